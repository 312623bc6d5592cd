//! The background work on a flank: reading its files, previews, the plan, and the export.

mod curves;
mod stamps;
mod steps;
#[cfg(test)]
mod tests;

use std::path::{Path, PathBuf};
use std::sync::Arc;

use files::{PartFile, Validate, files_in};
use task::{Doing, Lane, Memo, Priority, Scheduler, State, Task};

use stamps::Stamp;

use crate::workspaces::flank::comparison::{Row, Variant, best};
use crate::workspaces::flank::document::fields::FIELDS;
use crate::workspaces::flank::document::{FlankDocument, FlankSource, MeshFlank, WallsFile};
use crate::workspaces::flank::export;
pub use crate::workspaces::flank::export::{ExportChoice, WrittenFlank};
use crate::workspaces::flank::inputs::{FromFile, walls_unit};
use crate::workspaces::news::{EventKind, WorkEvent};
use crate::workspaces::opening::await_drives;
pub use curves::{AxisCurve, MachineCurves, Profile};
use geometry::mesh::Mesh;
use import::Unit;
use nc::flank_job::{FlankResult, LoadedSurface};
pub use steps::{LoadedFlank, LoadedWalls, Planned, Sketch};

/// What a surface is read from: the source, and how often it was asked for.
type SourceKey = (FlankSource, u64);
/// What walls are read from: the file, the unit of those that say none, and how often they were asked for.
type WallsKey = (WallsFile, Unit, u64);

/// What a plan depends on.
#[derive(Debug, Clone, PartialEq)]
struct Question {
    /// The parameters, but for those that change no path.
    document: FlankDocument,
    /// The files as they were read. A file that was written since and is read again is another one.
    files: Vec<Stamp>,
    /// How often the files were asked for: those of machine and post have no stamps.
    reloads: u64,
}

/// Surface and walls as they were read.
type ReadFlank = (FromFile<LoadedSurface>, Option<FromFile<Arc<Mesh>>>);

/// Everything that is computed for a flank.
pub struct FlankWork {
    /// One surface is remembered, and one set of walls: who comes back to a file reads it as it is then.
    source: Memo<SourceKey, LoadedFlank>,
    walls: Memo<WallsKey, LoadedWalls>,
    sketches: Memo<Question, Sketch>,
    /// Plans with their shapes are large: a few are remembered, so that undo is instant.
    planned: Memo<Question, Planned>,
    /// Plans side by side.
    compared: Memo<(Question, Vec<Variant>), Vec<Row>>,
    new_rows: Option<Arc<Vec<Row>>>,
    /// Whether a plan is wanted as soon as the files are there.
    is_waiting: bool,
    exported: Memo<u64, WrittenFlank>,
    exports: u64,
    reloads: u64,
    priority: Priority,
}

impl FlankWork {
    /// The work on a flank without any result yet.
    pub fn new(scheduler: &Scheduler) -> Self {
        Self {
            source: Memo::new(scheduler, Lane::Quick, "Surface").remembering(1),
            walls: Memo::new(scheduler, Lane::Quick, "Walls").remembering(1),
            sketches: Memo::new(scheduler, Lane::Quick, "Quick look").letting_finish().remembering(2),
            planned: Memo::new(scheduler, Lane::Long, "Flank").remembering(4),
            compared: Memo::new(scheduler, Lane::Long, "Comparison").remembering(1),
            new_rows: None,
            is_waiting: false,
            exported: Memo::new(scheduler, Lane::Long, "Export").awaiting_the_end().remembering(1),
            exports: 0,
            reloads: 0,
            priority: Priority::Normal,
        }
    }

    /// Takes in what has been made, and loads what `document` names. Returns what has happened.
    pub fn follow(&mut self, document: &FlankDocument, priority: Priority) -> Vec<WorkEvent> {
        self.priority = priority;
        let mut events = Vec::new();
        while let Some(ended) = self.source.take() {
            let event = WorkEvent::of("Surface", ended, |loaded| (EventKind::Done, loaded.sentence()));
            // A surface that comes with the program is no news.
            if event.kind != EventKind::Done || matches!(document.source, FlankSource::Mesh(_)) {
                events.push(event);
            }
        }
        while let Some(ended) = self.walls.take() {
            events.push(WorkEvent::of("Walls", ended, |walls| (EventKind::Done, walls.sentence())));
        }
        while let Some(ended) = self.planned.take() {
            events.push(WorkEvent::of("Flank", ended, |planned| (EventKind::Done, planned.sentence())));
        }
        while let Some(ended) = self.compared.take() {
            events.push(WorkEvent::of("Comparison", ended, |rows| (EventKind::Done, best_words(rows))));
            self.new_rows = self.compared.last().map(|(_, rows)| rows.clone());
        }
        while let Some(ended) = self.exported.take() {
            let kind =
                |written: &WrittenFlank| written.blocked.as_ref().map_or(EventKind::Done, |_| EventKind::Refused);
            events.push(WorkEvent::of("Flank", ended, |written| (kind(written), written.sentence())));
        }
        self.load(document);
        let question = self.question(document);
        self.sketches.turn_to(&question);
        self.planned.turn_to(&question);
        self.planned.prioritise(priority);
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
        let source = key.0.clone();
        let (named, also_named) = (files_in(document), files_in(document));
        self.source.ask(&key, self.priority, move |work| {
            await_drives(&named, &work.task)?;
            steps::load(&source, &work.task)
        });
        let Some(key) = self.walls_key(document) else { return };
        let (walls, unit) = (key.0.clone(), key.1);
        self.walls.ask(&key, self.priority, move |work| {
            await_drives(&also_named, &work.task)?;
            steps::load_walls(&walls, unit, &work.task)
        });
    }

    fn source_key(&self, document: &FlankDocument) -> SourceKey {
        (source_to_read(&document.source), self.reloads)
    }

    /// Reads the source of `document`.
    ///
    /// # Errors
    /// One line naming file, place and remedy.
    pub fn read(document: &FlankDocument, task: &Task) -> Result<LoadedFlank, String> {
        steps::load(&source_to_read(&document.source), task)
    }

    /// Takes `loaded` for what the files of the source of `document` hold.
    pub fn put(&mut self, document: &FlankDocument, loaded: Arc<LoadedFlank>) {
        let key = self.source_key(document);
        self.source.put(&key, loaded);
    }

    fn walls_key(&self, document: &FlankDocument) -> Option<WallsKey> {
        Some((document.walls.clone()?, walls_unit(document), self.reloads))
    }

    /// What is asked: not what is exported in spite of a check, nor what the cutter is called.
    fn question(&self, document: &FlankDocument) -> Question {
        let mut asked = FlankDocument { overrides: Vec::new(), ..document.clone() };
        asked.cutter.name.clear();
        Question { document: asked, files: self.stamps(document).cloned().collect(), reloads: self.reloads }
    }

    /// The files of `document` as they were read.
    fn stamps(&self, document: &FlankDocument) -> impl Iterator<Item = &Stamp> {
        let source = self.loaded(document).into_iter().flat_map(|loaded| &loaded.stamps);
        source.chain(self.walls(document).into_iter().map(|walls| &walls.stamp))
    }

    /// The files of `document` with what they held when they were read.
    pub fn files(&self, document: &FlankDocument) -> Vec<PartFile> {
        let source = self.loaded(document).into_iter().flat_map(|loaded| &loaded.files);
        source.chain(self.walls(document).and_then(|walls| walls.file.as_ref())).cloned().collect()
    }

    /// Reads all files again.
    pub fn reload(&mut self) {
        self.reloads += 1;
    }

    /// How the surface's source stands.
    pub fn source_state(&self, document: &FlankDocument) -> State {
        self.source.state(&self.source_key(document))
    }

    /// How the walls stand.
    pub fn walls_state(&self, document: &FlankDocument) -> State {
        self.walls_key(document).map_or(State::Ready, |key| self.walls.state(&key))
    }

    fn is_loading(&self, document: &FlankDocument) -> bool {
        [self.source_state(document), self.walls_state(document)].contains(&State::Running)
    }

    /// What `document` names, if it was read.
    pub fn loaded(&self, document: &FlankDocument) -> Option<&Arc<LoadedFlank>> {
        self.source.get(&self.source_key(document))
    }

    /// The walls that `document` names, if they were read.
    pub fn walls(&self, document: &FlankDocument) -> Option<&Arc<LoadedWalls>> {
        self.walls.get(&self.walls_key(document)?)
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
    pub fn state(&self, document: &FlankDocument) -> State {
        if self.is_waiting { State::Running } else { self.planned.state(&self.question(document)) }
    }

    /// What was planned or asked for last, for whatever parameters.
    pub fn planned(&self) -> Option<&Arc<Planned>> {
        self.planned.last().map(|(_, planned)| planned)
    }

    /// Whether that is of `document`, whatever is being worked on.
    pub fn is_planned_of(&self, document: &FlankDocument) -> bool {
        self.planned.last().is_some_and(|(of, _)| *of == self.question(document))
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
        self.planned.last().is_some_and(|(of, _)| is_same(&of.document.source))
    }

    /// Begins to plan.
    ///
    /// # Errors
    /// One line why it cannot be planned.
    pub fn plan(&mut self, document: &FlankDocument) -> Result<(), String> {
        document.validate().map_err(|e| FIELDS.in_window(&e))?;
        if self.is_loading(document) {
            self.is_waiting = true;
            return Ok(());
        }
        let (surface, walls) = self.read_for(document)?;
        let (question, asked) = (self.question(document), document.clone());
        self.planned.restart(&question, self.priority, move |work| steps::plan(&asked, surface, walls, &work.task));
        Ok(())
    }

    /// Surface and walls of `document` as they were read.
    fn read_for(&self, document: &FlankDocument) -> Result<ReadFlank, String> {
        for state in [self.source_state(document), self.walls_state(document)] {
            if let Some(why) = state.why_not() {
                return Err(why.to_owned());
            }
        }
        let surface = self.surface(document).zip(self.loaded(document)).ok_or("there is no surface yet")?;
        let surface = FromFile { value: surface.0, doubts: surface.1.doubts.clone() };
        let walls = self.walls(document);
        Ok((surface, walls.map(|walls| FromFile { value: walls.mesh.clone(), doubts: walls.doubts.clone() })))
    }

    /// Begins to plan with each of `variants`.
    ///
    /// # Errors
    /// One line why it cannot be planned.
    pub fn compare(&mut self, document: &FlankDocument, variants: &[Variant]) -> Result<(), String> {
        document.validate().map_err(|e| FIELDS.in_window(&e))?;
        let (surface, walls) = self.read_for(document)?;
        let key = (self.question(document), variants.to_vec());
        let (asked, variants) = (document.clone(), variants.to_vec());
        self.compared
            .restart(&key, self.priority, move |work| steps::compare(&asked, surface, walls, (&variants, &work.task)));
        Ok(())
    }

    /// The rows of a comparison that has just ended, once.
    pub fn take_compared(&mut self) -> Option<Arc<Vec<Row>>> {
        self.new_rows.take()
    }

    /// Looks quickly at what `document` leads to, unless that is known or being looked at.
    pub fn sketch(&mut self, document: &FlankDocument) {
        let Some(surface) = self.surface(document) else { return };
        let (question, asked) = (self.question(document), document.clone());
        self.sketches.ask(&question, self.priority, move |work| Ok(steps::sketch(&asked, surface, &work.task.cancel)));
    }

    /// What was seen at a glance of `document`; while it goes on changing (`is_held`) also of what it was before.
    pub fn sketched(&self, document: &FlankDocument, is_held: bool) -> Option<&Arc<Sketch>> {
        let is_alike = |of: &Question| of.document.source == document.source && of.document.side == document.side;
        let before = self.sketches.last().filter(|(of, _)| is_held && is_alike(of));
        self.sketches.get(&self.question(document)).or(before.map(|(_, sketch)| sketch))
    }

    /// Forgets what was seen at a glance.
    pub fn forget_sketch(&mut self) {
        self.sketches.clear();
    }

    /// What is being worked on.
    pub fn doing(&self) -> Option<&Doing> {
        let reading = [self.source.doing(), self.walls.doing()];
        let all = reading.into_iter().chain([self.planned.doing(), self.compared.doing(), self.exported.doing()]);
        all.flatten().next()
    }

    /// Whether anything waits or runs, quick looks apart.
    pub fn is_busy(&self) -> bool {
        self.is_waiting || self.doing().is_some()
    }

    /// Whether a quick look is being taken.
    pub fn is_sketching(&self) -> bool {
        self.sketches.is_busy()
    }

    /// Stops what runs, at the user's wish: none of it begins again by itself.
    pub fn cancel(&mut self) {
        self.is_waiting = false;
        self.source.cancel();
        self.walls.cancel();
        self.planned.cancel();
        self.compared.cancel();
        self.exported.cancel();
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
        self.stamps(document).filter_map(Stamp::changed).map(Path::to_owned).collect()
    }

    /// Writes the files of the plan into `folder`: of one of which a check fails that is not overridden only the
    /// report. The plans beside it are told as well.
    ///
    /// # Errors
    /// One line if there is no plan of `document`.
    pub fn export(
        &mut self,
        document: &FlankDocument,
        compared: &[Row],
        folder: &Path,
        choice: ExportChoice,
    ) -> Result<(), String> {
        let result = self.to_export(document)?;
        let (folder, document, compared) = (folder.to_owned(), document.clone(), compared.to_vec());
        self.exports += 1;
        self.exported.restart(&self.exports, Priority::Shown, move |work| {
            export::export(&folder, (&result, &document), &compared, choice, &work.task)
        });
        Ok(())
    }
}

/// The part of a source that has to be read, without the choice among its faces.
fn source_to_read(source: &FlankSource) -> FlankSource {
    match source {
        FlankSource::Mesh(mesh) => FlankSource::Mesh(MeshFlank { candidate: 1, is_own_wall: true, ..mesh.clone() }),
        other => other.clone(),
    }
}

/// The best of some plans in words.
fn best_words(rows: &[Row]) -> String {
    best(rows).map_or_else(
        || "none of the plans has a path".to_owned(),
        |i| format!("best of {}: {}", rows.len(), rows[i].sentence()),
    )
}
