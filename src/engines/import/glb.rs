//! Writing meshes as GLB, the binary form of glTF 2.0.

use std::io;

use glam::Vec3;
use serde_json::{Value, json};

use geometry::mesh::Mesh;

/// `glTF`, as a little-endian number.
const MAGIC: u32 = 0x4654_6c67;
/// `JSON` and `BIN\0`, as little-endian numbers.
const CHUNKS: [u32; 2] = [0x4e4f_534a, 0x004e_4942];
/// Numbers by which the format names what an array is for and what it holds.
const ARRAY_BUFFER: u32 = 34962;
const ELEMENT_ARRAY_BUFFER: u32 = 34963;
const FLOAT: u32 = 5126;
const UNSIGNED_INT: u32 = 5125;
/// From millimetres with Z up to the format's metres with Y up, column by column.
const PLACED: [f64; 16] = [1e-3, 0.0, 0.0, 0.0, 0.0, 0.0, -1e-3, 0.0, 0.0, 1e-3, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0];

/// Named meshes (mm, Z up) as the bytes of a GLB file: a node for each. Coordinates stay in millimetres, rounded to
/// `f32`; the nodes turn them into the format's metres with Y up.
///
/// # Errors
/// `InvalidInput` for a mesh without triangles, coordinates beyond `f32`, vertex numbers without a vertex, or more than
/// the format can count.
pub fn glb_bytes(parts: &[(&str, &Mesh)]) -> io::Result<Vec<u8>> {
    let mut file = Content::default();
    for (name, mesh) in parts {
        file.add(name, mesh)?;
    }
    if parts.is_empty() {
        return Err(invalid("a glTF file needs a mesh"));
    }
    let mut json = serde_json::to_vec(&file.document())?;
    json.resize(json.len().next_multiple_of(4), b' ');
    let length = 12 + 8 + json.len() + 8 + file.binary.len();
    let mut bytes = Vec::with_capacity(length);
    [MAGIC, 2, counted(length)?].iter().for_each(|n| bytes.extend(n.to_le_bytes()));
    for (chunk, kind) in [&json, &file.binary].into_iter().zip(CHUNKS) {
        [counted(chunk.len())?, kind].iter().for_each(|n| bytes.extend(n.to_le_bytes()));
        bytes.extend(chunk);
    }
    Ok(bytes)
}

#[derive(Default)]
struct Content {
    /// Always a multiple of four bytes, as all that goes in has four.
    binary: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
    meshes: Vec<Value>,
    nodes: Vec<Value>,
}

impl Content {
    fn add(&mut self, name: &str, mesh: &Mesh) -> io::Result<()> {
        if mesh.triangles.is_empty() {
            return Err(invalid("a mesh without triangles makes no glTF file"));
        }
        if mesh.triangles.iter().flatten().any(|&v| v as usize >= mesh.vertices.len()) {
            return Err(invalid("a triangle refers to a vertex that does not exist"));
        }
        let points: Vec<Vec3> = mesh.vertices.iter().map(|p| p.as_vec3()).collect();
        if !points.iter().all(|p| p.is_finite()) {
            return Err(invalid("a coordinate is not finite or too large for a glTF file"));
        }
        let (low, high) = points.iter().fold((points[0], points[0]), |(l, h), p| (l.min(*p), h.max(*p)));
        let coordinates = points.iter().flat_map(|p| p.to_array()).flat_map(f32::to_le_bytes);
        let view = self.view(coordinates, ARRAY_BUFFER)?;
        let position = self.accessors.len();
        self.accessors.push(json!({
            "bufferView": view, "componentType": FLOAT, "count": points.len(), "type": "VEC3",
            "min": low.to_array(), "max": high.to_array(),
        }));
        let view = self.view(mesh.triangles.iter().flatten().flat_map(|v| v.to_le_bytes()), ELEMENT_ARRAY_BUFFER)?;
        let indices = self.accessors.len();
        let count = 3 * mesh.triangles.len();
        self.accessors
            .push(json!({"bufferView": view, "componentType": UNSIGNED_INT, "count": count, "type": "SCALAR"}));
        let primitive = json!({"attributes": {"POSITION": position}, "indices": indices, "mode": 4});
        self.nodes.push(json!({"name": name, "mesh": self.meshes.len(), "matrix": PLACED}));
        self.meshes.push(json!({"name": name, "primitives": [primitive]}));
        Ok(())
    }

    fn view(&mut self, content: impl Iterator<Item = u8>, target: u32) -> io::Result<usize> {
        let offset = self.binary.len();
        self.binary.extend(content);
        let length = counted(self.binary.len())? as usize - offset;
        self.views.push(json!({"buffer": 0, "byteOffset": offset, "byteLength": length, "target": target}));
        Ok(self.views.len() - 1)
    }

    fn document(&self) -> Value {
        let nodes: Vec<usize> = (0..self.nodes.len()).collect();
        json!({
            "asset": {"version": "2.0", "generator": "sparkpath"},
            "scene": 0,
            "scenes": [{"nodes": nodes}],
            "nodes": self.nodes,
            "meshes": self.meshes,
            "accessors": self.accessors,
            "bufferViews": self.views,
            "buffers": [{"byteLength": self.binary.len()}],
        })
    }
}

fn counted(bytes: usize) -> io::Result<u32> {
    u32::try_from(bytes).map_err(|_| invalid("the mesh is too large for a glTF file"))
}

fn invalid(problem: &str) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidInput, problem.to_owned())
}

#[cfg(test)]
mod tests {
    use glam::{DVec3, Mat4};

    use super::*;

    #[test]
    fn another_reader_finds_the_same_triangles_and_the_node_makes_them_metres_with_y_up() {
        let first = Mesh::cuboid(DVec3::new(2.0, 3.0, 40.0));
        let second = first.mapped(|p| p - DVec3::new(0.1, 7.0, 5.5));
        let bytes = glb_bytes(&[("E01", &first), ("a \"name\"", &second)]).unwrap();
        // The crate checks the document against the format while it reads.
        let (document, buffers, _) = gltf::import_slice(&bytes).unwrap();
        assert_eq!(document.scenes().next().unwrap().nodes().count(), 2);
        let names = ["E01", "a \"name\""];
        for ((node, mesh), name) in document.nodes().zip([&first, &second]).zip(names) {
            assert_eq!(node.name(), Some(name));
            let primitive = node.mesh().unwrap().primitives().next().unwrap();
            let reader = primitive.reader(|b| Some(&buffers[b.index()].0[..]));
            let points: Vec<Vec3> = reader.read_positions().unwrap().map(Vec3::from).collect();
            let indices: Vec<u32> = reader.read_indices().unwrap().into_u32().collect();
            assert_eq!(points, mesh.vertices.iter().map(|p| p.as_vec3()).collect::<Vec<_>>());
            assert_eq!(indices, mesh.triangles.concat());
            let bounds = primitive.bounding_box();
            assert_eq!(Vec3::from(bounds.min), mesh.bounds().min.as_vec3());
            assert_eq!(Vec3::from(bounds.max), mesh.bounds().max.as_vec3());
            let placed = Mat4::from_cols_array_2d(&node.transform().matrix());
            let [x, y, z] = [Vec3::X, Vec3::Y, Vec3::Z].map(|p| placed.transform_point3(p * 1000.0));
            assert!(x.distance(Vec3::X) < 1e-6 && y.distance(Vec3::NEG_Z) < 1e-6 && z.distance(Vec3::Y) < 1e-6);
        }
    }

    #[test]
    fn what_is_no_mesh_is_refused() {
        let mesh = Mesh::cuboid(DVec3::ONE);
        let open = Mesh { vertices: mesh.vertices[..7].to_vec(), ..mesh.clone() };
        let far = mesh.mapped(|p| p * 1e39);
        for wrong in [&Mesh::default(), &open, &far] {
            assert_eq!(glb_bytes(&[("x", wrong)]).unwrap_err().kind(), io::ErrorKind::InvalidInput);
        }
        assert!(glb_bytes(&[]).is_err());
    }
}
