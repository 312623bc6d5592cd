//! Preferences of the user, independent of documents, in a file of their own.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

pub use crate::widgets::viewport::Navigation;
use files::atomic::atomic_write;

/// Preferences and the files opened last.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Preferences {
    /// Dark, light, or as the system is.
    pub theme: ThemeChoice,
    /// Size of everything in the window; 1 is as the system has it.
    pub scale: f32,
    /// Unit that lengths are shown in. Files and forms stay in mm.
    pub length: LengthUnit,
    /// Mouse buttons of the 3-D view.
    pub navigation: Navigation,
    /// Whether a quick look follows while an electrode is tuned, and a plan when it rests, with the global strategy.
    pub live: bool,
    /// Whether paths of files are typed even where the system has dialogs for them.
    pub types_paths: bool,
    /// Threads to compute on; 0 for one a core. Takes effect at the next start.
    pub threads: usize,
    /// Files opened last.
    pub recent: RecentFiles,
}

impl Default for Preferences {
    fn default() -> Self {
        Self {
            theme: ThemeChoice::Dark,
            scale: 1.0,
            length: LengthUnit::Millimetre,
            navigation: Navigation::Cad,
            live: true,
            types_paths: false,
            threads: 0,
            recent: RecentFiles::default(),
        }
    }
}

/// Colours of the window.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ThemeChoice {
    /// Light on dark.
    Dark,
    /// Dark on light.
    Light,
    /// The theme of the system.
    System,
}

/// Unit that lengths are shown in.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum LengthUnit {
    /// mm
    Millimetre,
    /// inch
    Inch,
}

impl LengthUnit {
    /// A length with its unit; `decimals` are those in mm.
    pub fn show(self, mm: f64, decimals: usize) -> String {
        match self {
            Self::Millimetre => format!("{mm:.decimals$} mm"),
            Self::Inch => format!("{:.*} in", decimals + 1, mm / 25.4),
        }
    }
}

impl Preferences {
    /// The scales that can be chosen.
    pub const SCALES: [f32; 6] = [0.8, 1.0, 1.25, 1.5, 1.75, 2.0];

    /// Reads them from `folder`; what cannot be read is as by default.
    pub fn read(folder: &Path) -> Self {
        let text = std::fs::read_to_string(file(folder)).unwrap_or_default();
        let mut read: Self = serde_json::from_str(&text).unwrap_or_default();
        if !(0.5..=3.0).contains(&read.scale) {
            read.scale = 1.0;
        }
        read
    }

    /// Writes them into `folder`.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn write(&self, folder: &Path) -> std::io::Result<()> {
        std::fs::create_dir_all(folder)?;
        let text = serde_json::to_vec_pretty(self)?;
        atomic_write(&file(folder), |out| out.write_all(&text))
    }

    /// What egui calls the theme.
    pub fn egui_theme(&self) -> egui::ThemePreference {
        match self.theme {
            ThemeChoice::Dark => egui::ThemePreference::Dark,
            ThemeChoice::Light => egui::ThemePreference::Light,
            ThemeChoice::System => egui::ThemePreference::System,
        }
    }
}

fn file(folder: &Path) -> PathBuf {
    folder.join("preferences.json")
}

/// Greatest number of files remembered.
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
    fn preferences_survive_and_damage_to_them_does_no_harm() {
        let folder = tempfile::tempdir().unwrap();
        assert_eq!(Preferences::read(folder.path()), Preferences::default());
        let mut own = Preferences { scale: 1.5, theme: ThemeChoice::Light, ..Default::default() };
        own.recent.add(Path::new("/a/b.stl"));
        own.write(folder.path()).unwrap();
        assert_eq!(Preferences::read(folder.path()), own);
        std::fs::write(file(folder.path()), "{\"scale\": 900}").unwrap();
        assert_eq!(Preferences::read(folder.path()).scale, 1.0);
        std::fs::write(file(folder.path()), "nothing").unwrap();
        assert_eq!(Preferences::read(folder.path()), Preferences::default());
    }

    #[test]
    fn an_inch_is_25_4_mm() {
        assert_eq!(LengthUnit::Inch.show(25.4, 2), "1.000 in");
        assert_eq!(LengthUnit::Millimetre.show(0.09876, 4), "0.0988 mm");
    }

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
