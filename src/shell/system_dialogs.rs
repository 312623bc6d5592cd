//! Detection of the system's file dialogs: a dialog that fails cannot be told from one that was cancelled.

use std::ffi::OsString;
use std::fs::File;
use std::io::Read as _;
use std::path::{Path, PathBuf};

/// Facts about the system that decide which file dialogs exist.
pub struct System {
    /// Folders of programs.
    pub programs: Vec<PathBuf>,
    /// Folders of shared data.
    pub data: Vec<PathBuf>,
    /// Whether there is a session bus, over which programs talk to each other.
    pub has_bus: bool,
    /// Whether this program runs in a sandbox, which provides dialogs.
    pub is_sandboxed: bool,
}

impl System {
    /// The system that the program runs on.
    pub fn present() -> Self {
        let named = |name: &str| std::env::var_os(name).filter(|value| !value.is_empty());
        let all = |paths: Option<OsString>| paths.map_or_else(Vec::new, |p| std::env::split_paths(&p).collect());
        let home = named("XDG_DATA_HOME").map(PathBuf::from);
        let home = home.or_else(|| Some(PathBuf::from(named("HOME")?).join(".local/share")));
        let usual = || OsString::from("/usr/local/share:/usr/share");
        let shared = all(named("XDG_DATA_DIRS").or_else(|| Some(usual())));
        let runtime = named("XDG_RUNTIME_DIR").map(|folder| Path::new(&folder).join("bus"));
        Self {
            programs: all(named("PATH")),
            data: home.into_iter().chain(shared).collect(),
            has_bus: named("DBUS_SESSION_BUS_ADDRESS").is_some() || runtime.is_some_and(|bus| bus.exists()),
            is_sandboxed: Path::new("/.flatpak-info").exists() || named("SNAP").is_some(),
        }
    }

    /// Whether there are file dialogs: on every system but free desktops, and there with zenity, or with a portal on
    /// the session bus that has a file chooser behind it. A portal without a file chooser answers as if the user had
    /// chosen nothing.
    pub fn has_dialogs(&self) -> bool {
        const PORTAL: &str = "dbus-1/services/org.freedesktop.portal.Desktop.service";
        const BACKENDS: &str = "xdg-desktop-portal/portals";
        if cfg!(not(all(unix, not(target_os = "macos")))) || self.is_sandboxed {
            return true;
        }
        let has_portal = self.has_bus && self.data.iter().any(|folder| folder.join(PORTAL).is_file());
        let has_portal = has_portal && self.data.iter().any(|folder| has_chooser(&folder.join(BACKENDS)));
        has_portal || self.programs.iter().any(|folder| folder.join("zenity").is_file())
    }
}

/// Whether a backend described in a folder provides a file chooser.
fn has_chooser(folder: &Path) -> bool {
    const CHOOSER: &str = "org.freedesktop.impl.portal.FileChooser";
    /// Greatest number of bytes read of a backend's description, which has a few lines.
    const MOST: u64 = 65_536;
    let chooses = |file: PathBuf| {
        let mut text = String::new();
        let read = File::open(file).and_then(|file| file.take(MOST).read_to_string(&mut text));
        read.is_ok() && text.contains(CHOOSER)
    };
    // A folder that cannot be read has none.
    let files = std::fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path());
    files.filter(|file| file.extension().is_some_and(|ending| ending == "portal") && file.is_file()).any(chooses)
}

#[cfg(test)]
#[cfg(all(unix, not(target_os = "macos")))]
mod tests {
    use super::*;

    #[test]
    fn dialogs_are_of_a_portal_or_of_zenity() {
        let folder = tempfile::tempdir().unwrap();
        let (programs, data) = (folder.path().join("bin"), folder.path().join("share"));
        let services = data.join("dbus-1/services");
        [&programs, &services].into_iter().for_each(|path| std::fs::create_dir_all(path).unwrap());
        let system = |has_bus| System {
            programs: vec![programs.clone()],
            data: vec![data.clone()],
            has_bus,
            is_sandboxed: false,
        };
        assert!(!system(true).has_dialogs());
        assert!(System { is_sandboxed: true, ..system(false) }.has_dialogs());
        std::fs::write(services.join("org.freedesktop.portal.Desktop.service"), "").unwrap();
        assert!(!system(true).has_dialogs(), "nothing behind the portal");
        let backends = data.join("xdg-desktop-portal/portals");
        std::fs::create_dir_all(&backends).unwrap();
        let backend = |name: &str, what: &str| {
            let text = format!("[portal]\nDBusName=a.b\nInterfaces=org.freedesktop.impl.portal.{what};\n");
            std::fs::write(backends.join(name), text).unwrap();
        };
        backend("a.portal", "Screenshot");
        backend("b.portal.old", "FileChooser");
        assert!(!system(true).has_dialogs(), "none of them chooses files");
        backend("c.portal", "FileChooser");
        assert!(system(true).has_dialogs() && !system(false).has_dialogs(), "a portal needs a bus");
        std::fs::write(programs.join("zenity"), "").unwrap();
        assert!(system(false).has_dialogs());
    }
}
