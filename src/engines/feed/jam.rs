//! Where a search came to its end, and what stopped it.

use glam::DVec3;
use serde::Serialize;

use super::machine::BeyondTravel;
use super::pose::{Axis, Pose};
use super::sizing::Opening;
use geometry::frame::Cylindrical;
use wheel::channel::{Channel, Surface};

/// Where a search came to its end.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Jam {
    /// The node that could not be reached, counted from the final pose.
    pub node: usize,
    /// Its withdrawn distance (mm).
    pub s: f64,
    /// The pose that came nearest to being free.
    pub pose: Pose,
    /// What stops the electrode there.
    pub cause: JamCause,
    /// How much more reduction would open a way, where that was looked for.
    pub opening: Option<Opening>,
}

/// What stops an electrode.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum JamCause {
    /// Metal, or the spark gap around it.
    Contact(JamContact),
    /// The machine: an axis cannot go where the way out leads (mm or rad).
    Travel {
        /// The axis.
        axis: Axis,
        /// Where it would have to go.
        value: f64,
        /// Where its travel ends.
        limit: f64,
    },
    /// The way out that was found takes so much additional reduction h (rad) that nothing is left of the electrode.
    NothingLeft {
        /// h (rad).
        h: f64,
    },
    /// Nothing that could be named: there was no place to look at.
    Unknown,
}

/// The place that lacks most room where an electrode jams.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct JamContact {
    /// The point of the electrode, in its final pose in W (mm).
    pub on_electrode: DVec3,
    /// The nearest point of the blisk, in W (mm).
    pub on_blisk: DVec3,
    /// The surface it lies on.
    pub surface: Surface,
    /// Clearance that is missing there (mm).
    pub lack: f64,
}

impl Jam {
    /// The place that stops the electrode, if it is one.
    pub fn contact(&self) -> Option<&JamContact> {
        if let JamCause::Contact(contact) = &self.cause { Some(contact) } else { None }
    }

    /// Whether so little is missing that another try may come through.
    pub(super) fn is_near(&self, nearly: f64) -> bool {
        match self.cause {
            JamCause::Contact(contact) => contact.lack <= nearly,
            JamCause::Travel { .. } | JamCause::NothingLeft { .. } => false,
            JamCause::Unknown => true,
        }
    }

    /// Where and why the search ended, and what would help, in one sentence.
    pub fn sentence(&self, channel: &Channel) -> String {
        let help = self.opening.map(|opening| opening_sentence(&opening, channel)).unwrap_or_default();
        format!("{}{help}", self.where_and_why(channel))
    }

    fn where_and_why(&self, channel: &Channel) -> String {
        let place = format!("jams at node {} (retract distance {:.2} mm)", self.node, self.s);
        match self.cause {
            JamCause::Contact(JamContact { on_blisk: at, surface, lack, .. }) => {
                let Cylindrical { x, r, .. } = Cylindrical::from_point(at);
                let missing = if lack < 5e-4 {
                    "a pose there is free, but no motion to it was found".to_owned()
                } else {
                    format!("{lack:.3} mm of clearance are missing there")
                };
                format!(
                    "{place} against the {} at x = {x:.2}, r = {r:.2} mm (W: {:.2}, {:.2}, {:.2}): {missing}",
                    channel.surface_name(surface),
                    at.x,
                    at.y,
                    at.z
                )
            }
            JamCause::Travel { axis, value, limit } => {
                let beyond = BeyondTravel { axis, row: 0, value, limit };
                let ((value, limit, unit), letter) = (beyond.in_file_units(), axis.letter());
                format!(
                    "{place} because axis {letter} cannot go to {value:.2} {unit}: its travel ends at {limit} {unit}"
                )
            }
            JamCause::NothingLeft { h } => format!(
                "{place}: the extraction path needs h = {:.3} deg of additional reduction, which leaves no electrode",
                h.to_degrees()
            ),
            JamCause::Unknown => format!("{place}: no free pose was found"),
        }
    }
}

/// What would open a way, to follow a verdict.
fn opening_sentence(opening: &Opening, channel: &Channel) -> String {
    let deg = |angle: f64| format!("{:.2} deg", angle.to_degrees());
    let wall = |surface, angle: Option<f64>| {
        angle.map(|a| format!("{} on the side of the {} alone", deg(a), channel.surface_name(surface)))
    };
    let both = opening.both.map(|a| format!("{} on both walls", deg(a)));
    let ways = [both, wall(Surface::LowWall, opening.low), wall(Surface::HighWall, opening.high)];
    let ways: Vec<String> = ways.into_iter().flatten().collect();
    if ways.is_empty() {
        "; not feasible at any reduction tried".to_owned()
    } else {
        format!("; feasible with more reduction: {}", ways.join(", or "))
    }
}
