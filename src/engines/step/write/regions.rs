//! Regions: the pieces of a skin that become faces, each on one surface or of free form.

use std::collections::HashMap;
use std::f64::consts::{PI, TAU};

use geometry::groups::Groups;
use geometry::mesh::Mesh;
use geometry::segmentation::{Face, FaceKind, Segmentation, SegmentationSettings};
use glam::DVec3;

use super::StepWriteError;
use super::skin::{CutPlane, Skin, sides_of};
use super::surface::Surface;

/// Share of a side that a vertex may be off the plane that cuts a cylinder or cone in halves.
const SNAP: f64 = 0.02;
/// Angle (rad) around the axis from which on a cylinder or cone is cut in halves.
const MOST_AROUND: f64 = 3.5;

/// Tolerances by which a free form may leave its facets: larger facets are planes, as far as these are not more than
/// [`MOST_FLAT`].
const COARSE: f64 = 2.0;
const MOST_FLAT: usize = 250;
/// Greatest mean angle (rad) across a border that is smooth.
const SMOOTH: f64 = 0.22;
/// Area of a plane, and of a cylinder or cone, against that of the free forms smoothly beside it, up to which it is a
/// part of these.
const MINOR: [f64; 2] = [1.0, 0.2];

/// A piece of the skin that becomes a face.
#[derive(Debug, Clone)]
pub(super) struct Region {
    /// Plane, cylinder or cone; none for a free form.
    pub(super) surface: Option<Surface>,
    /// Number of its role.
    pub(super) role: u16,
}

/// The regions of the skin of `mesh`: the faces that it shows, divided where roles change. Cylinders and cones go around
/// by half a turn at most.
pub(super) fn regions(
    skin: &mut Skin,
    mesh: &Mesh,
    role_of: &[u16],
    tolerance: f64,
) -> Result<Vec<Region>, StepWriteError> {
    let mut regions = found(skin, mesh, role_of, tolerance, COARSE * tolerance);
    if regions.len() > MOST_FLAT {
        regions = found(skin, mesh, role_of, tolerance, SegmentationSettings::default().chord_tolerance);
    }
    join_slivers(skin, &mut regions, tolerance);
    join_smooth(skin, &mut regions);
    cut_revolved(skin, &mut regions)?;
    Ok(regions)
}

/// Gives pieces that hang together numbers of their own.
pub(super) fn renumber(skin: &mut Skin, regions: &mut Vec<Region>) {
    *regions = skin.separate().into_iter().map(|old| regions[old as usize].clone()).collect();
}

/// The faces that the mesh shows, divided where roles change.
fn found(skin: &mut Skin, mesh: &Mesh, role_of: &[u16], tolerance: f64, chord_tolerance: f64) -> Vec<Region> {
    let settings = SegmentationSettings {
        fit_tolerance: (0.4 * tolerance).min(2e-3),
        plane_tolerance: (0.02 * tolerance).max(1e-5),
        chord_tolerance,
        ..Default::default()
    };
    let segmentation = Segmentation::of(mesh, &settings);
    let (mut number, mut regions) = (HashMap::new(), Vec::new());
    for i in 0..skin.triangles.len() {
        let source = skin.source[i] as usize;
        let face = segmentation.face_of[source];
        let role = role_of.get(source).copied().unwrap_or(u16::MAX);
        let near = skin.corners(i as u32)[0];
        skin.region[i] = *number.entry((face, role)).or_insert_with(|| {
            let face = &segmentation.faces[face as usize];
            let is_exact = face.deviation <= 0.5 * tolerance && !is_coarse(mesh, face, tolerance);
            let kind = if is_exact { face.kind } else { FaceKind::FreeForm };
            regions.push(Region { surface: Surface::of(&kind, near), role });
            regions.len() as u32 - 1
        });
    }
    renumber(skin, &mut regions);
    regions
}

/// Whether the facets of a cylinder or cone leave it by more than a file may leave them.
fn is_coarse(mesh: &Mesh, face: &Face, tolerance: f64) -> bool {
    let Some(surface) = Surface::of(&face.kind, DVec3::ZERO).filter(|s| s.axis().is_some()) else { return false };
    let middles = face.triangles.iter().flat_map(|&i| {
        let [a, b, c] = mesh.corners(i as usize);
        [a + b, b + c, c + a].map(|p| 0.5 * p)
    });
    middles.map(|p| surface.gap(p)).fold(0.0, f64::max) > COARSE * tolerance
}

/// Border lengths between regions, and from a region to all others.
fn borders(skin: &Skin) -> (HashMap<(u32, u32), f64>, HashMap<u32, f64>) {
    let (mut shared, mut all) = (HashMap::new(), HashMap::new());
    for i in 0..skin.triangles.len() {
        let own = skin.region[i];
        for (a, b) in sides_of(skin.triangles[i]) {
            let other = skin.region_across(a, b);
            if other != own {
                let length = skin.points[a as usize].distance(skin.points[b as usize]);
                *shared.entry((own, other)).or_insert(0.0) += length;
                *all.entry(own).or_insert(0.0) += length;
            }
        }
    }
    (shared, all)
}

/// Joins regions too narrow to be faces, and those that lie on a neighbour's surface as well, to their neighbours.
pub(super) fn join_slivers(skin: &mut Skin, regions: &mut Vec<Region>, tolerance: f64) {
    for _ in 0..8 {
        let members = skin.members();
        let (shared, all) = borders(skin);
        let area = |r: usize| members[r].iter().map(|&i| triangle_area(skin, i)).sum::<f64>();
        let areas: Vec<f64> = (0..regions.len()).map(area).collect();
        let mut order: Vec<usize> = (0..regions.len()).collect();
        order.sort_by(|&a, &b| areas[a].total_cmp(&areas[b]).then(a.cmp(&b)));
        let mut into: Vec<u32> = (0..regions.len() as u32).collect();
        let mut is_changed = vec![false; regions.len()];
        let mut neighbours: Vec<Vec<(u32, f64)>> = vec![Vec::new(); regions.len()];
        let mut pairs: Vec<_> = shared.into_iter().collect();
        pairs.sort_by_key(|p| p.0);
        pairs.iter().for_each(|&((r, q), length)| neighbours[r as usize].push((q, length)));
        for r in order {
            let width = 2.0 * areas[r] / all.get(&(r as u32)).copied().unwrap_or(f64::MIN_POSITIVE);
            let holds = |q: u32| is_home(skin, &members[r], regions, r, q as usize, width, tolerance);
            let is_larger = |q: u32| areas[q as usize] > areas[r];
            let home =
                neighbours[r].iter().filter(|(q, _)| !is_changed[*q as usize] && is_larger(*q) && holds(*q)).fold(
                    None,
                    |best: Option<(u32, f64)>, &(q, l)| if best.is_none_or(|b| l > b.1) { Some((q, l)) } else { best },
                );
            if let Some((q, _)) = home.filter(|_| !is_changed[r]) {
                into[r] = q;
                (is_changed[r], is_changed[q as usize]) = (true, true);
            }
        }
        if into.iter().enumerate().all(|(r, &q)| r as u32 == q) {
            return;
        }
        skin.region.iter_mut().for_each(|r| *r = into[*r as usize]);
        renumber(skin, regions);
    }
}

fn triangle_area(skin: &Skin, i: u32) -> f64 {
    let [a, b, c] = skin.corners(i);
    0.5 * (b - a).cross(c - a).length()
}

/// Whether the triangles of region `r` may become a part of region `q`.
fn is_home(skin: &Skin, members: &[u32], regions: &[Region], r: usize, q: usize, width: f64, tolerance: f64) -> bool {
    let is_narrow = width < 2.0 * tolerance;
    match &regions[q].surface {
        Some(surface) => {
            let is_near = |p: DVec3| surface.gap(p) <= 0.3 * tolerance;
            let agrees = |i: u32| {
                let normal = skin.normal(i);
                let [a, b, c] = skin.corners(i);
                normal == DVec3::ZERO || surface.distance((a + b + c) / 3.0).1.dot(normal) > 0.7
            };
            let is_sane = is_narrow || (regions[r].role == regions[q].role && members.iter().all(|&i| agrees(i)));
            is_sane && members.iter().all(|&i| skin.corners(i).into_iter().all(is_near))
        }
        None => is_narrow,
    }
}

/// Cuts cylinders and cones that go around by more than half a turn and something in halves.
fn cut_revolved(skin: &mut Skin, regions: &mut Vec<Region>) -> Result<(), StepWriteError> {
    let members = skin.members();
    for (r, triangles) in members.iter().enumerate() {
        let Some(axes) = regions[r].surface.as_ref().and_then(Surface::axis).copied() else { continue };
        let mut angles: Vec<f64> = Vec::new();
        for &i in triangles {
            for p in skin.corners(i) {
                let local = axes.local(p);
                if local.truncate().length() > 1e-9 {
                    angles.push(local.y.atan2(local.x));
                }
            }
        }
        angles.sort_by(f64::total_cmp);
        let last_gap = angles.first().zip(angles.last()).map_or(TAU, |(a, b)| a + TAU - b);
        let mut gap = (last_gap, 0.0);
        for pair in angles.windows(2) {
            if pair[1] - pair[0] > gap.0 {
                gap = (pair[1] - pair[0], pair[1]);
            }
        }
        // A gap of a facet's width is none.
        if TAU - gap.0 < MOST_AROUND {
            continue;
        }
        let angle = best_angle(&angles);
        let along = axes.x * angle.cos() + axes.y() * angle.sin();
        let plane = CutPlane::through(axes.origin, axes.z.cross(along).normalize());
        let above = regions.len() as u32;
        regions.push(regions[r].clone());
        skin.cut(r as u32, plane, SNAP, above)?;
    }
    renumber(skin, regions);
    Ok(())
}

/// The direction of a plane through the axis that passes the most vertices.
fn best_angle(sorted: &[f64]) -> f64 {
    let mut folded: Vec<f64> = sorted.iter().map(|a| a.rem_euclid(PI)).collect();
    folded.sort_by(f64::total_cmp);
    let (mut best, mut start) = ((0, 0.0), 0);
    for end in 0..folded.len() {
        while folded[end] - folded[start] > 1e-6 {
            start += 1;
        }
        if end - start + 1 > best.0 {
            best = (end - start + 1, 0.5 * (folded[start] + folded[end]));
        }
    }
    best.1
}

/// Borders of one region: length and mean angle between the triangles on both sides, by the region across.
fn smoothness(skin: &Skin, count: usize) -> Vec<Vec<(u32, f64, f64)>> {
    let mut found: Vec<Vec<(u32, f64, f64)>> = vec![Vec::new(); count];
    for (i, &own) in (0u32..).zip(&skin.region) {
        for (a, b) in sides_of(skin.triangles[i as usize]) {
            let across = skin.triangle_at(b, a);
            let other = skin.region_across(a, b);
            if other == own {
                continue;
            }
            let (n, m) = (skin.normal(i), skin.normal(across));
            let length = skin.points[a as usize].distance(skin.points[b as usize]);
            let angle = length * n.cross(m).length().atan2(n.dot(m));
            let entries = &mut found[own as usize];
            match entries.iter_mut().find(|e| e.0 == other) {
                Some(entry) => (entry.1, entry.2) = (entry.1 + length, entry.2 + angle),
                None => entries.push((other, length, angle)),
            }
        }
    }
    found
}

/// Makes minor planes, cylinders and cones that go over smoothly into free forms parts of these, and joins free forms
/// that go over smoothly into each other.
fn join_smooth(skin: &mut Skin, regions: &mut Vec<Region>) {
    for _ in 0..6 {
        let members = skin.members();
        let areas: Vec<f64> = members.iter().map(|m| m.iter().map(|&i| triangle_area(skin, i)).sum()).collect();
        let borders = smoothness(skin, regions.len());
        let is_free: Vec<bool> = regions.iter().map(|r| r.surface.is_none()).collect();
        let mut groups = Groups::of(regions.len());
        let mut is_changed = false;
        for r in 0..regions.len() {
            let beside = borders[r].iter().filter(|(q, length, angle)| {
                is_free[*q as usize] && *angle < SMOOTH * length && regions[*q as usize].role == regions[r].role
            });
            let beside: Vec<usize> = beside.map(|b| b.0 as usize).collect();
            let most = match &regions[r].surface {
                None => f64::INFINITY,
                Some(surface) => MINOR[usize::from(surface.axis().is_some())],
            };
            if beside.is_empty() || areas[r] > most * beside.iter().map(|&q| areas[q]).sum::<f64>() {
                continue;
            }
            regions[r].surface = None;
            is_changed = true;
            beside.iter().for_each(|&q| groups.join(r, q));
        }
        if !is_changed {
            return;
        }
        skin.region.iter_mut().for_each(|r| *r = groups.first(*r as usize) as u32);
        renumber(skin, regions);
    }
}

/// Makes a region that cannot be cut a part of the one with which it shares most of its border.
pub(super) fn absorb(skin: &mut Skin, regions: &mut [Region], region: u32) -> bool {
    let borders = smoothness(skin, regions.len());
    let home = borders[region as usize].iter().copied().reduce(|a, b| if b.1 > a.1 { b } else { a });
    let Some((home, ..)) = home else { return false };
    regions[home as usize].surface = None;
    skin.region.iter_mut().filter(|r| **r == region).for_each(|r| *r = home);
    true
}
