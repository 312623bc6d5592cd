//! Rounding of poses to the decimals that files carry.
//!
//! A path is rounded once, before it is verified. Text made from a rounded value and read back gives the same bits, so
//! the motion in a file is exactly the motion that was proven.

use crate::path::{FeedPath, PathRow};
use crate::pose::Pose;

/// Decimals of lengths (mm) in files: steps of 0.01 micrometre.
pub const MM_DECIMALS: usize = 5;
/// Decimals of angles (degrees) in files: at a radius of 200 mm a step is 0.0035 micrometre.
pub const DEG_DECIMALS: usize = 6;

/// `value` (mm) to the nearest step of [`MM_DECIMALS`]; never negative zero.
pub fn quantise_mm(value: f64) -> f64 {
    to_decimals(value, MM_DECIMALS)
}

/// `angle` (rad) to the nearest angle that is a whole number of steps of [`DEG_DECIMALS`] in degrees.
pub fn quantise_rad(angle: f64) -> f64 {
    to_decimals(angle.to_degrees(), DEG_DECIMALS).to_radians()
}

/// The pose that files carry for `pose`.
pub fn quantise(pose: &Pose) -> Pose {
    Pose {
        x: quantise_mm(pose.x),
        y: quantise_mm(pose.y),
        z: quantise_mm(pose.z),
        a: quantise_rad(pose.a),
        b: quantise_rad(pose.b),
        c: quantise_rad(pose.c),
    }
}

/// The path that files carry for `path`: every row's pose and `s` rounded. Verify this one.
pub fn quantise_path(path: &FeedPath) -> FeedPath {
    let row = |r: &PathRow| PathRow { node: r.node, s: quantise_mm(r.s), pose: quantise(&r.pose) };
    FeedPath { rows: path.rows.iter().map(row).collect(), ..path.clone() }
}

/// Index of the first row that [`quantise_path`] would change, or that is not finite.
pub fn first_unquantised_row(path: &FeedPath) -> Option<usize> {
    let same = |r: &PathRow| {
        let values = |s: f64, p: &Pose| std::iter::once(s).chain(p.to_array()).map(f64::to_bits).collect::<Vec<_>>();
        r.pose.to_array().iter().all(|v| v.is_finite())
            && r.s.is_finite()
            && values(r.s, &r.pose) == values(quantise_mm(r.s), &quantise(&r.pose))
    };
    path.rows.iter().position(|r| !same(r))
}

/// Text of a length (mm) with `decimals` decimals.
pub fn mm_text(value: f64, decimals: usize) -> String {
    format!("{value:.decimals$}")
}

/// Text in degrees of an angle (rad) with `decimals` decimals.
pub fn deg_text(angle: f64, decimals: usize) -> String {
    // First to the step of the files: what lies below it is the error of the conversion to radians.
    format!("{:.decimals$}", to_decimals(angle.to_degrees(), DEG_DECIMALS))
}

/// `value` rounded down to [`MM_DECIMALS`], for proven clearances, which rounding must not increase.
pub fn floor_mm_text(value: f64) -> String {
    let step = 10f64.powi(MM_DECIMALS as i32);
    // A value that is a step to within its own rounding error stays that step.
    let floored = (value * step * (1.0 + 4.0 * f64::EPSILON)).floor() / step + 0.0;
    mm_text(floored, MM_DECIMALS)
}

fn to_decimals(value: f64, decimals: usize) -> f64 {
    let step = 10f64.powi(decimals as i32);
    // Dividing two integers rounds once, as reading the decimal text does; `+ 0.0` turns -0 into 0.
    (value * step).round() / step + 0.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn text_of_a_rounded_value_reads_back_bit_for_bit(mm in -2000.0..2000.0f64, rad in -7.0..7.0f64) {
            let (mm_q, rad_q) = (quantise_mm(mm), quantise_rad(rad));
            let mm_back: f64 = mm_text(mm_q, MM_DECIMALS).parse().unwrap();
            let deg_back: f64 = deg_text(rad_q, DEG_DECIMALS).parse().unwrap();
            prop_assert_eq!(mm_back.to_bits(), mm_q.to_bits());
            prop_assert_eq!(deg_back.to_radians().to_bits(), rad_q.to_bits());
            prop_assert!((mm - mm_q).abs() <= 0.500001e-5);
            prop_assert!((rad - rad_q).to_degrees().abs() <= 0.500001e-6);
            prop_assert_eq!(quantise_mm(mm_q).to_bits(), mm_q.to_bits());
            prop_assert_eq!(quantise_rad(rad_q).to_bits(), rad_q.to_bits());
        }

        #[test]
        fn a_floored_clearance_never_exceeds_the_true_one(c in 0.0..50.0f64) {
            let floored: f64 = floor_mm_text(c).parse().unwrap();
            prop_assert!(floored <= c * (1.0 + 1e-14) && c - floored < 1.01e-5);
        }
    }

    #[test]
    fn a_tiny_negative_value_is_written_without_a_sign() {
        assert_eq!(mm_text(quantise_mm(-1e-9), MM_DECIMALS), "0.00000");
        assert_eq!(deg_text(-1e-12, DEG_DECIMALS), "0.000000");
        assert_eq!(floor_mm_text(0.1), "0.10000");
    }
}
