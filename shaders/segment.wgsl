// Segments as quads of constant width on the screen.

struct Segment {
    @builtin(position) clip: vec4<f32>,
    @location(0) view: vec3<f32>,
    // Both ends (pixels).
    @location(1) @interpolate(flat, either) ends: vec4<f32>,
    @location(2) colour: vec4<f32>,
    // Half the width (pixels).
    @location(3) half_width: f32,
}

// `p` or, if it lies behind the near plane, the point of the segment to `other` that lies in it.
fn before_near_plane(p: vec3<f32>, other: vec3<f32>) -> vec3<f32> {
    let limit = -frame.fade.w;
    if frame.up.w < 0.5 || p.z <= limit || other.z >= limit { return p; }
    return mix(p, other, (p.z - limit) / (p.z - other.z));
}

// A point moved towards the viewer by `pixels` pixels' size, so that what lies on a surface is not hidden by it.
fn lifted(p: vec3<f32>, pixels: f32) -> vec3<f32> {
    return p + towards_viewer(p) * (pixels * pixel_size(p) + 1e-4 * abs(p.z) * frame.up.w);
}

// Place on the screen (pixels) and depth, of which the lift may not cross the near plane.
fn on_screen(p: vec3<f32>) -> vec3<f32> {
    let clip = frame.projection * vec4(p, 1.0);
    let ndc = clip.xyz / clip.w;
    return vec3((vec2(ndc.x, -ndc.y) * 0.5 + 0.5) * frame.picture.xy, max(ndc.z, 0.0));
}

// Corner `index` (0 to 3, a strip) of the segment's quad; `reach` extends it beyond its ends (pixels).
fn segment(index: u32, a: vec3<f32>, b: vec3<f32>, width: f32, lift: f32, reach: f32, colour: vec4<f32>) -> Segment {
    let first = before_near_plane(a, b);
    let second = before_near_plane(b, a);
    let from_px = on_screen(lifted(first, lift));
    let to_px = on_screen(lifted(second, lift));
    let way = to_px.xy - from_px.xy;
    let along = select(vec2(1.0, 0.0), way / length(way), length(way) > 1e-4);
    let half_width = 0.5 * width * frame.picture.z;
    let at_end = (index & 2u) != 0u;
    let side = select(-1.0, 1.0, (index & 1u) != 0u);
    let across = vec2(-along.y, along.x) * side * (half_width + 1.0);
    let end = select(from_px, to_px, at_end);
    let pixel = end.xy + across + along * select(-reach, reach, at_end);
    let ndc = vec2(pixel.x / frame.picture.x, 1.0 - pixel.y / frame.picture.y) * 2.0 - 1.0;
    let view = select(first, second, at_end);
    return Segment(vec4(ndc, end.z, 1.0), view, vec4(from_px.xy, to_px.xy), colour, half_width);
}

// How much of a pixel the segment covers, with round ends or, endlessly long, without.
fn coverage(in: Segment, round_ends: bool) -> f32 {
    let a = in.ends.xy;
    let way = in.ends.zw - a;
    let off = in.clip.xy - a;
    var t = dot(off, way) / max(dot(way, way), 1e-6);
    if round_ends { t = clamp(t, 0.0, 1.0); }
    return clamp(in.half_width + 0.5 - length(off - way * t), 0.0, 1.0) * min(2.0 * in.half_width, 1.0);
}
