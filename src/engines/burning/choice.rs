//! Choice of the steps that an electrode burns with, and the volume that each step removes.

use std::fmt;

use files::{Invalid, Validate};
use serde::{Deserialize, Serialize};

use crate::technology::{AREA_MM2, Step, Technology, within};
use crate::{BurningError, MOST_ROWS, rules};

/// Difference between a wanted finish and that of a step that counts as the same (VDI 3400): the tables of the standard
/// round the roughness of a class.
const FINISH_TOLERANCE_VDI: f64 = 0.2;

/// Volumes that are possible (mm³).
const VOLUME_MM3: [f64; 2] = [0.0, 1e9];
/// Greatest difference of two lengths that count as the same (mm): a sum of decimal fractions is rounded.
const ROUNDING_MM: f64 = 1e-9;

/// Task of one electrode in one place.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Burn {
    /// Area of the burned surface (mm²), from which later steps remove a layer; the frontal area where it is not known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub burned_area_mm2: Option<f64>,
    /// Undersize of the electrode (mm a side); steps whose side gap and orbit reach beyond it are not taken.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub undersize_mm: Option<f64>,
    /// Ratio of depth to width of the cavity.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub depth_to_width: Option<f64>,
    /// Name of the step at which burning starts, as of a finishing electrode; the first one of the technology if none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub from: Option<String>,
    /// End of burning.
    pub until: Until,
    /// The burn along its direction or path, cut into pieces.
    pub pieces: Vec<Piece>,
}

/// Piece of a burn with one frontal area.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Piece {
    /// Volume to remove (mm³): the stock that the electrodes before have left.
    pub volume_mm3: f64,
    /// Area of the electrode in the stock, seen along the burn or the path (mm²).
    pub frontal_area_mm2: f64,
}

impl Burn {
    /// A burn with one frontal area, from the first step of a technology on.
    pub fn single(volume_mm3: f64, frontal_area_mm2: f64, until: Until) -> Self {
        let pieces = vec![Piece { volume_mm3, frontal_area_mm2 }];
        Self { burned_area_mm2: None, undersize_mm: None, depth_to_width: None, from: None, until, pieces }
    }

    /// Volume of all pieces (mm³).
    pub fn volume_mm3(&self) -> f64 {
        self.pieces.iter().map(|piece| piece.volume_mm3).sum()
    }

    /// Least and greatest frontal area of the pieces (mm²).
    fn areas_mm2(&self) -> [f64; 2] {
        let areas = self.pieces.iter().map(|piece| piece.frontal_area_mm2);
        areas.fold([f64::INFINITY, 0.0], |[least, greatest], area| [least.min(area), greatest.max(area)])
    }

    /// Greatest frontal area of the pieces (mm²).
    pub fn frontal_area_mm2(&self) -> f64 {
        let [_, greatest] = self.areas_mm2();
        greatest
    }
}

/// End of burning.
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
        let count = self.pieces.len();
        if count == 0 || count > MOST_ROWS {
            return Err(Invalid::of("pieces", format!("there are {count}; from 1 to {MOST_ROWS} are possible")));
        }
        for (i, piece) in self.pieces.iter().enumerate() {
            piece.validate().map_err(|problem| problem.within(&format!("pieces[{i}]")))?;
        }
        Invalid::unless_within("volume of all pieces", self.volume_mm3(), VOLUME_MM3, "mm³")?;
        within("burned_area_mm2", self.burned_area_mm2, AREA_MM2, "mm²")?;
        within("undersize_mm", self.undersize_mm, rules::UNDERSIZE_MM, "mm")?;
        within("depth_to_width", self.depth_to_width, [0.0, 1e4], "")?;
        match &self.until {
            Until::Vdi(vdi) => Invalid::unless_within("until.vdi", *vdi, rules::VDI_RANGE, "VDI"),
            Until::RaUm(ra) => Invalid::unless_within("until.ra_um", *ra, rules::RA_RANGE_UM, "µm"),
            Until::Step(_) => Ok(()),
        }
    }
}

impl Validate for Piece {
    fn validate(&self) -> Result<(), Invalid> {
        Invalid::unless_within("volume_mm3", self.volume_mm3, VOLUME_MM3, "mm³")?;
        Invalid::unless_within("frontal_area_mm2", self.frontal_area_mm2, AREA_MM2, "mm²")
    }
}

/// A figure of a step, of a technology or of a burn that a result needs.
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
    /// Radius of the orbit.
    Orbit,
    /// Removal rate.
    Rate,
    /// Area at which the removal rate is stated.
    RateArea,
    /// Layer left for the next step.
    StockNext,
    /// Area of the burned surface.
    BurnedArea,
    /// Ratio of depth to width of the burn, or its greatest value in the technology.
    Depth,
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
            Self::Orbit => "orbit",
            Self::Rate => "rate",
            Self::RateArea => "area of the rate",
            Self::StockNext => "stock left for the next step",
            Self::BurnedArea => "area of the burned surface",
            Self::Depth => "depth to width or its limit",
            Self::Jump => "jump",
            Self::Wear => "wear",
            Self::CornerWear => "corner wear",
        })
    }
}

/// A figure that is not given. Its text reads `rate of steps R1, S2 is not given`.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Missing {
    /// The figure.
    pub figure: Figure,
    /// Names of the steps that lack it; empty for a figure of the burn or of the whole technology.
    pub steps: Vec<String>,
}

impl Missing {
    /// Adds a step to those that lack a figure.
    pub(crate) fn add(list: &mut Vec<Self>, figure: Figure, step: &Step) {
        let name = step.name.clone();
        match list.iter_mut().find(|missing| missing.figure == figure) {
            Some(missing) if missing.steps.contains(&name) => {}
            Some(missing) => missing.steps.push(name),
            None => list.push(Self { figure, steps: vec![name] }),
        }
    }

    /// A figure that belongs to no step.
    const fn of_burn(figure: Figure) -> Self {
        Self { figure, steps: Vec::new() }
    }
}

impl fmt::Display for Missing {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self.steps.as_slice() {
            [] => write!(f, "{} is not given", self.figure),
            [step] => write!(f, "{} of step {step} is not given", self.figure),
            steps => write!(f, "{} of steps {} is not given", self.figure, steps.join(", ")),
        }
    }
}

/// A burn for which the figures of the technology are not valid.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Outside {
    /// Frontal areas are smaller or greater than those of the technology (mm²).
    Area {
        /// Least and greatest frontal area of the burn.
        areas_mm2: [f64; 2],
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
            Self::Area { areas_mm2: [small, large], range_mm2: [least, greatest] } => {
                write!(f, "frontal area {small:.2}")?;
                if small < large {
                    write!(f, " to {large:.2}")?;
                }
                write!(f, " mm²; the technology is valid from {least} to {greatest} mm²")
            }
            Self::DepthToWidth { ratio, greatest } => {
                write!(f, "depth to width {ratio:.2}; the technology is valid up to {greatest}")
            }
        }
    }
}

/// A step with the volume that it removes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ChosenStep<'a> {
    /// The step.
    pub step: &'a Step,
    /// Volume that it removes (mm³); none if the layer that it gets is not known.
    pub volume_mm3: Option<f64>,
}

/// The steps that an electrode burns with.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Choice<'a> {
    /// Technology of the steps.
    pub technology: &'a Technology,
    /// The burn.
    pub burn: &'a Burn,
    /// The steps, from rough to fine; none if figures that decide are missing.
    pub steps: Vec<ChosenStep<'a>>,
    /// Stock that the last step leaves on the walls (mm): undersize less side gap and orbit, as far as the orbit is known;
    /// none if undersize or side gap is not known.
    pub wall_stock_mm: Option<f64>,
    /// Figures without which steps or volumes are not known.
    pub missing: Vec<Missing>,
    /// Figures that the choice does without.
    pub not_considered: Vec<Missing>,
    /// Ranges of the technology that the burn leaves.
    pub outside: Vec<Outside>,
}

/// Chooses the steps for a burn.
///
/// The last step is the first one that reaches the finish, or the one that is named. Of the steps from the start to it
/// those are taken whose current density the greatest frontal area allows and whose side gap and orbit together are
/// within the undersize. If the last step does not suit the burn, a finer one takes its place, unless it was named.
///
/// Each step leaves a layer for the next one; where steps between them are not taken, their layers are left as well. The
/// finest steps get their layers first; roughing gets the rest. A step for which nothing is left is not burned.
///
/// # Errors
/// [`BurningError`] if the burn or the technology is not possible, if no step is fine enough, or if the last step does
/// not suit the burn.
pub(crate) fn choose<'a>(technology: &'a Technology, burn: &'a Burn) -> Result<Choice<'a>, BurningError> {
    technology.validate()?;
    burn.validate()?;
    let mut choice = Choice {
        technology,
        burn,
        steps: Vec::new(),
        wall_stock_mm: None,
        missing: Vec::new(),
        not_considered: Vec::new(),
        outside: outside(technology, burn),
    };
    if burn.depth_to_width.is_none() || technology.greatest_depth_to_width.is_none() {
        choice.not_considered.push(Missing::of_burn(Figure::Depth));
    }
    let first = burn.from.as_ref().map_or(Ok(0), |name| named(technology, name))?;
    let last = match &burn.until {
        Until::Step(name) => Some(named(technology, name)?),
        Until::Vdi(vdi) => fine_enough(first, *vdi, &mut choice)?,
        Until::RaUm(ra) => fine_enough(first, rules::vdi_of_ra(*ra)?, &mut choice)?,
    };
    let Some(mut last) = last else { return Ok(choice) };
    if let (Some(from), Until::Step(until)) = (&burn.from, &burn.until)
        && last < first
    {
        let remedy = format!("burning ends at step {until}, before it; start at that step or at one before it");
        return Err(Invalid::new("from", from, remedy).into());
    }
    if !matches!(burn.until, Until::Step(_)) {
        last = finer_that_suits(technology, burn, last)?;
    }
    let mut taken: Vec<(usize, &Step)> = Vec::new();
    for (i, step) in technology.step.iter().enumerate().take(last + 1).skip(first) {
        match suits(technology, burn, step) {
            Ok(()) => taken.push((i, step)),
            Err(reason) if i == last => return Err(reason),
            Err(_) => {}
        }
    }
    share_volume(&taken, &mut choice);
    for chosen in choice.steps.clone() {
        name_unchecked(chosen.step, &mut choice);
    }
    let finest = taken.last().and_then(|(_, step)| step.gap_side_mm.map(|gap| gap + step.orbit_mm.unwrap_or(0.0)));
    choice.wall_stock_mm = burn.undersize_mm.zip(finest).map(|(undersize, reach)| (undersize - reach).max(0.0));
    Ok(choice)
}

fn outside(technology: &Technology, burn: &Burn) -> Vec<Outside> {
    let areas_mm2 = burn.areas_mm2();
    let [small, large] = areas_mm2;
    let area = technology.area_range_mm2.filter(|[least, greatest]| small < *least || large > *greatest);
    let depth = burn.depth_to_width.zip(technology.greatest_depth_to_width).filter(|(ratio, most)| ratio > most);
    let area = area.map(|range_mm2| Outside::Area { areas_mm2, range_mm2 });
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

/// The first step from `start` on that is as fine as wanted; none, with the figures that are missing, if steps without a
/// finish could be.
fn fine_enough(start: usize, wanted_vdi: f64, choice: &mut Choice) -> Result<Option<usize>, BurningError> {
    let technology = choice.technology;
    let is_fine = |step: &Step| step.finish_vdi().is_some_and(|vdi| vdi <= wanted_vdi + FINISH_TOLERANCE_VDI);
    let steps = technology.step.iter().enumerate().skip(start);
    let first = steps.clone().find(|(_, step)| is_fine(step)).map(|(i, _)| i);
    let finest = technology.step.iter().filter_map(Step::finish_vdi).next_back();
    // A rougher step without a finish may do as well: the one that is known to do is taken.
    let list = if first.is_some() { &mut choice.not_considered } else { &mut choice.missing };
    for (_, step) in steps.take_while(|(i, _)| first.is_none_or(|first| *i < first)) {
        if step.finish_vdi().is_none() {
            Missing::add(list, Figure::Finish, step);
        }
    }
    match finest {
        Some(finest_vdi) if first.is_none() && choice.missing.is_empty() => {
            Err(BurningError::FinishNotReached { technology: technology.id.clone(), wanted_vdi, finest_vdi })
        }
        _ => Ok(first),
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

/// Whether the current density of a step, and its side gap and orbit together, are within what the burn allows, as far as
/// they are known.
fn suits(technology: &Technology, burn: &Burn, step: &Step) -> Result<(), BurningError> {
    if let (Some(current), Some(limit_a_cm2)) = (step.ip_a, step.max_density_a_cm2) {
        let density_a_cm2 = rules::density_a_cm2(current, burn.frontal_area_mm2());
        if density_a_cm2 > limit_a_cm2 {
            let [technology, step] = [technology.id.clone(), step.name.clone()];
            return Err(BurningError::CurrentDensity { technology, step, density_a_cm2, limit_a_cm2 });
        }
    }
    let [gap_mm, orbit_mm] = [step.gap_side_mm, step.orbit_mm].map(|length| length.unwrap_or(0.0));
    match burn.undersize_mm {
        Some(undersize_mm) if gap_mm + orbit_mm > undersize_mm + ROUNDING_MM => {
            let [technology, step] = [technology.id.clone(), step.name.clone()];
            Err(BurningError::ReachBeyondUndersize { technology, step, gap_mm, orbit_mm, undersize_mm })
        }
        _ => Ok(()),
    }
}

/// Names the figures of a step without which something about the burn could not be checked.
///
/// The current must be checked against the area in one way at least: by its density, by the areas of the technology, or
/// by the area of the rate.
fn name_unchecked(step: &Step, choice: &mut Choice) {
    let figure = match (step.max_density_a_cm2, step.ip_a) {
        (None, _) => Some(Figure::Density),
        (_, None) => Some(Figure::PeakCurrent),
        _ => None,
    };
    if let Some(figure) = figure {
        let is_bounded = choice.technology.area_range_mm2.is_some() || step.at_area_mm2.is_some();
        let list = if is_bounded { &mut choice.not_considered } else { &mut choice.missing };
        Missing::add(list, figure, step);
    }
    if choice.burn.undersize_mm.is_some() {
        for (length, figure) in [(step.gap_side_mm, Figure::SideGap), (step.orbit_mm, Figure::Orbit)] {
            if length.is_none() {
                Missing::add(&mut choice.not_considered, figure, step);
            }
        }
    }
}

/// Shares the volume of the burn among steps, given with their places in the technology, and keeps those that have
/// something to remove.
fn share_volume<'a>(taken: &[(usize, &'a Step)], choice: &mut Choice<'a>) {
    let burn = choice.burn;
    let area = burn.burned_area_mm2.unwrap_or_else(|| burn.frontal_area_mm2());
    // None once a layer is not known.
    let mut rest = Some(burn.volume_mm3());
    let (mut steps, mut without_stock) = (Vec::new(), Vec::new());
    let mut has_layers = false;
    for (k, (i, step)) in taken.iter().enumerate().rev() {
        let before = k.checked_sub(1).and_then(|before| taken.get(before));
        let volume = match (before, rest) {
            (None, rest) => rest,
            (_, Some(0.0)) => Some(0.0),
            (Some((before, _)), rest) => {
                has_layers = true;
                let between = choice.technology.step.get(*before..*i).unwrap_or_default();
                without_stock.extend(between.iter().rev().filter(|step| step.stock_next_mm.is_none()));
                let stock: Option<f64> = between.iter().map(|step| step.stock_next_mm).sum();
                rest.zip(stock).map(|(rest, stock)| (stock * area).min(rest))
            }
        };
        rest = rest.zip(volume).map(|(rest, volume)| (rest - volume).max(0.0));
        if k + 1 == taken.len() || volume != Some(0.0) {
            steps.push(ChosenStep { step, volume_mm3: volume });
        }
    }
    for step in without_stock.into_iter().rev() {
        Missing::add(&mut choice.missing, Figure::StockNext, step);
    }
    if has_layers && burn.burned_area_mm2.is_none() {
        choice.not_considered.push(Missing::of_burn(Figure::BurnedArea));
    }
    steps.reverse();
    choice.steps = steps;
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
            orbit_mm: Some(0.0),
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

    /// A burn of which all that steps R, S and F need is known.
    pub(crate) fn burn(volume_mm3: f64, frontal_area_mm2: f64, until: Until) -> Burn {
        let burned_area_mm2 = Some(frontal_area_mm2);
        Burn { burned_area_mm2, depth_to_width: Some(1.0), ..Burn::single(volume_mm3, frontal_area_mm2, until) }
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
        let rough = burn(1000.0, 50.0, Until::Vdi(36.0));
        assert_eq!(names(&choose(&technology, &rough).unwrap()), "S");
        assert!(choose(&technology, &burn(1000.0, 50.0, Until::Step("R".to_owned()))).is_err());
    }

    fn with_undersize(undersize: f64) -> Burn {
        Burn { undersize_mm: Some(undersize), ..burn(1000.0, 100.0, Until::Vdi(20.0)) }
    }

    #[test]
    fn gap_and_orbit_stay_within_the_undersize() {
        let mut technology = complete();
        let with = |technology: &Technology, undersize| {
            let asked = with_undersize(undersize);
            choose(technology, &asked).map(|choice| (names(&choice), choice.wall_stock_mm.unwrap()))
        };
        for (undersize, steps, stock) in [(0.2, "RSF", 0.15), (0.15, "SF", 0.1), (0.05, "F", 0.0)] {
            let (taken, left) = with(&technology, undersize).unwrap();
            assert_eq!(taken, steps);
            assert!((left - stock).abs() < 1e-12, "{left}");
        }
        assert!(matches!(with(&technology, 0.04), Err(BurningError::ReachBeyondUndersize { .. })));
        // With an orbit of 0.1 mm the steps reach 0.3, 0.2 and 0.15 mm beyond the electrode.
        technology.step.iter_mut().for_each(|step| step.orbit_mm = Some(0.1));
        for (undersize, steps, stock) in [(0.35, "RSF", 0.2), (0.3, "RSF", 0.15), (0.2, "SF", 0.05), (0.15, "F", 0.0)] {
            let (taken, left) = with(&technology, undersize).unwrap();
            assert_eq!(taken, steps);
            assert!((left - stock).abs() < 1e-12, "{left}");
        }
        let said = with(&technology, 0.14).unwrap_err().to_string();
        assert!(
            said.contains("step F reaches 0.1500 mm beyond the electrode (side gap 0.05 mm, orbit 0.1 mm)"),
            "{said}"
        );
        // An orbit alone may reach too far.
        technology.step[0].gap_side_mm = None;
        assert_eq!(choose(&technology, &with_undersize(0.09)).unwrap_err().to_string().matches("step F").count(), 1);
        technology.step[0].orbit_mm = Some(0.5);
        assert_eq!(with(&technology, 0.3).unwrap().0, "SF");
        // Without an orbit in the table the gap alone counts, and the result says so.
        technology = complete();
        technology.step.iter_mut().for_each(|step| step.orbit_mm = None);
        let asked = with_undersize(0.2);
        let choice = choose(&technology, &asked).unwrap();
        assert_eq!(
            choice.not_considered,
            [Missing { figure: Figure::Orbit, steps: ["R", "S", "F"].map(Into::into).into() }]
        );
        let open = burn(1000.0, 100.0, Until::Vdi(20.0));
        assert_eq!(choose(&technology, &open).unwrap().wall_stock_mm, None);
    }

    #[test]
    fn burning_starts_at_a_step() {
        let technology = complete();
        let from = |from: &str, until| Burn { from: Some(from.to_owned()), ..burn(4.0, 100.0, until) };
        let taken = |burn: Burn| choose(&technology, &burn).map(|choice| names(&choice)).map_err(|e| e.to_string());
        // The finishing electrode removes all of its volume with F, although S would do for the first of it.
        assert_eq!(taken(from("F", Until::Vdi(20.0))), Ok("F".to_owned()));
        assert_eq!(
            taken(Burn { pieces: burn(100.0, 100.0, Until::Vdi(20.0)).pieces, ..from("S", Until::Vdi(20.0)) }),
            Ok("SF".to_owned())
        );
        // A finish that a step before the start has is reached at the start.
        assert_eq!(taken(from("S", Until::Vdi(36.0))), Ok("S".to_owned()));
        assert_eq!(taken(from("S", Until::Step("S".to_owned()))), Ok("S".to_owned()));
        assert!(taken(from("X", Until::Vdi(20.0))).unwrap_err().contains("there is no step X"));
        let said = taken(from("F", Until::Step("S".to_owned()))).unwrap_err();
        assert_eq!(said, "from is F: burning ends at step S, before it; start at that step or at one before it");
    }

    #[test]
    fn layers_go_to_the_finest_steps_first() {
        let technology = complete();
        let volumes = |volume, burned| {
            let burn = Burn { burned_area_mm2: burned, ..burn(volume, 100.0, Until::Vdi(20.0)) };
            let choice = choose(&technology, &burn).unwrap();
            let without_area = Missing { figure: Figure::BurnedArea, steps: Vec::new() };
            assert_eq!(choice.not_considered.contains(&without_area), burned.is_none() && volume > 0.0);
            choice.steps.iter().map(|chosen| chosen.volume_mm3.unwrap()).collect::<Vec<_>>()
        };
        // S gets 0.1 mm over the area, F 0.05 mm.
        assert_eq!(volumes(1000.0, None), [985.0, 10.0, 5.0]);
        assert_eq!(volumes(1000.0, Some(300.0)), [955.0, 30.0, 15.0]);
        assert_eq!(volumes(12.0, None), [7.0, 5.0]);
        assert_eq!(volumes(4.0, None), [4.0]);
        assert_eq!(volumes(0.0, None), [0.0]);
    }

    /// Without S the step F removes what R leaves for S and what S would leave for F: 0.15 mm.
    #[test]
    fn layers_of_steps_that_are_not_taken_are_left() {
        let mut technology = complete();
        technology.step[1].ip_a = Some(2000.0);
        let asked = burn(1000.0, 100.0, Until::Vdi(20.0));
        let volumes = |technology: &Technology| {
            let choice = choose(technology, &asked).unwrap();
            let missing: Vec<String> = choice.missing.iter().map(ToString::to_string).collect();
            (
                names(&choice),
                choice.steps.iter().map(|chosen| chosen.volume_mm3).collect::<Vec<_>>(),
                missing.join("; "),
            )
        };
        let (steps, of_steps, missing) = volumes(&technology);
        assert_eq!((steps.as_str(), missing.as_str()), ("RF", ""));
        assert!((of_steps[0].unwrap() - 985.0).abs() < 1e-9 && (of_steps[1].unwrap() - 15.0).abs() < 1e-9);
        technology.step[1].stock_next_mm = None;
        let missing = "stock left for the next step of step S is not given".to_owned();
        assert_eq!(volumes(&technology), ("RF".to_owned(), vec![None, None], missing));
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
        let of_both = |figure: &str| format!("{figure} of steps R, S is not given");
        assert_eq!(without(|s| s.vdi = None), (all.clone(), String::new(), of_both("finish")));
        assert_eq!(without(|s| s.ip_a = None), (all.clone(), String::new(), of_both("peak current")));
        let density = of_both("greatest current density");
        assert_eq!(without(|s| s.max_density_a_cm2 = None), (all.clone(), String::new(), density));
        assert_eq!(without(|s| s.gap_side_mm = None), (all, String::new(), of_both("side gap")));
        let stock = of_both("stock left for the next step");
        assert_eq!(without(|s| s.stock_next_mm = None), ([None; 3].to_vec(), stock, String::new()));
    }

    /// Neither a density nor a range of areas nor the area of the rate: 80 A on 1 mm² would pass.
    #[test]
    fn a_current_that_nothing_bounds_is_missing() {
        let open = Technology { area_range_mm2: None, ..complete() };
        let asked = burn(1000.0, 100.0, Until::Vdi(20.0));
        let without = |change: fn(&mut Step)| {
            let mut technology = open.clone();
            technology.step.iter_mut().for_each(change);
            let choice = choose(&technology, &asked).unwrap();
            let figures = |list: &[Missing]| list.iter().map(|missing| missing.figure).collect::<Vec<_>>();
            (figures(&choice.missing), figures(&choice.not_considered))
        };
        let none = || Vec::<Figure>::new();
        assert_eq!(without(|s| s.at_area_mm2 = None), (none(), none()));
        assert_eq!(without(|s| s.max_density_a_cm2 = None), (none(), vec![Figure::Density]));
        assert_eq!(without(|s| [s.max_density_a_cm2, s.at_area_mm2] = [None; 2]), (vec![Figure::Density], none()));
        assert_eq!(without(|s| [s.ip_a, s.at_area_mm2] = [None; 2]), (vec![Figure::PeakCurrent], none()));
    }

    #[test]
    fn a_burn_is_read_and_written() {
        let text = "from = \"S\"\n\n[until]\nra_um = 1.6\n\n[[pieces]]\nvolume_mm3 = 10.0\nfrontal_area_mm2 = 5.0\n";
        let read: Burn = toml::from_str(text).unwrap();
        assert_eq!(read, Burn { from: Some("S".to_owned()), ..Burn::single(10.0, 5.0, Until::RaUm(1.6)) });
        assert_eq!(toml::to_string(&read).unwrap(), text, "what is not given is not written");
        assert!(toml::from_str::<Burn>(&text.replace("ra_um", "shine")).is_err());
    }

    #[test]
    fn without_any_finish_there_is_no_choice() {
        let mut technology = complete();
        technology.step.iter_mut().for_each(|step| step.vdi = None);
        let asked = burn(1.0, 100.0, Until::Vdi(30.0));
        let choice = choose(&technology, &asked).unwrap();
        assert!(choice.steps.is_empty());
        assert_eq!(
            choice.missing.iter().map(ToString::to_string).collect::<String>(),
            "finish of steps R, S, F is not given"
        );
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
        let unlimited = choose(&open, &deep).unwrap();
        let depth = [Missing { figure: Figure::Depth, steps: Vec::new() }];
        assert!(unlimited.outside.is_empty());
        assert_eq!(unlimited.not_considered, depth, "a depth without a limit");
        let flat = Burn { depth_to_width: None, ..deep };
        let unknown = choose(&technology, &flat).unwrap();
        assert_eq!((unknown.outside.len(), unknown.not_considered.as_slice()), (1, depth.as_slice()));
        // The entry with little area is outside as well.
        let small = Piece { volume_mm3: 1.0, frontal_area_mm2: 2.0 };
        let mut entry = burn(1000.0, 900.0, Until::Vdi(20.0));
        entry.pieces.push(small);
        let said = choose(&technology, &entry).unwrap().outside[0].to_string();
        assert_eq!(said, "frontal area 2.00 to 900.00 mm²; the technology is valid from 10 to 1000 mm²");
        let shallow = Burn { depth_to_width: Some(5.0), ..burn(1000.0, 1000.0, Until::Vdi(20.0)) };
        assert!(choose(&technology, &shallow).unwrap().outside.is_empty());
        for wrong in [f64::NAN, -1.0, f64::INFINITY] {
            assert!(choose(&technology, &burn(wrong, 100.0, Until::Vdi(20.0))).is_err());
            assert!(choose(&technology, &burn(1.0, wrong, Until::Vdi(20.0))).is_err());
            assert!(choose(&technology, &burn(1.0, 100.0, Until::RaUm(wrong))).is_err());
        }
        let empty = Burn { pieces: Vec::new(), ..shallow };
        let said = choose(&technology, &empty).unwrap_err().to_string();
        assert_eq!(said, "pieces: there are 0; from 1 to 100000 are possible");
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
