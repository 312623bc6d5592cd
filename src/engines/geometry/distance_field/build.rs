//! Building a [`DistanceField`]: octree cubes that carry the triangles that can be nearest inside them.

use std::cmp::Ordering;
use std::collections::HashMap;

use glam::DVec3;
use rayon::prelude::*;

use super::local_triangles::{Candidate, HalfSpace, Nearest};
use super::signs::{self, Passage};
use super::{DistanceField, Handle, LocalTriangles, trilinear};
use crate::exact::ExactMesh;
use crate::mesh::{Bounds, Mesh};
use task::{Cancel, Cancelled, Task};

/// Levels of leaves above single cells: the largest leaf spans `2^LEVELS` cells.
const LEVELS: u32 = 3;

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

/// Part of the field from one root cube: handles of its cells in x-fastest order, with numbers local to the cube.
#[derive(Default)]
struct Block {
    handles: Vec<Handle>,
    leaves: Vec<[f32; 8]>,
    leaf_kinds: Vec<Passage>,
    lists: Vec<Vec<Candidate>>,
    list_kinds: Vec<Passage>,
}

impl DistanceField {
    /// The field of `mesh` (prepared as `exact`) over `region`, grown to whole leaves, with cells of about
    /// `cell` mm (0.2 suits parts of some 100 mm).
    pub fn build(mesh: &Mesh, exact: &ExactMesh, region: Bounds, cell: f64, task: &Task) -> Result<Self, FieldError> {
        const STAGE: &str = "distance field";
        let root_size = cell * f64::from(1 << LEVELS);
        let roots_wanted = (region.size() / root_size).ceil().max(DVec3::ONE);
        let total = roots_wanted.element_product() * 8f64.powi(LEVELS as i32);
        if total.is_nan() || total > 2e8 {
            return Err(FieldError::TooLarge { cells: total });
        }
        let roots = [roots_wanted.x as usize, roots_wanted.y as usize, roots_wanted.z as usize];
        let bounds = Bounds { min: region.min, max: region.min + roots_wanted * root_size };
        // No triangle further away than this can be a candidate of any cube.
        let reaches: Vec<f64> = (0..roots.iter().product())
            .into_par_iter()
            .map(|i| {
                task.check()?;
                let root = [i % roots[0], i / roots[0] % roots[1], i / roots[0] / roots[1]];
                let center = bounds.min + (DVec3::from_array(root.map(|i| i as f64)) + 0.5) * root_size;
                Ok(exact.nearest(center).signed_distance.abs() + 3f64.sqrt() * root_size + 1e-6)
            })
            .collect::<Result<_, Cancelled>>()?;
        let triangles = LocalTriangles::new(mesh, bounds.grown(reaches.into_iter().fold(0.0, f64::max)));
        let probes = [0, 1].map(|level| probes(level).collect());
        let builder = Builder { triangles: &triangles, exact, min: bounds.min, cell, probes };
        let slabs = roots[1] * roots[2];
        let done = std::sync::atomic::AtomicUsize::new(0);
        let rows: Vec<Vec<Block>> = (0..slabs)
            .into_par_iter()
            .map(|row| {
                task.check()?;
                let blocks = (0..roots[0]).map(|i| builder.block([i, row % roots[1], row / roots[1]])).collect();
                let n = done.fetch_add(1, std::sync::atomic::Ordering::Relaxed) + 1;
                task.report(STAGE, n as f64 / slabs as f64, "");
                Ok(blocks)
            })
            .collect::<Result<_, Cancelled>>()?;
        let mut field = Self {
            bounds,
            cell,
            cells: roots.map(|n| n << LEVELS),
            handles: Vec::new(),
            leaves: Vec::new(),
            list_ends: Vec::new(),
            list: Vec::new(),
            windings: HashMap::new(),
            centres: Vec::new(),
            triangles,
        };
        let (leaves, lists) = field.assemble(roots, rows);
        signs::settle(&mut field, exact, leaves, lists, &task.cancel)?;
        field.centres = field.distances_at_centres(&task.cancel)?;
        Ok(field)
    }

    /// Distance at the centre of every exact cell, in the order of their numbers.
    fn distances_at_centres(&self, cancel: &Cancel) -> Result<Vec<f32>, Cancelled> {
        let exact = |i: &usize| self.handles[*i].kind() >= Handle::OUTSIDE;
        let numbers: Result<Vec<(usize, f32)>, Cancelled> = (0..self.handles.len())
            .into_par_iter()
            .filter(exact)
            .map(|i| {
                cancel.check()?;
                let [nx, ny, _] = self.cells;
                let center = self.center([i % nx, i / nx % ny, i / nx / ny]);
                Ok((self.handles[i].number(), self.value(center).unwrap_or(0.0) as f32))
            })
            .collect();
        let mut centres = vec![f32::NEG_INFINITY; self.list_ends.len()];
        numbers?.into_iter().for_each(|(number, distance)| centres[number] = distance);
        Ok(centres)
    }

    /// Puts the blocks together; answers how the surface passes each leaf and each exact cell.
    fn assemble(&mut self, roots: [usize; 3], rows: Vec<Vec<Block>>) -> (Vec<Passage>, Vec<Passage>) {
        let (mut leaf_kinds, mut list_kinds) = (Vec::new(), Vec::new());
        let side = 1usize << LEVELS;
        self.handles = vec![Handle::new(0, 0); self.cells.iter().product()];
        for (row, blocks) in rows.into_iter().enumerate() {
            for (i, block) in blocks.into_iter().enumerate() {
                let first = [i * side, row % roots[1] * side, row / roots[1] * side];
                for (k, handle) in block.handles.into_iter().enumerate() {
                    let base = if handle.kind() == Handle::EXACT { self.list_ends.len() } else { self.leaves.len() };
                    let at = [first[0] + k % side, first[1] + k / side % side, first[2] + k / side / side];
                    self.handles[(at[2] * self.cells[1] + at[1]) * self.cells[0] + at[0]] =
                        Handle::new(handle.kind(), base + handle.number());
                }
                self.leaves.extend(block.leaves);
                leaf_kinds.extend(block.leaf_kinds);
                list_kinds.extend(block.list_kinds);
                for list in block.lists {
                    self.list.extend(list);
                    self.list_ends.push(self.list.len() as u32);
                }
            }
        }
        (leaf_kinds, list_kinds)
    }
}

/// Nearest features of the points of a root cube's lattice of half cells, as far as they were asked for: neighbouring
/// cubes share the points between them.
struct Lattice {
    nearest: Vec<Option<Nearest>>,
}

impl Lattice {
    /// Points along each side.
    const SIDE: usize = 2 * (1 << LEVELS) + 1;

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
    triangles: &'a LocalTriangles,
    exact: &'a ExactMesh,
    min: DVec3,
    cell: f64,
    /// Of single cells, and of larger leaves.
    probes: [Vec<DVec3>; 2],
}

impl Builder<'_> {
    fn block(&self, root: [usize; 3]) -> Block {
        let side = 1usize << LEVELS;
        let mut block = Block { handles: vec![Handle::new(0, 0); side.pow(3)], ..Default::default() };
        let first = root.map(|i| i << LEVELS);
        let center = self.center(first, LEVELS);
        let reach = self.exact.nearest(center).signed_distance.abs() + 2.0 * self.half_diagonal(LEVELS);
        let near = |triangle| Near { from_center: 0.0, triangle, half_space: HalfSpace::ALL };
        let within = self.exact.triangles_within(center, reach);
        let candidates: Vec<Near> = self.triangles.numbers(within).map(near).collect();
        self.refine(&mut block, &mut Lattice::new(), ([0; 3], LEVELS), first, &candidates);
        block
    }

    /// Describes the cube of `2^level` cells at `at` within the block whose first cell is `first`.
    fn refine(
        &self,
        block: &mut Block,
        lattice: &mut Lattice,
        (at, level): ([usize; 3], u32),
        first: [usize; 3],
        parents: &[Near],
    ) {
        let corner = [0, 1, 2].map(|k| first[k] + at[k]);
        let candidates = self.candidates(self.center(corner, level), self.half_diagonal(level), parents);
        let clear = candidates.first().is_none_or(|near| near.from_center > self.half_diagonal(level));
        let center = self.center(corner, level);
        let contenders = contenders(&candidates, center, self.half_diagonal(level));
        let mut guess = contenders.first().map_or(0, |near| near.triangle);
        let mut exact = |lattice: &mut Lattice, t: DVec3| {
            let p = self.point(corner, level, t);
            let nearest = lattice.nearest(at, level, t, || self.nearest(p, center, &contenders, guess));
            guess = nearest.triangle;
            if clear { nearest.distance() } else { self.triangles.signed(p, nearest).0 }
        };
        let (values, smooth) = smooth_leaf(&self.probes[usize::from(level > 0)], |t| exact(lattice, t));
        if smooth {
            let handle = Handle::new(level, block.leaves.len());
            block.leaf_kinds.push(self.passage_of_smooth(&values, level, clear));
            block.leaves.push(values);
            self.fill(block, at, level, handle);
        } else if level == 0 {
            let handle = Handle::new(Handle::EXACT, block.lists.len());
            // The nearest first: that makes the others quick to rule out.
            let mut candidates = candidates;
            candidates.sort_unstable_by(Near::order);
            let list: Vec<Candidate> =
                candidates.iter().map(|near| Candidate::new(near.from_center, near.triangle)).collect();
            block.list_kinds.push(self.passage_of_exact(&values, clear, &list));
            block.lists.push(list);
            self.fill(block, at, level, handle);
        } else {
            let half = 1usize << (level - 1);
            for child in 0..8 {
                let offset = [0, 1, 2].map(|k| at[k] + (child >> k & 1) * half);
                self.refine(block, lattice, (offset, level - 1), first, &candidates);
            }
        }
    }

    fn fill(&self, block: &mut Block, at: [usize; 3], level: u32, handle: Handle) {
        let (side, n) = (1usize << LEVELS, 1usize << level);
        for z in at[2]..at[2] + n {
            for y in at[1]..at[1] + n {
                block.handles[(z * side + y) * side + at[0]..][..n].fill(handle);
            }
        }
    }

    fn center(&self, corner: [usize; 3], level: u32) -> DVec3 {
        self.point(corner, level, DVec3::splat(0.5))
    }

    fn half_diagonal(&self, level: u32) -> f64 {
        0.5 * 3f64.sqrt() * self.cell * f64::from(1 << level)
    }

    /// The point at `t` (0 to 1 along each axis) of the cube at `corner`.
    fn point(&self, corner: [usize; 3], level: u32, t: DVec3) -> DVec3 {
        let corner = DVec3::from_array(corner.map(|i| i as f64));
        self.min + (corner + t * f64::from(1 << level)) * self.cell
    }

    /// The triangles among `parents` that can be nearest to some point within `radius` of `center`, the nearest to
    /// `center` first: those no further from there than the nearest plus twice the radius, by the triangle inequality.
    fn candidates(&self, center: DVec3, radius: f64, parents: &[Near]) -> Vec<Near> {
        let spread = 2.0 * radius + 1e-9;
        let mut least = f64::INFINITY;
        let mut found = Vec::with_capacity(parents.len());
        for &Near { triangle, ref half_space, .. } in parents {
            let enough = least + spread;
            if half_space.distance(center) > enough || self.triangles.is_beyond(center, triangle, enough) {
                continue;
            }
            let nearest = self.triangles.nearest_point(center, triangle);
            let distance = center.distance(nearest);
            least = least.min(distance);
            if distance <= least + spread {
                found.push((distance, triangle, nearest));
            }
        }
        let near = |(distance, triangle, nearest): (f64, u32, DVec3)| {
            let out = if distance > 0.0 { (center - nearest) / distance } else { DVec3::ZERO };
            Near { from_center: distance, triangle, half_space: self.triangles.half_space(out, triangle) }
        };
        let reach = least + spread;
        let mut candidates: Vec<Near> = found.into_iter().filter(|&(d, ..)| d <= reach).map(near).collect();
        if let Some(first) = (0..candidates.len()).min_by(|&i, &j| candidates[i].order(&candidates[j])) {
            candidates.swap(0, first);
        }
        candidates
    }

    /// The nearest to `p` of `contenders`, which are in order of their distance from `center`; `guess` is one of them
    /// that may be it.
    fn nearest(&self, p: DVec3, center: DVec3, contenders: &[Near], guess: u32) -> Nearest {
        if contenders.is_empty() {
            return Nearest::NONE;
        }
        let away = p.distance(center);
        let (mut best, mut least) = (Nearest::NONE, f64::INFINITY);
        self.triangles.take_if_nearer(p, guess, &mut best, &mut least);
        for near in contenders {
            if near.from_center - away > least {
                break;
            }
            if near.half_space.distance(p) <= least && near.triangle != guess {
                self.triangles.take_if_nearer(p, near.triangle, &mut best, &mut least);
            }
        }
        best
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
        } else if self.triangles.any_opposite(triangles) {
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

/// The corner distances of a cube by `exact`, and whether interpolating them is accurate enough all over it. In a cube
/// that the surface does not cross they have no sign yet.
fn smooth_leaf(probes: &[DVec3], mut exact: impl FnMut(DVec3) -> f64) -> ([f32; 8], bool) {
    let values: [f32; 8] = std::array::from_fn(|i| exact(corner_of(i)) as f32);
    let mut good = |t: DVec3| {
        let d = exact(t);
        let allowed = ACCEPTED + 0.05 * (d.abs() - DistanceField::NEAR - ACCEPTED).max(0.0);
        (f64::from(trilinear(&values, t.as_vec3())) - d).abs() <= allowed
    };
    // The centre first: it rejects most cubes at once.
    let accepted = good(DVec3::splat(0.5)) && probes.iter().all(|&t| good(t));
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
