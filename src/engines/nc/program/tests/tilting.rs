//! Programs for a machine whose C turns the table.

use super::*;
use feed::machine::TurnedByC;
use feed::preset::Preset;

/// Places of a point of the electrode on the workpiece that a program takes it to, by the joints of the machine: the
/// electrode slides, and a table with A turns back on one that C turns back about a line along Z through `q`.
fn on_workpiece(text: &str, post: &Post, o: DVec3, q: Option<DVec3>, p: DVec3) -> Vec<DVec3> {
    let place = |axes: &Pose| {
        let slid = p + DVec3::new(axes.x, axes.y, axes.z);
        let turned_c = DMat3::from_rotation_z(axes.c);
        let on_cradle = match q {
            Some(q) => q + turned_c * (slid - q),
            // The electrode itself is turned, about O.
            None => o + DVec3::new(axes.x, axes.y, axes.z) + turned_c * (p - o),
        };
        DMat3::from_rotation_x(axes.a) * on_cradle
    };
    // Densely, with every axis of the machine linear from block to block.
    let poses = replayed(post, text, false);
    let between = |pair: &[Pose]| [0.0, 0.5].map(|t| pair[0].lerp(&pair[1], t));
    poses.windows(2).flat_map(between).map(|axes| place(&axes)).collect()
}

#[test]
fn a_tilting_table_takes_the_electrode_the_same_way_as_a_head_that_turns_it() {
    let (scene, nothing) = (Scene::new(EntrySide::PlusX), MachineModel::default());
    let plain = fixtures::machine_with_bodies();
    let tilting = MachineParams { c_turns: TurnedByC::Table, c_axis_mm: [-45.0, 12.0], ..plain.clone() };
    let post = Post::load("iso", None).unwrap();
    let text = |machine: &MachineParams, preset: Option<&Preset>| {
        let simulation = scene.simulation_of(preset, None, (machine, &nothing), &[OWN_CHANNEL]);
        assert!(simulation.holds(), "{}", simulation.sentence());
        let other = scene.approved().with_preset(Some(&Preset::default())).with_simulation(&simulation, &nothing);
        assert!(matches!(other, Err(NotApproved::OtherSimulated("preset"))));
        let approved = scene.approved().with_preset(preset).with_simulation(&simulation, &nothing).unwrap();
        NcProgram::new(&approved, &post, &NcSettings::default(), &NcJob { machine, ..job() }).unwrap().text().to_owned()
    };
    let (on_head, on_table) = (text(&plain, None), text(&tilting, None));
    assert!(on_table.contains("C TURNS THE TABLE") && !on_head.contains("C TURNS THE TABLE"));
    assert_ne!(replayed(&post, &on_head, false)[0], replayed(&post, &on_table, false)[0]);
    let o = scene.path.reference_point;
    let q = DVec3::new(scene.blisk.bounds().min.x - 45.0, 12.0, 0.0);
    for p in [o, fixtures::electrode_bounds().min, fixtures::electrode_bounds().max] {
        let ways = [on_workpiece(&on_head, &post, o, None, p), on_workpiece(&on_table, &post, o, Some(q), p)];
        let off = |way: &[DVec3], p: DVec3| {
            let segment = |pair: &[DVec3]| {
                let along = pair[1] - pair[0];
                let t = ((p - pair[0]).dot(along) / along.length_squared().max(1e-300)).clamp(0.0, 1.0);
                (pair[0] + t * along).distance(p)
            };
            way.windows(2).map(segment).fold(f64::INFINITY, f64::min)
        };
        // The chords of the coarser program between its points are some micrometres off.
        let worst = ways[0].iter().map(|p| off(&ways[1], *p)).fold(0.0, f64::max);
        assert!(worst < 3e-4, "{worst}");
    }
    // An electrode that stands turned on its holder is taken the same way by another program.
    let arm = (o - q).truncate().into();
    let preset = Preset { c_deg: 2.0, table_arm_mm: Some(arm), ..Preset::default() };
    let off_nominal = text(&tilting, Some(&preset));
    assert!(off_nominal.contains("Rz[-2.000000] * [X Y Z]"), "{off_nominal}");
    let [x0, y0, z0, c0] = preset.zero();
    let p = fixtures::electrode_bounds().max;
    let on_holder = o + DMat3::from_rotation_z(2f64.to_radians()) * (p - o);
    let rows = |text: &str| replayed(&post, text, false);
    for (axes, nominal) in rows(&off_nominal).iter().zip(rows(&on_table)) {
        let slid = on_holder + DVec3::new(x0 + axes.x, y0 + axes.y, z0 + axes.z);
        let place = DMat3::from_rotation_x(axes.a) * (q + DMat3::from_rotation_z(c0 + axes.c) * (slid - q));
        let slid = p + DVec3::new(nominal.x, nominal.y, nominal.z);
        let wanted = DMat3::from_rotation_x(nominal.a) * (q + DMat3::from_rotation_z(nominal.c) * (slid - q));
        assert!(place.distance(wanted) < 1e-4, "{place} {wanted}");
    }
    // A program for the one is none for the other.
    let simulation = scene.simulation(None, (&tilting, &nothing), &[OWN_CHANNEL]);
    let approved = scene.approved().with_simulation(&simulation, &nothing).unwrap();
    let other = NcProgram::new(&approved, &post, &NcSettings::default(), &NcJob { machine: &plain, ..job() });
    assert!(matches!(other, Err(NcError::OtherMachineSimulated { .. })), "{other:?}");
}
