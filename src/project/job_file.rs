//! The TOML job file of `sparkpath plan`. Every key but the mesh has a default, and a key that is not known is
//! an error, since a misspelt one would otherwise be ignored in silence.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::paths::{absolute, relative};
use crate::blisk::electrode::{ElectrodeParams, EnterSide, Sizing};
use crate::blisk::options::BliskOptions;
use crate::export::choice::{Channels, DrawnPictures, MeshFrame, WrittenFiles};
use crate::export::nc::NcSettings;
use crate::feed::genetic::{GeneticParams, ReductionMode};
use crate::feed::machine::MachineParams;
use crate::feed::machine_model::{is_file, machine_table};
use crate::feed::plan_params::PlanParams;
use crate::feed::search::{Constraint, Strategy};
use crate::feed::verify::VerifyOptions;
use crate::mesh_io::Units;

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

/// Why a job file cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum JobFileError {
    /// It cannot be read.
    #[error("{path}: cannot be read ({source}); check the path")]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// It is not valid TOML, or a key is unknown or of the wrong kind.
    #[error("{path}: {place}{message}")]
    Invalid {
        /// The file.
        path: PathBuf,
        /// Line and column, or section, with its separator; may be empty.
        place: String,
        /// What is wrong and what to do.
        message: String,
    },
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
        self.verify.validate().map_err(|e| format!("[verify] {e}"))?;
        self.export.validate()?;
        if self.electrode.mesh.is_some() && self.genetic.h == ReductionMode::Variable {
            return Err(
                "[genetic] h = \"variable\": an electrode mesh of your own cannot be reduced; use h = \"given\""
                    .to_owned(),
            );
        }
        if self.plan.strategy != Strategy::Genetic && self.genetic.h == ReductionMode::Variable {
            return Err(
                "[genetic] h = \"variable\": only the strategy \"genetic\" searches h; use h = \"given\"".to_owned()
            );
        }
        if self.plan.strategy == Strategy::Global && self.plan.constraint == Constraint::Angle {
            return Err("[plan] constraint = \"angle\": the strategy \"global\" works on distances; use constraint = \
                        \"distance\", or another strategy"
                .to_owned());
        }
        if self.verify.tolerance_mm >= 0.5 * self.electrode.spark_gap_mm {
            return Err(format!(
                "[verify] tolerance_mm = {}: must be less than half of spark_gap_mm = {}",
                self.verify.tolerance_mm, self.electrode.spark_gap_mm
            ));
        }
        Ok(())
    }

    /// Reads a job file. Paths in it are relative to its folder.
    pub fn read(path: &Path) -> Result<Self, JobFileError> {
        let text = std::fs::read_to_string(path)
            .map_err(|source| JobFileError::Unreadable { path: path.to_owned(), source })?;
        let folder = path.parent().unwrap_or(Path::new(""));
        Self::parse(&text, folder).map_err(|Problem { place, message }| JobFileError::Invalid {
            path: path.to_owned(),
            place,
            message,
        })
    }

    /// The parameters in a JSON value as [`serde_json::to_value`] makes it of a job, paths relative to `folder`.
    pub(super) fn from_json(value: serde_json::Value, folder: &Path) -> Result<Self, String> {
        let table = toml::Table::try_from(without_nulls(value)).map_err(|e| one_line(&e.to_string()))?;
        Self::from_table(table, folder).map_err(|Problem { place, message }| place + &message)
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

    fn parse(text: &str, folder: &Path) -> Result<Self, Problem> {
        let table: toml::Table = toml::from_str(text).map_err(|error| {
            let place = error.span().map_or(String::new(), |span| {
                let before = &text[..span.start.min(text.len())];
                let line = before.matches('\n').count() + 1;
                format!("line {line}: ")
            });
            Problem { place, message: one_line(error.message()) }
        })?;
        let job = Self::from_table(table, folder)?;
        if job.blisk.mesh.is_none() {
            return Err(Problem::at("[blisk] ", "mesh is missing; give the mesh file, as in mesh = \"part.stl\""));
        }
        if job.electrode.size == Sizing::Auto {
            return Err(Problem::at(
                "[electrode] size: ",
                "\"auto\" is not available; give the reductions, or let the search find h with [genetic] h = \"variable\"",
            ));
        }
        Ok(job)
    }

    fn from_table(mut table: toml::Table, folder: &Path) -> Result<Self, Problem> {
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
            Some(other) => Err(Problem::at(
                &format!("[{other}] "),
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

struct Problem {
    place: String,
    message: String,
}

impl Problem {
    fn at(place: &str, message: &str) -> Self {
        Self { place: place.to_owned(), message: message.to_owned() }
    }
}

fn one_line(message: &str) -> String {
    message.split_whitespace().collect::<Vec<_>>().join(" ")
}

fn take_table(table: &mut toml::Table, name: &str) -> Result<toml::Table, Problem> {
    match table.remove(name) {
        None => Ok(toml::Table::new()),
        Some(toml::Value::Table(section)) => Ok(section),
        Some(_) => Err(Problem::at(&format!("{name}: "), &format!("must be a section; write [{name}]"))),
    }
}

fn take<T: for<'a> Deserialize<'a>>(table: &mut toml::Table, section: &str, key: &str) -> Result<Option<T>, Problem> {
    table
        .remove(key)
        .map(|value| value.try_into())
        .transpose()
        .map_err(|e: toml::de::Error| Problem::at(&format!("[{section}] {key}: "), &one_line(e.message())))
}

/// The keys of `[machine]`, which take the place of those of the machine that is named.
fn machine(mut given: toml::Table, folder: &Path) -> Result<MachineParams, Problem> {
    let file: Option<PathBuf> = take(&mut given, "machine", "file")?;
    let name: Option<String> = take(&mut given, "machine", "name")?;
    let name = match (name.filter(|n| !n.is_empty()), file) {
        (Some(_), Some(_)) => return Err(Problem::at("[machine] ", "name and file are two machines; give one")),
        (Some(name), None) if !is_file(&name) => name,
        (Some(name), None) => folder.join(name).to_string_lossy().into_owned(),
        (None, Some(file)) if is_file(&file.to_string_lossy()) => folder.join(file).to_string_lossy().into_owned(),
        (None, Some(_)) => return Err(Problem::at("[machine] file: ", "must be the path of a machine file (.toml)")),
        (None, None) => return section(given, "machine"),
    };
    // A job that says everything itself, as a saved one does, can be read without the file.
    let everything = toml::Table::try_from(MachineParams::default()).unwrap_or_default();
    let mut table = match everything.keys().all(|key| key == "name" || given.contains_key(key)) {
        true => toml::Table::new(),
        false => machine_table(&name).map_err(|e| Problem::at("[machine] ", &one_line(&e.to_string())))?,
    };
    table.extend(given);
    let params: MachineParams = section(table, "machine")?;
    Ok(MachineParams { name, ..params })
}

fn section<T: for<'a> Deserialize<'a>>(table: toml::Table, name: &str) -> Result<T, Problem> {
    toml::Value::Table(table)
        .try_into()
        .map_err(|e: toml::de::Error| Problem::at(&format!("[{name}] "), &one_line(&e.to_string())))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::feed::axis_curve::Joining;
    use crate::feed::machine::AxisSet;

    fn parse(text: &str) -> Result<PlanJob, String> {
        PlanJob::parse(text, Path::new("jobs")).map_err(|p| p.place + &p.message)
    }

    #[test]
    fn a_mesh_is_all_a_job_needs() {
        let job = parse("[blisk]\nmesh = \"part.stl\"").unwrap();
        let demonstration = PlanJob::demonstration();
        assert_eq!(job.blisk.mesh.as_deref(), Some(Path::new("jobs/part.stl")));
        assert_eq!(
            (job.plan, job.genetic, job.machine),
            (demonstration.plan, demonstration.genetic, demonstration.machine)
        );
    }

    #[test]
    fn the_keys_of_the_contract_are_understood() {
        let job = parse(
            r#"
            [blisk]
            mesh = "part.stl"
            units = "mm"
            axis = "auto"
            blades = "auto"
            channel = 0
            hub_radius_mm = "auto"
            shroud_radius_mm = 125.0
            [electrode]
            spark_gap_mm = 0.10
            circumferential_reduction_deg = [0.8, 0.9]
            radial_reduction_mm = 0.5
            parts = 1
            overlap_mm = 1.0
            enter = "-x"
            size = "given"
            [machine]
            axes = "XYZAC"
            [plan]
            strategy = "genetic"
            step_mm = 0.5
            exit_clearance_mm = 5.0
            margin_mm = 0.0
            [plan.weights]
            a3 = 0.5
            b3 = 0.5
            [genetic]
            population = 30
            generations = 10
            crossover = 0.8
            mutation = 0.1
            seed = 7
            [verify]
            tolerance_mm = 0.002
            "#,
        )
        .unwrap();
        assert_eq!(job.electrode.circumferential_reduction_deg, [0.8, 0.9]);
        assert_eq!((job.genetic.seed, job.plan.weights.a3), (7, 0.5));
    }

    #[test]
    fn a_job_may_follow_the_centreline_and_join_by_nurbs() {
        let text = "[blisk]\nmesh = \"a.stl\"\n[plan]\nstrategy = \"centreline\"\n[plan.centreline]\n\
                    safety_increase_mm = 0.2\n[plan.interpolation]\nkind = \"nurbs\"\ndegree = 4";
        let mut job = parse(text).unwrap();
        assert_eq!((job.plan.strategy, job.plan.centreline.safety_increase_mm), (Strategy::Centreline, 0.2));
        assert_eq!(job.plan.interpolation.joining(), Joining::Nurbs(4));
        assert_eq!(job.validate(), Ok(()));
        job.genetic.h = ReductionMode::Variable;
        assert!(job.validate().unwrap_err().contains("[genetic] h"));
    }

    #[test]
    fn what_is_exported_can_be_said_and_is_everything_by_default() {
        let job = parse("[blisk]\nmesh = \"a.stl\"\n[export]\npost = \"beckhoff-edm\"").unwrap();
        assert_eq!(job.export, ExportSection { post: "beckhoff-edm".to_owned(), ..Default::default() });
        let text = "[blisk]\nmesh = \"a.stl\"\n[export]\nframe = \"w\"\n[export.files]\nnc = false\npictures = false\n\
                    [export.pictures]\nsweep = false";
        let export = parse(text).unwrap().export;
        assert_eq!(export.frame, MeshFrame::W);
        assert_eq!(export.files, WrittenFiles { nc: false, pictures: false, ..Default::default() });
        assert!(export.pictures.final_pose && !export.pictures.sweep);
        // What is chosen in the window comes back from a job file of it.
        let mut job = PlanJob::demonstration();
        (job.blisk.mesh, job.export) = (Some("jobs/a.stl".into()), export);
        let again = PlanJob::parse(&job.to_toml(Path::new("")).unwrap(), Path::new("")).map_err(|p| p.message).unwrap();
        assert_eq!(again, job);
    }

    #[test]
    fn a_job_file_finds_its_meshes_wherever_it_lies() {
        let folder = tempfile::tempdir().unwrap();
        let [parts, jobs] = ["parts", "jobs"].map(|name| folder.path().join(name));
        for folder in [&parts, &jobs] {
            std::fs::create_dir(folder).unwrap();
        }
        let [mesh, own, post] = ["part.stl", "own.stl", "mine.toml"].map(|name| parts.join(name));
        for file in [&mesh, &own, &post] {
            std::fs::write(file, "").unwrap();
        }
        let mut job = PlanJob::demonstration();
        (job.blisk.mesh, job.electrode.mesh) = (Some(mesh.clone()), Some(own.clone()));
        job.export.post = post.to_str().unwrap().to_owned();
        let file = jobs.join("job.toml");
        std::fs::write(&file, job.to_toml(&jobs).unwrap()).unwrap();
        let read = PlanJob::read(&file).unwrap();
        let same = |read: &Path, meant: &Path| read.canonicalize().unwrap() == meant.canonicalize().unwrap();
        assert!(same(&read.blisk.mesh.unwrap(), &mesh) && same(&read.electrode.mesh.unwrap(), &own));
        assert!(same(Path::new(&read.export.post), &post));
        assert!(PlanJob::demonstration().to_toml(&jobs).is_err(), "it would be a job that is refused");
        // A path as the command line gave it is seen from the working folder.
        job.blisk.mesh = Some("Cargo.toml".into());
        std::fs::write(&file, job.to_toml(&jobs).unwrap()).unwrap();
        assert!(same(&PlanJob::read(&file).unwrap().blisk.mesh.unwrap(), Path::new("Cargo.toml")));
    }

    #[test]
    fn an_export_of_nothing_is_refused_and_draws_nothing() {
        let mut job = PlanJob::demonstration();
        job.export.files =
            WrittenFiles { electrode: false, path: false, nc: false, report: false, leftover: false, pictures: false };
        assert!(job.validate().unwrap_err().contains("[export.files]"));
        assert!(!job.export.draws_any());
        job.export.files.report = true;
        assert!(job.validate().is_ok() && job.export.draws_any(), "a page of the report holds pictures of its own");
    }

    #[test]
    fn mistakes_are_named_with_their_place() {
        for (text, named) in [
            ("[blisk]\n", "mesh"),
            ("[blisk]\nmesh = \"a.stl\"\nblade = 3", "blade"),
            ("[blisk]\nmesh = 7", "[blisk] mesh"),
            ("[blisk]\nmesh = \"a.stl\"\n[plan]\nstep_mm = \"wide\"", "[plan]"),
            ("[blisk]\nmesh = \"a.stl\"\n[genetics]\nseed = 2", "[genetics]"),
            ("[blisk\nmesh = 1", "line 1"),
            ("blisk = 3", "blisk"),
        ] {
            let message = parse(text).unwrap_err();
            assert!(message.contains(named) && !message.contains('\n'), "{text:?}: {message}");
        }
    }

    #[test]
    fn the_global_strategy_works_on_distances_alone() {
        let mut job = PlanJob::demonstration();
        job.plan.strategy = Strategy::Global;
        assert_eq!(job.validate(), Ok(()));
        job.plan.constraint = Constraint::Angle;
        assert!(job.validate().unwrap_err().contains("works on distances"));
        job.plan.strategy = Strategy::Genetic;
        assert_eq!(job.validate(), Ok(()));
    }

    #[test]
    fn a_machine_is_named_and_its_keys_may_be_given_otherwise() {
        let with = |machine: &str| parse(&format!("[blisk]\nmesh = \"a.stl\"\n[machine]\n{machine}"));
        let none = with("axes = \"XYZC\"").unwrap().machine;
        assert!(!none.has_bodies() && none.travel_x_mm == MachineParams::default().travel_x_mm);
        let job = with("name = \"xyzabc\"\ntravel_b_deg = [-10.0, 20.0]").unwrap();
        assert_eq!((job.machine.axes, job.machine.travel_b_deg), (AxisSet::XYZABC, [-10.0, 20.0]));
        assert!(job.machine.has_bodies() && job.machine.travel_c_deg == [-360.0, 360.0]);
        assert!(with("name = \"mill\"").unwrap_err().contains("there is no such machine"));
        assert!(with("name = \"xyzc\"\nfile = \"my.toml\"").unwrap_err().contains("two machines"));
        assert!(with("file = \"my.step\"").unwrap_err().contains("[machine] file"));
        assert!(with("file = \"my.toml\"").unwrap_err().contains("cannot be read"));
        let job = with("name = \"xyzc\"\nbody_clearance_mm = 0.0").unwrap();
        assert!(job.validate().unwrap_err().contains("body_clearance_mm"));
    }

    #[test]
    fn a_machine_file_is_found_from_the_job_and_written_for_its_folder() {
        let folder = tempfile::tempdir().unwrap();
        let machine = folder.path().join("my.toml");
        std::fs::write(&machine, "axes = \"XYZC\"\ntravel_z_mm = [-7.0, 8.0]\nspeed_mm_min = 30.0\n").unwrap();
        let text = "[blisk]\nmesh = \"a.stl\"\n[machine]\nfile = \"my.toml\"\nspeed_mm_min = 20.0";
        let job = PlanJob::parse(text, folder.path()).map_err(|p| p.message).unwrap();
        let m = &job.machine;
        assert_eq!((m.axes, m.travel_z_mm, m.speed_mm_min), (AxisSet::XYZC, [-7.0, 8.0], 20.0));
        assert_eq!(Path::new(&m.name), machine);
        let written = job.to_toml(folder.path()).unwrap();
        assert!(written.contains("name = \"my.toml\""), "{written}");
        // It says everything itself, and so can be read without the machine's file.
        std::fs::remove_file(&machine).unwrap();
        let again = PlanJob::parse(&written, folder.path()).map_err(|p| p.message).unwrap();
        assert_eq!(again.machine, job.machine);
    }
}
