//! STEP: solids with faces.

use geometry::mesh::{Bounds, Mesh};
use geometry::solid::FacedMesh;
use step::read::{Options, Solid, read};

use super::error::ImportError;
use super::solids::{CadFaces, SolidReport, Solids};
use super::source::{Content, Likeness, MeshFormat, RawMesh, Source};
use super::unite::{Single, numbers, unite};
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
    let [taken, obstacles] = chosen(source, &file.solids)?;
    let mut warnings = file.warnings;
    let (unit_mm, unit) = &file.unit;
    if *unit_mm != 1.0 {
        warnings.push(format!("The lengths of the file are in {unit} and were converted."));
    }
    if source.reading.solids.is_empty() {
        let is_left = |n: &usize| !taken.contains(n) && !obstacles.contains(n);
        let left: Vec<u32> = (0..file.solids.len()).filter(is_left).map(|n| n as u32 + 1).collect();
        if !left.is_empty() {
            let left = numbers(&left);
            warnings.push(format!(
                "Solids that lie apart from the largest one were left out: {left}. Name those that make the part in \
                 solids, and those that are in the way in obstacles."
            ));
        }
    }
    let (mut singles, mut faces) = (Vec::new(), Vec::new());
    for (n, solid) in taken.iter().map(|n| (*n, &file.solids[*n])) {
        let first_face = faces.len() as u32;
        let face_of = solid.face_of.iter().map(|f| f + first_face).collect();
        let faced = FacedMesh { mesh: solid.mesh.clone(), face_of };
        let (number, is_closed) = (n as u32 + 1, solid.is_closed());
        singles.push(Single { number, faced, is_closed, faces: &solid.faces, first_face });
        faces.extend_from_slice(&solid.faces);
        for fault in solid.faults.iter().take(3) {
            let [x, y, z] = fault.place.to_array();
            let face = fault.face.map_or_else(String::new, |n| format!(" face {}", n + 1));
            warnings.push(format!("{}:{face} at ({x:.3}, {y:.3}, {z:.3}): {}.", solid.name, fault.problem));
        }
    }
    let (FacedMesh { mesh, face_of }, united) = unite(singles, source.reading.step_tolerance_mm, source.task)?;
    warnings.extend(united);
    let mut beside = Mesh::default();
    for solid in obstacles.iter().map(|n| &file.solids[*n]) {
        if !solid.is_closed() {
            warnings.push(format!("The surface of the obstacle {} is not closed: clearance from it is kept, but inside of it nothing is known.", solid.name));
        }
        beside.append(&solid.mesh);
    }
    let list = (1u32..)
        .zip(&file.solids)
        .map(|(number, s)| SolidReport {
            number,
            name: s.name.clone(),
            is_taken: taken.contains(&(number as usize - 1)),
            is_obstacle: obstacles.contains(&(number as usize - 1)),
            faces: s.faces.len(),
            volume_mm3: s.mesh.volume(),
            is_closed: s.is_closed(),
            color: s.color,
        })
        .collect();
    let faces = CadFaces { faces, face_of };
    Ok(RawMesh { mesh, warnings, solids: Some(Solids { list, faces, obstacles: beside }), ..RawMesh::default() })
}

/// Places in the list of the solids that make the part, and of those that are obstacles.
fn chosen(source: &Source, solids: &[Solid]) -> Result<[Vec<usize>; 2], ImportError> {
    let obstacles = places(source, solids, &source.reading.obstacles)?;
    let mut taken = places(source, solids, &source.reading.solids)?;
    if taken.is_empty() {
        taken = beside_largest(solids, &obstacles);
    }
    if let Some(both) = obstacles.iter().find(|n| taken.contains(n)) {
        let file = source.name.to_owned();
        return Err(ImportError::PartAndObstacle { file, number: *both as u32 + 1 });
    }
    if taken.is_empty() {
        return Err(ImportError::OnlyObstacles { file: source.name.to_owned() });
    }
    Ok([taken, obstacles])
}

/// Places in the list of the solids with these numbers.
fn places(source: &Source, solids: &[Solid], numbers: &[u32]) -> Result<Vec<usize>, ImportError> {
    let mut places = Vec::new();
    for &number in numbers {
        let place = (number as usize).checked_sub(1).filter(|n| *n < solids.len());
        let Some(place) = place else {
            let named = solids.iter().take(NAMED).enumerate().map(|(n, s)| format!("{} {}", n + 1, s.name));
            let names = named.collect::<Vec<_>>().join(", ");
            let (file, count) = (source.name.to_owned(), solids.len());
            return Err(ImportError::NoSuchSolid { file, number, count, names });
        };
        if !places.contains(&place) {
            places.push(place);
        }
    }
    places.sort_unstable();
    Ok(places)
}

/// The largest solid that is no obstacle and all others whose box meets that of those that were found already: blades
/// stand beside their hub, the other half of a mold does not.
fn beside_largest(solids: &[Solid], obstacles: &[usize]) -> Vec<usize> {
    /// Of equal solids the first is the largest, whatever rounding makes of copies.
    const MORE: f64 = 1.0 + 1e-9;
    let free: Vec<usize> = (0..solids.len()).filter(|n| !obstacles.contains(n)).collect();
    let size = |n: &usize| solids[*n].mesh.volume().abs();
    let Some(largest) = free.iter().copied().reduce(|a, b| if size(&b) > MORE * size(&a) { b } else { a }) else {
        return Vec::new();
    };
    let boxes: Vec<Bounds> = solids.iter().map(|s| s.mesh.bounds()).collect();
    let mut around = boxes[largest];
    let mut taken = vec![largest];
    loop {
        let more: Vec<usize> =
            free.iter().copied().filter(|n| !taken.contains(n) && boxes[*n].intersects(&around)).collect();
        if more.is_empty() {
            taken.sort_unstable();
            return taken;
        }
        for n in more {
            around = Bounds { min: around.min.min(boxes[n].min), max: around.max.max(boxes[n].max) };
            taken.push(n);
        }
    }
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

    #[test]
    fn solids_that_lie_apart_are_left_out_or_obstacles() {
        let read = |solids: &[u32], obstacles: &[u32]| {
            let reading = Reading { solids: solids.to_vec(), obstacles: obstacles.to_vec(), ..Reading::default() };
            let options = ImportOptions { reading, ..ImportOptions::default() };
            import_bytes("pins.step", &two_cylinders(), &options, &Task::default())
        };
        let alone = read(&[], &[]).unwrap();
        assert!(alone.report.components == 1 && alone.obstacles.is_none() && alone.mesh.bounds().max.x < 5.1);
        assert!(alone.report.warnings.iter().any(|w| w.contains("left out: 2.")), "{:?}", alone.report.warnings);
        assert!(read(&[1, 2], &[]).unwrap().report.components == 2);
        // An obstacle is no part of the mesh, whichever is named.
        let part = read(&[], &[1]).unwrap();
        assert!(part.report.min_mm.x > 14.9 && part.report.solids[0].is_obstacle);
        let beside = part.obstacles.unwrap();
        assert!(beside.is_watertight() && beside.bounds().max.x < 5.1);
        assert!((beside.volume() - 250.0 * PI).abs() < 0.005 * 100.0 * PI);
        let error = read(&[1, 2], &[2]).unwrap_err().to_string();
        assert!(error.contains("solid 2 is named among"), "{error}");
        assert!(read(&[], &[1, 2]).unwrap_err().to_string().contains("all solids are obstacles"));
    }
}
