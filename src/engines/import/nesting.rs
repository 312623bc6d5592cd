//! Parts of a surface that lie inside others.

use std::cell::OnceCell;

use glam::DVec3;

use super::orient::{Part, Patches};
use super::repair::weld_tolerance;
use geometry::bvh::Bvh;
use geometry::inside::half_solid_angle;
use geometry::mesh::Mesh;
use task::{Cancel, Cancelled};

/// How much work to spend on finding out which parts lie inside others: box tests and solid angles.
const MOST_BOX_TESTS: usize = 20_000_000;
const MOST_ANGLES: usize = 20_000_000;

/// Which parts bound cavities; `None` if that would take too long to find out.
///
/// A closed part lies inside another that winds round it and that it neither crosses nor touches. It bounds a cavity if
/// solids around it outnumber cavities around it. A part inside others that crosses or touches still others may be a
/// cavity or a rib that stands in one: the file tells, relative to the innermost part around it.
pub(super) fn cavities(
    mesh: &Mesh,
    patches: &Patches,
    parts: &[Part],
    cancel: &Cancel,
) -> Result<Option<Vec<bool>>, Cancelled> {
    let closed: Vec<usize> = (0..parts.len()).filter(|&i| parts[i].closed).collect();
    if closed.len().saturating_mul(closed.len()) > MOST_BOX_TESTS {
        return Ok(None);
    }
    let (triangles, start) = patches.members();
    let members = |part: usize| &triangles[start[part]..start[part + 1]];
    let trees: Vec<OnceCell<Bvh>> = vec![OnceCell::new(); parts.len()];
    let tree = |part: usize| -> Result<&Bvh, Cancelled> {
        if let Some(tree) = trees[part].get() {
            return Ok(tree);
        }
        let tree = Bvh::new(&submesh(mesh, members(part)), cancel)?;
        Ok(trees[part].get_or_init(|| tree))
    };
    let reach = weld_tolerance(mesh);
    let meet = |a: usize, b: usize| tree(a)?.meets(tree(b)?, reach, cancel);

    let mut around: Vec<Vec<usize>> = vec![Vec::new(); parts.len()];
    let mut angles = 0;
    for &inner in &closed {
        cancel.check()?;
        for &outer in closed.iter().filter(|&&outer| outer != inner && encloses(&parts[outer], &parts[inner])) {
            cancel.check()?;
            angles += members(outer).len();
            if angles > MOST_ANGLES {
                return Ok(None);
            }
            if is_inside(mesh, patches, members(outer), parts[inner].point) && !meet(inner, outer)? {
                around[inner].push(outer);
            }
        }
    }
    // Whatever lies around a part comes before it.
    let mut order: Vec<usize> = closed.iter().copied().filter(|&i| !around[i].is_empty()).collect();
    order.sort_by_key(|&i| around[i].len());
    let mut is_cavity = vec![false; parts.len()];
    for i in order {
        let mut crosses = false;
        for &other in closed.iter().filter(|&&o| o != i && parts[o].bounds.intersects(&parts[i].bounds)) {
            crosses = crosses || (!around[i].contains(&other) && !around[other].contains(&i) && meet(i, other)?);
        }
        let innermost = around[i].iter().copied().max_by_key(|&o| around[o].len());
        is_cavity[i] = match innermost {
            Some(outer) if crosses => {
                let outer_turned = (parts[outer].volume < 0.0) != is_cavity[outer];
                (parts[i].volume < 0.0) != outer_turned
            }
            _ => {
                let hollow = around[i].iter().filter(|&&o| is_cavity[o]).count();
                around[i].len() > 2 * hollow
            }
        };
    }
    Ok(Some(is_cavity))
}

/// Whether the box of a part lies within that of another.
fn encloses(outer: &Part, inner: &Part) -> bool {
    outer.bounds.min.cmplt(inner.bounds.min).all() && outer.bounds.max.cmpgt(inner.bounds.max).all()
}

/// The triangles `members` of a mesh.
fn submesh(mesh: &Mesh, members: &[u32]) -> Mesh {
    let vertices: Vec<DVec3> = members.iter().flat_map(|&t| mesh.corners(t as usize)).collect();
    let triangles = (0..members.len() as u32).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
    Mesh { vertices, triangles }
}

/// Whether a closed part winds round `point`: the sum of the solid angles of its triangles is 4 pi, else 0.
fn is_inside(mesh: &Mesh, patches: &Patches, members: &[u32], point: DVec3) -> bool {
    let half_angle = |&t: &u32| {
        let angle = half_solid_angle(&mesh.corners(t as usize), point);
        if patches.flip[t as usize] { -angle } else { angle }
    };
    members.iter().map(half_angle).sum::<f64>().abs() > std::f64::consts::PI
}
