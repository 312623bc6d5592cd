//! Plans of molds in which stages, shared tips and changes have to stay with their own place.

use files::Validate;
use std::collections::BTreeMap;

use glam::{DMat3, DVec2, DVec3};

use super::design::Family;
use super::design::{Electrode, ElectrodeSet, PartId, PartNode};
use super::params::{Edit, ElectrodeParams, Method, Shape, Stage};
use super::setting::RegionToBurn;
use super::tests::{GAP, mold, params, planned, region, ring};
use crate::fixtures::rectangle;
use geometry::mesh::Mesh;
use geometry::solid::difference;

/// The corners of a rectangle between two.
fn between(low: (f64, f64), high: (f64, f64)) -> Vec<DVec2> {
    ring(&[low, (high.0, low.1), high, (low.0, high.1)])
}

/// A solid that is this rectangle at height `-depth` and `wider` all around at 1.
fn drafted(low: DVec2, high: DVec2, depth: f64, wider: f64) -> Mesh {
    let at = |low: DVec2, high: DVec2, z: f64| {
        [low, DVec2::new(high.x, low.y), high, DVec2::new(low.x, high.y)].map(|p| p.extend(z))
    };
    let vertices = [at(low, high, -depth), at(low - wider, high + wider, 1.0)].concat();
    let sides = (0..4).flat_map(|i: u32| {
        let j = (i + 1) % 4;
        [[i, j, j + 4], [i, j + 4, i + 4]]
    });
    let triangles = [[0, 2, 1], [0, 3, 2], [4, 5, 6], [4, 6, 7]].into_iter().chain(sides).collect();
    Mesh { vertices, triangles }
}

/// The middles in plan of what each stage's burns stand in, by part.
fn middles(set: &ElectrodeSet) -> BTreeMap<PartId, Vec<DVec2>> {
    let mut found: BTreeMap<PartId, Vec<DVec2>> = BTreeMap::new();
    for electrode in &set.electrodes {
        for burn in &electrode.burns {
            let [part] = burn.parts[..] else { panic!("{:?}", burn.parts) };
            let there = electrode.burning(&electrode.tips, burn, &DMat3::IDENTITY).bounds().center().truncate();
            found.entry(part).or_default().push(there);
        }
    }
    found
}

/// A bar with a narrow slot and a wide one: roughing has no tip for the narrow one.
fn comb() -> (Mesh, RegionToBurn) {
    let bar = between((-9.0, -4.0), (-2.0, -1.0));
    let (narrow, wide) = (between((-8.0, -1.1), (-7.25, 4.0)), between((-5.0, -1.1), (-3.4, 3.0)));
    let mold = mold([24.0, 16.0, 10.0], &[(&bar, 3.0), (&narrow, 3.0), (&wide, 3.0)]);
    let volume = 3.0 * (7.0 * 3.0 + 0.75 * 5.0 + 1.6 * 4.0);
    let all = RegionToBurn { volume, ..region(&mold, DVec2::new(-9.1, -4.1), DVec2::new(-1.9, 4.1)) };
    (mold, all)
}

fn two_stages() -> ElectrodeParams {
    let rough = Stage { name: "rough".into(), finish_vdi: 33.0, ..Stage::finish(0.3) };
    let stages = vec![rough, Stage::finish(GAP)];
    ElectrodeParams { stages, together_mm: 0.0, family: true, ..params(GAP) }
}

#[test]
fn a_part_is_the_same_place_in_every_stage_and_so_are_names_and_families() {
    let (mold, all) = comb();
    let set = planned(&mold, std::slice::from_ref(&all), &two_stages());
    assert!(set.holds(), "{:?} {:?}", set.checks, set.regions[0].reason);
    let middles = middles(&set);
    for (part, places) in &middles {
        assert!(places.iter().all(|p| p.distance(places[0]) < 0.8), "{part} is at {places:?}");
    }
    assert_eq!(middles.values().map(Vec::len).collect::<Vec<_>>().iter().sum::<usize>(), 5);
    // What is on one base is for one place; the narrow slot has a tip of its own.
    let root = |e: &Electrode| e.name.split('-').next().unwrap().to_owned();
    for (e, electrode) in set.electrodes.iter().enumerate() {
        let others = set.electrodes.iter().filter(|o| root(o) == root(electrode));
        assert!(others.clone().all(|o| o.parts() == electrode.parts()));
        assert_eq!(matches!(electrode.family, Family::Apart { .. }), others.count() == 1, "{e}");
    }
    // The trees of both stages are known, and name all that is burned.
    let plan = &set.regions[0];
    let [(0, rough)] = &plan.earlier[..] else { panic!("{:?}", plan.earlier) };
    fn leaves(node: &PartNode) -> Vec<usize> {
        node.part.into_iter().chain(node.parts.iter().flat_map(leaves)).collect()
    }
    let (rough, last) = (leaves(rough), leaves(plan.tree.as_ref().unwrap()));
    assert_eq!(last, [0, 1, 2]);
    let is_in = |stage: usize, list: &[usize]| {
        let own = set.electrodes.iter().filter(|e| e.stage == stage).flat_map(|e| &e.burns).flat_map(|b| &b.parts);
        own.clone().all(|p| list.contains(&p.part))
    };
    assert!(is_in(0, &rough) && is_in(1, &last), "{rough:?}");
}

#[test]
fn what_roughing_passed_over_is_all_left_to_the_burn_that_takes_it() {
    let (mold, all) = comb();
    let set = planned(&mold, std::slice::from_ref(&all), &two_stages());
    let burns = || set.electrodes.iter().flat_map(|e| e.burns.iter().map(move |b| (e, b)));
    let total: f64 = burns().map(|(_, b)| b.volume).sum();
    assert!((total - all.volume).abs() < 1e-6 * all.volume, "{total}");
    let middle = |e: &Electrode, b| e.burning(&e.tips, b, &DMat3::IDENTITY).bounds().center();
    let narrow: Vec<f64> = burns().filter(|(e, b)| middle(e, b).x < -6.5).map(|(_, b)| b.volume).collect();
    let [narrow] = narrow[..] else { panic!("{narrow:?}") };
    assert!((narrow / (3.0 * 0.75 * 5.0) - 1.0).abs() < 0.12, "{narrow}");
    // Of the others roughing takes most.
    for (electrode, burn) in burns().filter(|(e, b)| e.stage == 1 && middle(e, b).x > -6.5) {
        let of_rough =
            burns().filter(|(e, b)| e.stage == 0 && b.parts == burn.parts).map(|(_, b)| b.volume).sum::<f64>();
        assert!(of_rough > burn.volume, "{}: {of_rough} {}", electrode.name, burn.volume);
    }
    // Each burn takes the volume of its heads, on the area that they have.
    for (_, burn) in burns() {
        let heads = burn.heads.as_ref().unwrap();
        assert!((heads.iter().map(|head| head.volume_mm3).sum::<f64>() - burn.volume).abs() < 1e-9);
        assert!(heads.iter().all(|head| head.frontal_area_mm2 > 0.0) && heads.len() == burn.parts.len());
    }
}

#[test]
fn a_net_shape_of_which_there_is_no_electrode_fails() {
    // With its gap of 0.3 no tip fits into the slot, without it one does.
    let mold = mold(
        [24.0, 16.0, 10.0],
        &[(&between((-6.0, -2.0), (-2.0, 2.0)), 3.0), (&between((-2.1, -0.21), (4.0, 0.21)), 3.0)],
    );
    let all = region(&mold, DVec2::new(-6.1, -2.1), DVec2::new(4.1, 2.1));
    let set = planned(&mold, &[all], &ElectrodeParams { shape: Shape::Net, ..params(0.3) });
    assert!(!set.holds() && !set.electrodes.is_empty());
    for (e, electrode) in set.electrodes.iter().enumerate() {
        let reach = |b| electrode.burning(&electrode.tips, b, &DMat3::IDENTITY).bounds().max.x;
        if electrode.burns.iter().any(|b| reach(b) > 0.0) {
            assert!(set.fails(e), "{} was not checked: {:?}", electrode.name, set.checks[e]);
        }
    }
}

#[test]
fn tips_are_shared_only_where_they_burn_as_well_as_the_place_s_own() {
    let block = mold([32.0, 28.0, 10.0], &[]);
    let wider = 4.0 * 2f64.to_radians().tan();
    let arms = [((-4.0, -3.0), (4.0, -1.8)), ((-1.0, -3.0), (0.2, 3.0))];
    let mold = arms.into_iter().fold(block, |mold, (low, high)| {
        difference(&mold, &drafted(DVec2::from(low), DVec2::from(high), 3.0, wider)).unwrap()
    });
    let all = region(&mold, DVec2::new(-4.3, -3.3), DVec2::new(4.3, 3.3));
    let apart = planned(&mold, std::slice::from_ref(&all), &ElectrodeParams { share: false, ..params(GAP) });
    assert!(apart.holds(), "{:?}", apart.checks);
    let shared = planned(&mold, std::slice::from_ref(&all), &params(GAP));
    assert!(shared.holds(), "{:?}", shared.checks);
}

#[test]
fn a_tip_reaches_as_high_as_the_surface_that_it_is_for() {
    // What layers know ends half a millimetre below what the surface shows.
    let block = mold([24.0, 16.0, 10.0], &[]);
    let mold = difference(&block, &drafted(DVec2::new(-4.0, -0.4), DVec2::new(4.0, 0.4), 3.0, 0.8)).unwrap();
    let all = RegionToBurn { rim: -0.5, ..region(&mold, DVec2::new(-5.0, -1.4), DVec2::new(5.0, 1.4)) };
    let set = planned(&mold, &[all], &params(GAP));
    assert!(set.holds(), "{:?}", set.checks);
}

#[test]
fn a_change_is_for_the_nearest_region_and_a_direction_that_is_none_is_refused() {
    // Two slots with a rib of 0.3 between them.
    let (left, right) = (between((-3.0, -2.0), (-2.0, 2.0)), between((-1.7, -2.0), (-0.7, 2.0)));
    let mold = mold([20.0, 14.0, 10.0], &[(&left, 3.0), (&right, 3.0)]);
    let regions =
        [(-3.1, -1.9), (-1.8, -0.6)].map(|(low, high)| region(&mold, DVec2::new(low, -2.1), DVec2::new(high, 2.1)));
    let place = DVec3::new(-2.0, 0.0, -1.0);
    let edits = vec![
        Edit::Make { place, method: Method::Extruding },
        Edit::Burn { place, direction: DVec3::new(0.0, 0.1, -1.0) },
    ];
    let set = planned(&mold, &regions, &ElectrodeParams { edits, ..params(GAP) });
    let of = |r: usize| (set.regions[r].method, set.regions[r].direction == DVec3::NEG_Z, set.regions[r].edits.len());
    assert_eq!((of(0), of(1)), ((Method::Extruding, false, 2), (Method::Cutting, true, 0)));
    let aside = planned(&mold, &regions, &ElectrodeParams { edits: vec![Edit::SetAside { place }], ..params(GAP) });
    assert_eq!(
        (aside.set_aside(), aside.needing_none(), aside.why_not_burned(0, &glam::DAffine3::IDENTITY)),
        (vec![0], vec![], Some("set aside".to_owned()))
    );
    let burned: Vec<usize> = aside.electrodes.iter().flat_map(Electrode::parts).map(|part| part.region).collect();
    assert!(aside.holds() && burned == [1] && aside.unmet_edits().is_empty(), "{:?}", aside.checks);
    let asked = |edit: Edit| ElectrodeParams { edits: vec![edit], ..params(GAP) }.validate();
    for wrong in [f64::NAN, f64::INFINITY, 1e200, 0.0, 1e-320] {
        let direction = DVec3::new(0.0, 0.0, wrong);
        assert_eq!(asked(Edit::Burn { place, direction }).unwrap_err().key, "edits[0].direction", "{wrong}");
    }
    assert_eq!(asked(Edit::Burn { place, direction: DVec3::new(0.0, 0.0, -7.5) }), Ok(()));
    let nowhere = DVec3::new(f64::NAN, 0.0, 0.0);
    assert_eq!(asked(Edit::Split { line: [place, nowhere] }).unwrap_err().key, "edits[0]");
}

#[test]
fn a_region_about_as_thin_as_the_tolerance_needs_no_electrode() {
    let mold = mold([30.0, 20.0, 10.0], &[(&rectangle(8.0, 0.8), 5.0)]);
    let slot = region(&mold, DVec2::new(-4.1, -0.5), DVec2::new(4.1, 0.5));
    let asked = params(0.45);
    let bare = RegionToBurn { corners: Vec::new(), depths: Vec::new(), ..slot.clone() };
    for of in [&slot, &bare] {
        let thin = RegionToBurn { thickness: 1.2 * asked.tolerance_mm, ..of.clone() };
        let set = planned(&mold, &[thin], &asked);
        assert!(set.holds() && set.electrodes.is_empty(), "{:?}", set.regions[0].reason);
        assert!(set.regions[0].left_out[0].text.contains("nothing to burn"), "{:?}", set.regions[0].left_out);
    }
    let set = planned(&mold, &[bare], &asked);
    let reason = set.regions[0].reason.as_ref().unwrap();
    assert!(reason.contains("surface") && !reason.contains("twice the spark gap"), "{reason}");
}
