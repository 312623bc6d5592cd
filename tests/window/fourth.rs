//! A workspace that the program does not have: one type, and one line in the list.

use std::any::Any;
use std::path::{Path, PathBuf};

use eframe::App as _;
use egui::{Key, Modifiers, Role, Ui, vec2};
use egui_kittest::Harness;
use sparkpath::shell::autosave::Recovery;
use sparkpath::shell::run::{Opening, SparkpathApp};
use sparkpath::widgets::viewport::Viewport;
use sparkpath::workspaces::commands::{Command, CommandInfo, CommandSet, Commanded, FrameCommand, Groups, Scope};
use sparkpath::workspaces::context::{Context, PathInfo, PathKind, Request, first};
use sparkpath::workspaces::record::Hands;
use sparkpath::workspaces::registry::workspaces;
use sparkpath::workspaces::workspace::{About, Menu, Workspace};
use task::Scheduler;

use crate::desk::{Desk, Home, holds};

const ENDING: &str = ".sparknotes";

static ABOUT: About = About {
    id: "notes",
    name: "Notes",
    switch: CommandInfo::new("Workspace: notes"),
    menu: "Notes",
    save: PathInfo { title: "Save notes", kind: PathKind::Write("Notes", ENDING), opens: false },
    ending: ENDING,
    article: "The sheet ",
    kind: "Notes, ",
    not_saved: "The notes were not saved",
};

#[derive(Debug, Clone, Copy, PartialEq)]
enum NotesCommand {
    AddLine,
}

impl CommandSet for NotesCommand {
    const SCOPE: Scope = Scope::Workspace("notes");

    fn table() -> &'static [(Self, CommandInfo)] {
        static TABLE: [(NotesCommand, CommandInfo); 1] =
            [(NotesCommand::AddLine, CommandInfo::new("Add a line").key(Key::F9))];
        &TABLE
    }
}

/// Lines, and how many there were when they were opened or saved and before the last step.
#[derive(Default)]
struct Notes {
    lines: usize,
    saved: usize,
    before: Option<usize>,
    file: Option<PathBuf>,
    wanted: Option<PathBuf>,
    viewport: Viewport,
}

impl Commanded for Notes {
    fn is_enabled(&self, command: Command) -> bool {
        match FrameCommand::of(command) {
            Some(FrameCommand::Undo) => self.before.is_some(),
            Some(FrameCommand::Redo | FrameCommand::Cancel | FrameCommand::Export) => false,
            Some(_) => true,
            None => NotesCommand::of(command).is_some(),
        }
    }
}

impl Workspace for Notes {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    fn commands(&self) -> Vec<Command> {
        NotesCommand::all()
    }

    fn menu(&self, menu: Menu) -> Groups {
        if menu == Menu::Own { vec![NotesCommand::all()] } else { Vec::new() }
    }

    fn run(&mut self, command: Command, _cx: &mut Context, _now: f64) {
        if NotesCommand::of(command) == Some(NotesCommand::AddLine) {
            self.before = Some(self.lines);
            self.lines += 1;
        }
    }

    fn ui(&mut self, ui: &mut Ui, cx: &mut Context) {
        ui.label(format!("There are {} lines", self.lines));
        let desk = Self { ..Self::default() };
        cx.button(ui, &desk, NotesCommand::AddLine, "Add", true);
    }

    fn status(&mut self, _ui: &mut Ui, _cx: &mut Context, _is_shown: bool) {}

    fn follow(&mut self, _cx: &mut Context, _hands: Hands, _seconds: f64, _is_shown: bool) {}

    fn is_busy(&self) -> bool {
        false
    }

    fn viewport(&self) -> &Viewport {
        &self.viewport
    }

    fn viewport_mut(&mut self) -> &mut Viewport {
        &mut self.viewport
    }

    fn name(&self) -> String {
        "sheet".to_owned()
    }

    fn is_unsaved(&self) -> bool {
        self.lines != self.saved
    }

    fn file(&self) -> Option<&Path> {
        self.file.as_deref()
    }

    fn undo_label(&self, again: bool) -> Option<&str> {
        self.before.filter(|_| !again).map(|_| "a line")
    }

    fn undo(&mut self, again: bool) {
        if let (Some(before), false) = (self.before.take(), again) {
            self.lines = before;
        }
    }

    fn open(&mut self, path: &Path, cx: &mut Context) {
        let text = std::fs::read_to_string(path).unwrap();
        (self.lines, self.file) = (text.lines().count(), Some(path.to_owned()));
        self.saved = self.lines;
        cx.request(Request::Show);
    }

    fn take_files(&mut self, files: &[PathBuf], cx: &mut Context) {
        self.wanted = Some(first(files).to_owned());
        cx.request(Request::Replace);
    }

    fn proceed(&mut self, cx: &mut Context) {
        if let Some(path) = self.wanted.take() {
            self.open(&path, cx);
        }
    }

    fn write(&self, file: &Path) -> Result<(), String> {
        std::fs::write(file, "a line\n".repeat(self.lines)).map_err(|e| e.to_string())
    }

    fn save_as(&mut self, file: &Path) -> Result<(), String> {
        self.write(file)?;
        (self.saved, self.file) = (self.lines, Some(file.to_owned()));
        Ok(())
    }

    fn recover(&mut self, copy: &Path, file: Option<PathBuf>, cx: &mut Context) -> Result<(), String> {
        self.open(copy, cx);
        (self.file, self.saved) = (file, 0);
        Ok(())
    }

    fn snapshot(&self) -> Box<dyn Any> {
        Box::new(self.lines)
    }

    fn is_at(&self, snapshot: Option<&dyn Any>) -> bool {
        snapshot.and_then(|s| s.downcast_ref()) == Some(&self.lines)
    }

    fn take_path(&mut self, _number: usize, _path: PathBuf, _cx: &mut Context) {}
}

/// Starts the program with its own workspaces and this one.
fn start(home: &Home, opening: Opening) -> Desk {
    let folders = home.folders();
    let window = Harness::builder().with_size(vec2(1280.0, 720.0)).wgpu().build_eframe(move |cc| {
        let scheduler = Scheduler::start(|| ()).unwrap();
        let mut list = workspaces(&scheduler);
        list.push(Box::<Notes>::default());
        SparkpathApp::with_workspaces(cc, (&opening, Some(folders)), list, scheduler).unwrap()
    });
    let mut desk = Desk { window };
    desk.window.state_mut().type_paths();
    desk.settle();
    desk
}

fn lines(desk: &Desk) -> usize {
    desk.app().workspace::<Notes>().unwrap().lines
}

#[test]
fn a_fourth_workspace_has_commands_menu_files_undo_and_recovery_like_the_others() {
    let home = Home::new();
    let mut desk = start(&home, Opening::In("mold", None));
    desk.key(Key::F9);
    assert_eq!(lines(&desk), 0, "its keys are its own");
    desk.press_role(Role::Tab, "Notes workspace");
    assert_eq!(desk.app().shown(), "notes");
    desk.key(Key::F9);
    desk.press("Add");
    desk.key_with(Modifiers::COMMAND, Key::K);
    desk.window.event(egui::Event::Text("add a line".to_owned()));
    desk.settle();
    desk.key(Key::Enter);
    assert_eq!(lines(&desk), 3);
    desk.assert_shows("There are 3 lines");
    assert_eq!(desk.app().title(), "sheet* - Sparkpath");
    desk.key_with(Modifiers::COMMAND, Key::Z);
    assert_eq!(lines(&desk), 2);
    desk.press("Notes");
    desk.assert_shows("Add a line");
    desk.key(Key::Escape);
    // Unsaved work is asked about, and kept.
    desk.key_with(Modifiers::COMMAND, Key::Q);
    desk.assert_shows("The sheet sheet has unsaved changes");
    desk.press("Cancel");
    desk.window.state_mut().on_exit();
    drop(desk);
    assert!(holds(&home.folders().autosave, ENDING));
    let mut desk = start(&home, Opening::Demonstration);
    desk.assert_shows("Notes, sheet, not saved yet");
    desk.press("Recover");
    assert_eq!((lines(&desk), desk.app().shown()), (2, "notes"));
    desk.key_with(Modifiers::COMMAND, Key::S);
    desk.assert_shows("Save notes");
    desk.type_path(&home.path("mine"));
    let file = home.path("mine.sparknotes");
    assert_eq!(std::fs::read_to_string(&file).unwrap().lines().count(), 2);
    desk.window.state_mut().on_exit();
    drop(desk);
    assert!(Recovery::find(&home.folders().autosave, &[ENDING]).is_empty(), "what is saved needs no copy");
    let desk = start(&home, Opening::File(file));
    assert_eq!((lines(&desk), desk.app().shown()), (2, "notes"));
}
