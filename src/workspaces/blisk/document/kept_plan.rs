//! What a project keeps of a plan: the nodes that were found. The path through them is made and verified anew when the
//! project is opened, so that a file can never vouch for a path.

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use super::job_file::PlanJob;
use feed::genetic::ReductionMode;
use feed::pose::Pose;
use feed::problem::Node;
use wheel::electrode::EntrySide;

/// The nodes of a plan and what they belong to.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct KeptPlan {
    /// What the plan was made from; see [`inputs_of`](Self::inputs_of).
    pub inputs: String,
    /// The electrodes in the order of their parts.
    pub electrodes: Vec<KeptElectrode>,
}

/// The nodes of one electrode.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct KeptElectrode {
    /// The side it enters from.
    pub side: EntrySide,
    /// Additional circumferential reduction that it was made with (rad).
    pub h: f64,
    /// Nodes from the final pose outwards.
    pub nodes: Vec<Node>,
}

/// A plan that is kept to compare with, and what it was made with.
#[derive(Debug, Clone, PartialEq)]
pub struct KeptRun {
    /// Its number, counted from 1.
    pub number: usize,
    /// Which of the window's colours it has.
    pub colour: usize,
    /// Its parameters.
    pub job: PlanJob,
    /// Its nodes.
    pub plan: KeptPlan,
}

/// Why a kept plan is not taken up: it is none that this program makes of the job.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("the plan kept in the project is not used, because {what}; plan anew")]
pub struct KeptPlanError {
    /// What is wrong with it.
    what: &'static str,
}

/// Longest way that is taken up (mm): the largest coordinate that the verifier takes.
const LONGEST: f64 = 1e4;
/// Rounding of a distance (mm) or an angle (rad) that was written to a file and read again.
const ROUNDING: f64 = 1e-9;

impl KeptPlan {
    /// Checks what a search always keeps to, since a file may say anything.
    ///
    /// # Errors
    /// [`KeptPlanError`] unless there is an electrode for every part of `job`, each from a side and with a reduction
    /// that the job allows, and its nodes withdraw it step by step from the final pose.
    pub fn check(&self, job: &PlanJob) -> Result<(), KeptPlanError> {
        let require = |holds: bool, what| if holds { Ok(()) } else { Err(KeptPlanError { what }) };
        let own = job.electrode.mesh.is_some();
        let parts = if own { 1 } else { job.electrode.count() };
        require(self.electrodes.len() == parts, "it has another number of electrodes than the job")?;
        let h_max = match job.genetic.h {
            ReductionMode::Variable if !own => job.genetic.h_max_deg.to_radians() + ROUNDING,
            _ => 0.0,
        };
        let sides = job.electrode.enter.candidates();
        for KeptElectrode { side, h, nodes } in &self.electrodes {
            require(sides.contains(side), "an electrode enters from a side that the job does not allow")?;
            require((0.0..=h_max).contains(h), "an electrode has another reduction than the job allows")?;
            let starts = nodes.first().is_some_and(|n| n.s == 0.0 && n.pose == Pose::FINAL);
            require(starts, "its nodes do not begin in the final pose")?;
            require(nodes.iter().all(is_possible), "a node stands where no search puts one")?;
            require(nodes.windows(2).all(|w| w[0].s < w[1].s), "its nodes do not lead steadily outwards")?;
        }
        Ok(())
    }

    /// SHA-256 of everything that a plan depends on, in hexadecimal: the content of the meshes, not where they lie.
    pub fn inputs_of(job: &PlanJob, content: &str) -> String {
        let PlanJob { mut blisk, mut electrode, machine, plan, genetic, verify, export: _ } = job.clone();
        for mesh in [&mut blisk.mesh, &mut electrode.mesh] {
            *mesh = mesh.take().map(|_| "mesh".into());
        }
        let mut hash = Sha256::new();
        hash.update(content);
        // Bodies have no part in the search; what is taken up is simulated anew.
        let machine = machine.searched();
        let parameters = (blisk, electrode, machine, plan, genetic, verify);
        hash.update(serde_json::to_vec(&parameters).unwrap_or_default());
        hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect()
    }
}

/// Whether every number of `node` is one that a search may have found.
fn is_possible(node: &Node) -> bool {
    let finite = node.pose.to_array().iter().chain([&node.h, &node.clearance]).all(|v| v.is_finite());
    // A withdrawal is a motion of the X axis.
    finite && (0.0..=LONGEST).contains(&node.s) && (node.pose.x.abs() - node.s).abs() <= ROUNDING
}
