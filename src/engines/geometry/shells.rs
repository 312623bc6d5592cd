//! The connected shells of a mesh, where it has several: solids of an assembly that reach into each other.

use glam::DVec3;
use parry3d_f64::shape::TriMesh;

use super::exact::{nearest_of, oriented};
use super::groups::Groups;
use super::mesh::{Bounds, Mesh};

/// More shells are no solids of an assembly but triangles that share no vertices.
const MOST_SHELLS: usize = 2000;

/// A shell that was made ready.
struct Shell {
    bounds: Bounds,
    shape: TriMesh,
    is_cavity: bool,
}

/// The shells of a mesh; none where it is one.
pub(super) struct Shells(Vec<Shell>);

impl Shells {
    pub fn of(mesh: &Mesh) -> Self {
        let parts = connected(mesh);
        if parts.len() > MOST_SHELLS {
            return Self(Vec::new());
        }
        let ready = |part: Mesh| {
            let (bounds, is_cavity) = (part.bounds(), part.volume() < 0.0);
            Some(Shell { bounds, is_cavity, shape: oriented(&part).ok()? })
        };
        Self(parts.into_iter().filter_map(ready).collect())
    }

    /// Whether `p` lies in one of several shells, and in no cavity of it.
    pub fn hold(&self, p: DVec3) -> bool {
        let around = self.0.iter().filter(|shell| shell.bounds.distance_to(p) == 0.0);
        let depth = |shell: &Shell| {
            let is_behind = nearest_of(&shell.shape, p).signed_distance < 0.0;
            i32::from(is_behind != shell.is_cavity) * if shell.is_cavity { -1 } else { 1 }
        };
        around.map(depth).sum::<i32>() > 0
    }
}

/// The parts of a mesh whose triangles share no vertices, in the order of their first vertices.
fn connected(mesh: &Mesh) -> Vec<Mesh> {
    let mut groups = Groups::of(mesh.vertices.len());
    for [a, b, c] in mesh.triangles.iter().map(|t| t.map(|v| v as usize)) {
        groups.join(a, b);
        groups.join(a, c);
    }
    let (numbers, count) = groups.numbers();
    let mut parts = vec![Vec::new(); count];
    for triangle in &mesh.triangles {
        parts[numbers[triangle[0] as usize] as usize].push(*triangle);
    }
    // A vertex of no triangle is a group of its own.
    parts.retain(|triangles| !triangles.is_empty());
    let of = |triangles: &Vec<[u32; 3]>| {
        let mut used: Vec<u32> = triangles.iter().flatten().copied().collect();
        used.sort_unstable();
        used.dedup();
        let number = |v: u32| used.binary_search(&v).unwrap_or(0) as u32;
        let vertices = used.iter().map(|&v| mesh.vertices[v as usize]).collect();
        Mesh { vertices, triangles: triangles.iter().map(|t| t.map(number)).collect() }
    };
    if let [_] | [] = parts[..] { Vec::new() } else { parts.iter().map(of).collect() }
}
