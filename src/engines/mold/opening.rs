//! Opening direction of a mold: from where cutters come.

use std::str::FromStr;

use glam::{DMat3, DQuat, DVec3};
use serde::{Deserialize, Serialize};

use geometry::mesh::Mesh;

/// Opening direction of a mold, in the axes of its mesh. Cutters come from there.
///
/// In files it is the name of an axis, as `"+y"`, or three numbers, as `[0.0, 0.5, 1.0]`.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(try_from = "Written", into = "Written")]
pub enum Opening {
    /// Along +X of the file.
    PlusX,
    /// Along -X of the file.
    MinusX,
    /// Along +Y of the file.
    PlusY,
    /// Along -Y of the file.
    MinusY,
    /// Along +Z of the file.
    #[default]
    PlusZ,
    /// Along -Z of the file.
    MinusZ,
    /// Along none of these.
    Slant(Slant),
}

/// A direction along none of the axes, as it was given: three finite numbers, of any length.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Slant(DVec3);

impl Slant {
    /// The rotation that turns the mesh so that this direction looks along +Z: that of the nearest axis after the
    /// shortest turn onto it. So a direction close to an axis turns the mesh almost as the axis does.
    fn turn(self) -> DMat3 {
        let direction = self.0.normalize();
        let along = |axis: &Opening| axis.direction().dot(direction);
        // Of axes that are as near as each other the first.
        let nearest = Opening::AXES.into_iter().rev().max_by(|a, b| along(a).total_cmp(&along(b))).unwrap_or_default();
        let onto = DMat3::from_quat(DQuat::from_rotation_arc(direction, nearest.direction()));
        let [x, y, z] = [onto.x_axis, onto.y_axis, onto.z_axis].map(|axis| nearest.upright(axis));
        DMat3::from_cols(x, y, z)
    }
}

impl Opening {
    /// The directions along the axes.
    pub const AXES: [Self; 6] = [Self::PlusX, Self::MinusX, Self::PlusY, Self::MinusY, Self::PlusZ, Self::MinusZ];

    /// The direction of a vector of any length; none if it has no direction.
    pub fn along(vector: DVec3) -> Option<Self> {
        let direction = vector.try_normalize().filter(|_| vector.is_finite())?;
        let axis = Self::AXES.into_iter().find(|axis| axis.direction() == direction);
        Some(axis.unwrap_or(Self::Slant(Slant(vector))))
    }

    /// The unit vector from the mold to where cutters come from, in the axes of the mesh.
    pub fn direction(self) -> DVec3 {
        match self {
            Self::PlusX => DVec3::X,
            Self::MinusX => DVec3::NEG_X,
            Self::PlusY => DVec3::Y,
            Self::MinusY => DVec3::NEG_Y,
            Self::PlusZ => DVec3::Z,
            Self::MinusZ => DVec3::NEG_Z,
            Self::Slant(slant) => slant.0.normalize(),
        }
    }

    /// Name in files and on the command line: the axis as in `+y`, or else the three numbers as in `0,0.5,1`.
    pub fn name(self) -> String {
        match self {
            Self::PlusX => "+x".to_owned(),
            Self::MinusX => "-x".to_owned(),
            Self::PlusY => "+y".to_owned(),
            Self::MinusY => "-y".to_owned(),
            Self::PlusZ => "+z".to_owned(),
            Self::MinusZ => "-z".to_owned(),
            Self::Slant(Slant(DVec3 { x, y, z })) => format!("{x},{y},{z}"),
        }
    }

    /// A point of the mesh where it is once the mold is turned so that its opening looks along +Z. Along an axis the
    /// coordinates are exchanged and stay exact.
    pub fn upright(self, p: DVec3) -> DVec3 {
        match self {
            Self::PlusX => DVec3::new(p.y, p.z, p.x),
            Self::MinusX => DVec3::new(p.z, p.y, -p.x),
            Self::PlusY => DVec3::new(p.z, p.x, p.y),
            Self::MinusY => DVec3::new(p.x, p.z, -p.y),
            Self::PlusZ => p,
            Self::MinusZ => DVec3::new(p.x, -p.y, -p.z),
            Self::Slant(slant) => slant.turn() * p,
        }
    }

    /// The point of the mesh that [`upright`](Self::upright) takes to `p`.
    pub fn in_mesh(self, p: DVec3) -> DVec3 {
        let [x, y, z] = [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| self.upright(axis));
        DVec3::new(x.dot(p), y.dot(p), z.dot(p))
    }

    /// The mold turned so that its opening looks along +Z.
    pub fn upright_mesh(self, mesh: &Mesh) -> Mesh {
        match self {
            Self::Slant(slant) => {
                let turn = slant.turn();
                mesh.mapped(|p| turn * p)
            }
            axis => mesh.mapped(|p| axis.upright(p)),
        }
    }
}

/// What is no direction.
const WRONG: &str = "expected +x, -x, +y, -y, +z, -z, or three numbers as in 0,0.5,1 that are not all 0";

impl FromStr for Opening {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if let Some(axis) = Self::AXES.into_iter().find(|o| text.trim().eq_ignore_ascii_case(&o.name())) {
            return Ok(axis);
        }
        let parts: Option<Vec<f64>> = text.split(',').map(|part| part.trim().parse().ok()).collect();
        let vector = parts.and_then(|parts| <[f64; 3]>::try_from(parts).ok());
        vector.and_then(|v| Self::along(v.into())).ok_or_else(|| WRONG.to_owned())
    }
}

/// An opening direction as files have it.
#[derive(Serialize, Deserialize)]
#[serde(untagged)]
enum Written {
    Name(String),
    Vector([f64; 3]),
}

impl TryFrom<Written> for Opening {
    type Error = String;

    fn try_from(written: Written) -> Result<Self, String> {
        match written {
            Written::Name(name) => name.parse(),
            Written::Vector(vector) => Self::along(vector.into()).ok_or_else(|| WRONG.to_owned()),
        }
    }
}

impl From<Opening> for Written {
    fn from(opening: Opening) -> Self {
        match opening {
            Opening::Slant(Slant(vector)) => Self::Vector(vector.to_array()),
            axis => Self::Name(axis.name()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_opening_is_turned_upwards_and_nothing_is_mirrored() {
        let axes = [DVec3::X, -DVec3::X, DVec3::Y, -DVec3::Y, DVec3::Z, -DVec3::Z];
        for (opening, axis) in Opening::AXES.into_iter().zip(axes) {
            assert_eq!((opening.upright(axis), opening.direction()), (DVec3::Z, axis), "{opening:?}");
            let [x, y, z] = [DVec3::X, DVec3::Y, DVec3::Z].map(|p| opening.upright(p));
            assert_eq!(x.cross(y), z, "{opening:?} is a rotation");
            let p = DVec3::new(1.0, 2.0, 3.0);
            assert_eq!(opening.in_mesh(opening.upright(p)), p);
            assert_eq!(opening.name().parse(), Ok(opening));
            assert_eq!(Opening::along(7.0 * axis), Some(opening), "a vector along an axis is the axis, and exact");
        }
        for wrong in ["up", "1,2", "0,0,0", "1,2,nan", "1,2,3,4"] {
            assert!(wrong.parse::<Opening>().is_err(), "{wrong}");
        }
    }

    #[test]
    fn any_vector_is_turned_upwards_by_a_rotation() {
        for vector in
            [DVec3::ONE, DVec3::new(-0.3, 20.0, 4.0), DVec3::new(1e-3, -2e-3, -1.0), DVec3::new(0.0, 1.0, 1.0)]
        {
            let opening = Opening::along(vector).unwrap();
            assert!(opening.upright(vector.normalize()).distance(DVec3::Z) < 1e-15, "{opening:?}");
            let [x, y, z] = [DVec3::X, DVec3::Y, DVec3::Z].map(|p| opening.upright(p));
            assert!(x.cross(y).distance(z) < 1e-15 && (x.length() - 1.0).abs() < 1e-15, "{opening:?} is a rotation");
            let p = DVec3::new(100.0, -20.0, 3.0);
            assert!(opening.in_mesh(opening.upright(p)).distance(p) < 1e-13);
            let mesh = Mesh { vertices: vec![p], triangles: Vec::new() };
            assert_eq!(opening.upright_mesh(&mesh).vertices, [opening.upright(p)]);
        }
        // Hardly off an axis, hardly off its turn.
        let [slant, axis] = [DVec3::new(1e-6, 1.0, 0.0), DVec3::Y].map(|v| Opening::along(v).unwrap());
        let p = DVec3::new(1.0, 2.0, 3.0);
        assert!(slant != axis && slant.upright(p).distance(axis.upright(p)) < 1e-5);
    }

    #[test]
    fn it_is_read_as_it_was_written() {
        #[derive(Debug, PartialEq, Serialize, Deserialize)]
        struct File {
            opening: Opening,
        }
        let parsed = |text: &str| toml::from_str::<File>(&format!("opening = {text}")).map(|file| file.opening);
        assert_eq!(parsed("\"-y\""), Ok(Opening::MinusY), "as files had it always");
        for text in ["0.1,0.2,0.3", "-1,1e-7,12345.678"] {
            let opening: Opening = text.parse().unwrap();
            assert_eq!(opening.name().parse(), Ok(opening));
            let file = toml::to_string(&File { opening }).unwrap();
            assert_eq!(toml::from_str(&file), Ok(File { opening }), "{file}");
        }
        assert!(parsed("\"up\"").unwrap_err().to_string().contains("expected +x"));
        assert!(parsed("[0, 0, 0]").is_err() && parsed("[1, 2]").is_err());
    }
}
