//! How little an electrode has to be reduced: the thickest one that comes out.

use super::genetic::{GeneticParams, ReductionMode};
use super::plan::{PlanSettings, PlanningSpace};
use super::plan_params::PlanError;
use super::planner::Planner;
use super::prepared::PreparedElectrode;
use super::probes::Turns;
use crate::blisk::electrode::Electrode;
use crate::progress::{Cancel, Progress};

/// Looks for the least reductions of one electrode, given without any, on one side.
pub struct Sizer<'a> {
    /// The channel.
    pub space: &'a PlanningSpace,
    /// The electrode without circumferential reductions.
    pub prepared: &'a PreparedElectrode,
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

impl Sizer<'_> {
    /// How much wider a way gets with more reduction, as far as that is not known yet (mm / rad).
    const WIDENS: f64 = 5.0;
    /// Trials after which the search for the least ends in any case.
    const TRIALS: usize = 14;

    /// Width of the way out with the walls drawn in by `turns` (mm); none if there is none at this resolution.
    ///
    /// # Errors
    /// [`PlanError::Cancelled`].
    pub fn width(&self, turns: Turns) -> Result<Option<f64>, PlanError> {
        let settings = PlanSettings { genetic: &plain(self.settings.genetic), ..*self.settings };
        let silent = Progress::silent();
        let planner = Planner { space: self.space, settings: &settings, turns, progress: &silent, cancel: self.cancel };
        planner.width_of_way(self.prepared.electrode(), &self.prepared.model(self.space))
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
            self.progress.report(
                "sizing",
                trial as f64 / Self::TRIALS as f64,
                &format!("{:.3} deg", angle.to_degrees()),
            );
            match self.width(turns(angle))? {
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
            let expected = least.angle - least.width / widens;
            let kept = 0.2 * between;
            angle = expected.clamp(blocked + kept, least.angle - kept.max(0.5 * self.tolerance)).max(0.0);
        }
        Ok(open)
    }
}

/// The genetic parameters with nothing searched beyond what is given.
fn plain(genetic: &GeneticParams) -> GeneticParams {
    GeneticParams { h: ReductionMode::Given, ..*genetic }
}

impl Planner<'_> {
    /// Width of the way out (mm) of the model's electrode, drawn in; none if there is none.
    fn width_of_way(
        &self,
        electrode: &Electrode,
        model: &super::clearance::ClearanceModel,
    ) -> Result<Option<f64>, PlanError> {
        let plan = self.nothing_yet(electrode, model);
        let width = self.with_problem(&plan, model, &Default::default(), |problem| {
            problem.width_of_way(&self.settings.plan.global, self.progress, self.cancel)
        })?;
        Ok(width)
    }
}
