//! The parameters of a plan, in a project file as TOML. Every key but the mesh has a default. An unknown key is an
//! error, because a misspelt key would otherwise be ignored.

mod blade_fields;
mod choice_words;
mod electrode_fields;
pub mod field_table;
mod scan_fields;
mod setting_fields;
mod setup_fields;
mod technology_fields;
mod weight_fields;

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::machine_file::{is_file, machine_table};
use crate::workspaces::blisk::document::burning::BurningSection;
use crate::workspaces::blisk::document::choice::{Channels, DrawnPictures, MeshFrame, WrittenFiles};
use crate::workspaces::blisk::document::scan::ScanSection;
use crate::workspaces::blisk::document::setting::SettingSection;
use crate::workspaces::blisk::document::setup::SetUpSection;
use burning::project::ProjectTechnology;
use feed::genetic::{GeneticParams, ReductionMode};
use feed::machine::MachineParams;
use feed::plan_params::PlanParams;
use feed::plan_params::{Constraint, Strategy};
use feed::verify::{VerifyError, VerifyOptions};
use field_table::FIELDS;
use files::{Invalid, Params, Validate};
use import::{Reading, Units};
use nc::program::NcSettings;
use nc::template::STANDARD;
use wheel::blade_sections::BladeRing;
use wheel::electrode::{ElectrodeParams, EnterSide, Sizing};
use wheel::options::{Auto, AxisChoice, BliskOptions, EndWalls, ZAt};
use wheel::parametric::ParametricBlisk;
use wheel::section_deviation::P1_LIMIT_MM;

/// Parameters of a plan.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlanJob {
    /// `[blisk]`: mesh, unit, and how the channel is found.
    #[serde(default)]
    pub blisk: BliskSection,
    /// `[electrode]`: how the electrode is made, or the user's own.
    #[serde(default)]
    pub electrode: ElectrodeParams,
    /// `[machine]`
    #[serde(default)]
    pub machine: MachineParams,
    /// `[plan]`
    #[serde(default)]
    pub plan: PlanParams,
    /// `[genetic]`
    #[serde(default)]
    pub genetic: GeneticParams,
    /// `[verify]`
    #[serde(default)]
    pub verify: VerifyOptions,
    /// `[export]`
    #[serde(default)]
    pub export: ExportSection,
    /// `[technology]`
    #[serde(default)]
    pub technology: ProjectTechnology,
    /// `[burning]`
    #[serde(default)]
    pub burning: BurningSection,
    /// `[setting]`
    #[serde(default)]
    pub setting: SettingSection,
    /// `[setup]`
    #[serde(default)]
    pub setup: SetUpSection,
    /// `[scan]`
    #[serde(default)]
    pub scan: ScanSection,
}

/// `[blisk]`
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(from = "BliskKeys")]
pub struct BliskSection {
    /// Mesh file; none for the built-in demonstration blisk.
    pub mesh: Option<PathBuf>,
    /// Solids, tolerance and unit in which the mesh file is read.
    #[serde(flatten)]
    pub reading: Reading,
    /// Blades that the blisk is made from, instead of a mesh.
    pub sections: BladesFrom,
    /// The other keys.
    #[serde(flatten)]
    pub options: BliskOptions,
}

/// Blades that a blisk is made from (`[blisk.sections]`).
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "lowercase")]
pub enum BladesFrom {
    /// The blisk has a mesh.
    #[default]
    None,
    /// Measured sections.
    Measured(MeasuredBlades),
    /// Parameters of their profile, P1 (3) to (5).
    Profile(ParametricBlisk),
}

impl BladesFrom {
    /// Blades of the same kind, from the same file, with defaults for all else.
    fn with_defaults(&self) -> Self {
        match self {
            Self::None => Self::None,
            Self::Measured(blades) => {
                Self::Measured(MeasuredBlades { file: blades.file.clone(), ..Default::default() })
            }
            Self::Profile(_) => Self::Profile(ParametricBlisk::default()),
        }
    }

    /// Greatest deviation of measured points that is accepted (mm).
    pub fn limit_mm(&self) -> f64 {
        match self {
            Self::Measured(blades) => blades.limit_mm,
            Self::None | Self::Profile(_) => P1_LIMIT_MM,
        }
    }
}

/// Measured sections of blades, and what they do not tell of the wheel.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct MeasuredBlades {
    /// Table of the sections.
    pub file: PathBuf,
    /// Greatest deviation of a measured point, from the wall that is planned for and from the wall through the other
    /// sections, that is accepted (mm).
    pub limit_mm: f64,
    /// Blades and rings.
    pub ring: BladeRing,
}

impl Default for MeasuredBlades {
    fn default() -> Self {
        Self { file: PathBuf::new(), limit_mm: P1_LIMIT_MM, ring: BladeRing::default() }
    }
}

/// The keys of `[blisk]` in one struct: serde finds unknown keys only there.
#[derive(Deserialize)]
#[serde(default, deny_unknown_fields)]
struct BliskKeys {
    mesh: Option<PathBuf>,
    units: Units,
    solids: Vec<u32>,
    obstacles: Vec<u32>,
    step_tolerance_mm: f64,
    sections: BladesFrom,
    axis: AxisChoice,
    blades: Auto<usize>,
    channel: usize,
    z_at: ZAt,
    hub_radius_mm: Auto<f64>,
    shroud_radius_mm: Auto<f64>,
    hub_points_mm: Vec<[f64; 3]>,
    shroud_points_mm: Vec<[f64; 3]>,
    end_walls: EndWalls,
    blade_points_mm: Vec<[f64; 3]>,
    wall_points_chord: usize,
    wall_points_span: usize,
}

impl Default for BliskKeys {
    fn default() -> Self {
        let options = BliskOptions::default();
        Self {
            mesh: None,
            units: Units::default(),
            solids: Vec::new(),
            obstacles: Vec::new(),
            step_tolerance_mm: Reading::STEP_TOLERANCE,
            sections: BladesFrom::default(),
            axis: options.axis,
            blades: options.blades,
            channel: options.channel,
            z_at: options.z_at,
            hub_radius_mm: options.hub_radius_mm,
            shroud_radius_mm: options.shroud_radius_mm,
            hub_points_mm: options.hub_points_mm,
            shroud_points_mm: options.shroud_points_mm,
            end_walls: options.end_walls,
            blade_points_mm: options.blade_points_mm,
            wall_points_chord: options.wall_points_chord,
            wall_points_span: options.wall_points_span,
        }
    }
}

impl From<BliskKeys> for BliskSection {
    fn from(keys: BliskKeys) -> Self {
        let options = BliskOptions {
            axis: keys.axis,
            blades: keys.blades,
            channel: keys.channel,
            z_at: keys.z_at,
            hub_radius_mm: keys.hub_radius_mm,
            shroud_radius_mm: keys.shroud_radius_mm,
            hub_points_mm: keys.hub_points_mm,
            shroud_points_mm: keys.shroud_points_mm,
            end_walls: keys.end_walls,
            blade_points_mm: keys.blade_points_mm,
            wall_points_chord: keys.wall_points_chord,
            wall_points_span: keys.wall_points_span,
        };
        let mesh = keys.mesh.filter(|mesh| !mesh.as_os_str().is_empty());
        let (units, step_tolerance_mm) = (keys.units, keys.step_tolerance_mm);
        let reading = Reading { units, solids: keys.solids, obstacles: keys.obstacles, step_tolerance_mm };
        Self { mesh, reading, sections: keys.sections, options }
    }
}

/// `[export]`
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ExportSection {
    /// Post-processor: `"iso"`, another built-in one, or the path of a TOML file.
    pub post: String,
    /// Template of the job sheet: `"standard"`, or the path of a file.
    pub job_sheet: String,
    /// Frame of the electrode meshes: `"mesh"` or `"w"`.
    pub frame: MeshFrame,
    /// Channels in which the motion is simulated and the NC program burns. The blisk is turned to them by A.
    pub channels: Channels,
    /// Files that are written.
    pub files: WrittenFiles,
    /// Pictures that are drawn.
    pub pictures: DrawnPictures,
    /// Speeds and times.
    pub nc: NcSettings,
}

impl Default for ExportSection {
    fn default() -> Self {
        Self {
            post: "iso".to_owned(),
            job_sheet: STANDARD.to_owned(),
            frame: MeshFrame::default(),
            channels: Channels::default(),
            files: WrittenFiles::default(),
            pictures: DrawnPictures::default(),
            nc: NcSettings::default(),
        }
    }
}

impl ExportSection {
    /// Whether any picture is drawn: only if a file holds it.
    pub fn draws_any(&self) -> bool {
        (self.files.report || self.files.pictures) && self.pictures.any()
    }
}

impl Default for PlanJob {
    fn default() -> Self {
        Self::demonstration()
    }
}

impl BliskSection {
    /// The file of the part: its mesh, or the table of its sections.
    pub fn file(&self) -> Option<&Path> {
        match &self.sections {
            BladesFrom::Measured(blades) => Some(&blades.file),
            _ => self.mesh.as_deref(),
        }
    }

    fn validate_sections(&self) -> Result<(), Invalid> {
        if self.sections != BladesFrom::None && self.mesh.is_some() {
            let remedy = "there is a mesh too: take blisk.mesh away, or set blisk.sections to \"none\"";
            return Err(Invalid::of("blisk.sections", remedy));
        }
        match &self.sections {
            BladesFrom::None => Ok(()),
            BladesFrom::Measured(blades) if blades.file.as_os_str().is_empty() => {
                Err(Invalid::of("blisk.sections.file", "must be the table of the measured sections"))
            }
            BladesFrom::Measured(blades) => {
                blades.ring.validate().map_err(|problem| problem.within("blisk.sections.ring"))
            }
            BladesFrom::Profile(blisk) => {
                blisk.validate().map_err(|problem| Invalid::of("blisk.sections", problem.to_string()))
            }
        }
    }
}

impl PlanJob {
    /// A job on the built-in demonstration blisk, whose passage widens towards +X; all else by default.
    pub fn demonstration() -> Self {
        Self {
            blisk: BliskSection::default(),
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
            technology: ProjectTechnology::default(),
            burning: BurningSection::default(),
            setting: SettingSection::default(),
            setup: SetUpSection::default(),
            scan: ScanSection::default(),
        }
    }

    /// A job on the blisk in the mesh file `mesh`, all else by default.
    pub fn for_mesh(mesh: &Path) -> Self {
        Self::of(BliskSection { mesh: Some(mesh.to_owned()), ..Default::default() })
    }

    /// A job on a blisk that is made from blades, all else by default.
    pub fn of_blades(sections: BladesFrom) -> Self {
        Self::of(BliskSection { sections, ..Default::default() })
    }

    fn of(blisk: BliskSection) -> Self {
        Self { blisk, electrode: ElectrodeParams::default(), ..Self::demonstration() }
    }

    /// The job of electrode number `number` as if its stage were the only one, and its number in that.
    pub fn of_electrode(&self, number: usize) -> (Self, usize) {
        let (stage, in_stage) = self.electrode.in_stage(number);
        (self.of_stage(stage), in_stage)
    }

    /// The job of stage `stage` as if it were the only one.
    #[must_use]
    pub fn of_stage(&self, stage: usize) -> Self {
        let mut job = self.clone();
        if let Some(own) = self.electrode.stage.get(stage) {
            (job.burning.last_step, job.burning.finish_vdi) = (own.last_step.clone(), own.finish_vdi);
        }
        job.electrode = self.electrode.of_stage(stage);
        job
    }

    fn can_be_sized(&self) -> Result<(), Invalid> {
        let why = if self.electrode.mesh.is_some() {
            "an electrode mesh of your own has the size it has; use \"given\""
        } else if self.genetic.h == ReductionMode::Variable {
            "the reductions are found once, not node by node; search the reduction h as \"given\""
        } else if self.plan.constraint == Constraint::Angle {
            "sizing works on distances; use the constraint \"distance\""
        } else {
            return Ok(());
        };
        Err(Invalid::new("electrode.size", "auto", why))
    }
}

impl Validate for PlanJob {
    /// Checks that every parameter is usable, as far as that is known before a mesh is read.
    fn validate(&self) -> Result<(), Invalid> {
        FIELDS.check(self)?;
        let other = |problem: &dyn std::fmt::Display| Invalid::of("", problem.to_string());
        self.blisk.options.validate().map_err(|e| other(&e))?;
        self.blisk.validate_sections()?;
        self.electrode.validate().map_err(|e| other(&e))?;
        self.machine.validate().map_err(|e| other(&e))?;
        self.plan.validate().map_err(|e| other(&e))?;
        self.genetic.validate().map_err(|e| other(&e))?;
        self.export.nc.validate().map_err(|e| other(&e))?;
        self.technology.validate().map_err(|problem| problem.within("technology"))?;
        self.burning.validate().map_err(|problem| problem.within("burning"))?;
        self.setup.validate().map_err(|problem| problem.within("setup"))?;
        self.scan.validate().map_err(|problem| problem.within("scan"))?;
        if !self.export.files.any() {
            return Err(Invalid::of("export.files", "no file is chosen, so that nothing would be written; choose one"));
        }
        let h = |why: &str| Err(Invalid::new("genetic.h", "variable", why));
        if self.genetic.h == ReductionMode::Variable && self.electrode.mesh.is_some() {
            return h("an electrode mesh of your own cannot be reduced; use \"given\"");
        }
        if self.genetic.h == ReductionMode::Variable && self.plan.strategy != Strategy::Genetic {
            return h("only the strategy \"genetic\" searches the reduction; use \"given\", or that strategy");
        }
        if self.electrode.size == Sizing::Auto {
            self.can_be_sized()?;
        }
        if self.plan.strategy == Strategy::Global && self.plan.constraint == Constraint::Angle {
            let why = "the strategy \"global\" works on distances; use \"distance\", or another strategy";
            return Err(Invalid::new("plan.constraint", "angle", why));
        }
        let of_stages = (0..self.electrode.stages()).map(|stage| self.electrode.of_stage(stage).spark_gap_mm);
        let gap = of_stages.fold(f64::INFINITY, f64::min);
        self.setting.validate(gap)?;
        self.verify.validate(gap).map_err(|e| match e {
            VerifyError::Tolerance { tolerance_mm, .. } => {
                let remedy = format!("must be less than half of the spark gap of {gap} mm; 0 is always allowed");
                Invalid::new("verify.tolerance_mm", tolerance_mm, remedy)
            }
            e => other(&e),
        })
    }
}

impl Params for PlanJob {
    const KIND: &'static str = "blisk";

    fn part(&self) -> String {
        let name = self.blisk.file().and_then(Path::file_name);
        let without = match self.blisk.sections {
            BladesFrom::Profile(_) => "Blisk of a profile",
            _ => "Demonstration blisk",
        };
        name.map_or_else(|| without.to_owned(), |name| name.to_string_lossy().into_owned())
    }

    fn name(&self) -> String {
        Path::new(&self.part()).file_stem().unwrap_or_default().to_string_lossy().into_owned()
    }

    fn change_paths(&mut self, change: &mut dyn FnMut(&Path) -> PathBuf) {
        let more = self.electrode.more.iter_mut().map(|own| &mut own.mesh).filter(|mesh| !mesh.as_os_str().is_empty());
        let meshes = [&mut self.blisk.mesh, &mut self.electrode.mesh, &mut self.burning.blank];
        for mesh in meshes.into_iter().flatten().chain(more) {
            *mesh = change(mesh);
        }
        if let BladesFrom::Measured(blades) = &mut self.blisk.sections
            && !blades.file.as_os_str().is_empty()
        {
            blades.file = change(&blades.file);
        }
        for file in [&mut self.scan.file, &mut self.setup.presets].into_iter().flatten() {
            *file = change(Path::new(file)).to_string_lossy().into_owned();
        }
        if self.technology.is_file() {
            let table = &mut self.technology.table;
            *table = change(Path::new(table)).to_string_lossy().into_owned();
        }
        let named = [
            (is_file as fn(&str) -> bool, &mut self.machine.name),
            (is_post, &mut self.export.post),
            (|name| name != STANDARD, &mut self.export.job_sheet),
        ];
        for (is_path, name) in named {
            if is_path(name) {
                *name = change(Path::new(name)).to_string_lossy().into_owned();
            }
        }
    }

    /// Meshes and sections are needed; a machine, a post or a template can be chosen later.
    fn needs(&self, path: &Path) -> bool {
        let blank = self.burning.blank.as_deref();
        self.blisk.file().into_iter().chain(self.electrode.own_meshes()).chain(blank).any(|file| file == path)
    }

    /// Axes, travels and speeds of the machine that is named, but for those that are given. What its file does not say
    /// stays as it is.
    fn complete(&mut self, is_given: &dyn Fn(&str) -> bool) -> Result<(), Invalid> {
        let name = self.machine.name.clone();
        let is_own = |key: &str| is_given(&format!("machine.{key}"));
        let wrong = |problem: &str| Invalid::of("machine.name", one_line(problem));
        let own = toml::Table::try_from(&self.machine).map_err(|e| wrong(&e.to_string()))?;
        // A project that says everything, as a saved one does, can be read without the machine's file.
        if name.is_empty() || !is_own("name") || own.keys().all(|key| is_own(key)) {
            return Ok(());
        }
        let of_file = machine_table(&name).map_err(|e| wrong(&e.to_string()))?;
        let mut table = own;
        table.extend(of_file.into_iter().filter(|(key, _)| !is_own(key)));
        let machine: MachineParams =
            toml::Value::Table(table).try_into().map_err(|e| wrong(&format!("{name}: {e}")))?;
        match machine.validate() {
            // What the project itself says wrong is told with its other mistakes.
            Err(error) if self.machine.validate().is_ok() => {
                let error = error.to_string();
                Err(wrong(&format!("{name}: {}", error.strip_prefix("machine.").unwrap_or(&error))))
            }
            _ => {
                self.machine = machine;
                Ok(())
            }
        }
    }
}

/// Whether the post `name` is a file rather than one of the built-in ones.
fn is_post(name: &str) -> bool {
    name.ends_with(".toml")
}

fn one_line(message: &str) -> String {
    message.split_whitespace().collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests;
