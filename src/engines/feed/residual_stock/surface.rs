//! The finished surface of the channel, cut into small triangles, and its figures.

use std::sync::atomic::{AtomicUsize, Ordering};

use glam::DVec3;
use rayon::prelude::*;

use super::{Layer, Passage, Removal, ResidualStockError, Site, SurfaceFigures, TOLERANCE};
use geometry::mesh::{Bounds, Mesh, halved, normal_times_two_areas};
use geometry::shells::Shells;
use geometry::weld::Weld;
use task::{Cancel, Cancelled, Task};
use wheel::channel::Surface;

/// Longest edge of a triangle of the map (mm).
const EDGE: f64 = 0.45;
/// Greatest edge length where two electrodes meet (mm).
const EDGE_AT_JUNCTION: f64 = 0.06;
/// How far from their junction that is so (mm).
const AT_JUNCTION: f64 = 0.15;
/// Tolerance beside the walls, along the circumference (mm): chord errors of the wall grids.
const BESIDE: f64 = 0.1;
/// Greatest distance of a point from the nearest surface of the channel (mm): the middle of a fillet.
const IN_FILLET: f64 = 0.8;
/// Distance off a triangle of the place that tells whether another shell buries it (mm).
const OFF: f64 = 0.02;
/// Vertices between two looks at the cancel flag.
const BATCH: usize = 64;

/// The surfaces that bound a channel.
const SURFACES: [Surface; 4] = [Surface::LowWall, Surface::HighWall, Surface::Hub, Surface::Shroud];

/// The finished surface of the channel.
pub(super) struct Patch {
    /// Small triangles that share their vertices.
    pub mesh: Mesh,
    /// Surface of the channel that each triangle belongs to.
    pub surfaces: Vec<Surface>,
}

/// The triangles of the blisk that bound the channel; not what another of its shells buries, as the end of a blade in a
/// hub.
pub(super) fn patch(site: &Site, passage: &Passage, cancel: &Cancel) -> Result<Patch, ResidualStockError> {
    let walls = site.channel.low.points.iter().chain(&site.channel.high.points).copied();
    let around = Bounds::of(walls).grown(1.0);
    let shells = Shells::of(site.blisk);
    let is_bare = |piece: &[DVec3; 3], triangle: usize| {
        let center = piece.iter().sum::<DVec3>() / 3.0;
        let off = center + OFF * normal_times_two_areas(*piece).normalize_or_zero();
        !shells.hold(off, triangle as u32, site.blisk.corners(triangle))
    };
    let longest = |p: DVec3, q: DVec3| if at_junction(site, passage, p, q) { EDGE_AT_JUNCTION } else { EDGE };
    let parts: Vec<_> = site
        .blisk
        .triangles
        .par_chunks(BATCH)
        .enumerate()
        .map(|(number, batch)| {
            cancel.check()?;
            let triangles = number * BATCH..number * BATCH + batch.len();
            let near = triangles.filter(|&t| Bounds::of(site.blisk.corners(t)).intersects(&around));
            let bounding = |t: usize| {
                let pieces = halved(site.blisk.corners(t), &around, &longest).into_iter();
                pieces.filter_map(|piece| part(site, passage, piece)).filter(move |(piece, _)| is_bare(piece, t))
            };
            Ok(near.flat_map(bounding).collect())
        })
        .collect();
    let parts: Vec<Vec<([DVec3; 3], Surface)>> = parts.into_iter().collect::<Result<_, Cancelled>>()?;
    // Halves of shared edges are the same to the last bit.
    let (mut weld, mut triangles, mut surfaces) = (Weld::default(), Vec::new(), Vec::new());
    for (corners, surface) in parts.into_iter().flatten() {
        triangles.push(corners.map(|p| weld.add(p)));
        surfaces.push(surface);
    }
    let mesh = Mesh { vertices: weld.into_points(), triangles };
    if mesh.triangles.is_empty() { Err(ResidualStockError::NoSurface) } else { Ok(Patch { mesh, surfaces }) }
}

/// Whether an edge comes near a junction of two electrodes, or crosses it.
fn at_junction(site: &Site, passage: &Passage, p: DVec3, q: DVec3) -> bool {
    let near = |a: f64, b: f64| a * b <= 0.0 || a.abs().min(b.abs()) < AT_JUNCTION;
    let planes = &site.junctions.planes;
    let split = site.junctions.split;
    let along = |p: DVec3| passage.along_and_height(p)[0];
    planes.iter().any(|at| near(along(p) - at, along(q) - at))
        || split.is_some_and(|s| near(passage.beyond_split(p, s), passage.beyond_split(q, s)))
}

/// Surface of the channel that a small triangle belongs to, if it bounds the channel.
fn part(site: &Site, passage: &Passage, corners: [DVec3; 3]) -> Option<([DVec3; 3], Surface)> {
    let center = corners.iter().sum::<DVec3>() / 3.0;
    if !passage.holds(center, BESIDE) || is_beside_blades(passage, corners, site.spark_gap) {
        return None;
    }
    let [along, height] = passage.along_and_height(center);
    let [hub, shroud] = site.channel.line_at(along).ends;
    let [low, high] = site.finder.wall_distances(center);
    let closed = if site.channel.shrouded { (height - shroud).abs() } else { f64::INFINITY };
    let distances = [low, high, (height - hub).abs(), closed];
    let nearest = (0..4).fold(0, |best, i| if distances[i] < distances[best] { i } else { best });
    (distances[nearest] <= IN_FILLET).then_some((corners, SURFACES[nearest]))
}

/// Whether a small triangle reaches further than the spark gap beyond the edges of the blades, or lies in the flat end
/// of a blade, square to the passage there.
pub(super) fn is_beside_blades(passage: &Passage, corners: [DVec3; 3], spark_gap: f64) -> bool {
    /// Part of a normal square to the line across the passage from which on a face is an end.
    const END: f64 = 0.995;
    let [from, to] = passage.span;
    let along = corners.map(|p| passage.along_and_height(p)[0]);
    let beyond = along.iter().map(|at| (from - at).max(at - to)).fold(f64::NEG_INFINITY, f64::max);
    let center = corners.iter().sum::<DVec3>() / 3.0;
    let normal = normal_times_two_areas(corners).normalize_or_zero();
    let channel = passage.channel();
    let [along, _] = passage.along_and_height(center);
    let across = channel.across(&channel.line_at(along));
    let outwards = center.with_x(0.0).normalize_or_zero();
    let slope = normal.dot(DVec3::X * across.x + outwards * across.y);
    beyond > spark_gap || (beyond > -EDGE && slope.abs() > END)
}

/// Thickness of the stock left on every vertex (mm), negative where it is cut too deep. Once it is known to be `enough`
/// or less no more is looked for.
pub(super) fn deviations(patch: &Patch, removal: &Removal, enough: f64, task: &Task) -> Result<Vec<f64>, Cancelled> {
    let (done, all) = (AtomicUsize::new(0), patch.mesh.vertices.len());
    let batches: Vec<_> = patch
        .mesh
        .vertices
        .par_chunks(BATCH)
        .map(|batch| {
            task.check()?;
            let left = |&p: &DVec3| removal.blank.left(p, removal.deviation(p, enough));
            let found: Vec<f64> = batch.iter().map(left).collect();
            let done = done.fetch_add(batch.len(), Ordering::Relaxed) + batch.len();
            task.report("residual stock", 0.7 * done as f64 / all as f64, "surfaces of the channel");
            Ok(found)
        })
        .collect();
    Ok(batches.into_iter().collect::<Result<Vec<_>, Cancelled>>()?.concat())
}

/// The figures of each surface that there is: every vertex stands for a third of the triangles around it. No deviation
/// is told that is greater than `most` (mm).
pub(super) fn figures(patch: &Patch, deviation: &[f64], most: f64) -> Vec<SurfaceFigures> {
    let of = |surface: Surface| {
        let mut figures = SurfaceFigures { surface, area_mm2: 0.0, left: Layer::default(), overcut: Layer::default() };
        let mine = patch.mesh.triangles.iter().zip(&patch.surfaces).filter(|(_, s)| **s == surface);
        for (triangle, _) in mine {
            let corners = triangle.map(|v| patch.mesh.vertices[v as usize]);
            let third = normal_times_two_areas(corners).length() / 6.0;
            figures.area_mm2 += 3.0 * third;
            for (v, at) in triangle.iter().zip(corners) {
                let d = deviation[*v as usize];
                let layer = if d > 0.0 { &mut figures.left } else { &mut figures.overcut };
                layer.add(d.abs(), third, at);
                layer.or_more |= d >= most;
            }
        }
        figures
    };
    SURFACES.into_iter().map(of).filter(|f| f.area_mm2 > 0.0).collect()
}

impl Layer {
    fn add(&mut self, depth: f64, area: f64, at: DVec3) {
        if depth <= TOLERANCE {
            return;
        }
        self.area_mm2 += area;
        self.volume_mm3 += area * depth;
        if depth > self.depth_mm {
            (self.depth_mm, self.at) = (depth, Some(at));
        }
    }
}
