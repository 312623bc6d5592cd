//! Mesh files to meshes in millimetres, and back.
//!
//! [`import_file`] reads STL (binary and ASCII), OBJ, glTF, GLB and STEP, distinguished by their content. Whatever the bytes,
//! it returns either a mesh and a report on it, or one clear line that names the file, the place and the remedy; it
//! neither panics nor takes more memory than its [`ImportLimits`] allow.
//!
//! The mesh that comes out has one vertex for each point of a solid, no collapsed or doubled triangles, and its triangles
//! are counter-clockwise seen from outside. Solids that touch close each on its own. What it does *not* promise is that
//! the surface is closed: holes are reported, not filled, and an open surface may have no outside.
//! [`ImportReport::watertight`] tells.
//!
//! ```
//! use import::{ImportOptions, Reading, Units, import_bytes};
//! use task::Task;
//!
//! let obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n";
//! let options = ImportOptions { reading: Reading::whole(Units::Inch), ..ImportOptions::default() };
//! let imported = import_bytes("corner.obj", obj.as_bytes(), &options, &Task::default())?;
//! assert!(imported.report.watertight);
//! assert!((imported.mesh.volume() - 25.4_f64.powi(3) / 6.0).abs() < 1e-9);
//! # Ok::<(), import::ImportError>(())
//! ```

use std::fs::File;
use std::io::Read;
use std::path::Path;

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use geometry::mesh::Mesh;
use geometry::segmentation::{Segmentation, SegmentationSettings};
use task::{Cancel, Cancelled, Task};

mod clean;
mod contacts;
mod edges;
mod error;
mod format;
mod glb;
mod gltf;
mod gltf_buffers;
mod holes;
mod limits;
mod nesting;
mod obj;
mod orient;
mod repair;
mod report;
mod solids;
mod source;
mod step;
mod stl;
mod unite;
mod units;
mod weld;

pub use error::{ImportError, excerpt, one_line};
pub use format::{Format, MESH_ENDINGS, detect};
pub use glb::glb_bytes;
pub use holes::Hole;
pub use limits::ImportLimits;
pub use obj::obj_bytes;
pub use report::ImportReport;
pub use solids::{CadFaces, SolidReport};
pub use stl::{stl_bytes, write_stl};
pub use units::{Undeclared, Unit, Units};

use source::{RawMesh, Source};

/// Solids, tolerance and unit in which a part is read from its file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Reading {
    /// Unit of the file's coordinates.
    pub units: Units,
    /// Numbers of the solids of a STEP file, from 1, that make the part. If there are none, the largest that is no
    /// obstacle and all others that lie beside it.
    pub solids: Vec<u32>,
    /// Numbers of the solids of a STEP file that are obstacles: a fixture, or a part beside it.
    pub obstacles: Vec<u32>,
    /// Greatest distance of the triangles from the exact faces of a STEP file (mm).
    pub step_tolerance_mm: f64,
}

impl Reading {
    /// Limits of the tolerance (mm).
    pub const STEP_TOLERANCES: [f64; 2] = [1e-4, 1.0];
    /// The tolerance, unless another is given (mm): a twentieth of a spark gap of 0.1.
    pub const STEP_TOLERANCE: f64 = 0.005;

    /// The whole file in `units`.
    pub fn whole(units: Units) -> Self {
        Self { units, ..Self::default() }
    }
}

impl Default for Reading {
    fn default() -> Self {
        Self {
            units: Units::default(),
            solids: Vec::new(),
            obstacles: Vec::new(),
            step_tolerance_mm: Self::STEP_TOLERANCE,
        }
    }
}

impl From<Units> for Reading {
    fn from(units: Units) -> Self {
        Self::whole(units)
    }
}

/// Options for reading a mesh file.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ImportOptions {
    /// Solids, tolerance and unit.
    pub reading: Reading,
    /// Unit where none is given here or in the file.
    pub undeclared: Undeclared,
    /// Distance (mm) within which vertices are taken for one where a mesh does not close otherwise. By default a
    /// millionth of the diagonal, and no less than what `f32` coordinates resolve. 0 welds equal vertices only.
    pub weld_tolerance_mm: Option<f64>,
    /// The most that the import may take.
    pub limits: ImportLimits,
}

impl ImportOptions {
    /// Checks these options.
    ///
    /// # Errors
    /// [`ImportError::BadOption`].
    pub fn validate(&self) -> Result<(), ImportError> {
        self.limits.validate()?;
        let [least, most] = Reading::STEP_TOLERANCES;
        let tolerance = self.reading.step_tolerance_mm;
        if !(least..=most).contains(&tolerance) {
            let problem = format!("step_tolerance_mm is {tolerance}; give a length from {least} to {most} mm");
            return Err(ImportError::BadOption { problem });
        }
        // Finer than a picometre would be finer than the coordinates themselves.
        match self.weld_tolerance_mm {
            Some(t) if t != 0.0 && !(1e-9..=1.0).contains(&t) => Err(ImportError::BadOption {
                problem: format!("weld_tolerance_mm is {t}; give 0 or a length from 1e-9 to 1 mm"),
            }),
            _ => Ok(()),
        }
    }
}

/// A mesh from a file.
#[derive(Debug, Clone, PartialEq)]
pub struct Imported {
    /// The repaired mesh (mm), in the axes of the file.
    pub mesh: Mesh,
    /// Report of the import.
    pub report: ImportReport,
    /// Faces of the CAD program, of a file that has them.
    pub faces: Option<CadFaces>,
    /// Solids beside the part that are obstacles (mm), as they stand in the file; none if there are no such.
    pub obstacles: Option<Mesh>,
    /// SHA-256 of the file, and of its buffer files after it, in hexadecimal.
    pub sha256: String,
}

impl Imported {
    /// The faces of the part: those of the CAD program where the file has them, else those that its triangles show.
    pub fn segmentation(&self, settings: &SegmentationSettings) -> Segmentation {
        match &self.faces {
            Some(known) => Segmentation::of_faces(&self.mesh, &known.faces, &known.face_of, settings),
            None => Segmentation::of(&self.mesh, settings),
        }
    }
}

/// Largest coordinate that is believed (mm): a kilometre.
const LARGEST_COORDINATE: f64 = 1e6;

/// How much is read or hashed between two looks at the cancel flag (bytes).
const BLOCK: usize = 4 << 20;

/// Reads the mesh file at `path`.
///
/// # Errors
/// Every variant of [`ImportError`]; its text is one line naming the file, the place in it and the remedy.
pub fn import_file(path: &Path, options: &ImportOptions, task: &Task) -> Result<Imported, ImportError> {
    options.validate()?;
    let name = error::one_line(&path.display().to_string());
    let bytes = read_bytes(path, &options.limits, task)?;
    let folder = path.parent().unwrap_or(Path::new(""));
    let source = Source {
        name: &name,
        bytes: &bytes,
        folder: Some(folder),
        reading: &options.reading,
        limits: &options.limits,
        task,
    };
    import(&source, options)
}

/// Reads a mesh file that is in memory already; `name` is for messages, and its extension a hint at the format.
///
/// A glTF whose buffers lie in files of their own cannot be read in this way.
///
/// # Errors
/// Every error of [`import_file`].
pub fn import_bytes(name: &str, bytes: &[u8], options: &ImportOptions, task: &Task) -> Result<Imported, ImportError> {
    options.validate()?;
    let name = error::one_line(name);
    options.limits.check_file(&name, bytes.len() as u64)?;
    let source = Source { name: &name, bytes, folder: None, reading: &options.reading, limits: &options.limits, task };
    import(&source, options)
}

/// Reads the whole file at `path`, of any format, within the limits of an import.
///
/// # Errors
/// [`ImportError::Unreadable`], [`ImportError::NotAFile`], [`ImportError::TooLarge`] and [`ImportError::Cancelled`].
pub fn read_bytes(path: &Path, limits: &ImportLimits, task: &Task) -> Result<Vec<u8>, ImportError> {
    let name = &*error::one_line(&path.display().to_string());
    let unreadable = |source| ImportError::Unreadable { file: name.to_owned(), source };
    // Asked before opening, as opening a pipe would wait for ever.
    let about = std::fs::metadata(path).map_err(unreadable)?;
    if !about.is_file() {
        let kind = if about.is_dir() { "a folder" } else { "a device or pipe" };
        return Err(ImportError::NotAFile { file: name.to_owned(), kind });
    }
    limits.check_file(name, about.len())?;
    limits.check_memory(name, about.len())?;
    let mut file = File::open(path).map_err(unreadable)?;
    let mut bytes = Vec::new();
    loop {
        task.check()?;
        task.report("reading the file", bytes.len() as f64 / about.len().max(1) as f64, "");
        let read = file.by_ref().take(BLOCK as u64).read_to_end(&mut bytes).map_err(unreadable)?;
        if read == 0 {
            return Ok(bytes);
        }
        // The file may have grown since it was asked for its length.
        limits.check_file(name, bytes.len() as u64)?;
    }
}

fn import(source: &Source, options: &ImportOptions) -> Result<Imported, ImportError> {
    let task = source.task;
    let format = detect(source.name, source.bytes)?;
    let about = format.about();
    let mut hasher = Sha256::new();
    let (raw, hashed) = rayon::join(|| (about.read)(source), || hash(&mut hasher, source.bytes, &task.cancel));
    let RawMesh { mesh, warnings, note, solids, attachments } = raw?;
    hashed?;
    attachments.iter().try_for_each(|content| hash(&mut hasher, content, &task.cancel))?;
    drop(attachments);
    let declared = about.unit.or_else(|| units::declared_in(&note).map(|unit| (unit, "the file")));
    let (given, size) = (options.reading.units.given(), repair::largest_extent(&mesh));
    let unit = units::choose_with_care(given, declared, options.undeclared, size)
        .map_err(|guess| ImportError::UnitOpen { file: source.name.to_owned(), guess: guess.reason })?;
    let unit_mm = unit.unit;
    let mesh = in_millimetres(source, mesh, unit_mm)?;
    let triangles_read = mesh.triangles.len();
    let before = solids.is_some().then(|| mesh.clone());
    let (mesh, repairs) = repair::repair(mesh, options.weld_tolerance_mm, task)?;
    if mesh.triangles.is_empty() {
        return Err(ImportError::NoTriangles { file: source.name.to_owned() });
    }
    let mut report = ImportReport::new(format, triangles_read, &mesh, unit, repairs, warnings);
    let mut obstacles = None;
    let faces = match solids.zip(before) {
        Some((solids, before)) => {
            report.solids = solids.list;
            report.step_tolerance_mm = Some(options.reading.step_tolerance_mm);
            obstacles = Some(in_millimetres(source, solids.obstacles, unit_mm)?).filter(|o| !o.triangles.is_empty());
            Some(solids::carried(solids.faces.scaled(unit_mm.in_mm()), &before, &mesh))
        }
        None => None,
    };
    task.report("importing", 1.0, "");
    let sha256 = hasher.finalize().iter().map(|byte| format!("{byte:02x}")).collect();
    Ok(Imported { mesh, report, faces, obstacles, sha256 })
}

/// `mesh` converted from `unit`; refuses coordinates that no part can have.
fn in_millimetres(source: &Source, mut mesh: Mesh, unit: Unit) -> Result<Mesh, ImportError> {
    for p in &mut mesh.vertices {
        *p *= unit.in_mm();
    }
    let too_far = |v: u32| mesh.vertices[v as usize].abs().max_element() > LARGEST_COORDINATE;
    let Some(t) = mesh.triangles.iter().position(|t| t.iter().any(|&v| too_far(v))) else { return Ok(mesh) };
    let corners = mesh.corners(t);
    let farthest = corners.iter().map(|p| p.abs().max_element()).fold(0.0, f64::max);
    Err(source.malformed(
        format!("triangle {}", t + 1),
        format!("a coordinate of {farthest:.3e} mm is larger than any part (unit: {})", unit.name()),
        "check the unit, or move the part to the origin and export it again",
    ))
}

fn hash(hasher: &mut Sha256, content: &[u8], cancel: &Cancel) -> Result<(), Cancelled> {
    for block in content.chunks(BLOCK) {
        cancel.check()?;
        hasher.update(block);
    }
    Ok(())
}
