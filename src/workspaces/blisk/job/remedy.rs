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

/// A change, and the electrodes that it leads to: their inputs and numbers.
struct Variant {
    change: Change,
    electrodes: Vec<(PlanInputs, usize)>,
}

/// A search for changes by which an electrode comes out that jams on every side.
pub(super) struct RemedySearch<'a> {
    prepared: &'a PreparedBlisk,
    inputs: &'a PlanInputs,
    /// Number of the electrode along the passage.
    number: usize,
    /// Sides that need not be proposed.
    tried: &'a [EntrySide],
    /// Whether more reduction of the walls is enough on some side.
    by_walls: bool,
    /// Whether what is no matter of a side was looked for: other sides, and a division.
    of_all_sides: bool,
}

impl<'a> RemedySearch<'a> {
    /// A search for electrode number `number` along the passage, which was tried on the sides `tried`.
    pub(super) fn new(
        prepared: &'a PreparedBlisk,
        inputs: &'a PlanInputs,
        number: usize,
        tried: &'a [EntrySide],
    ) -> Self {
        Self { prepared, inputs, number, tried, by_walls: false, of_all_sides: false }
    }

    /// Adds to `opening`, that of a jam towards `side`, the further reduction of the walls by which the electrode has a
    /// certified path towards that side, or those that are not enough.
    ///
    /// # Errors
    /// When told to stop; what was found by then is in `opening`.
    pub(super) fn walls(&mut self, opening: &mut Opening, side: EntrySide, task: &Task) -> Result<(), PlanJobError> {
        let mut is_enough = false;
        for more in [opening.both.map(|h| [h, h]), opening.low.map(|h| [h, 0.0]), opening.high.map(|h| [0.0, h])] {
            // Where both walls help by the same angle, that is enough to know.
            let Some(more) = more.filter(|_| !is_enough && self.inputs.own_electrodes.is_empty()) else { continue };
            let (change, opens) = self.with_walls(more, side, task)?;
            is_enough |= opens;
            if opens { &mut opening.changes } else { &mut opening.in_vain }.push(change);
        }
        self.by_walls |= is_enough;
        Ok(())
    }

    /// Adds to `opening`, that of a jam towards `side`, the other changes by which the electrode comes out as far as a
    /// preview tells, and those by which it does not. Reductions are looked at where none of the walls alone is enough on
    /// any side, and hold for `side`. Another side, and a division, after which each half may take a side of its own, are
    /// looked at once, for the first jam.
    ///
    /// # Errors
    /// When told to stop; what was found by then is in `opening`.
    pub(super) fn others(&mut self, opening: &mut Opening, side: EntrySide, task: &Task) -> Result<(), PlanJobError> {
        for amounts in self.changes(side, opening.most) {
            let Some((greatest, less)) = amounts.split_last() else { continue };
            // One of a kind is enough, and all reductions at once are the last resort.
            let kind = std::mem::discriminant(&greatest.change);
            let is_last_resort = matches!(greatest.change, Change::AllReductions { .. });
            if opening.changes.iter().any(|known| is_last_resort || std::mem::discriminant(known) == kind) {
                continue;
            }
            if !self.opens(greatest, task)? {
                opening.in_vain.push(greatest.change);
                continue;
            }
            let mut least = greatest;
            for variant in less {
                if self.opens(variant, task)? {
                    least = variant;
                    break;
                }
            }
            opening.changes.push(least.change);
        }
        self.of_all_sides = true;
        Ok(())
    }

    /// More reduction of the walls (rad), a little more where no certificate holds, and whether the electrode comes out
    /// towards `side`.
    fn with_walls(&self, more: [f64; 2], side: EntrySide, task: &Task) -> Result<(Change, bool), PlanJobError> {
        let electrode = &self.inputs.job.electrode;
        let now = electrode.of_part(electrode.place_of(self.number).0).circumferential_reduction_deg;
        let tries = RAISES_DEG.map(|raise| {
            let reduction = |wall: usize| match more[wall] {
                0.0 => now[wall],
                more => ((now[wall] + more.max(0.0).to_degrees() + raise) * 100.0).ceil() / 100.0,
            };
            let reductions = [reduction(0), reduction(1)];
            let with = self.with(side, &|row| {
                (row.low_reduction_deg, row.high_reduction_deg) = (Some(reductions[0]), Some(reductions[1]));
            });
            let more = [0, 1].map(|wall| (reductions[wall] - now[wall]).to_radians());
            (with, Change::Walls { reductions: reductions.map(f64::to_radians), more })
        });
        for (with, walls) in &tries {
            match comes_out(self.prepared, with, self.number, task) {
                Err(PlanJobError::Cancelled(cancelled)) => return Err(cancelled.into()),
                // One that cannot be made or judged does not come out.
                Err(_) => break,
                Ok(true) => return Ok((*walls, true)),
                Ok(false) => {}
            }
        }
        Ok((tries[0].1, false))
    }

    /// The inputs with another row of the part that the electrode burns, which enters from `side`.
    fn with(&self, side: EntrySide, edit: &dyn Fn(&mut PartParams)) -> PlanInputs {
        let mut changed = self.inputs.clone();
        let (part, _) = changed.job.electrode.place_of(self.number);
        let rows = &mut changed.job.electrode.part;
        rows.resize(rows.len().max(part + 1), PartParams::default());
        rows[part].enter = side.into();
        edit(&mut rows[part]);
        changed
    }

    /// Changes worth a look for a jam towards `side`, each in rising amounts; where no reduction of the walls is enough on
    /// any side, up to `most_walls` (rad) on this one, those of other sizes too.
    fn changes(&self, side: EntrySide, most_walls: f64) -> Vec<Vec<Variant>> {
        let (inputs, number, channel) = (self.inputs, self.number, &self.prepared.space.channel);
        let (part, _) = inputs.job.electrode.place_of(number);
        let one = |change: Change, with: PlanInputs| Variant { change, electrodes: vec![(with, number)] };
        let mut changes = Vec::new();
        for other in EntrySide::open(channel).into_iter().filter(|other| !self.tried.contains(other)) {
            if !self.of_all_sides && inputs.job.machine.comes_from(other) {
                changes.push(vec![one(Change::Side(other), self.with(other, &|_| ()))]);
            }
        }
        if self.by_walls || !inputs.own_electrodes.is_empty() {
            return changes;
        }
        let with = |edit: &dyn Fn(&mut PartParams)| self.with(side, edit);
        let now = inputs.job.electrode.of_part(part);
        let height = channel.middle().height();
        // To a tenth: what is said is what was tried.
        let radial = |share: f64| ((now.radial_reduction_mm + share * height) * 10.0).ceil() / 10.0;
        let drawn_in = |mm: f64| one(Change::Radial(mm), with(&|row| row.radial_reduction_mm = Some(mm)));
        changes.push(MORE_RADIAL.map(radial).map(drawn_in).into());
        let mut divided = inputs.clone();
        let share = divided.job.electrode.divide(part);
        let columns = inputs.job.electrode.columns;
        if !self.of_all_sides && divided.job.electrode.validate().is_ok() {
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
    fn opens(&self, variant: &Variant, task: &Task) -> Result<bool, PlanJobError> {
        for (inputs, number) in &variant.electrodes {
            if !self.comes_out(inputs, *number, task)? {
                return Ok(false);
            }
        }
        Ok(true)
    }

    /// Whether a preview finds a path of electrode number `number` to some side that `inputs` allow.
    fn comes_out(&self, inputs: &PlanInputs, number: usize, task: &Task) -> Result<bool, PlanJobError> {
        for side in sides(&inputs.job, &self.prepared.space.channel, number).unwrap_or_default() {
            match preview_on(self.prepared, inputs, (number, side), task) {
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
