//! A folder holds the results of one plan, or still those of the one before.

use std::collections::BTreeSet;
use std::path::Path;

use feed::path::FeedPath;
use feed::preset::Preset;
use files::{FileError, MANIFEST};
use geometry::exact::ExactMesh;
use glam::DVec3;
use nc::post::{BUILT_IN, Post};
use nc::template::JobSheet;
use sparkpath::workspaces::blisk::export::{self, ExportForms, PlanFilesError};
use sparkpath::workspaces::blisk::job::finish::finish_as_far_as_possible;
use sparkpath::workspaces::blisk::job::outcome::PlanInputs;
use sparkpath::workspaces::blisk::job::preset::{MeasuredElectrode, Presets, with_presets};
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

/// The path of an electrode that stands off nominal is certified anew and written with the place of its final pose.
pub fn a_preset_is_made_up_for_by_path_and_program() {
    let folder = tempfile::tempdir().unwrap();
    let (inputs, plan) = (inputs(), whole_easy_plan());
    let blisk = plan.channel.wheel_in_w(&inputs.blisk);
    let preset = Preset { x_mm: 0.3, y_mm: -0.2, z_mm: 0.05, c_deg: 0.8, uncertainty_mm: 0.002, ..Preset::default() };
    let preset = MeasuredElectrode { preset, wear_mm: 0.0 };
    let with = |presets: Presets, inputs: &PlanInputs| {
        with_presets(plan.clone(), inputs, &blisk, &presets, &Task::default()).map_err(|e| e.to_string())
    };
    let made = with(Presets::from([(1, preset)]), &inputs).unwrap();
    let [nominal, own] = [plan, &made].map(|plan| plan.electrodes[0].plan.path.as_ref().unwrap());
    assert!(made.is_verified() && own.path != nominal.path);
    assert!((own.certificate.certified() - nominal.certificate.certified()).abs() < 0.001);
    // At every row the electrode is where the nominal one is.
    let place = DVec3::new(4.0, 3.0, 47.0);
    let placed = |path: &FeedPath, i: usize| path.rows[i].pose.placement(path.reference_point).transform_point3(place);
    assert!((0..own.path.rows.len()).all(|i| placed(&own.path, i).distance(placed(&nominal.path, i)) < 3e-5));
    let forms = ExportForms::of(&inputs.job.export).unwrap();
    let mut report = build::report(&made, &inputs.job, Vec::new());
    finish_as_far_as_possible(&made, &inputs, &blisk, &Task::default()).unwrap();
    export::write(folder.path(), &made, &inputs, &forms, &mut report, &Cancel::default()).unwrap();
    let program = std::fs::read_to_string(folder.path().join("path_1.nc")).unwrap();
    assert!(program.contains("Preset: the electrode stands X 0.3 Y -0.2 Z 0.05 mm"), "{program}");
    let job: serde_json::Value =
        serde_json::from_str(&std::fs::read_to_string(folder.path().join("job.json")).unwrap()).unwrap();
    let position = &job["electrodes"][0]["locations"][0]["position"];
    assert!((position["c_deg"].as_f64().unwrap() + 0.8).abs() < 1e-9, "{position}");
    // What does not fit the plan, or is not measured well enough, is refused.
    assert!(with(Presets::new(), &inputs).unwrap_err().contains("electrode 1 has no preset"));
    let two = Presets::from([(1, preset), (2, preset)]);
    assert!(with(two, &inputs).unwrap_err().contains("the plan has 1"));
    let mut exact = inputs.clone();
    (exact.job.setting.x_mm, exact.job.setting.y_mm, exact.job.setting.z_mm) = (0.005, 0.001, 0.005);
    assert!(with(Presets::from([(1, preset)]), &exact).unwrap_err().contains("measured to 0.002 mm"));
}

/// A worn electrode goes on by what its front has lost: certified, without overcut, and no surface keeps more stock than a new
/// electrode leaves there and the wear.
pub fn a_worn_electrode_goes_on_by_what_it_lost() {
    const WEAR_MM: f64 = 0.1;
    let (inputs, plan) = (inputs(), whole_easy_plan());
    let blisk = plan.channel.wheel_in_w(&inputs.blisk);
    let worn = MeasuredElectrode { preset: Preset::default(), wear_mm: WEAR_MM };
    let made = with_presets(plan.clone(), &inputs, &blisk, &Presets::from([(1, worn)]), &Task::default()).unwrap();
    finish_as_far_as_possible(&made, &inputs, &blisk, &Task::default()).unwrap();
    let [new, worn] = [plan, &made].map(|plan| &plan.electrodes[0]);
    assert!(
        made.is_verified() && worn.electrode.mesh == new.electrode.mesh && worn.burning().mesh != new.electrode.mesh
    );
    let advance = DVec3::from(worn.preset.unwrap().advance_mm);
    assert!((advance.length() - WEAR_MM).abs() < 1e-9 && advance.dot(new.electrode.enters_from.direction()) < 0.0);
    // The worn mesh is where the certificate has it: as far from the blisk as is asked for, at every row.
    let [exact, worn_mesh] = [&blisk, &worn.burning().mesh].map(|mesh| ExactMesh::new(mesh).unwrap());
    let path = &worn.plan.path.as_ref().unwrap().path;
    for row in path.rows.iter().step_by(10) {
        let distance = exact.distance_to(&worn_mesh, &row.pose.placement(path.reference_point));
        assert!(distance > inputs.job.electrode.spark_gap_mm - 0.002, "{distance} at {}", row.s);
    }
    let [before, after] = [plan, &made].map(|plan| plan.residual_stock().unwrap());
    for (before, after) in before.surfaces.iter().zip(&after.surfaces) {
        assert!(after.overcut.depth_mm <= before.overcut.depth_mm + 0.002, "{:?}", after.surface);
        let most = before.left.depth_mm + 1.1 * WEAR_MM + 0.01;
        assert!(after.left.depth_mm <= most, "{:?}: {} of {most}", after.surface, after.left.depth_mm);
    }
}

/// A file is written only if its faces reach no farther beyond the mesh than feed and copying motion have to spare.
pub fn an_electrode_keeps_its_clearance_as_step() {
    let folder = tempfile::tempdir().unwrap();
    let mut inputs = inputs();
    inputs.job.export.files.step = true;
    let plan = whole_easy_plan();
    let mut report = build::report(plan, &inputs.job, Vec::new());
    let forms = ExportForms::of(&inputs.job.export).unwrap();
    let files = export::write(folder.path(), plan, &inputs, &forms, &mut report, &Cancel::default()).unwrap();
    let said = report.electrodes[0].step.clone().unwrap();
    let beyond = said.split_once("no more than ").and_then(|(_, rest)| rest.split_once(" mm beyond the mesh"));
    let beyond: f64 = beyond.unwrap_or_else(|| panic!("{said}")).0.parse().unwrap();
    let feed = &plan.electrodes[0].plan.path.as_ref().unwrap().certificate;
    assert!(beyond <= feed.certified() - (feed.required() - feed.tolerance()), "{said}");
    let is_there = |name: &str| files.contains(&name.to_owned());
    assert!(is_there("electrode_1.step") && is_there("electrode_1.stl"), "{files:?}");
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
