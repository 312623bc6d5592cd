//! The project file: parameters as TOML under a `kind`, and behind them what only the window needs.
//!
//! ```toml
//! kind = "mold"
//! version = 1
//! mesh = "part.stl"
//! tolerance_mm = 0.05
//!
//! [[files]]           # what the named files held
//! [results]           # what was computed, to be shown again at once
//! [kept]              # what the user keeps
//! [autosave]          # only in copies of unsaved work
//! ```
//!
//! A file written by hand needs nothing but `kind` and the parameters that are not at their defaults.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use toml::Spanned;
use toml::de::{DeTable, DeValue, Deserializer};

use super::{Params, PartFile};
use crate::paths::{folder_of, relative, without_detours};
use crate::toml_file::{keys_in, one_line, read_text, syntax, write_text};
use crate::{FileError, Invalid};

/// The largest project that is written or read (bytes).
pub const LARGEST_PROJECT: u64 = 64 << 20;
/// Version of the file's own keys.
const VERSION: u32 = 1;
/// How much of a file is read from its beginning or its end to tell what it is (bytes).
const END: u64 = 1 << 16;
/// Keys that are not of the parameters.
const OWN: [&str; 6] = ["kind", "version", "files", "results", "kept", "autosave"];

/// What a project file holds.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Project<P> {
    /// The parameters, with absolute paths.
    pub params: P,
    /// What the files that they name held.
    pub files: Vec<PartFile>,
    /// Results by name.
    pub results: BTreeMap<String, String>,
    /// What the user keeps, by name.
    pub kept: BTreeMap<String, String>,
}

/// What a copy of unsaved work says of itself.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CopyNote {
    /// The project file that it was to be saved in, if it had one.
    pub file: Option<PathBuf>,
    /// SHA-256 of that file as it was read or saved last.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sha256: Option<String>,
    /// What the part is called.
    pub part: String,
}

#[derive(Serialize)]
struct Head {
    kind: &'static str,
    version: u32,
}

fn first() -> u32 {
    1
}

/// The file's own keys; those of its head are written before the parameters.
#[derive(Default, Serialize, Deserialize)]
struct Tail {
    #[serde(skip_serializing)]
    kind: Option<String>,
    #[serde(default = "first", skip_serializing)]
    version: u32,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    files: Vec<PartFile>,
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    results: BTreeMap<String, String>,
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    kept: BTreeMap<String, String>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    autosave: Option<CopyNote>,
}

/// The `kind` of a project file, which tells the workspace that opens it. Where its beginning tells, no more is read.
///
/// # Errors
/// [`FileError`] if it cannot be read or is no project.
pub fn kind_of(file: &Path) -> Result<String, FileError> {
    let head = end_of(file, SeekFrom::Start(0)).map_err(|source| FileError::unreadable(file, source))?;
    let (root, _) = DeTable::parse_recoverable(&head);
    if let Some(kind) = root.get_ref().get("kind").and_then(|kind| kind.get_ref().as_str()) {
        return Ok(kind.to_owned());
    }
    let text = text_of(file)?;
    split(&text, file).map(|(kind, ..)| kind)
}

/// The text of the project in `file`.
pub(super) fn text_of(file: &Path) -> Result<String, FileError> {
    read_text(file, "project", LARGEST_PROJECT)
}

/// What a copy of unsaved work says of itself, which it does at its end.
pub(super) fn note_of(file: &Path) -> Option<CopyNote> {
    #[derive(Deserialize)]
    struct Note {
        autosave: CopyNote,
    }
    let size = std::fs::metadata(file).ok()?.len();
    let tail = end_of(file, SeekFrom::Start(size.saturating_sub(END))).ok()?;
    let note: Note = toml::from_str(tail.get(tail.rfind("[autosave]")?..)?).ok()?;
    Some(note.autosave)
}

/// A text of at most [`END`] bytes in `file`, from this place on.
fn end_of(file: &Path, from: SeekFrom) -> std::io::Result<String> {
    let (mut file, mut bytes) = (File::open(file)?, Vec::new());
    file.seek(from)?;
    file.take(END).read_to_end(&mut bytes)?;
    Ok(String::from_utf8_lossy(&bytes).into_owned())
}

/// The first number in `value` that is not finite, with its key.
fn not_finite(key: &str, value: &DeValue) -> Option<(String, String)> {
    match value {
        DeValue::Float(number) if number.as_str().contains(['n', 'f']) => {
            Some((key.to_owned(), number.as_str().to_owned()))
        }
        DeValue::Array(all) => {
            all.iter().enumerate().find_map(|(i, one)| not_finite(&format!("{key}[{i}]"), one.get_ref()))
        }
        DeValue::Table(all) => {
            all.iter().find_map(|(name, one)| not_finite(&format!("{key}.{}", name.get_ref()), one.get_ref()))
        }
        _ => None,
    }
}

/// The kind, the file's own keys, and the parameters.
fn split<'a>(text: &'a str, file: &Path) -> Result<(String, Tail, Deserializer<'a>), FileError> {
    let wrong = |error: &toml::de::Error| syntax(file, text, error);
    let root = DeTable::parse(text).map_err(|e| wrong(&e))?;
    if let Some((key, value)) =
        root.get_ref().iter().find_map(|(key, value)| not_finite(key.get_ref(), value.get_ref()))
    {
        return Err(FileError::placed(file, text, Invalid::new(key, value, "must be a finite number")));
    }
    let span = root.span();
    let is_own = |key: &str| OWN.contains(&key);
    let (own, params): (Vec<_>, Vec<_>) = root.into_inner().into_iter().partition(|(key, _)| is_own(key.get_ref()));
    let [own, params] =
        [own, params].map(|entries| Deserializer::from(Spanned::new(span.clone(), entries.into_iter().collect())));
    let mut tail = Tail::deserialize(own).map_err(|e| wrong(&e))?;
    let Some(kind) = tail.kind.take() else {
        let remedy = "it is missing; write the workspace in the first line: kind = \"blisk\", \"mold\" or \"flank\"";
        return Err(FileError::placed(file, text, Invalid::of("kind", remedy)));
    };
    if tail.version > VERSION {
        let remedy = format!("this program reads up to {VERSION}; open it with the newer program that saved it");
        return Err(FileError::placed(file, text, Invalid::new("version", tail.version, remedy)));
    }
    Ok((kind, tail, params))
}

impl<P: Params> Project<P> {
    /// Reads a copy of unsaved work, whose parameters need not be possible.
    ///
    /// # Errors
    /// [`FileError`] with line and key where they are known.
    pub(super) fn read_copy(file: &Path) -> Result<(Self, CopyNote), FileError> {
        let (project, note) = Self::parse_any(&text_of(file)?, file)?;
        Ok((project, note.unwrap_or_default()))
    }

    /// The project in `text`, which is that of `file`.
    ///
    /// # Errors
    /// [`FileError`] with line and key where they are known.
    pub fn parse(text: &str, file: &Path) -> Result<Self, FileError> {
        let (project, _) = Self::parse_any(text, file)?;
        // Last, as validation may look into the files that are named.
        project.params.validate().map_err(|problem| FileError::placed(file, text, problem))?;
        Ok(project)
    }

    /// The project in `text`, whose parameters need not be possible.
    fn parse_any(text: &str, file: &Path) -> Result<(Self, Option<CopyNote>), FileError> {
        let (kind, tail, params) = split(text, file)?;
        if kind != P::KIND {
            let remedy = format!("must be \"{}\" here", P::KIND);
            return Err(FileError::placed(file, text, Invalid::new("kind", format!("\"{kind}\""), remedy)));
        }
        let mut params = P::deserialize(params).map_err(|error| syntax(file, text, &error))?;
        let folder = folder_of(file);
        let seen = |path: &Path| without_detours(&folder.join(path));
        params.change_paths(&mut |path| seen(path));
        params.complete(&keys_in(text)).map_err(|problem| FileError::placed(file, text, problem))?;
        let files = tail.files.into_iter().map(|part| PartFile { path: seen(&part.path), ..part }).collect();
        Ok((Self { params, files, results: tail.results, kept: tail.kept }, tail.autosave))
    }

    /// Writes the project file.
    ///
    /// # Errors
    /// [`FileError`], also of parameters that could not be read again; what was there before then still is.
    pub fn write(&self, file: &Path) -> Result<(), FileError> {
        write_text(file, &self.text(file, None)?, LARGEST_PROJECT)
    }

    /// The text of the project, to lie at `file`. Only those of a copy, which says so in a note, need not be possible.
    pub(super) fn text(&self, file: &Path, autosave: Option<CopyNote>) -> Result<String, FileError> {
        if autosave.is_none() {
            self.params.validate().map_err(|problem| FileError::invalid(file, problem))?;
        }
        let folder = folder_of(file);
        let mut params = self.params.clone();
        params.change_paths(&mut |path| relative(path, &folder));
        let part = |part: &PartFile| PartFile { path: relative(&part.path, &folder), ..part.clone() };
        let files = self.files.iter().map(part).collect();
        let (results, kept) = (self.results.clone(), self.kept.clone());
        let tail = Tail { files, results, kept, autosave: autosave.clone(), ..Tail::default() };
        let unwritten = |problem: String| FileError::NotWritten { file: file.to_owned(), problem };
        let texts = [
            toml::to_string_pretty(&Head { kind: P::KIND, version: VERSION }),
            toml::to_string_pretty(&params),
            toml::to_string_pretty(&tail),
        ];
        let [head, params, tail] = texts.map(|text| text.map_err(|e| unwritten(one_line(&e.to_string()))));
        let (head, params, tail) = (head?, params?, tail?);
        // Tables follow values: the head comes first, the file's own tables last.
        let between = if tail.is_empty() { "" } else { "\n" };
        let text = format!("{head}{params}{between}{tail}");
        if text.len() as u64 > LARGEST_PROJECT && !self.results.is_empty() {
            // Results can be computed again: they keep nothing from being saved.
            return Self { results: BTreeMap::new(), ..self.clone() }.text(file, autosave);
        }
        Ok(text)
    }
}
