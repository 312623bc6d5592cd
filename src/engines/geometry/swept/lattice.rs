//! The lattice that a swept surface is made on, and which of its points are inside.

use glam::DVec3;
use rayon::prelude::*;

use super::motion::{Motion, Near};
use crate::mesh::Bounds;
use task::{Cancel, Cancelled};

/// Cells along an edge of a block.
pub(super) const BLOCK: usize = 8;
/// Most cells along the longest edge.
const LONGEST: f64 = 600.0;
/// How far beside its cell a vertex may be put to meet an edge of the surface (cells): an edge that runs along the face
/// between two cells belongs to one of them at least.
const BESIDE: f64 = 0.1;

/// A cubic lattice whose outermost points are outside.
pub(super) struct Lattice {
    min: DVec3,
    /// Distance of its points (mm).
    pub cell: f64,
    /// Blocks along each axis; a block has `BLOCK` points along each.
    blocks: [usize; 3],
}

/// Lattice points inside, and the placements that matter in those blocks that the surface passes.
pub(super) struct Blocks {
    inside: Vec<bool>,
    /// The blocks that the surface may pass, in rising order, each by its number.
    pub mixed: Vec<(usize, Near)>,
}

enum Block {
    Outside,
    Inside,
    Mixed(Near, Box<[bool; BLOCK * BLOCK * BLOCK]>),
}

impl Lattice {
    /// A lattice of about `cells` cells around `bounds`.
    pub(super) fn around(bounds: &Bounds, cells: usize) -> Self {
        let size = bounds.size();
        let cell = (size.element_product() / cells.max(1) as f64).cbrt().max(size.max_element() / LONGEST);
        // A single point has a lattice of some cells, too.
        let cell = if cell > 0.0 { cell } else { 1.0 };
        // A cell and a half stay free on every side; the lattice has no plane in common with the box.
        let points = (size / cell).ceil() + 4.0;
        let blocks = points.to_array().map(|n| (n as usize).div_ceil(BLOCK));
        Self { min: bounds.min - 1.517 * cell, cell, blocks }
    }

    /// Finds out which points are inside.
    pub(super) fn blocks(&self, motion: &Motion, cancel: &Cancel) -> Result<Blocks, Cancelled> {
        let count: usize = self.blocks.iter().product();
        let made: Vec<Block> = (0..count)
            .into_par_iter()
            .map(|number| cancel.check().map(|()| self.block(number, motion)))
            .collect::<Result<_, _>>()?;
        let mut blocks = Blocks { inside: vec![false; count * BLOCK.pow(3)], mixed: Vec::new() };
        for (number, block) in made.into_iter().enumerate() {
            let mut fill = |inside: &dyn Fn(usize) -> bool| {
                for i in 0..BLOCK.pow(3) {
                    blocks.inside[self.index(self.point_of(number, i))] = inside(i);
                }
            };
            match block {
                Block::Outside => {}
                Block::Inside => fill(&|_| true),
                Block::Mixed(near, inside) => {
                    fill(&|i| inside[i]);
                    blocks.mixed.push((number, near));
                }
            }
        }
        Ok(blocks)
    }

    fn block(&self, number: usize, motion: &Motion) -> Block {
        let first = self.point_of(number, 0);
        let center = self.place(first) + 0.5 * BLOCK as f64 * self.cell;
        // Half its diagonal, and as far as a vertex may have to go.
        let radius = (0.5 * BLOCK as f64 * 3f64.sqrt() + 2.0) * self.cell;
        let near = motion.near(center, radius);
        if near.covered {
            return Block::Inside;
        }
        if near.is_empty() {
            return Block::Outside;
        }
        let mut last = near.first();
        let inside = std::array::from_fn(|i| motion.covers(&near, self.place(self.point_of(number, i)), &mut last));
        Block::Mixed(near, Box::new(inside))
    }

    /// Point `i` of a block, in steps from the first of the lattice.
    pub(super) fn point_of(&self, block: usize, i: usize) -> [usize; 3] {
        let [nx, ny, _] = self.blocks;
        let at = [block % nx, block / nx % ny, block / nx / ny];
        let within = [i % BLOCK, i / BLOCK % BLOCK, i / BLOCK / BLOCK];
        [0, 1, 2].map(|k| at[k] * BLOCK + within[k])
    }

    /// Position of a point.
    pub(super) fn place(&self, point: [usize; 3]) -> DVec3 {
        self.min + DVec3::from_array(point.map(|i| i as f64)) * self.cell
    }

    /// Whether `q` lies in the cell that `p` lies in, or hardly beside it.
    pub(super) fn keeps(&self, p: DVec3, q: DVec3) -> bool {
        let center = ((p - self.min) / self.cell).floor() + 0.5;
        ((q - self.min) / self.cell - center).abs().max_element() <= 0.5 + BESIDE
    }

    /// The number of a point.
    pub(super) fn index(&self, point: [usize; 3]) -> usize {
        let [nx, ny, _] = self.blocks.map(|n| n * BLOCK);
        (point[2] * ny + point[1]) * nx + point[0]
    }

    /// Index step to the next point along an axis.
    pub(super) fn stride(&self, axis: usize) -> usize {
        let [nx, ny, _] = self.blocks.map(|n| n * BLOCK);
        [1, nx, nx * ny][axis]
    }

    /// Number of points.
    pub(super) fn point_count(&self) -> usize {
        self.blocks.iter().product::<usize>() * BLOCK.pow(3)
    }

    /// Whether a point is the first of a cell, not on the far rim.
    pub(super) fn has_cell(&self, point: [usize; 3]) -> bool {
        (0..3).all(|k| point[k] + 1 < self.blocks[k] * BLOCK)
    }
}

impl Blocks {
    /// Whether a point, by its number, is inside.
    pub(super) fn is_inside(&self, index: usize) -> bool {
        self.inside[index]
    }
}
