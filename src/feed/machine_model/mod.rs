//! The bodies of a machine: what may collide besides electrode and blisk.
//!
//! A machine is a URDF file (see [`urdf`]) or a TOML file: axes, travels and speeds under the keys of `[machine]` of a job, and a list of bodies.
//!
//! ```toml
//! axes = "XYZAC"
//! travel_x_mm = [-250.0, 250.0]
//!
//! [[bodies]]
//! name = "chuck"
//! carried_by = "electrode"
//! shape = "box"
//! size_mm = [30.0, 36.0, 36.0]
//! centre_mm = [15.0, 0.0, 0.0]
//! ```
//!
//! Bodies are given where they stand in the final pose, in directions of the machine that turn with the side of entry:
//! +x points away from the blisk, the way the electrode is withdrawn, +z is the machine's Z, which at the channel
//! points away from the blisk's axis, and y makes them right-handed. An electrode that enters from the other side
//! finds the same machine turned by half a turn about Z. Where x, y and z are counted from is the carrier's matter:
//!
//! | carrier | goes with | counted from |
//! | --- | --- | --- |
//! | `electrode` | X Y Z C B | the middle of the electrode's end face on the side of entry, the holder's interface |
//! | `head` | X Y Z | the reference point O, through which the C axis goes |
//! | `table` | the blisk, which A turns | the blisk's axis at the blisk's face away from the side of entry |
//! | `bed` | nothing | the same point |
//!
//! In the machine frame, which is W in the final pose, the tool is moved by `O + (x, y, z) + Rz(c) Ry(b) (p - O)`, and
//! the blisk and its table are turned by `Rx(-a)`.

mod builtin;
mod file;
mod shape;
#[cfg(test)]
mod tests;
mod urdf;

use std::path::PathBuf;

use glam::{DMat3, DVec3};
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

pub use builtin::BUILT_IN;
pub use file::{is_file, machine_table, read_machine};

use crate::blisk::electrode::EntrySide;
use crate::geometry::mesh::Mesh;
use crate::mesh_io::ImportError;
use crate::progress::Cancelled;

/// The most bodies that a machine may have, and the most triangles of all of them.
pub const MOST_BODIES: usize = 64;
/// See [`MOST_BODIES`].
pub const MOST_TRIANGLES: usize = 500_000;

/// What a body goes with.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Carrier {
    /// The electrode: slides with X, Y, Z and turns with C and B.
    Electrode,
    /// The head: slides with X, Y, Z.
    Head,
    /// The table: turns with A, so that it keeps its place at the blisk.
    Table,
    /// The bed: stands still.
    Bed,
}

impl Carrier {
    /// Whether the axes X, Y and Z move it.
    pub fn slides(self) -> bool {
        matches!(self, Self::Electrode | Self::Head)
    }
}

/// A body in the coordinates of its carrier.
#[derive(Debug, Clone, PartialEq)]
pub struct Body {
    /// What it is called.
    pub name: String,
    /// What it goes with.
    pub carrier: Carrier,
    /// Its closed surface (mm). A cylinder is a prism around it, never smaller than the cylinder.
    pub mesh: Mesh,
}

/// The bodies of a machine.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct MachineModel {
    /// The bodies in the order of the file.
    pub bodies: Vec<Body>,
}

impl MachineModel {
    /// SHA-256 (lower-case hex) over names, carriers and meshes: two models with the same digest are the same machine.
    pub fn digest(&self) -> String {
        let mut hash = Sha256::new();
        for Body { name, carrier, mesh } in &self.bodies {
            hash.update(format!("{name}\0{carrier:?}\0{}\0", mesh.digest()));
        }
        hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect()
    }
}

/// Where a machine stands about one electrode and a blisk.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Station {
    side: EntrySide,
    interface: DVec3,
    reference_point: DVec3,
    seat: DVec3,
}

impl Station {
    /// The machine about `electrode`, in its final pose with its reference point O, and `blisk`, all in W (mm).
    pub fn new(electrode: &Mesh, reference_point: DVec3, side: EntrySide, blisk: &Mesh) -> Self {
        let outermost = electrode.vertices.iter().map(|p| p.x * side.sign()).fold(f64::NEG_INFINITY, f64::max);
        let at_end = |p: &&DVec3| p.x * side.sign() > outermost - 1e-3;
        let end = crate::geometry::mesh::Bounds::of(electrode.vertices.iter().filter(at_end).copied());
        let blisk = blisk.bounds();
        let seat = if side == EntrySide::PlusX { blisk.min.x } else { blisk.max.x };
        Self { side, interface: end.center(), reference_point, seat: DVec3::new(seat, 0.0, 0.0) }
    }

    /// A body in W, where it is in the final pose (mm).
    pub fn placed(&self, body: &Body) -> Mesh {
        let origin = match body.carrier {
            Carrier::Electrode => self.interface,
            Carrier::Head => self.reference_point,
            Carrier::Table | Carrier::Bed => self.seat,
        };
        let directions = match self.side {
            EntrySide::PlusX => DMat3::IDENTITY,
            EntrySide::MinusX => DMat3::from_diagonal(DVec3::new(-1.0, -1.0, 1.0)),
        };
        body.mesh.mapped(|p| origin + directions * p)
    }
}

/// Why a machine cannot be had.
#[derive(Debug, thiserror::Error)]
pub enum MachineModelError {
    /// It cannot be read.
    #[error("{file}: cannot be read ({source}); check the path")]
    Unreadable {
        /// The file.
        file: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// There is no built-in machine of that name.
    #[error("[machine] name = {name:?}: there is no such machine; there are {}, and files that end in .toml or .urdf", BUILT_IN.join(", "))]
    NoSuchMachine {
        /// The name.
        name: String,
    },
    /// It is not what a machine file has to be.
    #[error("{file}: {problem}")]
    Invalid {
        /// The file or the name.
        file: String,
        /// What is wrong and what to do, in one line.
        problem: String,
    },
    /// A body is not possible.
    #[error("{file}: body {body}: {problem}")]
    Body {
        /// The file or the name of the machine.
        file: String,
        /// The body's name, or its number if it has none.
        body: String,
        /// What is wrong and what to do, in one line.
        problem: String,
    },
    /// The mesh of a body cannot be read.
    #[error("{file}: body {body}: {source}")]
    Mesh {
        /// The file or the name of the machine.
        file: String,
        /// The body's name.
        body: String,
        /// Why.
        source: Box<ImportError>,
    },
    /// It was told to stop.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}
