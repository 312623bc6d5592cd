//! A kept plan is taken up only if the job can have had it.

use feed::problem::Node;
use geometry::exact::ExactMesh;
use sparkpath::workspaces::blisk::document::job_file::PlanJob;
use sparkpath::workspaces::blisk::document::kept_plan::{KeptElectrode, KeptPlan};
use sparkpath::workspaces::blisk::job::outcome::{PlanInputs, PlanJobError, PlanOutcome};
use sparkpath::workspaces::blisk::job::plan::{kept, replay, run};
use task::Task;
use wheel::electrode::EntrySide;

use super::{easy_blisk, easy_job, easy_plan, mesh};

/// What the easy plan leaves in a project.
fn easy_kept() -> KeptPlan {
    KeptPlan { inputs: String::new(), electrodes: kept(easy_plan()).unwrap() }
}

fn taken_up(kept: &KeptPlan, job: PlanJob) -> Result<PlanOutcome, PlanJobError> {
    let inputs = PlanInputs::of(mesh(&easy_blisk()), job);
    let channel = &easy_plan().channel;
    let blisk = inputs.blisk.in_frame(&channel.frame);
    let exact = ExactMesh::new(&blisk).unwrap();
    replay(&inputs, channel, &blisk, &exact, kept, &Task::default())
}

pub fn the_plan_itself_is_taken_up_with_the_same_path() {
    let again = taken_up(&easy_kept(), easy_job()).unwrap();
    let path = |o: &PlanOutcome| o.electrodes[0].plan.path.as_ref().unwrap().path.digest();
    assert!(again.is_verified());
    assert_eq!(path(&again), path(easy_plan()));
}

pub fn a_kept_plan_that_no_search_makes_is_refused() {
    type Spoil = fn(&mut KeptElectrode);
    fn last(e: &mut KeptElectrode) -> &mut Node {
        e.nodes.last_mut().unwrap()
    }
    let spoils: [(&str, Spoil); 12] = [
        ("reduction", |e| e.h = 0.01),
        ("reduction", |e| e.h = -0.01),
        ("reduction", |e| e.h = f64::NAN),
        ("side", |e| e.side = EntrySide::PlusX),
        ("final pose", |e| e.nodes.clear()),
        ("final pose", |e| e.nodes[0].pose.c = 0.1),
        ("final pose", |e| e.nodes[0].s = -0.1),
        ("outwards", |e| e.nodes.swap(2, 3)),
        ("no search", |e| last(e).s = 1e12),
        ("no search", |e| {
            last(e).s = 1e12;
            last(e).pose.x = -1e12;
        }),
        ("no search", |e| last(e).pose.x -= 0.1),
        ("no search", |e| last(e).pose.b = f64::INFINITY),
    ];
    for (i, (why, spoil)) in spoils.into_iter().enumerate() {
        let mut plan = easy_kept();
        spoil(&mut plan.electrodes[0]);
        let error = taken_up(&plan, easy_job()).map(|o| o.is_verified()).unwrap_err();
        assert!(matches!(&error, PlanJobError::Kept(_)) && error.to_string().contains(why), "{i}: {error}");
    }
    let mut twice = easy_kept();
    twice.electrodes.push(twice.electrodes[0].clone());
    assert!(matches!(taken_up(&twice, easy_job()), Err(PlanJobError::Kept(_))));
}

pub fn a_job_that_cannot_be_planned_can_neither_be_taken_up() {
    let mut job = easy_job();
    job.verify.tolerance_mm = 0.999 * job.electrode.spark_gap_mm;
    let inputs = PlanInputs::of(mesh(&easy_blisk()), job.clone());
    let planned = run(&inputs, &Task::default());
    for answer in [planned, taken_up(&easy_kept(), job)] {
        let error = answer.map(|o| o.is_verified()).unwrap_err();
        assert!(matches!(&error, PlanJobError::Invalid(problem) if problem.key == "verify.tolerance_mm"), "{error}");
    }
}
