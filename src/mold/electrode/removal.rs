//! What each stage takes away, and over which area it burns.

use glam::DVec3;

use super::params::Stage;
use super::plan::{RegionToBurn, Setting};
use crate::geometry::mesh::{Mesh, unit_normal};

/// Volume that stage number `stage` takes of a region (mm^3).
///
/// A stage leaves a layer for the next one: as thick as that one's electrode is larger than its own, and no less than its
/// stock. The last stage takes all that is left, so that all together take the region's volume. `made` says of each stage
/// up to this one which share of the region it has tips for: of the rest it takes nothing.
pub(super) fn taken(region: &RegionToBurn, setting: &Setting, (stages, stage): (&[Stage], usize), made: &[f64]) -> f64 {
    let left_by = |number: usize| -> f64 {
        let (Some(stage), Some(next)) = (stages.get(number), stages.get(number + 1)) else { return 0.0 };
        let of = |corners: &[DVec3; 3]| {
            let [a, b, c] = corners.map(|p| setting.turned * p);
            let area = 0.5 * (b - a).cross(c - a).length();
            let normal = unit_normal([a, b, c]);
            // On a surface that has no normal there is no layer.
            let thick = (stage.undersize(normal) - next.undersize(normal)).max(stage.stock_mm);
            if area > 0.0 { area * thick } else { 0.0 }
        };
        region.corners.iter().map(of).sum()
    };
    let (mut left, mut taken) = (region.volume, 0.0);
    for (number, share) in made.iter().enumerate().take(stage + 1) {
        taken = share * (left - left.min(left_by(number)));
        left -= taken;
    }
    taken
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
