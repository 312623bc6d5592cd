//! Meshes, frames and distances. Knows no file and no electrode.

pub mod bvh;
pub mod circle;
pub mod distance_field;
pub mod envelope;
pub mod exact;
#[cfg(any(test, feature = "fixtures"))]
pub mod fixtures;
pub mod frame;
pub mod groups;
pub mod inside;
pub mod mesh;
pub mod minkowski;
pub mod nearest_pair;
pub mod nurbs;
pub mod offset;
pub mod patch;
pub mod raycast;
pub mod segmentation;
pub mod shells;
pub mod smoothing;
pub mod solid;
pub mod spline;
pub mod swept;
pub mod triangle_distance;
pub mod weld;
