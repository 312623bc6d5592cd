//! The faces of a CAD program on a wheel: what of them is turned about its axis, and the classes of surfaces by faces.

use serde::Serialize;

use super::frame::Axis;
use super::surfaces::SurfaceClass;
use geometry::mesh::Mesh;
use geometry::segmentation::{CadFaces, FaceKind};

/// A face is of one class where at least this share of its area is told to be of it.
const MOSTLY: f64 = 0.9;
/// A face is turned about the axis where its own axis is nearer than this share of the wheel's radius, over its extent.
const ABOUT_AXIS: f64 = 1e-3;

/// Faces of a wheel that the CAD program turned about its axis: cylinders, cones and tori.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct TurnedFaces {
    /// Number of faces of the file.
    pub faces: usize,
    /// Number of those that are turned about the axis.
    pub turned: usize,
    /// Greatest distance of an axis of these from the wheel's, over the extent of its face (mm).
    pub apart_mm: f64,
}

impl TurnedFaces {
    /// The turned faces among `cad`, the faces of `mesh`, about `axis`.
    pub fn new(mesh: &Mesh, cad: &CadFaces, axis: &Axis) -> Self {
        let radius = mesh.vertices.iter().map(|p| axis.distance(*p)).fold(0.0, f64::max);
        // How far the line of each face is from the axis.
        let mut apart = vec![0.0_f64; cad.faces.len()];
        for (corners, face) in mesh.iter_corners().zip(&cad.face_of) {
            let face = *face as usize;
            if let Some(line) = cad.faces.get(face).and_then(|face| line_of(&face.kind)) {
                let far = corners.map(|p| axis.distance(line.foot(p))).into_iter().fold(0.0, f64::max);
                apart[face] = apart[face].max(far);
            }
        }
        let is_turned = |kind: &FaceKind, apart: f64| line_of(kind).is_some() && apart < ABOUT_AXIS * radius;
        let turned = cad.faces.iter().zip(apart).filter(|(face, apart)| is_turned(&face.kind, *apart));
        let turned: Vec<f64> = turned.map(|(_, apart)| apart).collect();
        let apart_mm = turned.iter().copied().fold(0.0, f64::max);
        Self { faces: cad.faces.len(), turned: turned.len(), apart_mm }
    }
}

/// The line that a face is turned about.
fn line_of(kind: &FaceKind) -> Option<Axis> {
    match *kind {
        FaceKind::Cylinder { point, direction, .. } => Some(Axis::new(point, direction)),
        FaceKind::Cone { apex, axis, .. } => Some(Axis::new(apex, axis)),
        FaceKind::Torus { centre, axis, .. } => Some(Axis::new(centre, axis)),
        FaceKind::Plane { .. } | FaceKind::Sphere { .. } | FaceKind::FreeForm => None,
    }
}

/// Gives every triangle of a face the class that nearly all of the face has. A face on which several classes lie, as a
/// hub that goes on beyond the blades, keeps those of its triangles. `areas` are those of the triangles (mm²).
pub(super) fn classes_by_faces(classes: &mut [SurfaceClass], areas: &[f64], face_of: &[u32]) {
    let count = face_of.iter().max().map_or(0, |most| *most as usize + 1);
    let mut sums = vec![[0.0; SurfaceClass::ALL.len()]; count];
    for ((class, area), face) in classes.iter().zip(areas).zip(face_of) {
        sums[*face as usize][*class as usize] += area;
    }
    let class_of = |sums: &[f64; SurfaceClass::ALL.len()]| {
        let total: f64 = sums.iter().sum();
        SurfaceClass::ALL.into_iter().find(|class| sums[*class as usize] >= MOSTLY * total && total > 0.0)
    };
    let of_faces: Vec<Option<SurfaceClass>> = sums.iter().map(class_of).collect();
    for (class, face) in classes.iter_mut().zip(face_of) {
        *class = of_faces[*face as usize].unwrap_or(*class);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::segmentation::KnownFace;
    use glam::DVec3;

    #[test]
    fn a_face_is_of_the_class_of_nearly_all_of_it_or_keeps_several() {
        use SurfaceClass::{Edge, Elsewhere, Hub, MainLow};
        let mut classes = [MainLow, Edge, Hub, Elsewhere, Edge];
        classes_by_faces(&mut classes, &[0.95, 0.05, 0.6, 0.4, 1.0], &[0, 0, 1, 1]);
        assert_eq!(classes, [MainLow, MainLow, Hub, Elsewhere, Edge]);
    }

    /// A cylinder and a cone about the axis, one that is 0.02 mm and one that is 20 mm off.
    #[test]
    fn turned_faces_are_those_about_the_axis() {
        let cylinder = |y: f64| FaceKind::Cylinder {
            point: DVec3::new(3.0, y, 0.0),
            direction: DVec3::NEG_X,
            radius: 5.0,
            is_hollow: false,
        };
        let cone = FaceKind::Cone { apex: DVec3::X, axis: DVec3::X, half_angle: 0.5, is_hollow: true };
        let kinds = [cylinder(0.0), cone, cylinder(0.02), cylinder(20.0), FaceKind::FreeForm];
        let corners = [DVec3::new(0.0, 50.0, 0.0), DVec3::new(10.0, 50.0, 0.0), DVec3::new(0.0, 49.0, 5.0)];
        let mesh = Mesh { vertices: corners.to_vec(), triangles: vec![[0, 1, 2]; kinds.len()] };
        let cad = CadFaces { faces: kinds.map(KnownFace::of).to_vec(), face_of: (0..5).collect() };
        let found = TurnedFaces::new(&mesh, &cad, &Axis::new(DVec3::ZERO, DVec3::X));
        assert_eq!((found.faces, found.turned), (5, 3));
        assert!((found.apart_mm - 0.02).abs() < 1e-12, "{found:?}");
    }
}
