//! The parts of the form on how the workpiece is clamped and how the program is written.

use crate::workspaces::flank::panels::FlankDesk;
use egui::{ComboBox, RichText, Ui};
use glam::DVec3;

use super::fields::{self, Number};
use crate::widgets::panel_parts::file_name;
use crate::widgets::panel_parts::named;
use crate::widgets::theme::{palette, tick};
use crate::workspaces::flank::document::MillingSettings;
use crate::workspaces::flank::paths::FlankPath;
use flank::machine::milling_machine::Workpiece;
use nc::flank_program::{FlankNcSettings, TipControl, milling_posts};

/// Where the workpiece stands on the machine, and the directions in which it is clamped.
pub fn workpiece(ui: &mut Ui, desk: &FlankDesk, milling: &mut MillingSettings, wrong: &mut Option<String>) {
    if milling.machine.is_empty() {
        return;
    }
    let of_machine = desk.workpiece_of_machine();
    named(ui, "Clamped", |ui, _| {
        let mut is_own = milling.workpiece.is_some();
        let hint = "Off: as in the machine's file";
        if tick(ui, &mut is_own, "other than in the machine's file").on_hover_text(hint).changed() {
            milling.workpiece = is_own.then(|| of_machine.cloned().unwrap_or_default());
        }
    });
    match (&mut milling.workpiece, of_machine) {
        (Some(place), _) => own_place(ui, place, wrong),
        (None, Some(place)) => {
            let text = words(place);
            ui.add(egui::Label::new(RichText::new(text).small().color(palette(ui).faint)).wrap());
        }
        (None, None) => {}
    }
}

fn own_place(ui: &mut Ui, place: &mut Workpiece, wrong: &mut Option<String>) {
    let zero = Number { speed: 0.1, ..Number::mm("Zero", "The workpiece's zero in machine coordinates") };
    fields::point(ui, &mut place.zero_mm, "Zero at", zero, wrong);
    let hint = "The machine's direction along which the workpiece's Z points: \u{2212}Z if it is clamped upside down";
    fields::direction(ui, &mut place.z_axis, "Its Z along", hint, wrong);
    let hint = "The machine's direction along which the workpiece's X points; its share along Z is removed";
    fields::direction(ui, &mut place.x_axis, "Its X along", hint, wrong);
}

/// Where the workpiece stands, in a few words.
fn words(place: &Workpiece) -> String {
    let DVec3 { x, y, z } = place.zero_mm;
    let [z_axis, x_axis] = [place.z_axis, place.x_axis].map(fields::direction_words);
    format!("zero at {x}, {y}, {z} mm; its Z along {z_axis} of the machine, its X along {x_axis}")
}

/// The post, what X Y Z of the program mean, and the number of the tool. Answers what a path is wanted for.
pub fn program(ui: &mut Ui, milling: &mut MillingSettings, wrong: &mut Option<String>) -> Option<FlankPath> {
    let mut asked = None;
    named(ui, "Post", |ui, label| {
        let combo = ComboBox::from_id_salt("milling post").selected_text(file_name(&milling.post)).width(160.0);
        let shown = combo.show_ui(ui, |ui| {
            for name in milling_posts() {
                ui.selectable_value(&mut milling.post, name.to_owned(), name);
            }
            if ui.selectable_label(false, "Own file\u{2026}").clicked() {
                asked = Some(FlankPath::Post);
            }
        });
        shown.response.on_hover_text("The control for which the program is written").labelled_by(label);
    });
    let FlankNcSettings { tip_control, tool_number, .. } = &mut milling.program;
    named(ui, "X Y Z are", |ui, _| {
        ui.horizontal_wrapped(|ui| {
            ui.spacing_mut().item_spacing.x = 3.0;
            for (one, hint) in TipControl::ALL.into_iter().zip(TIP_HINTS) {
                let name = ["axes", "tip, angles", "tip, direction"][one as usize];
                ui.selectable_value(tip_control, one, name).on_hover_text(hint);
            }
        });
    });
    if *tip_control != TipControl::Off {
        let mut number = *tool_number as usize;
        let hint = "Number of the tool's length offset, written as H";
        fields::count(ui, &mut number, Number::count("Tool number", hint), wrong);
        *tool_number = u32::try_from(number).unwrap_or(u32::MAX);
    }
    asked
}

const TIP_HINTS: [&str; 3] = [
    "Positions of the machine's axes: the control needs no knowledge of the machine",
    "The tool's tip with the rotary axes (G43.4 on many controls): the post must have the word, as milling-tcp has",
    "The tool's tip with its direction (G43.5 on many controls): the post must have the word, as milling-tcp has",
];
