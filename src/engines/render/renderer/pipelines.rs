//! Pipelines: shader, its inputs, and their use of depth, stencil and colour.

use std::collections::HashMap;
use std::mem::size_of;

use super::FORMAT;
use super::batches::BatchVertex;
use super::uniforms::{DotInstance, FrameUniform, ObjectUniform, PlaneVertex, SegmentInstance};
use crate::mesh::Vertex;

/// Format of depth and stencil, which every device has.
pub const DEPTH_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Depth24PlusStencil8;

/// Kind of primitive that is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Kind {
    Background,
    /// Opaque surfaces.
    Surface,
    /// Only their depth.
    SurfaceDepth,
    /// Blended where their depth has been drawn before.
    SurfaceBlended,
    /// Opaque surfaces of some objects.
    Batch,
    Edges,
    /// Counts the windings of a section's outline.
    CapCount,
    /// Fills where the count is not zero, and clears it.
    CapFill,
    Grid,
    Lines,
    /// Only the depth of lines, for what is blended over them later.
    LinesDepth,
    /// Lines where something lies before them.
    LinesBehind,
    /// Lines over everything.
    LinesFlat,
    Dots,
    DotsBehind,
    DotsFlat,
}

/// Key of a pipeline.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Key {
    pub kind: Kind,
    /// Whether a section plane cuts.
    pub section: bool,
    /// Whether surfaces show values.
    pub valued: bool,
    /// Samples to a pixel.
    pub samples: u32,
}

/// Pipelines, made on first use.
pub struct Pipelines {
    pub frame_layout: wgpu::BindGroupLayout,
    pub object_layout: wgpu::BindGroupLayout,
    with_frame: wgpu::PipelineLayout,
    with_object: wgpu::PipelineLayout,
    modules: Modules,
    made: HashMap<Key, wgpu::RenderPipeline>,
}

struct Modules {
    background: wgpu::ShaderModule,
    surface: wgpu::ShaderModule,
    edges: wgpu::ShaderModule,
    lines: wgpu::ShaderModule,
    markers: wgpu::ShaderModule,
    cap: wgpu::ShaderModule,
    grid: wgpu::ShaderModule,
}

const COMMON: &str = include_str!("../../../../shaders/common.wgsl");
const OBJECT: &str = include_str!("../../../../shaders/object.wgsl");
const SEGMENT: &str = include_str!("../../../../shaders/segment.wgsl");

impl Modules {
    fn new(device: &wgpu::Device) -> Self {
        let module = |label: &str, parts: &[&str]| {
            let source = wgpu::ShaderSource::Wgsl(parts.concat().into());
            device.create_shader_module(wgpu::ShaderModuleDescriptor { label: Some(label), source })
        };
        Self {
            background: module("background", &[COMMON, include_str!("../../../../shaders/background.wgsl")]),
            surface: module("surface", &[COMMON, OBJECT, include_str!("../../../../shaders/surface.wgsl")]),
            edges: module("edges", &[COMMON, OBJECT, SEGMENT, include_str!("../../../../shaders/edges.wgsl")]),
            lines: module("lines", &[COMMON, SEGMENT, include_str!("../../../../shaders/lines.wgsl")]),
            markers: module("markers", &[COMMON, include_str!("../../../../shaders/markers.wgsl")]),
            cap: module("cap", &[COMMON, OBJECT, include_str!("../../../../shaders/cap.wgsl")]),
            grid: module("grid", &[COMMON, include_str!("../../../../shaders/grid.wgsl")]),
        }
    }
}

impl Pipelines {
    /// Compiles the shaders.
    pub fn new(device: &wgpu::Device) -> Self {
        let colour_maps = wgpu::BindGroupLayoutEntry {
            binding: 1,
            visibility: wgpu::ShaderStages::VERTEX_FRAGMENT,
            ty: wgpu::BindingType::Texture {
                sample_type: wgpu::TextureSampleType::Float { filterable: false },
                view_dimension: wgpu::TextureViewDimension::D2,
                multisampled: false,
            },
            count: None,
        };
        let layout = |entries: &[wgpu::BindGroupLayoutEntry]| {
            device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: None, entries })
        };
        let frame_layout = layout(&[uniform(size_of::<FrameUniform>()), colour_maps]);
        let object_layout = layout(&[uniform(size_of::<ObjectUniform>())]);
        let pipeline_layout = |groups: &[Option<&wgpu::BindGroupLayout>]| {
            let descriptor =
                wgpu::PipelineLayoutDescriptor { label: None, bind_group_layouts: groups, immediate_size: 0 };
            device.create_pipeline_layout(&descriptor)
        };
        Self {
            with_frame: pipeline_layout(&[Some(&frame_layout)]),
            with_object: pipeline_layout(&[Some(&frame_layout), Some(&object_layout)]),
            frame_layout,
            object_layout,
            modules: Modules::new(device),
            made: HashMap::new(),
        }
    }

    /// Makes sure that these pipelines are ready.
    pub fn make(&mut self, device: &wgpu::Device, keys: impl IntoIterator<Item = Key>) {
        for key in keys {
            if !self.made.contains_key(&key) {
                let pipeline = self.pipeline(device, key);
                self.made.insert(key, pipeline);
            }
        }
    }

    /// A pipeline that has been made.
    pub fn get(&self, key: Key) -> Option<&wgpu::RenderPipeline> {
        self.made.get(&key)
    }

    fn pipeline(&self, device: &wgpu::Device, key: Key) -> wgpu::RenderPipeline {
        let program = self.program(key);
        let constants = constants(key);
        let options = || wgpu::PipelineCompilationOptions { constants: &constants, ..Default::default() };
        let target = wgpu::ColorTargetState {
            format: FORMAT,
            blend: blends(key.kind).then_some(BLEND),
            write_mask: if program.colour { wgpu::ColorWrites::ALL } else { wgpu::ColorWrites::empty() },
        };
        let strip = !matches!(
            key.kind,
            Kind::Background | Kind::Surface | Kind::SurfaceDepth | Kind::SurfaceBlended | Kind::Batch | Kind::CapCount
        );
        let topology =
            if strip { wgpu::PrimitiveTopology::TriangleStrip } else { wgpu::PrimitiveTopology::TriangleList };
        device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some("scene"),
            layout: Some(if program.object { &self.with_object } else { &self.with_frame }),
            vertex: wgpu::VertexState {
                module: program.module,
                entry_point: Some(program.vertex),
                compilation_options: options(),
                buffers: &vertex_buffers(key),
            },
            primitive: wgpu::PrimitiveState { topology, ..Default::default() },
            depth_stencil: Some(depth_stencil(key.kind)),
            multisample: wgpu::MultisampleState { count: key.samples, ..Default::default() },
            fragment: Some(wgpu::FragmentState {
                module: program.module,
                entry_point: Some(program.fragment),
                compilation_options: options(),
                targets: &[Some(target)],
            }),
            multiview_mask: None,
            cache: None,
        })
    }

    fn program(&self, key: Key) -> Program<'_> {
        let m = &self.modules;
        let surface = if key.valued { "vs_valued" } else { "vs_plain" };
        let (module, vertex, fragment, colour, object) = match key.kind {
            Kind::Background => (&m.background, "vs", "fs", true, false),
            Kind::Surface | Kind::SurfaceBlended => (&m.surface, surface, "fs", true, true),
            Kind::SurfaceDepth => (&m.surface, surface, "fs_depth", false, true),
            Kind::Batch => (&m.surface, "vs_batch", "fs_batch", true, true),
            Kind::Edges => (&m.edges, "vs", "fs", true, true),
            Kind::CapCount => (&m.cap, "vs", "fs_count", false, true),
            Kind::CapFill => (&m.cap, "vs", "fs", true, true),
            Kind::Grid => (&m.grid, "vs", "fs", true, false),
            Kind::Lines | Kind::LinesBehind | Kind::LinesFlat => (&m.lines, "vs", "fs", true, false),
            Kind::LinesDepth => (&m.lines, "vs", "fs_depth", false, false),
            Kind::Dots | Kind::DotsBehind | Kind::DotsFlat => (&m.markers, "vs", "fs", true, false),
        };
        Program { module, vertex, fragment, colour, object }
    }
}

/// The shader of a pipeline, whether it gives colours and whether it reads an object's uniforms.
struct Program<'a> {
    module: &'a wgpu::ShaderModule,
    vertex: &'static str,
    fragment: &'static str,
    colour: bool,
    object: bool,
}

const BLEND: wgpu::BlendState = wgpu::BlendState {
    color: wgpu::BlendComponent {
        src_factor: wgpu::BlendFactor::SrcAlpha,
        dst_factor: wgpu::BlendFactor::OneMinusSrcAlpha,
        operation: wgpu::BlendOperation::Add,
    },
    // The picture stays opaque.
    alpha: wgpu::BlendComponent {
        src_factor: wgpu::BlendFactor::One,
        dst_factor: wgpu::BlendFactor::OneMinusSrcAlpha,
        operation: wgpu::BlendOperation::Add,
    },
};

fn blends(kind: Kind) -> bool {
    !matches!(
        kind,
        Kind::Background | Kind::Surface | Kind::SurfaceDepth | Kind::Batch | Kind::CapCount | Kind::LinesDepth
    )
}

fn constants(key: Key) -> Vec<(&'static str, f64)> {
    let flag = |on: bool| f64::from(u8::from(on));
    match key.kind {
        Kind::Surface | Kind::SurfaceDepth | Kind::SurfaceBlended => {
            vec![("SECTION", flag(key.section)), ("TRANSLUCENT", flag(key.kind == Kind::SurfaceBlended))]
        }
        Kind::Edges => vec![("SECTION", flag(key.section))],
        Kind::Lines | Kind::LinesDepth | Kind::LinesFlat | Kind::Dots | Kind::DotsFlat => vec![("FAINT", 0.0)],
        Kind::LinesBehind | Kind::DotsBehind => vec![("FAINT", 1.0)],
        Kind::Background | Kind::Batch | Kind::CapCount | Kind::CapFill | Kind::Grid => Vec::new(),
    }
}

fn depth_stencil(kind: Kind) -> wgpu::DepthStencilState {
    use wgpu::CompareFunction::{Always, Greater, LessEqual};
    let (write, compare) = match kind {
        Kind::Background | Kind::CapCount | Kind::LinesFlat | Kind::DotsFlat => (false, Always),
        Kind::Surface | Kind::SurfaceDepth | Kind::Batch | Kind::CapFill | Kind::LinesDepth => (true, LessEqual),
        Kind::SurfaceBlended | Kind::Edges | Kind::Grid | Kind::Lines | Kind::Dots => (false, LessEqual),
        Kind::LinesBehind | Kind::DotsBehind => (false, Greater),
    };
    wgpu::DepthStencilState {
        format: DEPTH_FORMAT,
        depth_write_enabled: Some(write),
        depth_compare: Some(compare),
        stencil: stencil(kind),
        bias: bias(kind),
    }
}

/// What is seen through is drawn as if it lay a little behind where it is: where it coincides with a solid body, such
/// as a swept volume with the body that sweeps it, the solid one is seen, and not specks of both.
fn bias(kind: Kind) -> wgpu::DepthBiasState {
    match kind {
        Kind::SurfaceDepth | Kind::SurfaceBlended => {
            wgpu::DepthBiasState { constant: 2048, slope_scale: 2.0, clamp: 0.0 }
        }
        _ => wgpu::DepthBiasState::default(),
    }
}

fn stencil(kind: Kind) -> wgpu::StencilState {
    use wgpu::StencilOperation::{DecrementWrap, IncrementWrap, Zero};
    let counting = |pass_op| wgpu::StencilFaceState { pass_op, ..Default::default() };
    let (front, back) = match kind {
        Kind::CapCount => (counting(IncrementWrap), counting(DecrementWrap)),
        Kind::CapFill => {
            let compare = wgpu::CompareFunction::NotEqual;
            let fill = wgpu::StencilFaceState { compare, depth_fail_op: Zero, pass_op: Zero, ..Default::default() };
            (fill, fill)
        }
        _ => return wgpu::StencilState::default(),
    };
    wgpu::StencilState { front, back, read_mask: 0xff, write_mask: 0xff }
}

fn uniform(size: usize) -> wgpu::BindGroupLayoutEntry {
    wgpu::BindGroupLayoutEntry {
        binding: 0,
        visibility: wgpu::ShaderStages::VERTEX_FRAGMENT,
        ty: wgpu::BindingType::Buffer {
            ty: wgpu::BufferBindingType::Uniform,
            has_dynamic_offset: true,
            min_binding_size: wgpu::BufferSize::new(size as u64),
        },
        count: None,
    }
}

fn vertex_buffers(key: Key) -> Vec<Option<wgpu::VertexBufferLayout<'static>>> {
    use wgpu::VertexStepMode::{Instance, Vertex as PerVertex};
    const SURFACE: [wgpu::VertexAttribute; 2] = wgpu::vertex_attr_array![0 => Float32x3, 1 => Snorm16x4];
    const VALUE: [wgpu::VertexAttribute; 1] = wgpu::vertex_attr_array![2 => Float32];
    const BATCH: [wgpu::VertexAttribute; 4] =
        wgpu::vertex_attr_array![0 => Float32x3, 1 => Snorm16x4, 2 => Float32x4, 3 => Float32x3];
    const EDGE: [wgpu::VertexAttribute; 2] = wgpu::vertex_attr_array![0 => Float32x3, 1 => Float32x3];
    const LINE: [wgpu::VertexAttribute; 4] =
        wgpu::vertex_attr_array![0 => Float32x3, 1 => Float32x3, 2 => Unorm8x4, 3 => Float32];
    const DOT: [wgpu::VertexAttribute; 3] = wgpu::vertex_attr_array![0 => Float32x3, 1 => Unorm8x4, 2 => Float32];
    const PLANE: [wgpu::VertexAttribute; 3] = wgpu::vertex_attr_array![0 => Float32x3, 1 => Float32x2, 2 => Float32x2];
    let layout = |size: usize, step_mode, attributes| {
        Some(wgpu::VertexBufferLayout { array_stride: size as u64, step_mode, attributes })
    };
    match key.kind {
        Kind::Background => Vec::new(),
        Kind::Surface | Kind::SurfaceDepth | Kind::SurfaceBlended => {
            let mut buffers = vec![layout(size_of::<Vertex>(), PerVertex, &SURFACE)];
            if key.valued {
                buffers.push(layout(size_of::<f32>(), PerVertex, &VALUE));
            }
            buffers
        }
        Kind::Batch => vec![layout(size_of::<BatchVertex>(), PerVertex, &BATCH)],
        Kind::Edges => vec![layout(size_of::<[[f32; 3]; 2]>(), Instance, &EDGE)],
        Kind::Lines | Kind::LinesDepth | Kind::LinesBehind | Kind::LinesFlat => {
            vec![layout(size_of::<SegmentInstance>(), Instance, &LINE)]
        }
        Kind::Dots | Kind::DotsBehind | Kind::DotsFlat => vec![layout(size_of::<DotInstance>(), Instance, &DOT)],
        Kind::CapCount | Kind::CapFill | Kind::Grid => vec![layout(size_of::<PlaneVertex>(), PerVertex, &PLANE)],
    }
}
