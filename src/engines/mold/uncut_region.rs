//! Regions of what is left, by all that is known of them.
//!
//! The grid of heights knows every kind of cutter, the layers know flat ones better. Where only flat cutters count, a
//! region's extent in plan and volume are those of the layers, and the grid adds what it knows of it, and regions that
//! lie between layers. Where rounded cutters count too, regions are those of the grid.

use glam::DVec2;
use serde::{Deserialize, Serialize};

use super::height_field::{Closing, FieldRegion, HeightField};
use super::plane;
use super::region::LayerRegion;
use super::stack::UncutLayer;
use super::surface::SurfacePiece;
use geometry::mesh::Bounds;

/// Cells of a region of the grid that are looked for among the layers' regions, at most.
const LOOKS: usize = 64;

/// A connected part of what the cutters leave.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct UncutRegion {
    /// Volume (mm^3).
    pub volume: f64,
    /// Area seen from the cutter (mm^2).
    pub plan_area: f64,
    /// Area of the mold's surface that bounds it, walls and floors (mm^2).
    pub surface_area: f64,
    /// Greatest height of what is left above the material (mm).
    pub depth: f64,
    /// Greatest thickness across the mold's surface (mm).
    pub thickness: f64,
    /// The box around it (mm), upright.
    pub bounds: Bounds,
    /// The triangles that bound it, wholly or in part, in order.
    pub faces: Vec<u32>,
    /// The cutter that leaves least in most of it: its place in the library.
    pub nearest_cutter: Option<usize>,
    /// Pieces in layers: layer and place in the layer; none where the region is one of the grid.
    pub pieces: Vec<[usize; 2]>,
}

impl UncutRegion {
    fn of_field(region: &FieldRegion) -> Self {
        Self {
            volume: region.volume,
            plan_area: region.plan_area,
            surface_area: 0.0,
            depth: region.depth,
            thickness: region.normal_depth,
            bounds: region.bounds,
            faces: Vec::new(),
            nearest_cutter: Some(region.nearest_cutter),
            pieces: Vec::new(),
        }
    }

    fn of_layers(layers: &[UncutLayer], region: &LayerRegion, of_field: &[&FieldRegion]) -> Self {
        let greatest = |value: fn(&FieldRegion) -> f64| of_field.iter().map(|r| value(r)).fold(0.0, f64::max);
        // Between layers, and above and below them, the grid knows more of its height.
        let of_both = |value: fn(&Bounds) -> f64| of_field.iter().map(move |r| value(&r.bounds));
        let mut bounds = region.bounds;
        bounds.min.z = of_both(|b| b.min.z).fold(bounds.min.z, f64::min);
        bounds.max.z = of_both(|b| b.max.z).fold(bounds.max.z, f64::max);
        let main = of_field.iter().max_by(|a, b| a.volume.total_cmp(&b.volume));
        Self {
            volume: region.volume,
            plan_area: if main.is_some() {
                plan_area(layers, region).unwrap_or_else(|| of_field.iter().map(|r| r.plan_area).sum())
            } else {
                region.plan_area
            },
            surface_area: 0.0,
            depth: if main.is_some() { greatest(|r| r.depth) } else { region.height },
            thickness: if main.is_some() { greatest(|r| r.normal_depth) } else { region.residue() },
            bounds,
            faces: Vec::new(),
            nearest_cutter: main.map(|r| r.nearest_cutter),
            pieces: region.pieces.clone(),
        }
    }
}

/// Regions, the largest volume first, and for each of the grid's which of them it is; none if it is in none.
pub struct Regions {
    /// The regions.
    pub regions: Vec<UncutRegion>,
    /// Where those of the grid are.
    pub places: Vec<Option<usize>>,
}

impl Regions {
    /// The regions of the grid, which come with the largest first.
    pub fn of_field(found: &[FieldRegion]) -> Self {
        Self {
            regions: found.iter().map(UncutRegion::of_field).collect(),
            places: (0..found.len()).map(Some).collect(),
        }
    }

    /// The regions of layers, with what the grid knows of them. Those of the layers that are one on the grid are one: they
    /// meet where the cutter has no room, as at the end of a slot of its own width.
    pub fn of_layers(
        layers: &[UncutLayer],
        flat: &[LayerRegion],
        (field, closing): (&HeightField, &Closing),
        found: &[FieldRegion],
    ) -> Self {
        let counts = |region: &FieldRegion| counts(layers, flat, (field, closing), region);
        let (flat, owners) = joined(flat, &found.iter().map(counts).collect::<Vec<_>>());
        let flat = &flat;
        let parts = |l: usize| found.iter().zip(&owners).filter(move |(_, owner)| **owner == Some(l)).map(|(r, _)| r);
        let of_layers =
            (0..flat.len()).map(|l| UncutRegion::of_layers(layers, &flat[l], &parts(l).collect::<Vec<_>>()));
        // Layers that lie too far apart may have missed what the grid finds.
        let missed = (0..found.len()).filter(|f| owners[*f].is_none());
        let all: Vec<UncutRegion> = of_layers.chain(missed.clone().map(|f| UncutRegion::of_field(&found[f]))).collect();
        let mut order: Vec<usize> = (0..all.len()).collect();
        order.sort_by(|a, b| all[*b].volume.total_cmp(&all[*a].volume).then(a.cmp(b)));
        let mut places = vec![0; all.len()];
        order.iter().enumerate().for_each(|(place, i)| places[*i] = place);
        let mut of_missed = flat.len()..;
        let place = |owner: &Option<usize>| owner.or_else(|| of_missed.next()).map(|i| places[i]);
        let places = owners.iter().map(place).collect();
        Self { regions: order.into_iter().map(|i| all[i].clone()).collect(), places }
    }

    /// The pieces of the surface that bound a region, which are numbered as the regions of the grid, numbered as the
    /// regions; these learn their faces and areas.
    pub fn with_surface(mut self, pieces: Vec<SurfacePiece>) -> (Vec<UncutRegion>, Vec<SurfacePiece>) {
        let Self { regions, places } = &mut self;
        let numbered = |piece: SurfacePiece| {
            let place = places[piece.region as usize]?;
            let region = &mut regions[place];
            region.surface_area += piece.area();
            if region.faces.last() != Some(&piece.face) {
                region.faces.push(piece.face);
            }
            Some(SurfacePiece { region: place as u32, ..piece })
        };
        let pieces = pieces.into_iter().filter_map(numbered).collect();
        (self.regions, pieces)
    }
}

/// The area of a region whose pieces are the same in all layers, as between vertical walls (mm^2). Where they are not,
/// what is thinner than the tolerance does not count, and only the grid knows it.
fn plan_area(layers: &[UncutLayer], region: &LayerRegion) -> Option<f64> {
    let mut pieces = region.pieces.iter().map(|&[k, i]| &layers[k].pieces[i]);
    let first = pieces.next()?;
    pieces.all(|piece| piece.boundary == first.boundary).then_some(first.area)
}

/// The regions of layers that hold looked at cells of a region of the grid, each with their number.
fn counts(
    layers: &[UncutLayer],
    flat: &[LayerRegion],
    (field, closing): (&HeightField, &Closing),
    region: &FieldRegion,
) -> Vec<(usize, usize)> {
    let slack = 1.5 * field.step();
    let near = (0..flat.len()).filter(|l| flat[*l].bounds.grown(slack).intersects(&region.bounds));
    let mut counts: Vec<(usize, usize)> = near.map(|l| (l, 0)).collect();
    for cell in region.cells.iter().step_by(region.cells.len().div_ceil(LOOKS).max(1)).map(|c| *c as usize) {
        let Some(low) = field.height(cell) else { continue };
        let heights = [low, low + closing.residue(field, cell)];
        let at = field.center(cell);
        for (l, count) in &mut counts {
            *count += usize::from(holds(layers, &flat[*l], at, heights, slack));
        }
    }
    counts.retain(|(_, count)| *count > 0);
    counts
}

/// The regions of layers, those without a region of the grid of their own joined with the one whose it is; and for each
/// region of the grid, by how many of its cells which of them hold, the one that holds most.
fn joined(flat: &[LayerRegion], counts: &[Vec<(usize, usize)>]) -> (Vec<LayerRegion>, Vec<Option<usize>>) {
    let most = |of: &Vec<(usize, usize)>| of.iter().rev().max_by_key(|(_, count)| *count).map(|(l, _)| *l);
    let owners: Vec<Option<usize>> = counts.iter().map(most).collect();
    // What each is part of: itself, or the owner of the region of the grid that most of it is in.
    let part_of = |l: usize| {
        let held = counts.iter().zip(&owners).flat_map(|(of, owner)| of.iter().zip(std::iter::repeat(*owner)));
        let own = held.filter(|((other, _), _)| *other == l);
        let of_most = own.max_by_key(|((_, count), _)| *count).and_then(|(_, owner)| owner);
        if owners.contains(&Some(l)) { l } else { of_most.unwrap_or(l) }
    };
    let parts: Vec<usize> = (0..flat.len()).map(part_of).collect();
    let kept: Vec<usize> = (0..flat.len()).filter(|l| parts[*l] == *l).collect();
    let whole = |l: &usize| {
        let others = (0..flat.len()).filter(|other| other != l && parts[*other] == *l);
        others.fold(flat[*l].clone(), |whole, other| whole.and(flat[other].clone()))
    };
    let place = |owner: &Option<usize>| owner.and_then(|l| kept.binary_search(&l).ok());
    (kept.iter().map(whole).collect(), owners.iter().map(place).collect())
}

/// Whether a piece of the region between the heights holds a place of the plan, or one within `slack` of it (mm).
fn holds(layers: &[UncutLayer], region: &LayerRegion, at: DVec2, [low, high]: [f64; 2], slack: f64) -> bool {
    let near = [DVec2::ZERO, DVec2::X, DVec2::NEG_X, DVec2::Y, DVec2::NEG_Y].map(|off| at + slack * off);
    let bounds = region.bounds.grown(slack);
    let is_in_box = bounds.min.truncate().cmple(at).all() && at.cmple(bounds.max.truncate()).all();
    let mut own = region.pieces.iter().filter(|[k, _]| (low - slack..=high + slack).contains(&layers[*k].z));
    is_in_box && own.any(|&[k, i]| near.iter().any(|p| plane::holds(&layers[k].pieces[i].boundary, *p)))
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;

    #[test]
    fn regions_of_layers_without_one_of_the_grid_are_joined_with_the_one_that_has_it() {
        let flat = |x: f64| LayerRegion {
            pieces: vec![[0, x as usize]],
            volume: 1.0 + x,
            plan_area: 2.0,
            bounds: Bounds { min: DVec3::new(x, 0.0, 0.0), max: DVec3::new(x + 1.0, 1.0, 3.0) },
            height: 3.0,
            corner_depth: 1.0,
        };
        let all = [flat(0.0), flat(1.0), flat(2.0), flat(3.0)];
        // The grid's first region is in 1 and 2, most in 2, its second in 3; of 0 it has nothing.
        let (joined, owners) = joined(&all, &[vec![(1, 20), (2, 30)], vec![(3, 5)], Vec::new()]);
        assert_eq!(owners, [Some(1), Some(2), None]);
        assert_eq!(joined.len(), 3);
        assert_eq!((&joined[0], &joined[2]), (&all[0], &all[3]));
        assert_eq!((joined[1].volume, &joined[1].pieces[..]), (5.0, &[[0, 1], [0, 2]][..]));
        assert_eq!((joined[1].bounds.min.x, joined[1].bounds.max.x), (1.0, 3.0));
    }

    #[test]
    fn a_region_of_layers_is_as_high_as_the_grid_knows() {
        let bounds = |low: f64, high: f64| Bounds { min: DVec3::new(0.0, 0.0, low), max: DVec3::new(2.0, 1.0, high) };
        let region = LayerRegion {
            pieces: Vec::new(),
            volume: 3.0,
            plan_area: 2.0,
            bounds: bounds(-7.0, -6.87),
            height: 0.13,
            corner_depth: 1.0,
        };
        let of_field = FieldRegion {
            cells: Vec::new(),
            plan_area: 2.5,
            volume: 3.5,
            depth: 0.2,
            normal_depth: 0.1,
            thickest: DVec3::ZERO,
            bounds: bounds(-6.98, -6.79).grown(0.5),
            nearest_cutter: 0,
        };
        let of = |field: &[&FieldRegion]| UncutRegion::of_layers(&[], &region, field).bounds;
        assert_eq!(of(&[]), region.bounds);
        let joined = of(&[&of_field]);
        assert_eq!((joined.min.z, joined.max.z), (of_field.bounds.min.z, of_field.bounds.max.z));
        assert_eq!(joined.min.truncate(), region.bounds.min.truncate(), "in plan the layers know better");
    }
}
