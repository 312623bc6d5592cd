//! STEP files to closed meshes whose triangles know their faces.
//!
//! ```no_run
//! use step::read::{Options, read};
//! use task::Task;
//!
//! let bytes = std::fs::read("wheel.step").unwrap_or_default();
//! let file = read(&bytes, &Options { chord: 0.005, ..Options::default() }, &Task::default())?;
//! for solid in &file.solids {
//!     println!("{}: {} faces, {:.3} mm^3", solid.name, solid.faces.len(), solid.mesh.volume());
//! }
//! # Ok::<(), step::StepError>(())
//! ```

mod assembly;
mod clamp;
mod domain;
mod edges;
mod solid;
mod surface;
mod text;
mod triangulate;

#[cfg(test)]
mod tests;

use std::collections::HashMap;

use glam::DVec3;

use geometry::mesh::Mesh;
use geometry::segmentation::KnownFace;
use task::Task;

use crate::error::StepError;

/// How a STEP file is read.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options {
    /// Greatest distance between triangles and the exact surface (mm).
    pub chord: f64,
    /// Greatest angle that the surface turns along a side of a triangle (rad).
    pub turn: f64,
    /// Most triangles of all solids together.
    pub max_triangles: u64,
    /// Most solids, placed copies counted.
    pub max_solids: u64,
}

impl Default for Options {
    fn default() -> Self {
        Self { chord: 0.005, turn: 0.3, max_triangles: 20_000_000, max_solids: 10_000 }
    }
}

/// Content of a STEP file.
#[derive(Debug, Clone, PartialEq)]
pub struct StepFile {
    /// Solids at their places in the assembly, in the order of the file.
    pub solids: Vec<Solid>,
    /// Millimetres in the file's unit of length, and the name of the unit.
    pub unit: (f64, String),
    /// Sentences on what was left out or assumed.
    pub warnings: Vec<String>,
}

/// A solid of a STEP file.
#[derive(Debug, Clone, PartialEq)]
pub struct Solid {
    /// Name of the part, and of the solid where a part has several.
    pub name: String,
    /// Red, green and blue from 0 to 1.
    pub color: Option<[f32; 3]>,
    /// Triangles (mm).
    pub mesh: Mesh,
    /// Faces.
    pub faces: Vec<KnownFace>,
    /// Number of the face of each triangle.
    pub face_of: Vec<u32>,
    /// Faces that could not be made, and open places: none of a closed solid.
    pub faults: Vec<Fault>,
}

impl Solid {
    /// Whether every side of a triangle is that of exactly one other, run through the other way.
    pub fn is_closed(&self) -> bool {
        let mut sides: HashMap<[u32; 2], i32> = HashMap::new();
        for &[a, b, c] in &self.mesh.triangles {
            for [from, to] in [[a, b], [b, c], [c, a]] {
                *sides.entry([from.min(to), from.max(to)]).or_insert(0) += if from < to { 1 } else { 1 << 16 };
            }
        }
        !self.mesh.triangles.is_empty() && sides.values().all(|times| *times == 1 + (1 << 16))
    }
}

/// A place at which a solid is not as the file means it.
#[derive(Debug, Clone, PartialEq)]
pub struct Fault {
    /// Number of the face.
    pub face: Option<u32>,
    /// A point beside it (mm).
    pub place: DVec3,
    /// The reason.
    pub problem: &'static str,
}

/// How fine triangles are, in the unit of the file.
#[derive(Debug, Clone, Copy)]
struct Fineness {
    /// Greatest distance between chord and curve.
    chord: f64,
    /// Greatest turn along a chord (rad).
    turn: f64,
    /// Chords shorter than this are fine whatever they leave.
    least_length: f64,
    /// Distance within which points are one.
    joined: f64,
}

impl Fineness {
    /// Whether the chord from `a` to `b` passes the point `p` between them closely enough.
    fn allows(&self, a: DVec3, b: DVec3, p: DVec3) -> bool {
        let (along, off) = (b - a, p - a);
        let length = along.length_squared();
        let foot = if length > 0.0 { along * (off.dot(along) / length).clamp(0.0, 1.0) } else { DVec3::ZERO };
        off.distance_squared(foot) <= self.chord * self.chord
    }
}

/// Reads a STEP file.
///
/// # Errors
/// [`StepError`].
pub fn read(bytes: &[u8], options: &Options, task: &Task) -> Result<StepFile, StepError> {
    task.report("reading STEP", 0.0, "");
    let (model, report) =
        step_io::read(&*text::checked(bytes)?).map_err(|problem| StepError::Syntax { problem: problem.to_string() })?;
    task.check()?;
    let scene = model.scene();
    let units = scene.units();
    let unit = match &units.length {
        Some(unit) => (unit.to_si * 1000.0, unit.name.to_lowercase()),
        None => (1.0, "none given, taken for millimetres".to_owned()),
    };
    let placed = assembly::placed(&scene, options.max_solids)?;
    let mut file = StepFile { solids: Vec::new(), unit, warnings: Vec::new() };
    let dropped = report.dropped.len();
    if dropped > 0 {
        file.warnings.push(format!("{dropped} entities could not be read and were left out."));
    }
    let precision = units.precision.unwrap_or(0.0);
    let angle = units.angle.as_ref().map_or(1.0, |a| a.to_si);
    let mut triangles = 0;
    for (n, group) in placed.iter().enumerate() {
        task.report("making triangles", n as f64 / placed.len() as f64, &group.name);
        let made = solid::tessellate(group, &model, [file.unit.0, angle, precision], options, task)?;
        for solid in made {
            triangles += solid.mesh.triangles.len() as u64;
            if triangles > options.max_triangles {
                let limit = options.max_triangles;
                return Err(StepError::TooLarge { what: "triangles", found: triangles, limit });
            }
            file.solids.push(solid);
        }
    }
    file.warnings.extend(scene.warnings().iter().map(|w| format!("{w}.")));
    if file.solids.is_empty() {
        let [faces, edges] = [scene.all_faces().count(), scene.all_edges().count()];
        return Err(StepError::NoSolid { found: format!("{faces} faces, {edges} edges") });
    }
    Ok(file)
}
