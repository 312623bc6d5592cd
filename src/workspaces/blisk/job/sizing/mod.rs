//! Automatic sizing: the thickest electrodes that come out, for one part and more, on either side, in every stage.

use std::sync::Arc;

use serde::Serialize;

use super::outcome::{ElectrodeOutcome, PlanInputs, PlanJobError, PlanOutcome};
use super::plan::{run_feeds, settings_of, sides};
use super::prepared_blisk::{PreparedBlisk, is_mended_by_less};
use crate::workspaces::blisk::document::job_file::PlanJob;
use feed::genetic::ReductionMode;
use feed::plan_params::PlanError;
use feed::plan_params::Strategy;
use feed::prepared::PreparedElectrode;
use feed::probes::Turns;
use feed::sizing::{Least, Sizer};
use files::Validate as _;
use task::Task;
use wheel::channel::Surface;
use wheel::electrode::{
    Column, ElectrodeError, ElectrodeParams, EnterSide, EntrySide, PartParams, Sizing as SizeMode, own_turns,
};

/// What is sized.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SizingRange {
    /// Least number of parts.
    pub from: usize,
    /// Greatest number of parts.
    pub to: usize,
}

/// A certified way to make the electrodes of a stage.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SizeRow {
    /// Name of the stage; none where the channel is burned in one.
    pub stage: Option<String>,
    /// Number of parts.
    pub parts: usize,
    /// The side they enter from.
    pub enter: EnterSide,
    /// Circumferential reductions of the low and the high wall (deg): a row that holds for all parts, or one for each part along
    /// the passage.
    pub reduction_deg: Vec<[f64; 2]>,
    /// Own values of single parts beside their reductions.
    #[serde(skip)]
    pub part: Vec<PartParams>,
    /// The thinnest metal of any of the parts between its walls (mm).
    pub least_thickness_mm: f64,
    /// Volume of all parts with shank and holder (mm^3).
    pub volume_mm3: f64,
    /// Certified clearance of the least of them (mm).
    pub certified_mm: f64,
    /// What keeps them from being thicker.
    pub limit: Option<SizeLimit>,
    /// What the certificate asked for beyond the reductions that the search needs (deg).
    pub raised_deg: f64,
}

impl SizeRow {
    /// Puts parts, side and reductions of the row into its stage of `job`, with the search that found them.
    pub fn apply(&self, job: &mut PlanJob) {
        (job.plan.strategy, job.genetic.h) = (Strategy::Global, ReductionMode::Given);
        let electrode = &mut job.electrode;
        electrode.size = SizeMode::Given;
        let mut sized = ElectrodeParams { part: self.part.clone(), ..ElectrodeParams::default() };
        reduce(&mut sized, &self.reduction_deg);
        let walls = sized.circumferential_reduction_deg;
        let Some(own) = electrode.stage.iter_mut().find(|stage| Some(&stage.name) == self.stage.as_ref()) else {
            (electrode.parts, electrode.part, electrode.enter) = (self.parts, sized.part, self.enter);
            electrode.circumferential_reduction_deg = walls;
            return;
        };
        (own.parts, own.enter) = (Some(self.parts), Some(self.enter));
        [own.low_reduction_deg, own.high_reduction_deg] = walls.map(Some);
        own.part = sized.part;
        // Without a row of its own the stage would have those of all.
        if own.part.is_empty() && !electrode.part.is_empty() {
            own.part.push(PartParams::default());
        }
    }

    /// `electrode` without everything that [`apply`](Self::apply) sets, of any row.
    pub fn forget(electrode: &mut ElectrodeParams) {
        electrode.size = SizeMode::Given;
        if electrode.stage.is_empty() {
            (electrode.parts, electrode.enter) = (1, EnterSide::Auto);
            electrode.circumferential_reduction_deg = [0.0; 2];
            without_reductions(&mut electrode.part);
        }
        for stage in &mut electrode.stage {
            (stage.parts, stage.enter) = (None, None);
            (stage.low_reduction_deg, stage.high_reduction_deg) = (None, None);
            without_reductions(&mut stage.part);
        }
    }

    /// The reductions of the low and the high wall, those of the parts with strokes between where they differ.
    pub fn reduction_cells(&self) -> [String; 2] {
        [0, 1].map(|wall| {
            let of_parts: Vec<String> = self.reduction_deg.iter().map(|walls| format!("{:.3}", walls[wall])).collect();
            of_parts.join("/")
        })
    }

    /// The greatest reduction (deg).
    pub fn most_deg(&self) -> f64 {
        self.reduction_deg.iter().flatten().copied().fold(0.0, f64::max)
    }

    /// Whether applying the row would not change `job`.
    pub fn is_applied(&self, job: &PlanJob) -> bool {
        let mut applied = job.clone();
        self.apply(&mut applied);
        applied == *job
    }
}

/// The electrode of a row that needs its reductions, and the narrowest place of its way out.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SizeLimit {
    /// The electrode, counted from 1.
    pub electrode: usize,
    /// Electrodes of the row.
    pub electrodes: usize,
    /// The side that it enters from.
    pub enters_from: EntrySide,
    /// The node at that place, counted from the final pose.
    pub node: usize,
    /// Withdrawn distance there (mm).
    pub s_mm: f64,
    /// Surface that is nearest there.
    pub surface: String,
}

impl SizeLimit {
    /// The limit in one clause.
    pub fn clause(&self) -> String {
        let Self { electrode, electrodes, enters_from, node, s_mm, surface } = self;
        let who = match electrodes {
            1 => "limited".to_owned(),
            n => {
                format!("limited by electrode {electrode} of {n}, which enters from {},", enters_from.words())
            }
        };
        format!("{who} at node {node}, retract distance {s_mm:.1} mm, by the {surface}")
    }
}

/// Reductions are found to this angle (deg).
pub const TOLERANCE_DEG: f64 = 0.015;
/// Greatest reduction that is tried (deg).
const MOST_DEG: f64 = 10.0;
/// Where the search begins (deg).
const FIRST_DEG: f64 = 1.0;
/// Times that a little more reduction is taken where the certificate does not hold.
const RAISES: usize = 8;
/// Steps below a certified row at which whole plans are tried, one after the other, in [`TOLERANCE_DEG`].
const LOWER: [f64; 3] = [2.0, 1.0, 4.0];
/// Most plans that are tried so for a row.
const MOST_LOWERED: usize = 10;

/// Sizes the electrodes of every stage of the job for every number of parts in `range`, and shows `found` each row as it is
/// certified. For one part both reductions are equal first, on each side of entry that the job allows, and then as unequal as
/// brings most on the better side; for more parts, or columns, they are equal first, the greatest that any of them needs, and
/// then for each wall of each part as little as it needs.
///
/// # Errors
/// Every error of a plan. No reduction that opens a way is not an error, but a row less.
pub fn size(
    prepared: &PreparedBlisk,
    inputs: &PlanInputs,
    range: SizingRange,
    found: &(dyn Fn(&SizeRow) + Sync),
    task: &Task,
) -> Result<Vec<SizeRow>, PlanJobError> {
    let mut rows = Vec::new();
    for stage in 0..inputs.job.electrode.stages() {
        rows.extend(sizes_of_stage(prepared, inputs, (stage, range), found, task)?.into_iter().map(|sized| sized.row));
    }
    Ok(rows)
}

/// A row with the electrodes that were planned for it.
pub(super) struct PlannedSize {
    pub row: SizeRow,
    pub electrodes: Vec<ElectrodeOutcome>,
}

/// The rows of one stage of the job; see [`size`].
///
/// # Errors
/// Every error of [`size`].
pub(super) fn sizes_of_stage(
    prepared: &PreparedBlisk,
    inputs: &PlanInputs,
    (stage, range): (usize, SizingRange),
    found: &(dyn Fn(&SizeRow) + Sync),
    task: &Task,
) -> Result<Vec<PlannedSize>, PlanJobError> {
    if !inputs.own_electrodes.is_empty() {
        return Err(PlanJobError::Job(
            "an electrode mesh of your own has the size it has; remove it to size".to_owned(),
        ));
    }
    let mut base = PlanInputs { job: inputs.job.of_stage(stage), ..inputs.clone() };
    base.job.plan.strategy = Strategy::Global;
    base.job.genetic.h = ReductionMode::Given;
    base.job.electrode.size = SizeMode::Given;
    reduce(&mut base.job.electrode, &[[0.0; 2]]);
    base.job.validate()?;
    let name = inputs.job.electrode.stage.get(stage).map(|stage| stage.name.clone());
    let sizing = Sizing { prepared, base, stage: name, found, task };
    let mut rows = Vec::new();
    for parts in range.from..=range.to {
        let single = parts == 1 && sizing.base.job.electrode.columns == 1;
        if single { sizing.one_part(&mut rows)? } else { sizing.many(parts, &mut rows)? }
    }
    Ok(rows)
}

/// `[electrode] size = "auto"`: `inputs` with the reductions, and the sides of entry, of the thickest electrodes that
/// come out in as many parts as every stage asks for, to be planned with the strategy that found them; and the row of each stage.
/// A stage keeps the reductions that it gives, and has no row, if none lets its electrodes out: planning these tells where they
/// jam.
///
/// # Errors
/// Every error of [`size`].
pub fn auto_sized(
    prepared: &PreparedBlisk,
    inputs: &PlanInputs,
    task: &Task,
) -> Result<(PlanInputs, Vec<Option<SizeRow>>), PlanJobError> {
    let mut sized = inputs.clone();
    sized.job.electrode.size = SizeMode::Given;
    let mut rows = Vec::new();
    for stage in 0..inputs.job.electrode.stages() {
        let parts = inputs.job.electrode.of_stage(stage).parts;
        let range = SizingRange { from: parts, to: parts };
        let found = sizes_of_stage(prepared, inputs, (stage, range), &|_| (), task)?.into_iter();
        let thickest = found.max_by(|a, b| a.row.least_thickness_mm.total_cmp(&b.row.least_thickness_mm));
        let row = thickest.map(|sized| sized.row);
        row.iter().for_each(|row| row.apply(&mut sized.job));
        rows.push(row);
    }
    Ok((sized, rows))
}

/// Divides the channel between so many parts; with another number than before, single parts have nothing of their own.
fn with_parts(electrode: &mut ElectrodeParams, parts: usize) {
    if electrode.parts != parts {
        (electrode.parts, electrode.part) = (parts, Vec::new());
    }
}

/// Takes the reductions of the walls out of rows of single parts, and rows at the end that have nothing more.
fn without_reductions(part: &mut Vec<PartParams>) {
    for row in part.iter_mut() {
        (row.low_reduction_deg, row.high_reduction_deg) = (None, None);
    }
    part.truncate(part.iter().rposition(|row| *row != PartParams::default()).map_or(0, |last| last + 1));
}

/// Gives the walls of `electrode`, which has no stages, the reductions of a row (deg).
fn reduce(electrode: &mut ElectrodeParams, reduction_deg: &[[f64; 2]]) {
    let most = |wall: usize| reduction_deg.iter().map(|walls| walls[wall]).fold(0.0, f64::max);
    electrode.circumferential_reduction_deg = [most(0), most(1)];
    without_reductions(&mut electrode.part);
    if let [_, _, ..] = reduction_deg {
        electrode.part.resize(reduction_deg.len(), PartParams::default());
        for (row, [low, high]) in electrode.part.iter_mut().zip(reduction_deg) {
            (row.low_reduction_deg, row.high_reduction_deg) = (Some(*low), Some(*high));
        }
    }
}

struct Sizing<'a> {
    prepared: &'a PreparedBlisk,
    /// The job of the stage, as if it were the only one.
    base: PlanInputs,
    /// Name of the stage.
    stage: Option<String>,
    found: &'a (dyn Fn(&SizeRow) + Sync),
    task: &'a Task,
}

/// The thickest electrode that can be made, from which reductions are tried.
struct Full {
    prepared: Arc<PreparedElectrode>,
    /// Circumferential reduction that it was made with (rad).
    reduction: f64,
}

impl Full {
    /// The angles by which its walls are drawn in further for reductions (rad); by none for less than it has.
    fn turns(&self, reductions: [f64; 2]) -> Turns {
        let further = reductions.map(|reduction| (reduction - self.reduction).max(0.0));
        Turns(own_turns(self.prepared.electrode().column, further))
    }
}

impl Sizing<'_> {
    fn one_part(&self, rows: &mut Vec<PlannedSize>) -> Result<(), PlanJobError> {
        let mut best: Option<(EntrySide, Least)> = None;
        let (mut impossible, mut possible) = (Vec::new(), false);
        for side in sides(&self.of(1).job, &self.prepared.space.channel, 0)? {
            let full = match self.full(1, 0, side) {
                Err(PlanJobError::Electrode(error)) => {
                    impossible.push((side, error));
                    continue;
                }
                full => full?,
            };
            let equal = |sizer: &Sizer| sizer.least(FIRST_DEG.to_radians(), &|h| full.turns([h, h]));
            let Some(least) = self.sized(&full, equal)? else {
                possible = true;
                continue;
            };
            let angle = least.angle.max(full.reduction);
            let sized = match self.certified((1, only(side)), &[[angle; 2]], 0) {
                // What is made for the plan may be refused where the fullest one was not.
                Err(PlanJobError::Electrode(error)) => {
                    impossible.push((side, error));
                    continue;
                }
                sized => sized?,
            };
            possible = true;
            let Some(sized) = sized else { continue };
            let sized = self.lowered(sized)?;
            let least = Least { angle: sized.row.most_deg().to_radians(), ..least };
            self.show(sized, rows);
            if best.as_ref().is_none_or(|(_, known)| least.angle < known.angle) {
                best = Some((side, least));
            }
        }
        // A side for which no electrode can be made is left, unless there is no other.
        if let Some(error) = ElectrodeError::of_sides(impossible).filter(|_| !possible) {
            return Err(error.into());
        }
        if let Some((side, least)) = best {
            let of_side = rows.iter().map(|sized| &sized.row).filter(|row| row.enter == only(side));
            let thickest = of_side.map(|row| row.least_thickness_mm).fold(0.0, f64::max);
            let walls = self.unequal(&self.full(1, 0, side)?, &least)?;
            // Where neither can be less, that row is there.
            if walls != [least.angle; 2]
                && let Some(sized) = self.certified((1, only(side)), &[walls], 0)?
                && sized.row.least_thickness_mm >= thickest
            {
                self.show(sized, rows);
            }
        }
        Ok(())
    }

    fn show(&self, sized: PlannedSize, rows: &mut Vec<PlannedSize>) {
        (self.found)(&sized.row);
        rows.push(sized);
    }

    /// Reductions of both walls of `full` (rad): with one wall as far drawn in as both need, the other is drawn in as little as it
    /// can be; the better of the two ways round.
    fn unequal(&self, full: &Full, equal: &Least) -> Result<[f64; 2], PlanJobError> {
        let angle = equal.angle;
        let below = |turns: &dyn Fn(f64) -> [f64; 2]| {
            let turns = |h: f64| full.turns(turns(h));
            let least =
                self.sized(full, |sizer| sizer.warm_started_down(equal.clone(), sizer.nothing_blocked(), &turns))?;
            Ok::<_, PlanJobError>(least.angle.max(full.reduction))
        };
        let low = below(&|h| [h, angle])?;
        let high = below(&|h| [angle, h])?;
        Ok(if high < low { [angle, high] } else { [low, angle] })
    }

    fn many(&self, parts: usize, rows: &mut Vec<PlannedSize>) -> Result<(), PlanJobError> {
        let inputs = self.of(parts);
        let (mut most, mut limiting) = (0.0f64, 0);
        let mut walls = vec![[0.0f64; 2]; parts];
        for number in 0..inputs.electrodes() {
            let (part, column) = inputs.job.electrode.place_of(number);
            let mut least: Option<(Least, Full)> = None;
            let (mut impossible, mut possible) = (Vec::new(), false);
            for side in sides(&inputs.job, &self.prepared.space.channel, number)? {
                let full = match self.full(parts, number, side) {
                    Err(PlanJobError::Electrode(error)) => {
                        impossible.push((side, error));
                        continue;
                    }
                    full => full?,
                };
                possible = true;
                let first = most.max(0.5 * FIRST_DEG.to_radians());
                let turns = |h: f64| full.turns([h; 2]);
                if let Some(found) = self.sized(&full, |sizer| sizer.least(first, &turns))? {
                    least = Some((Least { angle: found.angle.max(full.reduction), ..found }, full));
                    break;
                }
            }
            if let Some(error) = ElectrodeError::of_sides(impossible).filter(|_| !possible) {
                return Err(error.into());
            }
            let Some((least, full)) = least else { return Ok(()) };
            if least.angle > most {
                (most, limiting) = (least.angle, number);
            }
            match column {
                None => walls[part] = self.unequal(&full, &least)?,
                Some(Column::Low) => walls[part][0] = least.angle,
                Some(Column::High) => walls[part][1] = least.angle,
            }
        }
        let way = (parts, self.base.job.electrode.enter);
        if let Some(sized) = self.certified(way, &[[most; 2]], limiting)? {
            self.show(sized, rows);
        }
        let is_less = walls.iter().flatten().any(|wall| *wall < most - TOLERANCE_DEG.to_radians());
        if is_less && let Some(sized) = self.certified(way, &walls, limiting)? {
            self.show(sized, rows);
        }
        Ok(())
    }

    /// The electrode without circumferential reductions, or with the first that are tried where it cannot be made without.
    fn full(&self, parts: usize, number: usize, side: EntrySide) -> Result<Full, PlanJobError> {
        let mut inputs = self.of(parts);
        match self.prepared.fullest(&inputs, (number, side), self.task) {
            Err(error) if is_mended_by_less(&error) => {}
            made => return Ok(Full { prepared: made?.0, reduction: 0.0 }),
        }
        inputs.job.electrode.circumferential_reduction_deg = [FIRST_DEG; 2];
        let (prepared, Turns(drawn_in)) = self.prepared.fullest(&inputs, (number, side), self.task)?;
        let further = drawn_in.into_iter().fold(0.0, f64::max);
        Ok(Full { prepared, reduction: FIRST_DEG.to_radians() - further })
    }

    /// The inputs for a number of parts; with another number than that of the job its single parts have nothing of
    /// their own.
    fn of(&self, parts: usize) -> PlanInputs {
        let mut inputs = self.base.clone();
        with_parts(&mut inputs.job.electrode, parts);
        inputs
    }

    /// What `work` finds with the sizer of `full`.
    fn sized<T>(&self, full: &Full, work: impl FnOnce(&Sizer) -> Result<T, PlanError>) -> Result<T, PlanJobError> {
        let space = &self.prepared.space;
        let settings = settings_of(&self.base.job, &|_, _| ());
        Ok(work(&Sizer {
            space,
            electrode: full.prepared.electrode(),
            model: &full.prepared.model(space, settings.side_demand(), &self.task.cancel)?,
            settings: &settings,
            tolerance: TOLERANCE_DEG.to_radians(),
            most: MOST_DEG.to_radians(),
            task: self.task,
        })?)
    }

    /// The row for reductions (rad) of all parts or of each, with a little more where the certificate asks for it; electrode number
    /// `limiting` from 0 needs the most.
    fn certified(
        &self,
        (parts, enter): (usize, EnterSide),
        walls: &[[f64; 2]],
        limiting: usize,
    ) -> Result<Option<PlannedSize>, PlanJobError> {
        let mut inputs = self.of(parts);
        inputs.job.electrode.enter = enter;
        let mut raises = vec![0; walls.len()];
        for _ in 0..=RAISES {
            let more = |part: usize| raises[part] as f64 * TOLERANCE_DEG;
            let raised = walls.iter().enumerate().map(|(part, walls)| walls.map(|wall| wall.to_degrees() + more(part)));
            let raised_deg = raises.iter().max().map_or(0.0, |raises| f64::from(*raises) * TOLERANCE_DEG);
            match self.planned(&mut inputs, raised.collect(), limiting)? {
                Ok(sized) => return Ok(Some(PlannedSize { row: SizeRow { raised_deg, ..sized.row }, ..sized })),
                Err(outcome) if walls.len() > 1 => {
                    let failed = outcome.electrodes.iter().filter(|e| !e.plan.is_verified());
                    let mut parts: Vec<usize> = failed.map(|e| e.electrode.part).collect();
                    parts.dedup();
                    parts.into_iter().for_each(|part| raises[part] += 1);
                }
                Err(_) => raises[0] += 1,
            }
        }
        Ok(None)
    }

    /// `sized`, which has one part and equal reductions, or one of less reduction that a whole plan reaches: a plan needs
    /// less clearance in its fields than the search for the least, and repairs what its certificate rejects.
    fn lowered(&self, mut sized: PlannedSize) -> Result<PlannedSize, PlanJobError> {
        let mut inputs = self.of(1);
        inputs.job.electrode.enter = sized.row.enter;
        let mut left = LOWER.iter();
        let mut plans = 0;
        while let Some(step) = left.next().filter(|_| plans < MOST_LOWERED) {
            plans += 1;
            let lower = sized.row.most_deg() - step * TOLERANCE_DEG;
            if lower > 0.0
                && let Ok(found) = self.planned(&mut inputs, vec![[lower; 2]], 0)?
            {
                sized = found;
                left = LOWER.iter();
            }
        }
        Ok(sized)
    }

    /// The row of the plan for reductions (deg), if it is certified; otherwise the plan.
    fn planned(
        &self,
        inputs: &mut PlanInputs,
        reduction_deg: Vec<[f64; 2]>,
        limiting: usize,
    ) -> Result<Result<PlannedSize, PlanOutcome>, PlanJobError> {
        // To a thousandth, upwards: what is shown is what was planned.
        let upwards = |walls: [f64; 2]| walls.map(|deg| (deg * 1e3).ceil() / 1e3);
        let reduction_deg: Vec<[f64; 2]> = reduction_deg.into_iter().map(upwards).collect();
        reduce(&mut inputs.job.electrode, &reduction_deg);
        let mut part = inputs.job.electrode.part.clone();
        without_reductions(&mut part);
        let mut outcome = run_feeds(self.prepared, inputs, self.task)?;
        if !outcome.is_verified() {
            return Ok(Err(outcome));
        }
        for electrode in &mut outcome.electrodes {
            electrode.electrode.stage.clone_from(&self.stage);
        }
        let electrodes = || outcome.electrodes.iter();
        let certified = electrodes().filter_map(|e| e.plan.path.as_ref()).map(|p| p.certificate.certified());
        let row = SizeRow {
            stage: self.stage.clone(),
            parts: inputs.job.electrode.parts,
            enter: inputs.job.electrode.enter,
            reduction_deg,
            part,
            least_thickness_mm: electrodes().map(|e| e.electrode.least_thickness_mm).fold(f64::INFINITY, f64::min),
            volume_mm3: electrodes().map(|e| e.electrode.volume_mm3).sum(),
            certified_mm: certified.fold(f64::INFINITY, f64::min),
            limit: limit_of(&outcome, limiting),
            raised_deg: 0.0,
        };
        Ok(Ok(PlannedSize { row, electrodes: outcome.electrodes }))
    }
}

/// Where electrode number `limiting` from 0 of a plan is closest to a wall on its way out: of walls it is drawn in, and
/// so they keep it from being thicker. Without such a place that of its least clearance.
fn limit_of(outcome: &PlanOutcome, limiting: usize) -> Option<SizeLimit> {
    let electrode = outcome.electrodes.get(limiting)?;
    let planned = electrode.plan.path.as_ref()?;
    let (c, rows) = (&planned.certificate, &planned.path.rows);
    let places = rows.iter().zip(c.row_surface()).zip(c.row_clearance());
    let walls = places.filter(|((_, surface), _)| matches!(surface, Surface::LowWall | Surface::HighWall));
    let nearest = walls.min_by(|p, q| p.1.total_cmp(q.1)).map(|((row, surface), _)| (row, *surface));
    let (row, surface) = nearest.or_else(|| Some((rows.get(c.least().row.round() as usize)?, c.least().surface)))?;
    Some(SizeLimit {
        electrode: limiting + 1,
        electrodes: outcome.electrodes.len(),
        enters_from: electrode.electrode.enters_from,
        node: row.node,
        s_mm: row.s,
        surface: outcome.channel.surface_name(surface).to_owned(),
    })
}

fn only(side: EntrySide) -> EnterSide {
    side.into()
}

#[cfg(test)]
mod tests;
