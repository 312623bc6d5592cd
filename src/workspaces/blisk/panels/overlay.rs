//! What is drawn over the 3-D view: the row of view buttons, the axis gizmo, the section's slider, the verdict.

use egui::{Align2, Color32, FontId, Rect, RichText, Role, Sense, Ui, UiBuilder, WidgetInfo, pos2, vec2};
use glam::DVec3;

use super::viewport::Viewport;
use crate::shell::commands::Command;
use crate::shell::core::Core;
use crate::widgets::theme::palette;
use crate::workspaces::blisk::document::stage::Stage;
use crate::workspaces::blisk::pipeline::StageState;
use feed::simulation::Simulation;
use render::colour_map::{ColourMap, Legend};
use render::scene::SectionPlane;
use render::view::StandardView;

/// Draws all of it.
pub fn show(ui: &mut Ui, rect: Rect, core: &mut Core, viewport: &mut Viewport) {
    let views = [
        ("Fit", Command::Fit, false),
        ("Iso", Command::View(StandardView::Isometric), false),
        ("Front", Command::View(StandardView::Front), false),
        ("Right", Command::View(StandardView::Right), false),
        ("Top", Command::View(StandardView::Top), false),
        ("Channel", Command::IntoChannel, false),
        ("Blisk", Command::WholeBlisk, false),
        ("Section", Command::Section, core.section.is_some()),
        ("Measure", Command::Measure, core.measuring),
        ("Clearance", Command::Colours, core.colours),
    ];
    buttons(ui, rect, core, &views);
    gizmo(ui, rect, viewport);
    if core.section.is_some() {
        section(ui, rect, core);
        section_handle(ui, rect, core, viewport);
    }
    // Where there is no room for both, the status bar still says it.
    if core.section.is_none() || rect.height() > 300.0 {
        verdict(ui, rect, core);
    }
    measured(ui, rect, viewport, core);
    if let Some(shown) = core.leftover_legend().filter(|_| core.leftover) {
        legend(ui, rect, &shown);
    } else if core.colour_values().is_some() {
        legend(ui, rect, &core.colour_legend());
    }
}

/// The bar of colours with round values beside it and a mark at the value that counts, or at the middle of a map that has
/// one. Answers where it is.
pub fn legend(ui: &Ui, rect: Rect, legend: &Legend) -> Rect {
    let size = vec2(14.0, (rect.height() - 150.0).clamp(50.0, 180.0));
    let bar = Rect::from_min_size(pos2(rect.left() + 18.0, rect.top() + 78.0), size);
    let colours = palette(ui);
    let painter = ui.painter();
    let back = Rect::from_min_max(bar.min - vec2(8.0, 28.0), bar.max + vec2(74.0, 12.0));
    painter.rect_filled(back, 6.0, ui.visuals().window_fill.gamma_multiply(0.88));
    let title = format!("{} {}", legend.title, legend.unit);
    painter.text(
        bar.left_top() - vec2(0.0, 16.0),
        Align2::LEFT_CENTER,
        title,
        FontId::proportional(12.0),
        colours.faint,
    );
    let steps = 60;
    for i in 0..steps {
        let t = f64::from(i) / f64::from(steps - 1);
        let c = legend.map.at(t);
        let top = bar.bottom() - size.y * (i + 1) as f32 / steps as f32;
        let cell = Rect::from_min_size(pos2(bar.left(), top), vec2(size.x, size.y / steps as f32 + 0.5));
        painter.rect_filled(cell, 0.0, Color32::from_rgb(c.r, c.g, c.b));
    }
    let y = |value: f64| bar.bottom() - size.y * legend.place(value) as f32;
    // Enough decimals for a hundredth of the range.
    let decimals = (2.0 - (legend.max - legend.min).abs().max(1e-6).log10().ceil()).clamp(2.0, 5.0) as usize;
    for value in legend.ticks(if size.y < 100.0 { 2 } else { 5 }) {
        let at = pos2(bar.right() + 6.0, y(value));
        painter.text(
            at,
            Align2::LEFT_CENTER,
            format!("{value:.decimals$}"),
            FontId::monospace(11.0),
            ui.visuals().text_color(),
        );
    }
    if let Some(value) = legend.threshold {
        let line = egui::Stroke::new(2.0, ui.visuals().strong_text_color());
        painter.hline(bar.left() - 3.0..=bar.right() + 3.0, y(value), line);
        painter.text(
            pos2(bar.right() + 40.0, y(value)),
            Align2::LEFT_CENTER,
            "gap",
            FontId::proportional(11.0),
            colours.faint,
        );
    }
    if legend.map == ColourMap::Diverging {
        let line = egui::Stroke::new(1.5, Color32::from_gray(40));
        painter.hline(bar.left() - 3.0..=bar.right() + 3.0, y(0.5 * (legend.min + legend.max)), line);
    }
    back
}

/// A row of commands with their short names, and whether they are on.
pub fn buttons(ui: &mut Ui, rect: Rect, core: &mut Core, views: &[(&str, Command, bool)]) {
    let area = Rect::from_min_size(rect.min + vec2(8.0, 8.0), vec2((rect.width() - 120.0).max(60.0), 26.0));
    let mut child =
        ui.new_child(UiBuilder::new().max_rect(area).layout(egui::Layout::left_to_right(egui::Align::Center)));
    child.spacing_mut().item_spacing.x = 3.0;
    child.set_clip_rect(rect.intersect(ui.clip_rect()));
    let last = views.last().map_or("", |(name, ..)| name);
    let mut left = views.iter().copied().peekable();
    // What finds no room beside the axes is in a menu behind the rest.
    let needed = |name: &str, rest: f32| 12.0 + 8.0 * name.len() as f32 + rest;
    while let Some((name, command, on)) =
        left.next_if(|(name, ..)| child.available_width() > needed(name, if *name == last { 0.0 } else { 30.0 }))
    {
        view_button(&mut child, core, name, command, on);
    }
    if left.peek().is_some() {
        child.menu_button(RichText::new("…").size(12.0), |ui| {
            left.for_each(|(name, command, on)| view_button(ui, core, name, command, on));
        });
    }
}

fn view_button(ui: &mut Ui, core: &mut Core, name: &str, command: Command, on: bool) {
    let enabled = command.is_enabled(core);
    let button = egui::Button::new(RichText::new(name).size(12.0)).selected(on);
    if ui.add_enabled(enabled, button).on_hover_text(command.hint(ui.ctx())).clicked() {
        core.push(command);
    }
}

/// Middle of the three axes in the corner of a view.
fn gizmo_centre(rect: Rect) -> egui::Pos2 {
    pos2(rect.right() - 52.0, rect.top() + 52.0)
}

/// What the three axes cover of a view.
pub fn gizmo_area(rect: Rect) -> Rect {
    Rect::from_center_size(gizmo_centre(rect), vec2(92.0, 92.0))
}

/// Three axes that turn with the view; a click on an end looks from there.
pub fn gizmo(ui: &mut Ui, rect: Rect, viewport: &mut Viewport) {
    const RADIUS: f32 = 34.0;
    let centre = gizmo_centre(rect);
    let rotation = viewport.camera().0.view_rotation();
    let colours = palette(ui).axes;
    let mut ends: Vec<(DVec3, &str, Color32)> = Vec::new();
    for (i, (axis, name)) in [(DVec3::X, "X"), (DVec3::Y, "Y"), (DVec3::Z, "Z")].into_iter().enumerate() {
        ends.push((axis, name, colours[i]));
        ends.push((-axis, "", colours[i]));
    }
    ends.sort_by(|a, b| (rotation * a.0).z.total_cmp(&(rotation * b.0).z));
    for (axis, name, colour) in ends {
        let seen = rotation * axis;
        let at = centre + RADIUS * vec2(seen.x as f32, -seen.y as f32);
        let size = if name.is_empty() { 6.0 } else { 8.5 };
        let hit = Rect::from_center_size(at, vec2(18.0, 18.0));
        let label = format!("View from {}{}", if name.is_empty() { "-" } else { "+" }, letter(axis));
        let response = ui.interact(hit, ui.scope_id().with(("gizmo", &label)), Sense::click());
        response.widget_info(|| WidgetInfo::labeled(Role::Button, true, &label));
        let strength = if response.hovered() { 1.0 } else { (0.55 + 0.45 * seen.z).clamp(0.35, 1.0) as f32 };
        if name.is_empty() {
            ui.painter().circle(
                at,
                size,
                ui.visuals().panel_fill,
                egui::Stroke::new(1.5, colour.gamma_multiply(strength)),
            );
        } else {
            ui.painter().line_segment([centre, at], egui::Stroke::new(2.0, colour.gamma_multiply(strength)));
            ui.painter().circle_filled(at, size, colour.gamma_multiply(strength));
            let ink = if ui.visuals().dark_mode { Color32::BLACK } else { Color32::WHITE };
            ui.painter().text(at, Align2::CENTER_CENTER, name, FontId::proportional(11.0), ink);
        }
        if response.on_hover_text(label).clicked() {
            viewport.turn_to(axis, ui.input(|i| i.time));
        }
    }
}

fn letter(axis: DVec3) -> char {
    let i = axis.abs().to_array().iter().position(|v| *v > 0.5).unwrap_or(0);
    ['X', 'Y', 'Z'][i]
}

/// Where the cut is and which way it looks.
fn section(ui: &mut Ui, rect: Rect, core: &mut Core) {
    const WIDTH: f32 = 400.0;
    let width = (rect.width() - 16.0).min(WIDTH);
    let area = Rect::from_min_size(rect.left_bottom() + vec2(8.0, -40.0), vec2(width, 30.0));
    let mut child =
        ui.new_child(UiBuilder::new().max_rect(area).layout(egui::Layout::left_to_right(egui::Align::Center)));
    child.spacing_mut().slider_width = (100.0 - (WIDTH - width)).max(24.0);
    child.painter().rect_filled(area, 5.0, child.visuals().window_fill.gamma_multiply(0.92));
    child.add_space(8.0);
    let Some(part) = core.pipeline.part().cloned() else { return };
    let bounds = part.shape.bounds();
    let Some(plane) = &mut core.section else { return };
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
        core.section = None;
    }
}

/// A knob in the middle of the cut that moves it along its normal.
fn section_handle(ui: &mut Ui, rect: Rect, core: &mut Core, viewport: &Viewport) {
    let Some(plane) = &mut core.section else { return };
    let (camera, size) = viewport.camera();
    let seen = |p: DVec3| camera.project(p, size).map(|s| s.pixel / f64::from(ui.pixels_per_point()));
    let reach = 0.04 * camera.visible_height();
    let (Some(at), Some(tip)) = (seen(plane.point), seen(plane.point + plane.normal * reach)) else { return };
    let [at, tip] = [at, tip].map(|p| rect.min + vec2(p.x as f32, p.y as f32));
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
fn answer(ui: &Ui, core: &Core) -> Option<(Color32, String)> {
    let (plan, outcome, colours) = (core.pipeline.plan()?, core.outcome()?, palette(ui));
    let verdict = || outcome.plan.verdict(&plan.channel);
    let collision = plan.finishing().and_then(|finishing| finishing.collision()).map(Simulation::sentence);
    Some(match (core.pipeline.state(Stage::Plan), core.pipeline.state(Stage::Verify)) {
        (StageState::Running, _) => return None,
        (StageState::Stale, _) => (colours.warning, format!("out of date: {}", collision.unwrap_or_else(verdict))),
        (StageState::Done, _) if collision.is_some() => (colours.bad, collision.unwrap_or_default()),
        _ if !outcome.plan.is_verified() => (colours.bad, verdict()),
        (StageState::Done, StageState::Running) => {
            (colours.accent, format!("{}; its motion on the machine is being simulated", verdict()))
        }
        (StageState::Done, StageState::Failed(_)) if plan.may_be_approved() => {
            (colours.warning, format!("{}; its motion on the machine is not known", verdict()))
        }
        _ => (colours.good, verdict()),
    })
}

/// The answer in one line at the bottom of the view.
fn verdict(ui: &mut Ui, rect: Rect, core: &Core) {
    let Some((colour, text)) = answer(ui, core) else { return };
    let above = if core.section.is_some() { 50.0 } else { 10.0 };
    caption(ui, rect, above, colour, &super::stepper::sentence(&text));
}

/// A framed sentence so far `above` the bottom of the view (points).
pub fn caption(ui: &mut Ui, rect: Rect, above: f32, colour: Color32, text: &str) {
    let width = (rect.width() - 140.0).max(120.0);
    let galley = ui.painter().layout(text.to_owned(), FontId::proportional(13.0), colour, width);
    let size = galley.size() + vec2(20.0, 10.0);
    let area = Rect::from_min_size(pos2(rect.center().x - 0.5 * size.x, rect.bottom() - size.y - above), size);
    ui.painter().rect_filled(area, 6.0, ui.visuals().window_fill.gamma_multiply(0.92));
    ui.painter().rect_stroke(area, 6.0, egui::Stroke::new(1.0, colour), egui::StrokeKind::Inside);
    ui.painter().galley(area.min + vec2(10.0, 5.0), galley, colour);
    let response = ui.interact(area, ui.scope_id().with("verdict"), Sense::hover());
    response.widget_info(|| WidgetInfo::labeled(Role::Label, true, text));
}

/// A ring around a place in the view at `at`, and what is said of it beside, where there is room.
pub fn callout(ui: &mut Ui, rect: Rect, at: egui::Pos2, colour: Color32, text: &str) {
    /// Radius of the ring, and how far off the words are (points).
    const RING: f32 = 12.0;
    const OFF: egui::Vec2 = vec2(30.0, -34.0);
    let ink = ui.visuals().strong_text_color();
    let width = (0.5 * rect.width() - 40.0).clamp(100.0, 260.0);
    let galley = ui.painter().layout(text.to_owned(), FontId::proportional(12.0), ink, width);
    let size = galley.size() + vec2(16.0, 8.0);
    // Beside the handles at the edges.
    let is_right = at.x + OFF.x + size.x < rect.right() - 16.0;
    let corner = if is_right { at + OFF } else { at + vec2(-OFF.x - size.x, OFF.y) };
    // Below the row of buttons and above the strips.
    let [top, bottom] = [rect.top() + 44.0, rect.bottom() - size.y - 120.0];
    let area = Rect::from_min_size(pos2(corner.x.max(rect.left() + 16.0), corner.y.clamp(top, bottom.max(top))), size);
    let painter = ui.painter_at(rect);
    let edge = pos2(if is_right { area.left() } else { area.right() }, area.center().y);
    let stroke = egui::Stroke::new(1.5, colour);
    painter.line_segment([at + RING * (edge - at).normalized(), edge], stroke);
    painter.circle_stroke(at, RING, egui::Stroke::new(2.0, colour));
    painter.rect_filled(area, 4.0, ui.visuals().window_fill.gamma_multiply(0.94));
    painter.rect_stroke(area, 4.0, stroke, egui::StrokeKind::Inside);
    painter.galley(area.min + vec2(8.0, 4.0), galley, ink);
    let response = ui.interact(area, ui.scope_id().with("callout"), Sense::hover());
    response.widget_info(|| WidgetInfo::labeled(Role::Label, true, text));
}

/// The measured distance beside its line.
fn measured(ui: &Ui, rect: Rect, viewport: &Viewport, core: &Core) {
    let Some(super::viewport::Probe::Distance { from, to }) = viewport.probe() else { return };
    let (camera, size) = viewport.camera();
    let Some(seen) = camera.project((*from + *to) * 0.5, size) else { return };
    let p = seen.pixel / f64::from(ui.pixels_per_point());
    let at = rect.min + vec2(p.x as f32, p.y as f32);
    let text = core.preferences.length.show((*to - *from).length(), 3);
    let galley = ui.painter().layout_no_wrap(text, FontId::proportional(13.0), ui.visuals().strong_text_color());
    let area = Rect::from_center_size(at, galley.size() + vec2(12.0, 6.0));
    ui.painter().rect_filled(area, 4.0, ui.visuals().window_fill);
    ui.painter().galley(area.min + vec2(6.0, 3.0), galley, Color32::WHITE);
}
