//! The workspace of flanks.

use std::path::Path;
use task::State;
use wheel::electrode::ElectrodeFace;

use egui::{Key, Modifiers, Role};
use egui_kittest::kittest::{By, Queryable as _};
use files::{AnyDocument, Document};
use flank::ruled_surface::Side;
use glam::DVec3;
use nc::approved_flank::ApprovedFlank;
use nc::flank_job::LoadedSurface;
use nc::flank_program::{FlankNc, TipControl};
use sparkpath::shell::run::Opening;
use sparkpath::workspaces::blisk::document::stage::Stage;
use sparkpath::workspaces::flank::FlankWorkspace;
use sparkpath::workspaces::flank::comparison::{Quantity, Sweep};
use sparkpath::workspaces::flank::document::{FlankDocument, FlankSource, GuideSource, PathChoice};
use sparkpath::workspaces::flank::panels::desk::{FlankDesk, Tab};
use sparkpath::workspaces::flank::work::ExportChoice;

use crate::common::easy_blisk;
use crate::desk::{Desk, Home};

impl Home {
    /// A flank that is planned in no time: the paper's surface A on a coarse grid.
    fn flank(&self) -> Opening {
        self.flank_with(|_| {})
    }

    /// The same after a change.
    fn flank_with(&self, change: impl FnOnce(&mut FlankDocument)) -> Opening {
        let mut document = FlankDocument::default();
        document.plan.grid = [40, 20];
        document.side = Side::Positive;
        change(&mut document);
        let file = self.path("coarse.sparkpath");
        Document::new(document).export(&file).unwrap();
        Opening::File(file)
    }
}

impl Desk {
    pub fn flank(&self) -> &FlankDesk {
        &self.app().workspace::<FlankWorkspace>().unwrap().desk
    }

    pub fn flank_mut(&mut self) -> &mut FlankDesk {
        &mut self.window.state_mut().workspace_mut::<FlankWorkspace>().unwrap().desk
    }

    fn until_planned(&mut self) {
        self.until("the flank is planned", |desk| desk.flank().state() == State::Ready && desk.flank().is_planned());
        self.settle();
    }

    /// The objects of the scene that have colours of deviations.
    fn coloured(&self) -> usize {
        self.app().scene().objects.iter().filter(|o| o.values.is_some()).count()
    }
}

#[test]
fn a_flank_is_planned_looked_at_and_exported() {
    let home = Home::new();
    let mut desk = home.start(home.flank());
    assert_eq!(desk.app().shown(), "flank");
    desk.until("it is looked at quickly", |desk| desk.flank().planned().is_some());
    assert_eq!((desk.flank().is_planned(), desk.coloured()), (false, 1));
    desk.assert_shows("Preview");
    desk.press("Plan");
    desk.until_planned();
    let planned = desk.flank().planned().unwrap().clone();
    let plan = &planned.result.plan;
    // Edges count for more on a coarse grid: on the one of 100 by 50 it is 0.54.
    assert!(plan.ratio(&plan.refined) < 0.62 && plan.ratio(&plan.chosen) < 0.65, "{}", planned.sentence());
    desk.assert_shows("40 × 20 samples");
    desk.key(Key::Num5);
    desk.pictures("flank");
    let plot = desk.window.get(By::new().role(Role::Image).label("Plot of ranks")).rect();
    desk.window.hover_at(plot.center());
    desk.window.drag_at(plot.center());
    desk.window.drop_at(plot.center());
    desk.settle();
    let rank = desk.flank().rank.unwrap();
    let sum = plan.ranks.sums[rank - 1].unwrap();
    desk.assert_shows(&format!("rank {rank}: sum {sum:.3} mm"));

    // Where the cutter stands.
    let cutter = |desk: &Desk| desk.app().scene().objects.last().unwrap().transform.translation;
    let start = cutter(&desk);
    desk.slide("Timeline", 0.9, 3);
    assert!((desk.flank().t - 0.9).abs() < 0.02 && cutter(&desk).distance(start) > 10.0, "{}", desk.flank().t);
    desk.press("Next location");
    let steps = desk.flank().t * 49.0;
    assert!((steps - steps.round()).abs() < 1e-9);
    desk.press("Deviation");
    desk.key(Key::V);
    assert_eq!(desk.coloured(), 3);
    desk.pictures("flank_side_by_side");
    desk.key(Key::V);
    desk.press_role(Role::Tab, "Path initial");
    assert_eq!(desk.flank().path, PathChoice::Initial);
    desk.press("Machine");
    desk.key(Key::A);
    desk.pictures("flank_machine");

    let folder = home.path("out");
    desk.key_with(Modifiers::COMMAND, Key::E);
    let failing: Vec<_> = planned.result.checks.iter().filter(|check| !check.holds).collect();
    assert_eq!(desk.shows("Blocked"), !failing.is_empty());
    desk.picture("flank_export_dark");
    desk.press("Cancel");
    for check in failing {
        desk.press_role(Role::CheckBox, &format!("Release despite failed check: {}", check.kind.name()));
    }
    desk.key_with(Modifiers::COMMAND, Key::E);
    desk.press("Choose folder…");
    desk.type_path(&folder);
    desk.until("it is exported", |desk| !desk.flank().work.is_busy());
    for file in ["flank.cl", "path.csv", "report.html"] {
        assert!(folder.join(file).exists(), "{file}; {:?}", desk.log());
    }
    assert!(desk.flank().is_planned(), "what is let pass changes no path");
}

#[test]
fn a_sweep_is_plotted_and_a_row_of_it_is_taken() {
    let home = Home::new();
    let mut desk = home.start(home.flank_with(|document| document.plan.grid = [30, 12]));
    desk.press("Plan");
    desk.until_planned();
    desk.press("Keep");
    assert_eq!(desk.flank().rows().len(), 1);
    desk.flank_mut().sweep = Sweep { of: Quantity::Taper, ends: [2.0, 8.0], count: 4 };
    desk.settle();
    desk.press("Sweep");
    desk.until("it is swept beside what was kept", |desk| desk.flank().rows().len() == 5);
    desk.settle();
    let tapers: Vec<f64> = desk.flank().compared.iter().map(|row| row.variant.cutter.taper_deg).collect();
    assert_eq!(tapers, [2.0, 4.0, 6.0, 8.0]);
    assert_eq!(desk.flank().tab, Tab::Sweep);
    desk.pictures("flank_sweep");
    desk.press("R1 8\u{b0}");
    assert_eq!(desk.flank().params().cutter.taper_deg, 8.0);
    // Plans beside it go into the report.
    desk.until_planned();
    let folder = home.path("out");
    let (document, rows) = (desk.flank().params().clone(), desk.flank().rows());
    desk.flank_mut().work.export(&document, &rows, &folder, ExportChoice::ALL).unwrap();
    desk.until("it is written", |_| folder.join("flank.json").exists());
    desk.until_idle();
    let table = std::fs::read_to_string(folder.join("compared.csv")).unwrap();
    assert_eq!(table.lines().count(), 6);
}

#[test]
fn a_cutter_is_changed_in_passing_refused_in_words_and_taken_back() {
    let home = Home::new();
    let mut desk = home.start_in(home.flank(), [1000, 700], 1.0);
    desk.press("Plan");
    desk.until_planned();
    let kept = desk.flank().document.params().clone();
    desk.slide("Radius", 0.5, 4);
    let radius = desk.flank().document.params().cutter.radius_mm;
    assert!(radius > 2.0, "{radius}");
    assert!(!desk.flank().is_planned(), "what is shown is of another cutter");
    // Half a second after the slider rests the plan follows by itself.
    desk.until_planned();
    assert_eq!(desk.flank().planned().unwrap().result.plan.cutter.radius_mm, radius);
    assert_eq!(desk.flank().document.params().cutter.name, "", "it is no cone R1 5 deg any more");
    assert_eq!(desk.flank().document.undo_label(false), Some("Radius"));
    desk.key_with(Modifiers::COMMAND, Key::Z);
    assert_eq!(*desk.flank().document.params(), kept, "one slide is one step");
    desk.until_planned();

    desk.enter("Flutes", "-3");
    desk.assert_shows("Flutes is -3");
    assert!(!desk.flank().can_plan());
    desk.until("nothing is worked on", |desk| !desk.flank().work.is_busy());
    desk.picture("flank_refused_1000_dark");
    desk.enter("Flutes", "5");
    desk.until("it is looked at", |desk| desk.flank().planned().is_some());
    desk.until_planned();
    desk.assert_shows("must be");
    assert!(!desk.flank().planned().unwrap().result.holds(), "too short a cutter is said to be so");
    desk.enter("Flutes", "long");
    desk.assert_shows("is not a number");
    assert_eq!(desk.flank().document.params().cutter.length_mm, 5.0);

    let file = home.path("mine.sparkpath");
    desk.key_with(Modifiers::COMMAND | Modifiers::SHIFT, Key::S);
    desk.type_path(&file);
    assert_eq!(Document::<FlankDocument>::open(&file).unwrap().params(), desk.flank().document.params());
    assert!(!desk.flank().document.is_unsaved());
}

#[test]
fn of_a_blocked_path_the_report_is_written_and_words_are_of_what_is_there() {
    let home = Home::new();
    let mut desk = home.start(home.flank());
    desk.press("Plan");
    desk.until_planned();
    desk.assert_shows("total absolute deviation");
    // Another workspace has words of its own.
    desk.window.state_mut().show("mold");
    desk.settle();
    assert!(!desk.shows("total absolute deviation"));
    desk.window.state_mut().show("flank");
    desk.settle();
    assert!(desk.app().last_said().is_some_and(|(_, is_stale)| !is_stale));
    desk.enter("Flutes", "5");
    assert!(desk.app().last_said().is_none_or(|(_, is_stale)| is_stale), "it is of longer flutes");
    desk.until("it is looked at", |desk| desk.flank().planned().is_some());
    desk.until_planned();
    let folder = home.path("out");
    desk.key_with(Modifiers::COMMAND, Key::E);
    desk.assert_shows("Only the report is written");
    desk.press_role(Role::CheckBox, "report.html, .json");
    desk.press("Report to folder…");
    desk.type_path(&folder);
    desk.until("it is exported", |desk| !desk.flank().work.is_busy());
    assert!(folder.join("report.html").exists() && !folder.join("flank.cl").exists(), "{:?}", desk.log());
    desk.assert_shows("no program was written");
}

#[test]
fn a_cutter_is_named_in_the_form_and_its_path_stays() {
    let home = Home::new();
    let mut desk = home.start(home.flank());
    desk.press("Plan");
    desk.until_planned();
    desk.press_role(Role::TextInput, "Name");
    desk.key_with(Modifiers::COMMAND, Key::A);
    desk.window.event(egui::Event::Text("my cone".to_owned()));
    desk.settle();
    assert_eq!(desk.flank().document.params().cutter.name, "cone R1 5 deg", "what is half typed changes nothing");
    desk.key(Key::Enter);
    assert_eq!(desk.flank().document.params().cutter.name, "my cone");
    assert!(desk.flank().is_planned(), "a name changes no path");
    let exported = desk.flank().work.to_export(desk.flank().document.params()).unwrap();
    assert_eq!(exported.plan.cutter.name, "my cone");
}

#[test]
fn one_guide_is_opened_with_its_fellow_or_waits_for_it_and_a_path_that_is_not_there_changes_nothing() {
    let home = Home::new();
    let [lower, upper, alone, other] =
        ["a_lower.csv", "a_upper.csv", "points.csv", "others.csv"].map(|name| home.path(name));
    for (file, z) in [(&lower, 0), (&upper, 10), (&alone, 0), (&other, 10)] {
        std::fs::write(file, format!("0,0,{z}\n10,2,{z}\n20,2,{z}\n30,0,{z}\n")).unwrap();
    }
    let mut desk = home.start(home.flank());
    let before = desk.flank().document.params().clone();
    let open = |desk: &mut Desk, path: &Path| {
        desk.key_with(Modifiers::COMMAND, Key::O);
        desk.type_path(path);
    };
    open(&mut desk, &home.path("no such.csv"));
    desk.assert_shows("There is no file");
    desk.press("Close");
    desk.assert_shows("Type or paste the path");
    desk.press("Cancel");
    assert_eq!(*desk.flank().document.params(), before);
    // The fellow is told by its name, and the file of the other flank is no longer the one that is saved to.
    open(&mut desk, &upper);
    assert_eq!(desk.flank().document.params().source, FlankSource::guides([lower.clone(), upper.clone()]));
    assert_eq!(
        (desk.flank().document.params().side, desk.flank().document.file().map(Path::to_owned)),
        (Side::Automatic, None)
    );
    // What has none waits.
    open(&mut desk, &alone);
    assert_eq!(desk.flank().document.params().source, FlankSource::guides([lower, upper]));
    desk.type_path(&other);
    assert_eq!(desk.flank().document.params().source, FlankSource::guides([alone.clone(), other.clone()]));
    desk.until("it was read", |desk| desk.flank().work.loaded(desk.flank().document.params()).is_some());
    assert!(desk.flank().work.changed_files(desk.flank().document.params()).is_empty());
    std::fs::write(&alone, "0,0,0\n10,2,0\n").unwrap();
    assert_eq!(desk.flank().work.changed_files(desk.flank().document.params()), [alone]);
}

#[test]
fn the_side_of_two_guides_is_chosen_in_the_view() {
    let home = Home::new();
    let [lower, upper] = ["lower.csv", "upper.csv"].map(|name| home.path(name));
    std::fs::write(&lower, "0,0,0\n10,2,0\n20,2,0\n30,0,0\n").unwrap();
    std::fs::write(&upper, "0,1,10\n10,3.5,10\n20,3,10\n30,0,10\n").unwrap();
    let mut document = FlankDocument::default();
    document.plan.grid = [30, 12];
    document.source = FlankSource::Guides { lower: GuideSource::File(lower), upper: GuideSource::File(upper) };
    let file = home.path("guides.sparkpath");
    Document::new(document).export(&file).unwrap();
    let mut desk = home.start(Opening::File(file));
    desk.until("the side is asked for", |desk| desk.flank().open_side().is_some());
    desk.settle();
    desk.assert_shows("Choose the side of the cutter");
    assert_eq!(desk.flank().document.params().side, Side::Automatic);
    desk.pictures("flank_sides");
    // The arrow of the positive side is where the surface's normal points.
    let [_, normal] = desk.flank().open_side().unwrap();
    desk.press("Cutter on side +1");
    assert_eq!(
        (desk.flank().document.params().side, desk.flank().document.undo_label(false)),
        (Side::Positive, Some("Side"))
    );
    desk.press("Plan");
    desk.until_planned();
    let result = &desk.flank().planned().unwrap().result;
    assert!(result.surface.normal(0.5, 0.5).dot(normal) > 0.999 && !desk.shows("Choose the side"));
    assert!((result.path().pose(0.5).tip - result.surface.point(0.5, 0.0)).dot(normal) > 0.5);
}

#[test]
fn a_workpiece_is_clamped_otherwise_and_the_program_follows_the_tip() {
    let home = Home::new();
    let mut desk = home.start(home.flank_with(|document| document.milling.post = "milling-tcp".to_owned()));
    desk.press("Plan");
    desk.until_planned();
    desk.press_role(Role::DisclosureTriangle, "Machine");
    desk.settle();
    desk.assert_shows("its Z along +Z of the machine");
    let of_machine = desk.flank().workpiece_of_machine().unwrap().clone();
    desk.press_role(Role::CheckBox, "clamped other than in the machine's file");
    assert_eq!(
        desk.flank().document.params().milling.workpiece.as_ref(),
        Some(&of_machine),
        "it begins as the file has it"
    );
    desk.enter("Zero Z", "45");
    desk.press_role(Role::ComboBox, "X Y Z are");
    desk.press("tip, angles");
    desk.enter("Tool number", "7");
    let milling = &desk.flank().document.params().milling;
    assert_eq!(milling.workpiece.as_ref().unwrap().zero_mm, DVec3 { z: 45.0, ..of_machine.zero_mm });
    assert_eq!((milling.program.tip_control, milling.program.tool_number), (TipControl::Angles, 7));
    desk.until_planned();
    let result = &desk.flank().planned().unwrap().result;
    let milled = result.milled().unwrap();
    assert_eq!(milled.machine.machine().workpiece.zero_mm.z, 45.0);
    let program = FlankNc::new(&ApprovedFlank::new(result).unwrap(), "flank").unwrap().text;
    assert!(program.contains("G43.4 H7"), "{program}");
    desk.picture("flank_clamped_dark");
    // Without it the workpiece stands as the file says again.
    desk.press_role(Role::CheckBox, "clamped other than in the machine's file");
    assert_eq!(desk.flank().document.params().milling.workpiece, None);
}

#[test]
fn a_small_window_has_results_in_the_place_of_the_form_and_plots_in_that_of_the_view() {
    let home = Home::new();
    let mut desk = home.start_in(home.flank(), [860, 500], 1.0);
    desk.press("Plan");
    desk.until_planned();
    let has_plot = |desk: &Desk| desk.window.query(By::new().role(Role::Image).label("Plot of ranks")).is_some();
    assert!(!desk.shows("swept envelope") && !has_plot(&desk));
    desk.press("Results");
    desk.assert_shows("swept envelope");
    assert!(desk.window.query(By::new().role(Role::SpinButton).label("Flutes")).is_none());
    desk.press("Plots");
    assert!(has_plot(&desk));
    desk.picture("flank_small_dark");
    desk.press("Plots");
    desk.press("Parameters");
    assert!(!desk.shows("swept envelope") && !has_plot(&desk));
    assert!(desk.window.query(By::new().role(Role::SpinButton).label("Flutes")).is_some());
}

#[test]
fn files_that_have_changed_are_said_before_an_export_and_loaded_again() {
    let home = Home::new();
    let [lower, upper] = ["lower.csv", "upper.csv"].map(|name| home.path(name));
    let write = |file: &Path, z: f64, last: f64| {
        std::fs::write(file, format!("0,0,{z}\n10,2,{z}\n20,2,{z}\n30,{last},{z}\n")).unwrap();
    };
    write(&lower, 0.0, 0.0);
    write(&upper, 10.0, 0.0);
    let source = FlankSource::guides([lower, upper.clone()]);
    let mut desk = home.start(home.flank_with(|document| document.source = source));
    desk.press("Plan");
    desk.until_planned();
    // Where the upper guide ends.
    let is_end = |desk: &Desk, y: f64| {
        let surface = &desk.flank().planned().unwrap().result.surface;
        [0.0, 1.0].into_iter().any(|u| surface.point(u, 1.0).distance(DVec3::new(30.0, y, 10.0)) < 1e-9)
    };
    assert!(is_end(&desk, 0.0));
    desk.key_with(Modifiers::COMMAND, Key::E);
    assert!(!desk.shows("Changed or gone"));
    desk.press("Cancel");
    write(&upper, 10.0, 0.125);
    desk.key_with(Modifiers::COMMAND, Key::E);
    desk.assert_shows("Changed or gone since read: upper.csv");
    desk.press("Reload");
    assert!(!desk.shows("Changed or gone"));
    desk.press("Cancel");
    desk.until("it was read again", |desk| desk.flank().work.loaded(desk.flank().document.params()).is_some());
    assert!(desk.flank().work.changed_files(desk.flank().document.params()).is_empty() && !desk.flank().is_planned());
    desk.press("Plan");
    desk.until_planned();
    assert!(is_end(&desk, 0.125));
}

#[test]
fn a_blisks_electrode_is_milled_without_a_file() {
    let home = Home::new();
    let mut desk = home.start(Opening::File(home.part(&easy_blisk())));
    desk.until_idle();
    desk.open_step(Stage::Electrode);
    let volume = desk.blisk().work.electrodes().unwrap().electrodes[0].volume_mm3;
    desk.press("Mill its flanks");
    assert_eq!(desk.app().shown(), "flank");
    let part = desk.until_faces();
    // But for the single precision of what is exported.
    assert!((part / volume - 1.0).abs() < 1e-7, "{part} {volume}");
    // What is milled first is a wall of it, and neither its shank nor its holder.
    let faces = &desk.blisk().work.electrodes().unwrap().electrodes[0].faces;
    let mesh = desk.blisk().electrode_to_mill().unwrap().mesh;
    let is_wall = |face: &ElectrodeFace| matches!(face, ElectrodeFace::LowWall | ElectrodeFace::HighWall);
    let walls = mesh.triangles.iter().zip(faces).filter(|(_, face)| is_wall(face));
    let walls: Vec<DVec3> = walls.flat_map(|(corners, _)| corners.map(|v| mesh.vertices[v as usize])).collect();
    let loaded = desk.flank().work.loaded(desk.flank().params()).unwrap().clone();
    let LoadedSurface::Face { mesh, candidates, .. } = &loaded.surface else { panic!("no face of a part") };
    let corners = candidates[0].triangles.iter().flat_map(|&t| mesh.triangles[t as usize]);
    let off = |v: u32| walls.iter().map(|p| p.distance(mesh.vertices[v as usize])).fold(f64::INFINITY, f64::min);
    let off = corners.map(off).fold(0.0, f64::max);
    assert!(off < 1e-6, "{off}: {}", candidates[0].summary());
    assert_eq!(desk.flank().document.name(), "electrode 1 flank 1");
}

impl Desk {
    /// Until the faces of the part are listed. Answers its volume.
    pub fn until_faces(&mut self) -> f64 {
        self.until("its faces are listed", |desk| desk.flank().work.loaded(desk.flank().document.params()).is_some());
        let loaded = self.flank().work.loaded(self.flank().params()).unwrap();
        let LoadedSurface::Face { mesh, candidates, .. } = &loaded.surface else { panic!("no face of a part") };
        assert!(!candidates.is_empty());
        let volume = mesh.volume();
        assert!(self.window.query(By::new().role(Role::Row).label("Face 1")).is_some());
        volume
    }
}
