//! The TOML job file of `sparkpath plan`. Every key but the mesh has a default, and a key that is not known is
//! an error, since a misspelt one would otherwise be ignored in silence.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::machine_file::{is_file, machine_table};
use crate::workspaces::blisk::document::choice::{Channels, DrawnPictures, MeshFrame, WrittenFiles};
use feed::genetic::{GeneticParams, ReductionMode};
use feed::machine::MachineParams;
use feed::plan_params::PlanParams;
use feed::plan_params::{Constraint, Strategy};
use feed::verify::VerifyOptions;
use files::paths::{absolute, relative};
use files::{FileError, Invalid, TomlFile, read_text};
use import::Units;
use nc::program::NcSettings;
use wheel::electrode::{ElectrodeParams, EnterSide, Sizing};
use wheel::options::BliskOptions;

/// The largest job file that is read (bytes).
const LARGEST_FILE: u64 = 1 << 20;
/// Job files; what their sections hold is looked at one by one.
const JOB: TomlFile<toml::Table> = TomlFile::new("job");

/// A job: what to plan, with what, and how.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PlanJob {
    /// `[blisk]`: mesh and unit, and how its channel is found.
    pub blisk: BliskSection,
    /// `[electrode]`: how the electrode is made, or the user's own.
    pub electrode: ElectrodeParams,
    /// `[machine]`
    pub machine: MachineParams,
    /// `[plan]`
    pub plan: PlanParams,
    /// `[genetic]`
    pub genetic: GeneticParams,
    /// `[verify]`
    pub verify: VerifyOptions,
    /// `[export]`
    pub export: ExportSection,
}

/// `[blisk]`
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct BliskSection {
    /// Mesh file; none for the built-in demonstration blisk.
    pub mesh: Option<PathBuf>,
    /// Unit of the mesh file.
    pub units: Units,
    /// The other keys.
    #[serde(flatten)]
    pub options: BliskOptions,
}

/// `[export]`
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ExportSection {
    /// Post-processor: `"iso"`, another built-in one, or the path of a TOML file.
    pub post: String,
    /// Frame of the electrode meshes: `"mesh"` or `"w"`.
    pub frame: MeshFrame,
    /// Which channels the motion is simulated in and the NC program burns, the blisk being turned to them by A.
    pub channels: Channels,
    /// Which files are written.
    pub files: WrittenFiles,
    /// Which pictures are drawn.
    pub pictures: DrawnPictures,
    /// Speeds and times.
    pub nc: NcSettings,
}

impl Default for ExportSection {
    fn default() -> Self {
        Self {
            post: "iso".to_owned(),
            frame: MeshFrame::default(),
            channels: Channels::default(),
            files: WrittenFiles::default(),
            pictures: DrawnPictures::default(),
            nc: NcSettings::default(),
        }
    }
}

impl ExportSection {
    /// Whether it can be done.
    ///
    /// # Errors
    /// One line naming the key.
    pub fn validate(&self) -> Result<(), String> {
        self.nc.validate().map_err(|e| format!("[export.nc] {e}"))?;
        if !self.files.any() {
            return Err("[export.files] all are false, so that nothing would be written; set one to true".to_owned());
        }
        Ok(())
    }

    /// Whether any picture is drawn, which is so only if a file shall hold it.
    pub fn draws_any(&self) -> bool {
        (self.files.report || self.files.pictures) && self.pictures.any()
    }
}

impl PlanJob {
    /// A job on the built-in demonstration blisk, whose passage widens towards +X; all else by default.
    pub fn demonstration() -> Self {
        Self {
            blisk: BliskSection { mesh: None, units: Units::default(), options: BliskOptions::default() },
            electrode: ElectrodeParams {
                circumferential_reduction_deg: [2.0, 2.0],
                enter: EnterSide::PlusX,
                ..Default::default()
            },
            machine: MachineParams::default(),
            plan: PlanParams::default(),
            genetic: GeneticParams::default(),
            verify: VerifyOptions::default(),
            export: ExportSection::default(),
        }
    }

    /// Whether every parameter is usable, as far as that can be told before a mesh is seen.
    pub fn validate(&self) -> Result<(), String> {
        let text = |e: &dyn std::fmt::Display| e.to_string();
        self.blisk.options.validate()?;
        self.electrode.validate().map_err(|e| text(&e))?;
        self.machine.validate().map_err(|e| text(&e))?;
        self.plan.validate().map_err(|e| text(&e))?;
        self.genetic.validate().map_err(|e| text(&e))?;
        self.export.validate()?;
        if self.electrode.mesh.is_some() && self.genetic.h == ReductionMode::Variable {
            return Err(
                "[genetic] h = \"variable\": an electrode mesh of your own cannot be reduced; use h = \"given\""
                    .to_owned(),
            );
        }
        if self.plan.strategy != Strategy::Genetic && self.genetic.h == ReductionMode::Variable {
            return Err(
                "[genetic] h = \"variable\": only the strategy \"genetic\" searches h; use h = \"given\", or [plan] strategy = \
                 \"genetic\""
                    .to_owned(),
            );
        }
        if self.electrode.size == Sizing::Auto {
            self.can_be_sized()?;
        }
        if self.plan.strategy == Strategy::Global && self.plan.constraint == Constraint::Angle {
            return Err("[plan] constraint = \"angle\": the strategy \"global\" works on distances; use constraint = \
                        \"distance\", or another strategy"
                .to_owned());
        }
        self.verify.validate(self.electrode.spark_gap_mm).map_err(|e| format!("[verify] {e}"))
    }

    fn can_be_sized(&self) -> Result<(), String> {
        let why = if self.electrode.mesh.is_some() {
            "an electrode mesh of your own has the size it has"
        } else if self.genetic.h == ReductionMode::Variable {
            "the reductions are found once, not node by node as [genetic] h = \"variable\" does; use h = \"given\""
        } else if self.plan.constraint == Constraint::Angle {
            "sizing works on distances; use [plan] constraint = \"distance\""
        } else {
            return Ok(());
        };
        Err(format!("[electrode] size = \"auto\": {why}"))
    }

    /// Reads a job file. Paths in it are relative to its folder.
    ///
    /// # Errors
    /// [`FileError`].
    pub fn read(path: &Path) -> Result<Self, FileError> {
        Self::parse(&read_text(path, "job", LARGEST_FILE)?, path)
    }

    /// The parameters in a JSON value as [`serde_json::to_value`] makes it of a job, paths relative to `folder`.
    pub(super) fn from_json(value: serde_json::Value, folder: &Path) -> Result<Self, String> {
        let table = toml::Table::try_from(without_nulls(value)).map_err(|e| one_line(&e.to_string()))?;
        Self::from_table(table, folder).map_err(|problem| problem.to_string())
    }

    /// The job as a job file for the command line, to lie in `folder`.
    ///
    /// # Errors
    /// If there is no mesh, without which a job file is refused, or a number has no form in TOML.
    pub fn to_toml(&self, folder: &Path) -> Result<String, String> {
        if self.blisk.mesh.is_none() {
            return Err("the demonstration blisk has no mesh file that a job could name; open a mesh".to_owned());
        }
        let job = self.seen_from(&absolute(folder));
        let value = serde_json::to_value(job).map_err(|e| e.to_string())?;
        toml::to_string_pretty(&without_nulls(value)).map_err(|e| one_line(&e.to_string()))
    }

    /// The job with its paths as seen from the absolute `folder`.
    pub(super) fn seen_from(&self, folder: &Path) -> Self {
        let mut job = self.clone();
        for mesh in [&mut job.blisk.mesh, &mut job.electrode.mesh] {
            *mesh = mesh.take().map(|p| relative(&p, folder));
        }
        if is_file(&job.machine.name) {
            job.machine.name = relative(Path::new(&job.machine.name), folder).to_string_lossy().into_owned();
        }
        if job.export.post.ends_with(".toml") {
            job.export.post = relative(Path::new(&job.export.post), folder).to_string_lossy().into_owned();
        }
        job
    }

    fn parse(text: &str, file: &Path) -> Result<Self, FileError> {
        let table = JOB.parse(text, file)?;
        let placed = |problem| FileError::placed(file, text, problem);
        let job = Self::from_table(table, file.parent().unwrap_or(Path::new(""))).map_err(placed)?;
        if job.blisk.mesh.is_none() {
            let remedy = "it is missing; give the mesh file, as in mesh = \"part.stl\"";
            return Err(placed(Invalid::of("blisk.mesh", remedy)));
        }
        Ok(job)
    }

    fn from_table(mut table: toml::Table, folder: &Path) -> Result<Self, Invalid> {
        let mut blisk = take_table(&mut table, "blisk")?;
        let mesh: Option<PathBuf> = take(&mut blisk, "blisk", "mesh")?;
        let mesh = mesh.filter(|m| !m.as_os_str().is_empty()).map(|m| folder.join(m));
        let units = take(&mut blisk, "blisk", "units")?.unwrap_or_default();
        let mut electrode: ElectrodeParams = section(take_table(&mut table, "electrode")?, "electrode")?;
        electrode.mesh = electrode.mesh.map(|p| folder.join(p));
        let mut export: ExportSection = section(take_table(&mut table, "export")?, "export")?;
        if export.post.ends_with(".toml") {
            export.post = folder.join(&export.post).to_string_lossy().into_owned();
        }
        let job = Self {
            blisk: BliskSection { mesh, units, options: section(blisk, "blisk")? },
            electrode,
            machine: machine(take_table(&mut table, "machine")?, folder)?,
            plan: section(take_table(&mut table, "plan")?, "plan")?,
            genetic: section(take_table(&mut table, "genetic")?, "genetic")?,
            verify: section(take_table(&mut table, "verify")?, "verify")?,
            export,
        };
        match table.keys().next() {
            None => Ok(job),
            Some(other) => Err(Invalid::of(
                other,
                "is no section of a plan; there are [blisk], [electrode], [machine], [plan], [genetic], [verify], [export]",
            )),
        }
    }
}

/// TOML has no null: what is not there is left out.
fn without_nulls(value: serde_json::Value) -> serde_json::Value {
    match value {
        serde_json::Value::Object(fields) => {
            fields.into_iter().filter(|(_, v)| !v.is_null()).map(|(key, v)| (key, without_nulls(v))).collect()
        }
        other => other,
    }
}

fn one_line(message: &str) -> String {
    message.split_whitespace().collect::<Vec<_>>().join(" ")
}

fn take_table(table: &mut toml::Table, name: &str) -> Result<toml::Table, Invalid> {
    match table.remove(name) {
        None => Ok(toml::Table::new()),
        Some(toml::Value::Table(section)) => Ok(section),
        Some(_) => Err(Invalid::of(name, format!("must be a section; write [{name}]"))),
    }
}

fn take<T: for<'a> Deserialize<'a>>(table: &mut toml::Table, section: &str, key: &str) -> Result<Option<T>, Invalid> {
    table
        .remove(key)
        .map(|value| value.try_into())
        .transpose()
        .map_err(|e: toml::de::Error| Invalid::of(format!("{section}.{key}"), one_line(e.message())))
}

/// The keys of `[machine]`, which take the place of those of the machine that is named.
fn machine(mut given: toml::Table, folder: &Path) -> Result<MachineParams, Invalid> {
    let file: Option<PathBuf> = take(&mut given, "machine", "file")?;
    let name: Option<String> = take(&mut given, "machine", "name")?;
    let name = match (name.filter(|n| !n.is_empty()), file) {
        (Some(_), Some(_)) => return Err(Invalid::of("machine", "name and file are two machines; give one")),
        (Some(name), None) if !is_file(&name) => name,
        (Some(name), None) => folder.join(name).to_string_lossy().into_owned(),
        (None, Some(file)) if is_file(&file.to_string_lossy()) => folder.join(file).to_string_lossy().into_owned(),
        (None, Some(_)) => return Err(Invalid::of("machine.file", "must be the path of a machine file (.toml)")),
        (None, None) => return section(given, "machine"),
    };
    // A job that says everything itself, as a saved one does, can be read without the file.
    let everything = toml::Table::try_from(MachineParams::default()).unwrap_or_default();
    let mut table = match everything.keys().all(|key| key == "name" || given.contains_key(key)) {
        true => toml::Table::new(),
        false => machine_table(&name).map_err(|e| Invalid::of("machine", one_line(&e.to_string())))?,
    };
    let is_from_file = !table.is_empty();
    table.extend(given.clone());
    let params = MachineParams { name, ..section(table, "machine")? };
    let own: MachineParams = section(given, "machine")?;
    match params.validate() {
        // What the job itself says is told with the other mistakes of a job.
        Err(error) if is_from_file && own.validate().is_ok() => {
            let error = error.to_string();
            let problem = error.strip_prefix("[machine] ").unwrap_or(&error);
            Err(Invalid::of("machine", format!("{}: {problem}", params.name)))
        }
        _ => Ok(params),
    }
}

fn section<T: for<'a> Deserialize<'a>>(table: toml::Table, name: &str) -> Result<T, Invalid> {
    toml::Value::Table(table).try_into().map_err(|e: toml::de::Error| Invalid::of(name, one_line(&e.to_string())))
}

#[cfg(test)]
mod tests;
