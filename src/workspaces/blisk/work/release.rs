//! Release of a certified plan by the user, and the export of its files.

use std::path::Path;
use std::sync::Arc;

use super::BliskWork;
use crate::workspaces::blisk::document::job_file::field_table::FIELDS;
use crate::workspaces::blisk::job::finish::finish;
use crate::workspaces::blisk::job::outcome::{PlanInputs, PlanOutcome};
use crate::workspaces::blisk::job::planned::Exported;
use crate::workspaces::blisk::job::released::{NotReleased, Released};
use crate::workspaces::blisk::job::simulate;
use crate::workspaces::blisk::report::{InputFile, Written};
use task::{State, Task};

/// Writes a released plan of these inputs, which were read from these files, into a folder; answers what was
/// written.
pub type ExportWork =
    Box<dyn FnOnce(&Path, &Released, &PlanInputs, Vec<InputFile>, &Task) -> Result<Written, String> + Send>;

impl BliskWork {
    /// The plan if it is that of the present parameters and every path of it is certified; none while another one is
    /// being made, which would take its place unseen.
    fn certified(&self) -> Option<&Arc<PlanOutcome>> {
        let plan = &self.current()?.outcome;
        (!self.is_planning() && plan.may_be_approved()).then_some(plan)
    }

    /// Whether the plan can be released: its motions are known, the whole one on the machine too. The residual stock
    /// does not matter for that.
    pub fn can_release(&self) -> bool {
        let is_stopped = matches!(self.finishing(), State::Failed(_));
        let is_needed = self.now.as_ref().is_none_or(|now| simulate::is_needed(&now.job));
        self.certified().is_some_and(|plan| plan.finishing().is_some() || is_stopped && !is_needed)
    }

    /// Releases the plan, as the user wishes. It can be exported from then on, until an input changes or it is planned
    /// anew.
    ///
    /// # Errors
    /// One line if there is no certified plan for the present parameters, or another one is being made.
    pub fn release(&mut self) -> Result<(), String> {
        let released = self.certified().ok_or(NotReleased).and_then(Released::by_user).map_err(|e| e.to_string())?;
        if !self.can_release() {
            return Err(
                "the copying motions of this plan, or its motion on the machine, are not computed yet".to_owned()
            );
        }
        self.released = Some(released);
        Ok(())
    }

    /// Takes the release back, and stops an export that has not yet replaced any file.
    pub fn withdraw(&mut self) {
        self.released = None;
        self.exported.cancel();
    }

    /// The present plan, if the user released it.
    pub fn released(&self) -> Option<&Released> {
        self.released.as_ref().filter(|released| self.certified().is_some_and(|plan| released.is_of(plan)))
    }

    /// Writes the released plan into `folder`.
    ///
    /// # Errors
    /// One line if it is not released.
    pub fn start_export(&mut self, folder: &Path, write: ExportWork) -> Result<(), String> {
        let released = self.released().cloned().ok_or("release the plan first")?;
        if self.exported.is_busy() {
            return Err("the last export is still being written: wait for its end, or cancel it".to_owned());
        }
        let (Some(now), Some(part), Some(planned)) = (&self.now, self.part(), self.current()) else {
            return Err("there is no plan to export".to_owned());
        };
        // What is only about writing may have changed since the plan was made.
        let inputs = PlanInputs { job: (*now.job).clone(), ..planned.inputs.clone() };
        let (files, folder) = (part.files.clone(), folder.to_owned());
        // The residual stock is waited for here, unless the user stopped it.
        let blisk = self.channel.get(&now.channel).filter(|_| self.finishing() == State::Running).cloned();
        self.exports = (Some(now.export), self.exports.1 + 1);
        self.exported.restart(&(now.export, self.exports.1), self.priority, move |work| {
            if let Some(found) = blisk {
                finish(released.plan(), &inputs, &found.blisk, &work.task).map_err(|e| FIELDS.labelled(&e))?;
            }
            let written = write(&folder, &released, &inputs, files, &work.task)?;
            Ok(Exported { folder, written: written.files, no_job_sheet: written.no_job_sheet })
        });
        Ok(())
    }

    /// What was exported last.
    pub fn exported(&self) -> Option<&Arc<Exported>> {
        self.exported.last().map(|(_, exported)| exported)
    }
}
