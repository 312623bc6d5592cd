//! Mending: nodes are moved and put in until the curve through them is free.

use std::sync::Arc;

use feed::clearance::{Bodies, ClearanceModel, SamplesOf};
use feed::interpolation::AxisCurves;
use feed::objective::Objective;
use feed::outside::Outside;
use feed::pose::{Axis, Pose};
use feed::prepared::PlanningSpace;
use feed::probes::{Demand, SideDemand, Turns};
use feed::problem::{Node, SearchProblem};
use feed::samples::{SampleSpacing, sample_electrode};
use feed::verify::Verifier;
use geometry::distance_field::DistanceField;
use geometry::exact::ExactMesh;
use geometry::spline::EndCondition;
use task::Task;

use super::{easy_blisk, easy_job, easy_plan, mesh};

/// Every second node of a plan, and one of these moved towards a wall.
fn spoiled(nodes: &[Node]) -> Vec<Node> {
    let mut nodes: Vec<Node> =
        nodes.iter().enumerate().filter(|(i, _)| i % 2 == 0 || *i + 1 == nodes.len()).map(|(_, n)| *n).collect();
    nodes[3].pose.y -= 0.2;
    nodes
}

pub fn a_spoiled_path_is_repaired_without_another_search() {
    let (outcome, job) = (easy_plan(), easy_job());
    let task = Task::default();
    let electrode = &outcome.electrodes[0].electrode;
    let o = electrode.reference_point;
    let blisk = Arc::new(mesh(&easy_blisk()).in_frame(&outcome.channel.frame));
    let exact = Arc::new(ExactMesh::new(&blisk).unwrap());
    let channel = outcome.channel.clone();
    let space = PlanningSpace::new(blisk.clone(), exact.clone(), channel, job.plan.field_cell_mm, &task).unwrap();
    let (body, region) = (ExactMesh::new(&electrode.mesh).unwrap().into(), electrode.mesh.bounds().grown(1.1));
    let own = DistanceField::build(&electrode.mesh, body, region, 0.35, &task).unwrap();
    let outside = Outside::new(&blisk, &electrode.mesh, o);
    let bodies = Bodies {
        blisk: &space.field,
        electrode: &own,
        faces_x: space.channel.faces_x,
        free_radii: None,
        outside: outside.into(),
        reference_point: o,
        side: electrode.enters_from,
        samples: SamplesOf::Prepared,
        sides: SideDemand::default(),
    };
    let samples = sample_electrode(&electrode.mesh, &electrode.faces, SampleSpacing::default(), &task.cancel).unwrap();
    let model = ClearanceModel::new(bodies, samples, space.edges.clone(), &task::Cancel::default()).unwrap();
    let axes = job.machine.axes;
    let weights = job.plan.weights.normalised(&axes.axes()[1..]);
    let ranges = [0.0, 1.0, 1.0, 1.0, 1.0, 1.0];
    let objective = Objective::new(weights, ranges, model.samples(), o, &space.channel, &space.walls);
    let problem = |travel| SearchProblem {
        model: &model,
        angle: None,
        objective: &objective,
        axes,
        travel,
        ranges,
        turns: Turns::NONE,
        demand: Demand { spark_gap: 0.1, margin: 0.0, guard: 0.01, room: 0.0 },
        side: electrode.enters_from,
        joining: EndCondition::NotAKnot.into(),
        step: job.plan.step_mm,
        fine: &[],
        exit_clearance: 5.0,
        guide: None,
        observe: &|_, _| (),
    };

    // Against exact distances, not against the fields that were climbed.
    let verifier = Verifier::new(&blisk, &electrode.mesh, o, &task.cancel).unwrap();
    let least = |nodes: &[Node]| {
        let curves = AxisCurves::through(nodes, EndCondition::NotAKnot).unwrap();
        let until = nodes[nodes.len() - 1].s;
        let clearance = |i: u32| verifier.distance(&curves.pose(until * f64::from(i) / 300.0)).distance;
        (0..=300).map(clearance).fold(f64::INFINITY, f64::min)
    };
    let nodes = spoiled(&outcome.electrodes[0].plan.nodes);
    assert!(least(&nodes) < 0.08, "{} mm: nothing to mend", least(&nodes));
    let repaired = problem(job.machine.limits()).repaired(&nodes, &task.cancel).unwrap().expect("a free curve");
    assert!(least(&repaired) > 0.1 - 0.004, "{} mm", least(&repaired));
    assert_eq!(repaired[0].pose, Pose::FINAL);
    assert!(repaired.windows(2).all(|w| w[0].s < w[1].s));
    assert!(nodes.iter().all(|n| repaired.iter().any(|m| m.s == n.s)), "nodes are moved or put in, never left out");
    assert!(repaired.len() < 3 * nodes.len());

    // What the axes cannot reach is not repaired.
    let narrow = job.machine.limits().with(Axis::X, [-1.0, 1.0]);
    assert_eq!(problem(narrow).repaired(&nodes, &task.cancel), Ok(None));
    task.cancel.cancel();
    assert!(problem(job.machine.limits()).repaired(&nodes, &task.cancel).is_err());
}
