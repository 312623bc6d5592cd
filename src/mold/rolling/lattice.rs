//! Balls let down on the mold at the points of a lattice: from where the search for lower ones starts.

use glam::{DVec2, IVec2};
use rayon::prelude::*;

use super::obstacles::Obstacles;
use crate::progress::{Cancel, Cancelled};

/// Heights of the centres of balls at rest.
pub struct Lattice {
    origin: DVec2,
    step: f64,
    counts: IVec2,
    centers: Vec<f32>,
}

impl Lattice {
    /// Balls of `radius` (mm) over all that they can touch, `step` apart (mm). Where there is nothing to rest on they
    /// lie at `floor`.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn new(obstacles: &Obstacles, radius: f64, step: f64, floor: f64, cancel: &Cancel) -> Result<Self, Cancelled> {
        let bounds = obstacles.faces.iter().map(|f| f.bounds());
        let [min, max] = bounds.reduce(|[a, b], [c, d]| [a.min(c), b.max(d)]).unwrap_or_default();
        let reach = radius + step;
        let origin = min.truncate() - reach;
        let counts = ((max.truncate() + reach - origin) / step).ceil().as_ivec2() + 1;
        let mut lattice = Self { origin, step, counts, centers: Vec::new() };
        // By bands of rows: every band looks at the faces it can touch.
        const BAND: i32 = 16;
        let bands: Vec<i32> = (0..counts.y).step_by(BAND as usize).collect();
        let rows = |&first: &i32| {
            cancel.check()?;
            Ok(lattice.band(obstacles, radius, floor, first..(first + BAND).min(counts.y)))
        };
        let centers: Result<Vec<Vec<f32>>, Cancelled> = bands.par_iter().map(rows).collect();
        lattice.centers = centers?.concat();
        Ok(lattice)
    }

    fn band(&self, obstacles: &Obstacles, radius: f64, floor: f64, rows: std::ops::Range<i32>) -> Vec<f32> {
        let width = self.counts.x as usize;
        let mut centers = vec![floor as f32; width * rows.len()];
        let (low, high) = (self.point(IVec2::new(0, rows.start)), self.point(IVec2::new(0, rows.end - 1)));
        let min = DVec2::new(f64::NEG_INFINITY, low.y - radius).extend(f64::NEG_INFINITY);
        let max = DVec2::new(f64::INFINITY, high.y + radius).extend(f64::INFINITY);
        obstacles.near(min, max, |face| {
            let [least, most] = face.bounds();
            let columns = self.span(least.x - radius, most.x + radius, self.origin.x, self.counts.x);
            let own = self.span(least.y - radius, most.y + radius, self.origin.y, self.counts.y);
            for y in own.start.max(rows.start)..own.end.min(rows.end) {
                for x in columns.clone() {
                    let at = &mut centers[(y - rows.start) as usize * width + x as usize];
                    if f64::from(*at) < most.z + radius
                        && let Some(z) = face.rest(self.point(IVec2::new(x, y)), radius)
                    {
                        *at = at.max(z as f32);
                    }
                }
            }
        });
        centers
    }

    fn span(&self, from: f64, to: f64, origin: f64, count: i32) -> std::ops::Range<i32> {
        let index = |v: f64| ((v - origin) / self.step).clamp(0.0, f64::from(count));
        index(from).ceil() as i32..(index(to).floor() as i32 + 1).min(count)
    }

    fn point(&self, at: IVec2) -> DVec2 {
        self.origin + at.as_dvec2() * self.step
    }

    /// Calls `found` with every point of the lattice within `reach` (mm) of `p` and the height of the centre there.
    pub fn within(&self, p: DVec2, reach: f64, mut found: impl FnMut(DVec2, f64)) {
        let columns = self.span(p.x - reach, p.x + reach, self.origin.x, self.counts.x);
        for y in self.span(p.y - reach, p.y + reach, self.origin.y, self.counts.y) {
            for x in columns.clone() {
                let at = self.point(IVec2::new(x, y));
                if at.distance_squared(p) <= reach * reach {
                    found(at, f64::from(self.centers[(y * self.counts.x + x) as usize]));
                }
            }
        }
    }
}
