//! Cuts through heads along planes.

use glam::{DVec2, DVec3};
use serde::{Deserialize, Serialize};

use super::h_edge::HEdge;

/// How far a cut lies off the wall it goes along (mm), so that the two do not lie in one another.
pub(super) const OFF_WALL: f64 = 1e-4;
/// Further than any mold (mm).
pub(super) const FAR: f64 = 1e5;
/// Downward part of a normal up to which a face is cut along.
const STEEP: f64 = 0.5;
/// Downward part of a normal up to which a face is upright.
const UPRIGHT: f64 = 1e-6;
/// How far the ends of an edge may be off a plane to lie in it (mm).
pub(super) const ON_PLANE: f64 = 0.015;
/// How alike normals of faces are that are cut along at once (radians).
pub(super) const ALIKE: f64 = 2e-3;

/// A cut through a part along a plane, in the burn frame.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Cut {
    /// A point of the cut's plane (mm).
    pub through: DVec3,
    /// Unit normal, level or downwards: that of the near part's face in the plane.
    pub normal: DVec3,
    /// Height from which up the cut goes (mm), if it is slanted.
    pub low: f64,
    /// Whether parts beyond it reach back over it.
    pub overlaps: bool,
}

impl Cut {
    /// An upright cut through a point in plan (mm) with this unit normal.
    pub fn upright(through: DVec2, outward: DVec2, overlaps: bool) -> Self {
        Self { through: through.extend(0.0), normal: outward.extend(0.0), low: f64::NEG_INFINITY, overlaps }
    }

    /// The cut along a face of a tip through one of its points (mm); none where the face is not steep.
    pub(super) fn along(face: DVec3, through: DVec3) -> Option<Self> {
        let normal = if face.z.abs() < UPRIGHT { face.with_z(0.0).normalize_or_zero() } else { face };
        let is_steep = (-STEEP..=0.0).contains(&normal.z) && normal != DVec3::ZERO;
        is_steep.then_some(Self { through, normal, low: f64::NEG_INFINITY, overlaps: true })
    }

    /// This cut fitted to the inner edges of a tip that bound its face: from the lowest of their ends up, and through the
    /// end that lies furthest before the cut.
    pub(super) fn fitted(self, inner: &[HEdge]) -> Self {
        // Short edges of other faces may lie as near to it: through their ends the cut would go into its face.
        let is_its = |edge: &&HEdge| {
            let cuts = edge.normals.map(|n| Self::along(n, edge.ends[0]));
            self.holds(edge) && cuts.iter().flatten().any(|cut| cut.normal.distance(self.normal) < ALIKE)
        };
        let on: Vec<DVec3> = inner.iter().filter(is_its).flat_map(|edge| edge.ends).collect();
        let low = on.iter().map(|p| p.z).reduce(f64::min).unwrap_or(self.low);
        // The face is known to rounding: none of its edges stays before the cut.
        let first = on.iter().copied().min_by(|p, q| self.beyond(*p).total_cmp(&self.beyond(*q)));
        Self { through: first.unwrap_or(self.through), low, ..self }
    }

    /// Whether an edge lies in the cut's plane.
    pub(super) fn holds(&self, edge: &HEdge) -> bool {
        edge.ends.iter().all(|p| self.beyond(*p).abs() < ON_PLANE)
    }

    /// The angle by which the cut leans from upright (radians).
    pub fn slope(&self) -> f64 {
        (-self.normal.z).clamp(0.0, 1.0).asin()
    }

    /// Unit normal of the cut's lines in plan.
    pub fn outward(&self) -> DVec2 {
        self.normal.truncate().normalize_or_zero()
    }

    /// A point of the cut's line at a height (mm), in plan.
    pub(super) fn line(&self, height: f64) -> DVec2 {
        let across = self.normal.truncate().length();
        self.through.truncate() - self.outward() * self.normal.z / across * (height - self.through.z)
    }

    /// How far a point lies beyond the cut (mm), negative before it.
    pub(super) fn beyond(&self, p: DVec3) -> f64 {
        (p - self.through).dot(self.normal)
    }

    /// Everything beyond the cut between two heights, as corners of a convex body (mm).
    pub(super) fn all_beyond(&self, [low, high]: [f64; 2]) -> Vec<DVec3> {
        let along = self.outward().perp() * FAR;
        let at = |height: f64| {
            let line = self.line(height) - self.outward() * OFF_WALL;
            let far = self.line(high) + self.outward() * FAR;
            [line - along, line + along, far - along, far + along].map(|p| p.extend(height))
        };
        [at(low), at(high)].concat()
    }
}
