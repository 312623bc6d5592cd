//! Motion-bound clearance cache: a point with clearance to spare need not be tested again until the electrode has moved
//! by as much.
//!
//! A search tests many poses near to each other, and at each of them most points are far from any wall, so that most of
//! the cost is that of the first test.

/// Accumulated motion of the electrode over the poses tested, and the bound on it up to which each point, cluster and
/// block needs no new test.
#[derive(Debug, Clone)]
pub struct ClearanceCache {
    /// Motion so far, at most (mm).
    moved: f64,
    pub(super) blocks: Vec<MotionBound>,
    pub(super) clusters: Vec<MotionBound>,
    pub(super) points: Vec<MotionBound>,
}

impl ClearanceCache {
    /// Cache of so many blocks, clusters and points, none of which was tested yet.
    pub(super) fn new([blocks, clusters, points]: [usize; 3]) -> Self {
        let fresh = |n| vec![MotionBound::NONE; n];
        Self { moved: 0.0, blocks: fresh(blocks), clusters: fresh(clusters), points: fresh(points) }
    }

    /// Adds a motion of the electrode since the last test, in which no point moved by more than `motion` (mm).
    pub(super) fn advance(&mut self, motion: f64) {
        self.moved += motion;
    }

    /// The motion so far (mm).
    pub(super) fn moved(&self) -> f64 {
        self.moved
    }
}

/// Accumulated motion of the electrode (mm) up to which a point or ball keeps the clearance it needs, without any
/// margin beyond that.
#[derive(Debug, Clone, Copy)]
pub(super) struct MotionBound(f32);

impl MotionBound {
    /// Bound of a point that was not tested.
    const NONE: Self = Self(0.0);
    /// Bound of a point that never lacks clearance.
    pub(super) const FOR_EVER: Self = Self(f32::INFINITY);
    /// Bound of a ball whose points have bounds of their own.
    const OPENED: Self = Self(f32::NEG_INFINITY);
    /// Allowance for rounding to single precision (mm).
    const ROUNDING: f64 = 1e-5;

    /// Bound of a point with `spare` clearance beyond its demand (mm) after a motion of `moved` (mm);
    /// [`NONE`](Self::NONE) where `spare` is not finite, as outside a field.
    pub(super) fn of(spare: f64, moved: f64) -> Self {
        if spare.is_finite() { Self((moved + spare - Self::ROUNDING) as f32) } else { Self::NONE }
    }

    /// Whether the clearance surely exceeds the demand by `room` (mm) after a motion of `moved` (mm).
    #[inline]
    pub(super) fn lasts(self, moved: f64, room: f64) -> bool {
        f64::from(self.0) > moved + room
    }

    /// Whether the points of a ball have to be tested; where the bound does not decide, `spare` returns the clearance
    /// that the ball has beyond its demand now (mm).
    #[inline]
    pub(super) fn opens(&mut self, moved: f64, room: f64, spare: impl FnOnce() -> f64) -> bool {
        if self.0 == Self::OPENED.0 {
            return true;
        }
        if self.lasts(moved, room) {
            return false;
        }
        let spare = spare();
        *self = if spare < room { Self::OPENED } else { Self::of(spare, moved) };
        spare < room
    }
}

#[cfg(test)]
mod tests {
    use std::cell::Cell;

    use glam::{DAffine3, DVec3};
    use rand::{RngExt, SeedableRng};

    use super::*;
    use crate::probes::{Demand, Instant, Probes, SideDemand, Turns};
    use crate::samples::Sample;
    use task::Cancel;
    use wheel::electrode::ElectrodeFace;

    /// A plate of points, some of which ask for more.
    fn plate() -> Vec<Sample> {
        let at = |i: i32, j: i32| DVec3::new(f64::from(i), 0.02 * f64::from(j), 0.7 * f64::from(j));
        let extra = |i: i32| if i % 7 == 0 { 0.05 } else { 0.0 };
        let sample =
            |i, j| Sample { point: at(i, j), face: ElectrodeFace::FarEnd, extra: extra(i), stays_to: Sample::ALWAYS };
        (0..40).flat_map(|i| (0..40).map(move |j| sample(i, j))).collect()
    }

    /// Over a plane, from which distances are exact.
    #[test]
    fn watched_looks_find_what_fresh_ones_find_and_ask_less() {
        let probes = Probes::new(plate(), SideDemand::default(), |_| 0.3, &Cancel::default()).unwrap();
        let demand = Demand { spark_gap: 0.1, margin: 0.0, guard: 0.01, room: 0.1 };
        let at = Instant { s: 9.0, turns: Turns::NONE };
        let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(3);
        let (mut cache, mut last) = (probes.clearance_cache(), DAffine3::from_translation(DVec3::Y * 0.25));
        let (mut found_in_all, mut asked) = (0, [0, 0]);
        for _ in 0..60 {
            let turn = DAffine3::from_rotation_z(random.random_range(-0.002..0.002));
            let slid = DAffine3::from_translation(DVec3::Y * random.random_range(-0.03..0.03));
            let place = slid * turn * last;
            let motion = |p: DVec3| place.transform_point3(p).distance(last.transform_point3(p));
            cache.advance(probes.samples().iter().map(|s| motion(s.point)).fold(0.0, f64::max));
            last = place;
            let room = random.random_range(0.0..0.2);
            let look = |cache: &mut ClearanceCache| {
                let (mut found, asks) = (Vec::new(), Cell::new(0));
                let clearance = |p, _, _: f64| {
                    asks.set(asks.get() + 1);
                    place.transform_point3(p).y
                };
                probes.lacking(&at, &Demand { room, ..demand }, &clearance, cache, false, |k, lack| {
                    found.push((k, lack));
                    true
                });
                (found, asks.get())
            };
            let ((watched, few), (fresh, all)) = (look(&mut cache), look(&mut probes.clearance_cache()));
            assert_eq!(watched, fresh);
            found_in_all += fresh.len();
            asked = [asked[0] + few, asked[1] + all];
        }
        assert!(found_in_all > 1000, "{found_in_all}");
        assert!(2 * asked[0] < asked[1], "{asked:?}");
    }

    #[test]
    fn what_has_room_is_left_alone_until_that_may_be_used_up() {
        let mut rest = MotionBound::NONE;
        assert!(!rest.opens(0.0, 0.1, || 0.5));
        assert!(!rest.opens(0.39, 0.1, || panic!("it is known")));
        assert!(rest.lasts(0.39, 0.1) && !rest.lasts(0.41, 0.1) && !rest.lasts(0.39, 0.2));
        assert!(rest.opens(0.41, 0.1, || 0.05), "there it has to be looked at again");
        assert!(rest.opens(0.0, 0.0, || panic!("once opened it stays so")));
    }

    #[test]
    fn what_is_outside_a_field_is_asked_again() {
        let mut rest = MotionBound::NONE;
        assert!(!rest.opens(0.0, 0.1, || f64::INFINITY));
        assert!(rest.opens(0.0, 0.1, || 0.0));
        assert!(MotionBound::FOR_EVER.lasts(1e9, 1e9));
    }
}
