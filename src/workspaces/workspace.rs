//! What the window knows of a workspace.

use std::any::Any;
use std::path::{Path, PathBuf};

use egui::Ui;

use super::commands::{Command, CommandInfo, Commanded, Groups};
use super::context::{Context, LogLine, PathInfo};
use super::message::Message;
use super::record::Hands;
use crate::widgets::viewport::Viewport;

/// What is said of every document of a workspace.
pub struct About {
    /// Name in files and on the command line.
    pub id: &'static str,
    /// What the switch calls it.
    pub name: &'static str,
    /// The command that shows it.
    pub switch: CommandInfo,
    /// The name of its menu.
    pub menu: &'static str,
    /// How its documents are saved.
    pub save: PathInfo,
    /// The ending of its documents, with the dot.
    pub ending: &'static str,
    /// What stands before a document's name in a sentence; nothing or "The mold ".
    pub article: &'static str,
    /// What stands before the file of a recovered document; nothing or "Mold, ".
    pub kind: &'static str,
    /// The title of the message that a document was not saved.
    pub not_saved: &'static str,
}

/// The menus to which a workspace adds commands of its own.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Menu {
    /// The first group of the menu "File".
    New,
    /// The group of the menu "File" in which documents are saved.
    Save,
    /// The workspace's own menu.
    Own,
    /// The menu "View", after the standard views.
    View,
}

/// How a line of the log stands to what there is now.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Standing {
    /// The line holds.
    Current,
    /// The line is of other parameters than the present ones.
    Stale,
    /// The line is of a failure that is none any more.
    Over,
}

/// A workspace of the window: what it is about, with a document of its own.
///
/// The window asks it for everything that concerns its document and its panels; a workspace asks the window through its
/// [`Context`]. Workspaces do not know each other: what they exchange is a [`Message`].
pub trait Workspace: Any + Commanded {
    /// What is said of all its documents.
    fn about(&self) -> &'static About;

    /// Commands of the workspace.
    fn commands(&self) -> Vec<Command>;

    /// The commands that it adds to a menu.
    fn menu(&self, menu: Menu) -> Groups;

    /// Does `command`, one of its own or of the window, at `now` (s).
    fn run(&mut self, command: Command, cx: &mut Context, now: f64);

    /// Draws its panels and its view.
    fn ui(&mut self, ui: &mut Ui, cx: &mut Context);

    /// Draws what is being worked on, in the status bar.
    fn status(&mut self, ui: &mut Ui, cx: &mut Context, is_shown: bool);

    /// The number of triangles that the status bar tells.
    fn triangles(&self) -> Option<usize> {
        None
    }

    /// Takes in what has been made, once a frame, and goes on by `seconds` what is played.
    fn follow(&mut self, cx: &mut Context, hands: Hands, seconds: f64, is_shown: bool);

    /// Whether something is being worked on.
    fn is_busy(&self) -> bool;

    /// Whether a document is being read that is to take the place of the present one.
    fn is_opening(&self) -> bool {
        false
    }

    /// The 3-D view.
    fn viewport(&self) -> &Viewport;

    /// Mutable viewport, to be moved.
    fn viewport_mut(&mut self) -> &mut Viewport;

    /// What to call the document.
    fn name(&self) -> String;

    /// Whether the document has changes that no file holds.
    fn is_unsaved(&self) -> bool;

    /// The document's file.
    fn file(&self) -> Option<&Path>;

    /// A file in whose folder file dialogs start.
    fn near(&self) -> Option<&Path> {
        self.file()
    }

    /// What to call its part, if it has one that can be told.
    fn part(&self) -> Option<String> {
        Some(self.name())
    }

    /// What can be undone, or done again (`again`).
    fn undo_label(&self, again: bool) -> Option<&str>;

    /// Takes the last step back, or does the one again that was taken back last.
    fn undo(&mut self, again: bool);

    /// Opens the document or the mesh at `path`, in whose place there was no unsaved work.
    fn open(&mut self, path: &Path, cx: &mut Context);

    /// Takes files that were dropped, or one that was opened.
    fn take_files(&mut self, files: &[PathBuf], cx: &mut Context);

    /// Does what it has asked to do in place of its document, once no unsaved work stands in the way.
    fn proceed(&mut self, cx: &mut Context);

    /// Writes the document to `file`, which changes nothing in it.
    ///
    /// # Errors
    /// One line why it cannot be written.
    fn write(&self, file: &Path) -> Result<(), String>;

    /// Saves the document as `file`.
    ///
    /// # Errors
    /// One line why it cannot be saved.
    fn save_as(&mut self, file: &Path) -> Result<(), String>;

    /// Takes the unsaved work in `copy`, which was to be saved as `file`.
    ///
    /// # Errors
    /// One line why it cannot be read.
    fn recover(&mut self, copy: &Path, file: Option<PathBuf>, cx: &mut Context) -> Result<(), String>;

    /// The document as it is, for [`Self::is_at`].
    fn snapshot(&self) -> Box<dyn Any>;

    /// Whether the document is as it was at `snapshot`, or cannot be written now: while a number is typed.
    fn is_at(&self, snapshot: Option<&dyn Any>) -> bool;

    /// Goes on with the path that it has asked for under this number.
    fn take_path(&mut self, number: usize, path: PathBuf, cx: &mut Context);

    /// No path was given for this number: what would have followed is off.
    fn no_path(&mut self, _number: usize, _cx: &mut Context) {}

    /// The title of its dialog.
    fn dialog_title(&self) -> &'static str {
        "Export"
    }

    /// Draws its dialog. Tells whether it is to be closed.
    fn dialog(&mut self, _ui: &mut Ui, _cx: &mut Context) -> bool {
        true
    }

    /// Takes what another workspace gives. Tells whether it is something for this one.
    fn receive(&mut self, _message: &Message, _cx: &mut Context) -> bool {
        false
    }

    /// Reads the user's own lists from `folder`.
    fn take_user_files(&mut self, _folder: &Path, _cx: &mut Context) {}

    /// How often the document was changed, where that is counted.
    fn revision(&self) -> u64 {
        0
    }

    /// How a line of the log stands to what there is now.
    fn standing(&self, _line: &LogLine) -> Standing {
        Standing::Current
    }
}
