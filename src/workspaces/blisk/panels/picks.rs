//! Picking by hand in the step Channel: its buttons, and the list of picked points.

use egui::{CollapsingHeader, RichText, Ui, vec2};

use crate::widgets::panel_parts::notice;
use crate::widgets::theme::{color32, palette};
use crate::workspaces::blisk::commands::BliskCommand;
use crate::workspaces::blisk::desk::BliskDesk;
use crate::workspaces::blisk::desk::picks::Picked;
use crate::workspaces::blisk::document::stage::Stage;
use crate::workspaces::context::Context;
use task::State;

/// Whether they are needed, or in use: then they come before the form.
pub fn come_first(desk: &BliskDesk) -> bool {
    let is_picked = || Picked::ALL.into_iter().any(|of| !desk.picked(of).is_empty());
    is_refused(desk) || desk.picking().is_some() || is_picked()
}

fn is_refused(desk: &BliskDesk) -> bool {
    matches!(desk.work.state(Stage::Channel), State::Failed(_))
}

/// Draws them.
pub fn show(ui: &mut Ui, desk: &mut BliskDesk, cx: &mut Context) {
    if desk.work.part().is_none() {
        return;
    }
    // Where it is needed it is open, whatever it was before.
    let header = CollapsingHeader::new("Pick in the view").open(come_first(desk).then_some(true));
    header.show_unindented(ui, |ui| {
        if is_refused(desk) {
            let text = "What was not found can be told by points on the wheel.";
            ui.label(RichText::new(text).color(palette(ui).faint));
        }
        ui.horizontal_wrapped(|ui| {
            for of in Picked::ALL {
                let text = format!("Pick {}", of.name().to_lowercase());
                cx.button(ui, desk, BliskCommand::Pick(of), &text, desk.picking() == Some(of));
            }
        });
        Picked::ALL.into_iter().for_each(|of| points(ui, desk, of));
    });
}

/// The points of one surface, each with a button that removes it.
fn points(ui: &mut Ui, desk: &mut BliskDesk, of: Picked) {
    let points = desk.picked(of);
    if points.is_empty() {
        return;
    }
    ui.horizontal(|ui| {
        let (dot, _) = ui.allocate_exact_size(vec2(10.0, 14.0), egui::Sense::hover());
        ui.painter().circle_filled(dot.center(), 4.5, color32(of.colour()));
        let plural = if points.len() == 1 { "" } else { "s" };
        ui.label(format!("{}: {} point{plural}", of.name(), points.len()));
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            if ui.small_button("Clear").on_hover_text(format!("Remove all points: {}", of.name())).clicked() {
                desk.clear_picked(of);
            }
        });
    });
    for (i, p) in points.iter().enumerate() {
        ui.horizontal(|ui| {
            ui.add_space(16.0);
            let text = format!("{:9.3} {:9.3} {:9.3}", p.x, p.y, p.z);
            ui.label(RichText::new(text).monospace()).on_hover_text("x, y, z in the coordinates of the mesh (mm)");
            let name = format!("Remove point {} of {}", i + 1, of.name());
            let button = ui.small_button("\u{d7}");
            button.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, true, &name));
            if button.on_hover_text(name).clicked() {
                desk.remove_picked(of, i);
            }
        });
    }
    if of == Picked::Axis {
        match desk.picked_circle() {
            Some(Ok((circle, off))) => {
                let text = format!("circle of radius {:.3} mm, all points within {off:.3} mm", circle.radius);
                ui.label(RichText::new(text).small().color(palette(ui).good));
            }
            Some(Err(why)) => notice(ui, palette(ui).warning, why),
            None => {
                let text = format!("{} of {} points", points.len(), of.least());
                ui.label(RichText::new(text).small().color(palette(ui).faint));
            }
        }
    } else if points.len() < of.least() {
        ui.label(RichText::new("one more is needed").small().color(palette(ui).warning));
    }
}
