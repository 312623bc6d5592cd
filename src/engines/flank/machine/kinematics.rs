//! The kinematics of a milling machine in closed form.
//!
//! All vectors are in the machine's directions with every rotary axis at zero. The tool's direction in the workpiece is
//! d = R(a, alpha) R(b, beta) s, where a is the rotary axis next to the workpiece, b the one next to the tool, both
//! followed from the workpiece to the tool, and s the spindle. R(b, beta) s is where the cone about a through d meets
//! the cone about b through s: two solutions, one where the cones touch, none where they miss each other. Where d lies
//! along a, alpha is free: the machine's pole.

use glam::{DMat3, DVec3};

use super::milling_machine::{CarriedBy, LEAST_SINE, MachineError, MillingMachine};

/// How far beyond the reachable cone a direction may lie and still count as on it (rad).
const REACH_ROUNDING: f64 = 1e-9;

/// A tool's place in the workpiece's frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ToolPose {
    /// Middle of the cutter's bottom (mm).
    pub tip: DVec3,
    /// Unit vector from the tip to the spindle.
    pub axis: DVec3,
}

impl ToolPose {
    /// The point of the tool's axis at this height above the tip (mm).
    pub fn at_height(&self, height: f64) -> DVec3 {
        self.tip + self.axis * height
    }
}

/// Values of the five axes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Joints {
    /// X, Y, Z (mm) as programmed: where the tip would be from the workpiece's zero, in the machine's directions, with
    /// both rotary axes at zero.
    pub linear: DVec3,
    /// The rotary axes in the machine's order (rad).
    pub rotary: [f64; 2],
}

impl Joints {
    /// Part `t` of the way to `other`.
    pub fn lerp(&self, other: &Self, t: f64) -> Self {
        let part = |i: usize| self.rotary[i] + (other.rotary[i] - self.rotary[i]) * t;
        Self { linear: self.linear.lerp(other.linear, t), rotary: [part(0), part(1)] }
    }
}

/// The kind of a machine.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MachineKind {
    /// Both rotary axes carry the cutter.
    HeadHead,
    /// One rotary axis carries the cutter, one the workpiece.
    HeadTable,
    /// Both rotary axes carry the workpiece.
    TableTable,
}

/// A machine that was checked, ready for computing.
#[derive(Debug, Clone)]
pub struct Kinematics {
    machine: MillingMachine,
    directions: [DVec3; 2],
    /// Indices of the rotary axes of the head and of the table, from the bed outwards.
    head: Vec<usize>,
    table: Vec<usize>,
    spindle: DVec3,
    mount: DMat3,
    /// The rotary axes from the workpiece to the tool: index, and direction in which the tool goes.
    chain: [(usize, DVec3); 2],
    /// Angle between the two, and between the second and the spindle (rad).
    between: f64,
    to_spindle: f64,
}

impl Kinematics {
    pub(super) fn new(machine: &MillingMachine, directions: [DVec3; 2], spindle: DVec3, mount: DMat3) -> Self {
        let of = |carrier| (0..2).filter(|&i| machine.rotary[i].carried_by == carrier).collect::<Vec<usize>>();
        let (head, table) = (of(CarriedBy::Head), of(CarriedBy::Table));
        let outside_in = table.iter().rev().map(|&i| (i, -directions[i]));
        let chain: Vec<(usize, DVec3)> = outside_in.chain(head.iter().map(|&i| (i, directions[i]))).collect();
        let chain = [chain[0], chain[1]];
        let (between, to_spindle) = (angle(chain[0].1, chain[1].1), angle(chain[1].1, spindle));
        Self { machine: machine.clone(), directions, head, table, spindle, mount, chain, between, to_spindle }
    }

    pub(super) fn check(&self) -> Result<(), MachineError> {
        if self.between.sin() < LEAST_SINE {
            let remedy = "the two rotary axes are parallel; two that are not are needed to turn a tool anywhere";
            return Err(self.machine.bad("rotary.direction", self.chain[0].1, remedy));
        }
        if self.to_spindle.sin() < LEAST_SINE {
            let key = format!("rotary {}: direction", self.letter(self.chain[1].0));
            let remedy = "this axis is next to the tool and lies along the spindle, so that it only spins the tool; \
                          check the order of the axes (from the bed outwards) and the spindle's direction";
            return Err(self.machine.bad(key, self.chain[1].1, remedy));
        }
        Ok(())
    }

    /// The machine's data.
    pub fn machine(&self) -> &MillingMachine {
        &self.machine
    }

    /// Head-head, head-table or table-table.
    pub fn kind(&self) -> MachineKind {
        match self.head.len() {
            0 => MachineKind::TableTable,
            1 => MachineKind::HeadTable,
            _ => MachineKind::HeadHead,
        }
    }

    /// The letter of rotary axis `i` of the machine.
    pub fn letter(&self, i: usize) -> char {
        self.machine.rotary[i].letter.letter()
    }

    /// The rotary axis that is free where the tool lies along it: that next to the workpiece.
    pub fn pole_axis(&self) -> usize {
        self.chain[0].0
    }

    /// Partner, next to the tool.
    pub fn tilt_axis(&self) -> usize {
        self.chain[1].0
    }

    /// Position of the spindle nose in machine coordinates (mm), with both rotary axes at zero. The limits of X, Y and
    /// Z hold for it.
    pub fn slides(&self, joints: &Joints) -> DVec3 {
        joints.linear + self.offset()
    }

    /// A vector of the workpiece's frame in the machine's directions, with both rotary axes at zero: what a control
    /// that follows the tool's tip is given.
    pub fn in_machine(&self, v: DVec3) -> DVec3 {
        self.mount * v
    }

    /// The reverse of [`Self::in_machine`].
    pub fn in_workpiece(&self, v: DVec3) -> DVec3 {
        self.mount.transpose() * v
    }

    /// From programmed X, Y, Z to the slides.
    fn offset(&self) -> DVec3 {
        self.machine.workpiece.zero_mm + self.spindle * self.machine.gauge_length_mm
    }

    fn rotation(&self, i: usize, value: f64) -> DMat3 {
        DMat3::from_axis_angle(self.directions[i], value)
    }

    /// From the spindle nose to the tip with the head turned, and the tool's direction there, both in machine
    /// directions.
    fn head_turned(&self, rotary: &[f64; 2]) -> (DVec3, DVec3) {
        let start = (-self.spindle * self.machine.gauge_length_mm, self.spindle);
        self.head.iter().rev().fold(start, |(q, s), &i| {
            let (r, p) = (self.rotation(i, rotary[i]), self.machine.rotary[i].point_mm);
            (p + r * (q - p), r * s)
        })
    }

    /// The tool in the workpiece's frame.
    pub fn forward(&self, joints: &Joints) -> ToolPose {
        let (q, s) = self.head_turned(&joints.rotary);
        let start = (self.slides(joints) + q, s);
        let (x, d) = self.table.iter().fold(start, |(x, d), &i| {
            let (r, p) = (self.rotation(i, -joints.rotary[i]), self.machine.rotary[i].point_mm);
            (p + r * (x - p), r * d)
        });
        let back = self.mount.transpose();
        ToolPose { tip: back * (x - self.machine.workpiece.zero_mm), axis: back * d }
    }

    /// The tool's direction in the workpiece's frame for values of the rotary axes (rad).
    pub fn direction(&self, rotary: &[f64; 2]) -> DVec3 {
        let [(i, a), (j, b)] = self.chain;
        let turned = DMat3::from_axis_angle(a, rotary[i]) * (DMat3::from_axis_angle(b, rotary[j]) * self.spindle);
        self.mount.transpose() * turned
    }

    /// The values of X, Y, Z that bring the tip to `tip` (workpiece's frame) with these values of the rotary axes.
    pub fn with_tip(&self, tip: DVec3, rotary: [f64; 2]) -> Joints {
        let start = self.machine.workpiece.zero_mm + self.mount * tip;
        let at = self.table.iter().rev().fold(start, |x, &i| {
            let (r, p) = (self.rotation(i, rotary[i]), self.machine.rotary[i].point_mm);
            p + r * (x - p)
        });
        Joints { linear: at - self.head_turned(&rotary).0 - self.offset(), rotary }
    }

    /// Angle from a direction of the tool to the nearer end of the pole (rad).
    pub fn off_pole(&self, axis: DVec3) -> f64 {
        let angle = angle(self.mount * axis, self.chain[0].1);
        angle.min(std::f64::consts::PI - angle)
    }

    /// Both values of the rotary axes (rad, each within half a turn of zero) that give the tool this direction, unit,
    /// of the workpiece's frame. At the pole the value of [`Self::pole_axis`] means nothing.
    ///
    /// # Errors
    /// [`MachineError::Unreachable`].
    pub fn inverse(&self, axis: DVec3) -> Result<[[f64; 2]; 2], MachineError> {
        let d = self.mount * axis;
        let [(i, a), (j, b)] = self.chain;
        let (to_d, to_s, between) = (angle(a, d), self.to_spindle, self.between);
        let furthest = (to_s + between).min(std::f64::consts::TAU - to_s - between);
        let beyond = ((to_s - between).abs() - to_d).max(to_d - furthest);
        if beyond.is_nan() || beyond > REACH_ROUNDING {
            return Err(MachineError::Unreachable { direction: axis, by_deg: beyond.to_degrees() });
        }
        // The triple product of a, b and the meeting point from the three angles between them; from their cosines it
        // would lose half of its digits near the pole.
        let half = (to_d + to_s + between) / 2.0;
        let product = half.sin() * (half - to_d).sin() * (half - to_s).sin() * (half - between).sin();
        let triple = 2.0 * product.max(0.0).sqrt();
        let (g, along_a, along_b) = (a.dot(b), a.dot(d), b.dot(self.spindle));
        let sine_squared = a.cross(b).length_squared();
        let flat = (a * (along_a - g * along_b) + b * (along_b - g * along_a)) / sine_squared;
        Ok([1.0, -1.0].map(|sign| {
            let meeting = flat + a.cross(b) * (sign * triple / sine_squared);
            let mut rotary = [0.0; 2];
            rotary[j] = angle_about(b, self.spindle, meeting);
            rotary[i] = angle_about(a, meeting, d);
            rotary
        }))
    }

    /// The values with the pole's axis at `pole_value` (rad) that bring the tool nearest to this direction.
    pub fn nearest_with_pole_at(&self, axis: DVec3, pole_value: f64) -> [f64; 2] {
        let [(i, a), (j, b)] = self.chain;
        let turned_back = DMat3::from_axis_angle(a, -pole_value) * (self.mount * axis);
        let mut rotary = [0.0; 2];
        (rotary[i], rotary[j]) = (pole_value, angle_about(b, self.spindle, turned_back));
        rotary
    }

    /// An upper bound of the second derivative over t in [0, 1] of the place in the workpiece's frame of the tool's
    /// point at `height`, while every axis goes linearly from one position to the other (mm).
    pub fn bend(&self, from: &Joints, to: &Joints, height: f64) -> f64 {
        let change = |axes: &[usize]| axes.iter().map(|&i| (to.rotary[i] - from.rotary[i]).abs()).sum::<f64>();
        let (head_turn, table_turn) = (change(&self.head), change(&self.table));
        let point = |axes: &[usize], n: usize| axes.get(n).map(|&i| self.machine.rotary[i].point_mm);
        // A turned point goes at most its distance from the axes, taken along the chain, per radian.
        let lever = |axes: &[usize], from_end: DVec3, n: usize| match (point(axes, n), point(axes, 1 - n)) {
            (Some(p), Some(q)) => from_end.distance(p) + p.distance(q),
            _ => point(axes, 0).map_or(0.0, |p| from_end.distance(p)),
        };
        let from_nose = self.spindle * (height - self.machine.gauge_length_mm);
        let head = lever(&self.head, from_nose, 1);
        let speed = from.linear.distance(to.linear) + head_turn * head;
        let start = self.slides(from) + self.head_turned(&from.rotary).0;
        let table = lever(&self.table, start, 0) + height + speed;
        head_turn.powi(2) * head + 2.0 * table_turn * speed + table_turn.powi(2) * table
    }
}

/// Angle between two unit vectors (rad), exact for small ones too.
fn angle(a: DVec3, b: DVec3) -> f64 {
    a.cross(b).length().atan2(a.dot(b))
}

/// Angle about the unit vector `axis` that turns `from` to above or below `to` (rad).
fn angle_about(axis: DVec3, from: DVec3, to: DVec3) -> f64 {
    let across = |v: DVec3| v - axis * axis.dot(v);
    let (from, to) = (across(from), across(to));
    axis.dot(from.cross(to)).atan2(from.dot(to))
}
