//! The table and plot of sizes below the form of the electrode, and what the quick look found.

use crate::workspaces::blisk::desk::BliskDesk;
use egui::{Rangef, RichText, Ui, Vec2b};
use egui_plot::{AxisHints, GridInput, GridMark, Plot, PlotPoints, Points};

use crate::widgets::panel_parts::notice;
use crate::widgets::plot_parts::{legend, round_steps, round_text};
use crate::widgets::theme::palette;
use crate::workspaces::blisk::document::stage::Stage;
use crate::workspaces::blisk::job::sizing::{SizeRow, TOLERANCE_DEG};
use crate::workspaces::blisk::work::ElectrodeTable;
use task::State;

/// Width of a form in which columns may stand wide apart (points).
const ROOMY: f32 = 300.0;

/// Result of the preview of the electrode being tuned.
pub fn live(ui: &mut Ui, desk: &mut BliskDesk) {
    match (desk.work.look_state(), desk.work.looked()) {
        (State::Failed(why), _) => {
            notice(ui, palette(ui).warning, &format!("No preview of the extraction path: {why}"));
        }
        (_, Some(looked)) => {
            let out = looked.found.way.margin.is_some();
            let colour = if out { palette(ui).good } else { palette(ui).warning };
            let (sentence, took) = (&looked.sentence, looked.took.as_secs_f64());
            notice(ui, colour, &format!("Preview: {sentence} ({took:.2} s; not verified)"));
        }
        (State::Running, None) => notice(ui, palette(ui).faint, "Searching the extraction path…"),
        (State::Cancelled, None) => {
            notice(ui, palette(ui).faint, "The preview of the extraction path was cancelled.");
            if ui.button("Search again").clicked() {
                desk.work.resume_look();
            }
        }
        _ => {}
    }
}

/// Sizing: its button, its table, its plot.
pub fn show(ui: &mut Ui, desk: &mut BliskDesk) {
    ui.add_space(8.0);
    ui.strong("Thickest electrodes with an extraction path");
    let hint = "Finds the least reductions for 1, 2 and 3 parts, from either side of entry, each certified";
    search(ui, desk, ElectrodeTable::Sizes, ["Find sizes", "Stop sizing"], hint);
    let (rows, failure) = desk.work.sizes();
    let rows = rows.to_vec();
    if let Some(why) = failure {
        notice(ui, palette(ui).bad, &why);
    }
    if rows.is_empty() {
        return;
    }
    let current = desk.work.is_current(ElectrodeTable::Sizes);
    if !current {
        notice(ui, palette(ui).warning, "These sizes are out of date; find them again to take one.");
    }
    if let Some(row) = table(ui, desk, &rows, current) {
        apply(desk, &row);
    }
    plot(ui, &rows);
}

/// Buttons that begin and stop the search for a table, and its work while it goes on.
pub(super) fn search(ui: &mut Ui, desk: &mut BliskDesk, table: ElectrodeTable, [find, stop]: [&str; 2], hint: &str) {
    let searching = desk.work.searching(table);
    ui.horizontal(|ui| {
        if let Some(doing) = searching {
            if ui.button(stop).clicked() {
                desk.work.stop_search(table);
            }
            ui.label(RichText::new(doing).small().color(palette(ui).faint));
        } else {
            let ready = desk.work.state(Stage::Channel) == State::Ready;
            if ui.add_enabled(ready, egui::Button::new(find)).on_hover_text(hint).clicked() {
                desk.work.find(table);
            }
        }
    });
}

/// The rows; answers the one that is to be applied.
fn table(ui: &mut Ui, desk: &BliskDesk, rows: &[SizeRow], current: bool) -> Option<SizeRow> {
    let mut chosen = None;
    // The bar of a scrolled form, and the button of a narrow one, must have room.
    let gap = if ui.available_width() < ROOMY { 5.0 } else { 10.0 };
    let has_stages = rows.iter().any(|row| row.stage.is_some());
    egui::Grid::new("sizes")
        .num_columns(6 + usize::from(has_stages))
        .min_col_width(0.0)
        .spacing([gap, 3.0])
        .striped(true)
        .show(ui, |ui| {
            if has_stages {
                ui.label(RichText::new("Stage").small().color(palette(ui).faint));
            }
            for (head, unit) in
                [("Parts", ""), ("From", ""), ("Low", "deg"), ("High", "deg"), ("Thick", "mm"), ("", "")]
            {
                ui.label(RichText::new(format!("{head} {unit}").trim_end()).small().color(palette(ui).faint));
            }
            ui.end_row();
            for (i, row) in rows.iter().enumerate() {
                let [low, high] = [0, 1].map(|wall| span(row, wall));
                let hint = hint(row);
                let told = |response: egui::Response| drop(response.on_hover_text(&hint));
                if has_stages {
                    told(ui.label(row.stage.as_deref().unwrap_or_default()));
                }
                told(ui.label(RichText::new(row.parts.to_string()).monospace()));
                told(ui.label(RichText::new(row.enter.name()).monospace()));
                told(ui.label(RichText::new(low).monospace()));
                told(ui.label(RichText::new(high).monospace()));
                told(ui.label(RichText::new(format!("{:.3}", row.least_thickness_mm)).monospace()));
                let applied = current && row.is_applied(desk.document.params());
                let response = ui.add_enabled(
                    current && !applied,
                    egui::Button::new(if applied { "Taken" } else { "Take" }).small(),
                );
                let name = format!("Take size {}", i + 1);
                response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, current && !applied, &name));
                if response.on_hover_text(&hint).on_disabled_hover_text(&hint).clicked() {
                    chosen = Some(row.clone());
                }
                ui.end_row();
            }
        });
    chosen
}

/// The reduction of a wall, or the least and the greatest of the parts: a form is narrow.
fn span(row: &SizeRow, wall: usize) -> String {
    let of_parts = || row.reduction_deg.iter().map(|walls| walls[wall]);
    let (least, most) = (of_parts().fold(f64::INFINITY, f64::min), of_parts().fold(0.0, f64::max));
    if least == most { format!("{most:.3}") } else { format!("{least:.2}–{most:.2}") }
}

/// Note on a row beside its figures.
fn hint(row: &SizeRow) -> String {
    let limit = row.limit.as_ref().map(|limit| format!("; {}", limit.clause())).unwrap_or_default();
    let raised = match row.raised_deg {
        0.0 => String::new(),
        more => format!(", with {more:.2} deg more for the certificate"),
    };
    let stage = row.stage.as_ref().map(|stage| format!("{stage}: ")).unwrap_or_default();
    let parts = match &row.reduction_deg[..] {
        [_] => String::new(),
        _ => {
            let [low, high] = row.reduction_cells();
            format!("parts along the passage {low} and {high} deg; ")
        }
    };
    format!("{stage}{parts}certified {:.4} mm{limit}; found to {TOLERANCE_DEG} deg{raised}", row.certified_mm)
}

/// Puts a row's reductions, parts and side into the parameters, and the strategy that found them.
fn apply(desk: &mut BliskDesk, row: &SizeRow) {
    let mut job = desk.document.params().clone();
    row.apply(&mut job);
    desk.edit("Take a size", job, false);
}

/// Thickness over the greater reduction, a colour for each number of parts.
fn plot(ui: &mut Ui, rows: &[SizeRow]) {
    let c = palette(ui);
    let colours = [c.accent, c.good, c.warning];
    let mut parts: Vec<usize> = rows.iter().map(|r| r.parts).collect();
    parts.sort_unstable();
    parts.dedup();
    let series = parts.into_iter().enumerate().map(|(i, n)| {
        let of = rows.iter().filter(|r| r.parts == n);
        let at: Vec<[f64; 2]> = of.map(|r| [r.most_deg(), r.least_thickness_mm]).collect();
        (if n == 1 { "1 part".to_owned() } else { format!("{n} parts") }, colours[i % colours.len()], at)
    });
    let series: Vec<_> = series.collect();
    let all: Vec<[f64; 2]> = series.iter().flat_map(|(_, _, at)| at.iter().copied()).collect();
    let [x, y] = [0, 1].map(|k| around(all.iter().map(|p| p[k])));
    ui.add_space(4.0);
    // Over the plot it would hide points.
    legend(ui, series.iter().map(|(name, colour, _)| (*colour, name.as_str())));
    let axis = |axis: AxisHints<'static>, label: &str, room: Rangef| {
        axis.label(label).formatter(|mark, _| round_text(mark)).label_spacing(room)
    };
    Plot::new("size plot")
        .height(150.0)
        .allow_drag(false)
        .allow_scroll(false)
        .allow_zoom(Vec2b::new(false, false))
        .allow_boxed_zoom(false)
        .show_background(false)
        .grid_color(c.faint.gamma_multiply(0.35))
        .x_grid_spacer(few_steps)
        .y_grid_spacer(few_steps)
        .custom_x_axes(vec![axis(AxisHints::new_x(), "reduction (deg)", Rangef::new(30.0, 40.0))])
        .custom_y_axes(vec![axis(AxisHints::new_y(), "thickness (mm)", Rangef::new(14.0, 18.0)).min_thickness(36.0)])
        .show(ui, |plot| {
            plot.set_plot_bounds_x(x[0]..=x[1]);
            plot.set_plot_bounds_y(y[0]..=y[1]);
            for (name, colour, at) in series {
                plot.points(Points::new(name, PlotPoints::from(at)).radius(4.0).color(colour));
            }
        });
}

/// From the least to the greatest of `values` with room about them, also where there is but one.
pub(super) fn around(values: impl Iterator<Item = f64>) -> [f64; 2] {
    let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
    let room = (0.12 * (high - low)).max(0.02 * high.abs()).max(1e-3);
    [low - room, high + room]
}

/// Three to about seven lines at round values.
fn few_steps(input: GridInput) -> Vec<GridMark> {
    let marks = |count| round_steps(GridInput { bounds: input.bounds, base_step_size: input.base_step_size }, count);
    [3.0, 5.0, 8.0].into_iter().map(marks).find(|marks| marks.len() >= 3).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_axis_has_three_numbers_at_least() {
        for (low, high) in [(1.2, 1.35), (0.97, 2.03), (1.0, 1.0), (5.0, 5.004), (0.0, 10.0), (1.247, 1.302)] {
            let bounds = around([low, high].into_iter());
            let marks = few_steps(GridInput { bounds: (bounds[0], bounds[1]), base_step_size: 1.0 });
            assert!((3..=8).contains(&marks.len()), "{low} to {high}: {}", marks.len());
            assert!(marks.iter().all(|m| (bounds[0]..=bounds[1]).contains(&m.value)));
            let mut texts: Vec<String> = marks.into_iter().map(round_text).collect();
            texts.dedup();
            assert!(texts.len() >= 3, "{texts:?}");
        }
    }
}
