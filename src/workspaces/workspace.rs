//! The interface between the window and a workspace.

use std::any::Any;
use std::path::{Path, PathBuf};

use egui::Ui;

use super::commands::{Command, CommandInfo, Commanded, Groups};
use super::context::{Context, LogLine};
use super::hands::Hands;
use super::message::Message;
use super::news::EventKind;
use crate::widgets::viewport::Viewport;
use files::{AnyDocument, Recovery};
use task::Doing;

/// Names of a workspace, the same for all its documents.
pub struct About {
    /// Kind of the documents, in files and on the command line.
    pub id: &'static str,
    /// Name in the switch of the window.
    pub name: &'static str,
    /// Command that shows the workspace.
    pub switch: CommandInfo,
    /// Name of the workspace's menu.
    pub menu: &'static str,
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

/// State of a line of the log.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Standing {
    /// The line holds.
    Current,
    /// The line was written for other parameters than the present ones.
    Stale,
    /// The line tells of a problem that the user has changed something about since.
    Over,
}

/// A workspace of the window: what it is about, with a document of its own.
///
/// The window calls these methods for everything that concerns the document and the panels; a workspace asks the window
/// through its [`Context`]. Workspaces do not know each other: they exchange values as a [`Message`].
pub trait Workspace: Any + Commanded {
    /// Names of the workspace.
    fn about(&self) -> &'static About;

    /// Commands of the workspace.
    fn commands(&self) -> Vec<Command>;

    /// Commands that the workspace adds to a menu.
    fn menu(&self, menu: Menu) -> Groups;

    /// Runs `command`, a command of the workspace or of the window, at `now` (s).
    fn run(&mut self, command: Command, cx: &mut Context, now: f64);

    /// Draws the panels and the view of the workspace.
    fn ui(&mut self, ui: &mut Ui, cx: &mut Context);

    /// Work under way, with its progress.
    fn doing(&self) -> Option<&Doing> {
        None
    }

    /// Draws the work under way in the status bar.
    fn status(&mut self, ui: &mut Ui, cx: &mut Context, is_shown: bool) {
        if let Some(now) = self.doing().filter(|_| is_shown) {
            cx.doing(ui, now);
        }
    }

    /// Number of triangles shown in the status bar.
    fn triangles(&self) -> Option<usize> {
        None
    }

    /// Collects finished work, once a frame, and advances a playing motion by `seconds`.
    fn follow(&mut self, cx: &mut Context, hands: Hands, seconds: f64, is_shown: bool);

    /// Whether work is under way.
    fn is_busy(&self) -> bool;

    /// Whether a document is being read to replace the present one.
    fn is_opening(&self) -> bool {
        false
    }

    /// The 3-D view.
    fn viewport(&self) -> &Viewport;

    /// The 3-D view, to move its camera.
    fn viewport_mut(&mut self) -> &mut Viewport;

    /// The document.
    fn document(&self) -> &dyn AnyDocument;

    /// The document, to save it or to undo a step. [`Self::follow`] takes the change in.
    fn document_mut(&mut self) -> &mut dyn AnyDocument;

    /// File in whose folder file dialogs start.
    fn near(&self) -> Option<&Path> {
        self.document().file()
    }

    /// Opens the document or the mesh at `path`. The caller has asked about unsaved work.
    fn open(&mut self, path: &Path, cx: &mut Context);

    /// Takes files that were dropped on the window, or one that was opened.
    fn take_files(&mut self, files: &[PathBuf], cx: &mut Context);

    /// Carries out the replacement of the document that the workspace has asked for. The window calls this after the
    /// question about unsaved work.
    fn proceed(&mut self, cx: &mut Context);

    /// Begins to read unsaved work of an earlier run of the program. Requests [`Request::Recovered`] once the work has
    /// replaced the document, or shows why it cannot be read.
    ///
    /// [`Request::Recovered`]: super::context::Request::Recovered
    fn recover(&mut self, copy: Recovery, cx: &mut Context);

    /// Takes the parameters in the project `file`, which is of the workspace's kind, in the place of the present ones, as a step
    /// called `label` that can be undone.
    ///
    /// # Errors
    /// Sentence for the user, of one line.
    fn take_parameters(&mut self, file: &Path, _label: &str) -> Result<(), String> {
        Err(format!("{}: this workspace takes no parameters from points", file.display()))
    }

    /// Takes the path that the workspace has asked for under this number.
    fn take_path(&mut self, number: usize, path: PathBuf, cx: &mut Context);

    /// Tells that the user gave no path for this number, so that the pending step is dropped.
    fn no_path(&mut self, _number: usize, _cx: &mut Context) {}

    /// Title of the workspace's dialog.
    fn dialog_title(&self) -> &'static str {
        "Export"
    }

    /// Draws the workspace's dialog. Returns whether the dialog is to be closed.
    fn dialog(&mut self, _ui: &mut Ui, _cx: &mut Context) -> bool {
        true
    }

    /// Takes a message of another workspace. Returns whether this workspace handles the message, so that no other has to.
    fn receive(&mut self, _message: &Message, _cx: &mut Context) -> bool {
        false
    }

    /// Reads the user's own lists (cutters, holders, machines) from `folder`.
    fn take_user_files(&mut self, _folder: &Path, _cx: &mut Context) {}

    /// A number that changes with the document's parameters.
    fn revision(&self) -> u64 {
        self.document().revision()
    }

    /// State of a line with the present document.
    fn standing(&self, line: &LogLine) -> Standing {
        let is_problem = line.kind != EventKind::Done;
        if is_problem && line.is_of_other(self.revision()) { Standing::Over } else { Standing::Current }
    }
}

/// Implements the methods of [`Workspace`] that return a field: `ABOUT`, the commands, and the fields `desk`, `view`
/// and `opening`.
macro_rules! held_in_fields {
    ($commands:ty) => {
        fn about(&self) -> &'static About {
            &ABOUT
        }

        fn commands(&self) -> Vec<Command> {
            <$commands>::all()
        }

        fn doing(&self) -> Option<&task::Doing> {
            self.opening.doing().or(self.desk.work.doing())
        }

        fn is_opening(&self) -> bool {
            self.opening.is_busy()
        }

        fn viewport(&self) -> &$crate::widgets::viewport::Viewport {
            &self.view.viewport
        }

        fn viewport_mut(&mut self) -> &mut $crate::widgets::viewport::Viewport {
            &mut self.view.viewport
        }

        fn document(&self) -> &dyn files::AnyDocument {
            &self.desk.document
        }

        fn document_mut(&mut self) -> &mut dyn files::AnyDocument {
            &mut self.desk.document
        }
    };
}
pub(crate) use held_in_fields;
