//! Walls of a channel as NURBS surfaces skinned over sections (P1), and how far they are from what they were made of.

use glam::DVec3;

use rayon::prelude::*;

use super::channel::ChannelWall;
use super::sections::MeasuredSection;
use geometry::exact::ExactMesh;
use geometry::nurbs::{FitError, NurbsCurve, NurbsError, NurbsSurface};
use task::{Cancel, Cancelled};

/// A wall as a surface: `u` runs along the chord from the -X edge, `v` from the hub outwards.
#[derive(Debug, Clone, PartialEq)]
pub struct NurbsWall {
    /// The surface.
    pub surface: NurbsSurface,
    /// Parameters of the points along the chord.
    pub u: Vec<f64>,
    /// Parameters of the sections.
    pub v: Vec<f64>,
    /// Distances of the surface from `mesh`, which is in the same frame: at its points and half way between them.
    pub off_points: FitError,
}

/// Reason why there are no walls through measured sections.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum MeasuredError {
    /// Cancelled.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    /// A wall cannot be approximated by NURBS.
    #[error(transparent)]
    Nurbs(#[from] NurbsError),
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
    /// [`MeasuredError`] if neighbouring points or sections coincide, or when cancelled.
    pub fn of_measured(sections: &[MeasuredSection], cancel: &Cancel) -> Result<[Self; 2], MeasuredError> {
        let low: Vec<&[DVec3]> = sections.iter().map(|s| s.low.as_slice()).collect();
        let high: Vec<&[DVec3]> = sections.iter().map(|s| s.high.as_slice()).collect();
        Ok([Self::of_sections(&low, cancel)?, Self::of_sections(&high, cancel)?])
    }

    fn of_sections(sections: &[&[DVec3]], cancel: &Cancel) -> Result<Self, MeasuredError> {
        let n = sections.iter().map(|s| s.len()).max().unwrap_or(0).min(Self::MOST_POINTS);
        if sections.iter().all(|s| s.len() == n) {
            return Ok(Self::skinned(sections.iter().map(|s| s.to_vec()).collect())?);
        }
        let resampled = sections.iter().map(|points| {
            let curve = NurbsCurve::cubic(points, None)?;
            Ok((0..n).map(|i| curve.point(i as f64 / (n - 1) as f64)).collect())
        });
        let mut wall = Self::skinned(resampled.collect::<Result<_, NurbsError>>()?)?;
        let mut off = Vec::new();
        for (points, &v) in sections.iter().zip(&wall.v) {
            let places = wall.places_along(v);
            let distance = |p: &DVec3| {
                cancel.check()?;
                Ok(wall.distance_along(v, &places, *p))
            };
            off.extend(points.par_iter().map(distance).collect::<Result<Vec<f64>, Cancelled>>()?);
        }
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

    /// Evenly spaced points of the surface's curve at constant `v`.
    fn places_along(&self, v: f64) -> Vec<DVec3> {
        const PLACES: usize = 400;
        (0..=PLACES).map(|i| self.surface.point(i as f64 / PLACES as f64, v)).collect()
    }

    /// The distance of `p` from the surface's curve at constant `v`, of which `places` are evenly spaced points.
    fn distance_along(&self, v: f64, places: &[DVec3], p: DVec3) -> f64 {
        const ROUNDS: usize = 60;
        let distance = |u: f64| self.surface.point(u, v).distance_squared(p);
        let off = |i: usize| places[i].distance_squared(p);
        let last = places.len() - 1;
        let at = |i: usize| i as f64 / last as f64;
        let best = (0..=last).min_by(|a, b| off(*a).total_cmp(&off(*b))).unwrap_or(0);
        let (mut low, mut high) = (at(best.saturating_sub(1)), at((best + 1).min(last)));
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

    /// Distances of the surface from `mesh`, in the same frame: at its points and half way between them.
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
