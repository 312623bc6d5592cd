//! Number of repetitions of the walls about an axis, with its accuracy; and the best axis for them.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use serde::Serialize;

use super::super::error::NotChannels;
use super::slices::{CELLS, Gap, Slices, cylindrical_components};
use geometry::frame::{Cylindrical, wrap_angle};
use task::{Cancel, Cancelled};

/// Most kinds of blades: a main blade and up to three splitters.
pub(crate) const MOST_KINDS: usize = 4;
/// A kind of blades stands around the axis at least so many times.
const LEAST_REPEATS: usize = 3;
/// Share of the walls that repeat where the number of kinds is right.
pub(super) const MOST_REPEAT: f64 = 0.9;

/// Blades around the axis.
#[derive(Debug, Clone, Copy)]
pub(super) struct Blades {
    /// Number of blades, splitters included.
    pub count: usize,
    /// Number of blades after which they repeat.
    pub kinds: usize,
    /// Whether some may be missing, as where their count was given.
    pub may_lack: bool,
}

/// Repetition of the walls around the axis.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Repetition {
    /// Number of blades, splitters included.
    pub blades: usize,
    /// Number of blades after which they repeat: 1 where all are alike, 2 with a splitter between any two main blades.
    /// There are as many kinds of channels.
    pub kinds: usize,
    /// A wall repeats where it lies within this distance of the mean wall of its kind (mm).
    pub tolerance_mm: f64,
    /// Share of the compared wall points that repeat, 0 to 1.
    pub matched: f64,
    /// Root mean square distance of the walls from the mean ones (mm).
    pub rms_mm: f64,
    /// Greatest such distance (mm).
    pub greatest_mm: f64,
    /// Number of wall points compared.
    pub points: usize,
}

/// A connected part of the meridional plane in which every circle meets the same number of even gaps.
pub(super) struct Region {
    /// Number of gaps around.
    pub count: usize,
    /// Cells of the region.
    cells: Vec<[usize; 2]>,
    /// Reason why its gaps are no channels between blades, if they are not.
    pub objection: Option<NotChannels>,
}

/// The regions of the meridional plane where walls repeat, the one with the greatest wall area first.
pub(super) fn regions(slices: &Slices, wanted: Option<usize>, cancel: &Cancel) -> Result<Vec<Region>, Cancelled> {
    let columns: Vec<Vec<usize>> = (0..CELLS[0])
        .into_par_iter()
        .map(|ix| {
            let count = |ir| {
                cancel.check()?;
                let at = slices.cell_middle(ix, ir);
                let gaps = slices.gaps(at.x, at.y);
                Ok(match wanted {
                    Some(count) => {
                        // Blades of an unequal pitch are as many.
                        if gaps.len() == count || slots(&gaps, count).is_some() { count } else { 0 }
                    }
                    None => even_count(&gaps).filter(|&n| n >= 3).unwrap_or(0),
                })
            };
            (0..CELLS[1]).map(count).collect()
        })
        .collect::<Result<_, Cancelled>>()?;
    let mut regions = without_holes(connected(columns), slices);
    regions.retain(Region::is_more_than_a_line);
    regions.par_iter_mut().for_each(|region| region.objection = region.objection(slices));
    regions.sort_by_key(|r| std::cmp::Reverse(r.count * r.cells.len()));
    Ok(regions)
}

/// The number of gaps, if they or the blades between them are evenly spaced: beside thick blades and thin ones the gaps
/// are not.
fn even_count(gaps: &[Gap]) -> Option<usize> {
    let count = gaps.len();
    let pitch = TAU / count as f64;
    let is_even = |middle: &dyn Fn(usize) -> f64| {
        let misses = (0..count).map(|k| middle(k) - middle(0) - k as f64 * pitch);
        let (least, most) = misses.fold((0.0f64, 0.0f64), |(l, m), d| (l.min(d), m.max(d)));
        most - least < 0.25 * pitch
    };
    let blade = |k: usize| {
        let turns = if k == 0 { -TAU } else { 0.0 };
        0.5 * (gaps[(k + count - 1) % count].high.theta + turns + gaps[k].low.theta)
    };
    (count > 0 && (is_even(&|k| gaps[k].middle()) || is_even(&blade))).then_some(count)
}

/// Share of the blades that must stand where their count is given.
const MOST_STAND: f64 = 0.6;

/// The gaps between neighbouring ones of `count` evenly spaced blades, with their numbers around; none if the gaps are
/// others. Where a blade is missing there is a wider one, which is left out.
fn slots(gaps: &[Gap], count: usize) -> Option<Vec<(usize, Gap)>> {
    let pitch = TAU / count as f64;
    let narrow: Vec<Gap> = gaps.iter().filter(|gap| gap.width() < pitch || gaps.len() == count).copied().collect();
    let first = narrow.first()?.middle();
    let misses: Vec<f64> = narrow.iter().map(|g| (g.middle() - first) / pitch).map(|m| m - m.round()).collect();
    let (least, most) = misses.iter().fold((0.0f64, 0.0f64), |(l, m), d| (l.min(*d), m.max(*d)));
    let middle = 0.5 * (least + most);
    let number = |gap: &Gap| ((gap.middle() - first) / pitch - middle).round().rem_euclid(count as f64) as usize;
    let mut slots: Vec<(usize, Gap)> = narrow.iter().map(|gap| (number(gap), *gap)).collect();
    slots.dedup_by_key(|slot| slot.0);
    let is_even = most - least < 0.25 && slots.len() == narrow.len();
    (is_even && slots.len() as f64 >= MOST_STAND * count as f64).then_some(slots)
}

/// Splits the grid of counts into connected parts of equal count other than 0.
fn connected(mut counts: Vec<Vec<usize>>) -> Vec<Region> {
    let mut regions = Vec::new();
    for ix in 0..CELLS[0] {
        for ir in 0..CELLS[1] {
            let count = std::mem::take(&mut counts[ix][ir]);
            if count == 0 {
                continue;
            }
            let mut cells = vec![[ix, ir]];
            let mut done = 0;
            while let Some(&[cx, cr]) = cells.get(done) {
                done += 1;
                let around = [(cx.wrapping_sub(1), cr), (cx + 1, cr), (cx, cr.wrapping_sub(1)), (cx, cr + 1)];
                for (nx, nr) in around {
                    if let Some(cell) =
                        counts.get_mut(nx).and_then(|column| column.get_mut(nr)).filter(|c| **c == count)
                    {
                        *cell = 0;
                        cells.push([nx, nr]);
                    }
                }
            }
            cells.sort_unstable();
            regions.push(Region { count, cells, objection: None });
        }
    }
    regions
}

/// The regions, joined across circles that also meet holes in the blades: among the gaps of these are round holes, and the
/// others are as many as on the circles just within and just outside of the holes. Such circles are no part of a region that
/// goes on beside them.
fn without_holes(mut regions: Vec<Region>, slices: &Slices) -> Vec<Region> {
    /// Distance of these circles from a hole, as a share of its height. Beside passages that are round between fillets there
    /// is hub or shroud.
    const BESIDE: f64 = 0.1;
    let mut pierced: Vec<[usize; 2]> = Vec::new();
    for region in &mut regions {
        let at = region.middle(slices);
        let (holes, gaps): (Vec<Gap>, Vec<Gap>) =
            slices.gaps(at.x, at.y).into_iter().partition(|gap| is_round_hole(slices, at, gap));
        let Some(count) = even_count(&gaps).filter(|&n| n >= 3 && !holes.is_empty()) else { continue };
        let goes_on = |r: f64| even_count(&slices.gaps(at.x, r)) == Some(count);
        let is_in_blade = |hole: &Gap| {
            closed_between(slices, at, hole).is_some_and(|[inner, outer]| {
                let off = BESIDE * (outer - inner);
                goes_on(inner - off) && goes_on(outer + off)
            })
        };
        if holes.iter().all(is_in_blade) {
            region.count = count;
            pierced.extend(&region.cells);
        }
    }
    if pierced.is_empty() {
        return regions;
    }
    let mut counts = vec![vec![0; CELLS[1]]; CELLS[0]];
    let counted = regions.iter().flat_map(|region| region.cells.iter().map(|cell| (*cell, region.count)));
    counted.for_each(|([x, r], count)| counts[x][r] = count);
    pierced.sort_unstable();
    let mut joined = connected(counts);
    for region in &mut joined {
        let whole: Vec<_> = region.cells.iter().filter(|cell| pierced.binary_search(cell).is_err()).copied().collect();
        if !whole.is_empty() {
            region.cells = whole;
        }
    }
    joined
}

impl Region {
    fn holds(&self, cell: [usize; 2]) -> bool {
        self.cells.binary_search(&cell).is_ok()
    }

    /// Whether it is wider than one cell both ways; circles that graze the facets of a coarse cylinder are not.
    fn is_more_than_a_line(&self) -> bool {
        self.cells.iter().any(|&[x, r]| [[x + 1, r], [x, r + 1], [x + 1, r + 1]].iter().all(|&c| self.holds(c)))
    }

    /// Whether the region is more than a seam beside the other one, as there is where waves of an end wall stand between
    /// its blades.
    pub fn is_good_part_of(&self, other: &Self) -> bool {
        const LEAST: f64 = 0.1;
        self.cells.len() as f64 > LEAST * other.cells.len() as f64
    }

    /// Whether the other region begins within some cells of this one: where a round edge of a splitter becomes thin, gaps
    /// beside it are not even.
    fn touches(&self, other: &Self) -> bool {
        const BESIDE: usize = 12;
        let around = |at: usize| at.saturating_sub(BESIDE)..=at + BESIDE;
        let is_near = |&[x, r]: &[usize; 2]| around(x).any(|x| around(r).any(|r| self.holds([x, r])));
        other.cells.iter().any(is_near)
    }

    /// Regions of the `others` into which only some of this region's blades go on: the rest have ended there, as splitters
    /// do, one kind after the other.
    pub fn goes_on_into<'a>(&self, others: &'a [Self]) -> Vec<&'a Self> {
        let mut into: Vec<&Self> = Vec::new();
        let goes_on =
            |from: &Self, other: &Self| other.count < from.count && other.objection.is_none() && from.touches(other);
        let mut done = 0;
        loop {
            let from = if done == 0 { self } else { into[done - 1] };
            let is_new = |other: &&Self| !into.iter().any(|known| std::ptr::eq(*known, *other));
            let more: Vec<&Self> = others.iter().filter(is_new).filter(|other| goes_on(from, other)).collect();
            into.extend(more);
            if done == into.len() {
                return into;
            }
            done += 1;
        }
    }

    /// Number of kinds of blades that each stand in another part of the passage: of this region's blades only one in so
    /// many [goes on into](Self::goes_on_into) one of the `others`.
    pub fn least_kinds(&self, others: &[Self]) -> usize {
        let of = |other: &Self| kinds(self.count).find(|kinds| kinds * other.count == self.count);
        self.goes_on_into(others).into_iter().filter_map(of).max().unwrap_or(1)
    }

    /// Whether this may be another row of blades than those of `chosen`: a good part as large, with a circle between them
    /// that meets no blade.
    pub fn is_other_row_than(&self, chosen: &Self, slices: &Slices) -> bool {
        const LEAST: f64 = 0.25;
        let walls = |region: &Self| (region.count * region.cells.len()) as f64;
        walls(self) > LEAST * walls(chosen) && self.is_apart(chosen, slices)
    }

    /// Whether a circle between the nearest cells of two regions meets no blade: it is free all around, or solid.
    fn is_apart(&self, other: &Self, slices: &Slices) -> bool {
        let at = |&[x, r]: &[usize; 2]| DVec2::new(x as f64, r as f64);
        let nearest = |p: DVec2| {
            let to = other.cells.iter().map(at);
            to.min_by(|a, b| a.distance_squared(p).total_cmp(&b.distance_squared(p))).map(|q| (p, q))
        };
        let pairs = self.cells.iter().map(at).filter_map(nearest);
        let apart = |(p, q): &(DVec2, DVec2)| p.distance_squared(*q);
        let Some((p, q)) = pairs.min_by(|a, b| apart(a).total_cmp(&apart(b))) else { return false };
        let steps = (2.0 * (q - p).abs().max_element()).ceil().max(1.0) as usize;
        (1..steps).any(|i| {
            let cell = p.lerp(q, i as f64 / steps as f64);
            let at = slices.cell_middle(0, 0) + cell * slices.cell_size();
            slices.gaps(at.x, at.y).is_empty()
        })
    }

    /// Cells whose neighbours all belong to the region, or all of them if there are none.
    fn inner_cells(&self) -> Vec<[usize; 2]> {
        let inner = |&&[x, r]: &&[usize; 2]| {
            x > 0 && r > 0 && [[x - 1, r], [x + 1, r], [x, r - 1], [x, r + 1]].iter().all(|&c| self.holds(c))
        };
        let cells: Vec<_> = self.cells.iter().filter(inner).copied().collect();
        if cells.is_empty() { self.cells.clone() } else { cells }
    }

    /// Distance of a place (x, r) from the region, in cells.
    pub fn cells_from(&self, slices: &Slices, place: DVec2) -> f64 {
        let size = slices.cell_size();
        let off = |&[x, r]: &[usize; 2]| ((slices.cell_middle(x, r) - place) / size).abs().max_element();
        (self.cells.iter().map(off).fold(f64::INFINITY, f64::min) - 0.5).max(0.0)
    }

    /// The (x, r) of at most `most` circles well inside, evenly picked.
    pub fn circles(&self, slices: &Slices, most: usize) -> Vec<DVec2> {
        let cells = self.inner_cells();
        let step = cells.len().div_ceil(most).max(1);
        cells.iter().step_by(step).map(|&[x, r]| slices.cell_middle(x, r)).collect()
    }

    /// The (x, r) of the circle well inside that is nearest to the middle of the region.
    pub fn middle(&self, slices: &Slices) -> DVec2 {
        let n = self.cells.len() as f64;
        let mean = self.cells.iter().map(|&[x, r]| DVec2::new(x as f64, r as f64)).sum::<DVec2>() / n;
        let far = |&[x, r]: &[usize; 2]| (DVec2::new(x as f64, r as f64) - mean).length_squared();
        let cells = self.inner_cells();
        let cell = cells.iter().min_by(|a, b| far(a).total_cmp(&far(b))).copied().unwrap_or([0, 0]);
        slices.cell_middle(cell[0], cell[1])
    }

    fn objection(&self, slices: &Slices) -> Option<NotChannels> {
        let facing: f64 = self.circles(slices, 60).iter().map(|c| facing(slices, c)).sum();
        if facing <= 0.2 * self.circles(slices, 60).len() as f64 {
            return Some(NotChannels::Flats);
        }
        let middle = self.middle(slices);
        // Where splitters have ended in part, the others are wider than any hole.
        let gaps = slices.gaps(middle.x, middle.y);
        let narrowest = gaps.iter().min_by(|a, b| a.width().total_cmp(&b.width()));
        narrowest.is_some_and(|gap| is_round_hole(slices, middle, gap)).then_some(NotChannels::RoundHoles)
    }
}

/// How squarely the two sides of the gaps of a circle face each other: 1 for parallel walls, negative where
/// both belong to one bulging surface.
fn facing(slices: &Slices, circle: &DVec2) -> f64 {
    let gaps = slices.gaps(circle.x, circle.y);
    let of = |g: &Gap| {
        let normal = |triangle, theta| cylindrical_components(slices.normal(triangle), theta);
        -normal(g.low.triangle, g.low.theta).dot(normal(g.high.triangle, g.high.theta))
    };
    gaps.iter().take(8).map(of).sum::<f64>() / gaps.len().clamp(1, 8) as f64
}

/// The radii between which a gap of the circle through the given (x, r) is closed, half way around it; none where it is open.
fn closed_between(slices: &Slices, at: DVec2, gap: &Gap) -> Option<[f64; 2]> {
    let ray = slices.ray(at.x, gap.middle());
    let (inner, outer) = (ray.iter().rfind(|c| c.r < at.y)?, ray.iter().find(|c| c.r > at.y)?);
    Some([inner.r, outer.r])
}

/// Whether a gap of the circle through the given (x, r) is about as wide as high, closed above and below and much narrower
/// there than between.
fn is_round_hole(slices: &Slices, at: DVec2, gap: &Gap) -> bool {
    /// Width over height, of a hole aslant too.
    const AS_WIDE: std::ops::Range<f64> = 0.5..2.0;
    let Some([inner, outer]) = closed_between(slices, at, gap) else { return false };
    let width = |share: f64| {
        let r = inner + share * (outer - inner);
        slices.gap_near(at.x, r, gap).map_or(0.0, |g| g.width() * r)
    };
    let widest = width(0.5);
    AS_WIDE.contains(&(widest / (outer - inner))) && width(0.1).max(width(0.9)) < 0.75 * widest
}

/// A wall point against the same point of the mean blade.
struct Miss {
    /// Distance along the wall's normal (mm).
    distance: f64,
    /// Derivatives of the distance by moving the part along y and z (mm/mm) and by turning it about y and z (mm/rad).
    answers: [f64; 4],
}

/// Compares the walls around each of `circles` (x, r) with the mean walls of their kind; turns are taken about the
/// point of the axis at `x_mid`.
fn misses(slices: &Slices, circles: &[DVec2], blades: Blades, x_mid: f64) -> Vec<Miss> {
    let Blades { count, kinds, may_lack } = blades;
    let pitch = TAU / count as f64;
    let of_circle = |circle: &DVec2| {
        let gaps = slices.gaps(circle.x, circle.y);
        let mut misses = Vec::new();
        let whole = (gaps.len() == count).then(|| gaps.iter().copied().enumerate().collect());
        let Some(slots) = whole.or_else(|| slots(&gaps, count).filter(|_| may_lack)) else { return misses };
        for side in [|g: &Gap| g.low, |g: &Gap| g.high] {
            let walls: Vec<_> = slots.iter().map(|(k, gap)| (*k, side(gap))).collect();
            let (first, start) = (walls[0].0, walls[0].1.theta);
            let turn = |k: usize| (k as f64 - first as f64) * pitch;
            let off: Vec<f64> = walls.iter().map(|(k, w)| wrap_angle(w.theta - start - turn(*k))).collect();
            let of_kind = |kind: usize| walls.iter().zip(&off).filter(move |((k, _), _)| k % kinds == kind);
            let means: Vec<f64> =
                (0..kinds).map(|kind| median(&of_kind(kind).map(|w| *w.1).collect::<Vec<_>>())).collect();
            for ((k, wall), off) in walls.iter().zip(&off) {
                let mean = means[k % kinds];
                let p = Cylindrical { x: circle.x - x_mid, r: circle.y, theta: wall.theta }.point();
                let n = slices.normal(wall.triangle);
                let around = cylindrical_components(n, wall.theta).z;
                let moment = p.cross(n);
                let answers = [n.y, n.z, moment.y, moment.z];
                misses.push(Miss { distance: (off - mean) * circle.y * around, answers });
            }
        }
        misses
    };
    circles.par_iter().map(of_circle).collect::<Vec<_>>().into_iter().flatten().collect()
}

/// The middle value; 0 of nothing.
fn median(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let n = sorted.len();
    if n == 0 { 0.0 } else { 0.5 * (sorted[(n - 1) / 2] + sorted[n / 2]) }
}

/// The numbers of kinds that `count` blades may be of, the fewest first.
pub(super) fn kinds(count: usize) -> impl Iterator<Item = usize> {
    (1..=MOST_KINDS)
        .filter(move |kinds| count.is_multiple_of(*kinds) && (*kinds == 1 || count / kinds >= LEAST_REPEATS))
}

/// How exactly the walls of `blades` repeat about X of the given slices, to within `tolerance` (mm).
pub(super) fn repetition(slices: &Slices, circles: &[DVec2], blades: Blades, tolerance: f64) -> Repetition {
    let misses = misses(slices, circles, blades, 0.0);
    let points = misses.len();
    let share = 1.0 / points.max(1) as f64;
    Repetition {
        blades: blades.count,
        kinds: blades.kinds,
        tolerance_mm: tolerance,
        matched: misses.iter().filter(|m| m.distance.abs() <= tolerance).count() as f64 * share,
        rms_mm: (misses.iter().map(|m| m.distance.powi(2)).sum::<f64>() * share).sqrt(),
        greatest_mm: misses.iter().map(|m| m.distance.abs()).fold(0.0, f64::max),
        points,
    }
}

/// Where the axis about which the walls repeat lies, seen from X of the given slices: the point at `x_mid`
/// moved in y and z, and the y and z components of its direction. One Gauss-Newton step, in which walls that
/// miss by much more than most have little say. With `keep_direction` only the point moves.
pub(super) fn better_axis(
    slices: &Slices,
    circles: &[DVec2],
    blades: Blades,
    x_mid: f64,
    keep_direction: bool,
) -> Option<(DVec3, DVec3)> {
    let misses = misses(slices, circles, blades, x_mid);
    let unknowns = if keep_direction { 2 } else { 4 };
    let typical = 1.5 * median(&misses.iter().map(|m| m.distance.abs()).collect::<Vec<_>>());
    let radius = circles.iter().map(|c| c.y).fold(0.0, f64::max);
    let scale = [1.0, 1.0, 1.0 / radius, 1.0 / radius];
    let mut normal = DMatrix::<f64>::zeros(unknowns, unknowns);
    let mut right = DVector::<f64>::zeros(unknowns);
    for miss in &misses {
        let weight = (1.0 + (miss.distance / (3.0 * typical + f64::MIN_POSITIVE)).powi(2)).powi(-2);
        for i in 0..unknowns {
            right[i] += weight * miss.answers[i] * scale[i] * miss.distance;
            for j in 0..unknowns {
                normal[(i, j)] += weight * miss.answers[i] * scale[i] * miss.answers[j] * scale[j];
            }
        }
    }
    let solution = normal.cholesky()?.solve(&right);
    let get = |i: usize| solution.get(i).map_or(0.0, |v| v * scale[i]);
    // The part is turned by w = (0, wy, wz): its axis runs along X + w x X.
    Some((DVec3::new(x_mid, get(0), get(1)), DVec3::new(1.0, get(3), -get(2)).normalize()))
}
