//! What follows while an electrode is tuned: a quick look for its way out at every change, and the table of sizes when
//! asked for.

use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use super::{BliskWork, MOMENT, Wish};
use crate::workspaces::blisk::document::stage::{Fingerprint, Stage};
use crate::workspaces::blisk::job::outcome::PlanInputs;
use crate::workspaces::blisk::job::prepared_blisk::PreparedBlisk;
use crate::workspaces::blisk::job::preview::Looked;
use crate::workspaces::blisk::job::sizing::{SizeRow, SizingRange, size};
use crate::workspaces::context::rest_left;
use crate::workspaces::news::EventKind;
use feed::plan_params::Strategy;
use task::{Doing, Lane, Memo, Priority, Same, Scheduler, State};
use wheel::electrode::{EnterSide, Sizing};

/// Parts up to which electrodes are sized.
const PARTS: SizingRange = SizingRange { from: 1, to: 3 };
/// How long nothing may change before what was looked at quickly is planned and verified (s).
const REST: f64 = 0.7;

/// The plan whose parameters are looked at, and the number of the electrode.
type Place = (Fingerprint, usize);

/// Quick looks and sizes.
pub(super) struct Looks {
    looks: Memo<Place, Looked>,
    /// What is looked at.
    at: Option<Place>,
    /// What the user has given up looking at.
    cancelled: Option<Place>,
    /// The look that is shown, and since when (s).
    seen: Option<(Same<Looked>, f64)>,
    sizes: Memo<Fingerprint, Vec<SizeRow>, Vec<SizeRow>>,
    /// What sizes were asked for last.
    sized: Option<Fingerprint>,
}

impl Looks {
    pub(super) fn new(scheduler: &Scheduler) -> Self {
        Self {
            looks: Memo::new(scheduler, Lane::Quick, "Preview").remembering(4),
            at: None,
            cancelled: None,
            seen: None,
            sizes: Memo::new(scheduler, Lane::Long, "Sizes"),
            sized: None,
        }
    }

    pub(super) fn clear(&mut self) {
        self.looks.clear();
        self.sizes.clear();
        (self.at, self.cancelled, self.seen, self.sized) = (None, None, None, None);
    }
}

impl BliskWork {
    /// Looks at electrode number `part` as long as there is no plan of the present parameters, if looks are wanted
    /// (`is_live`), at `time` (s). What was found stays while that is made.
    pub fn look(&mut self, part: usize, is_live: bool, time: f64) {
        // What they find is shown, and not told.
        while self.looks.looks.take().is_some() || self.looks.sizes.take().is_some() {}
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

    /// Whether a look or sizes are under way, or what they need.
    pub fn is_looking(&self) -> bool {
        self.prepared.is_busy() || self.looks.looks.is_busy() || self.looks.sizes.is_busy()
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

    /// What tells the present parameters, and the mesh, from any other but for what sizing finds: parts, side of entry,
    /// reductions and strategy.
    fn of_size(&self) -> Option<Fingerprint> {
        let now = self.now.as_ref()?;
        let mut job = (*now.job).clone();
        let electrode = &mut job.electrode;
        (electrode.parts, electrode.enter, electrode.size) = (1, EnterSide::Auto, Sizing::Given);
        electrode.circumferential_reduction_deg = [0.0; 2];
        job.plan.strategy = Strategy::Global;
        Some(Fingerprint::of(Stage::Plan, &job, &now.content))
    }

    /// Begins the table of sizes.
    pub fn find_sizes(&mut self) {
        if let (Some(of), Ok(_)) = (self.of_size(), self.inputs()) {
            self.looks.sized = Some(of);
            self.wish(Wish::Sizes);
        }
    }

    /// Sizes on the blisk that is ready, or cannot be.
    pub(super) fn size(&mut self, ready: Result<Arc<PreparedBlisk>, String>, inputs: PlanInputs) {
        let Some(of) = self.of_size() else { return };
        self.looks.sized = Some(of);
        self.looks.sizes.restart(&of, Priority::Background, move |work| {
            let so_far = Mutex::new(Vec::new());
            let found = |row: &SizeRow| {
                let mut so_far = so_far.lock().unwrap_or_else(PoisonError::into_inner);
                so_far.push(row.clone());
                work.partial(so_far.clone());
            };
            let rows = size(&*ready?, &inputs, PARTS, &found, &work.task);
            rows.map_err(|e| e.to_string()).and_then(|rows| match rows.is_empty() {
                true => Err("not feasible: no electrode has an extraction path at the reductions tried".to_owned()),
                false => Ok(rows),
            })
        });
    }

    /// Whether the table is of the present parameters.
    pub fn sizes_are_current(&self) -> bool {
        self.looks.sized.is_some() && self.looks.sized == self.of_size()
    }

    /// Stops sizing; the rows found so far stay.
    pub fn stop_sizing(&mut self) {
        self.wishes.retain(|wish| *wish != Wish::Sizes);
        self.looks.sizes.cancel();
    }

    /// What is being sized.
    pub fn sizing(&self) -> Option<String> {
        let doing = self.looks.sizes.doing();
        let said = doing.filter(|doing| !doing.is_waiting && !doing.stage.is_empty());
        match said.map(|doing| format!("{} {}", doing.stage, doing.message)) {
            None if doing.is_some() || self.wishes.contains(&Wish::Sizes) => Some("sizing".to_owned()),
            said => said,
        }
    }

    /// The table so far, and why it ended early.
    pub fn sizes(&self) -> (&[SizeRow], Option<String>) {
        let Some(of) = &self.looks.sized else { return (&[], None) };
        let sizes = &self.looks.sizes;
        let rows = sizes.get(of).map(|rows| &***rows).or(sizes.partial(of).map(|rows| &**rows));
        let failure = if let State::Failed(why) = sizes.state(of) { Some(why) } else { None };
        (rows.unwrap_or_default(), failure)
    }
}
