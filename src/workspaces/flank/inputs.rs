//! Reads the files of a [`FlankDocument`] for [`nc::flank_job`].

use std::path::Path;
use std::sync::Arc;

use crate::workspaces::flank::document::kept_mesh::KeptMesh;
use crate::workspaces::flank::document::milling_machine_file::milling_machine;
use crate::workspaces::flank::document::{FlankDocument, FlankSource, GuideSource, MeshFlank, WallsFile};
use files::{Params, Validate};
use flank::fit_ruled::candidates_among;
use flank::guide::GuideCurve;
use flank::machine::milling_machine::MillingMachine;
use flank::ruled_surface::Side;
use geometry::mesh::Mesh;
use geometry::segmentation::SegmentationSettings;
use import::{ImportOptions, Imported, Undeclared, Unit, Units, import_bytes, import_file};
use nc::flank_job::{FlankInput, LoadedSurface};
use nc::flank_program::{FlankNc, milling_post};
use task::Task;

/// The largest file of points (bytes).
const LARGEST_FILE: u64 = 16 << 20;

/// A value from a file, with doubts about it.
#[derive(Debug, Clone)]
pub struct FromFile<T> {
    /// The value that was read.
    pub value: T,
    /// Doubts that the reader must know, in words.
    pub doubts: Vec<String>,
}

impl<T> FromFile<T> {
    /// A value without doubts.
    pub fn certain(value: T) -> Self {
        Self { value, doubts: Vec::new() }
    }
}

/// Reason why a flank's files cannot be used: one line with the file and the remedy, or cancelled.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct FlankLoadError(pub String);

/// Reads everything that `document` names. `user_folder` holds the user's own machines.
///
/// # Errors
/// [`FlankLoadError`].
pub fn load(document: &FlankDocument, user_folder: Option<&Path>, task: &Task) -> Result<FlankInput, FlankLoadError> {
    document.validate().map_err(|e| FlankLoadError(e.to_string()))?;
    // What is quick to find wrong comes first.
    let machine = load_machine(document, user_folder)?;
    let in_unit = walls_unit(document);
    let walls = document.walls.as_ref().map(|walls| load_walls(walls, in_unit, task)).transpose()?;
    let surface = load_surface(&document.source, task)?;
    Ok(input(document, surface, walls, machine))
}

/// Input of the job from a document and what was read for it.
pub fn input(
    document: &FlankDocument,
    surface: FromFile<LoadedSurface>,
    walls: Option<FromFile<Arc<Mesh>>>,
    machine: Option<MillingMachine>,
) -> FlankInput {
    let (walls, of_walls) = walls.map_or((None, Vec::new()), |walls| (Some(walls.value), walls.doubts));
    // The paper's surfaces are milled from the side that their figures are of.
    let is_demonstration = matches!(document.source, FlankSource::Demonstration { .. });
    let side = if is_demonstration && document.side == Side::Automatic { Side::Positive } else { document.side };
    FlankInput {
        name: document.name(),
        surface: surface.value,
        doubts: [surface.doubts, of_walls].concat(),
        side,
        cutter: document.cutter.clone(),
        params: document.plan.clone(),
        path: document.path,
        walls,
        machine,
        milling: document.milling.clone(),
        envelope_tolerance_mm: document.envelope_tolerance_mm,
        overcut_tolerance_mm: document.overcut_tolerance_mm,
        undercut_tolerance_mm: document.undercut_tolerance_mm,
        overrides: document.overrides.clone(),
        is_preview: false,
    }
}

/// The machine of `document`, if it names one.
///
/// # Errors
/// [`FlankLoadError`].
pub fn load_machine(
    document: &FlankDocument,
    user_folder: Option<&Path>,
) -> Result<Option<MillingMachine>, FlankLoadError> {
    let name = document.milling.machine.as_str();
    if name.is_empty() {
        return Ok(None);
    }
    let milling = &document.milling;
    let mut machine = milling_machine(name, user_folder).map_err(|e| FlankLoadError(e.to_string()))?;
    machine.workpiece = milling.workpiece.clone().unwrap_or(machine.workpiece);
    machine.gauge_length_mm = milling.gauge_length_mm.unwrap_or(machine.gauge_length_mm);
    let kinematics = machine.kinematics().map_err(|e| FlankLoadError(e.to_string()))?;
    // What the post cannot say is found before anything is computed.
    let post = milling_post(&milling.post).map_err(|e| FlankLoadError(e.to_string()))?;
    FlankNc::check_words(&kinematics, &post, &milling.program).map_err(|e| FlankLoadError(e.to_string()))?;
    Ok(Some(machine))
}

/// Unit of walls whose file states none: the unit given for the part, else mm, as for guides. The unit is never
/// guessed: in a wrong unit the walls would be far away, and no gouge would be found.
pub fn walls_unit(document: &FlankDocument) -> Unit {
    match &document.source {
        FlankSource::Mesh(mesh) if mesh.kept.is_none() => mesh.units.given().unwrap_or(Unit::Mm),
        _ => Unit::Mm,
    }
}

/// Reads the walls, in `unit` where neither their file nor the user states one.
///
/// # Errors
/// [`FlankLoadError`].
pub fn load_walls(walls: &WallsFile, unit: Unit, task: &Task) -> Result<FromFile<Arc<Mesh>>, FlankLoadError> {
    let walls = import(&walls.file, (walls.units, Undeclared::Take(unit)), task)?;
    Ok(FromFile { value: Arc::new(walls.value.mesh), doubts: walls.doubts })
}

/// Reads the surface. For a mesh every face that could be milled is fitted, which takes longest. A mesh without a unit
/// whose size does not suit mm is refused.
///
/// # Errors
/// [`FlankLoadError`].
pub fn load_surface(source: &FlankSource, task: &Task) -> Result<FromFile<LoadedSurface>, FlankLoadError> {
    match source {
        FlankSource::Demonstration { surface } => {
            let guides = surface.guides().map_err(|e| FlankLoadError(format!("{}: {e}", surface.name())))?;
            Ok(FromFile::certain(LoadedSurface::Guides { lower: guides.lower, upper: guides.upper }))
        }
        FlankSource::Guides { lower, upper } => {
            let (lower, upper) = (load_guide(lower)?, load_guide(upper)?);
            Ok(FromFile::certain(LoadedSurface::Guides { lower, upper }))
        }
        FlankSource::Mesh(flank) => load_mesh(flank, task),
    }
}

/// Reads a guide curve.
///
/// # Errors
/// [`FlankLoadError`].
pub fn load_guide(guide: &GuideSource) -> Result<GuideCurve, FlankLoadError> {
    let file = match guide {
        GuideSource::Curve(curve) => return Ok(curve.clone()),
        GuideSource::File(file) => file,
    };
    let wrong = |text: String| FlankLoadError(format!("{}: {text}", file.display()));
    let unreadable = |e: std::io::Error| wrong(format!("cannot be read ({e}); check the path"));
    let size = std::fs::metadata(file).map_err(unreadable)?.len();
    if size > LARGEST_FILE {
        return Err(wrong(format!("it has {size} bytes; a guide curve has at most {LARGEST_FILE}")));
    }
    let text = std::fs::read_to_string(file).map_err(unreadable)?;
    GuideCurve::from_csv(&text).map_err(|e| wrong(e.to_string()))
}

fn load_mesh(flank: &MeshFlank, task: &Task) -> Result<FromFile<LoadedSurface>, FlankLoadError> {
    let (FromFile { value: part, doubts }, name) = match &flank.kept {
        Some(kept) => (FromFile::certain(import_kept(kept, task)?), kept.words()),
        None => {
            let unit = (flank.units, Undeclared::RefuseOthers);
            (import(&flank.file, unit, task)?, flank.file.display().to_string())
        }
    };
    let faces = part.segmentation(&SegmentationSettings::default());
    let candidates = candidates_among(&part.mesh, &faces, &flank.fit, task);
    let mesh = Arc::new(part.mesh);
    let candidates = candidates.map_err(|e| FlankLoadError(format!("{name}: {e}")))?;
    let MeshFlank { candidate: number, is_own_wall, .. } = *flank;
    let surface = LoadedSurface::Face { mesh, candidates: Arc::new(candidates), number, is_own_wall };
    Ok(FromFile { value: surface, doubts })
}

fn import(
    file: &Path,
    (units, undeclared): (Units, Undeclared),
    task: &Task,
) -> Result<FromFile<Imported>, FlankLoadError> {
    let options = ImportOptions { reading: units.into(), undeclared, ..ImportOptions::default() };
    let imported = import_file(file, &options, task).map_err(|e| FlankLoadError(e.to_string()))?;
    let name = file.file_name().unwrap_or(file.as_os_str()).to_string_lossy();
    let doubts = imported.report.unit_doubt().map(|doubt| format!("{name}: {doubt}")).into_iter().collect();
    Ok(FromFile { value: imported, doubts })
}

/// Reads a mesh that the document itself holds, with the same checks as a file.
fn import_kept(kept: &KeptMesh, task: &Task) -> Result<Imported, FlankLoadError> {
    let options = ImportOptions { reading: Units::Mm.into(), ..ImportOptions::default() };
    let name = format!("{}.obj", kept.name);
    let imported = import_bytes(&name, kept.obj.as_bytes(), &options, task);
    imported.map_err(|e| FlankLoadError(e.to_string()))
}
