//! Where on the grid which region lies, asked for whole rectangles at once.

use std::ops::RangeInclusive;

use glam::DVec2;
use rayon::prelude::*;

use super::{Closing, FieldRegion, HeightField};

/// Cells along the side of a block.
const BLOCK: usize = 16;
/// The number of no region.
const NONE: u32 = u32::MAX;
/// The number of more than one, or of one that covers a part.
const SEVERAL: u32 = u32::MAX - 1;

/// Residual stock over a cell.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Left {
    /// The region it belongs to: its place in the list.
    pub region: usize,
    /// From the material (mm).
    pub low: f64,
    /// To the surface that the cutters leave (mm).
    pub high: f64,
}

/// Residual stock over a rectangle of cells.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Cover {
    /// No residual stock.
    Nothing,
    /// Some of it, or several regions.
    Partly,
    /// One region over every cell.
    Wholly {
        /// Number of the region.
        region: usize,
        /// Least and greatest height from which on stock is left (mm).
        from: [f64; 2],
        /// Least and greatest height up to which stock is left (mm).
        to: [f64; 2],
    },
}

/// Where the regions of a grid lie.
#[derive(Debug, Clone)]
pub struct Covered<'a> {
    field: &'a HeightField,
    closing: &'a Closing,
    /// The region of each cell.
    regions: Vec<u32>,
    /// Regions of blocks of cells.
    blocks: Vec<Part>,
    block_columns: usize,
}

impl<'a> Covered<'a> {
    /// Where these regions of a field lie.
    pub fn new(field: &'a HeightField, closing: &'a Closing, found: &[FieldRegion]) -> Self {
        let mut regions = vec![NONE; field.heights.len()];
        for (number, region) in found.iter().enumerate() {
            region.cells.iter().for_each(|&cell| regions[cell as usize] = number as u32);
        }
        let block_columns = field.columns.div_ceil(BLOCK);
        let block = |index: usize| {
            let (row, column) = (index / block_columns * BLOCK, index % block_columns * BLOCK);
            let last = |first: usize, count: usize| (first + BLOCK).min(count) - 1;
            summary(field, closing, &regions, column..=last(column, field.columns), row..=last(row, field.rows))
        };
        let blocks = (0..block_columns * field.rows.div_ceil(BLOCK)).into_par_iter().map(block).collect();
        Self { field, closing, regions, blocks, block_columns }
    }

    /// Side of a cell (mm).
    pub fn step(&self) -> f64 {
        self.field.step
    }

    /// Residual stock over the cell in which a place of the plan lies; none where nothing is left, or off the grid.
    pub fn at(&self, place: DVec2) -> Option<Left> {
        let cell = self.cell(place)?;
        let height = |of: &[f32]| self.field.base + f64::from(of[cell]);
        let (low, high) = (height(&self.field.heights), height(&self.closing.heights));
        (self.regions[cell] != NONE).then(|| Left { region: self.regions[cell] as usize, low, high })
    }

    /// Residual stock over the cells between two corners of a rectangle in plan (mm).
    pub fn over(&self, low: DVec2, high: DVec2) -> Cover {
        let [from, to] = [low, high].map(|p| (p - self.field.corner) / self.field.step);
        let size = DVec2::new(self.field.columns as f64, self.field.rows as f64);
        if to.cmplt(DVec2::ZERO).any() || from.cmpge(size).any() {
            return Cover::Nothing;
        }
        let [from, to] = [from, to].map(|p| p.clamp(DVec2::ZERO, size - 1.0));
        let (columns, rows) = (from.x as usize..=to.x as usize, from.y as usize..=to.y as usize);
        let is_wide = |range: &RangeInclusive<usize>| range.end() - range.start() > 2 * BLOCK;
        let part = if is_wide(&columns) || is_wide(&rows) {
            let in_blocks = |range: RangeInclusive<usize>| range.start() / BLOCK..=range.end() / BLOCK;
            let columns = in_blocks(columns);
            let blocks = in_blocks(rows).flat_map(|row| columns.clone().map(move |column| (row, column)));
            joined(blocks.map(|(row, column)| self.blocks[row * self.block_columns + column]))
        } else {
            summary(self.field, self.closing, &self.regions, columns, rows)
        };
        self.cover(part)
    }

    /// Residual stock over the cells along a line in plan (mm).
    pub fn along(&self, from: DVec2, to: DVec2) -> Cover {
        let steps = (2.0 * from.distance(to) / self.field.step).ceil().max(1.0);
        let places = (0..=steps as usize).map(|k| from.lerp(to, k as f64 / steps));
        self.cover(joined(places.map(|place| self.cell(place).map_or(Part::NOTHING, |cell| self.part(cell)))))
    }

    fn cover(&self, part: Part) -> Cover {
        let height = |above: f32| self.field.base + f64::from(above);
        match part.region {
            NONE => Cover::Nothing,
            SEVERAL => Cover::Partly,
            region => Cover::Wholly { region: region as usize, from: part.from.map(height), to: part.to.map(height) },
        }
    }

    /// The cell in which a place of the plan lies; none off the grid.
    fn cell(&self, place: DVec2) -> Option<usize> {
        let at = (place - self.field.corner) / self.field.step;
        let is_on = at.x >= 0.0 && at.y >= 0.0 && at.x < self.field.columns as f64 && at.y < self.field.rows as f64;
        is_on.then(|| at.y as usize * self.field.columns + at.x as usize)
    }

    fn part(&self, cell: usize) -> Part {
        part(self.field, self.closing, &self.regions, cell)
    }
}

/// A part of the grid: its region, the least and the greatest height from which on and up to which it is left.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Part {
    region: u32,
    from: [f32; 2],
    to: [f32; 2],
}

impl Part {
    const NOTHING: Self = Self { region: NONE, from: [0.0; 2], to: [0.0; 2] };
}

fn part(field: &HeightField, closing: &Closing, regions: &[u32], cell: usize) -> Part {
    Part { region: regions[cell], from: [field.heights[cell]; 2], to: [closing.heights[cell]; 2] }
}

/// A rectangle of cells as one part.
fn summary(
    field: &HeightField,
    closing: &Closing,
    regions: &[u32],
    columns: RangeInclusive<usize>,
    rows: RangeInclusive<usize>,
) -> Part {
    let cells = rows.flat_map(|row| columns.clone().map(move |column| row * field.columns + column));
    joined(cells.map(|cell| part(field, closing, regions, cell)))
}

fn joined(mut parts: impl Iterator<Item = Part>) -> Part {
    let first = parts.next().unwrap_or(Part::NOTHING);
    let both = |a: Part, b: Part| {
        // Once parts differ the rest says no more.
        if a.region != b.region || a.region == SEVERAL {
            return Err(Part { region: SEVERAL, ..Part::NOTHING });
        }
        let span = |a: [f32; 2], b: [f32; 2]| [a[0].min(b[0]), a[1].max(b[1])];
        Ok(Part { region: a.region, from: span(a.from, b.from), to: span(a.to, b.to) })
    };
    parts.try_fold(first, both).unwrap_or_else(|several| several)
}
