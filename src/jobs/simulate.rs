//! The whole motion of every electrode of a plan on its machine. Reads the machine's file and the meshes that it names.

use super::finish::Around;
use super::plan::{ElectrodeOutcome, PlanJobError};
use crate::blisk::channel::Channel;
use crate::export::choice::Channels;
use crate::feed::copying::Copying;
use crate::feed::machine_model::{MachineModel, read_machine};
use crate::feed::simulation::{Scenario, Simulation, SimulationOptions, simulate as simulate_motion};
use crate::progress::{Cancel, Progress};
use crate::project::PlanJob;

/// Finds out before the work whether the machine can be read and the channels exist.
pub(super) fn check(
    job: &PlanJob,
    channel: &Channel,
    progress: &Progress,
    cancel: &Cancel,
) -> Result<(), PlanJobError> {
    job.export.channels.numbers(channel.blades, channel.index).map_err(PlanJobError::Job)?;
    if job.machine.has_bodies() {
        read_machine(&job.machine.name, progress, cancel)?;
    }
    Ok(())
}

/// Gives every electrode with a certified path the simulation of its whole motion, if the machine has bodies or other
/// channels than that of the plan are burnt.
pub(super) fn simulate(
    around: &Around,
    electrodes: &mut [ElectrodeOutcome],
    progress: &Progress,
    cancel: &Cancel,
) -> Result<(), PlanJobError> {
    let machine = &around.job.machine;
    if !machine.has_bodies() && around.job.export.channels == Channels::Own {
        return Ok(());
    }
    let model = match machine.has_bodies() {
        true => read_machine(&machine.name, progress, cancel)?,
        false => MachineModel::default(),
    };
    for electrode in electrodes.iter_mut() {
        electrode.simulation = of_electrode(around, electrode, &model, progress, cancel)?.map(Into::into);
    }
    Ok(())
}

fn of_electrode(
    around: &Around,
    outcome: &ElectrodeOutcome,
    model: &MachineModel,
    progress: &Progress,
    cancel: &Cancel,
) -> Result<Option<Simulation>, PlanJobError> {
    let channel = around.channel;
    let channels = &around.job.export.channels;
    let channels = channels.numbers(channel.blades, channel.index).map_err(PlanJobError::Job)?;
    let Some(planned) = outcome.plan.path.as_ref().filter(|p| p.certificate.holds()) else { return Ok(None) };
    let copying = outcome.copying.as_ref().and_then(Copying::certified);
    let scenario = Scenario {
        blisk: around.blisk,
        channels: channel.blades,
        own_channel: channel.index,
        electrode: &outcome.electrode,
        feed: (&planned.path, &planned.certificate),
        copying: copying.map(|motion| (&motion.path, &motion.certificate)),
        machine: &around.job.machine,
        model,
    };
    Ok(Some(simulate_motion(&scenario, &SimulationOptions::of(channels), progress, cancel)?))
}
