//! The dialog about files of a project that are gone or have changed.

use std::path::PathBuf;

use egui::Ui;

use crate::widgets::panel_parts::from_right;
use crate::workspaces::blisk::document::job_file::PlanJob;
use files::MovedFile;

/// What the user answered.
pub enum Answer {
    /// Look for the file that was here.
    Locate(PathBuf),
    /// Open the project with the files as they are.
    OpenAnyway,
    /// Close the dialog.
    Close,
}

/// Draws it.
pub fn show(ui: &mut Ui, job: &PlanJob, moved: &[MovedFile]) -> Option<Answer> {
    let mut answer = None;
    for file in moved {
        let what = if file.is_changed { "has changed since the project was saved" } else { "no longer exists" };
        ui.label(format!("{} {what}.", file.path.display()));
        if ui.button("Find it…").clicked() {
            answer = Some(Answer::Locate(file.path.clone()));
        }
        ui.add_space(4.0);
    }
    ui.add_space(10.0);
    from_right(ui, |ui| {
        // Without its meshes there is nothing to show; a machine or a post can be chosen later.
        let is_mesh = |path: &PathBuf| [&job.blisk.mesh, &job.electrode.mesh].contains(&&Some(path.clone()));
        let text = if moved.iter().all(|file| file.is_changed) { "Use as it is now" } else { "Open without" };
        if moved.iter().all(|file| file.is_changed || !is_mesh(&file.path)) && ui.button(text).clicked() {
            answer = Some(Answer::OpenAnyway);
        }
        if ui.button("Cancel").clicked() {
            answer = Some(Answer::Close);
        }
    });
    answer
}
