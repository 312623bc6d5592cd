//! What is left over the faces that look upwards, column by column.
//!
//! Every such face is divided until what is left over it is told well enough by its values at the corners of the parts.
//! Parts along which the cutter slides unhindered are not looked at further.

use std::collections::HashMap;

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use crate::geometry::mesh::{Mesh, unit_normal};
use crate::progress::{Cancel, Cancelled};

/// Up to where a face is divided, and what counts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fineness {
    /// Residue along the normal that does not count (mm).
    pub tolerance: f64,
    /// Length of edges at which a part is looked at (mm).
    pub coarse: f64,
    /// Length of edges that are not divided any more where the residue begins to count (mm).
    pub border: f64,
    /// Length of edges that are not divided any more (mm).
    pub fine: f64,
    /// Error of a part's volume at which it is not divided any more (mm^3).
    pub error: f64,
}

impl Fineness {
    /// What a ball of `radius` (mm) asks for.
    pub fn of_ball(radius: f64, tolerance: f64) -> Self {
        // On a plane the residue of a ball begins with the square of the way from where the ball touches.
        let border = (0.6 * (2.0 * radius * tolerance).sqrt()).min(0.25 * radius);
        Self { tolerance, coarse: radius / 3.0, border, fine: radius / 48.0, error: 2e-4 * radius.powi(3) }
    }
}

/// A part of a face with something left over it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Column {
    /// Which face of the mesh.
    pub face: u32,
    /// Its corners on the face.
    pub corners: [DVec3; 3],
    /// Height of what is left over each corner (mm).
    pub left: [f64; 3],
}

/// What is left over a place, and how far a cutter slides freely there.
pub trait Remainder: Sync {
    /// Height of the lowest surface that a cutter leaves over `p` (mm).
    fn height(&self, p: DVec2) -> f64;
    /// How far around `p`, on a face with this normal, surely nothing is left, if no more than `most` (mm).
    fn slack(&self, p: DVec3, normal: DVec3, most: f64) -> f64;
}

/// The parts of the upward faces of `mesh` over which something is left.
///
/// # Errors
/// [`Cancelled`].
pub fn columns(
    mesh: &Mesh,
    remainder: &impl Remainder,
    fineness: &Fineness,
    cancel: &Cancel,
) -> Result<Vec<Column>, Cancelled> {
    let of_face = |i: usize| {
        let corners = mesh.corners(i);
        let normal = unit_normal(corners);
        let mut division =
            Division { remainder, fineness, cancel, face: i as u32, normal, found: Vec::new(), known: HashMap::new() };
        if normal.z > UPWARD {
            division.part(corners, [None; 3])?;
        }
        Ok(division.found)
    };
    let found: Result<Vec<Vec<Column>>, Cancelled> = (0..mesh.triangles.len()).into_par_iter().map(of_face).collect();
    Ok(found?.concat())
}

/// Least slope of a face whose columns count (z of its normal).
const UPWARD: f64 = 1e-3;

struct Division<'a, R> {
    remainder: &'a R,
    fineness: &'a Fineness,
    cancel: &'a Cancel,
    face: u32,
    normal: DVec3,
    found: Vec<Column>,
    /// What is left over places that two parts have in common.
    known: HashMap<[u64; 3], f64>,
}

impl<R: Remainder> Division<'_, R> {
    /// A part with what is known over its corners.
    fn part(&mut self, corners: [DVec3; 3], known: [Option<f64>; 3]) -> Result<(), Cancelled> {
        let middle = corners.iter().sum::<DVec3>() / 3.0;
        let (longest, length) = longest_edge(&corners);
        let reach = corners.iter().map(|c| c.distance(middle)).fold(0.0, f64::max);
        if length > 16.0 * self.fineness.coarse {
            return self.halves(corners, known, longest);
        }
        if known.iter().all(Option::is_none) {
            self.cancel.check()?;
            if self.remainder.slack(middle, self.normal, reach) >= reach {
                return Ok(());
            }
            if length > self.fineness.coarse {
                return self.halves(corners, known, longest);
            }
        }
        let left: [f64; 3] = std::array::from_fn(|k| known[k].unwrap_or_else(|| self.left_at_corner(corners[k])));
        let over = |left: f64, at: DVec3| (left - at.z).max(0.0);
        let all: [f64; 3] = std::array::from_fn(|k| over(left[k], corners[k]));
        let counts = |residue: f64| residue * self.normal.z > self.fineness.tolerance;
        if length > self.fineness.fine.min(self.fineness.border) {
            let at_middle = over(self.left(middle), middle);
            let flat = all.iter().sum::<f64>() / 3.0;
            let plan = 0.5 * (corners[1] - corners[0]).cross(corners[2] - corners[0]).z;
            let some = counts(at_middle) || all.iter().any(|r| counts(*r));
            let every = counts(at_middle) && all.iter().all(|r| counts(*r));
            let is_border = some && !every && length > self.fineness.border;
            let is_rough = (at_middle - flat).abs() * plan > self.fineness.error && length > self.fineness.fine;
            if is_border || (some && is_rough) {
                return self.halves(corners, left.map(Some), longest);
            }
        }
        if all.iter().any(|r| counts(*r)) {
            self.found.push(Column { face: self.face, corners, left });
        }
        Ok(())
    }

    fn left(&self, at: DVec3) -> f64 {
        self.remainder.height(at.truncate())
    }

    fn left_at_corner(&mut self, at: DVec3) -> f64 {
        let key = at.to_array().map(f64::to_bits);
        if let Some(known) = self.known.get(&key) {
            return *known;
        }
        let left = self.left(at);
        self.known.insert(key, left);
        left
    }

    /// Both halves of a part, divided in the middle of its edge from corner `k`.
    fn halves(&mut self, corners: [DVec3; 3], known: [Option<f64>; 3], k: usize) -> Result<(), Cancelled> {
        let [a, b, c] = [k, (k + 1) % 3, (k + 2) % 3];
        let at = (corners[a] + corners[b]) * 0.5;
        let between = if known.iter().any(Option::is_some) { Some(self.left_at_corner(at)) } else { None };
        self.part([corners[a], at, corners[c]], [known[a], between, known[c]])?;
        self.part([at, corners[b], corners[c]], [between, known[b], known[c]])
    }
}

/// The corner from which the longest edge in the plan goes, and its length.
fn longest_edge(corners: &[DVec3; 3]) -> (usize, f64) {
    let length = |k: usize| corners[k].distance(corners[(k + 1) % 3]);
    (0..3).map(|k| (k, length(k))).fold((0, 0.0), |best, edge| if edge.1 > best.1 { edge } else { best })
}

impl Column {
    /// Area in the plan (mm^2) and volume (mm^3) of what counts: the residue along `normal` above `tolerance` (mm).
    pub fn measure(&self, normal: DVec3, tolerance: f64) -> (f64, f64) {
        let residue: [f64; 3] = std::array::from_fn(|k| (self.left[k] - self.corners[k].z).max(0.0));
        let least = tolerance / normal.z;
        // Cut along the line on which the residue is the least that counts.
        let mut cut: Vec<(DVec2, f64)> = Vec::with_capacity(4);
        for k in 0..3 {
            let next = (k + 1) % 3;
            let (p, q) = (self.corners[k].truncate(), self.corners[next].truncate());
            let (a, b) = (residue[k], residue[next]);
            if a > least {
                cut.push((p, a));
            }
            if (a > least) != (b > least) {
                // Where a ball touches the residue begins as a square.
                let share = (least.sqrt() - a.sqrt()) / (b.sqrt() - a.sqrt());
                cut.push((p.lerp(q, share), least));
            }
        }
        let Some(&(o, at_o)) = cut.first() else { return (0.0, 0.0) };
        let mut sums = (0.0, 0.0);
        for w in cut.windows(2).skip(1) {
            let area = 0.5 * (w[0].0 - o).perp_dot(w[1].0 - o);
            sums.0 += area;
            sums.1 += area * (at_o + w[0].1 + w[1].1) / 3.0;
        }
        sums
    }
}
