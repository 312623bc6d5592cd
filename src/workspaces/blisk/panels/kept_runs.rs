//! The plans that are kept beside the present one: their figures, with a button to remove each.

use egui::{Color32, RichText, Role, Ui, WidgetInfo};

use crate::widgets::theme::palette;
use crate::workspaces::blisk::desk::BliskDesk;
use crate::workspaces::blisk::desk::kept_runs::KeptRun;
use crate::workspaces::blisk::report::comparison::RunElectrode;
use feed::pose::Axis;

impl KeptRun {
    /// Colour of the run among those of the theme.
    pub fn colour(&self, ui: &Ui) -> Color32 {
        palette(ui).runs[self.colour]
    }
}

/// Draws the figures of the kept runs for the electrode that is looked at, with a button to remove each.
pub fn show(ui: &mut Ui, desk: &mut BliskDesk) {
    let (electrode, step) = (desk.cursor.electrode, desk.kept.step().unwrap_or(desk.document.params().plan.step_mm));
    let runs = desk.kept.all();
    let moves = |axis: &Axis| runs.iter().filter_map(|r| r.run.electrodes.get(electrode)).any(|e| e.withdrawn != *axis);
    let axes: Vec<Axis> = desk.document.params().machine.axes.axes().iter().copied().filter(moves).collect();
    let mut removed = None;
    let caption = format!(
        "Second differences over steps of {step:.2} mm, RMS and greatest; linear axes in mm, rotary axes in deg"
    );
    egui::ScrollArea::both().id_salt("comparison").auto_shrink([false, false]).show(ui, |ui| {
        ui.label(RichText::new(caption).small().color(palette(ui).faint));
        egui::Grid::new("kept runs").spacing([9.0, 3.0]).striped(true).show(ui, |ui| {
            heads(ui, &axes);
            for run in desk.kept.all() {
                if named(ui, run) {
                    removed = Some(run.number);
                }
                figures(ui, run.run.electrodes.get(electrode), &axes);
                ui.end_row();
            }
        });
        // They count towards the most that can be kept: one must be able to make room.
        for (number, name, reason) in desk.kept.absent() {
            ui.horizontal(|ui| {
                ui.add_space(20.0);
                ui.label(RichText::new(&name).color(palette(ui).faint));
                if remove_button(ui, &name) {
                    removed = Some(number);
                }
                ui.label(RichText::new(reason).small().color(palette(ui).warning));
            });
        }
    });
    if let Some(number) = removed {
        desk.kept.remove(number, &mut desk.document);
    }
}

fn heads(ui: &mut Ui, axes: &[Axis]) {
    let of_axis = |axis: &Axis| ["RMS", "max"].map(|what| format!("{} {what}", axis.letter()));
    let heads = ["run", "", "certified mm", "search s"].map(str::to_owned);
    for head in heads.into_iter().chain(axes.iter().flat_map(of_axis)) {
        ui.label(RichText::new(head).small().color(palette(ui).faint));
    }
    ui.end_row();
}

/// The cells that name a run and remove it. Returns whether it is to be removed.
fn named(ui: &mut Ui, run: &KeptRun) -> bool {
    let colour = run.colour(ui);
    ui.horizontal(|ui| {
        let (rect, _) = ui.allocate_exact_size(egui::vec2(12.0, 14.0), egui::Sense::hover());
        ui.painter().hline(rect.x_range(), rect.center().y, egui::Stroke::new(2.0, colour));
        ui.label(run.name());
    });
    remove_button(ui, &run.name())
}

/// A button that removes the run called `name`. Returns whether it is pressed.
fn remove_button(ui: &mut Ui, name: &str) -> bool {
    let response = ui.add(egui::Button::new("×").small()).on_hover_text("Remove it from the comparison");
    let name = format!("Remove {name}");
    response.widget_info(|| WidgetInfo::labeled(Role::Button, true, &name));
    response.clicked()
}

/// The cells with the figures of one run.
fn figures(ui: &mut Ui, found: Option<&RunElectrode>, axes: &[Axis]) {
    let number = |ui: &mut Ui, value: Option<f64>, decimals: usize| {
        let text = value.map_or("\u{2013}".to_owned(), |v| format!("{v:.decimals$}"));
        ui.label(RichText::new(text).monospace());
    };
    number(ui, found.filter(|e| e.certified).and_then(|e| e.certified_clearance_mm), 4);
    // A plan that was opened was not searched.
    number(ui, found.map(|e| e.search_seconds).filter(|seconds| *seconds > 0.0), 2);
    // Three digits that count are enough to compare.
    let difference = |ui: &mut Ui, value: Option<f64>| {
        let decimals = value.map_or(3.0, |v| (2.0 - v.abs().max(1e-6).log10().floor()).clamp(2.0, 6.0));
        number(ui, value, decimals as usize);
    };
    for axis in axes {
        let smooth = found.and_then(|e| e.smoothness.iter().find(|a| a.axis == axis.letter()));
        difference(ui, smooth.map(|a| a.rms_second_difference));
        difference(ui, smooth.map(|a| a.max_second_difference));
    }
}
