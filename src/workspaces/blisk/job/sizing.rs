//! Automatic sizing: the thickest electrodes that come out, for one part and more, on either side.

use std::sync::Arc;

use serde::Serialize;

use super::outcome::{PlanInputs, PlanJobError, PlanOutcome};
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
use wheel::electrode::{ElectrodeError, EnterSide, EntrySide, Sizing as SizeMode, own_turns};

/// What is sized.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SizingRange {
    /// Least number of parts.
    pub from: usize,
    /// Greatest number of parts.
    pub to: usize,
}

/// A certified way to make the electrodes.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SizeRow {
    /// Number of parts.
    pub parts: usize,
    /// The side they enter from.
    pub enter: EnterSide,
    /// Circumferential reductions of the low and the high wall (deg).
    pub reduction_deg: [f64; 2],
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
    /// Puts parts, side and reductions of the row into `job`, with the search that found them; with another number of parts than
    /// before its single parts have nothing of their own.
    pub fn apply(&self, job: &mut PlanJob) {
        (job.plan.strategy, job.genetic.h) = (Strategy::Global, ReductionMode::Given);
        let electrode = &mut job.electrode;
        if electrode.parts != self.parts {
            (electrode.parts, electrode.part) = (self.parts, Vec::new());
        }
        for part in &mut electrode.part {
            (part.low_reduction_deg, part.high_reduction_deg) = (None, None);
        }
        if let Some(last) = electrode.stage.last_mut() {
            (last.low_reduction_deg, last.high_reduction_deg) = (None, None);
        }
        (electrode.circumferential_reduction_deg, electrode.enter) = (self.reduction_deg, self.enter);
        electrode.size = SizeMode::Given;
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

/// Sizes the electrodes of the job, or of its last stage, for every number of parts in `range`, and shows `found` each row as it is certified.
/// For one part both reductions are equal first, on each side of entry that the job allows, and then as unequal as
/// brings most on the better side; for more parts, or columns, they are equal, the greatest that any of them needs.
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
    if !inputs.own_electrodes.is_empty() {
        return Err(PlanJobError::Job(
            "an electrode mesh of your own has the size it has; remove it to size".to_owned(),
        ));
    }
    // The last stage has the least gap and makes the surface; those before follow it.
    let (mut base, _) = inputs.of_electrode(inputs.job.electrode.count() - 1);
    base.job.plan.strategy = Strategy::Global;
    base.job.genetic.h = ReductionMode::Given;
    base.job.electrode.size = SizeMode::Given;
    base.job.electrode.circumferential_reduction_deg = [0.0; 2];
    for part in &mut base.job.electrode.part {
        (part.low_reduction_deg, part.high_reduction_deg) = (None, None);
    }
    base.job.validate()?;
    let sizing = Sizing { prepared, base, found, task };
    let mut rows = Vec::new();
    for parts in range.from..=range.to {
        let single = parts == 1 && sizing.base.job.electrode.columns == 1;
        if single { sizing.one_part(&mut rows)? } else { sizing.many(parts, &mut rows)? }
    }
    Ok(rows)
}

/// `[electrode] size = "auto"`: `inputs` with the reductions, and the side of entry, of the thickest electrodes that
/// come out in as many parts as it asks for, to be planned with the strategy that found them; and the row they come
/// from. With the reductions that it gives, and no row, if none lets them out: planning these tells where they jam.
///
/// # Errors
/// Every error of [`size`].
pub fn auto_sized(
    prepared: &PreparedBlisk,
    inputs: &PlanInputs,
    task: &Task,
) -> Result<(PlanInputs, Option<SizeRow>), PlanJobError> {
    let mut sized = inputs.clone();
    let electrode = &mut sized.job.electrode;
    let parts = electrode.parts;
    electrode.size = SizeMode::Given;
    let range = SizingRange { from: parts, to: parts };
    let rows = size(prepared, &sized, range, &|_| (), task)?;
    let thickest = rows.into_iter().max_by(|a, b| a.least_thickness_mm.total_cmp(&b.least_thickness_mm));
    if let Some(row) = &thickest {
        row.apply(&mut sized.job);
    }
    Ok((sized, thickest))
}

struct Sizing<'a> {
    prepared: &'a PreparedBlisk,
    base: PlanInputs,
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
    fn one_part(&self, rows: &mut Vec<SizeRow>) -> Result<(), PlanJobError> {
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
            possible = true;
            let equal = |sizer: &Sizer| sizer.least(FIRST_DEG.to_radians(), &|h| full.turns([h, h]));
            let Some(least) = self.sized(&full, equal)? else { continue };
            let angle = least.angle.max(full.reduction);
            let Some(row) = self.certified(1, only(side), [angle; 2], 0)? else { continue };
            let row = self.lowered(row)?;
            let least = Least { angle: row.reduction_deg[0].to_radians(), ..least };
            self.show(row, rows);
            if best.as_ref().is_none_or(|(_, known)| least.angle < known.angle) {
                best = Some((side, least));
            }
        }
        // A side for which no electrode can be made is left, unless there is no other.
        if let Some(error) = ElectrodeError::of_sides(impossible).filter(|_| !possible) {
            return Err(error.into());
        }
        if let Some((side, least)) = best {
            let equal = rows.iter().filter(|r| r.enter == only(side)).map(|r| r.least_thickness_mm).fold(0.0, f64::max);
            if let Some(row) = self.unequal(side, &least)?.filter(|row| row.least_thickness_mm >= equal) {
                self.show(row, rows);
            }
        }
        Ok(())
    }

    fn show(&self, row: SizeRow, rows: &mut Vec<SizeRow>) {
        (self.found)(&row);
        rows.push(row);
    }

    /// With one wall as far drawn in as both need, the other is drawn in as little as it can be; the better of the two
    /// ways round.
    fn unequal(&self, side: EntrySide, equal: &Least) -> Result<Option<SizeRow>, PlanJobError> {
        let full = self.full(1, 0, side)?;
        let angle = equal.angle;
        let below = |turns: &dyn Fn(f64) -> [f64; 2]| {
            let turns = |h: f64| full.turns(turns(h));
            let least =
                self.sized(&full, |sizer| sizer.warm_started_down(equal.clone(), sizer.nothing_blocked(), &turns))?;
            Ok::<_, PlanJobError>(least.angle.max(full.reduction))
        };
        let low = below(&|h| [h, angle])?;
        let high = below(&|h| [angle, h])?;
        let turns = if high < low { [angle, high] } else { [low, angle] };
        if turns == [angle; 2] {
            // Neither can be less: that row is there.
            return Ok(None);
        }
        self.certified(1, only(side), turns, 0)
    }

    fn many(&self, parts: usize, rows: &mut Vec<SizeRow>) -> Result<(), PlanJobError> {
        let inputs = self.of(parts);
        let (mut most, mut limiting) = (0.0f64, 0);
        for number in 0..inputs.electrodes() {
            let mut least: Option<Least> = None;
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
                // What another one needs already costs nothing more.
                let first = most.max(0.5 * FIRST_DEG.to_radians());
                let turns = |h: f64| full.turns([h.max(most); 2]);
                least = self.sized(&full, |sizer| sizer.least(first, &turns))?;
                if let Some(least) = &mut least {
                    least.angle = least.angle.max(full.reduction);
                    break;
                }
            }
            if let Some(error) = ElectrodeError::of_sides(impossible).filter(|_| !possible) {
                return Err(error.into());
            }
            let Some(least) = least else { return Ok(()) };
            if least.angle > most {
                (most, limiting) = (least.angle, number);
            }
        }
        if let Some(row) = self.certified(parts, self.base.job.electrode.enter, [most; 2], limiting)? {
            self.show(row, rows);
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
        let electrode = &mut inputs.job.electrode;
        if electrode.parts != parts {
            (electrode.parts, electrode.part) = (parts, Vec::new());
        }
        inputs
    }

    /// What `work` finds with the sizer of `full`.
    fn sized<T>(&self, full: &Full, work: impl FnOnce(&Sizer) -> Result<T, PlanError>) -> Result<T, PlanJobError> {
        let space = &self.prepared.space;
        let settings = settings_of(&self.base.job, &|_, _| ());
        Ok(work(&Sizer {
            space,
            electrode: full.prepared.electrode(),
            model: &full.prepared.model(space, settings.side_demand()),
            settings: &settings,
            tolerance: TOLERANCE_DEG.to_radians(),
            most: MOST_DEG.to_radians(),
            task: self.task,
        })?)
    }

    /// The row for reductions (rad), with a little more where the certificate asks for it; electrode number `limiting`
    /// from 0 needs them.
    fn certified(
        &self,
        parts: usize,
        enter: EnterSide,
        turns: [f64; 2],
        limiting: usize,
    ) -> Result<Option<SizeRow>, PlanJobError> {
        let mut inputs = self.of(parts);
        inputs.job.electrode.enter = enter;
        for raise in 0..=RAISES {
            let more = raise as f64 * TOLERANCE_DEG;
            if let Some(row) = self.planned(&mut inputs, turns.map(|t| t.to_degrees() + more), limiting)? {
                return Ok(Some(SizeRow { raised_deg: more, ..row }));
            }
        }
        Ok(None)
    }

    /// `row`, which has one part and equal reductions, or one of less reduction that a whole plan reaches: a plan needs
    /// less clearance in its fields than the search for the least, and repairs what its certificate rejects.
    fn lowered(&self, mut row: SizeRow) -> Result<SizeRow, PlanJobError> {
        let mut inputs = self.of(1);
        inputs.job.electrode.enter = row.enter;
        let mut left = LOWER.iter();
        let mut plans = 0;
        while let Some(step) = left.next().filter(|_| plans < MOST_LOWERED) {
            plans += 1;
            let lower = row.reduction_deg.map(|deg| deg - step * TOLERANCE_DEG);
            if lower[0] > 0.0
                && let Some(found) = self.planned(&mut inputs, lower, 0)?
            {
                row = found;
                left = LOWER.iter();
            }
        }
        Ok(row)
    }

    /// The row of the plan for reductions (deg), if it is certified.
    fn planned(
        &self,
        inputs: &mut PlanInputs,
        reduction_deg: [f64; 2],
        limiting: usize,
    ) -> Result<Option<SizeRow>, PlanJobError> {
        // To a thousandth, upwards: what is shown is what was planned.
        let reduction = reduction_deg.map(|deg| (deg * 1e3).ceil() / 1e3);
        let electrode = &mut inputs.job.electrode;
        electrode.circumferential_reduction_deg = reduction;
        let (parts, enter) = (electrode.parts, electrode.enter);
        let outcome = run_feeds(self.prepared, inputs, self.task)?;
        let row = row_of(&outcome, parts, enter, reduction);
        Ok(row.map(|row| SizeRow { limit: limit_of(&outcome, limiting), ..row }))
    }
}

/// The row of a plan, if it is certified.
fn row_of(outcome: &PlanOutcome, parts: usize, enter: EnterSide, reduction_deg: [f64; 2]) -> Option<SizeRow> {
    if !outcome.is_verified() {
        return None;
    }
    let electrodes = || outcome.electrodes.iter();
    let certified = electrodes().filter_map(|e| e.plan.path.as_ref()).map(|p| p.certificate.certified());
    Some(SizeRow {
        parts,
        enter,
        reduction_deg,
        least_thickness_mm: electrodes().map(|e| e.electrode.least_thickness_mm).fold(f64::INFINITY, f64::min),
        volume_mm3: electrodes().map(|e| e.electrode.volume_mm3).sum(),
        certified_mm: certified.fold(f64::INFINITY, f64::min),
        limit: None,
        raised_deg: 0.0,
    })
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
