//! A flank milled with the side of a cutter: the surface, the path in three steps, the checks of the one that is milled,
//! and its positions on a machine. Pure: it reads no files.

pub mod settings;

use std::ops::Deref;
use std::sync::Arc;

use glam::DVec3;

use crate::flank_job::settings::{CutDirection, MillingSettings, PathChoice};
use files::{Override, sha256};
use flank::FlankError;
use flank::check_grid::{CheckGrid, CheckedPath};
use flank::cutter::FlankCutter;
use flank::fit_ruled::{Candidate, CandidateFit, RuledFit};
use flank::gouge;
use flank::gouge::{Clearance, GougeCheck};
use flank::guide::GuideCurve;
use flank::guide_joining::Joining;
use flank::inside_wall::within;
use flank::machine::joint_feed::{Contact, Slowed};
use flank::machine::kinematics::{Kinematics, ToolPose};
use flank::machine::linearise::{LinearisationParams, MachinePath};
use flank::machine::milling_machine::MillingMachine;
use flank::machine::tool_path::{ToolPath, ToolPathError};
use flank::own_leads::own_gouge_of_moves;
use flank::own_surface::{OwnGouge, OwnSurfaceCheck, own_surface};
use flank::params::FlankParams;
use flank::path::{FlankPath, FlankPose};
use flank::plan::{FlankPlan, plan_flank};
use flank::ruled_surface::{RuledSurface, Side};
use flank::walls::{OwnTriangles, Walls};
use geometry::mesh::Mesh;
use task::{Cancel, Cancelled, Task};

mod checks;
mod clearances;
mod motion;
mod places;

pub use checks::{CheckKind, FlankCheck};
use motion::{chordal_deviation, leads, milled, tool_path};

/// Distance from the surface within which a given wall counts as the surface itself (mm): the same part once more.
const OWN_MM: f64 = 0.01;

/// Source of a surface, read from its files.
#[derive(Debug, Clone)]
pub enum LoadedSurface {
    /// Two guides.
    Guides {
        /// Guide that the cutter's bottom follows.
        lower: GuideCurve,
        /// Upper guide.
        upper: GuideCurve,
    },
    /// A face of a mesh.
    Face {
        /// The mesh.
        mesh: Arc<Mesh>,
        /// Faces that could be milled, as [`flank_candidates`](flank::fit_ruled::flank_candidates) has them.
        candidates: Arc<Vec<Candidate>>,
        /// Number of the face, from 1.
        number: usize,
        /// Whether the rest of the mesh is looked at for gouges.
        is_own_wall: bool,
    },
}

impl LoadedSurface {
    /// Digest of the guides, or of the mesh with the number of its face.
    fn digest(&self) -> String {
        let mut bytes = Vec::new();
        let mut add =
            |point: &DVec3| point.to_array().iter().for_each(|part| bytes.extend(part.to_bits().to_le_bytes()));
        match self {
            Self::Guides { lower, upper } => return sha256(format!("{lower:?} {upper:?}").as_bytes()),
            Self::Face { mesh, number, .. } => {
                mesh.vertices.iter().for_each(&mut add);
                bytes.extend(mesh.triangles.iter().flatten().flat_map(|corner| corner.to_le_bytes()));
                bytes.extend(number.to_le_bytes());
            }
        }
        sha256(&bytes)
    }
}

/// Input of a flank.
#[derive(Debug, Clone)]
pub struct FlankInput {
    /// Name of the flank.
    pub name: String,
    /// The surface.
    pub surface: LoadedSurface,
    /// Doubts about the files of surface and walls, in words.
    pub doubts: Vec<String>,
    /// Side of the surface that the cutter stands on.
    pub side: Side,
    /// The cutter.
    pub cutter: FlankCutter,
    /// How the path is planned.
    pub params: FlankParams,
    /// Path that is milled.
    pub path: PathChoice,
    /// Other walls that must not be cut.
    pub walls: Option<Arc<Mesh>>,
    /// The machine; none for cutter locations only.
    pub machine: Option<MillingMachine>,
    /// Machine settings, clearances and motions of the milling.
    pub milling: MillingSettings,
    /// How much the moving cutter may cut otherwise than the standing one at any place (mm).
    pub envelope_tolerance_mm: f64,
    /// How deep the path may cut into the surface, standing or moving (mm).
    pub overcut_tolerance_mm: f64,
    /// How much stock it may leave on the surface, standing or moving (mm).
    pub undercut_tolerance_mm: f64,
    /// Checks that do not keep anything from being exported.
    pub overrides: Vec<Override>,
    /// Whether checks are taken on the plan's own coarse grid, for a preview; nothing may be milled by them.
    pub is_preview: bool,
}

/// Why there is no flank path at all.
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
        /// Why it does not fit.
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

/// The path in the positions of a machine.
#[derive(Debug, Clone)]
pub struct Milled {
    /// The machine.
    pub machine: Kinematics,
    /// Positions.
    pub line: MachinePath,
    /// Parameters of the positions.
    pub params: LinearisationParams,
    /// Where the flutes touch, for the feed.
    pub contact: Contact,
    /// Time of every move (min), one less than the positions.
    pub move_minutes: Vec<f64>,
    /// Time from the first position to the last (min).
    pub minutes: f64,
    /// Moves that are slower than asked for.
    pub slowed: Option<Slowed>,
}

/// Results and checks of a flank.
#[derive(Debug, Clone)]
pub struct FlankFacts {
    /// Name of the flank.
    pub name: String,
    /// Digest of what the surface was made of: what overrides were decided for.
    pub part: String,
    /// The surface, on the side that was chosen.
    pub surface: RuledSurface,
    /// The fit to the face of a mesh; none for guides.
    pub fit: Option<RuledFit>,
    /// How rows of points that are guides were joined; empty without such.
    pub joinings: Vec<Joining>,
    /// The paths.
    pub plan: FlankPlan,
    /// Path that is milled.
    pub path: PathChoice,
    /// Results of that path over the grid that it is checked on.
    pub checked: CheckedPath,
    /// Clearances; none if there is nothing that could be gouged.
    pub gouge: Option<GougeCheck>,
    /// Effect of the whole tool on the surface itself all along the path.
    pub own_surface: OwnSurfaceCheck,
    /// Clearances of the approach and of the retraction, each from the surface outwards.
    pub lead_gouge: [Option<GougeCheck>; 2],
    /// Where the approach and the retraction cut the surface itself deeper than the path does at its ends; t is the share
    /// of the moves, from the surface outwards.
    pub lead_own: [Option<OwnGouge>; 2],
    /// The straight moves that lead to it and from it, outside first.
    pub approach: Vec<ToolPose>,
    /// Straight moves of the retraction, from the surface outwards.
    pub retract: Vec<ToolPose>,
    /// The machine's path, or why there is none; none of both without a machine.
    pub milled: Option<Result<Milled, String>>,
    /// Greatest chordal deviation of tip and flutes' top on straight moves (mm).
    pub chordal_deviation_mm: f64,
    /// Machine settings, clearances and motions of the milling.
    pub milling: MillingSettings,
    /// How much the moving cutter may cut otherwise than the standing one at any place (mm).
    pub envelope_tolerance_mm: f64,
    /// How deep the path may cut into the surface, standing or moving (mm).
    pub overcut_tolerance_mm: f64,
    /// How much stock it may leave on the surface, standing or moving (mm).
    pub undercut_tolerance_mm: f64,
    /// Checks of the path.
    pub checks: Vec<FlankCheck>,
    /// Warnings on the path, in words.
    pub warnings: Vec<String>,
    /// Overrides that override nothing, and why, in words.
    pub idle_overrides: Vec<String>,
    /// Whether the checks were taken on the plan's own grid, to be quick: nothing is approved by them.
    pub is_preview: bool,
}

/// A planned flank with its checks. Only [`flank()`] makes one, and its facts can be read but not changed, so that no check
/// can be taken away and no path be exchanged for another one.
///
/// ```compile_fail,E0596
/// fn unchecked(mut result: nc::flank_job::FlankResult) {
///     result.checks.clear();
/// }
/// ```
///
/// ```compile_fail,E0451
/// fn made_up(facts: nc::flank_job::FlankFacts) -> nc::flank_job::FlankResult {
///     nc::flank_job::FlankResult { facts }
/// }
/// ```
#[derive(Debug, Clone)]
pub struct FlankResult {
    facts: FlankFacts,
}

impl Deref for FlankResult {
    type Target = FlankFacts;

    fn deref(&self) -> &FlankFacts {
        &self.facts
    }
}

impl FlankResult {
    /// The path that is milled.
    pub fn path(&self) -> &FlankPath {
        path_of(&self.plan, self.path)
    }

    /// Greatest overcut and undercut (mm) of the path that is milled as the cutter moves, on the grid of the plan or on that
    /// of the checks, whichever is worse.
    pub fn moving_most(&self) -> [f64; 2] {
        let both = [&self.path().envelope.deviation, &self.checked.envelope.deviation];
        let overcut = both.iter().fold(0.0, |most: f64, d| most.max(-d.most_overcut));
        [overcut, both.iter().fold(0.0, |most: f64, d| most.max(d.most_undercut))]
    }

    /// Decides anew which failing checks are let pass.
    pub fn decide(&mut self, overrides: &[Override]) {
        let part = [self.part.clone()];
        self.facts.checks.iter_mut().for_each(|check| check.decide(&part, overrides));
        self.facts.idle_overrides = checks::idle(&part, &self.checks, overrides);
    }

    /// Flank with another name for its cutter, which appears in files only as text.
    pub fn with_cutter_name(mut self, name: &str) -> Self {
        name.clone_into(&mut self.facts.plan.cutter.name);
        self
    }

    /// The decision to export although `check` fails, for this surface and as bad as it is now.
    pub fn let_pass(&self, check: &FlankCheck) -> Override {
        Override::decided(check.kind.name(), vec![self.part.clone()], &check.figures)
    }

    /// Overrides with the figures that they were decided for: those for any finding are for the finding made here.
    pub fn remembered(&self, overrides: &[Override]) -> Vec<Override> {
        let failing = |name: &str| self.checks.iter().find(|c| !c.holds && c.kind.name() == name);
        let remembered = |one: &Override| match failing(&one.check) {
            Some(check) if one.is_for_whatever() => self.let_pass(check),
            _ => one.clone(),
        };
        overrides.iter().map(remembered).collect()
    }

    /// Whether every check holds.
    pub fn holds(&self) -> bool {
        self.checks.iter().all(|c| c.holds)
    }

    /// Why nothing is exported: the checks that fail and are not overridden; none if there are none such.
    pub fn why_blocked(&self) -> Option<String> {
        let failed = self.checks.iter().filter(|c| !c.holds && !c.is_overridden);
        let lapsed = |c: &FlankCheck| c.lapsed.as_ref().map_or_else(String::new, |why| format!(" (override: {why})"));
        let failed: Vec<String> = failed.map(|c| format!("{}: {}{}", c.kind.name(), c.text, lapsed(c))).collect();
        (!failed.is_empty()).then(|| failed.join("; "))
    }

    /// Warnings on the path, and notes of the machine on it.
    pub fn all_warnings(&self) -> Vec<String> {
        self.warnings.iter().chain(&self.idle_overrides).cloned().chain(checks::of_machine(self)).collect()
    }

    /// The path that is milled with its leads, as a function for machines and posts.
    ///
    /// # Errors
    /// [`ToolPathError`].
    pub fn tool_path(&self) -> Result<ToolPath<'_>, ToolPathError> {
        tool_path(self.path(), &self.approach, &self.retract)
    }

    /// The machine's path, if there is one.
    pub fn milled(&self) -> Option<&Milled> {
        self.milled.as_ref()?.as_ref().ok()
    }
}

/// The path of a plan that was chosen.
pub fn path_of(plan: &FlankPlan, choice: PathChoice) -> &FlankPath {
    match choice {
        PathChoice::Initial => &plan.initial,
        PathChoice::Chosen => &plan.chosen,
        PathChoice::Refined => &plan.refined,
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
/// As [`flank()`].
pub fn surface(input: &FlankInput) -> Result<(RuledSurface, Option<RuledFit>), FlankJobError> {
    let (surface, fit) = surface_as_given(input)?;
    // Along u with the rulings upwards the cutter goes on the right of the surface if it stands where R_u x R_v points to.
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
