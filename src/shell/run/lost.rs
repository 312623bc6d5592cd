//! The loss of the graphics device: it was unplugged, its driver has reset it, or it has no memory left. The window cannot
//! draw any more, so that the program keeps the unsaved work and ends.

use std::sync::{Arc, OnceLock};

use eframe::egui_wgpu::RenderState;

use super::SparkpathApp;

/// Reason why the graphics device was lost, if it was. Clones share it.
#[derive(Debug, Clone, Default)]
pub struct Lost(Arc<OnceLock<String>>);

impl Lost {
    /// Notes the loss of the device of `state`, or an error that it cannot go on after, and has a frame drawn then.
    pub(super) fn watch(state: &RenderState, ctx: &egui::Context) -> Self {
        let lost = Self::default();
        let (noted, wake) = (lost.clone(), ctx.clone());
        state.device.set_device_lost_callback(move |_, why| noted.note(&why, &wake));
        let (noted, wake) = (lost.clone(), ctx.clone());
        state.device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| noted.note(&error.to_string(), &wake)));
        lost
    }

    fn note(&self, why: &str, ctx: &egui::Context) {
        // The first error is the cause of those that follow it.
        let words: Vec<&str> = why.split_whitespace().collect();
        self.0.get_or_init(|| words.join(" "));
        ctx.request_repaint();
    }

    fn why(&self) -> Option<&str> {
        self.0.get().map(String::as_str)
    }
}

impl SparkpathApp {
    /// Keeps the unsaved work and closes the window if the graphics device is lost. Returns whether it is.
    pub(super) fn end_if_lost(&mut self, ctx: &egui::Context) -> bool {
        let Some(why) = self.lost.why().map(str::to_owned) else { return false };
        if self.ending.get().is_none() {
            let why = if why.is_empty() { "no reason is given" } else { &why };
            let work = match (self.is_unsaved(), self.autosave_now()) {
                (false, _) => "nothing was unsaved",
                (true, true) => "the unsaved work is kept, and offered at the next start",
                (true, false) => "the unsaved work could not be kept",
            };
            let text = format!("the graphics device was lost ({why}): {work}; start the program again");
            self.ending.get_or_init(|| text);
        }
        ctx.send_viewport_cmd(egui::ViewportCommand::Close);
        true
    }

    /// Why the program ends without its user having asked for it; set once it does. Clones share it.
    pub fn ending(&self) -> &Arc<OnceLock<String>> {
        &self.ending
    }
}
