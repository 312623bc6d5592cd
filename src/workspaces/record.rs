//! What every workspace with a document of its own keeps of it beside its parameters: the file, the steps that can be
//! undone, and what the hands of the user do.

use std::path::{Path, PathBuf};

use files::old_history::History;

/// What the hands of the user do.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Hands {
    /// Nothing.
    #[default]
    Idle,
    /// They hold a button of the mouse down: what is dragged is not at rest.
    Holding,
    /// They type.
    Typing,
}

impl Hands {
    /// What they do now.
    pub fn of(ctx: &egui::Context) -> Self {
        match (ctx.input(|i| i.pointer.any_down()), ctx.egui_wants_keyboard_input()) {
            (true, _) => Self::Holding,
            (false, true) => Self::Typing,
            (false, false) => Self::Idle,
        }
    }
}

/// The file of a document, its steps that can be undone, and what the hands do. `P` are the parameters.
#[derive(Debug, Clone)]
pub struct Record<P> {
    /// The file of the document.
    pub file: Option<PathBuf>,
    /// What that file holds, or else what the document was opened with; none if no file holds anything of it.
    pub kept: Option<P>,
    /// The steps that can be undone.
    pub history: History<P>,
    hands: Hands,
    /// The number of what the hands are doing, whose changes make one step.
    gesture: u64,
}

impl<P: Clone + PartialEq> Record<P> {
    /// That of a document which nobody has touched.
    pub fn of(params: &P) -> Self {
        Self { file: None, kept: Some(params.clone()), history: History::default(), hands: Hands::Idle, gesture: 0 }
    }

    /// Begins anew with `params`, which are those of `file` if there is one.
    pub fn replace(&mut self, params: &P, file: Option<&Path>) {
        (self.file, self.kept) = (file.map(Path::to_owned), Some(params.clone()));
        self.history = History::default();
    }

    /// Notes that `file` holds `params`.
    pub fn saved_as(&mut self, file: &Path, params: &P) {
        (self.file, self.kept) = (Some(file.to_owned()), Some(params.clone()));
    }

    /// Whether no file holds `params`, which were changed since they were opened or saved.
    pub fn is_unsaved(&self, params: &P) -> bool {
        self.kept.as_ref() != Some(params)
    }

    /// What to call the document after its file, if it has one.
    pub fn name(&self) -> Option<String> {
        let name = self.file.as_deref().and_then(Path::file_stem);
        name.map(|n| n.to_string_lossy().into_owned())
    }

    /// Notes that `before` is about to be changed in a step called `label`.
    pub fn note(&mut self, label: &str, before: &P) {
        if self.history.undo_label() != Some(label) {
            self.gesture += 1;
        }
        self.history.record(label, before, Some(self.gesture));
    }

    /// The parameters before the last step, or after the one that was taken back last (`again`).
    pub fn undo(&mut self, now: &P, again: bool) -> Option<P> {
        if again { self.history.redo(now) } else { self.history.undo(now) }
    }

    /// What can be undone, or done again.
    pub fn undo_label(&self, again: bool) -> Option<&str> {
        if again { self.history.redo_label() } else { self.history.undo_label() }
    }

    /// Notes what the hands do, once a frame.
    pub fn follow(&mut self, hands: Hands) {
        // The frame in which a button is let go still belongs to what was done with it.
        if self.hands == Hands::Idle || (hands != Hands::Idle && hands != self.hands) {
            self.gesture += 1;
        }
        self.hands = hands;
    }

    /// What the hands did in the last frame.
    pub fn hands(&self) -> Hands {
        self.hands
    }
}
