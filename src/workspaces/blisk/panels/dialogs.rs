//! The dialog of the export: files, the frame of the electrode meshes, the post, and pictures. Every choice is a
//! parameter of the job like any other.

use crate::workspaces::blisk::desk::BliskDesk;
use egui::{ComboBox, RichText, Ui};

use super::forms::shown_choice;
use crate::widgets::panel_parts::from_right;
use crate::widgets::theme::{palette, tick};
use crate::workspaces::blisk::document::choice::{DrawnPictures, MeshFrame};
use crate::workspaces::blisk::document::job_file::ExportSection;
use crate::workspaces::blisk::document::job_file::field_table::FIELDS;
use files::{Kind, Word};

/// Room for the names of files (points).
const NAMES: f32 = 150.0;

/// Answer of the user.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Answer {
    /// Choose the folder and export.
    Folder,
    /// Choose an NC post of one's own, and go on with the export.
    OwnPost,
    /// Close the dialog.
    Close,
}

/// Draws the dialog of the export. Choices go into the document at once.
pub fn export(ui: &mut Ui, desk: &mut BliskDesk) -> Option<Answer> {
    let mut job = desk.document.params().clone();
    let export = &mut job.export;
    let mut answer = files(ui, export);
    ui.add_space(8.0);
    ui.label(RichText::new("Pictures").small().color(palette(ui).faint));
    let drawn = export.files.report || export.files.pictures;
    ui.add_enabled_ui(drawn, |ui| pictures(ui, &mut export.pictures));
    ui.add_space(8.0);
    let is_any = export.files.any();
    let problem = desk.document.problem().map(|problem| FIELDS.in_window(problem));
    let (colour, text) = match &problem {
        Some(_) if !is_any => (palette(ui).bad, "No file is chosen: nothing would be written."),
        Some(problem) => (palette(ui).bad, problem.as_str()),
        None => (palette(ui).warning, "Results of an earlier plan in the folder are replaced."),
    };
    ui.label(RichText::new(text).color(colour));
    ui.label(RichText::new("K is the number of the electrode.").small().color(palette(ui).faint));
    ui.add_space(10.0);
    from_right(ui, |ui| {
        if ui.add_enabled(problem.is_none(), egui::Button::new("Choose folder…")).clicked() {
            answer = Some(Answer::Folder);
        }
        if ui.button("Cancel").clicked() {
            answer = Some(Answer::Close);
        }
    });
    desk.edit("Export choices", job, false);
    answer
}

fn files(ui: &mut Ui, export: &mut ExportSection) -> Option<Answer> {
    let mut answer = None;
    egui::Grid::new("files").num_columns(2).min_col_width(NAMES).spacing([12.0, 6.0]).show(ui, |ui| {
        let files = &mut export.files;
        tick(ui, &mut files.electrode, file("electrode_K.stl"));
        ui.add_enabled_ui(files.electrode, |ui| frame(ui, &mut export.frame));
        ui.end_row();
        tick(ui, &mut files.step, file("electrode_K.step"));
        says(ui, "with faces, where it keeps the clearance");
        ui.end_row();
        tick(ui, &mut files.path, file("path_K.csv"));
        says(ui, "rows of the verified motion, in W");
        ui.end_row();
        tick(ui, &mut files.nc, file("path_K.nc"));
        ui.add_enabled_ui(files.nc, |ui| {
            if post(ui, &mut export.post) {
                answer = Some(Answer::OwnPost);
            }
        });
        ui.end_row();
        tick(ui, &mut files.residual_stock, file("leftover.ply, copying_K.csv"));
        says(ui, "residual stock, copying motion");
        ui.end_row();
        tick(ui, &mut files.report, file("report.html, .json"));
        says(ui, "verdict, figures, curves, pictures");
        ui.end_row();
        tick(ui, &mut files.pictures, file("*.png"));
        says(ui, "the pictures as files of their own");
        ui.end_row();
    });
    answer
}

fn file(name: &str) -> RichText {
    RichText::new(name).monospace()
}

fn says(ui: &mut Ui, text: &str) {
    ui.label(RichText::new(text).color(palette(ui).faint));
}

fn frame(ui: &mut Ui, frame: &mut MeshFrame) {
    let combo = ComboBox::from_id_salt("frame").width(220.0).selected_text(frame.name());
    let response = combo.show_ui(ui, |ui| {
        for other in [MeshFrame::Mesh, MeshFrame::W] {
            ui.selectable_value(frame, other, other.name());
        }
    });
    named(&response.response, "Frame of the electrode meshes");
}

/// Draws the choice of the post. Returns whether the user wants a post of their own.
fn post(ui: &mut Ui, post: &mut String) -> bool {
    let words = posts();
    let mut own = false;
    let combo = ComboBox::from_id_salt("post").width(220.0).truncate().selected_text(shown_choice(words, post));
    let response = combo.show_ui(ui, |ui| {
        for Word { word, label, .. } in words {
            ui.selectable_value(post, (*word).to_owned(), *label);
        }
        own = ui.selectable_label(false, "Own file…").clicked();
    });
    named(&response.response, "Post-processor of the NC programs");
    own
}

fn named(response: &egui::Response, name: &'static str) {
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::ComboBox, true, name));
}

/// The built-in posts with their names.
fn posts() -> &'static [Word] {
    let kind = FIELDS.find("export.post").map(|place| place.field.kind);
    if let Ok(Kind::ChoiceOrFile(words)) = kind { words } else { &[] }
}

fn pictures(ui: &mut Ui, drawn: &mut DrawnPictures) {
    ui.horizontal_wrapped(|ui| {
        ui.spacing_mut().item_spacing.x = 16.0;
        tick(ui, &mut drawn.whole, "Whole blisk");
        tick(ui, &mut drawn.final_pose, "Final pose");
        tick(ui, &mut drawn.sweep, "Sweep");
        tick(ui, &mut drawn.closest, "Closest point");
        tick(ui, &mut drawn.residual_stock, "Residual stock");
    });
}
