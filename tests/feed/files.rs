//! A folder holds the results of one plan, or still those of the one before.

use std::collections::BTreeSet;
use std::path::Path;

use nc::post::{BUILT_IN, Post};
use sparkpath::workspaces::blisk::export;
use sparkpath::workspaces::blisk::job::plan::PlanInputs;
use sparkpath::workspaces::blisk::report::build;
use task::Cancel;

use super::{easy_blisk, easy_job, mesh, whole_easy_plan};

/// Writes the easy plan with programs of this extension.
fn write(folder: &Path, extension: &str, cancel: &Cancel) -> Result<Vec<String>, export::PlanFilesError> {
    let text = BUILT_IN[0].1.replace("extension = \"nc\"", &format!("extension = \"{extension}\""));
    let post = Post::from_toml(&text, extension).unwrap();
    let inputs = PlanInputs { blisk: mesh(&easy_blisk()).into(), own_electrode: None, job: easy_job() };
    let mut report = build::report(whole_easy_plan(), &inputs.job, Vec::new());
    export::write(folder, whole_easy_plan(), &inputs, &post, &mut report, cancel)
}

fn names(folder: &Path) -> BTreeSet<String> {
    std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect()
}

pub fn a_folder_holds_the_programs_of_the_last_plan_only() {
    let (folder, cancel) = (tempfile::tempdir().unwrap(), Cancel::default());
    let folder = folder.path();
    let written = |extension| write(folder, extension, &cancel).unwrap().into_iter().collect::<BTreeSet<_>>();
    assert!(written("ngc").contains("path_1.ngc"));
    // Known by the report, and without one by its own first comment.
    assert_eq!((written("tap"), names(folder).contains("path_1.ngc")), (names(folder), false));
    std::fs::remove_file(folder.join("report.json")).unwrap();
    assert_eq!((written("h"), names(folder).contains("path_1.tap")), (names(folder), false));

    // Told to stop at the last moment, nothing is touched.
    let before = names(folder);
    let program = std::fs::metadata(folder.join("path_1.h")).unwrap().modified().unwrap();
    cancel.cancel();
    assert!(matches!(write(folder, "nc", &cancel), Err(export::PlanFilesError::Cancelled(_))));
    assert_eq!(names(folder), before);
    assert_eq!(std::fs::metadata(folder.join("path_1.h")).unwrap().modified().unwrap(), program);
}

pub fn what_cannot_be_replaced_is_named_and_no_program_lies_beside_it() {
    let folder = tempfile::tempdir().unwrap();
    let in_the_way = folder.path().join("path_1.csv");
    std::fs::create_dir(&in_the_way).unwrap();
    let error = write(folder.path(), "nc", &Cancel::default()).unwrap_err();
    assert!(matches!(&error, export::PlanFilesError::Replace { file, .. } if *file == in_the_way), "{error}");
    assert!(!error.to_string().contains("--out"), "{error}");
    assert!(!names(folder.path()).contains("path_1.nc"));
}
