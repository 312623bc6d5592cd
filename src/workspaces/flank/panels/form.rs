//! The left panel: the surface, the cutter, how its path is planned, what must not be cut, and the machine.

use crate::workspaces::commands::{CommandSet, FrameCommand};
use crate::workspaces::context::Context;
use crate::workspaces::flank::commands::FlankCommand;
use crate::workspaces::flank::panels::desk::FlankDesk;
use egui::{ComboBox, ProgressBar, RichText, Ui, vec2};
use glam::DVec3;

use super::desk::Standing;
use super::source::CHOOSE_SIDE;
use super::{results, source};
use crate::widgets::form::Form;
use crate::widgets::panel_parts::section;
use crate::widgets::panel_parts::{notice, sentence};
use crate::widgets::theme::{palette, tick};
use crate::workspaces::flank::document::FlankDocument;
use crate::workspaces::flank::document::fields::FIELDS;
use crate::workspaces::flank::paths::FlankPath;
use files::direction_words;
use flank::cutter::FlankCutter;
use task::State;

/// Height of the line that says how the plan stands (points).
const ROW: f32 = 22.0;

/// Draws the panel, with the results if `with_results`. Returns the purpose of the path to ask for, if any.
pub fn show(ui: &mut Ui, desk: &mut FlankDesk, cx: &mut Context, with_results: bool) -> Option<FlankPath> {
    let mut asked = None;
    ui.add_space(2.0);
    plan(ui, desk, cx);
    if with_results {
        ui.horizontal(|ui| {
            ui.selectable_value(&mut desk.shows_figures, false, "Parameters");
            ui.selectable_value(&mut desk.shows_figures, true, "Results");
        });
    }
    if with_results && desk.shows_figures {
        results::show(ui, desk);
        return None;
    }
    let mut chosen = None;
    egui::ScrollArea::vertical().id_salt("flank form").auto_shrink([false, false]).show(ui, |ui| {
        let mut form = Form::new(&FIELDS, desk.document.params(), desk.document.problem());
        section(ui, "Surface", true, |ui| asked = source::show(ui, desk, &mut form));
        section(ui, "Cutter", true, |ui| {
            chosen = cutters(ui, desk, &form);
            form.section(ui, "Cutter");
        });
        section(ui, "Path", true, |ui| form.section(ui, "Path"));
        section(ui, "Walls", false, |ui| walls(ui, desk, &mut form));
        section(ui, "Checks", false, |ui| form.section(ui, "Checks"));
        section(ui, "Machine", false, |ui| machine(ui, desk, &mut form, cx));
        let answer = form.answer();
        match chosen {
            Some(Chosen::One(cutter)) => desk.take_cutter(cutter),
            Some(Chosen::Best) => {
                if let Err(why) = desk.compare_cutters() {
                    cx.error("The cutters are not compared", why);
                }
            }
            None => {}
        }
        if let Some(edit) = answer.edit {
            desk.edit(edit.params);
        }
        answer.said.into_iter().for_each(|said| cx.say_in_passing(said));
        asked = asked.or(answer.wanted.and_then(|key| path_of(&key)));
    });
    asked
}

/// Choice among the cutters of the list.
enum Chosen {
    /// A cutter of the list.
    One(FlankCutter),
    /// The best for the flank.
    Best,
}

/// The list of cutters.
fn cutters(ui: &mut Ui, desk: &FlankDesk, form: &Form<FlankDocument>) -> Option<Chosen> {
    let mut chosen = None;
    let now = &form.params().cutter;
    let text = if desk.cutters.contains(now) { now.words() } else { "other".to_owned() };
    ui.horizontal(|ui| {
        let combo = ComboBox::from_id_salt("flank cutters").selected_text(text).width(170.0).truncate();
        let shown = combo.show_ui(ui, |ui| {
            for cutter in &desk.cutters {
                if ui.selectable_label(cutter == now, cutter.words()).clicked() {
                    chosen = Some(Chosen::One(cutter.clone()));
                }
            }
        });
        shown.response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::ComboBox, true, "List of cutters"));
        let hint = "Plans with each cutter of the list, and shows the figures side by side";
        if ui.small_button("Best of the list").on_hover_text(hint).clicked() {
            chosen = Some(Chosen::Best);
        }
    });
    chosen
}

/// The button that plans, and what is being done.
fn plan(ui: &mut Ui, desk: &mut FlankDesk, cx: &mut Context) {
    let state = desk.state();
    ui.horizontal(|ui| {
        cx.button(ui, desk, FlankCommand::PlanFlank, "Plan", state != State::Ready);
        cx.button(ui, desk, FrameCommand::Export, "Export\u{2026}", false);
        tick(ui, &mut desk.follows, "update automatically").on_hover_text("After the first plan");
    });
    // Always as high: the fields below must not move away from the hand that drags them.
    ui.allocate_ui(vec2(ui.available_width(), ROW), |ui| {
        ui.set_min_height(ROW);
        ui.horizontal(|ui| standing(ui, desk, cx));
    });
}

/// Work under way, error or result, in one line.
fn standing(ui: &mut Ui, desk: &mut FlankDesk, cx: &mut Context) {
    let colours = palette(ui);
    let is_possible = desk.document.problem().is_none();
    if let Some(doing) = desk.work.doing().filter(|_| is_possible).cloned() {
        let bar = ui.add(ProgressBar::new(doing.fraction as f32).desired_width(110.0).desired_height(8.0));
        let percent = format!("{} {:.0} %", doing.stage, 100.0 * doing.fraction);
        bar.widget_info(|| egui::WidgetInfo::labeled(egui::Role::ProgressIndicator, true, &percent));
        if ui.small_button("Cancel").on_hover_text(FrameCommand::Cancel.hint(ui.ctx())).clicked() {
            cx.push(FrameCommand::Cancel);
        }
        ui.add(egui::Label::new(RichText::new(&doing.stage).color(palette(ui).faint)).truncate());
        return;
    }
    let (colour, text) = match (desk.why_not(), desk.standing()) {
        _ if desk.open_side().is_some() => (colours.accent, CHOOSE_SIDE.to_owned()),
        (Some(why), _) => (colours.bad, sentence(&why)),
        (None, Standing::Planned) => (colours.faint, "Planned".to_owned()),
        (None, Standing::Sketch) => (colours.accent, "Preview on a coarse grid, not yet planned".to_owned()),
        (None, Standing::Stale) => (colours.warning, "Out of date".to_owned()),
        (None, Standing::Nothing) => (colours.faint, "Not yet planned".to_owned()),
    };
    ui.add(egui::Label::new(RichText::new(&text).small().color(colour)).truncate()).on_hover_text(text);
}

/// Purpose of the path for the parameter under `key`.
fn path_of(key: &str) -> Option<FlankPath> {
    Some(match key {
        "source.file" => FlankPath::Mesh,
        "source.lower.file" => FlankPath::Lower,
        "source.upper.file" => FlankPath::Upper,
        "walls.file" => FlankPath::Walls,
        "milling.machine" => FlankPath::Machine,
        "milling.post" => FlankPath::Post,
        _ => return None,
    })
}

/// Walls that must not be cut.
fn walls(ui: &mut Ui, desk: &FlankDesk, form: &mut Form<FlankDocument>) {
    form.section(ui, "Walls");
    if let Some(why) = desk.work.walls_state(desk.document.params()).why_not() {
        notice(ui, palette(ui).bad, why);
    }
    for doubt in desk.work.walls(desk.document.params()).iter().flat_map(|walls| &walls.doubts) {
        notice(ui, palette(ui).warning, doubt);
    }
}

/// The machine, how the workpiece is clamped on it, and the program.
fn machine(ui: &mut Ui, desk: &FlankDesk, form: &mut Form<FlankDocument>, cx: &mut Context) {
    let before = form.params().milling.machine.clone();
    form.row_with(ui, "milling.machine", &desk.machines);
    let chosen = form.params().milling.machine.clone();
    if chosen != before {
        let mut forgotten = None;
        form.change(|params| {
            params.milling.machine = before;
            forgotten = params.milling.take_machine(&chosen);
        });
        forgotten.into_iter().for_each(|forgotten| cx.say_in_passing(forgotten));
    }
    if !chosen.is_empty() {
        clamping(ui, desk, form);
    }
    form.group(ui, "Program");
}

/// Position and clamping directions of the workpiece on the machine.
fn clamping(ui: &mut Ui, desk: &FlankDesk, form: &mut Form<FlankDocument>) {
    let of_machine = desk.workpiece_of_machine();
    let mut is_own = form.params().milling.workpiece.is_some();
    let hint = "Off: as in the machine's file";
    if tick(ui, &mut is_own, "clamped other than in the machine's file").on_hover_text(hint).changed() {
        form.change(|params| params.milling.workpiece = is_own.then(|| of_machine.cloned().unwrap_or_default()));
    }
    form.group(ui, "Clamping");
    if let (false, Some(place)) = (is_own, of_machine) {
        let DVec3 { x, y, z } = place.zero_mm;
        let [z_axis, x_axis] =
            [place.z_axis, place.x_axis].map(|axis| direction_words(&axis.to_array().to_vec().into()));
        let text = format!("zero at {x}, {y}, {z} mm; its Z along {z_axis} of the machine, its X along {x_axis}");
        ui.add(egui::Label::new(RichText::new(text).small().color(palette(ui).faint)).wrap());
    }
}
