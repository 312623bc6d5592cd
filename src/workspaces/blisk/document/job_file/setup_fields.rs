//! The parameters of wheel and electrodes as they are set up.

use crate::workspaces::setup::SETUP_SHEET_FIELDS;
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
pub(super) const SETUP: Group =
    Group { section: "Export", name: "Set-up sheet", is_folded: true, fields: SETUP_SHEET_FIELDS };
