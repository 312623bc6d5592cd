//! The textures that a picture is drawn into.

use super::FORMAT;
use super::pipelines::DEPTH_FORMAT;

/// Sizes that are kept: one at rest and one while the view moves.
const KEPT: usize = 2;

/// Textures of one size.
pub struct Target {
    pub size: [u32; 2],
    /// The finished picture.
    pub picture: wgpu::TextureView,
    /// Colours before they are resolved, and depths, for each number of samples that was asked for.
    buffers: Vec<Buffers>,
}

/// Textures of one size and number of samples.
pub struct Buffers {
    samples: u32,
    pub depth: wgpu::TextureView,
    /// Only for more than one sample.
    pub colour: Option<wgpu::TextureView>,
}

/// The targets of the last sizes.
#[derive(Default)]
pub struct Targets {
    kept: Vec<Target>,
}

impl Targets {
    /// The target of this size, made if there is none; it is then the [`current`](Self::current) one.
    pub fn select(&mut self, device: &wgpu::Device, size: [u32; 2], samples: u32) {
        match self.kept.iter().position(|t| t.size == size) {
            Some(at) => self.kept[..=at].rotate_right(1),
            None => {
                let usages = wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_SRC;
                let picture = texture(device, size, 1, FORMAT, usages);
                self.kept.insert(0, Target { size, picture, buffers: Vec::new() });
                self.kept.truncate(KEPT);
            }
        }
        let buffers = &mut self.kept[0].buffers;
        if !buffers.iter().any(|b| b.samples == samples) {
            let none = wgpu::TextureUsages::empty();
            let depth = texture(device, size, samples, DEPTH_FORMAT, none);
            let colour = (samples > 1).then(|| texture(device, size, samples, FORMAT, none));
            buffers.push(Buffers { samples, depth, colour });
        }
    }

    /// The target selected last.
    pub fn current(&self) -> Option<&Target> {
        self.kept.first()
    }
}

impl Target {
    /// Its buffers for a number of samples.
    pub fn buffers(&self, samples: u32) -> Option<&Buffers> {
        self.buffers.iter().find(|b| b.samples == samples)
    }
}

fn texture(
    device: &wgpu::Device,
    [width, height]: [u32; 2],
    sample_count: u32,
    format: wgpu::TextureFormat,
    usages: wgpu::TextureUsages,
) -> wgpu::TextureView {
    device
        .create_texture(&wgpu::TextureDescriptor {
            label: Some("picture"),
            size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT | usages,
            view_formats: &[],
        })
        .create_view(&Default::default())
}
