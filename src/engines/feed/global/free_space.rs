//! Free space of the global strategy: the configurations that an electrode can take, and the motions between them.

use crate::clearance::{ClearanceModel, Shortfall};
use crate::climb::Ascent;
use crate::pose::Pose;
use crate::probes::Demand;
use crate::problem::SearchProblem;
use task::{Cancel, Cancelled};

/// Distance between the points that lead the search (mm).
pub(super) const COARSE: f64 = 0.6;

/// Distance fields of a problem, sampled by a thinned set of probes that leads the search and by all probes that judge
/// it.
pub(super) struct FreeSpace<'a> {
    pub(super) problem: &'a SearchProblem<'a>,
    /// Some of the problem's probes, which lead the search.
    coarse: ClearanceModel<'a>,
    /// Clearance margin up to which a wider place counts as better (mm).
    pub(super) room: f64,
    /// Steps of ascent for each pose.
    ascent: usize,
}

/// Configuration of the electrode: withdrawn distance and pose, with the clearance found there.
#[derive(Debug, Clone, Copy)]
pub(super) struct Configuration {
    /// Withdrawn distance (mm).
    pub(super) s: f64,
    /// The pose.
    pub(super) pose: Pose,
    /// Clearance margin beyond the demand (mm), scaled near the final pose by how far the passage may have opened.
    pub(super) room: f64,
    /// Clearance that is lacking (mm).
    pub(super) lack: f64,
    /// Contact with the least clearance, where that is less than the margin that counts.
    pub(super) worst: Option<Shortfall>,
}

impl<'a> FreeSpace<'a> {
    /// Withdrawn distance at which the whole clearance margin may have opened (mm).
    const OPEN: f64 = 4.0;
    /// Steps of ascent for each pose, for a full search and for a preview.
    const ASCENT: [usize; 2] = [12, 8];
    /// Steps with all probes, where the leading ones were not sufficient.
    const TOUCH: usize = 4;
    /// Lack of clearance by the leading probes up to which the others are tested too (mm).
    const HOPELESS: f64 = 0.05;
    /// Motion between the poses at which a path is tested (mm).
    const STRIDE: f64 = 0.25;

    pub(super) fn new(problem: &'a SearchProblem<'a>, room: f64, cancel: &Cancel) -> Result<Self, Cancelled> {
        Ok(Self { problem, coarse: problem.model.thinned(COARSE, cancel)?, room, ascent: Self::ASCENT[0] })
    }

    /// Free space for a preview, with half the clearance margin and fewer steps of ascent: polishing finds the rest.
    pub(super) fn quick(problem: &'a SearchProblem<'a>, room: f64, cancel: &Cancel) -> Result<Self, Cancelled> {
        Ok(Self { ascent: Self::ASCENT[1], ..Self::new(problem, 0.5 * room, cancel)? })
    }

    /// Configuration of the final pose, which is given.
    pub(super) fn origin(&self) -> Configuration {
        Configuration { s: 0.0, pose: Pose::FINAL, room: self.room, lack: 0.0, worst: None }
    }

    /// Configuration with the greatest clearance margin near `start`.
    pub(super) fn widest_near(&self, start: Pose, s: f64, cancel: &Cancel) -> Result<Configuration, Cancelled> {
        // Near the final pose there cannot be much room: it is taken in proportion to what space may have opened.
        let opened = (s / Self::OPEN).min(1.0);
        let wide = self.room * opened;
        let ascent = self.ascended(start, s, &Demand { room: wide, ..self.problem.narrow() }, cancel)?;
        let (room, lack) = ((wide - ascent.lack) / opened, (ascent.lack - wide).max(0.0));
        Ok(Configuration { s, pose: ascent.pose, room, lack, worst: ascent.worst })
    }

    fn ascended(&self, start: Pose, s: f64, demand: &Demand, cancel: &Cancel) -> Result<Ascent, Cancelled> {
        let (at, axes) = ((s, self.problem.turns), self.problem.free_axes());
        let led = self.coarse.ascend(start, at, demand, axes, self.ascent, cancel)?;
        if led.lack > demand.room + Self::HOPELESS {
            return Ok(led);
        }
        let touch = |lack: f64| if lack > demand.room { Self::TOUCH } else { 0 };
        self.problem.model.ascend_from(led.pose, at, demand, axes, touch, cancel)
    }

    /// Whether the configuration is free: no clearance is lacking and the axes are within their travel.
    pub(super) fn is_free(&self, configuration: &Configuration) -> bool {
        configuration.lack == 0.0 && self.problem.travel.beyond(&configuration.pose).is_none()
    }

    /// Whether the straight motion from one withdrawn distance and pose to another is free.
    pub(super) fn joins(&self, (from_s, from): (f64, &Pose), (to_s, to): (f64, &Pose)) -> bool {
        let strides = self.motion_between(from, to) / Self::STRIDE;
        let parts = strides.ceil().clamp(2.0, 24.0) as usize;
        let between = self.problem.between();
        let mut nearby = self.coarse.nearby();
        (1..parts).all(|i| {
            let t = i as f64 / parts as f64;
            let s = from_s + (to_s - from_s) * t;
            self.coarse.stays_free(&mut nearby, &from.lerp(to, t), (s, self.problem.turns), &between)
        })
    }

    /// Upper estimate of the motion of the electrode's points from one pose to another (mm).
    pub(super) fn motion_between(&self, from: &Pose, to: &Pose) -> f64 {
        self.coarse.motion_between(from, to)
    }
}
