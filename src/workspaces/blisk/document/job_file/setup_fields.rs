//! The parameters of wheel and electrodes as they are set up.

use files::{Field, Group};

/// Table of the electrodes as they stand on their holders.
pub(super) const PRESETS: Group = Group {
    section: "Verify",
    name: "Electrodes as measured",
    is_folded: true,
    fields: &[Field::file("setup.presets", "Presets").help(
        "Table of the places of the electrodes on their holders, and of what their fronts have lost (CSV with the columns \
         electrode, x_mm, y_mm, z_mm, c_deg, uncertainty_mm, date and, if there is wear, wear_mm). Paths make up for them and \
         are certified so.",
    )],
};

/// Datums of the set-up sheet.
pub(super) const SETUP: Group = Group {
    section: "Export",
    name: "Set-up sheet",
    is_folded: true,
    fields: &[
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
        .help("Balls and corners that the machine touches, in the coordinates of the wheel's file."),
        Field::number("setup.round_mm", "Round to", "mm", 1e-4, 10.0)
            .decimals(4)
            .or_nothing(0.001)
            .help("Step that the set-up values are rounded to."),
        Field::numbers("setup.a_axis_mm", "Axis of A", "mm", -1e5, 1e5).count(2).optional().help(
            "Y and Z of the axis of A in W, with a comma between: what the balls must read at both angles is told.",
        ),
        Field::numbers("setup.a_deg", "Angles of A", "deg", -360.0, 360.0)
            .count(2)
            .help("The two angles of A for that, as in the programs."),
    ],
};
