//! The copying (finishing) motion at the end of a feed (P0, III A).
//!
//! The walls of an electrode are turned away from their blades by the circumferential reductions, and its shroud side
//! is drawn in. From the final pose the table's axis A therefore turns the electrode back, first to the one wall, then
//! to the other, until each burning wall is a spark gap from its blade, and Z moves it outwards by the radial
//! reduction. It turns at several heights, up to the greatest, so that the corners at the shroud are burnt too.
//!
//! The motion is modelled as the machine makes it. Z is the direction of the channel's middle, so that a point at the
//! angle `phi` from the middle moves outwards by `cos(phi)` of it and sideways by `sin(phi)`, and a leaning wall that
//! is moved outwards comes nearer to its blade or farther from it. In a passage that does not run along the axis,
//! outwards is the direction from hub to shroud in the middle of what the electrode burns, and X and Y take part in it.
//! A turned hub side meets fillets, and the facets of a round hub, that it does not meet in the final pose. So the lowest
//! turn is at the least height that lets it go (nearly) furthest, the highest one at the greatest such height. Each turn
//! goes only as far as the electrode keeps its clearance and the axes go, and the whole is certified by the same verifier
//! as the feed.

use std::sync::{Mutex, PoisonError};

use serde::Serialize;

use super::certificate::{Certificate, TravelVerdict};
use super::machine::MachineParams;
use super::path::{FeedPath, PathRow};
use super::pose::{Axis, Pose};
use super::quantise::quantise_path;
use super::verify::{Verifier, VerifyError, VerifyOptions};
use geometry::frame::Frame;
use glam::DVec3;
use task::{Cancel, Task};
use wheel::channel::Surface;
use wheel::electrode::{Column, Electrode, ElectrodeParams};

/// Heights above the final pose, and below the greatest height, that turns are tried at (mm), in order.
const LIFTS: [f64; 7] = [0.0, 0.002, 0.005, 0.01, 0.015, 0.02, 0.05];
/// Share of a turn that is enough of it not to try another height.
const GOOD_TURN: f64 = 0.99;
/// Share of a turn that is worth to be made at the greatest height.
const WORTH_A_TURN: f64 = 0.5;
/// Distance between the heights of two turns (mm), and how many of them there are at most above the lowest: where more
/// would be needed they are farther apart.
const LEVEL: f64 = 0.15;
const MOST_LEVELS: usize = 8;
/// Halvings in the search for how far a move can go: to a 4096th of it.
const HALVINGS: usize = 12;
/// Places on a move that are looked at before all of it is believed.
const LOOKS: usize = 8;
/// Moves shorter than this are none: of A in rad and of Z in mm, steps of the files both.
const LEAST_MOVE: f64 = 1e-6;

/// Extent of a copying motion; no value is negative.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct CopyingExtent {
    /// Turn of A towards the low wall (rad).
    pub low: f64,
    /// Turn of A towards the high wall (rad).
    pub high: f64,
    /// Outwards, from the hub to the shroud: along Z in an axial channel (mm).
    pub outwards: f64,
}

/// A turn of A from 0 at a height and back.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Turn {
    /// Move outwards at which it turns (mm): the position of Z in an axial channel.
    pub outwards: f64,
    /// Angle of A (rad); negative towards the low wall, which is the one of smaller theta.
    pub a: f64,
}

impl CopyingExtent {
    /// Copying motion that undoes the reductions of `electrode`, made by `params` with its walls drawn in by a further
    /// `h` (rad). A column of a channel that is divided left and right copies to its own wall only.
    pub fn of(electrode: &Electrode, params: &ElectrodeParams, h: f64) -> Self {
        let params = params.of_part(electrode.part);
        let [low, high] = params.circumferential_reduction_deg.map(|deg| deg.to_radians() + h);
        let only = |column, value: f64| if electrode.column.is_none_or(|c| c == column) { value } else { 0.0 };
        Self { low: only(Column::Low, low), high: only(Column::High, high), outwards: params.radial_reduction_mm }
    }

    /// Copying motion that goes on by the wear `wear_mm` of `electrode` (mm) as well, which its walls may have given way by.
    #[must_use]
    pub fn beyond(self, electrode: &Electrode, wear_mm: f64) -> Self {
        let angle = wear_mm / electrode.middle().with_x(0.0).length().max(wear_mm);
        let more = |column, turn: f64| if electrode.column.is_none_or(|c| c == column) { turn + angle } else { turn };
        Self { low: more(Column::Low, self.low), high: more(Column::High, self.high), ..self }
    }

    /// Whether there is no motion.
    pub fn is_none(&self) -> bool {
        [self.low, self.high, self.outwards].iter().all(|v| *v < LEAST_MOVE)
    }
}

/// A copying motion with what the verifier says of it.
#[derive(Debug, Clone, PartialEq)]
pub struct CopyingMotion {
    /// Rows from the final pose back to the final pose, linear in every axis between.
    pub path: FeedPath,
    /// The verifier's word on them.
    pub certificate: Certificate,
    /// Extent that would undo the reductions.
    pub wanted: CopyingExtent,
    /// Extent reached.
    pub reached: CopyingExtent,
    /// The turns that it is made of.
    pub turns: Vec<Turn>,
}

/// Result of planning the copying motion of an electrode.
#[derive(Debug, Clone, PartialEq)]
pub enum Copying {
    /// There are no reductions to be undone.
    NotNeeded,
    /// The machine cannot make it: it has no axis A.
    NoTable,
    /// The copying motion.
    Made(Box<CopyingMotion>),
}

impl Copying {
    /// The motion, if it is certified.
    pub fn certified(&self) -> Option<&CopyingMotion> {
        match self {
            Self::Made(motion) if motion.holds() => Some(motion),
            _ => None,
        }
    }

    /// The result in one sentence.
    pub fn sentence(&self) -> String {
        match self {
            Self::NotNeeded => "No copying motion: there are no reductions.".to_owned(),
            Self::NoTable => "There is no copying motion: the machine has no axis A to turn the blisk.".to_owned(),
            Self::Made(motion) => motion.sentence(),
        }
    }
}

impl CopyingMotion {
    /// Whether the clearance is proven over the whole motion, which starts and ends in the final pose, within the
    /// travel of the axes.
    pub fn holds(&self) -> bool {
        let c = &self.certificate;
        let ends = [self.path.rows.first(), self.path.rows.last()];
        ends.into_iter().all(|row| row.is_some_and(|row| row.pose == Pose::FINAL))
            && c.keeps_clearance()
            && !matches!(c.travel(), TravelVerdict::Beyond(_))
    }

    /// Whether the reductions are undone, to a hundredth of each.
    pub fn is_whole(&self) -> bool {
        let (w, r) = (&self.wanted, &self.reached);
        r.low >= 0.99 * w.low && r.high >= 0.99 * w.high && r.outwards >= 0.99 * w.outwards
    }

    fn sentence(&self) -> String {
        let (w, r) = (&self.wanted, &self.reached);
        let turn = |name, wanted: f64, reached: f64| {
            (wanted >= LEAST_MOVE)
                .then(|| format!("{:.3} of {:.3} deg to the {name}", reached.to_degrees(), wanted.to_degrees()))
        };
        let out = (w.outwards >= LEAST_MOVE).then(|| format!("{:.3} of {:.3} mm outwards", r.outwards, w.outwards));
        let parts = [turn("low wall", w.low, r.low), turn("high wall", w.high, r.high), out];
        let c = &self.certificate;
        let verdict = if self.holds() {
            format!("certified clearance {:.4} mm; {}", c.certified(), c.demand())
        } else if let TravelVerdict::Beyond(beyond) = c.travel() {
            format!("not exported: {beyond}")
        } else {
            format!("not exported: only {:.4} mm are certified; {}", c.certified(), c.demand())
        };
        let limited = if self.is_whole() { "" } else { "; further it would cut too deep" };
        let list = parts.into_iter().flatten().collect::<Vec<_>>().join(", ");
        format!("The copying motion goes {list}{limited}; {verdict}.")
    }
}

/// Settings that a copying motion is made and judged with.
pub struct CopyingSettings<'a> {
    /// The machine.
    pub machine: &'a MachineParams,
    /// Verification.
    pub verify: &'a VerifyOptions,
    /// Spark gap (mm).
    pub spark_gap: f64,
    /// W in the coordinates of the loaded mesh.
    pub frame: Frame,
    /// Direction in W from the hub to the shroud in the middle of what the electrode burns, a unit vector.
    pub outwards: DVec3,
}

/// Makes the copying motion that goes as far as `wanted`, or as the clearance allows, and certifies it. `verifier` is
/// that of the blisk and the electrode, with the machine's travel.
///
/// # Errors
/// Every error of [`Verifier::verify`].
pub fn copying_motion(
    electrode: &Electrode,
    verifier: &Verifier,
    wanted: CopyingExtent,
    settings: &CopyingSettings,
    surface_of: &(dyn Fn(DVec3) -> Surface + Sync),
    task: &Task,
) -> Result<Copying, VerifyError> {
    if wanted.is_none() {
        return Ok(Copying::NotNeeded);
    }
    if !settings.machine.axes.axes().contains(&Axis::A) {
        return Ok(Copying::NoTable);
    }
    // Half the tolerance is left for the way between the rows.
    let least = settings.spark_gap - 0.5 * settings.verify.tolerance_mm;
    let limits = settings.machine.pose_limits();
    // What was too near to a wall last mostly is so at the next pose too.
    let too_near: [Mutex<Option<[u32; 2]>>; 2] = Default::default();
    let keeps = |pose: &Pose| {
        limits.beyond(pose).is_none() && {
            let last = || too_near[usize::from(pose.a > 0.0)].lock().unwrap_or_else(PoisonError::into_inner);
            let guess = *last();
            let found = verifier.nearer_than(pose, least, guess);
            *last() = found.or(guess);
            found.is_none()
        }
    };
    let (reached, turns) = reachable(&wanted, settings.outwards, &keeps, &task.cancel)?;
    let path = FeedPath {
        frame: settings.frame,
        reference_point: electrode.reference_point,
        spark_gap: settings.spark_gap,
        rows: rows_of(reached.outwards, settings.outwards, &turns),
    };
    let path = quantise_path(&path);
    let task = task.as_stage("copying motion");
    let certificate = verifier.verify(&path, surface_of, settings.verify, &task)?;
    Ok(Copying::Made(Box::new(CopyingMotion { path, certificate, wanted, reached, turns })))
}

/// Part of `wanted` that can be reached while `keeps` holds, and the turns that reach it.
fn reachable(
    wanted: &CopyingExtent,
    direction: DVec3,
    keeps: &(dyn Fn(&Pose) -> bool + Sync),
    cancel: &Cancel,
) -> Result<(CopyingExtent, Vec<Turn>), VerifyError> {
    let share = |from: Pose, to: Pose| share_of_move(&from, &to, keeps, cancel);
    let at = |a: f64, outwards: f64| lifted(a, outwards, direction);
    let top = wanted.outwards * share(Pose::FINAL, at(0.0, wanted.outwards))?;
    let to_wall = |turn: f64| {
        let mut turns: Vec<Turn> = Vec::new();
        if turn.abs() < LEAST_MOVE {
            return Ok(turns);
        }
        let at_height = |z: f64| Ok(Turn { outwards: z, a: turn * share(at(0.0, z), at(turn, z))? });
        let lowest = first_good_turn(turn, LIFTS.into_iter().filter(|z| *z <= top), &at_height)?;
        let Some(lowest) = lowest else { return Ok(turns) };
        turns.push(lowest);
        let room = top - lowest.outwards;
        if room >= LEAST_MOVE {
            let drops = LIFTS.into_iter().filter(|drop| *drop < room).map(|drop| top - drop);
            turns.extend(first_good_turn(turn, drops, &at_height)?);
            // Where a leaning wall lets it turn less the higher it is, the corner at the shroud wants the top all the
            // same.
            let highest = at_height(top)?;
            if highest.a.abs() >= WORTH_A_TURN * turn.abs() && !turns.contains(&highest) {
                turns.push(highest);
            }
        }
        let levels = ((room / LEVEL).ceil() as usize).min(MOST_LEVELS);
        for level in 1..levels {
            turns.push(at_height(lowest.outwards + room * level as f64 / levels as f64)?);
        }
        Ok::<_, VerifyError>(turns)
    };
    let (low, high) = rayon::join(|| to_wall(-wanted.low), || to_wall(wanted.high));
    let walls = [low?, high?];
    let [low, high] = [0, 1].map(|wall| walls[wall].iter().map(|t| t.a.abs()).fold(0.0, f64::max));
    Ok((CopyingExtent { low, high, outwards: top }, walls.concat()))
}

/// The first of the turns by `wanted` (rad) at `heights` that goes nearly as far as any of them, the heights being in
/// order of preference; none if there are no heights. Heights after a turn that is good enough are not tried.
fn first_good_turn(
    wanted: f64,
    heights: impl Iterator<Item = f64>,
    at_height: &dyn Fn(f64) -> Result<Turn, VerifyError>,
) -> Result<Option<Turn>, VerifyError> {
    let mut tried: Vec<Turn> = Vec::new();
    for z in heights {
        let turn = at_height(z)?;
        tried.push(turn);
        if turn.a.abs() >= GOOD_TURN * wanted.abs() {
            break;
        }
    }
    let furthest = tried.iter().map(|t| t.a.abs()).fold(0.0, f64::max);
    let slack = (1.0 - GOOD_TURN) * wanted.abs();
    Ok(tried.into_iter().find(|t| t.a.abs() >= furthest - slack))
}

/// Share of the motion between two poses that can be made while `keeps` holds.
fn share_of_move(from: &Pose, to: &Pose, keeps: &dyn Fn(&Pose) -> bool, cancel: &Cancel) -> Result<f64, VerifyError> {
    let good = |t: f64| cancel.check().map(|()| keeps(&from.lerp(to, t)));
    let (mut reached, mut blocked) = (0.0, None);
    for i in 1..=LOOKS {
        let t = i as f64 / LOOKS as f64;
        if !good(t)? {
            blocked = Some(t);
            break;
        }
        reached = t;
    }
    let Some(mut blocked) = blocked else { return Ok(1.0) };
    for _ in 0..HALVINGS {
        let middle = 0.5 * (reached + blocked);
        if good(middle)? { reached = middle } else { blocked = middle }
    }
    Ok(reached)
}

/// The pose turned by `a` (rad) and moved outwards (mm).
fn lifted(a: f64, outwards: f64, direction: DVec3) -> Pose {
    let DVec3 { x, y, z } = outwards * direction;
    Pose { a, x, y, z, ..Pose::FINAL }
}

/// The rows of a motion: outwards by `top` in the middle and, on the way, every turn at its height, always back to the
/// middle; at last back to the final pose.
fn rows_of(top: f64, direction: DVec3, turns: &[Turn]) -> Vec<PathRow> {
    let mut sorted = turns.to_vec();
    // From below: towards the low wall first where both turn at the same height.
    sorted.sort_by(|s, t| s.outwards.total_cmp(&t.outwards).then(s.a.total_cmp(&t.a)));
    let at = |a: f64, outwards: f64| lifted(a, outwards, direction);
    let slid = |pose: &Pose| DVec3::new(pose.x, pose.y, pose.z);
    let mut poses = vec![Pose::FINAL];
    let turned = sorted.iter().flat_map(|t| [at(0.0, t.outwards), at(t.a, t.outwards), at(0.0, t.outwards)]);
    for pose in turned.chain([at(0.0, top), Pose::FINAL]) {
        let last = poses[poses.len() - 1];
        if (pose.a - last.a).abs() >= LEAST_MOVE || slid(&pose).distance(slid(&last)) >= LEAST_MOVE {
            poses.push(pose);
        }
    }
    poses.into_iter().map(|pose| PathRow { node: 0, s: 0.0, pose }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const WANTED: CopyingExtent = CopyingExtent { low: 0.02, high: 0.01, outwards: 0.3 };

    fn reach(keeps: impl Fn(&Pose) -> bool + Sync) -> (CopyingExtent, Vec<Turn>) {
        reachable(&WANTED, DVec3::Z, &keeps, &Cancel::default()).unwrap()
    }

    #[test]
    fn the_rows_go_to_every_wall_at_every_height_and_back() {
        let (reached, turns) = reach(|_| true);
        assert_eq!(reached, WANTED);
        let poses: Vec<[f64; 2]> =
            rows_of(reached.outwards, DVec3::Z, &turns).iter().map(|r| [r.pose.a, r.pose.z]).collect();
        let level = |z| [[-0.02, z], [0.0, z], [0.01, z], [0.0, z]];
        let expected = [[[0.0, 0.0]].as_slice(), &level(0.0), &[[0.0, 0.15]], &level(0.15), &[[0.0, 0.3]], &level(0.3)];
        assert_eq!(poses, [expected.concat().as_slice(), &[[0.0, 0.0]]].concat());
        assert_eq!(rows_of(0.0, DVec3::Z, &[Turn { outwards: 0.0, a: -0.02 }]).len(), 3);
        assert!(rows_of(0.0, DVec3::Z, &[]).len() == 1 && CopyingExtent::default().is_none());
    }

    #[test]
    fn a_turn_is_lifted_by_as_much_as_it_takes() {
        // A step in the hub 8 um high, 0.005 rad towards the low wall.
        let (reached, turns) = reach(|pose| pose.a > -0.005 || pose.z >= 0.008);
        assert_eq!(reached, WANTED);
        assert_eq!(turns[0], Turn { outwards: 0.01, a: -0.02 });
        assert!(
            turns.contains(&Turn { outwards: 0.0, a: 0.01 }) && turns.contains(&Turn { outwards: 0.3, a: -0.02 }),
            "{turns:?}"
        );
    }

    #[test]
    fn a_move_ends_where_the_clearance_does() {
        // The low wall is met too early, and the high one leans over.
        let (reached, turns) = reach(|pose| pose.a > -0.013 && (pose.a <= 0.0 || pose.a + 0.01 * pose.z < 0.0104));
        assert!(reached.low < 0.013 && reached.low > 0.013 - 0.02 / 4000.0, "{reached:?}");
        assert_eq!((reached.high, reached.outwards), (0.01, 0.3));
        let top = turns.iter().find(|t| t.outwards == 0.3 && t.a > 0.0).unwrap();
        assert!(top.a < 0.0074 && top.a > 0.0074 - 0.01 / 4000.0, "{top:?}");
        let (reached, _) = reach(|pose| pose.z < 0.2);
        assert!(reached.outwards < 0.2 && reached.outwards > 0.2 - 0.3 / 4000.0, "{reached:?}");
    }
}
