//! Minutes and wear of an electrode as tables, reports and windows show them.

use std::fmt::Display;

use serde::{Deserialize, Serialize};

use crate::BurningError;
use crate::choice::{Burn, Figure, Missing};
use crate::duration::{BurnTime, Spread, StepTime};
use crate::estimate::Estimate;
use crate::project::ProjectTechnology;
use crate::technology::{Technology, TechnologyFile};
use crate::wear::{AllowedWear, Redress, Redressing, Wear, WearShare};

/// Beginning of the line of [`BurnFigures::explanation`] that says what the figures leave out.
pub const NOT_CONSIDERED: &str = "Not considered: ";

/// Minutes and wear of an electrode in one burn, or the reasons why they are not known, with what they rest on.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BurnFigures {
    /// Volume to remove (mm³); none if it is not known.
    pub volume_mm3: Option<f64>,
    /// Least and greatest frontal area (mm²); none if it is not known.
    pub frontal_area_mm2: Option<[f64; 2]>,
    /// The steps, from rough to fine.
    pub steps: Vec<StepTime>,
    /// Burning, without set-up and changing (minutes); none if it is not known.
    pub minutes: Option<Spread>,
    /// Length that the front loses (mm); none if it is not considered.
    pub end_wear_mm: Option<f64>,
    /// Wear of the edges (mm); none if it is not considered.
    pub corner_wear_mm: Option<f64>,
    /// Share of the allowed wear that the burn uses up.
    pub wear_share: WearShare,
    /// Redressing of the electrode.
    #[serde(default, skip_serializing_if = "Redress::is_none")]
    pub redress: Redress,
    /// Foundation of the figures, in a sentence; none without a technology.
    pub rests_on: Option<String>,
    /// Reasons why the minutes are not known.
    pub missing: Vec<String>,
    /// What the minutes and the wear do without, and ranges of the technology that the burn leaves.
    pub not_considered: Vec<String>,
}

impl BurnFigures {
    /// Figures of a burn with the technology of a project.
    pub fn of(table: &TechnologyFile, project: &ProjectTechnology, burn: &Burn) -> Self {
        let [least, greatest] = burn.areas_mm2();
        let of_burn = Self {
            volume_mm3: Some(burn.volume_mm3()),
            frontal_area_mm2: (least <= greatest).then_some([least, greatest]),
            redress: project.redress,
            rests_on: table.get(&project.id).map(|technology| {
                format!("{} ({}): {}", technology.label(), technology.basis, technology.source.trim())
            }),
            ..Self::default()
        };
        match table.estimate(&project.id, burn).and_then(|estimate| of_burn.with(&estimate, project.allowed_wear)) {
            Ok(figures) => figures,
            Err(reason) => Self { missing: vec![reason.to_string()], ..of_burn },
        }
    }

    /// Figures that are not known, for this reason.
    pub fn unknown(reason: impl Display) -> Self {
        Self { missing: vec![reason.to_string()], ..Self::default() }
    }

    /// Figures of a burn that is known to remove nothing.
    pub fn idle() -> Self {
        Self {
            volume_mm3: Some(0.0),
            minutes: Some(Spread::certain(0.0)),
            end_wear_mm: Some(0.0),
            corner_wear_mm: Some(0.0),
            wear_share: WearShare::Known(0.0),
            not_considered: vec!["a burn removes no stock".to_owned()],
            ..Self::default()
        }
    }

    /// Figures of several burns of one electrode together. A figure that one of them lacks is not known of all; without
    /// burns none is known.
    pub fn all_of(burns: &[Self]) -> Self {
        let Some((first, rest)) = burns.split_first() else { return Self::default() };
        rest.iter().fold(first.clone(), |all, burn| all.plus(burn))
    }

    fn plus(self, other: &Self) -> Self {
        let sum = |a: Option<f64>, b: Option<f64>| a.zip(b).map(|(a, b)| a + b);
        let areas = match (self.frontal_area_mm2, other.frontal_area_mm2) {
            (Some([a, b]), Some([c, d])) => Some([a.min(c), b.max(d)]),
            (one, None) | (None, one) => one,
        };
        let used = self.wear_share.at_least() + other.wear_share.at_least();
        let wear_share = match (self.wear_share, other.wear_share) {
            (WearShare::Unlimited, WearShare::Unlimited) => WearShare::Unlimited,
            (a, b) if a.is_unknown() || b.is_unknown() => WearShare::Unknown { at_least: used },
            _ => WearShare::Known(used),
        };
        let mut steps = self.steps;
        for step in &other.steps {
            match steps.iter_mut().find(|known| known.step == step.step) {
                Some(known) => *known = known.plus(step),
                None => steps.push(step.clone()),
            }
        }
        let joined = |mut all: Vec<String>, more: &[String]| {
            more.iter().for_each(|text| {
                if !all.contains(text) {
                    all.push(text.clone())
                }
            });
            all
        };
        Self {
            volume_mm3: sum(self.volume_mm3, other.volume_mm3),
            frontal_area_mm2: areas,
            steps,
            minutes: self.minutes.zip(other.minutes).map(|(a, b)| a.plus(b)),
            end_wear_mm: sum(self.end_wear_mm, other.end_wear_mm),
            corner_wear_mm: sum(self.corner_wear_mm, other.corner_wear_mm),
            wear_share,
            redress: if self.redress.is_none() { other.redress } else { self.redress },
            rests_on: self.rests_on.or_else(|| other.rests_on.clone()),
            missing: joined(self.missing, &other.missing),
            not_considered: joined(self.not_considered, &other.not_considered),
        }
    }

    fn with(&self, estimate: &Estimate, allowed: AllowedWear) -> Result<Self, BurningError> {
        let Estimate { time, wear } = estimate;
        let is_of_wear = |missing: &&Missing| matches!(missing.figure, Figure::Wear | Figure::CornerWear);
        let of_wear = wear.missing.iter().filter(is_of_wear).map(ToString::to_string);
        let outside = time.outside.iter().map(ToString::to_string);
        Ok(Self {
            steps: time.steps.clone(),
            minutes: time.burning,
            end_wear_mm: wear.end_mm,
            corner_wear_mm: wear.corner_mm,
            wear_share: wear.share_of(allowed)?,
            rests_on: self.rests_on.as_ref().map(|text| text.clone() + &scaling(time)),
            missing: time.missing.iter().map(ToString::to_string).collect(),
            not_considered: outside.chain(time.not_considered.iter().map(ToString::to_string)).chain(of_wear).collect(),
            ..self.clone()
        })
    }

    /// Minutes in words, as `12.5 min`, or that they are not known.
    pub fn minutes_text(&self) -> String {
        minutes_text(self.minutes)
    }

    /// Wear in words; what is not known is not considered.
    pub fn wear_text(&self) -> String {
        match (self.end_wear_mm, self.corner_wear_mm) {
            (None, None) => "wear not considered".to_owned(),
            (Some(end), None) => format!("end wear {end:.4} mm, corner wear not considered"),
            (None, Some(corner)) => format!("end wear not considered, corner wear {corner:.4} mm"),
            (Some(end), Some(corner)) => format!("end wear {end:.4} mm, corner wear {corner:.4} mm"),
        }
    }

    /// Whether the wear is known, so that no more electrodes are needed than are counted.
    pub fn is_wear_known(&self) -> bool {
        match self.wear_share {
            WearShare::Known(_) => true,
            WearShare::Unlimited => self.end_wear_mm.is_some() && self.corner_wear_mm.is_some(),
            WearShare::Unknown { .. } => false,
        }
    }

    /// Number of electrodes that `burns` burns need, in words. `copies` is their number as far as the wear is known.
    pub fn needed_text(&self, copies: usize) -> String {
        match (self.is_wear_known(), self.wear_share) {
            (false, _) => format!("at least {copies}: wear not considered"),
            (true, WearShare::Unlimited) => format!("{copies}: no wear is limited"),
            (true, _) => copies.to_string() + &self.redressed_text(copies),
        }
    }

    /// Redressing of an electrode that is worn as far as is allowed; none if that is not known, or of an electrode that is not
    /// redressed or that the burns do not wear out.
    pub fn redressing(&self) -> Option<Redressing> {
        let WearShare::Known(share) = self.wear_share else { return None };
        let worn_out = |wear: Option<f64>| wear.filter(|_| share > 0.0).map(|wear| wear / share);
        let [end_mm, corner_mm] = [self.end_wear_mm, self.corner_wear_mm].map(worn_out);
        self.redress.after(&Wear { end_mm, corner_mm, missing: Vec::new() }).ok().flatten()
    }

    /// How many are made where `copies` are used, in words; empty where none is redressed.
    fn redressed_text(&self, copies: usize) -> String {
        if let Some(missing) = self.redress.missing() {
            return format!("; redressing not considered: its {missing} is not given");
        }
        match self.redressing() {
            _ if self.redress.is_none() => String::new(),
            None => "; redressing not considered: end or corner wear is not known".to_owned(),
            Some(Redressing { times: 0, cut_off_mm, .. }) => {
                format!("; too short to lose {cut_off_mm:.3} mm for a redressing")
            }
            Some(redressing) => {
                let (made, times) = (redressing.electrodes_for(copies), redressing.times);
                format!(" uses of {made} made, redressed up to {times} times by {:.3} mm", redressing.cut_off_mm)
            }
        }
    }

    /// Lines that say what the figures rest on and what is missing.
    pub fn explanation(&self) -> Vec<String> {
        let missing = (!self.missing.is_empty()).then(|| format!("Minutes not known: {}.", self.missing.join("; ")));
        let without = &self.not_considered;
        let without = (!without.is_empty()).then(|| format!("{NOT_CONSIDERED}{}.", without.join("; ")));
        missing.into_iter().chain(self.rests_on.clone()).chain(without).collect()
    }
}

/// Figures that steps of a technology lack, each with the names of these steps.
pub fn gaps_of(technology: &Technology) -> Vec<Missing> {
    let mut gaps = Vec::new();
    for (i, step) in technology.step.iter().enumerate() {
        let jump = step.jump_mm.and(step.jump_every_s).and(step.jump_speed);
        // After the last step there is none to leave stock for.
        let is_last = i + 1 == technology.step.len();
        for (figure, is_given) in [
            (Figure::Finish, step.finish_vdi().is_some()),
            (Figure::PeakCurrent, step.ip_a.is_some()),
            (Figure::Density, step.max_density_a_cm2.is_some()),
            (Figure::SideGap, step.gap_side_mm.is_some()),
            (Figure::Orbit, step.orbit_mm.is_some()),
            (Figure::Rate, step.rate_mm3_min.is_some()),
            (Figure::RateArea, step.at_area_mm2.is_some()),
            (Figure::StockNext, step.stock_next_mm.is_some() || is_last),
            (Figure::Jump, jump.is_some()),
            (Figure::Wear, step.wear_percent.is_some()),
            (Figure::CornerWear, step.corner_wear_mm.is_some()),
        ] {
            if !is_given {
                Missing::add(&mut gaps, figure, step);
            }
        }
    }
    gaps
}

/// Minutes in words, as `12.5 min` or `12.5 min (10.0 to 15.0)`, or that they are not known.
pub fn minutes_text(minutes: Option<Spread>) -> String {
    in_unit(minutes, "min")
}

/// Hours in words, of minutes.
pub fn hours_text(minutes: Option<Spread>) -> String {
    in_unit(minutes.map(|minutes| minutes.times(1.0 / 60.0)), "h")
}

fn in_unit(time: Option<Spread>, unit: &str) -> String {
    match time {
        None => "not known".to_owned(),
        Some(Spread { least: Some(least), mean, greatest: Some(greatest) }) if least < greatest => {
            format!("{mean:.1} {unit} ({least:.1} to {greatest:.1})")
        }
        Some(Spread { mean, .. }) => format!("{mean:.1} {unit}"),
    }
}

fn scaling(time: &BurnTime) -> String {
    time.calibration.map_or_else(String::new, |calibrated| {
        let burns = if calibrated.count == 1 { "burn" } else { "burns" };
        format!(" Scaled by {} finished {burns}: {:.3} times the estimate.", calibrated.count, calibrated.mean)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::choice::Until;
    use crate::choice::tests::{burn, complete};
    use crate::technology::Calibration;

    fn table() -> TechnologyFile {
        TechnologyFile { technology: vec![complete()], calibration: Vec::new() }
    }

    fn project() -> ProjectTechnology {
        ProjectTechnology { id: "complete".to_owned(), ..ProjectTechnology::default() }
    }

    /// 985 / 40 + 10 / 10 + 5 / 2 minutes and 5 % for jumps; 985 mm³ at 1 %, 10 at 5 % and 5 at 20 % from 100 mm².
    #[test]
    fn figures_are_those_of_the_estimate() {
        let asked = burn(1000.0, 100.0, Until::Vdi(20.0));
        let figures = BurnFigures::of(&table(), &project(), &asked);
        let minutes = 1.05 * (985.0 / 40.0 + 1.0 + 2.5);
        assert!((figures.minutes.unwrap().mean - minutes).abs() < 1e-9);
        assert_eq!(figures.minutes_text(), format!("{minutes:.1} min"));
        assert_eq!((figures.volume_mm3, figures.frontal_area_mm2), (Some(1000.0), Some([100.0; 2])));
        assert_eq!(figures.wear_text(), "end wear 0.1135 mm, corner wear 0.0600 mm");
        assert_eq!(figures.rests_on.as_deref(), Some("complete (measured): test"));
        assert!(figures.missing.is_empty() && figures.not_considered.is_empty(), "{figures:?}");
        assert_eq!(figures.needed_text(1), "1: no wear is limited");
        let limited =
            ProjectTechnology { allowed_wear: AllowedWear { end_mm: Some(0.05), corner_mm: None }, ..project() };
        let figures = BurnFigures::of(&table(), &limited, &asked);
        assert_eq!(figures.needed_text(3), "3");
        assert!((figures.wear_share.at_least() - 0.1135 / 0.05).abs() < 1e-9);
    }

    /// An end wear of 0.1135 mm of 0.05 mm allowed: 2.27 electrodes, each worn by 0.05 mm and 0.0600 / 2.27 mm at its edges.
    #[test]
    fn worn_electrodes_are_redressed_as_often_as_their_length_allows() {
        let redress = Redress { length_mm: Some(12.0), least_length_mm: Some(11.5), allowance_mm: Some(0.1) };
        let allowed_wear = AllowedWear { end_mm: Some(0.05), corner_mm: None };
        let with = |redress| {
            let project = ProjectTechnology { allowed_wear, redress, ..project() };
            BurnFigures::of(&table(), &project, &burn(1000.0, 100.0, Until::Vdi(20.0)))
        };
        let cut_off = 0.05 + 0.06 * 0.05 / 0.1135 + 0.1;
        let redressing = with(redress).redressing().unwrap();
        assert!((redressing.cut_off_mm - cut_off).abs() < 1e-9 && redressing.times == 2, "{redressing:?}");
        assert_eq!(
            with(redress).needed_text(7),
            format!("7 uses of 3 made, redressed up to 2 times by {cut_off:.3} mm")
        );
        let short = with(Redress { least_length_mm: Some(11.9), ..redress });
        assert_eq!(short.needed_text(3), format!("3; too short to lose {cut_off:.3} mm for a redressing"));
        assert_eq!(with(Redress::default()).needed_text(3), "3");
        let unknown = BurnFigures { corner_wear_mm: None, ..with(redress) };
        assert!(unknown.needed_text(3).contains("redressing not considered"), "what is not known is not 0");
        let partly = with(Redress { allowance_mm: None, ..redress }).needed_text(3);
        assert_eq!(partly, "3; redressing not considered: its allowance_mm is not given");
    }

    #[test]
    fn finished_burns_are_told() {
        let mut table = table();
        let finished = |measured_min| Calibration {
            technology: "complete".to_owned(),
            estimated_min: 10.0,
            measured_min,
            date: None,
            source: None,
        };
        table.calibration = vec![finished(11.0), finished(13.0)];
        let figures = BurnFigures::of(&table, &project(), &burn(1000.0, 100.0, Until::Vdi(20.0)));
        let said = figures.rests_on.unwrap();
        assert!(said.ends_with("Scaled by 2 finished burns: 1.200 times the estimate."), "{said}");
        assert_eq!(minutes_text(figures.minutes), "35.4 min (32.5 to 38.4)");
    }

    #[test]
    fn what_is_missing_is_named_and_never_zero() {
        let mut table = table();
        for step in &mut table.technology[0].step {
            (step.wear_percent, step.corner_wear_mm) = (None, None);
        }
        let asked = burn(1000.0, 100.0, Until::Vdi(20.0));
        let figures = BurnFigures::of(&table, &project(), &asked);
        assert!(figures.minutes.is_some());
        assert_eq!((figures.end_wear_mm, figures.corner_wear_mm), (None, None));
        assert_eq!(
            (figures.wear_text(), figures.needed_text(1)),
            ("wear not considered".to_owned(), "at least 1: wear not considered".to_owned())
        );
        assert!(figures.not_considered.contains(&"wear of steps R, S, F is not given".to_owned()), "{figures:?}");
        let limited =
            ProjectTechnology { allowed_wear: AllowedWear { end_mm: Some(0.1), corner_mm: None }, ..project() };
        let figures = BurnFigures::of(&table, &limited, &asked);
        assert!(figures.wear_share.is_unknown());
        assert_eq!(figures.needed_text(1), "at least 1: wear not considered");

        table.technology[0].step[1].rate_mm3_min = None;
        let figures = BurnFigures::of(&table, &project(), &asked);
        assert_eq!((figures.minutes, figures.minutes_text().as_str()), (None, "not known"));
        assert_eq!(figures.missing, ["rate of step S is not given"]);
        assert!(figures.explanation()[0].starts_with("Minutes not known: rate of step S is not given."));
    }

    #[test]
    fn gaps_of_a_technology_are_named_with_their_steps() {
        assert_eq!(gaps_of(&complete()), [], "the last step leaves no stock");
        let mut technology = complete();
        technology.step[0].rate_mm3_min = None;
        technology.step[2].rate_mm3_min = None;
        technology.step[1].jump_speed = None;
        let said: Vec<String> = gaps_of(&technology).iter().map(ToString::to_string).collect();
        assert_eq!(said, ["rate of steps R, F is not given", "jump of step S is not given"]);
    }

    /// Twice the same burn is twice the volume, the minutes and the wear.
    #[test]
    fn burns_of_one_electrode_add_up() {
        let limited =
            ProjectTechnology { allowed_wear: AllowedWear { end_mm: Some(0.2), corner_mm: None }, ..project() };
        let one = BurnFigures::of(&table(), &limited, &burn(1000.0, 100.0, Until::Vdi(20.0)));
        let other = BurnFigures::of(&table(), &limited, &burn(500.0, 50.0, Until::Vdi(20.0)));
        let both = BurnFigures::all_of(&[one.clone(), other.clone(), BurnFigures::idle()]);
        let minutes = one.minutes.unwrap().mean + other.minutes.unwrap().mean;
        assert!((both.minutes.unwrap().mean - minutes).abs() < 1e-9);
        assert_eq!((both.volume_mm3, both.frontal_area_mm2), (Some(1500.0), Some([50.0, 100.0])));
        let share = one.wear_share.at_least() + other.wear_share.at_least();
        assert!(matches!(both.wear_share, WearShare::Known(used) if (used - share).abs() < 1e-12));
        let step = both.steps.iter().find(|step| step.step == "S").unwrap();
        let of_step = |f: &BurnFigures| f.steps.iter().find(|step| step.step == "S").unwrap().clone();
        assert_eq!(step.minutes, of_step(&one).minutes.zip(of_step(&other).minutes).map(|(a, b)| a + b));
        let minutes = step.volume_mm3.unwrap() / step.rate_mm3_min.unwrap() * step.jump_factor.unwrap();
        assert!((step.minutes.unwrap() - minutes).abs() < 1e-9, "the mean rate is the one that gives the minutes");
        let unknown = BurnFigures::all_of(&[one.clone(), BurnFigures::unknown("no volume")]);
        assert_eq!((unknown.minutes, unknown.volume_mm3, unknown.end_wear_mm), (None, None, None));
        assert!(unknown.wear_share.is_unknown() && unknown.missing == ["no volume"]);
        assert_eq!(BurnFigures::all_of(&[]).minutes, None, "no burns are not known to take no time");
        assert_eq!(BurnFigures::all_of(std::slice::from_ref(&one)), one);
    }

    #[test]
    fn a_burn_that_cannot_be_estimated_says_why() {
        let figures = BurnFigures::of(&table(), &project(), &burn(1000.0, 100.0, Until::Vdi(10.0)));
        assert_eq!((figures.minutes, figures.volume_mm3), (None, Some(1000.0)));
        assert!(figures.missing[0].contains("no step is as fine as VDI 10.0"), "{figures:?}");
        let other = ProjectTechnology { id: "other".to_owned(), ..project() };
        let figures = BurnFigures::of(&table(), &other, &burn(1000.0, 100.0, Until::Vdi(20.0)));
        assert_eq!((figures.rests_on, figures.minutes), (None, None));
        assert!(figures.missing[0].contains("there is no technology other"));
        let none = BurnFigures::unknown("no certified path");
        assert_eq!((none.volume_mm3, none.minutes, none.wear_text().as_str()), (None, None, "wear not considered"));
    }
}
