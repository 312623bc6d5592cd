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

/// What pictures are drawn with, or the reason why none can be.
pub(super) struct Studio(Result<Offscreen, String>);

/// Colours of a picture with what they stand for.
pub(super) type Legend<'a> = &'a [(Colour, String)];

impl Studio {
    pub(super) fn new() -> Self {
        Self(Offscreen::new().map_err(|error| error.to_string()))
    }

    /// A sentence to follow others on why there are no pictures; empty where there are.
    pub(super) fn note(&self) -> String {
        self.0.as_ref().err().map_or_else(String::new, |why| format!(" Its pictures are left out: {why}."))
    }

    /// `views` side by side in rows of two, each of the given size (pixels), as a PNG file; none where nothing can be
    /// drawn.
    pub(super) fn sheet(
        &mut self,
        views: &[View],
        size: [u32; 2],
        task: &Task,
    ) -> Result<Option<Vec<u8>>, RenderError> {
        let Some(images) = self.images(views, size, task)? else { return Ok(None) };
        let [columns, rows] = [views.len().min(2) as u32, views.len().div_ceil(2) as u32];
        let mut sheet = RgbaImage::new(columns * size[0], rows * size[1]);
        for (i, image) in images.iter().enumerate() {
            let [x, y] = [i as u32 % 2 * size[0], i as u32 / 2 * size[1]].map(i64::from);
            imageops::replace(&mut sheet, image, x, y);
        }
        png_bytes(&sheet, &task.cancel).map(Some)
    }

    /// `views` one after the other as an animated PNG file; none where nothing can be drawn.
    pub(super) fn animation(
        &mut self,
        views: &[View],
        size: [u32; 2],
        task: &Task,
    ) -> Result<Option<Vec<u8>>, RenderError> {
        /// Time of each picture (ms).
        const SHOWN: u16 = 90;
        let Some(images) = self.images(views, size, task)? else { return Ok(None) };
        animated_png(&images, SHOWN, &task.cancel).map(Some)
    }

    fn images(&mut self, views: &[View], size: [u32; 2], task: &Task) -> Result<Option<Vec<RgbaImage>>, RenderError> {
        let Ok(offscreen) = &mut self.0 else { return Ok(None) };
        let image = |(scene, camera): &View| offscreen.image_until(scene, camera, size, &task.cancel);
        views.iter().map(image).collect::<Result<_, _>>().map(Some)
    }
}

/// A picture of the page, if there is one.
pub(super) fn picture(title: &str, caption: String, legend: Legend, png: Option<Vec<u8>>) -> Option<Picture> {
    let css = |c: &Colour| format!("#{:02x}{:02x}{:02x}", c.r, c.g, c.b);
    let legend = legend.iter().map(|(colour, meaning)| (css(colour), meaning.clone())).collect();
    Some(Picture { file: String::new(), title: title.to_owned(), caption, legend, png: png? })
}
