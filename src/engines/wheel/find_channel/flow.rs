//! The direction of a passage: which part of the meridional plane blades bound on both sides, and the lines across it.
//!
//! On every circle about the axis the channel's gap either lies between two blades or not, which divides the meridional
//! plane (x, r). Going once round the bladed part, what lies beside it is solid twice (hub and shroud) and open twice
//! (inlet and outlet), whatever its direction.

use std::collections::HashMap;

use glam::DVec2;
use nalgebra::DMatrix;

use super::super::channel::Surface;
use super::super::error::BliskError;
use super::super::frame::lattice::{Lattice, MOST_POINTS, around};
use super::super::frame::slices::Gap;
use super::meridian::{Place, Tracer};

/// Lines from hub to shroud or tips (x, r) along a passage, found to about the distance of the lattice's points (mm).
pub(super) struct Lines {
    pub lines: Vec<[DVec2; 2]>,
    /// Distance of the lattice's points (mm).
    pub step: f64,
    /// Whether the outer ends are those of a wall; if not, of the blade tips.
    pub shrouded: bool,
    /// Share of the whole passage that is steep, also where splitters have ended.
    pub steep: f64,
    /// The part of the blades that the shroud covers, where it seems to end before they do.
    covered: Option<Covered>,
}

/// Part of the blades' ends that a hub or shroud covers.
#[derive(Clone, Copy)]
struct Covered {
    /// Share of their length.
    share: f64,
    /// A place on what covers them (x, r).
    at: DVec2,
}

/// Least narrowing of the gap from one point to the next at a hole, both sides together (share of its width).
const HOLE: f64 = 0.3;
/// Least narrowing at a hole on each side (share of the gap's width).
const HOLE_SIDE: f64 = 0.05;
/// Least narrowing at a hole that cuts into a blade, where one side does not narrow (share of the gap's width): splitters
/// narrow a gap by less.
const HOLE_AT_BLADE: f64 = 0.8;
/// Shorter runs of the outline are rounding (points).
const LEAST_RUN: usize = 4;
/// Points of a run that tell its direction.
const DIRECTION: usize = 8;
/// The blades' edges meet their tips in corners sharper than this (rad).
const LEAST_CORNER: f64 = 0.2;
/// Tips that go on from the end of a shroud turn from its direction by an angle with a cosine above this.
const GOES_ON: f64 = 0.7;
/// Such tips end in a corner sharper than this (rad).
const BARE_CORNER: f64 = 0.8;
/// Least share of the length of shroud and such tips that the tips have.
const LEAST_BARE: f64 = 0.2;
/// Shares of the outline, as divisors, over which corners are seen from afar and from near.
const CORNERS: [usize; 2] = [8, 30];
/// Pieces that the lines divide the passage into.
const PIECES: usize = 64;
/// Degree of the polynomials that smooth hub and shroud.
const DEGREE: usize = 6;
/// Steps of the lattice by which an outline may lie off its polynomial where no hole bends it.
const MOST_BENT: f64 = 4.0;
/// Curves whose mean radii differ by less than this share of the height lie side by side along the axis.
const SAME_RADIUS: f64 = 0.2;

/// A passage is axial where no more than this share of its length is steeper than 45 degrees, and radial where no more
/// is flatter.
pub(super) const MOST_STEEP: f64 = 0.1;

/// Slope (radius over x) from which on a passage is not axial: 45 degrees.
pub(super) const STEEP: f64 = 1.0;
/// Slope from which on a passage is looked for across its direction where none is found along the axis: 25 degrees.
pub(super) const LEANING: f64 = 0.47;

/// A piece of the outline of the bladed part, between two neighbouring points of the lattice.
#[derive(Clone, Copy)]
struct Piece {
    at: DVec2,
    is_solid: bool,
}

/// The lines across the passage through `start` between blades of so many kinds; none where it runs along the axis, at
/// most as steep as `slope` (radius over x), or where the blades do not reach a hub from end to end, so that nothing is
/// known of its direction.
pub(super) fn lines(tracer: &Tracer, start: Place, kinds: usize, slope: f64) -> Result<Option<Lines>, BliskError> {
    // Where both are given or one is drawn there is nothing to be found.
    let is_drawn = [Surface::Hub, Surface::Shroud].into_iter().any(|surface| tracer.is_drawn(surface));
    let is_known = is_drawn || tracer.by_hand.ends.iter().all(|points| !points.is_empty());
    let found = if is_known { None } else { lines_found(tracer, start, kinds, slope)? };
    tracer.lines_by_hand(start, found, slope)
}

fn lines_found(tracer: &Tracer, start: Place, kinds: usize, slope: f64) -> Result<Option<Lines>, BliskError> {
    let beside = |x: f64, r: f64, near: &Gap| tracer.bladed_gap(x, r, near);
    let mut found = lines_where(tracer, start, (&beside, slope))?;
    if kinds > 1
        && let Some(lines) = &mut found
    {
        // A splitter may end before the passage turns, which goes on between the main blades.
        let most = (kinds as f64 + 0.5) * tracer.pitch;
        let between = |x: f64, r: f64, near: &Gap| tracer.slices.gap_near(x, r, near).filter(|g| g.width() < most);
        lines.steep = lines_where(tracer, start, (&between, slope))?.map_or(lines.steep, |whole| whole.steep);
    }
    Ok(found.filter(|lines| lines.steep > MOST_STEEP))
}

impl Lines {
    /// Lines that were found to about `step` (mm), whose passage is steep where it is steeper than `slope`.
    pub fn new(lines: Vec<[DVec2; 2]>, (step, slope): (f64, f64), shrouded: bool) -> Self {
        let middle: Vec<DVec2> = lines.iter().map(|[hub, shroud]| 0.5 * (*hub + *shroud)).collect();
        Self { steep: steep_share(&middle, slope), lines, step, shrouded, covered: None }
    }

    /// The reason why the passage along these lines was not found, which `error` may hide.
    pub fn reason(&self, error: BliskError) -> BliskError {
        match (error, self.covered) {
            (BliskError::LostWall { .. } | BliskError::Unbounded { .. }, Some(Covered { share, at })) => {
                BliskError::PartShroud { share, x: at.x, r: at.y, joined: true }
            }
            (error, _) => error,
        }
    }
}

/// The gap at (x, r) that continues another, where it is one of the channel.
type GapAt<'a> = dyn Fn(f64, f64, &Gap) -> Option<Gap> + 'a;

/// The lines across the part of the meridional plane in which there is a gap; past holes in hub and shroud where these hide
/// them or bend them.
fn lines_where(tracer: &Tracer, start: Place, (gap_at, slope): (&GapAt, f64)) -> Result<Option<Lines>, BliskError> {
    let mut bent = None;
    for past_holes in [false, true] {
        let next = |at: DVec2, near: &Gap| gap_at(at.x, at.y, near).filter(|gap| !past_holes || !is_in_hole(gap, near));
        let (lattice, points) =
            Lattice::filled(tracer.slices, (DVec2::new(start.x, start.r), start.gap), next, tracer.cancel)?;
        if points.len() >= MOST_POINTS {
            continue;
        }
        let Some((walls, covered)) = curves(&outline(&points, tracer, &lattice), past_holes) else { continue };
        let [Some(hub), Some(outer)] = walls.each_ref().map(|wall| smooth(&wall.points)) else { continue };
        let shrouded = walls[1].is_solid;
        let off = hub.1.max(outer.1);
        let lines = Lines::new(ordered(hub.0, outer.0, shrouded), (lattice.step, slope), shrouded);
        let lines = Lines { covered, ..lines };
        // A blind hole does not open the outline, it bends it.
        if off <= MOST_BENT * lattice.step {
            return Ok(Some(lines));
        }
        bent = bent.or(Some(lines));
    }
    Ok(bent)
}

/// Share of the length of a curve (x, r) that is at least as steep as `slope` (radius over x).
pub(super) fn steep_share(curve: &[DVec2], slope: f64) -> f64 {
    let steps = || curve.windows(2).map(|w| (w[1] - w[0]).abs());
    let length = steps().map(DVec2::length).sum::<f64>();
    steps().filter(|step| step.y >= slope * step.x).map(DVec2::length).sum::<f64>() / length.max(f64::MIN_POSITIVE)
}

/// Whether a gap beside `near` is that of a hole in hub or shroud, which is narrower at once on both sides. Between fillets
/// that meet a gap is too: this is asked only where the outline yields no curves, or curves that bend.
fn is_in_hole(gap: &Gap, near: &Gap) -> bool {
    let narrowed = [gap.low.theta - near.low.theta, near.high.theta - gap.high.theta];
    let [both, width] = [narrowed.iter().sum::<f64>(), near.width()];
    narrowed.iter().all(|side| *side > HOLE_SIDE * width) && both > HOLE * width || both > HOLE_AT_BLADE * width
}

/// The longest outline of the bladed points, anticlockwise.
fn outline(bladed: &HashMap<[i32; 2], Gap>, tracer: &Tracer, lattice: &Lattice) -> Vec<Piece> {
    // Each point stands for the square about it; a piece of the outline runs from corner to corner of the squares, with
    // the bladed square on its left.
    let corners = [[0, 0], [1, 0], [1, 1], [0, 1]];
    let mut pieces: HashMap<[i32; 2], Vec<([i32; 2], Piece)>> = HashMap::new();
    let mut points: Vec<_> = bladed.iter().collect();
    points.sort_by_key(|(point, _)| **point);
    for (&[i, j], gap) in points {
        for (k, next) in around([i, j]).into_iter().enumerate().filter(|(_, next)| !bladed.contains_key(next)) {
            let beside = lattice.place(next.map(f64::from));
            let corner = |k: usize| [i + corners[k % 4][0], j + corners[k % 4][1]];
            let middle = [0.5 * f64::from(i + next[0]), 0.5 * f64::from(j + next[1])];
            let piece =
                Piece { at: lattice.place(middle), is_solid: tracer.slices.is_solid(beside.x, beside.y, gap.middle()) };
            pieces.entry(corner(k)).or_default().push((corner(k + 1), piece));
        }
    }
    let mut longest = Vec::new();
    let mut starts: Vec<_> = pieces.keys().copied().collect();
    starts.sort_unstable();
    for start in starts {
        let (mut at, mut outline) = (start, Vec::new());
        while let Some((next, piece)) = pieces.get_mut(&at).and_then(Vec::pop) {
            outline.push(piece);
            at = next;
        }
        if outline.len() > longest.len() {
            longest = outline;
        }
    }
    longest
}

/// A part of the outline whose pieces are of one kind.
#[derive(Clone)]
struct Run {
    is_solid: bool,
    points: Vec<DVec2>,
}

/// The two curves along a passage, in opposite directions: two solid ones, or a solid one and the tips; none where
/// there are not two, or where a hole in one of them was to be left out and is not. If one of two solid curves covers a part
/// of the blades' ends only, that part comes with them.
fn curves(outline: &[Piece], past_holes: bool) -> Option<([Run; 2], Option<Covered>)> {
    let with_holes = runs(outline)?;
    let runs = without_holes(with_holes.clone());
    if !past_holes && runs.len() < with_holes.len() {
        return None;
    }
    let solid: Vec<&Run> = runs.iter().filter(|run| run.is_solid).collect();
    let (walls, covered) = match (&solid[..], runs.len()) {
        (&[hub, shroud], 4) => ([hub.clone(), shroud.clone()], covered(&runs)),
        (&[hub], 2) => ([hub.clone(), tips(&runs.iter().find(|run| !run.is_solid)?.points)?], None),
        _ => return None,
    };
    walls.iter().all(|wall| wall.points.len() > DEGREE).then_some((walls, covered))
}

/// The part of the blades' ends that a solid run covers, if the open run beside it goes on in its direction up to a corner,
/// as tips do.
fn covered(runs: &[Run]) -> Option<Covered> {
    let n = runs.len();
    let covered = |[far_end, middle, end]: [DVec2; 3], open: &[DVec2], beside: DVec2| {
        let reach = (open.len() / CORNERS[0]).max(3);
        let corner = sharpest(open, reach, &|_| true).filter(|&i| turn(open, i, reach) > BARE_CORNER)?;
        let (bare, length) = (open[corner] - beside, far_end.distance(end));
        let share = length / (length + bare.length());
        let goes_on = (end - middle).normalize_or_zero().dot(bare.normalize_or_zero()) > GOES_ON;
        (goes_on && share < 1.0 - LEAST_BARE).then_some(Covered { share, at: middle })
    };
    (0..n).filter(|&i| runs[i].is_solid).find_map(|i| {
        let [before, wall, after] = [i + n - 1, i, i + 1].map(|i| &runs[i % n].points[..]);
        let (&[first, .., last], middle) = (wall, wall[wall.len() / 2]) else { return None };
        covered([first, middle, last], after, *after.first()?)
            .or_else(|| covered([last, middle, first], before, *before.last()?))
    })
}

/// The runs of an outline without the holes in its walls: open ones beyond which the wall goes on in its direction. Round
/// inlet, outlet and tips the outline turns back.
fn without_holes(mut runs: Vec<Run>) -> Vec<Run> {
    let is_hole = |runs: &[Run], i: usize| {
        let n = runs.len();
        let (before, after) = (&runs[(i + n - 1) % n].points, &runs[(i + 1) % n].points);
        let [last, first] = [before.len(), after.len()].map(|len| len.min(DIRECTION));
        let ways = [before[before.len() - 1] - before[before.len() - last], after[first - 1] - after[0]];
        !runs[i].is_solid && ways[0].dot(ways[1]) > 0.0
    };
    while runs.len() > 2
        && let Some(hole) = (0..runs.len()).find(|&i| is_hole(&runs, i))
    {
        // Its outline may go into it.
        runs[hole].points.clear();
        join_over(&mut runs, hole);
    }
    runs
}

/// Joins the runs on either side of run `i`, which are of one kind, over it.
fn join_over(runs: &mut Vec<Run>, i: usize) {
    runs.rotate_left(i);
    let over = runs.remove(0);
    let after = runs.remove(0);
    if let Some(before) = runs.last_mut() {
        before.points.extend(over.points);
        before.points.extend(after.points);
    }
}

/// The runs of an outline, in order; those that are too short belong to their neighbours.
fn runs(outline: &[Piece]) -> Option<Vec<Run>> {
    // Begin where something new begins, so that no run goes over the end of the list.
    let n = outline.len();
    let first = (0..n).find(|&i| outline[i].is_solid != outline[(i + n - 1) % n].is_solid)?;
    let mut runs: Vec<Run> = Vec::new();
    for piece in (0..n).map(|i| outline[(first + i) % n]) {
        match runs.last_mut() {
            Some(run) if run.is_solid == piece.is_solid => run.points.push(piece.at),
            _ => runs.push(Run { is_solid: piece.is_solid, points: vec![piece.at] }),
        }
    }
    while runs.len() > 2
        && let Some(i) = (0..runs.len()).min_by_key(|&i| runs[i].points.len())
        && runs[i].points.len() < LEAST_RUN
    {
        join_over(&mut runs, i);
    }
    Some(runs)
}

/// The tips in the open part of an outline, which goes from the hub's end round one edge, the tips and the other edge:
/// between the two places where it turns most, seen from afar, since edges may be rounded; then from near.
fn tips(open: &[DVec2]) -> Option<Run> {
    let [far, near] = CORNERS.map(|share| (open.len() / share).max(3));
    let is_corner = |i: &usize| turn(open, *i, far) > LEAST_CORNER;
    let one = sharpest(open, far, &|_| true).filter(is_corner)?;
    let other = sharpest(open, far, &|i| i.abs_diff(one) > 2 * far).filter(is_corner)?;
    let [one, other] = [one, other].map(|i| sharpest(open, near, &|k| k.abs_diff(i) <= far / 2).unwrap_or(i));
    Some(Run { is_solid: false, points: open[one.min(other)..=one.max(other)].to_vec() })
}

/// Angle by which an outline turns at point `i`, seen over `reach` points to either side (rad).
fn turn(outline: &[DVec2], i: usize, reach: usize) -> f64 {
    (outline[i] - outline[i - reach]).angle_to(outline[i + reach] - outline[i])
}

/// The point of an outline, of those that are allowed, at which it turns most, seen over `reach` points to either side.
fn sharpest(outline: &[DVec2], reach: usize, is_allowed: &dyn Fn(usize) -> bool) -> Option<usize> {
    let all = (reach..outline.len().saturating_sub(reach)).filter(|&i| is_allowed(i));
    all.max_by(|&a, &b| turn(outline, a, reach).total_cmp(&turn(outline, b, reach)))
}

/// Points at equal steps along the polynomial through a run of the outline, whose own points lie on a lattice, and the
/// greatest distance of the run from it (mm).
fn smooth(run: &[DVec2]) -> Option<(Vec<DVec2>, f64)> {
    let mean = |i: usize| {
        let near = &run[i.saturating_sub(2)..(i + 3).min(run.len())];
        near.iter().sum::<DVec2>() / near.len() as f64
    };
    let means: Vec<DVec2> = (0..run.len()).map(mean).collect();
    let mut lengths = vec![0.0];
    for pair in means.windows(2) {
        lengths.push(lengths[lengths.len() - 1] + pair[0].distance(pair[1]));
    }
    let total = lengths[lengths.len() - 1];
    // Chebyshev's polynomials of the share of the length, taken to -1..1.
    let basis = |t: f64, k: usize| (k as f64 * (2.0 * t - 1.0).clamp(-1.0, 1.0).acos()).cos();
    let matrix = DMatrix::from_fn(run.len(), DEGREE + 1, |i, k| basis(lengths[i] / total, k));
    let values = DMatrix::from_fn(run.len(), 2, |i, k| run[i][k]);
    let solution = matrix.svd(true, true).solve(&values, 1e-12).ok()?;
    let at = |t: f64| {
        let of = |c: usize| (0..=DEGREE).map(|k| solution[(k, c)] * basis(t, k)).sum();
        DVec2::new(of(0), of(1))
    };
    let off = means.iter().zip(&lengths).map(|(mean, length)| mean.distance(at(length / total))).fold(0.0, f64::max);
    Some(((0..=PIECES).map(|i| at(i as f64 / PIECES as f64)).collect(), off))
}

/// Lines from the hub, which of two walls is that of smaller radius, to the shroud or the tips, in order of rising x
/// or, where the passage runs more along the radius, of rising radius.
fn ordered(one: Vec<DVec2>, mut other: Vec<DVec2>, shrouded: bool) -> Vec<[DVec2; 2]> {
    other.reverse();
    let mean = |curve: &[DVec2]| curve.iter().sum::<DVec2>() / curve.len() as f64;
    let across = mean(&other) - mean(&one);
    let height = across.length();
    let one_is_hub = if !shrouded {
        true
    } else if across.y.abs() > SAME_RADIUS * height {
        across.y > 0.0
    } else {
        across.x > 0.0
    };
    let (hub, shroud) = if one_is_hub { (one, other) } else { (other, one) };
    rising(hub.into_iter().zip(shroud).map(|(hub, shroud)| [hub, shroud]).collect())
}

/// Lines in order of rising x or, where the passage runs more along the radius, of rising radius.
pub(super) fn rising(mut lines: Vec<[DVec2; 2]>) -> Vec<[DVec2; 2]> {
    let way = lines.last().zip(lines.first()).map_or(DVec2::ZERO, |(b, a)| b[0] + b[1] - a[0] - a[1]);
    if (if way.x.abs() >= way.y.abs() { way.x } else { way.y }) < 0.0 {
        lines.reverse();
    }
    lines
}
