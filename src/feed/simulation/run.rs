//! The tests that a simulation is made of.

use std::sync::atomic::{AtomicUsize, Ordering};

use rayon::prelude::*;

use super::bodies::{self, Bodies, Mover, Obstacle};
use super::copies::Copies;
use super::tour::{self, Leg, Phase};
use super::{Approach, PairReport, Place, Scenario, SimulationOptions, Visit, approach};
use crate::feed::certificate::Certificate;
use crate::feed::machine_model::Carrier;
use crate::feed::path::FeedPath;
use crate::feed::pose::Pose;
use crate::feed::verify::pair::{Near, Pair, PairClearance, TOUCHING};
use crate::geometry::mesh::Mesh;
use crate::progress::{Cancel, Cancelled, Progress};

/// A pair of bodies and the legs it is tested on.
struct Test<'a> {
    moving: &'a Mover,
    fixed: &'a Obstacle,
    /// Copies that stand for the body in every channel, and the legs that are then enough, indexing apart.
    copies: Option<(&'a Copies<'a>, Vec<Leg>)>,
    during: Option<&'static str>,
    required: f64,
    legs: Vec<Leg>,
    /// What is taken off for legs that stand for others (mm).
    allowance: f64,
}

impl<'a> Test<'a> {
    /// A pair on `legs`, with nothing to be said of them.
    fn new(moving: &'a Mover, fixed: &'a Obstacle, required: f64, legs: Vec<Leg>) -> Self {
        Self { moving, fixed, copies: None, during: None, required, legs, allowance: 0.0 }
    }
}

/// One simulation under way.
pub(super) struct Run<'a> {
    pub scenario: &'a Scenario<'a>,
    pub options: &'a SimulationOptions,
    pub bodies: &'a Bodies,
    pub cancel: &'a Cancel,
}

impl<'a> Run<'a> {
    /// The first way to the first row on which everything keeps its clearance; if there is none, the last one tried.
    pub fn approach(&self) -> Result<Approach, Cancelled> {
        let candidates = approach::candidates(self.scenario, self.options.clear_mm);
        for approach in &candidates {
            let leg = Leg { phase: Phase::Approach, channel: self.scenario.own_channel, poses: approach.poses.clone() };
            let tools = self.pairs().filter(|(moving, _)| !moving.on_table);
            let test =
                |(moving, fixed)| Test::new(moving, fixed, self.required_outside(moving, fixed), vec![leg.clone()]);
            let tests: Vec<Test> = tools.map(test).collect();
            let results: Result<Vec<_>, Cancelled> = tests.par_iter().map(|test| self.test(test)).collect();
            if results?.iter().flatten().all(PairReport::holds) {
                return Ok(approach.clone());
            }
        }
        Ok(candidates.into_iter().next().unwrap_or_default())
    }

    fn pairs(&self) -> impl Iterator<Item = (&'a Mover, &'a Obstacle)> + use<'a> {
        let bodies = self.bodies;
        let pairs = bodies.movers.iter().flat_map(|moving| bodies.obstacles.iter().map(move |fixed| (moving, fixed)));
        pairs.filter(|(moving, fixed)| moving.could_meet(fixed))
    }

    /// The clearance asked for outside the feed (mm). The electrode starts its feed where the plan withdrew it to, which
    /// may be nearer than bodies shall come.
    fn required_outside(&self, moving: &Mover, fixed: &Obstacle) -> f64 {
        let usual = self.scenario.machine.body_clearance_mm;
        if moving.is_electrode && fixed.is_blisk() {
            let at_start = self.scenario.feed.1.row_clearance().first().copied().unwrap_or(0.0);
            return usual.min(at_start - 2.0 * self.options.resolution_mm);
        }
        usual
    }

    /// What the certificates of feed and copying motion say of the electrode in its channel. On a blisk whose channels
    /// are alike to `error` (mm) it is said of all of them.
    pub fn feed_pairs(&self, error: f64) -> Vec<PairReport> {
        let feed = [(Phase::Feed, self.scenario.feed)];
        let copying = self.scenario.copying.map(|copying| (Phase::Copying, copying));
        let report = |(phase, (_, c)): (Phase, (&FeedPath, &Certificate))| PairReport {
            moving: "electrode".to_owned(),
            fixed: "blisk".to_owned(),
            during: Some(phase.name()),
            required: c.required() - c.tolerance(),
            certified: (c.certified() - error).max(0.0),
            least: Place {
                distance: c.least().distance,
                phase,
                channel: self.scenario.own_channel,
                row: c.least().row,
                pose: c.least().pose,
                on_moving: c.least().on_electrode,
                on_fixed: c.least().on_blisk,
            },
            contact: None,
        };
        feed.into_iter().chain(copying).map(report).collect()
    }

    /// What is found out about every pair.
    pub fn all(
        &self,
        approach: &Approach,
        visits: &[Visit],
        period_error: Option<f64>,
        progress: &Progress,
    ) -> Result<Vec<PairReport>, Cancelled> {
        let of = |table: &'a Mesh| Copies::new(table, visits, self.cancel);
        let tables = self.bodies.obstacles.iter().map(|o| o.table.as_ref());
        let copies: Vec<_> = tables.map(|t| t.map_or(Ok(None), of)).collect::<Result<_, _>>()?;
        let tests = self.tests(approach, visits, period_error, &copies);
        let done = AtomicUsize::new(0);
        let result = |test: &Test| {
            let result = self.test(test);
            let done = done.fetch_add(1, Ordering::Relaxed) + 1;
            progress.report("simulation", done as f64 / tests.len() as f64, &test.moving.name);
            result
        };
        let results: Result<Vec<_>, Cancelled> = tests.par_iter().map(result).collect();
        Ok(results?.into_iter().flatten().collect())
    }

    /// Every pair with the legs that it has to be tested on.
    fn tests<'t>(
        &self,
        approach: &Approach,
        visits: &[Visit],
        period_error: Option<f64>,
        copies: &'t [Option<Copies<'t>>],
    ) -> Vec<Test<'t>>
    where
        'a: 't,
    {
        let own = Visit { channel: self.scenario.own_channel, turn: 0.0 };
        let (feed, copying) = (self.scenario.feed.0, self.scenario.copying.map(|c| c.0));
        // The retraction keeps the clearances of the way in.
        let mut all = tour::whole(&approach.poses, feed, copying, visits);
        all.retain(|leg| leg.phase != Phase::Retract);
        let own_legs = tour::channel_legs(&approach.poses, feed, copying, &own);
        let in_feed = |leg: &Leg| matches!(leg.phase, Phase::Feed | Phase::Copying);
        let mut tests = Vec::new();
        let turned = tour::turned_leg(&all);
        for (moving, fixed) in self.pairs() {
            if moving.on_table {
                let required = self.required_outside(moving, fixed);
                tests.extend(turned.clone().map(|leg| Test::new(moving, fixed, required, vec![leg])));
                continue;
            }
            let at = self.bodies.obstacles.iter().position(|o| std::ptr::eq(o, fixed));
            let copies = at.and_then(|i| copies[i].as_ref());
            let is_feed_pair = moving.is_electrode && fixed.is_blisk();
            let (mut legs, allowance) = match fixed.carrier {
                // A moves a tool neither against the bed nor against the head.
                Some(Carrier::Bed | Carrier::Head) => (own_legs.clone(), 0.0),
                Some(_) => (all.clone(), 0.0),
                None => match period_error {
                    Some(error) => (
                        own_legs.iter().cloned().chain(tour::widest_index_leg(&approach.poses, visits)).collect(),
                        error,
                    ),
                    None => (all.clone(), 0.0),
                },
            };
            if is_feed_pair {
                let required = self.scenario.feed.1.required() - self.scenario.feed.1.tolerance();
                let in_channel: Vec<Leg> =
                    legs.iter().filter(|l| in_feed(l) && l.channel != own.channel).cloned().collect();
                legs.retain(|leg| !in_feed(leg));
                if !in_channel.is_empty() {
                    let during = Some("feed in other channels");
                    tests.push(Test { during, ..Test::new(moving, fixed, required, in_channel) });
                }
            }
            let during = is_feed_pair.then_some("moves outside");
            let required = self.required_outside(moving, fixed);
            let copies = copies.map(|copies| (copies, own_legs.clone()));
            tests.push(Test { moving, fixed, copies, during, required, legs, allowance });
        }
        tests
    }

    /// The clearance of a pair over its legs; none if one of the two has no surface.
    fn test(&self, test: &Test) -> Result<Option<PairReport>, Cancelled> {
        let pair = Pair {
            moving: &test.moving.solid,
            fixed: &test.fixed.solid,
            // In a channel the gap itself is narrow.
            resolution: self.options.resolution_mm.min(0.005 * test.required).max(1e-9),
            required: test.required,
            share: self.options.resolution_share,
        };
        let may_be_joined = match test.fixed.carrier {
            Some(Carrier::Head) => !test.moving.is_electrode,
            Some(Carrier::Bed) => test.moving.on_table && test.moving.name != "blisk",
            _ => false,
        };
        if may_be_joined && self.are_joined(&pair)? {
            return Ok(None);
        }
        let mut known: Option<Known> = None;
        if let Some((copies, legs)) = &test.copies {
            known = self.over(legs.iter(), &Pair { fixed: &copies.solid, ..pair }, test, None)?;
            let place = known.as_mut().map(|k| &mut k.place);
            if let Some((place, (visit, on_body))) = place.and_then(|p| copies.visit_at(p.on_fixed).map(|at| (p, at))) {
                (place.channel, place.pose.a, place.on_fixed) = (visit.channel, place.pose.a + visit.turn, on_body);
            }
        }
        let is_left = |leg: &&Leg| test.copies.is_none() || leg.phase == Phase::Index;
        let known = self.over(test.legs.iter().filter(is_left), &pair, test, known)?;
        let Some(Known { clearance: PairClearance { certified, .. }, place: least }) = known else { return Ok(None) };
        let contact =
            if certified <= 0.0 || certified < pair.resolution { self.first_contact(&pair, test)? } else { None };
        Ok(Some(PairReport {
            moving: test.moving.name.clone(),
            fixed: test.fixed.name.clone(),
            during: test.during,
            required: test.required,
            certified: (certified - test.allowance).max(0.0),
            least,
            contact,
        }))
    }

    /// Whether two bodies touch in the final pose already: the one turns in the other, as in a bearing.
    fn are_joined(&self, pair: &Pair) -> Result<bool, Cancelled> {
        let at_rest = pair.clearance(&[Pose::FINAL], None, self.cancel)?;
        Ok(at_rest.is_some_and(|clearance| clearance.least.distance <= TOUCHING))
    }

    /// The clearance of `pair` over `legs` and what is `known` already.
    fn over<'l>(
        &self,
        legs: impl Iterator<Item = &'l Leg>,
        pair: &Pair,
        test: &Test,
        mut known: Option<Known>,
    ) -> Result<Option<Known>, Cancelled> {
        // Feeds first: they come nearest, and what is known to be farther off is soon done with.
        let (feeds, others): (Vec<&Leg>, Vec<&Leg>) = legs.partition(|leg| leg.phase == Phase::Feed);
        for leg in feeds.into_iter().chain(others) {
            let poses = bodies::relative(&leg.poses, test.moving, test.fixed);
            let before = known.as_ref().map(|k| k.clearance);
            let Some(clearance) = pair.clearance(&poses, before, self.cancel)? else { return Ok(None) };
            let place = match known {
                Some(k) if k.clearance.least == clearance.least => k.place,
                _ => place(leg, &clearance.least),
            };
            known = Some(Known { clearance, place });
        }
        Ok(known)
    }

    fn first_contact(&self, pair: &Pair, test: &Test) -> Result<Option<Place>, Cancelled> {
        for leg in &test.legs {
            let poses = bodies::relative(&leg.poses, test.moving, test.fixed);
            if let Some(near) = pair.first_contact(&poses, self.cancel)? {
                return Ok(Some(place(leg, &near)));
            }
        }
        Ok(None)
    }
}

/// What is known of a pair, and where in the whole motion it comes closest.
struct Known {
    clearance: PairClearance,
    place: Place,
}

/// Where `near`, on the poses of `leg` relative to a pair of bodies, is in the whole motion.
fn place(leg: &Leg, near: &Near) -> Place {
    Place {
        distance: near.distance,
        phase: leg.phase,
        channel: leg.channel,
        row: near.row,
        pose: leg.pose_at(near.row),
        on_moving: near.on_moving,
        on_fixed: near.on_fixed,
    }
}
