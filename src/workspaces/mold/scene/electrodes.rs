//! Electrodes for a mold on the screen: where they burn, how they get there, and how they are cut.

use std::sync::Arc;

use glam::{DAffine3, DMat3, DVec2, DVec3};

use crate::widgets::camera::onto_section;
use crate::widgets::theme::BAD;
use crate::workspaces::mold::scene::region_colour;
use geometry::mesh::{Bounds, Mesh, normal_times_two_areas};
use mold::electrode::design::{Burn, Electrode, ElectrodeSet};
use mold::electrode::setting::to_burn_frame;
use mold::opening::Opening;
use render::camera::Camera;
use render::colour::Colour;
use render::mesh::RenderMesh;
use render::scene::{Marker, Object, ObjectId, Scene, SectionPlane};

/// Names of objects from which on they are electrodes: so many for each, one for each of its burns.
const FIRST: u32 = 1 << 24;
const BURNS: u32 = 1 << 12;
/// How near to the lowest corner of an electrode a face is its floor (mm).
const FLOOR: f64 = 1e-3;
/// Height of the picture of a section in parts of the depth of the burn.
const SECTION_DEPTHS: f64 = 1.8;
/// How far above its lowest face the middle of that picture is, in the same parts: below are the controls.
const SECTION_MIDDLE: f64 = 0.3;
/// Opacity of the burns beside the one that is looked at.
const BESIDE: f32 = 0.35;

/// An electrode made for the screen.
#[derive(Debug, Clone)]
pub struct ElectrodeShape {
    /// Mesh of the electrode, in its own axes.
    pub shape: Arc<RenderMesh>,
    /// A point of its lowest face, where a cut through it is worth looking at.
    pub lowest: DVec3,
}

/// The electrodes of `set` for the screen.
pub fn electrode_shapes(set: &ElectrodeSet) -> Vec<ElectrodeShape> {
    let shape = |e: &Electrode| ElectrodeShape { shape: Arc::new(RenderMesh::new(&e.mesh)), lowest: lowest(&e.tips) };
    set.electrodes.iter().map(shape).collect()
}

/// The middle of the largest triangle at the lowest place of `tips`.
fn lowest(tips: &Mesh) -> DVec3 {
    let low = tips.bounds().min.z;
    let is_low = |corners: &[DVec3; 3]| corners.iter().all(|p| p.z < low + FLOOR);
    let area = |corners: &[DVec3; 3]| normal_times_two_areas(*corners).length();
    let largest = tips.iter_corners().filter(is_low).max_by(|a, b| area(a).total_cmp(&area(b)));
    let middle = largest.map(|[a, b, c]| (a + b + c) / 3.0);
    // A tip may end in an edge or a point.
    middle.or_else(|| tips.vertices.iter().copied().min_by(|a, b| a.z.total_cmp(&b.z))).unwrap_or_default()
}

/// A burn of an electrode.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BurnOf {
    /// The electrode's place in the set.
    pub electrode: usize,
    /// The burn's among those of the electrode.
    pub burn: usize,
}

impl BurnOf {
    /// The object that it is shown as.
    fn id(self) -> ObjectId {
        ObjectId(FIRST + self.electrode as u32 * BURNS + self.burn as u32)
    }

    /// What an object shows, if that is a burn.
    pub fn of(id: ObjectId) -> Option<Self> {
        let number = id.0.checked_sub(FIRST)?;
        Some(Self { electrode: (number / BURNS) as usize, burn: (number % BURNS) as usize })
    }

    /// The electrode and its burn in `set`, if they are there.
    pub fn find(self, set: &ElectrodeSet) -> Option<(&Electrode, &Burn)> {
        let electrode = set.electrodes.get(self.electrode)?;
        Some((electrode, electrode.burns.get(self.burn)?))
    }
}

/// The colour of an electrode, the same in every stage.
pub fn electrode_colour(set: &ElectrodeSet, electrode: usize) -> Colour {
    let stage = set.electrodes.get(electrode).map(|e| e.stage);
    region_colour(set.electrodes.iter().take(electrode).filter(|e| Some(e.stage) == stage).count())
}

/// From the axes of an electrode to those of the mold's mesh, where it burns, moved by `off` in the upright mold (mm).
pub fn placement(electrode: &Electrode, burn: &Burn, off: DVec3, opening: Opening) -> DAffine3 {
    let back = to_burn_frame(electrode.direction).transpose() * DMat3::from_rotation_z(burn.turn);
    let axes = [back.x_axis, back.y_axis, back.z_axis].map(|axis| opening.in_mesh(axis));
    DAffine3::from_mat3_translation(DMat3::from_cols(axes[0], axes[1], axes[2]), opening.in_mesh(burn.position + off))
}

/// A part of the way of an electrode.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(missing_docs)]
pub enum BurnPhase {
    Approach,
    Burn,
    Lift,
}

impl BurnPhase {
    /// All phases, in order; each takes an equal share of the way's time.
    pub const ALL: [Self; 3] = [Self::Approach, Self::Burn, Self::Lift];

    /// Name of the phase.
    pub fn name(self) -> &'static str {
        ["approach", "burn", "lift"][self as usize]
    }
}

/// The way of an electrode down to the mold, into it and out again.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BurnWay {
    /// How far above its last place it begins and ends (mm).
    pub lift: f64,
    /// How far above it the burning begins (mm).
    pub depth: f64,
}

impl BurnWay {
    /// The way of one burn where electrodes are lifted by `lift` (mm), or as far as it takes to be out.
    pub fn of(burn: &Burn, lift: f64) -> Self {
        let depth = burn.depth.max(0.0);
        Self { lift: lift.max(depth), depth }
    }

    /// What the electrode does at a time from 0 to 1, and how far above its last place it is (mm).
    pub fn at(&self, time: f64) -> (BurnPhase, f64) {
        let time = 3.0 * time.clamp(0.0, 1.0);
        let between = |from: f64, to: f64, t: f64| from + (to - from) * t;
        match time {
            t if t < 1.0 => (BurnPhase::Approach, between(self.lift, self.depth, t)),
            t if t <= 2.0 => (BurnPhase::Burn, between(self.depth, 0.0, t - 1.0)),
            t => (BurnPhase::Lift, between(0.0, self.lift, t - 2.0)),
        }
    }
}

/// How electrodes are shown.
#[derive(Clone, Copy)]
pub struct ElectrodeScene<'a> {
    /// The electrodes.
    pub set: &'a ElectrodeSet,
    /// Shapes of the electrodes for the screen.
    pub shapes: &'a [ElectrodeShape],
    /// Where the mold opens to.
    pub opening: Opening,
    /// The box around the mold, in the axes of its mesh (mm).
    pub mold: Bounds,
    /// The stage whose electrodes are shown.
    pub stage: usize,
    /// The burn that is selected.
    pub selected: Option<BurnOf>,
    /// Whether no other is shown.
    pub is_alone: bool,
    /// How far they are lifted out of the mold and moved apart, 0 to 1.
    pub exploded: f64,
    /// How far above its place the selected one is on its way (mm).
    pub raised: f64,
    /// A place that is pointed at, in the upright mold (mm).
    pub place: Option<DVec3>,
}

impl ElectrodeScene<'_> {
    /// How far a burn is moved off its place, in the upright mold (mm).
    fn off(&self, at: BurnOf, electrode: &Electrode, burn: &Burn) -> DVec3 {
        let raised = if self.selected == Some(at) { self.raised } else { 0.0 };
        let middle = self.opening.upright(self.mold.center());
        // Out of the mold by as much as they reach into it, and a little more.
        let up = self.exploded * (burn.depth + 0.2 * self.mold.size().length());
        let apart = 0.6 * self.exploded * (burn.position - middle).truncate();
        apart.extend(0.0) - (raised + up) * electrode.direction
    }

    /// Where a burn is shown, in the axes of the mesh.
    pub fn placement(&self, at: BurnOf) -> Option<DAffine3> {
        let (electrode, burn) = at.find(self.set)?;
        Some(placement(electrode, burn, self.off(at, electrode, burn), self.opening))
    }

    /// Box around a burn where it is shown, in the axes of the mesh (mm).
    pub fn bounds(&self, at: BurnOf) -> Option<Bounds> {
        let shape = self.shapes.get(at.electrode)?;
        Some(Object::new(at.id(), shape.shape.clone(), BAD).at(self.placement(at)?).bounds())
    }

    /// Adds them to the scene of their mold.
    pub fn add_to(&self, scene: &mut Scene) {
        for (e, (electrode, shape)) in self.set.electrodes.iter().zip(self.shapes).enumerate() {
            let is_selected = self.selected.is_some_and(|at| at.electrode == e);
            for burn in 0..electrode.burns.len().min(BURNS as usize) {
                let at = BurnOf { electrode: e, burn };
                let is_it = self.selected == Some(at);
                if (self.is_alone && !is_it) || (!is_selected && electrode.stage != self.stage) {
                    continue;
                }
                let Some(placement) = self.placement(at) else { continue };
                let mut object = Object::new(at.id(), shape.shape.clone(), electrode_colour(self.set, e)).at(placement);
                object.selected = is_it && !self.is_alone;
                let is_beside =
                    self.exploded == 0.0 && self.selected.is_some_and(|selected| selected.electrode == e) && !is_it;
                // What is left where it burns is seen through it.
                let is_before_place = is_it && self.place.is_some();
                scene.objects.push(if is_beside || is_before_place { object.with_opacity(BESIDE) } else { object });
            }
        }
        if let Some(place) = self.place {
            scene.markers.push(Marker { at: self.opening.in_mesh(place), colour: BAD, radius_px: 7.0 });
        }
    }
}

/// A cut straight down through a burn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BurnCut {
    /// Whether it goes along Y of the upright mold, or else along X.
    pub along_y: bool,
    /// How far it is beside the middle of the lowest face (mm).
    pub beside: f64,
}

impl BurnCut {
    /// The axis of the upright mold that it is across of, towards the viewer.
    fn normal(self) -> DVec3 {
        if self.along_y { DVec3::X } else { DVec3::NEG_Y }
    }

    /// The point of the burn that it goes through, in the upright mold (mm).
    fn point(self, at: BurnOf, set: &ElectrodeSet, shapes: &[ElectrodeShape]) -> Option<DVec3> {
        let (electrode, burn) = at.find(set)?;
        let lowest = shapes.get(at.electrode)?.lowest;
        let turned = DVec2::from_angle(burn.turn).rotate(lowest.truncate()).extend(lowest.z);
        let point = burn.position + to_burn_frame(electrode.direction).transpose() * turned;
        Some(point + self.beside * self.normal())
    }

    /// The plane in the axes of the mesh; what is nearer to the viewer is taken away.
    pub fn plane(
        self,
        at: BurnOf,
        set: &ElectrodeSet,
        shapes: &[ElectrodeShape],
        opening: Opening,
    ) -> Option<SectionPlane> {
        let point = opening.in_mesh(self.point(at, set, shapes)?);
        Some(SectionPlane { point, normal: opening.in_mesh(self.normal()) })
    }

    /// Straight onto it, close enough to see the gap.
    pub fn camera(self, at: BurnOf, set: &ElectrodeSet, shapes: &[ElectrodeShape], opening: Opening) -> Option<Camera> {
        let plane = self.plane(at, set, shapes, opening)?;
        let depth = at.find(set)?.1.depth.max(0.1);
        let up = opening.in_mesh(DVec3::Z);
        Some(onto_section(&plane, up, plane.point + SECTION_MIDDLE * depth * up, SECTION_DEPTHS * depth))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use mold::electrode::base::Base;
    use mold::electrode::params::Method;

    fn electrode(direction: DVec3) -> Electrode {
        let position = DVec3::new(5.0, -2.0, 20.0);
        let burn = Burn { position, turn: 0.7, parts: Vec::new(), depth: 6.0, volume: 1.0, heads: None, minutes: None };
        let mesh = Mesh::cuboid(DVec3::new(2.0, 3.0, 4.0)).mapped(|p| p - DVec3::new(1.0, 1.5, 4.0));
        Electrode {
            name: "E01".to_owned(),
            number: 0,
            stage: 0,
            tips: mesh.clone(),
            mesh,
            burns: vec![burn],
            direction,
            method: Method::Cutting,
            blank: DVec3::ONE,
            holder: None,
            figures: Default::default(),
            needed: None,
            is_thin: false,
            front_area: 1.0,
            burn_area: 1.0,
            base: Base { sides: DVec2::ONE, is_round: false, height: 1.0, corner: 0.0 },
            family: Default::default(),
            others: Default::default(),
            material: None,
            unmet: Vec::new(),
            other_way: None,
        }
    }

    #[test]
    fn an_electrode_is_shown_where_the_computation_has_it_burn() {
        for (direction, opening) in [(DVec3::NEG_Z, Opening::MinusY), (DVec3::new(0.6, 0.0, -0.8), Opening::PlusX)] {
            let electrode = electrode(direction);
            let burn = &electrode.burns[0];
            let turned = to_burn_frame(direction);
            let placed = electrode.burning(&electrode.mesh, burn, &turned);
            let shown = placement(&electrode, burn, DVec3::ZERO, opening);
            for (own, there) in electrode.mesh.vertices.iter().zip(&placed.vertices) {
                let exact = opening.in_mesh(turned.transpose() * *there);
                assert!(shown.transform_point3(*own).distance(exact) < 1e-9);
            }
            let lifted = placement(&electrode, burn, -2.0 * direction, opening);
            let way = lifted.translation - shown.translation;
            assert!((opening.upright(way) + 2.0 * direction).length() < 1e-9, "out along the burn: {way}");
        }
    }

    #[test]
    fn the_way_goes_down_burns_and_comes_out_again() {
        let burn = electrode(DVec3::NEG_Z).burns.remove(0);
        let way = BurnWay::of(&burn, 30.0);
        let at = |t: f64| way.at(t);
        assert_eq!([at(0.0), at(1.0)], [(BurnPhase::Approach, 30.0), (BurnPhase::Lift, 30.0)]);
        assert_eq!(at(1.5 / 3.0), (BurnPhase::Burn, 3.0));
        assert!(at(1.0 / 3.0).1 - 6.0 < 1e-9 && at(2.0 / 3.0).1 < 1e-9);
        assert_eq!(BurnWay::of(&burn, 0.0).lift, 6.0, "it is out of the mold before it goes anywhere");
    }

    #[test]
    fn objects_tell_which_burn_they_are() {
        let at = BurnOf { electrode: 12, burn: 34 };
        assert_eq!((BurnOf::of(at.id()), BurnOf::of(ObjectId(FIRST - 1))), (Some(at), None));
        assert!((lowest(&electrode(DVec3::NEG_Z).tips).z + 4.0).abs() < 1e-12);
    }
}
