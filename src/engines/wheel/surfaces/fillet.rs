//! Fillets between blades and end walls, by how high above the wall a facet lies and how it faces.

use super::{Beside, FACES_WALL, ON_WALL};

/// Facets that face the wall by these cosines tell the radius.
const FACING: [f64; 2] = [0.1, 0.75];
/// Facets next to the wall that face it by less than this cosine are taken for a fillet's.
const NEXT_TO_WALL: f64 = 0.97;
/// Radii of fillets as shares of the height of the passage.
const RADII: [f64; 2] = [0.002, 0.5];
/// Cells of the radii's histogram, which are equal steps of their logarithm.
const CELLS: usize = 120;
/// A radius is one where its cell holds so many times as much as the middle one.
const STANDS_OUT: f64 = 6.0;
/// A fillet turns from the wall to the blade: more of its area than this share faces the wall by less, and by more, than
/// the middle of [`FACING`], as a leaning blade beside a wall does not.
const TURNS: f64 = 0.1;
/// A fillet goes on to the wall: what faces it by more than [`FACING`] has the weight of this share of what tells the radius,
/// at least. By the angles that both take of an even fillet that is 0.6; what leans over the wall has none.
const TO_WALL: f64 = 0.4;
/// How far a fillet may lie off the rolled ball, as a share of its radius.
const OFF_BALL: f64 = 0.04;
/// Facets of fillets are no wider than this share of the radius.
const WIDEST: f64 = 0.8;
/// Height of a facet next to the wall from which on it is the fillet's first, as a share of the radius.
const FIRST: f64 = 0.008;

/// The radius of the fillet that a facet would lie in (mm): its corners lie between `off` above the wall, and it faces
/// the wall with this cosine. None where it lies in no fillet of a passage of this height.
pub(super) fn estimate(off: [f64; 2], facing: f64, height: f64) -> Option<f64> {
    let middle = 0.5 * (off[0] + off[1]);
    if !(FACING[0]..NEXT_TO_WALL).contains(&facing) || off[0] < -ON_WALL || middle <= 0.0 {
        return None;
    }
    // The facet is a chord of the circle: its middle lies within.
    let sine = 1.0 - facing * facing;
    let half_chord_squared = (off[1] - off[0]).powi(2) / (4.0 * sine);
    let root = middle * middle - sine * (middle * middle + facing * facing * half_chord_squared);
    let radius = (middle + root.max(0.0).sqrt()) / sine;
    (RADII[0]..RADII[1]).contains(&(radius / height)).then_some(radius)
}

/// A radius (mm) that a facet tells, with the area of the facet (mm²) and the cosine by which it faces the wall.
#[derive(Debug, Clone, Copy)]
pub(super) struct Estimate {
    pub radius: f64,
    pub area: f64,
    pub facing: f64,
}

impl Estimate {
    /// Of a leaned blade every height has the same say.
    fn weight(&self) -> f64 {
        self.area / self.radius
    }
}

/// The radius (mm) that stands out among estimates in a passage of this height.
pub(super) fn radius(estimates: &[Estimate], height: f64) -> Option<f64> {
    let step = (RADII[1] / RADII[0]).ln() / CELLS as f64;
    let mut cells = [0.0; CELLS];
    for estimate in estimates.iter().filter(|e| e.facing < FACING[1]) {
        let cell = ((estimate.radius / (RADII[0] * height)).ln() / step).max(0.0) as usize;
        cells[cell.min(CELLS - 1)] += estimate.weight();
    }
    let smooth: Vec<f64> = (0..CELLS).map(|i| cells[i.saturating_sub(1)..(i + 2).min(CELLS)].iter().sum()).collect();
    let best = (0..CELLS).max_by(|a, b| smooth[*a].total_cmp(&smooth[*b]))?;
    let mut sorted = smooth.clone();
    sorted.sort_by(f64::total_cmp);
    let total: f64 = cells.iter().sum();
    if smooth[best] <= STANDS_OUT * sorted[CELLS / 2] || smooth[best] < 0.2 * total {
        return None;
    }
    let of = |i: f64| RADII[0] * height * (step * i).exp();
    let [from, to] = [of(best as f64 - 1.0), of(best as f64 + 2.0)];
    let near = || estimates.iter().filter(|e| e.facing < FACING[1] && (from..to).contains(&e.radius));
    let weight: f64 = near().map(Estimate::weight).sum();
    let facing: f64 = near().filter(|e| e.facing > 0.5 * (FACING[0] + FACING[1])).map(Estimate::weight).sum();
    let goes_on = estimates.iter().filter(|e| e.facing >= FACING[1] && (0.7 * from..1.4 * to).contains(&e.radius));
    let to_wall: f64 = goes_on.map(Estimate::weight).sum();
    if facing < TURNS * weight || facing > (1.0 - TURNS) * weight || to_wall < TO_WALL * weight {
        return None;
    }
    let mut near: Vec<(f64, f64)> = near().map(|e| (e.radius, e.weight())).collect();
    near.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    let mut sum = 0.0;
    near.into_iter()
        .find(|(_, share)| {
            sum += share;
            sum >= 0.5 * weight
        })
        .map(|(radius, _)| radius)
}

/// Whether a facet belongs to the wall itself, beside fillets of `radius` (mm). Along a hollow wall the corners of coarse
/// facets, wider than any of a fillet, lie below the wall that was measured, which is that of the chords.
pub(super) fn is_wall(beside: &Beside, radius: Option<f64>) -> bool {
    let most = radius.map_or(ON_WALL, |radius| (FIRST * radius).min(ON_WALL)) + beside.chord;
    let is_above =
        beside.off[0] > -ON_WALL - beside.chord || radius.is_none_or(|radius| beside.width > WIDEST * radius);
    beside.facing > FACES_WALL && beside.off[1] < most && is_above
}

/// Whether a facet lies in a fillet of `radius` (mm), rolled along the wall.
pub(super) fn holds(beside: &Beside, radius: f64) -> bool {
    let [least, most] = beside.off;
    let middle = 0.5 * (least + most);
    middle <= radius * (1.0 - beside.facing + OFF_BALL) && most <= radius * (1.0 - beside.facing.min(0.0) + OFF_BALL)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::FRAC_PI_2;

    #[test]
    fn what_leans_over_the_wall_like_a_fillet_and_does_not_go_on_to_it_is_none() {
        const FACETS: usize = 12;
        let at = |i: usize| FRAC_PI_2 * i as f64 / FACETS as f64;
        let of_facet = |i: usize| {
            let off = [i, i + 1].map(|i| 1.0 - at(i).cos());
            let facing = (0.5 * (at(i) + at(i + 1))).cos();
            Some(Estimate { radius: estimate(off, facing, 10.0)?, area: 1.0, facing })
        };
        let whole: Vec<Estimate> = (0..FACETS).filter_map(of_facet).collect();
        let found = radius(&whole, 10.0).unwrap();
        assert!((found - 1.0).abs() < 1e-9, "{found}");
        let upper: Vec<Estimate> = whole.into_iter().filter(|e| e.facing < FACING[1]).collect();
        assert_eq!(radius(&upper, 10.0), None);
    }
}
