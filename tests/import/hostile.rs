//! Files that lie, break off or are no meshes.

use std::path::Path;

use geometry::mesh::Mesh;
use glam::DVec3;
use import::{ImportError, ImportLimits, ImportOptions, import_bytes, import_file};
use task::{Cancel, Task};

use super::files::*;

#[test]
fn numbers_that_are_none_are_refused_with_their_place() {
    let mut part = part();
    part.vertices[7] = DVec3::new(1.0, f64::NAN, 0.0);
    assert_mentions(&refusal(binary_stl(&part, "")), &["triangle 3", "finite"]);
    assert_mentions(&refusal(ascii_stl(&part)), &["line 20", "finite"]);
    assert_mentions(&refusal(obj(&part)), &["line 8", "finite"]);
    assert_mentions(&refusal(gltf(&part, "")), &["mesh 0, primitive 0, vertex 7", "finite"]);
    assert_mentions(&refusal("v 0 0 0\nv 1,5 0 0\n"), &["line 2", "1,5"]);
    assert_mentions(&refusal("v 0 0 0\nv 1e999 0 0\n"), &["line 2", "finite"]);
}

#[test]
fn lying_lengths_are_refused_by_arithmetic() {
    let mut stl = binary_stl(&part(), "solid?");
    stl.truncate(184);
    stl[80..84].copy_from_slice(&u32::MAX.to_le_bytes());
    let text = import_bytes("part.stl", &stl, &ImportOptions::default(), &Task::default());
    assert_mentions(&text.unwrap_err().to_string(), &["4294967295 triangles", "214748364834 bytes", "184"]);

    let json = gltf(&part(), "");
    for (honest, lie) in [
        (r#""count":8"#, r#""count":9"#),
        (r#""count":8"#, r#""count":18446744073709551615"#),
        (r#""count":36"#, r#""count":4000000000"#),
        (r#""byteOffset":96"#, r#""byteOffset":18446744073709551615"#),
        (r#""byteLength":144"#, r#""byteLength":18446744073709551615"#),
        (r#""byteLength":240"#, r#""byteLength":4000000000"#),
        (r#""bufferView":1"#, r#""bufferView":7"#),
        (r#""buffer":0"#, r#""buffer":3"#),
        (r#""POSITION":0"#, r#""POSITION":5"#),
        (r#""mesh":0"#, r#""mesh":4"#),
        (r#""nodes":[0]"#, r#""nodes":[9]"#),
        (r#""nodes":[0]"#, r#""nodes":[0,0]"#),
        (r#""scene":0"#, r#""scene":2"#),
        (r#""mesh":0"#, r#""mesh":0,"children":[0]"#),
        (r#""type":"VEC3""#, r#""type":"VEC2""#),
        (r#""componentType":5126"#, r#""componentType":5123"#),
    ] {
        assert!(json.contains(honest), "{honest}");
        refusal(json.replace(honest, lie));
    }

    let glb = glb(&gltf_json(&part(), "", ""), &gltf_buffer(&part()));
    for at in [8, 12] {
        let mut lie = glb.clone();
        lie[at..at + 4].copy_from_slice(&u32::MAX.to_le_bytes());
        assert_mentions(&refusal(lie), &["GLB"]);
    }
    assert_mentions(&refusal("v 0 0 0\nf 1 1 2\n"), &["line 2", "vertex 2"]);
    assert_mentions(&refusal("v 0 0 0\nf 1 -9 -9223372036854775808\n"), &["line 2", "vertex -9"]);
}

#[test]
fn required_extensions_that_change_the_mesh_are_refused_by_name() {
    let with = |name: &str| gltf(&part(), "").replacen('{', &format!(r#"{{"extensionsRequired":["{name}"],"#), 1);
    assert_mentions(&refusal(with("KHR_draco_mesh_compression")), &["KHR_draco_mesh_compression", "compression"]);
    assert_eq!(import(with("KHR_materials_unlit")).report.triangles, 12);
}

#[test]
fn limits_hold() {
    let part = part();
    let few = ImportLimits { max_triangles: 11, ..Default::default() };
    let small = ImportLimits { max_file_bytes: 100, ..Default::default() };
    let lean = ImportLimits { max_memory_bytes: 1000, ..Default::default() };
    for (limits, word) in [(few, "max_triangles"), (small, "max_file_bytes"), (lean, "max_memory_bytes")] {
        let options = ImportOptions { limits, ..Default::default() };
        let text = import_with(&binary_stl(&part, ""), &options).unwrap_err().to_string();
        assert_mentions(&text, &["part.mesh", word]);
    }
    // Text does not say how many triangles it holds; the limit is kept all the same, to within a thousand.
    let mut many = obj(&part);
    (0..3000).for_each(|_| many.push_str("f 1 2 3 4 5 6 7 8\n"));
    let options = ImportOptions { limits: ImportLimits { max_triangles: 5000, ..few }, ..Default::default() };
    assert_mentions(&import_with(many.as_bytes(), &options).unwrap_err().to_string(), &["max_triangles"]);
}

#[test]
fn truncated_files_say_so() {
    let part = part();
    let stl = binary_stl(&part, "");
    let text = import_bytes("cut.stl", &stl[..300], &ImportOptions::default(), &Task::default());
    assert_mentions(&text.unwrap_err().to_string(), &["cut.stl", "cut off"]);
    let text = ascii_stl(&part);
    let within = text.find("vertex").unwrap() + text[text.find("vertex").unwrap()..].find('\n').unwrap();
    assert_mentions(&refusal(&text[..within]), &["cut off"]);
    assert_mentions(&refusal(&gltf(&part, "")[..200]), &["JSON line"]);
    assert_mentions(&refusal(&glb(&gltf_json(&part, "", ""), &gltf_buffer(&part))[..300]), &["GLB header"]);
}

#[test]
fn nothing_is_no_mesh() {
    assert_mentions(&refusal(""), &["empty", "STL"]);
    assert_mentions(&refusal("solid nothing\nendsolid nothing\n"), &["no triangles"]);
    assert_mentions(&refusal("v 0 0 0\nv 1 0 0\n"), &["no triangles"]);
    assert_mentions(&refusal("v 0 0 0\nv 1 0 0\nf 1 2 1\n"), &["no triangles"]);
    assert_mentions(&refusal(r#"{"asset":{"version":"2.0"}}"#), &["no triangles"]);
    assert_mentions(&refusal(binary_stl(&Mesh::default(), "")), &["no triangles"]);
    let mut png = b"\x89PNG\r\n\x1a\n".to_vec();
    png.resize(500, 0xff);
    assert_mentions(&refusal(png), &["no known mesh format", "glTF"]);
}

#[test]
fn folders_and_missing_files_are_errors() {
    let folder = tempfile::tempdir().unwrap();
    let import = |path: &Path| {
        let error = import_file(path, &ImportOptions::default(), &Task::default());
        error.unwrap_err().to_string()
    };
    assert_mentions(&import(folder.path()), &["a folder"]);
    assert_mentions(&import(&folder.path().join("none.stl")), &["none.stl", "cannot be read"]);
}

#[test]
fn a_cancelled_import_stops() {
    let cancel = Cancel::default();
    cancel.cancel();
    for (format, bytes) in every_format(&part()) {
        let result = import_bytes("part", &bytes, &ImportOptions::default(), &Task::silent(&cancel));
        assert!(matches!(result, Err(ImportError::Cancelled(_))), "{format:?}");
    }
}

#[test]
fn senseless_options_are_refused() {
    for tolerance in [-1.0, f64::NAN, 1e-300, 100.0] {
        let options = ImportOptions { weld_tolerance_mm: Some(tolerance), ..Default::default() };
        let result = import_with(&binary_stl(&part(), ""), &options);
        assert!(matches!(result, Err(ImportError::BadOption { .. })), "{tolerance}");
    }
}
