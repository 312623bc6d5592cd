//! The electrode of a channel: the channel's negative, drawn in by the spark gap, reduced, divided, and given a
//! shank and a holder block (P0, section II and figure 1).
//!
//! The burning part is built from planes across X. In each plane the unreduced boundary is where the exact
//! distance to the finished blisk equals the spark gap; then each wall is turned about X away from its blade and
//! the shroud side is drawn in. Past the tips of the blades' edges the boundary goes straight on at the angle of
//! the tip, so that the electrode never reaches round more than half an edge. Every surface is joined from closed
//! rings with the same number of points, which makes it watertight by construction.
//!
//! What is guaranteed: vertices, face centres and the nearest place of every edge keep the spark gap, so that on a
//! blisk meshed as finely as usual the whole surface keeps it to a micrometre. What is not: that the electrode can
//! be got out; that is the planner's and the verifier's business.

mod body;
mod boundary;
mod divide;
mod measure;
mod own;
mod params;
mod ring;
pub mod walls;

#[cfg(test)]
mod tests;

use glam::DVec3;
use serde::{Deserialize, Serialize};

pub use divide::own_turns;
pub use own::from_user_mesh;
pub use params::{ElectrodeParams, EnterSide, Sizing};

use super::channel::{Channel, ChannelWall};
use boundary::Boundary;
use geometry::exact::{ExactMesh, ExactMeshError};
use geometry::frame::Cylindrical;
use geometry::mesh::Mesh;
use ring::Finisher;
use task::{Cancel, Cancelled, Progress};

/// What a face of an electrode is.
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

/// Which side of a channel that is divided left and right an electrode burns.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Column {
    /// The low wall.
    Low,
    /// The high wall.
    High,
}

/// The side of the blisk, in W, that an electrode enters from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum EntrySide {
    /// From the side of smaller x.
    #[serde(rename = "-x")]
    MinusX,
    /// From the side of greater x.
    #[serde(rename = "+x")]
    PlusX,
}

impl EntrySide {
    /// The sign of the direction in which the electrode is withdrawn.
    pub fn sign(self) -> f64 {
        match self {
            Self::MinusX => -1.0,
            Self::PlusX => 1.0,
        }
    }
}

/// An electrode in its final pose, in the workpiece frame W.
#[derive(Debug, Clone, PartialEq)]
pub struct Electrode {
    /// The closed surface (mm, in W).
    pub mesh: Mesh,
    /// What each triangle is.
    pub faces: Vec<ElectrodeFace>,
    /// The side it enters from and is withdrawn to.
    pub enters_from: EntrySide,
    /// Reference point O in W: the middle of the burning part along X, y = 0, its mean radius as z (mm).
    pub reference_point: DVec3,
    /// Which part of the channel it burns, counted from the side of entry, from 0: the order of burning.
    pub part: usize,
    /// Number of parts.
    pub parts: usize,
    /// Which side of the channel it burns, where that is divided left and right.
    pub column: Option<Column>,
    /// The thinnest metal between the low and the high wall, or a wall and the division, along the walls' normals
    /// (mm); infinite when no normal of one meets the other.
    pub least_thickness_mm: f64,
    /// Volume with shank and holder (mm^3).
    pub volume_mm3: f64,
    /// Area of the faces that burn: walls, hub side, shroud side and far end (mm^2).
    pub burn_area_mm2: f64,
    /// Exact distance to the finished blisk in the final pose: for a derived electrode the least over vertices,
    /// edge midpoints and face centres, for an own mesh over the whole surfaces (mm).
    pub clearance_mm: f64,
    /// What was assumed, in plain sentences for the user.
    pub assumed: Vec<String>,
}

impl Electrode {
    /// What it burns, where the channel is divided: `part 1 of 2, low side`; empty for a single electrode.
    pub fn share(&self) -> String {
        let part = (self.parts > 1).then(|| format!("part {} of {}", self.part + 1, self.parts));
        let column = self.column.map(|column| match column {
            Column::Low => "low side".to_owned(),
            Column::High => "high side".to_owned(),
        });
        part.into_iter().chain(column).collect::<Vec<_>>().join(", ")
    }
}

/// Why there is no electrode.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ElectrodeError {
    /// The computation was told to stop.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    /// A parameter is out of its range.
    #[error("[electrode] {name} is {value}: it must be from {from} to {to}")]
    OutOfRange {
        /// The parameter's name.
        name: &'static str,
        /// Its value.
        value: f64,
        /// Least value allowed.
        from: f64,
        /// Greatest value allowed.
        to: f64,
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
        /// Where along X (mm).
        x: f64,
        /// At which radius (mm).
        r: f64,
        /// Distance of the middle to the blisk (mm).
        clearance: f64,
        /// Spark gap (mm).
        gap: f64,
    },
    /// The middle of the channel is inside the blisk's mesh.
    #[error(
        "the channel's middle at x = {x:.2} mm, radius {r:.2} mm is inside the blisk's mesh: either the channel is wrong, or \
         the mesh is folded near there (blade tips often are); mend the mesh, or stay below the tips by raising \
         radial_reduction_mm"
    )]
    InsideBlisk {
        /// Where along X (mm).
        x: f64,
        /// At which radius (mm).
        r: f64,
    },
    /// The reductions leave no metal between the walls.
    #[error(
        "no metal is left at x = {x:.2} mm, radius {r:.2} mm: the channel less the gap is {available:.3} mm wide there \
         and the reductions take {taken:.3} mm; lower circumferential_reduction_deg"
    )]
    NoMetal {
        /// Where along X (mm).
        x: f64,
        /// At which radius (mm).
        r: f64,
        /// Width along the circumference without reductions (mm).
        available: f64,
        /// What the reductions take of it (mm).
        taken: f64,
    },
    /// The reductions leave no height between hub and shroud.
    #[error(
        "no height is left at x = {x:.2} mm: there is {available:.3} mm between hub and shroud less the gaps, and \
         the radial reduction and insets take {taken:.3} mm; lower radial_reduction_mm"
    )]
    NoHeight {
        /// Where along X (mm).
        x: f64,
        /// Height without reductions (mm).
        available: f64,
        /// What the reductions take of it (mm).
        taken: f64,
    },
    /// The parts are too short for their overlap.
    #[error("{parts} parts of {length:.2} mm cannot overlap by {overlap:.2} mm: use fewer parts or lower overlap_mm")]
    PartsTooShort {
        /// Number of parts.
        parts: usize,
        /// Length of each (mm).
        length: f64,
        /// Overlap asked for (mm).
        overlap: f64,
    },
    /// The electrode came out nearer to the blisk than the gap.
    #[error(
        "the electrode is only {clearance:.4} mm from the blisk at ({:.2}, {:.2}, {:.2}) mm in the workpiece frame, the \
         gap is {gap:.4} mm: look at the blisk's mesh there, it may be coarse, open or crossing itself", at.x, at.y, at.z
    )]
    TooClose {
        /// Least distance (mm).
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
        "the electrode's mesh touches or crosses the blisk in its final pose: it must be given in the final pose, in the \
         frame and units of the blisk's mesh"
    )]
    Interferes,
}

/// Makes the electrodes of `channel`, in the order of burning: the part next to the side of entry first, and of each
/// part the low column first.
///
/// `blisk` is the finished blisk in W. The result does not depend on the number of threads.
///
/// # Errors
/// An [`ElectrodeError`] that says where the channel leaves no room for the wanted gap and reductions.
pub fn make_electrodes(
    channel: &Channel,
    blisk: &ExactMesh,
    params: &ElectrodeParams,
    side: EntrySide,
    progress: &Progress,
    cancel: &Cancel,
) -> Result<Vec<Electrode>, ElectrodeError> {
    params.validate()?;
    progress.report("electrode", 0.0, "boundary of the channel");
    let boundary = Boundary::new(channel, blisk, params)?;
    let extent = burning_extent(channel, params);
    let ranges = part_ranges(extent, params, side)?;
    let mut planes: Vec<f64> = ranges.iter().flatten().copied().collect();
    planes.extend(edge_planes(channel, params, extent));
    planes.extend(runout(channel, extent, side));
    let sections = boundary.sections(extent, &planes, cancel)?;
    let finisher = Finisher::new(&boundary, &sections);
    let mut electrodes = Vec::with_capacity(params.count());
    let columns: &[Option<Column>] =
        if params.columns > 1 { &[Some(Column::Low), Some(Column::High)] } else { &[None] };
    for &column in columns {
        let sections: Vec<_> = sections.iter().map(|s| divide::column_of(s, column, params)).collect();
        for (part, &range) in ranges.iter().enumerate() {
            progress.report("electrode", (electrodes.len() + 1) as f64 / (params.count() + 1) as f64, "surfaces");
            let plan = body::Plan { channel, params, side, part, column, range, sections: &sections };
            electrodes.push(body::build(&plan, &finisher, cancel)?);
        }
    }
    electrodes.sort_by_key(|e| e.part);
    progress.report("electrode", 1.0, "");
    Ok(electrodes)
}

/// The points of a channel wall turned about X by `angle` (rad): where a wall reduced by P0's h stands.
pub fn turned_wall(wall: &ChannelWall, angle: f64) -> Vec<DVec3> {
    let turned = |&p: &DVec3| {
        let at = Cylindrical::from_point(p);
        Cylindrical { theta: at.theta + angle, ..at }.point()
    };
    wall.points.iter().map(turned).collect()
}

/// The span of X that is burned: that of the blades and the overrun, at most to the faces.
fn burning_extent(channel: &Channel, params: &ElectrodeParams) -> [f64; 2] {
    let [from, to] = channel.span_x();
    let [front, back] = channel.faces_x;
    [(from - params.overrun_mm).max(front.min(from)), (to + params.overrun_mm).min(back.max(to))]
}

/// The span of X of each part, counted from the side of entry.
fn part_ranges(extent: [f64; 2], params: &ElectrodeParams, side: EntrySide) -> Result<Vec<[f64; 2]>, ElectrodeError> {
    let (parts, shared) = (params.parts, params.shared_length());
    let length = (extent[1] - extent[0] + (parts - 1) as f64 * shared) / parts as f64;
    if parts > 1 && length < 2.0 * params.overlap_mm {
        return Err(ElectrodeError::PartsTooShort { parts, length, overlap: params.overlap_mm });
    }
    let mut ranges: Vec<_> = (0..parts)
        .map(|k| extent[0] + k as f64 * (length - shared))
        .map(|from| [from, (from + length).min(extent[1])])
        .collect();
    if let Some(last) = ranges.last_mut() {
        last[1] = extent[1];
    }
    if side == EntrySide::PlusX {
        ranges.reverse();
    }
    Ok(ranges)
}

/// Where the burns of parts and columns meet that share so little that stock may be left between them.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Junctions {
    /// Planes across X (mm).
    pub planes: Vec<f64>,
    /// The share of the channel's width where two columns meet.
    pub split: Option<f64>,
}

impl Junctions {
    /// Those of electrodes that are made with `params`; none where the burns share more than the spark gap, so that each
    /// covers the other's rounded edge.
    ///
    /// # Errors
    /// If the parts are too short.
    pub fn of(channel: &Channel, params: &ElectrodeParams) -> Result<Self, ElectrodeError> {
        let gap = params.spark_gap_mm;
        let ranges = part_ranges(burning_extent(channel, params), params, EntrySide::MinusX)?;
        let meet = ranges.windows(2).map(|pair| 0.5 * (pair[0][1] + pair[1][0]));
        Ok(Self {
            planes: if params.overlap_mm < gap { meet.collect() } else { Vec::new() },
            split: (params.columns > 1 && params.column_overlap_mm < gap).then_some(params.column_split),
        })
    }
}

/// Planes where the boundary stops following the edges of the blades.
fn edge_planes(channel: &Channel, params: &ElectrodeParams, extent: [f64; 2]) -> Vec<f64> {
    let ([from, to], gap) = (channel.span_x(), params.spark_gap_mm);
    let planes = [from - gap, from - 0.5 * gap, from, to, to + 0.5 * gap, to + gap];
    planes.into_iter().filter(|x| (extent[0]..=extent[1]).contains(x)).collect()
}

/// Planes between the burning part and the face on the side of entry, the face included.
fn runout(channel: &Channel, extent: [f64; 2], side: EntrySide) -> Vec<f64> {
    let (from, to) = match side {
        EntrySide::MinusX => (extent[0], channel.faces_x[0]),
        EntrySide::PlusX => (extent[1], channel.faces_x[1]),
    };
    if (to - from) * side.sign() <= 1e-9 {
        return Vec::new();
    }
    let steps = (to - from).abs().ceil().clamp(1.0, 50.0) as usize;
    (1..=steps).map(|i| from + (to - from) * i as f64 / steps as f64).collect()
}
