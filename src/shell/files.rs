//! Native file dialogs, each on a thread of its own so that no frame waits for it.

use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, TryRecvError, channel};

use super::system_dialogs::System;
use crate::workspaces::context::{Endings, PathInfo, PathKind};
use files::paths;
use files::patience::Found;

/// Purpose of a chosen path.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Purpose {
    /// Part of the program that asks.
    pub of: Asking,
    /// Title and kind of the path.
    pub info: &'static PathInfo,
}

/// Part of the program that asks for a path.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Asking {
    /// The window, to save a picture.
    Picture,
    /// The window, to save the document of this workspace.
    Document(usize),
    /// A workspace: its number, and the number of the path in its table.
    Workspace(usize, usize),
    /// The window of studies, for a folder to run one in, or else to look at one.
    Study(bool),
}

/// Path of a picture.
pub static PICTURE: PathInfo = PathInfo { title: "Save picture", kind: PathKind::Write("PNG", ".png"), opens: false };

/// Path of a document.
pub static PROJECT: PathInfo =
    PathInfo { title: "Save project", kind: PathKind::Write("Project", ".sparkpath"), opens: false };

/// The open dialog, if any.
#[derive(Default)]
pub struct FileDialogs {
    open: Option<Asked>,
    /// Whether paths are typed even if the system has dialogs.
    pub typed: bool,
    /// Whether the user prefers typing.
    pub is_typing_preferred: bool,
}

/// Result of asking for a path.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Opened {
    /// A dialog asks for the path.
    Asked,
    /// Another dialog is open.
    Busy,
    /// No thread could be started for the dialog.
    Failed,
}

/// The question, with the channel of its answer.
struct Asked {
    purpose: Purpose,
    name: String,
    answer: Receiver<Option<PathBuf>>,
    /// Whether the path is typed in the window, without a dialog of the system.
    is_typed: bool,
}

/// Result of a dialog.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Chosen {
    /// The path that was chosen.
    Path(Purpose, PathBuf),
    /// The user chose nothing.
    Cancelled(Purpose),
    /// The path must be typed, because the system has no file dialogs or the user prefers typing. With the proposed
    /// name.
    ToType(Purpose, String),
}

impl Purpose {
    /// Ending of the file that is written; none if no file is written.
    pub fn ending(&self) -> Option<&'static str> {
        if let PathKind::Write(_, ending) = self.info.kind { Some(ending) } else { None }
    }

    /// Whether a file must be there, and something else was `found`.
    pub fn is_missing(&self, found: Found) -> bool {
        matches!(self.info.kind, PathKind::Read(_, _, true)) && found != Found::File
    }

    /// `path` with the ending of this purpose, added after any dots in the name.
    pub fn with_ending(&self, path: PathBuf) -> PathBuf {
        match self.ending() {
            Some(ending) if !paths::has_ending(&path, ending) => {
                let mut whole = path.into_os_string();
                whole.push(ending);
                whole.into()
            }
            _ => path,
        }
    }
}

impl FileDialogs {
    /// Opens a dialog, unless one is open.
    pub fn ask(&mut self, purpose: Purpose, name: &str, folder: Option<&Path>, ctx: &egui::Context) -> Opened {
        if self.open.is_some() {
            return Opened::Busy;
        }
        let (sender, answer) = channel();
        let is_typed = self.typed || self.is_typing_preferred || !System::present().has_dialogs();
        let asked = Asked { purpose, name: name.to_owned(), answer, is_typed };
        if is_typed {
            let _ = sender.send(None);
            self.open = Some(asked);
            return Opened::Asked;
        }
        let mut dialog = rfd::FileDialog::new();
        let folder = folder.map(Path::to_owned);
        let (name, ctx) = (name.to_owned(), ctx.clone());
        let spawned = std::thread::Builder::new().name("file dialog".to_owned()).spawn(move || {
            if let Some(folder) = folder.filter(|folder| folder.is_dir()) {
                dialog = dialog.set_directory(folder);
            }
            dialog = dialog.set_title(purpose.info.title);
            let path = match purpose.info.kind {
                PathKind::Folder => dialog.pick_folder(),
                PathKind::Write(what, ending) => {
                    dialog.add_filter(what, &[ending.trim_start_matches('.')]).set_file_name(name).save_file()
                }
                PathKind::Read(what, endings, _) => {
                    if !endings.is_empty() {
                        dialog = dialog.add_filter(what, &in_both_cases(endings));
                    }
                    dialog.add_filter("All files", &["*"]).pick_file()
                }
            };
            let _ = sender.send(path);
            ctx.request_repaint();
        });
        self.open = spawned.is_ok().then_some(asked);
        if self.open.is_some() { Opened::Asked } else { Opened::Failed }
    }

    /// Result of the dialog since the last call.
    pub fn chosen(&mut self) -> Option<Chosen> {
        let asked = self.open.as_ref()?;
        let path = match asked.answer.try_recv() {
            Ok(path) => path,
            Err(TryRecvError::Disconnected) => None,
            Err(TryRecvError::Empty) => return None,
        };
        let Asked { purpose, name, is_typed, .. } = self.open.take()?;
        Some(match path {
            Some(path) => Chosen::Path(purpose, path),
            None if is_typed => Chosen::ToType(purpose, name),
            None => Chosen::Cancelled(purpose),
        })
    }
}

/// All `endings`, each once in small letters and once in capitals: some systems tell them apart.
fn in_both_cases(endings: Endings) -> Vec<String> {
    let small = endings.iter().flat_map(|kind| kind.iter());
    let mut all: Vec<String> = small.flat_map(|ending| [ending.to_string(), ending.to_uppercase()]).collect();
    let mut seen = std::collections::BTreeSet::new();
    all.retain(|ending| seen.insert(ending.clone()));
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::workspaces::blisk::paths::BliskPath;
    use crate::workspaces::context::PathSet as _;

    static OPEN: PathInfo = PathInfo { title: "Open", kind: PathKind::Read("", &[], false), opens: true };
    static SAVE: PathInfo = PathInfo { title: "Save", kind: PathKind::Write("", ".sparkpath"), opens: false };
    static FOLDER: PathInfo = PathInfo { title: "Folder", kind: PathKind::Folder, opens: false };

    fn purpose(info: &'static PathInfo) -> Purpose {
        Purpose { of: Asking::Picture, info }
    }

    #[test]
    fn what_no_dialog_asks_for_is_typed_and_no_two_are_asked_at_once() {
        let ctx = egui::Context::default();
        let mut files = FileDialogs { is_typing_preferred: true, ..FileDialogs::default() };
        assert_eq!(files.ask(purpose(&OPEN), "", None, &ctx), Opened::Asked);
        assert_eq!(files.ask(purpose(&PICTURE), "a.png", None, &ctx), Opened::Busy);
        assert_eq!(files.chosen(), Some(Chosen::ToType(purpose(&OPEN), String::new())));
        // However long a failure takes to come back it is no cancelled dialog, and a cancelled one is no failure.
        let (sender, answer) = channel();
        let asked = |answer, is_typed| Asked { purpose: purpose(&OPEN), name: String::new(), answer, is_typed };
        files.open = Some(asked(answer, false));
        assert_eq!(files.chosen(), None);
        sender.send(None).unwrap();
        assert_eq!(files.chosen(), Some(Chosen::Cancelled(purpose(&OPEN))));
    }

    #[test]
    fn dialogs_offer_every_mesh_that_is_read_in_both_cases() {
        let read = |path: BliskPath| match BliskPath::table().iter().find(|(one, _)| *one == path).unwrap().1.kind {
            PathKind::Read(_, endings, _) => in_both_cases(endings),
            _ => Vec::new(),
        };
        let (meshes, open) = (read(BliskPath::ElectrodeMesh), read(BliskPath::Open));
        for ending in import::MESH_ENDINGS {
            let is_once = |all: &[String], ending: &str| all.iter().filter(|one| *one == ending).count() == 1;
            assert!(
                is_once(&meshes, ending) && is_once(&open, &ending.to_uppercase()),
                "{ending}: {meshes:?} {open:?}"
            );
        }
        assert!(open.iter().any(|ending| ending == "sparkpath") && !meshes.iter().any(|ending| ending == "sparkpath"));
    }

    #[test]
    fn a_name_gets_its_ending_once_and_loses_nothing() {
        for (name, whole) in [
            ("a/blisk", "a/blisk.sparkpath"),
            ("blisk v1.5", "blisk v1.5.sparkpath"),
            ("b.sparkpath", "b.sparkpath"),
            ("B.SPARKPATH", "B.SPARKPATH"),
        ] {
            assert_eq!(purpose(&SAVE).with_ending(name.into()), Path::new(whole));
        }
        assert_eq!(purpose(&PICTURE).with_ending("a.jpg".into()), Path::new("a.jpg.png"));
        assert_eq!(purpose(&FOLDER).with_ending("out".into()), Path::new("out"));
    }
}
