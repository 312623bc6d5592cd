//! The 3-D view: what the mouse does in it, and what is drawn over it.

use std::sync::Arc;
use std::time::{Duration, Instant};

use egui::{Align2, Color32, FontId, PointerButton, Rect, Response, Sense, Ui, pos2, vec2};
use glam::{DVec2, DVec3};

use crate::shell::core::Core;
use crate::shell::preferences::Navigation;
use crate::widgets::camera::{bodies, into_channel, standard};
use crate::widgets::theme::palette;
use crate::widgets::viewport_gpu::Picture;
use crate::workspaces::blisk::document::stage::Stage;
use crate::workspaces::blisk::pipeline::StageState;
use crate::workspaces::blisk::scene::{Layer, SceneInputs, build, layer_of};
use feed::pose::Pose;
use geometry::mesh::Bounds;
use render::camera::{Camera, OrbitStyle, Projection};
use render::colour::Theme;
use render::pick::{Pick, pick};
use render::renderer::Quality;
use render::scene::{LineSet, Marker, Scene};
use render::view::StandardView;
use wheel::electrode::EntrySide;

/// How long a change of view takes (s).
const FLIGHT: f64 = 0.25;
/// How long after the last movement the view is drawn with full care.
const REST: Duration = Duration::from_millis(160);

/// Something that a scene was made of. It is held: the next one might else lie at its address.
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

/// What was clicked, in the coordinates of the loaded mesh.
#[derive(Debug, Clone, PartialEq)]
pub enum Probe {
    /// A point of a surface.
    Point {
        /// On which layer.
        layer: Option<Layer>,
        /// Where.
        at: DVec3,
        /// The surface's unit normal there.
        normal: DVec3,
    },
    /// Two points with a distance.
    Distance {
        /// The first.
        from: DVec3,
        /// The second.
        to: DVec3,
    },
}

/// State of the view.
pub struct Viewport {
    camera: Camera,
    flight: Option<(Camera, Camera, f64)>,
    size: [u32; 2],
    pivot: DVec3,
    moved: Option<Instant>,
    probe: Option<Probe>,
    first_point: Option<DVec3>,
    scene: Arc<Scene>,
    /// What `scene` was made from, to know when to make it again.
    scene_key: Option<SceneKey>,
    fitted_to: Option<usize>,
}

/// Everything that the scene depends on.
#[derive(Debug, Clone, PartialEq)]
struct SceneKey {
    sources: [usize; 9],
    s: f64,
    pose: Option<Pose>,
    ghosts: Vec<f64>,
    layers: crate::workspaces::blisk::scene::Layers,
    selected: Option<Layer>,
    section: Option<render::scene::SectionPlane>,
    dark: bool,
    tuning: bool,
    contact: Option<[DVec3; 2]>,
    trouble: Option<[DVec3; 2]>,
    probe: Option<Probe>,
    first_point: Option<DVec3>,
}

impl Default for Viewport {
    fn default() -> Self {
        Self {
            camera: Camera::default(),
            flight: None,
            size: [1, 1],
            pivot: DVec3::ZERO,
            moved: None,
            probe: None,
            first_point: None,
            scene: Arc::default(),
            scene_key: None,
            fitted_to: None,
        }
    }
}

impl Viewport {
    /// What was clicked.
    pub fn probe(&self) -> Option<&Probe> {
        self.probe.as_ref()
    }

    /// Forgets what was clicked.
    pub fn clear_probe(&mut self) {
        (self.probe, self.first_point) = (None, None);
    }

    /// The scene and where it is seen from.
    pub fn picture(&self) -> (&Arc<Scene>, &Camera) {
        (&self.scene, &self.camera)
    }

    /// Draws the view.
    pub fn show(&mut self, ui: &mut Ui, core: &mut Core) {
        let (rect, response) = ui.allocate_exact_size(ui.available_size(), Sense::click_and_drag());
        response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, "3D viewport"));
        let scale = ui.pixels_per_point();
        self.size = [rect.width(), rect.height()].map(|s| (s * scale).round().max(1.0) as u32);
        self.navigate(ui, &response, core.preferences.navigation);
        self.click(ui, &response, core);
        self.fly(ui);
        self.follow(ui, core);
        let quality = self.quality(ui, core.pipeline.partial_plan().is_some(), core.cursor.playing);
        let (scene, camera) = (self.scene.clone(), self.camera);
        let picture = Picture { scene, camera, size: self.size, quality };
        ui.painter().add(eframe::egui_wgpu::Callback::new_paint_callback(rect, picture));
        super::overlay::show(ui, rect, core, self);
        if core.pipeline.part().is_none() {
            empty(ui, rect, &core.pipeline.state(Stage::Part));
        }
    }

    /// Draws a scene that another workspace has made, moved by the same hands, and fits it in when `fitted_to` changes.
    /// Answers where it is, and what was clicked if something was: nothing may have been met.
    pub fn show_scene(
        &mut self,
        ui: &mut Ui,
        navigation: Navigation,
        scene: &Arc<Scene>,
        (fitted_to, is_playing): (usize, bool),
    ) -> (Rect, Option<Option<Pick>>) {
        let (rect, response) = ui.allocate_exact_size(ui.available_size(), Sense::click_and_drag());
        response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, "3D viewport"));
        let scale = ui.pixels_per_point();
        self.size = [rect.width(), rect.height()].map(|s| (s * scale).round().max(1.0) as u32);
        self.scene = scene.clone();
        if self.fitted_to != Some(fitted_to) {
            self.fitted_to = Some(fitted_to);
            self.fit(true);
        }
        self.navigate(ui, &response, navigation);
        let at = response.interact_pointer_pos().filter(|_| response.clicked());
        let clicked = at.map(|at| pick(&self.scene, &self.camera, self.pixel(ui, rect, at), self.size));
        self.fly(ui);
        let quality = self.quality(ui, false, is_playing);
        let picture = Picture { scene: self.scene.clone(), camera: self.camera, size: self.size, quality };
        ui.painter().add(eframe::egui_wgpu::Callback::new_paint_callback(rect, picture));
        (rect, clicked)
    }

    fn pixel(&self, ui: &Ui, rect: Rect, at: egui::Pos2) -> DVec2 {
        let p = (at - rect.min) * ui.pixels_per_point();
        DVec2::new(p.x.into(), p.y.into())
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
        self.moved = Some(Instant::now());
        self.flight = None;
    }

    fn click(&mut self, ui: &Ui, response: &Response, core: &mut Core) {
        let (true, Some(at)) = (response.clicked(), response.interact_pointer_pos()) else { return };
        let picked = pick(&self.scene, &self.camera, self.pixel(ui, response.rect, at), self.size);
        let Some(picked) = picked else {
            self.clear_probe();
            core.selected = None;
            return;
        };
        let layer = layer_of(picked.object);
        if !core.measuring {
            core.selected = layer;
            self.first_point = None;
            self.probe = Some(Probe::Point { layer, at: picked.point, normal: picked.normal });
            return;
        }
        match self.first_point.take() {
            Some(from) => self.probe = Some(Probe::Distance { from, to: picked.point }),
            None => (self.first_point, self.probe) = (Some(picked.point), None),
        }
    }

    fn fly(&mut self, ui: &Ui) {
        let Some((from, to, since)) = self.flight else { return };
        let t = (ui.input(|i| i.time) - since) / FLIGHT;
        self.camera = from.towards(&to, t);
        if t >= 1.0 {
            self.camera = to;
            self.flight = None;
        } else {
            ui.ctx().request_repaint();
        }
    }

    /// Draws with less care while something moves, and once more with all care when it rests. A search moves the
    /// electrode from node to node: drawn with all care in software, it would keep the window from its keys and
    /// from saying that they were heard.
    fn quality(&mut self, ui: &Ui, is_searching: bool, is_playing: bool) -> Quality {
        if is_searching {
            self.moved = Some(Instant::now());
        }
        if self.flight.is_some() || is_playing {
            return Quality::Moving;
        }
        let Some(since) = self.moved.map(|m| m.elapsed()).filter(|e| *e < REST) else { return Quality::Full };
        ui.ctx().request_repaint_after(REST.saturating_sub(since));
        Quality::Moving
    }

    fn aspect(&self) -> f64 {
        f64::from(self.size[0]) / f64::from(self.size[1])
    }

    fn fly_to(&mut self, camera: Camera, now: f64) {
        self.flight = Some((self.camera, camera, now));
    }

    /// Moves so that everything is seen.
    pub fn fit(&mut self, at_once: bool) {
        let mut camera = self.camera;
        camera.fit(&bodies(&self.scene), self.aspect());
        self.flight = None;
        self.camera = camera;
        if !at_once {
            self.has_moved();
        }
    }

    /// Turns to a standard view of everything.
    pub fn look(&mut self, view: StandardView, now: f64) {
        let camera = standard(view, &self.scene, self.camera, self.aspect());
        self.fly_to(camera, now);
    }

    /// Moves so that `bounds` fills the view, from the present direction.
    pub fn fly_into(&mut self, bounds: &Bounds, now: f64) {
        let mut camera = self.camera;
        camera.fit(bounds, self.aspect());
        self.fly_to(camera, now);
    }

    /// Turns to `camera`.
    pub fn fly_onto(&mut self, camera: Camera, now: f64) {
        self.fly_to(camera, now);
    }

    /// Looks along the channel's radius into it.
    pub fn look_into_channel(&mut self, core: &Core, now: f64) {
        let Some(found) = core.pipeline.channel() else { return };
        let planned = core.outcome().map(|o| &o.electrode);
        let electrode = planned.or(core.pipeline.electrodes().and_then(|e| e.electrodes.first()));
        let side = electrode.map_or(EntrySide::MinusX, |e| e.enters_from);
        let camera = into_channel(&found.channel, side, self.camera, self.aspect());
        self.fly_to(camera, now);
    }

    /// Changes between perspective and parallel projection.
    pub fn toggle_projection(&mut self) {
        self.camera.projection = match self.camera.projection {
            Projection::Perspective => Projection::Orthographic,
            Projection::Orthographic => Projection::Perspective,
        };
    }

    /// Makes the scene again if anything it depends on has changed.
    fn follow(&mut self, ui: &Ui, core: &mut Core) {
        let key = self.key(ui, core);
        if self.scene_key.as_ref() == Some(&key) {
            return;
        }
        let mut scene = scene(core, if key.dark { Theme::DARK } else { Theme::LIGHT });
        self.mark(&mut scene, ui);
        self.scene = Arc::new(scene);
        self.scene_key = Some(key);
        let part = core.pipeline.part().map(|p| Arc::as_ptr(p) as usize);
        if part != self.fitted_to {
            self.fitted_to = part;
            self.fit(true);
        }
    }

    fn key(&self, ui: &Ui, core: &Core) -> SceneKey {
        fn address<T>(value: Option<&Arc<T>>) -> usize {
            value.map_or(0, |v| Arc::as_ptr(v) as usize)
        }
        let p = &core.pipeline;
        let sources = [
            address(p.part()),
            address(p.channel()),
            address(p.electrodes()),
            address(p.plan()) ^ core.cursor.electrode,
            Arc::as_ptr(&core.shared_track()) as usize,
            core.colour_values().map_or(0, |v| Arc::as_ptr(&v.values) as usize),
            address(core.swept.shape(&core.shared_track())),
            core.leftover_values().map_or(0, |(_, v)| Arc::as_ptr(&v.values) as usize),
            Arc::as_ptr(core.machine_bodies()) as usize,
        ];
        SceneKey {
            sources,
            s: core.cursor.s,
            pose: core.moment().map(|moment| moment.pose),
            ghosts: core.ghosts.clone(),
            layers: core.layers.clone(),
            selected: core.selected,
            section: core.section,
            dark: ui.visuals().dark_mode,
            tuning: core.is_tuning(),
            contact: core.contact(),
            trouble: core.trouble().map(|trouble| trouble.points),
            probe: self.probe.clone(),
            first_point: self.first_point,
        }
    }

    /// Adds what was clicked.
    fn mark(&self, scene: &mut Scene, ui: &Ui) {
        let c = palette(ui).accent;
        let colour = render::colour::Colour::rgb(c.r(), c.g(), c.b());
        let mut dot = |at: DVec3| scene.markers.push(Marker { at, colour, radius_px: 4.5 });
        match &self.probe {
            Some(Probe::Point { at, .. }) => dot(*at),
            Some(Probe::Distance { from, to }) => {
                dot(*from);
                dot(*to);
                scene.lines.push(LineSet { on_top: true, ..LineSet::new(vec![vec![*from, *to]], colour) });
            }
            None => {}
        }
        if let Some(at) = self.first_point {
            scene.markers.push(Marker { at, colour, radius_px: 4.5 });
        }
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

/// The scene of the present state.
pub fn scene(core: &Core, theme: Theme) -> Scene {
    let p = &core.pipeline;
    let fresh = core.is_tuning();
    let values = core.colour_values();
    let leftover = core.leftover_values();
    let track = core.shared_track();
    build(&SceneInputs {
        blisk: p.part().map(|part| &part.shape),
        channel: p.channel().map(|f| (&*f.channel, &f.shapes)),
        electrode: core.shown_electrode(),
        track: (!track.is_empty() && (core.is_live() || !fresh)).then_some(&*track),
        machine: core.machine_bodies(),
        pose: core.moment().map(|moment| moment.pose),
        s: core.cursor.s,
        ghosts: &core.ghosts,
        swept: core.swept.shape(&track),
        contact: core.contact().filter(|_| !fresh),
        trouble: core.trouble().filter(|_| !fresh).map(|trouble| trouble.points),
        values: values.as_ref(),
        leftover: leftover.as_ref().map(|(shape, values)| (*shape, values)),
        layers: &core.layers,
        selected: core.selected,
        section: core.section,
        theme,
        triad: false,
    })
}

fn empty(ui: &Ui, rect: Rect, state: &StageState) {
    let colours = palette(ui);
    let (title, lines) = match state {
        StageState::Running => ("Loading…", ["", "", ""]),
        StageState::Failed(_) => {
            ("This could not be loaded", ["The form on the left says why.", "Drop another mesh here, or open one.", ""])
        }
        _ => (
            "Drop a blisk here",
            [
                "STL, OBJ, glTF or GLB, or a Sparkpath project.",
                "Then follow the steps on the left, from part to export.",
                "Ctrl+K finds every command.",
            ],
        ),
    };
    let c = rect.center();
    ui.painter().text(c - vec2(0.0, 40.0), Align2::CENTER_CENTER, title, FontId::proportional(22.0), colours.accent);
    for (i, line) in lines.into_iter().enumerate() {
        let at = pos2(c.x, c.y + 20.0 * i as f32);
        let colour = Color32::from_gray(150);
        ui.painter().text(at, Align2::CENTER_CENTER, line, FontId::proportional(13.5), colour);
    }
}
