//! How long each move takes, so that the flank is milled at the feed that is asked for, no axis is too fast and no move
//! is shorter than the control takes.

use super::kinematics::Kinematics;
use super::linearise::{Interpolation, MachinePath, MachinePoint, on_the_way};
use super::tool_path::{Section, ToolPath};
use glam::DVec3;

/// Pieces that a move is measured in.
const PIECES: usize = 8;
/// Part of the way between two points of the path over which its direction is taken.
const ASIDE: f64 = 1e-4;

/// Contact of the flutes: the fastest point in a hollow, the slowest on a bulge.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Contact {
    /// Radius of the cutter at the tip and at the flutes' top (mm).
    pub radii_mm: [f64; 2],
    /// Whether the surface lies to the right as the cutter travels, seen from the spindle.
    pub is_right: bool,
}

/// Feeds and what they are measured on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Feeds {
    /// Along the cut and on the moves that begin or end on it (mm/min).
    pub cut_mm_min: f64,
    /// Along the other moves of approach and retraction (mm/min).
    pub lead_mm_min: f64,
    /// Height of the flutes' top above the tip (mm).
    pub reach_mm: f64,
    /// The shortest time that a move is given (min); 0 where the control takes any.
    pub least_minutes: f64,
    /// Interpolation of the control between points.
    pub interpolation: Interpolation,
    /// Contact of the flutes; none if the feed is that of the tool's axis.
    pub contact: Option<Contact>,
}

/// The pace of one move.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pace {
    /// The part of the path that it belongs to.
    pub section: Section,
    /// Time (min).
    pub minutes: f64,
    /// The longest way along the workpiece (mm) of tip, flutes' top and, in the cut, where the flutes touch at these
    /// two heights: what is to have the feed.
    pub way_mm: f64,
    /// Share of the programmed feed; 1 where no axis is too fast.
    pub share: f64,
    /// The axis that would be too fast with more.
    pub axis: char,
    /// Share of the speed, as axes and feed allow it, that the shortest time of a move leaves; 1 where the move takes
    /// longer anyway.
    pub short_share: f64,
}

/// Moves that are slower than asked for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Slowed {
    /// Number of slowed moves, for any reason.
    pub moves: usize,
    /// The least share of the feed asked for that is left.
    pub share: f64,
    /// Moves slowed for an axis: their number, the least share that the axes allow, and the axis.
    pub by_axis: Option<(usize, f64, char)>,
    /// Moves slowed for the control's shortest time: their number, and the least share of their speed that remains.
    pub short: Option<(usize, f64)>,
}

impl Slowed {
    /// Slowed moves among `paces`; none if every move has the programmed feed.
    pub fn of(paces: &[Pace]) -> Option<Self> {
        let slow = |share: fn(&Pace) -> f64| {
            let slow = paces.iter().filter(move |p| share(p) < 1.0);
            let least = slow.clone().min_by(|a, b| share(a).total_cmp(&share(b)))?;
            Some((slow.count(), share(least), least.axis))
        };
        let (moves, share, _) = slow(Pace::left)?;
        let short = slow(|p| p.short_share).map(|(moves, share, _)| (moves, share));
        Some(Self { moves, share, by_axis: slow(|p| p.share), short })
    }
}

impl Pace {
    /// Share of the programmed feed, whatever the limit.
    fn left(&self) -> f64 {
        self.share * self.short_share
    }
}

/// The pace of every move of `machine_path`: one less than its points.
pub fn paces(k: &Kinematics, path: &ToolPath, machine_path: &MachinePath, feeds: &Feeds) -> Vec<Pace> {
    machine_path.points.windows(2).map(|w| pace(k, path, &w[0], &w[1], feeds)).collect()
}

fn pace(k: &Kinematics, path: &ToolPath, from: &MachinePoint, to: &MachinePoint, feeds: &Feeds) -> Pace {
    let section = path.section(0.5 * (from.s + to.s));
    let feed = if path.is_on_flank(0.5 * (from.s + to.s)) { feeds.cut_mm_min } else { feeds.lead_mm_min };
    let at = |n: usize| on_the_way(k, feeds.interpolation, from, to, n as f64 / PIECES as f64);
    let way = |h: f64| (0..PIECES).map(|n| at(n).at_height(h).distance(at(n + 1).at_height(h))).sum::<f64>();
    let touching = match feeds.contact.filter(|_| section == Section::Cut) {
        Some(contact) => contact_way(path, [from.s, to.s], &contact, feeds.reach_mm),
        None => 0.0,
    };
    let way_mm = way(0.0).max(way(feeds.reach_mm)).max(touching);
    let (least, axis) = least_minutes(k, from, to);
    let asked = way_mm / feed;
    let free = asked.max(least);
    let share = |part: f64, whole: f64| if whole > part { part / whole } else { 1.0 };
    let short_share = share(free, feeds.least_minutes);
    let minutes = free.max(feeds.least_minutes);
    Pace { section, minutes, way_mm, share: share(asked, least), axis, short_share }
}

/// The longer way (mm) of where the flutes touch at the tip and at `reach_mm` above it: beside the axis, square to its
/// travel.
fn contact_way(path: &ToolPath, [from, to]: [f64; 2], contact: &Contact, reach_mm: f64) -> f64 {
    let side = if contact.is_right { 1.0 } else { -1.0 };
    let touched = |s: f64, height: f64, radius: f64| -> Option<DVec3> {
        let [before, pose, after] = [s - ASIDE, s, s + ASIDE].map(|s| path.at(path.within_cut(s)).ok());
        let travel = after?.at_height(height) - before?.at_height(height);
        let across = travel.cross(pose?.axis).try_normalize()?;
        Some(pose?.at_height(height) + side * radius * across)
    };
    let way = |height: f64, radius: f64| {
        let place = |n: usize| touched(from + (to - from) * n as f64 / PIECES as f64, height, radius);
        // Where the axis stands still nothing touches another place.
        (0..PIECES).filter_map(|n| Some(place(n)?.distance(place(n + 1)?))).sum::<f64>()
    };
    way(0.0, contact.radii_mm[0]).max(way(reach_mm, contact.radii_mm[1]))
}

/// The shortest time (min) in which every axis gets from one point to the other, and the axis that needs it.
pub fn least_minutes(k: &Kinematics, from: &MachinePoint, to: &MachinePoint) -> (f64, char) {
    let (by, speeds) = ((to.joints.linear - from.joints.linear).abs(), k.machine().linear.speed_mm_min);
    let straight = ['X', 'Y', 'Z'].into_iter().zip(by.to_array()).zip(speeds).map(|((axis, by), v)| (by / v, axis));
    let rotary = (0..2).map(|i| {
        let by = (to.joints.rotary[i] - from.joints.rotary[i]).abs().to_degrees();
        (by / k.machine().rotary[i].speed_deg_min, k.letter(i))
    });
    straight.chain(rotary).fold((0.0, 'X'), |worst, next| if next.0 > worst.0 { next } else { worst })
}
