//! Five-axis milling machines as data.
//!
//! A machine has three straight axes at right angles and two rotary axes, each carried by the head or by the table:
//! head-head, head-table and table-table. Only the motion of the head relative to the table counts here, so it does not
//! matter which slide of X, Y, Z is under which part. All vectors are in the machine's directions with every rotary
//! axis at zero.

use glam::{DMat3, DVec3};
use serde::{Deserialize, Serialize};

use super::kinematics::Kinematics;

/// Least sine of the angle between the two rotary axes, and between the spindle and the axis next to it.
pub(super) const LEAST_SINE: f64 = 0.05;
/// Turns that an axis without limits may take each way.
const MOST_TURNS: f64 = 3.0;
/// Greatest coordinate of anything (mm).
const LARGEST_MM: f64 = 1e5;

/// Reason why a machine or a position on it is not possible.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum MachineError {
    /// A value of the machine's data.
    #[error("machine {machine}: {key} is {value}; {remedy}")]
    Value {
        /// The machine's name.
        machine: String,
        /// The key.
        key: String,
        /// Value found.
        value: String,
        /// Remedy.
        remedy: String,
    },
    /// A tool direction that no position of the rotary axes gives.
    #[error(
        "the rotary axes cannot bring the tool to the direction {}: it is {by_deg:.3} degrees beyond their \
         reach; clamp the workpiece otherwise or take another machine", direction_words(*direction)
    )]
    Unreachable {
        /// In the workpiece's frame.
        direction: DVec3,
        /// How far beyond the reach (degrees).
        by_deg: f64,
    },
}

/// A direction as it is said: four decimals, and no zero with a sign.
fn direction_words(direction: DVec3) -> String {
    let [x, y, z] = direction.to_array().map(|part| (1e4 * part).round() / 1e4 + 0.0);
    format!("({x:.4}, {y:.4}, {z:.4})")
}

/// The letter of a rotary axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum RotaryLetter {
    /// Rotation about X.
    A,
    /// Rotation about Y.
    B,
    /// Rotation about Z.
    C,
}

impl RotaryLetter {
    /// The letter itself.
    pub fn letter(self) -> char {
        match self {
            Self::A => 'A',
            Self::B => 'B',
            Self::C => 'C',
        }
    }
}

/// Body that a rotary axis carries.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum CarriedBy {
    /// The tool.
    Head,
    /// The workpiece.
    Table,
}

/// One rotary axis.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RotaryAxis {
    /// Letter.
    pub letter: RotaryLetter,
    /// Whether it turns the tool or the workpiece.
    pub carried_by: CarriedBy,
    /// Direction about which the carried body turns right-handed when the axis value rises. A table that is counted as
    /// the tool moves relative to the workpiece (ISO 841) turns the other way round: give the opposite direction.
    pub direction: DVec3,
    /// A point that it goes through, with every rotary axis at zero (mm): of a table in machine coordinates, of a head
    /// from the spindle nose (the pivot).
    pub point_mm: DVec3,
    /// Least and greatest value (degrees), within 3 turns each way, which an axis without limits has.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub limits_deg: Option<[f64; 2]>,
    /// Greatest speed (degrees/min).
    pub speed_deg_min: f64,
}

impl RotaryAxis {
    /// Least and greatest value (rad).
    pub fn limits(&self) -> [f64; 2] {
        let turns = 360.0 * MOST_TURNS;
        self.limits_deg.unwrap_or([-turns, turns]).map(f64::to_radians)
    }
}

/// The straight axes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LinearAxes {
    /// Least and greatest X of the spindle nose (mm, machine coordinates).
    pub x_mm: [f64; 2],
    /// Travel of Y (mm).
    pub y_mm: [f64; 2],
    /// Travel of Z (mm).
    pub z_mm: [f64; 2],
    /// Greatest speeds of X, Y and Z (mm/min).
    pub speed_mm_min: [f64; 3],
}

/// Position of the workpiece's frame on the table, with every rotary axis at zero.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Workpiece {
    /// Zero in machine coordinates (mm).
    pub zero_mm: DVec3,
    /// Machine direction of its X; what of it lies along `z_axis` is taken off.
    pub x_axis: DVec3,
    /// Machine direction of its Z.
    pub z_axis: DVec3,
}

impl Default for Workpiece {
    fn default() -> Self {
        Self { zero_mm: DVec3::ZERO, x_axis: DVec3::X, z_axis: DVec3::Z }
    }
}

/// A five-axis milling machine with its frames, axes and limits.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MillingMachine {
    /// Name: letters, digits, `-` and `_`.
    pub name: String,
    /// Short description.
    #[serde(default)]
    pub title: String,
    /// Direction from the tool's tip to the spindle with every rotary axis at zero.
    #[serde(default = "upwards")]
    pub spindle: DVec3,
    /// From the spindle nose to the tool's tip (mm). The tip is the middle of the cutter's bottom.
    pub gauge_length_mm: f64,
    /// X, Y and Z.
    pub linear: LinearAxes,
    /// The two rotary axes. Of two in one carrier the one next to the bed comes first.
    pub rotary: Vec<RotaryAxis>,
    /// Position of the workpiece.
    #[serde(default)]
    pub workpiece: Workpiece,
}

fn upwards() -> DVec3 {
    DVec3::Z
}

impl MillingMachine {
    /// Checks everything and makes the machine ready for computing.
    ///
    /// # Errors
    /// [`MachineError::Value`] naming the key.
    pub fn kinematics(&self) -> Result<Kinematics, MachineError> {
        self.check_name()?;
        self.check_linear()?;
        let rotary = self.check_rotary()?;
        let (spindle, mount) = (self.unit("spindle", self.spindle)?, self.mount()?);
        let kinematics = Kinematics::new(self, rotary, spindle, mount);
        kinematics.check()?;
        Ok(kinematics)
    }

    pub(crate) fn bad(&self, key: impl Into<String>, value: impl std::fmt::Display, remedy: &str) -> MachineError {
        let (machine, key) = (self.name.clone(), key.into());
        MachineError::Value { machine, key, value: value.to_string(), remedy: remedy.to_owned() }
    }

    fn check_name(&self) -> Result<(), MachineError> {
        let plain = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '_';
        if self.name.is_empty() || self.name.len() > 64 || !self.name.chars().all(plain) {
            return Err(self.bad("name", format!("{:?}", self.name), "give letters, digits, - and _ only"));
        }
        if !(0.0..=LARGEST_MM).contains(&self.gauge_length_mm) {
            let remedy = "give the length from the spindle nose to the tip, 0 to 100000 mm";
            return Err(self.bad("gauge_length_mm", format!("{} mm", self.gauge_length_mm), remedy));
        }
        Ok(())
    }

    fn check_linear(&self) -> Result<(), MachineError> {
        let LinearAxes { x_mm, y_mm, z_mm, speed_mm_min } = &self.linear;
        for (key, range) in [("linear.x_mm", x_mm), ("linear.y_mm", y_mm), ("linear.z_mm", z_mm)] {
            // Not a comparison the other way round: a NaN must fail.
            if !(range[0] < range[1] && range.iter().all(|v| v.abs() <= LARGEST_MM)) {
                return Err(self.bad(key, format!("{range:?}"), "give the least value and then the greatest, in mm"));
            }
        }
        if let Some(speed) = speed_mm_min.iter().find(|v| !(0.001..=1e7).contains(*v)) {
            return Err(self.bad("linear.speed_mm_min", speed, "give 0.001 to 10000000 mm/min for each of X, Y, Z"));
        }
        Ok(())
    }

    /// The directions of the two rotary axes, unit.
    fn check_rotary(&self) -> Result<[DVec3; 2], MachineError> {
        let [first, second] = &self.rotary[..] else {
            return Err(self.bad("rotary", format!("a list of {}", self.rotary.len()), "give two rotary axes"));
        };
        if first.letter == second.letter {
            return Err(self.bad("rotary[1].letter", first.letter.letter(), "give each axis a letter of its own"));
        }
        for (i, axis) in [first, second].into_iter().enumerate() {
            let key = |key| format!("rotary[{i}].{key}");
            let [low, high] = axis.limits_deg.unwrap_or([-1.0, 1.0]);
            let most = 360.0 * MOST_TURNS;
            if !(low < high && low >= -most && high <= most) {
                let remedy = "give the least value and then the greatest, within 3 turns each way, or leave it out";
                return Err(self.bad(key("limits_deg"), format!("[{low}, {high}]"), remedy));
            }
            if !(0.001..=1e7).contains(&axis.speed_deg_min) {
                return Err(self.bad(key("speed_deg_min"), axis.speed_deg_min, "give 0.001 to 10000000 degrees/min"));
            }
            self.check_point(&key("point_mm"), axis.point_mm)?;
        }
        Ok([self.unit("rotary[0].direction", first.direction)?, self.unit("rotary[1].direction", second.direction)?])
    }

    fn check_point(&self, key: &str, point: DVec3) -> Result<(), MachineError> {
        let is_near = point.is_finite() && point.abs().max_element() <= LARGEST_MM;
        if is_near { Ok(()) } else { Err(self.bad(key, point, "give three lengths within 100000 mm")) }
    }

    fn unit(&self, key: &str, v: DVec3) -> Result<DVec3, MachineError> {
        let is_direction = v.is_finite() && (1e-6..1e6).contains(&v.length());
        if is_direction { Ok(v.normalize()) } else { Err(self.bad(key, v, "give a direction, such as [0, 0, 1]")) }
    }

    /// Turns directions of the workpiece's frame into the machine's.
    fn mount(&self) -> Result<DMat3, MachineError> {
        let Workpiece { zero_mm, x_axis, z_axis } = self.workpiece;
        self.check_point("workpiece.zero_mm", zero_mm)?;
        let (z, x) = (self.unit("workpiece.z_axis", z_axis)?, self.unit("workpiece.x_axis", x_axis)?);
        let across = x - z * x.dot(z);
        if across.length() < LEAST_SINE {
            return Err(self.bad("workpiece.x_axis", x_axis, "it lies along z_axis; give a direction across it"));
        }
        let x = across.normalize();
        Ok(DMat3::from_cols(x, z.cross(x), z))
    }
}
