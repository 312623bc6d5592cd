//! What the window shows of recognition, and what can be told to it by hand.

use egui::{Key, Modifiers, Role};
use egui_kittest::kittest::{By, Queryable as _};
use geometry::exact::ExactMesh;
use glam::DVec3;
use import::write_stl;
use sparkpath::shell::run::Opening;
use sparkpath::workspaces::blisk::desk::picks::Picked;
use sparkpath::workspaces::blisk::document::stage::Stage;
use sparkpath::workspaces::blisk::scene::Layer;
use task::State;
use wheel::electrode::{EnterSide, EntrySide};
use wheel::options::{Auto, AxisChoice, AxisLine};
use wheel::parametric::wheel::{ParametricWheel, Splitters};

use crate::common::{easy_blisk, mesh};
use crate::desk::{Desk, Home};

impl Desk {
    fn has(&self, role: Role, name: &str) -> bool {
        self.window.query(By::new().role(role).label(name)).is_some()
    }

    /// Clicks the view at shares of its width and height.
    fn click_view(&mut self, [x, y]: [f32; 2]) {
        let rect = self.window.get(By::new().role(Role::Image).label("3D viewport")).rect();
        let at = rect.min + rect.size() * egui::vec2(x, y);
        self.window.hover_at(at);
        self.settle();
        self.window.drag_at(at);
        self.window.drop_at(at);
        self.settle();
        self.window.remove_cursor();
        self.settle();
    }
}

const SECTION: &str = "Meridional section: radius over x, in mm";

#[test]
fn the_step_channel_shows_the_passage() {
    let home = Home::new();
    let mut desk = home.start(Opening::File(home.part(&easy_blisk())));
    desk.until_done(Stage::Channel);
    assert!(desk.blisk().shown_passage().is_none() && !desk.has(Role::CheckBox, "Show Passage"));
    desk.open_step(Stage::Channel);
    assert!(desk.blisk().shown_passage().is_some() && desk.has(Role::Image, SECTION));
    desk.press_role(Role::CheckBox, "Show Passage");
    assert!(desk.blisk().shown_passage().is_none(), "hidden as any other layer");
    desk.press_role(Role::CheckBox, "Show Passage");
    desk.open_step(Stage::Electrode);
    assert!(desk.blisk().shown_passage().is_none() && !desk.has(Role::Image, SECTION));
}

#[test]
fn a_wheel_with_splitters_lists_its_kinds_of_channels() {
    let home = Home::new();
    let part = home.path("splitters.stl");
    let wheel = ParametricWheel {
        splitters: vec![Splitters { off_middle: 0.02, ..Splitters::over([0.4, 0.9]) }],
        ..ParametricWheel::nozzle_ring()
    };
    write_stl(&part, &wheel.mesh()).unwrap();
    let mut desk = home.start(Opening::File(part));
    desk.until("the channel is known", |d| matches!(d.state(Stage::Channel), State::Ready | State::Failed(_)));
    assert_eq!(desk.state(Stage::Channel), State::Ready);
    let channel = desk.blisk().work.channel().unwrap().channel.clone();
    assert_eq!(channel.kinds, 2);
    let label = |kind: usize| {
        let all: Vec<String> = (kind..channel.blades).step_by(2).map(|n| n.to_string()).collect();
        format!("Kind {}: {}, … {} ({})", kind + 1, all[..3].join(", "), all[all.len() - 1], all.len())
    };
    desk.assert_shows(&label(0));
    desk.press(&label(1));
    assert_eq!(desk.blisk().document.params().blisk.options.channel, 1);
    desk.until("the channel is known", |d| d.state(Stage::Channel) != State::Running);
    assert_eq!(desk.blisk().work.channel().unwrap().channel.index, 1);
    desk.key_with(Modifiers::COMMAND, Key::Z);
    assert_eq!(desk.blisk().document.params().blisk.options.channel, 0, "one step of undo");
}

#[test]
fn an_arrow_at_either_mouth_chooses_the_side_of_entry() {
    let home = Home::new();
    let mut desk = home.start(Opening::File(home.part(&easy_blisk())));
    desk.until_done(Stage::Electrode);
    assert!(!desk.has(Role::RadioButton, "Enter from -X"), "only where the electrode is made");
    desk.open_step(Stage::Electrode);
    let open = EntrySide::open(&desk.blisk().work.channel().unwrap().channel);
    for side in EntrySide::ALL {
        assert_eq!(desk.has(Role::RadioButton, &format!("Enter from {}", side.label())), open.contains(&side));
    }
    let used = desk.blisk().work.electrodes().unwrap().electrodes[0].enters_from;
    let other = *open.iter().find(|side| **side != used).unwrap();
    desk.press_role(Role::RadioButton, &format!("Enter from {}", other.label()));
    assert_eq!(desk.blisk().document.params().electrode.enter, EnterSide::from(other));
    desk.until_done(Stage::Electrode);
    assert_eq!(desk.blisk().work.electrodes().unwrap().electrodes[0].enters_from, other);
    desk.key_with(Modifiers::COMMAND, Key::Z);
    assert_eq!(desk.blisk().document.params().electrode.enter, EnterSide::Auto);
    // Of several parts the one that is shown.
    desk.blisk_mut().change_job(|job| job.electrode.parts = 2);
    desk.until_done(Stage::Electrode);
    assert_eq!(desk.blisk().cursor.electrode, 0);
    desk.press_role(Role::RadioButton, &format!("Enter from {}", other.label()));
    let params = desk.blisk().document.params().electrode.clone();
    assert_eq!((params.enter, params.of_part(0).enter), (EnterSide::Auto, EnterSide::from(other)));
    assert_eq!(params.of_part(1).enter, EnterSide::Auto);
    desk.until_done(Stage::Electrode);
    assert_eq!(desk.blisk().work.electrodes().unwrap().electrodes[0].enters_from, other);
}

#[test]
fn surfaces_are_coloured_by_class_with_a_legend() {
    let home = Home::new();
    let mut desk = home.start(Opening::File(home.part(&easy_blisk())));
    // The electrode is in the picture, too.
    desk.until_idle();
    desk.open_step(Stage::Channel);
    // In a window of this size the last buttons of the view are in a menu.
    desk.press("…");
    desk.press("Surfaces");
    desk.until("the surfaces are coloured", |d| d.blisk().surface_map().is_some());
    let map = desk.blisk().surface_map().unwrap().clone();
    // The hub between the blades, the shroud above it, and both sides of every blade.
    for name in ["Hub", "Shroud", "Elsewhere"] {
        assert!(desk.window.query_all_by_label(name).next().is_some(), "{name}");
    }
    let area = mesh(&easy_blisk()).area();
    let told: f64 = map.areas.iter().map(|a| a.area_mm2).sum();
    assert!((told - area).abs() < 1e-4 * area, "{told} of {area}");
    desk.pictures("surfaces");
    // A tab of the plots has the same name.
    let buttons = desk.window.query_all(By::new().role(Role::Button).label("Clearance"));
    buttons.min_by(|a, b| a.rect().top().total_cmp(&b.rect().top())).unwrap().click();
    desk.settle();
    assert!(!desk.blisk().surfaces && desk.blisk().colours, "one coloring at a time");
}

/// A channel that is refused, since its hub is given within the metal.
fn refused(home: &Home) -> Desk {
    let file = home.project(&easy_blisk(), |job| job.blisk.options.hub_radius_mm = Auto::Given(41.0));
    let mut desk = home.start(Opening::File(file));
    desk.until("the channel is refused", |d| matches!(d.state(Stage::Channel), State::Failed(_)));
    desk.open_step(Stage::Channel);
    desk
}

#[test]
fn a_refused_channel_shows_its_place_and_offers_picks() {
    let home = Home::new();
    let mut desk = refused(&home);
    let at = desk.blisk().refused_at().unwrap();
    // Where the hub is missing: at the radius that was given or met, between the faces of the part.
    assert!((38.0..46.0).contains(&at.y.hypot(at.z)) && at.x.abs() < 8.0, "{at}");
    desk.press("Show the place");
    desk.wait(1.0);
    desk.assert_shows("Refused here");
    desk.pictures("refused");
    for button in ["Pick hub", "Pick shroud", "Pick blades", "Pick axis"] {
        assert!(desk.has(Role::Button, button), "{button}");
    }
}

#[test]
fn points_are_picked_on_the_wheel_listed_and_removed() {
    let home = Home::new();
    let mut desk = refused(&home);
    desk.press("Pick shroud");
    desk.assert_shows("Click points on the shroud");
    let picked = |desk: &Desk| desk.blisk().picked(Picked::Shroud);
    let places = [[0.5, 0.25], [0.35, 0.5], [0.5, 0.75], [0.4, 0.35]];
    for place in places {
        desk.click_view(place);
    }
    let points = picked(&desk);
    assert_eq!(points.len(), places.len(), "{points:?}");
    let exact = ExactMesh::new(&mesh(&easy_blisk())).unwrap();
    for p in &points {
        // Rounded to 0.0001 mm, and the file holds single precision.
        assert!(exact.nearest(*p).signed_distance.abs() < 1e-3, "{p} is off the wheel");
    }
    assert_eq!(desk.blisk().picked_markers().len(), points.len());
    // Every point lets recognition begin anew.
    desk.until_idle();
    desk.pictures("picked");
    desk.key(Key::Backspace);
    assert_eq!(picked(&desk), points[..points.len() - 1]);
    desk.press("Remove point 1 of Shroud");
    assert_eq!(picked(&desk), points[1..points.len() - 1]);
    desk.key_with(Modifiers::COMMAND, Key::Z);
    assert_eq!(picked(&desk), points[..points.len() - 1], "undone as any change of a parameter");
    desk.key(Key::Escape);
    assert!(desk.blisk().picking().is_none() && !desk.shows("Click points on the shroud"));
    desk.click_view(places[0]);
    assert_eq!(picked(&desk).len(), points.len() - 1, "a click selects again");
    assert_eq!(desk.blisk().selected, Some(Layer::Blisk));
}

#[test]
fn three_places_around_an_edge_give_the_axis() {
    let home = Home::new();
    let mut desk = home.start(Opening::File(home.part(&easy_blisk())));
    desk.until_done(Stage::Part);
    desk.open_step(Stage::Channel);
    desk.press_role(Role::DisclosureTriangle, "Pick in the view");
    desk.press("Pick axis");
    let [face, _] = easy_blisk().faces_x();
    let radius = easy_blisk().bore_radius_mm;
    for angle in [0.3_f64, 1.1, 2.6] {
        desk.blisk_mut().add_picked(DVec3::new(face, radius * angle.cos(), radius * angle.sin()) * 1.001);
    }
    desk.settle();
    let AxisChoice::Line(line) = desk.blisk().document.params().blisk.options.axis else { panic!("no axis") };
    let (direction, point) = (DVec3::from(line.direction), DVec3::from(line.point));
    assert!(direction.distance(DVec3::X) < 1e-5, "{direction}");
    assert!(point.y.hypot(point.z) < 1e-4, "{point}");
    desk.assert_shows("circle of radius 28.000 mm");
    desk.until_done(Stage::Channel);
    assert_eq!(desk.blisk().work.channel().unwrap().channel.blades, 24);
    // Points that are not on one circle change nothing, nor do three on different edges, through which there is a circle.
    desk.blisk_mut().add_picked(DVec3::new(-face, 50.0, 0.0));
    desk.settle();
    desk.assert_shows("not on one circle");
    desk.press("Remove point 2 of Axis");
    desk.press("Remove point 1 of Axis");
    desk.blisk_mut().add_picked(DVec3::new(face, 0.0, radius));
    desk.settle();
    desk.assert_shows("No edge of the wheel");
    assert_eq!(desk.blisk().document.params().blisk.options.axis, AxisChoice::Line(line));
}

/// Components with all their decimals are seen, and take no room from the view.
#[test]
fn the_panel_keeps_its_width_whatever_axis_is_given() {
    let home = Home::new();
    let mut desk = home.start(Opening::File(home.part(&easy_blisk())));
    desk.until_done(Stage::Part);
    desk.open_step(Stage::Channel);
    let view = |desk: &Desk| desk.window.get(By::new().role(Role::Image).label("3D viewport")).rect();
    let before = view(&desk);
    let mut job = desk.blisk().document.params().clone();
    let line =
        AxisLine { direction: [0.919335298, 0.080664764, -0.385117911], point: [-169.857612, 31.742468, 52.336468] };
    job.blisk.options.axis = AxisChoice::Line(line);
    desk.blisk_mut().edit("Axis", job, false);
    desk.settle();
    assert!((view(&desk).left() - before.left()).abs() < 0.1, "{:?}", view(&desk));
    for name in ["Direction of axis", "Point on axis"] {
        for letter in ["X", "Y", "Z"] {
            let field = desk.find(Role::SpinButton, &format!("{name} {letter}")).rect();
            assert!(field.left() > 0.0 && field.right() < before.left(), "{name} {letter}: {field}");
        }
    }
    let axis = |desk: &Desk| desk.blisk().document.params().blisk.options.axis;
    // A field that is left as it was keeps the decimals that it has no room for.
    desk.press_role(Role::SpinButton, "Point on axis X");
    desk.key(Key::Tab);
    assert_eq!(axis(&desk), AxisChoice::Line(line));
    desk.enter("Direction of axis Y", "0.25");
    let AxisChoice::Line(line) = axis(&desk) else { panic!("no axis") };
    assert_eq!(line.direction[1], 0.25);
}
