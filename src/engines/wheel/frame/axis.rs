//! Lines that may be the axis of a mesh, best first.
//!
//! Two independent sources: the principal axes of the solid (a solid with three or more equal sectors turns
//! about one of them), and the line that the surface's normals meet best (Pottmann and Wallner, Computational
//! Line Geometry, chapter 4: the normals of a surface of revolution all meet its axis). The second also holds
//! for a part of a blisk and for one with balance cuts.

use glam::{DMat3, DVec3};
use nalgebra::{Matrix3, Matrix4, SymmetricEigen, Vector4};
use rayon::prelude::*;
use serde::Serialize;

use geometry::mesh::{Bounds, Mesh, normal_times_two_areas};
use geometry::triangle_distance::segment_distance;

/// A line in the coordinates of the mesh: the axis of a blisk.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Axis {
    /// A point of the line (mm).
    pub point: DVec3,
    /// Unit direction.
    pub direction: DVec3,
}

impl Axis {
    /// The line through `point` along `direction`, turned to the positive side of the mesh axis that it is
    /// nearest to, its point the foot of the mesh's origin.
    pub(crate) fn new(point: DVec3, direction: DVec3) -> Self {
        let d = direction.normalize_or(DVec3::X);
        let size = d.abs().to_array();
        // Within rounding of a tie the earlier mesh axis decides.
        let major = (1..3).fold(0, |best, i| if size[i] > size[best] + 1e-9 { i } else { best });
        let direction = if d[major] < 0.0 { -d } else { d };
        Self { point: point - direction * direction.dot(point), direction }
    }

    /// The mesh axis that the line is nearest to: 0, 1 or 2.
    pub(super) fn major(&self) -> usize {
        let size = self.direction.abs().to_array();
        (1..3).fold(0, |best, i| if size[i] > size[best] + 1e-9 { i } else { best })
    }

    /// Point of the line that is nearest to `p`.
    pub(crate) fn foot(&self, p: DVec3) -> DVec3 {
        self.point + self.direction * self.direction.dot(p - self.point)
    }

    /// Distance of `p` from the line (mm).
    pub(crate) fn distance(&self, p: DVec3) -> f64 {
        self.direction.cross(p - self.point).length()
    }

    /// Line moved onto directions and planes of the mesh's own axes where it misses them by no more than the rounding
    /// of coordinates (f32 files keep seven digits) of a part of the given size (mm).
    pub(super) fn snapped(mut self, size: f64) -> Self {
        let unit = [DVec3::X, DVec3::Y, DVec3::Z][self.major()];
        if (self.direction - unit).length() < 2e-7 {
            self = Self::new(self.point, unit);
        }
        let near_zero = self.point.abs().cmplt(DVec3::splat(1e-7 * size));
        self.point = DVec3::select(near_zero, DVec3::ZERO, self.point);
        Self::new(self.point, self.direction)
    }
}

/// A piece of surface: where it is, its unit normal and its area.
struct Facet {
    center: DVec3,
    normal: DVec3,
    area: f64,
}

/// Facets that tell how well a surface turns about a line as well as more would.
const MANY: usize = 200_000;

/// Shares of the surface that differ by less are as much.
const AS_MUCH: f64 = 0.05;

/// Share of the closest agreement from which on a line agrees with the surface as closely.
const AS_CLOSE: f64 = 0.9;

/// Facets of a mesh, of a fine one evenly picked, about as many as `enough`.
fn facets(mesh: &Mesh, enough: usize) -> Vec<Facet> {
    let facet = |t: [DVec3; 3]| {
        let n = normal_times_two_areas(t);
        Facet { center: (t[0] + t[1] + t[2]) / 3.0, normal: n.normalize_or_zero(), area: 0.5 * n.length() }
    };
    // An odd step, so as not to pick the same triangle of every quad.
    let step = (mesh.triangles.len() / enough) | 1;
    mesh.iter_corners().step_by(step).map(facet).filter(|f| f.area > 0.0).collect()
}

/// Lines that may be the axis of `mesh`, the likeliest first, none twice; with `direction`, only lines along it.
pub(super) fn candidates(mesh: &Mesh, direction: Option<DVec3>) -> Vec<Axis> {
    let facets = facets(mesh, MANY);
    let size = mesh.bounds().size().length();
    let (center, moments) = solid_moments(mesh);
    let normals = Normals::new(&facets, center, size);
    let axes: Vec<Axis> = match direction {
        Some(direction) => vec![Axis::new(center, direction), normals.axis(Some(direction), true)],
        None => {
            let principal = eigen(moments).map(|(_, d)| d);
            let starts = principal.iter().map(|&d| Some(d)).chain([None]);
            let met = starts.map(|start| normals.axis(start, false));
            principal.iter().map(|&d| Axis::new(center, d)).chain(met).collect()
        }
    };
    let axes = axes.into_iter().filter(|a| a.point.is_finite() && a.direction.is_finite());
    let of = |a: Axis| (closeness(&facets, &a), share_of_revolution(&facets, &a), a);
    let mut ranked: Vec<(f64, f64, Axis)> = axes.map(of).collect();
    // Walls along the axis of a flat ring nearly turn about its diameters, and are more than its rims; its faces do not.
    let closest = ranked.iter().map(|(close, ..)| *close).fold(0.0, f64::max);
    let is_far = |close: f64| close < AS_CLOSE * closest;
    // Of lines about which as much turns, the closer one: the middle of a wheel that lacks blades is beside its axis.
    let much = |share: f64| (share / AS_MUCH).round();
    ranked
        .sort_by(|a, b| is_far(a.0).cmp(&is_far(b.0)).then(much(b.1).total_cmp(&much(a.1))).then(b.0.total_cmp(&a.0)));
    let mut distinct: Vec<Axis> = Vec::new();
    for (.., axis) in ranked {
        let same =
            |a: &Axis| a.direction.cross(axis.direction).length() < 1e-3 && a.distance(axis.foot(center)) < 1e-3 * size;
        if !distinct.iter().any(same) {
            distinct.push(axis);
        }
    }
    distinct
}

/// Centroid and second moments about it (the covariance times the volume) of the solid.
fn solid_moments(mesh: &Mesh) -> (DVec3, DMat3) {
    let o = mesh.bounds().center();
    let (mut volume, mut first) = (0.0, DVec3::ZERO);
    let mut second = DMat3::ZERO;
    for t in mesh.iter_corners() {
        let [a, b, c] = t.map(|p| p - o);
        let v = a.dot(b.cross(c)) / 6.0;
        let sum = a + b + c;
        volume += v;
        first += v * sum / 4.0;
        second += (outer(a) + outer(b) + outer(c) + outer(sum)) * (v / 20.0);
    }
    // An open mesh may enclose nothing: then its middle is as good a guess as any.
    let center = first / volume;
    if !center.is_finite() || !mesh.bounds().grown(1e-9).intersects(&Bounds::of([o + center])) {
        return (o, second);
    }
    (o + center, second - outer(center) * volume)
}

pub(crate) fn outer(v: DVec3) -> DMat3 {
    DMat3::from_cols(v * v.x, v * v.y, v * v.z)
}

/// Eigenvalues and unit eigenvectors of a symmetric matrix in order of rising eigenvalue.
pub(crate) fn eigen(m: DMat3) -> [(f64, DVec3); 3] {
    const MOST_STEPS: usize = 1000;
    let matrix = Matrix3::from_column_slice(&m.to_cols_array());
    let Some(eigen) = SymmetricEigen::try_new(matrix, f64::EPSILON, MOST_STEPS) else {
        return [DVec3::X, DVec3::Y, DVec3::Z].map(|v| (v.dot(m * v), v));
    };
    let mut order = [0, 1, 2];
    order.sort_by(|&a, &b| eigen.eigenvalues[a].total_cmp(&eigen.eigenvalues[b]));
    order.map(|i| (eigen.eigenvalues[i], DVec3::from_slice(eigen.eigenvectors.column(i).as_slice())))
}

/// How far the normal of a facet misses the axis: its component around the axis.
fn tangential(facet: &Facet, axis: &Axis) -> f64 {
    let around = axis.direction.cross(facet.center - axis.point);
    facet.normal.dot(around.normalize_or_zero()).abs()
}

/// Share of the area that is a surface of revolution about `axis`: whose normals miss it by no more than the width of a
/// facet. Faces across the axis are so about any line parallel to it, hence do not count.
fn share_of_revolution(facets: &[Facet], axis: &Axis) -> f64 {
    const SLANT: f64 = 0.1;
    let radial = facets.iter().filter(|f| tangential(f, axis) < SLANT).map(|f| f.area * beside(f, axis));
    radial.sum::<f64>() / facets.iter().map(|f| f.area).sum::<f64>()
}

/// How closely the surface turns about `axis`, faces across it included, 0 to 1: a half where its normals miss the axis as
/// those of a coarse cylinder's facets do.
fn closeness(facets: &[Facet], axis: &Axis) -> f64 {
    const HALF: f64 = 0.03;
    let close = facets.iter().map(|f| f.area / (1.0 + (tangential(f, axis) / HALF).powi(2)));
    close.sum::<f64>() / facets.iter().map(|f| f.area).sum::<f64>()
}

/// Some facets of a mesh, enough to tell about which lines its surface turns.
pub(super) struct Turning(Vec<Facet>);

impl Turning {
    pub(super) fn new(mesh: &Mesh) -> Self {
        Self(facets(mesh, Normals::ENOUGH))
    }

    /// Share of the area that is a surface of revolution about `axis`.
    pub(super) fn share(&self, axis: &Axis) -> f64 {
        share_of_revolution(&self.0, axis)
    }
}

/// How little a facet faces along the axis: the sine of the angle between them, squared.
fn beside(facet: &Facet, axis: &Axis) -> f64 {
    1.0 - facet.normal.dot(axis.direction).powi(2)
}

/// The lines of a surface's normals, in Pluecker coordinates about `center` in units of `size`.
struct Normals<'a> {
    facets: Vec<&'a Facet>,
    center: DVec3,
    size: f64,
}

impl<'a> Normals<'a> {
    /// Facets that are enough to guess an axis from.
    const ENOUGH: usize = 15_000;

    fn new(facets: &'a [Facet], center: DVec3, size: f64) -> Self {
        let step = (facets.len() / Self::ENOUGH) | 1;
        Self { facets: facets.iter().step_by(step).collect(), center, size }
    }

    /// The line that the normals meet best, by least squares reweighted so that walls, which are no surfaces of
    /// revolution, lose their say. It sets out from the line along `direction` that suits best, or from the
    /// best of all lines; with `keep` the direction stays.
    fn axis(&self, direction: Option<DVec3>, keep: bool) -> Axis {
        // How far a normal may miss the axis and still count, from anything down to the slant of a facet.
        const NARROWING: [f64; 9] = [1e3, 0.5, 0.35, 0.25, 0.18, 0.12, 0.08, 0.05, 0.03];
        let mut axis = None;
        for tolerance in NARROWING {
            axis = Some(self.step(axis.as_ref(), tolerance, direction));
        }
        if direction.is_some() && !keep {
            for tolerance in &NARROWING[4..] {
                axis = Some(self.step(axis.as_ref(), *tolerance, None));
            }
        }
        axis.unwrap_or(Axis { point: self.center, direction: DVec3::X })
    }

    /// The least-squares line (d, m = c x d), each normal weighted by how nearly it meets `axis`.
    fn step(&self, axis: Option<&Axis>, tolerance: f64, direction: Option<DVec3>) -> Axis {
        let (mut a, mut b, mut d) = (DMat3::ZERO, DMat3::ZERO, DMat3::ZERO);
        for f in &self.facets {
            let miss = axis.map_or(0.0, |axis| tangential(f, axis));
            let weight = f.area / (1.0 + (miss / tolerance).powi(2)).powi(2);
            let (n, moment) = (f.normal, (f.center - self.center).cross(f.normal) / self.size);
            a += weight * outer(n);
            b += weight * DMat3::from_cols(n * moment.x, n * moment.y, n * moment.z);
            d += weight * outer(moment);
        }
        let inverse = pseudo_inverse(a);
        let direction = direction.unwrap_or_else(|| eigen(d - b.transpose() * inverse * b)[0].1);
        let moment = -(inverse * (b * direction)) * self.size;
        Axis::new(self.center + direction.cross(moment), direction)
    }
}

/// The inverse of a symmetric matrix on the space where it is not zero.
fn pseudo_inverse(m: DMat3) -> DMat3 {
    let pairs = eigen(m);
    let greatest = pairs.iter().fold(0.0, |g: f64, (value, _)| g.max(value.abs()));
    let kept = pairs.into_iter().filter(|(value, _)| value.abs() > 1e-9 * greatest);
    kept.fold(DMat3::ZERO, |sum, (value, vector)| sum + outer(vector) * (1.0 / value))
}

/// The line near `axis` about which the turned surfaces of `mesh` turn: `axis` itself where that is it, and none where they
/// do not tell it from another. In a wheel whose blades were set a little aslant it is not the blades'. A line along one of
/// the mesh's own axes stands for one that cannot be told from it.
///
/// Gauss and Newton's steps of the reweighted least squares of [`Normals`], with the covariance of their result, which
/// tells lines apart.
pub(super) fn of_turned_surfaces(mesh: &Mesh, axis: Axis) -> Option<Axis> {
    const ROUNDS: usize = 8;
    /// A step by less than this, as a share of the reach and as an angle, changes nothing any more.
    const SETTLED: f64 = 1e-12;
    /// How far a normal may miss the axis, as a sine: the slant of a facet.
    const SLANT: f64 = 0.03;
    /// Nearer lines are the same, as a share of the part's radius.
    const SAME: f64 = 2e-4;
    /// Square of the distance in standard deviations from which on lines differ.
    const DIFFERENT: f64 = 50.0;
    let facets = facets(mesh, MANY);
    let total = facets.iter().map(|f| f.area).sum::<f64>();
    let center = facets.iter().map(|f| f.area * f.center).sum::<DVec3>() / total;
    let reach = facets.iter().map(|f| axis.distance(f.center)).fold(0.0, f64::max);
    // Of a line: its point beside the center, and two directions square to it.
    let base = |line: &Axis| {
        let across = line.direction.any_orthonormal_vector();
        (line.foot(center), [across, line.direction.cross(across)])
    };
    let (mut line, mut information) = (axis, Matrix4::zeros());
    for _ in 0..ROUNDS {
        let (origin, ways) = base(&line);
        let (mut normal, mut right, mut scatter) = (Matrix4::zeros(), Vector4::zeros(), Matrix4::zeros());
        for f in &facets {
            let arm = f.center - origin;
            let around = line.direction.cross(arm);
            let miss = f.normal.dot(around) / reach;
            let slant = f.normal.dot(around.normalize_or_zero()) / SLANT;
            let weight = f.area / (1.0 + slant * slant).powi(2);
            // How the miss changes as the line moves sideways, in units of the reach, and tilts.
            let moved = ways.map(|way| -f.normal.dot(line.direction.cross(way)));
            let tilted = ways.map(|way| f.normal.dot(way.cross(arm)) / reach);
            let change = Vector4::new(moved[0], moved[1], tilted[0], tilted[1]);
            let square = change * change.transpose();
            normal += weight * square;
            right -= weight * miss * change;
            scatter += (weight * miss).powi(2) * square;
        }
        let inverse = normal.try_inverse()?;
        let step = inverse * right;
        information = (inverse * scatter * inverse).try_inverse()?;
        let point = origin + reach * (step[0] * ways[0] + step[1] * ways[1]);
        line = Axis::new(point, line.direction + step[2] * ways[0] + step[3] * ways[1]);
        if !line.point.is_finite() || line.distance(center) > reach {
            return None;
        }
        if step.norm() < SETTLED {
            break;
        }
    }
    let apart = |other: &Axis| {
        let (origin, ways) = base(&line);
        let [moved, tilted] = [(other.foot(origin) - origin) / reach, other.direction - line.direction];
        Vector4::new(ways[0].dot(moved), ways[1].dot(moved), ways[0].dot(tilted), ways[1].dot(tilted))
    };
    let is_same = |other: &Axis| apart(other).norm() < SAME;
    let is_told_from = |other: &Axis| apart(other).dot(&(information * apart(other))) >= DIFFERENT;
    if is_same(&axis) {
        return Some(axis);
    }
    let own = Axis::new(DVec3::ZERO, [DVec3::X, DVec3::Y, DVec3::Z][line.major()]);
    is_told_from(&axis).then_some(if is_same(&own) || !is_told_from(&own) { own } else { line })
}

/// Angle about `axis` that the surface covers, of a full turn (rad), seen in 120 sectors. What lies so near the axis that
/// its error counts is left out: the plane faces of a sector cover nothing.
pub(super) fn covered_angle(mesh: &Mesh, axis: &Axis) -> f64 {
    const SECTORS: i64 = 120;
    const NEAR: f64 = 0.03;
    let across = axis.direction.any_orthonormal_vector();
    let up = axis.direction.cross(across);
    let flat = |p: DVec3| glam::DVec2::new(across.dot(p - axis.point), up.dot(p - axis.point));
    let reach = mesh.vertices.iter().map(|&p| flat(p).length()).fold(0.0, f64::max);
    let sector = std::f64::consts::TAU / SECTORS as f64;
    let seen = |triangle: &[u32; 3]| {
        let points = triangle.map(|v| flat(mesh.vertices[v as usize]));
        let sides = [0, 1, 2].map(|i| [points[i], points[(i + 1) % 3]].map(|p| p.extend(0.0)));
        if sides.iter().any(|side| segment_distance(*side, [DVec3::ZERO; 2]).distance < NEAR * reach) {
            return 0;
        }
        let start = points[0].to_angle();
        let turns = points.map(|p| points[0].angle_to(p));
        let (least, most) = turns.iter().fold((0.0f64, 0.0f64), |(l, m), &t| (l.min(t), m.max(t)));
        let first = ((start + least) / sector).floor() as i64;
        let last = ((start + most) / sector).floor() as i64;
        (first..=last).fold(0u128, |seen, i| seen | 1 << i.rem_euclid(SECTORS))
    };
    let seen = mesh.triangles.par_iter().map(seen).reduce(|| 0, |a, b| a | b);
    f64::from(seen.count_ones()) * sector
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parametric::wheel::{MeridianCurve, ParametricWheel};
    use glam::DVec2;

    /// Walls along the axis turn nearly about every diameter of a flat ring, and are more than what turns about its axis.
    #[test]
    fn a_diameter_of_a_flat_ring_is_not_its_axis() {
        for (height, wall_mm) in [(2.0, 0.5), (2.0, 2.0), (4.0, 0.5), (8.0, 1.0), (8.0, 2.0), (12.0, 0.5), (12.0, 5.0)]
        {
            let across = |x: f64| MeridianCurve::line(DVec2::new(x, 68.0), DVec2::new(x, 104.0));
            let thin = ParametricWheel {
                thickness_mm: 1.0,
                edge_thickness: 0.5,
                pieces: [100, 24, 4],
                ..ParametricWheel::nozzle_ring()
            };
            let ring = ParametricWheel { hub: across(0.0), shroud: across(height), wall_mm, ..thin };
            let first = candidates(&ring.mesh(), None)[0];
            let is_axis = first.direction.cross(DVec3::X).length() < 1e-3 && first.distance(DVec3::ZERO) < 0.1;
            assert!(is_axis, "{height} {wall_mm}: {first}");
        }
    }
}
