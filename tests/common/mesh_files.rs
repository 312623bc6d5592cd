//! Mesh files made of a mesh.

use geometry::mesh::Mesh;
use glam::DVec3;
use import::Format;

/// The box `[0, size]` with outward triangles.
pub fn cuboid(size: DVec3) -> Mesh {
    let vertices =
        (0..8).map(|i| size * DVec3::new((i & 1) as f64, (i >> 1 & 1) as f64, (i >> 2 & 1) as f64)).collect();
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    Mesh { vertices, triangles }
}

/// A box of a size that tells its axes apart and is exact in `f32`.
pub fn part() -> Mesh {
    cuboid(DVec3::new(64.0, 80.0, 100.5))
}

pub fn binary_stl(mesh: &Mesh, title: &str) -> Vec<u8> {
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

pub fn ascii_stl(mesh: &Mesh) -> String {
    let mut text = "solid part\n".to_owned();
    for corners in mesh.iter_corners() {
        text.push_str("  facet normal 0 0 0\n    outer loop\n");
        corners.iter().for_each(|p| text.push_str(&format!("      vertex {:e} {:e} {:e}\n", p.x, p.y, p.z)));
        text.push_str("    endloop\n  endfacet\n");
    }
    text + "endsolid part\n"
}

pub fn obj(mesh: &Mesh) -> String {
    let vertices = mesh.vertices.iter().map(|p| format!("v {} {} {}\n", p.x, p.y, p.z));
    let faces = mesh.triangles.iter().map(|[a, b, c]| format!("f {}/1/1 {}//2 {}\n", a + 1, b + 1, c + 1));
    vertices.chain(faces).collect()
}

/// Positions, then indices, as glTF wants them.
pub fn gltf_buffer(mesh: &Mesh) -> Vec<u8> {
    let positions = mesh.vertices.iter().flat_map(|p| p.to_array()).flat_map(|x| (x as f32).to_le_bytes());
    positions.chain(mesh.triangles.iter().flatten().flat_map(|v| v.to_le_bytes())).collect()
}

/// A document for [`gltf_buffer`]; `uri` and `node` are pieces of JSON.
pub fn gltf_json(mesh: &Mesh, uri: &str, node: &str) -> String {
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

pub fn base64(bytes: &[u8]) -> String {
    const DIGITS: &[u8] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let quad = |three: &[u8]| {
        let n = (0..3).fold(0_usize, |n, i| n << 8 | usize::from(*three.get(i).unwrap_or(&0)));
        (0..4).map(|i| if i > three.len() { '=' } else { DIGITS[n >> (18 - 6 * i) & 63] as char }).collect::<String>()
    };
    bytes.chunks(3).map(quad).collect()
}

pub fn gltf(mesh: &Mesh, node: &str) -> String {
    let uri = format!(r#","uri":"data:application/octet-stream;base64,{}""#, base64(&gltf_buffer(mesh)));
    gltf_json(mesh, &uri, node)
}

pub fn glb(json: &str, buffer: &[u8]) -> Vec<u8> {
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

/// A mesh in every format.
pub fn every_format(mesh: &Mesh) -> [(Format, Vec<u8>); 5] {
    [
        (Format::StlBinary, binary_stl(mesh, "part")),
        (Format::StlAscii, ascii_stl(mesh).into_bytes()),
        (Format::Obj, obj(mesh).into_bytes()),
        (Format::Gltf, gltf(mesh, "").into_bytes()),
        (Format::Glb, glb(&gltf_json(mesh, "", ""), &gltf_buffer(mesh))),
    ]
}
