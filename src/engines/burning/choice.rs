//! Choice of the steps that an electrode burns with, and the volume that each step removes.

use std::fmt;

use files::{Invalid, Validate};
use serde::{Deserialize, Serialize};

use crate::technology::{AREA_MM2, Step, Technology};
use crate::{BurningError, rules};

/// Difference between a wanted finish and that of a step that counts as the same (VDI 3400): the tables of the standard
/// round the roughness of a class.
const FINISH_TOLERANCE_VDI: f64 = 0.2;

/// What one electrode has to burn in one place.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Burn {
    /// Volume to remove (mm³): the stock that the electrodes before have left.
    pub volume_mm3: f64,
    /// Area of the electrode seen along the burn or the path (mm²).
    pub frontal_area_mm2: f64,
    /// Area of the burned surface (mm²), from which later steps remove a layer; the frontal area where it is not known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub burned_area_mm2: Option<f64>,
    /// Undersize of the electrode (mm a side); steps with a greater side gap are not taken.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub undersize_mm: Option<f64>,
    /// Ratio of depth to width of the cavity.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub depth_to_width: Option<f64>,
    /// Where burning ends.
    pub until: Until,
}

/// Where burning ends.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Until {
    /// At this finish (VDI 3400).
    Vdi(f64),
    /// At this arithmetic mean roughness (µm).
    RaUm(f64),
    /// After the step of this name.
    Step(String),
}

impl Validate for Burn {
    fn validate(&self) -> Result<(), Invalid> {
        Invalid::unless_within("volume_mm3", self.volume_mm3, [0.0, 1e9], "mm³")?;
        for (key, value, range, unit) in [
            ("frontal_area_mm2", Some(self.frontal_area_mm2), AREA_MM2, "mm²"),
            ("burned_area_mm2", self.burned_area_mm2, AREA_MM2, "mm²"),
            ("undersize_mm", self.undersize_mm, rules::UNDERSIZE_MM, "mm"),
            ("depth_to_width", self.depth_to_width, [0.0, 1e4], ""),
        ] {
            value.map_or(Ok(()), |value| Invalid::unless_within(key, value, range, unit))?;
        }
        match &self.until {
            Until::Vdi(vdi) => Invalid::unless_within("until.vdi", *vdi, rules::VDI_RANGE, "VDI"),
            Until::RaUm(ra) => Invalid::unless_within("until.ra_um", *ra, rules::RA_RANGE_UM, "µm"),
            Until::Step(_) => Ok(()),
        }
    }
}

/// A figure of a step that a result needs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Figure {
    /// Finish, as VDI class or roughness.
    Finish,
    /// Peak current.
    PeakCurrent,
    /// Greatest current density.
    Density,
    /// Side gap.
    SideGap,
    /// Removal rate.
    Rate,
    /// Area at which the removal rate is stated.
    RateArea,
    /// Layer left for the next step.
    StockNext,
    /// Height, interval and speed of jumps.
    Jump,
    /// Volume wear.
    Wear,
    /// Corner wear.
    CornerWear,
}

impl fmt::Display for Figure {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(match self {
            Self::Finish => "finish",
            Self::PeakCurrent => "peak current",
            Self::Density => "greatest current density",
            Self::SideGap => "side gap",
            Self::Rate => "rate",
            Self::RateArea => "area of the rate",
            Self::StockNext => "stock left for the next step",
            Self::Jump => "jump",
            Self::Wear => "wear",
            Self::CornerWear => "corner wear",
        })
    }
}

/// A figure that the technology does not give. Its text reads `rate of step R1 is not given`.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Missing {
    /// Name of the step.
    pub step: String,
    /// The figure.
    pub figure: Figure,
}

impl Missing {
    pub(crate) fn of(step: &Step, figure: Figure) -> Self {
        Self { step: step.name.clone(), figure }
    }
}

impl fmt::Display for Missing {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "{} of step {} is not given", self.figure, self.step)
    }
}

/// A burn for which the figures of the technology are not valid.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Outside {
    /// The frontal area is smaller or greater than those of the technology (mm²).
    Area {
        /// Frontal area.
        area_mm2: f64,
        /// Least and greatest area of the technology.
        range_mm2: [f64; 2],
    },
    /// The cavity is deeper for its width than the technology allows.
    DepthToWidth {
        /// Ratio of depth to width.
        ratio: f64,
        /// Greatest ratio of the technology.
        greatest: f64,
    },
}

impl fmt::Display for Outside {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::Area { area_mm2, range_mm2: [least, greatest] } => {
                write!(f, "frontal area {area_mm2:.2} mm²; the technology is valid from {least} to {greatest} mm²")
            }
            Self::DepthToWidth { ratio, greatest } => {
                write!(f, "depth to width {ratio:.2}; the technology is valid up to {greatest}")
            }
        }
    }
}

/// A step with the volume that it removes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ChosenStep<'a> {
    /// The step.
    pub step: &'a Step,
    /// Volume that it removes (mm³); none if the layer that it gets is not known.
    pub volume_mm3: Option<f64>,
}

/// The steps that an electrode burns with.
#[derive(Debug, Clone, PartialEq)]
pub struct Choice<'a> {
    /// Technology of the steps.
    pub technology: &'a Technology,
    /// The steps, from rough to fine; none if figures that decide are missing.
    pub steps: Vec<ChosenStep<'a>>,
    /// Frontal area of the burn (mm²).
    pub frontal_area_mm2: f64,
    /// Whether layers are counted over the burned surface; over the frontal area where that is not known.
    pub burned_area_given: bool,
    /// Figures without which steps or volumes are not known.
    pub missing: Vec<Missing>,
    /// Figures that the choice does without.
    pub not_considered: Vec<Missing>,
    /// Ranges of the technology that the burn leaves.
    pub outside: Vec<Outside>,
}

/// Chooses the steps for a burn.
///
/// The last step is the first one that reaches the finish, or the one that is named. Of the steps before it those are
/// taken whose current density the frontal area allows and whose side gap is within the undersize. If the density or
/// the gap of the last step is too great for the burn, a finer one takes its place, unless it was named.
///
/// Each step leaves a layer for the next one. The finest steps get their layers first; roughing gets the rest. A step
/// for which nothing is left is not burned.
///
/// # Errors
/// [`BurningError`] if the burn or the technology is not possible, if no step is fine enough, or if the last step does
/// not suit the burn.
pub fn choose<'a>(technology: &'a Technology, burn: &Burn) -> Result<Choice<'a>, BurningError> {
    technology.validate()?;
    burn.validate()?;
    let mut choice = Choice {
        technology,
        steps: Vec::new(),
        frontal_area_mm2: burn.frontal_area_mm2,
        burned_area_given: burn.burned_area_mm2.is_some(),
        missing: Vec::new(),
        not_considered: Vec::new(),
        outside: outside(technology, burn),
    };
    let last = match &burn.until {
        Until::Step(name) => named(technology, name)?,
        Until::Vdi(vdi) => match fine_enough(technology, *vdi, &mut choice)? {
            Some(first) => finer_that_suits(technology, burn, first)?,
            None => return Ok(choice),
        },
        Until::RaUm(ra) => match fine_enough(technology, rules::vdi_of_ra(*ra)?, &mut choice)? {
            Some(first) => finer_that_suits(technology, burn, first)?,
            None => return Ok(choice),
        },
    };
    let mut steps: Vec<&Step> = Vec::new();
    for (i, step) in technology.step.iter().enumerate().take(last + 1) {
        match suits(technology, burn, step) {
            Ok(()) => steps.push(step),
            Err(reason) if i == last => return Err(reason),
            Err(_) => {}
        }
    }
    choice.steps = shared(&steps, burn, &mut choice.missing);
    choice.not_considered.extend(choice.steps.iter().flat_map(|chosen| unchecked(chosen.step, burn)));
    Ok(choice)
}

fn outside(technology: &Technology, burn: &Burn) -> Vec<Outside> {
    let area_mm2 = burn.frontal_area_mm2;
    let area = technology.area_range_mm2.filter(|[least, greatest]| !(*least..=*greatest).contains(&area_mm2));
    let depth = burn.depth_to_width.zip(technology.greatest_depth_to_width).filter(|(ratio, most)| ratio > most);
    let area = area.map(|range_mm2| Outside::Area { area_mm2, range_mm2 });
    let depth = depth.map(|(ratio, greatest)| Outside::DepthToWidth { ratio, greatest });
    area.into_iter().chain(depth).collect()
}

fn named(technology: &Technology, name: &str) -> Result<usize, BurningError> {
    technology.step.iter().position(|step| step.name == name).ok_or_else(|| {
        let names: Vec<&str> = technology.step.iter().map(|step| step.name.as_str()).collect();
        let [technology, step] = [&technology.id, name].map(str::to_owned);
        BurningError::NoSuchStep { technology, step, steps: names.join(", ") }
    })
}

/// The first step that is as fine as wanted; none, with what is missing, if steps without a finish could be.
fn fine_enough(technology: &Technology, wanted_vdi: f64, choice: &mut Choice) -> Result<Option<usize>, BurningError> {
    let is_fine = |step: &Step| step.finish_vdi().is_some_and(|vdi| vdi <= wanted_vdi + FINISH_TOLERANCE_VDI);
    let first = technology.step.iter().position(is_fine);
    let before = technology.step.iter().take(first.unwrap_or(technology.step.len()));
    let unknown = before.filter(|step| step.finish_vdi().is_none()).map(|step| Missing::of(step, Figure::Finish));
    if first.is_some() {
        // A rougher step without a finish may do as well: the one that is known to do is taken.
        choice.not_considered.extend(unknown);
        return Ok(first);
    }
    choice.missing.extend(unknown);
    let finest = technology.step.iter().filter_map(Step::finish_vdi).next_back();
    match finest {
        Some(finest_vdi) if choice.missing.is_empty() => {
            Err(BurningError::FinishNotReached { technology: technology.id.clone(), wanted_vdi, finest_vdi })
        }
        _ => Ok(None),
    }
}

/// The first step from `first` on that suits the burn.
fn finer_that_suits(technology: &Technology, burn: &Burn, first: usize) -> Result<usize, BurningError> {
    let mut reason = None;
    for (i, step) in technology.step.iter().enumerate().skip(first) {
        match suits(technology, burn, step) {
            Ok(()) => return Ok(i),
            Err(error) => reason = Some(error),
        }
    }
    reason.map_or(Ok(first), Err)
}

/// Whether the current density and the side gap of a step are within what the burn allows, as far as both are known.
fn suits(technology: &Technology, burn: &Burn, step: &Step) -> Result<(), BurningError> {
    if let (Some(current), Some(limit_a_cm2)) = (step.ip_a, step.max_density_a_cm2) {
        let density_a_cm2 = rules::density_a_cm2(current, burn.frontal_area_mm2);
        if density_a_cm2 > limit_a_cm2 {
            let [technology, step] = [technology.id.clone(), step.name.clone()];
            return Err(BurningError::CurrentDensity { technology, step, density_a_cm2, limit_a_cm2 });
        }
    }
    if let (Some(gap_mm), Some(undersize_mm)) = (step.gap_side_mm, burn.undersize_mm)
        && gap_mm > undersize_mm
    {
        let [technology, step] = [technology.id.clone(), step.name.clone()];
        return Err(BurningError::GapBeyondUndersize { technology, step, gap_mm, undersize_mm });
    }
    Ok(())
}

/// Figures of a step without which something about the burn could not be checked.
fn unchecked(step: &Step, burn: &Burn) -> impl Iterator<Item = Missing> {
    let density = step.max_density_a_cm2.is_none().then_some(Figure::Density);
    let current = (step.max_density_a_cm2.is_some() && step.ip_a.is_none()).then_some(Figure::PeakCurrent);
    let gap = (step.gap_side_mm.is_none() && burn.undersize_mm.is_some()).then_some(Figure::SideGap);
    [density, current, gap].into_iter().flatten().map(|figure| Missing::of(step, figure))
}

/// The steps that have something to remove, with their volumes.
fn shared<'a>(steps: &[&'a Step], burn: &Burn, missing: &mut Vec<Missing>) -> Vec<ChosenStep<'a>> {
    let area = burn.burned_area_mm2.unwrap_or(burn.frontal_area_mm2);
    // None once a layer is not known.
    let mut rest = Some(burn.volume_mm3);
    let mut chosen = Vec::new();
    for (i, step) in steps.iter().enumerate().rev() {
        let is_last = i + 1 == steps.len();
        let before = i.checked_sub(1).and_then(|before| steps.get(before));
        let volume = match (before, rest) {
            (None, rest) => rest,
            (_, Some(0.0)) => Some(0.0),
            (Some(before), rest) => match before.stock_next_mm {
                Some(stock) => rest.map(|rest| (stock * area).min(rest)),
                None => {
                    missing.push(Missing::of(before, Figure::StockNext));
                    None
                }
            },
        };
        rest = rest.zip(volume).map(|(rest, volume)| (rest - volume).max(0.0));
        if is_last || volume != Some(0.0) {
            chosen.push(ChosenStep { step, volume_mm3: volume });
        }
    }
    missing.reverse();
    chosen.reverse();
    chosen
}

#[cfg(test)]
pub(crate) mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::technology::{Basis, ElectrodeMaterial};

    /// Steps R, S, F with every figure that choice, time and wear need.
    pub(crate) fn complete() -> Technology {
        let step = |name: &str, vdi, ip_a, gap, rate, wear, stock| Step {
            name: name.to_owned(),
            vdi: Some(vdi),
            ip_a: Some(ip_a),
            gap_side_mm: Some(gap),
            rate_mm3_min: Some(rate),
            at_area_mm2: Some(100.0),
            max_density_a_cm2: Some(20.0),
            wear_percent: Some(wear),
            corner_wear_mm: Some(0.02),
            stock_next_mm: stock,
            jump_mm: Some(2.0),
            jump_every_s: Some(1.0),
            jump_speed: Some(4800.0),
            ..Step::default()
        };
        Technology {
            id: "complete".to_owned(),
            title: String::new(),
            machine: None,
            generator: None,
            source: "test".to_owned(),
            licence: None,
            basis: Basis::Measured,
            date: None,
            electrode_material: ElectrodeMaterial::Copper,
            electrode_grade: None,
            workpiece: "steel".to_owned(),
            polarity: None,
            dielectric: None,
            flushing: None,
            area_range_mm2: Some([10.0, 1000.0]),
            greatest_depth_to_width: Some(5.0),
            step: vec![
                step("R", 36.0, 20.0, 0.2, 40.0, 1.0, Some(0.1)),
                step("S", 28.0, 10.0, 0.1, 10.0, 5.0, Some(0.05)),
                step("F", 20.0, 4.0, 0.05, 2.0, 20.0, None),
            ],
        }
    }

    pub(crate) fn burn(volume_mm3: f64, frontal_area_mm2: f64, until: Until) -> Burn {
        let [burned_area_mm2, undersize_mm, depth_to_width] = [None; 3];
        Burn { volume_mm3, frontal_area_mm2, burned_area_mm2, undersize_mm, depth_to_width, until }
    }

    fn names(choice: &Choice) -> String {
        choice.steps.iter().map(|chosen| chosen.step.name.as_str()).collect()
    }

    fn until(technology: &Technology, until: Until) -> String {
        names(&choose(technology, &burn(1000.0, 100.0, until)).unwrap())
    }

    #[test]
    fn steps_end_at_the_finish_that_is_wanted() {
        let technology = complete();
        for (vdi, steps) in [(40.0, "R"), (36.0, "R"), (35.0, "RS"), (28.0, "RS"), (24.0, "RSF"), (20.0, "RSF")] {
            assert_eq!(until(&technology, Until::Vdi(vdi)), steps, "{vdi}");
        }
        // Ra 1.0 µm is VDI 20, Ra 2.5 is VDI 27.96.
        assert_eq!(until(&technology, Until::RaUm(1.0)), "RSF");
        assert_eq!(until(&technology, Until::RaUm(2.5)), "RS");
        assert_eq!(until(&technology, Until::Step("S".to_owned())), "RS");
        let error = choose(&technology, &burn(1.0, 100.0, Until::Vdi(15.0))).unwrap_err();
        let is = BurningError::FinishNotReached { technology: "complete".into(), wanted_vdi: 15.0, finest_vdi: 20.0 };
        assert_eq!(error, is);
        let error = choose(&technology, &burn(1.0, 100.0, Until::Step("X".to_owned()))).unwrap_err().to_string();
        assert_eq!(error, "technology complete: there is no step X; its steps are R, S, F");
    }

    /// 20 A/cm² are allowed: 20 A need 100 mm², 10 A need 50 mm², 4 A need 20 mm².
    #[test]
    fn a_small_area_takes_less_current() {
        let technology = complete();
        let on = |area| choose(&technology, &burn(1000.0, area, Until::Vdi(20.0))).map(|choice| names(&choice));
        assert_eq!([100.0, 99.0, 50.0, 49.0, 20.0].map(|area| on(area).unwrap()), ["RSF", "SF", "SF", "F", "F"]);
        let error = on(16.0).unwrap_err();
        assert!(error.to_string().contains("step F has 25.00 A/cm² on this area, 20.00 are allowed"), "{error}");
        // A rough finish on a small area is burned with a finer step, unless the step is named.
        let rough = choose(&technology, &burn(1000.0, 50.0, Until::Vdi(36.0))).unwrap();
        assert_eq!(names(&rough), "S");
        assert!(choose(&technology, &burn(1000.0, 50.0, Until::Step("R".to_owned()))).is_err());
    }

    #[test]
    fn no_gap_is_greater_than_the_undersize() {
        let technology = complete();
        let with = |undersize| {
            let burn = Burn { undersize_mm: Some(undersize), ..burn(1000.0, 100.0, Until::Vdi(20.0)) };
            choose(&technology, &burn).map(|choice| names(&choice))
        };
        assert_eq!([0.2, 0.15, 0.05].map(|undersize| with(undersize).unwrap()), ["RSF", "SF", "F"]);
        assert!(matches!(with(0.04), Err(BurningError::GapBeyondUndersize { .. })));
    }

    #[test]
    fn layers_go_to_the_finest_steps_first() {
        let technology = complete();
        let volumes = |volume, burned| {
            let burn = Burn { burned_area_mm2: burned, ..burn(volume, 100.0, Until::Vdi(20.0)) };
            let choice = choose(&technology, &burn).unwrap();
            assert_eq!(choice.burned_area_given, burned.is_some());
            choice.steps.iter().map(|chosen| chosen.volume_mm3.unwrap()).collect::<Vec<_>>()
        };
        // S gets 0.1 mm over the area, F 0.05 mm.
        assert_eq!(volumes(1000.0, None), [985.0, 10.0, 5.0]);
        assert_eq!(volumes(1000.0, Some(300.0)), [955.0, 30.0, 15.0]);
        assert_eq!(volumes(12.0, None), [7.0, 5.0]);
        assert_eq!(volumes(4.0, None), [4.0]);
        assert_eq!(volumes(0.0, None), [0.0]);
    }

    #[test]
    fn what_is_missing_is_named() {
        let text = |list: &[Missing]| list.iter().map(ToString::to_string).collect::<Vec<_>>().join("; ");
        let asked = Burn { undersize_mm: Some(1.0), ..burn(1000.0, 100.0, Until::Vdi(20.0)) };
        let without = |change: fn(&mut Step)| {
            let mut technology = complete();
            technology.step.iter_mut().take(2).for_each(change);
            let choice = choose(&technology, &asked).unwrap();
            let volumes: Vec<_> = choice.steps.iter().map(|chosen| chosen.volume_mm3).collect();
            (volumes, text(&choice.missing), text(&choice.not_considered))
        };
        let all = [Some(985.0), Some(10.0), Some(5.0)].to_vec();
        assert_eq!(without(|_| {}), (all.clone(), String::new(), String::new()));
        let of_both = |figure: &str| format!("{figure} of step R is not given; {figure} of step S is not given");
        assert_eq!(without(|s| s.vdi = None), (all.clone(), String::new(), of_both("finish")));
        assert_eq!(without(|s| s.ip_a = None), (all.clone(), String::new(), of_both("peak current")));
        let density = of_both("greatest current density");
        assert_eq!(without(|s| s.max_density_a_cm2 = None), (all.clone(), String::new(), density));
        assert_eq!(without(|s| s.gap_side_mm = None), (all, String::new(), of_both("side gap")));
        let stock = of_both("stock left for the next step");
        assert_eq!(without(|s| s.stock_next_mm = None), ([None; 3].to_vec(), stock, String::new()));
    }

    #[test]
    fn a_burn_is_read_and_written() {
        let text = "volume_mm3 = 10.0\nfrontal_area_mm2 = 5.0\n\n[until]\nra_um = 1.6\n";
        let read: Burn = toml::from_str(text).unwrap();
        assert_eq!(read, burn(10.0, 5.0, Until::RaUm(1.6)));
        assert_eq!(toml::to_string(&read).unwrap(), text, "what is not given is not written");
        assert!(toml::from_str::<Burn>(&text.replace("ra_um", "shine")).is_err());
    }

    #[test]
    fn without_any_finish_there_is_no_choice() {
        let mut technology = complete();
        technology.step.iter_mut().for_each(|step| step.vdi = None);
        let choice = choose(&technology, &burn(1.0, 100.0, Until::Vdi(30.0))).unwrap();
        assert!(choice.steps.is_empty());
        assert_eq!(choice.missing.len(), 3);
        assert_eq!(choice.missing[0].to_string(), "finish of step R is not given");
        // The roughness does for the class.
        technology.step[2].ra_um = Some(1.0);
        assert_eq!(until(&technology, Until::Vdi(30.0)), "RSF");
    }

    #[test]
    fn a_burn_outside_the_technology_is_reported() {
        let technology = complete();
        let deep = Burn { depth_to_width: Some(6.0), ..burn(1000.0, 2000.0, Until::Vdi(20.0)) };
        let said: Vec<_> = choose(&technology, &deep).unwrap().outside.iter().map(ToString::to_string).collect();
        assert_eq!(said.len(), 2);
        assert!(said[0].contains("2000.00 mm²; the technology is valid from 10 to 1000 mm²"), "{said:?}");
        assert!(said[1].contains("depth to width 6.00; the technology is valid up to 5"), "{said:?}");
        // Without a range nothing is outside, and without a depth nothing is too deep.
        let open = Technology { area_range_mm2: None, greatest_depth_to_width: None, ..complete() };
        assert!(choose(&open, &deep).unwrap().outside.is_empty());
        assert_eq!(choose(&technology, &Burn { depth_to_width: None, ..deep }).unwrap().outside.len(), 1);
        let shallow = Burn { depth_to_width: Some(5.0), ..burn(1000.0, 1000.0, Until::Vdi(20.0)) };
        assert!(choose(&technology, &shallow).unwrap().outside.is_empty());
        for wrong in [f64::NAN, -1.0, f64::INFINITY] {
            assert!(choose(&technology, &burn(wrong, 100.0, Until::Vdi(20.0))).is_err());
            assert!(choose(&technology, &burn(1.0, wrong, Until::Vdi(20.0))).is_err());
            assert!(choose(&technology, &burn(1.0, 100.0, Until::RaUm(wrong))).is_err());
        }
    }

    proptest! {
        /// The volumes of the steps add up to the volume of the burn.
        #[test]
        fn volume_is_conserved(volume in 0.0..1e6, area in 100.0..1e4, burned in prop::option::of(1.0..1e5)) {
            let technology = complete();
            let burn = Burn { burned_area_mm2: burned, ..burn(volume, area, Until::Vdi(20.0)) };
            let choice = choose(&technology, &burn).unwrap();
            let sum: f64 = choice.steps.iter().map(|chosen| chosen.volume_mm3.unwrap()).sum();
            prop_assert!((sum - volume).abs() <= 1e-12 * volume);
        }
    }
}
