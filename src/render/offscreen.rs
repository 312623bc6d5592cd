//! Pictures without a window.

use std::io::Cursor;

use image::RgbaImage;

use super::camera::Camera;
use super::renderer::{Quality, Renderer};
use super::scene::Scene;

/// Why there is no picture.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum RenderError {
    /// Neither a graphics card nor a software stand-in.
    #[error(
        "no graphics driver was found. Install the driver of the graphics card, or a software one \
         (Debian, Ubuntu: apt install mesa-vulkan-drivers libvulkan1)"
    )]
    NoAdapter,
    /// The driver is there but does not work.
    #[error(
        "the graphics driver of {adapter} does not work: {reason}. Update it, or install a software one (mesa-vulkan-drivers)"
    )]
    Device {
        /// Name of the adapter.
        adapter: String,
        /// What the driver said.
        reason: String,
    },
    /// A picture without pixels, or with more than the device can draw.
    #[error("a picture of {width} x {height} pixels cannot be drawn; each side must be 1 to {most}")]
    Size {
        /// Width asked for.
        width: u32,
        /// Height asked for.
        height: u32,
        /// Most pixels along a side.
        most: u32,
    },
    /// The finished picture did not come back.
    #[error("the graphics driver lost the picture: {0}. Try again, or try a smaller picture")]
    Lost(String),
    /// The picture could not be written as PNG.
    #[error("the picture could not be written as PNG: {0}")]
    Png(String),
}

/// What draws.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct AdapterInfo {
    /// Its name, for the user.
    pub name: String,
    /// Its driver and interface, for the user.
    pub driver: String,
    /// Whether it is the CPU that draws: right, but slow.
    pub is_software: bool,
}

/// A device of its own and a renderer on it.
pub struct Offscreen {
    device: wgpu::Device,
    queue: wgpu::Queue,
    renderer: Renderer,
    adapter: AdapterInfo,
}

impl Offscreen {
    /// Opens the best adapter there is.
    pub fn new() -> Result<Self, RenderError> {
        Err(RenderError::NoAdapter)
    }

    /// What draws.
    pub fn adapter(&self) -> &AdapterInfo {
        &self.adapter
    }

    /// The picture in full quality.
    pub fn image(&mut self, scene: &Scene, camera: &Camera, size: [u32; 2]) -> Result<RgbaImage, RenderError> {
        self.renderer.render(&self.device, &self.queue, scene, camera, size, Quality::Full);
        Err(RenderError::NoAdapter)
    }

    /// The picture in full quality as a PNG file.
    pub fn png(&mut self, scene: &Scene, camera: &Camera, size: [u32; 2]) -> Result<Vec<u8>, RenderError> {
        png_bytes(&self.image(scene, camera, size)?)
    }
}

/// `image` as a PNG file.
pub fn png_bytes(image: &RgbaImage) -> Result<Vec<u8>, RenderError> {
    let mut bytes = Cursor::new(Vec::new());
    image.write_to(&mut bytes, image::ImageFormat::Png).map_err(|e| RenderError::Png(e.to_string()))?;
    Ok(bytes.into_inner())
}
