//! Walls of a channel as NURBS surfaces skinned over sections (P1), and how far they are from what they were made of.

use glam::DVec3;

use super::channel::ChannelWall;
use super::sections::MeasuredSection;
use crate::geometry::exact::ExactMesh;
use crate::geometry::nurbs::{FitError, NurbsCurve, NurbsError, NurbsSurface};

/// A wall as a surface: `u` runs along the chord from the -X edge, `v` from the hub outwards.
#[derive(Debug, Clone, PartialEq)]
pub struct NurbsWall {
    /// The surface.
    pub surface: NurbsSurface,
    /// Parameters of the points along the chord.
    pub u: Vec<f64>,
    /// Parameters of the sections.
    pub v: Vec<f64>,
    /// How far the surface is from the points that it was made from.
    pub off_points: FitError,
}

impl NurbsWall {
    /// Most points along the chord that a wall is made from when its sections have different numbers of them.
    const MOST_POINTS: usize = 400;

    /// The wall through the grid of `wall`.
    ///
    /// # Errors
    /// [`NurbsError`] if points of the grid coincide.
    pub fn of_grid(wall: &ChannelWall) -> Result<Self, NurbsError> {
        let section = |v| (0..wall.nu).map(|u| wall.point(u, v)).collect();
        Self::skinned((0..wall.nv).map(section).collect())
    }

    /// The low and the high wall through measured sections, from the hub outwards. Where sections have different
    /// numbers of points, cubics through each of them take their place.
    ///
    /// # Errors
    /// [`NurbsError`] if neighbouring points or sections coincide.
    pub fn of_measured(sections: &[MeasuredSection]) -> Result<[Self; 2], NurbsError> {
        let low: Vec<&[DVec3]> = sections.iter().map(|s| s.low.as_slice()).collect();
        let high: Vec<&[DVec3]> = sections.iter().map(|s| s.high.as_slice()).collect();
        Ok([Self::of_sections(&low)?, Self::of_sections(&high)?])
    }

    fn of_sections(sections: &[&[DVec3]]) -> Result<Self, NurbsError> {
        let n = sections.iter().map(|s| s.len()).max().unwrap_or(0).min(Self::MOST_POINTS);
        if sections.iter().all(|s| s.len() == n) {
            return Self::skinned(sections.iter().map(|s| s.to_vec()).collect());
        }
        let resampled = sections.iter().map(|points| {
            let curve = NurbsCurve::cubic(points, None)?;
            Ok((0..n).map(|i| curve.point(i as f64 / (n - 1) as f64)).collect())
        });
        let mut wall = Self::skinned(resampled.collect::<Result<_, NurbsError>>()?)?;
        let off = sections.iter().zip(&wall.v).flat_map(|(points, &v)| {
            let wall = &wall;
            points.iter().map(move |p| wall.distance_along(v, *p))
        });
        wall.off_points = FitError::of(off);
        Ok(wall)
    }

    fn skinned(sections: Vec<Vec<DVec3>>) -> Result<Self, NurbsError> {
        let (surface, [u, v]) = NurbsSurface::skinned(&sections)?;
        let off = sections.iter().zip(&v).flat_map(|(section, &v)| {
            let surface = &surface;
            section.iter().zip(&u).map(move |(p, &u)| surface.point(u, v).distance(*p))
        });
        let off_points = FitError::of(off);
        Ok(Self { surface, u, v, off_points })
    }

    /// The distance of `p` from the surface's curve at constant `v`.
    fn distance_along(&self, v: f64, p: DVec3) -> f64 {
        const PLACES: usize = 400;
        const ROUNDS: usize = 60;
        let distance = |u: f64| self.surface.point(u, v).distance_squared(p);
        let at = |i: usize| i as f64 / PLACES as f64;
        let best = (0..=PLACES).min_by(|a, b| distance(at(*a)).total_cmp(&distance(at(*b)))).unwrap_or(0);
        let (mut low, mut high) = (at(best.saturating_sub(1)), at((best + 1).min(PLACES)));
        for _ in 0..ROUNDS {
            let (a, b) = (low + (high - low) / 3.0, high - (high - low) / 3.0);
            if distance(a) < distance(b) {
                high = b;
            } else {
                low = a;
            }
        }
        distance(0.5 * (low + high)).sqrt()
    }

    /// How far the surface is from `mesh`, which is in the same frame: at its points and half way between them.
    pub fn off_mesh(&self, mesh: &ExactMesh) -> FitError {
        let halved = |t: &[f64]| -> Vec<f64> {
            let between = t.windows(2).flat_map(|w| [w[0], 0.5 * (w[0] + w[1])]);
            between.chain(t.last().copied()).collect()
        };
        let (us, vs) = (halved(&self.u), halved(&self.v));
        let places = us.iter().flat_map(|u| vs.iter().map(move |v| (*u, *v)));
        FitError::of(places.map(|(u, v)| mesh.nearest(self.surface.point(u, v)).signed_distance))
    }
}
