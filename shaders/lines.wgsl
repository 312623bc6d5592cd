// Polylines, given in view coordinates.

override FAINT: bool = false;

@vertex
fn vs(
    @builtin(vertex_index) index: u32, @location(0) a: vec3<f32>, @location(1) b: vec3<f32>,
    @location(2) colour: vec4<f32>, @location(3) width: f32
) -> Segment {
    let round = 0.5 * width * frame.picture.z + 1.0;
    return segment(index, a, b, width, 2.0, select(round, 0.0, FAINT), colour);
}

@fragment
fn fs(in: Segment) -> @location(0) vec4<f32> {
    let share = coverage(in, !FAINT) * select(1.0, 0.28, FAINT);
    if share < 0.02 { discard; }
    return vec4(in.colour.rgb, in.colour.a * share);
}
