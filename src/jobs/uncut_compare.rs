//! What another library of cutters would take away of what the present one leaves.

use glam::DVec3;

use super::uncut::Uncut;
use crate::geometry::exact::ExactMesh;
use crate::geometry::mesh::{Bounds, Mesh};
use crate::mold::surface::SurfacePiece;
use crate::mold::uncut_region::UncutRegion;
use crate::progress::{Cancel, Cancelled};

/// How many of the largest pieces of a region's surface are asked to whom they belong.
const ASKED: usize = 64;
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
    /// Whether the other library leaves nothing of region number `i` of the present one.
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
    let mut comparison = Comparison {
        remains: vec![0.0; now.regions.len()],
        volumes: [volume(now), volume(other)],
        regions: [now.regions.len(), other.regions.len()],
        new_regions: 0,
    };
    let known = Owners::new(now);
    let mut places: Vec<Vec<&SurfacePiece>> = vec![Vec::new(); other.regions.len()];
    for piece in other.surface {
        if let Some(own) = places.get_mut(piece.region as usize) {
            own.push(piece);
        }
    }
    // Along its boundary a surface is split finely, and where the two boundaries lie is as coarse as either grid.
    places.iter_mut().for_each(|own| own.sort_by(|a, b| b.area().total_cmp(&a.area())));
    for (region, places) in other.regions.iter().zip(&places) {
        cancel.check()?;
        let owner =
            if places.is_empty() { around(now.regions, region) } else { known.as_ref().and_then(|k| k.of(places)) };
        match owner {
            Some(owner) => comparison.remains[owner] += region.volume,
            None => comparison.new_regions += 1,
        }
    }
    Ok(comparison)
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

/// The surface under regions, to be asked whose a place is.
struct Owners<'a> {
    left: Left<'a>,
    surface: ExactMesh,
    reach: f64,
}

impl<'a> Owners<'a> {
    fn new(left: Left<'a>) -> Option<Self> {
        let vertices: Vec<DVec3> = left.surface.iter().flat_map(|p| p.corners).collect();
        let reach = SAME * Bounds::of(vertices.iter().copied()).size().length();
        let triangles = (0..left.surface.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        // Without any surface, or with none that can be asked, nothing is known.
        let surface = ExactMesh::new(&Mesh { vertices, triangles }).ok()?;
        Some(Self { left, surface, reach })
    }

    /// The region on which most of the first of `pieces` lie; none if most lie on none.
    fn of(&self, pieces: &[&SurfacePiece]) -> Option<usize> {
        let mut votes = vec![0usize; self.left.regions.len()];
        let mut strangers = 0;
        for piece in pieces.iter().take(ASKED) {
            let nearest = self.surface.nearest(piece.corners.iter().sum::<DVec3>() / 3.0);
            let owner = self.left.surface.get(nearest.triangle as usize).map(|p| p.region as usize);
            match owner.filter(|_| nearest.signed_distance.abs() <= self.reach).and_then(|i| votes.get_mut(i)) {
                Some(votes) => *votes += 1,
                None => strangers += 1,
            }
        }
        let most = (0..votes.len()).rev().max_by_key(|&i| votes[i])?;
        (votes[most] > 0 && votes[most] >= strangers).then_some(most)
    }
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
}
