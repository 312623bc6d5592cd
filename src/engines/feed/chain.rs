//! The kinematic chain of a machine about one electrode: what moves how, and the axis values of the machine that make a
//! pose of the electrode.
//!
//! On every machine A carries the blisk, and the head X, Y and Z. C turns the electrode, or a table under A: a cradle that
//! carries A, as on a tilting table. B tilts the electrode. With O the reference point, `Q` the place where the C axis of
//! the table is in the final pose, and `s` the slides of a pose, the point p of the electrode is, as seen from the blisk,
//! at `Rx(a) (O + s + Rz(c) Ry(b) (p - O))` by the definition of poses, and at
//! `Rx(a) (Q + Rz(c) (O + S + Ry(b) (p - O) - Q))` on a machine whose slides are at `S` and whose C turns the table. The
//! angles are the same, and the slides are `S = Rz(-c) (O + s - Q) - (O - Q)`.

use glam::{DAffine3, DMat3, DVec2, DVec3};

use super::machine_model::Carrier;
use super::path::PathRow;
use super::pose::Pose;

/// The chain of a machine about an electrode, in W.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Chain {
    reference_point: DVec3,
    /// Place of the C axis under A in the final pose (x, y) (mm); none where C turns the electrode.
    table_c: Option<DVec2>,
    /// Angle of X and Y of the machine about Z against W in the final pose (rad).
    turned: f64,
}

impl Chain {
    /// By how much (mm) the electrode may leave the motion of poses that are linear in every axis, where the machine is
    /// linear in its own axes from one of the [`refined`](Self::refined) rows to the next.
    const LINEAR: f64 = 5e-5;
    /// By how much (mm) the rounding of axis values to the decimals of files moves the electrode at most.
    const ROUNDED: f64 = 2e-5;

    /// The chain about an electrode with this reference point O. `table_c` is the place of the C axis under A in the
    /// final pose, in W; none where C turns the electrode.
    pub fn new(reference_point: DVec3, table_c: Option<DVec2>) -> Self {
        Self { reference_point, table_c, turned: 0.0 }
    }

    /// The chain of a machine whose X and Y are turned by `turned` (rad) about Z against W in the final pose, because the table
    /// that C turns makes up for how the electrode stands on its holder.
    #[must_use]
    pub fn turned(self, turned: f64) -> Self {
        Self { turned, ..self }
    }

    /// Angle of X and Y of the machine about Z against W in the final pose (rad).
    pub fn turn(&self) -> f64 {
        self.turned
    }

    /// A point of the C axis under A, in W; none where C turns the electrode.
    pub fn on_table_c(&self) -> Option<DVec3> {
        self.table_c.map(|q| q.extend(0.0))
    }

    /// By how much (mm) the machine's motion may leave that of the poses.
    pub fn deviation(&self) -> f64 {
        if self.table_c.is_some() { Self::LINEAR + Self::ROUNDED } else { 0.0 }
    }

    /// The axis values of the machine that make `pose`.
    pub fn machine_pose(&self, pose: &Pose) -> Pose {
        let in_w = self.slid(pose);
        if self.turned == 0.0 {
            return in_w;
        }
        let slides = DVec2::from_angle(self.turned).rotate(DVec2::new(in_w.x, in_w.y));
        Pose { x: slides.x, y: slides.y, ..in_w }
    }

    /// The axis values of the machine that make `pose`, with the slides along X and Y of W in the final pose.
    pub fn slid(&self, pose: &Pose) -> Pose {
        let Some(q) = self.table_c else { return *pose };
        let arm = self.reference_point.truncate() - q;
        let slides = DVec2::from_angle(-pose.c).rotate(arm + DVec2::new(pose.x, pose.y)) - arm;
        Pose { x: slides.x, y: slides.y, ..*pose }
    }

    /// `rows` with so many more between them that a machine which is linear in its own axes keeps to the motion of the
    /// poses; as they are where the axes are the same.
    pub fn refined(&self, rows: &[PathRow]) -> Vec<PathRow> {
        let between = |pair: &[PathRow]| {
            let (from, to, parts) = (pair[0], pair[1], self.parts(&pair[0].pose, &pair[1].pose));
            let at = move |i: usize| {
                let t = i as f64 / parts as f64;
                PathRow { node: from.node, s: from.s + (to.s - from.s) * t, pose: from.pose.lerp(&to.pose, t) }
            };
            (1..parts).map(at).chain(std::iter::once(to)).collect::<Vec<_>>()
        };
        rows.first().copied().into_iter().chain(rows.windows(2).flat_map(between)).collect()
    }

    /// The place among the [`refined`](Self::refined) rows of the place `row` among `rows`.
    pub fn refined_place(&self, rows: &[PathRow], row: f64) -> f64 {
        let mut place = 0.0;
        for (i, pair) in rows.windows(2).enumerate() {
            let share = (row - i as f64).clamp(0.0, 1.0);
            place += share * self.parts(&pair[0].pose, &pair[1].pose) as f64;
        }
        place
    }

    /// Number of parts of the motion from one row to the next.
    fn parts(&self, from: &Pose, to: &Pose) -> usize {
        const MOST: f64 = 1e4;
        let Some(q) = self.table_c else { return 1 };
        let arms = [from, to].map(|pose| self.reference_point.truncate() - q + DVec2::new(pose.x, pose.y));
        let (turn, way) = ((to.c - from.c).abs(), arms[0].distance(arms[1]));
        // An eighth of the greatest second derivative of Rz(-c) (O + s - Q).
        let deviation = 0.125 * turn * (turn * arms[0].length().max(arms[1].length()) + 2.0 * way);
        (deviation / Self::LINEAR).sqrt().ceil().clamp(1.0, MOST) as usize
    }

    /// How what goes with `carrier` moves from the final pose to `pose`, as seen from the blisk.
    pub fn seen_from_blisk(&self, carrier: Carrier, pose: &Pose) -> DAffine3 {
        let o = self.reference_point;
        match (carrier, self.on_table_c()) {
            (Carrier::Electrode, _) => pose.placement(o),
            (Carrier::Head, None) => Pose { b: 0.0, c: 0.0, ..*pose }.placement(o),
            // A head that does not turn goes round the table with C, as the electrode does.
            (Carrier::Head, Some(_)) => Pose { b: 0.0, ..*pose }.placement(o),
            (Carrier::Table, _) => DAffine3::IDENTITY,
            (Carrier::Cradle, _) | (Carrier::Bed, None) => DAffine3::from_mat3(DMat3::from_rotation_x(pose.a)),
            (Carrier::Bed, Some(q)) => Pose { a: pose.a, c: pose.c, ..Pose::FINAL }.placement(q),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const O: DVec3 = DVec3::new(3.0, 1.5, 90.0);
    const Q: DVec2 = DVec2::new(-60.0, 4.0);

    /// The point p of a part, in W in the final pose, as an observer on the bed sees it at these axis values of the
    /// machine: written down joint by joint, from the bed outwards.
    fn on_bed(carrier: Carrier, [x, y, z, a, b, c]: [f64; 6], p: DVec3) -> DVec3 {
        let (sb, cb) = b.sin_cos();
        let d = p - O;
        let tilted = O + DVec3::new(cb * d.x + sb * d.z, d.y, cb * d.z - sb * d.x);
        let slide = DVec3::new(x, y, z);
        // What carries the blisk turns against A and C.
        let (sa, ca) = a.sin_cos();
        let on_a = DVec3::new(p.x, ca * p.y + sa * p.z, ca * p.z - sa * p.y);
        let turned_c = |p: DVec3| {
            let ((sc, cc), d) = (c.sin_cos(), p - Q.extend(0.0));
            DVec3::new(Q.x + cc * d.x + sc * d.y, Q.y + cc * d.y - sc * d.x, p.z)
        };
        match carrier {
            Carrier::Electrode => tilted + slide,
            Carrier::Head => p + slide,
            Carrier::Table => turned_c(on_a),
            Carrier::Cradle => turned_c(p),
            Carrier::Bed => p,
        }
    }

    const CARRIERS: [Carrier; 5] = [Carrier::Electrode, Carrier::Head, Carrier::Table, Carrier::Cradle, Carrier::Bed];

    #[test]
    fn what_the_blisk_sees_is_what_the_joints_of_a_tilting_table_do() {
        let chain = Chain::new(O, Some(Q));
        for pose in [
            Pose { x: 14.0, y: -3.0, z: 7.0, a: 0.4, b: 0.0, c: -0.6 },
            Pose { x: -50.0, y: 8.0, z: -2.0, a: -1.1, b: 0.2, c: 0.9 },
        ] {
            let axes = chain.machine_pose(&pose).to_array();
            for (i, carrier) in CARRIERS.into_iter().enumerate() {
                let p = DVec3::new(7.0 - 3.0 * i as f64, 11.0, 95.0 - 20.0 * i as f64);
                // The place on the blisk that is there now is one that the table has taken there.
                let on_blisk = chain.seen_from_blisk(carrier, &pose).transform_point3(p);
                let [there, here] = [on_bed(Carrier::Table, axes, on_blisk), on_bed(carrier, axes, p)];
                assert!(there.distance(here) < 1e-11, "{carrier:?}: {there} {here}");
            }
        }
    }

    #[test]
    fn a_machine_that_is_linear_in_its_own_axes_keeps_to_the_motion_of_the_poses() {
        let chain = Chain::new(O, Some(Q));
        let row = |s: f64, pose: Pose| PathRow { node: 1, s, pose };
        let rows = [
            row(9.0, Pose { x: 40.0, y: 3.0, z: 5.0, a: 0.2, c: 0.5, ..Pose::FINAL }),
            row(4.0, Pose { x: 20.0, y: -3.0, z: 1.0, a: 0.1, c: 0.1, ..Pose::FINAL }),
            row(0.0, Pose::FINAL),
        ];
        let refined = chain.refined(&rows);
        assert!(refined.len() > 100 && refined.first() == rows.first() && refined.last() == rows.last());
        for (i, pair) in refined.windows(2).enumerate() {
            let [from, to] = [pair[0].pose, pair[1].pose].map(|pose| chain.machine_pose(&pose));
            for t in [0.25, 0.5, 0.8] {
                let (axes, pose) = (from.lerp(&to, t).to_array(), pair[0].pose.lerp(&pair[1].pose, t));
                let p = O + DVec3::new(5.0, -4.0, 12.0);
                let on_blisk = pose.placement(O).transform_point3(p);
                let off = on_bed(Carrier::Table, axes, on_blisk).distance(on_bed(Carrier::Electrode, axes, p));
                assert!(off <= Chain::LINEAR, "{i}: {off}");
            }
        }
        // Half way from the first row to the second.
        let at = chain.refined_place(&rows, 0.5);
        assert!((refined[at as usize].s - 6.5).abs() <= 2.5 / at, "{at}");
        assert_eq!(chain.refined_place(&rows, 2.0), (refined.len() - 1) as f64);
        // Where C turns the electrode nothing is changed.
        let plain = Chain::new(O, None);
        assert_eq!(
            (plain.refined(&rows), plain.refined_place(&rows, 1.25), plain.deviation()),
            (rows.to_vec(), 1.25, 0.0)
        );
        assert_eq!(plain.machine_pose(&rows[0].pose), rows[0].pose);
    }
}
