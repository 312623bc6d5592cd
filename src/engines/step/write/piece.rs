//! The triangles of one region by themselves, with the lines around them.

use std::collections::HashMap;

use geometry::groups::Groups;
use geometry::mesh::Mesh;
use glam::DVec3;

use super::skin::{Skin, sides_of};

/// The triangles of a region with vertices of their own. Where the region touches itself in a vertex only, that vertex
/// comes as often as the region passes it, so that every vertex has one fan of triangles.
#[derive(Debug, Clone)]
pub(super) struct Piece {
    /// Vertices (mm).
    pub(super) points: Vec<DVec3>,
    /// Number of each vertex in the skin.
    pub(super) of_skin: Vec<u32>,
    /// Counter-clockwise seen from outside.
    pub(super) triangles: Vec<[u32; 3]>,
    /// The vertices of each line around it; the region lies on their left.
    pub(super) loops: Vec<Vec<u32>>,
    /// Vertices less sides plus triangles: 1 for a disc.
    pub(super) characteristic: i64,
}

impl Piece {
    /// The triangles `members` of `skin`, all of one region, whose vertices lie at `points`.
    pub(super) fn of(skin: &Skin, members: &[u32], points: &[DVec3]) -> Self {
        let corner_of = |triangle: u32, v: u32| {
            let n = members.binary_search(&triangle).ok()?;
            let k = skin.triangles[triangle as usize].iter().position(|w| *w == v)?;
            Some(3 * n + k)
        };
        let mut corners = Groups::of(3 * members.len());
        let (mut outer, mut inner_sides) = (Vec::new(), 0);
        for (n, &i) in members.iter().enumerate() {
            for (k, (a, b)) in sides_of(skin.triangles[i as usize]).into_iter().enumerate() {
                let (start, end) = (3 * n + k, 3 * n + (k + 1) % 3);
                let across = skin.triangle_at(b, a);
                match corner_of(across, a).zip(corner_of(across, b)) {
                    Some((a, b)) => {
                        corners.join(start, a);
                        corners.join(end, b);
                        inner_sides += 1;
                    }
                    None => outer.push((start, end)),
                }
            }
        }
        let (number, count) = corners.numbers();
        let mut of_skin = vec![0; count];
        for (n, &i) in members.iter().enumerate() {
            for (k, v) in skin.triangles[i as usize].into_iter().enumerate() {
                of_skin[number[3 * n + k] as usize] = v;
            }
        }
        let sides = inner_sides / 2 + outer.len();
        let next: HashMap<u32, u32> = outer.iter().map(|&(a, b)| (number[a], number[b])).collect();
        Self {
            points: of_skin.iter().map(|&v| points[v as usize]).collect(),
            of_skin,
            triangles: number.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect(),
            loops: loops(outer.iter().map(|&(a, _)| number[a]), &next),
            characteristic: count as i64 - sides as i64 + members.len() as i64,
        }
    }

    /// Whether it is a disc: without holes, handles, and with one line around it.
    pub(super) fn is_disc(&self) -> bool {
        self.characteristic == 1 && self.loops.len() == 1
    }

    /// The piece as a mesh.
    pub(super) fn mesh(&self) -> Mesh {
        Mesh { vertices: self.points.clone(), triangles: self.triangles.clone() }
    }

    /// By how much the line around the piece turns to the left at each vertex, measured along the surface (rad).
    pub(super) fn turns(&self) -> Vec<f64> {
        let mut turns = vec![std::f64::consts::PI; self.points.len()];
        for t in &self.triangles {
            for k in 0..3 {
                let [p, q, r] = [k, (k + 1) % 3, (k + 2) % 3].map(|c| self.points[t[c] as usize]);
                let (d, e) = (q - p, r - p);
                turns[t[k] as usize] -= d.cross(e).length().atan2(d.dot(e));
            }
        }
        turns
    }
}

fn loops(starts: impl Iterator<Item = u32>, next: &HashMap<u32, u32>) -> Vec<Vec<u32>> {
    let (mut is_used, mut found) = (HashMap::new(), Vec::new());
    for start in starts {
        let (mut around, mut at) = (Vec::new(), start);
        while is_used.insert(at, ()).is_none() {
            around.push(at);
            match next.get(&at) {
                Some(&then) => at = then,
                None => break,
            }
        }
        if !around.is_empty() {
            found.push(around);
        }
    }
    found
}
