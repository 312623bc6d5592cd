//! Size and time of files when they were read, to notice later changes.

use std::path::{Path, PathBuf};
use std::time::SystemTime;

use crate::workspaces::flank::document::{FlankSource, GuideSource};
use files::{PartFile, sha256_of};

/// A file with its size (bytes) and time of writing, as far as known.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Stamp {
    file: PathBuf,
    seen: Option<(u64, Option<SystemTime>)>,
}

impl Stamp {
    /// The present stamp of `file`.
    pub fn of(file: &Path) -> Self {
        let seen = std::fs::metadata(file).ok().map(|data| (data.len(), data.modified().ok()));
        Self { file: file.to_owned(), seen }
    }

    /// Stamps of the files of a source.
    pub fn of_source(source: &FlankSource) -> Vec<Self> {
        let files: Vec<&Path> = match source {
            FlankSource::Demonstration { .. } => Vec::new(),
            FlankSource::Guides { lower, upper } => {
                let files = [lower, upper].into_iter().filter_map(|guide| match guide {
                    GuideSource::File(file) => Some(file.as_path()),
                    GuideSource::Curve(_) => None,
                });
                files.collect()
            }
            FlankSource::Mesh(mesh) if mesh.kept.is_some() => Vec::new(),
            FlankSource::Mesh(mesh) => vec![&mesh.file],
        };
        files.into_iter().map(Self::of).collect()
    }

    /// The file with its digest, unless it has changed since or cannot be read.
    pub fn part_file(&self) -> Option<PartFile> {
        let sha256 = sha256_of(&self.file).ok()?;
        self.changed().is_none().then(|| PartFile { path: self.file.clone(), sha256 })
    }

    /// The file, if its stamp differs now or it is gone.
    pub fn changed(&self) -> Option<&Path> {
        (Self::of(&self.file) != *self).then_some(&self.file)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_that_are_written_again_or_gone_have_changed() {
        let folder = tempfile::tempdir().unwrap();
        let [lower, upper] = ["a.csv", "b.csv"].map(|name| folder.path().join(name));
        [&lower, &upper].into_iter().for_each(|file| std::fs::write(file, "1,2,3").unwrap());
        let stamps = Stamp::of_source(&FlankSource::guides([lower.clone(), upper.clone()]));
        let changed = || stamps.iter().filter_map(Stamp::changed).collect::<Vec<_>>();
        assert!(stamps.len() == 2 && changed().is_empty());
        assert_eq!(stamps[1].part_file().unwrap().sha256, files::sha256(b"1,2,3"));
        std::fs::write(&upper, "1,2,3,4").unwrap();
        assert_eq!(changed(), [upper.as_path()]);
        assert_eq!(stamps[1].part_file(), None, "what was read is not what is there now");
        std::fs::remove_file(&lower).unwrap();
        assert_eq!(changed(), [lower.as_path(), upper.as_path()]);
        assert!(Stamp::of_source(&FlankSource::default()).is_empty());
    }
}
