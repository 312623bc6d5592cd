//! Overlays of the 3-D view: the row of view buttons, the axes, the slider of the section, the verdict.

use crate::workspaces::blisk::commands::BliskCommand;
use crate::workspaces::blisk::desk::BliskDesk;
use crate::workspaces::commands::CommandSet;
use crate::workspaces::context::{Context, standard_views};
use egui::{Color32, FontId, Rect, RichText, Role, Sense, Ui, UiBuilder, WidgetInfo, vec2};
use glam::DVec3;

use super::view::{BliskView, Probe};
use crate::widgets::overlay::{callout, caption, gizmo, legend, swatches};
use crate::widgets::panel_parts::{grouped, sentence};
use crate::widgets::theme::{color32, palette};
use crate::widgets::viewport::Viewport;
use crate::workspaces::blisk::document::job_file::field_table::FIELDS;
use crate::workspaces::blisk::document::stage::Stage;
use crate::workspaces::blisk::scene::surfaces::{SurfaceMap, class_colour};
use feed::simulation::Simulation;
use render::scene::SectionPlane;
use task::State;
use wheel::surfaces::ClassArea;

/// Draws all of it.
pub fn show(ui: &mut Ui, rect: Rect, desk: &mut BliskDesk, cx: &mut Context, view: &mut BliskView) {
    let mut views = standard_views();
    views.extend([
        ("Channel", BliskCommand::IntoChannel.command(), false),
        ("Blisk", BliskCommand::WholeBlisk.command(), false),
        ("Section", BliskCommand::Section.command(), desk.section.is_some()),
        ("Measure", BliskCommand::Measure.command(), desk.measuring),
        ("Clearance", BliskCommand::Colours.command(), desk.colours),
        ("Surfaces", BliskCommand::Surfaces.command(), desk.surfaces),
    ]);
    super::entry_arrows::show(ui, rect, desk, &view.viewport);
    cx.view_buttons(ui, rect, desk, &views);
    gizmo(ui, rect, &mut view.viewport);
    if desk.section.is_some() {
        section(ui, rect, desk);
        section_handle(ui, rect, desk, &view.viewport);
    }
    refusal(ui, rect, desk, &view.viewport);
    // Where there is no room for both, the status bar still says it.
    if let Some(of) = desk.picking() {
        let above = if desk.section.is_some() { 50.0 } else { 10.0 };
        let text = format!("{} Backspace removes the last point, Esc ends.", of.asks());
        caption(ui, rect, above, palette(ui).accent, &text);
    } else if desk.section.is_none() || rect.height() > 300.0 {
        verdict(ui, rect, desk);
    }
    measured(ui, rect, view, cx);
    if let Some(shown) = desk.map_legend() {
        legend(ui, rect, &shown);
    } else if desk.colour_values().is_some() {
        legend(ui, rect, &desk.colour_legend());
    } else if let Some(map) = desk.surface_map().cloned() {
        surfaces(ui, rect, &map);
    }
}

/// The place where the channel was refused.
fn refusal(ui: &mut Ui, rect: Rect, desk: &BliskDesk, viewport: &Viewport) {
    let Some(at) = desk.refused_at().and_then(|at| viewport.seen_at(ui, rect, at)) else { return };
    if rect.shrink(12.0).contains(at) {
        callout(ui, rect, at, palette(ui).bad, "Refused here");
    }
}

/// The classes of surfaces with their colours and areas, and the radii of fillets.
fn surfaces(ui: &mut Ui, rect: Rect, map: &SurfaceMap) {
    let entry = |area: &ClassArea| {
        (
            color32(class_colour(area.class)),
            sentence(&area.name),
            format!("{} mm²", grouped(area.area_mm2.round() as usize)),
        )
    };
    let entries: Vec<_> = map.areas.iter().map(entry).collect();
    let radii = [("hub", map.fillets_mm[0]), ("shroud", map.fillets_mm[1])];
    let radius = |(at, radius): (&str, Option<f64>)| Some(format!("Fillets at the {at}: radius {:.2} mm", radius?));
    let notes: Vec<String> = radii.into_iter().filter_map(radius).collect();
    swatches(ui, rect, &entries, &notes);
}

/// Position and direction of the section.
fn section(ui: &mut Ui, rect: Rect, desk: &mut BliskDesk) {
    const WIDTH: f32 = 400.0;
    let width = (rect.width() - 16.0).min(WIDTH);
    let area = Rect::from_min_size(rect.left_bottom() + vec2(8.0, -40.0), vec2(width, 30.0));
    let mut child =
        ui.new_child(UiBuilder::new().max_rect(area).layout(egui::Layout::left_to_right(egui::Align::Center)));
    child.spacing_mut().slider_width = (100.0 - (WIDTH - width)).max(24.0);
    child.painter().rect_filled(area, 5.0, child.visuals().window_fill.gamma_multiply(0.92));
    child.add_space(8.0);
    let Some(part) = desk.work.part().cloned() else { return };
    let bounds = part.shape.bounds();
    let Some(plane) = &mut desk.section else { return };
    for (name, axis) in [("X", DVec3::X), ("Y", DVec3::Y), ("Z", DVec3::Z)] {
        let on = plane.normal.dot(axis).abs() > 0.9;
        if child.selectable_label(on, name).on_hover_text(format!("Cut across {name}")).clicked() {
            *plane = SectionPlane { point: bounds.center(), normal: axis };
        }
    }
    if child.button("Turn").on_hover_text("Cut away the other side").clicked() {
        plane.normal = -plane.normal;
    }
    let axis = plane.normal.abs();
    let mut at = plane.point.dot(axis);
    let range = bounds.min.dot(axis)..=bounds.max.dot(axis);
    let label = child.label(RichText::new("at").color(palette(&child).faint));
    let slider = egui::Slider::new(&mut at, range).suffix(" mm").max_decimals(2);
    if child.add(slider).labelled_by(label.id).changed() {
        plane.point += axis * (at - plane.point.dot(axis));
    }
    if child.button("Close").clicked() {
        desk.section = None;
    }
}

/// A knob in the middle of the cut that moves it along its normal.
fn section_handle(ui: &mut Ui, rect: Rect, desk: &mut BliskDesk, viewport: &Viewport) {
    let Some(plane) = &mut desk.section else { return };
    let seen = |p: DVec3| viewport.seen_at(ui, rect, p);
    let reach = 0.04 * viewport.camera().0.visible_height();
    let (Some(at), Some(tip)) = (seen(plane.point), seen(plane.point + plane.normal * reach)) else { return };
    if !rect.shrink(10.0).contains(at) {
        return;
    }
    let response = ui.interact(Rect::from_center_size(at, vec2(22.0, 22.0)), ui.scope_id().with("cut"), Sense::drag());
    response.widget_info(|| WidgetInfo::labeled(Role::Slider, true, "Move the section plane"));
    let colour = if response.hovered() || response.dragged() { palette(ui).accent } else { ui.visuals().text_color() };
    ui.painter().arrow(at, tip - at, egui::Stroke::new(2.0, colour));
    ui.painter().circle(at, 6.0, ui.visuals().window_fill, egui::Stroke::new(2.0, colour));
    let along = tip - at;
    if response.dragged() && along.length_sq() > 4.0 {
        let share = response.drag_delta().dot(along) / along.length_sq();
        plane.point += plane.normal * (reach * f64::from(share));
    }
}

/// The answer of the plan, and of the check of its motion on the machine, and its colour.
fn answer(ui: &Ui, desk: &BliskDesk) -> Option<(Color32, String)> {
    let (plan, outcome, colours) = (desk.work.plan()?, desk.outcome()?, palette(ui));
    let verdict = || FIELDS.labelled(&outcome.plan.verdict(&plan.channel));
    let collision = plan.finishing().and_then(|finishing| finishing.collision()).map(Simulation::sentence);
    Some(match (desk.work.state(Stage::Plan), desk.work.state(Stage::Verify)) {
        (State::Running, _) => return None,
        (State::Stale, _) => (colours.warning, format!("out of date: {}", collision.unwrap_or_else(verdict))),
        (State::Ready, _) if collision.is_some() => (colours.bad, collision.unwrap_or_default()),
        _ if !outcome.plan.is_verified() => (colours.bad, verdict()),
        (State::Ready, State::Running) => {
            (colours.accent, format!("{}; its motion on the machine is being simulated", verdict()))
        }
        (State::Ready, State::Failed(_)) if plan.may_be_approved() => {
            (colours.warning, format!("{}; its motion on the machine is not known", verdict()))
        }
        _ => (colours.good, verdict()),
    })
}

/// What in the view belongs to earlier parameters, if anything does.
fn earlier(desk: &BliskDesk) -> Option<&'static str> {
    match desk.work.is_earlier() {
        [true, true] => Some("channel and electrode"),
        [true, false] => Some("channel"),
        [false, true] => Some("electrode"),
        [false, false] => None,
    }
}

/// The answer, or what is out of date, in one line at the bottom of the view.
fn verdict(ui: &mut Ui, rect: Rect, desk: &BliskDesk) {
    let earlier = || Some((palette(ui).warning, format!("out of date: {} of earlier parameters", earlier(desk)?)));
    let Some((colour, text)) = answer(ui, desk).or_else(earlier) else { return };
    let above = if desk.section.is_some() { 50.0 } else { 10.0 };
    caption(ui, rect, above, colour, &sentence(&text));
}

/// The measured distance beside its line.
fn measured(ui: &Ui, rect: Rect, view: &BliskView, cx: &Context) {
    let Some(Probe::Distance { from, to }) = view.probe() else { return };
    let Some(at) = view.viewport.seen_at(ui, rect, (*from + *to) * 0.5) else { return };
    let text = cx.preferences.length.show((*to - *from).length(), 3);
    let galley = ui.painter().layout_no_wrap(text, FontId::proportional(13.0), ui.visuals().strong_text_color());
    let area = Rect::from_center_size(at, galley.size() + vec2(12.0, 6.0));
    ui.painter().rect_filled(area, 4.0, ui.visuals().window_fill);
    ui.painter().galley(area.min + vec2(6.0, 3.0), galley, Color32::WHITE);
}
