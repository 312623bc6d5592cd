//! The window of studies: a study of the project that is shown, its table and the Pareto front. A row gives its parameters back.

use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, channel};
use std::sync::{Arc, Mutex, PoisonError};

use egui::{Align, Layout, RichText, Role, Ui, WidgetInfo};
use egui_extras::{Column, TableBuilder};
use egui_plot::{Plot, PlotPoints, Points};

use crate::study::base::{Base, varied_fields};
use crate::study::definition::{Collect, Method, Parameter, Sampling, Study, StudyCommand, StudyKind};
use crate::study::folder::{STUDY, StudyError, StudyFolder};
use crate::study::plots::scatter_of;
use crate::study::table::{PAGE, Row, Table, shown};
use crate::widgets::panel_parts::notice;
use crate::widgets::theme::palette;
use crate::workspaces::context::{PathInfo, PathKind};
use crate::workspaces::workspace::Workspace;
use task::{Cancel, Task};

/// Folder that a study is run in.
pub static RUN_IN: PathInfo = PathInfo::new("Folder of the study", PathKind::Folder);
/// Folder of a study that is looked at.
pub static LOOK_AT: PathInfo = PathInfo::new("Folder of a study", PathKind::Folder);

/// Request of the window of studies to the program.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum StudyAnswer {
    /// A folder to run the study in.
    FolderToRun,
    /// The folder of a study to look at.
    FolderToSee,
    /// The parameters of this point: its number and its project.
    Take(usize, PathBuf),
}

/// The window of studies.
#[derive(Default)]
pub struct StudyWindow {
    /// Whether the window is shown.
    pub is_open: bool,
    form: Form,
    running: Option<Running>,
    seen: Option<(PathBuf, Table)>,
    problem: Option<String>,
}

/// The study as it is typed.
struct Form {
    command: StudyCommand,
    sampling: Sampling,
    rows: Vec<FormRow>,
    less: String,
    more: String,
}

impl Default for Form {
    fn default() -> Self {
        Self {
            command: StudyCommand::Plan,
            sampling: Sampling::default(),
            rows: vec![FormRow::default()],
            less: String::new(),
            more: String::new(),
        }
    }
}

/// A parameter as it is typed.
#[derive(Debug, Clone, Default)]
struct FormRow {
    key: String,
    values: String,
}

/// A study under way.
struct Running {
    cancel: Cancel,
    progress: Arc<Mutex<(f64, String)>>,
    ended: Receiver<Result<(PathBuf, Table), String>>,
}

impl Drop for Running {
    fn drop(&mut self) {
        self.cancel.cancel();
    }
}

/// Commands of a workspace.
fn commands(kind: &str) -> &'static [StudyCommand] {
    match kind {
        "blisk" => &[StudyCommand::Plan, StudyCommand::Size],
        "mold" => &[StudyCommand::Uncut, StudyCommand::Electrodes],
        _ => &[],
    }
}

impl StudyWindow {
    /// Whether a study is under way.
    pub fn is_busy(&self) -> bool {
        self.running.is_some()
    }

    /// The table that is shown.
    pub fn table(&self) -> Option<&Table> {
        self.seen.as_ref().map(|(_, table)| table)
    }

    /// Draws the window for the workspace that is shown.
    pub fn show(&mut self, ctx: &egui::Context, here: &dyn Workspace) -> Option<StudyAnswer> {
        self.follow();
        let mut is_open = self.is_open;
        let room = ctx.content_rect().size();
        // The colour of panels, against which text fields can be seen.
        let frame = egui::Frame::window(&ctx.global_style()).fill(ctx.global_style().visuals.panel_fill);
        let window = egui::Window::new("Study")
            .frame(frame)
            .open(&mut is_open)
            .default_pos([80.0, 60.0])
            .default_size([680.0, 560.0])
            .max_size(room * 0.9);
        let shown = window.show(ctx, |ui| egui::ScrollArea::vertical().show(ui, |ui| self.contents(ui, here)).inner);
        self.is_open = is_open;
        shown.and_then(|shown| shown.inner).flatten()
    }

    /// Takes in what the study under way has ended with.
    fn follow(&mut self) {
        let Some(ended) = self.running.as_ref().and_then(|running| running.ended.try_recv().ok()) else { return };
        self.running = None;
        match ended {
            Ok(seen) => (self.seen, self.problem) = (Some(seen), None),
            Err(why) => self.problem = Some(why),
        }
    }

    fn contents(&mut self, ui: &mut Ui, here: &dyn Workspace) -> Option<StudyAnswer> {
        let mut answer = None;
        let kind = here.about().id;
        let commands = commands(kind);
        if commands.is_empty() {
            notice(ui, palette(ui).warning, "Studies are of blisks and molds: show one of these workspaces.");
        } else {
            if !commands.contains(&self.form.command) {
                self.form = Form { command: commands[0], ..Form::default() };
            }
            ui.label(
                RichText::new(format!("Of the parameters of {}", here.document().name())).color(palette(ui).faint),
            );
            self.form.show(ui, kind, commands);
        }
        ui.add_space(6.0);
        ui.horizontal(|ui| match &self.running {
            Some(running) => {
                let (fraction, message) = running.progress.lock().unwrap_or_else(PoisonError::into_inner).clone();
                if ui
                    .button("Stop study")
                    .on_hover_text("Points that are done stay; running it again goes on")
                    .clicked()
                {
                    running.cancel.cancel();
                }
                ui.add(egui::ProgressBar::new(fraction as f32).desired_width(160.0));
                ui.label(message);
            }
            None => {
                let run = ui.add_enabled(!commands.is_empty(), egui::Button::new("Run study…"));
                if run.on_hover_text("Asks for a folder; a study that is in it already goes on").clicked() {
                    answer = Some(StudyAnswer::FolderToRun);
                }
                if ui.button("Look at a study…").on_hover_text("The folder of a study, whoever ran it").clicked() {
                    answer = Some(StudyAnswer::FolderToSee);
                }
            }
        });
        if let Some(why) = &self.problem {
            notice(ui, palette(ui).bad, why);
        }
        if let Some((folder, found)) = &self.seen {
            ui.separator();
            let more = format!("{} has more plots", folder.join(PAGE).display());
            ui.label(found.sentence()).on_hover_text(more);
            plot(ui, found);
            if let Some(point) = table(ui, found) {
                let name = format!("points/{point:06}/point.sparkpath");
                answer = Some(StudyAnswer::Take(point, folder.join(name)));
            }
        }
        answer
    }

    /// Sets up the study of the project that is shown in `folder`, and runs it on threads of its own.
    pub fn run(&mut self, folder: &Path, here: &dyn Workspace, ctx: &egui::Context) {
        self.problem = None;
        match self.set_up(folder, here) {
            Ok(study) => self.start(study, true, ctx),
            Err(why) => self.problem = Some(why),
        }
    }

    /// Shows the study in `folder`.
    pub fn look_at(&mut self, folder: &Path, ctx: &egui::Context) {
        self.problem = None;
        match StudyFolder::open(folder) {
            Ok(study) => self.start(study, false, ctx),
            Err(why) => self.problem = Some(why.to_string()),
        }
    }

    fn set_up(&self, folder: &Path, here: &dyn Workspace) -> Result<StudyFolder, String> {
        let study = self.form.study()?;
        // Paths in the text are as seen from its folder.
        let text = here.document().copy(&folder.join("project.sparkpath")).map_err(|e| e.to_string())?;
        let base = Base::parse(here.about().id, &text, folder).map_err(|e| e.to_string())?;
        let own = here.near().and_then(Path::parent).unwrap_or(folder);
        let placed = |problem| files::FileError::invalid(&folder.join(STUDY), problem);
        StudyFolder::set_up(study, &base, own, folder, &placed).map_err(|e| e.to_string())
    }

    fn start(&mut self, study: StudyFolder, is_run: bool, ctx: &egui::Context) {
        let (cancel, progress) = (Cancel::default(), Arc::new(Mutex::new((0.0, String::new()))));
        let (sender, ended) = channel();
        let (shown, at_progress) = (progress.clone(), ctx.clone());
        let report = task::Progress::new(move |update: &task::Update| {
            *shown.lock().unwrap_or_else(PoisonError::into_inner) = (update.fraction, update.message.to_owned());
            at_progress.request_repaint();
        });
        let (task, at_end) = (Task { progress: report, cancel: cancel.clone() }, ctx.clone());
        let work = move || {
            let found = found(&study, is_run, &task).map(|table| (study.folder().to_owned(), table));
            // Nobody listens any more once the window is closed.
            let _ = sender.send(found.map_err(|error| error.to_string()));
            at_end.request_repaint();
        };
        match std::thread::Builder::new().name("study".to_owned()).spawn(work) {
            Ok(_) => self.running = Some(Running { cancel, progress, ended }),
            Err(error) => self.problem = Some(format!("no thread could be started: {error}")),
        }
    }
}

/// Runs what is open of the study, if that is asked for, and puts the answers side by side. A study that is stopped shows those
/// that it has.
fn found(study: &StudyFolder, is_run: bool, task: &Task) -> Result<Table, StudyError> {
    if is_run {
        let ran = study.run(rayon::current_num_threads(), task, &|_| ())?;
        if let Some((point, why)) = ran.failed.first() {
            return Err(StudyError::Internal(format!(
                "point {point} failed and is tried again by the next run: {why}"
            )));
        }
    }
    study.collect()
}

impl Form {
    fn show(&mut self, ui: &mut Ui, kind: &str, commands: &[StudyCommand]) {
        ui.horizontal(|ui| {
            for command in commands {
                ui.selectable_value(&mut self.command, *command, command.title());
            }
            ui.separator();
            for (method, name, hint) in [
                (Method::Grid, "Grid", "Every value of each parameter with every value of the others"),
                (Method::List, "List", "The first values of all, then the second ones, and so on"),
                (Method::Random, "Random", "Points that are drawn independently"),
                (
                    Method::Latin,
                    "Latin hypercube",
                    "One value in each of as many equal parts of a range as there are points",
                ),
            ] {
                ui.selectable_value(&mut self.sampling.method, method, name).on_hover_text(hint);
            }
        });
        match (self.sampling.method.is_drawn(), self.sampling.count) {
            (true, None) => self.sampling.count = Some(20),
            (false, Some(_)) => self.sampling.count = None,
            _ => {}
        }
        if let Some(count) = &mut self.sampling.count {
            ui.horizontal(|ui| {
                let label = ui.label("Points");
                ui.add(egui::DragValue::new(count).range(1..=crate::study::definition::MOST_POINTS))
                    .labelled_by(label.id);
                let label = ui.label("Seed");
                ui.add(egui::DragValue::new(&mut self.sampling.seed)).labelled_by(label.id);
            });
        }
        ui.label(
            RichText::new("Values: 0.08, 0.1, 0.12 or 0..59 or, with a number of values, 0.05..0.2 in 4")
                .small()
                .color(palette(ui).faint),
        );
        let mut removed = None;
        let is_only = self.rows.len() == 1;
        for (i, row) in self.rows.iter_mut().enumerate() {
            ui.horizontal(|ui| {
                key_box(ui, kind, i, &mut row.key);
                let field = egui::TextEdit::singleline(&mut row.values).hint_text("values").desired_width(260.0);
                let name = format!("Values of parameter {}", i + 1);
                ui.add(field).widget_info(|| WidgetInfo::labeled(Role::TextInput, true, &name));
                if !is_only && ui.small_button("Remove").clicked() {
                    removed = Some(i);
                }
            });
        }
        removed.into_iter().for_each(|i| drop(self.rows.remove(i)));
        if ui.small_button("Add parameter").clicked() {
            self.rows.push(FormRow::default());
        }
        let results = crate::study::evaluate::named_results(self.command);
        let names: Vec<&str> = results.iter().map(|(name, ..)| *name).collect();
        let hint = format!("Names with commas between: {}", names.join(", "));
        for (name, goals) in [("Less is better", &mut self.less), ("More is better", &mut self.more)] {
            ui.horizontal(|ui| {
                let label = ui.label(name);
                let field = egui::TextEdit::singleline(goals).hint_text("results").desired_width(420.0);
                ui.add(field).labelled_by(label.id).on_hover_text(&hint);
            });
        }
    }

    /// The study that is typed. Its project is not named: it is the one that is shown.
    fn study(&self) -> Result<Study, String> {
        let names =
            |text: &str| text.split(',').map(str::trim).filter(|name| !name.is_empty()).map(str::to_owned).collect();
        let study = Study {
            kind: StudyKind::Study,
            project: "project.sparkpath".into(),
            command: self.command,
            sampling: self.sampling,
            parameter: self.rows.iter().map(FormRow::parameter).collect::<Result<_, _>>()?,
            collect: Collect { columns: Vec::new(), less: names(&self.less), more: names(&self.more) },
        };
        files::Validate::validate(&study).map_err(|problem| problem.to_string())?;
        Ok(study)
    }
}

/// The parameter to choose, by its name with the key beside it.
fn key_box(ui: &mut Ui, kind: &str, i: usize, key: &mut String) {
    let fields = varied_fields(kind);
    let text = if key.is_empty() { "parameter…" } else { key.as_str() };
    let response = egui::ComboBox::from_id_salt(("study key", i))
        .selected_text(text)
        .width(240.0)
        .height(320.0)
        .show_ui(ui, |ui| {
            for (own, label) in &fields {
                ui.selectable_value(key, (*own).to_owned(), format!("{label}   {own}"));
            }
        });
    let name = format!("Parameter {}", i + 1);
    response.response.widget_info(|| WidgetInfo::labeled(Role::ComboBox, true, &name));
}

impl FormRow {
    /// The parameter: values with commas between, or a range.
    fn parameter(&self) -> Result<Parameter, String> {
        let (key, text) = (self.key.clone(), self.values.trim());
        if key.is_empty() {
            return Err("Choose a parameter to vary".to_owned());
        }
        if let Some((from, rest)) = text.split_once("..") {
            let wrong = || format!("{key}: {text} is no range; give one as in 0..59 or 0.05..0.2 in 4");
            let (to, steps) = rest.split_once("in").map_or((rest, None), |(to, steps)| (to, Some(steps)));
            let number = |text: &str| text.trim().parse::<f64>().map_err(|_| wrong());
            let steps = steps.map(|steps| steps.trim().parse::<usize>().map_err(|_| wrong())).transpose()?;
            return Ok(Parameter {
                from: Some(number(from)?),
                to: Some(number(to)?),
                steps,
                key,
                ..Parameter::default()
            });
        }
        let listed: Result<toml::Table, _> = toml::from_str(&format!("values = [{text}]"));
        let values = match listed.ok().and_then(|mut table| table.remove("values")) {
            Some(toml::Value::Array(values)) => values,
            // Words and files need no quotation marks here.
            _ => text.split(',').map(|word| toml::Value::String(word.trim().to_owned())).collect(),
        };
        if values.is_empty() || text.is_empty() {
            return Err(format!("{key}: give its values"));
        }
        Ok(Parameter { key, values, ..Parameter::default() })
    }
}

/// The points; answers the one that was clicked.
fn table(ui: &mut Ui, found: &Table) -> Option<usize> {
    let colours = palette(ui);
    let mut chosen = None;
    let columns = found.keys.len() + found.columns.len();
    let body = |ui: &mut Ui| {
        let table = TableBuilder::new(ui)
            .id_salt("study points")
            .striped(true)
            .sense(egui::Sense::click())
            .cell_layout(Layout::right_to_left(Align::Center))
            .column(Column::exact(40.0))
            .column(Column::exact(88.0))
            .columns(Column::initial(86.0).at_least(50.0).resizable(true).clip(true), columns)
            .max_scroll_height(220.0);
        let names = found.keys.iter().map(|key| key.rsplit('.').next().unwrap_or(key).to_owned());
        let names = names.chain(found.columns.iter().map(|column| column.name.clone()));
        let table = table.header(20.0, |mut header| {
            for name in ["point".to_owned(), "answer".to_owned()].into_iter().chain(names) {
                header.col(|ui| {
                    ui.add(egui::Label::new(RichText::new(&name).small().color(colours.faint)).truncate());
                });
            }
        });
        table.body(|body| {
            body.rows(18.0, found.rows.len(), |mut row| {
                let of = &found.rows[row.index()];
                let text = |cell: String| {
                    let text = RichText::new(cell).monospace();
                    if of.is_best { text.strong() } else { text }
                };
                let word = if of.is_best { "best" } else { of.word() };
                let cells = [of.point.to_string(), word.to_owned()].into_iter().chain(of.settings.iter().cloned());
                for cell in cells.chain(of.cells.iter().map(shown)) {
                    row.col(|ui| {
                        ui.add(egui::Label::new(text(cell)).truncate().selectable(false));
                    });
                }
                let is_there = of.has_project();
                let response = row.response().on_hover_text(hint(of));
                response.widget_info(|| WidgetInfo::labeled(Role::Row, is_there, format!("Point {}", of.point)));
                if is_there && response.clicked() {
                    chosen = Some(of.point);
                }
            });
        });
    };
    egui::ScrollArea::horizontal().id_salt("study columns").show(ui, body);
    chosen
}

fn hint(row: &Row) -> String {
    let take = if row.has_project() { "Click to take its parameters. " } else { "" };
    format!("{take}{}", row.sentence)
}

/// The first two goals against each other, or the first result over the first parameter.
fn plot(ui: &mut Ui, found: &Table) {
    let Some(scatter) = scatter_of(found) else { return };
    let c = palette(ui);
    let words = scatter.words;
    let has_words = !words.is_empty();
    let plot = Plot::new("study plot")
        .height(180.0)
        .allow_drag(false)
        .allow_scroll(false)
        .allow_zoom(egui::Vec2b::new(false, false))
        .allow_boxed_zoom(false)
        .show_background(false)
        .grid_color(c.faint.gamma_multiply(0.35))
        .x_axis_label(scatter.names[0].clone())
        .y_axis_label(scatter.names[1].clone());
    let word = move |value: f64| {
        let is_place = value.fract() == 0.0 && value >= 0.0;
        words.get(value as usize).filter(|_| is_place).cloned().unwrap_or_default()
    };
    let plot = if has_words { plot.x_axis_formatter(move |mark, _| word(mark.value)) } else { plot };
    plot.show(ui, |plot| {
        plot.points(Points::new("points", PlotPoints::from(scatter.others)).radius(3.0).color(c.faint));
        plot.points(Points::new("best", PlotPoints::from(scatter.best)).radius(4.5).color(c.accent));
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parameter(values: &str) -> Result<Parameter, String> {
        FormRow { key: "a".to_owned(), values: values.to_owned() }.parameter()
    }

    #[test]
    fn values_are_typed_as_lists_or_ranges() {
        let list = |text: &str| {
            let values = parameter(text).unwrap().values;
            values.iter().map(crate::study::definition::text_of).collect::<Vec<_>>()
        };
        assert_eq!(list("0.08, 0.1,3"), ["0.08", "0.1", "3"]);
        assert_eq!(list("xyzc, own.toml"), ["xyzc", "own.toml"]);
        assert_eq!(list("[1, 2.5], [2, 3]"), ["[1, 2.5]", "[2, 3]"]);
        let range = |text: &str| parameter(text).map(|p| (p.from, p.to, p.steps)).unwrap();
        assert_eq!(range("0..59"), (Some(0.0), Some(59.0), None));
        assert_eq!(range(" 0.05 .. 0.2 in 4"), (Some(0.05), Some(0.2), Some(4)));
        for wrong in ["", "  ", "0..x", "0..1 in many"] {
            assert!(parameter(wrong).is_err(), "{wrong}");
        }
    }
}
