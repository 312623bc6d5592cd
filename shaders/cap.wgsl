// Cut faces of a section: first the outline's winding is counted in the stencil, then what it encloses is
// filled and hatched.

struct Cap {
    @builtin(position) clip: vec4<f32>,
    @location(0) view: vec3<f32>,
    // Place in the plane (mm).
    @location(1) place: vec2<f32>,
}

@vertex
fn vs(@location(0) position: vec3<f32>, @location(1) place: vec2<f32>) -> Cap {
    return Cap(frame.projection * vec4(position, 1.0), position, place);
}

@fragment
fn fs_count() {}

@fragment
fn fs(in: Cap) -> @location(0) vec4<f32> {
    let t = (in.place.x + in.place.y) / frame.grid.w;
    let step = max(fwidth(t), 1e-6);
    // Lines 1.1 pixels wide; where they would run together, their mean.
    let line = clamp(0.55 + 0.5 - abs(fract(t) - 0.5) / step, 0.0, 1.0) * smoothstep(0.7, 0.25, step);
    let base = mix(object.colour.rgb, decoded(frame.accent.rgb), object.look.x);
    let fill = encoded(mix(base, vec3(0.9), 0.12) * 0.80);
    let colour = mix(fill, fill * 0.55, line * 0.8);
    return vec4(faded(colour, in.view, in.clip.xy), max(object.colour.a, 0.0));
}
