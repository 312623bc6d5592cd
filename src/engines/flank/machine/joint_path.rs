//! Choice among the machine positions that reach a direction along a path: both solutions of the rotary axes and every
//! whole turn of them within the limits, chosen together for the least travel.

use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::ops::Range;

use super::kinematics::{Joints, Kinematics, ToolPose};
use super::linearise::LinearisationParams;
use super::milling_machine::MachineError;
use super::singular::pole_places;
use super::tool_path::{Place, ToolPath, ToolPathError};
use task::{Cancel, Cancelled};

/// Cost of being outside of the limits by 1 mm or 1 rad beside the travel (rad): greater than any travel.
const OUTSIDE_COST: f64 = 1e6;
/// Cost that decides between positions of equal travel: the smaller values at the start.
const TIE_COST: f64 = 1e-6;
/// Cost of travel while the tool moves along the path, beside turning in place.
const MOVING_COST: f64 = 1.001;

/// Reason why a machine cannot follow a path.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum MillingError {
    /// The path.
    #[error(transparent)]
    Path(#[from] ToolPathError),
    /// The machine's data.
    #[error(transparent)]
    Machine(#[from] MachineError),
    /// A direction that it cannot take.
    #[error("{at}: {source}")]
    Unreachable {
        /// Place on the path.
        at: Place,
        /// Error of the machine.
        source: Box<MachineError>,
    },
    /// An axis outside of its limits, whichever way is taken.
    #[error(
        "{at}: axis {axis} would be at {value:.3} {unit}, {by:.3} {unit} outside of its limits {low:.3} to {high:.3}; \
         clamp the workpiece elsewhere or turned, or take another machine or tool length"
    )]
    OutsideLimits {
        /// Letter.
        axis: char,
        /// Where it is worst.
        at: Place,
        /// Value there: for X, Y, Z that of the spindle nose in machine coordinates.
        value: f64,
        /// How far outside.
        by: f64,
        /// mm or degrees.
        unit: &'static str,
        /// The least value.
        low: f64,
        /// The greatest.
        high: f64,
    },
    /// A tolerance that cannot be kept.
    #[error(
        "{at}: chordal deviation {deviation_mm:.5} mm, and more points do not reduce it; raise the linearisation \
         tolerance or smooth the path there"
    )]
    ChordalDeviation {
        /// Place on the path.
        at: Place,
        /// Chordal deviation (mm).
        deviation_mm: f64,
    },
    /// A path of too many points.
    #[error("more than {most} points are needed to keep the linearisation tolerance; raise it")]
    TooManyPoints {
        /// The most that are made.
        most: usize,
    },
    /// Cancelled.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    /// A value out of range.
    #[error("{name} is {value}; it must be {range}")]
    Setting {
        /// Name.
        name: &'static str,
        /// Value.
        value: f64,
        /// Range of valid values.
        range: &'static str,
    },
}

/// A point of the path with the position that was chosen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Chosen {
    pub s: f64,
    pub pose: ToolPose,
    pub rotary: [f64; 2],
    /// Number of the solution; none at the pole, where both are one.
    pub branch: Option<usize>,
}

struct Node {
    s: f64,
    pose: ToolPose,
    states: Vec<State>,
}

#[derive(Debug, Clone, Copy)]
struct State {
    rotary: [f64; 2],
    branch: Option<usize>,
    outside: f64,
}

/// The positions at every point of the path, and at the places between where it passes the pole. At the pole two may
/// follow each other at the same place: the pole's axis turns there.
pub(super) fn chosen(
    k: &Kinematics,
    path: &ToolPath,
    params: &LinearisationParams,
    cancel: &Cancel,
) -> Result<Vec<Chosen>, MillingError> {
    let mut nodes = Vec::new();
    cancel.check()?;
    let places = pole_places(k, path, params, cancel)?;
    cancel.check()?;
    let is_pole = |s: f64| Ok::<bool, MillingError>(k.off_pole(path.at(s)?.axis) <= params.pole_rad());
    let poles = places.iter().map(|&s| is_pole(s)).collect::<Result<Vec<bool>, _>>()?;
    let mut i = 0;
    while i < places.len() {
        cancel.check()?;
        let end = (i..places.len()).find(|&j| !poles[j]).unwrap_or(places.len());
        if end > i {
            nodes.extend(stay(k, path, &places, i..end, params)?);
            i = end;
        } else {
            let pose = path.at(places[i])?;
            nodes.push(Node { s: places[i], pose, states: states(k, path, places[i], &pose)? });
            i += 1;
        }
    }
    let mut line = least_travel(&nodes, cancel)?;
    line.dedup_by(|next, kept| next.s == kept.s && next.rotary == kept.rotary);
    Ok(line)
}

/// The points of a stay at the pole. Its axis comes as what is before wants it; at the last point it may turn to what
/// comes after.
fn stay(
    k: &Kinematics,
    path: &ToolPath,
    places: &[f64],
    at: Range<usize>,
    params: &LinearisationParams,
) -> Result<Vec<Node>, MillingError> {
    let Range { start, end } = at;
    let before = start.checked_sub(1).map(|i| beside(k, path, places[start], places[i], params)).transpose()?;
    let after = places.get(end).map(|&next| beside(k, path, places[end - 1], next, params)).transpose()?;
    // A path that never leaves the pole may have it anywhere.
    let anywhere = || {
        let [low, high] = k.machine().rotary[k.pole_axis()].limits();
        [0.0, FRAC_PI_2, -FRAC_PI_2, PI].map(|v| v.clamp(low, high)).to_vec()
    };
    let values = before.clone().or(after.clone()).unwrap_or_else(anywhere);
    let node = |s: f64, values: &[f64]| {
        let pose = path.at(s)?;
        Ok(Node { s, pose, states: pole_states(k, &pose, values) })
    };
    let mut nodes = places[start..end].iter().map(|&s| node(s, &values)).collect::<Result<Vec<_>, MillingError>>()?;
    if let (Some(_), Some(after)) = (before, after) {
        nodes.push(node(places[end - 1], &after)?);
    }
    Ok(nodes)
}

fn states(k: &Kinematics, path: &ToolPath, s: f64, pose: &ToolPose) -> Result<Vec<State>, MillingError> {
    let solutions =
        k.inverse(pose.axis).map_err(|e| MillingError::Unreachable { at: path.place(s), source: Box::new(e) })?;
    let turned = solutions.into_iter().enumerate().flat_map(|(b, rotary)| turns(k, pose, rotary, Some(b)));
    Ok(turned.collect())
}

fn pole_states(k: &Kinematics, pose: &ToolPose, values: &[f64]) -> Vec<State> {
    let at = |&value: &f64| turns(k, pose, k.nearest_with_pole_at(pose.axis, value), None);
    values.iter().flat_map(at).collect()
}

/// The values of the pole's axis just beside the pole at `s`, on the way to the place `other`.
fn beside(
    k: &Kinematics,
    path: &ToolPath,
    s: f64,
    other: f64,
    params: &LinearisationParams,
) -> Result<Vec<f64>, MillingError> {
    let mut part = 1e-6;
    loop {
        let at = s + (other - s) * f64::min(part, 1.0);
        let axis = path.at(at)?.axis;
        if part >= 1.0 || k.off_pole(axis) >= 10.0 * params.pole_rad() {
            let unreachable = |e| MillingError::Unreachable { at: path.place(at), source: Box::new(e) };
            return Ok(k.inverse(axis).map_err(unreachable)?.map(|rotary| rotary[k.pole_axis()]).to_vec());
        }
        part *= 2.0;
    }
}

/// Every position of the same turn apart from whole turns, within the limits and up to one turn beyond.
fn turns(k: &Kinematics, pose: &ToolPose, rotary: [f64; 2], branch: Option<usize>) -> Vec<State> {
    let slides_outside = slides_outside(k, &k.with_tip(pose.tip, rotary));
    let values = [0, 1].map(|i| {
        let [low, high] = k.machine().rotary[i].limits();
        let (first, last) = (((low - rotary[i]) / TAU).floor() as i32, ((high - rotary[i]) / TAU).ceil() as i32);
        (first..=last).map(|n| rotary[i] + TAU * f64::from(n)).collect::<Vec<f64>>()
    });
    let pairs = values[0].iter().flat_map(|&v| values[1].iter().map(move |&w| [v, w]));
    pairs
        .map(|rotary| {
            let outside = (0..2).map(|i| beyond(rotary[i], k.machine().rotary[i].limits())).sum::<f64>();
            State { rotary, branch, outside: outside + slides_outside }
        })
        .collect()
}

fn beyond(value: f64, [low, high]: [f64; 2]) -> f64 {
    // Limits in degrees and values in radians do not meet to the last digit.
    let by = (low - value).max(value - high);
    if by > 1e-9 { by } else { 0.0 }
}

fn slides_outside(k: &Kinematics, joints: &Joints) -> f64 {
    let (slides, linear) = (k.slides(joints), &k.machine().linear);
    let pairs = [(slides.x, linear.x_mm), (slides.y, linear.y_mm), (slides.z, linear.z_mm)];
    pairs.into_iter().map(|(value, limits)| beyond(value, limits)).sum()
}

/// Travel from one position to the next (rad); none where the next is of the other solution or half a turn away.
fn travel(from: &State, to: &State) -> Option<f64> {
    let by = [0, 1].map(|i| (to.rotary[i] - from.rotary[i]).abs());
    let is_joined = match (from.branch, to.branch) {
        (Some(a), Some(b)) => a == b && by.iter().all(|&v| v <= PI + 1e-9),
        _ => true,
    };
    is_joined.then_some(by[0] + by[1])
}

/// Dynamic programming over the points: for every position the cheapest way to it.
fn least_travel(nodes: &[Node], cancel: &Cancel) -> Result<Vec<Chosen>, Cancelled> {
    let Some(first) = nodes.first() else { return Ok(Vec::new()) };
    let own = |state: &State| OUTSIDE_COST * state.outside;
    let start = |state: &State| own(state) + TIE_COST * (state.rotary[0].abs() + state.rotary[1].abs());
    let mut cost: Vec<f64> = first.states.iter().map(start).collect();
    let mut came_from: Vec<Vec<usize>> = vec![Vec::new()];
    for pair in nodes.windows(2) {
        cancel.check()?;
        // Of equal travel, the one that turns at the pole and not on the way to it.
        let dearness = if pair[0].s == pair[1].s { 1.0 } else { MOVING_COST };
        let best = |to: &State| {
            let ways = pair[0].states.iter().enumerate();
            let ways = ways.filter_map(|(i, from)| travel(from, to).map(|way| (i, cost[i] + way * dearness)));
            ways.min_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or((0, f64::INFINITY))
        };
        let found: Vec<(usize, f64)> = pair[1].states.iter().map(best).collect();
        cost = found.iter().zip(&pair[1].states).map(|((_, c), state)| c + own(state)).collect();
        came_from.push(found.into_iter().map(|(i, _)| i).collect());
    }
    let mut at = cost.iter().enumerate().min_by(|a, b| a.1.total_cmp(b.1)).map_or(0, |(i, _)| i);
    let mut line = Vec::with_capacity(nodes.len());
    for (node, from) in nodes.iter().zip(&came_from).rev() {
        let State { rotary, branch, .. } = node.states[at];
        line.push(Chosen { s: node.s, pose: node.pose, rotary, branch });
        at = from.get(at).copied().unwrap_or(0);
    }
    line.reverse();
    Ok(line)
}

/// The first axis to blame where a position is outside of the limits: the one that is furthest outside.
pub(super) fn furthest_outside<'j>(
    k: &Kinematics,
    path: &ToolPath,
    line: impl Iterator<Item = (f64, &'j Joints)>,
) -> Result<(), MillingError> {
    let mut worst: Option<(f64, MillingError)> = None;
    for (s, joints) in line {
        let (slides, linear) = (k.slides(joints), &k.machine().linear);
        let straight = [('X', slides.x, linear.x_mm), ('Y', slides.y, linear.y_mm), ('Z', slides.z, linear.z_mm)];
        let rotary = [0, 1].map(|i| (k.letter(i), joints.rotary[i], k.machine().rotary[i].limits()));
        for (n, (axis, value, limits)) in straight.into_iter().chain(rotary).enumerate() {
            let by = beyond(value, limits);
            if by > 0.0 && worst.as_ref().is_none_or(|(most, _)| by > *most) {
                let (unit, scale) = if n < 3 { ("mm", 1.0) } else { ("degrees", 1f64.to_degrees()) };
                let [value, by, low, high] = [value, by, limits[0], limits[1]].map(|v| v * scale);
                let at = path.place(s);
                worst = Some((by / scale, MillingError::OutsideLimits { axis, at, value, by, unit, low, high }));
            }
        }
    }
    worst.map_or(Ok(()), |(_, error)| Err(error))
}
