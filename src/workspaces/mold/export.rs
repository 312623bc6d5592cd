//! All files of uncut regions or of electrodes in one folder, or none.

use std::path::Path;

use crate::workspaces::mold::job::uncut::{ClassedRun, Uncut};
use crate::workspaces::mold::report::segments::{ClassTotal, segments_as_csv};
use crate::workspaces::mold::report::uncut::{UncutPage, UncutReport, surface_as_ply};
use crate::workspaces::mold::report::{ElectrodesPage, ElectrodesReport};
use files::report::PageError;
use files::{ExportFolder, FileError, Published};
use import::ImportReport;
use mold::electrode::design::ElectrodeSet;
use nc::electrode_files::{
    ElectrodeExportError, ElectrodeFormat, WrittenElectrodes, is_electrode_file, points_to_measure,
    write_electrode_files,
};
use nc::job_file::{FileEntry, JobFile, JobTechnology};
use nc::measuring_points::measuring_csv;
use nc::template::BurnSheet;
use task::Task;

/// What the manifest of a folder calls an export of electrodes.
pub const EXPORT: &str = "electrodes";

/// Kind of an export of uncut regions in the manifest of a folder.
pub const UNCUT_EXPORT: &str = "uncut";

/// Uncut regions with all that their files say.
pub struct UncutFiles<'a> {
    /// The regions.
    pub uncut: &'a Uncut,
    /// Uncut segments of all layers.
    pub runs: &'a [ClassedRun],
    /// Report on them.
    pub report: &'a UncutReport,
    /// Digest of the mold's file (SHA-256).
    pub sha256: &'a str,
    /// Report of the mold's import.
    pub import: &'a ImportReport,
    /// What the page shows beside the report.
    pub page: UncutPage<'a>,
}

/// Reason why files of uncut regions were not written.
#[derive(Debug, thiserror::Error)]
pub enum UncutExportError {
    /// The figures could not be made.
    #[error("uncut.json: {0}")]
    Json(#[from] serde_json::Error),
    /// The page could not be made.
    #[error(transparent)]
    Page(#[from] PageError),
    /// A file could not be written.
    #[error(transparent)]
    File(#[from] FileError),
}

impl UncutFiles<'_> {
    /// Content of `uncut.json`.
    ///
    /// # Errors
    /// The writer's own; none is known.
    pub fn json(&self) -> Result<String, serde_json::Error> {
        let mut all = serde_json::json!({ "sha256": self.sha256, "import": self.import, "uncut": self.report });
        all["interference"] = serde_json::to_value(ClassTotal::of(self.runs))?;
        if let Some(comparison) = self.page.comparison {
            all["comparison"] = serde_json::to_value(comparison)?;
        }
        serde_json::to_string_pretty(&all)
    }

    /// Content of `uncut.txt`: the report in lines, and the comparison with other cutters if there is one.
    pub fn text(&self) -> String {
        let compared = self.page.comparison.map_or_else(String::new, |comparison| comparison.text());
        self.report.text(self.page.notes) + &compared
    }

    /// Writes all files into `folder`, which is made if missing.
    ///
    /// # Errors
    /// [`UncutExportError`]; then nothing was written.
    pub fn write(&self, folder: &Path) -> Result<Published, UncutExportError> {
        let (json, text, page) = (self.json()?, self.text(), self.report.html(&ClassTotal::of(self.runs), &self.page)?);
        let surface = surface_as_ply(&self.uncut.surface, self.uncut.params.opening);
        let segments = segments_as_csv(self.uncut, self.runs, self.page.mold);
        let files: [(&str, &[u8]); 5] = [
            ("uncut.json", json.as_bytes()),
            ("uncut.txt", text.as_bytes()),
            ("uncut.ply", &surface),
            ("uncut_segments.csv", segments.as_bytes()),
            ("uncut.html", page.as_bytes()),
        ];
        Ok(ExportFolder::write_all(folder, UNCUT_EXPORT, &files)?)
    }
}

/// Writes and publishes the electrodes that may be exported in all `formats`, `burn_table.csv` and `.json`, the burn
/// sheet, and the report with its pictures. Electrode files of earlier exports do not stay under their names. A sheet
/// that cannot be made of this table takes nothing else with it: why is told in what was written.
///
/// # Errors
/// [`ElectrodeExportError`]; then nothing was written.
pub fn export_electrodes(
    folder: ExportFolder,
    (set, report): (&ElectrodeSet, &ElectrodesReport),
    sheet: &BurnSheet,
    page: &ElectrodesPage,
    formats: &[ElectrodeFormat],
    task: &Task,
) -> Result<(WrittenElectrodes, Published), ElectrodeExportError> {
    let mut folder =
        folder.setting_aside(|path| path.file_name().and_then(|n| n.to_str()).is_some_and(is_electrode_file));
    let mut written = write_electrode_files(&mut folder, (set, &report.table), formats, task)?;
    folder.write("burn_table.csv", report.table.csv().as_bytes())?;
    folder.write("burn_table.json", report.table.json()?.as_bytes())?;
    match sheet.of(&report.table) {
        Ok(text) => drop(folder.write("burn_sheet.txt", text.as_bytes())?),
        Err(error) => written.no_sheet = Some(error.to_string()),
    }
    let job = job_file(&folder, (set, report), &written);
    let points = job.electrodes.iter().map(|electrode| (electrode.id.as_str(), &electrode.inspection_points[..]));
    folder.write("measuring_points.csv", measuring_csv(points).as_bytes())?;
    for (name, text) in [("job.json", job.json()?), ("job.xml", job.xml()?), ("job.csv", job.csv())] {
        folder.write(name, text.as_bytes())?;
    }
    folder.write("electrodes.json", report.json()?.as_bytes())?;
    folder.write("report.html", report.html(page)?.as_bytes())?;
    let published = folder.publish()?;
    Ok((written, published))
}

/// The job of the electrodes, with the files that were `written` into `folder`.
fn job_file(
    folder: &ExportFolder,
    (set, report): (&ElectrodeSet, &ElectrodesReport),
    written: &WrittenElectrodes,
) -> JobFile {
    let files_of = |electrode: &str| {
        let own = written.files.iter().filter(|file| file.electrode == electrode);
        let names = own.filter_map(|file| file.path.file_name()?.to_str());
        let entry = |name: &str| Some(FileEntry { name: name.to_owned(), sha256: folder.sha256_of(name)?.to_owned() });
        names.filter_map(entry).collect()
    };
    let technology = &set.params.technology;
    let technology_of = |stage: &str| {
        let stage = set.params.stages.iter().find(|of| of.name == stage)?;
        let last_step = Some(stage.last_step.trim()).filter(|step| !step.is_empty()).map(str::to_owned);
        Some(JobTechnology {
            table: technology.table.clone(),
            id: technology.id.clone(),
            finish_vdi: last_step.is_none().then_some(stage.finish_vdi),
            last_step,
        })
    };
    let points_of = |name: &str| {
        let electrode = set.electrodes.iter().find(|electrode| electrode.name == name);
        electrode.map(|electrode| points_to_measure(electrode, set.params.shape)).unwrap_or_default()
    };
    JobFile::of_table(&report.table, files_of, technology_of, points_of)
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::mesh::Mesh;
    use mold::datum::Datum;
    use mold::opening::Opening;
    use nc::electrode_fixtures::set;

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
        let report = ElectrodesReport::of(&set, "shell", Opening::PlusZ, &Datum::default(), true);
        std::fs::create_dir_all(&out).unwrap();
        std::fs::write(out.join("mine.txt"), "mine").unwrap();
        std::fs::write(out.join("E04_finish_g0.05_Cu-soft_x1.stl"), "of an earlier plan").unwrap();
        let opened = ExportFolder::open(&out, EXPORT).unwrap();
        std::fs::write(out.join("burn_table.csv"), "old").unwrap();
        let (_, published) = export_electrodes(
            opened,
            (&set, &report),
            &BurnSheet::standard(),
            &ElectrodesPage::default(),
            &[ElectrodeFormat::Stl],
            &Task::default(),
        )
        .unwrap();
        let renamed =
            "E04_finish_g0.05_Cu-soft_x1.stl of an earlier export is now called E04_finish_g0.05_Cu-soft_x1.stl.old";
        assert_eq!(published.notes(), [renamed]);
        let expected = [
            "E01_rough_g0.2_circular0.1_Cu-soft_x2.stl",
            "E02_finish_g0.05_Cu-soft_x1.stl",
            "E04_finish_g0.05_Cu-soft_x1.stl.old",
            "burn_sheet.txt",
            "burn_table.csv",
            "burn_table.json",
            "electrodes.json",
            "export_manifest.toml",
            "job.csv",
            "job.json",
            "job.xml",
            "measuring_points.csv",
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
        let report = ElectrodesReport::of(&broken, "shell", Opening::PlusZ, &Datum::default(), true);
        let tried = |set: &ElectrodeSet| {
            let opened = ExportFolder::open(&out, EXPORT).unwrap();
            export_electrodes(
                opened,
                (set, &report),
                &BurnSheet::standard(),
                &ElectrodesPage::default(),
                &[ElectrodeFormat::Glb],
                &Task::default(),
            )
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
}
