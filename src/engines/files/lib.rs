//! Files that the program reads and writes, and the parameters in them.
//!
//! - [`TomlFile`] reads and writes tables of any kind (cutters, holders, machines, posts) with one [`FileError`] that
//!   names file, line, key and remedy.
//! - [`FieldTable`] describes parameters once. Forms, `--set KEY=VALUE`, documentation and reports are made from it.
//! - [`Document`] keeps parameters with undo, a project file, kept results, and [`Autosave`] keeps unsaved work.
//! - [`ResultCache`] keeps results of long computations beside projects, so that they are shown again at once.
//! - [`ExportFolder`] writes all files of an export or none, and knows its own files by a manifest.
//! - [`report`] makes HTML pages from templates.
//!
//! None of it knows a workspace, a window or a job.

pub mod atomic;
mod document;
mod error;
mod export_folder;
mod fields;
mod overrides;
pub mod paths;
pub mod patience;
pub mod report;
mod result_cache;
mod toml_file;

pub use atomic::{atomic_write, write_bytes};
pub use document::autosave::{Autosave, Recovery};
pub use document::history::History;
pub use document::project::{LARGEST_PROJECT, kind_of};
pub use document::saving::Saving;
pub use document::{AnyDocument, Document, MovedFile, Params, PartFile, files_in, sha256, sha256_of};
pub use error::{FileError, Invalid, Validate};
pub use export_folder::{ExportFolder, MANIFEST, Published};
pub use fields::listing::{Entry, ParameterList};
pub use fields::table::{FieldTable, Group, Place};
pub use fields::text::{AXIS_NAMES, direction_words, inline_toml};
pub use fields::{Field, Instead, Kind, Range, Variant, When, Word, get, put, word};
pub use overrides::{Figures, Override};
pub use result_cache::ResultCache;
pub use toml_file::{TomlFile, read_text};
