//! What comes after the feed: the copying motions, the whole motion on the machine, and what stock is left by all
//! electrodes together.

use std::sync::Arc;

use glam::{DMat3, DVec2, DVec3};

use super::outcome::{Clock, ElectrodeOutcome, Finishing, PlanInputs, PlanJobError, PlanOutcome, Stock};
use super::simulate::{Around, simulate};
use feed::copying::{Copying, CopyingExtent, CopyingSettings, copying_motion};
use feed::path::FeedPath;
use feed::pose::Pose;
use feed::residual_stock::{Blank, Burn, ResidualStock, ResidualStockError, Site, residual_stock};
use feed::verify::Verifier;
use feed::verify::setting::{SettingErrors, SettingRoom};
use geometry::frame::Cylindrical;
use geometry::mesh::Mesh;
use task::{Cancelled, Task};
use wheel::channel::{Channel, Flow};
use wheel::electrode::{Electrode, Junctions};
use wheel::surface_finder::SurfaceFinder;

/// Works out how the electrodes of `outcome` finish the channel, as far as that is not known: their copying motions,
/// the whole motion on the machine, with which the plan can be approved, and then what stock they leave. `blisk` is
/// that of `inputs` in W.
///
/// # Errors
/// If a copying motion cannot be judged, or when told to stop; what is whole by then is known from then on.
pub fn finish<'a>(
    outcome: &'a PlanOutcome,
    inputs: &PlanInputs,
    blisk: &Mesh,
    task: &Task,
) -> Result<&'a Stock, PlanJobError> {
    let around = Around::of(outcome, inputs, blisk)?;
    let motions = match outcome.finishing() {
        Some(known) => known,
        None => {
            let motions = around.motions(outcome, task)?;
            if motions.stopped.is_some() {
                return Err(Cancelled.into());
            }
            outcome.finished_by(motions)
        }
    };
    if motions.stopped.is_some() {
        // What was stopped stays so: an outcome is finished once.
        return Err(Cancelled.into());
    }
    match outcome.stock() {
        Some(known) => Ok(known),
        None => {
            let stock = around.stock(outcome, motions, task);
            if stock.is_stopped { Err(Cancelled.into()) } else { Ok(outcome.leaving(stock)) }
        }
    }
}

/// Finishes a plan as [`finish`] does, but keeps what is known when the task is cancelled after the copying motions:
/// [`PlanOutcome::stopped`].
///
/// # Errors
/// Every error of [`finish`]; also when told to stop before.
pub fn finish_as_far_as_possible(
    outcome: &PlanOutcome,
    inputs: &PlanInputs,
    blisk: &Mesh,
    task: &Task,
) -> Result<(), PlanJobError> {
    let around = Around::of(outcome, inputs, blisk)?;
    let motions = match outcome.finishing() {
        Some(known) => known,
        None => outcome.finished_by(around.motions(outcome, task)?),
    };
    if outcome.stock().is_none() {
        outcome.leaving(around.stock(outcome, motions, task));
    }
    Ok(())
}

impl<'a> Around<'a> {
    fn of(outcome: &'a PlanOutcome, inputs: &'a PlanInputs, blisk: &'a Mesh) -> Result<Self, PlanJobError> {
        let channel = &outcome.channel;
        let finder = SurfaceFinder::new(channel.clone())?;
        let is_own = !inputs.own_electrodes.is_empty();
        let junctions =
            if is_own { Junctions::default() } else { Junctions::of(channel, &inputs.job.electrode.of_last_stage())? };
        let blank = inputs.blank.as_ref().map(|mesh| mesh.in_frame(&channel.frame));
        Ok(Self { job: &inputs.job, blisk, channel, finder, junctions, blank })
    }

    /// Copying motions, and the whole motion on the machine; nothing if not every path is certified.
    fn motions(&self, outcome: &PlanOutcome, task: &Task) -> Result<Finishing, PlanJobError> {
        let mut finishing = Finishing {
            copying: Vec::new(),
            setting: Vec::new(),
            simulations: Vec::new(),
            stopped: None,
            times: Vec::new(),
        };
        if !outcome.is_verified() {
            return Ok(finishing);
        }
        let mut clock = Clock::default();
        let electrodes = &outcome.electrodes;
        let motion = |e| clock.time("copying motion", || copying(self, e, task));
        finishing.copying = electrodes.iter().enumerate().map(motion).collect::<Result<Vec<_>, _>>()?;
        let setting = |e| clock.time("setting errors", || setting_room(self, e, task));
        let errors = self.job.setting.errors();
        let rooms =
            errors.into_iter().flat_map(|errors| electrodes.iter().enumerate().map(move |e| (e, errors))).map(setting);
        match rooms.collect::<Result<Vec<_>, _>>() {
            Ok(rooms) => finishing.setting = rooms,
            Err(PlanJobError::Cancelled(_)) => {
                finishing.stopped = Some("search for the setting errors that the path bears");
                finishing.times = clock.0;
                return Ok(finishing);
            }
            Err(other) => return Err(other),
        }
        let (motions, simulations) = (&finishing.copying, &mut finishing.simulations);
        match clock.time("simulation", || simulate(self, electrodes, motions, simulations, task)) {
            Ok(()) => {}
            Err(PlanJobError::Cancelled(_)) => finishing.stopped = Some("simulation of the whole motion"),
            Err(other) => return Err(other),
        }
        finishing.times = clock.0;
        Ok(finishing)
    }

    fn stock(&self, outcome: &PlanOutcome, motions: &Finishing, task: &Task) -> Stock {
        let unknown = |why: &str| Stock { left: Err(why.to_owned()), is_stopped: false, times: Vec::new() };
        if !outcome.is_verified() {
            return unknown("the residual stock needs a certified path of every electrode");
        }
        let mut clock = Clock::default();
        match clock.time("residual stock", || left_by(self, &outcome.electrodes, &motions.copying, task)) {
            Ok(left) => Stock { left: Ok(Arc::new(left)), is_stopped: false, times: clock.0 },
            Err(ResidualStockError::Cancelled(_)) => {
                Stock { is_stopped: true, ..unknown("the residual stock is not known: the computation was cancelled") }
            }
            // A plan is good without it.
            Err(other) => {
                Stock { times: clock.0, ..unknown(&format!("the residual stock cannot be computed: {other}")) }
            }
        }
    }
}

fn copying(
    around: &Around,
    (number, outcome): (usize, &ElectrodeOutcome),
    task: &Task,
) -> Result<Copying, PlanJobError> {
    let (job, electrode) = (&around.job.of_electrode(number).0, outcome.burning());
    let mut wanted = CopyingExtent::of(electrode, &job.electrode, outcome.plan.h);
    if let Some(wear_mm) = outcome.preset.map(|preset| preset.wear_mm()).filter(|wear| *wear > 0.0 && !wanted.is_none())
    {
        wanted = wanted.beyond(electrode, wear_mm);
    }
    let machine = &job.machine.seen_from_w(electrode.enters_from);
    let settings = CopyingSettings {
        machine,
        verify: &job.verify,
        spark_gap: job.electrode.spark_gap_mm,
        frame: around.channel.frame,
        outwards: outwards(electrode, around.channel),
    };
    task.report("copying motion", 0.0, "");
    let verifier = verifier(around, electrode, task)?.within(machine.pose_limits());
    let surface_of = |p: DVec3| around.finder.surface_of(p);
    Ok(copying_motion(electrode, &verifier, wanted, &settings, &surface_of, task)?)
}

/// The setting errors that the feed of `outcome` bears; `errors` are those asked about.
fn setting_room(
    around: &Around,
    ((number, outcome), errors): ((usize, &ElectrodeOutcome), SettingErrors),
    task: &Task,
) -> Result<Option<SettingRoom>, PlanJobError> {
    let Some(planned) = &outcome.plan.path else { return Ok(None) };
    let (job, _) = around.job.of_electrode(number);
    let least_mm = job.setting.least_mm(job.electrode.spark_gap_mm);
    let surface_of = |p: DVec3| around.finder.surface_of(p);
    let verifier = verifier(around, outcome.burning(), task)?;
    Ok(Some(verifier.setting_room(&planned.path, &errors, least_mm, &surface_of, task)?))
}

fn verifier(around: &Around, electrode: &Electrode, task: &Task) -> Result<Verifier, PlanJobError> {
    Ok(Verifier::new(around.blisk, &electrode.mesh, electrode.reference_point, &task.cancel)?)
}

/// Direction from the hub to the shroud in the middle of what `electrode` burns; along Z in an axial channel.
fn outwards(electrode: &Electrode, channel: &Channel) -> DVec3 {
    if channel.flow == Flow::Axial {
        return DVec3::Z;
    }
    let Cylindrical { x, r, theta } = Cylindrical::from_point(electrode.middle());
    let [along, _] = channel.along_and_height(DVec2::new(x, r));
    let DVec2 { x, y } = channel.line_at(along).up;
    DMat3::from_rotation_x(theta) * DVec3::new(x, 0.0, y)
}

fn left_by(
    around: &Around,
    electrodes: &[ElectrodeOutcome],
    motions: &[Copying],
    task: &Task,
) -> Result<ResidualStock, ResidualStockError> {
    let params = &around.job.electrode;
    let poses = |path: &FeedPath| -> Vec<Pose> { path.rows.iter().map(|row| row.pose).collect() };
    let burns: Vec<Burn> = electrodes
        .iter()
        .zip(motions)
        .enumerate()
        .map(|(number, (e, copying))| Burn {
            electrode: e.burning(),
            spark_gap: params.burned_gap_mm(number),
            feed: e.plan.path.as_ref().map(|p| poses(&p.path)).unwrap_or_default(),
            // What is not certified is not exported either, and burns nothing.
            copying: copying.certified().map(|c| poses(&c.path)).unwrap_or_default(),
        })
        .collect();
    let feeds = electrodes.iter().map(|e| e.plan.path.as_ref().map(|p| p.certificate.certified())).enumerate();
    let copied = motions.iter().map(|motion| motion.certified().map(|c| c.certificate.certified())).enumerate();
    let beyond_gap = |(number, certified): (usize, Option<f64>)| Some(certified? - params.burned_gap_mm(number));
    let site = Site {
        blisk: around.blisk,
        channel: around.channel,
        finder: &around.finder,
        spark_gap: params.of_last_stage().spark_gap_mm,
        junctions: around.junctions.clone(),
        proven: feeds.chain(copied).filter_map(beyond_gap).min_by(f64::total_cmp),
        blank: match (&around.blank, around.job.burning.allowance_mm) {
            (Some(blank), _) => Blank::Solid(blank),
            (None, Some(mm)) => Blank::Allowance(mm),
            (None, None) => Blank::Full,
        },
    };
    residual_stock(&site, &burns, task)
}
