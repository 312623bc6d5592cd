//! Pictures of electrodes for their report: all of them lifted out of the mold, and a section through each where it burns.

use std::sync::Arc;

use glam::DVec3;

use super::camera::{onto_section, standard};
use super::colours::STEEL;
use super::mold::region_colour;
use crate::geometry::mesh::Mesh;
use crate::mold::electrode::design::{Burn, Electrode, ElectrodeSet};
use crate::mold::electrode::plan::to_burn_frame;
use crate::mold::opening::Opening;
use crate::render::camera::Camera;
use crate::render::colour::Theme;
use crate::render::mesh::RenderMesh;
use crate::render::scene::{Object, ObjectId, Scene, SectionPlane};
use crate::render::view::StandardView;

/// Sections drawn at most: those of the first electrodes.
const SECTIONS: usize = 12;
/// Height of a section's picture in parts of the electrode's depth in the mold.
const SECTION_DEPTHS: f64 = 1.6;
/// Width to height of the pictures.
const ASPECT: f64 = 1400.0 / 900.0;

/// A picture to be drawn.
pub struct ElectrodePicture {
    /// What is seen.
    pub caption: String,
    /// What is drawn.
    pub scene: Scene,
    /// From where.
    pub camera: Camera,
}

/// An electrode where a burn puts it, lifted by `lift` (mm), in the axes of the mold's mesh.
pub fn burning_mesh(electrode: &Electrode, burn: &Burn, opening: Opening, lift: f64) -> Mesh {
    let turned = to_burn_frame(electrode.direction);
    let back = turned.transpose();
    let placed = electrode.burning(&electrode.mesh, burn, &turned);
    placed.mapped(|p| opening.in_mesh(back * p - electrode.direction * lift))
}

/// The pictures of a set of electrodes for `mold`, in the axes of its mesh.
pub fn electrode_pictures(mold: &Mesh, set: &ElectrodeSet, opening: Opening) -> Vec<ElectrodePicture> {
    if set.electrodes.is_empty() {
        return Vec::new();
    }
    let mold = Arc::new(RenderMesh::new(mold));
    let mut pictures = vec![lifted_out(&mold, set, opening)];
    for number in 0..set.electrodes.len().min(SECTIONS) {
        pictures.extend(section(&mold, set, number, opening));
    }
    pictures
}

fn scene_of(mold: &Arc<RenderMesh>) -> Scene {
    let mut scene = Scene { triad: false, ..Scene::new(Theme::LIGHT) };
    scene.objects.push(Object::new(ObjectId(0), mold.clone(), STEEL));
    scene
}

fn lifted_out(mold: &Arc<RenderMesh>, set: &ElectrodeSet, opening: Opening) -> ElectrodePicture {
    let mut scene = scene_of(mold);
    let lift = set.electrodes.iter().flat_map(|e| &e.burns).map(|b| b.depth).fold(0.0, f64::max) * 1.3;
    for (number, electrode) in set.electrodes.iter().enumerate() {
        for burn in &electrode.burns {
            let mesh = Arc::new(RenderMesh::new(&burning_mesh(electrode, burn, opening, lift)));
            scene.objects.push(Object::new(ObjectId(1 + number as u32), mesh, region_colour(number)));
        }
    }
    let camera = standard(StandardView::Isometric, &scene, Camera::default(), ASPECT);
    let caption = format!("All {} electrodes, each lifted {lift:.0} mm out of where it burns", set.electrodes.len());
    ElectrodePicture { caption, scene, camera }
}

fn section(mold: &Arc<RenderMesh>, set: &ElectrodeSet, number: usize, opening: Opening) -> Option<ElectrodePicture> {
    let electrode = &set.electrodes[number];
    let burn = electrode.burns.first()?;
    let mesh = burning_mesh(electrode, burn, opening, 0.0);
    let tips = electrode.tips.bounds();
    let mut scene = scene_of(mold);
    scene.objects.push(Object::new(ObjectId(1), Arc::new(RenderMesh::new(&mesh)), region_colour(number)));
    let up = opening.in_mesh(-electrode.direction);
    // Across the longer side of the tips.
    let along = if tips.size().x > tips.size().y { DVec3::X } else { DVec3::Y };
    let turned = glam::DVec2::from_angle(burn.turn).rotate(along.truncate()).extend(0.0);
    let back = to_burn_frame(electrode.direction).transpose();
    let normal = opening.in_mesh(back * turned);
    let low = mesh.vertices.iter().map(|p| p.dot(up)).fold(f64::INFINITY, f64::min);
    let middle = opening.in_mesh(burn.position);
    let at = middle + up * (low + 0.4 * burn.depth - middle.dot(up));
    let plane = SectionPlane { point: middle, normal };
    scene.section = Some(plane);
    let camera = onto_section(&plane, up, at, SECTION_DEPTHS * burn.depth.max(2.0));
    let gap = set.params.stages.get(electrode.stage).map_or(0.0, |s| s.gap_mm);
    let caption = format!("{} where it burns first, cut across; spark gap {gap} mm", electrode.name);
    Some(ElectrodePicture { caption, scene, camera })
}
