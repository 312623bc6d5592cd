//! Certified clearance of any two bodies, the one moved by the machine's axes: what [`Verifier`](super::Verifier) does
//! for electrode and blisk, for holders, heads, tables and beds.

use glam::DVec3;
use rayon::prelude::*;

use super::interval::{self, Question};
use super::motion::Motion;
use super::{ROWS_IN_TURN, inside};
use crate::pose::Pose;
use geometry::bvh::Bvh;
use geometry::mesh::Mesh;
use geometry::nearest_pair::{NearestPair, ROUNDING, nearer_than, nearest_pair};
use task::{Cancel, Cancelled};

/// A surface nearer than this is touched (mm).
pub const TOUCHING: f64 = 1e-6;
/// Halvings of an interval in the search for the instant of contact: to a billionth of it.
const HALVINGS: u32 = 30;

/// A body made ready for distances.
pub struct Solid {
    tree: Bvh,
    /// A point of each connected part.
    parts: Vec<DVec3>,
    /// The point that coordinates are counted from (mm, in W).
    pub(super) origin: DVec3,
    /// Greatest distance of a point of the body from there (mm).
    reach: f64,
}

impl Solid {
    /// Makes `mesh`, in W, ready. A body that moves is given about the reference point O of the electrode, one that
    /// stands still about the origin. A mesh without triangles is near to nothing.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn new(mesh: &Mesh, origin: DVec3, cancel: &Cancel) -> Result<Self, Cancelled> {
        let about = mesh.mapped(|p| p - origin);
        let tree = Bvh::new(&about, cancel)?;
        let reach = tree.triangles().iter().flatten().map(|u| u.length()).fold(0.0, f64::max);
        Ok(Self { tree, parts: inside::point_of_each_part(&about, cancel)?, origin, reach })
    }
}

/// Two bodies and how exactly their clearance is wanted.
#[derive(Clone, Copy)]
pub struct Pair<'a> {
    /// The body that the axes move, about the reference point O.
    pub moving: &'a Solid,
    /// The body that stands still, about the origin.
    pub fixed: &'a Solid,
    /// Accuracy of the proven bound to the smallest clearance met (mm).
    pub resolution: f64,
    /// Clearance that is asked for (mm).
    pub required: f64,
    /// Share of what a clearance exceeds the one asked for by, up to which the bound may stay below it: far bodies need
    /// no exact figure.
    pub share: f64,
}

/// Distance of two bodies at one instant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Near {
    /// Distance (mm); 0 when the surfaces touch or cross, or one body is inside the other.
    pub distance: f64,
    /// Position on the motion: `3.25` is a quarter of the way from pose 3 to pose 4.
    pub row: f64,
    /// Axis values at that instant.
    pub pose: Pose,
    /// The point on the moving body, where it is in the final pose, in W (mm).
    pub on_moving: DVec3,
    /// The point on the body that stands still, in W (mm).
    pub on_fixed: DVec3,
}

/// The clearance of two bodies over a motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PairClearance {
    /// Proven lower bound (mm).
    pub certified: f64,
    /// The smallest clearance met.
    pub least: Near,
}

impl Pair<'_> {
    fn placement(&self, pose: &Pose) -> (glam::DMat3, DVec3) {
        let placement = pose.placement(self.moving.origin);
        (placement.matrix3, placement.transform_point3(self.moving.origin))
    }

    pub(super) fn nearest(&self, pose: &Pose, guess: Option<[u32; 2]>) -> NearestPair {
        let (rotation, shift) = self.placement(pose);
        nearest_pair(&self.moving.tree, &self.fixed.tree, (&rotation, shift), guess)
    }

    pub(super) fn nearer_than(&self, pose: &Pose, limit: f64, guess: Option<[u32; 2]>) -> Option<[u32; 2]> {
        let (rotation, shift) = self.placement(pose);
        nearer_than(&self.moving.tree, &self.fixed.tree, (&rotation, shift), limit, guess)
    }

    fn near(&self, row: f64, pose: Pose, points: (f64, DVec3, DVec3)) -> Near {
        let (distance, first, on_fixed) = points;
        let on_moving = pose.placement(self.moving.origin).inverse().transform_point3(first);
        Near { distance, row, pose, on_moving, on_fixed }
    }

    /// A point of the one body inside the other at `pose`.
    pub(super) fn one_inside_the_other(&self, pose: &Pose, cancel: &Cancel) -> Result<Option<DVec3>, Cancelled> {
        let (rotation, shift) = self.placement(pose);
        let back = rotation.transpose();
        let moved = self.moving.parts.iter().map(|&u| rotation * u + shift);
        if let Some(p) = inside::first_inside(self.fixed.tree.triangles(), moved, cancel)? {
            return Ok(Some(p));
        }
        let fixed = self.fixed.parts.iter().map(|&p| back * (p - shift));
        let found = inside::first_inside(self.moving.tree.triangles(), fixed, cancel)?;
        Ok(found.map(|u| rotation * u + shift))
    }

    fn resolution_at(&self, clearance: f64) -> f64 {
        self.resolution.max(self.share * (clearance - self.required))
    }

    /// The resolution of a look at a motion: a little finer, so that a clearance which turns out a little smaller
    /// between the poses asks for no other look.
    fn resolution_for_a_look(&self, clearance: f64) -> f64 {
        self.resolution.max(0.9 * self.share * (clearance - self.required))
    }

    /// Bounds the clearance over the continuous motion through `poses`, all axes linear between them; none if there is
    /// nothing that could meet. A body that starts inside the other has a clearance of 0. `before` is the clearance
    /// over a motion that was looked at before: the answer is that over both.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn clearance(
        &self,
        poses: &[Pose],
        before: Option<PairClearance>,
        cancel: &Cancel,
    ) -> Result<Option<PairClearance>, Cancelled> {
        let (true, Some(first)) = (!self.moving.tree.is_empty() && !self.fixed.tree.is_empty(), poses.first()) else {
            return Ok(None);
        };
        if let Some(p) = self.one_inside_the_other(first, cancel)? {
            return Ok(Some(PairClearance { certified: 0.0, least: self.near(0.0, *first, (0.0, p, p)) }));
        }
        let mut least = match before {
            // A single pose has no way after it on which it would be looked at.
            Some(before) if poses.len() > 1 => before.least,
            before => {
                let here = self.least_at_poses(poses, cancel)?;
                before.map(|b| b.least).filter(|b| b.distance <= here.distance).unwrap_or(here)
            }
        };
        let mut resolution = self.resolution_for_a_look(least.distance);
        let mut lower = self.over(poses, &mut least, resolution, cancel)?;
        // What came nearer between the poses than at them needs a finer look.
        while lower + self.resolution_at(least.distance) < least.distance {
            let finer = self.resolution_for_a_look(least.distance);
            if finer >= resolution {
                break;
            }
            resolution = finer;
            lower = self.over(poses, &mut least, resolution, cancel)?;
        }
        // What is proven lies below what is met by what rounding may take.
        let own = lower.min(least.distance) - ROUNDING;
        let certified = before.map_or(own, |before| before.certified.min(own)).max(0.0);
        Ok(Some(PairClearance { certified, least }))
    }

    /// The bound over `poses` to within `resolution` (mm), infinite for a single one; `least` takes in what is met.
    fn over(&self, poses: &[Pose], least: &mut Near, resolution: f64, cancel: &Cancel) -> Result<f64, Cancelled> {
        let question = Question { known: least.distance, resolution, stop_below: f64::NEG_INFINITY, errors: [0.0; 6] };
        let bound = |i: usize| self.bound(&poses[i], &poses[i + 1], &question, cancel);
        let answers: Result<Vec<_>, Cancelled> = (0..poses.len() - 1).into_par_iter().map(bound).collect();
        let mut lower = f64::INFINITY;
        for (i, answer) in answers?.into_iter().enumerate() {
            lower = lower.min(answer.lower);
            if let Some((points, t)) = answer.found.filter(|(points, _)| points.distance < least.distance) {
                let pose = poses[i].lerp(&poses[i + 1], t);
                *least = self.near(i as f64 + t, pose, (points.distance, points.first, points.second));
            }
        }
        Ok(lower)
    }

    fn least_at_poses(&self, poses: &[Pose], cancel: &Cancel) -> Result<Near, Cancelled> {
        let in_turn = |(turn, poses): (usize, &[Pose])| {
            let (mut guess, mut least): (_, Option<(usize, NearestPair)>) = (None, None);
            for (i, pose) in poses.iter().enumerate() {
                cancel.check()?;
                let nearest = self.nearest(pose, guess);
                guess = Some(nearest.triangles);
                if least.as_ref().is_none_or(|(_, l)| nearest.points.distance < l.points.distance) {
                    least = Some((turn * ROWS_IN_TURN + i, nearest));
                }
            }
            Ok(least)
        };
        let found: Result<Vec<_>, Cancelled> = poses.par_chunks(ROWS_IN_TURN).enumerate().map(in_turn).collect();
        let least = found?.into_iter().flatten().min_by(|p, q| p.1.points.distance.total_cmp(&q.1.points.distance));
        // There is a first pose, and so a least one.
        let (row, nearest) = least.ok_or(Cancelled)?;
        let points = nearest.points;
        Ok(self.near(row as f64, poses[row], (points.distance, points.first, points.second)))
    }

    pub(super) fn bound(
        &self,
        from: &Pose,
        to: &Pose,
        question: &Question,
        cancel: &Cancel,
    ) -> Result<interval::Answer, Cancelled> {
        let motion = Motion::new(*from, *to, self.moving.origin, self.moving.reach).with_errors(question.errors);
        interval::bound(&self.moving.tree, &self.fixed.tree, &motion, question, cancel)
    }

    /// The first instant of the motion at which the bodies touch, up to a billionth of the way between two poses.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn first_contact(&self, poses: &[Pose], cancel: &Cancel) -> Result<Option<Near>, Cancelled> {
        let Some(first) = poses.first() else { return Ok(None) };
        if self.moving.tree.is_empty() || self.fixed.tree.is_empty() {
            return Ok(None);
        }
        if let Some(p) = self.one_inside_the_other(first, cancel)? {
            return Ok(Some(self.near(0.0, *first, (0.0, p, p))));
        }
        for i in 0..poses.len().saturating_sub(1) {
            if let Some(t) = self.contact_between(&poses[i], &poses[i + 1], cancel)? {
                let pose = poses[i].lerp(&poses[i + 1], t);
                let points = self.nearest(&pose, None).points;
                return Ok(Some(self.near(i as f64 + t, pose, (points.distance, points.first, points.second))));
            }
        }
        Ok(None)
    }

    /// The last instant before the bodies touch on the way between two poses, as a fraction of it.
    fn contact_between(&self, from: &Pose, to: &Pose, cancel: &Cancel) -> Result<Option<f64>, Cancelled> {
        let question = Question { known: 2.0 * TOUCHING, resolution: TOUCHING, stop_below: TOUCHING, errors: [0.0; 6] };
        let stays_clear = |s: f64, e: f64| {
            let answer = self.bound(&from.lerp(to, s), &from.lerp(to, e), &question, cancel)?;
            Ok::<_, Cancelled>(answer.lower >= TOUCHING)
        };
        if stays_clear(0.0, 1.0)? {
            return Ok(None);
        }
        // Of a window with a contact the first half that has one is kept.
        let (mut start, mut end) = (0.0, 1.0);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (start + end);
            if stays_clear(start, middle)? { start = middle } else { end = middle }
        }
        Ok(Some(start))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::verify::tests::any_pose;
    use geometry::exact::ExactMesh;
    use proptest::prelude::*;

    fn solids(moving: &Mesh, fixed: &Mesh, o: DVec3) -> [Solid; 2] {
        let never = Cancel::default();
        [Solid::new(moving, o, &never).unwrap(), Solid::new(fixed, DVec3::ZERO, &never).unwrap()]
    }

    fn at(x: f64, y: f64, z: f64) -> Pose {
        Pose { x, y, z, ..Pose::FINAL }
    }

    #[test]
    fn boxes_meet_at_the_instant_worked_out_by_hand() {
        let cube = Mesh::cuboid(DVec3::ONE);
        let [moving, fixed] = solids(&cube, &cube, DVec3::ZERO);
        let pair = Pair { moving: &moving, fixed: &fixed, resolution: 1e-6, required: 0.0, share: 0.0 };
        // Its far face is at x + 1, the other's near one at 0: they meet at x = -1, 4 of 10 mm into the second move.
        let way = [at(-9.0, 0.3, 0.2), at(-5.0, 0.3, 0.2), at(5.0, 0.3, 0.2)];
        let contact = pair.first_contact(&way, &Cancel::default()).unwrap().unwrap();
        assert!((contact.row - 1.4).abs() < 2e-7 && contact.distance <= 2e-6, "{contact:?}");
        let clearance = pair.clearance(&way, None, &Cancel::default()).unwrap().unwrap();
        assert_eq!((clearance.certified, clearance.least.distance), (0.0, 0.0));
        assert_eq!(pair.first_contact(&way[..2], &Cancel::default()).unwrap(), None);
    }

    #[test]
    fn clearances_are_those_of_closed_form() {
        let cube = Mesh::cuboid(DVec3::ONE);
        let never = Cancel::default();
        let [moving, fixed] = solids(&cube, &cube, DVec3::ZERO);
        let pair = Pair { moving: &moving, fixed: &fixed, resolution: 1e-6, required: 0.0, share: 0.0 };
        // Passing by 1.5 mm aside and 2 mm above.
        let found = pair.clearance(&[at(-7.0, 2.5, 3.0), at(9.0, 2.5, 3.0)], None, &never).unwrap().unwrap();
        assert!((found.least.distance - 2.5).abs() < 1e-6 && (found.certified - 2.5).abs() < 2e-6, "{found:?}");
        // A bar that reaches 5 mm from the C axis, at its corner, turns before a wall 6 mm away.
        let bar = Mesh::cuboid(DVec3::new(6.0, 8.0, 2.0)).mapped(|p| p - DVec3::new(3.0, 4.0, 1.0));
        let wall = Mesh::cuboid(DVec3::new(1.0, 40.0, 40.0)).mapped(|p| p + DVec3::new(6.0, -20.0, -20.0));
        let [moving, fixed] = solids(&bar, &wall, DVec3::ZERO);
        let pair = Pair { moving: &moving, fixed: &fixed, resolution: 1e-6, required: 0.0, share: 0.0 };
        let turned = [Pose::FINAL, Pose { c: -1.2, ..Pose::FINAL }];
        let found = pair.clearance(&turned, None, &never).unwrap().unwrap();
        assert!((found.least.distance - 1.0).abs() < 1e-6 && (found.certified - 1.0).abs() < 2e-6, "{found:?}");
        let instant = 4f64.atan2(3.0) / 1.2;
        assert!((found.least.row - instant).abs() < 2e-3, "{} {instant}", found.least.row);
    }

    #[test]
    fn a_single_pose_counts_beside_what_is_known_before() {
        let cube = Mesh::cuboid(DVec3::ONE);
        let never = Cancel::default();
        let [moving, fixed] = solids(&cube, &cube, DVec3::ZERO);
        let pair = Pair { moving: &moving, fixed: &fixed, resolution: 1e-6, required: 0.0, share: 0.0 };
        let clearance = |poses: &[Pose], before| pair.clearance(poses, before, &never).unwrap();
        let before = clearance(&[at(-9.0, 0.3, 0.2), at(-6.0, 0.3, 0.2)], None);
        for (x, least) in [(-3.0, 2.0), (-8.0, 5.0)] {
            let found = clearance(&[at(x, 0.3, 0.2)], before).unwrap();
            let is_proven = found.certified <= least && found.certified > least - 2e-6;
            assert!((found.least.distance - least).abs() < 1e-9 && is_proven, "{found:?}");
        }
    }

    /// From far away past the other by a little and far away again: the little counts, however far the ends are.
    #[test]
    fn far_ends_do_not_blur_what_is_near_between_them() {
        let cube = Mesh::cuboid(DVec3::ONE);
        let never = Cancel::default();
        let [moving, fixed] = solids(&cube, &cube, DVec3::ZERO);
        for (required, aside) in [(0.0, 0.2), (0.1, 0.2), (0.0, 0.02), (1.0, 4.0)] {
            let pair = Pair { moving: &moving, fixed: &fixed, resolution: 1e-4, required, share: 0.01 };
            let way = [at(-60.0, 1.0 + aside, 0.3), at(70.0, 1.0 + aside, 0.3)];
            let found = pair.clearance(&way, None, &never).unwrap().unwrap();
            let blur = f64::max(1e-4, 0.01 * (aside - required));
            assert!(found.certified <= aside && found.certified >= aside - blur - 1e-8, "{aside}: {found:?}");
            assert!(found.least.distance >= aside - 1e-9 && found.least.distance <= aside + blur, "{aside}: {found:?}");
        }
    }

    #[test]
    fn a_body_that_starts_inside_another_is_in_contact_from_the_first() {
        let (large, small) = (Mesh::cuboid(DVec3::splat(10.0)), Mesh::cuboid(DVec3::ONE).mapped(|p| p + 4.0));
        for (moving, fixed) in [(&small, &large), (&large, &small)] {
            let [moving, fixed] = solids(moving, fixed, DVec3::new(2.0, 1.0, 0.0));
            let pair = Pair { moving: &moving, fixed: &fixed, resolution: 1e-3, required: 0.0, share: 0.0 };
            let way = [Pose::FINAL, at(1.0, 0.0, 0.0)];
            assert_eq!(pair.clearance(&way, None, &Cancel::default()).unwrap().unwrap().certified, 0.0);
            assert_eq!(pair.first_contact(&way, &Cancel::default()).unwrap().unwrap().row, 0.0);
        }
        let nothing = [Mesh::default(), large];
        let [moving, fixed] = solids(&nothing[0], &nothing[1], DVec3::ZERO);
        let pair = Pair { moving: &moving, fixed: &fixed, resolution: 1e-3, required: 0.0, share: 0.0 };
        assert_eq!(pair.clearance(&[Pose::FINAL], None, &Cancel::default()).unwrap(), None);
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(24))]
        #[test]
        fn dense_sampling_never_finds_less_than_is_certified(
            start in any_pose(9.0, 0.8), end in any_pose(9.0, 0.8), size in [0.5..6.0f64, 0.5..6.0f64, 0.5..6.0f64],
        ) {
            let o = DVec3::new(0.0, 1.0, 12.0);
            let moving = Mesh::cuboid(DVec3::from_array(size)).mapped(|p| p + DVec3::new(1.0, -3.0, 11.0));
            let fixed = Mesh::cuboid(DVec3::new(5.0, 4.0, 3.0)).mapped(|p| p - DVec3::new(2.0, 2.0, 4.0));
            let solids = solids(&moving, &fixed, o);
            let pair = Pair { moving: &solids[0], fixed: &solids[1], resolution: 1e-3, required: 0.0, share: 0.0 };
            let found = pair.clearance(&[start, end], None, &Cancel::default()).unwrap().unwrap();
            let (moving, fixed) = (ExactMesh::new(&moving).unwrap(), ExactMesh::new(&fixed).unwrap());
            let sampled = (0..=200).map(|i| start.lerp(&end, i as f64 / 200.0));
            let sampled = sampled.map(|pose| fixed.distance_to(&moving, &pose.placement(o))).fold(f64::INFINITY, f64::min);
            prop_assert!(sampled >= found.certified - 1e-9, "{sampled} {found:?}");
            // A motion of some 50 mm in 200 steps: the least is hardly missed by more than the step.
            prop_assert!(sampled <= found.least.distance + 0.5, "{sampled} {found:?}");
        }
    }
}
