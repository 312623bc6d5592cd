//! The electrode as shown: its pose, its colours, and the bodies around it.

use std::sync::Arc;

use glam::DVec3;

use super::machine_motion::Trouble;
use super::{BliskDesk, TrackSource};
use crate::workspaces::blisk::document::choice::MeshFrame;
use crate::workspaces::blisk::document::machine_file::read_machine;
use crate::workspaces::blisk::document::stage::Stage;
use crate::workspaces::blisk::job::measured::MeasuredWalls;
use crate::workspaces::blisk::job::planned::PartialPlan;
use crate::workspaces::blisk::job::preview::Looked;
use crate::workspaces::blisk::job::stages::FoundChannel;
use crate::workspaces::blisk::scene::Layer;
use crate::workspaces::blisk::scene::machine::{BodyShape, MachineBody, Moment, body_shapes};
use crate::workspaces::blisk::scene::residual_stock::{DEVIATION, MapShape, SCANNED, colour_limit, map_legend};
use crate::workspaces::commands::FrameCommand;
use crate::workspaces::context::Context;
use crate::workspaces::message::ElectrodePart;
use crate::workspaces::news::EventKind;
use feed::machine::Mounting;
use feed::machine_model::Station;
use feed::pose::Pose;
use feed::preset::Preset;
use feed::simulation::Simulation;
use geometry::distance_field::DistanceField;
use render::colour_map::{ColourMap, Legend};
use render::mesh::RenderMesh;
use render::scene::{SectionPlane, SurfaceValues};
use task::{Priority, Refusal, Same, State};
use wheel::electrode::Electrode;

/// The bodies of the machine in their places, with the state that they belong to.
#[derive(Default)]
pub(super) struct Stood(Option<About>, Arc<Vec<MachineBody>>);

/// State that the places of the bodies belong to.
#[derive(PartialEq)]
struct About {
    bodies: Same<Vec<BodyShape>>,
    shape: Same<RenderMesh>,
    channel: Same<FoundChannel>,
    mounting: Mounting,
    preset: Option<Preset>,
    simulation: Option<Same<Simulation>>,
}

impl BliskDesk {
    /// The moment of the whole motion on the machine that is shown, unless a pose of the track is.
    pub fn moment(&self) -> Option<Moment> {
        self.machine.shown().filter(|_| !self.is_tuning() && self.searched().is_none())
    }

    /// Retract distance of the electrode on the track (mm); none while the machine is shown off the feed.
    pub fn feed_cursor(&self) -> Option<f64> {
        self.moment().map_or(Some(self.cursor.s), |moment| moment.s)
    }

    /// Shows the whole motion at `way`. The cursor follows where that is on the feed.
    pub fn go_to_moment(&mut self, way: f64) {
        self.cursor.playing = false;
        self.machine.go_to(Some(way));
        self.follow_moment();
    }

    pub(super) fn follow_moment(&mut self) {
        if let Some(s) = self.moment().and_then(|moment| moment.s) {
            self.cursor.s = s.min(self.track.length());
        }
    }

    /// The bodies of the machine around the electrode that is shown.
    pub fn machine_bodies(&self) -> &Arc<Vec<MachineBody>> {
        &self.stood.1
    }

    /// Reads the machine of the parameters, and places its bodies for the electrode that is shown.
    pub(super) fn follow_bodies(&mut self, cx: &mut Context) {
        while let Some(ended) = self.bodies.take() {
            if let Err(Refusal::Failed(why)) = ended.result {
                cx.say(EventKind::Failed, format!("the machine is not shown: {why}"));
            }
        }
        let machine = &self.document.params().machine;
        let wanted = machine.has_bodies().then(|| (machine.name.clone(), self.work.reloads()));
        if let Some(key) = &wanted {
            let name = key.0.clone();
            self.bodies.ask(key, Priority::Shown, move |work| {
                let model = read_machine(&name, &work.task).map_err(|e| e.to_string())?;
                Ok(body_shapes(&model))
            });
        }
        let about = wanted.and_then(|key| self.about(self.bodies.get(&key)?));
        if about != self.stood.0 {
            let bodies = about.as_ref().map(|about| self.standing(about)).unwrap_or_default();
            self.stood = Stood(about, Arc::new(bodies));
        }
    }

    fn about(&self, bodies: &Arc<Vec<BodyShape>>) -> Option<About> {
        let machine = &self.document.params().machine;
        let shown = self.shown_electrode().filter(|(electrode, _)| machine.comes_from(electrode.enters_from));
        let ((electrode, shape), channel) = shown.zip(self.work.channel())?;
        let mounting = machine.mounting(electrode.enters_from);
        // What was in the way of an earlier electrode may not be in the way of this one.
        let is_current = self.work.state(Stage::Plan) == State::Ready;
        let simulation = self.machine.simulation().filter(|_| is_current).cloned().map(Same);
        let planned = self.outcome().filter(|_| is_current);
        let preset = planned.filter(|o| std::ptr::eq(&o.electrode, electrode)).and_then(|o| o.preset);
        let (bodies, shape, channel) = (Same(bodies.clone()), Same(shape.clone()), Same(channel.clone()));
        Some(About { bodies, shape, channel, mounting, preset, simulation })
    }

    fn standing(&self, about: &About) -> Vec<MachineBody> {
        let Some((electrode, _)) = self.shown_electrode() else { return Vec::new() };
        let (o, side) = (electrode.reference_point, electrode.enters_from);
        let mesh = about.preset.and(self.outcome()).map_or(&electrode.mesh, |o| &o.burning().mesh);
        let station = Station::new(mesh, o, side, about.mounting, &about.channel.0.blisk);
        let station = about.preset.as_ref().map_or(station, |preset| station.holding(preset));
        let simulation = about.simulation.as_ref().map(|simulation| &*simulation.0);
        about.bodies.0.iter().map(|body| MachineBody::standing(body, &station, simulation)).collect()
    }

    /// The channel whose passage is drawn as lines: in the step Channel, unless that failed or they are hidden.
    pub fn shown_passage(&self) -> Option<&Arc<FoundChannel>> {
        let is_shown = self.step == Stage::Channel && self.layers.get(Layer::Passage).visible;
        let failed = matches!(self.work.state(Stage::Channel), State::Failed(_));
        self.work.channel().filter(|_| is_shown && !failed)
    }

    /// The place where the channel was refused, in the coordinates of the mesh (mm), in the step Channel.
    pub fn refused_at(&self) -> Option<DVec3> {
        self.work.refused_at().filter(|_| self.step == Stage::Channel)
    }

    /// The pose that the electrode is shown in.
    pub(super) fn shown_pose(&self) -> Pose {
        let on_track = || self.track.at(self.cursor.s).filter(|_| self.is_live() || !self.is_tuning()).map(|s| s.pose);
        self.moment().map(|moment| moment.pose).or_else(on_track).unwrap_or_default()
    }

    /// Clearance of the electrode as colours, as far as computed.
    pub fn colour_values(&self) -> Option<SurfaceValues> {
        let (_, shape) = self.shown_electrode()?;
        let (_, values) = self.coloured.last().filter(|(key, _)| self.colours && Arc::ptr_eq(&key.shape.0, shape))?;
        let legend = self.colour_legend();
        let range = [legend.min as f32, legend.max as f32];
        Some(SurfaceValues { values: values.clone(), map: legend.map, range })
    }

    /// The residual stock, if it is known and belongs to the electrodes that are shown.
    pub fn residual_stock_shape(&self) -> Option<&MapShape> {
        let is_current = self.work.state(Stage::Plan) == State::Ready && !self.is_tuning();
        self.work.residual_stock_shape().filter(|_| is_current)
    }

    /// The measured sections that the part was made from, against the walls of the channel, if there are any.
    pub fn measured(&self) -> Option<&(MeasuredWalls, MapShape)> {
        let found = self.work.channel().filter(|_| self.work.state(Stage::Channel) == State::Ready)?;
        found.measured.as_ref()
    }

    /// The map on the surfaces of the channel that is shown, the residual stock or the deviation of measured sections, with
    /// its title and where its colours end (mm).
    fn shown_map(&self) -> Option<(&MapShape, &'static str, f64)> {
        if let Some(shape) = self.residual_stock_shape().filter(|_| self.residual_stock) {
            let limit = colour_limit(shape.greatest, self.document.params().electrode.of_last_stage().spark_gap_mm);
            return Some((shape, "Residual stock", limit));
        }
        self.deviation_map().filter(|_| self.deviations)
    }

    /// Map of the deviations of the scan, or else of the measured sections, with its title and where its colours end (mm).
    pub fn deviation_map(&self) -> Option<(&MapShape, &'static str, f64)> {
        if let Some(scan) = self.scan() {
            let [_, tolerance] = scan.part.verdict.tolerance.range_mm();
            return Some((&scan.shape, SCANNED, 2.0 * tolerance));
        }
        let (walls, shape) = self.measured()?;
        Some((shape, DEVIATION, colour_limit(shape.greatest, walls.planned.limit_mm)))
    }

    /// The colours of that map.
    pub fn map_values(&self) -> Option<(&Arc<RenderMesh>, SurfaceValues)> {
        let (shape, _, limit) = self.shown_map()?;
        Some((&shape.shape, shape.values(limit)))
    }

    /// Legend of the colours of that map.
    pub fn map_legend(&self) -> Option<Legend> {
        let (_, title, limit) = self.shown_map()?;
        Some(map_legend(title, limit))
    }

    /// Shows the deviation of the scan or of measured sections, or the electrode again.
    pub fn toggle_deviations(&mut self) {
        self.deviations = !self.deviations;
        if self.deviations {
            self.residual_stock = false;
            self.layers.into_channel();
        }
        self.layers.get_mut(Layer::Electrode).visible = !self.deviations;
    }

    /// Shows the residual stock in the channel, or the electrode again.
    pub fn toggle_residual_stock(&mut self) {
        self.residual_stock = !self.residual_stock;
        if self.residual_stock {
            self.deviations = false;
            self.layers.into_channel();
        }
        self.layers.get_mut(Layer::Electrode).visible = !self.residual_stock;
    }

    /// Shows the electrode again if there is no map to show any more.
    pub(super) fn follow_maps(&mut self) {
        if self.deviations && self.deviation_map().is_none() {
            self.toggle_deviations();
        }
        if self.residual_stock && self.residual_stock_shape().is_none() {
            self.toggle_residual_stock();
        }
    }

    /// Legend of the colours.
    pub fn colour_legend(&self) -> Legend {
        let gap = self.shown_undersize();
        // While the electrode moves its colours come after it.
        let is_current = self.coloured.last().is_some_and(|(key, _)| key.pose == self.shown_pose());
        Legend {
            title: if is_current { "Clearance" } else { "Clearance, out of date" }.to_owned(),
            unit: "mm".to_owned(),
            map: ColourMap::Threshold,
            min: 0.0,
            max: 2.0 * gap,
            threshold: Some(gap),
        }
    }

    /// Whether the electrode is being tuned, so that the plan may belong to another one.
    pub fn is_tuning(&self) -> bool {
        let changed = self.work.state(Stage::Plan) != State::Ready;
        self.is_live() || (changed && self.step <= Stage::Electrode)
    }

    /// Whether the poses are those of a preview.
    pub fn is_live(&self) -> bool {
        matches!(self.track_of, TrackSource::Live(..))
    }

    /// Distance that the electrode that is shown keeps from the finished surface (mm).
    fn shown_undersize(&self) -> f64 {
        let of_job = || self.document.params().electrode.of_last_stage().spark_gap_mm;
        self.shown_electrode().map_or_else(of_job, |(electrode, _)| electrode.undersize_mm)
    }

    /// The electrode that is shown, with its shape. While parameters are tuned, it is the electrode of the present
    /// parameters, not the planned one.
    pub fn shown_electrode(&self) -> Option<(&Electrode, &Arc<RenderMesh>)> {
        if let Some(partial) = self.searched() {
            return Some((&partial.electrode, &partial.shape));
        }
        if let Some(looked) = self.work.looked().filter(|_| self.is_live()) {
            return self.looked_at(looked);
        }
        if self.is_tuning() { self.tuned().or(self.planned()) } else { self.planned().or(self.tuned()) }
    }

    /// The electrodes that panels and arrows tell of, in the order of their parts. That at the cursor is the one in the
    /// view, be it made for the side that is tried first or for that on which a preview or a plan found a path; the others
    /// are those of the plan, while that is of the present parameters, or else as they are made.
    pub fn reported_electrodes(&self) -> Vec<&Electrode> {
        let planned = self.work.plan().filter(|_| self.work.state(Stage::Plan) == State::Ready);
        let planned = |i: usize| planned.and_then(|plan| plan.electrodes.get(i)).map(|outcome| &outcome.electrode);
        let made = self.work.electrodes().map(|made| &made.electrodes[..]).unwrap_or_default();
        // A plan under way may have come to another part than the one at the cursor.
        let place = |e: &Electrode| (e.stage.clone(), e.part, e.parts, e.column);
        let shown = |i: usize| {
            let (electrode, _) = self.shown_electrode().filter(|_| i == self.cursor.electrode)?;
            (place(electrode) == place(&made[i])).then_some(electrode)
        };
        made.iter().enumerate().map(|(i, made)| shown(i).or_else(|| planned(i)).unwrap_or(made)).collect()
    }

    /// The electrode of the present parameters, with its shape.
    fn tuned(&self) -> Option<(&Electrode, &Arc<RenderMesh>)> {
        let i = self.cursor.electrode;
        self.work.electrodes().and_then(|e| e.electrodes.get(i).zip(e.shapes.get(i)))
    }

    /// The electrode of the plan, with its shape.
    fn planned(&self) -> Option<(&Electrode, &Arc<RenderMesh>)> {
        let (planned, i) = (self.work.planned()?, self.cursor.electrode);
        planned.outcome.electrodes.get(i).map(|o| &o.electrode).zip(planned.shapes.get(i))
    }

    /// The electrode that a quick look is shown with, and its shape.
    pub(super) fn looked_at<'a>(&'a self, looked: &'a Looked) -> Option<(&'a Electrode, &'a Arc<RenderMesh>)> {
        let other = looked.found.other.as_deref().zip(looked.shape.as_ref());
        other.or_else(|| self.tuned()).or_else(|| self.planned())
    }

    /// The electrode that is shown as a part for milling its flanks, in the axes of its export.
    pub fn electrode_to_mill(&self) -> Option<ElectrodePart> {
        let (electrode, _) = self.shown_electrode()?;
        let (part, channel) = (self.work.part()?, &self.work.channel()?.channel);
        let is_of_mesh = self.document.params().export.frame == MeshFrame::Mesh;
        let named = (self.cursor.electrode + 1, part.name.as_str());
        Some(ElectrodePart::of_blisk(electrode, named, is_of_mesh.then_some(&channel.frame)))
    }

    /// The plan being made, if its nodes are those of the track.
    fn searched(&self) -> Option<&PartialPlan> {
        let is_shown = matches!(self.track_of, TrackSource::Partial(_));
        self.work.partial_plan().filter(|partial| is_shown && !partial.nodes.is_empty()).map(|partial| &**partial)
    }

    /// The closest point of the feed, or the jam: a point of the electrode in its final pose and one of the blisk, both
    /// in W. None while a preview of other parameters is shown.
    pub fn contact(&self) -> Option<[DVec3; 2]> {
        let plan = &self.outcome().filter(|_| self.searched().is_none() && !self.is_live())?.plan;
        if let Some(jam) = &plan.jam {
            return jam.contact().map(|c| [c.on_electrode, c.on_blisk]);
        }
        let least = plan.path.as_ref()?.certificate.least();
        Some([least.on_electrode, least.on_blisk])
    }

    /// Retract distance of that place (mm).
    pub fn contact_s(&self) -> Option<f64> {
        let plan = &self.outcome().filter(|_| self.searched().is_none() && !self.is_live())?.plan;
        plan.jam.as_ref().map(|j| j.s).or_else(|| Some(plan.path.as_ref()?.certificate.least().s))
    }

    /// The place where bodies come too close in the whole motion on the machine. It takes precedence over the closest
    /// point of the feed.
    pub fn trouble(&self) -> Option<&Trouble> {
        self.machine.trouble().filter(|_| self.searched().is_none())
    }

    /// The required clearance, and the accepted shortfall (mm): of the path that is shown, or of the present
    /// parameters.
    pub fn required(&self) -> [f64; 2] {
        let path = self.outcome().filter(|_| self.track.is_path).and_then(|o| o.plan.path.as_ref());
        let of_job = [self.shown_undersize(), self.document.params().verify.tolerance_mm];
        path.map_or(of_job, |p| [p.certificate.required(), p.certificate.tolerance()])
    }

    /// The least clearance that is accepted (mm). At nodes it is as exact as the field of the search.
    pub fn least_wanted(&self) -> f64 {
        let [required, tolerance] = self.required();
        required - tolerance - if self.track.is_path { 0.0 } else { DistanceField::ACCURACY }
    }

    /// Whether the plan that is shown belongs to other parameters.
    pub fn plan_is_stale(&self) -> bool {
        self.work.state(Stage::Plan) == State::Stale
    }

    /// Plays, or moves to another node.
    pub fn step_along(&mut self, command: FrameCommand) {
        let track = self.track.clone();
        let cursor = &mut self.cursor;
        if command == FrameCommand::Play {
            cursor.playing = !cursor.playing;
            if self.machine.shown().is_some() {
                if cursor.playing && self.machine.advance(0.0) == Some(false) {
                    self.machine.go_to(Some(0.0));
                }
                return;
            }
            if cursor.playing && cursor.s <= 0.0 {
                cursor.s = track.length();
            }
            return;
        }
        self.machine.go_to(None);
        cursor.playing = false;
        cursor.s = match command {
            FrameCommand::NextNode => track.next_node(cursor.s),
            FrameCommand::PreviousNode => track.previous_node(cursor.s),
            FrameCommand::FirstNode => track.length(),
            _ => 0.0,
        };
    }

    /// Shows a section through everything, or everything again.
    pub fn toggle_section(&mut self) {
        self.section = match (self.section, self.work.part()) {
            (None, Some(part)) => {
                // Across the channel's middle where one is known: that is what one wants to look into.
                let plane = self.work.channel().map(|found| {
                    let frame = &found.channel.frame;
                    let middle = found.channel.middle().place(0.5);
                    let point = glam::DVec3::new(middle.x, 0.0, middle.y);
                    SectionPlane { point: frame.to_parent(point), normal: frame.x }
                });
                plane.or(Some(SectionPlane { point: part.mesh.bounds().center(), normal: glam::DVec3::X }))
            }
            _ => None,
        };
    }
}
