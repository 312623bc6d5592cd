//! The surfaces of a wheel in colours of their classes: hub, shroud, sides of blades, edges, tips, fillets.

use std::sync::Arc;

use rayon::prelude::*;

use super::caps::close_holes;
use super::shapes::shroud_triangles;
use super::{Layer, layer_id};
use crate::widgets::theme::{BLADE, HUB, SHROUD, STEEL};
use geometry::mesh::Mesh;
use render::colour::Colour;
use render::mesh::RenderMesh;
use render::scene::{Object, Scene};
use task::{Cancelled, Task};
use wheel::channel::Channel;
use wheel::surfaces::{ClassArea, SurfaceClass, classify};

/// Colour of a class.
pub fn class_colour(class: SurfaceClass) -> Colour {
    match class {
        SurfaceClass::Hub => HUB,
        SurfaceClass::Shroud => SHROUD,
        SurfaceClass::MainLow => BLADE,
        SurfaceClass::MainHigh => Colour::rgb(0x5c, 0xc0, 0xdc),
        SurfaceClass::SplitterLow => Colour::rgb(0x3d, 0x5f, 0xa8),
        SurfaceClass::SplitterHigh => Colour::rgb(0x2f, 0x8a, 0x9c),
        SurfaceClass::Tip => Colour::rgb(0xd8, 0xcc, 0x62),
        SurfaceClass::Edge => Colour::rgb(0xd8, 0x6a, 0x8c),
        SurfaceClass::HubFillet => Colour::rgb(0xea, 0x9a, 0x3e),
        SurfaceClass::ShroudFillet => Colour::rgb(0xc4, 0x6a, 0x34),
        SurfaceClass::Elsewhere => STEEL,
    }
}

/// A part of the wheel's surface with its colour.
type Patch = (Colour, Arc<RenderMesh>);

/// The surfaces of a wheel for the screen.
pub struct SurfaceMap {
    /// Classes with their areas.
    pub areas: Vec<ClassArea>,
    /// Radii of the fillets at hub and shroud (mm).
    pub fillets_mm: [Option<f64>; 2],
    /// The whole loaded part, in its own coordinates.
    whole: Vec<Patch>,
    /// The part without its shroud; empty where that is not of the loaded mesh.
    unshrouded: Vec<Patch>,
}

impl SurfaceMap {
    /// The surfaces of the loaded `mesh`, in which `channel` was found; `face_of` as for [`classify`].
    ///
    /// # Errors
    /// Only when cancelled.
    pub fn new(mesh: &Mesh, channel: &Channel, face_of: &[u32], task: &Task) -> Result<Self, Cancelled> {
        let found = classify(mesh, channel, face_of, task)?;
        let patches = |is_shown: &(dyn Fn(usize) -> bool + Sync)| -> Result<Vec<Patch>, Cancelled> {
            let patch = |area: &ClassArea| {
                task.cancel.check()?;
                let of_class = (0..mesh.triangles.len()).filter(|&i| found.classes[i] == area.class && is_shown(i));
                let triangles = of_class.map(|i| mesh.triangles[i]).collect();
                let mesh = Mesh { vertices: mesh.vertices.clone(), triangles }.compacted();
                Ok((class_colour(area.class), Arc::new(RenderMesh::new(&mesh))))
            };
            found.areas.par_iter().map(patch).collect()
        };
        let whole = patches(&|_| true)?;
        // Of a sector, what is shown without its shroud is the whole wheel.
        let mut unshrouded = if channel.whole.is_none() { whole.clone() } else { Vec::new() };
        if channel.shrouded && channel.whole.is_none() {
            let is_shroud = shroud_triangles(&mesh.in_frame(&channel.frame), channel);
            unshrouded = patches(&|i| !is_shroud[i])?;
            let kept = mesh.triangles.iter().zip(&is_shroud).filter(|(_, is_shroud)| !**is_shroud);
            let mut bare = Mesh { vertices: mesh.vertices.clone(), triangles: kept.map(|(t, _)| *t).collect() };
            let lids = bare.triangles.len();
            close_holes(&mut bare);
            bare.triangles.drain(..lids);
            unshrouded.push((STEEL, Arc::new(RenderMesh::new(&bare.compacted()))));
        }
        Ok(Self { areas: found.areas, fillets_mm: [found.hub_fillet_mm, found.shroud_fillet_mm], whole, unshrouded })
    }

    /// Colours the wheel of `scene`.
    pub fn colour(&self, scene: &mut Scene) {
        for (layer, patches) in [(Layer::Blisk, &self.whole), (Layer::Unshrouded, &self.unshrouded)] {
            let id = layer_id(layer);
            let Some(place) = scene.objects.iter().position(|object| object.id == id && object.values.is_none()) else {
                continue;
            };
            if patches.is_empty() {
                continue;
            }
            let plain = scene.objects.remove(place);
            // Their edges would be those between classes, along whatever facets the mesh has.
            let coloured = patches.iter().filter(|(_, mesh)| !mesh.is_empty()).map(|(colour, mesh)| Object {
                selected: plain.selected,
                edges: false,
                ..Object::new(id, mesh.clone(), *colour).with_opacity(plain.opacity)
            });
            scene.objects.extend(coloured.collect::<Vec<_>>());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;
    use render::colour::Theme;
    use wheel::find_channel::find_channel;
    use wheel::options::BliskOptions;
    use wheel::parametric::{MeshResolution, ParametricBlisk};

    /// Every triangle is drawn once, in the colour of its class, and the surfaces are where the part has them.
    #[test]
    fn the_classes_cover_the_part_and_take_its_place_in_a_scene() {
        let part = ParametricBlisk::turbine();
        let mesh = part.mesh(&MeshResolution::default()).unwrap();
        let channel = find_channel(&mesh, &BliskOptions::default(), &Task::default()).unwrap();
        let map = SurfaceMap::new(&mesh, &channel, &[], &Task::default()).unwrap();
        let total: f64 = map.areas.iter().map(|area| area.area_mm2).sum();
        assert!((total - mesh.area()).abs() < 1e-6 * total, "{total}");
        let triangles: usize = map.areas.iter().map(|area| area.triangles).sum();
        assert_eq!(triangles, mesh.triangles.len());
        for class in [SurfaceClass::Hub, SurfaceClass::Shroud, SurfaceClass::MainLow, SurfaceClass::MainHigh] {
            assert!(map.areas.iter().any(|area| area.class == class && area.area_mm2 > 0.0), "{class:?}");
        }
        let mut scene = Scene::new(Theme::DARK);
        scene.objects.push(Object::new(layer_id(Layer::Blisk), Arc::new(RenderMesh::new(&mesh)), STEEL));
        let before = scene.bounds();
        map.colour(&mut scene);
        assert_eq!(scene.objects.len(), map.areas.len());
        let close = |a: DVec3, b: DVec3| a.distance(b) < 1e-9;
        assert!(close(scene.bounds().min, before.min) && close(scene.bounds().max, before.max));
    }

    #[test]
    fn no_two_classes_have_one_colour() {
        for (i, a) in SurfaceClass::ALL.iter().enumerate() {
            assert!(SurfaceClass::ALL[..i].iter().all(|b| class_colour(*a) != class_colour(*b)), "{a:?}");
        }
    }
}
