//! Bounds on the motion of points of the electrode while every axis moves linearly, each with a constant error of which
//! no more than the greatest amount is known.

use std::f64::consts::{FRAC_PI_2, PI};

use glam::{DAffine3, DMat3, DVec3};

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
    /// Greatest error of each axis, in either sense (mm, rad).
    errors: [f64; 6],
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
///
/// Errors add, to first order, the derivatives of `p` by the axes at the middle of the window, times the errors. With
/// `e_s`, `e_a` and `e_w` the greatest errors of the slides together, of the table and of the tool's turns together, and
/// `R` greater by `e_s`, what that leaves out is at most
///
/// * `(e_a^2 R + 2 e_a (e_s + e_w reach) + e_w^2 reach) / 2`, of second order in the errors,
/// * `h (e_s a' + e_a (a' R + |d'| + w reach) + e_w (a' + w) reach)`, as the derivatives change over the window.
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
    /// What errors add; none where there are none.
    spread: Option<Spread>,
}

/// What errors of the axes add to the positions at the middle of a window.
struct Spread {
    /// Greatest errors (mm, rad).
    errors: [f64; 6],
    /// The axes at the middle of the window.
    pose: Pose,
    reference_point: DVec3,
    /// Derivatives of a position by the axes: those by the slides, of any point, and by the turns, `rate[k] * u + shift[k]`.
    slides: DMat3,
    rate: [DMat3; 3],
    shift: [DVec3; 3],
    /// Greatest distance by which errors move a point (mm).
    most: f64,
    /// How much of that is of second order (mm).
    second: f64,
}

/// A turn about one axis and its first two derivatives by the angle.
fn turn(angle: f64, about: fn(f64) -> DMat3, axis: DVec3) -> [DMat3; 3] {
    // The derivative is the turn by a right angle more, without the part that keeps the axis itself.
    let keep = DMat3::from_cols(axis * axis.x, axis * axis.y, axis * axis.z);
    [about(angle), about(angle + FRAC_PI_2) - keep, about(angle + PI) - keep]
}

impl Motion {
    pub(super) fn new(start: Pose, end: Pose, reference_point: DVec3, reach: f64) -> Self {
        Self { start, end, reference_point, reach, errors: [0.0; 6] }
    }

    /// The motion with errors of the axes up to these, in either sense (mm, rad).
    pub(super) fn with_errors(self, errors: [f64; 6]) -> Self {
        Self { errors, ..self }
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

        let [ex, ey, ez, error_a, eb, ec] = self.errors;
        let (error_s, error_w) = (DVec3::new(ex, ey, ez).length(), eb + ec);
        let (slides, turns, table) = (slide.length(), db.abs() + dc.abs(), da.abs());
        let radius = s.y.hypot(s.z) + half * slides + self.reach + error_s;
        let tool_speed = slides + turns * self.reach;
        let speed = table * radius + tool_speed;
        let third = table.powi(3) * radius
            + 3.0 * table * table * tool_speed
            + (3.0 * table + turns) * turns * turns * self.reach;
        let second = 0.5
            * (error_a * error_a * radius
                + 2.0 * error_a * (error_s + error_w * self.reach)
                + error_w * error_w * self.reach);
        let of_errors = second + half * (error_s * table + error_a * speed + error_w * (table + turns) * self.reach);
        let spread = (self.errors != [0.0; 6]).then(|| Spread {
            errors: self.errors,
            pose,
            reference_point: self.reference_point,
            slides: rx[0],
            rate: [rx[1] * q, rx[0] * rz[0] * ry[1], rx[0] * rz[1] * ry[0]],
            shift: [rx[1] * s, DVec3::ZERO, DVec3::ZERO],
            most: error_s + error_a * radius + error_w * self.reach,
            second,
        });
        Window {
            middle,
            travel: half * speed,
            rate: [rx[0] * q, x1 * q + rx[0] * q1, x2 * q + x1 * q1 * 2.0 + rx[0] * q2],
            shift: [rx[0] * s, x1 * s + rx[0] * slide, x2 * s + x1 * slide * 2.0],
            half,
            remainder: third * half.powi(3) / 6.0 + of_errors,
            spread,
        }
    }
}

impl Spread {
    /// From coordinates about O to W, with these errors.
    fn placement(&self, errors: [f64; 6]) -> DAffine3 {
        let axes = self.pose.to_array();
        let pose = Pose::from_array(std::array::from_fn(|i| axes[i] + errors[i]));
        pose.placement(self.reference_point) * DAffine3::from_translation(self.reference_point)
    }

    /// The derivative by each axis of the coordinate along `direction` of the point `u`.
    fn along(&self, direction: DVec3, u: DVec3) -> [f64; 6] {
        let [x, y, z] = (self.slides.transpose() * direction).to_array();
        let turned = |k: usize| direction.dot(self.rate[k] * u + self.shift[k]);
        [x, y, z, turned(0), turned(1), turned(2)]
    }

    /// How far errors move a point of the box along `direction`, at most (mm).
    fn of_box(&self, direction: DVec3, bounds: &OrientedBox) -> f64 {
        let slides = (self.slides.transpose() * direction).to_array();
        let turned = |k: usize| {
            let (along, offset) = (self.rate[k].transpose() * direction, direction.dot(self.shift[k]));
            (-(bounds.least_along(along) + offset)).max(offset - bounds.least_along(-along))
        };
        let rates = [slides[0].abs(), slides[1].abs(), slides[2].abs(), turned(0), turned(1), turned(2)];
        rates.iter().zip(self.errors).map(|(rate, error)| rate * error).sum()
    }

    fn of_point(&self, direction: DVec3, u: DVec3) -> f64 {
        self.along(direction, u).iter().zip(self.errors).map(|(rate, error)| rate.abs() * error).sum()
    }
}

impl Window {
    /// Turn and shift that carry the electrode from coordinates about O to W at the middle of the window.
    pub(super) fn placement(&self) -> (&DMat3, DVec3) {
        (&self.rate[0], self.shift[0])
    }

    /// Whether a shorter window makes no bound sharper than `resolution` (mm), or only what errors of second order leave
    /// unknown anyway.
    pub(super) fn is_exhausted(&self, resolution: f64) -> bool {
        let is_instant = self.half < 1e-12 || self.travel < 1e-3 * resolution;
        is_instant || self.spread.as_ref().is_some_and(|spread| self.travel < 0.1 * (resolution + spread.second))
    }

    /// How far errors move a point at most (mm).
    pub(super) fn error_reach(&self) -> f64 {
        self.spread.as_ref().map_or(0.0, |spread| spread.most)
    }

    /// The errors that move the point `u` furthest against `direction`, to first order; none where there are no errors.
    pub(super) fn worst_errors(&self, direction: DVec3, u: DVec3) -> Option<[f64; 6]> {
        let spread = self.spread.as_ref()?;
        let rates = spread.along(direction, u);
        Some(std::array::from_fn(|i| if rates[i] > 0.0 { -spread.errors[i] } else { spread.errors[i] }))
    }

    /// Positions of the points `u` at the middle of the window with these errors, in W; none where there are no errors.
    pub(super) fn placed_with(&self, errors: [f64; 6], u: &[DVec3; 3]) -> Option<[DVec3; 3]> {
        let placement = self.spread.as_ref()?.placement(errors);
        Some(u.map(|u| placement.transform_point3(u)))
    }

    /// Positions of the point `u` at the middle of the window with either of these errors, in W; none where there are none.
    pub(super) fn moved(&self, u: DVec3, errors: [[f64; 6]; 2]) -> Option<[DVec3; 2]> {
        let spread = self.spread.as_ref()?;
        Some(errors.map(|errors| spread.placement(errors).transform_point3(u)))
    }

    /// Positions of the points `u` at the middle of the window, in W.
    pub(super) fn placed(&self, u: &[DVec3; 3]) -> [DVec3; 3] {
        u.map(|u| self.rate[0] * u + self.shift[0])
    }

    /// A lower bound of `direction . p` over the whole window, all errors and all points of a triangle.
    pub(super) fn least_of_triangle(&self, direction: DVec3, triangle: &[DVec3; 3]) -> f64 {
        let along = Along::new(self, direction);
        // At any instant the motion is affine in the point, and so is what each error adds: the least is at a corner.
        let corner = |&u: &DVec3| {
            let [position, speed, acceleration] = std::array::from_fn(|k| along.direction[k].dot(u) + along.offset[k]);
            let by_errors = self.spread.as_ref().map_or(0.0, |spread| spread.of_point(direction, u));
            least_of_quadratic(position, speed, acceleration, self.half) - by_errors
        };
        triangle.iter().map(corner).fold(f64::INFINITY, f64::min) - self.remainder
    }

    /// A lower bound of `direction . p` over the whole window, all errors and all points of a box.
    pub(super) fn least_of_box(&self, direction: DVec3, bounds: &OrientedBox) -> f64 {
        let Along { direction: [g0, g1, g2], offset: [k0, k1, k2] } = Along::new(self, direction);
        let h = self.half;
        let least = |g: DVec3, k: f64| bounds.least_along(g) + k;
        // Position plus speed is linear in time, so least at an end; the acceleration can only take away
        // where it is negative.
        let linear = least(g0 + g1 * h, k0 + k1 * h).min(least(g0 - g1 * h, k0 - k1 * h));
        let by_errors = self.spread.as_ref().map_or(0.0, |spread| spread.of_box(direction, bounds));
        linear + 0.5 * h * h * least(g2, k2).min(0.0) - by_errors - self.remainder
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
            errors in any_pose(0.2, 0.02), shares in prop::collection::vec(-1.0..1.0f64, 21 * 6),
        ) {
            let errors = errors.to_array().map(f64::abs);
            let motion = Motion::new(start, end, O, REACH).with_errors(errors);
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
                // Errors at the ends of their ranges at every other instant, any within them at the others.
                let share = |i: usize| shares[6 * step + i];
                let share = |i: usize| if step % 2 == 0 { share(i).signum() } else { share(i) };
                let axes = motion.pose(t).to_array();
                let pose = Pose::from_array(std::array::from_fn(|i| axes[i] + share(i) * errors[i]));
                let placement = pose.placement(O);
                let at = |u: DVec3| placement.transform_point3(O + u);
                for (u, middle) in corners.iter().zip(window.placed(&corners)) {
                    prop_assert!(at(*u).distance(middle) <= window.travel + window.error_reach() + 1e-12);
                    prop_assert!(at(*u).dot(n) >= least_of_triangle - 1e-12);
                }
                for u in &in_box {
                    prop_assert!(at(*u).dot(n) >= least_of_box - 1e-12);
                }
            }
        }

        /// Of small errors nothing but their second order is given away.
        #[test]
        fn the_worst_errors_come_as_near_as_is_claimed(
            at in any_pose(1.0, 0.5), u in any_point(6.0), n in any_direction(), errors in any_pose(0.01, 2e-4),
        ) {
            let window = Motion::new(at, at, O, REACH).with_errors(errors.to_array().map(f64::abs)).window(0.0, 1.0);
            let worst = window.worst_errors(n, u).unwrap();
            let [p, ..] = window.placed_with(worst, &[u; 3]).unwrap();
            let claimed = window.least_of_triangle(n, &[u; 3]);
            prop_assert!(p.dot(n) >= claimed - 1e-12 && p.dot(n) - claimed < 2e-5, "{} {claimed}", p.dot(n));
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
