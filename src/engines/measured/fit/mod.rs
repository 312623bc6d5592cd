//! Best fit of the points of a scan to the nominal surface.
//!
//! The method is Gauss-Newton on the exact distances of the points from the surface (point to surface; Y. Chen and G.
//! Medioni, Object modelling by registration of multiple range images, Image and Vision Computing 10, 1992; H. Pottmann
//! et al., Geometry and convergence analysis of algorithms for registration of 3D shapes, IJCV 67, 2006).
//!
//! Stray points count little. The weight of a point is that of P. J. Huber (Robust estimation of a location parameter,
//! 1964): 1 up to 1.345 standard deviations, beyond that 1.345 standard deviations over its distance. The standard
//! deviation is 1.4826 times the median of the distances, of the same iteration. Unlike weights that fall to zero, these
//! let a face with few points count that is still far off. A stray point pulls no more than a point at 1.345 standard
//! deviations. What is beside the part altogether, such as a clamp, is best left out by its distance
//! ([`FitSettings::reach_mm`]): many points of one face of it could be taken for a face of the part.
//!
//! The fit goes in two passes. The first moves along all that the surface determines with all points. Where it ends the
//! weights tell what the surface determines without stray points. The second pass takes the motion along all others
//! back and fits what is left; so the values of an undetermined direction are exactly zero.

mod determined;
mod freedoms;
mod sums;

use std::borrow::Cow;

use glam::{DAffine3, DVec3};
use nalgebra::{Cholesky, DMatrix, DVector};
use task::Task;

pub use determined::Undetermined;
pub use freedoms::{Freedom, Freedoms};

use crate::{MeasuredError, Nominal};
use sums::{Near, Sums};

/// Distance in standard deviations up to which a point counts in full (Huber: 95 % efficiency for normal noise).
const FULL_WEIGHT: f64 = 1.345;
/// Least standard deviation of a scan (mm): a tenth of a micrometre.
const LEAST_SCALE: f64 = 1e-4;
/// Rms displacement of the points in one iteration with which the fit has converged (mm).
const CONVERGED: f64 = 1e-6;
/// Greatest rms displacement of the points in one iteration, as a share of their rms distance from their centre.
const LONGEST_STEP: f64 = 0.2;

/// Settings of a best fit.
#[derive(Debug, Clone, PartialEq)]
pub struct FitSettings {
    /// Freedoms of the points.
    pub freedoms: Freedoms,
    /// Distance from the nominal surface, before the fit, beyond which points do not count (mm): what the scanner saw of
    /// a fixture. Infinite if all count.
    pub reach_mm: f64,
    /// Most iterations, of both passes together.
    pub most_iterations: u32,
}

impl Default for FitSettings {
    /// All six freedoms, all points, 100 iterations.
    fn default() -> Self {
        Self { freedoms: Freedoms::all(), reach_mm: f64::INFINITY, most_iterations: 100 }
    }
}

/// The value of one freedom.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FittedValue {
    /// The freedom.
    pub freedom: Freedom,
    /// Value of the freedom (mm or rad).
    pub value: f64,
    /// Standard deviation of the value (mm or rad), from the scatter of the points after the fit, as if the errors of
    /// the points were independent; neighbouring points of a scanner are not, so the true one is greater. Undetermined
    /// directions have no part in it.
    pub standard_deviation: f64,
}

/// Best fit of a scan to the nominal surface.
#[derive(Debug, Clone, PartialEq)]
pub struct BestFit {
    /// The rigid motion that brings the points onto the nominal surface: from the axes of the scan to those of the
    /// nominal mesh (mm).
    pub motion: DAffine3,
    /// Values of the free axes, in the frame of the freedoms.
    pub values: Vec<FittedValue>,
    /// Number of points beyond the reach, which did not count.
    pub beyond_reach: usize,
    /// Root mean square of the distances of the points within reach after the fit (mm), stray points included.
    pub rms_mm: f64,
    /// Standard deviation of the points without stray ones (mm): 1.4826 times the median of their distances.
    pub scale_mm: f64,
    /// Number of iterations.
    pub iterations: u32,
    /// Whether the last iteration moved the points by less than a nanometre rms.
    pub has_converged: bool,
    /// Directions that the surface does not determine; the motion has no part of them.
    pub undetermined: Vec<Undetermined>,
}

/// Fits `points` (mm, in the axes of the scan) to the nominal surface.
///
/// Each point goes to the surface that is nearest, so the scan must lie roughly aligned from the start: off by less than
/// half of the thinnest wall or narrowest channel. Memory is about 200 bytes a point. Every point counts alike: a scan
/// that is denser somewhere has more weight there.
///
/// # Errors
/// [`MeasuredError::TooFewPoints`], [`MeasuredError::NotFinite`], [`MeasuredError::NoFit`] and
/// [`MeasuredError::Cancelled`].
pub fn best_fit(
    nominal: &Nominal,
    points: &[DVec3],
    settings: &FitSettings,
    task: &Task,
) -> Result<BestFit, MeasuredError> {
    if settings.reach_mm.is_nan() || settings.reach_mm <= 0.0 {
        let rule = "give a positive distance in mm";
        return Err(MeasuredError::BadSetting { name: "reach_mm", value: settings.reach_mm.to_string(), rule });
    }
    if let Some(i) = points.iter().position(|p| !p.is_finite()) {
        return Err(MeasuredError::NotFinite { number: i + 1 });
    }
    let within = within_reach(nominal, points, settings.reach_mm, task)?;
    let count = settings.freedoms.list().len();
    let needed = count + 1;
    if within.len() < needed {
        return Err(MeasuredError::TooFewPoints { found: within.len(), needed });
    }
    let beyond_reach = points.len() - within.len();
    let fit = Fit { nominal, points: &within, settings, task, values: DVector::zeros(count), iterations: 0 };
    Ok(BestFit { beyond_reach, ..fit.run()? })
}

/// The points within `reach_mm` of the nominal surface.
fn within_reach<'a>(
    nominal: &Nominal,
    points: &'a [DVec3],
    reach_mm: f64,
    task: &Task,
) -> Result<Cow<'a, [DVec3]>, MeasuredError> {
    if reach_mm == f64::INFINITY {
        return Ok(Cow::Borrowed(points));
    }
    let near = sums::nearest_of_all(nominal, points, &DAffine3::IDENTITY, task)?;
    let within = near.iter().filter(|n| n.distance <= reach_mm).map(|n| n.point);
    Ok(Cow::Owned(within.collect()))
}

/// A fit under way.
struct Fit<'a> {
    nominal: &'a Nominal,
    points: &'a [DVec3],
    settings: &'a FitSettings,
    task: &'a Task,
    values: DVector<f64>,
    iterations: u32,
}

/// The points at the present values, and what follows from them.
struct Here {
    near: Vec<Near>,
    centre: DVec3,
    twists: DMatrix<f64>,
    scale: f64,
    sums: Sums,
}

impl Fit<'_> {
    fn run(mut self) -> Result<BestFit, MeasuredError> {
        let mut here = self.here()?;
        // All points count for what the surface determines: few of a face that is still far off must not be lost.
        while self.iterations < self.settings.most_iterations {
            let all = Sums::of(&here.near, here.centre, self.nominal, |_| 1.0);
            let along = determined::split(&all, &here.twists).ok_or(UNBOUNDED)?.determined;
            let moved = self.step(&here, &along)?;
            here = self.here()?;
            if moved < CONVERGED {
                break;
            }
        }
        let split = determined::split(&here.sums, &here.twists).ok_or(UNBOUNDED)?;
        let undetermined = determined::named(&split.open, &here.twists, &here.sums, here.centre);
        let along = split.determined;
        if !undetermined.is_empty() {
            // The motions are orthonormal in the measure of the displacement.
            let energy = determined::energy(&here.sums, &here.twists);
            self.values = &along * (along.transpose() * energy * &self.values);
            here = self.here()?;
        }
        let mut has_converged = false;
        while self.iterations < self.settings.most_iterations && !has_converged {
            has_converged = self.step(&here, &along)? < CONVERGED;
            here = self.here()?;
        }
        self.task.report("best fit", 1.0, "");
        let deviations = self.standard_deviations(&here, &along)?;
        let values = self.settings.freedoms.list().iter().zip(self.values.iter().zip(deviations.iter()));
        let values =
            values.map(|(&freedom, (&value, &standard_deviation))| FittedValue { freedom, value, standard_deviation });
        let squares: f64 = here.near.iter().map(|n| n.distance * n.distance).sum();
        Ok(BestFit {
            motion: self.settings.freedoms.motion(&self.values),
            values: values.collect(),
            beyond_reach: 0,
            rms_mm: (squares / here.near.len() as f64).sqrt(),
            scale_mm: here.scale,
            iterations: self.iterations,
            has_converged,
            undetermined,
        })
    }

    fn here(&self) -> Result<Here, MeasuredError> {
        let done = f64::from(self.iterations) / f64::from(self.settings.most_iterations.max(1));
        self.task.report("best fit", done, &format!("iteration {}", self.iterations + 1));
        let motion = self.settings.freedoms.motion(&self.values);
        let near = sums::nearest_of_all(self.nominal, self.points, &motion, self.task)?;
        self.task.check()?;
        let centre = sums::centre_of(&near);
        let twists = self.settings.freedoms.twists(&self.values, centre);
        let scale = sums::scale_of(&near);
        let full = FULL_WEIGHT * scale.max(LEAST_SCALE);
        let sums = Sums::of(&near, centre, self.nominal, |distance| full / distance.max(full));
        Ok(Here { near, centre, twists, scale, sums })
    }

    /// Step of Gauss-Newton along the columns of `along`; answers the rms displacement of the points (mm).
    fn step(&mut self, here: &Here, along: &DMatrix<f64>) -> Result<f64, MeasuredError> {
        self.iterations += 1;
        if along.ncols() == 0 {
            return Ok(0.0);
        }
        let twists = &here.twists * along;
        let right = twists.transpose() * here.sums.right;
        let normal = twists.transpose() * here.sums.normal * &twists;
        let mut step = along * Cholesky::new(normal).ok_or(UNBOUNDED)?.solve(&right);
        let energy = determined::energy(&here.sums, &here.twists);
        let mut moved = step.dot(&(energy * &step)).max(0.0).sqrt();
        if !moved.is_finite() {
            return Err(UNBOUNDED);
        }
        let longest = LONGEST_STEP * (here.sums.energy.fixed_view::<3, 3>(0, 0).trace() / here.sums.weight).sqrt();
        if moved > longest {
            step *= longest / moved;
            moved = longest;
        }
        self.values += step;
        Ok(moved)
    }

    /// Standard deviations of the free values.
    fn standard_deviations(&self, here: &Here, along: &DMatrix<f64>) -> Result<DVector<f64>, MeasuredError> {
        let count = self.values.len();
        if along.ncols() == 0 {
            return Ok(DVector::zeros(count));
        }
        let twists = &here.twists * along;
        let normal = twists.transpose() * here.sums.normal * &twists;
        let inverse = Cholesky::new(normal).ok_or(UNBOUNDED)?.inverse();
        let left = (here.sums.weight - along.ncols() as f64).max(1.0);
        let covariance = along * inverse * along.transpose() * (here.sums.squares / left);
        Ok(DVector::from_iterator(count, (0..count).map(|k| covariance[(k, k)].max(0.0).sqrt())))
    }
}

/// The normal equations are not finite or not positive.
const UNBOUNDED: MeasuredError = MeasuredError::NoFit { problem: "its equations have no solution" };
