//! The files opened last.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

/// Most files that are remembered.
const MOST: usize = 12;

/// The files opened last, the latest first.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct RecentFiles(Vec<PathBuf>);

impl RecentFiles {
    /// Puts `path` in front.
    pub fn add(&mut self, path: &Path) {
        let path = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
        self.remove(&path);
        self.0.insert(0, path);
        self.0.truncate(MOST);
    }

    /// Forgets `path`.
    pub fn remove(&mut self, path: &Path) {
        self.0.retain(|p| p != path);
    }

    /// Forgets all of them.
    pub fn clear(&mut self) {
        self.0.clear();
    }

    /// The files, the latest first.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = &Path> {
        self.0.iter().map(PathBuf::as_path)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_latest_comes_first_and_only_once() {
        let mut recent = RecentFiles::default();
        for name in ["/a", "/b", "/a", "/c"] {
            recent.add(Path::new(name));
        }
        assert_eq!(recent.iter().collect::<Vec<_>>(), [Path::new("/c"), Path::new("/a"), Path::new("/b")]);
        (0..20).for_each(|i| recent.add(Path::new(&format!("/{i}"))));
        assert_eq!(recent.iter().len(), MOST);
    }
}
