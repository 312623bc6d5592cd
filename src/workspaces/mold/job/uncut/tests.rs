use std::f64::consts::{FRAC_PI_4, PI};

use glam::{DVec2, DVec3};

use super::*;
use crate::workspaces::mold::report::uncut::{CadFaceReport, UncutPage, UncutReport, surface_as_ply};
use geometry::mesh::unit_normal;
use geometry::segmentation::{CadFaces, Face, KnownFace, Segmentation, SegmentationSettings};
use geometry::solid::prism;
use mold::fixtures::{dish, pocket, polygon, rectangle};

fn answer(mesh: &Mesh, cutters: Vec<Cutter>) -> Result<Uncut, UncutError> {
    let params = UncutParams::of(CutterLibrary { cutter: cutters });
    uncut(mesh, &params, &Task::default())
}

#[test]
fn nothing_is_left_of_a_plain_block() {
    let mesh = Mesh::cuboid(DVec3::new(10.0, 8.0, 3.0));
    let left = answer(&mesh, vec![Cutter::flat(1.0), Cutter::ball(1.0)]).unwrap();
    assert_eq!(left.found(), Found::default());
    assert!(left.is_whole() && !left.is_of_flats());
    assert_eq!(left.agreement, Some([Found::default(); 2]));
}

#[test]
fn a_pocket_keeps_its_corners_with_the_walls_and_the_floor_beside_them() {
    let sides = rectangle(12.0, 9.0);
    let mesh = pocket(&rectangle(20.0, 20.0), &sides, &sides, [10.0, 8.0]);
    let corner = 1.0 - FRAC_PI_4;
    let by_flat = answer(&mesh, vec![Cutter::flat(1.0)]).unwrap();
    assert!(by_flat.is_of_flats());
    let by_both = answer(&mesh, vec![Cutter::flat(1.0), Cutter::ball(2.0)]).unwrap();
    for (left, share) in [(&by_flat, 1e-3), (&by_both, 0.03)] {
        assert_eq!(left.regions.len(), 4);
        for region in &left.regions {
            assert!((region.volume - 8.0 * corner).abs() < share * 8.0 * corner, "{region:?}");
            assert!((region.plan_area - corner).abs() < 0.05 * corner, "{region:?}");
            assert!((region.depth - 8.0).abs() < 0.01, "{region:?}");
            // Two walls, and the floor by one triangle or both.
            assert!((3..=6).contains(&region.faces.len()), "{region:?}");
            assert!((1.5 * 8.0..=2.0 * 8.0 + 2.0 * corner).contains(&region.surface_area), "{region:?}");
            assert!(region.nearest_cutter.is_some_and(|k| k < left.params.library.cutter.len()));
        }
        let layer = left.layers.iter().find(|l| (5.0..7.0).contains(&l.z)).unwrap();
        assert!((layer.area - 4.0 * corner).abs() < share.max(0.01) * 4.0 * corner, "{layer:?}");
        assert!((5.0..=8.001).contains(&layer.segment_length), "{layer:?}");
        let drawn: f64 =
            left.segments(layer.z).iter().flat_map(|run| run.windows(2)).map(|w| w[0].distance(w[1])).sum();
        assert!((drawn - layer.segment_length).abs() < 1e-9);
    }
    let middle = by_flat.layers.iter().find(|l| (5.0..7.0).contains(&l.z)).unwrap();
    // A radius is taken for smaller by what the file's precision can make of a width.
    assert!((middle.segment_length - 8.0).abs() < 8.0 * 2e-5, "two radii at each corner: {middle:?}");
}

#[test]
fn the_report_names_the_cad_faces_that_bound_a_region() {
    let sides = rectangle(12.0, 9.0);
    let mesh = pocket(&rectangle(20.0, 20.0), &sides, &sides, [10.0, 8.0]);
    let found = Segmentation::of(&mesh, &SegmentationSettings::default());
    let named = |(i, face): (usize, &Face)| KnownFace { name: format!("N{i}"), ..KnownFace::of(face.kind) };
    let faces = CadFaces { faces: found.faces.iter().enumerate().map(named).collect(), face_of: found.face_of };
    let report = UncutReport::of(&answer(&mesh, vec![Cutter::flat(1.0)]).unwrap(), Some(&faces));
    assert_eq!(report.regions.len(), 4);
    for region in &report.regions {
        // Two walls over a radius of the cutter each, 8 mm high, but for a cell or two of the grid, and the floor in the corner.
        let areas: Vec<f64> = region.cad_faces.iter().map(|face| face.area_mm2).collect();
        let [first, second, floor] = areas[..] else { panic!("{region:?}") };
        assert!([first, second].iter().all(|wall| (6.0..=8.5).contains(wall)) && floor < 0.5, "{areas:?}");
        assert!((areas.iter().sum::<f64>() - region.surface_area_mm2).abs() < 1e-6);
        let named = |face: &CadFaceReport| face.face == format!("plane, \u{201c}N{}\u{201d}", face.number - 1);
        assert!(region.cad_faces.iter().all(named), "{region:?}");
    }
    let text = report.text(&[]);
    assert_eq!(text.matches("     on face ").count(), 12, "{text}");
    let page = report.html(&[], &UncutPage::default()).unwrap();
    assert!(page.contains("CAD faces that bound them"), "{page}");
    let without = UncutReport { regions: Vec::new(), ..report }.html(&[], &UncutPage::default()).unwrap();
    assert!(!without.contains("CAD faces"));
}

#[test]
fn corners_too_thin_for_the_grid_are_left_all_the_same() {
    // Twelve corners of 150 degrees: R (1 / cos 15 degrees - 1) = 0.035 mm deep.
    let round = polygon(12, 8.0);
    let mesh = pocket(&polygon(12, 12.0), &round, &round, [10.0, 6.0]);
    for step in [None, Some(0.5)] {
        let params =
            UncutParams { grid_step_mm: step, ..UncutParams::of(CutterLibrary { cutter: vec![Cutter::flat(1.0)] }) };
        let left = uncut(&mesh, &params, &Task::default()).unwrap();
        assert_eq!(left.regions.len(), 12, "{step:?}");
        let (half, deep) = (15f64.to_radians(), 1.0 / 15f64.to_radians().cos() - 1.0);
        for region in &left.regions {
            // Where the grid sees a corner it looks up along the walls.
            assert!(region.thickness > 0.999 * deep, "{region:?}");
            assert!((region.volume - 6.0 * (half.tan() - half)).abs() < 1e-4, "{region:?}");
            assert!(region.plan_area > 0.0, "{region:?}");
        }
        let is_coarse = left.stack.warnings.iter().any(|w| matches!(w, MoldWarning::CoarseGrid { .. }));
        assert_eq!(is_coarse, step.is_some());
    }
    // A larger ball reaches them no better: they are slivers that every cutter leaves.
    let both = answer(&mesh, vec![Cutter::flat(1.0), Cutter::ball(2.0)]).unwrap();
    let left = both.stack.warnings.iter().find_map(|w| match w {
        MoldWarning::SliversLeft { regions, thickness, place } => Some((*regions, *thickness, DVec3::from(*place))),
        _ => None,
    });
    let (regions, thickness, place) = left.unwrap();
    assert!((regions, both.unknown_regions(), both.is_whole()) == (12, 0, false), "{:?}", both.stack.warnings);
    assert!((thickness - 0.0353).abs() < 0.008, "{thickness}");
    assert!((place.truncate().length() - 8.0 / 15f64.to_radians().cos()).abs() < 0.3, "{place}");
    let sentence = UncutReport::of(&both, None).sentence;
    assert!(sentence.ends_with("slivers too thin for regions are left in 12 places."), "{sentence}");
    // What is not known is no answer.
    let thin = MoldWarning::ThinRegions { regions: 12, thickness: 0.03 };
    let mut unsure = both.clone();
    unsure.stack.warnings = vec![thin];
    let sentence = UncutReport::of(&unsure, None).sentence;
    assert!(!unsure.is_whole() && unsure.is_sound(), "{sentence}");
    assert!(sentence.ends_with("whether they take 12 thin regions more is not known."), "{sentence}");
}

#[test]
fn a_shallow_valley_that_only_a_flat_cutter_leaves_is_no_sliver() {
    // A flat cutter of 1 mm radius stands 0.035 mm above the bottom of a valley that rises by 2 degrees on both sides; a
    // ball goes down to 0.0006 mm.
    let rise = 10.0 * 2f64.to_radians().tan();
    let across = [(-10.0, 0.0), (10.0, 0.0), (10.0, 5.0 + rise), (0.0, 5.0), (-10.0, 5.0 + rise)];
    let across: Vec<DVec2> = across.into_iter().map(DVec2::from).collect();
    let mesh = prism(&[&across], 0.0, 12.0).unwrap().mapped(|p| DVec3::new(p.z, p.x, p.y));
    let flat = answer(&mesh, vec![Cutter::flat(1.0)]).unwrap();
    assert!((flat.regions.len() == 1) && (0.02..0.04).contains(&flat.regions[0].thickness), "{:?}", flat.regions);
    let both = answer(&mesh, vec![Cutter::flat(1.0), Cutter::ball(1.0)]).unwrap();
    assert!(both.is_whole() && both.regions.is_empty(), "{:?} {:?}", both.stack.warnings, both.regions);
}

#[test]
fn what_balls_leave_is_found_twice() {
    let sides = rectangle(12.0, 9.0);
    let mesh = pocket(&rectangle(20.0, 20.0), &sides, &sides, [10.0, 4.0]);
    let left = answer(&mesh, vec![Cutter::ball(1.0)]).unwrap();
    let agreement = left.ball_agreement.unwrap();
    assert!(agreement.places > 300, "{agreement:?}");
    // Over the fillet along the walls; a cell at the wall's foot may take the wall for half a cell off.
    assert!(agreement.median_mm < 0.2 * left.grid_step, "{agreement:?}");
    assert!(agreement.ninetieth_mm < 2.0 * left.grid_step, "{agreement:?}");
}

#[test]
fn what_cannot_be_asked_is_answered_in_words() {
    let mesh = Mesh::cuboid(DVec3::new(10.0, 8.0, 3.0));
    let refused = |mesh: &Mesh, cutters| answer(mesh, cutters).unwrap_err().to_string();
    assert!(refused(&mesh, Vec::new()).contains("no cutter"));
    let coarse =
        UncutParams { grid_step_mm: Some(0.6), ..UncutParams::of(CutterLibrary { cutter: vec![Cutter::flat(1.0)] }) };
    assert!(coarse.validate().unwrap_err().to_string().contains("give at most 0.5 mm"));
    assert!(refused(&mesh, vec![Cutter::flat(-1.0)]).contains("diameter_mm is -2: must"));
    assert!(refused(&Mesh::default(), vec![Cutter::flat(1.0)]).contains("nothing to cut"));
}

/// The mold turned in plan by 20 degrees.
fn askew(mesh: &Mesh) -> Mesh {
    mesh.mapped(|p| DVec2::from_angle(20f64.to_radians()).rotate(p.truncate()).extend(p.z))
}

fn surface_area(left: &Uncut) -> f64 {
    left.surface.iter().map(SurfacePiece::area).sum()
}

#[test]
fn a_slot_askew_to_the_grid_is_left_whole_by_what_is_wider() {
    let slot = rectangle(10.0, 1.9);
    let mesh = askew(&pocket(&rectangle(14.0, 6.0), &slot, &slot, [9.0, 6.0]));
    let (floor, around) = (10.0 * 1.9, 2.0 * (10.0 + 1.9));
    for (cutters, within) in
        [(vec![Cutter::flat(1.0)], 1e-6), (vec![Cutter::flat(1.0), Cutter::bull_nose(1.5, 0.5)], 0.01)]
    {
        let left = answer(&mesh, cutters).unwrap();
        assert_eq!(left.regions.len(), 1);
        assert!((left.found().volume_mm3 / (6.0 * floor) - 1.0).abs() < within, "{:?}", left.found());
        assert!((left.regions[0].plan_area / floor - 1.0).abs() < within, "{:?}", left.regions[0].plan_area);
        // Floor and walls, each of which ends within two cells of where it should.
        let (area, exact) = (surface_area(&left), floor + 6.0 * around);
        assert!((area - exact).abs() < 2.0 * left.grid_step * 2.0 * around, "{area} {exact}");
        assert!((left.regions[0].surface_area - area).abs() < 1e-9 * area);
    }
}

#[test]
fn a_ball_leaves_the_same_askew_to_the_grid() {
    let sides = rectangle(8.0, 4.0);
    let mesh = askew(&pocket(&rectangle(11.0, 7.0), &sides, &sides, [6.0, 4.0]));
    let left = answer(&mesh, vec![Cutter::ball(1.0)]).unwrap();
    // Fillets along the straight edges of the floor, columns in the corners above them, and what an eighth of the ball
    // leaves of a cube in each corner between.
    let exact = (1.0 - FRAC_PI_4) * (2.0 * (6.0 + 2.0) + 4.0 * 3.0) + 4.0 * (1.0 - PI / 6.0);
    let Found { regions, volume_mm3 } = left.found();
    assert!(regions == 1 && (volume_mm3 / exact - 1.0).abs() < 0.03, "{volume_mm3} {exact}");
    // What is said of the error is about as large as the error is.
    let grid = UncutReport::of(&left, None).grid.unwrap();
    assert!(grid.coarser.regions == 1 && grid.coarser_step_mm == 2.0 * left.grid_step);
    let (off, said) = ((volume_mm3 - exact).abs(), grid.off_mm3);
    assert!(off < 3.0 * said && said < 0.05 * exact, "{off} {said}");
    assert!(UncutReport::of(&left, None).text(&[]).contains("Estimated error of the volume"));
    assert!(answer(&mesh, vec![Cutter::flat(1.0)]).unwrap().coarser.is_none());
}

#[test]
fn what_an_overhang_covers_is_neither_left_nor_cut() {
    // Under its mouth the pocket is wider: a ceiling looks down on the part of the floor that it covers.
    let (mouth, wide) = (rectangle(6.0, 4.0), rectangle(8.0, 6.0));
    let levels = [(mouth.clone(), 10.0), (mouth, 8.0), (wide.clone(), 8.0), (wide, 4.0)];
    let mesh = dish(&rectangle(12.0, 10.0), &levels, 4.0);
    let corner = 1.0 - FRAC_PI_4;
    for (cutters, within) in [(vec![Cutter::flat(1.0)], 1e-4), (vec![Cutter::flat(1.0), Cutter::ball(1.5)], 0.03)] {
        let left = answer(&mesh, cutters).unwrap();
        assert!((left.stack.invert.area - (8.0 * 6.0 - 6.0 * 4.0)).abs() < 1e-9, "{}", left.stack.invert.area);
        // From the rim of the mouth down to the floor, as though the mouth's walls went all the way.
        assert_eq!(left.regions.len(), 4);
        for region in &left.regions {
            assert!((region.volume / (6.0 * corner) - 1.0).abs() < within, "{}", region.volume);
            assert!((region.plan_area / corner - 1.0).abs() < 0.05, "{}", region.plan_area);
        }
        // The surface under it: the floor within the mouth, and the mouth's own walls. The wide walls are in the
        // shadow.
        let upness = |p: &SurfacePiece| unit_normal(mesh.corners(p.face as usize)).z;
        for piece in &left.surface {
            let out = piece.corners.map(|p| (p.x.abs() - 3.0).max(p.y.abs() - 2.0)).into_iter().fold(-3.0, f64::max);
            assert!(out < 3.0 * left.grid_step && upness(piece) > -1e-9, "{piece:?}");
        }
        let floor: f64 = left.surface.iter().filter(|p| upness(p) > 0.5).map(SurfacePiece::area).sum();
        assert!((floor / (4.0 * corner) - 1.0).abs() < 0.1, "{floor}");
        // Beside a wall the cutter's circle comes within the tolerance before it touches.
        let walls = surface_area(&left) - floor;
        assert!((0.75..=1.0).contains(&(walls / (4.0 * 2.0 * 2.0))), "{walls}");
    }
}

#[test]
fn any_number_of_threads_answers_with_the_same_bytes() {
    let sides = rectangle(8.0, 6.0);
    let tapered = rectangle(7.0, 5.0);
    let mesh = askew(&pocket(&rectangle(11.0, 9.0), &sides, &tapered, [6.0, 4.0]));
    for cutters in [vec![Cutter::flat(1.0)], vec![Cutter::flat(1.0), Cutter::ball(1.0), Cutter::bull_nose(1.5, 0.5)]] {
        let on = |threads: usize| {
            let params =
                UncutParams { grid_step_mm: Some(0.05), ..UncutParams::of(CutterLibrary { cutter: cutters.clone() }) };
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| uncut(&mesh, &params, &Task::default()).unwrap())
        };
        let (alone, together) = (on(1), on(3));
        assert!(!alone.regions.is_empty() && !alone.surface.is_empty());
        assert!(alone.stack == together.stack && alone.layers == together.layers);
        assert!(alone.regions == together.regions && alone.surface == together.surface);
        let bytes = |left: &Uncut| {
            let json = serde_json::to_string(&UncutReport::of(left, None)).unwrap();
            (json, surface_as_ply(&left.surface, left.params.opening), format!("{:?}", left.regions))
        };
        assert!(bytes(&alone) == bytes(&together));
    }
}

#[test]
fn volumes_that_differ_by_much_are_warned_of_in_plain_words() {
    let told = |found: [Option<[f64; 2]>; 2]| uncertain(found, Some(DVec3::new(1.0, 2.0, 3.0)), 1.0);
    assert_eq!(told([None; 2]), None);
    assert_eq!(told([Some([100.0, 95.0]), Some([10.0, 9.5])]), None);
    assert_eq!(told([Some([1.0, 0.3]), None]), None, "less than a cutter of 1 mm fills");
    let warning = told([Some([95.0, 100.0]), Some([149.0, 87.0])]).unwrap().to_string();
    for text in ["between 87.000 and 149.000 mm^3", "x = 1.000, y = 2.000, z = 3.000"] {
        assert!(warning.contains(text), "{warning}");
    }
    for word in ["layer", "boolean", "offset", "solid"] {
        assert!(!warning.contains(word), "{warning}");
    }
}

/// In a square hole as wide as the cutter no place of the tip on a grid askew to it may fit.
#[test]
fn a_hole_as_wide_as_the_cutter_keeps_its_corners_with_all_kinds_of_cutters() {
    let hole = rectangle(2.0, 2.0);
    let mesh = askew(&pocket(&rectangle(10.0, 10.0), &hole, &hole, [8.0, 5.0])).mapped(|p| p.as_vec3().as_dvec3());
    let corners = 4.0 * (1.0 - FRAC_PI_4) * 5.0;
    for (cutters, share) in [(vec![Cutter::flat(1.0)], 1e-3), (vec![Cutter::flat(1.0), Cutter::ball(1.0)], 0.1)] {
        let left = answer(&mesh, cutters).unwrap();
        let Found { volume_mm3, .. } = left.found();
        assert!((volume_mm3 / corners - 1.0).abs() < share, "{volume_mm3} {corners}");
        assert!(left.regions.iter().all(|region| region.surface_area > 0.0), "{:?}", left.regions);
        let is_uncertain = |w: &MoldWarning| matches!(w, MoldWarning::Uncertain { .. });
        assert!(!left.stack.warnings.iter().any(is_uncertain), "{:?}", left.stack.warnings);
    }
}
