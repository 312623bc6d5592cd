//! Figures of an electrode: thickness, burn area, distance to the blisk, reference point.

use glam::{DMat3, DVec3};
use rayon::prelude::*;

use super::{ElectrodeError, ElectrodeFace, EntrySide};
use crate::channel::Flow;
use geometry::bvh::Bvh;
use geometry::exact::ExactMesh;
use geometry::inside::guarded_distance;
use geometry::mesh::{Bounds, Mesh, normal_times_two_areas, unit_normal};
use geometry::nearest_pair::nearest_pair;
use geometry::triangle_distance::ClosestPoints;
use task::{Cancel, Cancelled};

/// How far thickness is looked for (mm).
const REACH: f64 = 1e3;
/// Places along an edge are no further apart than this (mm).
const ALONG_EDGE: f64 = 0.5;
/// Places processed between two checks of the cancel flag.
const BATCH: usize = 256;

/// Figures of an electrode.
pub(super) struct Measures {
    /// Thinnest metal between the walls (mm).
    pub thickness: f64,
    /// Area of the faces that burn (mm^2).
    pub burn_area: f64,
    /// Least distance to the blisk (mm), negative where a vertex, a place along an edge or the centre of a face is
    /// inside it.
    pub clearance: f64,
    /// Place of that distance on the electrode, in W (mm).
    pub closest: DVec3,
}

pub(super) fn measure(
    mesh: &Mesh,
    faces: &[ElectrodeFace],
    blisk: &ExactMesh,
    cancel: &Cancel,
) -> Result<Measures, ElectrodeError> {
    let (mut clearance, mut closest) = least_clearance(mesh, blisk, cancel)?;
    if let Some(nearest) = surface_distance(mesh, blisk, clearance, cancel)? {
        (clearance, closest) = (nearest.distance, nearest.first);
    }
    Ok(Measures {
        thickness: least_thickness(mesh, faces, cancel)?,
        burn_area: burn_area(mesh, faces),
        clearance,
        closest,
    })
}

/// Area of the faces that burn (mm^2).
pub(super) fn burn_area(mesh: &Mesh, faces: &[ElectrodeFace]) -> f64 {
    let burning = mesh.iter_corners().zip(faces).filter(|(_, face)| face.burns());
    burning.map(|(corners, _)| 0.5 * normal_times_two_areas(corners).length()).sum()
}

/// The reference point O of an electrode that leaves a passage of direction `flow` towards `side`: in an axial one the
/// middle of its burning faces along X, y = 0, the mean of their least and greatest radius as z; in any other the middle
/// of the holder, or of the whole electrode where none is told apart, across the direction of withdrawal, that of the
/// burning faces along it (mm).
pub(super) fn reference_point(mesh: &Mesh, faces: &[ElectrodeFace], side: EntrySide, flow: Flow) -> DVec3 {
    let box_of = |is_of: &dyn Fn(ElectrodeFace) -> bool, place: &dyn Fn(DVec3) -> DVec3| {
        let all = mesh.iter_corners().zip(faces).filter(|(_, face)| is_of(**face)).flat_map(|(corners, _)| corners);
        Bounds::of(all.map(place)).center()
    };
    if flow == Flow::Axial {
        return box_of(&|f| f.burns(), &|p| DVec3::new(p.x, 0.0, p.y.hypot(p.z)));
    }
    let has_holder = faces.contains(&ElectrodeFace::Holder);
    let holder = box_of(&|f| f == ElectrodeFace::Holder || !has_holder, &|p| p);
    let burning = box_of(&|f| f.burns(), &|p| p);
    let way = side.direction();
    holder.reject_from_normalized(way) + burning.project_onto_normalized(way)
}

/// The thinnest metal between the low and the high wall, or a wall and the division, from the centre of each wall face
/// along its normal (mm).
pub(super) fn least_thickness(mesh: &Mesh, faces: &[ElectrodeFace], cancel: &Cancel) -> Result<f64, ElectrodeError> {
    let own = ExactMesh::new(mesh)?;
    let through = |i: usize, opposite: &[ElectrodeFace]| {
        let corners = mesh.corners(i);
        let inward = -unit_normal(corners);
        let center = corners.iter().sum::<DVec3>() / 3.0;
        // Start just under the face, so that the face itself is not met.
        let start = center + inward * 1e-6;
        let depth = own.first_crossing(start, inward, REACH)?;
        let met = own.nearest(start + inward * depth).triangle as usize;
        faces.get(met).is_some_and(|face| opposite.contains(face)).then_some(depth + 1e-6)
    };
    let depths = in_batches(faces.len(), cancel, |i| match faces[i] {
        ElectrodeFace::LowWall => through(i, &[ElectrodeFace::HighWall, ElectrodeFace::Division]),
        ElectrodeFace::HighWall => through(i, &[ElectrodeFace::LowWall, ElectrodeFace::Division]),
        _ => None,
    })?;
    Ok(depths.into_iter().flatten().fold(f64::INFINITY, f64::min))
}

/// The closest points of `mesh` and of `blisk`, if they are not inside each other and nearer than `known` (mm).
pub(super) fn surface_distance(
    mesh: &Mesh,
    blisk: &ExactMesh,
    known: f64,
    cancel: &Cancel,
) -> Result<Option<ClosestPoints>, Cancelled> {
    if known.is_nan() || known <= 0.0 {
        return Ok(None);
    }
    let around = Bvh::new(&blisk.part_within(mesh.bounds().grown(known)), cancel)?;
    let own = Bvh::new(mesh, cancel)?;
    if around.is_empty() || own.is_empty() {
        return Ok(None);
    }
    let found = nearest_pair(&own, &around, (&DMat3::IDENTITY, DVec3::ZERO), None).points;
    Ok(Some(found).filter(|points| points.distance < known))
}

fn least_clearance(mesh: &Mesh, blisk: &ExactMesh, cancel: &Cancel) -> Result<(f64, DVec3), ElectrodeError> {
    let mut places = mesh.vertices.clone();
    for [a, b, c] in mesh.iter_corners() {
        places.push((a + b + c) / 3.0);
    }
    for &[a, b, c] in &mesh.triangles {
        // Each edge belongs to two triangles: look at it from one of them.
        for (p, q) in [(a, b), (b, c), (c, a)].into_iter().filter(|(p, q)| p < q) {
            let (p, q) = (mesh.vertices[p as usize], mesh.vertices[q as usize]);
            // Blades are thinner than a straight shank is long. The middle is always looked at.
            let pieces = 2.0 * (0.5 * p.distance(q) / ALONG_EDGE).ceil().clamp(1.0, 500.0);
            places.extend((1..pieces as usize).map(|i| p.lerp(q, i as f64 / pieces)));
        }
    }
    let distances = in_batches(places.len(), cancel, |i| guarded_distance(blisk, places[i]))?;
    let least = distances.into_iter().zip(places).reduce(|a, b| if b.0 < a.0 { b } else { a });
    Ok(least.unwrap_or((f64::INFINITY, DVec3::ZERO)))
}

/// `f` of every index below `n`, in order, by all threads, with a look at `cancel` between batches.
pub(super) fn in_batches<T: Send>(
    n: usize,
    cancel: &Cancel,
    f: impl Fn(usize) -> T + Sync,
) -> Result<Vec<T>, ElectrodeError> {
    let batches: Vec<_> = (0..n.div_ceil(BATCH))
        .into_par_iter()
        .map(|batch| {
            cancel.check()?;
            Ok::<_, ElectrodeError>((batch * BATCH..((batch + 1) * BATCH).min(n)).map(&f).collect::<Vec<_>>())
        })
        .collect();
    Ok(batches.into_iter().collect::<Result<Vec<_>, _>>()?.into_iter().flatten().collect())
}
