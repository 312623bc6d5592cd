//! What is shown of the electrode: which one, in which pose, in which colours, and what stands about it.

use std::sync::Arc;

use glam::DVec3;

use super::{BliskDesk, TrackSource};
use crate::workspaces::blisk::document::choice::MeshFrame;
use crate::workspaces::blisk::document::stage::Stage;
use crate::workspaces::blisk::panels::machine_motion::Trouble;
use crate::workspaces::blisk::pipeline::{PartialPlan, StageState};
use crate::workspaces::blisk::scene::Layer;
use crate::workspaces::blisk::scene::leftover::{LeftoverShape, colour_limit, leftover_legend};
use crate::workspaces::blisk::scene::machine::{MachineBody, Moment};
use crate::workspaces::context::Context;
use crate::workspaces::message::ElectrodePart;
use crate::workspaces::news::EventKind;
use feed::pose::Pose;
use geometry::distance_field::DistanceField;
use render::colour_map::{ColourMap, Legend};
use render::mesh::RenderMesh;
use render::scene::SurfaceValues;
use wheel::electrode::Electrode;

impl BliskDesk {
    /// The moment of the whole motion on the machine that is shown, if it is that and not a pose of the track.
    pub fn moment(&self) -> Option<Moment> {
        self.machine.shown().filter(|_| !self.is_tuning() && self.searched().is_none())
    }

    /// Withdrawn distance of the electrode on the track (mm); none while the machine is shown where no feed is.
    pub fn feed_cursor(&self) -> Option<f64> {
        self.moment().map_or(Some(self.cursor.s), |moment| moment.s)
    }

    /// Shows the whole motion at `way`; the cursor goes along where that is on the feed.
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

    /// The bodies of the machine about the electrode that is shown.
    pub fn machine_bodies(&self) -> &Arc<Vec<MachineBody>> {
        self.bodies.standing()
    }

    /// Keeps the bodies of the machine up with the parameters and with the electrode that is shown.
    pub(super) fn follow_bodies(&mut self, cx: &mut Context) {
        let machine = &self.document.params().machine;
        let wanted = machine.has_bodies().then(|| (machine.name.clone(), self.pipeline.reloads()));
        self.bodies.read(wanted);
        if let Some(why) = self.bodies.take_failure() {
            cx.say(EventKind::Failed, format!("the machine is not shown: {why}"));
        }
        // What was in the way of an earlier electrode may not be in the way of this one.
        let is_current = self.pipeline.state(Stage::Plan) == StageState::Done;
        let simulation = self.machine.simulation().filter(|_| is_current).cloned();
        let anew = self.bodies.anew(self.shown_electrode(), self.pipeline.channel(), simulation.as_ref());
        if let Some(stood) = anew {
            self.bodies.take_over(stood);
        }
    }

    /// The pose that the electrode is shown in.
    pub(super) fn shown_pose(&self) -> Pose {
        let on_track = || self.track.at(self.cursor.s).filter(|_| self.is_live() || !self.is_tuning()).map(|s| s.pose);
        self.moment().map(|moment| moment.pose).or_else(on_track).unwrap_or_default()
    }

    /// The electrode's clearance as colours, as far as it is computed.
    pub fn colour_values(&self) -> Option<SurfaceValues> {
        let (_, shape) = self.shown_electrode()?;
        let (_, values) = self.coloured.last().filter(|(key, _)| self.colours && Arc::ptr_eq(&key.shape.0, shape))?;
        let legend = self.colour_legend();
        let range = [legend.min as f32, legend.max as f32];
        Some(SurfaceValues { values: values.clone(), map: legend.map, range })
    }

    /// The stock that is left, if it is known and of the electrodes that are shown.
    pub fn leftover_shape(&self) -> Option<&LeftoverShape> {
        let is_current = self.pipeline.state(Stage::Plan) == StageState::Done && !self.is_tuning();
        self.pipeline.leftover_shape().filter(|_| is_current)
    }

    /// The stock left on the surfaces of the channel with its colours, if it is to be seen and known.
    pub fn leftover_values(&self) -> Option<(&Arc<RenderMesh>, SurfaceValues)> {
        let shape = self.leftover_shape().filter(|_| self.leftover)?;
        Some((&shape.shape, shape.values(self.leftover_limit(shape))))
    }

    /// What the colours of the stock left mean.
    pub fn leftover_legend(&self) -> Option<Legend> {
        Some(leftover_legend(self.leftover_limit(self.leftover_shape()?)))
    }

    fn leftover_limit(&self, shape: &LeftoverShape) -> f64 {
        colour_limit(shape.greatest, self.document.params().electrode.spark_gap_mm)
    }

    /// Shows the stock left in the channel, or the electrode again.
    pub fn toggle_leftover(&mut self) {
        self.leftover = !self.leftover;
        if self.leftover {
            self.layers.into_channel();
        }
        self.layers.get_mut(Layer::Electrode).visible = !self.leftover;
    }

    /// Shows the electrode again where there is no stock to be shown any more.
    pub(super) fn follow_leftover(&mut self) {
        if self.leftover && self.leftover_shape().is_none() {
            self.toggle_leftover();
        }
    }

    /// What the colours mean.
    pub fn colour_legend(&self) -> Legend {
        let gap = self.document.params().electrode.spark_gap_mm;
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

    /// Whether the electrode is being tuned, so that the plan there may be is not its own.
    pub fn is_tuning(&self) -> bool {
        let changed = self.pipeline.state(Stage::Plan) != StageState::Done;
        self.is_live() || (changed && self.step <= Stage::Electrode)
    }

    /// Whether the poses are those of a quick look.
    pub fn is_live(&self) -> bool {
        matches!(self.track_of, TrackSource::Live(_))
    }

    /// The electrode that is shown and its shape: while parameters are tuned as it would be, not as it was planned.
    pub fn shown_electrode(&self) -> Option<(&Electrode, &Arc<RenderMesh>)> {
        let (p, i) = (&self.pipeline, self.cursor.electrode);
        if let Some((electrode, shape)) = self.searched().and_then(|partial| partial.electrode.as_ref()) {
            return Some((electrode, shape));
        }
        if let Some((electrode, shape)) = self.tuning.other_electrode().filter(|_| self.is_live()) {
            return Some((electrode, shape));
        }
        let planned = self.outcome().map(|o| &o.electrode).zip(p.plan_shapes().and_then(|s| s.get(i)));
        let tuned = p.electrodes().and_then(|e| e.electrodes.get(i).zip(e.shapes.get(i)));
        if self.is_tuning() { tuned.or(planned) } else { planned.or(tuned) }
    }

    /// The electrode that is shown as the part whose flanks are milled, in the axes in which it is exported. Up is
    /// outwards.
    pub fn electrode_to_mill(&self) -> Option<ElectrodePart> {
        let (electrode, _) = self.shown_electrode()?;
        let (part, channel) = (self.pipeline.part()?, &self.pipeline.channel()?.channel);
        let is_of_mesh = self.document.params().export.frame == MeshFrame::Mesh;
        let named = (self.cursor.electrode + 1, part.name.as_str());
        Some(ElectrodePart::of_blisk(electrode, named, is_of_mesh.then_some(&channel.frame)))
    }

    /// The plan that is being made, if its nodes are those of the track.
    fn searched(&self) -> Option<&PartialPlan> {
        let is_shown = matches!(self.track_of, TrackSource::Partial(_));
        self.pipeline.partial_plan().filter(|partial| is_shown && !partial.nodes.is_empty())
    }

    /// Where the feed comes closest or jams, in one point of the electrode in its final pose and one of the blisk, both
    /// in W.
    pub fn contact(&self) -> Option<[DVec3; 2]> {
        let plan = &self.outcome().filter(|_| self.searched().is_none())?.plan;
        if let Some(jam) = &plan.jam {
            return jam.contact().map(|c| [c.on_electrode, c.on_blisk]);
        }
        let least = plan.path.as_ref()?.certificate.least();
        Some([least.on_electrode, least.on_blisk])
    }

    /// Withdrawn distance at which that is (mm).
    pub fn contact_s(&self) -> Option<f64> {
        let plan = &self.outcome().filter(|_| self.searched().is_none())?.plan;
        plan.jam.map(|j| j.s).or_else(|| Some(plan.path.as_ref()?.certificate.least().s))
    }

    /// Where something comes too close in the whole motion on the machine; that counts more than where the feed comes
    /// closest.
    pub fn trouble(&self) -> Option<&Trouble> {
        self.machine.trouble().filter(|_| self.searched().is_none())
    }

    /// The clearance that is required, and how much less of it still counts as kept (mm): of the path that is shown, or
    /// of the present parameters.
    pub fn required(&self) -> [f64; 2] {
        let path = self.outcome().filter(|_| self.track.is_path).and_then(|o| o.plan.path.as_ref());
        let job = self.document.params();
        let of_job = [job.electrode.spark_gap_mm, job.verify.tolerance_mm];
        path.map_or(of_job, |p| [p.certificate.required(), p.certificate.tolerance()])
    }

    /// The least clearance that counts as kept (mm). That of nodes is as exact as the field that they were searched in.
    pub fn least_wanted(&self) -> f64 {
        let [required, tolerance] = self.required();
        required - tolerance - if self.track.is_path { 0.0 } else { DistanceField::ACCURACY }
    }

    /// Whether what is shown of the plan belongs to other parameters.
    pub fn plan_is_stale(&self) -> bool {
        self.pipeline.state(Stage::Plan) == StageState::Stale
    }
}
