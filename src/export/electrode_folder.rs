//! A folder that gets all files of an export or none.

use std::fs::File;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use super::burn_template::BurnSheet;
use super::electrode_files::{ElectrodeExportError, ElectrodeFormat, WrittenElectrodes, write_electrode_files};
use super::electrode_report::ElectrodesReport;
use super::files::WriteError;
use crate::mold::electrode::design::ElectrodeSet;

/// A folder into which files are written unseen, and moved all together at the end.
///
/// They wait in a hidden folder within it: beside it there may be another file system, or no right to write. Until they are
/// [published](Self::publish) the folder is as it was; dropped before, nothing of them stays, nor do folders that were made
/// for them.
#[derive(Debug)]
pub struct ExportFolder {
    folder: PathBuf,
    // Before the folders: fields are dropped in order, and these go only when they are empty.
    waiting: tempfile::TempDir,
    names: Vec<String>,
    _made: MadeFolders,
}

/// Folders that were made, the innermost first, which go again unless something is in them.
#[derive(Debug, Default)]
struct MadeFolders(Vec<PathBuf>);

impl Drop for MadeFolders {
    fn drop(&mut self) {
        // One that holds something cannot be removed, and is to stay.
        self.0.iter().for_each(|folder| drop(std::fs::remove_dir(folder)));
    }
}

impl ExportFolder {
    /// The folder, made if it is not there.
    ///
    /// # Errors
    /// [`WriteError`] if it cannot be made or nothing can be written into it.
    pub fn open(folder: &Path) -> Result<Self, WriteError> {
        let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
        let wrong = |source| WriteError { path: folder.to_owned(), source };
        let missing = folder.ancestors().take_while(|f| !f.as_os_str().is_empty() && !f.exists());
        let made = MadeFolders(missing.map(Path::to_owned).collect());
        std::fs::create_dir_all(folder).map_err(wrong)?;
        let waiting = tempfile::Builder::new().prefix(".sparkpath-").suffix(".part").tempdir_in(folder);
        // The system's reason alone: nobody asked for the hidden folder.
        let waiting = waiting.map_err(|e| wrong(e.kind().into()))?;
        Ok(Self { folder: folder.to_owned(), waiting, names: Vec::new(), _made: made })
    }

    /// The path of a file once it is published.
    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.join(name)
    }

    /// Writes a file; one that has the name already is replaced when all are published.
    ///
    /// # Errors
    /// [`WriteError`] that names the file where it is to be.
    pub fn write(&mut self, name: &str, bytes: &[u8]) -> Result<PathBuf, WriteError> {
        let path = self.path(name);
        let written = || -> io::Result<()> {
            // What cannot be replaced should be known before anything is.
            if path.is_dir() {
                return Err(io::ErrorKind::IsADirectory.into());
            }
            let mut file = File::create(self.waiting.path().join(name))?;
            file.write_all(bytes)?;
            file.sync_all()
        };
        written().map_err(|source| WriteError { path: path.clone(), source })?;
        self.names.push(name.to_owned());
        Ok(path)
    }

    /// Moves all files to where they are to be. Other files of the folder stay.
    ///
    /// # Errors
    /// [`WriteError`]; each file is then the old one or the new one.
    pub fn publish(self) -> Result<(), WriteError> {
        for name in &self.names {
            let path = self.path(name);
            std::fs::rename(self.waiting.path().join(name), &path).map_err(|source| WriteError { path, source })?;
        }
        Ok(())
    }
}

/// Writes and publishes the electrodes that may be exported in all `formats`, `burn_table.csv` and `.json`, the burn sheet,
/// and the report with its pictures. A sheet that cannot be made of this table takes nothing else with it: why is told
/// in what was written.
///
/// # Errors
/// [`ElectrodeExportError`]; then nothing was written.
pub fn export_electrodes(
    mut folder: ExportFolder,
    (set, report): (&ElectrodeSet, &ElectrodesReport),
    sheet: &BurnSheet,
    pictures: &[(String, Vec<u8>)],
    formats: &[ElectrodeFormat],
) -> Result<WrittenElectrodes, ElectrodeExportError> {
    let mut written = write_electrode_files(&mut folder, set, formats)?;
    folder.write("burn_table.csv", report.table.csv().as_bytes())?;
    folder.write("burn_table.json", report.table.json()?.as_bytes())?;
    match sheet.of(&report.table) {
        Ok(text) => drop(folder.write("burn_sheet.txt", text.as_bytes())?),
        Err(error) => written.no_sheet = Some(error.to_string()),
    }
    folder.write("electrodes.json", report.json()?.as_bytes())?;
    folder.write("report.html", report.html(pictures).as_bytes())?;
    folder.publish()?;
    Ok(written)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::export::electrode_fixtures::set;
    use crate::geometry::mesh::Mesh;
    use crate::mold::opening::Opening;

    fn names(folder: &Path) -> Vec<String> {
        let mut names: Vec<String> =
            std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    #[test]
    fn all_files_come_together_beside_those_that_are_there() {
        let folder = tempfile::tempdir().unwrap();
        let out = folder.path().join("a/b");
        let set = set();
        let report = ElectrodesReport::of(&set, "shell", Opening::PlusZ);
        let opened = ExportFolder::open(&out).unwrap();
        std::fs::write(out.join("mine.txt"), "mine").unwrap();
        std::fs::write(out.join("burn_table.csv"), "old").unwrap();
        export_electrodes(opened, (&set, &report), &BurnSheet::standard(), &[], &[ElectrodeFormat::Stl]).unwrap();
        let expected = [
            "E01_rough_g0.2_circular0.1_Cu-soft_x2.stl",
            "E02_finish_g0.05_Cu-soft_x1.stl",
            "burn_sheet.txt",
            "burn_table.csv",
            "burn_table.json",
            "electrodes.json",
            "mine.txt",
            "report.html",
        ];
        assert_eq!(names(&out), expected);
        assert_eq!(std::fs::read_to_string(out.join("mine.txt")).unwrap(), "mine");
        assert_eq!(std::fs::read_to_string(out.join("burn_table.csv")).unwrap(), report.table.csv());
    }

    #[test]
    fn an_export_that_fails_half_way_leaves_the_folder_as_it_was() {
        let folder = tempfile::tempdir().unwrap();
        let out = folder.path().join("a/b");
        let mut broken = set();
        broken.electrodes[1].mesh = Mesh::default();
        let report = ElectrodesReport::of(&broken, "shell", Opening::PlusZ);
        let tried = |set: &ElectrodeSet| {
            let opened = ExportFolder::open(&out).unwrap();
            export_electrodes(opened, (set, &report), &BurnSheet::standard(), &[], &[ElectrodeFormat::Glb])
        };
        assert!(tried(&broken).unwrap_err().to_string().contains("E02-finish as glb"));
        assert!(!folder.path().join("a").exists(), "folders made for nothing go again");
        // A file that cannot be replaced is found before any other is.
        std::fs::create_dir_all(out.join("report.html")).unwrap();
        std::fs::write(out.join("burn_table.csv"), "old").unwrap();
        let error = tried(&set()).unwrap_err().to_string();
        assert!(error.contains("report.html") && error.contains("directory"), "{error}");
        assert_eq!(names(&out), ["burn_table.csv", "report.html"]);
        assert_eq!(std::fs::read_to_string(out.join("burn_table.csv")).unwrap(), "old");
    }

    #[test]
    fn a_folder_that_cannot_be_is_answered_before_there_is_anything_to_write() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("file");
        std::fs::write(&file, "").unwrap();
        for wrong in [file.clone(), file.join("deeper")] {
            let error = ExportFolder::open(&wrong).unwrap_err();
            assert_eq!(error.path, wrong);
            assert!(!error.to_string().contains(".part"), "{error}");
        }
    }
}
