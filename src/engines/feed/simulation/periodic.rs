//! Whether a blisk's mesh is the same when it is turned from channel to channel.

use std::collections::{HashMap, HashSet};

use glam::{DMat3, DVec3};

use geometry::mesh::Mesh;
use task::{Cancel, Cancelled};

/// Vertices further apart than this (mm) are not taken for the same.
const SAME: f64 = 1e-3;
/// How many triangles are processed between two checks of the cancel flag.
const PER_CHECK: usize = 16384;

/// How far points of `blisk` are from the blisk at most (mm) when it is turned about X so that what is at one of
/// `turns` (rad) comes to 0. None unless vertices come to vertices one to one and every turned triangle is, corner by
/// corner, a triangle of the mesh: otherwise surfaces may be the same and not be known to be.
pub(super) fn error_of(
    blisk: &Mesh,
    turns: impl Iterator<Item = f64>,
    cancel: &Cancel,
) -> Result<Option<f64>, Cancelled> {
    let (mut worst, mut known): (f64, Option<Known>) = (0.0, None);
    for turn in turns.filter(|turn| *turn != 0.0) {
        let known = match &mut known {
            Some(known) => known,
            none => none.insert(Known::new(blisk, cancel)?),
        };
        match known.error(blisk, turn, cancel)? {
            Some(error) => worst = worst.max(error),
            None => return Ok(None),
        }
    }
    Ok(Some(worst))
}

/// Vertices by place and triangles by vertices.
struct Known {
    cells: HashMap<[i64; 3], Vec<u32>>,
    triangles: HashSet<[u32; 3]>,
}

impl Known {
    fn new(mesh: &Mesh, cancel: &Cancel) -> Result<Self, Cancelled> {
        let mut cells: HashMap<_, Vec<u32>> = HashMap::new();
        for (i, p) in mesh.vertices.iter().enumerate() {
            if i % PER_CHECK == 0 {
                cancel.check()?;
            }
            cells.entry(cell(*p)).or_default().push(i as u32);
        }
        let mut triangles = HashSet::with_capacity(mesh.triangles.len());
        for (i, triangle) in mesh.triangles.iter().enumerate() {
            if i % PER_CHECK == 0 {
                cancel.check()?;
            }
            triangles.insert(rotated(*triangle));
        }
        Ok(Self { cells, triangles })
    }

    fn error(&self, mesh: &Mesh, turn: f64, cancel: &Cancel) -> Result<Option<f64>, Cancelled> {
        let rotation = DMat3::from_rotation_x(-turn);
        let (mut image, mut worst) = (Vec::with_capacity(mesh.vertices.len()), 0.0f64);
        let mut is_taken = vec![false; mesh.vertices.len()];
        for (i, &p) in mesh.vertices.iter().enumerate() {
            if i % PER_CHECK == 0 {
                cancel.check()?;
            }
            let Some((vertex, distance)) = self.nearest(mesh, rotation * p) else { return Ok(None) };
            // Two vertices that come to one leave another without any.
            if std::mem::replace(&mut is_taken[vertex as usize], true) {
                return Ok(None);
            }
            worst = worst.max(distance);
            image.push(vertex);
        }
        for (i, triangle) in mesh.triangles.iter().enumerate() {
            if i % PER_CHECK == 0 {
                cancel.check()?;
            }
            if !self.triangles.contains(&rotated(triangle.map(|v| image[v as usize]))) {
                return Ok(None);
            }
        }
        Ok(Some(worst))
    }

    /// The nearest vertex within [`SAME`] of `p`, and how far it is.
    fn nearest(&self, mesh: &Mesh, p: DVec3) -> Option<(u32, f64)> {
        let [x, y, z] = cell(p);
        let around = (-1..=1).flat_map(|i| (-1..=1).flat_map(move |j| (-1..=1).map(move |k| [x + i, y + j, z + k])));
        let close = around.filter_map(|cell| self.cells.get(&cell)).flatten();
        let measured = close.map(|&v| (v, mesh.vertices[v as usize].distance(p)));
        measured.filter(|(_, d)| *d <= SAME).min_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0)))
    }
}

fn cell(p: DVec3) -> [i64; 3] {
    p.to_array().map(|v| (v / SAME).floor() as i64)
}

/// Triangle with its least vertex first.
fn rotated([a, b, c]: [u32; 3]) -> [u32; 3] {
    if a <= b && a <= c {
        [a, b, c]
    } else if b <= c {
        [b, c, a]
    } else {
        [c, a, b]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    /// Two sheets a third of a micrometre apart on one side of the axis, and one sheet on the other.
    #[test]
    fn two_sheets_are_not_taken_for_one() {
        let sheet = [DVec3::new(0.0, 0.0, 10.0), DVec3::new(1.0, 0.0, 10.0), DVec3::new(0.0, 1.0, 10.0)];
        let turned = |p: DVec3| DVec3::new(p.x, -p.y, -p.z);
        let mut vertices: Vec<DVec3> = sheet.into_iter().chain(sheet.map(turned)).collect();
        let alike = Mesh { vertices: vertices.clone(), triangles: vec![[0, 1, 2], [3, 4, 5]] };
        let error = |mesh: &Mesh| error_of(mesh, [0.0, PI].into_iter(), &Cancel::default()).unwrap();
        assert!(error(&alike).unwrap() < 1e-12);
        vertices.push(sheet[0] + DVec3::new(0.0, 0.0, 3e-4));
        let doubled = Mesh { vertices, triangles: vec![[0, 1, 2], [6, 1, 2], [3, 4, 5]] };
        assert_eq!(error(&doubled), None);
    }
}
