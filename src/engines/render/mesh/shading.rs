//! Normals that are smooth over curved faces and break at creases.

use bytemuck::{Pod, Zeroable};
use glam::DVec3;
use rayon::prelude::*;

use super::fans::Fans;
use geometry::mesh::Mesh;

/// Vertices handled at once by a thread.
const CHUNK: usize = 4096;
/// Corners on one vertex up to which every pair of faces is compared.
const FEW: usize = 24;
/// Cosine of the angle (1 degree) within which two normals on a vertex count as one.
const SAME: f64 = 0.999_85;

/// A vertex as the GPU reads it.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct Vertex {
    /// Position from the mesh's origin (mm).
    pub position: [f32; 3],
    /// Unit normal in 32767ths; the fourth is 0.
    pub normal: [i16; 4],
}

/// The vertices and triangles of a shaded surface.
#[derive(Debug, Default)]
pub struct Shaded {
    /// Vertices, one for each normal on a vertex of the mesh.
    pub vertices: Vec<Vertex>,
    /// The vertex of the mesh that each came from.
    pub sources: Vec<u32>,
    /// Three for each triangle, in the mesh's order.
    pub indices: Vec<u32>,
}

/// The part of the result that one thread makes.
struct Part {
    vertices: Vec<Vertex>,
    sources: Vec<u32>,
    /// For each corner in the order of the fans, which of `vertices` it uses.
    uses: Vec<u32>,
}

/// Splits the vertices of `mesh` where faces meet at more than the angle with cosine `crease`. Positions are
/// given from `origin`; `normals` are those of the triangles, zero for those without area.
pub fn shade(mesh: &Mesh, fans: &Fans, normals: &[DVec3], origin: DVec3, crease: f64) -> Shaded {
    let count = fans.vertex_count();
    let parts: Vec<Part> = (0..count.div_ceil(CHUNK))
        .into_par_iter()
        .map(|i| part(mesh, fans, normals, origin, crease, i * CHUNK..((i + 1) * CHUNK).min(count)))
        .collect();
    let mut shaded = Shaded { indices: vec![0; mesh.triangles.len() * 3], ..Shaded::default() };
    let mut corners = fans.all().iter();
    for part in parts {
        let base = shaded.vertices.len() as u32;
        for (used, &corner) in part.uses.iter().zip(&mut corners) {
            shaded.indices[corner as usize] = base + used;
        }
        shaded.vertices.extend(part.vertices);
        shaded.sources.extend(part.sources);
    }
    shaded
}

fn part(
    mesh: &Mesh,
    fans: &Fans,
    normals: &[DVec3],
    origin: DVec3,
    crease: f64,
    range: std::ops::Range<usize>,
) -> Part {
    let mut part = Part { vertices: Vec::new(), sources: Vec::new(), uses: Vec::new() };
    let mut distinct: Vec<DVec3> = Vec::new();
    for v in range {
        let corners = fans.of(v);
        let faces: Vec<(DVec3, f64)> =
            corners.iter().map(|&c| (normals[c as usize / 3], corner_angle(mesh, c))).collect();
        let base = part.vertices.len() as u32;
        distinct.clear();
        for normal in smooth_normals(&faces, crease) {
            let known = distinct.iter().position(|d| d.dot(normal) > SAME);
            let index = known.unwrap_or_else(|| {
                distinct.push(normal);
                distinct.len() - 1
            });
            part.uses.push(base + index as u32);
        }
        let position = (mesh.vertices[v] - origin).as_vec3().to_array();
        part.vertices.extend(distinct.iter().map(|&n| Vertex { position, normal: quantised(n) }));
        part.sources.extend(distinct.iter().map(|_| v as u32));
    }
    part
}

/// The normal of each corner on one vertex, from the normals and corner angles of its faces.
fn smooth_normals(faces: &[(DVec3, f64)], crease: f64) -> Vec<DVec3> {
    if faces.len() > FEW {
        return grouped_normals(faces, crease);
    }
    let near = |own: DVec3, other: DVec3| own == DVec3::ZERO || own.dot(other) >= crease;
    faces
        .iter()
        .map(|&(own, _)| {
            let sum: DVec3 = faces.iter().filter(|f| near(own, f.0)).map(|&(n, angle)| n * angle).sum();
            sum.try_normalize().unwrap_or(own)
        })
        .collect()
}

/// Normals at a vertex with many faces, by groups around the first face of each: there are never more groups than
/// directions apart by the crease angle, so that the work grows with the number of faces only.
fn grouped_normals(faces: &[(DVec3, f64)], crease: f64) -> Vec<DVec3> {
    let mut groups: Vec<(DVec3, DVec3)> = Vec::new();
    let mut group_of = Vec::with_capacity(faces.len());
    for &(normal, angle) in faces {
        let known = groups.iter().position(|g| normal == DVec3::ZERO || g.0.dot(normal) >= crease);
        let group = known.unwrap_or_else(|| {
            groups.push((normal, DVec3::ZERO));
            groups.len() - 1
        });
        groups[group].1 += normal * angle;
        group_of.push(group);
    }
    group_of.into_iter().map(|g| groups[g].1.try_normalize().unwrap_or(groups[g].0)).collect()
}

/// The angle (rad) of a triangle at one corner: faces count by it, so that the normal on a vertex does not
/// depend on how its flat surroundings were cut into triangles.
fn corner_angle(mesh: &Mesh, corner: u32) -> f64 {
    let points = mesh.corners(corner as usize / 3);
    let k = corner as usize % 3;
    let (a, b) = (points[(k + 1) % 3] - points[k], points[(k + 2) % 3] - points[k]);
    a.cross(b).length().atan2(a.dot(b))
}

fn quantised(normal: DVec3) -> [i16; 4] {
    let [x, y, z] = (normal * f64::from(i16::MAX)).to_array().map(|c| c.round() as i16);
    [x, y, z, 0]
}
