//! What comes after the feed: the copying motions, and what stock is left by all electrodes together.

use std::sync::Arc;

use glam::DVec3;

use super::plan::{Clock, ElectrodeOutcome, PlanJobError};
use super::simulate::simulate;
use crate::blisk::channel::Channel;
use crate::blisk::surface_finder::SurfaceFinder;
use crate::feed::copying::{Copying, CopyingExtent, CopyingSettings, copying_motion};
use crate::feed::leftover::{Burn, Leftover, LeftoverError, Site, leftover};
use crate::feed::path::FeedPath;
use crate::feed::pose::Pose;
use crate::feed::verify::Verifier;
use crate::geometry::mesh::Mesh;
use crate::progress::{Cancel, Progress};
use crate::project::PlanJob;

/// What electrodes are finished in.
pub(super) struct Around<'a> {
    pub job: &'a PlanJob,
    /// The finished blisk in W.
    pub blisk: &'a Mesh,
    pub channel: &'a Arc<Channel>,
    pub finder: &'a SurfaceFinder,
}

/// Gives every electrode its copying motion and tells what they leave; the latter only if every path is certified,
/// otherwise it answers why not.
pub(super) fn finish(
    around: &Around,
    electrodes: &mut [ElectrodeOutcome],
    clock: &mut Clock,
    progress: &Progress,
    cancel: &Cancel,
) -> Result<Result<Arc<Leftover>, String>, PlanJobError> {
    if electrodes.is_empty() || !electrodes.iter().all(|e| e.plan.is_verified()) {
        return Ok(Err("what stock is left cannot be told before every electrode has a certified path".to_owned()));
    }
    for electrode in electrodes.iter_mut() {
        let made = clock.time("copying motion", || copying(around, electrode, progress, cancel))?;
        electrode.copying = Some(made);
    }
    clock.time("simulation", || simulate(around, electrodes, progress, cancel))?;
    let left = clock.time("leftover", || left_by(around, electrodes, progress, cancel));
    match left {
        Ok(left) => Ok(Ok(Arc::new(left))),
        Err(LeftoverError::Cancelled(cancelled)) => Err(cancelled.into()),
        // A plan is good without it.
        Err(other) => Ok(Err(format!("what stock is left cannot be told: {other}"))),
    }
}

fn copying(
    around: &Around,
    outcome: &ElectrodeOutcome,
    progress: &Progress,
    cancel: &Cancel,
) -> Result<Copying, PlanJobError> {
    let (job, electrode) = (around.job, &outcome.electrode);
    let wanted = CopyingExtent::of(electrode, &job.electrode, outcome.plan.h);
    let settings = CopyingSettings {
        machine: &job.machine,
        verify: &job.verify,
        spark_gap: job.electrode.spark_gap_mm,
        frame: around.channel.frame,
    };
    progress.report("copying motion", 0.0, "");
    let verifier = Verifier::new(around.blisk, &electrode.mesh, electrode.reference_point, cancel)?;
    let verifier = verifier.within(job.machine.limits());
    let surface_of = |p: DVec3| around.finder.surface_of(p);
    Ok(copying_motion(electrode, &verifier, wanted, &settings, &surface_of, progress, cancel)?)
}

fn left_by(
    around: &Around,
    electrodes: &[ElectrodeOutcome],
    progress: &Progress,
    cancel: &Cancel,
) -> Result<Leftover, LeftoverError> {
    let poses = |path: &FeedPath| -> Vec<Pose> { path.rows.iter().map(|row| row.pose).collect() };
    let burns: Vec<Burn> = electrodes
        .iter()
        .map(|e| Burn {
            electrode: &e.electrode,
            feed: e.plan.path.as_ref().map(|p| poses(&p.path)).unwrap_or_default(),
            // What is not certified is not exported either, and burns nothing.
            copying: e.copying.as_ref().and_then(Copying::certified).map(|c| poses(&c.path)).unwrap_or_default(),
        })
        .collect();
    let feeds = electrodes.iter().filter_map(|e| e.plan.path.as_ref().map(|p| p.certificate.certified()));
    let copied = electrodes.iter().filter_map(|e| e.copying.as_ref().and_then(Copying::certified));
    let proven = feeds.chain(copied.map(|c| c.certificate.certified())).fold(f64::INFINITY, f64::min);
    let site = Site {
        blisk: around.blisk,
        channel: around.channel,
        finder: around.finder,
        spark_gap: around.job.electrode.spark_gap_mm,
        proven,
    };
    leftover(&site, &burns, progress, cancel)
}
