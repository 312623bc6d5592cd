//! Square lattices in the meridional plane, filled from a place on.

use std::collections::HashMap;

use glam::DVec2;

use super::slices::Slices;
use task::{Cancel, Cancelled};

/// Most points of a lattice that are looked at.
pub(crate) const MOST_POINTS: usize = 40_000;
/// With fewer points a lattice is made finer, so many times at most.
const ENOUGH_POINTS: usize = 1_000;
const MOST_HALVINGS: usize = 4;

/// A square lattice in the meridional plane.
pub(crate) struct Lattice {
    /// Place (x, r) of its point [0, 0] (mm).
    start: DVec2,
    /// Distance of neighbouring points (mm).
    pub step: f64,
}

impl Lattice {
    /// Place (x, r) of a point, or between points (mm).
    pub fn place(&self, point: [f64; 2]) -> DVec2 {
        self.start + self.step * DVec2::from(point)
    }

    /// The point nearest to a place (x, r).
    pub fn nearest(&self, place: DVec2) -> [i32; 2] {
        ((place - self.start) / self.step).round().as_ivec2().into()
    }

    /// The points that are reached on a lattice from a place (x, r), with what is known of each: `next` says it of a place
    /// from what is known of its neighbour, or that the place does not belong to them. The lattice is made finer until there
    /// are [`ENOUGH_POINTS`]; there are [`MOST_POINTS`] at most.
    pub fn filled<T: Copy>(
        slices: &Slices,
        (start, known): (DVec2, T),
        next: impl Fn(DVec2, &T) -> Option<T>,
        cancel: &Cancel,
    ) -> Result<(Self, HashMap<[i32; 2], T>), Cancelled> {
        let mut lattice = Self { start, step: slices.cell_size().y };
        let mut halvings = 0;
        loop {
            let mut found = HashMap::from([([0, 0], known)]);
            let mut queue = vec![[0, 0]];
            let mut done = 0;
            while let Some(&point) = queue.get(done).filter(|_| queue.len() < MOST_POINTS) {
                cancel.check()?;
                done += 1;
                let near = found[&point];
                for beside in around(point) {
                    if !found.contains_key(&beside)
                        && let Some(known) = next(lattice.place(beside.map(f64::from)), &near)
                    {
                        found.insert(beside, known);
                        queue.push(beside);
                    }
                }
            }
            if found.len() >= ENOUGH_POINTS || halvings == MOST_HALVINGS {
                return Ok((lattice, found));
            }
            lattice.step *= 0.5;
            halvings += 1;
        }
    }
}

/// The four neighbours of a point of a lattice, anticlockwise from the one below.
pub(crate) fn around([i, j]: [i32; 2]) -> [[i32; 2]; 4] {
    [[i, j - 1], [i + 1, j], [i, j + 1], [i - 1, j]]
}
