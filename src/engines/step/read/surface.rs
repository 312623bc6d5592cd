//! Surfaces under faces, in a parameter plane of their own.
//!
//! Elementary surfaces keep the parameters of ISO 10303-42; all others are NURBS. A surface whose sides collapse to a
//! point has these poles at the ends of `v`, so that `u` is the direction around them.

use std::f64::consts::{FRAC_PI_2, TAU};

use geometry::nurbs::{KnotVector, NurbsCurve, NurbsSurface};
use glam::{DVec2, DVec3};

use super::clamp::{Row, clamped};

/// An orthonormal frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Axes {
    pub origin: DVec3,
    pub x: DVec3,
    pub y: DVec3,
    pub z: DVec3,
}

impl Axes {
    /// The frame with this origin, axis and a direction that is turned to be square to it; none where they are parallel.
    pub fn new(origin: DVec3, z: DVec3, towards: DVec3) -> Option<Self> {
        let z = z.try_normalize()?;
        let x = (towards - z * towards.dot(z)).try_normalize()?;
        origin.is_finite().then_some(Self { origin, x, y: z.cross(x), z })
    }

    /// Coordinates of `p` in this frame.
    fn local(&self, p: DVec3) -> DVec3 {
        let d = p - self.origin;
        DVec3::new(d.dot(self.x), d.dot(self.y), d.dot(self.z))
    }

    /// The unit vector square to the axis at angle `u` (rad), and its derivative.
    fn around(&self, u: f64) -> [DVec3; 2] {
        let (sin, cos) = u.sin_cos();
        [self.x * cos + self.y * sin, self.y * cos - self.x * sin]
    }
}

/// Form of a surface. Lengths are in the unit of the file, angles in radians.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Shape {
    Plane(Axes),
    Cylinder {
        axes: Axes,
        radius: f64,
    },
    /// `slope` is the growth of the radius along the axis.
    Cone {
        axes: Axes,
        radius: f64,
        slope: f64,
    },
    Sphere {
        axes: Axes,
        radius: f64,
    },
    Torus {
        axes: Axes,
        major: f64,
        minor: f64,
    },
    Nurbs(Box<NurbsSurface>),
}

/// A surface with its closed directions and poles.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Surface {
    pub shape: Shape,
    /// Lengths of the closed directions u and v.
    pub period: [Option<f64>; 2],
    /// Values of `v` at which the surface is a single point: below, and above, the rest of it.
    pub poles: [Option<f64>; 2],
    /// Whether u and v have changed places, which turns the normal over.
    pub is_flipped: bool,
    /// Distance along the normal `du x dv` at which the surface lies off the NURBS surface of its shape.
    pub offset: f64,
}

impl Surface {
    /// The elementary surface of this shape.
    pub fn elementary(shape: Shape) -> Self {
        let (period, poles) = match &shape {
            Shape::Plane(_) | Shape::Nurbs(_) => ([None, None], [None, None]),
            Shape::Cylinder { .. } => ([Some(TAU), None], [None, None]),
            Shape::Cone { radius, slope, .. } => {
                let apex = Some(-radius / slope);
                ([Some(TAU), None], if *slope > 0.0 { [apex, None] } else { [None, apex] })
            }
            Shape::Sphere { .. } => ([Some(TAU), None], [Some(-FRAC_PI_2), Some(FRAC_PI_2)]),
            Shape::Torus { .. } => ([Some(TAU), Some(TAU)], [None, None]),
        };
        Self { shape, period, poles, is_flipped: false, offset: 0.0 }
    }

    /// The surface at a distance from this NURBS surface, along the normal that the file gives it.
    pub fn offset_by(self, distance: f64) -> Self {
        Self { offset: if self.is_flipped { -distance } else { distance }, ..self }
    }

    /// The NURBS surface, its ends taken for one where they lie within `tolerance` of each other. None if it is none.
    pub fn nurbs(from: &step_io::scene::NurbsSurface, tolerance: f64) -> Option<Self> {
        let net = Net::of(from)?;
        let [rows, columns] = [net.points.len(), net.points.first()?.0.len()];
        let homogeneous = |i: usize, j: usize| net.points.get(i).and_then(|r| r.0.get(j)).copied();
        let point = |i: usize, j: usize| homogeneous(i, j).map(|p| p.truncate() / p.w);
        let at_side = |i: Option<usize>, j: Option<usize>| -> Option<bool> {
            let count = if i.is_some() { columns } else { rows };
            let first = point(i.unwrap_or(0), j.unwrap_or(0))?;
            let all: Option<Vec<DVec3>> = (0..count).map(|k| point(i.unwrap_or(k), j.unwrap_or(k))).collect();
            Some(all?.iter().all(|p| p.distance(first) <= tolerance))
        };
        let u_poles = [at_side(Some(0), None)?, at_side(Some(rows - 1), None)?];
        let v_poles = [at_side(None, Some(0))?, at_side(None, Some(columns - 1))?];
        let is_flipped = (u_poles[0] || u_poles[1]) && !(v_poles[0] || v_poles[1]);
        let [count_u, count_v] = if is_flipped { [columns, rows] } else { [rows, columns] };
        let pick = |i: usize, j: usize| if is_flipped { (j, i) } else { (i, j) };
        let (mut points, mut weights) = (Vec::new(), Vec::new());
        for (i, j) in (0..count_u).flat_map(|i| (0..count_v).map(move |j| pick(i, j))) {
            points.push(point(i, j)?);
            weights.push(homogeneous(i, j)?.w);
        }
        let [knots_u, knots_v] = net.knots;
        let mut knots = [KnotVector::new(from.degree_u, knots_u).ok()?, KnotVector::new(from.degree_v, knots_v).ok()?];
        if is_flipped {
            knots.reverse();
        }
        let [u, v] = knots;
        let surface = NurbsSurface::new(u, v, &points, &weights).ok()?;
        let domain = surface.domain();
        let poles = if is_flipped { u_poles } else { v_poles };
        let sides = |k: usize| domain[1][k];
        let poles = [poles[0].then(|| sides(0)), poles[1].then(|| sides(1))];
        let closes = |across: usize| {
            let [from, to] = domain[across];
            let [low, high] = domain[1 - across];
            let place =
                |along: f64, k: f64| if across == 0 { surface.point(k, along) } else { surface.point(along, k) };
            let places = (0..=16).map(|k| low + (high - low) * f64::from(k) / 16.0);
            places.into_iter().all(|p| place(p, from).distance(place(p, to)) <= tolerance)
        };
        let period = [0, 1].map(|k| closes(k).then(|| domain[k][1] - domain[k][0]));
        // What is a pole on one side and closed the other way is no ring there.
        let period = if poles.iter().any(Option::is_some) { [period[0], None] } else { period };
        Some(Self { shape: Shape::Nurbs(Box::new(surface)), period, poles, is_flipped, offset: 0.0 })
    }

    /// Point and both derivatives at `uv`.
    pub fn at(&self, uv: DVec2) -> [DVec3; 3] {
        let (u, v) = (uv.x, uv.y);
        match &self.shape {
            Shape::Plane(a) => [a.origin + a.x * u + a.y * v, a.x, a.y],
            Shape::Cylinder { axes, radius } => {
                let [out, on] = axes.around(u);
                [axes.origin + out * *radius + axes.z * v, on * *radius, axes.z]
            }
            Shape::Cone { axes, radius, slope } => {
                let [out, on] = axes.around(u);
                let r = radius + v * slope;
                [axes.origin + out * r + axes.z * v, on * r, out * *slope + axes.z]
            }
            Shape::Sphere { axes, radius } => {
                let [out, on] = axes.around(u);
                let (sin, cos) = v.sin_cos();
                let point = axes.origin + (out * cos + axes.z * sin) * *radius;
                [point, on * (radius * cos), (axes.z * cos - out * sin) * *radius]
            }
            Shape::Torus { axes, major, minor } => {
                let [out, on] = axes.around(u);
                let (sin, cos) = v.sin_cos();
                let r = major + minor * cos;
                let point = axes.origin + out * r + axes.z * (minor * sin);
                [point, on * r, (axes.z * cos - out * sin) * *minor]
            }
            Shape::Nurbs(s) => {
                let [u, v] = self.within(s, uv);
                if self.offset == 0.0 { s.at(u, v) } else { self.beside(s, [u, v]) }
            }
        }
    }

    /// The point at `uv`.
    pub fn point(&self, uv: DVec2) -> DVec3 {
        match &self.shape {
            Shape::Nurbs(s) if self.offset == 0.0 => {
                let [u, v] = self.within(s, uv);
                s.point(u, v)
            }
            _ => self.at(uv)[0],
        }
    }

    /// Point and both derivatives beside a NURBS surface, at the offset along its normal.
    fn beside(&self, s: &NurbsSurface, [u, v]: [f64; 2]) -> [DVec3; 3] {
        let [mut p, mut du, mut dv, mut duu, mut duv, mut dvv] = s.with_second(u, v);
        let mut across = du.cross(dv);
        if across.length_squared() <= 1e-24 * du.length_squared().max(dv.length_squared()).powi(2) {
            // At a pole the normal is that of the places beside it.
            let inwards = |k: usize, at: f64| {
                let [low, high] = s.domain()[k];
                at + 1e-6 * (high - low) * if at > 0.5 * (low + high) { -1.0 } else { 1.0 }
            };
            [_, du, dv, duu, duv, dvv] = s.with_second(inwards(0, u), inwards(1, v));
            across = du.cross(dv);
            p = s.point(u, v);
        }
        let Some(normal) = across.try_normalize() else { return [p, du, dv] };
        // Derivatives of a unit vector along `across`.
        let turn = |of_across: DVec3| (of_across - normal * normal.dot(of_across)) / across.length();
        let along_u = turn(duu.cross(dv) + du.cross(duv));
        let along_v = turn(duv.cross(dv) + du.cross(dvv));
        [p + normal * self.offset, du + along_u * self.offset, dv + along_v * self.offset]
    }

    /// Parameters within the domain of a NURBS surface: carried round in closed directions, held at the ends of others.
    fn within(&self, s: &NurbsSurface, uv: DVec2) -> [f64; 2] {
        let held = |k: usize| {
            let ([low, high], value) = (s.domain()[k], uv[k]);
            let value = match self.period[k] {
                Some(period) if !(low..=high).contains(&value) => low + (value - low).rem_euclid(period),
                _ => value,
            };
            value.clamp(low, high)
        };
        [held(0), held(1)]
    }

    /// Parameters of the point of the surface beside `p`, of all equal ones the nearest to `near`.
    pub fn locate(&self, p: DVec3, near: DVec2) -> DVec2 {
        let found = match &self.shape {
            Shape::Plane(a) => {
                let q = a.local(p);
                DVec2::new(q.x, q.y)
            }
            Shape::Cylinder { axes, .. } => {
                let q = axes.local(p);
                DVec2::new(q.y.atan2(q.x), q.z)
            }
            Shape::Cone { axes, radius, slope } => {
                let q = axes.local(p);
                // Beyond the tip the surface lies on the other side of the axis.
                let side = if radius + slope * q.z < 0.0 { -1.0 } else { 1.0 };
                DVec2::new((q.y * side).atan2(q.x * side), q.z)
            }
            Shape::Sphere { axes, .. } => {
                let q = axes.local(p);
                DVec2::new(q.y.atan2(q.x), q.z.atan2(q.x.hypot(q.y)))
            }
            Shape::Torus { axes, major, .. } => {
                let q = axes.local(p);
                DVec2::new(q.y.atan2(q.x), q.z.atan2(q.x.hypot(q.y) - major))
            }
            Shape::Nurbs(s) => self.foot(s, p, near),
        };
        let turned = |k: usize| self.period[k].map_or(0.0, |t| ((near[k] - found[k]) / t).round() * t);
        found + DVec2::new(turned(0), turned(1))
    }

    /// Parameters of the point beside `p` where nothing is known of its neighbours.
    pub fn locate_anywhere(&self, p: DVec3) -> DVec2 {
        let Shape::Nurbs(s) = &self.shape else { return self.locate(p, DVec2::ZERO) };
        let looks = [0, 1].map(|k| places(s, k));
        let mut starts: Vec<(f64, DVec2)> = Vec::new();
        for uv in looks[0].iter().flat_map(|u| looks[1].iter().map(|v| DVec2::new(*u, *v))) {
            starts.push((self.point(uv).distance_squared(p), uv));
        }
        starts.sort_by(|a, b| a.0.total_cmp(&b.0));
        let feet = starts.iter().take(8).map(|(_, start)| self.foot(s, p, *start));
        let far = |uv: &DVec2| self.point(*uv).distance_squared(p);
        feet.min_by(|a, b| far(a).total_cmp(&far(b))).unwrap_or(DVec2::ZERO)
    }

    /// The foot of `p` on a NURBS surface, by Gauss and Newton from `start`, with steps that never lead farther away.
    fn foot(&self, s: &NurbsSurface, p: DVec3, start: DVec2) -> DVec2 {
        const ROUNDS: usize = 40;
        let hold = |mut uv: DVec2| {
            for k in 0..2 {
                if self.period[k].is_none() {
                    uv[k] = uv[k].clamp(s.domain()[k][0], s.domain()[k][1]);
                }
            }
            uv
        };
        let size = |k: usize| s.domain()[k][1] - s.domain()[k][0];
        let mut uv = hold(start);
        let mut here = self.at(uv);
        for _ in 0..ROUNDS {
            let [point, du, dv] = here;
            let off = p - point;
            let (a, b, c) = (du.dot(du), du.dot(dv), dv.dot(dv));
            let (e, f) = (du.dot(off), dv.dot(off));
            let det = a * c - b * b;
            let step = if det > 1e-12 * a * c {
                DVec2::new((e * c - f * b) / det, (a * f - b * e) / det)
            } else {
                DVec2::new(if a > 0.0 { e / a } else { 0.0 }, if c > 0.0 { f / c } else { 0.0 })
            };
            // At a pole the parameter around it may be anything: no step leads farther than half around.
            let reach = DVec2::new(0.5 * size(0), 0.5 * size(1));
            let step = step.clamp(-reach, reach);
            let mut share = 1.0;
            let next = loop {
                let next = hold(uv + step * share);
                let there = self.at(next);
                if there[0].distance_squared(p) <= off.length_squared() || share < 1e-3 {
                    break (next, there);
                }
                share *= 0.5;
            };
            let moved = (next.0 - uv).abs();
            let is_still = moved.x <= 1e-12 * size(0) && moved.y <= 1e-12 * size(1);
            if next.1[0].distance_squared(p) > off.length_squared() {
                break;
            }
            (uv, here) = next;
            if is_still {
                break;
            }
        }
        uv
    }

    /// Both guides of a NURBS surface that is ruled, over the box of parameters from `low` to `high`: rulings join equal
    /// parameters. Two pairs where it is ruled both ways; none of any other surface, nor where the box crosses a seam.
    pub fn guides(&self, [low, high]: [DVec2; 2]) -> Vec<[NurbsCurve; 2]> {
        let Shape::Nurbs(s) = &self.shape else { return Vec::new() };
        if self.offset != 0.0 {
            return Vec::new();
        }
        let slack = |k: usize| 1e-9 * (s.domain()[k][1] - s.domain()[k][0]);
        let is_within = |k: usize| low[k] >= s.domain()[k][0] - slack(k) && high[k] <= s.domain()[k][1] + slack(k);
        if !is_within(0) || !is_within(1) {
            return Vec::new();
        }
        let corner = |end: usize| DVec2::new(s.domain()[0][end], s.domain()[1][end]);
        let [low, high] = [low, high].map(|uv| uv.clamp(corner(0), corner(1)));
        let is_straight = |k: &usize| s.knots(*k).degree() == 1 && s.knots(*k).count() == 2;
        let pairs = [1, 0].into_iter().filter(is_straight).filter_map(|across| {
            let guide = |at: f64| s.curve(1 - across, at).between(low[1 - across], high[1 - across]).ok();
            Some([guide(low[across])?, guide(high[across])?])
        });
        pairs.collect()
    }

    /// Places in the closed interval `range` of direction `k` between which the form may change.
    pub fn joints(&self, k: usize, range: [f64; 2]) -> Vec<f64> {
        let mut all = vec![range[0], range[1]];
        if let Shape::Nurbs(s) = &self.shape {
            let joints = s.joints(k);
            let turns: Vec<f64> = match self.period[k] {
                Some(period) => (-2..=2).map(|i| f64::from(i) * period).collect(),
                None => vec![0.0],
            };
            all.extend(turns.iter().flat_map(|t| joints.iter().map(move |j| j + t)));
        }
        all.retain(|x| (range[0]..=range[1]).contains(x));
        all.sort_by(f64::total_cmp);
        all.dedup();
        all
    }
}

/// Homogeneous control points of a NURBS surface, a row for each along u, and its knots, all ends repeated.
struct Net {
    points: Vec<Row>,
    knots: [Vec<f64>; 2],
}

impl Net {
    fn of(from: &step_io::scene::NurbsSurface) -> Option<Self> {
        let rows = from.control_points.iter().zip(&from.weights).map(|(points, weights)| {
            Row(points.iter().zip(weights).map(|(p, w)| (DVec3::from(*p) * *w).extend(*w)).collect())
        });
        let (knots_u, rows) = clamped(from.degree_u, from.knots_u.clone(), rows.collect())?;
        let (knots_v, columns) = clamped(from.degree_v, from.knots_v.clone(), transposed(&rows)?)?;
        Some(Self { points: transposed(&columns)?, knots: [knots_u, knots_v] })
    }
}

/// Rows of the columns; none where rows are not equally long.
fn transposed(rows: &[Row]) -> Option<Vec<Row>> {
    let count = rows.first()?.0.len();
    let is_even = rows.iter().all(|row| row.0.len() == count);
    is_even.then(|| (0..count).map(|k| Row(rows.iter().map(|row| row.0[k]).collect())).collect())
}

/// Places in direction `k` of a NURBS surface near one of which Newton's method finds a foot: three to a piece.
fn places(s: &NurbsSurface, k: usize) -> Vec<f64> {
    const MOST: usize = 60;
    let joints = s.joints(k);
    let parts = (MOST / joints.len().max(1)).clamp(1, 3);
    let mut all: Vec<f64> = Vec::new();
    for w in joints.windows(2) {
        all.extend((0..parts).map(|i| w[0] + (w[1] - w[0]) * i as f64 / parts as f64));
    }
    all.extend(joints.last());
    all
}
