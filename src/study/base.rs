//! The project that a study varies.

use std::path::{Path, PathBuf};

use super::definition::StudyCommand;
use crate::workspaces::blisk::document::job_file::PlanJob;
use crate::workspaces::blisk::document::job_file::field_table::FIELDS as BLISK_FIELDS;
use crate::workspaces::context::is_project;
use crate::workspaces::flank::document::FlankDocument;
use crate::workspaces::mold::document::MoldParams;
use crate::workspaces::mold::document::cutter_file::CUTTERS;
use crate::workspaces::mold::document::fields::FIELDS as MOLD_FIELDS;
use crate::workspaces::mold::document::standard::{open_mold, standard_mold};
use files::{Document, Entry, Field, FieldTable, FileError, Invalid, Kind, Params, kind_of, paths};

/// Key of a file of cutters, which takes the place of a mold's own ones.
pub const LIBRARY: &str = "library";

/// Parameters of a project that is studied, with absolute paths.
#[derive(Debug, Clone, PartialEq)]
pub enum Base {
    /// Of a blisk.
    Blisk(Box<PlanJob>),
    /// Of a mold.
    Mold(Box<MoldParams>),
}

/// A parameter with a value, as the command line would give them.
pub type Setting<'a> = (&'a str, &'a str);

impl Base {
    /// The parameters in `file`, a project or the mesh of a part for `command`. A new mold is as the user's standard in
    /// `user_folder` says.
    ///
    /// # Errors
    /// [`FileError`], also of a project that is not for the command.
    pub fn read(file: &Path, command: StudyCommand, user_folder: Option<&Path>) -> Result<Self, FileError> {
        let file = &paths::absolute(file);
        let is_blisk = matches!(command, StudyCommand::Plan | StudyCommand::Size);
        if !is_project(file) {
            if paths::has_ending(file, ".toml") {
                let remedy = "a project ends with .sparkpath; rename it, and write its kind in its first line";
                return Err(FileError::invalid(file, Invalid::of("project", remedy)));
            }
            return Ok(match is_blisk {
                true => Self::Blisk(PlanJob::for_mesh(file).into()),
                false => Self::Mold(MoldParams { mesh: Some(file.clone()), ..standard_mold(user_folder)? }.into()),
            });
        }
        let kind = kind_of(file)?;
        match kind.as_str() {
            PlanJob::KIND if is_blisk => Ok(Self::Blisk(Document::<PlanJob>::open(file)?.params().clone().into())),
            MoldParams::KIND if !is_blisk => Ok(Self::Mold(open_mold(file, user_folder)?.into())),
            _ => {
                let of = match kind.as_str() {
                    PlanJob::KIND => "a study of a blisk has the command plan or size",
                    MoldParams::KIND => "a study of a mold has the command uncut or electrodes",
                    FlankDocument::KIND => "studies are of blisks and molds; there are none of flanks",
                    _ => "studies are of blisks and molds",
                };
                let problem = Invalid::new("kind", format!("\"{kind}\""), format!("{of}, not {}", command.name()));
                Err(FileError::invalid(file, problem))
            }
        }
    }

    /// The parameters in the text of a project of this kind, in which paths are as seen from `folder`. A mold without holders
    /// has the user's.
    ///
    /// # Errors
    /// [`FileError`], also of a kind of which there are no studies.
    pub fn parse(kind: &str, text: &str, folder: &Path) -> Result<Self, FileError> {
        if kind == PlanJob::KIND {
            return Ok(Self::Blisk(Document::<PlanJob>::parse(text, folder)?.params().clone().into()));
        }
        Ok(Self::Mold(Document::<MoldParams>::parse(text, folder)?.params().clone().into()))
    }

    /// Sets the seed of the genetic search, where there is one.
    #[must_use]
    pub fn with_seed(mut self, seed: Option<u64>) -> Self {
        if let (Self::Blisk(job), Some(seed)) = (&mut self, seed) {
            job.genetic.seed = seed;
        }
        self
    }

    /// Text of a project with these parameters, to lie at `file`.
    ///
    /// # Errors
    /// [`FileError`] if they are not possible.
    pub fn text(&self, file: &Path) -> Result<String, FileError> {
        match self {
            Self::Blisk(job) => Document::new((**job).clone()).text(file),
            Self::Mold(params) => Document::new((**params).clone()).text(file),
        }
    }

    /// Name of the part.
    pub fn part(&self) -> String {
        match self {
            Self::Blisk(job) => job.part(),
            Self::Mold(params) => params.name(),
        }
    }

    /// Every parameter, for a report.
    pub fn entries(&self) -> Vec<Entry> {
        match self {
            Self::Blisk(job) => BLISK_FIELDS.list(job).entries,
            Self::Mold(params) => MOLD_FIELDS.list(params).entries,
        }
    }

    /// The parameters with another value for `key`. A file is as seen from `folder`. Conditions between parameters are not
    /// looked at. The second answer is the absolute path of the file that the value names, if it names one.
    ///
    /// # Errors
    /// [`Invalid`] if there is no such parameter, or it cannot have this value.
    pub fn set(&self, (key, value): Setting, folder: &Path) -> Result<(Self, Option<PathBuf>), Invalid> {
        match self {
            Self::Blisk(job) => {
                let (job, file) = set_in(&BLISK_FIELDS, job, (key, value), folder)?;
                Ok((Self::Blisk(job.into()), file))
            }
            Self::Mold(params) if key == LIBRARY => {
                let file = paths::without_detours(&folder.join(value));
                let library = CUTTERS.read(&file).map_err(|error| Invalid::of(key, error.to_string()))?;
                Ok((Self::Mold(MoldParams { library, ..(**params).clone() }.into()), Some(file)))
            }
            Self::Mold(params) => {
                let (params, file) = set_in(&MOLD_FIELDS, params, (key, value), folder)?;
                Ok((Self::Mold(params.into()), file))
            }
        }
    }

    /// The parameters with all of `settings`, completed, and checked as a whole.
    ///
    /// # Errors
    /// The first setting that is not possible.
    pub fn with(&self, settings: &[Setting], folder: &Path) -> Result<Self, Invalid> {
        let mut all = self.clone();
        for setting in settings {
            (all, _) = all.set(*setting, folder)?;
        }
        let is_set = |key: &str| settings.iter().any(|(set, _)| *set == key);
        match &mut all {
            Self::Blisk(job) => complete(&mut **job, &is_set)?,
            Self::Mold(params) => complete(&mut **params, &is_set)?,
        }
        Ok(all)
    }

    /// Whether the parameter `key` takes whole numbers only.
    ///
    /// # Errors
    /// If there is no such parameter.
    pub fn is_whole(&self, key: &str) -> Result<bool, Invalid> {
        let is_whole = |kind: &Kind| matches!(kind, Kind::Number { is_whole: true, .. });
        match self {
            Self::Blisk(_) => BLISK_FIELDS.find(key).map(|place| is_whole(&place.field.kind)),
            Self::Mold(_) => MOLD_FIELDS.find(key).map(|place| is_whole(&place.field.kind)),
        }
    }

    /// The files that the parameters name.
    pub fn files(&self) -> Vec<PathBuf> {
        let mut files = Vec::new();
        let mut add = |path: &Path| {
            files.push(path.to_owned());
            path.to_owned()
        };
        match self.clone() {
            Self::Blisk(mut job) => job.change_paths(&mut add),
            Self::Mold(mut params) => params.change_paths(&mut add),
        }
        files
    }
}

/// The parameters that a study of a project of this kind can vary: key and name.
pub fn varied_fields(kind: &str) -> Vec<(&'static str, String)> {
    let named = |field: &'static Field| {
        let is_single = !matches!(field.kind, Kind::Rows { .. } | Kind::Points { .. } | Kind::Variant { .. });
        let unit = if field.unit.is_empty() { String::new() } else { format!(" ({})", field.unit) };
        is_single.then(|| (field.key, format!("{}{unit}", field.label)))
    };
    match kind {
        PlanJob::KIND => BLISK_FIELDS.fields().filter_map(named).collect(),
        MoldParams::KIND => {
            MOLD_FIELDS.fields().filter_map(named).chain([(LIBRARY, "Library of cutters".to_owned())]).collect()
        }
        _ => Vec::new(),
    }
}

fn set_in<P: Params>(
    table: &FieldTable<P>,
    params: &P,
    (key, value): Setting,
    folder: &Path,
) -> Result<(P, Option<PathBuf>), Invalid> {
    let mut set = table.set(params, key, value)?;
    let mut file = None;
    set.change_paths(&mut |path| {
        if path != Path::new(value) {
            return path.to_owned();
        }
        let path = paths::without_detours(&folder.join(path));
        file = Some(path.clone());
        path
    });
    Ok((set, file))
}

fn complete<P: Params>(params: &mut P, is_set: &dyn Fn(&str) -> bool) -> Result<(), Invalid> {
    params.complete(is_set)?;
    params.validate()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_value_that_names_a_file_is_seen_from_the_folder_of_the_study() {
        let folder = Path::new("/studies/a");
        let base = Base::Blisk(PlanJob::for_mesh(Path::new("/parts/part.stl")).into());
        let (set, file) = base.set(("blisk.mesh", "../b.stl"), folder).unwrap();
        assert_eq!(file.as_deref(), Some(Path::new("/studies/b.stl")));
        assert_eq!(set.files(), [Path::new("/studies/b.stl")]);
        // A machine that comes with the program is no file.
        let (_, none) = base.set(("machine.name", "xyzc"), folder).unwrap();
        let (_, own) = base.set(("machine.name", "own.toml"), folder).unwrap();
        assert_eq!((none, own.as_deref()), (None, Some(Path::new("/studies/a/own.toml"))));
        assert!(base.is_whole("blisk.channel").unwrap() && !base.is_whole("electrode.spark_gap_mm").unwrap());
        let said = base.set(("electrode.pats", "1"), folder).unwrap_err().to_string();
        assert!(said.contains("did you mean electrode.parts?"), "{said}");
    }

    #[test]
    fn settings_are_checked_as_a_whole() {
        let base = Base::Blisk(PlanJob::for_mesh(Path::new("/parts/part.stl")).into());
        let folder = Path::new("/studies");
        let said = base.with(&[("genetic.h", "variable")], folder).unwrap_err().to_string();
        assert!(said.contains("genetic.h"), "{said}");
        let Base::Blisk(job) = base.with(&[("electrode.parts", "2"), ("genetic.seed", "9")], folder).unwrap() else {
            panic!("it is a blisk")
        };
        assert_eq!((job.electrode.parts, job.genetic.seed), (2, 9));
        assert!(base.set(("library", "a.toml"), folder).is_err(), "a blisk has no cutters");
    }

    #[test]
    fn a_library_of_cutters_takes_the_place_of_a_molds_own() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("mine.toml"), "[[cutter]]\ndiameter_mm = 3.0\n").unwrap();
        let base = Base::Mold(MoldParams::default().into());
        let (set, file) = base.set(("library", "mine.toml"), folder.path()).unwrap();
        let Base::Mold(params) = set else { panic!("it is a mold") };
        assert!(params.library.cutter.len() == 1 && file == Some(folder.path().join("mine.toml")));
        let said = base.set(("library", "none.toml"), folder.path()).unwrap_err().to_string();
        assert!(said.starts_with("library: ") && said.contains("none.toml"), "{said}");
    }

    #[test]
    fn a_project_of_another_kind_names_the_commands_that_it_has() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("a.sparkpath");
        for (kind, command, words) in [
            ("mold", StudyCommand::Plan, "a study of a mold has the command uncut or electrodes, not plan"),
            ("blisk", StudyCommand::Uncut, "a study of a blisk has the command plan or size, not uncut"),
            ("flank", StudyCommand::Plan, "there are none of flanks"),
        ] {
            std::fs::write(&file, format!("kind = \"{kind}\"\n")).unwrap();
            let said = Base::read(&file, command, None).unwrap_err().to_string();
            assert!(said.contains(words), "{said}");
        }
        assert!(Base::read(&folder.path().join("a.toml"), StudyCommand::Plan, None).is_err());
    }
}
