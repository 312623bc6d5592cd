//! Cylinders and cones: found from strips of facets that turn by equal steps, and grown as far as their points lie on
//! the fitted surface.

use std::collections::HashSet;

use glam::DVec3;
use rayon::prelude::*;

use super::facets::{Facets, Link};
use super::revolved::Revolved;
use super::topology::{NONE, Topology};
use task::{Cancel, Cancelled};

/// Facets taken before and after the two that a strip starts from.
const REACH: usize = 2;
/// Greatest ratio of two turns, one after the other, that are called equal.
const EQUAL_TURNS: f64 = 1.6;
/// Cosine of the greatest angle between two axes of turning, one after the other.
const EQUAL_AXES: f64 = 0.9;
/// Rounds of growing and fitting at most.
const ROUNDS: usize = 12;
/// Tolerances that are tried, each so many times as wide as the one before, the last being that of the settings. A
/// region is believed at the first one where the next hardly adds to it. A patch of another form grows with the
/// tolerance, and a wide tolerance takes in what goes on beside a cylinder.
const STEP: f64 = 4.0;
/// Number of tolerances.
const LEVELS: i32 = 5;
/// The part of the area within the next tolerance that must lie within one.
const FIRM_AREA: f64 = 0.8;
/// Times that a facet is taken into account where nothing comes of it.
const TRIALS: u8 = 4;
/// Greatest part of the mean area of a facet that a tilted one may have.
const NARROW: f64 = 0.5;
/// Cosine of the angle by which it may be tilted.
const TILTED: f64 = 0.6;
/// Facets of a region that may be there by chance.
const FEW: usize = 8;
/// Least angle that the normals of a curved face span.
const LEAST_SPAN_DEG: f64 = 1.0;

/// Limits within which facets lie on a cylinder or cone.
#[derive(Debug, Clone, Copy)]
pub(super) struct Limits {
    /// Greatest distance of a corner (mm).
    pub(super) tolerance: f64,
    /// Tolerance where corners are as exact as can be (mm).
    pub(super) least_tolerance: f64,
    /// Greatest angle between neighbouring facets (rad).
    pub(super) turn: f64,
    /// Cosine of the greatest angle between a facet and the surface: half a turn and something.
    pub(super) least_cosine: f64,
}

/// Facets on a cylinder or cone.
#[derive(Debug, Clone)]
pub(super) struct Region {
    pub(super) surface: Revolved,
    /// Whether the axis lies outside the material.
    pub(super) is_hollow: bool,
    pub(super) facets: Vec<u32>,
}

/// Facets side by side that turn by equal steps.
struct Strip {
    facets: Vec<u32>,
    is_hollow: bool,
}

/// The cylinders and cones among the facets; none shares a facet with another.
pub(super) fn find(
    topology: &Topology,
    facets: &Facets,
    limits: Limits,
    cancel: &Cancel,
) -> Result<Vec<Region>, Cancelled> {
    let mut grower = Grower {
        topology,
        facets,
        limits,
        is_taken: vec![false; facets.all.len()],
        seen: vec![0; facets.all.len()],
        round: 0,
    };
    let mut trials = vec![0u8; facets.all.len()];
    let mut found = Vec::new();
    for (i, link) in grower.pairs() {
        let pair = [i, link.to].map(|f| f as usize);
        if pair.iter().any(|&f| grower.is_taken[f]) || pair.iter().all(|&f| trials[f] >= TRIALS) {
            continue;
        }
        cancel.check()?;
        let Some(strip) = grower.strip(i, link) else { continue };
        match grower.region(&strip) {
            Ok(region) => {
                region.facets.iter().for_each(|&f| grower.is_taken[f as usize] = true);
                found.push(region);
            }
            Err(tried) => tried.iter().for_each(|&f| trials[f as usize] = trials[f as usize].saturating_add(1)),
        }
    }
    Ok(found)
}

struct Grower<'a> {
    topology: &'a Topology,
    facets: &'a Facets,
    limits: Limits,
    is_taken: Vec<bool>,
    seen: Vec<u32>,
    round: u32,
}

impl Grower<'_> {
    /// Facets side by side at a small angle, the largest first.
    fn pairs(&self) -> Vec<(u32, Link)> {
        let mut pairs = Vec::new();
        for i in 0..self.facets.all.len() as u32 {
            pairs.extend(self.facets.links(i).iter().filter(|l| l.to > i && self.is_smooth(l)).map(|&l| (i, l)));
        }
        let area = |f: u32| self.facets.all[f as usize].area;
        pairs.sort_by(|(i, a), (j, b)| (area(*j) + area(b.to)).total_cmp(&(area(*i) + area(a.to))));
        pairs
    }

    fn is_smooth(&self, link: &Link) -> bool {
        link.turn != 0.0 && link.turn.abs() <= self.limits.turn
    }

    /// The strip around two facets: at least three that turn by equal steps.
    fn strip(&self, i: u32, link: Link) -> Option<Strip> {
        let mut facets = vec![i, link.to];
        self.follow(&mut facets, link);
        facets.reverse();
        self.follow(&mut facets, Link { to: i, about: -link.about, ..link });
        let is_free = facets.iter().all(|&f| !self.is_taken[f as usize]);
        (facets.len() >= 3 && is_free).then_some(Strip { facets, is_hollow: link.turn < 0.0 })
    }

    /// Adds facets behind the last one of a strip, which was reached over `link`, as long as the turns are equal.
    fn follow(&self, strip: &mut Vec<u32>, mut link: Link) {
        for _ in 0..REACH {
            let onwards = self.facets.links(link.to).iter().filter(|next| {
                let ratio = next.turn / link.turn;
                self.is_smooth(next)
                    && (1.0 / EQUAL_TURNS..=EQUAL_TURNS).contains(&ratio)
                    && next.about.dot(link.about) >= EQUAL_AXES
                    && !strip.contains(&next.to)
            });
            let Some(next) = onwards.copied().reduce(|a, b| if b.length > a.length { b } else { a }) else { return };
            strip.push(next.to);
            link = next;
        }
    }

    /// A cylinder and a cone fitted to a strip, as far as they fit.
    fn starts(&self, strip: &Strip) -> impl Iterator<Item = Revolved> + use<> {
        let points = self.points(&strip.facets);
        let flats: Vec<_> = strip.facets.iter().map(|&f| self.facets.all[f as usize].flat).collect();
        let axis = flats.windows(2).map(|w| w[0].normal.cross(w[1].normal)).sum();
        let planes: Vec<_> = flats.iter().map(|flat| (flat.normal, flat.offset)).collect();
        let cylinder = Revolved::cylinder(&points, axis);
        let cone = Revolved::cone(&points, &planes);
        let (far, exact) = (100.0 * self.limits.tolerance, self.limits.least_tolerance);
        [cylinder, cone].into_iter().flatten().filter_map(move |start| {
            let is_near = points.iter().all(|&p| start.signed_distance(p).abs() < far);
            is_near.then(|| start.fitted(&points, 0.1 * exact))
        })
    }

    fn points(&self, facets: &[u32]) -> Vec<DVec3> {
        let mut corners: Vec<u32> =
            facets.iter().flat_map(|&f| self.facets.all[f as usize].corners.iter().copied()).collect();
        corners.sort_unstable();
        corners.dedup();
        corners.iter().map(|&v| self.topology.points[v as usize]).collect()
    }

    fn lie_on(&self, facets: &[u32], surface: &Revolved, is_hollow: bool, tolerance: f64) -> bool {
        facets.iter().all(|&f| self.lies_on(f, surface, is_hollow, tolerance))
    }

    /// Whether all corners of a facet lie on the surface, which it leaves in between no farther than half a turn.
    fn lies_on(&self, facet: u32, surface: &Revolved, is_hollow: bool, tolerance: f64) -> bool {
        let facet = &self.facets.all[facet as usize];
        // What a sliver's normal says is the rounding of its corners.
        let is_sliver = facet.width <= self.limits.tolerance;
        let normal = if is_hollow { -facet.flat.normal } else { facet.flat.normal };
        facet.corners.iter().map(|&v| self.topology.points[v as usize]).all(|p| {
            surface.signed_distance(p).abs() <= tolerance
                && (is_sliver || surface.normal(p).dot(normal) >= self.limits.least_cosine || self.is_tip(surface, p))
        })
    }

    /// Whether a point is the tip of a cone, where there is no normal.
    fn is_tip(&self, surface: &Revolved, p: DVec3) -> bool {
        let away = p - surface.origin;
        (away - surface.axis * away.dot(surface.axis)).length() <= 4.0 * self.limits.tolerance
    }

    /// The region grown from a strip, or the facets tried in vain.
    fn region(&mut self, strip: &Strip) -> Result<Region, Vec<u32>> {
        let mut tried = strip.facets.clone();
        for start in self.starts(strip) {
            let mut last: Option<Region> = None;
            for level in (0..LEVELS).rev() {
                let tolerance = self.limits.tolerance * STEP.powi(-level);
                if tolerance < self.limits.least_tolerance
                    || !self.lie_on(&strip.facets, &start, strip.is_hollow, tolerance)
                {
                    continue;
                }
                let region = self.grown(strip, start, tolerance);
                if let Some(last) = last.filter(|last| self.area(last) >= FIRM_AREA * self.area(&region))
                    && self.is_round(&last)
                {
                    return Ok(self.with_narrow(last, tolerance));
                }
                tried.extend(&region.facets);
                last = Some(region);
            }
        }
        tried.sort_unstable();
        tried.dedup();
        Err(tried)
    }

    /// Grows and fits in turn until nothing is added.
    fn grown(&mut self, strip: &Strip, start: Revolved, tolerance: f64) -> Region {
        let mut region = Region { surface: start, is_hollow: strip.is_hollow, facets: strip.facets.clone() };
        for _ in 0..ROUNDS {
            let facets = self.reached(strip, &region, tolerance);
            if facets.len() <= region.facets.len() {
                break;
            }
            region.surface = region.surface.fitted(&self.points(&facets), 0.0);
            region.facets = facets;
        }
        // The last fit may have left some a little outside.
        let (surface, is_hollow) = (region.surface, region.is_hollow);
        region.facets.retain(|&f| self.lies_on(f, &surface, is_hollow, tolerance));
        region
    }

    /// The facets on the surface that hang together with the strip.
    fn reached(&mut self, strip: &Strip, region: &Region, tolerance: f64) -> Vec<u32> {
        self.round += 1;
        let mut reached = strip.facets.clone();
        reached.iter().for_each(|&f| self.seen[f as usize] = self.round);
        let mut next = 0;
        while next < reached.len() {
            for link in self.facets.links(reached[next]) {
                let to = link.to as usize;
                if self.seen[to] == self.round || self.is_taken[to] {
                    continue;
                }
                self.seen[to] = self.round;
                if self.lies_on(link.to, &region.surface, region.is_hollow, tolerance) {
                    reached.push(link.to);
                }
            }
            next += 1;
        }
        reached
    }

    /// The region with narrow facets in its midst whose corners lie on the surface: these may be tilted, as one of
    /// which the long side runs around the axis.
    fn with_narrow(&self, mut region: Region, tolerance: f64) -> Region {
        let largest = NARROW * self.area(&region) / region.facets.len() as f64;
        let mut members: HashSet<u32> = region.facets.iter().copied().collect();
        let mut next = 0;
        while next < region.facets.len() {
            for link in self.facets.links(region.facets[next]) {
                let is_open = !self.is_taken[link.to as usize] && !members.contains(&link.to);
                if !is_open || self.facets.all[link.to as usize].area > largest {
                    continue;
                }
                let links = self.facets.links(link.to).iter();
                let (inside, all) = links.fold((0.0, 0.0), |(inside, all), l| {
                    (if members.contains(&l.to) { inside + l.length } else { inside }, all + l.length)
                });
                if inside >= 0.6 * all && self.lies_tilted_on(link.to, &region, tolerance) {
                    members.insert(link.to);
                    region.facets.push(link.to);
                }
            }
            next += 1;
        }
        region
    }

    fn lies_tilted_on(&self, facet: u32, region: &Region, tolerance: f64) -> bool {
        let facet = &self.facets.all[facet as usize];
        let normal = if region.is_hollow { -facet.flat.normal } else { facet.flat.normal };
        facet.corners.iter().map(|&v| self.topology.points[v as usize]).all(|p| {
            region.surface.signed_distance(p).abs() <= tolerance && region.surface.normal(p).dot(normal) >= TILTED
        })
    }

    fn area(&self, region: &Region) -> f64 {
        region.facets.iter().map(|&f| self.facets.all[f as usize].area).sum()
    }

    /// Whether the facets of a region are strips of a round face: several about as wide, and turned.
    fn is_round(&self, region: &Region) -> bool {
        let Some(first) = region.facets.first().map(|&f| self.facets.all[f as usize].flat.normal) else { return false };
        let normals = region.facets.iter().map(|&f| self.facets.all[f as usize].flat.normal);
        let span = normals.map(|n| n.angle_between(first)).fold(0.0, f64::max);
        let widths: Vec<f64> = region.facets.iter().map(|&f| self.width(f, &region.surface)).collect();
        let widest = widths.iter().copied().fold(0.0, f64::max);
        let alike = widths.iter().filter(|w| **w >= 0.5 * widest).count();
        alike >= 3 && span >= LEAST_SPAN_DEG.to_radians()
    }

    /// The angle around the axis that a facet spans.
    fn width(&self, facet: u32, surface: &Revolved) -> f64 {
        let facet = &self.facets.all[facet as usize];
        let (x, y) = (facet.flat.normal, surface.axis.cross(facet.flat.normal));
        let (mut low, mut high) = (0.0f64, 0.0f64);
        for p in facet.corners.iter().map(|&v| self.topology.points[v as usize]) {
            let away = surface.normal(p);
            let around = away.dot(y).atan2(away.dot(x).abs());
            (low, high) = (low.min(around), high.max(around));
        }
        high - low
    }
}

/// Whether each region is a row of a surface curved both ways, a sphere or a rounding: such rows go on at both ends
/// with facets about as long at a small angle, or at one end with such a row.
pub(super) fn rows(topology: &Topology, facets: &Facets, regions: &[Region], turn: [f64; 2]) -> Vec<bool> {
    let mut region_of = vec![NONE; facets.all.len()];
    for (i, region) in (0u32..).zip(regions) {
        region.facets.iter().for_each(|&f| region_of[f as usize] = i);
    }
    let ends: Vec<Ends> = regions
        .par_iter()
        .enumerate()
        .map(|(i, r)| Ends::of(topology, facets, &region_of, i as u32, r, turn))
        .collect();
    let mut is_row: Vec<bool> = ends.iter().map(Ends::all_go_on).collect();
    let mut queue: Vec<usize> = (0..regions.len()).filter(|&i| is_row[i]).collect();
    while let Some(i) = queue.pop() {
        for &j in &ends[i].next {
            let j = j as usize;
            if !is_row[j] && ends[j].next.contains(&(i as u32)) {
                is_row[j] = true;
                queue.push(j);
            }
        }
    }
    is_row
}

/// Whether each region is a few facets amid others like them: pieces of a free form that happen to fit.
pub(super) fn strays(facets: &Facets, regions: &[Region], turn: f64) -> Vec<bool> {
    let mut is_firm = vec![false; facets.all.len()];
    for region in regions.iter().filter(|r| r.facets.len() > FEW) {
        region.facets.iter().for_each(|&f| is_firm[f as usize] = true);
    }
    let is_stray = |region: &Region| {
        let (mut length, mut alike) = (0.0, 0.0);
        for &f in &region.facets {
            let own = &facets.all[f as usize];
            for link in facets.links(f).iter().filter(|link| !region.facets.contains(&link.to)) {
                length += link.length;
                let other = &facets.all[link.to as usize];
                let is_like = own.is_like(other) && other.is_like(own);
                if !is_firm[link.to as usize] && link.turn.abs() <= turn && is_like {
                    alike += link.length;
                }
            }
        }
        region.facets.len() <= FEW && alike > 0.8 * length
    };
    regions.iter().map(is_stray).collect()
}

/// How a cylinder or cone ends along its axis.
struct Ends {
    /// Length of the two ends (mm).
    length: [f64; 2],
    /// The part of it where facets about as long go on at a small angle.
    goes_on: [f64; 2],
    /// The regions that go on.
    next: Vec<u32>,
}

impl Ends {
    fn of(t: &Topology, facets: &Facets, region_of: &[u32], number: u32, region: &Region, turn: [f64; 2]) -> Self {
        let mut ends = Self { length: [0.0; 2], goes_on: [0.0; 2], next: Vec::new() };
        for &f in &region.facets {
            let facet = &facets.all[f as usize];
            let sides = facet.triangles.iter().flat_map(|&i| (0..3).map(move |k| (i as usize, k)));
            for (i, k) in sides {
                let beyond = t.neighbours[i][k];
                let other = if beyond == NONE { NONE } else { facets.of_triangle[beyond as usize] };
                if other != NONE && region_of[other as usize] == number {
                    continue;
                }
                let along = t.along_side(i, k);
                let generator = region.surface.generator(t.triangle(i)[k] + 0.5 * along);
                let outwards = along.cross(t.normals[i]).dot(generator);
                if outwards.abs() < 0.7 * along.length() {
                    continue;
                }
                let end = usize::from(outwards > 0.0);
                ends.length[end] += along.length();
                if other != NONE && goes_on(t, facets, [f, other], generator, turn) {
                    ends.goes_on[end] += along.length();
                    if region_of[other as usize] != NONE {
                        ends.next.push(region_of[other as usize]);
                    }
                }
            }
        }
        ends.next.sort_unstable();
        ends.next.dedup();
        ends
    }

    fn all_go_on(&self) -> bool {
        let total = self.length[0] + self.length[1];
        total > 0.0 && (0..2).all(|i| self.goes_on[i] >= 0.5 * self.length[i] || self.length[i] < 0.05 * total)
    }
}

fn goes_on(topology: &Topology, facets: &Facets, pair: [u32; 2], along: DVec3, [least, most]: [f64; 2]) -> bool {
    /// Facets of more corners are no pieces of a surface curved both ways.
    const MANY: usize = 64;
    let [a, b] = pair.map(|f| &facets.all[f as usize]);
    let turn = a.flat.normal.angle_between(b.flat.normal);
    if !(least..=most).contains(&turn) || a.corners.len() > MANY || b.corners.len() > MANY {
        return false;
    }
    let [a, b] = [a, b].map(|facet| {
        let heights = facet.corners.iter().map(|&v| topology.points[v as usize].dot(along));
        let (low, high) = heights.fold((f64::MAX, f64::MIN), |(l, h), z| (l.min(z), h.max(z)));
        high - low
    });
    a.max(b) <= 2.5 * a.min(b)
}
