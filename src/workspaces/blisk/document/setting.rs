//! Errors with which wheel and electrode are set up on the machine.

use feed::verify::VerifyError;
use feed::verify::setting::{ACCURACY_MM, LEAST_LEFT_MM, SettingErrors};
use files::Invalid;
use serde::{Deserialize, Serialize};

/// `[setting]`
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SettingSection {
    /// Along the axis of the blisk (mm).
    pub x_mm: f64,
    /// Across the channel (mm).
    pub y_mm: f64,
    /// Along the radius (mm).
    pub z_mm: f64,
    /// Of the blisk about its axis (degrees).
    pub a_deg: f64,
    /// Of the electrode about its Y (degrees).
    pub b_deg: f64,
    /// Of the electrode about its Z (degrees).
    pub c_deg: f64,
    /// Part of the spark gap that the errors may take up (mm).
    pub accuracy_mm: f64,
}

impl Default for SettingSection {
    /// No errors: setting up is not considered.
    fn default() -> Self {
        let [x_mm, y_mm, z_mm, a_deg, b_deg, c_deg] = [0.0; 6];
        Self { x_mm, y_mm, z_mm, a_deg, b_deg, c_deg, accuracy_mm: ACCURACY_MM }
    }
}

impl SettingSection {
    /// The errors; none where all are 0: setting up is not considered then.
    pub fn errors(&self) -> Option<SettingErrors> {
        let Self { x_mm, y_mm, z_mm, a_deg, b_deg, c_deg, .. } = *self;
        let errors = SettingErrors { x_mm, y_mm, z_mm, a_deg, b_deg, c_deg };
        (errors.of_axes() != [0.0; 6]).then_some(errors)
    }

    /// Clearance that has to be left with every error, of a spark gap (mm).
    pub fn least_mm(&self, spark_gap_mm: f64) -> f64 {
        spark_gap_mm - self.accuracy_mm
    }

    /// Checks the errors, and that the accuracy leaves some of the spark gap (mm).
    pub fn validate(&self, spark_gap_mm: f64) -> Result<(), Invalid> {
        let Some(errors) = self.errors() else { return Ok(()) };
        errors.validate().map_err(|e: VerifyError| Invalid::of("setting", e.to_string()))?;
        if self.accuracy_mm >= 0.0 && self.least_mm(spark_gap_mm) > LEAST_LEFT_MM {
            return Ok(());
        }
        let remedy =
            format!("must be 0 or more, and leave more than {LEAST_LEFT_MM} mm of the spark gap of {spark_gap_mm} mm");
        Err(Invalid::new("setting.accuracy_mm", self.accuracy_mm, remedy))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_are_asked_about_where_one_is_given_and_leave_some_of_the_gap() {
        let none = SettingSection::default();
        assert_eq!(none.errors(), None);
        let some = SettingSection { x_mm: 0.005, a_deg: 0.002, ..none };
        assert_eq!(some.errors().map(|e| e.of_axes()), Some([0.005, 0.0, 0.0, 0.002_f64.to_radians(), 0.0, 0.0]));
        assert!((some.least_mm(0.1) - 0.07).abs() < 1e-12);
        assert!(some.validate(0.1).is_ok());
        let error = some.validate(0.02).unwrap_err().to_string();
        assert!(error.contains("setting.accuracy_mm") && error.contains("0.02 mm"), "{error}");
        assert!(SettingSection { accuracy_mm: 0.0995, ..some }.validate(0.1).is_err(), "what is left cannot be proven");
        let error = SettingSection { z_mm: -1.0, ..none }.validate(0.1).unwrap_err().to_string();
        assert!(error.contains("z_mm"), "{error}");
    }
}
