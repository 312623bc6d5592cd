//! Sweep of a solid along a segment, or along the sides of a rectangle: its Minkowski sum with them.
//!
//! Every face is moved to the end of the segment that it looks to, and where faces that look to different ends meet,
//! the edge between them sweeps a parallelogram. This surface is closed. It winds around a point as often as the solid
//! meets the segment through that point in pieces, so that what it winds around at least once is the sum (Guibas,
//! Ramshaw and Stolfi, A Kinetic Framework for Computational Geometry, FOCS 1983). The sum with a rectangle is that
//! with one of its sides and then with the other: a frame around a pin meets a rectangle in one piece with a hole,
//! which would be counted as none.
//!
//! **Guaranteed:** but for the rounding of coordinates the sum is exact, whatever the solid: nothing that is shorter
//! than the segment is lost or turned over.

use std::collections::HashMap;

use glam::{DVec2, DVec3};

use super::mesh::{Mesh, unit_normal};
use super::solid::{SolidError, wound};

/// Slope of a face along the segment up to which it counts as parallel to it. What this does to the sum is no thicker
/// than the slope times the segment.
const PARALLEL: f64 = 1e-9;

/// Step to which [`on_grid`] rounds coordinates (mm): exact in binary, so that shifts by multiples of it are exact too.
const GRID: f64 = 1.0 / (1u64 << 30) as f64;

/// A length rounded up to the grid (mm).
pub fn up_to_grid(length: f64) -> f64 {
    (length / GRID).ceil() * GRID
}

/// A mesh with its vertices on a grid of a millionth of a micrometre. What was level or upright but for the rounding of
/// its coordinates is so exactly; moved along itself it would else cross itself in slivers without thickness.
pub fn on_grid(mesh: &Mesh) -> Mesh {
    mesh.mapped(|p| (p / GRID).round() * GRID)
}

/// The sum of a closed solid with the rectangle of these half sides (mm) across Z, its sides along X and Y.
///
/// # Errors
/// [`SolidError`].
pub fn with_rectangle(solid: &Mesh, half: DVec2) -> Result<Mesh, SolidError> {
    with_segment(&with_segment(solid, DVec3::X * half.x)?, DVec3::Y * half.y)
}

/// The sum of a closed solid with the segment from `-half` to `half` (mm); the solid itself where that has no length.
///
/// # Errors
/// [`SolidError`].
pub fn with_segment(solid: &Mesh, half: DVec3) -> Result<Mesh, SolidError> {
    let Some(along) = half.try_normalize() else { return Ok(solid.clone()) };
    let looks_back: Vec<bool> = solid.iter_corners().map(|c| unit_normal(c).dot(along) < -PARALLEL).collect();
    let count = solid.vertices.len() as u32;
    // Each vertex at the far end of the segment, and after all of these each at the near end.
    let vertices = solid.vertices.iter().map(|p| *p + half).chain(solid.vertices.iter().map(|p| *p - half)).collect();
    let mut backs: HashMap<(u32, u32), bool> = HashMap::with_capacity(3 * solid.triangles.len());
    for (&[a, b, c], &is_back) in solid.triangles.iter().zip(&looks_back) {
        [(a, b), (b, c), (c, a)].into_iter().for_each(|side| {
            backs.insert(side, is_back);
        });
    }
    let mut triangles: Vec<[u32; 3]> = Vec::with_capacity(solid.triangles.len());
    for (&[a, b, c], &is_back) in solid.triangles.iter().zip(&looks_back) {
        let shift = if is_back { count } else { 0 };
        triangles.push([a + shift, b + shift, c + shift]);
        for (a, b) in [(a, b), (b, c), (c, a)] {
            if !is_back && backs.get(&(b, a)) == Some(&true) {
                triangles.extend([[b, a, a + count], [b, a + count, b + count]]);
            }
        }
    }
    wound(&Mesh { vertices, triangles })
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;
    use crate::exact::ExactMesh;
    use crate::fixtures::{clipped, polygon_area};
    use crate::solid::{difference, prism, union};

    fn rectangle(x: f64, y: f64) -> Vec<DVec2> {
        [(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)].map(|(u, v)| DVec2::new(u * x, v * y)).to_vec()
    }

    fn polygon(corners: usize, radius: f64, first: f64) -> Vec<DVec2> {
        let at = |k: usize| DVec2::from_angle((k as f64 + first) / corners as f64 * TAU) * radius;
        (0..corners).map(at).collect()
    }

    /// A block with a hole through it.
    fn frame(hole: &[DVec2]) -> Mesh {
        let block = prism(&[&rectangle(12.0, 12.0)], 0.0, 2.0).unwrap();
        difference(&block, &prism(&[hole], -1.0, 3.0).unwrap()).unwrap()
    }

    /// Area of the part of a convex polygon from where the rectangle stays within it: what all shifts of it by the
    /// corners have in common.
    fn eroded_area(polygon: &[DVec2], half: DVec2) -> f64 {
        let mut kept = polygon.to_vec();
        for (x, y) in [(1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)] {
            let shift = half * DVec2::new(x, y);
            for i in 0..polygon.len() {
                let (a, b) = (polygon[i] + shift, polygon[(i + 1) % polygon.len()] + shift);
                kept = clipped(&kept, |p| (b - a).perp_dot(p - a));
            }
        }
        polygon_area(&kept)
    }

    #[test]
    fn a_block_grows_by_the_segment() {
        let block = prism(&[&rectangle(4.0, 3.0)], 0.0, 2.0).unwrap();
        let both = with_rectangle(&block, DVec2::new(0.5, 0.25)).unwrap();
        assert!(both.is_watertight() && (both.volume() - 5.0 * 3.5 * 2.0).abs() < 1e-12, "{}", both.volume());
        // Slanting: what a face of each pair sweeps along its normal.
        let half = DVec3::new(0.3, 0.4, 0.5);
        let slanted = with_segment(&block, half).unwrap();
        let expected = 24.0 + 2.0 * (0.3 * 6.0 + 0.4 * 8.0 + 0.5 * 12.0);
        assert!(slanted.is_watertight() && (slanted.volume() - expected).abs() < 1e-12, "{}", slanted.volume());
        assert_eq!(with_segment(&block, DVec3::ZERO).unwrap(), block);
    }

    #[test]
    fn a_round_hole_of_sides_shorter_than_the_segment_keeps_what_all_shifts_of_it_have_in_common() {
        let half = DVec2::splat(0.3);
        for (corners, first) in [(96, 0.0), (96, 0.5), (32, 0.31), (7, 0.1)] {
            let hole = polygon(corners, 3.0, first);
            let grown = with_rectangle(&frame(&hole), half).unwrap();
            let expected = (12.6 * 12.6 - eroded_area(&hole, half)) * 2.0;
            assert!(grown.is_watertight(), "{corners}");
            assert!((grown.volume() - expected).abs() < 1e-6, "{corners} {first}: {} {expected}", grown.volume());
        }
    }

    #[test]
    fn a_hole_narrower_than_the_segment_is_gone_and_a_pin_within_a_frame_is_not() {
        let filled = with_rectangle(&frame(&polygon(24, 0.5, 0.0)), DVec2::splat(0.6)).unwrap();
        assert!((filled.volume() - 13.2 * 13.2 * 2.0).abs() < 1e-6, "{}", filled.volume());
        // A pin in a hole: rectangles around the pin meet both it and, further out, the frame.
        let pin = prism(&[&rectangle(0.2, 0.2)], 0.0, 2.0).unwrap();
        let both = union(&frame(&rectangle(3.0, 3.0)), &pin).unwrap();
        let grown = with_rectangle(&both, DVec2::splat(0.5)).unwrap();
        let expected = (13.0 * 13.0 - 2.0 * 2.0 + 1.2 * 1.2) * 2.0;
        assert!((grown.volume() - expected).abs() < 1e-6, "{} {expected}", grown.volume());
    }

    #[test]
    fn no_shift_along_the_rectangle_enters_what_is_left_of_a_dish() {
        // A hollow that narrows downwards: facets that slant every way.
        let ring = |radius: f64, z: f64| polygon(20, radius, 0.3).into_iter().map(move |p| p.extend(z));
        let mut dish = Mesh { vertices: ring(2.0, 2.0).chain(ring(0.7, 0.5)).collect(), triangles: Vec::new() };
        let next = |i: u32| (i + 1) % 20;
        for i in 0..20 {
            dish.triangles.extend([[i + 20, next(i) + 20, next(i)], [i + 20, next(i), i]]);
        }
        dish.triangles.extend((1..19).flat_map(|i| [[20, 21 + i, 20 + i], [0, i, i + 1]]));
        let mold = difference(&prism(&[&rectangle(12.0, 12.0)], 0.0, 2.0).unwrap(), &dish).unwrap();
        let half = DVec2::new(0.3, 0.2);
        let grown = with_rectangle(&mold, half).unwrap();
        let (mold, left) = (ExactMesh::new(&mold).unwrap(), difference(&dish, &grown).unwrap());
        assert!(grown.is_watertight() && left.volume() > 1.0);
        let mut nearest = f64::INFINITY;
        for p in &left.vertices {
            let distance =
                |(x, y): &(f64, f64)| mold.nearest(*p + (half * DVec2::new(*x, *y)).extend(0.0)).signed_distance;
            let least = [(1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)].iter().map(distance).fold(9.0, f64::min);
            assert!(least > -1e-9, "{p} {least}");
            nearest = nearest.min(least);
        }
        assert!(nearest < 1e-9, "{nearest}");
    }
}
