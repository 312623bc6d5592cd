//! `[electrode] size = "auto"`: the job with the reductions that sizing finds.

use super::plan::{PlanInputs, PlanJobError};
use super::prepared_blisk::PreparedBlisk;
use super::sizing::{SizeRow, SizingRange, size};
use feed::plan_params::Strategy;
use task::Task;
use wheel::electrode::Sizing;

/// `inputs` with the reductions, and the side of entry, of the thickest electrodes that come out in as many parts as it
/// asks for, to be planned with the strategy that found them; and the row they come from. With the reductions that it
/// gives, and no row, if none lets them out: planning these tells where they jam.
///
/// # Errors
/// As sizing has them.
pub fn sized(
    prepared: &PreparedBlisk,
    inputs: &PlanInputs,
    task: &Task,
) -> Result<(PlanInputs, Option<SizeRow>), PlanJobError> {
    let mut sized = inputs.clone();
    let electrode = &mut sized.job.electrode;
    let parts = electrode.parts;
    electrode.size = Sizing::Given;
    let range = SizingRange { from: parts, to: parts };
    let rows = size(prepared, &sized, range, &|_| (), task)?;
    let thickest = rows.into_iter().max_by(|a, b| a.least_thickness_mm.total_cmp(&b.least_thickness_mm));
    if let Some(row) = &thickest {
        sized.job.plan.strategy = Strategy::Global;
        let electrode = &mut sized.job.electrode;
        (electrode.circumferential_reduction_deg, electrode.enter) = (row.reduction_deg, row.enter);
    }
    Ok((sized, thickest))
}
