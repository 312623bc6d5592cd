use std::f64::consts::FRAC_PI_4;

use super::*;
use crate::workspaces::mold::job::uncut::{UncutParams, uncut};
use mold::cutter::{Cutter, CutterLibrary};
use mold::fixtures::{pocket, rectangle};

const STEP: f64 = 0.04;
const DEPTH: f64 = 3.0;
/// Plan area that a flat cutter of radius 1 leaves in a right-angled corner (mm^2).
const CORNER: f64 = 1.0 - FRAC_PI_4;

/// A block with a pocket of 8 x 4 x 3 mm.
fn mold() -> Mesh {
    let sides = rectangle(8.0, 4.0);
    pocket(&rectangle(12.0, 8.0), &sides, &sides, [6.0, DEPTH])
}

fn answer(mesh: &Mesh, cutters: &[Cutter], step: f64) -> Uncut {
    let library = CutterLibrary { cutter: cutters.to_vec() };
    let params = UncutParams { grid_step_mm: Some(step), tolerance_mm: 0.05, ..UncutParams::of(library) };
    uncut(mesh, &params, &Task::default()).unwrap()
}

fn compared(now: &[Cutter], other: &[Cutter]) -> Comparison {
    let mesh = mold();
    let [now, other] = [now, other].map(|cutters| answer(&mesh, cutters, STEP));
    compare(&mesh, &now, &other, &Task::default()).unwrap()
}

fn is_close(found: f64, exact: f64, within: f64) -> bool {
    (found / exact - 1.0).abs() < within
}

#[test]
fn a_smaller_flat_cutter_takes_part_of_every_corner() {
    let found = compared(&[Cutter::flat(1.0)], &[Cutter::flat(0.5)]);
    let exact = CORNER * DEPTH;
    assert!(found.by_layers && found.regions == [4, 4] && found.new_regions == 0 && found.vanishing() == 0);
    assert!(is_close(found.volumes[0], 4.0 * exact, 1e-4) && is_close(found.volumes[1], exact, 1e-4), "{found:?}");
    assert!(found.remains.iter().all(|remains| is_close(*remains, 0.25 * exact, 0.1)), "{:?}", found.remains);
    assert!(found.taken.len() == 4 && found.added.is_empty(), "{found:?}");
    let mut of: Vec<_> = found.taken.iter().map(|d| d.region.unwrap()).collect();
    of.sort_unstable();
    assert_eq!(of, [0, 1, 2, 3]);
    for taken in &found.taken {
        assert!(is_close(taken.volume, 0.75 * exact, 0.06), "{taken:?}");
        assert!(is_close(taken.plan_area, 0.75 * CORNER, 0.06), "{taken:?}");
        assert!((taken.depth - DEPTH).abs() < 1e-4 && (taken.thickness - DEPTH).abs() < 1e-3, "{taken:?}");
    }
    assert!(found.sentence().contains("By height map, step 0.0400 mm: in 4 places"), "{}", found.sentence());
}

#[test]
fn a_rounded_cutter_that_cuts_nothing_more_changes_nothing() {
    // At no height is it as narrow as the flat one. By layers and by heights the same residue has two volumes, whose
    // difference would be no answer.
    let found = compared(&[Cutter::flat(1.0)], &[Cutter::flat(1.0), Cutter::bull_nose(1.5, 0.3)]);
    assert!(!found.by_layers && found.regions == [4, 4]);
    assert_eq!(found.volumes[0], found.volumes[1]);
    assert!(is_close(found.volumes[0], 4.0 * CORNER * DEPTH, 0.03), "{found:?}");
    assert!(found.taken.is_empty() && found.added.is_empty() && found.vanishing() == 0 && found.new_regions == 0);
    assert!(found.remains.iter().all(|remains| is_close(*remains, CORNER * DEPTH, 1e-3)), "{:?}", found.remains);
    assert!(found.sentence().contains("They differ nowhere"), "{}", found.sentence());
}

#[test]
fn a_ball_takes_the_corners_but_for_their_feet() {
    let (now, both) = ([Cutter::flat(1.0)], [Cutter::flat(1.0), Cutter::ball(0.5)]);
    let found = compared(&now, &both);
    // Above its radius the ball leaves as much of the corner as a flat cutter of that radius.
    let above = 0.75 * CORNER * (DEPTH - 0.5);
    assert!(!found.by_layers && found.taken.len() == 4 && found.added.is_empty() && found.vanishing() == 0);
    for taken in &found.taken {
        assert!((0.97 * above..0.75 * CORNER * DEPTH).contains(&taken.volume), "{taken:?} {above}");
    }
    // All that is taken is thick, so that it is what the volumes differ by.
    let sum: f64 = found.taken.iter().map(|d| d.volume).sum();
    assert!(is_close(sum, found.volumes[0] - found.volumes[1], 0.02), "{sum} {:?}", found.volumes);
    let back = compared(&both, &now);
    let figures = |all: &[Difference]| all.iter().map(|d| (d.volume, d.plan_area)).collect::<Vec<_>>();
    assert_eq!((figures(&back.added), back.taken.len()), (figures(&found.taken), 0));
    assert_eq!(back.volumes, [found.volumes[1], found.volumes[0]]);
}

#[test]
fn regions_vanish_are_new_or_merge() {
    // What the small one leaves is thinner than the tolerance.
    let (small, own, wide) = ([Cutter::flat(0.1)], [Cutter::flat(1.0)], [Cutter::flat(2.5)]);
    let gone = compared(&own, &small);
    assert!(gone.vanishing() == 4 && gone.vanishes(3) && gone.taken.len() == 4 && gone.volumes[1] == 0.0, "{gone:?}");
    assert!(gone.sentence().contains("; 4 regions vanish. By height map"), "{}", gone.sentence());
    let new = compared(&small, &own);
    assert!(new.new_regions == 4 && new.added.len() == 4 && new.added.iter().all(|d| d.region.is_none()), "{new:?}");
    assert!(new.sentence().contains("more than 0.000 mm³") && new.sentence().contains("4 regions are new"));
    // A cutter wider than the pocket leaves it whole: one region, where four were before.
    let whole = compared(&own, &wide);
    assert_eq!((whole.regions, whole.vanishing(), whole.new_regions), ([4, 1], 0, 0));
    assert!(whole.remains.iter().all(|remains| is_close(*remains, CORNER * DEPTH, 1e-3)), "{:?}", whole.remains);
    // And back: of one region four small parts remain.
    let back = compared(&wide, &own);
    assert!(back.regions == [1, 4] && back.vanishing() == 0 && back.new_regions == 0, "{back:?}");
    assert!(is_close(back.remains[0], 4.0 * CORNER * DEPTH, 0.03), "{back:?}");
    let left: f64 = whole.added.iter().map(|d| d.volume).sum();
    assert!(whole.taken.is_empty() && is_close(left, (32.0 - 4.0 * CORNER) * DEPTH, 0.01), "{left}");
}

#[test]
fn libraries_of_different_grids_are_compared_on_one() {
    let mesh = mold();
    let (now, other) = (answer(&mesh, &[Cutter::ball(1.0)], 0.1), answer(&mesh, &[Cutter::ball(0.5)], STEP));
    assert!((common_step(&now, &other) - 0.1).abs() < 1e-12 && common_step(&now, &now) == 0.1);
    let found = compare(&mesh, &now, &other, &Task::default()).unwrap();
    assert_eq!(found.step, 0.1);
    // Fillets along the edges of the floor, of a quarter of the area.
    assert!(found.volumes[0] > 3.0 * found.volumes[1] && found.taken.len() == 1, "{found:?}");
    let sum = found.taken[0].volume;
    assert!(is_close(sum, found.volumes[0] - found.volumes[1], 0.05), "{sum} {:?}", found.volumes);
    assert!((found.remains[0] / found.volumes[1] - 1.0).abs() < 0.15, "{found:?}");
}
