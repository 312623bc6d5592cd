//! What a cutter leaves of a place at most, by the tips alone with which it touches the surface there.
//!
//! Every place of the tip lowers what is left, so that any choice of them tells no less than all do. Where a cutter takes
//! nearly everything, those with which it touches the surface show it, and they are few: of all places of the tip most
//! touch the surface elsewhere.

use std::ops::Range;

use glam::DVec2;
use rayon::prelude::*;

use super::blocks::{Source, greater, lesser};
use super::closing::{Closing, Passes, closing_within, lowered_for};
use super::element::{PATCH, Patch};
use super::regions::normal_residue;
use super::{FieldRegion, HeightField, HeightFieldError, regions};
use crate::cutter::{Cutter, CutterKind, CutterLibrary};
use task::{Cancel, Cancelled};

/// Cells from one place that is touched to the next at first, and then where something is still left.
const SPACINGS: [usize; 2] = [4, 1];
/// Cells that may still be left after the first, in hundredths of all, for the others to be looked at.
const MOST_OPEN: usize = 10;
/// Cells around a place that is touched up to which it is asked what the tip takes.
const AROUND: isize = 8;
/// Normals are level below this share of their length, so that the side on which a flat part stands is not told.
const LEVEL: f64 = 1e-3;

/// The regions that the cutters of `library` leave at most of the cells of `field` within a rectangle in plan (mm): what
/// [`closing_within`] leaves lies in these regions.
///
/// # Errors
/// [`HeightFieldError`], as of [`closing`](super::closing).
pub fn left_at_most(
    field: &HeightField,
    library: &CutterLibrary,
    [low, high]: [DVec2; 2],
    tolerance: f64,
    cancel: &Cancel,
) -> Result<Vec<FieldRegion>, HeightFieldError> {
    // None of the rectangle's cells is lost to rounding.
    let within = [low - 0.5 * field.step, high + 0.5 * field.step];
    let Some(asked) = field.cells_within(within[0], within[1]) else { return Ok(Vec::new()) };
    let is_flat = |cutter: &&Cutter| cutter.kind() == CutterKind::Flat;
    let (flats, mut rounded): (Vec<&Cutter>, Vec<&Cutter>) = library.needed().into_iter().partition(is_flat);
    let mut left = if flats.is_empty() {
        let mut left = field.heights.clone();
        for cell in cells(field, &asked).filter(|cell| field.heights[*cell].is_finite()) {
            left[cell] = f32::INFINITY;
        }
        left
    } else {
        // Of flat cutters all is found at once.
        let flats = CutterLibrary { cutter: flats.into_iter().cloned().collect() };
        closing_within(field, &flats, within, cancel)?.heights
    };
    rounded.sort_by(|a, b| a.radius().total_cmp(&b.radius()));
    for cutter in rounded {
        lower_by_touching(field, cutter, (&mut left, &asked), tolerance, cancel)?;
    }
    let closing = Closing { heights: left, nearest: vec![0; field.heights.len()], cutters: vec![0] };
    regions(field, &closing, tolerance, cancel)
}

/// Cells in these columns and rows.
fn cells<'a>(field: &'a HeightField, [columns, rows]: &'a [Range<usize>; 2]) -> impl Iterator<Item = usize> + use<'a> {
    rows.clone().flat_map(|row| row * field.columns + columns.start..row * field.columns + columns.end)
}

/// Lowers what is left of the cells in these columns and rows to what the tips leave with which a cutter touches them.
fn lower_by_touching(
    field: &HeightField,
    cutter: &Cutter,
    (left, asked): (&mut Vec<f32>, &[Range<usize>; 2]),
    tolerance: f64,
    cancel: &Cancel,
) -> Result<(), HeightFieldError> {
    let lowered = lowered_for(field, &[cutter]);
    let passes = Passes::new(lowered.as_ref().unwrap_or(field), cutter)?;
    let touching = Touching::new(&passes);
    for spacing in SPACINGS {
        let is_open = |cell: &usize| {
            let at = [cell / field.columns, cell % field.columns];
            let is_spaced = at.iter().all(|at| at.is_multiple_of(spacing));
            is_spaced && normal_residue(field, left[*cell], *cell) > tolerance
        };
        let open: Vec<usize> = cells(field, asked).filter(is_open).collect();
        // Where much is still left it is no rounding of the grid: the cutter leaves it.
        if spacing == 1 && open.len() > MOST_OPEN * asked[0].len() * asked[1].len() / 100 {
            break;
        }
        let tips_at = |cell: &usize| {
            cancel.check()?;
            let of = |slope| touching.tip(*cell, slope);
            let slopes = touching.slopes(*cell);
            // Beside a crease there are several.
            Ok(if spacing == 1 { slopes.into_iter().filter_map(of).collect() } else { Vec::from_iter(of(slopes[0])) })
        };
        let tips: Vec<Vec<Tip>> = open.par_iter().map(tips_at).collect::<Result<_, Cancelled>>()?;
        for (cell, tip) in open.iter().zip(&tips).flat_map(|(cell, tips)| tips.iter().map(move |tip| (*cell, tip))) {
            touching.lower(left, tip, cell, asked);
        }
    }
    left.iter_mut().zip(&field.heights).for_each(|(left, height)| *left = greater(*left, *height));
    Ok(())
}

/// A place of the tip and its height above the field's base (mm).
struct Tip {
    row: isize,
    column: isize,
    height: f32,
}

/// Places of the tip of a cutter with which it touches a field.
struct Touching<'a> {
    passes: &'a Passes<'a>,
    heights: Source<'a>,
    /// Height of the highest material above the base (mm).
    highest: f32,
}

impl<'a> Touching<'a> {
    fn new(passes: &'a Passes<'a>) -> Self {
        let field = passes.field;
        let highest = field.heights.iter().copied().fold(f32::NEG_INFINITY, greater);
        Self { passes, heights: Source::new(&field.heights, field.columns), highest }
    }

    /// Rise per length of the surface at a cell: by its neighbours on both sides, and by those on one.
    fn slopes(&self, cell: usize) -> [DVec2; 5] {
        let field = self.passes.field;
        let (row, column) = (cell / field.columns, cell % field.columns);
        let own = field.heights[cell];
        let rise = |other: Option<usize>| {
            let height = other.and_then(|other| field.heights.get(other)).filter(|height| height.is_finite());
            height.map_or(0.0, |height| f64::from(height - own) / field.step)
        };
        let x = [(column > 0).then(|| cell - 1), (column + 1 < field.columns).then_some(cell + 1)].map(rise);
        let y = [(row > 0).then(|| cell - field.columns), Some(cell + field.columns)].map(rise);
        let (x, y) = ([-x[0], x[1]], [-y[0], y[1]]);
        let both = DVec2::new(0.5 * (x[0] + x[1]), 0.5 * (y[0] + y[1]));
        [both, DVec2::new(x[0], y[0]), DVec2::new(x[1], y[0]), DVec2::new(x[0], y[1]), DVec2::new(x[1], y[1])]
    }

    /// The tip of the cutter that touches a cell where the surface rises so; none where the grid does not have it.
    fn tip(&self, cell: usize, slope: DVec2) -> Option<Tip> {
        let Passes { field, cutter, offset, up, .. } = self.passes;
        let across = -slope / slope.length_squared().mul_add(1.0, 1.0).sqrt();
        let flat = cutter.radius() - cutter.corner_mm;
        let side = if across.length() > LEVEL { across.normalize() } else { DVec2::ZERO };
        let axis = (across * cutter.corner_mm + side * flat) / field.step;
        let cell = [cell / field.columns, cell % field.columns].map(|of| of as isize);
        let at = |i: usize, off: f64| cell[i] + (off + offset[i]).round() as isize;
        let under = [at(0, axis.y), at(1, axis.x)];
        let [row, column] = [under[0] - up.rows[0], under[1] - up.columns[0]];
        let is_of_grid =
            (0..self.passes.rows as isize).contains(&row) && (0..self.passes.columns as isize).contains(&column);
        is_of_grid.then(|| Tip { row, column, height: self.height(under, [cell[0] - under[0], cell[1] - under[1]]) })
    }

    /// How far down the tip comes whose surface's point 0 lies over the value at `under`, by the point at `first` before
    /// all others.
    fn height(&self, under: [isize; 2], first: [isize; 2]) -> f32 {
        let Passes { field, cutter, down, .. } = self.passes;
        let mut height = f32::NEG_INFINITY;
        for chord in &down.chords {
            let row = under[0] + chord.row;
            let columns = [under[1] + chord.columns[0], under[1] + chord.columns[1] + 1];
            let [from, to] = columns.map(|column| column.clamp(0, field.columns as isize) as usize);
            if (0..field.rows as isize).contains(&row) {
                let start = row as usize * field.columns;
                height = field.heights[start + from..start + to].iter().copied().fold(height, greater);
            }
        }
        if let Some((radius, reach)) = cutter.holder() {
            // No material under the square around its disc is higher.
            let side = (radius / field.step).ceil() as isize + 1;
            let [rows, columns] = under.map(|middle| middle - side..middle + side + 1);
            height = greater(height, self.heights.greatest(rows, columns) - reach as f32);
        }
        let is_first = |patch: &&Patch| {
            let span = |from: isize| from..from + PATCH as isize;
            span(patch.row).contains(&first[0]) && span(patch.column).contains(&first[1])
        };
        if let Some(patch) = down.patches.iter().find(is_first) {
            height = self.under(patch, under, height);
        }
        for patch in &down.patches {
            if self.highest - patch.least <= height {
                break;
            }
            let span = |from: isize| from..from + PATCH as isize;
            let most = self.heights.greatest(span(under[0] + patch.row), span(under[1] + patch.column));
            if most - patch.least > height {
                height = self.under(patch, under, height);
            }
        }
        height
    }

    /// The tip's height as a patch of the cutter's surface has it, or `height` if that is greater.
    fn under(&self, patch: &Patch, under: [isize; 2], height: f32) -> f32 {
        let field = self.passes.field;
        let (rows, columns) = (field.rows as isize, field.columns as isize);
        let [row, column] = [under[0] + patch.row, under[1] + patch.column];
        let last = PATCH as isize - 1;
        if row >= 0 && column >= 0 && row + last < rows && column + last < columns {
            let values = &field.heights[row as usize * field.columns + column as usize..];
            let value = |&(down, across, rise): &(u8, u8, f32)| {
                values[usize::from(down) * field.columns + usize::from(across)] - rise
            };
            return patch.points.iter().map(value).fold(height, greater);
        }
        let value = |&(down, across, rise): &(u8, u8, f32)| {
            let [row, column] = [row + down as isize, column + across as isize];
            let is_on = (0..rows).contains(&row) && (0..columns).contains(&column);
            is_on.then(|| field.heights[row as usize * field.columns + column as usize] - rise)
        };
        patch.points.iter().filter_map(value).fold(height, greater)
    }

    /// Lowers what is left of the cells around one, within rows and columns, to what the tip there leaves.
    fn lower(&self, left: &mut [f32], tip: &Tip, cell: usize, [columns, rows]: &[Range<usize>; 2]) {
        let Passes { field, up, .. } = self.passes;
        let near = |at: usize, asked: &Range<usize>| {
            let at = at as isize;
            (at - AROUND).max(asked.start as isize)..(at + AROUND + 1).min(asked.end as isize)
        };
        let (rows, columns) = (near(cell / field.columns, rows), near(cell % field.columns, columns));
        // The cell whose surface's point 0 is the tip.
        let [row, column] = [tip.row + up.rows[0], tip.column + up.columns[0]];
        let mut lower = |at: isize, over: isize, rise: f32| {
            let left = &mut left[at as usize * field.columns + over as usize];
            *left = lesser(*left, tip.height + rise);
        };
        for chord in up.chords.iter().filter(|chord| rows.contains(&(row - chord.row))) {
            let [from, to] = [column - chord.columns[1], column - chord.columns[0] + 1];
            (from.max(columns.start)..to.min(columns.end)).for_each(|over| lower(row - chord.row, over, 0.0));
        }
        let last = PATCH as isize - 1;
        let meets = |from: isize, range: &Range<isize>| from >= range.start && from - last < range.end;
        let is_near = |patch: &&Patch| meets(row - patch.row, &rows) && meets(column - patch.column, &columns);
        for patch in up.patches.iter().filter(is_near) {
            for &(down, across, rise) in &patch.points {
                let [at, over] = [row - patch.row - down as isize, column - patch.column - across as isize];
                if rows.contains(&at) && columns.contains(&over) {
                    lower(at, over, rise);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixtures::{dish, frame, polygon, rectangle};
    use geometry::mesh::Mesh;

    const TOLERANCE: f64 = 0.02;

    /// Cells that the cutter leaves of a rectangle, as all places of the tip tell, and as those that touch it do.
    fn left(mesh: &Mesh, cutters: &[Cutter], within: [DVec2; 2], step: f64) -> [Vec<u32>; 2] {
        let cancel = Cancel::default();
        let field = HeightField::raster(mesh, step, &cancel).unwrap();
        let library = CutterLibrary { cutter: cutters.to_vec() };
        let all = closing_within(&field, &library, within, &cancel).unwrap();
        let all = regions(&field, &all, TOLERANCE, &cancel).unwrap();
        let at_most = left_at_most(&field, &library, within, TOLERANCE, &cancel).unwrap();
        [all, at_most].map(|found| {
            let mut cells: Vec<u32> = found.into_iter().flat_map(|region| region.cells).collect();
            cells.sort_unstable();
            cells
        })
    }

    /// A block with a hollow, a part of a ball of this radius (mm), 3 mm wide at its mouth.
    fn hollow(radius: f64) -> Mesh {
        let end = (1.5 / radius).min(1.0).asin();
        let ring = |k: usize| {
            let angle = end * (1.0 - k as f64 / 24.0);
            (polygon(60, radius * angle.sin()), 5.0 - radius * (angle.cos() - end.cos()))
        };
        dish(&polygon(60, 3.5), &(0..24).map(ring).collect::<Vec<_>>(), 5.0 - radius * (1.0 - end.cos()))
    }

    #[test]
    fn a_hollow_is_taken_by_a_ball_that_is_smaller_and_not_by_one_that_is_larger() {
        let within = [DVec2::splat(-2.0), DVec2::splat(2.0)];
        for (radius, ball, is_taken) in [(1.6, 1.5, true), (2.5, 1.0, true), (1.6, 2.0, false)] {
            let [all, at_most] = left(&hollow(radius), &[Cutter::ball(ball)], within, 0.04);
            assert_eq!([all.is_empty(), at_most.is_empty()], [is_taken; 2], "{radius} {ball}: {}", at_most.len());
        }
    }

    #[test]
    fn corners_at_a_floor_are_taken_by_a_flat_cutter_and_its_walls_by_a_ball() {
        // Walls so much aslant that a flat cutter leaves a part of them.
        let mesh = dish(&polygon(48, 6.0), &[(polygon(48, 5.0), 5.0), (polygon(48, 2.0), 2.0)], 2.0);
        let within = [DVec2::splat(-4.0), DVec2::splat(4.0)];
        let field = HeightField::raster(&mesh, 0.04, &Cancel::default()).unwrap();
        let at_most = |cutters: &[Cutter]| {
            let library = CutterLibrary { cutter: cutters.to_vec() };
            left_at_most(&field, &library, within, TOLERANCE, &Cancel::default()).unwrap().len()
        };
        assert!(at_most(&[Cutter::ball(1.0)]) > 0);
        assert_eq!(at_most(&[Cutter::ball(1.0), Cutter::flat(1.0)]), 0);
    }

    #[test]
    fn what_is_left_at_most_holds_all_that_is_left() {
        let grooved = dish(
            &rectangle(9.0, 7.0),
            &[(rectangle(6.0, 4.0), 5.0), (rectangle(4.0, 1.5), 2.0), (rectangle(3.0, 1.0), 1.5)],
            1.5,
        );
        let within = [DVec2::new(-2.0, -1.5), DVec2::new(3.0, 2.0)];
        let short = Cutter { reach_mm: Some(1.0), holder_diameter_mm: Some(2.5), ..Cutter::ball(0.5) };
        let both = [Cutter::flat(0.4), Cutter::ball(0.5)];
        let of_one =
            [Cutter::ball(0.5), Cutter::ball(1.0), Cutter::bull_nose(0.8, 0.3), short].map(|cutter| vec![cutter]);
        let libraries: Vec<Vec<Cutter>> = of_one.into_iter().chain([both.to_vec()]).collect();
        for mesh in [grooved, frame(&rectangle(9.0, 7.0), &rectangle(4.0, 3.0), 2.0), hollow(1.5)] {
            for cutters in &libraries {
                let [all, at_most] = left(&mesh, cutters, within, 0.05);
                let lacking = all.iter().filter(|cell| at_most.binary_search(cell).is_err()).count();
                assert_eq!(lacking, 0, "of {} cells, {} at most: {cutters:?}", all.len(), at_most.len());
            }
        }
    }
}
