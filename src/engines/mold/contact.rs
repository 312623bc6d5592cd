//! Faces with material on both sides, as where solids touch or reach into each other, or where joining them has left a
//! film of air: they are no surface of the mold.

use glam::DVec3;
use rayon::prelude::*;

use super::section::vertex_error;
use geometry::groups::Groups;
use geometry::inside::winding_number_by_rays;
use geometry::mesh::{Bounds, Mesh, normal_times_two_areas, unit_normal};
use geometry::raycast::RayMesh;
use task::{Cancel, Cancelled};

/// How far before a face it is asked whether there is material (mm), at least, and in errors of a vertex.
const BEFORE: (f64, f64) = (1e-3, 4.0);
/// More solids are no assembly but triangles that share no vertices.
const MOST_SOLIDS: usize = 2000;
/// By how much places are moved from the edges of their face, as a share of the way to its middle.
const INNER: f64 = 0.01;
/// How alike the directions of faces are that lie along each other (radians).
const ALIKE: f64 = 1e-3;
/// Places of a face for each share of its area in that of the part's longest side squared, and at most.
const PLACES: (f64, f64) = (1e4, 256.0);

/// Faces of a mesh with material on both sides.
#[derive(Default)]
pub(super) struct Contacts<'a> {
    /// None where no two faces touch.
    touching: Option<Touching<'a>>,
}

struct Touching<'a> {
    mesh: &'a Mesh,
    rays: RayMesh,
    before: f64,
    /// Whether another solid, or another face that looks towards it, comes near each face.
    is_near: Vec<bool>,
    /// Share of each face that is covered by material.
    covered: Vec<f64>,
}

impl<'a> Contacts<'a> {
    /// Contacts between the solids of a mesh, and within one where joining it has left films.
    ///
    /// # Errors
    /// If it is cancelled.
    pub fn of(mesh: &'a Mesh, cancel: &Cancel) -> Result<Self, Cancelled> {
        let before = BEFORE.0.max(BEFORE.1 * vertex_error(mesh));
        let Ok(rays) = RayMesh::new(mesh) else { return Ok(Self::default()) };
        let near = [near_others(mesh, before), films(mesh, &rays, before, cancel)?].into_iter().flatten();
        let near = near.reduce(|a, b| a.into_iter().zip(b).map(|(a, b)| a || b).collect());
        let Some(is_near) = near else { return Ok(Self::default()) };
        let mut touching = Touching { mesh, rays, before, is_near, covered: Vec::new() };
        let longest = mesh.bounds().size().max_element();
        let share = |face: usize| {
            cancel.check()?;
            let corners = mesh.corners(face);
            let area = 0.5 * normal_times_two_areas(corners).length();
            let count = (PLACES.0 * area / (longest * longest)).clamp(1.0, PLACES.1).ceil() as usize;
            // Not on its edges, where other faces may begin.
            let middle = corners.iter().sum::<DVec3>() / 3.0;
            let inner = |i: usize| place(corners, i, count).lerp(middle, INNER);
            let is_covered = |i: &usize| touching.covers(face, inner(*i), unit_normal(corners));
            Ok((0..count).filter(is_covered).count() as f64 / count as f64)
        };
        touching.covered = (0..mesh.triangles.len()).into_par_iter().map(share).collect::<Result<_, _>>()?;
        Ok(Self { touching: Some(touching) })
    }

    /// Share of a face's area that is surface of the mold.
    pub fn free_share(&self, face: usize) -> f64 {
        self.touching.as_ref().map_or(1.0, |touching| 1.0 - touching.covered[face])
    }

    /// Whether something may touch a face.
    pub fn are_near(&self, face: usize) -> bool {
        self.touching.as_ref().is_some_and(|touching| touching.is_near[face])
    }

    /// Whether there is material before a place on a face with this unit normal.
    pub fn cover(&self, face: usize, place: DVec3, normal: DVec3) -> bool {
        self.touching.as_ref().is_some_and(|touching| touching.covers(face, place, normal))
    }
}

/// Whether solids of a mesh may touch or reach into each other.
pub(super) fn have_contacts(mesh: &Mesh) -> bool {
    near_others(mesh, BEFORE.0.max(BEFORE.1 * vertex_error(mesh))).is_some()
}

impl Touching<'_> {
    fn covers(&self, face: usize, place: DVec3, normal: DVec3) -> bool {
        self.is_near[face] && winding_number_by_rays(self.mesh, &self.rays, place + normal * self.before) > 0
    }
}

/// Of each face whether another solid may be within a distance (mm) of it; none where no two solids are.
fn near_others(mesh: &Mesh, within: f64) -> Option<Vec<bool>> {
    let (numbers, count) = Groups::of_vertices(mesh).numbers();
    let solid_of = |face: usize| numbers[mesh.triangles[face][0] as usize] as usize;
    // Solids that share an edge are one group.
    let touches_itself = touching_along_edges(mesh, count, solid_of);
    if count > MOST_SOLIDS || (count < 2 && !touches_itself.contains(&true)) {
        return None;
    }
    let mut bounds = vec![Bounds::EMPTY; count];
    for (point, number) in mesh.vertices.iter().zip(&numbers) {
        let of = &mut bounds[*number as usize];
        (of.min, of.max) = (of.min.min(*point), of.max.max(*point));
    }
    let others = |own: usize| -> Vec<Bounds> {
        let near = bounds[own].grown(within);
        (0..count).filter(|other| *other != own && bounds[*other].intersects(&near)).map(|i| bounds[i]).collect()
    };
    let others: Vec<Vec<Bounds>> = (0..count).into_par_iter().map(others).collect();
    let is_near = |face: usize| {
        let own = Bounds::of(mesh.corners(face)).grown(within);
        touches_itself[solid_of(face)] || others[solid_of(face)].iter().any(|other| other.intersects(&own))
    };
    let is_near: Vec<bool> = (0..mesh.triangles.len()).into_par_iter().map(is_near).collect();
    is_near.contains(&true).then_some(is_near)
}

/// Of each face whether another one within a distance (mm) lies along it and looks towards it, as on both sides of a film
/// of air that joining two solids has left between them; none where there is no film. What is taken for near too often
/// costs time alone: rays decide.
fn films(mesh: &Mesh, rays: &RayMesh, within: f64, cancel: &Cancel) -> Result<Option<Vec<bool>>, Cancelled> {
    let is_near = |face: usize| {
        cancel.check()?;
        let corners = mesh.corners(face);
        let own = unit_normal(corners);
        let faces = |other: u32| {
            let others = mesh.corners(other as usize);
            let normal = unit_normal(others);
            let is_along = |p: &DVec3| {
                let way = *p - corners[0];
                way.dot(own).abs() <= within + ALIKE * way.length()
            };
            own.dot(normal) < 0.0 && own.cross(normal).length() < ALIKE && others.iter().any(is_along)
        };
        let beside = Bounds::of(corners).grown(within);
        Ok(rays.meeting(mesh, |b| b.intersects(&beside)).any(faces))
    };
    let are_near: Vec<bool> = (0..mesh.triangles.len()).into_par_iter().map(is_near).collect::<Result<_, _>>()?;
    Ok(are_near.contains(&true).then_some(are_near))
}

/// Of each group of faces whether more than two of them meet in an edge.
fn touching_along_edges(mesh: &Mesh, count: usize, group_of: impl Fn(usize) -> usize) -> Vec<bool> {
    // The vertices that edges lead to from each vertex: two faces that meet have their edge in opposite directions.
    let mut first = vec![0u32; mesh.vertices.len() + 1];
    mesh.triangles.iter().flatten().for_each(|v| first[*v as usize + 1] += 1);
    (1..first.len()).for_each(|v| first[v] += first[v - 1]);
    let mut next = first.clone();
    let mut to = vec![(0u32, 0u32); 3 * mesh.triangles.len()];
    for (face, [a, b, c]) in mesh.triangles.iter().enumerate() {
        for (from, end) in [(a, b), (b, c), (c, a)] {
            let place = &mut next[*from as usize];
            to[*place as usize] = (*end, face as u32);
            *place += 1;
        }
    }
    let mut touches = vec![false; count];
    for ends in first.windows(2) {
        let edges = &mut to[ends[0] as usize..ends[1] as usize];
        edges.sort_unstable();
        for pair in edges.windows(2).filter(|pair| pair[0].0 == pair[1].0) {
            touches[group_of(pair[0].1 as usize)] = true;
        }
    }
    touches
}

/// Place number `i` of so many in a triangle, evenly spread: by the fractions of multiples of two irrational numbers
/// (Roberts 2018); one alone is the middle.
pub(super) fn place([a, b, c]: [DVec3; 3], i: usize, count: usize) -> DVec3 {
    if count == 1 {
        return (a + b + c) / 3.0;
    }
    let [u, v] = [0.754_877_666_246_692_8, 0.569_840_290_998_053_3].map(|step| (0.5 + step * i as f64).fract());
    let [u, v] = if u + v > 1.0 { [1.0 - u, 1.0 - v] } else { [u, v] };
    a + u * (b - a) + v * (c - a)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixtures::with;

    fn block(size: [f64; 3], at: [f64; 3]) -> Mesh {
        Mesh::cuboid(size.into()).mapped(|p| p + DVec3::from(at))
    }

    /// Area of the faces with this normal that is surface (mm^2).
    fn free_area(mesh: &Mesh, normal: DVec3) -> f64 {
        let contacts = Contacts::of(mesh, &Cancel::default()).unwrap();
        let faces = (0..mesh.triangles.len()).filter(|face| unit_normal(mesh.corners(*face)).dot(normal) > 0.999);
        faces.map(|face| contacts.free_share(face) * 0.5 * normal_times_two_areas(mesh.corners(face)).length()).sum()
    }

    #[test]
    fn a_solid_on_another_has_no_underside_and_one_that_overhangs_has_a_part_of_it() {
        let base = block([20.0, 20.0, 4.0], [0.0; 3]);
        let corner = base.bounds().min;
        let on = |x: f64, z: f64| {
            let post = block([4.0, 6.0, 5.0], [0.0; 3]);
            let shift = corner + DVec3::new(x, 3.0, z) - post.bounds().min;
            with(&base, &post.mapped(|p| p + shift))
        };
        let underside = |mesh: &Mesh| free_area(mesh, DVec3::NEG_Z);
        assert!((underside(&base) - 400.0).abs() < 1e-9);
        // On the base, sunk into it, above it, and half beside it.
        for (x, z, own) in [(5.0, 4.0, 0.0), (5.0, 3.0, 0.0), (5.0, 4.5, 24.0), (18.0, 4.0, 12.0)] {
            assert!((underside(&on(x, z)) - 400.0 - own).abs() < 0.5, "{x} {z}: {}", underside(&on(x, z)));
        }
        // Of the top what the post covers is none.
        assert!((free_area(&on(5.0, 4.0), DVec3::Z) - 400.0).abs() < 2.0);
    }

    /// A slot of a hair, as it stays between a rib and the wall that it was joined to, is no surface; one of a tenth is.
    #[test]
    fn a_film_of_air_within_a_solid_is_no_surface() {
        for (wide, walls) in [(2e-7, 40.0), (0.1, 72.0)] {
            let outline = [
                (0.0, 0.0),
                (10.0, 0.0),
                (10.0, 5.0),
                (5.0 + wide, 5.0),
                (5.0 + wide, 1.0),
                (5.0, 1.0),
                (5.0, 5.0),
                (0.0, 5.0),
            ];
            let vertices: Vec<DVec3> =
                [0.0, 8.0].iter().flat_map(|z| outline.map(|(x, y)| DVec3::new(x, y, *z))).collect();
            let side = |i: u32| {
                let j = (i + 1) % 8;
                [[i, j, j + 8], [i, j + 8, i + 8]]
            };
            let sides: Vec<[u32; 3]> = (0..8).flat_map(side).collect();
            // Both ends, of which neither has the slot in it.
            let end = [[0, 1, 4], [1, 2, 3], [1, 3, 4], [0, 4, 5], [0, 5, 7], [5, 6, 7]];
            let ends = end.iter().flat_map(|[a, b, c]| [[*a, *c, *b], [a + 8, b + 8, c + 8]]);
            let mesh = Mesh { vertices, triangles: sides.into_iter().chain(ends).collect() };
            let lean = glam::DMat3::from_euler(glam::EulerRot::XYZ, 0.3, -0.2, 0.7);
            let turned = mesh.mapped(|p| lean * p);
            // As in a file of single precision, far from its origin.
            let far = mesh.mapped(|p| (lean * p + DVec3::new(310.0, -280.0, 150.0)).as_vec3().as_dvec3());
            for (mesh, x) in [(&mesh, DVec3::X), (&turned, lean * DVec3::X), (&far, lean * DVec3::X)] {
                for normal in [x, -x] {
                    let area = free_area(mesh, normal);
                    assert!((area - walls).abs() < 0.5, "{wide}: {area}");
                }
            }
        }
    }

    #[test]
    fn solids_that_share_their_vertices_touch_too() {
        let low = block([4.0, 4.0, 4.0], [0.0; 3]);
        let mut both = with(&low, &low.mapped(|p| p + DVec3::Z * 4.0));
        let mut weld = geometry::weld::Weld::default();
        let number: Vec<u32> = both.vertices.iter().map(|p| weld.add(*p)).collect();
        both.triangles.iter_mut().for_each(|t| *t = t.map(|v| number[v as usize]));
        both.vertices = weld.into_points();
        assert_eq!(both.vertices.len(), 12);
        assert!(
            (free_area(&both, DVec3::NEG_Z) - 16.0).abs() < 1e-9 && (free_area(&both, DVec3::Z) - 16.0).abs() < 1e-9
        );
    }
}
