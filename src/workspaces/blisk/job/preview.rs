//! The quick look that follows while parameters are tuned.

use std::sync::Arc;
use std::time::{Duration, Instant};

use super::outcome::{PlanInputs, PlanJobError};
use super::plan::{settings_of, sides};
use super::prepared_blisk::PreparedBlisk;
use super::prepared_blisk::electrode_of;
use crate::workspaces::blisk::document::job_file::field_table::FIELDS;
use feed::global::PreviewPath;
use feed::plan::PlanSettings;
use feed::planner::{DrawnIn, preview_path};
use files::Validate as _;
use render::mesh::RenderMesh;
use task::Task;
use wheel::channel::Channel;
use wheel::electrode::{Electrode, EntrySide};

/// What a quick look found for one electrode.
#[derive(Debug, Clone)]
pub struct LiveWay {
    /// The side that it is withdrawn to.
    pub side: EntrySide,
    /// The way.
    pub way: PreviewPath,
    /// The electrode with the reductions of the job, if it is not made for the side that is tried first.
    pub other: Option<Arc<Electrode>>,
}

impl LiveWay {
    /// Result of the quick look, in one sentence.
    pub fn sentence(&self, channel: &Channel) -> String {
        let side = self.side.label();
        match (&self.way.margin, &self.way.jam) {
            (Some(margin), _) => format!("extraction path towards {side} probable, clearance margin {margin:.3} mm"),
            (None, Some(jam)) => format!("towards {side}: {}", jam.sentence(channel)),
            (None, None) => String::new(),
        }
    }
}

/// Looks for a way of the electrode number `part` along the passage with the parameters of the job: on the side that is tried
/// first, and where that fails on the other; of two that fail the one that gets further.
///
/// # Errors
/// If the electrode cannot be made, or when told to stop.
pub fn live_way(
    prepared: &PreparedBlisk,
    inputs: &PlanInputs,
    part: usize,
    task: &Task,
) -> Result<LiveWay, PlanJobError> {
    let job = &inputs.job;
    job.validate()?;
    let mut best: Option<LiveWay> = None;
    let sides = sides(job, &prepared.space.channel, part)?;
    for (i, &side) in sides.iter().enumerate() {
        let way = match preview_on(prepared, inputs, (part, side), task) {
            // A side for which no electrode can be made is left, unless it is the last hope.
            Err(PlanJobError::Electrode(_)) if i + 1 < sides.len() || best.is_some() => continue,
            way => way?,
        };
        let reach = |w: &PreviewPath| (w.margin.is_some(), w.nodes.last().map_or(0.0, |n| n.s));
        if best.as_ref().is_none_or(|b| reach(&b.way) < reach(&way)) {
            best = Some(LiveWay { side, way, other: None });
        }
        if best.as_ref().is_some_and(|b| b.way.margin.is_some()) {
            break;
        }
    }
    let mut best = best.ok_or_else(|| PlanJobError::Job("the electrode cannot be retracted to any side".to_owned()))?;
    if sides.first() != Some(&best.side) {
        let (channel, which) = (&prepared.space.channel, (part, best.side, 0.0));
        best.other = Some(Arc::new(electrode_of(inputs, channel, &prepared.exact, which, task)?));
    }
    Ok(best)
}

/// Preview of the extraction path of electrode number `number` along the passage to `side`.
///
/// # Errors
/// If the electrode cannot be made, or when told to stop.
pub(super) fn preview_on(
    prepared: &PreparedBlisk,
    inputs: &PlanInputs,
    (number, side): (usize, EntrySide),
    task: &Task,
) -> Result<PreviewPath, PlanJobError> {
    let (inputs, number) = &inputs.of_electrode(number);
    let (full, turns) = prepared.fullest(inputs, (*number, side), task)?;
    let drawn_in = DrawnIn { prepared: &full, turns, electrode: full.electrode() };
    let machine = &inputs.job.machine.seen_from_w(side);
    let settings = PlanSettings { machine, ..settings_of(&inputs.job, &|_, _| ()) };
    Ok(preview_path(&prepared.space, &drawn_in, &settings, task)?)
}

/// A quick look as it is shown.
pub struct Looked {
    /// Result of the quick look.
    pub found: LiveWay,
    /// The shape of the [electrode](LiveWay::other) that it is the way of, where that is not the one that is tuned.
    pub shape: Option<Arc<RenderMesh>>,
    /// Result of the quick look, in one sentence.
    pub sentence: String,
    /// How long it took.
    pub took: Duration,
}

impl Looked {
    /// Looks for a way of the electrode number `part` along the passage.
    ///
    /// # Errors
    /// One line for the user.
    pub fn at(prepared: &PreparedBlisk, inputs: &PlanInputs, part: usize, task: &Task) -> Result<Self, String> {
        let began = Instant::now();
        let found = live_way(prepared, inputs, part, task).map_err(|e| FIELDS.labelled(&e))?;
        let took = began.elapsed();
        let shape = found.other.as_ref().map(|electrode| Arc::new(RenderMesh::new(&electrode.mesh)));
        Ok(Self { shape, sentence: found.sentence(&prepared.space.channel), found, took })
    }
}
