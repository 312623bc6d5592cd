//! Replay: a plan from nodes found before, joined and verified anew without a search. The result is as certain as a new
//! plan, because only the verifier makes certificates.

use std::time::Instant;

use glam::DVec3;

use super::plan::{FeedPlan, PlanSettings};
use super::plan_params::PlanError;
use super::planner::{interpolated, planned_path};
use super::problem::Node;
use super::verify::Verifier;
use geometry::frame::Frame;
use geometry::mesh::Mesh;
use task::Task;
use wheel::electrode::Electrode;
use wheel::surface_finder::SurfaceFinder;

/// Blisk and channel of a replay.
#[derive(Clone, Copy)]
pub struct Surroundings<'a> {
    /// The finished blisk in W.
    pub blisk: &'a Mesh,
    /// The surfaces of the channel.
    pub finder: &'a SurfaceFinder,
    /// W in the coordinates of the loaded mesh.
    pub frame: Frame,
}

/// Joins `nodes`, from the final pose outwards, and verifies the path of `electrode`, which was made with an additional
/// reduction `h` (rad).
///
/// # Errors
/// If the nodes cannot be joined, or when cancelled. That the path does not hold is an answer, not an error.
pub fn replay_feed(
    around: &Surroundings,
    electrode: &Electrode,
    nodes: &[Node],
    h: f64,
    settings: &PlanSettings,
    task: &Task,
) -> Result<FeedPlan, PlanError> {
    settings.plan.validate()?;
    settings.machine.validate()?;
    let (curves, path) = interpolated(nodes, electrode, settings, around.frame)?;
    let started = Instant::now();
    let verifier = Verifier::new(around.blisk, &electrode.mesh, electrode.reference_point, &task.cancel)?
        .within(settings.machine.pose_limits());
    let surface_of = |p: DVec3| around.finder.surface_of(p);
    let certificate = verifier.verify(&path, &surface_of, settings.verify, task)?;
    Ok(FeedPlan {
        nodes: nodes.to_vec(),
        convergence: Vec::new(),
        jam: None,
        path: Some(planned_path(curves, path, certificate, settings)),
        h,
        remade: None,
        ranges: [0.0; 6],
        probes: 0,
        rounds: 0,
        repairs: 0,
        field_seconds: 0.0,
        search_seconds: 0.0,
        verify_seconds: started.elapsed().as_secs_f64(),
    })
}
