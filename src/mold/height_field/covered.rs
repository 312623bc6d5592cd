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

/// What is left over a cell.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Left {
    /// The region it belongs to: its place in the list.
    pub region: usize,
    /// From the material (mm).
    pub low: f64,
    /// To the surface that the cutters leave (mm).
    pub high: f64,
}

/// What is left over a rectangle of cells.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Cover {
    /// Nothing.
    Nothing,
    /// Some of it, or several regions.
    Partly,
    /// One region over every cell; the height of what is left is nowhere less than `least` (mm).
    #[allow(missing_docs)]
    Wholly { region: usize, least: f64 },
}

/// Where the regions of a grid lie.
#[derive(Debug, Clone)]
pub struct Covered<'a> {
    field: &'a HeightField,
    closing: &'a Closing,
    /// The region of each cell.
    regions: Vec<u32>,
    /// The same for blocks of cells, with the least height of what is left.
    blocks: Vec<(u32, f32)>,
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

    /// What is left over the cell in which a place of the plan lies; none where nothing is, or off the grid.
    pub fn at(&self, place: DVec2) -> Option<Left> {
        let at = (place - self.field.corner) / self.field.step;
        let is_on = at.x >= 0.0 && at.y >= 0.0 && at.x < self.field.columns as f64 && at.y < self.field.rows as f64;
        let cell = is_on.then(|| at.y as usize * self.field.columns + at.x as usize)?;
        let height = |of: &[f32]| self.field.base + f64::from(of[cell]);
        let (low, high) = (height(&self.field.heights), height(&self.closing.heights));
        (self.regions[cell] != NONE).then(|| Left { region: self.regions[cell] as usize, low, high })
    }

    /// What is left over the cells between two corners of a rectangle in plan (mm).
    pub fn over(&self, low: DVec2, high: DVec2) -> Cover {
        let [from, to] = [low, high].map(|p| (p - self.field.corner) / self.field.step);
        let size = DVec2::new(self.field.columns as f64, self.field.rows as f64);
        if to.cmplt(DVec2::ZERO).any() || from.cmpge(size).any() {
            return Cover::Nothing;
        }
        let [from, to] = [from, to].map(|p| p.clamp(DVec2::ZERO, size - 1.0));
        let (columns, rows) = (from.x as usize..=to.x as usize, from.y as usize..=to.y as usize);
        let is_wide = |range: &RangeInclusive<usize>| range.end() - range.start() > 2 * BLOCK;
        let (region, least) = if is_wide(&columns) || is_wide(&rows) {
            let in_blocks = |range: RangeInclusive<usize>| range.start() / BLOCK..=range.end() / BLOCK;
            let columns = in_blocks(columns);
            let blocks = in_blocks(rows).flat_map(|row| columns.clone().map(move |column| (row, column)));
            joined(blocks.map(|(row, column)| self.blocks[row * self.block_columns + column]))
        } else {
            summary(self.field, self.closing, &self.regions, columns, rows)
        };
        match region {
            NONE => Cover::Nothing,
            SEVERAL => Cover::Partly,
            region => Cover::Wholly { region: region as usize, least: self.field.base + f64::from(least) },
        }
    }
}

/// The region over a rectangle of cells and the least height of what is left.
fn summary(
    field: &HeightField,
    closing: &Closing,
    regions: &[u32],
    columns: RangeInclusive<usize>,
    rows: RangeInclusive<usize>,
) -> (u32, f32) {
    let cells = rows.flat_map(|row| columns.clone().map(move |column| row * field.columns + column));
    joined(cells.map(|cell| (regions[cell], closing.heights[cell])))
}

fn joined(mut parts: impl Iterator<Item = (u32, f32)>) -> (u32, f32) {
    let first = parts.next().unwrap_or((NONE, f32::INFINITY));
    let both = |a: (u32, f32), b: (u32, f32)| {
        let region = if a.0 == b.0 { a.0 } else { SEVERAL };
        // Once parts differ the rest says no more.
        if region == SEVERAL { Err((SEVERAL, f32::NEG_INFINITY)) } else { Ok((region, a.1.min(b.1))) }
    };
    parts.try_fold(first, both).unwrap_or_else(|several| several)
}
