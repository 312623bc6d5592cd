//! Runs of several strategies on the same electrodes, side by side: as P0's figure 7 compares smoothness.

mod page;

use std::fmt::Write;

use serde::Serialize;

use crate::workspaces::blisk::report::{InputFile, ObjectiveReport, ReportError, Smoothness};
use feed::plan::FeedPlan;
use feed::plan_params::Strategy;
use feed::pose::Axis;
use files::ParameterList;
use wheel::channel::Channel;
use wheel::electrode::Electrode;

/// Version of the keys of `comparison.json`.
pub const SCHEMA: u32 = 1;
/// Intervals that a curve is sampled in.
const INTERVALS: usize = 240;

/// Runs on one job.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Comparison {
    /// [`SCHEMA`].
    pub schema: u32,
    /// Version of the program.
    pub program_version: &'static str,
    /// Files that went in.
    pub inputs: Vec<InputFile>,
    /// Withdrawn distance from one value to the next, of which differences are taken (mm).
    pub step_mm: f64,
    /// Every parameter of the job but the strategy, defaults included.
    pub parameters: ParameterList,
    /// The runs in the order that was asked for.
    pub runs: Vec<Run>,
}

/// What one strategy found.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Run {
    /// The strategy.
    pub strategy: Strategy,
    /// Reason why it cannot be followed on this job, if it cannot.
    pub failure: Option<String>,
    /// Results of the electrodes, in the order of their parts; none after a failure.
    pub electrodes: Vec<RunElectrode>,
}

/// What one strategy found for one electrode. Lengths in mm, angles in degrees.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct RunElectrode {
    /// Number of the electrode, counted from 1.
    pub index: usize,
    /// Part of the channel that the electrode burns where the channel is divided; empty for a single electrode.
    pub share: String,
    /// `-x`, `+x` or `outward`, in W.
    pub enters_from: &'static str,
    /// The axis along which it is withdrawn, which moves evenly with the distance.
    #[serde(skip)]
    pub withdrawn: Axis,
    /// The answer in a sentence.
    pub verdict: String,
    /// Whether its path is certified.
    pub certified: bool,
    /// Proven lower bound of the clearance over the whole motion (mm); none without a path.
    pub certified_clearance_mm: Option<f64>,
    /// Smallest clearance met (mm).
    pub least_clearance_mm: Option<f64>,
    /// Search nodes, that of the final pose included.
    pub nodes: usize,
    /// Rows of the path; 0 without one.
    pub rows: usize,
    /// Time of the search (s).
    pub search_seconds: f64,
    /// Time of the certificate (s).
    pub certificate_seconds: f64,
    /// P0's objective, summed over all nodes; more nodes make greater sums.
    pub objective_sums: ObjectiveReport,
    /// Smoothness of each axis that moves; empty without a path.
    pub smoothness: Vec<Smoothness>,
    /// The axes that move, as plots show them.
    pub curves: Vec<AxisCourse>,
}

/// How an axis moves over the withdrawn distance: `[s, value]`, s in mm, values in mm or degrees.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct AxisCourse {
    /// The axis letter.
    pub axis: char,
    /// `mm` or `deg`.
    pub unit: &'static str,
    /// Values at the nodes, from the final pose outwards.
    pub nodes: Vec<[f64; 2]>,
    /// The curve through them, at equal distances; empty without a path.
    pub curve: Vec<[f64; 2]>,
}

impl Run {
    /// Whether every electrode has a certified path.
    pub fn is_certified(&self) -> bool {
        !self.electrodes.is_empty() && self.electrodes.iter().all(|e| e.certified)
    }
}

impl RunElectrode {
    /// The figures of `plan` for `electrode`, which is number `index` from 1.
    pub fn of(index: usize, plan: &FeedPlan, electrode: &Electrode, channel: &Channel) -> Self {
        let path = plan.path.as_ref();
        let sum = |part: fn(&ObjectiveReport) -> f64| {
            let value = |n: &feed::problem::Node| ObjectiveReport {
                smoothness: n.objective.smoothness,
                centring: n.objective.centring,
                total: n.objective.total,
            };
            plan.nodes.iter().map(value).map(|o| part(&o)).sum()
        };
        Self {
            index,
            share: electrode.share(),
            enters_from: electrode.enters_from.name(),
            withdrawn: Axis::of_withdrawal(electrode.enters_from),
            verdict: plan.verdict(channel),
            certified: plan.is_verified(),
            certified_clearance_mm: path.map(|p| p.certificate.certified()),
            least_clearance_mm: path.map(|p| p.certificate.least().distance),
            nodes: plan.nodes.len(),
            rows: path.map_or(0, |p| p.path.rows.len()),
            search_seconds: plan.search_seconds,
            certificate_seconds: plan.verify_seconds,
            objective_sums: ObjectiveReport {
                smoothness: sum(|o| o.smoothness),
                centring: sum(|o| o.centring),
                total: sum(|o| o.total),
            },
            smoothness: path.map_or(Vec::new(), |p| Smoothness::of(&p.smoothness)),
            curves: courses(plan),
        }
    }

    /// How `axis` moves, if it does.
    pub fn course(&self, axis: char) -> Option<&AxisCourse> {
        self.curves.iter().find(|course| course.axis == axis)
    }
}

/// How each axis moves that does.
pub fn courses(plan: &FeedPlan) -> Vec<AxisCourse> {
    let way = plan.nodes.last().map_or(0.0, |n| n.s);
    let course = |axis: Axis| {
        let shown = |v: f64| if axis.is_rotary() { v.to_degrees() } else { v };
        let curve = plan.path.as_ref().map(|p| p.curves.axis(axis));
        let at = |i: usize| way * i as f64 / INTERVALS as f64;
        AxisCourse {
            axis: axis.letter(),
            unit: if axis.is_rotary() { "deg" } else { "mm" },
            nodes: plan.nodes.iter().map(|n| [n.s, shown(n.pose.get(axis))]).collect(),
            curve: curve.map_or(Vec::new(), |c| (0..=INTERVALS).map(|i| [at(i), shown(c.at(at(i))[0])]).collect()),
        }
    };
    let moves = |axis: &Axis| plan.nodes.iter().any(|n| n.pose.get(*axis) != 0.0);
    Axis::ALL.into_iter().filter(moves).map(course).collect()
}

/// Columns of `comparison.csv`.
const COLUMNS: &str = "strategy,electrode,enters_from,certified,certified_clearance_mm,nodes,rows,search_s,\
    certificate_s,objective_smoothness_sum,objective_centring_sum,objective_total_sum,axis,unit,total_variation,\
    rms_second_difference,max_second_difference,sign_changes_first_difference";

impl Comparison {
    /// Whether a strategy has a certified path for every electrode.
    pub fn has_certified(&self) -> bool {
        self.runs.iter().any(Run::is_certified)
    }

    /// The comparison as JSON, keys in the order of the structs.
    ///
    /// # Errors
    /// [`ReportError::Json`], which nothing in it could cause.
    pub fn json(&self) -> Result<String, ReportError> {
        Ok(serde_json::to_string_pretty(self)? + "\n")
    }

    /// One row a strategy, electrode and moving axis; cells are empty where there is no path or no electrode.
    pub fn csv(&self) -> String {
        let mut out = format!("{COLUMNS}\n");
        for run in &self.runs {
            if run.electrodes.is_empty() {
                let _ =
                    writeln!(out, "{},,,false{}", run.strategy.name(), ",".repeat(COLUMNS.matches(',').count() - 3));
            }
            run.electrodes.iter().for_each(|e| csv_rows(&mut out, run.strategy, e));
        }
        out
    }

    /// The comparison as one self-contained page.
    ///
    /// # Errors
    /// [`ReportError::Page`], which a test of the template keeps from happening.
    pub fn html(&self) -> Result<String, ReportError> {
        Ok(page::page(self)?)
    }
}

fn csv_rows(out: &mut String, strategy: Strategy, e: &RunElectrode) {
    let clearance = e.certified_clearance_mm.map(|c| c.to_string()).unwrap_or_default();
    let ObjectiveReport { smoothness, centring, total } = e.objective_sums;
    let figures = [e.search_seconds, e.certificate_seconds, smoothness, centring, total].map(|v| v.to_string());
    let electrode = format!(
        "{},{},{},{},{clearance},{},{},{}",
        strategy.name(),
        e.index,
        e.enters_from,
        e.certified,
        e.nodes,
        e.rows,
        figures.join(",")
    );
    if e.smoothness.is_empty() {
        let _ = writeln!(out, "{electrode},,,,,,");
    }
    for a in &e.smoothness {
        let [variation, rms, most] = [a.total_variation, a.rms_second_difference, a.max_second_difference];
        let turns = a.sign_changes_first_difference;
        let _ = writeln!(out, "{electrode},{},{},{variation},{rms},{most},{turns}", a.axis, a.unit);
    }
}

#[cfg(test)]
mod tests;
