// Shows a picture over a rectangle of the window: one triangle that covers it all.

@group(0) @binding(0) var picture: texture_2d<f32>;
@group(0) @binding(1) var smoothly: sampler;

struct Corner {
    @builtin(position) position: vec4<f32>,
    @location(0) at: vec2<f32>,
}

@vertex
fn vertex(@builtin(vertex_index) i: u32) -> Corner {
    let at = vec2(f32((i << 1u) & 2u), f32(i & 2u));
    var corner: Corner;
    corner.position = vec4(at.x * 2.0 - 1.0, 1.0 - at.y * 2.0, 0.0, 1.0);
    corner.at = at;
    return corner;
}

@fragment
fn fragment(corner: Corner) -> @location(0) vec4<f32> {
    return vec4(textureSampleLevel(picture, smoothly, corner.at, 0.0).rgb, 1.0);
}
