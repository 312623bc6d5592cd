//! Points at which an electrode is measured on its holder: on its base and on its burning faces, with normals, where a ball
//! touches nothing else.

use files::report::quoted;
use geometry::exact::ExactMesh;
use geometry::inside::guarded_distance;
use geometry::mesh::{Mesh, normal_times_two_areas, unit_normal};
use glam::DVec3;
use serde::{Deserialize, Serialize};

/// Radii of balls: the largest that finds [`ENOUGH`] points is taken, else that which finds most (mm).
const BALLS: [f64; 3] = [1.0, 0.5, 0.25];
/// Places of a surface that are tried.
const TRIED: usize = 160;
/// Points with which a surface is told from a turned one.
const ENOUGH: usize = 3;
/// How far the surface may fall away from the plane of a point within the radius of the ball, as a share of the radius.
const FLAT: f64 = 0.2;

/// A point to be measured.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MeasuringPoint {
    /// Surface of the electrode that it lies on.
    pub surface: String,
    /// Nominal place (mm).
    pub point_mm: [f64; 3],
    /// Unit normal out of the electrode, against which it is touched.
    pub normal: [f64; 3],
    /// Radius of the largest ball of 1, 0.5 and 0.25 mm that touches it and nothing else (mm). The stylus that carries the ball
    /// is not considered.
    pub ball_radius_mm: f64,
}

/// Points of the closed electrode `mesh`, at most `most` of each of the `surfaces`, in the axes of the mesh. `surface_of` is the
/// surface of each triangle; triangles of others are not measured. A surface on which no ball finds room has none.
pub fn measuring_points(
    mesh: &Mesh,
    surfaces: &[&str],
    surface_of: &[Option<usize>],
    most: usize,
) -> Vec<MeasuringPoint> {
    let Ok(exact) = ExactMesh::new(mesh) else { return Vec::new() };
    let triangles: Vec<[DVec3; 3]> = mesh.iter_corners().collect();
    let mut points = Vec::new();
    for (surface, name) in surfaces.iter().enumerate() {
        let own = triangles.iter().zip(surface_of).filter(|(_, of)| **of == Some(surface)).map(|(corners, _)| *corners);
        let places = spread(&own.collect::<Vec<_>>());
        let mut found: Vec<(Place, f64)> = Vec::new();
        for radius in BALLS {
            let free: Vec<Place> = places.iter().copied().filter(|place| has_room(&exact, *place, radius)).collect();
            let apart = far_apart(&free, radius, most);
            if apart.len() > found.len() {
                found = apart;
            }
            if found.len() >= ENOUGH {
                break;
            }
        }
        let point = |(place, ball_radius_mm): (Place, f64)| MeasuringPoint {
            surface: (*name).to_owned(),
            point_mm: place.point.to_array().map(rounded),
            normal: place.normal.to_array().map(rounded),
            ball_radius_mm,
        };
        points.extend(found.into_iter().map(point));
    }
    points
}

/// The value to six decimals.
fn rounded(value: f64) -> f64 {
    (value * 1e6).round() / 1e6 + 0.0
}

/// A point of a surface with its normal.
#[derive(Debug, Clone, Copy)]
struct Place {
    point: DVec3,
    normal: DVec3,
}

/// Places spread evenly over the area of `triangles`.
fn spread(triangles: &[[DVec3; 3]]) -> Vec<Place> {
    let areas: Vec<f64> = triangles.iter().map(|t| 0.5 * normal_times_two_areas(*t).length()).collect();
    let total: f64 = areas.iter().sum();
    let (mut places, mut before, mut next) = (Vec::new(), 0.0, 0);
    for (&corners, area) in triangles.iter().zip(areas) {
        let ([a, b, c], normal) = (corners, unit_normal(corners));
        while next < TRIED && (next as f64 + 0.5) * total < (before + area) * TRIED as f64 {
            // Two irrational steps fill the triangle evenly (the additive recurrence R2 of Roberts).
            let [u, v] = [0.754_877_666_246_693, 0.569_840_290_998_053].map(|step| (0.5 + step * next as f64).fract());
            let [u, v] = if u + v > 1.0 { [1.0 - u, 1.0 - v] } else { [u, v] };
            places.push(Place { point: a + (b - a) * u + (c - a) * v, normal });
            next += 1;
        }
        before += area;
    }
    places
}

/// Whether a ball of this radius touches the surface at `place` and nowhere else, and the surface goes on around it.
fn has_room(exact: &ExactMesh, place: Place, radius: f64) -> bool {
    let across = place.normal.any_orthonormal_vector();
    let along = place.normal.cross(across);
    let off = |p: DVec3| exact.nearest(p).signed_distance.abs();
    let is_free = || guarded_distance(exact, place.point + radius * place.normal) >= radius * (1.0 - 1e-3);
    let is_level = (0..8).all(|k| {
        let (sin, cos) = (f64::from(k) * std::f64::consts::FRAC_PI_4).sin_cos();
        off(place.point + radius * (cos * across + sin * along)) <= FLAT * radius
    });
    is_level && is_free()
}

/// At most `most` of `places`, each as far from those before as can be, and farther than a ball; the first is nearest to
/// their middle.
fn far_apart(places: &[Place], radius: f64, most: usize) -> Vec<(Place, f64)> {
    if places.is_empty() {
        return Vec::new();
    }
    let middle = places.iter().map(|place| place.point).sum::<DVec3>() / places.len() as f64;
    let first = places.iter().min_by(|a, b| a.point.distance(middle).total_cmp(&b.point.distance(middle)));
    let mut taken: Vec<Place> = first.into_iter().copied().collect();
    while taken.len() < most {
        let to_taken =
            |place: &Place| taken.iter().map(|of| of.point.distance(place.point)).fold(f64::INFINITY, f64::min);
        let next = places.iter().max_by(|a, b| to_taken(a).total_cmp(&to_taken(b)));
        let Some(next) = next.filter(|next| to_taken(next) > radius) else { break };
        taken.push(*next);
    }
    taken.into_iter().map(|place| (place, radius)).collect()
}

/// The points of several electrodes, given with their names, as a table with one row for each point (mm).
pub fn measuring_csv<'a>(electrodes: impl IntoIterator<Item = (&'a str, &'a [MeasuringPoint])>) -> String {
    let mut csv = "electrode,surface,x_mm,y_mm,z_mm,normal_x,normal_y,normal_z,ball_radius_mm\n".to_owned();
    for (electrode, points) in electrodes {
        for point in points {
            let numbers = point.point_mm.iter().chain(&point.normal).chain([&point.ball_radius_mm]);
            let names = [electrode, &point.surface].map(quoted).into_iter();
            let cells: Vec<String> = names.chain(numbers.map(f64::to_string)).collect();
            csv += &(cells.join(",") + "\n");
        }
    }
    csv
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A block with a rib of 1.4 mm on it: surface 0 is the top of the block, 1 its sides, 2 the rib.
    fn ribbed() -> (Mesh, Vec<Option<usize>>) {
        let placed = |size, at: DVec3| {
            let mut mesh = Mesh::cuboid(size);
            mesh.vertices.iter_mut().for_each(|v| *v += at);
            mesh
        };
        let mut block = placed(DVec3::new(20.0, 16.0, 6.0), DVec3::new(-10.0, -8.0, -6.0));
        let rib = placed(DVec3::new(1.4, 12.0, 9.0), DVec3::new(-0.7, -6.0, 0.0));
        let mut surface_of: Vec<Option<usize>> = block
            .iter_corners()
            .map(|corners| {
                let normal = unit_normal(corners);
                if normal.z > 0.5 {
                    Some(0)
                } else if normal.z < -0.5 {
                    None
                } else {
                    Some(1)
                }
            })
            .collect();
        surface_of.extend(rib.iter_corners().map(|_| Some(2)));
        let count = block.vertices.len() as u32;
        block.vertices.extend(&rib.vertices);
        block.triangles.extend(rib.triangles.iter().map(|t| t.map(|v| v + count)));
        (block, surface_of)
    }

    #[test]
    fn balls_touch_the_points_and_nothing_else() {
        let (mesh, surface_of) = ribbed();
        let points = measuring_points(&mesh, &["top", "sides", "rib"], &surface_of, 9);
        for surface in ["top", "sides", "rib"] {
            let own: Vec<&MeasuringPoint> = points.iter().filter(|point| point.surface == surface).collect();
            assert_eq!(own.len(), 9, "{surface}");
            for point in own {
                let [at, normal] = [point.point_mm, point.normal].map(DVec3::from_array);
                let centre = at + point.ball_radius_mm * normal;
                // No place of the surface is within the ball, by sampling.
                for [a, b, c] in mesh.iter_corners() {
                    for k in 0..=40 {
                        for l in 0..=40 - k {
                            let (u, v) = (f64::from(k) / 40.0, f64::from(l) / 40.0);
                            let on = a + (b - a) * u + (c - a) * v;
                            assert!(on.distance(centre) > point.ball_radius_mm - 2e-3, "{point:?}: {on}");
                        }
                    }
                }
                match surface {
                    // The ball of 1 mm keeps clear of the rib and of the edges.
                    "top" => assert!(at.x.abs() < 9.21 && at.y.abs() < 7.21 && at.z == 0.0, "{at}"),
                    "sides" => assert!(at.z < -0.75 && normal.z == 0.0, "{at}"),
                    _ => assert!(at.x.abs() <= 0.7 && at.z > 0.0, "{at}"),
                }
            }
        }
    }

    #[test]
    fn the_table_has_a_row_for_each_point() {
        let (mesh, surface_of) = ribbed();
        let points = measuring_points(&mesh, &["top", "a, b"], &surface_of, 9);
        let csv = measuring_csv([("E1", &points[..]), ("E2", &points[..1])]);
        assert_eq!(csv.lines().count(), 1 + points.len() + 1);
        assert!(csv.contains("E1,\"a, b\",") && csv.lines().last().unwrap().starts_with("E2,top,"), "{csv}");
    }

    #[test]
    fn a_surface_too_small_for_any_ball_has_no_points() {
        let block = Mesh::cuboid(DVec3::new(10.0, 10.0, 0.2));
        let is_side = |corners| unit_normal(corners).z.abs() < 0.5;
        let surface_of: Vec<Option<usize>> = block.iter_corners().map(|t| is_side(t).then_some(0)).collect();
        assert_eq!(measuring_points(&block, &["sides"], &surface_of, 9), []);
    }
}
