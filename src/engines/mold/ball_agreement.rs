//! How far the grid of heights and the exact search agree on what ball-end cutters leave.

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::cutter::{CutterKind, CutterLibrary};
use super::height_field::{Closing, FieldRegion, HeightField};
use super::rolling::ball::BallReach;
use geometry::mesh::Mesh;
use task::{Cancel, Cancelled};

/// Places that are looked at, at most.
const PLACES: usize = 400;

/// By how much the heights of what balls leave differ (mm).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct BallAgreement {
    /// Places that were looked at.
    pub places: usize,
    /// By half of them by no more than this.
    pub median_mm: f64,
    /// By nine of ten by no more than this; beside walls the grid knows no place better than half a cell.
    pub ninetieth_mm: f64,
}

/// Residual stock of balls on `mesh`, which opens along +Z, at places spread evenly over the regions of a grid: by the
/// grid and by the exact search. Only places count where a ball without a limit of its reach leaves least; none if
/// there are none.
///
/// # Errors
/// [`Cancelled`].
pub fn ball_agreement(
    mesh: &Mesh,
    library: &CutterLibrary,
    (field, closing): (&HeightField, &Closing),
    regions: &[FieldRegion],
    cancel: &Cancel,
) -> Result<Option<BallAgreement>, Cancelled> {
    let is_ball = |k: usize| library.cutter[k].kind() == CutterKind::Ball && library.cutter[k].reach_mm.is_none();
    let cells = regions.iter().flat_map(|r| &r.cells).map(|cell| *cell as usize);
    let own = cells.filter_map(|cell| closing.nearest(cell).filter(|k| is_ball(*k)).map(|k| (cell, k)));
    let count = own.clone().count();
    let looked_at: Vec<(usize, usize)> = own.step_by(count.div_ceil(PLACES).max(1)).collect();
    let mut cutters: Vec<usize> = looked_at.iter().map(|(_, k)| *k).collect();
    cutters.sort_unstable();
    cutters.dedup();
    let ball = |k: &usize| BallReach::new(mesh, library.cutter[*k].radius(), cancel);
    let balls: Vec<BallReach> = cutters.iter().map(ball).collect::<Result<_, _>>()?;
    let difference = |&(cell, k): &(usize, usize)| -> Result<Option<f64>, Cancelled> {
        cancel.check()?;
        let ball = cutters.iter().position(|c| *c == k).map(|i| &balls[i]);
        Ok(field.height(cell).zip(ball).map(|(low, ball)| {
            let exact = ball.lowest(field.center(cell)).height.max(low);
            (low + closing.residue(field, cell) - exact).abs()
        }))
    };
    let differences: Vec<Option<f64>> = looked_at.par_iter().map(difference).collect::<Result<_, _>>()?;
    let mut differences: Vec<f64> = differences.into_iter().flatten().collect();
    differences.sort_by(f64::total_cmp);
    let share = |tenths: usize| differences.get((differences.len() * tenths / 10).min(differences.len() - 1)).copied();
    if differences.is_empty() {
        return Ok(None);
    }
    let [median_mm, ninetieth_mm] = [share(5), share(9)].map(Option::unwrap_or_default);
    Ok(Some(BallAgreement { places: differences.len(), median_mm, ninetieth_mm }))
}
