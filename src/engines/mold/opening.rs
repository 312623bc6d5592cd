//! Opening direction of a mold: from where cutters come.

use std::str::FromStr;

use glam::DVec3;
use serde::{Deserialize, Serialize};

use geometry::mesh::Mesh;

/// Opening direction of a mold, in the axes of its mesh. Cutters come from there.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum Opening {
    /// Along +X of the file.
    #[serde(rename = "+x")]
    PlusX,
    /// Along -X of the file.
    #[serde(rename = "-x")]
    MinusX,
    /// Along +Y of the file.
    #[serde(rename = "+y")]
    PlusY,
    /// Along -Y of the file.
    #[serde(rename = "-y")]
    MinusY,
    /// Along +Z of the file.
    #[default]
    #[serde(rename = "+z")]
    PlusZ,
    /// Along -Z of the file.
    #[serde(rename = "-z")]
    MinusZ,
}

impl Opening {
    /// All directions.
    pub const ALL: [Self; 6] = [Self::PlusX, Self::MinusX, Self::PlusY, Self::MinusY, Self::PlusZ, Self::MinusZ];

    /// How it is written.
    pub fn name(self) -> &'static str {
        match self {
            Self::PlusX => "+x",
            Self::MinusX => "-x",
            Self::PlusY => "+y",
            Self::MinusY => "-y",
            Self::PlusZ => "+z",
            Self::MinusZ => "-z",
        }
    }

    /// A point of the mesh where it is once the mold is turned so that its opening looks along +Z.
    pub fn upright(self, p: DVec3) -> DVec3 {
        match self {
            Self::PlusX => DVec3::new(p.y, p.z, p.x),
            Self::MinusX => DVec3::new(p.z, p.y, -p.x),
            Self::PlusY => DVec3::new(p.z, p.x, p.y),
            Self::MinusY => DVec3::new(p.x, p.z, -p.y),
            Self::PlusZ => p,
            Self::MinusZ => DVec3::new(p.x, -p.y, -p.z),
        }
    }

    /// The point of the mesh that [`upright`](Self::upright) takes to `p`.
    pub fn in_mesh(self, p: DVec3) -> DVec3 {
        let [x, y, z] = [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| self.upright(axis));
        DVec3::new(x.dot(p), y.dot(p), z.dot(p))
    }

    /// The mold turned so that its opening looks along +Z.
    pub fn upright_mesh(self, mesh: &Mesh) -> Mesh {
        mesh.mapped(|p| self.upright(p))
    }
}

impl FromStr for Opening {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let named = Self::ALL.into_iter().find(|o| text.trim().eq_ignore_ascii_case(o.name()));
        named.ok_or_else(|| "expected +x, -x, +y, -y, +z or -z".to_owned())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_opening_is_turned_upwards_and_nothing_is_mirrored() {
        let axes = [DVec3::X, -DVec3::X, DVec3::Y, -DVec3::Y, DVec3::Z, -DVec3::Z];
        for (opening, axis) in Opening::ALL.into_iter().zip(axes) {
            assert_eq!(opening.upright(axis), DVec3::Z, "{opening:?}");
            let [x, y, z] = [DVec3::X, DVec3::Y, DVec3::Z].map(|p| opening.upright(p));
            assert_eq!(x.cross(y), z, "{opening:?} is a rotation");
            let p = DVec3::new(1.0, 2.0, 3.0);
            assert_eq!(opening.in_mesh(opening.upright(p)), p);
            assert_eq!(opening.name().parse(), Ok(opening));
        }
        assert!("up".parse::<Opening>().is_err());
    }
}
