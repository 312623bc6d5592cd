//! What work beside the pipeline needs of it: the inputs of the present plan, and the blisk made ready.

use std::sync::Arc;

use super::Pipeline;
use super::prepared::Prepared;
use crate::workspaces::blisk::document::stage::{Fingerprint, Stage};
use crate::workspaces::blisk::job::plan::PlanInputs;
use crate::workspaces::blisk::job::prepared_blisk::PreparedBlisk;
use crate::workspaces::blisk::job::stages::FoundChannel;
use feed::plan_params::Strategy;
use files::Validate as _;
use task::Task;
use wheel::channel::Channel;
use wheel::electrode::{EnterSide, Sizing};

/// The inputs of the present plan.
pub struct TuningInputs {
    /// What tells these inputs from any other.
    pub of: Fingerprint,
    /// What tells them from any other but for what sizing finds: parts, side of entry, reductions and strategy.
    pub of_size: Fingerprint,
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
    pub fn prepared(&self, task: &Task) -> Result<Arc<PreparedBlisk>, String> {
        let cell = self.inputs.job.plan.field_cell_mm;
        self.kept.get(&self.found, cell, task).map_err(|e| e.to_string())
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
        let (found, kept) = (found.clone(), self.prepared.clone());
        Some(TuningInputs { of: now.plan, of_size: self.of_size()?, inputs, found, kept })
    }

    /// What tells the parameters of the last [`follow`](Self::follow), and the mesh, from any other but for what sizing
    /// finds.
    pub fn of_size(&self) -> Option<Fingerprint> {
        let (job, _) = self.now.as_ref()?;
        let mut job = job.clone();
        let electrode = &mut job.electrode;
        (electrode.parts, electrode.enter, electrode.size) = (1, EnterSide::Auto, Sizing::Given);
        electrode.circumferential_reduction_deg = [0.0; 2];
        job.plan.strategy = Strategy::Global;
        Some(Fingerprint::of(Stage::Plan, &job, &self.content()))
    }
}
