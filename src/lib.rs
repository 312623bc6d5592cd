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
//! * [`study`]: a command on many variants of a project, and a table of what came out.
//! * [`reproduce`]: the papers' results beside ours.
//! * [`cli`]: the command line.
//!
//! Lengths are millimetres and angles radians everywhere inside; degrees appear only at the edges, in names that end in
//! `_deg`.

pub mod cli;
pub mod reproduce;
pub mod shell;
pub mod study;
pub mod widgets;
pub mod workspaces;

/// Text of a panic.
fn panic_text(panic: &(dyn std::any::Any + Send)) -> String {
    let text = panic.downcast_ref::<String>().cloned();
    text.or_else(|| panic.downcast_ref::<&str>().map(|s| (*s).to_owned())).unwrap_or_default()
}
