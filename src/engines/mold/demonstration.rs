//! A mold to begin with, made here: what a shop burns of a mold is on it once.

use glam::DVec2;

use geometry::mesh::Mesh;
use geometry::solid::{SolidError, difference, prism, union};

/// Size of the block (mm).
const BLOCK: [f64; 2] = [64.0, 46.0];
/// Height of the block, of the cavity's floor and of the floor of its ribs (mm).
const HEIGHTS: [f64; 3] = [18.0, 11.0, 7.0];
/// How far what is taken away reaches above the block (mm).
const ABOVE: f64 = 2.0;
/// Greatest angle of an arc between two corners (degrees).
const ARC_DEG: f64 = 6.0;

/// The mold, which opens along +Z: a cavity with rounded corners, and in its floor two ribs of one shape, a cross of
/// ribs, a pocket with sharp corners, and a round boss.
///
/// # Errors
/// [`SolidError`], which a test keeps from happening.
pub fn demonstration() -> Result<Mesh, SolidError> {
    let [top, floor, deep] = HEIGHTS;
    let mut mold = prism(&[&rounded(BLOCK, 0.0)], 0.0, top)?;
    mold = difference(&mold, &prism(&[&rounded([52.0, 34.0], 6.0)], floor, top + ABOVE)?)?;
    let hollows = [
        (rounded([1.2, 14.0], 0.0), DVec2::new(-18.0, 4.0), deep),
        (rounded([1.2, 14.0], 0.0), DVec2::new(-12.0, 4.0), deep),
        (cross(14.0, 1.6), DVec2::new(14.0, 2.0), deep),
        (rounded([7.0, 5.0], 0.0), DVec2::new(-15.0, -11.0), 0.5 * (floor + deep)),
    ];
    for (outline, at, low) in hollows {
        let outline: Vec<DVec2> = outline.into_iter().map(|p| p + at).collect();
        mold = difference(&mold, &prism(&[&outline], low, floor + ABOVE)?)?;
    }
    let boss: Vec<DVec2> = rounded([7.0, 7.0], 3.5).into_iter().map(|p| p + DVec2::new(0.0, -10.0)).collect();
    union(&mold, &prism(&[&boss], floor - 1.0, floor + 4.0)?)
}

/// A rectangle about the origin with corners of this radius, counter-clockwise (mm).
fn rounded([x, y]: [f64; 2], radius: f64) -> Vec<DVec2> {
    let steps = if radius > 0.0 { (90.0 / ARC_DEG).ceil() as usize } else { 0 };
    let corner = |quarter: usize| {
        let sign = [DVec2::ONE, DVec2::new(-1.0, 1.0), DVec2::NEG_ONE, DVec2::new(1.0, -1.0)][quarter];
        let middle = sign * (0.5 * DVec2::new(x, y) - radius);
        let angle = move |i: usize| (quarter as f64 + i as f64 / steps.max(1) as f64) * std::f64::consts::FRAC_PI_2;
        (0..=steps).map(move |i| middle + radius * DVec2::from_angle(angle(i)))
    };
    let mut points: Vec<DVec2> = (0..4).flat_map(corner).collect();
    points.dedup_by(|a, b| a.distance(*b) < 1e-9);
    if points.first().zip(points.last()).is_some_and(|(a, b)| a.distance(*b) < 1e-9) {
        points.pop();
    }
    points
}

/// A cross of two bars about the origin, counter-clockwise (mm).
fn cross(length: f64, width: f64) -> Vec<DVec2> {
    let (l, w) = (0.5 * length, 0.5 * width);
    let arm = |x: DVec2| [(w, -l), (w, -w), (l, -w)].map(|(u, v)| x * u + x.perp() * v);
    [DVec2::X, DVec2::Y, DVec2::NEG_X, DVec2::NEG_Y].into_iter().flat_map(arm).collect()
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    #[test]
    fn it_is_closed_and_holds_what_is_taken_from_the_block() {
        let mesh = demonstration().unwrap();
        assert!(mesh.is_watertight());
        let corners = (4.0 - PI) * 36.0;
        let cavity = (52.0 * 34.0 - corners) * 7.0;
        let hollows = 2.0 * 1.2 * 14.0 * 4.0 + (2.0 * 14.0 * 1.6 - 1.6 * 1.6) * 4.0 + 7.0 * 5.0 * 2.0;
        let exact = 64.0 * 46.0 * 18.0 - cavity - hollows + PI * 3.5 * 3.5 * 4.0;
        assert!((mesh.volume() / exact - 1.0).abs() < 1e-3, "{} {exact}", mesh.volume());
        assert_eq!(demonstration().unwrap(), mesh, "the same whenever it is made");
    }
}
