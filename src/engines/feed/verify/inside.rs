//! Test whether one closed mesh lies wholly inside another, which no distance between their surfaces can show.

use std::f64::consts::TAU;

use glam::DVec3;

use geometry::groups::Groups;
use geometry::inside::half_solid_angle;
use geometry::mesh::{Bounds, Mesh};
use geometry::weld::Weld;
use task::{Cancel, Cancelled};

/// Number of vertices or triangles between two checks of the cancel flag: well below 50 ms.
const PER_CHECK: usize = 16384;

/// One vertex of every connected part of a mesh. Triangles are connected where they share a vertex position.
///
/// # Errors
/// [`Cancelled`].
pub(super) fn point_of_each_part(mesh: &Mesh, cancel: &Cancel) -> Result<Vec<DVec3>, Cancelled> {
    // With room for all: to make more in between would take longer than a look at the flag may.
    let mut weld = Weld::with_capacity(mesh.vertices.len());
    let mut number = Vec::with_capacity(mesh.vertices.len());
    for some in mesh.vertices.chunks(PER_CHECK) {
        cancel.check()?;
        number.extend(some.iter().map(|p| weld.add(*p) as usize));
    }
    let mut parts = Groups::of(weld.points().len());
    let mut used = vec![false; weld.points().len()];
    for some in mesh.triangles.chunks(PER_CHECK) {
        cancel.check()?;
        for [a, b, c] in some.iter().map(|t| t.map(|v| number[v as usize])) {
            parts.join(a, b);
            parts.join(a, c);
            used[a] = true;
        }
    }
    let (mut seen, mut points) = (vec![false; used.len()], Vec::new());
    for (i, p) in weld.points().iter().enumerate() {
        if i % PER_CHECK == 0 {
            cancel.check()?;
        }
        if used[i] && !std::mem::replace(&mut seen[parts.first(i)], true) {
            points.push(*p);
        }
    }
    Ok(points)
}

/// The first of `points` that lies inside the closed surface made of `triangles`.
///
/// # Errors
/// [`Cancelled`].
pub(super) fn first_inside(
    triangles: &[[DVec3; 3]],
    points: impl IntoIterator<Item = DVec3>,
    cancel: &Cancel,
) -> Result<Option<DVec3>, Cancelled> {
    let mut bounds = Bounds::EMPTY;
    for some in triangles.chunks(PER_CHECK) {
        cancel.check()?;
        let here = Bounds::of(some.iter().flatten().copied());
        bounds = Bounds { min: bounds.min.min(here.min), max: bounds.max.max(here.max) };
    }
    for p in points {
        cancel.check()?;
        if bounds.intersects(&Bounds { min: p, max: p }) && winding_number(triangles, p, cancel)?.abs() > 0.5 {
            return Ok(Some(p));
        }
    }
    Ok(None)
}

/// Winding number of the surface around `p`: 1 inside a closed, outward oriented surface, 0 outside.
fn winding_number(triangles: &[[DVec3; 3]], p: DVec3, cancel: &Cancel) -> Result<f64, Cancelled> {
    let mut sum = 0.0;
    for some in triangles.chunks(PER_CHECK) {
        cancel.check()?;
        sum = some.iter().map(|corners| half_solid_angle(corners, p)).fold(sum, |sum, angle| sum + angle);
    }
    Ok(sum / TAU)
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::fixtures::folded_box;

    fn first(triangles: &[[DVec3; 3]], points: &[DVec3]) -> Option<DVec3> {
        first_inside(triangles, points.iter().copied(), &Cancel::default()).unwrap()
    }

    fn parts(mesh: &Mesh) -> usize {
        point_of_each_part(mesh, &Cancel::default()).unwrap().len()
    }

    #[test]
    fn what_is_told_to_stop_stops() {
        let mesh = Mesh::cuboid(DVec3::ONE);
        let triangles: Vec<_> = mesh.iter_corners().collect();
        let stop = Cancel::default();
        stop.cancel();
        assert_eq!(point_of_each_part(&mesh, &stop), Err(Cancelled));
        assert_eq!(first_inside(&triangles, [DVec3::splat(0.5)], &stop), Err(Cancelled));
        assert_eq!(winding_number(&triangles, DVec3::splat(0.5), &stop), Err(Cancelled));
    }

    #[test]
    fn a_box_holds_its_inside_and_nothing_else() {
        let mesh = Mesh::cuboid(DVec3::new(2.0, 3.0, 4.0));
        let triangles: Vec<_> = mesh.iter_corners().collect();
        for (p, inside) in [
            (DVec3::new(0.1, 2.9, 3.9), true),
            (DVec3::new(1.0, 1.0, 1.0), true),
            (DVec3::new(2.1, 1.0, 1.0), false),
            (DVec3::new(1.0, 1.0, -5.0), false),
        ] {
            let winding = winding_number(&triangles, p, &Cancel::default()).unwrap();
            assert!((winding - f64::from(u8::from(inside))).abs() < 1e-9, "{p}");
            assert_eq!(first(&triangles, &[DVec3::splat(9.0), p]), inside.then_some(p));
        }
    }

    #[test]
    fn a_fold_hides_no_inside_and_makes_none() {
        for thickness in [0.04, -0.04] {
            let triangles: Vec<_> = folded_box(thickness).iter_corners().collect();
            for x in [0.5, 1.5, 2.5, 3.5] {
                for (z, inside) in [(0.2, true), (2.9, true), (3.1, false), (4.0, false)] {
                    let p = DVec3::new(x, 1.1, z);
                    assert_eq!(first(&triangles, &[p]).is_some(), inside, "{p}");
                }
            }
        }
    }

    #[test]
    fn parts_are_counted_with_and_without_shared_vertices() {
        let shared = Mesh::cuboid(DVec3::ONE);
        let corners: Vec<_> = shared.iter_corners().flatten().collect();
        let count = corners.len() as u32;
        let soup =
            Mesh { vertices: corners, triangles: (0..count / 3).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect() };
        assert_eq!(parts(&shared), 1);
        assert_eq!(parts(&soup), 1);
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
        assert_eq!(parts(&both), 2);
    }
}
