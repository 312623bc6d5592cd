//! Pictures of projects of molds and flanks for `sparkpath render`.

use std::path::Path;
use std::sync::Arc;

use super::project::open;
use super::render::aspect;
use super::{RenderArguments, Session};
use crate::widgets::camera::{NamedView, standard};
use crate::workspaces::flank::document::FlankDocument;
use crate::workspaces::flank::inputs;
use crate::workspaces::flank::scene::{FlankScene, FlankShapes};
use crate::workspaces::mold::document::part_of;
use crate::workspaces::mold::document::standard::open_mold;
use crate::workspaces::mold::job::electrodes::electrodes;
use crate::workspaces::mold::job::uncut::uncut;
use crate::workspaces::mold::scene::electrodes::electrode_shapes;
use crate::workspaces::mold::scene::pictures::electrode_pictures;
use crate::workspaces::mold::scene::{MoldLook, MoldScene, RegionColours, build_mold, faces_shape, region_shapes};
use files::Params;
use files::paths::user_folder;
use nc::flank_job::{LoadedSurface, flank};
use render::camera::Camera;
use render::mesh::RenderMesh;
use render::scene::Scene;
use render::view::StandardView;

/// The view that is asked for; none of these projects has a channel or nodes.
fn view(arguments: &RenderArguments) -> anyhow::Result<Option<StandardView>> {
    for (name, is_given) in [("--node", arguments.node.is_some()), ("--swept", arguments.swept)] {
        anyhow::ensure!(!is_given, "{name}: only the project of a blisk has nodes; leave it out");
    }
    match arguments.view {
        None => Ok(None),
        Some(NamedView::Standard(view)) => Ok(Some(view)),
        Some(NamedView::Channel) => anyhow::bail!("--view channel: only the project of a blisk has channels"),
    }
}

/// A mold with what its cutters leave, or one of its electrodes where it burns, cut along X.
pub(super) fn of_mold(file: &Path, arguments: &RenderArguments, session: &Session) -> anyhow::Result<(Scene, Camera)> {
    let view = view(arguments)?;
    let message = |e: String| anyhow::anyhow!("{}: {e}", file.display());
    let asked = open_mold(file, user_folder().as_deref())?;
    let demonstrated = asked.demonstrated(&session.task).map_err(message)?;
    let imported = match (&asked.mesh, demonstrated) {
        (Some(mesh), _) => session.import(mesh, &asked.reading())?,
        (None, Some(demonstrated)) => demonstrated,
        (None, None) => return Err(message("mesh is missing; name one in the project".to_owned())),
    };
    let mut of_part = asked.of_part(&part_of(&imported));
    of_part.open(&imported.mesh, &session.task.cancel)?;
    session.note_dropped(asked.mesh.as_deref().unwrap_or(file), &asked, &of_part);
    let asked = of_part;
    let mold = Arc::new(RenderMesh::new(&imported.mesh));
    let found = uncut(&imported.mesh, &asked.uncut(), &session.task).map_err(|e| message(e.to_string()))?;
    let (mut scene, own) = match arguments.electrode {
        Some(number) => {
            let made = electrodes(&imported, &found, &asked.electrodes, &session.task);
            let set = made.map_err(|e| message(e.to_string()))?;
            // The first picture is of all of them.
            let pictures = electrode_pictures(&set, &electrode_shapes(&set), &mold, asked.opening());
            let last = pictures.len().saturating_sub(1);
            let picture = pictures
                .into_iter()
                .nth(number as usize)
                .ok_or_else(|| anyhow::anyhow!("--electrode {number}: there are pictures of electrodes 1 to {last}"))?;
            (picture.scene, Some(picture.camera))
        }
        None => {
            let shapes = region_shapes(&imported.mesh, &found.surface, found.regions.len(), asked.opening());
            let scene = build_mold(&MoldScene {
                mold: &mold,
                regions: &shapes,
                shown: &vec![true; shapes.len()],
                colours: RegionColours::ByRegion,
                deepest: found.regions.iter().fold(0.0, |most: f64, r| most.max(r.depth)),
                selected: None,
                look: MoldLook::Solid,
                invert: faces_shape(&imported.mesh, &found.stack.invert.triangles).as_ref(),
                glance: None,
                layer: None,
                theme: arguments.theme,
            });
            (scene, None)
        }
    };
    scene.theme = arguments.theme;
    let from = |view| standard(view, &scene, Camera::default(), aspect(arguments));
    let camera = view.map(from).or(own).unwrap_or_else(|| from(StandardView::Isometric));
    Ok((scene, camera))
}

/// A flank with the deviations of the path that is milled, and the cutter halfway along it.
pub(super) fn of_flank(file: &Path, arguments: &RenderArguments, session: &Session) -> anyhow::Result<(Scene, Camera)> {
    let view = view(arguments)?;
    anyhow::ensure!(arguments.electrode.is_none(), "--electrode: the project of a flank has none; leave it out");
    let document = open::<FlankDocument>(file)?;
    let input = inputs::load(document.params(), user_folder().as_deref(), &session.task)?;
    let part = match &input.surface {
        LoadedSurface::Face { mesh, .. } => Some(Arc::new(RenderMesh::new(mesh))),
        LoadedSurface::Guides { .. } => None,
    };
    let walls = input.walls.as_ref().map(|mesh| Arc::new(RenderMesh::new(mesh)));
    let name = document.params().name();
    let result = flank(&input, &session.task).map_err(|e| anyhow::anyhow!("{name}: {e}"))?;
    let shapes = FlankShapes::of(&result.surface, &result.plan);
    let path = result.path();
    let scene = FlankScene {
        surface: Some(&shapes.surface),
        shapes: Some(&shapes),
        paths: &[result.path],
        moving: false,
        poses: &[path.pose(0.5)],
        contacts: &[],
        tips: &[path.poses.iter().map(|pose| pose.tip).collect()],
        shows_axis: false,
        shows_rulings: true,
        part: part.as_ref(),
        walls: walls.as_ref(),
        place: None,
        open_side: None,
        theme: arguments.theme,
    }
    .build();
    let camera = match view {
        Some(view) => standard(view, &scene, Camera::default(), aspect(arguments)),
        None => shapes.surface.camera(&shapes.surface.shape.bounds(), Camera::default(), aspect(arguments), false),
    };
    Ok((Scene { triad: true, ..scene }, camera))
}
