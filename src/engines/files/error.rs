//! Errors of parameters and of files.

use std::fmt;
use std::io;
use std::path::{Path, PathBuf};

/// Parameters that can be checked before anything is computed with them.
pub trait Validate {
    /// Checks that every value is possible, alone and together with the others.
    ///
    /// # Errors
    /// The first value that is not possible.
    fn validate(&self) -> Result<(), Invalid>;
}

impl Validate for toml::Table {
    fn validate(&self) -> Result<(), Invalid> {
        Ok(())
    }
}

/// A value that is not possible, or a key that is not known.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Invalid {
    /// Path of the parameter, as in `electrodes.stages[0].gap_mm`; may be empty.
    pub key: String,
    /// The value, without its unit; empty where none was given.
    pub value: String,
    /// Remedy: what is allowed, or what to do.
    pub remedy: String,
}

impl std::error::Error for Invalid {}

impl fmt::Display for Invalid {
    /// The command line shows this text with the key. Windows show
    /// [`FieldTable::in_window`](crate::FieldTable::in_window).
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match (self.key.is_empty(), self.value.is_empty()) {
            (true, _) => f.write_str(&self.remedy),
            (_, true) => write!(f, "{}: {}", self.key, self.remedy),
            _ => write!(f, "{} is {}: {}", self.key, self.value, self.remedy),
        }
    }
}

impl Invalid {
    /// A value that is not possible.
    pub fn new(key: impl Into<String>, value: impl fmt::Display, remedy: impl Into<String>) -> Self {
        Self { key: key.into(), value: value.to_string(), remedy: remedy.into() }
    }

    /// An error of `key` as a whole, such as an empty list.
    pub fn of(key: impl Into<String>, remedy: impl Into<String>) -> Self {
        Self::new(key, "", remedy)
    }

    /// Error of a part of a larger whole: `prefix` is put before the key.
    #[must_use]
    pub fn within(self, prefix: &str) -> Self {
        let key = match self.key.as_str() {
            "" => prefix.to_owned(),
            key if key.starts_with('[') => format!("{prefix}{key}"),
            key => format!("{prefix}.{key}"),
        };
        Self { key, ..self }
    }

    /// Checks that `value` lies from `least` to `greatest`, which may be infinite.
    ///
    /// # Errors
    /// The allowed range, if `value` lies outside or is not a number.
    pub fn unless_within(key: &str, value: f64, [least, greatest]: [f64; 2], unit: &str) -> Result<(), Self> {
        if (least..=greatest).contains(&value) && value.is_finite() {
            return Ok(());
        }
        Err(Self::new(key, value, allowed([least, greatest], unit)))
    }
}

/// The allowed numbers in words.
pub(crate) fn allowed([least, greatest]: [f64; 2], unit: &str) -> String {
    let unit = if unit.is_empty() { String::new() } else { format!(" {unit}") };
    match (least.is_finite(), greatest.is_finite()) {
        (true, true) => format!("must be from {least} to {greatest}{unit}"),
        (true, false) => format!("must be at least {least}{unit}"),
        (false, true) => format!("must be at most {greatest}{unit}"),
        (false, false) => "must be a number".to_owned(),
    }
}

/// Reason why a file cannot be read or written: file, line, key, remedy.
#[derive(Debug, thiserror::Error)]
pub enum FileError {
    /// The system cannot read the file.
    #[error("{}: cannot be read ({source}); check the path", file.display())]
    Unreadable {
        /// The file.
        file: PathBuf,
        /// Message of the system.
        source: io::Error,
    },
    /// The system cannot write the file.
    #[error("{}: cannot be written ({source}); check that the folder exists, is writable and has room", file.display())]
    Unwritable {
        /// The file.
        file: PathBuf,
        /// Message of the system.
        source: io::Error,
    },
    /// The file is larger than files of its kind may be.
    #[error("{}: more than {most} bytes, which no {what} has; open another file", file.display())]
    TooLarge {
        /// The file.
        file: PathBuf,
        /// The kind of file that was expected, such as `library of cutters`.
        what: String,
        /// Greatest size that is read (bytes).
        most: u64,
    },
    /// Another program has changed the file since it was read; nothing was written.
    #[error("{}: was changed by another program since it was read; save under another name, or replace it", file.display())]
    Changed {
        /// The file.
        file: PathBuf,
    },
    /// The drive of the file does not answer.
    #[error("{}: the drive does not answer; try again, or use another drive", file.display())]
    Silent {
        /// The file.
        file: PathBuf,
    },
    /// The name of the file is no Unicode, so that no other file can name it.
    #[error("{}: the name has characters that are not UTF-8; rename the file or its folder", file.display())]
    Unnamed {
        /// The file.
        file: PathBuf,
    },
    /// The file was not written, because it could not be read again.
    #[error("{}: not written: {problem}", file.display())]
    NotWritten {
        /// The file.
        file: PathBuf,
        /// Reason and remedy.
        problem: String,
    },
    /// The file is no text or no TOML, or has a key that is unknown or of the wrong kind.
    #[error("{}: {}{problem}; {remedy}", file.display(), place(*line, key))]
    Syntax {
        /// The file.
        file: PathBuf,
        /// Line, counted from 1.
        line: Option<usize>,
        /// The key at this place; empty if there is none.
        key: String,
        /// Reason.
        problem: String,
        /// Remedy.
        remedy: &'static str,
    },
    /// A value that is not possible.
    #[error("{}: {}{source}", file.display(), place(*line, ""))]
    Invalid {
        /// The file.
        file: PathBuf,
        /// Line, counted from 1; none if the key is not in the file.
        line: Option<usize>,
        /// Key, value and remedy.
        source: Invalid,
    },
}

fn place(line: Option<usize>, key: &str) -> String {
    let line = line.map_or_else(String::new, |n| format!("line {n}: "));
    if key.is_empty() { line } else { format!("{line}{key}: ") }
}

impl FileError {
    /// The system cannot read `file`.
    pub fn unreadable(file: &Path, source: io::Error) -> Self {
        Self::Unreadable { file: file.to_owned(), source }
    }

    /// The system cannot write `file`.
    pub fn unwritable(file: &Path, source: io::Error) -> Self {
        Self::Unwritable { file: file.to_owned(), source }
    }

    /// A wrong value in `file`, without its line.
    pub fn invalid(file: &Path, source: Invalid) -> Self {
        Self::Invalid { file: file.to_owned(), line: None, source }
    }

    /// Whether the file does not exist.
    pub fn is_not_found(&self) -> bool {
        matches!(self, Self::Unreadable { source, .. } if source.kind() == io::ErrorKind::NotFound)
    }

    /// Whether another program has changed the file since it was read.
    pub fn is_changed(&self) -> bool {
        matches!(self, Self::Changed { .. })
    }

    /// The line, counted from 1, where it is known.
    pub fn line(&self) -> Option<usize> {
        match self {
            Self::Syntax { line, .. } | Self::Invalid { line, .. } => *line,
            _ => None,
        }
    }

    /// The key, where it is known.
    pub fn key(&self) -> Option<&str> {
        let key = match self {
            Self::Syntax { key, .. } => key,
            Self::Invalid { source, .. } => &source.key,
            _ => return None,
        };
        Some(key).filter(|key| !key.is_empty()).map(String::as_str)
    }
}
