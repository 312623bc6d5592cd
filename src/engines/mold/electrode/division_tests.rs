//! Division of heads along slanted faces, and of those that cutters cannot mill as one.

use glam::{DVec2, DVec3};

use super::cut::Cut;
use super::cuts::Undivided;
use super::design::{ElectrodeSet, PartNode};
use super::division::enlarged;
use super::finding::{CheckKind, Finding};
use super::h_edge::{HEdge, Milling, h_edges, inner_edges};
use super::params::{DividedAt, Edit, ElectrodeParams};
use super::tests::{GAP, cutters, mold, params, planned, region};
use crate::cutter::{Cutter, CutterLibrary};
use crate::fixtures::rectangle;
use crate::outline::Outline;
use crate::plane;
use geometry::mesh::Mesh;
use geometry::solid::{difference, hull};

/// What the groove of a drafted pocket is cut along, in degrees.
const DRAFT_DEG: f64 = 2.0;

fn tree(set: &ElectrodeSet) -> &PartNode {
    set.regions[0].tree.as_ref().unwrap()
}

fn leaves(node: &PartNode) -> usize {
    if node.parts.is_empty() { 1 } else { node.parts.iter().map(leaves).sum() }
}

/// Outlines of a part in plan.
fn outlines(node: &PartNode) -> Vec<Outline> {
    node.outlines.iter().filter_map(|points| Outline::new(points.clone())).collect()
}

/// A pocket on a draft, with a round groove through one of its walls that ends halfway down.
fn pocket_with_groove() -> Mesh {
    let at = |side: f64, z: f64| rectangle(7.0, side).into_iter().map(move |p| p.extend(z));
    let wider = |z: f64| 2.0 + 2.0 * (z + 6.0) * DRAFT_DEG.to_radians().tan();
    let pocket: Vec<DVec3> = at(wider(-6.0), -6.0).chain(at(wider(1.0), 1.0)).collect();
    let angle = |i: usize| -std::f64::consts::PI * i as f64 / 12.0;
    let ground = (0..=12).map(|i| DVec2::from_angle(angle(i)) * 2.0).map(|p| (p.x, p.y - 0.5));
    let profile: Vec<(f64, f64)> = ground.chain([(2.0, 1.0), (-2.0, 1.0)]).collect();
    let groove: Vec<DVec3> =
        [0.0, 4.0].iter().flat_map(|y| profile.iter().map(|(x, z)| DVec3::new(*x, *y, *z))).collect();
    let block = mold([20.0, 20.0, 12.0], &[]);
    [hull(&pocket), hull(&groove)].iter().fold(block, |block, cavity| difference(&block, cavity).unwrap())
}

#[test]
fn a_head_is_divided_along_a_wall_on_a_draft_and_both_parts_are_milled() {
    let mold = pocket_with_groove();
    let all = region(&mold, DVec2::new(-4.1, -2.0), DVec2::new(4.1, 4.1));
    let set = planned(&mold, &[all], &params(GAP));
    assert!(set.holds(), "{:?} {:?}", set.checks, set.regions[0].reason);
    assert_eq!(leaves(tree(&set)), 2, "{:?}", tree(&set));
    let cut = tree(&set).cut.unwrap();
    assert!((cut.slope().to_degrees() - DRAFT_DEG).abs() < 0.01 && cut.outward().distance(DVec2::Y) < 1e-6, "{cut:?}");
}

/// A deep round hole of 24 sides, and a rectangular pocket on a draft that is not as deep, whose corners reach out of it.
fn hole_with_corners() -> Mesh {
    const LOW: f64 = -5.17;
    let sides = |z: f64| DVec2::new(2.368, 2.79) + 2.0 * (z - LOW) * 1.4_f64.to_radians().tan();
    let turn = DVec2::from_angle(41.7_f64.to_radians());
    let level = |z: f64| rectangle(sides(z).x, sides(z).y).into_iter().map(move |p| turn.rotate(p).extend(z));
    let pocket: Vec<DVec3> = level(LOW).chain(level(1.0)).collect();
    let round = (0..24).map(|i| DVec2::from_angle((11.1 + 15.0 * f64::from(i)).to_radians()) * 1.671);
    let hole: Vec<DVec3> = round.flat_map(|p| [p.extend(LOW - 0.5), p.extend(1.0)]).collect();
    let block = mold([14.0, 14.0, 9.0], &[]);
    [hull(&pocket), hull(&hole)].iter().fold(block, |block, cavity| difference(&block, cavity).unwrap())
}

/// The walls on a draft end above the tips of the corners' heads. What is cut off along a wall is cut off down to the tip,
/// and nothing of the wall's own face with it.
#[test]
fn a_cut_along_a_wall_that_ends_halfway_down_leaves_no_ledge_and_the_whole_wall() {
    let mold = hole_with_corners();
    let corners = [1.0, -1.0].map(|side| DVec2::new(-1.81, 0.25) * side);
    let regions = corners.map(|at| region(&mold, at - 0.55, at + 0.55));
    let set = planned(&mold, &regions, &params(GAP));
    let is_slanted = |node: &PartNode| node.cut.is_some_and(|cut| cut.slope() > 0.0);
    assert!(is_slanted(tree(&set)), "{:?}", tree(&set));
    assert!(set.holds(), "{:?} {:?}", set.checks, set.regions[0].reason);
}

#[test]
fn a_division_by_hand_along_the_wall_is_the_one_that_is_found_there() {
    let mold = pocket_with_groove();
    let all = [region(&mold, DVec2::new(-4.1, -2.0), DVec2::new(4.1, 4.1))];
    let found = planned(&mold, &all, &params(GAP));
    let by_hand = |edits: Vec<Edit>| {
        planned(&mold, &all, &ElectrodeParams { divided_at: DividedAt::Nothing, edits, ..params(GAP) })
    };
    // On the wall below the groove.
    let wall = |z: f64| DVec3::new(0.0, 1.0 + (z + 6.0) * DRAFT_DEG.to_radians().tan(), z);
    let set = by_hand(vec![Edit::SplitAlong { place: wall(-4.0) }]);
    assert_eq!((leaves(tree(&set)), set.unmet_edits()), (2, vec![]), "{:?}", tree(&set));
    let [cut, other] = [&set, &found].map(|set| tree(set).cut.unwrap());
    assert!((cut.slope().to_degrees() - DRAFT_DEG).abs() < 0.01 && cut.outward().distance(DVec2::Y) < 1e-6, "{cut:?}");
    assert!((cut.low - other.low).abs() < 1e-3 && cut.beyond(other.through).abs() < 0.015, "{cut:?} {other:?}");
    // The near parts are the same. The far ones differ at most by what reaches back over the cut, which is as wide as
    // the groove.
    let areas = |set: &ElectrodeSet| {
        let area = |node: &PartNode| plane::area(&outlines(node));
        [0, 1].map(|i| area(&tree(set).parts[i]))
    };
    let ([near, far], [near_found, far_found]) = (areas(&set), areas(&found));
    assert!((near - near_found).abs() < 0.02, "{near} {near_found}");
    assert!((far - far_found).abs() < 0.5 * 4.2, "{far} {far_found}");
    // The floor is not steep, and nothing is beyond the wall opposite.
    for place in [DVec3::new(2.0, 0.0, -6.0), -wall(-4.0).with_z(4.0)] {
        let set = by_hand(vec![Edit::SplitAlong { place }]);
        assert_eq!((leaves(tree(&set)), set.unmet_edits()), (1, vec![0]), "{place}");
    }
}

#[test]
fn prongs_between_which_no_cutter_passes_are_heads_of_their_own() {
    let slot = |x: f64| rectangle(0.8, 6.0).iter().map(|p| *p + DVec2::X * x).collect::<Vec<_>>();
    let mold = mold([20.0, 20.0, 10.0], &[(&slot(-0.45), 4.0), (&slot(0.45), 4.0)]);
    let both = region(&mold, DVec2::new(-1.0, -3.1), DVec2::new(1.0, 3.1));
    let apart = ElectrodeParams { share: false, together_mm: 0.0, ..params(GAP) };
    let set = planned(&mold, &[both], &apart);
    assert!(set.holds(), "{:?}", set.checks);
    assert_eq!(leaves(tree(&set)), 2, "{:?}", tree(&set));
}

/// Beyond the mold's ends the head of a groove that is open there goes on in the air, wider than in it. A part of it
/// alone would burn nothing.
#[test]
fn a_groove_that_is_open_at_its_ends_has_no_head_in_the_air_beside_the_mold() {
    let at = |x: f64| [(-3.0, 0.01), (3.0, 0.01), (0.0, -6.0)].map(|(y, z)| DVec3::new(x, y, z));
    let block = mold([20.0, 20.0, 12.0], &[]);
    let mold = difference(&block, &hull([at(-11.0), at(11.0)].as_flattened())).unwrap();
    // Cutters leave its ground, up to where they fit in.
    let mut ground = region(&mold, DVec2::new(-9.9999, -1.0), DVec2::new(9.9999, 1.0));
    ground.rim = ground.corners.iter().flatten().map(|p| p.z).fold(f64::NEG_INFINITY, f64::max);
    for divided_at in [DividedAt::HEdges, DividedAt::EveryEdge] {
        let set = planned(&mold, &[ground.clone()], &ElectrodeParams { divided_at, ..params(GAP) });
        assert!(set.holds(), "{:?} {:?}", set.checks, set.regions[0].reason);
        for node in tree(&set).nodes().into_iter().filter(|node| node.part.is_some()) {
            let [low, high] = plane::extent(&outlines(node));
            assert!(low.x < 9.5 && high.x > -9.5, "{divided_at:?}: a head from x = {} to {}", low.x, high.x);
        }
    }
}

/// A cut a hair before the end of a groove that is open there: the part beyond it burns what the other one does as well.
#[test]
fn a_part_that_burns_nothing_of_its_own_is_no_head() {
    let slot = rectangle(8.0, 0.8);
    let mold = mold([6.0, 6.0, 10.0], &[(&slot, 2.0)]);
    let all = [region(&mold, DVec2::new(-2.9999, -0.5), DVec2::new(2.9999, 0.5))];
    let cut_at = |x: f64| {
        let line = [-1.0, 1.0].map(|y| DVec3::new(x, y, 0.0));
        let set = planned(&mold, &all, &ElectrodeParams { edits: vec![Edit::Split { line }], ..params(GAP) });
        assert!(set.holds(), "{:?} {:?}", set.checks, set.regions[0].reason);
        leaves(tree(&set))
    };
    assert_eq!(cut_at(2.96), 1);
}

/// Grooves that cross have four inner edges at each crossing, and a cut along a wall takes away a quarter of them.
#[test]
fn grooves_that_cross_again_and_again_are_divided_at_all_crossings() {
    let groove = |off: f64, turn: f64| -> Vec<DVec2> {
        let turn = DVec2::from_angle(turn.to_radians());
        rectangle(5.0, 0.8).into_iter().map(|p| turn.rotate(p + DVec2::Y * off)).collect()
    };
    let grooves = [(-1.3, 20.0), (1.3, 20.0), (-1.3, 110.0), (1.3, 110.0)].map(|(off, turn)| groove(off, turn));
    let hollows: Vec<(&[DVec2], f64)> = grooves.iter().map(|outline| (&outline[..], 2.0)).collect();
    let mold = mold([12.0, 12.0, 10.0], &hollows);
    let all = region(&mold, DVec2::splat(-4.0), DVec2::splat(4.0));
    let set = planned(&mold, &[all], &params(GAP));
    assert!(set.holds(), "{:?} {:?}", set.checks, set.regions[0].reason);
    assert!(leaves(tree(&set)) >= 4, "{:?}", tree(&set));
}

/// What a head loses below an enlarged face goes on beyond the ends of the edge, so that the head touches nothing there.
#[test]
fn what_is_taken_away_below_an_enlarged_face_is_longer_than_its_edge() {
    let lean = DVec3::new(-0.05, 0.0, -0.05).normalize();
    for turn in [0.0f64, 12.0, 61.0] {
        let turned = |p: DVec3| DVec2::from_angle(turn.to_radians()).rotate(p.truncate()).extend(p.z);
        let normals = [turned(DVec3::new(1.0, 0.0, -0.05).normalize()), turned(lean)];
        let edge = HEdge { ends: [DVec3::new(1.0, -2.0, 0.0), DVec3::new(1.0, 2.0, -1.0)].map(turned), normals };
        let cut = Cut { through: edge.ends[0], normal: normals[0], low: f64::NEG_INFINITY, overlaps: true };
        let bodies = enlarged(&[&edge], &cut, 0.2, -5.0);
        let along = (edge.ends[1] - edge.ends[0]).normalize();
        let [from, to] = edge.ends.map(|p| p.dot(along));
        let on: Vec<f64> = bodies[0].iter().take(2).map(|p| p.dot(along)).collect();
        assert!(
            on[0] < from - 5e-5 && on[1] > to + 5e-5 && on[1] - on[0] < to - from + 1e-3,
            "{turn}: {on:?} {from} {to}"
        );
    }
}

#[test]
fn an_edge_that_a_ball_mills_within_the_tolerance_is_no_h_edge() {
    // A ball of radius r leaves r (1 / cos(a / 2) - 1) in an edge of turn a: 0.0121 mm of 0.5 in 25 degrees.
    let valley = |degrees: f64| {
        let deep = (0.5 * degrees).to_radians().tan();
        let groove = [(-1.0, 0.0), (0.0, -deep), (1.0, 0.0)].map(|(x, z)| [-3.0, 3.0].map(|y| DVec3::new(x, y, z)));
        let open = groove.as_flattened().iter().flat_map(|p| [*p, p.with_z(1.0)]).filter(|p| p.x != 0.0 || p.z < 0.0);
        difference(&mold([4.0, 4.0, 4.0], &[]), &hull(&open.collect::<Vec<_>>())).unwrap()
    };
    let found = |tip: &Mesh| h_edges(&inner_edges(tip), DividedAt::HEdges, &Milling::by(&cutters(), 0.02)).len();
    assert_eq!((found(&valley(25.0)), found(&valley(40.0))), (0, 1));
    // On a floor a flat end mills any edge that runs level and straight.
    let step =
        [(0.0, -1.0), (3.0, -1.0), (0.0, 1.0), (3.0, 1.0)].map(|(x, z)| [-3.0, 3.0].map(|y| DVec3::new(x, y, z)));
    let step = difference(&mold([4.0, 4.0, 4.0], &[]), &hull(step.as_flattened())).unwrap();
    assert_eq!(found(&step), 0);
}

/// A pocket of 2 x 2 mm whose floor rises to a bump in the middle, in facets of a fifth of a millimetre: its head has a pit
/// with inner edges all around.
fn pocket_with_bump() -> Mesh {
    const STEPS: u32 = 10;
    let at = |i: u32, j: u32| {
        let [x, y] = [i, j].map(|k| 2.0 * f64::from(k) / f64::from(STEPS) - 1.0);
        DVec3::new(x, y, -3.0 + 0.8 * (-4.0 * (x * x + y * y)).exp())
    };
    let number = |i: u32, j: u32| i * (STEPS + 1) + j;
    let count = (STEPS + 1).pow(2);
    let mut vertices: Vec<DVec3> = (0..=STEPS).flat_map(|i| (0..=STEPS).map(move |j| at(i, j))).collect();
    vertices.extend(vertices.clone().iter().map(|p| p.with_z(1.0)));
    let mut triangles = Vec::new();
    for (i, j) in (0..STEPS).flat_map(|i| (0..STEPS).map(move |j| (i, j))) {
        let [a, b, c, d] = [number(i, j), number(i + 1, j), number(i + 1, j + 1), number(i, j + 1)];
        triangles.extend([[a, c, b], [a, d, c], [a + count, b + count, c + count], [a + count, c + count, d + count]]);
    }
    for k in 0..STEPS {
        let ends =
            [[(k, 0), (k + 1, 0)], [(STEPS, k), (STEPS, k + 1)], [(k + 1, STEPS), (k, STEPS)], [(0, k + 1), (0, k)]];
        let sides = ends.map(|side| side.map(|(i, j)| number(i, j)));
        triangles.extend(sides.iter().flat_map(|[a, b]| [[*a, *b, b + count], [*a, b + count, a + count]]));
    }
    difference(&mold([12.0, 12.0, 8.0], &[]), &Mesh { vertices, triangles }).unwrap()
}

/// In a quarter of the pit every cut along an edge would make a head that is too narrow, or leaves as much: a cut across
/// what is left opens it.
#[test]
fn a_pit_whose_edges_do_not_help_is_cut_across() {
    let mold = pocket_with_bump();
    let all = region(&mold, DVec2::splat(-1.05), DVec2::splat(1.05));
    let large = CutterLibrary { cutter: vec![Cutter::flat(1.0), Cutter::ball(1.0)] };
    let set = planned(&mold, &[all], &ElectrodeParams { cutters: Some(large), ..params(GAP) });
    let milled = |findings: &Vec<Finding>| {
        let mut milling = findings.iter().filter(|f| f.kind == CheckKind::Machinable).peekable();
        milling.peek().is_some() && milling.all(|f| f.holds)
    };
    assert!(leaves(tree(&set)) > 4 && set.checks.iter().all(milled), "{:?}", set.checks);
}

#[test]
fn a_head_that_stays_undivided_says_why_and_what_helps() {
    let said = |tried, thin, less| Undivided { tried, thin, less, least: 0.3 }.to_string();
    assert_eq!(said(0, 0, 0), "it was not divided further: divide it there");
    let all_thin = said(8, 8, 0);
    assert!(all_thin.contains("of 8 cuts") && all_thin.contains("8 would make a head narrower than"), "{all_thin}");
    assert!(all_thin.contains("smaller least size"), "{all_thin}");
    let mixed = said(8, 3, 1);
    assert!(mixed.contains("1 would lead to heads") && mixed.contains("4 would leave as much"), "{mixed}");
    assert!(!said(1, 0, 0).contains("least size") && said(1, 0, 0).contains("of 1 cut tried"), "{}", said(1, 0, 0));
    let both = Undivided { tried: 8, thin: 3, less: 1, least: 0.3 };
    let both = both.and(Undivided { tried: 4, thin: 4, less: 0, least: 0.3 });
    assert_eq!((both.tried, both.thin, both.less), (12, 7, 1));
}
