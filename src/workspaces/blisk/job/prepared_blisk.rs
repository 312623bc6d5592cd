//! A blisk made ready for planning: everything that does not change while electrodes and searches are tuned.

use std::sync::{Arc, Mutex, PoisonError};

use super::outcome::{Clock, PlanInputs, PlanJobError};
use feed::prepared::PlanningSpace;
use feed::prepared::PreparedElectrode;
use feed::probes::Turns;
use geometry::exact::ExactMesh;
use geometry::frame::Frame;
use geometry::mesh::Mesh;
use task::Task;
use wheel::channel::Channel;
use wheel::electrode::{
    Electrode, ElectrodeError, ElectrodeParams, EnterSide, EntrySide, Sizing, from_user_mesh, make_electrode, own_turns,
};

/// A blisk with everything prepared that does not change while electrodes and searches are tuned.
pub struct PreparedBlisk {
    /// The blisk prepared for exact distances, in W.
    pub(super) exact: Arc<ExactMesh>,
    /// The channel with its distance field.
    pub(super) space: PlanningSpace,
    /// Size of a cell of the field (mm).
    cell: f64,
    /// Times of the stages.
    pub(super) clock: Clock,
    /// Electrodes that were prepared to be drawn in, or why they cannot be made, the latest last.
    fullest: Mutex<Vec<(Fullest, MadeFullest)>>,
}

/// An electrode that was prepared, or why it cannot be made.
type MadeFullest = Result<Arc<PreparedElectrode>, ElectrodeError>;

/// What tells one electrode that is drawn in from another.
#[derive(Debug, Clone, PartialEq)]
struct Fullest {
    params: ElectrodeParams,
    part: usize,
    side: EntrySide,
    margin: f64,
    most: f64,
}

impl PreparedBlisk {
    /// Prepared electrodes that are kept.
    const KEPT: usize = 8;
    /// Walls of a prepared electrode can be drawn in by a multiple of this angle (deg).
    const DRAWN_IN_DEG: f64 = 12.0;
    /// By how much more than its job wants at least, for what a jam asks for (deg).
    const MORE_DEG: f64 = 6.0;

    /// Builds the distance field about `channel`; `blisk` and `exact` are in W.
    ///
    /// # Errors
    /// If the field gets too large, or when told to stop.
    pub fn new(
        blisk: Arc<Mesh>,
        exact: Arc<ExactMesh>,
        channel: Arc<Channel>,
        cell: f64,
        task: &Task,
    ) -> Result<Self, PlanJobError> {
        let mut clock = Clock::default();
        let build = || PlanningSpace::new(blisk, exact.clone(), channel, cell, task);
        let space = clock.time("distance field", build)?;
        Ok(Self { exact, space, cell, clock, fullest: Mutex::default() })
    }

    /// The blisk in W.
    pub fn blisk(&self) -> &Mesh {
        &self.space.blisk
    }

    /// Whether the blisk was prepared with this cell size (mm).
    pub fn has_cell(&self, cell: f64) -> bool {
        self.cell == cell
    }

    /// Electrode number `part` along the passage for a side without circumferential reductions, and the angles by which its walls
    /// have to be drawn in for those of the job; where none can be made so full, one with half of them or all. An electrode of
    /// one's own is what it is.
    ///
    /// # Errors
    /// If it cannot be made, or when told to stop.
    pub(super) fn fullest(
        &self,
        inputs: &PlanInputs,
        (part, side): (usize, EntrySide),
        task: &Task,
    ) -> Result<(Arc<PreparedElectrode>, Turns), PlanJobError> {
        let of_part = inputs.job.electrode.of_electrode(part);
        let reductions = of_part.circumferential_reduction_deg;
        let is_own = !inputs.own_electrodes.is_empty();
        let made_with = |share: f64| {
            let mut full = inputs.clone();
            full.job.electrode = of_part.clone();
            let mut drawn_in = [0.0; 2];
            if !is_own {
                full.job.electrode.circumferential_reduction_deg = reductions.map(|deg| share * deg);
                drawn_in = reductions.map(|deg| (1.0 - share) * deg);
            }
            self.drawn_in_to(&full, (part, side), drawn_in, task)
        };
        let made = made_with(0.0);
        if is_own || reductions == [0.0; 2] || !made.as_ref().is_err_and(is_mended_by_less) {
            return made;
        }
        made_with(0.5).or_else(|error| if is_mended_by_less(&error) { made_with(1.0) } else { Err(error) })
    }

    /// The electrode of `full`, and the angles by which its walls are drawn in further (deg).
    fn drawn_in_to(
        &self,
        full: &PlanInputs,
        (part, side): (usize, EntrySide),
        drawn_in: [f64; 2],
        task: &Task,
    ) -> Result<(Arc<PreparedElectrode>, Turns), PlanJobError> {
        let turns = |of: &PreparedElectrode| Turns(own_turns(of.electrode().column, drawn_in.map(f64::to_radians)));
        let most = drawn_in.into_iter().fold(0.0, f64::max) + Self::MORE_DEG;
        let most = (Self::DRAWN_IN_DEG * (most / Self::DRAWN_IN_DEG).ceil()).to_radians();
        let margin = full.job.plan.margin_mm;
        // Neither where it may enter from nor how its size was found changes it.
        let params = ElectrodeParams { enter: EnterSide::Auto, size: Sizing::Given, ..full.job.electrode.clone() };
        let wanted = Fullest { params, part, side, margin, most };
        let known = |kept: &[(Fullest, MadeFullest)]| {
            kept.iter().find(|(of, _)| *of == wanted).map(|(_, prepared)| prepared.clone())
        };
        let is_known = known(&self.fullest.lock().unwrap_or_else(PoisonError::into_inner));
        let prepared = match is_known {
            Some(made) => made?,
            None => {
                let made = electrode_of(full, &self.space.channel, &self.exact, (part, side, 0.0), task);
                let clearance = full.job.electrode.spark_gap_mm + margin;
                let prepared = match made {
                    Ok(made) => Ok(PreparedElectrode::new(&self.space, made.into(), clearance, most, task)?.into()),
                    Err(ElectrodeError::Cancelled(cancelled)) => return Err(cancelled.into()),
                    Err(error) => Err(error),
                };
                let mut kept = self.fullest.lock().unwrap_or_else(PoisonError::into_inner);
                if kept.len() == Self::KEPT {
                    drop(kept.remove(0));
                }
                kept.push((wanted, prepared.clone()));
                prepared?
            }
        };
        let turns = turns(&prepared);
        Ok((prepared, turns))
    }
}

/// Whether an electrode that is drawn in may be made where this one cannot.
pub(super) fn is_mended_by_less(error: &PlanJobError) -> bool {
    matches!(error, PlanJobError::Electrode(ElectrodeError::TooClose { .. } | ElectrodeError::ShankMeets { .. }))
}

/// The electrode number `part` along the passage for a side, with its walls drawn in by a further `h` (rad), its vertices as a
/// file will hold them.
pub(super) fn electrode_of(
    inputs: &PlanInputs,
    channel: &Channel,
    exact: &ExactMesh,
    (part, side, h): (usize, EntrySide, f64),
    task: &Task,
) -> Result<Electrode, ElectrodeError> {
    let params = &inputs.job.electrode;
    let mut electrode = match inputs.own_electrodes.get(part) {
        Some(own) => {
            let own = own.in_frame(&channel.frame);
            let made = from_user_mesh(own, channel, exact, params.spark_gap_mm, side, &task.cancel)?;
            Electrode { part, parts: inputs.electrodes(), ..made }
        }
        None => {
            let (_, in_stage) = params.in_stage(part);
            let mut of_part = params.of_electrode(part);
            of_part.circumferential_reduction_deg.iter_mut().for_each(|deg| *deg += h.to_degrees());
            let made = make_electrode(channel, exact, &of_part, (in_stage, side), task)?;
            Electrode { stage: params.stage_of(part).map(|stage| stage.name.clone()), ..made }
        }
    };
    electrode.mesh = as_written(&electrode.mesh, &channel.frame);
    Ok(electrode)
}

/// The mesh as its file will hold it: single precision in the coordinates of the loaded mesh. What is verified is
/// what is written.
fn as_written(mesh: &Mesh, frame: &Frame) -> Mesh {
    mesh.mapped(|p| frame.from_parent(frame.to_parent(p).as_vec3().as_dvec3()))
}
