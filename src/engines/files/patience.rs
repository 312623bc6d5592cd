//! Work on files whose drive may not answer. The system gives no way to end a call that hangs on such a drive; work is
//! therefore done on a thread of its own, which is left behind if it must be.

use std::io;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, channel};
use std::time::Duration;

use crate::FileError;

/// Time for which a window waits for a drive (s). Drives that are well answer in a few milliseconds.
const MOMENT: Duration = Duration::from_millis(400);
/// Interval at which patient work looks whether it is cancelled.
const LOOK: Duration = Duration::from_millis(20);

/// The result of work on a thread of its own. Dropping it leaves the thread to itself.
#[derive(Debug)]
pub struct Awaited<T>(Receiver<T>);

impl<T: Send + 'static> Awaited<T> {
    /// Starts `work`, and calls `wake` when its result is there.
    ///
    /// # Errors
    /// If the system gives no thread.
    pub fn start(work: impl FnOnce() -> T + Send + 'static, wake: impl FnOnce() + Send + 'static) -> io::Result<Self> {
        let (sender, receiver) = channel();
        let run = move || {
            let _ = sender.send(work());
            wake();
        };
        std::thread::Builder::new().name("files".to_owned()).spawn(run)?;
        Ok(Self(receiver))
    }

    /// The result, once, if it is there.
    pub fn take(&self) -> Option<T> {
        self.0.try_recv().ok()
    }

    /// The result, once, if it is there or comes within a moment: most drives answer so soon that nobody notices.
    pub fn take_soon(&self) -> Option<T> {
        self.0.recv_timeout(MOMENT).ok()
    }
}

/// The result of quick `work` on `file`.
///
/// # Errors
/// Errors of the work, and [`FileError::Silent`] if the drive does not answer within a moment.
pub fn soon<T: Send + 'static>(
    file: &Path,
    work: impl FnOnce(&Path) -> Result<T, FileError> + Send + 'static,
) -> Result<T, FileError> {
    let of = file.to_owned();
    let awaited = Awaited::start(move || work(&of), || {}).map_err(|source| FileError::unreadable(file, source))?;
    awaited.take_soon().unwrap_or_else(|| Err(FileError::Silent { file: file.to_owned() }))
}

/// Kind of entry at a path.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Found {
    /// Nothing, or nothing that can be seen.
    Nothing,
    /// A file.
    File,
    /// A folder.
    Folder,
}

/// Looks up what is at `path`.
///
/// # Errors
/// [`FileError::Silent`] if the drive does not answer within a moment.
pub fn look_at(path: &Path) -> Result<Found, FileError> {
    soon(path, |path| {
        Ok(match std::fs::metadata(path) {
            Ok(of) if of.is_dir() => Found::Folder,
            Ok(_) => Found::File,
            Err(_) => Found::Nothing,
        })
    })
}

/// Waits until the drives of `files` answer, which are only opened: whether they can be read is not looked at. Calls
/// `waiting` with a file that lets wait.
///
/// Returns whether they did before `is_cancelled` held.
pub fn await_files(files: &[PathBuf], is_cancelled: impl Fn() -> bool, waiting: impl Fn(&Path)) -> bool {
    files.iter().all(|file| {
        let of = file.clone();
        let Ok(awaited) = Awaited::start(move || drop(std::fs::File::open(of)), || {}) else { return true };
        if awaited.take_soon().is_some() {
            return true;
        }
        waiting(file);
        loop {
            if is_cancelled() {
                return false;
            }
            if awaited.0.recv_timeout(LOOK).is_ok() {
                return true;
            }
        }
    })
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    /// A pipe that nobody writes to: it cannot even be opened.
    fn silent(folder: &Path) -> PathBuf {
        let pipe = folder.join("pipe");
        assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
        pipe
    }

    #[test]
    fn a_drive_that_does_not_answer_holds_nobody_up() {
        let folder = tempfile::tempdir().unwrap();
        let (pipe, file) = (silent(folder.path()), folder.path().join("file"));
        std::fs::write(&file, "1").unwrap();
        let read = |file: &Path| soon(file, |file| crate::read_text(file, "list", 10));
        assert_eq!(read(&file).unwrap(), "1");
        let silent = read(&pipe).unwrap_err().to_string();
        assert!(silent.contains("pipe") && silent.contains("does not answer"), "{silent}");
        assert!(!await_files(&[file.clone(), pipe], || true, |of| assert!(of.ends_with("pipe"))));
        assert!(await_files(&[file, folder.path().join("none")], || true, |_| {}));
    }

    #[test]
    fn what_is_at_a_path_is_told() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("file");
        std::fs::write(&file, "1").unwrap();
        let found = [&file, folder.path(), &folder.path().join("none")].map(|path| look_at(path).unwrap());
        assert_eq!(found, [Found::File, Found::Folder, Found::Nothing]);
    }
}
