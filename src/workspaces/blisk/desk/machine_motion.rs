//! The whole motion on the machine, and where it stands.

use std::sync::Arc;

use glam::DVec3;

use crate::workspaces::blisk::job::outcome::PlanOutcome;
use crate::workspaces::blisk::scene::machine::{Moment, WholeMotion, meeting};
use feed::copying::Copying;
use feed::simulation::{Phase, Simulation};

/// Where the machine stands in its whole motion.
#[derive(Default)]
pub struct MachineMotion {
    /// The way that it has gone; none while the timeline above says where the electrode stands.
    way: Option<f64>,
    motion: Option<(Arc<Simulation>, WholeMotion)>,
    /// Where something comes too close first.
    trouble: Option<Trouble>,
}

/// Where something comes too close.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Trouble {
    /// The way to it.
    pub way: f64,
    /// Withdrawn distance on the feed (mm), if it is there.
    pub s: Option<f64>,
    /// The two points that come too close, in W at that instant.
    pub points: [DVec3; 2],
}

impl MachineMotion {
    /// Keeps up with the electrode that is looked at.
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
        let o = planned.map(|p| p.path.reference_point);
        self.trouble = self.motion.as_ref().zip(o).and_then(|((simulation, motion), o)| {
            let (place, points) = meeting(simulation, o)?;
            let way = motion.way_to(&place)?;
            // The way back passes the same places; where it is told of is the way in.
            let s = motion.at(way).filter(|moment| moment.phase == Phase::Feed).and_then(|moment| moment.s);
            Some(Trouble { way, s, points })
        });
    }

    /// The moment of the whole motion that is looked at, if it is that and not the timeline above.
    pub fn shown(&self) -> Option<Moment> {
        self.motion.as_ref()?.1.at(self.way?)
    }

    /// The whole motion, and the way that it has gone; none of that while the timeline says where the electrode stands.
    pub fn motion(&self) -> Option<(&WholeMotion, Option<f64>)> {
        self.motion.as_ref().map(|(_, motion)| (motion, self.way))
    }

    /// What was found out about it.
    pub fn simulation(&self) -> Option<&Arc<Simulation>> {
        self.motion.as_ref().map(|(simulation, _)| simulation)
    }

    /// Goes to `way`, or back to the timeline above.
    pub fn go_to(&mut self, way: Option<f64>) {
        self.way = way;
    }

    /// Goes on by `way`. None if it is not looked at, or whether there is more of it.
    pub fn advance(&mut self, way: f64) -> Option<bool> {
        let (now, length) = (self.way?, self.motion.as_ref()?.1.length());
        self.way = Some((now + way).min(length));
        Some(now + way < length)
    }

    /// Where something comes too close first.
    pub fn trouble(&self) -> Option<&Trouble> {
        self.trouble.as_ref()
    }
}
