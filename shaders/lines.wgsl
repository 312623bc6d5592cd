// Polylines, given in view coordinates.

override FAINT: bool = false;

// Thin lines have no ends to speak of, and chains of short ones with round ends would look like beads.
const ROUND_FROM: f32 = 1.6;

@vertex
fn vs(
    @builtin(vertex_index) index: u32, @location(0) a: vec3<f32>, @location(1) b: vec3<f32>,
    @location(2) colour: vec4<f32>, @location(3) width: f32
) -> Segment {
    let reach = 0.5 * width * frame.picture.z + 1.0;
    return segment(index, a, b, width, 2.0, select(0.0, reach, !FAINT && width >= ROUND_FROM), colour);
}

@fragment
fn fs(in: Segment) -> @location(0) vec4<f32> {
    let round_ends = !FAINT && in.half_width * 2.0 >= ROUND_FROM * frame.picture.z;
    let share = coverage(in, round_ends) * select(1.0, 0.28, FAINT);
    if share < 0.02 { discard; }
    return vec4(in.colour.rgb, in.colour.a * share);
}

// Only depth, where the line is solid.
@fragment
fn fs_depth(in: Segment) {
    if coverage(in, true) < 0.5 { discard; }
}
