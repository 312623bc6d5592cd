//! Regions: what is left of a mold, joined from the pieces of its layers.
//!
//! Pieces of neighbouring layers that overlap in plan belong to one region, and so does a piece that overlaps none but
//! has one close beside it: a corner of slanted walls wanders. The volume of a region is the trapezoid over its pieces.

use glam::DVec2;
use rayon::prelude::*;

use super::outline::{Outline, off_segment};
use super::piece::UncutPiece;
use super::plane;
use super::stack::UncutLayer;
use geometry::groups::Groups;
use geometry::mesh::Bounds;

/// Share of the smaller of two pieces' areas from which on they overlap: rounding.
const OVERLAP: f64 = 1e-6;
/// Share of its least width by which a piece may come or go between two layers. Corners of walls up to 60 degrees off
/// the vertical then still overlap from layer to layer.
const DRIFT: f64 = 0.15;
/// How far a piece may wander from one layer to the next, in distances between them: corners of walls up to 60 degrees
/// off the vertical do.
const WANDER: f64 = 2.0;
/// Pieces further apart than this are never one (mm).
const APART: f64 = 0.25;

/// A connected part of what the cutters leave.
#[derive(Debug, Clone, PartialEq)]
pub struct LayerRegion {
    /// Pieces: layer and place in the layer, in order.
    pub pieces: Vec<[usize; 2]>,
    /// Volume (mm^3).
    pub volume: f64,
    /// Greatest area of its pieces in one layer (mm^2).
    pub plan_area: f64,
    /// The box around it (mm).
    pub bounds: Bounds,
    /// From its lowest to its highest layer (mm).
    pub height: f64,
    /// How far into a corner it reaches, seen from above, at most (mm); infinite where no cutter comes near.
    pub corner_depth: f64,
}

impl LayerRegion {
    /// How thick the residue is across the mold's surface, about (mm): upright it is as deep as the corner, lying as
    /// it is high.
    pub fn residue(&self) -> f64 {
        1.0 / (self.corner_depth.powi(-2) + self.height.max(f64::MIN_POSITIVE).powi(-2)).sqrt()
    }
}

impl LayerRegion {
    /// Both as one.
    pub fn and(mut self, other: Self) -> Self {
        self.pieces.extend(other.pieces);
        self.pieces.sort_unstable();
        self.bounds = Bounds { min: self.bounds.min.min(other.bounds.min), max: self.bounds.max.max(other.bounds.max) };
        Self {
            volume: self.volume + other.volume,
            plan_area: self.plan_area + other.plan_area,
            height: self.bounds.size().z,
            corner_depth: self.corner_depth.max(other.corner_depth),
            ..self
        }
    }
}

/// The regions of layers in rising order, by height and then by place of their first pieces; those whose residue is no
/// thicker than `tolerance` (mm) left out.
pub fn regions(layers: &[UncutLayer], tolerance: f64) -> Vec<LayerRegion> {
    let first: Vec<usize> = layers
        .iter()
        .scan(0, |sum, layer| {
            let first = *sum;
            *sum += layer.pieces.len();
            Some(first)
        })
        .collect();
    let count = layers.iter().map(|l| l.pieces.len()).sum();
    let links: Vec<Vec<[usize; 2]>> = (1..layers.len())
        .into_par_iter()
        .map(|k| {
            let [low, high] = [&layers[k - 1], &layers[k]];
            let reach = (WANDER * (high.z - low.z)).min(APART);
            let mut pairs = overlaps(&low.pieces, &high.pieces);
            pairs.extend(beside([&low.pieces, &high.pieces], &pairs, reach));
            pairs.into_iter().map(|[a, b]| [first[k - 1] + a, first[k] + b]).collect()
        })
        .collect();
    let mut groups = Groups::of(count);
    links.into_iter().flatten().for_each(|[a, b]| groups.join(a, b));
    let (numbers, groups) = groups.numbers();
    let mut members: Vec<Vec<[usize; 2]>> = vec![Vec::new(); groups];
    let places = layers.iter().enumerate().flat_map(|(k, layer)| (0..layer.pieces.len()).map(move |i| [k, i]));
    places.zip(numbers).for_each(|(place, group)| members[group as usize].push(place));
    let mut regions: Vec<LayerRegion> = members.into_par_iter().map(|pieces| region(layers, pieces)).collect();
    regions.retain(|region| region.residue() > tolerance);
    regions
}

fn region(layers: &[UncutLayer], pieces: Vec<[usize; 2]>) -> LayerRegion {
    let z = |k: usize| layers[k.min(layers.len() - 1)].z;
    let mut region = LayerRegion {
        volume: 0.0,
        plan_area: 0.0,
        bounds: Bounds::EMPTY,
        height: 0.0,
        corner_depth: 0.0,
        pieces: Vec::new(),
    };
    for of_layer in pieces.chunk_by(|a, b| a[0] == b[0]) {
        let k = of_layer[0][0];
        let own = || of_layer.iter().map(|&[k, i]| &layers[k].pieces[i]);
        let area: f64 = own().map(|p| p.area).sum();
        region.volume += area * 0.5 * (z(k + 1) - z(k.saturating_sub(1)));
        region.plan_area = region.plan_area.max(area);
        for piece in own() {
            region.corner_depth = region.corner_depth.max(piece.depth);
            let [min, max] = piece.extent().map(|p| p.extend(z(k)));
            region.bounds = Bounds { min: region.bounds.min.min(min), max: region.bounds.max.max(max) };
        }
    }
    region.height = region.bounds.size().z;
    region.pieces = pieces;
    region
}

/// Pairs of pieces of two layers that overlap, in order.
fn overlaps(a: &[UncutPiece], b: &[UncutPiece]) -> Vec<[usize; 2]> {
    let extents: Vec<[DVec2; 2]> = b.iter().map(UncutPiece::extent).collect();
    let mut pairs = Vec::new();
    for (i, first) in a.iter().enumerate() {
        let [low, high] = first.extent();
        let near = |[from, to]: &[DVec2; 2]| low.cmple(*to).all() && from.cmple(high).all();
        let both = b.iter().enumerate().filter(|(j, second)| near(&extents[*j]) && do_overlap(first, second));
        pairs.extend(both.map(|(j, _)| [i, j]));
    }
    pairs
}

/// For each piece of two layers that overlaps none of the other the nearest one there, if it is within `reach` (mm).
/// What comes and goes between facets joins nothing.
fn beside(layers: [&[UncutPiece]; 2], pairs: &[[usize; 2]], reach: f64) -> Vec<[usize; 2]> {
    let extents = layers.map(|pieces| pieces.iter().map(UncutPiece::extent).collect::<Vec<_>>());
    let are_near = |[low, high]: &[DVec2; 2], [from, to]: &[DVec2; 2]| {
        (*from - *high).cmple(DVec2::splat(reach)).all() && (*low - *to).cmple(DVec2::splat(reach)).all()
    };
    let mut found = Vec::new();
    for side in [0, 1] {
        let mut is_alone = vec![true; extents[side].len()];
        pairs.iter().for_each(|pair| is_alone[pair[side]] = false);
        for own in (0..is_alone.len()).filter(|own| is_alone[*own] && !layers[side][*own].is_shallow()) {
            let others = (0..extents[1 - side].len()).filter(|other| !layers[1 - side][*other].is_shallow());
            let near = others.filter(|other| are_near(&extents[side][own], &extents[1 - side][*other]));
            let gaps = near.map(|other| (other, off(&layers[side][own], &layers[1 - side][other])));
            let nearest = gaps.filter(|(_, gap)| *gap <= reach).min_by(|a, b| a.1.total_cmp(&b.1));
            found.extend(nearest.map(|(other, _)| if side == 0 { [own, other] } else { [other, own] }));
        }
    }
    found
}

/// How far apart the boundaries of two pieces are (mm).
fn off(a: &UncutPiece, b: &UncutPiece) -> f64 {
    let from = |a: &UncutPiece, b: &UncutPiece| {
        let off_side = |[p, q]: [DVec2; 2]| {
            let points = a.boundary.iter().flat_map(Outline::points);
            points.map(|at| off_segment(*at, p, q)).fold(f64::INFINITY, f64::min)
        };
        b.boundary.iter().flat_map(Outline::sides).map(off_side).fold(f64::INFINITY, f64::min)
    };
    from(a, b).min(from(b, a))
}

fn do_overlap(a: &UncutPiece, b: &UncutPiece) -> bool {
    // Between vertical walls nothing changes.
    if a.boundary == b.boundary {
        return true;
    }
    let shared: f64 = plane::intersection(&a.boundary, &b.boundary).iter().map(|s| plane::area(s)).sum();
    shared > OVERLAP * a.area.min(b.area)
}

/// Whether every piece of two neighbouring layers overlaps one of the other, or the layers are so near to each other
/// that what comes or goes between them is flat: nearer than `counted` (mm), or than the piece is wide.
pub fn have_partners(low: &UncutLayer, high: &UncutLayer, counted: f64) -> bool {
    let thickness = high.z - low.z;
    let is_flat = |piece: &UncutPiece| {
        let [from, to] = piece.extent();
        piece.is_shallow() || thickness <= DRIFT * (to - from).min_element()
    };
    if thickness <= counted || low.pieces.iter().chain(&high.pieces).all(is_flat) {
        return true;
    }
    let pairs = overlaps(&low.pieces, &high.pieces);
    let alone = |pieces: &[UncutPiece], side: usize| {
        let mut has = vec![false; pieces.len()];
        pairs.iter().for_each(|pair| has[pair[side]] = true);
        pieces.iter().zip(has).any(|(piece, has)| !has && !is_flat(piece))
    };
    !alone(&low.pieces, 0) && !alone(&high.pieces, 1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixtures::rectangle;

    /// A square piece with this middle and side.
    fn square(x: f64, side: f64) -> UncutPiece {
        let points: Vec<DVec2> = rectangle(side, side).into_iter().map(|p| p + DVec2::X * x).collect();
        let segments = vec![points.clone()];
        UncutPiece { boundary: vec![Outline::new(points).unwrap()], area: side * side, segments, depth: 0.5 * side }
    }

    fn layer(z: f64, pieces: Vec<UncutPiece>) -> UncutLayer {
        UncutLayer { z, pieces }
    }

    #[test]
    fn pieces_that_overlap_join() {
        let layers = [
            layer(0.0, vec![square(0.0, 2.0), square(10.0, 2.0)]),
            layer(1.0, vec![square(1.0, 2.0), square(12.3, 2.0)]),
            layer(2.0, vec![square(2.5, 2.0)]),
        ];
        let regions = regions(&layers, 1e-3);
        let pieces: Vec<_> = regions.iter().map(|r| r.pieces.clone()).collect();
        assert_eq!(pieces, [vec![[0, 0], [1, 0], [2, 0]]], "alone a piece has no height");
        let region = &regions[0];
        assert_eq!((region.volume, region.plan_area, region.height), (8.0, 4.0, 2.0));
        assert_eq!((region.bounds.min.x, region.bounds.max.x, region.corner_depth), (-1.0, 3.5, 1.0));
        assert!((region.residue() - 1.0 / (1.0f64 + 0.25).sqrt()).abs() < 1e-12);
    }

    #[test]
    fn two_that_meet_further_up_are_one() {
        let layers = [layer(0.0, vec![square(0.0, 1.0), square(3.0, 1.0)]), layer(0.5, vec![square(1.5, 5.0)])];
        let joined = regions(&layers, 1e-3);
        assert_eq!(joined.len(), 1);
        assert_eq!((joined[0].plan_area, joined[0].volume), (25.0, 0.25 * 2.0 + 0.25 * 25.0));
        assert!(regions(&layers, 1.0).is_empty() && regions(&[], 0.0).is_empty());
    }

    #[test]
    fn a_piece_alone_has_its_partner_further_between_unless_the_slab_is_thin() {
        let far = |thickness: f64, counted: f64| {
            have_partners(&layer(0.0, vec![square(0.0, 1.0)]), &layer(thickness, vec![square(3.0, 1.0)]), counted)
        };
        assert!(!far(0.5, 0.1) && far(0.1, 0.0) && far(0.5, 0.5));
        assert!(have_partners(&layer(0.0, vec![square(0.0, 1.0)]), &layer(0.5, vec![square(0.3, 1.0)]), 0.1));
    }

    /// The corner of walls 45 degrees off the vertical wanders as far as the layers are apart.
    #[test]
    fn a_piece_alone_goes_on_in_the_nearest_one_close_beside_it() {
        let low = layer(0.0, vec![square(0.0, 0.02), square(0.5, 0.02)]);
        let high = layer(0.1, vec![square(0.1, 0.02), square(0.6, 0.02)]);
        let found = regions(&[low.clone(), high], 1e-3);
        let pieces: Vec<_> = found.iter().map(|r| r.pieces.clone()).collect();
        assert_eq!(pieces, [[[0, 0], [1, 0]], [[0, 1], [1, 1]]]);
        let segments = vec![[-0.01, 0.0, 0.01].map(|x| DVec2::new(0.1 + x, 0.0)).to_vec()];
        let shallow = UncutPiece { segments, depth: 1e-5, ..square(0.1, 0.02) };
        assert!(shallow.is_shallow(), "what comes and goes between facets");
        assert!(regions(&[low, layer(0.1, vec![shallow])], 1e-3).is_empty());
    }
}
