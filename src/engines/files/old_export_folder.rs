//! A folder that gets all files of an export or none.

use std::fs::File;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use crate::whole_file::WriteError;

/// What is put behind the name of a file of an earlier export that is not to be taken for one of the present one.
const OLD: &str = "old";

/// A folder into which files are written unseen, and moved all together at the end.
///
/// They wait in a hidden folder within it: beside it there may be another file system, or no right to write. Until they are
/// [published](Self::publish) the folder is as it was; dropped before, nothing of them stays, nor do folders that were made
/// for them.
#[derive(Debug)]
pub struct ExportFolder {
    folder: PathBuf,
    // Before the folders: fields are dropped in order, and these go only when they are empty.
    waiting: tempfile::TempDir,
    names: Vec<String>,
    /// Files of an earlier export, and what they will be called.
    aside: Vec<[PathBuf; 2]>,
    _made: MadeFolders,
}

/// Folders that were made, the innermost first, which go again unless something is in them.
#[derive(Debug, Default)]
struct MadeFolders(Vec<PathBuf>);

impl Drop for MadeFolders {
    fn drop(&mut self) {
        // One that holds something cannot be removed, and is to stay.
        self.0.iter().for_each(|folder| drop(std::fs::remove_dir(folder)));
    }
}

impl ExportFolder {
    /// The folder, made if it is not there.
    ///
    /// # Errors
    /// [`WriteError`] if it cannot be made or nothing can be written into it.
    pub fn open(folder: &Path) -> Result<Self, WriteError> {
        let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
        let wrong = |source| WriteError { path: folder.to_owned(), source };
        let missing = folder.ancestors().take_while(|f| !f.as_os_str().is_empty() && !f.exists());
        let made = MadeFolders(missing.map(Path::to_owned).collect());
        std::fs::create_dir_all(folder).map_err(wrong)?;
        let waiting = tempfile::Builder::new().prefix(".sparkpath-").suffix(".part").tempdir_in(folder);
        // The system's reason alone: nobody asked for the hidden folder.
        let waiting = waiting.map_err(|e| wrong(e.kind().into()))?;
        Ok(Self { folder: folder.to_owned(), waiting, names: Vec::new(), aside: Vec::new(), _made: made })
    }

    /// The path of a file once it is published.
    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.join(name)
    }

    /// The names of the files that are there before anything is published, in order; none where they cannot be read.
    pub fn names(&self) -> Vec<String> {
        let entries = std::fs::read_dir(&self.folder).into_iter().flatten().flatten();
        let files = entries.filter(|entry| entry.path().is_file());
        let mut names: Vec<String> = files.filter_map(|entry| entry.file_name().into_string().ok()).collect();
        names.sort_unstable();
        names
    }

    /// Writes a file; one that has the name already is replaced when all are published.
    ///
    /// # Errors
    /// [`WriteError`] that names the file where it is to be.
    pub fn write(&mut self, name: &str, bytes: &[u8]) -> Result<PathBuf, WriteError> {
        let path = self.path(name);
        let written = || -> io::Result<()> {
            // What cannot be replaced should be known before anything is.
            if path.is_dir() {
                return Err(io::ErrorKind::IsADirectory.into());
            }
            let mut file = File::create(self.waiting.path().join(name))?;
            file.write_all(bytes)?;
            file.sync_all()
        };
        written().map_err(|source| WriteError { path: path.clone(), source })?;
        self.names.push(name.to_owned());
        Ok(path)
    }

    /// Has a file of an earlier export called `NAME.old`, or `NAME.old-2` and so on where there is one of that name, once
    /// all are published: nothing is deleted. Answers the name; none if there is no such file.
    pub fn set_aside(&mut self, name: &str) -> Option<String> {
        let path = self.path(name);
        if !path.is_file() {
            return None;
        }
        let numbered = (2..).map(|n: u64| format!("{name}.{OLD}-{n}"));
        let mut names = std::iter::once(format!("{name}.{OLD}")).chain(numbered);
        let free = names.find(|name| self.path(name).symlink_metadata().is_err())?;
        self.aside.push([path, self.path(&free)]);
        Some(free)
    }

    /// Moves all files to where they are to be, in the order in which they were written; first those out of the way that
    /// are [set aside](Self::set_aside). Other files of the folder stay.
    ///
    /// # Errors
    /// [`WriteError`]; each file is then the old one or the new one.
    pub fn publish(self) -> Result<(), WriteError> {
        for [from, to] in &self.aside {
            std::fs::rename(from, to).map_err(|source| WriteError { path: to.clone(), source })?;
        }
        for name in &self.names {
            let path = self.path(name);
            std::fs::rename(self.waiting.path().join(name), &path).map_err(|source| WriteError { path, source })?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_set_aside_is_never_lost_nor_touched_before_the_rest_is_there() {
        let folder = tempfile::tempdir().unwrap();
        let read = |name: &str| std::fs::read_to_string(folder.path().join(name)).unwrap();
        for (round, wanted) in ["path.ngc.old", "path.ngc.old-2", "path.ngc.old-3"].into_iter().enumerate() {
            std::fs::write(folder.path().join("path.ngc"), round.to_string()).unwrap();
            let mut dropped = ExportFolder::open(folder.path()).unwrap();
            assert_eq!(dropped.set_aside("path.ngc").as_deref(), Some(wanted));
            drop(dropped);
            assert_eq!(read("path.ngc"), round.to_string(), "nothing was published");
            let mut out = ExportFolder::open(folder.path()).unwrap();
            assert_eq!(out.set_aside("path.ngc").as_deref(), Some(wanted));
            assert_eq!(out.set_aside("none.ngc"), None);
            out.write("report.html", b"new").unwrap();
            out.publish().unwrap();
            assert_eq!((read(wanted), read("report.html")), (round.to_string(), "new".to_owned()));
        }
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 4);
        assert_eq!(read("path.ngc.old"), "0");
    }

    #[test]
    fn a_folder_that_cannot_be_is_answered_before_there_is_anything_to_write() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("file");
        std::fs::write(&file, "").unwrap();
        for wrong in [file.clone(), file.join("deeper")] {
            let error = ExportFolder::open(&wrong).unwrap_err();
            assert_eq!(error.path, wrong);
            assert!(!error.to_string().contains(".part"), "{error}");
        }
    }
}
