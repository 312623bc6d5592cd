//! The workspaces, each in a folder of its own, and what the window and all of them share: the trait
//! [`Workspace`](workspace::Workspace), commands as data, and the [`Context`](context::Context) through which a workspace
//! asks the window. [`registry`] is the one place that lists them.

pub mod blisk;
pub mod commands;
pub mod context;
pub mod flank;
pub mod hands;
pub mod message;
pub mod mold;
pub mod news;
pub mod opening;
pub mod preferences;
pub mod recent;
pub mod registry;
pub mod workspace;
