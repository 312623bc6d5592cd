//! The pictures that explain a plan: the whole blisk with the electrodes before it, and of each electrode its final
//! pose, its way, and a section through the place where it comes closest or jams.

use std::sync::Arc;

use glam::DVec3;

use super::residual_stock::{colour_limit, greatest, residual_stock_legend, unfolded};
use super::shapes::{ChannelShapes, channel_shapes};
use super::sweep::{COARSE, swept_shape};
use super::track::Track;
use crate::widgets::camera::PICTURE_SIZE;
use crate::widgets::camera::{bodies, electrode_in_channel, from_entry, onto_section};
use crate::workspaces::blisk::document::choice::DrawnPictures;
use crate::workspaces::blisk::job::measured::MeasuredWalls;
use crate::workspaces::blisk::scene::{Layer, Layers, SceneInputs, build, layer_id};
use feed::plan::FeedPlan;
use feed::residual_stock::{DeviationMap, ResidualStock};
use geometry::mesh::Mesh;
use geometry::swept::SweptError;
use render::camera::Camera;
use render::colour::{Colour, Theme};
use render::mesh::RenderMesh;
use render::scene::{Scene, SectionPlane};
use task::{Cancelled, Task};
use wheel::channel::{Channel, Flow, Surface};
use wheel::electrode::{Electrode, EntrySide};

/// How solid the other poses of an electrode are.
const GHOST_OPACITY: f32 = 0.13;
/// How solid the room is that an electrode passes through.
const ROOM_OPACITY: f32 = 0.42;
/// Height of the picture of a section as a multiple of the channel's throat, so that a spark gap is some pixels wide.
const SECTION_THROATS: f64 = 1.5;

/// A plan to be shown.
pub struct PlanToShow<'a> {
    /// The blisk in the axes of its file (mm).
    pub blisk: &'a Mesh,
    /// Channel of the blisk.
    pub channel: &'a Channel,
    /// The electrodes with their plans, in the order of the report.
    pub electrodes: Vec<(&'a Electrode, &'a FeedPlan)>,
    /// Stock that the electrodes leave, if that is known.
    pub residual_stock: Option<&'a ResidualStock>,
    /// The measured sections that the blisk was made from, if it was.
    pub measured: Option<&'a MeasuredWalls>,
    /// Spark gap (mm).
    pub spark_gap: f64,
}

/// A picture to be drawn.
pub struct PlanPicture {
    /// Name of its file.
    pub file: String,
    /// Title: the content of the picture in a few words.
    pub title: String,
    /// What is to be seen in it.
    pub caption: String,
    /// Colours of the picture and what they stand for.
    pub legend: Vec<(Colour, &'static str)>,
    /// What is drawn.
    pub scene: Scene,
    /// Camera of the picture.
    pub camera: Camera,
}

/// The pictures of a plan in the order in which they explain it. Takes seconds for every electrode.
///
/// # Errors
/// When told to stop.
pub fn plan_pictures(plan: &PlanToShow, wanted: &DrawnPictures, task: &Task) -> Result<Vec<PlanPicture>, Cancelled> {
    let drawn = Drawn::new(plan, wanted, task)?;
    let mut pictures = Vec::from_iter(wanted.whole.then(|| drawn.whole()));
    pictures.extend(plan.residual_stock.filter(|_| wanted.residual_stock).map(|left| drawn.residual_stock(left)));
    pictures.extend(plan.measured.filter(|_| wanted.whole).map(|walls| drawn.measured(walls)));
    for i in 0..plan.electrodes.len() {
        pictures.extend(wanted.final_pose.then(|| drawn.final_pose(i)));
        pictures.extend(wanted.sweep.then(|| drawn.sweep(i)));
        pictures.extend(wanted.closest.then(|| drawn.closest(i)).flatten());
    }
    Ok(pictures)
}

/// What the pictures of a plan share.
struct Drawn<'a> {
    plan: &'a PlanToShow<'a>,
    blisk: Arc<RenderMesh>,
    shapes: ChannelShapes,
    electrodes: Vec<Arc<RenderMesh>>,
    tracks: Vec<Track>,
    /// The room that each passes through, where it could be made.
    swept: Vec<Option<Arc<RenderMesh>>>,
    layers: Layers,
}

impl<'a> Drawn<'a> {
    fn new(plan: &'a PlanToShow<'a>, wanted: &DrawnPictures, task: &Task) -> Result<Self, Cancelled> {
        let mut layers = Layers::default();
        // The ground of a drawing; on paper it says nothing, and the blisk's axes may stand askew to it.
        for layer in [Layer::Grid, Layer::Contact, Layer::Paths] {
            layers.get_mut(layer).visible = false;
        }
        let tracks: Vec<Track> = plan.electrodes.iter().map(|(_, p)| Track::of_plan(p)).collect();
        let room = |((electrode, _), track): (&(&Electrode, _), &Track)| {
            match swept_shape(electrode, track, COARSE, task) {
                Err(SweptError::Cancelled(cancelled)) => Err(cancelled),
                // A picture of poses tells as much.
                made => Ok(made.ok()),
            }
        };
        // Seconds for each: only for those that are looked at.
        let looked_at = if wanted.sweep { &plan.electrodes[..] } else { &[] };
        let swept = looked_at.iter().zip(&tracks).map(room).collect::<Result<_, _>>()?;
        let electrodes = plan.electrodes.iter().map(|(e, _)| Arc::new(RenderMesh::for_pictures(&e.mesh))).collect();
        task.check()?;
        let blisk = Arc::new(RenderMesh::for_pictures(plan.channel.whole.as_deref().unwrap_or(plan.blisk)));
        task.check()?;
        let in_w = plan.channel.wheel_in_w(plan.blisk);
        let shapes = channel_shapes(&in_w, plan.channel, RenderMesh::for_pictures);
        Ok(Self { plan, blisk, shapes, electrodes, tracks, swept, layers })
    }

    /// Electrode `i` withdrawn by `s` (mm), with whatever `layers` show.
    fn scene(&self, i: usize, s: f64, layers: &Layers) -> Scene {
        let electrode = self.plan.electrodes.get(i).map(|(e, _)| *e).zip(self.electrodes.get(i));
        build(&SceneInputs {
            machine: &[],
            pose: None,
            blisk: Some(&self.blisk),
            channel: Some((self.plan.channel, &self.shapes)),
            electrode,
            track: self.tracks.get(i).filter(|t| !t.is_empty()),
            s,
            contact: self.place(i).map(|p| p.points),
            trouble: None,
            values: None,
            residual_stock: None,
            layers,
            selected: None,
            ghosts: &[],
            swept: self.room(i),
            triad: true,
            section: None,
            theme: Theme::LIGHT,
        })
    }

    /// The blisk with every electrode in the first pose of its track.
    fn whole(&self) -> PlanPicture {
        let (channel, count) = (self.plan.channel, self.plan.electrodes.len());
        let mut scene = self.scene(0, self.length(0), &self.layers);
        let mut without_blisk = self.layers.clone();
        without_blisk.get_mut(Layer::Blisk).visible = false;
        for i in 1..count {
            scene.objects.extend(self.scene(i, self.length(i), &without_blisk).objects);
        }
        let side = self.side(0);
        let (electrodes, stand) = if count == 1 { ("electrode", "stands") } else { ("electrodes", "stand") };
        PlanPicture {
            file: "view_1_whole.png".to_owned(),
            title: format!("The blisk and its {electrodes}"),
            caption: format!(
                "{} blades; channel {} is on top, seen from {}. The {electrodes} {stand} as far out as the plan goes.",
                channel.blades,
                channel.index,
                side_name(side)
            ),
            legend: self.legend(&[(Layer::Blisk, "finished blisk"), (Layer::Electrode, electrodes)]),
            camera: from_entry(channel, side, &scene, aspect()),
            scene,
        }
    }

    /// What is left on the surfaces of the channel.
    fn residual_stock(&self, left: &ResidualStock) -> PlanPicture {
        PlanPicture {
            file: "view_2_leftover.png".to_owned(),
            title: "Residual stock on the surfaces of the channel".to_owned(),
            ..self.unfolded_map(
                &left.map,
                self.plan.spark_gap,
                ["overcut", "as it should be", "residual stock"],
                &left.sentence(self.plan.channel),
            )
        }
    }

    /// What the measured sections are off, on the walls of the channel.
    fn measured(&self, walls: &MeasuredWalls) -> PlanPicture {
        PlanPicture {
            file: "view_3_sections.png".to_owned(),
            title: "Deviation of the measured sections from the walls".to_owned(),
            ..self.unfolded_map(
                &walls.map,
                walls.planned.limit_mm,
                ["blade too thin", "as planned", "blade too thick"],
                &format!(
                    "Of inner sections from the wall through the others, of the first and the last from the wall that is planned \
                     for; between them evenly. Positive into the channel. {}",
                    walls.sentence()
                ),
            )
        }
    }

    /// The surfaces of `map` side by side, in colours that end no earlier than at `least` (mm); `names` say what their least,
    /// middle and greatest stand for, `more` ends the caption.
    fn unfolded_map(&self, map: &DeviationMap, least: f64, names: [&'static str; 3], more: &str) -> PlanPicture {
        let channel = self.plan.channel;
        let limit = colour_limit(greatest(map), least);
        let (objects, around) = unfolded(map, channel, limit);
        let frame = &channel.frame;
        let (at, size) = (frame.to_parent(around.center()), around.size());
        let plane = SectionPlane { point: at, normal: frame.z };
        let height = 1.08 * size.x.max(size.y / aspect());
        // From the right to the left of the picture.
        let order = [Surface::HighWall, Surface::Hub, Surface::LowWall, Surface::Shroud];
        let is_there = |surface: &Surface| map.surfaces.contains(surface);
        let shown: Vec<&str> = order.into_iter().filter(is_there).map(|of| channel.surface_name(of)).collect();
        let upwards = if channel.flow == Flow::Axial { "X" } else { "the passage" };
        let colours = [0.0, 0.5, 1.0].map(|t| residual_stock_legend(limit).map.at(t));
        PlanPicture {
            file: String::new(),
            title: String::new(),
            caption: format!(
                "Unfolded and seen from within, {upwards} upwards; from the right {}. The colours end at {limit:.3} mm either \
                 way. {more}",
                shown.join(", ")
            ),
            legend: colours.into_iter().zip(names).collect(),
            scene: Scene { objects, triad: false, ..Scene::new(Theme::LIGHT) },
            camera: onto_section(&plane, frame.x, at, height),
        }
    }

    /// Electrode `i` at the end of its feed.
    fn final_pose(&self, i: usize) -> PlanPicture {
        let mut layers = self.layers.clone();
        layers.into_channel();
        let scene = self.scene(i, 0.0, &layers);
        PlanPicture {
            file: format!("electrode_{}_final.png", i + 1),
            title: format!("Electrode {} in its final pose", self.plan.electrodes[i].0.label(i)),
            caption: format!(
                "The shroud is taken away to look into the channel. A clearance of {:.3} mm is required all round.",
                self.plan.electrodes[i].0.undersize_mm
            ),
            legend: self.legend(&[(Layer::Unshrouded, "finished blisk"), (Layer::Electrode, "electrode")]),
            camera: self.camera(i, &scene),
            scene,
        }
    }

    /// Poses of electrode `i` along its way, and the electrode where it comes closest or jams.
    fn sweep(&self, i: usize) -> PlanPicture {
        let mut layers = self.layers.clone();
        layers.into_channel();
        let (others, name, opacity) = match self.room(i) {
            Some(_) => (Layer::Sweep, "swept volume", ROOM_OPACITY),
            None => (Layer::Ghosts, "other poses", GHOST_OPACITY),
        };
        for layer in [others, Layer::Contact] {
            layers.get_mut(layer).visible = true;
        }
        layers.get_mut(others).opacity = opacity;
        let place = self.place(i);
        let mut legend = vec![(Layer::Unshrouded, "finished blisk"), (Layer::Electrode, "electrode"), (others, name)];
        legend.extend(place.as_ref().map(|p| (Layer::Contact, p.name)));
        let scene = self.scene(i, place.as_ref().map_or(0.0, |p| p.s), &layers);
        PlanPicture {
            file: format!("electrode_{}_sweep.png", i + 1),
            title: format!("Electrode {} on its path", self.plan.electrodes[i].0.label(i)),
            caption: self.sweep_caption(i, place.as_ref()),
            legend: self.legend(&legend),
            camera: self.camera(i, &scene),
            scene,
        }
    }

    /// A section through the place where electrode `i` comes closest or jams, if there is one.
    fn closest(&self, i: usize) -> Option<PlanPicture> {
        let place = self.place(i)?;
        let mut layers = self.layers.clone();
        layers.get_mut(Layer::Contact).visible = true;
        let (plane, up, along) = self.section(i, &place);
        let height = SECTION_THROATS * self.plan.channel.throat.width_mm;
        // Of hub and shroud there is more than enough to be seen.
        let raised = match place.surface {
            Surface::Hub => 0.3 * height,
            Surface::Shroud => -0.3 * height,
            Surface::LowWall | Surface::HighWall | Surface::Elsewhere | Surface::Obstacle => 0.0,
        };
        let mut scene = self.scene(i, place.s, &layers);
        scene.section = Some(plane);
        Some(PlanPicture {
            file: format!("electrode_{}_closest.png", i + 1),
            title: format!("Electrode {} {}", self.plan.electrodes[i].0.label(i), place.name),
            caption: format!(
                "Section through the {} at this place, seen along {along}; the picture is {:.1} mm wide.",
                self.plan.channel.surface_name(place.surface),
                height * aspect()
            ),
            legend: self.legend(&[
                (Layer::Blisk, "finished blisk"),
                (Layer::Electrode, "electrode"),
                (Layer::Contact, place.name),
            ]),
            camera: onto_section(&plane, up, plane.point + up * raised, height),
            scene,
        })
    }

    /// The section through `place`, the direction that is up in it, and along what it is seen: across the surface that
    /// is near, which for a wall means from outside, and otherwise from the side of entry.
    fn section(&self, i: usize, place: &Place) -> (SectionPlane, DVec3, &'static str) {
        let frame = &self.plan.channel.frame;
        let [_, at] = place.points;
        let radius = DVec3::new(0.0, at.y, at.z).normalize_or(DVec3::Z);
        let axis = DVec3::X * self.side(i).sign();
        let (normal, up, along) = match place.surface {
            Surface::LowWall | Surface::HighWall => (radius, radius.cross(DVec3::X), "the radius"),
            Surface::Hub | Surface::Shroud | Surface::Elsewhere | Surface::Obstacle => (axis, radius, "the axis"),
        };
        let plane = SectionPlane { point: frame.to_parent(at), normal: frame.direction_to_parent(normal) };
        (plane, frame.direction_to_parent(up), along)
    }

    fn sweep_caption(&self, i: usize, place: Option<&Place>) -> String {
        let Some((electrode, plan)) = self.plan.electrodes.get(i) else { return String::new() };
        let side = side_name(electrode.enters_from);
        if plan.jam.is_some() {
            let mark = if place.is_some() { " The red dot marks the place." } else { "" };
            let verdict = plan.verdict(self.plan.channel);
            return format!("Retracted towards {side}, the electrode {verdict}. It is shown there.{mark}");
        }
        let Some(least) = plan.path.as_ref().map(|p| p.certificate.least()) else { return String::new() };
        format!(
            "Its path from {side} to the final pose. The solid one is at the smallest clearance (red dot): {:.4} mm \
             to the {}, {}.",
            least.distance,
            self.plan.channel.surface_name(least.surface),
            if least.s > 0.0 {
                format!("{:.2} mm before the final pose", least.s)
            } else {
                "in the final pose".to_owned()
            }
        )
    }

    /// Where electrode `i` jams or comes closest, if there is such a place.
    fn place(&self, i: usize) -> Option<Place> {
        let plan = self.plan.electrodes.get(i)?.1;
        if let Some(jam) = &plan.jam {
            let contact = jam.contact()?;
            let points = [contact.on_electrode, contact.on_blisk];
            return Some(Place { s: jam.s, points, surface: contact.surface, name: "where it jams" });
        }
        let least = plan.path.as_ref()?.certificate.least();
        let points = [least.on_electrode, least.on_blisk];
        Some(Place { s: least.s, points, surface: least.surface, name: "at the smallest clearance" })
    }

    fn room(&self, i: usize) -> Option<&Arc<RenderMesh>> {
        self.swept.get(i)?.as_ref()
    }

    fn length(&self, i: usize) -> f64 {
        self.tracks.get(i).map_or(0.0, Track::length)
    }

    fn side(&self, i: usize) -> EntrySide {
        self.plan.electrodes.get(i).map_or(EntrySide::MinusX, |(e, _)| e.enters_from)
    }

    /// Into the channel, with every pose of electrode `i` that `scene` shows.
    fn camera(&self, i: usize, scene: &Scene) -> Camera {
        let moved = [Layer::Electrode, Layer::Ghosts, Layer::Sweep].map(layer_id);
        let objects = scene.objects.iter().filter(|o| moved.contains(&o.id)).cloned().collect();
        let electrode = bodies(&Scene { objects, ..Scene::default() });
        electrode_in_channel(self.plan.channel, self.side(i), &electrode, aspect())
    }

    fn legend(&self, layers: &[(Layer, &'static str)]) -> Vec<(Colour, &'static str)> {
        layers.iter().map(|(layer, name)| (self.layers.get(*layer).colour, *name)).collect()
    }
}

/// A place worth a dot.
struct Place {
    /// Withdrawn distance (mm).
    s: f64,
    /// On the electrode in its final pose and on the blisk, in W (mm).
    points: [DVec3; 2],
    /// Surface of the blisk that the place is on.
    surface: Surface,
    /// Name of the place.
    name: &'static str,
}

fn aspect() -> f64 {
    let [width, height] = PICTURE_SIZE.map(f64::from);
    width / height
}

fn side_name(side: EntrySide) -> &'static str {
    match side {
        EntrySide::MinusX => "\u{2212}x",
        EntrySide::PlusX => "+x",
        EntrySide::Outward => "the rim",
        EntrySide::Inward => "the bore",
    }
}
