//! What a project keeps of a plan: the nodes that were found. The path through them is made and verified anew when the
//! project is opened, so that a file can never vouch for a path.

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use super::job_file::PlanJob;
use crate::blisk::electrode::EntrySide;
use crate::feed::search::Node;

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

impl KeptPlan {
    /// SHA-256 of everything that a plan depends on, in hexadecimal: the content of the meshes, not where they lie.
    pub fn inputs_of(job: &PlanJob, content: &str) -> String {
        let PlanJob { mut blisk, mut electrode, machine, plan, genetic, verify, export: _ } = job.clone();
        for mesh in [&mut blisk.mesh, &mut electrode.mesh] {
            *mesh = mesh.take().map(|_| "mesh".into());
        }
        let mut hash = Sha256::new();
        hash.update(content);
        let parameters = (blisk, electrode, machine, plan, genetic, verify);
        hash.update(serde_json::to_vec(&parameters).unwrap_or_default());
        hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect()
    }
}
