//! What follows while an electrode is tuned: a quick look for its way out at every change, and tables of sizes and of sets
//! when asked for.

use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use super::{BliskWork, MOMENT, Wish};
use crate::workspaces::blisk::document::job_file::ExportSection;
use crate::workspaces::blisk::document::stage::{Fingerprint, Stage};
use crate::workspaces::blisk::job::design::{DesignLimits, DesignRow, DesignSpace, design};
use crate::workspaces::blisk::job::outcome::{PlanInputs, PlanJobError};
use crate::workspaces::blisk::job::prepared_blisk::PreparedBlisk;
use crate::workspaces::blisk::job::preview::Looked;
use crate::workspaces::blisk::job::sizing::{SizeRow, SizingRange, size};
use crate::workspaces::context::rest_left;
use crate::workspaces::news::EventKind;
use feed::genetic::ReductionMode;
use feed::plan_params::Strategy;
use task::{Doing, Lane, Memo, Priority, Same, Scheduler, State, Task};

/// Parts up to which electrodes are sized.
const PARTS: SizingRange = SizingRange { from: 1, to: 3 };
/// How long nothing may change before what was looked at quickly is planned and verified (s).
const REST: f64 = 0.7;

/// The plan whose parameters are looked at, and the number of the electrode.
type Place = (Fingerprint, usize);

/// Quick looks and tables.
pub(super) struct Looks {
    looks: Memo<Place, Looked>,
    /// What is looked at.
    at: Option<Place>,
    /// What the user has given up looking at.
    cancelled: Option<Place>,
    /// The look that is shown, and since when (s).
    seen: Option<(Same<Looked>, f64)>,
    sizes: Table<SizeRow>,
    sets: Table<DesignRow>,
}

/// A table of electrodes that is searched row by row when asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ElectrodeTable {
    /// Least reductions.
    Sizes,
    /// Sets of the fewest hours.
    Sets,
}

/// Rows that were found.
struct Table<T> {
    rows: Memo<Fingerprint, Vec<T>, Vec<T>>,
    /// Parameters that they were asked for last.
    of: Option<Fingerprint>,
}

impl<T: Clone + Send + Sync + 'static> Table<T> {
    fn new(scheduler: &Scheduler, name: &'static str) -> Self {
        Self { rows: Memo::new(scheduler, Lane::Long, name), of: None }
    }

    /// Forgets all rows.
    fn clear(&mut self) {
        self.rows.clear();
        self.of = None;
    }

    /// Begins `search`, which shows each row as it is found.
    fn search(
        &mut self,
        of: Fingerprint,
        search: impl FnOnce(&(dyn Fn(&T) + Sync), &Task) -> Result<Vec<T>, String> + Send + 'static,
    ) {
        self.of = Some(of);
        self.rows.restart(&of, Priority::Background, move |work| {
            let so_far = Mutex::new(Vec::new());
            let found = |row: &T| {
                let mut so_far = so_far.lock().unwrap_or_else(PoisonError::into_inner);
                so_far.push(row.clone());
                work.partial(so_far.clone());
            };
            let rows = search(&found, &work.task)?;
            match rows.is_empty() {
                true => Err("not feasible: no electrode has an extraction path at the reductions tried".to_owned()),
                false => Ok(rows),
            }
        });
    }

    /// The rows so far, and why the search ended early.
    fn shown(&self) -> (&[T], Option<String>) {
        let Some(of) = &self.of else { return (&[], None) };
        let (known, so_far) = (self.rows.get(of).map(|rows| &***rows), self.rows.partial(of).map(|rows| &**rows));
        let rows = if self.rows.is_busy() { so_far.or(known) } else { known.or(so_far) };
        let failure = if let State::Failed(why) = self.rows.state(of) { Some(why) } else { None };
        (rows.unwrap_or_default(), failure)
    }
}

impl Looks {
    pub(super) fn new(scheduler: &Scheduler) -> Self {
        Self {
            looks: Memo::new(scheduler, Lane::Quick, "Preview").remembering(4),
            at: None,
            cancelled: None,
            seen: None,
            sizes: Table::new(scheduler, "Sizes"),
            sets: Table::new(scheduler, "Sets"),
        }
    }

    pub(super) fn clear(&mut self) {
        self.looks.clear();
        self.sizes.clear();
        self.sets.clear();
        (self.at, self.cancelled, self.seen) = (None, None, None);
    }
}

impl BliskWork {
    /// Looks at electrode number `part` as long as there is no plan of the present parameters, if looks are wanted
    /// (`is_live`), at `time` (s). What was found stays while that is made.
    pub fn look(&mut self, part: usize, is_live: bool, time: f64) {
        // What they find is shown, and not told.
        let looks = &mut self.looks;
        while looks.looks.take().is_some() || looks.sizes.rows.take().is_some() || looks.sets.rows.take().is_some() {}
        let state = self.state(Stage::Plan);
        if state == State::Running && is_live {
            return;
        }
        // Of an electrode that cannot be made there is nothing to look at.
        let can_be_made = !matches!(self.state(Stage::Electrode), State::Failed(_));
        let is_wanted = is_live && can_be_made && matches!(state, State::Missing | State::Stale);
        let inputs = if is_wanted { self.inputs().ok() } else { None };
        let inputs = inputs.filter(|inputs| inputs.job.plan.strategy == Strategy::Global);
        let (Some(inputs), Some(now)) = (inputs, &self.now) else {
            self.looks.at = None;
            return self.looks.looks.stop();
        };
        let place = (now.plan, part);
        self.looks.at = Some(place);
        self.looks.cancelled = self.looks.cancelled.filter(|cancelled| *cancelled == place);
        if self.looks.cancelled.is_some() {
            return self.looks.looks.stop();
        }
        let ready = if self.looks.looks.wants(&place) { self.ready() } else { Ok(None) };
        match ready {
            Ok(None) => self.looks.looks.turn_to(&place),
            ready => drop(self.looks.looks.ask(&place, self.priority, move |work| {
                let ready = ready?.ok_or_else(String::new)?;
                Looked::at(&ready, &inputs, part, &work.task)
            })),
        }
        let seen = self.looked().cloned().map(Same);
        if self.looks.seen.as_ref().map(|(seen, _)| seen) != seen.as_ref() {
            self.looks.seen = seen.map(|seen| (seen, time));
        }
    }

    /// What was seen of the parameters that are looked at.
    pub fn looked(&self) -> Option<&Arc<Looked>> {
        self.looks.looks.get(self.looks.at.as_ref()?)
    }

    /// How the look at them stands; missing if nothing is looked at.
    pub fn look_state(&self) -> State {
        if self.looks.at.is_some() && self.looks.at == self.looks.cancelled {
            return State::Cancelled;
        }
        match self.looks.at.as_ref().map(|at| self.looks.looks.state(at)) {
            // It waits for the blisk to be made ready.
            Some(State::Stale | State::Missing) => State::Running,
            state => state.unwrap_or(State::Missing),
        }
    }

    /// Gives up the look under way, which does not begin again by itself before a parameter changes.
    pub(super) fn cancel_look(&mut self) {
        if self.look_state() != State::Running {
            return;
        }
        self.looks.cancelled = self.looks.at;
        self.looks.looks.stop();
        self.say(Stage::Plan, EventKind::Cancelled, "the preview of the extraction path was cancelled");
    }

    /// Looks after all at what the user had given up looking at.
    pub fn resume_look(&mut self) {
        self.looks.cancelled = None;
    }

    /// The look under way, or the preparation that it waits for, once that takes more than a moment.
    pub(super) fn look_doing(&self) -> Option<&Doing> {
        let ready = self.prepared.doing().filter(|_| self.look_state() == State::Running);
        self.looks.looks.doing().or(ready).filter(|doing| doing.asked.elapsed() > MOMENT)
    }

    /// Whether a look or a table is under way, or what they need.
    pub fn is_looking(&self) -> bool {
        let Looks { looks, sizes, sets, .. } = &self.looks;
        self.prepared.is_busy() || looks.is_busy() || sizes.rows.is_busy() || sets.rows.is_busy()
    }

    /// Whether it is time to plan and verify what was looked at: it comes out, nothing has changed for a while, and it
    /// was not planned yet at `time` (s). If it is not time yet, tells how long to wait.
    pub fn is_at_rest(&self, time: f64) -> Result<(), Option<Duration>> {
        let (Some((seen, since)), Some(now)) = (&self.looks.seen, &self.now) else { return Err(None) };
        let is_shown = self.looked().is_some_and(|looked| Arc::ptr_eq(looked, &seen.0));
        if !is_shown || seen.0.found.way.margin.is_none() || !self.planned.wants(&now.plan) {
            return Err(None);
        }
        let left = rest_left(*since, REST, time);
        if left.is_zero() { Ok(()) } else { Err(Some(left)) }
    }

    /// Fingerprint of the present parameters and the mesh without what the search for a table finds: parts, side of entry,
    /// reductions and strategy, for sets columns, divisions and radial reductions as well.
    fn of_table(&self, table: ElectrodeTable) -> Option<Fingerprint> {
        let now = self.now.as_ref()?;
        let mut job = (*now.job).clone();
        job.plan.strategy = Strategy::Global;
        let electrode = &mut job.electrode;
        let (stage, edits) = match table {
            ElectrodeTable::Sizes => {
                SizeRow::forget(electrode);
                (Stage::Plan, 0)
            }
            // Their hours depend on the technology.
            ElectrodeTable::Sets => {
                DesignRow::forget(electrode);
                job.genetic.h = ReductionMode::Given;
                job.export = ExportSection { channels: job.export.channels.clone(), ..ExportSection::default() };
                (Stage::Export, now.technology_edits)
            }
        };
        Some(Fingerprint::of(stage, &job, &format!("{}/{edits}", now.content)))
    }

    /// Begins a table.
    pub fn find(&mut self, table: ElectrodeTable) {
        if let (Some(of), Ok(_)) = (self.of_table(table), self.inputs()) {
            match table {
                ElectrodeTable::Sizes => self.looks.sizes.of = Some(of),
                ElectrodeTable::Sets => self.looks.sets.of = Some(of),
            }
            self.wish(Wish::Table(table));
        }
    }

    /// Searches the rows of a table on the blisk that is ready, or cannot be.
    pub(super) fn search(
        &mut self,
        table: ElectrodeTable,
        ready: Result<Arc<PreparedBlisk>, String>,
        inputs: PlanInputs,
    ) {
        let Some(of) = self.of_table(table) else { return };
        match table {
            ElectrodeTable::Sizes => {
                self.looks
                    .sizes
                    .search(of, move |found, task| size(&*ready?, &inputs, PARTS, found, task).map_err(words));
            }
            ElectrodeTable::Sets => self.looks.sets.search(of, move |found, task| {
                let space = DesignSpace {
                    most_parts: PARTS.to,
                    columns: false,
                    radial_reductions_mm: Vec::new(),
                    planes: Vec::new(),
                };
                let design = design(&*ready?, &inputs, &space, &DesignLimits::default(), found, task).map_err(words)?;
                if design.rows.is_empty() { Err(design.left_out.join("; ")) } else { Ok(design.rows) }
            }),
        }
    }

    /// Whether a table is of the present parameters.
    pub fn is_current(&self, table: ElectrodeTable) -> bool {
        let of = match table {
            ElectrodeTable::Sizes => self.looks.sizes.of,
            ElectrodeTable::Sets => self.looks.sets.of,
        };
        of.is_some() && of == self.of_table(table)
    }

    /// Stops the search for a table; the rows found so far stay.
    pub fn stop_search(&mut self, table: ElectrodeTable) {
        self.wishes.retain(|wish| *wish != Wish::Table(table));
        match table {
            ElectrodeTable::Sizes => self.looks.sizes.rows.cancel(),
            ElectrodeTable::Sets => self.looks.sets.rows.cancel(),
        }
    }

    /// Work of the search for a table, in words.
    pub fn searching(&self, table: ElectrodeTable) -> Option<String> {
        let doing = match table {
            ElectrodeTable::Sizes => self.looks.sizes.rows.doing(),
            ElectrodeTable::Sets => self.looks.sets.rows.doing(),
        };
        let said = doing.filter(|doing| !doing.is_waiting && !doing.stage.is_empty());
        match said.map(|doing| format!("{} {}", doing.stage, doing.message)) {
            None if doing.is_some() || self.wishes.contains(&Wish::Table(table)) => Some("searching".to_owned()),
            said => said,
        }
    }

    /// The sizes so far, and why they ended early.
    pub fn sizes(&self) -> (&[SizeRow], Option<String>) {
        self.looks.sizes.shown()
    }

    /// The sets so far, and why they ended early.
    pub fn sets(&self) -> (&[DesignRow], Option<String>) {
        self.looks.sets.shown()
    }
}

fn words(error: PlanJobError) -> String {
    error.to_string()
}
