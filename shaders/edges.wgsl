// Feature edges of an object.

override SECTION: bool = false;

@vertex
fn vs(@builtin(vertex_index) index: u32, @location(0) a: vec3<f32>, @location(1) b: vec3<f32>) -> Segment {
    let first = (object.model_view * vec4(a, 1.0)).xyz;
    let second = (object.model_view * vec4(b, 1.0)).xyz;
    // On a dark background the edges of what can be seen through are drawn in its own colour.
    let darkness = 1.0 - smoothstep(0.3, 0.6, dot(frame.background_top.rgb, vec3(1.0 / 3.0)));
    let own = select(0.0, 0.85 * darkness, object.colour.a < 1.0);
    let plain = mix(frame.edge.rgb, encoded(object.colour.rgb), own);
    let colour = mix(plain, frame.accent.rgb, step(0.01, object.look.x));
    // The ends do not overlap: where edges are fine, a chain of them would look like beads.
    var edge = segment(index, first, second, 1.25, 1.2, 0.0, vec4(colour, object.look.w));
    // As near as its surfaces.
    edge.clip.z = max(edge.clip.z - object.values.z, 0.0);
    return edge;
}

@fragment
fn fs(in: Segment) -> @location(0) vec4<f32> {
    if SECTION {
        if is_cut_away(in.view) { discard; }
    }
    return vec4(faded(in.colour.rgb, in.view, in.clip.xy), in.colour.a * coverage(in, false));
}
