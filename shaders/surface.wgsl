// Lit surfaces, opaque or not.

override SECTION: bool = false;
override TRANSLUCENT: bool = false;

@group(0) @binding(1) var colour_maps: texture_2d<f32>;

struct Surface {
    @invariant @builtin(position) clip: vec4<f32>,
    @location(0) view: vec3<f32>,
    @location(1) normal: vec3<f32>,
    // Value times validity, validity.
    @location(2) value: vec2<f32>,
}

fn surface(position: vec3<f32>, normal: vec3<f32>, value: vec2<f32>) -> Surface {
    let view = object.model_view * vec4(position, 1.0);
    var clip = frame.projection * view;
    clip.z -= object.values.z * clip.w;
    return Surface(clip, view.xyz, (object.normal_view * vec4(normal, 0.0)).xyz, value);
}

@vertex
fn vs_plain(@location(0) position: vec3<f32>, @location(1) normal: vec4<f32>) -> Surface {
    return surface(position, normal.xyz, vec2(0.0));
}

@vertex
fn vs_valued(
    @location(0) position: vec3<f32>, @location(1) normal: vec4<f32>, @location(2) value: f32
) -> Surface {
    let valid = value > -1e38;
    let t = (value - object.values.x) * object.values.y;
    return surface(position, normal.xyz, select(vec2(0.0), vec2(t, 1.0), valid));
}

// Light from a hemisphere, a key light over the viewer's left shoulder, and weak ones from the right and from the
// viewer.
fn lit(base: vec3<f32>, n: vec3<f32>, v: vec3<f32>) -> vec3<f32> {
    let key = normalize(vec3(-0.45, 0.65, 0.80));
    let fill = normalize(vec3(0.85, -0.10, 0.45));
    let sky = normalize(frame.up.xyz + vec3(0.0, 0.6, 0.0));
    let ambient = mix(vec3(0.15, 0.155, 0.17), vec3(0.40, 0.41, 0.43), 0.5 + 0.5 * dot(n, sky));
    let diffuse = 0.60 * max(dot(n, key), 0.0) + 0.12 * max(dot(n, fill), 0.0) + 0.10 * max(dot(n, v), 0.0);
    let shine = 0.10 * pow(max(dot(n, normalize(key + v)), 0.0), 36.0);
    let rim = 0.07 * pow(1.0 - clamp(dot(n, v), 0.0, 1.0), 3.0);
    return base * (ambient + vec3(1.0, 0.985, 0.96) * diffuse) + shine + rim;
}

// What is seen of a surface; `colour` and `look` are those of its object.
fn seen(in: Surface, front: bool, colour_and_opacity: vec4<f32>, look: vec4<f32>) -> vec4<f32> {
    let v = towards_viewer(in.view);
    let outside = front == (look.z > 0.0);
    let n = normalize(in.normal) * select(-1.0, 1.0, outside);
    var base = colour_and_opacity.rgb;
    let is_valued = in.value.y > 0.999;
    if is_valued {
        let column = i32(clamp(in.value.x, 0.0, 1.0) * 255.0 + 0.5);
        base = decoded(textureLoad(colour_maps, vec2(column, i32(look.y)), 0).rgb);
    }
    base = mix(base, decoded(frame.accent.rgb), look.x);
    var colour = lit(base, n, v);
    // Colours that mean a value are kept nearer to the legend's.
    if is_valued { colour = mix(colour, base * (0.55 + 0.45 * clamp(dot(n, v), 0.0, 1.0)), 0.65); }
    // The inner side of what is open or cut.
    if !outside { colour = mix(colour, vec3(dot(colour, vec3(0.3, 0.6, 0.1))), 0.35) * 0.62; }
    let screen = faded(encoded(colour), in.view, in.clip.xy);
    if TRANSLUCENT {
        let grazing = pow(1.0 - clamp(dot(n, v), 0.0, 1.0), 3.0);
        return vec4(screen, mix(colour_and_opacity.a, 1.0, 0.45 * grazing * sqrt(colour_and_opacity.a)));
    }
    return vec4(screen, 1.0);
}

@fragment
fn fs(in: Surface, @builtin(front_facing) front: bool) -> @location(0) vec4<f32> {
    if SECTION {
        if is_cut_away(in.view) { discard; }
    }
    return seen(in, front, object.colour, object.look);
}

// A vertex of some objects drawn together, and what is seen of it: of many small triangles to shade each pixel would cost
// more than all else.
struct Batch {
    @invariant @builtin(position) clip: vec4<f32>,
    @location(0) seen: vec3<f32>,
}

// The fourth component of the normal is a number of depth steps. The colour is linear light and the share of the accent
// colour; the value is value times validity, validity, and the row of the colour map.
@vertex
fn vs_batch(
    @location(0) position: vec3<f32>, @location(1) normal: vec4<f32>, @location(2) colour: vec4<f32>,
    @location(3) value: vec3<f32>
) -> Batch {
    let view = object.model_view * vec4(position, 1.0);
    var clip = frame.projection * view;
    let pixel = (vec2(0.5, -0.5) * clip.xy / clip.w + 0.5) * frame.picture.xy;
    clip.z -= object.values.z * round(normal.w * 32767.0) * clip.w;
    let turned = (object.normal_view * vec4(normal.xyz, 0.0)).xyz;
    let surface = Surface(vec4(pixel, 0.0, 1.0), view.xyz, turned, value.xy);
    let look = vec4(colour.a, round(value.z), 1.0, 0.0);
    let front = dot(turned, towards_viewer(view.xyz)) > 0.0;
    return Batch(clip, seen(surface, front, colour, look).rgb);
}

@fragment
fn fs_batch(in: Batch) -> @location(0) vec4<f32> {
    return vec4(in.seen, 1.0);
}

// Only depth: so that of a translucent object its nearest surface alone is seen.
@fragment
fn fs_depth(in: Surface) {
    if SECTION {
        if is_cut_away(in.view) { discard; }
    }
}
