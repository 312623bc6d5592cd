//! The triangles of a mesh, sorted by the circles about the axis and the rays along the radius that may meet them.

use std::f64::consts::TAU;

use glam::DVec2;
use rayon::prelude::*;

use geometry::frame::{Cylindrical, wrap_angle};
use geometry::mesh::{Bounds, Mesh};

/// Sectors of the search grid for rays.
const SECTORS: usize = 96;

/// Most entries of the search grid; a mesh of many large triangles gets coarser cells instead.
const MOST_ENTRIES: usize = 40_000_000;

/// Grid over x and r, and over x and the angle about the axis, with the triangles of each cell.
pub(super) struct SearchGrid {
    /// Least x and radius 0.
    pub origin: DVec2,
    /// Extent in x and r.
    pub size: DVec2,
    /// Cells along x and r.
    pub counts: [usize; 2],
    /// Triangles that may meet the circles of a cell.
    cells: Buckets,
    /// Triangles that may meet the radial rays of a column of cells and a sector.
    wedges: Buckets,
}

impl SearchGrid {
    /// Sorts `mesh`, which is given in W and has `bounds`, into at most `most` cells along x and r.
    pub fn new(mesh: &Mesh, bounds: Bounds, most: [usize; 2]) -> Self {
        let places: Vec<Cylindrical> = mesh.vertices.par_iter().map(|p| Cylindrical::from_point(*p)).collect();
        let r_max = places.iter().map(|p| p.r).fold(0.0, f64::max);
        // A little more than the part, so that the last cell also holds its far boundary.
        let size = DVec2::new(bounds.size().x, r_max).max(DVec2::splat(1e-9)) * (1.0 + 1e-9);
        let origin = DVec2::new(bounds.min.x, 0.0);
        let mut counts = most;
        let mut spans = spans(mesh, &places, origin, size, counts);
        while spans.par_iter().map(Span::entries).sum::<usize>() > MOST_ENTRIES && counts != [1, 1] {
            counts = counts.map(|n| n.div_ceil(2));
            spans = self::spans(mesh, &places, origin, size, counts);
        }
        drop(places);
        let [nx, nr] = counts;
        let in_cells = |span: &Span| {
            let [columns, rows] = [span.x, span.r].map(|[first, last]| usize::from(first)..=usize::from(last));
            columns.flat_map(move |ix| rows.clone().map(move |ir| ix * nr + ir))
        };
        let in_wedges = |span: &Span| {
            let ([first, last], columns) = (span.theta, usize::from(span.x[0])..=usize::from(span.x[1]));
            let sectors = (first..=last).map(|s| i64::from(s).rem_euclid(SECTORS as i64) as usize);
            columns.flat_map(move |ix| sectors.clone().map(move |s| ix * SECTORS + s))
        };
        let (cells, wedges) =
            rayon::join(|| Buckets::new(nx * nr, &spans, in_cells), || Buckets::new(nx * SECTORS, &spans, in_wedges));
        Self { origin, size, counts, cells, wedges }
    }

    /// The triangles that may meet the circle of radius `r` about the axis at `x`.
    pub fn about(&self, x: f64, r: f64) -> &[u32] {
        let [nx, nr] = self.counts;
        let at = (DVec2::new(x, r) - self.origin) / self.size * DVec2::new(nx as f64, nr as f64);
        let inside = at.x >= 0.0 && at.y >= 0.0 && at.x < nx as f64 && at.y < nr as f64;
        if inside { self.cells.get(at.x as usize * nr + at.y as usize) } else { &[] }
    }

    /// The column of cells that holds `x`, or the nearest one.
    pub fn column(&self, x: f64) -> usize {
        let at = (x - self.origin.x) / self.size.x * self.counts[0] as f64;
        (at.max(0.0) as usize).min(self.counts[0] - 1)
    }

    /// The triangles of a column that may lie in the half plane at `theta`.
    pub fn towards(&self, column: usize, theta: f64) -> &[u32] {
        self.wedges.get(column * SECTORS + sector(theta))
    }

    /// The triangles of a column that may lie in the half planes between two angles in rising order.
    pub fn within(&self, column: usize, [first, last]: [f64; 2]) -> impl Iterator<Item = &u32> {
        let first = sector_count(first);
        let last = sector_count(last).min(first + SECTORS as i64 - 1);
        let sectors = (first..=last).map(|s| s.rem_euclid(SECTORS as i64) as usize);
        sectors.flat_map(move |s| self.wedges.get(column * SECTORS + s))
    }
}

/// The sector that holds an angle, counted on beyond a turn.
fn sector_count(theta: f64) -> i64 {
    (theta / (TAU / SECTORS as f64)).floor() as i64
}

/// The sector that holds an angle.
fn sector(theta: f64) -> usize {
    sector_count(theta).rem_euclid(SECTORS as i64) as usize
}

/// The cells that a triangle may touch: first and last column, row and sector.
struct Span {
    x: [u16; 2],
    r: [u16; 2],
    theta: [i16; 2],
}

/// The spans of the triangles of `mesh`, whose vertices are at `places`.
fn spans(mesh: &Mesh, places: &[Cylindrical], origin: DVec2, size: DVec2, grid: [usize; 2]) -> Vec<Span> {
    let span = |t: &[u32; 3]| {
        let flat = t.map(|v| mesh.vertices[v as usize]).map(|p| DVec2::new(p.z, -p.y));
        Span::new(flat, t.map(|v| places[v as usize]), origin, size, grid)
    };
    mesh.triangles.par_iter().map(span).collect()
}

impl Span {
    /// The cells of a triangle with these corners, also across the axis.
    fn new(flat: [DVec2; 3], corners: [Cylindrical; 3], origin: DVec2, size: DVec2, grid: [usize; 2]) -> Self {
        // Computed as for a point that is looked up, so that both round alike.
        let [nx, nr] = grid.map(|n| n as f64);
        let x = corners.map(|p| (p.x - origin.x) / size.x * nx);
        let r = corners.map(|p| p.r);
        let nearest = least_radius(flat);
        let index = |value: f64, axis: usize| (value.max(0.0) as usize).min(grid[axis] - 1) as u16;
        let theta = if nearest == 0.0 {
            [0, SECTORS as i16 - 1]
        } else {
            let start = corners[0].theta;
            let turns = corners.map(|p| wrap_angle(p.theta - start));
            [least(turns) - 1e-9, most(turns) + 1e-9].map(|turn| sector_count(start + turn) as i16)
        };
        // A hair more than the triangle, so that rounding never loses it.
        let rows = [nearest * (1.0 - 1e-12), most(r) * (1.0 + 1e-12)].map(|r| index(r / size.y * nr, 1));
        Self { x: [index(least(x), 0), index(most(x), 0)], r: rows, theta }
    }

    fn entries(&self) -> usize {
        let count = |[first, last]: [u16; 2]| usize::from(last - first) + 1;
        count(self.x) * (count(self.r) + (self.theta[1] - self.theta[0] + 1) as usize)
    }
}

fn least(v: [f64; 3]) -> f64 {
    v[0].min(v[1]).min(v[2])
}

fn most(v: [f64; 3]) -> f64 {
    v[0].max(v[1]).max(v[2])
}

/// Least distance of a triangle in the plane from the origin.
fn least_radius(corners: [DVec2; 3]) -> f64 {
    let edges = [0, 1, 2].map(|i| (corners[i], corners[(i + 1) % 3]));
    let sides = edges.map(|(p, q)| p.perp_dot(q));
    if sides.iter().all(|&s| s >= 0.0) || sides.iter().all(|&s| s <= 0.0) {
        return 0.0;
    }
    let to_edge = edges.map(|(p, q)| {
        let d = q - p;
        let t = if d == DVec2::ZERO { 0.0 } else { (-p.dot(d) / d.length_squared()).clamp(0.0, 1.0) };
        p.lerp(q, t).length()
    });
    least(to_edge)
}

/// Triangle numbers by bucket, in rising order within each.
struct Buckets {
    starts: Vec<usize>,
    items: Vec<u32>,
}

impl Buckets {
    /// Puts item `i` into every bucket of `of(&spans[i])`.
    fn new<I: Iterator<Item = usize>>(count: usize, spans: &[Span], of: impl Fn(&Span) -> I) -> Self {
        let mut starts = vec![0; count + 1];
        spans.iter().flat_map(&of).for_each(|bucket| starts[bucket + 1] += 1);
        for i in 0..count {
            starts[i + 1] += starts[i];
        }
        let mut ends = starts.clone();
        let mut items = vec![0; starts[count]];
        for (i, span) in spans.iter().enumerate() {
            for bucket in of(span) {
                items[ends[bucket]] = i as u32;
                ends[bucket] += 1;
            }
        }
        Self { starts, items }
    }

    fn get(&self, bucket: usize) -> &[u32] {
        &self.items[self.starts[bucket]..self.starts[bucket + 1]]
    }
}
