// What every pass of a picture knows. "View" coordinates: x right, y up, z towards the viewer, origin at the eye.

struct Frame {
    projection: mat4x4<f32>,
    // A point p is cut away where dot(xyz, p) + w > 0.
    section: vec4<f32>,
    // xyz: the scene's +Z in view axes; w: 1 for a perspective view, 0 for an orthographic one.
    up: vec4<f32>,
    // Width and height of the picture (pixels); pixels drawn for a pixel asked for; size of a pixel (mm), in a
    // perspective view at a depth of 1.
    picture: vec4<f32>,
    // Depth at which things begin to fade into the background and where they have faded most; how much; near
    // plane.
    fade: vec4<f32>,
    background_top: vec4<f32>,
    background_bottom: vec4<f32>,
    edge: vec4<f32>,
    accent: vec4<f32>,
    // Grid: spacing, radius, strength; hatch: spacing.
    grid: vec4<f32>,
    grid_colour: vec4<f32>,
}

@group(0) @binding(0) var<uniform> frame: Frame;

// Light to screen value, IEC 61966-2-1.
fn encoded(linear: vec3<f32>) -> vec3<f32> {
    let c = clamp(linear, vec3(0.0), vec3(1.0));
    return select(1.055 * pow(c, vec3(1.0 / 2.4)) - 0.055, 12.92 * c, c <= vec3(0.0031308));
}

// Screen value to light.
fn decoded(value: vec3<f32>) -> vec3<f32> {
    return select(pow((value + 0.055) / 1.055, vec3(2.4)), value / 12.92, value <= vec3(0.04045));
}

// Unit vector from a point to the viewer.
fn towards_viewer(p: vec3<f32>) -> vec3<f32> {
    return select(vec3(0.0, 0.0, 1.0), normalize(-p), frame.up.w > 0.5);
}

// Size of a drawn pixel at a point (mm).
fn pixel_size(p: vec3<f32>) -> f32 {
    return frame.picture.w * select(1.0, max(-p.z, 0.0), frame.up.w > 0.5);
}

fn is_cut_away(p: vec3<f32>) -> bool {
    return dot(frame.section.xyz, p) + frame.section.w > 0.0;
}

// The background's screen value at a height of the picture, 0 at the bottom.
fn background(height: f32) -> vec3<f32> {
    return mix(frame.background_bottom.rgb, frame.background_top.rgb, height);
}

// A screen value as it looks at this depth.
fn faded(colour: vec3<f32>, p: vec3<f32>, pixel: vec2<f32>) -> vec3<f32> {
    let share = clamp((-p.z - frame.fade.x) / max(frame.fade.y - frame.fade.x, 1e-6), 0.0, 1.0) * frame.fade.z;
    return mix(colour, background(1.0 - pixel.y / frame.picture.y), share);
}
