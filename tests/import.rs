//! Mesh files on their way in: ordinary, odd and hostile ones, all made here.

#[path = "import/files.rs"]
mod files;
#[path = "import/hostile.rs"]
mod hostile;
#[path = "import/laws.rs"]
mod laws;
#[path = "common/mesh_files.rs"]
mod mesh_files;

use std::fs;

use files::*;
use geometry::mesh::{Bounds, Mesh};
use glam::DVec3;
use import::{Format, ImportOptions, Imported, Unit, Units, import_file, write_stl};
use task::Task;

// ---- Ordinary files ----

#[test]
fn every_format_gives_the_same_mesh() {
    let part = part();
    for (format, bytes) in every_format(&part) {
        let imported = import(&bytes);
        assert_eq!(imported.report.format, format);
        assert_eq!(imported.mesh.vertices.len(), 8);
        let corners: Vec<[DVec3; 3]> = imported.mesh.iter_corners().collect();
        assert_eq!(corners, part.iter_corners().collect::<Vec<_>>(), "{format:?}");
        assert_eq!(imported.mesh, import(binary_stl(&part, "")).mesh, "{format:?}");
        let report = imported.report;
        assert!(report.watertight && imported.mesh.is_watertight());
        assert_eq!((report.triangles_read, report.triangles, report.vertices), (12, 12, 8));
        assert_eq!((report.components, report.hole_count, report.non_manifold_edges), (1, 0, 0));
        assert!((report.volume_mm3 - 64.0 * 80.0 * 100.5).abs() < 1e-6);
        assert_eq!(report.warnings, [""; 0]);
    }
}

#[test]
fn the_hash_is_that_of_the_file() {
    // The digest as sha256sum gives it.
    let imported = import("v 0 0 0\nv 30 0 0\nv 0 30 0\nf 1 2 3\n");
    assert_eq!(imported.sha256, "7d5a0ed62edb7feb4e92e9c3cec38f6efe960d64936fb059958096e751a0b161");
}

#[test]
fn what_is_written_reads_back() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("part.stl");
    write_stl(&path, &part()).unwrap();
    let bytes = fs::read(&path).unwrap();
    assert_eq!(bytes.len(), 84 + 50 * 12);
    assert!(!bytes.to_ascii_lowercase().starts_with(b"solid"));
    // The normal of the first triangle, which lies in the plane z = 0.
    assert_eq!(bytes[84..96], [0.0_f32, 0.0, -1.0].map(f32::to_le_bytes).concat());
    let imported = import_file(&path, &ImportOptions::default(), &Task::default()).unwrap();
    assert_eq!(imported.mesh, import(binary_stl(&part(), "")).mesh);
    assert!(imported.report.unit_certain, "the header says that it is in millimetres");

    let nowhere = Mesh { vertices: vec![DVec3::NAN; 3], triangles: vec![[0, 1, 2]] };
    assert!(write_stl(&path, &nowhere).is_err());
    let missing = Mesh { vertices: vec![DVec3::ZERO; 3], triangles: vec![[0, 1, 3]] };
    assert!(write_stl(&path, &missing).is_err());
    assert_eq!(fs::read(&path).unwrap(), bytes, "a refused mesh must leave the former file");
}

#[test]
fn a_binary_file_may_begin_with_solid_and_end_in_strays() {
    let mut bytes = binary_stl(&part(), "solid part made by somebody");
    assert_eq!(import(&bytes).report.format, Format::StlBinary);
    bytes.extend(b"stray");
    bytes[..5].copy_from_slice(b"SOLAR");
    let imported = import(&bytes);
    assert_mentions(&imported.report.warnings.join(" "), &["5 bytes"]);
    assert_eq!(imported.mesh, import(binary_stl(&part(), "")).mesh);
}

#[test]
fn ascii_stl_is_read_in_any_case_and_spacing_and_with_several_solids() {
    let wanted = import(binary_stl(&part(), "")).mesh;
    let text = ascii_stl(&part());
    let middle = text.match_indices("  facet").nth(5).unwrap().0;
    let (front, back) = text.split_at(middle);
    for variant in [
        text.to_uppercase(),
        text.replace('\n', "\r\n"),
        text.replace('\n', "\r"),
        format!("\u{feff} \n\t{text}").replace(' ', "  \t "),
        format!("{front}endsolid\nsolid second facet\n{back}"),
    ] {
        assert_eq!(import(&variant).mesh, wanted, "{}", &variant[..60]);
    }
}

#[test]
fn obj_faces_may_be_polygons_and_count_backwards() {
    let part = part();
    let vertices: String = part.vertices.iter().map(|p| format!("v {} {} {}\n", p.x, p.y, p.z)).collect();
    let quads = "f 1 3 4 2\nf -4 -3 -1 -2\nf 1/7 2/8 6 5\nf 3 7 8 4\nf 1 5 7 3\nl 1 2\nf 1 2\nf 2//1 4//1 8//1 6//1\n";
    let imported = import(format!("mtllib none.mtl\no part\nusemtl red\n{vertices}s off\n{quads}"));
    assert_eq!(imported.mesh, import(obj(&part)).mesh);
    assert_mentions(&imported.report.warnings.join(" "), &["1 face of"]);
    for variant in [obj(&part).replace('\n', "\r\n"), obj(&part).replace('\n', "\r"), format!("\u{feff}{}", obj(&part))]
    {
        assert_eq!(import(variant).mesh, imported.mesh);
    }
}

#[test]
fn gltf_nodes_place_their_meshes_and_mirrors_keep_the_outside() {
    let part = part();
    let turn = std::f64::consts::FRAC_1_SQRT_2;
    // A quarter turn about z, then a shift; and a mirror image in x.
    let turned = format!(r#","translation":[5,0,0],"rotation":[0,0,{turn},{turn}]"#);
    let imported = import(gltf(&part, &turned));
    let bounds = imported.mesh.bounds();
    assert!(bounds.min.abs_diff_eq(DVec3::new(-75.0, 0.0, 0.0), 1e-4), "{}", bounds.min);
    assert!(bounds.max.abs_diff_eq(DVec3::new(5.0, 64.0, 100.5), 1e-4), "{}", bounds.max);

    for mirror in [r#","scale":[-1,1,1]"#, r#","matrix":[-1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1]"#] {
        let imported = import(gltf(&part, mirror));
        assert_eq!(imported.mesh.bounds().min.x, -64.0);
        assert!(imported.mesh.volume() > 0.0);
        assert!(!imported.report.turned_inside_out, "a mirrored node must come out right by itself");
    }
}

#[test]
fn gltf_strips_and_fans_are_triangles_and_lines_are_not() {
    // One square each: as a strip, as a fan, and as a line that is skipped.
    let points = [[0.0, 0.0], [40.0, 0.0], [0.0, 40.0], [40.0, 40.0]].map(|[x, y]| DVec3::new(x, y, 0.0));
    let buffer: Vec<u8> = points.iter().flat_map(|p| p.to_array()).flat_map(|x| (x as f32).to_le_bytes()).collect();
    for (mode, order, area) in [(5, [0, 1, 2, 3], 1600.0), (6, [0, 1, 3, 2], 1600.0), (4, [0, 1, 2, 3], 800.0)] {
        let all = [buffer.as_slice(), order.as_slice()].concat();
        let json = format!(
            r#"{{"asset":{{"version":"2.0"}},"buffers":[{{"byteLength":52}}],
            "bufferViews":[{{"buffer":0,"byteLength":48}},{{"buffer":0,"byteOffset":48,"byteLength":4}}],
            "accessors":[{{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3"}},
                         {{"bufferView":1,"componentType":5121,"count":4,"type":"SCALAR"}}],
            "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}},"indices":1,"mode":{mode}}},
                                      {{"attributes":{{"POSITION":0}},"mode":1}}]}}]}}"#
        );
        let imported = import(glb(&json, &all));
        let normals: Vec<f64> = imported.mesh.iter_corners().map(|[a, b, c]| (b - a).cross(c - a).z).collect();
        assert!(normals.iter().all(|&z| z == 1600.0), "mode {mode}: {normals:?}");
        assert_eq!(imported.mesh.area(), area);
        assert_mentions(&imported.report.warnings.join(" "), &["1 group of points or lines"]);
    }
}

#[test]
fn gltf_buffers_come_from_the_same_folder_only() {
    let folder = tempfile::tempdir().unwrap();
    let (part, inner) = (part(), folder.path().join("inner"));
    fs::create_dir(&inner).unwrap();
    fs::write(inner.join("my part.bin"), gltf_buffer(&part)).unwrap();
    fs::write(folder.path().join("secret.bin"), gltf_buffer(&part)).unwrap();
    let path = inner.join("part.gltf");
    let import_with_uri = |uri: &str| {
        fs::write(&path, gltf_json(&part, &format!(r#","uri":"{uri}""#), "")).unwrap();
        let options = ImportOptions { reading: Units::Mm.into(), ..Default::default() };
        import_file(&path, &options, &Task::default())
    };
    assert_eq!(import_with_uri("my%20part.bin").unwrap().mesh, import(binary_stl(&part, "")).mesh);
    let absolute = folder.path().join("secret.bin").display().to_string();
    for uri in ["../secret.bin", "..%2fsecret.bin", &absolute, "http://there/part.bin", "none.bin", "."] {
        let text = import_with_uri(uri).unwrap_err().to_string();
        assert_mentions(&text, &["part.gltf", "buffer 0", "GLB"]);
    }
    assert_mentions(&refusal(gltf_json(&part, r#","uri":"my%20part.bin""#, "")), &["did not come along"]);
}

// ---- Units ----

#[test]
fn units_are_guessed_given_or_declared() {
    let sized = |factor: f64| part().mapped(|p| p * factor);
    let auto = |bytes: &[u8]| import_with(bytes, &ImportOptions::default()).unwrap();
    let height = |imported: &Imported| imported.report.size_mm.z;

    let mm = auto(&binary_stl(&part(), ""));
    assert_eq!((mm.report.unit, mm.report.unit_certain, height(&mm)), (Unit::Mm, true, 100.5));

    let inches = auto(obj(&sized(1.0 / 25.4)).as_bytes());
    assert_eq!((inches.report.unit, inches.report.unit_certain), (Unit::Inch, false));
    assert!((height(&inches) - 100.5).abs() < 1e-9);
    assert_mentions(&inches.report.warnings.join(" "), &["inches", "guess"]);

    let metres = auto(gltf(&sized(1e-3), "").as_bytes());
    assert_eq!((metres.report.unit, metres.report.unit_certain), (Unit::M, true));
    assert!((height(&metres) - 100.5).abs() < 1e-4);

    let absurd = auto(gltf(&part(), "").as_bytes());
    assert_eq!((absurd.report.unit, absurd.report.unit_certain), (Unit::M, false));

    let declared = auto(format!("# units: cm\n{}", obj(&part())).as_bytes());
    assert_eq!((declared.report.unit, declared.report.unit_certain), (Unit::Cm, true));

    let given = ImportOptions { reading: Units::Um.into(), ..Default::default() };
    assert_eq!(height(&import_with(&binary_stl(&part(), ""), &given).unwrap()), 0.1005);
}

#[test]
fn coordinates_farther_than_a_kilometre_are_refused() {
    let far = part().mapped(|p| if p.z > 0.0 { p * 1e7 } else { p });
    let options = ImportOptions { reading: Units::Mm.into(), ..Default::default() };
    let text = import_with(&binary_stl(&far, ""), &options).unwrap_err().to_string();
    assert_mentions(&text, &["part.mesh", "triangle 3", "unit"]);
}

// ---- Repair ----

#[test]
fn a_missing_triangle_is_a_hole_with_its_place_and_length() {
    let mut open = part();
    let gone = open.triangles.remove(4);
    for (_, bytes) in every_format(&open) {
        let report = import(&bytes).report;
        assert_eq!((report.watertight, report.hole_count, report.triangles), (false, 1, 11));
        let corners = gone.map(|v| open.vertices[v as usize]);
        let sides = [corners[0].distance(corners[1]), corners[1].distance(corners[2]), corners[2].distance(corners[0])];
        let hole = &report.holes[0];
        assert_eq!(hole.edges, 3);
        assert!((hole.length_mm - sides.iter().sum::<f64>()).abs() < 1e-9);
        let bounds = Bounds::of(corners).grown(1e-9);
        assert!(hole.center_mm.cmpge(bounds.min).all() && hole.center_mm.cmple(bounds.max).all());
        assert_mentions(&report.warnings.join(" "), &["1 hole"]);
    }
}

#[test]
fn flipped_and_inside_out_meshes_are_turned() {
    let wanted = import(binary_stl(&part(), "")).mesh.volume();
    let mut flipped = part();
    flipped.triangles[3].swap(0, 1);
    let report = import(binary_stl(&flipped, "")).report;
    assert_eq!((report.triangles_flipped, report.turned_inside_out, report.watertight), (1, false, true));
    assert_eq!(report.volume_mm3, wanted);

    let mut inside_out = part();
    inside_out.triangles.iter_mut().for_each(|t| t.swap(0, 1));
    let report = import(binary_stl(&inside_out, "")).report;
    assert_eq!((report.triangles_flipped, report.turned_inside_out, report.watertight), (0, true, true));
    assert!((report.volume_mm3 - wanted).abs() < 1e-6);
}

#[test]
fn cracks_are_welded_but_a_closed_mesh_keeps_its_finest_edges() {
    // Each triangle with corners of its own, off by less than a ten-millionth of the size.
    let corners = part().iter_corners().flatten().collect::<Vec<_>>();
    let moved = corners.iter().enumerate().map(|(i, p)| *p + 1e-5 * DVec3::new((i as f64).sin(), 0.0, 0.0));
    let triangles = (0..12).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    let cracked = Mesh { vertices: moved.collect(), triangles };
    let report = import(obj(&cracked)).report;
    assert!(report.welded_within_tolerance && report.watertight);
    assert_eq!(report.vertices, 8);
    let exact = ImportOptions { reading: Units::Mm.into(), weld_tolerance_mm: Some(0.0), ..Default::default() };
    assert!(!import_with(obj(&cracked).as_bytes(), &exact).unwrap().report.watertight);

    // A corner drawn out to a second vertex nearer than the tolerance, with triangles between: closed as it is.
    let mut fine = part();
    fine.vertices.push(fine.vertices[7] + DVec3::new(0.0, 0.0, 1e-6));
    let hit: Vec<usize> = (0..12).filter(|&t| fine.triangles[t].contains(&7)).collect();
    let around: Vec<u32> = hit.iter().flat_map(|&t| fine.triangles[t]).filter(|&v| v != 7).collect();
    let first = around[0];
    let second = *around.iter().find(|&&v| v != first).unwrap();
    let between = fine.triangles[hit[0]];
    assert!(between.contains(&first) && between.contains(&second));
    // The triangle moves to the new vertex; two slim ones close the gap that it leaves.
    fine.triangles[hit[0]] = between.map(|v| if v == 7 { 8 } else { v });
    let at = between.iter().position(|&v| v == 7).unwrap();
    let (next, last) = (between[(at + 1) % 3], between[(at + 2) % 3]);
    fine.triangles.extend([[7, next, 8], [8, last, 7]]);
    assert!(fine.is_watertight());
    let report = import(obj(&fine)).report;
    assert!(report.watertight && !report.welded_within_tolerance);
    assert_eq!((report.vertices, report.triangles), (9, 14));
}

#[test]
fn collapsed_and_doubled_triangles_go_and_the_mesh_stays_closed() {
    let mut part = part();
    part.triangles.extend([[0, 0, 1], [2, 3, 2], part.triangles[6]]);
    let imported = import(obj(&part));
    let report = &imported.report;
    assert_eq!((report.triangles_read, report.degenerate_removed, report.duplicates_removed), (15, 2, 1));
    assert!(report.watertight && imported.mesh.is_watertight());
}

#[test]
fn two_boxes_on_a_common_edge_are_two_solids_that_touch() {
    let mut both = part();
    let other = cuboid(DVec3::new(-64.0, -80.0, 100.5)).triangles;
    let vertices: Vec<DVec3> = cuboid(DVec3::new(-64.0, -80.0, 100.5)).vertices;
    both.triangles.extend(other.iter().map(|t| t.map(|v| v + 8)));
    both.vertices.extend(vertices);
    let report = import(obj(&both)).report;
    assert_eq!((report.components, report.touching_edges, report.watertight), (2, 1, true));
    assert!(report.non_manifold_edges == 0 && report.non_manifold_places_mm.is_empty());
    assert!(report.warnings.iter().any(|warning| warning.contains("touch along 1 edge")), "{:?}", report.warnings);
    assert!((report.volume_mm3 - 2.0 * 64.0 * 80.0 * 100.5).abs() < 1e-6);
}
