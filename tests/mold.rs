//! Molds against figures of independent programs: dexel fields and polygon offsets of sections, made with other code.
//!
//! The three molds come from a CAD kernel: square pockets, slots and lands, filleted cavities on a draft.

#[path = "mold/heights.rs"]
mod heights;
#[path = "mold/random.rs"]
mod random;

use geometry::mesh::Mesh;
use geometry::solid::difference;
use glam::{DMat3, DVec2, DVec3};
use import::{ImportOptions, import_file};
use mold::cutter::{Cutter, CutterLibrary};
use mold::electrode::design::{Burn, Electrode, ElectrodeSet};
use mold::electrode::params::{ElectrodeParams, Stage};
use mold::fixtures::{frame, rectangle};
use mold::surface::SurfacePiece;
use sparkpath::workspaces::mold::job::electrodes::electrodes;
use sparkpath::workspaces::mold::job::uncut::{Uncut, UncutParams, uncut};
use task::Task;

fn mold(name: &str) -> Mesh {
    let file = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/molds").join(name);
    import_file(&file, &ImportOptions::default(), &Task::default()).unwrap().mesh
}

fn library(cutters: &str) -> CutterLibrary {
    CutterLibrary { cutter: cutters.split(',').map(|c| c.parse::<Cutter>().unwrap()).collect() }
}

fn left(mesh: &Mesh, cutters: &str, step: Option<f64>) -> Uncut {
    let params = UncutParams { grid_step_mm: step, ..UncutParams::of(library(cutters)) };
    uncut(mesh, &params, &Task::default()).unwrap()
}

fn plan_area(left: &Uncut) -> f64 {
    left.regions.iter().map(|r| r.plan_area).sum()
}

const MIXED: &str = "flat:1,flat:2,flat:3,ball:0.5,ball:1,ball:2";
const SHORT: &str = "flat:1/6/5,flat:2/12/5,ball:1/6/5";

/// Regions, plan area (mm^2) and volume (mm^3) of dexel fields 0.025 or 0.04 mm apart.
fn agrees(name: &str, expected: &[(&str, Option<f64>, usize, [f64; 2])], off: [f64; 2]) {
    let mesh = mold(name);
    for (cutters, step, regions, figures) in expected {
        let left = left(&mesh, cutters, *step);
        let found = [plan_area(&left), left.found().volume_mm3];
        assert_eq!(left.found().regions, *regions, "{name} {cutters}");
        for k in 0..2 {
            assert!((found[k] / figures[k] - 1.0).abs() < off[k], "{name} {cutters}: {found:?} for {figures:?}");
        }
        assert!(left.regions.iter().all(|r| !r.faces.is_empty() && r.surface_area > 0.0), "{name} {cutters}");
        let (mesh, pieces) = (mesh.area(), left.surface.iter().map(SurfacePiece::area).sum::<f64>());
        assert!(pieces < mesh, "{name} {cutters}: {pieces} of {mesh}");
    }
}

#[test]
fn square_pockets_keep_what_a_dexel_field_says() {
    let expected = [
        ("flat:1", None, 12, [2.5969, 25.125]),
        ("flat:2", None, 12, [10.325, 100.0]),
        ("ball:1", Some(0.04), 3, [177.864, 73.1238]),
        (MIXED, Some(0.025), 12, [2.5969, 6.9169]),
        (SHORT, Some(0.04), 9, [391.6032, 1204.9745]),
    ];
    agrees("a_square.stl", &expected, [0.03; 2]);
}

#[test]
fn slots_and_lands_keep_what_a_dexel_field_says() {
    let expected = [
        ("flat:1", None, 46, [151.05, 915.305]),
        ("flat:2", None, 34, [358.6775, 2086.6488]),
        ("ball:1", Some(0.04), 12, [605.6352, 1024.0466]),
        (SHORT, Some(0.04), 43, [233.0496, 998.2305]),
    ];
    agrees("b_slots.stl", &expected, [0.03; 2]);
    // The area where the residue is as thin as the tolerance depends on the grid: 92.4 at 0.025 mm, 94.2 at 0.0125 mm.
    agrees("b_slots.stl", &[(MIXED, Some(0.025), 48, [96.1175, 192.3653])], [0.045, 0.03]);
}

#[test]
fn filleted_cavities_keep_what_a_dexel_field_says() {
    // Areas on the draft depend on the grid as above; the dexel field at 0.0125 mm says 4.712 mm2 and 9.169 mm3 for R 1.
    // The layers find eight more along the draft, so thin that the grid has no cell of them.
    let flat = left(&mold("c_fillets.stl"), "flat:1", None);
    let clear: Vec<_> = flat.regions.iter().filter(|r| !r.faces.is_empty()).collect();
    assert_eq!((clear.len(), flat.regions.len()), (12, 20));
    let thickest = flat.regions.iter().filter(|r| r.faces.is_empty()).map(|r| r.thickness).fold(0.0, f64::max);
    assert!(thickest < 2.0 * flat.grid_step, "{thickest} {}", flat.grid_step);
    let volume: f64 = clear.iter().map(|r| r.volume).sum();
    let area: f64 = clear.iter().map(|r| r.plan_area).sum();
    assert!((volume / 9.1692 - 1.0).abs() < 0.03 && (area / 4.7122 - 1.0).abs() < 0.05, "{volume} {area}");
    agrees("c_fillets.stl", &[("flat:2", None, 24, [34.8888, 114.3315])], [0.03; 2]);
    agrees("c_fillets.stl", &[("ball:1", Some(0.05), 9, [456.6112, 111.5372])], [0.03, 0.05]);
    // Where the residue is thin the dexel field at 0.025 mm says 0.470 mm3, at 0.0125 mm 0.3351 mm3.
    agrees("c_fillets.stl", &[(MIXED, Some(0.02), 8, [2.1628, 0.3351])], [0.03; 2]);
}

/// Every triangle in three, in another order, turned about Z by a right angle, moved.
fn otherwise(mesh: &Mesh) -> Mesh {
    let mut split = Mesh { vertices: mesh.vertices.clone(), triangles: Vec::new() };
    for (i, &[a, b, c]) in mesh.triangles.iter().enumerate().rev() {
        let middle = split.vertices.len() as u32;
        split.vertices.push(mesh.corners(i).iter().sum::<DVec3>() / 3.0);
        split.triangles.extend([[b, c, middle], [middle, a, b], [c, a, middle]]);
    }
    split.mapped(|p| DVec2::new(-p.y, p.x).extend(p.z) + DVec3::new(7.0, -30.0, 4.0))
}

const SCALE: f64 = 3.0;

#[test]
fn a_mold_turned_moved_split_and_scaled_keeps_the_same() {
    let mesh = mold("a_square.stl");
    for cutters in ["flat:2", "flat:2,ball:1"] {
        let own = left(&mesh, cutters, Some(0.1));
        let turned = left(&otherwise(&mesh), cutters, Some(0.1));
        assert_eq!(own.regions.len(), turned.regions.len(), "{cutters}");
        let volumes = [&own, &turned].map(|left| left.found().volume_mm3);
        assert!((volumes[1] / volumes[0] - 1.0).abs() < 0.02, "{cutters} {volumes:?}");
        let large = mesh.mapped(|p| p * SCALE);
        let mut params = UncutParams { grid_step_mm: Some(0.1 * SCALE), ..UncutParams::of(library(cutters)) };
        params.tolerance_mm *= SCALE;
        (params.layers.spacing_mm, params.layers.least_spacing_mm) =
            (params.layers.spacing_mm * SCALE, params.layers.least_spacing_mm * SCALE);
        for cutter in &mut params.library.cutter {
            (cutter.diameter_mm, cutter.corner_mm) = (cutter.diameter_mm * SCALE, cutter.corner_mm * SCALE);
        }
        let scaled = uncut(&large, &params, &Task::default()).unwrap();
        assert_eq!(scaled.regions.len(), own.regions.len(), "{cutters}");
        let volume = scaled.found().volume_mm3 / SCALE.powi(3);
        assert!((volume / volumes[0] - 1.0).abs() < 0.01, "{cutters}: {volume} {volumes:?}");
    }
}

#[test]
fn more_cutters_never_leave_more_and_larger_ones_never_less() {
    let mesh = mold("b_slots.stl");
    let volume = |cutters: &str| left(&mesh, cutters, Some(0.1)).found().volume_mm3;
    let libraries = ["flat:3", "flat:3,flat:2", "flat:3,flat:2,ball:1", "flat:3,flat:2,ball:1,bull:1:0.3"];
    let volumes = libraries.map(volume);
    assert!(volumes.windows(2).all(|v| v[1] <= v[0] * 1.001), "{volumes:?}");
    let balls = ["ball:1", "ball:1.5", "ball:2"].map(volume);
    assert!(balls.windows(2).all(|v| v[0] <= v[1]), "{balls:?}");
}

fn designed(mesh: &Mesh, left: &Uncut, gap: f64) -> ElectrodeSet {
    let params = ElectrodeParams { stages: vec![Stage::finish(gap)], ..ElectrodeParams::default() };
    electrodes(mesh, left, &params, &Task::default()).unwrap()
}

#[test]
fn square_pockets_have_electrodes_for_every_region_and_every_check_holds() {
    has_electrodes("a_square.stl", None, [12, 2], &[0.05, 0.0]);
}

#[test]
fn slots_and_lands_have_electrodes_for_every_region_and_every_check_holds() {
    has_electrodes("b_slots.stl", Some(0.05), [48, 16], &[0.05]);
}

#[test]
fn filleted_cavities_have_electrodes_for_every_region_and_every_check_holds() {
    has_electrodes("c_fillets.stl", None, [8, 2], &[0.05, 0.0]);
}

/// So many regions are burned by so many electrodes at most. The same files were judged by an independent program: boolean
/// volumes, dexel closings.
fn has_electrodes(name: &str, step: Option<f64>, [regions, most]: [usize; 2], gaps: &[f64]) {
    let mesh = mold(name);
    let left = left(&mesh, MIXED, step);
    assert_eq!(left.regions.len(), regions, "{name}");
    let residue = left.found().volume_mm3;
    for &gap in gaps {
        let set = designed(&mesh, &left, gap);
        assert!(set.holds(), "{name}, gap {gap}: {:?}", set.checks);
        assert!(set.electrodes.len() <= most, "{name}: {} electrodes", set.electrodes.len());
        let burned: std::collections::BTreeSet<usize> =
            set.electrodes.iter().flat_map(|e| &e.burns).flat_map(|b| b.parts.iter().map(|p| p.region)).collect();
        assert_eq!(burned.len(), regions, "{name}: every region is burned");
        let volume: f64 = set.regions.iter().map(|r| r.left.volume).sum();
        let thickest = set.regions.iter().map(|r| r.left.thickness).fold(0.0, f64::max);
        assert!(thickest <= (3f64.sqrt() - 1.0) * gap + 0.02, "{name}, gap {gap}: {thickest}");
        assert!(gap > 0.0 || volume < 1e-3 * residue, "{name}: {volume} of {residue}");
    }
}

/// Three blocks that stand on a pocketed base, and share faces and edges with it and with each other: the corner between two
/// of them has an electrode as if they were one solid.
#[test]
fn corners_between_touching_solids_are_burned() {
    let block = |low: [f64; 3], high: [f64; 3]| {
        let (low, high) = (DVec3::from(low), DVec3::from(high));
        Mesh::cuboid(high - low).mapped(|p| p + low)
    };
    let pocket = block([5.0, 5.0, 6.0], [20.0, 20.0, 11.0]);
    let base = difference(&block([0.0; 3], [50.0, 40.0, 10.0]), &pocket).unwrap();
    let blocks = [
        block([22.0, 2.0, 10.0], [24.0, 38.0, 16.0]),
        block([24.0, 10.0, 10.0], [40.0, 12.0, 16.0]),
        block([24.0, 12.0, 10.0], [26.0, 30.0, 18.0]),
    ];
    let mesh = blocks.into_iter().fold(base, |mut all, block| {
        let first = all.vertices.len() as u32;
        all.vertices.extend(block.vertices);
        all.triangles.extend(block.triangles.iter().map(|t| t.map(|v| v + first)));
        all
    });
    let left = left(&mesh, "flat:1,flat:2,flat:5,ball:1,ball:3", None);
    let set = designed(&mesh, &left, 0.05);
    assert_eq!(left.regions.len(), 7);
    assert!(set.holds() && set.without_electrode().is_empty(), "{:?}", set.checks);
}

#[test]
fn openings_through_the_block_are_burned_through_its_underside() {
    // A slot that no cutter enters, and a window with sharp corners.
    for (hole, regions) in [([9.0, 1.2], 1), ([9.0, 6.0], 4)] {
        let mesh = frame(&rectangle(20.0, 16.0), &rectangle(hole[0], hole[1]), 8.0);
        for cutters in ["flat:1", "flat:1,ball:1"] {
            let left = left(&mesh, cutters, None);
            let set = designed(&mesh, &left, 0.05);
            assert!(set.holds() && left.regions.len() == regions, "{hole:?} {cutters}: {:?}", set.checks);
            let burns = set.electrodes.iter().flat_map(|e| e.burns.iter().map(move |burn| (e, burn)));
            let lowest = |(e, burn): (&Electrode, &Burn)| e.burning(&e.tips, burn, &DMat3::IDENTITY).bounds().min.z;
            let lowest: Vec<f64> = burns.map(lowest).collect();
            assert_eq!(lowest.len(), regions);
            assert!(lowest.iter().all(|z| *z < mesh.bounds().min.z), "{lowest:?}");
        }
    }
}

#[test]
fn electrodes_are_the_same_on_any_number_of_threads() {
    let mesh = mold("a_square.stl");
    let left = left(&mesh, "flat:2", Some(0.1));
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let set = pool.install(|| designed(&mesh, &left, 0.05));
        let meshes: Vec<String> = set.electrodes.iter().map(|e| e.mesh.digest()).collect();
        format!(
            "{meshes:?} {:?} {:?} {:?}",
            set.checks,
            set.regions,
            set.electrodes.iter().map(|e| &e.burns).collect::<Vec<_>>()
        )
    };
    assert_eq!(on(1), on(3));
}
