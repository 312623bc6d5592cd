//! The unreduced boundary: where the exact distance to the finished blisk equals the spark gap.

use glam::DVec3;
use rayon::prelude::*;

use super::walls::WallTable;
use super::{ElectrodeError, ElectrodeParams};
use crate::channel::{Channel, Station};
use geometry::exact::ExactMesh;
use geometry::frame::Cylindrical;
use geometry::inside::guarded_distance;
use task::Cancel;

/// A boundary point keeps at least the gap and at most this more (mm).
const TOLERANCE: f64 = 1e-4;
/// How much farther than free space allows a search may jump ahead; less than the thinnest edge and two gaps (mm).
const LEAP: f64 = 0.3;
/// How far above the hub and below the shroud the corners of a section are searched, so that the walk along the
/// end wall is free (mm).
const CORNER_LIFT: f64 = 1e-3;
/// How much the radii of the channel may be wrong (mm).
const MERIDIAN_SLACK: f64 = 0.05;
/// Distance between planes before they are refined (mm).
const STEP: f64 = 0.5;
/// How deep a chord between two planes may cut into the gap before a plane is put between them (mm).
const CHORD_ERROR: f64 = 2e-3;
/// Planes are not put closer than this (mm).
const LEAST_STEP: f64 = 0.01;
/// Planes at most; where they do not suffice the deepest cuts are refined.
const MOST_PLANES: usize = 130;
/// Rounds of halving at most.
const MOST_ROUNDS: usize = 10;
/// Height of a row of faces on the walls (mm).
const ROW: f64 = 1.5;

/// A point in a plane across X.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Polar {
    /// Distance from the axis (mm).
    pub r: f64,
    /// Angle (rad).
    pub theta: f64,
}

impl Polar {
    /// The point in W.
    pub(super) fn at(self, x: f64) -> DVec3 {
        Cylindrical { x, r: self.r, theta: self.theta }.point()
    }
}

/// The unreduced boundary in one plane across X.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Section {
    /// The plane (mm).
    pub x: f64,
    /// Low and high wall, from the hub outwards.
    pub walls: [Vec<Polar>; 2],
}

/// Finds sections.
pub(super) struct Boundary<'a> {
    pub(super) channel: &'a Channel,
    pub(super) blisk: &'a ExactMesh,
    pub(super) gap: f64,
    pub(super) radial_reduction: f64,
    tables: [WallTable; 2],
    rows: usize,
}

/// The sense of theta that leads out of the channel through each wall.
const OUTWARDS: [f64; 2] = [-1.0, 1.0];

impl<'a> Boundary<'a> {
    pub(super) fn new(
        channel: &'a Channel,
        blisk: &'a ExactMesh,
        params: &ElectrodeParams,
    ) -> Result<Self, ElectrodeError> {
        let table = |wall| WallTable::new(wall).ok_or(ElectrodeError::BadChannel("a wall has fewer than 2 x 2 points"));
        if channel.meridian.len() < 2 {
            return Err(ElectrodeError::BadChannel("its hub and shroud radii are missing"));
        }
        let height = channel.meridian.iter().map(Station::height).fold(0.0, f64::max);
        Ok(Self {
            channel,
            blisk,
            gap: params.spark_gap_mm,
            radial_reduction: params.radial_reduction_mm,
            tables: [table(&channel.low)?, table(&channel.high)?],
            rows: (height / ROW).ceil().clamp(4.0, 40.0) as usize,
        })
    }

    /// Distance to the blisk less the gap (mm).
    pub(super) fn clearance(&self, x: f64, p: Polar) -> f64 {
        guarded_distance(self.blisk, p.at(x)) - self.gap
    }

    /// Sections over `extent`, in order of x: at `planes`, at equal steps, and wherever the chord between two
    /// neighbours would cut into the gap.
    pub(super) fn sections(
        &self,
        extent: [f64; 2],
        planes: &[f64],
        cancel: &Cancel,
    ) -> Result<Vec<Section>, ElectrodeError> {
        let steps = ((extent[1] - extent[0]) / STEP).ceil().clamp(2.0, MOST_PLANES as f64 / 2.0);
        let mut xs: Vec<f64> = planes.to_vec();
        xs.extend((0..=steps as usize).map(|i| extent[0] + (extent[1] - extent[0]) * i as f64 / steps));
        xs.sort_by(f64::total_cmp);
        // Where a step falls next to a plane that must be there, the plane is enough.
        xs.dedup_by(|b, a| *b - *a < 1e-9);
        let near_plane = |x: f64| planes.iter().any(|p| *p != x && (p - x).abs() < 0.2 * STEP);
        xs.retain(|&x| planes.contains(&x) || x == extent[0] || x == extent[1] || !near_plane(x));
        let mut sections = self.solve(&xs, cancel)?;
        for _ in 0..MOST_ROUNDS {
            let split = self.splits(&sections, extent, cancel)?;
            if split.is_empty() {
                break;
            }
            sections.extend(self.solve(&split, cancel)?);
            sections.sort_by(|a, b| a.x.total_cmp(&b.x));
        }
        Ok(sections)
    }

    fn solve(&self, xs: &[f64], cancel: &Cancel) -> Result<Vec<Section>, ElectrodeError> {
        let solved: Vec<_> = xs
            .par_iter()
            .map(|&x| {
                cancel.check()?;
                self.section(x)
            })
            .collect();
        solved.into_iter().collect()
    }

    /// The middles of the intervals whose chords cut too deep: the deepest, and each time only half as many as may
    /// still be added, so that the deepest cuts are refined first.
    fn splits(&self, sections: &[Section], extent: [f64; 2], cancel: &Cancel) -> Result<Vec<f64>, ElectrodeError> {
        let cut = |i: usize| {
            let (a, b) = (&sections[i], &sections[i + 1]);
            let is_inside = a.x > extent[0] - 1e-9 && b.x < extent[1] + 1e-9;
            let may_split = is_inside && b.x - a.x >= 2.0 * LEAST_STEP;
            let depth = if may_split { self.chord_depth(a, b) } else { 0.0 };
            (depth > CHORD_ERROR).then_some((depth, 0.5 * (a.x + b.x)))
        };
        let cuts: Vec<_> =
            (0..sections.len().saturating_sub(1)).into_par_iter().map(|i| cancel.check().map(|()| cut(i))).collect();
        let mut cuts: Vec<_> = cuts.into_iter().collect::<Result<Vec<_>, _>>()?.into_iter().flatten().collect();
        cuts.sort_by(|a, b| b.0.total_cmp(&a.0));
        cuts.truncate(MOST_PLANES.saturating_sub(sections.len()).div_ceil(2));
        Ok(cuts.into_iter().map(|(_, x)| x).collect())
    }

    /// How deep the chords between two sections cut into the gap at their middles, away from the corners (mm).
    fn chord_depth(&self, a: &Section, b: &Section) -> f64 {
        let chords = (0..2).flat_map(|w| a.walls[w].iter().zip(&b.walls[w]).skip(1).take(self.rows - 1));
        let middles = chords.map(|(p, q)| (p.at(a.x) + q.at(b.x)) / 2.0);
        middles.map(|middle| self.gap - guarded_distance(self.blisk, middle)).fold(0.0, f64::max)
    }

    /// The boundary in the plane at `x`.
    fn section(&self, x: f64) -> Result<Section, ElectrodeError> {
        let (hub, shroud) = self.channel.radii_at(x);
        let r = 0.5 * (hub + shroud);
        let middle = Polar { r, theta: self.middle(x, r) };
        let clearance = self.clearance(x, middle);
        if clearance.is_nan() || clearance < 0.0 {
            return Err(self.no_passage(x, r, clearance));
        }
        let bottom = self.descend(x, middle);
        let top = if self.channel.shrouded { self.ascend(x, middle) } else { shroud };
        let (available, taken) = (top - bottom, self.radial_reduction);
        if available < taken + 0.2 {
            return Err(ElectrodeError::NoHeight { x, available, taken });
        }
        let rows = self.rows;
        let radius = |v: usize| bottom + (available - taken) * v as f64 / rows as f64;
        let wall = |w: usize| -> Result<Vec<Polar>, ElectrodeError> {
            let mut points = vec![Polar { r: 0.0, theta: 0.0 }; rows + 1];
            for (v, point) in points.iter_mut().enumerate().take(rows).skip(1) {
                *point = self.wall_point(w, x, radius(v))?;
            }
            points[0] = self.corner(w, x, points[1], -1.0);
            points[rows] = if self.channel.shrouded {
                self.corner(w, x, points[rows - 1], 1.0)
            } else {
                self.wall_point(w, x, radius(rows))?
            };
            Ok(points)
        };
        Ok(Section { x, walls: [wall(0)?, wall(1)?] })
    }

    /// Reason why the channel's middle is not free.
    fn no_passage(&self, x: f64, r: f64, clearance: f64) -> ElectrodeError {
        let (clearance, gap) = (clearance + self.gap, self.gap);
        if clearance >= 0.0 {
            ElectrodeError::NoPassage { x, r, clearance, gap }
        } else {
            ElectrodeError::InsideBlisk { x, r }
        }
    }

    /// Angle of the channel's middle.
    fn middle(&self, x: f64, r: f64) -> f64 {
        0.5 * (self.tables[0].at(x, r).theta + self.tables[1].at(x, r).theta)
    }

    /// The radius down to which the point may go before it meets the hub's gap.
    pub(super) fn descend(&self, x: f64, from: Polar) -> f64 {
        let least = self.channel.radii_at(x).0 + self.gap - MERIDIAN_SLACK;
        from.r - farthest(|s| self.clearance(x, Polar { r: from.r - s, ..from }), from.r - least)
    }

    /// The radius up to which the point may go before it meets the shroud's gap.
    pub(super) fn ascend(&self, x: f64, from: Polar) -> f64 {
        let most = self.channel.radii_at(x).1 - self.gap + MERIDIAN_SLACK;
        from.r + farthest(|s| self.clearance(x, Polar { r: from.r + s, ..from }), most - from.r)
    }

    /// The point at `x` and `r` where the walk from the channel's middle to wall `w` meets the gap.
    fn wall_point(&self, w: usize, x: f64, r: f64) -> Result<Polar, ElectrodeError> {
        let place = self.tables[w].at(x, r);
        let middle = self.middle(x, r);
        let clearance_at = |theta| self.clearance(x, Polar { r, theta });
        // Start next to the wall if that is free, else in the middle.
        let close = place.theta - OUTWARDS[w] * (0.3 + 1.5 * self.gap) / r;
        let is_short = (close - middle) * OUTWARDS[w] <= 0.0;
        let start = if is_short || clearance_at(close) < 0.0 { middle } else { close };
        let clearance = clearance_at(start);
        if clearance < 0.0 {
            return Err(self.no_passage(x, r, clearance));
        }
        Ok(self.outwards(w, x, Polar { r, theta: start }))
    }

    /// From a free point along theta towards wall `w`, past an edge not beyond the angle of its tip.
    fn outwards(&self, w: usize, x: f64, from: Polar) -> Polar {
        let place = self.tables[w].at(x, from.r);
        let slack = if place.past_edge { 0.0 } else { 0.5 };
        let reach = (place.theta - from.theta) * OUTWARDS[w] * from.r + slack;
        let at = |s: f64| Polar { theta: from.theta + OUTWARDS[w] * s / from.r, ..from };
        at(farthest(|s| self.clearance(x, at(s)), reach))
    }

    /// The corner between wall `w` and the hub (`up = -1`) or shroud (`up = 1`), next to the wall point `beside`.
    ///
    /// The search runs along the end wall just inside its gap, and goes over facets of the end wall that rise into it.
    fn corner(&self, w: usize, x: f64, beside: Polar, up: f64) -> Polar {
        let inset = 0.3f64.min(0.5 * ((beside.theta - self.middle(x, beside.r)) * OUTWARDS[w] * beside.r).abs());
        let start = Polar { theta: beside.theta - OUTWARDS[w] * inset / beside.r, ..beside };
        let (end_wall, drawn_in) = match up {
            up if up < 0.0 => (self.descend(x, start), 0.0),
            _ => (self.ascend(x, start), self.radial_reduction),
        };
        let mut lift = CORNER_LIFT;
        let mut corner = Polar { r: end_wall - up * (lift + drawn_in), ..start };
        if self.clearance(x, corner) < 0.0 {
            return Polar { r: end_wall - up * drawn_in, ..start };
        }
        loop {
            corner = self.outwards(w, x, corner);
            let is_stopped = self.clearance(x, corner) <= TOLERANCE;
            if !is_stopped || lift > 0.1 || !self.is_radial(x, corner) {
                return corner;
            }
            corner.r -= up * lift;
            lift *= 2.0;
        }
    }

    /// Whether what stops a point lies below or above it rather than beside it.
    fn is_radial(&self, x: f64, p: Polar) -> bool {
        let point = p.at(x);
        let [_, radial, around] = components(point, point - self.blisk.nearest(point).point);
        radial.abs() > around.abs()
    }
}

/// Components of a direction at `point` along X, the radius, and theta.
pub(super) fn components(point: DVec3, direction: DVec3) -> [f64; 3] {
    let outward = DVec3::new(0.0, point.y, point.z).normalize_or(DVec3::Z);
    [direction.x, direction.dot(outward), direction.dot(DVec3::X.cross(outward))]
}

/// How far one may walk from 0 towards `reach` before `clearance`, which falls by at most 1 per mm and is not
/// negative at 0, gets negative: a place where it lies between 0 and [`TOLERANCE`], or `reach` if there is none.
fn farthest(clearance: impl Fn(f64) -> f64, reach: f64) -> f64 {
    if reach <= 0.0 {
        return 0.0;
    }
    let (mut s, mut free, mut slope) = (0.0, clearance(0.0), 1.0);
    for _ in 0..500 {
        if free <= TOLERANCE {
            return s;
        }
        // Free space allows a step of `free`; the fall seen so far suggests a longer one.
        let next = (s + (free / slope).min(free.max(LEAP))).min(reach);
        let there = clearance(next);
        if there < 0.0 {
            return crossing(clearance, (s, free), (next, there));
        }
        slope = ((free - there) / (next - s)).clamp(0.02, 1.0);
        (s, free) = (next, there);
        if s >= reach {
            return reach;
        }
    }
    s
}

/// A place between `free` (clearance >= 0) and `blocked` (< 0) where the clearance is between 0 and
/// [`TOLERANCE`], by the Illinois method.
fn crossing(clearance: impl Fn(f64) -> f64, mut free: (f64, f64), mut blocked: (f64, f64)) -> f64 {
    let (mut weight_free, mut weight_blocked) = (1.0, 1.0);
    for _ in 0..100 {
        if free.1 <= TOLERANCE || (blocked.0 - free.0).abs() < 1e-8 {
            break;
        }
        // Aim at the middle of the tolerance.
        let (a, b) = ((free.1 - 0.5 * TOLERANCE) * weight_free, (blocked.1 - 0.5 * TOLERANCE) * weight_blocked);
        let next = free.0 + (blocked.0 - free.0) * (a / (a - b)).clamp(0.01, 0.99);
        let there = clearance(next);
        if there >= 0.0 {
            free = (next, there);
            (weight_free, weight_blocked) = (1.0, weight_blocked * 0.5);
        } else {
            blocked = (next, there);
            (weight_free, weight_blocked) = (weight_free * 0.5, 1.0);
        }
    }
    free.0
}
