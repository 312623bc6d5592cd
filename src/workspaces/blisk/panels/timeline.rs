//! The timeline: the nodes of the track from outside to the final pose, the cursor, and how it is played.

use crate::workspaces::blisk::commands::BliskCommand;
use crate::workspaces::blisk::desk::BliskDesk;
use crate::workspaces::commands::{CommandSet, Commanded, FrameCommand};
use crate::workspaces::context::Context;
use egui::{Align2, FontId, Key, Rect, RichText, Role, Sense, Ui, WidgetInfo, pos2, vec2};

use crate::widgets::theme::palette;

/// Least room for the figures beside the buttons (points): the clearance, where it is, and what all of it is.
const READOUT: [f32; 3] = [90.0, 200.0, 325.0];
/// Least room for the controls of playing beside the buttons and the clearance.
const PLAYING: f32 = 320.0;

/// Draws the timeline.
pub fn show(ui: &mut Ui, desk: &mut BliskDesk, cx: &mut Context) {
    ui.horizontal(|ui| {
        controls(ui, desk, cx);
        readout(ui, desk, cx);
    });
    strip(ui, desk);
    whole_motion(ui, desk);
}

fn controls(ui: &mut Ui, desk: &mut BliskDesk, cx: &mut Context) {
    let play = if desk.cursor.playing { "⏸" } else { "▶" };
    let buttons = [
        (FrameCommand::FirstNode, "⏮", "First node"),
        (FrameCommand::PreviousNode, "⏴", "Previous node"),
        (FrameCommand::Play, play, "Play"),
        (FrameCommand::NextNode, "⏵", "Next node"),
        (FrameCommand::LastNode, "⏭", "Final pose"),
    ];
    for (command, sign, name) in buttons {
        let button = egui::Button::new(RichText::new(sign).size(13.0)).min_size(vec2(28.0, 22.0));
        let response = ui.add_enabled(desk.is_enabled(command.into()), button).on_hover_text(command.hint(ui.ctx()));
        response.widget_info(|| WidgetInfo::labeled(Role::Button, true, name));
        if response.clicked() {
            cx.push(command);
        }
    }
    // Where there is little room, what is looked at comes before how it is played.
    if ui.available_width() > PLAYING {
        playing(ui, desk, cx);
    }
    which_electrode(ui, desk);
}

/// Draws the buttons and the speed of playing.
fn playing(ui: &mut Ui, desk: &mut BliskDesk, cx: &mut Context) {
    let speed =
        egui::DragValue::new(&mut desk.cursor.speed).range(0.1..=200.0).speed(0.2).suffix(" mm/s").max_decimals(1);
    let response = ui.add_sized(vec2(78.0, 22.0), speed).on_hover_text("Speed of playing along the path");
    ui.ctx().accesskit_node_builder(response.id, |node| node.set_label("Speed of playing"));
    let ghost = ui.add_enabled(desk.is_enabled(BliskCommand::Ghost.into()), egui::Button::new("Previous position"));
    if ghost.on_hover_text(BliskCommand::Ghost.hint(ui.ctx())).clicked() {
        cx.push(BliskCommand::Ghost);
    }
}

/// Draws the choice of the electrode that is looked at, if there are several.
fn which_electrode(ui: &mut Ui, desk: &mut BliskDesk) {
    let count = desk.electrode_count();
    if count > 1 {
        let label = ui.label(RichText::new("Electrode").color(palette(ui).faint));
        let mut chosen = desk.cursor.electrode;
        let combo = egui::ComboBox::from_id_salt("electrode").width(48.0).selected_text((chosen + 1).to_string());
        let response = combo.show_ui(ui, |ui| {
            for i in 0..count {
                ui.selectable_value(&mut chosen, i, (i + 1).to_string());
            }
        });
        response.response.labelled_by(label.id);
        desk.cursor.electrode = chosen;
    }
}

fn readout(ui: &mut Ui, desk: &BliskDesk, cx: &mut Context) {
    let Some(s) = desk.feed_cursor() else {
        let name = desk.moment().map(|moment| moment.name()).unwrap_or_default();
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            ui.add(egui::Label::new(RichText::new(name).color(palette(ui).accent)).truncate());
        });
        return;
    };
    let Some(station) = desk.track().at(s) else { return };
    let length = cx.preferences.length;
    // Numbers count from the final pose, which is node 0, as in verdicts and files.
    let nodes: Vec<_> = desk.track().nodes().map(|n| n.node.unwrap_or_default()).collect();
    let node = desk.track().nearest_node(s).map_or(0, |i| nodes[i]);
    let last = nodes.iter().copied().max().unwrap_or_default();
    let room = ui.available_width();
    let [with_clearance, with_place, with_words] = READOUT.map(|least| room > least);
    let faint = palette(ui).faint;
    ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
        if with_clearance {
            let colour = if station.clearance < desk.least_wanted() { palette(ui).bad } else { palette(ui).good };
            let text = RichText::new(length.show(station.clearance, 4)).color(colour).monospace();
            ui.label(text).on_hover_text("Clearance at the cursor");
        }
        if with_words {
            ui.label(RichText::new("clearance").color(faint));
        }
        if with_place {
            ui.label(RichText::new(length.show(station.s, 3)).monospace()).on_hover_text("Retracted");
            ui.label(RichText::new("at").color(faint));
            ui.label(RichText::new(format!("{node} / {last}")).monospace()).on_hover_text("Node, from the final pose");
        }
        if with_words {
            ui.label(RichText::new("node").color(faint));
        }
    });
}

/// The strip with a tick for every node, coloured by its clearance; a drag moves the cursor.
fn strip(ui: &mut Ui, desk: &mut BliskDesk) {
    let (rect, response) = ui.allocate_exact_size(vec2(ui.available_width(), 30.0), Sense::click_and_drag());
    let length = desk.track().length();
    response.widget_info(|| WidgetInfo::slider(length > 0.0, desk.cursor.s, "Timeline"));
    let colours = palette(ui);
    let painter = ui.painter_at(rect);
    painter.rect_filled(rect, 4.0, ui.visuals().extreme_bg_color);
    if desk.track().is_empty() || length <= 0.0 {
        let text = match desk.track().is_empty() {
            true => "No path yet: plan one (F5) to see its nodes.",
            false => "Only the final pose was found to be free.",
        };
        painter.text(rect.center(), Align2::CENTER_CENTER, text, FontId::proportional(12.0), colours.faint);
        return;
    }
    // The same place as in the plots below, where they can be seen.
    let inner = match desk.span {
        Some([left, right]) if rect.left() <= left && left < right && right <= rect.right() => {
            Rect::from_x_y_ranges(left..=right, rect.y_range())
        }
        _ => rect.shrink2(vec2(12.0, 0.0)),
    };
    let x_of = |s: f64| inner.left() + inner.width() * (1.0 - (s / length) as f32);
    let gap = desk.least_wanted();
    for node in desk.track().nodes() {
        let colour = if node.clearance < gap { colours.bad } else { colours.faint };
        let x = x_of(node.s);
        painter.vline(x, rect.bottom() - 10.0..=rect.bottom() - 3.0, egui::Stroke::new(1.0, colour));
    }
    let pin = desk.feed_cursor().map(|s| x_of(s.clamp(0.0, length)));
    scale(&painter, inner, rect, length, colours.faint, pin);
    for s in &desk.ghosts {
        painter.circle_stroke(pos2(x_of(*s), rect.bottom() - 7.0), 3.5, egui::Stroke::new(1.5, colours.accent));
    }
    // Where the machine collides off the feed the strip below has the mark.
    let mark = desk.trouble().map_or_else(|| desk.contact_s(), |trouble| trouble.s);
    if let Some(s) = mark {
        let tip = pos2(x_of(s), rect.bottom() - 10.0);
        let triangle = vec![tip, tip + vec2(-4.0, -6.0), tip + vec2(4.0, -6.0)];
        let holds = desk.trouble().is_none() && desk.outcome().is_some_and(|o| o.plan.is_verified());
        let colour = if holds { colours.warning } else { colours.bad };
        painter.add(egui::Shape::convex_polygon(triangle, colour, egui::Stroke::NONE));
    }
    if let Some(x) = pin {
        painter.vline(x, rect.y_range(), egui::Stroke::new(2.0, colours.accent));
        painter.circle_filled(pos2(x, rect.top() + 5.0), 5.0, colours.accent);
    }
    if let Some(pointer) = response.interact_pointer_pos() {
        desk.cursor.playing = false;
        let t = f64::from((pointer.x - inner.left()) / inner.width()).clamp(0.0, 1.0);
        desk.cursor.s = length * (1.0 - t);
        desk.machine.go_to(None);
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

/// Round distances along the strip, except where the cursor, if it is shown, would hide them.
fn scale(painter: &egui::Painter, inner: Rect, rect: Rect, length: f64, colour: egui::Color32, cursor: Option<f32>) {
    let most = f64::from((inner.width() / 42.0).clamp(2.0, 14.0));
    for s in marks(length, most) {
        let x = inner.left() + inner.width() * (1.0 - (s / length) as f32);
        let text = if s == 0.0 { "final".to_owned() } else { format!("{s}") };
        // The last one may not stick out on the right.
        let x = x.min(rect.right() - 14.0);
        if cursor.is_none_or(|cursor| (x - cursor).abs() > 16.0) {
            painter.text(pos2(x, rect.top() + 8.0), Align2::CENTER_CENTER, text, FontId::proportional(10.0), colour);
        }
    }
}

/// A strip with a part for everything that the machine does; a drag moves it.
fn whole_motion(ui: &mut Ui, desk: &mut BliskDesk) {
    let Some((motion, gone)) = desk.machine.motion() else { return };
    let (rect, response) = ui.allocate_exact_size(vec2(ui.available_width(), 18.0), Sense::click_and_drag());
    let length = motion.length();
    response.widget_info(|| WidgetInfo::slider(length > 0.0, gone.unwrap_or(0.0), "Whole motion"));
    let colours = palette(ui);
    let painter = ui.painter_at(rect);
    painter.rect_filled(rect, 4.0, ui.visuals().extreme_bg_color);
    let inner = rect.shrink2(vec2(12.0, 0.0));
    let x_of = |way: f64| inner.left() + inner.width() * (way / length.max(1e-9)) as f32;
    for (i, (phase, _, [from, to])) in motion.phases().enumerate() {
        let part = Rect::from_x_y_ranges(x_of(from)..=x_of(to), rect.shrink(2.0).y_range());
        let fill = if i % 2 == 0 { colours.faint.gamma_multiply(0.18) } else { colours.faint.gamma_multiply(0.32) };
        painter.rect_filled(part, 2.0, fill);
        if part.width() > 7.0 * phase.name().len() as f32 {
            let font = FontId::proportional(10.0);
            painter.text(part.center(), Align2::CENTER_CENTER, phase.name(), font, ui.visuals().text_color());
        }
    }
    if let Some(trouble) = desk.machine.trouble() {
        painter.vline(x_of(trouble.way), rect.y_range(), egui::Stroke::new(2.0, colours.bad));
    }
    if let Some(way) = gone {
        painter.vline(x_of(way), rect.y_range(), egui::Stroke::new(2.0, colours.accent));
        painter.circle_filled(pos2(x_of(way), rect.center().y), 4.0, colours.accent);
    }
    if let Some(pointer) = response.interact_pointer_pos() {
        let t = f64::from((pointer.x - inner.left()) / inner.width()).clamp(0.0, 1.0);
        desk.go_to_moment(length * t);
    }
}

/// Round distances from 0 to `length` (mm), at most `most` steps of them up to any length that a path can have.
fn marks(length: f64, most: f64) -> impl Iterator<Item = f64> {
    let steps = (0..4).flat_map(|power| [1.0, 2.0, 5.0].map(|s| s * 10f64.powi(power)));
    let step = steps.into_iter().find(|s| length / s <= most).unwrap_or(1e4);
    let count = (length / step + 1e-9).min(most) as u32;
    (0..=count).map(move |i| step * f64::from(i))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn marks_are_round_distances_and_never_more_than_there_is_room_for() {
        assert_eq!(marks(4.4, 5.0).collect::<Vec<_>>(), [0.0, 1.0, 2.0, 3.0, 4.0]);
        assert_eq!(marks(30.0, 4.0).collect::<Vec<_>>(), [0.0, 10.0, 20.0, 30.0]);
        for length in [1e-3, 250.0, 9999.0, 1e19, f64::MAX] {
            let all: Vec<f64> = marks(length, 14.0).collect();
            assert!(all.len() <= 15 && all[0] == 0.0 && all.iter().all(|s| *s <= length), "{length}: {all:?}");
        }
    }
}
