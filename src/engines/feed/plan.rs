//! The whole plan for one electrode: search, interpolate, verify, and search again where the verifier found the
//! search too trusting.

use std::sync::Arc;

use glam::DVec3;

use super::centreline::Guide;
use super::certificate::{Certificate, TravelVerdict};
use super::genetic::GeneticParams;
use super::global::CoarseWay;
use super::interpolation::AxisCurves;
use super::jam::Jam;
use super::machine::MachineParams;
use super::objective::WallDistances;
use super::path::FeedPath;
use super::plan_params::{PlanError, PlanParams};
use super::planner::Planner;
use super::prepared::PreparedElectrode;
use super::probes::Turns;
use super::samples::{Sample, sample_convex_edges};
use super::search::{Convergence, Node, Strategy};
use super::smoothness::AxisSmoothness;
use super::verify::VerifyOptions;
use geometry::distance_field::DistanceField;
use geometry::exact::ExactMesh;
use geometry::mesh::{Bounds, Mesh};
use task::{Cancel, Progress};
use wheel::centreline::Centreline;
use wheel::channel::Channel;
use wheel::electrode::{Electrode, ElectrodeError};
use wheel::surface_finder::SurfaceFinder;

/// What all electrodes of one channel share: the blisk's surface in W, its distance field, and the walls.
pub struct PlanningSpace {
    /// The finished blisk in W.
    pub blisk: Arc<Mesh>,
    /// The channel.
    pub channel: Arc<Channel>,
    /// The surfaces of the channel.
    pub finder: SurfaceFinder,
    /// Signed distance around the channel.
    pub field: DistanceField,
    /// Distances to the two walls there.
    pub walls: WallDistances,
    /// Points along the blisk's edges there.
    pub edges: Vec<Sample>,
}

impl PlanningSpace {
    /// How far beside the channel's walls the field reaches, as a share of the pitch: the electrode swings there.
    const BESIDE: f64 = 0.75;
    /// How far beyond the field the blisk's edges are sampled (mm): shank and holder pass there.
    const RIMS: f64 = 25.0;
    /// Distance between points along the blisk's edges (mm).
    const EDGE_SPACING: f64 = 0.4;

    /// Builds the distance field with cells of `cell` mm over the channel and its surroundings.
    pub fn new(
        blisk: Arc<Mesh>,
        exact: &ExactMesh,
        channel: Arc<Channel>,
        cell: f64,
        progress: &Progress,
        cancel: &Cancel,
    ) -> Result<Self, PlanError> {
        let finder = SurfaceFinder::new(channel.clone())?;
        let field = DistanceField::build(&blisk, exact, Self::region(&channel), cell, progress, cancel)?;
        let edges = sample_convex_edges(&blisk, field.bounds().grown(Self::RIMS), Self::EDGE_SPACING, cancel)?;
        let walls = WallDistances::new(&finder, field.bounds(), cancel)?;
        Ok(Self { blisk, channel, finder, field, walls, edges })
    }

    fn region(channel: &Channel) -> Bounds {
        let walls = Bounds::of(channel.low.points.iter().chain(&channel.high.points).copied());
        let [front, back] = channel.faces_x;
        let beside = Self::BESIDE * std::f64::consts::TAU / channel.blades as f64 * walls.max.z;
        let shroud = channel.meridian.iter().map(|m| m.shroud).fold(walls.max.z, f64::max);
        Bounds {
            min: DVec3::new(front - 1.0, walls.min.y - beside, walls.min.z - 3.0),
            max: DVec3::new(back + 1.0, walls.max.y + beside, shroud + 2.0),
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
    pub remade: Option<Arc<Electrode>>,
    /// Full ranges of motion by (7), in the order of [`Axis`](crate::pose::Axis) (mm, rad).
    pub ranges: [f64; 6],
    /// Points tested for clearance in the last search.
    pub probes: usize,
    /// Searches made: one, and one more for each time that the verifier found something that could not be mended.
    pub rounds: usize,
    /// Times that the path was mended after the verifier found something.
    pub mends: usize,
    /// Time spent on the electrode's distance field (s).
    pub field_seconds: f64,
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
    /// Smoothness of each axis, in the order of [`Axis`](crate::pose::Axis).
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
                format!("has an extraction path, certified clearance {:.4} mm; {}", c.certified(), c.demand())
            }
            (None, Some(PlannedPath { certificate: c, .. })) if !c.ends_right() => {
                "has an extraction path that does not begin wholly outside the blisk; raise exit_clearance_mm"
                    .to_owned()
            }
            (None, Some(PlannedPath { certificate: c, .. })) if c.keeps_clearance() => match c.travel() {
                TravelVerdict::Beyond(beyond) => format!("has an extraction path, but {beyond}"),
                TravelVerdict::Within | TravelVerdict::NotJudged => "was not verified".to_owned(),
            },
            (None, Some(PlannedPath { certificate: c, .. })) => format!(
                "has an extraction path, but with a clearance of only {:.4} mm to the {}, {:.2} mm before the final pose; {}",
                c.least().distance,
                channel.surface_name(c.least().surface),
                c.least().s,
                c.demand()
            ),
            (None, None) => "was not planned".to_owned(),
        }
    }
}

/// Parameters of all that happens to one electrode.
#[derive(Clone, Copy)]
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
    /// Whether it is found out what would open a way where there is none, if the strategy can tell.
    pub explain: bool,
    /// Is shown the nodes found so far after each of them.
    pub observe: &'a Observe<'a>,
}

impl PlanSettings<'_> {
    fn validate(&self) -> Result<(), PlanError> {
        self.plan.validate()?;
        self.genetic.validate()?;
        Ok(self.machine.validate()?)
    }
}

/// Looks at a search while it goes on: nodes from the final pose outwards, and how each of them converged.
pub type Observe<'a> = dyn Fn(&[Node], &[Convergence]) + Sync + 'a;

/// Makes the electrode again with its walls drawn in by a further h (rad).
pub type Remake<'a> = dyn Fn(f64) -> Result<Electrode, ElectrodeError> + 'a;

/// Plans the feed path of `electrode` in `space`. `remake` is called where the strategy searches h too.
pub fn plan_feed(
    space: &PlanningSpace,
    electrode: &Arc<Electrode>,
    settings: &PlanSettings,
    remake: &Remake,
    progress: &Progress,
    cancel: &Cancel,
) -> Result<FeedPlan, PlanError> {
    settings.validate()?;
    let guide = match settings.plan.strategy {
        Strategy::Centreline => Some(Guide::new(Centreline::of_channel(&space.channel, cancel)?, electrode)?),
        _ => None,
    };
    Planner { space, settings, turns: Turns::NONE, progress, cancel, guide }.plan(electrode, remake)
}

/// An electrode that another one was prepared for.
#[derive(Clone, Copy)]
pub struct DrawnIn<'a> {
    /// What was prepared.
    pub prepared: &'a PreparedElectrode,
    /// How far the walls are drawn in from there.
    pub turns: Turns,
    /// The electrode with its walls drawn in.
    pub electrode: &'a Electrode,
}

/// Plans the feed path of an electrode that is prepared.
pub fn plan_drawn_in(
    space: &PlanningSpace,
    drawn_in: &DrawnIn,
    settings: &PlanSettings,
    progress: &Progress,
    cancel: &Cancel,
) -> Result<FeedPlan, PlanError> {
    settings.validate()?;
    let &DrawnIn { prepared, turns, electrode } = drawn_in;
    Planner { space, settings, turns, progress, cancel, guide: None }.plan_drawn_in(electrode, prepared)
}

/// A way out of an electrode that is prepared, as far as a quick look tells: neither polished nor verified.
pub fn coarse_way(
    space: &PlanningSpace,
    drawn_in: &DrawnIn,
    settings: &PlanSettings,
    progress: &Progress,
    cancel: &Cancel,
) -> Result<CoarseWay, PlanError> {
    settings.validate()?;
    let &DrawnIn { prepared, turns, electrode } = drawn_in;
    Planner { space, settings, turns, progress, cancel, guide: None }.coarse_way(electrode, &prepared.model(space))
}
