//! Minutes and wear of the electrodes of the plan, with the present technology.

use std::sync::Arc;

use super::BliskDesk;
use crate::workspaces::blisk::document::burning::BurningSection;
use crate::workspaces::blisk::job::burning::WheelBurning;
use crate::workspaces::blisk::job::planned::Planned;
use burning::project::ProjectTechnology;
use task::{Lane, Memo, Priority, Same, Scheduler};
use wheel::electrode::StageParams;

/// Key of the figures: the plan, once its residual stock is computed, how it and its stages burn, and how often the technology table was
/// changed.
pub(super) type BurnedKey = (Same<Planned>, ProjectTechnology, BurningSection, Vec<StageParams>, u64);

/// Figures of a plan; none of one that is not verified.
pub(super) type Burned = Memo<BurnedKey, Option<WheelBurning>>;

/// The memo of the figures.
pub(super) fn burned(scheduler: &Scheduler) -> Burned {
    Memo::new(scheduler, Lane::Quick, "Burning").letting_finish().remembering(2)
}

impl BliskDesk {
    fn burned_key(&self) -> Option<BurnedKey> {
        let planned = self.work.planned().filter(|planned| planned.outcome.stock().is_some())?;
        let job = self.document.params();
        let (technology, burning, stages) = (job.technology.clone(), job.burning.clone(), job.electrode.stage.clone());
        Some((Same(planned.clone()), technology, burning, stages, self.work.technology_edits()))
    }

    /// Computes the figures of the plan.
    pub(super) fn follow_burned(&mut self) {
        while self.burned.take().is_some() {}
        let Some(key) = self.burned_key() else { return };
        if !self.burned.wants(&key) {
            return self.burned.turn_to(&key);
        }
        let (planned, mut job) = (key.0.0.clone(), key.0.0.inputs.job.clone());
        (job.technology, job.burning) = (key.1.clone(), key.2.clone());
        for (stage, now) in job.electrode.stage.iter_mut().zip(&key.3) {
            (stage.last_step, stage.finish_vdi) = (now.last_step.clone(), now.finish_vdi);
        }
        self.burned.ask(&key, Priority::Shown, move |_| Ok(WheelBurning::of_job(&planned.outcome, &job)));
    }

    /// Minutes and wear of the electrodes of the plan, once they are computed.
    pub fn burned(&self) -> Option<&WheelBurning> {
        let burned: &Arc<Option<WheelBurning>> = self.burned.get(&self.burned_key()?)?;
        (**burned).as_ref()
    }
}
