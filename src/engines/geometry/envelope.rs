//! What a body that sinks straight down must stay above: a surface grown by a gap, and everything straight below that.
//!
//! The set of places nearer to a surface than the gap is the union of its triangles, each grown by a ball. A body that
//! moves along Z stays clear of it if it stays above its upper envelope, so each grown triangle is taken as the convex
//! column from it down to a floor. The union of these columns exists for every mesh: knife edges, points, open or
//! crossing surfaces included, and overhangs shade what lies below them.
//!
//! **Accuracy, always on the safe side:** faces are moved by the gap exactly. Where faces meet, their planes are
//! carried on until they meet, as long as that is no more than [`LONGEST`] gaps away; beyond, a polyhedron around the
//! ball takes its place, which reaches no more than 20 % of the gap beyond it.

use std::collections::{HashMap, HashSet};
use std::f64::consts::TAU;
use std::sync::LazyLock;

use glam::{DMat3, DVec2, DVec3};
use rayon::prelude::*;

use super::exact::ExactMesh;
use super::inside::is_inside;
use super::mesh::{Bounds, Mesh, normal_times_two_areas, unit_normal};
use super::offset::{least_shift, vertex_normals};
use super::solid::{self, GRID, SolidError, hull, on_grid};
use task::Cancel;

/// Gaps within which the planes of faces that meet are carried on.
const LONGEST: f64 = 1.8;
/// Gaps up to which an edge is short: moved apart, its ends may change places.
const SHORT: f64 = 0.25;
/// Radii within which the planes of walls that a disc is swept along are carried on.
const FURTHEST: f64 = 3.0;
/// Directions in which a ball is bounded that lie nearer to a face's normal than this are left out (rad).
const APART: f64 = 0.25;
/// Part of a unit normal downwards from which on others lie over a face.
const LEVEL: f64 = 1e-3;
/// Enlargement of the columns around sharp corners (mm): a multiple of this, up to as many as below.
const HAIR: f64 = 1e-6;
const HAIRS: usize = 61;
/// Corners of the polygon around a disc that sweeps.
const DISC: usize = 24;

/// Growth of a surface: the gap, and the disc that a body sweeps beside.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Growth {
    /// Distance (mm).
    pub gap: f64,
    /// Radius of the disc across Z that a body sweeps beside (mm).
    pub radius: f64,
}

/// The solid from below the height `floor` (mm) up to the upper envelope of a surface with its growth, over the rectangle
/// `over` in plan (its corners, mm). Beside it the solid may be incomplete.
///
/// # Errors
/// [`SolidError::Cancelled`], [`SolidError::Failed`].
pub fn envelope(
    mesh: &Mesh,
    growth: &Growth,
    [low, high]: [DVec2; 2],
    floor: f64,
    cancel: &Cancel,
) -> Result<Mesh, SolidError> {
    let corners = corners(mesh, growth);
    let reach = LONGEST * growth.gap + FURTHEST * growth.radius;
    let is_near = |t: &usize| {
        let Bounds { min, max } = Bounds::of(mesh.corners(*t));
        max.z + reach > floor && (max.truncate() + reach).cmpge(low).all() && (min.truncate() - reach).cmple(high).all()
    };
    let near: Vec<usize> = (0..mesh.triangles.len()).filter(is_near).collect();
    // All columns stand on one floor, below faces that reach further down too.
    let lowest = near.iter().flat_map(|t| mesh.corners(*t)).map(|p| p.z).fold(floor, f64::min);
    let floor = ((lowest - reach) / GRID).floor() * GRID;
    // Beside a triangle with a corner that is moved to several places the moved surface ends. A fold of it there may be
    // covered by nothing else, so that such triangles get columns of their own too.
    let mut is_beside = vec![false; mesh.vertices.len()];
    for triangle in &mesh.triangles {
        let has_one = triangle.iter().any(|v| matches!(corners[*v as usize], Corner::Around(_)));
        triangle.iter().for_each(|v| is_beside[*v as usize] |= has_one);
    }
    let needs_own = |t: &usize| {
        let triangle = mesh.triangles[*t];
        let is_apart = triangle.iter().any(|v| matches!(corners[*v as usize], Corner::Around(_)));
        let is_beside = triangle.iter().any(|v| is_beside[*v as usize]);
        let looks_down = || unit_normal(mesh.corners(*t)).z < -LEVEL;
        is_apart || (is_beside && !looks_up(&corners, triangle) && !looks_down())
    };
    let own = near.iter().filter(|t| needs_own(t));
    let moved_to = |t: usize| mesh.triangles[t].map(|v| &corners[v as usize]);
    let hulls: Vec<Vec<DVec3>> = own.map(|t| column(mesh, moved_to(*t), *t, floor)).collect();
    let moved: Vec<[u32; 3]> =
        near.iter().copied().map(|t| mesh.triangles[t]).filter(|t| looks_up(&corners, *t)).collect();
    cancel.check()?;
    let columns = solid::unfolded(below(&corners, &moved, floor))?;
    let found = solid::union(&columns, &solid::union_of_hulls(&hulls, cancel)?)?;
    cancel.check()?;
    let open = uncovered(mesh, &corners, &near, growth, floor, &found);
    if open.is_empty() {
        return Ok(found);
    }
    let normals = vertex_normals(mesh);
    let grown = |v: u32| Corner::around(mesh.vertices[v as usize], &normals[v as usize], growth);
    let hulls: Vec<Vec<DVec3>> =
        open.iter().map(|t| column(mesh, mesh.triangles[*t].map(grown).each_ref(), *t, floor)).collect();
    solid::union(&found, &solid::union_of_hulls(&hulls, cancel)?)
}

/// Triangles of `near` that share a corner with a folded one and have a place within the gap of them outside of `solid`:
/// looked for over some places of each, in all directions.
fn uncovered(mesh: &Mesh, corners: &[Corner], near: &[usize], growth: &Growth, floor: f64, solid: &Mesh) -> Vec<usize> {
    /// Part of the growth that may be missing: rounding of corners.
    const MISSING: f64 = 1e-3;
    /// Parts into which sides are divided by the places.
    const SHARES: u32 = 3;
    let mut is_at_fold = vec![false; mesh.vertices.len()];
    for triangle in near.iter().map(|t| mesh.triangles[*t]).filter(|t| is_folded(mesh, corners, *t)) {
        triangle.into_iter().for_each(|v| is_at_fold[v as usize] = true);
    }
    let asked: Vec<usize> =
        near.iter().copied().filter(|t| mesh.triangles[*t].iter().any(|v| is_at_fold[*v as usize])).collect();
    // A solid without faces covers nothing.
    let Some(solid) = (!asked.is_empty()).then(|| ExactMesh::new(solid).ok()).flatten() else { return asked };
    let is_open = |t: &usize| {
        let [a, b, c] = mesh.corners(*t);
        let normal = unit_normal([a, b, c]);
        let directions = DIRECTIONS.iter().copied().filter(|d| d.dot(normal) > 0.0).chain([normal]);
        let over = |d: DVec3| (d * growth.gap + d.with_z(0.0).normalize_or_zero() * growth.radius) * (1.0 - MISSING);
        let over: Vec<DVec3> = directions.map(over).collect();
        let shares =
            (0..=SHARES).flat_map(|i| (0..=SHARES - i).map(move |j| [i, j].map(|k| f64::from(k) / f64::from(SHARES))));
        let places = shares.map(|[i, j]| a + (b - a) * i + (c - a) * j);
        places.flat_map(|p| over.iter().map(move |d| p + *d)).any(|p| p.z > floor && !is_inside(&solid, p))
    };
    asked.into_par_iter().filter(is_open).collect()
}

/// Whether a triangle whose corners are all moved to one place looks up then: decided exactly.
fn looks_up(corners: &[Corner], triangle: [u32; 3]) -> bool {
    let [Corner::Meeting(a), Corner::Meeting(b), Corner::Meeting(c)] = triangle.map(|v| &corners[v as usize]) else {
        return false;
    };
    let [a, b, c] = [a, b, c].map(|p| (*p / GRID).to_array().map(|v| v as i128));
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]) > 0
}

/// The columns under moved triangles, without the walls that two of them share.
fn below(corners: &[Corner], triangles: &[[u32; 3]], floor: f64) -> Mesh {
    let sides: HashSet<(u32, u32)> = triangles.iter().flat_map(|[a, b, c]| [(*a, *b), (*b, *c), (*c, *a)]).collect();
    let mut mesh = Mesh::default();
    let mut numbers: HashMap<u32, u32> = HashMap::new();
    // The corner itself, and after it the one at the floor.
    let mut number = |v: u32, mesh: &mut Mesh| {
        *numbers.entry(v).or_insert_with(|| {
            let top = corners[v as usize].points()[0];
            mesh.vertices.extend([top, top.with_z(floor)]);
            mesh.vertices.len() as u32 - 2
        })
    };
    for triangle in triangles {
        let [a, b, c] = triangle.map(|v| number(v, &mut mesh));
        mesh.triangles.extend([[a, b, c], [a + 1, c + 1, b + 1]]);
        let [i, j, k] = *triangle;
        for ((from, to), side) in [((a, b), (i, j)), ((b, c), (j, k)), ((c, a), (k, i))] {
            if !sides.contains(&(side.1, side.0)) {
                mesh.triangles.extend([[from, from + 1, to + 1], [from, to + 1, to]]);
            }
        }
    }
    mesh
}

/// Where a corner of the surface is moved.
enum Corner {
    /// Where the moved planes of the faces around it meet, or as near as no face allows more.
    Meeting(DVec3),
    /// To the corners of a body around it.
    Around(Vec<DVec3>),
}

impl Corner {
    /// The corner at `p` of faces with these normals, moved to those of a body around it.
    fn around(p: DVec3, normals: &[DVec3], growth: &Growth) -> Self {
        Self::Around(around(normals, growth).into_iter().map(|d| on_grid(p + d)).collect())
    }

    fn points(&self) -> &[DVec3] {
        match self {
            Self::Meeting(point) => std::slice::from_ref(point),
            Self::Around(points) => points,
        }
    }
}

fn corners(mesh: &Mesh, growth: &Growth) -> Vec<Corner> {
    let whole = whole(mesh);
    let normals = vertex_normals(mesh);
    let close = close(mesh, SHORT * growth.gap);
    let of = |(v, p): (usize, &DVec3)| {
        let own = &normals[v];
        // A sliver folds when it is moved: its corners have to clear the faces at its other end too.
        let beside = close.get(&(v as u32)).into_iter().flatten().map(|w| *w as usize);
        let beside = beside.flat_map(|w| normals[w].iter().map(move |n| (*n, n.dot(mesh.vertices[w] - *p))));
        let planes: Vec<(DVec3, f64)> =
            own.iter().map(|n| (*n, 0.0)).chain(beside).map(|(n, off)| (n, growth.gap + off)).collect();
        let all: Vec<DVec3> = planes.iter().map(|(n, _)| *n).collect();
        let even = least_shift(&planes);
        let even = even.filter(|shift| whole[v] && !own.is_empty() && shift.length() <= LONGEST * growth.gap);
        match even.zip(across(&all, growth)) {
            Some((even, across)) => Corner::Meeting(on_grid(*p + even + across)),
            None => Corner::around(*p, own, growth),
        }
    };
    mesh.vertices.par_iter().enumerate().map(of).collect()
}

/// Whether a triangle, whose corners are all moved to one place, looks the other way then.
fn is_folded(mesh: &Mesh, corners: &[Corner], triangle: [u32; 3]) -> bool {
    let [Corner::Meeting(a), Corner::Meeting(b), Corner::Meeting(c)] = triangle.map(|v| &corners[v as usize]) else {
        return false;
    };
    let before = normal_times_two_areas(triangle.map(|v| mesh.vertices[v as usize]));
    before.dot(normal_times_two_areas([*a, *b, *c])) < 0.0
}

/// For vertices with edges shorter than `length` (mm) where those lead.
fn close(mesh: &Mesh, length: f64) -> HashMap<u32, Vec<u32>> {
    let mut close: HashMap<u32, Vec<u32>> = HashMap::new();
    for [a, b, c] in &mesh.triangles {
        for (from, to) in [(*a, *b), (*b, *c), (*c, *a)] {
            if mesh.vertices[from as usize].distance_squared(mesh.vertices[to as usize]) < length * length {
                close.entry(from).or_default().push(to);
                close.entry(to).or_default().push(from);
            }
        }
    }
    close.values_mut().for_each(|ends| {
        ends.sort_unstable();
        ends.dedup();
    });
    close
}

/// The shortest shift across Z by which faces with these normals are moved as far as by the disc; none where it would go
/// much further than that.
fn across(normals: &[DVec3], growth: &Growth) -> Option<DVec3> {
    /// Part of a normal across Z up to which a face is level: rounding of files.
    const ROUNDING: f64 = 1e-4;
    if growth.radius == 0.0 {
        return Some(DVec3::ZERO);
    }
    let across = normals.iter().map(|n| n.with_z(0.0)).filter(|n| n.length() > ROUNDING);
    let planes: Vec<(DVec3, f64)> = across.map(|n| (n.normalize(), growth.radius)).collect();
    least_shift(&planes).filter(|shift| shift.length() <= FURTHEST * growth.radius)
}

/// Which vertices the faces close around: each of their edges belongs to two faces that run along it both ways.
fn whole(mesh: &Mesh) -> Vec<bool> {
    let mut sides: HashMap<(u32, u32), u32> = HashMap::with_capacity(3 * mesh.triangles.len());
    for [a, b, c] in &mesh.triangles {
        [(*a, *b), (*b, *c), (*c, *a)].into_iter().for_each(|side| *sides.entry(side).or_default() += 1);
    }
    let mut whole = vec![true; mesh.vertices.len()];
    for ((a, b), count) in &sides {
        if *count != 1 || sides.get(&(*b, *a)) != Some(&1) {
            (whole[*a as usize], whole[*b as usize]) = (false, false);
        }
    }
    whole
}

/// Corners of a body around the ball of the gap, and what it sweeps: bounded by the moved planes of these faces, and
/// otherwise by planes in fixed directions.
fn around(normals: &[DVec3], growth: &Growth) -> Vec<DVec3> {
    /// Corners further away than this, in gaps, are those of planes that are hardly different.
    const SLENDER: f64 = 1.2;
    let apart = APART.cos();
    // What lies below belongs to the column anyway.
    let up: Vec<DVec3> = normals.iter().copied().filter(|n| n.z > -APART).collect();
    let fixed = DIRECTIONS.iter().copied().filter(|d| up.iter().all(|n| n.dot(*d) < apart));
    let directions: Vec<DVec3> = up.iter().copied().chain(fixed).chain([DVec3::NEG_Z]).collect();
    // The corners of what planes bound are the planes of the hull of their normals.
    let dual = hull(&directions);
    let corner = |[a, b, c]: [DVec3; 3]| {
        let rows = DMat3::from_cols(a, b, c).transpose();
        let met = (rows.determinant().abs() > 1e-9).then(|| rows.inverse() * DVec3::splat(growth.gap));
        let outwards = (a + b + c).normalize_or_zero() * growth.gap;
        met.unwrap_or(outwards).clamp_length_max(SLENDER * growth.gap)
    };
    let ball: Vec<DVec3> = dual.iter_corners().map(corner).collect();
    if growth.radius == 0.0 {
        return ball;
    }
    let half_step = 0.5 * TAU / DISC as f64;
    let beside = |i: usize| DVec2::from_angle((2 * i) as f64 * half_step) * (growth.radius / half_step.cos());
    ball.iter().flat_map(|p| (0..DISC).map(move |i| *p + beside(i).extend(0.0))).collect()
}

/// Directions upwards and level, no two neighbours further apart than 31 degrees: those of a divided octahedron.
static DIRECTIONS: LazyLock<Vec<DVec3>> = LazyLock::new(|| {
    const STEPS: i32 = 3;
    let all = (-STEPS..=STEPS).flat_map(|x| (-STEPS..=STEPS).map(move |y| (x, y)));
    let up = all.filter(|(x, y)| x.abs() + y.abs() <= STEPS);
    let of = |(x, y): (i32, i32)| DVec3::new(f64::from(x), f64::from(y), f64::from(STEPS - x.abs() - y.abs()));
    up.map(|direction| of(direction).normalize()).collect()
});

/// Points whose hull is the column under a triangle whose corners are moved to `moved`.
fn column(mesh: &Mesh, moved: [&Corner; 3], triangle: usize, floor: f64) -> Vec<DVec3> {
    let moved = moved.into_iter().flat_map(Corner::points).copied();
    let high: Vec<DVec3> = moved.chain(mesh.corners(triangle)).collect();
    let low = high.iter().map(|p| p.with_z(floor));
    let points: Vec<DVec3> = high.iter().copied().chain(low).collect();
    // Solids whose faces lie in one another cannot be told apart once their corners are rounded: each is larger by a
    // hair of its own.
    let hair = HAIR * (1.0 + (triangle % HAIRS) as f64);
    let middle = points.iter().sum::<DVec3>() / points.len() as f64;
    points.iter().map(|p| *p + (*p - middle).normalize_or_zero() * hair).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::exact::ExactMesh;
    use crate::inside::winding_number;
    use crate::solid::{difference, prism, union};
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    const GAP: f64 = 0.1;

    fn prism_over(ring: &[(f64, f64)], low: f64, high: f64) -> Mesh {
        let ring: Vec<DVec2> = ring.iter().map(|p| DVec2::from(*p)).collect();
        prism(&[&ring], low, high).unwrap()
    }

    fn block() -> Mesh {
        prism_over(&[(-4.0, -4.0), (4.0, -4.0), (4.0, 4.0), (-4.0, 4.0)], -3.0, 0.0)
    }

    /// A prism lying along Y over a profile in X and Z.
    fn bar(profile: &[(f64, f64)]) -> Mesh {
        prism_over(profile, -5.0, 5.0).mapped(|p| DVec3::new(p.x, -p.z, p.y))
    }

    /// A knife edge of 20 degrees that stands on the block.
    fn with_knife() -> Mesh {
        let half = 10f64.to_radians().tan();
        let knife = bar(&[(-half, -0.1), (half, -0.1), (0.0, 1.0)]).mapped(|p| p * DVec3::new(1.0, 0.4, 1.0));
        union(&block(), &knife).unwrap()
    }

    /// A groove with a sharp bottom, slanted walls of 30 degrees, and an undercut beside it.
    fn with_groove() -> Mesh {
        let groove = bar(&[(0.0, -2.0), (1.0, 0.3), (-1.0, 0.3)]);
        let undercut = bar(&[(2.0, -2.0), (3.5, -2.0), (2.6, 0.5), (2.3, 0.5)]);
        difference(&difference(&block(), &groove).unwrap(), &undercut).unwrap()
    }

    /// Two needles that touch in their points, and a triangle that is missing.
    fn broken() -> Mesh {
        let corners = [(1.0, 0.0), (-0.5, 0.8), (-0.5, -0.8)].map(|(x, y)| DVec2::new(x, y));
        let mut mesh = Mesh { vertices: vec![DVec3::ZERO], triangles: Vec::new() };
        mesh.vertices.extend(corners.map(|p| p.extend(-2.0)));
        mesh.vertices.extend(corners.map(|p| (0.2 * p).extend(2.0)));
        for i in 0..3 {
            let [a, b] = [1 + i, 1 + (i + 1) % 3];
            mesh.triangles.extend([[0, a, b], [0, b + 3, a + 3]]);
        }
        mesh.triangles.extend([[1, 3, 2], [4, 5, 6]]);
        mesh.triangles.remove(2);
        mesh
    }

    #[test]
    fn what_is_nearer_than_the_gap_or_lies_below_is_held_and_little_more() {
        for (mesh, growth) in [with_knife(), with_groove(), broken()]
            .into_iter()
            .flat_map(|mesh| [0.0, 0.2].map(|radius| (mesh.clone(), Growth { gap: GAP, radius })))
        {
            let over = [DVec2::splat(-5.0), DVec2::splat(5.0)];
            let held = envelope(&mesh, &growth, over, -3.5, &Cancel::default()).unwrap();
            assert!(held.is_watertight());
            let (exact, own) = (ExactMesh::new(&held).unwrap(), ExactMesh::new(&mesh).unwrap());
            let mut rng = ChaCha8Rng::seed_from_u64(7);
            let mut unit = || DVec3::from_array([0; 3].map(|_| rng.random_range(-1.0..1.0)));
            for corners in mesh.iter_corners() {
                for _ in 0..60 {
                    let weights = unit().abs() + 1e-9;
                    let weights = weights / weights.element_sum();
                    let p = corners[0] * weights.x + corners[1] * weights.y + corners[2] * weights.z;
                    let beside = growth.radius * unit().truncate().clamp_length_max(1.0);
                    let near = p + 0.999 * (unit().clamp_length_max(1.0) * GAP + beside.extend(0.0));
                    let below = near.with_z(near.z + (-3.4 - near.z) * 0.5 * (1.0 + unit().x));
                    for q in [near, below] {
                        assert!(winding_number(&exact, q) > 0, "{q} near {p} is free");
                    }
                }
            }
            // A corner of what is held is no further from the surface than where planes that are carried on may meet,
            // but for what lies below.
            let furthest = LONGEST * GAP + FURTHEST * growth.radius + 1e-6;
            let shaded = |p: DVec3| own.first_crossing(p + DVec3::Z * 10.0, DVec3::NEG_Z, 10.0).is_some();
            for p in held.vertices.iter().filter(|p| p.z > -3.0 && !shaded(**p)) {
                let above = own.nearest(*p).signed_distance.abs();
                let is_under =
                    |d: DVec2| own.first_crossing(p.truncate().extend(10.0) + d.extend(0.0), DVec3::NEG_Z, 10.0 - p.z);
                let is_below =
                    (0..24).any(|i| is_under(DVec2::from_angle(f64::from(i) * TAU / 24.0) * furthest).is_some());
                assert!(above <= furthest || is_below, "{p} is {above} off");
            }
        }
    }

    /// A block under two by two pairs of facets of random heights, with an opening through it whose wall passes a micrometre
    /// beside their middle corner.
    fn with_slivers(rng: &mut ChaCha8Rng) -> Mesh {
        let mut heights: Vec<f64> = (0..9).map(|_| rng.random_range(0.0..1.2)).collect();
        heights[4] = 0.6;
        let at = |i: usize, j: usize, z: f64| DVec3::new(i as f64 - 1.0, j as f64 - 1.0, z);
        let columns: Vec<Vec<DVec3>> = (0..2)
            .flat_map(|i| {
                (0..2).flat_map(move |j| [[(i, j), (i + 1, j), (i + 1, j + 1)], [(i, j), (i + 1, j + 1), (i, j + 1)]])
            })
            .map(|t| t.iter().flat_map(|(i, j)| [at(*i, *j, -3.0), at(*i, *j, heights[3 * i + j])]).collect())
            .collect();
        let block = solid::union_of_hulls(&columns, &Cancel::default()).unwrap();
        let (along, off) = (DVec2::from_angle(rng.random_range(0.0..TAU)), rng.random_range(2e-4..3e-3));
        let corner = |u: f64, v: f64| along * u + along.perp() * (v + off);
        let ring = [corner(-0.9, 0.0), corner(0.7, 0.0), corner(0.7, 0.6), corner(-0.9, 0.6)];
        difference(&block, &prism(&[&ring], -4.0, 2.0).unwrap()).unwrap()
    }

    #[test]
    fn corners_of_slivers_clear_the_faces_at_their_other_end_too() {
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        let growth = Growth { gap: 0.05, radius: 0.0 };
        let mut count = 0;
        for _ in 0..150 {
            let mesh = with_slivers(&mut rng);
            let (moved, normals) = (corners(&mesh, &growth), vertex_normals(&mesh));
            for (a, b) in mesh.triangles.iter().flat_map(|[a, b, c]| [(*a, *b), (*b, *c), (*c, *a)]) {
                let [p, q] = [a, b].map(|v| mesh.vertices[v as usize]);
                let Corner::Meeting(to) = &moved[a as usize] else { continue };
                if p.distance(q) < 0.01 {
                    let least = normals[b as usize].iter().map(|n| n.dot(*to - q)).fold(f64::INFINITY, f64::min);
                    assert!(least > growth.gap - 1e-6, "{p} is moved {least} off a face at {q}");
                    count += 1;
                }
            }
        }
        assert!(count > 6, "{count}");
    }

    #[test]
    fn faces_are_moved_by_the_gap_and_walls_by_the_disc_too() {
        let pocket =
            difference(&block(), &prism_over(&[(-2.0, -1.0), (2.0, -1.0), (2.0, 1.0), (-2.0, 1.0)], -2.0, 1.0));
        let growth = Growth { gap: GAP, radius: 0.2 };
        let over = [DVec2::splat(-4.0), DVec2::splat(4.0)];
        let held = envelope(&pocket.unwrap(), &growth, over, -2.5, &Cancel::default()).unwrap();
        let room = prism_over(&[(-3.0, -3.0), (3.0, -3.0), (3.0, 3.0), (-3.0, 3.0)], -2.0, GAP);
        let head = difference(&room, &held).unwrap();
        let expected = (4.0 - 0.6) * (2.0 - 0.6) * 2.0;
        assert!((head.volume() - expected).abs() < 1e-6, "{} {expected}", head.volume());
    }

    #[test]
    fn nothing_is_made_for_one_who_has_gone() {
        let cancel = Cancel::default();
        cancel.cancel();
        let growth = Growth { gap: GAP, radius: 0.0 };
        let found = envelope(&block(), &growth, [DVec2::splat(-1.0), DVec2::splat(1.0)], -1.0, &cancel);
        assert!(matches!(found, Err(SolidError::Cancelled(_))));
    }
}
