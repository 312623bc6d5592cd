//! A flank milled with the side of a cutter: the surface, the path in three steps, the checks of the one that is
//! milled, and its positions on a machine. Pure: it reads no files.

pub mod settings;

mod checks;
mod clearances;
mod input;
mod motion;
mod places;
mod result;

use glam::DVec3;

use crate::flank_job::settings::CutDirection;
use flank::FlankError;
use flank::check_grid::CheckGrid;
use flank::fit_ruled::{CandidateFit, RuledFit};
use flank::gouge;
use flank::gouge::{Clearance, GougeCheck};
use flank::guide_joining::Joining;
use flank::inside_wall::within;
use flank::machine::kinematics::ToolPose;
use flank::own_leads::own_gouge_of_moves;
use flank::own_surface::own_surface;
use flank::path::{FlankPath, FlankPose};
use flank::plan::plan_flank;
use flank::ruled_surface::{RuledSurface, Side};
use flank::walls::{OwnTriangles, Walls};
pub use input::{FlankInput, LoadedSurface};
pub use motion::Milled;
use motion::{chordal_deviation, leads, milled, tool_path};
pub use result::{CheckKind, FlankCheck, FlankFacts, FlankResult, path_of};
use task::{Cancel, Cancelled, Task};

/// Distance from the surface within which a given wall counts as the surface itself (mm): the same part once more.
const OWN_MM: f64 = 0.01;

/// Reason why there is no flank path at all.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum FlankJobError {
    /// The surface, the cutter or the parameters.
    #[error(transparent)]
    Flank(#[from] FlankError),
    /// A face that there is not.
    #[error(
        "there is no flank {number}: the mesh has {count} that could be milled; they are counted from 1 as they are \
         listed"
    )]
    NoCandidate {
        /// Number asked for.
        number: usize,
        /// How many there are.
        count: usize,
    },
    /// A cutter for which no path can be made.
    #[error("{misfit}; no path can be made for it ({why})")]
    Cutter {
        /// Reason why it does not fit.
        misfit: FlankError,
        /// Error met then.
        why: FlankError,
    },
    /// A face without a ruled surface.
    #[error("flank {number} has no ruled surface: {why}; choose another flank")]
    NotFitted {
        /// Number of the flank.
        number: usize,
        /// Reason in words.
        why: String,
    },
}

impl FlankJobError {
    /// Whether it was told to stop.
    pub fn is_cancelled(&self) -> bool {
        matches!(self, Self::Flank(FlankError::Cancelled(_)))
    }
}

impl From<Cancelled> for FlankJobError {
    fn from(cancelled: Cancelled) -> Self {
        Self::Flank(cancelled.into())
    }
}

/// Plans a flank, checks the path that is milled and puts it on the machine. What fails a check is in the result.
///
/// # Errors
/// [`FlankJobError`] if there is no path at all; cancelled.
pub fn flank(input: &FlankInput, task: &Task) -> Result<FlankResult, FlankJobError> {
    let (surface, fit) = surface(input)?;
    let joinings = match &input.surface {
        LoadedSurface::Guides { lower, upper } => Joining::of(lower, upper)?,
        LoadedSurface::Face { .. } => Vec::new(),
    };
    let plan = plan_flank(&surface, &input.cutter, &input.params, task).map_err(|why| {
        // A cutter that does not fit is what is to blame, wherever it showed.
        let misfit = input.cutter.fits(&surface, input.params.below_mm).err().filter(|misfit| *misfit != why);
        match (&why, misfit) {
            (FlankError::Unmeasured { .. } | FlankError::NoLocation { .. }, Some(misfit)) => {
                FlankJobError::Cutter { misfit, why }
            }
            _ => why.into(),
        }
    })?;
    let path = path_of(&plan, input.path);
    let quick = input.is_preview.then(|| CheckGrid::even(&surface, input.params.grid));
    let grid = quick.unwrap_or_else(|| CheckGrid::new(&surface));
    let checked = grid.checked(path, &input.cutter.above(input.params.below_mm)?)?;
    let whole_tool = grid.for_whole_tool(&surface);
    let against = (&whole_tool, input.params.gouge_tolerance_mm);
    let own_surface = own_surface(path, &input.cutter, against, task)?;
    let [approach, retract] = leads(&surface, path, &input.milling);
    let walls = walls(input, (&surface, path), fit.as_ref(), &task.cancel)?;
    let gouge = lesser_of(&walls, |wall| gouge::check(path, &input.cutter, wall, task))?;
    let gouge = gouge.map(|gouge| lesser(gouge, within_walls(input, &path.pose(0.0))));
    let moves = |from: FlankPose, lead: &[ToolPose]| -> Result<_, FlankError> {
        let places: Vec<DVec3> = std::iter::once(from.tip).chain(lead.iter().map(|p| p.tip)).collect();
        let way = (&places[..], from.axis);
        let gouge = lesser_of(&walls, |wall| gouge::check_moves(way, &input.cutter, wall, task))?;
        let gouge = gouge.map(|gouge| lesser(gouge, within_walls(input, &from)));
        Ok((gouge, own_gouge_of_moves(way, &input.cutter, against, &task.cancel)?))
    };
    let inwards: Vec<ToolPose> = approach.iter().rev().copied().collect();
    let ((onto, onto_own), (off, off_own)) = (moves(path.pose(0.0), &inwards)?, moves(path.pose(1.0), &retract)?);
    task.report("positions of the machine", 0.0, "");
    let milled = input.machine.as_ref().map(|machine| {
        let path = tool_path(path, &approach, &retract).map_err(|e| e.to_string())?;
        milled(machine, &path, (&input.milling, &input.cutter), &task.cancel)
    });
    task.check()?;
    let chordal_deviation_mm =
        chordal_deviation(path, &input.milling, [&approach, &retract], (&input.cutter, milled.as_ref()));
    task.report("positions of the machine", 1.0, "");
    let facts = FlankFacts {
        name: input.name.clone(),
        part: input.surface.digest(),
        surface,
        fit,
        joinings,
        plan,
        path: input.path,
        checked,
        own_surface,
        gouge,
        lead_gouge: [onto, off],
        lead_own: [onto_own, off_own],
        approach,
        retract,
        milled,
        chordal_deviation_mm,
        milling: input.milling.clone(),
        envelope_tolerance_mm: input.envelope_tolerance_mm,
        overcut_tolerance_mm: input.overcut_tolerance_mm,
        undercut_tolerance_mm: input.undercut_tolerance_mm,
        checks: Vec::new(),
        warnings: Vec::new(),
        idle_overrides: Vec::new(),
        is_preview: input.is_preview,
    };
    let mut result = FlankResult { facts };
    result.facts.checks = checks::of(&result);
    result.decide(&input.overrides);
    result.facts.warnings = [input.doubts.clone(), checks::warnings(&result, input)].concat();
    Ok(result)
}

/// The surface, with u along the cutter's travel, and the fit that it is from.
///
/// # Errors
/// Every error of [`flank()`].
pub fn surface(input: &FlankInput) -> Result<(RuledSurface, Option<RuledFit>), FlankJobError> {
    let (surface, fit) = surface_as_given(input)?;
    // Along u with the rulings upwards the cutter goes on the right of the surface if it stands where R_u x R_v points
    // to.
    let is_climb = surface.side() == Side::Negative;
    let is_wanted = is_climb == (input.milling.cut == CutDirection::Climb);
    Ok((if is_wanted { surface } else { surface.reversed() }, fit))
}

fn surface_as_given(input: &FlankInput) -> Result<(RuledSurface, Option<RuledFit>), FlankJobError> {
    match &input.surface {
        LoadedSurface::Guides { lower, upper } => Ok((RuledSurface::from_guides(lower, upper, input.side)?, None)),
        LoadedSurface::Face { candidates, number, .. } => {
            let (number, count) = (*number, candidates.len());
            let found = number.checked_sub(1).and_then(|i| candidates.get(i));
            let fit = match &found.ok_or(FlankJobError::NoCandidate { number, count })?.fit {
                CandidateFit::Fitted(fit) => fit,
                CandidateFit::Refused(error) => {
                    return Err(FlankJobError::NotFitted { number, why: error.to_string() });
                }
                CandidateFit::NotTried => {
                    let why = "it is too small a face to be looked at".to_owned();
                    return Err(FlankJobError::NotFitted { number, why });
                }
            };
            // The fit's guides run so that the positive side is outside of the solid.
            let side = if input.side == Side::Automatic { Side::Positive } else { input.side };
            let surface = RuledSurface::new(fit.lower.clone(), fit.upper.clone(), side)?;
            Ok((surface, Some(fit.as_ref().clone())))
        }
    }
}

/// Walls that must not be cut: the part's own other faces and the given walls. Of a face of a mesh its own triangles
/// are known; in the given walls they are those that lie on them.
fn walls(
    input: &FlankInput,
    milled: (&RuledSurface, &FlankPath),
    fit: Option<&RuledFit>,
    cancel: &Cancel,
) -> Result<Vec<Walls>, FlankJobError> {
    let most_mm = fit.map_or(0.0, |f| f.error.greatest_mm.max(f.tolerance_mm) + f.chord_mm);
    let mut walls = Vec::new();
    let mut in_walls = OwnTriangles::Near(OWN_MM);
    if let LoadedSurface::Face { mesh, candidates, number, is_own_wall } = &input.surface {
        let own = number.checked_sub(1).and_then(|i| candidates.get(i)).map_or(&[][..], |c| &c.triangles);
        in_walls = OwnTriangles::On(mesh, own, OWN_MM);
        if *is_own_wall {
            walls.push(Walls::new(mesh, OwnTriangles::Listed(own), milled, most_mm, cancel)?);
        }
    }
    if let Some(given) = &input.walls {
        walls.push(Walls::new(given, in_walls, milled, most_mm, cancel)?);
    }
    Ok(walls)
}

/// The lesser clearances of a check against each of the walls; none without walls.
fn lesser_of(
    walls: &[Walls],
    check: impl Fn(&Walls) -> Result<GougeCheck, FlankError>,
) -> Result<Option<GougeCheck>, FlankError> {
    let mut found: Option<GougeCheck> = None;
    for wall in walls {
        let next = check(wall)?;
        found = Some(found.map_or(next, |found| lesser(found, next)));
    }
    Ok(found)
}

/// Parts of the tool at `pose` that are wholly within the part or the given walls.
fn within_walls(input: &FlankInput, pose: &FlankPose) -> GougeCheck {
    let part = match &input.surface {
        LoadedSurface::Face { mesh, is_own_wall: true, .. } => Some(mesh),
        _ => None,
    };
    let found = part.into_iter().chain(&input.walls).map(|wall| within(pose, &input.cutter, wall));
    found.reduce(lesser).unwrap_or_default()
}

/// The lesser clearances of two checks.
fn lesser(a: GougeCheck, b: GougeCheck) -> GougeCheck {
    let least = |a: Option<Clearance>, b: Option<Clearance>| {
        a.into_iter().chain(b).min_by(|a, b| a.distance_mm.total_cmp(&b.distance_mm))
    };
    GougeCheck { cutter: least(a.cutter, b.cutter), holder: least(a.holder, b.holder) }
}
