//! Draws a scene into a texture.

mod batches;
mod gpu_meshes;
mod passes;
mod pipelines;
mod prepare;
mod targets;
mod triad;
mod uniforms;

use super::camera::Camera;
use super::colour_map::{ColourMap, TABLE_SIZE};
use super::scene::{Object, Scene};
use super::section::CutCache;
use batches::Batches;
use gpu_meshes::{Detail, GpuMeshes};
use pipelines::Pipelines;
use prepare::{Prepared, flat_frame, prepare};
use targets::Targets;
use uniforms::{FrameUniform, GrowingBuffer, ObjectUniform, spaced};

/// Format of the pictures; its values are already sRGB, so a reader must not decode them again.
pub const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;
/// Samples to a pixel at rest.
const SAMPLES: u32 = 4;
/// Pixels of a picture while the view moves on a software adapter, at most.
const MOVING_PIXELS: f64 = 500_000.0;

/// Indices of surfaces that a software adapter is given at a time: it keeps what it has not drawn, some hundred bytes for
/// each triangle.
const INDICES_AT_A_TIME: u32 = 3 * 500_000;
/// Triangles of a picture while the view moves above which small meshes are drawn in their lighter versions as well.
const MANY_TRIANGLES: usize = 200_000;

/// Quality of a picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Quality {
    /// While the view moves. On a software adapter at a lower resolution, with lighter meshes and
    /// without edges and smoothing; on a real GPU like [`Full`](Self::Full).
    Moving,
    /// Full quality, at rest and for print.
    Full,
}

/// Draws scenes on one device. Keeps meshes on the GPU between pictures, and lets go of those that have not
/// been drawn for a while.
pub struct Renderer {
    is_software: bool,
    /// Indices of surfaces that the device is given at a time, three for each triangle.
    pub(super) indices_at_a_time: u32,
    pipelines: Pipelines,
    targets: Targets,
    meshes: GpuMeshes,
    batches: Batches,
    cuts: CutCache,
    colour_maps: wgpu::TextureView,
    frames: GrowingBuffer,
    objects: GrowingBuffer,
    segments: GrowingBuffer,
    dots: GrowingBuffer,
    planes: GrowingBuffer,
    /// Distance of uniforms in a buffer (bytes).
    stride: usize,
}

/// How a picture is drawn.
#[derive(Debug, Clone, Copy)]
struct Plan {
    size: [u32; 2],
    /// Pixels drawn for a pixel asked for.
    scale: f64,
    samples: u32,
    /// Whether lighter meshes are drawn, without edges.
    light: bool,
    /// Whether lighter ones are drawn of small meshes too.
    is_crowded: bool,
}

impl Plan {
    fn detail(&self, object: &Object) -> Detail {
        let is_light = self.is_crowded || self.light && object.mesh.is_large();
        if is_light { Detail::Lighter } else { Detail::Full }
    }
}

impl Renderer {
    /// A renderer on this device. Needs no features, and no limits beyond WebGL 2's.
    pub fn new(device: &wgpu::Device, queue: &wgpu::Queue) -> Self {
        let alignment = device.limits().min_uniform_buffer_offset_alignment as usize;
        let largest = size_of::<FrameUniform>().max(size_of::<ObjectUniform>());
        let uniform = || GrowingBuffer::new(device, wgpu::BufferUsages::UNIFORM);
        let vertex = || GrowingBuffer::new(device, wgpu::BufferUsages::VERTEX);
        let is_software = Self::is_software(device);
        Self {
            is_software,
            indices_at_a_time: if is_software { INDICES_AT_A_TIME } else { u32::MAX },
            pipelines: Pipelines::new(device),
            targets: Targets::default(),
            meshes: GpuMeshes::default(),
            batches: Batches::default(),
            cuts: CutCache::default(),
            colour_maps: colour_maps(device, queue),
            frames: uniform(),
            objects: uniform(),
            segments: vertex(),
            dots: vertex(),
            planes: vertex(),
            stride: largest.next_multiple_of(alignment.max(1)),
        }
    }

    /// Draws the scene and returns the finished picture, opaque, in [`FORMAT`], usable as a texture binding and
    /// as a copy source. The view is the same one until [`picture_size`](Self::picture_size) changes.
    ///
    /// The picture may be smaller than `size` asks for (moving on a software adapter, or beyond the device's
    /// greatest texture): show it stretched over the place of `size`. Widths in pixels are those of `size`. A
    /// size of zero counts as one; with a camera that is not [valid](Camera::is_valid) only the background is
    /// drawn.
    pub fn render(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        scene: &Scene,
        camera: &Camera,
        size: [u32; 2],
        quality: Quality,
    ) -> wgpu::TextureView {
        let (picture, mut parts) = self.commands(device, queue, scene, camera, size, quality);
        let last = parts.pop();
        for part in parts {
            queue.submit([part]);
            // Whoever shows the picture finds out that the device is lost.
            let _ = device.poll(wgpu::PollType::wait_indefinitely());
        }
        queue.submit(last);
        picture
    }

    /// The commands that [`render`](Self::render) gives the device, in the parts in which it should finish them: a software
    /// adapter keeps in memory what it has not drawn.
    pub(super) fn commands(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        scene: &Scene,
        camera: &Camera,
        size: [u32; 2],
        quality: Quality,
    ) -> (wgpu::TextureView, Vec<wgpu::CommandBuffer>) {
        let (nothing, default) = (Scene { theme: scene.theme, ..Scene::default() }, Camera::default());
        let (scene, camera) = if camera.is_valid() { (scene, camera) } else { (&nothing, &default) };
        let plan = self.plan(device, scene, size, quality);
        let together = self.batches.gather(device, scene, &plan);
        let prepared = prepare(scene, camera, plan.size, plan.scale, &mut self.cuts, &together);
        self.write(device, queue, &prepared, plan.size);
        let picture = self.targets.select(device, plan.size, plan.samples).picture.clone();
        let commands = self.draw(device, scene, &prepared, &plan);
        self.meshes.finish_picture();
        (picture, commands)
    }

    /// Width and height of the last picture (pixels); zero before the first.
    pub fn picture_size(&self) -> [u32; 2] {
        self.targets.current().map_or([0, 0], |t| t.size)
    }

    /// The last picture's texture, to be copied from.
    pub fn picture(&self) -> Option<&wgpu::Texture> {
        self.targets.current().map(|t| t.picture.texture())
    }

    /// Whether the device computes on the CPU.
    pub fn is_software(device: &wgpu::Device) -> bool {
        device.adapter_info().device_type == wgpu::DeviceType::Cpu
    }

    fn plan(&self, device: &wgpu::Device, scene: &Scene, size: [u32; 2], quality: Quality) -> Plan {
        let asked = size.map(|s| f64::from(s.max(1)));
        let most = f64::from(device.limits().max_texture_dimension_2d);
        let light = quality == Quality::Moving && self.is_software;
        let mut scale = (most / asked[0].max(asked[1])).min(1.0);
        if light {
            scale = scale.min((MOVING_PIXELS / (asked[0] * asked[1])).sqrt());
        }
        Plan {
            size: asked.map(|s| (s * scale).round().clamp(1.0, most) as u32),
            scale,
            samples: if light { 1 } else { SAMPLES },
            light,
            is_crowded: light && triangles(scene) > MANY_TRIANGLES,
        }
    }

    fn write(&mut self, device: &wgpu::Device, queue: &wgpu::Queue, prepared: &Prepared, size: [u32; 2]) {
        let frames = [prepared.frame, flat_frame(&prepared.frame, size)];
        self.frames.write(device, queue, &spaced(frames, self.stride));
        let objects = prepared.objects.iter().map(|o| o.uniform);
        let objects = objects.chain(prepared.batches.iter().map(|b| b.uniform));
        // And one more, so that there is something to bind.
        let objects = objects.chain([bytemuck::Zeroable::zeroed()]);
        self.objects.write(device, queue, &spaced(objects, self.stride));
        self.segments.write(device, queue, bytemuck::cast_slice(&prepared.segments));
        self.dots.write(device, queue, bytemuck::cast_slice(&prepared.dots));
        self.planes.write(device, queue, bytemuck::cast_slice(&prepared.planes));
    }
}

/// Triangles that are drawn of a scene while the view moves if small meshes are drawn in full.
fn triangles(scene: &Scene) -> usize {
    let visible = scene.objects.iter().filter(|o| o.is_visible());
    let levels = visible.map(|o| if o.mesh.is_large() { o.mesh.lighter() } else { o.mesh.full() });
    levels.map(|level| level.indices.len() / 3).sum()
}

/// A texture with one row for each colour map.
fn colour_maps(device: &wgpu::Device, queue: &wgpu::Queue) -> wgpu::TextureView {
    let size =
        wgpu::Extent3d { width: TABLE_SIZE as u32, height: ColourMap::ALL.len() as u32, depth_or_array_layers: 1 };
    let texture = device.create_texture(&wgpu::TextureDescriptor {
        label: Some("colour maps"),
        size,
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: FORMAT,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    });
    let bytes: Vec<u8> = ColourMap::ALL.iter().flat_map(|m| m.table()).flat_map(|c| [c.r, c.g, c.b, 255]).collect();
    let layout =
        wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(4 * TABLE_SIZE as u32), rows_per_image: None };
    queue.write_texture(texture.as_image_copy(), &bytes, layout, size);
    texture.create_view(&Default::default())
}

#[cfg(test)]
mod tests;
