//! Plans on the machines that the program brings along.

use super::common::{easy_blisk, mesh};
use super::{easy_job, plan};
use sparkpath::feed::machine::MachineParams;
use sparkpath::feed::search::Strategy;
use sparkpath::feed::simulation::{Scenario, Simulation, SimulationOptions, simulate};
use sparkpath::jobs::plan::PlanOutcome;
use sparkpath::progress::{Cancel, Progress};
use sparkpath::project::machine_file::{BUILT_IN, machine_table, read_machine};

fn machine(name: &str) -> MachineParams {
    let params: MachineParams = toml::Value::Table(machine_table(name).unwrap()).try_into().unwrap();
    MachineParams { name: name.to_owned(), ..params }
}

fn simulated(outcome: &PlanOutcome, machine: &MachineParams, channels: Vec<usize>) -> Simulation {
    let blisk = mesh(&easy_blisk()).in_frame(&outcome.channel.frame);
    let electrode = &outcome.electrodes[0];
    let planned = electrode.plan.path.as_ref().unwrap();
    let never = Cancel::default();
    let scenario = Scenario {
        blisk: &blisk,
        channels: outcome.channel.blades,
        own_channel: outcome.channel.index,
        electrode: &electrode.electrode,
        feed: (&planned.path, &planned.certificate),
        copying: None,
        machine,
        model: &read_machine(&machine.name, &Progress::silent(), &never).unwrap(),
    };
    simulate(&scenario, &SimulationOptions::of(channels), &Progress::silent(), &never).unwrap()
}

#[test]
fn strategies_give_certified_plans_that_nothing_collides_on_with_fewer_and_more_axes() {
    for name in BUILT_IN {
        // Each is tried where there are axes that other tests have none of.
        let strategies: &[Strategy] = match name {
            "xyzc" => &[Strategy::Global],
            "xyzabc" => &[Strategy::Genetic],
            _ => &[],
        };
        for &strategy in strategies {
            let mut job = easy_job();
            (job.machine, job.plan.strategy) = (machine(name), strategy);
            let machine = job.machine.clone();
            let outcome = plan(mesh(&easy_blisk()), job);
            assert!(outcome.is_verified(), "{name}: {}", outcome.electrodes[0].plan.verdict(&outcome.channel));
            let simulation = simulated(&outcome, &machine, vec![outcome.channel.index]);
            assert!(simulation.holds(), "{name}: {}", simulation.sentence());
            assert!(simulation.pairs().iter().any(|p| p.moving == "spindle" && p.fixed == "faceplate"));
        }
    }
}

#[test]
fn channels_of_a_parametric_blisk_are_reached_by_indexing() {
    let outcome = super::easy_plan();
    let channels = outcome.channel.blades;
    let simulation = simulated(outcome, &machine("xyzac"), (0..channels).step_by(7).collect());
    assert!(simulation.holds(), "{}", simulation.sentence());
    assert_eq!((simulation.visits().len(), simulation.out_of_reach().len()), (channels.div_ceil(7), 0));
    // The parametric blisk is the same from every channel, but for the rounding of its coordinates and of A in files.
    assert!(simulation.period_error().unwrap() < 1e-5, "{:?}", simulation.period_error());
}
