//! The whole motion of every electrode of a plan on its machine. Reads the machine's file and the meshes that it names.

use std::sync::Arc;

use super::outcome::{ElectrodeOutcome, PlanJobError};
use super::plan::head_comes_from_elsewhere;
use crate::workspaces::blisk::document::choice::Channels;
use crate::workspaces::blisk::document::job_file::PlanJob;
use crate::workspaces::blisk::document::machine_file::read_machine;
use feed::copying::Copying;
use feed::machine_model::MachineModel;
use feed::simulation::{Scenario, Simulation, SimulationOptions, simulate as simulate_motion};
use geometry::mesh::Mesh;
use task::Task;
use wheel::channel::Channel;
use wheel::electrode::Junctions;
use wheel::surface_finder::SurfaceFinder;

/// Where electrodes are finished.
pub(super) struct Around<'a> {
    pub(super) job: &'a PlanJob,
    /// The finished blisk in W.
    pub(super) blisk: &'a Mesh,
    pub(super) channel: &'a Arc<Channel>,
    pub(super) finder: SurfaceFinder,
    pub(super) junctions: Junctions,
    /// The wheel as it comes, in W; none of a full ring, or of one with an allowance.
    pub(super) blank: Option<Mesh>,
}

/// Whether a program of this job may only be made after its whole motion was simulated: the machine has bodies, or
/// other channels than that of the plan are burnt.
pub fn is_needed(job: &PlanJob) -> bool {
    job.machine.has_bodies() || job.export.channels != Channels::Own
}

/// The bodies of the machine of `job` as its file has them now; none if it names no machine.
///
/// # Errors
/// If its file cannot be read.
pub fn bodies_of(job: &PlanJob, task: &Task) -> Result<MachineModel, PlanJobError> {
    match job.machine.has_bodies() {
        true => Ok(read_machine(&job.machine.name, task)?),
        false => Ok(MachineModel::default()),
    }
}

/// Finds out before the work whether the machine of `job`, with every body of it, can be read.
pub fn check_machine(job: &PlanJob, task: &Task) -> Result<(), PlanJobError> {
    bodies_of(job, task).map(drop)
}

/// Finds out before the work whether the channels that are burnt exist and are like the one that is planned for.
pub fn check_channels(job: &PlanJob, channel: &Channel) -> Result<(), PlanJobError> {
    let numbers = job.export.channels.numbers(channel.blades, channel.index).map_err(PlanJobError::Job)?;
    match numbers.into_iter().find(|&number| !channel.is_like(number)) {
        None => Ok(()),
        Some(number) => Err(PlanJobError::Job(format!(
            "export.channels: channel {number} is not like channel {}, so that its plan does not fit it; leave it out, and \
             plan it by itself with blisk.channel = {number}",
            channel.index
        ))),
    }
}

/// Adds to `known` the whole motion of every electrode, each with its copying motion, if the machine has bodies or
/// other channels than that of the plan are burnt; otherwise nothing. When told to stop, those that are whole are
/// there.
pub(super) fn simulate(
    around: &Around,
    electrodes: &[ElectrodeOutcome],
    motions: &[Copying],
    known: &mut Vec<Arc<Simulation>>,
    task: &Task,
) -> Result<(), PlanJobError> {
    if !is_needed(around.job) {
        return Ok(());
    }
    let model = bodies_of(around.job, task)?;
    for (electrode, motion) in electrodes.iter().zip(motions) {
        known.extend(of_electrode(around, electrode, motion, &model, task)?);
    }
    Ok(())
}

fn of_electrode(
    around: &Around,
    outcome: &ElectrodeOutcome,
    motion: &Copying,
    model: &MachineModel,
    task: &Task,
) -> Result<Option<Arc<Simulation>>, PlanJobError> {
    let channel = around.channel;
    // The last gate beside the choice of sides.
    if !around.job.machine.comes_from(outcome.electrode.enters_from) {
        return Err(head_comes_from_elsewhere(around.job));
    }
    let channels = &around.job.export.channels;
    let channels = channels.numbers(channel.blades, channel.index).map_err(PlanJobError::Job)?;
    let Some(planned) = outcome.plan.path.as_ref().filter(|p| p.certificate.holds()) else { return Ok(None) };
    let copying = motion.certified();
    let scenario = Scenario {
        blisk: around.blisk,
        channels: channel.blades,
        own_channel: channel.index,
        electrode: outcome.burning(),
        preset: outcome.preset.as_ref(),
        feed: (&planned.path, &planned.certificate),
        copying: copying.map(|motion| (&motion.path, &motion.certificate)),
        machine: &around.job.machine.seen_from_w(outcome.electrode.enters_from),
        model,
    };
    Ok(Some(simulate_motion(&scenario, &SimulationOptions::of(channels), task)?.into()))
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::workspaces::blisk::document::choice::Channels;
    use wheel::channel::{Difference, Unlike};
    use wheel::fixtures::exact_channel;
    use wheel::parametric::ParametricBlisk;

    #[test]
    fn a_channel_that_is_not_like_the_planned_one_is_not_burnt_by_its_plan() {
        let unlike = vec![Unlike { number: 5, difference: Difference::Tips }];
        let channel = Channel { unlike, ..exact_channel(&ParametricBlisk::default()) };
        let burnt = |channels: Channels| {
            let mut job = PlanJob::for_mesh(Path::new("part.stl"));
            job.export.channels = channels;
            check_channels(&job, &channel).map_err(|error| error.to_string())
        };
        assert_eq!(burnt(Channels::Own), Ok(()));
        assert_eq!(burnt(Channels::These(vec![0, 4, 6])), Ok(()));
        for wrong in [Channels::All, Channels::These(vec![4, 5])] {
            let refusal = burnt(wrong).unwrap_err();
            assert!(refusal.contains("channel 5 is not like channel 0"), "{refusal}");
        }
        // Every other channel of a wheel with splitters is of another kind.
        let channel = Channel { kinds: 2, ..exact_channel(&ParametricBlisk::default()) };
        let like: Vec<usize> = (0..6).filter(|&number| channel.is_like(number)).collect();
        assert_eq!(like, [0, 2, 4]);
    }
}
