//! State of the view of electrodes.

use std::sync::Arc;

use glam::DVec3;

use crate::workspaces::mold::document::holder_files::load_holders;
use crate::workspaces::mold::scene::MoldLook;
use crate::workspaces::mold::scene::division::NodeAt;
use crate::workspaces::mold::scene::electrodes::{BurnCut, BurnOf, BurnPhase, BurnWay, ElectrodeScene};
use crate::workspaces::mold::work::Designed;
use geometry::mesh::Bounds;
use mold::electrode::design::{Burn, Electrode, RegionPlan};
use mold::electrode::params::{Edit, ElectrodeParams, Holder};
use nc::electrode_files::ElectrodeFormat;
use nc::template::BurnSheet;
use render::camera::Camera;
use render::scene::SectionPlane;

/// Number of steps of an electrode's motion.
const STEPS: f64 = 12.0;
/// Duration of playing the whole motion (s).
const WAY: f64 = 6.0;
/// Half the side of the box that the view flies to, as a share of the mold's diagonal.
const AROUND: f64 = 0.06;

/// Target of a flight of the view.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Fly {
    /// A box, to fill the view (in the axes of the mesh).
    Into(Bounds),
    /// Everything.
    All,
    /// A section.
    Onto(Camera),
    /// The view before the section.
    Back,
    /// From above the mold.
    Above,
}

/// A marked place.
#[derive(Debug, Clone, PartialEq)]
pub struct Pointed {
    /// Place in the upright mold (mm).
    pub at: DVec3,
    /// Text on the place, with its figures.
    pub text: String,
}

/// Part of the state that a picture depends on.
#[derive(Debug, Clone, PartialEq)]
pub struct Look {
    selected: Option<BurnOf>,
    is_alone: bool,
    exploded: f64,
    raised: f64,
    look: MoldLook,
    cut: Option<BurnCut>,
    place: Option<DVec3>,
    stage: usize,
    /// First end of the line along which a part is split; none before the first click.
    split: Option<Option<DVec3>>,
    /// Node of a tree of divisions that stands out.
    node: Option<NodeAt>,
}

/// The state of the view of electrodes: selection, section, motion and marks.
pub struct ElectrodeDesk {
    /// Whether electrodes are shown instead of regions.
    pub is_shown: bool,
    /// Burn that is selected.
    pub selected: Option<BurnOf>,
    /// Electrode that the list has scrolled to.
    pub scrolled_to: Option<usize>,
    /// Whether only the selected electrode is shown.
    pub is_alone: bool,
    /// Share by which electrodes are lifted out and apart, 0 to 1.
    pub exploded: f64,
    /// Look of the mold.
    pub look: MoldLook,
    /// Position of the selected electrode on its motion, 0 to 1; none in the burning position.
    pub time: Option<f64>,
    /// Whether the motion is played.
    pub is_playing: bool,
    /// Section through the selected burn.
    pub cut: Option<BurnCut>,
    /// Marked place.
    pub place: Option<Pointed>,
    /// Stage that is shown.
    pub stage: usize,
    /// Parts to merge: number of the region and of the part.
    pub parts: Vec<(usize, usize)>,
    /// Node of a tree of divisions that is selected.
    pub node: Option<NodeAt>,
    /// Node below the pointer, in this frame alone.
    pub hovered: Option<NodeAt>,
    /// Line along which a part is split; see [`Look`].
    pub split: Option<Option<DVec3>>,
    /// Whether the part is split along a face, which one click names, instead of along a line.
    pub is_split_along_face: bool,
    /// Region to split, if the line is drawn for one region.
    pub split_region: Option<usize>,
    /// Whether each format is written.
    pub formats: [bool; ElectrodeFormat::ALL.len()],
    /// Template of the burn sheet.
    pub sheet: BurnSheet,
    /// Target of the next flight of the view.
    pub fly: Option<Fly>,
    /// Whether electrodes are shown once they are made.
    pub is_awaited: bool,
    /// Available holders.
    pub holders: Vec<Holder>,
    shown: Option<Arc<Designed>>,
}

impl Default for ElectrodeDesk {
    fn default() -> Self {
        Self {
            is_shown: false,
            selected: None,
            scrolled_to: None,
            is_alone: false,
            exploded: 0.0,
            look: MoldLook::Faint,
            time: None,
            is_playing: false,
            cut: None,
            place: None,
            stage: 0,
            parts: Vec::new(),
            node: None,
            hovered: None,
            split: None,
            is_split_along_face: false,
            split_region: None,
            formats: [true, false, false, false],
            sheet: BurnSheet::standard(),
            fly: None,
            is_awaited: false,
            // Those of a broken file would be none: what the parameters name is there in any case.
            holders: load_holders(None).unwrap_or_default(),
            shown: None,
        }
    }
}

impl ElectrodeDesk {
    /// Resets the view for another mold. The choice of formats and the holders stay.
    pub fn begin_anew(&mut self) {
        let Self { formats, sheet, holders, .. } = std::mem::take(self);
        *self = Self { formats, sheet, holders, ..Self::default() };
    }

    /// Takes in new electrodes. The selection stays if an electrode of that name still exists.
    pub fn follow(&mut self, now: Option<&Arc<Designed>>) {
        if now.map(Arc::as_ptr) == self.shown.as_ref().map(Arc::as_ptr) {
            return;
        }
        let name = self.chosen().map(|(electrode, _)| electrode.name.clone());
        let is_first = self.shown.is_none();
        // A line that is being drawn goes on while its region is there: electrodes do not change what is left.
        let place = |made: Option<&Arc<Designed>>| made?.places.get(self.split_region?).copied().flatten();
        let goes_on = place(self.shown.as_ref()).is_some_and(|before| place(now) == Some(before));
        self.shown = now.cloned();
        // Those that were made again by themselves are not forced upon who looks at something else.
        let is_awaited = std::mem::take(&mut self.is_awaited);
        self.is_shown = now.is_some() && (is_first || is_awaited || self.is_shown);
        self.place = None;
        self.parts.clear();
        self.node = None;
        if !goes_on {
            self.give_up_split();
        }
        let electrodes = self.shown.as_ref().map_or(&[][..], |made| &made.set.electrodes);
        let same = name.and_then(|name| electrodes.iter().position(|e| e.name == name));
        let last = electrodes.iter().map(|e| e.stage).max().unwrap_or(0);
        self.stage = same.map_or(last, |e| electrodes[e].stage);
        self.selected = same.map(|electrode| BurnOf { electrode, burn: 0 });
        if same.is_none() {
            self.deselect();
        }
    }

    /// Electrodes to show.
    pub fn designed(&self) -> Option<&Arc<Designed>> {
        self.shown.as_ref()
    }

    /// The electrodes while they are shown, which they are not while a line is drawn on the mold.
    pub fn seen(&self) -> Option<&Arc<Designed>> {
        self.shown.as_ref().filter(|_| self.is_shown)
    }

    /// The selected electrode with its burn.
    pub fn chosen(&self) -> Option<(&Electrode, &Burn)> {
        self.selected?.find(&self.shown.as_ref()?.set)
    }

    /// Selects a burn, and resets what was shown of another one.
    pub fn select(&mut self, at: BurnOf) {
        if self.selected != Some(at) {
            (self.time, self.is_playing, self.place, self.node) = (None, false, None, None);
        }
        self.selected = Some(at);
        if let Some(stage) = self.chosen().map(|(electrode, _)| electrode.stage) {
            self.stage = stage;
        }
        if let Some(cut) = self.cut {
            self.look_onto(cut);
        }
    }

    /// Clears the selection.
    pub fn deselect(&mut self) {
        if self.cut.take().is_some() {
            self.fly = Some(Fly::Back);
        }
        (self.selected, self.is_alone, self.time, self.is_playing, self.place) = (None, false, None, false, None);
        self.node = None;
    }

    /// Motion of the selected burn.
    pub fn way(&self) -> Option<BurnWay> {
        let lift = self.shown.as_ref()?.set.retract();
        self.chosen().map(|(_, burn)| BurnWay::of(burn, lift))
    }

    /// Phase of the selected electrode's motion, and its height above the burning position (mm).
    pub fn moment(&self) -> Option<(BurnPhase, f64)> {
        Some(self.way()?.at(self.time?))
    }

    /// Moves the electrode by one step, forwards or backwards.
    pub fn step(&mut self, forward: bool) {
        // Where it has burned is two thirds of the way.
        let at = self.time.unwrap_or(2.0 / 3.0) * STEPS;
        let next = if forward { (at + 1e-6).floor() + 1.0 } else { (at - 1e-6).ceil() - 1.0 };
        (self.time, self.is_playing) = (Some((next / STEPS).clamp(0.0, 1.0)), false);
    }

    /// Starts or stops playing.
    pub fn play(&mut self) {
        self.is_playing = !self.is_playing;
        if self.is_playing && self.time.is_none_or(|t| t >= 1.0) {
            self.time = Some(0.0);
        }
    }

    /// Advances a playing motion by `seconds`.
    pub fn advance(&mut self, seconds: f64) {
        let time = self.time.unwrap_or(0.0) + seconds / WAY;
        self.time = Some(time.min(1.0));
        self.is_playing &= time < 1.0;
    }

    /// Shows or hides a section through the selected burn.
    pub fn toggle_cut(&mut self) {
        if self.cut.take().is_some() {
            self.fly = Some(Fly::Back);
        } else {
            self.look_onto(BurnCut { along_y: false, beside: 0.0 });
        }
    }

    /// Shows this section and flies to it.
    pub fn look_onto(&mut self, cut: BurnCut) {
        let (Some(made), Some(at)) = (&self.shown, self.selected) else { return };
        self.fly = cut.camera(at, &made.set, &made.shapes, made.opening).map(Fly::Onto);
        self.cut = Some(cut);
    }

    /// Plane of the section, in the axes of the mesh.
    pub fn plane(&self) -> Option<SectionPlane> {
        let (made, at, cut) = (self.seen()?, self.selected?, self.cut?);
        cut.plane(at, &made.set, &made.shapes, made.opening)
    }

    /// Marks a place of the upright `mold` with a text, and flies there.
    pub fn point_at(&mut self, place: DVec3, text: String, mold: &Bounds) {
        let Some(made) = &self.shown else { return };
        let at = made.opening.in_mesh(place);
        self.fly = Some(Fly::Into(Bounds { min: at, max: at }.grown(AROUND * mold.size().length())));
        self.place = Some(Pointed { at: place, text });
        // What burns there stands there, and is not cut.
        (self.exploded, self.time, self.is_playing, self.cut) = (0.0, None, false, None);
    }

    /// Marks a place of an electrode and shows its burn alone, because others would hide it.
    pub fn point_at_burn(&mut self, electrode: usize, (place, text): (DVec3, String), mold: &Bounds) {
        let Some(made) = self.shown.clone() else { return };
        let burn = made.set.electrodes.get(electrode).map_or(0, |e| burn_at(e, &made.set.regions, place));
        self.select(BurnOf { electrode, burn });
        self.is_alone = true;
        self.point_at(place, text, mold);
    }

    /// Flies to the selected burn.
    pub fn fly_to_selected(&mut self, mold: Bounds) {
        let bounds = self.scene(mold).zip(self.selected).and_then(|(scene, at)| scene.bounds(at));
        self.fly = bounds.map(|b| Fly::Into(b.grown(0.15 * b.size().length())));
    }

    /// Electrodes to show beside a mold with this box.
    pub fn scene(&self, mold: Bounds) -> Option<ElectrodeScene<'_>> {
        let made = self.seen().filter(|_| self.split.is_none())?;
        Some(ElectrodeScene {
            set: &made.set,
            shapes: &made.shapes,
            opening: made.opening,
            mold,
            stage: self.stage,
            selected: self.selected,
            is_alone: self.selected.is_some() && (self.is_alone || self.time.is_some() || self.cut.is_some()),
            exploded: self.exploded,
            raised: self.moment().map_or(0.0, |(_, height)| height),
            place: self.place.as_ref().map(|place| place.at),
        })
    }

    /// The part of the state that a picture depends on.
    pub(in crate::workspaces::mold::panels) fn picture(&self) -> Look {
        Look {
            selected: self.selected,
            is_alone: self.is_alone,
            exploded: self.exploded,
            raised: self.moment().map_or(-1.0, |(_, height)| height),
            look: self.look,
            cut: self.cut,
            place: self.place.as_ref().map(|place| place.at),
            stage: self.stage,
            split: self.split,
            node: self.hovered.or(self.node),
        }
    }

    /// Regions whose division is drawn in the view: the one that is split, else those of the selected electrode; while
    /// regions are shown instead of electrodes, the one that is `selected` there.
    pub fn divided(&self, selected: Option<usize>) -> Vec<usize> {
        if !self.is_shown {
            return selected.into_iter().collect();
        }
        if self.split.is_some() {
            return self.split_region.into_iter().collect();
        }
        let mut regions: Vec<usize> =
            self.chosen().iter().flat_map(|(e, _)| e.parts()).map(|part| part.region).collect();
        regions.dedup();
        regions
    }

    /// Starts drawing a line along which a part of this region is split.
    pub fn begin_split(&mut self, region: usize) {
        self.deselect();
        (self.split, self.split_region, self.fly) = (Some(None), Some(region), Some(Fly::Above));
        self.is_split_along_face = false;
    }

    /// Starts picking a face along which a part of this region is split.
    pub fn begin_split_along(&mut self, region: usize) {
        self.deselect();
        (self.split, self.split_region, self.is_split_along_face) = (Some(None), Some(region), true);
    }

    /// Stops drawing the line, or picking the face.
    pub fn give_up_split(&mut self) {
        (self.split, self.split_region, self.is_split_along_face) = (None, None, false);
    }

    /// Takes a click on the mold as the face, or as an end of the splitting line. Returns the change once the face or both
    /// ends are known.
    pub fn click(&mut self, place: DVec3) -> Option<Edit> {
        match self.split? {
            _ if self.is_split_along_face => {
                self.give_up_split();
                Some(Edit::SplitAlong { place })
            }
            None => {
                self.split = Some(Some(place));
                None
            }
            Some(first) => {
                self.give_up_split();
                (first != place).then_some(Edit::Split { line: [first, place] })
            }
        }
    }

    /// Formats to write.
    pub fn formats(&self) -> Vec<ElectrodeFormat> {
        ElectrodeFormat::ALL.into_iter().zip(self.formats).filter(|(_, is_on)| *is_on).map(|(f, _)| f).collect()
    }

    /// Export state of an electrode: whether it is exported despite a failed check, or need not be.
    pub fn is_let_pass(&self, electrode: usize, params: &ElectrodeParams) -> bool {
        let Some(made) = self.shown.as_ref().filter(|made| electrode < made.set.electrodes.len()) else { return false };
        !made.set.is_blocked_with(electrode, &params.overrides)
    }
}

/// The burn of an electrode that a place belongs to: among the burns for the region with most rest material there, or
/// among all, the one with the nearest axis.
fn burn_at(electrode: &Electrode, regions: &[RegionPlan], place: DVec3) -> usize {
    let is_left_there = |burn: &Burn| {
        let mut own = burn.parts.iter().filter_map(|part| regions.get(part.region));
        own.any(|plan| plan.left.place == place)
    };
    let off = |burn: &Burn| (place - burn.position).reject_from_normalized(electrode.direction).length();
    let key = |burn: &Burn| (!is_left_there(burn), off(burn));
    let nearest = electrode.burns.iter().enumerate().min_by(|(_, a), (_, b)| {
        let (a, b) = (key(a), key(b));
        a.0.cmp(&b.0).then(a.1.total_cmp(&b.1))
    });
    nearest.map_or(0, |(i, _)| i)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_click_names_a_face_and_two_clicks_a_line() {
        let mut desk = ElectrodeDesk::default();
        desk.begin_split_along(2);
        assert_eq!(desk.click(DVec3::X), Some(Edit::SplitAlong { place: DVec3::X }));
        assert_eq!((desk.split, desk.click(DVec3::X)), (None, None), "it ends with the click");
        desk.begin_split(2);
        assert_eq!(desk.click(DVec3::X), None);
        assert_eq!(desk.click(DVec3::Y), Some(Edit::Split { line: [DVec3::X, DVec3::Y] }));
    }

    #[test]
    fn the_division_of_a_selected_region_is_drawn_while_regions_are_shown() {
        let mut desk = ElectrodeDesk::default();
        assert_eq!((desk.divided(Some(3)), desk.divided(None)), (vec![3], vec![]));
        desk.is_shown = true;
        assert!(desk.divided(Some(3)).is_empty(), "no electrode is selected");
    }
}
