//! The textures that a picture is drawn into.

use super::FORMAT;
use super::pipelines::DEPTH_FORMAT;

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

/// The target of the last picture and that of another size before it: the view at rest and in motion.
#[derive(Default)]
pub struct Targets {
    current: Option<Target>,
    other: Option<Target>,
}

impl Targets {
    /// The target of this size, made if there is none; it is then the [`current`](Self::current) one.
    pub fn select(&mut self, device: &wgpu::Device, size: [u32; 2], samples: u32) -> &Target {
        let fits = |t: &mut Target| t.size == size;
        let target = match self.current.take_if(fits) {
            Some(current) => current,
            None => {
                let known = self.other.take_if(fits);
                self.other = self.current.take();
                known.unwrap_or_else(|| Target::new(device, size))
            }
        };
        let target = self.current.insert(target);
        target.add_buffers(device, samples);
        target
    }

    /// The target selected last.
    pub fn current(&self) -> Option<&Target> {
        self.current.as_ref()
    }
}

impl Target {
    fn new(device: &wgpu::Device, size: [u32; 2]) -> Self {
        let usages = wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_SRC;
        Self { size, picture: texture(device, size, 1, FORMAT, usages), buffers: Vec::new() }
    }

    /// Makes the buffers for a number of samples if there are none.
    fn add_buffers(&mut self, device: &wgpu::Device, samples: u32) {
        if self.buffers(samples).is_none() {
            let none = wgpu::TextureUsages::empty();
            let depth = texture(device, self.size, samples, DEPTH_FORMAT, none);
            let colour = (samples > 1).then(|| texture(device, self.size, samples, FORMAT, none));
            self.buffers.push(Buffers { samples, depth, colour });
        }
    }

    /// Buffers for a number of samples.
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
