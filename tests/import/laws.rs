//! What holds for any bytes, any damage and any shape.

use geometry::mesh::Mesh;
use glam::DVec3;
use import::{ImportLimits, ImportOptions, Reading, Units, import_bytes};
use proptest::prelude::*;
use task::Task;

use super::files::*;

/// Whatever the bytes, the answer is a sound mesh or one line; under limits that keep the test small.
fn survives(bytes: &[u8]) -> Result<(), TestCaseError> {
    let limits = ImportLimits { max_memory_bytes: 64 << 20, ..Default::default() };
    let options = ImportOptions { limits, ..Default::default() };
    for name in ["x", "x.stl", "x.obj", "x.gltf"] {
        match import_bytes(name, bytes, &options, &Task::default()) {
            Ok(imported) => {
                let mesh = &imported.mesh;
                prop_assert!(mesh.vertices.iter().all(|p| p.is_finite() && p.abs().max_element() <= 1e6));
                prop_assert!(mesh.triangles.iter().flatten().all(|&v| (v as usize) < mesh.vertices.len()));
                prop_assert!(mesh.triangles.iter().all(|&[a, b, c]| a != b && b != c && c != a));
                prop_assert_eq!(imported.report.watertight, mesh.is_watertight());
            }
            Err(error) => {
                let text = error.to_string();
                prop_assert!(text.starts_with(name) && !text.contains('\n') && text.len() < 1000, "{}", text);
            }
        }
    }
    Ok(())
}

/// One way to spoil a file: cut it, overwrite some bytes, or repeat a piece of it elsewhere.
fn spoil(bytes: &mut Vec<u8>, (kind, at, from, value): (u8, usize, usize, u64)) {
    if bytes.is_empty() {
        return;
    }
    let (at, from) = (at % bytes.len(), from % bytes.len());
    match kind {
        0 => bytes.truncate(at),
        1 => bytes[at] = value as u8,
        2 => {
            let end = (at + 4).min(bytes.len());
            bytes[at..end].copy_from_slice(&value.to_le_bytes()[..end - at]);
        }
        3 => {
            let piece = bytes[from..(from + value as usize % 64).min(bytes.len())].to_vec();
            bytes.splice(at..at, piece);
        }
        // A number in a text becomes another one.
        _ => {
            if let Some(digit) = (at..bytes.len()).find(|&i| bytes[i].is_ascii_digit()) {
                let numbers = ["-1", "99", "1e40", "4294967296", "nan", "", "0", "-99999999999999999999"];
                bytes.splice(digit..=digit, numbers[value as usize % numbers.len()].bytes());
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn any_bytes_are_survived(
        start in prop::sample::select(vec!["", "solid \n", "glTF\x02\0\0\0", "{\"asset\":", "v 0 0 0\nf ", "\0\0"]),
        rest in prop::collection::vec(any::<u8>(), 0..400),
    ) {
        survives(&[start.as_bytes(), &rest].concat())?;
    }

    #[test]
    fn spoiled_files_of_every_format_are_survived(
        format in 0..5_usize,
        spoils in prop::collection::vec((0..5_u8, any::<usize>(), any::<usize>(), any::<u64>()), 1..6),
    ) {
        let [.., (_, mut bytes)] = { let mut all = every_format(&part()); all.swap(format, 4); all };
        spoils.into_iter().for_each(|one| spoil(&mut bytes, one));
        survives(&bytes)?;
    }

    /// Triangle order, turned triangles, doubled triangles and the place of a closed body change nothing about it.
    #[test]
    fn a_disturbed_box_is_the_same_box(
        order in Just((0..12_usize).collect::<Vec<_>>()).prop_shuffle(),
        turned in prop::collection::vec(any::<bool>(), 12),
        doubled in prop::collection::vec(any::<bool>(), 12),
        place in prop::array::uniform3(-1000.0..1000.0_f64),
    ) {
        let part = part();
        let mut triangles: Vec<[u32; 3]> = order.iter().map(|&t| part.triangles[t]).collect();
        triangles.iter_mut().zip(turned).filter(|(_, turned)| *turned).for_each(|(t, _)| t.swap(0, 1));
        let copies: Vec<[u32; 3]> = triangles.iter().zip(doubled).filter(|(_, d)| *d).map(|(t, _)| *t).collect();
        triangles.extend(&copies);
        let disturbed = Mesh { triangles, ..part }.mapped(|p| p + DVec3::from_array(place));
        let imported = import(obj(&disturbed));
        prop_assert!(imported.report.watertight);
        prop_assert_eq!(imported.report.duplicates_removed, copies.len());
        prop_assert!((imported.mesh.volume() - 64.0 * 80.0 * 100.5).abs() < 1e-3);
        prop_assert!(imported.report.size_mm.abs_diff_eq(DVec3::new(64.0, 80.0, 100.5), 1e-9));
    }

    /// An inch is 25.4 mm, whatever the shape.
    #[test]
    fn inches_scale_by_25_4(corners in prop::collection::vec(prop::array::uniform3(-50.0..50.0_f64), 4)) {
        let vertices: Vec<DVec3> = corners.into_iter().map(DVec3::from_array).collect();
        let mesh = Mesh { vertices, triangles: vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]] };
        prop_assume!(mesh.volume().abs() > 1.0);
        let read = |units| import_with(obj(&mesh).as_bytes(), &ImportOptions { reading: Reading::whole(units), ..Default::default() }).unwrap();
        let (mm, inch) = (read(Units::Mm), read(Units::Inch));
        prop_assert!(mm.mesh.volume() > 0.0);
        prop_assert!((inch.mesh.volume() / mm.mesh.volume() - 25.4_f64.powi(3)).abs() < 1e-6);
        prop_assert_eq!(mm.sha256, inch.sha256);
    }
}
