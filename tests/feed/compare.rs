//! Runs of all strategies on the same electrode.

use std::sync::Mutex;

use feed::plan_params::Strategy;
use feed::pose::Axis;
use sparkpath::workspaces::blisk::job::compare::{compare, comparison};
use sparkpath::workspaces::blisk::job::outcome::{PlanInputs, PlanJobError};
use sparkpath::workspaces::blisk::job::plan::{prepare, run_prepared};
use sparkpath::workspaces::blisk::job::prepared_blisk::PreparedBlisk;
use sparkpath::workspaces::blisk::report::Smoothness;
use sparkpath::workspaces::blisk::report::comparison::{Comparison, Run};
use task::{Cancel, Task};

use crate::common::{easy_blisk, mesh};
use crate::easy_job;

fn inputs() -> PlanInputs {
    let mut job = easy_job();
    job.plan.step_mm = 1.6;
    job.plan.field_cell_mm = 0.4;
    PlanInputs::of(mesh(&easy_blisk()), job)
}

/// The runs without what no two runs share.
fn timeless(mut runs: Vec<Run>) -> Vec<Run> {
    for electrode in runs.iter_mut().flat_map(|r| &mut r.electrodes) {
        (electrode.search_seconds, electrode.certificate_seconds) = (0.0, 0.0);
    }
    runs
}

/// All runs that are compared are of one blisk, which is made ready once.
#[test]
fn every_strategy_has_one_run_with_the_figures_of_its_plan() {
    let (inputs, task) = (inputs(), Task::default());
    let prepared = prepare(&inputs, &task).unwrap();
    let shown = Mutex::new(Vec::new());
    let show = |run: &Run| shown.lock().unwrap().push(run.strategy);
    let runs = compare(&prepared, &inputs, Strategy::ALL, &show, &task).unwrap();
    assert_eq!(runs.iter().map(|r| r.strategy).collect::<Vec<_>>(), Strategy::ALL);
    assert_eq!(shown.into_inner().unwrap(), Strategy::ALL);
    assert!(runs.iter().all(|r| r.electrodes.len() == 1), "{:?}", runs.iter().map(|r| &r.failure).collect::<Vec<_>>());
    files_name_every_strategy(&comparison(runs.clone(), &inputs.job, Vec::new()));
    a_run_has_the_figures_of_its_plan_and_leaves_nothing_to_the_next(&prepared, &inputs, runs);
    a_comparison_stops_when_told_to(&prepared, &inputs);
}

fn a_run_has_the_figures_of_its_plan_and_leaves_nothing_to_the_next(
    prepared: &PreparedBlisk,
    inputs: &PlanInputs,
    mut runs: Vec<Run>,
) {
    let two = [Strategy::Genetic, Strategy::Global];
    for strategy in two {
        figures_are_those_of_a_plan(prepared, inputs, &runs, strategy);
    }
    // In another order, and without others before them: no run leaves anything to the next.
    let mut again =
        compare(prepared, inputs, &[Strategy::Global, Strategy::Genetic], &|_| (), &Task::default()).unwrap();
    runs.retain(|run| two.contains(&run.strategy));
    [&mut again, &mut runs].into_iter().for_each(|runs| runs.sort_by_key(|run| run.strategy == Strategy::Global));
    assert_eq!(timeless(again), timeless(runs));
}

fn figures_are_those_of_a_plan(prepared: &PreparedBlisk, inputs: &PlanInputs, runs: &[Run], strategy: Strategy) {
    let mut inputs = inputs.clone();
    inputs.job.plan.strategy = strategy;
    let task = Task::default();
    let plan = &run_prepared(prepared, &inputs, &|_, _, _| (), &task).unwrap().electrodes[0].plan;
    let planned = plan.path.as_ref().unwrap();
    let found = &runs.iter().find(|r| r.strategy == strategy).unwrap().electrodes[0];
    assert!(found.certified && found.certified_clearance_mm == Some(planned.certificate.certified()));
    assert_eq!((found.nodes, found.rows), (plan.nodes.len(), planned.path.rows.len()));
    assert_eq!(found.smoothness, Smoothness::of(&planned.smoothness));
    let total: f64 = plan.nodes.iter().map(|n| n.objective.total).sum();
    assert!((found.objective_sums.total - total).abs() <= 1e-12 * total && total > 0.0);
    for axis in Axis::ALL {
        let Some(course) = found.course(axis.letter()) else {
            assert!(plan.nodes.iter().all(|n| n.pose.get(axis) == 0.0));
            continue;
        };
        let shown = |v: f64| if axis.is_rotary() { v.to_degrees() } else { v };
        // The curve passes through its nodes, which are those of the plan.
        for (node, [s, value]) in plan.nodes.iter().zip(&course.nodes) {
            assert_eq!((node.s, shown(node.pose.get(axis))), (*s, *value));
        }
        let ends = |points: &[[f64; 2]]| [points[0], points[points.len() - 1]];
        for ([s, v], [t, w]) in ends(&course.nodes).into_iter().zip(ends(&course.curve)) {
            assert!((s - t).abs() < 1e-9 && (v - w).abs() < 1e-9, "{axis:?}: {s} {v}, {t} {w}");
        }
    }
}

fn files_name_every_strategy(comparison: &Comparison) {
    let (html, csv) = (comparison.html().unwrap(), comparison.csv());
    let json: serde_json::Value = serde_json::from_str(&comparison.json().unwrap()).unwrap();
    for (i, &strategy) in Strategy::ALL.iter().enumerate() {
        // Names are not broken at their hyphens.
        assert!(html.contains(&format!("</i>{}", strategy.name().replace('-', "\u{2011}"))), "{strategy:?}");
        assert!(csv.lines().any(|line| line.starts_with(&format!("{},1,", strategy.name()))), "{strategy:?}");
        assert_eq!(json["runs"][i]["strategy"], strategy.name());
    }
    assert!(json["parameters"]["plan"].get("strategy").is_none());
}

fn a_comparison_stops_when_told_to(prepared: &PreparedBlisk, inputs: &PlanInputs) {
    let cancel = Cancel::default();
    let stop = |_: &Run| cancel.cancel();
    let wanted = [Strategy::FreeTravel, Strategy::Genetic];
    let answer = compare(prepared, inputs, &wanted, &stop, &Task::silent(&cancel));
    assert!(matches!(answer, Err(PlanJobError::Cancelled(_))));
}
