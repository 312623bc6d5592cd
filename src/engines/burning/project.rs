//! Choice of a technology in a project.

use files::{Invalid, Validate};
use serde::{Deserialize, Serialize};

use crate::duration::Overhead;
use crate::wear::{AllowedWear, Redress};

/// Word for the built-in technology table.
pub const BUILT_IN: &str = "built-in";

/// Technology of a project, the wear at which its electrodes are replaced, and the time beside burning.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ProjectTechnology {
    /// Technology table: [`BUILT_IN`], or a TOML file.
    pub table: String,
    /// Id of the technology in the table.
    pub id: String,
    /// Wear at which an electrode is replaced.
    pub allowed_wear: AllowedWear,
    /// Redressing of worn electrodes.
    pub redress: Redress,
    /// Time beside burning.
    pub overhead: Overhead,
}

impl Default for ProjectTechnology {
    fn default() -> Self {
        Self {
            table: BUILT_IN.to_owned(),
            id: "steel-copper".to_owned(),
            allowed_wear: AllowedWear::default(),
            redress: Redress::default(),
            overhead: Overhead::default(),
        }
    }
}

impl ProjectTechnology {
    /// Whether the table is a file.
    pub fn is_file(&self) -> bool {
        self.table != BUILT_IN
    }
}

impl Validate for ProjectTechnology {
    fn validate(&self) -> Result<(), Invalid> {
        if self.table.trim().is_empty() {
            return Err(Invalid::of("table", format!("is empty; give {BUILT_IN} or a file")));
        }
        self.allowed_wear.validate().map_err(|problem| problem.within("allowed_wear"))?;
        self.redress.validate().map_err(|problem| problem.within("redress"))?;
        self.overhead.validate().map_err(|problem| problem.within("overhead"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_technology_of_a_new_project_is_one_of_the_built_in_table() {
        let project = ProjectTechnology::default();
        assert!(!project.is_file() && project.validate().is_ok());
        assert!(crate::defaults::standard().unwrap().get(&project.id).is_some());
    }

    #[test]
    fn limits_that_are_not_given_stay_so_and_wrong_ones_are_named() {
        let read = |text: &str| toml::from_str::<ProjectTechnology>(text).unwrap();
        let project = read("id = \"a\"\n[allowed_wear]\nend_mm = 0.1\n[overhead]\nsetup_min = 30.0\n");
        assert_eq!((project.allowed_wear.end_mm, project.allowed_wear.corner_mm), (Some(0.1), None));
        assert_eq!(read(&toml::to_string(&project).unwrap()), project);
        let wrong = read("[allowed_wear]\ncorner_mm = 0.0\n").validate().unwrap_err().to_string();
        assert!(wrong.starts_with("allowed_wear.corner_mm is 0"), "{wrong}");
        let wrong = read("[overhead]\nchange_min = -1.0\n").validate().unwrap_err().to_string();
        assert!(wrong.starts_with("overhead.change_min is -1"), "{wrong}");
        assert!(read("table = \"\"").validate().is_err());
    }
}
