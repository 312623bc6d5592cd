//! Changes of an electrode that would let it out where it jams: more reduction of its walls, another side of entry, more
//! radial reduction, two shorter electrodes in its place.

use super::outcome::{PlanInputs, PlanJobError};
use super::plan::{comes_out, sides};
use super::prepared_blisk::PreparedBlisk;
use super::preview::preview_on;
use feed::jam::{Change, Opening};
use task::Task;
use wheel::electrode::{EntrySide, PartParams};

/// Radial reductions that are tried, as shares of the height of the passage in the middle of the blades, on top of the
/// one that jams.
const MORE_RADIAL: [f64; 3] = [0.1, 0.2, 0.35];

/// Reductions are found to a hundredth of a degree, upwards; where no certificate holds with what a search found enough,
/// so much more is tried (deg).
const RAISES_DEG: [f64; 3] = [0.01, 0.1, 0.3];

/// Adds to `opening` the changes by which electrode number `number` along the passage comes out, as far as a preview
/// tells, and those by which it does not. It jams on `tried`. Radial reductions and divisions are looked at where no
/// further reduction of the walls is enough.
///
/// # Errors
/// When told to stop.
pub(super) fn look_for_changes(
    opening: &mut Opening,
    (prepared, inputs): (&PreparedBlisk, &PlanInputs),
    number: usize,
    tried: &[EntrySide],
    task: &Task,
) -> Result<(), PlanJobError> {
    let remedies = Remedies { prepared, task: &task.as_stage("what would make it feasible") };
    let mut by_walls = false;
    for more in [opening.both.map(|h| [h, h]), opening.low.map(|h| [h, 0.0]), opening.high.map(|h| [0.0, h])] {
        // Where both walls help by the same angle, that is enough to know.
        let Some(more) = more.filter(|_| !by_walls && inputs.own_electrodes.is_empty()) else { continue };
        let (change, opens) = remedies.walls(inputs, number, more)?;
        by_walls |= opens;
        if opens { &mut opening.changes } else { &mut opening.in_vain }.push(change);
    }
    let changes = remedies.changes(inputs, number, tried, by_walls);
    for (change, variants) in changes {
        // One of a kind is enough.
        let kind = std::mem::discriminant(&change);
        if opening.changes.iter().any(|known| std::mem::discriminant(known) == kind) {
            continue;
        }
        let mut opens = true;
        for (inputs, number) in &variants {
            opens = opens && remedies.comes_out(inputs, *number)?;
        }
        if opens { &mut opening.changes } else { &mut opening.in_vain }.push(change);
    }
    // Of changes by an amount that are not enough the greatest says it all.
    let amount = |change: &Change| if let Change::Radial(mm) = change { Some(*mm) } else { None };
    let most = opening.in_vain.iter().filter_map(amount).fold(0.0, f64::max);
    opening.in_vain.retain(|change| amount(change).is_none_or(|mm| mm == most));
    Ok(())
}

struct Remedies<'a> {
    prepared: &'a PreparedBlisk,
    task: &'a Task,
}

impl Remedies<'_> {
    /// More reduction of the walls (rad), a little more where no certificate holds, and whether the electrode comes out.
    fn walls(&self, inputs: &PlanInputs, number: usize, more: [f64; 2]) -> Result<(Change, bool), PlanJobError> {
        let (part, _) = inputs.job.electrode.place_of(number);
        let now = inputs.job.electrode.of_part(part).circumferential_reduction_deg;
        let tries = RAISES_DEG.map(|raise| {
            let reduction = |wall: usize| match more[wall] {
                0.0 => now[wall],
                more => ((now[wall] + more.max(0.0).to_degrees() + raise) * 100.0).ceil() / 100.0,
            };
            let reductions = [reduction(0), reduction(1)];
            let with = self.with(inputs, part, &|row| {
                (row.low_reduction_deg, row.high_reduction_deg) = (Some(reductions[0]), Some(reductions[1]));
            });
            let more = [0, 1].map(|wall| (reductions[wall] - now[wall]).to_radians());
            (with, Change::Walls { reductions: reductions.map(f64::to_radians), more })
        });
        for (with, walls) in &tries {
            match comes_out(self.prepared, with, number, self.task) {
                Err(PlanJobError::Cancelled(cancelled)) => return Err(cancelled.into()),
                // One that cannot be made or judged does not come out.
                Err(_) => break,
                Ok(true) => return Ok((*walls, true)),
                Ok(false) => {}
            }
        }
        Ok((tries[0].1, false))
    }

    /// The inputs with another row of single part `part`.
    fn with(&self, inputs: &PlanInputs, part: usize, edit: &dyn Fn(&mut PartParams)) -> PlanInputs {
        let mut changed = inputs.clone();
        let rows = &mut changed.job.electrode.part;
        rows.resize(rows.len().max(part + 1), PartParams::default());
        edit(&mut rows[part]);
        changed
    }

    /// Changes worth a look, each with the electrodes that it leads to: their inputs and numbers.
    fn changes(
        &self,
        inputs: &PlanInputs,
        number: usize,
        tried: &[EntrySide],
        is_by_walls: bool,
    ) -> Vec<(Change, Vec<(PlanInputs, usize)>)> {
        let channel = &self.prepared.space.channel;
        let (part, _) = inputs.job.electrode.place_of(number);
        let with = |edit: &dyn Fn(&mut PartParams)| self.with(inputs, part, edit);
        let mut changes = Vec::new();
        for side in EntrySide::open(channel).into_iter().filter(|side| !tried.contains(side)) {
            if inputs.job.machine.comes_from(side) {
                changes.push((Change::Side(side), vec![(with(&|row| row.enter = side.into()), number)]));
            }
        }
        if is_by_walls || !inputs.own_electrodes.is_empty() {
            return changes;
        }
        let has_now = inputs.job.electrode.of_part(part).radial_reduction_mm;
        let height = channel.middle().height();
        for share in MORE_RADIAL {
            // To a tenth: what is said is what was tried.
            let radial = ((has_now + share * height) * 10.0).ceil() / 10.0;
            changes.push((Change::Radial(radial), vec![(with(&|row| row.radial_reduction_mm = Some(radial)), number)]));
        }
        let mut divided = inputs.clone();
        let share = divided.job.electrode.divide(part);
        let columns = inputs.job.electrode.columns;
        if divided.job.electrode.validate().is_ok() {
            changes.push((Change::Divided(share), vec![(divided.clone(), number), (divided, number + columns)]));
        }
        changes
    }

    /// Whether a preview finds a path of electrode number `number` to some side that `inputs` allow.
    fn comes_out(&self, inputs: &PlanInputs, number: usize) -> Result<bool, PlanJobError> {
        for side in sides(&inputs.job, &self.prepared.space.channel, number).unwrap_or_default() {
            match preview_on(self.prepared, inputs, (number, side), self.task) {
                Err(PlanJobError::Cancelled(cancelled)) => return Err(cancelled.into()),
                // One that cannot be made or judged does not come out.
                Err(_) => {}
                Ok(way) if way.margin.is_some() => return Ok(true),
                Ok(_) => {}
            }
        }
        Ok(false)
    }
}
