//! The built-in technologies, made from the [`rules`](crate::rules).

use std::path::Path;

use files::FileError;

use crate::technology::{TECHNOLOGY_FILE, TechnologyFile};

/// The built-in technologies: steel with graphite and with copper, Ti-6Al-4V and Inconel 718 with copper.
///
/// Finish, wear, pauses and jumps are missing in all of them, and the rate of the finishing steps F3 to F0. Titanium and
/// nickel have no gap, stock or current density either. Minutes from them are assumed.
///
/// As no step has a finish, burning can only end at a named step ([`Until::Step`](crate::choice::Until::Step)); a burn
/// until a finish answers that the finish is missing. In titanium and nickel nothing bounds the current on an area, so
/// there are no minutes.
///
/// # Errors
/// [`FileError`] if the built-in table cannot be read; a test reads it.
pub fn standard() -> Result<TechnologyFile, FileError> {
    TECHNOLOGY_FILE.parse(include_str!("../../../assets/technology.toml"), Path::new("technology.toml"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::choice::tests::burn;
    use crate::choice::{Figure, Until};
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
                // Finishing pauses for an unknown time: the peak current is not its mean current.
                let rate = rules::removal_rate_mm3_min(default.current_a, melting_c).ok();
                let rate = rate.filter(|_| !default.name.starts_with('F'));
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
            let time = file.estimate("steel-copper", &burn(1000.0, area, Until::Step("S1".to_owned()))).unwrap().time;
            assert!(time.estimated_min.unwrap() > 0.0);
            time.steps[0].step.clone()
        };
        assert_eq!([50.0, 100.0, 190.0, 460.0, 2300.0].map(first), ["S1", "S2", "R1", "R2", "R3"]);
        let wanted = burn(1000.0, 100.0, Until::Vdi(26.0));
        let time = file.estimate("steel-copper", &wanted).unwrap().time;
        let said: Vec<String> = time.missing.iter().map(ToString::to_string).collect();
        assert_eq!((time.burning, said.len()), (None, 1), "no finish is given");
        assert!(said[0].starts_with("finish of steps R3, R2"), "{said:?}");
    }

    /// Pauses of finishing are not known, so there are no minutes of it.
    #[test]
    fn finishing_has_no_rate() {
        let file = standard().unwrap();
        let time = file.estimate("steel-graphite", &burn(1000.0, 100.0, Until::Step("F2".to_owned()))).unwrap().time;
        let said: Vec<String> = time.missing.iter().map(ToString::to_string).collect();
        assert_eq!((time.burning, said.join("; ").as_str()), (None, "rate of steps F3, F2 is not given"));
        assert!(time.steps[0].minutes.unwrap() > 0.0, "what is known of roughing stays");
        let sentences = time.not_considered.len();
        assert!(sentences <= 5, "{sentences} sentences");
    }

    /// Neither a density nor an area bounds the current in titanium: it would be 80 A on 1 mm².
    #[test]
    fn titanium_has_no_minutes() {
        let file = standard().unwrap();
        for (id, area) in [("titanium-copper", 2500.0), ("nickel-copper", 1.0)] {
            let answer = file.estimate(id, &burn(1000.0, area, Until::Step("R2".to_owned()))).unwrap();
            let figures: Vec<Figure> = answer.time.missing.iter().map(|missing| missing.figure).collect();
            assert_eq!((answer.time.burning, figures), (None, vec![Figure::StockNext, Figure::Density]), "{id}");
            assert_eq!((answer.wear.end_mm, answer.wear.corner_mm), (None, None));
        }
    }
}
