//! Several stages: families on one base, and what a stage leaves to those after it.

use glam::{DMat3, DVec2, DVec3};

use super::design::ElectrodeSet;
use super::design::Family;
use super::params::{ElectrodeParams, Holder, Shape, Stage};
use super::setting::RegionToBurn;
use super::tests::{GAP, mold, params, planned, region, ring};
use crate::fixtures::rectangle;
use geometry::mesh::Mesh;
use geometry::solid::{difference, prism};

fn holder(side: f64) -> Holder {
    Holder { name: format!("holder {side}"), size_mm: [side; 2], height_mm: 20.0 }
}

/// Roughing with this gap and finishing, as a family if that is asked for.
fn stages(rough_gap: f64, family: bool) -> ElectrodeParams {
    let rough = Stage { name: "rough".into(), finish_vdi: 33.0, ..Stage::finish(rough_gap) };
    ElectrodeParams { stages: vec![rough, Stage::finish(GAP)], family, ..params(GAP) }
}

/// A slot in a block of this size.
fn slotted(block: [f64; 3]) -> (Mesh, RegionToBurn) {
    let mold = mold(block, &[(&rectangle(5.0, 1.6), 4.0)]);
    let slot = region(&mold, DVec2::new(-2.6, -0.9), DVec2::new(2.6, 0.9));
    (mold, slot)
}

fn offset(set: &ElectrodeSet, electrode: usize) -> DVec2 {
    match &set.electrodes[electrode].family {
        Family::Member { offset, .. } => *offset,
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_family_stands_on_one_base_and_each_stage_goes_where_its_tip_belongs() {
    let (mold, slot) = slotted([8.0, 6.0, 10.0]);
    for shape in [Shape::Undersized, Shape::Net] {
        let asked = ElectrodeParams { holders: vec![holder(15.0), holder(25.0)], shape, ..stages(0.2, true) };
        let set = planned(&mold, std::slice::from_ref(&slot), &asked);
        assert!(set.holds(), "{:?} {:?}", set.checks, set.regions[0].reason);
        let [rough, finish] = &set.electrodes[..] else { panic!("{}", set.electrodes.len()) };
        assert_eq!((rough.mesh == finish.mesh, rough.family.name(), set.body_of(1)), (true, Some("E01"), vec![0, 1]));
        assert!(rough.mesh.is_watertight() && rough.holder == Some(1) && finish.holder == Some(1));
        for (e, electrode) in set.electrodes.iter().enumerate() {
            let there = electrode.burning(&electrode.tips, &electrode.burns[0], &DMat3::IDENTITY).bounds();
            assert!(there.center().truncate().length() < 1e-6, "the tip is over the slot: {}", there.center());
            let own = electrode.tips.bounds().center().truncate();
            assert!(own.distance(offset(&set, e)) < 1e-9, "{own}");
            let origin = electrode.burns[0].position.truncate();
            assert!((origin + offset(&set, e)).length() < 1e-6, "{origin}");
        }
        let [a, b] = [rough, finish].map(|e| e.tips.bounds());
        assert!(b.min.x - a.max.x >= asked.family_spacing_mm - 1e-9, "{} {}", b.min.x, a.max.x);
        // The datum is the middle of both, and the base holds both with its margin.
        let size = rough.bounds().size();
        assert!(size.x >= b.max.x - a.min.x + 2.0 * asked.base_margin_mm && size.cmple(rough.blank + 1e-9).all());
    }
}

#[test]
fn a_family_that_would_enter_the_mold_or_outgrow_the_holders_stands_apart_and_says_so() {
    let (wide, slot) = slotted([60.0, 60.0, 10.0]);
    for (side, why) in [(25.0, "enter the mold"), (10.0, "no holder")] {
        let asked = ElectrodeParams { holders: vec![holder(side)], ..stages(0.2, true) };
        let set = planned(&wide, std::slice::from_ref(&slot), &asked);
        assert!(set.holds() && set.electrodes.len() == 2, "{:?}", set.checks);
        for electrode in &set.electrodes {
            let Family::Apart { why: said } = &electrode.family else { panic!("{:?}", electrode.family) };
            assert!(said.contains(why), "{said}");
            assert!(electrode.burns[0].position.truncate().length() < 1e-6 && electrode.others.triangles.is_empty());
        }
    }
    // Not asked for, there is nothing to be said.
    let set = planned(&wide, &[slot], &stages(0.2, false));
    assert!(set.electrodes.iter().all(|e| e.family == Family::None));
}

#[test]
fn a_member_of_a_family_that_fails_takes_the_body_with_it() {
    let (mold, slot) = slotted([8.0, 6.0, 10.0]);
    let mut set = planned(&mold, &[slot], &stages(0.2, true));
    set.checks[0][0].holds = false;
    assert!(set.is_blocked(0) && set.is_blocked(1) && set.fails(0) && !set.fails(1));
    let decided = set.override_of(0, set.checks[0].iter().find(|f| !f.holds).unwrap().kind);
    set.params.overrides.push(decided);
    assert!(!set.is_blocked(0) && !set.is_blocked(1));
}

#[test]
fn a_roughing_tip_keeps_its_thick_part_and_the_finishing_one_burns_the_rest() {
    // A bar of 8 by 2 with a leg of 0.8.
    let outline =
        [(-4.0, -1.0), (4.0, -1.0), (4.0, 1.0), (0.4, 1.0), (0.4, 5.0), (-0.4, 5.0), (-0.4, 1.0), (-4.0, 1.0)];
    let mold = mold([30.0, 30.0, 10.0], &[(&ring(&outline), 4.0)]);
    let all = RegionToBurn { volume: 76.8, ..region(&mold, DVec2::new(-4.1, -1.1), DVec2::new(4.1, 5.1)) };
    let set = planned(&mold, std::slice::from_ref(&all), &stages(0.3, false));
    assert!(set.holds(), "{:?} {:?}", set.checks, set.regions[0].reason);
    let [left] = &set.regions[0].left_out[..] else { panic!("{:?}", set.regions[0].left_out) };
    assert!(left.stage == 0 && left.text.contains("thinner than the least size"), "{left:?}");
    let rough: Vec<_> = set.electrodes.iter().filter(|e| e.stage == 0).collect();
    assert!(rough.len() == 1 && !rough[0].is_thin);
    let tip = rough[0].burning(&rough[0].tips, &rough[0].burns[0], &DMat3::IDENTITY);
    let in_mold = difference(&tip, &prism(&[&rectangle(50.0, 50.0)], 0.0, 90.0).unwrap()).unwrap().volume();
    let bar = (8.0 - 0.6) * (2.0 - 0.6) * (4.0 - 0.3);
    assert!((in_mold / bar - 1.0).abs() < 1e-3, "{in_mold} {bar}");
    // The stages together take all, and the leg is the finishing stage's.
    let taken = |stage: usize| -> f64 {
        set.electrodes.iter().filter(|e| e.stage == stage).flat_map(|e| &e.burns).map(|b| b.volume).sum()
    };
    assert!((taken(0) + taken(1) - all.volume).abs() < 1e-6 * all.volume, "{} {}", taken(0), taken(1));
    // Of a stage without anything thin in its way nothing is said.
    let small = planned(&mold, &[all], &stages(0.1, false));
    assert!(small.holds() && small.regions[0].left_out.is_empty(), "{:?}", small.regions[0].left_out);
    assert!(small.electrodes.iter().all(|e| e.bounds().size().cmpgt(DVec3::ZERO).all()));
}

#[test]
fn a_stage_that_is_too_thin_or_has_no_room_is_left_out_and_the_last_one_is_not() {
    let mold = mold([30.0, 20.0, 10.0], &[(&rectangle(8.0, 0.8), 5.0)]);
    let slot = RegionToBurn { volume: 32.0, ..region(&mold, DVec2::new(-4.1, -0.5), DVec2::new(4.1, 0.5)) };
    // 0.28 mm are less than the least size of 0.3 by less than is known.
    for (gap, why, is_close) in [
        (0.3, "thinner than the least size", false),
        (0.26, "thinner than the least size", true),
        (0.45, "spark gap is too large", false),
    ] {
        let set = planned(&mold, std::slice::from_ref(&slot), &stages(gap, false));
        assert!(set.holds(), "{:?} {:?}", set.checks, set.regions[0].reason);
        let [finish] = &set.electrodes[..] else { panic!("{}", set.electrodes.len()) };
        assert!(finish.stage == 1 && (finish.burns[0].volume - 32.0).abs() < 1e-9);
        let [left] = &set.regions[0].left_out[..] else { panic!("{:?}", set.regions[0].left_out) };
        assert!(left.text.contains(why) && left.text.contains("places alike") == is_close, "{left:?}");
    }
    let alone = planned(&mold, &[slot], &params(0.3));
    assert!(alone.electrodes.len() == 1 && alone.fails(0) && alone.regions[0].left_out.is_empty());
}
