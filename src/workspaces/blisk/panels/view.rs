//! The 3-D view of a blisk, and what a click in it means.

use std::sync::Arc;

use egui::{Rect, Ui};
use glam::DVec3;

use crate::widgets::camera::into_channel;
use crate::widgets::overlay;
use crate::widgets::theme::{BAD, palette};
use crate::widgets::viewport::{Moves, Viewport};
use crate::workspaces::blisk::desk::BliskDesk;
use crate::workspaces::blisk::desk::picks::Picked;
use crate::workspaces::blisk::document::stage::Stage;
use crate::workspaces::blisk::scene::{Layer, Layers, SceneInputs, build, layer_of};
use crate::workspaces::context::Context;
use feed::pose::Pose;
use geometry::mesh::Bounds;
use render::colour::Theme;
use render::pick::Pick;
use render::scene::{LineSet, Marker, ObjectId, Scene, SectionPlane};
use task::State;
use wheel::electrode::EntrySide;

/// A click, in the coordinates of the loaded mesh.
#[derive(Debug, Clone, PartialEq)]
pub enum Probe {
    /// A point of a surface.
    Point {
        /// Layer that the point lies on.
        layer: Option<Layer>,
        /// The point.
        at: DVec3,
        /// The surface's unit normal there.
        normal: DVec3,
        /// The face of the CAD program that it lies on, in words.
        face: Option<String>,
    },
    /// Two points with a distance.
    Distance {
        /// The first.
        from: DVec3,
        /// The second.
        to: DVec3,
    },
}

/// Half of the edge of the box around a place that is flown to, as a share of the part's diagonal.
const NEARBY: f64 = 0.05;

/// Share of its opacity that is left of what belongs to earlier parameters.
const PALE: f32 = 0.35;

/// State of the view.
#[derive(Default)]
pub struct BliskView {
    /// The camera and the hands that move it.
    pub viewport: Viewport,
    probe: Option<Probe>,
    first_point: Option<DVec3>,
    scene: Arc<Scene>,
    /// Key of the `scene`, to notice when it must be made again.
    scene_key: Option<SceneKey>,
}

/// Everything that the scene depends on.
#[derive(Debug, Clone, PartialEq)]
struct SceneKey {
    sources: [usize; 9],
    s: f64,
    pose: Option<Pose>,
    ghosts: Vec<f64>,
    layers: Layers,
    selected: Option<Layer>,
    section: Option<SectionPlane>,
    dark: bool,
    tuning: bool,
    contact: Option<[DVec3; 2]>,
    trouble: Option<[DVec3; 2]>,
    probe: Option<Probe>,
    first_point: Option<DVec3>,
    passage: bool,
    surfaces: usize,
    is_earlier: [bool; 2],
    picking: Option<Picked>,
    picked: [Vec<DVec3>; 4],
    refused_at: Option<DVec3>,
}

impl BliskView {
    /// Last click.
    pub fn probe(&self) -> Option<&Probe> {
        self.probe.as_ref()
    }

    /// Forgets what was clicked.
    pub fn clear_probe(&mut self) {
        (self.probe, self.first_point) = (None, None);
    }

    /// Draws the view.
    pub fn show(&mut self, ui: &mut Ui, desk: &mut BliskDesk, cx: &mut Context) {
        self.follow(ui, desk);
        let moves = match (desk.work.is_planning(), desk.cursor.playing) {
            (true, _) => Moves::Searching,
            (false, true) => Moves::Playing,
            (false, false) => Moves::Nothing,
        };
        let fitted_to = desk.work.part().map_or(0, |part| Arc::as_ptr(part) as usize);
        let navigation = cx.preferences.navigation;
        let (rect, clicked) = self.viewport.show(ui, navigation, &self.scene, (fitted_to, moves));
        if desk.picking().is_some() && ui.rect_contains_pointer(rect) {
            ui.ctx().set_cursor_icon(egui::CursorIcon::Crosshair);
        }
        if let Some(picked) = clicked {
            if desk.picking().is_some() {
                pick(desk, cx, picked);
            } else {
                self.click(desk, picked);
            }
            // What was clicked is marked in the next frame.
            ui.ctx().request_repaint();
        }
        super::overlay::show(ui, rect, desk, cx, self);
        if desk.work.part().is_none() {
            empty(ui, rect, &desk.work.state(Stage::Part));
        }
    }

    fn click(&mut self, desk: &mut BliskDesk, picked: Option<Pick>) {
        let Some(picked) = picked else {
            self.clear_probe();
            desk.selected = None;
            return;
        };
        let layer = layer_of(picked.object);
        if !desk.measuring {
            desk.selected = layer;
            self.first_point = None;
            let faces = desk.work.part().and_then(|part| part.faces.as_ref()).filter(|_| layer == Some(Layer::Blisk));
            let face = faces.zip(picked.triangle).and_then(|(faces, triangle)| faces.words_at(triangle));
            self.probe = Some(Probe::Point { layer, at: picked.point, normal: picked.normal, face });
            return;
        }
        match self.first_point.take() {
            Some(from) => self.probe = Some(Probe::Distance { from, to: picked.point }),
            None => (self.first_point, self.probe) = (Some(picked.point), None),
        }
    }

    /// Looks along the channel's radius into it.
    pub fn look_into_channel(&mut self, desk: &BliskDesk, now: f64) {
        let Some(found) = desk.work.channel() else { return };
        let planned = desk.outcome().map(|o| &o.electrode);
        let electrode = planned.or(desk.work.electrodes().and_then(|e| e.electrodes.first()));
        let side = electrode.map_or(EntrySide::MinusX, |e| e.enters_from);
        let camera = into_channel(&found.channel, side, *self.viewport.camera().0, self.viewport.aspect());
        self.viewport.fly_onto(camera, now);
    }

    /// Moves the camera to the place where the channel was refused.
    pub fn fly_to_refusal(&mut self, desk: &BliskDesk, now: f64) {
        let (Some(at), Some(part)) = (desk.refused_at(), desk.work.part()) else { return };
        let reach = DVec3::splat(NEARBY * part.shape.bounds().size().length());
        self.viewport.fly_into(&Bounds { min: at - reach, max: at + reach }, now);
    }

    /// Makes the scene again if anything it depends on has changed.
    fn follow(&mut self, ui: &Ui, desk: &BliskDesk) {
        let key = self.key(ui, desk);
        if self.scene_key.as_ref() == Some(&key) {
            return;
        }
        let mut scene = scene(desk, if key.dark { Theme::DARK } else { Theme::LIGHT });
        self.mark(&mut scene, ui);
        self.scene = Arc::new(scene);
        self.scene_key = Some(key);
    }

    fn key(&self, ui: &Ui, desk: &BliskDesk) -> SceneKey {
        fn address<T>(value: Option<&Arc<T>>) -> usize {
            value.map_or(0, |v| Arc::as_ptr(v) as usize)
        }
        let p = &desk.work;
        let sources = [
            address(p.part()),
            address(p.channel()),
            address(p.electrodes()),
            address(p.plan()) ^ desk.cursor.electrode,
            Arc::as_ptr(&desk.shared_track()) as usize,
            desk.colour_values().map_or(0, |v| Arc::as_ptr(&v.values) as usize),
            address(desk.swept()),
            desk.map_values().map_or(0, |(_, v)| Arc::as_ptr(&v.values) as usize),
            Arc::as_ptr(desk.machine_bodies()) as usize,
        ];
        SceneKey {
            sources,
            s: desk.cursor.s,
            pose: desk.moment().map(|moment| moment.pose),
            ghosts: desk.ghosts.clone(),
            layers: desk.layers.clone(),
            selected: desk.selected,
            section: desk.section,
            dark: ui.visuals().dark_mode,
            tuning: desk.is_tuning(),
            contact: desk.contact(),
            trouble: desk.trouble().map(|trouble| trouble.points),
            probe: self.probe.clone(),
            first_point: self.first_point,
            passage: desk.shown_passage().is_some(),
            surfaces: address(desk.surface_map()),
            is_earlier: desk.work.is_earlier(),
            picking: desk.picking(),
            picked: if desk.step == Stage::Channel {
                Picked::ALL.map(|of| desk.picked(of))
            } else {
                Default::default()
            },
            refused_at: desk.refused_at(),
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
}

/// Whether the object is the wheel, with or without its shroud.
fn is_wheel(object: ObjectId) -> bool {
    matches!(layer_of(object), Some(Layer::Blisk | Layer::Unshrouded))
}

/// Takes the point that was clicked as a picked one.
fn pick(desk: &mut BliskDesk, cx: &mut Context, picked: Option<Pick>) {
    // The cut of a section is no surface of the wheel.
    match picked.filter(|picked| picked.triangle.is_some() && is_wheel(picked.object)) {
        Some(picked) => desk.add_picked(picked.point),
        None => cx.say_in_passing("Click on a surface of the wheel.".to_owned()),
    }
}

/// The scene of the present state.
pub fn scene(desk: &BliskDesk, theme: Theme) -> Scene {
    let p = &desk.work;
    let fresh = desk.is_tuning();
    let values = desk.colour_values();
    let map = desk.map_values();
    let track = desk.shared_track();
    let mut scene = build(&SceneInputs {
        blisk: p.part().map(|part| &part.shape),
        channel: p.channel().map(|f| (&*f.channel, &f.shapes)),
        electrode: desk.shown_electrode(),
        track: (!track.is_empty() && (desk.is_live() || !fresh)).then_some(&*track),
        machine: desk.machine_bodies(),
        pose: desk.moment().map(|moment| moment.pose),
        s: desk.cursor.s,
        ghosts: &desk.ghosts,
        swept: desk.swept(),
        contact: desk.contact().filter(|_| !fresh),
        trouble: desk.trouble().filter(|_| !fresh).map(|trouble| trouble.points),
        values: values.as_ref(),
        residual_stock: map.as_ref().map(|(shape, values)| (*shape, values)),
        layers: &desk.layers,
        selected: desk.selected,
        section: desk.section,
        theme,
        triad: false,
    });
    let [channel, electrode] = desk.work.is_earlier();
    for object in &mut scene.objects {
        let is_earlier = match layer_of(object.id) {
            Some(Layer::Electrode) => electrode,
            Some(Layer::Unshrouded | Layer::LowWall | Layer::HighWall) => channel,
            _ => false,
        };
        object.opacity *= if is_earlier { PALE } else { 1.0 };
    }
    if let Some(found) = desk.shown_passage() {
        let place = |p| found.channel.frame.to_parent(p);
        scene.lines.extend(found.shapes.passage.drawn(place));
    }
    if let Some(map) = desk.surface_map() {
        map.colour(&mut scene);
    }
    if desk.picking().is_some() {
        // Only the wheel can be picked, whatever stands before it.
        scene.objects.retain(|object| is_wheel(object.id));
    }
    scene.markers.extend(desk.picked_markers());
    scene.markers.extend(desk.refused_at().map(|at| Marker { at, colour: BAD, radius_px: 6.0 }));
    scene
}

fn empty(ui: &Ui, rect: Rect, state: &State) {
    let (title, lines): (_, &[&str]) = match state {
        State::Running => ("Loading…", &["", "", ""]),
        State::Failed(_) => (
            "This could not be loaded",
            &["The form on the left says why.", "Drop another mesh here, or open one.", ""],
        ),
        _ => (
            "Drop a blisk here",
            &[
                "STL, OBJ, glTF, GLB or STEP, or a Sparkpath project.",
                "Then follow the steps on the left, from part to export.",
                "Ctrl+K finds every command.",
            ],
        ),
    };
    overlay::empty(ui, rect, title, lines);
}
