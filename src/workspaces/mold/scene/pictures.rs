//! The pictures of a report on electrodes: all of them over the mold, and a cut through each where it burns.

use std::sync::Arc;

use super::electrodes::{BurnCut, BurnOf, ElectrodeScene, ElectrodeShape};
use crate::widgets::camera::PICTURE_SIZE;
use crate::widgets::camera::standard;
use crate::workspaces::mold::scene::{MoldScene, RegionColours, build_mold};
use mold::electrode::design::ElectrodeSet;
use mold::opening::Opening;
use render::camera::Camera;
use render::colour::Theme;
use render::mesh::RenderMesh;
use render::scene::Scene;
use render::view::StandardView;

/// Cuts that are drawn at most.
const MOST_CUTS: usize = 12;
/// How far electrodes are lifted in the picture of all of them.
const EXPLODED: f64 = 0.8;

/// A picture to be drawn.
pub struct ElectrodePicture {
    /// What is to be seen in it.
    pub caption: String,
    /// What is drawn.
    pub scene: Scene,
    /// Camera of the picture.
    pub camera: Camera,
}

/// The pictures of `set` in the order in which they explain it.
pub fn electrode_pictures(
    set: &ElectrodeSet,
    shapes: &[ElectrodeShape],
    mold: &Arc<RenderMesh>,
    opening: Opening,
) -> Vec<ElectrodePicture> {
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
    let mut pictures = vec![ElectrodePicture { caption: "The electrodes, retracted".to_owned(), scene, camera }];
    for (electrode, made) in set.electrodes.iter().enumerate().take(MOST_CUTS) {
        let at = BurnOf { electrode, burn: 0 };
        let cut = BurnCut { along_y: false, beside: 0.0 };
        let mut scene = bare(mold);
        ElectrodeScene { selected: Some(at), is_alone: true, exploded: 0.0, ..all }.add_to(&mut scene);
        scene.section = cut.plane(at, set, shapes, opening);
        let Some(camera) = cut.camera(at, set, shapes, opening) else { continue };
        let caption = format!("{} in its cavity, cut along X", made.name);
        pictures.push(ElectrodePicture { caption, scene, camera });
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
        look: super::MoldLook::Solid,
        invert: None,
        glance: None,
        layer: None,
        theme: Theme::LIGHT,
    })
}
