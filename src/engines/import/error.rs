//! Errors of mesh files, in one line: file, place, remedy.

use std::io;

use task::Cancelled;

/// Reason why a mesh file was not imported. Its text is one line that names the file, the place in it and the remedy.
#[derive(Debug, thiserror::Error)]
pub enum ImportError {
    /// The file cannot be opened or read.
    #[error("{file}: cannot be read ({source}); check the path, the permissions and the disk")]
    Unreadable {
        /// Path as given.
        file: String,
        /// Error of the system.
        source: io::Error,
    },
    /// The path leads to a folder or a device.
    #[error("{file}: is {kind}, not a file; give the path of a mesh file")]
    NotAFile {
        /// Path as given.
        file: String,
        /// Kind of file found.
        kind: &'static str,
    },
    /// The content is of no format that can be read.
    #[error(
        "{file}: {found}; expected a part as STL (binary or ASCII), OBJ, glTF, GLB or STEP: export it again as one of these"
    )]
    UnknownFormat {
        /// Path as given.
        file: String,
        /// Apparent content.
        found: String,
    },
    /// The content breaks the rules of its format.
    #[error("{file}: {place}: {problem}; {remedy}")]
    Malformed {
        /// Path as given.
        file: String,
        /// Line, triangle, vertex or element.
        place: String,
        /// Problem found there.
        problem: String,
        /// Remedy.
        remedy: &'static str,
    },
    /// The file would take more than the limits allow.
    #[error("{file}: {found} {what} exceed the limit of {limit}; reduce the mesh or raise `{option}`")]
    TooLarge {
        /// Path as given.
        file: String,
        /// Quantity that exceeds the limit.
        what: &'static str,
        /// How much the file asks for.
        found: u64,
        /// How much is allowed.
        limit: u64,
        /// The field of [`ImportLimits`](super::ImportLimits) that says so.
        option: &'static str,
    },
    /// The file is sound but has no triangle with an area.
    #[error("{file}: holds no triangles with an area; export the surface as triangles")]
    NoTriangles {
        /// Path as given.
        file: String,
    },
    /// A STEP file that gives no part.
    #[error("{file}: {source}")]
    Step {
        /// Path as given.
        file: String,
        /// Reason, with the remedy.
        source: step::StepError,
    },
    /// Solids are asked for that the file does not hold.
    #[error("{file}: there is no solid {number} among its {count}: {names}; give numbers of these")]
    NoSuchSolid {
        /// Path as given.
        file: String,
        /// Number asked for.
        number: u32,
        /// Number of solids.
        count: usize,
        /// The first of them, numbered.
        names: String,
    },
    /// A solid cannot be both.
    #[error("{file}: solid {number} is named among the solids of the part and among the obstacles; name it once")]
    PartAndObstacle {
        /// Path as given.
        file: String,
        /// Number of the solid.
        number: u32,
    },
    /// Nothing is left for the part.
    #[error("{file}: all solids are obstacles, so that none makes the part; take one of them out of obstacles")]
    OnlyObstacles {
        /// Path as given.
        file: String,
    },
    /// The unit would have to be guessed, and that is too dangerous.
    #[error(
        "{file}: it says no unit, and a wrong guess would mill a part of another size (it may be {guess}); set the \
         unit: `--units mm` or `--units inch` on the command line, beside the part in the window"
    )]
    UnitOpen {
        /// Path as given.
        file: String,
        /// Unit that would be guessed, and the reason.
        guess: String,
    },
    /// The options themselves make no sense.
    #[error("import options: {problem}")]
    BadOption {
        /// Problem and remedy.
        problem: String,
    },
    /// Cancelled.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

/// Bytes of a file as they may be shown in an error: short, printable, on one line.
pub fn excerpt(bytes: &[u8]) -> String {
    const LONGEST: usize = 40;
    let shown: String = String::from_utf8_lossy(&bytes[..bytes.len().min(LONGEST)])
        .chars()
        .map(|c| if c.is_control() { '?' } else { c })
        .collect();
    if bytes.len() > LONGEST { format!("\"{shown}...\"") } else { format!("\"{shown}\"") }
}

/// A path as it may be shown in an error: on one line.
pub fn one_line(name: &str) -> String {
    name.chars().map(|c| if c.is_control() { '?' } else { c }).collect()
}
