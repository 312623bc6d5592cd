//! The sides that the passage opens to as arrows at its mouths, in the step Electrode: a click on one chooses it, for the
//! part that is shown where there are several.

use egui::{FontId, Rect, Role, Sense, Stroke, Ui, WidgetInfo, vec2};

use crate::widgets::theme::palette;
use crate::widgets::viewport::Viewport;
use crate::workspaces::blisk::desk::BliskDesk;
use crate::workspaces::blisk::document::stage::Stage;
use task::State;
use wheel::electrode::{EnterSide, EntrySide};

/// Length of an arrow as a share of the height of the view.
const LENGTH: f64 = 0.14;
/// Distance from the arrow at which the pointer is on it (points).
const NEAR: f32 = 9.0;

/// Draws the arrows over the view in `rect`.
pub fn show(ui: &mut Ui, rect: Rect, desk: &mut BliskDesk, viewport: &Viewport) {
    let failed = matches!(desk.work.state(Stage::Channel), State::Failed(_));
    let Some(found) = desk.work.channel().filter(|_| desk.step == Stage::Electrode && !failed).cloned() else { return };
    let channel = &*found.channel;
    let reach = LENGTH * viewport.camera().0.visible_height();
    for side in EntrySide::open(channel) {
        let Ok(is_last) = side.mouth(channel) else { continue };
        let Some(mouth) = found.shapes.passage.mouth(is_last) else { continue };
        let direction = side.direction();
        let told = desk.reported_electrodes().into_iter().filter(|electrode| electrode.enters_from == side);
        // Beyond the holder, where there is one.
        let ends = told.map(|electrode| {
            let bounds = electrode.mesh.bounds();
            bounds.min.dot(direction).max(bounds.max.dot(direction)) - mouth.dot(direction)
        });
        let start = mouth + direction * (ends.fold(0.0, f64::max) + 0.1 * reach);
        let [from, to] = [start, start + direction * reach].map(|p| channel.frame.to_parent(p));
        let (Some(from), Some(to)) = (viewport.seen_at(ui, rect, from), viewport.seen_at(ui, rect, to)) else {
            continue;
        };
        if arrow(ui, rect, [from, to], (side, is_used(desk, side))) {
            let number = desk.cursor.electrode;
            desk.change_job(|job| job.electrode.enter_from(number, side.into()));
        }
    }
}

/// Whether the electrode that is shown enters from `side`: the one that is chosen, or the one that the electrode in the
/// view is made for.
fn is_used(desk: &BliskDesk, side: EntrySide) -> bool {
    let (params, number) = (&desk.document.params().electrode, desk.cursor.electrode);
    match params.of_electrode(number).enter {
        EnterSide::Auto => {
            desk.reported_electrodes().get(number).is_some_and(|electrode| electrode.enters_from == side)
        }
        chosen => chosen.allows(side),
    }
}

/// Draws one arrow and tells whether it was clicked.
fn arrow(ui: &mut Ui, rect: Rect, [from, to]: [egui::Pos2; 2], (side, is_used): (EntrySide, bool)) -> bool {
    let area = Rect::from_two_pos(from, to).expand(NEAR).intersect(rect);
    if !area.is_positive() {
        return false;
    }
    let name = format!("Enter from {}", side.label());
    let response = ui.interact(area, ui.scope_id().with(("entry", side.label())), Sense::click());
    response.widget_info(|| WidgetInfo::selected(Role::RadioButton, true, is_used, &name));
    let colour = match (is_used, response.hovered()) {
        (_, true) => ui.visuals().strong_text_color(),
        (true, false) => palette(ui).accent,
        (false, false) => ui.visuals().text_color(),
    };
    let painter = ui.painter().with_clip_rect(rect);
    // On an edge and a label of their own, they are seen before the part as well.
    let (width, ground) = (if is_used { 3.0 } else { 1.5 }, ui.visuals().window_fill);
    painter.arrow(from, to - from, Stroke::new(width + 3.0, ground));
    painter.arrow(from, to - from, Stroke::new(width, colour));
    let galley = painter.layout_no_wrap(side.label().to_owned(), FontId::proportional(12.0), colour);
    let label = Rect::from_center_size(to + 14.0 * (to - from).normalized(), galley.size());
    painter.rect_filled(label.expand2(vec2(4.0, 1.0)), 3.0, ground.gamma_multiply(0.88));
    painter.galley(label.min, galley, colour);
    response.on_hover_text(name).clicked()
}
