//! Electrodes, from tips to burns.

use std::collections::BTreeSet;
use std::fmt;

use burning::choice::Piece;
use burning::duration::{Spread, sum_of};
use burning::figures::{BurnFigures, minutes_text};
use files::report::counted;
use files::{Figures, Override};
use glam::{DAffine3, DVec2, DVec3};
use serde::{Deserialize, Serialize};

use super::base::Base;
use super::burn_direction::BurnProposal;
use super::check::watertight;
use super::cut::Cut;
use super::finding::{CheckKind, Finding};
use super::given::{Given, GivenName};
use super::h_edge::EdgeChain;
use super::params::{ElectrodeParams, Method};
use super::residual_stock::LeftOfRegion;
use geometry::mesh::{Bounds, Mesh};
use geometry::solid::SolidError;

/// Margin of a base that the user's own blank needs at most (mm).
const MOST_MARGIN: f64 = 0.5;
/// Rounding of a length (mm).
const HAIR: f64 = 1e-6;

/// Identifier of a part of a region: the index of the region in the list, and the number of the part, which is the same
/// for the same place in every stage.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct PartId {
    /// Index of the region.
    pub region: usize,
    /// Number of the part.
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
    /// Position of the electrode's origin, in the upright mold (mm).
    pub position: DVec3,
    /// Turn of the electrode about the burn direction (radians).
    pub turn: f64,
    /// Parts that are burned.
    pub parts: Vec<PartId>,
    /// Depth of its lowest point below the mold's top (mm).
    pub depth: f64,
    /// Volume that is burned away (mm^3).
    pub volume: f64,
    /// Volume and area seen along the burn of each of the parts; none if that of one is not known.
    pub heads: Option<Vec<Piece>>,
    /// Burning, without set-up and changing (minutes); none if it is not known.
    pub minutes: Option<Spread>,
}

impl Burn {
    /// Distance above the mold's top that its lowest point is retracted to (mm).
    pub const CLEAR_MM: f64 = 2.0;

    /// Retract distance (mm): what brings it clear of the mold, and no less than `least`.
    pub fn retract(&self, least: f64) -> f64 {
        least.max(self.depth + Self::CLEAR_MM)
    }
}

/// Membership of an electrode in a base shared by several stages.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Family {
    /// Own base, because a shared one was not asked for.
    #[default]
    None,
    /// Shared base.
    Member {
        /// Name of the shared body.
        name: String,
        /// Middle of its own tips, from the middle of the base, which is the datum, in the electrode's axes (mm).
        offset: DVec2,
    },
    /// Own base, although a shared one was asked for.
    Apart {
        /// Reason in words.
        why: String,
    },
}

impl Family {
    /// Name of the shared body, if there is one.
    pub fn name(&self) -> Option<&str> {
        if let Self::Member { name, .. } = self { Some(name) } else { None }
    }
}

/// An electrode: a base with one tip or several. Its origin is the middle of the base's underside; tips reach down
/// along -Z.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Electrode {
    /// Name, also of its files.
    pub name: String,
    /// Number, which it keeps; 0 until it has one.
    pub number: usize,
    /// Stage: its index in the list.
    pub stage: usize,
    /// Surface, tips and base (mm).
    pub mesh: Mesh,
    /// The tips alone, up to the base.
    pub tips: Mesh,
    /// Burns, all with the same electrode.
    pub burns: Vec<Burn>,
    /// Burn direction, in the upright mold.
    pub direction: DVec3,
    /// Method of making its tips.
    pub method: Method,
    /// Sides of the blank, and its length along Z (mm).
    pub blank: DVec3,
    /// Holder: its index in the list, if one is large enough.
    pub holder: Option<usize>,
    /// Minutes and wear of all its burns together.
    pub figures: BurnFigures,
    /// Number of electrodes that its burns need, as far as the wear is known; none if there would be too many.
    pub needed: Option<usize>,
    /// Whether a tip is thinner than the least size everywhere.
    pub is_thin: bool,
    /// Area of the tips seen along the burn (mm^2).
    pub front_area: f64,
    /// Eroding area of the tips, walls and floors (mm^2).
    pub burn_area: f64,
    /// The base that the tips stand on.
    pub base: Base,
    /// Tips of other stages on the same base.
    pub family: Family,
    /// Tips of the other stages that stand on the base.
    pub others: Mesh,
    /// Material, where it is not that of all.
    pub material: Option<String>,
    /// Wishes of the user for this electrode that could not be met, in words.
    pub unmet: Vec<String>,
    /// The other way to burn places of its shape, if there is one.
    pub other_way: Option<OtherWay>,
}

/// The other way to burn places of one shape: by one head in several burns, or by several heads at once.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct OtherWay {
    /// The places that are burned at once, as numbers of the electrode's burns, or of its heads if it has several.
    pub at_once: Vec<Vec<usize>>,
    /// Sides of the largest blank, and its length along Z (mm).
    pub blank: DVec3,
    /// Burning of all burns (minutes); none if it is not known.
    pub minutes: Option<Spread>,
}

impl OtherWay {
    /// Greatest number of electrodes: heads that stand alike in several places can share one.
    pub fn electrodes(&self) -> usize {
        // Places by themselves share one.
        let several = self.at_once.iter().filter(|places| places.len() > 1).count();
        several + usize::from(several < self.at_once.len())
    }

    /// The figures of this way in words, beside the burning of the present way (minutes).
    pub fn sentence(&self, now: Option<Spread>) -> String {
        let DVec3 { x, y, z } = self.blank;
        let way = if self.is_of_burns() {
            format!("one head that burns {} places one after another", self.at_once.len())
        } else {
            let most = self.at_once.iter().map(Vec::len).max().unwrap_or(0);
            let electrodes = self.electrodes();
            let most_of_them = if electrodes > 1 { "at most " } else { "" };
            format!("{most_of_them}{} with up to {most} heads at once", counted(electrodes, "electrode"))
        };
        let [minutes, now] = [self.minutes, now].map(minutes_text);
        format!("Other way: {way}, burning {minutes} (now {now}), blank {x} x {y} x {z} mm")
    }

    /// Whether it is one head that burns one place after another.
    pub fn is_of_burns(&self) -> bool {
        self.at_once.iter().all(|places| places.len() == 1)
    }
}

impl Electrode {
    /// Material: that of all electrodes unless this one was given another.
    pub fn material<'a>(&'a self, params: &'a ElectrodeParams) -> &'a str {
        self.material.as_deref().unwrap_or(&params.material)
    }

    /// Takes what the user gave it.
    ///
    /// # Errors
    /// [`SolidError`].
    pub(super) fn as_given(&mut self, given: &Given, params: &ElectrodeParams) -> Result<(), SolidError> {
        self.material.clone_from(&given.material);
        if let Some([x, y]) = given.blank_mm {
            let needed = self.tips.bounds().size().truncate() + 2.0 * params.base_margin_mm.min(MOST_MARGIN);
            if self.family.name().is_some() {
                self.unmet.push("its blank is shared with other stages, so that no other can be given".to_owned());
            } else if DVec2::new(x, y).cmplt(needed - HAIR).any() {
                let DVec2 { x: a, y: b } = needed;
                self.unmet.push(format!(
                    "the blank of {x} x {y} mm is too small: its heads need {a:.2} x {b:.2} mm; give a larger one"
                ));
            } else {
                // The chamfer stays beside the heads.
                let beside = (0.5 * (DVec2::new(x, y) - self.tips.bounds().size().truncate())).min_element();
                let corner = self.base.corner.min(0.9 * beside);
                let base = Base { sides: DVec2::new(x, y), is_round: false, corner, ..self.base };
                match base.with_tips(std::slice::from_ref(&self.tips)) {
                    Ok(mesh) if watertight(&mesh).holds => {
                        (self.base, self.mesh) = (base, mesh);
                        self.blank = self.base.sides.extend(self.blank.z);
                        self.holder = self.base.holder(params);
                    }
                    Err(SolidError::Cancelled(cancelled)) => return Err(SolidError::Cancelled(cancelled)),
                    _ => self
                        .unmet
                        .push(format!("its heads and a blank of {x} x {y} mm make no closed body: give another size")),
                }
            }
        }
        if let Some(name) = &given.holder {
            let found = params.holders.iter().position(|holder| holder.name == *name);
            match found.filter(|h| self.base.fits(&params.holders[*h])) {
                Some(holder) => self.holder = Some(holder),
                None if found.is_some() => {
                    self.unmet.push(format!("its blank is too large for the holder {name}: choose another one"));
                }
                None => self.unmet.push(format!("the holder {name} is not in the list of holders: choose another one")),
            }
        }
        Ok(())
    }

    /// Bounding box.
    pub fn bounds(&self) -> Bounds {
        self.mesh.bounds()
    }

    /// Parts of regions that its burns are for, in order.
    pub fn parts(&self) -> Vec<PartId> {
        let mut parts: Vec<PartId> = self.burns.iter().flat_map(|b| b.parts.iter().copied()).collect();
        parts.sort_unstable();
        parts.dedup();
        parts
    }
}

/// Signed area of an outline (mm^2).
fn area_of(outline: &[DVec2]) -> f64 {
    let next = outline.iter().cycle().skip(1);
    0.5 * outline.iter().zip(next).map(|(a, b)| a.perp_dot(*b)).sum::<f64>()
}

/// Reason why an override has no effect.
#[derive(Debug, Clone, PartialEq)]
pub enum IdleOverride {
    /// No electrode has its name.
    NoElectrode,
    /// The findings have changed since the decision; in words.
    Lapsed(String),
    /// The check does not fail.
    Holds,
}

impl fmt::Display for IdleOverride {
    /// The reason in words, to follow the override's name.
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
    /// Cut that divides the part; none for a leaf.
    pub cut: Option<Cut>,
    /// H-edges, as chains in the burn frame.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub h_edges: Vec<EdgeChain>,
    /// Outlines in plan, in the burn frame (mm).
    pub outlines: Vec<Vec<DVec2>>,
    /// Heights in the burn frame at which the head begins and ends (mm).
    pub heights: [f64; 2],
    /// Parts of the part; a single one where nothing else of it is burned.
    pub parts: Vec<PartNode>,
    /// Whether a part beyond the cut was left out as too thin.
    pub lacks_thin: bool,
    /// Number of a leaf among the region's parts.
    pub part: Option<usize>,
    /// Point of a leaf by which changes name it, in plan, in the burn frame (mm).
    pub place: Option<DVec2>,
}

impl PartNode {
    /// Number of H-edges.
    pub fn h_edge_count(&self) -> usize {
        self.h_edges.iter().map(EdgeChain::edges).sum()
    }

    /// The part and all that it is divided into, each before its own parts.
    pub fn nodes(&self) -> Vec<&Self> {
        [self].into_iter().chain(self.parts.iter().flat_map(Self::nodes)).collect()
    }

    /// The leaf with this number among the region's parts.
    fn leaf(&self, part: usize) -> Option<&Self> {
        if self.part == Some(part) { Some(self) } else { self.parts.iter().find_map(|inner| inner.leaf(part)) }
    }
}

/// A part of a region that a stage has no tip for and leaves to later stages.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct LeftOut {
    /// Stage: its index in the list.
    pub stage: usize,
    /// The part and the reason, in words.
    pub text: String,
}

/// Plan of the burns of a region.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RegionPlan {
    /// Division by the last stage that has one.
    pub tree: Option<PartNode>,
    /// Divisions by earlier stages: their index in the list, the later stage first.
    pub earlier: Vec<(usize, PartNode)>,
    /// Method of making its tips.
    pub method: Method,
    /// Burn direction of its electrodes, in the upright mold.
    pub direction: DVec3,
    /// Whether the user has set the region aside: no electrode is made for it.
    pub is_set_aside: bool,
    /// User's changes that apply to the region: their indices in the list.
    pub edits: Vec<usize>,
    /// Reason why the region has no electrode, or lacks one for a part.
    #[serde(rename = "trouble")]
    pub reason: Option<String>,
    /// Place that the reason speaks of, in the upright mold (mm); none if it speaks of none.
    pub reason_place: Option<DVec3>,
    /// Parts that stages leave to later ones.
    pub left_out: Vec<LeftOut>,
    /// Residual stock of the region after all burns and cutters.
    pub left: LeftOfRegion,
    /// Another burn direction, where the mold hangs over residual stock and more of the region is seen from that
    /// direction.
    pub proposal: Option<BurnProposal>,
}

impl RegionPlan {
    /// The reason with its place, which `axes` take from the upright mold to those of a datum.
    pub fn reason_at(&self, axes: &DAffine3) -> Option<String> {
        // No zero with a sign.
        let place = self.reason_place.map(|place| (axes.transform_point3(place) * 1e3).round() / 1e3 + 0.0);
        let at = place.map_or_else(String::new, |p| format!(", at ({:.3}, {:.3}, {:.3})", p.x, p.y, p.z));
        self.reason.as_ref().map(|reason| format!("{reason}{at}"))
    }
}

/// All electrodes for a mold, with the findings of their checks.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct ElectrodeSet {
    /// Parameters of the electrodes.
    pub params: ElectrodeParams,
    /// The electrodes; those for the first stage first.
    pub electrodes: Vec<Electrode>,
    /// Findings of the checks, for each electrode.
    pub checks: Vec<Vec<Finding>>,
    /// Plan of each region, in the order of the regions.
    pub regions: Vec<RegionPlan>,
    /// All names ever given, with the places burned then.
    pub names: Vec<GivenName>,
}

impl ElectrodeSet {
    /// Whether a check of an electrode fails.
    pub fn fails(&self, electrode: usize) -> bool {
        self.checks[electrode].iter().any(|finding| !finding.holds)
    }

    /// Whether an electrode is not exported, because a check fails without an override.
    pub fn is_blocked(&self, electrode: usize) -> bool {
        self.is_blocked_with(electrode, &self.params.overrides)
    }

    /// Whether an electrode is not exported with these overrides. Electrodes on the same body count too, because the
    /// body is one piece.
    pub fn is_blocked_with(&self, electrode: usize, overrides: &[Override]) -> bool {
        let is_blocked = |e: &usize| {
            let mut failing = self.checks[*e].iter().filter(|f| !f.holds);
            failing.any(|f| !self.is_overridden(*e, f.kind, overrides))
        };
        self.body_of(electrode).iter().any(is_blocked)
    }

    /// Indices of the electrodes on the same body, including this one.
    pub fn body_of(&self, electrode: usize) -> Vec<usize> {
        match self.electrodes[electrode].family.name() {
            None => vec![electrode],
            name => (0..self.electrodes.len()).filter(|e| self.electrodes[*e].family.name() == name).collect(),
        }
    }

    /// The parts of regions that an electrode burns, each with its area in plan: a part that is merged with another has
    /// a larger area, whatever its name.
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

    /// Figures of a check of an electrode.
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

    /// An override for a failed check of an electrode, for its present parts and figures.
    pub fn override_of(&self, electrode: usize, check: CheckKind) -> Override {
        let figures = self.figures_of(electrode, check.name());
        let of = self.electrodes[electrode].name.clone();
        Override { of, ..Override::decided(check.name(), self.parts_of(electrode), &figures) }
    }

    /// Reason why an override of an electrode no longer holds; none while it does.
    fn lapsed(&self, electrode: usize, one: &Override) -> Option<String> {
        one.lapsed(&self.parts_of(electrode), &self.figures_of(electrode, &one.check))
    }

    /// Whether `overrides` has one for this check of an electrode.
    pub fn is_overridden(&self, electrode: usize, check: CheckKind, overrides: &[Override]) -> bool {
        let name = &self.electrodes[electrode].name;
        let mut of_it = overrides.iter().filter(|o| o.of == *name && o.check == check.name());
        of_it.any(|o| self.lapsed(electrode, o).is_none())
    }

    /// The overrides without effect, with the reason.
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

    /// Indices of regions without an electrode for every part.
    pub fn without_electrode(&self) -> Vec<usize> {
        (0..self.regions.len()).filter(|r| self.regions[*r].reason.is_some()).collect()
    }

    /// Indices of regions that no electrode burns, as there is nothing to burn.
    pub fn needing_none(&self) -> Vec<usize> {
        let burned: BTreeSet<usize> =
            self.electrodes.iter().flat_map(|e| &e.burns).flat_map(|b| &b.parts).map(|part| part.region).collect();
        let is_needless = |plan: &RegionPlan| plan.reason.is_none() && !plan.is_set_aside;
        (0..self.regions.len()).filter(|r| is_needless(&self.regions[*r]) && !burned.contains(r)).collect()
    }

    /// Indices of regions that the user has set aside.
    pub fn set_aside(&self) -> Vec<usize> {
        (0..self.regions.len()).filter(|r| self.regions[*r].is_set_aside).collect()
    }

    /// Reason why no electrode burns a region, or a part of it, with its place, which `axes` take from the upright mold to
    /// those of a datum; none where all is burned.
    pub fn why_not_burned(&self, region: usize, axes: &DAffine3) -> Option<String> {
        let plan = &self.regions[region];
        if plan.is_set_aside {
            return Some("set aside".to_owned());
        }
        let left_out = || plan.left_out.last().map_or("there is nothing to burn", |left| &left.text).to_owned();
        plan.reason_at(axes).or_else(|| self.needing_none().contains(&region).then(left_out))
    }

    /// User's changes that apply to no region, or change nothing: their indices in the list.
    pub fn unmet_edits(&self) -> Vec<usize> {
        let is_met = |edit: &usize| self.regions.iter().any(|region| region.edits.contains(edit));
        (0..self.params.edits.len()).filter(|edit| !is_met(edit)).collect()
    }

    /// Whether every region has its electrodes and every check holds.
    pub fn holds(&self) -> bool {
        self.without_electrode().is_empty() && (0..self.electrodes.len()).all(|e| !self.fails(e))
    }

    /// Retract distance that serves all burns (mm).
    pub fn retract(&self) -> f64 {
        let burns = self.electrodes.iter().flat_map(|e| &e.burns);
        burns.map(|burn| burn.retract(self.params.lift_mm)).fold(self.params.lift_mm, f64::max)
    }

    /// All burns with set-up and changing (minutes); none if one of them is not known.
    pub fn minutes(&self) -> Option<Spread> {
        let burns = self.electrodes.iter().flat_map(|e| &e.burns).map(|burn| burn.minutes);
        sum_of(burns, self.params.technology.overhead).ok().flatten()
    }
}
