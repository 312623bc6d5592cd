//! The order in which a picture is drawn.

use std::ops::Range;

use super::gpu_meshes::Detail;
use super::pipelines::{Key, Kind};
use super::prepare::{Prepared, PreparedBatch, PreparedObject};
use super::uniforms::{FrameUniform, ObjectUniform};
use super::{Plan, Renderer};
use crate::scene::{Object, Scene};

const KINDS: [Kind; 16] = [
    Kind::Background,
    Kind::Surface,
    Kind::SurfaceDepth,
    Kind::SurfaceBlended,
    Kind::Batch,
    Kind::Edges,
    Kind::CapCount,
    Kind::CapFill,
    Kind::Grid,
    Kind::Lines,
    Kind::LinesDepth,
    Kind::LinesBehind,
    Kind::LinesFlat,
    Kind::Dots,
    Kind::DotsBehind,
    Kind::DotsFlat,
];

/// State that the draws of one picture share.
struct Pass<'a> {
    renderer: &'a Renderer,
    pass: wgpu::RenderPass<'a>,
    scene: &'a Scene,
    prepared: &'a Prepared,
    plan: &'a Plan,
    /// Level of detail of each prepared object's mesh on the GPU.
    details: &'a [Option<Detail>],
    frame: wgpu::BindGroup,
    object: wgpu::BindGroup,
    /// Pipeline that is set: setting it again would cost as much as another draw.
    pipeline: Option<Key>,
}

impl Renderer {
    /// The commands that draw a prepared picture into the selected target.
    pub(super) fn draw(
        &mut self,
        device: &wgpu::Device,
        scene: &Scene,
        prepared: &Prepared,
        plan: &Plan,
    ) -> wgpu::CommandBuffer {
        let upload = |o: &PreparedObject| {
            self.meshes.upload(device, &scene.objects[o.index], plan.detail(&scene.objects[o.index]))
        };
        let details: Vec<Option<Detail>> = prepared.objects.iter().map(upload).collect();
        self.make_pipelines(device, prepared, plan);
        let mut encoder = device.create_command_encoder(&Default::default());
        let target = self.targets.current().and_then(|t| Some((t, t.buffers(plan.samples)?)));
        if let Some((target, buffers)) = target {
            let (view, resolve_target) = match &buffers.colour {
                Some(colour) => (colour, Some(&target.picture)),
                None => (&target.picture, None),
            };
            let pass = begin(&mut encoder, view, resolve_target, &buffers.depth);
            let [frame, object] = self.bind_groups(device);
            Pass { renderer: self, pass, scene, prepared, plan, details: &details, frame, object, pipeline: None }
                .all();
        }
        encoder.finish()
    }

    fn make_pipelines(&mut self, device: &wgpu::Device, prepared: &Prepared, plan: &Plan) {
        let (section, samples) = (prepared.section, plan.samples);
        let keys = KINDS
            .into_iter()
            .flat_map(|kind| [false, true].map(|valued| normalised(Key { kind, section, valued, samples })));
        self.pipelines.make(device, keys);
    }

    fn bind_groups(&self, device: &wgpu::Device) -> [wgpu::BindGroup; 2] {
        let window = |buffer, size: usize| {
            let size = wgpu::BufferSize::new(size as u64);
            wgpu::BindingResource::Buffer(wgpu::BufferBinding { buffer, offset: 0, size })
        };
        let group = |layout, entries: &[wgpu::BindGroupEntry]| {
            device.create_bind_group(&wgpu::BindGroupDescriptor { label: None, layout, entries })
        };
        let frame = wgpu::BindGroupEntry { binding: 0, resource: window(self.frames.get(), size_of::<FrameUniform>()) };
        let colour_maps =
            wgpu::BindGroupEntry { binding: 1, resource: wgpu::BindingResource::TextureView(&self.colour_maps) };
        let object =
            wgpu::BindGroupEntry { binding: 0, resource: window(self.objects.get(), size_of::<ObjectUniform>()) };
        [group(&self.pipelines.frame_layout, &[frame, colour_maps]), group(&self.pipelines.object_layout, &[object])]
    }
}

/// `key` without what makes no difference to its kind.
fn normalised(key: Key) -> Key {
    let surface = matches!(key.kind, Kind::Surface | Kind::SurfaceDepth | Kind::SurfaceBlended);
    Key { valued: key.valued && surface, section: key.section && (surface || key.kind == Kind::Edges), ..key }
}

fn begin<'a>(
    encoder: &'a mut wgpu::CommandEncoder,
    view: &wgpu::TextureView,
    resolve_target: Option<&wgpu::TextureView>,
    depth: &wgpu::TextureView,
) -> wgpu::RenderPass<'a> {
    let store = if resolve_target.is_some() { wgpu::StoreOp::Discard } else { wgpu::StoreOp::Store };
    encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: Some("scene"),
        color_attachments: &[Some(wgpu::RenderPassColorAttachment {
            view,
            depth_slice: None,
            resolve_target,
            ops: wgpu::Operations { load: wgpu::LoadOp::Clear(wgpu::Color::BLACK), store },
        })],
        depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
            view: depth,
            depth_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Clear(1.0), store: wgpu::StoreOp::Discard }),
            stencil_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Clear(0), store: wgpu::StoreOp::Discard }),
        }),
        ..Default::default()
    })
}

impl Pass<'_> {
    fn all(&mut self) {
        self.bind_frame(0);
        if self.select(Kind::Background, false) {
            self.pass.draw(0..3, 0..1);
        }
        self.batches();
        let opaque = 0..self.prepared.opaque;
        for i in opaque.clone() {
            self.surface(Kind::Surface, i);
        }
        for i in opaque.clone() {
            self.cap(i);
        }
        for i in opaque {
            self.edges(i);
        }
        self.quad(Kind::Grid, self.prepared.grid.clone());
        self.segments(Kind::Lines, self.prepared.lines.clone());
        self.segments(Kind::LinesDepth, self.prepared.lines.clone());
        for i in self.prepared.opaque..self.prepared.objects.len() {
            self.surface(Kind::SurfaceDepth, i);
            self.cap(i);
            self.surface(Kind::SurfaceBlended, i);
            self.edges(i);
        }
        self.segments(Kind::LinesBehind, self.prepared.lines_on_top.clone());
        self.segments(Kind::Lines, self.prepared.lines_on_top.clone());
        let markers = 0..self.prepared.triad.as_ref().map_or(self.prepared.dots.len() as u32, |t| t.first_dot);
        self.dots(Kind::DotsBehind, markers.clone());
        self.dots(Kind::Dots, markers);
        self.triad();
    }

    fn triad(&mut self) {
        let Some(triad) = &self.prepared.triad else { return };
        self.bind_frame(self.renderer.stride as u32);
        for (line, disc, letter) in triad.axes.clone() {
            self.segments(Kind::LinesFlat, line);
            self.dots(Kind::DotsFlat, disc);
            self.segments(Kind::LinesFlat, letter);
        }
    }

    fn bind_frame(&mut self, offset: u32) {
        self.pass.set_bind_group(0, &self.frame, &[offset]);
    }

    fn select(&mut self, kind: Kind, valued: bool) -> bool {
        let key = normalised(Key { kind, section: self.prepared.section, valued, samples: self.plan.samples });
        let Some(pipeline) = self.renderer.pipelines.get(key) else { return false };
        if self.pipeline.replace(key) != Some(key) {
            self.pass.set_pipeline(pipeline);
        }
        true
    }

    fn bind_object(&mut self, i: usize) {
        self.pass.set_bind_group(1, &self.object, &[(i * self.renderer.stride) as u32]);
    }

    fn object(&self, i: usize) -> &Object {
        &self.scene.objects[self.prepared.objects[i].index]
    }

    fn batches(&mut self) {
        for (i, PreparedBatch { batch, .. }) in self.prepared.batches.iter().enumerate() {
            if self.select(Kind::Batch, false) {
                // Their uniforms come after those of the objects.
                self.bind_object(self.prepared.objects.len() + i);
                self.pass.set_vertex_buffer(0, batch.vertices.slice(..));
                self.pass.set_index_buffer(batch.indices.slice(..), wgpu::IndexFormat::Uint32);
                self.pass.draw_indexed(0..batch.index_count, 0, 0..1);
            }
        }
    }

    fn surface(&mut self, kind: Kind, i: usize) {
        let Some(detail) = self.details[i] else { return };
        let meshes = &self.renderer.meshes;
        let (Some(mesh), values) = (meshes.mesh(self.object(i), detail), meshes.values(self.object(i), detail)) else {
            return;
        };
        if !self.select(kind, values.is_some()) {
            return;
        }
        self.bind_object(i);
        self.pass.set_vertex_buffer(0, mesh.vertices.slice(..));
        if let Some(values) = values {
            self.pass.set_vertex_buffer(1, values.slice(..));
        }
        self.pass.set_index_buffer(mesh.indices.slice(..), wgpu::IndexFormat::Uint32);
        self.pass.draw_indexed(0..mesh.index_count, 0, 0..1);
    }

    fn edges(&mut self, i: usize) {
        let wanted = !self.plan.light && (self.object(i).edges || self.object(i).selected);
        let Some(detail) = self.details[i].filter(|_| wanted) else { return };
        let Some(mesh) = self.renderer.meshes.mesh(self.object(i), detail) else { return };
        let Some(edges) = &mesh.edges else { return };
        if self.select(Kind::Edges, false) {
            self.bind_object(i);
            self.pass.set_vertex_buffer(0, edges.slice(..));
            self.pass.draw(0..4, 0..mesh.edge_count);
        }
    }

    fn cap(&mut self, i: usize) {
        let cap = self.prepared.objects[i].cap.clone();
        if cap.is_empty() {
            return;
        }
        self.bind_object(i);
        self.pass.set_vertex_buffer(0, self.renderer.planes.get().slice(..));
        self.pass.set_stencil_reference(0);
        if self.select(Kind::CapCount, false) {
            self.pass.draw(cap, 0..1);
        }
        if self.select(Kind::CapFill, false) {
            self.pass.draw(self.prepared.cap_cover.clone(), 0..1);
        }
    }

    fn quad(&mut self, kind: Kind, vertices: Range<u32>) {
        if !vertices.is_empty() && self.select(kind, false) {
            self.pass.set_vertex_buffer(0, self.renderer.planes.get().slice(..));
            self.pass.draw(vertices, 0..1);
        }
    }

    fn segments(&mut self, kind: Kind, instances: Range<u32>) {
        if !instances.is_empty() && self.select(kind, false) {
            self.pass.set_vertex_buffer(0, self.renderer.segments.get().slice(..));
            self.pass.draw(0..4, instances);
        }
    }

    fn dots(&mut self, kind: Kind, instances: Range<u32>) {
        if !instances.is_empty() && self.select(kind, false) {
            self.pass.set_vertex_buffer(0, self.renderer.dots.get().slice(..));
            self.pass.draw(0..4, instances);
        }
    }
}
