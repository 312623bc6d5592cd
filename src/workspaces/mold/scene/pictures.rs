//! The pictures of reports. On uncut regions: the regions by number and by depth, the uncut segments on the section
//! curves, and the largest regions from near. On electrodes: all of them over the mold, and a cut through each where it
//! burns.

use std::sync::Arc;

use glam::DVec3;

use super::electrodes::{BurnCut, BurnOf, ElectrodeScene, ElectrodeShape, electrode_colour};
use crate::widgets::camera::PICTURE_SIZE;
use crate::widgets::camera::standard;
use crate::widgets::theme::BAD;
use crate::workspaces::mold::job::uncut::Uncut;
use crate::workspaces::mold::scene::{
    INVERT, MoldLook, MoldScene, REGION_COLOURS, RegionColours, RegionShape, build_mold, depth_legend, faces_shape,
    region_colour, region_shapes,
};
use files::report::{Picture, counted};
use geometry::mesh::{Bounds, Mesh};
use mold::electrode::design::ElectrodeSet;
use mold::opening::Opening;
use mold::section::sections;
use render::camera::Camera;
use render::colour::{Colour, Theme};
use render::mesh::RenderMesh;
use render::offscreen::{Offscreen, RenderError};
use render::scene::{LineSet, Scene};
use render::view::{StandardView, looking};
use task::{Cancel, Cancelled, Task};

/// Cuts that are drawn at most.
const MOST_CUTS: usize = 12;
/// How far electrodes are lifted in the picture of all of them.
const EXPLODED: f64 = 0.8;
/// Regions that have a picture of their own at most.
const MOST_REGIONS: usize = 6;
/// Layers whose section curves are drawn at most.
const MOST_LAYERS: usize = 48;
/// Margin around a region in its picture, as a share of its diagonal.
const AROUND: f64 = 0.8;
/// Distance of lines before the surface that they lie on, as a share of the mold's diagonal.
const BEFORE: f64 = 5e-4;

/// A picture to be drawn.
pub struct MoldPicture {
    /// Title: the content of the picture in a few words.
    pub title: String,
    /// What is to be seen in it, in a sentence or two.
    pub caption: String,
    /// Colours and what each stands for.
    pub legend: Vec<(Colour, String)>,
    /// What is drawn.
    pub scene: Scene,
    /// Camera of the picture.
    pub camera: Camera,
}

impl MoldPicture {
    fn new(title: String, scene: Scene, camera: Camera) -> Self {
        Self { title, caption: String::new(), legend: Vec::new(), scene, camera }
    }
}

/// Draws pictures for a page.
///
/// # Errors
/// [`RenderError`], if nothing can be drawn here, or the task is cancelled.
pub fn draw(pictures: Vec<MoldPicture>, task: &Task) -> Result<Vec<Picture>, RenderError> {
    let mut offscreen = Offscreen::new()?;
    let count = pictures.len() as f64;
    let mut drawn = Vec::new();
    for (i, MoldPicture { title, caption, legend, scene, camera }) in pictures.into_iter().enumerate() {
        task.check()?;
        task.report("pictures", i as f64 / count, &title);
        let png = offscreen.png(&scene, &camera, PICTURE_SIZE, &task.cancel)?;
        let css = |c: Colour| format!("#{:02x}{:02x}{:02x}", c.r, c.g, c.b);
        let legend = legend.into_iter().map(|(colour, what)| (css(colour), what)).collect();
        drawn.push(Picture { file: String::new(), title, caption, legend, png });
    }
    Ok(drawn)
}

/// Shapes of a mold and of what is left of it, as pictures show them.
pub struct UncutShapes<'a> {
    /// The mold.
    pub mold: &'a Arc<RenderMesh>,
    /// Uncut regions.
    pub regions: &'a [RegionShape],
    /// Undercut faces, if there are any.
    pub invert: Option<&'a Arc<RenderMesh>>,
}

/// [`uncut_pictures`] with shapes that are made for them.
///
/// # Errors
/// [`Cancelled`].
pub fn pictures_of(mesh: &Mesh, uncut: &Uncut, cancel: &Cancel) -> Result<Vec<MoldPicture>, Cancelled> {
    let mold = Arc::new(RenderMesh::new(mesh));
    let regions = region_shapes(mesh, &uncut.surface, uncut.regions.len(), uncut.params.opening);
    let invert = faces_shape(mesh, &uncut.stack.invert.triangles);
    uncut_pictures(mesh, uncut, &UncutShapes { mold: &mold, regions: &regions, invert: invert.as_ref() }, cancel)
}

/// The pictures of `uncut` regions of a `mesh` in the order in which they explain them.
///
/// # Errors
/// [`Cancelled`].
pub fn uncut_pictures(
    mesh: &Mesh,
    uncut: &Uncut,
    shapes: &UncutShapes,
    cancel: &Cancel,
) -> Result<Vec<MoldPicture>, Cancelled> {
    let opening = uncut.params.opening;
    let deepest = uncut.regions.iter().fold(0.0, |most: f64, r| most.max(r.depth));
    let all = vec![true; shapes.regions.len()];
    let look = MoldScene {
        mold: shapes.mold,
        regions: shapes.regions,
        shown: &all,
        colours: RegionColours::ByRegion,
        deepest,
        selected: None,
        look: MoldLook::Solid,
        invert: shapes.invert,
        glance: None,
        layer: None,
        theme: Theme::LIGHT,
    };
    let mut legend =
        legend_of((0..uncut.regions.len()).map(|i| (region_colour(i), format!("region {}", i + 1))).collect());
    legend.extend(shapes.invert.map(|_| (INVERT, "undercut, not reachable".to_owned())));
    let mut pictures = Vec::new();
    let mut add = |title: &str, caption: String, legend, scene: Scene, towards: DVec3| {
        let camera = camera(opening, towards, &shapes.mold.bounds());
        pictures.push(MoldPicture { caption, legend, ..MoldPicture::new(title.to_owned(), scene, camera) });
    };
    let caption = "Where no cutter of the library touches the mold, each region in its own colour.";
    add("Uncut regions", caption.to_owned(), legend, build_mold(&look), ASLANT);
    let colours = depth_legend(deepest);
    let depths = [0.0, 0.5, 1.0].map(|t| (colours.map.at(t), format!("{:.2} mm", t * colours.max))).to_vec();
    let scene = build_mold(&MoldScene { colours: RegionColours::ByDepth, ..look });
    add("Height of the rest material", "Seen along the opening direction.".to_owned(), depths, scene, DVec3::Z);
    let (scene, layers) = segments(mesh, uncut, shapes, cancel)?;
    let all = counted(uncut.layers.len(), "layer");
    let shown = if layers < uncut.layers.len() { format!("{layers} of {all}") } else { all };
    let caption = format!("Section curves of {shown} and what no cutter touches of them.");
    let legend = vec![(SECTION, "section curves".to_owned()), (BAD, "uncut segments".to_owned())];
    add("Uncut segments", caption, legend, scene, ASLANT);
    let shown = |i: usize| (0..shapes.regions.len()).map(|other| other == i).collect::<Vec<_>>();
    for (i, region) in uncut.regions.iter().enumerate().take(MOST_REGIONS) {
        let bounds = Bounds::of([region.bounds.min, region.bounds.max].map(|p| opening.in_mesh(p)));
        let bounds = bounds.grown(AROUND * bounds.size().length());
        let scene = build_mold(&MoldScene { shown: &shown(i), ..look });
        let title = format!("Region {}", i + 1);
        let caption =
            format!("{:.3} mm\u{b3}, {:.2} mm high, {:.3} mm thick.", region.volume, region.depth, region.thickness);
        let camera = camera(opening, ASLANT, &bounds);
        pictures.push(MoldPicture { caption, ..MoldPicture::new(title, scene, camera) });
    }
    Ok(pictures)
}

/// The colours of regions or electrodes with their names, cut off where colours repeat.
fn legend_of(mut all: Vec<(Colour, String)>) -> Vec<(Colour, String)> {
    if let Some(more) = all.len().checked_sub(REGION_COLOURS).filter(|more| *more > 0) {
        all.truncate(REGION_COLOURS);
        all.push((SECTION, format!("and {more} more, whose colours repeat")));
    }
    all
}

/// Direction to the viewer of a picture from above and beside, in the upright mold.
const ASLANT: DVec3 = DVec3::new(0.6, -1.0, 1.4);
/// Colour of section curves.
const SECTION: Colour = Colour::rgb(0x8a, 0x90, 0x98);

/// A camera on a box (mm) of the mesh from a direction of the upright mold.
fn camera(opening: Opening, towards: DVec3, bounds: &Bounds) -> Camera {
    let up = if towards == DVec3::Z { DVec3::Y } else { DVec3::Z };
    let orientation = looking(opening.in_mesh(towards), opening.in_mesh(up));
    let mut camera = Camera { orientation, ..Camera::default() };
    camera.fit(bounds, f64::from(PICTURE_SIZE[0]) / f64::from(PICTURE_SIZE[1]));
    camera
}

/// Uncut segments on the section curves of at most [`MOST_LAYERS`] layers, evenly chosen, and the number of these.
fn segments(mesh: &Mesh, uncut: &Uncut, shapes: &UncutShapes, cancel: &Cancel) -> Result<(Scene, usize), Cancelled> {
    let opening = uncut.params.opening;
    let bounds = opening.upright_mesh(mesh).bounds();
    let lift = BEFORE * bounds.size().length();
    let apart = bounds.size().z / MOST_LAYERS as f64;
    let mut chosen: Vec<usize> = Vec::new();
    for (k, layer) in uncut.layers.iter().enumerate() {
        if chosen.last().is_none_or(|last| layer.z - uncut.layers[*last].z >= apart) {
            chosen.push(k);
        }
    }
    let heights: Vec<f64> = chosen.iter().map(|k| uncut.layers[*k].z).collect();
    let curves = sections(&opening.upright_mesh(mesh), &heights, cancel)?;
    let closed = |(section, z): (mold::section::Section, &f64)| {
        let outline = |o: &mold::outline::Outline| {
            let points = o.points();
            points.iter().chain(points.first()).map(|p| opening.in_mesh(p.extend(*z))).collect::<Vec<_>>()
        };
        section.outlines.iter().map(outline).collect::<Vec<_>>()
    };
    let curves = curves.into_iter().zip(&heights).flat_map(closed).collect();
    let runs = uncut.segment_runs().into_iter().filter(|run| chosen.binary_search(&run.layer).is_ok());
    let above = |p: &DVec3| opening.in_mesh(*p + lift * DVec3::Z);
    let runs = runs.map(|run| run.points.iter().map(above).collect()).collect();
    let mut scene = bare(shapes.mold);
    scene.objects.iter_mut().for_each(|mold| mold.opacity = 0.25);
    scene.lines.push(LineSet { width_px: 1.0, ..LineSet::new(curves, SECTION) });
    scene.lines.push(LineSet { width_px: 3.0, on_top: true, ..LineSet::new(runs, BAD) });
    Ok((scene, heights.len()))
}

/// The pictures of `set` in the order in which they explain it.
pub fn electrode_pictures(
    set: &ElectrodeSet,
    shapes: &[ElectrodeShape],
    mold: &Arc<RenderMesh>,
    opening: Opening,
) -> Vec<MoldPicture> {
    let all = ElectrodeScene {
        set,
        shapes,
        opening,
        mold: mold.bounds(),
        stage: set.params.stages.len().saturating_sub(1),
        selected: None,
        is_alone: false,
        exploded: EXPLODED,
        raised: 0.0,
        place: None,
    };
    let mut scene = bare(mold);
    all.add_to(&mut scene);
    let aspect = f64::from(PICTURE_SIZE[0]) / f64::from(PICTURE_SIZE[1]);
    let camera = standard(StandardView::Isometric, &scene, Camera::default(), aspect);
    let shown = set.electrodes.iter().enumerate().filter(|(_, electrode)| electrode.stage == all.stage);
    let legend = legend_of(shown.map(|(e, made)| (electrode_colour(set, e), made.name.clone())).collect());
    let mut pictures =
        vec![MoldPicture { legend, ..MoldPicture::new("The electrodes, retracted".to_owned(), scene, camera) }];
    for (electrode, made) in set.electrodes.iter().enumerate().take(MOST_CUTS) {
        let at = BurnOf { electrode, burn: 0 };
        let cut = BurnCut { along_y: false, beside: 0.0 };
        let mut scene = bare(mold);
        ElectrodeScene { selected: Some(at), is_alone: true, exploded: 0.0, ..all }.add_to(&mut scene);
        scene.section = cut.plane(at, set, shapes, opening);
        let Some(camera) = cut.camera(at, set, shapes, opening) else { continue };
        pictures.push(MoldPicture::new(format!("{} in its cavity, cut along X", made.name), scene, camera));
    }
    pictures
}

/// The mold alone.
fn bare(mold: &Arc<RenderMesh>) -> Scene {
    build_mold(&MoldScene {
        mold,
        regions: &[],
        shown: &[],
        colours: RegionColours::ByRegion,
        deepest: 0.0,
        selected: None,
        look: MoldLook::Solid,
        invert: None,
        glance: None,
        layer: None,
        theme: Theme::LIGHT,
    })
}
