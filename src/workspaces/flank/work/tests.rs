use task::{Lane, Scheduler};

use super::*;
use crate::workspaces::flank::document::PathChoice;
use files::Params;
use flank::ruled_surface::Side;

/// Two guides in files of their own in this folder, `bend` apart from straight in the middle.
fn guides(folder: &Path, bend: f64) -> FlankSource {
    std::fs::create_dir_all(folder).unwrap();
    let files = [("lower.csv", 0.0), ("upper.csv", 10.0)].map(|(file, z)| {
        let (file, text) = (folder.join(file), format!("0,0,{z}\n10,{bend},{z}\n20,0,{z}\n"));
        std::fs::write(&file, text).unwrap();
        file
    });
    FlankSource::guides(files)
}

fn document(source: FlankSource) -> FlankDocument {
    let mut document =
        FlankDocument { source, side: Side::Positive, path: PathChoice::Initial, ..FlankDocument::default() };
    (document.plan.grid, document.plan.rounds) = ([20, 8], 0);
    document
}

/// Does all that is to be done for `document`. Returns how many pieces of work there were, and what has happened.
fn settle(scheduler: &Scheduler, work: &mut FlankWork, document: &FlankDocument) -> (usize, Vec<WorkEvent>) {
    let (mut count, mut events) = (0, work.follow(document, Priority::Shown));
    while scheduler.run_next(Lane::Long) {
        count += 1;
        events.extend(work.follow(document, Priority::Shown));
    }
    (count, events)
}

#[test]
fn what_was_planned_of_a_file_is_not_taken_for_another_of_the_same_name() {
    let folder = tempfile::tempdir().unwrap();
    let document = document(guides(&folder.path().join("a"), 1.0));
    let scheduler = Scheduler::manual(|| ());
    let mut work = FlankWork::new(&scheduler);
    // The files are asked for first, the plan waits for them.
    work.follow(&document, Priority::Shown);
    work.plan(&document).unwrap();
    assert_eq!(work.state(&document), State::Running);
    let (count, events) = settle(&scheduler, &mut work, &document);
    assert!(count == 2 && work.is_planned_of(&document) && !work.is_busy(), "{events:?}");
    let turned = FlankDocument { side: Side::Negative, ..document.clone() };
    assert!(work.is_planned_of_surface(&turned) && !work.is_planned_of(&turned), "the surface is the same");
    let other = FlankDocument { source: guides(&folder.path().join("b"), 3.0), ..document.clone() };
    assert_eq!(other.name(), document.name());
    assert!(!work.is_planned_of_surface(&other));
}

#[test]
fn a_plan_is_there_again_when_its_parameters_are_but_not_of_a_file_that_was_written_since() {
    let folder = tempfile::tempdir().unwrap();
    let (a, b) = (folder.path().join("a"), folder.path().join("b"));
    let (first, other) = (document(guides(&a, 1.0)), document(guides(&b, 3.0)));
    let scheduler = Scheduler::manual(|| ());
    let mut work = FlankWork::new(&scheduler);
    let planned = |work: &mut FlankWork, document: &FlankDocument| {
        settle(&scheduler, work, document);
        work.plan(document).unwrap();
        settle(&scheduler, work, document);
        work.planned().unwrap().clone()
    };
    let plan = planned(&mut work, &first);
    let mut wider = first.clone();
    wider.cutter.radius_mm += 0.5;
    assert!(!Arc::ptr_eq(&planned(&mut work, &wider), &plan));
    // Undo: nothing is worked on.
    assert_eq!((settle(&scheduler, &mut work, &first).0, work.state(&first)), (0, State::Ready));
    assert!(work.is_planned_of(&first) && Arc::ptr_eq(work.planned().unwrap(), &plan));
    // Back from another surface the files are read again, which still hold what they held.
    planned(&mut work, &other);
    assert_eq!((settle(&scheduler, &mut work, &first).0, work.state(&first)), (1, State::Ready));
    settle(&scheduler, &mut work, &other);
    guides(&a, 1.25);
    assert_eq!((settle(&scheduler, &mut work, &first).0, work.state(&first)), (1, State::Stale));
    assert!(!work.is_planned_of(&first));
}

#[test]
fn what_is_cancelled_or_fails_is_said_and_not_begun_again() {
    let folder = tempfile::tempdir().unwrap();
    let document = document(guides(&folder.path().join("a"), 1.0));
    let scheduler = Scheduler::manual(|| ());
    let mut work = FlankWork::new(&scheduler);
    settle(&scheduler, &mut work, &document);
    work.plan(&document).unwrap();
    assert!(work.is_busy() && work.doing().is_some_and(|doing| doing.what == "Flank"));
    work.cancel();
    let (count, events) = settle(&scheduler, &mut work, &document);
    assert_eq!((count, work.state(&document), work.is_busy()), (0, State::Cancelled, false));
    let cancelled = WorkEvent { kind: EventKind::Cancelled, text: "Flank: cancelled".to_owned(), took: None };
    assert_eq!(events, [cancelled]);
    // A plan that is asked for is made all the same.
    work.plan(&document).unwrap();
    settle(&scheduler, &mut work, &document);
    assert_eq!(work.state(&document), State::Ready);
    let gone = FlankDocument { source: FlankSource::guides(["x.csv", "y.csv"].map(PathBuf::from)), ..document };
    let (count, events) = settle(&scheduler, &mut work, &gone);
    assert!(count == 1 && events[0].kind == EventKind::Failed && events[0].text.contains("x.csv"), "{events:?}");
    assert_eq!(settle(&scheduler, &mut work, &gone), (0, Vec::new()));
    let why = work.plan(&gone).unwrap_err();
    assert_eq!(work.source_state(&gone).why_not(), Some(why.as_str()));
}
