//! Electrodes for what was found, with all that is shown of them.

use glam::DVec3;

use super::steps::{FoundUncut, LoadedMold};
use crate::workspaces::mold::job::electrodes::electrodes;
use crate::workspaces::mold::report::ElectrodesReport;
use crate::workspaces::mold::scene::electrodes::{ElectrodeShape, electrode_shapes};
use files::Override;
use mold::electrode::design::{ElectrodeSet, PartNode};
use mold::electrode::params::ElectrodeParams;
use mold::opening::Opening;
use task::Task;

/// Electrodes with all that is shown of them.
#[derive(Debug)]
pub struct Designed {
    /// The electrodes.
    pub set: ElectrodeSet,
    /// The electrodes in figures and words, nothing overridden.
    pub report: ElectrodesReport,
    /// The electrodes for the screen.
    pub shapes: Vec<ElectrodeShape>,
    /// Where the mold opens to.
    pub opening: Opening,
    /// A place of each region's surface, upright, by which changes name it (mm).
    pub places: Vec<Option<DVec3>>,
    /// Whether they were made by this program since it was started, from what it found then.
    pub is_proven: bool,
}

impl Designed {
    /// The answer in a sentence if these are the user's overrides.
    pub fn sentence(&self, overrides: &[Override]) -> String {
        self.report.sentence_with(&self.set, overrides).replace("mm3", "mm³").replace("mm^3", "mm³")
    }

    /// A place in each part of a region that was not divided further, by its number, by which changes name it, upright
    /// (mm): none if the region is not burned straight down, or none was found.
    pub fn leaves(&self, region: usize) -> Vec<Option<DVec3>> {
        let Some(plan) = self.set.regions.get(region) else { return Vec::new() };
        let is_straight = plan.direction.dot(DVec3::NEG_Z) > 1.0 - 1e-12;
        let mut places = Vec::new();
        if let Some(tree) = &plan.tree {
            leaf_places(tree, plan.left.place.z, &mut places);
        }
        places.into_iter().map(|place| place.filter(|_| is_straight)).collect()
    }
}

fn leaf_places(node: &PartNode, z: f64, places: &mut Vec<Option<DVec3>>) {
    node.parts.iter().for_each(|part| leaf_places(part, z, places));
    if let Some(number) = node.part {
        places.resize(places.len().max(number + 1), None);
        places[number] = node.place.map(|p| p.extend(z));
    }
}

/// Makes electrodes for what was `found` of `mold`.
///
/// # Errors
/// One line for the user.
pub(super) fn design(
    mold: &LoadedMold,
    found: &FoundUncut,
    params: &ElectrodeParams,
    task: &Task,
) -> Result<Designed, String> {
    let uncut = &found.uncut;
    let set = electrodes(&mold.mesh, uncut, params, task).map_err(|e| e.to_string())?;
    task.check().map_err(|e| e.to_string())?;
    Ok(shown(mold, found, set, found.is_proven))
}

/// Electrodes that were made for what was `found` of `mold`, with all that is shown of them, nothing overridden.
pub(super) fn shown(mold: &LoadedMold, found: &FoundUncut, set: ElectrodeSet, is_proven: bool) -> Designed {
    let uncut = &found.uncut;
    let mut places = vec![None; set.regions.len()];
    for piece in &uncut.surface {
        if let Some(place) = places.get_mut(piece.region as usize) {
            place.get_or_insert(piece.corners[0]);
        }
    }
    let opening = uncut.params.opening;
    let plain = ElectrodeSet { params: ElectrodeParams { overrides: Vec::new(), ..set.params }, ..set };
    let report = ElectrodesReport::of(&plain, &mold.name, opening);
    Designed { report, shapes: electrode_shapes(&plain), opening, places, set: plain, is_proven }
}
