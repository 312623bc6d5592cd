//! Minutes that an electrode burns in one place, what they rest on, and what is missing.

use files::{Invalid, Validate};
use serde::{Deserialize, Serialize};

use crate::choice::{Burn, Choice, Figure, Missing, Outside, choose};
use crate::technology::{Basis, Calibration, Step, Technology};
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

    /// Both after each other. The spread is known if both are; all burns are taken to be slow or fast together.
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

/// Minutes around a burn.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Overhead {
    /// Setting up, positioning and measuring for one burn (minutes).
    pub setup_min: f64,
    /// Changing the electrode for one burn (minutes).
    pub change_min: f64,
}

impl Validate for Overhead {
    fn validate(&self) -> Result<(), Invalid> {
        Invalid::unless_within("setup_min", self.setup_min, [0.0, 1e6], "min")?;
        Invalid::unless_within("change_min", self.change_min, [0.0, 1e6], "min")
    }
}

/// What finished burns of a technology say about estimated minutes.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Calibrated {
    /// Number of finished burns.
    pub count: usize,
    /// Geometric mean of measured to estimated minutes.
    pub mean: f64,
    /// Least ratio; none for a single burn, which has no spread.
    pub least: Option<f64>,
    /// Greatest ratio; none for a single burn, which has no spread.
    pub greatest: Option<f64>,
}

impl Calibrated {
    /// Ratio of measured to estimated minutes of these finished burns; none without any.
    ///
    /// The ratio is a factor, so its mean is the geometric one: twice as long and half as long cancel.
    ///
    /// # Errors
    /// The first burn whose minutes are not possible.
    pub fn from_burns<'a>(burns: impl IntoIterator<Item = &'a Calibration>) -> Result<Option<Self>, Invalid> {
        let (mut count, mut sum) = (0_usize, 0.0);
        let [mut least, mut greatest] = [f64::INFINITY, 0.0_f64];
        for (i, burn) in burns.into_iter().enumerate() {
            burn.validate().map_err(|problem| problem.within(&format!("calibration[{i}]")))?;
            let ratio = burn.measured_min / burn.estimated_min;
            count += 1;
            sum += ratio.ln();
            [least, greatest] = [least.min(ratio), greatest.max(ratio)];
        }
        if count == 0 {
            return Ok(None);
        }
        // Rounding must not put the mean outside its limits.
        let mean = (sum / count as f64).exp().max(least).min(greatest);
        let spread = |ratio| (count > 1).then_some(ratio);
        Ok(Some(Self { count, mean, least: spread(least), greatest: spread(greatest) }))
    }

    /// Estimated minutes scaled by the finished burns.
    pub fn scale(&self, estimated_min: f64) -> Spread {
        Spread { least: self.least, mean: self.mean, greatest: self.greatest }.times(estimated_min)
    }
}

/// A step of a burn with its time.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct StepTime {
    /// Name of the step.
    pub step: String,
    /// Volume that it removes (mm³); none if not known.
    pub volume_mm3: Option<f64>,
    /// Removal rate on this area without jumps (mm³ per minute); none if not given.
    pub rate_mm3_min: Option<f64>,
    /// Factor by which jumps lengthen the time; none if they are not given.
    pub jump_factor: Option<f64>,
    /// Time with jumps, not calibrated (minutes); none if volume or rate is not known.
    pub minutes: Option<f64>,
}

/// Time of a burn.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct BurnTime {
    /// Id of the technology.
    pub technology: String,
    /// What the figures of the technology rest on.
    pub basis: Basis,
    /// The steps, from rough to fine.
    pub steps: Vec<StepTime>,
    /// Whether layers are counted over the burned surface; over the frontal area where that is not known.
    pub burned_area_given: bool,
    /// Finished burns that scale the time; none if there are none.
    pub calibration: Option<Calibrated>,
    /// Time of burning with jumps, not calibrated (minutes); none if a figure is missing.
    pub estimated_min: Option<f64>,
    /// Time of burning with jumps, calibrated (minutes); none if a figure is missing.
    pub burning: Option<Spread>,
    /// Minutes of set-up and changing.
    pub overhead: Overhead,
    /// Time with set-up and changing (minutes); none if a figure is missing.
    pub total: Option<Spread>,
    /// Figures without which there is no time.
    pub missing: Vec<Missing>,
    /// Figures that the time does without.
    pub not_considered: Vec<Missing>,
    /// Ranges of the technology that the burn leaves.
    pub outside: Vec<Outside>,
}

/// Time of a burn with a technology, scaled by finished burns where there are any.
///
/// Chooses the steps, then as [`time_of_steps`].
///
/// # Errors
/// As [`choose`], and for minutes that are not possible.
pub fn burn_time(
    technology: &Technology,
    burn: &Burn,
    calibration: Option<&Calibrated>,
    overhead: Overhead,
) -> Result<BurnTime, BurningError> {
    time_of_steps(&choose(technology, burn)?, calibration, overhead)
}

/// Time of chosen steps: the sum of volume / (rate times area factor) times the jump factor, scaled by finished burns,
/// plus set-up and changing.
///
/// Calibration scales burning only. A step whose rate is stated without an area has this rate on every area.
///
/// # Errors
/// [`BurningError`] for minutes that are not possible.
pub fn time_of_steps(
    choice: &Choice,
    calibration: Option<&Calibrated>,
    overhead: Overhead,
) -> Result<BurnTime, BurningError> {
    overhead.validate()?;
    let (mut missing, mut not_considered) = (choice.missing.clone(), choice.not_considered.clone());
    let mut steps = Vec::with_capacity(choice.steps.len());
    for chosen in &choice.steps {
        let step = chosen.step;
        let area_factor =
            step.at_area_mm2.map_or(Ok(1.0), |stated| rules::area_factor(choice.frontal_area_mm2, stated))?;
        let rate = step.rate_mm3_min.map(|rate| rate * area_factor);
        let jump_factor = jump_factor(step);
        let minutes = match (chosen.volume_mm3, rate) {
            (Some(0.0), _) => Some(0.0),
            (volume, Some(rate)) => volume.map(|volume| volume / rate * jump_factor.unwrap_or(1.0)),
            (_, None) => {
                missing.push(Missing::of(step, Figure::Rate));
                None
            }
        };
        let unstated = (rate.is_some() && step.at_area_mm2.is_none()).then_some(Figure::RateArea);
        let no_jump = jump_factor.is_none().then_some(Figure::Jump);
        not_considered.extend([unstated, no_jump].into_iter().flatten().map(|figure| Missing::of(step, figure)));
        let volume_mm3 = chosen.volume_mm3;
        steps.push(StepTime { step: step.name.clone(), volume_mm3, rate_mm3_min: rate, jump_factor, minutes });
    }
    // No step at all is no time of zero: the steps are not known.
    let all: Option<f64> = steps.iter().map(|step| step.minutes).sum();
    let estimated_min = all.filter(|_| !steps.is_empty() && missing.is_empty());
    let burning = estimated_min
        .map(|estimated| calibration.map_or(Spread::exactly(estimated), |calibration| calibration.scale(estimated)));
    let around = Spread::certain(overhead.setup_min + overhead.change_min);
    Ok(BurnTime {
        technology: choice.technology.id.clone(),
        basis: choice.technology.basis,
        steps,
        burned_area_given: choice.burned_area_given,
        calibration: calibration.copied(),
        estimated_min,
        burning,
        overhead,
        total: burning.map(|burning| burning.plus(around)),
        missing,
        not_considered,
        outside: choice.outside.clone(),
    })
}

/// Time of several burns, one after the other, with their set-up and changing (minutes): those of a channel, or of a
/// mold. None if one of them is not known.
pub fn sum_of<'a>(times: impl IntoIterator<Item = &'a BurnTime>) -> Option<Spread> {
    times.into_iter().try_fold(Spread::certain(0.0), |sum, time| Some(sum.plus(time.total?)))
}

/// Factor by which jumps lengthen burning: 1 + (2 height / speed) / interval. None unless all three are given.
pub fn jump_factor(step: &Step) -> Option<f64> {
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
    use crate::choice::Until;
    use crate::choice::tests::{burn, complete};

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
        burn_time(technology, &burn(volume, area, Until::Vdi(20.0)), None, Overhead::default()).unwrap()
    }

    /// 985 / 40 + 10 / 10 + 5 / 2 minutes; a jump of 2 mm at 80 mm/s takes 0.05 s in each second of burning.
    #[test]
    fn minutes_are_those_computed_by_hand() {
        let overhead = Overhead { setup_min: 10.0, change_min: 3.0 };
        let asked = burn(1000.0, 100.0, Until::Vdi(20.0));
        let time = burn_time(&complete(), &asked, None, overhead).unwrap();
        let minutes = (985.0 / 40.0 + 10.0 / 10.0 + 5.0 / 2.0) * 1.05;
        assert!((time.estimated_min.unwrap() - minutes).abs() < 1e-12);
        let [burning, total] = [time.burning.unwrap(), time.total.unwrap()];
        assert!((burning.mean - minutes).abs() < 1e-12 && (total.mean - minutes - 13.0).abs() < 1e-12);
        assert_eq!((burning.least, total.greatest), (None, None), "without finished burns there is no spread");
        let rests_on = (time.technology.as_str(), time.basis, time.burned_area_given, time.calibration);
        assert_eq!(rests_on, ("complete", Basis::Measured, false, None));
        assert_eq!(time.steps.iter().map(|step| step.step.as_str()).collect::<String>(), "RSF");
        assert!(time.missing.is_empty() && time.not_considered.is_empty() && time.outside.is_empty());
        // Half the stated area, where only S and F may burn: the rate falls by 0.5^0.437.
        let half = super::tests::time(&complete(), 1000.0, 50.0);
        let minutes = (997.5 / 10.0 + 2.5 / 2.0) * 1.05 / 0.5f64.powf(0.437);
        assert!((half.estimated_min.unwrap() - minutes).abs() < 1e-9);
    }

    #[test]
    fn finished_burns_scale_burning_but_not_the_overhead() {
        let ratios = |pairs: &[[f64; 2]]| Calibrated::from_burns(&finished(pairs)).unwrap();
        assert_eq!(ratios(&[]), None);
        let one = Calibrated { count: 1, mean: 1.25, least: None, greatest: None };
        assert_eq!(ratios(&[[80.0, 100.0]]), Some(one));
        // Twice and half as long cancel.
        let two = ratios(&[[10.0, 20.0], [30.0, 15.0]]).unwrap();
        assert_eq!((two.count, two.least, two.greatest), (2, Some(0.5), Some(2.0)));
        assert!((two.mean - 1.0).abs() < 1e-15);
        let same = ratios(&[[3.0, 1.0], [3.0, 1.0], [3.0, 1.0]]).unwrap();
        assert!(same.least.unwrap() <= same.mean && same.mean <= same.greatest.unwrap());
        assert!(Calibrated::from_burns(&finished(&[[0.0, 1.0]])).is_err());
        let overhead = Overhead { setup_min: 7.0, change_min: 0.0 };
        let asked = burn(1000.0, 100.0, Until::Vdi(20.0));
        let three = ratios(&[[10.0, 9.0], [10.0, 16.0], [10.0, 12.0]]).unwrap();
        let time = burn_time(&complete(), &asked, Some(&three), overhead).unwrap();
        let estimated = time.estimated_min.unwrap();
        let total = time.total.unwrap();
        for (value, ratio) in [(total.least.unwrap(), 0.9), (total.mean, 1.2), (total.greatest.unwrap(), 1.6)] {
            assert!((value - 7.0 - ratio * estimated).abs() < 1e-9, "{ratio}");
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
            assert_eq!((time.estimated_min, time.burning, time.total), (None, None, None), "{said}");
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
        assert_eq!((time.estimated_min, time.missing.len()), (None, 3), "no step is not no time");
    }

    #[test]
    fn a_sum_is_known_where_all_its_burns_are() {
        let known = time(&complete(), 1000.0, 100.0);
        let mut technology = complete();
        technology.step[2].rate_mm3_min = None;
        let unknown = time(&technology, 1000.0, 100.0);
        let twice = sum_of([&known, &known]).unwrap();
        assert!((twice.mean - 2.0 * known.total.unwrap().mean).abs() < 1e-12);
        assert_eq!(sum_of([&known, &unknown]), None, "a missing time is not zero");
        assert_eq!(sum_of([]), Some(Spread::certain(0.0)));
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
        let wrong = Overhead { setup_min: -1.0, change_min: 0.0 };
        assert!(burn_time(&complete(), &burn(1.0, 100.0, Until::Vdi(20.0)), None, wrong).is_err());
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
