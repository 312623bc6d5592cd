//! The window as its users meet it, driven without a screen by the names of its controls.
//!
//! Pictures are drawn by Mesa's software renderer (Debian: mesa-vulkan-drivers); `UPDATE_SNAPSHOTS=1` makes those in
//! `tests/snapshots` anew, which must then be looked at.

#[path = "window/burning.rs"]
mod burning_window;
mod common;
#[path = "window/desk.rs"]
mod desk;
#[path = "window/electrodes.rs"]
mod electrodes;
#[path = "window/exporting.rs"]
mod exporting;
#[path = "window/failures.rs"]
mod failures;
#[path = "window/faults.rs"]
mod faults;
#[path = "window/flank.rs"]
mod flank;
#[path = "window/fourth.rs"]
mod fourth;
#[path = "window/journey.rs"]
mod journey;
#[path = "window/keeping.rs"]
mod keeping;
#[path = "window/looks.rs"]
mod looks;
#[path = "window/machine.rs"]
mod machine;
#[path = "common/made_once.rs"]
mod made_once;
#[path = "window/mold.rs"]
mod mold;
#[path = "window/mold_documents.rs"]
mod mold_documents;
#[path = "window/recognition.rs"]
mod recognition;
#[path = "window/regions.rs"]
mod regions;
#[path = "window/releasing.rs"]
mod releasing;
#[path = "window/saving.rs"]
mod saving;
#[path = "window/study.rs"]
mod study;
#[path = "window/working.rs"]
mod working;
