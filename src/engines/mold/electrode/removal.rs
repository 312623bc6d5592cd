//! What each stage takes away, and over which area it burns.

use glam::{DMat3, DVec3};

use super::params::Stage;
use super::plan::{RegionToBurn, Setting};
use geometry::mesh::{Mesh, unit_normal};

/// Volume of the layer that a stage leaves of a region for the next one (mm^3): as thick as that one's electrode is larger
/// than its own, and no less than its stock.
pub(super) fn layer(region: &RegionToBurn, turned: &DMat3, [stage, next]: [&Stage; 2]) -> f64 {
    let of = |corners: &[DVec3; 3]| {
        let [a, b, c] = corners.map(|p| *turned * p);
        let area = 0.5 * (b - a).cross(c - a).length();
        let normal = unit_normal([a, b, c]);
        // On a surface that has no normal there is no layer.
        let thick = (stage.undersize(normal) - next.undersize(normal)).max(stage.stock_mm);
        if area > 0.0 { area * thick } else { 0.0 }
    };
    region.corners.iter().map(of).sum()
}

/// Area of bodies on the surface that burns, the mold's own moved by the gap (mm^2).
pub(super) fn burn_area<'a>(setting: &Setting, bodies: impl Iterator<Item = &'a Mesh>) -> f64 {
    let of = |body: &Mesh| -> f64 {
        let burns: Vec<bool> = body.vertices.iter().map(|p| setting.burns(*p)).collect();
        let is_burning = |t: &&[u32; 3]| {
            let middle = t.iter().map(|i| body.vertices[*i as usize]).sum::<DVec3>() / 3.0;
            t.iter().all(|i| burns[*i as usize]) && setting.burns(middle)
        };
        let area = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|i| body.vertices[i as usize]);
            0.5 * (b - a).cross(c - a).length()
        };
        // The sum of none is a zero with a sign.
        body.triangles.iter().filter(is_burning).map(area).sum::<f64>() + 0.0
    };
    bodies.map(of).sum::<f64>() + 0.0
}
