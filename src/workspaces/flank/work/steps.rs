//! The steps of the work on a flank, pure functions of their inputs.

use std::sync::Arc;

use glam::DVec3;

use super::curves::{MachineCurves, Profile};
use super::stamps::Stamp;
use crate::workspaces::flank::comparison::{self, Row, Variant};
use crate::workspaces::flank::document::fields::FIELDS;
use crate::workspaces::flank::document::{FlankDocument, FlankSource, PathChoice, WallsFile};
use crate::workspaces::flank::inputs;
use crate::workspaces::flank::inputs::{FromFile, input, load_machine, load_surface};
use crate::workspaces::flank::scene::{FlankShapes, FlankSurface};
use files::PartFile;
use files::paths::user_folder;
use flank::FlankError;
use flank::params::FlankParams;
use flank::ruled_surface::Side;
use geometry::mesh::Mesh;
use import::Unit;
use nc::flank_job::{FlankInput, FlankJobError, FlankResult, LoadedSurface, flank, surface};
use render::mesh::RenderMesh;
use task::{Cancel, Task};

/// Grid of a preview, and its greatest number of iterations.
const SKETCH_GRID: [usize; 2] = [34, 18];
const SKETCH_ROUNDS: usize = 8;

/// The surface of a flank, as loaded.
#[derive(Debug)]
pub struct LoadedFlank {
    /// The surface.
    pub surface: LoadedSurface,
    /// The part with the face, for the screen.
    pub part: Option<Arc<RenderMesh>>,
    /// The surface's files as they were read.
    pub files: Vec<PartFile>,
    /// Stamps of the surface's files as they were read.
    pub(super) stamps: Vec<Stamp>,
    /// Doubts about its file, in words.
    pub doubts: Vec<String>,
}

/// A sentence on a file, with the doubts about it.
fn with_doubts(text: String, doubts: &[String]) -> String {
    std::iter::once(text).chain(doubts.iter().cloned()).collect::<Vec<_>>().join("; ")
}

impl LoadedFlank {
    pub(super) fn sentence(&self) -> String {
        let text = match &self.surface {
            LoadedSurface::Guides { .. } => "two guide curves".to_owned(),
            LoadedSurface::Face { candidates, .. } => {
                let ruled = candidates.iter().filter(|c| c.is_ruled()).count();
                format!("{} faces could be milled, {ruled} of them are ruled within the tolerance", candidates.len())
            }
        };
        with_doubts(text, &self.doubts)
    }
}

/// Walls, as loaded.
#[derive(Debug)]
pub struct LoadedWalls {
    /// Mesh of the walls.
    pub mesh: Arc<Mesh>,
    /// Shape of the walls for the screen.
    pub shape: Arc<RenderMesh>,
    /// The walls' file as it was read.
    pub file: Option<PartFile>,
    /// Stamp of the walls' file as it was read.
    pub(super) stamp: Stamp,
    /// Doubts about their file, in words.
    pub doubts: Vec<String>,
}

impl LoadedWalls {
    pub(super) fn sentence(&self) -> String {
        with_doubts(format!("{} triangles", self.mesh.triangles.len()), &self.doubts)
    }
}

/// A planned flank, with its shapes and curves.
#[derive(Debug)]
pub struct Planned {
    /// The planned flank.
    pub result: FlankResult,
    /// Shapes of the flank for the screen.
    pub shapes: FlankShapes,
    /// Deviations along the guides, for each path.
    pub profiles: [Profile; 3],
    /// The axes of the machine, if there is a path of it.
    pub machine: Option<MachineCurves>,
}

impl Planned {
    fn of(result: FlankResult) -> Self {
        let shapes = FlankShapes::of(&result.surface, &result.plan);
        let plan = &result.plan;
        let profiles = [&plan.initial, &plan.chosen, &plan.refined].map(|path| Profile::of(&path.deviation));
        Self { machine: MachineCurves::of(&result), shapes, profiles, result }
    }

    /// The result in a sentence.
    pub fn sentence(&self) -> String {
        let plan = &self.result.plan;
        let sums = PathChoice::ALL.map(|path| nc::flank_job::path_of(plan, path).deviation.sum);
        let blocked = self.result.checks.iter().filter(|c| !c.holds).count();
        let checks = match blocked {
            0 => "every check holds".to_owned(),
            1 => "1 check fails".to_owned(),
            n => format!("{n} checks fail"),
        };
        format!(
            "total absolute deviation: initial {:.3} mm, chosen {:.3} mm (rank {}), refined {:.3} mm ({}); {checks}",
            sums[0],
            sums[1],
            plan.ranks.best,
            sums[2],
            plan.ratio_words(sums[2])
        )
    }
}

/// A preview of a flank.
#[derive(Debug)]
pub struct Sketch {
    /// The surface, if there is one.
    pub surface: Option<FlankSurface>,
    /// A plan on a coarse grid, or the reason why there is none.
    pub planned: Result<Arc<Planned>, String>,
    /// A place of the surface with the unit vector to its positive side, where the user must choose the side of the
    /// cutter.
    pub open_side: Option<[DVec3; 2]>,
}

/// Reads the surface of `source`.
///
/// # Errors
/// One line naming file, place and remedy.
pub(super) fn load(source: &FlankSource, task: &Task) -> Result<LoadedFlank, String> {
    // What is written while it is read counts as changed.
    let stamps = Stamp::of_source(source);
    let FromFile { value: surface, doubts } = load_surface(source, task).map_err(|e| e.to_string())?;
    let part = match &surface {
        LoadedSurface::Guides { .. } => None,
        LoadedSurface::Face { mesh, .. } => Some(Arc::new(RenderMesh::new(mesh))),
    };
    let files = stamps.iter().filter_map(Stamp::part_file).collect();
    Ok(LoadedFlank { surface, part, files, doubts, stamps })
}

/// Reads walls.
///
/// # Errors
/// Every error of [`load`].
pub(super) fn load_walls(walls: &WallsFile, unit: Unit, task: &Task) -> Result<LoadedWalls, String> {
    let stamp = Stamp::of(&walls.file);
    let found = inputs::load_walls(walls, unit, task).map_err(|e| e.to_string())?;
    let FromFile { value: mesh, doubts } = found;
    let shape = Arc::new(RenderMesh::new(&mesh));
    Ok(LoadedWalls { mesh, shape, doubts, file: stamp.part_file(), stamp })
}

/// Plans.
///
/// # Errors
/// One line for the user.
pub(super) fn plan(
    document: &FlankDocument,
    surface: FromFile<LoadedSurface>,
    walls: Option<FromFile<Arc<Mesh>>>,
    task: &Task,
) -> Result<Planned, String> {
    let machine = load_machine(document, user_folder().as_deref()).map_err(|e| e.to_string())?;
    let result = flank(&input(document, surface, walls, machine), task).map_err(|e| FIELDS.labelled(&e))?;
    task.check().map_err(|e| e.to_string())?;
    Ok(Planned::of(result))
}

/// Plans with each of `variants`.
///
/// # Errors
/// One line for the user.
pub(super) fn compare(
    document: &FlankDocument,
    surface: FromFile<LoadedSurface>,
    walls: Option<FromFile<Arc<Mesh>>>,
    (variants, task): (&[Variant], &Task),
) -> Result<Vec<Row>, String> {
    let machine = load_machine(document, user_folder().as_deref()).map_err(|e| e.to_string())?;
    comparison::compare(&input(document, surface, walls, machine), variants, task).map_err(|e| e.to_string())
}

/// Computes a preview: on a coarse grid, with few iterations, without walls and machine.
pub(super) fn sketch(document: &FlankDocument, loaded: LoadedSurface, cancel: &Cancel) -> Sketch {
    let least =
        FlankParams { grid: SKETCH_GRID, rounds: document.plan.rounds.min(SKETCH_ROUNDS), ..document.plan.clone() };
    let [nu, nv] = document.plan.grid;
    let grid = [SKETCH_GRID[0].min(nu), SKETCH_GRID[1].min(nv)];
    let asked = FlankDocument { plan: FlankParams { grid, ..least }, ..document.clone() };
    let mut coarse: FlankInput = input(&asked, FromFile::certain(loaded), None, None);
    coarse.is_preview = true;
    if let LoadedSurface::Face { is_own_wall, .. } = &mut coarse.surface {
        *is_own_wall = false;
    }
    let made = surface(&coarse);
    let open_side = match &made {
        Err(FlankJobError::Flank(FlankError::SideOpen { point, normal })) => Some([*point, *normal]),
        _ => None,
    };
    // The surface itself does not depend on its side.
    let of_a_side = open_side.and_then(|_| surface(&FlankInput { side: Side::Positive, ..coarse.clone() }).ok());
    let shown = made.as_ref().ok().or(of_a_side.as_ref()).map(|(surface, _)| FlankSurface::bare(surface));
    let planned = made.map_err(|e| FIELDS.labelled(&e)).and_then(|_| {
        flank(&coarse, &Task::silent(cancel))
            .map(|result| Arc::new(Planned::of(result)))
            .map_err(|e| FIELDS.labelled(&e))
    });
    Sketch { surface: shown, planned, open_side }
}
