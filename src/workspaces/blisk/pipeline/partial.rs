//! What a plan has found so far, with the electrode that it looks for a way for.

use std::sync::{Arc, Mutex, PoisonError};

use feed::problem::{Convergence, Node};
use render::mesh::RenderMesh;
use wheel::electrode::Electrode;

/// What a plan has found so far.
#[derive(Clone, Default)]
pub struct PartialPlan {
    /// Counts what was found since the program began: another number, another state of the search.
    pub number: u64,
    /// The electrode that a way is searched for, and its shape.
    pub electrode: Option<(Arc<Electrode>, Arc<RenderMesh>)>,
    /// Nodes from the final pose outwards.
    pub nodes: Vec<Node>,
    /// How each node's search converged.
    pub convergence: Vec<Convergence>,
}

/// The shape of the electrode that a plan works on, made once for each.
#[derive(Default)]
pub(super) struct Shapes(Mutex<Option<(Arc<Electrode>, Arc<RenderMesh>)>>);

impl Shapes {
    pub(super) fn of(&self, electrode: &Arc<Electrode>) -> Arc<RenderMesh> {
        let mut last = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        match &*last {
            Some((of, shape)) if Arc::ptr_eq(of, electrode) => shape.clone(),
            _ => {
                let shape = Arc::new(RenderMesh::new(&electrode.mesh));
                *last = Some((electrode.clone(), shape.clone()));
                shape
            }
        }
    }
}
