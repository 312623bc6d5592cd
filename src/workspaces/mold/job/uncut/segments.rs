//! Uncut segments of all layers as runs of points.

use std::collections::HashMap;

use glam::DVec3;
use rayon::prelude::*;

use super::Uncut;
use geometry::mesh::Mesh;
use mold::cutter::{Cutter, CutterKind};
use mold::interference::{Interference, LayerInterference};
use mold::invert::Shadows;
use mold::section::sections;
use mold::surface::segments_at;
use task::{Cancel, Cancelled};

/// Distance within which ends of segments are one point (mm): rounding.
const SAME: f64 = 1e-5;
/// Distance from the line between its neighbours up to which a point is left out (mm).
const STRAIGHT: f64 = 1e-6;

/// A run of a layer's outline that no cutter touches.
#[derive(Debug, Clone, PartialEq)]
pub struct SegmentRun {
    /// Layer: its index in [`Uncut::layers`].
    pub layer: usize,
    /// Region: its index in [`Uncut::regions`].
    pub region: usize,
    /// Points of the run at the height of the layer, upright (mm); of a closed run the first is the last as well.
    pub points: Vec<DVec3>,
}

impl SegmentRun {
    /// Length of the run (mm).
    pub fn length(&self) -> f64 {
        self.points.windows(2).map(|ends| ends[0].distance(ends[1])).sum()
    }
}

/// A run with the interference that leaves it.
#[derive(Debug, Clone, PartialEq)]
pub struct ClassedRun {
    /// The run.
    pub run: SegmentRun,
    /// Length of each class of interference along the run (mm), in the order of [`Interference::ALL`].
    pub lengths: [f64; 4],
}

impl ClassedRun {
    /// The class of most of its length.
    pub fn class(&self) -> Interference {
        Interference::of_most(&self.lengths)
    }
}

impl Uncut {
    /// The runs of [`Self::segment_runs`] with the interference of the smallest flat cutter that leaves them, as in P3; of
    /// the smallest cutter where none is flat. `mesh` is the mold.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn classed_runs(&self, mesh: &Mesh, cancel: &Cancel) -> Result<Vec<ClassedRun>, Cancelled> {
        let upright = self.params.opening.upright_mesh(mesh);
        let heights: Vec<f64> = self.layers.iter().map(|layer| layer.z).collect();
        let mut sections = sections(&upright, &heights, cancel)?;
        Shadows::new(&upright).cast(&mut sections, cancel)?;
        let needed = self.params.library.needed();
        let least = |of: &mut dyn Iterator<Item = &&Cutter>| of.map(|c| c.radius()).fold(f64::INFINITY, f64::min);
        let flat = least(&mut needed.iter().filter(|c| c.kind() == CutterKind::Flat));
        let radius = if flat.is_finite() { flat } else { least(&mut needed.iter()) };
        let runs = self.segment_runs();
        let of_layer = |own: &[SegmentRun]| {
            cancel.check()?;
            let of = LayerInterference::new(&sections[own[0].layer].outlines, radius);
            let classed = |run: &SegmentRun| {
                let points: Vec<_> = run.points.iter().map(|p| p.truncate()).collect();
                ClassedRun { lengths: of.lengths(&points), run: run.clone() }
            };
            Ok(own.iter().map(classed).collect())
        };
        let layers: Vec<&[SegmentRun]> = runs.chunk_by(|a, b| a.layer == b.layer).collect();
        let classed: Vec<Vec<ClassedRun>> = layers.into_par_iter().map(of_layer).collect::<Result<_, _>>()?;
        Ok(classed.into_iter().flatten().collect())
    }

    /// Uncut segments of all layers, by layer and then by region: exact where only flat cutters count, else as fine as
    /// the surface is split.
    pub fn segment_runs(&self) -> Vec<SegmentRun> {
        let runs: Vec<Vec<SegmentRun>> =
            if self.is_of_flats() { self.runs_of_pieces() } else { self.runs_of_surface() };
        runs.into_iter().flatten().collect()
    }

    fn runs_of_pieces(&self) -> Vec<Vec<SegmentRun>> {
        let mut runs = vec![Vec::new(); self.layers.len()];
        for (region, &[layer, i]) in
            self.regions.iter().enumerate().flat_map(|(n, r)| r.pieces.iter().map(move |p| (n, p)))
        {
            let of_layer = &self.stack.layers[layer];
            runs[layer].extend(of_layer.pieces[i].segments.iter().filter(|run| run.len() > 1).map(|run| SegmentRun {
                layer,
                region,
                points: run.iter().map(|p| p.extend(of_layer.z)).collect(),
            }));
        }
        runs
    }

    fn runs_of_surface(&self) -> Vec<Vec<SegmentRun>> {
        let heights: Vec<f64> = self.layers.iter().map(|layer| layer.z).collect();
        let mut crossing = vec![Vec::new(); heights.len()];
        for piece in &self.surface {
            let [low, high] = piece.span();
            let layers = heights.partition_point(|z| *z < low)..heights.partition_point(|z| *z <= high);
            layers.for_each(|layer| crossing[layer].push(*piece));
        }
        let of_layer = |(layer, mut pieces): (usize, Vec<_>)| -> Vec<SegmentRun> {
            pieces.sort_by_key(|piece: &mold::surface::SurfacePiece| piece.region);
            let of_region = pieces.chunk_by(|a, b| a.region == b.region).flat_map(|own| {
                let segments = segments_at(own, heights[layer]).into_iter().map(|(_, ends)| ends);
                let region = own[0].region as usize;
                joined(segments).into_iter().map(move |points| SegmentRun { layer, region, points })
            });
            of_region.collect()
        };
        crossing.into_par_iter().enumerate().map(of_layer).collect()
    }
}

/// Segments of one layer joined end to end, without points on straight lines.
fn joined(segments: impl Iterator<Item = [DVec3; 2]>) -> Vec<Vec<DVec3>> {
    let (mut points, mut numbers) = (Vec::new(), HashMap::new());
    let mut number = |p: DVec3| {
        *numbers.entry((p.truncate() / SAME).round().as_i64vec2()).or_insert_with(|| {
            points.push(p);
            points.len() - 1
        })
    };
    let sides: Vec<[usize; 2]> = segments.map(|ends| ends.map(&mut number)).filter(|[a, b]| a != b).collect();
    let mut at: Vec<Vec<usize>> = vec![Vec::new(); points.len()];
    sides.iter().enumerate().for_each(|(side, ends)| ends.iter().for_each(|end| at[*end].push(side)));
    let mut is_used = vec![false; sides.len()];
    let ends = (0..points.len()).filter(|p| at[*p].len() != 2);
    // What has no end is closed, and begins anywhere.
    let begins: Vec<usize> = ends.chain((0..points.len()).filter(|p| at[*p].len() == 2)).collect();
    let mut runs = Vec::new();
    for begin in begins {
        while let Some(first) = at[begin].iter().copied().find(|side| !is_used[*side]) {
            let (mut run, mut here, mut next) = (vec![points[begin]], begin, Some(first));
            while let Some(side) = next {
                is_used[side] = true;
                here = if sides[side][0] == here { sides[side][1] } else { sides[side][0] };
                run.push(points[here]);
                next = at[here].iter().copied().find(|side| at[here].len() == 2 && !is_used[*side]);
            }
            runs.push(bent(&run));
        }
    }
    runs
}

/// A run without the points that lie on the line between their neighbours.
fn bent(run: &[DVec3]) -> Vec<DVec3> {
    let mut kept = vec![run[0]];
    for ends in run.windows(3) {
        let (from, along) = (kept[kept.len() - 1], ends[2] - kept[kept.len() - 1]);
        let off = (ends[1] - from).reject_from(along);
        let is_between = (ends[1] - from).dot(along) <= along.length_squared();
        if !(along.length() > 0.0 && is_between && off.length() <= STRAIGHT) {
            kept.push(ends[1]);
        }
    }
    kept.extend(run.last());
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn segments_become_runs_whichever_way_they_lie() {
        let [a, b, c, d] = [(0.0, 0.0), (1.0, 0.0), (2.0, 0.0), (2.0, 3.0)].map(|(x, y)| DVec3::new(x, y, 5.0));
        let off = DVec3::X * 1e-9;
        // An open run with a point on its way, and a closed one elsewhere.
        let square =
            [DVec3::ZERO, DVec3::X, DVec3::new(1.0, 1.0, 0.0), DVec3::Y].map(|p| p + DVec3::new(9.0, 9.0, 5.0));
        let around = (0..4).map(|i| [square[i], square[(i + 1) % 4]]);
        let runs = joined([[c, b + off], [a, b], [c, d], [d, d]].into_iter().chain(around));
        assert_eq!(runs, [vec![a, c, d], vec![square[0], square[1], square[2], square[3], square[0]]]);
        assert!(joined(std::iter::empty()).is_empty());
    }
}
