use super::*;
use crate::workspaces::flank::document::PathChoice;
use flank::ruled_surface::Side;

#[test]
fn what_was_planned_of_a_file_is_not_taken_for_another_of_the_same_name() {
    let folder = tempfile::tempdir().unwrap();
    let guides = |name: &str, bend: f64| {
        let here = folder.path().join(name);
        std::fs::create_dir(&here).unwrap();
        let files = [("lower.csv", 0.0), ("upper.csv", 10.0)].map(|(file, z)| {
            let (file, text) = (here.join(file), format!("0,0,{z}\n10,{bend},{z}\n20,0,{z}\n"));
            std::fs::write(&file, text).unwrap();
            file
        });
        FlankSource::guides(files)
    };
    let mut document = FlankDocument {
        source: guides("a", 1.0),
        side: Side::Positive,
        path: PathChoice::Initial,
        ..FlankDocument::default()
    };
    (document.plan.grid, document.plan.rounds) = ([20, 8], 0);
    let mut work = FlankWork::start(|| {}).unwrap();
    // The files are asked for first, the plan waits for them.
    work.follow(&document);
    work.plan(&document).unwrap();
    let begun = std::time::Instant::now();
    while !work.is_planned_of(&document) {
        assert!(begun.elapsed() < std::time::Duration::from_secs(300), "{:?}", work.state(&document));
        work.follow(&document);
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    let turned = FlankDocument { side: Side::Negative, ..document.clone() };
    assert!(work.is_planned_of_surface(&turned) && !work.is_planned_of(&turned), "the surface is the same");
    let other = FlankDocument { source: guides("b", 3.0), ..document.clone() };
    assert_eq!(other.name(), document.name());
    assert!(!work.is_planned_of_surface(&other));
}
