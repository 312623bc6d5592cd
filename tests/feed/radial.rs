//! Passages along the radius: a nozzle ring whose electrodes come out of the rim.

use feed::angle_test::{AngleParams, AngleTest};
use feed::centreline::Guide;
use feed::machine::MachineParams;
use feed::prepared::PreparedElectrode;
use feed::probes::{SideDemand, Turns};
use geometry::exact::ExactMesh;
use glam::DVec2;
use sparkpath::workspaces::blisk::document::choice::Channels;
use sparkpath::workspaces::blisk::document::kept_plan::KeptPlan;
use sparkpath::workspaces::blisk::document::machine_file::machine_table;
use sparkpath::workspaces::blisk::job::outcome::ElectrodeOutcome;
use sparkpath::workspaces::blisk::job::plan::kept;
use wheel::centreline::Centreline;
use wheel::parametric::wheel::{MeridianCurve, ParametricWheel};

use super::*;

/// A ring with fillets, whose passages an electrode comes out of with some turning of the ring.
fn ring() -> Mesh {
    let across = |x: f64| MeridianCurve::line(DVec2::new(x, 34.0), DVec2::new(x, 48.0));
    let wheel = ParametricWheel {
        hub: across(0.0),
        shroud: across(6.0),
        wrap: [0.3; 2],
        thickness_mm: 1.5,
        fillet_mm: 0.3,
        wall_mm: 2.0,
        pieces: [160, 64, 12],
        ..ParametricWheel::nozzle_ring()
    };
    wheel.mesh()
}

fn radial_job() -> PlanJob {
    let mut job = easy_job();
    job.plan.strategy = Strategy::Global;
    (job.plan.step_mm, job.plan.field_cell_mm) = (2.4, 0.8);
    job.electrode.enter = EnterSide::Auto;
    job.electrode.circumferential_reduction_deg = [2.0, 2.0];
    job
}

/// The ring in W, and what its electrodes are planned in.
fn ring_space(job: &PlanJob) -> (Arc<ExactMesh>, PlanningSpace) {
    let task = Task::default();
    let channel: Arc<_> = find_channel(&ring(), &BliskOptions::default(), &task).unwrap().into();
    let blisk: Arc<_> = ring().in_frame(&channel.frame).into();
    let exact = Arc::new(ExactMesh::new(&blisk).unwrap());
    let space = PlanningSpace::new(blisk, exact.clone(), channel, job.plan.field_cell_mm, &task).unwrap();
    (exact, space)
}

#[test]
fn an_electrode_of_a_nozzle_ring_is_withdrawn_along_the_radius_and_copies_to_both_walls() {
    let mesh = ring();
    let mut job = radial_job();
    job.machine = built_in("xyzac-ram");
    job.export.channels = Channels::These(vec![0, 3]);
    let outcome = whole_plan(mesh.clone(), job);
    let electrode = &outcome.electrodes[0];
    assert!(outcome.is_verified(), "{}", electrode.plan.verdict(&outcome.channel));
    assert_eq!(electrode.electrode.enters_from, EntrySide::Outward);
    let planned = electrode.plan.path.as_ref().unwrap();
    assert_eq!(planned.certificate.enters_from(), Some(EntrySide::Outward));
    // On the machine with a ram nothing collides, on the way to another channel neither.
    let simulation = outcome.simulation(0).unwrap();
    assert!(simulation.holds(), "{}", simulation.sentence());
    assert_eq!(simulation.visits().len(), 2);
    let is_tested = |moving, fixed| simulation.pairs().iter().any(|p| p.moving == moving && p.fixed == fixed);
    assert!(is_tested("ram", "rotary table") && is_tested("chuck", "blisk") && is_tested("faceplate", "rotary table"));
    assert!(simulation.approach().windows(2).all(|w| w[0].z > w[1].z && w[0].x == w[1].x), "straight down");
    let rows = &planned.path.rows;
    assert!(rows.windows(2).all(|w| w[0].pose.z > w[1].pose.z), "the electrode only ever goes in");
    // Exact distances, densely, and the place where it begins.
    let blisk = mesh.in_frame(&outcome.channel.frame);
    let exact = ExactMesh::new(&blisk).unwrap();
    let body = ExactMesh::new(&electrode.electrode.mesh).unwrap();
    let o = planned.path.reference_point;
    for i in (0..rows.len() - 1).step_by(rows.len().div_ceil(12)) {
        for t in [0.0, 0.37] {
            let placement = rows[i].pose.lerp(&rows[i + 1].pose, t).placement(o);
            let clearance = exact.distance_to(&body, &placement);
            assert!(clearance >= planned.certificate.certified() - 1e-9, "row {i}: {clearance}");
        }
    }
    let first = rows[0].pose.placement(o);
    let rim = blisk.vertices.iter().map(|p| p.y.hypot(p.z)).fold(0.0, f64::max);
    let nearest = electrode.electrode.mesh.vertices.iter().map(|&p| first.transform_point3(p));
    assert!(nearest.map(|p| p.y.hypot(p.z)).fold(f64::INFINITY, f64::min) > rim, "it begins beyond the rim");
    // Kept in a project it is taken up again.
    let plan = KeptPlan { inputs: String::new(), electrodes: kept(&outcome).unwrap() };
    plan.check(&radial_job()).unwrap();
    // The copying motion turns back to both walls, past the fillets, and little is left.
    let copying = outcome.copying(0).unwrap().certified().unwrap();
    assert!(copying.reached.low > 0.9 * copying.wanted.low && copying.reached.high > 0.9 * copying.wanted.high);
    let left = outcome.residual_stock().unwrap();
    assert!(left.stock.left_mm3 < 0.05 * left.stock.channel_mm3, "{:?}", left.stock);
}

#[test]
fn sides_that_a_radial_passage_does_not_open_to_and_bodies_that_come_from_elsewhere_are_refused() {
    let refused = |change: &dyn Fn(&mut PlanJob)| {
        let mut job = radial_job();
        change(&mut job);
        run(&PlanInputs::of(ring(), job), &Task::default()).unwrap_err().to_string()
    };
    let said = refused(&|job| job.electrode.enter = EnterSide::MinusX);
    assert!(said.contains("the passage is radial and neither of its ends opens to -X"), "{said}");
    let said = refused(&|job| job.machine = built_in("xyzac"));
    assert!(said.contains("the head of xyzac comes along X, and the only side of entry that is left is the rim; choose a machine whose head"), "{said}");
}

#[test]
fn nodes_of_the_centreline_strategy_are_steps_along_the_line_to_the_rim() {
    let mut job = radial_job();
    job.plan.strategy = Strategy::Centreline;
    let outcome = plan(ring(), job.clone());
    let ElectrodeOutcome { electrode, plan, .. } = &outcome.electrodes[0];
    assert!(outcome.is_verified(), "{}", plan.verdict(&outcome.channel));
    assert_eq!(electrode.enters_from, EntrySide::Outward);
    let line = Centreline::of_channel(&outcome.channel, &Task::default().cancel).unwrap();
    let guide = Guide::new(line.clone(), &outcome.channel, electrode).unwrap();
    // From the middle of the passage to the rim.
    let toward = line.at_length(line.length())[0].z - line.at_length(0.0)[0].z;
    let lengths: Vec<f64> = plan.nodes.iter().map(|node| guide.arc_length(node.s) * toward.signum()).collect();
    let steps: Vec<f64> = lengths.windows(2).map(|pair| pair[1] - pair[0]).collect();
    assert!(steps.iter().all(|step| *step > 0.0 && *step < job.plan.step_mm + 1e-6), "{steps:?}");
    let whole = steps.iter().filter(|step| (*step - job.plan.step_mm).abs() < 1e-6).count();
    assert!(2 * whole > steps.len(), "most nodes are whole steps: {steps:?}");
    // The core point keeps near to the line, from which postures are adjusted.
    for node in plan.nodes.iter().take_while(|node| node.s < 8.0) {
        let [on_line, pose] = [guide.on_line(&node.pose), node.pose];
        let off = (on_line.x - pose.x).hypot(on_line.y - pose.y);
        assert!(off < 1.0 && on_line.z == pose.z, "{}: {off}", node.s);
    }
    // On the line it is as far beside it as in the final pose, wherever the ring has turned to.
    let at = |l: f64| line.at_length(l)[0];
    let beside = guide.core() - at(guide.arc_length(0.0));
    for (z, a, c) in [(0.0, 0.0, 0.0), (2.0, 0.05, 0.02), (9.0, -0.1, 0.1), (30.0, 0.2, -0.3)] {
        let pose = guide.on_line(&Pose { x: 7.0, y: -4.0, z, a, c, ..Pose::FINAL });
        let core = pose.placement(electrode.reference_point).transform_point3(guide.core());
        let off = |l: i32| (at(f64::from(l) * 0.01) + beside).distance(core);
        let least = (-4000..=8000).map(off).fold(f64::INFINITY, f64::min);
        assert!(least < 0.006 && pose.z == z, "{z}: {least}");
    }
}

#[test]
fn the_angle_test_frees_the_final_pose_and_refuses_metal_in_a_radial_passage() {
    let (job, task) = (radial_job(), Task::default());
    let (exact, space) = ring_space(&job);
    let channel = space.channel.clone();
    let mut made = make_electrodes(&channel, &exact, &job.electrode, EntrySide::Outward, &task).unwrap();
    let electrode = PreparedElectrode::new(&space, made.swap_remove(0).into(), 0.1, 0.0, &task).unwrap();
    let model = electrode.model(&space, SideDemand::default(), &Cancel::default()).unwrap();
    let test = AngleTest::new(&channel, 0.1, &AngleParams::default());
    let is_free = |pose: Pose| test.is_free(&model, &pose, Turns::NONE);
    assert!(is_free(Pose::FINAL));
    // Against hub and shroud, which are 6 mm apart along X, and against the blades.
    for pose in [
        Pose { x: 1.5, ..Pose::FINAL },
        Pose { x: -1.5, ..Pose::FINAL },
        Pose { a: 0.12, ..Pose::FINAL },
        Pose { a: -0.12, ..Pose::FINAL },
    ] {
        assert!(!is_free(pose), "{pose:?}");
    }
}

/// Where walls are drawn in by unequal angles the holder stands elsewhere, and with it the reference point that poses are
/// about.
#[test]
fn an_electrode_with_its_walls_drawn_in_has_the_clearances_of_one_prepared_by_itself() {
    let (job, task) = (radial_job(), Task::default());
    let (exact, space) = ring_space(&job);
    let channel = space.channel.clone();
    let reductions: [f64; 2] = [1.0, 4.0];
    let [full, drawn_in] = [[0.0; 2], reductions].map(|circumferential_reduction_deg| {
        let params = ElectrodeParams { circumferential_reduction_deg, ..job.electrode.clone() };
        Arc::new(make_electrodes(&channel, &exact, &params, EntrySide::Outward, &task).unwrap().swap_remove(0))
    });
    assert!(full.reference_point.distance(drawn_in.reference_point) > 0.1);
    let prepared = PreparedElectrode::new(&space, full, 0.1, 0.2, &task).unwrap();
    let own = PreparedElectrode::new(&space, drawn_in.clone(), 0.1, 0.0, &task).unwrap();
    let model = prepared.model_of(&drawn_in, &space, SideDemand::default(), &task.cancel).unwrap();
    let truth = own.model(&space, SideDemand::default(), &Cancel::default()).unwrap();
    let turns = Turns(reductions.map(f64::to_radians));
    for (z, y, c) in [(0.5, 0.0, 0.0), (2.0, 0.3, 0.05), (6.0, -0.5, 0.3), (12.0, 1.0, -0.4), (20.0, -2.0, 0.8)] {
        let pose = Pose { z, y, c, ..Pose::FINAL };
        let off = model.least_clearance(&pose, turns) - truth.least_clearance(&pose, Turns::NONE);
        // The blisk's edges see the prepared electrode as what its turned walls leave of it.
        assert!(off.abs() < 0.02, "{pose:?}: {off}");
        let [seen, true_one] = [&model, &truth].map(|of| of.outside().distance_outside(&pose, EntrySide::Outward));
        assert_eq!(seen, true_one, "{pose:?}");
    }
}

fn built_in(name: &str) -> MachineParams {
    let params: MachineParams = toml::Value::Table(machine_table(name).unwrap()).try_into().unwrap();
    MachineParams { name: name.to_owned(), ..params }
}
