//! Planning of one electrode: search, interpolation and verification, and another search where the verifier finds less
//! clearance than the search did.

use std::f64::consts::TAU;
use std::sync::Arc;
use std::time::Instant;

use glam::DVec3;

use super::centreline::Guide;
use super::certificate::{Certificate, Contact, TravelVerdict};
use super::clearance::ClearanceModel;
use super::genetic::{GeneticParams, ReductionMode};
use super::global::PreviewPath;
use super::interpolation::{AxisCurves, Lever, PathFrame, feed_path};
use super::jam::{Jam, JamCause, Opening};
use super::machine::BeyondTravel;
use super::path::FeedPath;
use super::plan::{FeedPlan, PlanSettings, PlannedPath, Remake};
use super::plan_params::PlanError;
use super::pose::{Axis, Pose};
use super::prepared::{PlanningSpace, PreparedElectrode};
use super::probes::Turns;
use super::problem::{Convergence, Node};
use super::samples::Sample;
use super::setup::{Refinements, SearchSetup};
use super::sizing::Sizer;
use super::smoothness::axis_smoothness;
use super::verify::Verifier;
use geometry::frame::Frame;
use task::Task;
use wheel::centreline::Centreline;
use wheel::electrode::{Electrode, ElectrodeError, ElectrodeFace};

/// Plans the feed path of `electrode` in `space`. `remake` is called where the strategy searches h too.
pub fn plan_feed(
    space: &PlanningSpace,
    electrode: &Arc<Electrode>,
    settings: &PlanSettings,
    remake: &Remake,
    task: &Task,
) -> Result<FeedPlan, PlanError> {
    settings.validate()?;
    let guide = match settings.strategy().follows_centreline() {
        true => Some(Guide::new(Centreline::of_channel(&space.channel, &task.cancel)?, &space.channel, electrode)?),
        false => None,
    };
    Planning { setup: SearchSetup { space, settings, turns: Turns::NONE, guide }, task }.plan(electrode, remake)
}

/// Electrode with its walls drawn in, and the prepared electrode that its clearances are computed with.
#[derive(Clone, Copy)]
pub struct DrawnIn<'a> {
    /// The prepared electrode.
    pub prepared: &'a PreparedElectrode,
    /// Angles by which the walls are drawn in from those of the prepared electrode (rad).
    pub turns: Turns,
    /// The electrode with its walls drawn in.
    pub electrode: &'a Electrode,
}

/// Plans the feed path of a prepared electrode.
pub fn plan_drawn_in(
    space: &PlanningSpace,
    drawn_in: &DrawnIn,
    settings: &PlanSettings,
    task: &Task,
) -> Result<FeedPlan, PlanError> {
    settings.validate()?;
    let &DrawnIn { prepared, turns, electrode } = drawn_in;
    Planning { setup: SearchSetup { space, settings, turns, guide: None }, task }.plan_drawn_in(electrode, prepared)
}

/// Preview of the extraction path of a prepared electrode: neither polished nor verified.
pub fn preview_path(
    space: &PlanningSpace,
    drawn_in: &DrawnIn,
    settings: &PlanSettings,
    task: &Task,
) -> Result<PreviewPath, PlanError> {
    settings.validate()?;
    let &DrawnIn { prepared, turns, electrode } = drawn_in;
    let model = prepared.model(space, settings.side_demand(), &task.cancel)?;
    Planning { setup: SearchSetup { space, settings, turns, guide: None }, task }.preview_path(electrode, &model)
}

/// What a search works with: the clearances, the genetic parameters and what the verifier taught.
type Search<'a> = (&'a ClearanceModel<'a>, &'a GeneticParams, &'a Refinements);

/// Plans one electrode.
struct Planning<'a> {
    setup: SearchSetup<'a>,
    task: &'a Task,
}

impl Planning<'_> {
    /// Searches after the first that findings of the verifier may cause, and the greatest number of path repairs.
    const ROUNDS: usize = 8;
    /// Extra clearance beyond what the verifier found missing, so that the next search does not end at the same place
    /// (mm).
    const BEYOND: f64 = 0.003;

    /// Plans `electrode`; where h is searched for too, plans the electrode that `remake` makes with the h found.
    fn plan(&self, electrode: &Arc<Electrode>, remake: &Remake) -> Result<FeedPlan, PlanError> {
        let started = Instant::now();
        let prepared = self.prepared(electrode.clone())?;
        let sides = self.setup.settings.side_demand();
        let model = prepared.model(self.setup.space, sides, &self.task.cancel)?;
        let mut plan = self.nothing_yet(electrode, &model);
        plan.field_seconds = started.elapsed().as_secs_f64();
        let mut genetic = *self.setup.settings.genetic;
        self.search(&mut plan, (&model, &genetic, &Refinements::default()), 0)?;
        plan.h = plan.nodes.iter().map(|n| n.h).fold(0.0, f64::max);
        if plan.jam.is_some() {
            return Ok(plan);
        }
        genetic.h = ReductionMode::Given;
        if plan.h > 0.0 {
            // An electrode with more reduction lies inside one with less, so its path stays free.
            let remade = match remake(plan.h) {
                Ok(remade) => Arc::new(remade),
                Err(error) if leaves_nothing(&error) => {
                    plan.jam = plan.nodes.last().map(|node| nothing_left(plan.nodes.len(), node, plan.h));
                    return Ok(plan);
                }
                Err(error) => return Err(error.into()),
            };
            let prepared = self.prepared(remade.clone())?;
            plan.nodes.iter_mut().for_each(|node| node.h = 0.0);
            let model = prepared.model(self.setup.space, sides, &self.task.cancel)?;
            self.verify_and_repair(&mut plan, &remade, &model, &genetic)?;
            plan.remade = Some(remade);
        } else {
            self.verify_and_repair(&mut plan, electrode, &model, &genetic)?;
        }
        Ok(plan)
    }

    /// Plans `electrode`, which is the prepared one with its walls drawn in by the turns of the setup.
    fn plan_drawn_in(&self, electrode: &Electrode, prepared: &PreparedElectrode) -> Result<FeedPlan, PlanError> {
        let sides = self.setup.settings.side_demand();
        let model = &prepared.model_of(electrode, self.setup.space, sides, &self.task.cancel)?;
        let mut plan = self.nothing_yet(electrode, model);
        let genetic = GeneticParams { h: ReductionMode::Given, ..*self.setup.settings.genetic };
        self.search(&mut plan, (model, &genetic, &Refinements::default()), 0)?;
        match &mut plan.jam {
            None => self.verify_and_repair(&mut plan, electrode, model, &genetic)?,
            Some(jam) if self.setup.settings.explain && jam.contact().is_some() => {
                let known = jam.place_and_cause(&self.setup.space.channel);
                let task = &self.task.as_stage_about(Opening::SEARCH, &known);
                let model = &prepared.model(self.setup.space, sides, &self.task.cancel)?;
                jam.opening = Some(match self.opening(prepared.electrode(), model, task) {
                    // Where it jams is known all the same.
                    Err(PlanError::Cancelled(_)) => Opening::stopped(),
                    opening => opening?,
                });
            }
            Some(_) => {}
        }
        Ok(plan)
    }

    /// Preview of the extraction path.
    fn preview_path(&self, electrode: &Electrode, model: &ClearanceModel) -> Result<PreviewPath, PlanError> {
        let surface_of = |p: DVec3| self.setup.space.finder.surface_of(p);
        let plan = self.nothing_yet(electrode, model);
        let way = self.setup.with_problem(plan.ranges, model, &Refinements::default(), |problem| {
            problem.preview_path(&self.setup.settings.plan.global, &surface_of, self.task)
        });
        Ok(way?)
    }

    /// Further reduction that would open a path of a prepared electrode with its `model`.
    fn opening(&self, electrode: &Electrode, model: &ClearanceModel, task: &Task) -> Result<Opening, PlanError> {
        /// Tolerance of that angle (rad).
        const TOLERANCE: f64 = 0.0005;
        /// The greatest angle tried is this share of that from blade to blade, within these limits (rad).
        const MOST_OF_PITCH: f64 = 0.15;
        const MOST: [f64; 2] = [0.05, 0.1];
        let SearchSetup { space, settings, .. } = self.setup;
        let most = (MOST_OF_PITCH * TAU / space.channel.blades as f64).clamp(MOST[0], MOST[1]);
        let sizer = Sizer { space, electrode, model, settings, tolerance: TOLERANCE, most, task };
        sizer.opening(self.setup.turns)
    }

    fn nothing_yet(&self, electrode: &Electrode, model: &ClearanceModel) -> FeedPlan {
        FeedPlan {
            nodes: Vec::new(),
            convergence: Vec::new(),
            jam: None,
            path: None,
            h: 0.0,
            remade: None,
            ranges: self.setup.ranges(electrode),
            probes: model.probes(),
            rounds: 0,
            repairs: 0,
            field_seconds: 0.0,
            search_seconds: 0.0,
            verify_seconds: 0.0,
        }
    }

    /// Verifies the path. Where clearance is missing, adds the contacts to the samples and repairs the path, or
    /// searches again from there in finer steps where that is not enough, until the path holds or the rounds are spent.
    fn verify_and_repair(
        &self,
        plan: &mut FeedPlan,
        electrode: &Electrode,
        model: &ClearanceModel,
        genetic: &GeneticParams,
    ) -> Result<(), PlanError> {
        let verifier =
            Verifier::new(&self.setup.space.blisk, &electrode.mesh, electrode.reference_point, &self.task.cancel)?
                .within(self.setup.settings.machine.pose_limits());
        let mut refinements = Refinements::default();
        loop {
            let (curves, path) =
                interpolated(&plan.nodes, electrode, self.setup.settings, self.setup.space.channel.frame)?;
            let started = Instant::now();
            let surface_of = |p: DVec3| self.setup.space.finder.surface_of(p);
            let certificate = verifier.verify(&path, &surface_of, self.setup.settings.verify, self.task)?;
            plan.verify_seconds += started.elapsed().as_secs_f64();
            let beyond = match certificate.travel() {
                TravelVerdict::Beyond(beyond) => Some(beyond),
                TravelVerdict::Within | TravelVerdict::NotJudged => None,
            };
            let only_ends_wrong = !certificate.ends_right() && certificate.keeps_clearance() && beyond.is_none();
            if certificate.holds() || plan.rounds > Self::ROUNDS || only_ends_wrong {
                plan.path = Some(planned_path(curves, path, certificate, self.setup.settings));
                return Ok(());
            }
            // The proven bound may fall short where no point met does: then the nearest is what to learn from.
            let mut contacts = certificate.violations().to_vec();
            if contacts.is_empty() && !certificate.keeps_clearance() {
                contacts.push(*certificate.least());
            }
            self.learn(&mut refinements, model, &contacts);
            let mut nearest = contacts.iter().map(|c| c.s).fold(f64::INFINITY, f64::min);
            if let Some(beyond) = beyond {
                self.stay_within(&mut refinements, &beyond);
                // The first row is the furthest out: the nodes before any row that is beyond are not touched.
                let limits = self.setup.settings.machine.pose_limits();
                let rows = path.rows.iter().filter(|row| limits.beyond(&row.pose).is_some());
                nearest = rows.map(|row| row.s).fold(nearest, f64::min);
                refinements
                    .fine
                    .push([nearest - self.setup.settings.plan.step_mm, nearest + self.setup.settings.plan.step_mm]);
            }
            let kept = plan.nodes.iter().filter(|n| n.s < nearest - self.setup.settings.plan.step_mm).count().max(1);
            let model = model.with_probes(&refinements.on_electrode, &refinements.on_blisk, &self.task.cancel)?;
            if beyond.is_none() && plan.repairs < Self::ROUNDS && self.repair(plan, &model, &refinements)? {
                plan.repairs += 1;
                continue;
            }
            self.search_from(plan, (&model, genetic, &refinements), kept)?;
            if plan.jam.is_some() {
                return Ok(());
            }
        }
    }

    fn learn(&self, refinements: &mut Refinements, model: &ClearanceModel, violations: &[Contact]) {
        let step = self.setup.settings.plan.step_mm;
        for contact in violations {
            let lack = (self.setup.settings.spark_gap - contact.distance).max(0.0);
            let (point, face) = model.before_turning(contact.on_electrode, self.setup.turns);
            let extra = lack + Self::BEYOND;
            refinements.on_electrode.push(Sample { point, face, extra, stays_to: Sample::ALWAYS });
            let face = ElectrodeFace::FarEnd;
            refinements.on_blisk.push(Sample { point: contact.on_blisk, face, extra, stays_to: Sample::ALWAYS });
            refinements.fine.push([contact.s - step, contact.s + step]);
        }
    }

    /// Keeps the nodes away from an end of travel that the curve between them overshot, by twice the overshoot.
    fn stay_within(&self, refinements: &mut Refinements, beyond: &BeyondTravel) {
        let limits = refinements.travel.unwrap_or_else(|| self.setup.settings.machine.pose_limits());
        let by = 2.0 * (beyond.value - beyond.limit).abs();
        let [least, greatest] = limits.of(beyond.axis);
        let drawn_in = if beyond.value < beyond.limit { [least + by, greatest] } else { [least, greatest - by] };
        // The final pose has to stay within.
        let travel = [drawn_in[0].min(0.0), drawn_in[1].max(0.0)];
        refinements.travel = Some(limits.with(beyond.axis, travel));
    }

    /// Searches on from the first `kept` nodes; where that jams, from half as many, down to the final pose: a late
    /// contact may forbid a path that was taken early.
    fn search_from(&self, plan: &mut FeedPlan, with: Search, kept: usize) -> Result<(), PlanError> {
        let known = plan.nodes.clone();
        // A whole path begins anew in any case.
        let mut kept = if self.setup.settings.strategy().is_whole() { 0 } else { kept };
        loop {
            plan.nodes.clone_from(&known);
            self.search(plan, with, kept)?;
            if plan.jam.is_none() || kept <= 1 || plan.rounds > Self::ROUNDS {
                return Ok(());
            }
            kept /= 2;
        }
    }

    /// Searches on from the first `kept` nodes of the plan, replaces the rest by the result and repairs the curve.
    fn search(&self, plan: &mut FeedPlan, (model, genetic, refinements): Search, kept: usize) -> Result<(), PlanError> {
        let started = Instant::now();
        let settings = self.setup.settings;
        let strategy = settings.plan.strategy.search(settings.plan, genetic);
        // A whole path keeps none of the nodes, but begins near all of them.
        let (kept, known) = if strategy.is_whole() { (0, &plan.nodes[..]) } else { (kept, &plan.nodes[..kept]) };
        let surface_of = |p: DVec3| self.setup.space.finder.surface_of(p);
        let outcome = self.setup.with_problem(plan.ranges, model, refinements, |problem| {
            problem.search(strategy, known, &surface_of, self.task)
        })?;
        plan.convergence.truncate(kept.saturating_sub(1));
        plan.convergence.extend(outcome.convergence);
        plan.nodes = outcome.nodes;
        plan.jam = outcome.jam;
        plan.probes = model.probes();
        plan.rounds += 1;
        plan.search_seconds += started.elapsed().as_secs_f64();
        if plan.jam.is_none() {
            // Where it cannot be mended the verifier says what is missing.
            self.repair(plan, model, refinements)?;
        }
        Ok(())
    }

    /// Inserts nodes where the curve lacks clearance between those that were searched; returns whether that was enough
    /// as far as the probes tell. If not, the plan stays as it is.
    fn repair(
        &self,
        plan: &mut FeedPlan,
        model: &ClearanceModel,
        refinements: &Refinements,
    ) -> Result<bool, PlanError> {
        let started = Instant::now();
        let repaired = self.setup.with_problem(plan.ranges, model, refinements, |problem| {
            // What was learned may ask for more than a dent: the whole path gives way a little.
            let nodes = match plan.rounds > 0 && !refinements.is_empty() {
                true => self.setup.settings.strategy().polished(problem, plan.nodes.clone(), &self.task.cancel)?,
                false => plan.nodes.clone(),
            };
            problem.repaired(&nodes, &self.task.cancel)
        })?;
        plan.search_seconds += started.elapsed().as_secs_f64();
        let Some(nodes) = repaired else { return Ok(false) };
        let mut searched = std::mem::take(&mut plan.convergence).into_iter().peekable();
        for node in &nodes[1..] {
            plan.convergence.push(searched.next_if(|c| c.s == node.s).unwrap_or_else(|| Convergence::none(node.s)));
        }
        plan.nodes = nodes;
        Ok(true)
    }

    fn prepared(&self, electrode: Arc<Electrode>) -> Result<PreparedElectrode, PlanError> {
        let PlanSettings { plan, genetic, spark_gap, .. } = *self.setup.settings;
        let most = if genetic.h == ReductionMode::Variable { genetic.h_max_deg.to_radians() } else { 0.0 };
        PreparedElectrode::new(self.setup.space, electrode, spark_gap + plan.margin_mm, most, self.task)
    }
}

/// The curves through `nodes` and the rows along them; `frame` is W in the coordinates of the loaded mesh.
pub(super) fn interpolated(
    nodes: &[Node],
    electrode: &Electrode,
    settings: &PlanSettings,
    frame: Frame,
) -> Result<(AxisCurves, FeedPath), PlanError> {
    let params = settings.plan.interpolation;
    let curves = AxisCurves::through(nodes, params.joining())?;
    let reference_point = electrode.reference_point;
    let frame = PathFrame { frame, reference_point, spark_gap: settings.spark_gap };
    let path = feed_path(&curves, params.chord_error_mm, lever(electrode, nodes), frame)?;
    Ok((curves, path))
}

/// The path with its figures of smoothness.
pub(super) fn planned_path(
    curves: AxisCurves,
    path: FeedPath,
    certificate: Certificate,
    settings: &PlanSettings,
) -> PlannedPath {
    let smoothness = Axis::ALL.map(|axis| axis_smoothness(&curves, axis, settings.plan.step_mm));
    PlannedPath { curves, path, certificate, smoothness }
}

/// Whether an electrode cannot be made because its reductions leave nothing of it.
fn leaves_nothing(error: &ElectrodeError) -> bool {
    use ElectrodeError::{NoHeight, NoMetal, Params};
    matches!(error, NoMetal { .. } | NoHeight { .. } | Params(_))
}

/// Jam of a search whose path, `nodes` nodes long to `last`, takes more reduction than the electrode has metal.
fn nothing_left(nodes: usize, last: &Node, h: f64) -> Jam {
    Jam { node: nodes - 1, s: last.s, pose: last.pose, cause: JamCause::NothingLeft { h }, opening: None }
}

/// How far the electrode's points move when axes turn, over all of `nodes`.
fn lever(electrode: &Electrode, nodes: &[Node]) -> Lever {
    let reach = electrode.mesh.vertices.iter().map(|v| v.distance(electrode.reference_point)).fold(0.0, f64::max);
    let from_axis = |pose: &Pose| {
        let slid = electrode.reference_point + DVec3::new(pose.x, pose.y, pose.z);
        slid.y.hypot(slid.z) + reach
    };
    Lever { radius: nodes.iter().map(|n| from_axis(&n.pose)).fold(0.0, f64::max), reach }
}
