//! The tip of an electrode: a prism over a region, as far as the mold and the spark gap leave room for it.

use std::collections::BTreeSet;

use glam::{DVec2, DVec3};

use super::burning::Burning;
use super::division::CELL;
use super::footprint::{grown, grown_pieces, shrunk};
use super::params::{Method, Stage};
use crate::outline::Outline;
use crate::plane;
use crate::plane::Shape;
use crate::section::sections;
use geometry::mesh::{Bounds, Mesh, normal_times_two_areas, unit_normal};
use geometry::solid;
use geometry::solid::{SolidError, Trimmer};
use rayon::prelude::*;
use task::{Cancel, Cancelled};

/// How far below the rim of what is left a tip's walls are cut off and led straight up (mm).
const BELOW_RIM: f64 = 1e-3;
/// How far a prism reaches into the walls that trim it (mm), so that no two faces of solids lie in one another.
pub(super) const SKIN: f64 = 0.02;
/// A tip stands over a box or a hull around its region unless that is this much larger than what surrounds it closely.
const WIDE: f64 = 2.0;
/// Cells of a region in plan at most.
const MOST_CELLS: f64 = 2e6;
/// Cells of a margin, into which a region is divided in plan.
const CELLS: f64 = 6.0;
/// Cells across a footprint where the share of a region in a part matters.
const FINE_CELLS: f64 = 24.0;
/// How far a point of the cap may be off (mm): more than what slivers that become points move it by.
const ON_CAP: f64 = 2e-5;
/// Smaller holes of a footprint are none (mm^2).
const LEAST_HOLE: f64 = 5e-3;
/// Upwards part of a normal below which a face is a wall.
const WALL: f64 = 0.2;

/// Reason why there is no tip.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum TipError {
    /// The gap leaves no room.
    #[error("the region is narrower than twice the spark gap: reduce the spark gap")]
    NoRoom,
    /// Nothing of the mold's surface is known to bound the region.
    #[error(
        "no part of the mold's surface was found to bound the region, so that there is nothing to make a tip for: find \
         what is left with a finer grid"
    )]
    NoSurface,
    /// A body that encloses nothing.
    #[error(
        "the head does not close where the mold bounds it; change the margin of the heads or the gap, or divide the region"
    )]
    Solid(SolidError),
    /// Told to stop.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

impl TipError {
    /// Whether there is no head for this region, rather than that the work was stopped.
    pub(super) fn is_no_head(&self) -> bool {
        !matches!(self, Self::Cancelled(_))
    }
}

impl From<SolidError> for TipError {
    fn from(error: SolidError) -> Self {
        match error {
            SolidError::Cancelled(cancelled) => Self::Cancelled(cancelled),
            other => Self::Solid(other),
        }
    }
}

/// The mold as the electrodes see it, in the burn frame.
#[derive(Clone, Copy)]
pub struct Burned<'a> {
    /// Volume that electrodes must stay above.
    pub kept_clear: &'a Mesh,
    /// The kept-clear volume around the tips made ready to trim them by.
    pub trimmer: &'a Trimmer,
    /// The gap upwards (mm): how far horizontal faces are moved.
    pub gap_up: f64,
    /// The gap across (mm): how far upright faces are moved at most.
    pub gap_across: f64,
    /// The stage.
    pub stage: &'a Stage,
    /// Places of the region's surface (mm).
    pub places: &'a [DVec3],
}

impl<'a> Burned<'a> {
    /// The kept-clear volume around the tips of a footprint and of its parts, made ready to trim them by; none where it
    /// cannot be cut out.
    pub(super) fn around(&self, footprint: &Footprint) -> Option<Trimmer> {
        /// How far beyond the footprint it reaches (mm): off all faces of tips.
        const BEYOND: f64 = 0.613;
        let [from, to] = plane::extent(&footprint.outlines);
        let bounds = Bounds { min: from.extend(footprint.low), max: to.extend(footprint.cap) };
        self.trimmer.within(&bounds.grown(BEYOND)).ok()
    }

    /// The mold as seen here, with another part of the kept-clear volume to trim tips by, if there is one.
    pub(super) fn trimmed_by<'b>(&self, trimmer: Option<&'b Trimmer>) -> Burned<'b>
    where
        'a: 'b,
    {
        Burned { trimmer: trimmer.unwrap_or(self.trimmer), ..*self }
    }

    /// For each of the places how far it is from what a tip burns (mm).
    pub(super) fn by(&self, tip: &Mesh) -> Vec<f64> {
        match Burning::new(tip, self.stage) {
            Ok(burning) => self.places.par_iter().map(|p| burning.beyond(*p)).collect(),
            Err(_) => vec![f64::INFINITY; self.places.len()],
        }
    }

    /// Whether tips together burn what one did that they are parts of: every one of the places, see
    /// [`are_burned`](Self::are_burned).
    pub(super) fn is_by_all<'m>(&self, by: [&[f64]; 2], tips: impl Iterator<Item = &'m Mesh>) -> bool {
        self.are_burned(by, tips).into_iter().all(|is_burned| is_burned)
    }

    /// For each of the places whether tips together burn it as one did that they are parts of, also true where that did
    /// not; given how far the places are from what the head of the whole region burns and from what that one does.
    pub(super) fn are_burned<'m>(
        &self,
        [by_whole, by_one]: [&[f64]; 2],
        tips: impl Iterator<Item = &'m Mesh>,
    ) -> Vec<bool> {
        /// By how much less a place may be burned than by the whole (mm): faces are known so well, and corners of parts
        /// are rounded.
        const LESS: f64 = 0.015;
        let by_each: Vec<Vec<f64>> = tips.map(|tip| self.by(tip)).collect();
        let least = |i: usize| by_each.iter().map(|by| by[i]).fold(f64::INFINITY, f64::min);
        let enough = |i: usize| by_whole[i].max(0.0) + LESS;
        // What lies further off than that is none of the head's.
        let is_asked = |i: usize| by_whole[i] <= self.gap_across + CELL && by_one[i] <= enough(i);
        (0..by_one.len()).map(|i| !is_asked(i) || least(i) <= enough(i)).collect()
    }
}

/// A region in the burn frame.
#[derive(Debug, Clone)]
pub struct Place {
    /// The corners of the parts of the surface that bound it (mm).
    pub corners: Vec<[DVec3; 3]>,
    /// The box around what is left (mm).
    pub bounds: Bounds,
}

impl Place {
    /// The place of a region with these parts of the surface, what is left reaching up to `rim` (mm).
    pub fn new(corners: Vec<[DVec3; 3]>, rim: f64) -> Self {
        let mut bounds = Bounds::of(corners.iter().flatten().copied());
        bounds.max.z = rim.max(bounds.min.z);
        Self { corners, bounds }
    }

    /// Rectangles, runs of cells with this side (mm), that cover it in plan, counter-clockwise.
    fn cells(&self, side: f64) -> Vec<[DVec2; 4]> {
        let size = self.bounds.size();
        let side = side.max((size.x * size.y / MOST_CELLS).sqrt());
        let mut marked = BTreeSet::new();
        for triangle in &self.corners {
            let [a, b, c] = triangle.map(|p| p.truncate() / side);
            let steps = 1 + (a.distance(b).max(a.distance(c)).max(b.distance(c)) * 1.5) as usize;
            for i in 0..=steps {
                for j in 0..=steps - i {
                    let [u, v] = [i, j].map(|k| k as f64 / steps as f64);
                    let p = a + (b - a) * u + (c - a) * v;
                    marked.insert((p.y.floor() as i64, p.x.floor() as i64));
                }
            }
        }
        let mut runs: Vec<[i64; 3]> = Vec::new();
        for (row, column) in marked {
            match runs.last_mut() {
                Some([r, _, end]) if *r == row && *end == column => *end += 1,
                _ => runs.push([row, column, column + 1]),
            }
        }
        let corner = |column: i64, row: i64| DVec2::new(column as f64, row as f64) * side;
        let rectangle = |[row, from, to]: [i64; 3]| {
            [corner(from, row), corner(to, row), corner(to, row + 1), corner(from, row + 1)]
        };
        runs.into_iter().map(rectangle).collect()
    }

    /// The directions of its walls in plan, as unit vectors, that of the largest walls first.
    fn walls(&self) -> Vec<DVec2> {
        /// Directions are distinguished by this (radians).
        const APART: f64 = 0.01;
        let mut found: Vec<(f64, DVec2)> = Vec::new();
        for corners in &self.corners {
            let area = normal_times_two_areas(*corners);
            if area.z.abs() > WALL * area.length() {
                continue;
            }
            let across = area.truncate().normalize_or_zero();
            let same = |d: DVec2| d.dot(across).abs() < APART || d.perp_dot(across).abs() < APART;
            match found.iter_mut().find(|(_, d)| same(*d)) {
                Some((sum, _)) => *sum += area.length(),
                None => found.push((area.length(), across)),
            }
        }
        found.sort_by(|a, b| b.0.total_cmp(&a.0));
        found.into_iter().map(|(_, d)| d).collect()
    }
}

/// The least rectangle around points, along one of these directions or else along X, that is `margin` wider all around.
fn box_around(points: &[DVec2], along: Vec<DVec2>, margin: f64) -> Option<Outline> {
    let rectangle = |x: DVec2| {
        let y = x.perp();
        let span = |d: DVec2| {
            let values = points.iter().map(move |p| p.dot(d));
            values.fold([f64::INFINITY, f64::NEG_INFINITY], |[l, h], v| [l.min(v), h.max(v)])
        };
        let ([x0, x1], [y0, y1]) = (span(x), span(y));
        let corner = |u: f64, v: f64| x * u + y * v;
        let (x0, x1, y0, y1) = (x0 - margin, x1 + margin, y0 - margin, y1 + margin);
        Outline::new(vec![corner(x0, y0), corner(x1, y0), corner(x1, y1), corner(x0, y1)])
    };
    let directions = if along.is_empty() { vec![DVec2::X] } else { along };
    directions.into_iter().filter_map(rectangle).min_by(|a, b| a.area().total_cmp(&b.area()))
}

/// Where a tip may stand: outlines that reach into the walls, and how much of them is free at the height of the rim.
/// Outlines and holes are those of connected sets, one after another.
#[derive(Debug, Clone)]
pub struct Footprint {
    /// The prism's outlines.
    pub outlines: Vec<Outline>,
    /// The free part of them, at the height of the cap.
    pub free: Vec<Outline>,
    /// The height at which walls end and are led straight up (mm).
    pub cap: f64,
    /// Where the prism begins (mm).
    pub low: f64,
    /// The region itself in plan, roughly.
    pub region: Vec<Outline>,
    /// What is left out of the tip beside what it must keep clear of: convex bodies, each given by its corners (mm).
    pub removed: Vec<Vec<DVec3>>,
    /// How it was found.
    pub method: Method,
}

/// Where a tip for a region may stand in plan, `margin` wider than it (mm), whatever the mold leaves of that.
pub struct Rooms {
    /// Rectangles, runs of cells, that cover the region closely.
    touched: Vec<Outline>,
    /// Rectangles that cover the region more roughly.
    cells: Vec<[DVec2; 4]>,
    /// Set of places within the margin of the region.
    close: Vec<Outline>,
    /// The box around it along its walls, and its hull.
    wide: [Vec<Outline>; 2],
}

impl Rooms {
    /// Rooms around the parts of the surface that bound a region.
    pub fn around(place: &Place, margin: f64) -> Self {
        let cells = place.cells(margin / CELLS);
        let points: Vec<DVec2> = place.corners.iter().flatten().map(|p| p.truncate()).collect();
        let grown = |pieces: Vec<Vec<DVec2>>| grown_pieces(pieces.into_iter(), margin).into_iter().flatten().collect();
        Self {
            touched: place.cells(margin / FINE_CELLS).into_iter().filter_map(|c| Outline::new(c.to_vec())).collect(),
            close: grown(cells.iter().map(|c| c.to_vec()).collect()),
            wide: [box_around(&points, place.walls(), margin).into_iter().collect(), grown(vec![points])],
            cells,
        }
    }

    /// The least rectangle along X and Y that holds all of them.
    pub fn extent(&self) -> [DVec2; 2] {
        let [low, high] = plane::extent(&self.close);
        let boxes = self.wide.iter().filter(|room| !room.is_empty()).map(|room| plane::extent(room));
        boxes.fold([low, high], |[low, high], [l, h]| [low.min(l), high.max(h)])
    }
}

/// The footprint of a tip for a region: the box around it along its walls where that holds little more than the region,
/// else its hull, else what lies within the margin of it, without gaps that a disc of the radius `round` does not enter
/// (mm).
///
/// # Errors
/// [`TipError::NoRoom`], [`TipError::Cancelled`].
pub fn footprint(
    burned: &Burned,
    bounds: &Bounds,
    rooms: &Rooms,
    (method, round, is_tilted): (Method, f64, bool),
    cancel: &Cancel,
) -> Result<Footprint, TipError> {
    let cap = bounds.max.z + burned.gap_up - BELOW_RIM;
    let section = sections(burned.kept_clear, &[cap], cancel)?.remove(0);
    // What is narrower than the gap is burned from beside it.
    let reach = burned.gap_across + 0.5 * burned.gap_up.max(SKIN);
    let near: Vec<Outline> =
        grown_pieces(rooms.cells.iter().map(|c| c.to_vec()), reach.max(1.5 * SKIN)).into_iter().flatten().collect();
    let free_of = |outlines: &[Outline]| {
        let is_touched = |shape: &Shape| !plane::intersection(shape, &near).is_empty();
        let free = plane::difference(outlines, &section.outlines);
        free.into_iter().filter(is_touched).flatten().collect::<Vec<Outline>>()
    };
    let least = plane::area(&free_of(&rooms.close));
    // Along another direction the surface of a region is no longer below all of it: its walls may be lines in plan.
    let widest = if is_tilted { f64::INFINITY } else { WIDE * least };
    let fits = |room: &&Vec<Outline>| (1e-9..=widest).contains(&plane::area(&free_of(room)));
    // Inner corners become so round that a cutter reaches into them, and what is too narrow for one is filled: no cutter
    // has been in there.
    let is_boxed = method == Method::Cutting || is_tilted;
    let boxed = rooms.wide.iter().filter(|_| is_boxed).find(fits).cloned();
    let room = boxed.unwrap_or_else(|| shrunk(&grown(&rooms.close, round), round));
    let free = free_of(&room);
    if free.is_empty() {
        return Err(TipError::NoRoom);
    }
    let into_walls: Vec<Outline> = plane::grown(&free, SKIN).into_iter().flatten().collect();
    let outlines = plane::intersection(&into_walls, &room).into_iter().flatten().collect();
    let low = bounds.min.z + burned.gap_up - BELOW_RIM;
    Ok(Footprint { outlines, free, cap, low, region: rooms.touched.clone(), removed: Vec::new(), method })
}

/// The tips over a footprint: as many as it has separate parts. Each ends with flat caps at the footprint's height.
///
/// # Errors
/// [`TipError`].
pub fn tip(burned: &Burned, footprint: &Footprint) -> Result<Mesh, TipError> {
    let mut tip = Mesh::default();
    for shape in plane::union(&footprint.outlines, &[]) {
        // Where faces of touching solids cross, slivers of holes touch the outline beside them; they are trimmed anyway.
        let (outer, holes) = shape.split_at(1);
        let holes = holes.iter().filter(|hole| hole.area().abs() > LEAST_HOLE);
        let rings: Vec<&[DVec2]> = outer.iter().chain(holes).map(Outline::points).collect();
        let prism = solid::prism(&rings, footprint.low, footprint.cap)?;
        tip = joined(tip, burned.trimmer.trim(&prism)?);
    }
    if !footprint.removed.is_empty() {
        let removed = solid::union_of_hulls(&footprint.removed, &Cancel::default())?;
        tip = Trimmer::new(&removed)?.trim(&tip)?;
    }
    if tip.triangles.is_empty() { Err(TipError::NoRoom) } else { Ok(tip) }
}

/// Both meshes as one, side by side.
pub(super) fn joined(mut all: Mesh, part: Mesh) -> Mesh {
    let first = all.vertices.len() as u32;
    all.vertices.extend(part.vertices);
    all.triangles.extend(part.triangles.iter().map(|t| t.map(|i| i + first)));
    all
}

/// Whether a triangle is part of the flat cap at this height.
pub fn is_cap(corners: [DVec3; 3], cap: f64) -> bool {
    corners.iter().all(|p| (p.z - cap).abs() < ON_CAP) && unit_normal(corners).z > 0.5
}

/// The tip led straight up from its cap to the height `top` (mm).
pub fn led_up(body: &Mesh, cap: f64, top: f64) -> Mesh {
    let mut mesh = body.clone();
    let caps: Vec<usize> = (0..body.triangles.len()).filter(|i| is_cap(body.corners(*i), cap)).collect();
    let edges: std::collections::HashSet<(u32, u32)> =
        caps.iter().map(|i| body.triangles[*i]).flat_map(|[a, b, c]| [(a, b), (b, c), (c, a)]).collect();
    let mut raised = std::collections::HashMap::new();
    for &i in &caps {
        let lifted = body.triangles[i].map(|v| {
            *raised.entry(v).or_insert_with(|| {
                mesh.vertices.push(body.vertices[v as usize].with_z(top));
                mesh.vertices.len() as u32 - 1
            })
        });
        for (a, b) in [(0, 1), (1, 2), (2, 0)] {
            let (from, to) = (body.triangles[i][a], body.triangles[i][b]);
            if !edges.contains(&(to, from)) {
                mesh.triangles.extend([[from, to, lifted[b]], [from, lifted[b], lifted[a]]]);
            }
        }
        mesh.triangles[i] = lifted;
    }
    mesh
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Where slivers of a cap have become points, its corners are a little off its height: no part of it stays a ledge.
    #[test]
    fn a_tip_is_led_up_from_all_of_its_cap() {
        let mut body = Mesh::cuboid(DVec3::new(2.0, 1.0, 3.0));
        for (i, p) in body.vertices.iter_mut().filter(|p| p.z > 1.0).enumerate() {
            p.z += [3e-6, -8e-6, 0.0, 5e-6][i];
        }
        let up = led_up(&body, 3.0, 4.0);
        assert!(up.is_watertight() && (up.volume() - 8.0).abs() < 1e-3, "{}", up.volume());
        let looks_up = |corners: &[DVec3; 3]| unit_normal(*corners).z > 0.5 && corners.iter().any(|p| p.z < 3.5);
        assert_eq!(up.iter_corners().filter(looks_up).count(), 0);
    }
}
