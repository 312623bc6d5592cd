//! The 3-D view of a mold, and what is drawn over it.

use std::sync::Arc;

use egui::{Align2, FontId, Rect, Stroke, Ui, pos2, vec2};

use super::electrode::{self, Fly, Look};
use super::strip;
use crate::shell::commands::Command;
use crate::shell::core::Core;
use crate::widgets::theme::palette;
use crate::workspaces::blisk::panels::overlay;
use crate::workspaces::blisk::panels::viewport::{Source, Viewport};
use crate::workspaces::mold::scene::{
    MoldLayer, MoldLook, MoldPart, MoldScene, RegionColours, build_mold, depth_legend, mold_part,
};
use crate::workspaces::mold::work::{Designed, FoundUncut, Glance, LoadedMold};
use render::camera::Camera;
use render::colour::Theme;
use render::pick::Pick;
use render::scene::{Marker, Scene};
use render::view::StandardView;
use task::State;

/// State of the view.
#[derive(Default)]
pub struct MoldView {
    /// The camera and the hands that move it.
    pub viewport: Viewport,
    scene: Arc<Scene>,
    key: Option<SceneKey>,
    /// From where was looked before a cut was.
    before: Option<Camera>,
    /// The part that the camera looks at.
    part: Option<String>,
}

/// Everything that the scene depends on.
#[derive(Debug, PartialEq)]
struct SceneKey {
    mold: Source<LoadedMold>,
    found: Source<FoundUncut>,
    glance: Source<Glance>,
    shown: Vec<bool>,
    colours: RegionColours,
    selected: Option<usize>,
    look: MoldLook,
    shows_invert: bool,
    layer: Option<usize>,
    /// Electrodes, while they are looked at.
    designed: Source<Designed>,
    burns: Look,
    dark: bool,
}

impl SceneKey {
    fn of(core: &Core, dark: bool) -> Self {
        let mold = &core.mold;
        let electrodes = &mold.electrodes;
        let is_faint = mold.is_faint || (mold.isolated && mold.selected.is_some());
        let look = match electrodes.seen() {
            // A line is drawn on what is left.
            Some(_) if electrodes.split.is_some() => MoldLook::Solid,
            // Half a mold hides nothing.
            Some(_) if electrodes.cut.is_some() && electrodes.look == MoldLook::Faint => MoldLook::Solid,
            Some(_) => electrodes.look,
            None if is_faint => MoldLook::Faint,
            None => MoldLook::Solid,
        };
        Self {
            mold: Source(mold.work.mold().cloned()),
            found: Source(mold.found().cloned()),
            glance: Source(mold.glanced().cloned()),
            shown: shown(core),
            colours: mold.colours,
            selected: match electrodes.seen() {
                // The one that is to be split, not what else is there.
                Some(_) => electrodes.split.and(electrodes.split_region),
                None => mold.selected,
            },
            look,
            shows_invert: mold.shows_invert,
            layer: mold.layer.filter(|_| electrodes.seen().is_none()),
            designed: Source(electrodes.seen().cloned()),
            burns: electrodes.picture(),
            dark,
        }
    }

    fn scene(&self, core: &Core) -> Scene {
        let theme = if self.dark { Theme::DARK } else { Theme::LIGHT };
        let Some(loaded) = core.mold.work.mold() else { return Scene { triad: false, ..Scene::new(theme) } };
        let found = core.mold.found();
        let layer = core.mold.layer().filter(|_| self.layer.is_some());
        let segments = found.zip(layer).map_or_else(Vec::new, |(f, (layer, _))| f.uncut.segments(layer.z));
        let opening = found.map_or(core.mold.params.opening, |f| f.uncut.params.opening);
        let pieces: Vec<_> =
            found.zip(layer).map_or_else(Vec::new, |(f, (_, number))| f.uncut.pieces(number).collect());
        let mut scene = build_mold(&MoldScene {
            mold: &loaded.shape,
            regions: found.map_or(&[], |f| &f.shapes),
            shown: &self.shown,
            colours: self.colours,
            deepest: found.map_or(0.0, |f| f.deepest),
            selected: self.selected,
            look: self.look,
            invert: found.and_then(|f| f.invert.as_ref()).filter(|_| self.shows_invert),
            glance: core.mold.glanced().map(|glance| &glance.shape),
            layer: found.zip(layer).map(|(found, (layer, number))| MoldLayer {
                z: layer.z,
                next: found.uncut.layers.get(number + 1).map(|next| next.z),
                pieces: &pieces,
                segments: &segments,
                opening,
            }),
            theme,
        });
        let electrodes = &core.mold.electrodes;
        if let Some(burns) = electrodes.scene(loaded.shape.bounds()) {
            burns.add_to(&mut scene);
            scene.section = electrodes.plane();
        }
        if let (Some(Some(first)), Some(made)) = (electrodes.split, electrodes.seen()) {
            let at = made.opening.in_mesh(first);
            scene.markers.push(Marker { at, colour: theme.accent, radius_px: 5.0 });
        }
        scene
    }
}

impl MoldView {
    /// Goes where the electrodes want it.
    fn fly(&mut self, core: &mut Core, ui: &Ui) {
        let Some(fly) = core.mold.electrodes.fly.take() else { return };
        let now = ui.input(|i| i.time);
        ui.ctx().request_repaint();
        match fly {
            Fly::Into(bounds) => self.viewport.fly_into(&bounds, now),
            Fly::Onto(camera) => {
                self.before.get_or_insert(*self.viewport.camera().0);
                self.viewport.fly_onto(camera, now);
            }
            Fly::Back => {
                if let Some(before) = self.before.take() {
                    self.viewport.fly_onto(before, now);
                }
            }
            Fly::Above => {
                let up = core.mold.params.opening.in_mesh(glam::DVec3::Z);
                self.viewport.turn_to(up, now);
            }
            Fly::All => self.viewport.fit(true),
        }
    }

    /// The line that is being drawn, from where it begins to the pointer.
    fn line(&self, ui: &Ui, rect: Rect, core: &Core) {
        let (Some(Some(first)), Some(made)) = (core.mold.electrodes.split, core.mold.electrodes.seen()) else { return };
        let (camera, size) = self.viewport.camera();
        let Some(seen) = camera.project(made.opening.in_mesh(first), size) else { return };
        let p = seen.pixel / f64::from(ui.pixels_per_point());
        let from = rect.min + vec2(p.x as f32, p.y as f32);
        let (painter, accent) = (ui.painter_at(rect), palette(ui).accent);
        painter.circle(from, 4.0, accent, Stroke::new(1.5, ui.visuals().window_fill));
        if let Some(to) = ui.ctx().pointer_hover_pos().filter(|to| rect.contains(*to)) {
            painter.line_segment([from, to], Stroke::new(2.0, accent));
        }
    }

    /// What is said of the place that is pointed at, beside it.
    fn pointed(&self, ui: &mut Ui, rect: Rect, core: &Core) {
        let electrodes = &core.mold.electrodes;
        let (Some(place), Some(made)) = (&electrodes.place, electrodes.seen()) else { return };
        let (camera, size) = self.viewport.camera();
        let Some(seen) = camera.project(made.opening.in_mesh(place.at), size) else { return };
        let p = seen.pixel / f64::from(ui.pixels_per_point());
        let at = rect.min + vec2(p.x as f32, p.y as f32);
        if rect.contains(at) && electrodes.split.is_none() {
            overlay::callout(ui, rect, at, palette(ui).bad, &place.text);
        }
    }

    /// Draws it.
    pub fn show(&mut self, ui: &mut Ui, core: &mut Core) {
        let key = SceneKey::of(core, ui.visuals().dark_mode);
        if self.key.as_ref() != Some(&key) {
            self.scene = Arc::new(key.scene(core));
            self.key = Some(key);
        }
        if let Some(mold) = core.mold.work.mold().filter(|mold| self.part.as_ref() != Some(&mold.sha256)) {
            // Another part is looked at as the first one was.
            (self.viewport, self.before, self.part) = (Viewport::default(), None, Some(mold.sha256.clone()));
        }
        if let Some(bounds) = core.mold.fly_to.take().and_then(|i| core.mold.bounds(i)) {
            self.viewport.fly_into(&bounds.grown(0.6 * bounds.size().length()), ui.input(|i| i.time));
        }
        let fitted_to = core.mold.work.mold().map_or(0, |mold| Arc::as_ptr(mold) as usize);
        let navigation = core.preferences.navigation;
        let (rect, clicked) =
            self.viewport.show_scene(ui, navigation, &self.scene, (fitted_to, core.mold.electrodes.is_playing));
        self.fly(core, ui);
        if let Some(picked) = clicked {
            click(core, picked);
        }
        overlay::buttons(ui, rect, core, &buttons(core));
        self.line(ui, rect, core);
        self.pointed(ui, rect, core);
        overlay::gizmo(ui, rect, &mut self.viewport);
        electrode::strip(ui, rect, core);
        if core.mold.electrodes.seen().is_none() {
            strip::show(ui, rect, core);
        }
        if core.mold.work.mold().is_none() {
            empty(ui, rect, core);
        }
        caption(ui, rect, core);
        if core.mold.colours == RegionColours::ByDepth
            && core.mold.electrodes.seen().is_none()
            && let Some(found) = core.mold.found()
        {
            overlay::legend(ui, rect, &depth_legend(found.deepest));
        }
    }
}

/// Whether each region is shown: while electrodes are, those that have none.
fn shown(core: &Core) -> Vec<bool> {
    let electrodes = &core.mold.electrodes;
    match electrodes.seen() {
        Some(made) if electrodes.split.is_none() => {
            let without = made.set.without_electrode();
            (0..core.mold.regions().len()).map(|r| without.contains(&r)).collect()
        }
        Some(_) => vec![true; core.mold.regions().len()],
        None => core.mold.is_visible(),
    }
}

/// Selects what was clicked, or takes it for an end of a line.
fn click(core: &mut Core, picked: Option<Pick>) {
    let part = picked.map(|p| mold_part(p.object));
    let Some(made) = core.mold.electrodes.seen().cloned() else {
        core.mold.selected = part.and_then(|part| if let MoldPart::Region(i) = part { Some(i) } else { None });
        return;
    };
    if core.mold.electrodes.split.is_some() {
        let edit = picked.and_then(|p| core.mold.electrodes.click(made.opening.upright(p.point)));
        if let Some(edit) = edit {
            let mut params = core.mold.params.clone();
            params.electrodes.edits.push(edit);
            core.mold.edit(params);
        }
        return;
    }
    match part {
        Some(MoldPart::Burn(at)) => core.mold.electrodes.select(at),
        // A cut leaves little to be hit.
        _ if core.mold.electrodes.cut.is_some() => {}
        _ => core.mold.electrodes.deselect(),
    }
}

fn buttons(core: &Core) -> Vec<(&'static str, Command, bool)> {
    let mold = &core.mold;
    if mold.electrodes.seen().is_some() {
        return vec![
            ("Fit", Command::Fit, false),
            ("Iso", Command::View(StandardView::Isometric), false),
            ("Front", Command::View(StandardView::Front), false),
            ("Right", Command::View(StandardView::Right), false),
            ("Top", Command::View(StandardView::Top), false),
            ("Transparent", Command::FaintMold, mold.electrodes.look != MoldLook::Solid),
            ("Cut", Command::Section, mold.electrodes.cut.is_some()),
            ("Isolate", Command::Isolate, mold.electrodes.is_alone),
        ];
    }
    vec![
        ("Fit", Command::Fit, false),
        ("Iso", Command::View(StandardView::Isometric), false),
        ("Front", Command::View(StandardView::Front), false),
        ("Right", Command::View(StandardView::Right), false),
        ("Top", Command::View(StandardView::Top), false),
        ("Layers", Command::Layers, mold.layer.is_some()),
        ("Depth", Command::DepthColours, mold.colours == RegionColours::ByDepth),
        ("Transparent", Command::FaintMold, mold.is_faint),
        ("Isolate", Command::Isolate, mold.isolated),
    ]
}

/// How the answer stands, at the bottom of the view.
fn caption(ui: &mut Ui, rect: Rect, core: &Core) {
    let colours = palette(ui);
    if let Some(made) = core.mold.electrodes.seen() {
        if !core.mold.is_designed() && core.mold.electrodes.split.is_none() {
            let text = format!("Out of date: {}", made.sentence(&core.mold.params.electrodes.overrides));
            overlay::caption(ui, rect, 122.0, colours.warning, &text);
        }
        return;
    }
    let others = core.mold.found_of_others().zip(core.mold.found());
    let text = match (core.mold.glanced(), others) {
        (Some(glance), _) => glance.preview.sentence(),
        (None, Some((others, found))) => format!("{others}: {}", found.sentence()),
        // The panel says it.
        (None, None) => return,
    };
    let above = if core.mold.layer.is_some() { 50.0 } else { 10.0 };
    overlay::caption(ui, rect, above, colours.warning, &text);
}

fn empty(ui: &Ui, rect: Rect, core: &Core) {
    let (title, line) = match core.mold.work.mold_state(&core.mold.params) {
        State::Running => ("Loading…", ""),
        State::Failed(_) | State::Cancelled => ("This could not be loaded", "The panel on the left says why."),
        _ => ("Drop a mold here", "STL, OBJ, glTF or GLB. Then set the opening direction and find the rest material."),
    };
    let c = rect.center();
    let accent = palette(ui).accent;
    ui.painter().text(c - vec2(0.0, 24.0), Align2::CENTER_CENTER, title, FontId::proportional(22.0), accent);
    let colour = egui::Color32::from_gray(150);
    ui.painter().text(pos2(c.x, c.y + 8.0), Align2::CENTER_CENTER, line, FontId::proportional(13.5), colour);
}
