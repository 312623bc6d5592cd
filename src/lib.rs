//! Sparkpath plans how an EDM electrode gets into a shrouded blisk and back out, proves that the motion keeps the spark
//! gap, and exports it; finds what milling cutters leave uncut in a mold and makes the electrodes for it; and plans how
//! ruled flanks are milled.
//!
//! The engines are crates of their own under `src/engines`: [`task`], [`files`], [`geometry`], [`import`], [`wheel`],
//! [`feed`], [`mold`], [`flank`], [`nc`] and [`render`]. None of them knows a window, a document or a job. This crate
//! is the program on top of them:
//!
//! * [`workspaces`]: blisk, mold and flank, each with its document, jobs, reports, scenes and panels.
//! * [`widgets`]: parts of the window that every workspace uses.
//! * [`shell`]: the frame of the window.
//! * [`reproduce`]: the papers' results beside ours.
//! * [`cli`]: the command line.
//!
//! Lengths are millimetres and angles radians everywhere inside; degrees appear only at the edges, in names that end in
//! `_deg`.

pub mod cli;
pub mod reproduce;
pub mod shell;
pub mod widgets;
pub mod workspaces;
