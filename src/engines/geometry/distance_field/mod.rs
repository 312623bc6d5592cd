//! A signed distance field of a mesh, made for looking up many points fast.
//!
//! Space is cut into cells of one size. A cell in which the distance is well described by trilinear
//! interpolation belongs to a *smooth* leaf, which may span 2, 4 or 8 cells along each axis and holds the eight
//! distances at its corners. A cell that no leaf describes well enough (beside sharp edges, in corners, on the
//! ridge between two walls) holds the few triangles that can be nearest there and is evaluated exactly. Cells are made
//! block by block, where they are asked for.
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

use std::sync::{Arc, OnceLock};

pub use build::FieldError;
use glam::{DVec3, Vec3};

use super::exact::ExactMesh;
use super::mesh::Bounds;
use local_triangles::{Candidate, LocalTriangles, Nearest};

/// Signed distance field of a mesh over a region.
pub struct DistanceField {
    bounds: Bounds,
    cell: f64,
    /// Blocks along each axis.
    blocks_along: [usize; 3],
    /// x fastest, each made when a point in it is first asked for. A block depends on the mesh and on its place alone, so
    /// it is the same whoever asks first.
    blocks: Vec<OnceLock<Box<Block>>>,
    triangles: LocalTriangles,
    exact: Arc<ExactMesh>,
}

/// The cells of a cube, [`SIDE`](Block::SIDE) along each axis.
struct Block {
    /// The first cell, with its number in the field.
    first: [usize; 3],
    /// One for each cell, x fastest, see [`Handle`].
    handles: [Handle; Block::CELLS],
    /// Corner distances of the smooth leaves; corner `i` lies on the far side along x, y, z where bits 0, 1, 2 of
    /// `i` are set.
    leaves: Vec<[f32; 8]>,
    /// Where the list of each exact cell ends in `list`; it begins where the one before ends.
    list_ends: Vec<u32>,
    /// The candidates of each exact cell, in order of their distance from its centre.
    list: Vec<Candidate>,
    /// Winding number at the reference point of each folded cell; their lists are the last.
    windings: Vec<i32>,
    /// Distance at the centre of each exact cell (mm).
    centres: Vec<f32>,
}

/// Description of a cell: in the low 3 bits the leaf's level (it spans `2^level` cells) or the source of an exact
/// cell's sign, above them the number of the leaf or of the exact cell in its block.
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

    fn is_exact(self) -> bool {
        self.kind() >= Self::OUTSIDE
    }

    fn number(self) -> usize {
        (self.0 >> 3) as usize
    }
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
        Some(self.locate(p)?.value(p))
    }

    /// Signed distance at `p`, or any value from `enough` to it if it is known to be greater (mm): where it is enough
    /// to know that, a cell's triangles need not be tested. `None` outside the field's bounds.
    #[inline]
    pub fn value_or_enough(&self, p: DVec3, enough: f64) -> Option<f64> {
        let place = self.locate(p)?;
        if place.handle.is_exact() {
            // The distance changes by no more than one moves.
            let at_center = f64::from(place.block.centres[place.handle.number()]);
            let least = at_center - p.distance(place.center()) - Self::ROUNDING;
            if least >= enough {
                return Some(least);
            }
        }
        Some(place.value(p))
    }

    /// Signed distance at `p` and its gradient; `None` outside the field's bounds.
    pub fn value_and_gradient(&self, p: DVec3) -> Option<(f64, DVec3)> {
        let place = self.locate(p)?;
        let kind = place.handle.kind();
        if place.handle.is_exact() {
            let (by_normals, nearest, normal) = self.triangles.signed(p, place.nearest(p));
            let d = match kind {
                Handle::OUTSIDE => by_normals.abs(),
                Handle::INSIDE => -by_normals.abs(),
                Handle::FOLDED => place.sign_in_folded(p) * by_normals.abs(),
                _ => by_normals,
            };
            let away = ((p - nearest) * d.signum()).try_normalize().unwrap_or(normal);
            return Some((d, away));
        }
        let v = &place.block.leaves[place.handle.number()];
        let t = place.leaf_position(p);
        let size = self.cell * f64::from(1 << kind);
        Some((f64::from(trilinear(v, t)), trilinear_gradient(v, t).as_dvec3() / size))
    }

    #[inline]
    fn locate(&self, p: DVec3) -> Option<Place<'_>> {
        let q = (p - self.bounds.min) / self.cell;
        if q.is_nan() || q.min_element() < 0.0 {
            return None;
        }
        let cell = [q.x as usize, q.y as usize, q.z as usize];
        let at = cell.map(|i| i / Block::SIDE);
        if (0..3).any(|k| at[k] >= self.blocks_along[k]) {
            return None;
        }
        let block = &self.blocks[(at[2] * self.blocks_along[1] + at[1]) * self.blocks_along[0] + at[0]];
        let block = block.get_or_init(|| Box::new(self.block(at.map(|i| i * Block::SIDE))));
        Some(Place { field: self, block, handle: block.handles[Block::index(cell)], cell })
    }

    /// The place in a cell whose winding number is known if the cell is folded: off the middle, so that surfaces that
    /// run through lattice planes miss it.
    fn reference_point(&self, cell: [usize; 3]) -> DVec3 {
        self.point_in(cell, DVec3::new(0.437, 0.561, 0.473))
    }

    /// The point `offset` cells from the low corner of a cell.
    #[inline]
    fn point_in(&self, cell: [usize; 3], offset: DVec3) -> DVec3 {
        self.bounds.min + (DVec3::from_array(cell.map(|i| i as f64)) + offset) * self.cell
    }
}

impl Block {
    /// Levels of leaves above single cells: the largest leaf is the block.
    const LEVELS: u32 = 3;
    /// Cells along each side.
    const SIDE: usize = 1 << Self::LEVELS;
    /// Cells in all.
    const CELLS: usize = Self::SIDE.pow(3);

    /// The place of a cell among those of its block.
    #[inline]
    fn index(cell: [usize; 3]) -> usize {
        let [x, y, z] = cell.map(|i| i % Self::SIDE);
        (z * Self::SIDE + y) * Self::SIDE + x
    }

    /// The number in the field of a cell of the block.
    fn in_field(&self, cell: [usize; 3]) -> [usize; 3] {
        [0, 1, 2].map(|k| self.first[k] + cell[k])
    }
}

/// A cell of a field.
struct Place<'a> {
    field: &'a DistanceField,
    block: &'a Block,
    handle: Handle,
    cell: [usize; 3],
}

impl Place<'_> {
    /// Signed distance at the point `p` of the cell (mm).
    #[inline]
    fn value(&self, p: DVec3) -> f64 {
        let exactly = |sign: f64| sign * self.nearest(p).distance();
        match self.handle.kind() {
            Handle::OUTSIDE => exactly(1.0),
            Handle::INSIDE => exactly(-1.0),
            Handle::FOLDED => exactly(self.sign_in_folded(p)),
            Handle::EXACT => self.field.triangles.signed(p, self.nearest(p)).0,
            _ => f64::from(trilinear(&self.block.leaves[self.handle.number()], self.leaf_position(p))),
        }
    }

    /// -1 if the surface winds around the point `p` of a folded cell, and 1 if not.
    #[cold]
    fn sign_in_folded(&self, p: DVec3) -> f64 {
        // No surface passes between `p` and a centre that is further from it.
        let at_center = self.block.centres.get(self.handle.number()).map(|d| f64::from(*d)).filter(|d| d.is_finite());
        if let Some(d) = at_center.filter(|d| d.abs() > p.distance(self.center()) + DistanceField::ROUNDING) {
            return d.signum();
        }
        let first_folded = self.block.list_ends.len() - self.block.windings.len();
        let known = self.block.windings[self.handle.number() - first_folded];
        let reference = self.field.reference_point(self.cell);
        // Both points are in the cell, and so is any triangle between them, in part.
        let reach = 0.5 * 3f64.sqrt() * self.field.cell + DistanceField::ROUNDING;
        let candidates = self.candidates();
        let between = candidates.partition_point(|c| c.in_order().0 <= reach);
        let passed = self.field.triangles.signed_crossings(p, reference, &candidates[..between]);
        if known + passed == 0 { 1.0 } else { -1.0 }
    }

    fn center(&self) -> DVec3 {
        self.field.point_in(self.cell, DVec3::splat(0.5))
    }

    /// Position of `p` within its leaf, 0 to 1 along each axis.
    #[inline]
    fn leaf_position(&self, p: DVec3) -> Vec3 {
        let (level, cell) = (self.handle.kind(), self.field.cell);
        let corner = self.cell.map(|i| (i >> level << level) as f64);
        ((p - self.field.bounds.min - DVec3::from_array(corner) * cell) / (cell * f64::from(1 << level))).as_vec3()
    }

    /// The triangle nearest to the point `p` of an exact cell.
    #[inline]
    fn nearest(&self, p: DVec3) -> Nearest {
        let candidates = self.candidates().iter().map(Candidate::in_order);
        self.field.triangles.nearest_in_order(p, self.center(), candidates)
    }

    fn candidates(&self) -> &[Candidate] {
        let (i, ends) = (self.handle.number(), &self.block.list_ends);
        let start = if i == 0 { 0 } else { ends[i - 1] as usize };
        &self.block.list[start..ends[i] as usize]
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
