//! The greatest value under a cutter's surface, for a tile of places at once.
//!
//! With values v and a surface of height s this is max over the surface of v - s. Discs are rows of range maxima, each
//! of two overlapping ranges whose length is a power of two. Rising surfaces are gone through in patches. In both, what
//! cannot exceed the least value found so far is passed over: over level ground that is nearly everything.

use std::ops::Range;

use super::blocks::{Source, greater, lesser};
use super::element::{Chord, Element, PATCH, Patch};

/// Places along y and x of a tile.
pub(super) const TILE_ROWS: usize = 64;
pub(super) const TILE_COLUMNS: usize = 128;
/// Rows of values that are looked at together.
const ROWS_TOGETHER: isize = 16;
/// Places along y and x that go through the patches together.
const GROUP_ROWS: usize = 8;
const GROUP_COLUMNS: usize = 32;
/// Values along y and x that they reach in one patch.
const REACH_ROWS: usize = GROUP_ROWS + PATCH - 1;
const REACH_COLUMNS: usize = GROUP_COLUMNS + PATCH - 1;

/// The places of a tile.
pub(super) struct Tile {
    /// First row and column among the places.
    pub row: usize,
    pub column: usize,
    /// The greatest values so far, row by row.
    pub best: Vec<f32>,
    /// From where on a greater value makes no difference; minus infinity for places that do not matter.
    pub enough: Vec<f32>,
    levels: Vec<f32>,
}

impl Tile {
    pub fn new() -> Self {
        let [best, enough] = [f32::NEG_INFINITY, f32::INFINITY].map(|v| vec![v; TILE_ROWS * TILE_COLUMNS]);
        Self { row: 0, column: 0, best, enough, levels: Vec::new() }
    }

    /// Goes to another place, where nothing is known yet.
    pub fn reset(&mut self, row: usize, column: usize) {
        (self.row, self.column) = (row, column);
        self.best.fill(f32::NEG_INFINITY);
        self.enough.fill(f32::INFINITY);
    }

    /// Raises the places to `values` under `element`, whose point 0 lies over the value `shift` rows and columns on.
    pub fn raise(&mut self, values: &Source, element: &Element, shift: [isize; 2]) {
        let rows = reached(self.row as isize + shift[0], TILE_ROWS, element.rows);
        let columns = reached(self.column as isize + shift[1], TILE_COLUMNS, element.columns);
        if element.patches.is_empty()
            && let Some(value) = values.constant(rows, columns)
        {
            return self.best.iter_mut().for_each(|best| *best = greater(*best, value));
        }
        self.raise_level(values, &element.chords, shift, 0.0);
        if !element.patches.is_empty() {
            self.raise_patches(values, element, shift);
        }
    }

    /// The least value of a place for which it still matters; infinite if there is none.
    fn least_open(&self) -> f32 {
        self.best.iter().zip(&self.enough).fold(f32::INFINITY, |least, (&best, &enough)| {
            lesser(least, if best < enough { best } else { f32::INFINITY })
        })
    }

    /// Raises the places to the greatest of `values` plus `offset` within a disc.
    pub fn raise_level(&mut self, values: &Source, chords: &[Chord], shift: [isize; 2], offset: f32) {
        let (Some(first), Some(last)) = (chords.first(), chords.last()) else { return };
        let from = chords.iter().map(|c| c.columns[0]).min().unwrap_or(0);
        let to = chords.iter().map(|c| c.columns[1]).max().unwrap_or(0);
        let columns = reached(self.column as isize + shift[1], TILE_COLUMNS, [from, to]);
        let width = (columns.end - columns.start) as usize;
        let depth = ((to - from + 1) as usize).ilog2() as usize + 1;
        self.levels.resize(depth * width, f32::NEG_INFINITY);
        let start = self.row as isize + shift[0];
        let rows = (start + first.row).max(0)..(start + TILE_ROWS as isize + last.row).min(values.rows as isize);
        let mut together: Vec<isize> = (rows.start..rows.end).step_by(ROWS_TOGETHER as usize).collect();
        // The longest chords first: they leave least to do for the others.
        let middle = start + TILE_ROWS as isize / 2;
        together.sort_by_key(|row| (row + ROWS_TOGETHER / 2 - middle).abs());
        let mut open = self.least_open();
        for row in together {
            let block = row..(row + ROWS_TOGETHER).min(rows.end);
            if values.greatest(block.clone(), columns.clone()) + offset <= open {
                continue;
            }
            for row in block {
                values.copy_row(row, columns.start, offset, &mut self.levels[..width]);
                self.fill_levels(width, depth);
                self.raise_by_row(row - start, chords, width, from);
            }
            open = self.least_open();
        }
    }

    /// Makes level n the maxima over 2^n columns to the right.
    fn fill_levels(&mut self, width: usize, depth: usize) {
        for level in 1..depth {
            let (below, rest) = self.levels[(level - 1) * width..].split_at_mut(width);
            let half = 1 << (level - 1);
            for ((to, &a), &b) in rest.iter_mut().zip(&below[..width - half]).zip(&below[half..]) {
                *to = greater(a, b);
            }
        }
    }

    /// Raises all rows of places to the row of values whose maxima are in the levels; `row` counts from the first
    /// place's.
    fn raise_by_row(&mut self, row: isize, chords: &[Chord], width: usize, from: isize) {
        let lowest = chords.first().map_or(0, |c| c.row);
        for (i, best) in self.best.chunks_exact_mut(TILE_COLUMNS).enumerate() {
            let number = row - i as isize - lowest;
            let Some(chord) = usize::try_from(number).ok().and_then(|n| chords.get(n)) else { continue };
            let length = (chord.columns[1] - chord.columns[0] + 1) as usize;
            let level = length.ilog2() as usize;
            let left = level * width + (chord.columns[0] - from) as usize;
            let right = left + length - (1 << level);
            let (left, right) = (&self.levels[left..left + TILE_COLUMNS], &self.levels[right..right + TILE_COLUMNS]);
            for ((best, &a), &b) in best.iter_mut().zip(left).zip(right) {
                *best = greater(*best, greater(a, b));
            }
        }
    }

    fn raise_patches(&mut self, values: &Source, element: &Element, shift: [isize; 2]) {
        for row in (0..TILE_ROWS).step_by(GROUP_ROWS) {
            for column in (0..TILE_COLUMNS).step_by(GROUP_COLUMNS) {
                self.raise_group(values, element, shift, [row, column]);
            }
        }
    }

    fn raise_group(&mut self, values: &Source, element: &Element, shift: [isize; 2], at: [usize; 2]) {
        let (row, column) = ((self.row + at[0]) as isize + shift[0], (self.column + at[1]) as isize + shift[1]);
        let mut open = self.least_open_of(at);
        let most =
            values.greatest(reached(row, GROUP_ROWS, element.rows), reached(column, GROUP_COLUMNS, element.columns));
        let mut near = [[f32::NEG_INFINITY; REACH_COLUMNS]; REACH_ROWS];
        for patch in &element.patches {
            if most - patch.least <= open {
                break;
            }
            let (row, column) = (row + patch.row, column + patch.column);
            let (rows, columns) = (row..row + REACH_ROWS as isize, column..column + REACH_COLUMNS as isize);
            if values.greatest(rows.clone(), columns) - patch.least <= open {
                continue;
            }
            rows.zip(&mut near).for_each(|(row, near)| values.copy_row(row, column, 0.0, near));
            for i in 0..GROUP_ROWS {
                self.raise_group_row(&near, patch, at[0] + i, i, at[1]);
            }
            open = self.least_open_of(at);
        }
    }

    fn raise_group_row(
        &mut self,
        near: &[[f32; REACH_COLUMNS]; REACH_ROWS],
        patch: &Patch,
        row: usize,
        i: usize,
        column: usize,
    ) {
        let Some(best) = self.best[row * TILE_COLUMNS + column..].first_chunk_mut::<GROUP_COLUMNS>() else { return };
        let mut found = *best;
        for &(down, across, height) in &patch.points {
            let Some(values) = near[i + down as usize][across as usize..].first_chunk::<GROUP_COLUMNS>() else {
                return;
            };
            for (found, &value) in found.iter_mut().zip(values) {
                *found = greater(*found, value - height);
            }
        }
        *best = found;
    }

    fn least_open_of(&self, at: [usize; 2]) -> f32 {
        let mut least = [f32::INFINITY; GROUP_COLUMNS];
        for row in at[0]..at[0] + GROUP_ROWS {
            let cells = row * TILE_COLUMNS + at[1]..row * TILE_COLUMNS + at[1] + GROUP_COLUMNS;
            for ((least, &best), &enough) in least.iter_mut().zip(&self.best[cells.clone()]).zip(&self.enough[cells]) {
                *least = lesser(*least, if best < enough { best } else { f32::INFINITY });
            }
        }
        least.into_iter().fold(f32::INFINITY, lesser)
    }
}

/// The values that `many` places from `first` on reach, with offsets from the first to the last of `span`.
fn reached(first: isize, many: usize, span: [isize; 2]) -> Range<isize> {
    first + span[0]..first + many as isize + span[1]
}
