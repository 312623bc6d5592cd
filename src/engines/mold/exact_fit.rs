//! Places that are about as wide as a cutter, which the height map may take for too narrow or for wide enough.
//!
//! On a grid the tip stands at centres of cells only. Where the cutter has no room to either side, as in a round or
//! square hole of its own width, none of them may be where it fits, and all of the place seems to be left. A place
//! narrower than the cutter by less than a cell may seem to let the cutter in.
//!
//! In the layers the cutter's path is exact. What flat cutters leave there is the most that a library leaves that has
//! them. What a cutter's shaft has no room for the cutter leaves below: a flat one in the layer, a rounded one by its
//! corner radius deeper.

use glam::DVec2;
use rayon::prelude::*;

use super::cutter::Cutter;
use super::height_field::{Closing, FieldRegion, HeightField};
use super::outline::Outline;
use super::piece::UncutPiece;
use super::plane;
use super::stack::UncutLayer;

/// Cells of a region that are compared at first, at most.
const LOOKS: usize = 64;
/// Share of these that the layers have to contradict for all cells to be compared: at the borders of what is left they
/// know more than a grid does.
const WRONG: f64 = 0.4;

/// Cells to either side of one that the layers have to contradict as well for the cell to be raised: where a wall lies
/// is as coarse as the grid.
const AROUND: usize = 2;
/// How far heights of the grid may be off (mm): single precision.
const ROUNDING: f64 = 1e-3;

/// Raises what `cutter` leaves of `field` to what its shaft has no room for in `layers`, which are of a flat cutter no wider
/// than the shaft. What was left `before` the cutter is the most.
pub fn raise_to_layers(
    field: &HeightField,
    (cutter, layers): (&Cutter, &[UncutLayer]),
    before: &Closing,
    closing: &mut Closing,
) {
    let mut above: &[UncutPiece] = &[];
    for layer in layers.iter().rev() {
        // Between upright walls the upper one tells more.
        let others = layer.pieces.iter().filter(|p| !above.iter().any(|a| a.boundary == p.boundary));
        let height = layer.z - cutter.corner_mm;
        let cells: Vec<Vec<usize>> =
            others.collect::<Vec<_>>().par_iter().map(|p| contradicted(field, closing, p, height)).collect();
        cells.iter().flatten().for_each(|cell| closing.raise(field, *cell, height, before));
        above = &layer.pieces;
    }
}

/// Cells within a piece of a layer, and around them so many that are as well, over which less is left than up to
/// `height` (mm).
fn contradicted(field: &HeightField, closing: &Closing, piece: &UncutPiece, height: f64) -> Vec<usize> {
    let [low, high] = piece.extent();
    let Some([columns, rows]) = field.cells_within(low, high) else { return Vec::new() };
    let is_less = |cell: usize| {
        field.height(cell).is_some_and(|z| z < height && z + closing.residue(field, cell) < height - ROUNDING)
    };
    let [width, _] = field.size();
    // A square of so many cells has one of these.
    let wide = 2 * AROUND + 1;
    let stretches: Vec<Vec<[f64; 2]>> =
        rows.clone().map(|row| plane::stretches(&piece.boundary, field.center(row * width).y)).collect();
    let is_in = |row: usize, column: usize| {
        let x = field.center(column).x;
        stretches[row - rows.start].iter().any(|[from, to]| (*from..*to).contains(&x))
    };
    let is_wrong = |row: usize, column: usize| is_less(row * width + column) && is_in(row, column);
    let first = |range: &std::ops::Range<usize>| range.start + AROUND;
    let mut looked = (first(&rows)..rows.end).step_by(wide);
    if !looked.any(|row| (first(&columns)..columns.end).step_by(wide).any(|column| is_wrong(row, column))) {
        return Vec::new();
    }
    let across = columns.len();
    let wrong: Vec<bool> =
        rows.clone().flat_map(|row| columns.clone().map(move |c| (row, c))).map(|(row, c)| is_wrong(row, c)).collect();
    let mut chosen = vec![false; wrong.len()];
    let square = |row: usize, column: usize| {
        (row..row + wide).flat_map(move |row| (column..column + wide).map(move |column| row * across + column))
    };
    for row in 0..(rows.len() + 1).saturating_sub(wide) {
        for column in 0..(across + 1).saturating_sub(wide) {
            if square(row, column).all(|i| wrong[i]) {
                square(row, column).for_each(|i| chosen[i] = true);
            }
        }
    }
    let cell = |i: usize| (rows.start + i / across) * width + columns.start + i % across;
    (0..chosen.len()).filter(|i| chosen[*i]).map(cell).collect()
}

/// Lowers what the cutters leave of `field` to what flat cutters leave in layers, in those of the grid's regions where the
/// two contradict each other; whether there were any. The cutters must include the flat ones of the layers.
pub fn lower_to_layers(
    (field, closing): (&HeightField, &mut Closing),
    regions: &[FieldRegion],
    layers: &[UncutLayer],
) -> bool {
    let extents: Vec<Vec<[DVec2; 2]>> =
        layers.par_iter().map(|layer| layer.pieces.iter().map(|piece| piece.extent()).collect()).collect();
    let known = Known { field, layers, extents };
    let wrong: Vec<&FieldRegion> = regions.par_iter().filter(|region| known.is_contradicted(region, closing)).collect();
    let heights = |region: &&FieldRegion| -> Vec<(usize, f64)> {
        let limit = |cell: &u32| {
            let cell = *cell as usize;
            Some((cell, known.limit(cell, known.span(cell, closing)?)))
        };
        region.cells.par_iter().filter_map(limit).collect()
    };
    let heights: Vec<Vec<(usize, f64)>> = wrong.iter().map(heights).collect();
    heights.iter().flatten().for_each(|(cell, height)| closing.lower(field, *cell, *height));
    !wrong.is_empty()
}

struct Known<'a> {
    field: &'a HeightField,
    layers: &'a [UncutLayer],
    /// Of each layer the extents of its pieces.
    extents: Vec<Vec<[DVec2; 2]>>,
}

impl Known<'_> {
    /// What is left over a cell, from and to (mm).
    fn span(&self, cell: usize, closing: &Closing) -> Option<[f64; 2]> {
        let low = self.field.height(cell)?;
        Some([low, low + closing.residue(self.field, cell)])
    }

    /// Whether something is left in a layer at a place or within `slack` of it (mm).
    fn is_left(&self, layer: usize, place: DVec2, slack: f64) -> bool {
        let near = |[low, high]: &[DVec2; 2]| (*low - slack).cmple(place).all() && place.cmple(*high + slack).all();
        let holds = |boundary: &[Outline]| match slack > 0.0 {
            true => plane::off(boundary, place) <= slack,
            false => plane::holds(boundary, place),
        };
        let pieces = self.layers[layer].pieces.iter().zip(&self.extents[layer]);
        pieces.filter(|(_, extent)| near(extent)).any(|(piece, _)| holds(&piece.boundary))
    }

    /// Whether halfway up nothing is left in the layers where the grid has a region.
    fn is_contradicted(&self, region: &FieldRegion, closing: &Closing) -> bool {
        let (mut looked, mut wrong) = (0, 0);
        for cell in region.cells.iter().step_by(region.cells.len().div_ceil(LOOKS).max(1)).map(|c| *c as usize) {
            let Some([low, high]) = self.span(cell, closing) else { continue };
            let layer = self.layers.partition_point(|layer| layer.z <= 0.5 * (low + high));
            // Between two layers the upper one may have less.
            let Some(layer) = layer.checked_sub(1).filter(|k| self.layers[*k].z > low) else { continue };
            looked += 1;
            wrong += usize::from(!self.is_left(layer, self.field.center(cell), self.field.step()));
        }
        wrong as f64 > WRONG * looked as f64
    }

    /// The height up to which the layers have something left over a cell (mm), of what the grid has there.
    fn limit(&self, cell: usize, [low, high]: [f64; 2]) -> f64 {
        let first = self.layers.partition_point(|layer| layer.z <= low);
        let within = self.layers[first..].partition_point(|layer| layer.z < high);
        // What is left begins at the material: above where it ends nothing is.
        let place = self.field.center(cell);
        let numbers: Vec<usize> = (first..first + within).collect();
        let left = numbers.partition_point(|k| self.is_left(*k, place, 0.0));
        match self.layers.get(first + left).filter(|_| left < within) {
            Some(_) if left == 0 => low,
            Some(free) => free.z.min(high),
            None => high,
        }
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;
    use crate::cutter::{Cutter, CutterLibrary};
    use crate::fixtures::{pocket, rectangle};
    use crate::height_field::{closing, closing_corrected, regions};
    use crate::layers::LayerSettings;
    use crate::stack::uncut_stack;
    use task::{Cancel, Task};

    /// A square hole as wide as the cutter keeps its corners however it lies, and a slot narrower than the cutter is left
    /// whole.
    #[test]
    fn a_cutter_without_play_is_known_to_fit() {
        let (cancel, cutter) = (Cancel::default(), Cutter::flat(1.0));
        let library = CutterLibrary { cutter: vec![cutter.clone(), Cutter::ball(2.0)] };
        let corners = (4.0 - PI) * 5.0;
        for degrees in [0.0f64, 11.0, 33.7, 45.0, 77.0] {
            let left = |width: f64| {
                let turn = DVec2::from_angle(degrees.to_radians());
                let hole = rectangle(2.0, width);
                let mesh = pocket(&rectangle(12.0, 12.0), &hole, &hole, [9.0, 5.0])
                    .mapped(|p| turn.rotate(p.truncate()).extend(p.z).as_vec3().as_dvec3());
                let field = HeightField::raster(&mesh, 0.025, &cancel).unwrap();
                let settings = LayerSettings::default();
                let stack = uncut_stack(&mesh, &[&cutter], None, &settings, &Task::default()).unwrap();
                let mut closing = closing(&field, &library, &cancel).unwrap();
                let found = regions(&field, &closing, 0.02, &cancel).unwrap();
                lower_to_layers((&field, &mut closing), &found, &stack.layers);
                let found = regions(&field, &closing, 0.02, &cancel).unwrap();
                found.iter().map(|region| region.volume).sum::<f64>()
            };
            assert!((left(2.0) / corners - 1.0).abs() < 0.15, "{degrees}: {} {corners}", left(2.0));
            assert!((left(1.9) / 19.0 - 1.0).abs() < 0.03, "{degrees}: {}", left(1.9));
        }
    }

    /// A slot narrower than the cutters by less than a cell is left by all of them: what a ball leaves is deeper by its
    /// radius.
    #[test]
    fn a_cutter_a_hair_too_wide_is_known_not_to_fit() {
        let (cancel, flat) = (Cancel::default(), Cutter::flat(1.0));
        for (degrees, kind) in [(0.0f64, Cutter::ball(1.0)), (33.7, Cutter::ball(3.0)), (0.0, flat.clone())] {
            let turn = DVec2::from_angle(degrees.to_radians());
            let hole = rectangle(1.99, 8.0);
            let mesh = pocket(&rectangle(12.0, 12.0), &hole, &hole, [9.0, 4.0])
                .mapped(|p| turn.rotate(p.truncate()).extend(p.z).as_vec3().as_dvec3());
            let field = HeightField::raster(&mesh, 0.025, &cancel).unwrap();
            let stack = uncut_stack(&mesh, &[&flat], None, &LayerSettings::default(), &Task::default()).unwrap();
            let raise = |cutter: &Cutter, before: &Closing, closing: &mut Closing| {
                raise_to_layers(&field, (cutter, &stack.layers), before, closing);
            };
            let library = CutterLibrary { cutter: vec![kind.clone()] };
            let closing = closing_corrected(&field, &library, &raise, &cancel).unwrap();
            let found = regions(&field, &closing, 0.02, &cancel).unwrap();
            let left: f64 = found.iter().map(|region| region.volume).sum();
            // What a ball dips into the slot is its segment.
            let dips = kind.corner_mm;
            let least = 1.99 * 8.0 * (4.0 - dips);
            assert!((0.98 * least..1.02 * 1.99 * 8.0 * 4.0).contains(&left), "{degrees}: {left} {least}");
        }
    }
}
