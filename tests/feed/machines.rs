//! Plans on the machines that the program brings along.

use super::common::{easy_blisk, mesh};
use super::{easy_job, easy_plan, plan};
use feed::machine::{MachineParams, TurnedByC};
use feed::machine_model::{Carrier, MachineModel};
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
use wheel::parametric::wheel::ParametricWheel;

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
    let model = read_machine(&machine.name, &Task::default()).unwrap();
    simulated_with((machine, &model), blisk, outcome, channels)
}

fn simulated_with(
    (machine, model): (&MachineParams, &MachineModel),
    blisk: &Mesh,
    outcome: &PlanOutcome,
    channels: Vec<usize>,
) -> Simulation {
    let blisk = blisk.in_frame(&outcome.channel.frame);
    let electrode = &outcome.electrodes[0];
    let planned = electrode.plan.path.as_ref().unwrap();
    let scenario = Scenario {
        blisk: &blisk,
        channels: outcome.channel.blades,
        own_channel: outcome.channel.index,
        electrode: &electrode.electrode,
        preset: None,
        feed: (&planned.path, &planned.certificate),
        copying: None,
        machine,
        model,
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

pub fn a_plan_goes_on_a_tilting_table_as_well_and_its_clearance_is_less_by_what_the_machine_leaves_the_poses() {
    let outcome = easy_plan();
    let plain = machine("xyzac");
    let tilting = MachineParams { c_turns: TurnedByC::Table, c_axis_mm: [-70.0, 0.0], ..plain.clone() };
    let mut model = read_machine("xyzac", &Task::default()).unwrap();
    model.bodies.iter_mut().filter(|body| body.name == "rotary table").for_each(|body| body.carrier = Carrier::Cradle);
    let (blisk, own) = (mesh(&easy_blisk()), outcome.channel.index);
    let on = |machine| simulated_with((machine, &model), &blisk, outcome, vec![own, own + 1]);
    let [on_head, on_table] = [&plain, &tilting].map(on);
    for simulation in [&on_head, &on_table] {
        assert!(simulation.holds(), "{}", simulation.sentence());
    }
    assert_eq!(on_head.approach(), on_table.approach());
    let is_tested = |moving, fixed| on_table.pairs().iter().any(|p| p.moving == moving && p.fixed == fixed);
    assert!(is_tested("base", "blisk") && is_tested("base", "rotary table") && is_tested("spindle", "rotary table"));
    let feed =
        |simulation: &Simulation| simulation.pairs().iter().find(|p| p.during == Some("feed")).unwrap().certified;
    assert!((feed(&on_head) - feed(&on_table) - on_table.chain().deviation()).abs() < 1e-12);
    assert_eq!(on_head.chain().deviation(), 0.0);
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
    let blisk = ParametricWheel::demonstration().mesh();
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
    let simulation = simulated(&blisk, &outcome, &machine("xyzac"), (0..channels).step_by(4).collect());
    assert!(simulation.holds(), "{}", simulation.sentence());
    assert_eq!((simulation.visits().len(), simulation.out_of_reach().len()), (channels / 4, 0));
    // The wheel is the same from every fourth channel, as far as its 11 bolt holes, but for the rounding of its
    // coordinates and of A in files.
    assert!(simulation.period_error().unwrap() < 1e-5, "{:?}", simulation.period_error());
}
