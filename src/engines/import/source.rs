//! The interface of a reader of a format, and the bytes of a file with all limits a reader needs.

use std::path::Path;

use glam::DVec3;

use super::Reading;
use super::error::ImportError;
use super::limits::ImportLimits;
use super::solids::Solids;
use super::units::Unit;
use geometry::mesh::Mesh;
use task::{Cancelled, Task};

/// How many items a reader handles between two looks at the cancel flag: a few milliseconds of work.
const ITEMS_PER_CHECK: usize = 1 << 14;

/// Description of a format for the importer. Each format has one, in its own file.
pub(super) struct MeshFormat {
    /// Name in a sentence.
    pub name: &'static str,
    /// Likeness of a file to this format.
    pub likeness: fn(&Content) -> Likeness,
    /// Reads a file of this format.
    pub read: fn(&Source) -> Result<RawMesh, ImportError>,
    /// Unit that the format itself prescribes, and who says so.
    pub unit: Option<(Unit, &'static str)>,
}

/// Likeness of a file to a format.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Likeness {
    /// Not at all.
    No,
    /// The name or a part of the content speaks for it; content that is of a foreign format speaks against it.
    Perhaps,
    /// The content begins as files of the format do.
    Likely,
    /// A signature, or a length that no other file has.
    Certain,
}

impl Likeness {
    /// This likeness if `holds`, else none.
    pub fn when(self, holds: bool) -> Self {
        if holds { self } else { Self::No }
    }
}

/// A file as the formats look at it.
pub(super) struct Content<'a> {
    /// The whole content.
    pub bytes: &'a [u8],
    /// Beginning of the content without leading white space, if it is text.
    pub text: Option<&'a [u8]>,
    /// Ending of the file's name in small letters, without the dot.
    pub ending: &'a str,
}

/// The bytes of one file and the circumstances of reading them.
pub(super) struct Source<'a> {
    /// Name for messages.
    pub name: &'a str,
    /// The whole content.
    pub bytes: &'a [u8],
    /// Folder of the file; `None` for bytes that came from memory.
    pub folder: Option<&'a Path>,
    /// Solids, tolerance and unit that are asked for.
    pub reading: &'a Reading,
    /// Limits of the import.
    pub limits: &'a ImportLimits,
    /// Receiver of progress, and cancelling.
    pub task: &'a Task,
}

/// Content of a file: coordinates as they stand in it, vertices as the format shares them.
#[derive(Debug, Default)]
pub(super) struct RawMesh {
    /// Vertices in the file's unit, no two of them equal, and triangles.
    pub mesh: Mesh,
    /// Sentences on what the reader skipped or assumed.
    pub warnings: Vec<String>,
    /// Free text of the file (header, comments) in which a unit may be named.
    pub note: String,
    /// Solids and faces, of a format that has them.
    pub solids: Option<Solids>,
    /// Content of further files that belong to the mesh, in order, for the hash.
    pub attachments: Vec<Vec<u8>>,
}

impl<'a> Source<'a> {
    /// The content as text, without the mark that some editors put in front of UTF-8.
    pub fn text(&self) -> &'a [u8] {
        without_mark(self.bytes)
    }

    /// The error for a `problem` at `place`.
    pub fn malformed(&self, place: impl Into<String>, problem: impl Into<String>, remedy: &'static str) -> ImportError {
        ImportError::Malformed { file: self.name.to_owned(), place: place.into(), problem: problem.into(), remedy }
    }

    /// Refuses a mesh that the limits do not allow.
    pub fn check_mesh(&self, triangles: u64, vertices: u64) -> Result<(), ImportError> {
        self.limits.check_mesh(self.name, self.bytes.len() as u64, triangles, vertices)
    }

    /// `p` if it is finite; `place` is only called for the error.
    pub fn finite(&self, p: DVec3, place: impl FnOnce() -> String) -> Result<DVec3, ImportError> {
        if p.is_finite() {
            return Ok(p);
        }
        Err(self.malformed(
            place(),
            format!("a coordinate is not a finite number ({}, {}, {})", p.x, p.y, p.z),
            "repair the mesh where it was made and export it again",
        ))
    }

    /// Reports progress and looks at the cancel flag every so many items of `total`.
    pub fn tick(&self, stage: &str, item: usize, total: usize) -> Result<(), Cancelled> {
        tick(self.task, stage, item, total)
    }
}

/// A text without the mark that some editors put in front of UTF-8.
pub(super) fn without_mark(text: &[u8]) -> &[u8] {
    text.strip_prefix(b"\xef\xbb\xbf").unwrap_or(text)
}

/// Reports progress and looks at the cancel flag every so many items of `total`.
pub(super) fn tick(task: &Task, stage: &str, item: usize, total: usize) -> Result<(), Cancelled> {
    if item.is_multiple_of(ITEMS_PER_CHECK) {
        task.report(stage, item as f64 / total.max(1) as f64, "");
        task.check()?;
    }
    Ok(())
}

/// `3 holes`, `1 hole`.
pub(super) fn count(n: usize, what: &str) -> String {
    format!("{n} {what}{}", if n == 1 { "" } else { "s" })
}
