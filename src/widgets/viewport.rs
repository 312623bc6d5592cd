//! The 3-D view: its camera, and the mouse actions.

use std::sync::Arc;
use std::time::Duration;

use egui::{PointerButton, Pos2, Rect, Response, Sense, Ui, vec2};
use glam::{DVec2, DVec3};
use serde::{Deserialize, Serialize};

use crate::widgets::camera::{bodies, standard};
use crate::widgets::viewport_gpu::Picture;
use geometry::mesh::Bounds;
use render::camera::{Camera, OrbitStyle, Projection};
use render::pick::{Pick, pick};
use render::renderer::Quality;
use render::scene::Scene;
use render::view::StandardView;

/// Duration of a change of view (s).
const FLIGHT: f64 = 0.25;
/// Delay after the last movement until the view is drawn in full quality (s).
const REST: f64 = 0.16;

/// Source of a scene. It is held, because another object might otherwise get its address.
#[derive(Debug)]
pub struct Source<T>(pub Option<Arc<T>>);

impl<T> PartialEq for Source<T> {
    fn eq(&self, other: &Self) -> bool {
        match (&self.0, &other.0) {
            (Some(one), Some(other)) => Arc::ptr_eq(one, other),
            (one, other) => one.is_none() && other.is_none(),
        }
    }
}

/// Motion in the scene.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Moves {
    /// No motion.
    Nothing,
    /// A motion is played.
    Playing,
    /// The scene follows a search.
    Searching,
}

/// Mouse buttons of the 3-D view. The wheel zooms to the cursor in every preset.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Navigation {
    /// Left turns, middle or Shift + left moves.
    Cad,
    /// Middle turns, Shift + middle moves.
    Blender,
}

impl Navigation {
    /// The preset in words.
    pub fn describe(self) -> &'static str {
        match self {
            Self::Cad => "left turns, middle or Shift + left moves, wheel zooms",
            Self::Blender => "middle turns, Shift + middle moves, wheel zooms",
        }
    }
}

/// State of the view.
pub struct Viewport {
    camera: Camera,
    flight: Option<(Camera, Camera, f64)>,
    size: [u32; 2],
    pivot: DVec3,
    /// The time of the last frame (s).
    now: f64,
    /// Time of the last movement (s).
    moved: Option<f64>,
    scene: Arc<Scene>,
    fitted_to: Option<usize>,
}

impl Default for Viewport {
    fn default() -> Self {
        Self {
            camera: Camera::default(),
            flight: None,
            size: [1, 1],
            pivot: DVec3::ZERO,
            now: 0.0,
            moved: None,
            scene: Arc::default(),
            fitted_to: None,
        }
    }
}

impl Viewport {
    /// The scene and its camera.
    pub fn picture(&self) -> (&Arc<Scene>, &Camera) {
        (&self.scene, &self.camera)
    }

    /// Draws `scene`, and fits it into the view when `fitted_to` changes. Returns the rectangle of the view, and the
    /// click if there was one, with what it met.
    pub fn show(
        &mut self,
        ui: &mut Ui,
        navigation: Navigation,
        scene: &Arc<Scene>,
        (fitted_to, moves): (usize, Moves),
    ) -> (Rect, Option<Option<Pick>>) {
        let (rect, response) = ui.allocate_exact_size(ui.available_size(), Sense::click_and_drag());
        response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, "3D viewport"));
        let scale = ui.pixels_per_point();
        self.size = [rect.width(), rect.height()].map(|s| (s * scale).round().max(1.0) as u32);
        self.scene = scene.clone();
        self.now = ui.input(|i| i.time);
        if self.fitted_to != Some(fitted_to) {
            self.fitted_to = Some(fitted_to);
            self.fit(true);
        }
        self.navigate(ui, &response, navigation);
        let at = response.interact_pointer_pos().filter(|_| response.clicked());
        let clicked = at.map(|at| pick(&self.scene, &self.camera, self.pixel(ui, rect, at), self.size));
        self.fly(ui);
        let quality = self.quality(ui, moves);
        let picture = Picture { scene: self.scene.clone(), camera: self.camera, size: self.size, quality };
        ui.painter().add(eframe::egui_wgpu::Callback::new_paint_callback(rect, picture));
        (rect, clicked)
    }

    fn pixel(&self, ui: &Ui, rect: Rect, at: Pos2) -> DVec2 {
        let p = (at - rect.min) * ui.pixels_per_point();
        DVec2::new(p.x.into(), p.y.into())
    }

    /// Position of the point `at` in the view, which fills `rect`; none behind the camera.
    pub fn seen_at(&self, ui: &Ui, rect: Rect, at: DVec3) -> Option<Pos2> {
        let p = self.camera.project(at, self.size)?.pixel / f64::from(ui.pixels_per_point());
        Some(rect.min + vec2(p.x as f32, p.y as f32))
    }

    fn navigate(&mut self, ui: &Ui, response: &Response, navigation: Navigation) {
        let shift = ui.input(|i| i.modifiers.shift);
        let dragged = |button| response.dragged_by(button);
        let (turn, pan) = match navigation {
            Navigation::Cad => (
                dragged(PointerButton::Primary) && !shift,
                dragged(PointerButton::Middle)
                    || dragged(PointerButton::Secondary)
                    || (dragged(PointerButton::Primary) && shift),
            ),
            Navigation::Blender => {
                let middle = dragged(PointerButton::Middle) || dragged(PointerButton::Primary);
                (middle && !shift, middle && shift)
            }
        };
        if response.drag_started() {
            let under = response.interact_pointer_pos().map(|p| self.pixel(ui, response.rect, p));
            let picked = under.and_then(|p| pick(&self.scene, &self.camera, p, self.size));
            self.pivot = picked.map_or(self.camera.target, |p| p.point);
            response.request_focus();
            response.surrender_focus();
        }
        let delta = response.drag_delta() * ui.pixels_per_point();
        let delta = DVec2::new(delta.x.into(), delta.y.into());
        if turn && delta != DVec2::ZERO {
            self.camera.orbit(delta, self.size[1], OrbitStyle::Turntable, self.pivot);
            self.has_moved();
        } else if pan && delta != DVec2::ZERO {
            self.camera.pan(delta, self.size);
            self.has_moved();
        }
        if let Some(at) = response.hover_pos() {
            let (scroll, pinch) = ui.input(|i| (i.smooth_scroll_delta().y, i.zoom_delta()));
            let factor = f64::from((scroll * 0.0035).exp() * pinch);
            if (factor - 1.0).abs() > 1e-6 {
                self.camera.zoom(factor, self.pixel(ui, response.rect, at), self.size);
                self.has_moved();
            }
        }
        if response.double_clicked() {
            self.fit(true);
        }
    }

    fn has_moved(&mut self) {
        self.moved = Some(self.now);
        self.flight = None;
    }

    fn fly(&mut self, ui: &Ui) {
        let Some((from, to, since)) = self.flight else { return };
        let t = (self.now - since) / FLIGHT;
        self.camera = from.towards(&to, t);
        if t >= 1.0 {
            self.camera = to;
            self.flight = None;
        } else {
            ui.ctx().request_repaint();
        }
    }

    /// Chooses the quality: reduced while something moves, full once at rest. A search moves the electrode from node to
    /// node: in full quality a software renderer would block the keys and messages of the window.
    fn quality(&mut self, ui: &Ui, moves: Moves) -> Quality {
        if moves == Moves::Searching {
            self.moved = Some(self.now);
        }
        if self.flight.is_some() || moves == Moves::Playing {
            return Quality::Moving;
        }
        let left = self.moved.map(|moved| moved + REST - self.now).filter(|left| *left > 0.0);
        let Some(left) = left else { return Quality::Full };
        ui.ctx().request_repaint_after(Duration::from_secs_f64(left));
        Quality::Moving
    }

    /// Ratio of width to height.
    pub fn aspect(&self) -> f64 {
        f64::from(self.size[0]) / f64::from(self.size[1])
    }

    fn fly_to(&mut self, camera: Camera, now: f64) {
        self.flight = Some((self.camera, camera, now));
    }

    /// Moves the camera so that everything is visible.
    pub fn fit(&mut self, at_once: bool) {
        let mut camera = self.camera;
        camera.fit(&bodies(&self.scene), self.aspect());
        self.flight = None;
        self.camera = camera;
        if !at_once {
            self.has_moved();
        }
    }

    /// Turns the camera to a standard view of everything.
    pub fn look(&mut self, view: StandardView, now: f64) {
        let camera = standard(view, &self.scene, self.camera, self.aspect());
        self.fly_to(camera, now);
    }

    /// Moves the camera so that `bounds` fills the view, in the present direction.
    pub fn fly_into(&mut self, bounds: &Bounds, now: f64) {
        let mut camera = self.camera;
        camera.fit(bounds, self.aspect());
        self.fly_to(camera, now);
    }

    /// Turns the camera to `camera`.
    pub fn fly_onto(&mut self, camera: Camera, now: f64) {
        self.fly_to(camera, now);
    }

    /// Changes between perspective and parallel projection.
    pub fn toggle_projection(&mut self) {
        self.camera.projection = match self.camera.projection {
            Projection::Perspective => Projection::Orthographic,
            Projection::Orthographic => Projection::Perspective,
        };
    }

    /// Camera of the last frame and the size of the view (pixels).
    pub fn camera(&self) -> (&Camera, [u32; 2]) {
        (&self.camera, self.size)
    }

    /// Turns the view so that `towards_viewer` points to the viewer.
    pub fn turn_to(&mut self, towards_viewer: DVec3, now: f64) {
        let up = if towards_viewer.z.abs() > 0.9 { DVec3::Y } else { DVec3::Z };
        let orientation = render::view::looking(towards_viewer, up);
        self.fly_to(Camera { orientation, ..self.camera }, now);
    }
}
