//! The table and plot of sets of electrodes below the sizes: hours of the wheel against the electrodes that it needs.

use egui::{RichText, Ui, Vec2b};
use egui_plot::{Plot, PlotPoints, Points};

use super::sizes::{around, search};
use crate::widgets::panel_parts::notice;
use crate::widgets::theme::palette;
use crate::workspaces::blisk::desk::BliskDesk;
use crate::workspaces::blisk::job::design::{DesignRow, mark_best};
use crate::workspaces::blisk::work::ElectrodeTable;

/// The search for sets: its button, its table, its plot.
pub fn show(ui: &mut Ui, desk: &mut BliskDesk) {
    ui.add_space(8.0);
    ui.strong("Sets of electrodes of the fewest hours");
    let hint =
        "Sizes, plans and finishes sets of 1, 2 and 3 parts, each certified, with their hours and residual stock";
    search(ui, desk, ElectrodeTable::Sets, ["Find sets", "Stop search"], hint);
    let (rows, failure) = desk.work.sets();
    let mut rows = rows.to_vec();
    // Rows of a search that goes on, or was stopped, are not marked yet.
    mark_best(&mut rows);
    if let Some(why) = failure {
        notice(ui, palette(ui).bad, &why);
    }
    if rows.is_empty() {
        return;
    }
    let is_current = desk.work.is_current(ElectrodeTable::Sets);
    if !is_current {
        notice(ui, palette(ui).warning, "These sets are out of date; find them again to take one.");
    }
    if let Some(row) = table(ui, desk, &rows, is_current) {
        let mut job = desk.document.params().clone();
        row.apply(&mut job);
        desk.edit("Take a set", job, false);
    }
    let unknown = rows.iter().find_map(|row| row.no_minutes.as_deref());
    if let Some(why) = unknown {
        notice(ui, palette(ui).warning, &format!("Hours are not known: {why}"));
    }
    plot(ui, &rows);
}

/// The rows; answers the one that is to be applied.
fn table(ui: &mut Ui, desk: &BliskDesk, rows: &[DesignRow], is_current: bool) -> Option<DesignRow> {
    let mut chosen = None;
    egui::Grid::new("sets").num_columns(6).min_col_width(0.0).spacing([8.0, 3.0]).striped(true).show(ui, |ui| {
        for head in ["Parts", "From", "Hours", "Needed", "Stock mm", ""] {
            ui.label(RichText::new(head).small().color(palette(ui).faint));
        }
        ui.end_row();
        for (i, row) in rows.iter().enumerate() {
            let cells = [
                row.stage_cell(|stage| stage.size.parts.to_string()),
                row.stage_cell(|stage| stage.size.enter.name().to_owned()),
                row.hours_cell(),
                row.needed_cell(),
                row.residual_cell(),
            ];
            let hint = hint(row);
            for cell in cells {
                let text = RichText::new(cell).monospace();
                ui.label(if row.is_best { text.strong() } else { text }).on_hover_text(&hint);
            }
            let is_applied = is_current && row.is_applied(desk.document.params());
            let button = egui::Button::new(if is_applied { "Taken" } else { "Take" }).small();
            let response = ui.add_enabled(is_current && !is_applied, button);
            let name = format!("Take set {}", i + 1);
            response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, is_current && !is_applied, &name));
            if response.on_hover_text(&hint).on_disabled_hover_text(&hint).clicked() {
                chosen = Some(row.clone());
            }
            ui.end_row();
        }
    });
    chosen
}

/// Note on a row beside its figures.
fn hint(row: &DesignRow) -> String {
    let is_best = if row.is_best { "; no other set betters it in hours, electrodes and residual stock" } else { "" };
    let breaks: String = row.breaks.iter().map(|why| format!("; {why}")).collect();
    format!("{}; certified {:.4} mm{is_best}{breaks}", row.words(), row.certified_mm)
}

/// Hours over electrodes, the best sets in the accent colour.
fn plot(ui: &mut Ui, rows: &[DesignRow]) {
    let c = palette(ui);
    let at = |row: &DesignRow| Some([row.needed? as f64, row.wheel?.mean / 60.0]);
    let points =
        |is_best: bool| -> Vec<[f64; 2]> { rows.iter().filter(|row| row.is_best == is_best).filter_map(at).collect() };
    let (best, others) = (points(true), points(false));
    let all = || best.iter().chain(&others);
    if all().next().is_none() {
        return;
    }
    let [x, y] = [0, 1].map(|k| around(all().map(|point| point[k])));
    ui.add_space(4.0);
    Plot::new("set plot")
        .height(150.0)
        .allow_drag(false)
        .allow_scroll(false)
        .allow_zoom(Vec2b::new(false, false))
        .allow_boxed_zoom(false)
        .show_background(false)
        .grid_color(c.faint.gamma_multiply(0.35))
        .x_axis_label("electrodes")
        .y_axis_label("hours")
        .show(ui, |plot| {
            plot.set_plot_bounds_x(x[0]..=x[1]);
            plot.set_plot_bounds_y(y[0]..=y[1]);
            plot.points(Points::new("others", PlotPoints::from(others)).radius(3.0).color(c.faint));
            plot.points(Points::new("best", PlotPoints::from(best)).radius(4.5).color(c.accent));
        });
}
