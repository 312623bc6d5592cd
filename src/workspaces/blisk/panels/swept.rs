//! The room that the electrode passes through, made when it is to be seen on a thread of its own.

use std::sync::Arc;

use crate::workspaces::blisk::scene::sweep::{FINE, swept_shape};
use crate::workspaces::blisk::scene::track::Track;
use crate::workspaces::worker::{Ended, Message, Worker};
use render::mesh::RenderMesh;
use wheel::electrode::Electrode;

/// The room that belongs to one track.
pub struct Swept {
    worker: Worker<(), (Arc<Track>, Arc<RenderMesh>)>,
    asked: Option<Arc<Track>>,
    made: Option<(Arc<Track>, Arc<RenderMesh>)>,
    failure: Option<String>,
}

impl Swept {
    /// Nothing yet; `wake` is called whenever there is something new.
    ///
    /// # Errors
    /// If the system gives no thread.
    pub fn start(wake: impl Fn() + Send + Sync + 'static) -> std::io::Result<Self> {
        Ok(Self { worker: Worker::start(wake)?, asked: None, made: None, failure: None })
    }

    /// Takes in what was made. Tells whether `track` is wanted and nobody was asked for its room yet; if nothing is
    /// wanted, what there is is let go.
    pub fn lacks(&mut self, wanted: Option<&Arc<Track>>) -> bool {
        for message in self.worker.messages() {
            match message {
                Message::Finished(_, Ended::Done(made)) => self.made = Some(made),
                Message::Finished(_, Ended::Failed(why) | Ended::Panicked(why)) => self.failure = Some(why),
                _ => {}
            }
        }
        let Some(track) = wanted else {
            if self.asked.take().is_some() {
                self.worker.cancel_from(0);
            }
            self.made = None;
            return false;
        };
        !self.asked.as_ref().is_some_and(|asked| Arc::ptr_eq(asked, track))
    }

    /// Has the room made that `electrode` passes through along `track`, in place of any other.
    pub fn make(&mut self, track: Arc<Track>, electrode: Electrode) {
        self.asked = Some(track.clone());
        self.worker.submit(0, move |_, task| {
            let shape = swept_shape(&electrode, &track, FINE, task).map_err(|e| e.to_string())?;
            Ok((track, shape))
        });
    }

    /// Why a room could not be made, once.
    pub fn take_failure(&mut self) -> Option<String> {
        self.failure.take()
    }

    /// The room that belongs to `track`, in W, once it is made.
    pub fn shape(&self, track: &Arc<Track>) -> Option<&Arc<RenderMesh>> {
        self.made.as_ref().filter(|(of, _)| Arc::ptr_eq(of, track)).map(|(_, shape)| shape)
    }
}
