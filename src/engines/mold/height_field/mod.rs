//! Residual stock of cutters by a height map: the second answer, independent of outlines and layers.
//!
//! A mold seen from above is one height per cell of a regular grid, that of the topmost material at the cell's centre;
//! what lies below an overhang is in its shadow, and outside the block is air. The cutter's tip comes down anywhere
//! until its surface meets a height ([`closing`]). Where the material encloses an opening through it, the stock ends at
//! the underside, and cutters go on below it. What lies between the least surface so left over all cutters and the
//! material is uncut, and its connected pieces are the regions ([`regions`]).
//!
//! Plan positions are exact to about half a cell, so what is left in a corner is found once it is some cells wide: with
//! 40 cells to the cutter's radius its volume is right within some per cent where walls run askew to the grid, and
//! better where they run along it. A step of a tenth of the smallest radius is the coarsest of use.

mod blocks;
mod closing;
mod covered;
mod element;
mod raster;
mod regions;
mod sweep;
#[cfg(test)]
mod tests;
mod touching;

pub use closing::{Closing, Correction, closing, closing_corrected, closing_within};
pub use covered::{Cover, Covered, Left};
pub use regions::{FieldRegion, difference, regions};
pub use touching::left_at_most;

use std::ops::Range;

use glam::{DVec2, DVec3};

use files::Invalid;
use task::Cancelled;

/// Most cells that a grid may have: some 20 bytes each.
const MOST_CELLS: f64 = 64e6;

/// Invalid height map or query.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum HeightFieldError {
    /// A mesh that covers no plan area.
    #[error("the mold covers no area when seen from above: there is nothing to cut")]
    NoMaterial,
    /// A step that is no length.
    #[error("the grid's step is {0} mm: it must be a finite length above zero")]
    BadStep(f64),
    /// A grid with too many cells for a computer's memory.
    #[error(
        "a grid of {step} mm over {width:.1} x {depth:.1} mm has {} million cells and at most {} million are \
         possible; a step of {coarser:.3} mm will do",
        (cells / 1e6).ceil(), MOST_CELLS / 1e6
    )]
    TooManyCells {
        /// The step (mm).
        step: f64,
        /// Extent along x, with the room that the largest cutter needs beside the mold (mm).
        width: f64,
        /// Extent along y, with the same (mm).
        depth: f64,
        /// How many cells it would have.
        cells: f64,
        /// A step that makes few enough (mm).
        coarser: f64,
    },
    /// The residual stock belongs to another height map.
    #[error("what the cutters leave was found on a grid of {found} cells, the heights have {expected}: find it again")]
    OtherGrid {
        /// Cells of the heights.
        expected: usize,
        /// Cells of what is left.
        found: usize,
    },
    /// A cutter that is none.
    #[error(transparent)]
    Cutter(#[from] Invalid),
    /// Told to stop.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

/// The topmost material of a mold at the centres of a regular grid in plan.
#[derive(Debug, Clone, PartialEq)]
pub struct HeightField {
    /// The least corner of the first cell (mm).
    corner: DVec2,
    /// Side of a cell (mm).
    step: f64,
    columns: usize,
    rows: usize,
    /// Height that the heights are counted from (mm).
    base: f64,
    /// Row by row; minus infinity where there is no material.
    heights: Vec<f32>,
    /// The z component of the surface's unit normal, in parts of [`UPNESS_ONE`].
    upness: Vec<u16>,
    /// Cells of openings through the material, in order; their height is that of the underside.
    through: Vec<u32>,
}

/// The upness of a horizontal face.
const UPNESS_ONE: f64 = u16::MAX as f64;

impl HeightField {
    /// Number of cells along x and along y.
    pub fn size(&self) -> [usize; 2] {
        [self.columns, self.rows]
    }

    /// Side of a cell (mm).
    pub fn step(&self) -> f64 {
        self.step
    }

    /// Centre of a cell in plan (mm); cells are numbered along x, then along y.
    pub fn center(&self, cell: usize) -> DVec2 {
        let at = DVec2::new((cell % self.columns) as f64, (cell / self.columns) as f64);
        self.corner + (at + 0.5) * self.step
    }

    /// Columns and rows of the cells whose centres lie within a rectangle in plan (mm); none if there are none.
    pub fn cells_within(&self, low: DVec2, high: DVec2) -> Option<[Range<usize>; 2]> {
        let [from, to] = [low, high].map(|p| (p - self.corner) / self.step - 0.5);
        let span = |from: f64, to: f64, count: usize| {
            let (first, last) = (from.ceil().max(0.0), to.floor().min(count as f64 - 1.0));
            (first <= last).then(|| first as usize..last as usize + 1)
        };
        Some([span(from.x, to.x, self.columns)?, span(from.y, to.y, self.rows)?])
    }

    /// Height of the topmost material at a cell's centre (mm); none where there is none, or no such cell. In
    /// openings that the material encloses it is that of the underside.
    pub fn height(&self, cell: usize) -> Option<f64> {
        self.heights.get(cell).filter(|h| h.is_finite()).map(|&h| self.base + f64::from(h))
    }

    /// The point of the surface at a cell's centre (mm); none where there is no material, or no such cell.
    pub fn surface_point(&self, cell: usize) -> Option<DVec3> {
        self.height(cell).map(|z| self.center(cell).extend(z))
    }

    /// Field whose openings through the material end `beyond` the underside (mm).
    fn opened_below(&self, beyond: f32) -> Self {
        let mut lowered = self.clone();
        self.through.iter().for_each(|cell| lowered.heights[*cell as usize] -= beyond);
        lowered
    }

    /// The point of the surface at a cell's centre, whose height is given above the base.
    fn point(&self, cell: usize, height: f32) -> DVec3 {
        self.center(cell).extend(self.base + f64::from(height))
    }
}

/// Refuses a grid of `columns` by `rows` of side `step` (mm) if it is too large.
fn check_size(step: f64, columns: f64, rows: f64) -> Result<(), HeightFieldError> {
    let cells = columns * rows;
    if cells <= MOST_CELLS {
        return Ok(());
    }
    let coarser = step * (cells / MOST_CELLS).sqrt() * 1.001;
    Err(HeightFieldError::TooManyCells { step, width: columns * step, depth: rows * step, cells, coarser })
}
