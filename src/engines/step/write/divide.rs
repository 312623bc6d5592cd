//! Cuts of free-form regions: into discs, and in two where one surface cannot be fitted.

use geometry::exact::ExactMesh;
use geometry::groups::Groups;
use geometry::mesh::Mesh;
use geometry::segmentation::FaceKind;
use glam::DVec3;

use super::StepWriteError;
use super::piece::Piece;
use super::regions::{Region, absorb, renumber};
use super::skin::{CutPlane, Skin, sides_of};
use super::surface::Surface;

/// Cuts at most until all free forms are discs.
const ROUNDS: usize = 24;
/// Shares of a side that a vertex may be off a cut, tried one after the other.
const SNAPS: [f64; 3] = [0.2, 0.02, 0.0];
/// Triangles of a region that is made of plane faces at most, where no surface fits it.
pub(super) const MOST_FACETS: usize = 64;
/// Share of the tolerance within which a free form is flat.
const FLAT: f64 = 0.1;
/// Places along each direction at which cuts are tried.
const PLACES: u32 = 10;

/// Makes flat free forms planes, and cuts the others until each is a disc with four vertices on its border.
pub(super) fn into_discs(skin: &mut Skin, regions: &mut Vec<Region>, tolerance: f64) -> Result<(), StepWriteError> {
    for _ in 0..ROUNDS {
        let mut due = Vec::new();
        for (r, members) in (0u32..).zip(skin.members()) {
            if regions[r as usize].surface.is_some() {
                continue;
            }
            if let Some(plane) = plane_of(skin, &members, FLAT * tolerance) {
                regions[r as usize].surface = Some(plane);
                continue;
            }
            let piece = Piece::of(skin, &members, &skin.points);
            if !piece.is_disc() {
                due.push(r);
            } else if let [a, b, c] = piece.loops[0][..] {
                let ends =
                    [(a, b), (b, c), (c, a)].map(|(v, w)| (piece.of_skin[v as usize], piece.of_skin[w as usize]));
                let length = |(v, w): (u32, u32)| skin.points[v as usize].distance(skin.points[w as usize]);
                let longest = ends.into_iter().reduce(|a, b| if length(b) > length(a) { b } else { a });
                longest.map_or(Ok(()), |side| skin.split_side(side))?;
            }
        }
        if due.is_empty() {
            return Ok(());
        }
        halve(skin, regions, &due)?;
    }
    let at = skin.points[skin.triangles[0][0] as usize];
    Err(StepWriteError::Divide { at })
}

/// Divides the region beside a place where a file is not as it should be, so that it comes out better; false where
/// nothing can be done.
pub(super) fn mend(
    skin: &mut Skin,
    regions: &mut Vec<Region>,
    at: DVec3,
    tolerance: f64,
) -> Result<bool, StepWriteError> {
    let mesh = Mesh { vertices: skin.points.clone(), triangles: skin.triangles.clone() };
    let exact = ExactMesh::new(&mesh).map_err(|_| StepWriteError::Unusable)?;
    let region = skin.region[exact.nearest(at).triangle as usize];
    let count = skin.region.iter().filter(|r| **r == region).count();
    let surface = &mut regions[region as usize].surface;
    match surface {
        Some(surface) if surface.axis().is_none() => return Ok(false),
        Some(_) => *surface = None,
        None if count <= MOST_FACETS => {
            into_facets(skin, regions, &[region], tolerance);
            renumber(skin, regions);
        }
        None => halve(skin, regions, &[region])?,
    }
    Ok(true)
}

/// Makes plane faces of the facets of regions. Numbers of the other regions stay as they are.
pub(super) fn into_facets(skin: &mut Skin, regions: &mut Vec<Region>, due: &[u32], tolerance: f64) {
    let members = skin.members();
    for &r in due {
        let mut open = members[r as usize].clone();
        let area = |i: u32| {
            let [a, b, c] = skin.corners(i);
            (b - a).cross(c - a).length()
        };
        open.sort_by(|&i, &j| area(j).total_cmp(&area(i)).then(i.cmp(&j)));
        let mut is_first = true;
        while let Some(&seed) = open.first() {
            let facet = facet(skin, r, seed, &mut open, FLAT * tolerance);
            let region = Region { surface: plane_of(skin, &facet, tolerance), role: regions[r as usize].role };
            if std::mem::take(&mut is_first) {
                regions[r as usize] = region;
                continue;
            }
            facet.iter().for_each(|&i| skin.region[i as usize] = regions.len() as u32);
            regions.push(region);
        }
    }
}

/// Takes the triangles around `seed` out of `open` that lie in its plane.
fn facet(skin: &Skin, region: u32, seed: u32, open: &mut Vec<u32>, within: f64) -> Vec<u32> {
    let (normal, [origin, ..]) = (skin.normal(seed), skin.corners(seed));
    let is_in = |i: u32| {
        let is_near = skin.corners(i).iter().all(|p| (*p - origin).dot(normal).abs() <= within);
        is_near && skin.normal(i).dot(normal) >= 0.0
    };
    let mut found = vec![seed];
    open.retain(|&i| i != seed);
    let mut next = 0;
    while next < found.len() {
        for (a, b) in sides_of(skin.triangles[found[next] as usize]) {
            let across = skin.triangle_at(b, a);
            if let Some(at) = open.iter().position(|&i| i == across)
                && skin.region[across as usize] == region
                && is_in(across)
            {
                open.remove(at);
                found.push(across);
            }
        }
        next += 1;
    }
    found.sort_unstable();
    found
}

/// The plane of triangles that all lie in it.
fn plane_of(skin: &Skin, members: &[u32], within: f64) -> Option<Surface> {
    let vectors = members.iter().map(|&i| {
        let [a, b, c] = skin.corners(i);
        (b - a).cross(c - a)
    });
    let normal = vectors.sum::<DVec3>().try_normalize()?;
    let heights = || members.iter().flat_map(|&i| skin.corners(i)).map(|p| p.dot(normal));
    let (low, high) = heights().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(x), h.max(x)));
    let is_facing = members.iter().all(|&i| skin.normal(i).dot(normal) >= 0.0);
    let kind = FaceKind::Plane { normal, offset: 0.5 * (low + high) };
    if is_facing && high - low <= 2.0 * within { Surface::of(&kind, skin.corners(members[0])[0]) } else { None }
}

/// Cuts each of these regions in two or more.
pub(super) fn halve(skin: &mut Skin, regions: &mut Vec<Region>, due: &[u32]) -> Result<(), StepWriteError> {
    let members = skin.members();
    for &r in due {
        let planes = planes(skin, &members[r as usize]);
        let above = regions.len() as u32;
        regions.push(regions[r as usize].clone());
        let mut is_cut = false;
        for (plane, snap) in planes.iter().flat_map(|p| SNAPS.map(|s| (*p, s))) {
            is_cut = is_cut || skin.cut(r, plane, snap, above)?;
        }
        if !is_cut && !absorb(skin, regions, r) {
            let first = members[r as usize].first();
            return Err(StepWriteError::Divide { at: first.map_or(DVec3::ZERO, |&i| skin.corners(i)[0]) });
        }
    }
    renumber(skin, regions);
    Ok(())
}

/// A triangle as a cut sees it.
struct Facet {
    middle: DVec3,
    normal: DVec3,
    area: f64,
    corners: [DVec3; 3],
}

/// Planes that divide a region, the best first: parts that are discs and turn little, by a short cut, and of about the
/// same size.
fn planes(skin: &Skin, members: &[u32]) -> Vec<CutPlane> {
    let facets: Vec<Facet> = members.iter().map(|&i| Facet::of(skin, i)).collect();
    let area = facets.iter().map(|f| f.area).sum::<f64>().max(f64::MIN_POSITIVE);
    let middle = facets.iter().map(|f| f.middle * f.area).sum::<DVec3>() / area;
    let normal = facets.iter().map(|f| f.normal * f.area).sum::<DVec3>() / area;
    let mut directions = principal(facets.iter().map(|f| (f.middle - middle, f.area)));
    directions.extend(principal(facets.iter().map(|f| (f.normal - normal, f.area))).into_iter().take(2));
    let parts = Parts::of(skin, members);
    let mut found: Vec<(f64, CutPlane)> = Vec::new();
    for direction in directions {
        let mut heights: Vec<f64> = facets.iter().map(|f| f.middle.dot(direction)).collect();
        heights.sort_by(f64::total_cmp);
        let [low, high] = [0.02, 0.98].map(|q| heights[((heights.len() - 1) as f64 * q) as usize]);
        for k in 1..PLACES {
            let offset = low + (high - low) * f64::from(k) / f64::from(PLACES);
            let plane = CutPlane { normal: direction, offset };
            if let Some(cost) = cost(&facets, &parts, &plane, area) {
                found.push((cost, plane));
            }
        }
    }
    found.sort_by(|a, b| a.0.total_cmp(&b.0));
    found.into_iter().map(|f| f.1).take(4).collect()
}

/// The cost of a cut; none where it leaves one side empty.
fn cost(facets: &[Facet], parts: &Parts, plane: &CutPlane, area: f64) -> Option<f64> {
    let is_above: Vec<bool> = facets.iter().map(|f| plane.height(f.middle) > 0.0).collect();
    let above = || facets.iter().zip(&is_above).filter(|(_, a)| **a).map(|(f, _)| f);
    let below = || facets.iter().zip(&is_above).filter(|(_, a)| !**a).map(|(f, _)| f);
    if above().next().is_none() || below().next().is_none() {
        return None;
    }
    let share = above().map(|f| f.area).sum::<f64>() / area;
    let turned = share * spread(above()) + (1.0 - share) * spread(below());
    let now = spread(facets.iter()).max(1e-3);
    let length: f64 = facets.iter().map(|f| f.cut_length(plane)).sum();
    let (pieces, faults) = parts.count(&is_above);
    let shape = 3.0 * faults as f64 + 0.5 * (pieces as f64 - 2.0);
    Some(shape + turned / now + 0.4 * length / area.sqrt() + 1.2 * (share - 0.5).abs())
}

impl Facet {
    fn of(skin: &Skin, i: u32) -> Self {
        let corners = skin.corners(i);
        let [a, b, c] = corners;
        let area = 0.5 * (b - a).cross(c - a).length();
        Self { middle: (a + b + c) / 3.0, normal: skin.normal(i), area, corners }
    }

    /// Length of the plane's line on the triangle.
    fn cut_length(&self, plane: &CutPlane) -> f64 {
        let heights = self.corners.map(|p| plane.height(p));
        let cross = |k: usize| {
            let (j, h) = ((k + 1) % 3, heights);
            (h[k] * h[j] < 0.0).then(|| self.corners[k].lerp(self.corners[j], h[k] / (h[k] - h[j])))
        };
        let places: Vec<DVec3> = (0..3).filter_map(cross).collect();
        if let [p, q] = places[..] { p.distance(q) } else { 0.0 }
    }
}

/// How the triangles of a region hang together, to tell what pieces a cut makes.
struct Parts {
    /// Vertices of each triangle, counted from 0.
    triangles: Vec<[usize; 3]>,
    vertices: usize,
    /// Triangles on both sides of every side within the region.
    pairs: Vec<[usize; 2]>,
}

impl Parts {
    fn of(skin: &Skin, members: &[u32]) -> Self {
        let piece = Piece::of(skin, members, &skin.points);
        let mut pairs = Vec::new();
        for (n, &i) in members.iter().enumerate() {
            for (a, b) in sides_of(skin.triangles[i as usize]) {
                if let Ok(other) = members.binary_search(&skin.triangle_at(b, a))
                    && other > n
                {
                    pairs.push([n, other]);
                }
            }
        }
        let triangles = piece.triangles.iter().map(|t| t.map(|v| v as usize)).collect();
        Self { triangles, vertices: piece.points.len(), pairs }
    }

    /// Number of pieces, and by how much their characteristics are away from those of discs.
    fn count(&self, is_above: &[bool]) -> (usize, usize) {
        let mut groups = Groups::of(self.triangles.len());
        let kept: Vec<&[usize; 2]> = self.pairs.iter().filter(|[a, b]| is_above[*a] == is_above[*b]).collect();
        kept.iter().for_each(|[a, b]| groups.join(*a, *b));
        let (number, count) = groups.numbers();
        // Vertices less sides plus triangles: each triangle brings three sides, each pair takes one away.
        let mut characteristic = vec![0i64; count];
        number.iter().for_each(|&n| characteristic[n as usize] -= 2);
        kept.iter().for_each(|[a, _]| characteristic[number[*a] as usize] += 1);
        let mut seen: Vec<Vec<u32>> = vec![Vec::new(); self.vertices];
        for (t, &n) in self.triangles.iter().zip(&number) {
            for &v in t {
                if !seen[v].contains(&n) {
                    seen[v].push(n);
                    characteristic[n as usize] += 1;
                }
            }
        }
        (count, characteristic.iter().map(|c| (1 - c).unsigned_abs() as usize).sum())
    }
}

/// How much normals differ: 0 where all are the same, 1 where they cancel.
fn spread<'a>(facets: impl Iterator<Item = &'a Facet>) -> f64 {
    let (sum, area) = facets.fold((DVec3::ZERO, 0.0), |(s, a), f| (s + f.normal * f.area, a + f.area));
    1.0 - sum.length() / area.max(f64::MIN_POSITIVE)
}

/// Unit vectors along which weighted vectors vary, the most first.
fn principal(vectors: impl Iterator<Item = (DVec3, f64)>) -> Vec<DVec3> {
    let mut matrix = nalgebra::Matrix3::<f64>::zeros();
    for (v, weight) in vectors {
        let v = nalgebra::Vector3::new(v.x, v.y, v.z);
        matrix += v * v.transpose() * weight;
    }
    let Some(eigen) = nalgebra::SymmetricEigen::try_new(matrix, 1e-15, 200) else { return DVec3::AXES.to_vec() };
    let mut order = [0, 1, 2];
    order.sort_by(|&a, &b| eigen.eigenvalues[b].total_cmp(&eigen.eigenvalues[a]));
    let vector = |k: usize| {
        let v = eigen.eigenvectors.column(k);
        DVec3::new(v[0], v[1], v[2]).normalize_or(DVec3::X)
    };
    order.map(vector).to_vec()
}
