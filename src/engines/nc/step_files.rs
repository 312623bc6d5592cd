//! Electrodes as STEP files: with faces that a CAM program can put a tool on.
//!
//! What is proven belongs to the triangles. A file is written only if its faces stay within the mesh and a stretch beyond
//! it that is to spare.

use step::write::{Property, PropertyValue, StepFile, StepPart, StepReport, StepSettings, StepWriteError, write_step};
use task::{Cancelled, Task};

/// Limits of the tolerance that faces are fitted with (mm).
const TOLERANCES: [f64; 2] = [5e-4, 5e-3];
/// Tolerances of faces that are known, which stay inside of the mesh, in the order in which they are tried (mm).
const INSIDE: [f64; 3] = [5e-3, 3e-3, 8e-3];

/// Most faces of a file: those of more are too small to put a tool on.
const MOST_FACES: usize = 500;

/// A STEP file, or the reason why there is none.
pub type WrittenStep = Result<StepFile, String>;

/// The STEP file of `part`, whose faces may reach `to_spare` (mm) beyond its mesh.
///
/// # Errors
/// When told to stop.
pub fn written_step(part: &StepPart, to_spare: f64, task: &Task) -> Result<WrittenStep, Cancelled> {
    let of_found = [(0.5 * to_spare).clamp(TOLERANCES[0], TOLERANCES[1])];
    let tolerances: &[f64] = if part.patches.is_empty() { &of_found } else { &INSIDE };
    let mut tried = tolerances
        .iter()
        .map(|&tolerance| write_step(part, &StepSettings { tolerance, to_spare, ..Default::default() }, task));
    let Some(mut made) = tried.next() else { return Ok(Err("there is no tolerance to try".to_owned())) };
    while let Err(error) = &made {
        let is_final = matches!(
            error,
            StepWriteError::Cancelled(_)
                | StepWriteError::Deviation { .. }
                | StepWriteError::Beyond { .. }
                | StepWriteError::ToSpare { .. }
        );
        if is_final {
            break;
        }
        let Some(next) = tried.next() else { break };
        made = next;
    }
    Ok(match made {
        Ok(file) if beyond(&file.report) > to_spare => Err(format!(
            "its faces may reach {:.4} mm beyond the mesh that was checked, and {to_spare:.4} mm are to spare; leave more \
             clearance, or take the mesh",
            beyond(&file.report)
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
        Err(StepWriteError::Deviation { at, distance, most }) if !part.patches.is_empty() => Err(format!(
            "its faces would lie {distance:.4} mm off the mesh that was checked at ({:.2}, {:.2}, {:.2}) mm, and {most:.4} mm \
             are allowed; a usual cause is triangles that are twisted beside a fillet; take the mesh",
            at.x, at.y, at.z
        )),
        Err(error) => Err(error.to_string()),
    })
}

/// The most that faces may reach beyond the mesh (mm).
fn beyond(report: &StepReport) -> f64 {
    report.outside_mm + report.unsure_mm
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
        "{} faces ({}), no more than {:.4} mm beyond the mesh that was checked, and {:.4} mm inside of it, where that much \
         less is burnt",
        report.faces(),
        kinds.join(", "),
        beyond(report),
        report.inside_mm
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

#[cfg(test)]
mod tests {
    use geometry::mesh::Mesh;
    use glam::DVec3;

    use super::*;

    /// A prism of so many sides.
    fn prism(sides: u32) -> Mesh {
        let at = |k: u32, z: f64| {
            let angle = std::f64::consts::TAU * f64::from(k % sides) / f64::from(sides);
            DVec3::new(5.0 * angle.cos(), 5.0 * angle.sin(), z)
        };
        let vertices = (0..sides).flat_map(|k| [at(k, 0.0), at(k, 8.0)]).collect();
        let ring = |k: u32| [2 * (k % sides), 2 * (k % sides) + 1];
        let walls = (0..sides).flat_map(|k| {
            let ([a, b], [c, d]) = (ring(k), ring(k + 1));
            [[a, c, b], [b, c, d]]
        });
        let ends = (1..sides - 1).flat_map(|k| [[0, 2 * (k + 1), 2 * k], [1, 2 * k + 1, 2 * k + 3]]);
        Mesh { vertices, triangles: walls.chain(ends).collect() }
    }

    fn tried(mesh: &Mesh, to_spare: f64) -> WrittenStep {
        let part = StepPart { name: "E", mesh, roles: &[], role_of: &[], patches: &[], properties: &[] };
        written_step(&part, to_spare, &Task::default()).unwrap()
    }

    /// The cylinder around a prism of 120 sides lies 5 (1 - cos 1.5 deg) = 0.0017 mm beyond it; a prism of 6 sides is planes.
    #[test]
    fn faces_beyond_the_mesh_are_written_only_where_there_is_room_for_them() {
        let round = prism(120);
        let words = step_words(&tried(&round, 0.01));
        assert!(words.starts_with("STEP: 4 faces (2 planes, 2 cylinders)"), "{words}");
        let words = step_words(&tried(&round, 0.0018));
        assert!(words.starts_with("No STEP file: ") && words.contains(" mm"), "{words}");
        let flat = tried(&prism(6), 1e-6);
        assert_eq!(
            step_words(&flat),
            "STEP: 8 faces (8 planes), no more than 0.0000 mm beyond the mesh that was checked, and 0.0000 mm inside of it, where \
             that much less is burnt."
        );
    }

    #[test]
    fn several_solids_are_no_electrode() {
        let one = prism(6);
        let first = one.vertices.len() as u32;
        let beside = one.vertices.iter().map(|p| *p + DVec3::X * 20.0);
        let mesh = Mesh {
            vertices: one.vertices.iter().copied().chain(beside).collect(),
            triangles: one
                .triangles
                .iter()
                .copied()
                .chain(one.triangles.iter().map(|t| t.map(|v| v + first)))
                .collect(),
        };
        assert!(tried(&mesh, 0.01).unwrap_err().contains("2 solids"));
    }
}
