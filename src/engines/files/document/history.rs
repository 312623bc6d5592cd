//! Undo and redo over whole sets of parameters: a set is a few hundred bytes, so a step keeps all of it.

/// Most steps that are kept.
const DEPTH: usize = 500;

/// One step: what was done, and the parameters on the other side of it.
#[derive(Debug, Clone, PartialEq)]
struct Step<T> {
    label: String,
    params: T,
}

/// The steps over parameters `T` that can be undone and done again.
#[derive(Debug, Clone, PartialEq)]
pub struct History<T> {
    past: Vec<Step<T>>,
    future: Vec<Step<T>>,
    /// Whether the last step is one of a gesture that still goes on: a slider being dragged, a number being typed.
    is_open: bool,
}

impl<T> Default for History<T> {
    fn default() -> Self {
        Self { past: Vec::new(), future: Vec::new(), is_open: false }
    }
}

impl<T: Clone> History<T> {
    /// Notes that `before` is about to be changed. Changes `in_gesture` with the same label make one step, until
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

    /// Ends a gesture: the next change is a step of its own.
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

    /// What undo would take back.
    pub fn undo_label(&self) -> Option<&str> {
        self.past.last().map(|s| s.label.as_str())
    }

    /// What redo would do again.
    pub fn redo_label(&self) -> Option<&str> {
        self.future.last().map(|s| s.label.as_str())
    }
}
