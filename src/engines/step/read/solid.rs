//! The mesh of one solid.

use std::collections::{HashMap, HashSet};

use geometry::mesh::Mesh;
use geometry::segmentation::{FaceKind, KnownFace};
use glam::{DMat4, DVec3};
use rayon::prelude::*;
use step_io::model::{Axis2Placement3dRef, CartesianPointRef, DirectionRef, EntityKey};
use step_io::scene::{Edge, Face, SurfaceKind, Vertex};
use step_io::{Orientation, StepModel};
use task::{Cancel, Task};

use super::assembly::Placed;
use super::domain::{Node, OWN, domain};
use super::surface::{Axes, Shape, Surface};
use super::triangulate::{CANCELLED, CROSSES, FaceMesh, triangulate};
use super::{Fault, Fineness, Options, Solid, edges};
use crate::error::StepError;

/// How often edges are halved beyond what they need by themselves, where faces beside them need it.
const MOST_LEVEL: u32 = 5;

/// Points of an edge in the numbers of its solid: start, points between, end.
type Chain = Vec<Node>;

/// A face with the edges around it.
struct Bounded<'m> {
    face: Face<'m>,
    /// Whether the outside is that of the surface's normal.
    is_forward: bool,
    /// Numbers of edges, and whether each is passed from start to end, counter-clockwise around the surface's normal.
    loops: Vec<Vec<(usize, bool)>>,
}

/// The meshes of a solid at all its places. `[unit, angle, precision]` are millimetres and radians in the units of the
/// file, and its precision in its own unit.
pub(super) fn tessellate(
    placed: &Placed,
    model: &StepModel,
    [unit, angle, precision]: [f64; 3],
    options: &Options,
    task: &Task,
) -> Result<Vec<Solid>, StepError> {
    // A tenth is left for what lies between the places that are looked at.
    let chord = 0.9 * options.chord / unit;
    let joined = (0.1 * chord).max(2.0 * precision.abs().min(chord));
    let fine = |chord: f64| Fineness { chord, turn: options.turn, least_length: 2.0 * chord, joined };
    let made = |chord: f64| at_fineness(placed, model, [unit, angle], &fine(chord), options.max_triangles, task);
    let mut solid = made(chord)?;
    if solid.faults.is_empty() && solid.is_closed() {
        // What chords leave is a share of the volume as they are of the thickness.
        let thickness = 2.0 * solid.mesh.volume().abs() / solid.mesh.area().max(f64::MIN_POSITIVE);
        let thin = (thickness / unit / THIN).max(FINEST * chord);
        if thin < chord {
            let finer = made(thin)?;
            if finer.faults.is_empty() && finer.is_closed() {
                solid = finer;
            }
        }
    }
    Ok(placed.places.iter().enumerate().map(|(n, at)| at_place(&solid, n, *at, unit)).collect())
}

/// A solid whose mean thickness is less than so many chord errors gets finer triangles, so that its volume holds.
const THIN: f64 = 100.0;
/// Least chord error of such triangles, as a share of that which is asked for.
const FINEST: f64 = 0.25;

/// The mesh of a solid in millimetres, where it stands by itself, with triangles this fine.
fn at_fineness(
    placed: &Placed,
    model: &StepModel,
    [unit, angle]: [f64; 2],
    fine: &Fineness,
    max_triangles: u64,
    task: &Task,
) -> Result<Solid, StepError> {
    let mut table = Table::default();
    let bounded: Vec<Bounded> = placed.faces.iter().map(|(face, turned)| table.face(*face, *turned)).collect();
    let surfaces: Vec<Option<Surface>> =
        bounded.par_iter().map(|b| surface(&b.face, model, angle, fine.joined)).collect();
    let most = usize::try_from(max_triangles / 2).unwrap_or(usize::MAX);
    let mut points = Points::default();
    let mut meshes: Vec<Result<FaceMesh, &'static str>> = (0..bounded.len()).map(|_| Err("not made")).collect();
    let mut due: Vec<usize> = (0..bounded.len()).collect();
    for level in 0..=MOST_LEVEL {
        table.sample(&mut points, fine);
        let made: Vec<(usize, Result<FaceMesh, &'static str>)> = due
            .par_iter()
            .map(|&n| {
                if task.check().is_err() {
                    return (n, Err(CANCELLED));
                }
                let surface = surfaces[n].as_ref().ok_or("its surface is of a kind that is not read");
                (n, surface.and_then(|s| face_mesh(&bounded[n], s, &points.chains, (most, fine), &task.cancel)))
            })
            .collect();
        task.check()?;
        made.into_iter().for_each(|(n, mesh)| meshes[n] = mesh);
        let coarse = table.coarse(&bounded, &meshes, &due, &points);
        if coarse.is_empty() || level == MOST_LEVEL {
            break;
        }
        coarse.iter().for_each(|&edge| {
            table.levels[edge] += 1;
            points.chains[edge] = None;
        });
        due = (0..bounded.len())
            .filter(|&n| bounded[n].loops.iter().flatten().any(|(e, _)| coarse.contains(e)))
            .collect();
    }
    let mut solid = assemble(placed, &bounded, &surfaces, points.all, meshes);
    for p in &mut solid.mesh.vertices {
        *p *= unit;
    }
    solid.faults.iter_mut().for_each(|f| f.place *= unit);
    let scale = DMat4::from_scale(DVec3::splat(unit));
    solid.faces.iter_mut().for_each(|face| *face = face.placed(&scale, unit));
    Ok(solid)
}

/// Vertices and edges of a solid, each once.
#[derive(Default)]
struct Table<'m> {
    edges: Vec<Edge<'m>>,
    /// How often each is halved beyond what it needs by itself.
    levels: Vec<u32>,
    of_edge: HashMap<EntityKey, usize>,
}

impl<'m> Table<'m> {
    fn face(&mut self, face: Face<'m>, is_turned: bool) -> Bounded<'m> {
        let is_forward = face.orientation() == Orientation::Forward;
        let mut loops = Vec::new();
        for bound in face.bounds() {
            let mut around: Vec<(usize, bool)> =
                bound.oriented_edges().map(|(edge, o)| (self.edge(edge), o == Orientation::Forward)).collect();
            // Loops are counter-clockwise around the face: turned where that is not the surface's side.
            if (bound.orientation() == Orientation::Forward) != is_forward {
                around.reverse();
                around.iter_mut().for_each(|e| e.1 = !e.1);
            }
            loops.push(around);
        }
        Bounded { face, is_forward: is_forward != is_turned, loops }
    }

    fn edge(&mut self, edge: Edge<'m>) -> usize {
        *self.of_edge.entry(edge.key()).or_insert_with(|| {
            self.edges.push(edge);
            self.levels.push(0);
            self.edges.len() - 1
        })
    }

    /// Makes the points of edges that have none.
    fn sample(&self, points: &mut Points, fine: &Fineness) {
        points.chains.resize(self.edges.len(), None);
        let due: Vec<usize> = (0..self.edges.len()).filter(|e| points.chains[*e].is_none()).collect();
        let ends: Vec<Option<[Node; 2]>> = due
            .iter()
            .map(|&e| Some([points.vertex(self.edges[e].start()?)?, points.vertex(self.edges[e].end()?)?]))
            .collect();
        let between: Vec<Vec<DVec3>> = due
            .par_iter()
            .zip(&ends)
            .map(|(&e, ends)| {
                let Some([start, end]) = ends else { return Vec::new() };
                let curve = self.edges[e].to_nurbs().and_then(|c| edges::curve(&c));
                curve.map_or_else(Vec::new, |c| edges::points(&c, start.1 == end.1, self.levels[e], fine))
            })
            .collect();
        for ((e, ends), between) in due.into_iter().zip(ends).zip(between) {
            points.chains[e] = ends.map(|[start, end]| {
                let mut chain = vec![start];
                chain.extend(between.into_iter().map(|p| (p, points.add(p))));
                chain.push(end);
                chain
            });
        }
    }

    /// Edges that are to be halved: those with sides too long for a face, and all of a face whose boundary crosses
    /// itself.
    fn coarse(
        &self,
        bounded: &[Bounded],
        meshes: &[Result<FaceMesh, &'static str>],
        due: &[usize],
        points: &Points,
    ) -> HashSet<usize> {
        let mut coarse = HashSet::new();
        for &n in due {
            let around = bounded[n].loops.iter().flatten().map(|(e, _)| *e);
            match &meshes[n] {
                Ok(mesh) if mesh.coarse_sides.is_empty() => {}
                Ok(mesh) => {
                    let sides: HashSet<[u32; 2]> =
                        mesh.coarse_sides.iter().flat_map(|&[a, b]| [[a, b], [b, a]]).collect();
                    let is_coarse = |e: &usize| {
                        let chain = points.chains[*e].as_ref();
                        chain.is_some_and(|c| c.windows(2).any(|w| sides.contains(&[w[0].1, w[1].1])))
                    };
                    coarse.extend(around.filter(is_coarse));
                }
                Err(problem) if *problem == CROSSES => coarse.extend(around),
                Err(_) => {}
            }
        }
        coarse
    }
}

/// Points along the edges of a solid.
#[derive(Default)]
struct Points {
    all: Vec<DVec3>,
    of_vertex: HashMap<EntityKey, Node>,
    /// Of each edge, if it has any.
    chains: Vec<Option<Chain>>,
}

impl Points {
    fn add(&mut self, p: DVec3) -> u32 {
        self.all.push(p);
        self.all.len() as u32 - 1
    }

    fn vertex(&mut self, vertex: Vertex) -> Option<Node> {
        if let Some(node) = self.of_vertex.get(&vertex.key()) {
            return Some(*node);
        }
        let p = DVec3::from(vertex.point()?.xyz());
        let node = (p, self.add(p));
        self.of_vertex.insert(vertex.key(), node);
        Some(node)
    }
}

/// The triangles of a face.
fn face_mesh(
    bounded: &Bounded,
    surface: &Surface,
    chains: &[Option<Chain>],
    (most, fine): (usize, &Fineness),
    cancel: &Cancel,
) -> Result<FaceMesh, &'static str> {
    let mut loops = node_loops(&bounded.loops, chains)?;
    let mut surface = surface.clone();
    if surface.is_flipped {
        loops.iter_mut().for_each(|l| l.reverse());
    }
    let domain = domain(&mut surface, &loops, fine, cancel)?;
    let mut mesh = triangulate(&surface, &domain, (most, fine), cancel)?;
    if mesh.triangles.is_empty() {
        return Err("it has no area");
    }
    if bounded.is_forward == surface.is_flipped {
        mesh.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    }
    Ok(mesh)
}

/// Closed loops of points. Edges that are passed in both directions are left out, and the rest is joined anew.
fn node_loops(loops: &[Vec<(usize, bool)>], chains: &[Option<Chain>]) -> Result<Vec<Vec<Node>>, &'static str> {
    const NO_EDGE: &str = "an edge of its boundary has no points";
    let mut passes: HashMap<usize, [usize; 2]> = HashMap::new();
    for (edge, forward) in loops.iter().flatten() {
        passes.entry(*edge).or_insert([0, 0])[usize::from(*forward)] += 1;
    }
    let is_seam = |edge: &usize| passes.get(edge).is_some_and(|[a, b]| *a > 0 && a == b);
    let mut found = Vec::new();
    for around in loops {
        let kept: Vec<Vec<Node>> = around
            .iter()
            .filter(|(edge, _)| !is_seam(edge))
            .map(|(edge, forward)| {
                let mut chain = chains.get(*edge).cloned().flatten().ok_or(NO_EDGE)?;
                if !forward {
                    chain.reverse();
                }
                Ok(chain)
            })
            .collect::<Result<_, &'static str>>()?;
        found.extend(joined(kept)?);
    }
    Ok(found)
}

/// Chains joined end to start until they close.
fn joined(mut chains: Vec<Vec<Node>>) -> Result<Vec<Vec<Node>>, &'static str> {
    let mut found = Vec::new();
    while !chains.is_empty() {
        let mut around = chains.remove(0);
        while around[0].1 != around[around.len() - 1].1 {
            let end = around[around.len() - 1].1;
            let Some(next) = chains.iter().position(|c| c[0].1 == end) else {
                return Err("its boundary does not close");
            };
            around.extend(chains.remove(next).into_iter().skip(1));
        }
        around.pop();
        if around.len() > 1 {
            found.push(around);
        }
    }
    Ok(found)
}

fn assemble(
    placed: &Placed,
    bounded: &[Bounded],
    surfaces: &[Option<Surface>],
    points: Vec<DVec3>,
    meshes: Vec<Result<FaceMesh, &'static str>>,
) -> Solid {
    let mut solid = Solid {
        name: placed.name.clone(),
        color: placed.color,
        mesh: Mesh { vertices: points, triangles: Vec::new() },
        faces: Vec::new(),
        face_of: Vec::new(),
        faults: Vec::new(),
    };
    for (n, ((b, surface), mesh)) in (0u32..).zip(bounded.iter().zip(surfaces).zip(meshes)) {
        let color = b.face.color().map(|c| [c.red as f32, c.green as f32, c.blue as f32]);
        let kind = surface.as_ref().map_or(FaceKind::FreeForm, |s| kind(s, b.is_forward));
        let guides = mesh.as_ref().map_or_else(|_| Vec::new(), |mesh| mesh.guides.clone());
        solid.faces.push(KnownFace { kind, name: b.face.name().trim().to_owned(), color, guides });
        let place = beside(&b.face);
        match mesh {
            Ok(mesh) => {
                let first = solid.mesh.vertices.len() as u32;
                solid.mesh.vertices.extend(&mesh.own);
                let number = |v: u32| if v >= OWN { v - OWN + first } else { v };
                solid.mesh.triangles.extend(mesh.triangles.iter().map(|t| t.map(number)));
                solid.face_of.extend(mesh.triangles.iter().map(|_| n));
                if !mesh.is_fine {
                    let problem = "its triangles leave the surface by more than the tolerance";
                    solid.faults.push(Fault { face: Some(n), place, problem });
                }
            }
            Err(problem) => solid.faults.push(Fault { face: Some(n), place, problem }),
        }
    }
    drop_unused(&mut solid.mesh);
    solid
}

/// Drops vertices of no triangle: points of edges that were made anew.
fn drop_unused(mesh: &mut Mesh) {
    let mut number = vec![u32::MAX; mesh.vertices.len()];
    let mut kept = Vec::new();
    for v in mesh.triangles.iter_mut().flatten() {
        let n = &mut number[*v as usize];
        if *n == u32::MAX {
            *n = kept.len() as u32;
            kept.push(mesh.vertices[*v as usize]);
        }
        *v = *n;
    }
    mesh.vertices = kept;
}

/// A vertex of a face.
fn beside(face: &Face) -> DVec3 {
    let edge = face.bounds().find_map(|b| b.edges().next());
    edge.and_then(|e| e.start()).and_then(|v| v.point()).map_or(DVec3::ZERO, |p| DVec3::from(p.xyz()))
}

/// The surface of a face; none if it is of a kind that is not read.
fn surface(face: &Face, model: &StepModel, angle: f64, tolerance: f64) -> Option<Surface> {
    let axes = |r: &Axis2Placement3dRef| axes(model, r);
    let shape = match face.surface().kind() {
        SurfaceKind::Plane(s) => Shape::Plane(axes(&s.position)?),
        SurfaceKind::Cylindrical(s) => Shape::Cylinder { axes: axes(&s.position)?, radius: s.radius },
        SurfaceKind::Conical(s) => {
            Shape::Cone { axes: axes(&s.position)?, radius: s.radius, slope: (s.semi_angle * angle).tan() }
        }
        SurfaceKind::Spherical(s) => Shape::Sphere { axes: axes(&s.position)?, radius: s.radius },
        SurfaceKind::Toroidal(s) if s.minor_radius < s.major_radius => {
            Shape::Torus { axes: axes(&s.position)?, major: s.major_radius, minor: s.minor_radius }
        }
        SurfaceKind::Offset(_) => {
            return face
                .to_nurbs()
                .map_or_else(|| offset(face.surface(), tolerance), |s| Surface::nurbs(&s, tolerance));
        }
        _ => return Surface::nurbs(&face.to_nurbs()?, tolerance),
    };
    let numbers = match &shape {
        Shape::Cylinder { radius, .. } | Shape::Sphere { radius, .. } => [*radius, 1.0],
        Shape::Cone { radius, slope, .. } => [1.0 + radius, *slope],
        Shape::Torus { major, minor, .. } => [*major, *minor],
        _ => [1.0, 1.0],
    };
    numbers.iter().all(|n| n.is_finite() && *n != 0.0).then(|| Surface::elementary(shape))
}

/// The surface at a distance from a free one, or from one that is so itself.
fn offset(mut surface: step_io::scene::Surface, tolerance: f64) -> Option<Surface> {
    /// Offsets of offsets are followed so far.
    const DEEPEST: usize = 16;
    let mut distance = 0.0f64;
    for _ in 0..DEEPEST {
        let SurfaceKind::Offset(kind) = surface.kind() else {
            let on = Surface::nurbs(&surface.to_nurbs()?, tolerance)?;
            return distance.is_finite().then(|| on.offset_by(distance));
        };
        distance += kind.distance;
        surface = surface.basis_surface()?;
    }
    None
}

fn axes(model: &StepModel, r: &Axis2Placement3dRef) -> Option<Axes> {
    let Axis2Placement3dRef::Axis2Placement3d(id) = r;
    let placement = model.get(*id)?;
    let CartesianPointRef::CartesianPoint(origin) = placement.location else { return None };
    let direction = |d: &Option<DirectionRef>, default: DVec3| match d {
        Some(DirectionRef::Direction(id)) => model.get(*id).map(|d| vector(&d.direction_ratios)),
        Some(_) => None,
        None => Some(default),
    };
    let z = direction(&placement.axis, DVec3::Z)?;
    // Without a direction of reference, any that is square to the axis.
    let x = direction(&placement.ref_direction, if z.x.abs() > 0.9 * z.length() { DVec3::Y } else { DVec3::X })?;
    Axes::new(vector(&model.get(origin)?.coordinates), z, x)
}

fn vector(v: &[f64]) -> DVec3 {
    let at = |k: usize| v.get(k).copied().unwrap_or(0.0);
    DVec3::new(at(0), at(1), at(2))
}

/// Form of a face. `is_forward` tells whether the outside is that of the surface's normal.
fn kind(surface: &Surface, is_forward: bool) -> FaceKind {
    match surface.shape {
        Shape::Plane(a) => {
            let normal = if is_forward { a.z } else { -a.z };
            FaceKind::Plane { normal, offset: normal.dot(a.origin) }
        }
        Shape::Cylinder { axes, radius } => {
            FaceKind::Cylinder { point: axes.origin, direction: axes.z, radius, is_hollow: !is_forward }
        }
        Shape::Cone { axes, radius, slope } => FaceKind::Cone {
            apex: axes.origin - axes.z * (radius / slope),
            axis: axes.z * slope.signum(),
            half_angle: slope.abs().atan(),
            is_hollow: !is_forward,
        },
        Shape::Sphere { axes, radius } => FaceKind::Sphere { centre: axes.origin, radius, is_hollow: !is_forward },
        Shape::Torus { axes, major, minor } => {
            FaceKind::Torus { centre: axes.origin, axis: axes.z, major, minor, is_hollow: !is_forward }
        }
        Shape::Nurbs(_) => FaceKind::FreeForm,
    }
}

/// The solid at one of its places.
fn at_place(solid: &Solid, n: usize, at: DMat4, unit: f64) -> Solid {
    let mut placed = solid.clone();
    if n > 0 {
        placed.name = format!("{} ({})", solid.name, n + 1);
    }
    if at == DMat4::IDENTITY {
        return placed;
    }
    let mut at = at;
    at.w_axis = (at.w_axis.truncate() * unit).extend(1.0);
    for p in &mut placed.mesh.vertices {
        *p = at.transform_point3(*p);
    }
    placed.faults.iter_mut().for_each(|f| f.place = at.transform_point3(f.place));
    placed.faces.iter_mut().for_each(|face| *face = face.placed(&at, 1.0));
    placed
}
