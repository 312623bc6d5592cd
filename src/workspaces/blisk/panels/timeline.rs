//! The timeline: the nodes of the track from outside to the final pose, the cursor, and how it is played.

use crate::workspaces::blisk::commands::BliskCommand;
use crate::workspaces::blisk::desk::BliskDesk;
use crate::workspaces::commands::{CommandSet, Commanded};
use crate::workspaces::context::Context;
use egui::{Align2, FontId, Rect, RichText, Ui, pos2, vec2};

use crate::widgets::theme::palette;
use crate::widgets::timeline::Strip;

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
    let names = ["First node", "Previous node", "Next node", "Final pose"];
    cx.play_buttons(ui, desk, (desk.cursor.playing, 28.0), names, false);
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
        let params = &desk.document.params().electrode;
        let combo = egui::ComboBox::from_id_salt("electrode").width(48.0).selected_text(params.label(chosen));
        let response = combo.show_ui(ui, |ui| {
            for i in 0..count {
                ui.selectable_value(&mut chosen, i, params.label(i));
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
    let length = desk.track().length();
    let strip = Strip::new(ui, 30.0, "Timeline", (desk.cursor.s, length > 0.0));
    let (rect, painter, colours) = (strip.rect, &strip.painter, palette(ui));
    if desk.track().is_empty() || length <= 0.0 {
        return strip.say(match desk.track().is_empty() {
            true => "No path yet: plan one (F5) to see its nodes.",
            false => "Only the final pose was found to be free.",
        });
    }
    // The same place as in the plots below, where they can be seen.
    let inner = match desk.span {
        Some([left, right]) if rect.left() <= left && left < right && right <= rect.right() => {
            Rect::from_x_y_ranges(left..=right, rect.y_range())
        }
        _ => strip.inner(),
    };
    let x_of = |s: f64| inner.left() + inner.width() * (1.0 - (s / length) as f32);
    let gap = desk.least_wanted();
    for node in desk.track().nodes() {
        let colour = if node.clearance < gap { colours.bad } else { colours.faint };
        let x = x_of(node.s);
        painter.vline(x, rect.bottom() - 10.0..=rect.bottom() - 3.0, egui::Stroke::new(1.0, colour));
    }
    let pin = desk.feed_cursor().map(|s| x_of(s.clamp(0.0, length)));
    scale(&strip, inner, length, pin);
    for s in &desk.ghosts {
        painter.circle_stroke(pos2(x_of(*s), rect.bottom() - 7.0), 3.5, egui::Stroke::new(1.5, colours.accent));
    }
    // Where the machine collides off the feed the strip below has the mark.
    let mark = desk.trouble().map_or_else(|| desk.contact_s(), |trouble| trouble.s);
    if let Some(s) = mark {
        let holds = desk.trouble().is_none() && desk.outcome().is_some_and(|o| o.plan.is_verified());
        strip.mark(x_of(s), 10.0, holds);
    }
    if let Some(x) = pin {
        strip.pin(x, rect.top() + 5.0, 5.0);
    }
    if let Some(t) = strip.dragged(inner) {
        desk.cursor.playing = false;
        desk.cursor.s = length * (1.0 - t);
        desk.machine.go_to(None);
    }
    strip.keep_keys(ui);
}

/// Round distances along the strip, except where the cursor, if it is shown, would hide them.
fn scale(strip: &Strip, inner: Rect, length: f64, cursor: Option<f32>) {
    let most = f64::from((inner.width() / 42.0).clamp(2.0, 14.0));
    for s in marks(length, most) {
        let x = inner.left() + inner.width() * (1.0 - (s / length) as f32);
        let text = if s == 0.0 { "final".to_owned() } else { format!("{s}") };
        // The last one may not stick out on the right.
        let x = x.min(strip.rect.right() - 14.0);
        if cursor.is_none_or(|cursor| (x - cursor).abs() > 16.0) {
            strip.number(x, text);
        }
    }
}

/// A strip with a part for everything that the machine does; a drag moves it.
fn whole_motion(ui: &mut Ui, desk: &mut BliskDesk) {
    let Some((motion, gone)) = desk.machine.motion() else { return };
    let length = motion.length();
    let strip = Strip::new(ui, 18.0, "Whole motion", (gone.unwrap_or(0.0), length > 0.0));
    let (rect, painter, inner, colours) = (strip.rect, &strip.painter, strip.inner(), palette(ui));
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
        strip.pin(x_of(way), rect.center().y, 4.0);
    }
    if let Some(t) = strip.dragged(inner) {
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
