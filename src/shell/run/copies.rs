//! Copies of unsaved work, which are brought up to date while the window is open.

use std::time::Duration;

use super::SparkpathApp;
use crate::workspaces::news::EventKind;

/// Interval of copies of unsaved work (s).
pub(super) const EVERY: f64 = 1.0;

impl SparkpathApp {
    /// Updates the copies of unsaved work. Returns whether every copy could be written.
    pub(super) fn autosave_now(&mut self) -> bool {
        let Some(autosave) = &mut self.autosave else { return false };
        // One that fails keeps no other from its copy; it is tried again next time.
        let failed: Vec<String> = self
            .workspaces
            .iter()
            .filter_map(|one| autosave.update(one.document()).err())
            .map(|e| format!("the unsaved work could not be copied: {e}"))
            .collect();
        if self.not_copied != failed {
            // Whatever changes in a document, it is said until there are copies again.
            failed.iter().for_each(|text| self.cx.say(EventKind::Failed, text));
            if failed.is_empty() {
                self.cx.say(EventKind::Done, "the unsaved work is copied again");
            }
            self.not_copied = failed;
        }
        self.not_copied.is_empty()
    }

    /// Updates the copies of unsaved work in time, and requests frames for that and while work is under way.
    pub(super) fn keep_up(&mut self, ctx: &egui::Context) {
        // What was given up on purpose is not kept again while the window closes.
        if !self.quitting && self.autosave.as_mut().is_some_and(|autosave| autosave.is_due(self.cx.now)) {
            self.autosave_now();
        }
        if let Some(autosave) = &mut self.autosave {
            self.workspaces.iter().for_each(|one| autosave.discard_saved(one.document()));
        }
        if self.is_unsaved()
            && let Some(autosave) = &self.autosave
        {
            ctx.request_repaint_after(Duration::from_secs_f64(autosave.due_in(self.cx.now).clamp(0.01, EVERY)));
        }
        if self.is_busy() {
            // Time left and elapsed go on even while nothing is reported.
            ctx.request_repaint_after(Duration::from_millis(250));
        }
        self.cx.take_wake().into_iter().for_each(|wait| ctx.request_repaint_after(wait));
    }
}
