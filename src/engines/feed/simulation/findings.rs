//! Findings about a whole motion.

use glam::DVec3;
use serde::Serialize;

use super::tour::{self, Leg, OutOfTravel, Phase, Visit};
use crate::chain::Chain;
use crate::machine::Mounting;
use crate::machine_model::Body;
use crate::path::FeedPath;
use crate::pose::{Axis, Pose};
use crate::preset::Preset;
use wheel::electrode::EntrySide;

/// Distance of two bodies at one instant of the whole motion.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Place {
    /// Distance (mm).
    pub distance: f64,
    /// Phase of the motion.
    pub phase: Phase,
    /// Channel of the motion, or the one that the blisk is turned to.
    pub channel: usize,
    /// Position in the phase: `3.25` is a quarter of the way from pose 3 to pose 4.
    pub row: f64,
    /// Axis values.
    pub pose: Pose,
    /// The point on the moving body, where it is in the final pose, in W (mm).
    pub on_moving: DVec3,
    /// The point on the other body, in the final pose, in W (mm).
    pub on_fixed: DVec3,
}

/// The clearance of two bodies over the whole motion.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PairReport {
    /// The body that moves.
    pub moving: String,
    /// The other.
    pub fixed: String,
    /// In which part of the motion, if not in all.
    pub during: Option<&'static str>,
    /// Clearance asked for (mm).
    pub required: f64,
    /// Proven clearance (mm).
    pub certified: f64,
    /// The smallest clearance met.
    pub least: Place,
    /// The first instant at which they touch, if they do. On the way from one channel to another it is told of the
    /// widest way, which stands for the others where channels are alike.
    pub contact: Option<Place>,
}

impl PairReport {
    /// Whether less is proven than is required, but some at the nearest place, and no contact.
    pub(super) fn is_short(&self) -> bool {
        !self.holds() && self.contact.is_none() && self.least.distance >= self.required
    }

    /// Whether the proven clearance is at least the clearance required.
    pub fn holds(&self) -> bool {
        self.certified > 0.0 && self.certified >= self.required
    }
}

/// Findings of a simulation.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(super) struct Findings {
    pub(super) path_digest: String,
    pub(super) copying_digest: Option<String>,
    pub(super) blisk_digest: String,
    pub(super) electrode_digest: String,
    pub(super) model_digest: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) preset: Option<Preset>,
    pub(super) with_bodies: bool,
    pub(super) body_clearance_mm: f64,
    pub(super) enters_from: EntrySide,
    pub(super) mounting: Mounting,
    pub(super) approach: Vec<Pose>,
    pub(super) visits: Vec<Visit>,
    pub(super) out_of_reach: Vec<usize>,
    pub(super) pairs: Vec<PairReport>,
    pub(super) travel: Option<OutOfTravel>,
    pub(super) minutes: f64,
    pub(super) period_error: Option<f64>,
    #[serde(skip)]
    pub(super) chain: Chain,
    #[serde(skip)]
    pub(super) bodies: Vec<Body>,
}

/// Proven clearances over the whole motion of one electrode on its machine. Only [`simulate`](super::simulate) can make
/// one, and none can be changed.
///
/// ```compile_fail,E0616
/// fn flatter(mut simulation: feed::simulation::Simulation) {
///     simulation.findings.pairs.clear();
/// }
/// ```
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(transparent)]
pub struct Simulation {
    findings: Findings,
}

impl Simulation {
    /// The simulation that found this: for [`simulate`](super::simulate) alone.
    pub(super) fn of(findings: Findings) -> Self {
        Self { findings }
    }

    /// [`FeedPath::digest`] of the feed that was simulated.
    pub fn path_digest(&self) -> &str {
        &self.findings.path_digest
    }

    /// Digest of the copying motion, if there is one.
    pub fn copying_digest(&self) -> Option<&str> {
        self.findings.copying_digest.as_deref()
    }

    /// [`Mesh::digest`](geometry::mesh::Mesh::digest) of the blisk, in W.
    pub fn blisk_digest(&self) -> &str {
        &self.findings.blisk_digest
    }

    /// [`Mesh::digest`](geometry::mesh::Mesh::digest) of the electrode, in its final pose in W.
    pub fn electrode_digest(&self) -> &str {
        &self.findings.electrode_digest
    }

    /// How the electrode stands on its holder; none of a nominal one.
    pub fn preset(&self) -> Option<&Preset> {
        self.findings.preset.as_ref()
    }

    /// [`MachineModel::digest`](crate::machine_model::MachineModel::digest) of the bodies.
    pub fn model_digest(&self) -> &str {
        &self.findings.model_digest
    }

    /// Whether the machine that was simulated has bodies.
    pub fn with_bodies(&self) -> bool {
        self.findings.with_bodies
    }

    /// Clearance demanded between bodies, and between them and the blisk (mm).
    pub fn body_clearance_mm(&self) -> f64 {
        self.findings.body_clearance_mm
    }

    /// The side that the electrode enters from.
    pub fn enters_from(&self) -> EntrySide {
        self.findings.enters_from
    }

    /// How the machine stood about the electrode.
    pub fn mounting(&self) -> Mounting {
        self.findings.mounting
    }

    /// Poses from the clear position to the first row of the feed; the retraction goes back through them.
    pub fn approach(&self) -> &[Pose] {
        &self.findings.approach
    }

    /// The channels in the order in which they are burnt.
    pub fn visits(&self) -> &[Visit] {
        &self.findings.visits
    }

    /// Channels that were asked for and that A does not reach.
    pub fn out_of_reach(&self) -> &[usize] {
        &self.findings.out_of_reach
    }

    /// Every pair of bodies, the ones that come nearest to what is asked for first.
    pub fn pairs(&self) -> &[PairReport] {
        &self.findings.pairs
    }

    /// The first pose beyond the travel of an axis.
    pub fn travel(&self) -> Option<&OutOfTravel> {
        self.findings.travel.as_ref()
    }

    /// Least time of the whole motion at the axes' greatest speeds, without burning (min).
    pub fn minutes(&self) -> f64 {
        self.findings.minutes
    }

    /// Greatest distance of the blisk's mesh from itself turned by channels (mm); none if its channels differ.
    pub fn period_error(&self) -> Option<f64> {
        self.findings.period_error
    }

    /// The kinematic chain of the machine that was simulated.
    pub fn chain(&self) -> &Chain {
        &self.findings.chain
    }

    /// The bodies of the machine in W, where they are in the final pose.
    pub fn bodies(&self) -> &[Body] {
        &self.findings.bodies
    }

    /// Whether everything keeps its clearance within the travel of the axes, in every channel that was asked for. What
    /// was not looked at holds nowhere.
    pub fn holds(&self) -> bool {
        let f = &self.findings;
        !self.is_empty() && f.pairs.iter().all(PairReport::holds) && f.travel.is_none() && f.out_of_reach.is_empty()
    }

    /// Whether no clearance was tested, or no channel is burnt.
    fn is_empty(&self) -> bool {
        self.findings.pairs.is_empty() || self.findings.visits.is_empty()
    }

    /// Of the pairs that do not keep what is asked for the worst; if there are none, of those with a body of the
    /// machine the one that comes nearest to it.
    pub fn tightest(&self) -> Option<&PairReport> {
        let failing = self.pairs().iter().filter(|p| !p.holds());
        let bodies = self.pairs().iter().filter(|p| p.during.is_none());
        failing.chain(bodies).next()
    }

    /// The legs of the whole motion in order, for showing.
    pub fn legs(&self, feed: &FeedPath, copying: Option<&FeedPath>) -> Vec<Leg> {
        tour::whole(self.approach(), &tour::paths(&self.findings.chain, feed, copying), self.visits())
    }

    /// Whether the body called `name` is in a pair that does not keep what is asked for.
    pub fn is_in_the_way(&self, name: &str) -> bool {
        self.pairs().iter().any(|p| !p.holds() && (p.moving == name || p.fixed == name))
    }

    /// The findings in one or two sentences.
    pub fn sentence(&self) -> String {
        let channels = match self.visits().len() {
            1 => "one channel".to_owned(),
            n => format!("{n} channels"),
        };
        let mut text = match self.tightest() {
            _ if self.visits().is_empty() => "Nothing was simulated: no channel is burnt.".to_owned(),
            _ if self.is_empty() => "Nothing was simulated: the feed has no rows; plan it again.".to_owned(),
            None => format!("The machine has no bodies; the electrode stays clear of the blisk in {channels}."),
            Some(pair) if pair.holds() => format!(
                "Nothing collides in {channels}: {} clearances of bodies are proven, the least of the machine's own, \
                 of {} and {}, {} mm of {:.3} mm. The blisk is taken as finished.",
                self.pairs().len(),
                pair.moving,
                pair.fixed,
                floored(pair.certified),
                pair.required
            ),
            Some(pair) => self.pairs().iter().find(|p| p.contact.is_some()).unwrap_or(pair).complaint(),
        };
        if !self.out_of_reach().is_empty() {
            let list: Vec<String> = self.out_of_reach().iter().map(usize::to_string).collect();
            text += &format!(" The travel of A does not reach channel {}.", list.join(", "));
        }
        if let Some(beyond) = self.travel() {
            let of = |value: f64| if beyond.axis.is_rotary() { value.to_degrees() } else { value };
            let (letter, unit) = (beyond.axis.letter(), if beyond.axis.is_rotary() { "deg" } else { "mm" });
            text += &format!(
                " Axis {letter} would go to {:.3} {unit} in the {} of channel {}, beyond its travel to {:.3} {unit}.",
                of(beyond.value),
                beyond.phase.name(),
                beyond.channel,
                of(beyond.limit)
            );
        }
        text
    }
}

/// Positions of the axes that are not in their final position.
fn stands(pose: &Pose) -> String {
    let of = |axis: Axis| {
        let value = pose.get(axis);
        let (shown, unit) = if axis.is_rotary() { (value.to_degrees(), "deg") } else { (value, "mm") };
        (value != 0.0).then(|| format!("{} {shown:.2} {unit}", axis.letter()))
    };
    let moved: Vec<String> = Axis::ALL.into_iter().filter_map(of).collect();
    if moved.is_empty() { "the final pose".to_owned() } else { moved.join(", ") }
}

/// A proven clearance (mm) to three decimals, never rounded up.
fn floored(mm: f64) -> String {
    format!("{:.3}", (mm * 1e3).floor() / 1e3)
}

impl PairReport {
    fn complaint(&self) -> String {
        let Self { moving, fixed, required, certified, .. } = self;
        match &self.contact {
            Some(at) => format!(
                "COLLISION: {moving} meets {fixed} in the {} of channel {}, at row {:.3} ({}). A path that turns the \
                 electrode less (strategy global), a longer shank or slimmer bodies may be clear.",
                at.phase.name(),
                at.channel,
                at.row,
                stands(&at.pose)
            ),
            None => format!(
                "TOO CLOSE: {moving} and {fixed} are proven to stay apart by {} mm only, of {required:.3} mm; \
                 the least, {:.3} mm, is in the {} of channel {}, at row {:.3}.",
                floored(*certified),
                self.least.distance,
                self.least.phase.name(),
                self.least.channel,
                self.least.row
            ),
        }
    }
}
