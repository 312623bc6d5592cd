//! A timeline: a strip with marks, numbers, and a pin to drag.

use egui::{
    Align2, EventFilter, FontId, Key, Painter, Rect, Response, Sense, Shape, Stroke, Ui, WidgetInfo, pos2, vec2,
};

use super::theme::{Palette, palette};

/// A strip over the available width.
pub struct Strip {
    /// Place of the strip in the window.
    pub rect: Rect,
    /// Painter of the strip.
    pub painter: Painter,
    response: Response,
    colours: &'static Palette,
}

impl Strip {
    /// An empty strip of this `height` (points), called `name`, with the present value and whether it can be changed.
    pub fn new(ui: &mut Ui, height: f32, name: &str, (value, is_enabled): (f64, bool)) -> Self {
        let (rect, response) = ui.allocate_exact_size(vec2(ui.available_width(), height), Sense::click_and_drag());
        response.widget_info(|| WidgetInfo::slider(is_enabled, value, name));
        let painter = ui.painter_at(rect);
        painter.rect_filled(rect, 4.0, ui.visuals().extreme_bg_color);
        Self { rect, painter, response, colours: palette(ui) }
    }

    /// Usual inner part of the strip.
    pub fn inner(&self) -> Rect {
        self.rect.shrink2(vec2(12.0, 0.0))
    }

    /// Shows why the strip is empty.
    pub fn say(&self, text: &str) {
        let font = FontId::proportional(12.0);
        self.painter.text(self.rect.center(), Align2::CENTER_CENTER, text, font, self.colours.faint);
    }

    /// Writes a number of the scale at `x`.
    pub fn number(&self, x: f32, text: String) {
        let at = pos2(x, self.rect.top() + 8.0);
        self.painter.text(at, Align2::CENTER_CENTER, text, FontId::proportional(10.0), self.colours.faint);
    }

    /// Marks a place at `x`, `above` points over the bottom: as a warning, or as a fault unless it `holds`.
    pub fn mark(&self, x: f32, above: f32, holds: bool) {
        let tip = pos2(x, self.rect.bottom() - above);
        let triangle = vec![tip, tip + vec2(-4.0, -6.0), tip + vec2(4.0, -6.0)];
        let colour = if holds { self.colours.warning } else { self.colours.bad };
        self.painter.add(Shape::convex_polygon(triangle, colour, Stroke::NONE));
    }

    /// Draws the pin at `x`, with its head of this radius at the height `y`.
    pub fn pin(&self, x: f32, y: f32, radius: f32) {
        self.painter.vline(x, self.rect.y_range(), Stroke::new(2.0, self.colours.accent));
        self.painter.circle_filled(pos2(x, y), radius, self.colours.accent);
    }

    /// Position to which the pin is dragged, from 0 on the left of `inner` to 1 on its right.
    pub fn dragged(&self, inner: Rect) -> Option<f64> {
        let pointer = self.response.interact_pointer_pos()?;
        Some(f64::from((pointer.x - inner.left()) / inner.width()).clamp(0.0, 1.0))
    }

    /// Keeps the stepping keys while the strip has the focus, which they would otherwise move. Escape releases the
    /// focus.
    pub fn keep_keys(&self, ui: &Ui) {
        if self.response.has_focus() {
            let lock = EventFilter { horizontal_arrows: true, ..Default::default() };
            ui.memory_mut(|m| m.set_focus_lock_filter(self.response.id, lock));
            if ui.input(|i| i.key_pressed(Key::Escape)) {
                self.response.surrender_focus();
            }
        }
    }
}
