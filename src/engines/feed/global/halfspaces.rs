//! Constraints of a step: an intersection of half-spaces and of ranges of the axes.

/// A step of the axes, in units of their mobility (about mm), in the order of `Axis`.
pub type Step = [f64; 6];

/// Steps `d` with `slope . d >= lack` for every wall, and every axis within its range; axes without a range stay still.
#[derive(Debug, Clone, Default)]
pub struct HalfSpaces {
    walls: Vec<(Step, f64)>,
    ranges: Vec<(usize, [f64; 2])>,
}

impl HalfSpaces {
    /// Sweeps over all walls. Where walls meet at a sharp angle more would come closer; what is left of a lack is taken
    /// up by the next problem.
    const SWEEPS: usize = 24;

    /// From walls, as slope and lack, and the ranges of axes.
    pub fn new(walls: Vec<(Step, f64)>, ranges: Vec<(usize, [f64; 2])>) -> Self {
        Self { walls, ranges }
    }

    /// The allowed step nearest to `target`, or nearly so: Hildreth's method, which sweeps over the walls and pushes
    /// or releases at each by just what it needs. Where nothing is allowed it ends between the walls.
    pub fn nearest(&self, target: &Step) -> Step {
        self.nearest_after(Self::SWEEPS, target)
    }

    fn nearest_after(&self, sweeps: usize, target: &Step) -> Step {
        const CLOSE: f64 = 1e-6;
        let mut step = [0.0; 6];
        for (i, _) in &self.ranges {
            step[*i] = target[*i];
        }
        let mut pushes = vec![0.0f64; self.walls.len()];
        let mut held = vec![0.0f64; self.ranges.len()];
        for _ in 0..sweeps {
            let mut moved = 0.0f64;
            for ((slope, lack), push) in self.walls.iter().zip(&mut pushes) {
                let square: f64 = slope.iter().map(|g| g * g).sum();
                if square < 1e-9 {
                    continue;
                }
                let along: f64 = slope.iter().zip(&step).map(|(g, d)| g * d).sum();
                let change = ((lack - along) / square).max(-*push);
                *push += change;
                step.iter_mut().zip(slope).for_each(|(d, g)| *d += change * g);
                moved = moved.max(change.abs());
            }
            for ((i, [least, greatest]), held) in self.ranges.iter().zip(&mut held) {
                let free = step[*i] - *held;
                let within = free.clamp(*least, greatest.max(*least));
                moved = moved.max((within - step[*i]).abs());
                *held = within - free;
                step[*i] = within;
            }
            if moved < CLOSE {
                break;
            }
        }
        step
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn free(walls: Vec<(Step, f64)>, size: f64) -> HalfSpaces {
        HalfSpaces::new(walls, (0..6).map(|i| (i, [-size, size])).collect())
    }

    #[test]
    fn a_wall_is_met_squarely_and_a_corner_at_its_edge() {
        let wall = |slope: Step, lack| (slope, lack);
        let one = free(vec![wall([0.6, 0.8, 0.0, 0.0, 0.0, 0.0], 1.0)], 10.0);
        let d = one.nearest(&[0.0; 6]);
        assert!((d[0] - 0.6).abs() < 1e-6 && (d[1] - 0.8).abs() < 1e-6, "{d:?}");
        let corner =
            free(vec![wall([1.0, 0.0, 0.0, 0.0, 0.0, 0.0], 1.0), wall([0.0, 1.0, 0.0, 0.0, 0.0, 0.0], 2.0)], 10.0);
        let d = corner.nearest(&[0.0, 5.0, -1.0, 0.0, 0.0, 0.0]);
        assert!((d[0] - 1.0).abs() < 1e-6 && (d[1] - 5.0).abs() < 1e-6 && (d[2] + 1.0).abs() < 1e-6, "{d:?}");
    }

    #[test]
    fn axes_without_a_range_stay_still() {
        let one = HalfSpaces::new(Vec::new(), vec![(1, [-0.5, 0.5])]);
        assert_eq!(one.nearest(&[3.0, 3.0, 3.0, 0.0, 0.0, 0.0]), [0.0, 0.5, 0.0, 0.0, 0.0, 0.0]);
    }

    proptest! {
        /// The projection on a convex set: allowed, and no allowed step is nearer (checked by the variational
        /// inequality against allowed steps found by drawing).
        #[test]
        fn nothing_allowed_is_nearer(
            slopes in prop::collection::vec(prop::array::uniform6(-1.0f64..1.0), 1..4),
            target in prop::array::uniform6(-2.0f64..2.0),
            others in prop::collection::vec(prop::array::uniform6(-1.0f64..1.0), 40),
        ) {
            // The origin is allowed by all.
            let spaces = free(slopes.iter().map(|g| (*g, -0.2)).collect(), 1.0);
            let d = spaces.nearest_after(20_000, &target);
            let dot = |a: &Step, b: &Step| a.iter().zip(b).map(|(p, q)| p * q).sum::<f64>();
            prop_assert!(slopes.iter().all(|g| dot(g, &d) >= -0.2 - 1e-3), "{d:?} is allowed");
            for other in others.iter().filter(|o| slopes.iter().all(|g| dot(g, o) >= -0.2)) {
                let away: f64 = (0..6).map(|i| (target[i] - d[i]) * (other[i] - d[i])).sum();
                prop_assert!(away < 5e-3, "{away}");
            }
        }
    }
}
