//! Points on the electrode's surface at which the search tests clearance.

use std::collections::HashMap;

use glam::{DMat3, DVec3};
use rayon::prelude::*;

use geometry::distance_field::DistanceField;
use geometry::mesh::{Bounds, Mesh, unit_normal};
use task::{Cancel, Cancelled};
use wheel::electrode::ElectrodeFace;

/// A point on the electrode in its final pose.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample {
    /// Position in W (mm).
    pub point: DVec3,
    /// The face it lies on.
    pub face: ElectrodeFace,
    /// Extra clearance demanded beyond that of all samples (mm), where the verifier found less clearance than the
    /// search.
    pub extra: f64,
    /// Greatest angles by which the low and the high wall can be drawn in with the point still part of the electrode
    /// (rad).
    pub stays_to: [f64; 2],
}

impl Sample {
    /// [`stays_to`](Self::stays_to) of a point that no reduction takes away.
    pub const ALWAYS: [f64; 2] = [f64::INFINITY; 2];
}

/// Sampling density of an electrode.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SampleSpacing {
    /// Between points on faces (mm).
    pub face: f64,
    /// Between points on sharp edges, where an electrode touches first (mm).
    pub edge: f64,
}

impl SampleSpacing {
    /// The spacing on `face`: shank and holder have room around them and need fewer points.
    fn on(&self, face: ElectrodeFace) -> Self {
        let factor = match face {
            ElectrodeFace::Holder => 3.0,
            ElectrodeFace::Shank | ElectrodeFace::EntryEnd => 1.5,
            _ => 1.0,
        };
        Self { face: factor * self.face, ..*self }
    }
}

impl Default for SampleSpacing {
    fn default() -> Self {
        Self { face: 1.0, edge: 0.12 }
    }
}

/// Samples of the whole surface of `mesh`, whose triangle `i` lies on `faces[i]`: every sharp corner, points
/// along sharp edges, then points on faces, each no closer to those before it than the spacing.
///
/// # Errors
/// [`Cancelled`].
pub fn sample_electrode(
    mesh: &Mesh,
    faces: &[ElectrodeFace],
    spacing: SampleSpacing,
    cancel: &Cancel,
) -> Result<Vec<Sample>, Cancelled> {
    let size = spacing.on(ElectrodeFace::Holder).face;
    let mut sieve = Sieve { kept: Vec::new(), grid: HashMap::new(), size };
    let edges = bent_edges(mesh, 0..mesh.triangles.len(), 20f64.to_radians());
    let mut ends: HashMap<u32, usize> = HashMap::new();
    for &v in edges.iter().flat_map(|e| &e.ends) {
        *ends.entry(v).or_default() += 1;
    }
    // Corners first, so that no neighbour crowds them out.
    for edge in &edges {
        for v in edge.ends.into_iter().filter(|v| ends[v] != 2) {
            sieve.offer(mesh.vertices[v as usize], edge.face(faces), 1e-6);
        }
    }
    for edge in &edges {
        cancel.check()?;
        let [p, q] = edge.ends.map(|v| mesh.vertices[v as usize]);
        let spacing = spacing.on(edge.face(faces)).edge;
        let pieces = (p.distance(q) / spacing).ceil().clamp(1.0, 1e4) as usize;
        for i in 0..=pieces {
            sieve.offer(p.lerp(q, i as f64 / pieces as f64), edge.face(faces), 0.7 * spacing);
        }
    }
    for (corners, &face) in mesh.iter_corners().zip(faces) {
        cancel.check()?;
        // Twice as fine as the spacing, so that the sieve decides and no gap stays open.
        let longest = (0..3).map(|i| corners[i].distance(corners[(i + 1) % 3])).fold(0.0, f64::max);
        let spacing = spacing.on(face).face;
        let pieces = (2.0 * longest / spacing).ceil().clamp(1.0, 400.0) as usize;
        for i in 0..=pieces {
            for j in 0..=pieces - i {
                let (s, t) = (i as f64 / pieces as f64, j as f64 / pieces as f64);
                let p = corners[0] + (corners[1] - corners[0]) * s + (corners[2] - corners[0]) * t;
                sieve.offer(p, face, spacing);
            }
        }
    }
    Ok(sieve.kept)
}

/// Sets the greatest angle, at most `most` (rad), by which each wall can be drawn in with each sample still part of the
/// electrode: a sample is, as long as it is inside the electrode turned about X as that wall is. `field` is that of the
/// electrode. Samples on the walls themselves follow them, and the holder does not change.
pub fn limit_to_reduced(samples: &mut [Sample], field: &DistanceField, most: f64) {
    const STEPS: u32 = 64;
    const HALVINGS: u32 = 5;
    /// Off the surface by no more than rounding and the field's error (mm).
    const INSIDE: f64 = 3.0 * DistanceField::ACCURACY;
    let follows = |face| matches!(face, ElectrodeFace::LowWall | ElectrodeFace::HighWall | ElectrodeFace::Holder);
    let step = most / f64::from(STEPS);
    samples.par_iter_mut().filter(|s| !follows(s.face)).for_each(|sample| {
        sample.stays_to = [-1.0, 1.0].map(|sense| {
            let seen = |turn: f64| DMat3::from_rotation_x(sense * turn) * sample.point;
            let inside = |turn: f64| field.value(seen(turn)).is_some_and(|d| d <= INSIDE);
            let steps = (1..=STEPS).take_while(|&i| inside(f64::from(i) * step)).count();
            if steps == STEPS as usize {
                return f64::INFINITY;
            }
            let (mut stays, mut gone) = (steps as f64 * step, (steps + 1) as f64 * step);
            for _ in 0..HALVINGS {
                let middle = 0.5 * (stays + gone);
                if inside(middle) { stays = middle } else { gone = middle }
            }
            stays
        });
    });
}

/// Points along the edges of `mesh` inside `region` where the surface bends outwards by more than 4 degrees: rims
/// and the facets of blade edges, which a coarsely sampled electrode would not notice.
///
/// # Errors
/// [`Cancelled`].
pub fn sample_convex_edges(
    mesh: &Mesh,
    region: Bounds,
    spacing: f64,
    cancel: &Cancel,
) -> Result<Vec<Sample>, Cancelled> {
    let mut sieve = Sieve { kept: Vec::new(), grid: HashMap::new(), size: spacing };
    let near = |i: &usize| mesh.bounds_of(&mesh.triangles[*i]).intersects(&region);
    let near: Vec<usize> = (0..mesh.triangles.len()).into_par_iter().filter(near).collect();
    for edge in bent_edges(mesh, near.into_iter(), 4f64.to_radians()).into_iter().filter(|e| e.convex) {
        cancel.check()?;
        let [p, q] = edge.ends.map(|v| mesh.vertices[v as usize]);
        if !Bounds::of([p, q]).intersects(&region) {
            continue;
        }
        let pieces = (p.distance(q) / spacing).ceil().clamp(1.0, 1e4) as usize;
        for i in 0..=pieces {
            let point = p.lerp(q, i as f64 / pieces as f64);
            if Bounds::of([point]).intersects(&region) {
                sieve.offer(point, ElectrodeFace::FarEnd, 0.7 * spacing);
            }
        }
    }
    Ok(sieve.kept)
}

/// An edge where the surface bends.
struct BentEdge {
    ends: [u32; 2],
    /// Range of its triangles.
    triangles: [usize; 2],
    /// Whether the solid is on the inside of the bend.
    convex: bool,
}

impl BentEdge {
    /// The face it counts as part of: a wall's edge follows the wall when that is drawn in.
    fn face(&self, faces: &[ElectrodeFace]) -> ElectrodeFace {
        let [first, second] = self.triangles.map(|t| faces[t]);
        if matches!(second, ElectrodeFace::LowWall | ElectrodeFace::HighWall) { second } else { first }
    }
}

/// Edges between `triangles` where the surface bends by more than `angle` (rad), in order of first occurrence.
fn bent_edges(mesh: &Mesh, triangles: impl ExactSizeIterator<Item = usize>, angle: f64) -> Vec<BentEdge> {
    let mut first: HashMap<[u32; 2], (usize, DVec3)> = HashMap::with_capacity(triangles.len() * 2);
    let mut bent = Vec::new();
    for i in triangles {
        let (t, normal) = (mesh.triangles[i], unit_normal(mesh.corners(i)));
        for k in 0..3 {
            let [here, next, opposite] = [0, 1, 2].map(|j| t[(k + j) % 3]);
            let ends = [here.min(next), here.max(next)];
            let Some(&(j, other)) = first.get(&ends) else {
                first.insert(ends, (i, normal));
                continue;
            };
            if normal.dot(other) < angle.cos() {
                let arm = mesh.vertices[opposite as usize] - mesh.vertices[here as usize];
                bent.push(BentEdge { ends, triangles: [j, i], convex: arm.dot(other) < 0.0 });
            }
        }
    }
    bent
}

/// Keeps points that are far enough from those kept before.
struct Sieve {
    kept: Vec<Sample>,
    grid: HashMap<[i64; 3], Vec<u32>>,
    size: f64,
}

impl Sieve {
    fn offer(&mut self, point: DVec3, face: ElectrodeFace, distance: f64) {
        self.offer_sample(Sample { point, face, extra: 0.0, stays_to: Sample::ALWAYS }, distance);
    }

    fn offer_sample(&mut self, sample: Sample, distance: f64) {
        let point = sample.point;
        let cell = (point / self.size).floor().to_array().map(|v| v as i64);
        let crowded = (0..27i64).any(|i| {
            let neighbour = [cell[0] + i % 3 - 1, cell[1] + i / 3 % 3 - 1, cell[2] + i / 9 - 1];
            self.grid.get(&neighbour).is_some_and(|list| {
                list.iter().any(|&k| self.kept[k as usize].point.distance_squared(point) < distance * distance)
            })
        });
        if !crowded {
            self.grid.entry(cell).or_default().push(self.kept.len() as u32);
            self.kept.push(sample);
        }
    }
}

/// Subset of `samples` no nearer to each other than `spacing` (mm), with all samples that have an extra demand.
pub fn thinned(samples: &[Sample], spacing: f64) -> Vec<Sample> {
    let mut sieve = Sieve { kept: Vec::new(), grid: HashMap::new(), size: spacing };
    for sample in samples {
        let distance = if sample.extra > 0.0 { 0.0 } else { spacing };
        sieve.offer_sample(*sample, distance);
    }
    sieve.kept
}

/// Neighbouring samples that are tested together: if the centre has room enough, all have.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cluster {
    /// Centre of a ball around the samples, in W at the final pose (mm).
    pub center: DVec3,
    /// Radius of the ball around the samples (mm).
    pub radius: f64,
    /// First sample.
    pub start: usize,
    /// One past the last sample.
    pub end: usize,
}

/// Orders `samples` so that neighbours stand together and returns clusters of at most `most` of them. Samples
/// of different groups (by `group`) never share a cluster.
pub fn cluster(samples: &mut [Sample], most: usize, group: impl Fn(ElectrodeFace) -> u8) -> Vec<Cluster> {
    samples.sort_by_key(|s| group(s.face));
    let mut clusters = Vec::new();
    let mut start = 0;
    while start < samples.len() {
        let this = group(samples[start].face);
        let end = start + samples[start..].partition_point(|s| group(s.face) == this);
        split(samples, start, end, most.max(1), &mut clusters);
        start = end;
    }
    clusters
}

fn split(samples: &mut [Sample], start: usize, end: usize, most: usize, clusters: &mut Vec<Cluster>) {
    let part = &mut samples[start..end];
    let bounds = Bounds::of(part.iter().map(|s| s.point));
    if part.len() <= most {
        let center = bounds.center();
        let radius = part.iter().map(|s| s.point.distance(center)).fold(0.0, f64::max);
        clusters.push(Cluster { center, radius, start, end });
        return;
    }
    let size = bounds.size();
    let axis = if size.x >= size.y && size.x >= size.z {
        0
    } else if size.y >= size.z {
        1
    } else {
        2
    };
    part.sort_by(|a, b| a.point[axis].total_cmp(&b.point[axis]));
    let middle = start + part.len() / 2;
    split(samples, start, middle, most, clusters);
    split(samples, middle, end, most, clusters);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_cover_a_box_and_all_its_edges() {
        let mesh = Mesh::cuboid(DVec3::new(6.0, 4.0, 3.0));
        let faces = vec![ElectrodeFace::FarEnd; 12];
        let spacing = SampleSpacing { face: 0.8, edge: 0.3 };
        let samples = sample_electrode(&mesh, &faces, spacing, &Cancel::default()).unwrap();
        let nearest = |p: DVec3| samples.iter().map(|s| s.point.distance(p)).fold(f64::INFINITY, f64::min);
        for v in &mesh.vertices {
            assert!(nearest(*v) < 1e-12, "corner {v}");
        }
        for i in 0..=100 {
            let t = f64::from(i) / 100.0;
            assert!(nearest(DVec3::new(6.0 * t, 0.0, 0.0)) <= 0.3);
            assert!(nearest(DVec3::new(6.0 * t, 4.0 * (7.0 * t).fract(), 3.0)) <= 1.2);
        }
    }

    #[test]
    fn only_edges_that_stand_out_count_as_convex() {
        // A box seen from outside has 12 convex edges, turned inside out (a cavity) none.
        let mesh = Mesh::cuboid(DVec3::splat(4.0));
        let everywhere = mesh.bounds().grown(1.0);
        let points = sample_convex_edges(&mesh, everywhere, 0.5, &Cancel::default()).unwrap();
        let on_edge =
            |p: DVec3| p.to_array().iter().filter(|v| v.abs() < 1e-12 || (*v - 4.0).abs() < 1e-12).count() >= 2;
        assert!(points.len() >= 12 * 7 + 8 && points.iter().all(|s| on_edge(s.point)));
        let cavity = Mesh { triangles: mesh.triangles.iter().map(|&[a, b, c]| [a, c, b]).collect(), ..mesh };
        assert!(sample_convex_edges(&cavity, everywhere, 0.5, &Cancel::default()).unwrap().is_empty());
    }

    #[test]
    fn clusters_hold_every_sample_once_inside_their_balls() {
        let mesh = Mesh::cuboid(DVec3::splat(5.0));
        let faces: Vec<_> =
            (0..12).map(|i| if i < 6 { ElectrodeFace::LowWall } else { ElectrodeFace::Shank }).collect();
        let mut samples = sample_electrode(&mesh, &faces, SampleSpacing::default(), &Cancel::default()).unwrap();
        let group = |face| u8::from(face == ElectrodeFace::LowWall);
        let clusters = cluster(&mut samples, 12, group);
        let mut next = 0;
        for c in &clusters {
            assert_eq!(c.start, next);
            assert!(c.end - c.start <= 12);
            let members = &samples[c.start..c.end];
            assert!(members.iter().all(|s| s.point.distance(c.center) <= c.radius + 1e-12));
            assert!(members.iter().all(|s| group(s.face) == group(members[0].face)));
            next = c.end;
        }
        assert_eq!(next, samples.len());
    }
}
