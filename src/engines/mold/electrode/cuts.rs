//! Cuts that are tried to divide a part.

use std::f64::consts::PI;
use std::fmt;

use glam::DVec2;

use super::cut::{ALIKE, Cut, ON_PLANE};
use super::division::{DivisionSettings, ON_LINE, Part, RestMaterial, RestPlace};
use super::h_edge::{HEdge, is_upright, place};
use super::params::DividedAt;
use super::tip::Footprint;
use crate::outline::Outline;
use crate::plane;
use crate::plane::Shape;
use geometry::mesh::Bounds;

/// Faces along which cuts are tried at most, those with the longest edges.
const MOST_FACES: usize = 4;
/// How near to the middle of rest material its thickest place lies to be cut through at once (mm).
const BESIDE: f64 = 0.1;

/// Cuts that were tried on a head of which cutters leave something.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Undivided {
    /// Number of cuts.
    pub tried: usize,
    /// Number of those that would make a head narrower than the least size.
    pub thin: usize,
    /// Number of those that leave less, but whose heads the cutters do not mill either.
    pub less: usize,
    /// The least size (mm).
    pub least: f64,
}

impl Undivided {
    /// Sum of the cuts that were tried on two heads.
    pub(super) fn and(self, other: Self) -> Self {
        let Self { tried, thin, less, least } = self;
        Self { tried: tried + other.tried, thin: thin + other.thin, less: less + other.less, least }
    }
}

impl fmt::Display for Undivided {
    /// The outcome with the remedy.
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let Self { tried, thin, less, least } = self;
        if *tried == 0 {
            return write!(f, "it was not divided further: divide it there");
        }
        let cuts = |n: usize| if n == 1 { "1 cut".to_owned() } else { format!("{n} cuts") };
        write!(f, "of {} tried through it ", cuts(*tried))?;
        let outcomes = [
            (*thin, format!("would make a head narrower than the least size of {least} mm")),
            (*less, "would lead to heads that the cutters do not mill either".to_owned()),
            (tried - thin - less, "would leave as much".to_owned()),
        ];
        let outcomes = outcomes.into_iter().filter(|(count, _)| *count > 0);
        let outcomes: Vec<String> = outcomes.map(|(count, what)| format!("{count} {what}")).collect();
        let smaller = if *thin > 0 { "give a smaller least size, " } else { "" };
        write!(f, "{}: {smaller}divide it by hand, or burn it from another direction", outcomes.join(", "))
    }
}

/// Whether two cuts are one.
fn is_same(a: &Cut, b: &Cut) -> bool {
    a.overlaps == b.overlaps
        && a.low == b.low
        && a.normal.distance(b.normal) < ALIKE
        && a.beyond(b.through).abs() < ON_PLANE
}

/// The cuts that may take H-edges away where cutters leave something: between pieces that stand close, along the steep
/// faces beside the edges, those with the longest H-edges first, and along slanted edges themselves.
pub(super) fn cuts(part: &Part, rest: &RestMaterial, settings: &DivisionSettings) -> Vec<Cut> {
    let reach = settings.milling.least;
    let is_near =
        |edge: &&HEdge| rest.places.iter().any(|at| at.bounds.grown(reach).intersects(&Bounds::of(edge.ends)));
    let near: Vec<&HEdge> = part.h_edges.iter().filter(is_near).collect();
    let mut along_faces: Vec<Cut> = Vec::new();
    for cut in near.iter().flat_map(|edge| edge.normals.map(|n| Cut::along(n, edge.ends[0]))).flatten() {
        if !along_faces.iter().any(|other| is_same(other, &cut)) {
            along_faces.push(cut);
        }
    }
    let length = |cut: &Cut| near.iter().filter(|edge| cut.holds(edge)).map(|edge| edge.length()).sum::<f64>();
    let mut along_faces: Vec<(f64, Cut)> = along_faces.into_iter().map(|cut| (length(&cut), cut)).collect();
    along_faces.sort_by(|a, b| b.0.total_cmp(&a.0));
    along_faces.truncate(MOST_FACES);
    let both = |(_, cut): (f64, Cut)| {
        let cut = cut.fitted(&part.inner);
        [true, false].map(|overlaps| Cut { overlaps, ..cut })
    };
    // Without an overlap both sides are alike, so that one direction across the edge will do.
    let along_itself = |edge: &&HEdge| {
        let outward = (edge.ends[1] - edge.ends[0]).truncate().normalize_or_zero().perp();
        Cut::upright(place(edge), outward, false)
    };
    let slanted = near.iter().filter(|edge| !is_upright(edge)).take(MOST_FACES).map(along_itself);
    let apart = apart(&part.footprint, 2.0 * reach);
    apart.into_iter().chain(along_faces.into_iter().flat_map(both)).chain(slanted).collect()
}

/// Upright cuts through what cutters leave, where it is thickest and through its middle: they open hollows and valleys
/// that have no edges, or none that a cut along helps.
pub(super) fn across(part: &Part, rest: &RestMaterial, settings: &DivisionSettings) -> Vec<Cut> {
    if settings.at == DividedAt::EveryEdge {
        return Vec::new();
    }
    let sides = part.footprint.free.iter().flat_map(Outline::sides).map(|[a, b]| b - a);
    let along = sides.max_by(|a, b| a.length_squared().total_cmp(&b.length_squared())).unwrap_or(DVec2::X);
    let along = along.normalize_or(DVec2::X);
    let through = |at: &RestPlace| {
        let [middle, thickest] = [at.bounds.center(), at.thickest].map(|p| p.truncate());
        if middle.distance(thickest) < BESIDE { vec![thickest] } else { vec![thickest, middle] }
    };
    let at = |p: DVec2| {
        [0.0, 0.25, 0.5, 0.75].map(|turns| Cut::upright(p, DVec2::from_angle(turns * PI).rotate(along), false))
    };
    rest.places.iter().flat_map(through).take(MOST_FACES).flat_map(at).collect()
}

/// Connected pieces of a footprint.
pub(super) fn shapes(footprint: &Footprint) -> Vec<Shape> {
    plane::union(&footprint.free, &[])
}

/// Cuts between connected pieces of a footprint that no cutter passes, so near do they stand (mm).
fn apart(footprint: &Footprint, nearer: f64) -> Vec<Cut> {
    let shapes = shapes(footprint);
    let onto =
        |p: DVec2, [a, b]: [DVec2; 2]| a + (b - a) * ((p - a).dot(b - a) / a.distance_squared(b)).clamp(0.0, 1.0);
    let ways = |a: &Shape, b: &Shape| -> Vec<[DVec2; 2]> {
        let sides: Vec<[DVec2; 2]> = b.iter().flat_map(Outline::sides).collect();
        a.iter().flat_map(Outline::points).flat_map(|p| sides.iter().map(|side| [*p, onto(*p, *side)])).collect()
    };
    let between = |a: &Shape, b: &Shape| {
        let back = ways(b, a).into_iter().map(|[p, q]| [q, p]);
        let all = ways(a, b).into_iter().chain(back);
        let [p, q] = all.min_by(|x, y| x[0].distance(x[1]).total_cmp(&y[0].distance(y[1])))?;
        let is_near = (ON_LINE..nearer).contains(&p.distance(q));
        is_near.then(|| Cut::upright(p.midpoint(q), (q - p).normalize(), false))
    };
    let pairs = (0..shapes.len()).flat_map(|i| (0..i).map(move |j| [i, j]));
    pairs.filter_map(|[i, j]| between(&shapes[i], &shapes[j])).take(MOST_FACES).collect()
}
