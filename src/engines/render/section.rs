//! Intersections of a section plane with meshes.

use std::collections::HashMap;
use std::sync::Arc;

use glam::{DAffine3, DVec3};
use rayon::prelude::*;

use super::mesh::RenderMesh;
use super::scene::{Object, SectionPlane};
use geometry::mesh::Mesh;

/// The line along which a plane cuts a surface, as segments in the scene's frame. They run so that the
/// material of an outward-oriented body lies on one side throughout; each end is, to the last bit, an end of
/// the next segment.
pub type Cut = Vec<[DVec3; 2]>;

/// Cuts of the last picture, so that a plane at rest costs nothing.
#[derive(Default)]
pub struct CutCache {
    cuts: HashMap<Key, (Arc<Cut>, u64)>,
    round: u64,
}

type Key = (u64, [u64; 12], [u64; 6]);

impl CutCache {
    /// The cut of `object`, made now unless it was already in this picture or the last.
    pub fn cut(&mut self, object: &Object, plane: &SectionPlane) -> Arc<Cut> {
        let round = self.round;
        let entry = self
            .cuts
            .entry(key(object, plane))
            .or_insert_with(|| (Arc::new(cut(&object.mesh, &object.transform, plane)), round));
        entry.1 = round;
        entry.0.clone()
    }

    /// Drops what the last picture did not use. Called after each picture.
    pub fn finish_picture(&mut self) {
        let round = self.round;
        self.cuts.retain(|_, (_, used)| *used == round);
        self.round += 1;
    }
}

fn key(object: &Object, plane: &SectionPlane) -> Key {
    let [p, n] = [plane.point.to_array(), plane.normal.to_array()];
    let bits = [p[0], p[1], p[2], n[0], n[1], n[2]].map(f64::to_bits);
    (object.mesh.id(), object.transform.to_cols_array().map(f64::to_bits), bits)
}

/// The cut of a mesh that `transform` takes into the scene.
pub fn cut(mesh: &RenderMesh, transform: &DAffine3, plane: &SectionPlane) -> Cut {
    let Some(normal) = plane.unit_normal() else { return Cut::new() };
    let source = mesh.source();
    let points: Vec<DVec3> = source.vertices.par_iter().map(|&p| transform.transform_point3(p)).collect();
    let heights: Vec<f64> = points.par_iter().map(|p| normal.dot(p - plane.point)).collect();
    let crossing = |t: &[u32; 3]| {
        let above = t.map(|v| heights[v as usize] > 0.0);
        above[0] != above[1] || above[1] != above[2]
    };
    let placed = Mesh { vertices: points, triangles: Vec::new() };
    // Mirrored meshes turn inside out; their segments are turned back.
    let mirrored = transform.matrix3.determinant() < 0.0;
    source.triangles.par_iter().filter(|t| crossing(t)).map(|t| segment(&placed, &heights, t, mirrored)).collect()
}

/// The segment in a triangle that crosses the plane: from where its boundary rises to where it sinks.
fn segment(mesh: &Mesh, heights: &[f64], triangle: &[u32; 3], mirrored: bool) -> [DVec3; 2] {
    let mut ends = [DVec3::ZERO; 2];
    for k in 0..3 {
        let (a, b) = (triangle[k], triangle[(k + 1) % 3]);
        let (low, high) = (heights[a as usize] > 0.0, heights[b as usize] > 0.0);
        if low != high {
            ends[usize::from(low != mirrored)] = crossing_point(mesh, heights, a.min(b), a.max(b));
        }
    }
    ends
}

/// Where an edge meets the plane. The ends come in the order of their indices, so that both triangles at the
/// edge find the same point.
fn crossing_point(mesh: &Mesh, heights: &[f64], a: u32, b: u32) -> DVec3 {
    let (ha, hb) = (heights[a as usize], heights[b as usize]);
    mesh.vertices[a as usize].lerp(mesh.vertices[b as usize], ha / (ha - hb))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::tests::sphere;

    /// Twice the vector area that the segments run around.
    fn swept(cut: &Cut, about: DVec3) -> DVec3 {
        cut.iter().map(|[a, b]| (a - about).cross(b - about)).sum()
    }

    #[test]
    fn the_cut_of_a_sphere_is_its_circle() {
        let center = DVec3::new(1.0, 2.0, 3.0);
        let mesh = RenderMesh::new(&sphere(5.0, 60, center));
        let plane = SectionPlane { point: center + DVec3::Z * 3.0, normal: DVec3::new(0.0, 0.0, 2.0) };
        let found = cut(&mesh, &DAffine3::IDENTITY, &plane);
        let area = 0.5 * swept(&found, plane.point);
        // A polygon in a circle of radius 4 whose sides are at most 3 degrees long.
        assert!((area.length() - 16.0 * std::f64::consts::PI).abs() < 0.01 * 16.0 * std::f64::consts::PI);
        assert!(area.normalize().dot(DVec3::Z).abs() > 1.0 - 1e-12);
        for [a, _] in &found {
            assert_eq!(found.iter().filter(|s| s[1] == *a).count(), 1);
        }
    }

    #[test]
    fn a_plane_through_vertices_still_gives_a_closed_line_and_mirroring_keeps_its_sense() {
        let mesh = RenderMesh::new(&Mesh::cuboid(DVec3::splat(2.0)));
        let plane = SectionPlane { point: DVec3::ZERO, normal: DVec3::new(1.0, -1.0, 0.0) };
        let found = cut(&mesh, &DAffine3::IDENTITY, &plane);
        let area = 0.5 * swept(&found, DVec3::ONE);
        assert!((area.length() - 2.0 * 8f64.sqrt()).abs() < 1e-12);
        let mirror = DAffine3::from_scale(DVec3::new(1.0, 1.0, -1.0));
        let mirrored = 0.5 * swept(&cut(&mesh, &mirror, &plane), DVec3::new(1.0, 1.0, -1.0));
        assert!((mirrored - area).length() < 1e-12);
    }

    #[test]
    fn no_plane_and_a_plane_beside_cut_nothing() {
        let mesh = RenderMesh::new(&Mesh::cuboid(DVec3::ONE));
        for (point, normal) in [(DVec3::ZERO, DVec3::ZERO), (DVec3::NAN, DVec3::X), (DVec3::X * 3.0, DVec3::X)] {
            assert!(cut(&mesh, &DAffine3::IDENTITY, &SectionPlane { point, normal }).is_empty());
        }
    }
}
