//! The least surface that a library of cutters leaves.

use files::Validate;
use glam::DVec2;
use rayon::prelude::*;

use super::blocks::{Source, greater};
use super::element::Element;
use super::sweep::{TILE_COLUMNS, TILE_ROWS, Tile};
use super::{HeightField, HeightFieldError, check_size};
use crate::cutter::{Cutter, CutterKind, CutterLibrary};
use task::{Cancel, Cancelled};

/// Height above the material up to which a cell counts as cut (mm): rounding of heights.
const CLEAN: f32 = 1e-5;

/// By how much of a cell a cutter that comes down is taken for thinner than it is.
///
/// Centres of cells are a coarse picture of a wall, and places of the tip of where it can stand. Along the grid's axes
/// the errors cancel; across them they would leave too much in corners, which this evens out on average (measured over
/// pockets at all angles).
fn trim(kind: CutterKind) -> f64 {
    match kind {
        CutterKind::Flat => 0.25,
        // The rim of a rounded edge rises steeply and meets walls only.
        CutterKind::Ball | CutterKind::BullNose => 0.15,
    }
}

/// Residual stock of all cutters together.
#[derive(Debug, Clone, PartialEq)]
pub struct Closing {
    /// Height above the field's base of what is left (mm), cell by cell; at least the material's.
    pub(super) heights: Vec<f32>,
    /// For each cell which of `cutters` leaves least.
    pub(super) nearest: Vec<u8>,
    /// Cutters of the library that were used.
    pub(super) cutters: Vec<usize>,
}

impl Closing {
    /// How much is left above the material of `field` at a cell (mm), up to rounding; nothing where there is no
    /// material.
    pub fn residue(&self, field: &HeightField, cell: usize) -> f64 {
        let left = self.heights.get(cell).zip(field.heights.get(cell)).map(|(left, height)| left - height);
        left.filter(|left| left.is_finite()).map_or(0.0, f64::from)
    }

    /// Lowers what is left at a cell of `field` to a height (mm), but not below the material.
    pub fn lower(&mut self, field: &HeightField, cell: usize, height: f64) {
        if let Some((left, material)) = self.heights.get_mut(cell).zip(field.heights.get(cell)) {
            *left = left.min(((height - field.base) as f32).max(*material));
        }
    }

    /// Raises what is left at a cell of `field` to a height (mm), but not above what was left `before`.
    pub fn raise(&mut self, field: &HeightField, cell: usize, height: f64, before: &Closing) {
        let Some((left, most)) = self.heights.get_mut(cell).zip(before.heights.get(cell)) else { return };
        let height = (height - field.base) as f32;
        *left = left.max(height.min(*most));
        // What was left before is due to the cutter of then.
        if *most <= height {
            self.nearest[cell] = before.nearest[cell];
        }
    }

    /// Best cutter of the library for a cell, the one that leaves least; the first among equals, none if there is no
    /// such cell.
    pub fn nearest(&self, cell: usize) -> Option<usize> {
        self.nearest.get(cell).and_then(|&number| self.cutters.get(usize::from(number))).copied()
    }
}

/// Residual stock of the cutters of `library` above `field`, wherever they go.
///
/// # Errors
/// [`HeightFieldError::Cutter`], [`HeightFieldError::TooManyCells`] with the room that a cutter needs beside the mold,
/// [`HeightFieldError::Cancelled`].
pub fn closing(field: &HeightField, library: &CutterLibrary, cancel: &Cancel) -> Result<Closing, HeightFieldError> {
    closing_of(field, library, |_| true, None, cancel)
}

/// Correction of what the grid leaves of a field after one cutter of a library, from what was left before that cutter.
pub type Correction<'a> = &'a dyn Fn(&Cutter, &Closing, &mut Closing);

/// Residual stock of the cutters of `library` above `field`, with a correction after each cutter.
///
/// # Errors
/// [`HeightFieldError`], as of [`closing`].
pub fn closing_corrected(
    field: &HeightField,
    library: &CutterLibrary,
    correction: Correction,
    cancel: &Cancel,
) -> Result<Closing, HeightFieldError> {
    closing_of(field, library, |_| true, Some(correction), cancel)
}

/// Residual stock of the cutters of `library` on the cells of `field` within a rectangle in plan (mm); elsewhere
/// nothing is left.
///
/// # Errors
/// [`HeightFieldError`], as of [`closing`].
pub fn closing_within(
    field: &HeightField,
    library: &CutterLibrary,
    [low, high]: [DVec2; 2],
    cancel: &Cancel,
) -> Result<Closing, HeightFieldError> {
    let is_within = |cell: usize| {
        let place = field.center(cell);
        place.cmpge(low).all() && place.cmple(high).all()
    };
    closing_of(field, library, is_within, None, cancel)
}

fn closing_of(
    field: &HeightField,
    library: &CutterLibrary,
    is_asked: impl Fn(usize) -> bool + Sync,
    correction: Option<Correction>,
    cancel: &Cancel,
) -> Result<Closing, HeightFieldError> {
    library.validate()?;
    let needed = library.needed();
    let cutters = (0..library.cutter.len()).filter(|&i| needed.iter().any(|c| std::ptr::eq(*c, &library.cutter[i])));
    let above = |(cell, &height): (usize, &f32)| {
        if height.is_finite() && is_asked(cell) { f32::INFINITY } else { height }
    };
    let mut closing = Closing {
        heights: field.heights.par_iter().enumerate().map(above).collect(),
        nearest: vec![0; field.heights.len()],
        cutters: cutters.collect(),
    };
    let lowered = lowered_for(field, &needed);
    for (number, cutter) in needed.into_iter().enumerate() {
        let before = correction.map(|correction| (correction, closing.clone()));
        Passes::new(lowered.as_ref().unwrap_or(field), cutter)?.lower(&mut closing, number as u8, cancel)?;
        if let Some((correction, before)) = before {
            correction(cutter, &before, &mut closing);
        }
    }
    if lowered.is_some() {
        closing.heights.par_iter_mut().zip(&field.heights).for_each(|(left, height)| *left = greater(*left, *height));
    }
    Ok(closing)
}

/// The field as `cutters` meet it; none where that is the field itself. Below the underside nothing stops a cutter: a
/// rounded one goes on until its full width is through.
pub(super) fn lowered_for(field: &HeightField, cutters: &[&Cutter]) -> Option<HeightField> {
    let beyond = cutters.iter().map(|cutter| cutter.corner_mm).fold(0.0, f64::max) as f32;
    (!field.through.is_empty() && beyond > 0.0).then(|| field.opened_below(beyond))
}

/// One cutter over a field.
pub(super) struct Passes<'a> {
    pub field: &'a HeightField,
    pub cutter: &'a Cutter,
    /// How far the places of the tip lie before the cells' centres, as a share of a cell.
    pub offset: [f64; 2],
    /// The cutter's surface around a place of the tip, over cells.
    pub down: Element,
    /// The cutter's surface around a cell, over places of the tip.
    pub up: Element,
    /// Columns and rows of places of the tip.
    pub columns: usize,
    pub rows: usize,
}

impl<'a> Passes<'a> {
    pub fn new(field: &'a HeightField, cutter: &'a Cutter) -> Result<Self, HeightFieldError> {
        let radius = cutter.radius() / field.step;
        let room = 2.0 * radius + 2.0;
        check_size(field.step, field.columns as f64 + room, field.rows as f64 + room)?;
        let across = (2.0 * radius).round();
        // As wide in cells as in truth: an even width is centred between cells, an odd one on a cell.
        let offset = [if across > 2.0 && across % 2.0 == 0.0 { 0.5 } else { 0.0 }; 2];
        // Less than a cell off, so that along the grid's axes it stays as wide.
        let trimmed = (radius - trim(cutter.kind())).max(0.5 * across - 0.5);
        let down = Element::of(cutter, trimmed * field.step, field.step, offset);
        let up = Element::of(cutter, cutter.radius(), field.step, offset.map(|o| -o));
        let more = |span: [isize; 2]| (span[1] - span[0]) as usize;
        let (columns, rows) = (field.columns + more(up.columns), field.rows + more(up.rows));
        Ok(Self { field, cutter, offset, down, up, columns, rows })
    }

    /// Lowers what is left to what this cutter leaves.
    fn lower(&self, closing: &mut Closing, number: u8, cancel: &Cancel) -> Result<(), Cancelled> {
        let open = self.open_tiles(&closing.heights);
        let tips = self.negated_tips(&open, cancel)?;
        let tips = Source::new(&tips, self.columns);
        let columns = self.field.columns;
        let left = closing.heights.par_chunks_mut(TILE_ROWS * columns);
        let bands = left.zip(closing.nearest.par_chunks_mut(TILE_ROWS * columns)).enumerate();
        bands.try_for_each_init(Tile::new, |tile, (band, (left, nearest))| {
            for (across, _) in open[band].iter().enumerate().filter(|(_, open)| **open) {
                cancel.check()?;
                self.start_tile(tile, band, across, left);
                tile.raise(&tips, &self.up, [-self.up.rows[0], -self.up.columns[0]]);
                for_each_place(tile, columns, left, |i, best, left| {
                    let height = greater(-best, self.field.heights[band * TILE_ROWS * columns + i]);
                    if height < *left {
                        (*left, nearest[i]) = (height, number);
                    }
                });
            }
            Ok(())
        })
    }

    /// Whether each tile of cells holds one that is not clean.
    fn open_tiles(&self, left: &[f32]) -> Vec<Vec<bool>> {
        let columns = self.field.columns;
        let bands = left.par_chunks(TILE_ROWS * columns).zip(self.field.heights.par_chunks(TILE_ROWS * columns));
        bands
            .map(|(left, heights)| {
                let mut open = vec![false; columns.div_ceil(TILE_COLUMNS)];
                for (left, heights) in left.chunks(columns).zip(heights.chunks(columns)) {
                    for (i, (left, heights)) in left.chunks(TILE_COLUMNS).zip(heights.chunks(TILE_COLUMNS)).enumerate()
                    {
                        open[i] |= left.iter().zip(heights).any(|(&left, &height)| left > height + CLEAN);
                    }
                }
                open
            })
            .collect()
    }

    /// Sets a tile to the cells of a band, negated as their tips are.
    fn start_tile(&self, tile: &mut Tile, band: usize, across: usize, left: &[f32]) {
        let columns = self.field.columns;
        tile.reset(band * TILE_ROWS, across * TILE_COLUMNS);
        tile.enough.fill(f32::NEG_INFINITY);
        let first = tile.column;
        let width = TILE_COLUMNS.min(columns - first);
        for (i, left) in left.chunks(columns).enumerate() {
            let cells = (tile.row + i) * columns + first..(tile.row + i) * columns + first + width;
            let places = i * TILE_COLUMNS..i * TILE_COLUMNS + width;
            tile.best[places.clone()].iter_mut().zip(&left[first..]).for_each(|(best, left)| *best = -left);
            let heights = &self.field.heights[cells];
            tile.enough[places].iter_mut().zip(heights).for_each(|(enough, height)| *enough = -(height + CLEAN));
        }
    }

    /// How far down the tip comes at every place from which it reaches an open tile, negated; minus infinity elsewhere.
    fn negated_tips(&self, open: &[Vec<bool>], cancel: &Cancel) -> Result<Vec<f32>, Cancelled> {
        let heights = Source::new(&self.field.heights, self.field.columns);
        let holder = self.cutter.holder().map(|(radius, reach)| {
            (Element::of(&Cutter::flat(radius), radius, self.field.step, self.offset), -reach as f32)
        });
        let mut tips = vec![f32::NEG_INFINITY; self.columns * self.rows];
        let columns = self.columns;
        tips.par_chunks_mut(TILE_ROWS * columns).enumerate().try_for_each_init(Tile::new, |tile, (band, tips)| {
            for across in 0..columns.div_ceil(TILE_COLUMNS) {
                cancel.check()?;
                if !self.reaches(open, band, across) {
                    continue;
                }
                tile.reset(band * TILE_ROWS, across * TILE_COLUMNS);
                let shift = [self.up.rows[0], self.up.columns[0]];
                tile.raise(&heights, &self.down, shift);
                if let Some((holder, lower)) = &holder {
                    tile.raise_level(&heights, &holder.chords, shift, *lower);
                }
                for_each_place(tile, columns, tips, |_, best, tip| *tip = -best);
            }
            Ok(())
        })?;
        Ok(tips)
    }

    /// Whether the cutter reaches an open tile from a tile of places.
    fn reaches(&self, open: &[Vec<bool>], band: usize, across: usize) -> bool {
        // A cell's places begin at its own number and are as many as the cutter is wide.
        let [high, wide] = [self.up.rows, self.up.columns].map(|span| (span[1] - span[0]) as usize);
        let bands = (band * TILE_ROWS).saturating_sub(high) / TILE_ROWS..=band;
        let acrosses = (across * TILE_COLUMNS).saturating_sub(wide) / TILE_COLUMNS..=across;
        open.iter().enumerate().any(|(i, row)| {
            bands.contains(&i) && row.iter().enumerate().any(|(j, &open)| open && acrosses.contains(&j))
        })
    }
}

/// Calls `f` with the number within the band, the tile's value and the band's value of every place of a tile within a
/// band of rows that is `columns` wide.
fn for_each_place(tile: &Tile, columns: usize, band: &mut [f32], mut f: impl FnMut(usize, f32, &mut f32)) {
    for (row, (places, values)) in tile.best.chunks(TILE_COLUMNS).zip(band.chunks_mut(columns)).enumerate() {
        for (i, (&best, value)) in places.iter().zip(&mut values[tile.column..]).enumerate() {
            f(row * columns + tile.column + i, best, value);
        }
    }
}
