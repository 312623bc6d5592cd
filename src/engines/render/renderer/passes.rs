//! The order in which a picture is drawn.

use std::ops::Range;

use super::gpu_meshes::Detail;
use super::pipelines::{Key, Kind};
use super::prepare::{Prepared, PreparedBatch, PreparedObject};
use super::targets::{Buffers, Target};
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

/// What of a picture is drawn in one pass.
#[derive(Clone, Copy)]
struct Place {
    first: bool,
    last: bool,
}

/// State that the draws of one picture share.
struct Pass<'a> {
    renderer: &'a Renderer,
    pass: wgpu::RenderPass<'a>,
    scene: &'a Scene,
    prepared: &'a Prepared,
    plan: &'a Plan,
    /// Level of detail of each prepared object's mesh on the GPU.
    details: &'a [Option<Detail>],
    frame: &'a wgpu::BindGroup,
    object: &'a wgpu::BindGroup,
    /// Pipeline that is set: setting it again would cost as much as another draw.
    pipeline: Option<Key>,
}

impl Renderer {
    /// The commands that draw a prepared picture into the selected target, to be done one after another.
    pub(super) fn draw(
        &mut self,
        device: &wgpu::Device,
        scene: &Scene,
        prepared: &Prepared,
        plan: &Plan,
    ) -> Vec<wgpu::CommandBuffer> {
        let upload = |o: &PreparedObject| {
            self.meshes.upload(device, &scene.objects[o.index], plan.detail(&scene.objects[o.index]))
        };
        let details: Vec<Option<Detail>> = prepared.objects.iter().map(upload).collect();
        self.make_pipelines(device, prepared, plan);
        let Some(target) = self.targets.current() else { return Vec::new() };
        let Some(buffers) = target.buffers(plan.samples) else { return Vec::new() };
        let of_object = |i: usize| {
            let mesh =
                details[i].and_then(|detail| self.meshes.mesh(&scene.objects[prepared.objects[i].index], detail));
            mesh.map_or(0, |mesh| mesh.index_count)
        };
        let parts = parts((0..prepared.opaque).map(of_object), self.indices_at_a_time);
        let [frame, object] = self.bind_groups(device);
        let commands = parts.iter().enumerate().map(|(number, part)| {
            let mut encoder = device.create_command_encoder(&Default::default());
            let is = Place { first: number == 0, last: number + 1 == parts.len() };
            let pass = begin(&mut encoder, target, buffers, is);
            let (renderer, details, [frame, object]) = (&*self, &details[..], [&frame, &object]);
            let mut pass = Pass { renderer, pass, scene, prepared, plan, details, frame, object, pipeline: None };
            pass.bind_frame(0);
            if is.first {
                pass.background();
            }
            for (i, indices) in part {
                pass.surface(Kind::Surface, *i, indices.clone());
            }
            if is.last {
                pass.all_but_surfaces();
            }
            drop(pass);
            encoder.finish()
        });
        commands.collect()
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

/// The parts, of at most so many indices, in which surfaces with these numbers of indices are drawn: of each part the
/// surfaces, and which of their indices. There is at least one part.
fn parts(counts: impl Iterator<Item = u32>, most: u32) -> Vec<Vec<(usize, Range<u32>)>> {
    let (mut parts, mut room) = (vec![Vec::new()], most);
    for (i, count) in counts.enumerate() {
        let mut from = 0;
        while from < count {
            if room == 0 {
                parts.push(Vec::new());
                room = most;
            }
            let to = from + room.min(count - from);
            parts.last_mut().into_iter().for_each(|part| part.push((i, from..to)));
            (from, room) = (to, room - (to - from));
        }
    }
    parts
}

fn begin<'a>(
    encoder: &'a mut wgpu::CommandEncoder,
    target: &Target,
    buffers: &Buffers,
    is: Place,
) -> wgpu::RenderPass<'a> {
    let (view, resolve_target) = match &buffers.colour {
        Some(colour) => (colour, Some(&target.picture).filter(|_| is.last)),
        None => (&target.picture, None),
    };
    let (discard, keep) = (wgpu::StoreOp::Discard, wgpu::StoreOp::Store);
    let store = if resolve_target.is_some() { discard } else { keep };
    let store_depth = if is.last { discard } else { keep };
    let (load, load_depth, load_stencil) = if is.first {
        (wgpu::LoadOp::Clear(wgpu::Color::BLACK), wgpu::LoadOp::Clear(1.0), wgpu::LoadOp::Clear(0))
    } else {
        (wgpu::LoadOp::Load, wgpu::LoadOp::Load, wgpu::LoadOp::Load)
    };
    encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: Some("scene"),
        color_attachments: &[Some(wgpu::RenderPassColorAttachment {
            view,
            depth_slice: None,
            resolve_target,
            ops: wgpu::Operations { load, store },
        })],
        depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
            view: &buffers.depth,
            depth_ops: Some(wgpu::Operations { load: load_depth, store: store_depth }),
            stencil_ops: Some(wgpu::Operations { load: load_stencil, store: store_depth }),
        }),
        ..Default::default()
    })
}

impl Pass<'_> {
    fn background(&mut self) {
        if self.select(Kind::Background, false) {
            self.pass.draw(0..3, 0..1);
        }
        self.batches();
    }

    fn all_but_surfaces(&mut self) {
        let opaque = 0..self.prepared.opaque;
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
            self.surface(Kind::SurfaceDepth, i, 0..u32::MAX);
            self.cap(i);
            self.surface(Kind::SurfaceBlended, i, 0..u32::MAX);
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
        self.pass.set_bind_group(0, self.frame, &[offset]);
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
        self.pass.set_bind_group(1, self.object, &[(i * self.renderer.stride) as u32]);
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

    /// Draws those of a surface's `indices` that there are.
    fn surface(&mut self, kind: Kind, i: usize, indices: Range<u32>) {
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
        self.pass.draw_indexed(indices.start..indices.end.min(mesh.index_count), 0, 0..1);
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
