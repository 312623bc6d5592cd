//! Extent of a blisk: the one definition of an electrode being outside, for the search and the verifier alike.

use glam::{DVec2, DVec3};

use super::pose::Pose;
use geometry::mesh::Mesh;
use wheel::electrode::EntrySide;

/// Depth below the electrode's innermost point down to which metal counts as its surroundings (mm).
const SURROUNDINGS: f64 = 15.0;

/// An electrode and the extent of the metal around it, rings and drums beyond the channel's own faces included.
#[derive(Debug, Clone)]
pub struct Outside {
    faces_x: [f64; 2],
    /// The blisk's greatest radius (mm).
    rim: f64,
    /// The radius of the cylinder about the axis that is free of metal (mm).
    bore: f64,
    /// Vertices of the electrode in its final pose, in W (mm).
    points: Vec<DVec3>,
    reference_point: DVec3,
}

impl Outside {
    /// Extent of `blisk` around `electrode` in its final pose, both in W, with the electrode's reference point O.
    pub fn new(blisk: &Mesh, electrode: &Mesh, reference_point: DVec3) -> Self {
        let radius = |p: &DVec3| p.y.hypot(p.z);
        // Vertices that no triangle uses are no part of the surface.
        let mut used = vec![false; electrode.vertices.len()];
        electrode.triangles.iter().flatten().for_each(|&v| used[v as usize] = true);
        let points: Vec<DVec3> =
            electrode.vertices.iter().zip(used).filter(|(_, used)| *used).map(|(&p, _)| p).collect();
        let innermost = points.iter().map(radius).fold(f64::INFINITY, f64::min);
        let around = blisk.iter_corners().filter(|t| t.iter().any(|p| radius(p) > innermost - SURROUNDINGS));
        let faces_x = extent(around.flatten().map(|p| p.x));
        let [_, rim] = extent(blisk.iter_corners().flatten().map(|p| radius(&p)));
        let bore = blisk.iter_corners().map(distance_from_axis).fold(f64::INFINITY, f64::min);
        Self { faces_x, rim, bore, points, reference_point }
    }

    /// The blisk's greatest radius (mm).
    pub fn rim(&self) -> f64 {
        self.rim
    }

    /// The radius of the cylinder about the axis that is free of metal (mm).
    pub fn bore(&self) -> f64 {
        self.bore
    }

    /// Distance of the whole electrode beyond the metal on `side` at `pose` (mm); negative while some point is not
    /// beyond it.
    pub fn distance_outside(&self, pose: &Pose, side: EntrySide) -> f64 {
        // Where the table with the blisk does not turn: the blisk's own extent is the same on all sides of its axis.
        let place = Pose { a: 0.0, ..*pose }.placement(self.reference_point);
        let placed = || self.points.iter().map(|&p| place.transform_point3(p));
        let [least, _] = extent(placed().map(|p| p.dot(side.direction())));
        match side {
            EntrySide::MinusX => least + self.faces_x[0],
            EntrySide::PlusX => least - self.faces_x[1],
            // Beside the axis the rim ends sooner.
            EntrySide::Outward => {
                let [from, to] = extent(placed().map(|p| p.y));
                let beside = from.max(-to).max(0.0);
                least - (self.rim * self.rim - beside * beside).max(0.0).sqrt()
            }
            EntrySide::Inward => self.bore - placed().map(|p| p.y.hypot(p.z)).fold(0.0, f64::max),
        }
    }

    /// The side on which the whole electrode at `pose` is beyond the metal, the one furthest beyond if there are two;
    /// none while some of it is not.
    pub fn side_of(&self, pose: &Pose) -> Option<EntrySide> {
        let distances = EntrySide::ALL.map(|side| (side, self.distance_outside(pose, side)));
        distances.into_iter().filter(|(_, d)| *d > 0.0).max_by(|a, b| a.1.total_cmp(&b.1)).map(|(side, _)| side)
    }

    /// Whether the whole electrode at `pose` is beyond the metal on one side or another.
    pub fn is_outside(&self, pose: &Pose) -> bool {
        self.side_of(pose).is_some()
    }
}

/// Distance of a triangle from the axis X (mm).
fn distance_from_axis(corners: [DVec3; 3]) -> f64 {
    let [a, b, c] = corners.map(|p| DVec2::new(p.y, p.z));
    let sides = [[a, b], [b, c], [c, a]];
    let turns = sides.map(|[p, q]| p.perp_dot(q));
    if turns.iter().all(|t| *t > 0.0) || turns.iter().all(|t| *t < 0.0) {
        return 0.0;
    }
    let of_side = |[p, q]: [DVec2; 2]| {
        let way = q - p;
        let share = (-p.dot(way) / way.length_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
        (p + share * way).length()
    };
    sides.map(of_side).into_iter().fold(f64::INFINITY, f64::min)
}

fn extent(values: impl Iterator<Item = f64>) -> [f64; 2] {
    values.fold([f64::INFINITY, f64::NEG_INFINITY], |[min, max], x| [min.min(x), max.max(x)])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn within_a_bore_the_farthest_corner_counts() {
        // Two beams at 30 mm to either side of the axis.
        let beam = Mesh::cuboid(DVec3::new(10.0, 40.0, 5.0)).mapped(|p| p + DVec3::new(0.0, -20.0, 30.0));
        let below = beam.mapped(|p| DVec3::new(p.x, -p.y, -p.z));
        let first = beam.vertices.len() as u32;
        let triangles = beam.triangles.iter().copied().chain(below.triangles.iter().map(|t| t.map(|v| v + first)));
        let triangles = triangles.collect();
        let blisk = Mesh { vertices: [beam.vertices, below.vertices].concat(), triangles };
        let tool = Mesh::cuboid(DVec3::new(1.0, 8.0, 10.0)).mapped(|p| p + DVec3::new(4.0, -4.0, 25.0));
        let outside = Outside::new(&blisk, &tool, DVec3::ZERO);
        assert!((outside.bore() - 30.0).abs() < 1e-12);
        for z in [-2.0_f64, -8.0, -30.0] {
            let free = 30.0 - 4f64.hypot((35.0 + z).max(-25.0 - z));
            let pose = Pose { z, ..Pose::FINAL };
            assert!((outside.distance_outside(&pose, EntrySide::Inward) - free).abs() < 1e-12, "{z}");
            assert_eq!(outside.side_of(&pose), (free > 0.0).then_some(EntrySide::Inward));
        }
    }

    #[test]
    fn metal_just_below_the_electrode_counts_and_metal_far_below_does_not() {
        let tool = Mesh::cuboid(DVec3::ONE).mapped(|p| p + DVec3::new(4.0, 0.0, 60.0));
        for (top, way) in [(46.0, -31.0), (44.0, -11.0)] {
            // A ring of 10 mm about the tool, and a drum of 30 mm that reaches up to `top`.
            let ring = Mesh::cuboid(DVec3::new(10.0, 1.0, 12.0)).mapped(|p| p + DVec3::Z * 58.0);
            let drum = Mesh::cuboid(DVec3::new(30.0, 1.0, 1.0)).mapped(|p| p + DVec3::Z * (top - 1.0));
            let first = ring.vertices.len() as u32;
            let blisk = Mesh {
                vertices: [ring.vertices, drum.vertices].concat(),
                triangles: ring
                    .triangles
                    .into_iter()
                    .chain(drum.triangles.iter().map(|t| t.map(|v| v + first)))
                    .collect(),
            };
            let outside = Outside::new(&blisk, &tool, DVec3::new(3.0, 2.0, 50.0));
            // The tool begins 4 mm inside: it lacks its place less the end of the metal.
            let moved = Pose { x: -5.0, ..Pose::FINAL };
            assert!((outside.distance_outside(&moved, EntrySide::PlusX) - way).abs() < 1e-12, "{top}");
            assert!((outside.distance_outside(&moved, EntrySide::MinusX) - 0.0).abs() < 1e-12);
            assert!(!outside.is_outside(&moved), "touching the plane of the face is not outside");
            assert!(outside.is_outside(&Pose { x: -5.1, ..moved }));
            assert_eq!(outside.is_outside(&Pose { x: 7.0, ..moved }), top < 45.0);
            // Beyond the rim along Z, whatever the blisk is turned by.
            let rim = 70f64.hypot(1.0);
            for a in [0.0, 0.7, 3.0] {
                let lifted = Pose { z: 11.0, a, ..Pose::FINAL };
                assert!((outside.distance_outside(&lifted, EntrySide::Outward) - (71.0 - rim)).abs() < 1e-9);
                assert_eq!(outside.side_of(&lifted), Some(EntrySide::Outward));
            }
            // From 48 mm beside the axis on the rim ends sooner.
            let beside = Pose { y: 48.0, z: 11.0, ..Pose::FINAL };
            let rim_there = (rim * rim - 48.0f64.powi(2)).sqrt();
            assert!((outside.distance_outside(&beside, EntrySide::Outward) - (71.0 - rim_there)).abs() < 1e-9);
        }
    }
}
