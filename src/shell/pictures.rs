//! Pictures of the view, drawn and written one after the other: a software renderer takes seconds for each.

use std::path::{Path, PathBuf};

use files::atomic::atomic_write;
use render::camera::Camera;
use render::offscreen::Offscreen;
use render::scene::Scene;
use task::{Cancel, Lane, Memo, Priority, Refusal, Scheduler};

/// Width and height (pixels).
const SIZE: [u32; 2] = [1920, 1200];

/// The pictures being written, each in its own memo, so that none replaces another.
#[derive(Default)]
pub struct Pictures(Vec<Memo<PathBuf, ()>>);

impl Pictures {
    /// Draws `scene` and writes it to `path`, after earlier pictures.
    pub fn write(&mut self, path: &Path, scene: Scene, camera: Camera, scheduler: &Scheduler) {
        let (mut memo, file) = (Memo::new(scheduler, Lane::Quick, "Picture").awaiting_the_end(), path.to_owned());
        memo.restart(&path.to_owned(), Priority::Normal, move |work| {
            draw(&file, &scene, &camera, &work.task.cancel).map_err(|e| format!("{}: {e}", file.display()))
        });
        self.0.push(memo);
    }

    /// Whether a picture is being written.
    pub fn is_busy(&self) -> bool {
        !self.0.is_empty()
    }

    /// Pictures finished since the last call: the file of each, or the reason why there is none.
    pub fn written(&mut self) -> Vec<Result<PathBuf, String>> {
        let ended: Vec<_> = self.0.iter_mut().filter_map(Memo::take).collect();
        self.0.retain(Memo::is_busy);
        let said = ended.into_iter().filter_map(|ended| match ended.result {
            Ok(_) => Some(Ok(ended.key)),
            Err(Refusal::Failed(why)) => Some(Err(why)),
            Err(Refusal::Cancelled) => None,
        });
        said.collect()
    }
}

fn draw(path: &Path, scene: &Scene, camera: &Camera, cancel: &Cancel) -> Result<(), String> {
    let mut offscreen = Offscreen::new().map_err(|e| e.to_string())?;
    let png = offscreen.png(scene, camera, SIZE, cancel).map_err(|e| e.to_string())?;
    atomic_write(path, |out| out.write_all(&png)).map_err(|e| e.to_string())
}
