//! The blades of a wheel with splitters: where each kind stands, and which of them are main blades.

use std::collections::HashMap;
use std::f64::consts::TAU;

use glam::{DVec2, DVec3};

use super::super::channel::Channel;
use super::super::frame::MOST_KINDS;
use super::super::frame::lattice::{Lattice, around};
use super::super::frame::slices::{Gap, Slices};
use geometry::frame::angle_near;
use task::{Cancel, Cancelled};

/// Main blades cover at least this share of what the largest blade covers in the meridional plane.
const MAIN: f64 = 0.9;
/// A place is looked up so many points of the lattice around it: those of edges and fillets lie beside it.
const BESIDE: i32 = 6;

/// The blades of one group, of which each is of another kind, at every place of the meridional plane. They are followed
/// from the channel on, also where those beside it have ended.
pub(super) struct Group {
    kinds: usize,
    /// Angle from group to group (rad).
    turn: f64,
    lattice: Lattice,
    places: HashMap<[i32; 2], Standing>,
    is_main: [bool; MOST_KINDS],
}

/// The blades of a group on a circle about the axis.
#[derive(Clone, Copy)]
struct Standing {
    /// Angle of the middle of each, or where it would be (rad).
    thetas: [f64; MOST_KINDS],
    /// Which of them are there, in most of the groups.
    is_there: [bool; MOST_KINDS],
}

/// The blade that a place on a wheel's surface belongs to.
pub(super) struct OfGroup {
    /// Whether it is a main blade.
    pub is_main: bool,
    /// Unit normal of its camber surface towards greater theta: along x, along r and about the axis.
    pub camber: DVec3,
}

impl Group {
    /// The blades of the wheel in `slices`, which are in W of `channel`; none where they are all of one kind, where each is
    /// of its own, or where those beside the channel are not met at its middle.
    pub fn new(slices: &Slices, channel: &Channel, cancel: &Cancel) -> Result<Option<Self>, Cancelled> {
        let kinds = channel.kinds;
        if kinds > MOST_KINDS {
            return Ok(None);
        }
        let turn = TAU * kinds as f64 / channel.blades as f64;
        let (low, high) = (&channel.low, &channel.high);
        let [a, b] = [low, high].map(|wall| wall.cylindrical(wall.nu / 2, wall.nv / 2));
        let at = 0.5 * DVec2::new(a.x + b.x, a.r + b.r);
        let middle = 0.5 * (a.theta + angle_near(b.theta, a.theta));
        let gaps = slices.gaps(at.x, at.y);
        let metals = metals(&gaps);
        let beside = gaps.iter().position(|gap| gap.holds(middle));
        let Some((above, below)) = beside.filter(|_| kinds > 1).map(|i| (i, (i + gaps.len() - 1) % gaps.len())) else {
            return Ok(None);
        };
        let first = metals[below];
        let second = first + (metals[above] - first).rem_euclid(TAU);
        let rest = (turn - (second - first)) / (kinds - 1) as f64;
        let thetas = std::array::from_fn(|k| if k == 0 { first } else { second + rest * (k - 1) as f64 });
        let next = |at: DVec2, near: &Standing| near.on(slices, at, (kinds, turn));
        let begin = Standing { thetas, is_there: [false; MOST_KINDS] };
        let Some(begin) = next(at, &begin) else { return Ok(None) };
        let (lattice, places) = Lattice::filled(slices, (at, begin), next, cancel)?;
        let covered: [usize; MOST_KINDS] = std::array::from_fn(|k| places.values().filter(|s| s.is_there[k]).count());
        let most = covered.into_iter().fold(0, usize::max) as f64;
        Ok(Some(Self { kinds, turn, lattice, places, is_main: covered.map(|places| places as f64 >= MAIN * most) }))
    }

    /// The blade that the place (x, r) at `theta` (rad) belongs to; none far from all blades.
    pub fn blade(&self, at: DVec2, theta: f64) -> Option<OfGroup> {
        let [i, j] = self.lattice.nearest(at);
        let square = |reach: i32| (-reach..=reach).flat_map(move |a| (-reach..=reach).map(move |b| [i + a, j + b]));
        let far = |point: &[i32; 2]| self.lattice.place(point.map(f64::from)).distance_squared(at);
        let known = |reach| square(reach).filter(|point| self.places.contains_key(point));
        let nearest = |reach| known(reach).min_by(|a, b| far(a).total_cmp(&far(b)));
        let point = [0, 1, BESIDE].into_iter().find_map(nearest)?;
        let standing = &self.places[&point];
        let off = |k: &usize| within_turn(theta - standing.thetas[*k], self.turn).abs();
        let k = (0..self.kinds).filter(|k| standing.is_there[*k]).min_by(|a, b| off(a).total_cmp(&off(b)))?;
        // How its angle changes along r and along x, from the neighbours where it stands.
        let [below, ahead, above, behind] = around(point).map(|beside| self.places.get(&beside));
        let slope = |before: Option<&Standing>, after: Option<&Standing>| {
            let stands = |standing: &&Standing| standing.is_there[k];
            let (from, to) = (before.filter(stands), after.filter(stands));
            let steps = usize::from(from.is_some()) + usize::from(to.is_some());
            let change = to.unwrap_or(standing).thetas[k] - from.unwrap_or(standing).thetas[k];
            change / (steps.max(1) as f64 * self.lattice.step)
        };
        let (along_x, along_r) = (slope(behind, ahead), slope(below, above));
        let camber = DVec3::new(-at.y * along_x, -at.y * along_r, 1.0).normalize();
        Some(OfGroup { is_main: self.is_main[k], camber })
    }
}

impl Standing {
    /// The blades on the circle at (x, r) beside this one, of groups of so many kinds that are a turn apart (rad); none where
    /// no blade is there.
    fn on(&self, slices: &Slices, at: DVec2, (kinds, turn): (usize, f64)) -> Option<Self> {
        let (mut counts, mut sums) = ([0; MOST_KINDS], [0.0; MOST_KINDS]);
        for middle in metals(&slices.gaps(at.x, at.y)) {
            let off = |k: usize| within_turn(middle - self.thetas[k], turn);
            let nearest = (0..kinds).min_by(|a, b| off(*a).abs().total_cmp(&off(*b).abs()))?;
            counts[nearest] += 1;
            sums[nearest] += off(nearest);
        }
        let groups = (TAU / turn).round() as usize;
        let is_there = counts.map(|count| 2 * count >= groups);
        let moved = |k: usize| sums[k] / counts[k] as f64;
        let there: Vec<f64> = (0..kinds).filter(|k| is_there[*k]).map(moved).collect();
        if there.is_empty() {
            return None;
        }
        // Blades that have ended are taken to go on as the others do.
        let mean = there.iter().sum::<f64>() / there.len() as f64;
        let thetas = std::array::from_fn(|k| self.thetas[k] + if is_there[k] { moved(k) } else { mean });
        Some(Self { thetas, is_there })
    }
}

/// An angle, less whole turns of `turn` (rad).
fn within_turn(angle: f64, turn: f64) -> f64 {
    angle - turn * (angle / turn).round()
}

/// Angles of the middles of the metal above each of the gaps of a circle (rad).
fn metals(gaps: &[Gap]) -> Vec<f64> {
    let width = |i: usize| (gaps[(i + 1) % gaps.len()].low.theta - gaps[i].high.theta).rem_euclid(TAU);
    (0..gaps.len()).map(|i| gaps[i].high.theta + 0.5 * width(i)).collect()
}
