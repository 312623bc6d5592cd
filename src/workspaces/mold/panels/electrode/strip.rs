//! The strips over the view: how far electrodes are lifted out, the way of the selected one, and the cut through it.

use crate::workspaces::commands::{CommandSet, FrameCommand};
use crate::workspaces::context::Context;
use crate::workspaces::mold::commands::MoldCommand;
use crate::workspaces::mold::panels::desk::MoldDesk;
use egui::{Rect, RichText, Slider, Ui};

use super::desk::Fly;
use crate::widgets::panel_parts::row;
use crate::widgets::theme::palette;
use crate::workspaces::mold::scene::MoldLook;
use crate::workspaces::mold::scene::electrodes::{BurnCut, BurnPhase};

/// Greatest width of a strip (points).
const WIDTH: f32 = 560.0;
/// Width of a strip (points) below which its words are fewer.
const NARROW: f32 = 440.0;

/// Draws them, if electrodes are looked at.
pub fn show(ui: &mut Ui, rect: Rect, desk: &mut MoldDesk, cx: &mut Context) {
    if desk.electrodes.split.is_some() {
        return splitting(ui, rect, desk);
    }
    if desk.electrodes.seen().is_none() {
        return;
    }
    if desk.electrodes.is_playing {
        let seconds = f64::from(ui.input(|i| i.stable_dt.clamp(0.0, 0.1)));
        desk.electrodes.advance(seconds);
        ui.ctx().request_repaint();
    }
    row(ui, rect, (0, WIDTH), |ui| looks(ui, desk));
    if desk.electrodes.chosen().is_some() {
        row(ui, rect, (1, WIDTH), |ui| way(ui, desk, cx));
    }
    if desk.electrodes.cut.is_some() {
        row(ui, rect, (2, WIDTH), |ui| cut(ui, desk, cx));
    }
}

fn looks(ui: &mut Ui, desk: &mut MoldDesk) {
    let desk = &mut desk.electrodes;
    ui.label(RichText::new("Mold").color(palette(ui).faint));
    for look in MoldLook::ALL {
        ui.selectable_value(&mut desk.look, look, look.name());
    }
    let label = ui.label(RichText::new("Retracted").color(palette(ui).faint));
    ui.spacing_mut().slider_width = (ui.available_width() - 20.0).clamp(40.0, 240.0);
    let slider = ui.add(Slider::new(&mut desk.exploded, 0.0..=1.0).show_value(false)).labelled_by(label.id);
    if slider.changed() {
        desk.fly = Some(Fly::All);
    }
}

fn way(ui: &mut Ui, desk: &mut MoldDesk, cx: &mut Context) {
    // Where there is no room for all phases the present one is named alone: the figure must not be cut off.
    let is_narrow = ui.available_width() < NARROW;
    if is_narrow {
        ui.spacing_mut().item_spacing.x = 4.0;
    }
    let names = ["To the start", "Step back", "Step forward", "Burn position"];
    cx.play_buttons(ui, desk, (desk.electrodes.is_playing, 26.0), names, false);
    let desk = &mut desk.electrodes;
    let words = if is_narrow { 130.0 } else { 190.0 };
    ui.spacing_mut().slider_width = (ui.available_width() - words).clamp(50.0, 240.0);
    let mut time = desk.time.unwrap_or(2.0 / 3.0);
    let slider = ui.add(Slider::new(&mut time, 0.0..=1.0).show_value(false));
    ui.ctx().accesskit_node_builder(slider.id, |node| node.set_label("Motion of the electrode"));
    if slider.changed() {
        (desk.time, desk.is_playing) = (Some(time), false);
    }
    let (phase, height) = desk.moment().unwrap_or((BurnPhase::Burn, 0.0));
    for one in BurnPhase::ALL.into_iter().filter(|one| !is_narrow || *one == phase) {
        let colour = if one == phase { palette(ui).accent } else { palette(ui).faint };
        ui.label(RichText::new(one.name()).small().color(colour));
    }
    ui.label(RichText::new(format!("{height:.2} mm")).small().monospace()).on_hover_text("Above the burn position");
}

fn cut(ui: &mut Ui, desk: &mut MoldDesk, cx: &mut Context) {
    let bounds = desk.work.mold().map(|mold| mold.shape.bounds());
    let desk = &mut desk.electrodes;
    let Some(now) = desk.cut else { return };
    ui.label(RichText::new("Cut along").color(palette(ui).faint));
    for (name, along_y) in [("X", false), ("Y", true)] {
        if ui.selectable_label(now.along_y == along_y, name).clicked() {
            desk.look_onto(BurnCut { along_y, beside: 0.0 });
        }
    }
    let label = ui.label(RichText::new("beside").color(palette(ui).faint));
    let reach = bounds.map_or(10.0, |b| 0.25 * b.size().length());
    let mut beside = now.beside;
    ui.spacing_mut().slider_width = (ui.available_width() - 250.0).clamp(50.0, 200.0);
    let slider = Slider::new(&mut beside, -reach..=reach).suffix(" mm").max_decimals(2);
    if ui.add(slider).labelled_by(label.id).changed() {
        desk.cut = Some(BurnCut { beside, ..now });
    }
    let gap = desk.designed().zip(desk.chosen()).and_then(|(made, (e, _))| made.set.params.stages.get(e.stage));
    if let Some(stage) = gap {
        ui.label(RichText::new(format!("gap {} mm", stage.gap_mm)).color(palette(ui).accent));
    }
    if ui.button("Close").clicked() {
        cx.push(MoldCommand::Section);
    }
}

/// Instruction for drawing a line, or for picking a face.
fn splitting(ui: &mut Ui, rect: Rect, desk: &mut MoldDesk) {
    let first = desk.electrodes.split.flatten();
    row(ui, rect, (0, WIDTH), |ui| {
        let is_along_face = desk.electrodes.is_split_along_face;
        let text = match first {
            _ if is_along_face => "click on a steep face of the mold beside the part".to_owned(),
            None => "click on the mold where the line begins".to_owned(),
            Some(p) => format!("from {:.2}, {:.2}: click where the line ends", p.x, p.y),
        };
        let what = desk.electrodes.split_region.map_or("Split".to_owned(), |r| format!("Split region {}", r + 1));
        let along = if is_along_face { " along a face" } else { "" };
        let text = format!("{what}{along}: {text}");
        ui.label(text);
        if ui.button("Cancel split").on_hover_text(FrameCommand::Cancel.hint(ui.ctx())).clicked() {
            desk.electrodes.give_up_split();
        }
    });
}
