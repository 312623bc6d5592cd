//! Tool path of a machine: a flank path as a function, with the straight moves that lead to and from it.

use std::f64::consts::PI;

use super::kinematics::ToolPose;
use glam::DVec3;

/// The most points of a path.
const MOST_POINTS: usize = 100_000;
/// The nearest to opposite that two directions of a straight move may be (rad).
const MOST_TURN: f64 = PI - 0.1;
/// The shortest straight move, as a part of the way from point to point.
const SHORTEST_MOVE: f64 = 1e-6;

/// Reason why a path is none.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ToolPathError {
    /// Too few or too many points.
    #[error("a path needs 2 to 100000 points of the cut, rising in u; it has {found}")]
    Points {
        /// How many there are.
        found: usize,
    },
    /// Parameters that do not rise.
    #[error("u does not rise from point {point} of the cut to the next ({from} to {to}); sort the points")]
    NotRising {
        /// Counted from 1.
        point: usize,
        /// u there.
        from: f64,
        /// u of the next.
        to: f64,
    },
    /// A place without a tool.
    #[error("{0}: the tool's place or direction is not a number there; check the path")]
    NotFinite(Place),
    /// Directions that no straight move can join.
    #[error("the tool turns by {by_deg:.1} degrees from {0} to the next point; give points between", at)]
    TurnsOver {
        /// Place on the path.
        at: Place,
        /// Angle of the turn (degrees).
        by_deg: f64,
    },
    /// A path that no straight moves follow.
    #[error(
        "{at}: the path jumps by {by_mm:.5} mm there, and no points between help; smooth it or raise the tolerance"
    )]
    Jumps {
        /// Place on the path.
        at: Place,
        /// How far it still leaves the shortest move (mm).
        by_mm: f64,
    },
}

/// The part of a path that a place is in.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Section {
    /// Approach to the cut, with the lead-in.
    Approach,
    /// The cut.
    Cut,
    /// Retraction from the cut, with the lead-out.
    Retract,
}

/// A place on a path in words.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Place {
    /// The part.
    pub section: Section,
    /// The point before it, counted from 1 within the part.
    pub point: usize,
    /// Part of the way from that point to the next.
    pub fraction: f64,
    /// The path's own parameter; only in the cut.
    pub u: Option<f64>,
}

impl std::fmt::Display for Place {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let section = match self.section {
            Section::Approach => "approach",
            Section::Cut => "cut",
            Section::Retract => "retract",
        };
        write!(f, "{section} point {}", self.point)?;
        if self.fraction > 0.0 {
            write!(f, " + {:.3}", self.fraction)?;
        }
        self.u.map_or(Ok(()), |u| write!(f, " (u = {u:.5})"))
    }
}

type Cut<'a> = Box<dyn Fn(f64) -> (DVec3, DVec3) + Sync + 'a>;

/// A path in the workpiece's frame. Its parameter s counts points: s = 3.5 lies half way from point 3 to point 4,
/// counted from 0 with the first point of the approach.
pub struct ToolPath<'a> {
    cut: Cut<'a>,
    points: Vec<f64>,
    approach: Vec<ToolPose>,
    retract: Vec<ToolPose>,
}

/// A path as straight moves of tip and axis.
#[derive(Debug, Clone, PartialEq)]
pub struct StraightMoves {
    /// End of each move on the [`ToolPath`], with the tool there; the first is the start.
    pub moves: Vec<(f64, ToolPose)>,
    /// The furthest that was measured between them (mm).
    pub chordal_deviation_mm: f64,
}

impl<'a> ToolPath<'a> {
    /// The path that `cut` gives: tip and direction to the spindle (of any length but 0) for u. `points` are the values
    /// of u that are programmed in any case.
    ///
    /// # Errors
    /// [`ToolPathError`].
    pub fn new(cut: impl Fn(f64) -> (DVec3, DVec3) + Sync + 'a, points: &[f64]) -> Result<Self, ToolPathError> {
        Self::with_leads(cut, points, &[], &[])
    }

    /// Path with straight moves: through `approach` to the first point and from the last through `retract`.
    ///
    /// # Errors
    /// [`ToolPathError`].
    pub fn with_leads(
        cut: impl Fn(f64) -> (DVec3, DVec3) + Sync + 'a,
        points: &[f64],
        approach: &[ToolPose],
        retract: &[ToolPose],
    ) -> Result<Self, ToolPathError> {
        if !(2..=MOST_POINTS).contains(&(points.len() + approach.len() + retract.len())) || points.len() < 2 {
            return Err(ToolPathError::Points { found: points.len() });
        }
        let falling = points.windows(2).position(|w| w[0].partial_cmp(&w[1]) != Some(std::cmp::Ordering::Less));
        if let Some(i) = falling {
            return Err(ToolPathError::NotRising { point: i + 1, from: points[i], to: points[i + 1] });
        }
        let (approach, retract) = (approach.to_vec(), retract.to_vec());
        let path = Self { cut: Box::new(cut), points: points.to_vec(), approach, retract };
        let poses = (0..=path.last()).map(|i| path.at(i as f64)).collect::<Result<Vec<_>, _>>()?;
        for (i, pair) in poses.windows(2).enumerate() {
            let by = pair[0].axis.angle_between(pair[1].axis);
            if by > MOST_TURN && path.section(i as f64 + 0.5) != Section::Cut {
                return Err(ToolPathError::TurnsOver { at: path.place(i as f64), by_deg: by.to_degrees() });
            }
        }
        Ok(path)
    }

    /// The greatest s.
    pub fn last(&self) -> usize {
        self.approach.len() + self.points.len() + self.retract.len() - 1
    }

    /// The part that s lies in; where the cut meets a lead, the cut.
    pub fn section(&self, s: f64) -> Section {
        let (first, last) = self.cut_ends();
        if s < first {
            Section::Approach
        } else if s <= last {
            Section::Cut
        } else {
            Section::Retract
        }
    }

    /// Whether s lies in the cut or on the move that leads onto it or off it, where the cutter may touch the flank.
    pub fn is_on_flank(&self, s: f64) -> bool {
        let (first, last) = self.cut_ends();
        s > first - 1.0 && s < last + 1.0
    }

    /// The nearest place of the cut.
    pub(super) fn within_cut(&self, s: f64) -> f64 {
        let (first, last) = self.cut_ends();
        s.clamp(first, last)
    }

    /// s of the first and of the last point of the cut.
    fn cut_ends(&self) -> (f64, f64) {
        let first = self.approach.len();
        (first as f64, (first + self.points.len() - 1) as f64)
    }

    fn u(&self, s: f64) -> f64 {
        let along = s - self.cut_ends().0;
        let i = (along.max(0.0) as usize).min(self.points.len() - 2);
        let t = along - i as f64;
        // Both ends come out exactly.
        self.points[i] * (1.0 - t) + self.points[i + 1] * t
    }

    /// The tool at s.
    ///
    /// # Errors
    /// [`ToolPathError::NotFinite`].
    pub fn at(&self, s: f64) -> Result<ToolPose, ToolPathError> {
        let (tip, axis) = match self.section(s) {
            Section::Cut => (self.cut)(self.u(s)),
            _ => self.on_lead(s),
        };
        match (tip.is_finite(), axis.try_normalize()) {
            (true, Some(axis)) => Ok(ToolPose { tip, axis }),
            _ => Err(ToolPathError::NotFinite(self.place(s))),
        }
    }

    fn on_lead(&self, s: f64) -> (DVec3, DVec3) {
        let i = (s.max(0.0) as usize).min(self.last() - 1);
        let (from, to, t) = (self.lead_point(i), self.lead_point(i + 1), s - i as f64);
        (from.0.lerp(to.0, t), from.1.lerp(to.1, t))
    }

    fn lead_point(&self, i: usize) -> (DVec3, DVec3) {
        let (first, last) = self.cut_ends();
        let lead = |pose: &ToolPose| (pose.tip, pose.axis.normalize_or_zero());
        let end_of_cut = |u: f64| {
            let (tip, axis) = (self.cut)(u);
            (tip, axis.normalize_or_zero())
        };
        match self.section(i as f64) {
            Section::Approach => lead(&self.approach[i]),
            Section::Cut if i as f64 <= first => end_of_cut(self.points[0]),
            Section::Cut => end_of_cut(self.points[self.points.len() - 1]),
            Section::Retract => lead(&self.retract[i - last as usize - 1]),
        }
    }

    /// s in words.
    pub fn place(&self, s: f64) -> Place {
        let (first, last) = self.cut_ends();
        let section = self.section(s);
        let (start, u) = match section {
            Section::Approach => (0.0, None),
            Section::Cut => (first, Some(self.u(s))),
            Section::Retract => (last + 1.0, None),
        };
        // On the way from the last point of the cut the retraction has not reached its own first one.
        let along = s - start;
        let point = if along < 0.0 { 0 } else { along as usize };
        let fraction = if along < 0.0 { 1.0 + along } else { along - point as f64 };
        let counted = if along < 0.0 { 0 } else { point + 1 };
        Place { section, point: counted, fraction, u }
    }

    /// The path as straight moves of tip and axis, for a control or a post that does the rest: no point of the tool's
    /// axis from the tip up to `reach_mm` is further than `tolerance_mm` from where it would be. Measured at 7 places
    /// of every move.
    ///
    /// # Errors
    /// [`ToolPathError`].
    pub fn straightened(&self, tolerance_mm: f64, reach_mm: f64) -> Result<StraightMoves, ToolPathError> {
        let (mut moves, mut chordal_deviation_mm) = (vec![(0.0, self.at(0.0)?)], 0.0f64);
        for i in 0..self.last() {
            let mut open = vec![(i as f64 + 1.0, self.at(i as f64 + 1.0)?)];
            while let Some(&(to, end)) = open.last() {
                let (from, start) = moves[moves.len() - 1];
                let by_mm = self.chordal_deviation(from, &start, to, &end, reach_mm)?;
                if by_mm <= tolerance_mm {
                    chordal_deviation_mm = chordal_deviation_mm.max(by_mm);
                    moves.push((to, end));
                    open.pop();
                } else if to - from < SHORTEST_MOVE || by_mm.is_nan() {
                    return Err(ToolPathError::Jumps { at: self.place(from), by_mm });
                } else {
                    let middle = 0.5 * (from + to);
                    open.push((middle, self.at(middle)?));
                }
            }
        }
        Ok(StraightMoves { moves, chordal_deviation_mm })
    }

    fn chordal_deviation(
        &self,
        from: f64,
        start: &ToolPose,
        to: f64,
        end: &ToolPose,
        reach: f64,
    ) -> Result<f64, ToolPathError> {
        let mut most = 0.0f64;
        for k in 1..8 {
            let t = f64::from(k) / 8.0;
            let true_pose = self.at(from + (to - from) * t)?;
            let straight = ToolPose {
                tip: start.tip.lerp(end.tip, t),
                axis: start.axis.lerp(end.axis, t).try_normalize().unwrap_or(start.axis),
            };
            let off = |h: f64| true_pose.at_height(h).distance(straight.at_height(h));
            most = most.max(off(0.0)).max(off(reach));
        }
        Ok(most)
    }
}
