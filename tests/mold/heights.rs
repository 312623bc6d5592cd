//! Rest material of a mold by its definition alone: heights by rays of another library, and every cutter set down at
//! every place. Nothing of it is the program's own, and nothing is fast.

use geometry::mesh::Mesh;
use glam::DVec3;
use parry3d_f64::query::{Ray, RayCast};
use parry3d_f64::shape::TriMesh;

/// Height where there is no material.
const NONE: f32 = -1e4;

/// A cutter that comes from above: radius and radius of its rounded edge (mm), 0 of a flat one.
#[derive(Debug, Clone, Copy)]
pub struct Tool {
    pub radius: f64,
    pub corner: f64,
}

impl Tool {
    /// Height of its surface above its tip (mm) at this distance from its axis.
    fn height(self, off: f64) -> Option<f64> {
        let over = (off - (self.radius - self.corner)).max(0.0);
        (off <= self.radius).then(|| self.corner - (self.corner * self.corner - over * over).max(0.0).sqrt())
    }
}

/// Lower or upper bound of what is left.
#[derive(Debug, Clone, Copy)]
pub enum Bound {
    Least,
    Most,
}

/// A mold seen from above.
pub struct Heights {
    step: f64,
    columns: usize,
    corner: DVec3,
    /// Topmost material of each place, and the upward part of its unit normal.
    top: Vec<f32>,
    upward: Vec<f32>,
    /// Whether there is stock at all: material, or an opening that it encloses.
    stock: Vec<bool>,
}

/// Stock left at one place (mm): its middle, its height, and how many of the four places beside it have none.
#[derive(Debug, Clone, Copy)]
pub struct Left {
    pub middle: DVec3,
    pub height: f64,
    sides: usize,
}

impl Heights {
    /// Heights of a mold whose opening looks along +Z, with places `step` apart (mm), and room for a cutter of `radius` beside it.
    pub fn new(mold: &Mesh, step: f64, radius: f64) -> Self {
        let (bounds, room) = (mold.bounds(), radius + 4.0 * step);
        let solid = TriMesh::new(mold.vertices.clone(), mold.triangles.clone()).unwrap();
        let corner = bounds.min - DVec3::new(room + 0.37 * step, room + 0.61 * step, 0.0);
        let [columns, rows] = [0, 1].map(|k| ((bounds.max[k] + room - corner[k]) / step).ceil() as usize + 1);
        let (mut top, mut upward) = (vec![NONE; columns * rows], vec![1.0; columns * rows]);
        for place in 0..columns * rows {
            let at = corner + DVec3::new((place % columns) as f64, (place / columns) as f64, 0.0) * step;
            let ray = Ray::new(at.with_z(bounds.max.z + 1.0), DVec3::NEG_Z);
            if let Some(hit) = solid.cast_local_ray_and_get_normal(&ray, 1e4, false) {
                top[place] = (bounds.max.z + 1.0 - hit.time_of_impact) as f32;
                upward[place] = hit.normal.z.abs() as f32;
            }
        }
        let mut stock = vec![true; top.len()];
        let mut outside = vec![0];
        while let Some(place) = outside.pop() {
            if top[place] > NONE || !std::mem::take(&mut stock[place]) {
                stock[place] |= top[place] > NONE;
                continue;
            }
            let (x, y) = (place % columns, place / columns);
            outside.extend((x > 0).then(|| place - 1));
            outside.extend((x + 1 < columns).then(|| place + 1));
            outside.extend((y > 0).then(|| place - columns));
            outside.extend((y + 1 < rows).then(|| place + columns));
        }
        Self { step, columns, corner, top, upward, stock }
    }

    /// Stock that the best of the cutters leaves thicker than `tolerance` (mm) across the mold's surface: no more than there is,
    /// or no less. A place that a cutter may take lies half a diagonal of the grid from one where it is tried.
    pub fn left(&self, tools: &[Tool], bound: Bound, tolerance: f64) -> Vec<Left> {
        let aside = 0.5f64.sqrt() * self.step;
        let [tip, cut] = match bound {
            Bound::Least => [aside, -aside],
            Bound::Most => [-aside, 0.0],
        };
        let mut left = vec![f32::INFINITY; self.top.len()];
        for tool in tools {
            for (left, by) in left.iter_mut().zip(self.closed(*tool, tip, cut)) {
                *left = left.min(by);
            }
        }
        let bottom = self.corner.z as f32;
        let heights: Vec<f32> = left.iter().zip(&self.top).map(|(stands, top)| stands - top.max(bottom)).collect();
        let is_left = |place: usize| self.stock[place] && f64::from(heights[place] * self.upward[place]) > tolerance;
        let of = |place: usize| {
            let beside = [place - 1, place + 1, place - self.columns, place + self.columns];
            let at = self.corner.truncate() + self.place(place) * self.step;
            let middle = at.extend(f64::from(left[place] - 0.5 * heights[place]));
            let sides = beside.into_iter().filter(|beside| !is_left(*beside)).count();
            Left { middle, height: f64::from(heights[place]), sides }
        };
        // There is room around the mold: no place with stock is an outermost one.
        (0..left.len()).filter(|place| is_left(*place)).map(of).collect()
    }

    fn place(&self, place: usize) -> glam::DVec2 {
        glam::DVec2::new((place % self.columns) as f64, (place / self.columns) as f64)
    }

    /// Heights at which a cutter that was everywhere leaves the stock. Its tip stands where its surface meets the material if all
    /// of that lies `tip` further off its axis, and it cuts as if all of the stock lay `cut` further off.
    fn closed(&self, tool: Tool, tip: f64, cut: f64) -> Vec<f32> {
        let reach = (tool.radius / self.step).ceil() as isize + 1;
        let around = |further: f64| {
            let places = (-reach..=reach).flat_map(|y| (-reach..=reach).map(move |x| (x, y)));
            let off = |(x, y): (isize, isize)| ((x as f64).hypot(y as f64) * self.step + further).max(0.0);
            let above = places.filter_map(|(x, y)| Some((x, y, tool.height(off((x, y)))? as f32)));
            above.collect::<Vec<_>>()
        };
        let (against, under) = (around(tip), around(cut));
        let mut tip = vec![NONE; self.top.len()];
        for &(x, y, height) in &against {
            self.shifted(&mut tip, &self.top, (x, y), |tip, top| tip.max(top - height));
        }
        let mut closed = vec![f32::INFINITY; self.top.len()];
        for &(x, y, height) in &under {
            self.shifted(&mut closed, &tip, (x, y), |closed, tip| closed.min(tip + height));
        }
        closed
    }

    /// Combines each place with the one that lies so many columns and rows further.
    fn shifted(&self, own: &mut [f32], other: &[f32], (x, y): (isize, isize), with: impl Fn(f32, f32) -> f32) {
        let by = y * self.columns as isize + x;
        let (from, to) = (by.max(0) as usize, (-by).max(0) as usize);
        for (own, other) in own[to..].iter_mut().zip(&other[from..]) {
            *own = with(*own, *other);
        }
    }

    /// Volume of such stock (mm^3), no more or no less than it is: it ends up to half a step before or beyond its outermost
    /// places.
    pub fn volume(&self, left: &[Left], bound: Bound) -> f64 {
        let beyond = match bound {
            Bound::Least => -0.5,
            Bound::Most => 0.5,
        };
        let share = |left: &Left| (1.0 + beyond * left.sides as f64).max(0.0);
        left.iter().map(|left| left.height * share(left)).sum::<f64>() * self.step * self.step
    }
}
