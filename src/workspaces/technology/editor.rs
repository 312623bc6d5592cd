//! The window in which the technology table of a project is looked at and edited.
//!
//! A change goes into the file of the table at once, and can be undone. A table that is not possible is not taken; the window
//! says why. The built-in table cannot be changed, but copied.

use std::path::{Path, PathBuf};

use burning::duration::Calibrated;
use burning::project::ProjectTechnology;
use burning::technology::{TECHNOLOGY_FILE, Technology, TechnologyFile};
use egui::{RichText, ScrollArea, Ui};
use files::{FileError, History, Invalid, Validate, write_bytes};

use super::fields::{FIELDS, tidied};
use super::{is_table, plots, read_table};
use crate::widgets::form::Form;
use crate::widgets::panel_parts::{file_name, notice};
use crate::widgets::theme::palette;
use crate::workspaces::context::{Context, PathSet, Request};
use crate::workspaces::message::Message;
use crate::workspaces::news::EventKind;

/// Ending that is added to the name of a file for the copy of it as it was when it was opened.
const BACKUP: &str = ".bak";
/// Name that is proposed for a copy of a table.
const COPY_NAME: &str = "technology.toml";

/// The window of the technology table, which may be closed.
#[derive(Default)]
pub struct TechnologyWindow {
    /// Content of the window. A closed window keeps a table that could not be written.
    editor: Option<TechnologyEditor>,
    is_open: bool,
}

/// Change that the project takes in.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum TableChange {
    /// The project is to use the technology of this identifier, of a table that may have changed.
    Use(String),
    /// The file of the table has changed.
    Figures,
}

impl TechnologyWindow {
    /// Opens the window, or closes it.
    pub fn toggle(&mut self) {
        if self.is_open {
            self.close();
        } else {
            self.is_open = true;
        }
    }

    fn close(&mut self) {
        self.is_open = false;
        self.editor.take_if(|editor| editor.unwritten.is_none());
    }

    /// Reads the table of `project`, unless it is the one that is shown.
    fn follow(&mut self, project: &ProjectTechnology, cx: &mut Context) {
        if self.editor.as_ref().is_some_and(|editor| editor.name == project.table) {
            return;
        }
        if let Some(why) = self.editor.take().and_then(|editor| editor.unwritten) {
            cx.say(EventKind::Failed, format!("changes of the technology table were not written: {why}"));
        }
        match TechnologyEditor::open(project) {
            Ok(editor) => self.editor = Some(editor),
            Err(error) => {
                self.is_open = false;
                cx.error("The technology table cannot be read", error.to_string());
            }
        }
    }

    /// Draws the window of the table of `project`, if it is open. It asks for another table by the path `choose`, for a copy of
    /// the table by `copy`.
    pub fn show<P: PathSet>(
        &mut self,
        ui: &Ui,
        project: &ProjectTechnology,
        cx: &mut Context,
        [choose, copy]: [P; 2],
    ) -> Option<TableChange> {
        if !self.is_open {
            return None;
        }
        self.follow(project, cx);
        match self.editor.as_mut()?.show(ui.ctx(), project)? {
            Wish::Choose => cx.ask(choose, ""),
            Wish::Copy => cx.ask(copy, COPY_NAME),
            Wish::Close => self.close(),
            Wish::ReadAgain => self.editor = None,
            Wish::Take(change) => {
                if project.is_file() {
                    cx.request(Request::Send(Message::TechnologyTable(PathBuf::from(&project.table))));
                }
                return Some(change);
            }
        }
        None
    }

    /// Writes a copy of the table to `path`, or shows why that is not possible. Returns whether it was written.
    pub fn write_copy(&self, path: &Path, cx: &mut Context) -> bool {
        let Some(editor) = &self.editor else { return false };
        let written = TECHNOLOGY_FILE.write(path, &editor.table);
        let is_written = written.is_ok();
        match written {
            Ok(()) => cx.request(Request::Send(Message::TechnologyTable(path.to_owned()))),
            Err(error) => cx.error("The technology table was not written", error.to_string()),
        }
        is_written
    }

    /// Takes the news that the file `table` was changed elsewhere. Returns whether it is the table of `project`, which is then
    /// read again where it is shown. Changes that could not be written stay.
    pub fn is_changed(&mut self, project: &ProjectTechnology, table: &Path) -> bool {
        let is_own = is_table(project, table);
        if is_own {
            self.editor.take_if(|editor| editor.unwritten.is_none());
        }
        is_own
    }
}

/// The technology table of a project in its window.
struct TechnologyEditor {
    /// Table as the project names it.
    name: String,
    /// Table as it is shown: a possible one.
    table: TechnologyFile,
    /// File of the table; none of the built-in one.
    file: Option<OwnFile>,
    /// Number of the shown technology.
    shown: usize,
    history: History<TechnologyFile>,
    /// Table before a gesture that goes on.
    before_gesture: Option<TechnologyFile>,
    /// Why the last change was not taken.
    refused: Option<String>,
    /// Why the table was not written.
    unwritten: Option<String>,
}

/// File of a technology table.
struct OwnFile {
    path: PathBuf,
    /// Text of the file as it was read or written last.
    text: String,
    /// Whether its text as it was opened is no longer needed: it is kept beside it, or the program wrote it.
    is_kept: bool,
}

impl OwnFile {
    /// Writes `table`. The file as it was opened is kept beside it.
    fn write(&mut self, table: &TechnologyFile) -> Result<(), String> {
        let now = std::fs::read(&self.path).map_err(|error| FileError::unreadable(&self.path, error).to_string())?;
        if now != self.text.as_bytes() {
            return Err("The file was changed elsewhere since it was read.".to_owned());
        }
        let text = TECHNOLOGY_FILE.text(&self.path, table).map_err(|error| error.to_string())?;
        if !self.is_kept {
            let mut beside = self.path.clone().into_os_string();
            beside.push(BACKUP);
            write_bytes(Path::new(&beside), self.text.as_bytes()).map_err(|error| error.to_string())?;
            self.is_kept = true;
        }
        write_bytes(&self.path, text.as_bytes()).map_err(|error| error.to_string())?;
        self.text = text;
        Ok(())
    }
}

/// Request of the user in the window.
#[derive(Debug, Clone, PartialEq, Eq)]
enum Wish {
    /// To choose another table.
    Choose,
    /// To choose a file for a copy of the table.
    Copy,
    /// To read the file again, and give up what was not written.
    ReadAgain,
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
        let (table, file) = if project.is_file() {
            let path = PathBuf::from(&project.table);
            let text = TECHNOLOGY_FILE.read_text(&path)?;
            let table = TECHNOLOGY_FILE.parse(&text, &path)?;
            let is_kept = TECHNOLOGY_FILE.text(&path, &table)? == text;
            (table, Some(OwnFile { path, text, is_kept }))
        } else {
            (read_table(project)?, None)
        };
        let shown = table.technology.iter().position(|technology| technology.id == project.id).unwrap_or(0);
        Ok(Self {
            name: project.table.clone(),
            table,
            file,
            shown,
            history: History::default(),
            before_gesture: None,
            refused: None,
            unwritten: None,
        })
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
        let mut wish = self.head(ui, project);
        if self.file.is_none() {
            let text = "The built-in table is made from rules and cannot be changed. A copy of it can, as a file.";
            notice(ui, palette(ui).faint, text);
        }
        if let Some(why) = &self.refused {
            notice(ui, palette(ui).bad, &format!("Not taken. {why}"));
        }
        if let Some(why) = &self.unwritten {
            notice(ui, palette(ui).bad, &format!("Not written. {why}"));
            let hint = "Gives up the changes that were not written";
            if ui.button("Read the file again").on_hover_text(hint).clicked() {
                wish = Some(Wish::ReadAgain);
            }
        }
        wish = self.list(ui, project).or(wish);
        ui.separator();
        let scroll = ScrollArea::both().auto_shrink([false, false]);
        let frame = egui::Frame::new().inner_margin(egui::Margin { right: 12, ..Default::default() });
        wish = scroll.show(ui, |ui| frame.show(ui, |ui| self.technology(ui, project)).inner).inner.or(wish);
        if !ui.input(|i| i.pointer.any_down())
            && let Some(before) = self.before_gesture.take()
        {
            self.history.end_gesture();
            wish = self.write(&before, project).or(wish);
        }
        wish
    }

    fn head(&mut self, ui: &mut Ui, project: &ProjectTechnology) -> Option<Wish> {
        let mut wish = None;
        ui.horizontal(|ui| {
            match &self.file {
                Some(OwnFile { path, .. }) => {
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
                let before = std::mem::replace(&mut self.table, table);
                self.shown = self.shown.min(self.table.technology.len().saturating_sub(1));
                (self.refused, self.before_gesture) = (None, None);
                wish = self.write(&before, project).or(wish.take());
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
                wish = self.changed("Duplicate a technology", before, project, false);
            }
            let can_go = is_own && self.table.technology.get(self.shown).is_some_and(|shown| shown.id != project.id);
            let hint = "One that the project uses stays";
            if ui.add_enabled(can_go, egui::Button::new("Remove")).on_disabled_hover_text(hint).clicked() {
                let before = self.table.clone();
                let gone = self.table.technology.remove(self.shown);
                self.table.calibration.retain(|burn| burn.technology != gone.id);
                self.shown = self.shown.min(self.table.technology.len() - 1);
                wish = self.changed("Remove a technology", before, project, false);
            }
        });
        wish
    }

    /// Takes a change of the table from `before`, unless the table is not possible now.
    fn changed(
        &mut self,
        label: &str,
        before: TechnologyFile,
        project: &ProjectTechnology,
        in_gesture: bool,
    ) -> Option<Wish> {
        if let Err(problem) = self.table.validate() {
            self.refused = Some(in_words(&self.table, &problem));
            self.table = before;
            self.shown = self.shown.min(self.table.technology.len().saturating_sub(1));
            return None;
        }
        self.refused = None;
        self.history.record(label, &before, in_gesture);
        let before = self.before_gesture.take().unwrap_or(before);
        if in_gesture {
            self.before_gesture = Some(before);
            return None;
        }
        self.write(&before, project)
    }

    /// Writes a change of the table from `before`. A project follows its technology that is called otherwise now.
    fn write(&mut self, before: &TechnologyFile, project: &ProjectTechnology) -> Option<Wish> {
        self.unwritten = self.file.as_mut()?.write(&self.table).err();
        if self.unwritten.is_some() {
            return None;
        }
        let of_project = before.technology.iter().position(|technology| technology.id == project.id);
        let now = of_project.and_then(|i| self.table.technology.get(i));
        match now.filter(|_| self.table.get(&project.id).is_none()) {
            Some(now) => Some(Wish::Take(TableChange::Use(now.id.clone()))),
            None => Some(FIGURES),
        }
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

    /// Draws the shown technology.
    fn technology(&mut self, ui: &mut Ui, project: &ProjectTechnology) -> Option<Wish> {
        let shown = self.of_shown()?;
        let mut form = Form::new(&FIELDS, &shown, None);
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
        if let Some(said) = answer.said {
            self.refused = Some(said);
        }
        let edit = answer.edit?;
        let params = tidied(edit.params);
        if params == shown {
            return None;
        }
        let before = self.table.clone();
        self.take(params);
        self.changed(&edit.label, before, project, edit.in_gesture)
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
}

/// Problem of a table in words, with the title of the technology in place of its number.
fn in_words(table: &TechnologyFile, problem: &Invalid) -> String {
    let place = problem.key.strip_prefix("technology[").and_then(|rest| rest.split_once(']'));
    let found = place.and_then(|(i, rest)| Some((table.technology.get(i.parse::<usize>().ok()?)?, rest)));
    let Some((technology, rest)) = found else { return FIELDS.in_window(problem) };
    let of_one = Invalid { key: format!("technology[0]{rest}"), ..problem.clone() };
    format!("{}: {}", technology.label(), FIELDS.in_window(&of_one))
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

    fn burn(technology: &str) -> Calibration {
        let technology = technology.to_owned();
        Calibration { technology, estimated_min: 10.0, measured_min: 12.0, date: None, source: None }
    }

    /// Changes the shown technology as the form does.
    fn edit(
        editor: &mut TechnologyEditor,
        project: &ProjectTechnology,
        in_gesture: bool,
        change: impl FnOnce(&mut TechnologyFile),
    ) -> Option<Wish> {
        let (before, mut of_shown) = (editor.table.clone(), editor.of_shown().unwrap());
        change(&mut of_shown);
        editor.take(of_shown);
        editor.changed("Change", before, project, in_gesture)
    }

    fn beside(project: &ProjectTechnology) -> String {
        std::fs::read_to_string(format!("{}{BACKUP}", project.table)).unwrap_or_default()
    }

    #[test]
    fn the_built_in_table_is_shown_and_not_changed() {
        let project = ProjectTechnology::default();
        let mut editor = TechnologyEditor::open(&project).unwrap();
        assert_eq!(editor.table.technology[editor.shown].id, project.id);
        let before = editor.table.clone();
        assert_eq!(editor.write(&before, &project), None);
    }

    #[test]
    fn a_change_goes_into_the_file_and_the_file_as_it_was_beside_it() {
        let folder = tempfile::tempdir().unwrap();
        let (project, mut editor) = own(folder.path());
        let change = |of: &mut TechnologyFile| {
            of.technology[0].step[0].wear_percent = Some(0.0);
            of.calibration.push(burn(""));
        };
        assert_eq!(edit(&mut editor, &project, false, change), Some(FIGURES));
        let read = TECHNOLOGY_FILE.read(Path::new(&project.table)).unwrap();
        let of_project = read.get(&project.id).unwrap();
        assert_eq!(of_project.step[0].wear_percent, Some(0.0), "a figure of zero is no missing one");
        assert_eq!(read.calibrations_of(&project.id).count(), 1);
        assert!(beside(&project).starts_with("# by hand"));
        // Opened again, the file is what the program wrote: what was written by hand is kept.
        let mut again = TechnologyEditor::open(&project).unwrap();
        edit(&mut again, &project, false, |of| of.technology[0].step[0].vdi = Some(40.0)).unwrap();
        assert!(beside(&project).starts_with("# by hand"));
        // Changed by hand and opened again, it is kept again.
        let text = std::fs::read_to_string(&project.table).unwrap();
        std::fs::write(&project.table, format!("# once more\n{text}")).unwrap();
        let mut again = TechnologyEditor::open(&project).unwrap();
        edit(&mut again, &project, false, |of| of.technology[0].step[0].vdi = Some(41.0)).unwrap();
        assert!(beside(&project).starts_with("# once more"));
    }

    #[test]
    fn what_is_not_possible_is_not_taken() {
        let folder = tempfile::tempdir().unwrap();
        let (project, mut editor) = own(folder.path());
        let (text, before) = (std::fs::read(&project.table).unwrap(), editor.table.clone());
        let others = editor.table.technology[0].id.clone();
        assert_ne!(others, project.id);
        assert_eq!(edit(&mut editor, &project, false, |of| of.technology[0].step[0].ip_a = Some(-1.0)), None);
        let why = editor.refused.clone().unwrap();
        assert!(why.contains(editor.table.technology[editor.shown].label()) && why.contains("Current"), "{why}");
        // Its burns would be those of the other one as well.
        assert_eq!(edit(&mut editor, &project, false, |of| of.technology[0].id = others), None);
        assert_eq!((editor.table, std::fs::read(&project.table).unwrap()), (before, text));
    }

    #[test]
    fn a_gesture_is_written_once_at_its_end() {
        let folder = tempfile::tempdir().unwrap();
        let (project, mut editor) = own(folder.path());
        let text = || std::fs::read(&project.table).unwrap();
        let before = text();
        for current in [81.0, 82.0, 83.0] {
            let wish = edit(&mut editor, &project, true, |of| of.technology[0].step[0].ip_a = Some(current));
            assert_eq!((wish, text() == before), (None, true));
        }
        let from = editor.before_gesture.take().unwrap();
        assert_eq!(editor.write(&from, &project), Some(FIGURES));
        assert_eq!(editor.history.undo(&editor.table), Some(from), "one step");
    }

    #[test]
    fn what_others_wrote_meanwhile_is_not_overwritten() {
        let folder = tempfile::tempdir().unwrap();
        let (project, mut editor) = own(folder.path());
        let theirs = format!("{}\n# theirs\n", std::fs::read_to_string(&project.table).unwrap());
        std::fs::write(&project.table, &theirs).unwrap();
        assert_eq!(edit(&mut editor, &project, false, |of| of.technology[0].step[0].vdi = Some(40.0)), None);
        assert!(editor.unwritten.is_some_and(|why| why.contains("changed elsewhere")));
        assert_eq!(std::fs::read_to_string(&project.table).unwrap(), theirs);
    }

    #[test]
    fn the_project_follows_a_technology_that_is_called_otherwise() {
        let folder = tempfile::tempdir().unwrap();
        let (project, mut editor) = own(folder.path());
        editor.table.calibration.push(burn(&project.id));
        let take = |id: &str| Some(Wish::Take(TableChange::Use(id.to_owned())));
        assert_eq!(edit(&mut editor, &project, false, |of| of.technology[0].id = "mine".to_owned()), take("mine"));
        assert_eq!(editor.table.calibrations_of("mine").count(), 1, "its burns go along");
        assert_eq!(editor.table.calibration.len(), 1);
        let renamed = ProjectTechnology { id: "mine".to_owned(), ..project.clone() };
        let table = editor.history.undo(&editor.table).unwrap();
        let before = std::mem::replace(&mut editor.table, table);
        assert_eq!(editor.write(&before, &renamed), take(&project.id), "and back");
        let copy = editor.free_copy(editor.shown);
        assert!(editor.table.get(&copy.id).is_none() && copy.step == editor.table.technology[editor.shown].step);
    }
}
