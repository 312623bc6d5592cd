//! Electrodes of molds whose answer is known, and electrodes broken on purpose.

use std::f64::consts::{FRAC_PI_2, PI};

use files::Validate;
use glam::{DVec2, DVec3};

use super::base::{on_plate, placed};
use super::check::{machinable, watertight};
use super::clearance::Obstacle;
use super::combine::{Form, near};
use super::design::{Electrode, ElectrodeSet};
use super::finding::{CheckKind, Finding};
use super::footprint::{grown, hull, shrunk};
use super::given::GivenName;
use super::h_edge::{Milling, h_edges, inner_edges, place};
use super::params::{DividedAt, Edit, ElectrodeParams, Method, Orbit, Shape, Stage};
use super::plan::plan;
use super::residual_stock::Milled;
use super::residual_stock::{Burns, Looked, left_by, residual_stock};
use super::setting::{ElectrodeError, RegionToBurn};
use crate::cutter::{Cutter, CutterLibrary};
use crate::fixtures::rectangle;
use crate::outline::Outline;
use crate::plane;
use geometry::mesh::Mesh;
use geometry::solid::{difference, prism};
use task::{Cancel, Task};

pub(super) const GAP: f64 = 0.05;

/// A block up to height 0 less prisms.
pub(super) fn mold(size: [f64; 3], hollows: &[(&[DVec2], f64)]) -> Mesh {
    let block = prism(&[&rectangle(size[0], size[1])], -size[2], 0.0).unwrap();
    let less = |mesh: Mesh, (outline, depth): &(&[DVec2], f64)| {
        difference(&mesh, &prism(&[outline], -depth, 1.0).unwrap()).unwrap()
    };
    hollows.iter().fold(block, less)
}

pub(super) fn ring(points: &[(f64, f64)]) -> Vec<DVec2> {
    points.iter().copied().map(DVec2::from).collect()
}

pub(super) fn cutters() -> CutterLibrary {
    CutterLibrary { cutter: vec![Cutter::flat(1.0), Cutter::ball(0.5)] }
}

/// All of the surface of a mold below height 0 within a box in plan, as a region that no cutter touched.
pub(super) fn region(mold: &Mesh, low: DVec2, high: DVec2) -> RegionToBurn {
    let inside = |c: &[DVec3; 3]| {
        let middle = (c[0] + c[1] + c[2]) / 3.0;
        let plan = middle.truncate();
        middle.z < -1e-9 && middle.z > -9.0 && plan.cmpge(low).all() && plan.cmple(high).all()
    };
    // Split, so that no triangle reaches far out of the box.
    let mut corners: Vec<[DVec3; 3]> = mold.iter_corners().collect();
    for _ in 0..10 {
        corners = corners.into_iter().flat_map(halved).collect();
    }
    corners.retain(inside);
    let depths = corners.iter().map(|c| -(c[0].z + c[1].z + c[2].z) / 3.0).collect();
    RegionToBurn { corners, depths, rim: 0.0, volume: 1.0, thickness: 3.0, has_whole_faces: false, is_through: false }
}

/// The triangle cut across its longest side, if that is longer than 0.2 mm.
fn halved([a, b, c]: [DVec3; 3]) -> Vec<[DVec3; 3]> {
    let sides = [a.distance(b), b.distance(c), c.distance(a)];
    let longest = sides.iter().copied().fold(0.0, f64::max);
    let [a, b, c] = match sides.iter().position(|s| *s == longest) {
        Some(1) => [b, c, a],
        Some(2) => [c, a, b],
        _ => [a, b, c],
    };
    if longest < 0.2 { vec![[a, b, c]] } else { vec![[a, a.midpoint(b), c], [a.midpoint(b), b, c]] }
}

pub(super) fn params(gap: f64) -> ElectrodeParams {
    ElectrodeParams { stages: vec![Stage::finish(gap)], ..ElectrodeParams::default() }
}

pub(super) fn planned(mold: &Mesh, regions: &[RegionToBurn], params: &ElectrodeParams) -> ElectrodeSet {
    let everything = |_: DVec3, _: f64| true;
    let milled = Milled { leaves: &everything, within: 0.05 };
    plan(mold, regions, (&cutters(), &milled), params, &Task::default()).unwrap()
}

fn holds(findings: &[Finding], kind: CheckKind) -> bool {
    findings.iter().find(|f| f.kind == kind).unwrap_or_else(|| panic!("{kind:?} was not checked")).holds
}

#[test]
fn a_slot_gets_the_blade_that_fills_it_but_for_the_gap() {
    let mold = mold([30.0, 20.0, 10.0], &[(&rectangle(8.0, 0.8), 5.0)]);
    let slot = region(&mold, DVec2::new(-4.1, -0.5), DVec2::new(4.1, 0.5));
    let set = planned(&mold, std::slice::from_ref(&slot), &params(GAP));
    assert!(set.holds(), "{:?}", set.checks);
    let [electrode] = &set.electrodes[..] else { panic!("{}", set.electrodes.len()) };
    let burn = &electrode.burns[0];
    assert!(burn.position.truncate().length() < 1e-6 && burn.turn == 0.0);
    // Below the mold's top: the slot less the gap on four sides and on the floor.
    let below = rectangle(50.0, 50.0);
    let tip = electrode.burning(&electrode.mesh, burn, &glam::DMat3::IDENTITY);
    let in_slot = difference(&tip, &prism(&[&below], 0.0, 90.0).unwrap()).unwrap();
    let expected = (8.0 - 2.0 * GAP) * (0.8 - 2.0 * GAP) * (5.0 - GAP);
    assert!((in_slot.volume() - expected).abs() < 1e-4 * expected, "{} {expected}", in_slot.volume());
    assert!((burn.depth - (5.0 - GAP)).abs() < 1e-9, "{}", burn.depth);
    // The base clears the mold, and the blank holds all of it.
    let size = electrode.bounds().size();
    assert!(size.cmple(electrode.blank + 1e-9).all() && (size.z - electrode.blank.z).abs() < 1e-9, "{size}");
    // Where three faces meet.
    assert!(set.regions[0].left.thickness < (3f64.sqrt() - 1.0) * GAP + 1e-3, "{:?}", set.regions[0].left);
}

#[test]
fn a_net_electrode_fills_the_slot_and_leaves_nothing() {
    let mold = mold([30.0, 20.0, 10.0], &[(&rectangle(8.0, 0.8), 5.0)]);
    let slot = region(&mold, DVec2::new(-4.1, -0.5), DVec2::new(4.1, 0.5));
    let net = ElectrodeParams { shape: Shape::Net, ..params(GAP) };
    let set = planned(&mold, std::slice::from_ref(&slot), &net);
    assert!(set.holds() && (set.electrodes[0].burns[0].depth - 5.0).abs() < 1e-9, "{:?}", set.checks);
    assert!(set.regions[0].left.thickness > 1e-3, "what is left is told of the real electrode");
    let too_wide = planned(&mold, std::slice::from_ref(&slot), &ElectrodeParams { shape: Shape::Net, ..params(0.45) });
    assert!(!too_wide.holds(), "no electrode is left of it once the gap is taken off");
    let set = planned(&mold, std::slice::from_ref(&slot), &params(0.0));
    assert!(set.holds(), "{:?}", set.checks);
    assert!(set.regions[0].left.thickness < 1e-3, "{:?}", set.regions[0].left);
    assert!((set.electrodes[0].burns[0].depth - 5.0).abs() < 1e-9);
    let wide = params(0.45);
    let set = planned(&mold, &[slot], &wide);
    assert!(!set.holds() && set.electrodes.is_empty());
    assert!(set.regions[0].reason.as_ref().unwrap().contains("gap"), "{:?}", set.regions[0].reason);
}

#[test]
fn an_angle_of_slots_is_divided_at_its_inner_corner_and_nothing_is_left() {
    let angle = ring(&[(-5.0, -5.0), (5.0, -5.0), (5.0, -4.2), (-4.2, -4.2), (-4.2, 5.0), (-5.0, 5.0)]);
    let mold = mold([30.0, 30.0, 10.0], &[(&angle, 4.0)]);
    let all = region(&mold, DVec2::splat(-5.1), DVec2::splat(5.1));
    let set = planned(&mold, &[all], &params(GAP));
    let tree = set.regions[0].tree.as_ref().unwrap();
    assert_eq!((tree.h_edge_count(), tree.parts.len()), (1, 2), "{tree:?}");
    assert!(tree.parts.iter().all(|p| p.h_edges.is_empty() && p.parts.is_empty()));
    assert!(set.holds(), "{:?}", set.checks);
    let parts: usize = set.electrodes.iter().flat_map(|e| &e.burns).map(|b| b.parts.len()).sum();
    assert_eq!(parts, 2);
}

#[test]
fn congruent_corners_share_an_electrode_and_mirrored_ones_do_not() {
    let mold = mold([40.0, 40.0, 10.0], &[(&rectangle(20.0, 16.0), 5.0)]);
    let corner = |x: f64, y: f64| {
        let at = DVec2::new(10.0 * x, 8.0 * y);
        let within = DVec2::new(0.9, 0.9);
        region(&mold, at - within, at + within)
    };
    let corners = [(1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)].map(|(x, y)| corner(x, y));
    let set = planned(&mold, &corners, &params(GAP));
    assert_eq!((set.electrodes.len(), set.electrodes[0].burns.len()), (1, 4), "four corners, turned");
    let mut turns: Vec<f64> = set.electrodes[0].burns.iter().map(|b| b.turn.rem_euclid(2.0 * PI) / FRAC_PI_2).collect();
    turns.sort_by(f64::total_cmp);
    assert!(turns.iter().zip([0.0, 1.0, 2.0, 3.0]).all(|(t, k)| (t - k).abs() < 1e-6), "{turns:?}");
    let apart = planned(&mold, &corners, &ElectrodeParams { share: false, together_mm: 0.0, ..params(GAP) });
    assert_eq!(apart.electrodes.len(), 4);
}

#[test]
fn a_form_is_laid_onto_its_turned_copy_and_not_onto_its_mirror_image() {
    let shape = ring(&[(0.0, 0.0), (3.0, 0.0), (3.0, 1.0), (0.0, 2.0)]);
    let own = prism(&[&shape], 0.0, 2.0).unwrap();
    let mirrored: Vec<DVec2> = shape.iter().rev().map(|p| DVec2::new(-p.x, p.y)).collect();
    let mirrored = prism(&[&mirrored], 0.0, 2.0).unwrap();
    let (turn, shift) = (0.7, DVec3::new(5.0, -3.0, 1.0));
    let copy = placed(&own, turn, shift);
    let form = |mesh: &Mesh| Form::of(mesh, |p| p.z < 1e9);
    let meets = |(turn, shift): &(f64, DVec3), other: &Mesh| {
        let moved = placed(&own, *turn, *shift);
        moved.vertices.iter().all(|p| other.vertices.iter().any(|q| q.distance(*p) < 1e-3))
    };
    let onto = form(&own).onto(&form(&copy));
    assert!(onto.iter().any(|by| meets(by, &copy)), "{onto:?}");
    let onto = form(&own).onto(&form(&mirrored));
    assert!(!onto.iter().any(|by| meets(by, &mirrored)), "{onto:?}");
}

#[test]
fn broken_electrodes_are_caught_by_the_check_that_is_meant_for_it() {
    let mold = mold([30.0, 20.0, 10.0], &[(&rectangle(8.0, 0.8), 5.0)]);
    let slot = [region(&mold, DVec2::new(-4.1, -0.5), DVec2::new(4.1, 0.5))];
    let params = params(GAP);
    let set = planned(&mold, &slot, &params);
    let electrode = &set.electrodes[0];
    let right = electrode.burning(&electrode.mesh, &electrode.burns[0], &glam::DMat3::IDENTITY);
    let check =
        |mesh: &Mesh| check_own(&mold, mesh, &params.stages[0], (&cutters(), &params), &Cancel::default()).unwrap();
    let good = check(&right);
    assert!(good.iter().all(|f| f.holds), "{good:?}");

    let moved = check(&right.mapped(|p| p + DVec3::X * 0.1));
    assert!(!holds(&moved, CheckKind::Gouge) && holds(&moved, CheckKind::Watertight), "{moved:?}");

    let no_gap = ElectrodeParams { stages: vec![Stage::finish(0.0)], ..params.clone() };
    let tight = planned(&mold, &slot, &no_gap);
    let tight =
        tight.electrodes[0].burning(&tight.electrodes[0].mesh, &tight.electrodes[0].burns[0], &glam::DMat3::IDENTITY);
    assert!(!holds(&check(&tight), CheckKind::Gouge), "the gap was forgotten");

    let mut open = right.clone();
    open.triangles.pop();
    assert!(!holds(&check(&open), CheckKind::Watertight));
    let inside_out =
        Mesh { triangles: right.triangles.iter().map(|[a, b, c]| [*a, *c, *b]).collect(), ..right.clone() };
    assert!(!watertight(&inside_out).holds);

    // Too short: it stands in the right place and hits nothing, and leaves the bottom of the slot.
    let short = ElectrodeParams { ..params.clone() };
    let raised = right.mapped(|p| p + DVec3::Z * 0.3);
    assert!(check(&raised).iter().all(|f| f.holds), "it gouges nothing");
    let stage = &short.stages[0];
    let burning = super::burning::Burning::new(&raised, stage).unwrap();
    let floor =
        super::residual_stock::Sample { point: DVec3::new(1.0, 0.0, -5.0), normal: DVec3::Z, area: 1.0, thickest: 5.0 };
    let everything = |_: DVec3, _: f64| true;
    let milled = Milled { leaves: &everything, within: 0.05 };
    let obstacle = super::clearance::Obstacle::new(&mold).unwrap();
    let burns = Burns { all: &[burning], fullest: None };
    let left = left_by(&burns, &[floor], (&obstacle, &milled), &Cancel::default()).unwrap()[0].left;
    assert!((left.thickness - 0.3).abs() < 1e-3, "{left:?}");
    assert!(!residual_stock(&left, (params.tolerance_mm, 0.0), &params.stages[0], Looked::default()).holds);
}

#[test]
fn a_thin_blade_and_a_block_without_gap_in_the_wall_are_caught_and_every_burn_is_lifted_clear() {
    let mold = mold([30.0, 20.0, 10.0], &[(&rectangle(8.0, 0.8), 5.0)]);
    let slot = [region(&mold, DVec2::new(-4.1, -0.5), DVec2::new(4.1, 0.5))];
    let short = planned(&mold, &slot, &ElectrodeParams { lift_mm: 2.0, ..params(GAP) });
    assert!(
        short.holds() && (short.retract() - (5.0 - GAP + 2.0)).abs() < 1e-6,
        "{} {:?}",
        short.retract(),
        short.checks
    );
    // What needs a greater retract distance than the limit fails, with both figures.
    let limited = |limit: f64| {
        let params = ElectrodeParams { lift_mm: 2.0, lift_limit_mm: Some(limit), ..params(GAP) };
        planned(&mold, &slot, &params).checks.remove(0)
    };
    let needed = 5.0 - GAP + 2.0;
    let findings = limited(needed - 0.25);
    let approach = findings.iter().find(|finding| finding.kind == CheckKind::Approach).unwrap();
    assert!(!approach.holds && holds(&findings, CheckKind::Gouge), "{findings:?}");
    assert!(approach.text.contains("6.950 mm, the retract limit 6.700 mm"), "{}", approach.text);
    assert!((approach.figures["retract_mm"] - 0.25).abs() < 1e-6, "{approach:?}");
    assert!(limited(needed + 0.25).iter().all(|finding| finding.holds));
    let low = ElectrodeParams { lift_limit_mm: Some(29.0), ..params(GAP) }.validate().unwrap_err().to_string();
    assert!(low.starts_with("lift_limit_mm is 29: must be from 30 to 10000 mm"), "{low}");
    let thin = planned(&mold, &slot, &params(0.3));
    assert!(!holds(&thin.checks[0], CheckKind::Machinable), "0.2 mm is less than the least size: {:?}", thin.checks);
    // Without gap: a block that stands in the slot's wall, and one that touches it.
    let block =
        |y: f64| prism(&[&rectangle(4.0, 0.8).iter().map(|p| *p + DVec2::Y * y).collect::<Vec<_>>()], -5.0, 6.0);
    let check = |y: f64| {
        check_own(&mold, &block(y).unwrap(), &Stage::finish(0.0), (&cutters(), &params(0.0)), &Cancel::default())
            .unwrap()
    };
    assert!(holds(&check(0.0), CheckKind::Gouge) && holds(&check(0.0), CheckKind::Approach), "{:?}", check(0.0));
    assert!(!holds(&check(0.01), CheckKind::Gouge) && !holds(&check(0.01), CheckKind::Approach));
}

#[test]
fn what_hangs_over_the_cavity_is_met_on_the_way_in() {
    // A roof over half of a pocket: the electrode has room where it burns, and none above.
    let pocket = mold([30.0, 20.0, 10.0], &[(&rectangle(10.0, 6.0), 5.0)]);
    let under =
        prism(&[&rectangle(4.0, 20.0).iter().map(|p| *p + DVec2::X * 13.0).collect::<Vec<_>>()], 0.0, 2.0).unwrap();
    let roof: Vec<DVec2> = rectangle(30.0, 20.0).iter().map(|p| *p + DVec2::X * 14.0).collect();
    let roof = prism(&[&roof], 2.0, 4.0).unwrap();
    let with = |a: &Mesh, b: &Mesh| geometry::solid::union(a, b).unwrap();
    let mold = with(&with(&pocket, &under), &roof);
    let block =
        prism(&[&rectangle(2.0, 2.0).iter().map(|p| *p + DVec2::X * 3.0).collect::<Vec<_>>()], -4.9, 1.5).unwrap();
    let found = check_own(&mold, &block, &Stage::finish(GAP), (&cutters(), &params(GAP)), &Cancel::default()).unwrap();
    assert!(holds(&found, CheckKind::Gouge), "{found:?}");
    assert!(!holds(&found, CheckKind::Approach), "{found:?}");
}

#[test]
fn an_inner_corner_that_no_cutter_reaches_is_an_h_edge_and_cannot_be_milled() {
    let angle = ring(&[(0.0, 0.0), (6.0, 0.0), (6.0, 2.0), (2.0, 2.0), (2.0, 6.0), (0.0, 6.0)]);
    let upright = prism(&[&angle], 0.0, 3.0).unwrap();
    let of = |tip: &Mesh, at| h_edges(&inner_edges(tip), at, &Milling::by(&cutters(), 0.02));
    let edges = of(&upright, DividedAt::HEdges);
    assert_eq!(edges.len(), 1, "{edges:?}");
    assert!(place(&edges[0]).distance(DVec2::splat(2.0)) < 1e-9 && (edges[0].length() - 3.0).abs() < 1e-9);
    let large = CutterLibrary { cutter: vec![Cutter::flat(0.5)] };
    let found =
        machinable(&on_plate(&upright.mapped(|p| p - DVec3::Z * 2.9)).unwrap(), &large, 0.02, None, &Cancel::default())
            .unwrap();
    assert!(!found.holds && found.place.unwrap().truncate().distance(DVec2::splat(2.1)) < 0.2, "{found:?}");
    // Lying down, the step is horizontal: a flat end makes it.
    let lying = upright.mapped(|p| DVec3::new(p.x, p.z, -p.y));
    assert!(of(&lying, DividedAt::HEdges).is_empty());
    assert_eq!(of(&lying, DividedAt::EveryEdge).len(), 1);
    let lying = on_plate(&lying.mapped(|p| p - DVec3::Z * (lying.bounds().max.z - 0.1))).unwrap();
    assert!(machinable(&lying, &large, 0.02, None, &Cancel::default()).unwrap().holds);
}

#[test]
fn sets_grow_and_shrink_by_distances() {
    let square = [Outline::new(rectangle(4.0, 4.0)).unwrap()];
    let wide = grown(&square, 1.0);
    let expected = 16.0 + 16.0 + PI;
    assert!((plane::area(&wide) / expected - 1.0).abs() < 0.01);
    assert!((plane::area(&shrunk(&square, 1.0)) - 4.0).abs() < 0.1);
    assert!(shrunk(&square, 2.1).is_empty());
    let points = ring(&[(0.0, 0.0), (2.0, 0.0), (1.0, 0.5), (2.0, 2.0), (0.0, 2.0), (1.0, 1.0)]);
    assert!((hull(&points).unwrap().area() - 4.0).abs() < 1e-12);
    assert!(hull(&points[..2]).is_none());
}

#[test]
fn boxes_come_together_as_far_as_they_fit_and_a_cutter_passes() {
    let at = |x: f64, y: f64| [DVec2::new(x, y), DVec2::new(x + 1.0, y + 1.0)];
    let boxes = [at(0.0, 0.0), at(3.0, 0.0), at(1.5, 0.0), at(20.0, 0.0), at(0.0, 3.0)];
    assert_eq!(near(&boxes, 5.0, 1.0), vec![vec![0, 1, 4], vec![2], vec![3]]);
    assert_eq!(near(&boxes, 0.0, 1.0).len(), 5);
}

#[test]
fn stages_have_electrodes_of_their_own_and_parameters_that_make_none_are_answered() {
    let mold = mold([30.0, 20.0, 10.0], &[(&rectangle(8.0, 1.6), 5.0)]);
    let slot = RegionToBurn { volume: 64.0, ..region(&mold, DVec2::new(-4.1, -0.9), DVec2::new(4.1, 0.9)) };
    let rough = Stage { name: "rough".into(), finish_vdi: 33.0, stock_mm: 0.05, ..Stage::finish(0.25) };
    let two = ElectrodeParams { stages: vec![rough, Stage::finish(GAP)], ..params(GAP) };
    let set = planned(&mold, std::slice::from_ref(&slot), &two);
    assert!(set.holds(), "{:?}", set.checks);
    assert_eq!(set.electrodes.iter().map(|e| e.name.as_str()).collect::<Vec<_>>(), ["E01-rough", "E01-finish"]);
    let widths: Vec<f64> = set.electrodes.iter().map(|e| e.tips.bounds().size().y).collect();
    assert!((widths[0] - 1.0).abs() < 1e-6 && (widths[1] - 1.5).abs() < 1e-6, "{widths:?}");
    // Finishing takes the layer by which its electrode is larger, 0.25 mm, off the region's whole surface.
    let surface: f64 = slot.corners.iter().map(|[a, b, c]| 0.5 * (*b - *a).cross(*c - *a).length()).sum();
    let volumes: Vec<f64> = set.electrodes.iter().map(|e| e.burns[0].volume).collect();
    assert!((volumes[1] - 0.25 * surface).abs() < 1e-6 * surface, "{volumes:?} {surface}");
    assert!((volumes[0] + volumes[1] - slot.volume).abs() < 1e-9 && volumes[0] > 0.0, "{volumes:?}");
    // Four walls and a floor of the blade that finishes; sparks reach the rim from as far above it as the gap.
    let [x, y, z] = [8.0 - 2.0 * GAP, 1.6 - 2.0 * GAP, 5.0];
    let area = set.electrodes[1].burn_area;
    assert!((area - (x * y + 2.0 * (x + y) * z)).abs() < 1e-3 * area, "{area}");
    let refused = |params: ElectrodeParams| params.validate().unwrap_err().to_string();
    assert!(refused(ElectrodeParams { stages: Vec::new(), ..params(GAP) }).contains("there is no stage"));
    let negative = refused(params(-0.1));
    assert!(negative.starts_with("stages[0].gap_mm is -0.1: must be from 0 to 5 mm"), "{negative}");
    let twice = ElectrodeParams { stages: vec![Stage::finish(0.1), Stage::finish(0.2)], ..params(GAP) };
    assert!(refused(twice).contains("two stages are called \"finish\""));
    let rough = Stage { name: "rough".into(), ..Stage::finish(0.2) };
    let backwards = ElectrodeParams { stages: vec![Stage::finish(0.05), rough], ..params(GAP) };
    assert!(refused(backwards).contains("stage rough has an undersize of 0.2 mm and follows finish with 0.05 mm"));
    assert!(ElectrodeParams { margin_mm: f64::NAN, ..params(GAP) }.validate().is_err());
    assert!(ElectrodeParams::default().validate().is_ok());
}

#[test]
fn the_user_splits_merges_and_chooses_the_method() {
    let mold = mold([30.0, 20.0, 10.0], &[(&rectangle(8.0, 0.8), 5.0)]);
    let slot = [region(&mold, DVec2::new(-4.1, -0.5), DVec2::new(4.1, 0.5))];
    let apart = ElectrodeParams { share: false, together_mm: 0.0, ..params(GAP) };
    let with = |edits: Vec<Edit>| planned(&mold, &slot, &ElectrodeParams { edits, ..apart.clone() });
    let line = |x: f64| [DVec3::new(x, -2.0, 0.0), DVec3::new(x, 2.0, 0.0)];
    let split = Edit::Split { line: line(1.0) };
    let halves = with(vec![split]);
    assert!(halves.holds(), "{:?}", halves.checks);
    assert_eq!(halves.electrodes.len(), 2);
    // The tree that is shown is that of the parts that are burned.
    let tree = |set: &ElectrodeSet| set.regions[0].tree.clone().unwrap();
    assert_eq!(tree(&halves).parts.iter().map(|p| p.part).collect::<Vec<_>>(), [Some(0), Some(1)]);
    assert!(tree(&halves).cut.is_some_and(|cut| (cut.through.x - 1.0).abs() < 1e-12));
    // Together they are as long as the slot and reach over one another by the overlap.
    let length: f64 = halves.electrodes.iter().map(|e| e.tips.bounds().size().x).sum();
    assert!((length - (8.0 - 2.0 * GAP + apart.overlap_mm)).abs() < 1e-3, "{length}");
    let merge = Edit::Merge { places: [DVec3::new(-2.0, 0.0, -5.0), DVec3::new(2.0, 0.0, -5.0)] };
    let again = with(vec![split, merge]);
    assert_eq!(again.electrodes.len(), 1);
    assert!((again.electrodes[0].tips.bounds().size().x - (8.0 - 2.0 * GAP)).abs() < 1e-3 && again.holds());
    assert!(tree(&again).parts.is_empty() && again.unmet_edits().is_empty());
    let beside = with(vec![Edit::Split { line: line(9.0) }, split]);
    assert_eq!((beside.electrodes.len(), beside.unmet_edits()), (2, vec![0]), "a line that meets no part divides none");
    // The places that the tree gives name its parts.
    let given: Vec<DVec3> = tree(&halves).parts.iter().map(|p| p.place.unwrap().extend(0.0)).collect();
    for places in [[given[0], given[1]], [given[1], given[0]]] {
        let again = with(vec![split, Edit::Merge { places }]);
        assert_eq!((again.electrodes.len(), again.unmet_edits()), (1, vec![]), "{places:?}");
    }
    let place = DVec3::new(0.0, 0.0, -5.0);
    for method in [Method::Extruding, Method::Cutting] {
        let set = with(vec![Edit::Make { place, method }]);
        assert!(set.holds() && set.electrodes[0].method == method && set.regions[0].method == method);
    }
}

/// A name belongs to what the electrode burned when it was given.
#[test]
fn names_once_given_never_move_and_gaps_stay() {
    let mold = mold([30.0, 20.0, 10.0], &[(&rectangle(8.0, 0.8), 5.0)]);
    let slot = [region(&mold, DVec2::new(-4.1, -0.5), DVec2::new(4.1, 0.5))];
    let with = |edits: &[Edit], names: &[GivenName]| {
        let (edits, names) = (edits.to_vec(), names.to_vec());
        let apart = ElectrodeParams { share: false, together_mm: 0.0, edits, names, ..params(GAP) };
        planned(&mold, &slot, &apart)
    };
    let split = |x: f64| Edit::Split { line: [DVec3::new(x, -1.0, 0.0), DVec3::new(x, 1.0, 0.0)] };
    // Each with the middle of what it burns along the slot.
    let names = |set: &ElectrodeSet| -> Vec<String> {
        let mut all: Vec<&Electrode> = set.electrodes.iter().collect();
        all.sort_by(|a, b| a.burns[0].position.x.total_cmp(&b.burns[0].position.x));
        all.iter().map(|e| e.name.clone()).collect()
    };
    let thirds = [split(-1.5), split(1.5)];
    let first = with(&thirds, &[]);
    let at_first = names(&first);
    let sorted = |mut names: Vec<String>| {
        names.sort();
        names
    };
    assert_eq!(sorted(at_first.clone()), ["E01", "E02", "E03"], "a first run numbers them one after the other");
    for merged in [[-2.75, 0.0], [0.0, 2.75]] {
        let merge = Edit::Merge { places: merged.map(|x| DVec3::new(x, 0.0, -5.0)) };
        let joined = with(&[&thirds[..], &[merge]].concat(), &first.names);
        let [left, right] = &names(&joined)[..] else { panic!("{:?}", names(&joined)) };
        let (other, before) = if merged[1] == 0.0 { (right, &at_first[2]) } else { (left, &at_first[0]) };
        assert_eq!(other, before, "what was not merged is called as before");
        let one = if merged[1] == 0.0 { left } else { right };
        let both: Vec<&String> = at_first.iter().filter(|name| *name != other).collect();
        assert!(both.contains(&one), "{one} {both:?}");
        // What is divided anew gets a new name, not the one that has become free.
        let apart =
            with(&[&thirds[..], &[merge, split(if merged[1] == 0.0 { 3.1 } else { -3.1 })]].concat(), &joined.names);
        assert_eq!(apart.electrodes.len(), 3);
        assert!(
            names(&apart).contains(other) && names(&apart).contains(one) && names(&apart).contains(&"E04".to_owned())
        );
        assert_eq!(names(&with(&thirds, &apart.names)), at_first, "taken back");
    }
    assert_eq!(names(&with(&thirds, &[])), at_first);
    // Names of a file that says the same number twice, or a place that is nowhere, are given once.
    let far = GivenName { number: usize::MAX, places: vec![DVec3::NAN, DVec3::splat(1e9)], ..GivenName::default() };
    let twice = [first.names.clone(), first.names.clone(), vec![far]].concat();
    assert_eq!(names(&with(&thirds, &twice)), at_first);
}

#[test]
fn parts_of_what_is_left_along_walls_are_named_by_points_of_it_and_of_their_tips() {
    let mold = mold([30.0, 20.0, 10.0], &[(&rectangle(8.0, 0.8), 5.0)]);
    let all = region(&mold, DVec2::new(-4.1, -0.5), DVec2::new(4.1, 0.5));
    let is_beside_wall = |c: &&[DVec3; 3]| (c[0] + c[1] + c[2]).y.abs() / 3.0 > 0.25;
    let corners: Vec<[DVec3; 3]> = all.corners.iter().filter(is_beside_wall).copied().collect();
    let depths = vec![5.0; corners.len()];
    let walls = [RegionToBurn { corners, depths, ..all }];
    let apart = ElectrodeParams { share: false, together_mm: 0.0, ..params(GAP) };
    let with = |edits: Vec<Edit>| planned(&mold, &walls, &ElectrodeParams { edits, ..apart.clone() });
    // The line's middle and those of the tips are in the middle of the slot, where nothing is left.
    let split = Edit::Split { line: [DVec3::new(1.0, -1.0, 0.0), DVec3::new(1.0, 1.0, 0.0)] };
    let halves = with(vec![split]);
    assert_eq!((halves.electrodes.len(), halves.unmet_edits()), (2, vec![]), "{:?}", halves.regions[0]);
    let tree = halves.regions[0].tree.clone().unwrap();
    let given: Vec<DVec3> = tree.parts.iter().map(|p| p.place.unwrap().extend(0.0)).collect();
    let middles: Vec<DVec3> = halves.electrodes.iter().map(|e| e.burns[0].position).collect();
    for places in [[given[0], given[1]], [middles[0], middles[1]]] {
        let again = with(vec![split, Edit::Merge { places }]);
        assert_eq!((again.electrodes.len(), again.unmet_edits()), (1, vec![]), "{places:?}");
    }
    let same = with(vec![split, Edit::Merge { places: [given[0]; 2] }]);
    assert_eq!((same.electrodes.len(), same.unmet_edits()), (2, vec![1]), "a part is not merged with itself");
}

#[test]
fn what_is_left_of_walls_alone_is_split_along_a_line_and_named_by_places_at_them() {
    let mold = mold([30.0, 20.0, 10.0], &[(&rectangle(8.0, 0.8), 5.0)]);
    let all = region(&mold, DVec2::new(-4.1, -0.5), DVec2::new(4.1, 0.5));
    let is_wall = |c: &&[DVec3; 3]| c.iter().all(|p| p.y.abs() > 0.4 - 1e-6);
    let corners: Vec<[DVec3; 3]> = all.corners.iter().filter(is_wall).copied().collect();
    let depths = vec![5.0; corners.len()];
    let walls = [RegionToBurn { corners, depths, ..all }];
    let apart = ElectrodeParams { share: false, together_mm: 0.0, ..params(GAP) };
    for orbit in [Orbit::None, Orbit::Circular { radius_mm: 0.05 }] {
        let stage = Stage { orbit, ..Stage::finish(GAP) };
        let apart = ElectrodeParams { stages: vec![stage], ..apart.clone() };
        let with = |edits: Vec<Edit>| planned(&mold, &walls, &ElectrodeParams { edits, ..apart.clone() });
        let split = Edit::Split { line: [DVec3::new(1.0, -1.0, 0.0), DVec3::new(1.0, 1.0, 0.0)] };
        let halves = with(vec![split]);
        assert_eq!((halves.electrodes.len(), halves.unmet_edits()), (2, vec![]), "{:?}", halves.regions[0]);
        assert!(halves.holds(), "{:?}", halves.checks);
        // Each takes its share of the walls: 5 mm and 3 mm of their length.
        let share: f64 = 3.0 / 8.0;
        let volumes: Vec<f64> = halves.electrodes.iter().map(|e| e.burns[0].volume).collect();
        let least = volumes[0].min(volumes[1]) / (volumes[0] + volumes[1]);
        assert!((least / share - 1.0).abs() < 0.1, "{volumes:?}");
        // At the wall, and within what the gap leaves beside the tip.
        for y in [0.4, 0.38, -0.4] {
            let merge = Edit::Merge { places: [DVec3::new(-2.0, y, -5.0), DVec3::new(2.0, y, -5.0)] };
            let again = with(vec![split, merge]);
            assert_eq!((again.electrodes.len(), again.unmet_edits()), (1, vec![]), "{y}");
        }
    }
}

#[test]
fn a_slot_in_a_side_is_burned_from_that_side() {
    let block = prism(&[&rectangle(30.0, 20.0)], -10.0, 0.0).unwrap();
    let slot: Vec<DVec2> = rectangle(10.0, 0.8).iter().map(|p| *p + DVec2::X * 15.0).collect();
    let mold = difference(&block, &prism(&[&slot], -7.0, -3.0).unwrap()).unwrap();
    let own = region(&mold, DVec2::new(9.9, -0.5), DVec2::new(14.999, 0.5));
    let corners: Vec<[DVec3; 3]> =
        own.corners.iter().filter(|c| c.iter().all(|p| (-7.1..-2.9).contains(&p.z))).copied().collect();
    let depths = vec![5.0; corners.len()];
    let place = DVec3::new(10.0, 0.0, -5.0);
    let own = RegionToBurn { corners, depths, ..own };
    let sideways = Edit::Burn { place, direction: DVec3::new(-2.0, 0.0, 0.0) };
    let set = planned(&mold, &[own], &ElectrodeParams { edits: vec![sideways], ..params(GAP) });
    assert!(set.holds(), "{:?} {:?}", set.checks, set.regions[0].reason);
    let [electrode] = &set.electrodes[..] else { panic!("one electrode") };
    assert!(electrode.direction.distance(DVec3::NEG_X) < 1e-9, "{}", electrode.direction);
    let burn = &electrode.burns[0];
    assert!((burn.depth - (5.0 - GAP)).abs() < 1e-6, "{}", burn.depth);
    // Its base stands off the side by the extension, before the middle of the slot.
    assert!(burn.position.distance(DVec3::new(20.0, 0.0, -5.0)) < 1e-6, "{}", burn.position);
}

/// Checks of electrodes from elsewhere, placed in the upright mold, as those of a plan are checked.
fn check_own(
    mold: &Mesh,
    electrode: &Mesh,
    stage: &Stage,
    (cutters, params): (&CutterLibrary, &ElectrodeParams),
    cancel: &Cancel,
) -> Result<Vec<Finding>, ElectrodeError> {
    let closed = watertight(electrode);
    let is_closed = closed.holds;
    let mut findings = vec![closed];
    let mold = Obstacle::new(mold)?.stopped_by(cancel);
    findings.extend(mold.clearance(electrode, stage, params.lift_mm)?.findings(stage));
    if is_closed {
        findings.push(machinable(electrode, cutters, params.tolerance_mm, None, cancel)?);
    }
    Ok(findings)
}

#[test]
fn walls_that_hang_over_a_head_are_told_with_their_place_and_the_way_out() {
    let sides = rectangle(30.0, 20.0);
    let narrows = crate::fixtures::pocket(&sides, &rectangle(8.0, 2.0), &rectangle(8.0, 6.0), [10.0, 5.0]);
    let mold = narrows.mapped(|p| p - DVec3::Z * 10.0);
    let slot = region(&mold, DVec2::new(-4.1, -3.1), DVec2::new(4.1, 3.1));
    let set = planned(&mold, &[slot], &params(GAP));
    let reason = set.regions[0].reason.clone().unwrap();
    let place = set.regions[0].reason_place.unwrap();
    assert!(place.x.abs() < 4.1 && place.y.abs() < 3.1 && (-5.1..0.1).contains(&place.z), "{reason} {place}");
    let told = set.regions[0].reason_at(&glam::DAffine3::from_translation(-place)).unwrap();
    assert_eq!(told, format!("{reason}, at (0.000, 0.000, 0.000)"), "from another origin");
    assert!(reason.contains("hangs over it") && reason.contains("burn the region from another"), "{reason}");
    // Two walls that lean apart are not seen from one direction.
    let proposal = set.regions[0].proposal.unwrap();
    assert!(!proposal.sees_all() && proposal.seen > proposal.seen_now, "{proposal:?}");
    assert!(reason.ends_with(&proposal.to_string()), "{reason}");
}

#[test]
fn a_slot_that_leans_is_burned_along_what_is_proposed_and_an_upright_one_gets_no_proposal() {
    let lean = glam::DMat3::from_rotation_x(20f64.to_radians());
    let slot = Mesh::cuboid(DVec3::new(6.0, 2.0, 8.0)).mapped(|p| lean * (p - DVec3::new(3.0, 1.0, 4.0)));
    let block = mold([30.0, 20.0, 10.0], &[]);
    let leaning = difference(&block, &slot).unwrap();
    let all = [region(&leaning, DVec2::splat(-5.0), DVec2::splat(5.0))];
    let set = planned(&leaning, &all, &params(GAP));
    let reason = set.regions[0].reason.clone().unwrap();
    let expected = "burn the region from another direction: tilted 20.0 deg towards 90.0 deg all of it is seen";
    assert!(reason.ends_with(expected), "{reason}");
    let proposal = set.regions[0].proposal.unwrap();
    let along = Edit::Burn { place: all[0].corners[0][0], direction: proposal.direction };
    let along = planned(&leaning, &all, &ElectrodeParams { edits: vec![along], ..params(GAP) });
    let plan = &along.regions[0];
    assert!(plan.direction.distance(proposal.direction) < 1e-12 && !along.electrodes.is_empty(), "{plan:?}");
    let is_hung_over = plan.reason.as_ref().is_some_and(|reason| reason.contains("hangs over it"));
    assert!(plan.proposal.is_none() && !is_hung_over, "{plan:?}");
    assert!(plan.left.thickness < set.regions[0].left.thickness, "{plan:?}");
    let upright = mold([30.0, 20.0, 10.0], &[(&rectangle(6.0, 2.0), 4.0)]);
    let all = region(&upright, DVec2::splat(-5.0), DVec2::splat(5.0));
    let set = planned(&upright, &[all], &params(GAP));
    assert!(set.holds() && set.regions[0].proposal.is_none(), "{:?}", set.regions[0]);
}
