//! The 3-D view of a mold, and what is drawn over it.

use std::sync::Arc;

use egui::{Align2, FontId, Rect, Ui, pos2};

use super::super::commands::Command;
use super::super::core::Core;
use super::super::overlay;
use super::super::theme::palette;
use super::super::viewport::Viewport;
use super::strip;
use crate::jobs::mold::{FoundUncut, Glance, LoadedMold};
use crate::jobs::pipeline::StageState;
use crate::render::colour::Theme;
use crate::render::scene::Scene;
use crate::render::view::StandardView;
use crate::views::{MoldLayer, MoldPart, MoldScene, RegionColours, build_mold, depth_legend, mold_part};

/// State of the view.
#[derive(Default)]
pub struct MoldView {
    /// The camera and the hands that move it.
    pub viewport: Viewport,
    scene: Arc<Scene>,
    key: Option<SceneKey>,
}

/// Something that a scene was made of. It is held: the next one might else lie at its address.
#[derive(Debug)]
struct Source<T>(Option<Arc<T>>);

impl<T> PartialEq for Source<T> {
    fn eq(&self, other: &Self) -> bool {
        match (&self.0, &other.0) {
            (Some(one), Some(other)) => Arc::ptr_eq(one, other),
            (one, other) => one.is_none() && other.is_none(),
        }
    }
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
    is_faint: bool,
    shows_invert: bool,
    layer: Option<usize>,
    dark: bool,
}

impl SceneKey {
    fn of(core: &Core, dark: bool) -> Self {
        let mold = &core.mold;
        Self {
            mold: Source(mold.work.mold().cloned()),
            found: Source(mold.found().cloned()),
            glance: Source(mold.glanced().cloned()),
            shown: mold.is_visible(),
            colours: mold.colours,
            selected: mold.selected,
            is_faint: mold.is_faint || (mold.isolated && mold.selected.is_some()),
            shows_invert: mold.shows_invert,
            layer: mold.layer,
            dark,
        }
    }

    fn scene(&self, core: &Core) -> Scene {
        let theme = if self.dark { Theme::DARK } else { Theme::LIGHT };
        let Some(loaded) = core.mold.work.mold() else { return Scene { triad: false, ..Scene::new(theme) } };
        let found = core.mold.found();
        let layer = core.mold.layer();
        let segments = found.zip(layer).map_or_else(Vec::new, |(f, (layer, _))| f.uncut.segments(layer.z));
        let opening = found.map_or(core.mold.params.opening, |f| f.uncut.params.opening);
        let pieces: Vec<_> =
            found.zip(layer).map_or_else(Vec::new, |(f, (_, number))| f.uncut.pieces(number).collect());
        build_mold(&MoldScene {
            mold: &loaded.shape,
            regions: found.map_or(&[], |f| &f.shapes),
            shown: &self.shown,
            colours: self.colours,
            deepest: found.map_or(0.0, |f| f.deepest),
            selected: self.selected,
            is_faint: self.is_faint,
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
        })
    }
}

impl MoldView {
    /// Draws it.
    pub fn show(&mut self, ui: &mut Ui, core: &mut Core) {
        let key = SceneKey::of(core, ui.visuals().dark_mode);
        if self.key.as_ref() != Some(&key) {
            self.scene = Arc::new(key.scene(core));
            self.key = Some(key);
        }
        if let Some(bounds) = core.mold.fly_to.take().and_then(|i| core.mold.bounds(i)) {
            self.viewport.fly_into(&bounds.grown(0.6 * bounds.size().length()), ui.input(|i| i.time));
        }
        let fitted_to = core.mold.work.mold().map_or(0, |mold| Arc::as_ptr(mold) as usize);
        let navigation = core.preferences.navigation;
        let (rect, clicked) = self.viewport.show_scene(ui, navigation, &self.scene, fitted_to);
        if let Some(picked) = clicked {
            core.mold.selected = picked.and_then(|p| match mold_part(p.object) {
                MoldPart::Region(i) => Some(i),
                MoldPart::Mold => None,
            });
        }
        overlay::buttons(ui, rect, core, &buttons(core));
        overlay::gizmo(ui, rect, &mut self.viewport);
        strip::show(ui, rect, core);
        if core.mold.work.mold().is_none() {
            empty(ui, rect, core);
        }
        caption(ui, rect, core);
        if core.mold.colours == RegionColours::ByDepth
            && let Some(found) = core.mold.found()
        {
            overlay::legend(ui, rect, &depth_legend(found.deepest));
        }
    }
}

fn buttons(core: &Core) -> [(&'static str, Command, bool); 9] {
    let mold = &core.mold;
    [
        ("Fit", Command::Fit, false),
        ("Iso", Command::View(StandardView::Isometric), false),
        ("Front", Command::View(StandardView::Front), false),
        ("Right", Command::View(StandardView::Right), false),
        ("Top", Command::View(StandardView::Top), false),
        ("Layers", Command::Layers, mold.layer.is_some()),
        ("Depth", Command::DepthColours, mold.colours == RegionColours::ByDepth),
        ("Faint", Command::FaintMold, mold.is_faint),
        ("Isolate", Command::Isolate, mold.isolated),
    ]
}

/// How the answer stands, at the bottom of the view.
fn caption(ui: &mut Ui, rect: Rect, core: &Core) {
    let colours = palette(ui);
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
        StageState::Running => ("Loading…", ""),
        StageState::Failed(_) => ("This could not be loaded", "The panel on the left says why."),
        _ => {
            ("Drop a mold here", "STL, OBJ, glTF or GLB. Then say where it opens to, and find what the cutters leave.")
        }
    };
    let c = rect.center();
    let accent = palette(ui).accent;
    ui.painter().text(c - egui::vec2(0.0, 24.0), Align2::CENTER_CENTER, title, FontId::proportional(22.0), accent);
    let colour = egui::Color32::from_gray(150);
    ui.painter().text(pos2(c.x, c.y + 8.0), Align2::CENTER_CENTER, line, FontId::proportional(13.5), colour);
}
