//! Floor 5: the document. What a user chooses for a whole job, with undo, files and autosave; and the machines that a
//! job names. It holds no results: the same parameters and seed give the same results again, byte by byte.

mod autosave;
pub mod cutter_file;
mod document;
pub mod electrode_file;
mod field_table;
mod fields;
pub mod flank_file;
pub mod flank_override;
pub mod flank_params;
mod history;
pub mod holder_files;
mod job_file;
pub mod kept_mesh;
mod kept_plan;
pub mod machine_file;
pub mod milling_machine_file;
pub mod mold_file;
mod mold_params;
mod paths;
mod project_file;
mod recent;
mod stage;
mod toml_file;
mod user_folder;

pub use autosave::{Autosave, CopyKind, Recovered, Recovery};
pub use document::{Document, OpenError};
pub use fields::{Field, Kind, Range, job_as_json, with_value};
pub use history::History;
pub use job_file::{BliskSection, ExportSection, JobFileError, PlanJob};
pub use kept_plan::{KeptElectrode, KeptPlan, KeptPlanError, KeptRun};
pub use mold_params::MoldParams;
pub use project_file::{MeshReference, MovedMesh, ProjectFile, ProjectFileError};
pub use recent::RecentFiles;
pub use stage::{Fingerprint, Stage};
pub use toml_file::TomlFileError;
pub use user_folder::user_folder;
