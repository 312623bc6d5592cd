//! The results of P0 on the demonstration blisk: the genetic search, and the methods that the paper compares it with.
//!
//! The paper has seven figures and no table. It prints neither dimensions nor weights nor any other number of a result, so
//! that no result can be compared number by number: what can be compared is what the paper concludes from its figures.

mod motion;
mod pictures;
mod walls;

use std::fmt::Display;
use std::sync::Arc;

use super::{Outcome, Paper, ReproduceError, Table, Verdict};
use crate::workspaces::blisk::document::job_file::PlanJob;
use crate::workspaces::blisk::job::compare::job_for;
use crate::workspaces::blisk::job::outcome::ElectrodeOutcome;
use crate::workspaces::blisk::job::plan::run_feeds;
use crate::workspaces::blisk::job::planned::inputs_of;
use crate::workspaces::blisk::job::prepared_blisk::PreparedBlisk;
use crate::workspaces::blisk::job::stages::{self, FoundChannel, Part};
use crate::workspaces::blisk::report::BliskSummary;
use feed::genetic::coding::Coding;
use feed::machine::AxisSet;
use feed::plan::FeedPlan;
use feed::plan_params::Strategy;
use feed::pose::Axis;
use feed::problem::Convergence;
use files::report::number;
use files::report::plot::{Plot, Series};
use geometry::mesh::Bounds;
use pictures::{Studio, picture};
use render::camera::Camera;
use render::colour::{Colour, Theme};
use render::mesh::RenderMesh;
use render::scene::{Object, ObjectId, Scene};
use render::view::looking;
use task::Task;
use wheel::channel::Channel;
use wheel::electrode::{Electrode, ElectrodeParams, make_electrodes};
use wheel::find_channel::find_channel;
use wheel::options::BliskOptions;

use crate::widgets::theme::COPPER;

/// Weight a3 of smoothness in (6) of the paths that are set beside those of the other methods. Obj2 of (5) is in mm and
/// mm^2 while Obj1 of (4) is a share of a range, so that with equal weights Obj1 has next to no say.
const SMOOTH: f64 = 0.9;

/// The results of the paper.
pub(super) fn results(task: &Task) -> Result<Vec<Outcome>, ReproduceError> {
    let subject = Subject::new(task)?;
    let mut studio = Studio::new();
    let net_shape = |params: &mut ElectrodeParams| {
        params.circumferential_reduction_deg = [0.0; 2];
        params.radial_reduction_mm = 0.0;
    };
    let primitive = subject.electrodes(net_shape, task)?;
    Ok(vec![
        design(&subject, &primitive, &mut studio, task)?,
        machine(&subject),
        walls::constraint(&subject, &primitive, task)?,
        walls::distribution(&subject, &primitive, &mut studio, task)?,
        convergence(&subject),
        motion::exit(&subject, &mut studio, task)?,
        motion::smoothness(&subject, &mut studio, task)?,
        weights(&subject),
        predecessors(&subject),
    ])
}

/// The reason why there is no result, which is that the task was cancelled if it was.
fn failed(task: &Task, name: &'static str, problem: &dyn Display) -> ReproduceError {
    match task.check() {
        Err(cancelled) => cancelled.into(),
        Ok(()) => ReproduceError::Result { paper: Paper::P0, name, problem: problem.to_string() },
    }
}

/// A path of the electrode.
struct Case {
    /// Name of the method.
    name: &'static str,
    /// Class of its curves in plots.
    class: &'static str,
    /// The same colour in pictures.
    colour: Colour,
    job: PlanJob,
    found: ElectrodeOutcome,
}

impl Case {
    fn plan(&self) -> &FeedPlan {
        &self.found.plan
    }
}

/// The part with its channel and the paths of its electrode.
struct Subject {
    part: Part,
    channel: FoundChannel,
    /// The paper's method, with mostly smoothness and with equal weights, then the methods that it is compared with, then
    /// our own.
    cases: Vec<Case>,
}

impl Subject {
    fn new(task: &Task) -> Result<Self, ReproduceError> {
        const NAME: &str = "Figure 7";
        let wrong = |problem: &dyn Display| failed(task, NAME, problem);
        let mut job = PlanJob::demonstration();
        // The paper's feed moves X, Y, Z and C; A only copies.
        job.machine.axes = AxisSet::XYZC;
        let part = stages::load(&job, task).map_err(|e| wrong(&e))?;
        let channel = stages::channel(&part, &job, &|_| (), task).map_err(|e| wrong(&e))?;
        let (blisk, exact, found) = (channel.blisk.clone(), channel.exact.clone(), channel.channel.clone());
        let prepared = PreparedBlisk::new(blisk, exact, found, job.plan.field_cell_mm, task).map_err(|e| wrong(&e))?;
        let wanted = [
            ("genetic, a3 = 0.9", "c0", Colour::rgb(0x1f, 0x5f, 0xa8), Strategy::Genetic, SMOOTH),
            ("genetic, a3 = 0.5", "c3", Colour::rgb(0x8a, 0x3a, 0x8f), Strategy::Genetic, job.plan.weights.a3),
            ("free travel [11]", "c1", Colour::rgb(0xb0, 0x5e, 0x12), Strategy::FreeTravel, SMOOTH),
            ("max-min distance [10]", "c2", Colour::rgb(0x2b, 0x7a, 0x4b), Strategy::MaxMinDistance, SMOOTH),
            ("global (not in the paper)", "c4", Colour::rgb(0x5d, 0x6b, 0x1f), Strategy::Global, SMOOTH),
        ];
        let mut cases = Vec::new();
        for (i, (name, class, colour, strategy, a3)) in wanted.into_iter().enumerate() {
            task.report("P0", i as f64 / wanted.len() as f64, name);
            let mut job = job_for(&job, strategy);
            (job.plan.weights.a3, job.plan.weights.b3) = (a3, 1.0 - a3);
            let outcome = run_feeds(&prepared, &inputs_of(&part, &job), &Task::silent(&task.cancel));
            let found = outcome.map_err(|e| wrong(&e))?.electrodes.into_iter().next();
            let found = found.ok_or_else(|| wrong(&"the plan has no electrode"))?;
            cases.push(Case { name, class, colour, job, found });
        }
        Ok(Self { part, channel, cases })
    }

    /// The paper's method.
    fn genetic(&self) -> &Case {
        &self.cases[0]
    }

    /// Free travel, which the paper's figure 7 compares with.
    fn free_travel(&self) -> &Case {
        &self.cases[2]
    }

    /// The electrodes of the demonstration with some parameters changed.
    fn electrodes(&self, change: impl Fn(&mut ElectrodeParams), task: &Task) -> Result<Vec<Electrode>, ReproduceError> {
        let (Case { job, found, .. }, FoundChannel { channel, exact, .. }) = (self.genetic(), &self.channel);
        let mut params = job.electrode.clone();
        change(&mut params);
        let made = make_electrodes(channel, exact, &params, found.electrode.enters_from, task);
        made.map_err(|e| failed(task, "Figure 1", &e))
    }

    /// The channel with so many points of each wall, along the passage and from hub to shroud.
    fn channel_of(
        &self,
        [wall_points_chord, wall_points_span]: [usize; 2],
        name: &'static str,
        task: &Task,
    ) -> Result<Channel, ReproduceError> {
        let options = self.genetic().job.blisk.options.clone();
        let options = BliskOptions { wall_points_chord, wall_points_span, ..options };
        find_channel(&self.part.mesh, &options, task).map_err(|e| failed(task, name, &e))
    }

    /// A result without figures.
    fn outcome(&self, name: &str, title: &str, verdict: Verdict, why: String, by_hand: &str) -> Outcome {
        let BliskSummary { blades, hub_radius_mm: hub, shroud_radius_mm: shroud, throat_mm, .. } =
            BliskSummary::of(&self.channel.channel);
        Outcome {
            name: name.to_owned(),
            title: title.to_owned(),
            part: format!(
                "demonstration blisk: {blades} blades, hub radius {:.1} mm, shroud radius {:.1} mm, throat {throat_mm:.2} mm; \
                 the paper states no dimensions",
                hub[0], shroud[1]
            ),
            verdict,
            why,
            by_hand: by_hand.to_owned(),
            ..Outcome::default()
        }
    }
}

/// What each colour of the plots stands for.
fn key(cases: &[Case]) -> Vec<(Colour, String)> {
    cases.iter().map(|case| (case.colour, case.name.to_owned())).collect()
}

/// Command that plans the demonstration as the paper's method does.
const BY_GENETIC: &str = "sparkpath demo --out DIR --set machine.axes=XYZC --set plan.strategy=genetic --set \
    plan.weights.a3=0.9 --set plan.weights.b3=0.1; in the window the step Plan, strategy genetic";

/// Figure 1: the electrode, its reductions and its division.
fn design(
    subject: &Subject,
    primitive: &[Electrode],
    studio: &mut Studio,
    task: &Task,
) -> Result<Outcome, ReproduceError> {
    let turned = subject.electrodes(|params| params.radial_reduction_mm = 0.0, task)?;
    let divided = subject.electrodes(|params| params.parts = 2, task)?;
    let reduced = std::slice::from_ref(&subject.genetic().found.electrode);
    let stages = [
        ("(a) primitive: spark gap only", primitive),
        ("(b) circumferential reduction", &turned[..]),
        ("(b) radial reduction too", reduced),
        ("(c), (d) divided in two along X", &divided[..]),
    ];
    let row = |(name, electrodes): &(&str, &[Electrode])| {
        let sum = |value: fn(&Electrode) -> f64| electrodes.iter().map(value).sum::<f64>();
        let thinnest = electrodes.iter().map(|e| e.least_thickness_mm).fold(f64::INFINITY, f64::min);
        let [volume, area] = [sum(|e| e.volume_mm3), sum(|e| e.burn_area_mm2)].map(|v| number(v, 0));
        vec![(*name).to_owned(), electrodes.len().to_string(), number(thinnest, 2), area, volume]
    };
    let view = |(_, electrodes): &(&str, &[Electrode])| {
        let mut scene = Scene { triad: false, ..Scene::new(Theme::LIGHT) };
        let object = |(i, e): (usize, &Electrode)| {
            Object::new(ObjectId(i as u32), Arc::new(RenderMesh::for_pictures(&e.mesh)), COPPER)
        };
        scene.objects.extend(electrodes.iter().enumerate().map(object));
        let side = electrodes.first().map_or(glam::DVec3::X, |e| e.enters_from.direction());
        let towards_viewer = glam::DVec3::new(-0.35 * side.x, -0.9, 0.45);
        let mut camera = Camera { orientation: looking(towards_viewer, glam::DVec3::Z), ..Camera::default() };
        camera.fit(&scene.bounds(), SHEET_ASPECT);
        (scene, camera)
    };
    let views: Vec<_> = stages.iter().map(view).collect();
    let png = studio.sheet(&views, SHEET, task).map_err(|e| failed(task, "Figure 1", &e))?;
    let [low, high] = subject.genetic().job.electrode.circumferential_reduction_deg;
    let caption = format!(
        "From the upper left: spark gap only; walls turned about X by {low} and {high} degrees; shroud side drawn in by {} \
         mm; divided in two. With shank and holder.",
        subject.genetic().job.electrode.radial_reduction_mm
    );
    let why = "The paper draws the steps and prints neither the reductions nor the sizes.".to_owned();
    let by_hand = "sparkpath demo --out DIR --set electrode.circumferential_reduction_deg=[2,2] --set \
        electrode.radial_reduction_mm=0.5 --set electrode.parts=2; in the window the step Electrode";
    let head = ["step", "#electrodes", "#least thickness mm", "#burn area mm²", "#volume mm³"];
    Ok(Outcome {
        tables: vec![Table::new("Electrodes", &head, stages.iter().map(row).collect())],
        pictures: picture("Reduction and division", caption, &[], png).into_iter().collect(),
        ..subject.outcome(
            "Figure 1",
            "Electrode: reduction and division",
            Verdict::NotComparable,
            why + &studio.note(),
            by_hand,
        )
    })
}

/// Size of each view of a sheet (pixels), and its width over its height.
const SHEET: [u32; 2] = [640, 420];
const SHEET_ASPECT: f64 = 640.0 / 420.0;

/// Figure 2: the machine and its axes.
fn machine(subject: &Subject) -> Outcome {
    let Case { job, found, .. } = subject.genetic();
    let row = |axis: Axis| {
        let role = match axis {
            Axis::X => "reference axis: its step is given (1)",
            Axis::A => "copying after the feed; still during the feed",
            Axis::B => "not there",
            Axis::Y | Axis::Z | Axis::C => "variable of every node",
        };
        let moves = found.plan.nodes.iter().any(|node| node.pose.get(axis) != 0.0);
        vec![axis.letter().to_string(), role.to_owned(), if moves { "moves" } else { "still" }.to_owned()]
    };
    let why = "The figure shows a machine and no result. The axes and their roles are the same.".to_owned();
    let by_hand = "machine.axes, machine.travel_x_mm and the like; in the window the step Plan, Machine";
    let caption = format!("Axes of the feed; nodes are {} mm apart", job.plan.step_mm);
    let rows = Axis::ALL.into_iter().map(row).collect();
    Outcome {
        tables: vec![Table::new(&caption, &["axis", "the paper", "ours during the feed"], rows)],
        ..subject.outcome("Figure 2", "Machine tool and its axes", Verdict::NotComparable, why, by_hand)
    }
}

/// Sums over the searched nodes of the best and of the mean objective in each generation, with those nodes.
fn converged(case: &Case) -> (Vec<&Convergence>, [Vec<f64>; 2]) {
    let generations = case.job.genetic.generations;
    let searched: Vec<_> = case.plan().convergence.iter().filter(|c| c.best.len() > generations).collect();
    let sums = |values: fn(&Convergence) -> &Vec<f64>| -> Vec<f64> {
        (0..=generations).map(|g| searched.iter().map(|c| values(c)[g]).sum()).collect()
    };
    let sums = [sums(|c| &c.best), sums(|c| &c.mean)];
    (searched, sums)
}

/// Figure 5: the flow chart, and how the search that it describes converges.
fn convergence(subject: &Subject) -> Outcome {
    let Case { job, .. } = subject.genetic();
    let points = |values: &[f64]| values.iter().enumerate().map(|(i, v)| [i as f64, *v]).collect::<Vec<_>>();
    let plot = |title: String, best: &[f64], mean: &[f64]| {
        let series = [(mean, "mean"), (best, "c0")];
        Plot {
            title,
            x_label: "generation".to_owned(),
            size: [360.0, 190.0],
            series: series.map(|(values, class)| Series { points: points(values), class, dots: false }).to_vec(),
            ..Plot::default()
        }
    };
    let (mut plots, mut rows, mut nodes) = (Vec::new(), Vec::new(), 0);
    for case in &subject.cases[..2] {
        let (searched, [best, mean]) = converged(case);
        plots.push(plot(format!("{}: sum over nodes; mean dashed", case.name), &best, &mean));
        let shown = [0, searched.len() / 3].into_iter().filter_map(|i| searched.get(i));
        plots.extend(shown.map(|c| plot(format!("{}, {} mm out", case.name, number(c.s, 1)), &c.best, &c.mean)));
        rows.extend([0.0, 0.5, 0.9, 0.99, 1.0].map(|share| {
            let generation = reached(&best, share);
            let value = generation.and_then(|g| best.get(g)).map_or(String::new(), |v| number(*v, 4));
            let generation = generation.map_or(String::new(), |g| g.to_string());
            vec![case.name.to_owned(), format!("{:.0} %", 100.0 * share), generation, value]
        }));
        nodes += searched.len();
    }
    let steps = [
        ("coding (8)", "Coding::new, Coding::encode"),
        ("initial population", "GeneticStep::first_population: free individuals only"),
        ("competition", "Roulette::spin, with an elite that passes unchanged"),
        (
            "crossover, mutation",
            "GeneticStep::children: probabilities fall to 0 for the best (Srinivas and Patnaik 1994)",
        ),
        ("decoding (9)", "Coding::decode"),
        ("next node until the electrode is out", "SearchProblem::search; a failed node halves the step"),
    ];
    let steps = steps.map(|(step, ours)| vec![step.to_owned(), ours.to_owned()]).to_vec();
    let why = format!(
        "The figure is the flow chart of the search; the paper shows no convergence. It calls its algorithm adaptive and \
         does not say how. Ours has {} individuals and {} generations for each of the {nodes} nodes of both paths that \
         were searched; what follows outside the blisk is not.",
        job.genetic.population, job.genetic.generations
    );
    Outcome {
        tables: vec![
            Table::new("Steps of the flow chart", &["the paper", "ours"], steps),
            Table::new(
                "Convergence of the sum over nodes",
                &["weights", "share of the improvement", "#generation", "#objective"],
                rows,
            ),
        ],
        plots: plots.iter().map(Plot::svg).collect(),
        ..subject.outcome(
            "Figure 5",
            "Flow chart of the genetic search; its convergence",
            Verdict::NotComparable,
            why,
            BY_GENETIC,
        )
    }
}

/// The first generation in which `share` of the improvement of `best`, which never rises, is reached.
fn reached(best: &[f64], share: f64) -> Option<usize> {
    let (first, last) = (best.first()?, best.last()?);
    // The last value itself must count as reached, whatever rounding does.
    let wanted = (first + share * (last - first)).max(*last);
    best.iter().position(|value| *value <= wanted)
}

/// Weights of (4) to (6), the ranges of (7) and the bits of (8).
fn weights(subject: &Subject) -> Outcome {
    let Case { job, found, .. } = subject.genetic();
    let raw = job.plan.weights;
    let axes = job.machine.axes.free_axes(found.electrode.enters_from);
    let used = raw.normalised(axes);
    let rows = [
        ("a1", "smoothness of Z (4)", raw.a1, used.a1),
        ("b1", "smoothness of Y (4)", raw.b1, used.b1),
        ("c1", "smoothness of C (4)", raw.c1, used.c1),
        ("d1", "smoothness of A, not in the paper", raw.d1, used.d1),
        ("e1", "smoothness of B, not in the paper", raw.e1, used.e1),
        ("a2", "equal least distances (5)", raw.a2, used.a2),
        ("b2", "S_L (5)", raw.b2, used.b2),
        ("c2", "S_R (5)", raw.c2, used.c2),
        ("a3", "Obj1 (6)", raw.a3, used.a3),
        ("b3", "Obj2 (6)", raw.b3, used.b3),
    ];
    let rows = rows.map(|(name, meaning, raw, used)| {
        vec![name.to_owned(), meaning.to_owned(), "not printed".to_owned(), number(raw, 4), number(used, 4)]
    });
    let ranges = axes.iter().map(|axis| {
        let (half, genetic) = (0.5 * found.plan.ranges[*axis as usize], &job.genetic);
        let precision = if axis.is_rotary() { genetic.precision_deg.to_radians() } else { genetic.precision_mm };
        let (shown, unit) = if axis.is_rotary() { (half.to_degrees(), "deg") } else { (half, "mm") };
        let bits = Coding::new(-half, half, precision).bits;
        vec![axis.letter().to_string(), number(shown, 3), unit.to_owned(), bits.to_string()]
    });
    let why =
        "The paper prints the conditions that each group sums to 1, and no values. Ours are scaled to these sums over \
        the axes that move."
            .to_owned();
    let by_hand = "plan.weights.a1 to b3, genetic.precision_mm, genetic.precision_deg; in the window the step Plan, \
        Weights, with the normalised ones below; both are listed among the symbols of report.html";
    Outcome {
        tables: vec![
            Table::new("Weights", &["weight", "of", "the paper", "#given", "#normalised"], rows.to_vec()),
            Table::new(
                "Ranges of motion in one step (7) and bits of the code (8)",
                &["axis", "#half range", "unit", "#bits"],
                ranges.collect(),
            ),
        ],
        ..subject.outcome(
            "Equations 4 to 8",
            "Weights, ranges and coding of the search",
            Verdict::NotComparable,
            why,
            by_hand,
        )
    }
}

/// The two earlier methods that the introduction names.
fn predecessors(subject: &Subject) -> Outcome {
    let rows = [
        [
            "[7] Liao et al. 2007",
            "The objective is known: the least reduction of the electrode's thickness. Variables, constraints and search are \
             not. There is not enough to build the method; its objective is that of our sizing.",
            "sparkpath size; genetic.h = variable adds the cost of a thinner electrode to the objective",
        ],
        [
            "[8], [9] Liu et al. 2012, 2013",
            "One condition is known: the centre line of the electrode stays tangent to that of the channel. Which point of \
             the one lies on the other, and how interference is resolved, is not said. There is not enough to build the \
             method; the nearest that we have is P1's.",
            "plan.strategy = centreline",
        ],
    ];
    let why = "The text gives the idea of each method in a sentence and no result of it.".to_owned();
    Outcome {
        tables: vec![Table::new(
            "Earlier methods",
            &["method", "what the text gives", "nearest of ours"],
            rows.map(|row| row.map(str::to_owned).to_vec()).to_vec(),
        )],
        ..subject.outcome(
            "References 7 to 9",
            "Thickness reduction and tangent centre lines",
            Verdict::NotComparable,
            why,
            "sparkpath size p0_blisk.stl; sparkpath compare p0_blisk.stl --strategies centreline --out DIR, with the mesh of this \
             folder",
        )
    }
}

/// The box around `points`; a box of no size about the origin where there are none.
fn around(points: impl Iterator<Item = glam::DVec3>) -> Bounds {
    let bounds = Bounds::of(points);
    if bounds.min.x <= bounds.max.x { bounds } else { Bounds::of([glam::DVec3::ZERO]) }
}

#[cfg(test)]
mod tests {
    use super::reached;

    #[test]
    fn a_share_of_the_improvement_is_reached_when_the_objective_first_falls_that_far() {
        let best = [10.0, 8.0, 8.0, 4.0, 2.0, 2.0];
        assert_eq!([0.0, 0.25, 0.5, 0.75, 1.0].map(|share| reached(&best, share)), [0, 1, 3, 3, 4].map(Some));
        assert_eq!(reached(&[], 0.5), None);
    }
}
