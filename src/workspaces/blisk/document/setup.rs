//! How a wheel and its electrodes are set up on the machine.

use files::{Invalid, Validate};
use serde::{Deserialize, Serialize};

use crate::workspaces::setup::{DatumRow, SetUpSheet};

/// `[setup]`
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(from = "SetUpKeys")]
pub struct SetUpSection {
    /// Table of the places of the electrodes on their holders, and of their wear; none where they are planned as nominal.
    pub presets: Option<String>,
    /// Settings of the set-up sheet.
    #[serde(flatten)]
    pub sheet: SetUpSheet,
}

impl Validate for SetUpSection {
    fn validate(&self) -> Result<(), Invalid> {
        self.sheet.validate()
    }
}

/// The keys of `[setup]` in one struct: serde finds unknown keys only there.
#[derive(Deserialize)]
#[serde(default, deny_unknown_fields)]
struct SetUpKeys {
    presets: Option<String>,
    datum: Vec<DatumRow>,
    round_mm: Option<f64>,
    a_axis_mm: Option<[f64; 2]>,
    a_deg: [f64; 2],
}

impl Default for SetUpKeys {
    fn default() -> Self {
        let SetUpSheet { datum, round_mm, a_axis_mm, a_deg } = SetUpSheet::default();
        Self { presets: None, datum, round_mm, a_axis_mm, a_deg }
    }
}

impl From<SetUpKeys> for SetUpSection {
    fn from(SetUpKeys { presets, datum, round_mm, a_axis_mm, a_deg }: SetUpKeys) -> Self {
        Self { presets, sheet: SetUpSheet { datum, round_mm, a_axis_mm, a_deg } }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_keys_stand_side_by_side_and_an_unknown_one_is_refused() {
        let text = "presets = \"own.csv\"\nround_mm = 0.01\n[[datum]]\nx_mm = 1.0\ny_mm = 2.0\nz_mm = 3.0\n";
        let read: SetUpSection = toml::from_str(text).unwrap();
        let row = DatumRow { x_mm: 1.0, y_mm: 2.0, z_mm: 3.0, radius_mm: None };
        let sheet = SetUpSheet { datum: vec![row], round_mm: Some(0.01), ..SetUpSheet::default() };
        assert_eq!(read, SetUpSection { presets: Some("own.csv".to_owned()), sheet });
        assert_eq!(toml::Table::try_from(&read).unwrap().try_into::<SetUpSection>().unwrap(), read);
        assert_eq!(toml::from_str::<SetUpSection>("").unwrap(), SetUpSection::default());
        let wrong = toml::from_str::<SetUpSection>("rounds_mm = 0.01").unwrap_err();
        assert!(wrong.to_string().contains("rounds_mm"), "{wrong}");
    }
}
