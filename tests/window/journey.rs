//! From a mesh to an NC program, and back after a kill.

use egui::accesskit::Toggled;
use egui::{Key, Modifiers, Role};
use egui_kittest::kittest::{AccessKitNode, By, Queryable as _};
use files::AnyDocument as _;
use geometry::solid::{intersection, prism};
use glam::DVec3;
use sparkpath::shell::run::Opening;
use sparkpath::workspaces::blisk::BliskWorkspace;
use sparkpath::workspaces::blisk::document::stage::Stage;
use sparkpath::workspaces::blisk::scene::{Layer, layer_id};
use sparkpath::workspaces::preferences::ThemeChoice;
use task::State;

use crate::common::{easy_blisk, mesh};
use crate::desk::{Desk, Home, holds};

#[test]
fn from_a_mesh_to_an_nc_program() {
    let home = Home::new();
    let mut desk = home.start(Opening::File(home.part(&easy_blisk())));
    desk.until_idle();
    for stage in [Stage::Part, Stage::Channel, Stage::Electrode] {
        assert!(desk.step_says(stage, "done"), "{stage:?}: {:?}", desk.state(stage));
    }
    desk.quicken();
    a_drag_is_one_step(&mut desk);
    plan_cancel_and_plan_again(&mut desk);
    everything_follows_the_cursor(&mut desk);
    verify_and_release(&mut desk);
    export(&mut desk, &home);
    an_edit_withdraws_the_release(&mut desk);
}

fn volume(desk: &Desk) -> f64 {
    desk.blisk().work.electrodes().unwrap().electrodes[0].volume_mm3
}

fn low_reduction(desk: &Desk) -> f64 {
    desk.blisk().document.params().electrode.circumferential_reduction_deg[0]
}

/// The electrode follows the slider; undo takes the whole drag back and nothing else.
fn a_drag_is_one_step(desk: &mut Desk) {
    desk.open_step(Stage::Electrode);
    let (before, thick) = (low_reduction(desk), volume(desk));
    desk.slide("Reduction, low wall", 0.5, 8);
    let dragged = low_reduction(desk);
    assert!((dragged - 2.0).abs() < 0.3, "the middle of a slider from 0 to 4 is {dragged}");
    desk.until_idle();
    assert!(desk.step_says(Stage::Electrode, "done"));
    assert!(volume(desk) < thick, "a larger reduction leaves less metal: {} of {thick}", volume(desk));
    desk.key_with(Modifiers::COMMAND, Key::Z);
    assert_eq!(low_reduction(desk), before, "one undo takes eight movements back");
    desk.until_idle();
    assert_eq!(volume(desk), thick);
    let of_drag = desk.log().into_iter().rfind(|line| line.starts_with("Electrode: ")).unwrap();
    assert!(!desk.shows(&of_drag), "the status bar tells of what is no more: {of_drag}");
    for (name, value) in [("Reduction, low wall", "3"), ("Reduction, high wall", "3"), ("Radial reduction", "1")] {
        desk.enter(name, value);
    }
    let electrode = &desk.blisk().document.params().electrode;
    assert_eq!((electrode.circumferential_reduction_deg, electrode.radial_reduction_mm), ([3.0, 3.0], 1.0));
    desk.until_idle();
}

fn plan_cancel_and_plan_again(desk: &mut Desk) {
    // A search that no machine ends before it is cancelled.
    let core = desk.blisk_mut();
    let mut long = core.document.params().clone();
    (long.genetic.population, long.genetic.generations) = (1000, 10_000);
    core.edit("Long search", long, false);
    desk.until_idle();
    desk.press("Go on to Plan");
    desk.press("Plan feed path");
    desk.until("the plan is under way", |d| d.blisk().work.doing().is_some_and(|doing| doing.what == "Plan"));
    assert!(desk.step_says(Stage::Plan, "working"));
    let cancel = |desk: &Desk| {
        let all = desk.window.query_all(By::new().role(Role::Button).label("Cancel")).map(|button| button.rect());
        all.max_by(|a, b| a.top().total_cmp(&b.top())).unwrap()
    };
    let before = cancel(desk);
    desk.until("nodes are found", |d| d.blisk().work.partial_plan().is_some_and(|partial| partial.nodes.len() > 1));
    assert_eq!(cancel(desk), before, "it stays where it is, whatever is said beside it");
    desk.press("Cancel");
    desk.until("the plan has stopped", |d| d.state(Stage::Plan) != State::Running);
    desk.assert_shows("Plan: cancelled");
    assert!(desk.blisk().work.plan().is_none());
    desk.key_with(Modifiers::COMMAND, Key::Z);
    desk.until_idle();
    desk.key(Key::F5);
    desk.until("the plan is done", |d| d.state(Stage::Plan) == State::Ready);
    desk.assert_shows("has an extraction path, certified clearance");
    assert!(desk.step_says(Stage::Plan, "done") && desk.step_says(Stage::Verify, "done"));
}

/// The cursor, the row of the table, the inspector and the electrode in the view are in the same place.
#[track_caller]
fn assert_together(desk: &Desk) {
    let core = desk.blisk();
    let station = core.track().at(core.cursor.s).unwrap();
    let node = station.node.expect("the cursor is on a node");
    let name = format!("Node {node}");
    let is_selected = |n: &AccessKitNode<'_>| n.toggled() == Some(Toggled::True);
    let selected: Vec<_> = desk.window.query_all(By::new().role(Role::Row).predicate(is_selected)).collect();
    assert_eq!(selected.len(), 1, "one row is selected");
    assert!(desk.window.query(By::new().role(Role::Row).label(&name).predicate(is_selected)).is_some(), "not {name}");
    desk.assert_shows(&format!("node {node} from the final pose"));
    let channel = core.work.channel().unwrap();
    let electrode = &core.outcome().unwrap().electrode;
    let shown = desk.app().scene().objects.iter().find(|o| o.id == layer_id(Layer::Electrode)).unwrap();
    let placed = station.pose.placement(electrode.reference_point);
    for p in [DVec3::ZERO, DVec3::new(10.0, 0.0, 70.0), DVec3::new(0.0, 5.0, 60.0)] {
        let expected = channel.channel.frame.to_parent(placed.transform_point3(p));
        let drawn = shown.transform.transform_point3(p);
        assert!((drawn - expected).length() < 1e-9, "{name}: {drawn} drawn, {expected} expected");
    }
}

fn everything_follows_the_cursor(desk: &mut Desk) {
    desk.press("Nodes");
    let nodes: Vec<f64> = desk.blisk().track().nodes().map(|n| n.s).collect();
    assert!(nodes.len() > 10);
    let s = |desk: &Desk| desk.blisk().cursor.s;
    desk.key(Key::Home);
    assert_eq!(s(desk), nodes[0]);
    assert_together(desk);
    for place in &nodes[1..4] {
        desk.key(Key::ArrowRight);
        assert_eq!(s(desk), *place);
        assert_together(desk);
    }
    desk.key(Key::ArrowLeft);
    assert_eq!(s(desk), nodes[2]);
    assert_together(desk);
    let row = format!("Node {}", nodes.len() - 5);
    desk.press_role(Role::Row, &row);
    assert_eq!(s(desk), nodes[4], "nodes count from the final pose");
    assert_together(desk);
    desk.key(Key::End);
    assert_eq!(s(desk), 0.0);
    assert_together(desk);
}

fn verify_and_release(desk: &mut Desk) {
    desk.open_step(Stage::Verify);
    desk.assert_shows("Certified: the whole motion keeps the spark gap, within the tolerance.");
    let least = {
        let outcome = desk.blisk().outcome().unwrap();
        let certificate = &outcome.plan.path.as_ref().unwrap().certificate;
        desk.assert_shows(&format!("{:.4} mm", certificate.certified()));
        certificate.least().s
    };
    desk.press("Go to the closest point");
    assert_eq!(desk.blisk().cursor.s, least);
    desk.until_idle();
    desk.press("Show the residual stock");
    let core = desk.blisk();
    assert!(core.map_values().is_some() && !core.layers.get(Layer::Electrode).visible);
    let (legend, left) = (core.map_legend().unwrap(), core.work.plan().unwrap().residual_stock().unwrap());
    let thickest = left.surfaces.iter().map(|s| s.left.depth_mm.max(s.overcut.depth_mm)).fold(0.0, f64::max);
    assert!(legend.max >= thickest - 1e-6 && legend.min == -legend.max, "{thickest} beyond {legend:?}");
    desk.settle();
    let walls = desk.app().scene().objects.iter().find(|o| o.values.is_some()).unwrap().bounds();
    let from = walls.center().distance(desk.app().camera().target);
    assert!(from < 0.5 * walls.size().length(), "the view went to the walls, {from} mm off");
    desk.press("Show the electrode");
    assert!(desk.blisk().map_values().is_none());
    desk.open_step(Stage::Export);
    let folder = tempfile::tempdir().unwrap();
    let early = folder.path().join("early");
    desk.window.state_mut().act(|blisk: &mut BliskWorkspace, cx| blisk.export(&early, cx));
    desk.until_idle();
    desk.assert_shows("release the plan first");
    desk.press("Close");
    assert!(!folder.path().join("early").exists());
    desk.press("Release for export");
    assert!(desk.blisk().work.released().is_some());
    desk.assert_shows(
        "Released: this path. A change of the path withdraws the release; feed and post do not change it.",
    );
}

fn export(desk: &mut Desk, home: &Home) {
    desk.press("Export…");
    desk.assert_shows("Results of an earlier plan in the folder are replaced.");
    desk.press_role(Role::Button, "Cancel");
    let folder = home.path("out");
    desk.window.state_mut().act(|blisk: &mut BliskWorkspace, cx| blisk.export(&folder, cx));
    desk.until("the files are written", |d| d.state(Stage::Export) == State::Ready);
    for name in ["path_1.nc", "path_1.csv", "electrode_1.stl", "report.html", "report.json"] {
        assert!(folder.join(name).is_file(), "{name}");
        desk.assert_shows(name);
    }
    let program = std::fs::read_to_string(folder.join("path_1.nc")).unwrap();
    assert!(program.starts_with("%\n"), "{program}");
    assert!(program.lines().nth(1).is_some_and(|line| line.starts_with("(Sparkpath")), "{program}");
    let digest = desk.blisk().outcome().unwrap().plan.path.as_ref().unwrap().path.digest();
    assert!(program.contains(&digest[..16]), "the program names the path that was released");
}

fn an_edit_withdraws_the_release(desk: &mut Desk) {
    desk.open_step(Stage::Verify);
    desk.press("Show the residual stock");
    desk.open_step(Stage::Electrode);
    desk.enter("Radial reduction", "1.2");
    desk.until_idle();
    let core = desk.blisk();
    assert!(!core.residual_stock && core.layers.get(Layer::Electrode).visible, "of this electrode there is no map");
    assert!(core.work.released().is_none());
    assert!(desk.step_says(Stage::Plan, "out of date") && desk.step_says(Stage::Export, "out of date"));
    assert!(desk.log().iter().any(|line| line.contains("release withdrawn: an input changed")));
    desk.assert_shows("Out of date: has an extraction path");
    desk.key_with(Modifiers::COMMAND, Key::E);
    desk.assert_shows("Export: the plan is out of date: plan again and release first");
    desk.key_with(Modifiers::COMMAND, Key::Z);
    desk.until_idle();
    assert!(desk.step_says(Stage::Plan, "done"), "the plan is of these parameters again");
    assert!(desk.blisk().work.released().is_none(), "but a release does not come back by itself");
}

#[test]
fn commands_are_found_by_a_few_of_their_letters() {
    let home = Home::new();
    let mut desk = home.start(Opening::Demonstration);
    desk.settle();
    assert_eq!(desk.app().context().preferences.theme, ThemeChoice::Dark);
    let field = |desk: &Desk| desk.window.query(By::new().role(Role::TextInput).label("Command")).is_some();
    desk.key_with(Modifiers::COMMAND, Key::K);
    assert!(field(&desk));
    desk.key(Key::Escape);
    assert!(!field(&desk), "Escape closes it");
    desk.key_with(Modifiers::COMMAND, Key::K);
    desk.window.event(egui::Event::Text("dk light".to_owned()));
    desk.settle();
    desk.key(Key::Enter);
    assert_eq!(desk.app().context().preferences.theme, ThemeChoice::Light);
    assert!(!desk.window.ctx.global_style().visuals.dark_mode);
    drop(desk);
    let desk = home.start(Opening::Demonstration);
    assert_eq!(desk.app().context().preferences.theme, ThemeChoice::Light, "preferences are kept");
}

#[test]
fn unsaved_work_survives_a_kill() {
    let home = Home::new();
    let part = home.part(&easy_blisk());
    let mut desk = home.start(Opening::File(part.clone()));
    desk.until_idle();
    desk.open_step(Stage::Electrode);
    desk.enter("Spark gap", "0.123");
    desk.until("a copy is kept", |_| holds(&home.folders().autosave, ".sparkpath"));
    let job = desk.blisk().document.params().clone();
    // Nothing of the program runs any more, neither its saving nor its end.
    drop(desk);
    let mut desk = home.start(Opening::Demonstration);
    desk.settle();
    desk.assert_shows("The program ended without saving.");
    desk.press("Recover");
    desk.until_idle();
    let document = &desk.blisk().document;
    assert_eq!((document.params(), document.params().electrode.spark_gap_mm), (&job, 0.123));
    assert!(document.is_unsaved() && document.params().blisk.mesh.as_ref() == Some(&part));
    assert!(desk.step_says(Stage::Electrode, "done"));
    // The work is recovered, and kept by the program that did so.
    assert!(holds(&home.folders().autosave, ".sparkpath"));
}

/// An axis that is given is taken as it is: a wrong one is refused, and the right one is that of the part.
#[test]
fn the_axis_is_given_by_hand_and_a_sector_is_its_wheel() {
    let home = Home::new();
    let blisk = easy_blisk();
    let sector = {
        let (pitch, whole) = (std::f64::consts::TAU / blisk.blades as f64, mesh(&blisk));
        let at = |theta: f64| glam::DVec2::from_angle(theta) * 1e3;
        let [from, to] = [0.3 * pitch, 3.3 * pitch];
        let wedge = prism(&[&[glam::DVec2::ZERO, at(from), at(to)]], -200.0, 200.0).unwrap();
        intersection(&whole, &wedge.mapped(|p| DVec3::new(p.z, p.x, p.y))).unwrap()
    };
    let file = home.path("sector.stl");
    import::write_stl(&file, &sector).unwrap();
    let mut desk = home.start(Opening::File(file));
    desk.until_done(Stage::Channel);
    desk.open_step(Stage::Channel);
    assert_eq!(desk.blisk().work.channel().unwrap().channel.blades, blisk.blades);
    desk.assert_shows("The mesh is a sector of 45.000 deg");
    desk.press_role(Role::ComboBox, "Axis");
    desk.press("given");
    desk.until("the wrong axis is refused", |d| matches!(d.state(Stage::Channel), State::Failed(_)));
    desk.press_role(Role::ComboBox, "Direction of axis");
    desk.press("+X");
    desk.until_done(Stage::Channel);
    let found = desk.blisk().work.channel().unwrap().channel.clone();
    assert_eq!((found.blades, found.frame.x), (blisk.blades, DVec3::X));
}
