//! Recovery of an export folder from a program that was killed while it published.

use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::time::Duration;

use serde::{Deserialize, Serialize};

use super::{Manifest, OLD, is_plain, manifest_in};
use crate::document::sha256;
use crate::{read_text, sha256_of};

/// Folders within the hidden one: files to come, and files that they replace.
pub(super) const NEW: &str = "new";
pub(super) const BEFORE: &str = "before";

/// File within the hidden folder that its program holds locked, and the file that lists the moves.
pub(super) const LOCK: &str = "lock";
pub(super) const JOURNAL: &str = "moves.json";
/// Beginning and end of the name of a hidden folder.
pub(super) const PREFIX: &str = ".sparkpath-";
pub(super) const SUFFIX: &str = ".part";

/// Largest journal that is read (bytes).
const LARGEST_JOURNAL: u64 = 16 << 20;

/// Move of a file within the export folder.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct Move {
    pub from: PathBuf,
    pub to: PathBuf,
    /// Hash of a file of the new export; none of what was there before.
    pub sha256: Option<String>,
}

impl Move {
    pub(super) fn of(from: impl Into<PathBuf>, to: impl Into<PathBuf>) -> Self {
        Self { from: from.into(), to: to.into(), sha256: None }
    }
}

/// Moves that publish an export. The file is there from before the first of them until the export is complete, or taken back.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct Journal {
    /// Digest of the manifest that is written after them; none if it stays as it is.
    pub manifest: Option<String>,
    pub moves: Vec<Move>,
}

impl Journal {
    pub(super) fn write(&self, file: &Path) -> io::Result<()> {
        let mut out = File::create(file)?;
        out.write_all(&serde_json::to_vec(self)?)?;
        out.sync_all()
    }

    /// Puts everything back, the last first, but files that somebody has changed since. What stood in their place before, and
    /// whatever else cannot be put back, is set aside.
    pub(super) fn take_back(&self, folder: &Path, waiting: &Path) {
        for Move { from, to, sha256 } in self.moves.iter().rev() {
            let [from, to] = [from, to].map(|path| folder.join(path));
            let is_ours = || sha256.as_ref().is_none_or(|written| sha256_of(&to).is_ok_and(|now| now == *written));
            if from.symlink_metadata().is_err() && is_ours() {
                let _ = fs::rename(to, from);
            }
        }
        for left in fs::read_dir(waiting.join(BEFORE)).into_iter().flatten().flatten() {
            let name = left.file_name().into_string().ok().and_then(|name| free_name(folder, &name));
            let _ = name.map(|name| fs::rename(left.path(), folder.join(name)));
        }
    }

    /// Whether every move stays in `folder`: names of its files, and of those in the hidden folder `waiting`.
    fn is_within(&self, waiting: &Path) -> bool {
        let is_hidden = |path: &Path| {
            let inside =
                path.strip_prefix(waiting).ok().and_then(|path| Some((path.parent()?, path.file_name()?.to_str()?)));
            inside.is_some_and(|(part, name)| [NEW, BEFORE].map(Path::new).contains(&part) && is_plain(name))
        };
        let mut paths = self.moves.iter().flat_map(|one| [&one.from, &one.to]);
        paths.all(|path| path.to_str().is_some_and(is_plain) || is_hidden(path))
    }
}

/// Digest of a manifest.
pub(super) fn digest(manifest: &Manifest) -> String {
    let rows = manifest.file.iter().map(|file| format!("{} {} {}\n", file.sha256, file.by, file.name));
    sha256(rows.collect::<String>().as_bytes())
}

/// Takes back what programs that were killed had published in part, and removes their hidden folders.
pub(super) fn take_back_killed(folder: &Path) {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    for hidden in entries.map(|entry| entry.path()) {
        let name = hidden.file_name().and_then(|name| name.to_str()).unwrap_or_default();
        let is_folder = |path: &Path| path.symlink_metadata().is_ok_and(|of| of.is_dir());
        if !(name.starts_with(PREFIX) && name.ends_with(SUFFIX) && is_folder(&hidden)) {
            continue;
        }
        let at = hidden.join(JOURNAL);
        let Ok(lock) = File::open(hidden.join(LOCK)) else {
            // Nothing to take back: the program was killed while it made the folder or removed it, unless it makes it just now.
            if !at.exists() && is_old(&hidden) {
                let _ = fs::remove_dir_all(&hidden);
            }
            continue;
        };
        // A program that is at work holds the lock; where none can be had, nothing is known.
        if lock.try_lock().is_err() {
            continue;
        }
        let text = read_text(&at, "list of moves", LARGEST_JOURNAL).ok();
        let journal = text.and_then(|text| serde_json::from_str::<Journal>(&text).ok());
        // A link would lead out of the folder.
        let are_folders = [NEW, BEFORE].iter().all(|inside| is_folder(&hidden.join(inside)));
        if let Some(journal) = journal.filter(|journal| are_folders && journal.is_within(Path::new(name))) {
            let now = manifest_in(folder).ok().map(|manifest| digest(&manifest));
            let is_complete = journal.manifest.is_some() && journal.manifest == now;
            if !is_complete {
                journal.take_back(folder, &hidden);
            }
        }
        // Before the lock is let go: nobody else takes anything back.
        let _ = fs::remove_file(at);
        let _ = fs::remove_dir_all(&hidden);
        drop(lock);
    }
}

/// Whether nothing has changed in a folder for longer than it takes to make one.
fn is_old(folder: &Path) -> bool {
    let changed = folder.symlink_metadata().and_then(|of| of.modified()).ok();
    changed.and_then(|at| at.elapsed().ok()).is_some_and(|since| since > Duration::from_secs(60))
}

/// `NAME.old`, or `NAME.old-2` and so on if that name is taken in `folder`.
pub(super) fn free_name(folder: &Path, name: &str) -> Option<String> {
    let numbered = (2..).map(|n: u64| format!("{name}.{OLD}-{n}"));
    let mut names = std::iter::once(format!("{name}.{OLD}")).chain(numbered);
    names.find(|name| folder.join(name).symlink_metadata().is_err())
}
