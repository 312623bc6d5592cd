//! The whole plan for one electrode: search, interpolate, verify, and search again where the verifier found the
//! search too trusting.

use std::time::Instant;

use glam::DVec3;
use serde::{Deserialize, Serialize};

use super::angle_test::{AngleParams, AngleParamsError, AngleTest};
use super::certificate::{Certificate, Contact};
use super::clearance::{ClearanceModel, Demand};
use super::genetic::{GeneticParams, GeneticParamsError, ReductionMode};
use super::interpolation::{AxisCurves, InterpolationParams, InterpolationParamsError, Lever, PathFrame, feed_path};
use super::machine::{MachineError, MachineParams};
use super::objective::{Objective, Weights, WeightsError};
use super::path::FeedPath;
use super::pose::{Axis, Pose};
use super::samples::{Sample, SampleSpacing, sample_electrode};
use super::search::{Constraint, Convergence, Jam, Node, SearchProblem, Strategy, StrategyParams};
use super::smoothness::{AxisSmoothness, axis_smoothness};
use super::verify::{Verifier, VerifyError, VerifyOptions};
use crate::blisk::channel::Channel;
use crate::blisk::electrode::{Electrode, ElectrodeError, ElectrodeFace};
use crate::blisk::surface_finder::SurfaceFinder;
use crate::geometry::distance_field::{DistanceField, FieldError};
use crate::geometry::exact::{ExactMesh, ExactMeshError};
use crate::geometry::mesh::{Bounds, Mesh};
use crate::geometry::spline::SplineError;
use crate::progress::{Cancel, Cancelled, Progress};

/// Parameters of a plan beyond those of its strategy.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct PlanParams {
    /// How the path is searched for.
    pub strategy: Strategy,
    /// What a pose must meet during the search.
    pub constraint: Constraint,
    /// Distance between nodes along the main direction (mm).
    pub step_mm: f64,
    /// How far out of the blisk the electrode is withdrawn (mm).
    pub exit_clearance_mm: f64,
    /// Clearance wanted beyond the spark gap as soon as the electrode has left its final pose (mm).
    pub margin_mm: f64,
    /// Size of a cell of the distance field (mm).
    pub field_cell_mm: f64,
    /// Weights of the objective.
    pub weights: Weights,
    /// Safety factors of the angle constraint.
    pub angle: AngleParams,
    /// How nodes are joined.
    pub interpolation: InterpolationParams,
}

impl Default for PlanParams {
    fn default() -> Self {
        Self {
            strategy: Strategy::Genetic,
            constraint: Constraint::Distance,
            step_mm: 0.5,
            exit_clearance_mm: 5.0,
            margin_mm: 0.0,
            field_cell_mm: 0.25,
            weights: Weights::default(),
            angle: AngleParams::default(),
            interpolation: InterpolationParams::default(),
        }
    }
}

/// Why a plan cannot be made at all. That no path was found is not an error but an answer.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[allow(missing_docs)]
pub enum PlanError {
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    #[error("[plan] {key} = {value}: must be {range}")]
    Parameter { key: &'static str, value: f64, range: &'static str },
    #[error(transparent)]
    Weights(#[from] WeightsError),
    #[error(transparent)]
    Angle(#[from] AngleParamsError),
    #[error(transparent)]
    Interpolation(#[from] InterpolationParamsError),
    #[error(transparent)]
    Genetic(#[from] GeneticParamsError),
    #[error(transparent)]
    Machine(#[from] MachineError),
    #[error(transparent)]
    Field(FieldError),
    #[error(transparent)]
    Mesh(#[from] ExactMeshError),
    #[error(transparent)]
    Electrode(ElectrodeError),
    #[error(transparent)]
    Spline(#[from] SplineError),
    #[error(transparent)]
    Verify(VerifyError),
}

impl From<FieldError> for PlanError {
    fn from(error: FieldError) -> Self {
        match error {
            FieldError::Cancelled(cancelled) => cancelled.into(),
            other => Self::Field(other),
        }
    }
}

impl From<VerifyError> for PlanError {
    fn from(error: VerifyError) -> Self {
        match error {
            VerifyError::Cancelled(cancelled) => cancelled.into(),
            other => Self::Verify(other),
        }
    }
}

impl From<ElectrodeError> for PlanError {
    fn from(error: ElectrodeError) -> Self {
        match error {
            ElectrodeError::Cancelled(cancelled) => cancelled.into(),
            other => Self::Electrode(other),
        }
    }
}

impl PlanParams {
    /// Whether every parameter is within its range.
    pub fn validate(&self) -> Result<(), PlanError> {
        let within = |key, value: f64, least: f64, greatest: f64, range| {
            let ok = (least..=greatest).contains(&value);
            if ok { Ok(()) } else { Err(PlanError::Parameter { key, value, range }) }
        };
        within("step_mm", self.step_mm, 0.01, 10.0, "0.01 to 10 mm")?;
        within("exit_clearance_mm", self.exit_clearance_mm, 0.1, 200.0, "0.1 to 200 mm")?;
        within("margin_mm", self.margin_mm, 0.0, 5.0, "0 to 5 mm")?;
        within("field_cell_mm", self.field_cell_mm, 0.05, 2.0, "0.05 to 2 mm")?;
        self.weights.validate()?;
        self.angle.validate()?;
        Ok(self.interpolation.validate()?)
    }
}

/// What all electrodes of one channel share: the blisk's surface in W, its distance field, and the walls.
pub struct PlanningSpace<'a> {
    /// The finished blisk in W.
    pub blisk: &'a Mesh,
    /// The channel.
    pub channel: &'a Channel,
    /// The surfaces of the channel.
    pub finder: SurfaceFinder<'a>,
    /// Signed distance around the channel.
    pub field: DistanceField,
}

impl<'a> PlanningSpace<'a> {
    /// How far beside the channel's walls the field reaches (mm).
    const BESIDE: f64 = 6.0;

    /// Builds the distance field with cells of `cell` mm over the channel and its surroundings.
    pub fn new(
        blisk: &'a Mesh,
        exact: &ExactMesh,
        channel: &'a Channel,
        cell: f64,
        progress: &Progress,
        cancel: &Cancel,
    ) -> Result<Self, PlanError> {
        let finder = SurfaceFinder::new(channel)?;
        let field = DistanceField::build(blisk, exact, Self::region(channel), cell, progress, cancel)?;
        Ok(Self { blisk, channel, finder, field })
    }

    fn region(channel: &Channel) -> Bounds {
        let walls = Bounds::of(channel.low.points.iter().chain(&channel.high.points).copied());
        let [front, back] = channel.faces_x;
        let shroud = channel.meridian.iter().map(|m| m.shroud).fold(walls.max.z, f64::max);
        Bounds {
            min: DVec3::new(front - 1.0, walls.min.y - Self::BESIDE, walls.min.z - 3.0),
            max: DVec3::new(back + 1.0, walls.max.y + Self::BESIDE, shroud + 2.0),
        }
    }
}

/// The plan for one electrode.
#[derive(Debug, Clone, PartialEq)]
pub struct FeedPlan {
    /// Nodes from the final pose outwards.
    pub nodes: Vec<Node>,
    /// How each node's search converged.
    pub convergence: Vec<Convergence>,
    /// Where the search jammed, if it did.
    pub jam: Option<Jam>,
    /// The path, if the electrode came out.
    pub path: Option<PlannedPath>,
    /// Additional circumferential reduction that the electrode was made with in the end (rad).
    pub h: f64,
    /// The electrode, if h made it another than the given one.
    pub remade: Option<Box<Electrode>>,
    /// Full ranges of motion by (7), in the order of [`Axis`] (mm, rad).
    pub ranges: [f64; 6],
    /// Samples on the electrode in the last search.
    pub samples: usize,
    /// Searches made: one, and one more for each time that the verifier found something.
    pub rounds: usize,
    /// Time in the search (s).
    pub search_seconds: f64,
    /// Time in the verification (s).
    pub verify_seconds: f64,
}

/// A path with what is known of it.
#[derive(Debug, Clone, PartialEq)]
pub struct PlannedPath {
    /// The curve of each axis.
    pub curves: AxisCurves,
    /// The rows.
    pub path: FeedPath,
    /// What the verifier says of them.
    pub certificate: Certificate,
    /// Smoothness of each axis, in the order of [`Axis`].
    pub smoothness: [AxisSmoothness; 6],
}

impl FeedPlan {
    /// Whether the electrode comes out on a path that the verifier certified.
    pub fn is_verified(&self) -> bool {
        self.path.as_ref().is_some_and(|p| p.certificate.holds())
    }

    /// The answer in one sentence.
    pub fn verdict(&self, channel: &Channel) -> String {
        match (&self.jam, &self.path) {
            (Some(jam), _) => jam.sentence(channel),
            (None, Some(PlannedPath { certificate: c, .. })) if c.holds() => {
                format!("comes out, certified clearance {:.4} mm of {:.4} mm", c.certified, c.required)
            }
            (None, Some(PlannedPath { certificate: c, .. })) => format!(
                "comes out, but with only {:.4} mm of {:.4} mm left against the {} {:.2} mm before the final pose",
                c.least.distance,
                c.required,
                channel.surface_name(c.least.surface),
                c.least.s
            ),
            (None, None) => "was not planned".to_owned(),
        }
    }
}

/// Parameters of all that happens to one electrode.
#[derive(Debug, Clone, Copy)]
pub struct PlanSettings<'a> {
    /// Search and interpolation.
    pub plan: &'a PlanParams,
    /// The genetic strategy.
    pub genetic: &'a GeneticParams,
    /// The machine.
    pub machine: &'a MachineParams,
    /// Verification.
    pub verify: &'a VerifyOptions,
    /// Spark gap (mm).
    pub spark_gap: f64,
}

/// Makes the electrode again with its walls drawn in by a further h (rad).
pub type Remake<'a> = dyn Fn(f64) -> Result<Electrode, ElectrodeError> + 'a;

/// Plans the feed path of `electrode` in `space`. `remake` is called where the strategy searches h too.
pub fn plan_feed(
    space: &PlanningSpace,
    electrode: &Electrode,
    settings: &PlanSettings,
    remake: &Remake,
    progress: &Progress,
    cancel: &Cancel,
) -> Result<FeedPlan, PlanError> {
    settings.plan.validate()?;
    settings.genetic.validate()?;
    settings.machine.validate()?;
    Planner { space, settings, progress, cancel }.plan(electrode, remake)
}

struct Planner<'a> {
    space: &'a PlanningSpace<'a>,
    settings: &'a PlanSettings<'a>,
    progress: &'a Progress,
    cancel: &'a Cancel,
}

/// What the verifier has taught the search so far.
#[derive(Default)]
struct Lessons {
    /// Samples where the electrode came too near.
    samples: Vec<Sample>,
    /// Stretches of withdrawn distance to be searched in finer steps (mm).
    fine: Vec<[f64; 2]>,
}

impl Planner<'_> {
    /// Searches after the first that the verifier's findings may cause.
    const ROUNDS: usize = 8;
    /// Beyond what the verifier found missing, so that the next search does not end just where this one did (mm).
    const BEYOND: f64 = 0.003;

    fn plan(&self, electrode: &Electrode, remake: &Remake) -> Result<FeedPlan, PlanError> {
        let model = self.model(electrode);
        let mut plan = FeedPlan {
            nodes: Vec::new(),
            convergence: Vec::new(),
            jam: None,
            path: None,
            h: 0.0,
            remade: None,
            ranges: self.ranges(electrode),
            samples: model.samples().len(),
            rounds: 0,
            search_seconds: 0.0,
            verify_seconds: 0.0,
        };
        let mut genetic = *self.settings.genetic;
        self.search(&mut plan, &model, &genetic, &Lessons::default(), 0)?;
        plan.h = plan.nodes.iter().map(|n| n.h).fold(0.0, f64::max);
        if plan.jam.is_some() {
            return Ok(plan);
        }
        // An electrode with more reduction lies inside one with less, so its path stays free.
        let remade = if plan.h > 0.0 { Some(remake(plan.h)?) } else { None };
        genetic.h = ReductionMode::Given;
        plan.nodes.iter_mut().for_each(|node| node.h = 0.0);
        self.verify_and_mend(&mut plan, remade.as_ref().unwrap_or(electrode), &genetic)?;
        plan.remade = remade.map(Box::new);
        Ok(plan)
    }

    /// Verifies the path; where it comes too near, adds the contacts to the samples and searches anew from there in
    /// finer steps, until it holds or the rounds are spent.
    fn verify_and_mend(
        &self,
        plan: &mut FeedPlan,
        electrode: &Electrode,
        genetic: &GeneticParams,
    ) -> Result<(), PlanError> {
        let verifier = Verifier::new(self.space.blisk, &electrode.mesh, electrode.reference_point)?;
        let model = self.model(electrode);
        let mut lessons = Lessons::default();
        loop {
            let curves = AxisCurves::through(&plan.nodes, self.settings.plan.interpolation.ends)?;
            let chord_error = self.settings.plan.interpolation.chord_error_mm;
            let path = feed_path(&curves, chord_error, lever(electrode, &plan.nodes), self.path_frame(electrode));
            let started = Instant::now();
            let surface_of = |p: DVec3| self.space.finder.surface_of(p);
            let options = VerifyOptions { stop_at_violation: plan.rounds <= Self::ROUNDS, ..*self.settings.verify };
            let certificate = verifier.verify(&path, &surface_of, &options, self.progress, self.cancel)?;
            plan.verify_seconds += started.elapsed().as_secs_f64();
            let done = certificate.holds() || plan.rounds > Self::ROUNDS || certificate.violations.is_empty();
            if done {
                let step = self.settings.plan.step_mm;
                let smoothness = Axis::ALL.map(|axis| axis_smoothness(&curves, axis, step));
                plan.path = Some(PlannedPath { curves, path, certificate, smoothness });
                return Ok(());
            }
            for v in &certificate.violations { eprintln!("DBG {v:?}"); }
            self.learn(&mut lessons, &model, &certificate.violations);
            let nearest = certificate.violations.iter().map(|c| c.s).fold(f64::INFINITY, f64::min);
            let kept = plan.nodes.iter().filter(|n| n.s < nearest - self.settings.plan.step_mm).count().max(1);
            self.search(plan, &model.with_samples(&lessons.samples), genetic, &lessons, kept)?;
            if plan.jam.is_some() {
                return Ok(());
            }
        }
    }

    fn learn(&self, lessons: &mut Lessons, model: &ClearanceModel, violations: &[Contact]) {
        let step = self.settings.plan.step_mm;
        for contact in violations {
            let lack = (self.settings.spark_gap - contact.distance).max(0.0);
            let face = model.face_at(contact.on_electrode);
            lessons.samples.push(Sample { point: contact.on_electrode, face, extra: lack + Self::BEYOND });
            lessons.fine.push([contact.s - step, contact.s + step]);
        }
    }

    /// Searches on from the first `kept` nodes of the plan and puts the answer in their place.
    fn search(
        &self,
        plan: &mut FeedPlan,
        model: &ClearanceModel,
        genetic: &GeneticParams,
        lessons: &Lessons,
        kept: usize,
    ) -> Result<(), PlanError> {
        let started = Instant::now();
        let PlanSettings { plan: params, machine, spark_gap, .. } = *self.settings;
        let channel = self.space.channel;
        let moving: Vec<Axis> = machine.axes.axes()[1..].to_vec();
        let objective = Objective::new(
            params.weights.normalised(&moving),
            plan.ranges,
            model.samples(),
            model.reference_point(),
            channel,
            &self.space.finder,
            self.space.field.bounds(),
        );
        let test = AngleTest::new(channel, spark_gap + params.margin_mm, &params.angle);
        let problem = SearchProblem {
            model,
            angle: (params.constraint == Constraint::Angle).then_some(&test),
            objective: &objective,
            machine,
            ranges: plan.ranges,
            demand: Demand { spark_gap, margin: params.margin_mm, guard: DistanceField::ACCURACY },
            side: model.side(),
            step: params.step_mm,
            fine: &lessons.fine,
            exit_clearance: params.exit_clearance_mm,
            faces_x: channel.faces_x,
        };
        let strategy = match params.strategy {
            Strategy::Genetic => StrategyParams::Genetic(*genetic),
        };
        let surface_of = |p: DVec3| self.space.finder.surface_of(p);
        let outcome = problem.search(&strategy, &plan.nodes[..kept], &surface_of, self.progress, self.cancel)?;
        plan.convergence.truncate(kept.saturating_sub(1));
        plan.convergence.extend(outcome.convergence);
        plan.nodes = outcome.nodes;
        plan.jam = outcome.jam;
        plan.samples = model.samples().len();
        plan.rounds += 1;
        plan.search_seconds += started.elapsed().as_secs_f64();
        Ok(())
    }

    fn model(&self, electrode: &Electrode) -> ClearanceModel<'_> {
        let samples = sample_electrode(&electrode.mesh, &electrode.faces, SampleSpacing::default());
        let Electrode { reference_point, enters_from, .. } = *electrode;
        ClearanceModel::new(&self.space.field, self.space.channel.faces_x, reference_point, enters_from, samples)
    }

    /// Full ranges of motion in one step by (7): Z within the passage's height, Y within half a pitch, C within
    /// the angle that the electrode's farthest wall point has to its blade. P0 leaves A and B still; here A may
    /// turn by half a pitch and B as far as C.
    fn ranges(&self, electrode: &Electrode) -> [f64; 6] {
        let channel = self.space.channel;
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

    fn path_frame(&self, electrode: &Electrode) -> PathFrame {
        PathFrame {
            frame: self.space.channel.frame,
            reference_point: electrode.reference_point,
            spark_gap: self.settings.spark_gap,
        }
    }
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
