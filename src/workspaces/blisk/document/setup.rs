//! How a wheel and its electrodes are set up on the machine.

use files::{Invalid, Validate};
use glam::{DVec2, DVec3};
use nc::setup_sheet::{Datum, SetUp, TableCheck};
use serde::{Deserialize, Serialize};

/// `[setup]`
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SetUpSection {
    /// Table of the places of the electrodes on their holders, and of their wear; none where they are planned as nominal.
    pub presets: Option<String>,
    /// Balls and corners that the machine touches.
    pub datum: Vec<DatumRow>,
    /// Step that set-up values are rounded to (mm); none leaves them as they are.
    pub round_mm: Option<f64>,
    /// Y and Z of the axis of A in W (mm): the balls are told at both angles of A; none for no check.
    pub a_axis_mm: Option<[f64; 2]>,
    /// The two angles of A (degrees), as in programs.
    pub a_deg: [f64; 2],
}

/// A ball or a corner that the machine touches, in the coordinates of the wheel's file.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DatumRow {
    /// X of the ball's centre or of the corner (mm).
    pub x_mm: f64,
    /// Y of that (mm).
    pub y_mm: f64,
    /// Z of that (mm).
    pub z_mm: f64,
    /// Radius of a ball (mm); none of a corner.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub radius_mm: Option<f64>,
}

impl Default for SetUpSection {
    fn default() -> Self {
        Self { presets: None, datum: Vec::new(), round_mm: None, a_axis_mm: None, a_deg: [0.0, 30.0] }
    }
}

impl SetUpSection {
    /// Settings of the set-up sheet; none without a datum.
    pub fn set_up(&self) -> Option<SetUp> {
        let datum = |row: &DatumRow| Datum { place: DVec3::new(row.x_mm, row.y_mm, row.z_mm), radius: row.radius_mm };
        let check = self
            .a_axis_mm
            .map(|axis| TableCheck { a_axis: DVec2::from(axis), angles: self.a_deg.map(f64::to_radians) });
        let datums: Vec<Datum> = self.datum.iter().map(datum).collect();
        (!datums.is_empty()).then_some(SetUp { datums, round: self.round_mm, check })
    }
}

impl Validate for SetUpSection {
    fn validate(&self) -> Result<(), Invalid> {
        if self.a_axis_mm.is_some() && self.datum.iter().all(|row| row.radius_mm.is_none()) {
            return Err(Invalid::of(
                "a_axis_mm",
                "a table is checked with a ball, and none is given; give a datum a radius",
            ));
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_is_checked_with_a_ball_and_a_sheet_needs_a_datum() {
        let none = SetUpSection::default();
        assert_eq!(none.set_up(), None);
        let row = |radius_mm| DatumRow { x_mm: 1.0, y_mm: 2.0, z_mm: 3.0, radius_mm };
        let checked = |radius| SetUpSection { datum: vec![row(radius)], a_axis_mm: Some([0.0, 5.0]), ..none.clone() };
        assert_eq!(checked(None).validate().unwrap_err().key, "a_axis_mm");
        let of = checked(Some(10.0));
        assert!(of.validate().is_ok());
        let SetUp { datums, check, .. } = of.set_up().unwrap();
        assert_eq!(datums, [Datum { place: DVec3::new(1.0, 2.0, 3.0), radius: Some(10.0) }]);
        assert_eq!(check.unwrap().angles, [0.0, 30.0_f64.to_radians()]);
    }
}
