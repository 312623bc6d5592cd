//! The steps of the work on a mold, pure functions of their inputs.

use std::path::Path;
use std::sync::Arc;

use crate::workspaces::mold::document::demonstration::{DEMONSTRATION, demonstration};
use crate::workspaces::mold::document::fields::FIELDS;
use crate::workspaces::mold::document::part_of;
use crate::workspaces::mold::job::compare::{Comparison, compare as compare_answers};
use crate::workspaces::mold::job::electrodes::MoldBody;
use crate::workspaces::mold::job::preview::{Preview, preview};
use crate::workspaces::mold::job::uncut::{Uncut, UncutParams, uncut};
use crate::workspaces::mold::report::uncut::UncutReport;
use crate::workspaces::mold::scene::{RegionShape, faces_shape, region_shapes};
use files::PartFile;
use geometry::circle::Circle;
use geometry::mesh::Mesh;
use import::{CadFaces, ImportOptions, ImportReport, Imported, Reading, import_file};
use mold::datum::rims;
use mold::invert::InvertFaces;
use mold::unseen::{OpeningProposal, Unseen, undercuts};
use mold::warning::MoldWarning;
use render::mesh::RenderMesh;
use task::{Cancel, Cancelled, StageClock, StageTime, Task};

/// A mold as loaded.
#[derive(Debug)]
pub struct LoadedMold {
    /// Name of the mold.
    pub name: String,
    /// Mesh of the mold (mm, in the axes of its file).
    pub mesh: Arc<Mesh>,
    /// Solids beside the mold that electrodes keep clear of (mm, in the axes of its file); none if there are no such.
    pub obstacles: Option<Mesh>,
    /// Shape of the mold, and of the obstacles beside it, for the screen.
    pub shape: Arc<RenderMesh>,
    /// Report of the import.
    pub report: ImportReport,
    /// Faces of the CAD program, of a file that has them.
    pub faces: Option<CadFaces>,
    /// Volume (mm^3).
    pub volume: f64,
    /// File of the mold as it was read; without a path for the demonstration mold.
    pub file: PartFile,
    /// Digest of the part: digest of the file and the unit that it was read in.
    pub sha256: String,
}

impl LoadedMold {
    /// Triangles and faces.
    pub fn body(&self) -> MoldBody<'_> {
        MoldBody { mesh: &self.mesh, faces: self.faces.as_ref(), obstacles: self.obstacles.as_ref() }
    }

    /// The import in a sentence.
    pub fn sentence(&self) -> String {
        format!("{}: {} triangles", self.name, self.mesh.triangles.len())
    }
}

/// Uncut regions with everything shown of them.
#[derive(Debug)]
pub struct FoundUncut {
    /// Uncut regions.
    pub uncut: Uncut,
    /// Report on the uncut regions.
    pub report: UncutReport,
    /// The regions for the screen.
    pub shapes: Vec<RegionShape>,
    /// Undercut faces, for the screen.
    pub invert: Option<Arc<RenderMesh>>,
    /// Greatest height of rest material (mm).
    pub deepest: f64,
    /// Whether this run of the program has computed the result, rather than read it from a file.
    pub is_proven: bool,
    /// Times of the stages; none of a result that was read from a file.
    pub times: Vec<StageTime>,
}

impl FoundUncut {
    /// The result in a sentence.
    pub fn sentence(&self) -> String {
        let kept = if self.is_proven { "" } else { " Kept from an earlier session." };
        format!("{}{kept}", self.report.sentence.replace("mm3", "mm³").replace("mm2", "mm²"))
    }
}

/// Reads a mold from its file.
///
/// # Errors
/// One line naming file, place and remedy.
pub fn load(path: &Path, reading: &Reading, task: &Task) -> Result<LoadedMold, String> {
    let options = ImportOptions { reading: reading.clone(), ..Default::default() };
    let imported = import_file(path, &options, task).map_err(|e| e.to_string())?;
    let name = path.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
    loaded(name, path, imported, task)
}

/// The demonstration mold.
///
/// # Errors
/// Those of [`demonstration`].
pub(super) fn load_demonstration(task: &Task) -> Result<LoadedMold, String> {
    loaded(DEMONSTRATION.to_owned(), Path::new(""), demonstration(task)?, task)
}

fn loaded(name: String, path: &Path, imported: Imported, task: &Task) -> Result<LoadedMold, String> {
    let (sha256, volume) = (part_of(&imported), imported.mesh.volume());
    let file = PartFile { path: path.to_owned(), sha256: imported.sha256 };
    let mesh = Arc::new(imported.mesh);
    let shape = Arc::new(RenderMesh::beside(&mesh, imported.obstacles.as_ref()));
    task.check().map_err(|e| e.to_string())?;
    let (report, faces, obstacles) = (imported.report, imported.faces, imported.obstacles);
    Ok(LoadedMold { name, file, mesh, obstacles, shape, report, faces, volume, sha256 })
}

/// What is looked for on a mold that is shown already.
#[derive(Debug)]
pub struct Survey {
    /// Opening direction that is proposed.
    pub proposal: OpeningProposal,
    /// Rims of holes and bosses, in the axes of the file (mm).
    pub rims: Vec<Circle>,
}

/// Looks for the opening direction and the rims of a mold.
///
/// # Errors
/// If it is cancelled.
pub(super) fn survey(mold: &LoadedMold, cancel: &Cancel) -> Result<Survey, Cancelled> {
    Ok(Survey { proposal: OpeningProposal::of(&mold.mesh, cancel)?, rims: rims(&mold.mesh, cancel)? })
}

/// Searches the uncut regions.
///
/// # Errors
/// One line for the user.
pub(super) fn find(mold: &LoadedMold, params: &UncutParams, task: &Task) -> Result<FoundUncut, String> {
    let clock = StageClock::default();
    let found = uncut(&mold.mesh, params, &clock.timed(task)).map_err(|e| FIELDS.labelled(&e))?;
    let times = clock.times();
    let shown = shown(mold, found, true);
    task.check().map_err(|e| e.to_string())?;
    Ok(FoundUncut { times, ..shown })
}

/// The uncut regions with everything shown of them.
pub(super) fn shown(mold: &LoadedMold, found: Uncut, is_proven: bool) -> FoundUncut {
    let shapes = region_shapes(&mold.mesh, &found.surface, found.regions.len(), found.params.opening);
    let invert = faces_shape(&mold.mesh, &found.stack.invert.triangles);
    let deepest = found.regions.iter().fold(0.0, |most: f64, r| most.max(r.depth));
    let report = UncutReport::of(&found, mold.faces.as_ref());
    FoundUncut { report, uncut: found, shapes, invert, deepest, is_proven, times: Vec::new() }
}

/// Searches the uncut regions of other cutters, and compares them with the result.
///
/// # Errors
/// One line for the user.
pub(super) fn compare(
    mold: &LoadedMold,
    found: &FoundUncut,
    params: &UncutParams,
    task: &Task,
) -> Result<(FoundUncut, Comparison), String> {
    let other = find(mold, params, task)?;
    let comparison = compare_answers(&mold.mesh, &found.uncut, &other.uncut, task);
    Ok((other, comparison.map_err(|e| FIELDS.labelled(&e))?))
}

/// A preview of uncut regions.
#[derive(Debug)]
pub struct Glance {
    /// Figures of the uncut regions.
    pub preview: Preview,
    /// Shape of the uncut regions on the mold, for the screen.
    pub shape: Arc<RenderMesh>,
    /// Undercut faces, for the screen.
    pub invert: Option<Arc<RenderMesh>>,
    /// Warning of a cavity that the opening direction hides.
    pub hidden: Option<MoldWarning>,
}

impl Glance {
    /// The preview in a sentence, and what is hidden.
    pub fn sentence(&self) -> String {
        let hidden = self.hidden.as_ref().map_or_else(String::new, |warning| format!(" Warning: {warning}."));
        self.preview.sentence() + &hidden.replace("mm^2", "mm²")
    }
}

/// Previews the uncut regions.
///
/// # Errors
/// One line if there is no preview.
pub(super) fn glance(mold: &LoadedMold, params: &UncutParams, cancel: &Cancel) -> Result<Glance, String> {
    let preview = preview(&mold.mesh, params, cancel).map_err(|e| FIELDS.labelled(&e))?;
    let cells = preview.regions.iter().flat_map(|r| &r.cells);
    let surface: Vec<_> = cells.flat_map(|cell| cell.pieces(0)).collect();
    let shape = region_shapes(&mold.mesh, &surface, 1, params.opening).swap_remove(0).shape;
    let upright = params.opening.upright_mesh(&mold.mesh);
    let invert = undercuts(InvertFaces::of(&upright), &upright, params.opening, cancel).map_err(|e| e.to_string())?;
    let invert = faces_shape(&mold.mesh, &invert.triangles);
    let hidden = Unseen::warning(&upright, cancel).map_err(|e| e.to_string())?;
    Ok(Glance { preview, shape, invert, hidden })
}
