//! The axis of half a wheel, which lies in the one plane that cuts it out.

use std::ops::RangeInclusive;

use glam::{DMat3, DVec2, DVec3};

use super::cuts::Cut;
use crate::frame::axis::{self, Axis};
use geometry::mesh::{Mesh, normal_times_two_areas};

/// Lines in a cut, if it leaves half a wheel, that may be its axis. `is_turned` tells whether enough of the surface turns
/// about a line.
pub(super) fn axes(mesh: &Mesh, cut: &Cut, on_cut: f64, is_turned: impl Fn(&Axis) -> bool) -> Vec<Axis> {
    /// How far a line may be off the cut before it is moved into it (rad, share of the size): the turned surfaces of a
    /// thin wheel tell it no better.
    const NEAR: f64 = 0.05;
    let size = mesh.bounds().size().length();
    let facets = facets_in(mesh, cut, on_cut);
    let may_be = |axis: &Axis| is_turned(axis) && is_divided(&facets, cut, axis);
    let in_cut = |axis: Axis| {
        let axis = axis::of_turned_surfaces(mesh, axis).unwrap_or(axis);
        let off = cut.normal.dot(axis.point) - cut.at;
        let is_near = axis.direction.dot(cut.normal).abs() < NEAR && off.abs() < NEAR * size;
        let direction = axis.direction.reject_from_normalized(cut.normal);
        is_near.then(|| Axis::new(axis.point - off * cut.normal, direction))
    };
    let found = lines_of_symmetry(&facets).into_iter().filter(may_be).filter_map(in_cut);
    found.map(|axis| of_arcs(mesh, cut, on_cut, axis)).filter(may_be).collect()
}

/// Whether a line divides the area in a cut about as the axis of half a wheel does.
pub(super) fn divides(mesh: &Mesh, cut: &Cut, on_cut: f64, axis: &Axis) -> bool {
    is_divided(&facets_in(mesh, cut, on_cut), cut, axis)
}

fn is_divided(facets: &[(DVec3, f64)], cut: &Cut, axis: &Axis) -> bool {
    /// Share of the area on one side.
    const HALVES: RangeInclusive<f64> = 0.3..=0.7;
    let across = cut.normal.cross(axis.direction);
    let beyond = facets.iter().filter(|(p, _)| across.dot(*p - axis.point) > 0.0).map(|(_, area)| area);
    HALVES.contains(&(beyond.sum::<f64>() / cut.area))
}

/// Middles and areas of the facets in a cut.
fn facets_in(mesh: &Mesh, cut: &Cut, on_cut: f64) -> Vec<(DVec3, f64)> {
    let facet = |t: [DVec3; 3]| ((t[0] + t[1] + t[2]) / 3.0, 0.5 * normal_times_two_areas(t).dot(cut.normal));
    cut.facets(mesh, on_cut).map(facet).collect()
}

/// The lines in a cut of these facets that its area may be symmetric about, as it is about the axis where it leaves half
/// a wheel.
fn lines_of_symmetry(facets: &[(DVec3, f64)]) -> [Axis; 2] {
    let center = facets.iter().map(|(p, area)| *area * *p).sum::<DVec3>() / facets.iter().map(|f| f.1).sum::<f64>();
    let moments = facets.iter().fold(DMat3::ZERO, |sum, (p, area)| sum + axis::outer(*p - center) * *area);
    // Square to the cut there is none.
    let [_, (_, narrow), (_, wide)] = axis::eigen(moments);
    [narrow, wide].map(|direction| Axis::new(center, direction))
}

/// The line in a cut near `axis` about which the arcs of the mesh run. The vertices of an arc lie on its circle, however
/// coarse the mesh is, so that each edge between two of them is square to the axis, and the plane through its middle that
/// it is square to holds the axis: least squares, in which edges that are no arcs lose their say.
fn of_arcs(mesh: &Mesh, cut: &Cut, on_cut: f64, mut axis: Axis) -> Axis {
    /// Parts of an edge along the axis and along the radius, at most, from round to round.
    const MOST_OFF: [f64; 9] = [0.1, 0.1, 0.1, 0.05, 0.05, 0.02, 0.02, 0.02, 0.02];
    /// Greatest length of an edge as a share of the radius.
    const MOST_LENGTH: f64 = 1.0;
    let is_cut = |p: DVec3| cut.at - cut.normal.dot(p) <= on_cut;
    let edges = mesh.iter_corners().flat_map(|[a, b, c]| [[a, b], [b, c], [c, a]]);
    // The edges that the cut divides end beside their circles.
    let all: Vec<(DVec3, DVec3, f64)> = edges
        .filter(|edge| !edge.iter().any(|p| is_cut(*p)))
        .map(|[a, b]| (0.5 * (a + b), (b - a).normalize_or_zero(), (b - a).length()))
        .filter(|(.., length)| *length > on_cut)
        .collect();
    let origin = all.iter().map(|(middle, ..)| *middle).sum::<DVec3>() / all.len().max(1) as f64;
    let reach = all.iter().map(|(middle, ..)| middle.distance(origin)).fold(f64::MIN_POSITIVE, f64::max);
    for most_off in MOST_OFF {
        let is_arc = |(middle, along, length): &&(DVec3, DVec3, f64)| {
            let arm = (*middle - axis.point).reject_from_normalized(axis.direction);
            let off = along.dot(axis.direction).abs().max(along.dot(arm.normalize_or_zero()).abs());
            off < most_off && *length < MOST_LENGTH * arm.length()
        };
        let edges: Vec<&(DVec3, DVec3, f64)> = all.iter().filter(is_arc).collect();
        let point = axis.point + axis.direction * axis.direction.dot(origin - axis.point);
        let across = cut.normal.cross(axis.direction);
        // How far the two conditions of each edge are missed (mm), and how that changes as the axis moves and tilts.
        let misses = edges.iter().flat_map(|(middle, along, _)| {
            let (arm, sideways) = (*middle - point, along.dot(across));
            let height = axis.direction.dot(arm);
            let beside = along.dot(arm - height * axis.direction);
            let aslant = reach * along.dot(axis.direction);
            [(beside, DVec2::new(-sideways, -sideways * height / reach)), (aslant, DVec2::new(0.0, sideways))]
        });
        let misses: Vec<(f64, DVec2)> = misses.collect();
        let mut sizes: Vec<f64> = misses.iter().map(|(miss, _)| miss.abs()).collect();
        sizes.sort_by(f64::total_cmp);
        let Some(typical) = sizes.get(sizes.len() / 2).map(|size| 4.5 * size + f64::MIN_POSITIVE) else { return axis };
        let (mut square, mut right) = ([0.0; 3], DVec2::ZERO);
        for (miss, change) in misses {
            let weight = (1.0 + (miss / typical).powi(2)).powi(-2);
            square[0] += weight * change.x * change.x;
            square[1] += weight * change.x * change.y;
            square[2] += weight * change.y * change.y;
            right -= weight * miss * change;
        }
        let [xx, xy, yy] = square;
        let determinant = xx * yy - xy * xy;
        if determinant <= 1e-9 * xx * yy {
            return axis;
        }
        let step = DVec2::new(yy * right.x - xy * right.y, xx * right.y - xy * right.x) / determinant;
        axis = Axis::new(point + step.x * across, axis.direction + step.y / reach * across);
    }
    axis
}
