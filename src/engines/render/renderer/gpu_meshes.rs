//! Copies of meshes on the GPU.

use std::collections::HashMap;
use std::sync::Arc;

use wgpu::util::DeviceExt;

use crate::mesh::{Level, RenderMesh};
use crate::scene::{Object, SurfaceValues};

/// Pictures after which an unused copy is let go.
const PATIENCE: u64 = 300;
/// Bytes of copies above which unused ones are let go at once.
const PLENTY: u64 = 1 << 30;
/// Stands for "no value" in a buffer of values.
const NO_VALUE: f32 = -f32::MAX;

/// Level of detail of a mesh.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Detail {
    Full,
    Lighter,
}

/// One version of a mesh on the GPU.
pub struct GpuMesh {
    pub vertices: wgpu::Buffer,
    pub indices: wgpu::Buffer,
    pub index_count: u32,
    /// Instances of edges, if there are any.
    pub edges: Option<wgpu::Buffer>,
    pub edge_count: u32,
}

/// The copies.
#[derive(Default)]
pub struct GpuMeshes {
    meshes: HashMap<(u64, Detail), Kept<GpuMesh>>,
    values: HashMap<ValuesKey, Kept<GpuValues>>,
    picture: u64,
}

/// Mesh, version and address of the values.
type ValuesKey = (u64, Detail, usize);

/// Values on the GPU, and where they came from: kept alive so that the address stays theirs.
struct GpuValues {
    buffer: wgpu::Buffer,
    _source: Arc<Vec<f32>>,
}

struct Kept<T> {
    what: T,
    used: u64,
    bytes: u64,
}

impl GpuMeshes {
    /// Makes sure that what `object` needs is on the GPU. Returns the version to be drawn: the lighter one
    /// also where the device has no buffer large enough for the full one, `None` if for neither.
    pub fn upload(&mut self, device: &wgpu::Device, object: &Object, detail: Detail) -> Option<Detail> {
        let most = device.limits().max_buffer_size;
        let fits = |d: &Detail| largest_buffer(level(&object.mesh, *d)) <= most;
        let detail = [detail, Detail::Lighter].into_iter().find(fits)?;
        let picture = self.picture;
        let mesh = self.meshes.entry((object.mesh.id(), detail)).or_insert_with(|| {
            let (what, bytes) = gpu_mesh(device, level(&object.mesh, detail));
            Kept { what, used: picture, bytes }
        });
        mesh.used = picture;
        if let Some(values) = &object.values {
            let kept = self.values.entry(values_key(object, detail, values)).or_insert_with(|| {
                let level = level(&object.mesh, detail);
                let data: Vec<f32> = level.sources.iter().map(|&v| values.at(v).unwrap_or(NO_VALUE)).collect();
                let buffer = buffer(device, bytemuck::cast_slice(&data), wgpu::BufferUsages::VERTEX);
                let bytes = buffer.size();
                Kept { what: GpuValues { buffer, _source: values.values.clone() }, used: picture, bytes }
            });
            kept.used = picture;
        }
        Some(detail)
    }

    /// The copy of an object's mesh.
    pub fn mesh(&self, object: &Object, detail: Detail) -> Option<&GpuMesh> {
        self.meshes.get(&(object.mesh.id(), detail)).map(|k| &k.what)
    }

    /// The copy of an object's values, if it has any.
    pub fn values(&self, object: &Object, detail: Detail) -> Option<&wgpu::Buffer> {
        let key = values_key(object, detail, object.values.as_ref()?);
        self.values.get(&key).map(|k| &k.what.buffer)
    }

    /// To be called after each picture: lets go of what has not been used for long, or of all that is unused
    /// if there is much.
    pub fn finish_picture(&mut self) {
        let bytes: u64 = self.meshes.values().map(|k| k.bytes).chain(self.values.values().map(|k| k.bytes)).sum();
        let oldest = self.picture.saturating_sub(if bytes > PLENTY { 0 } else { PATIENCE });
        self.meshes.retain(|_, k| k.used >= oldest);
        self.values.retain(|_, k| k.used >= oldest);
        self.picture += 1;
    }
}

/// A version of a mesh.
pub fn level(mesh: &RenderMesh, detail: Detail) -> &Level {
    match detail {
        Detail::Full => mesh.full(),
        Detail::Lighter => mesh.lighter(),
    }
}

fn values_key(object: &Object, detail: Detail, values: &SurfaceValues) -> ValuesKey {
    (object.mesh.id(), detail, Arc::as_ptr(&values.values).addr())
}

fn largest_buffer(level: &Level) -> u64 {
    let sizes = [size_of_val(&level.vertices[..]), size_of_val(&level.indices[..]), size_of_val(&level.edges[..])];
    sizes.into_iter().max().unwrap_or(0) as u64
}

fn gpu_mesh(device: &wgpu::Device, level: &Level) -> (GpuMesh, u64) {
    let mesh = GpuMesh {
        vertices: buffer(device, bytemuck::cast_slice(&level.vertices), wgpu::BufferUsages::VERTEX),
        indices: buffer(device, bytemuck::cast_slice(&level.indices), wgpu::BufferUsages::INDEX),
        index_count: level.indices.len() as u32,
        edges: (!level.edges.is_empty())
            .then(|| buffer(device, bytemuck::cast_slice(&level.edges), wgpu::BufferUsages::VERTEX)),
        edge_count: level.edges.len() as u32,
    };
    let bytes = mesh.vertices.size() + mesh.indices.size() + mesh.edges.as_ref().map_or(0, wgpu::Buffer::size);
    (mesh, bytes)
}

fn buffer(device: &wgpu::Device, contents: &[u8], usage: wgpu::BufferUsages) -> wgpu::Buffer {
    device.create_buffer_init(&wgpu::util::BufferInitDescriptor { label: Some("mesh"), contents, usage })
}
