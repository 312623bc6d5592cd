//! Bounds on the motion of points of the electrode while every axis moves linearly.

use std::f64::consts::{FRAC_PI_2, PI};

use glam::{DMat3, DVec3};

use crate::pose::Pose;
use geometry::bvh::OrientedBox;

/// The motion from one pose to another, linear in every axis.
///
/// A point `u` of the electrode, relative to the reference point O, is at
/// `p(t) = Rx(a) w`, `w = s + Q u`, with `s = O + (x, y, z)` and `Q = Rz(c) Ry(b)` at time `t` in [0, 1].
pub(super) struct Motion {
    start: Pose,
    end: Pose,
    reference_point: DVec3,
    /// Greatest distance of a point of the electrode from O (mm).
    reach: f64,
}

/// A window of time of a [`Motion`]: all points of the electrode as quadratic functions of time about its
/// middle, and bounds of what these leave out.
///
/// With `h` half the window's length, and rates `|d'|` of the slides, `w = |b'| + |c'|` of the tool's turns and
/// `a'` of the table's turn, all constant: turns and their derivatives by the angle have norm 1, so
/// `|s'| = |d'|`, `|Q'| <= w`, `|Q''| <= w^2`, `|Q'''| <= w^3`. With `reach` the greatest `|u|` and
/// `R = |s_yz| + h |d'| + reach` the greatest distance from the X axis in the window, differentiating the
/// product `Rx(a) w` gives
///
/// * `|p'|   <= a' R + |d'| + w reach`,
/// * `|p'''| <= a'^3 R + 3 a'^2 (|d'| + w reach) + 3 a' w^2 reach + w^3 reach`.
///
/// The first times `h` bounds the travel from the middle; the second times `h^3 / 6` bounds, by Taylor's
/// theorem for the coordinate along any direction, what the quadratic leaves out.
pub(super) struct Window {
    /// Middle of the window, as a fraction of the motion.
    pub middle: f64,
    /// Greatest distance of a point of the electrode from its position at the middle of the window (mm).
    pub travel: f64,
    /// Position, velocity and acceleration at the middle are `rate[k] * u + shift[k]` (mm per motion^k).
    rate: [DMat3; 3],
    shift: [DVec3; 3],
    half: f64,
    remainder: f64,
}

/// A turn about one axis and its first two derivatives by the angle.
fn turn(angle: f64, about: fn(f64) -> DMat3, axis: DVec3) -> [DMat3; 3] {
    // The derivative is the turn by a right angle more, without the part that keeps the axis itself.
    let keep = DMat3::from_cols(axis * axis.x, axis * axis.y, axis * axis.z);
    [about(angle), about(angle + FRAC_PI_2) - keep, about(angle + PI) - keep]
}

impl Motion {
    pub(super) fn new(start: Pose, end: Pose, reference_point: DVec3, reach: f64) -> Self {
        Self { start, end, reference_point, reach }
    }

    /// The pose at time `t`.
    pub(super) fn pose(&self, t: f64) -> Pose {
        self.start.lerp(&self.end, t)
    }

    /// The window from `from` to `to`, within [0, 1].
    pub(super) fn window(&self, from: f64, to: f64) -> Window {
        let (middle, half) = (0.5 * (from + to), 0.5 * (to - from));
        let pose = self.pose(middle);
        let [dx, dy, dz, da, db, dc] = std::array::from_fn(|i| self.end.to_array()[i] - self.start.to_array()[i]);
        let slide = DVec3::new(dx, dy, dz);
        let s = self.reference_point + DVec3::new(pose.x, pose.y, pose.z);

        let ry = turn(pose.b, DMat3::from_rotation_y, DVec3::Y);
        let rz = turn(pose.c, DMat3::from_rotation_z, DVec3::Z);
        let rx = turn(pose.a, DMat3::from_rotation_x, DVec3::X);
        let q = rz[0] * ry[0];
        let q1 = rz[1] * ry[0] * dc + rz[0] * ry[1] * db;
        let q2 = rz[2] * ry[0] * (dc * dc) + rz[1] * ry[1] * (2.0 * dc * db) + rz[0] * ry[2] * (db * db);
        let (x1, x2) = (rx[1] * da, rx[2] * (da * da));

        let (slides, turns, table) = (slide.length(), db.abs() + dc.abs(), da.abs());
        let radius = s.y.hypot(s.z) + half * slides + self.reach;
        let tool_speed = slides + turns * self.reach;
        let third = table.powi(3) * radius
            + 3.0 * table * table * tool_speed
            + (3.0 * table + turns) * turns * turns * self.reach;
        Window {
            middle,
            travel: half * (table * radius + tool_speed),
            rate: [rx[0] * q, x1 * q + rx[0] * q1, x2 * q + x1 * q1 * 2.0 + rx[0] * q2],
            shift: [rx[0] * s, x1 * s + rx[0] * slide, x2 * s + x1 * slide * 2.0],
            half,
            remainder: third * half.powi(3) / 6.0,
        }
    }
}

impl Window {
    /// Whether the window is so short that halving it would only add rounding.
    pub(super) fn is_instant(&self) -> bool {
        self.half < 1e-12
    }

    /// Turn and shift that carry the electrode from coordinates about O to W at the middle of the window.
    pub(super) fn placement(&self) -> (&DMat3, DVec3) {
        (&self.rate[0], self.shift[0])
    }

    /// Positions of the points `u` at the middle of the window, in W.
    pub(super) fn placed(&self, u: &[DVec3; 3]) -> [DVec3; 3] {
        u.map(|u| self.rate[0] * u + self.shift[0])
    }

    /// A lower bound of `direction . p` over the whole window and over all points of a triangle.
    pub(super) fn least_of_triangle(&self, direction: DVec3, triangle: &[DVec3; 3]) -> f64 {
        let along = Along::new(self, direction);
        // At any instant the motion is affine in the point, so the least is at a corner.
        let corner = |&u: &DVec3| {
            let [position, speed, acceleration] = std::array::from_fn(|k| along.direction[k].dot(u) + along.offset[k]);
            least_of_quadratic(position, speed, acceleration, self.half)
        };
        triangle.iter().map(corner).fold(f64::INFINITY, f64::min) - self.remainder
    }

    /// A lower bound of `direction . p` over the whole window and over all points of a box.
    pub(super) fn least_of_box(&self, direction: DVec3, bounds: &OrientedBox) -> f64 {
        let Along { direction: [g0, g1, g2], offset: [k0, k1, k2] } = Along::new(self, direction);
        let h = self.half;
        let least = |g: DVec3, k: f64| bounds.least_along(g) + k;
        // Position plus speed is linear in time, so least at an end; the acceleration can only take away
        // where it is negative.
        let linear = least(g0 + g1 * h, k0 + k1 * h).min(least(g0 - g1 * h, k0 - k1 * h));
        linear + 0.5 * h * h * least(g2, k2).min(0.0) - self.remainder
    }
}

/// Position, velocity and acceleration along a direction: `direction[k] . u + offset[k]`.
struct Along {
    direction: [DVec3; 3],
    offset: [f64; 3],
}

impl Along {
    fn new(window: &Window, n: DVec3) -> Self {
        Self {
            direction: window.rate.map(|m| DVec3::new(m.x_axis.dot(n), m.y_axis.dot(n), m.z_axis.dot(n))),
            offset: window.shift.map(|s| s.dot(n)),
        }
    }
}

/// The least of `p + v t + a t^2 / 2` for `|t| <= h`.
fn least_of_quadratic(p: f64, v: f64, a: f64, h: f64) -> f64 {
    if a * h > v.abs() { p - 0.5 * v * v / a } else { p - v.abs() * h + 0.5 * a * h * h }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::verify::tests::{any_direction, any_point, any_pose};
    use proptest::prelude::*;

    const O: DVec3 = DVec3::new(3.0, -1.0, 40.0);
    const REACH: f64 = 12.0;

    proptest! {
        #[test]
        fn bounds_hold_at_every_instant_and_point(
            start in any_pose(5.0, 1.0), end in any_pose(5.0, 1.0), from in 0.0..0.9f64, length in 0.01..0.5f64,
            corners in [any_point(6.0), any_point(6.0), any_point(6.0)], n in any_direction(),
        ) {
            let motion = Motion::new(start, end, O, REACH);
            let window = motion.window(from, (from + length).min(1.0));
            let bounds = OrientedBox {
                center: corners[0],
                axes: DMat3::from_rotation_y(corners[1].x),
                half: corners[2].abs() * 0.2,
            };
            let (least_of_triangle, least_of_box) =
                (window.least_of_triangle(n, &corners), window.least_of_box(n, &bounds));
            let in_box = (0..8).map(|i| {
                let sign = |bit: i32| if i >> bit & 1 == 1 { 1.0 } else { -1.0 };
                bounds.center + bounds.axes * (bounds.half * DVec3::new(sign(0), sign(1), sign(2)))
            });
            let in_box: Vec<_> = in_box.collect();
            for step in 0..=20 {
                let t = from + ((from + length).min(1.0) - from) * step as f64 / 20.0;
                let placement = motion.pose(t).placement(O);
                let at = |u: DVec3| placement.transform_point3(O + u);
                for (u, middle) in corners.iter().zip(window.placed(&corners)) {
                    prop_assert!(at(*u).distance(middle) <= window.travel + 1e-12);
                    prop_assert!(at(*u).dot(n) >= least_of_triangle - 1e-12);
                }
                for u in &in_box {
                    prop_assert!(at(*u).dot(n) >= least_of_box - 1e-12);
                }
            }
        }

        #[test]
        fn the_bound_of_a_triangle_is_tight(
            start in any_pose(1.0, 0.02), end in any_pose(1.0, 0.02), corners in [any_point(6.0), any_point(6.0), any_point(6.0)],
            n in any_direction(),
        ) {
            let motion = Motion::new(start, end, O, REACH);
            let bound = motion.window(0.0, 1.0).least_of_triangle(n, &corners);
            let sampled = (0..=1000).flat_map(|i| {
                let placement = motion.pose(i as f64 / 1000.0).placement(O);
                corners.map(|u| placement.transform_point3(O + u).dot(n))
            });
            // Three turns of 0.04 rad at up to 60 mm and slides of 3.5 mm: third-order terms are below
            // (0.12^3 * 60 + 3 * 0.12^2 * 3.5) / 48 = 5.3e-3 mm, where a bound of first order would be off by mm.
            let sampled = sampled.fold(f64::INFINITY, f64::min);
            prop_assert!(sampled - bound < 5.5e-3, "{sampled} {bound}");
        }
    }
}
