//! The timeline: the locations of the path from its start to its end, where the cutter stands, and how it is played.

use crate::workspaces::context::Context;
use crate::workspaces::flank::panels::desk::FlankDesk;
use egui::{RichText, Role, Ui, WidgetInfo};

use crate::widgets::theme::palette;
use crate::widgets::timeline::Strip;
use crate::workspaces::flank::scene::contact_line;

/// Draws it, `with_handle` that opens the plots below where they have no room of their own.
pub fn show(ui: &mut Ui, desk: &mut FlankDesk, cx: &mut Context, with_handle: bool) {
    ui.horizontal(|ui| {
        let names = ["To the start", "Previous location", "Next location", "To the end"];
        cx.play_buttons(ui, desk, (desk.is_playing, 28.0), names, true);
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

/// Position of the cutter, and the deviation there.
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
    let planned = desk.planned().cloned();
    let strip = Strip::new(ui, 30.0, "Timeline", (desk.t, planned.is_some()));
    let (rect, inner, colours) = (strip.rect, strip.inner(), palette(ui));
    let (Some(planned), Some(path)) = (&planned, desk.shown_path()) else {
        return strip.say("No path yet: plan one (F8) to see its cutter locations.");
    };
    let x_of = |t: f64| inner.left() + inner.width() * t as f32;
    for pose in &path.poses {
        let mark = egui::Stroke::new(1.0, colours.faint.gamma_multiply(0.7));
        strip.painter.vline(x_of(pose.t), rect.bottom() - 9.0..=rect.bottom() - 3.0, mark);
    }
    let pin = x_of(desk.t);
    for i in 0..=10 {
        let x = x_of(f64::from(i) / 10.0);
        if (x - pin).abs() > 14.0 {
            strip.number(x, format!("{:.1}", f64::from(i) / 10.0));
        }
    }
    // Where the nearest wall is, and where the machine's pole is passed.
    let near = planned.result.checks.iter().filter_map(|check| Some((check.t?, check.holds)));
    let poles = planned.machine.iter().flat_map(|machine| machine.singular.iter().map(|(t, _)| (*t, true)));
    for (t, holds) in near.chain(poles) {
        strip.mark(x_of(t), 9.0, holds);
    }
    strip.pin(pin, rect.top() + 5.0, 5.0);
    if let Some(t) = strip.dragged(inner) {
        desk.go_to(t);
    }
    strip.keep_keys(ui);
}
