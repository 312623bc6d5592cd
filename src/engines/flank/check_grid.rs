//! The grid that a path is checked on. It hangs on the surface alone: the grid that a path is planned on may be as
//! coarse as its user likes, and what lies between its places would not be seen.

use super::FlankError;
use super::cutter::FlankCutter;
use super::deviation::{DesignGrid, Deviation, Feet};
use super::envelope::EnvelopeCheck;
use super::path::{Coverage, FlankPath};
use super::ruled_surface::RuledSurface;

/// Places of a surface for checks: evenly 100 x 50, and at least two along u on each piece of both guides.
#[derive(Debug, Clone)]
pub struct CheckGrid {
    /// The places.
    pub places: DesignGrid,
    /// Greatest distance between neighbouring places along u and along v (mm).
    pub spacing_mm: [f64; 2],
    /// u of its rulings.
    along: Vec<f64>,
    /// Whether they are spaced evenly.
    is_even: bool,
}

impl CheckGrid {
    /// Places along u, at least, and along v.
    pub const EVEN: [usize; 2] = [100, 50];

    /// The grid of a surface.
    pub fn new(surface: &RuledSurface) -> Self {
        let [even, across] = Self::EVEN;
        Self::along(surface, (surface.places_along(even), across), even)
    }

    /// A grid of `size` samples along u and v, for a preview.
    pub fn even(surface: &RuledSurface, size: [usize; 2]) -> Self {
        let along = (0..size[0]).map(|i| i as f64 / (size[0].max(2) - 1) as f64).collect();
        Self::along(surface, (along, size[1]), size[0])
    }

    fn along(surface: &RuledSurface, (along, across): (Vec<f64>, usize), even: usize) -> Self {
        let places = DesignGrid::along(surface, &along, across);
        let step = |u: [f64; 2], v: [f64; 2]| surface.point(u[0], v[0]).distance(surface.point(u[1], v[1]));
        // Chords between two rulings are longest at one of the guides, steps along a ruling are even.
        let of_pair = |w: &[f64]| [0.0, 1.0].map(|v| step([w[0], w[1]], [v, v]));
        let by_u = along.windows(2).flat_map(of_pair).fold(0.0, f64::max);
        let by_v = along.iter().map(|u| step([*u, *u], [0.0, 1.0])).fold(0.0, f64::max) / (across.max(2) - 1) as f64;
        let is_even = along.len() == even;
        Self { places, spacing_mm: [by_u, by_v], along, is_even }
    }

    /// Grid with the same rulings for the check of the whole tool all along the path, which takes its time at each
    /// place. Where rulings are many there are fewer places on each: the flutes are as straight as the rulings.
    pub fn for_whole_tool(&self, surface: &RuledSurface) -> DesignGrid {
        const USUAL: usize = 10_000;
        const LEAST: usize = 15;
        let [_, across] = self.places.size();
        let fewer = (USUAL / self.along.len().max(1)).max(LEAST);
        if fewer >= across { self.places.clone() } else { DesignGrid::along(surface, &self.along, fewer) }
    }

    /// Description of the grid in words.
    pub fn words(&self) -> String {
        let ([nu, nv], [by_u, by_v]) = (self.places.counted_size(), self.spacing_mm);
        format!("{nu} x {nv} samples, at most {by_u:.3} x {by_v:.3} mm apart")
    }

    /// Results of `path` over this grid. `touching` is the part that touches: the cutter above the path's `below_mm`.
    ///
    /// # Errors
    /// [`FlankError::Unmeasured`] if no place of the axis stands over some place.
    pub fn checked(&self, path: &FlankPath, touching: &FlankCutter) -> Result<CheckedPath, FlankError> {
        let (words, along) = (self.words(), self.along.clone());
        // Most plans are made on the same places.
        let ((deviation, feet), coverage, envelope) = if self.is_even && path.deviation.grid == self.places.size() {
            ((path.deviation.clone(), path.feet.clone()), path.coverage, path.envelope.clone())
        } else {
            path.over(&self.places, touching)?
        };
        Ok(CheckedPath { words, deviation, feet, coverage, envelope, along })
    }
}

/// Results of a path over a grid for checks.
#[derive(Debug, Clone, PartialEq)]
pub struct CheckedPath {
    /// The grid, in words.
    pub words: String,
    /// Deviation of the standing cutter.
    pub deviation: Deviation,
    /// Foot points of the axis over the samples of the grid.
    pub feet: Feet,
    /// Coverage of the surface.
    pub coverage: Coverage,
    /// Deviation of the moving cutter.
    pub envelope: EnvelopeCheck,
    /// u of the grid's rulings.
    along: Vec<f64>,
}

impl CheckedPath {
    /// u and v of the place with this number.
    pub fn place(&self, number: usize) -> [f64; 2] {
        let across = self.deviation.grid[1].max(1);
        let u = self.along.get(number / across).copied().unwrap_or(1.0);
        [u, (number % across) as f64 / (across.max(2) - 1) as f64]
    }
}
