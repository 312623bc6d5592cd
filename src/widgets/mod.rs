//! Parts of the window that every workspace uses.

pub mod camera;
pub mod colours;
pub mod folds;
pub mod panel_parts;
pub mod pictures;
pub mod theme;
pub mod viewport_gpu;
