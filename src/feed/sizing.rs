//! How little an electrode has to be reduced: the thickest one that comes out.

use serde::Serialize;

use super::clearance::ClearanceModel;
use super::genetic::{GeneticParams, ReductionMode};
use super::plan::{PlanSettings, PlanningSpace};
use super::plan_params::PlanError;
use super::planner::{Lessons, Planner};
use super::probes::Turns;
use crate::blisk::electrode::Electrode;
use crate::progress::{Cancel, Progress};

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
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Least {
    /// The angle (rad).
    pub angle: f64,
    /// Width of the way beyond what is asked for (mm).
    pub width: f64,
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
    /// Trials after which the search for the least ends in any case.
    const TRIALS: usize = 12;

    /// Width of the way out with the walls drawn in by `turns` (mm); none if there is none at this resolution.
    ///
    /// # Errors
    /// [`PlanError::Cancelled`].
    pub fn width(&self, turns: Turns) -> Result<Option<f64>, PlanError> {
        let genetic = GeneticParams { h: ReductionMode::Given, ..*self.settings.genetic };
        let settings = PlanSettings { genetic: &genetic, ..*self.settings };
        let silent = Progress::silent();
        let planner = Planner {
            space: self.space,
            settings: &settings,
            turns,
            progress: &silent,
            cancel: self.cancel,
            guide: None,
        };
        let plan = planner.nothing_yet(self.electrode, self.model);
        let width = planner.with_problem(&plan, self.model, &Lessons::default(), |problem| {
            problem.width_of_way(&settings.plan.global, &silent, self.cancel)
        });
        Ok(width?)
    }

    /// The least angle, from 0 to [`most`](Self::most), with which a way out is found, looking about `first` first; `turns`
    /// tells what the walls do at an angle, and must draw them in further for greater ones. None if there is none.
    ///
    /// # Errors
    /// [`PlanError::Cancelled`].
    pub fn least(&self, first: f64, turns: &dyn Fn(f64) -> Turns) -> Result<Option<Least>, PlanError> {
        // Nothing is known to be blocked yet: a bit below 0.
        let mut blocked = -self.tolerance;
        let mut open: Option<Least> = None;
        let mut widens = Self::WIDENS;
        let mut angle = first.clamp(0.0, self.most);
        for trial in 0..Self::TRIALS {
            let done = trial as f64 / Self::TRIALS as f64;
            self.progress.report("sizing", done, &format!("{:.2} deg", angle.to_degrees()));
            match self.width(turns(angle))?.filter(|width| *width >= Self::SPARE) {
                Some(width) => {
                    if let Some(wider) = open.filter(|o| o.angle > angle && o.width > width) {
                        widens = (wider.width - width) / (wider.angle - angle);
                    }
                    open = Some(Least { angle, width });
                }
                None => blocked = angle,
            }
            let Some(least) = open else {
                if angle >= self.most {
                    return Ok(None);
                }
                angle = (1.3 * angle + 10.0 * self.tolerance).min(self.most);
                continue;
            };
            let between = least.angle - blocked;
            if between <= self.tolerance || least.angle == 0.0 {
                break;
            }
            // Where the width would be gone, but not beside what is known.
            let expected = least.angle - (least.width - Self::SPARE) / widens;
            let kept = 0.25 * between;
            angle = expected.clamp(blocked + kept, least.angle - kept).max(0.0);
        }
        Ok(open)
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
