//! Connected regions of residual stock.

use glam::DVec3;

use super::{Closing, HeightField, HeightFieldError, UPNESS_ONE};
use geometry::groups::Groups;
use geometry::mesh::Bounds;
use task::Cancel;

/// A connected piece of uncut material.
#[derive(Debug, Clone, PartialEq)]
pub struct FieldRegion {
    /// Cells, in order.
    pub cells: Vec<u32>,
    /// Area in plan (mm^2).
    pub plan_area: f64,
    /// Volume (mm^3).
    pub volume: f64,
    /// Greatest height of what is left above the material (mm).
    pub depth: f64,
    /// Greatest depth along the surface's normal (mm).
    pub normal_depth: f64,
    /// Where that is, on the material.
    pub thickest: DVec3,
    /// Box around it.
    pub bounds: Bounds,
    /// The cutter of the library that comes nearest in most of its cells.
    pub nearest_cutter: usize,
}

/// The pieces of what is left that are deeper than `tolerance` (mm) along the surface's normal, the largest first.
///
/// Cells are joined with their eight neighbours where what is left overlaps in height. A piece that nowhere covers a
/// square of three cells is the raggedness of the grid along a wall, and left out.
///
/// # Errors
/// [`HeightFieldError::OtherGrid`], [`HeightFieldError::Cancelled`].
pub fn regions(
    field: &HeightField,
    closing: &Closing,
    tolerance: f64,
    cancel: &Cancel,
) -> Result<Vec<FieldRegion>, HeightFieldError> {
    let (expected, found) = (field.heights.len(), closing.heights.len());
    if expected != found {
        return Err(HeightFieldError::OtherGrid { expected, found });
    }
    let pieces = Pieces::of(field, closing, tolerance, cancel)?;
    let mut regions: Vec<FieldRegion> =
        pieces.cells().into_iter().map(|cells| measured(field, closing, cells)).collect();
    let place = |r: &FieldRegion| r.bounds.min;
    regions.sort_by(|a, b| {
        let by_volume = b.volume.total_cmp(&a.volume);
        by_volume.then(place(a).x.total_cmp(&place(b).x)).then(place(a).y.total_cmp(&place(b).y))
    });
    Ok(regions)
}

/// Uncut cells with the piece that each belongs to.
struct Pieces<'a> {
    field: &'a HeightField,
    closing: &'a Closing,
    /// Numbers, in order.
    cells: Vec<u32>,
    /// Where the cells of each row begin.
    rows: Vec<usize>,
    /// Connected groups of the cells.
    groups: Groups,
}

impl<'a> Pieces<'a> {
    fn of(
        field: &'a HeightField,
        closing: &'a Closing,
        tolerance: f64,
        cancel: &Cancel,
    ) -> Result<Self, HeightFieldError> {
        let mut pieces = Self { field, closing, cells: Vec::new(), rows: vec![0], groups: Groups::of(0) };
        for row in 0..field.rows {
            cancel.check()?;
            let cells = row * field.columns..(row + 1) * field.columns;
            pieces
                .cells
                .extend(cells.filter(|&i| normal_residue(field, closing.heights[i], i) > tolerance).map(|i| i as u32));
            pieces.rows.push(pieces.cells.len());
        }
        pieces.groups = Groups::of(pieces.cells.len());
        for row in 0..field.rows {
            cancel.check()?;
            pieces.join_row(row);
        }
        Ok(pieces)
    }

    /// Joins the cells of a row with one another and with those of the row before.
    fn join_row(&mut self, row: usize) {
        let columns = self.field.columns as u32;
        let own = self.rows[row]..self.rows[row + 1];
        let before = if row == 0 { 0..0 } else { self.rows[row - 1]..self.rows[row] };
        let mut first = before.start;
        for i in own.clone() {
            let cell = self.cells[i];
            if i > own.start && self.cells[i - 1] + 1 == cell {
                self.join(i - 1, i);
            }
            // Numbers one row up, with one more on either side; rows are told apart by where they begin.
            while first < before.end && self.cells[first] + columns + 1 < cell {
                first += 1;
            }
            let mut other = first;
            while other < before.end && self.cells[other] + columns <= cell + 1 {
                self.join(other, i);
                other += 1;
            }
        }
    }

    /// Makes two cells one piece if what is left of them overlaps in height.
    fn join(&mut self, a: usize, b: usize) {
        let span = |i: usize| {
            let cell = self.cells[i] as usize;
            (self.field.heights[cell], self.closing.heights[cell])
        };
        let ((low, high), (other_low, other_high)) = (span(a), span(b));
        if low <= other_high && other_low <= high {
            self.groups.join(a, b);
        }
    }

    /// The cells of every piece that covers a square of three cells.
    fn cells(mut self) -> Vec<Vec<u32>> {
        let (numbers, count) = std::mem::replace(&mut self.groups, Groups::of(0)).numbers();
        let mut pieces: Vec<(bool, Vec<u32>)> = vec![(false, Vec::new()); count];
        for (i, number) in numbers.iter().enumerate() {
            let (is_wide, cells) = &mut pieces[*number as usize];
            cells.push(self.cells[i]);
            *is_wide = *is_wide || self.is_inner(i, &numbers);
        }
        pieces.into_iter().filter(|p| p.0).map(|p| p.1).collect()
    }

    /// Whether all eight neighbours belong to the same piece.
    fn is_inner(&self, i: usize, numbers: &[u32]) -> bool {
        let (cell, columns) = (self.cells[i] as usize, self.field.columns);
        let (row, column) = (cell / columns, cell % columns);
        if row == 0 || row + 1 == self.field.rows || column == 0 || column + 1 == columns {
            return false;
        }
        (row - 1..=row + 1).all(|row| {
            let first = (row * columns + column - 1) as u32;
            let start = self.rows[row];
            let at = start + self.cells[start..self.rows[row + 1]].partition_point(|&c| c < first);
            (0..3).all(|k| self.cells.get(at + k) == Some(&(first + k as u32)) && numbers[at + k] == numbers[i])
        })
    }
}

/// Residual stock at a cell up to a height above the base, along the surface's normal (mm).
pub(super) fn normal_residue(field: &HeightField, height: f32, cell: usize) -> f64 {
    let left = height - field.heights[cell];
    // Neither is finite where there is no material.
    if left > 0.0 { f64::from(left) * f64::from(field.upness[cell]) / UPNESS_ONE } else { 0.0 }
}

fn measured(field: &HeightField, closing: &Closing, cells: Vec<u32>) -> FieldRegion {
    let cell_area = field.step * field.step;
    let half = DVec3::new(0.5, 0.5, 0.0) * field.step;
    let mut region = FieldRegion {
        plan_area: cells.len() as f64 * cell_area,
        volume: 0.0,
        depth: 0.0,
        normal_depth: 0.0,
        thickest: DVec3::ZERO,
        bounds: Bounds::EMPTY,
        nearest_cutter: 0,
        cells,
    };
    let mut nearest = [0u32; 256];
    for cell in region.cells.iter().map(|&c| c as usize) {
        let (low, high) = (field.heights[cell], closing.heights[cell]);
        let left = f64::from(high - low);
        region.volume += left * cell_area;
        region.depth = region.depth.max(left);
        let normal_depth = normal_residue(field, high, cell);
        if normal_depth > region.normal_depth {
            (region.normal_depth, region.thickest) = (normal_depth, field.point(cell, low));
        }
        region.bounds.min = region.bounds.min.min(field.point(cell, low) - half);
        region.bounds.max = region.bounds.max.max(field.point(cell, high) + half);
        nearest[usize::from(closing.nearest[cell])] += 1;
    }
    let most = (0..closing.cutters.len()).rev().max_by_key(|&i| nearest[i]);
    region.nearest_cutter = most.map_or(0, |i| closing.cutters[i]);
    region
}

/// The connected pieces of what `more` leaves above what `less` leaves, where that is thicker than `tolerance` (mm)
/// along the normal of the material's surface, the largest first. Both are of `field`.
///
/// # Errors
/// [`HeightFieldError::OtherGrid`], [`HeightFieldError::Cancelled`].
pub fn difference(
    field: &HeightField,
    more: &Closing,
    less: &Closing,
    tolerance: f64,
    cancel: &Cancel,
) -> Result<Vec<FieldRegion>, HeightFieldError> {
    let (expected, found) = (field.heights.len(), less.heights.len());
    if expected != found {
        return Err(HeightFieldError::OtherGrid { expected, found });
    }
    // For this question what both leave is material.
    let filled = HeightField { heights: less.heights.clone(), ..field.clone() };
    regions(&filled, more, tolerance, cancel)
}
