//! `sparkpath render`: a picture without a window.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::project::ProjectArguments;
use super::{Answer, RenderArguments, Session, render_project};
use crate::widgets::camera::{NamedView, into_channel, standard};
use crate::widgets::theme::mesh_colour;
use crate::workspaces::blisk::document::job_file::PlanJob;
use crate::workspaces::blisk::job::plan::run_prepared;
use crate::workspaces::blisk::job::planned::inputs_of;
use crate::workspaces::blisk::job::stages;
use crate::workspaces::blisk::job::stages::{FoundChannel, Part};
use crate::workspaces::blisk::scene::sweep::{FINE, swept_shape};
use crate::workspaces::blisk::scene::track::Track;
use crate::workspaces::blisk::scene::{Layer, Layers, SceneInputs, build};
use crate::workspaces::context::is_project;
use files::{kind_of, write_bytes};
use render::camera::Camera;
use render::colour::Theme;
use render::mesh::RenderMesh;
use render::offscreen::Offscreen;
use render::scene::{Grid, Object, ObjectId, Scene};
use render::view::StandardView;
use wheel::electrode::Electrode;

/// Fewest and most pixels along a side.
const SIDES: [u32; 2] = [16, 8192];
/// Most pixels of a picture: what a driver needs for them stays below about 2 GB.
const MOST_PIXELS: u64 = 34_000_000;
/// The argument `WxH`.
pub(super) fn size(text: &str) -> Result<[u32; 2], String> {
    let [least, most] = SIDES;
    let wrong = || format!("expected width x height in pixels, as in 1400x900, each {least} to {most}");
    let (width, height) = text.split_once(['x', 'X']).ok_or_else(wrong)?;
    let side = |text: &str| text.parse::<u32>().ok().filter(|s| (least..=most).contains(s)).ok_or_else(wrong);
    let size = [side(width)?, side(height)?];
    if u64::from(size[0]) * u64::from(size[1]) > MOST_PIXELS {
        return Err(format!("a picture has at most {} million pixels", MOST_PIXELS / 1_000_000));
    }
    Ok(size)
}

/// The argument that names a view.
pub(super) fn view(text: &str) -> Result<NamedView, String> {
    NamedView::from_name(text).ok_or_else(|| format!("expected one of {}", NamedView::names().join(", ")))
}

/// The argument that names the colours of the surroundings.
pub(super) fn theme(text: &str) -> Result<Theme, String> {
    match text {
        "dark" => Ok(Theme::DARK),
        "light" => Ok(Theme::LIGHT),
        _ => Err("expected dark or light".to_owned()),
    }
}

/// Draws the picture of `arguments` and writes it.
pub(super) fn render(arguments: &RenderArguments, session: &Session) -> anyhow::Result<Answer> {
    // What would stop the picture should be found out before the work.
    require_writable(&arguments.png)?;
    let mut offscreen = Offscreen::new()?;
    let project = arguments.files.iter().find(|file| is_project(file));
    let (scene, camera) = match (&arguments.files[..], project) {
        ([project], Some(_)) => match kind_of(project).as_deref() {
            Ok("mold") => render_project::of_mold(project, arguments, session)?,
            Ok("flank") => render_project::of_flank(project, arguments, session)?,
            _ => of_project(project, arguments, session)?,
        },
        (_, Some(project)) => anyhow::bail!("{}: a project is drawn by itself; give it alone", project.display()),
        (meshes, None) => of_meshes(meshes, arguments, session)?,
    };
    session.task.check()?;
    let png = offscreen.png(&scene, &camera, arguments.size, &session.task.cancel)?;
    session.task.check()?;
    write_bytes(&arguments.png, &png)?;
    super::terminal::finish();
    let ([width, height], adapter) = (arguments.size, offscreen.adapter());
    let file = arguments.png.display();
    if session.json {
        let (name, driver) = (&adapter.name, &adapter.driver);
        let said = serde_json::json!({ "png": file.to_string(), "width": width, "height": height, "adapter": name, "driver": driver });
        say!("{said}");
    } else {
        say!("{file}: {width} x {height} pixels, drawn by {}", adapter.name);
    }
    Ok(Answer::Yes)
}

fn require_writable(png: &Path) -> anyhow::Result<()> {
    anyhow::ensure!(!png.is_dir(), "{}: is a folder; give the name of a file with --png", png.display());
    let is_png = png.extension().is_none_or(|e| e.eq_ignore_ascii_case("png"));
    anyhow::ensure!(is_png, "--png {}: pictures are written as PNG; give a name that ends with .png", png.display());
    let folder = png.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let tried = tempfile::tempfile_in(folder);
    tried
        .map(drop)
        .map_err(|e| anyhow::anyhow!("{}: cannot be written ({e}); give another file with --png", png.display()))
}

pub(super) fn aspect(arguments: &RenderArguments) -> f64 {
    f64::from(arguments.size[0]) / f64::from(arguments.size[1])
}

/// The meshes in their own coordinates, each in a colour of its own.
fn of_meshes(meshes: &[PathBuf], arguments: &RenderArguments, session: &Session) -> anyhow::Result<(Scene, Camera)> {
    let of_a_plan = [
        ("--node", arguments.node.is_some()),
        ("--electrode", arguments.electrode.is_some()),
        ("--swept", arguments.swept),
        ("--set", !arguments.settings.is_empty()),
    ];
    if let Some((name, _)) = of_a_plan.iter().find(|(_, given)| *given) {
        anyhow::bail!("{name}: only a project has electrodes and nodes; give a .sparkpath file");
    }
    let view = match arguments.view {
        None => StandardView::Isometric,
        Some(NamedView::Standard(view)) => view,
        Some(NamedView::Channel) => {
            anyhow::bail!("--view channel: channels belong to a project; give a .sparkpath file")
        }
    };
    let mut scene = Scene::new(arguments.theme);
    for (i, path) in meshes.iter().enumerate() {
        let imported = session.import(path, &arguments.units.into())?;
        let shape = Arc::new(RenderMesh::for_pictures(&imported.mesh));
        scene.objects.push(Object::new(ObjectId(i as u32), shape, mesh_colour(i)));
    }
    scene.grid = Grid::below(&scene.bounds());
    let camera = standard(view, &scene, Camera::default(), aspect(arguments));
    Ok((scene, camera))
}

/// What is shown of a project.
struct Shown {
    electrode: Electrode,
    /// Where it stands, if it was planned; else in its final pose.
    track: Option<Track>,
    /// The room that it passes through.
    swept: Option<Arc<RenderMesh>>,
}

/// Part and electrode of a project in the electrode's final pose, or as the plan has it.
fn of_project(file: &Path, arguments: &RenderArguments, session: &Session) -> anyhow::Result<(Scene, Camera)> {
    let project = ProjectArguments { file: file.to_owned(), settings: arguments.settings.clone() };
    let job = super::plan::read(&project, session)?;
    let task = &session.task;
    let message = |e: String| anyhow::anyhow!("{}: {e}", file.display());
    let part = stages::load(&job, task).map_err(anyhow::Error::msg)?;
    let found = stages::channel(&part, &job, &|_| {}, task).map_err(message)?;
    let shown = if arguments.node.is_some() || arguments.swept {
        planned(arguments, &part, job, session)?
    } else {
        let made = stages::electrodes(&part, &found, &job, task).map_err(message)?;
        let count = made.electrodes.len();
        let electrode = made.electrodes.into_iter().nth(index(arguments)).ok_or_else(|| no_such(arguments, count))?;
        Shown { electrode, track: None, swept: None }
    };
    Ok(project_picture(&part, &found, &shown, arguments))
}

/// The place of the electrode asked for among all.
fn index(arguments: &RenderArguments) -> usize {
    arguments.electrode.map_or(0, |k| k as usize - 1)
}

fn no_such(arguments: &RenderArguments, count: usize) -> anyhow::Error {
    let plural = if count == 1 { "" } else { "s" };
    anyhow::anyhow!("--electrode {}: the project has {count} electrode{plural}, counted from 1", index(arguments) + 1)
}

fn project_picture(part: &Part, found: &FoundChannel, shown: &Shown, arguments: &RenderArguments) -> (Scene, Camera) {
    let is_planned = shown.track.is_some();
    let usual = if is_planned { NamedView::Channel } else { NamedView::Standard(StandardView::Isometric) };
    let view = arguments.view.unwrap_or(usual);
    let mut layers = Layers::default();
    if is_planned || view == NamedView::Channel {
        layers.into_channel();
    }
    layers.get_mut(Layer::Sweep).visible = shown.swept.is_some();
    let shape = Arc::new(RenderMesh::new(&shown.electrode.mesh));
    let scene = build(&SceneInputs {
        machine: &[],
        pose: None,
        blisk: Some(&part.shape),
        channel: Some((&found.channel, &found.shapes)),
        electrode: Some((&shown.electrode, &shape)),
        track: shown.track.as_ref(),
        s: shown.track.as_ref().map_or(0.0, Track::length),
        contact: None,
        trouble: None,
        values: None,
        residual_stock: None,
        layers: &layers,
        selected: None,
        ghosts: &[],
        swept: shown.swept.as_ref(),
        triad: true,
        section: None,
        theme: arguments.theme,
    });
    let camera = match view {
        NamedView::Channel => {
            into_channel(&found.channel, shown.electrode.enters_from, Camera::default(), aspect(arguments))
        }
        NamedView::Standard(view) => standard(view, &scene, Camera::default(), aspect(arguments)),
    };
    (scene, camera)
}

/// Plans, and answers the electrode, where it stands at the node asked for, and the room it passes through if that is
/// asked for.
fn planned(arguments: &RenderArguments, part: &Part, job: PlanJob, session: &Session) -> anyhow::Result<Shown> {
    let inputs = inputs_of(part, &job);
    let (prepared, inputs) = super::plan::ready(inputs, session)?;
    let outcome = run_prepared(&prepared, &inputs, &|_, _, _| (), &session.task)?;
    session.task.check()?;
    let count = outcome.electrodes.len();
    let chosen = outcome.electrodes.get(index(arguments)).ok_or_else(|| no_such(arguments, count))?;
    let (electrode, plan) = (chosen.electrode.clone(), &chosen.plan);
    let whole = Track::of_plan(plan);
    // Where nothing else is said the electrode stands in its final pose, which is node 0.
    let node = arguments.node.unwrap_or(0);
    let last = plan.nodes.len().saturating_sub(1);
    let station = whole.nodes().find(|s| s.node == Some(node)).copied().ok_or_else(|| {
        let verdict = plan.verdict(&outcome.channel);
        anyhow::anyhow!("--node {node}: the electrode has nodes 0 to {last}; it {verdict}")
    })?;
    let swept = arguments.swept.then(|| swept_shape(&electrode, &whole, FINE, &session.task)).transpose()?;
    Ok(Shown { electrode, track: Some(Track::standing(station)), swept })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_size_is_two_sides_within_limits() {
        assert_eq!(size("1400x900"), Ok([1400, 900]));
        assert_eq!(size("16X8192"), Ok([16, 8192]));
        for wrong in ["", "1400", "x900", "1400x", "1400x900x2", "0x900", "15x900", "8193x16", "-5x900", "1e3x900"] {
            assert!(size(wrong).is_err_and(|e| e.contains("1400x900")), "{wrong}");
        }
        assert!(size("8192x8192").is_err_and(|e| e.contains("million")));
    }
}
