//! What the window knows of a workspace.

use std::any::Any;
use std::path::{Path, PathBuf};

use egui::Ui;

use super::commands::{Command, CommandInfo, Commanded, Groups};
use super::context::{Context, LogLine};
use super::hands::Hands;
use super::message::Message;
use crate::widgets::viewport::Viewport;
use files::{AnyDocument, Recovery};
use task::Doing;

/// What is said of every document of a workspace.
pub struct About {
    /// The kind of its documents, in files and on the command line.
    pub id: &'static str,
    /// What the switch calls it.
    pub name: &'static str,
    /// The command that shows it.
    pub switch: CommandInfo,
    /// The name of its menu.
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

    /// What is being worked on, and how far it is.
    fn doing(&self) -> Option<&Doing> {
        None
    }

    /// Draws what is being worked on, in the status bar.
    fn status(&mut self, ui: &mut Ui, cx: &mut Context, is_shown: bool) {
        if let Some(now) = self.doing().filter(|_| is_shown) {
            cx.doing(ui, now);
        }
    }

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

    /// The document.
    fn document(&self) -> &dyn AnyDocument;

    /// Mutable document, to be saved, or for a step to be undone, which [`Self::follow`] takes in.
    fn document_mut(&mut self) -> &mut dyn AnyDocument;

    /// A file in whose folder file dialogs start.
    fn near(&self) -> Option<&Path> {
        self.document().file()
    }

    /// Opens the document or the mesh at `path`, in whose place there was no unsaved work.
    fn open(&mut self, path: &Path, cx: &mut Context);

    /// Takes files that were dropped, or one that was opened.
    fn take_files(&mut self, files: &[PathBuf], cx: &mut Context);

    /// Does what it has asked to do in place of its document, once no unsaved work stands in the way.
    fn proceed(&mut self, cx: &mut Context);

    /// Begins to read unsaved work that an earlier program left behind, and asks for [`Request::Recovered`] once it has
    /// taken it; says why it cannot be read.
    ///
    /// [`Request::Recovered`]: super::context::Request::Recovered
    fn recover(&mut self, copy: Recovery, cx: &mut Context);

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

/// The methods of [`Workspace`] that give what every workspace holds: `ABOUT`, commands, and the fields `desk`, `view` and
/// `opening`.
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
