//! Minutes and wear of the electrodes of a plan, and the schedule of the wheel.

use std::collections::BTreeMap;
use std::fmt::Write;

use burning::choice::{Burn, Piece};
use burning::duration::{Spread, sum_of};
use burning::figures::{BurnFigures, hours_text, minutes_text};
use burning::schedule::{Activity, Schedule, ScheduledElectrode, WheelBurn, schedule};
use burning::technology::TechnologyFile;
use burning::wear::share_out;
use serde::Serialize;

use super::outcome::{ElectrodeOutcome, PlanOutcome};
use crate::workspaces::blisk::document::job_file::PlanJob;
use crate::workspaces::technology::read_table;

/// Reason why there are no minutes where burning has no end.
const NO_END: &str =
    "neither a last step nor a finish is given (burning.last_step, burning.finish_vdi, or those of electrode.stage)";

/// Checks, before anything is planned, that the technology of `job` has every step at which burning ends.
///
/// # Errors
/// The parameter and the reason, in words.
pub fn check_ends(job: &PlanJob) -> Result<(), String> {
    let stages = (0..job.electrode.stages()).map(|stage| (stage, job.of_stage(stage)));
    for (stage, until) in stages.filter_map(|(stage, of_stage)| Some((stage, of_stage.burning.until()?))) {
        let key = match job.electrode.stage.get(stage) {
            Some(_) => format!("electrode.stage[{stage}].last_step"),
            None => "burning.last_step".to_owned(),
        };
        // A table that cannot be read is told with the minutes.
        let Ok(table) = read_table(&job.technology) else { return Ok(()) };
        table.check_end(&job.technology.id, &until).map_err(|error| format!("{key}: {error}"))?;
    }
    Ok(())
}

/// Burning of a wheel with the electrodes of a plan.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct WheelBurning {
    /// Number of channels of the wheel.
    pub channels: usize,
    /// The electrodes in the order in which they burn.
    pub electrodes: Vec<BurningElectrode>,
    /// Burning of one channel with all electrodes (minutes); none if that of one of them is not known.
    pub channel: Option<Spread>,
    /// Schedule of the wheel; none if the minutes of an electrode are not known.
    pub schedule: Option<Schedule>,
    /// Reason why there is no schedule.
    pub no_schedule: Option<String>,
}

/// An electrode of a wheel that is burned.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct BurningElectrode {
    /// Number of the electrode, counted from 1, and its stage if there are any.
    pub label: String,
    /// Minutes and wear in one channel.
    pub figures: BurnFigures,
    /// Number of electrodes that the wheel needs, as far as the wear is known; none if there would be too many.
    pub copies: Option<usize>,
}

impl BurningElectrode {
    /// Number of electrodes that the wheel needs, in words.
    pub fn needed_text(&self) -> String {
        self.copies.map_or_else(|| "too many to count".to_owned(), |copies| self.figures.needed_text(copies))
    }
}

impl WheelBurning {
    /// Burning with the technology of `job`, whose table is read. None as long as the residual stock of the plan is not
    /// computed, and for a plan that is not verified.
    pub fn of_job(outcome: &PlanOutcome, job: &PlanJob) -> Option<Self> {
        let stock = outcome.stock().filter(|_| outcome.is_verified())?;
        let whole = &job.electrode;
        let table = read_table(&job.technology).map_err(|error| error.to_string());
        let removed = stock.left.as_ref().map(|left| left.removed.as_slice());
        let of = |(i, electrode): (usize, &ElectrodeOutcome)| match (&removed, &table) {
            (Err(why), _) => BurnFigures::unknown(why),
            (_, Err(why)) => BurnFigures::unknown(why),
            (Ok(removed), Ok(table)) => {
                let (job, _) = job.of_electrode(i);
                // What its stage leaves is left by the electrode, and not by its steps.
                let gap_mm = whole.burned_gap_mm(i);
                figures((electrode, gap_mm), removed.get(i).map_or(&[], Vec::as_slice), &job, table)
            }
        };
        Some(Self::of(outcome.electrodes.iter().enumerate().map(of).collect(), outcome.channel.blades, job))
    }

    /// Burning of a wheel with so many channels, given the figures of each electrode in one channel.
    fn of(figures: Vec<BurnFigures>, channels: usize, job: &PlanJob) -> Self {
        let copies = |figures: &BurnFigures| {
            share_out(&vec![figures.wear_share.at_least(); channels]).ok().map(|copies| copies.count)
        };
        let channel = sum_of(figures.iter().map(|figures| figures.minutes), Default::default()).ok().flatten();
        let made = scheduled(&figures, channels, job);
        let electrode = |(i, figures): (usize, BurnFigures)| {
            let (label, copies) = (job.electrode.label(i), copies(&figures));
            BurningElectrode { label, copies, figures }
        };
        let electrodes = figures.into_iter().enumerate().map(electrode).collect();
        let (schedule, no_schedule) = made.map_or_else(|why| (None, Some(why)), |schedule| (Some(schedule), None));
        Self { channels, electrodes, channel, schedule, no_schedule }
    }

    /// The answer in a sentence.
    pub fn sentence(&self) -> String {
        let total = self.schedule.as_ref().map(Schedule::total);
        let mut text = format!(
            "Burning of a channel: {}; of the wheel of {} channels with set-up, indexing and changes: {}.",
            minutes_text(self.channel),
            self.channels,
            hours_text(total)
        );
        if let Some(why) = &self.no_schedule {
            text += &format!(" There is no schedule: {why}.");
        }
        let unknown: Vec<String> = self.schedule.iter().flat_map(|schedule| schedule.not_considered.clone()).collect();
        if !unknown.is_empty() {
            text +=
                &format!(" Wear is not considered: {}; more electrodes and hours may be needed.", unknown.join(", "));
        }
        text
    }
}

fn figures(
    (outcome, gap_mm): (&ElectrodeOutcome, f64),
    removed: &[Piece],
    job: &PlanJob,
    table: &TechnologyFile,
) -> BurnFigures {
    let Some(until) = job.burning.until() else { return BurnFigures::unknown(NO_END) };
    if removed.is_empty() {
        return BurnFigures::idle();
    }
    let area = outcome.electrode.burn_area_mm2;
    let burn = Burn {
        burned_area_mm2: (area > 0.0).then_some(area),
        undersize_mm: Some(gap_mm),
        depth_to_width: None,
        from: None,
        until,
        pieces: removed.to_vec(),
    };
    BurnFigures::of(table, &job.technology, &burn)
}

fn scheduled(figures: &[BurnFigures], channels: usize, job: &PlanJob) -> Result<Schedule, String> {
    let electrode = |(i, figures): (usize, &BurnFigures)| {
        let name = format!("electrode {}", job.electrode.label(i));
        let burning = figures.minutes.ok_or_else(|| format!("the minutes of {name} are not known"))?;
        Ok::<_, String>(ScheduledElectrode { name, burning, wear_share: figures.wear_share })
    };
    let wheel = WheelBurn {
        channels,
        electrodes: figures.iter().enumerate().map(electrode).collect::<Result<_, _>>()?,
        order: job.burning.order,
        setup_min: job.technology.overhead.setup_min,
        indexing_min: job.burning.indexing_min,
        change_min: job.technology.overhead.change_min,
    };
    schedule(&wheel).map_err(|error| error.to_string())
}

/// Name of an activity in tables.
fn activity(of: Activity) -> &'static str {
    match of {
        Activity::SetUp => "set-up",
        Activity::Indexing => "indexing",
        Activity::Change => "change",
        Activity::Burn => "burn",
    }
}

/// A schedule of these electrodes as a table. Channels count from 0 as in a project, electrodes and their copies from 1. The wear
/// of a burn is the length that the front of the copy has lost in the burns before (mm); empty where it is not known.
pub fn schedule_csv(schedule: &Schedule, electrodes: &[BurningElectrode]) -> String {
    let mut csv = "row,activity,channel,electrode,copy,start_min,minutes,is_change,wear_mm\n".to_owned();
    let mut burned: BTreeMap<(usize, usize), f64> = BTreeMap::new();
    for (i, row) in schedule.rows.iter().enumerate() {
        let mut wear = String::new();
        if row.activity == Activity::Burn {
            let minutes = burned.entry((row.electrode, row.copy)).or_default();
            let figures = electrodes.get(row.electrode).map(|electrode| &electrode.figures);
            let of_channel = figures.and_then(|of| of.end_wear_mm.zip(of.minutes)).filter(|(_, of)| of.mean > 0.0);
            wear = match of_channel {
                _ if *minutes == 0.0 => "0.0000".to_owned(),
                Some((wear, of)) => format!("{:.4}", wear * *minutes / of.mean),
                None => String::new(),
            };
            *minutes += row.minutes;
        }
        // Writing into a string does not fail.
        let _ = writeln!(
            csv,
            "{},{},{},{},{},{:.3},{:.3},{},{wear}",
            i + 1,
            activity(row.activity),
            row.channel,
            row.electrode + 1,
            row.copy + 1,
            row.start_min,
            row.minutes,
            u8::from(row.is_change())
        );
    }
    csv
}

#[cfg(test)]
mod tests {
    use super::*;
    use burning::wear::WearShare;
    use wheel::electrode::StageParams;

    fn job() -> PlanJob {
        let mut job = PlanJob::demonstration();
        job.technology.overhead.setup_min = 30.0;
        job.technology.overhead.change_min = 4.0;
        job.burning.indexing_min = 0.5;
        job
    }

    fn known(minutes: f64, wear_share: WearShare) -> BurnFigures {
        BurnFigures { minutes: Some(Spread::exactly(minutes)), wear_share, ..BurnFigures::default() }
    }

    /// Two electrodes of 20 and 10 minutes in 60 channels: by electrode, the wheel is indexed 59 times, back to the
    /// first channel with the second electrode, and 59 times again.
    #[test]
    fn hours_of_a_wheel_are_those_of_its_channels() {
        let figures = vec![known(20.0, WearShare::Unlimited), known(10.0, WearShare::Unlimited)];
        let wheel = WheelBurning::of(figures, 60, &job());
        assert_eq!(wheel.channel, Some(Spread::exactly(30.0)));
        let schedule = wheel.schedule.as_ref().unwrap();
        assert_eq!((schedule.indexings, schedule.changes), (119, 1));
        let minutes = 60.0 * 30.0 + 30.0 + 0.5 * 119.0 + 4.0;
        assert!((schedule.total().mean - minutes).abs() < 1e-9);
        assert!(wheel.sentence().contains(&format!("{:.1} h", minutes / 60.0)), "{}", wheel.sentence());
        let worn = WheelBurning::of(vec![known(20.0, WearShare::Known(0.25))], 60, &job());
        assert_eq!(worn.electrodes[0].copies, Some(15), "four channels each");
        assert_eq!(worn.schedule.unwrap().changes_for_wear, 14);
    }

    #[test]
    fn a_step_that_the_technology_does_not_have_is_told_before_the_plan() {
        let mut of = job();
        assert_eq!(check_ends(&of), Ok(()), "no end is none that is missing");
        of.burning.last_step = "S1".to_owned();
        assert_eq!(check_ends(&of), Ok(()));
        of.burning.last_step = "S9".to_owned();
        let said = check_ends(&of).unwrap_err();
        assert!(said.contains("burning.last_step") && said.contains("no step S9; its steps are R3"), "{said}");
        let stage = |last_step: &str| StageParams { last_step: last_step.to_owned(), ..StageParams::default() };
        of.electrode.stage = vec![stage("R1"), stage("S7")];
        let said = check_ends(&of).unwrap_err();
        assert!(said.contains("electrode.stage[1].last_step") && said.contains("S7"), "{said}");
    }

    #[test]
    fn minutes_and_wear_that_are_not_known_are_not_zero() {
        let unknown = BurnFigures::unknown("rate of step F3 is not given");
        let wheel = WheelBurning::of(vec![known(20.0, WearShare::Unlimited), unknown], 60, &job());
        assert_eq!((wheel.channel, &wheel.schedule), (None, &None));
        let said = wheel.sentence();
        assert!(said.contains("a channel: not known") && said.contains("changes: not known"), "{said}");
        assert!(said.contains("the minutes of electrode 2 are not known"), "{said}");
        let unworn = WheelBurning::of(vec![known(20.0, WearShare::Unknown { at_least: 0.0 })], 60, &job());
        assert_eq!(unworn.electrodes[0].needed_text(), "at least 1: wear not considered");
        assert!(unworn.sentence().contains("Wear is not considered: electrode 1"), "{}", unworn.sentence());
        assert_eq!(known(1.0, WearShare::Unlimited).needed_text(1), "at least 1: wear not considered");
    }

    #[test]
    fn the_table_has_every_row_one_after_the_other() {
        let csv = |figures: BurnFigures| {
            let wheel = WheelBurning::of(vec![figures], 3, &job());
            schedule_csv(wheel.schedule.as_ref().unwrap(), &wheel.electrodes)
        };
        let unknown = csv(known(20.0, WearShare::Known(1.0)));
        let rows: Vec<&str> = unknown.lines().collect();
        assert_eq!(rows[1], "1,set-up,0,1,1,0.000,30.000,0,");
        assert_eq!(rows[2], "2,burn,0,1,1,30.000,20.000,0,0.0000", "a copy begins new");
        assert_eq!(rows[3], "3,indexing,1,1,2,50.000,0.500,0,");
        assert_eq!(rows[4], "4,change,1,1,2,50.500,4.000,1,");
        assert_eq!((rows.len(), rows[8]), (9, "8,burn,2,1,3,79.000,20.000,0,0.0000"));
        let later = csv(known(20.0, WearShare::Unknown { at_least: 0.0 }));
        assert!(later.lines().any(|row| row.contains(",burn,1,1,1,") && row.ends_with(",0,")), "{later}");
        // Two channels with each copy: the second is burned with what the first has left of it.
        let worn = csv(BurnFigures { end_wear_mm: Some(0.03), ..known(20.0, WearShare::Known(0.5)) });
        let wear: Vec<&str> =
            worn.lines().filter(|row| row.contains("burn")).filter_map(|row| row.rsplit(',').next()).collect();
        assert_eq!(wear, ["0.0000", "0.0300", "0.0000"]);
    }
}
