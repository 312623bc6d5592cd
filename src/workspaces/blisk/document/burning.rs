//! How a wheel is burned, beside the technology.

use std::path::PathBuf;

use burning::choice::Until;
use burning::schedule::Order;
use files::{Invalid, Validate};
use serde::{Deserialize, Serialize};

/// `[burning]`
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct BurningSection {
    /// Name of the step at which burning ends; empty to end at the finish.
    pub last_step: String,
    /// Finish at which burning ends (VDI 3400); none if it is not given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub finish_vdi: Option<f64>,
    /// Indexing to another channel (minutes).
    pub indexing_min: f64,
    /// Order of the channels of the wheel.
    pub order: Order,
    /// Stock on the surfaces of the channels of a wheel that was cast, printed or roughed before (mm); none of a full ring.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub allowance_mm: Option<f64>,
    /// Mesh of the wheel as it comes, in the coordinates of its own; none of a full ring.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub blank: Option<PathBuf>,
}

impl Validate for BurningSection {
    fn validate(&self) -> Result<(), Invalid> {
        match (&self.blank, self.allowance_mm) {
            (Some(_), Some(mm)) => Err(Invalid::new(
                "allowance_mm",
                mm,
                "a mesh of the wheel as it comes is given as well; give one of them",
            )),
            _ => Ok(()),
        }
    }
}

impl BurningSection {
    /// End of burning; none if neither a step nor a finish is given.
    pub fn until(&self) -> Option<Until> {
        match self.last_step.trim() {
            "" => self.finish_vdi.map(Until::Vdi),
            step => Some(Until::Step(step.to_owned())),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn burning_ends_at_the_step_or_else_at_the_finish() {
        let section = |last_step: &str, finish_vdi| {
            BurningSection { last_step: last_step.to_owned(), finish_vdi, ..BurningSection::default() }.until()
        };
        assert_eq!(section("S1", Some(24.0)), Some(Until::Step("S1".to_owned())));
        assert_eq!(section(" ", Some(24.0)), Some(Until::Vdi(24.0)));
        assert_eq!(section("", None), None, "nothing is taken for a finish");
    }
}
