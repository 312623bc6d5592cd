//! Solids of a part that touch, united.
//!
//! Where a curved face of one solid lies on another solid, both have triangles of their own there, which cross each other
//! within the tolerance. Such a face is first set a little into the other solid, along the walls around it, so that no
//! gaps are left between them.

use std::collections::{BTreeMap, BTreeSet, HashSet};

use geometry::bvh::Bvh;
use geometry::exact::ExactMesh;
use geometry::groups::Groups;
use geometry::inside::is_inside_of;
use geometry::mesh::{Bounds, Mesh, normal_times_two_areas};
use geometry::segmentation::{FaceKind, KnownFace};
use geometry::solid::{FacedMesh, SolidError, union_of_faced};
use glam::DVec3;
use rayon::prelude::*;
use task::{Cancelled, Task};

use super::error::ImportError;

/// A solid that may be united with others.
pub(super) struct Single<'a> {
    /// Number in the file, from 1.
    pub number: u32,
    /// Surface with the numbers of its faces in the list of all.
    pub faced: FacedMesh,
    /// Whether the surface is closed.
    pub is_closed: bool,
    /// Faces of the solid, whose numbers begin at `first_face`.
    pub faces: &'a [KnownFace],
    /// Number of the first of them.
    pub first_face: u32,
}

/// Distance within which solids touch, as a multiple of the tolerance of their triangles: both may leave the same face.
const TOUCHING: f64 = 2.0;
/// Distance within which they touch whatever the tolerance (mm): what CAD programs take for the same place.
const SAME: f64 = 1e-4;
/// How far a curved face is set into the solid that it lies on, as a multiple of the distance within which they touch.
const INTO: f64 = 1.5;

/// The solids as one surface: those that touch are united, all others stay bodies of their own. Sentences on what was
/// done. `tolerance` is that of the triangles (mm).
///
/// # Errors
/// [`ImportError::Cancelled`].
pub(super) fn unite(solids: Vec<Single>, tolerance: f64, task: &Task) -> Result<(FacedMesh, Vec<String>), ImportError> {
    let reach = (TOUCHING * tolerance).max(SAME);
    let (groups, count) = touching(&solids, reach, task)?;
    let mut all = FacedMesh::default();
    let mut sentences = Vec::new();
    let mut members: Vec<Vec<Single>> = (0..count).map(|_| Vec::new()).collect();
    for (solid, group) in solids.into_iter().zip(groups) {
        members[group as usize].push(solid);
    }
    for (n, group) in members.into_iter().enumerate() {
        task.report("uniting solids", n as f64 / count as f64, "");
        let numbers = numbers(&group.iter().map(|s| s.number).collect::<Vec<_>>());
        if group.len() > 1 {
            match united(&group, reach, task) {
                Ok(body) => {
                    sentences.push(format!("Solids {numbers} touch and were united."));
                    append(&mut all, &body);
                    continue;
                }
                Err(SolidError::Cancelled(cancelled)) => return Err(cancelled.into()),
                Err(why) => sentences.push(format!(
                    "Solids {numbers} touch and could not be united ({why}); they are taken as they are."
                )),
            }
        }
        group.iter().for_each(|solid| append(&mut all, &solid.faced));
    }
    Ok((all, sentences))
}

/// Rising numbers in words, runs of them short.
pub(super) fn numbers(all: &[u32]) -> String {
    let mut runs: Vec<[u32; 2]> = Vec::new();
    for number in all {
        match runs.last_mut() {
            Some([_, last]) if *last + 1 == *number => *last += 1,
            _ => runs.push([*number; 2]),
        }
    }
    let words = |[first, last]: &[u32; 2]| match last - first {
        0 => first.to_string(),
        1 => format!("{first}, {last}"),
        _ => format!("{first} to {last}"),
    };
    runs.iter().map(words).collect::<Vec<_>>().join(", ")
}

fn append(all: &mut FacedMesh, one: &FacedMesh) {
    all.mesh.append(&one.mesh);
    all.face_of.extend(&one.face_of);
}

/// Numbers of the groups of closed solids that touch one another, one by one, and how many groups there are.
fn touching(solids: &[Single], reach: f64, task: &Task) -> Result<(Vec<u32>, usize), Cancelled> {
    let boxes: Vec<Bounds> = solids.iter().map(|s| s.faced.mesh.bounds().grown(0.5 * reach)).collect();
    let mut trees: Vec<Option<Bvh>> = (0..solids.len()).map(|_| None).collect();
    let mut groups = Groups::of(solids.len());
    for a in 0..solids.len() {
        task.check()?;
        for b in a + 1..solids.len() {
            let may_touch = solids[a].is_closed && solids[b].is_closed && boxes[a].intersects(&boxes[b]);
            if !may_touch || groups.first(a) == groups.first(b) {
                continue;
            }
            for n in [a, b] {
                if trees[n].is_none() {
                    trees[n] = Some(Bvh::new(&solids[n].faced.mesh, &task.cancel)?);
                }
            }
            let (Some(one), Some(other)) = (&trees[a], &trees[b]) else { continue };
            let is_within = |a: usize, b: usize| {
                solids[a].faced.mesh.vertices.first().is_some_and(|p| is_inside_of(&solids[b].faced.mesh, *p))
            };
            if one.meets(other, reach, &task.cancel)? || is_within(a, b) || is_within(b, a) {
                groups.join(a, b);
            }
        }
    }
    Ok(groups.numbers())
}

/// The union of solids that touch.
fn united(solids: &[Single], reach: f64, task: &Task) -> Result<FacedMesh, SolidError> {
    let meshes: Vec<&Mesh> = solids.iter().map(|s| &s.faced.mesh).collect();
    let exact: Vec<Option<ExactMesh>> = meshes.par_iter().map(|mesh| ExactMesh::new(mesh).ok()).collect();
    let boxes: Vec<Bounds> = meshes.iter().map(|mesh| mesh.bounds()).collect();
    let mut faced: Vec<FacedMesh> = solids.iter().map(|s| s.faced.clone()).collect();
    let mut set: HashSet<[usize; 2]> = HashSet::new();
    for (into, on) in (0..solids.len()).flat_map(|a| (0..solids.len()).map(move |b| (a, b))) {
        task.check()?;
        let Some(exact) = exact[on].as_ref().filter(|_| into != on && !set.contains(&[on, into])) else { continue };
        if boxes[into].grown(reach).intersects(&boxes[on]) {
            let moved =
                set_into(&solids[into], &Ground { mesh: meshes[on], exact, around: boxes[on].grown(reach) }, reach);
            if !moved.is_empty() {
                set.insert([into, on]);
            }
            moved.into_iter().for_each(|(v, to)| faced[into].mesh.vertices[v as usize] = to);
        }
    }
    let volumes = faced.iter().map(|f| f.mesh.volume());
    let [most, sum] = volumes.fold([0.0, 0.0], |[most, sum], v| [v.max(most), sum + v]);
    let mut body = union_of_faced(&faced, &task.cancel)?;
    drop_gaps(&mut body, reach);
    let volume = body.mesh.volume();
    let slack = reach * body.mesh.area();
    if !body.mesh.is_watertight() || volume < most - slack || volume > sum + slack {
        return Err(SolidError::Failed(format!("{volume:.3} mm^3 of {sum:.3}")));
    }
    Ok(body)
}

/// A solid that faces of others lie on.
struct Ground<'a> {
    mesh: &'a Mesh,
    exact: &'a ExactMesh,
    /// Box around the solid and what touches it.
    around: Bounds,
}

impl Ground<'_> {
    /// The direction into the solid beside `p`.
    fn down(&self, p: DVec3) -> DVec3 {
        -normal_times_two_areas(self.mesh.corners(self.exact.nearest(p).triangle as usize)).normalize_or_zero()
    }

    /// Whether a triangle lies on the surface, facing it.
    fn bears(&self, corners: [DVec3; 3], reach: f64) -> bool {
        let is_on = |p: DVec3| self.exact.signed_distance(p).abs() <= reach;
        let middle = corners.iter().sum::<DVec3>() / 3.0;
        corners.iter().all(|p| self.around.distance_to(*p) <= 0.0)
            && is_on(middle)
            && self.down(middle).dot(normal_times_two_areas(corners)) > 0.0
            && corners.into_iter().all(is_on)
    }
}

/// New places of the vertices of each curved face of a solid that lies wholly on another one: a little within it.
fn set_into(solid: &Single, ground: &Ground, reach: f64) -> Vec<(u32, DVec3)> {
    let FacedMesh { mesh, face_of } = &solid.faced;
    let curved = (solid.first_face..).zip(solid.faces).filter(|(_, f)| !matches!(f.kind, FaceKind::Plane { .. }));
    let mut moved: Vec<(u32, DVec3)> = Vec::new();
    for (face, _) in curved {
        let own: Vec<usize> = (0..face_of.len()).filter(|t| face_of[*t] == face).collect();
        if own.is_empty() || !own.iter().all(|t| ground.bears(mesh.corners(*t), reach)) {
            continue;
        }
        let vertices: BTreeSet<u32> = own.iter().flat_map(|t| mesh.triangles[*t]).collect();
        let walls = walls(mesh, face_of, face, &vertices);
        let place = |v: u32| {
            let p = mesh.vertices[v as usize];
            let down = ground.down(p);
            // Along the walls beside it, so that they stay in their places.
            let along = across(walls.get(&v).map_or(&[], Vec::as_slice), down);
            let to = p + along * (INTO * reach / along.dot(down).max(0.1));
            (ground.exact.signed_distance(to) < 0.0).then_some((v, to))
        };
        moved.extend(vertices.into_iter().map(place).collect::<Option<Vec<_>>>().unwrap_or_default());
    }
    moved
}

/// Directions across what adjoins a face at each of its vertices: one beside a smooth wall, two at the edge of two walls,
/// square to each other.
fn walls(mesh: &Mesh, face_of: &[u32], face: u32, vertices: &BTreeSet<u32>) -> BTreeMap<u32, Vec<DVec3>> {
    /// Sine of the angle from which on two triangles belong to two walls.
    const EDGE: f64 = 0.3;
    let mut walls: BTreeMap<u32, Vec<DVec3>> = BTreeMap::new();
    for (t, _) in mesh.triangles.iter().zip(face_of).filter(|(_, f)| **f != face) {
        let normal = normal_times_two_areas(t.map(|v| mesh.vertices[v as usize])).normalize_or_zero();
        for v in t.iter().filter(|v| vertices.contains(v)) {
            let known = walls.entry(*v).or_default();
            let rest = across(known, normal);
            if rest.length() > EDGE && known.len() < 2 {
                known.push(rest.normalize());
            }
        }
    }
    walls
}

/// The part of a vector that is square to these unit vectors.
fn across(walls: &[DVec3], v: DVec3) -> DVec3 {
    walls.iter().fold(v, |v, wall| v - *wall * v.dot(*wall))
}

/// Drops closed gaps no thicker than `thickness` (mm).
fn drop_gaps(body: &mut FacedMesh, thickness: f64) {
    let (group_of, count) = Groups::of_vertices(&body.mesh).numbers();
    let mut of_group = vec![[0.0; 2]; count];
    for (corners, t) in body.mesh.iter_corners().zip(&body.mesh.triangles) {
        let [volume, area] = &mut of_group[group_of[t[0] as usize] as usize];
        *volume += corners[0].dot(corners[1].cross(corners[2])) / 6.0;
        *area += 0.5 * normal_times_two_areas(corners).length();
    }
    let is_gap = |t: &[u32; 3]| {
        let [volume, area] = of_group[group_of[t[0] as usize] as usize];
        volume <= 0.0 && -volume <= 0.5 * area * thickness
    };
    let kept: Vec<bool> = body.mesh.triangles.iter().map(|t| !is_gap(t)).collect();
    let mut keep = kept.iter();
    body.mesh.triangles.retain(|_| keep.next().is_some_and(|k| *k));
    let mut keep = kept.iter();
    body.face_of.retain(|_| keep.next().is_some_and(|k| *k));
    body.mesh = body.mesh.compacted();
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use step_io::build::{CurveInput, FaceBoundInput, Frame, SurfaceInput};
    use step_io::{Orientation, StepBuilder};

    use super::*;
    use crate::{ImportOptions, import_bytes};
    use Orientation::{Forward, Reversed};

    fn frame(origin: [f64; 3], axis: [f64; 3], ref_dir: [f64; 3]) -> Frame {
        Frame { origin, axis, ref_dir }
    }

    const Z: [f64; 3] = [0.0, 0.0, 1.0];
    const X: [f64; 3] = [1.0, 0.0, 0.0];

    /// A hub of radius 10 from z = 0 to 20, and a blade from z = 5 to 15 that stands on it where |y| < 1, up to x = 15.
    fn hub_and_blade() -> Vec<u8> {
        let mut b = StepBuilder::new();
        let part = b.part("wheel");
        let ends = [0.0, 20.0].map(|z| b.vertex([10.0, 0.0, z]).unwrap());
        let [low, high] = [(0, 0.0), (1, 20.0)]
            .map(|(k, z)| b.edge(ends[k], ends[k], CurveInput::Circle(frame([0.0, 0.0, z], Z, X), 10.0)).unwrap());
        let around = vec![FaceBoundInput::outer(vec![(low, Forward)]), FaceBoundInput::inner(vec![(high, Reversed)])];
        let mut cap = |edge, z, side| {
            let plane = SurfaceInput::Plane(frame([0.0, 0.0, z], Z, X));
            b.face(plane, side, vec![FaceBoundInput::outer(vec![(edge, side)])]).unwrap()
        };
        let caps = [cap(low, 0.0, Reversed), cap(high, 20.0, Forward)];
        let wall = b.face(SurfaceInput::Cylinder(frame([0.0; 3], Z, X), 10.0), Forward, around).unwrap();
        b.solid(part, "hub", vec![wall, caps[0], caps[1]]).unwrap();
        // Corners of the blade by end (z), side (y) and height: on the hub, at the top.
        let foot = 99f64.sqrt();
        let v = [5.0, 15.0].map(|z| [-1.0, 1.0].map(|y| [foot, 15.0].map(|x| b.vertex([x, y, z]).unwrap())));
        let line = |b: &mut StepBuilder, from, to| b.edge(from, to, CurveInput::Line).unwrap();
        let arcs = [0, 1].map(|e| {
            let circle = CurveInput::Circle(frame([0.0, 0.0, 5.0 + 10.0 * e as f64], Z, X), 10.0);
            b.edge(v[e][0][0], v[e][1][0], circle).unwrap()
        });
        let tops = [0, 1].map(|e| line(&mut b, v[e][0][1], v[e][1][1]));
        let ups = [0, 1].map(|e| [0, 1].map(|s| line(&mut b, v[e][s][0], v[e][s][1])));
        let alongs = [0, 1].map(|s| [0, 1].map(|h| line(&mut b, v[0][s][h], v[1][s][h])));
        let mut face =
            |surface, side, edges: Vec<_>| b.face(surface, side, vec![FaceBoundInput::outer(edges)]).unwrap();
        let plane = |origin, axis, x| SurfaceInput::Plane(frame(origin, axis, x));
        let mut faces = vec![face(
            SurfaceInput::Cylinder(frame([0.0; 3], Z, X), 10.0),
            Reversed,
            vec![(arcs[0], Reversed), (alongs[0][0], Forward), (arcs[1], Forward), (alongs[1][0], Reversed)],
        )];
        faces.push(face(
            plane([15.0, 0.0, 0.0], X, Z),
            Forward,
            vec![(tops[0], Forward), (alongs[1][1], Forward), (tops[1], Reversed), (alongs[0][1], Reversed)],
        ));
        for (e, z, axis) in [(0, 5.0, [0.0, 0.0, -1.0]), (1, 15.0, Z)] {
            let around = [(arcs[e], Forward), (ups[e][1], Forward), (tops[e], Reversed), (ups[e][0], Reversed)];
            // Seen from outside, counter-clockwise.
            let turned = |edges: [_; 4]| {
                edges.into_iter().rev().map(|(n, o)| (n, if o == Forward { Reversed } else { Forward }))
            };
            let edges = if e == 0 { around.to_vec() } else { turned(around).collect() };
            faces.push(face(plane([0.0, 0.0, z], axis, X), Forward, edges));
        }
        for (s, y) in [(0, -1.0), (1, 1.0)] {
            let around =
                [(alongs[s][0], Forward), (ups[1][s], Forward), (alongs[s][1], Reversed), (ups[0][s], Reversed)];
            let turned = |edges: [_; 4]| {
                edges.into_iter().rev().map(|(n, o)| (n, if o == Forward { Reversed } else { Forward }))
            };
            let edges = if s == 1 { around.to_vec() } else { turned(around).collect() };
            faces.push(face(plane([0.0, y, 0.0], [0.0, y, 0.0], X), Forward, edges));
        }
        b.solid(part, "blade", faces).unwrap();
        let mut bytes = Vec::new();
        step_io::write(&b.finish(), &mut bytes).unwrap();
        bytes
    }

    #[test]
    fn a_blade_that_stands_on_its_hub_becomes_one_body_with_it() {
        let part = import_bytes("wheel.step", &hub_and_blade(), &ImportOptions::default(), &Task::default()).unwrap();
        let report = &part.report;
        assert!(report.solids.iter().all(|s| s.is_closed && s.is_taken), "{:?}", report.solids);
        assert!(report.warnings.iter().any(|w| w == "Solids 1, 2 touch and were united."), "{:?}", report.warnings);
        assert!(report.watertight && report.components == 1 && report.non_manifold_edges == 0, "{report:?}");
        let blade = 10.0 * (30.0 - 99f64.sqrt() - 100.0 * 0.1f64.asin());
        let volume = 2000.0 * PI + blade;
        let slack = 0.005 * part.mesh.area();
        assert!((part.mesh.volume() - volume).abs() < slack, "{} for {volume}", part.mesh.volume());
        // No gap is left between them: a ray from the axis through the blade leaves metal once.
        for z in [5.4, 9.9, 14.6] {
            for y in [-0.9, -0.31, 0.02, 0.77] {
                let exact = ExactMesh::new(&part.mesh).unwrap();
                let from = DVec3::new(0.0, y, z);
                let first = exact.first_crossing(from, DVec3::X, 100.0).unwrap();
                assert!((first - 15.0).abs() < 1e-9, "metal ends at {first}");
            }
        }
        // The foot of the blade is gone, all other faces are known where they were.
        let faces = part.faces.as_ref().unwrap();
        let mut areas = vec![0.0; faces.faces.len()];
        for (corners, face) in part.mesh.iter_corners().zip(&faces.face_of) {
            areas[*face as usize] += 0.5 * normal_times_two_areas(corners).length();
            if let FaceKind::Plane { normal, offset } = faces.faces[*face as usize].kind {
                assert!(corners.iter().all(|p| (p.dot(normal) - offset).abs() < 1e-6), "face {face}");
            }
        }
        let foot = 10.0 * 20.0 * 0.1f64.asin();
        assert!((areas[0] - (400.0 * PI - foot)).abs() < 1.0, "{areas:?}");
        assert!((areas[3] < 1e-9) && (areas[4] - 20.0).abs() < 1e-6, "{areas:?}");
    }
}
