//! Meshes and tables of points that change on the disk, or go away, while the program has what it read of them.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use super::SparkpathApp;
use crate::workspaces::news::EventKind;
use files::paths::has_ending;
use files::patience::Awaited;
use import::MESH_ENDINGS;

/// Least time between two looks (s). A window at which nothing happens does not look.
const EVERY: f64 = 2.0;

/// Size (bytes) and time of writing of a file; none if it is not there.
type Stamp = Option<(u64, Option<SystemTime>)>;

/// The files of the documents as they were seen last.
#[derive(Default)]
pub struct Watch {
    seen: BTreeMap<PathBuf, Stamp>,
    /// The look that is under way: none follows while a drive does not answer.
    looking: Option<Awaited<BTreeMap<PathBuf, Stamp>>>,
    last: f64,
}

fn stamp(file: &Path) -> Stamp {
    std::fs::metadata(file).ok().map(|of| (of.len(), of.modified().ok()))
}

fn is_part(file: &Path) -> bool {
    MESH_ENDINGS.iter().chain(&["csv"]).any(|ending| has_ending(file, &format!(".{ending}")))
}

impl SparkpathApp {
    /// Says once of each file that it has changed or is gone since it was seen first.
    pub(super) fn watch_files(&mut self) {
        if let Some(now) = self.watch.looking.as_ref().and_then(Awaited::take) {
            self.watch.looking = None;
            for (file, stamp) in &now {
                let name = file.file_name().unwrap_or(file.as_os_str()).to_string_lossy();
                match self.watch.seen.get(file) {
                    Some(Some(_)) if stamp.is_none() => {
                        self.say(EventKind::Refused, format!("{name} is no longer there: what was read of it stays"));
                    }
                    Some(before) if before != stamp => {
                        let text = format!("{name} has changed on the disk: Reload meshes (Ctrl+R) reads it again");
                        self.say(EventKind::Refused, text);
                    }
                    _ => {}
                }
            }
            // Files that no document names any more are forgotten.
            self.watch.seen = now;
        }
        if self.watch.looking.is_some() || self.cx.now - self.watch.last < EVERY {
            return;
        }
        self.watch.last = self.cx.now;
        let mut named: Vec<PathBuf> = self.workspaces.iter().flat_map(|one| one.document().files()).collect();
        named.retain(|file| is_part(file));
        if named.is_empty() && self.watch.seen.is_empty() {
            return;
        }
        let ctx = self.ctx.clone();
        let look = move || named.into_iter().map(|file| (file.clone(), stamp(&file))).collect();
        self.watch.looking = Awaited::start(look, move || ctx.request_repaint()).ok();
    }
}
