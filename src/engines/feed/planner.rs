//! The loop of search, interpolation and verification for one electrode.

use std::sync::Arc;
use std::time::Instant;

use glam::DVec3;

use super::angle_test::AngleTest;
use super::centreline::Guide;
use super::certificate::{Certificate, Contact, TravelVerdict};
use super::clearance::ClearanceModel;
use super::genetic::{GeneticParams, ReductionMode};
use super::global::CoarseWay;
use super::interpolation::{AxisCurves, Lever, PathFrame, feed_path};
use super::jam::{Jam, JamCause};
use super::machine::{BeyondTravel, TravelLimits};
use super::objective::Objective;
use super::path::FeedPath;
use super::plan::{FeedPlan, PlanSettings, PlannedPath, PlanningSpace, Remake};
use super::plan_params::PlanError;
use super::pose::{Axis, Pose};
use super::prepared::PreparedElectrode;
use super::probes::{Demand, Turns};
use super::samples::Sample;
use super::search::{Constraint, Convergence, Node, SearchProblem, Strategy, StrategyParams};
use super::sizing::{Opening, Sizer};
use super::smoothness::axis_smoothness;
use super::verify::Verifier;
use geometry::distance_field::DistanceField;
use geometry::frame::Frame;
use task::{Cancel, Progress};
use wheel::electrode::{Electrode, ElectrodeError, ElectrodeFace};

/// Plans one electrode.
pub(super) struct Planner<'a> {
    pub(super) space: &'a PlanningSpace,
    pub(super) settings: &'a PlanSettings<'a>,
    /// How far the walls are drawn in from those of the electrode that was prepared.
    pub(super) turns: Turns,
    pub(super) progress: &'a Progress,
    pub(super) cancel: &'a Cancel,
    /// The way of the electrode, where the strategy follows a line.
    pub(super) guide: Option<Guide>,
}

/// What the verifier has taught the search so far.
#[derive(Default)]
pub(super) struct Lessons {
    /// Points of the electrode that came too near.
    on_electrode: Vec<Sample>,
    /// Points of the blisk that it came too near to.
    on_blisk: Vec<Sample>,
    /// Stretches of withdrawn distance to be searched in finer steps (mm).
    fine: Vec<[f64; 2]>,
    /// Travel to be kept to at the nodes, where the curve between them went beyond the machine's.
    travel: Option<TravelLimits>,
}

impl Lessons {
    fn is_empty(&self) -> bool {
        self.on_electrode.is_empty() && self.on_blisk.is_empty() && self.travel.is_none()
    }
}

impl Planner<'_> {
    /// Searches after the first that the verifier's findings may cause, and times that they are mended instead.
    const ROUNDS: usize = 8;
    /// Clearance that nodes keep beyond what is asked for, for the errors of the fields and for what the curve between
    /// them takes (mm).
    const GUARD: f64 = 2.0 * DistanceField::ACCURACY;
    /// Beyond what the verifier found missing, so that the next search does not end just where this one did (mm).
    const BEYOND: f64 = 0.003;

    /// Plans `electrode`; where h is searched for too, the one that `remake` makes in the end.
    pub(super) fn plan(&self, electrode: &Arc<Electrode>, remake: &Remake) -> Result<FeedPlan, PlanError> {
        let started = Instant::now();
        let prepared = self.prepared(electrode.clone())?;
        let model = prepared.model(self.space);
        let mut plan = self.nothing_yet(electrode, &model);
        plan.field_seconds = started.elapsed().as_secs_f64();
        let mut genetic = *self.settings.genetic;
        self.search(&mut plan, &model, &genetic, &Lessons::default(), 0)?;
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
            self.verify_and_mend(&mut plan, &remade, &prepared.model(self.space), &genetic)?;
            plan.remade = Some(remade);
        } else {
            self.verify_and_mend(&mut plan, electrode, &model, &genetic)?;
        }
        Ok(plan)
    }

    /// Plans `electrode`, which is the prepared one with its walls drawn in by [`turns`](Self::turns).
    pub(super) fn plan_drawn_in(
        &self,
        electrode: &Electrode,
        prepared: &PreparedElectrode,
    ) -> Result<FeedPlan, PlanError> {
        let model = &prepared.model_of(electrode, self.space, self.cancel)?;
        let mut plan = self.nothing_yet(electrode, model);
        let genetic = GeneticParams { h: ReductionMode::Given, ..*self.settings.genetic };
        self.search(&mut plan, model, &genetic, &Lessons::default(), 0)?;
        match &mut plan.jam {
            None => self.verify_and_mend(&mut plan, electrode, model, &genetic)?,
            Some(jam) if self.settings.explain && jam.contact().is_some() => {
                jam.opening = Some(self.opening(electrode, &prepared.model(self.space))?);
            }
            Some(_) => {}
        }
        Ok(plan)
    }

    /// A quick look for a way out.
    pub(super) fn coarse_way(&self, electrode: &Electrode, model: &ClearanceModel) -> Result<CoarseWay, PlanError> {
        let surface_of = |p: DVec3| self.space.finder.surface_of(p);
        let plan = self.nothing_yet(electrode, model);
        let way = self.with_problem(&plan, model, &Lessons::default(), |problem| {
            problem.coarse_way(&self.settings.plan.global, &surface_of, self.progress, self.cancel)
        });
        Ok(way?)
    }

    /// How much more reduction would open a way; `model` is that of the prepared electrode.
    fn opening(&self, electrode: &Electrode, model: &ClearanceModel) -> Result<Opening, PlanError> {
        /// To what angle that is found, and up to which it is looked for (rad).
        const TOLERANCE: f64 = 0.001;
        const MOST: f64 = 0.05;
        let Self { space, settings, progress, cancel, .. } = *self;
        let progress = &progress.as_stage("what would make it feasible");
        let sizer = Sizer { space, electrode, model, settings, tolerance: TOLERANCE, most: MOST, progress, cancel };
        sizer.opening(self.turns)
    }

    pub(super) fn nothing_yet(&self, electrode: &Electrode, model: &ClearanceModel) -> FeedPlan {
        FeedPlan {
            nodes: Vec::new(),
            convergence: Vec::new(),
            jam: None,
            path: None,
            h: 0.0,
            remade: None,
            ranges: self.ranges(electrode),
            probes: model.probes(),
            rounds: 0,
            mends: 0,
            field_seconds: 0.0,
            search_seconds: 0.0,
            verify_seconds: 0.0,
        }
    }

    /// Verifies the path; where it comes too near, adds the contacts to the samples and mends it, or searches anew from
    /// there in finer steps where that is not enough, until it holds or the rounds are spent.
    fn verify_and_mend(
        &self,
        plan: &mut FeedPlan,
        electrode: &Electrode,
        model: &ClearanceModel,
        genetic: &GeneticParams,
    ) -> Result<(), PlanError> {
        let verifier = Verifier::new(&self.space.blisk, &electrode.mesh, electrode.reference_point, self.cancel)?
            .within(self.settings.machine.limits());
        let mut lessons = Lessons::default();
        loop {
            let (curves, path) = interpolated(&plan.nodes, electrode, self.settings, self.space.channel.frame)?;
            let started = Instant::now();
            let surface_of = |p: DVec3| self.space.finder.surface_of(p);
            let certificate = verifier.verify(&path, &surface_of, self.settings.verify, self.progress, self.cancel)?;
            plan.verify_seconds += started.elapsed().as_secs_f64();
            let beyond = match certificate.travel() {
                TravelVerdict::Beyond(beyond) => Some(beyond),
                TravelVerdict::Within | TravelVerdict::NotJudged => None,
            };
            let only_ends_wrong = !certificate.ends_right() && certificate.keeps_clearance() && beyond.is_none();
            if certificate.holds() || plan.rounds > Self::ROUNDS || only_ends_wrong {
                plan.path = Some(planned_path(curves, path, certificate, self.settings));
                return Ok(());
            }
            // The proven bound may fall short where no point met does: then the nearest is what to learn from.
            let mut contacts = certificate.violations().to_vec();
            if contacts.is_empty() && !certificate.keeps_clearance() {
                contacts.push(*certificate.least());
            }
            self.learn(&mut lessons, model, &contacts);
            let mut nearest = contacts.iter().map(|c| c.s).fold(f64::INFINITY, f64::min);
            if let Some(beyond) = beyond {
                self.stay_within(&mut lessons, &beyond);
                // The first row is the furthest out: the nodes before any row that is beyond are not touched.
                let limits = self.settings.machine.limits();
                let rows = path.rows.iter().filter(|row| limits.beyond(&row.pose).is_some());
                nearest = rows.map(|row| row.s).fold(nearest, f64::min);
                lessons.fine.push([nearest - self.settings.plan.step_mm, nearest + self.settings.plan.step_mm]);
            }
            let kept = plan.nodes.iter().filter(|n| n.s < nearest - self.settings.plan.step_mm).count().max(1);
            let model = model.with_probes(&lessons.on_electrode, &lessons.on_blisk);
            if beyond.is_none() && plan.mends < Self::ROUNDS && self.mend(plan, &model, &lessons)? {
                plan.mends += 1;
                continue;
            }
            self.search_from(plan, &model, genetic, &lessons, kept)?;
            if plan.jam.is_some() {
                return Ok(());
            }
        }
    }

    fn learn(&self, lessons: &mut Lessons, model: &ClearanceModel, violations: &[Contact]) {
        let step = self.settings.plan.step_mm;
        for contact in violations {
            let lack = (self.settings.spark_gap - contact.distance).max(0.0);
            let (point, face) = model.before_turning(contact.on_electrode, self.turns);
            let extra = lack + Self::BEYOND;
            lessons.on_electrode.push(Sample { point, face, extra, stays_to: Sample::ALWAYS });
            let face = ElectrodeFace::FarEnd;
            lessons.on_blisk.push(Sample { point: contact.on_blisk, face, extra, stays_to: Sample::ALWAYS });
            lessons.fine.push([contact.s - step, contact.s + step]);
        }
    }

    /// Keeps the nodes away from an end of travel that the curve between them overshot, by twice as much.
    fn stay_within(&self, lessons: &mut Lessons, beyond: &BeyondTravel) {
        let limits = lessons.travel.unwrap_or_else(|| self.settings.machine.limits());
        let by = 2.0 * (beyond.value - beyond.limit).abs();
        let [least, greatest] = limits.of(beyond.axis);
        let drawn_in = if beyond.value < beyond.limit { [least + by, greatest] } else { [least, greatest - by] };
        // The final pose has to stay within.
        let travel = [drawn_in[0].min(0.0), drawn_in[1].max(0.0)];
        lessons.travel = Some(limits.with(beyond.axis, travel));
    }

    /// Searches on from the first `kept` nodes; where that jams, from half as many, down to the final pose: what was
    /// learned late may forbid a way that was taken early.
    fn search_from(
        &self,
        plan: &mut FeedPlan,
        model: &ClearanceModel,
        genetic: &GeneticParams,
        lessons: &Lessons,
        kept: usize,
    ) -> Result<(), PlanError> {
        let known = plan.nodes.clone();
        // The global strategy begins anew in any case.
        let mut kept = if self.settings.plan.strategy == Strategy::Global { 0 } else { kept };
        loop {
            plan.nodes.clone_from(&known);
            self.search(plan, model, genetic, lessons, kept)?;
            if plan.jam.is_none() || kept <= 1 || plan.rounds > Self::ROUNDS {
                return Ok(());
            }
            kept /= 2;
        }
    }

    /// Searches on from the first `kept` nodes of the plan, puts the answer in their place and mends the curve.
    fn search(
        &self,
        plan: &mut FeedPlan,
        model: &ClearanceModel,
        genetic: &GeneticParams,
        lessons: &Lessons,
        kept: usize,
    ) -> Result<(), PlanError> {
        let started = Instant::now();
        let strategy = match self.settings.plan.strategy {
            Strategy::Genetic => StrategyParams::Genetic(*genetic),
            Strategy::Global => StrategyParams::Global(self.settings.plan.global),
            Strategy::FreeTravel => StrategyParams::FreeTravel,
            Strategy::MaxMinDistance => StrategyParams::MaxMinDistance,
            Strategy::Centreline => StrategyParams::Centreline(self.settings.plan.centreline),
        };
        // The global strategy keeps none of the nodes, but begins near all of them.
        let (kept, known) = match strategy {
            StrategyParams::Global(_) => (0, &plan.nodes[..]),
            _ => (kept, &plan.nodes[..kept]),
        };
        let surface_of = |p: DVec3| self.space.finder.surface_of(p);
        let outcome = self.with_problem(plan, model, lessons, |problem| {
            problem.search(&strategy, known, &surface_of, self.progress, self.cancel)
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
            self.mend(plan, model, lessons)?;
        }
        Ok(())
    }

    /// Puts nodes in where the curve comes too near between those that were searched; answers whether that was enough,
    /// as far as the probes tell. If not, the plan stays as it is.
    fn mend(&self, plan: &mut FeedPlan, model: &ClearanceModel, lessons: &Lessons) -> Result<bool, PlanError> {
        let started = Instant::now();
        let mended = self.with_problem(plan, model, lessons, |problem| match self.settings.plan.strategy {
            // What was learned may ask for more than a dent: the whole path gives way a little.
            Strategy::Global if plan.rounds > 0 && !lessons.is_empty() => {
                let nodes = problem.polished(plan.nodes.clone(), &self.settings.plan.global, self.cancel)?;
                problem.mended(&nodes, self.cancel)
            }
            _ => problem.mended(&plan.nodes, self.cancel),
        })?;
        plan.search_seconds += started.elapsed().as_secs_f64();
        let Some(nodes) = mended else { return Ok(false) };
        let mut searched = std::mem::take(&mut plan.convergence).into_iter().peekable();
        for node in &nodes[1..] {
            plan.convergence.push(searched.next_if(|c| c.s == node.s).unwrap_or_else(|| Convergence::none(node.s)));
        }
        plan.nodes = nodes;
        Ok(true)
    }

    /// Calls `work` with the search problem for `model`.
    pub(super) fn with_problem<T>(
        &self,
        plan: &FeedPlan,
        model: &ClearanceModel,
        lessons: &Lessons,
        work: impl FnOnce(&SearchProblem) -> T,
    ) -> T {
        let PlanSettings { plan: params, machine, spark_gap, .. } = *self.settings;
        let channel = &*self.space.channel;
        let moving: Vec<Axis> = machine.axes.axes()[1..].to_vec();
        let objective = Objective::new(
            params.weights.normalised(&moving),
            plan.ranges,
            model.samples(),
            model.reference_point(),
            channel,
            &self.space.walls,
        );
        let test = AngleTest::new(channel, spark_gap + params.margin_mm, &params.angle);
        work(&SearchProblem {
            model,
            angle: (params.constraint == Constraint::Angle).then_some(&test),
            objective: &objective,
            axes: machine.axes,
            travel: lessons.travel.unwrap_or_else(|| machine.limits()),
            ranges: plan.ranges,
            demand: Demand { spark_gap, margin: params.margin_mm, guard: Self::GUARD, room: 0.0 },
            turns: self.turns,
            side: model.side(),
            joining: params.interpolation.joining(),
            step: params.step_mm,
            fine: &lessons.fine,
            exit_clearance: params.exit_clearance_mm,
            guide: self.guide.as_ref(),
            observe: self.settings.observe,
        })
    }

    fn prepared(&self, electrode: Arc<Electrode>) -> Result<PreparedElectrode, PlanError> {
        let PlanSettings { plan, genetic, spark_gap, .. } = *self.settings;
        let most = if genetic.h == ReductionMode::Variable { genetic.h_max_deg.to_radians() } else { 0.0 };
        PreparedElectrode::new(self.space, electrode, spark_gap + plan.margin_mm, most, self.progress, self.cancel)
    }

    /// Full ranges of motion in one step by (7): Z within the passage's height, Y within half a pitch, C within
    /// the angle that the electrode's farthest wall point has to its blade. P0 leaves A and B still; here A may
    /// turn by half a pitch and B as far as C.
    fn ranges(&self, electrode: &Electrode) -> [f64; 6] {
        let channel = &*self.space.channel;
        let hub = channel.meridian.iter().map(|m| m.hub).fold(f64::INFINITY, f64::min);
        let shroud = channel.meridian.iter().map(|m| m.shroud).fold(0.0, f64::max);
        let pitch = std::f64::consts::TAU / channel.blades as f64;
        let gamma = 0.5 * (shroud + hub) * (0.5 * pitch).sin();
        let beta = self.beta(electrode);
        let half = [0.0, gamma, shroud - hub, 0.5 * pitch, beta, beta];
        let axes = self.settings.machine.axes.axes();
        Axis::ALL.map(|axis| if axes.contains(&axis) { 2.0 * half[axis as usize] } else { 0.0 })
    }

    /// beta of (7): A is the point of the electrode's low wall farthest from O, B the point of the blade nearest to
    /// A, beta the angle AOB. At least a degree, for walls that are hardly reduced.
    fn beta(&self, electrode: &Electrode) -> f64 {
        let o = electrode.reference_point;
        let on_low = |i: &usize| electrode.faces[*i] == ElectrodeFace::LowWall;
        let a = (0..electrode.faces.len())
            .filter(on_low)
            .flat_map(|i| electrode.mesh.corners(i))
            .max_by(|p, q| p.distance_squared(o).total_cmp(&q.distance_squared(o)))
            .unwrap_or(o + DVec3::X);
        let b = self.space.finder.nearest_on_low_wall(a);
        (a - o).angle_between(b - o).max(1f64.to_radians())
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
    use ElectrodeError::{NoHeight, NoMetal, OutOfRange};
    matches!(error, NoMetal { .. } | NoHeight { .. } | OutOfRange { .. })
}

/// The end of a search whose way out, `nodes` nodes long to `last`, takes more reduction than the electrode has metal.
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
