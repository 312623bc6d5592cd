//! End of a search without a path, and its cause.

use glam::DVec3;
use serde::Serialize;

use super::machine::BeyondTravel;
use super::pose::{Axis, Pose};
use geometry::frame::Cylindrical;
use wheel::channel::{Channel, Surface};

/// End of a search without a path.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Jam {
    /// The node that could not be reached, counted from the final pose.
    pub node: usize,
    /// Withdrawn distance of that node (mm).
    pub s: f64,
    /// The pose that came nearest to being free.
    pub pose: Pose,
    /// Cause of the jam.
    pub cause: JamCause,
    /// Further reduction that would open a path, where that was searched for.
    pub opening: Option<FurtherReduction>,
}

/// Cause of a jam.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum JamCause {
    /// Contact with metal, or with the spark gap around it.
    Contact(JamContact),
    /// Travel of the machine: an axis cannot go where the path leads (mm or rad).
    Travel {
        /// The axis.
        axis: Axis,
        /// Axis value that the path needs.
        value: f64,
        /// End of its travel.
        limit: f64,
    },
    /// The path found takes so much additional reduction h (rad) that nothing is left of the electrode.
    NothingLeft {
        /// h (rad).
        h: f64,
    },
    /// No cause could be determined.
    Unknown,
}

/// Point with the greatest lack of clearance where an electrode jams.
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

/// Further reduction (rad) that would let an electrode come out, by the walls drawn in; none where even the greatest
/// tried is not enough.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct FurtherReduction {
    /// Both walls by the same angle.
    pub both: Option<f64>,
    /// The low wall alone.
    pub low: Option<f64>,
    /// The high wall alone.
    pub high: Option<f64>,
}

impl Jam {
    /// Contact that stops the electrode, if a contact is the cause.
    pub fn contact(&self) -> Option<&JamContact> {
        if let JamCause::Contact(contact) = &self.cause { Some(contact) } else { None }
    }

    /// Whether so little clearance is missing (up to `nearly`, mm) that another attempt may succeed.
    pub(super) fn is_near(&self, nearly: f64) -> bool {
        match self.cause {
            JamCause::Contact(contact) => contact.lack <= nearly,
            JamCause::Travel { .. } | JamCause::NothingLeft { .. } => false,
            JamCause::Unknown => true,
        }
    }

    /// Place and cause of the jam, and the remedy, in one sentence.
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

/// Sentence on the further reductions that would open a path, to follow a verdict.
fn opening_sentence(opening: &FurtherReduction, channel: &Channel) -> String {
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
