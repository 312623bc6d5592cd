//! Pictures of the results of P0: several views in one picture, and an animation.

use image::{RgbaImage, imageops};

use files::report::Picture;
use render::camera::Camera;
use render::colour::Colour;
use render::offscreen::{Offscreen, RenderError, animated_png, png_bytes};
use render::scene::Scene;
use task::Task;

/// A view of a scene.
pub(super) type View = (Scene, Camera);

/// What pictures are drawn with.
pub(super) struct Studio(Offscreen);

/// Colours of a picture with what they stand for.
pub(super) type Legend<'a> = &'a [(Colour, String)];

impl Studio {
    pub(super) fn new() -> Result<Self, RenderError> {
        Offscreen::new().map(Self)
    }

    /// `views` side by side in rows of two, each of the given size (pixels), as a PNG file.
    pub(super) fn sheet(&mut self, views: &[View], size: [u32; 2], task: &Task) -> Result<Vec<u8>, RenderError> {
        let [columns, rows] = [views.len().min(2) as u32, views.len().div_ceil(2) as u32];
        let mut sheet = RgbaImage::new(columns * size[0], rows * size[1]);
        for (i, image) in self.images(views, size, task)?.iter().enumerate() {
            let [x, y] = [i as u32 % 2 * size[0], i as u32 / 2 * size[1]].map(i64::from);
            imageops::replace(&mut sheet, image, x, y);
        }
        png_bytes(&sheet, &task.cancel)
    }

    /// `views` one after the other as an animated PNG file.
    pub(super) fn animation(&mut self, views: &[View], size: [u32; 2], task: &Task) -> Result<Vec<u8>, RenderError> {
        /// Time of each picture (ms).
        const SHOWN: u16 = 90;
        animated_png(&self.images(views, size, task)?, SHOWN, &task.cancel)
    }

    fn images(&mut self, views: &[View], size: [u32; 2], task: &Task) -> Result<Vec<RgbaImage>, RenderError> {
        let image = |(scene, camera): &View| self.0.image_until(scene, camera, size, &task.cancel);
        views.iter().map(image).collect()
    }
}

/// A picture of the page.
pub(super) fn picture(title: &str, caption: String, legend: Legend, png: Vec<u8>) -> Picture {
    let css = |c: &Colour| format!("#{:02x}{:02x}{:02x}", c.r, c.g, c.b);
    let legend = legend.iter().map(|(colour, meaning)| (css(colour), meaning.clone())).collect();
    Picture { file: String::new(), title: title.to_owned(), caption, legend, png }
}
