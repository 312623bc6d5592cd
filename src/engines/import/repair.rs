//! From the triangles of a file to a mesh that is as sound as it can be made without inventing surface.

use glam::DVec3;

use super::clean::{Slivers, drop_collapsed, drop_duplicates, exchange_slivers};
use super::contacts::split_touching;
use super::edges::{EdgeTable, NONE};
use super::holes::{Hole, trace};
use super::orient::{Orientation, orient};
use super::weld::weld_near;
use geometry::mesh::{Bounds, Mesh};
use task::{Cancelled, Task};

/// Cracks of exporters are about the last digit of their numbers wide, relative to the part's size.
const WELD_RELATIVE_TO_SIZE: f64 = 1e-6;

/// Coordinates of `f32` carry 24 bits; two roundings of one point may lie a few units of the last apart.
const WELD_RELATIVE_TO_COORDINATE: f64 = 4.0 * f32::EPSILON as f64;

/// Triangles this much lower than the tolerance of welding count as without height.
const HEIGHT_RELATIVE_TO_WELD: f64 = 0.25;

/// How many places of edges with three or more triangles are reported.
const PLACES: usize = 20;

/// Repairs made to a mesh, and the defects that remain.
#[derive(Debug, Default)]
pub(super) struct Repairs {
    /// Tolerance within which vertices count as one (mm).
    pub weld_tolerance: f64,
    /// Whether that was needed: a mesh that closes with equal vertices alone is not touched.
    pub welded_near: bool,
    pub collapsed: usize,
    pub duplicates: usize,
    /// Edges along which solids touch, which were split.
    pub touching_edges: usize,
    pub slivers: Slivers,
    pub orientation: Orientation,
    pub holes: Vec<Hole>,
    pub non_manifold_edges: usize,
    pub non_manifold_places: Vec<DVec3>,
    pub watertight: bool,
}

/// The tolerance of welding (mm) that suits a mesh.
pub(super) fn weld_tolerance(mesh: &Mesh) -> f64 {
    let bounds = mesh.bounds();
    let farthest = bounds.min.abs().max(bounds.max.abs()).max_element();
    (WELD_RELATIVE_TO_SIZE * bounds.size().length()).max(WELD_RELATIVE_TO_COORDINATE * farthest)
}

/// Repairs `mesh` (mm, no two vertices equal): no cracks, no collapsed or doubled triangles, solids that touch split, all
/// turned outwards.
///
/// Vertices come out numbered in the order in which the triangles first use them. No step opens a surface that was
/// closed; holes are reported, not filled.
pub(super) fn repair(mesh: Mesh, tolerance: Option<f64>, task: &Task) -> Result<(Mesh, Repairs), Cancelled> {
    let mut mesh = compact(mesh);
    let weld_tolerance = tolerance.unwrap_or_else(|| weld_tolerance(&mesh));
    let mut repairs = Repairs { weld_tolerance, ..Default::default() };
    repairs.collapsed = drop_collapsed(&mut mesh);
    let mut table = EdgeTable::of(&mesh, task)?;
    if weld_tolerance > 0.0 && !table.is_closed() {
        mesh = weld_near(mesh, weld_tolerance, task)?;
        repairs.collapsed += drop_collapsed(&mut mesh);
        repairs.welded_near = true;
        table = EdgeTable::of(&mesh, task)?;
    }
    repairs.duplicates = drop_duplicates(&mut mesh, &table, task)?;
    if repairs.duplicates > 0 {
        table = EdgeTable::of(&mesh, task)?;
    }
    task.check()?;
    let mut boundary = trace(&mesh, &table);
    match closed_apart(&mesh, &table, weld_tolerance, task)? {
        Some((split, split_table, orientation)) => {
            repairs.touching_edges = table.edges().filter(|edge| edge.halves().len() > 2).count();
            boundary = trace(&split, &split_table);
            (mesh, table, repairs.orientation) = (split, split_table, orientation);
        }
        None => repairs.orientation = orient(&mut mesh, &table, &boundary, task)?,
    }
    repairs.holes = boundary.holes;
    task.check()?;
    let height = HEIGHT_RELATIVE_TO_WELD * weld_tolerance;
    repairs.slivers = exchange_slivers(&mut mesh, height, task)?;
    if repairs.orientation.flipped + repairs.orientation.turned + repairs.slivers.exchanged > 0 {
        table = EdgeTable::of(&mesh, task)?;
    }
    task.check()?;
    repairs.watertight = !mesh.triangles.is_empty() && table.is_watertight(&mesh);
    let branches = table.edges().filter(|edge| edge.halves().len() > 2);
    for edge in branches {
        repairs.non_manifold_edges += 1;
        if repairs.non_manifold_places.len() < PLACES {
            let middle = (mesh.vertices[edge.low as usize] + mesh.vertices[edge.high as usize]) * 0.5;
            repairs.non_manifold_places.push(middle);
        }
    }
    Ok((compact(mesh), repairs))
}

/// `mesh` with solids that touch split, turned outwards, and its edges; none unless every part is a closed solid then.
fn closed_apart(
    mesh: &Mesh,
    table: &EdgeTable,
    tolerance: f64,
    task: &Task,
) -> Result<Option<(Mesh, EdgeTable, Orientation)>, Cancelled> {
    let Some(mut split) = split_touching(mesh, table, tolerance, task)? else { return Ok(None) };
    let table = EdgeTable::of(&split, task)?;
    let boundary = trace(&split, &table);
    let orientation = orient(&mut split, &table, &boundary, task)?;
    Ok((orientation.unsure == 0 && table.is_closed()).then_some((split, table, orientation)))
}

/// `mesh` with its vertices numbered in the order in which triangles first use them, and no others.
fn compact(mesh: Mesh) -> Mesh {
    let mut number = vec![NONE; mesh.vertices.len()];
    let mut vertices = Vec::with_capacity(mesh.vertices.len());
    let mut triangles = mesh.triangles;
    for v in triangles.iter_mut().flatten() {
        let slot = &mut number[*v as usize];
        if *slot == NONE {
            *slot = vertices.len() as u32;
            vertices.push(mesh.vertices[*v as usize]);
        }
        *v = *slot;
    }
    Mesh { vertices, triangles }
}

/// Largest extent of the vertices that triangles use.
pub(super) fn largest_extent(mesh: &Mesh) -> f64 {
    Bounds::of(mesh.iter_corners().flatten()).size().max_element().max(0.0)
}
