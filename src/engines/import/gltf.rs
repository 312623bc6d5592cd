//! glTF 2.0 and its binary form GLB: the triangles of the default scene, nodes placed as they say, in metres.
//!
//! The JSON is parsed by the `gltf` crate; every index, offset and length in it is checked here before use, as they
//! come from outside. Skins, morph targets, animations and everything that only concerns looks is skipped.

use glam::{DMat4, DQuat, DVec3};
use gltf::json::mesh::{Mode, Primitive, Semantic};
use gltf::json::scene::Node;
use gltf::json::validation::Checked;
use gltf::json::{Root, accessor};

use super::error::ImportError;
use super::gltf_buffers::{self, Buffers, REMEDY};
use super::source::{Content, Likeness, MeshFormat, RawMesh, Source, count};
use super::units::Unit;
use super::weld::weld_exact;

const UNIT: Option<(Unit, &str)> = Some((Unit::M, "the glTF standard"));
/// glTF 2.0 as JSON.
pub(super) static TEXT: MeshFormat = MeshFormat { name: "glTF", likeness: like_text, read, unit: UNIT };
/// glTF 2.0 in one binary file.
pub(super) static BINARY: MeshFormat = MeshFormat { name: "binary glTF", likeness: like_binary, read, unit: UNIT };

fn like_text(content: &Content) -> Likeness {
    let names_asset = || content.bytes.windows(7).any(|word| word == b"\"asset\"");
    let is_object = content.text.is_some_and(|text| text.starts_with(b"{"));
    Likeness::Likely.when(is_object && (content.ending == "gltf" || names_asset()))
}

fn like_binary(content: &Content) -> Likeness {
    Likeness::Certain.when(content.bytes.starts_with(b"glTF"))
}

/// Reads a glTF or GLB file.
fn read(source: &Source) -> Result<RawMesh, ImportError> {
    let container = gltf_buffers::split(source)?;
    // A two-byte element of an array can become a structure of some hundred bytes; objects are what costs.
    let objects = container.json.iter().filter(|&&b| b == b'{').count() as u64;
    source.limits.check_memory(source.name, objects * 1000 + container.json.len() as u64 * 8)?;
    let root: Root = serde_json::from_slice(container.json).map_err(|e| {
        let place = format!("JSON line {} column {}", e.line(), e.column());
        let text = e.to_string();
        let problem = text.split(" at line ").next().unwrap_or_default().replace(char::is_control, " ");
        source.malformed(place, problem, REMEDY)
    })?;
    refuse_unknown_extensions(source, &root)?;
    let buffers = Buffers::load(source, &root, container.binary)?;
    let mut reader =
        Reader { source, root: &root, buffers: &buffers, raw: RawMesh::default(), skipped: 0, posed: false };
    reader.read_scene()?;
    let mut raw = reader.finish();
    raw.mesh = weld_exact(raw.mesh, source.task)?;
    raw.warnings.extend(container.warning);
    raw.attachments = buffers.into_attachments();
    Ok(raw)
}

/// Extensions that change looks only, so that a mesh can be read without knowing them.
const ONLY_LOOKS: [&str; 4] = ["KHR_materials_", "KHR_texture_", "EXT_texture_", "KHR_lights_"];

fn refuse_unknown_extensions(source: &Source, root: &Root) -> Result<(), ImportError> {
    let unknown = |name: &&String| !ONLY_LOOKS.iter().any(|prefix| name.starts_with(prefix));
    let Some(name) = root.extensions_required.iter().find(unknown) else { return Ok(()) };
    let problem = format!("the extension {} is required but not supported", super::error::excerpt(name.as_bytes()));
    Err(source.malformed("extensionsRequired", problem, "export it again without compression or other extensions"))
}

struct Reader<'a> {
    source: &'a Source<'a>,
    root: &'a Root,
    buffers: &'a Buffers<'a>,
    raw: RawMesh,
    /// Primitives of points or lines.
    skipped: usize,
    /// Whether a skin or a morph target was left out.
    posed: bool,
}

impl Reader<'_> {
    fn finish(mut self) -> RawMesh {
        if self.skipped > 0 {
            self.raw.warnings.push(format!("{} of points or lines skipped.", count(self.skipped, "group")));
        }
        if self.posed {
            self.raw.warnings.push("Skins and morph targets were ignored: the mesh is in its rest pose.".to_owned());
        }
        self.raw
    }

    fn error(&self, place: String, problem: impl Into<String>) -> ImportError {
        self.source.malformed(place, problem, REMEDY)
    }

    /// Walks the node tree of the default scene, parents before children, in file order.
    fn read_scene(&mut self) -> Result<(), ImportError> {
        let root = self.root;
        let mut pending: Vec<(usize, DMat4)> = self.roots()?.into_iter().rev().map(|n| (n, DMat4::IDENTITY)).collect();
        let mut seen = vec![false; root.nodes.len()];
        while let Some((index, parent)) = pending.pop() {
            self.source.task.check()?;
            let place = || format!("node {index}");
            let Some(node) = root.nodes.get(index) else {
                return Err(self.error(place(), "does not exist but is referred to"));
            };
            if std::mem::replace(&mut seen[index], true) {
                return Err(self.error(place(), "is reached twice; nodes must form a tree"));
            }
            let transform = parent * local_transform(node);
            self.posed |= node.skin.is_some();
            if let Some(mesh) = node.mesh {
                self.read_mesh(mesh.value(), &transform)?;
            }
            let children = node.children.as_deref().unwrap_or_default();
            pending.extend(children.iter().rev().map(|child| (child.value(), transform)));
        }
        if root.nodes.is_empty() {
            for mesh in 0..root.meshes.len() {
                self.read_mesh(mesh, &DMat4::IDENTITY)?;
            }
        }
        Ok(())
    }

    /// The roots of the default scene, of the first one if none is the default, or every node without a parent.
    fn roots(&self) -> Result<Vec<usize>, ImportError> {
        let root = self.root;
        let chosen = root.scene.map(|scene| scene.value());
        match root.scenes.get(chosen.unwrap_or(0)) {
            Some(scene) => Ok(scene.nodes.iter().map(|n| n.value()).collect()),
            None if chosen.is_some() => Err(self.error("scene".to_owned(), "the default scene does not exist")),
            None => {
                let mut is_child = vec![false; root.nodes.len()];
                for child in root.nodes.iter().filter_map(|n| n.children.as_ref()).flatten() {
                    if let Some(flag) = is_child.get_mut(child.value()) {
                        *flag = true;
                    }
                }
                Ok((0..root.nodes.len()).filter(|&i| !is_child[i]).collect())
            }
        }
    }

    fn read_mesh(&mut self, index: usize, transform: &DMat4) -> Result<(), ImportError> {
        let root = self.root;
        let Some(mesh) = root.meshes.get(index) else {
            return Err(self.error(format!("mesh {index}"), "does not exist but a node refers to it"));
        };
        for (k, primitive) in mesh.primitives.iter().enumerate() {
            self.source.task.check()?;
            self.posed |= primitive.targets.is_some();
            let place = format!("mesh {index}, primitive {k}");
            match primitive.mode {
                Checked::Valid(mode @ (Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan)) => {
                    self.read_primitive(primitive, mode, transform, &place)?;
                }
                Checked::Valid(_) => self.skipped += 1,
                Checked::Invalid => return Err(self.error(place, "has a mode that does not exist")),
            }
        }
        Ok(())
    }

    fn read_primitive(
        &mut self,
        primitive: &Primitive,
        mode: Mode,
        transform: &DMat4,
        place: &str,
    ) -> Result<(), ImportError> {
        let Some(positions) = primitive.attributes.get(&Checked::Valid(Semantic::Positions)) else {
            return Err(self.error(place.to_owned(), "has no POSITION"));
        };
        let positions = self.buffers.elements(self.source, self.root, positions.value(), accessor::Type::Vec3)?;
        let indices = primitive
            .indices
            .map(|i| self.buffers.elements(self.source, self.root, i.value(), accessor::Type::Scalar))
            .transpose()?;
        let corners = indices.as_ref().map_or(positions.count, |i| i.count);
        let triangles = match mode {
            Mode::Triangles => corners / 3,
            _ => corners.saturating_sub(2),
        };
        let base = self.raw.mesh.vertices.len();
        self.source.check_mesh((self.raw.mesh.triangles.len() + triangles) as u64, (base + positions.count) as u64)?;
        for i in 0..positions.count {
            self.source.tick("reading vertices", i, positions.count)?;
            let p = DVec3::from_array(positions.point(i));
            let placed = transform.transform_point3(p);
            let placed = self.source.finite(placed, || format!("{place}, vertex {i}"))?;
            self.raw.mesh.vertices.push(placed);
        }
        // A mirrored node turns its triangles inside out; the standard has their corners reversed then.
        let mirrored = transform.determinant() < 0.0;
        for t in 0..triangles {
            self.source.tick("reading triangles", t, triangles)?;
            let mut triangle = [0; 3];
            for (corner, i) in triangle.iter_mut().zip(corners_of(mode, t)) {
                let v = indices.as_ref().map_or(i, |indices| indices.index(i));
                if v >= positions.count {
                    let problem = format!("refers to vertex {v} of {}", positions.count);
                    return Err(self.error(format!("{place}, triangle {t}"), problem));
                }
                *corner = (base + v) as u32;
            }
            if mirrored {
                triangle.swap(1, 2);
            }
            self.raw.mesh.triangles.push(triangle);
        }
        Ok(())
    }
}

/// Places in the list of corners that triangle `t` takes (glTF 2.0, section 3.7.2.1).
fn corners_of(mode: Mode, t: usize) -> [usize; 3] {
    match mode {
        Mode::TriangleStrip => [t, t + 1 + t % 2, t + 2 - t % 2],
        Mode::TriangleFan => [t + 1, t + 2, 0],
        _ => [3 * t, 3 * t + 1, 3 * t + 2],
    }
}

/// The transform from a node's coordinates to its parent's.
fn local_transform(node: &Node) -> DMat4 {
    if let Some(matrix) = node.matrix {
        return DMat4::from_cols_array(&matrix.map(f64::from));
    }
    let vector = |v: [f32; 3]| DVec3::from_array(v.map(f64::from));
    let rotation = node.rotation.map_or(DQuat::IDENTITY, |r| DQuat::from_array(r.0.map(f64::from)));
    // The standard asks for unit quaternions; as they are f32 they are so only nearly. A zero one turns nothing.
    let rotation = if rotation.length_squared() > 0.0 { rotation.normalize() } else { DQuat::IDENTITY };
    DMat4::from_scale_rotation_translation(
        node.scale.map_or(DVec3::ONE, vector),
        rotation,
        node.translation.map_or(DVec3::ZERO, vector),
    )
}
