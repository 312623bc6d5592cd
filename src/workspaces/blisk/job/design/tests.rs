//! Tests of sets: compared, told, and their kinds.

use super::*;
use wheel::electrode::StageParams;

fn row(minutes: Option<f64>, needed: usize, residual_mm: f64, breaks: &[&str]) -> DesignRow {
    let size = SizeRow {
        stage: None,
        parts: needed,
        enter: EnterSide::MinusX,
        reduction_deg: vec![[1.0, 1.5]],
        part: Vec::new(),
        least_thickness_mm: 2.0,
        volume_mm3: 100.0,
        certified_mm: 0.099,
        limit: None,
        raised_deg: 0.0,
    };
    DesignRow {
        stages: vec![StageSet { size, columns: 1, radial_reduction_mm: 0.5, plane: None }],
        least_thickness_mm: 2.0,
        certified_mm: 0.099,
        electrodes: needed,
        needed: Some(needed),
        is_wear_known: true,
        needed_text: Vec::new(),
        channel: None,
        wheel: minutes.map(Spread::exactly),
        no_minutes: None,
        residual_mm: Some(residual_mm),
        is_more_left: false,
        left_mm3: None,
        breaks: breaks.iter().map(|&word| word.to_owned()).collect(),
        is_best: false,
        electrode: ElectrodeParams::default(),
    }
}

#[test]
fn the_best_are_those_that_no_other_is_better_than() {
    let mut rows = vec![
        row(Some(600.0), 1, 0.5, &[]),
        row(Some(500.0), 2, 0.5, &[]),
        row(Some(650.0), 1, 0.5, &[]),
        row(Some(700.0), 3, 0.1, &[]),
        row(Some(100.0), 1, 0.9, &["residual stock"]),
        row(None, 1, 0.0, &[]),
        row(Some(600.0), 1, 0.5, &[]),
    ];
    mark_best(&mut rows);
    let best: Vec<bool> = rows.iter().map(|row| row.is_best).collect();
    assert_eq!(best, [true, true, false, true, false, false, true]);
    let design = Design { rows, left_out: Vec::new() };
    assert_eq!(design.fastest().unwrap().wheel, Some(Spread::exactly(500.0)));
    assert!(design.sentence().contains("7 certified sets, 6 of them within the limits"), "{}", design.sentence());
    let none = Design { rows: vec![row(Some(1.0), 1, 0.9, &["thickness"])], left_out: Vec::new() };
    assert!(none.fastest().is_none() && none.sentence() == "1 certified set, none of which keeps the limits.");
    let unknown = DesignRow { no_minutes: Some("no rate".to_owned()), ..row(None, 1, 0.1, &[]) };
    let said = Design { rows: vec![unknown], left_out: Vec::new() }.sentence();
    assert_eq!(said, "1 certified set, 1 of them within the limits; hours are not known: no rate.");
    assert!(Design::default().sentence().contains("No set"));
}

#[test]
fn figures_that_may_be_more_are_no_better_than_those_that_are_known() {
    let unworn = DesignRow { is_wear_known: false, ..row(Some(500.0), 1, 0.1, &[]) };
    let more = DesignRow { is_more_left: true, ..row(Some(10.0), 1, 0.0, &[]) };
    let mut rows = vec![row(Some(600.0), 8, 0.2, &[]), unworn.clone(), more];
    mark_best(&mut rows);
    assert_eq!(rows.iter().map(|row| row.is_best).collect::<Vec<_>>(), [true, true, false]);
    assert_eq!([unworn.hours_cell(), unworn.needed_cell(), unworn.residual_cell()], ["≥ 8.3", "≥ 1", "0.100"]);
    let said = Design { rows, left_out: Vec::new() }.sentence();
    assert!(said.contains("at least, because wear is not considered"), "{said}");
}

#[test]
fn every_kind_of_set_is_tried_once() {
    let space =
        DesignSpace { most_parts: 3, columns: true, radial_reductions_mm: vec![0.5, 0.2], planes: vec![0.4, 0.6] };
    let kinds = space.kinds();
    assert_eq!(kinds.len(), 2 * 2 * (1 + 3 + 1));
    let mut words: Vec<String> = kinds.iter().map(Kind::words).collect();
    words.sort();
    words.dedup();
    assert_eq!(words.len(), kinds.len());
    let applied = kinds.iter().find(|kind| kind.plane == Some(0.4)).unwrap().of(&PlanJob::demonstration(), 0);
    assert_eq!((applied.electrode.parts, applied.electrode.part[0].until), (2, Some(0.4)));
    applied.validate().unwrap();
    let mut job = PlanJob::demonstration();
    let stage = |name: &str, spark_gap_mm| StageParams { name: name.to_owned(), spark_gap_mm, ..Default::default() };
    job.electrode.stage = vec![stage("rough", 0.3), stage("finish", 0.1)];
    let kind = |parts, radial_reduction_mm| Kind { parts, columns: 1, radial_reduction_mm, plane: None };
    let staged = kind(2, None).of(&kind(1, Some(0.7)).of(&job, 0), 1);
    let [rough, finish] = [0, 1].map(|stage| staged.electrode.of_stage(stage));
    assert_eq!((rough.parts, rough.radial_reduction_mm), (1, 0.7));
    assert_eq!((finish.parts, finish.radial_reduction_mm), (2, job.electrode.radial_reduction_mm));
    staged.validate().unwrap();
}
