//! The work on a flank behind the window: what its files hold, a quick look while something is changed, the plan, and
//! its files.

mod curves;
mod stamps;
mod steps;
#[cfg(test)]
mod tests;

use std::path::{Path, PathBuf};
use std::sync::Arc;

use stamps::Stamp;

use crate::workspaces::blisk::pipeline::{EventKind, StageState};
use crate::workspaces::flank::document::{FlankDocument, FlankSource, MeshFlank, WallsFile};
use crate::workspaces::flank::export;
pub use crate::workspaces::flank::export::{ExportChoice, WrittenFlank};
use crate::workspaces::flank::inputs::{FromFile, walls_unit};
use crate::workspaces::glances::Glances;
use crate::workspaces::kept::{Doing, Kept, WorkEvent, note};
use crate::workspaces::worker::{Ended, Worker};
pub use curves::{AxisCurve, MachineCurves, Profile};
use import::Unit;
use nc::flank_job::{FlankResult, LoadedSurface};
pub use steps::{LoadedFlank, LoadedWalls, Planned, Sketch};

/// What a surface is read from: the source, and how often it was asked for.
type SourceKey = (FlankSource, u64);
/// The same of walls, and the unit of those that say none.
type WallsKey = (WallsFile, Unit, u64);
/// What is asked of a flank: of which files, and what.
pub type Question = (u64, FlankDocument);

/// See the module's page.
pub struct FlankWork {
    loader: Worker<(), LoadedFlank>,
    loading: Option<Doing>,
    source: Kept<SourceKey, LoadedFlank>,
    walls_loader: Worker<(), LoadedWalls>,
    loading_walls: Option<Doing>,
    walls: Kept<WallsKey, LoadedWalls>,
    sketches: Glances<Question, Sketch>,
    planner: Worker<(), Planned>,
    planning: Option<Doing>,
    planned: Kept<Question, Planned>,
    /// Whether a plan is wanted as soon as the files are there.
    is_waiting: bool,
    exporter: Worker<(), WrittenFlank>,
    exporting: Option<Doing>,
    reloads: u64,
}

impl FlankWork {
    /// Starts the workers; `wake` is called from them whenever something has happened.
    ///
    /// # Errors
    /// If the system gives no thread.
    pub fn start(wake: impl Fn() + Send + Sync + Clone + 'static) -> std::io::Result<Self> {
        Ok(Self {
            loader: Worker::start(wake.clone())?,
            loading: None,
            source: Kept::default(),
            walls_loader: Worker::start(wake.clone())?,
            loading_walls: None,
            walls: Kept::default(),
            sketches: Glances::start(wake.clone())?,
            planner: Worker::start(wake.clone())?,
            planning: None,
            planned: Kept::default(),
            is_waiting: false,
            exporter: Worker::start(wake)?,
            exporting: None,
            reloads: 0,
        })
    }

    /// Takes in what the workers have said, and loads what `document` names. Answers what has happened.
    pub fn follow(&mut self, document: &FlankDocument) -> Vec<WorkEvent> {
        let mut events = Vec::new();
        for message in self.loader.messages() {
            if self.source.awaits(message.task())
                && let Some((ended, took)) = note(&mut self.loading, "Surface", message)
                && let Some((kind, text)) = self.source.end(ended, LoadedFlank::sentence)
            {
                // A surface that comes with the program is no news.
                let is_news = kind != EventKind::Done || matches!(document.source, FlankSource::Mesh(_));
                events.extend(is_news.then(|| WorkEvent { kind, text: format!("Surface: {text}"), took }));
            }
        }
        for message in self.walls_loader.messages() {
            if self.walls.awaits(message.task())
                && let Some((ended, took)) = note(&mut self.loading_walls, "Walls", message)
                && let Some((kind, text)) = self.walls.end(ended, LoadedWalls::sentence)
            {
                events.push(WorkEvent { kind, text: format!("Walls: {text}"), took });
            }
        }
        for message in self.planner.messages() {
            if self.planned.awaits(message.task())
                && let Some((ended, took)) = note(&mut self.planning, "Flank", message)
                && let Some((kind, text)) = self.planned.end(ended, Planned::sentence)
            {
                events.push(WorkEvent { kind, text: format!("Flank: {text}"), took });
            }
        }
        for message in self.exporter.messages() {
            let Some((ended, took)) = note(&mut self.exporting, "Export", message) else { continue };
            let (kind, text) = match ended {
                Ended::Done(written) if written.blocked.is_some() => (EventKind::Refused, written.sentence()),
                Ended::Done(written) => (EventKind::Done, written.sentence()),
                Ended::Cancelled => (EventKind::Cancelled, "export cancelled".to_owned()),
                Ended::Failed(text) | Ended::Panicked(text) => (EventKind::Failed, text),
            };
            events.push(WorkEvent { kind, text: format!("Flank: {text}"), took });
        }
        self.sketches.follow();
        self.load(document);
        // What other parameters lead to is of no use to anybody.
        let question = self.question(document);
        if self.planned.running.as_ref().is_some_and(|(_, of)| *of != question) {
            self.planner.cancel_from(0);
        }
        if self.is_waiting && !self.is_loading(document) {
            self.is_waiting = false;
            if let Err(text) = self.plan(document) {
                events.push(WorkEvent { kind: EventKind::Failed, text: format!("Flank: {text}"), took: None });
            }
        }
        events
    }

    /// Loads what `document` names, unless that is done.
    fn load(&mut self, document: &FlankDocument) {
        let key = self.source_key(document);
        if matches!(self.source.state(&key), StageState::Missing | StageState::Stale) {
            let source = key.0.clone();
            let id = self.loader.submit(0, move |_, progress, cancel| steps::load(&source, progress, cancel));
            self.source.running = Some((id, key));
        }
        let Some(key) = self.walls_key(document) else { return };
        if matches!(self.walls.state(&key), StageState::Missing | StageState::Stale) {
            let (walls, unit) = (key.0.clone(), key.1);
            let id = self
                .walls_loader
                .submit(0, move |_, progress, cancel| steps::load_walls(&walls, unit, progress, cancel));
            self.walls.running = Some((id, key));
        }
    }

    /// What of the source has to be read: not which of its faces is chosen.
    fn source_key(&self, document: &FlankDocument) -> SourceKey {
        let source = match &document.source {
            FlankSource::Mesh(mesh) => FlankSource::Mesh(MeshFlank { candidate: 1, is_own_wall: true, ..mesh.clone() }),
            other => other.clone(),
        };
        (source, self.reloads)
    }

    fn walls_key(&self, document: &FlankDocument) -> Option<WallsKey> {
        Some((document.walls.clone()?, walls_unit(document), self.reloads))
    }

    /// What is asked: not what is exported in spite of a check, nor what the cutter is called.
    fn question(&self, document: &FlankDocument) -> Question {
        let mut asked = FlankDocument { overrides: Vec::new(), ..document.clone() };
        asked.cutter.name.clear();
        (self.reloads, asked)
    }

    /// Reads all files again.
    pub fn reload(&mut self) {
        self.reloads += 1;
    }

    /// How the surface's source stands.
    pub fn source_state(&self, document: &FlankDocument) -> StageState {
        self.source.state(&self.source_key(document))
    }

    /// How the walls stand.
    pub fn walls_state(&self, document: &FlankDocument) -> StageState {
        self.walls_key(document).map_or(StageState::Done, |key| self.walls.state(&key))
    }

    fn is_loading(&self, document: &FlankDocument) -> bool {
        [self.source_state(document), self.walls_state(document)].contains(&StageState::Running)
    }

    /// What `document` names, if it was read.
    pub fn loaded(&self, document: &FlankDocument) -> Option<&Arc<LoadedFlank>> {
        let key = self.source_key(document);
        self.source.value.as_ref().filter(|(of, _)| *of == key).map(|(_, loaded)| loaded)
    }

    /// The walls that `document` names, if they were read.
    pub fn walls(&self, document: &FlankDocument) -> Option<&Arc<LoadedWalls>> {
        let key = self.walls_key(document)?;
        self.walls.value.as_ref().filter(|(of, _)| *of == key).map(|(_, walls)| walls)
    }

    /// The surface of `document` with the face that it chose.
    fn surface(&self, document: &FlankDocument) -> Option<LoadedSurface> {
        let mut surface = self.loaded(document)?.surface.clone();
        if let (LoadedSurface::Face { number, is_own_wall, .. }, FlankSource::Mesh(mesh)) =
            (&mut surface, &document.source)
        {
            (*number, *is_own_wall) = (mesh.candidate, mesh.is_own_wall);
        }
        Some(surface)
    }

    /// How the plan of `document` stands.
    pub fn state(&self, document: &FlankDocument) -> StageState {
        if self.is_waiting { StageState::Running } else { self.planned.state(&self.question(document)) }
    }

    /// What was planned last, for whatever parameters.
    pub fn planned(&self) -> Option<&Arc<Planned>> {
        self.planned.value.as_ref().map(|(_, planned)| planned)
    }

    /// Whether that is of `document`, whatever is being worked on.
    pub fn is_planned_of(&self, document: &FlankDocument) -> bool {
        self.planned.is_of(&self.question(document))
    }

    /// Whether that is of the surface that `document` names, whatever cutter, side and walls it was planned with.
    pub fn is_planned_of_surface(&self, document: &FlankDocument) -> bool {
        let is_same = |of: &FlankSource| match (of, &document.source) {
            // Which other faces are walls is no matter of the surface.
            (FlankSource::Mesh(of), FlankSource::Mesh(asked)) => {
                *of == MeshFlank { is_own_wall: of.is_own_wall, ..asked.clone() }
            }
            (of, asked) => of == asked,
        };
        self.planned.value.as_ref().is_some_and(|((_, of), _)| is_same(&of.source))
    }

    /// Begins to plan.
    ///
    /// # Errors
    /// One line why it cannot be planned.
    pub fn plan(&mut self, document: &FlankDocument) -> Result<(), String> {
        document.validate()?;
        if self.is_loading(document) {
            self.is_waiting = true;
            return Ok(());
        }
        for state in [self.source_state(document), self.walls_state(document)] {
            if let StageState::Failed(why) = state {
                return Err(why);
            }
        }
        let surface = self.surface(document).zip(self.loaded(document)).ok_or("there is no surface yet")?;
        let surface = FromFile { value: surface.0, doubts: surface.1.doubts.clone() };
        let walls = self.walls(document);
        let walls = walls.map(|walls| FromFile { value: walls.mesh.clone(), doubts: walls.doubts.clone() });
        let question = self.question(document);
        let asked = document.clone();
        let id =
            self.planner.submit(0, move |_, progress, cancel| steps::plan(&asked, surface, walls, progress, cancel));
        self.planned.failure = None;
        self.planned.running = Some((id, question));
        Ok(())
    }

    /// Looks quickly at what `document` leads to, unless that is known or being looked at.
    pub fn sketch(&mut self, document: &FlankDocument) {
        let Some(surface) = self.surface(document) else { return };
        let (question, asked) = (self.question(document), document.clone());
        self.sketches.ask(question, move |cancel| Ok(steps::sketch(&asked, surface, cancel)));
    }

    /// What was seen at a glance of `document`; while it goes on changing (`is_held`) also of what it was before.
    pub fn sketched(&self, document: &FlankDocument, is_held: bool) -> Option<&Arc<Sketch>> {
        let question = self.question(document);
        let is_same = |of: &Question| of.1.source == question.1.source && of.1.side == question.1.side;
        self.sketches.seen(|of| *of == question || (is_held && is_same(of)))
    }

    /// Forgets what was seen at a glance.
    pub fn forget_sketch(&mut self) {
        self.sketches.forget();
    }

    /// What is being worked on.
    pub fn doing(&self) -> Option<&Doing> {
        let all = [&self.loading, &self.loading_walls, &self.planning, &self.exporting];
        all.into_iter().find_map(Option::as_ref)
    }

    /// Whether anything waits or runs, quick looks apart.
    pub fn is_busy(&self) -> bool {
        self.is_waiting
            || self.loader.is_busy()
            || self.walls_loader.is_busy()
            || self.planner.is_busy()
            || self.exporter.is_busy()
    }

    /// Whether a quick look is being taken.
    pub fn is_sketching(&self) -> bool {
        self.sketches.is_busy()
    }

    /// Stops what runs, at the user's wish: none of it begins again by itself.
    pub fn cancel(&mut self) {
        self.is_waiting = false;
        self.source.give_up();
        self.walls.give_up();
        self.planned.give_up();
        self.loader.cancel_from(0);
        self.walls_loader.cancel_from(0);
        self.planner.cancel_from(0);
        self.exporter.cancel_from(0);
    }

    /// What was planned for `document`, with the checks that it overrides and its name of the cutter.
    ///
    /// # Errors
    /// One line if there is no plan of it.
    pub fn to_export(&self, document: &FlankDocument) -> Result<FlankResult, String> {
        let planned = self.planned().filter(|_| self.is_planned_of(document));
        let planned = planned.ok_or("the plan is not of the present parameters: plan again")?;
        let mut result = planned.result.clone();
        result.decide(&document.overrides);
        Ok(result.with_cutter_name(&document.cutter.name))
    }

    /// The files that were read for `document` and have changed since: its plan is not of what they hold now.
    pub fn changed_files(&self, document: &FlankDocument) -> Vec<PathBuf> {
        let source = self.loaded(document).into_iter().flat_map(|loaded| &loaded.stamps);
        let walls = self.walls(document).into_iter().map(|walls| &walls.stamp);
        source.chain(walls).filter_map(Stamp::changed).map(Path::to_owned).collect()
    }

    /// Writes the files of the plan into `folder`: of one of which a check fails that is not overridden only the report.
    ///
    /// # Errors
    /// One line if there is no plan of `document`.
    pub fn export(&mut self, document: &FlankDocument, folder: &Path, choice: ExportChoice) -> Result<(), String> {
        let result = self.to_export(document)?;
        let (folder, document) = (folder.to_owned(), document.clone());
        self.exporter.submit(0, move |_, progress, cancel| {
            export::export(&folder, (&result, &document), choice, progress, cancel)
        });
        Ok(())
    }
}
