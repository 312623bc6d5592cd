//! Wall clearances, the four distances of P1: from the electrode to the suction wall, the pressure wall, the hub and
//! the shroud of its channel, each by itself.

use glam::DVec3;
use rayon::prelude::*;

use super::pose::Pose;
use super::samples::{Cluster, Sample, SampleSpacing, cluster, sample_electrode};
use geometry::frame::Cylindrical;
use task::{Cancel, Cancelled};
use wheel::channel::{Channel, Flow};
use wheel::electrode::Electrode;
use wheel::surface_finder::SurfaceFinder;

/// Least distances of an electrode in one pose (mm).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WallClearances {
    /// Distances to the low and to the high wall; the channel tells which of them is the suction wall.
    pub walls: [f64; 2],
    /// Distance to the radius of the hub, which facets of its mesh dip below; none once the electrode is out of the
    /// ring, and where the passage does not run along the axis.
    pub hub: Option<f64>,
    /// Distance to the radius of the shroud; none outside the ring and where there is no shroud.
    pub shroud: Option<f64>,
}

/// An electrode made ready to be measured.
pub struct ClearanceGauge<'a> {
    finder: &'a SurfaceFinder,
    channel: &'a Channel,
    reference_point: DVec3,
    samples: Vec<Sample>,
    clusters: Vec<Cluster>,
}

impl<'a> ClearanceGauge<'a> {
    /// Points in a cluster.
    const CLUSTER: usize = 16;

    /// Prepares `electrode`; `finder` is that of `channel`.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn new(
        electrode: &Electrode,
        channel: &'a Channel,
        finder: &'a SurfaceFinder,
        cancel: &Cancel,
    ) -> Result<Self, Cancelled> {
        let spacing = SampleSpacing::default();
        let mut samples = sample_electrode(&electrode.mesh, &electrode.faces, spacing, cancel)?;
        let clusters = cluster(&mut samples, Self::CLUSTER, |_| 0);
        Ok(Self { finder, channel, reference_point: electrode.reference_point, samples, clusters })
    }

    /// The distances at each of `poses`, of samples of the electrode's surface.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn at_all(&self, poses: &[Pose], cancel: &Cancel) -> Result<Vec<WallClearances>, Cancelled> {
        poses.par_iter().map(|pose| cancel.check().map(|()| self.at(pose))).collect()
    }

    /// The distances at `pose`.
    pub fn at(&self, pose: &Pose) -> WallClearances {
        let place = pose.placement(self.reference_point);
        let [front, back] = self.channel.faces_x;
        let (mut hub, mut shroud) = (f64::INFINITY, f64::INFINITY);
        for sample in &self.samples {
            let Cylindrical { x, r, .. } = Cylindrical::from_point(place.transform_point3(sample.point));
            if self.channel.flow == Flow::Axial && (front..=back).contains(&x) {
                let (inner, outer) = self.channel.radii_at(x);
                hub = hub.min(r - inner);
                shroud = shroud.min(outer - r);
            }
        }
        let known = |distance: f64| Some(distance).filter(|d| d.is_finite());
        let to_wall = |p: DVec3| self.finder.wall_distances(place.transform_point3(p));
        WallClearances {
            walls: self.nearest_to_walls(to_wall),
            hub: known(hub),
            shroud: known(shroud).filter(|_| self.channel.shrouded),
        }
    }

    /// Least distances to both walls over all samples; clusters that are too far away are skipped.
    fn nearest_to_walls(&self, distances: impl Fn(DVec3) -> [f64; 2]) -> [f64; 2] {
        let mut nearest: Vec<(f64, &Cluster)> = Vec::new();
        let mut least = [f64::INFINITY; 2];
        for c in &self.clusters {
            let bound = distances(c.center).map(|d| d - c.radius);
            nearest.push((bound[0].min(bound[1]), c));
        }
        nearest.sort_by(|a, b| a.0.total_cmp(&b.0));
        for (bound, c) in nearest {
            if bound > least[0].max(least[1]) {
                break;
            }
            for sample in &self.samples[c.start..c.end] {
                let [low, high] = distances(sample.point);
                least = [least[0].min(low), least[1].min(high)];
            }
        }
        least
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::exact::ExactMesh;
    use task::Task;
    use wheel::electrode::{ElectrodeParams, EntrySide, make_electrodes};
    use wheel::fixtures::exact_channel;
    use wheel::parametric::{MeshResolution, ParametricBlisk};

    #[test]
    fn in_the_final_pose_they_are_the_gap_and_the_reductions() {
        let blisk = ParametricBlisk::turbine();
        let channel = exact_channel(&blisk);
        let mesh = blisk.mesh(&MeshResolution::default()).unwrap().in_frame(&channel.frame);
        let task = Task::default();
        let exact = ExactMesh::new(&mesh).unwrap();
        let params = ElectrodeParams {
            circumferential_reduction_deg: [0.0, 1.0],
            spark_gap_mm: 0.15,
            radial_reduction_mm: 0.5,
            ..Default::default()
        };
        let made = make_electrodes(&channel, &exact, &params, EntrySide::PlusX, &task).unwrap();
        let finder = SurfaceFinder::new(channel.clone().into()).unwrap();
        let gauge = ClearanceGauge::new(&made[0], &channel, &finder, &task.cancel).unwrap();
        let at = gauge.at(&Pose::FINAL);
        assert!((at.walls[0] - 0.15).abs() < 0.02, "{at:?}");
        assert!(at.walls[1] > 0.3, "one degree more");
        // Facets of the mesh dip below the hub, and the electrode keeps its gap to the facets.
        assert!((at.hub.unwrap() - 0.15).abs() < 0.04, "{at:?}");
        assert!((at.shroud.unwrap() - 0.65).abs() < 0.04, "{at:?}");
        // Clusters that are passed over hold nothing nearer.
        let all = made[0].mesh.vertices.iter().map(|v| finder.wall_distances(*v));
        let least = all.fold([f64::INFINITY; 2], |[a, b], [c, d]| [a.min(c), b.min(d)]);
        assert!((0..2).all(|i| at.walls[i] <= least[i] + 0.02), "{at:?} {least:?}");
        // Towards the hub by what is left there, and out of the ring.
        let lower = gauge.at(&Pose { z: -0.1, ..Pose::FINAL });
        assert!((lower.hub.unwrap() - (at.hub.unwrap() - 0.1)).abs() < 0.01);
        let out = gauge.at_all(&[Pose { x: 500.0, ..Pose::FINAL }], &task.cancel).unwrap()[0];
        assert!(out.hub.is_none() && out.shroud.is_none() && out.walls[0] > 100.0);
    }
}
