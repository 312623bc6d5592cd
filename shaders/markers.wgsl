// Round dots with a dark rim, given in view coordinates.

override FAINT: bool = false;

struct Dot {
    @builtin(position) clip: vec4<f32>,
    @location(0) off: vec2<f32>,
    @location(1) colour: vec4<f32>,
    @location(2) radius: f32,
}

@vertex
fn vs(
    @builtin(vertex_index) index: u32, @location(0) at: vec3<f32>, @location(1) colour: vec4<f32>,
    @location(2) radius_asked: f32
) -> Dot {
    let radius = radius_asked * frame.picture.z;
    let corner = vec2(f32(index & 1u), f32(index >> 1u)) * 2.0 - 1.0;
    let off = corner * (radius + 2.0);
    var clip = frame.projection * vec4(at + towards_viewer(at) * radius * pixel_size(at), 1.0);
    // Not moved through the near plane.
    clip = vec4(clip.xy + off * 2.0 / frame.picture.xy * clip.w, max(clip.z, 0.0), clip.w);
    return Dot(clip, off, colour, radius);
}

@fragment
fn fs(in: Dot) -> @location(0) vec4<f32> {
    let r = length(in.off);
    let share = clamp(in.radius + 1.0 - r, 0.0, 1.0);
    if share <= 0.0 { discard; }
    let rim = clamp(r - (in.radius - 1.5 * frame.picture.z), 0.0, 1.0);
    let colour = mix(in.colour.rgb, in.colour.rgb * 0.25, rim * 0.85);
    return vec4(colour, in.colour.a * share * select(1.0, 0.35, FAINT));
}
