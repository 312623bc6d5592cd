//! What is left in each layer, in figures.

use mold::height_field::{Closing, FieldRegion, HeightField};
use mold::stack::UncutStack;
use mold::surface::{SurfacePiece, segments_at};
use mold::uncut_region::UncutRegion;
use serde::{Deserialize, Serialize};

/// How far heights of the grid may be off: single precision, and a rounded cutter that sags between two places (mm).
const ROUNDING: f64 = 3e-4;

/// What is left in one layer.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct LayerFound {
    /// Height of the layer (mm).
    pub z: f64,
    /// Area of what is left (mm^2).
    pub area: f64,
    /// Length of the mold's outline that no cutter touches (mm).
    pub segment_length: f64,
}

/// What the regions of flat cutters have in each layer.
pub(super) fn of_layers(stack: &UncutStack, regions: &[UncutRegion]) -> Vec<LayerFound> {
    let mut layers: Vec<LayerFound> =
        stack.layers.iter().map(|l| LayerFound { z: l.z, area: 0.0, segment_length: 0.0 }).collect();
    for &[k, i] in regions.iter().flat_map(|r| &r.pieces) {
        let piece = &stack.layers[k].pieces[i];
        layers[k].area += piece.area;
        layers[k].segment_length += piece.segment_length();
    }
    layers
}

/// What all cutters leave in each layer, by cells and by the surface.
pub(super) fn of_surface(
    stack: &UncutStack,
    (field, closing): (&HeightField, &Closing),
    regions: &[FieldRegion],
    surface: &[SurfacePiece],
) -> Vec<LayerFound> {
    let heights: Vec<f64> = stack.layers.iter().map(|l| l.z).collect();
    // Cells that begin and end below each layer: what is left between layers adds up to what is left in each.
    let mut change = vec![0i64; heights.len() + 1];
    for cell in regions.iter().flat_map(|r| &r.cells).map(|c| *c as usize) {
        let Some(low) = field.height(cell) else { continue };
        let high = low + closing.residue(field, cell);
        change[first_above(&heights, low)] += 1;
        change[first_above(&heights, high)] -= 1;
    }
    let counts = change.iter().scan(0i64, |sum, by| {
        *sum += by;
        Some(*sum)
    });
    let mut lengths = vec![0.0; heights.len()];
    for piece in surface {
        let own = std::slice::from_ref(piece);
        let [low, high] = piece.span();
        for k in heights.partition_point(|z| *z < low)..heights.partition_point(|z| *z <= high) {
            lengths[k] += segments_at(own, heights[k]).iter().map(|(_, [a, b])| a.distance(*b)).sum::<f64>();
        }
    }
    let area = |count: i64| count as f64 * field.step() * field.step();
    let figures = heights.iter().zip(counts).zip(lengths);
    figures.map(|((z, count), segment_length)| LayerFound { z: *z, area: area(count), segment_length }).collect()
}

/// The first of the layers that lies above a height of the grid. Layers lie closely below and on horizontal faces, and
/// heights are a little off: one near such a pair is that of the face.
fn first_above(layers: &[f64], height: f64) -> usize {
    let after = layers.partition_point(|z| *z <= height);
    let is_pair = |k: &usize| {
        let [below, above] = [layers[*k - 1], layers[*k]];
        above - below < 0.1 * ROUNDING && (below - ROUNDING..=above + ROUNDING).contains(&height)
    };
    let near = after.saturating_sub(1).max(1)..(after + 2).min(layers.len());
    near.clone().find(is_pair).unwrap_or(after)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn heights_of_faces_lie_between_the_layers_below_and_above_them() {
        let layers = [0.0, 1.0 - 1e-6, 1.0 + 1e-6, 3.0];
        let at = |height: f64| first_above(&layers, height);
        assert_eq!([-1.0, 0.5, 2.0, 4.0].map(at), [0, 1, 3, 4]);
        assert_eq!([1.0 - 1e-4, 1.0 - 5e-7, 1.0, 1.0 + 1e-4].map(at), [2; 4]);
        assert_eq!(first_above(&[], 1.0), 0);
    }
}
