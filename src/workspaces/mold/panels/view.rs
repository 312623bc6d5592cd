//! The 3-D view of a mold, and what is drawn over it.

use crate::workspaces::commands::{Command, CommandSet};
use crate::workspaces::context::{Context, standard_views};
use crate::workspaces::mold::commands::MoldCommand;
use crate::workspaces::mold::panels::desk::MoldDesk;
use std::sync::Arc;

use egui::{Rect, Stroke, Ui};

use super::datum_pick::DatumPick;
use super::electrode;
use super::electrode::desk::{Fly, Look};
use super::strip;
use crate::widgets::overlay;
use crate::widgets::theme::palette;
use crate::widgets::viewport::{Moves, Source, Viewport};
use crate::workspaces::mold::scene::division::division_lines;
use crate::workspaces::mold::scene::{
    MoldLayer, MoldLook, MoldPart, MoldScene, RegionColours, build_mold, datum_lines, depth_legend, mold_part,
    rim_lines,
};
use crate::workspaces::mold::work::{Designed, FoundUncut, Glance, LoadedMold, Survey};
use crate::workspaces::news::EventKind;
use mold::datum::Datum;
use mold::opening::Opening;
use render::camera::Camera;
use render::colour::Theme;
use render::pick::Pick;
use render::scene::{Marker, Scene};
use task::State;

/// State of the view.
#[derive(Default)]
pub struct MoldView {
    /// The camera and the hands that move it.
    pub viewport: Viewport,
    scene: Arc<Scene>,
    key: Option<SceneKey>,
    /// Camera before the view went to a cut.
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
    /// Electrodes, and regions whose division is drawn.
    divided: (Source<Designed>, Vec<usize>),
    /// Work datum, where it is worth showing.
    datum: Option<(Datum, Opening)>,
    pick: Option<DatumPick>,
    /// Rims, while one is picked.
    rims: Source<Survey>,
    dark: bool,
}

impl SceneKey {
    fn of(desk: &MoldDesk, dark: bool) -> Self {
        let mold = desk;
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
            // What lies on the mold is not the mold: a place that is picked is one of the mold itself.
            glance: Source(mold.glanced().filter(|_| mold.pick.is_none()).cloned()),
            shown: if mold.pick.is_none() { shown(desk) } else { Vec::new() },
            colours: mold.colours,
            selected: match electrodes.seen() {
                // The one that is to be split, not what else is there.
                Some(_) => electrodes.split.and(electrodes.split_region),
                None => mold.selected,
            },
            look,
            shows_invert: mold.shows_invert && mold.pick.is_none(),
            layer: mold.layer.filter(|_| electrodes.seen().is_none()),
            designed: Source(electrodes.seen().cloned()),
            burns: electrodes.picture(),
            divided: (Source(electrodes.designed().cloned()), divided(desk)),
            datum: Some((mold.params().datum.clone(), mold.params().opening()))
                .filter(|(datum, _)| !datum.is_of_mesh() || mold.pick.is_some()),
            pick: mold.pick,
            rims: Source(mold.work.survey(mold.params()).filter(|_| mold.pick == Some(DatumPick::Hole)).cloned()),
            dark,
        }
    }

    fn scene(&self, desk: &MoldDesk) -> Scene {
        let theme = if self.dark { Theme::DARK } else { Theme::LIGHT };
        let Some(loaded) = desk.work.mold() else { return Scene { triad: false, ..Scene::new(theme) } };
        let (found, glance) = (desk.found(), self.glance.0.as_ref());
        let layer = desk.layer().filter(|_| self.layer.is_some());
        let segments = found.zip(layer).map_or_else(Vec::new, |(f, (layer, _))| f.uncut.segments(layer.z));
        let opening = found.map_or(desk.document.params().opening(), |f| f.uncut.params.opening);
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
            invert: glance
                .map_or_else(|| found.and_then(|f| f.invert.as_ref()), |glance| glance.invert.as_ref())
                .filter(|_| self.shows_invert),
            glance: glance.map(|glance| &glance.shape),
            layer: found.zip(layer).map(|(found, (layer, number))| MoldLayer {
                z: layer.z,
                next: found.uncut.layers.get(number + 1).map(|next| next.z),
                pieces: &pieces,
                segments: &segments,
                opening,
            }),
            theme,
        });
        let electrodes = &desk.electrodes;
        if let Some(burns) = electrodes.scene(loaded.shape.bounds()) {
            burns.add_to(&mut scene);
            scene.section = electrodes.plane();
        }
        if let (Some(made), regions) = (&self.divided.0.0, &self.divided.1) {
            let emphasised = electrodes.hovered.or(electrodes.node);
            scene.lines.extend(division_lines((&made.set, regions), emphasised, made.opening, theme));
        }
        if let (Some(Some(first)), Some(made)) = (electrodes.split, electrodes.seen()) {
            let at = made.opening.in_mesh(first);
            scene.markers.push(Marker { at, colour: theme.accent, radius_px: 5.0 });
        }
        if let Some((datum, opening)) = &self.datum {
            scene.lines.extend(datum_lines(datum, *opening, &loaded.shape.bounds()));
        }
        if let Some(found) = &self.rims.0 {
            scene.lines.push(rim_lines(&found.rims, theme));
        }
        if let Some(DatumPick::Faces(Some((at, _))) | DatumPick::XAxis(Some(at))) = self.pick {
            scene.markers.push(Marker { at, colour: theme.accent, radius_px: 5.0 });
        }
        scene
    }
}

impl MoldView {
    /// Flies to the target that the electrodes ask for.
    fn fly(&mut self, desk: &mut MoldDesk, ui: &Ui) {
        let Some(fly) = desk.electrodes.fly.take() else { return };
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
                let up = desk.document.params().opening().in_mesh(glam::DVec3::Z);
                self.viewport.turn_to(up, now);
            }
            Fly::All => self.viewport.fit(true),
        }
    }

    /// The line that is being drawn, from where it begins to the pointer.
    fn line(&self, ui: &Ui, rect: Rect, desk: &MoldDesk) {
        let (Some(Some(first)), Some(made)) = (desk.electrodes.split, desk.electrodes.seen()) else { return };
        let Some(from) = self.viewport.seen_at(ui, rect, made.opening.in_mesh(first)) else { return };
        let (painter, accent) = (ui.painter_at(rect), palette(ui).accent);
        painter.circle(from, 4.0, accent, Stroke::new(1.5, ui.visuals().window_fill));
        if let Some(to) = ui.ctx().pointer_hover_pos().filter(|to| rect.contains(*to)) {
            painter.line_segment([from, to], Stroke::new(2.0, accent));
        }
    }

    /// Text beside the marked place.
    fn pointed(&self, ui: &mut Ui, rect: Rect, desk: &MoldDesk) {
        let electrodes = &desk.electrodes;
        let (Some(place), Some(made)) = (&electrodes.place, electrodes.seen()) else { return };
        let Some(at) = self.viewport.seen_at(ui, rect, made.opening.in_mesh(place.at)) else { return };
        if rect.contains(at) && electrodes.split.is_none() {
            overlay::callout(ui, rect, at, palette(ui).bad, &place.text);
        }
    }

    /// The face that was clicked, in words beside the place.
    fn face(&self, ui: &mut Ui, rect: Rect, desk: &MoldDesk) {
        let Some((at, words)) = desk.face.as_ref().filter(|_| desk.electrodes.seen().is_none()) else { return };
        if let Some(at) = self.viewport.seen_at(ui, rect, *at).filter(|at| rect.contains(*at)) {
            overlay::callout(ui, rect, at, palette(ui).accent, words);
        }
    }

    /// Draws the view.
    pub fn show(&mut self, ui: &mut Ui, desk: &mut MoldDesk, cx: &mut Context) {
        let key = SceneKey::of(desk, ui.visuals().dark_mode);
        if self.key.as_ref() != Some(&key) {
            self.scene = Arc::new(key.scene(desk));
            self.key = Some(key);
        }
        // The panels, which are drawn first, say it anew in each frame.
        desk.electrodes.hovered = None;
        if let Some(mold) = desk.work.mold().filter(|mold| self.part.as_ref() != Some(&mold.sha256)) {
            // Another part is looked at as the first one was.
            desk.face = None;
            (self.viewport, self.before, self.part) = (Viewport::default(), None, Some(mold.sha256.clone()));
        }
        if let Some(bounds) = desk.fly_to.take().and_then(|i| desk.bounds(i)) {
            self.viewport.fly_into(&bounds.grown(0.6 * bounds.size().length()), ui.input(|i| i.time));
        }
        let fitted_to = desk.work.mold().map_or(0, |mold| Arc::as_ptr(mold) as usize);
        let navigation = cx.preferences.navigation;
        let moves = if desk.electrodes.is_playing { Moves::Playing } else { Moves::Nothing };
        let (rect, clicked) = self.viewport.show(ui, navigation, &self.scene, (fitted_to, moves));
        self.fly(desk, ui);
        if let Some(picked) = clicked {
            click(desk, picked, cx);
        }
        cx.view_buttons(ui, rect, desk, &buttons(desk));
        self.line(ui, rect, desk);
        self.pointed(ui, rect, desk);
        self.face(ui, rect, desk);
        overlay::gizmo(ui, rect, &mut self.viewport);
        electrode::strip(ui, rect, desk, cx);
        if desk.pick.is_some() {
            strip::picking(ui, rect, desk);
        } else if desk.electrodes.seen().is_none() {
            strip::show(ui, rect, desk);
        }
        if desk.work.mold().is_none() {
            empty(ui, rect, desk);
        }
        caption(ui, rect, desk);
        if desk.colours == RegionColours::ByDepth
            && desk.electrodes.seen().is_none()
            && let Some(found) = desk.found()
        {
            overlay::legend(ui, rect, &depth_legend(found.deepest));
        }
    }
}

/// Regions whose division is drawn; none while a place for the datum is picked.
fn divided(desk: &MoldDesk) -> Vec<usize> {
    if desk.pick.is_some() {
        return Vec::new();
    }
    // Of others the numbers mean other regions.
    desk.electrodes.divided(desk.selected.filter(|_| desk.is_designed()))
}

/// Whether each region is shown: while electrodes are, those that have none.
fn shown(desk: &MoldDesk) -> Vec<bool> {
    let electrodes = &desk.electrodes;
    match electrodes.seen() {
        Some(made) if electrodes.split.is_none() => {
            let without = made.set.without_electrode();
            (0..desk.regions().len()).map(|r| without.contains(&r)).collect()
        }
        Some(_) => vec![true; desk.regions().len()],
        None => desk.is_visible(),
    }
}

/// Selects what was clicked, or takes it for an end of a line, for a face to divide along, or for the work datum.
fn click(desk: &mut MoldDesk, picked: Option<Pick>, cx: &mut Context) {
    if desk.pick.is_some() {
        if let Some(Err(why)) = picked.map(|p| desk.take_datum(p.point, p.normal)) {
            cx.say(EventKind::Refused, format!("Work datum: {why}"));
        }
        return;
    }
    let part = picked.map(|p| mold_part(p.object));
    desk.face = picked.filter(|_| part == Some(MoldPart::Mold)).and_then(|p| {
        let words = desk.work.mold()?.faces.as_ref()?.words_at(p.triangle?)?;
        Some((p.point, words))
    });
    let Some(made) = desk.electrodes.seen().cloned() else {
        desk.selected = part.and_then(|part| if let MoldPart::Region(i) = part { Some(i) } else { None });
        return;
    };
    if desk.electrodes.split.is_some() {
        let edit = picked.and_then(|p| desk.electrodes.click(made.opening.upright(p.point)));
        if let Some(edit) = edit {
            let mut params = desk.document.params().clone();
            params.electrodes.edits.push(edit);
            desk.edit(params);
        }
        return;
    }
    match part {
        Some(MoldPart::Burn(at)) => desk.electrodes.select(at),
        // A cut leaves little to be hit.
        _ if desk.electrodes.cut.is_some() => {}
        _ => desk.electrodes.deselect(),
    }
}

fn buttons(desk: &MoldDesk) -> Vec<(&'static str, Command, bool)> {
    let mold = desk;
    let mut buttons = standard_views();
    if mold.electrodes.seen().is_some() {
        buttons.extend([
            ("Transparent", MoldCommand::FaintMold.command(), mold.electrodes.look != MoldLook::Solid),
            ("Cut", MoldCommand::Section.command(), mold.electrodes.cut.is_some()),
            ("Isolate", MoldCommand::Isolate.command(), mold.electrodes.is_alone),
        ]);
        return buttons;
    }
    buttons.extend([
        ("Layers", MoldCommand::Layers.command(), mold.layer.is_some()),
        ("Depth", MoldCommand::DepthColours.command(), mold.colours == RegionColours::ByDepth),
        ("Transparent", MoldCommand::FaintMold.command(), mold.is_faint),
        ("Isolate", MoldCommand::Isolate.command(), mold.isolated),
    ]);
    buttons
}

/// State of the result, at the bottom of the view.
fn caption(ui: &mut Ui, rect: Rect, desk: &MoldDesk) {
    let colours = palette(ui);
    if let Some(made) = desk.electrodes.seen() {
        if !desk.is_designed() && desk.electrodes.split.is_none() {
            let text = format!("Out of date: {}", made.sentence(&desk.document.params().electrodes.overrides));
            overlay::caption(ui, rect, 122.0, colours.warning, &text);
        }
        return;
    }
    let others = desk.found_of_others().zip(desk.found());
    let text = match (desk.glanced(), others) {
        (Some(glance), _) => glance.sentence(),
        (None, Some((others, found))) => format!("{others}: {}", found.sentence()),
        // The panel says it.
        (None, None) if desk.document.params().mesh.is_none() && desk.found().is_none() => {
            let hint = "Demonstration mold. Drop your own here: STL, OBJ, glTF, GLB or STEP.";
            return overlay::caption(ui, rect, 10.0, colours.faint, hint);
        }
        (None, None) => return,
    };
    let above = if desk.layer.is_some() { 50.0 } else { 10.0 };
    overlay::caption(ui, rect, above, colours.warning, &text);
}

fn empty(ui: &Ui, rect: Rect, desk: &MoldDesk) {
    let (title, line) = match desk.work.mold_state(desk.document.params()) {
        State::Running => ("Loading…", ""),
        State::Failed(_) | State::Cancelled => ("This could not be loaded", "The panel on the left says why."),
        _ => (
            "Drop a mold here",
            "STL, OBJ, glTF, GLB or STEP. Then set the opening direction and find the rest material.",
        ),
    };
    overlay::empty(ui, rect, title, &[line]);
}
