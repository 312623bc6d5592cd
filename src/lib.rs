//! Sparkpath plans how an EDM electrode gets into a shrouded blisk and back out, proves that the motion
//! keeps the spark gap, and exports it.
//!
//! The floors of the house, lowest first; a module uses only those above it in this list:
//!
//! * [`geometry`]: meshes, frames, exact distances, the signed distance field, splines.
//! * [`mesh_io`]: mesh files to meshes and back.
//! * [`blisk`]: axis, channel, electrode, and a parametric blisk.
//! * [`feed`]: poses, search strategies, path and certificate.
//! * [`mold`]: cutters, what they leave uncut, and the electrodes for it.
//! * [`flank`]: ruled surfaces milled with the flank of a cutter.
//! * [`export`]: NC, CSV and reports.
//! * [`project`]: the document: parameters of a whole job, undo, files.
//! * [`render`]: scenes to pictures, without a window; uses [`geometry`] alone.
//! * [`views`]: what is shown of a job, as scenes.
//! * [`jobs`]: whole jobs as pure functions of their inputs, and the thread they run on.
//! * [`app`]: the window.
//! * [`cli`]: the command line.
//!
//! Lengths are millimetres and angles radians everywhere inside; degrees appear only at the edges, in names
//! that end in `_deg`.

pub mod app;
pub mod blisk;
pub mod cli;
pub mod export;
pub mod feed;
pub mod flank;
pub mod geometry;
pub mod jobs;
pub mod mesh_io;
pub mod mold;
pub mod project;
pub mod render;
pub mod views;
mod word_or_table;
