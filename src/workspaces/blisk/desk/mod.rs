//! The state of the workspace: the document, its steps, the cursor, and what is shown. Panels draw it and push commands.

mod shown;

use std::sync::Arc;
use std::time::Duration;

use crate::workspaces::blisk::document::Document;
use crate::workspaces::blisk::document::job_file::PlanJob;
use crate::workspaces::blisk::document::stage::Stage;
use crate::workspaces::blisk::job::plan::ElectrodeOutcome;
pub use crate::workspaces::blisk::panels::cursor::Cursor;
use crate::workspaces::blisk::panels::kept_runs::KeptRuns;
use crate::workspaces::blisk::panels::machine_bodies::MachineBodies;
use crate::workspaces::blisk::panels::machine_motion::MachineMotion;
use crate::workspaces::blisk::panels::swept::Swept;
use crate::workspaces::blisk::panels::tuning::Tuning;
use crate::workspaces::blisk::pipeline::{Pipeline, StageState};
use crate::workspaces::blisk::scene::track::Track;
use crate::workspaces::blisk::scene::values::clearance_at_vertices;
use crate::workspaces::blisk::scene::{Layer, Layers};
use crate::workspaces::context::{Context, LogLine};
use crate::workspaces::news::EventKind;
use feed::plan_params::Strategy;
use feed::pose::Pose;
use files::MovedFile;
use render::mesh::RenderMesh;
use render::scene::SectionPlane;
use task::{Lane, Memo, Priority, Same, Scheduler};

/// The dialogs of the workspace.
pub enum BliskDialog {
    /// What is exported and where.
    Export,
    /// A project, and files of it that are gone or have changed.
    Moved(Box<Document>, Vec<MovedFile>),
}

/// The document, what has been made of it, and how it is looked at.
pub struct BliskDesk {
    /// The parameters.
    pub document: Document,
    /// What has been made of them.
    pub pipeline: Pipeline,
    /// The step whose form is open.
    pub step: Stage,
    /// Where the electrode stands.
    pub cursor: Cursor,
    /// How things look.
    pub layers: Layers,
    /// What is selected in tree and view.
    pub selected: Option<Layer>,
    /// A cut through everything.
    pub section: Option<SectionPlane>,
    /// Whether the electrode is coloured by its clearance.
    pub colours: bool,
    /// Whether the stock left on the surfaces of the channel is shown as colours.
    pub leftover: bool,
    /// The electrode's clearance at its vertices in some pose.
    coloured: Memo<ColourKey, Vec<f32>>,
    /// The room that the electrode passes through.
    pub swept: Swept,
    /// The quick look, and sizing.
    pub tuning: Tuning,
    /// The whole motion on the machine.
    pub machine: MachineMotion,
    bodies: MachineBodies,
    /// The dialog that is open.
    pub dialog: Option<BliskDialog>,
    /// Plans that are kept to compare with.
    pub kept: KeptRuns,
    /// Withdrawn distances at which ghosts of the electrode are pinned (mm).
    pub ghosts: Vec<f64>,
    /// Whether clicks in the view measure.
    pub measuring: bool,
    /// Where the plots have the first pose and the final one on the screen (points), for the timeline above them.
    pub span: Option<[f32; 2]>,
    /// The track of the electrode that is looked at; made again when its source changes.
    track: Arc<Track>,
    track_of: TrackSource,
}

/// What colours were computed for.
#[derive(Clone, PartialEq)]
struct ColourKey {
    /// The electrode's shape.
    shape: Same<RenderMesh>,
    pose: Pose,
}

/// What a track was made from: the plan's address, or the number of a partial plan.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
enum TrackSource {
    #[default]
    Nothing,
    Plan(usize, usize),
    Partial(u64),
    Live(u64),
}

impl BliskDesk {
    /// The state of the workspace on `document`.
    ///
    /// # Errors
    /// If the system gives no thread to work on.
    pub fn new(
        document: Document,
        scheduler: &Scheduler,
        wake: impl Fn() + Send + Sync + Clone + 'static,
    ) -> std::io::Result<Self> {
        Ok(Self {
            document,
            pipeline: Pipeline::start(wake.clone())?,
            coloured: Memo::new(scheduler, Lane::Quick, "Clearance").letting_finish(),
            swept: Swept::start(wake.clone())?,
            bodies: MachineBodies::start(wake.clone())?,
            kept: KeptRuns::start(wake.clone())?,
            tuning: Tuning::start(wake)?,
            machine: MachineMotion::default(),
            dialog: None,
            step: Stage::Part,
            cursor: Cursor { electrode: 0, s: 0.0, playing: false, speed: 10.0 },
            layers: Layers::default(),
            selected: None,
            section: None,
            colours: false,
            leftover: false,
            ghosts: Vec::new(),
            measuring: false,
            span: None,
            track: Arc::default(),
            track_of: TrackSource::default(),
        })
    }

    /// Takes in what the worker has said.
    pub fn follow(&mut self, cx: &mut Context) {
        for event in self.pipeline.follow(&mut self.document) {
            let text = format!("{}: {}", event.stage.name(), event.text);
            let topic = Some(event.stage.number());
            cx.note(LogLine { topic, took: event.took, ..LogLine::now(event.kind, text) });
        }
        self.follow_tuning(cx.preferences.live);
        self.follow_track();
        self.machine.follow(self.pipeline.plan(), self.cursor.electrode);
        self.follow_moment();
        self.follow_leftover();
        self.follow_kept(cx);
        self.follow_bodies(cx);
        self.follow_colours();
        self.follow_swept(cx);
    }

    /// Moves the cursor to where `s` is withdrawn, or as far as there are poses.
    pub fn go_to(&mut self, s: f64) {
        self.machine.go_to(None);
        self.cursor.s = s.clamp(0.0, self.track.length());
        self.cursor.playing = false;
    }

    /// Changes parameters. `dragging` tells that more changes of the same kind may follow at once.
    pub fn edit(&mut self, label: &str, job: PlanJob, dragging: bool) {
        self.document.edit(label, job, dragging);
    }

    /// Ends what was one gesture: the button is released, the field is left.
    pub fn end_gesture(&mut self) {
        self.document.end_gesture();
    }

    /// Whether a plan can be started.
    pub fn can_plan(&self) -> bool {
        // A plan makes its own electrodes, so that it need not wait for those that are shown.
        self.pipeline.state(Stage::Channel) == StageState::Done
            && !matches!(self.pipeline.state(Stage::Electrode), StageState::Missing | StageState::Failed(_))
            && self.pipeline.state(Stage::Plan) != StageState::Running
    }

    /// Whether the present plan can be kept to compare with: its strategy is known while no parameter has changed.
    pub fn can_keep(&self) -> bool {
        self.pipeline.state(Stage::Plan) == StageState::Done
            && self.pipeline.plan().is_some_and(|plan| self.kept.can_keep(plan, &self.document))
    }

    /// Keeps the present plan, which [`can_keep`](Self::can_keep) says can be.
    pub fn keep(&mut self, cx: &mut Context) {
        let (Some(plan), Some(part)) = (self.pipeline.plan(), self.pipeline.part()) else { return };
        if let Some(name) = self.kept.keep(plan, &mut self.document, &part.content()) {
            cx.say(EventKind::Done, format!("{name} is kept for comparison"));
        }
    }

    /// Has the runs made that came with the document.
    fn follow_kept(&mut self, cx: &mut Context) {
        let p = &self.pipeline;
        let found = p.channel().filter(|_| p.state(Stage::Channel) == StageState::Done);
        for why in self.kept.follow(&self.document, (p.part(), found)) {
            cx.say(EventKind::Cancelled, why);
        }
    }

    /// What the plan found about the electrode that is looked at.
    pub fn outcome(&self) -> Option<&ElectrodeOutcome> {
        self.pipeline.plan().and_then(|p| p.electrodes.get(self.cursor.electrode))
    }

    /// How many electrodes there are to look at.
    pub fn electrode_count(&self) -> usize {
        let planned = self.pipeline.plan().map(|p| p.electrodes.len());
        planned.or(self.pipeline.electrodes().map(|e| e.electrodes.len())).unwrap_or(0)
    }

    /// The poses of the electrode that is looked at.
    pub fn track(&self) -> &Track {
        &self.track
    }

    /// The same, to be kept.
    pub fn shared_track(&self) -> Arc<Track> {
        self.track.clone()
    }

    /// Keeps the quick look up with the parameters, as long as there is no plan of theirs. What it found stays while
    /// that is made.
    fn follow_tuning(&mut self, is_live: bool) {
        if self.pipeline.state(Stage::Plan) == StageState::Running && is_live {
            return;
        }
        let wanted = is_live
            && self.document.params().plan.strategy == Strategy::Global
            && matches!(self.pipeline.state(Stage::Plan), StageState::Missing | StageState::Stale);
        let inputs = wanted.then(|| self.pipeline.tuning_inputs()).flatten();
        self.tuning.follow(inputs, self.cursor.electrode);
    }

    /// Begins to look for the thickest electrodes.
    pub fn find_sizes(&mut self) {
        if let Some(inputs) = self.pipeline.tuning_inputs() {
            self.tuning.size(inputs);
        }
    }

    fn follow_track(&mut self) {
        self.cursor.electrode = self.cursor.electrode.min(self.electrode_count().saturating_sub(1));
        let partial = self.pipeline.partial_plan().filter(|p| !p.nodes.is_empty());
        let source = match (partial, self.tuning.way(), self.pipeline.plan()) {
            (Some(partial), ..) => TrackSource::Partial(partial.number),
            (None, Some((number, _)), _) => TrackSource::Live(number),
            (None, None, Some(plan)) => TrackSource::Plan(Arc::as_ptr(plan) as usize, self.cursor.electrode),
            (None, None, None) => TrackSource::Nothing,
        };
        if source == self.track_of {
            return;
        }
        let track = match (source, partial, self.outcome()) {
            (TrackSource::Partial(_), Some(partial), _) => Track::of_nodes(&partial.nodes),
            (TrackSource::Plan(..), _, Some(outcome)) => Track::of_plan(&outcome.plan),
            (TrackSource::Live(_), ..) => {
                self.tuning.way().map(|(_, live)| Track::of_nodes(&live.way.nodes)).unwrap_or_default()
            }
            _ => Track::default(),
        };
        // While nodes are found the electrode goes along with the last of them.
        if matches!(source, TrackSource::Partial(_)) || matches!(self.track_of, TrackSource::Partial(_)) {
            self.cursor.s = track.length();
        }
        self.cursor.s = self.cursor.s.min(track.length());
        (self.track, self.track_of) = (Arc::new(track), source);
    }

    /// Has the electrode's clearance computed at the pose of the cursor, if it is to be seen.
    fn follow_colours(&mut self) {
        while self.coloured.take().is_some() {}
        if !self.colours {
            return self.coloured.clear();
        }
        let Some((electrode, shape)) = self.shown_electrode() else { return };
        let Some(found) = self.pipeline.channel() else { return };
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

    /// Has the room made that the electrode passes through, if it is to be seen and all its poses are known.
    fn follow_swept(&mut self, cx: &mut Context) {
        let seen = self.layers.get(Layer::Sweep).visible && !self.is_tuning() && self.pipeline.partial_plan().is_none();
        let track = self.track.clone();
        let lacks = self.swept.lacks((seen && !track.is_empty()).then_some(&track));
        if let Some(why) = self.swept.take_failure() {
            cx.say(EventKind::Failed, format!("the swept volume is drawn as poses: {why}"));
        }
        if let (true, Some((electrode, _))) = (lacks, self.shown_electrode()) {
            let electrode = electrode.clone();
            self.swept.make(track, electrode);
        }
    }

    /// Pins a ghost of the electrode where the cursor stands, or takes the one there away.
    pub fn toggle_ghost(&mut self) {
        let s = self.cursor.s;
        let before = self.ghosts.len();
        self.ghosts.retain(|g| (g - s).abs() > 1e-9);
        if self.ghosts.len() == before {
            self.ghosts.push(s);
            self.layers.get_mut(Layer::Ghosts).visible = true;
        }
    }

    /// Moves the playing cursor on by `elapsed`. Tells whether it still moves.
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
