//! Native file dialogs, each on a thread of its own so that no frame waits for it.

use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, TryRecvError, channel};

use super::system_dialogs::System;
use crate::workspaces::flank::document::flank_file;
use crate::workspaces::mold::document::mold_file::ENDING;

/// What a chosen path is for.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Purpose {
    /// Project or mesh to open.
    Open,
    /// Where the project is saved; then the program goes on with what it was asked for.
    SaveProject,
    /// Where the job file for the command line is written.
    SaveJob,
    /// Folder for the exported files.
    ExportFolder,
    /// An electrode mesh of one's own.
    ElectrodeMesh,
    /// An NC post of one's own.
    Post,
    /// A machine file of one's own.
    Machine,
    /// Where the picture is saved.
    Picture,
    /// The mesh of a mold.
    Mold,
    /// A library of cutters.
    Cutters,
    /// Another one to compare with.
    OtherCutters,
    /// Where the mold is saved.
    SaveMold,
    /// Folder for the files of electrodes.
    ElectrodeFolder,
    /// A template of the burn sheet.
    BurnSheet,
    /// Where the cutters are saved.
    SaveCutters,
    /// The mesh that was at this path.
    MovedMesh(PathBuf),
    /// Something of a flank.
    Flank(FlankPurpose),
    /// Where the flank is saved.
    SaveFlank,
}

/// What of a flank a chosen path is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FlankPurpose {
    /// A flank that was saved, or a mesh with one.
    Open,
    /// Points of the lower guide curve.
    Lower,
    /// Of the upper one.
    Upper,
    /// A mesh with the flank.
    Mesh,
    /// Walls that must not be cut.
    Walls,
    /// A machine of one's own.
    Machine,
    /// A post of one's own.
    Post,
    /// Folder for the exported files.
    Folder,
}

impl FlankPurpose {
    fn title(self) -> &'static str {
        match self {
            Self::Open => "Open a flank",
            Self::Lower => "Points of the lower guide curve",
            Self::Upper => "Points of the upper guide curve",
            Self::Mesh => "Mesh with the flank",
            Self::Walls => "Neighbouring walls",
            Self::Machine => "Your own milling machine",
            Self::Post => "Your own post for milling",
            Self::Folder => "Folder for the flank's files",
        }
    }

    /// What the dialog offers, and the endings of that.
    fn filter(self) -> (&'static str, Vec<&'static str>) {
        match self {
            Self::Open => ("Flanks, meshes and points", [&MESHES[..], &["sparkflank", "csv", "txt"]].concat()),
            Self::Lower | Self::Upper => ("Points", vec!["csv", "txt"]),
            Self::Mesh | Self::Walls => ("Meshes", MESHES.to_vec()),
            Self::Machine | Self::Folder => ("Machine", vec!["toml"]),
            Self::Post => ("Post", vec!["toml"]),
        }
    }
}

/// The dialog that is open, if one is.
#[derive(Default)]
pub struct FileDialogs {
    open: Option<Asked>,
    /// Whether paths are typed even where the system has dialogs.
    pub typed: bool,
    /// Whether the user would rather type them.
    pub is_typing_preferred: bool,
}

/// What became of a question for a path.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Opened {
    /// It is asked.
    Asked,
    /// Another one is still open.
    Busy,
    /// The system gives no thread to ask on.
    Failed,
}

/// What was asked, and where the answer comes from.
struct Asked {
    purpose: Purpose,
    name: String,
    answer: Receiver<Option<PathBuf>>,
    /// Whether nothing of the system asks for it.
    is_typed: bool,
}

/// What became of a dialog.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Chosen {
    /// This was chosen.
    Path(Purpose, PathBuf),
    /// The user chose nothing.
    Cancelled(Purpose),
    /// The path is to be typed: the system has no file dialogs, or they are not wanted. With the name that was proposed.
    ToType(Purpose, String),
}

impl Purpose {
    /// The title of its dialog.
    pub fn title(&self) -> &str {
        match self {
            Self::Open => "Open a project or a mesh",
            Self::SaveProject => "Save project",
            Self::SaveJob => "Save job file",
            Self::ExportFolder => "Folder for the exported files",
            Self::ElectrodeMesh => "Your own electrode",
            Self::Post => "Your own NC post",
            Self::Machine => "Your own machine",
            Self::Picture => "Save picture",
            Self::Mold => "Open a mold",
            Self::Cutters => "Load cutters",
            Self::OtherCutters => "Load cutters to compare with",
            Self::SaveMold => "Save mold",
            Self::SaveCutters => "Save cutters",
            Self::BurnSheet => "Template of the burn sheet",
            Self::ElectrodeFolder => "Folder for the electrodes",
            Self::MovedMesh(_) => "Find the mesh",
            Self::Flank(what) => what.title(),
            Self::SaveFlank => "Save flank",
        }
    }

    /// How the name of a file ends that is written for this; none if no file is written.
    pub fn ending(&self) -> Option<&'static str> {
        match self {
            Self::SaveProject => Some(".sparkpath"),
            Self::SaveMold => Some(ENDING),
            Self::SaveFlank => Some(flank_file::ENDING),
            Self::SaveJob | Self::SaveCutters => Some(".toml"),
            Self::Picture => Some(".png"),
            Self::Open | Self::ExportFolder | Self::ElectrodeMesh | Self::Post | Self::Machine | Self::MovedMesh(_) => {
                None
            }
            Self::Mold
            | Self::Cutters
            | Self::OtherCutters
            | Self::ElectrodeFolder
            | Self::BurnSheet
            | Self::Flank(_) => None,
        }
    }

    /// What there is not at `path` that would have to be for this; none if there is, or if other words are found for it.
    pub fn missing(&self, path: &Path) -> Option<&'static str> {
        match self {
            Self::Flank(FlankPurpose::Folder) => None,
            Self::Flank(_) => (!path.is_file()).then_some("file"),
            _ => None,
        }
    }

    /// `path` with the ending that belongs to this, after whatever dots the name has.
    pub fn with_ending(&self, path: PathBuf) -> PathBuf {
        let name = path.as_os_str().to_string_lossy().to_lowercase();
        match self.ending() {
            Some(ending) if !name.ends_with(ending) => {
                let mut whole = path.into_os_string();
                whole.push(ending);
                whole.into()
            }
            _ => path,
        }
    }
}

const MESHES: [&str; 8] = ["stl", "STL", "obj", "OBJ", "gltf", "glb", "GLTF", "GLB"];

impl FileDialogs {
    /// Opens a dialog, unless one is open.
    pub fn ask(&mut self, purpose: Purpose, name: &str, folder: Option<&Path>, ctx: &egui::Context) -> Opened {
        if self.open.is_some() {
            return Opened::Busy;
        }
        let (sender, answer) = channel();
        let is_typed = self.typed || self.is_typing_preferred || !System::present().has_dialogs();
        let asked = Asked { purpose: purpose.clone(), name: name.to_owned(), answer, is_typed };
        if is_typed {
            let _ = sender.send(None);
            self.open = Some(asked);
            return Opened::Asked;
        }
        let mut dialog = rfd::FileDialog::new();
        if let Some(folder) = folder.filter(|f| f.is_dir()) {
            dialog = dialog.set_directory(folder);
        }
        let (name, ctx) = (name.to_owned(), ctx.clone());
        let spawned = std::thread::Builder::new().name("file dialog".to_owned()).spawn(move || {
            let path = match &purpose {
                Purpose::Open => dialog
                    .set_title(purpose.title())
                    .add_filter(
                        "Projects and meshes",
                        &[&MESHES[..], &["sparkpath", "sparkmold", "sparkflank"]].concat(),
                    )
                    .add_filter("All files", &["*"])
                    .pick_file(),
                Purpose::MovedMesh(_) | Purpose::ElectrodeMesh => dialog
                    .set_title(purpose.title())
                    .add_filter("Meshes", &MESHES)
                    .add_filter("All files", &["*"])
                    .pick_file(),
                Purpose::SaveProject => dialog
                    .set_title(purpose.title())
                    .add_filter("Project", &["sparkpath"])
                    .set_file_name(name)
                    .save_file(),
                Purpose::SaveJob => {
                    dialog.set_title(purpose.title()).add_filter("Job", &["toml"]).set_file_name(name).save_file()
                }
                Purpose::Picture => {
                    dialog.set_title(purpose.title()).add_filter("PNG", &["png"]).set_file_name(name).save_file()
                }
                Purpose::Cutters | Purpose::OtherCutters => {
                    dialog.set_title(purpose.title()).add_filter("Cutters", &["toml"]).pick_file()
                }
                Purpose::BurnSheet => dialog.set_title(purpose.title()).add_filter("All files", &["*"]).pick_file(),
                Purpose::Mold => dialog
                    .set_title(purpose.title())
                    .add_filter("Molds and meshes", &[&MESHES[..], &["sparkmold"]].concat())
                    .add_filter("All files", &["*"])
                    .pick_file(),
                Purpose::SaveMold => {
                    dialog.set_title(purpose.title()).add_filter("Mold", &["sparkmold"]).set_file_name(name).save_file()
                }
                Purpose::SaveCutters => {
                    dialog.set_title(purpose.title()).add_filter("Cutters", &["toml"]).set_file_name(name).save_file()
                }
                Purpose::Machine => dialog.set_title(purpose.title()).add_filter("Machine", &["toml"]).pick_file(),
                Purpose::Post => dialog.set_title(purpose.title()).add_filter("Post", &["toml"]).pick_file(),
                Purpose::ExportFolder | Purpose::ElectrodeFolder | Purpose::Flank(FlankPurpose::Folder) => {
                    dialog.set_title(purpose.title()).pick_folder()
                }
                Purpose::Flank(what) => {
                    let (name, endings) = what.filter();
                    dialog
                        .set_title(what.title())
                        .add_filter(name, &endings)
                        .add_filter("All files", &["*"])
                        .pick_file()
                }
                Purpose::SaveFlank => dialog
                    .set_title(purpose.title())
                    .add_filter("Flank", &["sparkflank"])
                    .set_file_name(name)
                    .save_file(),
            };
            let _ = sender.send(path);
            ctx.request_repaint();
        });
        self.open = spawned.is_ok().then_some(asked);
        if self.open.is_some() { Opened::Asked } else { Opened::Failed }
    }

    /// What became of the dialog since the last call.
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_no_dialog_asks_for_is_typed_and_no_two_are_asked_at_once() {
        let ctx = egui::Context::default();
        let mut files = FileDialogs { is_typing_preferred: true, ..FileDialogs::default() };
        assert_eq!(files.ask(Purpose::Open, "", None, &ctx), Opened::Asked);
        assert_eq!(files.ask(Purpose::Picture, "a.png", None, &ctx), Opened::Busy);
        assert_eq!(files.chosen(), Some(Chosen::ToType(Purpose::Open, String::new())));
        // However long a failure takes to come back it is no cancelled dialog, and a cancelled one is no failure.
        let (sender, answer) = channel();
        let asked = |answer, is_typed| Asked { purpose: Purpose::Post, name: String::new(), answer, is_typed };
        files.open = Some(asked(answer, false));
        assert_eq!(files.chosen(), None);
        sender.send(None).unwrap();
        assert_eq!(files.chosen(), Some(Chosen::Cancelled(Purpose::Post)));
    }

    #[test]
    fn a_name_gets_its_ending_once_and_loses_nothing() {
        for (name, whole) in [
            ("a/blisk", "a/blisk.sparkpath"),
            ("blisk v1.5", "blisk v1.5.sparkpath"),
            ("b.sparkpath", "b.sparkpath"),
            ("B.SPARKPATH", "B.SPARKPATH"),
        ] {
            assert_eq!(Purpose::SaveProject.with_ending(name.into()), Path::new(whole));
        }
        assert_eq!(Purpose::Picture.with_ending("a.jpg".into()), Path::new("a.jpg.png"));
        assert_eq!(Purpose::ExportFolder.with_ending("out".into()), Path::new("out"));
    }
}
