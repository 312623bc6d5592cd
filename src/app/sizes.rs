//! The table and plot of sizes below the form of the electrode, and what the quick look found.

use egui::{RichText, Ui};
use egui_plot::{Plot, PlotPoints, Points};

use super::core::Core;
use super::stepper::notice;
use super::theme::palette;
use crate::jobs::pipeline::StageState;
use crate::jobs::sizing::SizeRow;
use crate::project::{PlanJob, Stage};

/// What a quick look says of the electrode as it is tuned.
pub fn live(ui: &mut Ui, core: &Core) {
    if let Some(why) = core.tuning.blind() {
        notice(ui, palette(ui).warning, &format!("No look for a way out: {why}"));
    } else if core.tuning.is_looking() {
        notice(ui, palette(ui).faint, "Looking for a way out…");
    } else if let Some((sentence, took)) = core.tuning.sentence() {
        let out = core.tuning.way().is_some_and(|(_, way)| way.way.width.is_some());
        let colour = if out { palette(ui).good } else { palette(ui).warning };
        notice(ui, colour, &format!("At a glance: {sentence} ({:.2} s; not verified)", took.as_secs_f64()));
    }
}

/// Sizing: its button, its table, its plot.
pub fn show(ui: &mut Ui, core: &mut Core) {
    ui.add_space(8.0);
    ui.strong("Thickest electrodes that come out");
    let sizing = core.tuning.sizing().map(str::to_owned);
    ui.horizontal(|ui| {
        if let Some(doing) = &sizing {
            if ui.button("Stop sizing").clicked() {
                core.tuning.stop_sizing();
            }
            ui.label(RichText::new(doing).small().color(palette(ui).faint));
        } else {
            let hint = "Finds the least reductions for 1, 2 and 3 parts on either side, each with a certificate";
            let ready = core.pipeline.state(Stage::Channel) == StageState::Done;
            if ui.add_enabled(ready, egui::Button::new("Find sizes")).on_hover_text(hint).clicked() {
                core.find_sizes();
            }
        }
    });
    let (rows, failure) = core.tuning.sizes();
    let (rows, failure) = (rows.to_vec(), failure.map(str::to_owned));
    if let Some(why) = failure {
        notice(ui, palette(ui).bad, &why);
    }
    if rows.is_empty() {
        return;
    }
    let current = core.tuning.sizes_are_of(core.pipeline.of_size());
    if !current {
        notice(ui, palette(ui).warning, "These sizes are of other parameters; find them again to take one.");
    }
    if let Some(row) = table(ui, core, &rows, current) {
        apply(core, &row);
    }
    plot(ui, &rows);
}

/// The rows; answers the one that is to be applied.
fn table(ui: &mut Ui, core: &Core, rows: &[SizeRow], current: bool) -> Option<SizeRow> {
    let mut chosen = None;
    egui::Grid::new("sizes").num_columns(6).spacing([10.0, 3.0]).striped(true).show(ui, |ui| {
        for (head, unit) in [("Parts", ""), ("From", ""), ("Low", "deg"), ("High", "deg"), ("Thick", "mm"), ("", "")] {
            ui.label(RichText::new(format!("{head} {unit}")).small().color(palette(ui).faint));
        }
        ui.end_row();
        for (i, row) in rows.iter().enumerate() {
            let [low, high] = row.reduction_deg;
            ui.label(RichText::new(row.parts.to_string()).monospace());
            ui.label(RichText::new(row.enter.name()).monospace());
            ui.label(RichText::new(format!("{low:.3}")).monospace());
            ui.label(RichText::new(format!("{high:.3}")).monospace());
            ui.label(RichText::new(format!("{:.3}", row.least_thickness_mm)).monospace());
            let applied = current && is_applied(core.document.job(), row);
            let response =
                ui.add_enabled(current && !applied, egui::Button::new(if applied { "Taken" } else { "Take" }).small());
            let name = format!("Take size {}", i + 1);
            response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, current && !applied, &name));
            if response.on_hover_text(format!("certified {:.4} mm", row.certified_mm)).clicked() {
                chosen = Some(row.clone());
            }
            ui.end_row();
        }
    });
    chosen
}

fn is_applied(job: &PlanJob, row: &SizeRow) -> bool {
    let e = &job.electrode;
    let given = e.size == crate::blisk::electrode::Sizing::Given;
    given && e.parts == row.parts && e.enter == row.enter && e.circumferential_reduction_deg == row.reduction_deg
}

/// Puts a row's reductions, parts and side into the parameters, and the strategy that found them.
fn apply(core: &mut Core, row: &SizeRow) {
    let mut job = core.document.job().clone();
    job.electrode.parts = row.parts;
    job.electrode.enter = row.enter;
    job.electrode.size = crate::blisk::electrode::Sizing::Given;
    job.electrode.circumferential_reduction_deg = row.reduction_deg;
    job.plan.strategy = crate::feed::search::Strategy::Global;
    core.edit("Take a size", job, false);
}

/// Thickness over the greater reduction, a colour for each number of parts.
fn plot(ui: &mut Ui, rows: &[SizeRow]) {
    let c = palette(ui);
    let colours = [c.accent, c.good, c.warning];
    ui.add_space(4.0);
    let axes = |p: Plot<'static>| p.x_axis_label("reduction (deg)").y_axis_label("thickness (mm)");
    let plot = axes(Plot::new("size plot")).height(140.0).allow_scroll(false).legend(egui_plot::Legend::default());
    plot.show(ui, |plot| {
        let mut parts: Vec<usize> = rows.iter().map(|r| r.parts).collect();
        parts.dedup();
        for (i, n) in parts.into_iter().enumerate() {
            let of = rows.iter().filter(|r| r.parts == n);
            let at: Vec<[f64; 2]> =
                of.map(|r| [r.reduction_deg.into_iter().fold(0.0, f64::max), r.least_thickness_mm]).collect();
            let name = if n == 1 { "1 part".to_owned() } else { format!("{n} parts") };
            plot.points(Points::new(name, PlotPoints::from(at)).radius(4.0).color(colours[i % colours.len()]));
        }
    });
}
