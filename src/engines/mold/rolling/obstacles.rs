//! The faces of a mold, to find those near a place, and how a ball comes to rest on one.

use glam::{DVec2, DVec3, IVec2};

use geometry::mesh::{Mesh, unit_normal};
use task::{Cancel, Cancelled};

/// A face of the mold.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Face {
    /// Corners.
    pub corners: [DVec3; 3],
    /// Unit normal, outwards.
    pub normal: DVec3,
    min: DVec3,
    max: DVec3,
}

/// All faces, sorted into squares of the plan.
pub struct Obstacles {
    /// In the order of the mesh; faces without area are left out.
    pub faces: Vec<Face>,
    origin: DVec2,
    cell: f64,
    counts: IVec2,
    /// Where the faces of each square begin in `listed`.
    starts: Vec<u32>,
    listed: Vec<u32>,
}

impl Obstacles {
    /// Squares in all, at most.
    const MOST_SQUARES: f64 = 4e6;

    /// The faces of `mesh` in squares of size `cell` (mm) or, if these were too many, larger ones.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn new(mesh: &Mesh, cell: f64, cancel: &Cancel) -> Result<Self, Cancelled> {
        let mut faces: Vec<Face> = Vec::with_capacity(mesh.triangles.len());
        for corners in mesh.iter_corners() {
            cancel.check()?;
            faces.extend(Face::new(corners));
        }
        let min = faces.iter().fold(DVec3::INFINITY, |m, f| m.min(f.min)).truncate();
        let max = faces.iter().fold(DVec3::NEG_INFINITY, |m, f| m.max(f.max)).truncate();
        let size = (max - min).max(DVec2::ZERO);
        let cell = cell.max((size.x * size.y / Self::MOST_SQUARES).sqrt()).max(size.max_element() / 1e5).max(1e-9);
        let counts = if faces.is_empty() { IVec2::ONE } else { (size / cell).floor().as_ivec2() + 1 };
        let mut grid = Self { faces, origin: min, cell, counts, starts: Vec::new(), listed: Vec::new() };
        grid.fill(cancel)?;
        Ok(grid)
    }

    fn fill(&mut self, cancel: &Cancel) -> Result<(), Cancelled> {
        let squares = (self.counts.x * self.counts.y) as usize;
        let mut starts = vec![0u32; squares + 1];
        let index = |at: IVec2| (at.y * self.counts.x + at.x) as usize;
        for face in &self.faces {
            self.squares_of(face, cancel, |at| starts[index(at) + 1] += 1)?;
        }
        for i in 0..squares {
            starts[i + 1] += starts[i];
        }
        let mut listed = vec![0u32; starts[squares] as usize];
        let mut next = starts.clone();
        for (i, face) in self.faces.iter().enumerate() {
            self.squares_of(face, cancel, |at| {
                let at = &mut next[index(at)];
                listed[*at as usize] = i as u32;
                *at += 1;
            })?;
        }
        (self.starts, self.listed) = (starts, listed);
        Ok(())
    }

    /// Calls `found` with every square that the face lies in, and a few beside it: row by row, since long and narrow
    /// faces that run across would fill many squares with their box.
    fn squares_of(&self, face: &Face, cancel: &Cancel, mut found: impl FnMut(IVec2)) -> Result<(), Cancelled> {
        let [from, to] = self.range(face.min.truncate(), face.max.truncate());
        let corners = face.corners.map(DVec3::truncate);
        for y in from.y..=to.y {
            cancel.check()?;
            let [low, high] = [y, y + 1].map(|row| self.origin.y + f64::from(row) * self.cell);
            let (mut least, mut most) = (f64::INFINITY, f64::NEG_INFINITY);
            for k in 0..3 {
                let (a, b) = (corners[k], corners[(k + 1) % 3]);
                let along = |y: f64| {
                    if a.y == b.y { a.x } else { a.x + (b.x - a.x) * ((y - a.y) / (b.y - a.y)).clamp(0.0, 1.0) }
                };
                // Where the edge does not reach the row this is its end nearest to it: too much, but never too little.
                for x in [along(low), along(high)] {
                    (least, most) = (least.min(x), most.max(x));
                }
            }
            let rounding = 1e-6 * self.cell;
            let first = self.square(DVec2::new(least - rounding, low)).x.clamp(from.x, to.x);
            let last = self.square(DVec2::new(most + rounding, low)).x.clamp(from.x, to.x);
            (first..=last).for_each(|x| found(IVec2::new(x, y)));
        }
        Ok(())
    }

    fn square(&self, p: DVec2) -> IVec2 {
        ((p - self.origin) / self.cell).floor().clamp(DVec2::splat(-1.0), DVec2::splat(1e9)).as_ivec2()
    }

    fn range(&self, min: DVec2, max: DVec2) -> [IVec2; 2] {
        let most = self.counts - 1;
        [self.square(min).clamp(IVec2::ZERO, most), self.square(max).clamp(IVec2::ZERO, most)]
    }

    /// Calls `found` with every face whose box meets the box from `min` to `max`; large ones more than once.
    pub fn near<'a>(&'a self, min: DVec3, max: DVec3, mut found: impl FnMut(&'a Face)) {
        let [from, to] = self.range(min.truncate(), max.truncate());
        for y in from.y..=to.y {
            for x in from.x..=to.x {
                let square = (y * self.counts.x + x) as usize;
                for &i in &self.listed[self.starts[square] as usize..self.starts[square + 1] as usize] {
                    let face = &self.faces[i as usize];
                    if face.min.cmple(max).all() && face.max.cmpge(min).all() {
                        found(face);
                    }
                }
            }
        }
    }
}

/// A ball that only touches a wall on its way down passes it (mm^2).
const TANGENT: f64 = 1e-9;

impl Face {
    fn new(corners: [DVec3; 3]) -> Option<Self> {
        let [a, b, c] = corners;
        let normal = unit_normal(corners);
        let (min, max) = (a.min(b).min(c), a.max(b).max(c));
        (normal.is_normalized() && min.is_finite() && max.is_finite()).then_some(Self { corners, normal, min, max })
    }

    /// The box around it.
    pub fn bounds(&self) -> [DVec3; 2] {
        [self.min, self.max]
    }

    /// Point nearest to `p`.
    pub fn nearest(&self, p: DVec3) -> DVec3 {
        let [a, b, c] = self.corners;
        let off = self.normal.dot(p - a);
        let foot = p - self.normal * off;
        if self.holds(foot) {
            return foot;
        }
        let on_edges = [[a, b], [b, c], [c, a]].map(|[from, to]| {
            let along = to - from;
            from + along * ((p - from).dot(along) / along.length_squared()).clamp(0.0, 1.0)
        });
        on_edges.into_iter().fold(a, |best, q| if q.distance_squared(p) < best.distance_squared(p) { q } else { best })
    }

    /// Whether a point of its plane lies in it.
    fn holds(&self, q: DVec3) -> bool {
        let [a, b, c] = self.corners;
        [[a, b], [b, c], [c, a]].iter().all(|[from, to]| (*to - *from).cross(q - *from).dot(self.normal) >= 0.0)
    }

    /// Height of the centre of a ball of `radius` (mm) that is let down along Z at `p` until it rests on the face; none
    /// if it passes.
    pub fn rest(&self, p: DVec2, radius: f64) -> Option<f64> {
        let [a, b, c] = self.corners;
        let on_corner = |v: DVec3| {
            let rise = radius * radius - v.truncate().distance_squared(p);
            (rise > TANGENT).then(|| v.z + rise.sqrt())
        };
        let up = if self.normal.z < 0.0 { -self.normal } else { self.normal };
        let on_inside = (up.z > 1e-9).then(|| {
            let z = a.z + (radius - up.truncate().dot(p - a.truncate())) / up.z;
            self.holds(p.extend(z) - up * radius).then_some(z)
        });
        let on_edges = [[a, b], [b, c], [c, a]].map(|edge| rest_on_edge(edge, p, radius));
        let all = self.corners.map(on_corner).into_iter().chain(on_edges).chain(on_inside).flatten();
        all.max_by(f64::total_cmp)
    }
}

fn rest_on_edge([from, to]: [DVec3; 2], p: DVec2, radius: f64) -> Option<f64> {
    let length = from.distance(to);
    let along = (to - from) / length;
    let off = p - from.truncate();
    // |w|^2 - (w . along)^2 = radius^2 for w = (off, t).
    let level = off.dot(along.truncate());
    let a = 1.0 - along.z * along.z;
    if a < 1e-12 {
        return None;
    }
    let half_b = -along.z * level;
    let c = off.length_squared() - level * level - radius * radius;
    let root = half_b * half_b - a * c;
    let t = (root > TANGENT * a).then(|| (-half_b + root.sqrt()) / a)?;
    let foot = level + along.z * t;
    (0.0..=length).contains(&foot).then_some(from.z + t)
}
