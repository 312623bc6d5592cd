//! Feed paths along the centreline: figures 1, 2, 5, 7 and 8, and table 4.

use std::fmt::Write;
use std::sync::Arc;

use glam::DVec3;

use super::{CHANNELS, Part, cells, drawn, failed, outcome};
use crate::reproduce::{Outcome, ReproduceError, Table, Verdict};
use crate::workspaces::blisk::document::choice::DrawnPictures;
use crate::workspaces::blisk::document::job_file::PlanJob;
use crate::workspaces::blisk::job::outcome::{ElectrodeOutcome, PlanInputs, PlanOutcome};
use crate::workspaces::blisk::job::plan::{prepare, run_feeds};
use crate::workspaces::blisk::scene::pictures::{PlanToShow, plan_pictures};
use crate::workspaces::mold::scene::pictures::MoldPicture;
use feed::axis_curve::CurveKind;
use feed::centreline::Guide;
use feed::machine::AxisSet;
use feed::plan_params::Strategy;
use feed::pose::Pose;
use feed::wall_clearances::{ClearanceGauge, WallClearances};
use files::report::number;
use files::report::plot::{Plot, Series};
use geometry::frame::Frame;
use task::Task;
use wheel::centreline::Centreline;
use wheel::channel::{BladeSide, Channel};
use wheel::electrode::EnterSide;
use wheel::surface_finder::SurfaceFinder;

/// The paper's electrodes for one channel: inner and outer, on the left and on the right (text on figure 2).
const ELECTRODES: usize = 4;
/// Step along the centreline (mm; text before figure 9).
const STEP_MM: f64 = 0.1;
/// Rows of the table of nodes on the page.
const ROWS: usize = 16;
const BY_HAND: &str = "sparkpath plan p1_blisk.stl --set plan.strategy=centreline --set plan.step_mm=0.1 --set \
                       plan.interpolation.kind=nurbs --set electrode.parts=2 --set electrode.columns=2 --out DIR, which \
                       writes nodes, core points and distances into nodes_K.csv; in the window: Blisk workspace, steps Electrode and Plan, strategy centreline.";

/// The job of the paper: four electrodes of one channel along its centreline.
fn job(axes: AxisSet) -> PlanJob {
    let mut job = PlanJob::demonstration();
    job.electrode.parts = 2;
    job.electrode.columns = 2;
    job.electrode.enter = EnterSide::Auto;
    job.electrode.circumferential_reduction_deg = [0.8, 0.8];
    job.plan.strategy = Strategy::Centreline;
    job.plan.step_mm = STEP_MM;
    job.plan.interpolation.kind = CurveKind::Nurbs;
    job.machine.axes = axes;
    job
}

/// The plans for 4, 5 and 6 axes.
pub(super) struct Planned {
    plans: Vec<(AxisSet, PlanInputs, PlanOutcome)>,
}

/// What is told of a node beside its pose.
struct NodeFacts {
    /// Core point v_i (mm, in W), and its arc length along the centreline (mm).
    core: DVec3,
    arc: f64,
    /// Distances to pressure wall, suction wall, hub and shroud: P1's delta_1 to delta_4 (mm).
    distances: [Option<f64>; 4],
}

impl Planned {
    pub(super) fn new(part: &Part, task: &Task) -> Result<Self, ReproduceError> {
        let inputs = |axes| PlanInputs {
            blisk: part.mesh.clone(),
            obstacles: None,
            own_electrodes: Vec::new(),
            blank: None,
            sections: Arc::default(),
            job: job(axes),
        };
        let prepared = prepare(&inputs(AxisSet::XYZAC), task).map_err(failed("Figure 7", task))?;
        let plan = |axes| {
            let inputs = inputs(axes);
            let outcome = run_feeds(&prepared, &inputs, task).map_err(failed("Figure 7", task))?;
            Ok((axes, inputs, outcome))
        };
        let plans = [AxisSet::XYZAC, AxisSet::XYZC, AxisSet::XYZABC].map(plan);
        Ok(Self { plans: plans.into_iter().collect::<Result<_, ReproduceError>>()? })
    }

    /// The workpiece frame W of the channel that was found in the mesh.
    pub(super) fn frame(&self) -> Frame {
        self.plans.first().map_or(Frame::IDENTITY, |(_, _, outcome)| outcome.channel.frame)
    }

    pub(super) fn outcomes(&self, part: &Part, task: &Task) -> Result<Vec<Outcome>, ReproduceError> {
        let Some((_, inputs, outcome)) = self.plans.first() else { return Ok(Vec::new()) };
        let mut pictures = pictures(part, inputs, outcome, task)?.into_iter();
        let figure_1 = super::outcome(
            "Figure 1",
            "The wheel and its channels",
            Verdict::NotComparable,
            format!("Another wheel with the same number of channels, {CHANNELS}; the paper's is not public."),
            "The mesh is p1_blisk.stl in this folder: sparkpath inspect p1_blisk.stl.",
        );
        let figure_1 = Outcome { pictures: pictures.next().into_iter().collect(), ..figure_1 };
        let figure_2 = Outcome { pictures: pictures.collect(), ..figure_2(outcome) };
        let line = Centreline::of_channel(&outcome.channel, &task.cancel).map_err(failed("Figure 7", task))?;
        let facts = |e: &ElectrodeOutcome| facts(e, &outcome.channel, &line, task);
        let facts = outcome.electrodes.iter().map(facts).collect::<Result<Vec<_>, _>>()?;
        Ok(vec![figure_1, figure_2, figure_5(), table_4(inputs), self.figure_7(&facts), self.figure_8()])
    }

    fn figure_7(&self, facts: &[Vec<NodeFacts>]) -> Outcome {
        let rows = self.plans.iter().flat_map(|(axes, _, outcome)| {
            outcome.electrodes.iter().map(move |e| {
                let path = e.plan.path.as_ref();
                let reversals = path.map_or(0, |p| p.smoothness.iter().map(|s| s.sign_changes).sum::<usize>());
                let figures = [
                    e.plan.nodes.len().to_string(),
                    number(e.plan.nodes.last().map_or(0.0, |n| n.s), 2),
                    number(path.map_or(f64::NAN, |p| p.certificate.certified()), 4),
                    reversals.to_string(),
                    number(e.plan.search_seconds, 2),
                ];
                let found = if e.plan.is_verified() { "certified" } else { "none" }.to_owned();
                [
                    vec![format!("{axes:?}"), e.electrode.share(), e.electrode.enters_from.name().to_owned(), found],
                    figures.to_vec(),
                ]
                .concat()
            })
        });
        let head = [
            "machine",
            "electrode",
            "enters from",
            "path",
            "#nodes",
            "#retracted (mm)",
            "#certified clearance (mm)",
            "#reversals",
            "#search (s)",
        ];
        let mut tables = vec![Table::new("Paths on machines of 4, 5 and 6 axes", &head, rows.collect())];
        let (mut plots, mut files) = (Vec::new(), Vec::new());
        let Some((_, inputs, outcome)) = self.plans.first() else { return figure_5() };
        let gap = inputs.job.electrode.spark_gap_mm;
        for (i, (e, facts)) in outcome.electrodes.iter().zip(facts).enumerate() {
            let title = format!("Electrode {}, {}", i + 1, e.electrode.share());
            plots.push(distance_plot(&title, e, facts, gap));
            files.push((format!("p1_nodes_{}.csv", i + 1), csv(e, facts).into_bytes()));
        }
        if let (Some(e), Some(facts)) = (outcome.electrodes.first(), facts.first()) {
            tables.push(nodes(e, facts));
        }
        let all = self.plans.iter().flat_map(|(_, _, o)| &o.electrodes);
        let certified = all.clone().filter(|e| e.plan.is_verified()).count();
        let why = format!(
            "The paper shows the search window for 4, 5 and 6 axes and states that paths were found; it gives no nodes. Here \
             {certified} of {} paths along the centreline are found and certified over the whole motion, where the paper tests \
             its nodes. Some of them waver: the reversals of all axes stand in the table.",
            all.count()
        );
        let verdict = if certified == self.plans.len() * ELECTRODES { Verdict::Same } else { Verdict::Worse };
        Outcome {
            tables,
            plots,
            files,
            ..outcome_named(
                "Figure 7",
                "Search along the centreline: nodes, core points, the four distances",
                verdict,
                why,
            )
        }
    }

    fn figure_8(&self) -> Outcome {
        let rows = self.plans.iter().map(|(axes, inputs, outcome)| {
            let least = outcome.electrodes.iter().filter_map(|e| Some(e.plan.path.as_ref()?.certificate.certified()));
            let least = least.fold(f64::INFINITY, f64::min);
            let free = if outcome.is_verified() { "free of interference" } else { "not for every electrode" };
            let figures = cells(&[least, inputs.job.electrode.spark_gap_mm], 4);
            [vec![format!("{axes:?}"), free.to_owned()], figures].concat()
        });
        let head = ["machine", "whole motion", "#least certified clearance (mm)", "#spark gap (mm)"];
        let all = self.plans.iter().all(|(_, _, outcome)| outcome.is_verified());
        let verdict = if all { Verdict::NotComparable } else { Verdict::Worse };
        let why = "The paper plays the motion of electrode and machine in its simulation and sees no collision. Of electrode \
                   and blisk ours is a certificate: a lower bound of the distance over the whole continuous motion. The \
                   bodies of the paper's machine are not known; those of ours are moved by sparkpath simulate, not here.";
        Outcome {
            tables: vec![Table::new("Certificates of all four electrodes together", &head, rows.collect())],
            ..super::outcome(
                "Figure 8",
                "Simulation of the motion for 4, 5 and 6 axes",
                verdict,
                why,
                "sparkpath plan certifies every path; sparkpath simulate moves the bodies of a machine.",
            )
        }
    }
}

fn outcome_named(name: &str, title: &str, verdict: Verdict, why: String) -> Outcome {
    outcome(name, title, verdict, why, BY_HAND)
}

fn figure_2(outcome: &PlanOutcome) -> Outcome {
    let rows = outcome.electrodes.iter().enumerate().map(|(i, e)| {
        let figures = cells(&[e.electrode.least_thickness_mm, e.electrode.volume_mm3, e.electrode.burn_area_mm2], 3);
        let names = vec![format!("{}", i + 1), e.electrode.share(), e.electrode.enters_from.name().to_owned()];
        [names, figures].concat()
    });
    let head = ["electrode", "burns", "enters from", "#least thickness (mm)", "#volume (mm³)", "#burning area (mm²)"];
    let same = outcome.electrodes.len() == ELECTRODES;
    let thickness = outcome.electrodes.iter().map(|e| e.electrode.least_thickness_mm);
    let [least, most] = thickness.fold([f64::INFINITY, 0.0], |[a, b], t| [f64::min(a, t), f64::max(b, t)]);
    let why = format!(
        "{} electrodes, as the paper has: two from each side, its inner and outer ones from the left and from the right, \
         with an overlap. How it divides inner from outer its text does not say; ours are divided between the blades. The \
         paper balances their thickness and gives no figures. Ours divides front from rear, and left from right, \
         where both are as thick as each other at their thinnest places before any reduction, or as nearly as a division between \
         one and two thirds of the length makes them. The finished ones are {least:.2} to {most:.2} mm thick.",
        outcome.electrodes.len()
    );
    Outcome {
        tables: vec![Table::new("Electrodes of one channel", &head, rows.collect())],
        ..outcome_named(
            "Figure 2",
            "Division of the electrode",
            if same { Verdict::Same } else { Verdict::NotComparable },
            why,
        )
    }
}

fn figure_5() -> Outcome {
    let row = |cells: [&str; 2]| cells.map(str::to_owned).to_vec();
    let rows = vec![
        row(["walls of the channel as NURBS, their centreline", "wheel: nurbs_wall, centreline"]),
        row(["electrode in its final pose, reduced by the spark gap", "wheel: electrode"]),
        row(["nodes in equal steps along the centreline, core point of each", "feed: centreline (Guide)"]),
        row(["interference at the node: least distance to the walls", "feed: clearance"]),
        row(["other posture, greater gap, shorter step", "feed: centreline, search"]),
        row(["curve through the nodes", "feed: interpolation"]),
        row(["not in the paper: proof over the whole motion", "feed: verify"]),
    ];
    Outcome {
        tables: vec![Table::new("Steps of the flowchart and where they are", &["step", "crate: module"], rows)],
        ..outcome_named(
            "Figure 5",
            "Flow of the search",
            Verdict::NotComparable,
            "A flow chart without figures. The same steps along our own centreline (figure 6). Where the paper leaves the way to another posture open, ours climbs the distance field. The proof at \
             the end is ours."
                .to_owned(),
        )
    }
}

fn table_4(inputs: &PlanInputs) -> Outcome {
    let job = &inputs.job;
    let row = |key: &str, value: String, unit: &str| vec![key.to_owned(), value, unit.to_owned()];
    let rows = vec![
        row("plan.strategy", job.plan.strategy.name().to_owned(), ""),
        row("plan.step_mm", number(job.plan.step_mm, 3), "mm"),
        row("plan.centreline.safety_increase_mm", number(job.plan.centreline.safety_increase_mm, 3), "mm"),
        row("plan.exit_clearance_mm", number(job.plan.exit_clearance_mm, 3), "mm"),
        row("plan.interpolation.degree", job.plan.interpolation.degree.to_string(), ""),
        row("electrode.spark_gap_mm", number(job.electrode.spark_gap_mm, 3), "mm"),
        row("electrode.parts, electrode.columns", format!("{}, {}", job.electrode.parts, job.electrode.columns), ""),
    ];
    let why =
        format!("{} Of the parameters only the step is in its text: {STEP_MM} mm, which is ours too.", super::NO_CELLS);
    Outcome {
        tables: vec![Table::new("Parameters of our search", &["key", "#value", "unit"], rows)],
        ..outcome_named("Table 4", "Parameters of the search", Verdict::NotComparable, why)
    }
}

/// Core point and distances at every node of an electrode.
fn facts(
    e: &ElectrodeOutcome,
    channel: &Arc<Channel>,
    line: &Centreline,
    task: &Task,
) -> Result<Vec<NodeFacts>, ReproduceError> {
    let guide = Guide::new(line.clone(), channel, &e.electrode).map_err(failed("Figure 7", task))?;
    let finder = SurfaceFinder::new(channel.clone()).map_err(failed("Figure 7", task))?;
    let gauge = ClearanceGauge::new(&e.electrode, channel, &finder, &task.cancel)?;
    let poses: Vec<Pose> = e.plan.nodes.iter().map(|n| n.pose).collect();
    let measured = gauge.at_all(&poses, &task.cancel)?;
    let of_node = |(node, d): (&feed::problem::Node, WallClearances)| {
        let [low, high] = d.walls.map(Some);
        let walls = if channel.low.side == BladeSide::Pressure { [low, high] } else { [high, low] };
        let core = node.pose.placement(e.electrode.reference_point).transform_point3(guide.core());
        NodeFacts { core, arc: guide.arc_length(node.s), distances: [walls[0], walls[1], d.hub, d.shroud] }
    };
    Ok(e.plan.nodes.iter().zip(measured).map(of_node).collect())
}

fn distance_plot(title: &str, e: &ElectrodeOutcome, facts: &[NodeFacts], gap: f64) -> String {
    let nodes = &e.plan.nodes;
    let curve =
        |k: usize| nodes.iter().zip(facts).map(move |(n, f)| [n.s, f.distances[k].unwrap_or(f64::NAN)]).collect();
    let series = (0..4).zip(["c0", "c1", "c2", "c3"]).map(|(k, class)| Series { points: curve(k), class, dots: false });
    Plot {
        title: format!("{title}: mm to pressure wall (blue), suction wall (brown), hub (green), shroud (violet)"),
        x_label: "retracted (mm)".to_owned(),
        log_y: true,
        size: [760.0, 250.0],
        series: series.collect(),
        levels: vec![(gap, format!("spark gap {gap:.2}"))],
        ..Plot::default()
    }
    .svg()
}

/// s, axes and what is told of the node.
fn row(node: &feed::problem::Node, facts: &NodeFacts) -> [f64; 15] {
    let p = node.pose;
    let [a, b, c] = [p.a, p.b, p.c].map(f64::to_degrees);
    let [d1, d2, d3, d4] = facts.distances.map(|d| d.unwrap_or(f64::NAN));
    let core = facts.core;
    [node.s, p.x, p.y, p.z, a, b, c, core.x, core.y, core.z, facts.arc, d1, d2, d3, d4]
}

fn nodes(e: &ElectrodeOutcome, facts: &[NodeFacts]) -> Table {
    let step = e.plan.nodes.len().div_ceil(ROWS).max(1);
    let rows = e
        .plan
        .nodes
        .iter()
        .zip(facts)
        .enumerate()
        .step_by(step)
        .map(|(i, (node, facts))| [vec![i.to_string()], cells(&row(node, facts), 3)].concat());
    let head = [
        "#node", "#s", "#x", "#y", "#z", "#a (deg)", "#b (deg)", "#c (deg)", "#v x", "#v y", "#v z", "#arc", "#d1",
        "#d2", "#d3", "#d4",
    ];
    let caption = "Nodes of electrode 1 (mm): retract distance, axes, core point v and its arc length, distances to pressure \
                   wall, suction wall, hub, shroud (to their greatest radius, which facets dip below: the mesh may be a few \
                   micrometres further away); every node is in p1_nodes_1.csv";
    Table::new(caption, &head, rows.collect())
}

fn csv(e: &ElectrodeOutcome, facts: &[NodeFacts]) -> String {
    let mut csv =
        "node,s_mm,x_mm,y_mm,z_mm,a_deg,b_deg,c_deg,core_x_mm,core_y_mm,core_z_mm,arc_mm,d1_mm,d2_mm,d3_mm,d4_mm\n"
            .to_owned();
    for (i, (node, facts)) in e.plan.nodes.iter().zip(facts).enumerate() {
        let cell = |value: &f64| if value.is_nan() { String::new() } else { format!("{value:.5}") };
        let cells = row(node, facts).iter().map(cell).collect::<Vec<_>>().join(",");
        // Writing into a string does not fail.
        let _ = writeln!(csv, "{i},{cells}");
    }
    csv
}

/// The wheel, and each electrode in its final pose.
fn pictures(
    part: &Part,
    inputs: &PlanInputs,
    outcome: &PlanOutcome,
    task: &Task,
) -> Result<Vec<files::report::Picture>, ReproduceError> {
    let plan = PlanToShow {
        blisk: &part.mesh,
        channel: &outcome.channel,
        electrodes: outcome.electrodes.iter().map(|e| (&e.electrode, &e.plan)).collect(),
        residual_stock: None,
        measured: None,
        spark_gap: inputs.job.electrode.spark_gap_mm,
    };
    let wanted = DrawnPictures { whole: true, final_pose: true, sweep: false, closest: false, residual_stock: false };
    let pictures = plan_pictures(&plan, &wanted, task)?.into_iter().map(|p| MoldPicture {
        title: p.title,
        caption: p.caption,
        legend: p.legend.into_iter().map(|(colour, what)| (colour, what.to_owned())).collect(),
        scene: p.scene,
        camera: p.camera,
    });
    drawn(pictures.collect(), task)
}
