//! What work beside the pipeline needs of it: the inputs of the present plan, and the blisk made ready.

use std::sync::Arc;

use super::Pipeline;
use super::prepared::Prepared;
use crate::blisk::channel::Channel;
use crate::jobs::plan::PlanInputs;
use crate::jobs::prepared_blisk::PreparedBlisk;
use crate::jobs::stages::FoundChannel;
use crate::progress::{Cancel, Progress};
use crate::project::Fingerprint;

/// The inputs of the present plan.
pub struct TuningInputs {
    /// What tells these inputs from any other.
    pub of: Fingerprint,
    /// The inputs.
    pub inputs: PlanInputs,
    found: Arc<FoundChannel>,
    kept: Prepared,
}

impl TuningInputs {
    /// The blisk made ready, now if it is not yet.
    ///
    /// # Errors
    /// One line for the user.
    pub fn prepared(&self, progress: &Progress, cancel: &Cancel) -> Result<Arc<PreparedBlisk>, String> {
        let cell = self.inputs.job.plan.field_cell_mm;
        self.kept.get(&self.found, cell, progress, cancel).map_err(|e| e.to_string())
    }

    /// The channel.
    pub fn channel(&self) -> Arc<Channel> {
        self.found.channel.clone()
    }
}

impl Pipeline {
    /// The inputs of the plan for the parameters of the last [`follow`](Self::follow), if channel and parameters allow one.
    pub fn tuning_inputs(&self) -> Option<TuningInputs> {
        let (job, now) = self.now.as_ref()?;
        let (part, found) = (self.part.current(now.part)?, self.channel.current(now.channel)?);
        job.validate().ok()?;
        let inputs =
            PlanInputs { blisk: part.mesh.clone(), own_electrode: part.own_electrode.clone(), job: job.clone() };
        Some(TuningInputs { of: now.plan, inputs, found: found.clone(), kept: self.prepared.clone() })
    }
}
