//! Joint search for the sets of electrodes of a channel that take the fewest hours: in every stage the number of parts, the planes
//! between them, columns, sides of entry, and the reductions of every part and wall together. Every set that is answered is
//! certified.

use std::collections::BTreeSet;

use serde::Serialize;

use super::burning::WheelBurning;
use super::finish::finish;
use super::outcome::{ElectrodeOutcome, Finishing, PlanInputs, PlanJobError, PlanOutcome};
use super::prepared_blisk::PreparedBlisk;
use super::sizing::{PlannedSize, SizeRow, SizingRange, sizes_of_stage};
use crate::workspaces::blisk::document::job_file::PlanJob;
use burning::duration::Spread;
use burning::schedule::Schedule;
use feed::genetic::ReductionMode;
use feed::plan_params::Strategy;
use files::Validate as _;
use task::Task;
use wheel::electrode::{ElectrodeParams, EnterSide, PartParams, Sizing};

/// Sets of electrodes that are tried, in every stage.
#[derive(Debug, Clone, PartialEq)]
pub struct DesignSpace {
    /// Greatest number of parts along the passage.
    pub most_parts: usize,
    /// Whether parts are divided left and right as well.
    pub columns: bool,
    /// Radial reductions (mm); empty: that of the stage alone.
    pub radial_reductions_mm: Vec<f64>,
    /// Planes between two parts as shares of the passage, beside the one that makes both equally thick.
    pub planes: Vec<f64>,
}

/// Limits of a set.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct DesignLimits {
    /// Greatest residual stock on the walls (mm); none: any.
    pub residual_mm: Option<f64>,
    /// Least thickness of the electrodes (mm).
    pub thickness_mm: f64,
}

/// The electrodes of a stage.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct StageSet {
    /// The size, as [`size`](super::sizing::size) finds it.
    #[serde(flatten)]
    pub size: SizeRow,
    /// Number of columns.
    pub columns: usize,
    /// Radial reduction (mm).
    pub radial_reduction_mm: f64,
    /// Plane between two parts as a share of the passage; none where it is found.
    pub plane: Option<f64>,
}

/// A certified set of electrodes for a channel.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct DesignRow {
    /// The electrodes of every stage in order; one row where the channel is burned in one.
    pub stages: Vec<StageSet>,
    /// The thinnest metal of any electrode between its walls (mm).
    pub least_thickness_mm: f64,
    /// The least certified clearance (mm).
    pub certified_mm: f64,
    /// Number of electrodes of a channel.
    pub electrodes: usize,
    /// Number of electrodes that the wheel needs at least, with their wear as far as it is known; none where it is too large.
    pub needed: Option<usize>,
    /// Whether the wear of every electrode is known, so that no more are needed.
    pub is_wear_known: bool,
    /// Number of each electrode of a channel that the wheel needs, in words.
    pub needed_text: Vec<String>,
    /// Burning of a channel (minutes); none if it is not known.
    pub channel: Option<Spread>,
    /// The whole wheel with set-up, indexing and changes (minutes); none if it is not known.
    pub wheel: Option<Spread>,
    /// Reason why the minutes of the wheel are not known.
    pub no_minutes: Option<String>,
    /// Thickest residual stock on a wall above the tolerance of the map (mm); 0 where there is none, none if it is not known.
    pub residual_mm: Option<f64>,
    /// Whether the stock is that thick at least: how thick it is was not followed further.
    pub is_more_left: bool,
    /// Volume that is left in the channel (mm^3); none if it is not known.
    pub left_mm3: Option<f64>,
    /// Limits that it does not keep, in words.
    pub breaks: Vec<String>,
    /// Whether no other set that keeps the limits is as good in hours, number of electrodes and residual stock, and better in
    /// one of them.
    pub is_best: bool,
    /// The parameters of the electrodes.
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
    /// The best set of the fewest hours; none if no set keeps the limits, or no hours are known.
    pub fn fastest(&self) -> Option<&DesignRow> {
        let minutes = |row: &DesignRow| row.wheel.map_or(f64::INFINITY, |wheel| wheel.mean);
        self.rows.iter().filter(|row| row.is_best).min_by(|a, b| minutes(a).total_cmp(&minutes(b)))
    }

    /// The answer in a sentence.
    pub fn sentence(&self) -> String {
        let keep = || self.rows.iter().filter(|row| row.breaks.is_empty());
        let certified = counted(self.rows.len(), "certified set");
        let Some(fastest) = self.fastest() else {
            return match (keep().count(), keep().find_map(|row| row.no_minutes.as_deref())) {
                (0, _) if self.rows.is_empty() => "No set of electrodes has certified paths.".to_owned(),
                (0, _) => format!("{certified}, none of which keeps the limits."),
                (n, Some(why)) => format!("{certified}, {n} of them within the limits; hours are not known: {why}."),
                (n, None) => format!("{certified}, {n} of them within the limits; they cannot be compared."),
            };
        };
        let wear = if fastest.is_wear_known { "" } else { " at least, because wear is not considered" };
        format!(
            "{certified}, {} of them within the limits; the fastest has {}: {} for the wheel{wear}.",
            keep().count(),
            fastest.words(),
            burning::figures::hours_text(fastest.wheel)
        )
    }
}

/// A number of things.
fn counted(n: usize, what: &str) -> String {
    if n == 1 { format!("1 {what}") } else { format!("{n} {what}s") }
}

impl StageSet {
    fn words(&self) -> String {
        let [low, high] = self.size.reduction_cells();
        let stage = self.size.stage.as_ref().map(|stage| format!("{stage}: ")).unwrap_or_default();
        let kind = Kind {
            parts: self.size.parts,
            columns: self.columns,
            radial_reduction_mm: Some(self.radial_reduction_mm),
            plane: self.plane,
        };
        format!("{stage}{}, from {}, reductions {low} and {high} deg", kind.words(), self.size.enter.name())
    }
}

impl DesignRow {
    /// The set in words.
    pub fn words(&self) -> String {
        self.stages.iter().map(StageSet::words).collect::<Vec<_>>().join("; ")
    }

    /// A cell of a table that tells `of` of every stage, with `+` between the stages.
    pub fn stage_cell(&self, of: impl Fn(&StageSet) -> String) -> String {
        self.stages.iter().map(of).collect::<Vec<_>>().join("+")
    }

    /// Puts the set into `job`, with the search that found it.
    pub fn apply(&self, job: &mut PlanJob) {
        (job.plan.strategy, job.genetic.h) = (Strategy::Global, ReductionMode::Given);
        job.electrode = self.electrode.clone();
    }

    /// `electrode` without everything that [`apply`](Self::apply) sets, of any set.
    pub fn forget(electrode: &mut ElectrodeParams) {
        SizeRow::forget(electrode);
        (electrode.parts, electrode.enter, electrode.circumferential_reduction_deg) = (1, EnterSide::Auto, [0.0; 2]);
        (electrode.columns, electrode.part, electrode.radial_reduction_mm) = (1, Vec::new(), 0.0);
        for stage in &mut electrode.stage {
            (stage.columns, stage.part, stage.radial_reduction_mm) = (None, Vec::new(), None);
        }
    }

    /// Whether applying the row would not change `job`.
    pub fn is_applied(&self, job: &PlanJob) -> bool {
        let mut applied = job.clone();
        self.apply(&mut applied);
        applied == *job
    }

    /// Hours of the wheel, for a table.
    pub fn hours_cell(&self) -> String {
        let hours = self.wheel.map(|wheel| format!("{:.1}", wheel.mean / 60.0));
        at_least(hours, !self.is_wear_known)
    }

    /// Number of electrodes that the wheel needs, for a table.
    pub fn needed_cell(&self) -> String {
        at_least(self.needed.map(|needed| needed.to_string()), !self.is_wear_known)
    }

    /// Residual stock (mm), for a table.
    pub fn residual_cell(&self) -> String {
        at_least(self.residual_mm.map(|stock| format!("{stock:.3}")), self.is_more_left)
    }

    /// Hours, electrodes and residual stock, of which less is better; none where one of them is not known.
    fn costs(&self) -> Option<[f64; 3]> {
        let residual_mm = self.residual_mm.filter(|_| !self.is_more_left)?;
        Some([self.wheel?.mean, self.needed? as f64, residual_mm])
    }
}

/// A figure of a table; a dash where it is not known.
fn at_least(figure: Option<String>, is_more: bool) -> String {
    figure.map_or_else(|| "–".to_owned(), |figure| if is_more { format!("≥ {figure}") } else { figure })
}

/// A kind of set of one stage.
#[derive(Clone)]
struct Kind {
    parts: usize,
    columns: usize,
    /// Radial reduction (mm); none for that of the stage.
    radial_reduction_mm: Option<f64>,
    plane: Option<f64>,
}

impl DesignSpace {
    /// The kinds of sets, those of one part first.
    fn kinds(&self) -> Vec<Kind> {
        let mut kinds = Vec::new();
        let given: Vec<Option<f64>> = self.radial_reductions_mm.iter().copied().map(Some).collect();
        let radial_reductions_mm = if given.is_empty() { &[None] } else { given.as_slice() };
        for parts in 1..=self.most_parts {
            let planes = if parts == 2 { self.planes.as_slice() } else { &[] };
            for columns in 1..=1 + usize::from(self.columns) {
                for &radial_reduction_mm in radial_reductions_mm {
                    let kind = |plane| Kind { parts, columns, radial_reduction_mm, plane };
                    kinds.extend([None].into_iter().chain(planes.iter().copied().map(Some)).map(kind));
                }
            }
        }
        kinds
    }
}

impl Kind {
    /// `job` with stage `stage` of this kind; single parts have no more than the plane of their own.
    fn of(&self, job: &PlanJob, stage: usize) -> PlanJob {
        let until = self.plane.map(|plane| PartParams { until: Some(plane), ..PartParams::default() });
        let part = until.into_iter().collect();
        let mut of_kind = job.clone();
        let electrode = &mut of_kind.electrode;
        electrode.size = Sizing::Given;
        match electrode.stage.get_mut(stage) {
            Some(own) => {
                (own.parts, own.columns, own.part) = (Some(self.parts), Some(self.columns), part);
                own.radial_reduction_mm = self.radial_reduction_mm.or(own.radial_reduction_mm);
                electrode.part.clear();
            }
            None => {
                (electrode.parts, electrode.columns, electrode.part) = (self.parts, self.columns, part);
                electrode.radial_reduction_mm = self.radial_reduction_mm.unwrap_or(electrode.radial_reduction_mm);
            }
        }
        of_kind
    }

    fn words(&self) -> String {
        let plane = self.plane.map(|plane| format!(" divided at {plane}")).unwrap_or_default();
        let radial = self.radial_reduction_mm.map(|mm| format!(", radially {mm} mm")).unwrap_or_default();
        let [parts, columns] = [counted(self.parts, "part"), counted(self.columns, "column")];
        format!("{parts}{plane}, {columns}{radial}")
    }
}

/// Sizes every kind of set in `space` for every stage of the job, works out minutes, wear and residual stock of sets of them, and
/// shows `found` each set. Where there is one stage, every size makes a set. Where there are several, the sets of one kind in all
/// stages are first; from the fastest, the electrodes of one stage at a time are exchanged for every other size of that stage,
/// until that makes no set faster. The parameters of the job beside parts, columns, reductions and sides hold for all; single
/// parts have nothing of their own.
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
    let kinds = space.kinds();
    let stages = inputs.job.electrode.stages();
    for kind in &kinds {
        (0..stages).try_for_each(|stage| kind.of(&inputs.job, stage).validate())?;
    }
    let mut search =
        Search { prepared, inputs, limits, found, task, tried: BTreeSet::new(), design: Design::default() };
    let of_stages = (0..stages).map(|stage| search.candidates(&kinds, stage)).collect::<Result<Vec<_>, _>>()?;
    if of_stages.iter().all(|candidates| !candidates.is_empty()) {
        search.sets(&of_stages, kinds.len())?;
    }
    let mut design = search.design;
    mark_best(&mut design.rows);
    Ok(design)
}

/// The electrodes that one stage may have.
struct Candidate {
    /// Number of the kind.
    of_kind: usize,
    kind: Kind,
    sized: PlannedSize,
}

/// Number of the candidate of each stage.
type Choice = Vec<usize>;

struct Search<'a> {
    prepared: &'a PreparedBlisk,
    inputs: &'a PlanInputs,
    limits: &'a DesignLimits,
    found: &'a (dyn Fn(&DesignRow) + Sync),
    task: &'a Task,
    tried: BTreeSet<Choice>,
    design: Design,
}

impl Search<'_> {
    /// All sizes of all kinds for a stage.
    fn candidates(&mut self, kinds: &[Kind], stage: usize) -> Result<Vec<Candidate>, PlanJobError> {
        let name = self.inputs.job.electrode.stage.get(stage).map(|stage| format!("{}: ", stage.name));
        let mut candidates = Vec::new();
        for (of_kind, kind) in kinds.iter().enumerate() {
            let words = name.clone().unwrap_or_default() + &kind.words();
            let inputs = PlanInputs { job: kind.of(&self.inputs.job, stage), ..self.inputs.clone() };
            let range = SizingRange { from: kind.parts, to: kind.parts };
            let sizing = self.task.as_stage_about("sizing", &words);
            let why = match sizes_of_stage(self.prepared, &inputs, (stage, range), &|_| (), &sizing) {
                Err(PlanJobError::Electrode(why)) => why.to_string(),
                Ok(sizes) if sizes.is_empty() => {
                    "no electrode has an extraction path at the reductions tried".to_owned()
                }
                sizes => {
                    let candidate = |sized| Candidate { of_kind, kind: kind.clone(), sized };
                    candidates.extend(sizes?.into_iter().map(candidate));
                    continue;
                }
            };
            self.design.left_out.push(format!("{words}: {why}"));
        }
        Ok(candidates)
    }

    /// Tries the sets of one kind in all stages, and exchanges the electrodes of one stage after the other while that makes them
    /// faster.
    fn sets(&mut self, of_stages: &[Vec<Candidate>], kinds: usize) -> Result<(), PlanJobError> {
        let thickest = |candidates: &[Candidate], kind: Option<usize>| {
            let of_kind = candidates.iter().enumerate().filter(|(_, c)| kind.is_none_or(|kind| c.of_kind == kind));
            let thickness = |c: &Candidate| c.sized.row.least_thickness_mm;
            of_kind.max_by(|(_, a), (_, b)| thickness(a).total_cmp(&thickness(b))).map(|(i, _)| i)
        };
        let mut best: Option<(Choice, [f64; 2])> = None;
        for kind in (0..kinds).map(Some).chain([None]) {
            let same: Option<Choice> = of_stages.iter().map(|candidates| thickest(candidates, kind)).collect();
            if let Some(choice) = same {
                self.keep_faster(of_stages, choice, &mut best)?;
            }
        }
        while let Some((from, _)) = best.clone() {
            for (stage, candidates) in of_stages.iter().enumerate().rev() {
                for other in 0..candidates.len() {
                    let mut choice = best.as_ref().map_or_else(|| from.clone(), |(choice, _)| choice.clone());
                    choice[stage] = other;
                    self.keep_faster(of_stages, choice, &mut best)?;
                }
            }
            if best.as_ref().is_some_and(|(choice, _)| *choice == from) {
                break;
            }
        }
        Ok(())
    }

    /// Tries a set that was not tried before; it is the best from now on if it breaks fewer limits, or as many and takes fewer
    /// hours. A set that cannot be burned is no worse to go on from than none.
    fn keep_faster(
        &mut self,
        of_stages: &[Vec<Candidate>],
        choice: Choice,
        best: &mut Option<(Choice, [f64; 2])>,
    ) -> Result<(), PlanJobError> {
        if !self.tried.insert(choice.clone()) {
            return Ok(());
        }
        let of_set: Vec<&Candidate> = of_stages.iter().zip(&choice).map(|(candidates, i)| &candidates[*i]).collect();
        let words: Vec<String> = of_set.iter().map(|candidate| candidate.words()).collect();
        let burning = self.task.as_stage_about("burning", &words.join("; "));
        let cost = match self.evaluated(&of_set, &burning)? {
            Ok(row) => {
                (self.found)(&row);
                let minutes = row.wheel.map_or(f64::INFINITY, |wheel| wheel.mean);
                let breaks = row.breaks.len() as f64;
                self.design.rows.push(row);
                [breaks, minutes]
            }
            Err(why) => {
                self.design.left_out.push(format!("{}: {why}", words.join("; ")));
                [f64::INFINITY; 2]
            }
        };
        if best.as_ref().is_none_or(|(_, least)| cost < *least) {
            *best = Some((choice, cost));
        }
        Ok(())
    }

    /// The set of one candidate for each stage, finished; or why it cannot be burned.
    fn evaluated(&self, of_set: &[&Candidate], task: &Task) -> Result<Result<DesignRow, String>, PlanJobError> {
        let mut inputs = self.inputs.clone();
        let electrodes: Vec<ElectrodeOutcome> =
            of_set.iter().flat_map(|candidate| candidate.sized.electrodes.iter().cloned()).collect();
        for (stage, Candidate { kind, sized, .. }) in of_set.iter().enumerate() {
            inputs.job = kind.of(&inputs.job, stage);
            sized.row.apply(&mut inputs.job);
        }
        inputs.job.validate()?;
        let outcome = PlanOutcome::new(self.prepared.space.channel.clone(), electrodes, Vec::new());
        finish(&outcome, &inputs, &self.prepared.space.blisk, task)?;
        if let Some(collision) = outcome.finishing().and_then(Finishing::collision) {
            return Ok(Err(collision.sentence()));
        }
        let stage_set = |(stage, Candidate { kind, sized, .. }): (usize, &&Candidate)| StageSet {
            size: sized.row.clone(),
            columns: kind.columns,
            radial_reduction_mm: inputs.job.electrode.of_stage(stage).radial_reduction_mm,
            plane: kind.plane,
        };
        let stages = of_set.iter().enumerate().map(stage_set).collect();
        Ok(Ok(row_of(&outcome, &inputs, stages, self.limits)))
    }
}

impl Candidate {
    fn words(&self) -> String {
        let [low, high] = self.sized.row.reduction_cells();
        let stage = self.sized.row.stage.as_ref().map(|stage| format!("{stage}: ")).unwrap_or_default();
        format!("{stage}{}, {low} and {high} deg", self.kind.words())
    }
}

fn row_of(outcome: &PlanOutcome, inputs: &PlanInputs, stages: Vec<StageSet>, limits: &DesignLimits) -> DesignRow {
    let burning = WheelBurning::of_job(outcome, &inputs.job);
    let burning = burning.as_ref();
    let stock = outcome.residual_stock();
    let thickest = stock.map(|stock| stock.thickest().map(|(_, layer)| layer));
    let residual_mm = thickest.map(|layer| layer.map_or(0.0, |layer| layer.depth_mm));
    let is_more_left = thickest.flatten().is_some_and(|layer| layer.or_more);
    let least = |of: fn(&SizeRow) -> f64| stages.iter().map(|stage| of(&stage.size)).fold(f64::INFINITY, f64::min);
    let [least_thickness_mm, certified_mm] = [least(|size| size.least_thickness_mm), least(|size| size.certified_mm)];
    let needed = burning.and_then(|of| of.electrodes.iter().map(|electrode| electrode.copies).sum());
    let mut breaks = Vec::new();
    match (limits.residual_mm, residual_mm) {
        (Some(most), Some(left)) if left > most || is_more_left => {
            let more = if is_more_left { " or more" } else { "" };
            breaks.push(format!("residual stock {left:.3} mm{more} for {most} mm"));
        }
        (Some(most), None) => breaks.push(format!("residual stock not known for {most} mm")),
        _ => {}
    }
    if least_thickness_mm < limits.thickness_mm {
        breaks.push(format!("thickness {least_thickness_mm:.3} mm for {} mm", limits.thickness_mm));
    }
    if burning.is_some() && needed.is_none() {
        breaks.push("the wear asks for too many electrodes".to_owned());
    }
    if !outcome.bears_setting() {
        breaks.push("the setting errors do not hold".to_owned());
    }
    DesignRow {
        stages,
        least_thickness_mm,
        certified_mm,
        electrodes: outcome.electrodes.len(),
        needed,
        is_wear_known: burning.is_some_and(|of| of.electrodes.iter().all(|e| e.figures.is_wear_known())),
        needed_text: burning.map_or_else(Vec::new, |of| of.electrodes.iter().map(|e| e.needed_text()).collect()),
        channel: burning.and_then(|of| of.channel),
        wheel: burning.and_then(|of| of.schedule.as_ref()).map(Schedule::total),
        no_minutes: burning.and_then(|of| Some(why_unknown(of, of.no_schedule.as_ref()?))),
        residual_mm,
        is_more_left,
        left_mm3: stock.map(|stock| stock.stock.left_mm3),
        breaks,
        is_best: false,
        electrode: inputs.job.electrode.clone(),
    }
}

/// Reason why there is no schedule, with what is missing for the minutes.
fn why_unknown(burning: &WheelBurning, no_schedule: &str) -> String {
    let missing = burning.electrodes.iter().find(|of| !of.figures.missing.is_empty());
    missing.map_or_else(|| no_schedule.to_owned(), |of| format!("{no_schedule}: {}", of.figures.missing.join("; ")))
}

/// Marks the sets that keep the limits and that no other such set is better than: no worse in hours, electrodes and residual
/// stock, and better in one of them. A set of which one of these is not known is not compared. Where the wear is not known hours
/// and electrodes are the least that there may be, which is no better than what is known.
pub fn mark_best(rows: &mut [DesignRow]) {
    let compared = |row: &DesignRow| Some((row.costs().filter(|_| row.breaks.is_empty())?, row.is_wear_known));
    let all: Vec<Option<([f64; 3], bool)>> = rows.iter().map(compared).collect();
    let is_better = |(a, a_known): &([f64; 3], bool), (b, b_known): &([f64; 3], bool)| {
        a != b && a.iter().zip(b).all(|(a, b)| a <= b) && (*a_known || !b_known)
    };
    for (row, own) in rows.iter_mut().zip(&all) {
        row.is_best = own.is_some_and(|own| !all.iter().flatten().any(|other| is_better(other, &own)));
    }
}

#[cfg(test)]
mod tests;
