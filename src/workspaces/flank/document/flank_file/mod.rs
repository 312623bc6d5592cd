//! Files of flanks: the surface, the cutter and how it is milled.

use std::path::{Path, PathBuf};

use super::milling_machine_file::file_of_machine;
use crate::workspaces::flank::document::{FlankDocument, FlankSource, GuideSource};
use files::old_toml_file;
use files::old_toml_file::{TomlFileError, folder_of};
use files::paths::{relative, without_detours};

/// How the name of such a file ends.
pub const ENDING: &str = ".sparkflank";
/// The largest that is written or read (bytes): it may hold a mesh.
const LARGEST_FILE: u64 = 64 << 20;

/// Whether `path` is named as a file of a flank.
pub fn is_flank_file(path: &Path) -> bool {
    old_toml_file::has_ending(path, ENDING)
}

/// Writes `document` as a TOML file, with the files that it names as seen from the file's folder.
///
/// # Errors
/// [`TomlFileError`], also of a document that could not be read again.
pub fn write_flank(file: &Path, document: &FlankDocument) -> Result<(), TomlFileError> {
    document.validate().map_err(|problem| TomlFileError::of(file, problem))?;
    let folder = folder_of(file);
    old_toml_file::write(file, &with_files(document, |f| relative(f, &folder)), LARGEST_FILE)
}

/// The document in a file that [`write_flank`] has written.
///
/// # Errors
/// [`TomlFileError`].
pub fn read_flank(file: &Path) -> Result<FlankDocument, TomlFileError> {
    let document: FlankDocument = old_toml_file::read(file, "flank", LARGEST_FILE)?;
    let folder = folder_of(file);
    let document = with_files(&document, |f| without_detours(&folder.join(f)));
    // Its post is read for this.
    document.validate().map_err(|problem| TomlFileError::of(file, problem))?;
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
