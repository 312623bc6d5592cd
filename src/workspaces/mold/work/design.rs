//! Electrodes for uncut regions, with everything shown of them.

use glam::DVec3;

use super::steps::{FoundUncut, LoadedMold};
use crate::workspaces::mold::document::fields::FIELDS;
use crate::workspaces::mold::job::electrodes::{electrodes, timed};
use crate::workspaces::mold::report::ElectrodesReport;
use crate::workspaces::mold::scene::electrodes::{ElectrodeShape, electrode_shapes};
use files::Override;
use mold::datum::Datum;
use mold::electrode::design::{ElectrodeSet, PartNode};
use mold::electrode::params::ElectrodeParams;
use mold::opening::Opening;
use task::{StageClock, StageTime, Task};

/// Electrodes with everything shown of them.
#[derive(Debug)]
pub struct Designed {
    /// The electrodes.
    pub set: ElectrodeSet,
    /// Report on the electrodes, without overrides; positions are those of the upright mold.
    pub report: ElectrodesReport,
    /// The electrodes for the screen.
    pub shapes: Vec<ElectrodeShape>,
    /// Opening direction of the mold.
    pub opening: Opening,
    /// What the search for uncut regions does not tell, in sentences.
    pub doubts: Vec<String>,
    /// A place on the surface of each region, upright, by which changes name the region (mm).
    pub places: Vec<Option<DVec3>>,
    /// Whether this run of the program has computed them, rather than read them from a file.
    pub is_proven: bool,
    /// Times of the stages, those of the search for uncut regions first; none of what was read from a file.
    pub times: Vec<StageTime>,
}

impl Designed {
    /// The result in a sentence, with these overrides of the user.
    pub fn sentence(&self, overrides: &[Override]) -> String {
        self.report.sentence_with(&self.set, overrides).replace("mm3", "mm³").replace("mm^3", "mm³")
    }

    /// The electrodes with minutes and wear by the technology table as it is now.
    pub(super) fn timed_again(&self, mold: &LoadedMold, found: &FoundUncut) -> Self {
        let set = timed(self.set.clone());
        Self {
            report: report_on(&set, mold, found),
            set,
            shapes: self.shapes.clone(),
            opening: self.opening,
            doubts: self.doubts.clone(),
            places: self.places.clone(),
            is_proven: self.is_proven,
            times: self.times.clone(),
        }
    }

    /// A place in each undivided part of a region, by number of the part; changes name the part by it. Upright (mm);
    /// none if the region is not burned straight down, or no place was found.
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

/// Makes electrodes for the regions `found` on `mold`.
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
    let clock = StageClock::default();
    let set = electrodes(mold.body(), uncut, params, &clock.timed(task)).map_err(|e| FIELDS.labelled(&e))?;
    let times = [found.times.clone(), clock.times()].concat();
    task.check().map_err(|e| e.to_string())?;
    Ok(Designed { times, ..shown(mold, found, set, found.is_proven) })
}

/// The electrodes with everything shown of them, without overrides.
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
    let report = report_on(&plain, mold, found);
    let (shapes, times) = (electrode_shapes(&plain), Vec::new());
    Designed { report, shapes, opening, doubts: uncut.doubts(), places, set: plain, is_proven, times }
}

/// The report on electrodes, without overrides.
fn report_on(plain: &ElectrodeSet, mold: &LoadedMold, found: &FoundUncut) -> ElectrodesReport {
    let uncut = &found.uncut;
    let of = ElectrodesReport::of(plain, &mold.name, uncut.params.opening, &Datum::default(), uncut.is_certain());
    of.with_cad_faces(&found.report)
}
