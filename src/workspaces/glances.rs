//! Quick looks that follow while something is changed, on a thread of their own.

use std::sync::Arc;

use super::worker::{Ended, Message, Worker};
use task::Cancel;

/// Looks at one question at a time; the next is that which is asked when the last one is answered.
pub(super) struct Glances<Q, T> {
    worker: Worker<(), T>,
    asked: Option<Q>,
    /// What was looked at last; nothing was seen if that could not be.
    seen: Option<(Q, Option<Arc<T>>)>,
    /// Whether what is looked at is of no use any more.
    is_forgotten: bool,
}

impl<Q: PartialEq, T: Send + 'static> Glances<Q, T> {
    pub fn start(wake: impl Fn() + Send + Sync + 'static) -> std::io::Result<Self> {
        Ok(Self { worker: Worker::start(wake)?, asked: None, seen: None, is_forgotten: false })
    }

    pub fn follow(&mut self) {
        for message in self.worker.messages() {
            if let Message::Finished(_, ended) = message {
                let Some(question) = self.asked.take() else { continue };
                let seen = if let Ended::Done(glance) = ended { Some(Arc::new(glance)) } else { None };
                if !std::mem::take(&mut self.is_forgotten) {
                    self.seen = Some((question, seen));
                }
            }
        }
    }

    fn wants(&self, question: &Q) -> bool {
        !self.seen.as_ref().is_some_and(|(of, _)| of == question)
    }

    /// Looks at `question` with `look`, unless that is known or something is being looked at.
    pub fn ask(&mut self, question: Q, look: impl FnOnce(&Cancel) -> Result<T, String> + Send + 'static) {
        if self.asked.is_some() || !self.wants(&question) {
            return;
        }
        self.asked = Some(question);
        self.worker.submit(0, move |_, _, cancel| look(cancel));
    }

    pub fn forget(&mut self) {
        self.seen = None;
        self.is_forgotten = self.asked.is_some();
    }

    /// What was seen of a question that `is_same`.
    pub fn seen(&self, is_same: impl Fn(&Q) -> bool) -> Option<&Arc<T>> {
        let (of, glance) = self.seen.as_ref()?;
        glance.as_ref().filter(|_| is_same(of))
    }

    pub fn is_busy(&self) -> bool {
        self.worker.is_busy()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_seen_is_of_its_own_question() {
        let mut glances: Glances<(&str, u32), u32> = Glances::start(|| {}).unwrap();
        glances.seen = Some((("a", 1), Some(Arc::new(7))));
        assert!(glances.seen(|of| *of == ("a", 1)).is_some() && glances.seen(|of| of.0 == "a").is_some());
        assert!(glances.seen(|of| *of == ("a", 2)).is_none() && glances.seen(|of| of.0 == "b").is_none());
        assert!(!glances.wants(&("a", 1)) && glances.wants(&("a", 2)));
    }
}
