//! A signed distance field of a mesh, made for looking up many points fast.
//!
//! Space is cut into cells of one size. A cell in which the distance is well described by trilinear
//! interpolation belongs to a *smooth* leaf, which may span 2, 4 or 8 cells along each axis and holds the eight
//! distances at its corners. A cell that no leaf describes well enough (beside sharp edges, in corners, on the
//! ridge between two walls) holds the few triangles that can be nearest there and is evaluated exactly.
//!
//! The idea of spending resolution only where the distance bends is that of adaptively sampled distance fields
//! (Frisken et al., SIGGRAPH 2000).
//!
//! **Accuracy:** within [`DistanceField::NEAR`] of the surface the error is at most
//! [`DistanceField::ACCURACY`]; further away it may grow by 5 % of the distance beyond that. A leaf is
//! accepted when it meets less than that at 19 places of its own and 8 inside; the tests compare the whole with
//! exact distances.
//!
//! **Sign:** negative where the surface winds around a point, also where sheets of it overlap or are folded (see
//! `signs`); within a cell of a fold the sign may follow either sheet.
//!
//! **Not guaranteed:** the sign, where the mesh is not closed.

mod build;
mod local_triangles;
mod signs;

use std::collections::HashMap;

pub use build::FieldError;
use glam::{DVec3, Vec3};

use super::mesh::Bounds;
use local_triangles::{Candidate, LocalTriangles, Nearest};

/// Signed distance field of a mesh over a region.
pub struct DistanceField {
    bounds: Bounds,
    cell: f64,
    cells: [usize; 3],
    /// One for each cell, see [`Handle`].
    handles: Vec<Handle>,
    /// Corner distances of the smooth leaves; corner `i` lies on the far side along x, y, z where bits 0, 1, 2 of
    /// `i` are set.
    leaves: Vec<[f32; 8]>,
    /// Where the list of each exact cell ends in `list`; it begins where the one before ends.
    list_ends: Vec<u32>,
    /// The candidates of each exact cell, in order of their distance from its centre.
    list: Vec<Candidate>,
    /// Winding number at the reference point of each folded cell, by the number of its list.
    windings: HashMap<u32, i32>,
    /// Distance at the centre of each exact cell (mm).
    centres: Vec<f32>,
    triangles: LocalTriangles,
}

/// Description of a cell: in the low 3 bits the leaf's level (it spans `2^level` cells) or the source of an exact
/// cell's sign, above them the number of the leaf or of the exact cell.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Handle(u32);

impl Handle {
    /// Wholly outside.
    const OUTSIDE: u32 = 4;
    /// Wholly inside.
    const INSIDE: u32 = 5;
    /// Crossed by a surface whose normals are unreliable: crossings are counted.
    const FOLDED: u32 = 6;
    /// Signs by the normals.
    const EXACT: u32 = 7;

    fn new(kind: u32, number: usize) -> Self {
        Self((number as u32) << 3 | kind)
    }

    fn kind(self) -> u32 {
        self.0 & 7
    }

    fn number(self) -> usize {
        (self.0 >> 3) as usize
    }
}

/// Sizes of the parts of a field, for reports.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FieldSize {
    /// Cells in all.
    pub cells: usize,
    /// Smooth leaves.
    pub leaves: usize,
    /// Cells evaluated exactly.
    pub exact_cells: usize,
    /// Memory held (bytes).
    pub bytes: usize,
}

impl DistanceField {
    /// Distance from the surface up to which [`ACCURACY`](Self::ACCURACY) holds (mm).
    pub const NEAR: f64 = 0.5;
    /// Greatest error near the surface (mm).
    pub const ACCURACY: f64 = 0.005;
    /// For rounding to single precision (mm).
    const ROUNDING: f64 = 1e-5;

    /// Size of the cells of a field over `region` (mm): `wanted`, or larger so that there are no more than `most`. Larger
    /// cells are as accurate, but slower to look up.
    pub fn cell_for(region: &Bounds, wanted: f64, most: f64) -> f64 {
        wanted.max((region.size().element_product() / most).cbrt())
    }

    /// The region that the field describes.
    pub fn bounds(&self) -> Bounds {
        self.bounds
    }

    /// Signed distance at `p` (mm), negative inside the mesh; `None` outside the field's bounds.
    #[inline]
    pub fn value(&self, p: DVec3) -> Option<f64> {
        let (handle, cell) = self.locate(p)?;
        let exactly = |sign: f64| sign * self.nearest(p, handle, cell).distance();
        Some(match handle.kind() {
            Handle::OUTSIDE => exactly(1.0),
            Handle::INSIDE => exactly(-1.0),
            Handle::FOLDED => exactly(self.sign_in_folded(p, handle, cell)),
            Handle::EXACT => self.triangles.signed(p, self.nearest(p, handle, cell)).0,
            level => f64::from(trilinear(&self.leaves[handle.number()], self.leaf_position(p, cell, level))),
        })
    }

    /// Signed distance at `p`, or any value from `enough` to it if it is known to be greater (mm): where it is enough
    /// to know that, a cell's triangles need not be tested. `None` outside the field's bounds.
    #[inline]
    pub fn value_or_enough(&self, p: DVec3, enough: f64) -> Option<f64> {
        let (handle, cell) = self.locate(p)?;
        if handle.kind() >= Handle::OUTSIDE {
            // The distance changes by no more than one moves.
            let least = f64::from(self.centres[handle.number()]) - p.distance(self.center(cell)) - Self::ROUNDING;
            if least >= enough {
                return Some(least);
            }
        }
        self.value(p)
    }

    /// Signed distance at `p` and its gradient; `None` outside the field's bounds.
    pub fn value_and_gradient(&self, p: DVec3) -> Option<(f64, DVec3)> {
        let (handle, cell) = self.locate(p)?;
        if handle.kind() >= Handle::OUTSIDE {
            let (by_normals, nearest, normal) = self.triangles.signed(p, self.nearest(p, handle, cell));
            let d = match handle.kind() {
                Handle::OUTSIDE => by_normals.abs(),
                Handle::INSIDE => -by_normals.abs(),
                Handle::FOLDED => self.sign_in_folded(p, handle, cell) * by_normals.abs(),
                _ => by_normals,
            };
            let away = ((p - nearest) * d.signum()).try_normalize().unwrap_or(normal);
            return Some((d, away));
        }
        let v = &self.leaves[handle.number()];
        let t = self.leaf_position(p, cell, handle.kind());
        let size = self.cell * f64::from(1 << handle.kind());
        Some((f64::from(trilinear(v, t)), trilinear_gradient(v, t).as_dvec3() / size))
    }

    /// Size of the field.
    pub fn size(&self) -> FieldSize {
        FieldSize {
            cells: self.handles.len(),
            leaves: self.leaves.len(),
            exact_cells: self.list_ends.len(),
            bytes: self.handles.len() * 4
                + self.leaves.len() * 32
                + (self.list_ends.len() + self.centres.len()) * 4
                + self.list.len() * size_of::<Candidate>()
                + self.triangles.bytes(),
        }
    }

    /// -1 if the surface winds around `p`, a point of a folded cell, and 1 if not.
    #[cold]
    fn sign_in_folded(&self, p: DVec3, handle: Handle, cell: [usize; 3]) -> f64 {
        // No surface passes between `p` and a centre that is further from it.
        let at_center = self.centres.get(handle.number()).map(|d| f64::from(*d)).filter(|d| d.is_finite());
        if let Some(d) = at_center.filter(|d| d.abs() > p.distance(self.center(cell)) + Self::ROUNDING) {
            return d.signum();
        }
        let known = self.windings.get(&(handle.number() as u32)).copied().unwrap_or(0);
        let reference = self.reference_point(cell);
        // Both points are in the cell, and so is any triangle between them, in part.
        let reach = 0.5 * 3f64.sqrt() * self.cell + Self::ROUNDING;
        let candidates = self.candidates(handle);
        let between = candidates.partition_point(|c| c.in_order().0 <= reach);
        let passed = self.triangles.signed_crossings(p, reference, &candidates[..between]);
        if known + passed == 0 { 1.0 } else { -1.0 }
    }

    fn handle(&self, cell: [usize; 3]) -> Handle {
        self.handles[self.index(cell)]
    }

    fn index(&self, cell: [usize; 3]) -> usize {
        (cell[2] * self.cells[1] + cell[1]) * self.cells[0] + cell[0]
    }

    fn center(&self, cell: [usize; 3]) -> DVec3 {
        self.bounds.min + (DVec3::from_array(cell.map(|i| i as f64)) + 0.5) * self.cell
    }

    #[inline]
    fn locate(&self, p: DVec3) -> Option<(Handle, [usize; 3])> {
        let q = (p - self.bounds.min) / self.cell;
        if q.is_nan() || q.min_element() < 0.0 {
            return None;
        }
        let cell = [q.x as usize, q.y as usize, q.z as usize];
        if cell[0] >= self.cells[0] || cell[1] >= self.cells[1] || cell[2] >= self.cells[2] {
            return None;
        }
        Some((self.handle(cell), cell))
    }

    /// Position of `p` within its leaf, 0 to 1 along each axis.
    #[inline]
    fn leaf_position(&self, p: DVec3, cell: [usize; 3], level: u32) -> Vec3 {
        let corner = cell.map(|i| (i >> level << level) as f64);
        let size = self.cell * f64::from(1 << level);
        ((p - self.bounds.min - DVec3::from_array(corner) * self.cell) / size).as_vec3()
    }

    /// The triangle nearest to `p`, a point of the exact cell `cell`.
    #[inline]
    fn nearest(&self, p: DVec3, handle: Handle, cell: [usize; 3]) -> Nearest {
        let candidates = self.candidates(handle).iter().map(Candidate::in_order);
        self.triangles.nearest_in_order(p, self.center(cell), candidates)
    }

    fn candidates(&self, handle: Handle) -> &[Candidate] {
        let i = handle.number();
        let start = if i == 0 { 0 } else { self.list_ends[i - 1] as usize };
        &self.list[start..self.list_ends[i] as usize]
    }
}

#[inline]
fn trilinear(v: &[f32; 8], t: Vec3) -> f32 {
    let lerp = |a: f32, b: f32, t: f32| a + (b - a) * t;
    let [y0z0, y1z0, y0z1, y1z1] = [0, 2, 4, 6].map(|i| lerp(v[i], v[i + 1], t.x));
    lerp(lerp(y0z0, y1z0, t.y), lerp(y0z1, y1z1, t.y), t.z)
}

fn trilinear_gradient(v: &[f32; 8], t: Vec3) -> Vec3 {
    let lerp = |a: f32, b: f32, t: f32| a + (b - a) * t;
    let bilinear = |[a, b, c, d]: [f32; 4], s: f32, t: f32| lerp(lerp(a, b, s), lerp(c, d, s), t);
    Vec3::new(
        bilinear([0, 2, 4, 6].map(|i| v[i + 1] - v[i]), t.y, t.z),
        bilinear([0, 1, 4, 5].map(|i| v[i + 2] - v[i]), t.x, t.z),
        bilinear([0, 1, 2, 3].map(|i| v[i + 4] - v[i]), t.x, t.y),
    )
}

#[cfg(test)]
mod tests;
