//! Technology tables: steps of a generator with their current, pulse, gap, rate and wear, and finished burns.
//!
//! Every figure that a supplier may not know is optional. A missing figure stays missing.

use std::collections::HashSet;
use std::fmt;

use files::{Invalid, TomlFile, Validate};
use serde::{Deserialize, Serialize};

use crate::rules;

/// The most technologies of a file.
const MOST_TECHNOLOGIES: usize = 256;
/// The most steps of a technology.
const MOST_STEPS: usize = 64;
/// The most finished burns of a file.
const MOST_CALIBRATIONS: usize = 10_000;
/// The greatest difference between the VDI class and the roughness of a step (VDI 3400): classes are whole numbers.
const FINISH_ROUNDING_VDI: f64 = 1.0;

/// The [built-in technologies](crate::defaults::standard), or those of a supplier, with the burns that were measured.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct TechnologyFile {
    /// The technologies, in any order.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub technology: Vec<Technology>,
    /// Finished burns, by which the estimates are scaled.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub calibration: Vec<Calibration>,
}

/// Technology file as TOML.
pub const TECHNOLOGY_FILE: TomlFile<TechnologyFile> = TomlFile::new("technology table");

/// A technology: one electrode material in one workpiece on one generator, as steps from rough to fine.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Technology {
    /// Identifier, unique in a file, as calibrations and documents name it.
    pub id: String,
    /// Title in lists.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub title: String,
    /// Machine.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub machine: Option<String>,
    /// Generator.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub generator: Option<String>,
    /// Origin of the figures, and the range in which they are valid.
    pub source: String,
    /// Licence of the figures.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub licence: Option<String>,
    /// Foundation of the figures; the weakest basis, where they differ.
    pub basis: Basis,
    /// Date of the figures, as year-month-day.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub date: Option<String>,
    /// Material of the electrode.
    pub electrode_material: ElectrodeMaterial,
    /// Grade of the electrode's material, such as the grain size of graphite.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub electrode_grade: Option<String>,
    /// Material of the workpiece.
    pub workpiece: String,
    /// Polarity of the electrode.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub polarity: Option<Polarity>,
    /// Dielectric fluid.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub dielectric: Option<String>,
    /// Flushing.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub flushing: Option<String>,
    /// Least and greatest frontal area for which the figures are valid (mm²).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub area_range_mm2: Option<[f64; 2]>,
    /// Greatest ratio of depth to width for which the figures are valid.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub greatest_depth_to_width: Option<f64>,
    /// The steps, from rough to fine.
    #[serde(default)]
    pub step: Vec<Step>,
}

/// Foundation of figures.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Basis {
    /// Measured on the machine.
    Measured,
    /// Stated by the vendor.
    Vendor,
    /// Fitted to tables of others.
    Fitted,
    /// Assumed.
    Assumed,
}

impl fmt::Display for Basis {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(match self {
            Self::Measured => "measured",
            Self::Vendor => "vendor",
            Self::Fitted => "fitted",
            Self::Assumed => "assumed",
        })
    }
}

/// Material of an electrode.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ElectrodeMaterial {
    /// Graphite.
    Graphite,
    /// Copper.
    Copper,
    /// Copper-tungsten.
    CopperTungsten,
    /// Another material; the grade says which.
    Other,
}

/// Polarity of the electrode against the workpiece.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Polarity {
    /// The electrode is the anode.
    Positive,
    /// The electrode is the cathode.
    Negative,
}

/// A step of a technology: one setting of the generator.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Step {
    /// Name, unique in the technology.
    pub name: String,
    /// Code by which the machine calls this setting.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub vendor_code: Option<String>,
    /// Finish that the step leaves (VDI 3400).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub vdi: Option<f64>,
    /// Arithmetic mean roughness that the step leaves (µm).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ra_um: Option<f64>,
    /// Peak current (A).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ip_a: Option<f64>,
    /// Pulse duration (µs).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub on_us: Option<f64>,
    /// Pause between pulses (µs).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub off_us: Option<f64>,
    /// Servo voltage (V).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub servo_v: Option<f64>,
    /// Open-circuit voltage (V).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub open_v: Option<f64>,
    /// Spark gap at the sides (mm a side).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gap_side_mm: Option<f64>,
    /// Spark gap at the front (mm).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gap_front_mm: Option<f64>,
    /// Removal rate (mm³ per minute), without jumps.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rate_mm3_min: Option<f64>,
    /// Frontal area at which the rate is stated (mm²).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub at_area_mm2: Option<f64>,
    /// Greatest peak current per frontal area (A/cm²).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub max_density_a_cm2: Option<f64>,
    /// Volume that the electrode loses, in percent of the volume that it removes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub wear_percent: Option<f64>,
    /// Wear of the electrode's edges in one burn (mm).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub corner_wear_mm: Option<f64>,
    /// Radius of the orbit (mm).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub orbit_mm: Option<f64>,
    /// Thickness of the layer that the step leaves for the next step (mm).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stock_next_mm: Option<f64>,
    /// Height of a jump (mm).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub jump_mm: Option<f64>,
    /// Time of burning between two jumps (s).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub jump_every_s: Option<f64>,
    /// Speed of a jump, up and down (mm per minute).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub jump_speed: Option<f64>,
    /// Thickness of the recast layer (µm).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub recast_um: Option<f64>,
}

/// A finished burn: what was estimated and what was measured.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Calibration {
    /// Id of the technology.
    pub technology: String,
    /// Estimated minutes of burning with jumps, without set-up and changing, not calibrated.
    pub estimated_min: f64,
    /// Measured minutes of the same.
    pub measured_min: f64,
    /// Date of the burn, as year-month-day.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub date: Option<String>,
    /// Origin of the measurement.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub source: Option<String>,
}

impl Technology {
    /// The step of this name.
    pub fn step_named(&self, name: &str) -> Option<&Step> {
        self.step.iter().find(|step| step.name == name)
    }

    /// Title, or the id where there is none.
    pub fn label(&self) -> &str {
        if self.title.is_empty() { &self.id } else { &self.title }
    }
}

impl Step {
    /// Finish (VDI 3400): the class, or that of the roughness where only this is given.
    pub fn finish_vdi(&self) -> Option<f64> {
        self.vdi.or_else(|| self.ra_um.and_then(|ra| rules::vdi_of_ra(ra).ok()))
    }
}

impl TechnologyFile {
    /// The technology of this id.
    pub fn get(&self, id: &str) -> Option<&Technology> {
        self.technology.iter().find(|technology| technology.id == id)
    }

    /// The technologies of an electrode material for a workpiece, in the order of the file. The case of the workpiece's
    /// name does not matter.
    pub fn suitable(&self, material: ElectrodeMaterial, workpiece: &str) -> Vec<&Technology> {
        let wanted = workpiece.trim().to_lowercase();
        let suits = |t: &&Technology| t.electrode_material == material && t.workpiece.trim().to_lowercase() == wanted;
        self.technology.iter().filter(suits).collect()
    }

    /// The finished burns of a technology.
    pub fn calibrations_of<'a>(&'a self, id: &'a str) -> impl Iterator<Item = &'a Calibration> {
        self.calibration.iter().filter(move |burn| burn.technology == id)
    }
}

impl Validate for TechnologyFile {
    fn validate(&self) -> Result<(), Invalid> {
        at_most("technology", self.technology.len(), MOST_TECHNOLOGIES)?;
        at_most("calibration", self.calibration.len(), MOST_CALIBRATIONS)?;
        let mut ids = HashSet::new();
        for (i, technology) in self.technology.iter().enumerate() {
            let place = |problem: Invalid| problem.within(&format!("technology[{i}]"));
            technology.validate().map_err(place)?;
            if !ids.insert(technology.id.as_str()) {
                return Err(place(Invalid::new("id", &technology.id, "another technology has it; give each its own")));
            }
        }
        for (i, burn) in self.calibration.iter().enumerate() {
            let place = |problem: Invalid| problem.within(&format!("calibration[{i}]"));
            burn.validate().map_err(place)?;
            if !ids.contains(burn.technology.as_str()) {
                let remedy = "no technology of this file has this id; correct it";
                return Err(place(Invalid::new("technology", &burn.technology, remedy)));
            }
        }
        Ok(())
    }
}

impl Validate for Technology {
    fn validate(&self) -> Result<(), Invalid> {
        not_empty("id", &self.id)?;
        not_empty("source", &self.source)?;
        not_empty("workpiece", &self.workpiece)?;
        if let Some([least, greatest]) = self.area_range_mm2 {
            Invalid::unless_within("area_range_mm2[0]", least, AREA_MM2, "mm²")?;
            Invalid::unless_within("area_range_mm2[1]", greatest, [least, AREA_MM2[1]], "mm²")?;
        }
        within("greatest_depth_to_width", self.greatest_depth_to_width, [0.01, 1000.0], "")?;
        let count = self.step.len();
        if count == 0 {
            return Err(Invalid::of("step", "there is no step; give at least one as [[technology.step]]"));
        }
        at_most("step", count, MOST_STEPS)?;
        let mut names = HashSet::new();
        let mut finest: Option<f64> = None;
        for (i, step) in self.step.iter().enumerate() {
            let place = |problem: Invalid| problem.within(&format!("step[{i}]"));
            step.validate().map_err(place)?;
            if !names.insert(step.name.as_str()) {
                return Err(place(Invalid::new("name", &step.name, "another step has it; give each its own")));
            }
            let Some(vdi) = step.finish_vdi() else { continue };
            if finest.is_some_and(|before| vdi > before) {
                let key = if step.vdi.is_some() { "vdi" } else { "ra_um" };
                let value = step.vdi.or(step.ra_um).unwrap_or(vdi);
                return Err(place(Invalid::new(
                    key,
                    value,
                    "a step before it is finer; list steps from rough to fine",
                )));
            }
            finest = Some(vdi);
        }
        Ok(())
    }
}

/// Frontal areas that are possible (mm²).
pub(crate) const AREA_MM2: [f64; 2] = [1e-3, 1e7];

impl Validate for Step {
    fn validate(&self) -> Result<(), Invalid> {
        not_empty("name", &self.name)?;
        for (key, value, range, unit) in [
            ("vdi", self.vdi, rules::VDI_RANGE, "VDI"),
            ("ra_um", self.ra_um, rules::RA_RANGE_UM, "µm"),
            ("ip_a", self.ip_a, [1e-3, 2000.0], "A"),
            ("on_us", self.on_us, [1e-3, 1e5], "µs"),
            ("off_us", self.off_us, [1e-3, 1e5], "µs"),
            ("servo_v", self.servo_v, [0.0, 1000.0], "V"),
            ("open_v", self.open_v, [1.0, 1000.0], "V"),
            ("gap_side_mm", self.gap_side_mm, [1e-4, 5.0], "mm"),
            ("gap_front_mm", self.gap_front_mm, [1e-4, 5.0], "mm"),
            ("rate_mm3_min", self.rate_mm3_min, [1e-6, 1e5], "mm³/min"),
            ("at_area_mm2", self.at_area_mm2, AREA_MM2, "mm²"),
            ("max_density_a_cm2", self.max_density_a_cm2, [1e-3, 1e4], "A/cm²"),
            ("wear_percent", self.wear_percent, [0.0, 1000.0], "%"),
            ("corner_wear_mm", self.corner_wear_mm, [0.0, 50.0], "mm"),
            ("orbit_mm", self.orbit_mm, [0.0, 50.0], "mm"),
            ("stock_next_mm", self.stock_next_mm, [1e-4, 50.0], "mm"),
            ("jump_mm", self.jump_mm, [0.0, 1000.0], "mm"),
            ("jump_every_s", self.jump_every_s, [1e-2, 1e5], "s"),
            ("jump_speed", self.jump_speed, [1.0, 1e5], "mm/min"),
            ("recast_um", self.recast_um, [0.0, 1000.0], "µm"),
        ] {
            within(key, value, range, unit)?;
        }
        if let (Some(vdi), Some(ra)) = (self.vdi, self.ra_um)
            && let Ok(of_ra) = rules::vdi_of_ra(ra)
            && (vdi - of_ra).abs() > FINISH_ROUNDING_VDI
        {
            return Err(Invalid::new("ra_um", ra, format!("is VDI {of_ra:.1}, but vdi is {vdi}; correct one of them")));
        }
        Ok(())
    }
}

impl Validate for Calibration {
    fn validate(&self) -> Result<(), Invalid> {
        not_empty("technology", &self.technology)?;
        Invalid::unless_within("estimated_min", self.estimated_min, [1e-3, 1e7], "min")?;
        Invalid::unless_within("measured_min", self.measured_min, [1e-3, 1e7], "min")
    }
}

/// Refuses a value that is given and not within the range.
pub(crate) fn within(key: &str, value: Option<f64>, range: [f64; 2], unit: &str) -> Result<(), Invalid> {
    value.map_or(Ok(()), |value| Invalid::unless_within(key, value, range, unit))
}

fn not_empty(key: &str, text: &str) -> Result<(), Invalid> {
    if text.trim().is_empty() { Err(Invalid::of(key, "is empty; give one")) } else { Ok(()) }
}

fn at_most(key: &str, count: usize, most: usize) -> Result<(), Invalid> {
    if count > most {
        return Err(Invalid::of(key, format!("there are {count}; at most {most} are possible")));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use files::FileError;

    use super::*;

    const HEAD: &str = "[[technology]]\nid = \"a\"\nsource = \"test\"\nbasis = \"vendor\"\n\
                        electrode_material = \"copper-tungsten\"\nworkpiece = \"steel\"\n";

    fn read(text: &str) -> Result<TechnologyFile, FileError> {
        TECHNOLOGY_FILE.parse(text, Path::new("t.toml"))
    }

    fn refused(text: &str) -> String {
        read(text).unwrap_err().to_string()
    }

    #[test]
    fn every_key_is_read_and_written_again() {
        let text = format!(
            "{HEAD}title = \"t\"\nmachine = \"m\"\ngenerator = \"g\"\nlicence = \"CC0\"\ndate = \"2025-01-31\"\n\
             electrode_grade = \"25/75\"\npolarity = \"negative\"\ndielectric = \"oil\"\nflushing = \"through\"\n\
             area_range_mm2 = [10.0, 100.0]\ngreatest_depth_to_width = 4.0\n[[technology.step]]\nname = \"S1\"\n\
             vendor_code = \"E31\"\nvdi = 30.0\nra_um = 3.2\nip_a = 14.0\non_us = 28.0\noff_us = 20.0\nservo_v = 60.0\n\
             open_v = 120.0\ngap_side_mm = 0.1\ngap_front_mm = 0.09\nrate_mm3_min = 20.0\nat_area_mm2 = 50.0\n\
             max_density_a_cm2 = 12.0\nwear_percent = 1.0\ncorner_wear_mm = 0.03\norbit_mm = 0.1\n\
             stock_next_mm = 0.02\njump_mm = 2.0\njump_every_s = 1.0\njump_speed = 4000.0\nrecast_um = 8.0\n\
             [[calibration]]\ntechnology = \"a\"\nestimated_min = 10.0\nmeasured_min = 12.0\ndate = \"2025-02-01\"\n\
             source = \"shop\"\n"
        );
        let file = read(&text).unwrap();
        let technology = file.get("a").unwrap();
        assert_eq!((technology.label(), technology.basis.to_string().as_str()), ("t", "vendor"));
        assert_eq!(technology.polarity, Some(Polarity::Negative));
        assert_eq!(file.suitable(ElectrodeMaterial::CopperTungsten, " Steel"), [technology]);
        assert!(file.suitable(ElectrodeMaterial::Copper, "steel").is_empty());
        assert_eq!(file.calibrations_of("a").count(), 1);
        let written = toml::to_string(&file).unwrap();
        for key in text.lines().filter_map(|line| line.split_once(" = ")).map(|(key, _)| key) {
            assert!(written.contains(&format!("{key} = ")), "{key}");
        }
        assert_eq!(read(&written).unwrap(), file);
    }

    #[test]
    fn what_a_table_does_not_have_stays_missing() {
        let file = read(&format!("{HEAD}[[technology.step]]\nname = \"only\"\n")).unwrap();
        assert_eq!(file.technology[0].step[0], Step { name: "only".to_owned(), ..Step::default() });
        assert_eq!(file.technology[0].step[0].finish_vdi(), None);
        let written = toml::to_string(&file).unwrap();
        assert_eq!(written.lines().filter(|line| line.contains('=')).count(), 6, "{written}");
        assert!(!written.contains('0'), "{written}");
    }

    #[test]
    fn impossible_figures_are_refused_with_place_and_remedy() {
        let step = "[[technology.step]]\nname = \"R\"\n";
        for (wrong, said) in [
            ("gap_side_mm = 0.0", "technology[0].step[0].gap_side_mm is 0: must be from 0.0001 to 5 mm"),
            ("rate_mm3_min = 0.0", "step[0].rate_mm3_min is 0"),
            ("rate_mm3_min = nan", "step[0].rate_mm3_min is NaN"),
            ("on_us = inf", "step[0].on_us is inf"),
            ("wear_percent = -1.0", "step[0].wear_percent is -1"),
            ("jump_every_s = 0.0", "step[0].jump_every_s is 0"),
            ("stock_next_mm = 0.0", "step[0].stock_next_mm is 0"),
            ("vdi = 30.0\nra_um = 1.0", "is VDI 20.0, but vdi is 30"),
            ("colour = 1", "unknown field `colour`"),
        ] {
            let text = refused(&format!("{HEAD}{step}{wrong}\n"));
            assert!(text.contains(said), "{text}");
        }
        for (text, said) in [
            (HEAD.to_owned(), "technology[0].step: there is no step"),
            (format!("{HEAD}{step}{step}"), "step[1].name is R: another step has it"),
            (format!("{HEAD}{step}{HEAD}{step}"), "technology[1].id is a: another technology has it"),
            (format!("{HEAD}area_range_mm2 = [5.0, 2.0]\n{step}"), "area_range_mm2[1] is 2"),
            (
                format!("{HEAD}{step}ra_um = 1.0\n[[technology.step]]\nname = \"S\"\nvdi = 25.0\n"),
                "step[1].vdi is 25: a step before it is finer",
            ),
            (
                format!("{HEAD}{step}[[calibration]]\ntechnology = \"b\"\nestimated_min = 1.0\nmeasured_min = 1.0\n"),
                "calibration[0].technology is b: no technology",
            ),
            (
                format!("{HEAD}{step}[[calibration]]\ntechnology = \"a\"\nestimated_min = 0.0\nmeasured_min = 1.0\n"),
                "calibration[0].estimated_min is 0",
            ),
            (HEAD.replace("source = \"test\"", "source = \" \""), "technology[0].source: is empty"),
            (HEAD.replace("vendor", "guessed"), "unknown variant `guessed`"),
        ] {
            assert!(refused(&text).contains(said), "{}", refused(&text));
        }
    }
}
