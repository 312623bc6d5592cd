//! Choice of the steps that an electrode burns with, and the volume that each step removes.

#[cfg(test)]
pub(crate) mod tests;

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

impl Piece {
    /// Pieces of the burn of several heads that go down together to one depth.
    ///
    /// Each head has as much stock above its floor as its volume is of its frontal area, so that the ones with more
    /// stock begin earlier: the areas of all that have begun add up. A head without stock does not count. None if the
    /// volume of a head with stock has no area.
    pub fn together(heads: &[Self]) -> Option<Vec<Self>> {
        let mut begun: Vec<[f64; 2]> = Vec::with_capacity(heads.len());
        for head in heads.iter().filter(|head| head.volume_mm3 != 0.0) {
            let depth = head.volume_mm3 / head.frontal_area_mm2;
            if !depth.is_finite() || depth < 0.0 {
                return None;
            }
            begun.push([depth, head.frontal_area_mm2]);
        }
        begun.sort_by(|a, b| b[0].total_cmp(&a[0]));
        let (mut pieces, mut area) = (Vec::new(), 0.0);
        for (i, [depth, own]) in begun.iter().enumerate() {
            area += own;
            let end = begun.get(i + 1).map_or(0.0, |next| next[0]);
            if *depth > end {
                pieces.push(Self { volume_mm3: area * (depth - end), frontal_area_mm2: area });
            }
        }
        Some(pieces)
    }
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
    pub(crate) fn areas_mm2(&self) -> [f64; 2] {
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

/// Index of the step of this name.
pub(crate) fn named(technology: &Technology, name: &str) -> Result<usize, BurningError> {
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
