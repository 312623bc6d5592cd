//! Preparation of a picture on the CPU: from a scene and a camera to the data for the GPU.

use std::ops::Range;
use std::sync::Arc;

use bytemuck::Zeroable;
use glam::{DAffine3, DMat4, DVec3};

use super::batches::{Batch, Together};
use super::triad::{self, Triad};
use super::uniforms::{DotInstance, FrameUniform, ObjectUniform, PlaneVertex, SegmentInstance};
use crate::camera::{Camera, Projection};
use crate::colour::Colour;
use crate::scene::{Grid, LineSet, Marker, Object, Scene, SectionPlane, union};
use crate::section::{Cut, CutCache};
use geometry::mesh::Bounds;

/// How much the furthest things fade into the background.
const FADE: f32 = 0.16;
/// Distance of a cap's hatch lines (pixels), at least.
const HATCH_PX: f64 = 5.0;
/// By how much of the depth range an object is drawn nearer than the one before it, and how many times at most, so
/// that faces that coincide do not flicker: of opaque objects the later one in the scene is seen, of translucent ones,
/// such as ghosts that slide along their own faces, the nearer one. Opaque ones take few steps in turn, since what is drawn
/// much nearer would be seen through what stands before it.
const STEP: f32 = 3e-6;
const STEPS: usize = 64;
const OPAQUE_STEPS: usize = 8;
/// Widths and radii in pixels lie between these.
const PIXELS: [f32; 2] = [0.25, 64.0];

/// All that is drawn in one picture.
pub struct Prepared {
    pub frame: FrameUniform,
    /// Objects drawn together, nearest first.
    pub batches: Vec<PreparedBatch>,
    pub objects: Vec<PreparedObject>,
    /// How many of `objects` come first and are opaque; the others are sorted by depth, furthest first.
    pub opaque: usize,
    pub segments: Vec<SegmentInstance>,
    /// Lines that objects hide.
    pub lines: Range<u32>,
    /// Lines that shine through.
    pub lines_on_top: Range<u32>,
    pub dots: Vec<DotInstance>,
    pub planes: Vec<PlaneVertex>,
    /// The quad that fills every cap.
    pub cap_cover: Range<u32>,
    pub grid: Range<u32>,
    pub triad: Option<Triad>,
    pub section: bool,
}

/// One object of a picture.
pub struct PreparedObject {
    /// Place in the scene's list.
    pub index: usize,
    pub uniform: ObjectUniform,
    /// Triangles whose windings make its cap.
    pub cap: Range<u32>,
    /// Depth of the nearest corner of its box (mm).
    nearest: f64,
}

/// Some objects drawn together.
pub struct PreparedBatch {
    pub batch: Arc<Batch>,
    pub uniform: ObjectUniform,
}

/// View through which everything in a picture is seen.
struct View<'a> {
    camera: &'a Camera,
    size: [u32; 2],
    scale: f64,
    affine: DAffine3,
}

/// Prepares a picture of `size` pixels, `scale` of them to a pixel asked for.
/// Objects that are drawn `together` are left out of its objects.
pub fn prepare(
    scene: &Scene,
    camera: &Camera,
    size: [u32; 2],
    scale: f64,
    cuts: &mut CutCache,
    together: &Together,
) -> Prepared {
    let rotation = camera.view_rotation();
    let affine = DAffine3 { matrix3: rotation, translation: camera.to_view(DVec3::ZERO) };
    let view = View { camera, size, scale, affine };
    let section = scene.section.filter(|s| s.unit_normal().is_some());
    let mut prepared = Prepared {
        frame: frame_uniform(scene, &view, section.as_ref()),
        batches: batches(together, &view),
        objects: objects(scene, &view, together),
        opaque: 0,
        segments: Vec::new(),
        lines: 0..0,
        lines_on_top: 0..0,
        dots: scene.markers.iter().filter_map(|m| dot(m, &view)).collect(),
        planes: Vec::new(),
        cap_cover: 0..0,
        grid: 0..0,
        triad: None,
        section: section.is_some(),
    };
    prepared.opaque = prepared.objects.iter().filter(|o| scene.objects[o.index].is_opaque()).count();
    let (opaque, translucent) = prepared.objects.split_at_mut(prepared.opaque);
    opaque.iter_mut().for_each(|object| object.uniform.values[2] = f32::from(depth_step(object.index)) * STEP);
    for (rank, object) in translucent.iter_mut().enumerate() {
        object.uniform.values[2] = rank.min(STEPS) as f32 * STEP;
    }
    if let Some(plane) = &section {
        add_caps(&mut prepared, scene, plane, &view, cuts);
    }
    cuts.finish_picture();
    if let Some(grid) = &scene.grid {
        prepared.grid = add_grid(&mut prepared.planes, grid, &view);
    }
    for lines in scene.lines.iter().filter(|l| !l.on_top) {
        add_lines(&mut prepared.segments, lines, &view);
    }
    let middle = prepared.segments.len() as u32;
    for lines in scene.lines.iter().filter(|l| l.on_top) {
        add_lines(&mut prepared.segments, lines, &view);
    }
    (prepared.lines, prepared.lines_on_top) = (0..middle, middle..prepared.segments.len() as u32);
    if scene.triad {
        let background = scene.theme.background_bottom;
        prepared.triad = Some(triad::add(&mut prepared.segments, &mut prepared.dots, camera, size, scale, background));
    }
    prepared
}

/// The uniforms for drawing in pixels instead: x and y count from the middle of the picture.
pub fn flat_frame(frame: &FrameUniform, size: [u32; 2]) -> FrameUniform {
    let [w, h] = size.map(|s| 2.0 / s as f32);
    let mut projection = [0.0; 16];
    (projection[0], projection[5], projection[14], projection[15]) = (w, h, 0.5, 1.0);
    let [a, b, c, _] = frame.picture;
    FrameUniform { projection, up: [0.0; 4], picture: [a, b, c, 0.0], fade: [0.0; 4], ..*frame }
}

fn frame_uniform(scene: &Scene, view: &View, section: Option<&SectionPlane>) -> FrameUniform {
    let camera = view.camera;
    let grid = scene.grid.iter().filter(|g| is_grid(g)).map(|g| {
        let reach = DVec3::new(g.radius, g.radius, 0.0);
        Bounds { min: g.center - reach, max: g.center + reach }
    });
    let objects = scene.bounds_of_objects();
    let range = camera.depth_range(&grid.fold(union(scene.bounds_of_points(), objects), union));
    let [near, far] = camera.depth_range(&objects);
    let [width, height] = view.size.map(f64::from);
    let perspective = camera.projection == Projection::Perspective;
    let unit_depth = camera.pixel_size(1.0, view.size[1]);
    let up = camera.view_rotation() * DVec3::Z;
    let theme = &scene.theme;
    let spacing = scene.grid.map_or(1.0, |g| g.spacing);
    // From below the grid lies before the objects: it steps back.
    let strength = if camera.backward().z < 0.0 { 0.35 } else { 1.0 };
    FrameUniform {
        projection: to_f32(&camera.projection_matrix(width / height, range)),
        section: section.map_or([0.0, 0.0, 0.0, -1.0], |s| section_uniform(s, view)),
        up: up.extend(f64::from(u8::from(perspective))).as_vec4().to_array(),
        picture: [width as f32, height as f32, view.scale as f32, unit_depth as f32],
        fade: [near as f32, far as f32, FADE, range[0] as f32],
        background_top: opaque(theme.background_top),
        background_bottom: opaque(theme.background_bottom),
        edge: opaque(theme.edge),
        accent: opaque(theme.accent),
        grid: [spacing as f32, scene.grid.map_or(1.0, |g| g.radius) as f32, strength, hatch_spacing(view) as f32],
        grid_colour: opaque(theme.grid),
    }
}

/// The plane in view coordinates: `dot(xyz, p) + w` is the height above it.
fn section_uniform(plane: &SectionPlane, view: &View) -> [f32; 4] {
    let normal = view.affine.matrix3 * plane.unit_normal().unwrap_or_default();
    normal.extend(-normal.dot(view.affine.transform_point3(plane.point))).as_vec4().to_array()
}

/// A power of two of 1 mm, so that the hatch stays in place while zooming but for jumps by two.
fn hatch_spacing(view: &View) -> f64 {
    let pixel = view.camera.pixel_size(view.camera.distance, view.size[1]);
    // The hatch runs diagonally.
    2f64.powf((HATCH_PX * view.scale * pixel * std::f64::consts::SQRT_2).log2().ceil())
}

/// How many depth steps nearer the opaque object at this place of the scene's list is drawn.
pub fn depth_step(index: usize) -> i16 {
    (index % OPAQUE_STEPS) as i16
}

fn batches(together: &Together, view: &View) -> Vec<PreparedBatch> {
    let nearest = |b: &&Arc<Batch>| view.camera.depth_extent(&b.bounds)[0];
    let mut batches: Vec<&Arc<Batch>> = together.batches.iter().collect();
    batches.sort_by(|a, b| nearest(a).total_cmp(&nearest(b)));
    let prepared = |batch: &Arc<Batch>| {
        let placed = view.affine * DAffine3::from_translation(batch.origin);
        let uniform = ObjectUniform {
            model_view: to_f32(&DMat4::from(placed)),
            normal_view: to_f32(&DMat4::from_mat3(placed.matrix3)),
            values: [0.0, 0.0, STEP, 0.0],
            ..Zeroable::zeroed()
        };
        PreparedBatch { batch: batch.clone(), uniform }
    };
    batches.into_iter().map(prepared).collect()
}

fn objects(scene: &Scene, view: &View, together: &Together) -> Vec<PreparedObject> {
    let visible = |o: &Object| o.is_visible() && o.transform.matrix3.determinant() != 0.0;
    let mut list: Vec<PreparedObject> = scene
        .objects
        .iter()
        .enumerate()
        .filter(|(index, o)| !together.has(*index) && visible(o))
        .map(|(index, o)| PreparedObject {
            index,
            uniform: object_uniform(o, view),
            cap: 0..0,
            nearest: nearest(o, view),
        })
        .collect();
    // What lies within another object is never nearer than its outside, so it comes before it. The sort is
    // stable: equals stay in the scene's order.
    list.sort_by(|a, b| {
        let translucent = |o: &PreparedObject| !scene.objects[o.index].is_opaque();
        let by_depth =
            || if translucent(a) { b.nearest.total_cmp(&a.nearest) } else { a.nearest.total_cmp(&b.nearest) };
        translucent(a).cmp(&translucent(b)).then_with(by_depth)
    });
    list
}

fn object_uniform(object: &Object, view: &View) -> ObjectUniform {
    let placed = view.affine * object.transform;
    let model_view = DMat4::from(placed * DAffine3::from_translation(object.mesh.origin()));
    let turn = placed.matrix3.inverse().transpose();
    // Any scale will do for directions; one near 1 keeps f32 from its limits.
    let turn = turn * (1.0 / turn.x_axis.length().max(f64::MIN_POSITIVE));
    let [r, g, b] = object.colour.to_linear().map(|c| c as f32);
    let opacity = object.opacity.min(1.0);
    let mirrored = if placed.matrix3.determinant() < 0.0 { -1.0 } else { 1.0 };
    let edge_strength = if object.is_opaque() { 0.85 } else { 0.25 + 0.5 * opacity };
    let (row, values) =
        object.values.as_ref().map_or((0.0, [0.0; 4]), |v| (v.map.index() as f32, [v.range[0], v.scale(), 0.0, 0.0]));
    ObjectUniform {
        model_view: to_f32(&model_view),
        normal_view: to_f32(&DMat4::from_mat3(turn)),
        colour: [r, g, b, opacity],
        look: [object.accent(), row, mirrored, edge_strength],
        values,
    }
}

fn nearest(object: &Object, view: &View) -> f64 {
    view.camera.depth_extent(&object.bounds())[0]
}

/// Adds caps and the lines around them.
fn add_caps(prepared: &mut Prepared, scene: &Scene, plane: &SectionPlane, view: &View, cuts: &mut CutCache) {
    let Some(normal) = plane.unit_normal() else { return };
    let (u, v) = plane_axes(normal);
    let vertex = |p: DVec3| PlaneVertex {
        position: view.point(p),
        place: [u.dot(p - plane.point) as f32, v.dot(p - plane.point) as f32],
        off: [0.0; 2],
    };
    let mut corners = Bounds::EMPTY;
    for prepared_object in &mut prepared.objects {
        let object = &scene.objects[prepared_object.index];
        let cut = cuts.cut(object, plane);
        let place = |p: DVec3| DVec3::new(u.dot(p - plane.point), v.dot(p - plane.point), 0.0);
        let own = Bounds::of(cut.iter().flatten().map(|&p| place(p)));
        corners = union(corners, own);
        add_outline(&mut prepared.segments, &cut, scene.theme.section, object.opacity, view);
        if object.mesh.is_closed() && !cut.is_empty() {
            let first = prepared.planes.len() as u32;
            let pivot = cut[0][0];
            prepared.planes.extend(cut.iter().flat_map(|&[a, b]| [pivot, a, b]).map(vertex));
            prepared_object.cap = first..prepared.planes.len() as u32;
        }
    }
    if corners.min.x <= corners.max.x {
        let Bounds { min, max } = corners.grown(0.01 * corners.size().length());
        let quad = [[min.x, min.y], [max.x, min.y], [min.x, max.y], [max.x, max.y]];
        let first = prepared.planes.len() as u32;
        prepared.planes.extend(quad.map(|[x, y]| vertex(plane.point + u * x + v * y)));
        prepared.cap_cover = first..first + 4;
    }
}

/// Two unit vectors across `normal` that turn with it as little as may be.
fn plane_axes(normal: DVec3) -> (DVec3, DVec3) {
    let across = if normal.z.abs() < 0.9 { DVec3::Z } else { DVec3::Y };
    let u = across.cross(normal).normalize_or(DVec3::X);
    (u, normal.cross(u))
}

fn add_outline(segments: &mut Vec<SegmentInstance>, cut: &Cut, colour: Colour, opacity: f32, view: &View) {
    let alpha = (255.0 * opacity.clamp(0.35, 1.0)).round() as u8;
    let colour = [colour.r, colour.g, colour.b, alpha];
    segments.extend(cut.iter().map(|&[a, b]| SegmentInstance {
        ends: [view.point(a), view.point(b)],
        colour,
        width: 1.4,
    }));
}

fn add_lines(segments: &mut Vec<SegmentInstance>, lines: &LineSet, view: &View) {
    let Colour { r, g, b } = lines.colour;
    let width = pixels(lines.width_px);
    for polyline in &lines.polylines {
        let pairs = polyline.windows(2).filter(|p| p[0].is_finite() && p[1].is_finite());
        segments.extend(pairs.map(|p| SegmentInstance {
            ends: [view.point(p[0]), view.point(p[1])],
            colour: [r, g, b, 255],
            width,
        }));
    }
}

fn dot(marker: &Marker, view: &View) -> Option<DotInstance> {
    let Colour { r, g, b } = marker.colour;
    let in_front = view.camera.project(marker.at, view.size).is_some();
    (marker.at.is_finite() && in_front).then(|| DotInstance {
        at: view.point(marker.at),
        colour: [r, g, b, 255],
        radius: pixels(marker.radius_px),
    })
}

fn is_grid(grid: &Grid) -> bool {
    grid.center.is_finite() && grid.radius > 0.0 && grid.radius.is_finite() && grid.spacing > 1e-4 * grid.radius
}

fn add_grid(planes: &mut Vec<PlaneVertex>, grid: &Grid, view: &View) -> Range<u32> {
    if !is_grid(grid) {
        return 0..0;
    }
    let first = planes.len() as u32;
    // Lines pass through multiples of the spacing; places are counted from such a crossing nearby.
    let strong = 10.0 * grid.spacing;
    let shift = grid.center - (grid.center / strong).round() * strong;
    let r = grid.radius;
    planes.extend([[-r, -r], [r, -r], [-r, r], [r, r]].map(|[x, y]| PlaneVertex {
        position: view.point(grid.center + DVec3::new(x, y, 0.0)),
        place: [(shift.x + x) as f32, (shift.y + y) as f32],
        off: [x as f32, y as f32],
    }));
    first..first + 4
}

impl View<'_> {
    fn point(&self, p: DVec3) -> [f32; 3] {
        self.affine.transform_point3(p).as_vec3().to_array()
    }
}

fn pixels(asked: f32) -> f32 {
    if asked.is_nan() { 1.0 } else { asked.clamp(PIXELS[0], PIXELS[1]) }
}

fn opaque(colour: Colour) -> [f32; 4] {
    let [r, g, b] = colour.to_unit();
    [r, g, b, 1.0]
}

fn to_f32(matrix: &DMat4) -> [f32; 16] {
    matrix.to_cols_array().map(|c| c as f32)
}
