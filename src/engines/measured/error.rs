//! Reasons why a scan cannot be read, fitted or judged.

use geometry::exact::ExactMeshError;
use import::ImportError;
use task::Cancelled;

/// Reason why a scan cannot be read, fitted or judged: what is wrong, where, and the remedy.
#[derive(Debug, thiserror::Error)]
pub enum MeasuredError {
    /// The file cannot be read, or is a mesh file that cannot.
    #[error(transparent)]
    Import(#[from] ImportError),
    /// The content is of no format that can be read.
    #[error("{file}: {found}; expected points as STL, OBJ, PLY, XYZ or CSV: export the scan again as one of these")]
    UnknownFormat {
        /// Path as given.
        file: String,
        /// Apparent content.
        found: String,
    },
    /// The content breaks the rules of its format.
    #[error("{file}: {place}: {problem}; {remedy}")]
    Malformed {
        /// Path as given.
        file: String,
        /// Line or vertex.
        place: String,
        /// Problem found there.
        problem: String,
        /// Remedy.
        remedy: &'static str,
    },
    /// The file holds more points than allowed.
    #[error("{file}: {found} points exceed the limit of {limit}; thin out the scan or raise `max_points`")]
    TooManyPoints {
        /// Path as given.
        file: String,
        /// Number of points, as far as they were counted.
        found: u64,
        /// Number that is allowed.
        limit: u64,
    },
    /// The file is sound but has no point.
    #[error("{file}: holds no points; export the scan again")]
    NoPoints {
        /// Path as given.
        file: String,
    },
    /// The nominal mesh cannot be searched.
    #[error("nominal surface: {0}; give a mesh with triangles")]
    Nominal(#[from] ExactMeshError),
    /// There are fewer points than a fit needs.
    #[error(
        "the scan has {found} points that count, the fit needs at least {needed}; give more points, a longer reach, or free \
         fewer axes"
    )]
    TooFewPoints {
        /// Number of points.
        found: usize,
        /// Number that is needed.
        needed: usize,
    },
    /// A point that is not a place.
    #[error("point {number} of the scan is not finite; remove it")]
    NotFinite {
        /// Number of the point, from 1.
        number: usize,
    },
    /// A setting that makes no sense.
    #[error("{name} is {value}; {rule}")]
    BadSetting {
        /// Name of the setting.
        name: &'static str,
        /// Value of the setting.
        value: String,
        /// What is possible.
        rule: &'static str,
    },
    /// The equations of the fit have no solution.
    #[error("the fit does not converge: {problem}; align the scan roughly with the nominal surface first")]
    NoFit {
        /// Reason.
        problem: &'static str,
    },
    /// Cancelled.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}
