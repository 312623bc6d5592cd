//! Minutes that an electrode burns in one place, what they rest on, and what is missing.

use files::{Invalid, Validate};
use serde::{Deserialize, Serialize};

use crate::choice::{Burn, Choice, Figure, Missing, Outside};
use crate::technology::{AREA_MM2, Basis, Calibration, Step};
use crate::{BurningError, rules};

/// Minutes with the least and the greatest that finished burns make likely.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Spread {
    /// Least (minutes); none where no spread is known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub least: Option<f64>,
    /// Mean (minutes).
    pub mean: f64,
    /// Greatest (minutes); none where no spread is known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub greatest: Option<f64>,
}

impl Spread {
    /// Minutes without a known spread.
    pub const fn exactly(mean: f64) -> Self {
        Self { least: None, mean, greatest: None }
    }

    /// Minutes that are certain: least, mean and greatest are the same.
    pub const fn certain(mean: f64) -> Self {
        Self { least: Some(mean), mean, greatest: Some(mean) }
    }

    /// Sum of two times, one after the other. The spread is known if both are; all burns are taken to be slow or fast together.
    #[must_use]
    pub fn plus(self, other: Self) -> Self {
        let sum = |a: Option<f64>, b: Option<f64>| a.zip(b).map(|(a, b)| a + b);
        Self {
            least: sum(self.least, other.least),
            mean: self.mean + other.mean,
            greatest: sum(self.greatest, other.greatest),
        }
    }

    /// A multiple, such as hours of minutes.
    #[must_use]
    pub fn times(self, factor: f64) -> Self {
        let times = |value: Option<f64>| value.map(|value| value * factor);
        Self { least: times(self.least), mean: self.mean * factor, greatest: times(self.greatest) }
    }
}

impl Validate for Spread {
    fn validate(&self) -> Result<(), Invalid> {
        let minutes = |key, value| Invalid::unless_within(key, value, [0.0, 1e9], "min");
        minutes("mean", self.mean)?;
        if let Some(least) = self.least {
            Invalid::unless_within("least", least, [0.0, self.mean], "min")?;
        }
        self.greatest.map_or(Ok(()), |greatest| Invalid::unless_within("greatest", greatest, [self.mean, 1e9], "min"))
    }
}

/// Minutes around several burns.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Overhead {
    /// Setting up the workpiece and the first electrode (minutes), once.
    pub setup_min: f64,
    /// Changing to the next electrode, with positioning and measuring it (minutes), before each burn but the first.
    pub change_min: f64,
}

impl Validate for Overhead {
    fn validate(&self) -> Result<(), Invalid> {
        Invalid::unless_within("setup_min", self.setup_min, [0.0, 1e6], "min")?;
        Invalid::unless_within("change_min", self.change_min, [0.0, 1e6], "min")
    }
}

/// Ratio of measured to estimated minutes in the finished burns of a technology.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Calibrated {
    /// Number of finished burns.
    pub count: usize,
    /// Sum of the measured minutes by sum of the estimated minutes.
    pub mean: f64,
    /// Least ratio; none for a single burn, which has no spread.
    pub least: Option<f64>,
    /// Greatest ratio; none for a single burn, which has no spread.
    pub greatest: Option<f64>,
}

impl Calibrated {
    /// Ratio of measured to estimated minutes of these finished burns; none without any.
    ///
    /// The mean is the ratio of the sums, so that the scaled estimates of the same burns add up to the measured minutes.
    ///
    /// # Errors
    /// The first burn whose minutes are not possible.
    pub fn from_burns<'a>(burns: impl IntoIterator<Item = &'a Calibration>) -> Result<Option<Self>, Invalid> {
        let (mut count, mut measured, mut estimated) = (0_usize, 0.0, 0.0);
        let [mut least, mut greatest] = [f64::INFINITY, 0.0_f64];
        for (i, burn) in burns.into_iter().enumerate() {
            burn.validate().map_err(|problem| problem.within(&format!("calibration[{i}]")))?;
            let ratio = burn.measured_min / burn.estimated_min;
            count += 1;
            measured += burn.measured_min;
            estimated += burn.estimated_min;
            [least, greatest] = [least.min(ratio), greatest.max(ratio)];
        }
        if count == 0 {
            return Ok(None);
        }
        // Rounding must not put the mean outside its limits.
        let mean = (measured / estimated).max(least).min(greatest);
        let spread = |ratio| (count > 1).then_some(ratio);
        Ok(Some(Self { count, mean, least: spread(least), greatest: spread(greatest) }))
    }

    /// Estimated minutes scaled by the finished burns.
    pub fn scale(&self, estimated_min: f64) -> Spread {
        Spread { least: self.least, mean: self.mean, greatest: self.greatest }.times(estimated_min)
    }
}

/// A step of a burn with its time.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StepTime {
    /// Name of the step.
    pub step: String,
    /// Volume that it removes (mm³); none if not known.
    pub volume_mm3: Option<f64>,
    /// Mean removal rate on the areas of the burn, without jumps (mm³ per minute); none if not given.
    pub rate_mm3_min: Option<f64>,
    /// Factor by which jumps lengthen the time; none if they are not given.
    pub jump_factor: Option<f64>,
    /// Time with jumps, not calibrated (minutes); none if volume or rate is not known.
    pub minutes: Option<f64>,
}

impl StepTime {
    /// Sum of a step over two burns: volume, minutes, and the mean rate that gives them.
    pub(crate) fn plus(&self, other: &Self) -> Self {
        let sum = |a: Option<f64>, b: Option<f64>| a.zip(b).map(|(a, b)| a + b);
        let volume_mm3 = sum(self.volume_mm3, other.volume_mm3);
        let slow = |step: &Self| step.volume_mm3.zip(step.rate_mm3_min).map(|(volume, rate)| volume / rate);
        let rate = volume_mm3.zip(sum(slow(self), slow(other))).map(|(volume, minutes)| volume / minutes);
        Self {
            step: self.step.clone(),
            volume_mm3,
            rate_mm3_min: rate.filter(|rate| rate.is_finite()).or(self.rate_mm3_min),
            jump_factor: self.jump_factor.zip(other.jump_factor).map(|(factor, _)| factor),
            minutes: sum(self.minutes, other.minutes),
        }
    }
}

/// Time of a burn, without set-up and changing.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct BurnTime {
    /// Id of the technology.
    pub technology: String,
    /// Foundation of the figures of the technology.
    pub basis: Basis,
    /// Origin of the figures of the technology, and the range in which they are valid.
    pub source: String,
    /// The steps, from rough to fine.
    pub steps: Vec<StepTime>,
    /// Stock that the last step leaves on the walls (mm): undersize less its side gap and orbit, which counts as 0 where
    /// [`BurnTime::not_considered`] names it; none if undersize or side gap is not known.
    pub wall_stock_mm: Option<f64>,
    /// Finished burns that scale the time; none if there are none.
    pub calibration: Option<Calibrated>,
    /// Time of burning with jumps, not calibrated (minutes); none if a figure is missing.
    pub estimated_min: Option<f64>,
    /// Time of burning with jumps, calibrated (minutes); none if a figure is missing.
    pub burning: Option<Spread>,
    /// Figures without which there is no time.
    pub missing: Vec<Missing>,
    /// Figures that the time does without.
    pub not_considered: Vec<Missing>,
    /// Ranges of the technology that the burn leaves.
    pub outside: Vec<Outside>,
}

/// Time of chosen steps: the sum over steps and pieces of volume / (rate times area factor) times the jump factor, scaled
/// by finished burns.
///
/// # Errors
/// [`BurningError`] for areas that are not possible.
pub(crate) fn time_of(choice: &Choice, calibration: Option<Calibrated>) -> Result<BurnTime, BurningError> {
    let (mut missing, mut not_considered) = (choice.missing.clone(), choice.not_considered.clone());
    let mut steps = Vec::with_capacity(choice.steps.len());
    for chosen in &choice.steps {
        let (step, volume_mm3) = (chosen.step, chosen.volume_mm3);
        let rate = mean_rate(step, choice.burn)?;
        let jump_factor = jump_factor(step);
        let minutes = match (volume_mm3, rate) {
            (Some(0.0), _) => Some(0.0),
            (volume, Some(rate)) => volume.map(|volume| volume / rate * jump_factor.unwrap_or(1.0)),
            (_, None) => {
                Missing::add(&mut missing, Figure::Rate, step);
                None
            }
        };
        if rate.is_some() && step.at_area_mm2.is_none() {
            Missing::add(&mut not_considered, Figure::RateArea, step);
        }
        if jump_factor.is_none() {
            Missing::add(&mut not_considered, Figure::Jump, step);
        }
        steps.push(StepTime { step: step.name.clone(), volume_mm3, rate_mm3_min: rate, jump_factor, minutes });
    }
    // No step at all is no time of zero: the steps are not known.
    let all: Option<f64> = steps.iter().map(|step| step.minutes).sum();
    let estimated_min = all.filter(|_| !steps.is_empty() && missing.is_empty());
    Ok(BurnTime {
        technology: choice.technology.id.clone(),
        basis: choice.technology.basis,
        source: choice.technology.source.clone(),
        steps,
        wall_stock_mm: choice.wall_stock_mm,
        calibration,
        estimated_min,
        burning: estimated_min.map(|estimated| {
            calibration.map_or(Spread::exactly(estimated), |calibration| calibration.scale(estimated))
        }),
        missing,
        not_considered,
        outside: choice.outside.clone(),
    })
}

/// Mean removal rate of a step over the pieces of a burn (mm³ per minute); none if no rate is given.
///
/// A piece slows the step down where its area is smaller than the area of the rate, or than the one on which the density
/// of the step allows its current. A step without either has its rate on every area. Each step removes the same share of
/// every piece.
fn mean_rate(step: &Step, burn: &Burn) -> Result<Option<f64>, BurningError> {
    let Some(rate) = step.rate_mm3_min else { return Ok(None) };
    let of_current =
        step.ip_a.zip(step.max_density_a_cm2).map(|(current, limit)| rules::area_of_density_mm2(current, limit));
    let [least, greatest] = AREA_MM2;
    let full_from = step.at_area_mm2.into_iter().chain(of_current).reduce(f64::max);
    let Some(full_from) = full_from.map(|area| area.clamp(least, greatest)) else { return Ok(Some(rate)) };
    let volume = burn.volume_mm3();
    if volume == 0.0 {
        return Ok(Some(rate * rules::area_factor(burn.frontal_area_mm2(), full_from)?));
    }
    let mut slowness = 0.0;
    for piece in &burn.pieces {
        slowness += piece.volume_mm3 / volume / rules::area_factor(piece.frontal_area_mm2, full_from)?;
    }
    Ok(Some(rate / slowness))
}

/// Time of several burns, one after the other, with set-up and changing (minutes), given the time of each (minutes): those
/// of a channel, or of a mold. None if one of them is not known.
///
/// # Errors
/// [`Invalid`] for minutes of set-up or changing that are not possible.
pub fn sum_of(burns: impl IntoIterator<Item = Option<Spread>>, overhead: Overhead) -> Result<Option<Spread>, Invalid> {
    overhead.validate()?;
    let add = |sum: Spread, (i, burning): (usize, Option<Spread>)| {
        let change = Spread::certain(if i > 0 { overhead.change_min } else { 0.0 });
        Some(sum.plus(change).plus(burning?))
    };
    Ok(burns.into_iter().enumerate().try_fold(Spread::certain(overhead.setup_min), add))
}

/// Factor by which jumps lengthen burning: 1 + (2 height / speed) / interval. None unless all three are given.
fn jump_factor(step: &Step) -> Option<f64> {
    const SECONDS: f64 = 60.0;
    let (height, (interval, speed)) = step.jump_mm.zip(step.jump_every_s.zip(step.jump_speed))?;
    let factor = 1.0 + SECONDS * 2.0 * height / speed / interval;
    // Steps that were validated have a positive interval and speed.
    factor.is_finite().then_some(factor)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::choice::tests::{burn, complete};
    use crate::choice::{Piece, Until, choose};
    use crate::technology::Technology;

    /// A change of a step.
    type Change = fn(&mut Step);

    fn finished(pairs: &[[f64; 2]]) -> Vec<Calibration> {
        let burn = |[estimated_min, measured_min]: &[f64; 2]| Calibration {
            technology: "complete".to_owned(),
            estimated_min: *estimated_min,
            measured_min: *measured_min,
            date: None,
            source: None,
        };
        pairs.iter().map(burn).collect()
    }

    fn time(technology: &Technology, volume: f64, area: f64) -> BurnTime {
        time_of(&choose(technology, &burn(volume, area, Until::Vdi(20.0))).unwrap(), None).unwrap()
    }

    /// 985 / 40 + 10 / 10 + 5 / 2 minutes; a jump of 2 mm at 80 mm/s takes 0.05 s in each second of burning.
    #[test]
    fn minutes_are_those_computed_by_hand() {
        let time = super::tests::time(&complete(), 1000.0, 100.0);
        let minutes = (985.0 / 40.0 + 10.0 / 10.0 + 5.0 / 2.0) * 1.05;
        assert!((time.estimated_min.unwrap() - minutes).abs() < 1e-12);
        let burning = time.burning.unwrap();
        assert!((burning.mean - minutes).abs() < 1e-12);
        assert_eq!((burning.least, burning.greatest), (None, None), "without finished burns there is no spread");
        let rests_on = (time.technology.as_str(), time.basis, time.source.as_str(), time.calibration);
        assert_eq!(rests_on, ("complete", Basis::Measured, "test", None));
        assert_eq!(time.steps.iter().map(|step| step.step.as_str()).collect::<String>(), "RSF");
        assert!(time.missing.is_empty() && time.not_considered.is_empty() && time.outside.is_empty());
        // Half the stated area, where only S and F may burn: the rate falls by 0.5^0.437.
        let half = super::tests::time(&complete(), 1000.0, 50.0);
        let minutes = (997.5 / 10.0 + 2.5 / 2.0) * 1.05 / 0.5f64.powf(0.437);
        assert!((half.estimated_min.unwrap() - minutes).abs() < 1e-9);
    }

    /// 100 mm³ on 10 mm², then 900 mm³ on 100 mm²: the entry burns at 0.1^0.437 of the rate.
    #[test]
    fn an_entry_with_little_area_is_slow() {
        let mut asked = burn(900.0, 100.0, Until::Vdi(20.0));
        asked.pieces.insert(0, Piece { volume_mm3: 100.0, frontal_area_mm2: 10.0 });
        let mut technology = complete();
        let minutes = |technology: &Technology| time_of(&choose(technology, &asked).unwrap(), None).unwrap();
        let whole = time(&technology, 1000.0, 100.0).estimated_min.unwrap();
        let slow = whole * (0.9 + 0.1 / 0.1f64.powf(0.437));
        assert!((minutes(&technology).estimated_min.unwrap() - slow).abs() < 1e-9);
        // Rates without an area: R needs 100 mm² for its current, S 50 mm² and F 20 mm².
        technology.step.iter_mut().for_each(|step| step.at_area_mm2 = None);
        let of_step =
            |volume: f64, rate: f64, least: f64| 1.05 * volume / rate * (0.9 + 0.1 / (10.0 / least).powf(0.437));
        let slow = of_step(985.0, 40.0, 100.0) + of_step(10.0, 10.0, 50.0) + of_step(5.0, 2.0, 20.0);
        let time = minutes(&technology);
        assert!((time.estimated_min.unwrap() - slow).abs() < 1e-9);
        assert_eq!(time.not_considered[0].to_string(), "area of the rate of steps R, S, F is not given");
        // Equal pieces are one.
        let mut cut = burn(500.0, 100.0, Until::Vdi(20.0));
        cut.pieces.push(Piece { volume_mm3: 500.0, frontal_area_mm2: 100.0 });
        let cut = time_of(&choose(&complete(), &cut).unwrap(), None).unwrap();
        assert!((cut.estimated_min.unwrap() - whole).abs() < 1e-9);
    }

    #[test]
    fn finished_burns_scale_burning() {
        let ratios = |pairs: &[[f64; 2]]| Calibrated::from_burns(&finished(pairs)).unwrap();
        assert_eq!(ratios(&[]), None);
        let one = Calibrated { count: 1, mean: 1.25, least: None, greatest: None };
        assert_eq!(ratios(&[[80.0, 100.0]]), Some(one));
        // 40 minutes were estimated and 35 measured, although the ratios are 2 and 0.5.
        let two = Calibrated { count: 2, mean: 35.0 / 40.0, least: Some(0.5), greatest: Some(2.0) };
        assert_eq!(ratios(&[[10.0, 20.0], [30.0, 15.0]]), Some(two));
        let same = ratios(&[[3.0, 1.0], [3.0, 1.0], [3.0, 1.0]]).unwrap();
        assert!(same.least.unwrap() <= same.mean && same.mean <= same.greatest.unwrap());
        assert!(Calibrated::from_burns(&finished(&[[0.0, 1.0]])).is_err());
        let asked = burn(1000.0, 100.0, Until::Vdi(20.0));
        let three = ratios(&[[10.0, 9.0], [10.0, 16.0], [10.0, 11.0]]).unwrap();
        let technology = complete();
        let time = time_of(&choose(&technology, &asked).unwrap(), Some(three)).unwrap();
        let (estimated, burning) = (time.estimated_min.unwrap(), time.burning.unwrap());
        for (value, ratio) in [(burning.least.unwrap(), 0.9), (burning.mean, 1.2), (burning.greatest.unwrap(), 1.6)] {
            assert!((value - ratio * estimated).abs() < 1e-9, "{ratio}");
        }
        assert_eq!(time.calibration, Some(three));
    }

    #[test]
    fn a_missing_figure_is_named_and_never_zero() {
        let without = |change: Change| {
            let mut technology = complete();
            change(&mut technology.step[0]);
            time(&technology, 1000.0, 100.0)
        };
        let text = |list: &[Missing]| list.iter().map(ToString::to_string).collect::<Vec<_>>().join("; ");
        let whole = time(&complete(), 1000.0, 100.0).estimated_min.unwrap();
        let blocked: [(Change, &str); 2] = [
            (|s| s.rate_mm3_min = None, "rate of step R is not given"),
            (|s| s.stock_next_mm = None, "stock left for the next step of step R is not given"),
        ];
        for (change, said) in blocked {
            let time = without(change);
            assert_eq!((time.estimated_min, time.burning), (None, None), "{said}");
            assert_eq!(text(&time.missing), said);
            assert_eq!(time.steps[2].minutes, Some(5.0 / 2.0 * 1.05), "what is known of the others stays");
        }
        let rough = 985.0 / 40.0;
        let unaware: [(Change, &str, f64); 6] = [
            (|s| s.jump_mm = None, "jump of step R is not given", whole - 0.05 * rough),
            (|s| s.jump_every_s = None, "jump of step R is not given", whole - 0.05 * rough),
            (|s| s.jump_speed = None, "jump of step R is not given", whole - 0.05 * rough),
            (|s| s.at_area_mm2 = None, "area of the rate of step R is not given", whole),
            (|s| s.ip_a = None, "peak current of step R is not given", whole),
            (|s| s.max_density_a_cm2 = None, "greatest current density of step R is not given", whole),
        ];
        for (change, said, minutes) in unaware {
            let time = without(change);
            assert_eq!(text(&time.not_considered), said);
            assert!((time.estimated_min.unwrap() - minutes).abs() < 1e-9, "{said}");
        }
        // Figures that times do not rest on change nothing.
        let unused: [Change; 11] = [
            |s| s.vendor_code = None,
            |s| s.on_us = None,
            |s| s.off_us = None,
            |s| s.servo_v = None,
            |s| s.open_v = None,
            |s| s.gap_side_mm = None,
            |s| s.gap_front_mm = None,
            |s| s.wear_percent = None,
            |s| s.corner_wear_mm = None,
            |s| s.orbit_mm = None,
            |s| s.recast_um = None,
        ];
        for change in unused {
            assert_eq!(without(change), time(&complete(), 1000.0, 100.0));
        }
        let mut nameless = complete();
        nameless.step.iter_mut().for_each(|step| step.vdi = None);
        let time = time(&nameless, 1000.0, 100.0);
        assert_eq!((time.estimated_min, time.missing.len()), (None, 1), "no step is not no time");
    }

    #[test]
    fn a_sum_is_known_where_all_its_burns_are() {
        let known = time(&complete(), 1000.0, 100.0).burning;
        let mut technology = complete();
        technology.step[2].rate_mm3_min = None;
        let unknown = time(&technology, 1000.0, 100.0).burning;
        let minutes = known.unwrap().mean;
        let twice = sum_of([known, known], Overhead::default()).unwrap().unwrap();
        assert!((twice.mean - 2.0 * minutes).abs() < 1e-12);
        // Set up once, changed twice.
        let overhead = Overhead { setup_min: 30.0, change_min: 4.0 };
        let three = sum_of([known, known, known], overhead).unwrap().unwrap();
        assert!((three.mean - 3.0 * minutes - 38.0).abs() < 1e-12);
        assert_eq!(sum_of([known, unknown], overhead), Ok(None), "a missing time is not zero");
        assert_eq!(sum_of([], Overhead::default()), Ok(Some(Spread::certain(0.0))));
        assert!(sum_of([known], Overhead { setup_min: -1.0, change_min: 0.0 }).is_err());
    }

    #[test]
    fn jumps_need_height_interval_and_speed() {
        let step = complete().step[0].clone();
        assert!((jump_factor(&step).unwrap() - 1.05).abs() < 1e-15);
        assert_eq!(jump_factor(&Step { jump_mm: Some(0.0), ..step.clone() }), Some(1.0));
        assert_eq!(jump_factor(&Step { jump_speed: Some(0.0), ..step }), None);
    }

    #[test]
    fn spreads_add_where_both_are_known() {
        let known = Spread { least: Some(1.0), mean: 2.0, greatest: Some(4.0) };
        assert_eq!(known.plus(Spread::exactly(1.0)), Spread::exactly(3.0));
        let sum = Spread { least: Some(2.0), mean: 3.0, greatest: Some(5.0) };
        assert_eq!(known.plus(Spread::certain(1.0)), sum);
        assert!(known.validate().is_ok());
        assert!(Spread { least: Some(3.0), ..known }.validate().is_err());
        assert!(Spread { greatest: Some(f64::NAN), ..known }.validate().is_err());
    }

    proptest! {
        #[test]
        fn more_volume_never_takes_less_time(volume in 0.0..1e5, more in 0.0..1e5, area in 20.0..1e4) {
            let technology = complete();
            let [less, more] = [volume, volume + more].map(|v| time(&technology, v, area).estimated_min.unwrap());
            prop_assert!(more >= less * (1.0 - 1e-12), "{less} {more}");
        }

        /// Roughing through all of the volume is no slower than what is computed, finishing all of it no faster.
        #[test]
        fn minutes_lie_between_all_rough_and_all_fine(volume in 0.0..1e5, area in 100.0..1e4) {
            let minutes = time(&complete(), volume, area).estimated_min.unwrap();
            let [rough, fine] = [40.0, 2.0].map(|rate| volume / rate * 1.05);
            prop_assert!(rough * (1.0 - 1e-12) <= minutes && minutes <= fine * (1.0 + 1e-12));
        }
    }
}
