//! What another library of cutters would take away of what the present one leaves.

use glam::DVec3;

use super::uncut_regions::Left;
use crate::geometry::exact::ExactMesh;
use crate::geometry::mesh::{Bounds, Mesh};
use crate::progress::{Cancel, Cancelled};

/// Pieces of a region's surface that are asked to whom they belong.
const ASKED: usize = 64;
/// How far apart two surfaces of the same mold may lie and still be one, in parts of the diagonal.
const SAME: f64 = 1e-3;

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
pub fn compare(now: &Left, other: &Left, cancel: &Cancel) -> Result<Comparison, Cancelled> {
    let volume = |left: &Left| left.regions.iter().fold(0.0, |sum, r| sum + r.volume);
    let mut comparison = Comparison {
        remains: vec![0.0; now.regions.len()],
        volumes: [volume(now), volume(other)],
        regions: [now.regions.len(), other.regions.len()],
        new_regions: 0,
    };
    let known = Owners::new(now);
    let mut places: Vec<Vec<DVec3>> = vec![Vec::new(); other.regions.len()];
    for piece in &other.surface {
        if let Some(own) = places.get_mut(piece.region as usize) {
            own.push(piece.corners.iter().sum::<DVec3>() / 3.0);
        }
    }
    for (region, places) in other.regions.iter().zip(&places) {
        cancel.check()?;
        match known.as_ref().and_then(|known| known.of(places)) {
            Some(owner) => comparison.remains[owner] += region.volume,
            None => comparison.new_regions += 1,
        }
    }
    Ok(comparison)
}

/// The surface under regions, to be asked whose a place is.
struct Owners<'a> {
    left: &'a Left,
    surface: ExactMesh,
    reach: f64,
}

impl<'a> Owners<'a> {
    fn new(left: &'a Left) -> Option<Self> {
        let vertices: Vec<DVec3> = left.surface.iter().flat_map(|p| p.corners).collect();
        let reach = SAME * Bounds::of(vertices.iter().copied()).size().length();
        let triangles = (0..left.surface.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        // Without any surface, or with none that can be asked, nothing is known.
        let surface = ExactMesh::new(&Mesh { vertices, triangles }).ok()?;
        Some(Self { left, surface, reach })
    }

    /// The region on which most of some of `places` lie; none if most lie on none.
    fn of(&self, places: &[DVec3]) -> Option<usize> {
        let mut votes = vec![0usize; self.left.regions.len()];
        let mut strangers = 0;
        for place in places.iter().step_by(places.len().div_ceil(ASKED).max(1)) {
            let nearest = self.surface.nearest(*place);
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
    use crate::jobs::uncut_regions::LeftRegion;
    use crate::mold::surface::SurfacePiece;

    /// Triangles at places along X, each with the volume of its region.
    fn left(places: &[(f64, f64)]) -> Left {
        let region = |volume| LeftRegion {
            volume,
            plan_area: 1.0,
            depth: 1.0,
            bounds: Bounds::of([DVec3::ZERO]),
            nearest_cutter: None,
        };
        let piece = |(i, (x, _)): (usize, &(f64, f64))| SurfacePiece {
            corners: [DVec3::ZERO, DVec3::X, DVec3::Y].map(|p| p + x * DVec3::X),
            face: 0,
            region: i as u32,
            depth: [1.0; 3],
        };
        let regions = places.iter().map(|(_, volume)| region(*volume)).collect();
        Left { regions, surface: places.iter().enumerate().map(piece).collect() }
    }

    #[test]
    fn what_vanishes_what_remains_and_what_is_new_is_told_apart() {
        let now = left(&[(0.0, 4.0), (10.0, 3.0), (20.0, 2.0)]);
        let other = left(&[(20.0, 1.5), (0.0, 1.0), (50.0, 0.5)]);
        let compared = compare(&now, &other, &Cancel::default()).unwrap();
        assert_eq!(compared.remains, [1.0, 0.0, 1.5]);
        assert_eq!((compared.vanishing(), compared.vanishes(1), compared.new_regions), (1, true, 1));
        assert_eq!(compared.sentence(), "6.000 mm³ of 9.000 mm³ would be cut; 1 region vanishes, and 1 region is new.");
        let nothing = compare(&now, &left(&[]), &Cancel::default()).unwrap();
        assert_eq!((nothing.vanishing(), nothing.volumes), (3, [9.0, 0.0]));
        let worse = compare(&left(&[]), &now, &Cancel::default()).unwrap();
        assert_eq!((worse.new_regions, worse.vanishing()), (3, 0));
        assert!(worse.sentence().starts_with("9.000 mm³ more"));
    }
}
