//! Overlays of every 3-D view: a row of buttons, the three axes, the legend of colours, captions, and the handles that
//! fold the panels beside the view.

use egui::{Align2, Color32, FontId, Rect, RichText, Role, Sense, Ui, UiBuilder, WidgetInfo, pos2, vec2};
use glam::DVec3;

use super::theme::{color32, palette};
use super::viewport::Viewport;
use render::colour_map::{ColourMap, Legend};

/// The legend of colours with round values beside it, and a mark at the limit, or at the middle of a symmetric map.
/// Returns its rectangle.
pub fn legend(ui: &Ui, rect: Rect, legend: &Legend) -> Rect {
    let size = vec2(14.0, (rect.height() - 150.0).clamp(50.0, 180.0));
    let bar = Rect::from_min_size(pos2(rect.left() + 18.0, rect.top() + 78.0), size);
    let colours = palette(ui);
    let painter = ui.painter();
    let title =
        if legend.unit.is_empty() { legend.title.clone() } else { format!("{} ({})", legend.title, legend.unit) };
    let title = painter.layout_no_wrap(title, FontId::proportional(12.0), colours.faint);
    // As wide as its title, or its numbers.
    let beside = (title.size().x + 8.0 - size.x).max(74.0);
    let back = Rect::from_min_max(bar.min - vec2(8.0, 28.0), bar.max + vec2(beside, 12.0));
    painter.rect_filled(back, 6.0, ui.visuals().window_fill.gamma_multiply(0.88));
    painter.galley(bar.left_top() - vec2(0.0, 16.0 + 0.5 * title.size().y), title, colours.faint);
    let steps = 60;
    for i in 0..steps {
        let t = f64::from(i) / f64::from(steps - 1);
        let c = legend.map.at(t);
        let top = bar.bottom() - size.y * (i + 1) as f32 / steps as f32;
        let cell = Rect::from_min_size(pos2(bar.left(), top), vec2(size.x, size.y / steps as f32 + 0.5));
        painter.rect_filled(cell, 0.0, color32(c));
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

/// A legend of single colours: name and figure of each, and notes below.
pub fn swatches(ui: &mut Ui, rect: Rect, entries: &[(Color32, String, String)], notes: &[String]) {
    const WIDTH: f32 = 260.0;
    let least = rect.min + vec2(10.0, 46.0);
    let area = Rect::from_min_max(least, pos2((least.x + WIDTH).min(rect.right()), rect.bottom() - 60.0));
    let mut child = ui.new_child(UiBuilder::new().max_rect(area).layout(egui::Layout::top_down(egui::Align::Min)));
    child.set_clip_rect(area.intersect(ui.clip_rect()));
    let fill = child.visuals().window_fill.gamma_multiply(0.88);
    egui::Frame::new().fill(fill).corner_radius(6).inner_margin(8).show(&mut child, |ui| {
        ui.spacing_mut().item_spacing = vec2(8.0, 2.0);
        egui::Grid::new("swatches").num_columns(3).min_col_width(12.0).show(ui, |ui| {
            for (colour, name, figure) in entries {
                let (dot, _) = ui.allocate_exact_size(vec2(12.0, 14.0), Sense::hover());
                ui.painter().rect_filled(dot.shrink2(vec2(0.0, 1.0)), 2.0, *colour);
                ui.label(RichText::new(name).size(12.0));
                ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                    ui.label(RichText::new(figure).size(12.0).color(palette(ui).faint));
                });
                ui.end_row();
            }
        });
        for note in notes {
            ui.label(RichText::new(note).size(12.0).color(palette(ui).faint));
        }
    });
}

/// A button over the view.
pub struct ViewButton {
    /// Short name.
    pub name: &'static str,
    /// Help text: the effect of the button, with its keys.
    pub hint: String,
    /// Whether the button can be pressed.
    pub is_enabled: bool,
    /// Whether the button is on.
    pub is_on: bool,
}

/// A row of buttons. Returns the index of the pressed one.
pub fn buttons(ui: &mut Ui, rect: Rect, views: &[ViewButton]) -> Option<usize> {
    let area = Rect::from_min_size(rect.min + vec2(8.0, 8.0), vec2((rect.width() - 120.0).max(60.0), 26.0));
    let mut child =
        ui.new_child(UiBuilder::new().max_rect(area).layout(egui::Layout::left_to_right(egui::Align::Center)));
    child.spacing_mut().item_spacing.x = 3.0;
    child.set_clip_rect(rect.intersect(ui.clip_rect()));
    let last = views.len().saturating_sub(1);
    let mut left = views.iter().enumerate().peekable();
    let mut pressed = None;
    // What finds no room beside the axes is in a menu behind the rest.
    let needed = |name: &str, rest: f32| 12.0 + 8.0 * name.len() as f32 + rest;
    while let Some((i, view)) =
        left.next_if(|(i, view)| child.available_width() > needed(view.name, if *i == last { 0.0 } else { 30.0 }))
    {
        pressed = view_button(&mut child, view).then_some(i).or(pressed);
    }
    if left.peek().is_some() {
        child.menu_button(RichText::new("…").size(12.0), |ui| {
            for (i, view) in left {
                pressed = view_button(ui, view).then_some(i).or(pressed);
            }
        });
    }
    pressed
}

fn view_button(ui: &mut Ui, view: &ViewButton) -> bool {
    let button = egui::Button::new(RichText::new(view.name).size(12.0)).selected(view.is_on);
    ui.add_enabled(view.is_enabled, button).on_hover_text(&view.hint).clicked()
}

/// Middle of the three axes in the corner of a view.
fn gizmo_centre(rect: Rect) -> egui::Pos2 {
    pos2(rect.right() - 52.0, rect.top() + 52.0)
}

/// Rectangle of the three axes in a view.
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

/// Hints in the middle of an empty view: a title and lines below.
pub fn empty(ui: &Ui, rect: Rect, title: &str, lines: &[&str]) {
    let (above, below) = if lines.len() > 1 { (40.0, 0.0) } else { (24.0, 8.0) };
    let (c, painter) = (rect.center(), ui.painter());
    painter.text(c - vec2(0.0, above), Align2::CENTER_CENTER, title, FontId::proportional(22.0), palette(ui).accent);
    for (i, line) in lines.iter().enumerate() {
        let at = pos2(c.x, c.y + below + 20.0 * i as f32);
        painter.text(at, Align2::CENTER_CENTER, line, FontId::proportional(13.5), Color32::from_gray(150));
    }
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

/// A ring around the place `at` of the view, with a text beside it where there is room.
pub fn callout(ui: &mut Ui, rect: Rect, at: egui::Pos2, colour: Color32, text: &str) {
    /// Radius of the ring, and distance of the text (points).
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

/// A panel beside the view that folds.
pub struct Folding<'a> {
    /// Whether the panel is on the left.
    pub is_left: bool,
    /// Whether the panel is open.
    pub is_there: bool,
    /// Name of the handle.
    pub name: &'a str,
    /// Tooltip: the name with the shortcut.
    pub hint: String,
}

/// Draws the handles over the view in `rect`. Returns the index of the clicked one.
pub fn folds(ui: &mut Ui, rect: Rect, panels: &[Folding]) -> Option<usize> {
    const SIZE: egui::Vec2 = vec2(12.0, 46.0);
    let inwards = vec2(0.5 * SIZE.x, 0.0);
    let mut clicked = None;
    for (i, panel) in panels.iter().enumerate() {
        let at = if panel.is_left { rect.left_center() + inwards } else { rect.right_center() - inwards };
        if fold_handle(ui, Rect::from_center_size(at, SIZE), panel) {
            clicked = Some(i);
        }
    }
    clicked
}

/// A handle of a panel, which points in the direction of its motion. Returns whether it was clicked.
fn fold_handle(ui: &mut Ui, rect: Rect, panel: &Folding) -> bool {
    let response = ui.interact(rect, ui.scope_id().with(("fold", panel.name)), Sense::click());
    response.widget_info(|| WidgetInfo::labeled(Role::Button, true, panel.name));
    let visuals = ui.visuals();
    let (fill, ink) = if response.hovered() {
        (visuals.widgets.hovered.weak_bg_fill, visuals.strong_text_color())
    } else {
        (visuals.window_fill.gamma_multiply(0.88), palette(ui).faint)
    };
    ui.painter().rect_filled(rect, 3.0, fill);
    let points_right = panel.is_left != panel.is_there;
    let sign = if points_right { "\u{23f5}" } else { "\u{23f4}" };
    ui.painter().text(rect.center(), Align2::CENTER_CENTER, sign, FontId::proportional(10.0), ink);
    response.on_hover_text(&panel.hint).clicked()
}
