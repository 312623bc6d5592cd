//! Stages of a channel: each has electrodes of its own, certified at its own distance.

use sparkpath::workspaces::blisk::document::kept_plan::KeptPlan;
use sparkpath::workspaces::blisk::job::plan::{kept, replay};
use wheel::electrode::StageParams;

use super::*;

fn staged() -> PlanJob {
    let stage = |name: &str, spark_gap_mm, stock_mm, low_reduction_deg| StageParams {
        name: name.to_owned(),
        spark_gap_mm,
        stock_mm,
        low_reduction_deg,
        ..StageParams::default()
    };
    let mut job = easy_job();
    job.plan.strategy = Strategy::Global;
    let reduction = job.electrode.circumferential_reduction_deg[0];
    job.electrode.stage = vec![stage("rough", 0.2, 0.1, Some(reduction + 0.5)), stage("finish", 0.08, 0.0, None)];
    job
}

#[test]
fn every_stage_is_certified_at_its_own_distance_and_taken_up_again() {
    let inputs = easy_inputs(staged());
    let outcome = run_feeds(ready(), &inputs, &Task::default()).unwrap();
    assert!(outcome.is_verified());
    let labels: Vec<String> = outcome.electrodes.iter().enumerate().map(|(i, e)| e.electrode.label(i)).collect();
    assert_eq!(labels, ["1 (rough)", "2 (finish)"]);
    let certificates = outcome.electrodes.iter().map(|e| &e.plan.path.as_ref().unwrap().certificate);
    for (certificate, distance) in certificates.zip([0.3, 0.08]) {
        assert_eq!(certificate.required(), distance);
        assert!(certificate.certified() > distance - 0.002, "{}", certificate.certified());
    }
    let [rough, finish] = [0, 1].map(|i| &outcome.electrodes[i].electrode);
    for (electrode, distance) in [(rough, 0.3), (finish, 0.08)] {
        assert!((electrode.clearance_mm - distance).abs() < 2e-3, "{}", electrode.clearance_mm);
    }
    assert!(rough.least_thickness_mm < finish.least_thickness_mm - 0.3);
    let kept = KeptPlan { inputs: String::new(), electrodes: kept(&outcome).unwrap() };
    let (channel, exact) = (&outcome.channel, ExactMesh::new(ready().blisk()).unwrap());
    let again = replay(&inputs, channel, ready().blisk(), &exact, &kept, &Task::default()).unwrap();
    let paths = |outcome: &PlanOutcome| -> Vec<String> {
        outcome.electrodes.iter().map(|e| e.plan.path.as_ref().unwrap().path.digest()).collect()
    };
    assert_eq!(paths(&again), paths(&outcome));
}

#[test]
fn a_job_with_stages_burns_each_with_its_own_technology() {
    let mut job = staged();
    job.electrode.stage[0].last_step = "R1".to_owned();
    job.electrode.stage[1].finish_vdi = Some(24.0);
    let ends = [0, 1].map(|number| job.of_electrode(number).0.burning.until());
    assert_eq!(ends, [Some(burning::choice::Until::Step("R1".to_owned())), Some(burning::choice::Until::Vdi(24.0))]);
    assert_eq!([0, 1].map(|number| job.electrode.burned_gap_mm(number)), [0.2, 0.08]);
    ::files::Validate::validate(&job).unwrap();
    job.verify.tolerance_mm = 0.05;
    let said = ::files::Validate::validate(&job).unwrap_err().to_string();
    assert!(said.contains("verify.tolerance_mm") && said.contains("0.08"), "{said}");
}
