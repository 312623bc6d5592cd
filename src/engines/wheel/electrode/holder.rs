//! The holder block of an electrode, and the plane frame that joins the end of the shank to it.

use glam::{DVec2, DVec3};

use super::ring::Layout;
use super::{ElectrodeParams, EntrySide};

/// By how much the holder block is larger than the shank at least (mm).
const MARGIN: f64 = 1.0;
/// Least distance of neighbouring points on a side of the block, as a share of their mean distance.
const LEAST_SPACING: f64 = 0.2;

/// The rectangle of the holder block around the end of the shank, its corners at the shank's corners.
pub(super) struct Block {
    /// Middle, with no part along the direction of withdrawal (mm).
    center: DVec3,
    /// Unit vectors across the passage, towards greater theta, and from the hub to the shroud.
    axes: [DVec3; 2],
    /// Size along both (mm).
    size: [f64; 2],
    /// Where the points of the shank's sides are joined to those of the block, as shares of these: of the hub side and
    /// the shroud side from the low wall, of the low and the high wall from the hub.
    shares: [Vec<f64>; 4],
    layout: Layout,
}

impl Block {
    /// Around the end of a shank, whose `outline` is without its part along the direction of withdrawal: along the axes
    /// of W, or turned with the shank where the frame to it would fold over itself otherwise.
    pub(super) fn around(
        outline: &[DVec3],
        (side, layout): (EntrySide, Layout),
        params: &ElectrodeParams,
        assumed: &mut Vec<String>,
    ) -> Self {
        // Theta grows towards -Y.
        let rise = (outline[layout.shroud(0)] - outline[layout.hub(0)]).x.signum();
        let upright = match side {
            EntrySide::MinusX | EntrySide::PlusX => DVec3::Z,
            EntrySide::Outward | EntrySide::Inward => DVec3::X * rise,
        };
        let mut block = Self::along([DVec3::NEG_Y, upright], outline, layout, params);
        if !block.joined(outline) {
            let side_of = |on: &dyn Fn(usize) -> usize| outline[on(0)] + outline[on(layout.columns)];
            let up = side_of(&|j| layout.shroud(j)) - side_of(&|j| layout.hub(j));
            let turned = up.try_normalize().map(|up| {
                let normal = DVec3::NEG_Y.cross(upright);
                Self::along([up.cross(normal), up], outline, layout, params)
            });
            let turned = turned.and_then(|mut turned| turned.joined(outline).then_some(turned));
            match turned {
                Some(turned) => {
                    let angle = upright.angle_between(turned.axes[1]).to_degrees();
                    assumed.push(format!("The holder block is turned by {angle:.0} deg, as the end of the shank is."));
                    block = turned;
                }
                None => assumed.push("The frame between the shank and the holder block folds over itself.".to_owned()),
            }
        }
        let [_, width, height] = params.holder_mm;
        let [w, h] = block.size;
        if w > width || h > height {
            assumed.push(format!(
                "The holder block is {w:.1} x {h:.1} mm instead of {width:.1} x {height:.1} mm, to hold the shank."
            ));
        }
        block
    }

    /// Along `axes`, its points evenly spaced on every side.
    fn along(axes: [DVec3; 2], outline: &[DVec3], layout: Layout, params: &ElectrodeParams) -> Self {
        let [_, width, height] = params.holder_mm;
        let bounds = axes.map(|axis| {
            let places = outline.iter().map(|p| p.dot(axis));
            places.fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], s| [a.min(s), b.max(s)])
        });
        let middle = bounds.map(|[least, most]| (least + most) * 0.5);
        let needed = bounds.map(|[least, most]| most - least + 2.0 * MARGIN);
        let evenly = |n: usize| (0..=n).map(|k| k as f64 / n as f64).collect::<Vec<_>>();
        let (columns, rows) = (evenly(layout.columns), evenly(layout.rows));
        Self {
            center: axes[0] * middle[0] + axes[1] * middle[1],
            axes,
            size: [width.max(needed[0]), height.max(needed[1])],
            shares: [columns.clone(), columns, rows.clone(), rows],
            layout,
        }
    }

    /// Middle, with no part along the direction of withdrawal (mm).
    pub(super) fn center(&self) -> DVec3 {
        self.center
    }

    /// How far the block reaches along `axis` on both sides of its middle (mm).
    pub(super) fn reach(&self, axis: DVec3) -> f64 {
        let [across, up] = [0, 1].map(|k| self.size[k] * self.axes[k].dot(axis).abs());
        0.5 * (across + up)
    }

    /// The ring of the block, without its part along the direction of withdrawal (mm).
    pub(super) fn ring(&self) -> Vec<DVec3> {
        let [w, h] = self.size;
        let corner = |across: f64, upwards: f64| {
            self.center + self.axes[0] * (0.5 * w * across) + self.axes[1] * (0.5 * h * upwards)
        };
        let mut ring = vec![DVec3::ZERO; self.layout.len()];
        let [hub, shroud, low, high] = self.shares.each_ref().map(|shares| shares.iter().map(|s| 2.0 * s - 1.0));
        hub.enumerate().for_each(|(j, across)| ring[self.layout.hub(j)] = corner(across, -1.0));
        shroud.enumerate().for_each(|(j, across)| ring[self.layout.shroud(j)] = corner(across, 1.0));
        low.enumerate().for_each(|(v, upwards)| ring[self.layout.low(v)] = corner(-1.0, upwards));
        high.enumerate().for_each(|(v, upwards)| ring[self.layout.high(v)] = corner(1.0, upwards));
        ring
    }

    /// Moves the points of the block's ring, where needed, along its sides to where the frame does not fold over itself;
    /// false if there are no such places.
    fn joined(&mut self, outline: &[DVec3]) -> bool {
        if !self.is_folded(outline) {
            return true;
        }
        let (ring, layout) = (self.ring(), self.layout);
        let flat = |p: DVec3| DVec2::new(p.dot(self.axes[0]), p.dot(self.axes[1]));
        let side = |count: usize, on: &dyn Fn(usize) -> usize, sense: f64| {
            let points: Vec<DVec2> = (0..=count).map(|k| flat(outline[on(k)])).collect();
            seen_from(&points, [0, count].map(|k| flat(ring[on(k)])), sense)
        };
        let Layout { rows, columns } = layout;
        let sides = [
            side(columns, &|j| layout.hub(j), 1.0),
            side(columns, &|j| layout.shroud(j), -1.0),
            side(rows, &|v| layout.low(v), -1.0),
            side(rows, &|v| layout.high(v), 1.0),
        ];
        let [Some(hub), Some(shroud), Some(low), Some(high)] = sides else { return false };
        let before = std::mem::replace(&mut self.shares, [hub, shroud, low, high]);
        let is_folded = self.is_folded(outline);
        if is_folded {
            self.shares = before;
        }
        !is_folded
    }

    /// Whether a face of the frame lies over others, however it is cut in two.
    fn is_folded(&self, outline: &[DVec3]) -> bool {
        let (ring, n) = (self.ring(), outline.len());
        let normal = self.axes[0].cross(self.axes[1]);
        let area = |a: DVec3, b: DVec3, c: DVec3| (b - a).cross(c - a).dot(normal);
        (0..n).any(|k| {
            let [a, b, c, d] = [outline[k], outline[(k + 1) % n], ring[(k + 1) % n], ring[k]];
            // The ring runs counter-clockwise, and the frame is on its right.
            let is_cut = |faces: [f64; 2]| faces.iter().all(|area| *area < 0.0);
            !is_cut([area(a, b, c), area(a, c, d)]) && !is_cut([area(a, b, d), area(b, c, d)])
        })
    }
}

/// Shares of the line between `ends`, rising, at which the points of a side of the shank are joined to it: as evenly as can
/// be where each lies outside of both stretches of the side beside its point. The outside is on the right of the side where
/// `sense` is 1, on the left where it is -1; none if there are no such shares.
fn seen_from(side: &[DVec2], [from, to]: [DVec2; 2], sense: f64) -> Option<Vec<f64>> {
    let last = side.len() - 1;
    let spacing = LEAST_SPACING / last as f64;
    let (mut least, mut most) = (vec![0.0f64; last + 1], vec![1.0f64; last + 1]);
    for i in 1..last {
        least[i] = least[i - 1] + spacing;
        for pair in side[i - 1..=i + 1].windows(2) {
            let outside = |p: DVec2| -sense * (pair[1] - pair[0]).perp_dot(p - pair[0]);
            let [a, b] = [from, to].map(outside);
            let crossing = a / (a - b);
            match (a > 0.0, b > 0.0) {
                (true, true) => {}
                (false, true) => least[i] = least[i].max(crossing + spacing),
                (true, false) => most[i] = most[i].min(crossing - spacing),
                (false, false) => return None,
            }
        }
    }
    for i in (1..last).rev() {
        most[i] = most[i].min(most[i + 1] - spacing);
    }
    let mut shares = vec![0.0f64; last + 1];
    for i in 1..last {
        if least[i] > most[i] {
            return None;
        }
        shares[i] = (i as f64 / last as f64).clamp(least[i], most[i]).max(shares[i - 1] + spacing);
    }
    shares[last] = 1.0;
    Some(shares)
}

#[cfg(test)]
mod tests {
    use super::*;

    const LAYOUT: Layout = Layout { rows: 12, columns: 16 };

    /// The outline of a shank with straight sides between its corners: hub side from the low to the high wall, shroud side
    /// back.
    fn outline(corners: [DVec3; 4]) -> Vec<DVec3> {
        let side = |k: usize| {
            let count = [LAYOUT.columns, LAYOUT.rows][k % 2];
            (0..count).map(move |i| corners[k].lerp(corners[(k + 1) % 4], i as f64 / count as f64))
        };
        (0..4).flat_map(side).collect()
    }

    /// Area of all faces of the frame, however they lie, over the area between the block's ring and the shank (mm^2).
    fn covered(outline: &[DVec3], block: &Block) -> f64 {
        let (ring, n) = (block.ring(), outline.len());
        let area = |[a, b, c]: [DVec3; 3]| 0.5 * (b - a).cross(c - a).length();
        let of_face = |k: usize| {
            let [a, b, c, d] = [outline[k], outline[(k + 1) % n], ring[(k + 1) % n], ring[k]];
            let [one, other] = [area([a, b, c]) + area([a, c, d]), area([a, b, d]) + area([b, c, d])];
            one.min(other)
        };
        let within = |ring: &[DVec3]| 0.5 * (0..n).map(|k| ring[k].cross(ring[(k + 1) % n])).sum::<DVec3>().length();
        (0..n).map(of_face).sum::<f64>() / (within(&ring) - within(outline))
    }

    fn around(outline: &[DVec3], side: EntrySide) -> (Block, Vec<String>) {
        let mut assumed = Vec::new();
        let params = ElectrodeParams::default();
        (Block::around(outline, (side, LAYOUT), &params, &mut assumed), assumed)
    }

    #[test]
    fn a_shank_along_the_axes_has_its_block_along_them_with_even_points() {
        let corners = [[0.0, 6.0, 60.0], [0.0, -5.0, 60.0], [0.0, -7.0, 70.0], [0.0, 7.0, 70.0]].map(DVec3::from);
        let outline = outline(corners);
        let (block, assumed) = around(&outline, EntrySide::PlusX);
        assert!((covered(&outline, &block) - 1.0).abs() < 1e-9);
        assert_eq!((block.axes, block.size, assumed.len()), ([DVec3::NEG_Y, DVec3::Z], [20.0, 24.0], 0));
        assert!(block.shares.iter().flat_map(|s| s.windows(2)).all(|pair| (pair[1] - pair[0]) * 12.0 < 1.0 + 1e-9));
    }

    /// The corners of a closed impeller's shank at the rim: two walls meet the hub side there at 20 and at 160 degrees.
    #[test]
    fn the_frame_of_a_leaning_shank_does_not_fold() {
        let corners = [[-0.5, 90.5], [-0.5, 43.7], [-12.3, 76.5], [-12.6, 100.0]].map(|[x, y]| DVec3::new(x, y, 0.0));
        let outline = outline(corners);
        let (block, assumed) = around(&outline, EntrySide::Outward);
        assert!((covered(&outline, &block) - 1.0).abs() < 1e-9, "{}", covered(&outline, &block));
        assert_eq!(block.axes, [DVec3::NEG_Y, DVec3::NEG_X], "{assumed:?}");
    }

    /// The corners of its shank in the eye, where the passage has wound far about the axis.
    #[test]
    fn the_block_of_a_shank_far_from_the_top_is_turned_with_it() {
        let corners = [[-18.7, 1.4], [-14.7, -11.7], [-19.6, -36.1], [-40.7, -5.3]].map(|[y, z]| DVec3::new(0.0, y, z));
        let outline = outline(corners);
        let (block, assumed) = around(&outline, EntrySide::MinusX);
        assert!((covered(&outline, &block) - 1.0).abs() < 1e-9, "{}", covered(&outline, &block));
        assert!(assumed[0].starts_with("The holder block is turned by 1"), "{assumed:?}");
        let [a, b] = [block.axes[0].dot(block.axes[1]), block.axes[0].cross(block.axes[1]).dot(DVec3::NEG_X)];
        assert!(a.abs() < 1e-9 && (b.abs() - 1.0).abs() < 1e-9, "{a} {b}");
        // It holds the shank.
        for axis in [DVec3::Y, DVec3::Z] {
            assert!(outline.iter().all(|p| (p - block.center).dot(axis).abs() < block.reach(axis)));
        }
    }
}
