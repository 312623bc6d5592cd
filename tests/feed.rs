//! Whole plans on parametric blisks: what must hold for every plan, and what must not depend on how it was made.

#[path = "feed/centreline.rs"]
mod centreline;
mod common;
#[path = "feed/compare.rs"]
mod compare;
#[path = "feed/files.rs"]
mod files;
#[path = "feed/global.rs"]
mod global;
#[path = "feed/machines.rs"]
mod machines;
#[path = "feed/obstacles.rs"]
mod obstacles;
#[path = "feed/path_repair.rs"]
mod path_repair;
#[path = "feed/radial.rs"]
mod radial;
#[path = "feed/random.rs"]
mod random;
#[path = "feed/replay.rs"]
mod replay;
#[path = "feed/stages.rs"]
mod stages;

use std::sync::{Arc, OnceLock};

use common::{curved_blisk, easy_blisk, mesh};
use feed::certificate::TravelVerdict;
use feed::genetic::ReductionMode;
use feed::jam::JamCause;
use feed::plan::PlanSettings;
use feed::plan_params::{Constraint, Strategy};
use feed::planner::plan_feed;
use feed::pose::{Axis, Pose};
use feed::prepared::PlanningSpace;
use feed::verify::{Verifier, VerifyOptions};
use geometry::exact::ExactMesh;
use geometry::frame::Cylindrical;
use geometry::mesh::Mesh;
use glam::{DMat3, DVec3};
use nc::approved::Approved;
use sparkpath::workspaces::blisk::document::job_file::PlanJob;
use sparkpath::workspaces::blisk::job::outcome::{PlanInputs, PlanJobError, PlanOutcome};
use sparkpath::workspaces::blisk::job::plan::{prepare, run, run_feeds};
use sparkpath::workspaces::blisk::job::prepared_blisk::PreparedBlisk;
use task::{Cancel, Task};
use wheel::channel::Surface;
use wheel::electrode::{ElectrodeError, ElectrodeParams, EnterSide, EntrySide, OwnMesh, make_electrodes};
use wheel::find_channel::find_channel;
use wheel::options::BliskOptions;
use wheel::parametric::{ChannelSide, MeshResolution, ParametricBlisk};

/// A small genetic search for the easy blisk, withdrawn towards -X; the global search has tests of its own.
fn easy_job() -> PlanJob {
    let mut job = PlanJob::demonstration();
    job.plan.strategy = Strategy::Genetic;
    job.electrode.enter = EnterSide::MinusX;
    job.electrode.circumferential_reduction_deg = [2.8, 2.8];
    job.genetic.population = 16;
    job.genetic.generations = 6;
    job.plan.step_mm = 0.8;
    job.plan.field_cell_mm = 0.5;
    job
}

fn easy_inputs(job: PlanJob) -> PlanInputs {
    PlanInputs::of(mesh(&easy_blisk()), job)
}

/// The easy blisk, made ready once.
fn ready() -> &'static PreparedBlisk {
    static READY: OnceLock<PreparedBlisk> = OnceLock::new();
    let make = || prepare(&easy_inputs(easy_job()), &Task::default()).unwrap();
    READY.get_or_init(make)
}

/// The feeds of a job on the easy blisk.
fn plan_easy(job: PlanJob) -> PlanOutcome {
    run_feeds(ready(), &easy_inputs(job), &Task::default()).unwrap()
}

/// The feeds alone, where copying motions and residual stock do not matter.
fn plan(blisk: Mesh, job: PlanJob) -> PlanOutcome {
    let inputs = PlanInputs::of(blisk, job);
    let task = Task::default();
    run_feeds(&prepare(&inputs, &task).unwrap(), &inputs, &task).unwrap()
}

/// The whole plan.
fn whole_plan(blisk: Mesh, job: PlanJob) -> PlanOutcome {
    let inputs = PlanInputs::of(blisk, job);
    run(&inputs, &Task::default()).unwrap()
}

fn whole_easy_plan() -> &'static PlanOutcome {
    static PLAN: OnceLock<PlanOutcome> = OnceLock::new();
    PLAN.get_or_init(|| whole_plan(mesh(&easy_blisk()), easy_job()))
}

fn threads(count: usize) -> rayon::ThreadPool {
    rayon::ThreadPoolBuilder::new().num_threads(count).build().unwrap()
}

fn easy_plan() -> &'static PlanOutcome {
    static PLAN: OnceLock<PlanOutcome> = OnceLock::new();
    PLAN.get_or_init(|| threads(2).install(|| plan_easy(easy_job())))
}

/// All that compares with one and the same plan, which is made once.
#[test]
fn one_plan_seen_from_all_sides() {
    a_plan_is_certified_from_outside_to_the_final_pose_and_may_be_approved();
    dense_sampling_with_the_librarys_distance_never_finds_less_than_the_certificate();
    the_same_seed_gives_the_same_bytes_on_one_thread_and_on_two();
    another_seed_gives_another_path();
    moving_and_scaling_the_mesh_changes_nothing_in_w();
    replay::the_plan_itself_is_taken_up_with_the_same_path();
    replay::a_kept_plan_that_no_search_makes_is_refused();
    replay::a_job_that_cannot_be_planned_can_neither_be_taken_up();
}

/// What is searched or repaired anew beside that plan.
#[test]
fn one_plan_and_what_is_made_of_it() {
    every_row_is_within_the_travel_of_its_axis();
    machines::a_plan_goes_on_a_tilting_table_as_well_and_its_clearance_is_less_by_what_the_machine_leaves_the_poses();
    obstacles::a_plate_before_the_channel_is_in_the_way_of_the_shank_and_one_on_the_other_side_is_not();
    path_repair::a_spoiled_path_is_repaired_without_another_search();
}

fn a_plan_is_certified_from_outside_to_the_final_pose_and_may_be_approved() {
    let outcome = easy_plan();
    assert!(outcome.is_verified(), "{}", outcome.electrodes[0].plan.verdict(&outcome.channel));
    let planned = outcome.electrodes[0].plan.path.as_ref().unwrap();
    let certificate = &planned.certificate;
    assert!(certificate.certified() >= 0.1 - 0.002 && certificate.certified() <= certificate.least().distance);
    assert!(certificate.row_clearance().iter().all(|&c| c >= certificate.certified()));
    assert_eq!(planned.path.rows.last().map(|r| (r.s, r.pose)), Some((0.0, Pose::FINAL)));
    assert!(planned.path.rows.windows(2).all(|w| w[0].s > w[1].s), "the electrode only ever goes in");
    let (blisk, body) = (mesh(&easy_blisk()).in_frame(&outcome.channel.frame), &outcome.electrodes[0].electrode.mesh);
    assert!(Approved::new(planned.path.clone(), certificate.clone(), &blisk, body).is_ok());
}

/// All that needs one and the same whole plan.
#[test]
fn one_whole_plan_is_finished_and_written() {
    the_copying_motion_is_certified_and_brings_the_walls_to_their_gap();
    a_threshold_keeps_its_side_farther_off_once_the_feed_has_opened_up();
    files::a_folder_holds_the_programs_of_the_last_plan_only();
    files::what_cannot_be_replaced_is_named_and_no_program_lies_beside_it();
    files::a_plan_that_is_stopped_at_its_pictures_is_written_without_them_and_without_a_program();
    files::an_electrode_keeps_its_clearance_as_step();
    files::a_preset_is_made_up_for_by_path_and_program();
    files::a_worn_electrode_goes_on_by_what_it_lost();
}

fn the_copying_motion_is_certified_and_brings_the_walls_to_their_gap() {
    let outcome = whole_easy_plan();
    let copying = outcome.copying(0).unwrap();
    let motion = copying.certified().unwrap_or_else(|| panic!("{}", copying.sentence()));
    let rows = &motion.path.rows;
    assert!(rows.len() > 2 && rows[0].pose == Pose::FINAL && rows[rows.len() - 1].pose == Pose::FINAL);
    let left = outcome.residual_stock().unwrap();
    // Nothing is cut deeper than the tolerance of the certificates, which is less than is counted.
    assert!(left.deepest().is_none(), "{:?}", left.deepest());
    let reduced = easy_job().electrode.circumferential_reduction_deg[0].to_radians();
    let walls = left.surfaces.iter().filter(|s| matches!(s.surface, Surface::LowWall | Surface::HighWall));
    for wall in walls {
        // What the reduction leaves on a wall of some 50 mm radius is gone nearly everywhere.
        assert!(wall.left.area_mm2 < 0.2 * wall.area_mm2 && reduced > 0.0, "{wall:?}");
    }
    assert!(left.stock.left_mm3 < 0.02 * left.stock.channel_mm3, "{:?}", left.stock);
}

fn dense_sampling_with_the_librarys_distance_never_finds_less_than_the_certificate() {
    let outcome = easy_plan();
    let electrode = &outcome.electrodes[0];
    let planned = electrode.plan.path.as_ref().unwrap();
    let blisk = mesh(&easy_blisk()).in_frame(&outcome.channel.frame);
    let exact = |m: &Mesh| ExactMesh::new(m).unwrap();
    let (blisk, body) = (exact(&blisk), exact(&electrode.electrode.mesh));
    let rows = &planned.path.rows;
    for i in (0..rows.len() - 1).step_by(rows.len() / 12) {
        for t in [0.21, 0.77] {
            let pose = rows[i].pose.lerp(&rows[i + 1].pose, t);
            let clearance = blisk.distance_to(&body, &pose.placement(planned.path.reference_point));
            assert!(clearance >= planned.certificate.certified() - 1e-9, "row {i}: {clearance}");
        }
    }
}

fn the_same_seed_gives_the_same_bytes_on_one_thread_and_on_two() {
    // From the mesh on: nothing that was made ready on two is taken.
    let one = threads(1).install(|| plan(mesh(&easy_blisk()), easy_job()));
    let [one, two] = [&one, easy_plan()].map(|o| o.electrodes[0].plan.path.as_ref().unwrap());
    assert_eq!(one.path.digest(), two.path.digest());
    assert!(one.certificate == two.certificate);
}

fn another_seed_gives_another_path() {
    let mut job = easy_job();
    job.genetic.seed = 2;
    let other = plan_easy(job);
    let digest = |o: &PlanOutcome| o.electrodes[0].plan.path.as_ref().map(|p| p.path.digest());
    assert_ne!(digest(&other), digest(easy_plan()));
}

/// The same part turned, moved and in other units is the same part in W: the electrode has the same size and the path
/// found for the one keeps the same clearance to the other.
fn moving_and_scaling_the_mesh_changes_nothing_in_w() {
    let turn = DMat3::from_rotation_z(0.3) * DMat3::from_rotation_y(-0.4);
    let moved = mesh(&easy_blisk()).mapped(|p| turn * p + DVec3::new(30.0, -12.0, 7.0));
    // Through inches and back, as the importer would.
    let moved = moved.mapped(|p| p / 25.4).mapped(|p| p * 25.4);
    let mut job = easy_job();
    // The channel nearest to the mesh's own direction may be another one; all are alike.
    job.plan.constraint = Constraint::Distance;
    let here = easy_plan();
    let there = plan(moved.clone(), job);
    assert!(there.is_verified());
    let (a, b) = (&here.electrodes[0].electrode, &there.electrodes[0].electrode);
    assert!((a.volume_mm3 / b.volume_mm3 - 1.0).abs() < 1e-4, "{} {}", a.volume_mm3, b.volume_mm3);
    assert!((a.least_thickness_mm - b.least_thickness_mm).abs() < 1e-3);
    let planned = here.electrodes[0].plan.path.as_ref().unwrap();
    let verifier =
        Verifier::new(&moved.in_frame(&there.channel.frame), &b.mesh, b.reference_point, &Cancel::default()).unwrap();
    let mut path = planned.path.clone();
    path.reference_point = b.reference_point;
    let options = VerifyOptions::default();
    let surface = |_| wheel::channel::Surface::Elsewhere;
    let certificate = verifier.verify(&path, &surface, &options, &Task::default()).unwrap();
    let difference = certificate.least().distance - planned.certificate.least().distance;
    assert!(difference.abs() < 1e-3, "{difference}");
}

#[test]
fn without_reductions_it_jams_and_says_where() {
    let mut job = easy_job();
    job.electrode.circumferential_reduction_deg = [0.0, 0.0];
    // However long is searched there is nothing to be found.
    (job.genetic.population, job.genetic.generations) = (8, 3);
    let outcome = plan(mesh(&curved_blisk()), job);
    assert!(!outcome.is_verified());
    let plan = &outcome.electrodes[0].plan;
    let jam = plan.jam.as_ref().expect("a curved electrode that fills its channel cannot come out");
    assert!(plan.path.is_none() && jam.node == plan.nodes.len());
    let contact = jam.contact().expect("metal is in the way");
    let blisk = ExactMesh::new(&mesh(&curved_blisk()).in_frame(&outcome.channel.frame)).unwrap();
    let off = blisk.signed_distance(contact.on_blisk).abs();
    assert!(off < 0.05, "the place is {off} mm off the blisk");
    let sentence = jam.sentence(&outcome.channel);
    assert!(sentence.contains("jams at node") && sentence.contains(outcome.channel.surface_name(contact.surface)));
}

/// The easy electrode without reductions, which fills its channel, and a search for h.
fn job_that_needs_h() -> PlanJob {
    let mut job = easy_job();
    job.electrode.circumferential_reduction_deg = [0.0, 0.0];
    job.genetic.h = ReductionMode::Variable;
    job.genetic.h_max_deg = 2.5;
    job
}

/// Searches for h on one blisk, which is made ready once.
#[test]
fn one_blisk_and_reductions_that_are_searched() {
    an_electrode_that_fills_its_channel_is_no_answer();
    a_searched_reduction_makes_a_thinner_electrode_that_comes_out_where_the_given_one_jams();
}

/// Other jobs on that blisk.
#[test]
fn one_blisk_and_what_a_job_asks_of_its_way() {
    under_the_angle_constraint_every_node_is_between_the_surfaces_and_the_verifier_has_the_last_word();
    a_margin_is_kept_on_the_way();
    travel_that_ends_before_the_way_out_is_named();
    entry_from_the_other_side_withdraws_to_the_other_side();
    two_parts_are_two_electrodes_that_share_their_overlap();
}

fn an_electrode_that_fills_its_channel_is_no_answer() {
    let mut given = job_that_needs_h();
    given.genetic.h = ReductionMode::Given;
    // However long is searched there is nothing to be found.
    (given.genetic.population, given.genetic.generations) = (8, 3);
    let jammed = plan_easy(given);
    assert!(jammed.electrodes[0].plan.jam.is_some(), "h = 0 is no answer");
}

fn a_searched_reduction_makes_a_thinner_electrode_that_comes_out_where_the_given_one_jams() {
    let outcome = plan_easy(job_that_needs_h());
    let electrode = &outcome.electrodes[0];
    assert!(outcome.is_verified(), "{}", electrode.plan.verdict(&outcome.channel));
    let h = electrode.plan.h.to_degrees();
    assert!(h > 0.0 && h <= 2.5, "{h}");
    let blisk = ExactMesh::new(&mesh(&easy_blisk()).in_frame(&outcome.channel.frame)).unwrap();
    let volume = |h| {
        let params = ElectrodeParams { circumferential_reduction_deg: [h, h], ..easy_job().electrode };
        let made = make_electrodes(&outcome.channel, &blisk, &params, EntrySide::MinusX, &Task::default()).unwrap();
        made[0].volume_mm3
    };
    assert!(electrode.electrode.volume_mm3 < volume(0.0));
    assert!((volume(h) / electrode.electrode.volume_mm3 - 1.0).abs() < 1e-6);
}

#[test]
fn a_searched_reduction_that_leaves_no_metal_is_an_answer_and_not_bad_input() {
    let (job, task) = (job_that_needs_h(), Task::default());
    let part = mesh(&easy_blisk());
    let channel = Arc::new(find_channel(&part, &BliskOptions::default(), &task).unwrap());
    let blisk = Arc::new(part.in_frame(&channel.frame));
    let exact = Arc::new(ExactMesh::new(&blisk).unwrap());
    let electrodes = make_electrodes(&channel, &exact, &job.electrode, EntrySide::MinusX, &task).unwrap();
    let space = PlanningSpace::new(blisk, exact, channel.clone(), job.plan.field_cell_mm, &task).unwrap();
    let settings = PlanSettings {
        plan: &job.plan,
        genetic: &job.genetic,
        machine: &job.machine,
        verify: &job.verify,
        spark_gap: job.electrode.spark_gap_mm,
        explain: false,
        observe: &|_, _| (),
    };
    let nothing = |_: f64| Err(ElectrodeError::NoMetal { x: 0.0, r: 60.0, available: 1.0, taken: 1.1 });
    let plan = plan_feed(&space, &electrodes[0].clone().into(), &settings, &nothing, &task).unwrap();
    let jam = plan.jam.as_ref().unwrap();
    assert!(matches!(jam.cause, JamCause::NothingLeft { h } if h > 0.0 && h == plan.h), "{jam:?}");
    assert!(!plan.is_verified() && plan.verdict(&channel).contains("leaves no electrode"));
}

/// P0: "the value point be within the flow channel between the left and right surfaces", and between hub and shroud.
fn under_the_angle_constraint_every_node_is_between_the_surfaces_and_the_verifier_has_the_last_word() {
    let mut job = easy_job();
    job.plan.constraint = Constraint::Angle;
    let outcome = plan_easy(job);
    let (plan, channel) = (&outcome.electrodes[0].plan, &outcome.channel);
    // The angle test is blind to edges and to what lies beside the walls: it leads away from the final pose, but
    // whether all the way out is not promised. Whatever it hands out has been judged by exact distances.
    assert!(plan.nodes.len() > 5, "{}", plan.verdict(channel));
    let holds = plan.path.as_ref().is_some_and(|p| p.certificate.certified() >= 0.098);
    assert_eq!(outcome.is_verified(), holds);
    let electrode = &outcome.electrodes[0].electrode;
    let (blisk, [from, to]) = (easy_blisk(), channel.span_x());
    let inner = [from + 0.15 * (to - from), to - 0.15 * (to - from)];
    let mut judged = 0;
    for node in &plan.nodes {
        let place = node.pose.placement(electrode.reference_point);
        for p in electrode.mesh.vertices.iter().map(|&p| place.transform_point3(p)) {
            if p.x < inner[0] || p.x > inner[1] {
                continue;
            }
            judged += 1;
            let at = Cylindrical::from_point(channel.frame.to_parent(p));
            assert!(at.r > 42.0 && at.r < 50.0, "s {}: radius {}", node.s, at.r);
            // Of the generator's own walls, brought to the channel that the point is in.
            let pitch = blisk.pitch();
            let from_low = (at.theta - blisk.wall_theta(ChannelSide::Low, at.x, at.r)).rem_euclid(pitch);
            let width =
                blisk.wall_theta(ChannelSide::High, at.x, at.r) - blisk.wall_theta(ChannelSide::Low, at.x, at.r);
            assert!(from_low < width, "s {}: {:.3} mm beyond the high wall", node.s, at.r * (from_low - width));
        }
    }
    assert!(judged > 1000, "{judged}");
}

fn a_margin_is_kept_on_the_way() {
    let mut job = easy_job();
    job.plan.margin_mm = 0.05;
    let outcome = plan_easy(job);
    let planned = outcome.electrodes[0].plan.path.as_ref().unwrap();
    assert!(outcome.is_verified());
    // In the final pose only the spark gap is open; 5 % of the way later there is room for the margin too.
    let away: Vec<f64> = planned
        .path
        .rows
        .iter()
        .zip(planned.certificate.row_clearance())
        .filter(|(row, _)| row.s > 2.0)
        .map(|(_, &clearance)| clearance)
        .collect();
    let least = away.iter().copied().fold(f64::INFINITY, f64::min);
    assert!(away.len() > 20 && least >= 0.15 - 0.002, "{least} mm over {} rows", away.len());
}

/// A ring about the X axis.
fn ring([from, to]: [f64; 2], [inner, outer]: [f64; 2]) -> Mesh {
    const N: u32 = 180;
    let profile = [(from, inner), (from, outer), (to, outer), (to, inner)];
    let at =
        |i: u32, (x, r): (f64, f64)| Cylindrical { x, r, theta: f64::from(i) * std::f64::consts::TAU / f64::from(N) };
    let vertices = (0..N).flat_map(|i| profile.map(|p| at(i, p).point())).collect();
    let quad =
        |i: u32, k: u32| [4 * i + k, 4 * i + (k + 1) % 4, 4 * ((i + 1) % N) + (k + 1) % 4, 4 * ((i + 1) % N) + k];
    let quads = (0..N).flat_map(|i| (0..4).map(move |k| quad(i, k)));
    let ring = Mesh { vertices, triangles: quads.flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]).collect() };
    if ring.volume() > 0.0 {
        ring
    } else {
        Mesh { triangles: ring.triangles.iter().map(|&[a, b, c]| [a, c, b]).collect(), ..ring }
    }
}

#[test]
fn metal_beyond_the_channels_faces_is_passed_before_the_electrode_is_outside() {
    let part = mesh(&easy_blisk());
    let face = part.bounds().min.x;
    let drum = ring([face - 20.0, face - 0.5], [24.0, 30.0]);
    assert!(drum.is_watertight() && drum.volume() > 0.0);
    let first = part.vertices.len() as u32;
    let blisk = Mesh {
        vertices: [part.vertices, drum.vertices].concat(),
        triangles: [part.triangles, drum.triangles.iter().map(|t| t.map(|v| v + first)).collect()].concat(),
    };
    let outcome = plan(blisk.clone(), easy_job());
    let electrode = &outcome.electrodes[0];
    assert!(outcome.is_verified(), "{}", electrode.plan.verdict(&outcome.channel));
    assert!((outcome.channel.faces_x[0] - face).abs() < 1e-3, "the channel ends at its own face");
    let path = &electrode.plan.path.as_ref().unwrap().path;
    let place = path.rows[0].pose.placement(path.reference_point);
    let innermost = electrode.electrode.mesh.vertices.iter().map(|&p| place.transform_point3(p).x);
    let end = blisk.in_frame(&outcome.channel.frame).bounds().min.x;
    let clear = end - innermost.fold(f64::NEG_INFINITY, f64::max);
    assert!(clear >= easy_job().plan.exit_clearance_mm - 1e-4, "{clear} mm beyond the drum");
}

#[test]
fn a_side_for_which_no_electrode_can_be_made_is_noted_and_the_other_tried() {
    // The passage is 5.2 mm high at the -X face and 10.8 mm at the other.
    let blisk = ParametricBlisk { hub_slope: -0.2, shroud_slope: 0.2, ..easy_blisk() };
    let mut job = easy_job();
    job.electrode.enter = EnterSide::Auto;
    job.electrode.shank_inset_mm = 2.5;
    let outcome = plan(mesh(&blisk), job.clone());
    let electrode = &outcome.electrodes[0];
    assert_eq!(electrode.electrode.enters_from, EntrySide::PlusX);
    let [(EntrySide::MinusX, why)] = &electrode.tried[..] else { panic!("{:?}", electrode.tried) };
    assert!(why.contains("no height is left"), "{why}");
    // Asked for that side alone, it is an error that says why.
    job.electrode.enter = EnterSide::MinusX;
    let inputs = PlanInputs::of(mesh(&blisk), job);
    let error = run(&inputs, &Task::default()).unwrap_err();
    assert!(matches!(&error, PlanJobError::Electrode(_)) && why.contains(&error.to_string()), "{error}");
}

fn every_row_is_within_the_travel_of_its_axis() {
    let wide = &easy_plan().electrodes[0].plan.path.as_ref().unwrap().path;
    let reach = |axis: Axis| wide.rows.iter().map(|r| r.pose.get(axis).abs()).fold(0.0, f64::max);
    let mut job = easy_job();
    // Half of what the axes take when they may.
    let half = |axis: Axis| [-0.5 * reach(axis), 0.5 * reach(axis)];
    (job.machine.travel_y_mm, job.machine.travel_z_mm) = (half(Axis::Y), half(Axis::Z));
    job.machine.travel_c_deg = half(Axis::C).map(f64::to_degrees);
    let limits = job.machine.clone();
    let outcome = plan_easy(job);
    let plan = &outcome.electrodes[0].plan;
    assert!(plan.path.is_some(), "{}", plan.verdict(&outcome.channel));
    let planned = plan.path.as_ref().unwrap();
    let within = planned.path.rows.iter().all(|row| {
        let p = row.pose;
        [(p.y, limits.travel_y_mm), (p.z, limits.travel_z_mm), (p.c.to_degrees(), limits.travel_c_deg)]
            .iter()
            .all(|(value, [least, greatest])| *value >= least - 1e-6 && *value <= greatest + 1e-6)
    });
    assert_eq!(planned.certificate.travel() == TravelVerdict::Within, within);
    assert!(within && outcome.is_verified(), "{}", plan.verdict(&outcome.channel));
}

fn travel_that_ends_before_the_way_out_is_named() {
    for strategy in [Strategy::Genetic, Strategy::Global] {
        let mut job = easy_job();
        job.plan.strategy = strategy;
        job.machine.travel_x_mm = [-4.0, 250.0];
        let outcome = plan_easy(job);
        let jam = outcome.electrodes[0].plan.jam.as_ref().expect("4 mm are not enough to leave a blisk of 14 mm");
        let JamCause::Travel { axis: Axis::X, value, limit: -4.0 } = jam.cause else { panic!("{jam:?}") };
        assert!((-4.81..-4.0).contains(&value), "{value}");
        assert!(jam.sentence(&outcome.channel).contains("axis X"));
    }
}

fn entry_from_the_other_side_withdraws_to_the_other_side() {
    let mut job = easy_job();
    job.electrode.enter = EnterSide::PlusX;
    let outcome = plan_easy(job);
    let electrode = &outcome.electrodes[0];
    assert_eq!(electrode.electrode.enters_from, EntrySide::PlusX);
    assert!(outcome.is_verified(), "{}", electrode.plan.verdict(&outcome.channel));
    assert!(electrode.plan.path.as_ref().unwrap().path.rows[0].pose.x > 10.0);
}

fn two_parts_are_two_electrodes_that_share_their_overlap() {
    let mut job = easy_job();
    job.electrode.parts = 2;
    job.electrode.enter = EnterSide::Auto;
    let outcome = plan_easy(job);
    assert_eq!(outcome.electrodes.len(), 2);
    assert!(outcome.is_verified());
    let burning = |e: &wheel::electrode::Electrode| {
        let burns = (0..e.faces.len()).filter(|&i| e.faces[i].burns()).flat_map(|i| e.mesh.corners(i));
        burns.fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], p| [a.min(p.x), b.max(p.x)])
    };
    let [first, second] = [0, 1].map(|i| burning(&outcome.electrodes[i].electrode));
    // The burns share overlap_mm, each with its gap of 0.1 mm.
    assert!((first[1] - second[0] - 0.8).abs() < 1e-4, "{first:?} {second:?}");
    own_electrodes_of_one_channel_are_planned_one_after_the_other(&outcome);
}

/// What was made is taken as meshes of one's own: the same two electrodes, each from its side.
fn own_electrodes_of_one_channel_are_planned_one_after_the_other(made: &PlanOutcome) {
    let mut job = easy_job();
    let sides = [0, 1].map(|i| made.electrodes[i].electrode.enters_from);
    job.electrode.mesh = Some("first.stl".into());
    job.electrode.more = vec![OwnMesh { mesh: "second.stl".into(), enter: sides[1].into() }];
    job.electrode.enter = sides[0].into();
    let mut inputs = easy_inputs(job);
    let in_mesh = |i: usize| made.electrodes[i].electrode.mesh.in_parent_of(&made.channel.frame).into();
    inputs.own_electrodes = vec![in_mesh(0), in_mesh(1)];
    let task = Task::default();
    let outcome = run_feeds(ready(), &inputs, &task).unwrap();
    assert_eq!((inputs.electrodes(), outcome.electrodes.len()), (2, 2));
    assert!(outcome.is_verified());
    for (i, (own, made)) in outcome.electrodes.iter().zip(&made.electrodes).enumerate() {
        let (own, made) = (&own.electrode, &made.electrode);
        assert_eq!((own.enters_from, own.part, own.parts), (sides[i], i, 2));
        assert!((own.volume_mm3 / made.volume_mm3 - 1.0).abs() < 1e-6);
        assert!((own.clearance_mm - made.clearance_mm).abs() < 1e-4);
    }
}

#[test]
fn channel_walls_lie_on_the_generators_own_surfaces() {
    let blisk = easy_blisk();
    let fine = MeshResolution { chord: 60, span: 8, edge: 10, ..Default::default() };
    let part = blisk.mesh(&fine).unwrap();
    let channel = find_channel(&part, &BliskOptions::default(), &Task::default()).unwrap();
    assert_eq!((channel.blades, channel.shrouded), (24, true));
    // W may be turned about X against the generator's frame by whole pitches and by its own choice of middle.
    let reference = |wall: ChannelSide, p: DVec3| {
        let at = Cylindrical::from_point(channel.frame.to_parent(p));
        let off = at.theta - blisk.wall_theta(wall, at.x, at.r);
        at.r * (off - (off / blisk.pitch()).round() * blisk.pitch())
    };
    for (wall, side) in [(&channel.low, ChannelSide::Low), (&channel.high, ChannelSide::High)] {
        // Edges apart, where a facet's chord leaves the arc of the edge and theta says little.
        for u in wall.nu / 8..wall.nu * 7 / 8 {
            for v in 0..wall.nv {
                let off = reference(side, wall.point(u, v));
                assert!(off.abs() < 0.02, "{side:?} {u} {v}: {off} mm");
            }
        }
    }
}

#[test]
fn a_cancelled_plan_answers_nothing() {
    let cancel = Cancel::default();
    cancel.cancel();
    let inputs = PlanInputs::of(mesh(&easy_blisk()), easy_job());
    assert!(matches!(run(&inputs, &Task::silent(&cancel)), Err(PlanJobError::Cancelled(_))));
}

fn a_threshold_keeps_its_side_farther_off_once_the_feed_has_opened_up() {
    const THRESHOLD: f64 = 0.3;
    let mut job = easy_job();
    job.plan.thresholds.low_wall_mm = THRESHOLD;
    let [plain, kept] = [whole_easy_plan(), &whole_plan(mesh(&easy_blisk()), job)];
    // Of nodes so far out that the threshold is asked for in full, and not so far that the walls are left behind.
    let least = |outcome: &PlanOutcome| {
        let electrode = &outcome.electrodes[0];
        let nodes =
            electrode.plan.nodes.iter().zip(&electrode.distances).filter(|(node, _)| (9.0..16.0).contains(&node.s));
        nodes.map(|(_, at)| at.clearances.walls[0]).fold(f64::INFINITY, f64::min)
    };
    assert!(kept.is_verified());
    let [without, with] = [least(plain), least(kept)];
    assert!(with > THRESHOLD - 0.03 && with.is_finite() && without < with, "{without} {with}");
    // D_L of P0 and the distance of P1 are of the same wall; the one is of samples between the blades alone.
    for at in plain.electrodes[0].distances.iter().filter(|at| at.spread.least[0].is_some()) {
        let [d_l, d_1] = [at.spread.least[0].unwrap_or_default(), at.clearances.walls[0]];
        assert!(d_1 <= d_l + 0.05, "{d_1} {d_l}");
    }
}
