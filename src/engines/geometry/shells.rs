//! The connected shells of a mesh, where it has several: solids of an assembly that reach into each other.

use std::collections::HashMap;
use std::sync::OnceLock;
use std::sync::atomic::AtomicU8;
use std::sync::atomic::Ordering::Relaxed;

use foldhash::fast::FixedState;
use glam::DVec3;
use parry3d_f64::shape::TriMesh;

use super::exact::{nearest_of, oriented};
use super::groups::Groups;
use super::mesh::{Bounds, Mesh};

/// More shells are no solids of an assembly but triangles that share no vertices.
const MOST_SHELLS: usize = 2000;

/// A shell, which is made ready for distances where they are asked for.
struct Shell {
    mesh: Mesh,
    bounds: Bounds,
    is_cavity: bool,
    /// None where it cannot be made ready.
    shape: OnceLock<Option<TriMesh>>,
}

impl Shell {
    /// Distance of `p` from the shell, negative in its solid (mm). What cannot be made ready is no solid.
    fn distance(&self, p: DVec3) -> Option<f64> {
        let shape = self.shape.get_or_init(|| oriented(&self.mesh).ok()).as_ref()?;
        Some(nearest_of(shape, p).signed_distance)
    }
}

/// The shells of a mesh; none where it is one.
pub struct Shells {
    shells: Vec<Shell>,
    /// Of each triangle the number of its shell.
    shell_of: Vec<u32>,
    /// Of each triangle whether another shell comes near it: unknown, no or yes.
    is_near_another: Vec<AtomicU8>,
}

const NO: u8 = 1;
const YES: u8 = 2;

impl Shells {
    /// Finds the shells of `mesh`.
    pub fn of(mesh: &Mesh) -> Self {
        let (shell_of, parts) = connected(mesh);
        let shell = |mesh: Mesh| {
            let (bounds, is_cavity) = (mesh.bounds(), mesh.volume() < 0.0);
            Shell { mesh, bounds, is_cavity, shape: OnceLock::new() }
        };
        let is_assembly = (2..=MOST_SHELLS).contains(&parts.len());
        let shells: Vec<Shell> = parts.into_iter().filter(|_| is_assembly).map(shell).collect();
        let triangles = if shells.is_empty() { 0 } else { shell_of.len() };
        Self { shells, shell_of, is_near_another: (0..triangles).map(|_| AtomicU8::new(0)).collect() }
    }

    /// Whether `p`, which is near `triangle` of the mesh, lies in a shell that reaches to that triangle, and in no cavity
    /// of it.
    pub fn hold(&self, p: DVec3, triangle: u32, corners: [DVec3; 3]) -> bool {
        if self.shells.is_empty() || !self.is_near_another(triangle, corners) {
            return false;
        }
        let around = self.shells.iter().filter(|shell| shell.bounds.distance_to(p) == 0.0);
        let depth = |shell: &Shell| {
            let is_behind = shell.distance(p)? < 0.0;
            Some(i32::from(is_behind != shell.is_cavity) * if shell.is_cavity { -1 } else { 1 })
        };
        around.filter_map(depth).sum::<i32>() > 0
    }

    /// Whether another shell may reach to the triangle.
    fn is_near_another(&self, triangle: u32, corners: [DVec3; 3]) -> bool {
        let known = &self.is_near_another[triangle as usize];
        if known.load(Relaxed) == 0 {
            let middle = corners.iter().sum::<DVec3>() / 3.0;
            let radius = corners.iter().map(|corner| corner.distance(middle)).fold(0.0, f64::max);
            let own = self.shell_of[triangle as usize] as usize;
            let others = self.shells.iter().enumerate().filter(|(i, _)| *i != own).map(|(_, shell)| shell);
            let comes_near = |shell: &Shell| {
                shell.bounds.distance_to(middle) <= radius && shell.distance(middle).is_some_and(|d| d <= radius)
            };
            known.store(if others.into_iter().any(comes_near) { YES } else { NO }, Relaxed);
        }
        known.load(Relaxed) == YES
    }
}

/// The parts of a mesh whose triangles share no vertices, in the order of their first triangles, after the number of the
/// part that each triangle is of. One part is none.
fn connected(mesh: &Mesh) -> (Vec<u32>, Vec<Mesh>) {
    let mut groups = Groups::of_vertices(mesh);
    let mut part_of: HashMap<usize, u32, FixedState> = HashMap::default();
    let number = |triangle: &[u32; 3]| {
        let count = part_of.len() as u32;
        *part_of.entry(groups.first(triangle[0] as usize)).or_insert(count)
    };
    let numbers: Vec<u32> = mesh.triangles.iter().map(number).collect();
    if part_of.len() < 2 {
        return (numbers, Vec::new());
    }
    let mut parts = vec![Vec::new(); part_of.len()];
    mesh.triangles.iter().zip(&numbers).for_each(|(triangle, &part)| parts[part as usize].push(*triangle));
    let of = |triangles: &Vec<[u32; 3]>| {
        let mut used: Vec<u32> = triangles.iter().flatten().copied().collect();
        used.sort_unstable();
        used.dedup();
        let number = |v: u32| used.binary_search(&v).unwrap_or(0) as u32;
        let vertices = used.iter().map(|&v| mesh.vertices[v as usize]).collect();
        Mesh { vertices, triangles: triangles.iter().map(|t| t.map(number)).collect() }
    };
    (numbers, parts.iter().map(of).collect())
}
