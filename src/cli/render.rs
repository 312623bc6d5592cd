//! `sparkpath render`: a picture without a window.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::{Answer, RenderArguments, Session};
use crate::export::files::write_atomically;
use crate::jobs::plan::{ElectrodeOutcome, PlanInputs, run};
use crate::jobs::stages::{self, FoundChannel, Part};
use crate::project::{PlanJob, ProjectFile};
use crate::render::camera::Camera;
use crate::render::colour::{Colour, Theme};
use crate::render::mesh::RenderMesh;
use crate::render::offscreen::Offscreen;
use crate::render::scene::{Grid, Object, ObjectId, Scene};
use crate::render::view::StandardView;
use crate::views::{Layers, NamedView, SceneInputs, Station, Track, build, into_channel, standard};

/// Fewest and most pixels along a side.
const SIDES: [u32; 2] = [16, 8192];
/// Most pixels of a picture: what a driver needs for them stays below about 2 GB.
const MOST_PIXELS: u64 = 34_000_000;
/// Colours of meshes that are shown together, in their order, over and over.
const COLOURS: [Colour; 6] = [
    Colour::rgb(0x9d, 0xab, 0xba),
    Colour::rgb(0xd0, 0x83, 0x4f),
    Colour::rgb(0x6f, 0xa8, 0xa0),
    Colour::rgb(0x8a, 0x96, 0xc8),
    Colour::rgb(0xc9, 0xb4, 0x5a),
    Colour::rgb(0xb5, 0x7f, 0xa8),
];

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
    let is_project = |path: &&PathBuf| path.extension().is_some_and(|e| e.eq_ignore_ascii_case("sparkpath"));
    let (scene, camera) = match (&arguments.files[..], arguments.files.iter().find(is_project)) {
        ([project], Some(_)) => of_project(project, arguments, session)?,
        (_, Some(project)) => anyhow::bail!("{}: a project is drawn by itself; give it alone", project.display()),
        (meshes, None) => of_meshes(meshes, arguments, session)?,
    };
    session.cancel.check()?;
    let png = offscreen.png(&scene, &camera, arguments.size)?;
    session.cancel.check()?;
    write_atomically(&arguments.png, &png)?;
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
    let folder = png.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let tried = tempfile::tempfile_in(folder);
    tried
        .map(drop)
        .map_err(|e| anyhow::anyhow!("{}: cannot be written ({e}); give another file with --png", png.display()))
}

fn aspect(arguments: &RenderArguments) -> f64 {
    f64::from(arguments.size[0]) / f64::from(arguments.size[1])
}

/// The meshes in their own coordinates, each in a colour of its own.
fn of_meshes(meshes: &[PathBuf], arguments: &RenderArguments, session: &Session) -> anyhow::Result<(Scene, Camera)> {
    anyhow::ensure!(
        arguments.node.is_none(),
        "--node {}: nodes belong to a project; give a .sparkpath file",
        arguments.node.unwrap_or(0)
    );
    let view = match arguments.view {
        None => StandardView::Isometric,
        Some(NamedView::Standard(view)) => view,
        Some(NamedView::Channel) => {
            anyhow::bail!("--view channel: channels belong to a project; give a .sparkpath file")
        }
    };
    let mut scene = Scene::new(arguments.theme);
    for (i, path) in meshes.iter().enumerate() {
        let imported = session.import(path, arguments.units)?;
        let shape = Arc::new(RenderMesh::new(&imported.mesh));
        scene.objects.push(Object::new(ObjectId(i as u32), shape, COLOURS[i % COLOURS.len()]));
    }
    scene.grid = Grid::below(&scene.bounds());
    let camera = standard(view, &scene, Camera::default(), aspect(arguments));
    Ok((scene, camera))
}

/// Part and electrode of a project in the electrode's final pose, or at a node of the plan.
fn of_project(file: &Path, arguments: &RenderArguments, session: &Session) -> anyhow::Result<(Scene, Camera)> {
    let mut job = read_project(file)?;
    if let Some(seed) = session.seed {
        job.genetic.seed = seed;
    }
    let (progress, cancel) = (&session.progress, &session.cancel);
    let message = |e: String| anyhow::anyhow!("{}: {e}", file.display());
    job.validate().map_err(message)?;
    let part = stages::load(&job, progress, cancel).map_err(anyhow::Error::msg)?;
    let found = stages::channel(&part, &job, progress, cancel).map_err(message)?;
    let at_node = arguments.node.map(|node| at_node(node, &part, job.clone(), session)).transpose()?;
    let (electrode, track) = match at_node {
        Some((outcome, station)) => (outcome.electrode, Some(Track::standing(station))),
        None => {
            let made = stages::electrodes(&part, &found, &job, progress, cancel).map_err(message)?;
            (made.electrodes.into_iter().next().ok_or_else(|| message("has no electrode".to_owned()))?, None)
        }
    };
    let shape = Arc::new(RenderMesh::new(&electrode.mesh));
    let shown = (&electrode, &shape);
    Ok(project_picture(&part, &found, shown, track.as_ref(), arguments))
}

fn project_picture(
    part: &Part,
    found: &FoundChannel,
    electrode: (&crate::blisk::electrode::Electrode, &Arc<RenderMesh>),
    track: Option<&Track>,
    arguments: &RenderArguments,
) -> (Scene, Camera) {
    let usual = if track.is_some() { NamedView::Channel } else { NamedView::Standard(StandardView::Isometric) };
    let view = arguments.view.unwrap_or(usual);
    let mut layers = Layers::default();
    if track.is_some() || view == NamedView::Channel {
        layers.into_channel();
    }
    let scene = build(&SceneInputs {
        blisk: Some(&part.shape),
        channel: Some((&found.channel, &found.shapes)),
        electrode: Some(electrode),
        track,
        s: track.map_or(0.0, Track::length),
        contact: None,
        values: None,
        layers: &layers,
        selected: None,
        ghosts: &[],
        triad: true,
        section: None,
        theme: arguments.theme,
    });
    let camera = match view {
        NamedView::Channel => {
            into_channel(&found.channel, electrode.0.enters_from, Camera::default(), aspect(arguments))
        }
        NamedView::Standard(view) => standard(view, &scene, Camera::default(), aspect(arguments)),
    };
    (scene, camera)
}

/// Reads a project, and says when its meshes are others than those it was made with.
fn read_project(file: &Path) -> anyhow::Result<PlanJob> {
    let project = ProjectFile::read(file)?;
    for mesh in project.moved_meshes().iter().filter(|m| m.changed) {
        super::terminal::print_error(&format!("note: {} has changed since the project was saved", mesh.path.display()));
    }
    Ok(project.job)
}

/// Plans, and answers the first electrode and where it stands at `node`.
fn at_node(node: usize, part: &Part, job: PlanJob, session: &Session) -> anyhow::Result<(ElectrodeOutcome, Station)> {
    let inputs = PlanInputs { blisk: part.mesh.clone(), own_electrode: part.own_electrode.clone(), job };
    let outcome = run(&inputs, &session.progress, &session.cancel)?;
    let verdict = |e: &ElectrodeOutcome| e.plan.verdict(&outcome.channel);
    let Some(first) = outcome.electrodes.first() else { anyhow::bail!("--node {node}: the plan has no electrode") };
    let station = Track::of_plan(&first.plan).nodes().find(|s| s.node == Some(node)).copied();
    let Some(station) = station else {
        let last = first.plan.nodes.len().saturating_sub(1);
        anyhow::bail!("--node {node}: the electrode has nodes 0 to {last}; it {}", verdict(first));
    };
    Ok((first.clone(), station))
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
