//! Balls let down on the mold at the points of a lattice: from where the search for lower ones starts.

use glam::{DVec2, IVec2};

use super::obstacles::Obstacles;

/// Heights of the centres of balls at rest around a place.
pub struct Lattice {
    /// Points of a lattice that all places share, and the heights of the centres there.
    centers: Vec<(DVec2, f64)>,
}

impl Lattice {
    /// Balls of `radius` (mm) at points `step` apart within `reach` of `p` (mm). Where there is nothing to rest on they
    /// lie at `floor`.
    pub fn around(obstacles: &Obstacles, radius: f64, p: DVec2, reach: f64, step: f64, floor: f64) -> Self {
        let [low, high] = [(p - reach) / step, (p + reach) / step];
        let (low, high) = (low.ceil().as_ivec2(), high.floor().as_ivec2());
        let points = (low.y..=high.y).flat_map(|y| (low.x..=high.x).map(move |x| IVec2::new(x, y).as_dvec2() * step));
        let mut centers: Vec<(DVec2, f64)> =
            points.filter(|at| at.distance(p) <= reach).map(|at| (at, floor)).collect();
        let far = reach + radius;
        obstacles.near((p - far).extend(f64::NEG_INFINITY), (p + far).extend(f64::INFINITY), |face| {
            let [least, most] = face.bounds();
            let (least, top, most) = (least.truncate() - radius, most.z + radius, most.truncate() + radius);
            for (at, z) in &mut centers {
                if *z < top
                    && at.cmpge(least).all()
                    && at.cmple(most).all()
                    && let Some(rest) = face.rest(*at, radius)
                {
                    *z = z.max(rest);
                }
            }
        });
        Self { centers }
    }

    /// Calls `found` with every point and the height of the centre there.
    pub fn for_each(&self, mut found: impl FnMut(DVec2, f64)) {
        self.centers.iter().for_each(|(at, z)| found(*at, *z));
    }
}
