//! The colours of the wheel's surfaces by class.

use std::sync::Arc;

use super::BliskDesk;
use crate::workspaces::blisk::document::stage::Stage;
use crate::workspaces::blisk::job::stages::{FoundChannel, Part};
use crate::workspaces::blisk::scene::surfaces::SurfaceMap;
use crate::workspaces::context::Context;
use crate::workspaces::news::EventKind;
use task::{Lane, Memo, Priority, Refusal, Same, Scheduler, State};

/// Colours of the surfaces of a part with a channel.
pub(super) type Classed = Memo<(Same<Part>, Same<FoundChannel>), SurfaceMap>;

/// The memo of the colours.
pub(super) fn classed(scheduler: &Scheduler) -> Classed {
    Memo::new(scheduler, Lane::Quick, "Surfaces").remembering(2)
}

impl BliskDesk {
    /// Shows the surfaces of the wheel in the colours of their classes, or the plain wheel again.
    pub fn toggle_surfaces(&mut self) {
        self.surfaces = !self.surfaces;
        // One legend at a time.
        self.colours &= !self.surfaces;
    }

    fn classed_key(&self) -> Option<(Same<Part>, Same<FoundChannel>)> {
        let is_known = self.surfaces && self.work.state(Stage::Channel) == State::Ready;
        let (part, found) = self.work.part().zip(self.work.channel()).filter(|_| is_known)?;
        Some((Same(part.clone()), Same(found.clone())))
    }

    /// Tells the surfaces apart, if their colours are shown.
    pub(super) fn follow_surfaces(&mut self, cx: &mut Context) {
        while let Some(ended) = self.classed.take() {
            if let Err(Refusal::Failed(why)) = ended.result {
                cx.say(EventKind::Failed, format!("the surfaces are not coloured: {why}"));
            }
        }
        let Some(key) = self.classed_key() else { return };
        if !self.classed.wants(&key) {
            return self.classed.turn_to(&key);
        }
        let (part, found) = (key.0.0.clone(), key.1.0.clone());
        self.classed.ask(&key, Priority::Shown, move |work| {
            let face_of = part.faces.as_ref().map_or(&[][..], |cad| &cad.face_of);
            SurfaceMap::new(&part.mesh, &found.channel, face_of, &work.task).map_err(|e| e.to_string())
        });
    }

    /// The surfaces of the wheel in colours, if they are shown and known.
    pub fn surface_map(&self) -> Option<&Arc<SurfaceMap>> {
        self.classed.get(&self.classed_key()?)
    }

    /// Whether the surfaces are being told apart.
    pub fn is_classing(&self) -> bool {
        self.classed.is_busy()
    }
}
