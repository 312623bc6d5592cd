// A grid on the ground, fading out.

struct Ground {
    @builtin(position) clip: vec4<f32>,
    @location(0) view: vec3<f32>,
    // Place from a crossing of strong lines near the middle (mm), and from the middle.
    @location(1) place: vec2<f32>,
    @location(2) off: vec2<f32>,
}

@vertex
fn vs(
    @location(0) position: vec3<f32>, @location(1) place: vec2<f32>, @location(2) off: vec2<f32>
) -> Ground {
    return Ground(frame.projection * vec4(position, 1.0), position, place, off);
}

fn lines(place: vec2<f32>, spacing: f32) -> f32 {
    let t = place / spacing;
    let step = max(fwidth(t), vec2(1e-6));
    let line = clamp(vec2(1.0) - abs(fract(t - 0.5) - 0.5) / step, vec2(0.0), vec2(1.0));
    let clear = smoothstep(vec2(0.6), vec2(0.15), step);
    return max(line.x * clear.x, line.y * clear.y);
}

@fragment
fn fs(in: Ground) -> @location(0) vec4<f32> {
    let fine = lines(in.place, frame.grid.x);
    let strong = lines(in.place, frame.grid.x * 10.0);
    let fading = 1.0 - smoothstep(0.35, 1.0, length(in.off) / frame.grid.y);
    return vec4(frame.grid_colour.rgb, max(fine * 0.22, strong * 0.5) * fading * frame.grid.z);
}
