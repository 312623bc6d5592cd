//! What every panel sees: the document, its steps, the cursor, and what is shown. Panels draw it and push
//! [`Command`]s; nothing else changes it.

use std::sync::Arc;
use std::time::{Duration, SystemTime};

use glam::DVec3;

use super::commands::Command;
use super::preferences::Preferences;
use crate::jobs::pipeline::{Event, EventKind, Pipeline, StageState};
use crate::jobs::plan::ElectrodeOutcome;
use crate::project::{Document, PlanJob, Stage};
use crate::render::scene::SectionPlane;
use crate::views::{Layer, Layers, Track};

/// See the module's page.
pub struct Core {
    /// The parameters.
    pub document: Document,
    /// What has been made of them.
    pub pipeline: Pipeline,
    /// What the user prefers.
    pub preferences: Preferences,
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
    /// Whether clicks in the view measure.
    pub measuring: bool,
    /// Everything that has been said.
    pub log: Vec<LogLine>,
    /// The track of the electrode that is looked at; made again when its source changes.
    track: Arc<Track>,
    track_of: TrackSource,
    commands: Vec<Command>,
    gesture: u64,
}

/// Where the electrode stands.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cursor {
    /// Which electrode is looked at.
    pub electrode: usize,
    /// Distance withdrawn (mm).
    pub s: f64,
    /// Whether it moves by itself.
    pub playing: bool,
    /// How fast (mm/s).
    pub speed: f64,
}

/// A line of the log.
#[derive(Debug, Clone, PartialEq)]
pub struct LogLine {
    /// When.
    pub at: SystemTime,
    /// What kind of news.
    pub kind: EventKind,
    /// In one sentence.
    pub text: String,
}

/// What a track was made from: the plan's address or the number of nodes found so far.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
enum TrackSource {
    #[default]
    Nothing,
    Plan(usize, usize),
    Partial(usize),
}

impl Core {
    /// A window's state on `document`.
    ///
    /// # Errors
    /// If the system gives no thread to work on.
    pub fn new(
        document: Document,
        preferences: Preferences,
        wake: impl Fn() + Send + Sync + 'static,
    ) -> std::io::Result<Self> {
        Ok(Self {
            document,
            pipeline: Pipeline::start(wake)?,
            preferences,
            step: Stage::Part,
            cursor: Cursor { electrode: 0, s: 0.0, playing: false, speed: 10.0 },
            layers: Layers::default(),
            selected: None,
            section: None,
            colours: false,
            measuring: false,
            log: Vec::new(),
            track: Arc::default(),
            track_of: TrackSource::default(),
            commands: Vec::new(),
            gesture: 0,
        })
    }

    /// Asks for `command` at the end of the frame.
    pub fn push(&mut self, command: Command) {
        self.commands.push(command);
    }

    /// The commands asked for since the last call.
    pub fn take_commands(&mut self) -> Vec<Command> {
        std::mem::take(&mut self.commands)
    }

    /// Takes in what the worker has said. Answers what has happened.
    pub fn follow(&mut self) -> Vec<Event> {
        let events = self.pipeline.follow(&mut self.document);
        for event in &events {
            self.say(event.kind, format!("{}: {}", event.stage.name(), event.text));
        }
        self.follow_track();
        events
    }

    /// Adds a line to the log.
    pub fn say(&mut self, kind: EventKind, text: impl Into<String>) {
        self.log.push(LogLine { at: SystemTime::now(), kind, text: text.into() });
    }

    /// Changes parameters. `dragging` tells that more changes of the same kind may follow at once.
    pub fn edit(&mut self, label: &str, job: PlanJob, dragging: bool) {
        self.document.edit(label, job, dragging.then_some(self.gesture));
        if !dragging {
            self.gesture += 1;
        }
    }

    /// Ends what was one gesture: the button is released, the field is left.
    pub fn end_gesture(&mut self) {
        self.gesture += 1;
    }

    /// Whether a plan can be started.
    pub fn can_plan(&self) -> bool {
        self.pipeline.state(Stage::Electrode) == StageState::Done
            && self.pipeline.state(Stage::Plan) != StageState::Running
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

    fn follow_track(&mut self) {
        self.cursor.electrode = self.cursor.electrode.min(self.electrode_count().saturating_sub(1));
        let partial = self.pipeline.partial_plan().filter(|p| !p.nodes.is_empty());
        let source = match (partial, self.pipeline.plan()) {
            (Some(partial), _) => TrackSource::Partial(partial.nodes.len()),
            (None, Some(plan)) => TrackSource::Plan(Arc::as_ptr(plan) as usize, self.cursor.electrode),
            (None, None) => TrackSource::Nothing,
        };
        if source == self.track_of {
            return;
        }
        let track = match (source, partial, self.outcome()) {
            (TrackSource::Partial(_), Some(partial), _) => Track::of_nodes(&partial.nodes),
            (TrackSource::Plan(..), _, Some(outcome)) => Track::of_plan(&outcome.plan),
            _ => Track::default(),
        };
        // While nodes are found the electrode goes along with the last of them.
        if matches!(source, TrackSource::Partial(_)) {
            self.cursor.s = track.length();
        }
        self.cursor.s = self.cursor.s.min(track.length());
        (self.track, self.track_of) = (Arc::new(track), source);
    }

    /// Moves the playing cursor on by `elapsed`. Tells whether it still moves.
    pub fn advance(&mut self, elapsed: Duration) -> bool {
        if !self.cursor.playing {
            return false;
        }
        self.cursor.s -= self.cursor.speed * elapsed.as_secs_f64();
        if self.cursor.s <= 0.0 {
            self.cursor.s = 0.0;
            self.cursor.playing = false;
        }
        self.cursor.playing
    }

    /// Where the electrode comes closest or jams, in one point of the electrode in its final pose and one of the
    /// blisk, both in W.
    pub fn contact(&self) -> Option<[DVec3; 2]> {
        let plan = &self.outcome()?.plan;
        if let Some(jam) = &plan.jam {
            return jam.contact().map(|c| [c.on_electrode, c.on_blisk]);
        }
        let least = plan.path.as_ref()?.certificate.least();
        Some([least.on_electrode, least.on_blisk])
    }

    /// Withdrawn distance at which that is (mm).
    pub fn contact_s(&self) -> Option<f64> {
        let plan = &self.outcome()?.plan;
        plan.jam.map(|j| j.s).or_else(|| Some(plan.path.as_ref()?.certificate.least().s))
    }

    /// Whether what is shown of the plan belongs to other parameters.
    pub fn plan_is_stale(&self) -> bool {
        self.pipeline.state(Stage::Plan) == StageState::Stale
    }
}
