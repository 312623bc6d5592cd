//! Pictures of the view, drawn and written on a thread of their own: a software renderer takes seconds for one.

use std::path::{Path, PathBuf};

use crate::workspaces::worker::{Ended, Message, Worker};
use files::atomic::atomic_write;
use render::camera::Camera;
use render::offscreen::Offscreen;
use render::scene::Scene;
use task::Cancel;

/// Width and height (pixels).
const SIZE: [u32; 2] = [1920, 1200];

/// The pictures that are being written.
pub struct Pictures {
    worker: Worker<(), PathBuf>,
    asked: u32,
}

impl Pictures {
    /// None yet; `wake` is called whenever one is written.
    ///
    /// # Errors
    /// If the system gives no thread.
    pub fn start(wake: impl Fn() + Send + Sync + 'static) -> std::io::Result<Self> {
        Ok(Self { worker: Worker::start(wake)?, asked: 0 })
    }

    /// Has `scene` drawn and written to `path`, after those asked for before.
    pub fn write(&mut self, path: &Path, scene: Scene, camera: Camera) {
        // In a slot of its own no picture takes another's place.
        self.asked += 1;
        let path = path.to_owned();
        self.worker.submit(self.asked, move |_, task| {
            draw(&path, &scene, &camera, &task.cancel).map_err(|e| format!("{}: {e}", path.display()))?;
            Ok(path)
        });
    }

    /// What became of pictures since the last call: the file of each, or why there is none.
    pub fn written(&self) -> Vec<Result<PathBuf, String>> {
        let messages = self.worker.messages().into_iter();
        let ended = messages.filter_map(|m| if let Message::Finished(_, ended) = m { Some(ended) } else { None });
        ended
            .filter_map(|ended| match ended {
                Ended::Done(path) => Some(Ok(path)),
                Ended::Failed(why) | Ended::Panicked(why) => Some(Err(why)),
                Ended::Cancelled => None,
            })
            .collect()
    }
}

fn draw(path: &Path, scene: &Scene, camera: &Camera, cancel: &Cancel) -> Result<(), String> {
    let mut offscreen = Offscreen::new().map_err(|e| e.to_string())?;
    let png = offscreen.png(scene, camera, SIZE, cancel).map_err(|e| e.to_string())?;
    atomic_write(path, |out| out.write_all(&png)).map_err(|e| e.to_string())
}
