//! STEP: solids with faces.

use geometry::mesh::Mesh;
use step::read::{Options, Solid, read};

use super::error::ImportError;
use super::solids::{CadFaces, SolidReport, Solids};
use super::source::{Content, Likeness, MeshFormat, RawMesh, Source};
use super::units::Unit;

/// STEP files.
pub(super) const TEXT: MeshFormat = MeshFormat {
    name: "STEP",
    likeness,
    read: read_step,
    unit: Some((Unit::Mm, "the file, whose unit is converted,")),
};

/// Greatest turn of the surface along a side of a triangle (rad).
const TURN: f64 = 0.3;
/// How many solids an error names.
const NAMED: usize = 12;

fn likeness(content: &Content) -> Likeness {
    Likeness::Certain.when(content.text.is_some_and(|text| text.starts_with(b"ISO-10303-21")))
}

fn read_step(source: &Source) -> Result<RawMesh, ImportError> {
    // Entities take about twelve times their text.
    source.limits.check_memory(source.name, (source.bytes.len() as u64).saturating_mul(12))?;
    let options = Options {
        chord: source.reading.step_tolerance_mm,
        turn: TURN,
        max_triangles: source.limits.max_triangles,
        ..Options::default()
    };
    let file = read(source.bytes, &options, source.task).map_err(|problem| match problem {
        step::StepError::Cancelled(cancelled) => ImportError::Cancelled(cancelled),
        problem => ImportError::Step { file: source.name.to_owned(), source: problem },
    })?;
    let taken = taken(source, &file.solids)?;
    let mut warnings = file.warnings;
    let (unit_mm, unit) = &file.unit;
    if *unit_mm != 1.0 {
        warnings.push(format!("The lengths of the file are in {unit} and were converted."));
    }
    let (mut mesh, mut faces) = (Mesh::default(), CadFaces::default());
    for solid in taken.iter().map(|n| &file.solids[*n]) {
        append(solid, &mut mesh, &mut faces);
        for fault in solid.faults.iter().take(3) {
            let [x, y, z] = fault.place.to_array();
            let face = fault.face.map_or_else(String::new, |n| format!(" face {}", n + 1));
            warnings.push(format!("{}:{face} at ({x:.3}, {y:.3}, {z:.3}): {}.", solid.name, fault.problem));
        }
    }
    let list = (1u32..)
        .zip(&file.solids)
        .map(|(number, s)| SolidReport {
            number,
            name: s.name.clone(),
            is_taken: taken.contains(&(number as usize - 1)),
            faces: s.faces.len(),
            volume_mm3: s.mesh.volume(),
            is_closed: s.is_closed(),
            color: s.color,
        })
        .collect();
    Ok(RawMesh { mesh, warnings, solids: Some(Solids { list, faces }), ..RawMesh::default() })
}

/// Places in the list of the solids that make the part.
fn taken(source: &Source, solids: &[Solid]) -> Result<Vec<usize>, ImportError> {
    if source.reading.solids.is_empty() {
        return Ok((0..solids.len()).collect());
    }
    let mut taken = Vec::new();
    for &number in &source.reading.solids {
        let place = (number as usize).checked_sub(1).filter(|n| *n < solids.len());
        let Some(place) = place else {
            let named = solids.iter().take(NAMED).enumerate().map(|(n, s)| format!("{} {}", n + 1, s.name));
            let names = named.collect::<Vec<_>>().join(", ");
            let (file, count) = (source.name.to_owned(), solids.len());
            return Err(ImportError::NoSuchSolid { file, number, count, names });
        };
        if !taken.contains(&place) {
            taken.push(place);
        }
    }
    taken.sort_unstable();
    Ok(taken)
}

/// Adds a solid to a mesh and its faces.
fn append(solid: &Solid, mesh: &mut Mesh, faces: &mut CadFaces) {
    let (first, first_face) = (mesh.vertices.len() as u32, faces.faces.len() as u32);
    mesh.vertices.extend(&solid.mesh.vertices);
    mesh.triangles.extend(solid.mesh.triangles.iter().map(|t| t.map(|v| v + first)));
    faces.face_of.extend(solid.face_of.iter().map(|f| f + first_face));
    faces.faces.extend_from_slice(&solid.faces);
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use geometry::segmentation::{EdgeKind, FaceKind, SegmentationSettings};
    use step_io::build::{CurveInput, FaceBoundInput, Frame, SurfaceInput};
    use step_io::{Orientation, StepBuilder};
    use task::Task;

    use crate::{ImportOptions, Reading, import_bytes};

    /// Two cylinders about Z, of radius 5 and height 10, 20 mm apart along X.
    fn two_cylinders() -> Vec<u8> {
        use Orientation::{Forward, Reversed};
        let mut b = StepBuilder::new();
        let part = b.part("pins");
        for x in [0.0, 20.0] {
            let at = |z: f64| Frame { origin: [x, 0.0, z], axis: [0.0, 0.0, 1.0], ref_dir: [1.0, 0.0, 0.0] };
            let ends = [0.0, 10.0].map(|z| b.vertex([x + 5.0, 0.0, z]).unwrap());
            let low = b.edge(ends[0], ends[0], CurveInput::Circle(at(0.0), 5.0)).unwrap();
            let high = b.edge(ends[1], ends[1], CurveInput::Circle(at(10.0), 5.0)).unwrap();
            let around =
                vec![FaceBoundInput::outer(vec![(low, Forward)]), FaceBoundInput::inner(vec![(high, Reversed)])];
            let mut cap = |edge, z, side| {
                b.face(SurfaceInput::Plane(at(z)), side, vec![FaceBoundInput::outer(vec![(edge, side)])]).unwrap()
            };
            let caps = [cap(low, 0.0, Reversed), cap(high, 10.0, Forward)];
            let wall = b.face(SurfaceInput::Cylinder(at(0.0), 5.0), Forward, around).unwrap();
            b.solid(part, &format!("pin at {x}"), vec![wall, caps[0], caps[1]]).unwrap();
        }
        let mut bytes = Vec::new();
        step_io::write(&b.finish(), &mut bytes).unwrap();
        bytes
    }

    #[test]
    fn the_faces_of_the_file_are_those_of_the_part() {
        let options =
            ImportOptions { reading: Reading { solids: vec![2], ..Reading::default() }, ..ImportOptions::default() };
        let part = import_bytes("pins.step", &two_cylinders(), &options, &Task::default()).unwrap();
        let taken: Vec<bool> = part.report.solids.iter().map(|s| s.is_taken).collect();
        assert_eq!((taken, part.report.watertight), (vec![false, true], true));
        assert!((part.mesh.volume() - 250.0 * PI).abs() < 0.005 * 100.0 * PI && part.report.min_mm.x > 14.9);
        let found = part.segmentation(&SegmentationSettings::default());
        assert_eq!(found.faces.len(), 3);
        let wall = found.faces.iter().find(|f| matches!(f.kind, FaceKind::Cylinder { .. })).unwrap();
        let FaceKind::Cylinder { radius, is_hollow, .. } = wall.kind else { panic!("no cylinder") };
        // Exact, where triangles alone would give the radius to their chords.
        assert!(radius == 5.0 && !is_hollow && wall.deviation < 1e-9 && (wall.area - 100.0 * PI).abs() < 0.5);
        let words: Vec<String> = wall.triangles.iter().filter_map(|t| part.faces.as_ref()?.words_at(*t)).collect();
        assert!(words.len() == wall.triangles.len() && words.iter().all(|w| w.ends_with("cylinder, radius 5.0000 mm")));
        assert!(part.report.notes().any(|note| note.contains("within 0.005 mm of the exact faces")));
        assert!(found.edges.len() == 2 && found.edges.iter().all(|e| e.kind == EdgeKind::Convex && e.is_closed()));
    }

    #[test]
    fn solids_that_are_not_there_are_refused_with_those_that_are() {
        let reading = Reading { solids: vec![3], ..Reading::default() };
        let options = ImportOptions { reading, ..ImportOptions::default() };
        let error = import_bytes("pins.step", &two_cylinders(), &options, &Task::default()).unwrap_err().to_string();
        assert!(error.contains("no solid 3 among its 2") && error.contains("2 pins: pin at 20"), "{error}");
    }
}
