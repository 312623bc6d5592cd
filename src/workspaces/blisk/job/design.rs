//! Joint search for the sets of electrodes of a channel that take the fewest hours: numbers of parts, the planes between them,
//! columns, sides of entry, and reductions together. Every set that is answered is certified.

use serde::Serialize;

use super::burning::{BurningElectrode, WheelBurning};
use super::finish::finish;
use super::outcome::{PlanInputs, PlanJobError, PlanOutcome};
use super::plan::run_feeds;
use super::prepared_blisk::PreparedBlisk;
use super::sizing::{SizeRow, SizingRange, size};
use burning::duration::Spread;
use burning::schedule::Schedule;
use feed::plan_params::Strategy;
use task::Task;
use wheel::electrode::{ElectrodeParams, PartParams};

/// Sets of electrodes that are tried.
#[derive(Debug, Clone, PartialEq)]
pub struct DesignSpace {
    /// Greatest number of parts along the passage.
    pub most_parts: usize,
    /// Whether parts are divided left and right as well.
    pub columns: bool,
    /// Radial reductions (mm).
    pub radial_reductions_mm: Vec<f64>,
    /// Planes between two parts as shares of the passage, beside the one that makes both equally thick.
    pub planes: Vec<f64>,
}

/// What a set has to keep.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct DesignLimits {
    /// Greatest residual stock on the walls (mm); none: any.
    pub residual_mm: Option<f64>,
    /// Least thickness of the electrodes (mm).
    pub thickness_mm: f64,
}

/// A certified set of electrodes for a channel.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct DesignRow {
    /// The size, as [`size`] finds it.
    pub size: SizeRow,
    /// Number of columns.
    pub columns: usize,
    /// Radial reduction (mm).
    pub radial_reduction_mm: f64,
    /// Plane between two parts as a share of the passage; none where it is found.
    pub plane: Option<f64>,
    /// Number of electrodes of a channel.
    pub electrodes: usize,
    /// Number of electrodes that the wheel needs at least, with their wear as far as it is known; none where it is too large.
    pub needed: Option<usize>,
    /// Whether the wear of every electrode is known, so that no more are needed.
    pub is_wear_known: bool,
    /// That number in words, for each electrode of a channel.
    pub needed_text: Vec<String>,
    /// Burning of a channel (minutes); none if it is not known.
    pub channel: Option<Spread>,
    /// The whole wheel with set-up, indexing and changes (minutes); none if it is not known.
    pub wheel: Option<Spread>,
    /// Reason why the minutes of the wheel are not known.
    pub no_minutes: Option<String>,
    /// Thickest residual stock on a wall above the tolerance of the map (mm); 0 where there is none, none if it is not known.
    pub residual_mm: Option<f64>,
    /// Volume that is left in the channel (mm^3); none if it is not known.
    pub left_mm3: Option<f64>,
    /// Limits that it does not keep, in words.
    pub breaks: Vec<String>,
    /// Whether no other set that keeps the limits is as good in hours, number of electrodes and residual stock, and better in
    /// one of them.
    pub is_best: bool,
    /// The parameters of the set.
    #[serde(skip)]
    pub electrode: ElectrodeParams,
}

/// Sets of electrodes, and what was left out.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Design {
    /// The sets in the order in which they were found.
    pub rows: Vec<DesignRow>,
    /// Kinds of sets without an electrode that comes out, and why.
    pub left_out: Vec<String>,
}

impl Design {
    /// The set of the fewest hours that keeps the limits; with minutes that are not known the first of the best.
    pub fn fastest(&self) -> Option<&DesignRow> {
        let minutes = |row: &DesignRow| row.wheel.map_or(f64::INFINITY, |wheel| wheel.mean);
        self.rows.iter().filter(|row| row.is_best).min_by(|a, b| minutes(a).total_cmp(&minutes(b)))
    }

    /// The answer in a sentence.
    pub fn sentence(&self) -> String {
        let keep = self.rows.iter().filter(|row| row.breaks.is_empty()).count();
        let Some(fastest) = self.fastest() else {
            return match self.rows.len() {
                0 => "No set of electrodes has certified paths.".to_owned(),
                n => format!("None of the {n} certified sets keeps the limits."),
            };
        };
        let hours = burning::figures::hours_text(fastest.wheel);
        format!(
            "{} certified sets, {keep} of them within the limits; the fastest has {}: {hours} for the wheel.",
            self.rows.len(),
            fastest.words()
        )
    }
}

impl DesignRow {
    /// The set in words.
    pub fn words(&self) -> String {
        let [low, high] = self.size.reduction_deg;
        let counted = |n: usize, what: &str| if n == 1 { format!("1 {what}") } else { format!("{n} {what}s") };
        let plane = self.plane.map(|plane| format!(" divided at {plane}")).unwrap_or_default();
        format!(
            "{}{plane}, {}, from {}, reductions {low:.3} and {high:.3} deg, radially {} mm",
            counted(self.size.parts, "part"),
            counted(self.columns, "column"),
            self.size.enter.name(),
            self.radial_reduction_mm
        )
    }

    /// Puts the set into the parameters of an electrode.
    pub fn apply(&self, electrode: &mut ElectrodeParams) {
        *electrode = self.electrode.clone();
    }

    /// Whether applying the row would not change `electrode`.
    pub fn is_applied(&self, electrode: &ElectrodeParams) -> bool {
        self.electrode == *electrode
    }

    /// Number of electrodes that the wheel needs, for a table.
    pub fn needed_cell(&self) -> String {
        match self.needed {
            None => "–".to_owned(),
            Some(needed) if self.is_wear_known => needed.to_string(),
            Some(needed) => format!("≥ {needed}"),
        }
    }

    /// Hours, electrodes and residual stock, of which less is better; none where the hours are not known.
    fn costs(&self) -> Option<[f64; 3]> {
        Some([self.wheel?.mean, self.needed? as f64, self.residual_mm?])
    }
}

/// A kind of set.
struct Kind {
    parts: usize,
    columns: usize,
    radial_reduction_mm: f64,
    plane: Option<f64>,
}

impl DesignSpace {
    /// The kinds of sets, those of one part first.
    fn kinds(&self) -> Vec<Kind> {
        let mut kinds = Vec::new();
        for parts in 1..=self.most_parts {
            let planes = if parts == 2 { self.planes.as_slice() } else { &[] };
            for columns in 1..=1 + usize::from(self.columns) {
                for &radial_reduction_mm in &self.radial_reductions_mm {
                    let kind = |plane| Kind { parts, columns, radial_reduction_mm, plane };
                    kinds.extend([None].into_iter().chain(planes.iter().copied().map(Some)).map(kind));
                }
            }
        }
        kinds
    }
}

impl Kind {
    /// The parameters `of` a job for this kind.
    fn applied(&self, of: &ElectrodeParams) -> ElectrodeParams {
        let until = self.plane.map(|plane| PartParams { until: Some(plane), ..PartParams::default() });
        ElectrodeParams {
            parts: self.parts,
            columns: self.columns,
            radial_reduction_mm: self.radial_reduction_mm,
            part: until.into_iter().collect(),
            ..of.clone()
        }
    }

    fn words(&self) -> String {
        let plane = self.plane.map(|plane| format!(" divided at {plane}")).unwrap_or_default();
        format!("{} parts{plane}, {} columns, radially {} mm", self.parts, self.columns, self.radial_reduction_mm)
    }
}

/// Sizes every kind of set in `space`, plans each size that is found, works out its minutes, wear and residual stock, and shows
/// `found` each set. The parameters of the job beside parts, columns, reductions and sides hold for all; single parts have
/// nothing of their own.
///
/// # Errors
/// Every error of a plan but those of electrodes that cannot be made, whose kinds are left out.
pub fn design(
    prepared: &PreparedBlisk,
    inputs: &PlanInputs,
    space: &DesignSpace,
    limits: &DesignLimits,
    found: &(dyn Fn(&DesignRow) + Sync),
    task: &Task,
) -> Result<Design, PlanJobError> {
    let mut design = Design::default();
    let kinds = space.kinds();
    for (k, kind) in kinds.iter().enumerate() {
        task.report("sets of electrodes", k as f64 / kinds.len() as f64, &kind.words());
        let mut of_kind = inputs.clone();
        of_kind.job.electrode = kind.applied(&inputs.job.electrode);
        let range = SizingRange { from: kind.parts, to: kind.parts };
        let sizes = match size(prepared, &of_kind, range, &|_| (), &Task::silent(&task.cancel)) {
            Err(PlanJobError::Electrode(why)) => {
                design.left_out.push(format!("{}: {why}", kind.words()));
                continue;
            }
            sizes => sizes?,
        };
        if sizes.is_empty() {
            design
                .left_out
                .push(format!("{}: no electrode has an extraction path at the reductions tried", kind.words()));
        }
        for size in sizes {
            let row = evaluated(prepared, &of_kind, kind, size, limits, task)?;
            if let Some(row) = row {
                found(&row);
                design.rows.push(row);
            }
        }
    }
    mark_best(&mut design.rows);
    Ok(design)
}

/// The set of `size`, planned and finished.
fn evaluated(
    prepared: &PreparedBlisk,
    inputs: &PlanInputs,
    kind: &Kind,
    size: SizeRow,
    limits: &DesignLimits,
    task: &Task,
) -> Result<Option<DesignRow>, PlanJobError> {
    let mut inputs = inputs.clone();
    inputs.job.plan.strategy = Strategy::Global;
    size.apply(&mut inputs.job.electrode);
    let task = Task::silent(&task.cancel);
    let outcome = run_feeds(prepared, &inputs, &task)?;
    if !outcome.is_verified() {
        return Ok(None);
    }
    finish(&outcome, &inputs, &prepared.space.blisk, &task)?;
    Ok(outcome.may_be_approved().then(|| row_of(&outcome, &inputs, kind, size, limits)))
}

fn row_of(outcome: &PlanOutcome, inputs: &PlanInputs, kind: &Kind, size: SizeRow, limits: &DesignLimits) -> DesignRow {
    let burning = WheelBurning::of_job(outcome, &inputs.job);
    let burning = burning.as_ref();
    let stock = outcome.residual_stock();
    let residual_mm = stock.map(|stock| stock.thickest().map_or(0.0, |(_, layer)| layer.depth_mm));
    let needed = burning.and_then(|of| of.electrodes.iter().map(|electrode| electrode.copies).sum());
    let mut breaks = Vec::new();
    match (limits.residual_mm, residual_mm) {
        (Some(most), Some(left)) if left > most => breaks.push(format!("residual stock {left:.3} mm for {most} mm")),
        (Some(most), None) => breaks.push(format!("residual stock not known for {most} mm")),
        _ => {}
    }
    if size.least_thickness_mm < limits.thickness_mm {
        breaks.push(format!("thickness {:.3} mm for {} mm", size.least_thickness_mm, limits.thickness_mm));
    }
    if burning.is_some() && needed.is_none() {
        breaks.push("the wear asks for too many electrodes".to_owned());
    }
    DesignRow {
        columns: kind.columns,
        radial_reduction_mm: kind.radial_reduction_mm,
        plane: kind.plane,
        electrodes: outcome.electrodes.len(),
        needed,
        is_wear_known: burning.is_some_and(|of| of.electrodes.iter().all(BurningElectrode::is_wear_known)),
        needed_text: burning.map_or_else(Vec::new, |of| of.electrodes.iter().map(|e| e.needed_text()).collect()),
        channel: burning.and_then(|of| of.channel),
        wheel: burning.and_then(|of| of.schedule.as_ref()).map(Schedule::total),
        no_minutes: burning.and_then(|of| of.no_schedule.clone()),
        residual_mm,
        left_mm3: stock.map(|stock| stock.stock.left_mm3),
        breaks,
        is_best: false,
        electrode: inputs.job.electrode.clone(),
        size,
    }
}

/// Marks the sets that keep the limits and that no other such set is better than. A set whose hours are not known is not
/// compared.
fn mark_best(rows: &mut [DesignRow]) {
    let costs: Vec<Option<[f64; 3]>> = rows.iter().map(|row| row.costs().filter(|_| row.breaks.is_empty())).collect();
    let is_better = |a: &[f64; 3], b: &[f64; 3]| a != b && a.iter().zip(b).all(|(a, b)| a <= b);
    for (row, own) in rows.iter_mut().zip(&costs) {
        row.is_best = own.is_some_and(|own| !costs.iter().flatten().any(|other| is_better(other, &own)));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use wheel::electrode::EnterSide;

    fn row(minutes: Option<f64>, needed: usize, residual_mm: f64, breaks: &[&str]) -> DesignRow {
        let size = SizeRow {
            parts: needed,
            enter: EnterSide::MinusX,
            reduction_deg: [1.0, 1.5],
            least_thickness_mm: 2.0,
            volume_mm3: 100.0,
            certified_mm: 0.099,
            limit: None,
            raised_deg: 0.0,
        };
        DesignRow {
            size,
            columns: 1,
            radial_reduction_mm: 0.5,
            plane: None,
            electrodes: needed,
            needed: Some(needed),
            is_wear_known: true,
            needed_text: Vec::new(),
            channel: None,
            wheel: minutes.map(Spread::exactly),
            no_minutes: None,
            residual_mm: Some(residual_mm),
            left_mm3: None,
            breaks: breaks.iter().map(|&word| word.to_owned()).collect(),
            is_best: false,
            electrode: ElectrodeParams::default(),
        }
    }

    #[test]
    fn the_best_are_those_that_no_other_is_better_than() {
        let mut rows = vec![
            row(Some(600.0), 1, 0.5, &[]),
            row(Some(500.0), 2, 0.5, &[]),
            row(Some(650.0), 1, 0.5, &[]),
            row(Some(700.0), 3, 0.1, &[]),
            row(Some(100.0), 1, 0.9, &["residual stock"]),
            row(None, 1, 0.0, &[]),
            row(Some(600.0), 1, 0.5, &[]),
        ];
        mark_best(&mut rows);
        let best: Vec<bool> = rows.iter().map(|row| row.is_best).collect();
        assert_eq!(best, [true, true, false, true, false, false, true]);
        let design = Design { rows, left_out: Vec::new() };
        assert_eq!(design.fastest().unwrap().wheel, Some(Spread::exactly(500.0)));
        assert!(design.sentence().contains("7 certified sets, 6 of them within the limits"), "{}", design.sentence());
        let none = Design { rows: vec![row(Some(1.0), 1, 0.9, &["thickness"])], left_out: Vec::new() };
        assert!(none.fastest().is_none() && none.sentence().contains("None of the 1 certified sets keeps"));
        assert!(Design::default().sentence().contains("No set"));
    }

    #[test]
    fn every_kind_of_set_is_tried_once() {
        let space =
            DesignSpace { most_parts: 3, columns: true, radial_reductions_mm: vec![0.5, 0.2], planes: vec![0.4, 0.6] };
        let kinds = space.kinds();
        assert_eq!(kinds.len(), 2 * 2 * (1 + 3 + 1));
        let mut words: Vec<String> = kinds.iter().map(Kind::words).collect();
        words.sort();
        words.dedup();
        assert_eq!(words.len(), kinds.len());
        let applied = kinds.iter().find(|kind| kind.plane == Some(0.4)).unwrap().applied(&ElectrodeParams::default());
        assert_eq!((applied.parts, applied.part[0].until), (2, Some(0.4)));
    }
}
