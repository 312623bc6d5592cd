//! The triangles of a closed mesh, gathered in regions, and the cuts that divide regions.

use std::collections::HashMap;

use geometry::mesh::{Mesh, unit_normal};
use geometry::weld::Weld;
use glam::DVec3;

use super::StepWriteError;

/// No region, no triangle.
pub(super) const NONE: u32 = u32::MAX;

/// A plane that a region was cut along: the points `p` with `normal . p = offset`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct CutPlane {
    /// Unit normal.
    pub(super) normal: DVec3,
    /// Distance of the plane from the origin (mm).
    pub(super) offset: f64,
}

impl CutPlane {
    /// The plane through a point.
    pub(super) fn through(point: DVec3, normal: DVec3) -> Self {
        Self { normal, offset: normal.dot(point) }
    }

    /// Signed distance of a point (mm).
    pub(super) fn height(&self, p: DVec3) -> f64 {
        self.normal.dot(p) - self.offset
    }
}

/// A closed surface of triangles. Cuts add vertices on sides, so that it stays closed.
#[derive(Debug, Clone)]
pub(super) struct Skin {
    /// Vertices, those at the same place being one (mm).
    pub(super) points: Vec<DVec3>,
    /// Counter-clockwise seen from outside.
    pub(super) triangles: Vec<[u32; 3]>,
    /// The region of each triangle.
    pub(super) region: Vec<u32>,
    /// The triangle of the mesh that each triangle is a part of.
    pub(super) source: Vec<u32>,
    /// The triangle of each directed side.
    sides: HashMap<(u32, u32), u32>,
}

fn undirected(a: u32, b: u32) -> (u32, u32) {
    (a.min(b), a.max(b))
}

/// The number of the next entry of a list.
fn next_number(len: usize) -> Result<u32, StepWriteError> {
    u32::try_from(len).map_err(|_| StepWriteError::TooLarge)
}

impl Skin {
    /// The triangles of `mesh`, all in region 0. Triangles two corners of which lie at the same place are left out.
    ///
    /// # Errors
    /// [`StepWriteError::NotClosed`] where a side has not exactly one triangle on both sides.
    pub(super) fn of(mesh: &Mesh) -> Result<Self, StepWriteError> {
        let mut weld = Weld::with_capacity(mesh.vertices.len());
        let number: Vec<u32> = mesh.vertices.iter().map(|&p| weld.add(p)).collect();
        let (mut triangles, mut source) = (Vec::new(), Vec::new());
        for (i, t) in mesh.triangles.iter().enumerate() {
            let corner = |k: usize| number.get(t[k] as usize).copied().ok_or(StepWriteError::Unusable);
            let [a, b, c] = [corner(0)?, corner(1)?, corner(2)?];
            if a != b && b != c && c != a {
                triangles.push([a, b, c]);
                source.push(next_number(i)?);
            }
        }
        let points = weld.into_points();
        if triangles.is_empty() || points.iter().any(|p| !p.is_finite()) {
            return Err(StepWriteError::Unusable);
        }
        let (sides, region) = (HashMap::with_capacity(triangles.len() * 3), vec![0; triangles.len()]);
        let mut skin = Self { points, triangles, region, source, sides };
        for i in 0..skin.triangles.len() {
            skin.enter(i)?;
        }
        let open = skin.triangles.iter().flat_map(|&t| sides_of(t)).find(|&(a, b)| !skin.sides.contains_key(&(b, a)));
        match open {
            Some((a, b)) => Err(StepWriteError::NotClosed { at: skin.middle(a, b) }),
            None => Ok(skin),
        }
    }

    /// Notes the sides of triangle `i`.
    fn enter(&mut self, i: usize) -> Result<(), StepWriteError> {
        let number = next_number(i)?;
        for (a, b) in sides_of(self.triangles[i]) {
            if self.sides.insert((a, b), number).is_some() {
                return Err(StepWriteError::NotClosed { at: self.middle(a, b) });
            }
        }
        Ok(())
    }

    fn middle(&self, a: u32, b: u32) -> DVec3 {
        0.5 * (self.points[a as usize] + self.points[b as usize])
    }

    /// Corners of triangle `i` (mm).
    pub(super) fn corners(&self, i: u32) -> [DVec3; 3] {
        self.triangles[i as usize].map(|v| self.points[v as usize])
    }

    /// Outward unit normal of triangle `i`; zero without area.
    pub(super) fn normal(&self, i: u32) -> DVec3 {
        unit_normal(self.corners(i))
    }

    /// The triangle with the directed side from `a` to `b`.
    pub(super) fn triangle_at(&self, a: u32, b: u32) -> u32 {
        self.sides.get(&(a, b)).copied().unwrap_or(NONE)
    }

    /// The region across the directed side from `a` to `b`, seen from the triangle that has it.
    pub(super) fn region_across(&self, a: u32, b: u32) -> u32 {
        self.region.get(self.triangle_at(b, a) as usize).copied().unwrap_or(NONE)
    }

    /// The triangles of every region, rising.
    pub(super) fn members(&self) -> Vec<Vec<u32>> {
        let count = self.region.iter().max().map_or(0, |&r| r as usize + 1);
        let mut members = vec![Vec::new(); count];
        for (i, &r) in (0u32..).zip(&self.region) {
            members[r as usize].push(i);
        }
        members
    }

    /// Numbers the pieces of every region that hang together as regions of their own, in the order of their first
    /// triangles; answers what region each was a part of.
    pub(super) fn separate(&mut self) -> Vec<u32> {
        let mut number = vec![NONE; self.triangles.len()];
        let mut origin = Vec::new();
        for seed in 0..self.triangles.len() {
            if number[seed] != NONE {
                continue;
            }
            let (old, new) = (self.region[seed], origin.len() as u32);
            origin.push(old);
            number[seed] = new;
            let mut open = vec![seed];
            while let Some(i) = open.pop() {
                for (a, b) in sides_of(self.triangles[i]) {
                    let j = self.triangle_at(b, a) as usize;
                    if j < number.len() && number[j] == NONE && self.region[j] == old {
                        number[j] = new;
                        open.push(j);
                    }
                }
            }
        }
        self.region = number;
        origin
    }

    /// Cuts region `region` along `plane`: the triangles above it become region `above`. Answers whether both sides
    /// have triangles; the skin may have got vertices even if not.
    ///
    /// A vertex nearer to the plane than `snap` of the length of a side counts as on it, so that no slivers arise.
    pub(super) fn cut(&mut self, region: u32, plane: CutPlane, snap: f64, above: u32) -> Result<bool, StepWriteError> {
        let members: Vec<u32> = (0u32..).zip(&self.region).filter(|(_, r)| **r == region).map(|(i, _)| i).collect();
        let sides = self.sides_of_plane(&members, plane, snap);
        let mut split = HashMap::new();
        for &i in &members {
            for (a, b) in sides_of(self.triangles[i as usize]) {
                let is_crossed = sides.get(&a).zip(sides.get(&b)).is_some_and(|(s, t)| s * t < 0);
                if is_crossed && !split.contains_key(&undirected(a, b)) {
                    let middle = self.add_on_side(a, b, plane)?;
                    split.insert(undirected(a, b), middle);
                }
            }
        }
        let mut touched = members.clone();
        touched.extend(members.iter().flat_map(|&i| sides_of(self.triangles[i as usize])).filter_map(|(a, b)| {
            let other = self.triangle_at(b, a);
            (split.contains_key(&undirected(a, b)) && self.region[other as usize] != region).then_some(other)
        }));
        touched.sort_unstable();
        touched.dedup();
        for i in touched {
            self.split_triangle(i, &split)?;
        }
        Ok(self.divide(region, plane, &sides, above))
    }

    /// On which side of the plane the vertices of triangles lie: -1, 0 or 1.
    fn sides_of_plane(&self, members: &[u32], plane: CutPlane, snap: f64) -> HashMap<u32, i32> {
        let mut sides: HashMap<u32, i32> = HashMap::new();
        let height = |v: u32| plane.height(self.points[v as usize]);
        for &i in members {
            for v in self.triangles[i as usize] {
                let h = height(v);
                sides.insert(
                    v,
                    if h.abs() < 1e-7 {
                        0
                    } else if h > 0.0 {
                        1
                    } else {
                        -1
                    },
                );
            }
        }
        for &i in members {
            for (a, b) in sides_of(self.triangles[i as usize]) {
                let (h, k) = (height(a), height(b));
                if h * k < 0.0 {
                    let share = h / (h - k);
                    if share < snap {
                        sides.insert(a, 0);
                    } else if share > 1.0 - snap {
                        sides.insert(b, 0);
                    }
                }
            }
        }
        sides
    }

    fn add_on_side(&mut self, a: u32, b: u32, plane: CutPlane) -> Result<u32, StepWriteError> {
        let (low, high) = undirected(a, b);
        let [p, q] = [low, high].map(|v| self.points[v as usize]);
        let (h, k) = (plane.height(p), plane.height(q));
        let number = next_number(self.points.len())?;
        self.points.push(p.lerp(q, h / (h - k)));
        Ok(number)
    }

    /// Puts a vertex in the middle of a side.
    pub(super) fn split_side(&mut self, (a, b): (u32, u32)) -> Result<(), StepWriteError> {
        let middle = next_number(self.points.len())?;
        self.points.push(self.middle(a.min(b), a.max(b)));
        let split = HashMap::from([(undirected(a, b), middle)]);
        for i in [self.triangle_at(a, b), self.triangle_at(b, a)] {
            self.split_triangle(i, &split)?;
        }
        Ok(())
    }

    /// Replaces a triangle by triangles over its corners and the points put on its sides.
    fn split_triangle(&mut self, i: u32, split: &HashMap<(u32, u32), u32>) -> Result<(), StepWriteError> {
        let t = self.triangles[i as usize];
        let mut outline = Vec::with_capacity(6);
        for (a, b) in sides_of(t) {
            outline.push((a, true));
            outline.extend(split.get(&undirected(a, b)).map(|&m| (m, false)));
        }
        if outline.len() == 3 {
            return Ok(());
        }
        for side in sides_of(t) {
            self.sides.remove(&side);
        }
        let pieces = fan(outline);
        for (k, piece) in pieces.into_iter().enumerate() {
            let at = if k == 0 { i as usize } else { self.triangles.len() };
            if k == 0 {
                self.triangles[at] = piece;
            } else {
                self.triangles.push(piece);
                self.region.push(self.region[i as usize]);
                self.source.push(self.source[i as usize]);
            }
            self.enter(at)?;
        }
        Ok(())
    }

    /// Gives the triangles of a region above the plane a new number.
    fn divide(&mut self, region: u32, plane: CutPlane, sides: &HashMap<u32, i32>, above: u32) -> bool {
        let (mut counts, mut moved) = ([0usize; 2], Vec::new());
        for i in 0..self.triangles.len() {
            if self.region[i] != region {
                continue;
            }
            let side: i32 = self.triangles[i].iter().map(|v| sides.get(v).copied().unwrap_or(0)).sum();
            let middle = self.corners(i as u32).iter().map(|&p| plane.height(p)).sum::<f64>();
            let is_above = if side != 0 { side > 0 } else { middle > 0.0 };
            counts[usize::from(is_above)] += 1;
            if is_above {
                moved.push(i);
            }
        }
        if counts.contains(&0) {
            return false;
        }
        for i in moved {
            self.region[i] = above;
        }
        true
    }
}

/// The directed sides of a triangle.
pub(super) fn sides_of([a, b, c]: [u32; 3]) -> [(u32, u32); 3] {
    [(a, b), (b, c), (c, a)]
}

/// Triangles over an outline of three corners (true) and points on sides (false), at most one on each side: corners
/// between two such points are cut off first, and what is left has no three points in a row on one side.
fn fan(mut outline: Vec<(u32, bool)>) -> Vec<[u32; 3]> {
    let mut pieces = Vec::new();
    while outline.len() > 3 {
        let n = outline.len();
        let (before, after) = (|k: usize| (k + n - 1) % n, |k: usize| (k + 1) % n);
        let ear = (0..n).find(|&k| outline[k].1 && !outline[before(k)].1 && !outline[after(k)].1);
        match ear {
            Some(k) => {
                pieces.push([outline[before(k)].0, outline[k].0, outline[after(k)].0]);
                outline.remove(k);
            }
            // One point on a side: from there to the corner across.
            None => {
                let k = outline.iter().position(|o| !o.1).unwrap_or(0);
                pieces.push([outline[k].0, outline[after(k)].0, outline[(k + 2) % n].0]);
                outline.remove(after(k));
            }
        }
    }
    pieces.push([outline[0].0, outline[1].0, outline[2].0]);
    pieces
}
