//! Electrodes as the user arranges them.

use glam::{DVec2, DVec3};

use super::design::ElectrodeSet;
use super::given::{Given, GivenName};
use super::params::{Edit, ElectrodeParams, Holder, Repeat};
use super::setting::RegionToBurn;
use super::tests::{GAP, mold, params, planned, region};
use crate::fixtures::rectangle;
use geometry::mesh::Mesh;

/// Slots of these sides at these places, 4 mm deep, each with its region.
fn slots(all: &[([f64; 2], [f64; 2])]) -> (Mesh, Vec<RegionToBurn>) {
    let outline = |([x, y], [w, d]): &([f64; 2], [f64; 2])| -> Vec<DVec2> {
        rectangle(*w, *d).iter().map(|p| *p + DVec2::new(*x, *y)).collect()
    };
    let outlines: Vec<Vec<DVec2>> = all.iter().map(outline).collect();
    let hollows: Vec<(&[DVec2], f64)> = outlines.iter().map(|o| (&o[..], 4.0)).collect();
    let mesh = mold([60.0, 60.0, 10.0], &hollows);
    let of = |([x, y], [w, d]): &([f64; 2], [f64; 2])| {
        let (middle, half) = (DVec2::new(*x, *y), 0.5 * DVec2::new(*w, *d) + 0.1);
        region(&mesh, middle - half, middle + half)
    };
    let regions = all.iter().map(of).collect();
    (mesh, regions)
}

fn at(x: f64, y: f64) -> DVec3 {
    DVec3::new(x, y, -4.0)
}

/// Of each electrode the number of parts of each burn.
fn burned(set: &ElectrodeSet) -> Vec<Vec<usize>> {
    let mut all: Vec<Vec<usize>> =
        set.electrodes.iter().map(|e| e.burns.iter().map(|burn| burn.parts.len()).collect()).collect();
    all.sort();
    all
}

fn with(edits: Vec<Edit>) -> ElectrodeParams {
    ElectrodeParams { edits, ..params(GAP) }
}

#[test]
fn heads_of_any_regions_are_joined_on_one_base_and_taken_apart() {
    let (mold, regions) = slots(&[([-20.0, 0.0], [8.0, 0.8]), ([0.0, 0.0], [6.0, 1.2]), ([20.0, 0.0], [8.0, 0.8])]);
    let set = planned(&mold, &regions, &params(GAP));
    assert_eq!(burned(&set), [vec![1], vec![1, 1]], "those of one shape share an electrode");
    let join = Edit::Join { places: [at(-20.0, 0.0), at(0.0, 0.0)] };
    let set = planned(&mold, &regions, &with(vec![join]));
    assert!(set.holds() && set.unmet_edits().is_empty(), "{:?}", set.checks);
    assert_eq!(burned(&set), [vec![1], vec![2]]);
    let apart = Edit::TakeApart { place: at(20.0, 0.0) };
    let set = planned(&mold, &regions, &with(vec![apart]));
    assert!(set.holds() && set.unmet_edits().is_empty());
    assert_eq!(burned(&set), [vec![1], vec![1], vec![1]]);
    let nowhere = Edit::Join { places: [at(-20.0, 0.0), at(0.0, 20.0)] };
    assert_eq!(planned(&mold, &regions, &with(vec![nowhere])).unmet_edits(), [0]);
}

#[test]
fn places_of_one_shape_go_on_sharing_an_electrode_when_the_first_of_them_is_joined_to_another() {
    let (mold, regions) = slots(&[
        ([-20.0, 0.0], [8.0, 0.8]),
        ([0.0, 0.0], [6.0, 1.2]),
        ([20.0, 0.0], [8.0, 0.8]),
        ([0.0, 8.0], [8.0, 0.8]),
    ]);
    for first in [at(-20.0, 0.0), at(20.0, 0.0), at(0.0, 8.0)] {
        let join = Edit::Join { places: [first, at(0.0, 0.0)] };
        let set = planned(&mold, &regions, &with(vec![join]));
        assert!(set.holds() && set.unmet_edits().is_empty(), "{:?}", set.checks);
        let mut burned = burned(&set);
        burned.sort();
        assert_eq!(burned, [vec![1, 1], vec![2]], "{first:?}");
    }
}

#[test]
fn an_electrode_of_several_heads_is_copied_to_another_cavity() {
    let shapes = |x: f64| [([x, 0.0], [8.0, 0.8]), ([x, 5.0], [6.0, 1.2])];
    let (mold, regions) = slots(&[shapes(-15.0), shapes(15.0)].concat());
    let join = Edit::Join { places: [at(-15.0, 0.0), at(-15.0, 5.0)] };
    let copy = Edit::Copy { places: [at(-15.0, 0.0), at(15.0, 0.0)] };
    let set = planned(&mold, &regions, &with(vec![join, copy]));
    assert!(set.holds() && set.unmet_edits().is_empty(), "{:?} {:?}", set.checks, set.unmet_edits());
    assert_eq!(burned(&set), [vec![2, 2]]);
    let [one, two] = &set.electrodes[0].burns[..] else { panic!() };
    assert!((two.position - one.position).distance(30.0 * DVec3::X) < 1e-3, "{}", two.position - one.position);
    // A place of another shape is not burned by it.
    let wrong = Edit::Copy { places: [at(-15.0, 0.0), at(15.0, 5.0)] };
    assert_eq!(planned(&mold, &regions, &with(vec![join, wrong])).unmet_edits(), [1]);
}

#[test]
fn places_of_one_shape_are_burned_by_one_head_or_by_several_and_the_other_way_is_told() {
    let (mold, regions) = slots(&[([0.0, 0.0], [8.0, 0.8]), ([0.0, 6.0], [8.0, 0.8])]);
    // A rate on an area that no head has: several heads at once burn faster than one after another.
    let table = "[[technology]]\nid = \"steel-copper\"\nsource = \"test\"\nbasis = \"assumed\"\n\
                 electrode_material = \"copper\"\nworkpiece = \"steel\"\n[[technology.step]]\nname = \"S\"\n\
                 vdi = 20.0\nrate_mm3_min = 2.0\nat_area_mm2 = 100.0\n";
    let table = burning::technology::TECHNOLOGY_FILE.parse(table, std::path::Path::new("t.toml")).unwrap();
    let timed = |params: &ElectrodeParams| planned(&mold, &regions, params).timed(Ok(&table));
    let one = timed(&params(GAP));
    let several = timed(&ElectrodeParams { repeat: Repeat::Heads, ..params(GAP) });
    assert!(one.holds() && several.holds());
    assert_eq!((burned(&one), burned(&several)), (vec![vec![1, 1]], vec![vec![2]]));
    let [one, several] = [one, several].map(|set| set.electrodes[0].clone());
    let [way, back] = [&one, &several].map(|electrode| electrode.other_way.as_ref().unwrap());
    let mean = |minutes: Option<burning::duration::Spread>| minutes.unwrap().mean;
    let [of_one, of_several] = [&one, &several].map(|electrode| mean(electrode.figures.minutes));
    assert!((mean(way.minutes) - of_several).abs() < 1e-9 && way.blank == several.blank, "{way:?} {of_several}");
    assert!((mean(back.minutes) - of_one).abs() < 1e-9 && back.blank == one.blank, "{back:?} {of_one}");
    // The rate grows with the power 0.437 of the area.
    assert!((of_one / of_several - 2f64.powf(0.437)).abs() < 1e-6, "{of_one} {of_several}");
    assert!(back.is_of_burns() && !way.is_of_burns());
}

#[test]
fn several_heads_that_stand_alike_in_two_cavities_are_one_electrode() {
    let pair = |x: f64| [([x, 0.0], [8.0, 0.8]), ([x, 6.0], [8.0, 0.8])];
    let (mold, regions) = slots(&[pair(-15.0), pair(15.0)].concat());
    let heads = ElectrodeParams { repeat: Repeat::Heads, ..params(GAP) };
    let set = planned(&mold, &regions, &heads);
    assert!(set.holds(), "{:?}", set.checks);
    assert_eq!(burned(&set), [vec![2, 2]]);
    let [one, two] = &set.electrodes[0].burns[..] else { panic!() };
    let way = two.position - one.position;
    // Each slot is its own copy turned by half a turn, so that either pair may stand either way round.
    assert!((way.x.abs() - 30.0).abs() < 1e-3 && way.z.abs() < 1e-3, "{way}");
    let way = set.electrodes[0].other_way.as_ref().unwrap();
    assert_eq!((way.at_once.len(), way.is_of_burns()), (4, true));
    // A third slot beside one of the pairs makes it another set.
    let (mold, regions) = slots(&[&pair(-15.0)[..], &pair(15.0), &[([15.0, 12.0], [8.0, 0.8])]].concat());
    assert_eq!(burned(&planned(&mold, &regions, &ElectrodeParams { together_mm: 20.0, ..heads })), [vec![2], vec![3]]);
}

#[test]
fn overrides_follow_a_new_name_of_their_electrode_in_every_stage() {
    let mut own = params(GAP);
    own.names = vec![GivenName { number: 1, ..GivenName::default() }, GivenName { number: 10, ..GivenName::default() }];
    let stage = own.stages[0].name.clone();
    let texts =
        ["E01:gouge".to_owned(), format!("E01-{stage}:leftover"), "E010:gouge".to_owned(), "E10:gouge".to_owned()];
    own.overrides = texts.iter().map(|text| text.parse().unwrap()).collect();
    let of = |own: &ElectrodeParams| -> Vec<String> { own.overrides.iter().map(|one| one.of.clone()).collect() };
    let named = |name: &str| Given { name: Some(name.to_owned()), ..Given::default() };
    own.give(0, named("rib"));
    assert_eq!(of(&own), ["rib".to_owned(), format!("rib-{stage}"), "E010".to_owned(), "E10".to_owned()]);
    own.give(0, Given { number: Some(7), ..Given::default() });
    assert_eq!(of(&own)[..2], ["E07".to_owned(), format!("E07-{stage}")]);
    // The name of another electrode is not taken, nor its overrides mixed with these.
    own.give(0, named("e10"));
    assert_eq!(of(&own)[..2], ["E07".to_owned(), format!("E07-{stage}")]);
    own.give(0, Given { number: Some(7), ..Given::default() });
    own.give(0, Given::default());
    assert_eq!(of(&own)[..2], ["E01".to_owned(), format!("E01-{stage}")]);
}

#[test]
fn an_electrode_has_the_name_holder_blank_and_material_that_it_is_given() {
    let (mold, regions) = slots(&[([0.0, 0.0], [8.0, 0.8])]);
    let holder = |name: &str, side: f64| Holder { name: name.to_owned(), size_mm: [side; 2], height_mm: 10.0 };
    let holders = vec![holder("small", 20.0), holder("large", 50.0)];
    let common = ElectrodeParams { holders, ..params(GAP) };
    let plain = planned(&mold, &regions, &common);
    assert_eq!(plain.electrodes[0].holder, Some(0));
    let given = |given: Given| {
        let names = vec![GivenName { given, ..plain.names[0].clone() }];
        planned(&mold, &regions, &ElectrodeParams { names, ..common.clone() }).electrodes[0].clone()
    };
    let own = given(Given {
        number: Some(7),
        name: Some("slot-A".to_owned()),
        holder: Some("large".to_owned()),
        blank_mm: Some([18.0, 14.0]),
        material: Some("graphite".to_owned()),
    });
    assert_eq!((&own.name[..], own.material(&common), own.holder, own.number), ("slot-A", "graphite", Some(1), 1));
    assert_eq!((own.blank.x, own.blank.y), (18.0, 14.0));
    let size = own.mesh.bounds().size();
    assert!((size.truncate() - DVec2::new(18.0, 14.0)).length() < 1e-9 && own.unmet.is_empty(), "{size}");
    let renumbered = given(Given { number: Some(7), ..Given::default() });
    assert_eq!((&renumbered.name[..], renumbered.number), ("E07", 1), "it stays the one with number 1");
    let too_small = given(Given { blank_mm: Some([8.0, 5.0]), ..Given::default() });
    assert!(too_small.unmet[0].contains("too small") && too_small.blank == plain.electrodes[0].blank);
    let too_large = given(Given { holder: Some("small".into()), blank_mm: Some([30.0, 30.0]), ..Given::default() });
    assert!(too_large.unmet[0].contains("too large for the holder") && too_large.holder == Some(1));
}

#[test]
fn no_two_electrodes_have_one_name() {
    let (mold, regions) = slots(&[([-20.0, 0.0], [8.0, 0.8]), ([20.0, 0.0], [6.0, 1.2])]);
    let plain = planned(&mold, &regions, &params(GAP));
    let named = |given: [Given; 2]| {
        let names = plain.names.iter().zip(given).map(|(name, given)| GivenName { given, ..name.clone() }).collect();
        let set = planned(&mold, &regions, &ElectrodeParams { names, ..params(GAP) });
        set.electrodes.iter().map(|e| (e.name.clone(), e.unmet.len())).collect::<Vec<_>>()
    };
    let name = |name: &str| Given { name: Some(name.to_owned()), ..Given::default() };
    assert_eq!(named([name("rib"), name("Rib")]), [("rib".to_owned(), 0), ("E02".to_owned(), 1)]);
    let second = Given { number: Some(2), ..Given::default() };
    assert_eq!(named([second, Given::default()]), [("E01".to_owned(), 1), ("E02".to_owned(), 0)]);
    // Numbers can be exchanged.
    let [one, two] = [1, 2].map(|number| Given { number: Some(number), ..Given::default() });
    assert_eq!(named([two, one]), [("E02".to_owned(), 0), ("E01".to_owned(), 0)]);
}

#[test]
fn an_automatic_group_is_joined_and_copied_as_a_whole_and_later_changes_prevail() {
    let near = |x: f64| [([x, 0.0], [6.0, 0.8]), ([x, 4.0], [5.0, 1.2])];
    let (mold, regions) = slots(&[near(-18.0), near(18.0)].concat());
    let apart = ElectrodeParams { share: false, ..params(GAP) };
    let with = |edits: Vec<Edit>| planned(&mold, &regions, &ElectrodeParams { edits, ..apart.clone() });
    assert_eq!(burned(&with(Vec::new())), [vec![2], vec![2]]);
    let copy = Edit::Copy { places: [at(-18.0, 0.0), at(18.0, 0.0)] };
    let set = with(vec![copy]);
    assert_eq!((burned(&set), set.unmet_edits()), (vec![vec![2, 2]], Vec::new()));
    let join = Edit::Join { places: [at(-18.0, 0.0), at(18.0, 4.0)] };
    assert_eq!(burned(&with(vec![join])), [vec![4]]);
    let take = Edit::TakeApart { place: at(18.0, 4.0) };
    assert_eq!(burned(&with(vec![join, take])), [vec![1], vec![1], vec![2]]);
    assert_eq!(burned(&with(vec![take, join])), [vec![1], vec![3]]);
}
