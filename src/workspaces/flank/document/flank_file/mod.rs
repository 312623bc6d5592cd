//! Files of flanks: the surface, the cutter and how it is milled.

use std::path::{Path, PathBuf};

use super::milling_machine_file::file_of_machine;
use crate::workspaces::flank::document::{FlankDocument, FlankSource, GuideSource};
use files::paths::{folder_of, has_ending, relative, without_detours};
use files::{FileError, Invalid, TomlFile, Validate};
use serde::{Deserialize, Serialize};

/// How the name of such a file ends.
pub const ENDING: &str = ".sparkflank";
/// Such a file, which may hold a mesh.
const FLANK: TomlFile<AsWritten> = TomlFile::new("flank").at_most(64 << 20);

/// A document whose files are seen from its own folder. Validation reads some of them, and so comes later.
#[derive(Serialize, Deserialize)]
#[serde(transparent)]
struct AsWritten(FlankDocument);

impl Validate for AsWritten {
    fn validate(&self) -> Result<(), Invalid> {
        Ok(())
    }
}

/// Whether `path` is named as a file of a flank.
pub fn is_flank_file(path: &Path) -> bool {
    has_ending(path, ENDING)
}

/// Writes `document` as a TOML file, with the files that it names as seen from the file's folder.
///
/// # Errors
/// [`FileError`], also of a document that could not be read again.
pub fn write_flank(file: &Path, document: &FlankDocument) -> Result<(), FileError> {
    document.validate().map_err(|problem| FileError::invalid(file, problem))?;
    let folder = folder_of(file);
    FLANK.write(file, &AsWritten(with_files(document, |f| relative(f, &folder))))
}

/// The document in a file that [`write_flank`] has written.
///
/// # Errors
/// [`FileError`].
pub fn read_flank(file: &Path) -> Result<FlankDocument, FileError> {
    let AsWritten(document) = FLANK.read(file)?;
    let folder = folder_of(file);
    let document = with_files(&document, |f| without_detours(&folder.join(f)));
    // Its post is read for this.
    document.validate().map_err(|problem| FileError::invalid(file, problem))?;
    Ok(document)
}

/// The document with every file that it names changed. Machines and posts are names unless they end in
/// `.toml`.
fn with_files(document: &FlankDocument, change: impl Fn(&Path) -> PathBuf) -> FlankDocument {
    let mut changed = document.clone();
    match &mut changed.source {
        FlankSource::Demonstration { .. } => {}
        FlankSource::Guides { lower, upper } => {
            for guide in [lower, upper] {
                if let GuideSource::File(file) = guide {
                    *file = change(file);
                }
            }
        }
        FlankSource::Mesh(mesh) if mesh.kept.is_some() => {}
        FlankSource::Mesh(mesh) => mesh.file = change(&mesh.file),
    }
    if let Some(walls) = &mut changed.walls {
        walls.file = change(&walls.file);
    }
    let moved = |file: &str| change(Path::new(file)).to_string_lossy().into_owned();
    let milling = &mut changed.milling;
    if let Some((file, name)) = file_of_machine(&milling.machine) {
        let name = name.map_or_else(String::new, |name| format!("#{name}"));
        milling.machine = moved(file) + &name;
    }
    if milling.post.ends_with(".toml") {
        milling.post = moved(&milling.post);
    }
    changed
}

#[cfg(test)]
mod tests;
