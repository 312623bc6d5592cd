//! Finished parts that were scanned: points of the scan, their best fit to the nominal surface, deviations, verdict.
//!
//! [`points::read_points`] reads the points of a scan. [`fit::best_fit`] finds the rigid motion that brings them onto the
//! [`Nominal`] surface, over all six freedoms or only those that a machine can correct, and names the directions that
//! the surface does not determine. [`deviation::deviations`] answers the signed distance of every point after that, with
//! statistics, the worst places and a verdict against a tolerance, also surface by surface. [`table`] writes them.
//!
//! Lengths are in mm, angles in radians. Distances are positive outside of the metal. Motions lead from the axes of the
//! scan to those of the nominal mesh. No result depends on the number of threads.
//!
//! The caller names the surfaces: a closure labels each deviation, most simply by the triangle that is nearest.
//!
//! ```
//! use std::sync::Arc;
//!
//! use geometry::mesh::Mesh;
//! use glam::DVec3;
//! use measured::Nominal;
//! use measured::deviation::{Tolerance, deviations};
//! use measured::fit::{FitSettings, best_fit};
//! use task::Task;
//!
//! let task = Task::default();
//! let nominal = Nominal::new(Arc::new(Mesh::cuboid(DVec3::new(40.0, 30.0, 20.0))), &task)?;
//! // A scan of three faces, 0.1 mm off along X.
//! let grid = (0..400).map(|i| (f64::from(i % 20) + 0.5, f64::from(i / 20) * 0.5 + 2.0));
//! let scan: Vec<DVec3> = grid
//!     .flat_map(|(u, v)| [DVec3::new(u, v, 20.0), DVec3::new(u, 0.0, v), DVec3::new(0.0, u, v)])
//!     .map(|p| p + DVec3::X * 0.1)
//!     .collect();
//! let fit = best_fit(&nominal, &scan, &FitSettings::default(), &task)?;
//! assert!((fit.motion.translation + DVec3::X * 0.1).length() < 1e-5 && fit.undetermined.is_empty());
//!
//! let map = deviations(&nominal, &scan, &fit.motion, &task)?;
//! let tolerance = Tolerance::symmetric(0.02)?;
//! // Two triangles make a face of the box.
//! let faces = map.statistics_by(&tolerance, |deviation| deviation.triangle / 2);
//! assert_eq!(faces.len(), 3);
//! assert!(map.verdict(&tolerance).is_within);
//! # Ok::<(), measured::MeasuredError>(())
//! ```

pub mod deviation;
mod error;
pub mod fit;
mod nominal;
pub mod points;
pub mod table;
#[cfg(test)]
mod tests;

pub use error::MeasuredError;
pub use nominal::Nominal;
