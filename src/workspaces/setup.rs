//! How a workpiece and its electrodes are set up on the machine: the settings of the set-up sheet, as a project of any kind of
//! workpiece has them, and their fields.

use files::{Field, Invalid, Validate};
use glam::{DVec2, DVec3};
use nc::setup_sheet::{Datum, SetUp, TableCheck};
use serde::{Deserialize, Serialize};

/// Name of the set-up sheet in the folder of an export.
pub const SETUP_SHEET_FILE: &str = "setup_sheet.txt";

/// Settings of the set-up sheet (`[setup]`).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SetUpSheet {
    /// Balls and corners that the machine touches.
    pub datum: Vec<DatumRow>,
    /// Step that set-up values are rounded to (mm); none leaves them as they are.
    pub round_mm: Option<f64>,
    /// Y and Z of the axis of A in the axes of the job (mm): the balls are told at both angles of A; none for no check.
    pub a_axis_mm: Option<[f64; 2]>,
    /// The two angles of A (degrees), as in programs.
    pub a_deg: [f64; 2],
}

/// A ball or a corner that the machine touches, in the coordinates of the workpiece's file.
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

impl Default for SetUpSheet {
    fn default() -> Self {
        Self { datum: Vec::new(), round_mm: None, a_axis_mm: None, a_deg: [0.0, 30.0] }
    }
}

impl SetUpSheet {
    /// Settings of the set-up sheet; none without a datum.
    pub fn set_up(&self) -> Option<SetUp> {
        let datum = |row: &DatumRow| Datum { place: DVec3::new(row.x_mm, row.y_mm, row.z_mm), radius: row.radius_mm };
        let check = self
            .a_axis_mm
            .map(|axis| TableCheck { a_axis: DVec2::from(axis), angles: self.a_deg.map(f64::to_radians) });
        let datums: Vec<Datum> = self.datum.iter().map(datum).collect();
        (!datums.is_empty()).then_some(SetUp { datums, round: self.round_mm, check })
    }

    /// The settings without what is said of one workpiece: its datums, and the axis of A in the axes of its job.
    pub fn of_any_part(&self) -> Self {
        Self { datum: Vec::new(), a_axis_mm: None, ..self.clone() }
    }
}

impl Validate for SetUpSheet {
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

/// Fields of a project's [`SetUpSheet`] under the key `setup`.
pub const SETUP_SHEET_FIELDS: &[Field] = &[
    Field::rows(
        "setup.datum",
        "Datums",
        &[
            Field::number("x_mm", "X", "mm", -1e5, 1e5).decimals(3).help("X of a ball's centre, or of a corner."),
            Field::number("y_mm", "Y", "mm", -1e5, 1e5).decimals(3).help("Its Y."),
            Field::number("z_mm", "Z", "mm", -1e5, 1e5).decimals(3).help("Its Z."),
            Field::number("radius_mm", "Ball R", "mm", 1e-3, 1000.0)
                .decimals(3)
                .or_nothing(10.0)
                .help("Radius of a ball; none of a corner."),
        ],
        "{ x_mm = 0.0, y_mm = 0.0, z_mm = 0.0, radius_mm = 10.0 }",
    )
    .help("Balls and corners that the machine touches, in the coordinates of the workpiece's file."),
    Field::number("setup.round_mm", "Round to", "mm", 1e-4, 10.0)
        .decimals(4)
        .or_nothing(0.001)
        .help("Step that the set-up values are rounded to."),
    Field::numbers("setup.a_axis_mm", "Axis of A", "mm", -1e5, 1e5).count(2).optional().help(
        "Y and Z of the axis of A in the axes of the job, with a comma between: what the balls must read at both angles is \
         told.",
    ),
    Field::numbers("setup.a_deg", "Angles of A", "deg", -360.0, 360.0)
        .count(2)
        .help("The two angles of A for that, as in the programs."),
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_is_checked_with_a_ball_and_a_sheet_needs_a_datum() {
        let none = SetUpSheet::default();
        assert_eq!(none.set_up(), None);
        let row = |radius_mm| DatumRow { x_mm: 1.0, y_mm: 2.0, z_mm: 3.0, radius_mm };
        let checked = |radius| SetUpSheet { datum: vec![row(radius)], a_axis_mm: Some([0.0, 5.0]), ..none.clone() };
        assert_eq!(checked(None).validate().unwrap_err().key, "a_axis_mm");
        let of = checked(Some(10.0));
        assert!(of.validate().is_ok());
        let SetUp { datums, check, .. } = of.set_up().unwrap();
        assert_eq!(datums, [Datum { place: DVec3::new(1.0, 2.0, 3.0), radius: Some(10.0) }]);
        assert_eq!(check.unwrap().angles, [0.0, 30.0_f64.to_radians()]);
        // What is said of one workpiece goes, and what is left can be used.
        let other = SetUpSheet { round_mm: Some(0.01), ..of }.of_any_part();
        assert_eq!(other, SetUpSheet { round_mm: Some(0.01), ..none });
        assert!(other.validate().is_ok());
    }
}
