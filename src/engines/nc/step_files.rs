//! Electrodes as STEP files: with faces that a CAM program can put a tool on.
//!
//! What is proven belongs to the triangles. A file is written only if its faces stay within the mesh and a stretch beyond
//! it that is to spare.

use step::write::{Property, PropertyValue, StepFile, StepPart, StepReport, StepSettings, StepWriteError, write_step};
use task::{Cancelled, Task};

/// Limits of the tolerance that faces are fitted with (mm).
const TOLERANCES: [f64; 2] = [5e-4, 5e-3];

/// Most faces of a file: those of more are too small to put a tool on.
const MOST_FACES: usize = 500;

/// A STEP file, or the reason why there is none.
pub type WrittenStep = Result<StepFile, String>;

/// The STEP file of `part`, whose faces may reach `to_spare` (mm) beyond its mesh.
///
/// # Errors
/// When told to stop.
pub fn written_step(part: &StepPart, to_spare: f64, task: &Task) -> Result<WrittenStep, Cancelled> {
    let settings =
        StepSettings { tolerance: (0.5 * to_spare).clamp(TOLERANCES[0], TOLERANCES[1]), ..Default::default() };
    Ok(match write_step(part, &settings, task) {
        Ok(file) if file.report.outside_mm > to_spare => Err(format!(
            "its faces reach {:.4} mm beyond the mesh that was checked, and {to_spare:.4} mm are to spare; leave more \
             clearance, or take the mesh",
            file.report.outside_mm
        )),
        Ok(file) if file.report.solids != 1 => {
            Err(format!("it would be {} solids, and an electrode is one; take the mesh", file.report.solids))
        }
        Ok(file) if file.report.faces() > MOST_FACES => Err(format!(
            "its triangles are too uneven for large faces: there would be {} of them, more than {MOST_FACES}; make the mesh \
             of the part finer, or take the mesh",
            file.report.faces()
        )),
        Ok(file) => Ok(file),
        Err(StepWriteError::Cancelled(cancelled)) => return Err(cancelled),
        Err(error) => Err(error.to_string()),
    })
}

/// The file that was written, or why there is none, in a sentence.
pub fn step_words(step: &WrittenStep) -> String {
    match step {
        Ok(file) => format!("STEP: {}.", report_words(&file.report)),
        Err(why) => format!("No STEP file: {why}."),
    }
}

/// Faces of a file and its distance from the mesh, in words.
fn report_words(report: &StepReport) -> String {
    let kinds = [
        (report.planes, "planes"),
        (report.cylinders, "cylinders"),
        (report.cones, "cones"),
        (report.free_forms, "B-splines"),
    ];
    let kinds: Vec<String> =
        kinds.into_iter().filter(|(count, _)| *count > 0).map(|(count, kind)| format!("{count} {kind}")).collect();
    format!(
        "{} faces ({}), at most {:.4} mm off the mesh that was checked, {:.4} mm beyond it",
        report.faces(),
        kinds.join(", "),
        report.deviation_mm(),
        report.outside_mm
    )
}

/// A property in words.
pub fn text(name: &str, value: &str) -> Property {
    Property { name: name.to_owned(), value: PropertyValue::Text(value.to_owned()) }
}

/// A property that is a length (mm).
pub fn length(name: &str, value: f64) -> Property {
    Property { name: name.to_owned(), value: PropertyValue::Length(value) }
}

/// A property that is a number of things.
pub fn count(name: &str, value: u32) -> Property {
    Property { name: name.to_owned(), value: PropertyValue::Count(value) }
}
