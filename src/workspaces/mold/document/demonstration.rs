//! The mold that comes with the program: it stands in for the mesh where a project names none.

use import::{ImportOptions, Imported, Units, import_bytes, stl_bytes};
use mold::demonstration::demonstration as made;
use task::Task;

use super::{MoldParams, part_of};

/// Name of the demonstration mold.
pub const DEMONSTRATION: &str = "Demonstration mold";

/// The demonstration mold, as from a file.
///
/// # Errors
/// One line if the task is cancelled; else none, as a test makes the mold.
pub fn demonstration(task: &Task) -> Result<Imported, String> {
    let mesh = made().map_err(|e| e.to_string())?;
    let bytes = stl_bytes(&mesh).map_err(|e| e.to_string())?;
    let options = ImportOptions { reading: Units::Mm.into(), ..ImportOptions::default() };
    import_bytes(DEMONSTRATION, &bytes, &options, task).map_err(|e| e.to_string())
}

impl MoldParams {
    /// The demonstration mold, if these parameters name no mesh and were made for it in the window.
    ///
    /// # Errors
    /// Those of [`demonstration`].
    pub fn demonstrated(&self, task: &Task) -> Result<Option<Imported>, String> {
        if self.mesh.is_some() || self.part.is_none() {
            return Ok(None);
        }
        let imported = demonstration(task)?;
        Ok(self.part.as_ref().is_some_and(|part| *part == part_of(&imported)).then_some(imported))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_stands_in_for_no_mesh_of_a_project_that_was_made_for_it() {
        let imported = demonstration(&Task::default()).unwrap();
        assert!(imported.report.watertight && imported.report.unit_doubt().is_none(), "{:?}", imported.report);
        let of = |part: Option<String>| MoldParams { part, ..MoldParams::default() }.demonstrated(&Task::default());
        assert_eq!(of(Some(part_of(&imported))).unwrap(), Some(imported));
        assert!(of(None).unwrap().is_none() && of(Some("other".to_owned())).unwrap().is_none());
    }
}
