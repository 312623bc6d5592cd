//! Plans that the user keeps beside the present one: their figures and the curves of their axes.

use std::sync::Arc;

use egui::{Color32, RichText, Role, Ui, WidgetInfo};

use super::core::Core;
use super::theme::palette;
use crate::export::comparison::{AxisCourse, Run, RunElectrode};
use crate::export::report::Smoothness;
use crate::feed::pose::Axis;
use crate::feed::smoothness::axis_smoothness;
use crate::jobs::compare::run_of;
use crate::jobs::plan::PlanOutcome;
use crate::project::PlanJob;

/// The runs that are kept.
#[derive(Default)]
pub struct KeptRuns {
    runs: Vec<KeptRun>,
    /// Runs kept so far, removed ones counted too.
    kept: usize,
    /// Step that differences of all of them are taken over, that of the first (mm).
    step: f64,
}

/// A run that is kept.
pub struct KeptRun {
    /// Counted from 1.
    number: usize,
    /// Which of the theme's colours it has.
    colour: usize,
    run: Run,
    /// Digests of its paths.
    paths: Vec<String>,
}

impl KeptRun {
    /// Its name: its number and strategy.
    pub fn name(&self) -> String {
        format!("{} {}", self.number, self.run.strategy.name())
    }

    /// Its colour among those of the theme.
    pub fn colour(&self, ui: &Ui) -> Color32 {
        palette(ui).runs[self.colour]
    }

    /// How `axis` of electrode number `electrode` from 0 moves.
    pub fn course(&self, electrode: usize, axis: Axis) -> Option<&AxisCourse> {
        self.run.electrodes.get(electrode)?.course(axis.letter())
    }
}

impl KeptRuns {
    /// Most runs that are kept.
    pub const MOST: usize = 6;

    /// Those that are kept, in the order of keeping.
    pub fn all(&self) -> &[KeptRun] {
        &self.runs
    }

    /// Whether one more can be kept, and `plan` is not kept already.
    pub fn can_keep(&self, plan: &PlanOutcome) -> bool {
        self.runs.len() < Self::MOST
            && !self.runs.iter().any(|run| run.paths.iter().map(String::as_str).eq(paths(plan)))
    }

    /// Keeps `plan`, which was made by `job`. Answers its name.
    pub fn keep(&mut self, plan: &Arc<PlanOutcome>, job: &PlanJob) -> String {
        if self.runs.is_empty() {
            self.step = job.plan.step_mm;
        }
        let mut run = run_of(job.plan.strategy, plan);
        // Differences over other steps could not be compared.
        for (kept, electrode) in run.electrodes.iter_mut().zip(&plan.electrodes) {
            let Some(planned) = &electrode.plan.path else { continue };
            let figures = Axis::ALL.map(|axis| axis_smoothness(&planned.curves, axis, self.step));
            kept.smoothness = Smoothness::of(&figures);
        }
        self.kept += 1;
        let is_free = |colour: &usize| self.runs.iter().all(|run| run.colour != *colour);
        let colour = (0..Self::MOST).find(is_free).unwrap_or(0);
        let kept = KeptRun { number: self.kept, colour, run, paths: paths(plan).map(str::to_owned).collect() };
        let name = kept.name();
        self.runs.push(kept);
        name
    }

    fn remove(&mut self, number: usize) {
        self.runs.retain(|run| run.number != number);
    }
}

/// Digests of the paths of `plan`.
fn paths(plan: &PlanOutcome) -> impl Iterator<Item = &str> {
    plan.electrodes.iter().filter_map(|e| Some(e.plan.path.as_ref()?.certificate.path_digest()))
}

/// Draws the figures of the kept runs for the electrode that is looked at, with a button to remove each.
pub fn show(ui: &mut Ui, core: &mut Core) {
    let axes: Vec<Axis> = core.document.job().machine.axes.axes().iter().copied().filter(|a| *a != Axis::X).collect();
    let (electrode, step) = (core.cursor.electrode, core.kept.step);
    let mut removed = None;
    let caption = format!("Second differences over steps of {step:.2} mm: root mean square and greatest");
    egui::ScrollArea::both().id_salt("comparison").auto_shrink([false, false]).show(ui, |ui| {
        ui.label(RichText::new(caption).small().color(palette(ui).faint));
        egui::Grid::new("kept runs").spacing([14.0, 3.0]).striped(true).show(ui, |ui| {
            heads(ui, &axes);
            for run in core.kept.all() {
                if named(ui, run) {
                    removed = Some(run.number);
                }
                figures(ui, run.run.electrodes.get(electrode), &axes);
                ui.end_row();
            }
        });
    });
    if let Some(number) = removed {
        core.kept.remove(number);
    }
}

fn heads(ui: &mut Ui, axes: &[Axis]) {
    let unit = |axis: &Axis| if axis.is_rotary() { "deg" } else { "mm" };
    let of_axis = |axis: &Axis| ["RMS", "max"].map(|what| format!("{} {what} {}", axis.letter(), unit(axis)));
    let heads = ["run", "", "certified mm", "search s"].map(str::to_owned);
    for head in heads.into_iter().chain(axes.iter().flat_map(of_axis)) {
        ui.label(RichText::new(head).small().color(palette(ui).faint));
    }
    ui.end_row();
}

/// The cells that name a run and remove it. Tells whether it is to be removed.
fn named(ui: &mut Ui, run: &KeptRun) -> bool {
    let colour = run.colour(ui);
    ui.horizontal(|ui| {
        let (rect, _) = ui.allocate_exact_size(egui::vec2(12.0, 14.0), egui::Sense::hover());
        ui.painter().hline(rect.x_range(), rect.center().y, egui::Stroke::new(2.0, colour));
        ui.label(run.name());
    });
    let response = ui.add(egui::Button::new("Remove").small());
    let name = format!("Remove {}", run.name());
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
    for axis in axes {
        let smooth = found.and_then(|e| e.smoothness.iter().find(|a| a.axis == axis.letter()));
        number(ui, smooth.map(|a| a.rms_second_difference), 5);
        number(ui, smooth.map(|a| a.max_second_difference), 5);
    }
}
