//! A workspace that the program does not have: one type, and one line in the list.

use std::path::{Path, PathBuf};

use eframe::App as _;
use egui::{Key, Modifiers, Role, Ui, vec2};
use egui_kittest::Harness;
use files::{AnyDocument, Document, Invalid, Params, Recovery, Validate};
use serde::{Deserialize, Serialize};
use sparkpath::shell::run::{Opening, SparkpathApp};
use sparkpath::widgets::viewport::Viewport;
use sparkpath::workspaces::commands::{Command, CommandInfo, CommandSet, Commanded, FrameCommand, Groups, Scope};
use sparkpath::workspaces::context::{Context, Request, first};
use sparkpath::workspaces::hands::Hands;
use sparkpath::workspaces::registry::workspaces;
use sparkpath::workspaces::workspace::{About, Menu, Workspace};
use task::Scheduler;

use crate::desk::{Desk, Home, holds};

static ABOUT: About = About { id: "notes", name: "Notes", switch: CommandInfo::new("Workspace: notes"), menu: "Notes" };

/// How many lines there are.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
struct Sheet {
    lines: usize,
}

impl Validate for Sheet {
    fn validate(&self) -> Result<(), Invalid> {
        Ok(())
    }
}

impl Params for Sheet {
    const KIND: &'static str = "notes";

    fn part(&self) -> String {
        "sheet".to_owned()
    }

    fn change_paths(&mut self, _: &mut dyn FnMut(&Path) -> PathBuf) {}
}

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

#[derive(Default)]
struct Notes {
    document: Document<Sheet>,
    wanted: Option<PathBuf>,
    viewport: Viewport,
}

impl Commanded for Notes {
    fn is_enabled(&self, command: Command) -> bool {
        match FrameCommand::of(command) {
            Some(FrameCommand::Undo) => self.document.undo_label(false).is_some(),
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
            self.document.edit("a line", Sheet { lines: self.document.params().lines + 1 }, false);
        }
    }

    fn ui(&mut self, ui: &mut Ui, cx: &mut Context) {
        ui.label(format!("There are {} lines", self.document.params().lines));
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

    fn document(&self) -> &dyn AnyDocument {
        &self.document
    }

    fn document_mut(&mut self) -> &mut dyn AnyDocument {
        &mut self.document
    }

    fn open(&mut self, path: &Path, cx: &mut Context) {
        self.document = Document::open(path).unwrap();
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

    fn recover(&mut self, copy: Recovery, cx: &mut Context) {
        self.document = copy.open().unwrap();
        cx.request(Request::Recovered(copy));
    }

    fn take_path(&mut self, _number: usize, _path: PathBuf, _cx: &mut Context) {}
}

/// Starts the program with its own workspaces and this one.
fn start(home: &Home, opening: Opening) -> Desk {
    let folders = home.folders();
    let mut desk = Desk::start(Harness::builder().with_size(vec2(1280.0, 720.0)), move |cc| {
        let scheduler = Scheduler::start(|| ()).unwrap();
        let mut list = workspaces(&scheduler);
        list.push(Box::<Notes>::default());
        SparkpathApp::with_workspaces(cc, (&opening, Some(folders)), list, scheduler).unwrap()
    });
    desk.settle();
    desk
}

fn lines(desk: &Desk) -> usize {
    desk.app().workspace::<Notes>().unwrap().document.params().lines
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
    desk.assert_shows("Notes: sheet has unsaved changes");
    desk.press("Cancel");
    desk.window.state_mut().on_exit();
    drop(desk);
    assert!(holds(&home.folders().autosave, ".notes.sparkpath"));
    let mut desk = start(&home, Opening::Demonstration);
    desk.assert_shows("Notes: sheet, not saved yet");
    desk.press("Recover");
    assert_eq!((lines(&desk), desk.app().shown()), (2, "notes"));
    desk.key_with(Modifiers::COMMAND, Key::S);
    desk.assert_shows("Save project");
    desk.type_path(&home.path("mine"));
    let file = home.path("mine.sparkpath");
    assert_eq!(std::fs::read_to_string(&file).unwrap(), "kind = \"notes\"\nversion = 1\nlines = 2\n");
    desk.window.state_mut().on_exit();
    drop(desk);
    assert!(Recovery::find(&home.folders().autosave).is_empty(), "what is saved needs no copy");
    let desk = start(&home, Opening::File(file));
    assert_eq!((lines(&desk), desk.app().shown()), (2, "notes"));
}
