//! The axes in the corner of a picture.

use std::ops::Range;

use glam::DVec3;

use super::uniforms::{DotInstance, SegmentInstance};
use crate::camera::Camera;
use crate::colour::Colour;

/// Length of an axis and distance of their common end from the corner of the picture (pixels).
const LENGTH: f64 = 34.0;
const MARGIN: f64 = 56.0;
/// Radius of the disc at the tip (pixels), and half the size of the letter on it.
const DISC: f64 = 8.5;
const LETTER: [f64; 2] = [2.6, 3.4];
const COLOURS: [Colour; 3] =
    [Colour::rgb(0xe8, 0x4d, 0x4f), Colour::rgb(0x6c, 0xc2, 0x4a), Colour::rgb(0x4a, 0x90, 0xf0)];
const INK: [u8; 4] = [0x12, 0x14, 0x18, 0xff];

type Stroke = [[f64; 2]; 2];
const X: &[Stroke] = &[[[-1.0, -1.0], [1.0, 1.0]], [[-1.0, 1.0], [1.0, -1.0]]];
const Y: &[Stroke] = &[[[-1.0, 1.0], [0.0, 0.0]], [[1.0, 1.0], [0.0, 0.0]], [[0.0, 0.0], [0.0, -1.0]]];
const Z: &[Stroke] = &[[[-1.0, 1.0], [1.0, 1.0]], [[1.0, 1.0], [-1.0, -1.0]], [[-1.0, -1.0], [1.0, -1.0]]];

/// Where the three axes lie among the segments and dots of a picture, furthest first.
pub struct Triad {
    /// Of each axis its line, its disc and the strokes of its letter.
    pub axes: [(Range<u32>, Range<u32>, Range<u32>); 3],
    /// How many dots of the picture come before the discs.
    pub first_dot: u32,
}

/// Adds the axes. Their coordinates are drawn pixels from the middle of the picture; `scale` of these make a
/// pixel asked for.
pub fn add(
    segments: &mut Vec<SegmentInstance>,
    dots: &mut Vec<DotInstance>,
    camera: &Camera,
    size: [u32; 2],
    scale: f64,
    background: Colour,
) -> Triad {
    let [w, h] = size.map(|s| 0.5 * f64::from(s));
    let origin = DVec3::new(MARGIN * scale - w, MARGIN * scale - h, 0.0);
    let axes = camera.view_rotation();
    let mut order = [0, 1, 2];
    order.sort_by(|&i, &j| axes.col(i).z.total_cmp(&axes.col(j).z));
    let first_dot = dots.len() as u32;
    let axes = order.map(|i| {
        let tip = origin + axes.col(i).with_z(0.0) * (LENGTH * scale);
        let colour = dimmed(COLOURS[i], background, axes.col(i).z);
        let line = segments.len() as u32;
        segments.push(segment([origin, tip], colour, 2.2));
        let disc = dots.len() as u32;
        dots.push(DotInstance { at: tip.as_vec3().to_array(), colour, radius: DISC as f32 });
        for stroke in [X, Y, Z][i] {
            let ends = stroke.map(|[x, y]| tip + DVec3::new(x * LETTER[0], y * LETTER[1], 0.0) * scale);
            segments.push(segment(ends, INK, 1.4));
        }
        (line..line + 1, disc..disc + 1, line + 1..segments.len() as u32)
    });
    Triad { axes, first_dot }
}

fn segment(ends: [DVec3; 2], colour: [u8; 4], width: f32) -> SegmentInstance {
    SegmentInstance { ends: ends.map(|p| p.as_vec3().to_array()), colour, width }
}

/// The colour of an axis, paler the more it points away from the viewer.
fn dimmed(colour: Colour, background: Colour, towards_viewer: f64) -> [u8; 4] {
    let share = 0.55 * (-towards_viewer).clamp(0.0, 1.0);
    let mix = |a: u8, b: u8| (f64::from(a) + (f64::from(b) - f64::from(a)) * share).round() as u8;
    [mix(colour.r, background.r), mix(colour.g, background.g), mix(colour.b, background.b), 255]
}
