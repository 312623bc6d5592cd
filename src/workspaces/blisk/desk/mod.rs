//! The state of the workspace: the document, its steps, the cursor, and what is shown. Panels draw the state and push
//! commands.

mod burned;
pub mod kept_runs;
pub mod machine_motion;
pub mod picks;
pub mod scan;
mod shown;
mod surfaces;

use std::sync::Arc;
use std::time::Duration;

use crate::workspaces::blisk::commands::BliskCommand;
use crate::workspaces::blisk::document::Document;
use crate::workspaces::blisk::document::job_file::PlanJob;
use crate::workspaces::blisk::document::stage::Stage;
use crate::workspaces::blisk::job::outcome::ElectrodeOutcome;
use crate::workspaces::blisk::job::planned::{PartialPlan, Planned};
use crate::workspaces::blisk::job::preview::Looked;
use crate::workspaces::blisk::scene::machine::BodyShape;
use crate::workspaces::blisk::scene::shapes::clearance_at_vertices;
use crate::workspaces::blisk::scene::sweep::{FINE, swept_shape};
use crate::workspaces::blisk::scene::track::Track;
use crate::workspaces::blisk::scene::{Layer, Layers};
use crate::workspaces::blisk::work::BliskWork;
use crate::workspaces::commands::{Command, CommandSet, Commanded, FrameCommand};
use crate::workspaces::context::{Context, LogLine};
use crate::workspaces::news::{EventKind, WorkEvent};
use burned::{Burned, burned};
use feed::global::PreviewPath;
use feed::pose::Pose;
use feed::problem::Node;
use files::AnyDocument as _;
use glam::DVec3;
use kept_runs::KeptRuns;
use machine_motion::MachineMotion;
use picks::Picking;
use render::mesh::RenderMesh;
use render::scene::SectionPlane;
use scan::Scanned;
use shown::Stood;
use surfaces::{Classed, classed};
use task::{Lane, Memo, Priority, Refusal, Same, Scheduler, State};

/// Position of the electrode that is shown.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cursor {
    /// Number of the electrode that is shown, from 0.
    pub electrode: usize,
    /// Retract distance (mm).
    pub s: f64,
    /// Whether the motion is played.
    pub playing: bool,
    /// Speed of playing (mm/s).
    pub speed: f64,
}

/// The document, the results made from it, and how they are shown.
pub struct BliskDesk {
    /// The parameters.
    pub document: Document,
    /// Results computed from the parameters.
    pub work: BliskWork,
    /// The step whose form is open.
    pub step: Stage,
    /// Position of the electrode that is shown.
    pub cursor: Cursor,
    /// Visibility, colour and opacity of each layer.
    pub layers: Layers,
    /// Layer that is selected in tree and view.
    pub selected: Option<Layer>,
    /// A cut through everything.
    pub section: Option<SectionPlane>,
    /// Whether the electrode is coloured by its clearance.
    pub colours: bool,
    /// Whether the stock left on the surfaces of the channel is shown as colours.
    pub residual_stock: bool,
    /// Whether what a scan, or else the measured sections, are off is shown.
    pub deviations: bool,
    /// Whether the surfaces of the wheel are coloured by their classes.
    pub surfaces: bool,
    classed: Classed,
    burned: Burned,
    scanned: Scanned,
    /// Points that are picked in the view.
    pub picking: Picking,
    /// Clearance of the electrode at its vertices in a pose.
    coloured: Memo<ColourKey, Vec<f32>>,
    /// Swept volume of the electrode along a track.
    swept: Memo<Same<Track>, Arc<RenderMesh>>,
    /// The whole motion on the machine.
    pub machine: MachineMotion,
    /// Bodies of the machine with this name, and the number of times that its file was read.
    bodies: Memo<(String, u64), Vec<BodyShape>>,
    stood: Stood,
    /// Plans that are kept to compare with.
    pub kept: KeptRuns,
    /// Withdrawn distances at which ghosts of the electrode are pinned (mm).
    pub ghosts: Vec<f64>,
    /// Whether clicks in the view measure.
    pub measuring: bool,
    /// Positions of the first and the final pose in the plots on the screen (points), for the timeline above them.
    pub span: Option<[f32; 2]>,
    /// Track of the electrode that is shown; made again when its source changes.
    track: Arc<Track>,
    track_of: TrackSource,
}

/// Key of computed colours.
#[derive(Clone, PartialEq)]
struct ColourKey {
    /// The electrode's shape.
    shape: Same<RenderMesh>,
    pose: Pose,
}

/// Source of a track.
#[derive(Clone, PartialEq, Default)]
enum TrackSource {
    #[default]
    Nothing,
    Plan(Same<Planned>, usize),
    Partial(Same<PartialPlan>),
    /// The quick look, and the reference point of the electrode that is shown with it.
    Live(Same<Looked>, Option<DVec3>),
}

impl BliskDesk {
    /// The state of the workspace on `document`.
    pub fn new(document: Document, scheduler: &Scheduler) -> Self {
        Self {
            document,
            work: BliskWork::new(scheduler),
            coloured: Memo::new(scheduler, Lane::Quick, "Clearance").letting_finish().remembering(2),
            swept: Memo::new(scheduler, Lane::Quick, "Swept volume").remembering(2),
            bodies: Memo::new(scheduler, Lane::Quick, "Machine").remembering(1),
            stood: Stood::default(),
            kept: KeptRuns::new(scheduler),
            machine: MachineMotion::default(),
            step: Stage::Part,
            cursor: Cursor { electrode: 0, s: 0.0, playing: false, speed: 10.0 },
            layers: Layers::default(),
            selected: None,
            section: None,
            colours: false,
            residual_stock: false,
            deviations: false,
            surfaces: false,
            classed: classed(scheduler),
            burned: burned(scheduler),
            scanned: Scanned::new(scheduler),
            picking: Picking::default(),
            ghosts: Vec::new(),
            measuring: false,
            span: None,
            track: Arc::default(),
            track_of: TrackSource::default(),
        }
    }

    /// Takes in finished work and starts what follows from it.
    pub fn follow(&mut self, cx: &mut Context, is_shown: bool) {
        let priority = if is_shown { Priority::Shown } else { Priority::Normal };
        for (stage, WorkEvent { kind, text, took }) in self.work.follow(&mut self.document, priority) {
            cx.note(LogLine { topic: Some(stage.number()), took, ..LogLine::now(kind, text) });
        }
        self.work.look(self.cursor.electrode, cx.preferences.live, cx.now);
        self.follow_track();
        self.machine.follow(self.work.plan(), self.cursor.electrode);
        self.follow_moment();
        self.follow_maps();
        self.follow_kept(cx);
        self.follow_bodies(cx);
        self.follow_colours();
        self.follow_swept(cx);
        self.follow_surfaces(cx);
        self.follow_burned();
        self.follow_scan(cx);
    }

    /// Whether any work waits or runs.
    pub fn is_busy(&self) -> bool {
        let shown = self.coloured.is_busy() || self.swept.is_busy() || self.bodies.is_busy() || self.burned.is_busy();
        self.scanned.is_busy()
            || shown
            || self.is_classing()
            || self.kept.is_busy()
            || self.work.is_busy()
            || self.work.is_looking()
    }

    /// Moves the cursor to the retract distance `s` (mm), or as far as there are poses.
    pub fn go_to(&mut self, s: f64) {
        self.machine.go_to(None);
        self.cursor.s = s.clamp(0.0, self.track.length());
        self.cursor.playing = false;
    }

    /// Changes the parameters. With `dragging` the change belongs to a gesture, and more changes may follow.
    pub fn edit(&mut self, label: &str, job: PlanJob, dragging: bool) {
        self.document.edit(label, job, dragging);
    }

    /// Ends a gesture, when a button is released or a field is left.
    pub fn end_gesture(&mut self) {
        self.document.end_gesture();
    }

    /// Whether a plan can be started.
    pub fn can_plan(&self) -> bool {
        // A plan makes its own electrodes, so that it need not wait for those that are shown.
        self.work.state(Stage::Channel) == State::Ready
            && !matches!(self.work.state(Stage::Electrode), State::Missing | State::Failed(_))
            && self.work.state(Stage::Plan) != State::Running
    }

    /// Whether the present plan can be kept to compare with. Its strategy is known only while no parameter has changed.
    pub fn can_keep(&self) -> bool {
        self.work.state(Stage::Plan) == State::Ready && self.work.plan().is_some_and(|plan| self.kept.can_keep(plan))
    }

    /// Keeps the present plan. Check [`can_keep`](Self::can_keep) first.
    pub fn keep(&mut self, cx: &mut Context) {
        let (Some(plan), Some(part)) = (self.work.plan(), self.work.part()) else { return };
        match self.kept.keep(plan, &mut self.document, &part.content()) {
            Ok(name) => name.iter().for_each(|name| cx.say(EventKind::Done, format!("{name} is kept for comparison"))),
            Err(why) => cx.error("The plan is not kept", why),
        }
    }

    /// Computes the runs that came with the document.
    fn follow_kept(&mut self, cx: &mut Context) {
        let found = self.work.channel().filter(|_| self.work.state(Stage::Channel) == State::Ready);
        for why in self.kept.follow(&self.document, self.work.part().zip(found)) {
            cx.say(EventKind::Cancelled, why);
        }
    }

    /// Result of the plan for the electrode that is shown.
    pub fn outcome(&self) -> Option<&ElectrodeOutcome> {
        self.work.plan().and_then(|p| p.electrodes.get(self.cursor.electrode))
    }

    /// The result whose nodes the track has, if it has those of a whole plan.
    pub fn outcome_of_track(&self) -> Option<&ElectrodeOutcome> {
        self.outcome().filter(|_| matches!(self.track_of, TrackSource::Plan(..)))
    }

    /// Number of electrodes that can be shown.
    pub fn electrode_count(&self) -> usize {
        let planned = self.work.plan().map(|p| p.electrodes.len());
        planned.or(self.work.electrodes().map(|e| e.electrodes.len())).unwrap_or(0)
    }

    /// Poses of the electrode that is shown.
    pub fn track(&self) -> &Track {
        &self.track
    }

    /// The shared track.
    pub fn shared_track(&self) -> Arc<Track> {
        self.track.clone()
    }

    fn follow_track(&mut self) {
        self.cursor.electrode = self.cursor.electrode.min(self.electrode_count().saturating_sub(1));
        let partial = self.work.partial_plan().filter(|partial| !partial.nodes.is_empty());
        let source = match (partial, self.work.looked(), self.work.planned()) {
            (Some(partial), ..) => TrackSource::Partial(Same(partial.clone())),
            (None, Some(looked), _) => {
                let shown = self.looked_at(looked).map(|(electrode, _)| electrode.reference_point);
                TrackSource::Live(Same(looked.clone()), shown)
            }
            (None, None, Some(plan)) => TrackSource::Plan(Same(plan.clone()), self.cursor.electrode),
            (None, None, None) => TrackSource::Nothing,
        };
        if source == self.track_of {
            return;
        }
        let track = match &source {
            TrackSource::Partial(partial) => Track::of_nodes(&partial.0.nodes),
            TrackSource::Plan(..) => self.outcome().map(|outcome| Track::of_plan(&outcome.plan)).unwrap_or_default(),
            TrackSource::Live(looked, shown) => {
                let PreviewPath { nodes, reference_point, .. } = &looked.0.found.way;
                let about = |n: &Node| n.pose.about(*reference_point, shown.unwrap_or(*reference_point));
                Track::of_nodes(&nodes.iter().map(|n| Node { pose: about(n), ..*n }).collect::<Vec<_>>())
            }
            TrackSource::Nothing => Track::default(),
        };
        // While nodes are found the electrode goes along with the last of them.
        if matches!(source, TrackSource::Partial(_)) || matches!(self.track_of, TrackSource::Partial(_)) {
            self.cursor.s = track.length();
        }
        self.cursor.s = self.cursor.s.min(track.length());
        (self.track, self.track_of) = (Arc::new(track), source);
    }

    /// Computes the clearance of the electrode at the pose of the cursor, if its colours are shown.
    fn follow_colours(&mut self) {
        while self.coloured.take().is_some() {}
        if !self.colours {
            return self.coloured.clear();
        }
        let Some((electrode, shape)) = self.shown_electrode() else { return };
        let Some(found) = self.work.channel() else { return };
        let (pose, exact) = (self.shown_pose(), found.exact.clone());
        let key = ColourKey { shape: Same(shape.clone()), pose };
        if self.coloured.is_busy() || !self.coloured.wants(&key) {
            return self.coloured.turn_to(&key);
        }
        let electrode = electrode.clone();
        self.coloured.ask(&key, Priority::Shown, move |work| {
            clearance_at_vertices(&electrode, &exact, &pose, &work.task.cancel).map_err(|e| e.to_string())
        });
    }

    /// Computes the swept volume of the electrode, if it is shown and all its poses are known.
    fn follow_swept(&mut self, cx: &mut Context) {
        while let Some(ended) = self.swept.take() {
            if let Err(Refusal::Failed(why)) = ended.result {
                cx.say(EventKind::Failed, format!("the swept volume is drawn as poses: {why}"));
            }
        }
        let seen = self.layers.get(Layer::Sweep).visible && !self.is_tuning() && !self.work.is_planning();
        let electrode = self.shown_electrode().filter(|_| seen && !self.track.is_empty());
        let Some((electrode, _)) = electrode else { return self.swept.clear() };
        let (track, key) = (self.track.clone(), Same(self.track.clone()));
        if !self.swept.wants(&key) {
            return self.swept.turn_to(&key);
        }
        let electrode = electrode.clone();
        self.swept.ask(&key, Priority::Shown, move |work| {
            swept_shape(&electrode, &track, FINE, &work.task).map_err(|e| e.to_string())
        });
    }

    /// The swept volume in W, once computed.
    pub fn swept(&self) -> Option<&Arc<RenderMesh>> {
        self.swept.get(&Same(self.track.clone())).map(|shape| &**shape)
    }

    /// Pins a ghost of the electrode at the cursor, or removes the one there.
    pub fn toggle_ghost(&mut self) {
        let s = self.cursor.s;
        let before = self.ghosts.len();
        self.ghosts.retain(|g| (g - s).abs() > 1e-9);
        if self.ghosts.len() == before {
            self.ghosts.push(s);
            self.layers.get_mut(Layer::Ghosts).visible = true;
        }
    }

    /// Advances the playing cursor by `elapsed`. Returns whether it still moves.
    pub fn advance(&mut self, elapsed: Duration) -> bool {
        if !self.cursor.playing {
            return false;
        }
        if let Some(goes_on) = self.machine.advance(self.cursor.speed * elapsed.as_secs_f64()) {
            self.cursor.playing = goes_on;
            return goes_on;
        }
        self.cursor.s -= self.cursor.speed * elapsed.as_secs_f64();
        if self.cursor.s <= 0.0 {
            self.cursor.s = 0.0;
            self.cursor.playing = false;
        }
        self.cursor.playing
    }
}

impl Commanded for BliskDesk {
    fn is_enabled(&self, command: Command) -> bool {
        use FrameCommand as F;
        if let Some(command) = F::of(command) {
            return match command {
                F::Undo => self.document.undo_label(false).is_some(),
                F::Redo => self.document.undo_label(true).is_some(),
                F::Cancel => self.work.is_busy() || self.picking().is_some(),
                F::Export => self.work.released().is_some(),
                F::Play | F::NextNode | F::PreviousNode | F::FirstNode | F::LastNode => !self.track().is_empty(),
                _ => true,
            };
        }
        let Some(command) = BliskCommand::of(command) else { return false };
        match command {
            BliskCommand::Plan => self.can_plan(),
            BliskCommand::Release => self.work.can_release() && self.work.released().is_none(),
            BliskCommand::Withdraw => self.work.released().is_some(),
            BliskCommand::Ghost => !self.track().is_empty() && self.feed_cursor().is_some(),
            BliskCommand::Keep => self.can_keep(),
            BliskCommand::Colours => self.work.state(Stage::Electrode) != State::Missing,
            BliskCommand::ResidualStock => self.residual_stock_shape().is_some(),
            BliskCommand::Deviations => self.deviation_map().is_some(),
            BliskCommand::Surfaces => self.work.state(Stage::Channel) == State::Ready,
            BliskCommand::Pick(_) => self.work.part().is_some(),
            BliskCommand::Unpick => self.picking().is_some_and(|of| !self.picked(of).is_empty()),
            BliskCommand::ShowRefusal => self.refused_at().is_some(),
            BliskCommand::MillFlanks => {
                self.work.state(Stage::Electrode) == State::Ready && self.shown_electrode().is_some()
            }
            _ => true,
        }
    }
}
