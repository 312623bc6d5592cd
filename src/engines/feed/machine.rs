//! The machine: which axes it has and how far and how fast they go.

use files::Invalid;
use serde::{Deserialize, Serialize};

use super::path::PathRow;
use super::pose::{Axis, Pose};
use wheel::electrode::EntrySide;

/// Axes of the machine.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[allow(clippy::upper_case_acronyms)]
pub enum AxisSet {
    /// Four axes.
    XYZC,
    /// Five axes: the blisk turns on A.
    #[default]
    XYZAC,
    /// Six axes: the electrode tilts about B too.
    XYZABC,
}

impl AxisSet {
    /// The axes in order.
    pub fn axes(self) -> &'static [Axis] {
        use Axis::{A, B, C, X, Y, Z};
        match self {
            Self::XYZC => &[X, Y, Z, C],
            Self::XYZAC => &[X, Y, Z, A, C],
            Self::XYZABC => &[X, Y, Z, A, B, C],
        }
    }

    /// The axes in order, without the one along which the electrode is withdrawn.
    pub fn free_axes(self, side: EntrySide) -> &'static [Axis] {
        use Axis::{A, B, C, X, Y};
        if Axis::of_withdrawal(side) == X {
            return &self.axes()[1..];
        }
        match self {
            Self::XYZC => &[X, Y, C],
            Self::XYZAC => &[X, Y, A, C],
            Self::XYZABC => &[X, Y, A, B, C],
        }
    }
}

/// Axis of W along which the head of a machine comes to the blisk.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum HeadAxis {
    /// Along the blisk's axis: the electrode hangs on an arm beside the blisk.
    #[default]
    X,
    /// Along the radius: a ram above the blisk carries the electrode.
    Z,
}

impl HeadAxis {
    /// The axis of poses.
    pub fn axis(self) -> Axis {
        match self {
            Self::X => Axis::X,
            Self::Z => Axis::Z,
        }
    }
}

/// Face of the blisk, in W, that the table of a machine holds.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum MountedFace {
    /// The face at the least x.
    #[default]
    #[serde(rename = "-x")]
    MinusX,
    /// The face at the greatest x.
    #[serde(rename = "+x")]
    PlusX,
}

impl MountedFace {
    fn is_least_x(&self) -> bool {
        *self == Self::MinusX
    }
}

/// Part of a machine that C turns.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum TurnedByC {
    /// The electrode, on the head.
    #[default]
    Electrode,
    /// The table that carries A, as on a tilting table.
    Table,
}

impl TurnedByC {
    fn is_electrode(&self) -> bool {
        *self == Self::Electrode
    }
}

/// How the directions of a machine lie in W, and where its C axis is if that turns the table.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct Mounting {
    /// Whether the machine is turned by half a turn about Z against W.
    pub is_turned: bool,
    /// Place (x, y) of the C axis under A, in directions of the machine, from the blisk's axis at the face that the table
    /// holds (mm); none where C turns the electrode.
    pub table_c: Option<[f64; 2]>,
}

impl std::fmt::Display for Mounting {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let turned = if self.is_turned { "turned" } else { "not turned" };
        write!(f, "a machine that is {turned} by half a turn about Z, whose C turns ")?;
        match self.table_c {
            None => write!(f, "the electrode"),
            Some([x, y]) => write!(f, "the table about x = {x} mm, y = {y} mm"),
        }
    }
}

/// Travel of the axes about the final pose, as `[least, greatest]`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct MachineParams {
    /// Whose bodies are simulated: a built-in machine or the path of a machine file; empty for no bodies.
    pub name: String,
    /// Clearance that bodies keep from each other and from the blisk (mm).
    pub body_clearance_mm: f64,
    /// Axis along which the head comes, of a machine with bodies.
    pub head_along: HeadAxis,
    /// Face of the blisk that the table holds, on a machine with bodies whose head comes along Z. Where it comes along X
    /// the table holds the face away from the side of entry.
    pub mounted_face: MountedFace,
    /// Part that C turns, of a machine with bodies.
    pub c_turns: TurnedByC,
    /// Place (x, y) of the C axis in the final pose where C turns the table, in directions of the machine, counted from the
    /// blisk's axis at the face that the table holds (mm).
    pub c_axis_mm: [f64; 2],
    /// Axes of the machine.
    pub axes: AxisSet,
    /// Travel along X (mm).
    pub travel_x_mm: [f64; 2],
    /// Travel along Y (mm).
    pub travel_y_mm: [f64; 2],
    /// Travel along Z (mm).
    pub travel_z_mm: [f64; 2],
    /// Travel about A (deg).
    pub travel_a_deg: [f64; 2],
    /// Travel about B (deg).
    pub travel_b_deg: [f64; 2],
    /// Travel about C (deg).
    pub travel_c_deg: [f64; 2],
    /// Greatest speed of X, Y, Z (mm/min).
    pub speed_mm_min: f64,
    /// Greatest speed of A, B, C (deg/min).
    pub speed_deg_min: f64,
}

impl Default for MachineParams {
    fn default() -> Self {
        Self {
            name: String::new(),
            body_clearance_mm: 1.0,
            head_along: HeadAxis::default(),
            mounted_face: MountedFace::default(),
            c_turns: TurnedByC::default(),
            c_axis_mm: [0.0; 2],
            axes: AxisSet::default(),
            travel_x_mm: [-250.0, 250.0],
            travel_y_mm: [-150.0, 150.0],
            travel_z_mm: [-150.0, 150.0],
            travel_a_deg: [-360.0, 360.0],
            travel_b_deg: [-45.0, 45.0],
            travel_c_deg: [-360.0, 360.0],
            speed_mm_min: 1000.0,
            speed_deg_min: 1800.0,
        }
    }
}

/// The part of [`MachineParams`] that a search depends on: all but the bodies.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SearchedMachine {
    axes: AxisSet,
    travel_x_mm: [f64; 2],
    travel_y_mm: [f64; 2],
    travel_z_mm: [f64; 2],
    travel_a_deg: [f64; 2],
    travel_b_deg: [f64; 2],
    travel_c_deg: [f64; 2],
    speed_mm_min: f64,
    speed_deg_min: f64,
    #[serde(skip_serializing_if = "MountedFace::is_least_x")]
    mounted_face: MountedFace,
    #[serde(skip_serializing_if = "TurnedByC::is_electrode")]
    c_turns: TurnedByC,
}

/// Travel of every axis about the final pose, `[least, greatest]` (mm or rad).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TravelLimits([[f64; 2]; 6]);

/// A row that is beyond the travel of an axis.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct BeyondTravel {
    /// The axis.
    pub axis: Axis,
    /// Index of the row in feed order.
    pub row: usize,
    /// Axis value needed (mm or rad).
    pub value: f64,
    /// End of its travel (mm or rad).
    pub limit: f64,
}

impl BeyondTravel {
    /// Value, limit and their unit, as files have them: mm or degrees.
    pub fn in_file_units(&self) -> (f64, f64, &'static str) {
        if self.axis.is_rotary() {
            (self.value.to_degrees(), self.limit.to_degrees(), "deg")
        } else {
            (self.value, self.limit, "mm")
        }
    }
}

impl std::fmt::Display for BeyondTravel {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let (value, limit, unit) = self.in_file_units();
        let letter = self.axis.letter();
        write!(f, "axis {letter} goes to {value:.5} {unit} at row {}, beyond its travel to {limit} {unit}", self.row)
    }
}

impl TravelLimits {
    /// Tolerance for rounding (mm or rad).
    const ROUNDING: f64 = 1e-9;

    /// Axes that go as far as they like.
    pub const UNLIMITED: Self = Self([[f64::NEG_INFINITY, f64::INFINITY]; 6]);

    /// Limits with `axis` kept within `[least, greatest]` (mm or rad).
    pub fn with(mut self, axis: Axis, travel: [f64; 2]) -> Self {
        self.0[axis as usize] = travel;
        self
    }

    /// Travel of `axis` (mm or rad).
    pub fn of(&self, axis: Axis) -> [f64; 2] {
        self.0[axis as usize]
    }

    /// The first axis that is beyond its travel at `pose`, with where that ends.
    pub fn beyond(&self, pose: &Pose) -> Option<(Axis, f64)> {
        Axis::ALL.into_iter().find_map(|axis| {
            let ([least, greatest], value) = (self.of(axis), pose.get(axis));
            let within = (least - Self::ROUNDING..=greatest + Self::ROUNDING).contains(&value);
            (!within).then_some((axis, if value < least { least } else { greatest }))
        })
    }

    /// The first of `rows` that is beyond travel. Axes are linear between rows, so that what holds at the rows holds
    /// between them.
    pub fn first_beyond(&self, rows: &[PathRow]) -> Option<BeyondTravel> {
        rows.iter().enumerate().find_map(|(row, r)| {
            self.beyond(&r.pose).map(|(axis, limit)| BeyondTravel { axis, row, value: r.pose.get(axis), limit })
        })
    }
}

impl MachineParams {
    /// Whether every travel holds the final pose and every speed is positive.
    pub fn validate(&self) -> Result<(), Invalid> {
        const KEYS: [&str; 6] = ["x_mm", "y_mm", "z_mm", "a_deg", "b_deg", "c_deg"];
        for (axis, [least, greatest]) in KEYS.into_iter().zip(self.travels()) {
            if !(least <= 0.0 && greatest >= 0.0 && least.is_finite() && greatest.is_finite()) {
                let remedy = "must be finite and include 0, the final pose; give [least, greatest]";
                return Err(Invalid::new(format!("machine.travel_{axis}"), format!("{least} to {greatest}"), remedy));
            }
        }
        Invalid::unless_within("machine.body_clearance_mm", self.body_clearance_mm, [0.01, 100.0], "mm")?;
        for place in self.c_axis_mm {
            Invalid::unless_within("machine.c_axis_mm", place, [-1e4, 1e4], "mm")?;
        }
        if self.c_turns == TurnedByC::Table && !self.has_bodies() {
            let remedy = "needs a machine whose motion is simulated; name its file in machine.name";
            return Err(Invalid::new("machine.c_turns", "table", remedy));
        }
        for (key, speed) in [("machine.speed_mm_min", self.speed_mm_min), ("machine.speed_deg_min", self.speed_deg_min)]
        {
            if !speed.is_finite() || speed <= 0.0 {
                return Err(Invalid::new(key, speed, "must be finite and greater than 0"));
            }
        }
        Ok(())
    }

    /// Whether the machine has bodies that a motion has to be simulated with.
    pub fn has_bodies(&self) -> bool {
        !self.name.is_empty()
    }

    /// Whether its bodies, if it has any, are those of a machine whose head comes from `side`.
    pub fn comes_from(&self, side: EntrySide) -> bool {
        !self.has_bodies() || (side != EntrySide::Inward && Axis::of_withdrawal(side) == self.head_along.axis())
    }

    /// The part of the parameters that a search depends on.
    pub fn searched(&self) -> SearchedMachine {
        let Self { travel_x_mm, travel_y_mm, travel_z_mm, travel_a_deg, travel_b_deg, travel_c_deg, .. } = *self;
        let Self { axes, speed_mm_min, speed_deg_min, .. } = *self;
        SearchedMachine {
            axes,
            travel_x_mm,
            travel_y_mm,
            travel_z_mm,
            travel_a_deg,
            travel_b_deg,
            travel_c_deg,
            speed_mm_min,
            speed_deg_min,
            mounted_face: self.mounted_face,
            c_turns: self.c_turns,
        }
    }

    fn travels(&self) -> [[f64; 2]; 6] {
        let Self { travel_x_mm, travel_y_mm, travel_z_mm, travel_a_deg, travel_b_deg, travel_c_deg, .. } = *self;
        [travel_x_mm, travel_y_mm, travel_z_mm, travel_a_deg, travel_b_deg, travel_c_deg]
    }

    /// Axes that count the other way round on a machine that is turned by half a turn about Z against W.
    pub const TURNED: [Axis; 4] = [Axis::X, Axis::Y, Axis::A, Axis::B];

    /// Whether a machine with bodies is turned by half a turn about Z against W for an electrode that enters from `side`:
    /// its own +x points from the table into the blisk.
    pub fn is_turned(&self, side: EntrySide) -> bool {
        let holds_greater_x = match side {
            EntrySide::MinusX => true,
            EntrySide::PlusX => false,
            EntrySide::Outward | EntrySide::Inward => self.mounted_face == MountedFace::PlusX,
        };
        self.has_bodies() && holds_greater_x
    }

    /// How the machine stands about an electrode that enters from `side`.
    pub fn mounting(&self, side: EntrySide) -> Mounting {
        let table_c = (self.c_turns == TurnedByC::Table).then_some(self.c_axis_mm);
        Mounting { is_turned: self.is_turned(side), table_c }
    }

    /// Machine with its travels in the directions of W, for an electrode that enters from `side`.
    pub fn seen_from_w(&self, side: EntrySide) -> Self {
        let mut seen = self.clone();
        if self.is_turned(side) {
            for travel in [&mut seen.travel_x_mm, &mut seen.travel_y_mm, &mut seen.travel_a_deg, &mut seen.travel_b_deg]
            {
                *travel = [0.0 - travel[1], 0.0 - travel[0]];
            }
        }
        seen
    }

    /// Travel of an axis (mm or rad); nothing for an axis the machine does not have.
    pub fn travel(&self, axis: Axis) -> [f64; 2] {
        if !self.axes.axes().contains(&axis) {
            return [0.0; 2];
        }
        let travel = self.travels()[axis as usize];
        if axis.is_rotary() { travel.map(f64::to_radians) } else { travel }
    }

    /// Travel of all axes; that of an axis which the machine does not have is nothing.
    pub fn limits(&self) -> TravelLimits {
        TravelLimits(Axis::ALL.map(|axis| self.travel(axis)))
    }

    /// Limits of poses: the travel of all axes, but for X and Y of a machine whose C turns the table, where they go other
    /// ways than the pose does; the simulation judges these.
    pub fn pose_limits(&self) -> TravelLimits {
        match self.c_turns {
            TurnedByC::Electrode => self.limits(),
            TurnedByC::Table => {
                let anywhere = [f64::NEG_INFINITY, f64::INFINITY];
                self.limits().with(Axis::X, anywhere).with(Axis::Y, anywhere)
            }
        }
    }

    /// Shortest time (min) in which all axes can go linearly from one pose to the other within their speeds, and the
    /// axis that needs it.
    pub fn least_minutes(&self, from: &Pose, to: &Pose) -> (f64, Axis) {
        let minutes = |axis: Axis| {
            let way = (to.get(axis) - from.get(axis)).abs();
            if axis.is_rotary() { way.to_degrees() / self.speed_deg_min } else { way / self.speed_mm_min }
        };
        let slowest = Axis::ALL.map(|axis| (minutes(axis), axis));
        slowest.into_iter().fold((0.0, Axis::X), |most, next| if next.0 > most.0 { next } else { most })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pose_beyond_travel_names_its_axis() {
        let machine = MachineParams { travel_c_deg: [-10.0, 90.0], ..Default::default() };
        let beyond = |pose: Pose| machine.limits().beyond(&pose);
        assert_eq!(beyond(Pose { c: -0.2, ..Pose::FINAL }), Some((Axis::C, (-10f64).to_radians())));
        assert_eq!(beyond(Pose { b: 0.01, ..Pose::FINAL }), Some((Axis::B, 0.0)), "five axes have no B");
        assert_eq!(beyond(Pose { x: -40.0, a: 1.0, ..Pose::FINAL }), None);
        assert_eq!(beyond(Pose { x: -250.0, ..Pose::FINAL }), None, "the end of travel can be reached");
        assert!(beyond(Pose { x: f64::NAN, ..Pose::FINAL }).is_some());
    }

    #[test]
    fn a_machine_with_bodies_is_turned_for_an_electrode_from_the_other_side() {
        let machine = MachineParams { travel_x_mm: [-20.0, 250.0], travel_z_mm: [-5.0, 90.0], ..Default::default() };
        assert_eq!(machine.seen_from_w(EntrySide::MinusX), machine, "without bodies travels are those of W");
        let machine = MachineParams { name: "xyzac".to_owned(), ..machine };
        assert_eq!(machine.seen_from_w(EntrySide::PlusX), machine);
        let seen = machine.seen_from_w(EntrySide::MinusX);
        assert_eq!((seen.travel_x_mm, seen.travel_z_mm), ([-250.0, 20.0], [-5.0, 90.0]));
    }

    #[test]
    fn a_ram_along_z_serves_the_rim_alone_and_is_turned_with_the_face_that_is_held() {
        let of = |head_along| MachineParams { name: "m".to_owned(), head_along, ..Default::default() };
        for (head, sides) in [(HeadAxis::X, [true, true, false, false]), (HeadAxis::Z, [false, false, true, false])] {
            assert_eq!(EntrySide::ALL.map(|side| of(head).comes_from(side)), sides);
        }
        assert!(EntrySide::ALL.iter().all(|side| MachineParams::default().comes_from(*side)), "no bodies, no head");
        let ram = MachineParams { travel_y_mm: [-20.0, 50.0], ..of(HeadAxis::Z) };
        assert_eq!(ram.seen_from_w(EntrySide::Outward), ram);
        let turned = MachineParams { mounted_face: MountedFace::PlusX, ..ram };
        assert_eq!(turned.seen_from_w(EntrySide::Outward).travel_y_mm, [-50.0, 20.0]);
    }

    #[test]
    fn the_slowest_axis_sets_the_time() {
        let machine = MachineParams { speed_mm_min: 100.0, speed_deg_min: 30.0, ..Default::default() };
        let to = Pose { x: -2.0, y: 1.0, c: 0.3f64.to_radians(), ..Pose::FINAL };
        let (minutes, axis) = machine.least_minutes(&Pose::FINAL, &to);
        assert!((minutes - 0.02).abs() < 1e-15 && axis == Axis::X);
        let (minutes, axis) = machine.least_minutes(&to, &Pose { a: (-1.5f64).to_radians(), ..to });
        assert!((minutes - 0.05).abs() < 1e-15 && axis == Axis::A);
        assert_eq!(machine.least_minutes(&to, &to).0, 0.0);
    }

    #[test]
    fn travel_that_excludes_the_final_pose_is_refused() {
        let machine = MachineParams { travel_z_mm: [1.0, 50.0], ..Default::default() };
        assert!(machine.validate().unwrap_err().to_string().contains("z_mm"));
        assert!(MachineParams { speed_deg_min: 0.0, ..Default::default() }.validate().is_err());
    }
}
