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
pub(super) struct Motion {
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

    /// Number of poses.
    pub(super) fn len(&self) -> usize {
        self.poses.len()
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
        let (exact, bounds) = (ExactMesh::new(mesh)?.into(), within(mesh, span_x));
        let region = bounds.grown(REACH);
        let cell = DistanceField::cell_for(&region, CELL, MOST_CELLS);
        let field = DistanceField::build(mesh, exact, region, cell, task)?;
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
    /// [`COARSE`] of itself, and the error of the field.
    pub(super) fn least(&self, p: DVec3, mut known: f64, enough: f64) -> f64 {
        for motion in &self.motions {
            if motion.may_lower(p, known) {
                known = self.least_over(motion, p, known, enough);
            }
        }
        known
    }

    /// A motion of this electrode.
    pub(super) fn motion(&self, poses: Vec<Pose>) -> Motion {
        Motion::new(poses, self.reference_point, &self.bounds)
    }

    /// The first row of `motion` at which `p`, in W, is nearer to the electrode than `distance` (mm, less than [`REACH`]).
    pub(super) fn first_row_within(&self, motion: &Motion, p: DVec3, distance: f64) -> Option<usize> {
        if !motion.may_lower(p, distance) {
            return None;
        }
        let radius = p.y.hypot(p.z);
        let mut row = 0;
        while let Some(placement) = motion.placements.get(row) {
            let look = self.look(placement, p);
            if look.distance.is_some_and(|known| known < distance) {
                return Some(row);
            }
            // No distance changes faster than the point moves in the electrode's axes.
            let way = motion.ways[row];
            let travel = |to: &[f64; 3]| {
                let [turn, slide, tilt] = std::array::from_fn(|i| to[i] - way[i]);
                let carried = turn * radius + slide;
                carried + tilt * (look.arm + carried)
            };
            let still = motion.ways[row + 1..].iter().take_while(|to| look.at_least - travel(to) >= distance).count();
            row += 1 + still;
        }
        None
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

    /// Branch and bound, with [`MotionBounds`] for the bounds.
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
            let ways = std::array::from_fn(|i| end[i] - start[i]);
            let bounds = MotionBounds::new([a, b], ways, radius);
            let resolution = RESOLUTION.max(COARSE * known);
            let is_linear = to <= from.floor() + 1.0;
            let is_above = |bound: f64| bound >= known - resolution;
            if bounds.travel <= 2.0 * resolution
                || is_above(bounds.at_least())
                || (is_linear && bounds.at_least_outside().is_some_and(is_above))
            {
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
            let at_middle = look(middle, &mut known);
            open.push((from, middle, a, at_middle));
            open.push((middle, to, at_middle, b));
        }
        known
    }
}

/// Bounds of the distance from a point to the electrode between two instants of a motion.
struct MotionBounds {
    looks: [Look; 2],
    /// Greatest way of the point in the electrode's axes (mm).
    travel: f64,
    /// Greatest second derivative of that way, where all axes move linearly, per square of the time between (mm).
    bend: f64,
}

impl MotionBounds {
    /// The bounds between two looks at a point at a `radius` from the axis of A, with the ways of the axes: turn of A (rad),
    /// slides (mm), turns of B and C (rad).
    fn new(looks: [Look; 2], [turn, slide, tilt]: [f64; 3], radius: f64) -> Self {
        // Turned by A and slid, the point takes this way; then it is tilted about O.
        let carried = turn * radius + slide;
        let arm = looks[0].arm.max(looks[1].arm) + carried;
        Self {
            looks,
            travel: carried + tilt * arm,
            bend: turn * turn * radius + 2.0 * tilt * carried + tilt * tilt * arm,
        }
    }

    /// A lower bound of the distance (mm): none changes faster than the point moves.
    fn at_least(&self) -> f64 {
        0.5 * (self.looks[0].at_least + self.looks[1].at_least - self.travel)
    }

    /// A lower bound of the distance (mm) where all axes move linearly and the point stays outside; none if that is not
    /// known. Where it moves along a wall this falls by the square of the travel, the other by the travel itself.
    ///
    /// The square of the distance is the least of the squares of those to all points of the electrode. The second
    /// derivative of each is twice the square of the point's speed and twice the product of distance and acceleration, at
    /// most. So the square of the distance lies no further below the chord between the instants than a parabola of that
    /// second derivative does.
    fn at_least_outside(&self) -> Option<f64> {
        // Less by the error of the field, which the square would magnify.
        let [a, b] = self.looks.map(|look| look.distance.map(|d| d - DistanceField::ACCURACY));
        let (a, b) = (a.filter(|a| *a > 0.0)?, b.filter(|b| *b > 0.0)?);
        // No nearest point in between is further away than the further look and the travel.
        let second = 2.0 * (self.travel * self.travel + (a.max(b) + self.travel) * self.bend);
        let rise = b * b - a * a;
        let t = (0.5 - rise / second).clamp(0.0, 1.0);
        let square = a * a + rise * t - 0.5 * second * t * (1.0 - t);
        (square > 0.0).then(|| square.sqrt() + DistanceField::ACCURACY)
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
    use proptest::prelude::*;

    use super::*;

    const O: DVec3 = DVec3::new(0.0, 0.0, 62.0);

    /// A cuboid of 8 x 4 x 5 mm that moves through `poses`.
    fn cutter(poses: Vec<Pose>) -> (Cutter, ExactMesh) {
        let mesh = Mesh::cuboid(DVec3::new(8.0, 4.0, 5.0)).mapped(|p| p + DVec3::new(-4.0, -2.0, 60.0));
        let cutter = Cutter::new(&mesh, O, [-9.0, 9.0], vec![poses], &Task::default()).unwrap();
        (cutter, ExactMesh::new(&mesh).unwrap())
    }

    #[test]
    fn between_two_instants_no_distance_is_less_than_its_bounds() {
        let pose = |most: [f64; 6]| {
            let values = most.map(|m| -m..m);
            values.prop_map(Pose::from_array)
        };
        let (electrode, exact) = cutter(vec![Pose::FINAL]);
        let around = [-7.0..7.0, -5.0..5.0, 57.0..68.0];
        let moved = pose([1.0, 1.0, 1.0, 0.02, 0.1, 0.1]);
        let step = pose([0.5, 0.5, 0.5, 0.01, 0.05, 0.05]);
        proptest!(|(p in around, moved in moved, step in step)| {
            let p = DVec3::from_array(p);
            let other = Pose::from_array(std::array::from_fn(|i| moved.to_array()[i] + step.to_array()[i]));
            let looks = [moved, other].map(|pose| electrode.look(&pose.placement(O), p));
            let motion = Motion::new(vec![moved, other], O, &electrode.bounds);
            let bounds = MotionBounds::new(looks, motion.way(1.0), p.y.hypot(p.z));
            let sampled = (0..=200).map(|k| {
                let placement = moved.lerp(&other, f64::from(k) / 200.0).placement(O);
                exact.signed_distance(placement.inverse().transform_point3(p))
            });
            let sampled = sampled.fold(f64::INFINITY, f64::min);
            let error = DistanceField::ACCURACY + 0.05 * (sampled.abs() - DistanceField::NEAR).max(0.0);
            prop_assert!(bounds.at_least() <= sampled + error, "{} {sampled}", bounds.at_least());
            let outside = bounds.at_least_outside().unwrap_or(0.0);
            prop_assert!(outside <= sampled.max(0.0) + error, "{outside} {sampled}");
        });
    }

    /// Moving along a face the distance stays: its bound is below it by the parabola of the travel.
    #[test]
    fn along_a_face_the_bound_falls_by_the_square_of_the_travel() {
        let (electrode, _) = cutter(vec![Pose::FINAL]);
        let p = DVec3::new(0.0, 2.2, 62.0);
        let looks = [Pose::FINAL, Pose { x: 0.05, ..Pose::FINAL }].map(|pose| electrode.look(&pose.placement(O), p));
        let bounds = MotionBounds::new(looks, [0.0, 0.05, 0.0], p.y.hypot(p.z));
        let off = 0.2 - bounds.at_least_outside().unwrap();
        // 0.05^2 / (8 * 0.2) mm.
        assert!((off - 0.0016).abs() < 1e-4, "{off}");
        assert!(0.2 - bounds.at_least() > 0.024);
    }

    #[test]
    fn the_least_distance_is_that_of_fine_sampling() {
        let poses = vec![
            Pose::FINAL,
            Pose { z: 0.7, ..Pose::FINAL },
            Pose { a: -0.03, z: 0.7, ..Pose::FINAL },
            Pose { x: -5.0, y: 1.0, a: 0.02, c: 0.3, ..Pose::FINAL },
        ];
        let (cutter, exact) = cutter(poses.clone());
        for i in 0..60 {
            let f = f64::from(i);
            let p = DVec3::new(-9.0 + 0.3 * f, 4.5 * (1.7 * f).sin(), 62.5 + 4.0 * (0.9 * f).cos());
            let sampled = (0..=3000).map(|k| {
                let (row, t) = (k / 1000, f64::from(k % 1000) / 1000.0);
                let next = (row as usize + 1).min(3);
                let placement = poses[row as usize].lerp(&poses[next], t).placement(O);
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
