//! Undo and redo over whole sets of parameters. A set has a few hundred bytes, so that each step keeps one.

/// Greatest number of steps kept.
const DEPTH: usize = 500;

/// A step: its name, and the parameters on the other side of it.
#[derive(Debug, Clone, PartialEq)]
struct Step<T> {
    label: String,
    params: T,
}

/// The steps of parameters `T` for undo and redo.
#[derive(Debug, Clone, PartialEq)]
pub struct History<T> {
    past: Vec<Step<T>>,
    future: Vec<Step<T>>,
    /// Whether the last step belongs to a gesture in progress: a slider being dragged, a number being typed.
    is_open: bool,
}

impl<T> Default for History<T> {
    fn default() -> Self {
        Self { past: Vec::new(), future: Vec::new(), is_open: false }
    }
}

impl<T: Clone> History<T> {
    /// Records that `before` is about to change. Changes `in_gesture` with the same label form one step, until
    /// [`end_gesture`](Self::end_gesture).
    pub fn record(&mut self, label: &str, before: &T, in_gesture: bool) {
        let continued = in_gesture && self.is_open && self.undo_label() == Some(label);
        self.is_open = in_gesture;
        self.future.clear();
        if continued {
            return;
        }
        self.past.push(Step { label: label.to_owned(), params: before.clone() });
        if self.past.len() > DEPTH {
            self.past.remove(0);
        }
    }

    /// Ends a gesture. The next change is a step of its own.
    pub fn end_gesture(&mut self) {
        self.is_open = false;
    }

    /// The parameters before the last step, if there is one.
    pub fn undo(&mut self, now: &T) -> Option<T> {
        let step = self.past.pop()?;
        self.is_open = false;
        self.future.push(Step { label: step.label, params: now.clone() });
        Some(step.params)
    }

    /// The parameters after the step that was undone last, if there is one.
    pub fn redo(&mut self, now: &T) -> Option<T> {
        let step = self.future.pop()?;
        self.is_open = false;
        self.past.push(Step { label: step.label, params: now.clone() });
        Some(step.params)
    }

    /// Changes the parameters of every step.
    pub fn change_all(&mut self, mut change: impl FnMut(&mut T)) {
        self.past.iter_mut().chain(&mut self.future).for_each(|step| change(&mut step.params));
    }

    /// Name of the step that undo takes back.
    pub fn undo_label(&self) -> Option<&str> {
        self.past.last().map(|s| s.label.as_str())
    }

    /// Name of the step that redo does again.
    pub fn redo_label(&self) -> Option<&str> {
        self.future.last().map(|s| s.label.as_str())
    }
}
