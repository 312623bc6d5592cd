//! Studies: a command on many variants of a project, the points, and a table of what came out.
//!
//! A [`Study`](definition::Study) is a TOML file. It names a project, a command, the parameters to vary with their values, and
//! the results to collect. A [`StudyFolder`](folder::StudyFolder) holds all that belongs to one:
//!
//! ```text
//! study.toml           the study, with the values and the paths as seen from this folder
//! project.sparkpath    the project that is varied
//! Snakefile            the same points as a workflow of Snakemake, for many machines
//! points/000001/       a point: point.sparkpath, its project, and answer.json, which is written last
//! study.csv            the table
//! study.html           the table with plots
//! ```
//!
//! A study stands above the workspaces: the kind of its project tells which of them answers.

pub mod answer;
pub mod base;
pub mod definition;
pub mod evaluate;
pub mod folder;
mod pareto;
pub mod plots;
pub mod sampling;
pub mod table;
