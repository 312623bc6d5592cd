//! Electrodes of molds that nobody drew.

use super::heights::{Bound, Heights, Left, Tool};
use geometry::mesh::Bounds;
use mold::random_mold::random_mold;
use mold::uncut_region::UncutRegion;
use task::Cancel;

/// Electrodes of a mold: how many there are, how many are not exported, and of how many regions a part has none.
#[derive(Debug, Clone, Copy)]
struct Came {
    electrodes: usize,
    blocked: usize,
    without: usize,
}

/// Plans the electrodes of a mold and asserts that nothing but a physical reason keeps them back.
fn planned(number: u64) -> Came {
    use mold::electrode::finding::CheckKind;
    use sparkpath::workspaces::mold::job::{electrodes::electrodes, uncut::UncutParams, uncut::uncut};
    let (mesh, opening) = random_mold(number, &Cancel::default()).unwrap_or_else(|e| panic!("mold {number}: {e}"));
    assert!(mesh.is_watertight(), "mold {number}");
    let params = UncutParams { opening, ..UncutParams::of(super::library("flat:1,flat:2,flat:5,ball:1,ball:3")) };
    let task = task::Task::default();
    let left = uncut(&mesh, &params, &task).unwrap_or_else(|error| panic!("mold {number}: {error}"));
    let stages = vec![mold::electrode::params::Stage::finish(0.05)];
    let params = mold::electrode::params::ElectrodeParams { stages, ..Default::default() };
    let set = electrodes(&mesh, &left, &params, &task).unwrap_or_else(|error| panic!("mold {number}: {error}"));
    let failing: Vec<_> = set.checks.iter().flatten().filter(|finding| !finding.holds).collect();
    for finding in &failing {
        let is_physical = matches!(finding.kind, CheckKind::Machinable | CheckKind::ResidualStock);
        assert!(is_physical, "mold {number}: {}", finding.text);
    }
    let reasons = set.regions.iter().filter_map(|region| region.reason.as_deref());
    for said in reasons.chain(failing.iter().map(|finding| &finding.text[..])) {
        let own = ["boolean", "solid", "offset", "layer", "does not close", "closed surface"];
        assert!(!own.iter().any(|word| said.contains(word)), "mold {number}: {said}");
        println!("mold {number}: {said}");
    }
    let blocked = (0..set.electrodes.len()).filter(|e| set.is_blocked(*e)).count();
    Came { electrodes: set.electrodes.len(), blocked, without: set.without_electrode().len() }
}

fn campaign(numbers: std::ops::Range<u64>) {
    let count = numbers.end - numbers.start;
    let came: Vec<Came> = numbers.map(planned).collect();
    let sum = |of: fn(&Came) -> usize| came.iter().map(of).sum::<usize>();
    let (electrodes, blocked) = (sum(|c| c.electrodes), sum(|c| c.blocked));
    println!("{count} molds: {electrodes} electrodes, {blocked} blocked, {} regions without", sum(|c| c.without));
    assert!(electrodes > blocked, "{blocked} of {electrodes}");
}

#[test]
fn molds_of_every_kind_end_in_electrodes_or_in_physical_reasons() {
    campaign(1..7);
}

/// The molds that `MOLDS=FROM..TO` names, or those of `own`.
fn molds(own: std::ops::Range<u64>) -> std::ops::Range<u64> {
    let named = std::env::var("MOLDS").ok().and_then(|text| {
        let (from, to) = text.split_once("..")?;
        Some(from.parse().ok()?..to.parse().ok()?)
    });
    named.unwrap_or(own)
}

#[test]
#[ignore = "takes a quarter of an hour"]
fn two_hundred_molds_of_every_kind_end_in_electrodes_or_in_physical_reasons() {
    campaign(molds(0..200));
}

/// Volume up to which two ways may differ: that of films as thin as the tolerance, which one counts and the other does not (mm^3).
const SLACK_MM3: f64 = 0.05;
/// Height from which on stock is more than such a film (mm).
const THICK_MM: f64 = 0.1;

/// Libraries of which each mold has one, by its number.
const LIBRARIES: [(&str, &[Tool]); 4] = [
    ("flat:1", &[Tool { radius: 1.0, corner: 0.0 }]),
    ("ball:1", &[Tool { radius: 1.0, corner: 1.0 }]),
    ("flat:1,ball:1", &[Tool { radius: 1.0, corner: 0.0 }, Tool { radius: 1.0, corner: 1.0 }]),
    ("bull:1.2:0.5", &[Tool { radius: 1.2, corner: 0.5 }]),
];

/// Finds what is left of a mold and compares it with heights by rays: the volume lies between what is certainly left and what
/// may be; of what is certainly left thicker than some grids can tell, all lies in regions; every region holds what may be left.
fn agrees(number: u64, step: f64) {
    use sparkpath::workspaces::mold::job::{uncut::UncutParams, uncut::uncut};
    let (mesh, opening) = random_mold(number, &Cancel::default()).unwrap_or_else(|e| panic!("mold {number}: {e}"));
    let (library, tools) = LIBRARIES[number as usize % LIBRARIES.len()];
    let params = UncutParams { opening, ..UncutParams::of(super::library(library)) };
    let found = uncut(&mesh, &params, &task::Task::default()).unwrap_or_else(|error| panic!("mold {number}: {error}"));
    let heights = Heights::new(&opening.upright_mesh(&mesh), step, 1.2);
    let surely = heights.left(tools, Bound::Least, params.tolerance_mm);
    let perhaps = heights.left(tools, Bound::Most, params.tolerance_mm);
    let (least, most) = (heights.volume(&surely, Bound::Least), heights.volume(&perhaps, Bound::Most));
    let volume = found.found().volume_mm3;
    println!("mold {number}, {library}: {volume:.3} mm3 for {least:.3} to {most:.3}");
    assert!(least - SLACK_MM3 < volume && volume < most + SLACK_MM3, "mold {number}, {library}");
    let holds = |region: &UncutRegion, left: &Left| {
        let Bounds { min, max } = region.bounds;
        left.middle.cmpgt(min - 2.0 * step).all() && left.middle.cmplt(max + 2.0 * step).all()
    };
    let missed = surely.iter().filter(|left| left.height > THICK_MM && !found.regions.iter().any(|r| holds(r, left)));
    let missed: Vec<Left> = missed.copied().collect();
    assert!(
        heights.volume(&missed, Bound::Least) < SLACK_MM3,
        "mold {number}, {library}: {} places as {:?}",
        missed.len(),
        missed[0]
    );
    for region in found.regions.iter().filter(|region| region.volume > SLACK_MM3) {
        assert!(perhaps.iter().any(|left| holds(region, left)), "mold {number}, {library}: {:?}", region.bounds);
    }
}

#[test]
fn what_is_left_of_molds_agrees_with_heights_by_rays() {
    molds(0..2).for_each(|number| agrees(number, 0.08));
}

#[test]
#[ignore = "takes a quarter of an hour"]
fn what_is_left_of_three_hundred_molds_agrees_with_heights_by_rays() {
    molds(0..300).for_each(|number| agrees(number, 0.03));
}
