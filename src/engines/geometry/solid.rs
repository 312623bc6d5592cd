//! Closed solids: prisms and their differences and intersections (manifold-rust).

use std::collections::{BTreeSet, HashMap, HashSet};

use glam::{DVec2, DVec3};
use manifold_rust::linalg::Vec3;
use manifold_rust::manifold::Manifold;
use manifold_rust::types::{BooleanEngine, Error, MeshGL64, OpType, WindingRule};

use super::mesh::{Bounds, Mesh, normal_times_two_areas};
use super::weld::Weld;
use task::{Cancel, Cancelled};

mod faced;

pub use faced::{FacedMesh, common_of_faced, union_of_faced};

/// Step to which corners of solids are rounded (mm): exact in binary.
pub(super) const GRID: f64 = 1.0 / (1u64 << 30) as f64;

/// Reason why solids cannot be combined.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum SolidError {
    /// A solid whose surface is not closed.
    #[error("the surface is not closed, or touches itself: {0}; repair the mesh first")]
    NotClosed(String),
    /// The boolean operation itself failed.
    #[error("where two bodies meet no closed surface was found ({0})")]
    Failed(String),
    /// Told to stop.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    /// Outlines that bound no area.
    #[error("an outline crosses itself or has no area, so that it bounds no solid")]
    Outline,
}

/// The part of `a` outside `b`; a mesh without triangles where there is none.
///
/// # Errors
/// [`SolidError::NotClosed`], [`SolidError::Failed`].
pub fn difference(a: &Mesh, b: &Mesh) -> Result<Mesh, SolidError> {
    Ok(mesh(&combine(a, b, OpType::Subtract, BooleanEngine::Exact)?))
}

/// The part of `a` inside `b`; a mesh without triangles where there is none.
///
/// # Errors
/// [`SolidError::NotClosed`], [`SolidError::Failed`].
pub fn intersection(a: &Mesh, b: &Mesh) -> Result<Mesh, SolidError> {
    Ok(mesh(&combine(a, b, OpType::Intersect, BooleanEngine::Exact)?))
}

/// Everything inside `a` or `b`.
///
/// # Errors
/// [`SolidError::NotClosed`], [`SolidError::Failed`].
pub fn union(a: &Mesh, b: &Mesh) -> Result<Mesh, SolidError> {
    match (a.triangles.is_empty(), b.triangles.is_empty()) {
        (true, _) => Ok(b.clone()),
        (_, true) => Ok(a.clone()),
        _ => Ok(mesh(&simplified(combine(a, b, OpType::Add, BooleanEngine::Auto)?, SMALLEST))),
    }
}

/// The solid that a closed surface bounds which may cross or fold over itself: what it winds around at least once.
///
/// # Errors
/// [`SolidError::NotClosed`], [`SolidError::Failed`].
pub fn unfolded(surface: Mesh) -> Result<Mesh, SolidError> {
    if soup(&surface)?.has_self_intersections() { wound(&surface) } else { Ok(surface) }
}

/// The solid that a closed surface bounds which crosses itself, with edges that more than two faces may meet in: what
/// it winds around at least once.
///
/// # Errors
/// [`SolidError::NotClosed`], [`SolidError::Failed`].
pub fn wound(surface: &Mesh) -> Result<Mesh, SolidError> {
    let found = soup(surface)?.rebuild_solid(WindingRule::Positive);
    match found.status() {
        Error::NoError => Ok(mesh(&found)),
        error => Err(SolidError::Failed(error.to_str().to_owned())),
    }
}

fn combine(a: &Mesh, b: &Mesh, operation: OpType, engine: BooleanEngine) -> Result<Manifold, SolidError> {
    if a.triangles.is_empty() {
        return Ok(Manifold::empty());
    }
    combined(&manifold(a)?, &manifold(b)?, operation, engine)
}

/// Shells that overlap stay as they are with the exact engine, which takes no heaps of triangles.
fn combined(a: &Manifold, b: &Manifold, operation: OpType, engine: BooleanEngine) -> Result<Manifold, SolidError> {
    let found = a.boolean_with_engine(b, operation, engine);
    match found.status() {
        Error::NoError => Ok(found),
        Error::NotManifold if engine == BooleanEngine::Exact => combined(a, b, operation, BooleanEngine::Auto),
        error => Err(SolidError::Failed(error.to_str().to_owned())),
    }
}

/// A solid that others are trimmed by, again and again: what is known of it is found once. It may touch itself.
pub struct Trimmer(Manifold);

impl Trimmer {
    /// A trimmer from its surface.
    ///
    /// # Errors
    /// [`SolidError::NotClosed`].
    pub fn new(surface: &Mesh) -> Result<Self, SolidError> {
        Ok(Self(manifold(surface)?))
    }

    /// The part of it in a box: bodies well inside of the box are trimmed by it as by all of it, in less time.
    ///
    /// # Errors
    /// [`SolidError::Failed`].
    pub fn within(&self, bounds: &Bounds) -> Result<Self, SolidError> {
        let within = manifold(&Mesh::cuboid(bounds.size()).mapped(|p| p + bounds.min))?;
        Ok(Self(combined(&within, &self.0, OpType::Intersect, BooleanEngine::Auto)?))
    }

    /// The part of `a` outside of it, without the slivers that faces leave which lie in one another but for rounding.
    ///
    /// # Errors
    /// [`SolidError::NotClosed`], [`SolidError::Failed`].
    pub fn trim(&self, a: &Mesh) -> Result<Mesh, SolidError> {
        if a.triangles.is_empty() {
            return Ok(Mesh::default());
        }
        let found = combined(&manifold(a)?, &self.0, OpType::Subtract, BooleanEngine::Auto)?;
        Ok(without_slivers(mesh(&simplified(found, SLIVER))))
    }
}

/// Longest edge of a sliver (mm): more than single precision cannot tell apart 50 mm from the origin.
const SLIVER: f64 = 1e-5;

/// A closed surface whose edges as short as slivers have become points, so that it stays closed in files which cannot
/// tell their ends apart. So have short edges along which the surface touches itself. What would touch itself then is left
/// as it is.
pub fn without_slivers(mut mesh: Mesh) -> Mesh {
    /// Each takes away one edge of every place.
    const PASSES: usize = 16;
    /// Length up to which an edge becomes a point along which the surface touches itself (mm), and how near two edges are
    /// that do (mm).
    const TOUCHING: f64 = 5e-4;
    const SAME: f64 = 1e-6;
    let near = |p: DVec3| (p / SAME).round().to_array().map(|v| v as i64);
    let side = |mesh: &Mesh, a: u32, b: u32| mesh.vertices[a as usize].distance(mesh.vertices[b as usize]);
    for _ in 0..PASSES {
        let sides = mesh.triangles.iter().flat_map(|[a, b, c]| [[*a, *b], [*b, *c], [*c, *a]]);
        let sides: Vec<(f64, [u32; 2])> = sides
            .filter(|[a, b]| a < b)
            .map(|[a, b]| (side(&mesh, a, b), [a, b]))
            .filter(|(length, _)| *length < TOUCHING)
            .collect();
        let place = |ends: [u32; 2]| {
            let [p, q] = ends.map(|v| near(mesh.vertices[v as usize]));
            [p.min(q), p.max(q)]
        };
        let mut count: HashMap<[[i64; 3]; 2], usize> = HashMap::new();
        sides.iter().for_each(|(_, ends)| *count.entry(place(*ends)).or_default() += 1);
        let is_short = |(length, ends): &(f64, [u32; 2])| *length < SLIVER || count[&place(*ends)] > 1;
        let mut short: Vec<(f64, [u32; 2])> = sides.into_iter().filter(is_short).collect();
        if short.is_empty() {
            break;
        }
        short.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let mut around: HashMap<u32, BTreeSet<u32>> =
            short.iter().flat_map(|(_, ends)| *ends).map(|v| (v, BTreeSet::new())).collect();
        for triangle in &mesh.triangles {
            for v in triangle {
                if let Some(around) = around.get_mut(v) {
                    around.extend(triangle.iter().filter(|w| *w != v));
                }
            }
        }
        let mut is_touched = vec![false; mesh.vertices.len()];
        let mut kept: Vec<u32> = (0..mesh.vertices.len() as u32).collect();
        let mut count = 0;
        for (_, [a, b]) in short {
            let beside = [&around[&a], &around[&b]];
            // An edge can become a point where its ends have none but the corners opposite to it in common.
            let is_free = beside[0].intersection(beside[1]).count() == 2 && beside[0].len() + beside[1].len() > 6;
            if is_free && !beside.into_iter().flatten().any(|v| is_touched[*v as usize]) {
                beside.into_iter().flatten().for_each(|v| is_touched[*v as usize] = true);
                kept[b as usize] = a;
                count += 1;
            }
        }
        if count == 0 {
            break;
        }
        let triangles = mesh.triangles.iter().map(|t| t.map(|v| kept[v as usize]));
        mesh.triangles = triangles.filter(|[a, b, c]| a != b && b != c && c != a).collect();
    }
    mesh.compacted()
}

/// Edges that are shorter, and corners that are nearer to the line of their neighbours (mm), are left out of what was
/// combined.
const SMALLEST: f64 = 1e-9;

/// Union of the convex hulls of these sets of points.
///
/// # Errors
/// [`SolidError::Failed`], and [`SolidError::Cancelled`] when cancelled.
pub fn union_of_hulls(sets: &[Vec<DVec3>], cancel: &Cancel) -> Result<Mesh, SolidError> {
    let middle = |points: &[DVec3]| points.iter().sum::<DVec3>() / points.len().max(1) as f64;
    let mut placed: Vec<(DVec3, &[DVec3])> = sets.iter().map(|set| (middle(set), &set[..])).collect();
    let all = united(&mut placed, cancel)?;
    Ok(mesh(&simplified(all, SMALLEST)))
}

/// The union of hulls, each with its middle: halves of them that lie apart first.
fn united(hulls: &mut [(DVec3, &[DVec3])], cancel: &Cancel) -> Result<Manifold, SolidError> {
    cancel.check()?;
    if let [(_, points)] = hulls {
        return Ok(hull_of(points));
    }
    if hulls.is_empty() {
        return Ok(Manifold::empty());
    }
    let bounds = Bounds::of(hulls.iter().map(|(middle, _)| *middle));
    let size = bounds.size();
    let axis = if size.x >= size.y.max(size.z) { 0 } else { usize::from(size.z > size.y) + 1 };
    let half = hulls.len() / 2;
    hulls.sort_by(|(a, _), (b, _)| a[axis].total_cmp(&b[axis]));
    let (low, high) = hulls.split_at_mut(half);
    let found = united(low, cancel)?.boolean_with_engine(&united(high, cancel)?, OpType::Add, BooleanEngine::Auto);
    match found.status() {
        Error::NoError => Ok(found),
        error => Err(SolidError::Failed(error.to_str().to_owned())),
    }
}

/// The convex hull of points; a mesh without triangles where they lie in a plane.
pub fn hull(points: &[DVec3]) -> Mesh {
    mesh(&hull_of(points))
}

fn hull_of(points: &[DVec3]) -> Manifold {
    let points: Vec<Vec3> = points.iter().map(|p| Vec3::new(p.x, p.y, p.z)).collect();
    Manifold::hull(&points)
}

/// A surface as it is. Read as a solid it would be tidied first, and where faces lie folded on one another that moves
/// it: each triangle gets corners of its own, so that it is read as a heap of triangles. Those without any area would
/// be left out of the heap, which would then not be closed: they are taken in by their neighbours.
fn soup(surface: &Mesh) -> Result<Manifold, SolidError> {
    let mut weld = Weld::default();
    let triangles = surface.iter_corners().map(|c| c.map(|p| weld.add(p))).collect();
    let points = weld.points();
    let corners = without_collinear(points, triangles).into_iter().flatten().map(|v| points[v as usize]);
    let corners: Vec<DVec3> = corners.collect();
    let numbers = 0..corners.len() as u32;
    let triangles = numbers.step_by(3).map(|i| [i, i + 1, i + 2]).collect();
    let soup = Manifold::from_mesh_gl64_robust(&given(&Mesh { vertices: corners, triangles }));
    match soup.status() {
        Error::NoError => Ok(soup),
        error => Err(SolidError::NotClosed(error.to_str().to_owned())),
    }
}

/// The triangles of a surface less those whose corners lie on a line: each of these and its neighbour across its
/// longest side are two triangles that meet in its third corner instead, so that the surface is the same.
fn without_collinear(points: &[DVec3], mut triangles: Vec<[u32; 3]>) -> Vec<[u32; 3]> {
    /// Height of a triangle up to which its corners lie on a line (mm): what rounding makes of none.
    const HAIR: f64 = 1e-12;
    /// Rounds at most: a neighbour may become such a triangle in its turn.
    const ROUNDS: usize = 32;
    for _ in 0..ROUNDS {
        triangles.retain(|[a, b, c]| a != b && b != c && c != a);
        // The third corner last.
        let longest_first = |[a, b, c]: [u32; 3]| {
            let length = |u: u32, v: u32| points[u as usize].distance_squared(points[v as usize]);
            let all = [[a, b, c], [b, c, a], [c, a, b]];
            all.into_iter()
                .reduce(|x, y| if length(y[0], y[1]) > length(x[0], x[1]) { y } else { x })
                .unwrap_or([a, b, c])
        };
        let is_flat = |triangle: [u32; 3]| {
            let [u, v, m] = triangle.map(|v| points[v as usize]);
            let (along, off) = (v - u, m - u);
            along.cross(off).length() <= HAIR * along.length()
        };
        let flat: Vec<usize> = (0..triangles.len()).filter(|t| is_flat(longest_first(triangles[*t]))).collect();
        if flat.is_empty() {
            break;
        }
        let mut sides = HashMap::new();
        for (t, [a, b, c]) in triangles.iter().enumerate() {
            [(*a, *b, *c), (*b, *c, *a), (*c, *a, *b)].into_iter().for_each(|(u, v, w)| {
                sides.insert((u, v), (t, w));
            });
        }
        let mut is_changed = vec![false; triangles.len()];
        for t in flat {
            let [u, v, m] = longest_first(triangles[t]);
            let Some(&(neighbour, w)) = sides.get(&(v, u)) else { continue };
            if neighbour == t || is_changed[t] || is_changed[neighbour] {
                continue;
            }
            (is_changed[t], is_changed[neighbour]) = (true, true);
            // One that is its own reverse takes both away.
            (triangles[t], triangles[neighbour]) = if w == m { ([u; 3], [u; 3]) } else { ([v, m, w], [m, u, w]) };
        }
    }
    triangles
}

fn given(mesh: &Mesh) -> MeshGL64 {
    MeshGL64 {
        num_prop: 3,
        vert_properties: mesh.vertices.iter().flat_map(|p| p.to_array()).collect(),
        tri_verts: mesh.triangles.iter().flatten().map(|i| u64::from(*i)).collect(),
        ..MeshGL64::default()
    }
}

/// A mesh as a solid. What is read is tidied, and where edges lie nearer to one another than rounding, tidying may take a
/// corner of their neighbours away: corners are rounded first, which keeps such edges in one line. Where a corner is lost
/// all the same, triangles whose corners lie on a line are taken in by their neighbours, and where that does not help the
/// mesh is read as it is; operations on it take longer.
fn manifold(mesh: &Mesh) -> Result<Manifold, SolidError> {
    let vertices = mesh.vertices.iter().map(|p| on_grid(*p)).collect();
    let rounded = Mesh { vertices, triangles: mesh.triangles.clone() };
    let solid = Manifold::from_mesh_gl64(&given(&rounded));
    if solid.status() != Error::NoError {
        return Err(SolidError::NotClosed(solid.status().to_str().to_owned()));
    }
    if is_same(&solid, &rounded) {
        return Ok(solid);
    }
    let triangles = without_collinear(&rounded.vertices, rounded.triangles.clone());
    let rounded = Mesh { triangles, ..rounded };
    let solid = Manifold::from_mesh_gl64(&given(&rounded));
    if solid.status() == Error::NoError && is_same(&solid, &rounded) { Ok(solid) } else { soup(&rounded) }
}

/// Whether a solid that was read has the volume of its mesh beside every corner that was tidied away.
fn is_same(solid: &Manifold, mesh: &Mesh) -> bool {
    /// Thickness by which tidying may change a solid beside a corner that it takes away (mm).
    const TIDIED: f64 = 1e-6;
    let key = |p: &[f64]| [p[0].to_bits(), p[1].to_bits(), p[2].to_bits()];
    let read = solid.get_mesh_gl64(-1).vert_properties;
    let kept: HashSet<[u64; 3]> = read.chunks_exact(3).map(key).collect();
    let is_lost = |v: &u32| !kept.contains(&key(&mesh.vertices[*v as usize].to_array()));
    let area = |t: &[u32; 3]| normal_times_two_areas(t.map(|v| mesh.vertices[v as usize])).length() / 2.0;
    let beside: f64 = mesh.triangles.iter().filter(|t| t.iter().any(is_lost)).map(area).sum();
    beside == 0.0 || (solid.volume() - mesh.volume().abs()).abs() <= TIDIED * beside
}

/// A solid with what is smaller than `length` (mm) tidied away, as far as that can be done.
fn simplified(solid: Manifold, length: f64) -> Manifold {
    let found = solid.simplify(length);
    if found.status() == Error::NoError { found } else { solid }
}

/// The nearest place on the grid of corners.
pub(super) fn on_grid(p: DVec3) -> DVec3 {
    (p / GRID).round() * GRID
}

/// Vertices on the seam of the two solids come once for each and are one again here.
fn mesh(found: &Manifold) -> Mesh {
    let given = found.get_mesh_gl64(-1);
    let all: Vec<DVec3> = given.vert_properties.chunks_exact(3).map(DVec3::from_slice).collect();
    let mut same: Vec<usize> = (0..all.len()).collect();
    for (from, to) in given.merge_from_vert.iter().zip(&given.merge_to_vert) {
        same[*from as usize] = *to as usize;
    }
    let kept: Vec<bool> = same.iter().enumerate().map(|(i, to)| i == *to).collect();
    let number: Vec<u32> = kept
        .iter()
        .scan(0, |count, is_kept| {
            let own = *count;
            *count += u32::from(*is_kept);
            Some(own)
        })
        .collect();
    let vertices = all.iter().zip(&kept).filter(|(_, is_kept)| **is_kept).map(|(p, _)| *p).collect();
    let corner = |i: u64| number[same[i as usize]];
    let triangles = given.tri_verts.chunks_exact(3).map(|t| [corner(t[0]), corner(t[1]), corner(t[2])]).collect();
    Mesh { vertices, triangles }
}

/// Triangles between the rings of a connected set of the plane, its outer boundary counter-clockwise and first, its
/// holes clockwise: numbers of their points, all rings counted on, turning counter-clockwise. Every point of a ring is
/// a corner.
///
/// # Errors
/// [`SolidError::Outline`] where rings cross so that the triangles do not fill what they bound.
pub fn filled(rings: &[&[DVec2]]) -> Result<Vec<[u32; 3]>, SolidError> {
    /// Turns in which rings are filled until one does (radians). Where corners of one ring lie in line with a side of
    /// another, some are lost, as the ways between rings run along that line; turned, the ways are others.
    const TURNS: [f64; 4] = [0.0, 0.7, 2.1, 4.3];
    TURNS.into_iter().find_map(|turn| filled_turned(rings, DVec2::from_angle(turn))).ok_or(SolidError::Outline)
}

/// Triangles between rings turned by an angle, given as a unit vector; none where they do not fill what the rings bound.
fn filled_turned(rings: &[&[DVec2]], turn: DVec2) -> Option<Vec<[u32; 3]>> {
    /// Share of the area by which the triangles may miss it: rounding.
    const SAME_AREA: f64 = 1e-6;
    let points = rings.iter().flat_map(|ring| ring.iter()).map(|p| turn.rotate(*p).to_array());
    let starts = rings.iter().scan(0u32, |count, ring| {
        *count += ring.len() as u32;
        Some(*count)
    });
    let holes: Vec<u32> = starts.take(rings.len().saturating_sub(1)).collect();
    let mut corners: Vec<u32> = Vec::new();
    earcut::Earcut::new().earcut(points, &holes, &mut corners);
    let all: Vec<DVec2> = rings.concat();
    let twice = |[a, b, c]: [u32; 3]| {
        let [a, b, c] = [a, b, c].map(|v| all[v as usize]);
        (b - a).perp_dot(c - a)
    };
    let of = |t: &[u32]| {
        let [a, b, c] = [t[0], t[1], t[2]];
        if twice([a, b, c]) < 0.0 { [a, c, b] } else { [a, b, c] }
    };
    let triangles: Vec<[u32; 3]> = corners.chunks_exact(3).map(of).collect();
    // A closed fill has as many triangles as its corners and holes demand (Euler), and no two of them overlap.
    let expected = (all.len() + 2 * rings.len()).checked_sub(4);
    let ring_area =
        |ring: &&[DVec2]| (0..ring.len()).map(|i| ring[i].perp_dot(ring[(i + 1) % ring.len()])).sum::<f64>();
    let mut areas = rings.iter().map(|ring| ring_area(ring).abs());
    let area = areas.next()? - areas.sum::<f64>();
    let filled: f64 = triangles.iter().map(|t| twice(*t)).sum();
    let is_filled = expected == Some(triangles.len()) && (filled - area).abs() <= SAME_AREA * area;
    (is_filled && !triangles.is_empty()).then_some(triangles)
}

/// The prism over rings (as of [`filled`]) from the height `low` to the height `high` (mm).
///
/// # Errors
/// [`SolidError::Outline`].
pub fn prism(rings: &[&[DVec2]], low: f64, high: f64) -> Result<Mesh, SolidError> {
    let caps = filled(rings)?;
    let count = rings.iter().map(|ring| ring.len() as u32).sum::<u32>();
    let at = |z: f64| rings.iter().flat_map(move |ring| ring.iter().map(move |p| p.extend(z)));
    let vertices = at(low).chain(at(high)).collect();
    let mut triangles: Vec<[u32; 3]> = caps.iter().map(|[a, b, c]| [*a, *c, *b]).collect();
    triangles.extend(caps.iter().map(|t| t.map(|i| i + count)));
    let mut first = 0;
    for ring in rings {
        let n = ring.len() as u32;
        for i in 0..n {
            let (a, b) = (first + i, first + (i + 1) % n);
            triangles.extend([[a, b, b + count], [a, b + count, a + count]]);
        }
        first += n;
    }
    Ok(Mesh { vertices, triangles })
}

/// Whether a mesh is closed as files know it: with vertices within `within` (mm) taken for one, each side of a triangle
/// has exactly one neighbour, which runs the other way.
pub fn is_closed(mesh: &Mesh, within: f64) -> bool {
    welded(mesh, within).is_watertight()
}

/// How many sides of triangles have not exactly one neighbour, which runs the other way: see [`is_closed`].
pub fn open_edges(mesh: &Mesh, within: f64) -> usize {
    let sides = welded(mesh, within).directed_edges();
    sides.iter().filter(|((a, b), count)| **count != 1 || sides.get(&(*b, *a)) != Some(&1)).count()
}

/// The ends of the edges along which a closed surface touches itself, vertices within `within` (mm) taken for one.
pub fn touching_edges(mesh: &Mesh, within: f64) -> Vec<[DVec3; 2]> {
    let welded = welded(mesh, within);
    let sides = welded.directed_edges();
    let mut several: Vec<(u32, u32)> =
        sides.into_iter().filter(|((a, b), count)| a < b && *count > 1).map(|(ends, _)| ends).collect();
    several.sort_unstable();
    several.into_iter().map(|(a, b)| [a, b].map(|v| welded.vertices[v as usize])).collect()
}

/// The triangles of a mesh whose vertices within `within` (mm) are one, without those that are none then.
fn welded(mesh: &Mesh, within: f64) -> Mesh {
    let (mut known, mut vertices) = (HashMap::new(), Vec::new());
    let mut place = |p: &DVec3| {
        *known.entry((*p / within).round().to_array().map(|v| v as i64)).or_insert_with(|| {
            vertices.push(*p);
            vertices.len() as u32 - 1
        })
    };
    let places: Vec<u32> = mesh.vertices.iter().map(&mut place).collect();
    let welded = mesh.triangles.iter().map(|t| t.map(|v| places[v as usize]));
    let triangles = welded.filter(|[a, b, c]| a != b && b != c && c != a).collect();
    Mesh { vertices, triangles }
}

#[cfg(test)]
mod tests;
