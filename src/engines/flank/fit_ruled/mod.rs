//! Ruled surfaces fitted to faces of a triangle mesh, to flank-mill them.
//!
//! The border of the face is cut at four corners into two guides and two end rulings; ways to do so are tried, and the
//! one with the best fit stays. Both guides are cubic B-splines with common knots, so that rulings join equal
//! parameters. Gauss-Newton steps on their control points make the distances of the face from the surface small, feet
//! being looked for anew at each; pieces that are off are halved until the surface is within the tolerance or gets no
//! better.
//!
//! The corners of triangles lie on the surface that was tessellated, places inside of them do not: the fit goes by the
//! corners, and both are measured. A face whose triangles are coarse says little about the surface between its corners;
//! [`RuledFit::chord_mm`] tells how little.
//!
//! Guaranteed: the distances named are those at some 20000 places of the face and some 3000 of the surface. Not
//! guaranteed: that a face that is said not to be ruled has no better ruled surface than the one found, nor what lies
//! between places.

mod band;
mod candidates;
mod exact;
mod knots;
mod measure;
mod params;
mod patch;
mod sides;
mod solve;
mod strip;
#[cfg(test)]
mod tests;

use glam::DVec3;

use self::params::FIRST_COUNT;
use self::patch::Patch;
use self::sides::Sides;
use self::solve::Samples;
use self::strip::Strip;
use geometry::mesh::Mesh;
use geometry::nurbs::{FitError, NurbsCurve};
use task::Cancel;

pub use self::candidates::{Candidate, CandidateFit, CandidateKind, candidates_among, flank_candidates};
pub use self::params::{PartBase, RuledFitError, RuledFitParams};

/// Number of control points of each guide of a face all around.
const RING_COUNT: usize = 19;
/// Corners of the mesh by which surfaces are compared while one is looked for.
const COMPARED: usize = 2_000;
/// Points of the face by which the first surfaces are fitted, and the last one.
const FIRST_POINTS: usize = 400;
const LAST_POINTS: usize = 1_600;
/// Share of the guides by which a face may reach beyond their ends.
const COVERED: f64 = 2e-3;
/// The chord error that is allowed for beside the tolerance, as so many tolerances: triangles that leave more say too
/// little about the surface.
const MOST_CHORD: f64 = 20.0;
/// Triangles above which a face is fitted by fewer of its corners only.
const MANY: usize = 100_000;

/// A ruled surface fitted to a face, and how far it is off.
#[derive(Debug, Clone, PartialEq)]
pub struct RuledFit {
    /// The lower guide, a cubic B-spline with parameters from 0 to 1.
    pub lower: NurbsCurve,
    /// The upper guide with the same knots: rulings join equal parameters. Along the guides crossed with from the lower
    /// to the upper one points out of the solid, to the side on which the tool stands.
    pub upper: NurbsCurve,
    /// Distances of the face from the surface, at corners of triangles and inside of them.
    pub error: FitError,
    /// Distances of the triangles' corners alone. They lie on the surface that was tessellated.
    pub error_corners: FitError,
    /// Distances of the surface from the face, where it lies over the face.
    pub error_back: FitError,
    /// Where the face is farthest from the surface (mm).
    pub worst: DVec3,
    /// How far the triangles may be off a smooth surface through their corners (mm), estimated from how they turn.
    pub chord_mm: f64,
    /// How far the guides are off the border of the face (mm).
    pub border_mm: f64,
    /// How far the surface reaches beyond the face or over holes in it (mm).
    pub overhang_mm: f64,
    /// How far the face reaches beyond the surface (mm): so much stays unmilled at its ends.
    pub uncovered_mm: f64,
    /// Where that is (mm).
    pub uncovered_at: DVec3,
    /// How far pieces of the face that do not hang together with the largest one are off the surface or beyond it (mm).
    pub lost_mm: f64,
    /// The tolerance that was asked for (mm).
    pub tolerance_mm: f64,
    /// Whether the form of the face is ruled within the tolerance: the corners are as near as that, other places and
    /// those of the surface nearer than the tolerance and the chord error together, of which twenty tolerances are
    /// allowed for.
    pub is_ruled: bool,
    /// Whether what mills the surface mills all of the face: neither the face nor a piece of it reaches beyond the
    /// surface by more than the tolerance and the chord error together, and the latter is not above twenty tolerances.
    pub covers: bool,
    /// Whether the face runs all around: both guides end where they start, with the same slope and the same bend.
    pub is_closed: bool,
    /// Whether guides and rulings are those of the CAD program's face, not fitted.
    pub is_known: bool,
    /// Notes on the fit, one sentence each; the first says whether the face is ruled.
    pub words: Vec<String>,
}

/// A strip on its way.
struct Trial {
    sides: Sides,
    samples: Samples,
    strip: Strip,
    error: f64,
    /// Whether it reaches beyond an end of the face.
    is_longer: bool,
}

impl Trial {
    fn surface(&self) -> Found<'_> {
        Found { sides: &self.sides, strip: &self.strip, is_longer: self.is_longer, is_known: false }
    }
}

/// A surface that a face is answered with.
struct Found<'a> {
    sides: &'a Sides,
    strip: &'a Strip,
    /// Whether it reaches beyond an end of the face.
    is_longer: bool,
    /// Whether its guides are those of the CAD program.
    is_known: bool,
}

/// Fits a ruled surface to `triangles` of `mesh`, which should hang together and have two long sides. A face all
/// around, as of a cylinder, has closed guides, whose seam is at a ruling; holes are bridged.
///
/// # Errors
/// [`RuledFitError`] if the face cannot be laid out as a strip. One that is only not ruled is answered with the error.
pub fn fit_ruled(
    mesh: &Mesh,
    triangles: &[u32],
    params: &RuledFitParams,
    cancel: &Cancel,
) -> Result<RuledFit, RuledFitError> {
    params.validate()?;
    cancel.check()?;
    let patch = Patch::of(mesh, triangles)?;
    cancel.check()?;
    if patch.loops.is_empty() {
        return Err(RuledFitError::Closed);
    }
    let up = params.up.normalize_or_zero();
    let choices = sides::choices(&patch, up);
    let trials = first_trials(&patch, choices, params, cancel);
    cancel.check()?;
    let trial = best(trials, params, up).ok_or(RuledFitError::NoSides)?;
    let trial = refined(&patch, trial, params);
    cancel.check()?;
    answer(&patch, &trial.surface(), params, cancel)
}

/// The ruled surface of a face that a CAD program gives the guides of, measured against the face; none where that is not
/// the surface of the face, or where it goes beyond what cubic guides can be.
///
/// # Errors
/// As [`fit_ruled`].
pub fn known_ruled(
    mesh: &Mesh,
    triangles: &[u32],
    guides: &[[NurbsCurve; 2]],
    params: &RuledFitParams,
    cancel: &Cancel,
) -> Result<Option<RuledFit>, RuledFitError> {
    params.validate()?;
    if guides.is_empty() {
        return Ok(None);
    }
    cancel.check()?;
    let patch = Patch::of(mesh, triangles)?;
    cancel.check()?;
    let Some(surface) = exact::surface(&patch, guides, params.up.normalize_or_zero()) else {
        return Ok(None);
    };
    let found = Found { sides: &surface.0, strip: &surface.1, is_longer: false, is_known: true };
    let fit = answer(&patch, &found, params, cancel)?;
    // A face with a border beside the guides is another one, which they alone do not tell.
    let near = fit.tolerance_mm + fit.chord_mm.min(MOST_CHORD * fit.tolerance_mm);
    let is_whole = fit.is_ruled && fit.covers && fit.border_mm <= near && fit.overhang_mm <= near;
    Ok(is_whole.then_some(fit))
}

/// Surfaces with few control points over each choice of sides, from two starts each. What is far worse than another
/// after some steps is given up.
fn first_trials(patch: &Patch, choices: Vec<Sides>, params: &RuledFitParams, cancel: &Cancel) -> Vec<Trial> {
    let enough = 0.1 * params.tolerance_mm;
    let mut trials: Vec<Trial> = Vec::new();
    for sides in choices {
        let is_long = sides.is_ring && params.most_control_points >= RING_COUNT;
        let count = if is_long { RING_COUNT } else { FIRST_COUNT };
        let samples = Samples::of(patch, &sides, (FIRST_POINTS, params.tolerance_mm), cancel);
        let starts = [false, true].into_iter().filter_map(|by_tangents| sides.strip(count, by_tangents));
        let strips = starts.map(|start| samples.improved(start, 3, enough));
        let measured = strips.map(|strip| (measure::quick(patch, &strip, FIRST_POINTS), strip));
        if let Some((error, strip)) = measured.reduce(|a, b| if b.0 < 0.95 * a.0 { b } else { a }) {
            trials.push(Trial { sides, samples, strip, error, is_longer: false });
        }
    }
    let least = trials.iter().map(|t| t.error).fold(f64::INFINITY, f64::min);
    trials.retain(|t| t.error <= params.tolerance_mm.max(3.0 * least));
    for trial in &mut trials {
        trial.strip = trial.samples.improved(trial.strip.clone(), 8, enough);
        trial.error = measure::quick(patch, &trial.strip, FIRST_POINTS);
    }
    trials
}

/// Of trials about as good as the best one that which is most like a strip standing up.
fn best(trials: Vec<Trial>, params: &RuledFitParams, up: DVec3) -> Option<Trial> {
    let least = trials.iter().map(|t| t.error).fold(f64::INFINITY, f64::min);
    let enough = params.tolerance_mm.max(1.2 * least);
    let lean = |t: &Trial| {
        let [a, b] = t.strip.ends(0.5);
        t.sides.cost + 0.3 * (1.0 - (b - a).normalize_or_zero().dot(up).abs())
    };
    let good = trials.into_iter().filter(|t| t.error <= enough);
    good.reduce(|a, b| if lean(&b) < lean(&a) { b } else { a })
}

/// With all points of the face and pieces halved; where that is not enough, with ends that are no rulings, too.
fn refined(patch: &Patch, trial: Trial, params: &RuledFitParams) -> Trial {
    let free = released(&trial, params);
    let mut best = halved(patch, trial, params);
    if best.error > params.tolerance_mm
        && let Some(free) = free.map(|free| halved(patch, free, params))
        && free.error < 0.8 * best.error
    {
        best = free;
    }
    covered(patch, &mut best, params);
    best
}

/// With pieces halved where the surface is off, as long as that helps.
fn halved(patch: &Patch, mut trial: Trial, params: &RuledFitParams) -> Trial {
    let enough = 0.25 * params.tolerance_mm;
    let points = trial.sides.guides.iter().map(Vec::len).max().unwrap_or(0);
    // Where triangles are coarse only the corners tell of the surface; more control points than those would be free.
    let told = if patch.chord < params.tolerance_mm { usize::MAX } else { (points + 3).max(FIRST_COUNT) };
    let most = params.most_control_points.min(told);
    let (ends, cancel) = (trial.samples.ends, trial.samples.cancel.clone());
    trial.samples = Samples::of(patch, &trial.sides, (LAST_POINTS, params.tolerance_mm), &cancel);
    trial.samples.ends = ends;
    let mut strip = trial.samples.improved(trial.strip.clone(), 10, 0.1 * enough);
    let error = measure::quick(patch, &strip, COMPARED);
    (trial.strip, trial.error) = (strip.clone(), error);
    let mut in_vain = 0;
    while trial.error > enough && in_vain < 3 && !cancel.is_cancelled() {
        let errors = measure::by_piece(patch, &strip, COMPARED);
        let Some(finer) = strip.refined(&errors, enough, most) else { break };
        let next = trial.samples.improved(finer, 10, 0.1 * enough);
        let error = measure::quick(patch, &next, COMPARED);
        in_vain = if error < 0.8 * trial.error { 0 } else { in_vain + 1 };
        strip.clone_from(&next);
        if error < 0.98 * trial.error {
            (trial.strip, trial.error) = (next, error);
        }
    }
    trial
}

/// Makes the guides longer where the face reaches beyond the end rulings, by little as over an end that is bent.
fn covered(patch: &Patch, trial: &mut Trial, params: &RuledFitParams) {
    if trial.sides.is_ring {
        return;
    }
    let held = trial.samples.ends;
    let Some(longer) = longer(&mut trial.samples, &trial.strip, 0.1) else { return };
    let strip = trial.samples.improved(longer, 8, 0.02 * params.tolerance_mm);
    let error = measure::quick(patch, &strip, COMPARED);
    if error <= params.tolerance_mm.max(1.05 * trial.error) {
        (trial.strip, trial.error, trial.is_longer) = (strip, error, true);
    } else {
        trial.samples.ends = held;
    }
}

/// The strip with guides so long, by at most a share `most` at each end, that the face does not reach beyond its ends,
/// which are held there; none if it does not.
fn longer(samples: &mut Samples, strip: &Strip, most: f64) -> Option<Strip> {
    let [low, high] = samples.reach(strip);
    if low > -COVERED && high < 1.0 + COVERED {
        return None;
    }
    let longer = strip.between(low.clamp(-most, 0.0), high.clamp(1.0, 1.0 + most))?;
    let [start, end] = [longer.ends(0.0), longer.ends(1.0)];
    samples.ends = Some([0, 1].map(|side| [start[side], end[side]]));
    Some(longer)
}

/// The strip with its ends let go, where these may be no rulings: it then reaches beyond the face. None where it is
/// good enough as it is.
fn released(trial: &Trial, params: &RuledFitParams) -> Option<Trial> {
    if trial.sides.is_ring || trial.error <= params.tolerance_mm {
        return None;
    }
    let enough = 0.1 * params.tolerance_mm;
    let mut samples = trial.samples.clone();
    samples.ends = None;
    let mut strip = samples.improved(trial.strip.clone(), 8, enough);
    if let Some(longer) = longer(&mut samples, &strip, 0.25) {
        strip = samples.improved(longer, 8, enough);
    }
    Some(Trial { sides: trial.sides.clone(), samples, strip, error: trial.error, is_longer: true })
}

fn answer(patch: &Patch, surface: &Found, params: &RuledFitParams, cancel: &Cancel) -> Result<RuledFit, RuledFitError> {
    let [lower, upper] = surface.strip.guides(patch.origin)?;
    let found = measure::measured(patch, surface.sides, surface.strip, cancel)?;
    let tolerance = params.tolerance_mm;
    let with_chord = tolerance + patch.chord.min(MOST_CHORD * tolerance);
    // What lies between corners is known of a surface that was given, however coarse the triangles.
    let is_told = surface.is_known || patch.chord <= MOST_CHORD * tolerance;
    let is_near = surface.is_known || found.all.greatest_mm <= with_chord && found.back.greatest_mm <= with_chord;
    let is_ruled = found.corners.greatest_mm <= tolerance && is_near;
    let covers = found.uncovered <= with_chord && found.lost <= with_chord && is_told;
    let mut fit = RuledFit {
        lower,
        upper,
        error: found.all,
        error_corners: found.corners,
        error_back: found.back,
        worst: found.worst,
        chord_mm: patch.chord,
        border_mm: found.border,
        overhang_mm: found.overhang,
        uncovered_mm: found.uncovered,
        uncovered_at: found.uncovered_at,
        lost_mm: found.lost,
        tolerance_mm: tolerance,
        is_ruled,
        covers,
        is_closed: surface.sides.is_ring,
        is_known: surface.is_known,
        words: Vec::new(),
    };
    fit.words = words(patch, surface.is_longer, &fit);
    Ok(fit)
}

fn words(patch: &Patch, is_longer: bool, fit: &RuledFit) -> Vec<String> {
    let place = |p: DVec3| format!("({:.2}, {:.2}, {:.2})", p.x, p.y, p.z);
    let (off, within) = (fit.error_corners.greatest_mm, fit.tolerance_mm);
    let much = within + fit.chord_mm.min(MOST_CHORD * within);
    let is_near = fit.error.greatest_mm <= much && off <= within;
    let mut words = vec![if fit.is_ruled {
        format!("ruled within {within:.4} mm: corners of the mesh are at most {off:.4} mm off")
    } else if is_near {
        let back = fit.error_back.greatest_mm;
        format!("not ruled within {within:.4} mm: the surface is up to {back:.4} mm off between points of the face")
    } else {
        format!("not ruled within {within:.4} mm: {:.4} mm off at {}", fit.error.greatest_mm, place(fit.worst))
    }];
    words.push(format!(
        "inside of triangles it is {:.4} mm off at most; the triangles themselves leave about {:.4} mm",
        fit.error.greatest_mm, fit.chord_mm
    ));
    if fit.is_known {
        words.push("guides and rulings are those of the CAD program's face, not fitted".into());
    } else if fit.chord_mm > MOST_CHORD * within {
        words.push(format!(
            "the triangles are too coarse: they leave {:.4} mm, and no more than {:.4} mm is allowed for; export \
             the mesh finer",
            fit.chord_mm,
            MOST_CHORD * within
        ));
    } else if fit.chord_mm > within {
        words.push(
            "the triangles are coarser than the tolerance: between their corners nothing is known so well".into(),
        );
    }
    if fit.is_closed {
        words.push(format!("the face runs all around; paths start and end at {}", place(fit.lower.point(0.0))));
    } else if patch.loops.len() > 1 {
        words.push(format!("the face has {} hole(s); the surface goes on over them", patch.loops.len() - 1));
    }
    if is_longer {
        words.push("an end of the face is no ruling: the surface reaches beyond it".into());
    }
    if fit.border_mm > much {
        words.push(format!("the guides leave the border of the face by up to {:.4} mm", fit.border_mm));
    }
    if fit.overhang_mm > much {
        words.push(format!(
            "the surface reaches up to {:.3} mm beyond the face: look at what is beside it",
            fit.overhang_mm
        ));
    }
    if fit.uncovered_mm > much {
        words.push(format!(
            "NOT COVERED: the face reaches up to {:.3} mm beyond the surface, farthest at {}, and stays unmilled \
             there: its ends are bent, or it has other than four sides",
            fit.uncovered_mm,
            place(fit.uncovered_at)
        ));
    }
    if patch.turned > 0 {
        words.push(format!("{} triangle(s) faced the other way than the rest and were turned", patch.turned));
    }
    if patch.lost > 1e-9 {
        let share = 100.0 * patch.lost;
        words.push(format!("the face is in pieces: only the largest is fitted, {share:.1} % of the area is left out"));
    }
    if fit.lost_mm > much {
        words.push(format!(
            "NOT COVERED: pieces that are left out reach up to {:.3} mm away from the surface",
            fit.lost_mm
        ));
    }
    if patch.triangles.len() > MANY {
        words.push(format!("of its {} triangles a part, evenly chosen, is looked at", patch.triangles.len()));
    }
    words
}
