//! Machines whose C turns the table that carries A, beside those whose C turns the electrode.

use super::*;
use crate::machine::TurnedByC;
use crate::pose::Axis;
use glam::DMat3;

/// The bar of the other tests on a machine whose C turns the table about x = 25 mm, y = 3 mm from the drum's far face.
fn on_tilting_table(bodies: Vec<Body>, poses: Vec<Pose>) -> Parts {
    let mut parts = parts(bodies, 0.0).with_poses(poses);
    parts.machine = MachineParams {
        name: "tilting".to_owned(),
        c_turns: TurnedByC::Table,
        c_axis_mm: [25.0, 3.0],
        ..MachineParams::default()
    };
    parts
}

/// Where the C axis is in W.
const Q: DVec3 = DVec3::new(20.0, 3.0, 0.0);

/// A point of what C and A turn as the bed sees it at these axis values, joint by joint.
fn turned(p: DVec3, a: f64, c: f64) -> DVec3 {
    Q + DMat3::from_rotation_z(-c) * (DMat3::from_rotation_x(-a) * p - Q)
}

fn start() -> Vec<Pose> {
    vec![Pose { x: 30.0, y: 1.0, a: 0.1, c: 0.4, ..Pose::FINAL }, Pose::FINAL]
}

#[test]
fn a_pole_on_the_bed_is_met_by_the_cradle_and_by_the_drum_where_the_table_turns_to() {
    // A post where an outrigger of the cradle comes to half way through the turn of C, and another for a lug of the table.
    let (outrigger, lug) = (DVec3::new(0.0, -70.0, -60.0), DVec3::new(-12.0, 50.0, -80.0));
    let half = |p: DVec3, a: f64| turned(p, a, 0.2);
    let at = |name: &str, carrier, p: DVec3| body(name, carrier, (p + DVec3::X * 5.0).to_array(), [1.0; 3]);
    let bodies = vec![
        at("outrigger", Carrier::Cradle, outrigger),
        at("lug", Carrier::Table, lug),
        at("first post", Carrier::Bed, half(outrigger, 0.0)),
        at("second post", Carrier::Bed, half(lug, 0.05)),
    ];
    let simulation = on_tilting_table(bodies, start()).simulate(&[0]);
    for (post, body) in [("first post", "outrigger"), ("second post", "lug")] {
        let contact = pair(&simulation, post, body).contact.unwrap();
        assert!(contact.phase == Phase::Feed && (0.2..0.25).contains(&contact.pose.c), "{post}: {contact:?}");
    }
    // Where C turns the electrode, both stand still but for A.
    let bodies =
        vec![at("outrigger", Carrier::Cradle, outrigger), at("first post", Carrier::Bed, half(outrigger, 0.0))];
    assert!(parts(bodies, 0.0).with_poses(start()).simulate(&[0]).holds());
}

#[test]
fn every_clearance_is_that_of_densely_sampled_joints() {
    let bodies = || {
        vec![
            chuck(),
            body("head", Carrier::Head, [14.0, -3.0, 18.0], [4.0, 4.0, 4.0]),
            body("lug", Carrier::Table, [28.0, -12.0, 108.0], [2.0, 2.0, 2.0]),
            body("yoke", Carrier::Cradle, [50.0, 20.0, 111.0], [6.0, 6.0, 6.0]),
            body("post", Carrier::Bed, [60.0, -20.0, 120.0], [3.0, 3.0, 3.0]),
        ]
    };
    let parts = on_tilting_table(bodies(), start());
    let simulation = parts.simulate(&[0, 1]);
    let legs = simulation.legs(&parts.feed, None);
    let mounted: Vec<Body> = simulation.bodies().to_vec();
    let solid = |name: &str| match name {
        "electrode" => (Carrier::Electrode, &parts.electrode.mesh),
        "blisk" => (Carrier::Table, &parts.blisk),
        other => mounted.iter().find(|b| b.name == other).map(|b| (b.carrier, &b.mesh)).unwrap(),
    };
    // As the bed sees it: slides worked out from where O has to be on the blisk.
    let placed = |carrier: Carrier, pose: &Pose, p: DVec3| {
        let o_on_blisk = pose.placement(O).transform_point3(O);
        let slide = turned(o_on_blisk, pose.a, pose.c) - O;
        match carrier {
            Carrier::Electrode | Carrier::Head => p + slide,
            Carrier::Table => turned(p, pose.a, pose.c),
            Carrier::Cradle => turned(p, 0.0, pose.c),
            Carrier::Bed => p,
        }
    };
    let mut seen = 0;
    for report in simulation.pairs().iter().filter(|p| p.during.is_none()) {
        let [first, second] = [&report.moving, &report.fixed].map(|name| solid(name));
        let mut least = f64::INFINITY;
        for leg in legs.iter().filter(|leg| leg.phase != Phase::Retract) {
            for step in 0..=60 {
                let pose = leg.pose_at((leg.poses.len() - 1) as f64 * f64::from(step) / 60.0);
                let [p, q] = [first, second].map(|(carrier, mesh)| mesh.mapped(|p| placed(carrier, &pose, p)));
                let distance =
                    ExactMesh::new(&p).unwrap().distance_to(&ExactMesh::new(&q).unwrap(), &glam::DAffine3::IDENTITY);
                least = least.min(distance);
            }
        }
        assert!(least >= report.certified - 1e-9, "{} {}: {least} {report:?}", report.moving, report.fixed);
        assert!(least <= report.least.distance + 3.0, "{} {}: {least} {report:?}", report.moving, report.fixed);
        seen += 1;
    }
    // Bar, chuck and head against blisk, lug, yoke and post, but for the bar and the blisk; bar and chuck against the head;
    // blisk and lug against the yoke; the post against blisk, lug and yoke.
    assert_eq!(seen, 11 + 2 + 2 + 3);
}

#[test]
fn the_slides_of_the_machine_are_judged_by_its_travel() {
    let mut parts = on_tilting_table(vec![chuck()], start());
    let chain = *parts.simulate(&[0]).chain();
    let first = chain.machine_pose(&parts.feed.rows[0].pose);
    assert!((first.y - parts.feed.rows[0].pose.y).abs() > 3.0, "the table takes the channel aside: {first:?}");
    let slides: Vec<f64> = chain.refined(&parts.feed.rows).iter().map(|row| chain.machine_pose(&row.pose).y).collect();
    let (least, most) = slides.iter().fold((0.0f64, 0.0f64), |(least, most), y| (least.min(*y), most.max(*y)));
    assert_eq!(first.y, least);
    parts.machine.travel_y_mm = [least - 0.2, most + 0.2];
    // The approach ends with the travel of Y.
    let simulation = parts.simulate(&[0]);
    assert_eq!(simulation.travel(), None, "{}", simulation.sentence());
    let clear = simulation.approach()[0];
    assert!(clear.x > 30.0 && (chain.machine_pose(&clear).y - first.y).abs() > 0.1999, "{clear:?}");
    parts.machine.travel_y_mm[0] = least + 0.1;
    assert_eq!(parts.simulate(&[0]).travel().map(|t| t.axis), Some(Axis::Y));
    // A search is not held up by them.
    assert_eq!(parts.machine.pose_limits().of(Axis::Y), [f64::NEG_INFINITY, f64::INFINITY]);
}
