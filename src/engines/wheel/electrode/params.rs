//! Parameters of an electrode.

use std::path::PathBuf;

use files::Invalid;
use serde::{Deserialize, Serialize};

use super::{ElectrodeError, EntrySide};
use crate::channel::Channel;

/// Parameters by which an electrode is derived from its channel (`[electrode]`).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ElectrodeParams {
    /// Spark gap between the burning faces and the finished blisk (mm).
    pub spark_gap_mm: f64,
    /// Angle by which the low and the high wall of the electrode are turned about X away from their blades; P0's
    /// circumferential reduction h (deg).
    pub circumferential_reduction_deg: [f64; 2],
    /// Radial reduction: distance by which the shroud side is drawn in towards the hub (mm).
    pub radial_reduction_mm: f64,
    /// Number of electrodes the channel is divided between along the passage.
    pub parts: usize,
    /// Overlap along the passage of the burns of two neighbouring parts, each with the spark gap that it burns beyond itself
    /// (mm). With 0 the burns only meet, and a ridge is left between them on every wall.
    pub overlap_mm: f64,
    /// 1, or 2 to divide every part left and right along the channel's middle surface too, as P1 does: one electrode
    /// burns the low wall, the other the high wall.
    pub columns: usize,
    /// Overlap along the circumference of the burns of the two columns (mm), counted in the same way; negative leaves a
    /// web between them.
    pub column_overlap_mm: f64,
    /// Share of the channel's width that belongs to the low column.
    pub column_split: f64,
    /// The side of the blisk, in W, that the electrodes enter from and are withdrawn to.
    pub enter: EnterSide,
    /// Whether the reductions are as given or the least for which a path exists.
    pub size: Sizing,
    /// An electrode of one's own, in its final pose in the frame of the blisk's mesh, instead of a derived one.
    pub mesh: Option<PathBuf>,
    /// Distance by which the burning part reaches past the tips of the blades' edges, at most to where the passage
    /// ends (mm).
    pub overrun_mm: f64,
    /// Inset of the shank from the burning part, all round (mm).
    pub shank_inset_mm: f64,
    /// Inset of the shank of a part that stands deeper in the channel, where it passes between the blades (mm).
    pub channel_shank_inset_mm: f64,
    /// Distance by which the shank reaches out of the blisk's face, or rim (mm).
    pub shank_length_mm: f64,
    /// Length along the direction of withdrawal, width and height from hub to shroud of the holder block (mm); it grows
    /// where the shank is larger.
    pub holder_mm: [f64; 3],
}

impl Default for ElectrodeParams {
    fn default() -> Self {
        Self {
            spark_gap_mm: 0.10,
            circumferential_reduction_deg: [0.8, 0.8],
            radial_reduction_mm: 0.5,
            parts: 1,
            overlap_mm: 1.0,
            columns: 1,
            column_overlap_mm: 0.5,
            column_split: 0.5,
            enter: EnterSide::Auto,
            size: Sizing::Given,
            mesh: None,
            overrun_mm: 0.5,
            shank_inset_mm: 0.3,
            channel_shank_inset_mm: 0.5,
            shank_length_mm: 10.0,
            holder_mm: [16.0, 20.0, 24.0],
        }
    }
}

/// The wanted side of entry.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum EnterSide {
    /// Entry from the side of greater x.
    #[serde(rename = "+x")]
    PlusX,
    /// Entry from the side of smaller x.
    #[serde(rename = "-x")]
    MinusX,
    /// Entry along the radius, from outside.
    #[serde(rename = "outward")]
    Outward,
    /// The better side.
    #[default]
    #[serde(rename = "auto")]
    Auto,
}

impl EnterSide {
    /// Name of the side in project files.
    pub fn name(self) -> &'static str {
        match self {
            Self::PlusX => "+x",
            Self::MinusX => "-x",
            Self::Outward => "outward",
            Self::Auto => "auto",
        }
    }

    /// Whether an electrode may enter from `side`.
    pub fn allows(self, side: EntrySide) -> bool {
        self == Self::Auto || self == side.into()
    }

    /// The sides to try: the given one, or all that the passage of `channel` opens to, those at its first station first.
    ///
    /// # Errors
    /// If the passage does not open to the given side, or to none.
    pub fn candidates(self, channel: &Channel) -> Result<Vec<EntrySide>, ElectrodeError> {
        let only = |side: EntrySide| side.mouth(channel).map(|_| vec![side]);
        match self {
            Self::PlusX => only(EntrySide::PlusX),
            Self::MinusX => only(EntrySide::MinusX),
            Self::Outward => only(EntrySide::Outward),
            Self::Auto => {
                let mut sides = EntrySide::open(channel);
                sides.sort_by_key(|side| side.mouth(channel) == Ok(true));
                if sides.is_empty() { Err(ElectrodeError::Closed(channel.flow)) } else { Ok(sides) }
            }
        }
    }
}

impl From<EntrySide> for EnterSide {
    fn from(side: EntrySide) -> Self {
        match side {
            EntrySide::MinusX => Self::MinusX,
            EntrySide::PlusX => Self::PlusX,
            EntrySide::Outward => Self::Outward,
        }
    }
}

/// Source of the size of an electrode.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Sizing {
    /// The reductions are those of the parameters.
    #[default]
    Given,
    /// The least reductions for which a path exists are searched for.
    Auto,
}

impl ElectrodeParams {
    /// Whether every value is within its range.
    pub fn validate(&self) -> Result<(), Invalid> {
        let [low, high] = self.circumferential_reduction_deg;
        let [length, width, height] = self.holder_mm;
        [
            ("spark_gap_mm", self.spark_gap_mm, [0.005, 2.0], "mm"),
            ("circumferential_reduction_deg[0]", low, [0.0, 45.0], "deg"),
            ("circumferential_reduction_deg[1]", high, [0.0, 45.0], "deg"),
            ("radial_reduction_mm", self.radial_reduction_mm, [0.0, 100.0], "mm"),
            ("parts", self.parts as f64, [1.0, 20.0], ""),
            ("overlap_mm", self.overlap_mm, [0.0, 100.0], "mm"),
            ("columns", self.columns as f64, [1.0, 2.0], ""),
            ("column_overlap_mm", self.column_overlap_mm, [-20.0, 20.0], "mm"),
            ("column_split", self.column_split, [0.1, 0.9], ""),
            ("overrun_mm", self.overrun_mm, [0.0, 100.0], "mm"),
            ("shank_inset_mm", self.shank_inset_mm, [0.02, 20.0], "mm"),
            ("channel_shank_inset_mm", self.channel_shank_inset_mm, [0.02, 20.0], "mm"),
            ("shank_length_mm", self.shank_length_mm, [0.5, 500.0], "mm"),
            ("holder_mm[0]", length, [0.5, 500.0], "mm"),
            ("holder_mm[1]", width, [0.5, 500.0], "mm"),
            ("holder_mm[2]", height, [0.5, 500.0], "mm"),
        ]
        .into_iter()
        .try_for_each(|(key, value, range, unit)| Invalid::unless_within(key, value, range, unit))
        .map_err(|problem| problem.within("electrode"))
    }

    /// Number of electrodes that the channel is divided between.
    pub fn count(&self) -> usize {
        self.parts * self.columns
    }

    /// Length along X that two neighbouring parts themselves share (mm); negative where they stand apart.
    pub(super) fn shared_length(&self) -> f64 {
        self.overlap_mm - 2.0 * self.spark_gap_mm
    }

    /// Circumferential reductions of the low and the high wall (rad).
    pub(super) fn turns(&self) -> [f64; 2] {
        self.circumferential_reduction_deg.map(f64::to_radians)
    }
}
