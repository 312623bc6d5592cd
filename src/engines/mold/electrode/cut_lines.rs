//! Lines that show where a part is cut.

use glam::{DVec2, DVec3};

use super::design::PartNode;

/// How far on both sides of a cut the part has to be for the cut to go through it (mm): faces are known to this.
const BESIDE: f64 = 0.02;

impl PartNode {
    /// Where the cut goes through the head, as polylines in the burn frame (mm): a line at the height of the cap, or the
    /// closed outline of the piece of a slanted plane down to where the cut begins. None for a part that is not divided.
    pub fn cut_lines(&self) -> Vec<Vec<DVec3>> {
        let Some(cut) = self.cut else { return Vec::new() };
        let [low, cap] = self.heights;
        let (through, outward) = (cut.line(cap), cut.outward());
        // Along a wall that the cut goes on from there is no head on one of its sides.
        let [before, beyond] = [-BESIDE, BESIDE].map(|off| spans(&self.outlines, through + off * outward, outward));
        let both = |a: &[f64; 2], b: &[f64; 2]| [a[0].max(b[0]), a[1].min(b[1])];
        let cut_through = before.iter().flat_map(|a| beyond.iter().map(move |b| both(a, b)));
        let is_slanted = cut.normal.z < 0.0;
        let from = if cut.low < cap { cut.low.max(low) } else { low };
        let down = (cut.line(from) - through).extend(from - cap);
        let line = |span: [f64; 2]| {
            let [a, b] = span.map(|t| (through + t * outward.perp()).extend(cap));
            if is_slanted { vec![a, b, b + down, a + down, a] } else { vec![a, b] }
        };
        cut_through.filter(|[a, b]| b - a > BESIDE).map(line).collect()
    }
}

/// Where a line in plan lies within outlines and holes, as distances from the point that it goes through (mm), along its
/// normal turned by a quarter.
fn spans(outlines: &[Vec<DVec2>], through: DVec2, normal: DVec2) -> Vec<[f64; 2]> {
    let off = |p: DVec2| (p - through).dot(normal);
    let crossing = |(a, b): (&DVec2, &DVec2)| {
        let (from, to) = (off(*a), off(*b));
        ((from < 0.0) != (to < 0.0)).then(|| (a.lerp(*b, from / (from - to)) - through).dot(normal.perp()))
    };
    let sides = outlines.iter().flat_map(|points| points.iter().zip(points.iter().cycle().skip(1)));
    let mut crossings: Vec<f64> = sides.filter_map(crossing).collect();
    crossings.sort_by(f64::total_cmp);
    crossings.chunks_exact(2).map(|pair| [pair[0], pair[1]]).collect()
}

#[cfg(test)]
mod tests {
    use super::super::cut::Cut;
    use super::*;

    fn part(outline: &[(f64, f64)], cut: Cut) -> PartNode {
        PartNode {
            cut: Some(cut),
            h_edges: Vec::new(),
            outlines: vec![outline.iter().copied().map(DVec2::from).collect()],
            heights: [-6.0, 0.5],
            parts: Vec::new(),
            lacks_thin: false,
            part: None,
            place: None,
        }
    }

    #[test]
    fn a_cut_along_a_wall_is_drawn_where_the_head_goes_on_on_both_sides() {
        let angle = [(-2.0, -2.0), (2.0, -2.0), (2.0, 0.0), (0.0, 0.0), (0.0, 2.0), (-2.0, 2.0)];
        let cut = Cut::upright(DVec2::new(1.0, 0.0), DVec2::Y, true);
        let [line] = &part(&angle, cut).cut_lines()[..] else { panic!("one line") };
        // From the wall that is cut along to the wall opposite.
        let (least, most) = (line[0].min(line[1]), line[0].max(line[1]));
        assert!(line.len() == 2 && least.distance(DVec3::new(-2.0, 0.0, 0.5)) < 1e-9, "{line:?}");
        assert!(most.distance(DVec3::new(0.0, 0.0, 0.5)) < 1e-9, "{line:?}");
        assert!(part(&angle, Cut { through: 9.0 * DVec3::Y, ..cut }).cut_lines().is_empty(), "beside the head");
    }

    #[test]
    fn a_slanted_cut_is_drawn_as_its_piece_of_the_plane() {
        let square = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
        let (sin, cos) = 0.1f64.sin_cos();
        let (through, normal) = (DVec3::new(0.5, 0.0, 0.5), DVec3::new(cos, 0.0, -sin));
        let cut = Cut { through, normal, low: -1.5, overlaps: true };
        let [outline] = &part(&square, cut).cut_lines()[..] else { panic!("one outline") };
        assert!(outline.len() == 5 && outline[0] == outline[4]);
        assert!(
            outline.iter().all(|p| (p - through).dot(normal).abs() < 1e-9),
            "all of it lies in the plane: {outline:?}"
        );
        let heights: Vec<f64> = outline.iter().map(|p| p.z).collect();
        assert_eq!(heights, [0.5, 0.5, -1.5, -1.5, 0.5]);
        let deep = Cut { low: f64::NEG_INFINITY, ..cut };
        assert_eq!(part(&square, deep).cut_lines()[0][2].z, -6.0, "no deeper than the head");
    }
}
