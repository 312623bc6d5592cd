//! Changes of an electrode that would let it out where it jams: more reduction of its walls, another side of entry, more
//! radial reduction, two shorter electrodes in its place, more of all reductions at once.

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

/// Shares of the greatest further reduction of the walls and of the height of the passage that are tried at once.
const ALL_REDUCTIONS: [[f64; 2]; 2] = [[0.5, 0.2], [1.0, 0.35]];

/// Reductions are found to a hundredth of a degree, upwards; where no certificate holds with what a search found enough,
/// so much more is tried (deg).
const RAISES_DEG: [f64; 3] = [0.01, 0.1, 0.3];

/// Adds to `opening` the changes by which electrode number `number` along the passage comes out, as far as a preview
/// tells, and those by which it does not. It jams on `tried`. Radial reductions and divisions are looked at where no
/// further reduction of the walls is enough.
///
/// # Errors
/// When told to stop; what was found by then is in `opening`.
pub(super) fn look_for_changes(
    opening: &mut Opening,
    (prepared, inputs): (&PreparedBlisk, &PlanInputs),
    number: usize,
    tried: &[EntrySide],
    task: &Task,
) -> Result<(), PlanJobError> {
    let remedies = Remedies { prepared, task };
    let mut by_walls = false;
    for more in [opening.both.map(|h| [h, h]), opening.low.map(|h| [h, 0.0]), opening.high.map(|h| [0.0, h])] {
        // Where both walls help by the same angle, that is enough to know.
        let Some(more) = more.filter(|_| !by_walls && inputs.own_electrodes.is_empty()) else { continue };
        let (change, opens) = remedies.walls(inputs, number, more)?;
        by_walls |= opens;
        if opens { &mut opening.changes } else { &mut opening.in_vain }.push(change);
    }
    let most_walls = (!by_walls).then_some(opening.most);
    for amounts in remedies.changes(inputs, number, tried, most_walls) {
        let Some((greatest, less)) = amounts.split_last() else { continue };
        // One of a kind is enough, and all reductions at once are the last resort.
        let kind = std::mem::discriminant(&greatest.change);
        let is_last_resort = matches!(greatest.change, Change::AllReductions { .. });
        if opening.changes.iter().any(|known| is_last_resort || std::mem::discriminant(known) == kind) {
            continue;
        }
        if !remedies.opens(greatest)? {
            opening.in_vain.push(greatest.change);
            continue;
        }
        let mut least = greatest;
        for variant in less {
            if remedies.opens(variant)? {
                least = variant;
                break;
            }
        }
        opening.changes.push(least.change);
    }
    Ok(())
}

/// A change, and the electrodes that it leads to: their inputs and numbers.
struct Variant {
    change: Change,
    electrodes: Vec<(PlanInputs, usize)>,
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

    /// Changes worth a look, each in rising amounts; where no reduction of the walls up to `most_walls` (rad) is enough,
    /// those of other sizes too.
    fn changes(
        &self,
        inputs: &PlanInputs,
        number: usize,
        tried: &[EntrySide],
        most_walls: Option<f64>,
    ) -> Vec<Vec<Variant>> {
        let channel = &self.prepared.space.channel;
        let (part, _) = inputs.job.electrode.place_of(number);
        let with = |edit: &dyn Fn(&mut PartParams)| self.with(inputs, part, edit);
        let one = |change: Change, with: PlanInputs| Variant { change, electrodes: vec![(with, number)] };
        let mut changes = Vec::new();
        for side in EntrySide::open(channel).into_iter().filter(|side| !tried.contains(side)) {
            if inputs.job.machine.comes_from(side) {
                changes.push(vec![one(Change::Side(side), with(&|row| row.enter = side.into()))]);
            }
        }
        let Some(most_walls) = most_walls.filter(|_| inputs.own_electrodes.is_empty()) else { return changes };
        let now = inputs.job.electrode.of_part(part);
        let height = channel.middle().height();
        // To a tenth: what is said is what was tried.
        let radial = |share: f64| ((now.radial_reduction_mm + share * height) * 10.0).ceil() / 10.0;
        let drawn_in = |mm: f64| one(Change::Radial(mm), with(&|row| row.radial_reduction_mm = Some(mm)));
        changes.push(MORE_RADIAL.map(radial).map(drawn_in).into());
        let mut divided = inputs.clone();
        let share = divided.job.electrode.divide(part);
        let columns = inputs.job.electrode.columns;
        if divided.job.electrode.validate().is_ok() {
            let electrodes = vec![(divided.clone(), number), (divided, number + columns)];
            changes.push(vec![Variant { change: Change::Divided(share), electrodes }]);
        }
        let all = ALL_REDUCTIONS.map(|[of_walls, of_height]| {
            let more = of_walls * most_walls.to_degrees();
            let degrees = now.circumferential_reduction_deg.map(|deg| ((deg + more) * 100.0).ceil() / 100.0);
            let radial_mm = radial(of_height);
            let smaller = with(&|row| {
                (row.low_reduction_deg, row.high_reduction_deg) = (Some(degrees[0]), Some(degrees[1]));
                row.radial_reduction_mm = Some(radial_mm);
            });
            let reductions = degrees.map(f64::to_radians);
            one(Change::AllReductions { reductions, radial_mm }, smaller)
        });
        changes.push(all.into());
        changes
    }

    /// Whether all electrodes of a change come out.
    fn opens(&self, variant: &Variant) -> Result<bool, PlanJobError> {
        for (inputs, number) in &variant.electrodes {
            if !self.comes_out(inputs, *number)? {
                return Ok(false);
            }
        }
        Ok(true)
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
