//! Electrodes of molds that nobody drew.

use mold::random_mold::random_mold;
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

#[test]
#[ignore = "takes a quarter of an hour"]
fn two_hundred_molds_of_every_kind_end_in_electrodes_or_in_physical_reasons() {
    let numbers = std::env::var("MOLDS").ok().and_then(|text| {
        let (from, to) = text.split_once("..")?;
        Some(from.parse().ok()?..to.parse().ok()?)
    });
    campaign(numbers.unwrap_or(0..200));
}
