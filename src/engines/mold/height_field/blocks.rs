//! Extremes of a grid over blocks of cells, to see where nothing can change.

use std::ops::Range;

use rayon::prelude::*;

/// Cells along the side of a block.
const BLOCK: usize = 8;

/// A grid of values with the extremes of each block; outside it is minus infinity.
pub(super) struct Source<'a> {
    pub values: &'a [f32],
    pub columns: usize,
    pub rows: usize,
    blocks_across: usize,
    least: Vec<f32>,
    greatest: Vec<f32>,
}

impl<'a> Source<'a> {
    pub fn new(values: &'a [f32], columns: usize) -> Self {
        let (rows, blocks_across) = (values.len() / columns, columns.div_ceil(BLOCK));
        let extremes: Vec<[f32; 2]> = values
            .par_chunks(BLOCK * columns)
            .flat_map_iter(|band| (0..blocks_across).map(move |block| Self::extremes(band, columns, block)))
            .collect();
        let [least, greatest] = [0, 1].map(|i| extremes.iter().map(|e| e[i]).collect());
        Self { values, columns, rows, blocks_across, least, greatest }
    }

    fn extremes(band: &[f32], columns: usize, block: usize) -> [f32; 2] {
        let mut found = [f32::INFINITY, f32::NEG_INFINITY];
        for row in band.chunks(columns) {
            for &value in &row[block * BLOCK..columns.min((block + 1) * BLOCK)] {
                found = [lesser(found[0], value), greater(found[1], value)];
            }
        }
        found
    }

    /// No value in these rows and columns is greater.
    pub fn greatest(&self, rows: Range<isize>, columns: Range<isize>) -> f32 {
        self.fold(&self.greatest, &rows, &columns, f32::NEG_INFINITY, greater)
    }

    /// The value that all cells in these rows and columns have, if the blocks around them show it.
    pub fn constant(&self, rows: Range<isize>, columns: Range<isize>) -> Option<f32> {
        let inside = rows.start >= 0
            && columns.start >= 0
            && rows.end <= self.rows as isize
            && columns.end <= self.columns as isize;
        if !inside {
            let greatest = self.greatest(rows, columns);
            return (greatest == f32::NEG_INFINITY).then_some(greatest);
        }
        let least = self.fold(&self.least, &rows, &columns, f32::INFINITY, lesser);
        (self.greatest(rows, columns) == least).then_some(least)
    }

    fn fold(&self, of: &[f32], rows: &Range<isize>, columns: &Range<isize>, start: f32, f: fn(f32, f32) -> f32) -> f32 {
        let within = |range: &Range<isize>, end: usize| {
            let (first, last) = (range.start.max(0) as usize, range.end.clamp(0, end as isize) as usize);
            if first < last { first / BLOCK..(last - 1) / BLOCK + 1 } else { 0..0 }
        };
        let (rows, columns) = (within(rows, self.rows), within(columns, self.columns));
        rows.flat_map(|row| &of[row * self.blocks_across + columns.start..row * self.blocks_across + columns.end])
            .fold(start, |found, &value| f(found, value))
    }

    /// Copies a stretch of a row, from any column on, and adds `offset`.
    pub fn copy_row(&self, row: isize, column: isize, offset: f32, into: &mut [f32]) {
        let (width, columns) = (into.len() as isize, self.columns as isize);
        let (from, to) = ((-column).clamp(0, width), (columns - column).clamp(0, width));
        if row < 0 || row >= self.rows as isize || from >= to {
            return into.fill(f32::NEG_INFINITY);
        }
        let start = row as usize * self.columns;
        let values = &self.values[start + (column + from) as usize..start + (column + to) as usize];
        into[..from as usize].fill(f32::NEG_INFINITY);
        into[to as usize..].fill(f32::NEG_INFINITY);
        into[from as usize..to as usize].iter_mut().zip(values).for_each(|(to, &value)| *to = value + offset);
    }
}

/// The greater of two numbers. Unlike `f32::max` it may give either if one is not a number, and so is one instruction.
pub(super) fn greater(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

/// The lesser of two numbers, with the same freedom.
pub(super) fn lesser(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}
