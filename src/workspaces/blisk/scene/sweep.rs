//! The room that an electrode passes through, as a shape.

use std::sync::Arc;

use glam::DAffine3;

use super::track::Track;
use geometry::swept::{SweptError, SweptSurface};
use render::mesh::RenderMesh;
use task::Task;
use wheel::electrode::Electrode;

/// Cells of the lattice of a surface to be looked at closely: cells of some tenths of a millimetre. Takes seconds.
pub const FINE: usize = 1_000_000;
/// Cells of the lattice of one that is seen as a whole.
pub const COARSE: usize = 100_000;

/// The surface that `electrode` sweeps along `track`, in W, made on a lattice of about so many `cells`.
///
/// # Errors
/// If there is no way, or when told to stop.
pub fn swept_shape(
    electrode: &Electrode,
    track: &Track,
    cells: usize,
    task: &Task,
) -> Result<Arc<RenderMesh>, SweptError> {
    let placements = placements(electrode, track);
    let swept = SweptSurface::new(&electrode.mesh, &placements, cells, task)?;
    task.check()?;
    Ok(Arc::new(RenderMesh::new(&swept.mesh)))
}

/// Where the electrode is along `track`, in W, so often that no point of it goes much further than
/// [`SweptSurface::STEP`] from one to the next.
pub fn placements(electrode: &Electrode, track: &Track) -> Vec<DAffine3> {
    let corners = electrode.mesh.bounds().corners();
    let o = electrode.reference_point;
    let mut placements: Vec<DAffine3> = track.stations().iter().take(1).map(|s| s.pose.placement(o)).collect();
    for pair in track.stations().windows(2) {
        let [from, to] = [pair[0].pose, pair[1].pose].map(|p| p.placement(o));
        let moved = corners.map(|c| from.transform_point3(c).distance(to.transform_point3(c)));
        let steps = (moved.into_iter().fold(0.0, f64::max) / SweptSurface::STEP).ceil().max(1.0);
        let at = |i: usize| pair[0].pose.lerp(&pair[1].pose, i as f64 / steps).placement(o);
        placements.extend((1..=steps as usize).map(at));
    }
    placements
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use feed::objective::ObjectiveValue;
    use feed::pose::Pose;
    use feed::problem::Node;
    use geometry::exact::ExactMesh;
    use geometry::inside::is_inside;
    use wheel::electrode::{ElectrodeParams, EntrySide, make_electrodes};
    use wheel::fixtures::exact_channel;
    use wheel::parametric::{MeshResolution, ParametricBlisk};

    #[test]
    fn the_room_holds_the_electrode_in_every_pose() {
        let blisk = ParametricBlisk::turbine();
        let exact = ExactMesh::new(&blisk.mesh(&MeshResolution::default()).unwrap()).unwrap();
        let (params, task) = (ElectrodeParams::default(), Task::default());
        let channel = exact_channel(&blisk);
        let made = make_electrodes(&channel, &exact, &params, EntrySide::PlusX, &task).unwrap();
        let electrode = &made[0];
        let pose = |i: f64| Pose { x: 4.0 * i, z: 0.3 * i, y: 0.1 * i * i, a: 0.03 * i, c: -0.04 * i * i, b: 0.0 };
        let node = |i: u32| {
            let pose = pose(f64::from(i));
            Node { s: pose.x, pose, h: 0.0, clearance: 0.1, objective: ObjectiveValue::default() }
        };
        let track = Track::of_nodes(&[0, 1, 2].map(node));
        let placements = placements(electrode, &track);
        let far = electrode.mesh.vertices.iter().copied();
        let moved =
            |p: DVec3| placements.windows(2).map(move |w| w[0].transform_point3(p).distance(w[1].transform_point3(p)));
        let most = far.flat_map(|p| moved(p).collect::<Vec<_>>()).fold(0.0, f64::max);
        assert!(most <= 1.05 * SweptSurface::STEP, "{most} mm from one placement to the next");

        let room = SweptSurface::new(&electrode.mesh, &placements, 100_000, &task).unwrap();
        assert!(RenderMesh::new(&room.mesh).is_closed());
        let surface = ExactMesh::new(&room.mesh).unwrap();
        let outside = |p: DVec3| if is_inside(&surface, p) { 0.0 } else { surface.signed_distance(p).abs() };
        let points = placements
            .iter()
            .step_by(9)
            .flat_map(|at| electrode.mesh.vertices.iter().step_by(41).map(|p| at.transform_point3(*p)));
        let distances: Vec<f64> = points.map(outside).collect();
        let most = distances.iter().copied().fold(0.0, f64::max);
        let mean = distances.iter().sum::<f64>() / distances.len() as f64;
        assert!(mean <= SweptSurface::ACCURACY, "{mean} mm outside on average");
        // Edges that are thinner than a cell are cut off.
        assert!(most <= 0.5 * room.cell, "{most} mm outside, cells of {} mm", room.cell);
    }
}
