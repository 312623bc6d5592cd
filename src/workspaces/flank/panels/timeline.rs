//! The timeline: the locations of the path from its start to its end, where the cutter stands, and how it is played.

use crate::workspaces::commands::{CommandSet, Commanded, FrameCommand};
use crate::workspaces::context::Context;
use crate::workspaces::flank::panels::desk::FlankDesk;
use egui::{Align2, FontId, Key, RichText, Role, Sense, Ui, WidgetInfo, pos2, vec2};

use crate::widgets::theme::palette;
use crate::workspaces::flank::scene::contact_line;

/// Draws it, `with_handle` that opens the plots below where they have no room of their own.
pub fn show(ui: &mut Ui, desk: &mut FlankDesk, cx: &mut Context, with_handle: bool) {
    ui.horizontal(|ui| {
        controls(ui, desk, cx);
        if with_handle {
            let sign = if desk.shows_plots { "Plots \u{23f7}" } else { "Plots \u{23f6}" };
            let hint = "Show the plots in place of a part of the view, or hide them";
            let response = ui.selectable_label(desk.shows_plots, sign).on_hover_text(hint);
            response.widget_info(|| WidgetInfo::selected(Role::Button, true, desk.shows_plots, "Plots"));
            if response.clicked() {
                desk.shows_plots = !desk.shows_plots;
            }
        }
        readout(ui, desk);
    });
    strip(ui, desk);
}

fn controls(ui: &mut Ui, desk: &mut FlankDesk, cx: &mut Context) {
    let play = if desk.is_playing { "⏸" } else { "▶" };
    let buttons = [
        (FrameCommand::FirstNode, "⏮", "To the start"),
        (FrameCommand::PreviousNode, "⏴", "Previous location"),
        (FrameCommand::Play, play, "Play"),
        (FrameCommand::NextNode, "⏵", "Next location"),
        (FrameCommand::LastNode, "⏭", "To the end"),
    ];
    for (command, sign, name) in buttons {
        let button = egui::Button::new(RichText::new(sign).size(13.0)).min_size(vec2(28.0, 22.0));
        let keys = command
            .command()
            .info
            .keys
            .map(|keys| format!("  ({})", ui.ctx().format_shortcut(&keys)))
            .unwrap_or_default();
        let response = ui.add_enabled(desk.is_enabled(command.into()), button).on_hover_text(format!("{name}{keys}"));
        response.widget_info(|| WidgetInfo::labeled(Role::Button, true, name));
        if response.clicked() {
            cx.push(command);
        }
    }
}

/// Where the cutter stands and how far it is off there.
fn readout(ui: &mut Ui, desk: &FlankDesk) {
    let flank = desk;
    let Some(path) = flank.shown_path() else { return };
    let pose = path.pose(flank.t);
    let line = contact_line(path, flank.t);
    let least = line.iter().fold(f64::INFINITY, |a, [_, _, d]| a.min(*d));
    let greatest = line.iter().fold(f64::NEG_INFINITY, |a, [_, _, d]| a.max(*d));
    let faint = palette(ui).faint;
    let room = ui.available_width();
    ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
        if room > 330.0 {
            let text = if line.is_empty() {
                "off the surface".to_owned()
            } else {
                format!("{least:+.4} to {greatest:+.4} mm")
            };
            let hint = "Least and greatest static deviation at this location";
            ui.label(RichText::new(text).monospace()).on_hover_text(hint);
        }
        if room > 700.0 {
            let (tip, axis) = (pose.tip, pose.axis);
            let text = format!(
                "tip {:.3}, {:.3}, {:.3}   axis {:+.4}, {:+.4}, {:+.4}   ",
                tip.x, tip.y, tip.z, axis.x, axis.y, axis.z
            );
            ui.label(RichText::new(text).monospace().color(faint)).on_hover_text("Centre of the cutter's bottom (mm)");
        }
        if room > 100.0 {
            let text = format!("{} path, t {:.3}", flank.path.name(), flank.t);
            ui.label(text).on_hover_text("0 where the path begins, 1 where it ends");
        }
    });
}

/// The strip with a tick for every location; a drag moves the cutter.
fn strip(ui: &mut Ui, desk: &mut FlankDesk) {
    let (rect, response) = ui.allocate_exact_size(vec2(ui.available_width(), 30.0), Sense::click_and_drag());
    let planned = desk.planned().cloned();
    response.widget_info(|| WidgetInfo::slider(planned.is_some(), desk.t, "Timeline"));
    let colours = palette(ui);
    let painter = ui.painter_at(rect);
    painter.rect_filled(rect, 4.0, ui.visuals().extreme_bg_color);
    let (Some(planned), Some(path)) = (&planned, desk.shown_path()) else {
        let text = "No path yet: plan one (F8) to see its cutter locations.";
        painter.text(rect.center(), Align2::CENTER_CENTER, text, FontId::proportional(12.0), colours.faint);
        return;
    };
    let inner = rect.shrink2(vec2(12.0, 0.0));
    let x_of = |t: f64| inner.left() + inner.width() * t as f32;
    for pose in &path.poses {
        let mark = egui::Stroke::new(1.0, colours.faint.gamma_multiply(0.7));
        painter.vline(x_of(pose.t), rect.bottom() - 9.0..=rect.bottom() - 3.0, mark);
    }
    let pin = x_of(desk.t);
    for i in 0..=10 {
        let x = x_of(f64::from(i) / 10.0);
        if (x - pin).abs() > 14.0 {
            let text = format!("{:.1}", f64::from(i) / 10.0);
            painter.text(
                pos2(x, rect.top() + 8.0),
                Align2::CENTER_CENTER,
                text,
                FontId::proportional(10.0),
                colours.faint,
            );
        }
    }
    // Where the nearest wall is, and where the machine's pole is passed.
    let near = planned.result.checks.iter().filter_map(|check| Some((check.t?, check.holds)));
    let poles = planned.machine.iter().flat_map(|machine| machine.singular.iter().map(|(t, _)| (*t, true)));
    for (t, holds) in near.chain(poles) {
        let tip = pos2(x_of(t), rect.bottom() - 9.0);
        let triangle = vec![tip, tip + vec2(-4.0, -6.0), tip + vec2(4.0, -6.0)];
        let colour = if holds { colours.warning } else { colours.bad };
        painter.add(egui::Shape::convex_polygon(triangle, colour, egui::Stroke::NONE));
    }
    painter.vline(pin, rect.y_range(), egui::Stroke::new(2.0, colours.accent));
    painter.circle_filled(pos2(pin, rect.top() + 5.0), 5.0, colours.accent);
    if let Some(pointer) = response.interact_pointer_pos() {
        desk.go_to(f64::from((pointer.x - inner.left()) / inner.width()));
    }
    if response.has_focus() {
        // The keys that step would otherwise move the focus.
        let lock = egui::EventFilter { horizontal_arrows: true, ..Default::default() };
        ui.memory_mut(|m| m.set_focus_lock_filter(response.id, lock));
        if ui.input(|i| i.key_pressed(Key::Escape)) {
            response.surrender_focus();
        }
    }
}
