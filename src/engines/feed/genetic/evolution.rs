//! One node of the genetic search: a first population of free individuals, evolved.

use std::ops::Range;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use super::coding::{Coding, Genes, chromosome_bits, cross};
use super::{GeneticParams, ReductionMode};
use crate::objective::ObjectiveValue;
use crate::pose::{Axis, Pose};
use crate::problem::{Candidate, Convergence, NodeTask, SearchProblem};
use crate::strategy::Candidates;
use task::{Cancel, Cancelled};

/// The search for one node.
pub struct GeneticStep<'a> {
    params: &'a GeneticParams,
    problem: &'a SearchProblem<'a>,
    task: &'a NodeTask,
    codings: Vec<Coding>,
    axes: &'a [Axis],
}

#[derive(Debug, Clone)]
struct Individual {
    genes: Genes,
    pose: Pose,
    h: f64,
    objective: ObjectiveValue,
    /// Cost to be minimised: the objective plus the cost of a new greatest h, where h is variable.
    cost: f64,
}

impl<'a> GeneticStep<'a> {
    /// Tries for each individual of the first population.
    const TRIES: u32 = 11;
    /// Individuals that look for a free place first: if none of them finds one, the node is given up.
    const SCOUTS: u64 = 16;

    /// Prepares the search for `task`. The variables are the increments of the free axes from the last pose,
    /// bounded by (7), and h.
    pub fn new(params: &'a GeneticParams, problem: &'a SearchProblem<'a>, task: &'a NodeTask) -> Self {
        let axes = problem.free_axes();
        let mut codings: Vec<Coding> = axes
            .iter()
            .map(|&axis| {
                let half = 0.5 * problem.ranges[axis as usize];
                let precision = if axis.is_rotary() { params.precision_deg.to_radians() } else { params.precision_mm };
                Coding::new(-half, half, precision)
            })
            .collect();
        if params.h == ReductionMode::Variable {
            codings.push(Coding::new(0.0, params.h_max_deg.to_radians(), params.precision_deg.to_radians()));
        }
        Self { params, problem, task, codings, axes }
    }

    /// Free individuals at the node, best first, and how the population converged. None if no free individual
    /// was found.
    pub fn run(&self, cancel: &Cancel) -> Candidates {
        let mut population = self.first_population(cancel)?;
        let mut convergence = Convergence { s: self.task.s, best: Vec::new(), mean: Vec::new() };
        if population.is_empty() {
            return Ok((Vec::new(), convergence));
        }
        convergence.record(population.iter().map(|i| i.objective.total));
        for generation in 1..=self.params.generations {
            cancel.check()?;
            population = self.next_generation(population, generation as u64);
            convergence.record(population.iter().map(|i| i.objective.total));
            if has_stalled(&convergence.best, self.params.stall_generations) {
                break;
            }
        }
        population.dedup_by(|a, b| a.genes == b.genes);
        let candidates =
            population.into_iter().map(|i| Candidate { pose: i.pose, h: i.h, objective: i.objective }).collect();
        Ok((candidates, convergence))
    }

    fn random(&self, generation: u64, individual: u64) -> ChaCha8Rng {
        // Any change of one of them gives an unrelated stream; bits of s stand for the node.
        let parts = [self.params.seed, self.task.s.to_bits(), self.task.attempt, generation, individual];
        let mixed = parts.into_iter().fold(0x9e37_79b9_7f4a_7c15u64, |hash, part| {
            let mut z = (hash ^ part).wrapping_mul(0xbf58_476d_1ce4_e5b9);
            z ^= z >> 29;
            z = z.wrapping_mul(0x94d0_49bb_1331_11eb);
            z ^ z >> 32
        });
        ChaCha8Rng::seed_from_u64(mixed)
    }

    /// Free individuals only: each is drawn about the expected pose, from the whole range (7) at first and from
    /// ever nearer when that meets the blisk, and may climb the distance field to freedom.
    fn first_population(&self, cancel: &Cancel) -> Result<Vec<Individual>, Cancelled> {
        let scouts = Self::SCOUTS.min(self.params.population as u64);
        let mut population = self.free_individuals(0..scouts, cancel)?;
        if population.is_empty() {
            return Ok(population);
        }
        population.extend(self.free_individuals(scouts..self.params.population as u64, cancel)?);
        // Those that found no place are replaced by copies of those that did.
        let found = population.len();
        for i in found..self.params.population {
            if found > 0 {
                population.push(population[i % found].clone());
            }
        }
        sort(&mut population);
        Ok(population)
    }

    fn free_individuals(&self, numbers: Range<u64>, cancel: &Cancel) -> Result<Vec<Individual>, Cancelled> {
        let found: Result<Vec<Option<Individual>>, Cancelled> =
            numbers.into_par_iter().map(|i| cancel.check().map(|()| self.free_individual(i))).collect();
        Ok(found?.into_iter().flatten().collect())
    }

    fn free_individual(&self, number: u64) -> Option<Individual> {
        let mut random = self.random(0, number);
        let mut hint = 0;
        // The first individual starts from what is expected itself: another try differs in h alone.
        let tries = if number == 0 && self.codings.len() == self.axes.len() { 1 } else { Self::TRIES };
        (0..tries).find_map(|attempt| {
            let reach = if number == 0 { 0.0 } else { 0.5f64.powi(attempt as i32) };
            let mut values = self.expected(number);
            for (i, (value, coding)) in values.iter_mut().zip(&self.codings).enumerate() {
                let width = coding.upper - coding.lower;
                *value += if i < self.axes.len() {
                    reach * 0.5 * width * random.random_range(-1.0..=1.0)
                } else {
                    // The longer the search for a place, the more reduction is tried.
                    f64::from(attempt) / f64::from(Self::TRIES) * width * random.random_range(0.0..=1.0)
                };
            }
            if let Some(individual) = self.individual(self.encode(&values), &mut hint) {
                return Some(individual);
            }
            // Climbing is dear and of no use far away.
            if number > 0 && attempt < 4 {
                return None;
            }
            let (pose, h) = self.decode(&self.encode(&values));
            let (climbed, lacking) = self.problem.climb(pose, self.task.s, h);
            if lacking.is_some() {
                return None;
            }
            for (value, &axis) in values.iter_mut().zip(self.axes) {
                *value = climbed.get(axis) - self.task.from.get(axis);
            }
            self.individual(self.encode(&values), &mut hint)
        })
    }

    /// Where to look first: for even numbers where the last step's rates lead, for odd ones the last pose.
    fn expected(&self, number: u64) -> Vec<f64> {
        let rates = &self.task.before.increments;
        let ratio = if number.is_multiple_of(2) { self.task.duration / self.task.before.duration } else { 0.0 };
        let mut values: Vec<f64> = self.axes.iter().map(|&a| rates[a as usize] * ratio).collect();
        values.resize(self.codings.len(), self.task.h_so_far);
        values
    }

    fn encode(&self, values: &[f64]) -> Genes {
        self.codings.iter().zip(values).map(|(c, &v)| c.encode(v)).collect()
    }

    /// Pose and h of an individual.
    fn decode(&self, genes: &Genes) -> (Pose, f64) {
        let mut q = self.task.placed(&self.task.from).to_array();
        for ((&axis, coding), &code) in self.axes.iter().zip(&self.codings).zip(genes) {
            q[axis as usize] += coding.decode(code);
        }
        let h = if genes.len() > self.axes.len() {
            self.codings[self.axes.len()].decode(genes[self.axes.len()])
        } else {
            0.0
        };
        (Pose::from_array(q), h)
    }

    /// The individual with these genes, if it is free and within the machine's travel.
    fn individual(&self, genes: Genes, hint: &mut usize) -> Option<Individual> {
        let (pose, h) = self.decode(&genes);
        if !self.problem.is_free(&pose, self.task.s, h, hint) {
            return None;
        }
        let motion = self.task.motion_to(&pose);
        let objective = self.problem.objective.value(&pose, h, &motion, &self.task.before);
        let thinner = (h - self.task.h_so_far).max(0.0) / self.params.h_max_deg.to_radians();
        Some(Individual { genes, pose, h, objective, cost: objective.total + thinner })
    }

    fn next_generation(&self, population: Vec<Individual>, generation: u64) -> Vec<Individual> {
        let costs: Vec<f64> = population.iter().map(|i| i.cost).collect();
        let roulette = Roulette::new(&costs);
        let pairs = (population.len() - self.params.elite).div_ceil(2) as u64;
        let children: Vec<[Individual; 2]> = (0..pairs)
            .into_par_iter()
            .map(|pair| {
                let mut random = self.random(generation, pair);
                let parents = [0; 2].map(|_| &population[roulette.spin(&mut random)]);
                self.children(parents, &roulette, &mut random)
            })
            .collect();
        let size = population.len();
        let mut next: Vec<Individual> = population.into_iter().take(self.params.elite).collect();
        next.extend(children.into_iter().flatten());
        next.truncate(size);
        sort(&mut next);
        next
    }

    /// Two children of two parents. A child that meets the blisk is eliminated and its parent lives on.
    fn children(&self, parents: [&Individual; 2], roulette: &Roulette, random: &mut ChaCha8Rng) -> [Individual; 2] {
        let better = parents[0].cost.min(parents[1].cost);
        let crosses = random.random_bool(self.params.crossover * roulette.disturbance(better));
        let cut = random.random_range(0..=chromosome_bits(&self.codings));
        let (left, right) = if crosses {
            cross(&self.codings, &parents[0].genes, &parents[1].genes, cut)
        } else {
            (parents[0].genes.clone(), parents[1].genes.clone())
        };
        let mut hint = 0;
        let mut grown = |mut genes: Genes, parent: &Individual| {
            let probability = self.params.mutation * roulette.disturbance(parent.cost);
            for (gene, coding) in genes.iter_mut().zip(&self.codings) {
                if random.random_bool(probability) {
                    *gene ^= 1 << random.random_range(0..coding.bits);
                }
            }
            if genes == parent.genes {
                return parent.clone();
            }
            self.individual(genes, &mut hint).unwrap_or_else(|| parent.clone())
        };
        let first = grown(left, parents[0]);
        [first, grown(right, parents[1])]
    }
}

fn sort(population: &mut [Individual]) {
    population.sort_by(|a, b| a.cost.total_cmp(&b.cost).then_with(|| a.genes.cmp(&b.genes)));
}

/// Roulette selection over costs, and the adaptive disturbance of Srinivas and Patnaik (1994).
struct Roulette {
    /// Running sums of the fitnesses.
    wheel: Vec<f64>,
    best: f64,
    mean: f64,
}

impl Roulette {
    /// A fitness that falls linearly with cost, the worst keeping a twentieth of the best's chance.
    fn new(costs: &[f64]) -> Self {
        let best = costs.iter().copied().fold(f64::INFINITY, f64::min);
        let worst = costs.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let mean = costs.iter().sum::<f64>() / costs.len() as f64;
        let width = worst - best;
        let fitness = |c: f64| if width > 0.0 { 0.05 + 0.95 * (worst - c) / width } else { 1.0 };
        let wheel = costs
            .iter()
            .scan(0.0, |sum, &c| {
                *sum += fitness(c);
                Some(*sum)
            })
            .collect();
        Self { wheel, best, mean }
    }

    fn spin(&self, random: &mut ChaCha8Rng) -> usize {
        let total = self.wheel.last().copied().unwrap_or(0.0);
        let ball = random.random_range(0.0..1.0) * total;
        self.wheel.partition_point(|&sum| sum <= ball).min(self.wheel.len() - 1)
    }

    /// 1 for what is worse than average, falling linearly to 0 for the best.
    fn disturbance(&self, cost: f64) -> f64 {
        if cost >= self.mean || self.mean <= self.best {
            1.0
        } else {
            ((cost - self.best) / (self.mean - self.best)).clamp(0.0, 1.0)
        }
    }
}

/// Whether the objective, the least of each generation, has not become better in the last `stall` generations; never for 0.
fn has_stalled(best: &[f64], stall: usize) -> bool {
    let least = |values: &[f64]| values.iter().copied().fold(f64::INFINITY, f64::min);
    stall > 0 && best.len() > stall && least(best) >= least(&best[..best.len() - stall])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_best_are_disturbed_least() {
        let roulette = Roulette::new(&[1.0, 2.0, 3.0, 6.0]);
        assert_eq!(roulette.disturbance(1.0), 0.0);
        assert_eq!(roulette.disturbance(2.0), 0.5);
        assert_eq!(roulette.disturbance(3.0), 1.0);
        assert_eq!(roulette.disturbance(6.0), 1.0);
        assert_eq!(Roulette::new(&[2.0; 4]).disturbance(2.0), 1.0, "a population of equals must not freeze");
    }

    #[test]
    fn the_roulette_favours_the_fit_in_proportion() {
        let roulette = Roulette::new(&[0.0, 1.0]);
        let mut random = ChaCha8Rng::seed_from_u64(3);
        let first = (0..21_000).filter(|_| roulette.spin(&mut random) == 0).count() as f64;
        // Fitnesses 1 and 0.05: expected 20000 with a standard deviation of 31.
        assert!((first - 20_000.0).abs() < 160.0, "{first}");
    }

    #[test]
    fn a_search_stalls_when_its_best_is_no_better_than_so_many_generations_before() {
        let best = [5.0, 4.0, 4.0, 3.0, 3.0, 3.0];
        let ends = |stall: usize| (1..=best.len()).find(|n| has_stalled(&best[..*n], stall));
        assert_eq!([0, 1, 2, 3].map(ends), [None, Some(3), Some(6), None]);
    }
}
