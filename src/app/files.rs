//! Native file dialogs, each on a thread of its own so that no frame waits for it.

use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};

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
    /// Where the picture is saved.
    Picture,
    /// The mesh that was at this path.
    MovedMesh(PathBuf),
}

/// A native dialog that comes back this soon was never seen by anybody: the system has none.
const NEVER_SEEN: Duration = Duration::from_millis(500);

/// The dialog that is open, if one is.
#[derive(Default)]
pub struct FileDialogs {
    open: Option<(Purpose, Receiver<Option<PathBuf>>, Instant)>,
}

/// What became of a dialog.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Chosen {
    /// This was chosen.
    Path(Purpose, PathBuf),
    /// The system has no file dialogs: the path has to be typed.
    NoDialogs(Purpose),
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
            Self::Picture => "Save picture",
            Self::MovedMesh(_) => "Find the mesh",
        }
    }
}

const MESHES: [&str; 8] = ["stl", "STL", "obj", "OBJ", "gltf", "glb", "GLTF", "GLB"];

impl FileDialogs {
    /// Opens a dialog, unless one is open.
    pub fn ask(&mut self, purpose: Purpose, name: &str, folder: Option<&Path>, ctx: &egui::Context) {
        if self.open.is_some() {
            return;
        }
        let mut dialog = rfd::FileDialog::new();
        if let Some(folder) = folder.filter(|f| f.is_dir()) {
            dialog = dialog.set_directory(folder);
        }
        let (asked, name, ctx) = (purpose.clone(), name.to_owned(), ctx.clone());
        let (sender, receiver) = channel();
        let spawned = std::thread::Builder::new().name("file dialog".to_owned()).spawn(move || {
            let path = match &asked {
                Purpose::Open => dialog
                    .set_title(asked.title())
                    .add_filter("Projects and meshes", &[&MESHES[..], &["sparkpath"]].concat())
                    .add_filter("All files", &["*"])
                    .pick_file(),
                Purpose::MovedMesh(_) | Purpose::ElectrodeMesh => dialog
                    .set_title(asked.title())
                    .add_filter("Meshes", &MESHES)
                    .add_filter("All files", &["*"])
                    .pick_file(),
                Purpose::SaveProject => dialog
                    .set_title(asked.title())
                    .add_filter("Project", &["sparkpath"])
                    .set_file_name(name)
                    .save_file(),
                Purpose::SaveJob => {
                    dialog.set_title(asked.title()).add_filter("Job", &["toml"]).set_file_name(name).save_file()
                }
                Purpose::Picture => {
                    dialog.set_title(asked.title()).add_filter("PNG", &["png"]).set_file_name(name).save_file()
                }
                Purpose::Post => dialog.set_title(asked.title()).add_filter("Post", &["toml"]).pick_file(),
                Purpose::ExportFolder => dialog.set_title(asked.title()).pick_folder(),
            };
            let _ = sender.send(path);
            ctx.request_repaint();
        });
        if spawned.is_ok() {
            self.open = Some((purpose, receiver, Instant::now()));
        }
    }

    /// What became of the dialog since the last call.
    pub fn chosen(&mut self) -> Option<Chosen> {
        let (purpose, receiver, since) = self.open.as_ref()?;
        let (purpose, never_seen) = (purpose.clone(), since.elapsed() < NEVER_SEEN);
        match receiver.try_recv() {
            Ok(path) => {
                self.open = None;
                match path {
                    Some(path) => Some(Chosen::Path(purpose, path)),
                    None => never_seen.then_some(Chosen::NoDialogs(purpose)),
                }
            }
            Err(std::sync::mpsc::TryRecvError::Disconnected) => {
                self.open = None;
                None
            }
            Err(std::sync::mpsc::TryRecvError::Empty) => None,
        }
    }
}
