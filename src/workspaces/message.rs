//! Messages from one workspace to another.

use std::path::PathBuf;
use std::sync::Arc;

use flank::fit_ruled::PartBase;
use geometry::frame::Frame;
use geometry::mesh::Mesh;
use glam::DVec3;
use mold::electrode::design::Electrode as MoldElectrode;
use wheel::electrode::{Electrode as BliskElectrode, EntrySide};

/// A plain value from one workspace to the others.
#[derive(Debug, Clone, PartialEq)]
pub enum Message {
    /// An electrode whose flanks are to be milled; for the first workspace that accepts it.
    MillFlanks(Arc<ElectrodePart>),
    /// The technology table in this file has changed; for every workspace.
    TechnologyTable(PathBuf),
}

/// An electrode with its orientation for milling its flanks.
#[derive(Debug, Clone, PartialEq)]
pub struct ElectrodePart {
    /// Name of the electrode.
    pub name: String,
    /// Name of the mold or blisk that the electrode burns.
    pub of: String,
    /// Mesh of the electrode, in the axes of its file (mm).
    pub mesh: Mesh,
    /// Direction of the cutter's axis on the electrode.
    pub up: DVec3,
    /// Base of the electrode, which is not milled; none of an electrode of the user's own that burns nowhere.
    pub base: Option<PartBase>,
    /// Whether the electrode is clamped upside down: its base on the table, its tips to the spindle.
    pub is_upside_down: bool,
}

/// Direction upwards on electrodes of molds, whose files have their tips along -Z.
pub const UP_OF_MOLDS: DVec3 = DVec3::NEG_Z;
/// Direction to the base of electrodes of molds.
pub const BASE_OF_MOLDS: DVec3 = DVec3::Z;

impl ElectrodePart {
    /// An electrode of a `mold`: as in its file, tips down.
    pub fn of_mold(electrode: &MoldElectrode, mold: &str) -> Self {
        let (name, mesh) = (electrode.name.clone(), electrode.mesh.clone());
        let base = Some(PartBase::at_end(BASE_OF_MOLDS));
        Self { name, of: mold.to_owned(), mesh, up: UP_OF_MOLDS, base, is_upside_down: true }
    }

    /// Number `number` (from 1) of a blisk, in its own axes or, given the `frame` of these, in those of the blisk's
    /// mesh. Up is away from the axis; of an electrode from the rim or the bore, which is clamped by its holder, from there to its
    /// burning part.
    pub fn of_blisk(electrode: &BliskElectrode, (number, blisk): (usize, &str), frame: Option<&Frame>) -> Self {
        let side = electrode.enters_from;
        let is_upside_down = matches!(side, EntrySide::Outward | EntrySide::Inward);
        let up = if is_upside_down { -side.direction() } else { DVec3::Z };
        let in_file = |v: DVec3| frame.map_or(v, |frame| frame.direction_to_parent(v));
        let mesh = frame.map_or_else(|| electrode.mesh.clone(), |frame| electrode.mesh.in_parent_of(frame));
        // Shoulder, shank and holder begin where it stops to burn.
        let (up, towards) = (in_file(up), in_file(side.direction()));
        let burning = mesh.triangles.iter().zip(&electrode.faces).filter(|(_, face)| face.burns());
        let along = burning.flat_map(|(corners, _)| corners).map(|&v| mesh.vertices[v as usize].dot(towards));
        let base = along.reduce(f64::max).map(|from| PartBase { towards, from_mm: Some(from) });
        Self { name: format!("electrode {number}"), of: blisk.to_owned(), mesh, up, base, is_upside_down }
    }
}
