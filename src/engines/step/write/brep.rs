//! The solid's faces, edges and vertices, from the regions of a skin.

use std::collections::{BTreeSet, HashMap};

use geometry::exact::ExactMesh;
use geometry::mesh::unit_normal;
use glam::{DVec2, DVec3};
use rayon::prelude::*;
use task::Task;

use super::StepWriteError;
use super::curve::{Course, EdgeCurve};
use super::divide;
use super::map::Map;
use super::net::{Chain, Net, Use, net};
use super::quad::{self, Quad, Sides, Target};
use super::regions::{self, Region};
use super::skin::Skin;
use super::spline::{Curve, SplineSurface};
use super::surface::Surface;

/// Rounds of cutting free forms that cannot be fitted.
const ROUNDS: usize = 8;
/// Rounds of dividing chains that no curve follows, between two of these.
const SPLITS: usize = 8;
/// Share of the tolerance within which free forms are fitted.
const FIT: f64 = 0.8;
/// Rounds in which folds are not accepted at all.
const EARLY: usize = 3;
/// Places of folds that are accepted in later rounds.
const SMALL_FOLDS: f64 = 4.0;
/// Greatest distance of an edge from a cylinder or cone beside it (mm), and tolerances: beyond it, that face is made a
/// free form.
const MOST_GAP: [f64; 2] = [5e-4, 0.2];

/// An edge of the solid.
#[derive(Debug, Clone)]
pub(super) struct Edge {
    /// Numbers of the vertices from and to.
    pub(super) ends: [usize; 2],
    /// Curve.
    pub(super) curve: EdgeCurve,
}

/// The surface of a face.
#[derive(Debug, Clone)]
pub(super) enum FaceSurface {
    /// A plane, cylinder or cone.
    Exact(Surface),
    /// A free form; its normal points outwards.
    Free(SplineSurface),
}

/// A face of the solid.
#[derive(Debug, Clone)]
pub(super) struct Face {
    /// Surface.
    pub(super) surface: FaceSurface,
    /// Number of its role.
    pub(super) role: u16,
    /// Loops of edges with their senses, counter-clockwise seen from outside; the outer one first.
    pub(super) loops: Vec<Vec<(usize, bool)>>,
}

/// A solid with its boundary.
#[derive(Debug, Clone, Default)]
pub(super) struct Brep {
    /// Vertices (mm).
    pub(super) vertices: Vec<DVec3>,
    /// Edges.
    pub(super) edges: Vec<Edge>,
    /// Faces, one a region and in their order.
    pub(super) faces: Vec<Face>,
    /// The greatest distance of an edge from the planes, cylinders and cones beside it (mm).
    pub(super) edge_gap: f64,
}

/// Surfaces of free forms that are known already, by the vertices of the skin around them, corners first, and the control
/// points of their sides.
type Known = HashMap<Vec<u64>, Quad>;

/// Fits curves and free forms, cutting regions of `skin` where that is needed.
pub(super) fn brep(
    skin: &mut Skin,
    regions: &mut Vec<Region>,
    tolerance: f64,
    task: &Task,
) -> Result<Brep, StepWriteError> {
    let (mut splits, mut known) = (BTreeSet::new(), Known::new());
    for round in 0..=ROUNDS {
        task.report("faces", round as f64 / ROUNDS as f64, "");
        let (net, curves) = laid(skin, regions, &mut splits, tolerance, task)?;
        let quads = quads(&net, &curves, regions, &known, tolerance, task)?;
        let mut failing: Vec<(u32, f64, DVec3)> = Vec::new();
        for (r, quad) in (0u32..).zip(&quads) {
            match quad {
                Some(quad)
                    if quad.distance > FIT * tolerance
                        || quad.excess > if round < EARLY { 0.0 } else { SMALL_FOLDS } =>
                {
                    failing.push((r, quad.distance, quad.at))
                }
                None if regions[r as usize].surface.is_none() => {
                    failing.push((r, f64::INFINITY, net.pieces[r as usize].points[0]));
                }
                _ => {}
            }
        }
        let worst = failing.iter().copied().reduce(|a, b| if b.1 > a.1 { b } else { a });
        let is_last = round == ROUNDS;
        match worst {
            Some((_, distance, at)) if is_last && distance > 2.0 * tolerance => {
                return Err(StepWriteError::Fit { at, distance, tolerance });
            }
            Some(_) if !is_last => {}
            _ => return Ok(assembled(&net, curves, quads, regions)),
        }
        known = net
            .pieces
            .iter()
            .enumerate()
            .filter_map(|(r, _)| Some((net.signature(&curves, r)?, quads[r].clone()?)))
            .collect();
        // What stays small after several cuts has no form of its own: its facets are faces.
        let is_facets = |r: u32| round + 1 >= EARLY && net.pieces[r as usize].triangles.len() <= divide::MOST_FACETS;
        let (facets, halves): (Vec<u32>, Vec<u32>) = failing.iter().map(|f| f.0).partition(|&r| is_facets(r));
        divide::into_facets(skin, regions, &facets, tolerance);
        divide::halve(skin, regions, &halves)?;
        if !facets.is_empty() {
            regions::join_slivers(skin, regions, tolerance);
        }
    }
    Err(StepWriteError::Divide { at: skin.corners(0)[0] })
}

/// The net of borders with the curves of its chains, which are divided until each has one. Cylinders and cones that
/// their edges do not lie on become free forms.
fn laid(
    skin: &mut Skin,
    regions: &mut Vec<Region>,
    splits: &mut BTreeSet<u32>,
    tolerance: f64,
    task: &Task,
) -> Result<(Net, Vec<EdgeCurve>), StepWriteError> {
    divide::into_discs(skin, regions, tolerance)?;
    for _ in 0..SPLITS {
        task.check()?;
        let net = net(skin, regions, splits, tolerance);
        let curves: Vec<EdgeCurve> =
            net.chains.par_iter().map(|c| course(&net, c, regions, tolerance).curve()).collect();
        let is_done = {
            let found = net.chains.iter().zip(&curves).filter_map(|(chain, curve)| Some(chain.vertices[curve.split?]));
            let before = splits.len();
            splits.extend(found);
            splits.len() == before
        };
        if !is_done {
            continue;
        }
        if !freed(&net, &curves, regions, tolerance) {
            return Ok((net, curves));
        }
        divide::into_discs(skin, regions, tolerance)?;
    }
    let net = net(skin, regions, splits, tolerance);
    let curves = net.chains.par_iter().map(|c| course(&net, c, regions, tolerance).curve()).collect();
    Ok((net, curves))
}

fn course<'a>(net: &Net, chain: &Chain, regions: &'a [Region], tolerance: f64) -> Course<'a> {
    let surfaces: Vec<&Surface> = chain.regions.iter().filter_map(|&r| regions[r as usize].surface.as_ref()).collect();
    Course { is_at_free: surfaces.len() < 2, surfaces, line: net.line(chain), tolerance }
}

/// Makes cylinders and cones free forms whose edges do not lie on them; whether there were any.
fn freed(net: &Net, curves: &[EdgeCurve], regions: &mut [Region], tolerance: f64) -> bool {
    let mut is_any = false;
    for (chain, curve) in net.chains.iter().zip(curves) {
        if curve.gap <= MOST_GAP[0].max(MOST_GAP[1] * tolerance) {
            continue;
        }
        for &r in &chain.regions {
            let region = &mut regions[r as usize];
            if region.surface.as_ref().is_some_and(|s| s.axis().is_some()) {
                region.surface = None;
                is_any = true;
            }
        }
    }
    is_any
}

/// The surfaces of all free forms.
fn quads(
    net: &Net,
    curves: &[EdgeCurve],
    regions: &[Region],
    known: &Known,
    tolerance: f64,
    task: &Task,
) -> Result<Vec<Option<Quad>>, StepWriteError> {
    let fitted = |r: usize| {
        if regions[r].surface.is_some() {
            return Ok(None);
        }
        let Some(signature) = net.signature(curves, r) else { return Ok(None) };
        match known.get(&signature) {
            Some(quad) => Ok(Some(quad.clone())),
            None => quad_of(net, curves, r, tolerance, task),
        }
    };
    (0..regions.len()).into_par_iter().map(fitted).collect()
}

fn quad_of(
    net: &Net,
    curves: &[EdgeCurve],
    r: usize,
    tolerance: f64,
    task: &Task,
) -> Result<Option<Quad>, StepWriteError> {
    let piece = &net.pieces[r];
    let Some((sides, on_border)) = outline(net, curves, r) else { return Ok(None) };
    let map = Map::of(piece, &on_border);
    task.check()?;
    let mesh = piece.mesh();
    let exact = ExactMesh::new(&mesh).map_err(|_| StepWriteError::Unusable)?;
    let normals: Vec<DVec3> = mesh.iter_corners().map(unit_normal).collect();
    let target = Target { map: &map, exact: &exact, normals: &normals, tolerance: FIT * tolerance };
    Ok(quad::fit(&target, &sides, task)?)
}

/// The sides of a free form, and the places of its border in the unit square.
fn outline(net: &Net, curves: &[EdgeCurve], r: usize) -> Option<(Sides, HashMap<u32, DVec2>)> {
    let (line, uses, corners) = (net.pieces[r].loops.first()?, net.uses[r].first()?, net.corners[r]?);
    let mut on_border = HashMap::new();
    let mut sides = Vec::with_capacity(4);
    for k in 0..4 {
        let of_side = side_uses(uses, corners, k)?;
        let parts: Vec<Curve> = of_side.iter().map(|u| directed(&curves[u.chain], u.is_forward).0).collect();
        let lengths: Vec<f64> = of_side.iter().map(|u| length(&net.line(&net.chains[u.chain]))).collect();
        let joints = joints(&lengths);
        for (n, used) in of_side.iter().enumerate() {
            for (i, t) in directed(&curves[used.chain], used.is_forward).1.into_iter().enumerate() {
                let t = joints[n] + (joints[n + 1] - joints[n]) * t;
                let place = match k {
                    0 => DVec2::new(t, 0.0),
                    1 => DVec2::new(1.0, t),
                    2 => DVec2::new(1.0 - t, 1.0),
                    _ => DVec2::new(0.0, 1.0 - t),
                };
                on_border.insert(line[(used.start + i) % line.len()], place);
            }
        }
        sides.push(Curve::chained(&parts, &joints));
    }
    let along_u = [sides[0].clone(), sides[2].reversed()];
    let along_v = [sides[3].reversed(), sides[1].clone()];
    Some((Sides { along_u, along_v }, on_border))
}

/// The chains of a side, in the order of the line.
fn side_uses(uses: &[Use], corners: [usize; 4], side: usize) -> Option<Vec<Use>> {
    let at = |corner: usize| uses.iter().position(|u| u.start == corner);
    let (from, to) = (at(corners[side])?, at(corners[(side + 1) % 4])?);
    let count = (to + uses.len() - from - 1) % uses.len() + 1;
    Some((0..count).map(|k| uses[(from + k) % uses.len()]).collect())
}

/// The spline of an edge in one of its senses, and the parameters of the points of its chain.
fn directed(curve: &EdgeCurve, is_forward: bool) -> (Curve, Vec<f64>) {
    if is_forward {
        return (curve.spline.clone(), curve.parameters.clone());
    }
    (curve.spline.reversed(), curve.parameters.iter().rev().map(|t| 1.0 - t).collect())
}

fn length(line: &[DVec3]) -> f64 {
    line.windows(2).map(|w| w[0].distance(w[1])).sum()
}

/// Dyadic fractions that divide the unit interval about in the proportion of lengths.
fn joints(lengths: &[f64]) -> Vec<f64> {
    let whole = lengths.iter().sum::<f64>().max(f64::MIN_POSITIVE);
    let mut wanted = vec![0.0];
    lengths.iter().for_each(|l| wanted.push(wanted[wanted.len() - 1] + l / whole));
    let count = lengths.len();
    let mut parts = 1usize;
    loop {
        let mut joints: Vec<f64> = wanted.iter().map(|w| (w * parts as f64).round()).collect();
        // Every part gets one step at least.
        for k in 1..count {
            joints[k] = joints[k].max(joints[k - 1] + 1.0).min(parts as f64 - (count - k) as f64);
        }
        joints[count] = parts as f64;
        let is_fine = joints.windows(2).zip(wanted.windows(2)).all(|(j, w)| {
            let (got, asked) = ((j[1] - j[0]) / parts as f64, w[1] - w[0]);
            j[1] > j[0] && (got <= 1.4 * asked || got <= 1.0 / 64.0) && got >= 0.7 * asked
        });
        if is_fine || (parts >= 64 && parts >= 4 * count) {
            return joints.iter().map(|j| j / parts as f64).collect();
        }
        parts *= 2;
    }
}

impl Net {
    /// What the surface of a free form depends on: the vertices around it from its first corner on, where chains and sides
    /// begin, and the curves of the sides.
    fn signature(&self, curves: &[EdgeCurve], r: usize) -> Option<Vec<u64>> {
        let (line, corners) = (self.pieces[r].loops.first()?, self.corners[r]?);
        let around = (0..line.len()).map(|k| line[(corners[0] + k) % line.len()] as usize);
        let mut signature: Vec<u64> = around.map(|v| u64::from(self.pieces[r].of_skin[v])).collect();
        signature.extend(corners.map(|c| u64::from(line[c])));
        for used in self.uses[r].iter().flatten() {
            signature.push(u64::from(line[used.start]));
            let controls = curves[used.chain].spline.controls.iter().flat_map(|p| p.to_array());
            signature.extend(controls.map(f64::to_bits));
        }
        Some(signature)
    }
}

fn assembled(net: &Net, curves: Vec<EdgeCurve>, quads: Vec<Option<Quad>>, regions: &[Region]) -> Brep {
    let mut brep = Brep { edge_gap: curves.iter().map(|c| c.gap).fold(0.0, f64::max), ..Default::default() };
    let mut number: HashMap<u32, usize> = HashMap::new();
    for (chain, curve) in net.chains.iter().zip(curves) {
        let ends = [chain.vertices[0], chain.vertices[chain.vertices.len() - 1]].map(|v| {
            *number.entry(v).or_insert_with(|| {
                brep.vertices.push(net.points[v as usize]);
                brep.vertices.len() - 1
            })
        });
        brep.edges.push(Edge { ends, curve });
    }
    for (r, (quad, region)) in quads.into_iter().zip(regions).enumerate() {
        let surface = match (&region.surface, quad) {
            (Some(surface), _) => FaceSurface::Exact(surface.clone()),
            (None, Some(quad)) => FaceSurface::Free(quad.surface),
            (None, None) => continue,
        };
        let mut order: Vec<usize> = (0..net.uses[r].len()).collect();
        if let Some(surface) = &region.surface {
            // The loop that goes around all others encloses most.
            let area = |k: &usize| enclosed(surface, &net.loop_points(r, *k));
            order.sort_by(|a, b| area(b).total_cmp(&area(a)));
        }
        let edges = |k: &usize| net.uses[r][*k].iter().map(|u| (u.chain, u.is_forward)).collect();
        brep.faces.push(Face { surface, role: region.role, loops: order.iter().map(edges).collect() });
    }
    brep
}

impl Net {
    fn loop_points(&self, r: usize, k: usize) -> Vec<DVec3> {
        self.pieces[r].loops[k].iter().map(|&v| self.pieces[r].points[v as usize]).collect()
    }
}

/// The area that a closed line encloses in the parameters of a surface, positive where it runs counter-clockwise.
pub(super) fn enclosed(surface: &Surface, points: &[DVec3]) -> f64 {
    let (Surface::Plane(axes) | Surface::Cylinder { axes, .. } | Surface::Cone { axes, .. }) = surface;
    let is_hollow =
        matches!(surface, Surface::Cylinder { is_hollow: true, .. } | Surface::Cone { is_hollow: true, .. });
    let mut places: Vec<DVec2> = Vec::with_capacity(points.len());
    for &p in points {
        let local = axes.local(p);
        let place = if surface.axis().is_none() {
            local.truncate()
        } else {
            let mut angle = local.y.atan2(local.x);
            if let Some(before) = places.last() {
                angle += ((before.x - angle) / std::f64::consts::TAU).round() * std::f64::consts::TAU;
            }
            DVec2::new(angle, local.z)
        };
        places.push(place);
    }
    let area: f64 = (0..places.len()).map(|k| places[k].perp_dot(places[(k + 1) % places.len()])).sum::<f64>() * 0.5;
    if is_hollow { -area } else { area }
}
