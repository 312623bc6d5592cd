// One object's place and look.

struct Object {
    model_view: mat4x4<f32>,
    // For normals: the inverse transpose.
    normal_view: mat4x4<f32>,
    // Linear light, and opacity.
    colour: vec4<f32>,
    // Share of the accent colour; row of the colour map; 1 or, for a mirrored object, -1; strength of edges.
    look: vec4<f32>,
    // Least value and one over the range of values; how much nearer it is drawn (of the depth range).
    values: vec4<f32>,
}

@group(1) @binding(0) var<uniform> object: Object;
