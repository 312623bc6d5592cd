//! Classes of interference: the reason why a flat cutter does not touch a place of a layer's outline (P3, sections 4.1.1
//! and 4.1.2).
//!
//! A cutter whose disc touches the outline at a place would reach into the material elsewhere. Where that is on the same
//! outline the paper calls it self-interference, local at a corner and global across a slot, and other-interference where
//! it is on another outline. As in the paper self-interference counts first.

use std::f64::consts::PI;

use glam::DVec2;
use serde::{Deserialize, Serialize};

use super::edge_grid::EdgeGrid;
use super::outline::{Outline, off_segment};

/// Angle by which an outline turns between two places that face each other, at least (rad): 150 degrees. A draft or a
/// taper of up to 30 degrees is still a slot.
const FACING: f64 = 5.0 / 6.0 * PI;
/// Depth to which the disc may reach into the material, as a share of its radius: facets and rounding.
const ALLOWED: f64 = 1e-5;
/// Parts of the radius at which a run is looked at, and parts of one side at most.
const STEPS: (f64, f64) = (8.0, 256.0);
/// How far off a run its outline may lie, as a share of the radius: runs of the height map are less exact than outlines.
const BESIDE: f64 = 0.1;

/// A class of interference.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Interference {
    /// With the same outline around a corner that is sharper than the cutter.
    Local,
    /// With the same outline, which comes back nearer than a diameter.
    Global,
    /// With another outline of the layer.
    Other,
    /// With nothing in the layer: a holder, or the rounded end of a cutter, keeps it off.
    OffLayer,
}

impl Interference {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Local, Self::Global, Self::Other, Self::OffLayer];

    /// The class of the greatest of these lengths, in the order of [`Self::ALL`]; of equal ones the first.
    pub fn of_most(lengths: &[f64; 4]) -> Self {
        let longer =
            |best: Self, class: Self| if lengths[class as usize] > lengths[best as usize] { class } else { best };
        Self::ALL.into_iter().fold(Self::Local, longer)
    }

    /// Name in files.
    pub fn key(self) -> &'static str {
        match self {
            Self::Local => "local",
            Self::Global => "global",
            Self::Other => "other",
            Self::OffLayer => "off-layer",
        }
    }

    /// Name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Local => "self, local",
            Self::Global => "self, global",
            Self::Other => "other",
            Self::OffLayer => "none in the layer",
        }
    }
}

/// The outlines of a layer, ready to tell the interference of a cutter with them.
pub struct LayerInterference {
    radius: f64,
    sides: Vec<[DVec2; 2]>,
    /// Of each side the first side of its outline and their number.
    outline: Vec<[usize; 2]>,
    /// Length and turn to the right of an outline up to the beginning of each side (mm, rad), its corner included.
    along: Vec<[f64; 2]>,
    /// Length and turn of the outline of each side (mm, rad).
    whole: Vec<[f64; 2]>,
    grid: EdgeGrid,
}

impl LayerInterference {
    /// Interference of a flat cutter of `radius` (mm) with `outlines`, whose material lies on the left.
    pub fn new(outlines: &[Outline], radius: f64) -> Self {
        let (mut sides, mut outline, mut along, mut whole) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        for one in outlines {
            let (first, own): (usize, Vec<[DVec2; 2]>) = (sides.len(), one.sides().collect());
            let [mut length, mut turn] = [0.0; 2];
            for (i, [a, b]) in own.iter().enumerate() {
                let [before, from] = own[(i + own.len() - 1) % own.len()];
                turn -= (from - before).angle_to(*b - *a);
                along.push([length, turn]);
                length += a.distance(*b);
            }
            outline.extend(own.iter().map(|_| [first, own.len()]));
            whole.extend(own.iter().map(|_| [length, turn]));
            sides.extend(own);
        }
        let grid = EdgeGrid::new(&sides, radius);
        Self { radius, sides, outline, along, whole, grid }
    }

    /// Length of each class along `run`, in the order of [`Interference::ALL`] (mm).
    pub fn lengths(&self, run: &[DVec2]) -> [f64; 4] {
        let mut lengths = [0.0; 4];
        for ends in run.windows(2) {
            let length = ends[0].distance(ends[1]);
            let steps = (STEPS.0 * length / self.radius).ceil().clamp(1.0, STEPS.1) as usize;
            for k in 0..steps {
                let p = ends[0].lerp(ends[1], (k as f64 + 0.5) / steps as f64);
                lengths[self.at(p) as usize] += length / steps as f64;
            }
        }
        lengths
    }

    /// The class at a place of an outline.
    pub fn at(&self, p: DVec2) -> Interference {
        let mut near = Vec::new();
        let reach = BESIDE * self.radius;
        self.grid.near(p, p, reach, &mut near);
        let off = |side: usize, p: DVec2| off_segment(p, self.sides[side][0], self.sides[side][1]);
        let sides = near.iter().map(|side| *side as usize);
        let Some(own) = sides.min_by(|a, b| off(*a, p).total_cmp(&off(*b, p))).filter(|s| off(*s, p) <= reach) else {
            return Interference::OffLayer;
        };
        let [a, b] = self.sides[own];
        // The material is on the left.
        let centre = p - (b - a).normalize_or_zero().perp() * self.radius;
        self.grid.near(centre, centre, self.radius, &mut near);
        let is_met = |side: &usize| *side != own && off(*side, centre) < (1.0 - ALLOWED) * self.radius;
        let met: Vec<usize> = near.iter().map(|side| *side as usize).filter(is_met).collect();
        let same = met.iter().copied().filter(|side| self.outline[*side] == self.outline[own]);
        let nearest = same.map(|side| self.between(own, side)).min_by(|a, b| a.0.total_cmp(&b.0));
        match nearest {
            Some((_, turn)) if turn > 0.0 && turn < FACING => Interference::Local,
            Some(_) => Interference::Global,
            None if met.is_empty() => Interference::OffLayer,
            None => Interference::Other,
        }
    }

    /// Length of the shorter way between two sides of one outline, and by how much it turns to the right (mm, rad).
    fn between(&self, a: usize, b: usize) -> (f64, f64) {
        let (first, last) = (a.min(b), a.max(b));
        let side = |i: usize| self.sides[i][0].distance(self.sides[i][1]);
        let [length, turn] = self.whole[first];
        let gap = self.along[last][0] - self.along[first][0] - side(first);
        let around = length - gap - side(first) - side(last);
        let turned = self.along[last][1] - self.along[first][1];
        if gap <= around { (gap, turned) } else { (around, turn - turned) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixtures::{polygon, rectangle};
    use crate::uncut_layer::uncut_pieces;

    fn outline(points: Vec<DVec2>) -> Outline {
        Outline::new(points).unwrap()
    }

    /// A block of 60 mm with a pocket.
    fn block(pocket: Vec<DVec2>) -> Vec<Outline> {
        vec![outline(rectangle(60.0, 60.0)), outline(pocket.into_iter().rev().collect())]
    }

    fn lengths(outlines: &[Outline], radius: f64) -> [f64; 4] {
        let of = LayerInterference::new(outlines, radius);
        let pieces = uncut_pieces(outlines, radius, 1e-3);
        let runs = pieces.iter().flat_map(|piece| &piece.segments).map(|run| of.lengths(run));
        runs.fold([0.0; 4], |sum, one| std::array::from_fn(|k| sum[k] + one[k]))
    }

    /// P3, figure 10a: two radii at each corner, all of them local.
    #[test]
    fn corners_are_local() {
        for turned in [0.0, 0.7] {
            let spin = |p: &DVec2| DVec2::from_angle(turned).rotate(*p);
            let [local, rest @ ..] = lengths(&block(rectangle(20.0, 12.0).iter().map(spin).collect()), 1.5);
            assert!((local - 12.0).abs() < 1e-6 && rest == [0.0; 3], "{local} {rest:?}");
        }
    }

    /// P3, figure 10b: the sides of a slot are global but within a radius of its ends.
    #[test]
    fn slots_are_global_but_for_their_ends() {
        let (long, wide, radius) = (20.0, 1.6, 1.0);
        let [local, global, other, off] = lengths(&block(rectangle(long, wide)), radius);
        let exact = 2.0 * (long - 2.0 * radius);
        assert!((global - exact).abs() < 0.3 && other == 0.0 && off == 0.0, "{global} {exact}");
        assert!((local + global - 2.0 * (long + wide)).abs() < 1e-6, "{local}");
    }

    /// P3, figure 14: two round islands. The cutter between them touches both, and what is left is an arc of either.
    #[test]
    fn islands_interfere_with_each_other() {
        let (island, apart, radius) = (3.0, 7.0, 2.0);
        let round = |x: f64| outline(polygon(720, island).into_iter().map(|p| p + DVec2::new(x, 0.0)).collect());
        let islands = [round(-0.5 * apart), round(0.5 * apart)];
        let [local, global, other, off] = lengths(&islands, radius);
        let half = (0.5 * apart / (island + radius)).acos();
        let exact = 4.0 * island * half;
        assert!((other / exact - 1.0).abs() < 0.01, "{other} {exact}");
        assert_eq!([local, global, off], [0.0; 3]);
        // Further apart than a diameter the cutter passes.
        assert!(lengths(&[round(-9.0), round(9.0)], radius).iter().all(|length| *length == 0.0));
    }

    #[test]
    fn what_nothing_in_the_layer_is_in_the_way_of_is_said_to_be() {
        let of = LayerInterference::new(&block(rectangle(20.0, 12.0)), 1.0);
        let at = |x: f64, y: f64| of.at(DVec2::new(x, y));
        assert_eq!(
            [at(0.0, 6.0), at(5.0, 0.0), at(9.9, 6.0)],
            [Interference::OffLayer, Interference::OffLayer, Interference::Local]
        );
    }
}
