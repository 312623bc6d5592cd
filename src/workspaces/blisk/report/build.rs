//! The outcome of a plan in the words of the report.

use crate::workspaces::blisk::document::job_file::PlanJob;
use crate::workspaces::blisk::document::job_file::field_table::FIELDS;
use crate::workspaces::blisk::job::burning::WheelBurning;
use crate::workspaces::blisk::job::figures::{Histogram, centroid_way};
use crate::workspaces::blisk::job::node_distances::NodeDistances;
use crate::workspaces::blisk::job::outcome::{ElectrodeOutcome, PlanOutcome};
use crate::workspaces::blisk::report::StageTime;
use crate::workspaces::blisk::report::residual_stock::ResidualStockReport;
use crate::workspaces::blisk::report::simulation::SimulationReport;
use crate::workspaces::blisk::report::verify::SettingReport;
use crate::workspaces::blisk::report::{
    BliskSummary, ClearancePlace, Convergence, ElectrodeReport, Failure, InputFile, Motion, NodeReport,
    ObjectiveReport, PoseReport, Report, SCHEMA, Smoothness, Symbol, Verdict, VerifiedDigests, Written,
};
use feed::certificate::TravelVerdict;
use feed::jam::JamCause;
use feed::plan::{FeedPlan, PlannedPath};
use feed::plan_params::{Constraint, Strategy};
use feed::pose::Axis;
use feed::strategy::SearchStrategy;
use files::ParameterList;
use nc::program::longest_jump;
use wheel::channel::Channel;
use wheel::electrode::{Electrode, EntrySide};

/// The report on `outcome`, without pictures. `inputs` tells which files it was made from. The technology table of `job` is
/// read; why it cannot be read stands in the report.
pub fn report(outcome: &PlanOutcome, job: &PlanJob, inputs: Vec<InputFile>) -> Report {
    let electrodes = outcome.electrodes.iter().enumerate().map(|(i, e)| electrode(i + 1, e, outcome, job)).collect();
    Report {
        schema: SCHEMA,
        program_version: env!("CARGO_PKG_VERSION").to_owned(),
        verdict: verdict(outcome),
        inputs,
        blisk: BliskSummary::of(&outcome.channel),
        parameters: parameters(job),
        symbols: symbols(outcome, job),
        electrodes,
        residual_stock: outcome.residual_stock().map(|l| ResidualStockReport::of(l, &outcome.channel)),
        no_residual_stock: outcome.stock().and_then(|stock| stock.left.as_ref().err()).cloned(),
        burning: WheelBurning::of_job(outcome, job),
        measured: outcome.measured.as_deref().map(Into::into),
        written: Written::default(),
        times: times(outcome),
        pictures: Vec::new(),
        no_pictures: None,
    }
}

/// Whether its number does not say what an electrode burns.
fn is_shared(electrode: &Electrode) -> bool {
    electrode.column.is_some() || electrode.stage.is_some()
}

fn verdict(outcome: &PlanOutcome) -> Verdict {
    let sentences: Vec<String> = outcome
        .electrodes
        .iter()
        .enumerate()
        .map(|(i, e)| {
            let tried = e.tried.iter().map(|(side, why)| format!(" Towards {} it {why}.", side.words()));
            let verdict = e.plan.verdict(&outcome.channel);
            format!(
                "Electrode {}{} towards {} {verdict}.{}",
                i + 1,
                if is_shared(&e.electrode) { format!(" ({})", e.electrode.share()) } else { String::new() },
                e.electrode.enters_from.words(),
                tried.collect::<String>()
            )
        })
        .collect();
    let left = outcome.residual_stock().map(|l| l.sentence(&outcome.channel));
    let simulated = outcome.finishing().into_iter().flat_map(|f| &f.simulations).map(|s| s.sentence());
    // Where one jams, its own sentence says that the search for a remedy was stopped.
    let stopped = outcome.stopped().filter(|_| outcome.is_verified());
    let stopped = stopped.map(|stage| format!("The {stage} was stopped, so that there is no NC program."));
    // That the table of the sections is in order is no news.
    let measured = outcome.measured.as_deref().filter(|walls| !walls.holds()).map(|walls| walls.sentence());
    let all = sentences
        .into_iter()
        .chain(outcome.setting_sentences())
        .chain(simulated)
        .chain(stopped)
        .chain(left)
        .chain(measured);
    let sentence = all.collect::<Vec<_>>().join(" ");
    let exit_code = match (outcome.stopped(), outcome.may_be_approved() && outcome.bears_setting()) {
        (Some(_), _) => 130,
        (None, true) => 0,
        (None, false) => 3,
    };
    Verdict { exit_code, sentence }
}

fn electrode(index: usize, outcome: &ElectrodeOutcome, whole: &PlanOutcome, job: &PlanJob) -> ElectrodeReport {
    let ElectrodeOutcome { electrode, plan, .. } = outcome;
    let certificate = plan.path.as_ref().map(|p| &p.certificate);
    let place = |c: &feed::certificate::Certificate| {
        ClearancePlace::of(c.least(), whole.channel.surface_name(c.least().surface))
    };
    ElectrodeReport {
        index,
        share: electrode.share(),
        enters_from: electrode.enters_from.name().to_owned(),
        extractable: certificate.is_some_and(|c| c.ends_right() && c.certified() > 0.0),
        verified: plan.is_verified(),
        required_clearance_mm: job.of_electrode(index - 1).0.electrode.spark_gap_mm,
        tolerance_mm: job.verify.tolerance_mm,
        certified_clearance_mm: certificate.map(|c| c.certified()),
        preset: outcome.preset_sentence(),
        preset_values: outcome.preset,
        unworn_mm: outcome.unworn_mm,
        longest_jump_mm: plan.path.as_ref().filter(|p| p.certificate.holds()).map(|p| longest_jump(&p.path)),
        least_clearance_mm: certificate.map(|c| c.least().distance),
        least_clearance_at: certificate.map(place),
        nodes: nodes(plan, &outcome.distances),
        smoothness: plan.path.as_ref().map_or(Vec::new(), |p| Smoothness::of(&p.smoothness)),
        volume_mm3: electrode.volume_mm3,
        least_thickness_mm: Some(electrode.least_thickness_mm),
        burn_area_mm2: Some(electrode.burn_area_mm2),
        ga_convergence: convergence(plan),
        feed_lowered: None,
        step: None,
        copying: whole.copying(index - 1).map(Into::into),
        setting: whole.setting(index - 1).map(|room| SettingReport::of(room, |s| whole.channel.surface_name(s))),
        simulation: whole.simulation(index - 1).map(|s| SimulationReport::of(s)),
        sha256: certificate.map(VerifiedDigests::of),
        failure: failure(plan, &whole.channel),
        files: Vec::new(),
        motion: plan
            .path
            .as_ref()
            .map(|p| Motion { rows: p.path.rows.clone(), clearance: p.certificate.row_clearance().to_vec() }),
        centroid: centroid_way(outcome),
        wall_distances: wall_distances(outcome),
    }
}

/// The histograms in the final pose and at the node whose distances are most uneven, P0's figure 4, of those with at least
/// half as many samples between the blades.
fn wall_distances(outcome: &ElectrodeOutcome) -> Vec<(f64, Histogram)> {
    let nodes = || outcome.plan.nodes.iter().zip(&outcome.distances);
    let Some((_, last)) = nodes().next() else { return Vec::new() };
    let samples = |at: &NodeDistances, wall: usize| at.walls[wall].len();
    let is_within = |at: &NodeDistances| (0..2).all(|wall| 2 * samples(at, wall) >= samples(last, wall));
    let unevenness = |at: &NodeDistances| at.spread.deviation.iter().sum::<f64>();
    let within = nodes().skip(1).filter(|(_, at)| is_within(at));
    let worst = within.max_by(|a, b| unevenness(a.1).total_cmp(&unevenness(b.1)));
    let shown = nodes().take(1).chain(worst);
    shown.map(|(node, at)| (node.s, Histogram::of(&at.walls))).collect()
}

fn nodes(plan: &FeedPlan, distances: &[NodeDistances]) -> Vec<NodeReport> {
    let objective = |n: &feed::problem::Node| ObjectiveReport {
        smoothness: n.objective.smoothness,
        centring: n.objective.centring,
        total: n.objective.total,
    };
    plan.nodes
        .iter()
        .enumerate()
        .map(|(node, n)| NodeReport {
            node,
            s_mm: n.s,
            pose: PoseReport::from(&n.pose),
            clearance_mm: n.clearance,
            objective: Some(objective(n)),
            walls_mm: distances.get(node).map(|d| d.spread.into()),
            distances_mm: distances.get(node).map(|d| d.clearances.into()),
        })
        .collect()
}

fn convergence(plan: &FeedPlan) -> Vec<Convergence> {
    // The search of node i + 1 is trace i; nodes that were coasted to or put in have none.
    let searched = plan.convergence.iter().enumerate().filter(|(_, c)| !c.best.is_empty());
    searched.map(|(i, c)| Convergence { node: i + 1, best: c.best.clone(), mean: c.mean.clone() }).collect()
}

/// Reason why there is no verified path, and what would help.
fn failure(plan: &FeedPlan, channel: &Channel) -> Option<Failure> {
    if plan.is_verified() {
        return None;
    }
    let verdict = plan.verdict(channel);
    let name = |surface| channel.surface_name(surface).to_owned();
    if let Some(jam) = &plan.jam {
        let has_other_side = EntrySide::open(channel).len() > 1;
        let other_side =
            |before: &str| if has_other_side { format!("{before} the other side of entry") } else { String::new() };
        let remedy = match jam.cause {
            JamCause::Contact(_) => format!(
                "Increase the circumferential reduction on that wall, divide the channel otherwise{}.",
                other_side(", or take")
            ),
            JamCause::Travel { .. } => {
                format!("Another machine, less exit_clearance_mm{} would help.", other_side(" or"))
            }
            JamCause::NothingLeft { .. } => format!("A smaller h_max_deg, more parts{} may help.", other_side(" or")),
            JamCause::Unknown => "A smaller step_mm, more poses or a larger population may find one.".to_owned(),
        };
        return Some(Failure {
            node: jam.node,
            s_mm: jam.s,
            wall: jam.contact().map(|c| name(c.surface)),
            place: jam.contact().map(|c| c.on_blisk.to_array()),
            sentence: format!("The electrode {verdict}. {remedy}"),
        });
    }
    let PlannedPath { path, certificate: c, .. } = plan.path.as_ref()?;
    let node = |row: usize| path.rows.get(row).map_or(0, |r| r.node);
    let sentence = format!("The electrode {verdict}.");
    // What makes it fail: the ends, the axes' travel, or else the clearance where it is least.
    let elsewhere =
        |row: usize, s_mm| Failure { node: node(row), s_mm, wall: None, place: None, sentence: sentence.clone() };
    Some(match c.travel() {
        _ if !c.keeps_clearance() => Failure {
            node: node(c.least().row as usize),
            s_mm: c.least().s,
            wall: Some(name(c.least().surface)),
            place: Some(c.least().on_blisk.to_array()),
            sentence,
        },
        TravelVerdict::Beyond(beyond) => elsewhere(beyond.row, path.rows.get(beyond.row).map_or(0.0, |r| r.s)),
        TravelVerdict::Within | TravelVerdict::NotJudged => elsewhere(0, path.rows.first().map_or(0.0, |r| r.s)),
    })
}

/// Times of all stages in order.
fn times(outcome: &PlanOutcome) -> Vec<StageTime> {
    let motions = outcome.finishing().into_iter().flat_map(|f| &f.times);
    let stock = outcome.stock().into_iter().flat_map(|stock| &stock.times);
    outcome.times.iter().chain(motions).chain(stock).cloned().collect()
}

/// The strategy of `job` with its parameters.
fn strategy_of(job: &PlanJob) -> &dyn SearchStrategy {
    job.plan.strategy.search(&job.plan, &job.genetic)
}

/// The parameters of `job` but for those of strategies, and of a constraint, that had no part in its plan.
fn parameters(job: &PlanJob) -> ParameterList {
    let own = strategy_of(job).parameters();
    let others = Strategy::ALL.iter().filter_map(|other| other.search(&job.plan, &job.genetic).parameters());
    let constraint = (job.plan.constraint != Constraint::Angle).then_some("plan.angle");
    let idle = others.filter(|other| Some(*other) != own).chain(constraint);
    idle.fold(FIELDS.list(job), ParameterList::without)
}

/// The papers' symbols, and the parameters of the strategy, with the values they had.
fn symbols(outcome: &PlanOutcome, job: &PlanJob) -> Vec<Symbol> {
    let symbol = |symbol: &str, meaning: &str, value: String, unit: &str| Symbol {
        symbol: symbol.to_owned(),
        meaning: meaning.to_owned(),
        value,
        unit: unit.to_owned(),
    };
    let Some(first) = outcome.electrodes.first() else { return Vec::new() };
    let (params, weights) =
        (&job.electrode, job.plan.weights.normalised(job.machine.axes.free_axes(first.electrode.enters_from)));
    let summary = BliskSummary::of(&outcome.channel);
    let first_weight = match Axis::of_withdrawal(first.electrode.enters_from) {
        Axis::Z => "weight of X in (4)",
        _ => "weight of Z in (4)",
    };
    let mut list = vec![
        symbol("R_h", "hub radius over the blades", range_text(summary.hub_radius_mm), "mm"),
        symbol("R_c", "shroud (or tip) radius over the blades", range_text(summary.shroud_radius_mm), "mm"),
        symbol("theta", "angle between neighbouring blades", text(360.0 / outcome.channel.blades as f64), "deg"),
    ];
    // One row where all electrodes have the same.
    let reduction = |(number, e): (usize, &ElectrodeOutcome)| {
        params.of_electrode(number).circumferential_reduction_deg.map(|deg| deg + e.plan.h.to_degrees())
    };
    let reductions: Vec<[f64; 2]> = outcome.electrodes.iter().enumerate().map(reduction).collect();
    let is_same = reductions.iter().all(|walls| *walls == reductions[0]);
    for (number, walls) in reductions.iter().enumerate().take(if is_same { 1 } else { reductions.len() }) {
        let of = if is_same { String::new() } else { format!(" of electrode {}", params.label(number)) };
        let meaning = format!("circumferential reduction{of}, low and high wall");
        list.push(symbol(if number == 0 { "h" } else { "" }, &meaning, range_text(*walls), "deg"));
    }
    list.push(symbol("x_1 - x_0", "distance of nodes", text(job.plan.step_mm), "mm"));
    if params.stage.is_empty() {
        list.insert(3, symbol("delta", "spark gap", text(params.spark_gap_mm), "mm"));
    }
    for stage in params.stage.iter().rev() {
        let of_stage = |what: &str| format!("{what} in the stage {}", stage.name);
        list.insert(3, symbol("", &of_stage("stock left"), text(stage.stock_mm), "mm"));
        list.insert(3, symbol("delta", &of_stage("spark gap"), text(stage.spark_gap_mm), "mm"));
    }
    for (name, meaning, value) in [
        ("a1", first_weight, weights.a1),
        ("b1", "weight of Y in (4)", weights.b1),
        ("c1", "weight of C in (4)", weights.c1),
        ("d1", "weight of A in (4), not in the paper", weights.d1),
        ("e1", "weight of B in (4), not in the paper", weights.e1),
        ("a2", "weight of equal distances in (5)", weights.a2),
        ("b2", "weight of S_L in (5)", weights.b2),
        ("c2", "weight of S_R in (5)", weights.c2),
        ("a3", "weight of smoothness in (6)", weights.a3),
        ("b3", "weight of centring in (6)", weights.b3),
    ] {
        list.push(symbol(name, meaning, text(value), "1"));
    }
    if job.plan.constraint == Constraint::Angle {
        let angle = &job.plan.angle;
        list.push(symbol("Delta1", "distance kept from hub and shroud by the angle test", text(angle.delta1_mm), "mm"));
        list.push(symbol("Delta2", "angle kept by the angle test", text(angle.delta2_deg), "deg"));
    }
    for axis in [Axis::X, Axis::Z, Axis::Y, Axis::A, Axis::B, Axis::C] {
        list.extend(range_symbols(axis, first.plan.ranges[axis as usize], job, &symbol));
    }
    list.extend(strategy_symbols(job, &symbol));
    list
}

/// The parameters of the strategy that was followed.
fn strategy_symbols(job: &PlanJob, symbol: &impl Fn(&str, &str, String, &str) -> Symbol) -> Vec<Symbol> {
    let mut list = vec![symbol("strategy", "how the path is searched for", job.plan.strategy.name().to_owned(), "")];
    list.extend(strategy_of(job).symbols().iter().map(|s| symbol(&s.symbol, s.meaning, text(s.value), s.unit)));
    list
}

/// The range of an axis by (7) and, of a genetic search, the bits it is coded with by (8).
fn range_symbols(
    axis: Axis,
    range: f64,
    job: &PlanJob,
    symbol: &impl Fn(&str, &str, String, &str) -> Symbol,
) -> Vec<Symbol> {
    if range <= 0.0 {
        return Vec::new();
    }
    let half = 0.5 * range;
    let (shown, unit) = if axis.is_rotary() { (half.to_degrees(), "deg") } else { (half, "mm") };
    let range = format!("+-{}", text(shown));
    let mut list = vec![symbol(&format!("Delta_{}", axis.letter()), "range of motion in one step (7)", range, unit)];
    let coded = strategy_of(job).axis_symbols(axis, half);
    list.extend(coded.iter().map(|s| symbol(&s.symbol, s.meaning, text(s.value), s.unit)));
    list
}

fn text(value: f64) -> String {
    let rounded = (value * 1e4).round() / 1e4;
    format!("{rounded}")
}

fn range_text([a, b]: [f64; 2]) -> String {
    if (a - b).abs() < 5e-5 { text(a) } else { format!("{} to {}", text(a), text(b)) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use feed::certificate::Certificate;
    use feed::interpolation::AxisCurves;
    use feed::machine::TravelLimits;
    use feed::objective::ObjectiveValue;
    use feed::path::FeedPath;
    use feed::pose::Pose;
    use feed::problem::Node;
    use feed::smoothness::AxisSmoothness;
    use feed::verify::VerifyOptions;
    use geometry::spline::EndCondition;
    use nc::fixtures;
    use wheel::fixtures::exact_channel;
    use wheel::parametric::ParametricBlisk;

    /// A plan whose path came out, with this certificate.
    fn plan(path: FeedPath, certificate: Certificate) -> FeedPlan {
        let node = |s: f64| {
            let pose = Pose { x: -s, ..Pose::FINAL };
            Node { s, pose, h: 0.0, clearance: 0.1, objective: ObjectiveValue::default() }
        };
        let nodes = vec![node(0.0), node(60.0)];
        let planned = PlannedPath {
            curves: AxisCurves::through(&nodes, EndCondition::NotAKnot).unwrap(),
            path,
            certificate,
            smoothness: [AxisSmoothness::of(&[0.0]); 6],
        };
        FeedPlan {
            nodes,
            convergence: Vec::new(),
            jam: None,
            path: Some(planned),
            h: 0.0,
            remade: None,
            ranges: [0.0; 6],
            probes: 0,
            rounds: 1,
            repairs: 0,
            field_seconds: 0.0,
            search_seconds: 0.0,
            verify_seconds: 0.0,
        }
    }

    #[test]
    fn whatever_keeps_a_path_from_being_verified_is_told() {
        let channel = exact_channel(&ParametricBlisk::turbine());
        let scene = fixtures::Scene::new(wheel::electrode::EntrySide::MinusX);
        let told = |path: &FeedPath, c: &Certificate| failure(&plan(path.clone(), c.clone()), &channel);
        let good = scene.certificate(&scene.path);
        assert_eq!(told(&scene.path, &good), None);
        let verdict = plan(scene.path.clone(), good.clone()).verdict(&channel);
        let certified = format!("{:.4} mm; 0.1000 mm less the tolerance of 0.0020 mm are required", good.certified());
        assert!(verdict.contains(&certified), "{verdict}");

        let narrow = scene.with_wall_nearer_by(0.02).certificate(&scene.path);
        let close = told(&scene.path, &narrow).unwrap();
        let least = narrow.least();
        assert!((least.s - 3.0).abs() < 0.5, "where the clearance is least: {least:?}");
        assert_eq!((close.s_mm, close.place), (least.s, Some(least.on_blisk.to_array())));
        assert!(close.wall.is_some() && close.node == scene.path.rows[least.row as usize].node);

        let mut inside = scene.path.clone();
        inside.rows.drain(..60);
        let ends = told(&inside, &scene.certificate(&inside)).unwrap();
        assert!(ends.sentence.contains("begin wholly outside") && ends.s_mm == 30.0 && ends.place.is_none());

        // C turns a little the other way first, seen from the final pose.
        let limits = TravelLimits::UNLIMITED.with(Axis::C, [-0.001, 1.0]);
        let beyond = scene.verified(&scene.path, &VerifyOptions::default(), Some(limits)).unwrap();
        let TravelVerdict::Beyond(found) = beyond.travel() else { panic!("{beyond:?}") };
        let travel = told(&scene.path, &beyond).unwrap();
        assert!(travel.sentence.contains("axis C") && travel.wall.is_none());
        assert!(found.row > 0 && travel.s_mm == scene.path.rows[found.row].s, "{found:?}");
    }

    #[test]
    fn only_parameters_that_had_a_part_in_the_plan_are_listed() {
        let mut job = PlanJob::demonstration();
        let symbol = |symbol: &str, meaning: &str, value: String, unit: &str| {
            let [symbol, meaning, unit] = [symbol, meaning, unit].map(str::to_owned);
            Symbol { symbol, meaning, value, unit }
        };
        let of_one = [
            (Strategy::Genetic, "genetic", "p_m"),
            (Strategy::Global, "plan.global", "poses"),
            (Strategy::Centreline, "plan.centreline", "increase"),
        ];
        for (strategy, section, named) in of_one {
            job.plan.strategy = strategy;
            let listed = parameters(&job);
            let has = |key: &str| {
                let is_entered = listed.entries.iter().any(|e| e.key.starts_with(&format!("{key}.")) || e.key == key);
                assert_eq!(is_entered, !files::get(&listed.tree, key).is_null(), "{key}");
                is_entered
            };
            assert!(!has("plan.angle") && has("plan.step_mm"));
            let symbols = strategy_symbols(&job, &symbol);
            for (_, other, name) in of_one {
                assert_eq!(has(other), other == section, "{strategy:?} {other}");
                assert_eq!(symbols.iter().any(|s| s.symbol == name), name == named, "{strategy:?} {name}");
            }
        }
        job.plan.constraint = Constraint::Angle;
        assert!(parameters(&job).entries.iter().any(|e| e.label == "Angle of the angle test" && e.unit == "deg"));
    }
}
