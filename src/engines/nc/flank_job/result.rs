//! The result of a planned flank: its facts and its checks, which cannot be changed.

use std::ops::Deref;

use files::{Figures, Override};
use glam::DVec3;

use super::motion::{Milled, tool_path};
use super::settings::{MillingSettings, PathChoice};
use crate::block_feed::LEAST_BLOCK_MINUTES;
use flank::check_grid::CheckedPath;
use flank::fit_ruled::RuledFit;
use flank::gouge::GougeCheck;
use flank::guide_joining::Joining;
use flank::machine::joint_feed::Slowed;
use flank::machine::kinematics::ToolPose;
use flank::machine::tool_path::{ToolPath, ToolPathError};
use flank::own_surface::{OwnGouge, OwnSurfaceCheck};
use flank::path::FlankPath;
use flank::plan::FlankPlan;
use flank::ruled_surface::RuledSurface;

/// The greatest figure of what is wrong: what is no number is as bad as that.
const WORST: f64 = 1e9;

/// Subject of a check.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum CheckKind {
    /// The face of the mesh is ruled.
    Ruled,
    /// The points of guides agree with the smooth curves through them.
    Guides,
    /// The cutter is long and thin enough.
    Cutter,
    /// The path covers the whole surface.
    Coverage,
    /// Overcut and undercut are within their tolerances.
    Deviation,
    /// The bounds asked for are kept.
    Bounds,
    /// The swept envelope agrees with the static cutter.
    Envelope,
    /// The whole tool cuts the surface itself nowhere deeper than where it stands over it.
    Surface,
    /// The flutes gouge no neighbouring wall.
    Gouge,
    /// The holder touches nothing.
    Holder,
    /// Approach and retraction cut no wall, and the surface itself no deeper than the path's ends do.
    Leads,
    /// The machine can follow within its limits and the tolerance.
    Machine,
}

impl CheckKind {
    /// All checks.
    pub const ALL: [Self; 12] = [
        Self::Ruled,
        Self::Guides,
        Self::Cutter,
        Self::Coverage,
        Self::Deviation,
        Self::Bounds,
        Self::Envelope,
        Self::Surface,
        Self::Gouge,
        Self::Holder,
        Self::Leads,
        Self::Machine,
    ];

    /// Name, by which it can be overridden.
    pub fn name(self) -> &'static str {
        match self {
            Self::Ruled => "ruled",
            Self::Guides => "guides",
            Self::Cutter => "cutter",
            Self::Coverage => "coverage",
            Self::Deviation => "deviation",
            Self::Bounds => "bounds",
            Self::Envelope => "envelope",
            Self::Surface => "surface",
            Self::Gouge => "gouge",
            Self::Holder => "holder",
            Self::Leads => "leads",
            Self::Machine => "machine",
        }
    }
}

/// Finding of a check.
#[derive(Debug, Clone, PartialEq)]
pub struct FlankCheck {
    /// Subject of the check.
    pub kind: CheckKind,
    /// Whether it is as it should be.
    pub holds: bool,
    /// Whether it fails and the user decided that it does not matter.
    pub is_overridden: bool,
    /// The finding with its figures.
    pub text: String,
    /// Place of the finding (mm), in the axes of the surface.
    pub place: Option<DVec3>,
    /// Parameter t of the path at the finding.
    pub t: Option<f64>,
    /// Figures of a failed check, if it can be counted: see [`Figures`].
    pub figures: Figures,
    /// Reason why an override for it no longer holds.
    pub lapsed: Option<String>,
}

impl FlankCheck {
    pub(super) fn new(kind: CheckKind, holds: bool, text: String) -> Self {
        let figures = Figures::new();
        Self { kind, holds, is_overridden: false, text, place: None, t: None, figures, lapsed: None }
    }

    /// Check with the figures of its failure; figures within their limits are left out.
    pub(super) fn with(mut self, figures: &[(&str, f64)]) -> Self {
        let wrong = figures.iter().filter(|(_, figure)| !self.holds && (*figure > 0.0 || figure.is_nan()));
        let kept = |figure: f64| if figure.is_finite() { figure.min(WORST) } else { WORST };
        self.figures.extend(wrong.map(|(name, figure)| ((*name).to_owned(), kept(*figure))));
        self
    }

    /// Takes `overrides` for the decisions on it, made of `part`.
    pub fn decide(&mut self, part: &[String], overrides: &[Override]) {
        let of_it = overrides.iter().filter(|o| !self.holds && o.check == self.kind.name());
        let mut lapsed = Vec::new();
        let mut is_overridden = false;
        for one in of_it {
            match one.lapsed(part, &self.figures) {
                None => is_overridden = true,
                Some(why) => lapsed.push(why),
            }
        }
        (self.is_overridden, self.lapsed) = (is_overridden, lapsed.pop().filter(|_| !is_overridden));
    }

    pub(super) fn at(self, place: DVec3) -> Self {
        Self { place: Some(place), ..self }
    }
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
    /// Joining of guides given as points; empty for other guides.
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
    /// Where the approach and the retraction cut the surface itself deeper than the path does at its ends; t is the
    /// share of the moves, from the surface outwards.
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
    /// Greatest difference between the swept envelope and the static deviation at any sample (mm).
    pub envelope_tolerance_mm: f64,
    /// Greatest overcut, static or of the swept envelope (mm).
    pub overcut_tolerance_mm: f64,
    /// Greatest undercut, static or of the swept envelope (mm).
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

/// A planned flank with its checks. Only [`flank()`](super::flank()) makes one, and its facts can be read but not
/// changed, so that no check can be taken away and no path be exchanged for another one.
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
    pub(super) facts: FlankFacts,
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

    /// Greatest overcut and undercut (mm) of the path that is milled as the cutter moves, on the grid of the plan or on
    /// that of the checks, whichever is worse.
    pub fn moving_most(&self) -> [f64; 2] {
        let both = [&self.path().envelope.deviation, &self.checked.envelope.deviation];
        let overcut = both.iter().fold(0.0, |most: f64, d| most.max(-d.most_overcut));
        [overcut, both.iter().fold(0.0, |most: f64, d| most.max(d.most_undercut))]
    }

    /// Decides anew which failing checks are let pass.
    pub fn decide(&mut self, overrides: &[Override]) {
        let part = [self.part.clone()];
        self.facts.checks.iter_mut().for_each(|check| check.decide(&part, overrides));
        self.facts.idle_overrides = idle(&part, &self.checks, overrides);
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

    /// Reason why nothing is exported: the checks that fail and are not overridden; none if there are none such.
    pub fn why_blocked(&self) -> Option<String> {
        let failed = self.checks.iter().filter(|c| !c.holds && !c.is_overridden);
        let lapsed = |c: &FlankCheck| c.lapsed.as_ref().map_or_else(String::new, |why| format!(" (override: {why})"));
        let failed: Vec<String> = failed.map(|c| format!("{}: {}{}", c.kind.name(), c.text, lapsed(c))).collect();
        (!failed.is_empty()).then(|| failed.join("; "))
    }

    /// Warnings on the path, and notes of the machine on it.
    pub fn all_warnings(&self) -> Vec<String> {
        self.warnings.iter().chain(&self.idle_overrides).cloned().chain(of_machine(self)).collect()
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

/// Overrides that override nothing, and why.
pub(super) fn idle(part: &[String], checks: &[FlankCheck], overrides: &[Override]) -> Vec<String> {
    let why = |one: &Override| match checks.iter().find(|c| !c.holds && c.kind.name() == one.check) {
        None => Some("no check of this name fails: the override has no effect".to_owned()),
        Some(check) => one.lapsed(part, &check.figures),
    };
    overrides.iter().filter_map(|one| Some(format!("override of {:?}: {}", one.check, why(one)?))).collect()
}

/// Notes of the machine on a path that it can follow.
pub(super) fn of_machine(result: &FlankResult) -> Vec<String> {
    let Some(milled) = result.milled() else { return Vec::new() };
    let mut warnings: Vec<String> = milled.line.singular.iter().map(ToString::to_string).collect();
    let Some(Slowed { by_axis, short, .. }) = milled.slowed else { return warnings };
    if let Some((moves, share, axis)) = by_axis {
        warnings.push(format!(
            "{moves} moves are slower than asked for, at most down to {:.1} % of the feed, so that axis {axis} does \
             not exceed its speed",
            100.0 * share
        ));
    }
    if let Some((moves, share)) = short {
        warnings.push(format!(
            "{moves} moves are given {} s, the shortest time of a block, which leaves them {:.1} % of their speed \
             at least",
            60.0 * LEAST_BLOCK_MINUTES,
            100.0 * share
        ));
    }
    warnings
}
