//! The state of the workspace: the mold, the results, and how they are shown.

use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use super::datum_pick::DatumPick;
use super::electrode::desk::ElectrodeDesk;
use crate::widgets::form::Answer;
use crate::workspaces::context::{Context, rest_left};
use crate::workspaces::hands::{Gesture, Hands};
use crate::workspaces::mold::document::holder_files::load_holders;
use crate::workspaces::mold::document::standard::standard_mold;
use crate::workspaces::mold::document::{MoldParams, fields};
use crate::workspaces::mold::job::uncut::LayerFound;
use crate::workspaces::mold::scene::RegionColours;
use crate::workspaces::mold::work::{FoundUncut, Glance, MoldWork};
use crate::workspaces::news::{EventKind, WorkEvent};
use files::{AnyDocument, Document};
use geometry::mesh::Bounds;
use glam::DVec3;
use mold::cutter::CutterLibrary;
use mold::electrode::given::GivenName;
use mold::uncut_region::UncutRegion;
use task::{Priority, Scheduler, State};

/// Delay after the last change until a preview is followed by the exact result (s).
const REST: f64 = 0.3;
/// Delay after the last change until electrodes are made again (s): a user who changes one setting often changes
/// another.
const REST_OF_DESIGN: f64 = 1.2;

/// A column of the list.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(missing_docs)]
pub enum Column {
    Index,
    Volume,
    Area,
    Height,
    Nearest,
}

impl Column {
    /// All columns.
    pub const ALL: [Self; 5] = [Self::Index, Self::Volume, Self::Area, Self::Height, Self::Nearest];

    /// Sort key of the region number `i`.
    pub fn key(self, region: &UncutRegion, i: usize) -> f64 {
        match self {
            Self::Index => i as f64,
            Self::Volume => region.volume,
            Self::Area => region.plan_area,
            Self::Height => region.depth,
            Self::Nearest => region.nearest_cutter.map_or(-1.0, |c| c as f64),
        }
    }
}

/// The mold, the results, and how they are shown.
pub struct MoldDesk {
    /// Whether the panel on the left is open.
    pub shows_panel: bool,
    /// Whether the list of regions or electrodes is open, where it has its own panel.
    pub shows_list: bool,
    /// Whether a small window shows the list in place of the panel on the left.
    pub shows_list_instead: bool,
    /// Whether the window is small.
    pub is_small: bool,
    /// The mold with its parameters.
    pub document: Document<MoldParams>,
    /// Results computed from the parameters.
    pub work: MoldWork,
    /// Region that is selected.
    pub selected: Option<usize>,
    /// Region that the list has scrolled to.
    pub scrolled_to: Option<usize>,
    /// Whether only the selected region is shown.
    pub isolated: bool,
    /// Meaning of the colours of regions.
    pub colours: RegionColours,
    /// Whether the mold is shown transparent.
    pub is_faint: bool,
    /// Whether undercut faces are shown in their own colour.
    pub shows_invert: bool,
    /// Layer that is shown.
    pub layer: Option<usize>,
    /// Sort column of the list, and whether the greatest comes first.
    pub sort: (Column, bool),
    /// Least volume of regions that are shown (mm^3).
    pub least_volume: f64,
    /// Other cutters, for the comparison.
    pub other: CutterLibrary,
    /// Whether only regions are shown that vanish with the other cutters.
    pub only_vanishing: bool,
    /// Whether a change starts the exact search, once there was a result, and the electrodes, once they were made.
    pub follows: bool,
    /// Region that the view flies to next.
    pub fly_to: Option<usize>,
    /// How the work datum is being picked.
    pub pick: Option<DatumPick>,
    /// Place of the CAD program's face that was clicked, in the axes of the file (mm), and the face in words.
    pub face: Option<(DVec3, String)>,
    /// Parameters of the last frame.
    followed: MoldParams,
    gesture: Gesture,
    /// Parameters of a new mold: the user's own standard.
    standard: MoldParams,
    /// The time of the last frame (s).
    now: f64,
    /// Time of the last change without a result.
    edited: Option<f64>,
    /// Time of the last change that electrodes depend on, until they are made again.
    changed: Option<f64>,
    /// State of the electrodes.
    pub electrodes: ElectrodeDesk,
    /// Result that the present selection belongs to.
    shown: Option<Arc<FoundUncut>>,
}

impl MoldDesk {
    /// The state without a mold.
    pub fn new(scheduler: &Scheduler) -> Self {
        let electrodes = ElectrodeDesk::default();
        let mut params = MoldParams::default();
        params.electrodes.holders.clone_from(&electrodes.holders);
        Self {
            shows_panel: true,
            shows_list: true,
            shows_list_instead: false,
            is_small: false,
            other: params.library.clone(),
            standard: params.clone(),
            followed: params.clone(),
            document: Document::new(params),
            gesture: Gesture::default(),
            work: MoldWork::new(scheduler),
            selected: None,
            face: None,
            scrolled_to: None,
            isolated: false,
            colours: RegionColours::default(),
            is_faint: false,
            shows_invert: true,
            layer: None,
            sort: (Column::Volume, true),
            least_volume: 0.0,
            only_vanishing: false,
            follows: true,
            fly_to: None,
            pick: None,
            now: 0.0,
            edited: None,
            changed: None,
            electrodes,
            shown: None,
        }
    }

    /// Opens or folds the panel on the left. A small window shows either the panel or the list.
    pub fn fold_panel(&mut self) {
        if self.is_small && self.shows_list_instead {
            (self.shows_panel, self.shows_list_instead) = (true, false);
        } else {
            self.shows_panel = !self.shows_panel;
        }
    }

    /// Reads the standard of molds and the holders from the user's folder. Returns a line for each error; the built-in
    /// values are then used.
    pub fn take_user_files(&mut self, folder: &Path) -> Vec<String> {
        let mut wrong = Vec::new();
        match load_holders(Some(folder)) {
            Ok(holders) => self.electrodes.holders = holders,
            Err(error) => wrong.push(error.to_string()),
        }
        match standard_mold(Some(folder)) {
            // These are where a mold begins, and no change of the user's.
            Ok(standard) => {
                self.standard = standard.clone();
                self.replace(Document::new(standard));
            }
            // What both say is said once.
            Err(error) => wrong.extend(Some(error.to_string()).filter(|text| !wrong.contains(text))),
        }
        wrong
    }

    /// The parameters.
    pub fn params(&self) -> &MoldParams {
        self.document.params()
    }

    /// A new document for the mesh at `mesh`: with the present cutters, and without decisions for another mold. If
    /// there was no mold before but the demonstration mold, other unsaved choices are kept for this one.
    pub fn begun(&self, mesh: &Path) -> Document<MoldParams> {
        let params = self.params();
        if params.mesh.is_none() {
            let mut document = self.document.detached();
            document.amend(true, |params| {
                *params = MoldParams { mesh: Some(mesh.to_owned()), part: None, ..params.undecided() };
            });
            return document;
        }
        let (mesh, library) = (Some(mesh.to_owned()), params.library.clone());
        Document::new(MoldParams { mesh, library, ..self.standard.clone() })
    }

    /// Replaces the document.
    pub fn replace(&mut self, document: Document<MoldParams>) {
        self.document = document;
        let holders = &self.electrodes.holders;
        self.document.amend(true, |params| {
            if params.electrodes.holders.is_empty() {
                params.electrodes.holders.clone_from(holders);
            }
        });
        self.followed = self.params().clone();
        (self.edited, self.changed) = (None, None);
        self.work.begin_anew();
        // How the last mold was looked at would hide parts of this one.
        self.electrodes.begin_anew();
        (self.is_faint, self.layer, self.least_volume, self.only_vanishing) = (false, None, 0.0, false);
        self.pick = None;
    }

    /// Notes a fact about the part in the document, without computing anything anew.
    fn note(&mut self, is_in_file: bool, change: impl FnMut(&mut MoldParams)) {
        self.follow_params();
        self.document.amend(is_in_file, change);
        self.followed = self.params().clone();
    }

    /// Ties the parameters to the mold that was read, and takes the opening direction that is proposed for it if none
    /// was given. Decisions for another mold are dropped. Returns the report of that.
    fn follow_part(&mut self) -> Option<WorkEvent> {
        let mold = self.work.part(self.document.params())?;
        let part = mold.sha256.clone();
        let proposed = self.work.survey(self.document.params()).map(|found| found.proposal.opening);
        let MoldParams { part: own, opening, .. } = self.params();
        if own.as_ref().is_none_or(|own| *own == part) {
            if own.is_none() || (opening.is_none() && proposed.is_some()) {
                self.note(true, |params| {
                    params.part.get_or_insert_with(|| part.clone());
                    params.opening = params.opening.or(proposed);
                });
            }
            return None;
        }
        let now = MoldParams { opening: proposed, ..self.params().of_part(&part) };
        let dropped = now.dropped(self.params());
        self.document.complete_step(now);
        dropped.map(|text| WorkEvent { kind: EventKind::Refused, text: format!("Mold: {text}"), took: None })
    }

    /// Changes the parameters. While they go on changing they are previewed.
    pub fn edit(&mut self, params: MoldParams) {
        let label = fields::change(self.params(), &params);
        self.document.edit(&label, params, self.gesture.goes_on());
        self.follow_params();
    }

    /// Takes the answer of a form.
    pub fn take(&mut self, answer: Answer<MoldParams>, cx: &mut Context) {
        if let Some(edit) = answer.edit {
            self.edit(edit.params);
        }
        answer.said.into_iter().for_each(|said| cx.say_in_passing(said));
    }

    /// Notes a change of the parameters.
    fn follow_params(&mut self) {
        let params = self.document.params();
        if *params == self.followed {
            return;
        }
        // What is left depends neither on electrodes nor on where positions are counted from.
        let MoldParams { electrodes, datum, .. } = self.followed.clone();
        let is_asked_anew = MoldParams { electrodes, datum, ..params.clone() } != self.followed;
        self.followed = params.clone();
        self.changed = Some(self.now);
        if is_asked_anew {
            self.edited = self.changed;
        }
    }

    /// State of the result for the present parameters.
    pub fn state(&self) -> State {
        self.work.state(self.document.params())
    }

    fn check(&self) -> Result<(), String> {
        self.document.problem().map_or(Ok(()), |problem| Err(fields::FIELDS.in_window(problem)))
    }

    /// Starts the search for rest material.
    ///
    /// # Errors
    /// One line why the search cannot start.
    pub fn find(&mut self) -> Result<(), String> {
        self.edited = None;
        self.check()?;
        self.work.find(self.document.params())
    }

    /// Starts to make electrodes for the rest material, after searching it if needed.
    ///
    /// # Errors
    /// One line why electrodes cannot be made.
    pub fn design(&mut self) -> Result<(), String> {
        (self.edited, self.changed) = (None, None);
        self.check()?;
        self.electrodes.is_awaited = true;
        self.work.design(self.document.params())
    }

    /// Stops all work at the user's wish. None of it begins again by itself.
    pub fn cancel(&mut self) {
        self.electrodes.is_awaited = false;
        self.work.cancel();
    }

    /// State of the electrodes for the present parameters.
    pub fn design_state(&self) -> State {
        self.work.design_state(self.document.params())
    }

    /// Whether the electrodes that are shown are those of the present parameters.
    pub fn is_designed(&self) -> bool {
        self.work.is_designed_of(self.document.params())
    }

    /// Takes in finished work, once a frame. Returns the reports, and the time until the next action.
    pub fn follow(&mut self, hands: Hands, is_seen: bool, now: f64) -> (Vec<WorkEvent>, Option<Duration>) {
        self.now = now;
        self.gesture.follow(hands, &mut self.document);
        self.follow_params();
        let priority = if is_seen { Priority::Shown } else { Priority::Normal };
        let mut events = self.work.follow(self.document.params(), priority);
        let read = self.work.mold().filter(|_| self.document.params().mesh.is_some());
        read.into_iter().for_each(|mold| self.document.note_file(&mold.file));
        events.extend(self.follow_part());
        self.follow_answer();
        self.electrodes.follow(self.work.designed());
        self.keep_names();
        let waits = [self.find_again(hands), self.design_again(hands)];
        let mut wait: Option<Duration> = None;
        for next in waits {
            match next {
                Ok(next) => wait = [wait, next].into_iter().flatten().min(),
                Err(text) => events.push(WorkEvent { kind: EventKind::Failed, text, took: None }),
            }
        }
        (events, wait)
    }

    /// Keeps the names of electrodes: a name, once given, stays through changes and undo.
    fn keep_names(&mut self) {
        let Some(made) = self.work.designed().filter(|_| self.is_designed()) else { return };
        let known = &self.params().electrodes.names;
        let is_new = |name: &&GivenName| known.iter().all(|known| known.number != name.number);
        let new: Vec<GivenName> = made.set.names.iter().filter(is_new).cloned().collect();
        if new.is_empty() {
            return;
        }
        let names = [known.clone(), new].concat();
        // From what the file holds the same names are made again.
        let is_saved = !self.document.is_unsaved();
        self.note(is_saved, |params| params.electrodes.names.clone_from(&names));
    }

    /// Previews a change, and searches exactly once nothing changes any more. Returns the time until the next action.
    fn find_again(&mut self, hands: Hands) -> Result<Option<Duration>, String> {
        let state = self.state();
        if state == State::Ready {
            self.edited = None;
            self.work.forget_glance();
        }
        let Some(edited) = self.edited else { return Ok(None) };
        self.work.glance(self.document.params());
        let can_follow = self.follows && state == State::Stale && self.document.problem().is_none();
        if !can_follow || hands == Hands::Holding {
            return Ok(None);
        }
        let wait = rest_left(edited, REST, self.now);
        if wait.is_zero() { self.find().map(|()| None) } else { Ok(Some(wait)) }
    }

    /// Makes outdated electrodes again, in all stages, once nothing changes any more and the rest material is known.
    /// Returns the time until the next action.
    fn design_again(&mut self, hands: Hands) -> Result<Option<Duration>, String> {
        let Some(changed) = self.changed else { return Ok(None) };
        let state = self.design_state();
        if state == State::Ready {
            self.changed = None;
        }
        let is_again = match state {
            State::Stale => self.state() == State::Ready,
            // They were asked for, and the change came before there were any.
            State::Missing => self.electrodes.is_awaited,
            _ => false,
        };
        // A line that is being drawn would be lost.
        let is_free = hands != Hands::Holding && self.electrodes.split.is_none();
        if !(self.follows && is_again && is_free && self.document.problem().is_none()) {
            return Ok(None);
        }
        let wait = rest_left(changed, REST_OF_DESIGN, self.now);
        if !wait.is_zero() {
            return Ok(Some(wait));
        }
        self.changed = None;
        self.work.design(self.document.params()).map(|()| None)
    }

    /// Clears the selection if it belongs to another result.
    fn follow_answer(&mut self) {
        let now = self.work.found();
        if now.map(Arc::as_ptr) == self.shown.as_ref().map(Arc::as_ptr) {
            return;
        }
        let is_same = |(before, now): (&Arc<FoundUncut>, &Arc<FoundUncut>)| {
            before.uncut.params == now.uncut.params && before.uncut.regions == now.uncut.regions
        };
        if self.shown.as_ref().zip(now).is_some_and(is_same) {
            // What was kept was proven.
            self.shown = now.cloned();
            return;
        }
        // A layer of the same mold is looked for again at about the same height.
        let height = self.layer().map(|(layer, _)| layer.z);
        self.shown = now.cloned();
        (self.selected, self.isolated, self.fly_to) = (None, false, None);
        self.layer = height.and_then(|z| {
            let layers = &self.shown.as_ref()?.uncut.layers;
            let off = |i: &usize| (layers[*i].z - z).abs();
            (0..layers.len()).min_by(|a, b| off(a).total_cmp(&off(b)))
        });
    }

    /// The result that is shown: of the present parameters or of earlier ones.
    pub fn found(&self) -> Option<&Arc<FoundUncut>> {
        self.shown.as_ref()
    }

    /// Label of the shown result if it is out of date.
    pub fn found_of_others(&self) -> Option<&'static str> {
        let found = self.shown.as_ref().filter(|_| !self.work.is_found_of(self.document.params()))?;
        let is_of_cutters = found.uncut.params.library != self.document.params().library;
        Some(if is_of_cutters { "Out of date (other cutters)" } else { "Out of date" })
    }

    /// The preview of the present parameters, or while they are dragged of the last ones.
    pub fn glanced(&self) -> Option<&Arc<Glance>> {
        self.work.glanced(self.document.params(), self.gesture.is_holding())
    }

    /// Uncut regions.
    pub fn regions(&self) -> &[UncutRegion] {
        self.shown.as_ref().map_or(&[], |found| &found.uncut.regions)
    }

    /// The box around a region in the axes of the mesh (mm).
    pub fn bounds(&self, region: usize) -> Option<Bounds> {
        let uncut = &self.shown.as_ref()?.uncut;
        let Bounds { min, max } = uncut.regions.get(region)?.bounds;
        Some(Bounds::of([min, max].map(|p| uncut.params.opening.in_mesh(p))))
    }

    /// The layer that is shown, with its number.
    pub fn layer(&self) -> Option<(&LayerFound, usize)> {
        let number = self.layer?;
        Some((self.shown.as_ref()?.uncut.layers.get(number)?, number))
    }

    /// Shows layers, beginning with the one that has most rest material, or hides them.
    pub fn toggle_layers(&mut self) {
        let layers = self.shown.as_ref().map_or(&[][..], |found| &found.uncut.layers);
        // Of equals the highest: less of the mold is cut away.
        let fullest = (0..layers.len()).max_by(|&a, &b| layers[a].area.total_cmp(&layers[b].area));
        self.layer = if self.layer.is_some() { None } else { fullest };
    }

    /// Numbers of the regions in the order of the list.
    pub fn listed(&self) -> Vec<usize> {
        let regions = self.regions();
        let other = self.work.other().filter(|_| self.only_vanishing);
        let is_listed =
            |i: &usize| regions[*i].volume >= self.least_volume && other.is_none_or(|other| other.1.vanishes(*i));
        let mut listed: Vec<usize> = (0..regions.len()).filter(is_listed).collect();
        let (column, falls) = self.sort;
        listed.sort_by(|&a, &b| {
            let by_column = column.key(&regions[a], a).total_cmp(&column.key(&regions[b], b));
            if falls { by_column.reverse() } else { by_column }
        });
        listed
    }

    /// Whether the view shows each region.
    pub fn is_visible(&self) -> Vec<bool> {
        let mut visible = vec![false; self.regions().len()];
        self.listed().into_iter().for_each(|i| visible[i] = true);
        if let (true, Some(selected)) = (self.isolated, self.selected) {
            visible.iter_mut().enumerate().for_each(|(i, visible)| *visible = i == selected);
        }
        visible
    }

    /// Name of the best cutter for a region.
    pub fn nearest(&self, region: &UncutRegion) -> String {
        let library = self.shown.as_ref().map(|found| &found.uncut.params.library);
        let cutter = region.nearest_cutter.and_then(|i| library?.cutter.get(i));
        cutter.map_or("\u{2013}".to_owned(), |c| c.label())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_users_lists_are_where_a_mold_begins_and_what_is_wrong_with_them_is_said() {
        let folder = tempfile::tempdir().unwrap();
        let mut desk = MoldDesk::new(&Scheduler::manual(|| ()));
        let standard = load_holders(None).unwrap();
        assert!(desk.params().electrodes.holders == standard && desk.electrodes.holders == standard);
        std::fs::create_dir(folder.path().join("holders")).unwrap();
        let supplier = folder.path().join("holders/Acme.toml");
        std::fs::write(&supplier, "[[holder]]\nname = \"20\"\nsize_mm = [20.0, 20.0]\nheight_mm = 12.0\n").unwrap();
        let standard = "kind = \"mold\"\ntolerance_mm = 0.05\n[electrodes]\nmargin_mm = 0.7";
        std::fs::write(folder.path().join("mold.sparkpath"), standard).unwrap();
        assert!(desk.take_user_files(folder.path()).is_empty() && !desk.document.is_unsaved());
        let asked = desk.params().electrodes.clone();
        assert_eq!((asked.margin_mm, asked.holders[0].name.as_str(), asked.holders.len()), (0.7, "Acme: 20", 1));
        assert_eq!((&desk.electrodes.holders, desk.params().tolerance_mm), (&asked.holders, 0.05));
        // A mold that names no holder has the user's.
        desk.replace(Document::default());
        assert_eq!(desk.params().electrodes.holders, asked.holders);
        std::fs::write(&supplier, "holder = 1").unwrap();
        let wrong = desk.take_user_files(folder.path());
        assert!(wrong.len() == 1 && wrong[0].contains("Acme.toml"), "{wrong:?}");
        assert_eq!(desk.electrodes.holders, asked.holders, "what was there stays");
    }
}
