// Feature edges of an object.

override SECTION: bool = false;

@vertex
fn vs(@builtin(vertex_index) index: u32, @location(0) a: vec3<f32>, @location(1) b: vec3<f32>) -> Segment {
    let first = (object.model_view * vec4(a, 1.0)).xyz;
    let second = (object.model_view * vec4(b, 1.0)).xyz;
    let colour = mix(frame.edge, vec4(frame.accent.rgb, 1.0), step(0.01, object.look.x));
    return segment(index, first, second, 1.25, 1.2, 0.3, vec4(colour.rgb, object.look.w));
}

@fragment
fn fs(in: Segment) -> @location(0) vec4<f32> {
    if SECTION {
        if is_cut_away(in.view) { discard; }
    }
    return vec4(faded(in.colour.rgb, in.view, in.clip.xy), in.colour.a * coverage(in, false));
}
