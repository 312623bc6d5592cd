//! Places that are just as wide as a flat cutter, which the height map may take for too narrow.
//!
//! On a grid the tip stands at centres of cells only. Where the cutter has no room to either side, as in a round or
//! square hole of its own width, none of them may be where it fits, and all of the place seems to be left. In the layers
//! the cutter's path is exact, and what flat cutters leave there is the most that a library leaves that has them.

use glam::DVec2;
use rayon::prelude::*;

use super::height_field::{Closing, FieldRegion, HeightField};
use super::outline::Outline;
use super::plane;
use super::stack::UncutLayer;

/// Cells of a region that are compared at first, at most.
const LOOKS: usize = 64;
/// Share of these that the layers have to contradict for all cells to be compared: at the borders of what is left they
/// know more than a grid does.
const WRONG: f64 = 0.4;

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
    use crate::height_field::{closing, regions};
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
}
