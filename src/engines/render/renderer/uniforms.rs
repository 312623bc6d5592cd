//! Uniforms of the shaders, byte for byte.

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
