//! Positions of a machine along a path, so close together that straight moves between them keep a tolerance.
//!
//! Between two programmed points every axis goes linearly, so the tool leaves the path. What counts is the tip and the
//! point of the tool's axis at the flutes' top: the way off is linear in the height, so no point between them goes
//! further off. It is taken at equal parts of the move and of the path's parameter, which is never less than the
//! distance to the path. Bound of a move: the greatest of 17 measured places, plus what can lie between two of them,
//! an eighth of the squared step times the second derivative of the way off. That of the machine's motion is bounded in
//! closed form ([`Kinematics::bend`]); that of the path is taken as twice its greatest second difference.

use std::f64::consts::TAU;

use glam::DVec3;
use serde::{Deserialize, Serialize};

use super::joint_path::{Chosen, MillingError, chosen, furthest_outside};
use super::kinematics::{Joints, Kinematics, ToolPose};
use super::singular::{SingularPassage, passages};
use super::tool_path::ToolPath;
use task::Cancel;

/// Decimals of X, Y, Z (mm) and of the rotary axes (degrees) in programs: positions are rounded to them before the
/// moves are measured.
pub const MM_DECIMALS: usize = 5;
/// Decimals of angles (deg) in programs.
pub const DEG_DECIMALS: usize = 6;
/// Pieces in which a move is measured.
const PIECES: usize = 16;
/// Part of the tolerance that leaving the exact direction near the pole may take.
const POLE_SHARE: f64 = 0.25;
/// Directions are not known better than this (rad): coordinates of guides have six decimals or so, and rulings a few
/// mm.
const ROUNDING_RAD: f64 = 1e-6;
/// Part of the tolerance that what is rounding may take.
const ROUNDING_SHARE: f64 = 0.5;
/// How often a move is halved.
const DEEPEST: usize = 32;
/// The most points.
const MOST_POINTS: usize = 1_000_000;

/// Interpolation of the control: the quantities that it moves linearly.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Interpolation {
    /// All five axes.
    #[default]
    Joints,
    /// The tip on the workpiece and the rotary axes: a control that follows the tool's tip (G43.4).
    Tip,
}

/// Parameters of linearisation.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct LinearisationParams {
    /// The furthest that tip and flutes' top may leave the path between programmed points (mm).
    pub linearisation_mm: f64,
    /// Height of the flutes' top above the tip (mm).
    pub reach_mm: f64,
    /// Passing the pole within this angle is reported (degrees).
    pub singular_cone_deg: f64,
    /// Interpolation of the control.
    pub interpolation: Interpolation,
}

impl Default for LinearisationParams {
    fn default() -> Self {
        let interpolation = Interpolation::Joints;
        Self { linearisation_mm: 0.002, reach_mm: 20.0, singular_cone_deg: 5.0, interpolation }
    }
}

impl LinearisationParams {
    /// The greatest height of the flutes' top (mm).
    pub const LONGEST_REACH_MM: f64 = 1000.0;

    /// Checks the ranges.
    ///
    /// # Errors
    /// [`MillingError::Setting`] naming the setting.
    pub fn validate(&self) -> Result<(), MillingError> {
        let settings = [
            ("linearisation_mm", self.linearisation_mm, 1e-4, 1.0, "0.0001 to 1 mm"),
            ("reach_mm", self.reach_mm, 0.0, Self::LONGEST_REACH_MM, "0 to 1000 mm"),
            ("singular_cone_deg", self.singular_cone_deg, 0.0, 20.0, "0 to 20 degrees"),
        ];
        let wrong = settings.into_iter().find(|(_, value, low, high, _)| !(*low..=*high).contains(value));
        wrong.map_or(Ok(()), |(name, value, _, _, range)| Err(MillingError::Setting { name, value, range }))
    }

    /// So near to the pole the tool is taken to be at it (rad), where its axis stays as it is: a direction that is off
    /// the pole by rounding says nothing of where that should stand.
    pub(super) fn pole_rad(&self) -> f64 {
        let tolerance_rad = self.linearisation_mm / self.reach_mm.max(1.0);
        (POLE_SHARE * tolerance_rad).max(ROUNDING_RAD.min(ROUNDING_SHARE * tolerance_rad))
    }

    pub(super) fn cone_rad(&self) -> f64 {
        self.singular_cone_deg.to_radians().max(2.0 * self.pole_rad())
    }
}

fn rounded(joints: &Joints) -> Joints {
    let rotary = joints.rotary.map(|v| to_decimals(v.to_degrees(), DEG_DECIMALS).to_radians());
    Joints { linear: rounded_tip(joints.linear), rotary }
}

fn rounded_tip(tip: DVec3) -> DVec3 {
    tip.map(|v| to_decimals(v, MM_DECIMALS))
}

fn to_decimals(value: f64, decimals: usize) -> f64 {
    let step = 10f64.powi(decimals as i32);
    (value * step).round() / step + 0.0
}

/// A programmed point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MachinePoint {
    /// Parameter on the [`ToolPath`].
    pub s: f64,
    /// The five axes, rounded to the decimals of programs.
    pub joints: Joints,
    /// The tip in the workpiece's frame, rounded likewise in the machine's directions: for a control that follows the
    /// tip.
    pub tip: DVec3,
    /// Unit direction to the spindle in the workpiece's frame, as the rotary axes give it.
    pub axis: DVec3,
    branch: Option<usize>,
}

/// A path in the positions of a machine.
#[derive(Debug, Clone, PartialEq)]
pub struct MachinePath {
    /// The programmed points.
    pub points: Vec<MachinePoint>,
    /// Places where the path passes near the machine's pole.
    pub singular: Vec<SingularPassage>,
    /// Bound of how far tip and flutes' top leave the path anywhere (mm).
    pub deviation_mm: f64,
    /// Greatest that was measured (mm).
    pub measured_mm: f64,
}

/// The path of `machine` along `path`, within every limit and within the tolerance.
///
/// # Errors
/// [`MillingError`], also when it was told to stop.
pub fn linearise(
    k: &Kinematics,
    path: &ToolPath,
    params: &LinearisationParams,
    cancel: &Cancel,
) -> Result<MachinePath, MillingError> {
    params.validate()?;
    let line = chosen(k, path, params, cancel)?;
    let exact: Vec<(f64, Joints)> = line.iter().map(|c| (c.s, k.with_tip(c.pose.tip, c.rotary))).collect();
    furthest_outside(k, path, exact.iter().map(|(s, joints)| (*s, joints)))?;
    let follower = Follower { k, path, params, cancel };
    let mut points = Vec::new();
    let (mut deviation_mm, mut measured_mm) = (0.0f64, 0.0f64);
    for to in line.iter().map(|c| follower.point(c)) {
        if points.is_empty() {
            points.push(to);
            continue;
        }
        let (bound, measured) = follower.follow(&mut points, to)?;
        (deviation_mm, measured_mm) = (deviation_mm.max(bound), measured_mm.max(measured));
    }
    furthest_outside(k, path, points.iter().map(|p| (p.s, &p.joints)))?;
    let singular = passages(k, path, &points, params.cone_rad())?;
    Ok(MachinePath { points, singular, deviation_mm, measured_mm })
}

/// The tool on the workpiece, part `t` of the way from one point to the next.
pub fn on_the_way(k: &Kinematics, mode: Interpolation, from: &MachinePoint, to: &MachinePoint, t: f64) -> ToolPose {
    let joints = from.joints.lerp(&to.joints, t);
    match mode {
        Interpolation::Joints => k.forward(&joints),
        Interpolation::Tip => ToolPose { tip: from.tip.lerp(to.tip, t), axis: k.direction(&joints.rotary) },
    }
}

struct Follower<'a, 'p> {
    k: &'a Kinematics,
    path: &'a ToolPath<'p>,
    params: &'a LinearisationParams,
    cancel: &'a Cancel,
}

impl Follower<'_, '_> {
    fn point(&self, c: &Chosen) -> MachinePoint {
        let joints = rounded(&self.k.with_tip(c.pose.tip, c.rotary));
        MachinePoint {
            s: c.s,
            joints,
            tip: self.k.in_workpiece(rounded_tip(self.k.in_machine(c.pose.tip))),
            axis: self.k.direction(&joints.rotary),
            branch: c.branch,
        }
    }

    /// Adds the points up to `to`; the bound and the greatest measured deviation on the way.
    fn follow(&self, points: &mut Vec<MachinePoint>, to: MachinePoint) -> Result<(f64, f64), MillingError> {
        let (mut bound, mut measured) = (0.0f64, 0.0f64);
        let mut open = vec![to];
        while let Some(to) = open.pop() {
            self.cancel.check()?;
            let Some(from) = points.last().copied() else { break };
            let deviation = self.chordal_deviation(&from, &to)?;
            if deviation.0 <= self.params.linearisation_mm {
                (bound, measured) = (bound.max(deviation.0), measured.max(deviation.1));
                points.push(to);
                if points.len() > MOST_POINTS {
                    return Err(MillingError::TooManyPoints { most: MOST_POINTS });
                }
                continue;
            }
            if open.len() >= DEEPEST {
                return Err(MillingError::ChordalDeviation { at: self.path.place(from.s), deviation_mm: deviation.1 });
            }
            let middle = self.between(&from, &to)?;
            open.extend([to, middle]);
        }
        Ok((bound, measured))
    }

    /// The point half way: the exact position on the same solution, nearest to the middle of the move. Near the pole
    /// the pole's axis goes on evenly as long as the tool's direction stays within a share of the tolerance.
    fn between(&self, from: &MachinePoint, to: &MachinePoint) -> Result<MachinePoint, MillingError> {
        let (s, guess) = (0.5 * (from.s + to.s), from.joints.lerp(&to.joints, 0.5).rotary);
        let pose = self.path.at(s)?;
        let near = |rotary: [f64; 2]| [0, 1].map(|i| rotary[i] + TAU * ((guess[i] - rotary[i]) / TAU).round());
        if self.k.off_pole(pose.axis) < self.params.cone_rad() {
            let even = near(self.k.nearest_with_pole_at(pose.axis, guess[self.k.pole_axis()]));
            if self.k.direction(&even).distance(pose.axis) <= self.params.pole_rad() {
                return Ok(self.point(&Chosen { s, pose, rotary: even, branch: None }));
            }
        }
        let unreachable = |e| MillingError::Unreachable { at: self.path.place(s), source: Box::new(e) };
        let solutions = self.k.inverse(pose.axis).map_err(unreachable)?.map(near);
        let off = |b: usize| (0..2).map(|i| (solutions[b][i] - guess[i]).abs()).sum::<f64>();
        let nearest = if off(1) < off(0) { 1 } else { 0 };
        let branch = from.branch.or(to.branch).unwrap_or(nearest);
        Ok(self.point(&Chosen { s, pose, rotary: solutions[branch], branch: Some(branch) }))
    }

    /// Bound and greatest measured way off the path between two points (mm).
    fn chordal_deviation(&self, from: &MachinePoint, to: &MachinePoint) -> Result<(f64, f64), MillingError> {
        let (mode, heights) = (self.params.interpolation, [0.0, self.params.reach_mm]);
        let (mut most, mut bends) = (0.0f64, [0.0f64; 2]);
        let mut before: Vec<[DVec3; 2]> = Vec::with_capacity(PIECES + 1);
        for n in 0..=PIECES {
            let t = n as f64 / PIECES as f64;
            let wanted = self.path.at(from.s + (to.s - from.s) * t)?;
            let moved = on_the_way(self.k, mode, from, to, t);
            let wanted = heights.map(|h| wanted.at_height(h));
            for i in 0..2 {
                most = most.max(wanted[i].distance(moved.at_height(heights[i])));
                if let [.., b, a] = &before[..] {
                    bends[i] = bends[i].max((b[i] - a[i] * 2.0 + wanted[i]).length());
                }
            }
            before.push(wanted);
        }
        let square = (1.0 / PIECES as f64).powi(2);
        let machine = |h: f64| match mode {
            Interpolation::Joints => self.k.bend(&from.joints, &to.joints, h),
            Interpolation::Tip => {
                let turn = (0..2).map(|i| (to.joints.rotary[i] - from.joints.rotary[i]).abs()).sum::<f64>();
                turn * turn * h
            }
        };
        let between = |i: usize| (square * machine(heights[i]) + 2.0 * bends[i]) / 8.0;
        Ok((most + between(0).max(between(1)), most))
    }
}
