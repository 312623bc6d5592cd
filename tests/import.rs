//! Mesh files on their way in: ordinary, odd and hostile ones, all made here.

use std::fs;
use std::path::Path;

use glam::DVec3;
use proptest::prelude::*;
use sparkpath::geometry::mesh::Mesh;
use sparkpath::mesh_io::{
    Format, ImportError, ImportLimits, ImportOptions, Imported, Unit, Units, import_bytes, import_file, write_stl,
};
use sparkpath::progress::{Cancel, Progress};

// ---- Files ----

/// The box `[0, size]` with outward triangles.
fn cuboid(size: DVec3) -> Mesh {
    let vertices =
        (0..8).map(|i| size * DVec3::new((i & 1) as f64, (i >> 1 & 1) as f64, (i >> 2 & 1) as f64)).collect();
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    Mesh { vertices, triangles }
}

/// A box of a size that tells its axes apart and is exact in `f32`.
fn part() -> Mesh {
    cuboid(DVec3::new(64.0, 80.0, 100.5))
}

fn binary_stl(mesh: &Mesh, title: &str) -> Vec<u8> {
    let mut bytes = title.as_bytes().to_vec();
    bytes.resize(80, b' ');
    bytes.extend((mesh.triangles.len() as u32).to_le_bytes());
    for corners in mesh.iter_corners() {
        bytes.extend([0; 12]);
        bytes.extend(corners.iter().flat_map(|p| p.to_array()).flat_map(|x| (x as f32).to_le_bytes()));
        bytes.extend([0; 2]);
    }
    bytes
}

fn ascii_stl(mesh: &Mesh) -> String {
    let mut text = "solid part\n".to_owned();
    for corners in mesh.iter_corners() {
        text.push_str("  facet normal 0 0 0\n    outer loop\n");
        corners.iter().for_each(|p| text.push_str(&format!("      vertex {:e} {:e} {:e}\n", p.x, p.y, p.z)));
        text.push_str("    endloop\n  endfacet\n");
    }
    text + "endsolid part\n"
}

fn obj(mesh: &Mesh) -> String {
    let vertices = mesh.vertices.iter().map(|p| format!("v {} {} {}\n", p.x, p.y, p.z));
    let faces = mesh.triangles.iter().map(|[a, b, c]| format!("f {}/1/1 {}//2 {}\n", a + 1, b + 1, c + 1));
    vertices.chain(faces).collect()
}

/// Positions, then indices, as glTF wants them.
fn gltf_buffer(mesh: &Mesh) -> Vec<u8> {
    let positions = mesh.vertices.iter().flat_map(|p| p.to_array()).flat_map(|x| (x as f32).to_le_bytes());
    positions.chain(mesh.triangles.iter().flatten().flat_map(|v| v.to_le_bytes())).collect()
}

/// A document for [`gltf_buffer`]; `uri` and `node` are pieces of JSON.
fn gltf_json(mesh: &Mesh, uri: &str, node: &str) -> String {
    let (points, corners) = (mesh.vertices.len(), 3 * mesh.triangles.len());
    let (split, all) = (12 * points, 12 * points + 4 * corners);
    format!(
        r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0]}}],"nodes":[{{"mesh":0{node}}}],
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}},"indices":1}}]}}],
        "accessors":[{{"bufferView":0,"componentType":5126,"count":{points},"type":"VEC3"}},
                     {{"bufferView":1,"componentType":5125,"count":{corners},"type":"SCALAR"}}],
        "bufferViews":[{{"buffer":0,"byteLength":{split}}},
                       {{"buffer":0,"byteOffset":{split},"byteLength":{}}}],
        "buffers":[{{"byteLength":{all}{uri}}}]}}"#,
        all - split
    )
}

fn base64(bytes: &[u8]) -> String {
    const DIGITS: &[u8] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let quad = |three: &[u8]| {
        let n = (0..3).fold(0_usize, |n, i| n << 8 | usize::from(*three.get(i).unwrap_or(&0)));
        (0..4).map(|i| if i > three.len() { '=' } else { DIGITS[n >> (18 - 6 * i) & 63] as char }).collect::<String>()
    };
    bytes.chunks(3).map(quad).collect()
}

fn gltf(mesh: &Mesh, node: &str) -> String {
    let uri = format!(r#","uri":"data:application/octet-stream;base64,{}""#, base64(&gltf_buffer(mesh)));
    gltf_json(mesh, &uri, node)
}

fn glb(json: &str, buffer: &[u8]) -> Vec<u8> {
    let mut json = json.as_bytes().to_vec();
    json.resize(json.len().next_multiple_of(4), b' ');
    let mut bytes = b"glTF\x02\0\0\0".to_vec();
    bytes.extend((28 + json.len() as u32 + buffer.len() as u32).to_le_bytes());
    bytes.extend((json.len() as u32).to_le_bytes());
    bytes.extend(b"JSON");
    bytes.extend(json);
    bytes.extend((buffer.len() as u32).to_le_bytes());
    bytes.extend(b"BIN\0");
    bytes.extend(buffer);
    bytes
}

/// The same mesh in every format.
fn every_format(mesh: &Mesh) -> [(Format, Vec<u8>); 5] {
    [
        (Format::StlBinary, binary_stl(mesh, "part")),
        (Format::StlAscii, ascii_stl(mesh).into_bytes()),
        (Format::Obj, obj(mesh).into_bytes()),
        (Format::Gltf, gltf(mesh, "").into_bytes()),
        (Format::Glb, glb(&gltf_json(mesh, "", ""), &gltf_buffer(mesh))),
    ]
}

// ---- Ways in ----

fn import_with(bytes: &[u8], options: &ImportOptions) -> Result<Imported, ImportError> {
    import_bytes("part.mesh", bytes, options, &Progress::silent(), &Cancel::default())
}

fn import(bytes: impl AsRef<[u8]>) -> Imported {
    import_with(bytes.as_ref(), &ImportOptions { units: Units::Mm, ..Default::default() }).unwrap()
}

/// The error for bytes that must be refused, which must be one line that names the file.
fn refusal(bytes: impl AsRef<[u8]>) -> String {
    let error = import_with(bytes.as_ref(), &ImportOptions::default()).unwrap_err();
    let text = error.to_string();
    assert!(text.starts_with("part.mesh: ") && !text.contains('\n'), "{text}");
    text
}

fn assert_mentions(text: &str, words: &[&str]) {
    for word in words {
        assert!(text.contains(word), "no \"{word}\" in: {text}");
    }
}

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
    let imported = import_file(&path, &ImportOptions::default(), &Progress::silent(), &Cancel::default()).unwrap();
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
        let options = ImportOptions { units: Units::Mm, ..Default::default() };
        import_file(&path, &options, &Progress::silent(), &Cancel::default())
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

    let given = ImportOptions { units: Units::Um, ..Default::default() };
    assert_eq!(height(&import_with(&binary_stl(&part(), ""), &given).unwrap()), 0.1005);
}

#[test]
fn coordinates_farther_than_a_kilometre_are_refused() {
    let far = part().mapped(|p| if p.z > 0.0 { p * 1e7 } else { p });
    let options = ImportOptions { units: Units::Mm, ..Default::default() };
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
        let bounds = sparkpath::geometry::mesh::Bounds::of(corners).grown(1e-9);
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
    let exact = ImportOptions { units: Units::Mm, weld_tolerance_mm: Some(0.0), ..Default::default() };
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
fn two_boxes_on_a_common_edge_are_two_parts_and_a_branching_edge() {
    let mut both = part();
    let other = cuboid(DVec3::new(-64.0, -80.0, 100.5)).triangles;
    let vertices: Vec<DVec3> = cuboid(DVec3::new(-64.0, -80.0, 100.5)).vertices;
    both.triangles.extend(other.iter().map(|t| t.map(|v| v + 8)));
    both.vertices.extend(vertices);
    let report = import(obj(&both)).report;
    assert_eq!((report.components, report.non_manifold_edges, report.watertight), (2, 1, false));
    assert_eq!(report.non_manifold_places_mm, [DVec3::new(0.0, 0.0, 50.25)]);
    assert!((report.volume_mm3 - 2.0 * 64.0 * 80.0 * 100.5).abs() < 1e-6);
}

// ---- Bad files ----

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
    let text = import_bytes("part.stl", &stl, &ImportOptions::default(), &Progress::silent(), &Cancel::default());
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
    let text = import_bytes("cut.stl", &stl[..300], &ImportOptions::default(), &Progress::silent(), &Cancel::default());
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
        let error = import_file(path, &ImportOptions::default(), &Progress::silent(), &Cancel::default());
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
        let result = import_bytes("part", &bytes, &ImportOptions::default(), &Progress::silent(), &cancel);
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

// ---- Laws ----

/// Whatever the bytes, the answer is a sound mesh or one line; under limits that keep the test small.
fn survives(bytes: &[u8]) -> Result<(), TestCaseError> {
    let limits = ImportLimits { max_memory_bytes: 64 << 20, ..Default::default() };
    let options = ImportOptions { limits, ..Default::default() };
    for name in ["x", "x.stl", "x.obj", "x.gltf"] {
        match import_bytes(name, bytes, &options, &Progress::silent(), &Cancel::default()) {
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
        let read = |units| import_with(obj(&mesh).as_bytes(), &ImportOptions { units, ..Default::default() }).unwrap();
        let (mm, inch) = (read(Units::Mm), read(Units::Inch));
        prop_assert!(mm.mesh.volume() > 0.0);
        prop_assert!((inch.mesh.volume() / mm.mesh.volume() - 25.4_f64.powi(3)).abs() < 1e-6);
        prop_assert_eq!(mm.sha256, inch.sha256);
    }
}
