//! What a body that sinks straight down must stay above: a surface grown by a gap, and everything straight below that.
//!
//! The set of places nearer to a surface than the gap is the union of its triangles, each grown by a ball. A body that
//! moves along Z stays clear of it if it stays above its upper envelope, so each grown triangle is taken as the convex
//! column from it down to a floor. The union of these columns exists for every mesh: knife edges, points, open or
//! crossing surfaces included, and overhangs shade what lies below them.
//!
//! **Accuracy, always on the safe side:** faces are moved by the gap exactly. Where faces meet, their planes are
//! carried on until they meet, as long as that is no more than [`LONGEST`] gaps away; beyond, a polyhedron around the
//! ball takes its place, which reaches no more than 8 % of the gap beyond it.

use std::collections::{HashMap, HashSet};
use std::f64::consts::TAU;
use std::sync::LazyLock;

use glam::{DMat3, DVec2, DVec3};
use rayon::prelude::*;

use super::mesh::{Bounds, Mesh, unit_normal};
use super::offset::{least_shift, vertex_normals};
use super::solid::{self, SolidError, hull};
use task::Cancel;

/// Gaps within which the planes of faces that meet are carried on.
const LONGEST: f64 = 1.8;
/// Step to which moved corners are rounded (mm): exact in binary, so that it can be told exactly which faces look up.
const GRID: f64 = 1.0 / (1u64 << 30) as f64;
/// Directions in which a ball is bounded that lie nearer to a face's normal than this are left out (rad).
const APART: f64 = 0.25;
/// Part of a unit normal downwards from which on others lie over a face.
const LEVEL: f64 = 1e-3;
/// Share of its size by which a column around a corner is larger, and how many such shares there are.
const HAIR: f64 = 1e-6;
const HAIRS: usize = 61;
/// Corners of the polygon around a disc that sweeps.
const DISC: usize = 24;

/// What a body sweeps across Z beside its way.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Sweep {
    /// Nothing.
    None,
    /// A disc of this radius (mm).
    Disc(f64),
    /// A square of this half side along X and Y (mm).
    Square(f64),
}

impl Sweep {
    /// How far it goes (mm).
    fn reach(self) -> f64 {
        match self {
            Self::None => 0.0,
            Self::Disc(radius) => radius,
            Self::Square(half) => half * std::f64::consts::SQRT_2,
        }
    }

    /// Corners of a polygon around it.
    fn polygon(self) -> Vec<DVec2> {
        let around = |corners: usize, radius: f64| {
            let step = TAU / corners as f64;
            (0..corners).map(|i| DVec2::from_angle((i as f64 + 0.5) * step) * radius / (0.5 * step).cos()).collect()
        };
        match self {
            Self::None => vec![DVec2::ZERO],
            Self::Disc(radius) => around(DISC, radius),
            Self::Square(half) => around(4, half),
        }
    }
}

/// What is kept clear around a surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Growth {
    /// Distance (mm).
    pub gap: f64,
    /// What else a body sweeps across Z.
    pub sweep: Sweep,
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
    let reach = LONGEST * (growth.gap + growth.sweep.reach());
    let is_near = |t: &usize| {
        let Bounds { min, max } = Bounds::of(mesh.corners(*t));
        max.z + reach > floor && (max.truncate() + reach).cmpge(low).all() && (min.truncate() - reach).cmple(high).all()
    };
    let near: Vec<usize> = (0..mesh.triangles.len()).filter(is_near).collect();
    // All columns stand on one floor, below faces that reach further down too.
    let lowest = near.iter().flat_map(|t| mesh.corners(*t)).map(|p| p.z).fold(floor, f64::min);
    let floor = ((lowest - reach) / GRID).floor() * GRID;
    // Beside what is not moved as one, the surface that is has borders: there no fold of it covers another.
    let mut is_beside = vec![false; mesh.vertices.len()];
    for triangle in &mesh.triangles {
        let has_one = triangle.iter().any(|v| matches!(corners[*v as usize], Corner::Around(_)));
        triangle.iter().for_each(|v| is_beside[*v as usize] |= has_one);
    }
    let needs_own = |t: &usize| {
        let triangle = mesh.triangles[*t];
        let looks_down = unit_normal(mesh.corners(*t)).z < -LEVEL;
        triangle.iter().any(|v| matches!(corners[*v as usize], Corner::Around(_)))
            || (triangle.iter().any(|v| is_beside[*v as usize]) && !looks_up(&corners, triangle) && !looks_down)
    };
    let own = near.iter().filter(|t| needs_own(t));
    let hulls: Vec<Vec<DVec3>> = own.map(|t| column_around(mesh, &corners, *t, floor)).collect();
    let moved: Vec<[u32; 3]> =
        near.iter().copied().map(|t| mesh.triangles[t]).filter(|t| looks_up(&corners, *t)).collect();
    cancel.check()?;
    cancel.check()?;
    let columns = solid::unfolded(below(&corners, &moved, floor))?;
    solid::union(&columns, &solid::union_of_hulls(&hulls, cancel)?)
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
    let of = |((p, normals), is_whole): ((&DVec3, &Vec<DVec3>), &bool)| {
        let even = least_shift(&normals.iter().map(|n| (*n, growth.gap)).collect::<Vec<_>>());
        let even = even.filter(|shift| *is_whole && !normals.is_empty() && shift.length() <= LONGEST * growth.gap);
        let at = |d: DVec3| ((*p + d) / GRID).round() * GRID;
        match (even, growth.sweep) {
            (Some(even), Sweep::None) => Corner::Meeting(at(even)),
            (Some(even), Sweep::Disc(radius)) if let Some(across) = across(normals, radius) => {
                Corner::Meeting(at(even + across))
            }
            (Some(even), sweep) => Corner::Around(sweep.polygon().iter().map(|s| at(even + s.extend(0.0))).collect()),
            (None, _) => Corner::Around(around(normals, growth).into_iter().map(at).collect()),
        }
    };
    mesh.vertices.par_iter().zip(&normals).zip(&whole).map(of).collect()
}

/// The shortest shift across Z by which faces with these normals are moved as far as by a disc; none where it would go
/// much further than the disc.
fn across(normals: &[DVec3], radius: f64) -> Option<DVec3> {
    /// Part of a normal across Z up to which a face is level: rounding of files.
    const LEVEL: f64 = 1e-4;
    let across = normals.iter().map(|n| n.with_z(0.0)).filter(|n| n.length() > LEVEL);
    let planes: Vec<(DVec3, f64)> = across.map(|n| (n.normalize(), radius)).collect();
    least_shift(&planes).filter(|shift| shift.length() <= LONGEST * radius)
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
    const FURTHEST: f64 = 1.2;
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
        met.unwrap_or(outwards).clamp_length_max(FURTHEST * growth.gap)
    };
    let ball: Vec<DVec3> = dual.iter_corners().map(corner).collect();
    let swept = growth.sweep.polygon();
    ball.iter().flat_map(|p| swept.iter().map(|s| *p + s.extend(0.0))).collect()
}

/// Directions upwards and level, no two neighbours further apart than 31 degrees: those of a divided octahedron.
static DIRECTIONS: LazyLock<Vec<DVec3>> = LazyLock::new(|| {
    const STEPS: i32 = 3;
    let all = (-STEPS..=STEPS).flat_map(|x| (-STEPS..=STEPS).map(move |y| (x, y)));
    let up = all.filter(|(x, y)| x.abs() + y.abs() <= STEPS);
    let of = |(x, y): (i32, i32)| DVec3::new(f64::from(x), f64::from(y), f64::from(STEPS - x.abs() - y.abs()));
    up.map(|direction| of(direction).normalize()).collect()
});

/// Points whose hull is the column under a grown triangle.
fn column_around(mesh: &Mesh, corners: &[Corner], triangle: usize, floor: f64) -> Vec<DVec3> {
    let moved = mesh.triangles[triangle].iter().flat_map(|v| corners[*v as usize].points()).copied();
    let high: Vec<DVec3> = moved.chain(mesh.corners(triangle)).collect();
    let low = high.iter().map(|p| p.with_z(floor));
    let points: Vec<DVec3> = high.iter().copied().chain(low).collect();
    // Solids whose faces lie in one another cannot be told apart once their corners are rounded: each is larger by a
    // hair of its own.
    let hair = HAIR * (1.0 + (triangle % HAIRS) as f64);
    let middle = points.iter().sum::<DVec3>() / points.len() as f64;
    points.iter().map(|p| *p + (*p - middle) * hair).collect()
}
