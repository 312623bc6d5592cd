//! Plans on the machines that the program brings along.

use super::common::{easy_blisk, mesh};
use super::{easy_job, plan};
use feed::machine::MachineParams;
use feed::plan_params::Strategy;
use feed::simulation::{Scenario, Simulation, SimulationOptions, simulate};
use files::AnyDocument as _;
use geometry::mesh::Mesh;
use sparkpath::workspaces::blisk::document::job_file::PlanJob;
use sparkpath::workspaces::blisk::document::kept_plan::KeptPlan;
use sparkpath::workspaces::blisk::document::machine_file::{BUILT_IN, machine_table, read_machine};
use sparkpath::workspaces::blisk::document::{Document, demonstration};
use sparkpath::workspaces::blisk::job::outcome::PlanOutcome;
use sparkpath::workspaces::blisk::job::plan::kept;
use task::Task;
use wheel::parametric::ParametricBlisk;

fn machine(name: &str) -> MachineParams {
    let params: MachineParams = toml::Value::Table(machine_table(name).unwrap()).try_into().unwrap();
    MachineParams { name: name.to_owned(), ..params }
}

/// Up to what the mathematics of another system makes of the last bits.
fn same_nodes(known: &KeptPlan, found: &KeptPlan) {
    assert_eq!(known.inputs, found.inputs);
    assert_eq!(known.electrodes.len(), found.electrodes.len());
    for (known, found) in known.electrodes.iter().zip(&found.electrodes) {
        assert_eq!((known.side, known.h, known.nodes.len()), (found.side, found.h, found.nodes.len()));
        for (known, found) in known.nodes.iter().zip(&found.nodes) {
            let pairs = known.pose.to_array().into_iter().zip(found.pose.to_array());
            let off = pairs.chain([(known.s, found.s)]).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(off < 1e-9, "plan the demonstration anew with UPDATE_SNAPSHOTS=1: {known:?} {found:?}");
        }
    }
}

fn simulated(blisk: &Mesh, outcome: &PlanOutcome, machine: &MachineParams, channels: Vec<usize>) -> Simulation {
    let blisk = blisk.in_frame(&outcome.channel.frame);
    let electrode = &outcome.electrodes[0];
    let planned = electrode.plan.path.as_ref().unwrap();
    let scenario = Scenario {
        blisk: &blisk,
        channels: outcome.channel.blades,
        own_channel: outcome.channel.index,
        electrode: &electrode.electrode,
        feed: (&planned.path, &planned.certificate),
        copying: None,
        machine,
        model: &read_machine(&machine.name, &Task::default()).unwrap(),
    };
    simulate(&scenario, &SimulationOptions::of(channels), &Task::default()).unwrap()
}

#[test]
fn with_fewer_axes_the_global_search_gives_a_certified_plan_that_nothing_collides_on() {
    is_certified_and_nothing_collides("xyzc", Strategy::Global);
}

#[test]
fn with_more_axes_the_genetic_search_gives_a_certified_plan_that_nothing_collides_on() {
    is_certified_and_nothing_collides("xyzabc", Strategy::Genetic);
}

/// Each strategy is tried where there are axes that other tests have none of.
fn is_certified_and_nothing_collides(name: &str, strategy: Strategy) {
    assert!(BUILT_IN.contains(&name));
    let mut job = easy_job();
    (job.machine, job.plan.strategy, job.plan.step_mm) = (machine(name), strategy, 1.6);
    let machine = job.machine.clone();
    let outcome = plan(mesh(&easy_blisk()), job);
    assert!(outcome.is_verified(), "{name}: {}", outcome.electrodes[0].plan.verdict(&outcome.channel));
    let simulation = simulated(&mesh(&easy_blisk()), &outcome, &machine, vec![outcome.channel.index]);
    assert!(simulation.holds(), "{name}: {}", simulation.sentence());
    assert!(simulation.pairs().iter().any(|p| p.moving == "spindle" && p.fixed == "faceplate"));
}

#[test]
fn the_demonstration_keeps_its_plan_and_its_channels_are_reached_by_indexing() {
    let job = PlanJob::demonstration();
    let blisk = mesh(&ParametricBlisk::demonstration());
    let outcome = plan(blisk.clone(), job.clone());
    let found = KeptPlan { inputs: KeptPlan::inputs_of(&job, ""), electrodes: kept(&outcome).unwrap() };
    if std::env::var_os("UPDATE_SNAPSHOTS").is_some() {
        let mut document = Document::new(job);
        found.note(&mut document);
        document.save_as("assets/demonstration.sparkpath".as_ref()).unwrap();
    } else {
        same_nodes(&KeptPlan::of(&demonstration()).unwrap(), &found);
    }

    let channels = outcome.channel.blades;
    let simulation = simulated(&blisk, &outcome, &machine("xyzac"), (0..channels).step_by(7).collect());
    assert!(simulation.holds(), "{}", simulation.sentence());
    assert_eq!((simulation.visits().len(), simulation.out_of_reach().len()), (channels.div_ceil(7), 0));
    // The parametric blisk is the same from every channel, but for the rounding of its coordinates and of A in files.
    assert!(simulation.period_error().unwrap() < 1e-5, "{:?}", simulation.period_error());
}
