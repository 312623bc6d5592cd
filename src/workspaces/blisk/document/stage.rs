//! The steps from part to export, and the fingerprint of what each of them depends on.

use serde::Serialize;
use sha2::{Digest, Sha256};

use super::job_file::PlanJob;

/// A step of the work, in order; each depends on those before it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Stage {
    /// The blisk's mesh is loaded.
    Part,
    /// Axis, blades and channel are found.
    Channel,
    /// The electrode is made.
    Electrode,
    /// The feed path is searched.
    Plan,
    /// The path is certified.
    Verify,
    /// The approved path is written.
    Export,
}

impl Stage {
    /// Every step in order.
    pub const ALL: [Self; 6] = [Self::Part, Self::Channel, Self::Electrode, Self::Plan, Self::Verify, Self::Export];

    /// The name shown to a reader.
    pub fn name(self) -> &'static str {
        ["Part", "Channel", "Electrode", "Plan", "Verify", "Export"][self as usize]
    }

    /// Number of the stage, from 1.
    pub fn number(self) -> usize {
        self as usize + 1
    }
}

/// SHA-256 of everything that the result of a step depends on. A result with another fingerprint than that of the
/// present parameters is stale.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Fingerprint([u8; 32]);

impl Fingerprint {
    /// Fingerprint of the inputs of `stage` in `job`. `mesh` is the content of the part, and of the user's own
    /// electrode, as far as known.
    pub fn of(stage: Stage, job: &PlanJob, mesh: &str) -> Self {
        let mut hash = Sha256::new();
        hash.update(mesh);
        let reading = &job.blisk.reading;
        add(&mut hash, &(&job.blisk.mesh, &reading.units, &job.blisk.sections));
        // Plans that were kept before STEP files were read hold for a whole file.
        if *reading != reading.units.into() {
            add(&mut hash, reading);
        }
        // Older plans are of full rings.
        if let Some(blank) = &job.burning.blank {
            add(&mut hash, blank);
        }
        if stage >= Stage::Channel {
            add(&mut hash, &job.blisk.options);
        }
        if stage >= Stage::Electrode {
            // The sides of entry that are left depend on the bodies.
            add(&mut hash, &(&job.electrode.searched(), job.machine.has_bodies()));
        }
        if stage >= Stage::Plan {
            add(&mut hash, &(&job.machine, &job.plan, &job.genetic, &job.verify));
            // The motion is simulated in these.
            add(&mut hash, &job.export.channels);
            // The residual stock is that of the blank.
            if let Some(allowance) = job.burning.allowance_mm {
                add(&mut hash, &allowance);
            }
            // The errors that the feed bears are looked at with its motion.
            add(&mut hash, &job.setting);
        }
        if stage >= Stage::Export {
            add(&mut hash, &(&job.export, &job.technology, &job.burning, &job.setup));
            add(&mut hash, &job.electrode.stage);
        }
        Self(hash.finalize().into())
    }
}

fn add(hash: &mut Sha256, part: &impl Serialize) {
    // Parameters are plain numbers, texts and lists, which always have a JSON form; were one ever without, its
    // place would count as changed by the length marker alone.
    let text = serde_json::to_vec(part).unwrap_or_default();
    hash.update((text.len() as u64).to_le_bytes());
    hash.update(&text);
}

#[cfg(test)]
mod tests {
    use super::*;
    use wheel::electrode::StageParams;

    /// Stages that have another fingerprint after `change`.
    fn changed(change: impl Fn(&mut PlanJob)) -> Vec<Stage> {
        let before = PlanJob::demonstration();
        let mut after = before.clone();
        change(&mut after);
        let differs = |s: &Stage| Fingerprint::of(*s, &before, "m") != Fingerprint::of(*s, &after, "m");
        Stage::ALL.into_iter().filter(differs).collect()
    }

    #[test]
    fn a_change_makes_its_own_step_and_all_after_it_stale() {
        use Stage::{Channel, Electrode, Export, Plan, Verify};
        assert_eq!(changed(|_| ()), []);
        assert_eq!(changed(|j| j.blisk.mesh = Some("a.stl".into())), Stage::ALL);
        assert_eq!(changed(|j| j.blisk.options.channel = 3), [Channel, Electrode, Plan, Verify, Export]);
        assert_eq!(changed(|j| j.electrode.radial_reduction_mm = 0.7), [Electrode, Plan, Verify, Export]);
        assert_eq!(changed(|j| j.genetic.seed = 9), [Plan, Verify, Export]);
        assert_eq!(changed(|j| j.export.post = "other".into()), [Export]);
        assert_eq!(changed(|j| j.technology.id = "other".into()), [Export], "a path does not depend on how it burns");
        assert_eq!(changed(|j| j.burning.last_step = "S1".into()), [Export]);
        assert_eq!(changed(|j| j.machine.body_clearance_mm += 1.0), [Plan, Verify, Export]);
        let staged = |last_step: &str| {
            let mut job = PlanJob::demonstration();
            job.electrode.stage = vec![StageParams { last_step: last_step.to_owned(), ..StageParams::default() }];
            job
        };
        let of = |stage, step| Fingerprint::of(stage, &staged(step), "m");
        assert_eq!(of(Verify, "R1"), of(Verify, "S1"), "nor on how a stage burns");
        assert_ne!(of(Export, "R1"), of(Export, "S1"));
        assert_eq!(changed(|j| j.setting.x_mm = 0.005), [Plan, Verify, Export]);
        // Bodies of a machine decide which sides of entry are left.
        assert_eq!(changed(|j| j.machine.name = "xyzc".into()), [Electrode, Plan, Verify, Export]);
        assert_eq!(
            changed(|j| j.export.channels = crate::workspaces::blisk::document::choice::Channels::All),
            [Plan, Verify, Export]
        );
        let job = PlanJob::demonstration();
        assert_ne!(Fingerprint::of(Stage::Part, &job, "a"), Fingerprint::of(Stage::Part, &job, "b"));
    }
}
