//! Which motions the surface determines: a generalised eigenvalue problem, and the names of the directions that it
//! leaves open.

use std::fmt;

use glam::{DMat3, DVec3};
use nalgebra::{Cholesky, DMatrix, SymmetricEigen};

use super::sums::Sums;

/// Least share of the square of a displacement that must lie along the normals, for a motion to be determined.
const LEAST_SHARE: f64 = 1e-3;

/// How many times the share that facets alone would feign a motion must have to be determined.
const FACETS: f64 = 3.0;

/// Most steps of the eigenvalue iteration.
const MOST_STEPS: usize = 1000;

/// A direction of motion that the measured surface does not determine: the part may move along it, and the distances of
/// the points stay as they are.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Undetermined {
    /// A translation.
    Translation {
        /// Unit vector, in the axes of the nominal mesh.
        direction: DVec3,
        /// Share of the square of the points' displacement that lies along the normals.
        share: f64,
    },
    /// A rotation, or a screw motion.
    Rotation {
        /// Point of the axis next to the middle of the scan (mm), in the axes of the nominal mesh.
        point: DVec3,
        /// Unit vector of the axis.
        direction: DVec3,
        /// Translation along the axis for a unit of rotation (mm/rad); 0 for a mere rotation.
        pitch: f64,
        /// Share of the square of the points' displacement that lies along the normals.
        share: f64,
    },
}

impl fmt::Display for Undetermined {
    /// In plain words: `translation along Z`, `rotation about the axis along Z through (0.000, 0.000, 0.000) mm`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Translation { direction, .. } => write!(f, "translation along {}", words(*direction)),
            Self::Rotation { point: p, direction, pitch, .. } => {
                let about = words(*direction);
                write!(f, "rotation about the axis along {about} through ({:.3}, {:.3}, {:.3}) mm", p.x, p.y, p.z)?;
                if *pitch == 0.0 { Ok(()) } else { write!(f, " with {pitch:.3} mm/rad along it") }
            }
        }
    }
}

/// A direction: the letter of an axis within half a degree of it, else its components.
fn words(direction: DVec3) -> String {
    const NEAR: f64 = 0.999_96;
    let axes = [("X", DVec3::X), ("Y", DVec3::Y), ("Z", DVec3::Z)];
    match axes.iter().find(|(_, axis)| direction.dot(*axis).abs() > NEAR) {
        Some((letter, _)) => (*letter).to_owned(),
        None => format!("({:.4}, {:.4}, {:.4})", direction.x, direction.y, direction.z),
    }
}

/// The motions that are determined and those that are not, as columns of changes of the free values. Each displaces the
/// points by 1 mm rms, and all are orthogonal in that measure.
pub(super) struct Split {
    /// What the surface determines.
    pub determined: DMatrix<f64>,
    /// What the surface leaves open.
    pub open: DMatrix<f64>,
}

/// Splits the motions of which `twists` are the columns.
///
/// For a motion with twist t the ratio of t' N t to t' E t, N the normal matrix and E the energy, is the share of the
/// square of the points' displacement that lies along the normals. The eigenvectors of this pencil are the motions that
/// are determined best and least. Both are in mm^2, so the shares depend on no unit, no size and no frame. A surface of
/// facets feigns a share, as a prism does a turn of the cylinder that it stands for; so the share must exceed that, too.
///
/// No answer for sums that are not finite.
pub(super) fn split(sums: &Sums, twists: &DMatrix<f64>) -> Option<Split> {
    let count = twists.ncols();
    let energy = energy(sums, twists);
    // What displaces no point is given a little energy, and so no share.
    let little = 1e-9 * energy.trace().max(f64::MIN_POSITIVE) / count as f64;
    let root = Cholesky::new(&energy + DMatrix::identity(count, count) * little)?;
    let inverse = root.l().try_inverse()?;
    let normal = twists.transpose() * sums.normal * twists / sums.weight;
    let pencil = &inverse * normal * inverse.transpose();
    let eigen = SymmetricEigen::try_new((&pencil + pencil.transpose()) * 0.5, f64::EPSILON, MOST_STEPS)?;
    let least = LEAST_SHARE.max(FACETS * sums.facets);
    let motions = inverse.transpose() * &eigen.eigenvectors;
    let chosen = |wanted: bool| {
        let columns: Vec<usize> = (0..count).filter(|&k| (eigen.eigenvalues[k] > least) == wanted).collect();
        motions.select_columns(&columns)
    };
    Some(Split { determined: chosen(true), open: chosen(false) })
}

/// Mean square of the points' displacement, per motion (mm^2).
pub(super) fn energy(sums: &Sums, twists: &DMatrix<f64>) -> DMatrix<f64> {
    twists.transpose() * sums.energy * twists / sums.weight
}

/// Names the motions that `open` spans. Pure translations come first; then rotations, along the axes of the mesh as far
/// as the span allows. `centre` is the point whose velocity the twists give.
pub(super) fn named(open: &DMatrix<f64>, twists: &DMatrix<f64>, sums: &Sums, centre: DVec3) -> Vec<Undetermined> {
    let count = open.ncols();
    if count == 0 {
        return Vec::new();
    }
    let all = twists * open;
    let turns = all.rows(0, 3).into_owned();
    let shifts = all.rows(3, 3).into_owned();
    // Rms distance of the points from their centre.
    let spread = (0.5 * (0..3).map(|i| sums.energy[(i, i)]).sum::<f64>() / sums.weight).sqrt();
    let Some(eigen) = SymmetricEigen::try_new(turns.transpose() * &turns, f64::EPSILON, MOST_STEPS) else {
        return Vec::new();
    };
    // Less than a tenth of the displacement by rotation makes no rotation.
    let is_turn = |k: &usize| eigen.eigenvalues[*k] * spread * spread > 0.01;
    let (turning, shifting): (Vec<usize>, Vec<usize>) = (0..count).partition(is_turn);
    let combinations = |chosen: &[usize]| eigen.eigenvectors.select_columns(chosen);
    let translations = basis(&(&shifts * combinations(&shifting)));
    let share = |turn: DVec3, shift: DVec3| {
        let twist = nalgebra::Vector6::new(turn.x, turn.y, turn.z, shift.x, shift.y, shift.z);
        let (seen, whole) = (twist.dot(&(sums.normal * twist)), twist.dot(&(sums.energy * twist)));
        if whole > 0.0 { seen / whole } else { 0.0 }
    };
    let mut found: Vec<Undetermined> = translations
        .iter()
        .map(|&direction| Undetermined::Translation { direction, share: share(DVec3::ZERO, direction) })
        .collect();
    let coefficients = combinations(&turning);
    for direction in basis(&(&turns * &coefficients)) {
        // The combination that turns about this direction at unit speed.
        let wanted = (&turns * &coefficients).transpose() * nalgebra::Vector3::from(direction.to_array());
        let scaled = wanted.component_div(&nalgebra::DVector::from_iterator(
            turning.len(),
            turning.iter().map(|&k| eigen.eigenvalues[k]),
        ));
        let shift = &shifts * &coefficients * scaled;
        let mut shift = DVec3::new(shift[0], shift[1], shift[2]);
        for translation in &translations {
            shift -= *translation * translation.dot(shift);
        }
        let pitch = direction.dot(shift);
        let pitch = if pitch.abs() > 1e-3 * spread { pitch } else { 0.0 };
        let point = centre + direction.cross(shift);
        found.push(Undetermined::Rotation { point, direction, pitch, share: share(direction, shift) });
    }
    found
}

/// Orthogonal unit vectors that span the columns of a matrix of three rows: as near to X, Y and Z as the span allows.
fn basis(columns: &DMatrix<f64>) -> Vec<DVec3> {
    const SMALL: f64 = 0.01;
    let square = columns * columns.transpose();
    let Some(eigen) = SymmetricEigen::try_new(square, f64::EPSILON, MOST_STEPS) else { return Vec::new() };
    let greatest = eigen.eigenvalues.iter().copied().fold(0.0, f64::max);
    let spanning: Vec<usize> = (0..3).filter(|&k| greatest > 0.0 && eigen.eigenvalues[k] > SMALL * greatest).collect();
    let mut projector = spanning.iter().fold(DMat3::ZERO, |sum, &k| {
        let v = DVec3::new(eigen.eigenvectors[(0, k)], eigen.eigenvectors[(1, k)], eigen.eigenvectors[(2, k)]);
        sum + DMat3::from_cols(v * v.x, v * v.y, v * v.z)
    });
    let mut found = Vec::new();
    for _ in 0..spanning.len() {
        let shadows = [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| projector * axis);
        // Of axes that lie equally near, to rounding, the first.
        let best = shadows.iter().fold(shadows[0], |best, s| if s.length() > best.length() + 1e-6 { *s } else { best });
        let direction = best.normalize_or_zero();
        projector -= DMat3::from_cols(direction * direction.x, direction * direction.y, direction * direction.z);
        found.push(direction);
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_are_told_in_words() {
        let turn = Undetermined::Rotation { point: DVec3::X, direction: DVec3::NEG_Z, pitch: 0.0, share: 0.0 };
        assert_eq!(turn.to_string(), "rotation about the axis along Z through (1.000, 0.000, 0.000) mm");
        let screw = Undetermined::Rotation { point: DVec3::X, direction: DVec3::Z, pitch: 2.0, share: 0.0 };
        assert!(screw.to_string().ends_with("with 2.000 mm/rad along it"), "{screw}");
        let shift = Undetermined::Translation { direction: DVec3::new(0.6, 0.8, 0.0), share: 0.0 };
        assert_eq!(shift.to_string(), "translation along (0.6000, 0.8000, 0.0000)");
    }

    #[test]
    fn a_span_is_told_by_the_axes_next_to_it() {
        let columns = DMatrix::from_column_slice(3, 2, &[1.0, 1.0, 0.0, 1.0, -1.0, 0.0]);
        let found = basis(&columns);
        assert!(found.len() == 2 && found[0].abs_diff_eq(DVec3::X, 1e-12) && found[1].abs_diff_eq(DVec3::Y, 1e-12));
        let askew = basis(&DMatrix::from_column_slice(3, 1, &[-0.3, -0.8, 0.1]));
        assert!(askew.len() == 1 && askew[0].y > 0.0);
        assert!(basis(&DMatrix::zeros(3, 0)).is_empty());
    }
}
