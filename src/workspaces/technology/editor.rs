//! The window in which the technology table of a project is looked at and edited.
//!
//! A change goes into the file of the table at once, and can be undone. A table that is not possible is not written; the
//! window says so, and what is wrong. The built-in table cannot be changed, but copied.

use std::path::{Path, PathBuf};

use burning::duration::Calibrated;
use burning::project::ProjectTechnology;
use burning::technology::{TECHNOLOGY_FILE, Technology, TechnologyFile};
use egui::{RichText, ScrollArea, Ui};
use files::{FileError, History, Invalid, Validate, write_bytes};

use super::fields::FIELDS;
use super::{plots, read_table};
use crate::widgets::form::Form;
use crate::widgets::panel_parts::{file_name, notice};
use crate::widgets::theme::palette;
use crate::workspaces::context::{Context, PathSet};

/// Ending of the copy of a file as it was when it was opened.
const BACKUP: &str = "toml.bak";

/// Name that is proposed for a copy of a table.
const COPY_NAME: &str = "technology.toml";

/// The window of the technology table, which may be closed.
#[derive(Default)]
pub struct TechnologyWindow(Option<TechnologyEditor>);

/// Change that the project takes in.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum TableChange {
    /// The project is to use the technology of this identifier, of a table that may have changed.
    Use(String),
    /// The file of the table has changed.
    Figures,
}

impl TechnologyWindow {
    /// Opens the window for the table of `project`, or shows why the table cannot be read; closes an open window.
    pub fn toggle(&mut self, project: &ProjectTechnology, cx: &mut Context) {
        if self.0.take().is_none() {
            self.open(project, cx);
        }
    }

    /// Shows the table of `project`, which is another one now, if the window is open.
    pub fn turn_to(&mut self, project: &ProjectTechnology, cx: &mut Context) {
        if self.0.is_some() {
            self.open(project, cx);
        }
    }

    fn open(&mut self, project: &ProjectTechnology, cx: &mut Context) {
        match TechnologyEditor::open(project) {
            Ok(editor) => self.0 = Some(editor),
            Err(error) => cx.error("The technology table cannot be read", error.to_string()),
        }
    }

    /// Draws the window if it is open. It asks for another table by the path `choose`, for a copy of the table by `copy`.
    pub fn show<P: PathSet>(
        &mut self,
        ui: &Ui,
        project: &ProjectTechnology,
        cx: &mut Context,
        [choose, copy]: [P; 2],
    ) -> Option<TableChange> {
        match self.0.as_mut()?.show(ui.ctx(), project)? {
            Wish::Choose => cx.ask(choose, ""),
            Wish::Copy => cx.ask(copy, COPY_NAME),
            Wish::Close => self.0 = None,
            Wish::Take(change) => return Some(change),
        }
        None
    }

    /// Writes a copy of the table to `path`, or shows why that is not possible. Returns whether it was written.
    pub fn write_copy(&self, path: &Path, cx: &mut Context) -> bool {
        let Some(editor) = &self.0 else { return false };
        let written = TECHNOLOGY_FILE.write(path, &editor.table);
        let is_written = written.is_ok();
        written.unwrap_or_else(|error| cx.error("The technology table was not written", error.to_string()));
        is_written
    }
}

/// The technology table of a project in its window.
struct TechnologyEditor {
    /// Table as it is shown, which may not be possible.
    table: TechnologyFile,
    /// File of the table, with its content when it was opened; none for the built-in one.
    file: Option<(PathBuf, Vec<u8>)>,
    /// Number of the shown technology.
    shown: usize,
    history: History<TechnologyFile>,
    /// Why the table was not written.
    unwritten: Option<String>,
}

/// Request of the user in the window.
#[derive(Debug, Clone, PartialEq, Eq)]
enum Wish {
    /// To choose another table.
    Choose,
    /// To choose a file for a copy of the table.
    Copy,
    /// To take a change into the project.
    Take(TableChange),
    /// To close the window.
    Close,
}

const FIGURES: Wish = Wish::Take(TableChange::Figures);

impl TechnologyEditor {
    /// The window for the table of `project`, with the technology of the project.
    ///
    /// # Errors
    /// [`FileError`] if it is a file that cannot be read or is no technology table.
    fn open(project: &ProjectTechnology) -> Result<Self, FileError> {
        let table = read_table(project)?;
        let file = project.is_file().then(|| PathBuf::from(&project.table));
        let content = |path: PathBuf| match std::fs::read(&path) {
            Ok(bytes) => Ok((path, bytes)),
            Err(error) => Err(FileError::unreadable(&path, error)),
        };
        let file = file.map(content).transpose()?;
        let shown = table.technology.iter().position(|technology| technology.id == project.id).unwrap_or(0);
        Ok(Self { table, file, shown, history: History::default(), unwritten: None })
    }

    /// Draws the window.
    fn show(&mut self, ctx: &egui::Context, project: &ProjectTechnology) -> Option<Wish> {
        let mut is_open = true;
        let room = ctx.content_rect().size() - egui::vec2(40.0, 80.0);
        let size = egui::vec2(room.x.min(1400.0), room.y.min(760.0));
        let at = ctx.content_rect().center() - 0.5 * size;
        let window = egui::Window::new("Technology table").open(&mut is_open).default_size(size).max_size(room);
        let window = window.default_pos(at).collapsible(false);
        let shown = window.show(ctx, |ui| self.contents(ui, project));
        let wish = shown.and_then(|shown| shown.inner).flatten();
        wish.or((!is_open).then_some(Wish::Close))
    }

    fn contents(&mut self, ui: &mut Ui, project: &ProjectTechnology) -> Option<Wish> {
        let mut wish = self.head(ui);
        if self.file.is_none() {
            let text = "The built-in table is made from rules and cannot be changed. A copy of it can, as a file.";
            notice(ui, palette(ui).faint, text);
        }
        if let Some(why) = &self.unwritten {
            notice(ui, palette(ui).bad, &format!("Not written. {why}"));
        }
        wish = self.list(ui, project).or(wish);
        ui.separator();
        let scroll = ScrollArea::both().auto_shrink([false, false]);
        let frame = egui::Frame::new().inner_margin(egui::Margin { right: 12, ..Default::default() });
        let changed = scroll.show(ui, |ui| frame.show(ui, |ui| self.technology(ui)).inner).inner;
        changed.then(|| self.write(project)).flatten().or(wish)
    }

    fn head(&mut self, ui: &mut Ui) -> Option<Wish> {
        let mut wish = None;
        ui.horizontal(|ui| {
            match &self.file {
                Some((path, _)) => {
                    let name = ui.strong(file_name(&path.to_string_lossy()));
                    name.on_hover_text(format!("{}\nComments of the file go once it is changed.", path.display()));
                }
                None => drop(ui.strong("built-in")),
            }
            ui.add_space(12.0);
            if ui.button("Other table…").clicked() {
                wish = Some(Wish::Choose);
            }
            if ui.button("Save a copy…").on_hover_text("The project then uses the copy").clicked() {
                wish = Some(Wish::Copy);
            }
            let [undo, redo] =
                [self.history.undo_label(), self.history.redo_label()].map(|label| label.map(str::to_owned));
            let go = |ui: &mut Ui, name: &str, label: Option<String>| {
                let button = ui.add_enabled(label.is_some(), egui::Button::new(name));
                button.on_hover_text(label.unwrap_or_default()).clicked()
            };
            let back = go(ui, "Undo", undo);
            let again = go(ui, "Redo", redo);
            let table = match (back, again) {
                (true, _) => self.history.undo(&self.table),
                (_, true) => self.history.redo(&self.table),
                _ => None,
            };
            if let Some(table) = table {
                self.table = table;
                self.shown = self.shown.min(self.table.technology.len().saturating_sub(1));
                wish = self.put_in_file().then_some(FIGURES).or(wish.take());
            }
        });
        ui.add_space(4.0);
        wish
    }

    /// Draws the choice of the technology that is shown, and what can be done with it.
    fn list(&mut self, ui: &mut Ui, project: &ProjectTechnology) -> Option<Wish> {
        let mut wish = None;
        ui.horizontal(|ui| {
            let all = &self.table.technology;
            let used = |technology: &Technology| if technology.id == project.id { ", in use" } else { "" };
            let name = |technology: &Technology| format!("{}{}", technology.label(), used(technology));
            let now = all.get(self.shown).map(name).unwrap_or_default();
            let list = egui::ComboBox::from_id_salt("technologies").selected_text(now).width(300.0);
            let list = list.show_ui(ui, |ui| {
                for (i, technology) in all.iter().enumerate() {
                    let response = ui.selectable_label(i == self.shown, name(technology));
                    if response.on_hover_text(format!("{}, {}", technology.id, technology.basis)).clicked() {
                        self.shown = i;
                    }
                }
            });
            list.response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::ComboBox, true, "Technology"));
            let Some(shown) = self.table.technology.get(self.shown) else { return };
            let hint = "Estimates of the project rest on the technology that it uses";
            let can_use = shown.id != project.id && self.unwritten.is_none();
            if ui.add_enabled(can_use, egui::Button::new("Use in the project")).on_hover_text(hint).clicked() {
                wish = Some(Wish::Take(TableChange::Use(shown.id.clone())));
            }
            let is_own = self.file.is_some();
            if ui.add_enabled(is_own, egui::Button::new("Duplicate")).clicked() {
                let (copy, before) = (self.free_copy(self.shown), self.table.clone());
                self.table.technology.insert(self.shown + 1, copy);
                self.shown += 1;
                wish = self.changed("Duplicate a technology", &before);
            }
            let can_go = is_own && self.table.technology.len() > 1;
            if ui.add_enabled(can_go, egui::Button::new("Remove")).clicked() {
                let before = self.table.clone();
                let gone = self.table.technology.remove(self.shown);
                self.table.calibration.retain(|burn| burn.technology != gone.id);
                self.shown = self.shown.min(self.table.technology.len() - 1);
                wish = self.changed("Remove a technology", &before);
            }
        });
        wish
    }

    fn changed(&mut self, label: &str, before: &TechnologyFile) -> Option<Wish> {
        self.history.record(label, before, false);
        self.put_in_file().then_some(FIGURES)
    }

    /// A copy of a technology with an identifier that none has.
    fn free_copy(&self, i: usize) -> Technology {
        let of = &self.table.technology[i];
        let is_free = |id: &String| self.table.get(id).is_none();
        let id = (2..).map(|n| format!("{}-{n}", of.id)).find(is_free).unwrap_or_default();
        let title = if of.title.is_empty() { String::new() } else { format!("{}, copy", of.title) };
        Technology { id, title, ..of.clone() }
    }

    /// The shown technology with its finished burns as a table of its own.
    fn of_shown(&self) -> Option<TechnologyFile> {
        let technology = self.table.technology.get(self.shown)?.clone();
        let calibration = self.table.calibrations_of(&technology.id).cloned().collect();
        Some(TechnologyFile { technology: vec![technology], calibration })
    }

    /// Draws the shown technology. Returns whether it was changed.
    fn technology(&mut self, ui: &mut Ui) -> bool {
        let Some(shown) = self.of_shown() else { return false };
        let problem = shown.validate().err().or_else(|| self.not_unique());
        let mut form = Form::new(&FIELDS, &shown, problem.as_ref());
        ui.add_enabled_ui(self.file.is_some(), |ui| {
            ui.columns(2, |columns| {
                form.group(&mut columns[0], "What it is for");
                form.group(&mut columns[1], "What it rests on");
            });
            ui.separator();
            form.section(ui, "Steps");
        });
        ui.add_space(6.0);
        plots::show(ui, &shown.technology[0].step);
        ui.separator();
        ui.add_enabled_ui(self.file.is_some(), |ui| form.section(ui, "Burns"));
        ui.label(RichText::new(calibrated_text(&shown)).color(palette(ui).faint));
        let answer = form.answer();
        let Some(edit) = answer.edit.map(|edit| (tidied(edit.params), edit.label, edit.in_gesture)) else {
            if ui.input(|i| i.pointer.any_released()) {
                self.history.end_gesture();
            }
            return false;
        };
        let (params, label, in_gesture) = edit;
        if params == shown {
            return false;
        }
        self.history.record(&label, &self.table, in_gesture);
        self.take(params);
        true
    }

    /// Puts a technology in the place of the shown one, with its finished burns.
    fn take(&mut self, mut of_shown: TechnologyFile) {
        let Some(technology) = of_shown.technology.pop() else { return };
        let before = std::mem::replace(&mut self.table.technology[self.shown], technology);
        let id = &self.table.technology[self.shown].id;
        self.table.calibration.retain(|burn| burn.technology != before.id);
        self.table.calibration.extend(of_shown.calibration.into_iter().map(|mut burn| {
            burn.technology.clone_from(id);
            burn
        }));
    }

    /// Why the shown technology cannot be told from another one.
    fn not_unique(&self) -> Option<Invalid> {
        let id = &self.table.technology.get(self.shown)?.id;
        let count = self.table.technology.iter().filter(|technology| technology.id == *id).count();
        (count > 1).then(|| Invalid::new("technology[0].id", id, "another technology has it; give each its own"))
    }

    /// Writes a change of the shown technology, of which the project may know the former identifier.
    fn write(&mut self, project: &ProjectTechnology) -> Option<Wish> {
        if !self.put_in_file() {
            return None;
        }
        let is_known = self.table.get(&project.id).is_some();
        let id = || self.table.technology[self.shown].id.clone();
        Some(if is_known { FIGURES } else { Wish::Take(TableChange::Use(id())) })
    }

    /// Writes the table to its file, if it is possible. The file as it was is kept beside it.
    fn put_in_file(&mut self) -> bool {
        let Some((path, opened)) = &self.file else { return false };
        let written = self.table.validate().map_err(|problem| in_words(&self.table, &problem)).and_then(|()| {
            let backup = path.with_extension(BACKUP);
            let kept = if backup.exists() { Ok(()) } else { write_bytes(&backup, opened) };
            kept.and_then(|()| TECHNOLOGY_FILE.write(path, &self.table)).map_err(|error| error.to_string())
        });
        self.unwritten = written.err();
        self.unwritten.is_none()
    }
}

/// What is wrong with a table, with the title of the technology in place of its number.
fn in_words(table: &TechnologyFile, problem: &Invalid) -> String {
    let place = problem.key.strip_prefix("technology[").and_then(|rest| rest.split_once(']'));
    let found = place.and_then(|(i, rest)| Some((table.technology.get(i.parse::<usize>().ok()?)?, rest)));
    let Some((technology, rest)) = found else { return FIELDS.in_window(problem) };
    let of_one = Invalid { key: format!("technology[0]{rest}"), ..problem.clone() };
    format!("{}: {}", technology.label(), FIELDS.in_window(&of_one))
}

/// Empty texts are none.
fn tidied(mut table: TechnologyFile) -> TechnologyFile {
    let tidy = |text: &mut Option<String>| drop(text.take_if(|text| text.trim().is_empty()));
    for technology in &mut table.technology {
        let Technology { machine, generator, licence, date, electrode_grade, dielectric, flushing, .. } = technology;
        [machine, generator, licence, date, electrode_grade, dielectric, flushing].into_iter().for_each(tidy);
        technology.step.iter_mut().for_each(|step| tidy(&mut step.vendor_code));
    }
    for burn in &mut table.calibration {
        [&mut burn.date, &mut burn.source].into_iter().for_each(tidy);
    }
    table
}

/// By what finished burns scale the estimates of a technology.
fn calibrated_text(of_one: &TechnologyFile) -> String {
    match Calibrated::from_burns(&of_one.calibration) {
        Err(_) => "The finished burns are not possible.".to_owned(),
        Ok(None) => "Without finished burns, estimates are not scaled.".to_owned(),
        Ok(Some(Calibrated { count, mean, least, greatest })) => {
            let spread = least.zip(greatest).map(|(least, greatest)| format!(", {least:.3} to {greatest:.3}"));
            let burns = if count == 1 { "burn" } else { "burns" };
            format!("{count} finished {burns}: estimates are multiplied by {mean:.3}{}.", spread.unwrap_or_default())
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use burning::technology::Calibration;

    fn own(folder: &Path) -> (ProjectTechnology, TechnologyEditor) {
        let file = folder.join("own.toml");
        let text = format!("# by hand\n{}", toml::to_string(&burning::defaults::standard().unwrap()).unwrap());
        std::fs::write(&file, text).unwrap();
        let project = ProjectTechnology { table: file.to_string_lossy().into_owned(), ..ProjectTechnology::default() };
        let editor = TechnologyEditor::open(&project).unwrap();
        (project, editor)
    }

    #[test]
    fn the_built_in_table_is_shown_and_not_changed() {
        let mut editor = TechnologyEditor::open(&ProjectTechnology::default()).unwrap();
        assert_eq!(editor.table.technology[editor.shown].id, ProjectTechnology::default().id);
        assert!(!editor.put_in_file());
    }

    #[test]
    fn a_change_goes_into_the_file_and_the_file_as_it_was_beside_it() {
        let folder = tempfile::tempdir().unwrap();
        let (project, mut editor) = own(folder.path());
        let path = PathBuf::from(&project.table);
        let mut of_shown = editor.of_shown().unwrap();
        of_shown.technology[0].step[0].wear_percent = Some(0.0);
        let burn = Calibration {
            technology: String::new(),
            estimated_min: 10.0,
            measured_min: 12.0,
            date: None,
            source: None,
        };
        of_shown.calibration.push(burn);
        editor.take(of_shown);
        assert_eq!(editor.write(&project), Some(FIGURES));
        let read = TECHNOLOGY_FILE.read(&path).unwrap();
        let of_project = read.get(&project.id).unwrap();
        assert_eq!(of_project.step[0].wear_percent, Some(0.0), "a figure of zero is no missing one");
        assert_eq!(read.calibrations_of(&project.id).count(), 1);
        assert!(std::fs::read_to_string(path.with_extension(BACKUP)).unwrap().starts_with("# by hand"));
    }

    #[test]
    fn what_is_not_possible_stays_in_the_window() {
        let folder = tempfile::tempdir().unwrap();
        let (project, mut editor) = own(folder.path());
        let before = std::fs::read(&project.table).unwrap();
        let mut of_shown = editor.of_shown().unwrap();
        of_shown.technology[0].step[0].ip_a = Some(-1.0);
        editor.take(of_shown);
        assert_eq!(editor.write(&project), None);
        let why = editor.unwritten.clone().unwrap();
        assert!(why.contains(editor.table.technology[editor.shown].label()) && why.contains("Current"), "{why}");
        assert_eq!(std::fs::read(&project.table).unwrap(), before);
    }

    #[test]
    fn the_project_follows_a_technology_that_is_called_otherwise() {
        let folder = tempfile::tempdir().unwrap();
        let (project, mut editor) = own(folder.path());
        let burn = Calibration {
            technology: project.id.clone(),
            estimated_min: 10.0,
            measured_min: 12.0,
            date: None,
            source: None,
        };
        editor.table.calibration.push(burn);
        let mut of_shown = editor.of_shown().unwrap();
        of_shown.technology[0].id = "mine".to_owned();
        editor.take(of_shown);
        assert_eq!(editor.write(&project), Some(Wish::Take(TableChange::Use("mine".to_owned()))));
        assert_eq!(editor.table.calibrations_of("mine").count(), 1, "its burns go along");
        assert_eq!(editor.table.calibration.len(), 1);
        let copy = editor.free_copy(editor.shown);
        assert!(editor.table.get(&copy.id).is_none() && copy.step == editor.table.technology[editor.shown].step);
    }
}
