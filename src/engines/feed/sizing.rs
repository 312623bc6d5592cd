//! How little an electrode has to be reduced: the thickest one that comes out.

use serde::Serialize;

use super::clearance::ClearanceModel;
use super::genetic::{GeneticParams, ReductionMode};
use super::global::{GlobalParams, Way};
use super::plan::{PlanSettings, PlanningSpace};
use super::plan_params::PlanError;
use super::planner::{Lessons, Planner};
use super::probes::Turns;
use super::search::SearchProblem;
use task::{Cancel, Cancelled, Progress};
use wheel::electrode::Electrode;

/// Looks for the least reductions of one electrode on one side.
pub struct Sizer<'a> {
    /// The channel.
    pub space: &'a PlanningSpace,
    /// The electrode as it was prepared.
    pub electrode: &'a Electrode,
    /// The model of its clearance.
    pub model: &'a ClearanceModel<'a>,
    /// All that a plan needs; its strategy does not matter.
    pub settings: &'a PlanSettings<'a>,
    /// Angle to which the least reduction is found (rad).
    pub tolerance: f64,
    /// Greatest angle that is tried (rad).
    pub most: f64,
    /// Is told how far it is.
    pub progress: &'a Progress,
    /// Is looked at all the time.
    pub cancel: &'a Cancel,
}

/// A reduction at which a way out was found.
#[derive(Debug, Clone, PartialEq)]
pub struct Least {
    /// The angle (rad).
    pub angle: f64,
    /// Width of the way beyond what is asked for (mm).
    pub width: f64,
    /// The way.
    pub way: Way,
}

/// How much more an electrode that does not come out would have to be reduced (rad), by what is drawn in; none where
/// even the most that is tried is not enough.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Opening {
    /// Both walls by as much.
    pub both: Option<f64>,
    /// The low wall alone.
    pub low: Option<f64>,
    /// The high wall alone.
    pub high: Option<f64>,
}

impl Sizer<'_> {
    /// How much wider a way gets with more reduction, as far as that is not known yet (mm / rad).
    const WIDENS: f64 = 5.0;
    /// Least width of a way that counts (mm): about what the fields are wrong by.
    const SPARE: f64 = 0.003;
    /// How far below the least angle known another way is searched for, one after the other (tolerances).
    const STEPS: [f64; 2] = [4.0, 1.0];
    /// Trials after which the search for the least ends in any case.
    const TRIALS: usize = 12;

    /// The least angle, from 0 to [`most`](Self::most), with which a way out is found, looking about `first` first; `turns`
    /// tells what the walls do at an angle, and must draw them in further for greater ones. None if there is none.
    ///
    /// # Errors
    /// [`PlanError::Cancelled`].
    pub fn least(&self, first: f64, turns: &dyn Fn(f64) -> Turns) -> Result<Option<Least>, PlanError> {
        let mut blocked = self.nothing_blocked();
        let mut angle = first.clamp(0.0, self.most);
        loop {
            if let Some(open) = self.searched(angle, turns)? {
                return self.least_below(open, blocked, turns).map(Some);
            }
            if angle >= self.most {
                return Ok(None);
            }
            blocked = angle;
            angle = (1.3 * angle + 10.0 * self.tolerance).min(self.most);
        }
    }

    /// An angle at which there need be no way for all that is known (rad): a bit below 0.
    pub fn nothing_blocked(&self) -> f64 {
        -self.tolerance
    }

    /// The least angle between `blocked` (rad), where there is no way, and that of `open`: its way is followed as far as it
    /// leads, which takes a fraction of the time of a search; then another one is searched for.
    fn least_below(&self, open: Least, blocked: f64, turns: &dyn Fn(f64) -> Turns) -> Result<Least, PlanError> {
        let mut open = self.followed_down(open, blocked, turns)?;
        let mut steps = Self::STEPS.iter();
        while let Some(step) = steps.next() {
            let angle = open.angle - step * self.tolerance;
            if angle > blocked
                && let Some(other) = self.searched(angle, turns)?
            {
                open = self.followed_down(other, blocked, turns)?;
                steps = Self::STEPS.iter();
            }
        }
        Ok(open)
    }

    /// The least angle between `blocked` (rad), where there is no way, and that of `open` to which its way leads.
    ///
    /// # Errors
    /// [`PlanError::Cancelled`].
    pub fn followed_down(
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
            let expected = open.angle - (open.width - Self::SPARE) / widens;
            let nearest = open.angle - (0.25 * between).min(2.0 * self.tolerance);
            let angle = expected.clamp(blocked + 0.25 * between, nearest).max(0.0);
            match self.followed(&open.way, angle, turns)? {
                Some(found) => {
                    if open.width > found.width {
                        widens = (open.width - found.width) / (open.angle - found.angle);
                    }
                    open = found;
                }
                None => blocked = angle,
            }
        }
        Ok(open)
    }

    /// A way out that is searched for at `angle` (rad), if one is found.
    fn searched(&self, angle: f64, turns: &dyn Fn(f64) -> Turns) -> Result<Option<Least>, PlanError> {
        self.wide_enough(angle, turns, |problem| problem.way_with_few(&self.params(), &Progress::silent(), self.cancel))
    }

    /// Those of the plan, with room enough to tell how wide a way is.
    fn params(&self) -> GlobalParams {
        const LEAST_ROOM: f64 = 0.05;
        let given = self.settings.plan.global;
        GlobalParams { room_mm: given.room_mm.max(LEAST_ROOM), ..given }
    }

    /// The way near `way` at `angle` (rad), if there is one.
    fn followed(&self, way: &Way, angle: f64, turns: &dyn Fn(f64) -> Turns) -> Result<Option<Least>, PlanError> {
        self.wide_enough(angle, turns, |problem| problem.followed_way(&self.params(), way, self.cancel))
    }

    /// The way that `find` finds at `angle` (rad), if it is wide enough.
    fn wide_enough(
        &self,
        angle: f64,
        turns: &dyn Fn(f64) -> Turns,
        find: impl FnOnce(&SearchProblem) -> Result<Option<Way>, Cancelled>,
    ) -> Result<Option<Least>, PlanError> {
        self.progress.report("sizing", 0.0, &format!("{:.2} deg", angle.to_degrees()));
        let genetic = GeneticParams { h: ReductionMode::Given, ..*self.settings.genetic };
        let settings = PlanSettings { genetic: &genetic, ..*self.settings };
        let Self { space, cancel, .. } = *self;
        let progress = &Progress::silent();
        let planner = Planner { space, settings: &settings, turns: turns(angle), progress, cancel, guide: None };
        let plan = planner.nothing_yet(self.electrode, self.model);
        let way = planner.with_problem(&plan, self.model, &Lessons::default(), find)?;
        let least = |way: Way| Least { angle, width: way.last().map_or(0.0, |w| w.width), way };
        Ok(way.map(least).filter(|least| least.width >= Self::SPARE))
    }

    /// How much more reduction would open a way from `turns` on, where there is none.
    ///
    /// # Errors
    /// [`PlanError::Cancelled`].
    pub fn opening(&self, turns: Turns) -> Result<Opening, PlanError> {
        const FIRST: f64 = 0.005;
        let Turns([low, high]) = turns;
        let least = |walls: [f64; 2]| {
            let drawn_in = |more: f64| Turns([low + walls[0] * more, high + walls[1] * more]);
            Ok::<_, PlanError>(self.least(FIRST, &drawn_in)?.map(|least| least.angle))
        };
        Ok(Opening { both: least([1.0, 1.0])?, low: least([1.0, 0.0])?, high: least([0.0, 1.0])? })
    }
}
