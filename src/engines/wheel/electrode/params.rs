//! Parameters of an electrode.

use std::path::{Path, PathBuf};

use files::Invalid;
use serde::{Deserialize, Serialize};

use super::{Column, ElectrodeError, EntrySide, StageParams};
use crate::channel::Channel;
use crate::options::Auto;

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
    /// What single parts have of their own, in order along the passage, that at its first station first
    /// (`[[electrode.part]]`). Parts without a row are like all others.
    pub part: Vec<PartParams>,
    /// Overlap along the passage of the burns of two neighbouring parts, each with the spark gap that it burns beyond itself
    /// (mm). With 0 the burns only meet, and a ridge is left between them on every wall.
    pub overlap_mm: f64,
    /// 1, or 2 to divide every part left and right along the channel's middle surface too, as P1 does: one electrode
    /// burns the low wall, the other the high wall.
    pub columns: usize,
    /// Overlap along the circumference of the burns of the two columns (mm), counted in the same way; negative leaves a
    /// web between them.
    pub column_overlap_mm: f64,
    /// Share of the channel's width that belongs to the low column; found so that both columns are equally thick unless
    /// it is given.
    pub column_split: Auto<f64>,
    /// The side of the blisk, in W, that the electrodes enter from and are withdrawn to.
    pub enter: EnterSide,
    /// Whether the reductions are as given or the least for which a path exists.
    pub size: Sizing,
    /// An electrode of one's own, in its final pose in the frame of the blisk's mesh, instead of a derived one.
    pub mesh: Option<PathBuf>,
    /// More electrodes of one's own for the same channel, in the order in which they burn (`[[electrode.more]]`).
    pub more: Vec<OwnMesh>,
    /// Distance by which the burning part reaches past the tips of the blades' edges, at most to where the passage
    /// ends (mm).
    pub overrun_mm: f64,
    /// Stages in which the channel is burned, in order, each by electrodes of its own (`[[electrode.stage]]`). Without a row
    /// there is one stage, with what is given above.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub stage: Vec<StageParams>,
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
            part: Vec::new(),
            overlap_mm: 1.0,
            columns: 1,
            column_overlap_mm: 0.5,
            column_split: Auto::Auto,
            enter: EnterSide::Auto,
            size: Sizing::Given,
            mesh: None,
            more: Vec::new(),
            overrun_mm: 0.5,
            stage: Vec::new(),
            shank_inset_mm: 0.3,
            channel_shank_inset_mm: 0.5,
            shank_length_mm: 10.0,
            holder_mm: [16.0, 20.0, 24.0],
        }
    }
}

/// A further electrode of one's own.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct OwnMesh {
    /// Mesh of the electrode in its final pose, in the frame of the blisk's mesh.
    pub mesh: PathBuf,
    /// Side of entry of the electrode; automatic: that of all.
    pub enter: EnterSide,
}

/// What one part of a channel has of its own; what is left out is as for all parts.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct PartParams {
    /// Its side of entry.
    pub enter: EnterSide,
    /// Division between it and the next part, as a share of the burned length of the passage from its first station;
    /// where none is given, the parts on both sides are as thick as each other where each is thinnest, or as nearly as a
    /// place that leaves each of them a third of their length makes them.
    pub until: Option<f64>,
    /// Overlap with the next part (mm).
    pub overlap_mm: Option<f64>,
    /// Circumferential reduction of its low wall (deg).
    pub low_reduction_deg: Option<f64>,
    /// Circumferential reduction of its high wall (deg).
    pub high_reduction_deg: Option<f64>,
    /// Radial reduction (mm).
    pub radial_reduction_mm: Option<f64>,
}

impl PartParams {
    /// Whether every value is within its range.
    fn validate(&self) -> Result<(), Invalid> {
        [
            ("until", self.until, [0.01, 0.99], ""),
            ("overlap_mm", self.overlap_mm, OVERLAP, "mm"),
            ("low_reduction_deg", self.low_reduction_deg, TURN, "deg"),
            ("high_reduction_deg", self.high_reduction_deg, TURN, "deg"),
            ("radial_reduction_mm", self.radial_reduction_mm, RADIAL, "mm"),
        ]
        .into_iter()
        .filter_map(|(key, value, range, unit)| value.map(|value| (key, value, range, unit)))
        .try_for_each(|(key, value, range, unit)| Invalid::unless_within(key, value, range, unit))
    }
}

/// Range of the share of the low column.
pub(super) const COLUMN_SPLIT: [f64; 2] = [0.1, 0.9];
/// Ranges that hold for all parts and stages and for single ones.
pub(super) const GAP: [f64; 2] = [0.005, 2.0];
const OVERLAP: [f64; 2] = [0.0, 100.0];
/// Parts along the passage, and columns.
pub(super) const PARTS: [f64; 2] = [1.0, 20.0];
pub(super) const COLUMNS: [f64; 2] = [1.0, 2.0];
pub(super) const TURN: [f64; 2] = [0.0, 45.0];
pub(super) const RADIAL: [f64; 2] = [0.0, 100.0];

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
    /// Entry along the radius, from within the bore.
    #[serde(rename = "inward")]
    Inward,
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
            Self::Inward => "inward",
            Self::Auto => "auto",
        }
    }

    /// Whether an electrode may enter from `side`.
    pub fn allows(self, side: EntrySide) -> bool {
        self == Self::Auto || self == side.into()
    }

    /// The sides to try: the given one, or all that the passage of `channel` opens to, those at its first station first;
    /// the bore only where there is no other.
    ///
    /// # Errors
    /// If the passage does not open to the given side, or to none.
    pub fn candidates(self, channel: &Channel) -> Result<Vec<EntrySide>, ElectrodeError> {
        let only = |side: EntrySide| side.mouth(channel).map(|_| vec![side]);
        match self {
            Self::PlusX => only(EntrySide::PlusX),
            Self::MinusX => only(EntrySide::MinusX),
            Self::Outward => only(EntrySide::Outward),
            Self::Inward => only(EntrySide::Inward),
            Self::Auto => {
                let mut sides = EntrySide::open(channel);
                // A bore is reached by few machines.
                if sides.len() > 1 {
                    sides.retain(|side| *side != EntrySide::Inward);
                }
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
            EntrySide::Inward => Self::Inward,
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
            ("spark_gap_mm", self.spark_gap_mm, GAP, "mm"),
            ("circumferential_reduction_deg[0]", low, TURN, "deg"),
            ("circumferential_reduction_deg[1]", high, TURN, "deg"),
            ("radial_reduction_mm", self.radial_reduction_mm, RADIAL, "mm"),
            ("parts", self.parts as f64, PARTS, ""),
            ("overlap_mm", self.overlap_mm, OVERLAP, "mm"),
            ("columns", self.columns as f64, COLUMNS, ""),
            ("column_overlap_mm", self.column_overlap_mm, [-20.0, 20.0], "mm"),
            ("column_split", self.column_split.given().unwrap_or(0.5), COLUMN_SPLIT, ""),
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
        .and_then(|()| self.validate_own())
        .and_then(|()| self.validate_parts())
        .and_then(|()| self.validate_stages())
        .map_err(|problem| problem.within("electrode"))
    }

    fn validate_own(&self) -> Result<(), Invalid> {
        const MOST: usize = 19;
        let rows = || format!("a list of {} rows", self.more.len());
        if let Some(i) = self.more.iter().position(|own| own.mesh.as_os_str().is_empty()) {
            return Err(Invalid::new(
                format!("more[{i}].mesh"),
                "empty",
                "name the mesh of the electrode, or remove the row",
            ));
        }
        if self.mesh.is_none() && !self.more.is_empty() {
            return Err(Invalid::new(
                "more",
                rows(),
                "electrode.mesh names the first one: give it, or remove the rows",
            ));
        }
        if self.more.len() > MOST {
            return Err(Invalid::new("more", rows(), format!("at most {MOST} rows")));
        }
        Ok(())
    }

    pub(super) fn validate_parts(&self) -> Result<(), Invalid> {
        if self.part.len() > self.parts {
            let remedy = format!("more than electrode.parts, which is {}: remove rows, or raise parts", self.parts);
            return Err(Invalid::new("part", format!("a list of {} rows", self.part.len()), remedy));
        }
        for (i, part) in self.part.iter().enumerate() {
            part.validate().map_err(|problem| problem.within(&format!("part[{i}]")))?;
        }
        let divisions = self.divisions(1.0, 0.0);
        match (1..divisions.len()).find(|&i| divisions[i] <= divisions[i - 1]) {
            None => Ok(()),
            Some(i) => {
                let i = if self.part.get(i).is_some_and(|part| part.until.is_some()) { i } else { i - 1 };
                let remedy = "divisions must follow one another along the passage";
                let value = self.part.get(i).and_then(|part| part.until).unwrap_or_default();
                Err(Invalid::new(format!("part[{i}].until"), value, remedy))
            }
        }
    }

    /// The meshes of electrodes of one's own, in the order in which they burn.
    pub fn own_meshes(&self) -> impl Iterator<Item = &Path> {
        let more = self.more.iter().map(|own| own.mesh.as_path()).filter(|_| self.mesh.is_some());
        self.mesh.as_deref().into_iter().chain(more)
    }

    /// Number of electrodes that the channel is divided between, in all stages.
    pub fn count(&self) -> usize {
        if self.mesh.is_some() {
            return 1 + self.more.len();
        }
        let places = |stage: &StageParams| stage.parts.unwrap_or(self.parts) * stage.columns.unwrap_or(self.columns);
        if self.stage.is_empty() { self.parts * self.columns } else { self.stage.iter().map(places).sum() }
    }

    /// The parameters that hold for part `part` along the passage: of its own row only the division is left.
    #[must_use]
    pub fn of_part(&self, part: usize) -> Self {
        if self.mesh.is_some() {
            let own = part.checked_sub(1).and_then(|i| self.more.get(i)).map_or(EnterSide::Auto, |own| own.enter);
            return Self { enter: if own == EnterSide::Auto { self.enter } else { own }, ..self.clone() };
        }
        let own = self.part.get(part).copied().unwrap_or_default();
        let [low, high] = self.circumferential_reduction_deg;
        let divided =
            |row: &PartParams| PartParams { until: row.until, overlap_mm: row.overlap_mm, ..Default::default() };
        Self {
            enter: if own.enter == EnterSide::Auto { self.enter } else { own.enter },
            circumferential_reduction_deg: [
                own.low_reduction_deg.unwrap_or(low),
                own.high_reduction_deg.unwrap_or(high),
            ],
            radial_reduction_mm: own.radial_reduction_mm.unwrap_or(self.radial_reduction_mm),
            part: self.part.iter().map(divided).collect(),
            ..self.clone()
        }
    }

    /// Part and column of electrode number `number` in its [stage](Self::in_stage), counted along the passage, the columns of one
    /// part low to high; electrodes of one's own are parts.
    pub fn place_of(&self, number: usize) -> (usize, Option<Column>) {
        if self.mesh.is_some() {
            return (number, None);
        }
        let column = if number.is_multiple_of(self.columns) { Column::Low } else { Column::High };
        (number / self.columns, (self.columns > 1).then_some(column))
    }

    /// Divisions between the parts over a burned length of `length` (mm), from the first station: those given, and
    /// between them as many as are missing, so that these parts, of which neighbours have `shared` (mm), are equally long;
    /// thickness is balanced from there.
    pub(super) fn divisions(&self, length: f64, shared: f64) -> Vec<f64> {
        let given =
            |i: usize| if i == self.parts { Some(1.0) } else { self.part.get(i - 1).and_then(|part| part.until) };
        let (mut divisions, mut last) = (Vec::new(), (0, 0.0));
        for i in 1..=self.parts {
            if let Some(share) = given(i) {
                let ((from, start), end) = (last, share * length);
                // Parts reach over divisions, but not over the ends of the passage.
                let over = [from > 0, i < self.parts].map(|is_division| if is_division { 0.5 * shared } else { 0.0 });
                let apart = (end - start + over[0] + over[1] - shared) / (i - from) as f64;
                divisions.extend((1..i - from).map(|k| start - over[0] + k as f64 * apart + 0.5 * shared));
                divisions.push(end);
                last = (i, end);
            }
        }
        divisions.pop();
        divisions
    }

    /// Sets the side of entry of electrode number `number`: where there are several parts, of its own alone.
    pub fn enter_from(&mut self, number: usize, side: EnterSide) {
        let (stage, number) = self.in_stage(number);
        let of_stage = self.of_stage(stage);
        let (part, _) = of_stage.place_of(number);
        let own = self.stage.get_mut(stage).filter(|own| {
            !own.part.is_empty() || own.enter.is_some() || own.parts.is_some_and(|parts| parts != self.parts)
        });
        if let Some(own) = own {
            own.part = of_stage.part;
            if of_stage.parts == 1 {
                own.enter = Some(side);
                own.part.iter_mut().for_each(|row| row.enter = EnterSide::Auto);
            } else {
                own.part.resize(own.part.len().max(part + 1), PartParams::default());
                own.part[part].enter = side;
            }
        } else if let Some(own) = part.checked_sub(1).and_then(|i| self.more.get_mut(i)).filter(|_| self.mesh.is_some())
        {
            own.enter = side;
        } else if self.parts == 1 || self.mesh.is_some() {
            self.enter = side;
            self.part.iter_mut().for_each(|row| row.enter = EnterSide::Auto);
        } else {
            self.part.resize(self.part.len().max(part + 1), PartParams::default());
            self.part[part].enter = side;
        }
    }

    /// Divides part `part` along the passage in two of equal length that have what it has of its own; answers the new
    /// division, to a hundredth.
    pub fn divide(&mut self, part: usize) -> f64 {
        let divisions = self.divisions(1.0, 0.0);
        self.part.resize(self.parts, PartParams::default());
        for (row, division) in self.part.iter_mut().zip(&divisions) {
            row.until = Some(*division);
        }
        let from = if part == 0 { 0.0 } else { divisions[part - 1] };
        let share = (50.0 * (from + divisions.get(part).unwrap_or(&1.0))).round() / 100.0;
        self.part.insert(part, PartParams { until: Some(share), overlap_mm: None, ..self.part[part] });
        self.parts += 1;
        share
    }

    /// Overlap of part `part` with the next (mm).
    pub(super) fn overlap_after(&self, part: usize) -> f64 {
        self.part.get(part).and_then(|part| part.overlap_mm).unwrap_or(self.overlap_mm)
    }

    /// Circumferential reductions of the low and the high wall (rad).
    pub(super) fn turns(&self) -> [f64; 2] {
        self.circumferential_reduction_deg.map(f64::to_radians)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_of_single_parts_that_cannot_be_are_refused_with_their_key() {
        let of = |parts, part| {
            ElectrodeParams { parts, part, ..ElectrodeParams::default() }.validate().map_err(|e| e.to_string())
        };
        let until = |share| PartParams { until: Some(share), ..PartParams::default() };
        assert_eq!(of(3, vec![until(0.2), until(0.5)]), Ok(()));
        for (parts, rows, key) in [
            (1, vec![until(0.5), until(0.6)], "electrode.part is"),
            (3, vec![until(0.5), until(0.4)], "electrode.part[1].until"),
            (4, vec![until(0.995)], "electrode.part[0].until"),
            (2, vec![PartParams { overlap_mm: Some(-1.0), ..PartParams::default() }], "electrode.part[0].overlap_mm"),
        ] {
            let said = of(parts, rows).unwrap_err();
            assert!(said.contains(key), "{said}");
        }
    }

    #[test]
    fn electrodes_of_ones_own_are_as_many_as_their_meshes_each_from_its_side() {
        let more = [("b.stl", EnterSide::PlusX), ("c.stl", EnterSide::Auto)];
        let more = more.map(|(mesh, enter)| OwnMesh { mesh: mesh.into(), enter }).to_vec();
        let mut own = ElectrodeParams {
            mesh: Some("a.stl".into()),
            more,
            enter: EnterSide::MinusX,
            parts: 1,
            columns: 2,
            ..ElectrodeParams::default()
        };
        own.validate().unwrap();
        assert_eq!((own.count(), own.own_meshes().count()), (3, 3));
        assert_eq!([0, 1, 2].map(|number| own.place_of(number)), [(0, None), (1, None), (2, None)]);
        let sides = |own: &ElectrodeParams| [0, 1, 2].map(|part| own.of_part(part).enter);
        assert_eq!(sides(&own), [EnterSide::MinusX, EnterSide::PlusX, EnterSide::MinusX]);
        own.enter_from(2, EnterSide::Outward);
        assert_eq!(sides(&own), [EnterSide::MinusX, EnterSide::PlusX, EnterSide::Outward]);
        own.more[0].mesh = "".into();
        assert!(own.validate().unwrap_err().to_string().contains("more[0].mesh"));
        own.more[0].mesh = "b.stl".into();
        own.mesh = None;
        assert!(own.validate().unwrap_err().to_string().contains("electrode.mesh names the first one"));
        assert_eq!((own.count(), own.own_meshes().count()), (2, 0), "without the first they are none");
    }
}
