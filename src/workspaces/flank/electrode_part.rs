//! The flank of an electrode that another workspace hands over.

use glam::DVec3;

use crate::workspaces::flank::document::kept_mesh::KeptMesh;
use crate::workspaces::flank::document::{FlankDocument, FlankSource, MeshFlank};
use crate::workspaces::flank::inputs::{FlankLoadError, load_machine};
use crate::workspaces::message::ElectrodePart;
use files::paths::user_folder;
use flank::fit_ruled::RuledFitParams;
use flank::machine::milling_machine::Workpiece;
use flank::params::FlankParams;

/// The flank of `part` that is milled first, with the cutter, the plan and the machine of `before`.
///
/// # Errors
/// [`FlankLoadError`] if the machine or the mesh cannot be read.
pub fn flank_of(part: &ElectrodePart, before: &FlankDocument) -> Result<FlankDocument, FlankLoadError> {
    let kept = KeptMesh::new(&part.name, &part.of, &part.mesh).map_err(FlankLoadError)?;
    let fit = fit_of(part);
    let mut document =
        before.of_another(FlankSource::Mesh(MeshFlank { fit, kept: Some(kept), ..MeshFlank::default() }));
    if part.is_upside_down {
        keep_off_base(&mut document);
        turn_over(&mut document)?;
    }
    Ok(document)
}

/// Parameters for fitting ruled surfaces to the faces of `part`.
pub fn fit_of(part: &ElectrodePart) -> RuledFitParams {
    RuledFitParams { up: part.up, base: part.base, ..RuledFitParams::default() }
}

/// Ends the cutter's bottom at the lower guide unless another depth is given: below an electrode's tips is its base,
/// which a deeper cutter would gouge.
pub fn keep_off_base(document: &mut FlankDocument) {
    if document.plan.below_mm == FlankParams::default().below_mm {
        document.plan.below_mm = 0.0;
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::workspaces::message::{BASE_OF_MOLDS, UP_OF_MOLDS};
    use flank::fit_ruled::{PartBase, flank_candidates};
    use geometry::frame::Frame;
    use geometry::mesh::Mesh;
    use task::Task;
    use wheel::electrode::{Electrode as BliskElectrode, ElectrodeFace, EntrySide};

    /// A box (mm) from `low` to `high`, outwards.
    fn cuboid(low: DVec3, high: DVec3) -> Mesh {
        let vertices =
            (0..8).map(|i| DVec3::select(glam::BVec3::new(i & 1 > 0, i & 2 > 0, i & 4 > 0), high, low)).collect();
        let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        Mesh { vertices, triangles: quads.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect() }
    }

    #[test]
    fn of_an_electrode_of_a_mold_a_tips_flank_comes_first_and_the_cutter_ends_at_its_base() {
        // Tips along -Z: a blank of 40 x 30 x 20 mm with a tip of 8 x 5 x 12 mm under it.
        let mut mesh = cuboid(DVec3::ZERO, DVec3::new(40.0, 30.0, 20.0));
        let tip = cuboid(DVec3::new(10.0, 10.0, -12.0), DVec3::new(18.0, 15.0, 0.0));
        mesh.triangles.extend(tip.triangles.iter().map(|t| t.map(|v| v + 8)));
        mesh.vertices.extend(tip.vertices);
        let base = Some(PartBase::at_end(BASE_OF_MOLDS));
        let (name, of) = ("E1".to_owned(), "mold".to_owned());
        let electrode = ElectrodePart { name, of, mesh, up: UP_OF_MOLDS, base, is_upside_down: true };
        let found = flank_candidates(&electrode.mesh, &fit_of(&electrode), &Task::default()).unwrap();
        assert!((found[0].area_mm2 - 96.0).abs() < 1e-6 && found[0].is_millable(), "{}", found[0].summary());
        let lies = |c: &flank::fit_ruled::Candidate| c.outwards.z.abs() > 0.99;
        let first = found.iter().position(lies).unwrap();
        assert!(first == 8 && found[first..].iter().all(lies) && found[4].area_mm2 > 500.0);
        // Without a base the largest that stands is first.
        let plain = RuledFitParams { base: None, ..fit_of(&electrode) };
        let plain = flank_candidates(&electrode.mesh, &plain, &Task::default()).unwrap();
        assert!((plain[0].area_mm2 - 800.0).abs() < 1e-6, "{}", plain[0].summary());

        let mut before = FlankDocument::default();
        before.milling.machine = String::new();
        assert_eq!(flank_of(&electrode, &before).unwrap().plan.below_mm, 0.0);
        before.plan.below_mm = 0.3;
        assert_eq!(flank_of(&electrode, &before).unwrap().plan.below_mm, 0.3);
    }

    #[test]
    fn of_an_electrode_of_a_blisk_a_wall_comes_first_and_neither_shank_nor_holder() {
        use ElectrodeFace::{EntryEnd, FarEnd, HighWall, Holder, HubSide, LowWall, Shank, ShroudSide};
        // The faces of a box in their order: lower and upper in Z, Y, and X.
        let boxes = [
            ([0.0, -2.5, 0.0], [20.0, 2.5, 8.0], [HubSide, ShroudSide, HighWall, LowWall, FarEnd, EntryEnd]),
            ([20.0, -2.2, 0.3], [40.0, 2.2, 7.7], [Shank; 6]),
            ([40.0, -10.0, -8.0], [56.0, 10.0, 16.0], [Holder; 6]),
        ];
        let (mut mesh, mut faces) = (Mesh::default(), Vec::new());
        for (low, high, own) in boxes {
            let (one, start) = (cuboid(low.into(), high.into()), mesh.vertices.len() as u32);
            mesh.vertices.extend(one.vertices);
            mesh.triangles.extend(one.triangles.iter().map(|t| t.map(|v| v + start)));
            faces.extend(own.into_iter().flat_map(|face| [face; 2]));
        }
        let electrode = BliskElectrode {
            mesh,
            faces,
            enters_from: EntrySide::PlusX,
            reference_point: DVec3::ZERO,
            stage: None,
            part: 0,
            parts: 1,
            column: None,
            least_thickness_mm: 5.0,
            volume_mm3: 1.0,
            burn_area_mm2: 1.0,
            undersize_mm: 0.1,
            clearance_mm: 0.1,
            assumed: Vec::new(),
            patches: Vec::new(),
        };
        let turned = Frame { origin: DVec3::new(5.0, -3.0, 70.0), x: DVec3::Y, y: DVec3::Z, z: DVec3::X };
        for frame in [None, Some(&turned)] {
            let part = ElectrodePart::of_blisk(&electrode, (1, "blisk"), frame);
            let found = flank_candidates(&part.mesh, &fit_of(&part), &Task::default()).unwrap();
            let areas: Vec<f64> = found[..3].iter().map(|c| c.area_mm2).collect();
            assert!(areas.iter().zip([160.0, 160.0, 384.0]).all(|(a, b)| (a - b).abs() < 1e-6), "{areas:?}");
            assert!(found[..2].iter().all(|c| c.is_millable() && c.triangles.iter().all(|&t| t < 12)));
        }
    }
}
