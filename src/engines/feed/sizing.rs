//! Sizing: the least reductions at which an electrode comes out.

use super::clearance::ClearanceModel;
use super::genetic::{GeneticParams, ReductionMode};
use super::global::{ExtractionPath, GlobalParams};
use super::jam::Opening;
use super::plan::PlanSettings;
use super::plan_params::PlanError;
use super::prepared::PlanningSpace;
use super::probes::Turns;
use super::problem::SearchProblem;
use super::setup::{Refinements, SearchSetup};
use task::{Cancelled, Task};
use wheel::electrode::Electrode;

/// Search for the least reductions of one electrode on one side.
pub struct Sizer<'a> {
    /// The channel.
    pub space: &'a PlanningSpace,
    /// The electrode as it was prepared.
    pub electrode: &'a Electrode,
    /// The model of its clearance.
    pub model: &'a ClearanceModel<'a>,
    /// Settings of a plan; its strategy does not matter.
    pub settings: &'a PlanSettings<'a>,
    /// Angle to which the least reduction is found (rad).
    pub tolerance: f64,
    /// Greatest angle that is tried (rad).
    pub most: f64,
    /// Progress of the search.
    pub task: &'a Task,
}

/// Reduction at which an extraction path was found.
#[derive(Debug, Clone, PartialEq)]
pub struct Least {
    /// The angle (rad).
    pub angle: f64,
    /// Clearance margin of the path beyond the demand (mm).
    pub margin: f64,
    /// The path.
    pub path: ExtractionPath,
}

impl Sizer<'_> {
    /// Growth of the clearance margin with reduction, until it is measured (mm/rad).
    const WIDENS: f64 = 5.0;
    /// Least clearance margin that counts (mm): about the error of the distance fields.
    const SPARE: f64 = 0.003;
    /// Steps below the least known angle at which another path is searched for, one after the other (tolerances): for the
    /// least, and for what is to be known roughly.
    const STEPS: [f64; 5] = [8.0, 4.0, 2.0, 1.0, 0.5];
    const ROUGH_STEPS: [f64; 2] = [8.0, 2.0];
    /// Trials after which the search for the least ends in any case.
    const TRIALS: usize = 12;

    /// Least angle, from 0 to [`most`](Self::most), at which an extraction path is found, searching about `first`
    /// first; `turns` gives the turns of the walls at an angle, and must grow with it. None if there is no path.
    ///
    /// # Errors
    /// [`PlanError::Cancelled`].
    pub fn least(&self, first: f64, turns: &dyn Fn(f64) -> Turns) -> Result<Option<Least>, PlanError> {
        self.least_in(&Self::STEPS, first, turns)
    }

    /// [`least`](Self::least) with these steps.
    fn least_in(&self, steps: &[f64], first: f64, turns: &dyn Fn(f64) -> Turns) -> Result<Option<Least>, PlanError> {
        let mut blocked = self.nothing_blocked();
        let mut angle = first.clamp(0.0, self.most);
        loop {
            if let Some(open) = self.searched(angle, turns)? {
                return self.least_below(steps, open, blocked, turns).map(Some);
            }
            if angle >= self.most {
                return Ok(None);
            }
            blocked = angle;
            angle = (1.3 * angle + 10.0 * self.tolerance).min(self.most);
        }
    }

    /// Angle just below 0 (rad), which stands for "no angle is known to be blocked".
    pub fn nothing_blocked(&self) -> f64 {
        -self.tolerance
    }

    /// Least angle between `blocked` (rad), where there is no path, and that of `open`. The path of `open` is
    /// warm-started at smaller angles as far as it leads, which takes a fraction of the time of a search; then another
    /// one is searched for.
    fn least_below(
        &self,
        steps: &[f64],
        open: Least,
        blocked: f64,
        turns: &dyn Fn(f64) -> Turns,
    ) -> Result<Least, PlanError> {
        let mut open = self.warm_started_down(open, blocked, turns)?;
        let mut left = steps.iter();
        while let Some(step) = left.next() {
            let angle = open.angle - step * self.tolerance;
            if angle > blocked
                && let Some(other) = self.searched(angle, turns)?
            {
                open = self.warm_started_down(other, blocked, turns)?;
                left = steps.iter();
            }
        }
        Ok(open)
    }

    /// Least angle between `blocked` (rad), where there is no path, and that of `open` to which the path of `open` can
    /// be warm-started.
    ///
    /// # Errors
    /// [`PlanError::Cancelled`].
    pub fn warm_started_down(
        &self,
        mut open: Least,
        mut blocked: f64,
        turns: &dyn Fn(f64) -> Turns,
    ) -> Result<Least, PlanError> {
        let mut widens = Self::WIDENS;
        for _ in 0..Self::TRIALS {
            let between = open.angle - blocked;
            if between <= self.tolerance || open.angle == 0.0 {
                break;
            }
            // Where the width would be gone, but not beside what is known.
            let expected = open.angle - (open.margin - Self::SPARE) / widens;
            let nearest = open.angle - (0.25 * between).min(2.0 * self.tolerance);
            let angle = expected.clamp(blocked + 0.25 * between, nearest).max(0.0);
            match self.warm_started(&open.path, angle, turns)? {
                Some(found) => {
                    if open.margin > found.margin {
                        widens = (open.margin - found.margin) / (open.angle - found.angle);
                    }
                    open = found;
                }
                None => blocked = angle,
            }
        }
        Ok(open)
    }

    /// Extraction path searched for at `angle` (rad).
    fn searched(&self, angle: f64, turns: &dyn Fn(f64) -> Turns) -> Result<Option<Least>, PlanError> {
        self.with_margin(angle, turns, |problem| {
            problem.path_with_few_poses(&self.params(), &Task::silent(&self.task.cancel))
        })
    }

    /// Parameters of the plan, with a clearance margin large enough to tell how wide a path is.
    fn params(&self) -> GlobalParams {
        const LEAST_ROOM: f64 = 0.05;
        let given = self.settings.plan.global;
        GlobalParams { room_mm: given.room_mm.max(LEAST_ROOM), ..given }
    }

    /// Path near `path` at `angle` (rad), if there is one.
    fn warm_started(
        &self,
        path: &ExtractionPath,
        angle: f64,
        turns: &dyn Fn(f64) -> Turns,
    ) -> Result<Option<Least>, PlanError> {
        self.with_margin(angle, turns, |problem| problem.warm_started_path(&self.params(), path, &self.task.cancel))
    }

    /// Path that `find` finds at `angle` (rad), if its clearance margin is sufficient.
    fn with_margin(
        &self,
        angle: f64,
        turns: &dyn Fn(f64) -> Turns,
        find: impl FnOnce(&SearchProblem) -> Result<Option<ExtractionPath>, Cancelled>,
    ) -> Result<Option<Least>, PlanError> {
        self.task.report("sizing", 0.0, &format!("{:.2} deg", angle.to_degrees()));
        let genetic = GeneticParams { h: ReductionMode::Given, ..*self.settings.genetic };
        let settings = PlanSettings { genetic: &genetic, ..*self.settings };
        let setup = SearchSetup { space: self.space, settings: &settings, turns: turns(angle), guide: None };
        let path = setup.with_problem(setup.ranges(self.electrode), self.model, &Refinements::default(), find)?;
        let least = |path: ExtractionPath| Least { angle, margin: path.last().map_or(0.0, |w| w.margin), path };
        Ok(path.map(least).filter(|least| least.margin >= Self::SPARE))
    }

    /// Whether an extraction path is found with the walls turned so.
    fn is_open(&self, turns: Turns) -> Result<bool, PlanError> {
        Ok(self.searched(0.0, &|_| turns)?.is_some())
    }

    /// Further reduction that would open a path beyond `turns`, where there is none.
    ///
    /// # Errors
    /// [`PlanError::Cancelled`].
    pub fn opening(&self, turns: Turns) -> Result<Opening, PlanError> {
        const FIRST: f64 = 0.005;
        let Turns([low, high]) = turns;
        let least = |walls: [f64; 2]| {
            let drawn_in = |more: f64| Turns([low + walls[0] * more, high + walls[1] * more]);
            Ok::<_, PlanError>(self.least_in(&Self::ROUGH_STEPS, FIRST, &drawn_in)?.map(|least| least.angle))
        };
        let both = least([1.0, 1.0])?;
        // Where the same angle helps on both, that is enough to know. Where it does not, an electrode drawn in on one wall by as
        // much contains one that has no path, unless the walls of that one met: the greatest angle tells whether there is more
        // to look for.
        let single = |walls: [f64; 2]| match both {
            Some(_) => Ok(None),
            None if !self.is_open(Turns([low + walls[0] * self.most, high + walls[1] * self.most]))? => Ok(None),
            None => least(walls),
        };
        let [low, high] = [single([1.0, 0.0])?, single([0.0, 1.0])?];
        Ok(Opening { most: self.most, both, low, high, changes: Vec::new(), in_vain: Vec::new(), is_stopped: false })
    }
}
