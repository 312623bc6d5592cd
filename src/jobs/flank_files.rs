//! Reads what a [`FlankDocument`] names, for [`super::flank`]. This module reads files.

use std::path::Path;
use std::sync::Arc;

use super::flank::{FlankInput, LoadedSurface};
use crate::export::flank_nc::{FlankNc, milling_post};
use crate::flank::fit_ruled::flank_candidates;
use crate::flank::guide::GuideCurve;
use crate::flank::machine::milling_machine::MillingMachine;
use crate::flank::ruled_surface::Side;
use crate::geometry::mesh::Mesh;
use crate::mesh_io::{ImportOptions, Units, import_bytes, import_file};
use crate::progress::{Cancel, Progress};
use crate::project::flank_params::{FlankDocument, FlankSource, GuideSource, MeshFlank, WallsFile};
use crate::project::kept_mesh::KeptMesh;
use crate::project::milling_machine_file::milling_machine;

/// The largest file of points (bytes).
const LARGEST_FILE: u64 = 16 << 20;

/// Why a flank's files are of no use: one line with the file and what to do, or cancelled.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct FlankLoadError(pub String);

/// All that `document` names, read. `user_folder` is where a user's own machines are.
///
/// # Errors
/// [`FlankLoadError`].
pub fn load(
    document: &FlankDocument,
    user_folder: Option<&Path>,
    progress: &Progress,
    cancel: &Cancel,
) -> Result<FlankInput, FlankLoadError> {
    document.validate().map_err(FlankLoadError)?;
    // What is quick to find wrong comes first.
    let machine = load_machine(document, user_folder)?;
    let walls = document.walls.as_ref().map(|walls| load_walls(walls, progress, cancel)).transpose()?;
    let surface = load_surface(&document.source, progress, cancel)?;
    Ok(input(document, surface, walls, machine))
}

/// The job's input from a document and what was read for it.
pub fn input(
    document: &FlankDocument,
    surface: LoadedSurface,
    walls: Option<Arc<Mesh>>,
    machine: Option<MillingMachine>,
) -> FlankInput {
    // The paper's surfaces are milled from the side that their figures are of.
    let is_demonstration = matches!(document.source, FlankSource::Demonstration { .. });
    let side = if is_demonstration && document.side == Side::Automatic { Side::Positive } else { document.side };
    FlankInput {
        name: document.name(),
        surface,
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
        is_quick_look: false,
    }
}

/// The machine that `document` names; none if it names none.
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

/// The walls that must not be cut.
///
/// # Errors
/// [`FlankLoadError`].
pub fn load_walls(walls: &WallsFile, progress: &Progress, cancel: &Cancel) -> Result<Arc<Mesh>, FlankLoadError> {
    import(&walls.file, walls.units, progress, cancel)
}

/// What the surface is made of. Of a mesh every face that could be milled is fitted: this is the long part.
///
/// # Errors
/// [`FlankLoadError`].
pub fn load_surface(
    source: &FlankSource,
    progress: &Progress,
    cancel: &Cancel,
) -> Result<LoadedSurface, FlankLoadError> {
    match source {
        FlankSource::Demonstration { surface } => {
            let guides = surface.guides().map_err(|e| FlankLoadError(format!("{}: {e}", surface.name())))?;
            Ok(LoadedSurface::Guides { lower: guides.lower, upper: guides.upper })
        }
        FlankSource::Guides { lower, upper } => {
            Ok(LoadedSurface::Guides { lower: load_guide(lower)?, upper: load_guide(upper)? })
        }
        FlankSource::Mesh(flank) => load_mesh(flank, progress, cancel),
    }
}

/// A guide curve.
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

fn load_mesh(flank: &MeshFlank, progress: &Progress, cancel: &Cancel) -> Result<LoadedSurface, FlankLoadError> {
    let (mesh, name) = match &flank.kept {
        Some(kept) => (import_kept(kept, progress, cancel)?, kept.words()),
        None => (import(&flank.file, flank.units, progress, cancel)?, flank.file.display().to_string()),
    };
    progress.report("faces that could be milled", 0.0, "");
    let candidates = flank_candidates(&mesh, &flank.fit, cancel);
    let candidates = candidates.map_err(|e| FlankLoadError(format!("{name}: {e}")))?;
    progress.report("faces that could be milled", 1.0, "");
    let MeshFlank { candidate: number, is_own_wall, .. } = *flank;
    Ok(LoadedSurface::Face { mesh, candidates: Arc::new(candidates), number, is_own_wall })
}

fn import(file: &Path, units: Units, progress: &Progress, cancel: &Cancel) -> Result<Arc<Mesh>, FlankLoadError> {
    let options = ImportOptions { units, ..ImportOptions::default() };
    let imported = import_file(file, &options, progress, cancel).map_err(|e| FlankLoadError(e.to_string()))?;
    Ok(Arc::new(imported.mesh))
}

/// A mesh that a document holds, with the care that is taken of any file: it may have been read from one.
fn import_kept(kept: &KeptMesh, progress: &Progress, cancel: &Cancel) -> Result<Arc<Mesh>, FlankLoadError> {
    let options = ImportOptions { units: Units::Mm, ..ImportOptions::default() };
    let name = format!("{}.obj", kept.name);
    let imported = import_bytes(&name, kept.obj.as_bytes(), &options, progress, cancel);
    Ok(Arc::new(imported.map_err(|e| FlankLoadError(e.to_string()))?.mesh))
}
