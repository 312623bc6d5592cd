//! The answer of a point, as a file.

use std::collections::BTreeMap;
use std::path::Path;

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

use files::{FileError, Invalid, PartFile, read_text, write_bytes};

/// Version of the keys of `answer.json`.
const SCHEMA: u32 = 1;
/// The largest answer that is read (bytes).
const LARGEST: u64 = 4 << 20;

/// Exit code of a point that is done and verified.
pub const YES: u8 = 0;
/// Exit code of a point that cannot be: its settings or its files are wrong. It is not tried again.
pub const BAD: u8 = 2;
/// Exit code of a point that is not feasible.
pub const NO: u8 = 3;

/// Answer of a point.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Answer {
    schema: u32,
    /// Number of the point, counted from 1.
    pub point: usize,
    /// Exit code of the command.
    pub exit_code: u8,
    /// The answer in a sentence; of a bad point the reason.
    pub sentence: String,
    /// Version of the program.
    pub program_version: String,
    /// Digest of the study and its project.
    pub study_sha256: String,
    /// The files that went in, with paths as seen from the folder of the study.
    pub inputs: Vec<PartFile>,
    /// The parameters that were varied.
    pub settings: BTreeMap<String, String>,
    /// Time that the point took (s).
    pub seconds: f64,
    /// Results; none of a bad point.
    pub results: Map<String, Value>,
}

impl Answer {
    /// An answer of this program, without files, time and results.
    pub fn of(point: usize, study_sha256: &str, settings: BTreeMap<String, String>) -> Self {
        Self {
            schema: SCHEMA,
            point,
            exit_code: BAD,
            sentence: String::new(),
            program_version: env!("CARGO_PKG_VERSION").to_owned(),
            study_sha256: study_sha256.to_owned(),
            inputs: Vec::new(),
            settings,
            seconds: 0.0,
            results: Map::new(),
        }
    }

    /// Reads the answer of a point; none if there is no such file.
    ///
    /// # Errors
    /// [`FileError`] of a file that is no answer, or that of another point.
    pub fn read(file: &Path, point: usize) -> Result<Option<Self>, FileError> {
        let text = match read_text(file, "answer", LARGEST) {
            Err(error) if error.is_not_found() => return Ok(None),
            text => text?,
        };
        let wrong = |problem: String| {
            FileError::invalid(file, Invalid::of("", format!("{problem}; remove it, and run the point again")))
        };
        let answer: Self = serde_json::from_str(&text).map_err(|e| wrong(format!("this is no answer: {e}")))?;
        if answer.point != point {
            return Err(wrong(format!("this is the answer of point {}", answer.point)));
        }
        let is_known = answer.schema == SCHEMA && [YES, BAD, NO].contains(&answer.exit_code);
        if is_known { Ok(Some(answer)) } else { Err(wrong("this is an answer of another form".to_owned())) }
    }

    /// Writes the answer atomically.
    ///
    /// # Errors
    /// [`FileError`].
    pub fn write(&self, file: &Path) -> Result<(), FileError> {
        // What it holds are numbers, words and lists of these, all of which JSON has.
        let text = serde_json::to_string_pretty(self).unwrap_or_default() + "\n";
        write_bytes(file, text.as_bytes())
    }
}
