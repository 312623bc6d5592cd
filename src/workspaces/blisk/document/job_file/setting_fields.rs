//! The parameters of setting up.

use files::{Field, Group};

/// Greatest errors of the axes, and what they may take of the gap.
pub(super) const SETTING: Group = Group {
    section: "Verify",
    name: "Setting errors",
    is_folded: true,
    fields: &[
        Field::number("setting.x_mm", "Error of X", "mm", 0.0, 1.0)
            .decimals(4)
            .help("Greatest error along the axis of the blisk; all errors 0: setting up is not considered."),
        Field::number("setting.y_mm", "Error of Y", "mm", 0.0, 1.0)
            .decimals(4)
            .help("Greatest error across the channel."),
        Field::number("setting.z_mm", "Error of Z", "mm", 0.0, 1.0)
            .decimals(4)
            .help("Greatest error along the radius."),
        Field::number("setting.a_deg", "Error of A", "deg", 0.0, 1.0)
            .decimals(4)
            .help("Greatest error of the blisk about its axis."),
        Field::number("setting.b_deg", "Error of B", "deg", 0.0, 1.0)
            .decimals(4)
            .help("Greatest error of the electrode about its Y."),
        Field::number("setting.c_deg", "Error of C", "deg", 0.0, 1.0)
            .decimals(4)
            .help("Greatest error of the electrode about its Z."),
        Field::number("setting.accuracy_mm", "Accuracy", "mm", 0.0, 10.0)
            .decimals(4)
            .help("Part of the spark gap that the errors may take up, everywhere on the feed."),
    ],
};
