//! The whole motion on the machine, and the position shown of it.

use std::sync::Arc;

use glam::DVec3;

use crate::workspaces::blisk::job::outcome::PlanOutcome;
use crate::workspaces::blisk::scene::machine::{Moment, WholeMotion, meeting};
use feed::copying::Copying;
use feed::simulation::{Phase, Simulation};

/// State of the whole motion on the machine.
#[derive(Default)]
pub struct MachineMotion {
    /// Distance travelled; none while the timeline above positions the electrode.
    way: Option<f64>,
    motion: Option<(Arc<Simulation>, WholeMotion)>,
    /// First place where bodies come too close.
    trouble: Option<Trouble>,
}

/// A place where bodies come too close.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Trouble {
    /// Distance travelled up to this place.
    pub way: f64,
    /// Retract distance on the feed (mm), if the place is on the feed.
    pub s: Option<f64>,
    /// The two points that come too close, in W at that moment.
    pub points: [DVec3; 2],
}

impl MachineMotion {
    /// Follows the electrode that is shown.
    pub fn follow(&mut self, plan: Option<&Arc<PlanOutcome>>, electrode: usize) {
        let simulation = plan.and_then(|p| p.simulation(electrode));
        if simulation.map(Arc::as_ptr) == self.motion.as_ref().map(|(s, _)| Arc::as_ptr(s)) {
            return;
        }
        self.way = None;
        let planned = plan.and_then(|p| p.electrodes.get(electrode)?.plan.path.as_ref());
        let copying = plan.and_then(|p| p.copying(electrode)).and_then(Copying::certified);
        self.motion = simulation.zip(planned).map(|(simulation, planned)| {
            (simulation.clone(), WholeMotion::new(simulation, &planned.path, copying.map(|c| &c.path)))
        });
        self.trouble = self.motion.as_ref().and_then(|(simulation, motion)| {
            let (place, points) = meeting(simulation)?;
            let way = motion.way_to(&place)?;
            // The way back passes the same places; where it is told of is the way in.
            let s = motion.at(way).filter(|moment| moment.phase == Phase::Feed).and_then(|moment| moment.s);
            Some(Trouble { way, s, points })
        });
    }

    /// The moment of the whole motion that is shown, unless the timeline above is.
    pub fn shown(&self) -> Option<Moment> {
        self.motion.as_ref()?.1.at(self.way?)
    }

    /// The whole motion and the distance travelled; no distance while the timeline above is shown.
    pub fn motion(&self) -> Option<(&WholeMotion, Option<f64>)> {
        self.motion.as_ref().map(|(_, motion)| (motion, self.way))
    }

    /// Result of the simulation.
    pub fn simulation(&self) -> Option<&Arc<Simulation>> {
        self.motion.as_ref().map(|(simulation, _)| simulation)
    }

    /// Shows the whole motion at `way`, or the timeline above if none.
    pub fn go_to(&mut self, way: Option<f64>) {
        self.way = way;
    }

    /// Advances by `way`. Returns whether there is more of the motion; none if the motion is not shown.
    pub fn advance(&mut self, way: f64) -> Option<bool> {
        let (now, length) = (self.way?, self.motion.as_ref()?.1.length());
        self.way = Some((now + way).min(length));
        Some(now + way < length)
    }

    /// First place where bodies come too close.
    pub fn trouble(&self) -> Option<&Trouble> {
        self.trouble.as_ref()
    }
}
