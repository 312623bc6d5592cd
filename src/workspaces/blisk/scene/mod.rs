//! The scene of a job: which bodies are shown, where, and in which colours.

pub mod caps;
pub mod machine;
pub mod passage;
pub mod pictures;
pub mod residual_stock;
pub mod scan;
pub mod shapes;
pub mod surfaces;
pub mod sweep;
pub mod track;

use std::sync::Arc;

use glam::{DAffine3, DMat3, DVec3};

use crate::widgets::theme::{BAD, COPPER, GHOST, HIGH, LOW, MACHINE, PASSAGE, STEEL};
use crate::workspaces::blisk::scene::machine::MachineBody;
use crate::workspaces::blisk::scene::shapes::ChannelShapes;
use crate::workspaces::blisk::scene::track::{Station, Track};
use feed::pose::Pose;
use geometry::frame::Frame;
use render::colour::{Colour, Theme};
use render::mesh::RenderMesh;
use render::scene::{Grid, LineSet, Marker, Object, ObjectId, Scene, SectionPlane, SurfaceValues};
use wheel::channel::Channel;
use wheel::electrode::Electrode;

/// Something that can be shown or hidden as a whole.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Layer {
    /// The whole blisk.
    Blisk,
    /// The blisk without its shroud.
    Unshrouded,
    /// The low wall of the channel.
    LowWall,
    /// The high wall of the channel.
    HighWall,
    /// The electrode in the pose of the cursor.
    Electrode,
    /// The electrode at some of the nodes.
    Ghosts,
    /// The room that the electrode passes through.
    Sweep,
    /// The ways of some points of the electrode.
    Paths,
    /// The centreline of the channel.
    Centreline,
    /// Hub and shroud curves, stations, inlet and outlet of the channel.
    Passage,
    /// Where the electrode comes closest, or jams.
    Contact,
    /// Head, holder, table and bed.
    Machine,
    /// The grid below.
    Grid,
}

impl Layer {
    /// Every layer, in the order of the scene tree.
    pub const ALL: [Self; 13] = [
        Self::Blisk,
        Self::Unshrouded,
        Self::LowWall,
        Self::HighWall,
        Self::Electrode,
        Self::Ghosts,
        Self::Sweep,
        Self::Paths,
        Self::Centreline,
        Self::Passage,
        Self::Contact,
        Self::Machine,
        Self::Grid,
    ];

    /// Name of the part for a reader.
    pub fn name(self) -> &'static str {
        match self {
            Self::Blisk => "Blisk",
            Self::Unshrouded => "Without shroud",
            Self::LowWall => "Low wall",
            Self::HighWall => "High wall",
            Self::Electrode => "Electrode",
            Self::Ghosts => "Previous positions",
            Self::Sweep => "Swept volume",
            Self::Paths => "Point paths",
            Self::Centreline => "Centreline",
            Self::Passage => "Passage",
            Self::Contact => "Contact",
            Self::Machine => "Machine",
            Self::Grid => "Grid",
        }
    }

    /// Whether the layer consists of bodies, which have a colour and an opacity.
    pub fn is_body(self) -> bool {
        !matches!(self, Self::Paths | Self::Centreline | Self::Passage | Self::Contact | Self::Grid)
    }
}

/// Visibility, opacity and colour of a layer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Look {
    /// Whether the layer is shown.
    pub visible: bool,
    /// 1 is solid.
    pub opacity: f32,
    /// Colour of the part.
    pub colour: Colour,
}

/// How every layer looks.
#[derive(Debug, Clone, PartialEq)]
pub struct Layers([Look; Layer::ALL.len()]);

impl Default for Layers {
    fn default() -> Self {
        let look = |visible, opacity, colour| Look { visible, opacity, colour };
        Self([
            look(true, 1.0, STEEL),
            look(false, 1.0, STEEL),
            look(false, 1.0, LOW),
            look(false, 1.0, HIGH),
            look(true, 1.0, COPPER),
            look(false, 0.18, GHOST),
            look(false, 0.5, GHOST),
            look(true, 1.0, COPPER),
            look(false, 1.0, GHOST),
            look(true, 1.0, PASSAGE),
            look(true, 1.0, BAD),
            look(true, 0.55, MACHINE),
            look(true, 1.0, STEEL),
        ])
    }
}

impl Layers {
    /// How `layer` looks.
    pub fn get(&self, layer: Layer) -> &Look {
        &self.0[layer as usize]
    }

    /// How `layer` looks, to be changed.
    pub fn get_mut(&mut self, layer: Layer) -> &mut Look {
        &mut self.0[layer as usize]
    }

    /// Shows `layer` and hides every other body.
    pub fn isolate(&mut self, layer: Layer) {
        for other in Layer::ALL.into_iter().filter(|l| l.is_body()) {
            self.get_mut(other).visible = other == layer;
        }
    }

    /// What serves best to look into the channel: the blisk without its shroud, and the electrode.
    pub fn into_channel(&mut self) {
        for (layer, visible) in [(Layer::Blisk, false), (Layer::Unshrouded, true), (Layer::Electrode, true)] {
            self.get_mut(layer).visible = visible;
        }
    }

    /// The whole blisk as a solid.
    pub fn whole_blisk(&mut self) {
        *self.get_mut(Layer::Blisk) = *Self::default().get(Layer::Blisk);
        self.get_mut(Layer::Unshrouded).visible = false;
    }
}

/// What a scene is made from. What is not there yet is not shown.
#[derive(Clone, Copy)]
pub struct SceneInputs<'a> {
    /// The whole blisk in the axes of its file.
    pub blisk: Option<&'a Arc<RenderMesh>>,
    /// The channel and its shapes.
    pub channel: Option<(&'a Channel, &'a ChannelShapes)>,
    /// The electrode and its shape.
    pub electrode: Option<(&'a Electrode, &'a Arc<RenderMesh>)>,
    /// Poses of the electrode.
    pub track: Option<&'a Track>,
    /// The bodies of the machine.
    pub machine: &'a [MachineBody],
    /// A pose of the whole motion that the machine is shown in, instead of that of the track.
    pub pose: Option<Pose>,
    /// Withdrawn distance of the cursor (mm).
    pub s: f64,
    /// Withdrawn distances at which ghosts are shown (mm); if there are none, at some evenly along the way.
    pub ghosts: &'a [f64],
    /// The room that it passes through, in W; without it many poses stand in for it.
    pub swept: Option<&'a Arc<RenderMesh>>,
    /// Where it comes closest or jams: a point of the electrode in its final pose and one of the blisk, in W.
    pub contact: Option<[DVec3; 2]>,
    /// Where two bodies meet on the machine: a point of each, in W at that instant. It is shown instead of the contact.
    pub trouble: Option<[DVec3; 2]>,
    /// A quantity on the electrode.
    pub values: Option<&'a SurfaceValues>,
    /// What stock is left on the surfaces of the channel, or what measured sections are off.
    pub residual_stock: Option<(&'a Arc<RenderMesh>, &'a SurfaceValues)>,
    /// How things look.
    pub layers: &'a Layers,
    /// What is selected.
    pub selected: Option<Layer>,
    /// A cut.
    pub section: Option<SectionPlane>,
    /// Colours of the surroundings.
    pub theme: Theme,
    /// Whether the axes are shown in a corner.
    pub triad: bool,
}

/// The name of a layer's bodies in a scene.
pub fn layer_id(layer: Layer) -> ObjectId {
    ObjectId(layer as u32)
}

/// The layer that a body of a scene belongs to.
pub fn layer_of(id: ObjectId) -> Option<Layer> {
    Layer::ALL.get(id.0 as usize).copied()
}

/// The scene, in the coordinates of the loaded mesh.
pub fn build(inputs: &SceneInputs) -> Scene {
    let mut scene = Scene { triad: inputs.triad, ..Scene::new(inputs.theme) };
    let layers = inputs.layers;
    let add = |scene: &mut Scene, layer: Layer, mesh: &Arc<RenderMesh>, at: DAffine3| {
        let look = layers.get(layer);
        if look.visible {
            let object = Object::new(layer_id(layer), mesh.clone(), look.colour).at(at).with_opacity(look.opacity);
            // The edges of a swept room are seldom sharp, and those of many poses would be a thicket.
            let object = Object { edges: layer != Layer::Sweep, ..object };
            scene.objects.push(Object { selected: inputs.selected == Some(layer), ..object });
        }
    };
    if let Some(blisk) = inputs.blisk {
        add(&mut scene, Layer::Blisk, blisk, DAffine3::IDENTITY);
    }
    let to_mesh = inputs.channel.map_or(DAffine3::IDENTITY, |(channel, _)| from_w(&channel.frame));
    if let Some((_, shapes)) = inputs.channel {
        add(&mut scene, Layer::Unshrouded, &shapes.unshrouded, to_mesh);
        add(&mut scene, Layer::LowWall, &shapes.low, to_mesh);
        add(&mut scene, Layer::HighWall, &shapes.high, to_mesh);
        let look = layers.get(Layer::Centreline);
        if look.visible && shapes.centreline.len() > 1 {
            let line = shapes.centreline.iter().map(|p| to_mesh.transform_point3(*p)).collect();
            scene.lines.push(LineSet { on_top: true, width_px: 2.0, ..LineSet::new(vec![line], look.colour) });
        }
    }
    if let Some((map, values)) = inputs.residual_stock {
        let object = Object::new(layer_id(Layer::Unshrouded), map.clone(), STEEL).at(to_mesh);
        scene.objects.push(Object { edges: false, values: Some(values.clone()), ..object });
    }
    if let Some((electrode, mesh)) = inputs.electrode {
        let station = inputs.track.and_then(|t| t.at(inputs.s));
        let placed = |station: &Station| to_mesh * station.pose.placement(electrode.reference_point);
        let o = electrode.reference_point;
        let pose = inputs.pose.or(station.as_ref().map(|s| s.pose)).unwrap_or_default();
        let here = to_mesh * pose.placement(o);
        for body in inputs.machine {
            let before = scene.objects.len();
            add(&mut scene, Layer::Machine, &body.shape, to_mesh * body.placement(&pose));
            if body.is_in_the_way {
                scene.objects[before..].iter_mut().for_each(|object| object.colour = BAD);
            }
        }
        add(&mut scene, Layer::Electrode, mesh, here);
        if let Some(object) = scene.objects.iter_mut().find(|o| o.id == layer_id(Layer::Electrode)) {
            object.values = inputs.values.cloned();
        }
        if let Some(track) = inputs.track {
            let chosen: Vec<Station> = inputs.ghosts.iter().filter_map(|s| track.at(*s)).collect();
            let ghosts = if chosen.is_empty() { spaced(track, 12) } else { chosen };
            ghosts.iter().for_each(|station| add(&mut scene, Layer::Ghosts, mesh, placed(station)));
            match inputs.swept {
                Some(swept) => add(&mut scene, Layer::Sweep, swept, to_mesh),
                None => {
                    let poses = spaced(track, 60);
                    poses.iter().for_each(|station| add(&mut scene, Layer::Sweep, mesh, placed(station)));
                }
            }
            lines(&mut scene, inputs, electrode, track, to_mesh);
        }
        match inputs.trouble {
            Some(points) => trouble(&mut scene, inputs, points.map(|p| to_mesh.transform_point3(p))),
            None => contact(&mut scene, inputs, electrode, &pose, to_mesh),
        }
    }
    scene.section = inputs.section;
    if layers.get(Layer::Grid).visible {
        scene.grid = Grid::below(&scene.bounds());
    }
    scene
}

/// Map from W to the coordinates of the loaded mesh.
pub(crate) fn from_w(frame: &Frame) -> DAffine3 {
    DAffine3 { matrix3: DMat3::from_cols(frame.x, frame.y, frame.z), translation: frame.origin }
}

/// About `count` of the track's stations, evenly along the way, the first and the last among them.
fn spaced(track: &Track, count: usize) -> Vec<Station> {
    let steps = count.max(2) - 1;
    (0..=steps).filter_map(|i| track.at(track.length() * i as f64 / steps as f64)).collect()
}

/// The ways of the middle of the burning part, P0's centroid, and of its far end.
fn lines(scene: &mut Scene, inputs: &SceneInputs, electrode: &Electrode, track: &Track, to_mesh: DAffine3) {
    if !inputs.layers.get(Layer::Paths).visible {
        return;
    }
    let o = electrode.reference_point;
    let bounds = electrode.mesh.bounds();
    let direction = electrode.enters_from.direction();
    let far = o + direction * (bounds.min.dot(direction).min(bounds.max.dot(direction)) - o.dot(direction));
    let points = [electrode.middle(), far];
    let colour = inputs.layers.get(Layer::Paths).colour;
    let polylines = points
        .iter()
        .map(|p| track.stations().iter().map(|s| to_mesh.transform_point3(s.pose.placement(o).transform_point3(*p))))
        .map(Iterator::collect::<Vec<_>>)
        .filter(|line| line.len() > 1)
        .collect();
    scene.lines.push(LineSet { on_top: true, width_px: 1.5, ..LineSet::new(polylines, colour) });
}

fn contact(scene: &mut Scene, inputs: &SceneInputs, electrode: &Electrode, pose: &Pose, to_mesh: DAffine3) {
    let look = inputs.layers.get(Layer::Contact);
    let (Some([on_electrode, on_blisk]), true) = (inputs.contact, look.visible) else { return };
    let moved = pose.placement(electrode.reference_point).transform_point3(on_electrode);
    let [a, b] = [moved, on_blisk].map(|p| to_mesh.transform_point3(p));
    scene.markers.push(Marker { at: b, colour: look.colour, radius_px: 5.0 });
    // Elsewhere on the path the point of the electrode has nothing to do with the place.
    if a.distance(b) < 2.0 {
        scene.lines.push(LineSet { on_top: true, width_px: 1.5, ..LineSet::new(vec![vec![a, b]], look.colour) });
        scene.markers.push(Marker { at: a, colour: COPPER, radius_px: 3.5 });
    }
}

/// Where two bodies meet on the machine.
fn trouble(scene: &mut Scene, inputs: &SceneInputs, points: [DVec3; 2]) {
    let look = inputs.layers.get(Layer::Contact);
    if !look.visible {
        return;
    }
    let [moving, fixed] = points;
    scene.lines.push(LineSet { on_top: true, width_px: 1.5, ..LineSet::new(vec![vec![moving, fixed]], look.colour) });
    scene.markers.push(Marker { at: fixed, colour: look.colour, radius_px: 5.0 });
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::mesh::Mesh;
    use wheel::fixtures::exact_channel;
    use wheel::parametric::ParametricBlisk;

    #[test]
    fn the_centreline_is_a_line_where_its_layer_is_shown() {
        let channel = exact_channel(&ParametricBlisk::turbine());
        let empty = || Arc::new(RenderMesh::new(&Mesh { vertices: Vec::new(), triangles: Vec::new() }));
        let points = vec![DVec3::new(1.0, 2.0, 100.0), DVec3::new(9.0, 0.0, 101.0)];
        let shapes = ChannelShapes {
            low: empty(),
            high: empty(),
            unshrouded: empty(),
            centreline: points.clone(),
            passage: Default::default(),
        };
        let mut layers = Layers::default();
        let lines = |layers: &Layers| {
            let inputs = SceneInputs {
                residual_stock: None,
                blisk: None,
                channel: Some((&channel, &shapes)),
                electrode: None,
                track: None,
                machine: &[],
                pose: None,
                s: 0.0,
                ghosts: &[],
                swept: None,
                contact: None,
                trouble: None,
                values: None,
                layers,
                selected: None,
                section: None,
                theme: Theme::DARK,
                triad: false,
            };
            build(&inputs).lines
        };
        assert!(lines(&layers).is_empty(), "hidden at first");
        layers.get_mut(Layer::Centreline).visible = true;
        let shown = lines(&layers);
        assert_eq!(shown.len(), 1);
        for (p, q) in shown[0].polylines[0].iter().zip(&points) {
            assert!((channel.frame.from_parent(*p) - *q).length() < 1e-9, "in the coordinates of the mesh");
        }
    }
}
