//! A folder holds the results of one plan, or still those of the one before.

use std::collections::BTreeSet;
use std::path::Path;

use files::{FileError, MANIFEST};
use nc::post::{BUILT_IN, Post};
use nc::template::JobSheet;
use sparkpath::workspaces::blisk::export::{self, ExportForms, PlanFilesError};
use sparkpath::workspaces::blisk::job::outcome::PlanInputs;
use sparkpath::workspaces::blisk::report::build;
use task::{Cancel, Task};

use super::{easy_blisk, easy_job, mesh, whole_easy_plan};

fn inputs() -> PlanInputs {
    PlanInputs::of(mesh(&easy_blisk()), easy_job())
}

/// Writes the easy plan with programs of this extension.
fn write(folder: &Path, extension: &str, cancel: &Cancel) -> Result<Vec<String>, PlanFilesError> {
    let text = BUILT_IN[0].1.replace("extension = \"nc\"", &format!("extension = \"{extension}\""));
    let post = Post::from_toml(&text, extension).unwrap();
    let forms = ExportForms { post, job_sheet: JobSheet::standard() };
    let inputs = inputs();
    let mut report = build::report(whole_easy_plan(), &inputs.job, Vec::new());
    export::write(folder, whole_easy_plan(), &inputs, &forms, &mut report, cancel)
}

fn names(folder: &Path) -> BTreeSet<String> {
    std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect()
}

pub fn a_folder_holds_the_programs_of_the_last_plan_only() {
    let (folder, cancel) = (tempfile::tempdir().unwrap(), Cancel::default());
    let folder = folder.path();
    let written = |extension| {
        let files = write(folder, extension, &cancel).unwrap().into_iter();
        files.chain([MANIFEST.to_owned()]).collect::<BTreeSet<_>>()
    };
    assert!(written("ngc").contains("path_1.ngc"));
    // Known by the manifest, and without one by its own first comment: then it is renamed and not removed.
    assert_eq!((written("tap"), names(folder).contains("path_1.ngc")), (names(folder), false));
    std::fs::remove_file(folder.join(MANIFEST)).unwrap();
    let others = ["path_3.tap", "path_4.notes.txt"];
    others.iter().for_each(|name| std::fs::write(folder.join(name), "(Sparkpath is a program)").unwrap());
    let mut left = written("h");
    left.extend([others[0], others[1], "path_1.tap.old"].map(str::to_owned));
    assert_eq!(left, names(folder));

    // Told to stop at the last moment, nothing is touched.
    let before = names(folder);
    let program = std::fs::metadata(folder.join("path_1.h")).unwrap().modified().unwrap();
    cancel.cancel();
    assert!(matches!(write(folder, "nc", &cancel), Err(PlanFilesError::Cancelled(_))));
    assert_eq!(names(folder), before);
    assert_eq!(std::fs::metadata(folder.join("path_1.h")).unwrap().modified().unwrap(), program);
}

/// Feed and copying motion of the easy plan leave less than a micrometre to spare. A file is written only if its faces reach
/// no farther beyond the mesh; if not, the reason is told, and the other files are written.
pub fn an_electrode_that_would_lose_its_clearance_as_step_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let mut inputs = inputs();
    inputs.job.export.files.step = true;
    let plan = whole_easy_plan();
    let mut report = build::report(plan, &inputs.job, Vec::new());
    let forms = ExportForms::of(&inputs.job.export).unwrap();
    let files = export::write(folder.path(), plan, &inputs, &forms, &mut report, &Cancel::default()).unwrap();
    let said = report.electrodes[0].step.clone().unwrap();
    assert!(said.starts_with("No STEP file: ") && said.contains(" mm are to spare"), "{said}");
    assert!(files.iter().all(|file| !file.ends_with(".step")) && files.contains(&"electrode_1.stl".to_owned()));
    assert_eq!(names(folder.path()), files.into_iter().chain([MANIFEST.to_owned()]).collect());
}

pub fn what_cannot_be_replaced_is_named_and_no_program_lies_beside_it() {
    let folder = tempfile::tempdir().unwrap();
    let in_the_way = folder.path().join("path_1.csv");
    std::fs::create_dir(&in_the_way).unwrap();
    let error = write(folder.path(), "nc", &Cancel::default()).unwrap_err();
    let named = |error: &FileError| matches!(error, FileError::Unwritable { file, .. } if *file == in_the_way);
    assert!(matches!(&error, PlanFilesError::Write(error) if named(error)), "{error}");
    assert!(!error.to_string().contains("--out"), "{error}");
    assert!(!names(folder.path()).contains("path_1.nc"));
}

pub fn a_plan_that_is_stopped_at_its_pictures_is_written_without_them_and_without_a_program() {
    let folder = tempfile::tempdir().unwrap();
    let (inputs, plan) = (inputs(), whole_easy_plan().clone().undrawn());
    assert!(inputs.job.export.draws_any() && whole_easy_plan().may_be_approved());
    let (report, written) = export::export(folder.path(), &plan, &inputs, Vec::new(), &Task::default()).unwrap();
    assert_eq!((report.pictures.len(), report.verdict.exit_code), (0, 130), "{}", report.verdict.sentence);
    let is_written = |name: &str| written.iter().any(|file| file == name);
    assert!(is_written("path_1.csv") && is_written("report.html") && !is_written("path_1.nc"), "{written:?}");
}
