//! What a workspace sees of the window: preferences, the log, and what it asks the window to do.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant, SystemTime};

use egui::{Color32, RichText, Ui, vec2};

use super::commands::{Command, CommandInfo, CommandSet, Commanded, FrameCommand};
use super::message::Message;
use super::news::{EventKind, WorkEvent};
use super::preferences::Preferences;
use crate::widgets::overlay::{self, Folding, ViewButton};
use crate::widgets::theme::palette;
use files::{FileError, Recovery, ResultCache, paths};
use render::view::StandardView;
use task::Doing;

/// Time that a passing message is shown (s).
const PASSING: f64 = 8.0;

/// A line of the log.
#[derive(Debug, Clone, PartialEq)]
pub struct LogLine {
    /// Time of the message.
    pub at: SystemTime,
    /// Kind of the message.
    pub kind: EventKind,
    /// Text of the message, one sentence.
    pub text: String,
    /// Time that the work took, if that is known.
    pub took: Option<Duration>,
    /// Number of the workspace that sent the message.
    pub workspace: usize,
    /// Subject of the message, as the workspace numbers it: a step of the plan.
    pub topic: Option<usize>,
    /// Revision of the workspace's document after the message; none for a message that is not about the document.
    pub revision: Option<u64>,
}

impl LogLine {
    /// A line with the present time.
    pub fn now(kind: EventKind, text: impl Into<String>) -> Self {
        let (at, text) = (SystemTime::now(), text.into());
        Self { at, kind, text, took: None, workspace: 0, topic: None, revision: None }
    }

    /// Whether the document has changed since the message and is now at `revision`.
    pub fn is_of_other(&self, revision: u64) -> bool {
        self.revision.is_some_and(|of| of != revision)
    }
}

/// A sentence of the status bar in a place `width` points wide: what does not fit is shown where the pointer is on it.
pub fn status_sentence(ui: &mut Ui, width: f32, text: &str) {
    let layout = egui::Layout::left_to_right(egui::Align::Center);
    ui.allocate_ui_with_layout(vec2(width, 18.0), layout, |ui| {
        ui.set_min_width(width);
        ui.add(egui::Label::new(text).truncate());
    });
}

/// A path that the user is asked for.
#[derive(Debug, PartialEq, Eq)]
pub struct PathInfo {
    /// The title of the dialog.
    pub title: &'static str,
    /// Kind of the file or folder.
    pub kind: PathKind,
    /// Whether the file is opened in place of the document.
    pub opens: bool,
}

impl PathInfo {
    /// A path that is asked for by `title`.
    pub const fn new(title: &'static str, kind: PathKind) -> Self {
        Self { title, kind, opens: false }
    }

    /// A path, asked for by `title`, of a file that is opened in place of the document.
    pub const fn open(title: &'static str, kind: PathKind) -> Self {
        Self { title, kind, opens: true }
    }
}

/// Kind of path that a file dialog asks for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PathKind {
    /// A file to read: what such files are called, their endings (all files without), and whether one that is not there
    /// is refused at once.
    Read(&'static str, Endings, bool),
    /// A file to write: what such files are called, and their ending with its dot.
    Write(&'static str, &'static str),
    /// A folder.
    Folder,
}

/// Paths that a workspace asks for, with a table of their own.
pub trait PathSet: Copy + PartialEq + 'static {
    /// All paths of the set.
    fn table() -> &'static [(Self, PathInfo)];

    /// The path with this number in the table.
    fn at(number: usize) -> Option<Self> {
        Self::table().get(number).map(|(path, _)| *path)
    }
}

/// Kinds of files, each with its endings, without the dot and in small letters.
pub type Endings = &'static [&'static [&'static str]];

/// Ending of posts, machines and libraries.
pub const TOML: &[&str] = &["toml"];
/// Endings of tables.
pub const CSV: &[&str] = &["csv"];
/// Ending of projects.
pub const PROJECT: &[&str] = &["sparkpath"];

/// A request of a workspace to the window.
pub enum Request {
    /// A path: its number in the workspace's table, what it is for, and the name that is proposed.
    Path(usize, &'static PathInfo, String),
    /// Shows an error: title and text.
    Error(String, String),
    /// Shows the workspace's own dialog.
    Dialog,
    /// Closes the workspace's own dialog.
    CloseDialog,
    /// Replaces the document, after the question about unsaved work.
    Replace,
    /// Replaces the document as part of a replacement that was asked about already: the user is not asked again about
    /// work given up for it.
    GoOn,
    /// Shows the workspace.
    Show,
    /// Tells that the work of this copy has been recovered, so that the copy can go.
    Recovered(Recovery),
    /// Sends a message to the other workspaces, until one handles it.
    Send(Message),
}

/// The window as a workspace sees it.
pub struct Context {
    /// Preferences of the user.
    pub preferences: Preferences,
    /// The log.
    pub log: Vec<LogLine>,
    /// Cache of results, if there is a folder for it.
    pub results: Option<ResultCache>,
    /// Time of the present frame (s), since the window opened.
    pub now: f64,
    /// A line that is shown for a moment and not kept in the log, with its time (s).
    passing: Option<(LogLine, f64)>,
    commands: Vec<Command>,
    requests: Vec<(usize, Request)>,
    wake: Option<Duration>,
    /// Number of the workspace that acts.
    turn: usize,
    /// Number of the first line of its turn in the log.
    first: usize,
}

impl Context {
    /// A context with an empty log.
    pub fn new(preferences: Preferences) -> Self {
        let (log, commands, requests) = (Vec::new(), Vec::new(), Vec::new());
        let now = 0.0;
        Self { preferences, log, results: None, now, passing: None, commands, requests, wake: None, turn: 0, first: 0 }
    }

    /// Has `command` run at the end of the frame.
    pub fn push(&mut self, command: impl Into<Command>) {
        self.commands.push(command.into());
    }

    /// A button for a command of `desk`, disabled while the command cannot be run.
    pub fn button(&mut self, ui: &mut Ui, desk: &impl Commanded, command: impl CommandSet, text: &str, primary: bool) {
        let command = command.command();
        let enabled = desk.is_enabled(command);
        let mut button = egui::Button::new(RichText::new(text).strong()).min_size(vec2(0.0, 26.0));
        if primary && enabled {
            let accent = palette(ui).accent;
            let ink = if ui.visuals().dark_mode { Color32::BLACK } else { Color32::WHITE };
            button = egui::Button::new(RichText::new(text).strong().color(ink)).fill(accent).min_size(vec2(0.0, 26.0));
        }
        let mut response = ui.add_enabled(enabled, button).on_hover_text(command.info.hint(ui.ctx()));
        if let Some(why) = command.info.needs {
            response = response.on_disabled_hover_text(why);
        }
        if response.clicked() {
            self.push(command);
        }
    }

    /// The buttons that play and step the motion of `desk`, each `width` points wide. `names` are the names of the
    /// buttons first, back, on and last; with `are_hints` the tooltips show these in place of the names of the
    /// commands.
    pub fn play_buttons(
        &mut self,
        ui: &mut Ui,
        desk: &impl Commanded,
        (is_playing, width): (bool, f32),
        [first, back, on, last]: [&'static str; 4],
        are_hints: bool,
    ) {
        let buttons = [
            (FrameCommand::FirstNode, "⏮", first),
            (FrameCommand::PreviousNode, "⏴", back),
            (FrameCommand::Play, if is_playing { "⏸" } else { "▶" }, "Play"),
            (FrameCommand::NextNode, "⏵", on),
            (FrameCommand::LastNode, "⏭", last),
        ];
        for (command, sign, name) in buttons {
            let button = egui::Button::new(RichText::new(sign).size(13.0)).min_size(vec2(width, 22.0));
            let info = command.command().info;
            let name_of_hint = if are_hints { name } else { info.name };
            let hint = CommandInfo { name: name_of_hint, keys: info.keys, needs: None }.hint(ui.ctx());
            let response = ui.add_enabled(desk.is_enabled(command.into()), button).on_hover_text(hint);
            response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, true, name));
            if response.clicked() {
                self.push(command);
            }
        }
    }

    /// Shows the work under way: a button that cancels it, its progress, and a sentence on it with the time left. Each
    /// keeps its place; a long sentence ends in dots, and is shown whole where the pointer is on it.
    pub fn doing(&mut self, ui: &mut Ui, doing: &Doing) {
        let stage = if doing.stage.is_empty() { doing.what } else { &doing.stage };
        let percent = 100.0 * doing.fraction;
        let room = ui.available_width();
        if ui.small_button("Cancel").on_hover_text(FrameCommand::Cancel.hint(ui.ctx())).clicked() {
            self.push(FrameCommand::Cancel);
        }
        let bar = egui::ProgressBar::new(doing.fraction as f32).desired_width(if room > 900.0 { 140.0 } else { 80.0 });
        let bar = bar.desired_height(8.0);
        let name = format!("{stage} {percent:.0} %");
        ui.add(bar).widget_info(|| egui::WidgetInfo::labeled(egui::Role::ProgressIndicator, true, &name));
        ui.label(RichText::new(format!("{percent:3.0} %")).monospace());
        let left = doing.time_left(Instant::now());
        let left = left.map(|t| format!(", about {} s left", t.as_secs() + 1)).unwrap_or_default();
        let mut text = format!("{}: {stage}, {} s{left}", doing.what, doing.since.elapsed().as_secs());
        if !doing.message.is_empty() {
            text = format!("{text}: {}", doing.message);
        }
        status_sentence(ui, (0.3 * room).clamp(120.0, 460.0), &text);
        ui.separator();
    }

    /// The row of buttons over a view: for each its short name, its command, and whether what it shows is on.
    pub fn view_buttons(
        &mut self,
        ui: &mut Ui,
        rect: egui::Rect,
        desk: &impl Commanded,
        views: &[(&'static str, Command, bool)],
    ) {
        let button = |(name, command, is_on): &(&'static str, Command, bool)| ViewButton {
            name,
            hint: command.info.hint(ui.ctx()),
            is_enabled: desk.is_enabled(*command),
            is_on: *is_on,
        };
        let buttons: Vec<ViewButton> = views.iter().map(button).collect();
        if let Some((_, command, _)) = overlay::buttons(ui, rect, &buttons).and_then(|i| views.get(i)) {
            self.push(*command);
        }
    }

    /// The handles that fold the panels beside the view in `rect`: for each panel its command and whether the panel is
    /// open. The right panel may have no handle.
    pub fn folds<C: CommandSet>(&mut self, ui: &mut Ui, rect: egui::Rect, left: (C, bool), right: Option<(C, bool)>) {
        let panels: Vec<(C, bool)> = [left].into_iter().chain(right).collect();
        let folding = |(i, (command, is_there)): (usize, &(C, bool))| {
            let info = command.command().info;
            Folding { is_left: i == 0, is_there: *is_there, name: info.name, hint: info.hint(ui.ctx()) }
        };
        let handles: Vec<Folding> = panels.iter().enumerate().map(folding).collect();
        if let Some((command, _)) = overlay::folds(ui, rect, &handles).and_then(|i| panels.get(i)) {
            self.push(*command);
        }
    }

    /// Adds a line to the log.
    pub fn say(&mut self, kind: EventKind, text: impl Into<String>) {
        self.note(LogLine::now(kind, text));
    }

    /// Adds a line of the workspace that acts.
    pub fn note(&mut self, line: LogLine) {
        self.log.push(LogLine { workspace: self.turn, ..line });
    }

    /// Adds reports of work, and has a frame drawn after `wait`.
    pub fn note_events(&mut self, (events, wait): (Vec<WorkEvent>, Option<Duration>)) {
        for WorkEvent { kind, text, took } in events {
            self.note(LogLine { took, ..LogLine::now(kind, text) });
        }
        wait.into_iter().for_each(|wait| self.wake_after(wait));
    }

    /// Shows `text` for a moment, in place of the last such text. The log does not keep it.
    pub fn say_in_passing(&mut self, text: impl Into<String>) {
        let line = LogLine { workspace: self.turn, ..LogLine::now(EventKind::Cancelled, text) };
        self.passing = Some((line, self.now));
    }

    /// The passing line of workspace number `workspace`, and the time for which it is still shown.
    pub fn passing(&self, workspace: usize) -> Option<(&LogLine, Duration)> {
        let (line, since) = self.passing.as_ref().filter(|(line, _)| line.workspace == workspace)?;
        let left = rest_left(*since, PASSING, self.now);
        (!left.is_zero()).then_some((line, left))
    }

    /// Sets the revision of the lines that the acting workspace has added in its turn. They are about the document as
    /// the turn leaves it.
    pub fn set_revision(&mut self, revision: u64) {
        let passing = self.passing.iter_mut().map(|(line, _)| line);
        let said = self.log.iter_mut().skip(self.first).chain(passing);
        for line in said.filter(|line| line.workspace == self.turn) {
            line.revision.get_or_insert(revision);
        }
    }

    /// Asks the user for a path. `name` is proposed where a file is written.
    pub fn ask<P: PathSet>(&mut self, path: P, name: &str) {
        let found = P::table().iter().enumerate().find(|(_, (one, _))| *one == path);
        if let Some((number, (_, info))) = found {
            self.request(Request::Path(number, info, name.to_owned()));
        }
    }

    /// Shows an error.
    pub fn error(&mut self, title: impl Into<String>, text: impl Into<String>) {
        self.request(Request::Error(title.into(), text.into()));
    }

    /// Makes a request to the window.
    pub fn request(&mut self, request: Request) {
        self.requests.push((self.turn, request));
    }

    /// Has a frame drawn after `wait` at the latest.
    pub fn wake_after(&mut self, wait: Duration) {
        self.wake = Some(self.wake.map_or(wait, |before| before.min(wait)));
    }

    /// Puts a file first among the recent files.
    pub fn opened(&mut self, file: &Path) {
        self.preferences.recent.add(file);
    }

    /// Removes a file that cannot be opened from the recent files.
    pub fn not_opened(&mut self, file: &Path) {
        self.preferences.recent.remove(file);
    }

    /// Shows that the project in `file` cannot be opened, and removes it from the recent files.
    pub fn not_a_project(&mut self, file: &Path, why: &FileError) {
        self.not_opened(file);
        self.error("This project cannot be opened", why.to_string());
    }

    /// Sets the number of the workspace that acts.
    pub fn take_turn(&mut self, turn: usize) {
        (self.turn, self.first) = (turn, self.log.len());
    }

    /// Takes the commands requested since the last call.
    pub fn take_commands(&mut self) -> Vec<Command> {
        std::mem::take(&mut self.commands)
    }

    /// Takes the requests since the last call, each with the number of its workspace.
    pub fn take_requests(&mut self) -> Vec<(usize, Request)> {
        std::mem::take(&mut self.requests)
    }

    /// Time until the next frame that is needed, if any.
    pub fn take_wake(&mut self) -> Option<Duration> {
        self.wake.take()
    }
}

/// The buttons of the standard views, which begin the row over a view.
pub fn standard_views() -> Vec<(&'static str, Command, bool)> {
    use FrameCommand as F;
    let views = [
        ("Fit", F::Fit),
        ("Iso", F::View(StandardView::Isometric)),
        ("Front", F::View(StandardView::Front)),
        ("Right", F::View(StandardView::Right)),
        ("Top", F::View(StandardView::Top)),
    ];
    views.map(|(name, command)| (name, command.command(), false)).to_vec()
}

/// Time from `now` until `wait` after `since`, all in seconds.
pub fn rest_left(since: f64, wait: f64, now: f64) -> Duration {
    Duration::from_secs_f64((since + wait - now).max(0.0))
}

/// Whether `path` has the ending of a project.
pub fn is_project(path: &Path) -> bool {
    paths::has_ending(path, ".sparkpath")
}

/// The first of `files`; an empty path if there is none.
pub fn first(files: &[PathBuf]) -> &Path {
    files.first().map_or(Path::new(""), PathBuf::as_path)
}
