//! Atomic writing: a file is either the old one or the whole new one.

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::Path;
use std::time::Duration;

use crate::FileError;

/// Beginning and end of temporary names.
const PREFIX: &str = ".sparkpath-";
const SUFFIX: &str = ".part";
/// A temporary file is that of a program that was killed once nothing was written to it for so long.
const LEFT: Duration = Duration::from_secs(60);

/// Writes a file through `write` under a temporary name in the same folder and renames it to `path` at the end.
///
/// A reader of `path` sees the former file or the complete new one. After an error the former file is unchanged and the
/// temporary file is removed. The folder must exist.
///
/// # Errors
/// The errors of `write` and of the file system.
pub fn atomic_write(path: &Path, write: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> io::Result<()> {
    let folder = match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    let mut builder = tempfile::Builder::new();
    builder.prefix(PREFIX).suffix(SUFFIX);
    // Temporary files are private to their owner by default; this one becomes an ordinary file, under the umask.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    let file = builder.tempfile_in(folder).map_err(without_path)?;
    let mut buffered: BufWriter<&File> = BufWriter::with_capacity(1 << 20, file.as_file());
    write(&mut buffered)?;
    buffered.flush()?;
    drop(buffered);
    file.as_file().sync_all()?;
    file.persist(path).map_err(|e| e.error)?;
    Ok(())
}

/// Writes `bytes` as the whole content of `path`, atomically.
///
/// # Errors
/// [`FileError::Unwritable`]; a file already at `path` is then untouched.
pub fn write_bytes(path: &Path, bytes: &[u8]) -> Result<(), FileError> {
    atomic_write(path, |file| file.write_all(bytes)).map_err(|source| FileError::unwritable(path, source))
}

/// Removes the temporary files in `folder` of programs that were killed while they wrote.
pub(crate) fn remove_left(folder: &Path) {
    for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
        let name = entry.file_name();
        let is_temporary = name.to_str().is_some_and(|name| name.starts_with(PREFIX) && name.ends_with(SUFFIX));
        let is_left = || {
            let of = entry.metadata().ok().filter(std::fs::Metadata::is_file)?;
            of.modified().ok()?.elapsed().ok().map(|age| age > LEFT)
        };
        if is_temporary && is_left() == Some(true) {
            // One that cannot be removed does no harm.
            let _ = std::fs::remove_file(entry.path());
        }
    }
}

/// The error without the temporary name at its end, which the user does not know.
fn without_path(error: io::Error) -> io::Error {
    let text = error.to_string();
    let cause = text.split_once(" at path ").map(|(cause, _)| cause.to_owned());
    match cause {
        Some(cause) => io::Error::new(error.kind(), cause),
        None => error,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    fn names(folder: &Path) -> Vec<String> {
        fs::read_dir(folder).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect()
    }

    #[test]
    fn a_failed_write_leaves_the_former_file_and_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("part.txt");
        write_bytes(&path, b"old").unwrap();
        let failed = atomic_write(&path, |w| {
            w.write_all(b"half of the n")?;
            Err(io::Error::other("disk full"))
        });
        assert!(failed.is_err());
        assert_eq!(fs::read(&path).unwrap(), b"old");
        write_bytes(&path, b"new").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"new");
        assert_eq!(names(folder.path()), ["part.txt"]);
    }

    #[test]
    fn temporary_files_of_killed_programs_go_and_no_others() {
        let folder = tempfile::tempdir().unwrap();
        let [left, young, other] = [".sparkpath-a.part", ".sparkpath-b.part", "c.part"].map(|n| folder.path().join(n));
        [&left, &young, &other].into_iter().for_each(|file| fs::write(file, "half").unwrap());
        for file in [&left, &other] {
            File::options()
                .write(true)
                .open(file)
                .unwrap()
                .set_modified(std::time::SystemTime::now() - 2 * LEFT)
                .unwrap();
        }
        fs::create_dir(folder.path().join(".sparkpath-d.part")).unwrap();
        remove_left(folder.path());
        let mut left = names(folder.path());
        left.sort();
        assert_eq!(left, [".sparkpath-b.part", ".sparkpath-d.part", "c.part"]);
    }

    #[test]
    fn a_missing_folder_is_named_and_the_temporary_file_is_not() {
        let folder = tempfile::tempdir().unwrap();
        let error = write_bytes(&folder.path().join("none/part.txt"), b"").unwrap_err().to_string();
        assert!(error.contains("none") && !error.contains(".sparkpath-"), "{error}");
    }
}
