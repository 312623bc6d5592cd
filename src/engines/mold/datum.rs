//! Work datum of a mold: the axes that positions of burns are given in, and how it is found on the part.

use glam::{DAffine3, DMat3, DVec3};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::opening::Opening;
use files::{Invalid, Validate};
use geometry::circle::Circle;
use geometry::mesh::{Mesh, unit_normal};
use task::{Cancel, Cancelled};

/// Largest coordinate of the origin (mm).
pub const FURTHEST: f64 = 1e5;
/// Faces whose normals are nearer to one line than this are parallel (rad).
const PARALLEL: f64 = 2e-3;
/// Two places that are nearer to one another in plan give no direction (mm).
const SHORTEST: f64 = 1e-3;
/// Angle between two faces from which on their edge may be of a rim (rad); facets of a round turn by less.
const SHARP: f64 = 0.61;
/// Vertices whose edges are looked at together.
const VERTICES_AT_A_TIME: usize = 500_000;
/// Fewest corners of a rim: a square or a hexagon is none.
const LEAST_CORNERS: usize = 8;
/// How far a corner may lie off the circle of its rim, in parts of the radius.
const OFF_CIRCLE: f64 = 2e-3;

/// Work datum: origin and X axis of the axes that positions of burns are given in. Z is the opening direction.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Datum {
    /// Name, as in `corner`; may be empty.
    pub name: String,
    /// Origin, in the axes of the mesh (mm).
    pub origin_mm: DVec3,
    /// Angle of the X axis from that of the upright mold, counter-clockwise seen from where cutters come (degrees).
    pub angle_deg: f64,
}

impl Validate for Datum {
    fn validate(&self) -> Result<(), Invalid> {
        for (key, value) in ["origin_mm[0]", "origin_mm[1]", "origin_mm[2]"].into_iter().zip(self.origin_mm.to_array())
        {
            Invalid::unless_within(key, value, [-FURTHEST, FURTHEST], "mm")?;
        }
        Invalid::unless_within("angle_deg", self.angle_deg, [-360.0, 360.0], "degrees")
    }
}

impl Datum {
    /// Whether positions are those of the upright mold: origin and axes of the mesh itself.
    pub fn is_of_mesh(&self) -> bool {
        self.origin_mm == DVec3::ZERO && self.angle_deg == 0.0
    }

    /// Name for people: the given one, or else `origin of the file` or `given`.
    pub fn label(&self) -> &str {
        match (self.name.trim(), self.is_of_mesh()) {
            ("", true) => "origin of the file",
            ("", false) => "given",
            (name, _) => name,
        }
    }

    /// From the upright mold to the axes of the datum (mm).
    pub fn of_upright(&self, opening: Opening) -> DAffine3 {
        let turn = DMat3::from_rotation_z(-self.angle_deg.to_radians());
        DAffine3::from_mat3_translation(turn, -(turn * opening.upright(self.origin_mm)))
    }

    /// Unit axes X, Y and Z of the datum, in the axes of the mesh.
    pub fn axes(&self, opening: Opening) -> [DVec3; 3] {
        let turn = DMat3::from_rotation_z(self.angle_deg.to_radians());
        [turn.x_axis, turn.y_axis, turn.z_axis].map(|axis| opening.in_mesh(axis))
    }

    /// This datum with its origin at a place of the mesh (mm), to a nanometre, that is called `name`.
    pub fn at(&self, place: DVec3, name: &str) -> Self {
        Self { name: name.to_owned(), origin_mm: (place * 1e6).round() / 1e6 + 0.0, ..self.clone() }
    }

    /// This datum with its X axis along the way from one place of the mesh to another (mm), seen from where cutters
    /// come, to a billionth of a degree; none if they lie over one another.
    pub fn with_x_along(&self, opening: Opening, [from, to]: [DVec3; 2]) -> Option<Self> {
        let along = opening.upright(to - from).truncate();
        let angle = (along.to_angle().to_degrees() * 1e9).round() / 1e9 + 0.0;
        (along.length() > SHORTEST).then(|| Self { angle_deg: angle, ..self.clone() })
    }

    /// This datum with its origin moved across two parallel faces to the middle between them, each face given by a
    /// place (mm) and a normal; none if they are not parallel.
    pub fn between(&self, faces: [(DVec3, DVec3); 2]) -> Option<Self> {
        let [(p, n), (q, m)] = faces;
        let (n, m) = (n.try_normalize()?, m.try_normalize()?);
        let off = ((p + q) * 0.5 - self.origin_mm).dot(n);
        (n.cross(m).length() < PARALLEL).then(|| self.at(self.origin_mm + off * n, "between faces"))
    }
}

/// The circles along which sharp edges of a mesh run all the way round: rims of holes and bosses, in the order of their
/// first vertices.
///
/// # Errors
/// If it is cancelled.
pub fn rims(mesh: &Mesh, cancel: &Cancel) -> Result<Vec<Circle>, Cancelled> {
    // The vertices at the other ends of each vertex's sharp edges, and how many of these there are.
    let mut others = vec![([0u32; 2], 0u8); mesh.vertices.len()];
    // Edges of a few vertices at a time: those of a large mesh would take more memory than it does.
    for first in (0..others.len()).step_by(VERTICES_AT_A_TIME) {
        let sides = |(i, t): (usize, &[u32; 3])| {
            let [a, b, c] = *t;
            let sides = [(a, b), (b, c), (c, a)].map(|(a, b)| (a.min(b), a.max(b), i as u32));
            sides.into_iter().filter(move |(a, ..)| (first..first + VERTICES_AT_A_TIME).contains(&(*a as usize)))
        };
        let mut edges: Vec<(u32, u32, u32)> = mesh.triangles.par_iter().enumerate().flat_map_iter(sides).collect();
        cancel.check()?;
        edges.par_sort_unstable();
        for edge in edges.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
            let [(a, b, one), (_, _, other)] = *edge else { continue };
            let [n, m] = [one, other].map(|face| unit_normal(mesh.corners(face as usize)));
            if n.dot(m) < SHARP.cos() {
                for (from, to) in [(a, b), (b, a)] {
                    let (ends, count) = &mut others[from as usize];
                    if let Some(end) = ends.get_mut(*count as usize) {
                        *end = to;
                    }
                    *count = count.saturating_add(1);
                }
            }
        }
        cancel.check()?;
    }
    let mut rims = Vec::new();
    let mut is_seen = vec![false; others.len()];
    for start in 0..others.len() as u32 {
        let mut chain = Vec::new();
        let (mut at, mut before) = (start, start);
        while others[at as usize].1 == 2 && !is_seen[at as usize] {
            is_seen[at as usize] = true;
            chain.push(mesh.vertices[at as usize]);
            let [one, other] = others[at as usize].0;
            let next = if one == before { other } else { one };
            (before, at) = (at, next);
        }
        if at != start || chain.len() < LEAST_CORNERS {
            continue;
        }
        let is_on = |circle: &Circle| chain.iter().all(|p| circle.distance(*p) <= OFF_CIRCLE * circle.radius);
        rims.extend(Circle::through(&chain).filter(is_on));
    }
    Ok(rims)
}

/// The rim that a place is next to: the nearest, if it is no further off than its radius.
pub fn rim_at(rims: &[Circle], place: DVec3) -> Option<&Circle> {
    let nearest = rims.iter().min_by(|a, b| a.distance(place).total_cmp(&b.distance(place)));
    nearest.filter(|rim| rim.distance(place) <= rim.radius)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixtures::{frame, polygon, rectangle, with};

    #[test]
    fn the_meshs_own_datum_changes_no_position() {
        for opening in Opening::AXES {
            let datum = Datum::default();
            let p = DVec3::new(1.25, -3.5, 1e-7);
            assert_eq!(datum.of_upright(opening).transform_point3(p), p);
            assert_eq!(datum.axes(opening), [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| opening.in_mesh(axis)));
            assert!(datum.is_of_mesh() && datum.label() == "origin of the file");
        }
    }

    #[test]
    fn a_place_has_the_coordinates_that_its_distances_from_the_axes_are() {
        let slant = Opening::along(DVec3::new(0.2, -0.4, 0.7)).unwrap();
        for opening in [Opening::PlusZ, Opening::MinusX, Opening::PlusY, slant] {
            let datum = Datum { origin_mm: DVec3::new(4.0, -2.0, 7.5), angle_deg: 30.0, ..Datum::default() };
            let axes = datum.axes(opening);
            assert!(axes[0].cross(axes[1]).distance(axes[2]) < 1e-15 && axes[2].distance(opening.direction()) < 1e-15);
            let x = opening.in_mesh(DVec3::X);
            assert!((axes[0].dot(x) - 30f64.to_radians().cos()).abs() < 1e-15);
            assert!((x.cross(axes[0]).dot(opening.direction()) - 0.5).abs() < 1e-15, "counter-clockwise from above");
            let place = DVec3::new(10.0, 3.0, -6.0);
            let found = datum.of_upright(opening).transform_point3(opening.upright(place));
            let expected = axes.map(|axis| axis.dot(place - datum.origin_mm));
            assert!(found.distance(expected.into()) < 1e-13, "{found}");
        }
    }

    #[test]
    fn between_two_faces_is_the_middle_across_them_and_nothing_else() {
        let datum = Datum { origin_mm: DVec3::new(1.0, 2.0, 3.0), angle_deg: 5.0, ..Datum::default() };
        let faces = [(DVec3::new(-4.0, 9.0, 0.0), DVec3::NEG_X), (DVec3::new(10.0, -7.0, 5.0), DVec3::X)];
        let found = datum.between(faces).unwrap();
        assert_eq!((found.origin_mm, found.angle_deg), (DVec3::new(3.0, 2.0, 3.0), 5.0));
        assert_eq!(datum.between([faces[0], (DVec3::ZERO, DVec3::new(1.0, 0.01, 0.0))]), None, "not parallel");
    }

    #[test]
    fn the_x_axis_runs_along_the_way_between_two_places_seen_from_above() {
        let slant = Opening::along(DVec3::new(0.2, -0.4, 0.7)).unwrap();
        let datum = Datum { name: "corner".to_owned(), origin_mm: DVec3::new(4.0, -2.0, 7.5), angle_deg: 30.0 };
        for opening in [Opening::PlusZ, Opening::MinusX, Opening::PlusY, slant] {
            // Two places at any heights, whose way makes 150 degrees with the X axis of the upright mold.
            let from = DVec3::new(3.0, -1.0, 2.0);
            let way = DVec3::new(-(3f64.sqrt()), 1.0, -5.0);
            let places = [from, from + way].map(|p| opening.in_mesh(p));
            let found = datum.with_x_along(opening, places).unwrap();
            assert!((found.angle_deg - 150.0).abs() < 1e-8, "{found:?}");
            assert_eq!(Datum { angle_deg: 30.0, ..found.clone() }, datum, "nothing else changes");
            // The way has no part along Y, and its part along X is positive.
            let [x, y, _] = found.axes(opening).map(|axis| axis.dot(places[1] - places[0]));
            assert!((x - 2.0).abs() < 1e-8 && y.abs() < 1e-8, "{x} {y}");
            let back = datum.with_x_along(opening, [places[1], places[0]]).unwrap();
            assert!((back.angle_deg + 30.0).abs() < 1e-8, "{back:?}");
            let above = [from, from + 4.0 * DVec3::Z].map(|p| opening.in_mesh(p));
            assert_eq!(datum.with_x_along(opening, above), None, "over one another");
        }
    }

    #[test]
    fn holes_are_found_where_they_are_and_squares_are_none() {
        let mut hole = polygon(24, 3.0);
        hole.iter_mut().for_each(|p| *p += glam::DVec2::new(2.0, 1.0));
        // An outline of as many corners: a hole that starts at its own.
        let around: Vec<_> =
            polygon(24, 9.0).into_iter().map(|p| p.clamp(-glam::DVec2::splat(8.0), glam::DVec2::splat(8.0))).collect();
        let part = frame(&around, &hole, 5.0);
        let found = rims(&part, &Cancel::default()).unwrap();
        assert_eq!(found.len(), 2, "{found:?}");
        for (rim, z) in found.iter().zip([0.0, 5.0]) {
            assert!(rim.radius > 2.999_999 && rim.radius < 3.000_001);
            assert!(found.iter().any(|rim| rim.centre.distance(DVec3::new(2.0, 1.0, z)) < 1e-9), "{rim:?}");
        }
        let near = rim_at(&found, DVec3::new(4.5, 1.0, 5.0)).unwrap();
        assert!((near.centre.z - 5.0).abs() < 1e-9, "the rim that was pointed at");
        assert!(rim_at(&found, DVec3::new(60.0, 0.0, 0.0)).is_none());
        let square = frame(&rectangle(20.0, 20.0), &rectangle(6.0, 6.0), 5.0);
        assert!(rims(&square, &Cancel::default()).unwrap().is_empty());
        // A round peg is a rim too.
        let peg = fixtures_peg();
        assert_eq!(rims(&with(&square, &peg), &Cancel::default()).unwrap().len(), 2);
    }

    /// A round bar of 4 mm, 5 mm long.
    fn fixtures_peg() -> Mesh {
        let bar = polygon(16, 2.0);
        geometry::solid::prism(&[&bar], 0.0, 5.0).unwrap()
    }

    #[test]
    fn what_is_no_datum_is_refused() {
        let wrong = Datum { origin_mm: DVec3::new(0.0, f64::NAN, 0.0), ..Datum::default() };
        assert!(wrong.validate().unwrap_err().to_string().contains("origin_mm[1]"));
        assert!(Datum { angle_deg: 361.0, ..Datum::default() }.validate().is_err());
        assert!(Datum::default().validate().is_ok());
    }
}
