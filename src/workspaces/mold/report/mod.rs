//! The report on a mold's electrodes, as `electrodes.json` for programs and `report.html` for people.

pub mod corpus;
mod page;
pub mod segments;
pub mod steps;
pub mod uncut;

use glam::{DAffine3, DVec2, DVec3};
use serde::Serialize;

use crate::workspaces::mold::document::MoldParams;
use crate::workspaces::mold::document::fields::FIELDS;
use crate::workspaces::mold::job::divisions::WayResult;
use files::report::{PageError, counted};
use files::{Override, ParameterList};
use mold::datum::Datum;
use mold::electrode::design::IdleOverride;
use mold::electrode::design::{Electrode, ElectrodeSet, PartNode, RegionPlan};
use mold::electrode::h_edge::EdgeChain;
use mold::electrode::params::{Edit, ElectrodeParams};
use mold::electrode::setting::to_burn_frame;
use mold::opening::Opening;
use nc::burn_table::{BurnTable, ElectrodeState, method_name};
use nc::electrode_files::why_blocked;
pub use page::ElectrodesPage;
use uncut::{CadFaceReport, UncutReport};

/// Version of the keys of `electrodes.json`.
pub const SCHEMA: u32 = 4;

/// All that a report says of electrodes. Places are in the axes of the work datum; regions and parts count from 1.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ElectrodesReport {
    /// [`SCHEMA`].
    pub schema: u32,
    /// The answer in a sentence.
    pub sentence: String,
    /// Whether every region has its electrodes and every check holds.
    pub holds: bool,
    /// Whether it is known what is left of the mold.
    pub is_certain: bool,
    /// The burn table.
    pub table: BurnTable,
    /// Electrodes that are not exported, and why.
    pub blocked: Vec<BlockedEntry>,
    /// Names of electrodes that are exported although a check fails.
    pub overridden: Vec<String>,
    /// Overrides that override nothing.
    pub idle_overrides: Vec<IdleEntry>,
    /// The user's changes that met no region, or changed nothing.
    pub unmet_edits: Vec<String>,
    /// For electrodes whose places can be burned in another way, that way with its figures.
    pub other_ways: Vec<String>,
    /// What volumes and minutes of stages are counted by.
    pub model: &'static str,
    /// Every region.
    pub regions: Vec<RegionEntry>,
    /// Comparison with other ways of dividing, if it was asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub divisions: Option<Vec<WayResult>>,
    /// Every parameter, defaults included.
    pub parameters: ParameterList,
}

/// An electrode that is not exported.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct BlockedEntry {
    /// The electrode.
    pub electrode: String,
    /// Checks that fail, and the remedy.
    pub why: String,
}

/// An override that overrides nothing.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct IdleEntry {
    /// Name of the override as it is given: `NAME:CHECK`.
    pub name: String,
    /// Reason why the override has no effect.
    pub why: String,
}

/// What is counted where there are several stages.
const MODEL: &str = "A stage leaves a layer for the next one on the whole surface of a region: as thick as the next \
    one's electrode is larger (the difference of their undersizes), and no less than its stock. It takes what the \
    stages \
    before it left, down to that layer; the last one takes all the rest, so that the stages together take what the \
    cutters \
    left. Minutes are those volumes by the rates of the technology's steps. Heads on one base go down together: the one \
    with the most stock for its area begins, and the areas of all that have begun add up.";

/// A region and how it is burned.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct RegionEntry {
    /// Number of the region, counted from 1.
    pub index: usize,
    /// How its tips are made.
    pub method: &'static str,
    /// Unit vector along which its electrodes go.
    pub direction: [f64; 3],
    /// Parts that it is divided into.
    pub parts: usize,
    /// Division of the region; none where there is no footprint.
    pub division: Option<Division>,
    /// Divisions by earlier stages that have parts which it does not.
    pub earlier_divisions: Vec<EarlierDivision>,
    /// Electrodes that burn it or parts of it.
    pub electrodes: Vec<String>,
    /// The faces of the CAD program that bound it; none where the file has none.
    pub cad_faces: Vec<CadFaceReport>,
    /// Greatest thickness that all burns leave, across the surface (mm).
    pub left_thickness_mm: f64,
    /// Where (mm).
    pub left_at_mm: [f64; 3],
    /// Volume that they leave (mm^3).
    pub left_volume_mm3: f64,
    /// Reason why the region has no electrode, or lacks one for a part.
    pub trouble: Option<String>,
    /// What stages leave to those after them, in words.
    pub left_out: Vec<String>,
}

/// How an earlier stage divides a region.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct EarlierDivision {
    /// The stage, by name.
    pub stage: String,
    /// Division of the region by the stage.
    pub division: Division,
}

/// A part of a region and what it is divided into.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Division {
    /// Description of the part in a few words.
    pub text: String,
    /// Edges in it that no cutter makes.
    pub h_edges: usize,
    /// Parts that the part is divided into.
    pub parts: Vec<Division>,
}

impl ElectrodesReport {
    /// The report on electrodes of a mold that is called `mold`, with positions from `datum`. `is_certain` tells whether it
    /// is known what is left of the mold.
    pub fn of(set: &ElectrodeSet, mold: &str, opening: Opening, datum: &Datum, is_certain: bool) -> Self {
        let table = BurnTable::of(set, mold, opening, datum);
        let axes = datum.of_upright(opening);
        let blocked =
            |e: usize| why_blocked(set, e).map(|why| BlockedEntry { electrode: set.electrodes[e].name.clone(), why });
        let is = |state: ElectrodeState| table.electrodes.iter().filter(move |e| e.state == state);
        let overridden: Vec<String> = is(ElectrodeState::Overridden).map(|e| e.name.clone()).collect();
        let idle = |(o, why): (&Override, IdleOverride)| IdleEntry { name: o.to_string(), why: why.to_string() };
        // Names that were given once are remembered, and are no parameter but for what the user gave.
        let names = set.params.names.iter().filter(|name| !name.given.is_nothing()).cloned().collect();
        let own = ElectrodeParams { names, ..set.params.clone() };
        let other_way =
            |e: &Electrode| Some(format!("{}: {}.", e.name, e.other_way.as_ref()?.sentence(e.figures.minutes)));
        Self {
            schema: SCHEMA,
            sentence: sentence(set, &table, &set.params.overrides, is_certain),
            is_certain,
            holds: set.holds(),
            blocked: (0..set.electrodes.len()).filter_map(blocked).collect(),
            idle_overrides: set.idle_overrides(&set.params.overrides).into_iter().map(idle).collect(),
            unmet_edits: set.unmet_edits().into_iter().map(|e| set.params.edits[e].to_string()).collect(),
            model: MODEL,
            other_ways: set.electrodes.iter().filter_map(other_way).collect(),
            regions: set.regions.iter().enumerate().map(|(r, plan)| region(set, r, plan, &axes)).collect(),
            divisions: None,
            parameters: FIELDS.list(&MoldParams { electrodes: own, ..MoldParams::default() }).of_table("electrodes"),
            overridden,
            table,
        }
    }

    /// The report with the CAD faces of the regions of `uncut`, which are the report's own.
    pub fn with_cad_faces(mut self, uncut: &UncutReport) -> Self {
        for (entry, region) in self.regions.iter_mut().zip(&uncut.regions) {
            entry.cad_faces.clone_from(&region.cad_faces);
        }
        self
    }

    /// The answer in a sentence if these are the user's overrides of the `set` that the report is on.
    pub fn sentence_with(&self, set: &ElectrodeSet, overrides: &[Override]) -> String {
        sentence(set, &self.table, overrides, self.is_certain)
    }

    /// The report as JSON; a number that is not finite becomes null.
    ///
    /// # Errors
    /// None that is known; the writer's own.
    pub fn json(&self) -> Result<String, serde_json::Error> {
        Ok(serde_json::to_string_pretty(self)? + "\n")
    }

    /// The report as one self-contained page.
    ///
    /// # Errors
    /// [`PageError`], which a test of the template keeps from happening.
    pub fn html(&self, shown: &ElectrodesPage) -> Result<String, PageError> {
        page::page(self, shown)
    }
}

fn sentence(set: &ElectrodeSet, table: &BurnTable, overrides: &[Override], is_certain: bool) -> String {
    let regions = set.regions.len();
    if regions == 0 {
        return "No region was found that the cutters leave: no electrode is made.".to_owned();
    }
    let known = |minutes: f64| counted(minutes.max(0.0).round() as usize, "minute");
    let minutes = table.minutes.map_or_else(|| "minutes not known".to_owned(), known);
    let mut text = format!(
        "{} with {} for {}: {}.",
        counted(table.electrodes.len(), "electrode"),
        counted(table.burns, "burn"),
        counted(regions, "region"),
        minutes
    );
    let list = |names: Vec<&str>| names.join(", ");
    let named = |state: ElectrodeState| -> Vec<&str> {
        let all = table.electrodes.iter().enumerate();
        all.filter(|(e, _)| ElectrodeState::of(set, *e, overrides) == state).map(|(_, e)| e.name.as_str()).collect()
    };
    let blocked = named(ElectrodeState::Blocked);
    if !blocked.is_empty() {
        text += &format!(" Blocked by a failed check: {}.", list(blocked));
    }
    let overridden = named(ElectrodeState::Overridden);
    if !overridden.is_empty() {
        text += &format!(" Released despite a failed check: {}.", list(overridden));
    }
    let warned: Vec<&str> = table.electrodes.iter().filter(|e| e.holder.is_none()).map(|e| e.name.as_str()).collect();
    if !warned.is_empty() {
        text += &format!(" No holder is large enough: {}.", list(warned));
    }
    let without: Vec<String> = set.without_electrode().iter().map(|r| (r + 1).to_string()).collect();
    if !without.is_empty() {
        let what = if without.len() == 1 { "Region" } else { "Regions" };
        text += &format!(" {what} not burned, or not wholly: {}.", without.join(", "));
    }
    let aside: Vec<String> = set.set_aside().iter().map(|r| (r + 1).to_string()).collect();
    if !aside.is_empty() {
        let what = if aside.len() == 1 { "Region" } else { "Regions" };
        text += &format!(" {what} set aside: {}.", aside.join(", "));
    }
    let none: Vec<String> = set.needing_none().iter().map(|r| (r + 1).to_string()).collect();
    if !none.is_empty() {
        let what = if none.len() == 1 { "Region" } else { "Regions" };
        text += &format!(" {what} left out, as within the tolerance there is nothing to burn: {}.", none.join(", "));
    }
    let warnings = table.electrodes.iter().map(|e| e.warnings.len()).sum();
    if warnings > 0 {
        text += &format!(" {} of electrodes.", counted(warnings, "warning"));
    }
    for edit in set.unmet_edits() {
        text += &format!(" Change {} has no effect: {}.", edit + 1, why_unmet(&set.params.edits[edit]));
    }
    if set.holds() && !set.electrodes.is_empty() {
        text += if is_certain {
            " Every check holds."
        } else {
            " Every check of these electrodes holds; what is left of the mold is not certain: see the warnings."
        };
    }
    text
}

/// A change to the division that does nothing, its place, and the remedy, in words.
pub fn why_unmet(edit: &Edit) -> String {
    let remedy = match edit {
        Edit::Split { .. } => {
            "the middle of the line lies in no part of a region, or all of the part lies on one side of it: remove the \
             change and draw a line across the part, with its middle inside"
        }
        Edit::SplitAlong { .. } => {
            "no steep face of the mold is at the place, or no part of a region is beside it, or all of the part lies on \
             one side of the face: remove the change and click on a steep face where the head goes on beyond it"
        }
        Edit::Merge { .. } => "the places lie in one part, or not in two parts of one region: remove the change",
        Edit::Join { .. } => "there are no two heads of one burn direction at its places: remove the change",
        Edit::TakeApart { .. } => "there is no head at this place: remove the change, or give a place under a head",
        Edit::Copy { .. } => {
            "there is no head at one of its places, or the head at the first one does not burn the second place: the \
             places differ in shape, or it comes too near to the mold there; remove the change"
        }
        Edit::Make { .. } | Edit::Burn { .. } | Edit::SetAside { .. } => {
            "no region has its surface within 0.5 mm of this place: give a point on a wall or floor of the region, or \
             remove the change"
        }
    };
    format!("{edit}: {remedy}")
}

fn region(set: &ElectrodeSet, r: usize, plan: &RegionPlan, axes: &DAffine3) -> RegionEntry {
    let burns = |e: &&Electrode| e.burns.iter().flat_map(|b| &b.parts).any(|part| part.region == r);
    RegionEntry {
        index: r + 1,
        method: method_name(plan.method),
        direction: axes.transform_vector3(plan.direction).to_array().map(|v| rounded(v, 1e12)),
        parts: plan.tree.as_ref().map_or(0, leaves),
        division: division_of(set, r, axes),
        earlier_divisions: earlier_divisions(set, r, plan, axes),
        electrodes: set.electrodes.iter().filter(burns).map(|e| e.name.clone()).collect(),
        cad_faces: Vec::new(),
        left_thickness_mm: plan.left.thickness,
        left_at_mm: axes.transform_point3(plan.left.place).to_array().map(|v| rounded(v, 1e6)),
        left_volume_mm3: plan.left.volume,
        trouble: plan.reason_at(axes),
        left_out: plan.left_out.iter().map(|left| left.text.clone()).collect(),
    }
}

/// What names parts that the last stage's division does not have.
fn earlier_divisions(set: &ElectrodeSet, r: usize, plan: &RegionPlan, axes: &DAffine3) -> Vec<EarlierDivision> {
    fn has(node: &PartNode, part: usize) -> bool {
        node.part == Some(part) || node.parts.iter().any(|node| has(node, part))
    }
    fn is_new(node: &PartNode, last: &PartNode) -> bool {
        node.part.is_some_and(|part| !has(last, part)) || node.parts.iter().any(|node| is_new(node, last))
    }
    let told = plan.earlier.iter().rev().filter(|(_, tree)| plan.tree.as_ref().is_some_and(|last| is_new(tree, last)));
    let of = |(stage, tree): &(usize, PartNode)| EarlierDivision {
        stage: set.params.stages[*stage].name.clone(),
        division: division(tree, r, &Plan::of(set, plan, axes)),
    };
    told.map(of).collect()
}

/// To one part in `scale`, and no zero with a sign.
fn rounded(value: f64, scale: f64) -> f64 {
    (value * scale).round() / scale + 0.0
}

fn leaves(node: &PartNode) -> usize {
    if node.parts.is_empty() { usize::from(node.part.is_some()) } else { node.parts.iter().map(leaves).sum() }
}

/// Reason why a cut leads to fewer parts than it has sides.
fn beyond(node: &PartNode) -> &'static str {
    match (node.lacks_thin, node.parts.len()) {
        (true, _) => ": what is thinner than the least size beyond it is left to later stages",
        (false, 1) => ": beyond it nothing is to be burned",
        _ => "",
    }
}

/// From the plan of the burn frame in the upright mold to that in the axes of the datum.
struct Plan<'a> {
    /// Burn direction, in the upright mold.
    direction: DVec3,
    axes: &'a DAffine3,
    /// Overlap of parts (mm).
    overlap: f64,
}

impl<'a> Plan<'a> {
    fn of(set: &ElectrodeSet, plan: &RegionPlan, axes: &'a DAffine3) -> Self {
        Self { direction: plan.direction, axes, overlap: set.params.overlap_mm }
    }

    fn vector(&self, v: DVec2) -> DVec2 {
        let turned = self.axes.matrix3 * (to_burn_frame(self.direction).transpose() * v.extend(0.0));
        (to_burn_frame(self.axes.transform_vector3(self.direction)) * turned).truncate()
    }

    fn point(&self, p: DVec2) -> DVec2 {
        // Along the burn all is one place.
        self.vector(p) + (to_burn_frame(self.axes.transform_vector3(self.direction)) * self.axes.translation).truncate()
    }
}

/// Division of region `r` by the last stage; `axes` are from the upright mold to those of the datum.
pub fn division_of(set: &ElectrodeSet, r: usize, axes: &DAffine3) -> Option<Division> {
    let plan = set.regions.get(r)?;
    plan.tree.as_ref().map(|tree| division(tree, r, &Plan::of(set, plan, axes)))
}

/// The H-edges of a part in words, after what is said of it.
fn edges_of(node: &PartNode) -> String {
    if node.h_edges.is_empty() {
        return String::new();
    }
    let length: f64 = node.h_edges.iter().map(EdgeChain::length).sum();
    let (edges, chains) = (counted(node.h_edge_count(), "H-edge"), counted(node.h_edges.len(), "chain"));
    format!(", {edges} in {chains}, {length:.1} mm")
}

fn division(node: &PartNode, r: usize, plan: &Plan) -> Division {
    let edges = edges_of(node);
    let text = match (&node.cut, node.part) {
        (Some(cut), _) => {
            let (through, outward) = (plan.point(cut.through.truncate()), plan.vector(cut.outward()));
            let slope = rounded(cut.slope().to_degrees(), 100.0);
            let slope = if slope == 0.0 { String::new() } else { format!(", on a draft of {slope}\u{b0}") };
            let overlap = if cut.overlaps { format!(", parts overlap by {} mm", plan.overlap) } else { String::new() };
            // A line across its normal, the same whichever way the normal points.
            let along = rounded(outward.perp().to_angle().to_degrees(), 10.0).rem_euclid(180.0);
            let [x, y] = through.to_array().map(|v| rounded(v, 1e3));
            let beyond = beyond(node);
            format!("cut through {x:.3}, {y:.3} along {along:.1}\u{b0}{slope}{overlap}{edges}{beyond}")
        }
        (None, Some(part)) => format!("part R{}.{}{edges}", r + 1, part + 1),
        (None, None) => format!("not burned{edges}"),
    };
    Division {
        text,
        h_edges: node.h_edge_count(),
        parts: node.parts.iter().map(|part| division(part, r, plan)).collect(),
    }
}

#[cfg(test)]
mod tests;
