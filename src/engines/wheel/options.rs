//! Options of a blisk that replace what would otherwise be found: the `[blisk]` keys of a project file.

use glam::DVec3;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// A figure that is found from the mesh unless it is given: `"auto"` or the value.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub enum Auto<T> {
    /// Find it.
    #[default]
    Auto,
    /// Use this.
    Given(T),
}

impl<T: Copy> Auto<T> {
    /// The value, if it was given.
    pub fn given(&self) -> Option<T> {
        match *self {
            Self::Auto => None,
            Self::Given(value) => Some(value),
        }
    }
}

#[derive(Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
enum AutoWord {
    Auto,
}

#[derive(Serialize, Deserialize)]
#[serde(untagged, expecting = "expected \"auto\" or a number")]
enum AutoOr<T> {
    Word(AutoWord),
    Value(T),
}

impl<T: Serialize + Copy> Serialize for Auto<T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.given().map_or(AutoOr::Word(AutoWord::Auto), AutoOr::Value).serialize(serializer)
    }
}

impl<'de, T: Deserialize<'de>> Deserialize<'de> for Auto<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        Ok(match AutoOr::deserialize(deserializer)? {
            AutoOr::Word(AutoWord::Auto) => Self::Auto,
            AutoOr::Value(value) => Self::Given(value),
        })
    }
}

/// An axis by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum AxisName {
    /// Find direction and place.
    Auto,
    /// Parallel to the mesh's X axis; its place is found.
    X,
    /// Parallel to the mesh's Y axis; its place is found.
    Y,
    /// Parallel to the mesh's Z axis; its place is found.
    Z,
}

impl AxisName {
    /// The unit direction in the mesh's coordinates; none where it is found.
    pub fn direction(self) -> Option<DVec3> {
        match self {
            Self::Auto => None,
            Self::X => Some(DVec3::X),
            Self::Y => Some(DVec3::Y),
            Self::Z => Some(DVec3::Z),
        }
    }
}

/// A line in the coordinates of the mesh.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AxisLine {
    /// Along the line, of any length but zero.
    pub direction: [f64; 3],
    /// A point of the line (mm).
    pub point: [f64; 3],
}

/// The blisk's axis: `"auto"`, `"x"`, `"y"`, `"z"` or `{ direction = [0, 0, 1], point = [0, 0, 0] }`, taken
/// exactly as given in the last case.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(untagged, expecting = "expected \"auto\", \"x\", \"y\", \"z\" or { direction = [0, 0, 1], point = [0, 0, 0] }")]
pub enum AxisChoice {
    /// By name.
    Named(AxisName),
    /// By direction and point.
    Line(AxisLine),
}

/// Place of a passage that is not axial that lies along Z of W, so that electrodes leave it there along Z.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ZAt {
    /// The mouth at the rim, where the passage runs along Z, seen along the axis; the middle where there is no such
    /// mouth.
    #[default]
    Rim,
    /// The mouth in the bore, through which Z goes; the middle where there is no such mouth.
    Bore,
    /// The middle of the passage, through which Z goes.
    Middle,
}

/// What bounds a passage towards hub and shroud.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum EndWalls {
    /// The surfaces of the mesh; points that are given lie on them.
    #[default]
    Measured,
    /// The curves through the points that are given: where blades grow together at the hub, or where metal is to be left
    /// there.
    Drawn,
}

/// Options for finding the channel of a blisk.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct BliskOptions {
    /// The blisk's axis in the coordinates of the mesh.
    pub axis: AxisChoice,
    /// Number of blades around the axis.
    pub blades: Auto<usize>,
    /// Number of the channel: 0 is the one nearest to the mesh's +Z (to its +X when the axis runs along Z), or to the
    /// middle of a mesh that is a sector; the others
    /// follow in the sense of a right-handed turn about W's X.
    pub channel: usize,
    /// Place of the passage along Z of W.
    pub z_at: ZAt,
    /// Radius of the hub along the whole channel (mm; P0: R_h).
    pub hub_radius_mm: Auto<f64>,
    /// Radius of the shroud, or of the blade tips without one, along the whole channel (mm; P0: R_c).
    pub shroud_radius_mm: Auto<f64>,
    /// Points on the hub, at least two or none, in any order and at any angle about the axis, in the coordinates of the
    /// mesh (mm). They tell which surface is the hub; it is measured beside the curve through them.
    pub hub_points_mm: Vec<[f64; 3]>,
    /// Points on the shroud, or on the blade tips without one, given in the same way (mm).
    pub shroud_points_mm: Vec<[f64; 3]>,
    /// What the points on hub and shroud stand for. A drawn curve may leave metal to others, but may not reach into the
    /// part.
    pub end_walls: EndWalls,
    /// Points on walls of blades, in the coordinates of the mesh (mm). They tell which circles about the axis blades
    /// bound; the wall of the first one bounds channel 0.
    pub blade_points_mm: Vec<[f64; 3]>,
    /// Points of a wall along the chord, from edge to edge.
    pub wall_points_chord: usize,
    /// Points of a wall from hub to shroud.
    pub wall_points_span: usize,
}

impl Default for BliskOptions {
    fn default() -> Self {
        Self {
            axis: AxisChoice::Named(AxisName::Auto),
            blades: Auto::Auto,
            channel: 0,
            z_at: ZAt::Rim,
            hub_radius_mm: Auto::Auto,
            shroud_radius_mm: Auto::Auto,
            hub_points_mm: Vec::new(),
            shroud_points_mm: Vec::new(),
            end_walls: EndWalls::Measured,
            blade_points_mm: Vec::new(),
            wall_points_chord: 81,
            wall_points_span: 25,
        }
    }
}

/// Most points a wall may have along the chord or across it.
const MAX_WALL_POINTS: usize = 300;
/// Most points that may be given on one surface.
const MAX_POINTS: usize = 1000;
/// Greatest coordinate of a point (mm).
const FURTHEST: f64 = 1e6;

impl BliskOptions {
    /// The radii that bound an axial channel, by their keys.
    pub(super) fn radii(&self) -> [(&'static str, Auto<f64>); 2] {
        [("hub_radius_mm", self.hub_radius_mm), ("shroud_radius_mm", self.shroud_radius_mm)]
    }

    /// The points of hub, shroud and blades, by their keys and with the least number of them.
    pub(super) fn points(&self) -> [(&'static str, &[[f64; 3]], usize); 3] {
        [
            ("hub_points_mm", &self.hub_points_mm, 2),
            ("shroud_points_mm", &self.shroud_points_mm, 2),
            ("blade_points_mm", &self.blade_points_mm, 1),
        ]
    }

    /// The keys of the curves that are drawn.
    pub(super) fn drawn(&self) -> impl Iterator<Item = &'static str> {
        let is_drawn = self.end_walls == EndWalls::Drawn;
        let curves = self.points().into_iter().take(2);
        curves.filter(move |(_, points, _)| is_drawn && !points.is_empty()).map(|(key, ..)| key)
    }

    /// Whether the options make sense before any mesh is seen; if not, which key is wrong and what it may be.
    pub fn validate(&self) -> Result<(), String> {
        if let AxisChoice::Line(AxisLine { direction, point }) = self.axis {
            let length = DVec3::from(direction).length();
            if !(length.is_finite() && length > 1e-12 && DVec3::from(point).is_finite()) {
                return Err("blisk.axis: the direction must be finite and not zero, and the point finite".into());
            }
        }
        if self.blades.given().is_some_and(|n| !(2..=1000).contains(&n)) {
            return Err("blisk.blades: must be \"auto\" or between 2 and 1000".into());
        }
        for (key, radius) in self.radii() {
            if radius.given().is_some_and(|r| !(r.is_finite() && r > 0.0)) {
                return Err(format!("blisk.{key}: must be \"auto\" or a radius in mm greater than 0"));
            }
        }
        if let (Some(hub), Some(shroud)) = (self.hub_radius_mm.given(), self.shroud_radius_mm.given())
            && hub >= shroud
        {
            return Err(format!("blisk.hub_radius_mm ({hub}) must be less than blisk.shroud_radius_mm ({shroud})"));
        }
        for (key, points, least) in self.points() {
            if points.len() == 1 && least == 2 {
                return Err(format!(
                    "blisk.{key}: has only one point, and a second one is needed, nearer to the other edge of the blades; \
                     or take the point away"
                ));
            }
            if points.len() > MAX_POINTS {
                return Err(format!("blisk.{key}: must have at most {MAX_POINTS} points"));
            }
            if points.iter().flatten().any(|c| !(c.is_finite() && c.abs() <= FURTHEST)) {
                return Err(format!("blisk.{key}: coordinates must lie between -{FURTHEST} and {FURTHEST} mm"));
            }
        }
        if self.end_walls == EndWalls::Drawn && self.drawn().next().is_none() {
            return Err(
                "blisk.end_walls: \"drawn\" needs points of the curves in blisk.hub_points_mm, blisk.shroud_points_mm \
                        or both"
                    .into(),
            );
        }
        let given = self.radii().map(|(key, radius)| radius.given().is_some().then_some(key));
        for (radius, (key, points, _)) in given.into_iter().zip(self.points()) {
            if let Some(radius) = radius
                && !points.is_empty()
            {
                return Err(format!("blisk.{key}: give either these points or blisk.{radius}, not both"));
            }
        }
        let sizes = [("wall_points_chord", self.wall_points_chord), ("wall_points_span", self.wall_points_span)];
        for (key, size) in sizes {
            if !(5..=MAX_WALL_POINTS).contains(&size) {
                return Err(format!("blisk.{key}: must be between 5 and {MAX_WALL_POINTS}"));
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_job_file_names_or_spells_out_the_axis() {
        let parse = |text: &str| toml::from_str::<BliskOptions>(text);
        assert_eq!(parse("").unwrap(), BliskOptions::default());
        let given = parse("axis = 'z'\nblades = 60\nhub_radius_mm = 110\nshroud_radius_mm = 'auto'").unwrap();
        assert_eq!(given.axis, AxisChoice::Named(AxisName::Z));
        assert_eq!((given.blades, given.hub_radius_mm), (Auto::Given(60), Auto::Given(110.0)));
        let line = parse("axis = { direction = [0, 0, 2], point = [1, 2.5, 3] }").unwrap();
        assert_eq!(line.axis, AxisChoice::Line(AxisLine { direction: [0.0, 0.0, 2.0], point: [1.0, 2.5, 3.0] }));
        for wrong in ["axis = 'w'", "blades = 'many'", "blade = 60", "axis = { direction = [0, 0, 1] }"] {
            assert!(parse(wrong).is_err(), "{wrong}");
        }
        assert!(parse("axis = 'w'").unwrap_err().to_string().contains("direction"), "says what is allowed");
    }

    #[test]
    fn options_survive_being_written_and_read() {
        let options = BliskOptions {
            axis: AxisChoice::Line(AxisLine { direction: [0.0, 1.0, 0.0], point: [0.5; 3] }),
            blades: Auto::Given(7),
            ..Default::default()
        };
        for options in [options, BliskOptions::default()] {
            let text = toml::to_string(&options).unwrap();
            assert_eq!(toml::from_str::<BliskOptions>(&text).unwrap(), options, "{text}");
        }
    }

    #[test]
    fn senseless_options_are_refused_by_key() {
        let default = BliskOptions::default;
        let nowhere = AxisLine { direction: [0.0; 3], point: [0.0; 3] };
        let radii = BliskOptions { hub_radius_mm: Auto::Given(5.0), shroud_radius_mm: Auto::Given(4.0), ..default() };
        for (options, key) in [
            (BliskOptions { axis: AxisChoice::Line(nowhere), ..default() }, "axis"),
            (BliskOptions { blades: Auto::Given(1), ..default() }, "blades"),
            (BliskOptions { hub_radius_mm: Auto::Given(f64::NAN), ..default() }, "hub_radius_mm"),
            (radii, "shroud_radius_mm"),
            (BliskOptions { end_walls: EndWalls::Drawn, ..default() }, "end_walls"),
            (BliskOptions { wall_points_span: 1, ..default() }, "wall_points_span"),
        ] {
            assert!(options.validate().unwrap_err().contains(key), "{key}");
        }
        let one_point = BliskOptions { shroud_points_mm: vec![[1.0; 3]], ..default() };
        let refusal = one_point.validate().unwrap_err();
        assert!(refusal.contains("shroud_points_mm") && refusal.contains("second"), "{refusal}");
        assert_eq!(BliskOptions { blade_points_mm: vec![[1.0; 3]], ..default() }.validate(), Ok(()));
        assert_eq!(default().validate(), Ok(()));
    }
}
