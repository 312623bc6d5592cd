//! Connection to the renderer: draws a scene when it has changed, and shows the picture in every frame.

use std::sync::Arc;

use eframe::egui_wgpu::{self, CallbackResources, CallbackTrait, ScreenDescriptor};

use render::camera::Camera;
use render::renderer::{Quality, Renderer};
use render::scene::Scene;

/// State beside the window's own GPU state.
struct Gpu {
    renderer: Renderer,
    pipeline: wgpu::RenderPipeline,
    sampler: wgpu::Sampler,
    shown: Option<Shown>,
}

/// Picture drawn last.
struct Shown {
    scene: Arc<Scene>,
    camera: Camera,
    size: [u32; 2],
    quality: Quality,
    bind: wgpu::BindGroup,
}

/// Prepares the window's GPU state for [`Picture`]s.
pub fn install(state: &egui_wgpu::RenderState) {
    let gpu = Gpu::new(&state.device, &state.queue, state.target_format);
    state.renderer.write().callback_resources.insert(gpu);
}

impl Gpu {
    fn new(device: &wgpu::Device, queue: &wgpu::Queue, format: wgpu::TextureFormat) -> Self {
        let shader = device.create_shader_module(wgpu::include_wgsl!("../../shaders/blit.wgsl"));
        let pipeline = device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some("picture"),
            layout: None,
            vertex: wgpu::VertexState {
                module: &shader,
                entry_point: Some("vertex"),
                compilation_options: Default::default(),
                buffers: &[],
            },
            primitive: Default::default(),
            depth_stencil: None,
            multisample: Default::default(),
            fragment: Some(wgpu::FragmentState {
                module: &shader,
                entry_point: Some("fragment"),
                compilation_options: Default::default(),
                targets: &[Some(format.into())],
            }),
            multiview_mask: None,
            cache: None,
        });
        let sampler = device.create_sampler(&wgpu::SamplerDescriptor {
            mag_filter: wgpu::FilterMode::Linear,
            min_filter: wgpu::FilterMode::Linear,
            ..Default::default()
        });
        Self { renderer: Renderer::new(device, queue), pipeline, sampler, shown: None }
    }

    fn draw(&mut self, device: &wgpu::Device, queue: &wgpu::Queue, picture: &Picture) {
        let Picture { scene, camera, size, quality } = picture;
        let same =
            |s: &Shown| Arc::ptr_eq(&s.scene, scene) && s.camera == *camera && s.size == *size && s.quality == *quality;
        if self.shown.as_ref().is_some_and(same) {
            return;
        }
        let view = self.renderer.render(device, queue, scene, camera, *size, *quality);
        let bind = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("picture"),
            layout: &self.pipeline.get_bind_group_layout(0),
            entries: &[
                wgpu::BindGroupEntry { binding: 0, resource: wgpu::BindingResource::TextureView(&view) },
                wgpu::BindGroupEntry { binding: 1, resource: wgpu::BindingResource::Sampler(&self.sampler) },
            ],
        });
        let (scene, camera) = (scene.clone(), *camera);
        self.shown = Some(Shown { scene, camera, size: *size, quality: *quality, bind });
    }
}

/// A picture to show in the window.
pub struct Picture {
    /// Scene of the picture.
    pub scene: Arc<Scene>,
    /// Camera of the picture.
    pub camera: Camera,
    /// Width and height (pixels).
    pub size: [u32; 2],
    /// Quality of the drawing.
    pub quality: Quality,
}

impl CallbackTrait for Picture {
    fn prepare(
        &self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        _screen: &ScreenDescriptor,
        _encoder: &mut wgpu::CommandEncoder,
        resources: &mut CallbackResources,
    ) -> Vec<wgpu::CommandBuffer> {
        if let Some(gpu) = resources.get_mut::<Gpu>() {
            gpu.draw(device, queue, self);
        }
        Vec::new()
    }

    fn paint(
        &self,
        _info: egui::PaintCallbackInfo,
        pass: &mut wgpu::RenderPass<'static>,
        resources: &CallbackResources,
    ) {
        let Some(gpu) = resources.get::<Gpu>() else { return };
        let Some(shown) = &gpu.shown else { return };
        pass.set_pipeline(&gpu.pipeline);
        pass.set_bind_group(0, &shown.bind, &[]);
        pass.draw(0..3, 0..1);
    }
}
