//! Whether one closed mesh lies wholly inside another: what no distance between their surfaces can tell.

use std::f64::consts::TAU;

use glam::DVec3;

use crate::geometry::mesh::{Bounds, Mesh};

/// One vertex of every connected part of a mesh. Triangles are connected where they share a vertex position.
pub(super) fn point_of_each_part(mesh: &Mesh) -> Vec<DVec3> {
    let n = mesh.vertices.len();
    // Adding zero makes -0 and 0 the same.
    let position = |v: usize| (mesh.vertices[v] + DVec3::ZERO).to_array();
    let mut order: Vec<usize> = (0..n).collect();
    order.sort_by(|&v, &w| {
        let by_coordinate = position(v).into_iter().zip(position(w)).map(|(p, q)| p.total_cmp(&q));
        by_coordinate.fold(std::cmp::Ordering::Equal, |known, next| known.then(next)).then(v.cmp(&w))
    });
    let mut parts = Parts { parent: (0..n).collect() };
    for pair in order.windows(2).filter(|pair| position(pair[0]) == position(pair[1])) {
        parts.join(pair[0], pair[1]);
    }
    let mut used = vec![false; n];
    for [a, b, c] in mesh.triangles.iter().map(|t| t.map(|v| v as usize)) {
        parts.join(a, b);
        parts.join(a, c);
        used[a] = true;
    }
    let mut seen = vec![false; n];
    let first_of_part = |&v: &usize| used[v] && !std::mem::replace(&mut seen[parts.root(v)], true);
    (0..n).filter(first_of_part).map(|v| mesh.vertices[v]).collect()
}

/// Disjoint sets of indices.
struct Parts {
    parent: Vec<usize>,
}

impl Parts {
    fn root(&mut self, mut v: usize) -> usize {
        while self.parent[v] != v {
            self.parent[v] = self.parent[self.parent[v]];
            v = self.parent[v];
        }
        v
    }

    fn join(&mut self, v: usize, w: usize) {
        let (v, w) = (self.root(v), self.root(w));
        self.parent[v.max(w)] = v.min(w);
    }
}

/// The first of `points` that lies inside the closed surface made of `triangles`.
pub(super) fn first_inside(triangles: &[[DVec3; 3]], points: impl IntoIterator<Item = DVec3>) -> Option<DVec3> {
    let bounds = Bounds::of(triangles.iter().flatten().copied());
    let around = |p: DVec3| bounds.intersects(&Bounds { min: p, max: p });
    points.into_iter().find(|&p| around(p) && winding_number(triangles, p).abs() > 0.5)
}

/// How often the surface winds around `p`: 1 inside a closed, outward oriented surface, 0 outside. Solid angles
/// of the triangles after A. Van Oosterom and J. Strackee (IEEE Trans. Biomed. Eng. 30, 1983).
fn winding_number(triangles: &[[DVec3; 3]], p: DVec3) -> f64 {
    let half_solid_angle = |corners: &[DVec3; 3]| {
        let [a, b, c] = corners.map(|q| q - p);
        let (la, lb, lc) = (a.length(), b.length(), c.length());
        let cosine = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
        a.dot(b.cross(c)).atan2(cosine)
    };
    triangles.iter().map(half_solid_angle).sum::<f64>() / TAU
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::mesh::tests::{cuboid, folded_box};

    #[test]
    fn a_box_holds_its_inside_and_nothing_else() {
        let mesh = cuboid(DVec3::new(2.0, 3.0, 4.0));
        let triangles: Vec<_> = mesh.iter_corners().collect();
        for (p, inside) in [
            (DVec3::new(0.1, 2.9, 3.9), true),
            (DVec3::new(1.0, 1.0, 1.0), true),
            (DVec3::new(2.1, 1.0, 1.0), false),
            (DVec3::new(1.0, 1.0, -5.0), false),
        ] {
            assert!((winding_number(&triangles, p) - f64::from(u8::from(inside))).abs() < 1e-9, "{p}");
            assert_eq!(first_inside(&triangles, [DVec3::splat(9.0), p]), inside.then_some(p));
        }
    }

    #[test]
    fn a_fold_hides_no_inside_and_makes_none() {
        for thickness in [0.04, -0.04] {
            let triangles: Vec<_> = folded_box(thickness).iter_corners().collect();
            for x in [0.5, 1.5, 2.5, 3.5] {
                for (z, inside) in [(0.2, true), (2.9, true), (3.1, false), (4.0, false)] {
                    let p = DVec3::new(x, 1.1, z);
                    assert_eq!(first_inside(&triangles, [p]).is_some(), inside, "{p}");
                }
            }
        }
    }

    #[test]
    fn parts_are_counted_with_and_without_shared_vertices() {
        let shared = cuboid(DVec3::ONE);
        let corners: Vec<_> = shared.iter_corners().flatten().collect();
        let count = corners.len() as u32;
        let soup =
            Mesh { vertices: corners, triangles: (0..count / 3).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect() };
        assert_eq!(point_of_each_part(&shared).len(), 1);
        assert_eq!(point_of_each_part(&soup).len(), 1);
        let far = soup.mapped(|p| p + 5.0);
        let both = Mesh {
            vertices: [soup.vertices.clone(), far.vertices].concat(),
            triangles: soup
                .triangles
                .iter()
                .copied()
                .chain(far.triangles.iter().map(|t| t.map(|v| v + count)))
                .collect(),
        };
        assert_eq!(point_of_each_part(&both).len(), 2);
    }
}
