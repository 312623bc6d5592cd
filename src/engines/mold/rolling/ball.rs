//! How low a ball-end cutter comes.

use glam::{DVec2, DVec3, IVec2};

use super::halfspaces::{HalfSpace, nearest};
use super::obstacles::Obstacles;
use geometry::mesh::Mesh;
use task::{Cancel, Cancelled};

/// A ball-end cutter over a mold.
pub struct BallReach {
    obstacles: Obstacles,
    radius: f64,
    /// Where balls lie that rest on nothing (mm).
    floor: f64,
}

/// A position of the cutter and what it leaves at a place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lowest {
    /// Height of the cutter's surface over the place (mm).
    pub height: f64,
    /// Centre of the ball.
    pub center: DVec3,
}

/// Distance of the lattice's points, as a share of the radius.
const LATTICE: f64 = 0.25;
/// How much farther than the radius counts as covered, as a share of its square: coordinates of single precision.
const COVERED: f64 = 4e-6;
/// Gain of a step at which the descent is over, as a share of the radius.
const SETTLED: f64 = 1e-5;
/// How much lower than where another descent would start makes that one needless, as a share of the radius.
const FAR_LOWER: f64 = 0.5;
/// The longest step of a descent, and the shortest that it looks ahead, as shares of the radius.
const LONGEST_STEP: f64 = 0.25;
/// Shortest step of a march (mm).
const SHORTEST_STEP: f64 = 0.01;
/// Steps of descent after which it is left at that; every one of them is a valid position.
const MOST_STEPS: usize = 24;

impl BallReach {
    /// A ball of `radius` (mm) over `mesh`.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn new(mesh: &Mesh, radius: f64, cancel: &Cancel) -> Result<Self, Cancelled> {
        let floor = mesh.bounds().min.z - 4.0 * radius;
        Ok(Self { obstacles: Obstacles::new(mesh, radius, cancel)?, radius, floor })
    }

    /// The position in which the cutter comes lowest over `p`.
    pub fn lowest(&self, p: DVec2) -> Lowest {
        let r = self.radius;
        let mut inside = Lowest { height: f64::INFINITY, center: DVec3::INFINITY };
        let mut beside = inside;
        let reach = r * (1.0 + 1.5 * LATTICE);
        let lattice = Lattice::around(&self.obstacles, r, p, reach, LATTICE * r, self.floor);
        lattice.for_each(|at, z| {
            let rise = r * r - at.distance_squared(p);
            let best = if rise >= 0.0 { &mut inside } else { &mut beside };
            let height = z - rise.max(0.0).sqrt();
            if height < best.height {
                *best = Lowest { height, center: at.extend(z) };
            }
        });
        // A position just out of reach may be led to one within it that is lower than all of the lattice.
        let led = (beside.height < inside.height).then(|| self.descend(p, beside.center)).flatten();
        let is_far_lower = |led: &Lowest| inside.height - led.height > FAR_LOWER * r;
        let own = if inside.center.is_finite() && !led.as_ref().is_some_and(is_far_lower) {
            self.descend(p, inside.center)
        } else {
            None
        };
        led.into_iter().chain(own).min_by(|a, b| a.height.total_cmp(&b.height)).unwrap_or(inside)
    }

    /// The lowest position that descent from a free `center` leads to; none if it does not come to cover `p`.
    fn descend(&self, p: DVec2, mut center: DVec3) -> Option<Lowest> {
        let mut step = LONGEST_STEP * self.radius;
        let mut planes = Vec::new();
        for _ in 0..MOST_STEPS {
            self.planes_around(center, step, &mut planes);
            let Some(to) = self.lowest_between(&planes, p, center) else { break };
            let way = to - center;
            let moved = way * (step / way.length()).min(1.0);
            let before = self.height_over(p, center);
            center += moved;
            // What is farther off than some such steps is not met by the next one.
            step = (4.0 * moved.length()).clamp(SHORTEST_STEP * self.radius, LONGEST_STEP * self.radius);
            let is_there = before.zip(self.height_over(p, center)).is_some_and(|(a, b)| a - b < SETTLED * self.radius);
            if is_there || moved.length() < SETTLED * self.radius {
                break;
            }
        }
        self.height_over(p, center).map(|height| Lowest { height, center })
    }

    fn height_over(&self, p: DVec2, center: DVec3) -> Option<f64> {
        let rise = self.radius * self.radius - center.truncate().distance_squared(p);
        // At the foot of a wall the ball's side stands just over the place.
        (rise >= -COVERED * self.radius * self.radius).then(|| center.z - rise.max(0.0).sqrt())
    }

    /// Planes between the ball at `center` and every face that it could meet within `step` (mm).
    fn planes_around(&self, center: DVec3, step: f64, planes: &mut Vec<HalfSpace>) {
        planes.clear();
        let reach = self.radius + step;
        self.obstacles.near(center - reach, center + reach, |face| {
            let off = center - face.nearest(center);
            let distance = off.length();
            if distance < reach && distance > 0.0 {
                let normal = off / distance;
                let most = face.corners.iter().map(|v| normal.dot(*v)).fold(f64::NEG_INFINITY, f64::max);
                planes.push(HalfSpace { normal, offset: most + self.radius });
            }
        });
    }

    /// The best centre between `planes` for what is left over `p`, as seen from `center`; none if that is one already.
    fn lowest_between(&self, planes: &[HalfSpace], p: DVec2, center: DVec3) -> Option<DVec3> {
        let r = self.radius;
        let Some(height) = self.height_over(p, center) else {
            return nearest(planes, p.extend(center.z), &mut Vec::new());
        };
        let mut held = Vec::new();
        // The centre nearest to a point over p is as far from it as the radius where the cutter's surface is.
        let mut z = height - 1.5 * LONGEST_STEP * r;
        let mut best = None;
        for _ in 0..32 {
            let at = nearest(planes, p.extend(z), &mut held)?;
            let off = at - p.extend(z);
            let distance = off.length();
            best = Some(at);
            // The distance is a convex function of z: Newton's steps from below do not pass the root.
            if distance <= r * (1.0 + 1e-10) || off.z <= 0.0 {
                break;
            }
            z += (distance - r) * distance / off.z;
            if z > height {
                return None;
            }
        }
        best
    }
}

/// Heights of the centres of balls at rest around a place.
struct Lattice {
    /// Points of a lattice that all places share, and the heights of the centres there.
    centers: Vec<(DVec2, f64)>,
}

impl Lattice {
    /// Balls of `radius` (mm) at points `step` apart within `reach` of `p` (mm). Where there is nothing to rest on they
    /// lie at `floor`.
    fn around(obstacles: &Obstacles, radius: f64, p: DVec2, reach: f64, step: f64, floor: f64) -> Self {
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
    fn for_each(&self, mut found: impl FnMut(DVec2, f64)) {
        self.centers.iter().for_each(|(at, z)| found(*at, *z));
    }
}
