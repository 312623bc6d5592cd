//! Small objects that are drawn together while the view moves: ten thousand draws would cost more than all else.

use std::collections::HashMap;
use std::sync::Arc;

use bytemuck::{Pod, Zeroable};
use glam::{DMat3, DVec3};
use wgpu::util::DeviceExt;

use super::Plan;
use super::gpu_meshes::{Detail, level};
use super::prepare::depth_step;
use crate::colour::Colour;
use crate::colour_map::ColourMap;
use crate::mesh::Level;
use crate::scene::{Object, Scene, union};
use geometry::mesh::Bounds;

/// Number of small objects from which on they are drawn together.
const MANY: usize = 256;
/// Triangles that an object drawn with others has, at most.
const SMALL: usize = 4096;
/// Places in the scene's list from which a batch takes its objects: little is made anew when one of them changes.
const PLACES: usize = 256;
/// Pictures in motion after which an unused batch is let go. An object that moves makes one for each picture.
const PATIENCE: u64 = 10;

/// A vertex as the GPU reads it, from the batch's origin. The fourth component of its normal is its object's number of
/// depth steps, the fourth of its colour (linear light) the share of the accent colour. Of its value, a share of its colour
/// map: the share times validity, validity, and the map's row.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub struct BatchVertex {
    position: [f32; 3],
    normal: [i16; 4],
    colour: [f32; 4],
    value: [f32; 3],
}

/// Surfaces of some objects in one mesh.
pub struct Batch {
    pub vertices: wgpu::Buffer,
    pub indices: wgpu::Buffer,
    pub index_count: u32,
    pub origin: DVec3,
    pub bounds: Bounds,
    /// Values of its objects, kept so that their addresses stay theirs.
    _values: Vec<Arc<Vec<f32>>>,
}

/// Batches of one picture, and the objects that are in them.
#[derive(Default)]
pub struct Together {
    pub batches: Vec<Arc<Batch>>,
    /// Whether each object of the scene is in one of them; empty if none is.
    batched: Vec<bool>,
}

/// Batches of this picture and of the last ones.
#[derive(Default)]
pub struct Batches {
    made: HashMap<Vec<Item>, (Arc<Batch>, u64)>,
    picture: u64,
}

/// All that an object gives its batch.
#[derive(PartialEq, Eq, Hash)]
struct Item {
    mesh: u64,
    detail: Detail,
    transform: [u64; 12],
    colour: Colour,
    selected: bool,
    step: i16,
    /// Address of the values, their map, and its range.
    values: Option<(usize, ColourMap, [u32; 2])>,
}

impl Together {
    /// Whether the object at this place of the scene's list is drawn in a batch.
    pub fn has(&self, index: usize) -> bool {
        self.batched.get(index).is_some_and(|is| *is)
    }
}

impl Batches {
    /// The batches of a picture. There are none at rest, where objects have edges, nor in a section, where they
    /// have cut faces, nor where they are few.
    pub fn gather(&mut self, device: &wgpu::Device, scene: &Scene, plan: &Plan) -> Together {
        if !plan.light {
            return Together::default();
        }
        self.picture += 1;
        self.made.retain(|_, (_, used)| *used + PATIENCE > self.picture);
        if scene.section.is_some() {
            return Together::default();
        }
        let batched: Vec<bool> = scene.objects.iter().map(|o| can_be_batched(o, plan)).collect();
        if batched.iter().filter(|is| **is).count() < MANY {
            return Together::default();
        }
        let mut batches = Vec::new();
        for (chunk, objects) in scene.objects.chunks(PLACES).enumerate() {
            let first = chunk * PLACES;
            let numbered = || objects.iter().enumerate().filter(|(i, _)| batched[first + i]);
            let items: Vec<Item> = numbered().map(|(i, o)| item(first + i, o, plan)).collect();
            if items.is_empty() {
                continue;
            }
            let picture = self.picture;
            let known = self.made.get_mut(&items).map(|(batch, used)| {
                *used = picture;
                batch.clone()
            });
            batches.push(known.unwrap_or_else(|| {
                let batch = Arc::new(batch(device, numbered().map(|(_, o)| o).zip(&items)));
                self.made.insert(items, (batch.clone(), picture));
                batch
            }));
        }
        Together { batches, batched }
    }
}

fn can_be_batched(object: &Object, plan: &Plan) -> bool {
    object.is_visible()
        && object.is_opaque()
        && level(&object.mesh, plan.detail(object)).indices.len() < 3 * SMALL
        && object.transform.matrix3.determinant() != 0.0
}

fn item(index: usize, object: &Object, plan: &Plan) -> Item {
    Item {
        mesh: object.mesh.id(),
        detail: plan.detail(object),
        transform: object.transform.to_cols_array().map(f64::to_bits),
        colour: object.colour,
        selected: object.selected,
        step: depth_step(index),
        values: object.values.as_ref().map(|v| (Arc::as_ptr(&v.values).addr(), v.map, v.range.map(f32::to_bits))),
    }
}

fn batch<'a>(device: &wgpu::Device, objects: impl Iterator<Item = (&'a Object, &'a Item)> + Clone) -> Batch {
    let bounds = objects.clone().map(|(o, _)| o.bounds()).fold(Bounds::EMPTY, union);
    let origin = bounds.center();
    let (mut vertices, mut indices) = (Vec::new(), Vec::new());
    for (object, item) in objects.clone() {
        add(&mut vertices, &mut indices, object, level(&object.mesh, item.detail), item.step, origin);
    }
    let buffer = |contents: &[u8], usage| {
        device.create_buffer_init(&wgpu::util::BufferInitDescriptor { label: Some("batch"), contents, usage })
    };
    Batch {
        vertices: buffer(bytemuck::cast_slice(&vertices), wgpu::BufferUsages::VERTEX),
        indices: buffer(bytemuck::cast_slice(&indices), wgpu::BufferUsages::INDEX),
        index_count: indices.len() as u32,
        origin,
        bounds,
        _values: objects.filter_map(|(o, _)| Some(o.values.as_ref()?.values.clone())).collect(),
    }
}

/// Adds a mesh as `object` places it.
fn add(
    vertices: &mut Vec<BatchVertex>,
    indices: &mut Vec<u32>,
    object: &Object,
    level: &Level,
    step: i16,
    origin: DVec3,
) {
    let first = vertices.len() as u32;
    let turn: DMat3 = object.transform.matrix3.inverse().transpose();
    let [r, g, b] = object.colour.to_linear().map(|c| c as f32);
    let colour = [r, g, b, object.accent()];
    let value = |source: u32| {
        let values = object.values.as_ref()?;
        Some([(values.at(source)? - values.range[0]) * values.scale(), 1.0, values.map.index() as f32])
    };
    vertices.extend(level.vertices.iter().zip(&level.sources).map(|(v, &source)| {
        let place = object.mesh.origin() + DVec3::from_array(v.position.map(f64::from));
        let [x, y, z, _] = v.normal.map(f64::from);
        let normal = (turn * DVec3::new(x, y, z)).normalize_or_zero() * f64::from(i16::MAX);
        let [x, y, z] = normal.to_array().map(|c| c.round() as i16);
        let position = (object.transform.transform_point3(place) - origin).as_vec3().to_array();
        BatchVertex { position, normal: [x, y, z, step], colour, value: value(source).unwrap_or_default() }
    }));
    // A mirrored mesh is turned inside out; its triangles are turned back.
    let order = if object.transform.matrix3.determinant() < 0.0 { [0, 2, 1] } else { [0, 1, 2] };
    indices.extend(level.indices.chunks_exact(3).flat_map(|t| order.map(|k| first + t[k])));
}
