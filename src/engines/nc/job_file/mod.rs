//! The job file: a workpiece, its electrodes, where each of them burns, and how, for the software of machines and cells. It
//! exists as JSON, whose schema is [`SCHEMA`], as XML of the same structure, and as CSV with one row for each operation.
//! Lengths are in mm, angles in degrees. What is not known is null in JSON, and left out or empty in the others.

mod example;
mod formats;
mod of_table;
#[cfg(test)]
mod tests;

use std::path::Path;

use serde::{Deserialize, Serialize};

use super::measuring_points::MeasuringPoint;

/// JSON schema of a job file, by which other programs can check it.
pub const SCHEMA: &str = include_str!("job.schema.json");
/// Name and version of the format.
pub const FORMAT: &str = "sparkpath-job-2";

/// A job.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct JobFile {
    /// [`FORMAT`].
    pub format: String,
    /// Version of the program.
    pub program_version: String,
    /// The workpiece.
    pub workpiece: Workpiece,
    /// The electrodes in the order in which they burn.
    pub electrodes: Vec<JobElectrode>,
}

/// The largest job file that is read (bytes).
const LARGEST_FILE: u64 = 64 << 20;

/// Reason why a file is no job.
#[derive(Debug, thiserror::Error)]
pub enum JobFileError {
    /// File cannot be read.
    #[error(transparent)]
    File(#[from] files::FileError),
    /// The text is no job.
    #[error(
        "{file}: this is no job of the format {FORMAT}: {problem}; export the job again, or compare with its schema"
    )]
    Wrong {
        /// The file.
        file: String,
        /// Problem, with the line.
        problem: String,
    },
}

impl JobFile {
    /// The job in the JSON file `file`, of at most 64 MiB.
    ///
    /// # Errors
    /// [`JobFileError`].
    pub fn read(file: &Path) -> Result<Self, JobFileError> {
        let text = files::read_text(file, "job", LARGEST_FILE)?;
        let wrong = |problem| JobFileError::Wrong { file: file.display().to_string(), problem };
        let job: Self = serde_json::from_str(&text).map_err(|error| wrong(error.to_string()))?;
        if job.format != FORMAT {
            return Err(wrong(format!("its format is {:?}", job.format)));
        }
        if job.electrodes.is_empty() {
            return Err(wrong("it has no electrode".to_owned()));
        }
        for electrode in &job.electrodes {
            let lengths = [electrode.spark_gap_mm, electrode.undersize_wall_mm, electrode.undersize_floor_mm];
            if lengths.into_iter().any(|length| length < 0.0) {
                return Err(wrong(format!("{}: spark gap and undersize are 0 or more", electrode.id)));
            }
        }
        Ok(job)
    }
}

/// Kind of a workpiece.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum WorkpieceKind {
    /// A wheel with channels.
    Wheel,
    /// A mold.
    Mold,
}

/// A workpiece.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Workpiece {
    /// Identifier in this file.
    pub id: String,
    /// Name.
    pub name: String,
    /// Kind.
    pub kind: WorkpieceKind,
    /// Number of channels of a wheel.
    pub channels: Option<usize>,
    /// The axes that positions are in, in words.
    pub axes: String,
    /// Origin of these axes in the coordinates of the workpiece's file (mm).
    pub origin_mm: [f64; 3],
    /// Unit vector of their X in these coordinates.
    pub x_axis: [f64; 3],
    /// Unit vector of their Z in these coordinates.
    pub z_axis: [f64; 3],
    /// SHA-256 of the workpiece's triangles in these axes, as certificates have it, not that of its file; none if no path was
    /// verified against it.
    pub mesh_sha256: Option<String>,
}

/// A file beside the job.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FileEntry {
    /// Name.
    pub name: String,
    /// SHA-256 of the bytes.
    pub sha256: String,
}

impl FileEntry {
    /// A file of this name with these bytes.
    pub fn of(name: &str, bytes: &[u8]) -> Self {
        Self { name: name.to_owned(), sha256: files::sha256(bytes) }
    }
}

/// An orbit.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct JobOrbit {
    /// Name of the pattern: circular or square.
    pub pattern: String,
    /// Radius or half side (mm).
    pub radius_mm: f64,
}

/// Technology that an electrode burns with.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct JobTechnology {
    /// Name of the table.
    pub table: String,
    /// Identifier in the table.
    pub id: String,
    /// Step at which burning ends; none if it ends at a finish.
    pub last_step: Option<String>,
    /// Finish at which burning ends (VDI 3400); none if it ends at a step.
    pub finish_vdi: Option<f64>,
}

/// An electrode.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct JobElectrode {
    /// Identifier in this file.
    pub id: String,
    /// Name.
    pub name: String,
    /// Files of the electrode.
    pub files: Vec<FileEntry>,
    /// Axes of these files, in words.
    pub axes: String,
    /// Whether the undersize is in the files already.
    pub is_undersized: bool,
    /// Material; none where it is not known.
    pub material: Option<String>,
    /// Stage, as rough or finish; none in a wheel.
    pub stage: Option<String>,
    /// Number of pieces to make, as given; none in a wheel.
    pub quantity: Option<usize>,
    /// Number of pieces that the wear asks for, in words.
    pub needed: String,
    /// Spark gap (mm).
    pub spark_gap_mm: f64,
    /// Undersize across a wall (mm): spark gap, stock and orbit.
    pub undersize_wall_mm: f64,
    /// Undersize across a floor (mm).
    pub undersize_floor_mm: f64,
    /// The orbit; none if it does not orbit.
    pub orbit: Option<JobOrbit>,
    /// The technology; none where it is not known.
    pub technology: Option<JobTechnology>,
    /// Length that the front loses at one location, on average (mm); none if wear is not considered.
    pub end_wear_mm: Option<f64>,
    /// Points at which it is measured on its holder, in the axes of its files.
    pub inspection_points: Vec<MeasuringPoint>,
    /// The places where it burns.
    pub locations: Vec<Location>,
}

/// Values of the axes in the final pose: in a wheel the motion from where the electrode stands in W, in a mold the place of
/// the electrode's origin.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Position {
    /// X (mm).
    pub x_mm: f64,
    /// Y (mm).
    pub y_mm: f64,
    /// Z (mm).
    pub z_mm: f64,
    /// A (degrees); none where the electrode burns from the side of a mold.
    pub a_deg: Option<f64>,
    /// B (degrees); none where A is.
    pub b_deg: Option<f64>,
    /// C, about the direction of the burn (degrees).
    pub c_deg: f64,
}

/// A place where an electrode burns.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Location {
    /// Identifier in this file.
    pub id: String,
    /// Number of the channel, from 0; none in a mold.
    pub channel: Option<usize>,
    /// Final position.
    pub position: Position,
    /// Motion from the axes of the electrode's files to those of the job, as three rows of a rotation with the shift in the
    /// fourth column (mm), and a row that is always 0 0 0 1; none in a wheel.
    pub pose: Option<[[f64; 4]; 4]>,
    /// Unit vector along which the electrode comes in at last; none where no path is certified.
    pub approach: Option<[f64; 3]>,
    /// Depth (mm); none where it is that of a path.
    pub depth_mm: Option<f64>,
    /// Distance by which it is retracted (mm); none where it is that of a path.
    pub retract_mm: Option<f64>,
    /// The operations in their order.
    pub operations: Vec<Operation>,
}

/// Kind of an operation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum OperationKind {
    /// Sinking along the approach.
    Sink,
    /// Feed along a path.
    Feed,
    /// Motion from the final pose to the walls and back.
    Copying,
}

/// An operation.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Operation {
    /// Identifier in this file.
    pub id: String,
    /// Kind.
    pub kind: OperationKind,
    /// File of its path; none if it has no path, or if its file is not written.
    pub path: Option<FileEntry>,
    /// SHA-256 of the path that was verified; none if it has no path.
    pub path_sha256: Option<String>,
    /// The certified clearance along its path (mm); none if it has no path.
    pub certified_clearance_mm: Option<f64>,
    /// Volume that it removes (mm^3); none if it is not known, or is in the operation before.
    pub volume_mm3: Option<f64>,
    /// Minutes that it takes; none if they are not known, or are in the operation before.
    pub minutes: Option<f64>,
}
