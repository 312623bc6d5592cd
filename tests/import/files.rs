//! The short ways to import mesh files.

use import::{ImportError, ImportOptions, Imported, Units, import_bytes};
use task::Task;

pub use super::mesh_files::*;

pub fn import_with(bytes: &[u8], options: &ImportOptions) -> Result<Imported, ImportError> {
    import_bytes("part.mesh", bytes, options, &Task::default())
}

pub fn import(bytes: impl AsRef<[u8]>) -> Imported {
    import_with(bytes.as_ref(), &ImportOptions { reading: Units::Mm.into(), ..Default::default() }).unwrap()
}

/// The error for bytes that must be refused, which must be one line that names the file.
pub fn refusal(bytes: impl AsRef<[u8]>) -> String {
    let error = import_with(bytes.as_ref(), &ImportOptions::default()).unwrap_err();
    let text = error.to_string();
    assert!(text.starts_with("part.mesh: ") && !text.contains('\n'), "{text}");
    text
}

pub fn assert_mentions(text: &str, words: &[&str]) {
    for word in words {
        assert!(text.contains(word), "no \"{word}\" in: {text}");
    }
}
