//! What another library of cutters would take away of what the present one leaves.

use std::collections::BTreeMap;

use glam::DVec3;
use rayon::prelude::*;

use super::uncut::Uncut;
use crate::geometry::exact::ExactMesh;
use crate::geometry::mesh::{Bounds, Mesh};
use crate::mold::surface::SurfacePiece;
use crate::mold::uncut_region::UncutRegion;
use crate::progress::{Cancel, Cancelled};

/// How many places of a region's surface are asked to whom they belong.
const PLACES: usize = 128;
/// The part of a region's area that counts for nothing: where a boundary lies is as coarse as the grid.
const NEARLY_NONE: f64 = 0.03;
/// The part of the golden ratio behind its point: multiples of it spread evenly.
const GOLDEN: f64 = 0.618_033_988_749_894_9;
/// How far apart two surfaces of the same mold may lie and still be one, in parts of the diagonal.
const SAME: f64 = 1e-3;

/// What a library leaves.
#[derive(Debug, Clone, Copy)]
pub struct Left<'a> {
    /// The regions.
    pub regions: &'a [UncutRegion],
    /// The surface under them.
    pub surface: &'a [SurfacePiece],
}

impl<'a> Left<'a> {
    /// What is left by the answer `uncut`.
    pub fn of(uncut: &'a Uncut) -> Self {
        Self { regions: &uncut.regions, surface: &uncut.surface }
    }
}

/// What becomes of the regions that the present library leaves.
#[derive(Debug, Clone, PartialEq)]
pub struct Comparison {
    /// For each region of the present library the volume that the other one leaves of it (mm^3).
    pub remains: Vec<f64>,
    /// Volume that the present library leaves, and the other one (mm^3).
    pub volumes: [f64; 2],
    /// How many regions either leaves.
    pub regions: [usize; 2],
    /// How many regions of the other library lie where the present one leaves nothing.
    pub new_regions: usize,
}

impl Comparison {
    /// Whether the other library leaves (nearly) nothing of region number `i` of the present one.
    pub fn vanishes(&self, i: usize) -> bool {
        self.remains.get(i).is_some_and(|volume| *volume <= 0.0)
    }

    /// How many regions vanish.
    pub fn vanishing(&self) -> usize {
        (0..self.remains.len()).filter(|i| self.vanishes(*i)).count()
    }

    /// What the other library would do, in a sentence.
    pub fn sentence(&self) -> String {
        let ([now, other], gone) = (self.volumes, self.vanishing());
        let regions = if gone == 1 { "1 region vanishes".to_owned() } else { format!("{gone} regions vanish") };
        let change = now - other;
        let volume = if change >= 0.0 {
            format!("{change:.3} mm³ of {now:.3} mm³ would be cut")
        } else {
            format!("{:.3} mm³ more than {now:.3} mm³ would be left", -change)
        };
        let new = match self.new_regions {
            0 => String::new(),
            1 => ", and 1 region is new".to_owned(),
            n => format!(", and {n} regions are new"),
        };
        format!("{volume}; {regions}{new}.")
    }
}

/// Compares what two libraries leave of the same mold, seen from the same opening.
///
/// # Errors
/// [`Cancelled`].
pub fn compare(now: Left, other: Left, cancel: &Cancel) -> Result<Comparison, Cancelled> {
    let volume = |left: Left| left.regions.iter().fold(0.0, |sum, r| sum + r.volume);
    let [present, others] = [now, other].map(Side::new);
    let shared = shared(&present, &others, cancel)?;
    // Where each region of the other library lies, and how much of the mold it shares there.
    let mut owners: Vec<Vec<(usize, f64)>> = vec![Vec::new(); other.regions.len()];
    for ((i, k), area) in shared {
        if area >= NEARLY_NONE * present.areas[i].min(others.areas[k]) {
            owners[k].push((i, area));
        }
    }
    let mut comparison = Comparison {
        remains: vec![0.0; now.regions.len()],
        volumes: [volume(now), volume(other)],
        regions: [now.regions.len(), other.regions.len()],
        new_regions: owners.iter().filter(|own| own.is_empty()).count(),
    };
    for (region, owners) in other.regions.iter().zip(&owners) {
        let all = owners.iter().fold(0.0, |sum, (_, area)| sum + area);
        owners.iter().for_each(|(i, area)| comparison.remains[*i] += region.volume * area / all);
    }
    Ok(comparison)
}

/// Area that each region of the present library shares with each of the other one (mm^2), where that is any.
fn shared(now: &Side, other: &Side, cancel: &Cancel) -> Result<BTreeMap<(usize, usize), f64>, Cancelled> {
    let mut shared = BTreeMap::new();
    // What is small beside its counterpart is seen only from its own side.
    for (i, found) in now.on(other, cancel)?.into_iter().enumerate() {
        for (k, area) in found {
            shared.insert((i, k), area);
        }
    }
    for (k, found) in other.on(now, cancel)?.into_iter().enumerate() {
        for (i, area) in found {
            let known: &mut f64 = shared.entry((i, k)).or_default();
            *known = known.max(area);
        }
    }
    Ok(shared)
}

/// The smallest of `regions` whose box holds the middle of that of a region which is too small to have a surface.
fn around(regions: &[UncutRegion], region: &UncutRegion) -> Option<usize> {
    let middle = region.bounds.center();
    let holds = |i: &usize| {
        let Bounds { min, max } = regions[*i].bounds;
        min.cmple(middle).all() && middle.cmple(max).all()
    };
    let size = |i: usize| regions[i].bounds.size().element_product();
    (0..regions.len()).filter(holds).min_by(|&a, &b| size(a).total_cmp(&size(b)))
}

/// What a library leaves, to be asked whose a place is.
struct Side<'a> {
    left: Left<'a>,
    /// For each region the surface under it, and its area (mm^2).
    pieces: Vec<Vec<&'a SurfacePiece>>,
    areas: Vec<f64>,
    /// All of that; none without any surface, or with none that can be asked.
    surface: Option<ExactMesh>,
    reach: f64,
}

impl<'a> Side<'a> {
    fn new(left: Left<'a>) -> Self {
        let mut pieces: Vec<Vec<&SurfacePiece>> = vec![Vec::new(); left.regions.len()];
        for piece in left.surface {
            if let Some(own) = pieces.get_mut(piece.region as usize) {
                own.push(piece);
            }
        }
        let area = |own: &Vec<&SurfacePiece>| own.iter().fold(0.0, |sum, p| sum + p.area());
        let areas = pieces.iter().map(area).collect();
        let vertices: Vec<DVec3> = left.surface.iter().flat_map(|p| p.corners).collect();
        let reach = SAME * Bounds::of(vertices.iter().copied()).size().length();
        let triangles = (0..left.surface.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        let surface = ExactMesh::new(&Mesh { vertices, triangles }).ok();
        Self { left, pieces, areas, surface, reach }
    }

    /// For each region the regions of `other` on which it lies, with the area of it that does (mm^2).
    fn on(&self, other: &Self, cancel: &Cancel) -> Result<Vec<BTreeMap<usize, f64>>, Cancelled> {
        let of_region = |i: usize| {
            cancel.check()?;
            let area = self.areas[i];
            let mut found = BTreeMap::new();
            if area > 0.0 {
                for place in places(&self.pieces[i], area) {
                    if let Some(k) = other.owner(place) {
                        *found.entry(k).or_default() += area / PLACES as f64;
                    }
                }
            } else if let Some(k) = around(other.left.regions, &self.left.regions[i]) {
                // Any area will do: it is compared with none.
                found.insert(k, self.left.regions[i].plan_area.max(f64::MIN_POSITIVE));
            }
            Ok(found)
        };
        (0..self.pieces.len()).into_par_iter().map(of_region).collect()
    }

    /// The region on whose surface `place` lies.
    fn owner(&self, place: DVec3) -> Option<usize> {
        let nearest = self.surface.as_ref()?.nearest(place);
        let piece = self.left.surface.get(nearest.triangle as usize)?;
        (nearest.signed_distance.abs() <= self.reach && (piece.region as usize) < self.areas.len())
            .then_some(piece.region as usize)
    }
}

/// Places spread over `pieces` of this `area` (mm^2), each for an equal part of it.
fn places(pieces: &[&SurfacePiece], area: f64) -> Vec<DVec3> {
    let part = area / PLACES as f64;
    let mut places = Vec::with_capacity(PLACES);
    let mut before = 0.0;
    for piece in pieces {
        let (own, [a, b, c]) = (piece.area(), piece.corners);
        while places.len() < PLACES && (places.len() as f64 + 0.5) * part < before + own {
            // From corner to opposite side as the area grows, and to and fro between the other two.
            let along = (((places.len() as f64 + 0.5) * part - before) / own).clamp(0.0, 1.0).sqrt();
            let across = (GOLDEN * (places.len() + 1) as f64).fract();
            places.push(a.lerp(b.lerp(c, across), along));
        }
        before += own;
    }
    places
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Regions with a triangle each at places along X and with their volumes.
    fn left(places: &[(f64, f64)]) -> (Vec<UncutRegion>, Vec<SurfacePiece>) {
        let corners = |x: f64| [DVec3::ZERO, DVec3::X, DVec3::Y].map(|p| p + x * DVec3::X);
        let region = |(x, volume): &(f64, f64)| UncutRegion {
            volume: *volume,
            plan_area: 1.0,
            surface_area: 0.5,
            depth: 1.0,
            thickness: 1.0,
            bounds: Bounds::of(corners(*x)),
            faces: vec![0],
            nearest_cutter: None,
            pieces: Vec::new(),
        };
        let piece = |(i, (x, _)): (usize, &(f64, f64))| SurfacePiece {
            corners: corners(*x),
            face: 0,
            region: i as u32,
            depth: [1.0; 3],
        };
        (places.iter().map(region).collect(), places.iter().enumerate().map(piece).collect())
    }

    fn compared(now: &[(f64, f64)], other: &[(f64, f64)]) -> Comparison {
        let (now, other) = (left(now), left(other));
        let [now, other] = [&now, &other].map(|(regions, surface)| Left { regions, surface });
        compare(now, other, &Cancel::default()).unwrap()
    }

    #[test]
    fn what_vanishes_what_remains_and_what_is_new_is_told_apart() {
        let now = [(0.0, 4.0), (10.0, 3.0), (20.0, 2.0)];
        let found = compared(&now, &[(20.0, 1.5), (0.0, 1.0), (50.0, 0.5)]);
        assert_eq!(found.remains, [1.0, 0.0, 1.5]);
        assert_eq!((found.vanishing(), found.vanishes(1), found.new_regions), (1, true, 1));
        assert_eq!(found.sentence(), "6.000 mm³ of 9.000 mm³ would be cut; 1 region vanishes, and 1 region is new.");
        let nothing = compared(&now, &[]);
        assert_eq!((nothing.vanishing(), nothing.volumes), (3, [9.0, 0.0]));
        let worse = compared(&[], &now);
        assert_eq!((worse.new_regions, worse.vanishing()), (3, 0));
        assert!(worse.sentence().starts_with("9.000 mm³ more"));
    }

    #[test]
    fn what_is_too_small_for_a_surface_belongs_where_it_lies() {
        let (now, other) = (left(&[(0.0, 4.0), (10.0, 3.0)]), left(&[(10.0, 0.1)]));
        let now = Left { regions: &now.0, surface: &now.1 };
        let found = compare(now, Left { regions: &other.0, surface: &[] }, &Cancel::default()).unwrap();
        assert_eq!((found.remains, found.new_regions), (vec![0.0, 0.1], 0));
    }

    #[test]
    fn regions_that_merge_into_one_do_not_vanish() {
        // Squares along X: of these, the other library leaves all between 0 and 4, of the third one a quarter.
        let square = |region: u32, x: [f64; 2]| {
            let [a, b, c, d] = [[x[0], 0.0], [x[1], 0.0], [x[1], 1.0], [x[0], 1.0]].map(|[x, y]| DVec3::new(x, y, 0.0));
            [[a, b, c], [a, c, d]].map(|corners| SurfacePiece { corners, face: 0, region, depth: [1.0; 3] })
        };
        let of = |squares: &[([f64; 2], f64)]| {
            let (mut regions, _) = left(&squares.iter().map(|(x, volume)| (x[0], *volume)).collect::<Vec<_>>());
            for (region, (x, _)) in regions.iter_mut().zip(squares) {
                region.bounds = Bounds::of(square(0, *x).iter().flat_map(|p| p.corners));
            }
            let surface: Vec<_> = squares.iter().zip(0..).flat_map(|((x, _), i)| square(i, *x)).collect();
            (regions, surface)
        };
        let now = of(&[([0.0, 1.0], 1.0), ([2.0, 4.0], 2.0), ([5.0, 6.0], 1.0), ([8.0, 9.0], 1.0)]);
        let other = of(&[([0.0, 4.0], 6.0), ([5.75, 6.0], 0.25), ([7.0, 7.5], 0.5)]);
        let [now, other] = [&now, &other].map(|(regions, surface)| Left { regions, surface });
        let found = compare(now, other, &Cancel::default()).unwrap();
        let vanish: Vec<bool> = (0..4).map(|i| found.vanishes(i)).collect();
        assert_eq!((vanish, found.new_regions), (vec![false, false, false, true], 1));
        // One part of three lies on the first, two on the second.
        for (remains, exact) in found.remains.iter().zip([2.0, 4.0, 0.25, 0.0]) {
            assert!((remains - exact).abs() < 0.1, "{:?}", found.remains);
        }
        assert!((found.remains[0] + found.remains[1] - 6.0).abs() < 1e-9);
    }
}
