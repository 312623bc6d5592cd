//! The machine: which axes it has and how far and how fast they go.

use serde::{Deserialize, Serialize};

use super::pose::{Axis, Pose};

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
}

/// Travel of the axes about the final pose, as `[least, greatest]`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct MachineParams {
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

/// What is wrong with machine parameters, or with a path on that machine.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum MachineError {
    /// A travel that does not hold the final pose.
    #[error(
        "[machine] travel_{axis}: {least} to {greatest} must be finite and include 0, the final pose; give [least, greatest]"
    )]
    Travel {
        /// Axis and unit, as in the key.
        axis: &'static str,
        /// Lower end.
        least: f64,
        /// Upper end.
        greatest: f64,
    },
    /// A speed that is not positive.
    #[error("[machine] {0} must be finite and greater than 0")]
    Speed(&'static str),
}

impl MachineParams {
    /// Whether every travel holds the final pose and every speed is positive.
    pub fn validate(&self) -> Result<(), MachineError> {
        const KEYS: [&str; 6] = ["x_mm", "y_mm", "z_mm", "a_deg", "b_deg", "c_deg"];
        for (axis, [least, greatest]) in KEYS.into_iter().zip(self.travels()) {
            if !(least <= 0.0 && greatest >= 0.0 && least.is_finite() && greatest.is_finite()) {
                return Err(MachineError::Travel { axis, least, greatest });
            }
        }
        for (key, speed) in [("speed_mm_min", self.speed_mm_min), ("speed_deg_min", self.speed_deg_min)] {
            if !speed.is_finite() || speed <= 0.0 {
                return Err(MachineError::Speed(key));
            }
        }
        Ok(())
    }

    fn travels(&self) -> [[f64; 2]; 6] {
        let Self { travel_x_mm, travel_y_mm, travel_z_mm, travel_a_deg, travel_b_deg, travel_c_deg, .. } = *self;
        [travel_x_mm, travel_y_mm, travel_z_mm, travel_a_deg, travel_b_deg, travel_c_deg]
    }

    /// Travel of an axis (mm or rad); nothing for an axis the machine does not have.
    pub fn travel(&self, axis: Axis) -> [f64; 2] {
        if !self.axes.axes().contains(&axis) {
            return [0.0; 2];
        }
        let travel = self.travels()[axis as usize];
        if axis.is_rotary() { travel.map(f64::to_radians) } else { travel }
    }

    /// The first axis that is beyond its travel at `pose`, if any.
    pub fn beyond_travel(&self, pose: &Pose) -> Option<Axis> {
        Axis::ALL.into_iter().find(|&axis| {
            let [least, greatest] = self.travel(axis);
            !(least - 1e-9..=greatest + 1e-9).contains(&pose.get(axis))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pose_beyond_travel_names_its_axis() {
        let machine = MachineParams { travel_c_deg: [-10.0, 90.0], ..Default::default() };
        assert_eq!(machine.beyond_travel(&Pose { c: -0.2, ..Pose::FINAL }), Some(Axis::C));
        assert_eq!(machine.beyond_travel(&Pose { b: 0.01, ..Pose::FINAL }), Some(Axis::B), "five axes have no B");
        assert_eq!(machine.beyond_travel(&Pose { x: -40.0, a: 1.0, ..Pose::FINAL }), None);
    }

    #[test]
    fn travel_that_excludes_the_final_pose_is_refused() {
        let machine = MachineParams { travel_z_mm: [1.0, 50.0], ..Default::default() };
        assert!(machine.validate().unwrap_err().to_string().contains("z_mm"));
        assert!(MachineParams { speed_deg_min: 0.0, ..Default::default() }.validate().is_err());
    }
}
