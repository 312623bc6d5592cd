//! The search problem of an electrode, made from the settings of its plan.

use glam::DVec3;

use super::angle_test::AngleTest;
use super::centreline::Guide;
use super::clearance::ClearanceModel;
use super::machine::TravelLimits;
use super::objective::Objective;
use super::plan::PlanSettings;
use super::plan_params::Constraint;
use super::pose::Axis;
use super::prepared::PlanningSpace;
use super::probes::{Demand, Turns};
use super::problem::SearchProblem;
use super::samples::Sample;
use geometry::distance_field::DistanceField;
use wheel::channel::Station;
use wheel::electrode::{Electrode, ElectrodeFace};

/// Settings that the searches for one electrode have in common.
pub(super) struct SearchSetup<'a> {
    /// The channel.
    pub(super) space: &'a PlanningSpace,
    /// Parameters of the plan.
    pub(super) settings: &'a PlanSettings<'a>,
    /// Angles by which the walls are drawn in from those of the prepared electrode (rad).
    pub(super) turns: Turns,
    /// The path of the electrode along the centreline, where the strategy follows it.
    pub(super) guide: Option<Guide>,
}

/// Further demands on searches, from findings of the verifier.
#[derive(Default)]
pub(super) struct Refinements {
    /// Points of the electrode that lacked clearance.
    pub(super) on_electrode: Vec<Sample>,
    /// Points of the blisk to which the electrode lacked clearance.
    pub(super) on_blisk: Vec<Sample>,
    /// Intervals of withdrawn distance to be searched in finer steps (mm).
    pub(super) fine: Vec<[f64; 2]>,
    /// Travel for the nodes, where the curve between them went beyond the machine's.
    pub(super) travel: Option<TravelLimits>,
}

impl Refinements {
    /// Whether no point was added and travel is the machine's.
    pub(super) fn is_empty(&self) -> bool {
        self.on_electrode.is_empty() && self.on_blisk.is_empty() && self.travel.is_none()
    }
}

impl SearchSetup<'_> {
    /// Clearance that nodes keep beyond what is asked for, for the errors of the fields and for what the curve between
    /// them takes (mm).
    const GUARD: f64 = 2.0 * DistanceField::ACCURACY;

    /// Calls `work` with the search problem for `model`; `ranges` are those of [`ranges`](Self::ranges).
    pub(super) fn with_problem<T>(
        &self,
        ranges: [f64; 6],
        model: &ClearanceModel,
        refinements: &Refinements,
        work: impl FnOnce(&SearchProblem) -> T,
    ) -> T {
        let PlanSettings { plan: params, machine, spark_gap, .. } = *self.settings;
        let channel = &*self.space.channel;
        let moving = machine.axes.free_axes(model.side());
        let objective = Objective::new(
            params.weights.normalised(moving),
            ranges,
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
            travel: refinements.travel.unwrap_or_else(|| machine.pose_limits()),
            ranges,
            demand: Demand { spark_gap, margin: params.margin_mm, guard: Self::GUARD, room: 0.0 },
            turns: self.turns,
            side: model.side(),
            joining: params.interpolation.joining(),
            step: params.step_mm,
            fine: &refinements.fine,
            exit_clearance: params.exit_clearance_mm,
            guide: self.guide.as_ref(),
            observe: self.settings.observe,
        })
    }

    /// Full ranges of motion in one step by (7): Z, or X where the electrode is withdrawn along Z, within the passage's
    /// height, Y within half a pitch, C within
    /// the angle that the electrode's farthest wall point has to its blade. P0 leaves A and B still; here A may
    /// turn by half a pitch and B as far as C.
    pub(super) fn ranges(&self, electrode: &Electrode) -> [f64; 6] {
        let channel = &*self.space.channel;
        let hub = channel.meridian.iter().map(|m| m.hub.y).fold(f64::INFINITY, f64::min);
        let shroud = channel.meridian.iter().map(|m| m.shroud.y).fold(0.0, f64::max);
        let pitch = std::f64::consts::TAU / channel.blades as f64;
        let gamma = 0.5 * (shroud + hub) * (0.5 * pitch).sin();
        let beta = self.beta(electrode);
        let side = electrode.enters_from;
        let across = match Axis::of_withdrawal(side) {
            Axis::X => shroud - hub,
            _ => channel.meridian.iter().map(Station::height).fold(0.0, f64::max),
        };
        let half = [across, gamma, across, 0.5 * pitch, beta, beta];
        let axes = self.settings.machine.axes.free_axes(side);
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
