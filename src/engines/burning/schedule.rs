//! Schedule of a wheel: when each electrode burns each channel, with indexing and changes of electrodes.

use files::{Invalid, Validate};
use serde::{Deserialize, Serialize};

use crate::duration::Spread;
use crate::estimate::Estimate;
use crate::wear::{AllowedWear, Assignment, WearShare, share_out, whole_electrodes};
use crate::{BurningError, MOST_ROWS};

/// The most electrodes of a channel.
const MOST_ELECTRODES: usize = 1000;

/// An electrode of a channel, as a schedule needs it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ScheduledElectrode {
    /// Name.
    pub name: String,
    /// Burning in one channel, without set-up and changing (minutes).
    pub burning: Spread,
    /// Share of the allowed wear that one channel uses up; not known if it is not given.
    #[serde(default)]
    pub wear_share: WearShare,
}

impl ScheduledElectrode {
    /// An electrode with the time and the wear of its burn. None if a figure of the time is missing, as
    /// [`BurnTime::missing`](crate::duration::BurnTime::missing) says.
    ///
    /// # Errors
    /// [`BurningError::Invalid`] for limits of wear that are not possible.
    pub fn from_estimate(
        name: impl Into<String>,
        estimate: &Estimate,
        allowed: AllowedWear,
    ) -> Result<Option<Self>, BurningError> {
        let wear_share = estimate.wear.share_of(allowed)?;
        Ok(estimate.time.burning.map(|burning| Self { name: name.into(), burning, wear_share }))
    }
}

impl Validate for ScheduledElectrode {
    fn validate(&self) -> Result<(), Invalid> {
        self.burning.validate().map_err(|problem| problem.within("burning"))?;
        Invalid::unless_within("wear_share", self.wear_share.at_least(), [0.0, f64::INFINITY], "")
    }
}

/// Order in which the channels of a wheel are burned.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Order {
    /// All channels with the first electrode, then all with the second one: few changes, much indexing.
    #[default]
    ByElectrode,
    /// Each channel with all electrodes before the next channel: little indexing, many changes.
    ByChannel,
}

/// A wheel to burn. All its channels are alike.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WheelBurn {
    /// Number of channels.
    pub channels: usize,
    /// The electrodes of a channel, in the order in which they burn.
    pub electrodes: Vec<ScheduledElectrode>,
    /// Order of the channels.
    #[serde(default)]
    pub order: Order,
    /// Setting the wheel and the first electrode up (minutes).
    pub setup_min: f64,
    /// Indexing to another channel (minutes).
    pub indexing_min: f64,
    /// Changing the electrode, with measuring it (minutes).
    pub change_min: f64,
}

impl Validate for WheelBurn {
    fn validate(&self) -> Result<(), Invalid> {
        if self.channels == 0 || self.channels > MOST_ROWS {
            let remedy = format!("must be from 1 to {MOST_ROWS}");
            return Err(Invalid::new("channels", self.channels, remedy));
        }
        let count = self.electrodes.len();
        if count == 0 || count > MOST_ELECTRODES {
            let remedy = format!("there are {count}; from 1 to {MOST_ELECTRODES} are possible");
            return Err(Invalid::of("electrodes", remedy));
        }
        for (i, electrode) in self.electrodes.iter().enumerate() {
            electrode.validate().map_err(|problem| problem.within(&format!("electrodes[{i}]")))?;
        }
        let minutes =
            [("setup_min", self.setup_min), ("indexing_min", self.indexing_min), ("change_min", self.change_min)];
        minutes.into_iter().try_for_each(|(key, value)| Invalid::unless_within(key, value, [0.0, 1e6], "min"))
    }
}

/// Kind of a row of a schedule.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Activity {
    /// Setting the wheel and the first electrode up.
    SetUp,
    /// Indexing to the channel.
    Indexing,
    /// Changing to the electrode.
    Change,
    /// Burning.
    Burn,
}

/// A row of a schedule.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Row {
    /// Kind of the row.
    pub activity: Activity,
    /// Channel that it is done for, from 0 in the order of indexing.
    pub channel: usize,
    /// Electrode, from 0 in the order of burning.
    pub electrode: usize,
    /// Copy of this electrode, from 0.
    pub copy: usize,
    /// Start after the beginning of the set-up (minutes).
    pub start_min: f64,
    /// Mean duration (minutes).
    pub minutes: f64,
}

impl Row {
    /// Whether the electrode is changed.
    pub fn is_change(&self) -> bool {
        self.activity == Activity::Change
    }
}

/// Times of a channel.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ChannelTotal {
    /// Channel, from 0 in the order of indexing.
    pub channel: usize,
    /// Burning with all electrodes (minutes).
    pub burning: Spread,
    /// Indexing to this channel and changing electrodes for it (minutes).
    pub other_min: f64,
}

impl ChannelTotal {
    /// Burning, indexing and changing (hours).
    pub fn hours(&self) -> Spread {
        self.burning.plus(Spread::certain(self.other_min)).times(HOURS)
    }
}

/// Times and copies of an electrode.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ElectrodeTotal {
    /// Name.
    pub name: String,
    /// Burning in all channels (minutes).
    pub burning: Spread,
    /// Number of copies that the wheel needs; at least so many where the wear is not known.
    pub copies: usize,
    /// Share of the allowed wear that one channel uses up.
    pub wear_share: WearShare,
}

/// Schedule of a wheel.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Schedule {
    /// All that is done, one after the other without a pause.
    pub rows: Vec<Row>,
    /// Times of each channel. The set-up belongs to none.
    pub channels: Vec<ChannelTotal>,
    /// Times and copies of each electrode.
    pub electrodes: Vec<ElectrodeTotal>,
    /// Burning (minutes).
    pub burning: Spread,
    /// Set-up (minutes).
    pub setup_min: f64,
    /// All indexing (minutes).
    pub indexing_min: f64,
    /// All changes of electrodes (minutes).
    pub changing_min: f64,
    /// Number of times that the wheel is indexed.
    pub indexings: usize,
    /// Number of changes of electrodes.
    pub changes: usize,
    /// Number of these changes that put a fresh copy in the place of a worn one.
    pub changes_for_wear: usize,
    /// Names of the electrodes whose wear is not known: they may need more copies, changes and hours.
    pub not_considered: Vec<String>,
}

/// Hours in a minute.
const HOURS: f64 = 1.0 / 60.0;

impl Schedule {
    /// All of the wheel (minutes).
    pub fn total(&self) -> Spread {
        self.burning.plus(Spread::certain(self.setup_min + self.indexing_min + self.changing_min))
    }

    /// All of the wheel (hours).
    pub fn hours(&self) -> Spread {
        self.total().times(HOURS)
    }
}

/// The schedule of a wheel.
///
/// The wheel starts at its first channel with the first electrode mounted. It is indexed whenever the next burn is in
/// another channel. The electrode is changed whenever the next burn needs another electrode or another copy; a change
/// after indexing is done in the new channel. Where channels are burned one by one, a fresh copy of a worn electrode comes
/// with the change that is due anyway.
///
/// # Errors
/// [`BurningError`] if the wheel is not possible, or needs more than [`MOST_ROWS`] rows.
pub fn schedule(wheel: &WheelBurn) -> Result<Schedule, BurningError> {
    wheel.validate()?;
    // Counted before anything is allocated: each channel takes as many burns as it wears electrodes away.
    let mut burns = 0_usize;
    for electrode in &wheel.electrodes {
        let of_channel = whole_electrodes(electrode.wear_share.at_least())?;
        burns = burns.saturating_add(wheel.channels.saturating_mul(of_channel));
    }
    if burns > MOST_ROWS {
        return Err(too_many(burns));
    }
    // The burns in their order: the electrode, and which copy burns which part of which channel.
    let mut order: Vec<(usize, Assignment)> = Vec::with_capacity(burns);
    let mut electrodes = Vec::with_capacity(wheel.electrodes.len());
    for (i, electrode) in wheel.electrodes.iter().enumerate() {
        let copies = share_out(&vec![electrode.wear_share.at_least(); wheel.channels])?;
        order.extend(copies.assignments.into_iter().map(|assignment| (i, assignment)));
        electrodes.push(ElectrodeTotal {
            name: electrode.name.clone(),
            burning: electrode.burning.times(wheel.channels as f64),
            copies: copies.count,
            wear_share: electrode.wear_share,
        });
    }
    if wheel.order == Order::ByChannel {
        // A stable order: electrodes and copies stay as they are within a channel.
        order.sort_by_key(|(_, assignment)| assignment.channel);
    }
    let unknown = wheel.electrodes.iter().filter(|electrode| electrode.wear_share.is_unknown());
    let of_channel = wheel.electrodes.iter().fold(Spread::certain(0.0), |sum, electrode| sum.plus(electrode.burning));
    let channel = |channel| ChannelTotal { channel, burning: of_channel, other_min: 0.0 };
    let mut schedule = Schedule {
        rows: Vec::with_capacity(2 * burns),
        channels: (0..wheel.channels).map(channel).collect(),
        electrodes,
        burning: of_channel.times(wheel.channels as f64),
        setup_min: wheel.setup_min,
        indexing_min: 0.0,
        changing_min: 0.0,
        indexings: 0,
        changes: 0,
        changes_for_wear: 0,
        not_considered: unknown.map(|electrode| electrode.name.clone()).collect(),
    };
    fill(wheel, &order, &mut schedule)?;
    Ok(schedule)
}

fn too_many(rows: usize) -> BurningError {
    BurningError::TooManyRows { what: "schedule", rows, most: MOST_ROWS }
}

/// Adds the rows of the burns, in this order, to a schedule without rows, and counts indexing and changes.
fn fill(wheel: &WheelBurn, order: &[(usize, Assignment)], schedule: &mut Schedule) -> Result<(), BurningError> {
    let mut clock = 0.0;
    let mut before: Option<(usize, Assignment)> = None;
    for &(electrode, Assignment { channel, copy, part, .. }) in order {
        let mut add = |activity, minutes| {
            if schedule.rows.len() >= MOST_ROWS {
                return Err(too_many(MOST_ROWS + 1));
            }
            schedule.rows.push(Row { activity, channel, electrode, copy, start_min: clock, minutes });
            clock += minutes;
            Ok(())
        };
        let is_indexed = before.is_some_and(|(_, before)| before.channel != channel);
        let is_changed = before.is_some_and(|(mounted, before)| (mounted, before.copy) != (electrode, copy));
        if before.is_none() {
            add(Activity::SetUp, wheel.setup_min)?;
        }
        if is_indexed {
            add(Activity::Indexing, wheel.indexing_min)?;
        }
        if is_changed {
            add(Activity::Change, wheel.change_min)?;
        }
        let burning = wheel.electrodes.get(electrode).map_or(0.0, |electrode| electrode.burning.mean);
        add(Activity::Burn, burning * part)?;
        let indexing = if is_indexed { wheel.indexing_min } else { 0.0 };
        let changing = if is_changed { wheel.change_min } else { 0.0 };
        schedule.indexings += usize::from(is_indexed);
        schedule.changes += usize::from(is_changed);
        schedule.changes_for_wear += usize::from(is_changed && before.is_some_and(|(mounted, _)| mounted == electrode));
        schedule.indexing_min += indexing;
        schedule.changing_min += changing;
        if let Some(total) = schedule.channels.get_mut(channel) {
            total.other_min += indexing + changing;
        }
        before = Some((electrode, Assignment { channel, copy, part, used: 0.0 }));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::choice::Until;
    use crate::choice::tests::{burn, complete};
    use crate::technology::{Calibration, TechnologyFile};
    use crate::wear::WearShare::{Known, Unknown, Unlimited};

    fn electrode(mean: f64, wear_share: WearShare) -> ScheduledElectrode {
        ScheduledElectrode { name: format!("E{mean}"), burning: Spread::exactly(mean), wear_share }
    }

    fn wheel(channels: usize, electrodes: Vec<ScheduledElectrode>, order: Order) -> WheelBurn {
        WheelBurn { channels, electrodes, order, setup_min: 30.0, indexing_min: 0.5, change_min: 4.0 }
    }

    /// Properties of every schedule.
    fn check(wheel: &WheelBurn, schedule: &Schedule) {
        let close = |a: f64, b: f64| assert!((a - b).abs() <= 1e-9 * (1.0 + b.abs()), "{a} is not {b}");
        let sum = |select: &dyn Fn(&Row) -> bool| -> f64 {
            schedule.rows.iter().filter(|row| select(row)).map(|row| row.minutes).sum()
        };
        close(sum(&|_| true), schedule.total().mean);
        close(sum(&|row| row.is_change()), schedule.changing_min);
        close(sum(&|row| row.activity == Activity::Indexing), schedule.indexing_min);
        close(sum(&|row| row.activity == Activity::Burn), schedule.burning.mean);
        let of_channels: f64 = schedule.channels.iter().map(|channel| 60.0 * channel.hours().mean).sum();
        close(of_channels + schedule.setup_min, schedule.total().mean);
        let of_electrodes: f64 = schedule.electrodes.iter().map(|electrode| electrode.burning.mean).sum();
        close(of_electrodes, schedule.burning.mean);
        for pair in schedule.rows.windows(2) {
            close(pair[0].start_min + pair[0].minutes, pair[1].start_min);
        }
        assert_eq!(schedule.rows.iter().filter(|row| row.is_change()).count(), schedule.changes);
        for (channel, total) in schedule.channels.iter().enumerate() {
            let burns = |row: &Row| row.channel == channel && row.activity == Activity::Burn;
            close(sum(&burns), total.burning.mean);
            // The electrodes of a channel burn in their order.
            let electrodes: Vec<_> = schedule.rows.iter().filter(|row| burns(row)).map(|row| row.electrode).collect();
            assert!(electrodes.is_sorted());
            assert!((0..wheel.electrodes.len()).all(|electrode| electrodes.contains(&electrode)));
        }
    }

    /// Minutes that add up to the hours of P1 (60 channels, 4.07 to 4.25 h each, 249.3 h in all). Only the addition is
    /// tested: the minutes of the four electrodes are made up.
    #[test]
    fn electrodes_and_channels_are_added_up() {
        let means = [120.0, 60.0, 40.0, 29.3];
        let burning =
            |mean: f64| Spread { least: Some(mean * 4.07 / 4.155), mean, greatest: Some(mean * 4.25 / 4.155) };
        let electrode =
            |mean| ScheduledElectrode { name: String::new(), burning: burning(mean), wear_share: Unlimited };
        for order in [Order::ByElectrode, Order::ByChannel] {
            let mut p1 = wheel(60, means.map(electrode).to_vec(), order);
            [p1.setup_min, p1.indexing_min, p1.change_min] = [0.0; 3];
            let schedule = schedule(&p1).unwrap();
            check(&p1, &schedule);
            assert!((schedule.hours().mean - 249.3).abs() < 1e-9);
            for channel in &schedule.channels {
                let hours = channel.hours();
                assert!((hours.least.unwrap() - 4.07).abs() < 1e-9);
                assert!((hours.mean - 4.155).abs() < 1e-9);
                assert!((hours.greatest.unwrap() - 4.25).abs() < 1e-9);
            }
            let burns = schedule.rows.iter().filter(|row| row.activity == Activity::Burn).count();
            assert_eq!((burns, schedule.channels.len()), (240, 60));
            assert!(
                schedule.electrodes.iter().all(|electrode| electrode.copies == 1) && schedule.not_considered.is_empty()
            );
        }
    }

    /// Five finished burns scale the time of one electrode: the spread reaches the channels and the wheel.
    #[test]
    fn finished_burns_give_least_and_greatest_hours() {
        let mut file = TechnologyFile { technology: vec![complete()], calibration: Vec::new() };
        let asked = burn(1000.0, 100.0, Until::Vdi(20.0));
        let plain = file.estimate("complete", &asked).unwrap().time.estimated_min.unwrap();
        let finished = |i: i32| Calibration {
            technology: "complete".to_owned(),
            estimated_min: 100.0,
            measured_min: 100.0 * 1.01f64.powi(i),
            date: None,
            source: None,
        };
        file.calibration = (-1..=3).map(finished).collect();
        let estimate = file.estimate("complete", &asked).unwrap();
        let electrode = ScheduledElectrode::from_estimate("E1", &estimate, AllowedWear::default()).unwrap().unwrap();
        let wheel = wheel(60, vec![electrode.clone(), electrode], Order::ByElectrode);
        let answer = schedule(&wheel).unwrap();
        check(&wheel, &answer);
        let total = answer.total();
        let other = 30.0 + 119.0 * 0.5 + 4.0;
        let mean = (-1..=3).map(|i| 1.01f64.powi(i)).sum::<f64>() / 5.0;
        let ratios = [(total.least, 1.0 / 1.01), (Some(total.mean), mean), (total.greatest, 1.01f64.powi(3))];
        for (minutes, ratio) in ratios {
            let (minutes, expected) = (minutes.unwrap(), other + 120.0 * plain * ratio);
            assert!((minutes - expected).abs() < 1e-6, "{minutes} is not {expected}");
        }
    }

    /// Closed forms: N channels and E electrodes take N E - 1 indexings and E - 1 changes, or N - 1 and N E - 1.
    #[test]
    fn indexing_and_changes_are_those_of_the_order() {
        for (channels, count) in [(60, 4), (3, 1), (1, 5), (1, 1), (7, 2)] {
            let electrodes: Vec<_> = (0..count).map(|i| electrode(1.0 + i as f64, Unlimited)).collect();
            let burns = channels * count;
            let by_electrode = wheel(channels, electrodes.clone(), Order::ByElectrode);
            let answer = schedule(&by_electrode).unwrap();
            check(&by_electrode, &answer);
            let indexings = if channels > 1 { burns - 1 } else { 0 };
            assert_eq!((answer.indexings, answer.changes, answer.changes_for_wear), (indexings, count - 1, 0));
            let by_channel = wheel(channels, electrodes, Order::ByChannel);
            let answer = schedule(&by_channel).unwrap();
            check(&by_channel, &answer);
            let changes = if count > 1 { burns - 1 } else { 0 };
            assert_eq!((answer.indexings, answer.changes, answer.changes_for_wear), (channels - 1, changes, 0));
            let minutes = 30.0 + 0.5 * (channels - 1) as f64 + 4.0 * changes as f64;
            let burning = (channels * count * (count + 1) / 2) as f64;
            assert!((answer.total().mean - minutes - burning).abs() < 1e-9);
        }
    }

    #[test]
    fn worn_electrodes_are_changed() {
        // 0.4 of the allowed wear: two channels each. The second electrode lasts for all.
        let electrodes = vec![electrode(10.0, Known(0.4)), electrode(5.0, Known(0.1))];
        let by_electrode = wheel(6, electrodes.clone(), Order::ByElectrode);
        let answer = schedule(&by_electrode).unwrap();
        check(&by_electrode, &answer);
        assert_eq!((answer.changes, answer.changes_for_wear), (3, 2));
        assert_eq!(answer.electrodes.iter().map(|e| e.copies).collect::<Vec<_>>(), [3, 1]);
        let burns = |schedule: &Schedule, electrode: usize| {
            let rows = schedule.rows.iter();
            let rows = rows.filter(|row| row.activity == Activity::Burn && row.electrode == electrode);
            rows.map(|row| row.copy).collect::<Vec<_>>()
        };
        assert_eq!((burns(&answer, 0), burns(&answer, 1)), (vec![0, 0, 1, 1, 2, 2], vec![0; 6]));
        // Channel by channel a fresh copy comes with a change that is due anyway.
        let by_channel = wheel(6, electrodes, Order::ByChannel);
        let answer = schedule(&by_channel).unwrap();
        check(&by_channel, &answer);
        assert_eq!((answer.changes, answer.changes_for_wear), (11, 0));
        assert_eq!(burns(&answer, 0), [0, 0, 1, 1, 2, 2]);
        // Two and a half electrodes a channel: each part burns for its share of the minutes.
        let much = wheel(1, vec![electrode(10.0, Known(2.5))], Order::ByChannel);
        let answer = schedule(&much).unwrap();
        check(&much, &answer);
        let minutes: Vec<f64> =
            answer.rows.iter().filter(|row| row.activity == Activity::Burn).map(|row| row.minutes).collect();
        assert!(minutes.iter().zip([4.0, 4.0, 2.0]).all(|(a, b)| (a - b).abs() < 1e-9), "{minutes:?}");
        assert_eq!((answer.changes, answer.changes_for_wear, answer.electrodes[0].copies), (2, 2, 3));
    }

    #[test]
    fn schedules_are_bounded() {
        let many = wheel(60_000, vec![electrode(1.0, Unlimited)], Order::ByElectrode);
        assert!(matches!(schedule(&many), Err(BurningError::TooManyRows { .. })), "an index and a burn a channel");
        let fits = wheel(50_000, vec![electrode(1.0, Unlimited)], Order::ByElectrode);
        assert_eq!(schedule(&fits).unwrap().rows.len(), 100_000);
        let worn = wheel(100, vec![electrode(1.0, Known(2000.0))], Order::ByElectrode);
        let said = schedule(&worn).unwrap_err().to_string();
        assert!(said.contains("at most 100000 are possible: give fewer channels"), "{said}");
        let huge = wheel(100_000, vec![electrode(1.0, Unlimited); 1000], Order::ByChannel);
        assert!(matches!(schedule(&huge), Err(BurningError::TooManyRows { .. })));
        // All burns are counted before one is made: 3 GB of them otherwise.
        let worn = wheel(1, vec![electrode(1.0, Known(99_999.0)); 1000], Order::ByChannel);
        let error = schedule(&worn).unwrap_err();
        assert_eq!(error, BurningError::TooManyRows { what: "schedule", rows: 99_999_000, most: MOST_ROWS });
    }

    /// Half of the allowed wear at least: two channels each at most, and the schedule says that it may be fewer.
    #[test]
    fn an_unknown_wear_is_named() {
        let electrodes = vec![electrode(10.0, Unknown { at_least: 0.5 }), electrode(5.0, Known(0.1))];
        let answer = schedule(&wheel(6, electrodes, Order::ByElectrode)).unwrap();
        assert_eq!(answer.not_considered, ["E10"]);
        assert_eq!(answer.electrodes.iter().map(|electrode| electrode.copies).collect::<Vec<_>>(), [3, 1]);
        assert_eq!((answer.changes_for_wear, answer.electrodes[0].wear_share), (2, Unknown { at_least: 0.5 }));
        let text = "name = \"E\"\n[burning]\nmean = 1.0\n";
        let read: ScheduledElectrode = toml::from_str(text).unwrap();
        assert_eq!(read.wear_share, Unknown { at_least: 0.0 }, "a share that is not given is not zero wear");
        for share in [Unlimited, Known(0.4), Unknown { at_least: 0.1 }] {
            let written = toml::to_string(&electrode(1.0, share)).unwrap();
            assert_eq!(toml::from_str::<ScheduledElectrode>(&written).unwrap().wear_share, share, "{written}");
        }
    }

    #[test]
    fn impossible_wheels_are_refused() {
        let good = wheel(2, vec![electrode(1.0, Unlimited)], Order::ByElectrode);
        let said = |wheel: WheelBurn| schedule(&wheel).unwrap_err().to_string();
        assert_eq!(said(WheelBurn { channels: 0, ..good.clone() }), "channels is 0: must be from 1 to 100000");
        assert!(said(WheelBurn { electrodes: Vec::new(), ..good.clone() }).contains("electrodes: there are 0"));
        assert!(said(WheelBurn { change_min: f64::NAN, ..good.clone() }).contains("change_min is NaN"));
        let wrong = WheelBurn { electrodes: vec![electrode(1.0, Known(f64::NAN))], ..good.clone() };
        assert!(said(wrong).contains("electrodes[0].wear_share is NaN"));
        let wrong = WheelBurn { electrodes: vec![electrode(-1.0, Unlimited)], ..good };
        assert!(said(wrong).contains("electrodes[0].burning.mean is -1"));
    }

    /// From a burn to a wheel; a time with a missing figure cannot be scheduled.
    #[test]
    fn only_known_times_are_scheduled() {
        let mut file = TechnologyFile { technology: vec![complete()], calibration: Vec::new() };
        let allowed = AllowedWear { end_mm: Some(0.227), corner_mm: None };
        let electrode = |file: &TechnologyFile| {
            let estimate = file.estimate("complete", &burn(1000.0, 100.0, Until::Vdi(20.0))).unwrap();
            ScheduledElectrode::from_estimate("E1", &estimate, allowed).unwrap()
        };
        let known = electrode(&file).unwrap();
        let minutes = known.burning.mean;
        // 0.1135 mm a channel: two channels each, so four changes.
        let answer = schedule(&wheel(10, vec![known], Order::ByChannel)).unwrap();
        assert!((answer.total().mean - (30.0 + 9.0 * 0.5 + 4.0 * 4.0 + 10.0 * minutes)).abs() < 1e-9);
        assert_eq!((answer.total().least, answer.total().greatest), (None, None));
        file.technology[0].step[1].rate_mm3_min = None;
        assert_eq!(electrode(&file), None);
    }

    proptest! {
        #[test]
        fn minutes_add_up(
            channels in 1..30_usize,
            electrodes in prop::collection::vec((0.0..300.0, prop::option::of(0.0..2.5)), 1..5),
            is_by_channel in any::<bool>(),
        ) {
            let electrodes = electrodes.into_iter().map(|(mean, share)| electrode(mean, share.map_or(Unlimited, Known))).collect();
            let order = if is_by_channel { Order::ByChannel } else { Order::ByElectrode };
            let wheel = wheel(channels, electrodes, order);
            check(&wheel, &schedule(&wheel).unwrap());
        }
    }
}
