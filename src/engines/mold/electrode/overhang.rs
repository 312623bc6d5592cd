//! Samples of a region's surface beside what hangs over it.
//!
//! Regions are known to cells. Beside what is undercut some of their surface seems to lie under it, where cutters leave
//! nothing of theirs; and no head reaches the last gap's width before it, where most is left just at the border.

use std::f64::consts::TAU;

use glam::{DMat3, DVec2, DVec3};
use rayon::prelude::*;

use super::clearance::Obstacle;
use super::residual_stock::{BESIDE, Sample};
use crate::invert::{DOWNWARDS, InvertFaces};
use geometry::mesh::{Bounds, Mesh};

/// Directions around a sample in which a border is looked for, and how far, in cells.
const AROUND: (usize, f64) = (8, 3.0);
/// Halvings of the way to a border.
const HALVINGS: usize = 20;
/// How far a place may lie off the mold's surface to be on it (mm).
const ON_SURFACE: f64 = 1e-5;

/// What looks away from the opening of an upright mold.
pub(super) struct Overhangs {
    faces: Vec<Bounds>,
    /// Height of the mold's top (mm).
    top: f64,
}

impl Overhangs {
    /// The overhangs of an upright mold.
    pub fn of(mold: &Mesh) -> Self {
        let faces = InvertFaces::of(mold).triangles;
        let faces = faces.into_iter().map(|face| Bounds::of(mold.corners(face as usize))).collect();
        Self { faces, top: mold.bounds().max.z }
    }

    /// Of samples of a region those that overhangs do not hide, and more at the borders of overhangs. `turned` is the
    /// rotation from the upright mold to the frame of the samples, in which the `mold` is; the region is known to a
    /// `cell` (mm).
    pub fn without_hidden(&self, samples: Vec<Sample>, (mold, turned): (&Obstacle, &DMat3), cell: f64) -> Vec<Sample> {
        let (back, reach) = (turned.transpose(), AROUND.1 * cell);
        let all = Bounds::of(samples.iter().map(|sample| back * sample.point));
        let beside = |face: &Bounds, of: &Bounds| {
            let (low, high) = (of.min - reach, of.max + reach);
            let in_plan = face.min.cmple(high).bitmask() & low.cmple(face.max).bitmask() & 0b11;
            in_plan == 0b11 && face.max.z >= of.min.z
        };
        let faces: Vec<&Bounds> = self.faces.iter().filter(|face| beside(face, &all)).collect();
        if faces.is_empty() {
            return samples;
        }
        let of = |sample: Sample| {
            let own = Bounds::of([back * sample.point]);
            let is_near = faces.iter().any(|face| beside(face, &own));
            if is_near { self.beside((mold, *turned), sample, reach) } else { vec![sample] }
        };
        samples.into_par_iter().map(of).collect::<Vec<_>>().concat()
    }

    /// A sample that is not hidden, and a border within reach (mm) of it.
    fn beside(&self, (mold, turned): (&Obstacle, DMat3), sample: Sample, reach: f64) -> Vec<Sample> {
        let opening = turned * DVec3::Z;
        // Faces that lean over by less than undercut ones do are walls.
        let off = BESIDE - DOWNWARDS * (self.top - sample.point.dot(opening)).max(0.0);
        let is_open = |p: DVec3| !mold.is_hidden(p + sample.normal * off, opening);
        let around = |i: usize| turned * (DVec2::from_angle(i as f64 * TAU / AROUND.0 as f64) * reach).extend(0.0);
        let mut around = (0..AROUND.0).map(around);
        if !is_open(sample.point) {
            // Far under an overhang it is none of the grid's doing.
            let is_at_border = around.any(|shift| is_open(sample.point + shift));
            return if is_at_border { Vec::new() } else { vec![sample] };
        }
        let border = |shift: DVec3| {
            // Along the face.
            let shift = shift - sample.normal * shift.dot(sample.normal);
            let is_hidden = |t: f64| {
                let p = sample.point + shift * t;
                mold.distance(p) <= ON_SURFACE && !is_open(p)
            };
            is_hidden(1.0).then(|| {
                let (mut open, mut hidden) = (0.0, 1.0);
                for _ in 0..HALVINGS {
                    let middle = 0.5 * (open + hidden);
                    *(if is_hidden(middle) { &mut hidden } else { &mut open }) = middle;
                }
                sample.point + shift * open
            })
        };
        let nearest = around.filter_map(border).min_by(|p, q| {
            let off = |p: &DVec3| p.distance_squared(sample.point);
            off(p).total_cmp(&off(q))
        });
        // It stands for no area.
        let border = nearest.map(|point| Sample { point, area: 0.0, ..sample });
        std::iter::once(sample).chain(border).collect()
    }
}
