//! Plans for the electrodes as they are measured.

use super::BliskWork;
use crate::workspaces::blisk::job::planned::Planned;
use task::Same;

/// Key of a plan for measured electrodes: the plan, the table, and how often files were read.
pub(super) type MeasuredKey = (Same<Planned>, String, u64);

impl BliskWork {
    /// Key of the present plan for the measured electrodes; none where they are nominal.
    pub(super) fn measured_key(&self) -> Option<MeasuredKey> {
        let now = self.now.as_ref()?;
        let presets = now.job.setup.presets.clone()?;
        let planned = self.planned.get(&now.plan).filter(|planned| planned.outcome.is_verified())?;
        Some((Same(planned.clone()), presets, self.reloads))
    }

    /// Rewrites the plan for the electrodes as they are measured, if they are.
    pub(super) fn follow_measured(&mut self) {
        let found = self.now.as_ref().and_then(|now| self.channel.get(&now.channel)).cloned();
        let (Some(found), Some(key), false) = (found, self.measured_key(), self.is_planning()) else {
            return self.measured.stop();
        };
        let (planned, presets) = (key.0.0.clone(), key.1.clone());
        self.measured.ask(&key, self.priority, move |work| planned.as_measured(&presets, &found.blisk, &work.task));
    }
}
