//! Bodies of a mesh that lie apart from each other, as two wheels in one file do.

use glam::{DMat3, DVec3};

use super::super::channel::Channel;
use super::super::error::BliskError;
use super::super::frame::axis::{Axis, eigen, outer};
use super::super::frame::find_wheel;
use super::super::options::BliskOptions;
use geometry::groups::Groups;
use geometry::mesh::Mesh;
use task::Task;

/// Bodies lie apart where there is room between them of at least this share of the mesh's size.
const APART: f64 = 1e-3;
/// More shells are no solids but triangles that share no vertices.
const MOST_SHELLS: usize = 100;
/// Bodies that are searched for a wheel of their own.
const SEARCHED: usize = 3;
/// Two axes are one within this angle (rad) and this share of the mesh's size.
const SAME: f64 = 0.01;

/// A shell, as far as it reaches.
struct Shell {
    vertices: Vec<DVec3>,
    middle: DVec3,
    /// Extent along each of the common directions (mm).
    extents: Vec<[f64; 2]>,
}

fn extent(vertices: &[DVec3], direction: DVec3) -> [f64; 2] {
    let reach = vertices.iter().map(|p| p.dot(direction));
    reach.fold([f64::INFINITY, f64::NEG_INFINITY], |[l, m], d| [l.min(d), m.max(d)])
}

/// The bodies of `mesh`, of which no two come near each other, the largest first; none where all of it is one. Shells are
/// of one body unless a plane between them is found.
fn apart(mesh: &Mesh) -> Vec<Mesh> {
    let mut of_vertices = Groups::of_vertices(mesh);
    let first: Vec<usize> = (0..mesh.vertices.len()).map(|v| of_vertices.first(v)).collect();
    let mut names: Vec<usize> = mesh.triangles.iter().map(|t| first[t[0] as usize]).collect();
    let of_triangles = names.clone();
    names.sort_unstable();
    names.dedup();
    if !(2..=MOST_SHELLS).contains(&names.len()) {
        return Vec::new();
    }
    let number = |name: usize| names.binary_search(&name).ok();
    let mut vertices = vec![Vec::new(); names.len()];
    first.iter().zip(&mesh.vertices).for_each(|(name, p)| number(*name).into_iter().for_each(|i| vertices[i].push(*p)));
    let largest = vertices.iter().max_by_key(|of| of.len()).map_or(&[][..], |of| of);
    let own = principal(largest);
    let directions = [DVec3::X, DVec3::Y, DVec3::Z].into_iter().chain(own).collect::<Vec<_>>();
    let shell = |vertices: Vec<DVec3>| {
        let extents = directions.iter().map(|d| extent(&vertices, *d)).collect();
        Shell { middle: mean(&vertices), extents, vertices }
    };
    let shells: Vec<Shell> = vertices.into_iter().map(shell).collect();
    let room = APART * mesh.bounds().size().length();
    let has_room = |a: [f64; 2], b: [f64; 2]| b[0] - a[1] > room || a[0] - b[1] > room;
    let is_apart = |a: &Shell, b: &Shell| {
        let between = b.middle - a.middle;
        let across = own.iter().map(|d| between.reject_from_normalized(*d)).chain([between]);
        a.extents.iter().zip(&b.extents).any(|(a, b)| has_room(*a, *b))
            || across.filter_map(DVec3::try_normalize).any(|d| has_room(extent(&a.vertices, d), extent(&b.vertices, d)))
    };
    let mut bodies = Groups::of(shells.len());
    for i in 0..shells.len() {
        for k in i + 1..shells.len() {
            if bodies.first(i) != bodies.first(k) && !is_apart(&shells[i], &shells[k]) {
                bodies.join(i, k);
            }
        }
    }
    let (body_of, count) = bodies.numbers();
    if count < 2 {
        return Vec::new();
    }
    let mut triangles = vec![Vec::new(); count];
    for (triangle, name) in mesh.triangles.iter().zip(&of_triangles) {
        number(*name).into_iter().for_each(|i| triangles[body_of[i] as usize].push(*triangle));
    }
    let body = |triangles| Mesh { vertices: mesh.vertices.clone(), triangles }.compacted();
    let mut bodies: Vec<Mesh> = triangles.into_iter().map(body).collect();
    bodies.sort_by(|a, b| size(b).total_cmp(&size(a)));
    bodies
}

fn size(body: &Mesh) -> f64 {
    body.bounds().size().length()
}

fn mean(points: &[DVec3]) -> DVec3 {
    points.iter().sum::<DVec3>() / points.len().max(1) as f64
}

/// The principal axes of points.
fn principal(points: &[DVec3]) -> [DVec3; 3] {
    let middle = mean(points);
    eigen(points.iter().fold(DMat3::ZERO, |sum, p| sum + outer(*p - middle))).map(|(_, d)| d)
}

/// The refusal of `mesh` as several bodies, where it is not taken for a wheel about `axis` and one of its bodies is one by
/// itself, about another axis.
///
/// # Errors
/// [`BliskError::Cancelled`].
pub(super) fn refused(
    mesh: &Mesh,
    axis: Option<Axis>,
    options: &BliskOptions,
    task: &Task,
) -> Result<Option<BliskError>, BliskError> {
    let bodies = apart(mesh);
    let wheels = bodies.iter().take(SEARCHED).map(|body| match find_wheel(body, options, task) {
        Err(BliskError::Cancelled(cancelled)) => Err(BliskError::from(cancelled)),
        wheel => Ok(wheel.ok().map(|wheel| wheel.blisk)),
    });
    let wheels = wheels.collect::<Result<Vec<_>, _>>()?;
    let wheels: Vec<_> = wheels.into_iter().flatten().collect();
    let reach = mesh.bounds().size().length();
    let is_other = |other: &Axis| {
        axis.is_none_or(|axis| {
            axis.direction.cross(other.direction).length() > SAME
                || (axis.point - other.point).reject_from_normalized(axis.direction).length() > SAME * reach
        })
    };
    Ok(wheels.first().filter(|wheel| is_other(&wheel.axis)).map(|wheel| BliskError::Bodies {
        count: bodies.len() as u32,
        wheels: wheels.len() as u32,
        axis: wheel.axis,
        blades: wheel.repetition.blades,
        at: wheel.middle,
    }))
}

/// Says which bodies lie apart from the one that holds the passage of `channel`.
pub(super) fn others(mesh: &Mesh, channel: &Channel) -> Option<String> {
    let bodies = apart(mesh);
    let wall = channel.frame.to_parent(channel.low.point(channel.low.nu / 2, channel.low.nv / 2));
    let off = |body: &Mesh| body.vertices.iter().map(|p| p.distance_squared(wall)).fold(f64::INFINITY, f64::min);
    let own = (0..bodies.len()).min_by(|a, b| off(&bodies[*a]).total_cmp(&off(&bodies[*b])))?;
    let (_, other) = bodies.iter().enumerate().find(|(i, _)| *i != own)?;
    let (size, at) = (other.bounds().size(), other.bounds().center());
    Some(format!(
        "The mesh holds {} bodies apart from each other. Beside the one with the passage there is one of {:.1} x {:.1} x {:.1} \
         mm about ({:.1}, {:.1}, {:.1}) mm. All of them are metal that is not to be touched: load the wheel alone if they are \
         not there.",
        bodies.len(),
        size.x,
        size.y,
        size.z,
        at.x,
        at.y,
        at.z
    ))
}
