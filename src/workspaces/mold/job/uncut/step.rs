//! How fine the field of heights has to be.

use geometry::mesh::Mesh;
use mold::cutter::{Cutter, CutterKind};

/// Cells of the field of heights that a smallest radius is divided into, where memory allows.
const CELLS_PER_RADIUS: f64 = 40.0;
/// Tolerances that the field's step is wide, and steps across a mold, at most, that are made for that.
const STEPS: (f64, f64) = (2.0, 2500.0);
/// Cells of a smallest diameter at most: time grows with them, for rounded cutters with their square.
const MOST_ACROSS: [f64; 2] = [400.0, 160.0];
/// Cells of the field of heights, at most, unless its step is given: some 20 bytes each.
const MOST_CELLS: f64 = 36e6;

/// The grid's usual step (mm): as fine as the smallest of `cutters` and the `tolerance` (mm) ask for, but with no more
/// cells than a computer holds with ease, and such that every cutter is close to a whole number of cells wide, for the
/// grid takes it for that.
pub(super) fn usual_step(mesh: &Mesh, cutters: &[&Cutter], tolerance: f64) -> f64 {
    let least = cutters.iter().map(|c| c.diameter_mm).fold(f64::INFINITY, f64::min);
    let widest = cutters.iter().map(|c| c.holder().map_or(c.radius(), |(holder, _)| holder)).fold(0.0, f64::max);
    let size = mesh.bounds().size().truncate() + 2.0 * widest;
    let coarsest = (size.x * size.y / MOST_CELLS).sqrt();
    let fine = (STEPS.0 * tolerance).max(mesh.bounds().size().truncate().max_element() / STEPS.1);
    let is_rounded = cutters.iter().any(|c| c.kind() != CutterKind::Flat);
    let across = (least / fine).min(MOST_ACROSS[usize::from(is_rounded)]).max(2.0 * CELLS_PER_RADIUS);
    let most = across.min(least / coarsest).floor();
    if most < 2.0 {
        return coarsest;
    }
    // Off a whole number, in shares of a cell, at worst.
    let off = |count: f64| {
        let widths = cutters.iter().map(|c| c.diameter_mm / least * count);
        widths.map(|w| (w - w.round()).abs()).fold(0.0, f64::max)
    };
    let counts = (0..=(most / 5.0) as usize).map(|k| most - k as f64).filter(|count| *count >= 2.0);
    least / counts.fold(most, |best, count| if off(count) < off(best) - 0.02 { count } else { best })
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;

    #[test]
    fn the_grid_fits_the_cutters() {
        let mesh = Mesh::cuboid(DVec3::new(100.0, 80.0, 3.0));
        let step = |cutters: &[Cutter]| usual_step(&mesh, &cutters.iter().collect::<Vec<_>>(), 0.02);
        assert_eq!(step(&[Cutter::flat(1.0)]), 0.025);
        for cutters in [vec![Cutter::ball(0.5)], vec![Cutter::flat(1.3), Cutter::ball(1.0)], vec![Cutter::flat(1e-2)]] {
            let step = step(&cutters);
            assert!(8000.0 / (step * step) <= 1.1 * MOST_CELLS, "{step}");
        }
        let step = step(&[Cutter::flat(1.3), Cutter::ball(1.0)]);
        for diameter in [2.6, 2.0] {
            let cells = diameter / step;
            assert!((cells - f64::round(cells)).abs() < 0.05, "{cells} cells");
        }
    }
}
