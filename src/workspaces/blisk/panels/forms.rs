//! The form of a step, made from the table of parameters.

use egui::Ui;

use crate::widgets::form::Form;
use crate::widgets::panel_parts::file_name;
use crate::workspaces::blisk::commands::BliskCommand;
use crate::workspaces::blisk::desk::BliskDesk;
use crate::workspaces::blisk::document::job_file::field_table::FIELDS;
use crate::workspaces::blisk::document::stage::Stage;
use crate::workspaces::context::Context;
use files::{Params as _, Word, get};

/// Request of a form to the workspace.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Request {
    /// A table of measured sections.
    Sections,
    /// An electrode mesh of one's own, for the parameter under this key.
    ElectrodeMesh(String),
    /// An NC post of one's own.
    Post,
    /// A template of the job sheet of one's own.
    JobSheet,
    /// A machine file of one's own.
    Machine,
    /// A technology table of one's own.
    Technology,
    /// A mesh of the wheel as it comes.
    Blank,
    /// A scan of the finished part.
    Scan,
    /// A table of the electrodes as they are measured.
    Presets,
}

/// Draws the fields of `stage`. Changes go into the document at once.
pub fn show(ui: &mut Ui, desk: &mut BliskDesk, cx: &mut Context, stage: Stage) -> Option<Request> {
    let mut form = Form::new(&FIELDS, desk.document.params(), desk.document.problem());
    form.section(ui, stage.name());
    let answer = form.answer();
    if let Some(edit) = answer.edit {
        let mut job = edit.params;
        // A machine that is chosen brings its axes along; one that cannot be read is not taken.
        if job.complete(&|key| key == edit.key).is_ok() {
            desk.edit(&edit.label, job, edit.in_gesture);
        }
    }
    answer.said.into_iter().for_each(|said| cx.say_in_passing(said));
    if ui.input(|i| i.pointer.any_released()) {
        desk.end_gesture();
    }
    if stage == Stage::Plan {
        ui.add_space(4.0);
        cx.button(ui, desk, BliskCommand::Technology, "Technology table\u{2026}", false);
    }
    answer.wanted.map(|key| match key.as_str() {
        "machine.name" => Request::Machine,
        "export.post" => Request::Post,
        "export.job_sheet" => Request::JobSheet,
        "technology.table" => Request::Technology,
        "blisk.sections.file" => Request::Sections,
        "burning.blank" => Request::Blank,
        "scan.file" => Request::Scan,
        "setup.presets" => Request::Presets,
        _ => Request::ElectrodeMesh(key),
    })
}

/// Whether a field of `stage` says that its value cannot be taken.
pub fn has_problem(desk: &BliskDesk, stage: Stage) -> bool {
    let job = FIELDS.values(desk.document.params());
    let mut fields = FIELDS.groups(stage.name()).flat_map(|group| group.fields).filter(|field| field.is_shown(&job));
    fields.any(|field| field.check(field.key, get(&job, field.key)).is_err())
}

/// Label of a choice, or the name of its file.
pub fn shown_choice(words: &[Word], now: &str) -> String {
    let shown = words.iter().find(|word| word.word == now).map(|word| word.label.to_owned());
    shown.unwrap_or_else(|| file_name(now))
}
