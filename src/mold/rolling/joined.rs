//! Columns that hang together.

use std::collections::HashMap;

use glam::{DVec2, DVec3, IVec2};

use super::columns::Column;
use crate::geometry::mesh::{Bounds, Mesh, normal_times_two_areas, unit_normal};

/// A connected piece of what is left.
#[derive(Debug, Clone, PartialEq)]
pub struct Remnant {
    /// Its columns, as indices.
    pub columns: Vec<u32>,
    /// Area in the plan (mm^2).
    pub plan_area: f64,
    /// Area on the mold (mm^2).
    pub area: f64,
    /// Volume (mm^3).
    pub volume: f64,
    /// Greatest height (mm).
    pub height: f64,
    /// Greatest height along the normal of the face below it (mm).
    pub depth: f64,
    /// The box around it.
    pub bounds: Bounds,
    /// Faces of the mold that it lies on, in order.
    pub faces: Vec<u32>,
}

/// The connected pieces of `columns` of `mesh`, the largest volume first. Columns are connected where they meet or come
/// as near as `near` (mm), and share a height. What is not left over by `tolerance` (mm) does not count.
pub fn remnants(mesh: &Mesh, columns: &[Column], near: f64, tolerance: f64) -> Vec<Remnant> {
    let mut sets = Sets((0..columns.len() as u32).collect());
    let mut squares: HashMap<IVec2, Vec<u32>> = HashMap::new();
    for (i, column) in columns.iter().enumerate() {
        let square = |p: DVec2| (p / near).floor().as_ivec2();
        let flat = column.corners.map(DVec3::truncate);
        let margin = DVec2::splat(1e-6 * near);
        let from = square(flat.iter().fold(DVec2::INFINITY, |m, p| m.min(*p)) - margin);
        let to = square(flat.iter().fold(DVec2::NEG_INFINITY, |m, p| m.max(*p)) + margin);
        for (x, y) in (from.x..=to.x).flat_map(|x| (from.y..=to.y).map(move |y| (x, y))) {
            let listed = squares.entry(IVec2::new(x, y)).or_default();
            let span = column.span();
            for &other in listed.iter() {
                let with = columns[other as usize].span();
                if span[0] <= with[1] && with[0] <= span[1] {
                    sets.join(i as u32, other);
                }
            }
            listed.push(i as u32);
        }
    }
    let mut own: HashMap<u32, Vec<u32>> = HashMap::new();
    for i in 0..columns.len() as u32 {
        own.entry(sets.root(i)).or_default().push(i);
    }
    let mut found: Vec<Remnant> = own.into_values().map(|own| remnant(mesh, columns, own, tolerance)).collect();
    let place = |r: &Remnant| r.columns.first().copied();
    found.sort_by(|a, b| b.volume.total_cmp(&a.volume).then(place(a).cmp(&place(b))));
    found
}

fn remnant(mesh: &Mesh, columns: &[Column], own: Vec<u32>, tolerance: f64) -> Remnant {
    let mut all = Remnant {
        columns: own,
        plan_area: 0.0,
        area: 0.0,
        volume: 0.0,
        height: 0.0,
        depth: 0.0,
        bounds: Bounds::EMPTY,
        faces: Vec::new(),
    };
    for &i in &all.columns {
        let column = &columns[i as usize];
        let normal = unit_normal(mesh.corners(column.face as usize));
        let (area, volume) = column.measure(normal, tolerance);
        all.plan_area += area;
        all.area += area / normal.z;
        all.volume += volume;
        all.faces.push(column.face);
        for (corner, left) in column.corners.iter().zip(column.left) {
            let height = left - corner.z;
            if height * normal.z > tolerance {
                all.height = all.height.max(height);
                all.depth = all.depth.max(height * normal.z);
                let ends = [*corner, corner.with_z(left)];
                all.bounds.min = all.bounds.min.min(ends[0]).min(ends[1]);
                all.bounds.max = all.bounds.max.max(ends[0]).max(ends[1]);
            }
        }
    }
    all.faces.sort_unstable();
    all.faces.dedup();
    all
}

impl Column {
    /// From the lowest of the face to the highest that is left.
    fn span(&self) -> [f64; 2] {
        let low = self.corners.iter().map(|c| c.z).fold(f64::INFINITY, f64::min);
        [low, self.left.iter().copied().fold(low, f64::max)]
    }

    /// Twice its area on the face (mm^2).
    pub fn two_areas(&self) -> f64 {
        normal_times_two_areas(self.corners).length()
    }
}

/// Sets of indices that are joined; the smallest one stands for its set.
struct Sets(Vec<u32>);

impl Sets {
    fn root(&mut self, mut i: u32) -> u32 {
        while self.0[i as usize] != i {
            let above = self.0[self.0[i as usize] as usize];
            self.0[i as usize] = above;
            i = above;
        }
        i
    }

    fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.root(a), self.root(b));
        self.0[a.max(b) as usize] = a.min(b);
    }
}
