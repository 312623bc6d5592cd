// The background: a vertical gradient, dithered so that no bands show.

struct Corner {
    @builtin(position) clip: vec4<f32>,
}

@vertex
fn vs(@builtin(vertex_index) index: u32) -> Corner {
    let corner = vec2(f32((index << 1u) & 2u), f32(index & 2u));
    return Corner(vec4(corner * 2.0 - 1.0, 1.0, 1.0));
}

@fragment
fn fs(in: Corner) -> @location(0) vec4<f32> {
    // Interleaved gradient noise, within half a step of 8 bits.
    let noise = fract(52.9829189 * fract(dot(floor(in.clip.xy), vec2(0.06711056, 0.00583715)))) - 0.5;
    return vec4(background(1.0 - in.clip.y / frame.picture.y) + noise / 255.0, 1.0);
}
