//! Native file dialogs, each on a thread of its own so that no frame waits for it.

use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, TryRecvError, channel};
use std::time::{Duration, Instant};

use crate::project::flank_file;
use crate::project::mold_file::ENDING;

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
            Self::Folder => "Folder for the flank's files",
        }
    }

    /// What the dialog offers, and the endings of that.
    fn filter(self) -> (&'static str, Vec<&'static str>) {
        match self {
            Self::Open => ("Flanks and meshes", [&MESHES[..], &["sparkflank"]].concat()),
            Self::Lower | Self::Upper => ("Points", vec!["csv", "txt"]),
            Self::Mesh | Self::Walls => ("Meshes", MESHES.to_vec()),
            Self::Machine | Self::Folder => ("Machine", vec!["toml"]),
        }
    }
}

/// A native dialog that comes back this soon was never seen by anybody: the system has none.
const NEVER_SEEN: Duration = Duration::from_millis(500);

/// The dialog that is open, if one is.
#[derive(Default)]
pub struct FileDialogs {
    open: Option<Asked>,
    /// Whether paths are typed even where the system has dialogs.
    pub typed: bool,
}

/// What was asked, and where the answer comes from.
struct Asked {
    purpose: Purpose,
    name: String,
    answer: Receiver<Option<PathBuf>>,
    since: Instant,
}

/// What became of a dialog.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Chosen {
    /// This was chosen.
    Path(Purpose, PathBuf),
    /// The user chose nothing.
    Cancelled(Purpose),
    /// The system has no file dialogs: the path has to be typed. With the name that was proposed.
    NoDialogs(Purpose, String),
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
            Self::Mold | Self::Cutters | Self::OtherCutters | Self::ElectrodeFolder | Self::Flank(_) => None,
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
    /// Opens a dialog, unless one is open. Tells whether it did.
    pub fn ask(&mut self, purpose: Purpose, name: &str, folder: Option<&Path>, ctx: &egui::Context) -> bool {
        if self.open.is_some() {
            return false;
        }
        let (sender, answer) = channel();
        let asked = Asked { purpose: purpose.clone(), name: name.to_owned(), answer, since: Instant::now() };
        if self.typed {
            let _ = sender.send(None);
            self.open = Some(asked);
            return true;
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
        self.open.is_some()
    }

    /// What became of the dialog since the last call.
    pub fn chosen(&mut self) -> Option<Chosen> {
        let asked = self.open.as_ref()?;
        let path = match asked.answer.try_recv() {
            Ok(path) => path,
            Err(TryRecvError::Disconnected) => None,
            Err(TryRecvError::Empty) => return None,
        };
        let Asked { purpose, name, since, .. } = self.open.take()?;
        Some(match path {
            Some(path) => Chosen::Path(purpose, path),
            None if self.typed || since.elapsed() < NEVER_SEEN => Chosen::NoDialogs(purpose, name),
            None => Chosen::Cancelled(purpose),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
