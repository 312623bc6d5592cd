//! What a workspace sees of the window: preferences, the log, and what it asks the window to do.

use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

use egui::{Color32, RichText, Ui, vec2};

use super::commands::{Command, CommandInfo, CommandSet, Commanded, FrameCommand};
use super::message::Message;
use super::news::{EventKind, WorkEvent};
use super::preferences::Preferences;
use crate::widgets::folds::{self, Folding};
use crate::widgets::overlay::{self, ViewButton};
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
    /// Number of changes of the document before the message, where the workspace counts them.
    pub revision: u64,
}

impl LogLine {
    /// A line that is said now.
    pub fn now(kind: EventKind, text: impl Into<String>) -> Self {
        let (at, text) = (SystemTime::now(), text.into());
        Self { at, kind, text, took: None, workspace: 0, topic: None, revision: 0 }
    }
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

/// What is chosen in a file dialog.
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
    /// Goes on with what takes the place of the document, after asking about unsaved work.
    Replace,
    /// To go on with the replacement on the way to what was asked for before: what the user has given up for it is not asked about again.
    GoOn,
    /// Shows the workspace.
    Show,
    /// The work of this copy has been taken up: the copy itself is of no use any more.
    Recovered(Recovery),
    /// Hands a message to the workspace that takes it.
    Send(Message),
}

/// The window as a workspace sees it.
pub struct Context {
    /// What the user prefers.
    pub preferences: Preferences,
    /// Everything that has been said.
    pub log: Vec<LogLine>,
    /// Results that are shown again at once, if there is a folder for them.
    pub results: Option<ResultCache>,
    /// The time of the present frame (s), since the window opened.
    pub now: f64,
    /// A sentence that passes, who said it and when.
    passing: Option<(String, usize, f64)>,
    commands: Vec<Command>,
    requests: Vec<(usize, Request)>,
    wake: Option<Duration>,
    /// The number of the workspace whose turn it is.
    turn: usize,
}

impl Context {
    /// A window in which nothing was said.
    pub fn new(preferences: Preferences) -> Self {
        let (log, commands, requests) = (Vec::new(), Vec::new(), Vec::new());
        let now = 0.0;
        Self { preferences, log, results: None, now, passing: None, commands, requests, wake: None, turn: 0 }
    }

    /// Asks for `command` at the end of the frame.
    pub fn push(&mut self, command: impl Into<Command>) {
        self.commands.push(command.into());
    }

    /// A button for a command of `desk`, greyed while it cannot be done.
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

    /// The buttons that play what `desk` shows and step along it, so wide (points): first, back, on and last are called
    /// `names`, which `are_hints` has their tooltips say in place of the commands' own.
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

    /// Says what is being worked on, how far it is and how long it will take, with a button that cancels it.
    pub fn doing(&mut self, ui: &mut Ui, doing: &Doing) {
        let stage = if doing.stage.is_empty() { doing.what } else { &doing.stage };
        let (percent, faint) = (100.0 * doing.fraction, palette(ui).faint);
        ui.label(format!("{}: {stage}", doing.what));
        let bar = egui::ProgressBar::new(doing.fraction as f32).desired_width(140.0).desired_height(8.0);
        let name = format!("{stage} {percent:.0} %");
        ui.add(bar).widget_info(|| egui::WidgetInfo::labeled(egui::Role::ProgressIndicator, true, &name));
        ui.label(RichText::new(format!("{percent:3.0} %")).monospace());
        if !doing.message.is_empty() {
            ui.label(RichText::new(&doing.message).color(faint));
        }
        let left = doing.time_left().map(|t| format!(", about {} s left", t.as_secs() + 1)).unwrap_or_default();
        ui.label(RichText::new(format!("{} s{left}", doing.since.elapsed().as_secs())).color(faint));
        if ui.small_button("Cancel").on_hover_text(FrameCommand::Cancel.hint(ui.ctx())).clicked() {
            self.push(FrameCommand::Cancel);
        }
        ui.separator();
    }

    /// The row of buttons over a view: short names, commands, and whether what they show is on.
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

    /// The handles that fold the panels beside the view in `rect`: the commands that do, and whether the one on the left
    /// is there, and that on the right if it has a handle.
    pub fn folds<C: CommandSet>(&mut self, ui: &mut Ui, rect: egui::Rect, left: (C, bool), right: Option<(C, bool)>) {
        let panels: Vec<(C, bool)> = [left].into_iter().chain(right).collect();
        let folding = |(i, (command, is_there)): (usize, &(C, bool))| {
            let info = command.command().info;
            Folding { is_left: i == 0, is_there: *is_there, name: info.name, hint: info.hint(ui.ctx()) }
        };
        let handles: Vec<Folding> = panels.iter().enumerate().map(folding).collect();
        if let Some((command, _)) = folds::show(ui, rect, &handles).and_then(|i| panels.get(i)) {
            self.push(*command);
        }
    }

    /// Adds a line to the log.
    pub fn say(&mut self, kind: EventKind, text: impl Into<String>) {
        self.note(LogLine::now(kind, text));
    }

    /// Adds a line of the workspace whose turn it is.
    pub fn note(&mut self, line: LogLine) {
        self.log.push(LogLine { workspace: self.turn, ..line });
    }

    /// Adds what became of work on revision `revision` of the document, and comes back after `wait`.
    pub fn note_events(&mut self, (events, wait): (Vec<WorkEvent>, Option<Duration>), revision: u64) {
        for WorkEvent { kind, text, took } in events {
            self.note(LogLine { took, revision, ..LogLine::now(kind, text) });
        }
        wait.into_iter().for_each(|wait| self.wake_after(wait));
    }

    /// Says `text` for a moment, in place of what was said last: it is no news that the log should hold.
    pub fn say_in_passing(&mut self, text: impl Into<String>) {
        self.passing = Some((text.into(), self.turn, self.now));
    }

    /// What workspace number `workspace` said in passing, and how long it is still to be seen.
    pub fn passing(&self, workspace: usize) -> Option<(&str, Duration)> {
        let (text, _, since) = self.passing.as_ref().filter(|(_, of, _)| *of == workspace)?;
        let left = rest_left(*since, PASSING, self.now);
        (!left.is_zero()).then_some((text, left))
    }

    /// Asks for a path; `name` is proposed where a file is written.
    pub fn ask<P: PathSet>(&mut self, path: P, name: &str) {
        let found = P::table().iter().enumerate().find(|(_, (one, _))| *one == path);
        if let Some((number, (_, info))) = found {
            self.request(Request::Path(number, info, name.to_owned()));
        }
    }

    /// Tells of something that went wrong.
    pub fn error(&mut self, title: impl Into<String>, text: impl Into<String>) {
        self.request(Request::Error(title.into(), text.into()));
    }

    /// Asks something of the window.
    pub fn request(&mut self, request: Request) {
        self.requests.push((self.turn, request));
    }

    /// Has a frame drawn after `wait` at the latest.
    pub fn wake_after(&mut self, wait: Duration) {
        self.wake = Some(self.wake.map_or(wait, |before| before.min(wait)));
    }

    /// Puts a file in front of those opened last.
    pub fn opened(&mut self, file: &Path) {
        self.preferences.recent.add(file);
    }

    /// Forgets a file that cannot be opened.
    pub fn not_opened(&mut self, file: &Path) {
        self.preferences.recent.remove(file);
    }

    /// Tells that the project in `file` cannot be opened, and forgets it.
    pub fn not_a_project(&mut self, file: &Path, why: &FileError) {
        self.not_opened(file);
        self.error("This project cannot be opened", why.to_string());
    }

    /// Gives workspace number `turn` its turn.
    pub fn take_turn(&mut self, turn: usize) {
        self.turn = turn;
    }

    /// The commands asked for since the last call.
    pub fn take_commands(&mut self) -> Vec<Command> {
        std::mem::take(&mut self.commands)
    }

    /// What was asked of the window since the last call, with the number of the workspace that did.
    pub fn take_requests(&mut self) -> Vec<(usize, Request)> {
        std::mem::take(&mut self.requests)
    }

    /// After how long a frame is wanted.
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

/// How long it is from `now` until `wait` after `since`, all in seconds.
pub fn rest_left(since: f64, wait: f64, now: f64) -> Duration {
    Duration::from_secs_f64((since + wait - now).max(0.0))
}

/// Whether `path` is named as a project.
pub fn is_project(path: &Path) -> bool {
    paths::has_ending(path, ".sparkpath")
}

/// The first of `files`, which there is where any were dropped.
pub fn first(files: &[PathBuf]) -> &Path {
    files.first().map_or(Path::new(""), PathBuf::as_path)
}
