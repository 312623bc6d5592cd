//! Files of a project that are gone or have changed since it was saved: the user finds them, takes them as they are
//! now, or opens the project without them.

use std::path::{Path, PathBuf};

use egui::Ui;
use files::{Document, MovedFile, Params};

use super::context::{Context, PathInfo, PathKind, PathSet, Request};
use crate::widgets::panel_parts::from_right;

/// Title of the dialog.
pub const TITLE: &str = "Files of this project";
/// The path that a workspace asks for to find a file.
pub const FIND: PathInfo = PathInfo::new("Find the file", PathKind::Read("Files", &[], false));

/// A project that is opened once the user has said what becomes of its files that are gone or have changed.
pub struct MovedFiles<P> {
    waiting: Option<(Document<P>, Vec<MovedFile>)>,
    /// The file that is looked for.
    sought: Option<PathBuf>,
}

impl<P> Default for MovedFiles<P> {
    fn default() -> Self {
        Self { waiting: None, sought: None }
    }
}

impl<P: Params> MovedFiles<P> {
    /// Asks the user about `moved` files of `document`, which waits for the answer.
    pub fn ask(&mut self, document: Document<P>, moved: Vec<MovedFile>, cx: &mut Context) {
        (self.waiting, self.sought) = (Some((document, moved)), None);
        cx.request(Request::Dialog);
    }

    /// Whether a project waits for an answer.
    pub fn is_asking(&self) -> bool {
        self.waiting.is_some()
    }

    /// Forgets the project that waits.
    pub fn forget(&mut self) {
        (self.waiting, self.sought) = (None, None);
    }

    /// Puts the file at `path` in the place of the one that is looked for. Returns the project once no file is left to
    /// ask about.
    pub fn found(&mut self, path: &Path, cx: &mut Context) -> Option<Document<P>> {
        let (document, moved) = self.waiting.as_mut()?;
        let sought = self.sought.take()?;
        document.replace_file(&sought, path);
        moved.retain(|file| file.path != sought);
        if !moved.is_empty() {
            return None;
        }
        cx.request(Request::CloseDialog);
        self.waiting.take().map(|(document, _)| document)
    }

    /// Draws the dialog, which asks for `find` where a file is to be found. Returns the project that the user opens
    /// with its files as they are. Afterwards [`is_asking`](Self::is_asking) tells whether the dialog stays open.
    pub fn dialog(&mut self, ui: &mut Ui, cx: &mut Context, find: impl PathSet) -> Option<Document<P>> {
        let (document, moved) = self.waiting.as_ref()?;
        for file in moved {
            let what = if file.is_changed { "has changed since the project was saved" } else { "no longer exists" };
            ui.label(format!("{} {what}.", file.path.display()));
            if ui.button("Find it…").clicked() {
                self.sought = Some(file.path.clone());
                cx.ask(find, "");
            }
            ui.add_space(4.0);
        }
        ui.add_space(10.0);
        let text = if moved.iter().all(|file| file.is_changed) { "Use as it is now" } else { "Open without" };
        let can_open = moved.iter().all(|file| file.is_changed || !document.params().needs(&file.path));
        let (mut is_opened, mut is_cancelled) = (false, false);
        from_right(ui, |ui| {
            is_opened = can_open && ui.button(text).clicked();
            is_cancelled = ui.button("Cancel").clicked();
        });
        if is_cancelled {
            self.forget();
        }
        self.waiting.take_if(|_| is_opened).map(|(document, _)| document)
    }
}

#[cfg(test)]
mod tests {
    use files::{AnyDocument as _, Invalid, PartFile, Validate, sha256};
    use serde::{Deserialize, Serialize};

    use super::*;
    use crate::workspaces::preferences::Preferences;

    #[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
    struct Two {
        lower: PathBuf,
        upper: PathBuf,
    }

    impl Validate for Two {
        fn validate(&self) -> Result<(), Invalid> {
            Ok(())
        }
    }

    impl Params for Two {
        const KIND: &'static str = "two";

        fn part(&self) -> String {
            String::new()
        }

        fn change_paths(&mut self, change: &mut dyn FnMut(&Path) -> PathBuf) {
            (self.lower, self.upper) = (change(&self.lower), change(&self.upper));
        }
    }

    #[test]
    fn a_project_waits_until_each_of_its_files_is_found() {
        let folder = tempfile::tempdir().unwrap();
        let [lower, upper, other, file] = ["a", "b", "c", "p.sparkpath"].map(|name| folder.path().join(name));
        [&lower, &upper, &other].into_iter().for_each(|file| std::fs::write(file, "1").unwrap());
        let mut document = Document::new(Two { lower: lower.clone(), upper: upper.clone() });
        document.note_file(&PartFile { path: upper.clone(), sha256: sha256(b"1") });
        document.save_as(&file).unwrap();
        let open = || Document::<Two>::open(&file).unwrap();
        let (mut moved, mut cx) = (MovedFiles::default(), Context::new(Preferences::default()));
        assert!(open().moved_files().is_empty() && !moved.is_asking());

        std::fs::remove_file(&lower).unwrap();
        std::fs::write(&upper, "2").unwrap();
        let ask = |moved: &mut MovedFiles<Two>, cx: &mut Context| moved.ask(open(), open().moved_files(), cx);
        ask(&mut moved, &mut cx);
        assert!(moved.is_asking());
        assert!(matches!(cx.take_requests()[..], [(_, Request::Dialog)]));
        assert!(moved.found(&other, &mut cx).is_none(), "none is looked for");
        moved.sought = Some(lower.clone());
        assert!(moved.found(&other, &mut cx).is_none() && moved.is_asking(), "the other one has changed");
        moved.sought = Some(upper.clone());
        let found = moved.found(&upper, &mut cx).unwrap();
        assert_eq!(found.params(), &Two { lower: other, upper });
        assert!(found.is_unsaved() && !moved.is_asking());
        assert!(matches!(cx.take_requests()[..], [(_, Request::CloseDialog)]));

        ask(&mut moved, &mut cx);
        assert!(moved.is_asking());
        moved.forget();
        assert!(!moved.is_asking() && moved.found(&file, &mut cx).is_none());
    }
}
