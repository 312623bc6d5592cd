//! The sides of outlines in the squares of a grid, to find those near a place.

use std::collections::HashMap;

use glam::{DVec2, IVec2};

/// Grid over the edges of outlines, which finds those near a place.
pub struct EdgeGrid {
    cell: f64,
    squares: HashMap<IVec2, Vec<u32>>,
}

impl EdgeGrid {
    /// Cells that one side may be put into, along either axis.
    const MOST_CELLS: f64 = 4096.0;

    /// A grid of squares of size `cell` (mm) over `sides`.
    pub fn new(sides: &[[DVec2; 2]], cell: f64) -> Self {
        let longest = sides.iter().map(|[a, b]| (*b - *a).abs().max_element()).fold(0.0, f64::max);
        let cell = cell.max(longest / Self::MOST_CELLS).max(1e-6);
        let mut grid = Self { cell, squares: HashMap::new() };
        for (i, [a, b]) in sides.iter().enumerate() {
            // Walk the side in steps of half a cell: no square that it crosses by more than a corner is missed, and
            // queries are widened by what may be.
            let steps = (2.0 * a.distance(*b) / cell).ceil().max(1.0) as usize;
            for k in 0..=steps {
                let square = grid.square(a.lerp(*b, k as f64 / steps as f64));
                let listed = grid.squares.entry(square).or_default();
                if listed.last() != Some(&(i as u32)) {
                    listed.push(i as u32);
                }
            }
        }
        grid
    }

    fn square(&self, p: DVec2) -> IVec2 {
        (p / self.cell).floor().clamp(DVec2::splat(-1e9), DVec2::splat(1e9)).as_ivec2()
    }

    /// The sides that come within `reach` (mm) of the box from `min` to `max`, and some more, in order.
    pub fn near(&self, min: DVec2, max: DVec2, reach: f64, found: &mut Vec<u32>) {
        found.clear();
        self.add(min, max, reach, found);
        found.sort_unstable();
        found.dedup();
    }

    /// The sides that come within `reach` (mm) of a line between two points, and some more, in order.
    pub fn along(&self, [a, b]: [DVec2; 2], reach: f64, found: &mut Vec<u32>) {
        found.clear();
        // The box around a long line aslant holds many more squares than are near it.
        let pieces = (a.distance(b) / (reach + self.cell)).ceil().clamp(1.0, Self::MOST_CELLS) as usize;
        let at = |k: usize| a.lerp(b, k as f64 / pieces as f64);
        (0..pieces).for_each(|k| self.add(at(k).min(at(k + 1)), at(k).max(at(k + 1)), reach, found));
        found.sort_unstable();
        found.dedup();
    }

    fn add(&self, min: DVec2, max: DVec2, reach: f64, found: &mut Vec<u32>) {
        let margin = reach + 0.5 * self.cell;
        let (from, to) = (self.square(min - margin), self.square(max + margin));
        for x in from.x..=to.x {
            for y in from.y..=to.y {
                found.extend(self.squares.get(&IVec2::new(x, y)).into_iter().flatten());
            }
        }
    }
}
