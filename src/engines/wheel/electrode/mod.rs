//! The electrode of a channel: the channel's negative, drawn in by the spark gap, reduced, divided, and given a
//! shank and a holder block (P0, section II and figure 1).
//!
//! The burning part is built from planes across X. In each plane the unreduced boundary is where the exact distance to
//! the finished blisk equals the spark gap; then each wall is turned about X away from its blade and the shroud side is
//! drawn in. Past the tips of the blades' edges the boundary continues at the angle of the tip, so that the electrode
//! reaches round at most half an edge. Every surface is joined from closed rings with the same number of points, which
//! makes it watertight by construction.
//!
//! Guaranteed: the whole surface keeps the spark gap to a micrometre. Not guaranteed: that the electrode can be withdrawn,
//! which the planner finds and the verifier proves.

mod body;
mod boundary;
mod holder;
mod make;
mod measure;
mod own;
mod params;
mod ring;
mod stage;
pub mod walls;
mod worn;

#[cfg(test)]
mod tests;

use files::Invalid;
use glam::{DVec2, DVec3};
use serde::{Deserialize, Serialize};

pub use make::{Junctions, make_electrode, make_electrodes};
pub use own::from_user_mesh;
pub use params::{ElectrodeParams, EnterSide, OwnMesh, PartParams, Sizing};
pub use stage::StageParams;

use crate::channel::{Channel, Flow, OPENS, ways_out};
use geometry::exact::ExactMeshError;
use geometry::mesh::{Mesh, normal_times_two_areas};
use geometry::patch::Patch;
use task::Cancelled;

/// Purpose of a face of an electrode.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum ElectrodeFace {
    /// Burns the wall on the side of smaller theta.
    LowWall,
    /// Burns the wall on the side of greater theta.
    HighWall,
    /// Burns the hub.
    HubSide,
    /// Burns the shroud, or ends at the blades' tips.
    ShroudSide,
    /// Looks at the other column of a channel that is divided left and right.
    Division,
    /// The plane end away from the side of entry.
    FarEnd,
    /// The shoulder from the burning part to the shank.
    EntryEnd,
    /// The shank.
    Shank,
    /// The holder block with its shoulder.
    Holder,
}

impl ElectrodeFace {
    /// Whether the face erodes stock when the electrode has arrived: all but shoulder, shank and holder.
    pub fn burns(self) -> bool {
        !matches!(self, Self::EntryEnd | Self::Shank | Self::Holder)
    }
}

/// Side of a channel divided left and right that an electrode burns.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Column {
    /// The low wall.
    Low,
    /// The high wall.
    High,
}

/// Angles by which the walls of `column` are turned inwards, of those given for the low and the high wall; the surface
/// between the columns does not turn (rad).
pub fn own_turns(column: Option<Column>, [low, high]: [f64; 2]) -> [f64; 2] {
    match column {
        None => [low, high],
        Some(Column::Low) => [low, 0.0],
        Some(Column::High) => [0.0, high],
    }
}

/// The side of the blisk, in W, that an electrode enters from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum EntrySide {
    /// Entry from the side of smaller x.
    #[serde(rename = "-x")]
    MinusX,
    /// Entry from the side of greater x.
    #[serde(rename = "+x")]
    PlusX,
    /// Entry at the rim: withdrawal along Z, the direction in which the passage runs out there.
    #[serde(rename = "outward")]
    Outward,
    /// Entry from the free bore of a ring: withdrawal against Z.
    #[serde(rename = "inward")]
    Inward,
}

impl EntrySide {
    /// All sides, in the order in which they are tried.
    pub const ALL: [Self; 4] = [Self::MinusX, Self::PlusX, Self::Outward, Self::Inward];

    /// The sign of the direction in which the electrode is withdrawn, on the axis along which it is.
    pub fn sign(self) -> f64 {
        match self {
            Self::MinusX | Self::Inward => -1.0,
            Self::PlusX | Self::Outward => 1.0,
        }
    }

    /// The direction in W in which the electrode is withdrawn, a unit vector.
    pub fn direction(self) -> DVec3 {
        match self {
            Self::MinusX => DVec3::NEG_X,
            Self::PlusX => DVec3::X,
            Self::Outward => DVec3::Z,
            Self::Inward => DVec3::NEG_Z,
        }
    }

    /// Name in files and reports.
    pub fn name(self) -> &'static str {
        EnterSide::from(self).name()
    }

    /// Name in the sentences of reports.
    pub fn words(self) -> &'static str {
        match self {
            Self::Outward => "the rim",
            Self::Inward => "the bore",
            other => other.name(),
        }
    }

    /// Name in the window's sentences.
    pub fn label(self) -> &'static str {
        match self {
            Self::MinusX => "-X",
            Self::PlusX => "+X",
            Self::Outward => "the rim",
            Self::Inward => "the bore",
        }
    }

    /// The sides to which the passage of `channel` opens, in the order in which they are tried.
    pub fn open(channel: &Channel) -> Vec<Self> {
        Self::ALL.into_iter().filter(|side| side.mouth(channel).is_ok()).collect()
    }

    /// Whether the end of the passage that opens to this side is its last station; if not, its first.
    ///
    /// # Errors
    /// [`ElectrodeError::NoMouth`] if neither end does.
    pub fn mouth(self, channel: &Channel) -> Result<bool, ElectrodeError> {
        let no_mouth = ElectrodeError::NoMouth { side: self, flow: channel.flow };
        let towards = match self {
            Self::MinusX => DVec2::NEG_X,
            Self::PlusX => DVec2::X,
            Self::Outward => DVec2::Y,
            Self::Inward => DVec2::NEG_Y,
        };
        let [first, last] =
            if channel.flow == Flow::Axial { [DVec2::NEG_X, DVec2::X] } else { ways_out(&channel.meridian) };
        match [first, last].map(|way| way.dot(towards)) {
            [first, last] if first.max(last) < OPENS => Err(no_mouth),
            [first, last] => Ok(last >= first),
        }
    }
}

/// What lets a shank that leaves along the radius run straight on along the passage.
fn straight(side: EntrySide) -> &'static str {
    match side {
        EntrySide::Outward => "; with blisk.z_at = \"rim\" Z is along the passage there",
        EntrySide::Inward => "; with blisk.z_at = \"bore\" Z goes through the mouth there",
        EntrySide::MinusX | EntrySide::PlusX => "",
    }
}

/// How near an electrode comes to the blisk, whose surface is `clearance` (mm) away, negative inside it.
fn near(clearance: f64) -> String {
    match clearance < 0.0 {
        true => format!("reaches {:.3} mm into the blisk", -clearance),
        false => format!("comes within {clearance:.4} mm of the blisk"),
    }
}

/// A four-sided part of the surface of an electrode.
#[derive(Debug, Clone, PartialEq)]
pub struct ElectrodePatch {
    /// Face of the electrode that the patch belongs to.
    pub face: ElectrodeFace,
    /// Vertices of the electrode's mesh.
    pub grid: Patch,
}

/// An electrode in its final pose, in the workpiece frame W.
#[derive(Debug, Clone, PartialEq)]
pub struct Electrode {
    /// The closed surface (mm, in W).
    pub mesh: Mesh,
    /// Face that each triangle belongs to.
    pub faces: Vec<ElectrodeFace>,
    /// The smooth parts of the surface, which share whole sides; empty for an own mesh.
    pub patches: Vec<ElectrodePatch>,
    /// The side it enters from and is withdrawn to.
    pub enters_from: EntrySide,
    /// Reference point O in W: in an axial passage the middle of the burning part along X, y = 0, its mean radius as z;
    /// in any other the middle of the holder, at the burning part's middle along the direction of withdrawal (mm).
    pub reference_point: DVec3,
    /// Name of the stage that it burns in; none where there are no stages.
    pub stage: Option<String>,
    /// Number of the part of the channel that the electrode burns, counted along the passage from its first station,
    /// from 0.
    pub part: usize,
    /// Number of parts.
    pub parts: usize,
    /// Side of the channel that the electrode burns, where the channel is divided left and right.
    pub column: Option<Column>,
    /// The thinnest metal between the low and the high wall, or a wall and the division, along the walls' normals
    /// (mm); infinite when no normal of one meets the other.
    pub least_thickness_mm: f64,
    /// Volume with shank and holder (mm^3).
    pub volume_mm3: f64,
    /// Area of the faces that burn: walls, hub side, shroud side and far end (mm^2).
    pub burn_area_mm2: f64,
    /// Distance to the finished surface that it is made for: the spark gap, and the stock that its stage leaves (mm).
    pub undersize_mm: f64,
    /// Exact distance to the finished blisk in the final pose (mm).
    pub clearance_mm: f64,
    /// Assumptions made, in plain sentences for the user.
    pub assumed: Vec<String>,
}

impl Electrode {
    /// The middle of the faces that burn, each with its area, in W (mm).
    pub fn middle(&self) -> DVec3 {
        let burning = self.mesh.iter_corners().zip(&self.faces).filter(|(_, face)| face.burns());
        let weighted = burning.map(|(corners, _)| {
            let twice = normal_times_two_areas(corners).length();
            (twice * corners.iter().sum::<DVec3>() / 3.0, twice)
        });
        let (sum, all) = weighted.fold((DVec3::ZERO, 0.0), |(sum, all), (place, area)| (sum + place, all + area));
        if all > 0.0 { sum / all } else { self.reference_point }
    }

    /// Number of the electrode in lists, where it is at `index` of all, and its stage: `2 (finish)`.
    pub fn label(&self, index: usize) -> String {
        stage::label(index, self.stage.as_deref())
    }

    /// Stage and share of a divided channel that the electrode burns: `finish, part 1 of 2, low side`; empty for a single
    /// electrode.
    pub fn share(&self) -> String {
        let part = (self.parts > 1).then(|| format!("part {} of {}", self.part + 1, self.parts));
        let column = self.column.map(|column| match column {
            Column::Low => "low side".to_owned(),
            Column::High => "high side".to_owned(),
        });
        self.stage.clone().into_iter().chain(part).chain(column).collect::<Vec<_>>().join(", ")
    }
}

/// Reason why no electrode can be made.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ElectrodeError {
    /// Cancelled.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    /// A parameter cannot be used.
    #[error(transparent)]
    Params(#[from] Invalid),
    /// The channel does not open to the wanted side.
    #[error(
        "the passage is {} and neither of its ends opens to {} within 45 degrees: choose another side of entry, or auto",
        .flow.name(), .side.label()
    )]
    NoMouth {
        /// The side.
        side: EntrySide,
        /// Direction of the passage.
        flow: Flow,
    },
    /// The channel lacks what an electrode is made from.
    #[error("the channel cannot carry an electrode: {0}; look at the channel step, or give its radii by hand")]
    BadChannel(&'static str),
    /// The middle of the channel is nearer to the blisk than the spark gap.
    #[error(
        "the channel is too narrow at x = {x:.2} mm, radius {r:.2} mm: its middle is {clearance:.3} mm from the blisk, \
         the spark gap is {gap:.3} mm; lower spark_gap_mm or check the channel"
    )]
    NoPassage {
        /// Place along X (mm).
        x: f64,
        /// Radius of the place (mm).
        r: f64,
        /// Distance of the middle to the blisk (mm).
        clearance: f64,
        /// Spark gap (mm).
        gap: f64,
    },
    /// Straight on beyond the edges of its blades the channel's middle meets the blisk.
    #[error(
        "straight on beyond the edges of its blades the channel's middle is free for {beyond:.2} mm, and meets the blisk at \
         x = {x:.2} mm, radius {r:.2} mm, as ahead of a splitter: set overrun_mm to no more than that"
    )]
    Overrun {
        /// Place along X (mm).
        x: f64,
        /// Radius of the place (mm).
        r: f64,
        /// Distance from the edges, along the passage, up to which it is free (mm).
        beyond: f64,
    },
    /// The middle of the channel is inside the blisk's mesh.
    #[error(
        "the channel's middle at x = {x:.2} mm, radius {r:.2} mm is inside the blisk's mesh: either the channel is \
         wrong, or the mesh is folded near there (blade tips often are); mend the mesh, or stay below the tips by \
         raising radial_reduction_mm"
    )]
    InsideBlisk {
        /// Place along X (mm).
        x: f64,
        /// Radius of the place (mm).
        r: f64,
    },
    /// Beyond the blades of the passage the blisk stands in the way out.
    #[error(
        "from the end of the passage the shank goes out at the angle of the blades' edges, and at x = {x:.2} mm, radius \
         {r:.2} mm another blade stands in its way, as beside a splitter: choose another side of entry, or another channel"
    )]
    WayOut {
        /// Place along X (mm).
        x: f64,
        /// Radius of the place (mm).
        r: f64,
    },
    /// The reductions leave no metal between the walls.
    #[error(
        "no metal is left at x = {x:.2} mm, radius {r:.2} mm: the channel less the gap is {available:.3} mm wide there \
         and the reductions take {taken:.3} mm; lower circumferential_reduction_deg"
    )]
    NoMetal {
        /// Place along X (mm).
        x: f64,
        /// Radius of the place (mm).
        r: f64,
        /// Width along the circumference without reductions (mm).
        available: f64,
        /// Part of it that the reductions take (mm).
        taken: f64,
    },
    /// The radial reduction, or the inset of the shank, leaves no height between hub and shroud.
    #[error(
        "no height is left at x = {x:.2} mm: there is {available:.3} mm between hub and shroud less the gaps{}, and {} {taken:.3} mm; \
         lower {}",
        if *.of_shank { " and the radial reduction" } else { "" },
        if *.of_shank { "the shank's insets take" } else { "the radial reduction takes" },
        if *.of_shank { "shank_inset_mm, channel_shank_inset_mm or radial_reduction_mm" } else { "radial_reduction_mm" }
    )]
    NoHeight {
        /// Where along X (mm).
        x: f64,
        /// Height that there is for it (mm).
        available: f64,
        /// Part of it that is taken (mm).
        taken: f64,
        /// Whether it is the shank that has none.
        of_shank: bool,
    },
    /// None can be made for any side of entry.
    #[error("{}", .0.iter().map(|(side, why)| format!("towards {}: {why}", side.words())).collect::<Vec<_>>().join("; "))]
    Sides(Vec<(EntrySide, ElectrodeError)>),
    /// A part is too short for its overlaps.
    #[error(
        "part {part} along the passage is {length:.2} mm long, too short for an overlap of {overlap:.2} mm: use fewer parts, \
         move its divisions, or lower the overlap"
    )]
    PartTooShort {
        /// The part, counted from 1.
        part: usize,
        /// Its length (mm).
        length: f64,
        /// Overlap asked for (mm).
        overlap: f64,
    },
    /// The electrode came out nearer to the blisk than the gap.
    #[error(
        "the electrode {} at ({:.2}, {:.2}, {:.2}) mm in the workpiece frame, \
         the gap is {gap:.4} mm: raise radial_reduction_mm or circumferential_reduction_deg to keep it clear of that place; a \
         hub or shroud that is drawn by hand must stay within the passage there",
        near(*clearance), at.x, at.y, at.z
    )]
    TooClose {
        /// Least distance (mm).
        clearance: f64,
        /// Spark gap (mm).
        gap: f64,
        /// Where, in W (mm).
        at: DVec3,
    },
    /// The channel opens to no side.
    #[error(
        "the passage is {} and opens neither along the axis nor to the rim within 45 degrees: no electrode can leave it \
         straight",
        .0.name()
    )]
    Closed(Flow),
    /// Shank or holder, which go straight to the side of entry, meet the blisk.
    #[error(
        "the shank, which goes straight on towards {} from the end of the passage, {} at ({:.2}, {:.2}, {:.2}) mm in the workpiece frame, the gap is {gap:.3} mm: choose another side of entry, \
         more parts, or a larger shank inset{}",
        .side.label(), near(*clearance), at.x, at.y, at.z, straight(*side)
    )]
    ShankMeets {
        /// The side of entry.
        side: EntrySide,
        /// Distance to the blisk, negative inside it (mm).
        clearance: f64,
        /// Spark gap (mm).
        gap: f64,
        /// Where, in W (mm).
        at: DVec3,
    },
    /// A mesh cannot be searched.
    #[error("the electrode's mesh: {0}")]
    Unsearchable(#[from] ExactMeshError),
    /// An own mesh is open or not oriented.
    #[error("the electrode's mesh is not closed and consistently oriented: repair it in the program it came from")]
    NotWatertight,
    /// An own mesh is inside out.
    #[error("the electrode's mesh is inside out (volume {0:.3} mm^3): turn its triangles round")]
    InsideOut(f64),
    /// An own mesh crosses the blisk.
    #[error(
        "the electrode's mesh touches or crosses the blisk in its final pose: it must be given in the final pose, in \
         the frame and units of the blisk's mesh"
    )]
    Interferes,
}

impl ElectrodeError {
    /// The reason where no side of entry can have an electrode: those of all sides, in the order in which they were
    /// tried, or the one that is the same for all; none if there are none.
    pub fn of_sides(reasons: Vec<(EntrySide, Self)>) -> Option<Self> {
        let first = reasons.first()?.1.clone();
        Some(if reasons.iter().all(|(_, reason)| *reason == first) { first } else { Self::Sides(reasons) })
    }
}
