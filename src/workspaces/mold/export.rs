//! All files of uncut regions or of electrodes in one folder, or none.

use std::path::Path;

use crate::workspaces::mold::job::uncut::{ClassedRun, Uncut};
use crate::workspaces::mold::report::segments::{ClassTotal, segments_as_csv};
use crate::workspaces::mold::report::uncut::{UncutPage, UncutReport, surface_as_ply};
use crate::workspaces::mold::report::{ElectrodesPage, ElectrodesReport};
use crate::workspaces::setup::SETUP_SHEET_FILE;
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
use nc::setup_sheet::{SetUp, setup_sheet};
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

/// The forms in which electrodes are written.
#[derive(Debug, Clone)]
pub struct ElectrodeForms {
    /// Formats of the electrode files.
    pub formats: Vec<ElectrodeFormat>,
    /// Template of the burn sheet.
    pub burn_sheet: BurnSheet,
    /// Settings of the set-up sheet; none where there is none.
    pub set_up: Option<SetUp>,
}

/// Writes and publishes the electrodes that may be exported in all formats, `burn_table.csv` and `.json`, the burn
/// sheet, the set-up sheet, and the report with its pictures. Electrode files of earlier exports do not stay under their
/// names. A burn sheet that cannot be made of this table takes nothing else with it: why is told in what was written.
///
/// # Errors
/// [`ElectrodeExportError`]; then nothing was written.
pub fn export_electrodes(
    folder: ExportFolder,
    (set, report): (&ElectrodeSet, &ElectrodesReport),
    forms: &ElectrodeForms,
    page: &ElectrodesPage,
    task: &Task,
) -> Result<(WrittenElectrodes, Published), ElectrodeExportError> {
    let mut folder =
        folder.setting_aside(|path| path.file_name().and_then(|n| n.to_str()).is_some_and(is_electrode_file));
    let mut written = write_electrode_files(&mut folder, (set, &report.table), &forms.formats, task)?;
    folder.write("burn_table.csv", report.table.csv().as_bytes())?;
    folder.write("burn_table.json", report.table.json()?.as_bytes())?;
    match forms.burn_sheet.of(&report.table) {
        Ok(text) => drop(folder.write("burn_sheet.txt", text.as_bytes())?),
        Err(error) => written.no_sheet = Some(error.to_string()),
    }
    let job = job_file(&folder, (set, report), &written);
    let points = job.electrodes.iter().map(|electrode| (electrode.id.as_str(), &electrode.inspection_points[..]));
    folder.write("measuring_points.csv", measuring_csv(points).as_bytes())?;
    for (name, text) in [("job.json", job.json()?), ("job.xml", job.xml()?), ("job.csv", job.csv())] {
        folder.write(name, text.as_bytes())?;
    }
    if let Some(set_up) = &forms.set_up {
        folder.write(SETUP_SHEET_FILE, setup_sheet(&job, set_up)?.as_bytes())?;
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
    use crate::workspaces::setup::{DatumRow, SetUpSheet};
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

    fn exported(
        folder: ExportFolder,
        of: (&ElectrodeSet, &ElectrodesReport),
        format: ElectrodeFormat,
        set_up: Option<SetUp>,
    ) -> Result<(WrittenElectrodes, Published), ElectrodeExportError> {
        let forms = ElectrodeForms { formats: vec![format], burn_sheet: BurnSheet::standard(), set_up };
        export_electrodes(folder, of, &forms, &ElectrodesPage::default(), &Task::default())
    }

    /// The work datum lies at (10, -4, 0.5) of the file with X along the file's Z: a quarter turn about an opening along +X,
    /// above which X of the upright mold is the file's Y, and Y its Z. The ball is (20, 11, 5.5) away from there.
    #[test]
    fn the_set_up_sheet_tells_a_ball_in_the_axes_of_the_work_datum() {
        let folder = tempfile::tempdir().unwrap();
        let (out, set) = (folder.path().join("out"), set());
        let datum = Datum { origin_mm: glam::DVec3::new(10.0, -4.0, 0.5), angle_deg: 90.0, name: "corner".to_owned() };
        let report = ElectrodesReport::of(&set, "shell", Opening::PlusX, &datum, true);
        let written = |sheet: &SetUpSheet| {
            let opened = ExportFolder::open(&out, EXPORT).unwrap();
            exported(opened, (&set, &report), ElectrodeFormat::Stl, sheet.set_up()).unwrap();
            std::fs::read_to_string(out.join(SETUP_SHEET_FILE)).ok()
        };
        let ball = DatumRow { x_mm: 30.0, y_mm: 7.0, z_mm: 6.0004, radius_mm: Some(4.0) };
        let asked =
            SetUpSheet { datum: vec![ball], round_mm: Some(0.001), a_axis_mm: Some([0.0, -10.0]), a_deg: [0.0, 90.0] };
        let sheet = written(&asked).unwrap();
        let numbers = |what: &str| -> Vec<f64> {
            let line = sheet
                .lines()
                .find_map(|line| line.trim_start().strip_prefix(what))
                .unwrap_or_else(|| panic!("{sheet}"));
            line.split_whitespace().map(|word| word.parse().unwrap()).collect()
        };
        assert!(sheet.starts_with("SET-UP SHEET  shell\nAxes: corner, Z out of the opening."), "{sheet}");
        assert_eq!(numbers("in the workpiece's file"), [30.0, 7.0, 6.0004]);
        assert_eq!(numbers("in the axes of the job"), [5.5004, -11.0, 20.0]);
        assert_eq!(numbers("its top along Z"), [5.5004, -11.0, 24.0]);
        assert_eq!(numbers("the same, rounded"), [-5.5, 11.0, -20.0]);
        assert_eq!(numbers("which moves the workpiece"), [-0.0004, 0.0, 0.0]);
        // The table turns against A: about Y 0, Z -10 from (-11, 20) to (30, 1).
        assert_eq!(numbers("ball 1 at A 90.0000"), [5.5004, 30.0, 1.0]);
        // The job beside it gives the command line the same sheet.
        let job = JobFile::read(&out.join("job.json")).unwrap();
        assert_eq!(setup_sheet(&job, &asked.set_up().unwrap()).unwrap(), sheet);
        assert!(sheet.contains("\nE1  E01: to measure on its holder"), "{sheet}");
        // Without a datum there is none, and that of the former export goes.
        assert_eq!(written(&SetUpSheet::default()), None);
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
        let (_, published) = exported(opened, (&set, &report), ElectrodeFormat::Stl, None).unwrap();
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
            exported(opened, (set, &report), ElectrodeFormat::Glb, None)
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
