//! Points of a scan from files: STL, OBJ, PLY, XYZ, CSV.
//!
//! The content decides the format. Of meshes the vertices are taken. Coordinates are in mm.

mod ply;
mod text;

use std::path::Path;

use glam::DVec3;
use import::{ImportLimits, ImportOptions, Reading, Units, excerpt, import_bytes, one_line, read_bytes};
use task::Task;

use crate::MeasuredError;

/// The most that reading a scan may take.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PointLimits {
    /// Number of points.
    pub max_points: u64,
    /// Size of the file, and what the import of a mesh may take.
    pub import: ImportLimits,
}

impl Default for PointLimits {
    /// 20 million points; limits of the import as usual.
    fn default() -> Self {
        Self { max_points: 20_000_000, import: ImportLimits::default() }
    }
}

/// Format of a file of points.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PointFormat {
    /// A mesh, STL or OBJ, of which the vertices are taken.
    Mesh,
    /// PLY, ASCII or binary, of which the vertices are taken.
    Ply,
    /// Lines of numbers: XYZ or CSV.
    Text,
}

/// Points of a scan.
#[derive(Debug, Clone, PartialEq)]
pub struct ScanPoints {
    /// The points (mm), in the axes of the file.
    pub points: Vec<DVec3>,
    /// Format of the file.
    pub format: PointFormat,
}

/// Largest coordinate that is believed (mm): a kilometre.
const LARGEST_COORDINATE: f64 = 1e6;

/// Length of text that is looked at to recognise a format (bytes).
const HEAD: usize = 1 << 16;

/// Points that are read between two looks at the cancel flag.
const ITEMS_PER_CHECK: usize = 1 << 14;

/// Reads the points of the scan at `path` (mm).
///
/// # Errors
/// Every error of [`points_from_bytes`], and those of reading the file.
pub fn read_points(path: &Path, limits: &PointLimits, task: &Task) -> Result<ScanPoints, MeasuredError> {
    let bytes = read_bytes(path, &limits.import, task)?;
    points_from_bytes(&path.display().to_string(), &bytes, limits, task)
}

/// Reads the points of a scan (mm) from the content of a file; `name` is for messages.
///
/// Text: a point to a line, `x y z` in its first columns or in those that a header line names. Columns are separated by
/// semicolons, tabs, commas or spaces; beside semicolons and tabs a comma may be the decimal mark. Empty lines, lines
/// that begin with `#`, `%` or `//`, and further columns are ignored.
///
/// # Errors
/// [`MeasuredError::UnknownFormat`], [`MeasuredError::Malformed`], [`MeasuredError::TooManyPoints`],
/// [`MeasuredError::NoPoints`], [`MeasuredError::Import`] and [`MeasuredError::Cancelled`]. Each names the file, the
/// place and the remedy. Whatever the bytes, no more memory is taken than the limits allow.
pub fn points_from_bytes(
    name: &str,
    bytes: &[u8],
    limits: &PointLimits,
    task: &Task,
) -> Result<ScanPoints, MeasuredError> {
    let name = one_line(name);
    let source = Source { name: &name, bytes, limits, task };
    let (points, format) = if ply::is_like(bytes) {
        (ply::read(&source)?, PointFormat::Ply)
    } else if import::detect(&name, bytes).is_ok() {
        let reading = Reading::whole(Units::Mm);
        let options = ImportOptions { reading, limits: limits.import, ..ImportOptions::default() };
        (import_bytes(&name, bytes, &options, task)?.mesh.vertices, PointFormat::Mesh)
    } else if text::is_like(&bytes[..bytes.len().min(HEAD)]) {
        (text::read(&source)?, PointFormat::Text)
    } else {
        let found = match bytes {
            [] => "the file is empty".to_owned(),
            _ => format!("unknown content {}", excerpt(bytes)),
        };
        return Err(MeasuredError::UnknownFormat { file: name, found });
    };
    if points.is_empty() {
        return Err(MeasuredError::NoPoints { file: name });
    }
    source.check_count(points.len() as u64)?;
    Ok(ScanPoints { points, format })
}

/// The content of one file and the circumstances of reading it.
struct Source<'a> {
    name: &'a str,
    bytes: &'a [u8],
    limits: &'a PointLimits,
    task: &'a Task,
}

impl Source<'_> {
    fn malformed(&self, place: String, problem: impl Into<String>, remedy: &'static str) -> MeasuredError {
        MeasuredError::Malformed { file: self.name.to_owned(), place, problem: problem.into(), remedy }
    }

    fn check_count(&self, found: u64) -> Result<(), MeasuredError> {
        let limit = self.limits.max_points;
        if found <= limit {
            return Ok(());
        }
        Err(MeasuredError::TooManyPoints { file: self.name.to_owned(), found, limit })
    }

    /// `p` if it can be a point of a part; `place` is only called for the error.
    fn believed(&self, p: DVec3, place: impl FnOnce() -> String) -> Result<DVec3, MeasuredError> {
        // Written so that NaN fails.
        if p.abs().cmple(DVec3::splat(LARGEST_COORDINATE)).all() {
            return Ok(p);
        }
        let problem = format!("({}, {}, {}) is no point of a part in mm", p.x, p.y, p.z);
        Err(self.malformed(place(), problem, "remove the point, or check the unit and export the scan again"))
    }

    /// Reports progress and looks at the cancel flag now and then; `done` is the share that is done.
    fn tick(&self, item: usize, done: f64) -> Result<(), MeasuredError> {
        if item.is_multiple_of(ITEMS_PER_CHECK) {
            self.task.check()?;
            self.task.report("reading points", done, "");
        }
        Ok(())
    }
}
