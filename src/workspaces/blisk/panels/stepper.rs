//! The left panel: the six steps with their state, the form of the open one, and what is known of it.

use egui::{Align2, Color32, FontId, Rect, RichText, Role, Sense, Ui, WidgetInfo, pos2, vec2};

use super::forms::{self, Request};
use super::step_facts;
use crate::shell::commands::Command;
use crate::shell::core::Core;
use crate::widgets::theme::palette;
use crate::workspaces::blisk::document::stage::Stage;
use crate::workspaces::blisk::pipeline::StageState;

/// Below this height (points) the steps stand side by side, so that their forms have room.
const LOW: f32 = 420.0;

/// Draws stepper and form.
pub fn show(ui: &mut Ui, core: &mut Core) -> Option<Request> {
    ui.add_space(2.0);
    if ui.available_height() < LOW {
        row_of_steps(ui, core)
    } else {
        list_of_steps(ui, core)
    }
    ui.add_space(4.0);
    ui.separator();
    let mut request = None;
    egui::ScrollArea::vertical().id_salt("form").auto_shrink([false, false]).show(ui, |ui| {
        introduction(ui, core.step);
        // What a field says of itself need not be said twice.
        if let StageState::Failed(why) = core.pipeline.state(core.step)
            && !forms::has_problem(core, core.step)
        {
            notice(ui, palette(ui).bad, &why);
        }
        if core.pipeline.state(core.step) == StageState::Stale {
            notice(ui, palette(ui).warning, stale_text(core.step));
        }
        request = forms::show(ui, core, core.step);
        ui.add_space(8.0);
        step_facts::show(ui, core, core.step);
    });
    request
}

fn list_of_steps(ui: &mut Ui, core: &mut Core) {
    ui.scope(|ui| {
        ui.spacing_mut().item_spacing.y = 2.0;
        for stage in Stage::ALL {
            if step(ui, stage, Standing::of(core, stage), core.step == stage).clicked() {
                core.step = stage;
            }
        }
    });
}

/// The steps side by side, and the name of the open one below.
fn row_of_steps(ui: &mut Ui, core: &mut Core) {
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 2.0;
        let width = (ui.available_width() - 10.0) / Stage::ALL.len() as f32;
        for stage in Stage::ALL {
            let (state, open) = (Standing::of(core, stage), core.step == stage);
            let (rect, response) = ui.allocate_exact_size(vec2(width, 26.0), Sense::click());
            background(ui, rect, open, &response);
            let (_, colour) = word(ui, state);
            badge(ui, rect.center(), stage, state, colour);
            if told(response, stage, state, open).clicked() {
                core.step = stage;
            }
        }
    });
    let (word, colour) = word(ui, Standing::of(core, core.step));
    ui.horizontal(|ui| {
        ui.strong(format!("{} {}", core.step.number(), core.step.name()));
        ui.label(RichText::new(word).color(colour));
    });
}

fn stale_text(stage: Stage) -> &'static str {
    match stage {
        Stage::Plan | Stage::Verify => {
            "An input has changed since this was planned. Plan again to bring it up to date."
        }
        Stage::Export => "The exported files are out of date.",
        _ => "An input has changed; this step is being recomputed.",
    }
}

/// What is done in a step, for whoever sees it for the first time.
fn introduction(ui: &mut Ui, stage: Stage) {
    let text = match stage {
        Stage::Part => "Load the finished blisk: drop a mesh into the window or open one.",
        Stage::Channel => "Check axis, blades and channel; correct by hand what is wrong.",
        Stage::Electrode => "Tune gap and reductions by eye: the electrode follows.",
        Stage::Plan => "Search the feed path, from the final pose outwards, node by node.",
        Stage::Verify => "The whole motion is proven to keep the spark gap, or the place where it does not is shown.",
        Stage::Export => "Release the certified path for export and write it for the machine.",
    };
    ui.label(RichText::new(text).color(palette(ui).faint));
    ui.add_space(2.0);
}

/// A framed sentence with a coloured edge.
pub fn notice(ui: &mut Ui, colour: Color32, text: &str) {
    let fill = colour.gamma_multiply(0.14);
    egui::Frame::new()
        .fill(fill)
        .corner_radius(4)
        .inner_margin(8)
        .stroke(egui::Stroke::new(1.0, colour.gamma_multiply(0.6)))
        .show(ui, |ui| {
            ui.set_width(ui.available_width());
            ui.add(egui::Label::new(sentence(text)).wrap());
        });
    ui.add_space(4.0);
}

/// One line of the stepper.
fn step(ui: &mut Ui, stage: Stage, state: Standing, open: bool) -> egui::Response {
    let (rect, response) = ui.allocate_exact_size(vec2(ui.available_width(), 26.0), Sense::click());
    let (word, colour) = word(ui, state);
    background(ui, rect, open, &response);
    let visuals = ui.visuals();
    let ink = if open { visuals.selection.stroke.color } else { visuals.text_color() };
    badge(ui, pos2(rect.left() + 15.0, rect.center().y), stage, state, colour);
    let font = FontId::proportional(13.0);
    ui.painter().text(rect.left_center() + vec2(32.0, 0.0), Align2::LEFT_CENTER, stage.name(), font.clone(), ink);
    let right = rect.right_center() - vec2(8.0, 0.0);
    ui.painter().text(right, Align2::RIGHT_CENTER, word, FontId::proportional(11.5), colour);
    told(response, stage, state, open)
}

/// How a step stands for who looks at it: a plan is not good before what belongs to it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Standing {
    /// Nothing has been done.
    Missing,
    /// It, or what decides about it, is being worked on.
    Working,
    /// Its result is that of the present parameters.
    Done,
    /// Its result is that of other parameters.
    Stale,
    /// It could not be done.
    Failed,
    /// There is a plan, which must not be driven.
    Unsafe,
    /// There is a plan, of which it is not known whether it may be driven.
    Unchecked,
}

impl Standing {
    /// How `stage` stands.
    pub fn of(core: &Core, stage: Stage) -> Self {
        let may_be_driven = || core.pipeline.plan().is_some_and(|plan| plan.may_be_approved());
        match (core.pipeline.state(stage), stage) {
            (StageState::Done, Stage::Plan) => match core.pipeline.state(Stage::Verify) {
                StageState::Running => Self::Working,
                StageState::Failed(_) if may_be_driven() => Self::Unchecked,
                StageState::Failed(_) => Self::Unsafe,
                StageState::Missing | StageState::Done | StageState::Stale => Self::Done,
            },
            (StageState::Missing, _) => Self::Missing,
            (StageState::Running, _) => Self::Working,
            (StageState::Done, _) => Self::Done,
            (StageState::Stale, _) => Self::Stale,
            (StageState::Failed(_), _) => Self::Failed,
        }
    }
}

/// How a step stands, in a word and a colour.
fn word(ui: &Ui, state: Standing) -> (&'static str, Color32) {
    let colours = palette(ui);
    let colour = match state {
        Standing::Missing => colours.faint,
        Standing::Working => colours.accent,
        Standing::Done => colours.good,
        Standing::Stale | Standing::Unchecked => colours.warning,
        Standing::Failed | Standing::Unsafe => colours.bad,
    };
    (word_of(state), colour)
}

fn word_of(state: Standing) -> &'static str {
    match state {
        Standing::Missing => "",
        Standing::Working => "working",
        Standing::Done => "done",
        Standing::Stale => "out of date",
        Standing::Failed => "failed",
        Standing::Unsafe => "not safe",
        Standing::Unchecked => "unchecked",
    }
}

fn background(ui: &Ui, rect: Rect, open: bool, response: &egui::Response) {
    let visuals = ui.visuals();
    if open {
        ui.painter().rect_filled(rect, 4.0, visuals.selection.bg_fill);
    } else if response.hovered() {
        ui.painter().rect_filled(rect, 4.0, visuals.widgets.hovered.weak_bg_fill);
    }
}

/// Names a step for whoever hears the window or points at it.
fn told(response: egui::Response, stage: Stage, state: Standing, open: bool) -> egui::Response {
    let name = format!("{} {}", stage.number(), stage.name());
    let said = match word_of(state) {
        "" => name,
        word => format!("{name}, {word}"),
    };
    response.widget_info(|| WidgetInfo::selected(Role::Tab, true, open, &said));
    response.on_hover_text(Command::Step(stage).name())
}

/// The number of a step in a circle that shows its state; a hook when it is done.
fn badge(ui: &Ui, centre: egui::Pos2, stage: Stage, state: Standing, colour: Color32) {
    let painter = ui.painter();
    let stroke = egui::Stroke::new(1.5, colour);
    if state == Standing::Done {
        painter.circle_filled(centre, 9.0, colour);
        let ink = egui::Stroke::new(1.8, ui.visuals().panel_fill);
        let hook = [vec2(-4.0, 0.2), vec2(-1.2, 3.0), vec2(4.0, -3.0)].map(|d| centre + d);
        painter.line(hook.to_vec(), ink);
        return;
    }
    painter.circle_stroke(centre, 8.5, stroke);
    let number = stage.number().to_string();
    painter.text(centre, Align2::CENTER_CENTER, number, FontId::proportional(11.5), colour);
    if state == Standing::Working {
        let angle = (ui.input(|i| i.time) * 4.0) as f32;
        let point = centre + 8.5 * egui::Vec2::angled(angle);
        painter.circle_filled(point, 2.5, colour);
        // Twenty a second are enough for a dot that goes round.
        ui.ctx().request_repaint_after(std::time::Duration::from_millis(50));
    }
}

/// A button for a command, greyed while it cannot be done.
pub fn command_button(ui: &mut Ui, core: &mut Core, command: Command, text: &str, primary: bool) {
    let enabled = command.is_enabled(core);
    let mut button = egui::Button::new(RichText::new(text).strong()).min_size(vec2(0.0, 26.0));
    if primary && enabled {
        let accent = palette(ui).accent;
        let ink = if ui.visuals().dark_mode { Color32::BLACK } else { Color32::WHITE };
        button = egui::Button::new(RichText::new(text).strong().color(ink)).fill(accent).min_size(vec2(0.0, 26.0));
    }
    let mut response = ui.add_enabled(enabled, button).on_hover_text(command.hint(ui.ctx()));
    if let Some(why) = command.needs() {
        response = response.on_disabled_hover_text(why);
    }
    if response.clicked() {
        core.push(command);
    }
}

/// A name on the left and its value on the right: words end at the edge, numbers stand below each other with their
/// units in a column of their own. A long value takes from the name's room, but not all of it.
pub fn fact(ui: &mut Ui, name: &str, value: impl Into<String>) {
    const UNITS: f32 = 36.0;
    let width = ui.available_width();
    let (rect, _) = ui.allocate_exact_size(vec2(width, 18.0), Sense::hover());
    let value = value.into();
    let (value, unit) = number_and_unit(&value).map_or((value.as_str(), None), |(n, unit)| (n, Some(unit)));
    let end = rect.right() - unit.map_or(0.0, |_| UNITS);
    let font = egui::TextStyle::Body.resolve(ui.style());
    let needed = ui.painter().layout_no_wrap(value.to_owned(), font, Color32::WHITE).size().x;
    let border = end - (needed + 8.0).clamp(0.0, 0.75 * width);
    let left = Rect::from_min_max(rect.min, pos2(border, rect.bottom()));
    let right = Rect::from_min_max(pos2(border, rect.top()), pos2(end, rect.bottom()));
    let faint = palette(ui).faint;
    let put = |ui: &mut Ui, at: Rect, text: RichText, layout: egui::Layout| {
        let mut child = ui.new_child(egui::UiBuilder::new().max_rect(at).layout(layout));
        child.add(egui::Label::new(text).truncate());
    };
    put(ui, left, RichText::new(name).color(faint), egui::Layout::left_to_right(egui::Align::Center));
    put(ui, right, RichText::new(value), egui::Layout::right_to_left(egui::Align::Center));
    if let Some(unit) = unit.filter(|unit| !unit.is_empty()) {
        let at = Rect::from_min_max(pos2(end + 4.0, rect.top()), rect.max);
        put(ui, at, RichText::new(unit).color(faint), egui::Layout::left_to_right(egui::Align::Center));
    }
}

/// The number that `value` is, and its unit, which may be empty; none if it is words.
fn number_and_unit(value: &str) -> Option<(&str, &str)> {
    let is_number = |text: &str| text.chars().all(|c| c.is_ascii_digit() || "+-. ".contains(c)) && !text.is_empty();
    if is_number(value) {
        return Some((value, ""));
    }
    let (number, unit) = value.rsplit_once(' ')?;
    (is_number(number) && ["mm", "in", "deg", "s", "mm²", "mm³"].contains(&unit)).then_some((number, unit))
}

/// A sentence as it begins where it stands by itself; names of files and keys stay as they are.
pub fn sentence(text: &str) -> String {
    let first = text.split(' ').next().unwrap_or_default();
    if !first.chars().all(|c| c.is_ascii_lowercase() || ",:".contains(c)) {
        return text.to_owned();
    }
    let mut letters = text.chars();
    letters.next().map_or(String::new(), |first| first.to_uppercase().chain(letters).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_is_told_from_its_unit_and_from_words() {
        assert_eq!(number_and_unit("-1.4874 deg"), Some(("-1.4874", "deg")));
        assert_eq!(number_and_unit("24 288"), Some(("24 288", "")));
        assert_eq!(number_and_unit("10788.4 mm³"), Some(("10788.4", "mm³")));
        for words in ["hub", "node 7 from the final pose", "part.stl", ""] {
            assert_eq!(number_and_unit(words), None, "{words}");
        }
    }

    #[test]
    fn a_sentence_begins_with_a_capital_and_a_name_stays_as_it_is() {
        assert_eq!(sentence("jams at node 7"), "Jams at node 7");
        for name in ["part.stl: not closed", "[plan] step_mm: too large", "x_1 is wrong", ""] {
            assert_eq!(sentence(name), name);
        }
    }
}
