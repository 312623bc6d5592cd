//! The searches that P4 compares its method with: particle swarm (PSO) and electromagnetism-like search (EM), here over
//! the control points of the axis surface and for the sum of absolute deviations on a grid of the design surface.
//!
//! Sources: Kennedy and Eberhart 1995 with the constriction of Clerc and Kennedy 2002; Birbil and Fang 2003. P4 names
//! neither their settings nor their variables. What is here is given what favours it: it starts from the three-point
//! path, and no change is tried that is far larger than the deviations.

use glam::DVec3;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use flank::FlankError;
use flank::axis_surface::AxisSurface;
use flank::compensation::Measured;
use flank::cutter::FlankCutter;
use flank::deviation::DesignGrid;
use task::Task;

/// Kind of search.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Swarm {
    /// Particle swarm.
    Particles,
    /// Electromagnetism-like search.
    Charges,
}

impl Swarm {
    /// Both of them.
    pub(super) const ALL: [Self; 2] = [Self::Particles, Self::Charges];

    /// Name in tables.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Particles => "particle swarm (PSO)",
            Self::Charges => "electromagnetism-like search (EM)",
        }
    }
}

/// Path that a search has found.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Found {
    /// The surface that its axis sweeps.
    pub axis: AxisSurface,
    /// Evaluations so far and the least sum as a share of the start's, after each generation.
    pub course: Vec<[f64; 2]>,
}

/// Individuals of a generation.
const INDIVIDUALS: usize = 30;
/// Evaluations of the objective at which a search ends.
pub(super) const EVALUATIONS: usize = 6000;
/// Greatest change of a coordinate of a control point, as a share of the greatest deviation of the start.
const REACH: f64 = 2.0;
const SEED: u64 = 4;

/// An individual: changes of the coordinates (mm), those of C_b first, and the sum of its path (mm).
#[derive(Debug, Clone)]
struct Individual {
    at: Vec<f64>,
    sum: f64,
}

/// What is searched in.
struct Space<'a> {
    grid: &'a DesignGrid,
    start: Measured,
    cutter: &'a FlankCutter,
    /// Greatest change of a coordinate (mm).
    reach: f64,
}

/// Searches from the path `start` for the least sum over `grid`, over paths that stand over all of the surface.
///
/// # Errors
/// [`FlankError::Unmeasured`] if the start cannot be measured; cancelled.
pub(super) fn search(
    swarm: Swarm,
    grid: &DesignGrid,
    start: &AxisSurface,
    cutter: &FlankCutter,
    task: &Task,
) -> Result<Found, FlankError> {
    let start = Measured::new(grid, start.clone(), cutter, None)?;
    let greatest = start.deviation.most_undercut.max(-start.deviation.most_overcut);
    let space = Space { grid, start, cutter, reach: REACH * greatest };
    let (best, course) = match swarm {
        Swarm::Particles => space.particles(task)?,
        Swarm::Charges => space.charges(task)?,
    };
    Ok(Found { axis: space.axis(&best.at)?, course })
}

impl Space<'_> {
    fn axis(&self, change: &[f64]) -> Result<AxisSurface, FlankError> {
        let (from, n) = (&self.start.axis, self.start.axis.lower().len());
        let moved = |points: &[DVec3], first: usize| -> Vec<DVec3> {
            points.iter().enumerate().map(|(i, p)| *p + DVec3::from_slice(&change[first + 3 * i..])).collect()
        };
        AxisSurface::new(moved(from.lower(), 0), moved(from.upper(), 3 * n), from.u0_range)
    }

    /// The sum of a changed path (mm); infinite if it does not stand over all of the surface.
    fn sum(&self, change: &[f64]) -> f64 {
        let path =
            self.axis(change).and_then(|axis| Measured::new(self.grid, axis, self.cutter, Some(&self.start.feet)));
        path.ok().filter(Measured::stands_over_all).map_or(f64::INFINITY, |path| path.deviation.sum)
    }

    fn individuals(&self, changes: Vec<Vec<f64>>) -> Vec<Individual> {
        changes.into_par_iter().map(|at| Individual { sum: self.sum(&at), at }).collect()
    }

    /// The start and others drawn from all of the box.
    fn first_generation(&self, random: &mut ChaCha8Rng) -> Vec<Individual> {
        let unknowns = 6 * self.start.axis.lower().len();
        let mut changes = vec![vec![0.0; unknowns]];
        changes.resize_with(INDIVIDUALS, || self.drawn(unknowns, random));
        self.individuals(changes)
    }

    fn drawn(&self, unknowns: usize, random: &mut ChaCha8Rng) -> Vec<f64> {
        (0..unknowns).map(|_| self.reach * random.random_range(-1.0..1.0)).collect()
    }

    fn course_point(&self, evaluations: usize, best: &Individual) -> [f64; 2] {
        [evaluations as f64, best.sum / self.start.deviation.sum.max(f64::MIN_POSITIVE)]
    }

    /// Velocities are drawn to each particle's own best place and to the best of all.
    fn particles(&self, task: &Task) -> Result<(Individual, Vec<[f64; 2]>), FlankError> {
        /// Share of the speed that is kept, and pull, by the constriction.
        const INERTIA: f64 = 0.7298;
        const PULL: f64 = 1.49618;
        let mut random = ChaCha8Rng::seed_from_u64(SEED);
        let mut now = self.first_generation(&mut random);
        let mut own = now.clone();
        let mut speeds = vec![vec![0.0; now[0].at.len()]; INDIVIDUALS];
        let mut best = least(&own);
        let mut evaluations = INDIVIDUALS;
        let mut course = vec![self.course_point(evaluations, &best)];
        while evaluations + INDIVIDUALS <= EVALUATIONS {
            task.check()?;
            for ((particle, own), speed) in now.iter_mut().zip(&own).zip(&mut speeds) {
                for (k, speed) in speed.iter_mut().enumerate() {
                    let [to_own, to_best] = [own.at[k], best.at[k]].map(|to| to - particle.at[k]);
                    let [a, b]: [f64; 2] = [random.random(), random.random()];
                    *speed = INERTIA * *speed + PULL * (a * to_own + b * to_best);
                    let next = particle.at[k] + *speed;
                    particle.at[k] = next.clamp(-self.reach, self.reach);
                    if next != particle.at[k] {
                        *speed = 0.0;
                    }
                }
            }
            now = self.individuals(now.into_iter().map(|particle| particle.at).collect());
            evaluations += INDIVIDUALS;
            for (own, now) in own.iter_mut().zip(&now).filter(|(own, now)| now.sum < own.sum) {
                own.clone_from(now);
            }
            best = least(&own);
            course.push(self.course_point(evaluations, &best));
        }
        Ok((best, course))
    }

    /// Better individuals attract and worse ones repel, by charges from their sums; around the best one single
    /// coordinates are tried.
    fn charges(&self, task: &Task) -> Result<(Individual, Vec<[f64; 2]>), FlankError> {
        let mut random = ChaCha8Rng::seed_from_u64(SEED);
        let mut now = self.first_generation(&mut random);
        let mut best = least(&now);
        let mut evaluations = INDIVIDUALS;
        let mut course = vec![self.course_point(evaluations, &best)];
        // Steps of the local search, made less while they find nothing.
        let mut step = self.reach;
        while evaluations + 2 * INDIVIDUALS <= EVALUATIONS {
            task.check()?;
            let unknowns = best.at.len();
            let tries = (0..INDIVIDUALS).map(|_| {
                let mut at = best.at.clone();
                let k = random.random_range(0..unknowns);
                at[k] = (at[k] + step * random.random_range(-1.0..1.0)).clamp(-self.reach, self.reach);
                at
            });
            let near = least(&self.individuals(tries.collect()));
            if near.sum < best.sum {
                best = near;
            } else {
                step *= 0.8;
            }
            let worst = now.iter_mut().max_by(|a, b| a.sum.total_cmp(&b.sum));
            worst.into_iter().for_each(|worst| worst.clone_from(&best));
            let moved = (0..INDIVIDUALS).map(|i| self.pushed(&now, i, &best, &mut random)).collect();
            now = self.individuals(moved);
            evaluations += 2 * INDIVIDUALS;
            let least = least(&now);
            if least.sum < best.sum {
                best = least;
            }
            course.push(self.course_point(evaluations, &best));
        }
        Ok((best, course))
    }

    /// Individual `i` moved a random part of the way to the edge of the box, along the force of the others; the best
    /// one stays.
    fn pushed(&self, now: &[Individual], i: usize, best: &Individual, random: &mut ChaCha8Rng) -> Vec<f64> {
        let own = &now[i];
        let share: f64 = random.random();
        let parts: Vec<f64> = own.at.iter().map(|_| random.random()).collect();
        if own.at == best.at {
            return own.at.clone();
        }
        let finite = |sum: f64| if sum.is_finite() { sum - best.sum } else { 1e3 * self.start.deviation.sum };
        let total: f64 = now.iter().map(|other| finite(other.sum)).sum::<f64>().max(f64::MIN_POSITIVE);
        let charge = |one: &Individual| (-(own.at.len() as f64) * finite(one.sum) / total).exp();
        let mut force = vec![0.0; own.at.len()];
        for other in now.iter().filter(|other| other.at != own.at) {
            let apart: f64 = other.at.iter().zip(&own.at).map(|(a, b)| (a - b) * (a - b)).sum();
            let sign = if other.sum < own.sum { 1.0 } else { -1.0 };
            let pull = sign * charge(own) * charge(other) / apart;
            force.iter_mut().zip(other.at.iter().zip(&own.at)).for_each(|(f, (a, b))| *f += pull * (a - b));
        }
        let length = force.iter().map(|f| f * f).sum::<f64>().sqrt().max(f64::MIN_POSITIVE);
        let moved = |k: usize| {
            let way = force[k] / length;
            let room = if way > 0.0 { self.reach - own.at[k] } else { self.reach + own.at[k] };
            (own.at[k] + share * parts[k] * way * room).clamp(-self.reach, self.reach)
        };
        (0..own.at.len()).map(moved).collect()
    }
}

/// The best one, the first of several.
fn least(all: &[Individual]) -> Individual {
    let best = all.iter().skip(1).fold(&all[0], |best, one| if one.sum < best.sum { one } else { best });
    best.clone()
}

#[cfg(test)]
mod tests {
    use super::super::{CONE, SURFACES, cutter, params, surface};
    use super::*;
    use flank::params::FlankParams;
    use flank::plan::plan_flank;

    #[test]
    fn a_search_is_the_same_on_any_number_of_threads_and_ends_no_worse_than_it_starts() {
        let (surface, cutter) = (surface(SURFACES[1], "Table 2").unwrap(), cutter(CONE));
        let params = FlankParams { grid: [20, 10], rounds: 0, ..params() };
        let start = plan_flank(&surface, &cutter, &params, &Task::default()).unwrap().initial;
        let grid = DesignGrid::new(&surface, params.grid);
        for swarm in Swarm::ALL {
            let of = |threads| {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
                pool.install(|| search(swarm, &grid, &start.axis, &cutter, &Task::default()).unwrap())
            };
            let (found, again) = (of(1), of(3));
            assert!(found == again, "{}: bit for bit", swarm.name());
            assert!(found.course.windows(2).all(|pair| pair[1][1] <= pair[0][1] && pair[1][0] <= EVALUATIONS as f64));
            let path = Measured::new(&grid, found.axis, &cutter, None).unwrap();
            let last = found.course[found.course.len() - 1][1];
            assert!((path.deviation.sum / start.deviation.sum - last).abs() < 1e-9 && last < 1.0, "{last}");
            assert!(path.stands_over_all());
        }
    }
}
