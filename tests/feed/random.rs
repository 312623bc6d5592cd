//! Blisks at random: where the searches of the papers find a way, the global one does.

use super::*;
use feed::plan_params::Strategy;
use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use std::ops::Range;

/// A blisk that can be made, of some 20 to 60 blades with channels of 10 to 20 mm depth.
fn random_blisk(rng: &mut ChaCha8Rng) -> (ParametricBlisk, Mesh) {
    loop {
        let mut within = |least: f64, most: f64| rng.random_range(least..most);
        let (hub, chord) = (within(60.0, 120.0), within(12.0, 26.0));
        let blisk = ParametricBlisk {
            blades: within(20.0, 64.0) as usize,
            hub_radius_mm: hub,
            shroud_radius_mm: hub + within(10.0, 20.0),
            hub_slope: within(-0.1, 0.2),
            shroud_slope: within(-0.1, 0.2),
            bore_radius_mm: 0.5 * hub,
            width_mm: chord + 6.0,
            chord_mm: chord,
            beta_in_deg: within(5.0, 50.0),
            beta_out_deg: within(-50.0, -5.0),
            twist_deg: within(-8.0, 8.0),
            lean_deg: within(-6.0, 6.0),
            taper: within(0.0, 0.15),
            max_thickness_mm: within(2.0, 5.0),
            ..Default::default()
        };
        if let Ok(mesh) = blisk.mesh(&MeshResolution::default()) {
            return (blisk, mesh);
        }
    }
}

/// How many of the blisks with these seeds the global search found a way for. Where it finds none, no other search may: they are
/// tried there only.
fn ways_found(seeds: Range<u64>) -> usize {
    let mut found = 0;
    for seed in seeds {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let (blisk, mesh) = random_blisk(&mut rng);
        let mut job = PlanJob::demonstration();
        let pitch_deg = 360.0 / blisk.blades as f64;
        let reduction = pitch_deg * rng.random_range(0.12..0.32);
        job.electrode.circumferential_reduction_deg = [reduction; 2];
        job.electrode.enter = if rng.random() { EnterSide::MinusX } else { EnterSide::PlusX };
        let mut inputs = PlanInputs { blisk: mesh.into(), own_electrode: None, job };
        let task = Task::default();
        let ready = prepare(&inputs, &task).unwrap();
        let mut finds = |strategy: Strategy| {
            inputs.job.plan.strategy = strategy;
            match run_feeds(&ready, &inputs, &task) {
                Ok(outcome) => outcome.is_verified(),
                // No electrode can be made at all, which is the same for every strategy.
                Err(PlanJobError::Electrode(_)) => false,
                Err(other) => panic!("blisk {seed}, {strategy:?}: {other}"),
            }
        };
        let global = finds(Strategy::Global);
        let others = [Strategy::Genetic, Strategy::Centreline].map(|other| !global && finds(other));
        println!("blisk {seed}: {reduction:.3} of {pitch_deg:.2} deg: global {global}, others where not {others:?}");
        assert_eq!(others, [false; 2], "genetic, centreline on blisk {seed}, {reduction} deg: {blisk:?}");
        found += usize::from(global);
    }
    found
}

#[test]
fn the_global_search_finds_a_way_wherever_another_does() {
    assert_eq!(ways_found(0..1), 1);
}

#[test]
#[ignore = "takes a quarter of an hour"]
fn the_global_search_finds_a_way_wherever_another_does_on_fifty_blisks_the_first_half() {
    let found = ways_found(0..25);
    println!("ways for {found} of 25");
    assert!(found > 5, "{found}");
}

#[test]
#[ignore = "takes a quarter of an hour"]
fn the_global_search_finds_a_way_wherever_another_does_on_fifty_blisks_the_second_half() {
    let found = ways_found(25..50);
    println!("ways for {found} of 25");
    assert!(found > 5, "{found}");
}
