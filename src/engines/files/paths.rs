//! Paths in files, relative to the folder of the file.

use std::path::{Path, PathBuf};

use crate::FileError;

/// Refuses a file whose name is no UTF-8: text files, such as copies of unsaved work, could not name it.
///
/// # Errors
/// [`FileError::Unnamed`].
pub fn check_name(file: &Path) -> Result<(), FileError> {
    match file.to_str() {
        Some(_) => Ok(()),
        None => Err(FileError::Unnamed { file: file.to_owned() }),
    }
}

/// `path` as an absolute path; an empty one is the working folder.
pub fn absolute(path: &Path) -> PathBuf {
    std::path::absolute(if path.as_os_str().is_empty() { Path::new(".") } else { path })
        .unwrap_or_else(|_| path.to_owned())
}

/// `path` without the `folder/..` that [`relative`] makes necessary, so that a mesh keeps its name through saving and
/// opening.
pub fn without_detours(path: &Path) -> PathBuf {
    use std::path::Component;
    let mut short = PathBuf::new();
    for part in path.components() {
        if part == Component::ParentDir && matches!(short.components().next_back(), Some(Component::Normal(_))) {
            short.pop();
        } else {
            short.push(part);
        }
    }
    short
}

/// Folder that paths in `file` are relative to.
pub fn folder_of(file: &Path) -> PathBuf {
    absolute(file.parent().unwrap_or(Path::new("")))
}

/// Whether the name of `path` ends with `ending`, a point and letters of any case.
pub fn has_ending(path: &Path, ending: &str) -> bool {
    path.extension().is_some_and(|e| ending.strip_prefix('.').is_some_and(|own| e.eq_ignore_ascii_case(own)))
}

/// `path` relative to the absolute `folder`, with `..` where it lies beside it; absolute where both share no root.
pub fn relative(path: &Path, folder: &Path) -> PathBuf {
    let path = absolute(path);
    let common = path.components().zip(folder.components()).take_while(|(a, b)| a == b).count();
    if common == 0 {
        return path;
    }
    let up = folder.components().skip(common).map(|_| std::path::Component::ParentDir);
    up.chain(path.components().skip(common)).collect()
}

/// The folder of the user's settings and lists, if the system has one. The program looks there for `mold.sparkpath`,
/// `holders.toml` and the folder `holders`.
pub fn user_folder() -> Option<PathBuf> {
    Some(directories::ProjectDirs::from("", "", "sparkpath")?.config_dir().to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_are_written_as_seen_from_the_file() {
        let seen = relative(Path::new("/a/b/part.stl"), Path::new("/a/c"));
        assert_eq!(without_detours(&Path::new("/a/c").join(&seen)).as_os_str(), "/a/b/part.stl");
        assert_eq!(without_detours(Path::new("../../part.stl")).as_os_str(), "../../part.stl");
        assert_eq!(seen, Path::new("../b/part.stl"));
        assert_eq!(relative(Path::new("/a/part.stl"), Path::new("/a")), Path::new("part.stl"));
    }
}
