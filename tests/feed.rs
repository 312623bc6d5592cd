//! Whole plans on parametric blisks: what must hold for every plan, and what must not depend on how it was made.

use std::sync::OnceLock;

use glam::{DMat3, DVec3};
use sparkpath::blisk::electrode::{EnterSide, EntrySide};
use sparkpath::blisk::find_channel::find_channel;
use sparkpath::blisk::options::BliskOptions;
use sparkpath::blisk::parametric::{ChannelSide, MeshResolution, ParametricBlisk};
use sparkpath::export::approved::Approved;
use sparkpath::feed::genetic::ReductionMode;
use sparkpath::feed::pose::Pose;
use sparkpath::feed::search::Constraint;
use sparkpath::feed::verify::Verifier;
use sparkpath::geometry::frame::Cylindrical;
use sparkpath::geometry::mesh::Mesh;
use sparkpath::jobs::plan::{PlanInputs, PlanJobError, PlanOutcome, run};
use sparkpath::progress::{Cancel, Progress};
use sparkpath::project::PlanJob;

/// A blisk with wide channels of little turning, so that small populations do.
fn easy_blisk() -> ParametricBlisk {
    ParametricBlisk {
        blades: 24,
        hub_radius_mm: 60.0,
        shroud_radius_mm: 72.0,
        bore_radius_mm: 40.0,
        width_mm: 20.0,
        chord_mm: 14.0,
        beta_in_deg: 20.0,
        beta_out_deg: -25.0,
        twist_deg: 2.0,
        ..Default::default()
    }
}

fn mesh(blisk: &ParametricBlisk) -> Mesh {
    blisk.mesh(&MeshResolution::default()).unwrap()
}

/// A small search for the easy blisk, withdrawn towards -X.
fn easy_job() -> PlanJob {
    let mut job = PlanJob::demonstration();
    job.electrode.enter = EnterSide::MinusX;
    job.electrode.circumferential_reduction_deg = [2.0, 2.0];
    job.genetic.population = 16;
    job.genetic.generations = 6;
    job.plan.step_mm = 0.8;
    job
}

fn plan(blisk: Mesh, job: PlanJob) -> PlanOutcome {
    let inputs = PlanInputs { blisk, own_electrode: None, job };
    run(&inputs, &Progress::silent(), &Cancel::default()).unwrap()
}

fn easy_plan() -> &'static PlanOutcome {
    static PLAN: OnceLock<PlanOutcome> = OnceLock::new();
    PLAN.get_or_init(|| plan(mesh(&easy_blisk()), easy_job()))
}

#[test]
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

#[test]
fn dense_sampling_with_the_librarys_distance_never_finds_less_than_the_certificate() {
    let outcome = easy_plan();
    let electrode = &outcome.electrodes[0];
    let planned = electrode.plan.path.as_ref().unwrap();
    let blisk = mesh(&easy_blisk()).in_frame(&outcome.channel.frame);
    let exact = |m: &Mesh| sparkpath::geometry::exact::ExactMesh::new(m).unwrap();
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

#[test]
fn the_same_seed_gives_the_same_bytes_on_one_thread_and_on_two() {
    let digest = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let outcome = pool.install(|| plan(mesh(&easy_blisk()), easy_job()));
        let planned = outcome.electrodes[0].plan.path.clone().unwrap();
        (planned.path.digest(), planned.certificate)
    };
    let (one, two) = (digest(1), digest(2));
    assert!(one == two);
    assert_eq!(one.0, easy_plan().electrodes[0].plan.path.as_ref().unwrap().path.digest());
}

#[test]
fn another_seed_gives_another_path() {
    let mut job = easy_job();
    job.genetic.seed = 2;
    let other = plan(mesh(&easy_blisk()), job);
    let digest = |o: &PlanOutcome| o.electrodes[0].plan.path.as_ref().map(|p| p.path.digest());
    assert_ne!(digest(&other), digest(easy_plan()));
}

/// The same part turned, moved and in other units is the same part in W: the electrode has the same size and the path
/// found for the one keeps the same clearance to the other.
#[test]
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
    let verifier = Verifier::new(&moved.in_frame(&there.channel.frame), &b.mesh, b.reference_point).unwrap();
    let mut path = planned.path.clone();
    path.reference_point = b.reference_point;
    let options = here_options();
    let surface = |_| sparkpath::blisk::channel::Surface::Elsewhere;
    let certificate = verifier.verify(&path, &surface, &options, &Progress::silent(), &Cancel::default()).unwrap();
    let difference = certificate.least().distance - planned.certificate.least().distance;
    assert!(difference.abs() < 1e-3, "{difference}");
}

fn here_options() -> sparkpath::feed::verify::VerifyOptions {
    Default::default()
}

#[test]
fn without_reductions_it_jams_and_says_where() {
    let mut blisk = easy_blisk();
    (blisk.beta_in_deg, blisk.beta_out_deg) = (45.0, -45.0);
    let mut job = easy_job();
    job.electrode.circumferential_reduction_deg = [0.0, 0.0];
    let outcome = plan(mesh(&blisk), job);
    assert!(!outcome.is_verified());
    let plan = &outcome.electrodes[0].plan;
    let jam = plan.jam.expect("a curved electrode that fills its channel cannot come out");
    assert!(plan.path.is_none() && jam.node == plan.nodes.len());
    let contact = jam.contact().expect("metal is in the way");
    let on_blisk = contact.on_blisk.in_frame(&outcome);
    assert!(on_blisk < 0.05, "the place is {on_blisk} mm off the blisk");
    let sentence = jam.sentence(&outcome.channel);
    assert!(sentence.contains("jams at node") && sentence.contains(outcome.channel.surface_name(contact.surface)));
}

trait OffBlisk {
    fn in_frame(&self, outcome: &PlanOutcome) -> f64;
}

impl OffBlisk for DVec3 {
    /// Distance of a point in W from the surface of the blisk that jams.
    fn in_frame(&self, outcome: &PlanOutcome) -> f64 {
        let mut blisk = easy_blisk();
        (blisk.beta_in_deg, blisk.beta_out_deg) = (45.0, -45.0);
        let mesh = mesh(&blisk).in_frame(&outcome.channel.frame);
        sparkpath::geometry::exact::ExactMesh::new(&mesh).unwrap().signed_distance(*self).abs()
    }
}

#[test]
fn a_searched_reduction_makes_a_thinner_electrode_that_comes_out() {
    let mut job = easy_job();
    job.electrode.circumferential_reduction_deg = [0.6, 0.6];
    job.genetic.h = ReductionMode::Variable;
    job.genetic.h_max_deg = 2.5;
    let outcome = plan(mesh(&easy_blisk()), job);
    let electrode = &outcome.electrodes[0];
    assert!(outcome.is_verified(), "{}", electrode.plan.verdict(&outcome.channel));
    let h = electrode.plan.h.to_degrees();
    assert!((0.0..=2.5).contains(&h), "{h}");
    let mut given = easy_job();
    given.electrode.circumferential_reduction_deg = [0.6 + h, 0.6 + h];
    given.genetic.generations = 1;
    let same = plan(mesh(&easy_blisk()), given);
    assert!((same.electrodes[0].electrode.volume_mm3 / electrode.electrode.volume_mm3 - 1.0).abs() < 1e-6);
}

#[test]
fn under_the_angle_constraint_the_verifier_has_the_last_word() {
    let mut job = easy_job();
    job.plan.constraint = Constraint::Angle;
    let outcome = plan(mesh(&easy_blisk()), job);
    let plan = &outcome.electrodes[0].plan;
    // The angle test is blind to edges and to what lies beside the walls: it leads away from the final pose, but
    // whether all the way out is not promised. Whatever it hands out has been judged by exact distances.
    assert!(plan.nodes.len() > 5, "{}", plan.verdict(&outcome.channel));
    assert_eq!(plan.jam.is_some(), plan.path.is_none());
    let holds = plan.path.as_ref().is_some_and(|p| p.certificate.certified() >= 0.098);
    assert_eq!(outcome.is_verified(), holds);
}

#[test]
fn entry_from_the_other_side_withdraws_to_the_other_side() {
    let mut job = easy_job();
    job.electrode.enter = EnterSide::PlusX;
    let outcome = plan(mesh(&easy_blisk()), job);
    let electrode = &outcome.electrodes[0];
    assert_eq!(electrode.electrode.enters_from, EntrySide::PlusX);
    assert!(outcome.is_verified(), "{}", electrode.plan.verdict(&outcome.channel));
    assert!(electrode.plan.path.as_ref().unwrap().path.rows[0].pose.x > 10.0);
}

#[test]
fn two_parts_are_two_electrodes_that_share_their_overlap() {
    let mut job = easy_job();
    job.electrode.parts = 2;
    job.electrode.enter = EnterSide::Auto;
    let outcome = plan(mesh(&easy_blisk()), job);
    assert_eq!(outcome.electrodes.len(), 2);
    assert!(outcome.is_verified());
    let burning = |e: &sparkpath::blisk::electrode::Electrode| {
        let burns = (0..e.faces.len()).filter(|&i| e.faces[i].burns()).flat_map(|i| e.mesh.corners(i));
        burns.fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], p| [a.min(p.x), b.max(p.x)])
    };
    let [first, second] = [0, 1].map(|i| burning(&outcome.electrodes[i].electrode));
    assert!((first[1] - second[0] - 1.0).abs() < 1e-4, "parts along X share overlap_mm: {first:?} {second:?}");
}

#[test]
fn channel_walls_lie_on_the_generators_own_surfaces() {
    let blisk = easy_blisk();
    let fine = MeshResolution { chord: 60, span: 8, edge: 10, ..Default::default() };
    let part = blisk.mesh(&fine).unwrap();
    let channel = find_channel(&part, &BliskOptions::default(), &Progress::silent(), &Cancel::default()).unwrap();
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
    let inputs = PlanInputs { blisk: mesh(&easy_blisk()), own_electrode: None, job: easy_job() };
    assert!(matches!(run(&inputs, &Progress::silent(), &cancel), Err(PlanJobError::Cancelled(_))));
}
