//! The surface of a mold where it bounds what is left: triangles, split along the boundary.
//!
//! Floors lie under what is left, walls beside it: a point of the surface belongs to a region if the grid's cell just
//! outside it does and the point is no higher than the cutters leave there. A triangle is halved until all of it does,
//! none of it does, or it is as small as two cells: the boundary is that fine. Faces that look down are never uncut:
//! they are invert. Free forms under a rounded cutter have a boundary everywhere; where their pieces would be too many
//! for a computer's memory, all of the surface is split half as finely, and so on.

use serde::{Deserialize, Serialize};
use std::sync::atomic::{AtomicUsize, Ordering};

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::height_field::{Cover, Covered};
use geometry::mesh::{Mesh, unit_normal};
use task::{Cancel, Cancelled};

/// Longest side of the smallest triangles, in cells.
const FINENESS: f64 = 2.0;
/// How far outside the surface the grid is asked, in cells times the horizontal part of the normal.
const BESIDE: f64 = 0.75;
/// By how many cells a point may lie below the material of the cell beside it, which has one height for all of the
/// cell.
const BELOW: f64 = 2.5;
/// The z component of the unit normal below which a face is a wall, which may stand out of what is left.
const WALL: f64 = 0.5;
/// The z component of the unit normal below which a face looks down.
const INVERT: f64 = -1e-3;
/// How far heights of the grid may be off: single precision, and a rounded cutter that sags between two places (mm).
const ROUNDING: f64 = 3e-4;
/// Pieces at most, beside one of each triangle: some 100 bytes each, here and once more for the screen.
const MOST_PIECES: usize = 2_000_000;
/// Halvings at most: a triangle of a kilometre comes down to a micrometre.
const MOST_HALVINGS: usize = 60;

/// Part of a mold's triangle that bounds what is left.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct SurfacePiece {
    /// Corners, turning as those of the triangle do (mm).
    pub corners: [DVec3; 3],
    /// The triangle of the mesh that it is of.
    pub face: u32,
    /// The region that it bounds: its place in the list.
    pub region: u32,
    /// Height of what is left above each corner (mm).
    pub depth: [f32; 3],
}

impl SurfacePiece {
    /// Least and greatest height (mm).
    pub fn span(&self) -> [f64; 2] {
        let heights = self.corners.map(|p| p.z);
        heights.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], z| [low.min(*z), high.max(*z)])
    }

    /// Area (mm^2).
    pub fn area(&self) -> f64 {
        let [a, b, c] = self.corners;
        0.5 * (b - a).cross(c - a).length()
    }
}

/// Where the pieces of a surface pass just above the height `z` (mm): the segments of that layer that the cutters do
/// not touch, each with its region.
pub fn segments_at(pieces: &[SurfacePiece], z: f64) -> Vec<(u32, [DVec3; 2])> {
    let crossing = |a: DVec3, b: DVec3| ((a.z <= z) != (b.z <= z)).then(|| a.lerp(b, (z - a.z) / (b.z - a.z)));
    let segment = |piece: &SurfacePiece| {
        let [a, b, c] = piece.corners;
        let mut ends = [crossing(a, b), crossing(b, c), crossing(c, a)].into_iter().flatten();
        Some((piece.region, [ends.next()?, ends.next()?]))
    };
    pieces.iter().filter_map(segment).collect()
}

/// The parts of a mold's surface that bound what is left.
#[derive(Debug, Clone, PartialEq)]
pub struct UncutSurface {
    /// The pieces, in the order of the mold's triangles.
    pub pieces: Vec<SurfacePiece>,
    /// How far their boundary may be off (mm): the longest side of the smallest triangles.
    pub fineness: f64,
    /// Whether that is more than it would be if a computer held any number of pieces.
    pub is_coarse: bool,
}

/// The parts of `mesh`, which opens along +Z, that bound regions.
///
/// # Errors
/// [`Cancelled`].
pub fn uncut_surface(mesh: &Mesh, covered: &Covered, cancel: &Cancel) -> Result<UncutSurface, Cancelled> {
    surface_within(mesh, covered, MOST_PIECES, cancel)
}

/// Surface pieces, at most `most` plus one for each triangle.
fn surface_within(mesh: &Mesh, covered: &Covered, most: usize, cancel: &Cancel) -> Result<UncutSurface, Cancelled> {
    let finest = FINENESS * covered.step();
    let mut split = Split { mesh, covered, cancel, fineness: finest, most: most.saturating_add(mesh.triangles.len()) };
    // Once the smallest triangles are those of the mesh there is one piece of each at most.
    loop {
        if let Some(pieces) = split.pieces()? {
            let fineness = split.fineness;
            return Ok(UncutSurface { pieces, fineness, is_coarse: fineness > finest });
        }
        split.fineness *= 2.0;
    }
}

/// A mold that is split into pieces.
struct Split<'a> {
    mesh: &'a Mesh,
    covered: &'a Covered<'a>,
    cancel: &'a Cancel,
    /// Longest side of the smallest triangles (mm).
    fineness: f64,
    /// Pieces at most.
    most: usize,
}

impl Split<'_> {
    /// The pieces; none if they are too many.
    fn pieces(&self) -> Result<Option<Vec<SurfacePiece>>, Cancelled> {
        let count = AtomicUsize::new(0);
        let of_face = |face: usize| -> Result<Vec<SurfacePiece>, Cancelled> {
            self.cancel.check()?;
            let corners = self.mesh.corners(face);
            let normal = unit_normal(corners);
            let mut pieces = Vec::new();
            // A face without area has no normal.
            if normal != DVec3::ZERO && normal.z >= INVERT {
                let beside = normal.with_z(0.0) * BESIDE * self.covered.step();
                let face = Face { of: self, count: &count, normal, beside, face: face as u32 };
                face.split(corners, MOST_HALVINGS, &mut pieces)?;
            }
            Ok(pieces)
        };
        let pieces: Vec<Vec<SurfacePiece>> =
            (0..self.mesh.triangles.len()).into_par_iter().map(of_face).collect::<Result<_, _>>()?;
        Ok((count.into_inner() <= self.most).then(|| pieces.concat()))
    }
}

struct Face<'a> {
    of: &'a Split<'a>,
    /// Pieces of all faces so far.
    count: &'a AtomicUsize,
    normal: DVec3,
    /// From the surface to where the grid is asked (mm).
    beside: DVec3,
    face: u32,
}

impl Face<'_> {
    fn split(&self, corners: [DVec3; 3], halvings: usize, pieces: &mut Vec<SurfacePiece>) -> Result<(), Cancelled> {
        self.of.cancel.check()?;
        // What is more will be thrown away.
        if self.count.load(Ordering::Relaxed) > self.of.most {
            return Ok(());
        }
        let [a, b, c] = corners;
        let (low, high) = (a.z.min(b.z).min(c.z), a.z.max(b.z).max(c.z));
        let slack = BELOW * self.of.covered.step();
        let whole = match self.cover(corners) {
            Cover::Nothing => return Ok(()),
            Cover::Partly => None,
            // Under other material, or above what is left.
            Cover::Wholly { from, to, .. } if high < from[0] - slack || low > to[1] + ROUNDING => return Ok(()),
            // What is left over a floor reaches above it everywhere unless something else is over it; beside a wall it
            // may end halfway up.
            Cover::Wholly { region, from, to } => {
                let is_whole = if self.normal.z >= WALL { from[1] <= high + slack } else { to[0] >= high - ROUNDING };
                is_whole.then_some(region)
            }
        };
        let middle = (a + b + c) / 3.0;
        let is_visible = || [a, b, c, middle].iter().all(|p| self.left_at(*p).is_some());
        if let Some(region) = whole.filter(|_| is_visible()) {
            self.keep(self.piece(corners, region), pieces);
            return Ok(());
        }
        let sides = [b - a, c - b, a - c].map(DVec3::length);
        let longest = (0..3).max_by(|i, j| sides[*i].total_cmp(&sides[*j])).unwrap_or(0);
        if sides[longest] <= self.of.fineness || halvings == 0 {
            if let Some((region, _)) = self.left_at(middle) {
                self.keep(self.piece(corners, region), pieces);
            }
            return Ok(());
        }
        let [from, to, tip] = [0, 1, 2].map(|k| corners[(longest + k) % 3]);
        let half = 0.5 * (from + to);
        self.split([from, half, tip], halvings - 1, pieces)?;
        self.split([half, to, tip], halvings - 1, pieces)
    }

    fn keep(&self, piece: SurfacePiece, pieces: &mut Vec<SurfacePiece>) {
        self.count.fetch_add(1, Ordering::Relaxed);
        pieces.push(piece);
    }

    /// Residual stock beside or over a part of the face. A wall that is less than a cell wide in plan is a line there:
    /// its box would hold what lies behind it.
    fn cover(&self, corners: [DVec3; 3]) -> Cover {
        let plan = corners.map(|p| (p + self.beside).truncate());
        let across = self.normal.truncate().normalize_or_zero();
        let extent = |direction: DVec2| {
            let along = plan.map(|p| p.dot(direction));
            [along[0].min(along[1]).min(along[2]), along[0].max(along[1]).max(along[2])]
        };
        let [near, far] = extent(across);
        if self.normal.z < WALL && far - near < self.of.covered.step() {
            let [from, to] = extent(across.perp());
            let at = |along: f64| across * 0.5 * (near + far) + across.perp() * along;
            return self.of.covered.along(at(from), at(to));
        }
        self.of.covered.over(plan[0].min(plan[1]).min(plan[2]), plan[0].max(plan[1]).max(plan[2]))
    }

    /// The region that a point of the surface bounds, and how far what is left reaches above it (mm).
    fn left_at(&self, p: DVec3) -> Option<(usize, f64)> {
        let left = self.of.covered.at((p + self.beside).truncate())?;
        let is_hidden = p.z < left.low - BELOW * self.of.covered.step();
        (!is_hidden && p.z <= left.high + ROUNDING).then_some((left.region, (left.high - p.z).max(0.0)))
    }

    fn piece(&self, corners: [DVec3; 3], region: usize) -> SurfacePiece {
        let middle = (corners[0] + corners[1] + corners[2]) / 3.0;
        let top = self.left_at(middle).map_or(middle.z, |(_, depth)| middle.z + depth);
        // A corner on the boundary may lie over a cell of which nothing is left.
        let depth = |p: DVec3| self.left_at(p).map_or((top - p.z).max(0.0), |(_, depth)| depth) as f32;
        SurfacePiece { corners, face: self.face, region: region as u32, depth: corners.map(depth) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cutter::{Cutter, CutterLibrary};
    use crate::fixtures::{dish, pocket, rectangle};
    use crate::height_field::{FieldRegion, HeightField, closing, regions};

    const STEP: f64 = 0.05;

    fn surface(mesh: &Mesh, cutter: Cutter) -> (Vec<SurfacePiece>, Vec<FieldRegion>) {
        let cancel = Cancel::default();
        let field = HeightField::raster(mesh, STEP, &cancel).unwrap();
        let closing = closing(&field, &CutterLibrary { cutter: vec![cutter] }, &cancel).unwrap();
        let found = regions(&field, &closing, 0.02, &cancel).unwrap();
        let surface = uncut_surface(mesh, &Covered::new(&field, &closing, &found), &cancel).unwrap();
        assert!(!surface.is_coarse && surface.fineness == 2.0 * STEP);
        (surface.pieces, found)
    }

    /// Area of the pieces whose normals look this steeply upwards.
    fn area(mesh: &Mesh, pieces: &[SurfacePiece], upness: std::ops::RangeInclusive<f64>) -> f64 {
        let upright = |p: &&SurfacePiece| upness.contains(&unit_normal(mesh.corners(p.face as usize)).z);
        pieces.iter().filter(upright).map(SurfacePiece::area).sum()
    }

    #[test]
    fn floor_and_walls_of_a_slot_too_narrow_for_the_cutter_are_uncut_whole() {
        let slot = rectangle(10.0, 1.9);
        let mesh = pocket(&rectangle(20.0, 12.0), &slot, &slot, [9.0, 6.0]);
        let (pieces, found) = surface(&mesh, Cutter::flat(1.0));
        assert_eq!(found.len(), 1);
        let (floor, walls) = (area(&mesh, &pieces, 0.9..=1.0), area(&mesh, &pieces, -0.1..=0.1));
        // Each side ends within two cells of where it should.
        assert!((floor - 19.0).abs() < 2.0 * STEP * 23.8, "{floor}");
        assert!((walls - 23.8 * 6.0).abs() < 2.0 * STEP * 23.8, "{walls}");
        let depths = pieces.iter().flat_map(|p| p.corners.iter().zip(p.depth));
        depths.for_each(|(p, depth)| assert!((9.0 - p.z - f64::from(depth)).abs() < 1e-4, "{p} {depth}"));
        let length: f64 = segments_at(&pieces, 6.0).iter().map(|(_, [a, b])| a.distance(*b)).sum();
        assert!((length - 23.8).abs() < 16.0 * STEP, "{length}");
        assert!(segments_at(&pieces, 2.9).is_empty() && segments_at(&pieces, 9.1).is_empty());
    }

    #[test]
    fn in_the_corners_of_a_pocket_they_end_where_the_residue_is_thinner_than_the_tolerance() {
        let sides = rectangle(10.0, 8.0);
        let mesh = pocket(&rectangle(20.0, 16.0), &sides, &sides, [9.0, 6.0]);
        let (pieces, found) = surface(&mesh, Cutter::flat(2.0));
        assert_eq!(found.len(), 4);
        let floor = area(&mesh, &pieces, 0.9..=1.0);
        let corner = 4.0 * (1.0 - std::f64::consts::FRAC_PI_4);
        assert!((floor - 4.0 * corner).abs() < 0.05 * 4.0 * corner, "{floor}");
        // Beside a wall the cutter's circle comes as near as a cell at sqrt(2 R cell) before it touches.
        let walls = area(&mesh, &pieces, -0.1..=0.1) / (4.0 * 2.0 * 6.0);
        let lost = |cells: f64| (2.0 * 2.0 * cells * STEP).sqrt();
        assert!((2.0 - lost(2.0)..=2.0 - lost(0.4)).contains(&walls), "{walls}");
        let own: Vec<_> = (0..4).map(|r| pieces.iter().filter(|p| p.region == r).count()).collect();
        assert!(own.iter().all(|n| *n > 10), "{own:?}");
        for piece in &pieces {
            let [a, b, c] = mesh.corners(piece.face as usize);
            let normal = unit_normal([a, b, c]);
            assert!(piece.corners.iter().all(|p| (*p - a).dot(normal).abs() < 1e-9), "it lies on its triangle");
            assert!(unit_normal(piece.corners).dot(normal) > 1.0 - 1e-6, "it turns as its triangle");
            let bounds = found[piece.region as usize].bounds.grown(3.0 * STEP);
            assert!(piece.corners.iter().all(|p| p.clamp(bounds.min, bounds.max) == *p), "{piece:?}");
        }
    }

    #[test]
    fn sloping_walls_are_split_where_the_cutter_begins_to_touch() {
        // A groove of 90 degrees, 4 mm wide: a flat cutter of radius 1 stops 1 mm above its ground.
        let level = |half: f64| rectangle(12.0 + 2.0 * half, 2.0 * half);
        let mesh = dish(&rectangle(30.0, 12.0), &[(level(2.0), 5.0), (level(1e-3), 3.001)], 3.001);
        let (pieces, _) = surface(&mesh, Cutter::flat(1.0));
        let slopes: Vec<_> = pieces.iter().filter(|p| p.corners.iter().all(|q| q.x.abs() < 5.0)).collect();
        let highest = slopes.iter().flat_map(|p| p.corners).map(|p| p.z).fold(0.0, f64::max);
        assert!((highest - 4.0).abs() < 3.0 * STEP, "{highest}");
        let length: f64 = segments_at(&pieces, 3.5).iter().map(|(_, [a, b])| a.distance(*b)).sum();
        assert!((length - 2.0 * (13.0 + 1.0)).abs() < 0.3, "both slopes and both ends: {length}");
    }

    #[test]
    fn where_pieces_are_too_many_all_of_them_are_coarser() {
        let sides = rectangle(10.0, 8.0);
        let mesh = pocket(&rectangle(20.0, 16.0), &sides, &sides, [9.0, 6.0]);
        let cancel = Cancel::default();
        let field = HeightField::raster(&mesh, STEP, &cancel).unwrap();
        let closing = closing(&field, &CutterLibrary { cutter: vec![Cutter::ball(2.0)] }, &cancel).unwrap();
        let found = regions(&field, &closing, 0.02, &cancel).unwrap();
        let covered = Covered::new(&field, &closing, &found);
        let within = |most: usize| surface_within(&mesh, &covered, most, &cancel).unwrap();
        let area = |surface: &UncutSurface| surface.pieces.iter().map(SurfacePiece::area).sum::<f64>();
        let finest = within(usize::MAX);
        assert!(finest.pieces.len() > 2000, "{}", finest.pieces.len());
        assert!(finest == within(finest.pieces.len()) && finest == uncut_surface(&mesh, &covered, &cancel).unwrap());
        for most in [finest.pieces.len() / 4, 100, 0] {
            let coarse = within(most);
            assert!(coarse.is_coarse && coarse.pieces.len() <= most + mesh.triangles.len(), "{most}");
            // It is the finest that there is room for: halves of halves of what two cells are.
            let doublings = (coarse.fineness / finest.fineness).log2();
            assert!(doublings >= 1.0 && doublings.fract() == 0.0, "{}", coarse.fineness);
            // The boundary of what is left runs once around the floor, and once around the walls.
            let off = (area(&coarse) - area(&finest)).abs();
            assert!(off < coarse.fineness * 2.0 * 36.0, "{most}: {off} with pieces of {} mm", coarse.fineness);
        }
    }
}
