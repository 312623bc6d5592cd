//! Native file dialogs, each on a thread of its own so that no frame waits for it.

use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, channel};

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
    /// Where the picture is saved.
    Picture,
    /// The mesh that was at this path.
    MovedMesh(PathBuf),
}

/// The dialog that is open, if one is.
#[derive(Default)]
pub struct FileDialogs {
    open: Option<(Purpose, Receiver<Option<PathBuf>>)>,
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
            let path = match asked {
                Purpose::Open => dialog
                    .set_title("Open a project or a mesh")
                    .add_filter("Projects and meshes", &[&MESHES[..], &["sparkpath"]].concat())
                    .add_filter("All files", &["*"])
                    .pick_file(),
                Purpose::MovedMesh(_) | Purpose::ElectrodeMesh => {
                    dialog.set_title(&name).add_filter("Meshes", &MESHES).add_filter("All files", &["*"]).pick_file()
                }
                Purpose::SaveProject => dialog
                    .set_title("Save project")
                    .add_filter("Project", &["sparkpath"])
                    .set_file_name(name)
                    .save_file(),
                Purpose::SaveJob => {
                    dialog.set_title("Save job file").add_filter("Job", &["toml"]).set_file_name(name).save_file()
                }
                Purpose::Picture => {
                    dialog.set_title("Save picture").add_filter("PNG", &["png"]).set_file_name(name).save_file()
                }
                Purpose::ExportFolder => dialog.set_title("Folder for the exported files").pick_folder(),
            };
            let _ = sender.send(path);
            ctx.request_repaint();
        });
        if spawned.is_ok() {
            self.open = Some((purpose, receiver));
        }
    }

    /// What was chosen since the last call.
    pub fn chosen(&mut self) -> Option<(Purpose, PathBuf)> {
        let (purpose, receiver) = self.open.as_ref()?;
        let purpose = purpose.clone();
        match receiver.try_recv() {
            Ok(path) => {
                self.open = None;
                path.map(|path| (purpose, path))
            }
            Err(std::sync::mpsc::TryRecvError::Disconnected) => {
                self.open = None;
                None
            }
            Err(std::sync::mpsc::TryRecvError::Empty) => None,
        }
    }
}
