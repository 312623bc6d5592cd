//! The stock left on the surfaces of a channel, or what measured sections are off, as colours: in place, and unfolded into a
//! plane.

use std::collections::{BTreeSet, HashMap};
use std::sync::Arc;

use glam::{DAffine3, DMat3, DVec3};

use crate::widgets::theme::STEEL;
use crate::workspaces::blisk::scene::{Layer, from_w, layer_id};
use feed::residual_stock::DeviationMap;
use geometry::frame::Frame;
use geometry::mesh::{Bounds, Mesh, normal_times_two_areas};
use measured::deviation::{Deviation, DeviationMap as PointDeviations};
use render::colour_map::{ColourMap, Legend};
use render::mesh::RenderMesh;
use render::scene::{Object, SurfaceValues};
use wheel::channel::{Channel, Surface};

/// How far before the blisk's own surface the map is shown (mm), so that the one does not shine through the other.
const BEFORE: f64 = 0.03;
/// The most points of a scan that are shown.
const MOST_POINTS: usize = 300_000;
/// Least and greatest size of a point of a scan (mm).
const POINT_SIZES: [f64; 2] = [0.03, 1.0];
/// Room between the unfolded surfaces (mm).
const ROOM: f64 = 1.5;

/// A map made for the screen.
#[derive(Debug, Clone)]
pub struct MapShape {
    /// Hub and walls, in W.
    pub shape: Arc<RenderMesh>,
    /// Thickness of the stock left, or deviation, at its vertices (mm).
    pub values: Arc<Vec<f32>>,
    /// The greatest value either way on any surface, the shroud as well (mm).
    pub greatest: f64,
}

impl MapShape {
    /// The surfaces of `map` that one sees who looks into the channel: all but the shroud.
    pub fn new(map: &DeviationMap) -> Self {
        let (mesh, values) = part_of(map, |surface| surface != Surface::Shroud);
        let mut normals = vec![DVec3::ZERO; mesh.vertices.len()];
        for (triangle, corners) in mesh.triangles.iter().zip(mesh.iter_corners()) {
            triangle.iter().for_each(|&v| normals[v as usize] += normal_times_two_areas(corners));
        }
        let before = |(p, n): (&DVec3, &DVec3)| p + BEFORE * n.normalize_or_zero();
        let vertices = mesh.vertices.iter().zip(&normals).map(before).collect();
        let shape = RenderMesh::new(&Mesh { vertices, triangles: mesh.triangles });
        Self { shape: Arc::new(shape), values: Arc::new(values), greatest: greatest(map) }
    }

    /// The points of a scan on the triangles of the part's `mesh` that are `shown`, each as a small triangle on the part.
    /// `frame` is W.
    pub fn of_points(map: &PointDeviations, mesh: &Mesh, frame: &Frame, shown: impl Fn(u32) -> bool) -> Self {
        let all: Vec<&Deviation> = map.list().iter().filter(|of| shown(of.triangle)).collect();
        let every = all.len().div_ceil(MOST_POINTS).max(1);
        let size = point_size(&all, mesh, every);
        let (mut spots, mut values) = (Mesh::default(), Vec::new());
        for of in all.iter().step_by(every) {
            let normal = frame.direction_from_parent(normal_times_two_areas(mesh.corners(of.triangle as usize)));
            let normal = normal.normalize_or(DVec3::Z);
            let (side, other) = normal.any_orthonormal_pair();
            let at = frame.from_parent(of.nearest) + BEFORE * normal;
            let first = spots.vertices.len() as u32;
            let corners = [side, -0.5 * side + 0.75_f64.sqrt() * other, -0.5 * side - 0.75_f64.sqrt() * other];
            spots.vertices.extend(corners.map(|corner| at + size * corner));
            spots.triangles.push([first, first + 1, first + 2]);
            values.extend([of.distance as f32; 3]);
        }
        let greatest = all.iter().fold(0.0, |most: f64, of| most.max(of.distance.abs()));
        Self { shape: Arc::new(RenderMesh::new(&spots)), values: Arc::new(values), greatest }
    }

    /// Colours of the surface, up to `limit` (mm) either way.
    pub fn values(&self, limit: f64) -> SurfaceValues {
        surface_values(self.values.clone(), limit)
    }
}

/// Distance of a corner of a point's triangle from the point (mm): as far as the points lie apart on the triangles of the part
/// that have some.
fn point_size(all: &[&Deviation], mesh: &Mesh, every: usize) -> f64 {
    let met: BTreeSet<u32> = all.iter().map(|of| of.triangle).collect();
    let twice: f64 = met.iter().map(|triangle| normal_times_two_areas(mesh.corners(*triangle as usize)).length()).sum();
    let each = 0.5 * twice * every as f64 / all.len().max(1) as f64;
    each.sqrt().clamp(POINT_SIZES[0], POINT_SIZES[1])
}

/// The greatest deviation of `map` either way (mm).
pub(super) fn greatest(map: &DeviationMap) -> f64 {
    map.deviation.iter().filter(|v| v.is_finite()).fold(0.0, |most, v| most.max(f64::from(v.abs())))
}

/// Where the colours of a map end whose greatest value is `greatest`: the next round value, and no less than the spark
/// gap (mm).
pub fn colour_limit(greatest: f64, spark_gap: f64) -> f64 {
    let most = greatest.max(spark_gap);
    if !(most > 0.0 && most.is_finite()) {
        return spark_gap;
    }
    let decade = 10f64.powf(most.log10().floor());
    // Values come in single precision.
    let round = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0].map(|step| step * decade);
    round.into_iter().find(|limit| *limit >= most * (1.0 - 1e-6)).unwrap_or(10.0 * decade)
}

/// Title of the map of what a scan is off.
pub const SCANNED: &str = "Scan, out of the metal";
/// Title of the map of what measured sections are off.
pub const DEVIATION: &str = "Measured, into the channel";

/// What the colours mean, up to `limit` (mm) either way.
pub fn residual_stock_legend(limit: f64) -> Legend {
    map_legend("Residual stock", limit)
}

/// What the colours of a map of this `title` mean, up to `limit` (mm) either way.
pub fn map_legend(title: &str, limit: f64) -> Legend {
    Legend {
        title: title.to_owned(),
        unit: "mm".to_owned(),
        map: ColourMap::Diverging,
        min: -limit,
        max: limit,
        threshold: None,
    }
}

fn surface_values(values: Arc<Vec<f32>>, limit: f64) -> SurfaceValues {
    let legend = residual_stock_legend(limit);
    SurfaceValues { values, map: legend.map, range: [legend.min as f32, legend.max as f32] }
}

/// The triangles of the wanted surfaces with the vertices that they use, and the values of these.
fn part_of(map: &DeviationMap, wanted: impl Fn(Surface) -> bool) -> (Mesh, Vec<f32>) {
    let (mut part, mut values, mut known) = (Mesh::default(), Vec::new(), HashMap::new());
    for (triangle, _) in map.mesh.triangles.iter().zip(&map.surfaces).filter(|(_, s)| wanted(**s)) {
        part.triangles.push(triangle.map(|v| {
            *known.entry(v).or_insert_with(|| {
                part.vertices.push(map.mesh.vertices[v as usize]);
                values.push(map.deviation.get(v as usize).copied().unwrap_or(f32::NAN));
                part.vertices.len() as u32 - 1
            })
        }));
    }
    (part, values)
}

/// The surfaces of the channel as one would unfold a box, all seen from within: along Y from below high wall, hub, low
/// wall and, where there is one, shroud. Returns them, in the coordinates of the loaded mesh, with the box around them
/// in W.
pub(super) fn unfolded(map: &DeviationMap, channel: &Channel, limit: f64) -> (Vec<Object>, Bounds) {
    let to_mesh = from_w(&channel.frame);
    // From hub to shroud becomes upwards, whichever way the passage runs.
    let up = channel.line_at(channel.middle().along).up;
    let lean = DMat3::from_rotation_y(-up.x.atan2(up.y));
    let mut top = f64::NEG_INFINITY;
    let (mut objects, mut around) = (Vec::new(), Bounds::EMPTY);
    // From the hub's top edge upwards, then the high wall below it all.
    for surface in [Surface::Hub, Surface::LowWall, Surface::Shroud, Surface::HighWall] {
        let (part, values) = part_of(map, |s| s == surface);
        if part.triangles.is_empty() {
            continue;
        }
        let turn = opened(surface) * lean;
        let turned = part.mapped(|p| turn * p);
        let bounds = turned.bounds();
        let y = match surface {
            _ if around.min.x > around.max.x => 0.0,
            Surface::HighWall => around.min.y - ROOM - bounds.max.y,
            _ => top + ROOM - bounds.min.y,
        };
        let shift = DVec3::new(0.0, y, -bounds.center().z);
        let placed = Bounds { min: bounds.min + shift, max: bounds.max + shift };
        around = Bounds { min: around.min.min(placed.min), max: around.max.max(placed.max) };
        top = around.max.y;
        let at = to_mesh * DAffine3 { matrix3: turn, translation: shift };
        let mesh = Arc::new(RenderMesh::new(&part));
        let object = Object::new(layer_id(Layer::Blisk), mesh, STEEL).at(at);
        objects.push(Object { edges: false, values: Some(surface_values(Arc::new(values), limit)), ..object });
    }
    (objects, around)
}

/// The turn that makes a surface of the channel look along Z: the low wall looks along -Y, the high one along Y.
fn opened(surface: Surface) -> DMat3 {
    let quarters = match surface {
        Surface::LowWall => -1.0,
        Surface::HighWall => 1.0,
        Surface::Shroud => 2.0,
        Surface::Hub | Surface::Elsewhere | Surface::Obstacle => 0.0,
    };
    DMat3::from_rotation_x(quarters * std::f64::consts::FRAC_PI_2)
}

#[cfg(test)]
mod tests {
    use super::*;
    use wheel::fixtures::exact_channel;
    use wheel::parametric::ParametricBlisk;

    /// One triangle on each surface of a channel, seen from within.
    fn map() -> DeviationMap {
        let triangle = |p: DVec3, u: DVec3, v: DVec3| [p, p + u, p + v];
        let (x, y, z) = (DVec3::X, DVec3::Y, DVec3::Z);
        let corners = [
            triangle(DVec3::new(0.0, 0.0, 100.0), x, y),
            triangle(DVec3::new(0.0, 5.0, 105.0), x, z),
            triangle(DVec3::new(0.0, -5.0, 105.0), z, x),
            triangle(DVec3::new(0.0, 0.0, 110.0), y, x),
        ];
        let mesh =
            Mesh { vertices: corners.concat(), triangles: (0..4u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect() };
        let surfaces = vec![Surface::Hub, Surface::LowWall, Surface::HighWall, Surface::Shroud];
        let deviation = (0..12).map(|i| i as f32).collect::<Vec<_>>();
        DeviationMap { mesh: Arc::new(mesh), surfaces, deviation: Arc::new(deviation) }
    }

    #[test]
    fn every_surface_is_seen_from_within_and_none_lies_upon_another() {
        let map = map();
        let channel = exact_channel(&ParametricBlisk::default());
        let (objects, around) = unfolded(&map, &channel, 0.1);
        assert_eq!(objects.len(), 4);
        let surfaces = [Surface::Hub, Surface::LowWall, Surface::Shroud, Surface::HighWall];
        for (object, surface) in objects.iter().zip(surfaces) {
            let (part, _) = part_of(&map, |s| s == surface);
            let normal = object.transform.matrix3 * normal_times_two_areas(part.corners(0));
            assert!(normal.normalize().z > 0.99, "{surface:?} {normal}");
        }
        let mut spans: Vec<[f64; 2]> = objects.iter().map(|o| [o.bounds().min.y, o.bounds().max.y]).collect();
        spans.sort_by(|a, b| a[0].total_cmp(&b[0]));
        assert!(spans.windows(2).all(|w| w[0][1] < w[1][0]), "{spans:?}");
        assert!((around.min.y - spans[0][0]).abs() < 1e-5 && (around.max.y - spans[3][1]).abs() < 1e-5);
    }

    #[test]
    fn colours_end_at_a_round_value_that_nothing_exceeds() {
        for (greatest, gap, limit) in
            [(0.154, 0.1, 0.2), (0.02, 0.1, 0.1), (f64::from(0.2f32), 0.1, 0.2), (0.61, 0.1, 0.8), (0.9, 0.1, 1.0)]
        {
            assert!((colour_limit(greatest, gap) - limit).abs() < 1e-9, "{greatest}: {}", colour_limit(greatest, gap));
        }
    }

    #[test]
    fn the_shape_leaves_the_shroud_out_and_keeps_the_values() {
        let shape = MapShape::new(&map());
        assert_eq!(shape.greatest, 11.0, "that of the shroud");
        assert_eq!(*shape.values, (0..9).map(|i| i as f32).collect::<Vec<_>>());
        assert!((shape.shape.bounds().min.z - (100.0 + BEFORE)).abs() < 1e-5);
    }
}
