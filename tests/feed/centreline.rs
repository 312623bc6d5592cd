//! Plans along the centreline, and paths joined by NURBS.

use std::sync::OnceLock;

use feed::axis_curve::CurveKind;
use feed::jam::JamCause;
use feed::plan_params::Strategy;
use feed::pose::Pose;
use geometry::exact::ExactMesh;
use sparkpath::workspaces::blisk::document::job_file::PlanJob;
use sparkpath::workspaces::blisk::document::kept_plan::KeptPlan;
use sparkpath::workspaces::blisk::job::node_distances::NodeDistances;
use sparkpath::workspaces::blisk::job::outcome::{PlanInputs, PlanOutcome};
use sparkpath::workspaces::blisk::job::plan::{kept, replay};
use sparkpath::workspaces::blisk::report::build::report;
use task::{Cancel, Task};
use wheel::surface_finder::SurfaceFinder;

use super::{curved_blisk, easy_blisk, easy_job, mesh, plan, plan_easy, threads};

fn job() -> PlanJob {
    let mut job = easy_job();
    job.plan.strategy = Strategy::Centreline;
    job.plan.interpolation.kind = CurveKind::Nurbs;
    job
}

fn centreline_plan() -> &'static PlanOutcome {
    static PLAN: OnceLock<PlanOutcome> = OnceLock::new();
    PLAN.get_or_init(|| threads(2).install(|| plan_easy(job())))
}

/// All that compares with one and the same plan, which is made once.
#[test]
fn one_path_along_the_centreline_seen_from_all_sides() {
    the_electrode_comes_out_along_the_centreline_in_steps_of_arc_length();
    a_path_of_nurbs_is_taken_up_again_with_the_same_path();
    the_same_job_gives_the_same_path_on_one_thread();
    a_report_gives_the_wall_clearances_at_every_node();
}

fn the_electrode_comes_out_along_the_centreline_in_steps_of_arc_length() {
    let outcome = centreline_plan();
    let plan = &outcome.electrodes[0].plan;
    assert!(outcome.is_verified(), "{}", plan.verdict(&outcome.channel));
    assert!(plan.path.as_ref().unwrap().certificate.certified() >= 0.1 - 0.002);
    let step = job().plan.step_mm;
    assert!(plan.nodes.windows(2).all(|w| w[0].s < w[1].s && w[1].s - w[0].s <= step + 1e-9));
    // The line leans against X, so that a step along it is a shorter one along X: the first is by its cosine.
    let first = plan.nodes[1].s - plan.nodes[0].s;
    assert!(first < step && first > 0.8 * step, "{first}");
    assert!(plan.nodes.iter().all(|n| (n.pose.x + n.s).abs() < 1e-9), "s is told along X");
    assert_eq!(plan.nodes[0].pose, Pose::FINAL);
}

fn a_path_of_nurbs_is_taken_up_again_with_the_same_path() {
    let kept = KeptPlan { inputs: String::new(), electrodes: kept(centreline_plan()).unwrap() };
    let channel = &centreline_plan().channel;
    let again = |job| {
        let inputs = PlanInputs::of(mesh(&easy_blisk()), job);
        let blisk = inputs.blisk.in_frame(&channel.frame);
        let exact = ExactMesh::new(&blisk).unwrap();
        replay(&inputs, channel, &blisk, &exact, &kept, &Task::default()).unwrap()
    };
    let path = |o: &PlanOutcome| o.electrodes[0].plan.path.as_ref().unwrap().path.digest();
    let same = again(job());
    assert!(same.is_verified());
    assert_eq!(path(&same), path(centreline_plan()));
    // Joined by splines the same nodes make another curve.
    let mut splines = job();
    splines.plan.interpolation.kind = CurveKind::Spline;
    assert_ne!(path(&again(splines)), path(centreline_plan()));
}

fn the_same_job_gives_the_same_path_on_one_thread() {
    let alone = threads(1).install(|| plan_easy(job()));
    let digest = |o: &PlanOutcome| o.electrodes[0].plan.path.as_ref().map(|p| p.path.digest());
    assert_eq!(digest(&alone), digest(centreline_plan()));
}

fn a_report_gives_the_wall_clearances_at_every_node() {
    let mut plan = centreline_plan().clone();
    let finder = SurfaceFinder::new(plan.channel.clone()).unwrap();
    let electrode = &mut plan.electrodes[0];
    let line = plan.centreline.clone();
    let around = (&*plan.channel, &finder, line.as_deref());
    electrode.distances =
        NodeDistances::at(&electrode.plan.nodes, &electrode.electrode, around, &Cancel::default()).unwrap();
    let told = report(&plan, &job(), Vec::new());
    let nodes = &told.electrodes[0].nodes;
    let four = |i: usize| nodes[i].distances_mm.unwrap();
    for node in nodes {
        let d = node.distances_mm.unwrap();
        // The least clearance is to any surface and of more points. That of the hub is to its radius, which the
        // facets of the mesh dip below.
        let least = [Some(d.low_wall), Some(d.high_wall), d.hub, d.shroud].into_iter().flatten();
        assert!(least.fold(f64::INFINITY, f64::min) > node.clearance_mm - 0.08, "{node:?}");
    }
    let first = four(0);
    let to_shroud = 0.1 + job().electrode.radial_reduction_mm;
    assert!((first.hub.unwrap() - 0.1).abs() < 0.08, "{first:?}");
    assert!((first.shroud.unwrap() - to_shroud).abs() < 0.08, "{first:?}");
    assert!(first.low_wall > 0.1 && first.high_wall > 0.1 && four(nodes.len() - 1).hub.is_none());
    // Of nodes that were not measured nothing is told.
    assert!(report(centreline_plan(), &easy_job(), Vec::new()).electrodes[0].nodes[0].distances_mm.is_none());
}

#[test]
fn an_electrode_that_fills_a_curved_channel_jams_with_a_reason() {
    let mut job = job();
    job.electrode.circumferential_reduction_deg = [0.1, 0.1];
    let outcome = plan(mesh(&curved_blisk()), job);
    let jam = outcome.electrodes[0].plan.jam.as_ref().expect("it cannot come out");
    assert!(matches!(jam.cause, JamCause::Contact(_)), "{:?}", jam.cause);
    assert!(jam.sentence(&outcome.channel).contains("missing"));
}
