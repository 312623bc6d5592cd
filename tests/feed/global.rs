//! The global strategy, sizing, the quick look, and the strategies to compare with.

use std::sync::OnceLock;
use std::sync::atomic::{AtomicUsize, Ordering};

use super::*;
use ::files::Validate as _;
use feed::jam::{Change, JamCause, Opening};
use feed::plan_params::Strategy;
use sparkpath::workspaces::blisk::job::burning::WheelBurning;
use sparkpath::workspaces::blisk::job::design::{DesignLimits, DesignSpace, design};
use sparkpath::workspaces::blisk::job::outcome::ElectrodeOutcome;
use sparkpath::workspaces::blisk::job::plan::{run_finished, run_prepared};
use sparkpath::workspaces::blisk::job::prepared_blisk::PreparedBlisk;
use sparkpath::workspaces::blisk::job::preview::live_way;
use sparkpath::workspaces::blisk::job::sizing::{SizingRange, TOLERANCE_DEG, size};
use task::Progress;
use wheel::electrode::{PartParams, StageParams};

fn job_with(strategy: Strategy, reduction_deg: f64) -> PlanJob {
    let mut job = easy_job();
    job.plan.strategy = strategy;
    job.electrode.circumferential_reduction_deg = [reduction_deg; 2];
    job
}

/// The same with a coarse search, for what takes many of them.
fn coarse_job(reduction_deg: f64) -> PlanJob {
    let mut job = job_with(Strategy::Global, reduction_deg);
    (job.plan.step_mm, job.plan.global.poses) = (2.0, 8);
    job
}

fn planned(strategy: Strategy, reduction_deg: f64) -> PlanOutcome {
    plan_easy(job_with(strategy, reduction_deg))
}

fn global_plan() -> &'static PlanOutcome {
    static PLAN: OnceLock<PlanOutcome> = OnceLock::new();
    PLAN.get_or_init(|| threads(2).install(|| planned(Strategy::Global, 2.8)))
}

fn only(outcome: &PlanOutcome) -> &ElectrodeOutcome {
    assert_eq!(outcome.electrodes.len(), 1);
    &outcome.electrodes[0]
}

#[test]
fn the_global_path_is_certified_smooth_and_the_same_every_time() {
    dense_sampling_never_finds_less_than_the_certificate();
    it_is_at_least_twice_as_smooth_as_free_travel();
    it_is_the_same_on_any_number_of_threads();
    greatest_least_distance_keeps_further_away_at_its_nodes();
    a_glance_tells_what_the_plan_will_say_where_that_is_clear();
}

/// Both look for the least reduction that lets the electrode out.
#[test]
fn a_reduction_that_is_found_lets_the_electrode_out() {
    where_there_is_no_way_the_reduction_that_is_named_opens_one();
    sizes_are_certified_and_what_is_sized_is_what_a_plan_makes();
    sets_are_what_their_plans_make();
}

fn dense_sampling_never_finds_less_than_the_certificate() {
    let outcome = global_plan();
    assert!(outcome.is_verified(), "{}", only(outcome).plan.verdict(&outcome.channel));
    let planned = only(outcome).plan.path.as_ref().unwrap();
    let blisk = ExactMesh::new(&mesh(&easy_blisk()).in_frame(&outcome.channel.frame)).unwrap();
    let body = ExactMesh::new(&only(outcome).electrode.mesh).unwrap();
    let rows = &planned.path.rows;
    for i in (0..rows.len() - 1).step_by(rows.len().div_ceil(14)) {
        for t in [0.13, 0.59] {
            let pose = rows[i].pose.lerp(&rows[i + 1].pose, t);
            let clearance = blisk.distance_to(&body, &pose.placement(planned.path.reference_point));
            assert!(clearance >= planned.certificate.certified() - 1e-9, "row {i}: {clearance}");
        }
    }
}

/// What the comparison of the papers is about: the path that is optimised as a whole against the greedy one.
fn it_is_at_least_twice_as_smooth_as_free_travel() {
    let free = planned(Strategy::FreeTravel, 2.8);
    let path = |outcome: &PlanOutcome| only(outcome).plan.path.clone().expect("it comes out");
    let (free, global) = (path(&free), path(global_plan()));
    for axis in [Axis::Y, Axis::Z, Axis::A, Axis::C] {
        let of = |p: &feed::plan::PlannedPath| p.smoothness[axis as usize].max_second_difference;
        assert!(2.0 * of(&global) <= of(&free), "{axis:?}: {} against {}", of(&global), of(&free));
    }
}

/// The roomiest pose at every node has at least the clearance there that any other strategy's has, but for what its
/// own search misses.
fn greatest_least_distance_keeps_further_away_at_its_nodes() {
    let roomy = planned(Strategy::MaxMinDistance, 2.8);
    let mean = |outcome: &PlanOutcome| {
        let nodes = &only(outcome).plan.nodes;
        let inside: Vec<f64> = nodes.iter().filter(|n| n.s > 0.5 && n.s < 12.0).map(|n| n.clearance).collect();
        inside.iter().sum::<f64>() / inside.len() as f64
    };
    assert!(mean(&roomy) > mean(easy_plan()), "{} {}", mean(&roomy), mean(easy_plan()));
}

fn it_is_the_same_on_any_number_of_threads() {
    let one = threads(1).install(|| planned(Strategy::Global, 2.8));
    let digest = |o: &PlanOutcome| only(o).plan.path.as_ref().map(|p| p.path.digest());
    assert_eq!(digest(&one), digest(global_plan()));
}

/// Too thick an electrode: the verdict names the place and what would help, and that does help.
fn where_there_is_no_way_the_reduction_that_is_named_opens_one() {
    const TOO_LITTLE: f64 = 0.05;
    let inputs = easy_inputs(coarse_job(TOO_LITTLE));
    let (outcome, reports) = planned_until(&inputs, usize::MAX);
    let jam = only(&outcome).plan.jam.as_ref().expect("it jams");
    assert!(matches!(jam.cause, JamCause::Contact(_)), "{jam:?}");
    let opening = jam.opening.as_ref().expect("what would help was looked for");
    let [Change::Walls { reductions: [low, high], more }] = opening.changes[..] else { panic!("{opening:?}") };
    assert!(low == high && (low - more[0] - TOO_LITTLE.to_radians()).abs() < 1e-9, "{opening:?}");
    let said = format!("feasible with both walls reduced by {:.2} deg", low.to_degrees());
    assert!(only(&outcome).plan.verdict(&outcome.channel).contains(&said));
    let more = plan_easy(coarse_job((low.to_degrees() * 100.0).round() / 100.0));
    assert!(more.is_verified(), "{}", only(&more).plan.verdict(&more.channel));
    // Where it jams is known before what would help: who stops that search keeps it.
    let whole = only(&outcome).plan.verdict(&outcome.channel);
    for stopped_at in [1, reports / 2] {
        let (outcome, _) = planned_until(&inputs, stopped_at);
        let said = only(&outcome).plan.verdict(&outcome.channel);
        // So late there may be nothing left to stop.
        let is_whole = stopped_at > 1 && said == whole;
        assert_eq!(is_whole, outcome.stopped().is_none(), "{stopped_at}: {said}");
        assert!(said.contains("mm of clearance are missing there") && !outcome.may_be_approved(), "{said}");
        assert!(is_whole || said.ends_with("; the search for a change that makes it feasible was stopped"), "{said}");
    }
}

/// A plan that is stopped at a report of the search for what would make it feasible, and how many reports there were.
fn planned_until(inputs: &PlanInputs, report: usize) -> (PlanOutcome, usize) {
    let (cancel, reports) = (Cancel::default(), Arc::new(AtomicUsize::new(0)));
    let (stopping, counted) = (cancel.clone(), reports.clone());
    let progress = Progress::new(move |update| {
        if update.stage == Opening::SEARCH {
            assert!(update.message.starts_with("jams at node"), "{}", update.message);
            if counted.fetch_add(1, Ordering::Relaxed) + 1 == report {
                stopping.cancel();
            }
        }
    });
    let outcome = run_prepared(ready(), inputs, &|_, _, _| (), &Task { progress, cancel }).unwrap();
    (outcome, reports.load(Ordering::Relaxed))
}

/// The coarse plan of `blisk` by an electrode that enters from `enter`, with what it was made of.
fn coarse_plan(blisk: &ParametricBlisk, enter: EnterSide) -> (PlanInputs, PreparedBlisk, PlanOutcome) {
    let mut job = coarse_job(0.05);
    job.electrode.enter = enter;
    let inputs = PlanInputs::of(mesh(blisk), job);
    let ready = prepare(&inputs, &Task::default()).unwrap();
    let outcome = run_prepared(&ready, &inputs, &|_, _, _| (), &Task::default()).unwrap();
    (inputs, ready, outcome)
}

/// The sides of an uneven passage need different reductions: each jam tells of its own.
#[test]
fn a_remedy_holds_for_the_side_that_it_is_told_of() {
    let blisk = ParametricBlisk { beta_in_deg: 20.0, beta_out_deg: -50.0, ..easy_blisk() };
    let (inputs, ready, outcome) = coarse_plan(&blisk, EnterSide::Auto);
    let electrode = only(&outcome);
    let best = (electrode.electrode.enters_from, electrode.plan.verdict(&outcome.channel));
    assert_eq!(electrode.tried.len(), 1, "it jams on both sides: {best:?}");
    let enough = |said: &str| {
        let (_, rest) = said.split_once("; feasible with both walls reduced by ")?;
        rest.split(' ').next()?.parse::<f64>().ok()
    };
    assert!(enough(&best.1).is_some(), "one that a change opens is told of first: {best:?}");
    for (side, said) in electrode.tried.iter().chain([&best]) {
        let Some(reduction) = enough(said) else { continue };
        let mut followed = inputs.clone();
        followed.job.electrode.enter = (*side).into();
        followed.job.electrode.circumferential_reduction_deg = [reduction; 2];
        let helped = run_feeds(&ready, &followed, &Task::default()).unwrap();
        assert!(helped.is_verified(), "towards {side:?}: {said}: {}", only(&helped).plan.verdict(&helped.channel));
    }
}

/// A passage that turns by more than its walls can give way for: what else was tried is told.
#[test]
fn where_no_reduction_of_the_walls_is_enough_other_changes_are_tried() {
    let blisk = ParametricBlisk { beta_in_deg: 58.0, beta_out_deg: -58.0, ..curved_blisk() };
    let (inputs, ready, outcome) = coarse_plan(&blisk, EnterSide::MinusX);
    let jam = only(&outcome).plan.jam.as_ref().expect("it jams");
    let opening = jam.opening.as_ref().expect("what would help was looked for");
    assert!(!opening.is_by_walls(), "{opening:?}");
    let [Change::Side(EntrySide::PlusX), Change::Radial(radial), Change::Divided(0.5)] = opening.in_vain[..] else {
        panic!("{opening:?}")
    };
    // The greatest that was tried: 0.35 of the height, to a tenth.
    let height = outcome.channel.middle().height();
    assert!((radial - inputs.job.electrode.radial_reduction_mm - 0.35 * height).abs() <= 0.1, "{radial}");
    // All at once are enough, and that does help.
    let [Change::AllReductions { reductions: [low, high], radial_mm }] = opening.changes[..] else {
        panic!("{opening:?}")
    };
    let said = only(&outcome).plan.verdict(&outcome.channel);
    let deg = low.to_degrees();
    assert!(
        said.contains(&format!("both walls reduced by {deg:.2} deg and a radial reduction of {radial_mm:.2} mm")),
        "{said}"
    );
    let mut smaller = inputs.clone();
    smaller.job.electrode.circumferential_reduction_deg =
        [low, high].map(|angle| (angle.to_degrees() * 100.0).round() / 100.0);
    smaller.job.electrode.radial_reduction_mm = radial_mm;
    let helped = run_prepared(&ready, &smaller, &|_, _, _| (), &Task::default()).unwrap();
    assert!(helped.is_verified(), "{}", only(&helped).plan.verdict(&helped.channel));
    // Where nothing helps, all that was tried is told.
    let mut jam = jam.clone();
    let opening = jam.opening.as_mut().unwrap();
    opening.in_vain.append(&mut opening.changes);
    let said = jam.sentence(&outcome.channel);
    for word in [
        "both walls reduced by 2.86 deg more",
        "nor towards +x",
        "nor with a radial reduction of",
        "nor divided in two",
        "mm at once",
    ] {
        assert!(said.contains(word), "{said}");
    }
    // Both halves have what the whole has of its own.
    let mut divided = inputs.job.electrode.clone();
    divided.part = vec![PartParams { low_reduction_deg: Some(1.0), ..PartParams::default() }];
    assert_eq!(divided.divide(0), 0.5);
    assert_eq!([0, 1].map(|part| divided.of_part(part).circumferential_reduction_deg), [[1.0, 0.05]; 2]);
}

fn sizes_are_certified_and_what_is_sized_is_what_a_plan_makes() {
    let mut base = easy_inputs(coarse_job(2.8));
    base.job.plan.strategy = Strategy::Genetic;
    let shown = std::sync::Mutex::new(Vec::new());
    let found = |row: &_| shown.lock().unwrap().push(Clone::clone(row));
    let range = SizingRange { from: 1, to: 1 };
    let rows = size(ready(), &base, range, &found, &Task::default()).unwrap();
    assert!(!rows.is_empty());
    let row = &rows[0];
    assert_eq!(*shown.lock().unwrap(), rows, "no row is shown that is thrown away");
    let [least] = row.reduction_deg[..] else { panic!("{row:?}") };
    assert!(least[0] < 2.0 && least[0] == least[1], "{row:?}");
    assert!(row.certified_mm >= 0.1 - 0.002);
    let mut job = coarse_job(0.0);
    job.electrode.circumferential_reduction_deg = least;
    let inputs = easy_inputs(job);
    let plan = run_feeds(ready(), &inputs, &Task::default()).unwrap();
    assert!(plan.is_verified());
    assert_eq!(only(&plan).electrode.least_thickness_mm, row.least_thickness_mm);
    let mut less = inputs.clone();
    less.job.electrode.circumferential_reduction_deg = least.map(|deg| deg - TOLERANCE_DEG);
    assert!(!run_feeds(ready(), &less, &Task::default()).unwrap().is_verified(), "there is a certified plan with less");
    let thicker =
        |r: &sparkpath::workspaces::blisk::job::sizing::SizeRow| r.least_thickness_mm >= row.least_thickness_mm;
    assert!(rows.iter().filter(|r| r.reduction_deg[0][0] != r.reduction_deg[0][1]).all(thicker), "{rows:?}");
}

fn sets_are_what_their_plans_make() {
    let mut base = easy_inputs(coarse_job(2.8));
    let stage = |name: &str, stock_mm, last_step: &str| StageParams {
        name: name.to_owned(),
        spark_gap_mm: 0.15,
        stock_mm,
        last_step: last_step.to_owned(),
        ..StageParams::default()
    };
    base.job.electrode.stage = vec![stage("rough", 0.25, "S1"), stage("finish", 0.0, "S1")];
    // The search of sets is the global one, whatever the job's own draws in.
    (base.job.plan.strategy, base.job.genetic.h) = (Strategy::Genetic, ReductionMode::Variable);
    let space = DesignSpace { most_parts: 1, columns: false, radial_reductions_mm: Vec::new(), planes: Vec::new() };
    let design = design(ready(), &base, &space, &DesignLimits::default(), &|_| (), &Task::default()).unwrap();
    for row in &design.rows {
        // Each stage is drawn in by what it needs itself.
        let [rough, finish] = [0, 1].map(|stage| &row.stages[stage].size);
        assert!(rough.reduction_deg != finish.reduction_deg, "{row:?}");
        assert!(rough.certified_mm > 0.39 && rough.least_thickness_mm < finish.least_thickness_mm, "{row:?}");
        let mut job = base.job.clone();
        assert!(!row.is_applied(&job));
        row.apply(&mut job);
        job.validate().unwrap();
        assert!(row.is_applied(&job));
        let inputs = PlanInputs { job, ..base.clone() };
        let plan = run_finished(ready(), &inputs, &Task::default()).unwrap();
        let certified = |e: &ElectrodeOutcome| e.plan.path.as_ref().unwrap().certificate.certified();
        let planned: Vec<f64> = plan.electrodes.iter().map(certified).collect();
        assert_eq!(planned, row.stages.iter().map(|stage| stage.size.certified_mm).collect::<Vec<_>>());
        let burning = WheelBurning::of_job(&plan, &inputs.job).unwrap();
        assert_eq!((burning.channel, burning.schedule.map(|of| of.total())), (row.channel, row.wheel));
        assert_eq!(plan.residual_stock().unwrap().stock.left_mm3, row.left_mm3.unwrap());
    }
    assert!(!design.rows.is_empty(), "{}", design.sentence());
    // The finishing electrode burns so little that the step's current is too high for its area: that is told, and no hours.
    for row in &design.rows {
        let why = row.no_minutes.as_deref().unwrap_or_default();
        assert!(
            row.wheel.is_none() && why.contains("electrode 2 (finish)") && why.contains("more frontal area"),
            "{why}"
        );
    }
    assert!(design.fastest().is_none() && design.sentence().contains("hours are not known"), "{}", design.sentence());
}

fn a_glance_tells_what_the_plan_will_say_where_that_is_clear() {
    let look = |reduction| {
        let inputs = easy_inputs(job_with(Strategy::Global, reduction));
        live_way(ready(), &inputs, 0, &Task::default()).unwrap()
    };
    let out = look(2.8);
    assert!(out.way.margin.is_some_and(|w| w > 0.0) && out.way.jam.is_none());
    assert!(out.sentence(&global_plan().channel).contains("extraction path towards -X probable"));
    cancelling_ends_a_global_plan();
    let stuck = look(0.05);
    assert!(stuck.way.margin.is_none() && stuck.way.jam.is_some());
}

fn cancelling_ends_a_global_plan() {
    let cancel = Cancel::default();
    cancel.cancel();
    let inputs = easy_inputs(job_with(Strategy::Global, 2.8));
    let ended = run_prepared(ready(), &inputs, &|_, _, _| (), &Task::silent(&cancel));
    assert!(matches!(ended, Err(PlanJobError::Cancelled(_))));
}
