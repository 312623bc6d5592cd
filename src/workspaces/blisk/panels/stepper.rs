//! The left panel: the six steps with their state, the form of the open one, and what is known of it.

use crate::widgets::panel_parts::notice;
use crate::workspaces::blisk::commands::BliskCommand;
use crate::workspaces::blisk::desk::BliskDesk;
use crate::workspaces::commands::CommandSet;
use crate::workspaces::context::Context;
use egui::{Align2, Color32, FontId, Rect, RichText, Role, Sense, Ui, WidgetInfo, pos2, vec2};

use super::forms::{self, Request};
use super::{picks, step_facts};
use crate::widgets::theme::palette;
use crate::workspaces::blisk::document::stage::Stage;
use task::State;

/// Below this height (points) the steps stand side by side, so that their forms have room.
const LOW: f32 = 420.0;

/// Draws stepper and form.
pub fn show(ui: &mut Ui, desk: &mut BliskDesk, cx: &mut Context) -> Option<Request> {
    ui.add_space(2.0);
    if ui.available_height() < LOW {
        row_of_steps(ui, desk)
    } else {
        list_of_steps(ui, desk)
    }
    ui.add_space(4.0);
    ui.separator();
    let mut request = None;
    egui::ScrollArea::vertical().id_salt("form").auto_shrink([false, false]).show(ui, |ui| {
        introduction(ui, desk.step);
        // What a field says of itself need not be said twice.
        if let State::Failed(why) = desk.work.state(desk.step)
            && !forms::has_problem(desk, desk.step)
        {
            notice(ui, palette(ui).bad, &why);
            if desk.refused_at().is_some() {
                cx.button(ui, desk, BliskCommand::ShowRefusal, "Show the place", false);
                ui.add_space(4.0);
            }
        }
        if desk.work.state(desk.step) == State::Stale {
            notice(ui, palette(ui).warning, stale_text(desk.step));
        }
        if desk.step == Stage::Channel && picks::come_first(desk) {
            picks::show(ui, desk, cx);
            ui.add_space(4.0);
        }
        request = forms::show(ui, desk, cx, desk.step);
        ui.add_space(8.0);
        step_facts::show(ui, desk, cx, desk.step);
    });
    request
}

fn list_of_steps(ui: &mut Ui, desk: &mut BliskDesk) {
    ui.scope(|ui| {
        ui.spacing_mut().item_spacing.y = 2.0;
        for stage in Stage::ALL {
            if step(ui, stage, Standing::of(desk, stage), desk.step == stage).clicked() {
                desk.step = stage;
            }
        }
    });
}

/// The steps side by side, and the name of the open one below.
fn row_of_steps(ui: &mut Ui, desk: &mut BliskDesk) {
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 2.0;
        let width = (ui.available_width() - 10.0) / Stage::ALL.len() as f32;
        for stage in Stage::ALL {
            let (state, open) = (Standing::of(desk, stage), desk.step == stage);
            let (rect, response) = ui.allocate_exact_size(vec2(width, 26.0), Sense::click());
            background(ui, rect, open, &response);
            let (_, colour) = word(ui, state);
            badge(ui, rect.center(), stage, state, colour);
            if told(response, stage, state, open).clicked() {
                desk.step = stage;
            }
        }
    });
    let (word, colour) = word(ui, Standing::of(desk, desk.step));
    ui.horizontal(|ui| {
        ui.strong(format!("{} {}", desk.step.number(), desk.step.name()));
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

/// Explanation of a step for new users.
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

/// Draws one line of the stepper.
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

/// State of a step as shown: a plan is complete only with everything that belongs to it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Standing {
    /// Nothing has been done.
    Missing,
    /// The stage, or one that it depends on, is being worked on.
    Working,
    /// The result is that of the present parameters.
    Done,
    /// The result is that of other parameters.
    Stale,
    /// The stage failed.
    Failed,
    /// There is a plan, which must not be driven.
    Unsafe,
    /// There is a plan, of which it is not known whether it may be driven.
    Unchecked,
}

impl Standing {
    /// State of `stage` as shown.
    pub fn of(desk: &BliskDesk, stage: Stage) -> Self {
        let may_be_driven = || desk.work.plan().is_some_and(|plan| plan.may_be_approved());
        match (desk.work.state(stage), stage) {
            (State::Ready, Stage::Plan) => match desk.work.state(Stage::Verify) {
                State::Running => Self::Working,
                State::Failed(_) if may_be_driven() => Self::Unchecked,
                State::Failed(_) => Self::Unsafe,
                State::Missing | State::Ready | State::Stale | State::Cancelled => Self::Done,
            },
            (State::Missing | State::Cancelled, _) => Self::Missing,
            (State::Running, _) => Self::Working,
            (State::Ready, _) => Self::Done,
            (State::Stale, _) => Self::Stale,
            (State::Failed(_), _) => Self::Failed,
        }
    }
}

/// State of a step as a word with its colour.
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
    response.on_hover_text(BliskCommand::Step(stage).command().info.name)
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
