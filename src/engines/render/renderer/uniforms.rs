//! Uniforms of the shaders, byte for byte, and the buffers that they are written to for each picture.

use bytemuck::{Pod, Zeroable};

/// `Frame` in `shaders/common.wgsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub struct FrameUniform {
    pub projection: [f32; 16],
    pub section: [f32; 4],
    pub up: [f32; 4],
    pub picture: [f32; 4],
    pub fade: [f32; 4],
    pub background_top: [f32; 4],
    pub background_bottom: [f32; 4],
    pub edge: [f32; 4],
    pub accent: [f32; 4],
    pub grid: [f32; 4],
    pub grid_colour: [f32; 4],
}

/// `Object` in `shaders/object.wgsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub struct ObjectUniform {
    pub model_view: [f32; 16],
    pub normal_view: [f32; 16],
    pub colour: [f32; 4],
    pub look: [f32; 4],
    pub values: [f32; 4],
}

/// A segment of a line, in view coordinates.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub struct SegmentInstance {
    pub ends: [[f32; 3]; 2],
    pub colour: [u8; 4],
    pub width: f32,
}

/// A dot, in view coordinates.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub struct DotInstance {
    pub at: [f32; 3],
    pub colour: [u8; 4],
    pub radius: f32,
}

/// A corner of something flat, in view coordinates, with places in its plane.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub struct PlaneVertex {
    pub position: [f32; 3],
    pub place: [f32; 2],
    pub off: [f32; 2],
}

/// A buffer that grows with what is written into it.
pub struct GrowingBuffer {
    buffer: wgpu::Buffer,
    usage: wgpu::BufferUsages,
}

impl GrowingBuffer {
    /// A small one.
    pub fn new(device: &wgpu::Device, usage: wgpu::BufferUsages) -> Self {
        let usage = usage | wgpu::BufferUsages::COPY_DST;
        Self { buffer: buffer(device, 1024, usage), usage }
    }

    /// Writes `bytes`; returns whether the buffer was replaced.
    pub fn write(&mut self, device: &wgpu::Device, queue: &wgpu::Queue, bytes: &[u8]) -> bool {
        let grows = bytes.len() as u64 > self.buffer.size();
        if grows {
            self.buffer = buffer(device, (bytes.len() as u64).next_power_of_two(), self.usage);
        }
        if !bytes.is_empty() {
            queue.write_buffer(&self.buffer, 0, bytes);
        }
        grows
    }

    /// The buffer as it is now.
    pub fn get(&self) -> &wgpu::Buffer {
        &self.buffer
    }
}

/// The bytes of `items`, each starting at a multiple of `stride`.
pub fn spaced<T: bytemuck::Pod>(items: impl IntoIterator<Item = T>, stride: usize) -> Vec<u8> {
    let mut bytes = Vec::new();
    for item in items {
        let start = bytes.len();
        bytes.extend_from_slice(bytemuck::bytes_of(&item));
        bytes.resize(start + stride, 0);
    }
    bytes
}

fn buffer(device: &wgpu::Device, size: u64, usage: wgpu::BufferUsages) -> wgpu::Buffer {
    device.create_buffer(&wgpu::BufferDescriptor { label: Some("picture"), size, usage, mapped_at_creation: false })
}
