//! The pole of a machine: where the tool lies along the rotary axis next to the workpiece, whose value means nothing
//! there. Passing it closely makes this axis swing by up to half a turn within a short way.

use super::joint_path::MillingError;
use super::kinematics::Kinematics;
use super::linearise::{LinearisationParams, MachinePoint};
use super::tool_path::{Place, ToolPath, ToolPathError};
use task::Cancel;

/// Places at which a stretch between two points is looked at for the pole.
const LOOKS: usize = 16;
/// Steps of the search for the closest place; each leaves 0.618 of what was left.
const STEPS: usize = 60;
/// Turning by less counts as holding still (degrees).
const STILL_DEG: f64 = 1.0;

/// Way of passing the pole.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Passage {
    /// The pole's axis stood, or nearly so.
    Held,
    /// The axis turned at the pole while the tool stayed where it was on the workpiece.
    TurnedInPlace {
        /// By how much (degrees).
        by_deg: f64,
    },
    /// The axis swung while the tool moved.
    Swung {
        /// By how much (degrees).
        by_deg: f64,
        /// Over which way of the tip on the workpiece (mm).
        over_mm: f64,
    },
}

/// A stretch of a path within the cone about the pole.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SingularPassage {
    /// Closest place.
    pub at: Place,
    /// Least angle to the pole (degrees).
    pub least_deg: f64,
    /// Letter of the pole's axis.
    pub axis: char,
    /// Way of passing the pole.
    pub passage: Passage,
}

impl std::fmt::Display for SingularPassage {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { at, least_deg, axis, passage } = self;
        write!(f, "{at}: the tool comes within {least_deg:.4} degrees of lying along axis {axis} (singular): ")?;
        match passage {
            Passage::Held => write!(f, "passed with {axis} held still"),
            Passage::TurnedInPlace { by_deg } => {
                write!(
                    f,
                    "{axis} turns there by {by_deg:.1} degrees with the tool kept in its place: it may mark the flank"
                )
            }
            Passage::Swung { by_deg, over_mm } => {
                write!(
                    f,
                    "{axis} swings by {by_deg:.1} degrees over {over_mm:.3} mm of the path, which a workpiece \
                     clamped tilted avoids"
                )
            }
        }
    }
}

/// Every point of the path, and between them the closest places to the pole within the cone.
pub(super) fn pole_places(
    k: &Kinematics,
    path: &ToolPath,
    params: &LinearisationParams,
    cancel: &Cancel,
) -> Result<Vec<f64>, MillingError> {
    let off = |s: f64| Ok::<f64, ToolPathError>(k.off_pole(path.at(s)?.axis));
    let mut places = vec![0.0];
    for i in 0..path.last() {
        cancel.check()?;
        let at = |n: usize| i as f64 + n as f64 / LOOKS as f64;
        let seen = (0..=LOOKS).map(|n| off(at(n))).collect::<Result<Vec<f64>, _>>()?;
        // Of a stretch that stays at the pole no place is closer to it than by rounding.
        let stays = seen.iter().all(|off| *off <= params.pole_rad());
        for n in (0..=LOOKS).filter(|_| !stays) {
            let (before, after) = (n.saturating_sub(1), (n + 1).min(LOOKS));
            let is_least = seen[n] < seen[before] || seen[n] < seen[after];
            if !is_least || seen[n] > seen[before] || seen[n] > seen[after] {
                continue;
            }
            let closest = least(&off, at(before), at(after))?;
            let is_inside = closest > i as f64 + 1e-6 && closest < i as f64 + 1.0 - 1e-6;
            if is_inside && off(closest)? < params.cone_rad() && places.last().is_none_or(|&s| closest > s + 1e-6) {
                places.push(closest);
            }
        }
        places.push(i as f64 + 1.0);
    }
    Ok(places)
}

/// Golden section.
fn least(f: &impl Fn(f64) -> Result<f64, ToolPathError>, mut low: f64, mut high: f64) -> Result<f64, ToolPathError> {
    let part = (5f64.sqrt() - 1.0) / 2.0;
    for _ in 0..STEPS {
        let (left, right) = (high - (high - low) * part, low + (high - low) * part);
        if f(left)? < f(right)? { high = right } else { low = left }
    }
    Ok(0.5 * (low + high))
}

/// The stretches of finished points within the cone.
pub(super) fn passages(
    k: &Kinematics,
    path: &ToolPath,
    points: &[MachinePoint],
    cone: f64,
) -> Result<Vec<SingularPassage>, MillingError> {
    let off = points.iter().map(|p| Ok(k.off_pole(path.at(p.s)?.axis))).collect::<Result<Vec<f64>, ToolPathError>>()?;
    let mut found = Vec::new();
    let mut first = 0;
    while first < points.len() {
        let end = (first..points.len()).find(|&i| off[i] >= cone).unwrap_or(points.len());
        if end > first {
            found.push(passage(k, path, &points[first..end], &off[first..end]));
        }
        first = end.max(first) + 1;
    }
    Ok(found)
}

fn passage(k: &Kinematics, path: &ToolPath, points: &[MachinePoint], off: &[f64]) -> SingularPassage {
    let closest = off.iter().enumerate().min_by(|a, b| a.1.total_cmp(b.1)).map_or(0, |(i, _)| i);
    let pole = k.pole_axis();
    let turn = |w: &[MachinePoint]| (w[1].joints.rotary[pole] - w[0].joints.rotary[pole]).to_degrees().abs();
    let (mut in_place, mut moving, mut way) = (0.0, 0.0, 0.0);
    for w in points.windows(2) {
        if w[0].s == w[1].s {
            in_place += turn(w);
        } else {
            moving += turn(w);
            way += w[0].tip.distance(w[1].tip);
        }
    }
    let passage = if in_place.max(moving) < STILL_DEG {
        Passage::Held
    } else if in_place > moving {
        Passage::TurnedInPlace { by_deg: in_place }
    } else {
        Passage::Swung { by_deg: moving, over_mm: way }
    };
    let at = path.place(points[closest].s);
    SingularPassage { at, least_deg: off[closest].to_degrees(), axis: k.letter(pole), passage }
}
