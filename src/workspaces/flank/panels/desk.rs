//! The state of the workspace: the flank, the results made from it, and how they are shown.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use glam::DVec3;

use crate::workspaces::context::rest_left;
use crate::workspaces::flank::comparison::{Quantity, Row, Sweep, Variant};
use crate::workspaces::flank::document::cutter_list::{standard_cutters, user_cutters};
use crate::workspaces::flank::document::milling_machine_file::{load_milling_machines, milling_machine};
use crate::workspaces::flank::document::{FlankDocument, FlankSource, GuideSource, PathChoice, fields};
use crate::workspaces::flank::work::{ExportChoice, FlankWork, Planned, Sketch};
use crate::workspaces::hands::{Gesture, Hands};
use crate::workspaces::news::{EventKind, WorkEvent};
use files::paths::user_folder;
use files::{AnyDocument, Document};
use flank::cutter::FlankCutter;
use flank::machine::milling_machine::Workpiece;
use flank::path::FlankPath;
use flank::ruled_surface::Side;
use nc::flank_job::path_of;
use task::{Priority, Scheduler, State};

/// Delay after the last change until a previewed plan is computed in full (s).
const REST: f64 = 0.3;
/// Duration of playing the whole path (s).
const WAY: f64 = 8.0;

/// Target of a flight of the view.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Fly {
    /// Onto the surface, from the cutter's side.
    Onto,
    /// Perpendicular to the surface.
    Square,
    /// To a place (mm).
    Place(DVec3),
}

/// State of the shown result.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Standing {
    /// There is no result.
    Nothing,
    /// A preview.
    Sketch,
    /// The plan of other parameters.
    Stale,
    /// The plan of the present parameters.
    Planned,
}

/// A plot of the panel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Tab {
    /// Sum of deviations over the rank.
    Ranks,
    /// Deviations along the guides, with the position of the cutter.
    Deviation,
    /// The machine's axes.
    Machine,
    /// Figures of the plans side by side over a quantity.
    Sweep,
}

/// The flank, the results made from it, and how they are shown.
pub struct FlankDesk {
    /// Whether the panel on the left is open.
    pub shows_panel: bool,
    /// Whether the panel of results is open, where the results have their own panel.
    pub shows_list: bool,
    /// Whether the panel on the left shows the results, where these have no panel of their own.
    pub shows_figures: bool,
    /// Whether plots are shown in a window too low for both plots and view.
    pub shows_plots: bool,
    /// The flank.
    pub document: Document<FlankDocument>,
    /// Parameters of the last frame.
    followed: FlankDocument,
    gesture: Gesture,
    /// Results computed from the flank.
    pub work: FlankWork,
    /// Whether a change starts a new plan, once there is one.
    pub follows: bool,
    /// Path that is shown.
    pub path: PathChoice,
    /// Whether all three paths are shown, side by side.
    pub is_side_by_side: bool,
    /// Whether the deviations shown are those of the swept envelope.
    pub is_moving: bool,
    /// Whether the cutter is shown: for one path, and for paths side by side, whose maps it covers.
    shows_cutters: [bool; 2],
    /// Whether the surface that the cutter's axis sweeps is shown.
    pub shows_axis: bool,
    /// Whether rulings are drawn.
    pub shows_rulings: bool,
    /// Position of the cutter on the path, 0 to 1.
    pub t: f64,
    /// Whether the motion is played.
    pub is_playing: bool,
    /// The plot that is shown.
    pub tab: Tab,
    /// The rank that was clicked in the plot of ranks.
    pub rank: Option<usize>,
    /// Whether limits are drawn where they are in the plots of the machine.
    pub shows_limits: bool,
    /// Place under the pointer (mm).
    pub place: Option<DVec3>,
    /// Target of the next flight of the view.
    pub fly: Option<Fly>,
    /// The files that are written.
    pub choice: ExportChoice,
    /// Names and titles of the available machines.
    pub machines: Vec<[String; 2]>,
    /// The cutters to choose from.
    pub cutters: Vec<FlankCutter>,
    /// Plans side by side that the user keeps.
    kept: Vec<Row>,
    /// Plans side by side of the last sweep or list of cutters.
    pub compared: Vec<Row>,
    /// The sweep that is asked for next, whose quantity plans side by side are plotted over.
    pub sweep: Sweep,
    /// Whether the sweep is to be started.
    pub wants_sweep: bool,
    /// Files that had changed since they were read, when an export was last asked for.
    pub changed_files: Vec<PathBuf>,
    /// The lower guide, until the upper one is named.
    pub first_guide: Option<PathBuf>,
    /// Number of changes of the flank.
    revision: u64,
    /// The machine looked up last, with the workpiece position in its file, if there is such a machine.
    clamped: (String, Option<Workpiece>),
    /// The time of the last frame (s).
    now: f64,
    /// Time of the last change without a plan.
    edited: Option<f64>,
    shown: Option<Arc<Planned>>,
    /// Surface that the view has flown to.
    looked_at: Option<FlankSource>,
    standing: Standing,
}

impl FlankDesk {
    /// The state with a built-in surface.
    pub fn new(scheduler: &Scheduler) -> Self {
        Self {
            shows_panel: true,
            shows_list: true,
            shows_figures: false,
            shows_plots: false,
            document: Document::default(),
            followed: FlankDocument::default(),
            gesture: Gesture::default(),
            work: FlankWork::new(scheduler),
            follows: true,
            path: PathChoice::Refined,
            is_side_by_side: false,
            is_moving: false,
            shows_cutters: [true, false],
            shows_axis: false,
            shows_rulings: true,
            t: 0.5,
            is_playing: false,
            tab: Tab::Ranks,
            rank: None,
            shows_limits: false,
            place: None,
            fly: None,
            choice: ExportChoice::ALL,
            // Those of a broken file would be none: the one that the flank names is there in any case.
            machines: load_milling_machines(user_folder().as_deref())
                .unwrap_or_default()
                .into_iter()
                .map(|m| [m.name, m.title])
                .collect(),
            cutters: user_cutters(user_folder().as_deref()).or_else(|_| standard_cutters()).unwrap_or_default().cutter,
            kept: Vec::new(),
            compared: Vec::new(),
            sweep: Quantity::Radius.usual(),
            wants_sweep: false,
            changed_files: Vec::new(),
            first_guide: None,
            revision: 0,
            clamped: (String::new(), None),
            now: 0.0,
            edited: None,
            shown: None,
            looked_at: None,
            standing: Standing::Nothing,
        }
    }

    /// The parameters.
    pub fn params(&self) -> &FlankDocument {
        self.document.params()
    }

    /// Replaces the document.
    pub fn replace(&mut self, document: Document<FlankDocument>) {
        if self.params().source == document.params().source {
            self.work.reload();
        } else {
            // What is opened is looked at by itself first.
            self.is_side_by_side = false;
        }
        self.document = document;
        self.followed = self.params().clone();
        (self.path, self.rank, self.place, self.edited) = (self.followed.path, None, None, None);
        self.revision += 1;
        self.work.forget_sketch();
        self.clear_rows();
    }

    /// Project file of the document, or a file of its surface.
    pub fn file(&self) -> Option<&Path> {
        let source = match &self.params().source {
            FlankSource::Demonstration { .. } => None,
            FlankSource::Guides { lower: GuideSource::File(file), .. } => Some(file.as_path()),
            FlankSource::Guides { .. } => None,
            FlankSource::Mesh(mesh) => Some(mesh.file.as_path()).filter(|_| mesh.kept.is_none()),
        };
        self.document.file().or(source)
    }

    /// Changes the parameters. While they go on changing they are previewed.
    pub fn edit(&mut self, mut params: FlankDocument) {
        let label = fields::change(self.params(), &params);
        params.cutter.forget_stale_name(&self.params().cutter);
        self.document.edit(&label, params, self.gesture.goes_on());
        self.follow_params();
    }

    /// Notes a change of the parameters.
    fn follow_params(&mut self) {
        let params = self.document.params();
        if *params == self.followed {
            return;
        }
        // What is exported in spite of a check changes no path.
        let is_asked_anew =
            FlankDocument { overrides: self.followed.overrides.clone(), ..params.clone() } != self.followed;
        if params.path != self.followed.path {
            self.path = params.path;
        }
        self.followed = params.clone();
        if is_asked_anew {
            (self.edited, self.place) = (Some(self.now), None);
            self.revision += 1;
        }
    }

    /// Number of changes and replacements of the flank.
    pub fn revision(&self) -> u64 {
        self.revision
    }

    /// Position of workpieces on the machine as its file gives it; none without a machine that can be read.
    pub fn workpiece_of_machine(&self) -> Option<&Workpiece> {
        self.clamped.1.as_ref().filter(|_| self.clamped.0 == self.document.params().milling.machine)
    }

    /// State of the plan of the present parameters.
    pub fn state(&self) -> State {
        self.work.state(self.document.params())
    }

    /// Whether a plan can be started.
    pub fn can_plan(&self) -> bool {
        self.document.problem().is_none() && self.state() != State::Running
    }

    /// Whether the shown result is the plan of the present parameters.
    pub fn is_planned(&self) -> bool {
        self.standing == Standing::Planned
    }

    /// State of the shown result.
    pub fn standing(&self) -> Standing {
        self.standing
    }

    /// Starts the plan.
    ///
    /// # Errors
    /// One line why the flank cannot be planned.
    pub fn plan(&mut self) -> Result<(), String> {
        self.edited = None;
        self.work.plan(self.document.params())
    }

    /// What plans that are compared may differ in, as it is now.
    pub fn variant(&self) -> Variant {
        let params = self.document.params();
        Variant { cutter: params.cutter.clone(), control_points: params.plan.control_points }
    }

    /// Starts plans with each cutter of the list.
    ///
    /// # Errors
    /// One line why the flank cannot be planned.
    pub fn compare_cutters(&mut self) -> Result<(), String> {
        let of = |cutter: &FlankCutter| Variant { cutter: cutter.clone(), ..self.variant() };
        let variants: Vec<Variant> = self.cutters.iter().map(of).collect();
        self.work.compare(self.document.params(), &variants)
    }

    /// Starts plans at the steps of the sweep, and shows their plot.
    ///
    /// # Errors
    /// One line why the flank cannot be planned.
    fn start_sweep(&mut self) -> Result<(), String> {
        self.work.compare(self.document.params(), &self.sweep.variants(&self.variant()))?;
        self.tab = Tab::Sweep;
        Ok(())
    }

    /// Keeps the plan that is shown beside others. Check [`is_planned`](Self::is_planned) first.
    pub fn keep(&mut self) {
        self.kept.extend(self.shown.as_ref().map(|planned| Row::of(&planned.result)));
    }

    /// All plans side by side, the kept ones first.
    pub fn rows(&self) -> Vec<Row> {
        [&self.kept[..], &self.compared].concat()
    }

    /// Forgets all plans side by side.
    pub fn clear_rows(&mut self) {
        self.kept.clear();
        self.compared.clear();
    }

    /// Takes a cutter.
    pub fn take_cutter(&mut self, cutter: FlankCutter) {
        self.take(Variant { cutter, ..self.variant() });
    }

    /// Takes what a plan beside others was made with.
    pub fn take(&mut self, Variant { cutter, control_points }: Variant) {
        let mut params = FlankDocument { cutter, ..self.document.params().clone() };
        params.plan.control_points = control_points;
        let label = fields::change(self.document.params(), &params);
        self.document.edit(&label, params, false);
        self.follow_params();
    }

    /// Takes in finished work, once a frame. Nothing is computed for a flank that nobody has seen (`is_seen`). Returns
    /// the reports, and the time until the next action.
    pub fn follow(&mut self, hands: Hands, is_seen: bool, now: f64) -> (Vec<WorkEvent>, Option<Duration>) {
        self.now = now;
        self.gesture.follow(hands, &mut self.document);
        self.follow_params();
        let machine = &self.document.params().milling.machine;
        if is_seen && self.clamped.0 != *machine {
            let found = milling_machine(machine, user_folder().as_deref()).ok();
            self.clamped = (machine.clone(), found.map(|machine| machine.workpiece));
        }
        if !is_seen && !self.work.is_busy() {
            return (Vec::new(), None);
        }
        let priority = if is_seen { Priority::Shown } else { Priority::Normal };
        let mut events = self.work.follow(self.document.params(), priority);
        if std::mem::take(&mut self.wants_sweep)
            && let Err(text) = self.start_sweep()
        {
            events.push(WorkEvent { kind: EventKind::Failed, text: format!("Sweep: {text}"), took: None });
        }
        if let Some(rows) = self.work.take_compared() {
            self.compared = rows.to_vec();
        }
        self.work.files(self.document.params()).iter().for_each(|file| self.document.note_file(file));
        let state = self.state();
        let is_valid = self.document.problem().is_none();
        // While it is planned for the first time the surface is shown at once.
        let is_first = state == State::Running && matches!(self.surface_from(), (None, None));
        if is_valid && (is_first || !matches!(state, State::Ready | State::Running)) {
            self.work.sketch(self.document.params());
        }
        self.follow_answer();
        if state == State::Ready {
            self.edited = None;
        }
        let Some(edited) = self.edited.filter(|_| self.follows && is_valid && state == State::Stale) else {
            return (events, None);
        };
        if hands == Hands::Holding {
            return (events, None);
        }
        let wait = rest_left(edited, REST, self.now);
        if !wait.is_zero() {
            return (events, Some(wait));
        }
        if let Err(text) = self.plan() {
            events.push(WorkEvent { kind: EventKind::Failed, text: format!("Flank: {text}"), took: None });
        }
        (events, None)
    }

    /// Chooses the result to show.
    fn follow_answer(&mut self) {
        let is_planned = self.work.is_planned_of(self.document.params());
        let sketched = self.sketched().and_then(|sketch| sketch.planned.as_ref().ok()).cloned();
        let (shown, standing) = match (self.work.planned().cloned(), sketched) {
            (Some(planned), _) if is_planned => (Some(planned), Standing::Planned),
            (_, Some(sketch)) => (Some(sketch), Standing::Sketch),
            // What cannot be planned has no deviations, and another surface has others.
            _ if self.why_not().is_some() => (None, Standing::Nothing),
            (Some(planned), _) if self.work.is_planned_of_surface(self.document.params()) => {
                (Some(planned), Standing::Stale)
            }
            _ => (None, Standing::Nothing),
        };
        let is_seen = shown.is_some() || self.open_side().is_some();
        let is_first = is_seen && self.looked_at.as_ref() != Some(&self.document.params().source);
        if shown.as_ref().map(Arc::as_ptr) != self.shown.as_ref().map(Arc::as_ptr) {
            self.rank = None;
        }
        (self.shown, self.standing) = (shown, standing);
        if is_first {
            self.looked_at = Some(self.document.params().source.clone());
        }
        if is_first && self.fly.is_none() {
            self.fly = Some(if self.is_side_by_side { Fly::Square } else { Fly::Onto });
        }
    }

    /// The plan or the preview that gives the present surface, for any cutter.
    pub fn surface_from(&self) -> (Option<&Arc<Planned>>, Option<&Arc<Sketch>>) {
        let is_same = self.work.is_planned_of_surface(self.document.params());
        let planned = self.shown.as_ref().or(self.work.planned().filter(|_| is_same));
        let sketch = self.work.sketched(self.document.params(), true).filter(|_| planned.is_none());
        (planned, sketch)
    }

    /// The preview of the present parameters, or while they are dragged of the last ones.
    pub fn sketched(&self) -> Option<&Arc<Sketch>> {
        self.work.sketched(self.document.params(), self.gesture.is_holding())
    }

    /// Reason why there is no path with the present parameters, if known.
    pub fn why_not(&self) -> Option<String> {
        if let Some(why) = self.document.problem() {
            return Some(fields::FIELDS.in_window(why));
        }
        for state in [
            self.work.source_state(self.document.params()),
            self.work.walls_state(self.document.params()),
            self.state(),
        ] {
            if let Some(why) = state.why_not() {
                return Some(why.to_owned());
            }
        }
        self.work.sketched(self.document.params(), false).and_then(|sketch| sketch.planned.as_ref().err().cloned())
    }

    /// Where the user must choose the side of the cutter before there can be a path: see [`Sketch::open_side`].
    pub fn open_side(&self) -> Option<[DVec3; 2]> {
        self.work.sketched(self.document.params(), false)?.open_side
    }

    /// Sets the side of the cutter.
    pub fn choose_side(&mut self, side: Side) {
        self.edit(FlankDocument { side, ..self.document.params().clone() });
    }

    /// The shown result: the plan of the present parameters, a preview, or the plan of other parameters; see
    /// [`Self::standing`].
    pub fn planned(&self) -> Option<&Arc<Planned>> {
        self.shown.as_ref()
    }

    /// The path that is shown.
    pub fn shown_path(&self) -> Option<&FlankPath> {
        Some(path_of(&self.shown.as_ref()?.result.plan, self.path))
    }

    /// The paths that the view shows.
    pub fn shown_paths(&self) -> Vec<PathChoice> {
        if self.is_side_by_side { PathChoice::ALL.to_vec() } else { vec![self.path] }
    }

    /// Whether the cutter is shown.
    pub fn shows_cutter(&self) -> bool {
        self.shows_cutters[usize::from(self.is_side_by_side)]
    }

    /// Shows or hides the cutter.
    pub fn toggle_cutter(&mut self) {
        let shows = &mut self.shows_cutters[usize::from(self.is_side_by_side)];
        *shows = !*shows;
    }

    /// Moves the cutter to `t` and stops playing.
    pub fn go_to(&mut self, t: f64) {
        (self.t, self.is_playing) = (t.clamp(0.0, 1.0), false);
    }

    /// Moves the cutter by one location, forwards or backwards.
    pub fn step(&mut self, forward: bool) {
        let places = self.shown_path().map_or(1, |path| path.poses.len().max(2) - 1) as f64;
        let at = self.t * places;
        let next = if forward { (at + 1e-6).floor() + 1.0 } else { (at - 1e-6).ceil() - 1.0 };
        self.go_to(next / places);
    }

    /// Starts or stops playing.
    pub fn play(&mut self) {
        self.is_playing = !self.is_playing;
        if self.is_playing && self.t >= 1.0 {
            self.t = 0.0;
        }
    }

    /// Advances a playing motion by `seconds`.
    pub fn advance(&mut self, seconds: f64) {
        if self.is_playing {
            self.t = (self.t + seconds / WAY).min(1.0);
            self.is_playing = self.t < 1.0;
        }
    }

    /// Marks a place, moves the cutter to `t` if that is known, and flies there.
    pub fn point_at(&mut self, place: DVec3, t: Option<f64>) {
        (self.place, self.fly) = (Some(place), Some(Fly::Place(place)));
        // The checks are of the path that is milled.
        (self.path, self.is_side_by_side) = (self.document.params().path, false);
        t.into_iter().for_each(|t| self.go_to(t));
    }
}
