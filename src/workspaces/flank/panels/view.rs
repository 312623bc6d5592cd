//! The 3-D view of a flank, and what is drawn over it.

use crate::workspaces::commands::{Command, CommandSet, FrameCommand};
use crate::workspaces::context::Context;
use crate::workspaces::flank::commands::FlankCommand;
use crate::workspaces::flank::panels::desk::FlankDesk;
use std::sync::Arc;

use egui::{Align2, FontId, Rect, RichText, Role, Ui, WidgetInfo, vec2};
use glam::DVec3;

use super::desk::{Fly, Standing};
use super::source::{CHOOSE_SIDE, SIDES};
use crate::widgets::camera::bodies;
use crate::widgets::overlay;
use crate::widgets::theme::palette;
use crate::widgets::viewport::{Moves, Source, Viewport};
use crate::workspaces::flank::document::PathChoice;
use crate::workspaces::flank::scene::{FlankScene, FlankSurface, contact_line};
use crate::workspaces::flank::work::{LoadedFlank, LoadedWalls, Planned, Sketch};
use flank::path::FlankPath;
use nc::flank_job::path_of;
use render::colour::Theme;
use render::scene::Scene;
use render::view::StandardView;
use task::State;

/// Position of a side's button on its arrow, in lengths of the arrow.
const BEYOND: f64 = 1.35;
/// Room that the legend takes beside what is shown (points).
const LEGEND: f64 = 112.0;

/// Names of paths, and where they stand.
type Names = Vec<(DVec3, &'static str)>;

/// State of the view.
#[derive(Default)]
pub struct FlankView {
    /// The camera and the hands that move it.
    pub viewport: Viewport,
    scene: Arc<Scene>,
    names: Names,
    /// The ends of the arrows to both sides of the surface, while one is to be chosen.
    sides: Option<[DVec3; 2]>,
    key: Option<SceneKey>,
}

/// Everything that the scene depends on.
#[derive(Debug, PartialEq)]
struct SceneKey {
    planned: Source<Planned>,
    /// Key of the surface.
    surface_of: (Source<Planned>, Source<Sketch>),
    part: Source<LoadedFlank>,
    walls: Source<LoadedWalls>,
    paths: Vec<PathChoice>,
    moving: bool,
    /// Pose of the cutter, if it is shown.
    t: Option<f64>,
    shows_axis: bool,
    shows_rulings: bool,
    place: Option<DVec3>,
    /// Place where the side is to be chosen.
    open_side: Option<[DVec3; 2]>,
    dark: bool,
}

impl SceneKey {
    fn of(desk: &FlankDesk, dark: bool) -> Self {
        let flank = desk;
        let (known, sketch) = flank.surface_from();
        Self {
            planned: Source(flank.planned().cloned()),
            surface_of: (Source(known.cloned()), Source(sketch.cloned())),
            part: Source(flank.work.loaded(flank.document.params()).cloned()),
            walls: Source(flank.work.walls(flank.document.params()).cloned()),
            paths: flank.shown_paths(),
            moving: flank.is_moving,
            t: flank.shows_cutter().then_some(flank.t),
            shows_axis: flank.shows_axis,
            shows_rulings: flank.shows_rulings,
            place: flank.place,
            open_side: flank.open_side(),
            dark,
        }
    }

    fn surface(&self) -> Option<&FlankSurface> {
        let (planned, sketch) = &self.surface_of;
        let known = planned.0.as_ref().map(|planned| &planned.shapes.surface);
        known.or_else(|| sketch.0.as_ref()?.surface.as_ref())
    }

    fn scene(&self) -> (Scene, Names, Option<[DVec3; 2]>) {
        let planned = self.planned.0.as_ref();
        let paths: Vec<&FlankPath> = planned.map_or_else(Vec::new, |planned| {
            self.paths.iter().map(|path| path_of(&planned.result.plan, *path)).collect()
        });
        let surface = planned.map(|planned| &planned.result.surface);
        let contact = |path: &FlankPath, t: f64| -> Vec<DVec3> {
            let line = contact_line(path, t);
            surface.map_or_else(Vec::new, |s| line.iter().map(|[u, v, _]| s.point(*u, *v)).collect())
        };
        let poses: Vec<_> = self.t.map_or_else(Vec::new, |t| paths.iter().map(|path| path.pose(t)).collect());
        let tips: Vec<Vec<DVec3>> = paths.iter().map(|path| path.poses.iter().map(|p| p.tip).collect()).collect();
        let contacts: Vec<Vec<DVec3>> =
            self.t.map_or_else(Vec::new, |t| paths.iter().map(|path| contact(path, t)).collect());
        let inputs = FlankScene {
            surface: self.surface(),
            shapes: planned.map(|planned| &planned.shapes),
            paths: &self.paths,
            moving: self.moving,
            poses: &poses,
            contacts: &contacts,
            tips: &tips,
            shows_axis: self.shows_axis,
            shows_rulings: self.shows_rulings,
            part: self.part.0.as_ref().and_then(|loaded| loaded.part.as_ref()),
            walls: self.walls.0.as_ref().map(|walls| &walls.shape),
            place: self.place,
            open_side: self.open_side,
            theme: if self.dark { Theme::DARK } else { Theme::LIGHT },
        };
        (inputs.build(), inputs.names(), inputs.sides())
    }
}

impl FlankView {
    /// Draws the view.
    pub fn show(&mut self, ui: &mut Ui, desk: &mut FlankDesk, cx: &mut Context) {
        let seconds = f64::from(ui.input(|i| i.stable_dt.clamp(0.0, 0.1)));
        if desk.is_playing {
            desk.advance(seconds);
            ui.ctx().request_repaint();
        }
        let key = SceneKey::of(desk, ui.visuals().dark_mode);
        if self.key.as_ref() != Some(&key) {
            let (scene, names, sides) = key.scene();
            (self.scene, self.names, self.sides, self.key) = (Arc::new(scene), names, sides, Some(key));
        }
        let navigation = cx.preferences.navigation;
        let moves = if desk.is_playing { Moves::Playing } else { Moves::Nothing };
        let has_surface = self.key.as_ref().is_some_and(|key| key.surface().is_some());
        let fitted_to = usize::from(has_surface);
        let (rect, _) = self.viewport.show(ui, navigation, &self.scene, (fitted_to, moves));
        self.fly(desk, ui);
        cx.view_buttons(ui, rect, desk, &buttons(desk));
        overlay::gizmo(ui, rect, &mut self.viewport);
        self.label(ui, rect, desk);
        self.choose_side(ui, rect, desk);
        if let Some(planned) = desk.planned() {
            legend(ui, rect, planned);
        }
        if !has_surface && desk.why_not().is_none() {
            empty(ui, rect, desk);
        }
        caption(ui, rect, desk);
    }

    /// Flies to the target that the workspace asks for.
    fn fly(&mut self, desk: &mut FlankDesk, ui: &Ui) {
        let Some(surface) = self.key.as_ref().and_then(SceneKey::surface) else { return };
        let Some(fly) = desk.fly.take() else { return };
        let (now, (camera, [width, height])) = (ui.input(|i| i.time), self.viewport.camera());
        let aspect = f64::from(width) / f64::from(height.max(1));
        let all = bodies(&self.scene);
        let to = match fly {
            Fly::Onto => surface.camera(&all, *camera, aspect, false),
            // The legend covers nothing of what lies side by side.
            Fly::Square => {
                let free = (1.0 - 2.0 * LEGEND * f64::from(ui.pixels_per_point()) / f64::from(width.max(1))).max(0.4);
                surface.camera(&all, *camera, free * aspect, true)
            }
            Fly::Place(place) => {
                ui.ctx().request_repaint();
                return self.viewport.fly_into(&surface.around(place), now);
            }
        };
        self.viewport.fly_onto(to, now);
        ui.ctx().request_repaint();
    }

    /// Both sides of the surface at the ends of their arrows, to be chosen.
    fn choose_side(&self, ui: &mut Ui, rect: Rect, desk: &mut FlankDesk) {
        let Some((tips, [from, _])) = self.sides.zip(desk.open_side()) else { return };
        for (tip, (side, name, hint)) in tips.into_iter().zip(SIDES) {
            // Past the arrow's point, which is to be seen.
            let Some(at) = self.viewport.seen_at(ui, rect, from.lerp(tip, BEYOND)) else { continue };
            let area = Rect::from_center_size(at, vec2(34.0, 22.0));
            if !rect.contains_rect(area) {
                continue;
            }
            let text = RichText::new(name).strong().color(palette(ui).accent);
            let response = ui.put(area, egui::Button::new(text)).on_hover_text(hint);
            response.widget_info(|| WidgetInfo::labeled(Role::Button, true, format!("Cutter on side {name}")));
            if response.clicked() {
                desk.choose_side(side);
            }
        }
    }

    /// Names the paths that are side by side, with their figures.
    fn label(&self, ui: &Ui, rect: Rect, desk: &FlankDesk) {
        let Some(planned) = desk.planned().filter(|_| self.names.len() > 1) else { return };
        let plan = &planned.result.plan;
        let mut placed: Vec<Rect> = Vec::new();
        for ((at, name), choice) in self.names.iter().zip(PathChoice::ALL) {
            let Some(at) = self.viewport.seen_at(ui, rect, *at) else { continue };
            if !rect.shrink(4.0).contains(at) {
                continue;
            }
            let path = path_of(plan, choice);
            let deviation = if desk.is_moving { &path.envelope.deviation } else { &path.deviation };
            let words = plan.ratio_words(deviation.sum);
            let text = if desk.is_moving {
                format!("{name}   envelope \u{2211} {:.3} mm   {words} to initial, static", deviation.sum)
            } else {
                format!("{name}   \u{2211} {:.3} mm   {words}", deviation.sum)
            };
            let strong = choice == desk.path;
            let colour = if strong { ui.visuals().strong_text_color() } else { ui.visuals().text_color() };
            let galley = ui.painter().layout_no_wrap(text, FontId::proportional(12.5), colour);
            let area = Rect::from_min_size(at - vec2(0.0, galley.size().y), galley.size()).expand2(vec2(6.0, 3.0));
            let area = beside_axes(rect, area, &placed);
            placed.push(area);
            ui.painter().rect_filled(area, 4.0, ui.visuals().window_fill.gamma_multiply(0.8));
            ui.painter().galley(area.min + vec2(6.0, 3.0), galley, colour);
        }
    }
}

/// `area` moved off the three axes in the corner of the view: to their left, or below them where something is `placed`
/// already.
fn beside_axes(rect: Rect, area: Rect, placed: &[Rect]) -> Rect {
    const GAP: f32 = 4.0;
    let axes = overlay::gizmo_area(rect);
    if !area.intersects(axes) {
        return area;
    }
    let left = area.translate(vec2(axes.left() - GAP - area.right(), 0.0));
    let below = area.translate(vec2(0.0, axes.bottom() + GAP - area.top()));
    let is_free = rect.contains_rect(left) && !placed.iter().any(|other| other.intersects(left));
    if is_free { left } else { below }
}

/// The scale of the colours, and what its ends mean.
fn legend(ui: &mut Ui, rect: Rect, planned: &Planned) {
    let area = overlay::legend(ui, rect, &planned.shapes.legend());
    let unmilled = planned.shapes.has_unmilled.then_some("grey: not milled");
    let texts: Vec<&str> = ["+ undercut", "\u{2212} overcut"].into_iter().chain(unmilled).collect();
    let height = 14.0 * texts.len() as f32 + 6.0;
    let below = Rect::from_min_size(area.left_bottom() + vec2(0.0, 3.0), vec2(area.width(), height));
    ui.painter().rect_filled(below, 6.0, ui.visuals().window_fill.gamma_multiply(0.88));
    for (i, text) in texts.into_iter().enumerate() {
        let at = below.left_top() + vec2(8.0, 10.0 + 14.0 * i as f32);
        ui.painter().text(at, Align2::LEFT_CENTER, text, FontId::proportional(11.0), palette(ui).faint);
    }
}

fn buttons(desk: &FlankDesk) -> Vec<(&'static str, Command, bool)> {
    let flank = desk;
    vec![
        ("Fit", FrameCommand::Fit.command(), false),
        ("Face", FlankCommand::FaceFlank.command(), false),
        ("Iso", FrameCommand::View(StandardView::Isometric).command(), false),
        ("Side by side", FlankCommand::SideBySide.command(), flank.is_side_by_side),
        ("Envelope", FlankCommand::MovingCutter.command(), flank.is_moving),
        ("Cutter", FlankCommand::ShowCutter.command(), flank.shows_cutter()),
        ("Axis", FlankCommand::AxisSurface.command(), flank.shows_axis),
        ("Rulings", FlankCommand::Rulings.command(), flank.shows_rulings),
    ]
}

/// State of the shown result, at the bottom of the view.
fn caption(ui: &mut Ui, rect: Rect, desk: &FlankDesk) {
    let (flank, colours) = (desk, palette(ui));
    let sentence = |planned: &Planned| {
        let plan = &planned.result.plan;
        let path = path_of(plan, flank.path);
        let [nu, nv] = path.deviation.counted_grid();
        format!("total {:.3} mm over {nu} × {nv} samples, {}", path.deviation.sum, plan.ratio_words(path.deviation.sum))
    };
    let (colour, text) = match (flank.standing(), flank.planned(), flank.why_not()) {
        (Standing::Planned, ..) => return,
        _ if flank.open_side().is_some() => (colours.accent, CHOOSE_SIDE.to_owned()),
        (Standing::Sketch, Some(planned), _) => {
            (colours.accent, format!("Preview, {} path: {}", flank.path.name(), sentence(planned)))
        }
        (Standing::Stale, Some(planned), None) => {
            (colours.warning, format!("Out of date, {} path: {}", flank.path.name(), sentence(planned)))
        }
        (.., Some(why)) => (colours.bad, crate::widgets::panel_parts::sentence(&why)),
        _ => return,
    };
    overlay::caption(ui, rect, 10.0, colour, &text);
}

fn empty(ui: &Ui, rect: Rect, desk: &FlankDesk) {
    let work = &desk.work;
    let (title, line) = match work.source_state(desk.document.params()) {
        State::Running => ("Loading…", ""),
        State::Ready if work.is_sketching() || desk.state() == State::Running => ("Looking at the surface…", ""),
        _ => ("Drop a part or two guide curves here", "STL, OBJ, glTF, GLB or STEP; or points as CSV."),
    };
    overlay::empty(ui, rect, title, &[line]);
}
