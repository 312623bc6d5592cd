//! The built-in technologies, made from the [`rules`](crate::rules).

use std::path::Path;

use files::FileError;

use crate::technology::{TECHNOLOGY_FILE, TechnologyFile};

/// The built-in technologies: steel with graphite and with copper, Ti-6Al-4V and Inconel 718 with copper.
///
/// Finish, wear, pauses and jumps are missing in all of them; titanium and nickel have no gap, stock or current density
/// either. Minutes from them are assumed.
///
/// # Errors
/// [`FileError`] if the built-in table cannot be read; a test reads it.
pub fn standard() -> Result<TechnologyFile, FileError> {
    TECHNOLOGY_FILE.parse(include_str!("../../../assets/technology.toml"), Path::new("technology.toml"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::choice::Until;
    use crate::choice::tests::burn;
    use crate::duration::{Overhead, burn_time};
    use crate::rules::{self, GapMaterial, STEPS};
    use crate::technology::{Basis, ElectrodeMaterial, Step, Technology};

    const MELTING_C: [(&str, f64); 4] = [
        ("steel-graphite", rules::STEEL_MELTING_C),
        ("steel-copper", rules::STEEL_MELTING_C),
        ("titanium-copper", rules::TI_6AL_4V_MELTING_C),
        ("nickel-copper", rules::INCONEL_718_MELTING_C),
    ];

    fn gap_material(technology: &Technology) -> GapMaterial {
        match technology.electrode_material {
            ElectrodeMaterial::Graphite => GapMaterial::Graphite,
            _ => GapMaterial::Copper,
        }
    }

    #[test]
    fn the_built_in_table_has_the_figures_of_the_rules() {
        let file = standard().unwrap();
        assert_eq!(file.technology.iter().map(|t| t.id.as_str()).collect::<Vec<_>>(), MELTING_C.map(|(id, _)| id));
        assert!(file.calibration.is_empty());
        for (id, melting_c) in MELTING_C {
            let technology = file.get(id).unwrap();
            assert_eq!(technology.basis, Basis::Assumed);
            assert!(technology.source.contains(&format!("{melting_c} °C")), "{}", technology.source);
            let is_steel = technology.workpiece == "steel";
            let gap = |i: usize| {
                let step = STEPS.get(i)?;
                rules::side_gap_mm(gap_material(technology), step.current_a, step.pulse_us).ok()
            };
            assert_eq!(technology.step.len(), STEPS.len());
            for (i, (step, default)) in technology.step.iter().zip(STEPS).enumerate() {
                let pulse = (step.name.as_str(), step.ip_a, step.on_us);
                assert_eq!(pulse, (default.name, Some(default.current_a), Some(default.pulse_us)));
                let rounded = |value: Option<f64>, rule: Option<f64>, rounding: f64, what: &str| {
                    assert_eq!(value.is_some(), rule.is_some(), "{id} {} {what}", step.name);
                    let off = value.zip(rule).map_or(0.0, |(value, rule)| (value - rule).abs());
                    assert!(off <= 0.5001 * rounding, "{id} {} {what}: off by {off}", step.name);
                };
                let rate = rules::removal_rate_mm3_min(default.current_a, melting_c).ok();
                rounded(step.rate_mm3_min, rate, 0.01, "rate");
                rounded(step.gap_side_mm, gap(i).filter(|_| is_steel), 1e-4, "gap");
                let stock = gap(i).zip(gap(i + 1)).and_then(|(a, b)| rules::stock_for_next_mm(a, b).ok());
                rounded(step.stock_next_mm, stock.filter(|_| is_steel), 1e-4, "stock");
                let density = rules::density_limit_a_cm2(default.current_a).ok();
                rounded(step.max_density_a_cm2, density.filter(|_| is_steel), 0.01, "density");
            }
        }
    }

    #[test]
    fn what_has_no_source_is_empty() {
        for technology in standard().unwrap().technology {
            for step in &technology.step {
                let kept = Step {
                    name: step.name.clone(),
                    ip_a: step.ip_a,
                    on_us: step.on_us,
                    rate_mm3_min: step.rate_mm3_min,
                    ..Step::default()
                };
                let of_steel = Step {
                    gap_side_mm: step.gap_side_mm,
                    max_density_a_cm2: step.max_density_a_cm2,
                    stock_next_mm: step.stock_next_mm,
                    ..kept.clone()
                };
                assert_eq!(*step, if technology.workpiece == "steel" { of_steel } else { kept });
            }
        }
    }

    /// 100 mm² take 20.7 A: burning starts with S2 at 20 A.
    #[test]
    fn steel_is_roughed_with_the_current_of_the_area() {
        let file = standard().unwrap();
        let first = |area: f64| {
            let burn = burn(1000.0, area, Until::Step("F3".to_owned()));
            let time = burn_time(file.get("steel-copper").unwrap(), &burn, None, Overhead::default()).unwrap();
            assert!(time.estimated_min.unwrap() > 0.0);
            time.steps[0].step.clone()
        };
        assert_eq!([20.0, 100.0, 190.0, 460.0, 2300.0].map(first), ["F3", "S2", "R1", "R2", "R3"]);
        let wanted = burn(1000.0, 100.0, Until::Vdi(26.0));
        let time = burn_time(file.get("steel-copper").unwrap(), &wanted, None, Overhead::default()).unwrap();
        assert_eq!((time.total, time.missing.len()), (None, 9), "no finish is given");
    }

    /// With a single step titanium has an assumed time, with two the layer between them is missing.
    #[test]
    fn titanium_has_no_layers() {
        let file = standard().unwrap();
        let time = |step: &str| {
            let burn = burn(1000.0, 2500.0, Until::Step(step.to_owned()));
            burn_time(file.get("titanium-copper").unwrap(), &burn, None, Overhead::default()).unwrap()
        };
        assert!(time("R3").total.is_some());
        let two = time("R2");
        assert_eq!(two.total, None);
        assert_eq!(two.missing[0].to_string(), "stock left for the next step of step R3 is not given");
    }
}
