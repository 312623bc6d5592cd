//! The quick look that follows while a cutter is changed, on a thread of its own.

use std::sync::Arc;

use super::{LoadedMold, Question};
use crate::jobs::uncut_preview::{Preview, preview};
use crate::jobs::worker::{Ended, Message, Reporter, Worker};
use crate::progress::{Cancel, Progress};
use crate::render::mesh::RenderMesh;
use crate::views::region_shapes;

/// What was seen at a glance.
#[derive(Debug)]
pub struct Glance {
    /// In figures.
    pub preview: Preview,
    /// On the mold, for the screen.
    pub shape: Arc<RenderMesh>,
}

/// Looks at one question at a time; the next is that which is asked when the last one is answered.
pub(super) struct Glancer {
    worker: Worker<(), Glance>,
    asked: Option<Question>,
    /// What was looked at last; nothing was seen if that could not be.
    seen: Option<(Question, Option<Arc<Glance>>)>,
    /// Whether what is looked at is of no use any more.
    is_forgotten: bool,
}

impl Glancer {
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

    pub fn wants(&self, question: &Question) -> bool {
        !self.seen.as_ref().is_some_and(|(of, _)| of == question)
    }

    pub fn ask(&mut self, question: Question, mold: Arc<LoadedMold>) {
        if self.asked.is_some() || !self.wants(&question) {
            return;
        }
        let params = question.1.clone();
        self.asked = Some(question);
        self.worker.submit(0, move |_: &Reporter<(), Glance>, _: &Progress, cancel: &Cancel| {
            let preview = preview(&mold.mesh, &params, cancel).map_err(|e| e.to_string())?;
            let cells = preview.regions.iter().flat_map(|r| &r.cells);
            let surface: Vec<_> = cells.flat_map(|cell| cell.pieces(0)).collect();
            let shape = region_shapes(&mold.mesh, &surface, 1, params.opening).swap_remove(0).shape;
            Ok(Glance { preview, shape })
        });
    }

    pub fn forget(&mut self) {
        self.seen = None;
        self.is_forgotten = self.asked.is_some();
    }

    /// What was seen of the mold of `question`, and of its cutters unless those `may_differ`.
    pub fn seen(&self, question: &Question, may_differ: bool) -> Option<&Arc<Glance>> {
        let (of, glance) = self.seen.as_ref()?;
        glance.as_ref().filter(|_| of == question || (may_differ && of.0 == question.0))
    }

    pub fn is_busy(&self) -> bool {
        self.worker.is_busy()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::mesh::Mesh;
    use crate::jobs::uncut::UncutParams;
    use crate::mold::cutter::{Cutter, CutterLibrary};

    #[test]
    fn what_was_seen_is_of_its_own_question() {
        let question = |mold: &str, radius: f64| {
            let library = CutterLibrary { cutter: vec![Cutter::flat(radius)] };
            (mold.to_owned(), UncutParams::of(library))
        };
        let mut glancer = Glancer::start(|| {}).unwrap();
        let mesh = Mesh { vertices: Vec::new(), triangles: Vec::new() };
        let glance =
            Glance { preview: Preview { step: 1.0, regions: Vec::new() }, shape: Arc::new(RenderMesh::new(&mesh)) };
        glancer.seen = Some((question("a", 1.0), Some(Arc::new(glance))));
        let seen = |mold, radius, may_differ| glancer.seen(&question(mold, radius), may_differ).is_some();
        assert!(seen("a", 1.0, false) && seen("a", 2.0, true));
        assert!(!seen("a", 2.0, false) && !seen("b", 1.0, false) && !seen("b", 1.0, true));
    }
}
