//! End of a search without a path, and its cause.

use glam::DVec3;
use serde::Serialize;

use super::machine::BeyondTravel;
use super::pose::{Axis, Pose};
use geometry::frame::Cylindrical;
use wheel::channel::{Channel, Surface};
use wheel::electrode::EntrySide;

/// End of a search without a path.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Jam {
    /// The node that could not be reached, counted from the final pose.
    pub node: usize,
    /// Withdrawn distance of that node (mm).
    pub s: f64,
    /// The pose that came nearest to being free.
    pub pose: Pose,
    /// Cause of the jam.
    pub cause: JamCause,
    /// Changes that would open a path, where they were searched for.
    pub opening: Option<Opening>,
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

/// Changes that would let an electrode come out where it jams, and those that would not.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Opening {
    /// Greatest further reduction of the walls that was tried (rad).
    pub most: f64,
    /// Further reduction of both walls by the same angle that a search finds enough (rad); none where even the greatest
    /// tried is not. What an electrode made with it comes to is among the changes.
    pub both: Option<f64>,
    /// Further reduction of the low wall alone (rad), where no angle of both is enough.
    pub low: Option<f64>,
    /// Further reduction of the high wall alone (rad), where no angle of both is enough.
    pub high: Option<f64>,
    /// Changes that open a path: of walls with a certificate, others as far as a preview tells.
    pub changes: Vec<Change>,
    /// Changes that do not.
    pub in_vain: Vec<Change>,
    /// Whether the search for changes was stopped before its end.
    pub is_stopped: bool,
}

/// A change of an electrode.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Change {
    /// Other reductions of the low and the high wall.
    Walls {
        /// The reductions (rad).
        reductions: [f64; 2],
        /// Increase of each over the present reduction (rad).
        more: [f64; 2],
    },
    /// Another side of entry.
    Side(EntrySide),
    /// Another radial reduction (mm).
    Radial(f64),
    /// Two electrodes in its place, divided at a share of the burned length of the passage.
    Divided(f64),
    /// Other reductions of both walls and another radial reduction at once.
    AllReductions {
        /// The reductions of the low and the high wall (rad).
        reductions: [f64; 2],
        /// The radial reduction (mm).
        radial_mm: f64,
    },
}

impl Change {
    /// The change after "feasible".
    fn words(&self, channel: &Channel) -> String {
        let deg = |angle: f64| format!("{:.2} deg", angle.to_degrees());
        match self {
            Self::Walls { reductions: [low, high], more: [a, b] } if a == b && low == high => {
                format!("with both walls reduced by {}, {} more than now", deg(*low), deg(*a))
            }
            Self::Walls { reductions, more } => {
                let walls = [Surface::LowWall, Surface::HighWall].into_iter().zip(reductions.iter().zip(more));
                let of = |(wall, (angle, more)): (Surface, (&f64, &f64))| {
                    let name = channel.surface_name(wall);
                    (*more > 0.0)
                        .then(|| format!("the {name} reduced by {}, {} more than now", deg(*angle), deg(*more)))
                };
                format!("with {}", walls.filter_map(of).collect::<Vec<_>>().join(" and "))
            }
            Self::Side(side) => format!("towards {}", side.words()),
            Self::Radial(mm) => format!("with a radial reduction of {mm:.2} mm"),
            Self::Divided(share) => format!("divided in two at {share:.2} of the burned length"),
            Self::AllReductions { reductions: [low, high], radial_mm } => {
                let radial = format!("a radial reduction of {radial_mm:.2} mm at once");
                if low == high {
                    format!("with both walls reduced by {} and {radial}", deg(*low))
                } else {
                    format!("with the walls reduced by {} and {}, and {radial}", deg(*low), deg(*high))
                }
            }
        }
    }
}

impl Opening {
    /// Name of the stage in which changes are searched for.
    pub const SEARCH: &str = "what would make it feasible";

    /// A search for changes that was stopped before it found any.
    pub fn stopped() -> Self {
        Self { is_stopped: true, ..Self::default() }
    }

    /// Whether some further reduction of the walls opens a path.
    pub fn is_by_walls(&self) -> bool {
        self.both.or(self.low).or(self.high).is_some()
    }

    /// Sentence on the changes, to follow a verdict.
    fn sentence(&self, channel: &Channel) -> String {
        let words = |changes: &[Change]| changes.iter().map(|change| change.words(channel)).collect::<Vec<_>>();
        let stopped = if self.is_stopped { "; the search for a change that makes it feasible was stopped" } else { "" };
        if !self.changes.is_empty() {
            return format!("; feasible {}{stopped}", words(&self.changes).join(", or "));
        }
        let walls = (!self.is_by_walls() && self.most > 0.0)
            .then(|| format!("with both walls reduced by {:.2} deg more", self.most.to_degrees()));
        let in_vain: Vec<String> = walls.into_iter().chain(words(&self.in_vain)).collect();
        if in_vain.is_empty() {
            stopped.to_owned()
        } else {
            format!("; not feasible {}{stopped}", in_vain.join(", nor "))
        }
    }
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
        let help = self.opening.as_ref().map(|opening| opening.sentence(channel)).unwrap_or_default();
        format!("{}{help}", self.place_and_cause(channel))
    }

    /// Place and cause of the jam.
    pub fn place_and_cause(&self, channel: &Channel) -> String {
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
