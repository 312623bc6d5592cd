//! The parameters of a flank to be milled.

pub mod cutter_list;
pub mod fields;
pub mod kept_mesh;
pub mod milling_machine_file;

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use crate::workspaces::flank::document::kept_mesh::KeptMesh;
use crate::workspaces::flank::document::milling_machine_file::file_of_machine;
use files::{Invalid, Override, Params, Validate};
use flank::FlankError;
use flank::cutter::FlankCutter;
use flank::fit_ruled::RuledFitParams;
use flank::guide::GuideCurve;
use flank::machine::linearise::LinearisationParams;
use flank::params::FlankParams;
use flank::ruled_surface::Side;
use import::Units;
use nc::flank_job::CheckKind;
pub use nc::flank_job::settings::{CutDirection, MillingSettings, PathChoice};
use nc::flank_program::milling_post;

/// A built-in surface, of the paper that the method is from (P4).
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum DemonstrationSurface {
    /// Surface A of the paper.
    #[default]
    A,
    /// Surface B of the paper.
    B,
}

/// The two guides of a demonstration surface.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GuidePair {
    /// Lower guide.
    pub lower: GuideCurve,
    /// Upper guide.
    pub upper: GuideCurve,
}

impl DemonstrationSurface {
    /// Name of the surface.
    pub fn name(self) -> &'static str {
        match self {
            Self::A => "surface A",
            Self::B => "surface B",
        }
    }

    /// Guide curves of the surface.
    ///
    /// # Errors
    /// Only if the program was built with a wrong file.
    pub fn guides(self) -> Result<GuidePair, String> {
        let text = match self {
            Self::A => include_str!("../../../../assets/flank_a.toml"),
            Self::B => include_str!("../../../../assets/flank_b.toml"),
        };
        toml::from_str(text).map_err(|e| e.message().to_owned())
    }

    /// Ratio of the paper's refined sum of deviations to the initial one.
    pub fn paper_ratio(self) -> f64 {
        match self {
            Self::A => 0.541,
            Self::B => 0.526,
        }
    }
}

/// Source of a guide curve.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum GuideSource {
    /// A CSV file with x, y, z (mm) of a point on each line; the curve is a cubic through them.
    File(PathBuf),
    /// The curve itself.
    Curve(GuideCurve),
}

/// A face of a mesh.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct MeshFlank {
    /// The mesh: STL, OBJ, glTF, GLB or STEP; empty where it is kept.
    #[serde(skip_serializing_if = "is_empty")]
    pub file: PathBuf,
    /// Unit of the mesh.
    pub units: Units,
    /// Number of the face among those that could be milled, by area, from 1.
    pub candidate: usize,
    /// Parameters of the fit of the ruled surface.
    pub fit: RuledFitParams,
    /// Whether the rest of the mesh is checked for gouges.
    pub is_own_wall: bool,
    /// The mesh itself (mm) if it is in no file, such as an electrode just designed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub kept: Option<KeptMesh>,
}

fn is_empty(path: &Path) -> bool {
    path.as_os_str().is_empty()
}

impl Default for MeshFlank {
    fn default() -> Self {
        let (file, fit) = (PathBuf::new(), RuledFitParams::default());
        Self { file, units: Units::Auto, candidate: 1, fit, is_own_wall: true, kept: None }
    }
}

impl MeshFlank {
    /// The mesh in `file`, its largest face.
    pub fn of(file: &Path) -> Self {
        Self { file: file.to_owned(), ..Self::default() }
    }

    /// Name of the mesh: that of its file, or its own.
    pub fn part(&self) -> String {
        match &self.kept {
            Some(kept) => kept.words(),
            None => self.file.file_name().map_or_else(String::new, |n| n.to_string_lossy().into_owned()),
        }
    }
}

/// Source of the surface.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum FlankSource {
    /// A built-in surface.
    Demonstration {
        /// The surface.
        surface: DemonstrationSurface,
    },
    /// Two guide curves.
    Guides {
        /// Guide that the cutter's bottom follows.
        lower: GuideSource,
        /// Upper guide.
        upper: GuideSource,
    },
    /// A face of a mesh.
    Mesh(MeshFlank),
}

impl FlankSource {
    /// Two guides from files, the lower one first.
    pub fn guides(files: [PathBuf; 2]) -> Self {
        let [lower, upper] = files.map(GuideSource::File);
        Self::Guides { lower, upper }
    }
}

impl Default for FlankSource {
    fn default() -> Self {
        Self::Demonstration { surface: DemonstrationSurface::A }
    }
}

/// Neighbouring walls that must not be cut.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WallsFile {
    /// The mesh.
    pub file: PathBuf,
    /// Unit of the mesh.
    #[serde(default)]
    pub units: Units,
}

/// A flank, the cutter, and parameters of the milling.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct FlankDocument {
    /// Source of the surface.
    pub source: FlankSource,
    /// Side of the surface that the cutter stands on.
    pub side: Side,
    /// The cutter.
    pub cutter: FlankCutter,
    /// Parameters of the path.
    pub plan: FlankParams,
    /// Path that is milled.
    pub path: PathChoice,
    /// Neighbouring walls that must not be cut.
    pub walls: Option<WallsFile>,
    /// Machine, post, clearances and motions of the milling.
    pub milling: MillingSettings,
    /// Greatest difference between the swept envelope and the static deviation at any sample (mm).
    pub envelope_tolerance_mm: f64,
    /// Greatest overcut, static or of the swept envelope (mm).
    pub overcut_tolerance_mm: f64,
    /// Greatest undercut, static or of the swept envelope (mm).
    pub undercut_tolerance_mm: f64,
    /// Overridden checks.
    pub overrides: Vec<Override>,
}

impl Default for FlankDocument {
    fn default() -> Self {
        Self {
            source: FlankSource::default(),
            side: Side::default(),
            cutter: FlankCutter { name: "cone R1 5 deg".to_owned(), ..FlankCutter::cone(1.0, 5.0, 30.0) },
            plan: FlankParams::default(),
            path: PathChoice::default(),
            walls: None,
            milling: MillingSettings::default(),
            envelope_tolerance_mm: 0.02,
            overcut_tolerance_mm: 0.1,
            undercut_tolerance_mm: 0.15,
            overrides: Vec::new(),
        }
    }
}

impl Validate for FlankDocument {
    fn validate(&self) -> Result<(), Invalid> {
        let within = |key: &str, problem: &dyn std::fmt::Display| Invalid::of(key, problem.to_string());
        fields::FIELDS.check(self)?;
        self.plan.validate().map_err(|e| of_plan(&e))?;
        let (below, flutes) = (self.plan.below_mm, self.cutter.length_mm);
        if below >= flutes {
            return Err(Invalid::new("plan.below_mm", below, "must be less than the length of the flutes"));
        }
        if flutes > LinearisationParams::LONGEST_REACH_MM {
            let most = LinearisationParams::LONGEST_REACH_MM;
            let remedy = format!("must be at most {most} mm, up to which a machine's moves are measured");
            return Err(Invalid::new("cutter.length_mm", flutes, remedy));
        }
        milling_post(&self.milling.post).map_err(|e| within("milling.post", &e))?;
        self.milling.validate(flutes).map_err(|e| within("milling", &e))?;
        let checks = CheckKind::ALL.map(CheckKind::name);
        for (i, one) in self.overrides.iter().enumerate() {
            one.validate(&checks, false).map_err(|problem| problem.within(&format!("overrides[{i}]")))?;
        }
        Ok(())
    }
}

fn of_plan(error: &FlankError) -> Invalid {
    match error {
        FlankError::Parameter { name, value, wanted } => {
            Invalid::new(format!("plan.{}", name.replace(' ', ".")), value, format!("must be {wanted}"))
        }
        other => Invalid::of("plan", other.to_string()),
    }
}

impl Params for FlankDocument {
    const KIND: &'static str = "flank";

    fn part(&self) -> String {
        let stem = |file: &Path| file.file_stem().map_or_else(String::new, |n| n.to_string_lossy().into_owned());
        match &self.source {
            FlankSource::Demonstration { surface } => surface.name().to_owned(),
            FlankSource::Guides { lower: GuideSource::File(lower), upper: GuideSource::File(upper) } => {
                format!("{} to {}", stem(lower), stem(upper))
            }
            FlankSource::Guides { .. } => "guide curves".to_owned(),
            FlankSource::Mesh(MeshFlank { kept: Some(kept), candidate, .. }) => {
                format!("{} flank {candidate}", kept.name)
            }
            FlankSource::Mesh(mesh) => format!("{} flank {}", stem(&mesh.file), mesh.candidate),
        }
    }

    /// The files of the surface are needed; walls, a machine or a post can be chosen later.
    fn needs(&self, path: &Path) -> bool {
        let is_file = |guide: &GuideSource| matches!(guide, GuideSource::File(file) if file == path);
        match &self.source {
            FlankSource::Demonstration { .. } => false,
            FlankSource::Guides { lower, upper } => is_file(lower) || is_file(upper),
            FlankSource::Mesh(mesh) => mesh.file == path,
        }
    }

    // Machines and posts are names unless they end in `.toml`.
    fn change_paths(&mut self, change: &mut dyn FnMut(&Path) -> PathBuf) {
        match &mut self.source {
            FlankSource::Demonstration { .. } => {}
            FlankSource::Guides { lower, upper } => {
                for guide in [lower, upper] {
                    if let GuideSource::File(file) = guide {
                        *file = change(file);
                    }
                }
            }
            FlankSource::Mesh(mesh) if mesh.kept.is_some() => {}
            FlankSource::Mesh(mesh) => mesh.file = change(&mesh.file),
        }
        if let Some(walls) = &mut self.walls {
            walls.file = change(&walls.file);
        }
        let mut moved = |file: &str| change(Path::new(file)).to_string_lossy().into_owned();
        let milling = &mut self.milling;
        if let Some((file, name)) = file_of_machine(&milling.machine) {
            let name = name.map_or_else(String::new, |name| format!("#{name}"));
            milling.machine = moved(file) + &name;
        }
        if milling.post.ends_with(".toml") {
            milling.post = moved(&milling.post);
        }
    }
}

impl FlankDocument {
    /// A copy of the document for another surface: without side, walls, clamping and overrides.
    pub fn of_another(&self, source: FlankSource) -> Self {
        let milling = MillingSettings { workpiece: None, ..self.milling.clone() };
        let (side, walls, overrides) = (Side::Automatic, None, Vec::new());
        Self { source, side, walls, milling, overrides, ..self.clone() }
    }
}

#[cfg(test)]
mod tests;
