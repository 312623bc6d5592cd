//! The verifier: proven bounds of the clearance over the whole continuous motion of a feed path.
//!
//! The verifier knows nothing of how the path was found. Between rows every axis moves linearly, as the machine will
//! move; clearance is proven over the continuous motion, not sampled. The least clearance is bounded from above by
//! closest points that occur, and from below by directions along which electrode and blisk are proven to stay apart
//! (`interval.rs`, `motion.rs`); bounds are sharpened until they are within the resolution asked for.
//!
//! Where the machine is known it also says whether its axes stay within their travel. What it does not tell: how deep
//! an interference is, anything about bodies that are not in the two meshes, such as a holder or the machine, and how
//! fast the axes may go, which is seen to where the feed is written.

use std::sync::atomic::{AtomicUsize, Ordering};

use glam::DVec3;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::machine::TravelLimits;
use super::outside::Outside;
use super::path::FeedPath;
use super::pose::Pose;
use certificate::{Certificate, Contact, Findings, TravelVerdict};
use geometry::mesh::Mesh;
use geometry::nearest_pair::{NearestPair, ROUNDING};
use geometry::triangle_distance::ClosestPoints;
use interval::{Answer, Question};
use pair::{Pair, Solid};
use task::{Cancel, Cancelled, Task};
use wheel::channel::Surface;

pub mod certificate;
mod inside;
mod interval;
mod motion;
pub mod pair;
pub mod setting;
#[cfg(test)]
mod tests;

/// Rows whose clearances are found one after the other, each from the closest triangles of the one before.
const ROWS_IN_TURN: usize = 8;
/// Intervals looked at between two decisions whether to stop.
const INTERVALS_IN_TURN: usize = 16;
/// How many violations are listed, and how far apart they are on the electrode or on the blisk (mm).
const VIOLATIONS: usize = 16;
const VIOLATION_SPACING: f64 = 1.0;

/// Greatest coordinate (mm) and turn (rad) for which [`ROUNDING`] covers the rounding.
const LARGEST_COORDINATE: f64 = 1e4;
const LARGEST_TURN: f64 = 1e3;

/// Parameters of the verification.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct VerifyOptions {
    /// How far below the spark gap the clearance may fall (mm).
    pub tolerance_mm: f64,
    /// How close the proven bound comes to the smallest clearance met (mm).
    pub resolution_mm: f64,
    /// Whether to stop once the clearance is known to fall below the spark gap less the tolerance somewhere.
    pub stop_at_violation: bool,
}

impl Default for VerifyOptions {
    fn default() -> Self {
        Self { tolerance_mm: 0.002, resolution_mm: 0.0005, stop_at_violation: false }
    }
}

/// Reason why a path cannot be verified.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum VerifyError {
    /// One of the meshes has no triangles.
    #[error("the {0} mesh has no triangles: load a mesh that has a surface")]
    EmptyMesh(&'static str),
    /// One of the meshes has an undefined or absurd coordinate.
    #[error("vertex {1} of the {0} mesh has a coordinate that is no number or beyond 10 m: check mesh and units")]
    VertexOutOfRange(&'static str, usize),
    /// The path has no rows.
    #[error("the path has no rows: give at least the final pose")]
    EmptyPath,
    /// A row has an undefined or absurd value.
    #[error("row {0} of the path has a value that is no number or beyond 10 m or 1000 rad: correct that row")]
    RowOutOfRange(usize),
    /// A tolerance that leaves too little of the spark gap.
    #[error(
        "tolerance_mm is {tolerance_mm}: it must be 0 or more, and less than half of the path's spark gap of \
         {spark_gap_mm} mm"
    )]
    Tolerance {
        /// How far below the spark gap the clearance may fall (mm).
        tolerance_mm: f64,
        /// The spark gap (mm).
        spark_gap_mm: f64,
    },
    /// A parameter or the reference point is out of its range.
    #[error("{name} is {value}: it must be {must_be}")]
    Parameter {
        /// Name of the option.
        name: &'static str,
        /// Value of the option.
        value: f64,
        /// Range of valid values.
        must_be: &'static str,
    },
    /// Cancelled.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

impl VerifyOptions {
    /// Checks every parameter's range for paths of this spark gap (mm). No certificate is made of others: a clearance
    /// of half the gap or less would pass for one of the gap.
    ///
    /// # Errors
    /// [`VerifyError`] that names the parameter.
    pub fn validate(&self, spark_gap_mm: f64) -> Result<(), VerifyError> {
        let (tolerance_mm, value) = (self.tolerance_mm, self.resolution_mm);
        if !(tolerance_mm == 0.0 || (0.0..0.5 * spark_gap_mm).contains(&tolerance_mm)) {
            return Err(VerifyError::Tolerance { tolerance_mm, spark_gap_mm });
        }
        if !(1e-6..=1.0).contains(&value) {
            let must_be = "from 0.000001 to 1 mm";
            return Err(VerifyError::Parameter { name: "resolution_mm", value, must_be });
        }
        Ok(())
    }
}

/// The closest points of an electrode at some pose and the blisk.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Clearance {
    /// Distance (mm); 0 when the surfaces touch or cross.
    pub distance: f64,
    /// The point on the electrode, in its final pose in W (mm).
    pub on_electrode: DVec3,
    /// The point on the blisk, in W (mm).
    pub on_blisk: DVec3,
}

/// A blisk and an electrode made ready for distances and verification.
pub struct Verifier {
    blisk: Solid,
    electrode: Solid,
    /// Digests of the blisk and the electrode as they were given.
    digests: [String; 2],
    travel: Option<TravelLimits>,
    outside: Outside,
}

/// Verifies `path` for one electrode and blisk, both in W, the electrode in its final pose. `surface_of` names
/// the surface that a point of the blisk lies on. See [`Verifier::verify`].
pub fn verify(
    blisk: &Mesh,
    electrode: &Mesh,
    path: &FeedPath,
    surface_of: &(dyn Fn(DVec3) -> Surface + Sync),
    options: &VerifyOptions,
    task: &Task,
) -> Result<Certificate, VerifyError> {
    Verifier::new(blisk, electrode, path.reference_point, &task.cancel)?.verify(path, surface_of, options, task)
}

impl Verifier {
    /// Prepares a blisk and an electrode in its final pose, both in W, with the electrode's reference point O.
    pub fn new(blisk: &Mesh, electrode: &Mesh, reference_point: DVec3, cancel: &Cancel) -> Result<Self, VerifyError> {
        for (name, mesh) in [("blisk", blisk), ("electrode", electrode)] {
            if mesh.triangles.is_empty() {
                return Err(VerifyError::EmptyMesh(name));
            }
            if let Some(vertex) = mesh.vertices.iter().position(|&p| !in_range(p)) {
                return Err(VerifyError::VertexOutOfRange(name, vertex));
            }
        }
        if !in_range(reference_point) {
            let value = reference_point.length();
            return Err(VerifyError::Parameter {
                name: "the reference point's distance",
                value,
                must_be: "within 10 m",
            });
        }
        let (fixed, moving) =
            rayon::join(|| Solid::new(blisk, DVec3::ZERO, cancel), || Solid::new(electrode, reference_point, cancel));
        Ok(Self {
            blisk: fixed?,
            electrode: moving?,
            digests: [blisk.digest(), electrode.digest()],
            travel: None,
            outside: Outside::new(blisk, electrode, reference_point),
        })
    }

    /// Verifier that judges the travel of the axes too.
    pub fn within(self, travel: TravelLimits) -> Self {
        Self { travel: Some(travel), ..self }
    }

    /// The distance between the surfaces with the electrode at `pose`: exact to rounding.
    pub fn distance(&self, pose: &Pose) -> Clearance {
        let points = self.pair().nearest(pose, None).points;
        Clearance {
            distance: points.distance,
            on_electrode: self.in_final_pose(pose, points.first),
            on_blisk: points.second,
        }
    }

    /// Two triangles, of the electrode and of the blisk, that are nearer to each other than `limit` (mm) with the
    /// electrode at `pose`; none if its [`distance`](Self::distance) is not less. The answer at a pose near by, as
    /// `guess`, makes it fast.
    pub(super) fn nearer_than(&self, pose: &Pose, limit: f64, guess: Option<[u32; 2]>) -> Option<[u32; 2]> {
        self.pair().nearer_than(pose, limit, guess)
    }

    /// Bounds the clearance over the whole continuous motion of `path`, all axes linear between rows.
    ///
    /// The lower bound comes within the resolution of the smallest clearance met, unless a violation stopped
    /// the work. The same input gives the same certificate on any number of threads. Meshes have to be closed
    /// for an electrode wholly inside metal to be noticed; that is a violation at row 0 with clearance 0.
    pub fn verify(
        &self,
        path: &FeedPath,
        surface_of: &(dyn Fn(DVec3) -> Surface + Sync),
        options: &VerifyOptions,
        task: &Task,
    ) -> Result<Certificate, VerifyError> {
        let run = Run { body: self, path, surface_of, options, task };
        run.check_path()?;
        options.validate(path.spark_gap)?;
        run.certificate()
    }

    fn pair(&self) -> Pair<'_> {
        Pair { moving: &self.electrode, fixed: &self.blisk, resolution: 0.0, required: 0.0, share: 0.0 }
    }

    /// Where a point (in W) of the electrode at `pose` is in its final pose.
    fn in_final_pose(&self, pose: &Pose, p: DVec3) -> DVec3 {
        pose.placement(self.electrode.origin).inverse().transform_point3(p)
    }
}

/// Whether every coordinate is a number of sensible size.
fn in_range(p: DVec3) -> bool {
    p.abs().cmple(DVec3::splat(LARGEST_COORDINATE)).all()
}

/// One verification under way.
struct Run<'a> {
    body: &'a Verifier,
    path: &'a FeedPath,
    surface_of: &'a (dyn Fn(DVec3) -> Surface + Sync),
    options: &'a VerifyOptions,
    task: &'a Task,
}

impl Run<'_> {
    fn check_path(&self) -> Result<(), VerifyError> {
        let good = |pose: &Pose| {
            let turns = DVec3::new(pose.a, pose.b, pose.c);
            in_range(DVec3::new(pose.x, pose.y, pose.z)) && turns.abs().cmple(DVec3::splat(LARGEST_TURN)).all()
        };
        if self.path.rows.is_empty() {
            return Err(VerifyError::EmptyPath);
        }
        if let Some(row) = self.path.rows.iter().position(|row| !good(&row.pose) || !row.s.is_finite()) {
            return Err(VerifyError::RowOutOfRange(row));
        }
        let (value, name) = (self.path.spark_gap, "the path's spark gap");
        if !(value.is_finite() && value >= 0.0) {
            return Err(VerifyError::Parameter { name, value, must_be: "a length of 0 mm or more" });
        }
        if self.path.reference_point != self.body.electrode.origin {
            let value = self.path.reference_point.distance(self.body.electrode.origin);
            let name = "the distance of the path's reference point from the prepared electrode's";
            return Err(VerifyError::Parameter { name, value, must_be: "0: prepare the electrode for this path" });
        }
        Ok(())
    }

    fn limit(&self) -> f64 {
        self.path.spark_gap - self.options.tolerance_mm
    }

    fn certificate(&self) -> Result<Certificate, VerifyError> {
        let nearest = self.rows()?;
        let points: Vec<_> = nearest.iter().map(|n| n.points).collect();
        let mut at_rows: Vec<_> = points.iter().enumerate().map(|(row, &p)| self.contact(row, 0.0, p)).collect();
        self.note_inside(&mut at_rows[..1])?;
        let known = at_rows.iter().map(|c| c.distance).fold(f64::INFINITY, f64::min);
        let between = self.between_rows(known)?;
        let least = between.found.iter().map(|c| c.distance).fold(known, f64::min);
        if least <= self.options.resolution_mm && !self.options.stop_at_violation {
            // The surfaces may have crossed, and rows beyond the crossing be inside metal.
            self.note_inside(&mut at_rows)?;
        }
        let mut contacts: Vec<_> = at_rows.iter().chain(&between.found).copied().collect();
        contacts.sort_by(|p, q| p.distance.total_cmp(&q.distance).then(p.row.total_cmp(&q.row)));
        let [blisk_digest, electrode_digest] = self.body.digests.clone();
        let enters_from = self.body.outside.side_of(&self.path.rows[0].pose);
        Ok(Certificate::of(Findings {
            path_digest: self.path.digest(),
            blisk_digest,
            electrode_digest,
            required: self.path.spark_gap,
            tolerance: self.options.tolerance_mm,
            certified: between.certified,
            least: contacts[0],
            violations: apart(contacts.iter().filter(|c| c.distance < self.limit())),
            row_clearance: at_rows.iter().map(|c| c.distance).collect(),
            row_surface: at_rows.iter().map(|c| c.surface).collect(),
            enters_from,
            ends_right: enters_from.is_some() && self.path.rows.last().is_some_and(|row| row.pose == Pose::FINAL),
            travel: self.travel(),
            pair_intervals: between.pairs,
        }))
    }

    /// Sets the contacts of those rows to distance 0 where one body is inside the other.
    fn note_inside(&self, at_rows: &mut [Contact]) -> Result<(), Cancelled> {
        at_rows.par_iter_mut().enumerate().try_for_each(|(row, contact)| {
            self.task.check()?;
            if let Some(p) = self.body.pair().one_inside_the_other(&contact.pose, &self.task.cancel)? {
                *contact = self.contact(row, 0.0, ClosestPoints { distance: 0.0, first: p, second: p });
            }
            Ok(())
        })
    }

    fn travel(&self) -> TravelVerdict {
        match self.body.travel {
            None => TravelVerdict::NotJudged,
            Some(limits) => limits.first_beyond(&self.path.rows).map_or(TravelVerdict::Within, TravelVerdict::Beyond),
        }
    }

    /// The closest points at every row.
    fn rows(&self) -> Result<Vec<NearestPair>, VerifyError> {
        let done = AtomicUsize::new(0);
        let in_turn = |rows: &[super::path::PathRow]| {
            let mut guess = None;
            let mut found = Vec::with_capacity(rows.len());
            for row in rows {
                self.task.check()?;
                let nearest = self.body.pair().nearest(&row.pose, guess);
                guess = Some(nearest.triangles);
                found.push(nearest);
                self.report("clearance at the rows", &done);
            }
            Ok(found)
        };
        let parts: Result<Vec<_>, Cancelled> = self.path.rows.par_chunks(ROWS_IN_TURN).map(in_turn).collect();
        Ok(parts?.concat())
    }

    /// Bounds the clearance between rows, given the least clearance at the rows.
    fn between_rows(&self, known: f64) -> Result<Between, VerifyError> {
        let stop_below = if self.options.stop_at_violation { self.limit() } else { f64::NEG_INFINITY };
        let question = Question { known, resolution: self.options.resolution_mm, stop_below, errors: [0.0; 6] };
        let intervals: Vec<usize> = (0..self.path.rows.len() - 1).collect();
        let in_turn = if self.options.stop_at_violation { INTERVALS_IN_TURN } else { intervals.len().max(1) };
        let done = AtomicUsize::new(0);
        let mut stopped = known < stop_below;
        let mut between = Between { certified: known, found: Vec::new(), pairs: 0 };
        for part in intervals.chunks(in_turn) {
            if stopped {
                break;
            }
            let bound = |&i: &usize| {
                let answer = self.interval(i, &question);
                self.report("clearance between the rows", &done);
                answer
            };
            let answers: Result<Vec<Answer>, Cancelled> = part.par_iter().map(bound).collect();
            for (&i, answer) in part.iter().zip(answers?) {
                between.certified = between.certified.min(answer.lower);
                between.pairs += answer.pairs;
                if let Some((points, t)) = answer.found {
                    stopped |= points.distance < stop_below;
                    between.found.push(self.contact(i, t, points));
                }
            }
        }
        between.certified = if stopped { 0.0 } else { (between.certified - ROUNDING).max(0.0) };
        Ok(between)
    }

    fn interval(&self, i: usize, question: &Question) -> Result<Answer, Cancelled> {
        let (from, to) = (&self.path.rows[i].pose, &self.path.rows[i + 1].pose);
        self.body.pair().bound(from, to, question, &self.task.cancel)
    }

    /// Closest points (both in W) at the fraction `t` of the way from a row to the next.
    fn contact(&self, row: usize, t: f64, points: ClosestPoints) -> Contact {
        let rows = &self.path.rows;
        let (from, to) = (&rows[row], &rows[(row + 1).min(rows.len() - 1)]);
        let pose = from.pose.lerp(&to.pose, t);
        Contact {
            distance: points.distance,
            row: row as f64 + t,
            s: from.s + (to.s - from.s) * t,
            pose,
            on_electrode: self.body.in_final_pose(&pose, points.first),
            on_blisk: points.second,
            surface: (self.surface_of)(points.second),
        }
    }

    fn report(&self, stage: &str, done: &AtomicUsize) {
        let done = done.fetch_add(1, Ordering::Relaxed) + 1;
        self.task.report(stage, done as f64 / self.path.rows.len() as f64, "");
    }
}

/// Findings about the motion between rows.
struct Between {
    /// Proven lower bound of the clearance (mm).
    certified: f64,
    /// Smaller clearances than at any row.
    found: Vec<Contact>,
    /// Triangle pairs and windows bounded one by one.
    pairs: u64,
}

/// The first of `contacts` that are not close to one before, on both bodies.
fn apart<'a>(contacts: impl Iterator<Item = &'a Contact>) -> Vec<Contact> {
    let close = |p: &Contact, q: &Contact| {
        p.on_electrode.distance(q.on_electrode) < VIOLATION_SPACING
            && p.on_blisk.distance(q.on_blisk) < VIOLATION_SPACING
    };
    let mut kept: Vec<Contact> = Vec::new();
    for contact in contacts {
        if kept.len() < VIOLATIONS && !kept.iter().any(|other| close(contact, other)) {
            kept.push(*contact);
        }
    }
    kept
}
