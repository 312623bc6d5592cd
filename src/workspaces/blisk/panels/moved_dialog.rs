//! The dialog about meshes of a project that are gone or have changed.

use std::path::PathBuf;

use egui::Ui;

use crate::widgets::panel_parts::from_right;
use crate::workspaces::blisk::document::project_file::MovedMesh;

/// What the user answered.
pub enum Answer {
    /// Look for the mesh that was here.
    Locate(PathBuf),
    /// Open the project although meshes have changed.
    OpenAnyway,
    /// Close the dialog.
    Close,
}

/// Draws it.
pub fn show(ui: &mut Ui, moved: &[MovedMesh]) -> Option<Answer> {
    let mut answer = None;
    for mesh in moved {
        let what = if mesh.changed { "has changed since the project was saved" } else { "no longer exists" };
        ui.label(format!("{} {what}.", mesh.path.display()));
        if ui.button("Find it…").clicked() {
            answer = Some(Answer::Locate(mesh.path.clone()));
        }
        ui.add_space(4.0);
    }
    ui.add_space(10.0);
    from_right(ui, |ui| {
        if moved.iter().all(|m| m.changed) && ui.button("Use as it is now").clicked() {
            answer = Some(Answer::OpenAnyway);
        }
        if ui.button("Cancel").clicked() {
            answer = Some(Answer::Close);
        }
    });
    answer
}
