//! Hub and shroud of a passage in any direction, met by rays along the lines across it.

use glam::DVec2;

use super::super::channel::{Flow, Station, Surface};
use super::super::error::BliskError;
use super::super::frame::slices::Gap;
use super::flow::{Lines, MOST_STEEP, STEEP, steep_share};
use super::meridian::{DIP, MIDDLE_SHARE, Meridian, Place, RAYS, Tracer};

/// Share of the height away from an end wall where its rays begin, and how far beyond it they look for it.
const BESIDE: f64 = 0.2;
/// Shares of the passage's width over which an end wall is met: the middle, and more where a hole takes that.
const OVER: [f64; 4] = [MIDDLE_SHARE, 0.7, 0.8, 0.9];
/// Shares of the width in which there is wall between large fillets.
const BETWEEN_FILLETS: [f64; 2] = [0.3, 0.15];
/// An end wall that goes on bends away by less than this share of the height from one station to the next: by no more than
/// about 20 deg, as the facets of coarse meshes do.
const GOES_ON: f64 = 0.02;
/// A last station nearer to the one before than this share of their steps takes its place.
const LEAST_STEP: f64 = 0.1;
/// Lines at either end that may lie beyond the end walls.
const LAST_LINES: usize = 5;
/// Most stations beside the blades at either end.
const MOST_BESIDE: usize = 400;
/// Steps of the height in which the tips are looked for, and how far (shares of the height).
const TIP_STEPS: usize = 40;
const MOST_TIP: f64 = 1.5;
/// The tips are where the line across was drawn to, within so many points of its lattice or this share of the height.
const MOST_OFF: f64 = 3.0;
const MOST_OFF_SHARE: f64 = 0.03;
/// End walls face the rays to them at least so squarely (cosine).
const LEAST_FACING: f64 = 0.3;
/// Steps in which the channel's gap is followed across the passage.
const STEPS: usize = 12;

/// The channel's gap at the middle of a station and where its rays begin; beside the blades those of their edges.
#[derive(Clone, Copy)]
struct Gaps {
    hub: Gap,
    middle: Gap,
    shroud: Gap,
}

impl Tracer<'_> {
    /// Hub and shroud along `lines` and on along the rings beside the blades, as far as both reach. `start` is a place
    /// between the blades; the one that is returned with them is in the middle of a station.
    pub(super) fn tube(&self, start: Place, known: &Lines) -> Result<(Meridian, Place), BliskError> {
        let lost = |at: DVec2| BliskError::LostWall { x: at.x, r: at.y };
        let at = DVec2::new(start.x, start.r);
        let far = |line: &[DVec2; 2]| (0.5 * (line[0] + line[1])).distance_squared(at);
        let lines = &known.lines;
        let Some(first) = (0..lines.len()).min_by(|&a, &b| far(&lines[a]).total_cmp(&far(&lines[b]))) else {
            return Err(lost(at));
        };
        let middle = station(lines[first]);
        let gap = self.followed(&start.gap, at, middle.place(0.5))?;
        let across = |share: f64| self.followed(&gap, middle.place(0.5), middle.place(share)).unwrap_or(gap);
        let gaps = Gaps { hub: across(BESIDE), middle: gap, shroud: across(1.0 - BESIDE) };
        let measured = self.measured(lines[first], &gaps, known, false).ok_or(lost(middle.place(0.5)))?;
        let mut stations = self.outwards(measured, lines[..first].iter().rev().copied(), known)?;
        stations.reverse();
        let index = stations.len();
        stations.push(measured.0);
        stations.extend(self.outwards(measured, lines[first + 1..].iter().copied(), known)?);
        let mut along = 0.0;
        for i in 1..stations.len() {
            let (before, here) = (stations[i - 1], stations[i]);
            let step = here.place(0.5) - before.place(0.5);
            let advances = [here.hub - before.hub, here.shroud - before.shroud].iter().all(|d| d.dot(step) > 0.0);
            if !advances {
                return Err(lost(here.place(0.5)));
            }
            along += step.length();
            stations[i].along = along;
        }
        let middle: Vec<DVec2> = stations.iter().map(|s| s.place(0.5)).collect();
        let is_radial = steep_share(&middle, STEEP).min(known.steep) >= 1.0 - MOST_STEEP;
        let flow = if is_radial { Flow::Radial } else { Flow::Mixed };
        let here = stations[index];
        let at = here.place(0.5);
        let place = Place { along: here.along, x: at.x, r: at.y, gap: measured.1.middle };
        Ok((Meridian { stations, flow, shrouded: known.shrouded }, place))
    }

    /// Stations of `lines` beyond a known one, and from there on at equal steps up to where an end wall ends.
    fn outwards(
        &self,
        from: (Station, Gaps),
        lines: impl ExactSizeIterator<Item = [DVec2; 2]>,
        known: &Lines,
    ) -> Result<Vec<Station>, BliskError> {
        let (mut here, mut gaps) = from;
        let mut stations = Vec::new();
        let count = lines.len();
        for (i, line) in lines.enumerate() {
            self.cancel.check()?;
            let at = station(line).place(0.5);
            let Some(next) = self.measured(line, &gaps, known, false) else {
                // The lines are found to about a point of the lattice: the last ones may lie beyond the end walls'
                // ends.
                if i + LAST_LINES >= count {
                    break;
                }
                return Err(BliskError::LostWall { x: at.x, r: at.y });
            };
            stations.push(next.0);
            (here, gaps) = next;
        }
        let mut step = match stations[..] {
            [.., before, last] => onwards(before, last, known),
            _ => return Ok(stations),
        };
        // Beside the tips, and between two drawn curves, nothing ends the passage, which is as long as it is high there.
        let [hub, shroud] = [Surface::Hub, Surface::Shroud].map(|surface| self.is_drawn(surface));
        let most = if known.shrouded && !(hub && shroud) {
            MOST_BESIDE
        } else {
            (here.height() / step[0].length().max(1e-3 * here.height())) as usize
        };
        for _ in 0..most.min(MOST_BESIDE) {
            self.cancel.check()?;
            let beyond = |share: f64| [here.hub + share * step[0], here.shroud + share * step[1]];
            if let Some(next) = self.beside(beyond(1.0), &gaps, known) {
                stations.push(next.0);
                // A ring may be bent: the next step goes on as this one did.
                step = onwards(here, next.0, known);
                (here, gaps) = next;
                continue;
            }
            let (mut good, mut bad, mut last) = (0.0, 1.0, None);
            while bad - good > 1e-7 {
                let middle = 0.5 * (good + bad);
                match self.beside(beyond(middle), &gaps, known) {
                    Some(next) => (good, last) = (middle, Some(next.0)),
                    None => bad = middle,
                }
            }
            // The end itself, rather than a station just before it.
            if good <= LEAST_STEP && stations.len() > 1 && last.is_some() {
                stations.pop();
            }
            stations.extend(last);
            break;
        }
        Ok(stations)
    }

    /// The end walls on a line beyond the last station, if both go on there.
    fn beside(&self, line: [DVec2; 2], near: &Gaps, known: &Lines) -> Option<(Station, Gaps)> {
        let next = self.measured(line, near, known, true)?;
        let most = GOES_ON * next.0.height();
        let off = next.0.hub.distance(line[0]).max(next.0.shroud.distance(line[1]));
        (off < most).then_some(next)
    }

    /// The end walls on a line, and its gaps, which continue `near`. There are no tips beside the blades.
    fn measured(&self, line: [DVec2; 2], near: &Gaps, known: &Lines, is_beside: bool) -> Option<(Station, Gaps)> {
        let guess = station(line);
        let gap = |share: f64, near: &Gap| {
            let at = guess.place(share);
            self.gap_between_any(at.x, at.y, near).unwrap_or(*near)
        };
        let at = guess.place(0.5);
        let bladed = self.bladed_gap(at.x, at.y, &near.middle);
        let gaps = Gaps {
            hub: gap(BESIDE, &near.hub),
            middle: gap(0.5, &near.middle),
            shroud: gap(1.0 - BESIDE, &near.shroud),
        };
        let hub = self.end_wall(&guess, &gaps.hub, Surface::Hub)?;
        let shroud = match (known.shrouded, bladed.filter(|_| !is_beside)) {
            (true, _) => self.end_wall(&guess, &gaps.shroud, Surface::Shroud)?,
            (false, Some(gap)) if !self.is_drawn(Surface::Shroud) => {
                let tip = self.tip(&guess, gap)?;
                // Where the line leaves the blades by an edge it does not meet their tips.
                (tip.distance(guess.shroud) < (MOST_OFF * known.step).max(MOST_OFF_SHARE * guess.height()))
                    .then_some(tip)?
            }
            (false, _) => guess.shroud,
        };
        Some((station([hub, shroud]), gaps))
    }

    /// The hub or the shroud on the line of `guess`, met by rays that begin beside it, or drawn.
    fn end_wall(&self, guess: &Station, gap: &Gap, surface: Surface) -> Option<DVec2> {
        if self.is_drawn(surface) {
            return Some(if surface == Surface::Hub { guess.hub } else { guess.shroud });
        }
        let share = if surface == Surface::Hub { BESIDE } else { 1.0 - BESIDE };
        let height = guess.height();
        let [from, toward] = self.start_of(guess, share, surface);
        let met_over = |share: f64| {
            let half = 0.5 * share * gap.width();
            let theta = |i: usize| gap.middle() + half * (2.0 * i as f64 / (RAYS - 1) as f64 - 1.0);
            let met = (0..RAYS).filter_map(|i| self.met(theta(i), from, toward, 2.0 * BESIDE * height));
            let mut met: Vec<(f64, u32)> = met.collect();
            met.sort_by(|a, b| a.0.total_cmp(&b.0));
            (3 * met.len() >= RAYS).then_some(met)
        };
        // The same wall is met as far off as its facets dip; what differs more is a fillet or a blade.
        let typical = |met: &[(f64, u32)]| {
            let (distance, triangle) = met[met.len() / 2];
            (distance, DIP * height + self.slices.radial_sag(triangle, (from + distance * toward).y))
        };
        let is_even = |met: &Vec<(f64, u32)>| {
            let (typical, dip) = typical(met);
            3 * met.iter().filter(|m| (m.0 - typical).abs() <= dip).count() >= 2 * met.len()
        };
        // Where a hole takes the middle the wall is met beside it, and where fillets take the sides, between them.
        let met = OVER.into_iter().find_map(met_over)?;
        let between = || BETWEEN_FILLETS.into_iter().filter_map(met_over).find(is_even);
        let met = if is_even(&met) { met } else { between().unwrap_or(met) };
        let (typical, dip) = typical(&met);
        let nearest = met.iter().map(|m| m.0).find(|d| *d >= typical - dip)?;
        Some(from + nearest * toward)
    }

    /// The end of the blades on the line of `guess`, from the channel's middle outwards; none where they do not end.
    fn tip(&self, guess: &Station, mut gap: Gap) -> Option<DVec2> {
        let step = 1.0 / TIP_STEPS as f64;
        let (mut good, mut bad) = (0.5, None);
        while good < MOST_TIP && bad.is_none() {
            let at = guess.place(good + step);
            match self.bladed_gap(at.x, at.y, &gap) {
                Some(next) => (good, gap) = (good + step, next),
                None => bad = Some(good + step),
            }
        }
        let mut bad = bad?;
        while bad - good > 1e-6 * step {
            let middle = 0.5 * (good + bad);
            let at = guess.place(middle);
            match self.bladed_gap(at.x, at.y, &gap) {
                Some(next) => (good, gap) = (middle, next),
                None => bad = middle,
            }
        }
        Some(guess.place(good))
    }

    /// Where on a station rays to an end wall begin, and their direction (x, r).
    pub(super) fn start_of(&self, station: &Station, share: f64, surface: Surface) -> [DVec2; 2] {
        let up = (station.shroud - station.hub).normalize_or(DVec2::Y);
        [station.place(share), if surface == Surface::Hub { -up } else { up }]
    }

    /// Where the ray from `from` (x, r) along `toward` in the half plane at `theta` meets the solid from outside: the
    /// distance (mm) and the triangle. A face that it only grazes is no end wall.
    pub(super) fn met(&self, theta: f64, from: DVec2, toward: DVec2, reach: f64) -> Option<(f64, u32)> {
        let (distance, triangle) = self.slices.first_in_half_plane(theta, from, toward, reach)?;
        (self.slices.meridional_normal(triangle, theta).dot(toward) < -LEAST_FACING).then_some((distance, triangle))
    }

    /// The gap at `to` that `gap` at `from` goes over into along the straight line between them (x, r).
    ///
    /// # Errors
    /// [`BliskError::LostWall`] where blades do not bound it on both sides.
    pub(super) fn followed(&self, gap: &Gap, from: DVec2, to: DVec2) -> Result<Gap, BliskError> {
        (1..=STEPS).try_fold(*gap, |near, i| {
            let at = from + (to - from) * i as f64 / STEPS as f64;
            self.bladed_gap(at.x, at.y, &near).ok_or(BliskError::LostWall { x: at.x, r: at.y })
        })
    }
}

/// How hub and shroud go on beyond two stations. Beside the tips, which end somewhere about a blade's edge, the passage
/// keeps its height.
fn onwards(before: Station, last: Station, known: &Lines) -> [DVec2; 2] {
    let hub = last.hub - before.hub;
    [hub, if known.shrouded { last.shroud - before.shroud } else { hub }]
}

fn station([hub, shroud]: [DVec2; 2]) -> Station {
    Station { along: 0.0, hub, shroud }
}
