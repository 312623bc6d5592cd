//! Pictures of parts. A scene and a camera become an image on the GPU, or on its software stand-in;
//! no window is needed.
//!
//! A [`scene::Scene`] lists what is to be seen, a [`camera::Camera`] from where.
//! [`renderer::Renderer`] draws them into a texture of a device that somebody else owns (the window's);
//! [`offscreen::Offscreen`] owns a device and gives the picture itself. [`pick`] says what lies under a pixel,
//! on the CPU and exactly as drawn.
//!
//! Guarantees: the same scene, camera and size give the same bytes on the same driver; coordinates far from
//! the origin lose no digits, because f64 goes as far as the vectors between the camera and each body.

pub mod camera;
pub mod colour;
pub mod colour_map;
pub mod mesh;
pub mod offscreen;
pub mod pick;
pub mod renderer;
pub mod scene;
pub mod section;
pub mod view;
