//! The left panel: the mold, its cutters, what they leave, and what others would leave.

use crate::workspaces::commands::{CommandSet, FrameCommand};
use crate::workspaces::context::Context;
use crate::workspaces::mold::commands::MoldCommand;
use crate::workspaces::mold::panels::desk::MoldDesk;
use egui::{ProgressBar, RichText, TextEdit, Ui, vec2};
use files::Validate as _;

use super::datum_pick::DatumPick;
use super::{compare, cutters, electrode, list};
use crate::widgets::form::Form;
use crate::widgets::panel_parts::grouped;
use crate::widgets::panel_parts::section;
use crate::widgets::panel_parts::{fact, notice};
use crate::widgets::solids::solids;
use crate::widgets::theme::{palette, tick};
use crate::workspaces::mold::document::MoldParams;
use crate::workspaces::mold::document::cutter_file::standard_cutters;
use crate::workspaces::mold::document::fields::FIELDS;
use crate::workspaces::mold::paths::MoldPath;
use crate::workspaces::mold::work::FoundUncut;
use crate::workspaces::news::EventKind;
use files::Params;
use mold::datum::Datum;
use mold::opening::Opening;
use mold::unseen::OpeningProposal;
use task::State;

/// Height of the list of regions where it has no panel of its own (points).
const LIST: f32 = 420.0;
/// Width of the bar that scrolls, with room beside it (points).
const BAR: f32 = 6.0;

/// Draws the panel, `with_list` also the list of regions. Returns the path that the user is to choose.
pub fn show(ui: &mut Ui, desk: &mut MoldDesk, cx: &mut Context, with_list: bool) -> Option<MoldPath> {
    let mut asked = None;
    egui::ScrollArea::vertical().id_salt("mold form").auto_shrink([false, false]).show(ui, |ui| {
        ui.add_space(2.0);
        // Nothing ends below the bar.
        ui.set_max_width(ui.available_width() - BAR);
        section(ui, "Mold", true, |ui| asked = mold(ui, desk, cx));
        section(ui, "Work datum", false, |ui| datum(ui, desk, cx));
        section(ui, "Cutters", true, |ui| asked = library(ui, desk, cx).or(asked.take()));
        section(ui, "Uncut", true, |ui| uncut(ui, desk, cx));
        section(ui, "Electrodes", false, |ui| asked = electrode::form(ui, desk, cx).or(asked.take()));
        if with_list {
            section(ui, "List", true, |ui| {
                ui.allocate_ui(vec2(ui.available_width(), LIST), |ui| list::lists(ui, desk, cx));
            });
        }
        section(ui, "Compare cutters", false, |ui| asked = compare::show(ui, desk, cx).or(asked.take()));
    });
    asked
}

fn mold(ui: &mut Ui, desk: &mut MoldDesk, cx: &mut Context) -> Option<MoldPath> {
    let mut asked = None;
    let state = desk.work.mold_state(desk.document.params());
    ui.horizontal(|ui| {
        if ui.button("Open mold…").on_hover_text(FrameCommand::Open.hint(ui.ctx())).clicked() {
            asked = Some(MoldPath::Open);
        }
        match &desk.document.params().mesh {
            None => drop(ui.label(RichText::new("or drop a mesh here").color(palette(ui).faint))),
            Some(_) => drop(ui.add(egui::Label::new(RichText::new(desk.document.params().name()).strong()).truncate())),
        }
    });
    if let Some(why) = state.why_not() {
        notice(ui, palette(ui).bad, why);
    }
    let mut form = Form::new(&FIELDS, desk.document.params(), desk.document.problem());
    form.row(ui, "units");
    if let Some(report) = desk.work.mold().map(|mold| &mold.report).filter(|r| r.step_tolerance_mm.is_some()) {
        form.row(ui, "step_tolerance_mm");
        if let Some(chosen) = solids(ui, &report.solids) {
            form.change(|params| (params.solids, params.obstacles) = (chosen.part, chosen.obstacles));
        }
    }
    let proposal = desk.work.survey(desk.document.params()).map(|found| found.proposal);
    opening(ui, &mut form, proposal);
    if desk.work.is_surveying() {
        ui.label(RichText::new("The direction that hides least is being looked for.").small().color(palette(ui).faint));
    }
    form.row(ui, "tolerance_mm");
    desk.take(form.answer(), cx);
    facts(ui, desk, cx);
    asked
}

/// The opening direction: along an axis, a typed vector, or the one that is proposed, with the reason.
fn opening(ui: &mut Ui, form: &mut Form<MoldParams>, proposal: Option<OpeningProposal>) {
    let now = form.params().opening;
    let mut chosen = now;
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 2.0;
        ui.label("Opening direction").on_hover_text("The cutters come from this side.");
        for axis in Opening::AXES {
            if ui.selectable_label(now == Some(axis), axis.name()).clicked() {
                chosen = Some(axis);
            }
        }
    });
    ui.horizontal(|ui| {
        let own = now.filter(|opening| !Opening::AXES.contains(opening)).map_or_else(String::new, Opening::name);
        let id = ui.make_persistent_id("opening vector");
        let mut text = ui.data_mut(|d| d.get_temp(id)).unwrap_or(own);
        let is_wrong = !text.trim().is_empty() && text.parse::<Opening>().is_err();
        let colour = is_wrong.then_some(palette(ui).bad);
        let edit = TextEdit::singleline(&mut text).hint_text("or x, y, z").desired_width(128.0).text_color_opt(colour);
        let edit = ui.add(edit).on_hover_text("Three numbers, as in 0, 0.5, 1");
        ui.ctx().accesskit_node_builder(edit.id, |node| node.set_label("Opening vector"));
        if edit.has_focus() {
            ui.data_mut(|d| d.insert_temp(id, text));
        } else {
            ui.data_mut(|d| d.remove::<String>(id));
            chosen = text.parse().ok().filter(|_| edit.lost_focus()).or(chosen);
        }
        let other = proposal.filter(|proposal| Some(proposal.opening) != now);
        if ui.add_enabled(other.is_some(), egui::Button::new("As proposed")).clicked() {
            chosen = other.map(|proposal| proposal.opening).or(chosen);
        }
    });
    if let Some(proposal) = proposal {
        let text = format!("Proposed {}", proposal.sentence().replace("mm2", "mm²"));
        ui.add(egui::Label::new(RichText::new(text).small().color(palette(ui).faint)).wrap());
    }
    if chosen != now {
        form.change(|params| params.opening = chosen);
    }
}

/// The work datum: typed, or picked on the part.
fn datum(ui: &mut Ui, desk: &mut MoldDesk, cx: &mut Context) {
    let mut form = Form::new(&FIELDS, desk.document.params(), desk.document.problem());
    for key in ["datum.origin_mm", "datum.angle_deg", "datum.name"] {
        form.row(ui, key);
    }
    let is_loaded = desk.work.mold().is_some();
    ui.horizontal_wrapped(|ui| {
        for (name, hint, pick) in [
            ("Corner", "Click on a corner of the mold", DatumPick::Corner),
            ("Between faces", "The middle between two parallel faces, across them", DatumPick::Faces(None)),
            ("Hole", "The centre of a hole, at the rim that is clicked on", DatumPick::Hole),
            (
                "X direction",
                "The X axis along an edge, from the first of two corners to the second",
                DatumPick::XAxis(None),
            ),
        ] {
            let is_on = desk.pick.is_some_and(|now| std::mem::discriminant(&now) == std::mem::discriminant(&pick));
            if ui.add_enabled(is_loaded, egui::Button::selectable(is_on, name)).on_hover_text(hint).clicked() {
                desk.pick_datum(pick);
            }
        }
        if ui.button("Reset").on_hover_text("Origin and axes of the mold's file").clicked() {
            form.change(|params| params.datum = Datum::default());
        }
    });
    let text = "Positions of burns refer to it. Z is the opening direction.";
    ui.label(RichText::new(text).small().color(palette(ui).faint));
    desk.take(form.answer(), cx);
}

fn facts(ui: &mut Ui, desk: &MoldDesk, cx: &mut Context) {
    let Some(mold) = desk.work.mold() else { return };
    let length = cx.preferences.length;
    let size = mold.shape.bounds().size();
    fact(ui, "Size", format!("{:.2} × {:.2} × {}", size.x, size.y, length.show(size.z, 2)));
    fact(ui, "Volume", format!("{:.1} mm³", mold.volume));
    fact(ui, "Triangles", grouped(mold.mesh.triangles.len()));
    let surface = if mold.report.watertight { "watertight" } else { "open" };
    fact(ui, "Surface", format!("{surface}, read in {}", mold.report.unit.name()));
    if !mold.report.unit_certain {
        let text = RichText::new(&mold.report.unit_reason).small().color(palette(ui).faint);
        ui.add(egui::Label::new(text).wrap());
    }
    for warning in &mold.report.warnings {
        notice(ui, palette(ui).warning, warning);
    }
}

fn library(ui: &mut Ui, desk: &mut MoldDesk, cx: &mut Context) -> Option<MoldPath> {
    let mut asked = None;
    let mut form = Form::new(&FIELDS, desk.document.params(), desk.document.problem());
    cutters::table(ui, &mut form, "library.cutter");
    ui.horizontal_wrapped(|ui| {
        if ui.button("Load…").on_hover_text("A library of cutters (TOML)").clicked() {
            asked = Some(MoldPath::Cutters);
        }
        let can_save = form.params().library.validate().is_ok();
        if ui.add_enabled(can_save, egui::Button::new("Save…")).on_hover_text("As a TOML file").clicked() {
            asked = Some(MoldPath::SaveCutters);
        }
        if ui.button("Standard").on_hover_text("The built-in library").clicked() {
            match standard_cutters() {
                Ok(library) => form.change(|params| params.library = library),
                Err(error) => cx.say(EventKind::Failed, error.to_string()),
            }
        }
    });
    desk.take(form.answer(), cx);
    asked
}

fn uncut(ui: &mut Ui, desk: &mut MoldDesk, cx: &mut Context) {
    let state = desk.state();
    ui.horizontal(|ui| {
        cx.button(ui, desk, MoldCommand::FindUncut, "Find rest material", state != State::Ready);
        let is_next = state == State::Ready && !desk.is_designed();
        cx.button(ui, desk, MoldCommand::DesignElectrodes, "Create electrodes", is_next);
    });
    ui.horizontal(|ui| {
        let hint = "Recomputes rest material and electrodes after each change";
        tick(ui, &mut desk.follows, "update automatically").on_hover_text(hint);
        cx.button(ui, desk, MoldCommand::ExportUncut, "Export rest\u{2026}", false);
    });
    if let Some(doing) = desk.work.doing().cloned() {
        ui.horizontal(|ui| {
            let bar = ui.add(ProgressBar::new(doing.fraction as f32).desired_width(150.0).desired_height(8.0));
            let percent = format!("{} {:.0} %", doing.stage, 100.0 * doing.fraction);
            bar.widget_info(|| egui::WidgetInfo::labeled(egui::Role::ProgressIndicator, true, &percent));
            if ui.small_button("Cancel").on_hover_text(FrameCommand::Cancel.hint(ui.ctx())).clicked() {
                cx.push(FrameCommand::Cancel);
            }
            // Last, as it takes what is left of the row: a panel grows with what does not fit, and stays so.
            ui.add(egui::Label::new(RichText::new(&doing.stage).color(palette(ui).faint)).truncate());
        });
    }
    if let Some(why) = state.why_not() {
        notice(ui, palette(ui).bad, why);
    }
    if let Some(found) = desk.found().cloned() {
        answer(ui, desk, &found);
    }
}

/// The result in words and figures.
fn answer(ui: &mut Ui, desk: &mut MoldDesk, found: &FoundUncut) {
    let report = &found.report;
    let colours = palette(ui);
    let colour = match (report.is_whole, report.regions.is_empty()) {
        (false, _) => colours.warning,
        (true, true) => colours.good,
        (true, false) => colours.accent,
    };
    match desk.found_of_others() {
        Some(others) => notice(ui, colours.warning, &format!("{others}: {}", found.sentence())),
        None => notice(ui, colour, &found.sentence()),
    }
    ui.scope(|ui| {
        list::dim(ui, desk);
        figures(ui, found);
    });
    if report.invert.faces > 0 {
        tick(
            ui,
            &mut desk.shows_invert,
            format!("{} undercut faces ({:.1} mm²), not reachable", report.invert.faces, report.invert.area_mm2),
        )
        .on_hover_text("They need another set-up or a slide, and have their own colour.");
    }
}

/// Notes on a result, and the agreement of the two methods.
fn figures(ui: &mut Ui, found: &FoundUncut) {
    let (report, colours) = (&found.report, palette(ui));
    for warning in &report.warnings {
        notice(ui, colours.warning, warning);
    }
    if let Some(agreement) = &report.agreement {
        let [layers, field] = [&agreement.layers, &agreement.field];
        let hint = "Flat cutters: exact layers compared with the height map";
        ui.label(RichText::new("Rest material of the flat cutters, computed twice").small().color(colours.faint))
            .on_hover_text(hint);
        let figures = |found: &crate::workspaces::mold::job::uncut::Found| {
            let plural = if found.regions == 1 { "" } else { "s" };
            format!("{} region{plural}, {:.3} mm³", found.regions, found.volume_mm3)
        };
        fact(ui, "By layers", figures(layers));
        fact(ui, &format!("Height map, step {} mm", (1e4 * agreement.field_step_mm).round() / 1e4), figures(field));
    }
    if let Some(agreement) = &report.ball_agreement {
        let hint = "Height map compared with an exact search for the rolling ball";
        let text = format!("Rest material of the ball cutters, computed twice at {} points", agreement.places);
        ui.label(RichText::new(text).small().color(colours.faint)).on_hover_text(hint);
        fact(ui, "Half of them within", format!("{:.4} mm", agreement.median_mm));
        fact(ui, "Nine of ten within", format!("{:.4} mm", agreement.ninetieth_mm));
    }
}
