//! Building a [`DistanceField`]: octree cubes that carry the triangles that can be nearest inside them.

use std::cmp::Ordering;
use std::sync::{Arc, LazyLock, OnceLock};

use glam::DVec3;
use rayon::prelude::*;

use super::local_triangles::{Candidate, HalfSpace, Nearest};
use super::signs::{self, Passage};
use super::{Block, DistanceField, Handle, LocalTriangles, trilinear};
use crate::exact::ExactMesh;
use crate::mesh::{Bounds, Mesh};
use task::{Cancelled, Task};

/// Error at which a leaf is still accepted near the surface (mm): below the promised accuracy, since the places
/// where it is measured need not be the worst.
const ACCEPTED: f64 = 0.45 * DistanceField::ACCURACY;

/// Reason why a field cannot be built.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum FieldError {
    /// Cancelled.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    /// Region over cell size needs too many cells.
    #[error("a distance field of {cells:.1e} cells is too large; give a larger cell or a smaller region")]
    TooLarge {
        /// Cells asked for.
        cells: f64,
    },
}

impl DistanceField {
    /// The field of `mesh` (prepared as `exact`) over `region`, grown to whole blocks, with cells of about
    /// `cell` mm (0.2 suits parts of some 100 mm).
    pub fn build(
        mesh: &Mesh,
        exact: Arc<ExactMesh>,
        region: Bounds,
        cell: f64,
        task: &Task,
    ) -> Result<Self, FieldError> {
        const STAGE: &str = "distance field";
        task.report(STAGE, 0.0, "");
        let block_size = cell * Block::SIDE as f64;
        let wanted = (region.size() / block_size).ceil().max(DVec3::ONE);
        let total = wanted.element_product() * Block::CELLS as f64;
        if total.is_nan() || total > 2e8 {
            return Err(FieldError::TooLarge { cells: total });
        }
        let along = [wanted.x as usize, wanted.y as usize, wanted.z as usize];
        let bounds = Bounds { min: region.min, max: region.min + wanted * block_size };
        let count = along.iter().product();
        // No triangle further away than this can be a candidate of any block.
        let reaches: Vec<f64> = (0..count)
            .into_par_iter()
            .map(|i| {
                task.check()?;
                let block = [i % along[0], i / along[0] % along[1], i / along[0] / along[1]];
                let center = bounds.min + (DVec3::from_array(block.map(|i| i as f64)) + 0.5) * block_size;
                Ok(exact.nearest(center).signed_distance.abs() + 3f64.sqrt() * block_size + 1e-6)
            })
            .collect::<Result<_, Cancelled>>()?;
        task.report(STAGE, 0.5, "");
        let triangles = LocalTriangles::new(mesh, bounds.grown(reaches.into_iter().fold(0.0, f64::max)));
        task.report(STAGE, 1.0, "");
        let blocks = (0..count).map(|_| OnceLock::new()).collect();
        Ok(Self { bounds, cell, blocks_along: along, blocks, triangles, exact })
    }

    /// The block whose first cell is `first`.
    pub(super) fn block(&self, first: [usize; 3]) -> Block {
        let mut builder = Builder {
            field: self,
            block: Block {
                first,
                handles: [Handle::new(0, 0); Block::CELLS],
                leaves: Vec::new(),
                list_ends: Vec::new(),
                list: Vec::new(),
                windings: Vec::new(),
                centres: Vec::new(),
            },
            leaves: Vec::new(),
            lists: Vec::new(),
            lattice: Lattice::new(),
        };
        let center = builder.center([0; 3], Block::LEVELS);
        let reach = self.exact.nearest(center).signed_distance.abs() + 2.0 * builder.half_diagonal(Block::LEVELS);
        let near = |triangle| Near { from_center: 0.0, triangle, half_space: HalfSpace::ALL };
        let within = self.exact.triangles_within(center, reach);
        let candidates: Vec<Near> = self.triangles.numbers(within).map(near).collect();
        builder.refine([0; 3], Block::LEVELS, &candidates);
        let Builder { mut block, leaves, lists, .. } = builder;
        signs::settle(self, &mut block, &leaves, &lists);
        block.measure_centres(self);
        block
    }
}

/// Nearest features of the points of a block's lattice of half cells, as far as they were asked for: neighbouring
/// cubes share the points between them.
struct Lattice {
    nearest: Vec<Option<Nearest>>,
}

impl Lattice {
    /// Points along each side.
    const SIDE: usize = 2 * Block::SIDE + 1;

    fn new() -> Self {
        Self { nearest: vec![None; Self::SIDE.pow(3)] }
    }

    /// Nearest feature of the point at `t` of the cube of `2^level` cells at `at`, from `find` if it is not known yet.
    fn nearest(&mut self, at: [usize; 3], level: u32, t: DVec3, find: impl FnOnce() -> Nearest) -> Nearest {
        let halves = t * f64::from(2 << level);
        let whole = [0, 1, 2].map(|k| halves[k] as usize);
        if halves != DVec3::from_array(whole.map(|k| k as f64)) {
            return find();
        }
        let [x, y, z] = [0, 1, 2].map(|k| 2 * at[k] + whole[k]);
        *self.nearest[(z * Self::SIDE + y) * Self::SIDE + x].get_or_insert_with(find)
    }
}

/// A triangle that can be nearest to some point of a cube.
#[derive(Clone, Copy)]
struct Near {
    /// Distance from the cube's centre (mm).
    from_center: f64,
    triangle: u32,
    /// Holds the triangle, as far from the centre: mostly tells at other points too that another triangle is nearer.
    half_space: HalfSpace,
}

impl Near {
    fn order(&self, other: &Self) -> Ordering {
        self.from_center.total_cmp(&other.from_center).then(self.triangle.cmp(&other.triangle))
    }
}

struct Builder<'a> {
    field: &'a DistanceField,
    block: Block,
    /// How the surface passes each smooth leaf.
    leaves: Vec<Passage>,
    /// How it passes each exact cell.
    lists: Vec<Passage>,
    lattice: Lattice,
}

impl Builder<'_> {
    /// Describes the cube of `2^level` cells at `at` within the block.
    fn refine(&mut self, at: [usize; 3], level: u32, parents: &[Near]) {
        let (center, half_diagonal) = (self.center(at, level), self.half_diagonal(level));
        let candidates = self.candidates(center, half_diagonal, parents);
        let clear = candidates.first().is_none_or(|near| near.from_center > half_diagonal);
        let contenders = contenders(&candidates, center, half_diagonal);
        let mut guess = contenders.first().map_or(0, |near| near.triangle);
        let (field, corner, triangles) = (self.field, self.block.in_field(at), &self.field.triangles);
        let exact = |t: DVec3| {
            let p = field.point_in(corner, t * f64::from(1 << level));
            let found = self.lattice.nearest(at, level, t, || nearest(triangles, p, center, &contenders, guess));
            guess = found.triangle;
            if clear { found.distance() } else { triangles.signed(p, found).0 }
        };
        let (values, smooth) = smooth_leaf(level, exact);
        if smooth {
            self.fill(at, level, Handle::new(level, self.block.leaves.len()));
            self.leaves.push(self.passage_of_smooth(&values, level, clear));
            self.block.leaves.push(values);
        } else if level == 0 {
            self.fill(at, level, Handle::new(Handle::EXACT, self.block.list_ends.len()));
            // The nearest first: that makes the others quick to rule out.
            let mut candidates = candidates;
            candidates.sort_unstable_by(Near::order);
            let list: Vec<Candidate> =
                candidates.iter().map(|near| Candidate::new(near.from_center, near.triangle)).collect();
            self.lists.push(self.passage_of_exact(&values, clear, &list));
            self.block.list.extend(list);
            self.block.list_ends.push(self.block.list.len() as u32);
        } else {
            let half = 1usize << (level - 1);
            for child in 0..8 {
                let child = [0, 1, 2].map(|k| at[k] + (child >> k & 1) * half);
                self.refine(child, level - 1, &candidates);
            }
        }
    }

    fn fill(&mut self, at: [usize; 3], level: u32, handle: Handle) {
        let n = 1usize << level;
        for z in at[2]..at[2] + n {
            for y in at[1]..at[1] + n {
                self.block.handles[Block::index([at[0], y, z])..][..n].fill(handle);
            }
        }
    }

    fn center(&self, at: [usize; 3], level: u32) -> DVec3 {
        self.field.point_in(self.block.in_field(at), DVec3::splat(0.5 * f64::from(1 << level)))
    }

    fn half_diagonal(&self, level: u32) -> f64 {
        0.5 * 3f64.sqrt() * self.field.cell * f64::from(1 << level)
    }

    /// The triangles among `parents` that can be nearest to some point within `radius` of `center`, the nearest to
    /// `center` first: those no further from there than the nearest plus twice the radius, by the triangle inequality.
    fn candidates(&self, center: DVec3, radius: f64, parents: &[Near]) -> Vec<Near> {
        let spread = 2.0 * radius + 1e-9;
        let mut least = f64::INFINITY;
        let mut found = Vec::with_capacity(parents.len());
        for &Near { triangle, ref half_space, .. } in parents {
            let enough = least + spread;
            if half_space.distance(center) > enough || self.field.triangles.is_beyond(center, triangle, enough) {
                continue;
            }
            let nearest = self.field.triangles.nearest_point(center, triangle);
            let distance = center.distance(nearest);
            least = least.min(distance);
            if distance <= least + spread {
                found.push((distance, triangle, nearest));
            }
        }
        let near = |(distance, triangle, nearest): (f64, u32, DVec3)| {
            let out = if distance > 0.0 { (center - nearest) / distance } else { DVec3::ZERO };
            Near { from_center: distance, triangle, half_space: self.field.triangles.half_space(out, triangle) }
        };
        let reach = least + spread;
        let mut candidates: Vec<Near> = found.into_iter().filter(|&(d, ..)| d <= reach).map(near).collect();
        if let Some(first) = (0..candidates.len()).min_by(|&i, &j| candidates[i].order(&candidates[j])) {
            candidates.swap(0, first);
        }
        candidates
    }

    /// How the surface passes a smooth leaf. It crosses none whose corners are further away than any point of the leaf
    /// is from the nearest place where the interpolation was compared with the truth.
    fn passage_of_smooth(&self, values: &[f32; 8], level: u32, clear: bool) -> Passage {
        let pieces = if level > 0 { 4.0 } else { 2.0 };
        // Interpolation may be off by 5 % far away.
        let reach = 1.06 * self.half_diagonal(level) / pieces + 2.0 * DistanceField::ACCURACY;
        let least = values.iter().map(|v| f64::from(v.abs())).fold(f64::INFINITY, f64::min);
        let one_sign = values.iter().all(|&v| v > 0.0) || values.iter().all(|&v| v < 0.0);
        if clear || (one_sign && least > reach) { Passage::Clear } else { Passage::Crossed(inside_corners(values)) }
    }

    /// How the surface passes an exact cell. Where sheets that face away from each other come together the normals
    /// are unreliable: the mesh may be folded.
    fn passage_of_exact(&self, values: &[f32; 8], clear: bool, triangles: &[Candidate]) -> Passage {
        if clear {
            Passage::Clear
        } else if self.field.triangles.any_opposite(triangles) {
            Passage::Folded
        } else {
            Passage::Crossed(inside_corners(values))
        }
    }
}

/// Triangles among `candidates` that can be nearest within `radius` of `center`, in order of their distance from there.
///
/// The point of the first that is nearest to the centre, at the distance `d` and seen against the unit vector `u`, is
/// no further from a point `center + v` than `d + u . v + v^2 / (2 d)`. Another triangle is at least as far from there
/// as its half-space, at the distance `e + w . v`. So it is out if `e - d` exceeds
/// `radius |u - w| + radius^2 / (2 d)`.
fn contenders(candidates: &[Near], center: DVec3, radius: f64) -> Vec<Near> {
    let Some(first) = candidates.first() else { return Vec::new() };
    let bend = first.from_center + 0.5 * radius * radius / first.from_center;
    let is_out = |near: &Near| {
        let further = near.half_space.distance(center) - bend;
        let turned = near.half_space.out.distance_squared(first.half_space.out);
        further > 0.0 && further * further > radius * radius * turned
    };
    let mut contenders: Vec<Near> = candidates.iter().filter(|near| !is_out(near)).copied().collect();
    contenders.sort_unstable_by(Near::order);
    contenders
}

/// The nearest of `triangles` to `p` of `contenders`, which are in order of their distance from `center`; `guess` is one
/// of them that may be it.
fn nearest(triangles: &LocalTriangles, p: DVec3, center: DVec3, contenders: &[Near], guess: u32) -> Nearest {
    if contenders.is_empty() {
        return Nearest::NONE;
    }
    let away = p.distance(center);
    let (mut best, mut least) = (Nearest::NONE, f64::INFINITY);
    triangles.take_if_nearer(p, guess, &mut best, &mut least);
    for near in contenders {
        if near.from_center - away > least {
            break;
        }
        if near.half_space.distance(p) <= least && near.triangle != guess {
            triangles.take_if_nearer(p, near.triangle, &mut best, &mut least);
        }
    }
    best
}

/// The corner distances of a cube of `2^level` cells by `exact`, and whether interpolating them is accurate enough all over it. In a cube
/// that the surface does not cross they have no sign yet.
fn smooth_leaf(level: u32, mut exact: impl FnMut(DVec3) -> f64) -> ([f32; 8], bool) {
    static PROBES: LazyLock<[Vec<DVec3>; 2]> = LazyLock::new(|| [0, 1].map(|level| probes(level).collect()));
    let values: [f32; 8] = std::array::from_fn(|i| exact(corner_of(i)) as f32);
    let mut good = |t: DVec3| {
        let d = exact(t);
        let allowed = ACCEPTED + 0.05 * (d.abs() - DistanceField::NEAR - ACCEPTED).max(0.0);
        (f64::from(trilinear(&values, t.as_vec3())) - d).abs() <= allowed
    };
    // The centre first: it rejects most cubes at once.
    let accepted = good(DVec3::splat(0.5)) && PROBES[usize::from(level > 0)].iter().all(|&t| good(t));
    (values, accepted)
}

/// Bit `i` is set if corner `i` is inside.
fn inside_corners(values: &[f32; 8]) -> u8 {
    (0..8).filter(|&i| values[i] < 0.0).map(|i| 1 << i).sum()
}

/// The corners of the unit cube: bits 0, 1 and 2 of `i` tell the far side along x, y and z.
fn corner_of(i: usize) -> DVec3 {
    DVec3::new((i & 1) as f64, (i >> 1 & 1) as f64, (i >> 2 & 1) as f64)
}

/// Places in the unit cube where a leaf is compared with exact distances: a lattice that divides each side in 4,
/// without the corners; for single cells only the middles of its edges and faces and of its eight octants.
fn probes(level: u32) -> impl Iterator<Item = DVec3> {
    (0..125).map(|i| [i % 5, i / 5 % 5, i / 25]).filter_map(move |lattice| {
        let corner = lattice.iter().all(|&k| k % 4 == 0);
        let coarse = lattice.iter().all(|&k| k % 2 == 0) || lattice.iter().all(|&k| k % 2 == 1);
        let probe = !corner && (level > 0 || coarse);
        probe.then(|| DVec3::from_array(lattice.map(|k| k as f64 * 0.25)))
    })
}
