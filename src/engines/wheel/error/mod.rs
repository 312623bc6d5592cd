//! Why a mesh is not taken for a blisk, in words that say what to do about it.

mod reasons;

use glam::{DVec2, DVec3};

pub use self::reasons::{Misleading, NotChannels};
use super::by_hand::{ByHand, nearest};
use super::channel::{Agreement, Surface};
use super::frame::axis::Axis;
use super::frame::frame_along;
use super::frame::sector::SectorError;
use super::options::BliskOptions;
use geometry::frame::{Cylindrical, Frame};
use task::Cancelled;

/// Reason why the axis, the blades or a channel could not be found.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum BliskError {
    /// A key of the project is wrong.
    #[error("{0}")]
    Options(String),
    /// There is nothing to look at.
    #[error("the mesh cannot be searched for a blisk: {0}")]
    Mesh(String),
    /// Only a part of a blisk.
    #[error(
        "the surface of the mesh covers only about {covered_deg:.0} of 360 degrees around the axis {axis}{}, and no two \
         planes through it cut it out of a wheel: {}load the whole blisk, or a sector of one pitch up to half a turn that \
         ends on two planes through its axis",
        if *.given { " that blisk.axis gives" } else { "" },
        if *.given { "set blisk.axis to auto or correct it, or " } else { "give the axis with blisk.axis if it is another, or " }
    )]
    Partial {
        /// Angle that the surface covers (deg).
        covered_deg: f64,
        /// The axis it was measured around.
        axis: Axis,
        /// Whether it is given by hand, or its direction.
        given: bool,
    },
    /// A sector that no whole wheel can be made of.
    #[error(transparent)]
    Sector(SectorError),
    /// Nothing repeats around the axis.
    #[error(
        "no blades found: no circle about the axis {axis} crosses walls that repeat evenly around it{}{}; \
         if this is a blisk, give its blade count, those that are missing included, with blisk.blades, and its axis with \
         blisk.axis if it is another",
        .wanted.map_or(" three times or more".to_owned(), |n| format!(" exactly {n} times")),
        if *.closed { "" } else { " (the mesh is not closed, which may be why: repair it first)" }
    )]
    NoBlades {
        /// The axis that was tried.
        axis: Axis,
        /// The blade count that was asked for.
        wanted: Option<usize>,
        /// Whether the mesh is closed; an open one has no inside.
        closed: bool,
    },
    /// Something repeats, but it is no channel between blades.
    #[error(
        "no blades found: about the axis {axis} there are {count} gaps, but {reason}; {}",
        if *reason == NotChannels::RoundHoles {
            "if they are passages between blades, give points on walls of the blades with blisk.blade_points_mm"
        } else {
            "if this is a blisk, give its blade count, those that are missing included, with blisk.blades; if that is not \
             enough, as where they stand at unequal angles, its axis with blisk.axis as well, or points on walls of its \
             blades with blisk.blade_points_mm"
        }
    )]
    NoChannels {
        /// The axis that was tried.
        axis: Axis,
        /// How many gaps there are.
        count: usize,
        /// Reason why they are no channels.
        reason: NotChannels,
    },
    /// What is given by hand keeps the wheel from being found.
    #[error(
        "{} the mesh, which has {blades} blades about the axis {axis}, at x {:.3}, r {:.3} mm about it: {}",
        .given.words()[0], .at.x, .at.y, .given.words()[1]
    )]
    Misleading {
        /// What is given.
        given: Misleading,
        /// The axis that is found without it.
        axis: Axis,
        /// The number of blades that is found without it.
        blades: usize,
        /// Position along the axis and distance from it (mm) of a place between these blades.
        at: DVec2,
    },
    /// Several bodies that are no one wheel.
    #[error(
        "the mesh holds {count} bodies apart from each other, of which {}: load each wheel from a file of its own, or name the \
         one to be planned by its axis with blisk.axis. That of one of them, which has {blades} blades, is {axis}",
        if *.wheels > 1 { format!("{wheels} are wheels") } else { "one is a wheel by itself".to_owned() }
    )]
    Bodies {
        /// Number of bodies.
        count: u32,
        /// Number of those that are wheels, of the largest ones.
        wheels: u32,
        /// Axis of the first wheel.
        axis: Axis,
        /// Number of its blades.
        blades: usize,
        /// Position along the axis and distance from it (mm) of a place between these blades.
        at: DVec2,
    },
    /// The channel that is asked for does not exist.
    #[error("blisk.channel is {index}, but the blisk has {blades} channels, 0 to {}", .blades - 1)]
    NoSuchChannel {
        /// The channel asked for.
        index: usize,
        /// Number of channels.
        blades: usize,
    },
    /// An end wall could not be found.
    #[error(
        "the {wall} was not found: no surface is met along the radius from the channel's middle (x {x:.3}, r {r:.3} mm \
         about the axis); give its radius with blisk.{key} or points on it with blisk.{wall}_points_mm"
    )]
    NoEndWall {
        /// Name of the wall: `"hub"`.
        wall: &'static str,
        /// The key that gives it by hand.
        key: &'static str,
        /// Where the ray started (mm along the axis).
        x: f64,
        /// Where the ray started (mm from the axis).
        r: f64,
    },
    /// Hub and shroud leave no room.
    #[error(
        "hub radius {hub:.3} mm and shroud radius {shroud:.3} mm leave no channel that the blades cross; \
         check blisk.hub_radius_mm and blisk.shroud_radius_mm"
    )]
    NoHeight {
        /// Hub radius (mm).
        hub: f64,
        /// Shroud radius (mm).
        shroud: f64,
    },
    /// A radius is given for a passage that does not run along the axis.
    #[error(
        "the passage does not run along the axis, so that one radius cannot bound it: take away blisk.{key} and give \
         points with blisk.hub_points_mm and blisk.shroud_points_mm"
    )]
    NotAxial {
        /// The key that gives it.
        key: &'static str,
    },
    /// The passage turns away from the axis, and the curves along it were not found.
    #[error(
        "the passage turns from the axis to the radius at x {x:.3}, r {r:.3} mm about the axis, but its hub and its shroud \
         or blade tips were not found from end to end: the blades must stand on the hub from edge to edge, and end at one \
         shroud or at tips with a corner at either edge; look for holes, steps or other bodies between the blades, or give \
         points of both, from edge to edge, with blisk.hub_points_mm and blisk.shroud_points_mm"
    )]
    Turns {
        /// Where (mm along the axis).
        x: f64,
        /// Where (mm from the axis).
        r: f64,
    },
    /// The blades go on where hub, shroud or tips have ended.
    #[error(
        "the blades go on beyond the end of the hub, shroud or tips that were found, at x {x:.3}, r {r:.3} mm about the axis, \
         so that the passage is not known from edge to edge: hub and shroud must reach as far as the blades, and the tips \
         must end in a corner at either edge; check blisk.axis, or give points of both, from edge to edge, with \
         blisk.hub_points_mm and blisk.shroud_points_mm"
    )]
    Unbounded {
        /// Where (mm along the axis).
        x: f64,
        /// Where (mm from the axis).
        r: f64,
    },
    /// The walls could not be followed over the whole channel.
    #[error(
        "the channel's walls were lost at x {x:.3}, r {r:.3} mm about the axis, where the blades do not bound it on \
         both sides, or metal stands between them; pick a passage that they bound with blisk.blade_points_mm or blisk.channel, give their number \
         with blisk.blades where blades are hollow or broken, or give points of hub \
         and shroud with blisk.hub_points_mm and blisk.shroud_points_mm; where blades grow together at the hub, or a \
         back plate is cut away between them, draw a curve above the hub with blisk.hub_points_mm and \
         blisk.end_walls = \"drawn\""
    )]
    LostWall {
        /// Where (mm along the axis).
        x: f64,
        /// Where (mm from the axis).
        r: f64,
    },
    /// With a radius that is given the walls could not be followed.
    #[error(
        "with the radius that blisk.{key} gives, the blades do not bound the channel on both sides at x {x:.3}, r {r:.3} mm \
         about the axis: correct it, so that the blades reach as far, or set it to auto"
    )]
    GivenRadius {
        /// The key that gives it.
        key: &'static str,
        /// Where (mm along the axis).
        x: f64,
        /// Where (mm from the axis).
        r: f64,
    },
    /// What was found is not what the mesh has.
    #[error("{}", disagreement(.0))]
    Disagrees(Agreement),
    /// The walls of the channel touch.
    #[error(
        "the walls that were found touch at x {x:.3}, r {r:.3} mm about the axis: what lies between them is no passage \
         between two blades; check blisk.axis and blisk.blades, pick a passage with blisk.blade_points_mm, or give \
         points of hub and shroud with blisk.hub_points_mm and blisk.shroud_points_mm"
    )]
    NoThroat {
        /// Where (mm along the axis).
        x: f64,
        /// Where (mm from the axis).
        r: f64,
    },
    /// A shroud over part of the blades, or beyond a gap.
    #[error("{}", part_shroud(*.share, [*.x, *.r], *.joined))]
    PartShroud {
        /// Share of the passage's length that is covered.
        share: f64,
        /// Position along the axis of a place that is covered (mm, in W).
        x: f64,
        /// Radius of that place (mm).
        r: f64,
        /// Whether the blades join it.
        joined: bool,
    },
    /// Blades of different height.
    #[error(
        "a blade of the channel goes on beyond the tips of its neighbour, at x {x:.3}, r {r:.3} mm about the axis, so that \
         nothing bounds the passage there on one side; pick a channel between two high blades, if there is one, with \
         blisk.channel, or draw the bound with points beside the lower tips as blisk.shroud_points_mm and \
         blisk.end_walls = \"drawn\": what lies beyond it is not burned then"
    )]
    HigherBlade {
        /// Position along the axis of a place beyond the lower tips (mm, in W).
        x: f64,
        /// Radius of that place (mm).
        r: f64,
    },
    /// Something stands in the passage.
    #[error(
        "metal stands in the passage at x {:.3}, r {:.3} mm about the axis, {off_mm:.3} mm within it, so that no electrode \
         fills it; take it out of the mesh if the finished wheel is without it, or pick another passage \
         with blisk.channel if only some have it",
        .at.x, .at.y.hypot(.at.z)
    )]
    Obstructed {
        /// The place that is furthest within it (mm).
        at: DVec3,
        /// How far it is from the nearest surface of the passage that the metal does not reach to (mm).
        off_mm: f64,
    },
    /// Points that are given do not lie on the hub or the shroud that was measured beside them.
    #[error(
        "point {number} of blisk.{key}, at x {x:.3}, r {r:.3} mm about the axis, is {off_mm:.3} mm off the {surface} that was \
         measured; correct it, or give more points between its neighbours"
    )]
    PointOff {
        /// Name of the surface.
        surface: &'static str,
        /// The key that the point stands under.
        key: &'static str,
        /// Number of the point, from 1.
        number: usize,
        /// Where (mm along the axis).
        x: f64,
        /// Where (mm from the axis).
        r: f64,
        /// How far off (mm).
        off_mm: f64,
    },
    /// A drawn hub or shroud is not between the blades.
    #[error(
        "the curve that is drawn with blisk.{key} reaches into the part, or beyond the blades, at x {x:.3}, r {r:.3} mm about \
         the axis: move its points into the passage there"
    )]
    DrawnOutside {
        /// The key of its points.
        key: &'static str,
        /// Where (mm along the axis).
        x: f64,
        /// Where (mm from the axis).
        r: f64,
    },
    /// Points that are given make no curve along the passage.
    #[error(
        "the points of blisk.{key} make no curve beside the passage at x {x:.3}, r {r:.3} mm about the axis, along which its \
         other end is met; give more points, from edge to edge of the blades, or those of the other end as well"
    )]
    HandCurve {
        /// The key of the points.
        key: &'static str,
        /// Where the passage is (mm along the axis).
        x: f64,
        /// Where the passage is (mm from the axis).
        r: f64,
    },
    /// A point that is given lies on no blade.
    #[error(
        "point {number} of blisk.blade_points_mm, at x {x:.3}, r {r:.3} mm about the axis, {}; pick a place well within the \
         wall of a blade, or check blisk.axis and blisk.blades",
        .off_mm.map_or("lies on a circle about the axis that blades do not bound on both sides".to_owned(),
            |off| format!("is {off:.3} mm off the nearest wall of a passage"))
    )]
    BladePoint {
        /// Number of the point, from 1.
        number: usize,
        /// Where (mm along the axis).
        x: f64,
        /// Where (mm from the axis).
        r: f64,
        /// How far off the nearest wall (mm); none where there is none.
        off_mm: Option<f64>,
    },
    /// The chosen passage is refused, of a mesh that has holes or where others of its kind are not.
    #[error(
        "{error}{}{}",
        if *.closed { "" } else { ". The mesh is not closed, which may be why: repair it first" },
        .other.map_or(String::new(), |other| format!(
            ". Only some passages of this wheel are so: that of channel {other} was found. If this one is spoilt, pick that \
             with blisk.channel"
        ))
    )]
    Spoilt {
        /// Reason why it is refused.
        error: Box<BliskError>,
        /// Whether the mesh is closed.
        closed: bool,
        /// Number of a channel that was found.
        other: Option<usize>,
    },
    /// Cancelled.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

/// Refusal of a wheel, with the place that it is about.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{error}")]
pub struct Refused {
    /// The reason.
    pub error: BliskError,
    /// The place in the coordinates of the loaded mesh (mm), where there is one.
    pub at: Option<DVec3>,
}

impl Refused {
    /// The refusal for `error`, which speaks of places in `frame` or of points of `options`.
    pub(super) fn new(error: BliskError, frame: &Frame, options: &BliskOptions) -> Self {
        let radius = options.radii().into_iter().find(|(_, radius)| radius.given().is_some());
        // Of two drawn curves the one that is nearer is to blame.
        let drawn = |at: DVec2| {
            let [hub, shroud] = ByHand::new(options, frame).curves;
            let off = |curve: Option<Vec<DVec2>>| curve.map_or(f64::INFINITY, |curve| nearest(&curve, at).1);
            let nearer = if off(shroud) < off(hub) { "shroud_points_mm" } else { "hub_points_mm" };
            options.drawn().next().map(|first| options.drawn().find(|key| *key == nearer).unwrap_or(first))
        };
        let error = match (error, radius) {
            (BliskError::LostWall { x, r }, Some((key, _))) => BliskError::GivenRadius { key, x, r },
            (BliskError::LostWall { x, r }, None) => match drawn(DVec2::new(x, r)) {
                Some(key) => BliskError::DrawnOutside { key, x, r },
                None => BliskError::LostWall { x, r },
            },
            (error, _) => error,
        };
        Self { at: error.given_point(options).or_else(|| Some(frame.to_parent(error.place()?))), error }
    }
}

impl From<BliskError> for Refused {
    fn from(error: BliskError) -> Self {
        let at = match error {
            BliskError::Misleading { axis, at, .. } | BliskError::Bodies { axis, at, .. } => {
                Some(frame_along(&axis).to_parent(Cylindrical { x: at.x, r: at.y, theta: 0.0 }.point()))
            }
            _ => None,
        };
        Self { error, at }
    }
}

fn part_shroud(share: f64, [x, r]: [f64; 2], joined: bool) -> String {
    /// From this share of the length on metal beyond the tips covers all of it.
    const ALL: f64 = 0.9;
    let over = format!("over {:.0} % of the passage's length, among it at x {x:.2}, r {r:.2}", 100.0 * share);
    let beyond = format!("metal stands close beyond the blade tips {over}, though the blades do not join it");
    let (what, otherwise) = match (joined, share < ALL) {
        (true, _) => {
            (format!("the blades have a shroud, or a ring between them, only {over}"), "a mesh whose shroud is whole")
        }
        (false, true) => (
            format!("{beyond}: it seems to have a shroud over a part of its length only"),
            "a mesh whose shroud is whole",
        ),
        (false, false) => {
            (format!("{beyond}: a shroud that is another solid lies beyond a gap"), "the solid of the blades alone")
        }
    };
    format!(
        "{what}. Draw the curve along the tips that is to bound the passage with blisk.shroud_points_mm and \
         blisk.end_walls \"drawn\", or take {otherwise}"
    )
}

fn disagreement(found: &Agreement) -> String {
    let Cylindrical { x, r, .. } = Cylindrical::from_point(found.at);
    let off = match found.greatest_mm {
        off if off.is_finite() => format!("is up to {off:.3} mm off the mesh"),
        _ => "is not there in the mesh".to_owned(),
    };
    format!(
        "the {} that was found {off} (at x {x:.3}, r {r:.3} mm about the axis; {} of {} places disagree): the mesh \
         has no passage between blades, hub and shroud as they were taken for, or its facets are too coarse to tell; check \
         blisk.axis and blisk.blades, pick a passage with blisk.blade_points_mm, give points of hub and shroud with \
         blisk.hub_points_mm and blisk.shroud_points_mm, or load a finer mesh{}",
        found.surface.name(),
        ((1.0 - found.share) * found.samples as f64).round(),
        found.samples,
        match found.surface {
            Surface::Hub | Surface::Shroud =>
                "; where large fillets leave little of it between the blades, draw a curve above them with blisk.end_walls = \"drawn\"",
            _ => "",
        }
    )
}

impl From<SectorError> for BliskError {
    fn from(error: SectorError) -> Self {
        match error {
            SectorError::Cancelled(cancelled) => cancelled.into(),
            other => Self::Sector(other),
        }
    }
}

impl BliskError {
    /// The place that the error is about, in the frame of the search (mm). Where only the circle about the axis is known,
    /// its point in the middle of the channel.
    fn place(&self) -> Option<DVec3> {
        match *self {
            Self::NoEndWall { x, r, .. }
            | Self::Turns { x, r }
            | Self::Unbounded { x, r }
            | Self::LostWall { x, r }
            | Self::GivenRadius { x, r, .. }
            | Self::DrawnOutside { x, r, .. }
            | Self::HandCurve { x, r, .. }
            | Self::NoThroat { x, r }
            | Self::HigherBlade { x, r }
            | Self::PartShroud { x, r, .. } => Some(Cylindrical { x, r, theta: 0.0 }.point()),
            Self::Disagrees(Agreement { at, .. }) | Self::Obstructed { at, .. } => Some(at),
            Self::Spoilt { ref error, .. } => error.place(),
            _ => None,
        }
        .filter(|p| p.is_finite())
    }

    /// The point of `options` that the error is about, in the coordinates of the mesh (mm).
    fn given_point(&self, options: &BliskOptions) -> Option<DVec3> {
        let (key, number) = match *self {
            Self::PointOff { key, number, .. } => (key, number),
            Self::BladePoint { number, .. } => ("blade_points_mm", number),
            _ => return None,
        };
        let (_, points, _) = options.points().into_iter().find(|(of, ..)| *of == key)?;
        points.get(number.checked_sub(1)?).map(|p| DVec3::from_array(*p))
    }

    /// The axis about which the search failed.
    pub fn axis(&self) -> Option<Axis> {
        match self {
            Self::Partial { axis, .. }
            | Self::NoBlades { axis, .. }
            | Self::NoChannels { axis, .. }
            | Self::Bodies { axis, .. }
            | Self::Misleading { axis, .. } => Some(*axis),
            Self::Sector(error) => error.axis(),
            _ => None,
        }
    }
}

impl std::fmt::Display for Axis {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let (p, d) = (rounded(self.point, 1e-6), rounded(self.direction, 1e-9));
        write!(f, "through ({}, {}, {}) mm along ({}, {}, {})", p.x, p.y, p.z, d.x, d.y, d.z)
    }
}

/// `v` rounded to multiples of `unit`, without negative zeros.
fn rounded(v: DVec3, unit: f64) -> DVec3 {
    let digits = (1.0 / unit).round();
    (v * digits).round() / digits + DVec3::ZERO
}
