//! A mesh made ready for drawing.

mod edges;
mod fans;
mod shading;
mod simplify;

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use glam::DVec3;
use rayon::prelude::*;

use fans::Fans;
use geometry::mesh::{Bounds, Mesh, unit_normal};
use geometry::raycast::RayMesh;
pub use shading::Vertex;
use shading::{Shaded, shade};
use simplify::Lighter;

/// Cosine of the angle (30 degrees) between faces from which on the edge between them is sharp.
const CREASE: f64 = 0.866_025_403_784_438_6;
/// Crease angle of the lighter mesh, which is rougher (rad).
const LIGHTER_CREASE: f64 = 0.7;
/// Number of triangles from which on there is a lighter mesh.
const LIGHTER_FROM: usize = 24;
/// Number of triangles from which on the lighter mesh is drawn whenever the view moves.
const LARGE_FROM: usize = 60_000;
/// Triangles of the lighter version of a large mesh, about.
const LARGE_TARGET: f64 = 30_000.0;
/// By how much fewer triangles are asked of the lighter version of a smaller mesh: the first of these that keeps its surface.
/// About a tenth are left by the first, since sides that face differently stay apart.
const FEWER: [f64; 3] = [48.0, 12.0, 2.0];
/// Share of its surface that a small mesh keeps in its lighter version, at least: of a narrow strip nothing may be left.
const LEAST_AREA: f64 = 0.6;

/// A mesh with all that drawing and picking need. Make it once for each mesh, on a worker thread (a second or
/// so for a million triangles), and share it.
pub struct RenderMesh {
    id: u64,
    source: Arc<Mesh>,
    bounds: Bounds,
    closed: bool,
    full: Level,
    lighter: Option<Level>,
    rays: Option<RayMesh>,
}

/// One version of a mesh as the GPU wants it: positions are from the [`RenderMesh::origin`].
#[derive(Debug, Default)]
pub struct Level {
    /// Vertices, split where the surface has a crease.
    pub vertices: Vec<Vertex>,
    /// For each of them the vertex of the source mesh.
    pub sources: Vec<u32>,
    /// Three for each triangle.
    pub indices: Vec<u32>,
    /// Both ends of every feature edge; a lighter level has none.
    pub edges: Vec<[[f32; 3]; 2]>,
}

impl std::fmt::Debug for RenderMesh {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("RenderMesh").field("id", &self.id).field("triangles", &self.triangle_count()).finish()
    }
}

impl RenderMesh {
    /// Prepares `mesh`. Triangles with vertices that do not exist or are not finite are not seen; the others
    /// keep their indices.
    pub fn new(mesh: &Mesh) -> Self {
        Self::made(mesh.clone().into(), true)
    }

    /// Prepares `mesh` as [`new`](Self::new) does, and what is beside it, if there is anything. Where there is nothing
    /// the mesh is kept and not copied, as is good for a large one.
    pub fn beside(mesh: &Arc<Mesh>, others: Option<&Mesh>) -> Self {
        let with = |others: &Mesh| {
            let mut all = (**mesh).clone();
            all.append(others);
            all.into()
        };
        Self::made(others.map_or_else(|| mesh.clone(), with), true)
    }

    /// Prepares `mesh` for pictures in full quality alone: it has no lighter version, and no ray meets it.
    pub fn for_pictures(mesh: &Mesh) -> Self {
        Self::made(mesh.clone().into(), false)
    }

    fn made(mesh: Arc<Mesh>, is_handled: bool) -> Self {
        static NEXT: AtomicU64 = AtomicU64::new(0);
        let (source, bounds) = cleaned(mesh);
        let origin = if source.triangles.is_empty() { DVec3::ZERO } else { bounds.center() };
        let rays = || is_handled.then(|| RayMesh::new(&source).ok()).flatten();
        let (levels, rays) = rayon::join(|| levels(&source, origin, is_handled), rays);
        let Levels { full, lighter, closed } = levels;
        Self { id: NEXT.fetch_add(1, Ordering::Relaxed), source, bounds, closed, full, lighter, rays }
    }

    /// Whether there is nothing to be seen.
    pub fn is_empty(&self) -> bool {
        self.source.triangles.is_empty()
    }

    /// Number of triangles.
    pub fn triangle_count(&self) -> usize {
        self.source.triangles.len()
    }

    /// A number that no other prepared mesh of this run of the program has.
    pub fn id(&self) -> u64 {
        self.id
    }

    /// The mesh it was made of, with unusable triangles shrunk to points.
    pub fn source(&self) -> &Mesh {
        &self.source
    }

    /// The box around its triangles, in its own frame; [`Bounds::EMPTY`] if it is empty.
    pub fn bounds(&self) -> Bounds {
        self.bounds
    }

    /// Origin of the positions of the levels, in the mesh's frame.
    pub fn origin(&self) -> DVec3 {
        if self.is_empty() { DVec3::ZERO } else { self.bounds.center() }
    }

    /// Whether its triangles enclose a space, so that a section of it has cut faces.
    pub fn is_closed(&self) -> bool {
        self.closed
    }

    /// The mesh in full.
    pub fn full(&self) -> &Level {
        &self.full
    }

    /// Whether it has many triangles by itself, and is drawn in its lighter version whenever the view moves.
    pub fn is_large(&self) -> bool {
        self.triangle_count() >= LARGE_FROM
    }

    /// A version to be drawn while the view moves: some ten thousand triangles of a large mesh, about a tenth of the
    /// triangles of a smaller one; the mesh in full if that has few.
    pub fn lighter(&self) -> &Level {
        self.lighter.as_ref().unwrap_or(&self.full)
    }

    /// The mesh prepared for rays; `None` if there is nothing to meet.
    pub fn rays(&self) -> Option<&RayMesh> {
        self.rays.as_ref()
    }
}

impl From<Shaded> for Level {
    fn from(shaded: Shaded) -> Self {
        let Shaded { vertices, sources, indices } = shaded;
        Self { vertices, sources, indices, edges: Vec::new() }
    }
}

/// Levels of detail of a mesh.
struct Levels {
    full: Level,
    lighter: Option<Level>,
    closed: bool,
}

fn levels(source: &Mesh, origin: DVec3, is_handled: bool) -> Levels {
    let normals: Vec<DVec3> = source.triangles.par_iter().map(|t| normal(source, t)).collect();
    let fans = Fans::new(source.vertices.len(), &source.triangles);
    let edges = edges::find_edges(&source.triangles, &fans, &normals, CREASE);
    let ends = |e: &[u32; 2]| e.map(|v| (source.vertices[v as usize] - origin).as_vec3().to_array());
    let shaded = shade(source, &fans, &normals, origin, CREASE);
    let full = Level { edges: edges.features.iter().map(ends).collect(), ..Level::from(shaded) };
    let lighter = is_handled.then(|| lighter_level(source, &fans, &normals, origin)).flatten();
    Levels { full, lighter, closed: edges.closed }
}

/// `mesh` with every index valid and every vertex finite, and the box around its triangles.
fn cleaned(mesh: Arc<Mesh>) -> (Arc<Mesh>, Bounds) {
    let usable = |v: u32| mesh.vertices.get(v as usize).is_some_and(|p| p.is_finite());
    let bounds = Bounds::of(
        mesh.triangles.iter().filter(|t| t.iter().all(|&v| usable(v))).flatten().map(|&v| mesh.vertices[v as usize]),
    );
    let first = mesh.triangles.iter().flatten().copied().find(|&v| usable(v));
    let Some(first) = first.filter(|_| bounds.size().is_finite() && bounds.min.x <= bounds.max.x) else {
        return (Arc::default(), Bounds::EMPTY);
    };
    if mesh.vertices.iter().all(|p| p.is_finite()) && mesh.triangles.iter().flatten().all(|&v| usable(v)) {
        return (mesh, bounds);
    }
    let place = mesh.vertices[first as usize];
    let vertices = mesh.vertices.iter().map(|&p| if p.is_finite() { p } else { place }).collect();
    let triangles = mesh.triangles.iter().map(|t| if t.iter().all(|&v| usable(v)) { *t } else { [first; 3] }).collect();
    (Mesh { vertices, triangles }.into(), bounds)
}

fn normal(mesh: &Mesh, triangle: &[u32; 3]) -> DVec3 {
    unit_normal(triangle.map(|v| mesh.vertices[v as usize]))
}

/// The lighter version; `None` where it would be no lighter or much of the surface would be missing.
fn lighter_level(source: &Mesh, fans: &Fans, normals: &[DVec3], origin: DVec3) -> Option<Level> {
    let count = source.triangles.len();
    if count < LIGHTER_FROM {
        return None;
    }
    let lighter = |target: f64| simplify::lighter(source, fans, normals, target);
    let keeps_surface = |lighter: &Lighter| {
        2 * lighter.mesh.triangles.len() <= count && lighter.mesh.area() >= LEAST_AREA * source.area()
    };
    let lighter = if count >= LARGE_FROM {
        lighter(LARGE_TARGET)
    } else {
        FEWER.into_iter().map(|fewer| lighter(count as f64 / fewer)).find(keeps_surface)?
    };
    let normals: Vec<DVec3> = lighter.mesh.triangles.par_iter().map(|t| normal(&lighter.mesh, t)).collect();
    let fans = Fans::new(lighter.mesh.vertices.len(), &lighter.mesh.triangles);
    let mut level = Level::from(shade(&lighter.mesh, &fans, &normals, origin, LIGHTER_CREASE));
    level.sources.iter_mut().for_each(|v| *v = lighter.sources[*v as usize]);
    Some(level)
}

#[cfg(test)]
pub(crate) mod tests;
