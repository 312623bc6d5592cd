//! Pictures without a window.

use std::io::Write;
use std::sync::{Arc, Mutex, mpsc};
use std::time::Duration;

use image::RgbaImage;

use super::camera::Camera;
use super::renderer::{Quality, Renderer};
use super::scene::Scene;
use task::{Cancel, Cancelled};

/// How long is waited for the driver between two looks at the cancel flag.
const PATIENCE: Duration = Duration::from_millis(30);
/// Rows of a picture that are compressed between two looks.
const ROWS: usize = 32;

/// Reason why there is no picture.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum RenderError {
    /// Cancelled.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    /// Neither a graphics card nor a software stand-in.
    #[error(
        "no graphics driver was found. Install the driver of the graphics card, or a software one \
         (Debian, Ubuntu: apt install mesa-vulkan-drivers libvulkan1)"
    )]
    NoAdapter,
    /// The driver is there but does not work.
    #[error(
        "the graphics driver of {adapter} does not work: {reason}. Update it, or install a software one \
         (Debian, Ubuntu: apt install mesa-vulkan-drivers libvulkan1)"
    )]
    Device {
        /// Name of the adapter.
        adapter: String,
        /// Message of the driver.
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

/// Graphics adapter that draws.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct AdapterInfo {
    /// Name, for the user.
    pub name: String,
    /// Interface and driver, for the user.
    pub driver: String,
    /// Whether it is the CPU that draws: right, but slow.
    pub is_software: bool,
}

/// A device of its own and a renderer on it.
pub struct Offscreen {
    device: wgpu::Device,
    queue: wgpu::Queue,
    pub(super) renderer: Renderer,
    adapter: AdapterInfo,
    /// Error of the driver since the last picture. Without a handler it would end the program.
    refused: Arc<Mutex<Option<String>>>,
}

impl Offscreen {
    /// Opens the fastest adapter there is, of those that the environment variable `WGPU_BACKEND` leaves if set.
    pub fn new() -> Result<Self, RenderError> {
        // OpenGL only where there is nothing better: merely asking for it makes some drivers complain aloud.
        let adapter = adapter(wgpu::Backends::PRIMARY).or_else(|| adapter(wgpu::Backends::SECONDARY));
        let adapter = adapter.ok_or(RenderError::NoAdapter)?;
        let info = adapter.get_info();
        let descriptor = wgpu::DeviceDescriptor {
            label: Some("pictures"),
            // All that the adapter has: large pictures and large meshes.
            required_limits: adapter.limits(),
            ..Default::default()
        };
        let (device, queue) = pollster::block_on(adapter.request_device(&descriptor))
            .map_err(|e| RenderError::Device { adapter: info.name.clone(), reason: e.to_string() })?;
        let refused = Arc::new(Mutex::new(None));
        let told = refused.clone();
        device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| {
            if let Ok(mut first) = told.lock() {
                first.get_or_insert_with(|| error.to_string().split_whitespace().collect::<Vec<_>>().join(" "));
            }
        }));
        let adapter = AdapterInfo {
            driver: format!("{:?} {} {}", info.backend, info.driver, info.driver_info).trim_end().to_owned(),
            is_software: Renderer::is_software(&device),
            name: info.name,
        };
        Ok(Self { renderer: Renderer::new(&device, &queue), device, queue, adapter, refused })
    }

    /// Graphics adapter that draws.
    pub fn adapter(&self) -> &AdapterInfo {
        &self.adapter
    }

    /// The picture in full quality.
    pub fn image(&mut self, scene: &Scene, camera: &Camera, size: [u32; 2]) -> Result<RgbaImage, RenderError> {
        self.image_until(scene, camera, size, &Cancel::default())
    }

    /// The picture in full quality, unless told to stop.
    pub fn image_until(
        &mut self,
        scene: &Scene,
        camera: &Camera,
        size: [u32; 2],
        cancel: &Cancel,
    ) -> Result<RgbaImage, RenderError> {
        let [width, height] = size;
        let most = self.device.limits().max_texture_dimension_2d;
        if width.min(height) == 0 || width.max(height) > most {
            return Err(RenderError::Size { width, height, most });
        }
        self.draw_until(scene, camera, size, Quality::Full, cancel)?;
        self.read_back()
    }

    /// The picture in full quality as a PNG file.
    pub fn png(
        &mut self,
        scene: &Scene,
        camera: &Camera,
        size: [u32; 2],
        cancel: &Cancel,
    ) -> Result<Vec<u8>, RenderError> {
        png_bytes(&self.image_until(scene, camera, size, cancel)?, cancel)
    }

    /// Draws and waits until it is done, without reading the picture back.
    pub fn draw(
        &mut self,
        scene: &Scene,
        camera: &Camera,
        size: [u32; 2],
        quality: Quality,
    ) -> Result<(), RenderError> {
        self.draw_until(scene, camera, size, quality, &Cancel::default())
    }

    fn draw_until(
        &mut self,
        scene: &Scene,
        camera: &Camera,
        size: [u32; 2],
        quality: Quality,
        cancel: &Cancel,
    ) -> Result<(), RenderError> {
        cancel.check()?;
        let (_, parts) = self.renderer.commands(&self.device, &self.queue, scene, camera, size, quality);
        for part in parts {
            self.queue.submit([part]);
            self.wait(cancel)?;
        }
        Ok(())
    }

    /// The picture drawn last.
    pub fn read_back(&self) -> Result<RgbaImage, RenderError> {
        let lost = |reason: &str| RenderError::Lost(reason.to_owned());
        let texture = self.renderer.picture().ok_or_else(|| lost("nothing was drawn"))?;
        let [width, height] = self.renderer.picture_size();
        // Rows of a copy begin at multiples of this.
        let row = (4 * width).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
        let buffer = self.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("picture"),
            size: u64::from(row) * u64::from(height),
            usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
            mapped_at_creation: false,
        });
        let mut encoder = self.device.create_command_encoder(&Default::default());
        let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(row), rows_per_image: None };
        encoder.copy_texture_to_buffer(
            texture.as_image_copy(),
            wgpu::TexelCopyBufferInfo { buffer: &buffer, layout },
            texture.size(),
        );
        self.queue.submit([encoder.finish()]);
        let (sender, receiver) = mpsc::channel();
        buffer.slice(..).map_async(wgpu::MapMode::Read, move |answer| drop(sender.send(answer)));
        self.wait(&Cancel::default())?;
        let answer = receiver.recv().map_err(|_| lost("no answer"))?;
        answer.map_err(|e| lost(&e.to_string()))?;
        let mapped = buffer.slice(..).get_mapped_range().map_err(|e| lost(&e.to_string()))?;
        let pixels = mapped.chunks(row as usize).flat_map(|r| &r[..4 * width as usize]).copied().collect();
        RgbaImage::from_raw(width, height, pixels).ok_or_else(|| lost("rows are missing"))
    }

    /// Waits until everything is drawn.
    fn wait(&self, cancel: &Cancel) -> Result<(), RenderError> {
        loop {
            cancel.check()?;
            match self.device.poll(wgpu::PollType::Wait { submission_index: None, timeout: Some(PATIENCE) }) {
                Ok(_) => break,
                Err(wgpu::PollError::Timeout) => {}
                Err(error) => return Err(RenderError::Lost(error.to_string())),
            }
        }
        match self.refused.lock().ok().and_then(|mut first| first.take()) {
            Some(reason) => Err(RenderError::Lost(reason)),
            None => Ok(()),
        }
    }
}

/// The fastest adapter behind these interfaces.
fn adapter(backends: wgpu::Backends) -> Option<wgpu::Adapter> {
    let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle();
    descriptor.backends = backends;
    let instance = wgpu::Instance::new(descriptor.with_env());
    let options =
        wgpu::RequestAdapterOptions { power_preference: wgpu::PowerPreference::HighPerformance, ..Default::default() };
    pollster::block_on(instance.request_adapter(&options)).ok()
}

/// `images`, all of one size, as an animated PNG file that repeats for ever; each is shown for `milliseconds`.
///
/// # Errors
/// [`RenderError::Png`] if there is none or their sizes differ; when cancelled.
pub fn animated_png(images: &[RgbaImage], milliseconds: u16, cancel: &Cancel) -> Result<Vec<u8>, RenderError> {
    let failed = |e: png::EncodingError| RenderError::Png(e.to_string());
    let size = images.first().map_or((0, 0), RgbaImage::dimensions);
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, size.0, size.1);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_compression(png::Compression::Balanced);
    encoder.set_filter(png::Filter::Adaptive);
    encoder.set_animated(images.len() as u32, 0).map_err(failed)?;
    encoder.set_frame_delay(milliseconds, 1000).map_err(failed)?;
    let mut writer = encoder.write_header().map_err(failed)?;
    for image in images {
        cancel.check()?;
        if image.dimensions() != size {
            return Err(RenderError::Png("the pictures of an animation differ in size".to_owned()));
        }
        let opaque: Vec<u8> = image.as_raw().chunks_exact(4).flat_map(|pixel| &pixel[..3]).copied().collect();
        writer.write_image_data(&opaque).map_err(failed)?;
    }
    writer.finish().map_err(failed)?;
    Ok(bytes)
}

/// `image` as a PNG file.
pub fn png_bytes(image: &RgbaImage, cancel: &Cancel) -> Result<Vec<u8>, RenderError> {
    let failed = |e: png::EncodingError| RenderError::Png(e.to_string());
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, image.width(), image.height());
    // Pictures have no holes: without the fourth channel the file is a good deal smaller.
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_compression(png::Compression::Balanced);
    encoder.set_filter(png::Filter::Adaptive);
    let mut writer = encoder.write_header().map_err(failed)?;
    let mut stream = writer.stream_writer().map_err(failed)?;
    for rows in image.as_raw().chunks((4 * image.width() as usize * ROWS).max(1)) {
        cancel.check()?;
        let opaque: Vec<u8> = rows.chunks_exact(4).flat_map(|pixel| &pixel[..3]).copied().collect();
        stream.write_all(&opaque).map_err(|e| RenderError::Png(e.to_string()))?;
    }
    stream.finish().map_err(failed)?;
    writer.finish().map_err(failed)?;
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_animation_has_every_picture_in_order_and_repeats() {
        let images: Vec<RgbaImage> =
            [10, 120, 240].iter().map(|grey| RgbaImage::from_pixel(7, 5, image::Rgba([*grey; 4]))).collect();
        let bytes = animated_png(&images, 80, &Cancel::default()).unwrap();
        let mut reader = png::Decoder::new(std::io::Cursor::new(&bytes)).read_info().unwrap();
        let control = *reader.info().animation_control().unwrap();
        assert_eq!((control.num_frames, control.num_plays), (3, 0));
        for grey in [10, 120, 240] {
            let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
            reader.next_frame(&mut pixels).unwrap();
            assert!(pixels.len() == 7 * 5 * 3 && pixels.iter().all(|value| *value == grey));
        }
        assert!(animated_png(&[], 80, &Cancel::default()).is_err());
        let unlike = [images[0].clone(), RgbaImage::new(4, 4)];
        assert!(animated_png(&unlike, 80, &Cancel::default()).is_err());
    }
}
