//! The whole motion of every electrode of a plan on its machine. Reads the machine's file and the meshes that it names.

use std::sync::Arc;

use super::outcome::{ElectrodeOutcome, PlanJobError};
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

/// Finds out before the work whether the channels that are burnt exist.
pub fn check_channels(job: &PlanJob, channel: &Channel) -> Result<(), PlanJobError> {
    job.export.channels.numbers(channel.blades, channel.index).map(drop).map_err(PlanJobError::Job)
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
    let channels = &around.job.export.channels;
    let channels = channels.numbers(channel.blades, channel.index).map_err(PlanJobError::Job)?;
    let Some(planned) = outcome.plan.path.as_ref().filter(|p| p.certificate.holds()) else { return Ok(None) };
    let copying = motion.certified();
    let scenario = Scenario {
        blisk: around.blisk,
        channels: channel.blades,
        own_channel: channel.index,
        electrode: &outcome.electrode,
        feed: (&planned.path, &planned.certificate),
        copying: copying.map(|motion| (&motion.path, &motion.certificate)),
        machine: &around.job.machine.seen_from_w(outcome.electrode.enters_from),
        model,
    };
    Ok(Some(simulate_motion(&scenario, &SimulationOptions::of(channels), task)?.into()))
}
