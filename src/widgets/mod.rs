//! Parts of the window that every workspace uses.

pub mod camera;
pub mod form;
pub mod overlay;
pub mod panel_parts;
pub mod plot_parts;
pub mod solids;
pub mod theme;
pub mod timeline;
pub mod viewport;
pub mod viewport_gpu;
