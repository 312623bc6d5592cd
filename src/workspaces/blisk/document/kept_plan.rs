//! The part of a plan that a project keeps: the nodes, as JSON in one text. The path through them is made and verified
//! anew when the project is opened, so that a file never proves a path.

use std::path::PathBuf;

use serde::{Deserialize, Serialize};

use super::Document;
use super::job_file::{BladesFrom, PlanJob};
use feed::genetic::ReductionMode;
use feed::objective::ObjectiveValue;
use feed::pose::{Axis, Pose};
use feed::problem::Node;
use files::Params as _;
use wheel::electrode::EntrySide;

/// The nodes of a plan, with the digest of its inputs.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct KeptPlan {
    /// Digest of the inputs of the plan; see [`inputs_of`](Self::inputs_of).
    pub inputs: String,
    /// The electrodes in the order of their parts.
    pub electrodes: Vec<KeptElectrode>,
}

/// The nodes of one electrode.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct KeptElectrode {
    /// Side from which the electrode enters.
    pub side: EntrySide,
    /// Additional circumferential reduction of the electrode (rad).
    pub h: f64,
    /// Nodes from the final pose outwards.
    #[serde(with = "rows")]
    pub nodes: Vec<Node>,
}

/// Nodes as rows of numbers.
mod rows {
    use serde::{Deserializer, Serializer};

    use super::{Deserialize, Node, ObjectiveValue, Pose};

    pub fn serialize<S: Serializer>(nodes: &[Node], serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_seq(nodes.iter().map(|node| {
            let (Node { s, h, clearance, .. }, [x, y, z, a, b, c]) = (*node, node.pose.to_array());
            let ObjectiveValue { smoothness, centring, total } = node.objective;
            [s, x, y, z, a, b, c, h, clearance, smoothness, centring, total]
        }))
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Vec<Node>, D::Error> {
        let node = |[s, x, y, z, a, b, c, h, clearance, smoothness, centring, total]: [f64; 12]| Node {
            s,
            pose: Pose { x, y, z, a, b, c },
            h,
            clearance,
            objective: ObjectiveValue { smoothness, centring, total },
        };
        Ok(Vec::deserialize(deserializer)?.into_iter().map(node).collect())
    }
}

/// A plan kept for comparison, with its parameters.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct KeptRun {
    /// Number of the plan, counted from 1.
    pub number: usize,
    /// Number of the run's colour among those of the window.
    pub colour: usize,
    /// Parameters of the plan. Of files only the names are kept; the plan holds what was read from them.
    pub job: PlanJob,
    /// Nodes of the plan.
    pub plan: KeptPlan,
}

/// Reason why a kept plan is not used: this program would not make such a plan of the project.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("the plan kept in the project is not used, because {what}; plan anew")]
pub struct KeptPlanError {
    /// Reason.
    what: &'static str,
}

/// Name of the result for the plan of a document.
const PLAN: &str = "plan";
/// Name of the content for the runs of a document.
const RUNS: &str = "runs";

/// Checks that the plans in `document` can be read.
///
/// # Errors
/// One line naming what cannot be read.
pub fn check(document: &Document) -> Result<(), String> {
    let damaged = |what: &str, e: serde_json::Error| {
        format!("the project is damaged: {what} cannot be read ({e}); remove it from the file to open the rest")
    };
    let plan = document.result(PLAN).map(serde_json::from_str::<KeptPlan>).transpose();
    plan.map_err(|e| damaged("results.plan", e))?;
    let Some(text) = document.kept(RUNS) else { return Ok(()) };
    fits(text)?;
    let runs = serde_json::from_str::<Vec<KeptRun>>(text).map_err(|e| damaged("kept.runs", e))?;
    if runs.len() > KeptRun::MOST {
        let (kept, most) = (runs.len(), KeptRun::MOST);
        return Err(format!(
            "the project keeps {kept} plans to compare with, and at most {most} can be: remove the others from kept.runs \
             in the file"
        ));
    }
    Ok(())
}

/// Whether the runs in `text` are few enough to be kept.
fn fits(text: &str) -> Result<(), String> {
    let [size, most] = [text.len(), KeptRun::MOST_BYTES].map(|bytes| bytes as f64 / f64::from(1 << 20));
    if text.len() <= KeptRun::MOST_BYTES {
        return Ok(());
    }
    Err(format!(
        "the plans that are kept to compare with take {size:.1} MiB in the project, and at most {most} MiB can be kept: \
         remove some of them, or plan with a larger step"
    ))
}

impl KeptRun {
    /// Greatest number of runs that a document keeps.
    pub const MOST: usize = 6;
    /// Greatest size of all of them together (bytes).
    pub const MOST_BYTES: usize = 16 << 20;

    /// The plans that `document` keeps for comparison, in the order of keeping.
    pub fn all_of(document: &Document) -> Vec<Self> {
        document.kept(RUNS).and_then(|text| serde_json::from_str(text).ok()).unwrap_or_default()
    }

    /// Makes `document` keep these runs and no others. The change is unsaved work, because their parameters may be
    /// nowhere else.
    ///
    /// # Errors
    /// One line if they are too large to be kept; then nothing is changed.
    pub fn keep(runs: &[Self], document: &mut Document) -> Result<(), String> {
        let text = serde_json::to_string(runs).map_err(|e| e.to_string())?;
        fits(&text)?;
        document.keep(RUNS, Some(text).filter(|_| !runs.is_empty()));
        Ok(())
    }

    /// A run with the parameters `job`.
    pub fn new(number: usize, colour: usize, mut job: PlanJob, plan: KeptPlan) -> Self {
        job.change_paths(&mut |path| path.file_name().map(PathBuf::from).unwrap_or_default());
        Self { number, colour, job, plan }
    }
}

/// Longest accepted path (mm): the largest coordinate of the verifier.
const LONGEST: f64 = 1e4;
/// Tolerance of a distance (mm) or an angle (rad) that was written to a file and read again.
const ROUNDING: f64 = 1e-9;

/// The keys of a part that is read whole, as JSON.
const WHOLE_FILE: &str = r#""solids":[],"obstacles":[],"step_tolerance_mm":0.005,"#;

impl KeptPlan {
    /// The plan kept in `document`.
    pub fn of(document: &Document) -> Option<Self> {
        document.result(PLAN).and_then(|text| serde_json::from_str(text).ok())
    }

    /// Notes the plan for the project file of `document`. The note is not unsaved work, because the same search finds
    /// the plan again.
    pub fn note(&self, document: &mut Document) {
        document.note_result(PLAN, serde_json::to_string(self).ok());
    }

    /// Checks the conditions that every search fulfils, because a file may hold anything.
    ///
    /// # Errors
    /// [`KeptPlanError`] unless there is an electrode for every part of `job`, each from a side and with a reduction
    /// that the job allows, and its nodes withdraw it step by step from the final pose.
    pub fn check(&self, job: &PlanJob) -> Result<(), KeptPlanError> {
        let require = |holds: bool, what| if holds { Ok(()) } else { Err(KeptPlanError { what }) };
        let own = job.electrode.mesh.is_some();
        require(
            self.electrodes.len() == job.electrode.count(),
            "it has another number of electrodes than the project",
        )?;
        let h_max = match job.genetic.h {
            ReductionMode::Variable if !own => job.genetic.h_max_deg.to_radians() + ROUNDING,
            _ => 0.0,
        };
        for (number, KeptElectrode { side, h, nodes }) in self.electrodes.iter().enumerate() {
            require(
                job.electrode.of_electrode(number).enter.allows(*side),
                "an electrode enters from a side that the project does not allow",
            )?;
            require((0.0..=h_max).contains(h), "an electrode has another reduction than the project allows")?;
            let starts = nodes.first().is_some_and(|n| n.s == 0.0 && n.pose == Pose::FINAL);
            require(starts, "its nodes do not begin in the final pose")?;
            require(nodes.iter().all(|node| is_possible(node, *side)), "a node stands where no search puts one")?;
            require(nodes.windows(2).all(|w| w[0].s < w[1].s), "its nodes do not lead steadily outwards")?;
        }
        Ok(())
    }

    /// SHA-256 of everything that a plan depends on, in hexadecimal: of meshes the content, not the path.
    pub fn inputs_of(job: &PlanJob, content: &str) -> String {
        let PlanJob {
            mut blisk,
            mut electrode,
            machine,
            plan,
            genetic,
            verify,
            export: _,
            technology: _,
            burning: _,
            setting: _,
            setup: _,
            scan: _,
        } = job.clone();
        for mesh in [&mut blisk.mesh, &mut electrode.mesh] {
            *mesh = mesh.take().map(|_| "mesh".into());
        }
        electrode.more.iter_mut().for_each(|own| own.mesh = "mesh".into());
        electrode = electrode.searched();
        if let BladesFrom::Measured(blades) = &mut blisk.sections {
            blades.file = "sections".into();
        }
        // Bodies have no part in the search; what is taken up is simulated anew.
        let machine = machine.searched();
        let parameters = (blisk, electrode, machine, plan, genetic, verify);
        let parameters = serde_json::to_string(&parameters).unwrap_or_default();
        // What is read of a STEP file counts where it is not the whole: other plans are older than these keys.
        let parameters = parameters.replacen(WHOLE_FILE, "", 1);
        files::sha256(&[content, &parameters].concat().into_bytes())
    }
}

/// Whether every number of `node` is one that a search may have found.
fn is_possible(node: &Node, side: EntrySide) -> bool {
    let finite = node.pose.to_array().iter().chain([&node.h, &node.clearance]).all(|v| v.is_finite());
    // A withdrawal is a motion of one axis.
    let withdrawn = node.pose.get(Axis::of_withdrawal(side)) * side.sign();
    finite && (0.0..=LONGEST).contains(&node.s) && (withdrawn - node.s).abs() <= ROUNDING
}
