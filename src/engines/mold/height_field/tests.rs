//! Closed forms, laws, and the definition itself on small fields.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};

use glam::{DVec2, DVec3};
use proptest::prelude::*;

use super::*;
use crate::cutter::{Cutter, CutterKind, CutterLibrary};
use crate::fixtures::{frame, rectangle, with};
use geometry::mesh::Mesh;
use task::Cancel;

const STEP: f64 = 0.025;
/// Plan area that a flat cutter of radius 1 leaves in a right-angled corner.
const CORNER: f64 = 1.0 - FRAC_PI_4;

fn raster(mesh: &Mesh, step: f64) -> HeightField {
    HeightField::raster(mesh, step, &Cancel::default()).unwrap()
}

fn left_by(field: &HeightField, cutters: &[Cutter]) -> Closing {
    closing(field, &CutterLibrary { cutter: cutters.to_vec() }, &Cancel::default()).unwrap()
}

fn regions_of(field: &HeightField, cutters: &[Cutter]) -> Vec<FieldRegion> {
    regions(field, &left_by(field, cutters), 0.02, &Cancel::default()).unwrap()
}

/// The upward faces of a block with a pocket that reaches `half` from its middle along x and y, turned in plan (rad).
fn pocket(half: [f64; 2], depth: f64, turn: f64) -> Mesh {
    let mut mesh = Mesh::default();
    let half = DVec2::from_array(half);
    for (size, z) in [(half, 0.0), (half, -depth), (half + 1.5, 0.0)] {
        for [x, y] in [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]] {
            mesh.vertices.push(DVec2::from_angle(turn).rotate(DVec2::new(x, y) * size).extend(z));
        }
    }
    mesh.triangles.extend([[4, 5, 6], [4, 6, 7]]);
    for (i, j) in [(0, 1), (1, 2), (2, 3), (3, 0)] {
        mesh.triangles.extend([[i, 8 + i, 8 + j], [i, 8 + j, j]]);
    }
    mesh
}

/// The upward faces of a block with points `outline` (x, z) all along y from -2 to 2.
fn profile(outline: &[[f64; 2]]) -> Mesh {
    let vertices = outline.iter().flat_map(|&[x, z]| [-2.0, 2.0].map(|y| DVec3::new(x, y, z))).collect();
    let strips = (0..2 * (outline.len() as u32 - 1)).step_by(2);
    Mesh { vertices, triangles: strips.flat_map(|i| [[i, i + 2, i + 3], [i, i + 3, i + 1]]).collect() }
}

/// Area between what is left and the material in the plane y = 0 (mm^2).
fn section_left(field: &HeightField, closing: &Closing) -> f64 {
    let [columns, rows] = field.size();
    let row = rows / 2 * columns;
    (row..row + columns).map(|cell| closing.residue(field, cell) * field.step()).sum()
}

#[test]
fn heights_are_those_of_the_topmost_face_at_the_centres() {
    // A slanted roof over a floor, the roof seen from either side.
    let plane = |p: DVec2| 1.0 + 0.3 * p.x - 0.2 * p.y;
    let roof: Vec<DVec3> =
        [[0.0, 0.0], [3.0, 0.4], [2.1, 2.9]].map(|[x, y]| DVec2::new(x, y)).map(|p| p.extend(plane(p))).to_vec();
    let floor = [[0.0, 0.0], [3.0, 0.0], [3.0, 3.0], [0.0, 3.0]].map(|[x, y]| DVec3::new(x, y, -2.0));
    let vertices = [roof, floor.to_vec()].concat();
    for first in [[0, 1, 2], [0, 2, 1]] {
        let field = raster(&Mesh { vertices: vertices.clone(), triangles: vec![first, [3, 4, 5], [3, 5, 6]] }, 0.07);
        assert_eq!(field.size(), [43, 43]);
        let mut covered = 0;
        for cell in 0..43 * 43 {
            let (at, height) = (field.center(cell), field.height(cell).filter(|_| cell % 43 < 42 && cell < 42 * 43));
            let Some(height) = height else { continue };
            let is_roof = (height - plane(at)).abs() < 1e-5;
            assert!(is_roof || (height + 2.0).abs() < 1e-6, "{at}: {height}");
            covered += usize::from(is_roof);
        }
        // The roof's plan area is half of |(3, 0.4) x (2.1, 2.9)|.
        assert!((covered as f64 * 0.07 * 0.07 - 0.5 * (3.0 * 2.9 - 0.4 * 2.1)).abs() < 0.05);
    }
}

#[test]
fn no_cell_falls_between_triangles() {
    // A fan of slivers whose edges run through centres of cells in many places.
    let rim = (0..=97).map(|i| DVec2::from_angle(std::f64::consts::TAU * f64::from(i) / 97.0).extend(0.0) * 2.0);
    let vertices = std::iter::once(DVec3::ZERO).chain(rim).collect();
    let field = raster(&Mesh { vertices, triangles: (1..=97).map(|i| [0, i, i + 1]).collect() }, 0.01);
    let [columns, rows] = field.size();
    let inside = (0..columns * rows).filter(|&cell| field.center(cell).length() < 1.99);
    assert!(inside.into_iter().all(|cell| field.height(cell) == Some(0.0)));
}

#[test]
fn what_cannot_be_a_grid_is_refused_in_words() {
    let (block, cancel) = (Mesh::cuboid(DVec3::new(80.0, 110.0, 5.0)), Cancel::default());
    let fine = HeightField::raster(&block, 0.001, &cancel).unwrap_err();
    let HeightFieldError::TooManyCells { coarser, .. } = fine else { panic!("{fine}") };
    assert!(fine.to_string().contains("8800 million"), "{fine}");
    assert!((coarser - (8800.0f64 / 64.0).sqrt() * 0.001).abs() < 1e-4);
    for step in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(HeightField::raster(&block, step, &cancel), Err(HeightFieldError::BadStep(_))));
    }
    let wall = Mesh { vertices: vec![DVec3::ZERO, DVec3::X, DVec3::Z], triangles: vec![[0, 1, 2]] };
    for nothing in [Mesh::default(), wall, block.mapped(|p| p * f64::NAN)] {
        assert_eq!(HeightField::raster(&nothing, 0.1, &cancel), Err(HeightFieldError::NoMaterial));
    }
    let coarse = raster(&block, 0.025);
    let huge = CutterLibrary { cutter: vec![Cutter::flat(150.0)] };
    assert!(matches!(closing(&coarse, &huge, &cancel), Err(HeightFieldError::TooManyCells { .. })));
    assert!(matches!(closing(&coarse, &CutterLibrary::default(), &cancel), Err(HeightFieldError::Cutter(_))));
    let other = left_by(&raster(&block, 1.0), &[Cutter::flat(1.0)]);
    let found = 80 * 110;
    assert_eq!(
        regions(&coarse, &other, 0.02, &cancel),
        Err(HeightFieldError::OtherGrid { expected: 3200 * 4400, found })
    );
    assert_eq!((other.nearest(found), other.residue(&coarse, found)), (None, 0.0));
    cancel.cancel();
    let told = Err(HeightFieldError::Cancelled(Cancelled));
    assert_eq!(HeightField::raster(&block, 1.0, &cancel), told);
    assert_eq!(closing(&raster(&block, 1.0), &huge, &cancel).map(|_| ()), Err(HeightFieldError::Cancelled(Cancelled)));
}

#[test]
fn a_flat_cutter_leaves_the_corners_of_a_pocket() {
    for (turn, within) in [(0.0, 0.005), (30f64.to_radians(), 0.03)] {
        let field = raster(&pocket([2.5; 2], 2.0, turn), STEP);
        let found = regions_of(&field, &[Cutter::ball(2.0), Cutter::flat(1.0)][1..]);
        assert_eq!(found.len(), 4);
        let total = |f: fn(&FieldRegion) -> f64| found.iter().map(f).sum::<f64>();
        let (area, volume) = (total(|r| r.plan_area), total(|r| r.volume));
        assert!((area / (4.0 * CORNER) - 1.0).abs() < within, "{area}");
        assert!((volume / (8.0 * CORNER) - 1.0).abs() < within, "{volume}");
        for region in &found {
            assert!((region.depth - 2.0).abs() < 1e-6 && (region.normal_depth - 2.0).abs() < 1e-4);
            assert!((region.bounds.min.z + 2.0).abs() < 1e-6 && region.bounds.max.z.abs() < 1e-6);
            // The tangent ends are a cutter's radius from the corner.
            let corner = DVec2::from_angle(turn).rotate(DVec2::splat(2.5));
            let far = region.bounds.center().truncate().length();
            assert!((corner.length() - 1.0..corner.length() + 0.1).contains(&far), "{far}");
        }
        assert!(found.windows(2).all(|w| w[0].volume >= w[1].volume));
    }
}

#[test]
fn a_slot_narrower_than_the_cutter_is_left_whole() {
    let slot = |width: f64| raster(&pocket([0.5 * width, 2.0], 3.0, 0.0), STEP);
    let found = regions_of(&slot(1.9), &[Cutter::flat(1.0)]);
    assert_eq!(found.len(), 1);
    assert!((found[0].plan_area - 1.9 * 4.0).abs() < 1e-9 && (found[0].volume - 1.9 * 12.0).abs() < 1e-4);
    // One that is wide enough keeps its corners.
    assert_eq!(regions_of(&slot(2.2), &[Cutter::flat(1.0)]).len(), 4);
}

#[test]
fn grooves_and_floors_keep_what_their_closed_forms_say() {
    for degrees in [30.0f64, 45.0, 60.0] {
        let (half, cot) = (degrees.to_radians(), 1.0 / degrees.to_radians().tan());
        let wide = 4.0 * half.tan();
        // The bottom lies between two columns of cells, where a tip can stand.
        let edge = wide.ceil() + 1.0;
        let field = raster(&profile(&[[-edge, 0.0], [-wide, 0.0], [0.0, -4.0], [wide, 0.0], [edge, 0.0]]), STEP);
        // A ball of radius 1 touches both flanks; a flat one hangs between them.
        let by_ball = section_left(&field, &left_by(&field, &[Cutter::ball(1.0)]));
        assert!((by_ball / (cot - (FRAC_PI_2 - half)) - 1.0).abs() < 0.03, "{degrees}: {by_ball}");
        let by_flat = section_left(&field, &left_by(&field, &[Cutter::flat(1.0)]));
        assert!((by_flat / cot - 1.0).abs() < 0.03, "{degrees}: {by_flat}");
    }
    // A ball leaves a fillet along each wall; a bull-nose one of its corner.
    let field = raster(&profile(&[[-4.0, 0.0], [-2.5, 0.0], [-2.5, -3.0], [2.5, -3.0], [2.5, 0.0], [4.0, 0.0]]), STEP);
    for (cutter, corner) in [(Cutter::ball(1.0), 1.0), (Cutter::bull_nose(1.5, 0.5), 0.5)] {
        let left = section_left(&field, &left_by(&field, &[cutter]));
        assert!((left / (2.0 * CORNER * corner * corner) - 1.0).abs() < 0.03, "{corner}: {left}");
    }
}

#[test]
fn a_larger_cutter_leaves_no_less_and_another_one_no_more() {
    let field = raster(&pocket([2.5; 2], 2.0, 0.0), 0.05);
    let cells = field.size()[0] * field.size()[1];
    let residues = |closing: &Closing| (0..cells).map(|i| closing.residue(&field, i)).collect::<Vec<_>>();
    let of_flat = [0.5, 1.0, 1.5, 2.0].map(|r| residues(&left_by(&field, &[Cutter::flat(r)])));
    for pair in of_flat.windows(2) {
        assert!(pair[0].iter().zip(&pair[1]).all(|(small, large)| *small <= large + 1e-6));
        assert!(pair[0].iter().sum::<f64>() < pair[1].iter().sum());
    }
    let cutters = [Cutter::flat(2.0), Cutter::ball(0.5), Cutter::bull_nose(1.5, 0.5)];
    let alone = cutters.clone().map(|cutter| residues(&left_by(&field, &[cutter])));
    let together = left_by(&field, &cutters);
    for (cell, left) in residues(&together).into_iter().enumerate() {
        let least = alone.iter().map(|r| r[cell]).fold(f64::INFINITY, f64::min);
        assert!((left - least).abs() < 3e-5, "cell {cell}: {left} and {least}");
        assert!((alone[together.nearest(cell).unwrap()][cell] - least).abs() < 3e-5);
    }
}

#[test]
fn a_holder_keeps_the_tip_up() {
    let field = raster(&pocket([2.5; 2], 3.0, 0.0), 0.05);
    let middle = field.size()[0] / 2 * (field.size()[0] + 1);
    let cutter =
        |holder: f64| Cutter { reach_mm: Some(2.0), holder_diameter_mm: Some(2.0 * holder), ..Cutter::flat(1.0) };
    // One wider than the pocket always passes over the block, and the tip stays 1 mm above the floor.
    let wide = left_by(&field, &[cutter(3.0)]);
    let floor = (0..field.size()[0] * field.size()[1]).filter(|&i| field.height(i) == Some(-3.0));
    assert!(floor.into_iter().all(|i| wide.residue(&field, i) > 1.0 - 1e-5));
    assert!((wide.residue(&field, middle) - 1.0).abs() < 1e-5);
    // One as wide as the cutter touches nothing that the cutter does not.
    assert_eq!(left_by(&field, &[cutter(1.0)]).heights, left_by(&field, &[Cutter::flat(1.0)]).heights);
    // One of 2 mm reaches the floor within 0.5 mm of the middle, and the cutter 1 mm further.
    let some = left_by(&field, &[cutter(2.0)]);
    let at = |x: f64| some.residue(&field, middle + (x / 0.05).round() as usize);
    assert!(at(0.0) == 0.0 && at(1.4) == 0.0 && (at(1.6) - 1.0).abs() < 1e-5);
}

#[test]
fn pieces_join_where_they_touch_and_overlap_in_height() {
    // Squares of four cells: two that meet at a corner at the same height, one beside them far below, and a hair.
    let (columns, rows) = (16, 12);
    let mut field = of_heights(columns, vec![0.0; columns * rows]);
    let mut left = left_by(&field, &[Cutter::flat(0.01)]);
    let mut square = |x: usize, y: usize, wide: usize, low: f32| {
        for cell in (y..y + 4).flat_map(|row| (x..x + wide).map(move |column| row * columns + column)) {
            (field.heights[cell], left.heights[cell]) = (low, low + 1.0);
        }
    };
    square(0, 0, 4, 0.0);
    square(4, 4, 4, 0.5);
    square(8, 4, 4, -3.0);
    square(14, 0, 1, 0.0);
    let found = regions(&field, &left, 0.02, &Cancel::default()).unwrap();
    assert_eq!(found.iter().map(|r| r.cells.len()).collect::<Vec<_>>(), [32, 16]);
    assert_eq!((found[0].bounds.min, found[0].bounds.max), (DVec3::ZERO, DVec3::new(0.8, 0.8, 1.5)));
    assert!((found[1].volume - 0.16).abs() < 1e-9 && (found[1].bounds.max.z + 2.0).abs() < 1e-6);
}

#[test]
fn corners_of_an_opening_through_the_block_are_left_down_to_its_underside() {
    let mesh = frame(&rectangle(14.0, 14.0), &rectangle(8.0, 6.0), 5.0);
    let field = raster(&mesh, STEP);
    // A ball goes on below the underside until it is through, so that it leaves what a flat cutter leaves.
    for cutters in [&[Cutter::flat(1.0)][..], &[Cutter::ball(1.0)], &[Cutter::flat(2.0), Cutter::ball(1.0)]] {
        let found = regions_of(&field, cutters);
        assert_eq!(found.len(), 4, "{cutters:?}");
        for region in found {
            assert!((region.volume / (CORNER * 5.0) - 1.0).abs() < 0.05, "{cutters:?}: {}", region.volume);
            assert!((region.bounds.min.z - mesh.bounds().min.z).abs() < 1e-5);
        }
    }
    // A slot that the ball does not enter keeps all but what it takes where it sinks between the edges.
    let mesh = frame(&rectangle(14.0, 14.0), &rectangle(8.0, 1.0), 5.0);
    let slot = regions_of(&raster(&mesh, STEP), &[Cutter::ball(1.0)]);
    let taken = 0.5f64.asin() - 0.5 * 0.75f64.sqrt();
    assert_eq!(slot.len(), 1);
    assert!((slot[0].volume / (8.0 * (5.0 - taken)) - 1.0).abs() < 0.005, "{}", slot[0].volume);
}

#[test]
fn a_closer_look_finds_what_the_whole_finds_there() {
    let mesh = frame(&rectangle(14.0, 14.0), &rectangle(8.0, 6.0), 5.0);
    let library = CutterLibrary { cutter: vec![Cutter::flat(1.0)] };
    // All that a cutter touches which reaches the corner of the opening at (4, 3).
    let plan = [DVec2::new(0.5, -0.5), DVec2::new(6.5, 5.5)];
    let corner = [DVec2::new(2.8, 1.8), DVec2::new(4.2, 3.2)];
    let field = raster(&mesh, 4.0 * STEP).closer(&mesh, plan, STEP, &Cancel::default()).unwrap();
    let left = closing_within(&field, &library, corner, &Cancel::default()).unwrap();
    let found = regions(&field, &left, 0.02, &Cancel::default()).unwrap();
    assert_eq!(found.len(), 1);
    assert!((found[0].volume / (CORNER * 5.0) - 1.0).abs() < 0.05, "{}", found[0].volume);
    let whole = closing(&field, &library, &Cancel::default()).unwrap();
    for cell in 0..field.heights.len() {
        let place = field.center(cell);
        let is_asked = place.cmpge(corner[0]).all() && place.cmple(corner[1]).all();
        let there = if is_asked { whole.residue(&field, cell) } else { 0.0 };
        assert_eq!(left.residue(&field, cell), there, "{place}");
    }
}

#[test]
fn beside_the_block_there_is_air_down_to_the_underside() {
    // Two blocks beside each other: what is between them is not enclosed.
    let block = Mesh::cuboid(DVec3::new(2.0, 6.0, 3.0));
    let both = with(&block.mapped(|p| p - DVec3::X * 1.5), &block.mapped(|p| p + DVec3::X * 1.5));
    assert!(regions_of(&raster(&both, STEP), &[Cutter::flat(1.0)]).is_empty());
}

#[test]
fn any_number_of_threads_finds_the_same() {
    let mesh = pocket([2.5; 2], 2.0, 0.4);
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let field = raster(&mesh, 0.05);
            let left = left_by(&field, &[Cutter::flat(1.0), Cutter::ball(0.5)]);
            let found = regions(&field, &left, 0.02, &Cancel::default()).unwrap();
            (field, left, found)
        })
    };
    assert!(on(1) == on(3));
}

/// A field with a step of 0.1 mm and these heights, all faces horizontal.
fn of_heights(columns: usize, heights: Vec<f32>) -> HeightField {
    let rows = heights.len() / columns;
    let upness = vec![u16::MAX; heights.len()];
    HeightField { corner: DVec2::ZERO, step: 0.1, columns, rows, base: 0.0, heights, upness, through: Vec::new() }
}

/// Residual stock of a cutter by definition: every tip over every cell, every cell under every tip.
fn by_definition(field: &HeightField, cutter: &Cutter) -> Vec<f64> {
    let cells_across = (cutter.diameter_mm / field.step).round();
    let between = cells_across > 2.0 && cells_across % 2.0 == 0.0;
    let trim = if cutter.kind() == CutterKind::Flat { 0.25 } else { 0.15 };
    let reach = (cutter.radius() / field.step - trim).max(0.5 * cells_across - 0.5) * field.step + 1e-7;
    let room = (cutter.radius() / field.step) as isize + 2;
    let middle = |i: isize| (i as f64 + 0.5) * field.step;
    let tip_at = |i: isize| middle(i) - if between { 0.5 * field.step } else { 0.0 };
    let (columns, rows) = (field.columns as isize, field.rows as isize);
    let plan = |columns: isize, rows: isize| {
        (-room..rows + room).flat_map(move |y| (-room..columns + room).map(move |x| [x, y]))
    };
    let cells: Vec<(DVec2, f64)> = (0..field.heights.len())
        .map(|i| (DVec2::new(middle(i as isize % columns), middle(i as isize / columns)), f64::from(field.heights[i])))
        .collect();
    let tips: Vec<(DVec2, f64)> = plan(columns, rows)
        .map(|[x, y]| {
            let tip = DVec2::new(tip_at(x), tip_at(y));
            let down = cells.iter().filter(|(at, _)| at.distance(tip) <= reach);
            let mut height = down
                .map(|(at, h)| h - cutter.height(at.distance(tip).min(cutter.radius())).unwrap())
                .fold(f64::NEG_INFINITY, f64::max);
            if let Some((radius, reach)) = cutter.holder() {
                let under = cells.iter().filter(|(at, _)| at.distance(tip) <= radius + 1e-7);
                height = under.map(|(_, h)| h - reach).fold(height, f64::max);
            }
            (tip, height)
        })
        .collect();
    let over = |at: DVec2| {
        let above = tips.iter().filter(move |(tip, _)| tip.distance(at) <= cutter.radius() + 1e-7);
        above
            .map(|(tip, h)| h + cutter.height(tip.distance(at).min(cutter.radius())).unwrap())
            .fold(f64::INFINITY, f64::min)
    };
    cells.iter().map(|&(at, h)| if h.is_finite() { over(at).max(h) } else { h }).collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(40))]
    #[test]
    fn the_sweeps_give_what_the_definition_says(
        columns in 1usize..34,
        levels in proptest::collection::vec(0u8..5, 1..300),
        noise in 0.0f32..0.4,
        radius in 0.03f64..1.2,
        corner in 0.0f64..1.0,
        shape in 0..3,
        holder in proptest::option::of((0.1f64..2.0, 0.0f64..0.8)),
    ) {
        let rows = levels.len().div_ceil(columns);
        // Plateaus of several cells, some without material, with some noise on them.
        let height = |i: usize| match levels[(i / columns / 3 * 7 + i % columns / 4) % levels.len()] {
            0 => f32::NEG_INFINITY,
            level => f32::from(level) + noise * f32::from(levels[i % levels.len()]),
        };
        let field = of_heights(columns, (0..columns * rows).map(height).collect());
        let mut cutter = match shape {
            0 => Cutter::flat(radius),
            1 => Cutter::ball(radius),
            _ => Cutter::bull_nose(radius, corner * radius),
        };
        if let Some((reach, wider)) = holder {
            cutter.reach_mm = Some(reach);
            cutter.holder_diameter_mm = Some(cutter.diameter_mm + 2.0 * wider);
        }
        let found = left_by(&field, std::slice::from_ref(&cutter));
        for (cell, (&found, truth)) in found.heights.iter().zip(by_definition(&field, &cutter)).enumerate() {
            prop_assert!(f64::from(found) == truth || (f64::from(found) - truth).abs() < 2e-5, "{cell}: {found} {truth}");
        }
    }
}

#[test]
fn tiles_meet_without_a_seam() {
    // A field larger than a tile either way is that of its transposed, whose tiles lie elsewhere.
    let (columns, rows) = (190, 150);
    let height = |x: usize, y: usize| (((y / 9 * 31 + x / 13) as u32).wrapping_mul(2_654_435_761) >> 29) as f32;
    let field = of_heights(columns, (0..columns * rows).map(|i| height(i % columns, i / columns)).collect());
    let turned = of_heights(rows, (0..columns * rows).map(|i| height(i / rows, i % rows)).collect());
    for cutter in [Cutter::flat(0.7), Cutter::ball(1.1), Cutter::bull_nose(0.65, 0.3)] {
        let cutter = Cutter { reach_mm: Some(3.0), holder_diameter_mm: Some(4.0), ..cutter };
        let [found, other] = [&field, &turned].map(|f| left_by(f, std::slice::from_ref(&cutter)).heights);
        let same = |i: usize| (found[i] - other[i % columns * rows + i / columns]).abs() < 2e-5;
        assert!((0..columns * rows).all(same), "{cutter:?}");
    }
}

/// A wall thinner than a cell keeps what is beside it apart, however it lies; a ridge of gentle slopes is none.
#[test]
fn walls_thinner_than_a_cell_are_kept() {
    let cancel = Cancel::default();
    for degrees in [0.0f64, 90.0, 20.0, 45.0, 77.0] {
        let turn = DVec2::from_angle(degrees.to_radians());
        // Two slots of 1 mm in a block with 0.01 mm between them.
        let slot = |y: f64| [[-4.0, y], [-4.0, y + 1.0], [4.0, y + 1.0], [4.0, y]].map(DVec2::from).to_vec();
        let block = rectangle(12.0, 8.0);
        let [a, b] = [slot(-1.006), slot(0.004)];
        let rings: Vec<&[DVec2]> = vec![&block, &a, &b];
        let mesh = geometry::solid::prism(&rings, 0.0, 3.0).unwrap();
        let floor = Mesh::cuboid(DVec3::new(12.0, 8.0, 1.0)).mapped(|p| p - DVec3::new(6.0, 4.0, 0.5));
        let mesh = with(&mesh, &floor).mapped(|p| turn.rotate(p.truncate()).extend(p.z));
        let field = HeightField::raster(&mesh, 0.05, &cancel).unwrap();
        let left = closing(&field, &CutterLibrary { cutter: vec![Cutter::flat(0.8)] }, &cancel).unwrap();
        let found = regions(&field, &left, 0.02, &cancel).unwrap();
        let volume: f64 = found.iter().map(|r| r.volume).sum();
        assert!((volume / 40.0 - 1.0).abs() < 0.08, "{degrees}: {volume} in {}", found.len());
    }
}
