use super::*;
use geometry::exact::ExactMesh;
use task::Task;
use wheel::centreline::Centreline;
use wheel::electrode::{ElectrodeParams, EntrySide, make_electrodes};
use wheel::fixtures::exact_channel;
use wheel::parametric::MeshResolution;
use wheel::parametric::ParametricBlisk;

fn guide() -> (Guide, Centreline) {
    let blisk = ParametricBlisk::turbine();
    let channel = exact_channel(&blisk);
    let mesh = blisk.mesh(&MeshResolution::default()).unwrap().in_frame(&channel.frame);
    let task = Task::default();
    let params = ElectrodeParams { circumferential_reduction_deg: [2.0, 2.0], ..Default::default() };
    let exact = ExactMesh::new(&mesh).unwrap();
    let mut electrodes = make_electrodes(&channel, &exact, &params, EntrySide::PlusX, &task).unwrap();
    let line = Centreline::of_channel(&channel, &task.cancel).unwrap();
    (Guide::new(line.clone(), &channel, &electrodes.swap_remove(0)).unwrap(), line)
}

#[test]
fn nodes_follow_the_line_in_steps_of_arc_length() {
    let (guide, line) = guide();
    let mut s = 0.0;
    for _ in 0..60 {
        let next = guide.next_s(s, 0.5);
        assert!(next > s);
        let [a, b] = [s, next].map(|s| guide.arc_length(s));
        // Along +X the arc length grows; the line is nowhere so steep that X alone decides.
        assert!((b - a - 0.5).abs() < 1e-6, "{a} to {b}");
        let [p, q] = [a, b].map(|l| line.at_length(l)[0]);
        assert!((q.x - p.x - (next - s)).abs() < 1e-6);
        s = next;
    }
}

#[test]
fn the_core_point_stays_on_the_line_however_the_electrode_turns() {
    let (guide, line) = guide();
    let o = guide.reference_point();
    let core = guide.core();
    let beside = core - line.at_length(line.length_at_x(core.x))[0];
    assert!(beside.length() < 1.0, "the electrode is about in the middle of its channel: {beside}");
    for (x, a, b, c) in [(0.0, 0.0, 0.0, 0.0), (4.0, 0.02, 0.0, 0.1), (12.0, -0.05, 0.03, -0.2), (40.0, 0.0, 0.0, 0.3)]
    {
        let pose = guide.on_line(&Pose { x, y: 9.0, z: -9.0, a, b, c });
        assert_eq!([pose.x, pose.a, pose.b, pose.c], [x, a, b, c]);
        let at = pose.placement(o).transform_point3(core) - beside;
        let off = at - line.at_length(line.length_at_x(at.x))[0];
        assert!(off.length() < 1e-6, "{off}");
    }
    let still = guide.on_line(&Pose::FINAL);
    assert!(still.y.abs() < 1e-6 && still.z.abs() < 1e-6, "the final pose is where the way begins");
}

#[test]
fn turning_is_the_change_of_direction_seen_along_z() {
    let (guide, line) = guide();
    let (from, to) = (1.0, 6.0);
    let angle = |s: f64| {
        let direction = line.at_length(guide.arc_length(s))[1];
        direction.y.atan2(direction.x)
    };
    let (axis, turn) = guide.turning(from, to);
    assert!(axis == Axis::C && (turn - (angle(to) - angle(from))).abs() < 1e-9);
    assert_eq!(guide.turning(from, from).1, 0.0);
}
