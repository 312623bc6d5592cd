//! Least distance of a moving electrode from a point.

use glam::{DAffine3, DVec3};

use crate::pose::Pose;
use geometry::distance_field::{DistanceField, FieldError};
use geometry::exact::{ExactMesh, ExactMeshError};
use geometry::mesh::{Bounds, Mesh};
use task::Task;

/// Accuracy of the least distance found (mm), beside the error of the distance field.
pub(super) const RESOLUTION: f64 = 0.002;
/// Distance around an electrode up to which distances are known (mm); greater ones do not matter.
pub(super) const REACH: f64 = 3.0;
/// Size of a cell of the field (mm).
const CELL: f64 = 0.3;
/// Cells at most.
const MOST_CELLS: f64 = 2e6;
/// Accuracy of distances as a share of them, where that is more than [`RESOLUTION`].
const COARSE: f64 = 0.01;

/// An electrode with the poses it passes through, linear in every axis between.
pub(super) struct Cutter {
    field: DistanceField,
    /// Box around the electrode in its final pose.
    bounds: Bounds,
    reference_point: DVec3,
    /// The motions: copying first, then the feed.
    motions: Vec<Motion>,
}

/// Poses with the way of the axes up to each of them.
struct Motion {
    poses: Vec<Pose>,
    /// Placement of the electrode at each of them: sines and cosines once, not at every look.
    placements: Vec<DAffine3>,
    /// Turn of A (rad), slides (mm), turns of B and C (rad), added up.
    ways: Vec<[f64; 3]>,
    /// Box that holds the electrode on the whole of it.
    swept: Bounds,
}

impl Motion {
    fn new(poses: Vec<Pose>, reference_point: DVec3, body: &Bounds) -> Self {
        let mut way = [0.0; 3];
        let mut ways = Vec::with_capacity(poses.len());
        for (i, pose) in poses.iter().enumerate() {
            let last = &poses[i.saturating_sub(1)];
            let slide = DVec3::new(pose.x - last.x, pose.y - last.y, pose.z - last.z);
            way[0] += (pose.a - last.a).abs();
            way[1] += slide.length();
            way[2] += (pose.b - last.b).abs() + (pose.c - last.c).abs();
            ways.push(way);
        }
        let placements: Vec<DAffine3> = poses.iter().map(|pose| pose.placement(reference_point)).collect();
        let swept = swept(&placements, &ways, reference_point, body);
        Self { poses, placements, ways, swept }
    }

    /// Whether the electrode may come nearer to `p` than `known` (mm), which is negative where it has been within it.
    fn may_lower(&self, p: DVec3, known: f64) -> bool {
        known <= 0.0 && self.swept.distance_to(p) == 0.0 || self.swept.distance_to(p) < known
    }

    /// Position of `u`, in rows: the row before it and the share of the motion to the next.
    fn place(&self, u: f64) -> (usize, usize, f64) {
        let row = (u.floor() as usize).min(self.poses.len() - 1);
        (row, (row + 1).min(self.poses.len() - 1), u - row as f64)
    }

    fn placement(&self, u: f64, reference_point: DVec3) -> DAffine3 {
        let (row, next, share) = self.place(u);
        if share == 0.0 {
            return self.placements[row];
        }
        self.poses[row].lerp(&self.poses[next], share).placement(reference_point)
    }

    fn way(&self, u: f64) -> [f64; 3] {
        let (row, next, share) = self.place(u);
        std::array::from_fn(|i| self.ways[row][i] + share * (self.ways[next][i] - self.ways[row][i]))
    }
}

/// Distance at one instant, where the field reaches so far, and a lower bound of it (mm).
#[derive(Clone, Copy)]
struct Look {
    distance: Option<f64>,
    at_least: f64,
    /// Vector from O to the point, in the electrode's axes (mm).
    arm: f64,
}

impl Cutter {
    /// Prepares an electrode, in its final pose in W, with its motions. What of it is beyond `span_x` in the final pose
    /// is taken to burn nothing: no feed goes further than the final pose.
    pub(super) fn new(
        mesh: &Mesh,
        reference_point: DVec3,
        span_x: [f64; 2],
        motions: Vec<Vec<Pose>>,
        task: &Task,
    ) -> Result<Self, CutterError> {
        let (exact, bounds) = (ExactMesh::new(mesh)?, within(mesh, span_x));
        let region = bounds.grown(REACH);
        let cell = DistanceField::cell_for(&region, CELL, MOST_CELLS);
        let field = DistanceField::build(mesh, &exact, region, cell, task)?;
        let motions = motions
            .into_iter()
            .filter(|poses| !poses.is_empty())
            .map(|poses| Motion::new(poses, reference_point, &bounds))
            .collect();
        Ok(Self { field, bounds, reference_point, motions })
    }

    /// The signed distance from `p`, in W, to the electrode in its final pose (mm, negative inside), if it is near.
    pub(super) fn in_final_pose(&self, p: DVec3) -> Option<f64> {
        self.field.value(p)
    }

    /// The least signed distance (mm) from `p`, in W, to the electrode at the rows of its first motion, or `known` if
    /// it is nowhere less: mostly near the least of all, since that motion bends where the electrode is at a wall.
    pub(super) fn at_rows(&self, p: DVec3, known: f64) -> f64 {
        let first = self.motions.first().filter(|motion| motion.may_lower(p, known));
        let rows = first.map_or(&[][..], |motion| &motion.placements);
        rows.iter().filter_map(|placement| self.look(placement, p).distance).fold(known, f64::min)
    }

    /// The least signed distance (mm) from `p`, in W, to the electrode over the continuous motions, or `known` if it is
    /// nowhere less. Once it is known to be `enough` or less the rest is not looked at. Within [`RESOLUTION`], or the share
    /// [`COARSE`] of itself, and the
    /// error of the field.
    pub(super) fn least(&self, p: DVec3, mut known: f64, enough: f64) -> f64 {
        for motion in &self.motions {
            if motion.may_lower(p, known) {
                known = self.least_over(motion, p, known, enough);
            }
        }
        known
    }

    fn look(&self, placement: &DAffine3, p: DVec3) -> Look {
        // Rigid: the transposed turn is the inverse one.
        let q = placement.matrix3.transpose() * (p - placement.translation);
        let distance = self.field.value(q);
        let at_least = distance.unwrap_or_else(|| {
            let outside = (self.bounds.min - q).max(q - self.bounds.max).max(DVec3::ZERO);
            outside.length()
        });
        Look { distance, at_least, arm: q.distance(self.reference_point) }
    }

    /// Branch and bound: no distance changes faster than the electrode moves past the point.
    fn least_over(&self, motion: &Motion, p: DVec3, mut known: f64, enough: f64) -> f64 {
        let radius = p.y.hypot(p.z);
        let look = |u: f64, known: &mut f64| {
            let look = self.look(&motion.placement(u, self.reference_point), p);
            *known = known.min(look.distance.unwrap_or(f64::INFINITY));
            look
        };
        let last = (motion.poses.len() - 1) as f64;
        let (first_look, last_look) = (look(0.0, &mut known), look(last, &mut known));
        let mut open = vec![(0.0, last, first_look, last_look)];
        while let Some((from, to, a, b)) = open.pop() {
            if known <= enough {
                break;
            }
            let (start, end) = (motion.way(from), motion.way(to));
            let [turn, slide, tilt] = std::array::from_fn(|i| end[i] - start[i]);
            let carried = turn * radius + slide;
            let travel = carried + tilt * (a.arm.max(b.arm) + carried);
            let bound = 0.5 * (a.at_least + b.at_least - travel);
            let resolution = RESOLUTION.max(COARSE * known);
            if bound >= known - resolution || travel <= 2.0 * resolution {
                continue;
            }
            // At a row where there is one between, since the motion bends there.
            let half = 0.5 * (from + to);
            let middle = if half.floor() > from {
                half.floor()
            } else if half.ceil() < to {
                half.ceil()
            } else {
                half
            };
            let between = look(middle, &mut known);
            open.push((from, middle, a, between));
            open.push((middle, to, between, b));
        }
        known
    }
}

/// Box that holds `body` on its way through `placements`. Between two of them a point strays from the straight line by
/// no more than an eighth of its second derivative: that of a turn about A, of slides carried by it, and of tilts.
fn swept(placements: &[DAffine3], ways: &[[f64; 3]], reference_point: DVec3, body: &Bounds) -> Bounds {
    let corners = body.corners();
    let at_rows = placements.iter().flat_map(|placement| corners.map(|p| placement.transform_point3(p)));
    let bounds = Bounds::of(at_rows);
    let arm = corners.iter().map(|p| p.distance(reference_point)).fold(0.0, f64::max);
    let radius = bounds.corners().iter().map(|p| p.y.hypot(p.z)).fold(0.0, f64::max);
    let strays = ways.windows(2).map(|pair| {
        let [turn, slide, tilt] = std::array::from_fn(|i| pair[1][i] - pair[0][i]);
        (radius * turn * turn + 2.0 * turn * slide + arm * (tilt + turn) * (tilt + turn)) / 8.0
    });
    bounds.grown(strays.fold(0.0, f64::max))
}

/// The box around what of `mesh` lies in the span of X, whole triangles at a time, cut off at the span's ends.
fn within(mesh: &Mesh, [from, to]: [f64; 2]) -> Bounds {
    let near = mesh.iter_corners().map(Bounds::of).filter(|b| b.max.x >= from && b.min.x <= to);
    let Bounds { min, max } = near.fold(Bounds::EMPTY, |a, b| Bounds { min: a.min.min(b.min), max: a.max.max(b.max) });
    if min.x > max.x {
        return mesh.bounds();
    }
    Bounds { min: min.with_x(min.x.max(from)), max: max.with_x(max.x.min(to)) }
}

/// Reason why an electrode cannot be prepared.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum CutterError {
    /// The electrode's distance field cannot be built.
    #[error("the electrode's distance field: {0}")]
    Field(#[from] FieldError),
    /// The electrode's mesh cannot be searched.
    #[error("the electrode's mesh: {0}")]
    Mesh(#[from] ExactMeshError),
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_least_distance_is_that_of_fine_sampling() {
        let mesh = Mesh::cuboid(DVec3::new(8.0, 4.0, 5.0)).mapped(|p| p + DVec3::new(-4.0, -2.0, 60.0));
        let o = DVec3::new(0.0, 0.0, 62.0);
        let poses = vec![
            Pose::FINAL,
            Pose { z: 0.7, ..Pose::FINAL },
            Pose { a: -0.03, z: 0.7, ..Pose::FINAL },
            Pose { x: -5.0, y: 1.0, a: 0.02, c: 0.3, ..Pose::FINAL },
        ];
        let cutter = Cutter::new(&mesh, o, [-9.0, 9.0], vec![poses.clone()], &Task::default()).unwrap();
        let exact = ExactMesh::new(&mesh).unwrap();
        for i in 0..60 {
            let f = f64::from(i);
            let p = DVec3::new(-9.0 + 0.3 * f, 4.5 * (1.7 * f).sin(), 62.5 + 4.0 * (0.9 * f).cos());
            let sampled = (0..=3000).map(|k| {
                let (row, t) = (k / 1000, f64::from(k % 1000) / 1000.0);
                let next = (row as usize + 1).min(3);
                let placement = poses[row as usize].lerp(&poses[next], t).placement(o);
                exact.signed_distance(placement.inverse().transform_point3(p))
            });
            let sampled = sampled.fold(2.5, f64::min);
            let found = cutter.least(p, 2.5, f64::NEG_INFINITY);
            // Samples are at most 0.01 mm apart; the field may be off by 5 um and, deep inside, by 5 % more.
            let allowed = RESOLUTION + 0.005 + DistanceField::ACCURACY + 0.05 * sampled.abs();
            assert!((found - sampled).abs() < allowed, "{p}: {found} {sampled}");
        }
    }
}
