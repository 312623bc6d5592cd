//! Default formulas of die-sinking EDM, for tables that lack a figure.
//!
//! | rule | valid for | basis |
//! | --- | --- | --- |
//! | [`side_gap_mm`] | steel, through-flushing, the steps of [`STEPS`] | fitted, standard deviation 8 to 9 % |
//! | [`undersize_mm`], [`roughing_current_a`] | steel, 10 to 10,000 mm² | fitted, the same deviation |
//! | [`removal_ceiling_mm3_min`] | any metal whose melting point is known | textbook |
//! | [`removal_rate_mm3_min`] | the same | assumed share of the ceiling |
//! | [`stock_for_next_mm`] | steps with known side gaps | assumed |
//! | [`area_factor`] | as the roughing current | assumed |
//! | [`vdi_of_ra`], [`ra_of_vdi`] | all | definition (VDI 3400) |
//!
//! The fits are of public generator tables. No rule is evaluated outside the range for which it was fitted: the answer is
//! then [`BurningError::OutsideRule`]. Spark gaps and wear in nickel and titanium have no public source, so there is no
//! rule for them.

use crate::BurningError;

/// A step of the default technologies: one current and one pulse duration.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DefaultStep {
    /// Name: R is roughing, S is semi-finishing, F is finishing; a greater number is rougher.
    pub name: &'static str,
    /// Peak current (A).
    pub current_a: f64,
    /// Pulse duration (µs).
    pub pulse_us: f64,
}

const fn step(name: &'static str, current_a: f64, pulse_us: f64) -> DefaultStep {
    DefaultStep { name, current_a, pulse_us }
}

/// The steps of the default technologies, from rough to fine (A, µs).
pub const STEPS: [DefaultStep; 9] = [
    step("R3", 80.0, 136.0),
    step("R2", 40.0, 136.0),
    step("R1", 27.0, 100.0),
    step("S2", 20.0, 56.0),
    step("S1", 14.0, 28.0),
    step("F3", 10.0, 16.0),
    step("F2", 6.0, 8.0),
    step("F1", 4.0, 4.0),
    step("F0", 2.0, 4.0),
];

/// Peak currents for which the side gap is given (A): those of [`STEPS`].
pub const GAP_CURRENT_A: [f64; 2] = [2.0, 80.0];
/// Pulse durations for which the side gap is given (µs): those of [`STEPS`].
pub const GAP_PULSE_US: [f64; 2] = [4.0, 136.0];
/// Frontal areas for which undersize and roughing current are given (mm²).
pub const RULE_AREA_MM2: [f64; 2] = [10.0, 10_000.0];
/// Finishes that are converted (VDI 3400). The classes of the standard go from 0 to 45.
pub const VDI_RANGE: [f64; 2] = [-20.0, 60.0];
/// Roughness values that are converted (µm), those of [`VDI_RANGE`].
pub const RA_RANGE_UM: [f64; 2] = [0.01, 100.0];

/// Melting point of tool and carbon steels as the removal ceiling takes it (°C). Steels melt at 1420 to 1540 °C.
pub const STEEL_MELTING_C: f64 = 1515.0;
/// Liquidus temperature of Inconel 718 (°C); its solidus is at 1260 °C.
pub const INCONEL_718_MELTING_C: f64 = 1336.0;
/// Liquidus temperature of Ti-6Al-4V (°C); its solidus is at 1604 °C.
pub const TI_6AL_4V_MELTING_C: f64 = 1660.0;

/// Share of the removal ceiling that is assumed to be reached.
pub const ASSUMED_SHARE: f64 = 0.4;

/// Exponent of the frontal area in the roughing current.
const CURRENT_EXPONENT: f64 = 0.437;
/// Roughing current at a frontal area of 1 mm² (A).
const CURRENT_AT_1_MM2: f64 = 2.77;

/// Material of an electrode for which the side gap was fitted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum GapMaterial {
    /// Graphite in steel, R² 0.989.
    Graphite,
    /// Copper in steel, R² 0.993.
    Copper,
}

/// Spark gap at the sides (mm a side) of a peak current (A) and a pulse duration (µs).
///
/// Graphite: 0.01214 IP^0.377 ton^0.356. Copper: 0.01004 IP^0.400 ton^0.381. Steel, through-flushing. Fitted to public
/// generator tables with a standard deviation of 8 to 9 %; valid for the currents and pulses of [`STEPS`].
///
/// # Errors
/// [`BurningError::OutsideRule`] outside [`GAP_CURRENT_A`] and [`GAP_PULSE_US`].
pub fn side_gap_mm(material: GapMaterial, current_a: f64, pulse_us: f64) -> Result<f64, BurningError> {
    inside("side gap", "peak current", current_a, GAP_CURRENT_A, "A")?;
    inside("side gap", "pulse duration", pulse_us, GAP_PULSE_US, "µs")?;
    let (factor, of_current, of_pulse) = match material {
        GapMaterial::Graphite => (0.01214, 0.377, 0.356),
        GapMaterial::Copper => (0.01004, 0.400, 0.381),
    };
    Ok(factor * current_a.powf(of_current) * pulse_us.powf(of_pulse))
}

/// Undersize of a roughing electrode (mm a side) with this frontal area (mm²): 0.0246 A^0.361.
///
/// Steel; fitted to public generator tables with a standard deviation of 8 to 9 %.
///
/// # Errors
/// [`BurningError::OutsideRule`] outside [`RULE_AREA_MM2`].
pub fn undersize_mm(area_mm2: f64) -> Result<f64, BurningError> {
    inside("undersize", "frontal area", area_mm2, RULE_AREA_MM2, "mm²")?;
    Ok(0.0246 * area_mm2.powf(0.361))
}

/// Peak current for roughing (A) with this frontal area (mm²): 2.77 A^0.437.
///
/// Steel; fitted to public generator tables with a standard deviation of 8 to 9 %.
///
/// # Errors
/// [`BurningError::OutsideRule`] outside [`RULE_AREA_MM2`].
pub fn roughing_current_a(area_mm2: f64) -> Result<f64, BurningError> {
    inside("roughing current", "frontal area", area_mm2, RULE_AREA_MM2, "mm²")?;
    Ok(CURRENT_AT_1_MM2 * area_mm2.powf(CURRENT_EXPONENT))
}

/// Least frontal area (mm²) on which a peak current (A) may rough: the inverse of [`roughing_current_a`].
///
/// # Errors
/// [`BurningError::OutsideRule`] for currents below 7.6 A or above 155 A, which no area of [`RULE_AREA_MM2`] has.
pub fn least_area_mm2(current_a: f64) -> Result<f64, BurningError> {
    let range = RULE_AREA_MM2.map(|area| CURRENT_AT_1_MM2 * area.powf(CURRENT_EXPONENT));
    inside("least area", "peak current", current_a, range, "A")?;
    Ok((current_a / CURRENT_AT_1_MM2).powf(CURRENT_EXPONENT.recip()))
}

/// Greatest density of a peak current (A/cm²): the current on its [`least_area_mm2`].
///
/// # Errors
/// As [`least_area_mm2`].
pub fn density_limit_a_cm2(current_a: f64) -> Result<f64, BurningError> {
    Ok(density_a_cm2(current_a, least_area_mm2(current_a)?))
}

/// Density of a current (A) on a frontal area (mm², positive), in A/cm².
pub(crate) fn density_a_cm2(current_a: f64, area_mm2: f64) -> f64 {
    100.0 * current_a / area_mm2
}

/// Least frontal area (mm²) on which a density (A/cm², positive) allows a current (A).
pub(crate) fn area_of_density_mm2(current_a: f64, density_a_cm2: f64) -> f64 {
    100.0 * current_a / density_a_cm2
}

/// Factor of a removal rate that is stated at a frontal area, on another one (both mm²): (A / stated)^0.437 below the
/// stated area, 1 above.
///
/// A generator lowers the current on a smaller area; the current that an area takes grows as in
/// [`roughing_current_a`], and the rate with the current. On a larger area the step keeps its current. Assumed.
///
/// # Errors
/// [`BurningError::OutsideRule`] for areas that are not positive numbers.
pub fn area_factor(area_mm2: f64, stated_at_mm2: f64) -> Result<f64, BurningError> {
    inside("area factor", "frontal area", area_mm2, crate::technology::AREA_MM2, "mm²")?;
    inside("area factor", "stated area", stated_at_mm2, crate::technology::AREA_MM2, "mm²")?;
    Ok((area_mm2 / stated_at_mm2).min(1.0).powf(CURRENT_EXPONENT))
}

/// Greatest removal rate (mm³ per minute) of a mean current (A) in a metal that melts at `melting_c` (°C):
/// 4e4 I Tm^-1.23.
///
/// A textbook formula. Its constant agrees with the other common form, 664 mm³/s, which is 39,840 mm³ per minute. Per
/// mean ampere it gives 4.90 for steel at 1515 °C, 5.72 for Inconel 718 at 1336 °C and 4.38 for Ti-6Al-4V at 1660 °C.
/// The usual 4.9, 5.7 and 4.4 follow if the liquidus temperature of an alloy is taken: the solidus temperatures
/// (1260 and 1604 °C) give 6.15 and 4.57. Steel gives 4.9 from 1503 to 1527 °C; pure iron (1538 °C) gives 4.81 and a
/// tool steel that melts at 1420 °C gives 5.31.
///
/// # Errors
/// [`BurningError::OutsideRule`] for currents outside 0.001 to 2000 A or melting points outside 200 to 4000 °C.
pub fn removal_ceiling_mm3_min(mean_current_a: f64, melting_c: f64) -> Result<f64, BurningError> {
    inside("removal ceiling", "mean current", mean_current_a, [1e-3, 2000.0], "A")?;
    inside("removal ceiling", "melting point", melting_c, [200.0, 4000.0], "°C")?;
    Ok(4e4 * mean_current_a * melting_c.powf(-1.23))
}

/// Removal rate that the default technologies assume (mm³ per minute): [`ASSUMED_SHARE`] of the ceiling of a mean
/// current (A).
///
/// The default technologies know no pause between pulses. For roughing and semi-finishing they take the peak current for
/// the mean current; the share stands for pauses, jumps of the servo and debris. Finishing pauses for longer than it
/// burns, by an unknown ratio: its steps have no rate. Finished burns correct the rates.
///
/// # Errors
/// As [`removal_ceiling_mm3_min`].
pub fn removal_rate_mm3_min(mean_current_a: f64, melting_c: f64) -> Result<f64, BurningError> {
    Ok(ASSUMED_SHARE * removal_ceiling_mm3_min(mean_current_a, melting_c)?)
}

/// Thickness of the layer (mm) that a step leaves for the next one: the difference of their side gaps (mm a side).
///
/// The next step reaches the wall that the step before would reach with the same orbit, less its smaller gap. Assumed.
///
/// # Errors
/// [`BurningError::OutsideRule`] unless the gap of the next step is positive and not greater than the one before.
pub fn stock_for_next_mm(gap_mm: f64, next_gap_mm: f64) -> Result<f64, BurningError> {
    inside("stock for the next step", "side gap", gap_mm, [1e-4, 5.0], "mm")?;
    inside("stock for the next step", "side gap of the next step", next_gap_mm, [1e-4, gap_mm], "mm")?;
    Ok(gap_mm - next_gap_mm)
}

/// Finish (VDI 3400) of an arithmetic mean roughness (µm): 20 log10(10 Ra).
///
/// # Errors
/// [`BurningError::OutsideRule`] outside [`RA_RANGE_UM`].
pub fn vdi_of_ra(ra_um: f64) -> Result<f64, BurningError> {
    inside("VDI 3400", "roughness Ra", ra_um, RA_RANGE_UM, "µm")?;
    Ok(20.0 * (10.0 * ra_um).log10())
}

/// Arithmetic mean roughness (µm) of a finish (VDI 3400): 10^(K/20) / 10.
///
/// # Errors
/// [`BurningError::OutsideRule`] outside [`VDI_RANGE`].
pub fn ra_of_vdi(vdi: f64) -> Result<f64, BurningError> {
    inside("VDI 3400", "finish", vdi, VDI_RANGE, "VDI")?;
    Ok(10f64.powf(vdi / 20.0) / 10.0)
}

/// Ratio of the undersize of the roughing electrode to that of the finishing electrode beyond which there is a middle
/// electrode.
pub const MIDDLE_ELECTRODE_RATIO: f64 = 4.0;

/// Whether a middle electrode is needed between roughing and finishing electrodes of these undersizes (mm a side).
///
/// A rule of thumb: the finishing electrode would otherwise have too much to remove.
///
/// # Errors
/// [`BurningError::OutsideRule`] for undersizes that are not positive or above 50 mm.
pub fn needs_middle_electrode(roughing_mm: f64, finishing_mm: f64) -> Result<bool, BurningError> {
    inside("middle electrode", "undersize for roughing", roughing_mm, UNDERSIZE_MM, "mm")?;
    inside("middle electrode", "undersize for finishing", finishing_mm, UNDERSIZE_MM, "mm")?;
    Ok(roughing_mm > MIDDLE_ELECTRODE_RATIO * finishing_mm)
}

/// Undersizes that are possible (mm a side).
pub(crate) const UNDERSIZE_MM: [f64; 2] = [1e-4, 50.0];

/// Distance (mm, along its normal) by which a face of the electrode is moved inwards by an undersize (mm a side), where
/// `angle_deg` is the angle between the face's normal and the burn direction: undersize times the sine.
///
/// An undersize acts sideways: a wall (90°) moves by all of it, a floor (0°) stays. In depth the electrode is set by its
/// front gap.
///
/// # Errors
/// [`BurningError::OutsideRule`] for undersizes below 0 or above 50 mm, and for angles outside 0 to 180°.
pub fn normal_undersize_mm(undersize_mm: f64, angle_deg: f64) -> Result<f64, BurningError> {
    inside("undersize of a face", "undersize", undersize_mm, [0.0, UNDERSIZE_MM[1]], "mm")?;
    inside("undersize of a face", "angle", angle_deg, [0.0, 180.0], "°")?;
    // The sine of 180 degrees is not exactly 0 in floating point.
    Ok(undersize_mm * angle_deg.min(180.0 - angle_deg).to_radians().sin())
}

/// Least radius (mm) of an inner upright corner that an electrode burns: the radius of its own edge, of a circular orbit
/// and of the side gap (all mm), added.
///
/// A circular orbit and the gap enlarge the electrode's outline by a circle each, so a sharp edge burns a corner of this
/// radius. Geometry; holds for any material.
///
/// # Errors
/// [`BurningError::OutsideRule`] for lengths below 0 or above 50 mm.
pub fn corner_radius_mm(edge_mm: f64, orbit_mm: f64, gap_mm: f64) -> Result<f64, BurningError> {
    let lengths = [("radius of the edge", edge_mm), ("radius of the orbit", orbit_mm), ("side gap", gap_mm)];
    lengths.into_iter().try_fold(0.0, |sum, (quantity, length)| {
        inside("corner radius", quantity, length, [0.0, 50.0], "mm").map(|()| sum + length)
    })
}

fn inside(
    rule: &'static str,
    quantity: &'static str,
    value: f64,
    [least, greatest]: [f64; 2],
    unit: &'static str,
) -> Result<(), BurningError> {
    // Also false for NaN.
    if (least..=greatest).contains(&value) {
        return Ok(());
    }
    Err(BurningError::OutsideRule { rule, quantity, value, least, greatest, unit })
}

#[cfg(test)]
mod tests {
    use std::f64::consts::LOG10_2;

    use proptest::prelude::*;

    use super::*;

    fn close(a: f64, b: f64, relative: f64) {
        assert!((a - b).abs() <= relative * b.abs(), "{a} is not {b}");
    }

    /// Logarithms in base 10 by hand: lg 80 = 1.90309, lg 136 = 2.13354.
    #[test]
    fn gaps_are_those_of_the_fits() {
        let gap = |m, i, t| side_gap_mm(m, i, t).unwrap();
        let power = |lg: f64| 10f64.powf(lg);
        close(gap(GapMaterial::Graphite, 80.0, 136.0), 0.01214 * power(0.377 * 1.90309 + 0.356 * 2.13354), 1e-5);
        close(gap(GapMaterial::Copper, 2.0, 4.0), 0.01004 * power((0.4 + 2.0 * 0.381) * LOG10_2), 1e-12);
        // Twice the current or the pulse: 2 to the exponent.
        close(gap(GapMaterial::Copper, 40.0, 50.0) / gap(GapMaterial::Copper, 20.0, 50.0), 2f64.powf(0.4), 1e-12);
        close(gap(GapMaterial::Graphite, 9.0, 100.0) / gap(GapMaterial::Graphite, 9.0, 50.0), 2f64.powf(0.356), 1e-12);
    }

    #[test]
    fn finer_steps_have_smaller_gaps_and_currents() {
        for material in [GapMaterial::Graphite, GapMaterial::Copper] {
            for pair in STEPS.windows(2) {
                let [rough, fine] = [0, 1].map(|i| side_gap_mm(material, pair[i].current_a, pair[i].pulse_us).unwrap());
                assert!(fine < rough && pair[1].current_a < pair[0].current_a);
                close(stock_for_next_mm(rough, fine).unwrap() + fine, rough, 1e-12);
                assert!(stock_for_next_mm(fine, rough).is_err());
            }
        }
    }

    /// 100 mm² is 10 to the 2: 0.0246 * 10^0.722 and 2.77 * 10^0.874.
    #[test]
    fn undersize_and_current_grow_with_area() {
        close(undersize_mm(100.0).unwrap(), 0.0246 * 5.272299, 1e-6);
        close(roughing_current_a(100.0).unwrap(), 2.77 * 7.481695, 1e-6);
        close(roughing_current_a(10_000.0).unwrap() / roughing_current_a(100.0).unwrap(), 7.481695, 1e-6);
        for area in [10.0, 37.0, 10_000.0] {
            let current = roughing_current_a(area).unwrap();
            close(least_area_mm2(current).unwrap(), area, 1e-9);
            close(density_limit_a_cm2(current).unwrap(), 100.0 * current / area, 1e-9);
        }
    }

    #[test]
    fn the_constant_of_the_ceiling_gives_the_usual_figures() {
        let per_ampere = |melting| removal_ceiling_mm3_min(1.0, melting).unwrap();
        for (melting, usual) in [(STEEL_MELTING_C, 4.9), (INCONEL_718_MELTING_C, 5.7), (TI_6AL_4V_MELTING_C, 4.4)] {
            assert!((per_ampere(melting) - usual).abs() < 0.05, "{melting}");
        }
        // The figures of the doc comment.
        let said = [
            (1515.0, 4.90),
            (1336.0, 5.72),
            (1660.0, 4.38),
            (1260.0, 6.15),
            (1604.0, 4.57),
            (1538.0, 4.81),
            (1420.0, 5.31),
        ];
        for (melting, figure) in said {
            assert!((per_ampere(melting) - figure).abs() < 0.006, "{melting}: {}", per_ampere(melting));
        }
        assert!(per_ampere(1502.0) > 4.95 && per_ampere(1503.0) < 4.95);
        assert!(per_ampere(1527.0) > 4.85 && per_ampere(1528.0) < 4.85);
        // The other form of the formula, in mm³ per second.
        close(per_ampere(1000.0), 60.0 * 664.0 * 1000f64.powf(-1.23), 0.005);
        close(removal_rate_mm3_min(10.0, 1336.0).unwrap(), 4.0 * per_ampere(1336.0), 1e-12);
    }

    #[test]
    fn finish_and_roughness_are_those_of_the_standard() {
        // VDI 3400: class 0 is Ra 0.1, 12 is 0.4, 20 is 1.0, 30 is 3.15, 45 is 18 µm (rounded values).
        for (class, ra) in [(0.0, 0.1), (12.0, 0.4), (20.0, 1.0), (30.0, 3.15), (45.0, 18.0)] {
            close(ra_of_vdi(class).unwrap(), ra, 0.02);
            assert!((vdi_of_ra(ra).unwrap() - class).abs() < 0.15, "{class}");
        }
    }

    #[test]
    fn an_undersize_acts_sideways_only() {
        assert_eq!(normal_undersize_mm(0.3, 0.0), Ok(0.0));
        assert_eq!(normal_undersize_mm(0.3, 180.0), Ok(0.0));
        close(normal_undersize_mm(0.3, 90.0).unwrap(), 0.3, 1e-15);
        close(normal_undersize_mm(0.3, 30.0).unwrap(), 0.15, 1e-12);
        close(normal_undersize_mm(0.3, 150.0).unwrap(), 0.15, 1e-12);
        close(corner_radius_mm(0.0, 0.2, 0.0).unwrap(), 0.2, 1e-15);
        close(corner_radius_mm(0.1, 0.2, 0.05).unwrap(), 0.35, 1e-12);
        assert_eq!(needs_middle_electrode(0.4, 0.1), Ok(false));
        assert_eq!(needs_middle_electrode(0.41, 0.1), Ok(true));
    }

    #[test]
    fn the_rate_falls_on_a_smaller_area_only() {
        assert_eq!(area_factor(200.0, 100.0), Ok(1.0));
        close(area_factor(50.0, 100.0).unwrap(), 0.5f64.powf(0.437), 1e-12);
    }

    #[test]
    fn outside_its_range_a_rule_says_so() {
        let said = side_gap_mm(GapMaterial::Copper, 100.0, 10.0).unwrap_err().to_string();
        assert_eq!(said, "side gap: peak current is 100 A; the rule holds from 2 to 80 A: give the figure itself");
        assert!(undersize_mm(9.0).is_err() && roughing_current_a(2e4).is_err() && least_area_mm2(6.0).is_err());
    }

    proptest! {
        /// Whatever is asked: a finite figure or an error.
        #[test]
        fn no_rule_answers_what_is_no_number(a in any::<f64>(), b in any::<f64>(), c in any::<f64>()) {
            let answers = [
                side_gap_mm(GapMaterial::Graphite, a, b),
                undersize_mm(a),
                roughing_current_a(a),
                least_area_mm2(a),
                density_limit_a_cm2(a),
                area_factor(a, b),
                removal_ceiling_mm3_min(a, b),
                removal_rate_mm3_min(a, b),
                stock_for_next_mm(a, b),
                vdi_of_ra(a),
                ra_of_vdi(a),
                normal_undersize_mm(a, b),
                corner_radius_mm(a, b, c),
            ];
            prop_assert!(answers.into_iter().flatten().all(f64::is_finite));
        }

        #[test]
        fn finish_and_roughness_are_inverse(vdi in -20.0..60.0) {
            let ra = ra_of_vdi(vdi).unwrap().clamp(0.01, 100.0);
            prop_assert!((vdi_of_ra(ra).unwrap() - vdi).abs() < 1e-9);
        }
    }
}
