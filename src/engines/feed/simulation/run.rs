//! The tests that a simulation is made of.

use glam::DMat3;
use rayon::prelude::*;

use super::approach::{self, Approach};
use super::bodies::{self, Bodies, Mover, Obstacle};
use super::copies::Copies;
use super::findings::{Findings, PairReport, Place, Simulation};
use super::pace::Pace;
use super::tour::{self, Leg, Legs, Phase, Visit};
use super::{Scenario, SimulationOptions, periodic};
use crate::certificate::{Certificate, Contact};
use crate::machine_model::Carrier;
use crate::path::FeedPath;
use crate::pose::Pose;
use crate::verify::pair::{Near, Pair, PairClearance, TOUCHING};
use geometry::mesh::Mesh;
use task::{Cancelled, Task};

/// Share of the usual resolution at which channels are tested where that proves too little.
const FINER: f64 = 0.1;

/// Simulates the whole motion.
///
/// # Errors
/// [`Cancelled`]. A collision is an answer.
pub fn simulate(scenario: &Scenario, options: &SimulationOptions, task: &Task) -> Result<Simulation, Cancelled> {
    task.report("simulation", 0.0, "bodies");
    let bodies = Bodies::new(scenario, &task.cancel)?;
    let (visits, out_of_reach) = tour::visits(scenario, &options.channels);
    let period_error = periodic::error_of(scenario.blisk, visits.iter().map(|v| v.turn), &task.cancel)?;
    let mut run = Run { scenario, options, bodies: &bodies, visits: &visits, period_error, fineness: 1.0, task };
    let copies = run.copies()?;
    let (mut approach, mut pairs) = run.found(&copies)?;
    // What one channel proves for all of them is less by what they differ by, and every proof by its resolution: where that
    // is too little, each is tested itself, more finely.
    if pairs.iter().any(PairReport::is_short) {
        (run.period_error, run.fineness) = (None, FINER);
        (approach, pairs) = run.found(&copies)?;
    }
    pairs.sort_by(|p, q| (p.certified - p.required).total_cmp(&(q.certified - q.required)));
    let chain = bodies.chain;
    let legs = tour::whole(&approach.poses, &run.paths(), &visits);
    Ok(Simulation::of(Findings {
        path_digest: scenario.feed.0.digest(),
        copying_digest: scenario.copying.map(|(path, _)| path.digest()),
        blisk_digest: scenario.blisk.digest(),
        electrode_digest: scenario.electrode.mesh.digest(),
        travel: tour::out_of_travel(&chain, &legs, scenario.machine),
        minutes: tour::minutes(&chain, &legs, scenario.machine),
        approach: approach.poses,
        visits,
        out_of_reach,
        pairs,
        period_error,
        model_digest: scenario.model.digest(),
        preset: scenario.preset.copied(),
        with_bodies: scenario.machine.has_bodies(),
        body_clearance_mm: scenario.machine.body_clearance_mm,
        enters_from: scenario.electrode.enters_from,
        mounting: scenario.machine.mounting(scenario.electrode.enters_from),
        chain,
        bodies: bodies::placed(scenario),
    }))
}

/// A pair of bodies and the legs it is tested on.
struct Test<'a> {
    moving: &'a Mover,
    fixed: &'a Obstacle,
    /// Copies that stand for the body in every channel, and the legs that are then enough, indexing apart.
    copies: Option<(&'a Copies<'a>, &'a [Leg])>,
    during: Option<&'static str>,
    required: f64,
    legs: Vec<&'a Leg>,
    /// Allowance taken off for legs that stand for others (mm).
    allowance: f64,
}

impl<'a> Test<'a> {
    /// A pair on `legs`, with nothing to be said of them.
    fn new(moving: &'a Mover, fixed: &'a Obstacle, required: f64, legs: Vec<&'a Leg>) -> Self {
        Self { moving, fixed, copies: None, during: None, required, legs, allowance: 0.0 }
    }

    /// Whether the pair is tested on `leg`: copies of the fixed body may make that needless.
    fn is_on(&self, leg: &Leg) -> bool {
        self.copies.is_none() || leg.phase == Phase::Index
    }

    /// Number of legs that the pair is tested on.
    fn walked(&self) -> usize {
        let own = self.copies.map_or(0, |(_, own)| own.len());
        own + self.legs.iter().filter(|leg| self.is_on(leg)).count()
    }
}

/// One simulation under way.
pub(super) struct Run<'a> {
    pub scenario: &'a Scenario<'a>,
    pub options: &'a SimulationOptions,
    pub bodies: &'a Bodies,
    pub visits: &'a [Visit],
    /// Greatest distance of the blisk from itself turned to other channels (mm); none if its channels differ.
    pub period_error: Option<f64>,
    /// Share of the usual resolution.
    pub fineness: f64,
    pub task: &'a Task,
}

impl<'a> Run<'a> {
    /// The way to the first row, and what is found of every pair on the whole motion.
    fn found(&self, copies: &[Option<Copies>]) -> Result<(Approach, Vec<PairReport>), Cancelled> {
        self.task.report("simulation", 0.0, "approach");
        let approach = self.approach(copies)?;
        let mut pairs = Vec::new();
        // Without a feed there is nothing to say of any pair.
        if !self.scenario.feed.0.rows.is_empty() {
            pairs.extend(self.feed_pairs());
            pairs.extend(self.all(&approach, copies)?);
        }
        Ok((approach, pairs))
    }

    /// The first way to the first row on which everything keeps its clearance in every channel; if there is none, the
    /// first that does in one of them, and then the first of all.
    pub fn approach(&self, copies: &[Option<Copies>]) -> Result<Approach, Cancelled> {
        let candidates = approach::candidates(self.scenario, &self.bodies.chain, self.options.clear_mm);
        let one = [self.representative()];
        for (visits, copies) in [(self.visits, copies), (&one[..], &[][..])] {
            for approach in &candidates {
                if self.is_clear(approach, visits, copies)? {
                    return Ok(approach.clone());
                }
            }
        }
        Ok(candidates.into_iter().next().unwrap_or_default())
    }

    /// Whether the tool keeps its clearances on the approach to `visits` and between them.
    fn is_clear(&self, approach: &Approach, visits: &[Visit], copies: &[Option<Copies>]) -> Result<bool, Cancelled> {
        let legs = Legs::new(&approach.poses, &[], self.scenario.own_channel, visits);
        let tests: Vec<Test> = self.tests(&legs, copies).into_iter().filter(|test| !test.moving.on_table).collect();
        let silent = Task::silent(&self.task.cancel);
        let pace = Pace::new(&silent, self.visits, 0);
        let results: Result<Vec<_>, Cancelled> = tests.par_iter().map(|test| self.test(test, &legs, &pace)).collect();
        Ok(results?.iter().flatten().all(PairReport::holds))
    }

    /// The channel that reports name for what was tested in the channel of the plan: that one if it is burnt, otherwise
    /// the first that is.
    fn representative(&self) -> Visit {
        let own = Visit { channel: self.scenario.own_channel, turn: 0.0 };
        let visited = self.visits.iter().find(|visit| visit.turn == 0.0).or(self.visits.first());
        visited.copied().unwrap_or(own)
    }

    /// Every pair that could meet, with the number of the body that stands still.
    fn pairs(&self) -> impl Iterator<Item = (&'a Mover, usize, &'a Obstacle)> + use<'a> {
        let bodies = self.bodies;
        let with_all = |moving| bodies.obstacles.iter().enumerate().map(move |(i, fixed)| (moving, i, fixed));
        bodies.movers.iter().flat_map(with_all).filter(|(moving, _, fixed)| moving.could_meet(fixed, &bodies.chain))
    }

    /// The feed and the copying motion with the rows that the machine needs.
    fn paths(&self) -> Vec<(Phase, Vec<Pose>)> {
        tour::paths(&self.bodies.chain, self.scenario.feed.0, self.scenario.copying.map(|c| c.0))
    }

    /// The clearance asked for outside the feed (mm). The electrode starts its feed where the plan withdrew it to,
    /// which may be nearer than bodies shall come; `allowance` is taken off what is proven there (mm).
    fn required_outside(&self, moving: &Mover, fixed: &Obstacle, allowance: f64) -> f64 {
        let usual = self.scenario.machine.body_clearance_mm;
        if moving.is_electrode && fixed.is_blisk() {
            let at_start = self.scenario.feed.1.row_clearance().first().copied().unwrap_or(0.0);
            return usual.min(at_start - 2.0 * self.options.resolution_mm - allowance);
        }
        usual
    }

    /// Whether `certificate` holds and is that of this very path and these very meshes.
    fn is_proven(&self, path: &FeedPath, certificate: &Certificate) -> bool {
        let Scenario { blisk, electrode, .. } = self.scenario;
        certificate.keeps_clearance()
            && certificate.path_digest() == path.digest()
            && certificate.blisk_digest() == blisk.digest()
            && certificate.electrode_digest() == electrode.mesh.digest()
    }

    /// Clearances of the electrode in its channel by the certificates of feed and copying motion. On a blisk whose
    /// channels are alike they hold for all channels; otherwise only for the planned channel, if it is burnt. A
    /// certificate that proves nothing of this motion is reported with a clearance of 0.
    pub fn feed_pairs(&self) -> Vec<PairReport> {
        let is_burnt = self.period_error.is_some() || self.representative().turn == 0.0;
        let error = self.period_error.unwrap_or(0.0);
        let feed = [(Phase::Feed, self.scenario.feed)];
        let copying = self.scenario.copying.map(|copying| (Phase::Copying, copying));
        let chain = &self.bodies.chain;
        let place = |phase, path: &FeedPath, least: &Contact| Place {
            distance: least.distance,
            phase,
            channel: self.scenario.own_channel,
            row: chain.refined_place(&path.rows, least.row),
            pose: least.pose,
            on_moving: least.on_electrode,
            on_fixed: least.on_blisk,
        };
        let report = |(phase, (path, c)): (Phase, (&FeedPath, &Certificate))| {
            let is_proven = self.is_proven(path, c);
            (is_burnt || !is_proven).then(|| PairReport {
                moving: "electrode".to_owned(),
                fixed: "blisk".to_owned(),
                during: Some(phase.name()),
                required: c.required() - c.tolerance(),
                certified: if is_proven { (c.certified() - error - chain.deviation()).max(0.0) } else { 0.0 },
                least: self.visited(place(phase, path, c.least()), true, self.representative()),
                contact: None,
            })
        };
        feed.into_iter().chain(copying).filter_map(report).collect()
    }

    /// Copies of every table for all channels, in the order of the bodies that stand still.
    pub fn copies(&self) -> Result<Vec<Option<Copies<'a>>>, Cancelled> {
        let of = |table: &'a Mesh| Copies::new(table, self.visits, &self.task.cancel);
        let tables = self.bodies.obstacles.iter().map(|o| o.table.as_ref());
        tables.map(|table| table.map_or(Ok(None), of)).collect()
    }

    /// Reports on every pair of bodies.
    pub fn all(&self, approach: &Approach, copies: &[Option<Copies>]) -> Result<Vec<PairReport>, Cancelled> {
        let legs = Legs::new(&approach.poses, &self.paths(), self.scenario.own_channel, self.visits);
        let tests = self.tests(&legs, copies);
        let pace = Pace::new(self.task, self.visits, tests.iter().map(Test::walked).sum());
        let results: Result<Vec<_>, Cancelled> = tests.par_iter().map(|test| self.test(test, &legs, &pace)).collect();
        Ok(results?.into_iter().flatten().collect())
    }

    /// Every pair with those of `legs` that it has to be tested on.
    fn tests<'t>(&self, legs: &'t Legs, copies: &'t [Option<Copies<'t>>]) -> Vec<Test<'t>>
    where
        'a: 't,
    {
        let mut tests = Vec::new();
        for (moving, at, fixed) in self.pairs() {
            let (mut on, allowance) = self.legs_against(moving, fixed, legs);
            let required = self.required_outside(moving, fixed, allowance);
            if moving.on_table {
                let turned = |leg| Test { allowance, ..Test::new(moving, fixed, required, vec![leg]) };
                tests.extend(legs.turned.iter().map(turned));
                continue;
            }
            let mut during = None;
            if moving.is_electrode && fixed.is_blisk() {
                // In its own channel it is the matter of the certificates.
                let (in_feed, outside): (Vec<_>, Vec<_>) =
                    on.into_iter().partition(|leg| matches!(leg.phase, Phase::Feed | Phase::Copying));
                let elsewhere: Vec<_> =
                    in_feed.into_iter().filter(|leg| leg.channel != self.scenario.own_channel).collect();
                if !elsewhere.is_empty() {
                    let required = self.scenario.feed.1.required() - self.scenario.feed.1.tolerance();
                    let during = Some("feed in other channels");
                    let allowance = self.bodies.chain.deviation();
                    tests.push(Test { during, allowance, ..Test::new(moving, fixed, required, elsewhere) });
                }
                (on, during) = (outside, Some("moves outside"));
            }
            let copies = copies.get(at).and_then(Option::as_ref).map(|copies| (copies, &legs.own[..]));
            let copies = copies.filter(|_| !moving.on_bed);
            tests.push(Test { copies, during, allowance, ..Test::new(moving, fixed, required, on) });
        }
        tests
    }

    /// The legs that `moving` has to be tested on against `fixed`, and the allowance taken off because they stand for
    /// others, or the machine does not keep to the poses (mm).
    fn legs_against<'t>(&self, moving: &Mover, fixed: &Obstacle, legs: &'t Legs) -> (Vec<&'t Leg>, f64) {
        let deviation = self.bodies.chain.deviation();
        let (legs, allowance) = match (fixed.carrier, self.period_error) {
            // A moves a tool neither against cradle and bed nor against the head, and the bed not against the cradle.
            (Some(Carrier::Cradle | Carrier::Bed | Carrier::Head), _) => (legs.own.iter().collect(), 0.0),
            _ if moving.on_bed => (legs.all.iter().collect(), 0.0),
            (None, Some(error)) => {
                let index = legs.widest_index();
                // Two ways between channels are alike since each is like one about the plan's channel: what channels
                // differ by counts twice.
                let steps = if index.is_some() { 2.0 } else { 1.0 };
                (legs.own.iter().chain(index).collect(), steps * error)
            }
            _ => (legs.all.iter().collect(), 0.0),
        };
        (legs, allowance + deviation)
    }

    /// The clearance of a pair over its legs; none if one of the two has no surface.
    fn test(&self, test: &Test, legs: &Legs, pace: &Pace) -> Result<Option<PairReport>, Cancelled> {
        let pair = Pair {
            moving: &test.moving.solid,
            fixed: &test.fixed.solid,
            // In a channel the gap itself is narrow.
            resolution: (self.fineness * self.options.resolution_mm.min(0.005 * test.required)).max(1e-9),
            required: test.required,
            share: self.options.resolution_share,
        };
        let may_be_joined = match test.fixed.carrier {
            Some(Carrier::Head) => !test.moving.is_electrode,
            Some(Carrier::Cradle | Carrier::Bed) if test.moving.on_table => test.moving.name != "blisk",
            Some(Carrier::Cradle | Carrier::Table) => test.moving.on_bed,
            _ => false,
        };
        if may_be_joined && self.are_joined(&pair)? {
            return Ok(None);
        }
        let (mut known, mut is_found): (Option<Known>, _) = (None, true);
        if let Some((copies, own)) = test.copies {
            known = self.over(own.iter(), &Pair { fixed: &copies.solid, ..pair }, test, None, pace)?;
            if let Some(Known { place, .. }) = &mut known {
                let found = copies.visit_at(place.on_fixed, &self.task.cancel)?;
                is_found = found.is_some();
                if let Some((visit, on_body)) = found {
                    (place.channel, place.pose.a, place.on_fixed) = (visit.channel, place.pose.a + visit.turn, on_body);
                }
            }
        }
        let left = test.legs.iter().copied().filter(|leg| test.is_on(leg));
        let known = self.over(left, &pair, test, known, pace)?;
        let Some(Known { clearance: PairClearance { certified, .. }, place: least }) = known else { return Ok(None) };
        let contact =
            if certified <= 0.0 || certified < pair.resolution { self.first_contact(&pair, test, legs)? } else { None };
        // Inside a copy no point tells which one it is; the first contact does.
        let least = contact.filter(|_| !is_found).unwrap_or(least);
        let in_tour = |place: Place| match (test.moving.on_table, test.moving.on_bed) {
            (true, _) => passed(place, legs),
            // It is tested in every channel itself.
            (_, true) if test.fixed.carrier != Some(Carrier::Cradle) => place,
            _ => self.visited(place, test.fixed.is_blisk(), self.representative()),
        };
        Ok(Some(PairReport {
            moving: test.moving.name.clone(),
            fixed: test.fixed.name.clone(),
            during: test.during,
            required: test.required,
            certified: (certified - test.allowance).max(0.0),
            least: in_tour(least),
            contact: contact.map(|place| self.first_in_tour(place, test)),
        }))
    }

    /// A contact in the channel that it comes about in first: what is tested in the channel of the plan for all of them
    /// happens in every one.
    fn first_in_tour(&self, place: Place, test: &Test) -> Place {
        let is_for_all = match test.fixed.carrier {
            Some(Carrier::Head | Carrier::Cradle | Carrier::Bed) => !test.moving.on_table,
            Some(Carrier::Electrode | Carrier::Table) => false,
            None => self.period_error.is_some() && !test.moving.on_bed,
        };
        let first = self.visits.first().copied().filter(|_| is_for_all);
        first.map_or(place, |visit| self.visited(place, test.fixed.is_blisk(), visit))
    }

    /// `place` told of `visit`, if it is in the channel of the plan. The blisk looks the same from there, with another
    /// point in its place, and what A does not move is as near.
    fn visited(&self, place: Place, is_on_blisk: bool, visit: Visit) -> Place {
        if visit.turn == 0.0 || place.phase == Phase::Index || place.channel != self.scenario.own_channel {
            return place;
        }
        let turned = DMat3::from_rotation_x(visit.turn) * place.on_fixed;
        Place {
            channel: visit.channel,
            pose: Pose { a: place.pose.a + visit.turn, ..place.pose },
            on_fixed: if is_on_blisk { turned } else { place.on_fixed },
            ..place
        }
    }

    /// Whether two bodies touch in the final pose already: the one turns in the other, as in a bearing.
    fn are_joined(&self, pair: &Pair) -> Result<bool, Cancelled> {
        let at_rest = pair.clearance(&[Pose::FINAL], None, &self.task.cancel)?;
        Ok(at_rest.is_some_and(|clearance| clearance.least.distance <= TOUCHING))
    }

    /// The clearance of `pair` over `legs` and what is `known` already.
    fn over<'l>(
        &self,
        legs: impl Iterator<Item = &'l Leg>,
        pair: &Pair,
        test: &Test,
        mut known: Option<Known>,
        pace: &Pace,
    ) -> Result<Option<Known>, Cancelled> {
        // Feeds first: they come nearest, and what is known to be farther off is soon done with.
        let (mut legs, others): (Vec<&Leg>, Vec<&Leg>) = legs.partition(|leg| leg.phase == Phase::Feed);
        legs.extend(others);
        for leg in &legs {
            let poses = bodies::relative(&self.bodies.chain, &leg.poses, test.moving, test.fixed);
            let before = known.as_ref().map(|k| k.clearance);
            pace.begin(&test.moving.name, leg, &legs);
            let clearance = pair.clearance(&poses, before, &self.task.cancel)?;
            pace.end();
            let Some(clearance) = clearance else { continue };
            let place = match known {
                Some(k) if k.clearance.least == clearance.least => k.place,
                _ => place(leg, &clearance.least),
            };
            known = Some(Known { clearance, place });
        }
        Ok(known)
    }

    /// The first contact in the order of time. What A turns is tested over all that A goes through, in one go that
    /// knows no order, so that the tour itself is walked.
    fn first_contact(&self, pair: &Pair, test: &Test, legs: &Legs) -> Result<Option<Place>, Cancelled> {
        let tour: Vec<&Leg> = if test.moving.on_table { legs.all.iter().collect() } else { test.legs.clone() };
        for leg in tour {
            let poses = bodies::relative(&self.bodies.chain, &leg.poses, test.moving, test.fixed);
            if let Some(near) = pair.first_contact(&poses, &self.task.cancel)? {
                return Ok(Some(place(leg, &near)));
            }
        }
        Ok(None)
    }
}

/// Clearance of a pair, and where in the whole motion it is least.
struct Known {
    clearance: PairClearance,
    place: Place,
}

/// Instant at which the whole motion first takes A to the value at `place`: what only A moves has the same distance
/// there.
fn passed(place: Place, legs: &Legs) -> Place {
    match legs.passing(place.pose.a) {
        Some((leg, row)) => Place { phase: leg.phase, channel: leg.channel, row, pose: leg.pose_at(row), ..place },
        None => place,
    }
}

/// Place in the whole motion of `near`, which is on the poses of `leg` relative to a pair of bodies.
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
