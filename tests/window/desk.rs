//! A window without a screen, with folders of its own, and the hands of its user.

use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, channel};

use egui::{Key, Modifiers, Role, pos2, vec2};
use egui_kittest::kittest::{By, Queryable as _};
use egui_kittest::{Harness, HarnessBuilder, Node};
use feed::plan_params::Strategy;
use files::AnyDocument as _;
use import::write_stl;
use sparkpath::shell::run::{Folders, Opening, SparkpathApp};
use sparkpath::workspaces::blisk::document::Document;
use sparkpath::workspaces::blisk::document::job_file::PlanJob;
use sparkpath::workspaces::blisk::document::stage::Stage;
use sparkpath::workspaces::blisk::{BliskDesk, BliskWorkspace};
use sparkpath::workspaces::preferences::Preferences;
use task::State;
use tempfile::TempDir;
use wheel::electrode::EnterSide;
use wheel::parametric::ParametricBlisk;

use crate::common::mesh;

/// How much later each frame is than the one before it (s): the window has no other clock.
const FRAME: f32 = 0.25;

/// Where a user's files and the program's own are.
pub struct Home {
    folder: TempDir,
}

/// So many frames in which nothing is worked on are more than anything waits: 100 s.
const IDLE: usize = 400;

impl Home {
    /// Those of a user who wants no preview of each change, which takes longer than most that is tried here.
    pub fn new() -> Self {
        let home = Self { folder: tempfile::tempdir().unwrap() };
        Preferences { live: false, ..Preferences::default() }.write(&home.folders().config).unwrap();
        home
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    pub fn folders(&self) -> Folders {
        let [config, autosave, results] = ["config", "autosave", "results"].map(|name| self.path(name));
        Folders { config, autosave, results }
    }

    /// Writes the mesh of `blisk`.
    pub fn part(&self, blisk: &ParametricBlisk) -> PathBuf {
        let file = self.path("part.stl");
        write_stl(&file, &mesh(blisk)).unwrap();
        file
    }

    /// Writes the mesh of `blisk`, and a project of it with a quick search and what `change` does to that.
    pub fn project(&self, blisk: &ParametricBlisk, change: impl FnOnce(&mut PlanJob)) -> PathBuf {
        let mut job = quick(PlanJob::for_mesh(&self.part(blisk)));
        change(&mut job);
        let file = self.path("part.sparkpath");
        Document::new(job).save_as(&file).unwrap();
        file
    }

    /// Starts the program on `opening`, in a window of the usual size.
    pub fn start(&self, opening: Opening) -> Desk {
        self.start_in(opening, [1280, 720], 1.0)
    }

    /// Starts the program on `opening` in a window of so many pixels, of which `scale` make a point.
    pub fn start_in(&self, opening: Opening, pixels: [u16; 2], scale: f32) -> Desk {
        let folders = self.folders();
        let [width, height] = pixels.map(f32::from);
        let window = Harness::builder().with_size(vec2(width, height) / scale).with_pixels_per_point(scale);
        Desk::start(window, move |cc| SparkpathApp::new(cc, &opening, Some(folders)).unwrap())
    }
}

/// The window, and what a user does at it.
pub struct Desk {
    pub window: Harness<'static, SparkpathApp>,
    /// Told whenever a frame is wanted at once.
    woken: Receiver<()>,
}

impl Desk {
    /// The program that `make` starts, in this window.
    pub fn start(
        window: HarnessBuilder<SparkpathApp>,
        make: impl FnOnce(&eframe::CreationContext) -> SparkpathApp,
    ) -> Self {
        let (wake, woken) = channel();
        let window = window.with_step_dt(FRAME).wgpu().build_eframe(move |cc| {
            cc.egui_ctx.set_request_repaint_callback(move |asked| {
                // Nobody listens any more once the window is closed.
                if asked.delay.is_zero() {
                    wake.send(()).unwrap_or(());
                }
            });
            make(cc)
        });
        let mut desk = Self { window, woken };
        // No dialog of the system may open, which nobody would answer.
        desk.window.state_mut().type_paths();
        desk
    }

    pub fn app(&self) -> &SparkpathApp {
        self.window.state()
    }

    pub fn blisk(&self) -> &BliskDesk {
        &self.app().workspace::<BliskWorkspace>().unwrap().desk
    }

    pub fn blisk_mut(&mut self) -> &mut BliskDesk {
        &mut self.window.state_mut().workspace_mut::<BliskWorkspace>().unwrap().desk
    }

    pub fn state(&self, stage: Stage) -> State {
        self.blisk().work.state(stage)
    }

    /// Goes on until `is` holds: with the next frame as soon as there is something new, and at once while nothing is
    /// worked on. Fails where nothing can become of it any more.
    #[track_caller]
    pub fn until(&mut self, what: &str, is: impl Fn(&Self) -> bool) {
        let mut idle = 0;
        while !is(self) {
            if self.app().is_busy() {
                self.await_wake();
                idle = 0;
            }
            assert!(idle < IDLE, "waited in vain until {what}; the log: {:#?}", self.log());
            idle += 1;
            self.window.step();
        }
        self.settle();
    }

    /// Waits until a frame is wanted. One frame answers all that wanted one before it.
    pub fn await_wake(&self) {
        self.woken.recv().unwrap();
        self.woken.try_iter().for_each(drop);
    }

    /// Lets so many seconds pass.
    pub fn wait(&mut self, seconds: f32) {
        self.window.run_steps((seconds / FRAME).ceil() as usize);
    }

    /// A few frames, so that everything shows what is known; what is opened is open then, and shown.
    pub fn settle(&mut self) {
        const FRAMES: usize = 4;
        let mut left = FRAMES;
        while left > 0 {
            self.window.step();
            left -= 1;
            while self.app().is_opening() {
                self.await_wake();
                self.window.step();
                left = FRAMES;
            }
        }
    }

    /// Until nothing is worked on.
    pub fn until_idle(&mut self) {
        self.settle();
        self.until("all work is done", |desk| !desk.blisk().work.is_busy());
        // The end of one step may be the beginning of the next.
        while self.blisk().work.is_busy() {
            self.until("all work is done", |desk| !desk.blisk().work.is_busy());
        }
    }

    /// Until `stage` is done, whatever follows it.
    #[track_caller]
    pub fn until_done(&mut self, stage: Stage) {
        self.settle();
        self.until("the step is done", |desk| desk.state(stage) == State::Ready);
    }

    pub fn log(&self) -> Vec<String> {
        self.app().context().log.iter().map(|line| line.text.clone()).collect()
    }

    /// Whether a text that contains `text` is anywhere in the window.
    pub fn shows(&self, text: &str) -> bool {
        self.window.query_all_by_label_contains(text).next().is_some()
    }

    #[track_caller]
    pub fn assert_shows(&self, text: &str) {
        assert!(self.shows(text), "nothing in the window says \"{text}\"; the log: {:#?}", self.log());
    }

    #[track_caller]
    pub fn find<'a>(&'a self, role: Role, name: &'a str) -> Node<'a> {
        let all: Vec<Node<'a>> = self.window.query_all(By::new().role(role).label(name)).collect();
        *all.first().unwrap_or_else(|| panic!("there is no {role:?} called \"{name}\""))
    }

    /// Scrolls to a control and presses it with the mouse.
    #[track_caller]
    pub fn press_role(&mut self, role: Role, name: &str) {
        self.find(role, name).scroll_to_me();
        self.settle();
        // The middle of a row may lie beside what is seen of its table.
        if role == Role::Row {
            self.find(role, name).click_accesskit()
        } else {
            self.find(role, name).click()
        }
        self.settle();
        self.window.remove_cursor();
        self.settle();
    }

    #[track_caller]
    pub fn press(&mut self, button: &str) {
        self.press_role(Role::Button, button);
    }

    /// Opens the form of a step.
    #[track_caller]
    pub fn open_step(&mut self, stage: Stage) {
        let name = format!("{} {}", stage.number(), stage.name());
        let tab = self.window.query_all(By::new().role(Role::Tab).label_contains(&name)).next();
        tab.unwrap_or_else(|| panic!("there is no step {name}")).click();
        self.settle();
        self.window.remove_cursor();
        self.settle();
    }

    /// What the stepper says of a step: "4 Plan, done".
    pub fn step_says(&self, stage: Stage, word: &str) -> bool {
        let name = format!("{} {}, {word}", stage.number(), stage.name());
        self.window.query(By::new().role(Role::Tab).label(&name)).is_some()
    }

    /// Types `text` into the number called `name`.
    #[track_caller]
    pub fn enter(&mut self, name: &str, text: &str) {
        self.press_role(Role::SpinButton, name);
        self.window.event(egui::Event::Text(text.to_owned()));
        self.settle();
        self.key(Key::Enter);
    }

    /// Types a path that is asked for.
    #[track_caller]
    pub fn type_path(&mut self, path: &Path) {
        self.assert_shows("Type or paste the path");
        self.window.event(egui::Event::Text(path.to_str().unwrap().to_owned()));
        self.settle();
        self.key(Key::Enter);
    }

    /// Drags the slider called `name` from its place to `fraction` of its range, in `moves` movements.
    #[track_caller]
    pub fn slide(&mut self, name: &str, fraction: f32, moves: u32) {
        let rail = self.find(Role::Slider, name).rect();
        let goal = pos2(rail.left() + fraction * rail.width(), rail.center().y);
        let start = pos2(rail.left() + 0.1 * rail.width(), rail.center().y);
        self.window.hover_at(start);
        self.window.drag_at(start);
        for i in 1..=moves {
            self.window.step();
            self.window.hover_at(start.lerp(goal, i as f32 / moves as f32));
        }
        self.settle();
        self.window.drop_at(goal);
        self.settle();
    }

    pub fn key(&mut self, key: Key) {
        self.key_with(Modifiers::NONE, key);
    }

    pub fn key_with(&mut self, modifiers: Modifiers, key: Key) {
        self.window.key_press_modifiers(modifiers, key);
        self.settle();
    }

    /// Makes the search a small one, as a user would who types the numbers in.
    pub fn quicken(&mut self) {
        let core = self.blisk_mut();
        let job = quick(core.document.params().clone());
        core.edit("Small search", job, false);
        self.until_idle();
    }
}

/// `job` with a genetic search that takes a second, and which nothing begins but its user.
pub fn quick(mut job: PlanJob) -> PlanJob {
    job.plan.strategy = Strategy::Genetic;
    job.electrode.enter = EnterSide::MinusX;
    job.genetic.population = 16;
    job.genetic.generations = 6;
    job.plan.step_mm = 1.6;
    job.plan.field_cell_mm = 1.2;
    // Few rows, each of which is verified and simulated.
    job.plan.interpolation.chord_error_mm = 0.05;
    job
}

/// Whether `folder` holds a file whose name ends with `end`.
pub fn holds(folder: &Path, end: &str) -> bool {
    let Ok(entries) = std::fs::read_dir(folder) else { return false };
    entries.flatten().any(|e| e.file_name().to_string_lossy().ends_with(end))
}
