//! Electrodes for what was found, made and exported on threads of their own.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use glam::DVec3;

use super::electrode_export::{Exported, export};
use super::{FoundUncut, LoadedMold, Question};
use crate::workspaces::blisk::pipeline::{EventKind, StageState};
use crate::workspaces::kept::{Doing, Kept, WorkEvent, note};
use crate::workspaces::mold::job::electrodes::electrodes;
use crate::workspaces::mold::report::ElectrodesReport;
use crate::workspaces::mold::scene::electrodes::{ElectrodeShape, electrode_shapes};
use crate::workspaces::worker::{Ended, Reporter, Worker};
use mold::electrode::design::{ElectrodeSet, PartNode};
use mold::electrode::overrides::Override;
use mold::electrode::params::ElectrodeParams;
use mold::opening::Opening;
use nc::burn_template::BurnSheet;
use nc::electrode_files::ElectrodeFormat;
use task::{Cancel, Progress};

/// Electrodes with all that is shown of them.
#[derive(Debug)]
pub struct Designed {
    /// They.
    pub set: ElectrodeSet,
    /// The same in figures and words, nothing overridden.
    pub report: ElectrodesReport,
    /// They for the screen.
    pub shapes: Vec<ElectrodeShape>,
    /// Where the mold opens to.
    pub opening: Opening,
    /// A place of each region's surface, upright, by which changes name it (mm).
    pub places: Vec<Option<DVec3>>,
}

impl Designed {
    /// The answer in a sentence if these are the user's overrides.
    pub fn sentence(&self, overrides: &[Override]) -> String {
        self.report.sentence_with(&self.set, overrides).replace("mm3", "mm³").replace("mm^3", "mm³")
    }

    /// A place in each part of a region that was not divided further, by its number, by which changes name it, upright (mm): none if
    /// the region is not burned straight down, or none was found.
    pub fn leaves(&self, region: usize) -> Vec<Option<DVec3>> {
        let Some(plan) = self.set.regions.get(region) else { return Vec::new() };
        let is_straight = plan.direction.dot(DVec3::NEG_Z) > 1.0 - 1e-12;
        let mut places = Vec::new();
        if let Some(tree) = &plan.tree {
            leaf_places(tree, plan.left.place.z, &mut places);
        }
        places.into_iter().map(|place| place.filter(|_| is_straight)).collect()
    }
}

fn leaf_places(node: &PartNode, z: f64, places: &mut Vec<Option<DVec3>>) {
    node.parts.iter().for_each(|part| leaf_places(part, z, places));
    if let Some(number) = node.part {
        places.resize(places.len().max(number + 1), None);
        places[number] = node.place.map(|p| p.extend(z));
    }
}

/// What is asked: of which mold and cutters, and for which electrodes.
type DesignQuestion = (Question, ElectrodeParams);

/// What of `params` electrodes depend on: not what they are called or which are exported.
fn asked(question: &Question, params: &ElectrodeParams) -> DesignQuestion {
    let params = ElectrodeParams { overrides: Vec::new(), material: String::new(), ..params.clone() };
    (question.clone(), params)
}

/// Makes electrodes, and exports them.
pub(super) struct Designer {
    worker: Worker<(), Designed>,
    made: Kept<DesignQuestion, Designed>,
    pub doing: Option<Doing>,
    /// Whether they are wanted as soon as it is known what is left.
    pub is_waiting: bool,
    exporter: Worker<(), Exported>,
    exporting: Option<Doing>,
}

impl Designer {
    pub fn start(wake: impl Fn() + Send + Sync + Clone + 'static) -> std::io::Result<Self> {
        Ok(Self {
            worker: Worker::start(wake.clone())?,
            made: Kept::default(),
            doing: None,
            is_waiting: false,
            exporter: Worker::start(wake)?,
            exporting: None,
        })
    }

    /// Takes in what was made. What other parameters lead to is of no use to anybody.
    pub fn follow(&mut self, question: Option<&Question>, params: &ElectrodeParams) -> Vec<WorkEvent> {
        let mut events = Vec::new();
        for message in self.worker.messages() {
            if !self.made.awaits(message.task()) {
                continue;
            }
            let Some((ended, took)) = note(&mut self.doing, "Electrodes", message) else { continue };
            let ended = self.made.end(ended, |made| made.sentence(&params.overrides));
            events.extend(ended.map(|said| event(said, took)));
        }
        for message in self.exporter.messages() {
            let Some((ended, took)) = note(&mut self.exporting, "Export of electrodes", message) else { continue };
            let said = match ended {
                Ended::Done(exported) => (EventKind::Done, exported.sentence()),
                Ended::Cancelled => (EventKind::Cancelled, "export cancelled".to_owned()),
                Ended::Failed(text) | Ended::Panicked(text) => (EventKind::Failed, text),
            };
            events.push(event(said, took));
        }
        let is_other = |of: &DesignQuestion| question.is_some_and(|question| asked(question, params) != *of);
        if self.made.running.as_ref().is_some_and(|(_, of)| is_other(of)) {
            self.worker.cancel_from(0);
        }
        events
    }

    pub fn state(&self, question: &Question, params: &ElectrodeParams) -> StageState {
        self.made.state(&asked(question, params))
    }

    /// Whether what was made last is of this.
    pub fn is_of(&self, question: &Question, params: &ElectrodeParams) -> bool {
        self.made.is_of(&asked(question, params))
    }

    /// What was made last, of a mold with this digest.
    pub fn made_of(&self, mold: &str) -> Option<&Arc<Designed>> {
        self.made.value.as_ref().filter(|((question, _), _)| question.0 == mold).map(|(_, made)| made)
    }

    pub fn has_made(&self) -> bool {
        self.made.value.is_some()
    }

    /// Makes electrodes for what was `found` of `mold`.
    pub fn design(
        &mut self,
        question: &Question,
        params: &ElectrodeParams,
        mold: Arc<LoadedMold>,
        found: Arc<FoundUncut>,
    ) {
        self.is_waiting = false;
        let asked_params = params.clone();
        let work = move |_: &Reporter<(), Designed>, progress: &Progress, cancel: &Cancel| {
            design(&mold, &found, &asked_params, progress, cancel)
        };
        let id = self.worker.submit(0, work);
        self.made.failure = None;
        self.made.running = Some((id, asked(question, params)));
    }

    /// Writes what was made into `folder`; `params` say which electrodes are let pass, and what they are called.
    pub fn export(
        &mut self,
        folder: &Path,
        (designed, mold): (Arc<Designed>, Arc<LoadedMold>),
        (name, params): (String, &ElectrodeParams),
        (formats, sheet): (Vec<ElectrodeFormat>, BurnSheet),
    ) {
        let (folder, params): (PathBuf, _) = (folder.to_owned(), params.clone());
        self.exporter.submit(0, move |_, progress, cancel| {
            let set = ElectrodeSet { params, ..designed.set.clone() };
            export(&folder, (&set, &designed), (&mold, &name), (&formats, &sheet), progress, cancel)
        });
    }

    pub fn doing(&self) -> Option<&Doing> {
        self.doing.as_ref().or(self.exporting.as_ref())
    }

    pub fn is_busy(&self) -> bool {
        self.is_waiting || self.worker.is_busy() || self.exporter.is_busy()
    }

    /// Stops what runs, at the user's wish.
    pub fn cancel(&mut self) {
        self.is_waiting = false;
        self.made.give_up();
        self.worker.cancel_from(0);
        self.exporter.cancel_from(0);
    }
}

fn event((kind, text): (EventKind, String), took: Option<Duration>) -> WorkEvent {
    WorkEvent { kind, text: format!("Electrodes: {text}"), took }
}

/// Makes them.
///
/// # Errors
/// One line for the user.
fn design(
    mold: &LoadedMold,
    found: &FoundUncut,
    params: &ElectrodeParams,
    progress: &Progress,
    cancel: &Cancel,
) -> Result<Designed, String> {
    let uncut = &found.uncut;
    let set = electrodes(&mold.mesh, uncut, params, progress, cancel).map_err(|e| e.to_string())?;
    cancel.check().map_err(|e| e.to_string())?;
    let mut places = vec![None; set.regions.len()];
    for piece in &uncut.surface {
        if let Some(place) = places.get_mut(piece.region as usize) {
            place.get_or_insert(piece.corners[0]);
        }
    }
    let opening = uncut.params.opening;
    let plain = ElectrodeSet { params: ElectrodeParams { overrides: Vec::new(), ..params.clone() }, ..set };
    let report = ElectrodesReport::of(&plain, &mold.name, opening);
    Ok(Designed { report, shapes: electrode_shapes(&plain), opening, places, set: plain })
}
