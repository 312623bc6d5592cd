use std::collections::BTreeMap;
use std::fs;

use proptest::prelude::*;

use super::*;
use crate::{Autosave, Invalid, Recovery, kind_of};

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
struct Mold {
    mesh: Option<PathBuf>,
    tolerance_mm: f64,
    name: String,
    cutters: Vec<f64>,
    nested: BTreeMap<String, f64>,
}

impl Default for Mold {
    fn default() -> Self {
        Self { mesh: None, tolerance_mm: 0.02, name: String::new(), cutters: Vec::new(), nested: BTreeMap::new() }
    }
}

impl Validate for Mold {
    fn validate(&self) -> Result<(), Invalid> {
        Invalid::unless_within("tolerance_mm", self.tolerance_mm, [1e-4, 10.0], "mm")
    }
}

impl Params for Mold {
    const KIND: &'static str = "mold";

    fn part(&self) -> String {
        let name = self.mesh.as_deref().and_then(Path::file_name);
        name.map_or_else(String::new, |name| name.to_string_lossy().into_owned())
    }

    fn change_paths(&mut self, change: &mut dyn FnMut(&Path) -> PathBuf) {
        if let Some(mesh) = &mut self.mesh {
            *mesh = change(mesh);
        }
    }
}

#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
struct Flank {
    mesh: PathBuf,
}

thread_local! {
    static VALIDATED: std::cell::Cell<usize> = const { std::cell::Cell::new(0) };
}

impl Validate for Flank {
    fn validate(&self) -> Result<(), Invalid> {
        VALIDATED.set(VALIDATED.get() + 1);
        if self.mesh.as_os_str() == "wrong" { Err(Invalid::new("mesh", "wrong", "name another")) } else { Ok(()) }
    }
}

impl Params for Flank {
    const KIND: &'static str = "flank";

    fn part(&self) -> String {
        String::new()
    }

    fn change_paths(&mut self, _: &mut dyn FnMut(&Path) -> PathBuf) {}
}

fn with(document: &Document<Mold>, tolerance_mm: f64) -> Mold {
    Mold { tolerance_mm, ..document.params().clone() }
}

#[test]
fn what_is_wrong_is_looked_for_once_for_each_change() {
    let mut document = Document::<Flank>::default();
    let told = |document: &Document<Flank>, is_wrong: bool| {
        let before = VALIDATED.get();
        assert_eq!([(); 3].map(|()| document.problem().is_some()), [is_wrong; 3]);
        VALIDATED.get() - before
    };
    assert_eq!(told(&document, false), 1);
    document.edit("Mesh", Flank { mesh: "wrong".into() }, false);
    assert_eq!((told(&document, true), told(&document.clone(), true)), (1, 0));
    document.undo(false);
    assert_eq!(told(&document, false), 1);
    document.undo(true);
    document.amend(false, |flank| flank.mesh = "right".into());
    assert_eq!(told(&document, false), 1);
    document.complete_step(Flank { mesh: "wrong".into() });
    assert_eq!(told(&document, true), 1);
    document.replace_file("wrong".as_ref(), "found".as_ref());
    assert_eq!(told(&document, true), 1, "its paths are fixed");
    document.note_result("plan", Some("of it".to_owned()));
    let kept = document.kept_revision();
    assert_eq!(told(&document, true), 0, "results are no parameters");
    document.keep("runs", Some("1".to_owned()));
    assert_ne!(document.kept_revision(), kept);
}

#[test]
fn the_kind_of_a_large_project_is_told_by_its_beginning_and_what_a_copy_is_of_by_its_end() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("large.sparkpath");
    let large = "[x]\n".repeat(100_000);
    let note = "[autosave]\nfile = \"a.sparkpath\"\npart = \"slots\"\n";
    fs::write(&file, format!("kind = \"mold\"\n[results]\nfound = \"\"\"\n{large}\"\"\"\n{note}")).unwrap();
    assert_eq!(kind_of(&file).unwrap(), "mold");
    let found = project::note_of(&file).unwrap();
    assert_eq!((found.part.as_str(), found.file.as_deref()), ("slots", Some(Path::new("a.sparkpath"))));
    // Wherever it stands, and whatever else is wrong: that is told by who opens it.
    fs::write(&file, format!("name = \"\"\"\n{large}\"\"\"\nkind = \"mold\"")).unwrap();
    assert_eq!(kind_of(&file).unwrap(), "mold");
    fs::write(&file, "kind = \"mold\"\n[[").unwrap();
    assert_eq!(kind_of(&file).unwrap(), "mold");
    fs::write(&file, "mesh = \"a.stl\"").unwrap();
    assert!(kind_of(&file).unwrap_err().to_string().contains("kind: it is missing"));
}

#[test]
fn one_drag_is_one_step_and_the_next_another() {
    let mut document = Document::<Mold>::default();
    for mm in [0.6, 0.7, 0.8] {
        document.edit("Tolerance", with(&document, mm), true);
    }
    document.end_gesture();
    document.edit("Tolerance", with(&document, 0.9), true);
    document.edit("Other", with(&document, 1.0), true);
    document.edit("Typed", with(&document, 1.1), false);
    document.edit("Typed", with(&document, 1.2), false);
    for mm in [1.1, 1.0, 0.9, 0.8, 0.02] {
        assert!(document.undo(false));
        assert_eq!(document.params().tolerance_mm, mm);
    }
    assert!(!document.undo(false) && !document.is_unsaved());
    assert_eq!((document.undo_label(false), document.undo_label(true)), (None, Some("Tolerance")));
    document.undo(true);
    document.edit("Tolerance", with(&document, 0.85), true);
    assert!(!document.undo(true), "a new edit ends what could be done again");
    document.undo(false);
    assert_eq!(document.params().tolerance_mm, 0.8, "what was done again is no part of the gesture after it");
}

#[test]
fn what_the_program_notes_is_no_step_and_what_follows_from_a_step_goes_with_it() {
    let mut document = Document::<Mold>::default();
    document.edit("Tolerance", with(&document, 0.5), false);
    let states = [document.revision(), document.content_revision()];
    document.amend(true, |params| params.name = "noted".to_owned());
    assert!(document.revision() == states[0] && document.content_revision() != states[1]);
    document.undo(false);
    assert!(document.params().name == "noted" && !document.is_unsaved() && document.undo_label(false).is_none());
    document.amend(false, |params| params.name = "found".to_owned());
    assert!(document.is_unsaved(), "the file does not hold it");
    document.undo(true);
    document.edit("Mesh", Mold { mesh: Some("a.stl".into()), ..document.params().clone() }, false);
    document.complete_step(Mold { name: "of the mesh".to_owned(), ..document.params().clone() });
    document.undo(false);
    assert_eq!((document.params().name.as_str(), &document.params().mesh), ("found", &None));
    document.undo(true);
    assert_eq!(document.params().name, "of the mesh");
}

#[test]
fn a_project_is_opened_as_it_was_saved_and_finds_its_files_beside_it() {
    let folder = tempfile::tempdir().unwrap();
    let [old, new] = ["old", "new"].map(|name| folder.path().join(name));
    fs::create_dir(&old).unwrap();
    fs::write(old.join("part.stl"), "solid").unwrap();
    let nested = BTreeMap::from([("a b".to_owned(), 1.0 / 3.0)]);
    let params = Mold { mesh: Some(old.join("part.stl")), nested, cutters: vec![0.1 + 0.2], ..Mold::default() };
    let mut document = Document::new(params);
    let of = |path: PathBuf, sha256: String| PartFile { path, sha256 };
    document.note_file(&of(old.join("part.stl"), sha256_of(&old.join("part.stl")).unwrap()));
    document.note_file(&of(old.join("unused.stl"), "0".to_owned()));
    document.note_result("plan", Some("{\"nodes\": [1e-300, '''\"\"\"]}\r\n\u{1}".to_owned()));
    assert!(!document.is_unsaved(), "the same search finds a result again");
    document.keep("runs", Some("[1]".to_owned()));
    assert!(document.is_unsaved());
    let file = old.join("a.sparkpath");
    document.save_as(&file).unwrap();
    assert!(!document.is_unsaved() && kind_of(&file).unwrap() == "mold" && document.name() == "a");
    let text = fs::read_to_string(&file).unwrap();
    assert!(text.starts_with("kind = \"mold\"\nversion = 1\n") && text.contains("mesh = \"part.stl\""), "{text}");
    fs::rename(&old, &new).unwrap();
    let opened = Document::<Mold>::open(&new.join("a.sparkpath")).unwrap();
    let wanted = Mold { mesh: Some(new.join("part.stl")), ..document.params().clone() };
    assert_eq!(opened.params(), &wanted);
    assert_eq!((opened.result("plan"), opened.kept("runs")), (document.result("plan"), Some("[1]")));
    assert!(opened.moved_files().is_empty() && !opened.is_unsaved());
    opened.export(&new.join("job.sparkpath")).unwrap();
    let job = fs::read_to_string(new.join("job.sparkpath")).unwrap();
    assert!(!job.contains("results") && !job.contains("files"), "{job}");
}

#[test]
fn lost_and_changed_files_are_told_apart_and_replaced() {
    let folder = tempfile::tempdir().unwrap();
    let [mesh, found, file] = ["part.stl", "found.stl", "a.sparkpath"].map(|name| folder.path().join(name));
    fs::write(&mesh, "solid").unwrap();
    let mut document = Document::new(Mold { mesh: Some(mesh.clone()), ..Mold::default() });
    document.note_file(&PartFile { path: mesh.clone(), sha256: sha256_of(&mesh).unwrap() });
    document.save_as(&file).unwrap();
    fs::write(&mesh, "other").unwrap();
    let mut opened = Document::<Mold>::open(&file).unwrap();
    assert_eq!(opened.moved_files(), [MovedFile { path: mesh.clone(), is_changed: true }]);
    fs::remove_file(&mesh).unwrap();
    assert_eq!(opened.moved_files(), [MovedFile { path: mesh.clone(), is_changed: false }]);
    fs::write(&found, "anything").unwrap();
    opened.replace_file(&mesh, &found);
    assert!(opened.moved_files().is_empty() && opened.is_unsaved(), "the file names another mesh");
}

#[test]
fn what_is_no_project_of_this_workspace_is_refused_with_line_and_remedy() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("wrong.sparkpath");
    let deep = format!("kind = \"mold\"\na = {}", "[".repeat(100_000));
    for (text, words) in [
        ("tolerance_mm = 0.1", "kind: it is missing"),
        ("kind = \"flank\"", "line 1: kind is \"flank\": must be \"mold\""),
        ("kind = \"mold\"\nversion = 2", "line 2: version is 2: this program reads up to 1"),
        ("kind = \"mold\"\nversion = -2", "line 2: version"),
        ("kind = \"mold\"\n\ntolerance_mm = -1", "line 3: tolerance_mm is -1: must be from 0.0001 to 10 mm"),
        ("kind = \"mold\"\ntolerance = 1", "line 2: tolerance: unknown field"),
        ("kind = \"mold\"\ntolerance_mm = \"wide\"", "line 2: tolerance_mm: invalid type"),
        ("kind = \"mold\"\n[results]\nplan = 3", "invalid type"),
        ("{\"format\": \"sparkpath-project\"}", "line 1"),
        ("solid cube", "line 1"),
        (&deep, "line 2"),
    ] {
        fs::write(&file, text).unwrap();
        let said = Document::<Mold>::open(&file).unwrap_err().to_string();
        assert!(
            said.contains("wrong.sparkpath: ") && said.contains(words) && !said.contains('\n'),
            "{text:.60}: {said}"
        );
    }
    fs::File::create(&file).unwrap().set_len(1 << 40).unwrap();
    assert!(matches!(Document::<Mold>::open(&file), Err(FileError::TooLarge { .. })));
    fs::write(&file, b"kind = \"mold\"\nname = \"\xff\"").unwrap();
    assert_eq!(Document::<Mold>::open(&file).unwrap_err().line(), Some(2));
    fs::write(&file, "kind = \"mold\"\ntolerance_mm = 0.5").unwrap();
    assert_eq!(Document::<Mold>::open(&file).unwrap().params().tolerance_mm, 0.5, "a job written by hand");
    let mut broken = Document::new(Mold { tolerance_mm: f64::NAN, ..Mold::default() });
    assert_eq!(broken.save_as(&file).unwrap_err().key(), Some("tolerance_mm"));
    assert!(Document::<Mold>::open(&file).is_ok(), "what was there still is");
}

fn unsaved(tolerance_mm: f64) -> Document<Mold> {
    let mut document = Document::<Mold>::default();
    document.edit("Tolerance", with(&document, tolerance_mm), false);
    document
}

fn start(folder: &Path) -> Autosave {
    Autosave::start(folder, 20.0).unwrap()
}

#[test]
fn a_copy_is_due_by_the_clock_that_is_given() {
    let folder = tempfile::tempdir().unwrap();
    let mut autosave = Autosave::start(folder.path(), 20.0).unwrap();
    let due: Vec<bool> = [0.0, 19.0, 20.0, 21.0, 39.0, 41.0].map(|now| autosave.is_due(now)).into();
    assert_eq!(due, [false, false, true, false, false, true]);
}

#[test]
fn unsaved_work_is_found_after_its_program_is_gone_but_not_before() {
    let folder = tempfile::tempdir().unwrap();
    let (copies, mesh) = (folder.path().join("copies"), folder.path().join("b_slots.stl"));
    let mut autosave = start(&copies);
    let mut document = unsaved(0.5);
    document.edit("Mesh", Mold { mesh: Some(mesh.clone()), ..with(&document, 0.5) }, false);
    document.note_result("uncut", Some("many regions".to_owned()));
    autosave.update(&document).unwrap();
    autosave
        .update(&{
            let mut flank = Document::<Flank>::default();
            flank.edit("Mesh", Flank { mesh: "a.stl".into() }, false);
            flank
        })
        .unwrap();
    assert_eq!(Recovery::find(&copies), [], "its program is alive");
    drop(autosave);
    let found = Recovery::find(&copies);
    let titles: Vec<String> = found.iter().map(Recovery::title).collect();
    assert_eq!(titles, ["Flank, not saved yet", "Mold: b_slots.stl, not saved yet"]);
    let recovered: Document<Mold> = found[1].open().unwrap();
    assert_eq!((recovered.params(), recovered.result("uncut")), (document.params(), Some("many regions")));
    assert!(recovered.is_unsaved() && recovered.file().is_none() && found[1].written().is_some());
    assert!(found[0].open::<Mold>().is_err(), "a flank is no mold");
    found[1].discard();
    assert_eq!(Recovery::find(&copies).len(), 1, "the one leaves the other alone");
    found[0].discard();
    assert_eq!(fs::read_dir(&copies).unwrap().count(), 0);
}

#[test]
fn saved_work_leaves_no_copy_and_unsaved_work_knows_its_file() {
    let folder = tempfile::tempdir().unwrap();
    let (copies, file) = (folder.path().join("copies"), folder.path().join("mine.sparkpath"));
    let mut autosave = start(&copies);
    let mut document = unsaved(0.5);
    autosave.update(&document).unwrap();
    document.save_as(&file).unwrap();
    autosave.update(&document).unwrap();
    assert_eq!(fs::read_dir(&copies).unwrap().count(), 1, "the lock alone");
    document.edit("Tolerance", with(&document, 0.7), false);
    autosave.update(&document).unwrap();
    drop(autosave);
    let [found] = &Recovery::find(&copies)[..] else { panic!("one copy") };
    assert_eq!(found.title(), "Mold, of mine.sparkpath");
    let recovered: Document<Mold> = found.open().unwrap();
    assert_eq!((recovered.file(), recovered.params().tolerance_mm), (Some(&*file), 0.7));
    let mut autosave = start(&copies);
    autosave.update(&recovered).unwrap();
    found.discard();
    autosave.discard("mold");
    drop(autosave);
    assert_eq!(fs::read_dir(&copies).unwrap().count(), 0);
}

/// Work is not lost because a number in it is wrong.
#[test]
fn parameters_that_are_not_possible_are_kept_in_a_copy_but_in_no_project() {
    let folder = tempfile::tempdir().unwrap();
    let mut autosave = start(folder.path());
    let mut document = unsaved(0.5);
    document.edit("Tolerance", with(&document, 0.0), false);
    autosave.update(&document).unwrap();
    drop(autosave);
    let [found] = &Recovery::find(folder.path())[..] else { panic!("one copy") };
    let recovered: Document<Mold> = found.open().unwrap();
    assert!(recovered.params() == document.params() && recovered.problem().is_some());
    assert!(Document::<Mold>::open(found.copy()).is_err(), "as a project it is refused");
    assert!(document.save_as(&folder.path().join("a.sparkpath")).is_err());
}

#[test]
fn programs_that_were_killed_leave_no_locks_and_no_temporary_files_for_ever() {
    let folder = tempfile::tempdir().unwrap();
    let alive = start(folder.path());
    let names = ["1-0.lock", "2-0.lock", "2-0.mold.sparkpath", ".sparkpath-a.part"];
    names.iter().for_each(|name| fs::write(folder.path().join(name), "").unwrap());
    let minutes_ago = std::time::SystemTime::now() - std::time::Duration::from_secs(300);
    fs::File::options().write(true).open(folder.path().join(names[3])).unwrap().set_modified(minutes_ago).unwrap();
    let other = start(folder.path());
    let mut left: Vec<_> = fs::read_dir(folder.path()).unwrap().map(|e| e.unwrap().file_name()).collect();
    let are_kept = names[1..3].iter().all(|name| left.iter().any(|left| left == name));
    left.retain(|name| !names.iter().any(|known| name == known));
    assert!(are_kept && left.len() == 2, "a copy with its lock, and two locks of the living: {left:?}");
    drop((alive, other));
}

#[test]
fn a_file_that_another_program_has_changed_is_replaced_only_on_purpose() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("mine.sparkpath");
    let save = |document: &mut Document<Mold>| {
        let saving = document.begin_saving(&file)?;
        saving.write(false).map(|()| document.end_saving(&saving))
    };
    let mut first = unsaved(0.5);
    save(&mut first).unwrap();
    let mut second = Document::<Mold>::open(&file).unwrap();
    first.edit("Tolerance", with(&first, 0.6), false);
    second.edit("Tolerance", with(&second, 0.7), false);
    save(&mut first).unwrap();
    // Recovered work knows what it began with.
    let mut autosave = start(&folder.path().join("copies"));
    autosave.update(&second).unwrap();
    drop(autosave);
    let mut recovered: Document<Mold> = Recovery::find(&folder.path().join("copies"))[0].open().unwrap();
    for document in [&mut second, &mut recovered] {
        let refused = save(document).unwrap_err();
        assert!(refused.is_changed() && document.is_unsaved(), "{refused}");
        assert_eq!(Document::<Mold>::open(&file).unwrap().params().tolerance_mm, 0.6);
    }
    second.save_as(&file).unwrap();
    second.edit("Tolerance", with(&second, 0.8), false);
    save(&mut second).unwrap();
    assert!(save(&mut first).unwrap_err().is_changed());
    // Nothing is lost where the file is gone, or is what would be written.
    let saving = first.begin_saving(&file).unwrap();
    fs::write(&file, &saving.text).unwrap();
    saving.write(false).unwrap();
    fs::remove_file(&file).unwrap();
    save(&mut first).unwrap();
}

#[test]
fn work_done_while_a_file_is_written_is_unsaved() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("mine.sparkpath");
    let mut document = unsaved(0.5);
    let saving = document.begin_saving(&file).unwrap();
    document.edit("Tolerance", with(&document, 0.6), false);
    saving.write(false).unwrap();
    document.end_saving(&saving);
    assert!(document.is_unsaved() && document.file() == Some(&*file));
    document.undo(false);
    assert!(!document.is_unsaved());
    // A document that came meanwhile is not the one that was saved.
    let mut other = unsaved(0.7);
    other.end_saving(&saving);
    assert!(other.is_unsaved() && other.file().is_none());
}

#[test]
fn two_programs_keep_two_copies_and_a_damaged_one_is_offered_but_does_not_open() {
    let folder = tempfile::tempdir().unwrap();
    let mut both = [start(folder.path()), start(folder.path())];
    for (autosave, mm) in both.iter_mut().zip([0.5, 0.6]) {
        autosave.update(&unsaved(mm)).unwrap();
    }
    drop(both);
    let found = Recovery::find(folder.path());
    let read = |r: &Recovery| r.open::<Mold>().unwrap().params().tolerance_mm;
    assert_eq!(found.iter().map(read).collect::<Vec<_>>(), [0.5, 0.6]);
    let mut names = fs::read_dir(folder.path()).unwrap().map(|entry| entry.unwrap().path());
    let copy = names.find(|path| path.extension().is_some_and(|e| e == "sparkpath")).unwrap();
    fs::write(copy, "kind = \"mo").unwrap();
    fs::write(folder.path().join("..sparkpath"), "").unwrap();
    let again = Recovery::find(folder.path());
    assert!(again.iter().any(|r| r.title() == "Mold, not saved yet" && r.open::<Mold>().is_err()), "{again:?}");
}

proptest! {
    /// Undoing every step gives the start again, and doing them all again the end.
    #[test]
    fn undo_and_redo_are_inverse(edits in prop::collection::vec((0.1..5.0_f64, 0..3_u8, any::<bool>(), any::<bool>()), 1..20)) {
        let mut document = Document::<Mold>::default();
        let mut states = vec![document.params().clone()];
        for (mm, label, in_gesture, ends) in edits {
            document.edit(&label.to_string(), with(&document, mm), in_gesture);
            states.push(document.params().clone());
            if ends {
                document.end_gesture();
            }
        }
        let end = document.params().clone();
        let mut back = vec![end.clone()];
        while document.undo(false) {
            back.push(document.params().clone());
        }
        prop_assert_eq!(document.params(), &states[0]);
        // Gestures skip states, but nothing else is ever shown.
        prop_assert!(back.iter().all(|state| states.contains(state)));
        let mut forth = vec![document.params().clone()];
        while document.undo(true) {
            forth.push(document.params().clone());
        }
        back.reverse();
        prop_assert_eq!(forth, back);
    }

    /// Whatever a document holds is read back to the last bit.
    #[test]
    fn a_project_survives_saving_and_opening(
        tolerance_mm in 1e-4..10.0_f64, name: String, cutters in prop::collection::vec(prop::num::f64::NORMAL | prop::num::f64::ZERO, 0..5),
        nested in prop::collection::btree_map(any::<String>(), prop::num::f64::NORMAL, 0..5),
        results in prop::collection::btree_map(any::<String>(), any::<String>(), 0..4),
    ) {
        let params = Mold { mesh: None, tolerance_mm, name, cutters, nested };
        let project = Project { params, files: Vec::new(), results: results.clone(), kept: results };
        let text = project.text(Path::new("a"), None).unwrap();
        let read = Project::parse(&text, Path::new("a"));
        prop_assert_eq!(read.unwrap(), project, "{}", text);
    }
}

#[test]
fn a_number_that_is_not_finite_is_refused_with_its_place() {
    for (text, key) in [("tolerance_mm = nan", "tolerance_mm"), ("cutters = [1.0, inf]", "cutters[1]")] {
        let text = format!("kind = \"mold\"\n{text}\n");
        let said = Project::<Mold>::parse(&text, Path::new("part.sparkpath")).unwrap_err().to_string();
        assert!(said.contains("line 2") && said.contains(key) && said.contains("finite"), "{said}");
    }
}
