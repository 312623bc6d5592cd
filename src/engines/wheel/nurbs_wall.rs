//! Walls of a channel as NURBS surfaces skinned over sections (P1), and how far they are from what they were made of.

use glam::DVec3;

use rayon::prelude::*;

use super::channel::{Channel, ChannelWall};
use super::sections::MeasuredSection;
use geometry::exact::ExactMesh;
use geometry::nurbs::{FitError, LineShape, NurbsCurve, NurbsError, NurbsSurface};
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

/// The point of a wall nearest to another point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfaceFoot {
    /// Parameters of the nearest point, along the chord and across the sections.
    pub at: [f64; 2],
    /// The nearest point (mm).
    pub point: DVec3,
    /// Height of the other point over the tangent plane there, positive along u x v: to the side of greater theta (mm).
    pub height: f64,
    /// Distance of the other point from the normal there: greater than 0 only beyond the border (mm).
    pub aside: f64,
}

/// A wall with the points that it was made from, where searches for nearest points begin.
pub struct WallFeet<'a> {
    wall: &'a NurbsWall,
    places: Vec<([f64; 2], DVec3)>,
}

impl WallFeet<'_> {
    /// The point of the wall nearest to `p`.
    pub fn foot(&self, p: DVec3) -> SurfaceFoot {
        let off = |place: &&([f64; 2], DVec3)| place.1.distance_squared(p);
        let start = self.places.iter().min_by(|a, b| off(a).total_cmp(&off(b)));
        self.wall.foot_from(p, start.map_or([0.0; 2], |place| place.0))
    }
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

    /// The low and the high wall of a channel.
    ///
    /// # Errors
    /// [`NurbsError`] if points of a wall coincide.
    pub fn of_channel(channel: &Channel) -> Result<[Self; 2], NurbsError> {
        Ok([Self::of_grid(&channel.low)?, Self::of_grid(&channel.high)?])
    }

    /// The wall through the grid of `wall`.
    ///
    /// # Errors
    /// [`NurbsError`] if points of the grid coincide.
    pub fn of_grid(wall: &ChannelWall) -> Result<Self, NurbsError> {
        let section = |v| (0..wall.nu).map(|u| wall.point(u, v)).collect();
        Self::skinned((0..wall.nv).map(section).collect(), &vec![LineShape::default(); wall.nv])
    }

    /// The low and the high wall through measured sections of given weights and end tangents, from the hub outwards. Where
    /// sections have different
    /// numbers of points, cubics through each of them take their place.
    ///
    /// # Errors
    /// [`MeasuredError`] if neighbouring points or sections coincide, or when cancelled.
    pub fn of_measured(sections: &[MeasuredSection], cancel: &Cancel) -> Result<[Self; 2], MeasuredError> {
        let low: Vec<&[DVec3]> = sections.iter().map(|s| s.low.as_slice()).collect();
        let high: Vec<&[DVec3]> = sections.iter().map(|s| s.high.as_slice()).collect();
        let [low_shapes, high_shapes] = [0, 1].map(|side| sections.iter().map(|s| s.shapes[side].clone()).collect());
        Ok([Self::of_sections(&low, low_shapes, cancel)?, Self::of_sections(&high, high_shapes, cancel)?])
    }

    fn of_sections(sections: &[&[DVec3]], mut shapes: Vec<LineShape>, cancel: &Cancel) -> Result<Self, MeasuredError> {
        let n = sections.iter().map(|s| s.len()).max().unwrap_or(0).min(Self::MOST_POINTS);
        if sections.iter().all(|s| s.len() == n) {
            return Ok(Self::skinned(sections.iter().map(|s| s.to_vec()).collect(), &shapes)?);
        }
        let resampled = sections.iter().zip(&shapes).map(|(points, shape)| {
            let curve = NurbsCurve::rational(points, shape)?;
            Ok((0..n).map(|i| curve.point(i as f64 / (n - 1) as f64)).collect())
        });
        let resampled = resampled.collect::<Result<_, NurbsError>>()?;
        // What the weights do is in the points now.
        shapes.iter_mut().for_each(|shape| shape.weights.clear());
        let mut wall = Self::skinned(resampled, &shapes)?;
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

    fn skinned(sections: Vec<Vec<DVec3>>, shapes: &[LineShape]) -> Result<Self, NurbsError> {
        let (surface, [u, v]) = NurbsSurface::skinned_as(&sections, shapes)?;
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

    /// The wall ready for nearest points.
    pub fn feet(&self) -> WallFeet<'_> {
        let places = self.u.iter().flat_map(|u| self.v.iter().map(move |v| [*u, *v]));
        WallFeet { wall: self, places: places.map(|at| (at, self.surface.point(at[0], at[1]))).collect() }
    }

    /// The point of the surface nearest to `p`, by Newton's method without second derivatives from the parameters
    /// `at`.
    fn foot_from(&self, p: DVec3, mut at: [f64; 2]) -> SurfaceFoot {
        const ROUNDS: usize = 40;
        let off = |[u, v]: [f64; 2]| self.surface.point(u, v).distance_squared(p);
        let mut distance = off(at);
        for _ in 0..ROUNDS {
            let step = self.step_towards(p, at);
            let shorter = |share: f64| [0, 1].map(|i| (at[i] + share * step[i]).clamp(0.0, 1.0));
            let mut tries = [1.0, 0.5, 0.25, 0.125].into_iter().map(shorter).map(|at| (off(at), at));
            let Some((nearer, next)) = tries.find(|(next, _)| *next < distance) else { break };
            (distance, at) = (nearer, next);
        }
        let [point, along_u, along_v] = self.surface.at(at[0], at[1]);
        let normal = along_u.cross(along_v).normalize_or_zero();
        let height = normal.dot(p - point);
        SurfaceFoot { at, point, height, aside: (p - point - height * normal).length() }
    }

    /// The step in the parameters from `at` to the foot of `p` in the tangent plane there, along the border where it
    /// leads out over it.
    fn step_towards(&self, p: DVec3, at: [f64; 2]) -> [f64; 2] {
        let [point, along_u, along_v] = self.surface.at(at[0], at[1]);
        let off = p - point;
        let (a, b, c) = (along_u.length_squared(), along_u.dot(along_v), along_v.length_squared());
        let (e, f) = (along_u.dot(off), along_v.dot(off));
        let determinant = a * c - b * b;
        let step = [(c * e - b * f) / determinant, (a * f - b * e) / determinant];
        let leads_out = |i: usize| (at[i] <= 0.0 && step[i] < 0.0) || (at[i] >= 1.0 && step[i] > 0.0);
        match [leads_out(0), leads_out(1)] {
            _ if !step.iter().all(|s| s.is_finite()) => [0.0; 2],
            [false, false] => step,
            [true, false] => [0.0, f / c],
            [false, true] => [e / a, 0.0],
            [true, true] => [0.0; 2],
        }
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
