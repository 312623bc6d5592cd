//! Electrodes, from tips to burns.

use std::fmt;

use files::{Figures, Override};
use glam::{DVec2, DVec3};
use serde::{Deserialize, Serialize};

use super::base::Base;
use super::division::Cut;
use super::finding::{CheckKind, Finding};
use super::leftover::LeftOfRegion;
use super::params::{ElectrodeParams, GivenName, Method};
use geometry::mesh::{Bounds, Mesh};

/// Where a part of a region is: the region's place in the list, and the part's number, which is the same for the same
/// place in every stage.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct PartId {
    /// The region.
    pub region: usize,
    /// The part of it.
    pub part: usize,
}

/// Name in tables: `R3.2` is part 2 of region 3, both counted from 1.
impl fmt::Display for PartId {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "R{}.{}", self.region + 1, self.part + 1)
    }
}

/// Position at which an electrode burns.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Burn {
    /// Where the electrode's origin is, in the upright mold (mm).
    pub position: DVec3,
    /// How far the electrode is turned about the burn direction (radians).
    pub turn: f64,
    /// Parts that are burned.
    pub parts: Vec<PartId>,
    /// How deep below the mold's top its lowest point is (mm).
    pub depth: f64,
    /// Volume that is burned away (mm^3).
    pub volume: f64,
    /// Minutes that it takes: as long as its slowest tip, or as all of them at the generator's greatest rate.
    pub minutes: f64,
}

/// Whether an electrode shares its base with those of other stages.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Family {
    /// Own base; a shared one was not asked for.
    #[default]
    None,
    /// Shared base.
    Member {
        /// Name of the shared body.
        name: String,
        /// Where the middle of its own tips is, from the middle of the base, which is the datum, in the electrode's
        /// axes (mm).
        offset: DVec2,
    },
    /// Own base, although a shared one was asked for.
    Apart {
        /// Why, in words.
        why: String,
    },
}

impl Family {
    /// Name of the body that is shared with others, if there is one.
    pub fn name(&self) -> Option<&str> {
        if let Self::Member { name, .. } = self { Some(name) } else { None }
    }
}

/// An electrode: a base with one tip or several. Its origin is the middle of the base's underside, from where the tips
/// reach down along -Z.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Electrode {
    /// Name, which its files carry.
    pub name: String,
    /// Burn: the place in the list of stages.
    pub stage: usize,
    /// Surface, tips and base (mm).
    pub mesh: Mesh,
    /// The tips alone, up to the base.
    pub tips: Mesh,
    /// Where it burns; each of these alike.
    pub burns: Vec<Burn>,
    /// Where the electrode goes, in the upright mold.
    pub direction: DVec3,
    /// How its tips were made.
    pub method: Method,
    /// Sides of the blank, and its length along Z (mm).
    pub blank: DVec3,
    /// The holder: its place in the list, if one is large enough.
    pub holder: Option<usize>,
    /// Minutes that all its burns take.
    pub minutes: f64,
    /// Whether a tip is nowhere as thick as the least size.
    pub is_thin: bool,
    /// Area of the tips seen along the burn (mm^2).
    pub front_area: f64,
    /// Area of the tips that burns, walls and floors (mm^2).
    pub burn_area: f64,
    /// The base that the tips stand on.
    pub base: Base,
    /// Whether tips of other stages stand on it too.
    pub family: Family,
    /// Tips of the other stages that stand on the base.
    pub others: Mesh,
}

impl Electrode {
    /// Box around it.
    pub fn bounds(&self) -> Bounds {
        self.mesh.bounds()
    }

    /// The parts of regions that all its burns are for, in order.
    pub fn parts(&self) -> Vec<PartId> {
        let mut parts: Vec<PartId> = self.burns.iter().flat_map(|b| b.parts.iter().copied()).collect();
        parts.sort_unstable();
        parts.dedup();
        parts
    }
}

/// Area of an outline with the sign of its sense (mm^2).
fn area_of(outline: &[DVec2]) -> f64 {
    let next = outline.iter().cycle().skip(1);
    0.5 * outline.iter().zip(next).map(|(a, b)| a.perp_dot(*b)).sum::<f64>()
}

/// Why an override overrides nothing.
#[derive(Debug, Clone, PartialEq)]
pub enum IdleOverride {
    /// No electrode has its name.
    NoElectrode,
    /// The facts that the decision was made for have changed; in words.
    Lapsed(String),
    /// The check does not fail.
    Holds,
}

impl fmt::Display for IdleOverride {
    /// In words, after the override's name.
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(match self {
            Self::NoElectrode => "there is no electrode of that name",
            Self::Lapsed(why) => why,
            Self::Holds => "the check does not fail: the override has no effect",
        })
    }
}

/// A part of a region after division, as the tree shows it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PartNode {
    /// The cut that divides it; none for a leaf.
    pub cut: Option<Cut>,
    /// H-edges that it has.
    pub h_edges: usize,
    /// Outlines in plan, in the burn frame (mm).
    pub outlines: Vec<Vec<DVec2>>,
    /// Parts that it is divided into; one part only where nothing else of it is burned.
    pub parts: Vec<PartNode>,
    /// Whether something beyond the cut was left out as too thin.
    pub lacks_thin: bool,
    /// For a leaf its number among the region's parts.
    pub part: Option<usize>,
    /// For a leaf a point of it by which changes name it, in plan, in the burn frame (mm).
    pub place: Option<DVec2>,
}

impl PartNode {
    /// The leaf with this number among the region's parts.
    fn leaf(&self, part: usize) -> Option<&Self> {
        if self.part == Some(part) { Some(self) } else { self.parts.iter().find_map(|inner| inner.leaf(part)) }
    }
}

/// Part of a region that a stage has no tip for, and leaves to the stages after it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct LeftOut {
    /// The stage: its place in the list.
    pub stage: usize,
    /// The part and the reason, in words.
    pub text: String,
}

/// How a region is burned.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RegionPlan {
    /// Division by the last stage that has one.
    pub tree: Option<PartNode>,
    /// Divisions by the stages before that one: their places in the list, the later one first.
    pub earlier: Vec<(usize, PartNode)>,
    /// How its tips are made.
    pub method: Method,
    /// Where its electrodes go, in the upright mold.
    pub direction: DVec3,
    /// The user's changes that met it: their places in the list.
    pub edits: Vec<usize>,
    /// Reason why the region has no electrode, or lacks one for a part.
    #[serde(rename = "trouble")]
    pub reason: Option<String>,
    /// Parts that stages leave to those after them.
    pub left_out: Vec<LeftOut>,
    /// Residual stock of the region after all burns and cutters.
    pub left: LeftOfRegion,
}

/// All electrodes for a mold, with what was checked.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct ElectrodeSet {
    /// Parameters of the electrodes.
    pub params: ElectrodeParams,
    /// The electrodes; those for the first stage first.
    pub electrodes: Vec<Electrode>,
    /// Findings of the checks, for each electrode.
    pub checks: Vec<Vec<Finding>>,
    /// How each region is burned, in the order of the regions.
    pub regions: Vec<RegionPlan>,
    /// The names that were ever given, with what they were given for.
    pub names: Vec<GivenName>,
}

impl ElectrodeSet {
    /// Whether a check of an electrode fails.
    pub fn fails(&self, electrode: usize) -> bool {
        self.checks[electrode].iter().any(|finding| !finding.holds)
    }

    /// Whether an electrode may not be exported: a check fails and the user did not override it.
    pub fn is_blocked(&self, electrode: usize) -> bool {
        self.is_blocked_with(electrode, &self.params.overrides)
    }

    /// Whether an electrode may not be exported with these overrides. Electrodes that share a body with it count too,
    /// because the body is one piece.
    pub fn is_blocked_with(&self, electrode: usize, overrides: &[Override]) -> bool {
        let is_blocked = |e: &usize| {
            let mut failing = self.checks[*e].iter().filter(|f| !f.holds);
            failing.any(|f| !self.is_overridden(*e, f.kind, overrides))
        };
        self.body_of(electrode).iter().any(is_blocked)
    }

    /// The electrodes that are one body with this one, itself among them.
    pub fn body_of(&self, electrode: usize) -> Vec<usize> {
        match self.electrodes[electrode].family.name() {
            None => vec![electrode],
            name => (0..self.electrodes.len()).filter(|e| self.electrodes[*e].family.name() == name).collect(),
        }
    }

    /// The parts of regions that an electrode burns, each with its area in plan: a part that is merged with another has
    /// a larger one, whatever it is called.
    pub fn parts_of(&self, electrode: usize) -> Vec<String> {
        let electrode = &self.electrodes[electrode];
        let area = |id: &PartId| {
            let region = self.regions.get(id.region)?;
            let divisions = region.earlier.iter().filter(|(stage, _)| *stage == electrode.stage).map(|(_, tree)| tree);
            let leaf = divisions.chain(&region.tree).find_map(|tree| tree.leaf(id.part))?;
            Some(leaf.outlines.iter().map(|outline| area_of(outline)).sum::<f64>().abs())
        };
        electrode.parts().iter().map(|id| format!("{id} {:.2} mm2", area(id).unwrap_or_default())).collect()
    }

    /// How bad what a check of an electrode found is.
    fn figures_of(&self, electrode: usize, check: &str) -> Figures {
        let mut figures = Figures::new();
        for finding in self.checks[electrode].iter().filter(|f| !f.holds && f.kind.name() == check) {
            for (name, figure) in &finding.figures {
                let worst = figures.entry(name.clone()).or_insert(*figure);
                *worst = worst.max(*figure);
            }
        }
        figures
    }

    /// The decision to export an electrode although a check fails, for what it burns and as bad as it is now.
    pub fn override_of(&self, electrode: usize, check: CheckKind) -> Override {
        let figures = self.figures_of(electrode, check.name());
        let of = self.electrodes[electrode].name.clone();
        Override { of, ..Override::decided(check.name(), self.parts_of(electrode), &figures) }
    }

    /// Why an override of an electrode no longer holds; none while it does.
    fn lapsed(&self, electrode: usize, one: &Override) -> Option<String> {
        one.lapsed(&self.parts_of(electrode), &self.figures_of(electrode, &one.check))
    }

    /// Whether one of `overrides` is for this check of an electrode.
    pub fn is_overridden(&self, electrode: usize, check: CheckKind, overrides: &[Override]) -> bool {
        let name = &self.electrodes[electrode].name;
        let mut of_it = overrides.iter().filter(|o| o.of == *name && o.check == check.name());
        of_it.any(|o| self.lapsed(electrode, o).is_none())
    }

    /// The overrides of `overrides` that override nothing, with the reason.
    pub fn idle_overrides<'a>(&self, overrides: &'a [Override]) -> Vec<(&'a Override, IdleOverride)> {
        let why = |o: &Override| -> Option<IdleOverride> {
            let Some(e) = self.electrodes.iter().position(|e| e.name == o.of) else {
                return Some(IdleOverride::NoElectrode);
            };
            if !self.checks[e].iter().any(|f| !f.holds && f.kind.name() == o.check) {
                return Some(IdleOverride::Holds);
            }
            self.lapsed(e, o).map(IdleOverride::Lapsed)
        };
        overrides.iter().filter_map(|o| Some((o, why(o)?))).collect()
    }

    /// Regions that have no electrode for all of them.
    pub fn without_electrode(&self) -> Vec<usize> {
        (0..self.regions.len()).filter(|r| self.regions[*r].reason.is_some()).collect()
    }

    /// The user's changes that met no region, or changed nothing: their places in the list.
    pub fn unmet_edits(&self) -> Vec<usize> {
        let is_met = |edit: &usize| self.regions.iter().any(|region| region.edits.contains(edit));
        (0..self.params.edits.len()).filter(|edit| !is_met(edit)).collect()
    }

    /// Whether every region has its electrodes and every check holds.
    pub fn holds(&self) -> bool {
        self.without_electrode().is_empty() && (0..self.electrodes.len()).all(|e| !self.fails(e))
    }

    /// Minutes that all burns take.
    pub fn minutes(&self) -> f64 {
        // The sum of none is a zero with a sign.
        self.electrodes.iter().map(|e| e.minutes).sum::<f64>() + 0.0
    }
}
