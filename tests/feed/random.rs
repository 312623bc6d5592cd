//! Blisks and wheels at random: where the searches of the papers find a way, the global one does, and no sample of a
//! certified path comes nearer than its certificate says.

use super::*;
use feed::plan_params::Strategy;
use geometry::inside::guarded_distance;
use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use sparkpath::workspaces::blisk::job::outcome::ElectrodeOutcome;
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

/// Strategies that are tried where the global search finds no way.
const OTHERS: [Strategy; 2] = [Strategy::Genetic, Strategy::Centreline];

/// What a plan of a wheel came to.
#[derive(Debug, Default, Clone, Copy, PartialEq)]
struct Came {
    /// Whether an electrode can be made.
    made: bool,
    /// Whether the global search finds a certified path.
    out: bool,
}

/// Plans one electrode of a wheel and compares samples of its path with the certificate. Where the global search finds no
/// path none of the `others` may; they are tried there only.
fn planned(name: &str, mesh: Mesh, job: PlanJob, others: &[Strategy]) -> Came {
    let mut inputs = PlanInputs::of(mesh, job);
    let task = Task::default();
    let ready = match prepare(&inputs, &task) {
        Ok(ready) => ready,
        Err(PlanJobError::Electrode(why)) => {
            println!("{name}: no electrode: {why}");
            return Came::default();
        }
        Err(other) => panic!("{name}: {other}"),
    };
    let plan = |strategy: Strategy, inputs: &mut PlanInputs| {
        inputs.job.plan.strategy = strategy;
        match run_feeds(&ready, inputs, &task) {
            Ok(outcome) => Some(outcome),
            // No electrode can be made at all, which is the same for every strategy.
            Err(PlanJobError::Electrode(why)) => {
                println!("{name}: no electrode: {why}");
                None
            }
            Err(other) => panic!("{name}, {strategy:?}: {other}"),
        }
    };
    let Some(outcome) = plan(Strategy::Global, &mut inputs) else { return Came::default() };
    let came = Came { made: true, out: outcome.is_verified() };
    println!(
        "{name}: towards {}: {}",
        outcome.electrodes[0].electrode.enters_from.words(),
        outcome.electrodes[0].plan.verdict(&outcome.channel)
    );
    if came.out {
        samples_keep_the_certificate(name, &ready, &outcome);
    } else {
        for other in others {
            let found = plan(*other, &mut inputs).is_some_and(|outcome| outcome.is_verified());
            assert!(!found, "{other:?} on {name}: {:?}", inputs.job.electrode);
        }
    }
    came
}

/// Points of the electrode at poses along the path: none is nearer to the blisk than is certified.
fn samples_keep_the_certificate(name: &str, ready: &PreparedBlisk, outcome: &PlanOutcome) {
    let ElectrodeOutcome { electrode, plan, .. } = &outcome.electrodes[0];
    let planned = plan.path.as_ref().unwrap();
    let blisk = ExactMesh::new(ready.blisk()).unwrap();
    let certified = planned.certificate.certified();
    let places: Vec<DVec3> = electrode.mesh.iter_corners().flat_map(|[a, b, c]| [a, (a + b + c) / 3.0]).collect();
    let mut pick = wheel::parametric::random::shares(places.len() as u64);
    for rows in planned.path.rows.windows(2) {
        for _ in 0..40 {
            let place = places[((pick() * places.len() as f64) as usize).min(places.len() - 1)];
            let pose = rows[0].pose.lerp(&rows[1].pose, pick());
            let at = pose.placement(electrode.reference_point).transform_point3(place);
            let distance = guarded_distance(&blisk, at);
            assert!(distance >= certified - 1e-9, "{name}: {distance} for {certified} at s = {}", rows[0].s);
        }
    }
}

/// How many of the blisks with these seeds the global search found a way for.
fn ways_found(seeds: Range<u64>) -> usize {
    let one = |seed: u64| {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let (blisk, mesh) = random_blisk(&mut rng);
        let mut job = PlanJob::demonstration();
        let pitch_deg = 360.0 / blisk.blades as f64;
        let reduction = pitch_deg * rng.random_range(0.12..0.32);
        job.electrode.circumferential_reduction_deg = [reduction; 2];
        job.electrode.enter = if rng.random() { EnterSide::MinusX } else { EnterSide::PlusX };
        planned(&format!("blisk {seed}, {reduction:.3} of {pitch_deg:.2} deg"), mesh, job, &OTHERS)
    };
    seeds.map(one).filter(|came| came.out).count()
}

/// Wheels of every kind: what became of each.
fn wheels_planned(numbers: Range<usize>, others: &[Strategy]) -> Vec<Came> {
    let one = |number: usize| {
        let mut share = wheel::parametric::random::shares(number as u64);
        let (wheel, flow) = wheel::parametric::random::random_wheel(number, &mut share);
        let mut job = PlanJob::demonstration();
        let reduction = wheel.pitch().to_degrees() * (0.05 + 0.2 * share());
        job.electrode.circumferential_reduction_deg = [reduction; 2];
        job.electrode.radial_reduction_mm = 0.5 + 2.0 * share();
        job.electrode.enter = EnterSide::Auto;
        (job.plan.step_mm, job.plan.field_cell_mm) = (1.5, 0.6);
        // Where no pose of a node is free, all generations come to nothing.
        job.genetic.stall_generations = 10;
        let name = format!("wheel {number}, {}, {reduction:.2} deg", flow.name());
        planned(&name, wheel.mesh(), job, others)
    };
    numbers.map(one).collect()
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

/// The wheels that `WHEELS=FROM..TO` names, or those of `own`.
fn wheels(own: Range<usize>) -> Range<usize> {
    let named = std::env::var("WHEELS").ok().and_then(|text| {
        let (from, to) = text.split_once("..")?;
        Some(from.parse().ok()?..to.parse().ok()?)
    });
    named.unwrap_or(own)
}

/// Plans wheels; most of them have electrodes, and some of these a path.
fn most_have_electrodes(numbers: Range<usize>, others: &[Strategy]) {
    let came = wheels_planned(numbers, others);
    let [made, out] = [|c: &&Came| c.made, |c: &&Came| c.out].map(|is| came.iter().filter(is).count());
    println!("{made} electrodes and {out} paths of {} wheels", came.len());
    assert!(2 * made > came.len() && out > 0);
}

#[test]
#[ignore = "takes a quarter of an hour"]
fn the_global_search_finds_a_way_wherever_another_does_on_wheels_of_every_kind() {
    most_have_electrodes(wheels(0..30), &OTHERS);
}

#[test]
#[ignore = "takes hours"]
fn no_sample_of_a_thousand_wheels_contradicts_a_certificate() {
    most_have_electrodes(wheels(0..1000), &[]);
}
