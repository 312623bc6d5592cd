//! Tests of rows of sizes: taken, and forgotten.

use super::*;
use wheel::electrode::StageParams;

fn row(stage: Option<&str>, parts: usize, reduction_deg: Vec<[f64; 2]>, until: Option<f64>) -> SizeRow {
    let part = until.into_iter().map(|until| PartParams { until: Some(until), ..PartParams::default() }).collect();
    SizeRow {
        stage: stage.map(str::to_owned),
        parts,
        enter: EnterSide::Auto,
        reduction_deg,
        part,
        least_thickness_mm: 2.0,
        volume_mm3: 100.0,
        certified_mm: 0.1,
        limit: None,
        raised_deg: 0.0,
    }
}

/// A job whose parts have a division and a reduction of their own, in two stages if wanted.
fn job(is_staged: bool) -> PlanJob {
    let mut job = PlanJob::demonstration();
    let own = PartParams { until: Some(0.4), low_reduction_deg: Some(3.0), ..PartParams::default() };
    (job.electrode.parts, job.electrode.part, job.electrode.enter) = (2, vec![own], EnterSide::PlusX);
    if is_staged {
        let stage =
            |name: &str, spark_gap_mm| StageParams { name: name.to_owned(), spark_gap_mm, ..Default::default() };
        job.electrode.stage = vec![stage("rough", 0.3), stage("finish", 0.1)];
    }
    job
}

/// The job has afterwards all that a row says, whichever row was taken before.
#[test]
fn a_row_that_is_taken_leaves_nothing_of_the_one_before() {
    for stage in [None, Some("finish")] {
        let one = row(stage, 1, vec![[1.0, 1.0]], None);
        let two = row(stage, 2, vec![[1.0, 2.0], [0.5, 0.25]], Some(0.4));
        let equal = row(stage, 2, vec![[1.5, 1.5]], Some(0.4));
        for taken in [&one, &two, &equal] {
            let mut direct = job(stage.is_some());
            taken.apply(&mut direct);
            direct.validate().unwrap();
            let last = direct.electrode.of_last_stage();
            assert_eq!((last.parts, last.enter), (taken.parts, EnterSide::Auto));
            for part in 0..taken.parts {
                let walls = taken.reduction_deg.get(part).unwrap_or(&taken.reduction_deg[0]);
                assert_eq!(last.of_part(part).circumferential_reduction_deg, *walls, "{taken:?}");
            }
            assert_eq!(last.part.first().and_then(|row| row.until), taken.part.first().and_then(|row| row.until));
            for before in [&one, &two, &equal] {
                let mut after = job(stage.is_some());
                before.apply(&mut after);
                assert!(before.is_applied(&after));
                taken.apply(&mut after);
                assert_eq!(after, direct, "{before:?} then {taken:?}");
            }
        }
    }
}

/// A table stays current while its rows are taken, and no longer once what they were found with is changed.
#[test]
fn what_is_forgotten_is_what_rows_set() {
    let forgotten = |job: &PlanJob| {
        let mut electrode = job.electrode.clone();
        SizeRow::forget(&mut electrode);
        electrode
    };
    for stage in [None, Some("rough")] {
        let mut plain = job(stage.is_some());
        // Divisions of single parts are kept only by rows of as many parts.
        plain.electrode.part.clear();
        let mut taken = plain.clone();
        row(stage, 3, vec![[1.0, 2.0], [0.5, 0.25], [0.1, 0.2]], None).apply(&mut taken);
        assert_eq!(forgotten(&taken), forgotten(&plain));
        taken.electrode.spark_gap_mm += 0.01;
        assert_ne!(forgotten(&taken), forgotten(&plain));
    }
    let mut entered = job(true);
    entered.electrode.enter = EnterSide::MinusX;
    assert_ne!(forgotten(&entered), forgotten(&job(true)), "stages without a side of their own enter from it");
}
