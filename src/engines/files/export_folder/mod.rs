//! A folder into which an export writes all of its files or none, even if the program is killed meanwhile. A manifest names the
//! files of the exports.

mod journal;

use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use crate::document::sha256;
use crate::{FileError, Invalid, TomlFile, Validate, sha256_of};
use journal::{BEFORE, JOURNAL, Journal, LOCK, Move, NEW, PREFIX, SUFFIX, digest, free_name, take_back_killed};

/// Name of the manifest, which lists the files that exports wrote into the folder, with the SHA-256 of each.
pub const MANIFEST: &str = "export_manifest.toml";
/// Ending added to the name of a file that must not be taken for one of the present export.
const OLD: &str = "old";
const MANIFEST_FILE: TomlFile<Manifest> = TomlFile::new("manifest of an export").at_most(16 << 20);

#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Manifest {
    #[serde(default)]
    file: Vec<OwnFile>,
}

/// A file that an export wrote.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct OwnFile {
    name: String,
    /// Kind of the export.
    by: String,
    sha256: String,
}

impl Validate for Manifest {
    /// Checked name of a file in the folder, without a path.
    fn validate(&self) -> Result<(), Invalid> {
        match self.file.iter().position(|file| !is_plain(&file.name)) {
            Some(i) => Err(Invalid::new(
                format!("file[{i}].name"),
                format!("{:?}", self.file[i].name),
                "must be the name of a file in this folder",
            )),
            None => Ok(()),
        }
    }
}

/// Whether `name` is the name of a file in a folder, on every system.
fn is_plain(name: &str) -> bool {
    let has_path = name.chars().any(|c| matches!(c, '/' | '\\' | ':') || c.is_control());
    !(name.is_empty() || name == "." || name == ".." || has_path)
}

/// The manifest of a folder; an empty one if it has none.
fn manifest_in(folder: &Path) -> Result<Manifest, FileError> {
    let file = folder.join(MANIFEST);
    match MANIFEST_FILE.read_if_there(&file) {
        // A file in the way of the folder is told when the folder is made.
        Err(FileError::Unreadable { source, .. }) if source.kind() == io::ErrorKind::NotADirectory => {
            Ok(Manifest::default())
        }
        Err(problem) => {
            let problem = format!(
                "the manifest of the former export is damaged ({problem}); remove it and the files of that export, or \
                 choose another folder"
            );
            Err(FileError::NotWritten { file: folder.to_owned(), problem })
        }
        Ok(found) => Ok(found.unwrap_or_default()),
    }
}

/// A folder into which files are written hidden, and moved all together at the end.
///
/// New files wait in a hidden folder within the export folder; beside the export folder there may be another file
/// system, or no permission to write. Until the files are [published](Self::publish) the export folder stays as it was.
/// If the value is dropped before, nothing remains of the files and of the folders made for them.
#[derive(Debug)]
pub struct ExportFolder {
    folder: PathBuf,
    /// Kind of the export, as in `flank`. Exports of a kind replace each other and leave other kinds alone.
    by: &'static str,
    /// Other exports whose files are removed as well, because they are about the former export.
    replaced: &'static [&'static str],
    /// Locked as long as this program works on the export.
    _lock: File,
    // Before the folders: fields are dropped in order, and these go only when they are empty.
    waiting: tempfile::TempDir,
    /// Files to be published, in order, and their hashes.
    new: Vec<OwnFile>,
    /// Files that no manifest knows and that are to be set aside.
    unknown: Vec<String>,
    _made: MadeFolders,
}

/// Result of publishing.
#[derive(Debug, Default)]
pub struct Published {
    /// The files that were written, in order.
    pub files: Vec<PathBuf>,
    /// Files of the former export that the present one does not have, and that were removed.
    pub removed: Vec<String>,
    /// Files of the former export that someone changed since, or that no manifest knows: the former name, and the one
    /// that they have now.
    pub set_aside: Vec<[String; 2]>,
}

impl Published {
    /// What happened to files of former exports, a sentence each.
    pub fn notes(&self) -> Vec<String> {
        let removed = self.removed.iter().map(|name| format!("{name} of an earlier export was removed"));
        let renamed = self.set_aside.iter();
        removed.chain(renamed.map(|[was, is]| format!("{was} of an earlier export is now called {is}"))).collect()
    }
}

/// Folders that were made, the innermost first. They are removed again unless they hold files.
#[derive(Debug, Default)]
struct MadeFolders(Vec<PathBuf>);

impl Drop for MadeFolders {
    fn drop(&mut self) {
        // One that holds something cannot be removed, and is to stay.
        self.0.iter().for_each(|folder| drop(fs::remove_dir(folder)));
    }
}

impl ExportFolder {
    /// Checks that files can be written into `folder`, without making it. Called before work whose results go there.
    ///
    /// # Errors
    /// [`FileError`] naming the folder.
    pub fn check(folder: &Path) -> Result<(), FileError> {
        let is_there = |path: &&Path| !path.as_os_str().is_empty() && path.exists();
        let there = folder.ancestors().find(is_there).unwrap_or(Path::new("."));
        tempfile::tempfile_in(there).map_err(|source| FileError::unwritable(folder, source))?;
        manifest_in(folder).map(drop)
    }

    /// Writes these files, and no others, as one export of the kind `by`.
    ///
    /// # Errors
    /// [`FileError`]; everything is then as it was before.
    pub fn write_all(folder: &Path, by: &'static str, files: &[(&str, &[u8])]) -> Result<Published, FileError> {
        let mut out = Self::open(folder, by)?;
        for (name, bytes) in files {
            out.write(name, bytes)?;
        }
        out.publish()
    }

    /// Opens the folder for an export of the kind `by`, and makes it if it is missing.
    ///
    /// # Errors
    /// [`FileError`] if it cannot be made, nothing can be written into it, or its manifest cannot be read: without it
    /// an older program could stay beside a report that refuses it.
    pub fn open(folder: &Path, by: &'static str) -> Result<Self, FileError> {
        let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
        take_back_killed(folder);
        manifest_in(folder)?;
        let wrong = |source| FileError::unwritable(folder, source);
        let missing = folder.ancestors().take_while(|f| !f.as_os_str().is_empty() && !f.exists());
        let made = MadeFolders(missing.map(Path::to_owned).collect());
        fs::create_dir_all(folder).map_err(wrong)?;
        let waiting = tempfile::Builder::new().prefix(PREFIX).suffix(SUFFIX).tempdir_in(folder);
        // The system's reason alone: nobody asked for the hidden folder.
        let waiting = waiting.map_err(|e| wrong(e.kind().into()))?;
        for inside in [NEW, BEFORE] {
            fs::create_dir(waiting.path().join(inside)).map_err(wrong)?;
        }
        // Locked before others can see it. Where there are no locks nothing is taken back either.
        let unseen = waiting.path().join("unlocked");
        let lock = File::create(&unseen).map_err(wrong)?;
        let _ = lock.try_lock();
        fs::rename(&unseen, waiting.path().join(LOCK)).map_err(wrong)?;
        let folder = folder.to_owned();
        Ok(Self { folder, by, replaced: &[], _lock: lock, waiting, new: Vec::new(), unknown: Vec::new(), _made: made })
    }

    /// Also removes the files of exports of these kinds, which describe the former export.
    #[must_use]
    pub fn replacing(self, others: &'static [&'static str]) -> Self {
        Self { replaced: others, ..self }
    }

    /// Sets aside the files that are `own` and that no manifest lists, for example after the manifest was deleted.
    #[must_use]
    pub fn setting_aside(self, own: impl Fn(&Path) -> bool) -> Self {
        let unknown = self.names().into_iter().filter(|name| own(&self.path(name))).collect();
        Self { unknown, ..self }
    }

    /// The path of a file once it is published.
    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.join(name)
    }

    /// The names of the files that are there before anything is published, in order; none where they cannot be read.
    pub fn names(&self) -> Vec<String> {
        let entries = fs::read_dir(&self.folder).into_iter().flatten().flatten();
        let files = entries.filter(|entry| entry.path().is_file());
        let mut names: Vec<String> = files.filter_map(|entry| entry.file_name().into_string().ok()).collect();
        names.sort_unstable();
        names
    }

    /// Writes a file, which replaces one of the same name when all are published.
    ///
    /// # Errors
    /// [`FileError`] with the final path of the file.
    pub fn write(&mut self, name: &str, bytes: &[u8]) -> Result<PathBuf, FileError> {
        let path = self.path(name);
        let written = || -> io::Result<()> {
            if !is_plain(name) || name == MANIFEST {
                return Err(io::Error::new(io::ErrorKind::InvalidInput, "this is no name for a file of an export"));
            }
            // Not even by capitals, which do not count on every system.
            if self.new.iter().any(|file| file.name.eq_ignore_ascii_case(name)) {
                return Err(io::Error::new(io::ErrorKind::AlreadyExists, "two files of one export have this name"));
            }
            // What cannot be replaced should be known before anything is.
            if path.is_dir() {
                return Err(io::ErrorKind::IsADirectory.into());
            }
            let mut file = File::create(self.waiting.path().join(NEW).join(name))?;
            file.write_all(bytes)?;
            file.sync_all()
        };
        written().map_err(|source| FileError::unwritable(&path, source))?;
        self.new.push(OwnFile { name: name.to_owned(), by: self.by.to_owned(), sha256: sha256(bytes) });
        Ok(path)
    }

    /// SHA-256 of a file of this export.
    pub fn sha256_of(&self, name: &str) -> Option<&str> {
        self.new.iter().find(|file| file.name == name).map(|file| file.sha256.as_str())
    }

    /// Moves all files to their final places. Files of the former export of this kind that the new one lacks are
    /// removed first, so that no program stays beside a report that refuses it. Those that someone has changed since
    /// are renamed to `NAME.old`. Other files of the folder stay.
    ///
    /// # Errors
    /// [`FileError`]; everything is then as it was before.
    pub fn publish(self) -> Result<Published, FileError> {
        // A program that was killed since this folder was opened.
        take_back_killed(&self.folder);
        let (moves, published, manifest) = self.planned()?;
        let journal = Journal { manifest: manifest.as_ref().map(digest), moves };
        let at = self.waiting.path().join(JOURNAL);
        let wrong = |source| FileError::unwritable(&self.folder, source);
        journal.write(&at).map_err(wrong)?;
        let done = journal.moves.iter().try_for_each(|Move { from, to, .. }| {
            let [from, to] = [from, to].map(|path| self.folder.join(path));
            fs::rename(&from, &to).map_err(|source| FileError::unwritable(&to, source))
        });
        let done = done.and_then(|()| match &manifest {
            Some(manifest) => MANIFEST_FILE.write(&self.path(MANIFEST), manifest),
            None => Ok(()),
        });
        if done.is_err() {
            journal.take_back(&self.folder, self.waiting.path());
        }
        // From here on there is nothing to take back.
        fs::remove_file(&at).map_err(wrong)?;
        done.map(|()| published)
    }

    /// Moves that publish the files, relative to the folder, what is told of them, and the new manifest unless it is the one there.
    fn planned(&self) -> Result<(Vec<Move>, Published, Option<Manifest>), FileError> {
        let (mut moves, mut published) = (Vec::new(), Published::default());
        let former = manifest_in(&self.folder)?;
        let waiting = PathBuf::from(self.waiting.path().file_name().unwrap_or_default());
        let is_new = |name: &str| self.new.iter().any(|file| file.name == name);
        let is_replaced = |by: &str| by == self.by || self.replaced.contains(&by);
        let known = former.file.iter().filter(|file| is_replaced(&file.by));
        let is_known = |name: &&String| former.file.iter().any(|file| file.name == **name);
        let unknown = self.unknown.iter().filter(|name| !is_known(name)).map(|name| (name, None));
        for (name, sha256) in known.map(|file| (&file.name, Some(&file.sha256))).chain(unknown) {
            let path = self.path(name);
            // What is no plain file any more is none that an export wrote.
            if is_new(name) || !path.symlink_metadata().is_ok_and(|m| m.is_file()) {
                continue;
            }
            if sha256.is_some_and(|written| sha256_of(&path).is_ok_and(|now| now == *written)) {
                moves.push(Move::of(name, waiting.join(BEFORE).join(name)));
                published.removed.push(name.clone());
            } else {
                let Some(free) = free_name(&self.folder, name) else { continue };
                moves.push(Move::of(name, &free));
                published.set_aside.push([name.clone(), free]);
            }
        }
        for OwnFile { name, sha256, .. } in &self.new {
            if self.path(name).symlink_metadata().is_ok() {
                moves.push(Move::of(name, waiting.join(BEFORE).join(name)));
            }
            let sha256 = Some(sha256.clone());
            moves.push(Move { sha256, ..Move::of(waiting.join(NEW).join(name), name) });
            published.files.push(self.path(name));
        }
        let of_others = former.file.iter().filter(|file| !is_replaced(&file.by) && !is_new(&file.name));
        let manifest = Manifest { file: of_others.chain(&self.new).cloned().collect() };
        Ok((moves, published, (manifest != former).then_some(manifest)))
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let mut names: Vec<String> =
            fs::read_dir(folder).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    fn export(folder: &Path, by: &'static str, files: &[(&str, &str)]) -> Published {
        let files: Vec<(&str, &[u8])> = files.iter().map(|(name, text)| (*name, text.as_bytes())).collect();
        ExportFolder::write_all(folder, by, &files).unwrap()
    }

    fn read(folder: &Path, name: &str) -> String {
        fs::read_to_string(folder.join(name)).unwrap()
    }

    #[test]
    fn a_blocked_export_takes_its_former_program_away_and_nothing_of_others() {
        let folder = tempfile::tempdir().unwrap();
        let out = folder.path().join("a/b");
        let first = export(&out, "flank", &[("flank.ngc", "G1"), ("report.html", "good"), ("flank.cl", "GOTO")]);
        assert_eq!(first.files, [out.join("flank.ngc"), out.join("report.html"), out.join("flank.cl")]);
        export(&out, "mold", &[("E01.stl", "solid")]);
        fs::write(out.join("mine.ngc"), "mine").unwrap();
        fs::write(out.join("flank.cl"), "changed by hand").unwrap();
        let blocked = export(&out, "flank", &[("report.html", "blocked")]);
        assert_eq!(blocked.removed, ["flank.ngc"]);
        assert_eq!(blocked.set_aside, [["flank.cl", "flank.cl.old"].map(str::to_owned)]);
        assert_eq!(blocked.notes()[0], "flank.ngc of an earlier export was removed");
        assert_eq!(names(&out), ["E01.stl", MANIFEST, "flank.cl.old", "mine.ngc", "report.html"]);
        assert_eq!(
            (read(&out, "report.html"), read(&out, "flank.cl.old")),
            ("blocked".into(), "changed by hand".into())
        );
        // What was set aside is the user's: the next export knows nothing of it.
        let again = export(&out, "flank", &[("flank.cl", "GOTO 2"), ("report.html", "good")]);
        assert!(again.removed.is_empty() && again.set_aside.is_empty());
        fs::write(out.join("flank.cl"), "by hand again").unwrap();
        assert_eq!(export(&out, "flank", &[]).set_aside, [["flank.cl", "flank.cl.old-2"].map(str::to_owned)]);
        assert_eq!(names(&out), ["E01.stl", MANIFEST, "flank.cl.old", "flank.cl.old-2", "mine.ngc"]);
    }

    #[test]
    fn an_export_that_is_dropped_or_fails_leaves_everything_as_it_was() {
        let folder = tempfile::tempdir().unwrap();
        let out = folder.path().join("a/b");
        let mut dropped = ExportFolder::open(&out, "flank").unwrap();
        dropped.write("report.html", b"new").unwrap();
        drop(dropped);
        assert!(!folder.path().join("a").exists(), "folders made for nothing go again");
        export(&out, "flank", &[("flank.ngc", "G1"), ("report.html", "old")]);
        let before = names(&out);
        let mut failing = ExportFolder::open(&out, "flank").unwrap();
        failing.write("report.html", b"new").unwrap();
        failing.write("table.csv", b"new").unwrap();
        // The last move fails: what was to be moved is gone.
        let waiting = failing.waiting.path().join(NEW).join("table.csv");
        fs::remove_file(waiting).unwrap();
        let error = failing.publish().unwrap_err().to_string();
        assert!(error.contains("table.csv") && !error.contains(".part"), "{error}");
        assert_eq!(names(&out), before);
        assert_eq!((read(&out, "report.html"), read(&out, "flank.ngc")), ("old".into(), "G1".into()));
        fs::create_dir(out.join("table.csv")).unwrap();
        let error = ExportFolder::open(&out, "flank").unwrap().write("table.csv", b"").unwrap_err().to_string();
        assert!(error.contains("table.csv") && error.contains("directory"), "{error}");
    }

    /// Leftovers of a program that is killed after `moves` of the moves of its export, or after writing its manifest.
    fn killed(next: ExportFolder, moves: Option<usize>) {
        let (planned, _, manifest) = next.planned().unwrap();
        let journal = Journal { manifest: manifest.as_ref().map(digest), moves: planned };
        journal.write(&next.waiting.path().join(JOURNAL)).unwrap();
        for Move { from, to, .. } in &journal.moves[..moves.unwrap_or(journal.moves.len())] {
            fs::rename(next.folder.join(from), next.folder.join(to)).unwrap();
        }
        if let (None, Some(manifest)) = (moves, manifest) {
            MANIFEST_FILE.write(&next.path(MANIFEST), &manifest).unwrap();
        }
        // As long as its program lives nobody touches it.
        take_back_killed(&next.folder);
        assert!(names(&next.folder).iter().any(|name| name.ends_with(SUFFIX)));
        let ExportFolder { _lock: lock, waiting, .. } = next;
        let _ = waiting.keep();
        drop(lock);
    }

    fn opened(out: &Path, files: &[(&str, &str)]) -> ExportFolder {
        let mut next = ExportFolder::open(out, "flank").unwrap();
        files.iter().for_each(|(name, text)| drop(next.write(name, text.as_bytes()).unwrap()));
        next
    }

    #[test]
    fn a_killed_export_is_taken_back_by_the_next() {
        let folder = tempfile::tempdir().unwrap();
        let out = folder.path().join("out");
        let old = [("flank.ngc", "G1"), ("report.html", "old")];
        let set_up = || {
            let _ = fs::remove_dir_all(&out);
            export(&out, "flank", &old);
        };
        let is_as_before = |what: &str| {
            assert_eq!(names(&out), [MANIFEST, "flank.ngc", "report.html"], "{what}");
            assert_eq!((read(&out, "report.html"), read(&out, "flank.ngc")), ("old".into(), "G1".into()), "{what}");
        };
        // One file goes, one is replaced, one comes; and the same export again, whose manifest stays as it is.
        for new in [&[("report.html", "new"), ("table.csv", "new")][..], &old] {
            for moves in 0..=4 {
                set_up();
                killed(opened(&out, new), Some(moves));
                drop(opened(&out, &[]));
                is_as_before(&format!("{new:?} after {moves} moves"));
            }
        }
        set_up();
        killed(opened(&out, &[("report.html", "new"), ("table.csv", "new")]), None);
        drop(opened(&out, &[]));
        assert_eq!(names(&out), [MANIFEST, "report.html", "table.csv"]);
        assert_eq!(read(&out, "report.html"), "new");
        // Another program that was at work all the while publishes over what it takes back first.
        set_up();
        let patient = opened(&out, &[("report.html", "patient")]);
        killed(opened(&out, &[("table.csv", "new")]), Some(2));
        patient.publish().unwrap();
        assert_eq!(names(&out), [MANIFEST, "report.html"]);
    }

    #[cfg(unix)]
    #[test]
    fn hidden_folders_that_were_half_made_or_half_removed_go_in_time() {
        let out = tempfile::tempdir().unwrap();
        let hidden = out.path().join(format!("{PREFIX}x{SUFFIX}"));
        fs::create_dir_all(hidden.join(NEW)).unwrap();
        take_back_killed(out.path());
        assert!(hidden.exists(), "another program may be making it");
        let minutes_ago = std::time::SystemTime::now() - std::time::Duration::from_secs(300);
        File::open(&hidden).unwrap().set_modified(minutes_ago).unwrap();
        take_back_killed(out.path());
        assert!(!hidden.exists());
    }

    #[test]
    fn what_somebody_changed_after_a_program_was_killed_stays() {
        let folder = tempfile::tempdir().unwrap();
        let out = folder.path().join("out");
        export(&out, "flank", &[("report.html", "old")]);
        killed(opened(&out, &[("report.html", "new")]), Some(2));
        fs::write(out.join("report.html"), "by hand").unwrap();
        drop(opened(&out, &[]));
        assert_eq!((read(&out, "report.html"), read(&out, "report.html.old")), ("by hand".into(), "old".into()));
    }

    #[test]
    fn a_hostile_journal_moves_nothing_outside_the_folder() {
        let folder = tempfile::tempdir().unwrap();
        let out = folder.path().join("out");
        let hidden = out.join(".sparkpath-x.part");
        fs::create_dir_all(&hidden).unwrap();
        fs::write(folder.path().join("victim.txt"), "precious").unwrap();
        fs::write(hidden.join(LOCK), "").unwrap();
        let moves = vec![Move::of("stolen.txt", "../victim.txt")];
        [NEW, BEFORE].iter().for_each(|inside| fs::create_dir(hidden.join(inside)).unwrap());
        let journal = Journal { manifest: Some("x".to_owned()), moves };
        fs::write(hidden.join(JOURNAL), serde_json::to_vec(&journal).unwrap()).unwrap();
        take_back_killed(&out);
        assert!(names(&out).is_empty() && folder.path().join("victim.txt").exists());
    }

    #[test]
    fn a_hostile_manifest_reaches_nothing_outside_the_folder() {
        let folder = tempfile::tempdir().unwrap();
        let out = folder.path().join("out");
        fs::create_dir(&out).unwrap();
        let victim = folder.path().join("victim.txt");
        fs::write(&victim, "precious").unwrap();
        let hash = sha256_of(&victim).unwrap();
        for name in ["../victim.txt", &victim.display().to_string(), "..", ".", ""] {
            let text = format!("[[file]]\nname = {name:?}\nby = \"flank\"\nsha256 = \"{hash}\"\n");
            fs::write(out.join(MANIFEST), text).unwrap();
            for error in [ExportFolder::open(&out, "flank").unwrap_err(), ExportFolder::check(&out).unwrap_err()] {
                let said = error.to_string();
                assert!(said.contains("line 2: file[0].name") && said.contains("choose another folder"), "{said}");
            }
            assert!(victim.exists());
        }
        #[cfg(unix)]
        {
            std::os::unix::fs::symlink(&victim, out.join("link.ngc")).unwrap();
            let text = format!("[[file]]\nname = \"link.ngc\"\nby = \"flank\"\nsha256 = \"{hash}\"\n");
            fs::write(out.join(MANIFEST), text).unwrap();
            assert!(export(&out, "flank", &[]).removed.is_empty() && victim.exists());
        }
        fs::write(out.join(MANIFEST), b"\xff\xfe[[").unwrap();
        assert!(ExportFolder::open(&out, "flank").is_err());
        fs::remove_file(out.join(MANIFEST)).unwrap();
        for name in ["../a.csv", "/a.csv", "a\\b", "", "..", MANIFEST, "C:a"] {
            assert!(ExportFolder::open(&out, "flank").unwrap().write(name, b"").is_err(), "{name:?}");
        }
    }

    #[test]
    fn verdicts_on_a_former_export_go_with_it_and_programs_without_a_manifest_are_set_aside() {
        let folder = tempfile::tempdir().unwrap();
        let out = folder.path();
        export(out, "blisk", &[("path_1.nc", "G1")]);
        export(out, "verify", &[("verify.json", "holds")]);
        fs::write(out.join("path_2.nc"), "of nobody knows which plan").unwrap();
        fs::write(out.join("notes.txt"), "mine").unwrap();
        let mut again = ExportFolder::open(out, "blisk").unwrap().replacing(&["verify"]);
        again = again.setting_aside(|path| path.extension().is_some_and(|e| e == "nc"));
        again.write("report.html", b"blocked").unwrap();
        let published = again.publish().unwrap();
        assert_eq!(published.removed, ["path_1.nc", "verify.json"]);
        assert_eq!(published.set_aside, [["path_2.nc", "path_2.nc.old"].map(str::to_owned)]);
        assert_eq!(names(out), [MANIFEST, "notes.txt", "path_2.nc.old", "report.html"]);
    }

    #[test]
    fn nothing_to_write_writes_nothing_and_no_file_takes_the_place_of_another() {
        let folder = tempfile::tempdir().unwrap();
        let out = folder.path().join("out");
        export(&out, "simulation", &[]);
        assert!(!out.exists());
        let mut twice = ExportFolder::open(&out, "blisk").unwrap();
        twice.write("path_1.csv", b"1").unwrap();
        let said = twice.write("path_1.CSV", b"2").unwrap_err().to_string();
        assert!(said.contains("path_1.CSV") && said.contains("two files"), "{said}");
        ExportFolder::check(&folder.path().join("a/b")).unwrap();
        assert!(!folder.path().join("a").exists());
        fs::write(folder.path().join("file"), "").unwrap();
        assert!(ExportFolder::check(&folder.path().join("file/b")).is_err());
    }

    #[test]
    fn a_folder_that_cannot_be_is_answered_before_there_is_anything_to_write() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("file");
        fs::write(&file, "").unwrap();
        for wrong in [file.clone(), file.join("deeper")] {
            let error = ExportFolder::open(&wrong, "flank").unwrap_err().to_string();
            assert!(error.starts_with(&wrong.display().to_string()) && !error.contains(".part"), "{error}");
        }
    }

    proptest! {
        /// After any exports the folder holds what the last of each kind wrote, and what was there from others.
        #[test]
        fn the_folder_holds_the_last_export_of_each_kind(
            exports in prop::collection::vec((0..2_usize, prop::collection::btree_set(0..4_usize, 0..4)), 1..6)
        ) {
            let folder = tempfile::tempdir().unwrap();
            fs::write(folder.path().join("mine.txt"), "mine").unwrap();
            let mut last = [Vec::new(), Vec::new()];
            let is_any = exports.iter().any(|(_, files)| !files.is_empty());
            for (kind, files) in exports {
                let names: Vec<String> = files.iter().map(|n| format!("{kind}-{n}.txt")).collect();
                let files: Vec<(&str, &str)> = names.iter().map(|name| (name.as_str(), "x")).collect();
                export(folder.path(), ["a", "b"][kind], &files);
                last[kind] = names;
            }
            let mut wanted = [last.concat(), vec!["mine.txt".to_owned()]].concat();
            wanted.extend(is_any.then(|| MANIFEST.to_owned()));
            wanted.sort();
            prop_assert_eq!(names(folder.path()), wanted);
        }
    }
}
