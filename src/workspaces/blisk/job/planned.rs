//! The plan as the window makes and shows it: while it is searched, as it came out, and how its electrodes finish the
//! channel.

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use super::finish::finish;
use super::outcome::Finishing;
use super::outcome::{PlanInputs, PlanJobError, PlanOutcome};
use super::plan::{replay, run_prepared};
use super::prepared_blisk::PreparedBlisk;
use super::preset::{read_presets, with_presets};
use super::simulate;
use super::stages::{FoundChannel, Part};
use crate::workspaces::blisk::document::job_file::PlanJob;
use crate::workspaces::blisk::document::job_file::field_table::FIELDS;
use crate::workspaces::blisk::document::kept_plan::KeptPlan;
use crate::workspaces::blisk::scene::residual_stock::MapShape;
use crate::workspaces::news::EventKind;
use feed::problem::{Convergence, Node};
use feed::simulation::Simulation;
use geometry::mesh::Mesh;
use render::mesh::RenderMesh;
use task::Task;
use wheel::electrode::Electrode;

/// What a plan has found so far.
#[derive(Clone)]
pub struct PartialPlan {
    /// The electrode that a way is searched for.
    pub electrode: Arc<Electrode>,
    /// Shape of the electrode for the screen.
    pub shape: Arc<RenderMesh>,
    /// Nodes from the final pose outwards.
    pub nodes: Vec<Node>,
    /// How each node's search converged.
    pub convergence: Vec<Convergence>,
}

/// A plan with its electrodes for the screen.
pub struct Planned {
    /// Inputs of the plan.
    pub inputs: PlanInputs,
    /// What the meshes held that it was made from: [`Part::content`].
    pub content: String,
    /// The plan.
    pub outcome: Arc<PlanOutcome>,
    /// Shapes of the electrodes for the screen.
    pub shapes: Vec<Arc<RenderMesh>>,
}

/// The inputs of a plan of `job` on `part`.
pub fn inputs_of(part: &Part, job: &PlanJob) -> PlanInputs {
    PlanInputs {
        blisk: part.mesh.clone(),
        obstacles: part.obstacles.clone(),
        own_electrodes: part.own_electrodes.clone(),
        sections: part.sections.clone(),
        blank: part.blank.clone(),
        job: job.clone(),
    }
}

impl Planned {
    /// Plans; `found` is told what is found on the way.
    ///
    /// # Errors
    /// One line for the user.
    pub fn search(
        ready: &PreparedBlisk,
        (part, job): (&Part, &PlanJob),
        found: &(dyn Fn(PartialPlan) + Sync),
        task: &Task,
    ) -> Result<Self, String> {
        let text = |e: PlanJobError| FIELDS.labelled(&e);
        simulate::check_machine(job, task).map_err(text)?;
        simulate::check_channels(job, &ready.space.channel).map_err(text)?;
        // The shape of the electrode that is worked on is made once for each.
        let last: Mutex<Option<(Arc<Electrode>, Arc<RenderMesh>)>> = Mutex::default();
        let observe = |electrode: &Arc<Electrode>, nodes: &[Node], convergence: &[Convergence]| {
            let mut last = last.lock().unwrap_or_else(PoisonError::into_inner);
            let known = last.take().filter(|(of, _)| Arc::ptr_eq(of, electrode));
            let made = || (electrode.clone(), Arc::new(RenderMesh::new(&electrode.mesh)));
            let (electrode, shape) = last.insert(known.unwrap_or_else(made)).clone();
            found(PartialPlan { electrode, shape, nodes: nodes.to_vec(), convergence: convergence.to_vec() });
        };
        let inputs = inputs_of(part, job);
        let outcome = run_prepared(ready, &inputs, &observe, task).map_err(text)?;
        Ok(Self::new(inputs, part, outcome))
    }

    /// Takes up the plan that was kept in a project.
    ///
    /// # Errors
    /// One line for the user.
    pub fn replay(
        kept: &KeptPlan,
        (part, channel, job): (&Part, &FoundChannel, &PlanJob),
        task: &Task,
    ) -> Result<Self, String> {
        let (inputs, FoundChannel { channel, blisk, exact, .. }) = (inputs_of(part, job), channel);
        let outcome = replay(&inputs, channel, blisk, exact, kept, task).map_err(|e| FIELDS.labelled(&e))?;
        Ok(Self::new(inputs, part, outcome))
    }

    /// The plan for electrodes that stand on their holders, and are worn, as the table `presets` says. `blisk` is that of the
    /// plan, in W.
    ///
    /// # Errors
    /// One line for the user.
    pub fn as_measured(&self, presets: &str, blisk: &Mesh, task: &Task) -> Result<Self, String> {
        let presets = read_presets(Path::new(presets)).map_err(|error| error.to_string())?;
        let outcome = with_presets((*self.outcome).clone(), &self.inputs, blisk, &presets, task);
        let outcome = outcome.map_err(|error| FIELDS.labelled(&error))?;
        let shapes = outcome.electrodes.iter().map(|e| Arc::new(RenderMesh::new(&e.burning().mesh))).collect();
        let (inputs, content) = (self.inputs.clone(), self.content.clone());
        Ok(Self { inputs, content, outcome: Arc::new(outcome), shapes })
    }

    fn new(inputs: PlanInputs, part: &Part, outcome: PlanOutcome) -> Self {
        let shapes = outcome.electrodes.iter().map(|e| Arc::new(RenderMesh::new(&e.electrode.mesh))).collect();
        Self { inputs, content: part.content(), outcome: Arc::new(outcome), shapes }
    }

    /// Whether every electrode comes out, certified or not.
    pub fn comes_out(&self) -> bool {
        self.outcome.electrodes.iter().all(|e| e.plan.path.is_some())
    }

    /// What came out, in a sentence.
    pub fn sentence(&self) -> (EventKind, String) {
        let plan = &self.outcome;
        let kind = if plan.may_be_approved() { EventKind::Done } else { EventKind::Refused };
        // The first electrode that is not verified is what stands in the way.
        let told = plan.electrodes.iter().enumerate().find(|(_, e)| !e.plan.is_verified());
        let (i, electrode) = match told.or_else(|| plan.electrodes.iter().enumerate().next()) {
            Some(found) => found,
            None => return (EventKind::Refused, "there is no electrode".to_owned()),
        };
        let name = if plan.electrodes.len() > 1 {
            format!("electrode {} ", electrode.electrode.label(i))
        } else {
            "the electrode ".to_owned()
        };
        let collision = plan.finishing().and_then(|f| f.collision());
        let collision = collision.map(|simulation| format!(". {}", simulation.sentence())).unwrap_or_default();
        (kind, name + &FIELDS.labelled(&electrode.plan.verdict(&plan.channel)) + &collision)
    }
}

/// How the electrodes of a plan finish the channel; the figures are in the plan itself.
pub struct Finished {
    /// What stock is left, or why that cannot be told; and what collides on the machine.
    said: Result<String, String>,
    /// The stock that is left, for the screen.
    pub residual_stock: Option<MapShape>,
}

impl Finished {
    /// Works it out; `blisk` is in W.
    ///
    /// # Errors
    /// One line for the user.
    pub fn of(planned: &Planned, blisk: &Mesh, task: &Task) -> Result<Self, String> {
        let Planned { inputs, outcome, .. } = planned;
        let left = &finish(outcome, inputs, blisk, task).map_err(|e| FIELDS.labelled(&e))?.left;
        let collision = outcome.finishing().and_then(Finishing::collision).map(Simulation::sentence);
        let said = left.as_ref().map(|left| left.sentence(&outcome.channel)).map_err(Clone::clone);
        Ok(Self {
            said: collision.map_or(said, Err),
            residual_stock: left.as_ref().ok().map(|left| MapShape::new(&left.map)),
        })
    }

    /// What came out, in a sentence.
    pub fn sentence(&self) -> (EventKind, String) {
        match &self.said {
            Ok(left) => (EventKind::Done, left.clone()),
            Err(why) => (EventKind::Refused, why.clone()),
        }
    }
}

/// The files of an export.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Exported {
    /// Folder of the files.
    pub folder: PathBuf,
    /// The names of the files.
    pub written: Vec<String>,
    /// Reason why there is no job sheet, if its template makes none.
    pub no_job_sheet: Option<String>,
}

impl Exported {
    /// What was written, in a sentence.
    pub fn sentence(&self) -> String {
        let no_sheet = self.no_job_sheet.iter().map(|why| format!("; no job sheet: {why}"));
        format!("{} files written to {}{}", self.written.len(), self.folder.display(), no_sheet.collect::<String>())
    }
}
