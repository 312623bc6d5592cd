//! The scene of a flank: the surface coloured by how far the cutter is off it, the surface of the cutter's axis, the
//! cutter where it stands, and the three paths of a plan side by side.

use std::f64::consts::TAU;
use std::sync::Arc;

use glam::{DAffine3, DMat3, DQuat, DVec3};

use crate::widgets::theme::{BAD, HIGH, MACHINE, STEEL};
use crate::workspaces::flank::document::PathChoice;
use flank::cutter::FlankCutter;
use flank::deviation::{Deviation, ROUNDING_MM};
use flank::path::{FlankPath, FlankPose};
use flank::plan::FlankPlan;
use flank::ruled_surface::RuledSurface;
use geometry::mesh::{Bounds, Mesh};
use render::camera::Camera;
use render::colour::{Colour, Theme};
use render::colour_map::{ColourMap, Legend};
use render::mesh::RenderMesh;
use render::scene::{Grid, LineSet, Marker, Object, ObjectId, Scene, SurfaceValues};
use render::view::looking;

/// Flutes.
const FLUTES: Colour = Colour::rgb(0xb9, 0xc4, 0xce);
/// Opacity of the cutter, so that the surface is seen through it.
const CUTTER_OPACITY: f32 = 0.5;
/// Opacity of cutters side by side, where they stand before other surfaces.
const CUTTERS_OPACITY: f32 = 0.22;
/// Opacity of the surface of the axis.
const AXIS_OPACITY: f32 = 0.4;
/// Opacity of walls and of the part that a flank is of.
const WALL_OPACITY: f32 = 0.3;
/// Corners of the circles that the cutter is made of.
const CORNERS: usize = 48;
/// Rulings that are drawn.
const RULINGS: usize = 24;
/// Places of a surface that has no plan.
const BARE: [usize; 2] = [65, 5];
/// Distance of the surfaces side by side, in parts of their own size that way.
const APART: f64 = 1.35;
/// Share of a surface's width below which the way between its ends does not tell how long it is.
const SHORT: f64 = 0.5;

/// Length of the arrows to both sides of a surface, in parts of its length and height together.
const ARROW: f64 = 0.16;

/// The least end of the colours' scale (mm): smaller deviations are noise.
const LEAST_LIMIT: f64 = 1e-4;

const FIRST_SURFACE: u32 = 0;
const FIRST_AXIS: u32 = 8;
const FIRST_CUTTER: u32 = 16;
const FIRST_HOLDER: u32 = 24;
const PART: u32 = 32;
const WALLS: u32 = 33;

/// A ruled surface made for the screen.
#[derive(Debug, Clone)]
pub struct FlankSurface {
    /// Mesh of the surface over a grid: v runs faster.
    pub shape: Arc<RenderMesh>,
    rulings: Vec<Vec<DVec3>>,
    /// Middle, mean unit normal on the cutter's side, direction and length along the guides, and along the rulings.
    middle: DVec3,
    normal: DVec3,
    along: DVec3,
    across: DVec3,
    /// Whether its ends are so near to each other that it is seen as a whole from the side.
    is_round: bool,
}

/// A plan made for the screen.
#[derive(Debug, Clone)]
pub struct FlankShapes {
    /// The surface, over the plan's grid.
    pub surface: FlankSurface,
    /// For each path the deviations of the standing and of the moving cutter, as the surface's vertices; NaN above the
    /// flutes.
    values: [[Arc<Vec<f32>>; 2]; 3],
    /// Whether the flutes are too short for a part of the surface, which has the colour of a surface without a plan.
    pub has_unmilled: bool,
    /// The greatest deviation either way of any path (mm).
    pub greatest: f64,
    axes: [Arc<RenderMesh>; 3],
    cutter: CutterShape,
}

/// A cutter made for the screen, its bottom centre at zero and its axis along +Z.
#[derive(Debug, Clone)]
struct CutterShape {
    flutes: Arc<RenderMesh>,
    holder: Option<Arc<RenderMesh>>,
}

impl FlankSurface {
    /// The surface at `size` places along u and v.
    pub fn of(surface: &RuledSurface, size: [usize; 2]) -> Self {
        let size = size.map(|n| n.max(2));
        let share = |i: usize, n: usize| i as f64 / (n - 1) as f64;
        let vertices: Vec<DVec3> = (0..size[0] * size[1])
            .map(|k| surface.point(share(k / size[1], size[0]), share(k % size[1], size[1])))
            .collect();
        let mesh = Mesh { triangles: lattice(size), vertices };
        let rulings = (0..=RULINGS).map(|i| share(i, RULINGS + 1));
        let rulings = rulings.map(|u| vec![surface.point(u, 0.0), surface.point(u, 1.0)]).collect();
        let normal = (0..=8).map(|i| surface.normal(f64::from(i) / 8.0, 0.5)).sum::<DVec3>().normalize_or_zero();
        let made = Self {
            shape: Arc::new(RenderMesh::new(&mesh)),
            rulings,
            middle: surface.point(0.5, 0.5),
            normal,
            along: surface.point(1.0, 0.5) - surface.point(0.0, 0.5),
            across: 0.5 * (surface.point(0.0, 1.0) + surface.point(1.0, 1.0))
                - 0.5 * (surface.point(0.0, 0.0) + surface.point(1.0, 0.0)),
            is_round: false,
        };
        made.seen_round(&mesh.vertices)
    }

    /// The surface with the directions in which it is seen as a whole, where its ends are near to each other for its
    /// width: the way from one end to the other is then no measure of it.
    fn seen_round(self, vertices: &[DVec3]) -> Self {
        let across = self.rulings.iter().map(|r| r[1] - r[0]).sum::<DVec3>() / self.rulings.len() as f64;
        let up = across.normalize_or_zero();
        let extent = |way: DVec3| {
            let heights = vertices.iter().map(|p| p.dot(way));
            let [low, high] =
                heights.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high]: [f64; 2], x| [low.min(x), high.max(x)]);
            high - low
        };
        let [aside, towards] = [up.any_orthonormal_vector(), up.cross(up.any_orthonormal_vector())];
        let width = extent(aside).max(extent(towards));
        if up == DVec3::ZERO || !width.is_finite() || self.along.reject_from(up).length() >= SHORT * width {
            return self;
        }
        // From where most of it looks to, or, all around a ring, from the same side each time.
        let normal = self.normal.reject_from(up).try_normalize().filter(|_| !self.is_ring(width)).unwrap_or(towards);
        let way = up.cross(normal);
        let middle = vertices.iter().sum::<DVec3>() / vertices.len().max(1) as f64;
        Self { middle, normal, along: extent(way) * way, across, is_round: true, ..self }
    }

    /// Whether its ends meet, for what is `width` wide (mm).
    fn is_ring(&self, width: f64) -> bool {
        self.along.length() < 1e-3 * width
    }

    /// A surface without a plan.
    pub fn bare(surface: &RuledSurface) -> Self {
        Self::of(surface, BARE)
    }

    /// From one surface to the next of several side by side (mm): long ones stand above each other.
    fn step(&self) -> DVec3 {
        let is_long = self.along.length() > 1.6 * self.across.length();
        // Rings above each other would cover each other.
        if is_long && !self.is_round { -APART * self.across } else { APART * self.along }
    }

    /// Onto the surface from the cutter's side, so that a box around it fills a picture `aspect` times as wide as high;
    /// `straight` for square to it, with nothing foreshortened.
    pub fn camera(&self, bounds: &Bounds, from: Camera, aspect: f64, straight: bool) -> Camera {
        let (up, along) = (self.across.normalize_or_zero(), self.along.normalize_or_zero());
        let towards = if straight { self.normal } else { self.normal + 0.45 * up - 0.35 * along };
        if towards.cross(up).length() < 1e-6 {
            return from;
        }
        let mut camera = Camera { orientation: looking(towards, up), ..from };
        camera.fit(bounds, aspect);
        camera
    }

    /// A box around a place of it that is worth looking at (mm).
    pub fn around(&self, place: DVec3) -> Bounds {
        Bounds { min: place, max: place }.grown(0.12 * (self.along.length() + self.across.length()))
    }
}

/// Triangles of a lattice whose second index runs faster.
fn lattice([n, m]: [usize; 2]) -> Vec<[u32; 3]> {
    let index = |i: usize, j: usize| (i * m + j) as u32;
    let cells = (1..n).flat_map(|i| (1..m).map(move |j| (i, j)));
    let quads = cells.map(|(i, j)| [index(i - 1, j - 1), index(i, j - 1), index(i, j), index(i - 1, j)]);
    quads.flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]).collect()
}

/// A body of revolution about Z through (radius, height), closed at both ends.
fn revolved(profile: &[(f64, f64)]) -> Mesh {
    let (n, rows) = (CORNERS as u32, profile.len() as u32);
    let ring = |(r, z): (f64, f64)| {
        (0..CORNERS).map(move |i| {
            let (sin, cos) = (TAU * i as f64 / CORNERS as f64).sin_cos();
            DVec3::new(r * cos, r * sin, z)
        })
    };
    let mut vertices: Vec<DVec3> = profile.iter().flat_map(|p| ring(*p)).collect();
    let ends = [profile.first(), profile.last()].map(|p| p.map_or(0.0, |p| p.1));
    vertices.extend(ends.map(|z| DVec3::new(0.0, 0.0, z)));
    let mut triangles = Vec::new();
    for i in 0..n {
        let next = (i + 1) % n;
        for row in 1..rows {
            let (low, high) = ((row - 1) * n, row * n);
            triangles.extend([[low + i, low + next, high + next], [low + i, high + next, high + i]]);
        }
        triangles.push([rows * n, next, i]);
        triangles.push([rows * n + 1, (rows - 1) * n + i, (rows - 1) * n + next]);
    }
    Mesh { vertices, triangles }
}

impl CutterShape {
    fn of(cutter: &FlankCutter) -> Self {
        let profile = [(cutter.radius_mm, 0.0), (cutter.radius_at(cutter.length_mm), cutter.length_mm)];
        let mut height = cutter.length_mm;
        let mut profile_above = Vec::new();
        for part in &cutter.holder {
            profile_above.push((part.lower_radius_mm, height));
            height += part.length_mm;
            profile_above.push((part.upper_radius_mm, height));
        }
        let made = |profile: &[(f64, f64)]| Arc::new(RenderMesh::new(&revolved(profile)));
        let holder = (!profile_above.is_empty()).then(|| made(&profile_above));
        Self { flutes: made(&profile), holder }
    }
}

impl FlankShapes {
    /// The shapes of a plan.
    pub fn of(surface: &RuledSurface, plan: &FlankPlan) -> Self {
        let paths = [&plan.initial, &plan.chosen, &plan.refined];
        let touching = plan.cutter.above(plan.params.below_mm).unwrap_or_else(|_| plan.cutter.clone());
        let highest = plan.cutter.length_mm + ROUNDING_MM;
        let values = |path: &FlankPath, deviation: &Deviation| {
            let value = |(v, height): (&f64, f64)| if height > highest { f32::NAN } else { *v as f32 };
            Arc::new(deviation.values.iter().zip(path.contact_heights(&touching)).map(value).collect::<Vec<_>>())
        };
        let most = |d: &Deviation| d.most_overcut.abs().max(d.most_undercut.abs());
        let values = paths.map(|p| [values(p, &p.deviation), values(p, &p.envelope.deviation)]);
        Self {
            surface: FlankSurface::of(surface, plan.initial.deviation.grid),
            has_unmilled: values.iter().flatten().any(|values| values.iter().any(|value| value.is_nan())),
            values,
            greatest: paths.into_iter().map(|p| most(&p.deviation)).fold(0.0, f64::max),
            axes: paths.map(|p| Arc::new(RenderMesh::new(&swept_by_axis(p)))),
            cutter: CutterShape::of(&plan.cutter),
        }
    }

    /// The end of the colours' scale (mm), the same for all paths: the greatest deviation, rounded up.
    pub fn limit(&self) -> f64 {
        let greatest = if self.greatest.is_finite() { self.greatest.max(LEAST_LIMIT) } else { LEAST_LIMIT };
        let decade = 10f64.powf(greatest.log10().floor());
        [1.0, 2.0, 3.0, 4.0, 6.0, 8.0, 10.0]
            .map(|s| s * decade)
            .into_iter()
            .find(|s| *s >= 0.999_999 * greatest)
            .unwrap_or(greatest)
    }

    /// What the colours mean.
    pub fn legend(&self) -> Legend {
        let (title, unit) = ("Deviation".to_owned(), "mm".to_owned());
        let max = self.limit();
        Legend { title, unit, map: ColourMap::Diverging, min: -max, max, threshold: None }
    }
}

/// The surface that the axis of a path sweeps, from the bottom centre to the other guide's side.
fn swept_by_axis(path: &FlankPath) -> Mesh {
    const ALONG: usize = 65;
    let ends = |i: usize| {
        let at = path.axis.at(i as f64 / (ALONG - 1) as f64);
        [at.tip, at.top]
    };
    Mesh { vertices: (0..ALONG).flat_map(ends).collect(), triangles: lattice([ALONG, 2]) }
}

/// Where the cutter at `t` is over the surface: places (u, v) with their deviation (mm), from the lower guide up.
/// Places that no place of the path at `t` stands over are left out.
pub fn contact_line(path: &FlankPath, t: f64) -> Vec<[f64; 3]> {
    let [n, m] = path.deviation.grid;
    let foot = |i: usize, j: usize| path.feet.at.get(i * m + j).map_or(f64::NAN, |q| q.x);
    let value = |i: usize, j: usize| path.deviation.at(i, j).unwrap_or(f64::NAN);
    let mut line = Vec::new();
    for j in 0..m {
        let between = (1..n).find(|i| (foot(i - 1, j) - t) * (foot(*i, j) - t) <= 0.0);
        let Some(i) = between else { continue };
        let (before, after) = (foot(i - 1, j), foot(i, j));
        let share = if after == before { 0.0 } else { (t - before) / (after - before) };
        let u = (i as f64 - 1.0 + share) / (n - 1) as f64;
        let deviation = value(i - 1, j) + share * (value(i, j) - value(i - 1, j));
        line.push([u, j as f64 / (m - 1) as f64, deviation]);
    }
    line
}

/// What a scene of a flank is made from.
#[derive(Clone, Copy)]
pub struct FlankScene<'a> {
    /// The surface; its plan's if there is one.
    pub surface: Option<&'a FlankSurface>,
    /// The plan's.
    pub shapes: Option<&'a FlankShapes>,
    /// The paths that are shown, side by side if there are several.
    pub paths: &'a [PathChoice],
    /// Whether the colours are those of the moving cutter.
    pub moving: bool,
    /// Pose of the cutter on each path, if it is shown.
    pub poses: &'a [FlankPose],
    /// Line of contact on the surface at that pose, for each path.
    pub contacts: &'a [Vec<DVec3>],
    /// Line of the cutter's bottom centre, for each path.
    pub tips: &'a [Vec<DVec3>],
    /// Whether the surface of the axis is shown.
    pub shows_axis: bool,
    /// Whether rulings are drawn.
    pub shows_rulings: bool,
    /// The part that the flank is of.
    pub part: Option<&'a Arc<RenderMesh>>,
    /// Walls that must not be cut.
    pub walls: Option<&'a Arc<RenderMesh>>,
    /// A place that is pointed at.
    pub place: Option<DVec3>,
    /// Where the cutter's side is to be chosen: a place of the surface, and the unit vector to its positive side.
    pub open_side: Option<[DVec3; 2]>,
    /// Colours of the surroundings.
    pub theme: Theme,
}

impl FlankScene<'_> {
    /// How far each of the shown paths is moved from its place.
    fn offset(&self, i: usize) -> DVec3 {
        let step = self.surface.filter(|_| self.paths.len() > 1).map_or(DVec3::ZERO, FlankSurface::step);
        step * i as f64
    }

    /// The names of paths that are side by side, and where they stand.
    pub fn names(&self) -> Vec<(DVec3, &'static str)> {
        let Some(surface) = self.surface.filter(|_| self.paths.len() > 1) else { return Vec::new() };
        let corner = surface.middle - 0.5 * surface.along + 0.56 * surface.across;
        self.paths.iter().enumerate().map(|(i, path)| (corner + self.offset(i), path.name())).collect()
    }

    /// The ends of the arrows to both sides of the surface, the positive one first, while the side is to be chosen.
    pub fn sides(&self) -> Option<[DVec3; 2]> {
        let ([at, normal], surface) = (self.open_side?, self.surface?);
        let reach = ARROW * (surface.along.length() + surface.across.length());
        Some([at + reach * normal, at - reach * normal])
    }

    /// An arrow from a place of the surface to `tip`: its shaft and both barbs.
    fn arrow(&self, at: DVec3, tip: DVec3) -> LineSet {
        let (way, aside) = (tip - at, self.surface.map_or(DVec3::X, |s| s.along.normalize_or(DVec3::X)));
        let barb = |sign: f64| vec![tip - 0.2 * way + sign * 0.08 * way.length() * aside, tip];
        let lines = vec![vec![at, tip], barb(1.0), barb(-1.0)];
        LineSet { width_px: 3.0, on_top: true, ..LineSet::new(lines, self.theme.accent) }
    }

    /// The scene, in the axes of the surface.
    pub fn build(&self) -> Scene {
        let mut scene = Scene { triad: false, ..Scene::new(self.theme) };
        let flat = |id: u32, shape: &Arc<RenderMesh>, colour| {
            let object = Object::new(ObjectId(id), shape.clone(), colour);
            Object { edges: false, ..object }
        };
        for i in 0..self.paths.len().max(1) {
            let to = DAffine3::from_translation(self.offset(i));
            if let Some(surface) = self.surface {
                let mut object = flat(FIRST_SURFACE + i as u32, &surface.shape, STEEL).at(to);
                object.values = self.shapes.zip(self.paths.get(i)).map(|(shapes, path)| {
                    let limit = shapes.limit() as f32;
                    let values = shapes.values[*path as usize][usize::from(self.moving)].clone();
                    SurfaceValues { values, map: ColourMap::Diverging, range: [-limit, limit] }
                });
                scene.objects.push(object);
                scene.lines.extend(self.lines(surface, i));
            }
            if let (Some(shapes), Some(path)) = (self.shapes, self.paths.get(i)) {
                if self.shows_axis {
                    let shape = &shapes.axes[*path as usize];
                    scene.objects.push(flat(FIRST_AXIS + i as u32, shape, HIGH).at(to).with_opacity(AXIS_OPACITY));
                }
                scene.objects.extend(self.poses.get(i).into_iter().flat_map(|pose| {
                    let opacity = if self.paths.len() > 1 { CUTTERS_OPACITY } else { CUTTER_OPACITY };
                    cutter(shapes, pose, i, to).into_iter().map(move |part| part.with_opacity(opacity))
                }));
            }
        }
        if self.paths.len() < 2 {
            let wall = |id, shape: &Arc<RenderMesh>, colour| {
                Object::new(ObjectId(id), shape.clone(), colour).with_opacity(WALL_OPACITY)
            };
            scene.objects.extend(self.part.map(|shape| wall(PART, shape, STEEL)));
            scene.objects.extend(self.walls.map(|shape| wall(WALLS, shape, MACHINE)));
        }
        if let (Some([at, _]), Some(tips)) = (self.open_side, self.sides()) {
            scene.lines.extend(tips.map(|tip| self.arrow(at, tip)));
        }
        scene.markers.extend(self.place.map(|at| Marker { at, colour: BAD, radius_px: 6.0 }));
        scene.grid = if self.paths.len() > 1 { None } else { Grid::below(&scene.bounds()) };
        scene
    }

    /// Rulings and guides, the line that the cutter is over, and the way of its bottom.
    fn lines(&self, surface: &FlankSurface, i: usize) -> Vec<LineSet> {
        let off = self.offset(i);
        let moved = |line: &Vec<DVec3>| line.iter().map(|p| *p + off).collect::<Vec<_>>();
        let mut sets = Vec::new();
        if self.shows_rulings {
            let rulings = surface.rulings.iter().map(moved).collect();
            sets.push(LineSet { width_px: 0.8, ..LineSet::new(rulings, self.theme.grid) });
        }
        if let Some(contact) = self.contacts.get(i).filter(|line| line.len() > 1) {
            sets.push(LineSet { width_px: 3.0, on_top: true, ..LineSet::new(vec![moved(contact)], self.theme.accent) });
        }
        if let Some(tips) = self.tips.get(i).filter(|line| line.len() > 1 && self.shows_axis) {
            sets.push(LineSet { width_px: 1.5, ..LineSet::new(vec![moved(tips)], self.theme.accent) });
        }
        sets
    }
}

/// The cutter at a pose of path number `i`, moved by `to`.
fn cutter(shapes: &FlankShapes, pose: &FlankPose, i: usize, to: DAffine3) -> Vec<Object> {
    let turn = DMat3::from_quat(DQuat::from_rotation_arc(DVec3::Z, pose.axis.normalize_or(DVec3::Z)));
    let at = to * DAffine3::from_mat3_translation(turn, pose.tip);
    let part =
        |id: u32, shape: &Arc<RenderMesh>, colour| Object::new(ObjectId(id + i as u32), shape.clone(), colour).at(at);
    let flutes = part(FIRST_CUTTER, &shapes.cutter.flutes, FLUTES);
    let holder = shapes.cutter.holder.as_ref().map(|shape| part(FIRST_HOLDER, shape, MACHINE));
    std::iter::once(flutes).chain(holder).collect()
}

/// Whether an object of a scene of a flank is a surface, and the number of its path among those shown.
pub fn flank_surface_of(id: ObjectId) -> Option<usize> {
    (id.0 < FIRST_AXIS).then_some((id.0 - FIRST_SURFACE) as usize)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::workspaces::flank::document::DemonstrationSurface;
    use flank::guide::GuideCurve;
    use flank::params::FlankParams;
    use flank::plan::plan_flank;
    use flank::ruled_surface::Side;
    use task::Task;

    #[test]
    fn a_cutter_is_closed_and_has_the_volume_of_its_cone() {
        let cutter = FlankCutter::cone(1.0, 5.0, 20.0);
        let mesh = revolved(&[(1.0, 0.0), (cutter.radius_at(20.0), 20.0)]);
        let top = 1.0 + 20.0 * 5f64.to_radians().tan();
        let volume = std::f64::consts::PI * 20.0 / 3.0 * (1.0 + top + top * top);
        let share = mesh.volume() / volume;
        assert!(mesh.is_watertight() && share < 1.0 && share > 0.99, "{share}");
    }

    #[test]
    fn a_ring_and_two_more_of_it_stand_beside_each_other_and_are_seen_square() {
        // Frustums whose guides are circles, or three quarters of them, of any direction that is up.
        let circle = |radius: f64, turn: f64, up: DVec3, height: f64| {
            let (x, y) = (up.any_orthonormal_vector(), up.cross(up.any_orthonormal_vector()));
            let at = |i: i32| TAU * turn * f64::from(i) / 48.0;
            let points = (0..=48).map(|i| radius * (at(i).cos() * x + at(i).sin() * y) + height * up).collect();
            GuideCurve::Points { points, degree: 3 }
        };
        for (turn, up) in [(1.0, DVec3::Z), (1.0, DVec3::new(0.6, 0.0, 0.8)), (0.9, DVec3::Y)] {
            let [lower, upper] = [(20.0, 0.0), (17.0, 10.0)].map(|(r, height)| circle(r, turn, up, height));
            let surface = RuledSurface::from_guides(&lower, &upper, Side::Positive).unwrap();
            let shown = FlankSurface::bare(&surface);
            // The circle is as wide as its diameter from every side.
            assert!((shown.along.length() - 40.0).abs() < 4.0, "{turn}: {}", shown.along.length());
            assert!((shown.across - 10.0 * up).length() < 0.3 * shown.across.length(), "{turn}: {}", shown.across);
            assert!(shown.step().length() > shown.along.length() && shown.step().dot(shown.across).abs() < 1e-6);
            // Square to it, with what is up upwards.
            assert!((shown.normal.length() - 1.0).abs() < 1e-9 && shown.normal.dot(shown.across).abs() < 1e-6);
            assert!(shown.normal.dot(shown.along).abs() < 1e-6);
        }
    }

    #[test]
    fn side_by_side_each_path_has_its_own_colours_on_the_same_scale_and_its_cutter_beside_them() {
        let guides = DemonstrationSurface::A.guides().unwrap();
        let surface = RuledSurface::from_guides(&guides.lower, &guides.upper, Side::Positive).unwrap();
        let params = FlankParams { grid: [21, 9], rounds: 2, ..FlankParams::default() };
        let cutter = FlankCutter::cone(1.0, 5.0, 20.0);
        let plan = plan_flank(&surface, &cutter, &params, &Task::default()).unwrap();
        let shapes = FlankShapes::of(&surface, &plan);
        assert!(shapes.limit() >= shapes.greatest && shapes.limit() <= 2.0 * shapes.greatest);
        let poses = [plan.initial.pose(0.5), plan.chosen.pose(0.5), plan.refined.pose(0.5)];
        let scene = FlankScene {
            surface: Some(&shapes.surface),
            shapes: Some(&shapes),
            paths: &PathChoice::ALL,
            moving: false,
            poses: &poses,
            contacts: &[],
            tips: &[],
            shows_axis: false,
            shows_rulings: true,
            part: None,
            walls: None,
            place: None,
            open_side: None,
            theme: Theme::DARK,
        };
        let built = scene.build();
        let surfaces: Vec<&Object> = built.objects.iter().filter(|o| flank_surface_of(o.id).is_some()).collect();
        assert_eq!((surfaces.len(), built.objects.len(), scene.names().len()), (3, 6, 3));
        let boxes: Vec<Bounds> = surfaces.iter().map(|o| o.bounds()).collect();
        let step = shapes.surface.step().normalize();
        let reach = |b: &Bounds| b.center().dot(step);
        assert!(reach(&boxes[0]) < reach(&boxes[1]) && reach(&boxes[1]) < reach(&boxes[2]));
        let ranges: Vec<_> = surfaces.iter().map(|o| o.values.as_ref().unwrap().range).collect();
        assert!(ranges[0] == ranges[1] && ranges[1] == ranges[2] && ranges[0][0] == -ranges[0][1]);

        // The line that the cutter is over has the deviations of the standing cutter where the feet say so.
        let line = contact_line(&plan.initial, 0.5);
        assert_eq!(line.len(), 9);
        for [u, v, deviation] in line {
            let foot = surface.point(u, v);
            let pose = plan.initial.pose(0.5);
            let off = foot - pose.tip;
            let height = off.dot(pose.axis);
            let distance = (off - height * pose.axis).length();
            // Distance from the cone along its own normal.
            let (sin, cos) = cutter.half_angle().sin_cos();
            let from_cone = (distance - cutter.radius_mm) * cos - height * sin;
            assert!((from_cone - deviation).abs() < 2e-3, "{from_cone} {deviation}");
        }
    }

    #[test]
    fn above_flutes_that_are_too_short_nothing_is_coloured() {
        let guides = DemonstrationSurface::A.guides().unwrap();
        let surface = RuledSurface::from_guides(&guides.lower, &guides.upper, Side::Positive).unwrap();
        let params = FlankParams { grid: [21, 9], rounds: 0, below_mm: 1.0, ..FlankParams::default() };
        let shapes = |length_mm: f64| {
            let cutter = FlankCutter::cone(1.0, 5.0, length_mm);
            FlankShapes::of(&surface, &plan_flank(&surface, &cutter, &params, &Task::default()).unwrap())
        };
        let (long, short) = (shapes(40.0), shapes(8.0));
        assert!(!long.has_unmilled && short.has_unmilled);
        for (all, some) in long.values.iter().flatten().zip(short.values.iter().flatten()) {
            for (k, (all, some)) in all.iter().zip(some.iter()).enumerate() {
                let [u, v] = [(k / 9) as f64 / 20.0, (k % 9) as f64 / 8.0];
                let height = params.below_mm + v * surface.point(u, 0.0).distance(surface.point(u, 1.0));
                assert!(some.is_nan() || some == all && height < 9.0, "{u} {v}: {all} {some} {height}");
                assert!(!some.is_nan() || height > 7.0, "{u} {v}: {height}");
            }
        }
    }
}
