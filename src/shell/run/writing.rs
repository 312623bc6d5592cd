//! What the window writes beside projects: job files, exported plans, pictures.

use std::path::Path;

use super::SparkpathApp;
use crate::shell::dialogs::Dialog;
use crate::workspaces::blisk::document::fields::{Field, job_as_json, with_value};
use crate::workspaces::blisk::document::machine_file::read_machine;
use crate::workspaces::blisk::document::stage::Stage;
use crate::workspaces::blisk::export;
use crate::workspaces::blisk::pipeline::{EventKind, ExportWork};
use nc::post::Post;
use render::scene::Scene;
use task::{Cancel, Progress};

impl SparkpathApp {
    pub(super) fn write_job(&mut self, path: &Path) {
        let text = self.core.document.job().to_toml(path.parent().unwrap_or(Path::new("")));
        let written = text.and_then(|text| {
            files::atomic::atomic_write(path, |out| out.write_all(text.as_bytes())).map_err(|e| e.to_string())
        });
        match written {
            Ok(()) => self.core.say(EventKind::Done, format!("job file written to {}", path.display())),
            Err(e) => self.dialog = Dialog::Error("The job file was not written".to_owned(), e),
        }
    }

    /// Takes the post in this file, if it is one.
    pub fn take_post(&mut self, path: &Path) {
        let name = path.to_string_lossy().into_owned();
        match Post::named(&name) {
            Ok(_) => {
                let mut job = self.core.document.job().clone();
                job.export.post = name;
                self.core.edit("NC program Post-processor", job, false);
            }
            Err(error) => {
                let before = std::mem::take(&mut self.dialog);
                self.behind = before;
                self.dialog = Dialog::Error("This is no post".to_owned(), error.to_string());
            }
        }
    }

    /// Takes the machine in the file `path`; says why not if it is none.
    pub fn take_machine(&mut self, path: &Path) {
        let name = path.to_string_lossy().into_owned();
        let job = job_as_json(self.core.document.job());
        let field = Field::of(Stage::Plan).find(|f| f.pointer == "/machine/name");
        let read = read_machine(&name, &Progress::silent(), &Cancel::default()).map_err(|e| e.to_string());
        let taken = read.and_then(|_| field.map_or(Err(String::new()), |f| with_value(&job, f, name.into())));
        match taken {
            Ok(job) => self.core.edit("Machine Bodies", job, false),
            Err(error) => {
                self.behind = std::mem::take(&mut self.dialog);
                self.dialog = Dialog::Error("This is no machine".to_owned(), error);
            }
        }
    }

    /// Writes the files of the released plan into `folder`, as the export dialog does; says why not if it cannot.
    pub fn export(&mut self, folder: &Path) {
        let write: ExportWork = Box::new(|folder, released, inputs, files, progress, cancel| {
            let exported = export::export(folder, released.plan(), inputs, files, progress, cancel);
            exported.map(|(_, written)| written).map_err(|e| e.to_string())
        });
        if let Err(why) = self.core.pipeline.start_export(folder, write) {
            self.dialog = Dialog::Error("Nothing was exported".to_owned(), why);
        }
    }

    pub(super) fn write_picture(&mut self, path: &Path) {
        let (scene, camera) = self.seen().picture();
        // A picture has nothing else that tells the axes.
        let scene = Scene { triad: true, ..(**scene).clone() };
        self.pictures.write(path, scene, *camera);
    }

    /// Says what became of the pictures that were asked for.
    pub(super) fn follow_pictures(&mut self) {
        for written in self.pictures.written() {
            match written {
                Ok(path) => self.core.say(EventKind::Done, format!("picture written to {}", path.display())),
                Err(why) => self.core.say(EventKind::Failed, format!("the picture was not written: {why}")),
            }
        }
    }
}
