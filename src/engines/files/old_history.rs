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
    /// The gesture whose changes make one step: a slider being dragged, a number being typed.
    gesture: Option<u64>,
}

impl<T> Default for History<T> {
    fn default() -> Self {
        Self { past: Vec::new(), future: Vec::new(), gesture: None }
    }
}

impl<T: Clone> History<T> {
    /// Notes that `before` is about to be changed. Changes of the same `gesture` make one step.
    pub fn record(&mut self, label: &str, before: &T, gesture: Option<u64>) {
        let continued = gesture.is_some() && gesture == self.gesture && !self.past.is_empty();
        self.gesture = gesture;
        self.future.clear();
        if continued {
            return;
        }
        self.past.push(Step { label: label.to_owned(), params: before.clone() });
        if self.past.len() > DEPTH {
            self.past.remove(0);
        }
    }

    /// The parameters before the last step, if there is one.
    pub fn undo(&mut self, now: &T) -> Option<T> {
        let step = self.past.pop()?;
        self.gesture = None;
        self.future.push(Step { label: step.label, params: now.clone() });
        Some(step.params)
    }

    /// The parameters after the step that was undone last, if there is one.
    pub fn redo(&mut self, now: &T) -> Option<T> {
        let step = self.future.pop()?;
        self.gesture = None;
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
