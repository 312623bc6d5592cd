//! An electrode that was just made, as the part whose flanks are milled.

use glam::DVec3;

use super::flank_files::{FlankLoadError, load_machine};
use crate::blisk::electrode::Electrode as BliskElectrode;
use crate::export::choice::MeshFrame;
use crate::flank::fit_ruled::RuledFitParams;
use crate::flank::machine::milling_machine::Workpiece;
use crate::geometry::frame::Frame;
use crate::geometry::mesh::Mesh;
use crate::mold::electrode::design::Electrode as MoldElectrode;
use crate::project::flank_params::{FlankDocument, FlankSource, MeshFlank};
use crate::project::kept_mesh::KeptMesh;
use crate::project::user_folder;

/// Which way is up on electrodes of molds, whose files have their tips along -Z.
pub const UP_OF_MOLDS: DVec3 = DVec3::NEG_Z;

/// An electrode, and how it stands while its flanks are milled.
#[derive(Debug, Clone, PartialEq)]
pub struct FlankElectrode {
    /// What it is called.
    pub name: String,
    /// What it burns: the name of a mold or a blisk.
    pub of: String,
    /// It, in the axes of its file (mm).
    pub mesh: Mesh,
    /// Which way the cutter's axis points on it.
    pub up: DVec3,
    /// Whether it is clamped upside down: its base on the table, its tips to the spindle.
    pub is_upside_down: bool,
}

impl FlankElectrode {
    /// One of a `mold`: as in its file, tips down.
    pub fn of_mold(electrode: &MoldElectrode, mold: &str) -> Self {
        Self {
            name: electrode.name.clone(),
            of: mold.to_owned(),
            mesh: electrode.mesh.clone(),
            up: UP_OF_MOLDS,
            is_upside_down: true,
        }
    }

    /// Number `number` (from 1) of a blisk whose W is `frame`, in the axes in which it is exported. Up is outwards.
    pub fn of_blisk(
        electrode: &BliskElectrode,
        (number, blisk): (usize, &str),
        (frame, exported): (&Frame, MeshFrame),
    ) -> Self {
        let (mesh, up) = match exported {
            MeshFrame::Mesh => (electrode.mesh.in_parent_of(frame), frame.z),
            MeshFrame::W => (electrode.mesh.clone(), DVec3::Z),
        };
        Self { name: format!("electrode {number}"), of: blisk.to_owned(), mesh, up, is_upside_down: false }
    }

    /// The flank of it that is milled first, with the cutter, the plan and the machine of `before`.
    ///
    /// # Errors
    /// [`FlankLoadError`] if the machine cannot be read, or the mesh is none.
    pub fn document(&self, before: &FlankDocument) -> Result<FlankDocument, FlankLoadError> {
        let kept = KeptMesh::new(&self.name, &self.of, &self.mesh).map_err(FlankLoadError)?;
        let fit = RuledFitParams { up: self.up, ..RuledFitParams::default() };
        let mut document =
            before.of_another(FlankSource::Mesh(MeshFlank { fit, kept: Some(kept), ..MeshFlank::default() }));
        if self.is_upside_down {
            turn_over(&mut document)?;
        }
        Ok(document)
    }
}

/// Clamps the workpiece upside down on its machine, if there is one.
///
/// # Errors
/// [`FlankLoadError`] if the machine cannot be read.
pub fn turn_over(document: &mut FlankDocument) -> Result<(), FlankLoadError> {
    if let Some(machine) = load_machine(document, user_folder().as_deref())? {
        let place = machine.workpiece;
        document.milling.workpiece = Some(Workpiece { z_axis: DVec3::ZERO - place.z_axis, ..place });
    }
    Ok(())
}
