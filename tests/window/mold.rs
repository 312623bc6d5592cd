//! The workspace of molds: from a mesh to what is left of it, and what other cutters would take away.

use std::f64::consts::FRAC_PI_4;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use task::State;

use egui::{Key, Modifiers, Role, vec2};
use egui_kittest::kittest::{By, NodeT as _, Queryable as _};
use files::AnyDocument;
use geometry::mesh::Mesh;
use glam::DVec3;
use import::{Units, write_stl};
use mold::cutter::{Cutter, CutterLibrary};
use mold::datum::Datum;
use sparkpath::shell::run::Opening;
use sparkpath::workspaces::mold::MoldWorkspace;
use sparkpath::workspaces::mold::panels::datum_pick::DatumPick;
use sparkpath::workspaces::mold::panels::desk::MoldDesk;

use crate::desk::{Desk, Home};

/// A block of 40 x 30 x 12 mm with a pocket of 28 x 18 mm, 5 mm deep, and in its floor one of 16 x 10 mm, 4 mm deep.
pub(crate) fn stepped() -> Mesh {
    let ring = |x: f64, y: f64, z: f64| [[-x, -y], [x, -y], [x, y], [-x, y]].map(|[x, y]| DVec3::new(x, y, z));
    let rings =
        [(20.0, 15.0, 0.0), (20.0, 15.0, 12.0), (14.0, 9.0, 12.0), (14.0, 9.0, 7.0), (8.0, 5.0, 7.0), (8.0, 5.0, 3.0)];
    let vertices: Vec<DVec3> = rings.into_iter().flat_map(|(x, y, z)| ring(x, y, z)).collect();
    let mut triangles = vec![[0, 2, 1], [0, 3, 2], [20, 21, 22], [20, 22, 23]];
    for (k, i) in (0..5).flat_map(|k| (0..4).map(move |i| (k, i))) {
        let [a, b] = [4 * k + i, 4 * k + (i + 1) % 4];
        triangles.extend([[a, b, b + 4], [a, b + 4, a + 4]]);
    }
    Mesh { vertices, triangles }
}

/// What a flat cutter of this radius leaves in one corner of so many mm of height (mm^3).
fn corner(radius: f64, height: f64) -> f64 {
    (1.0 - FRAC_PI_4) * radius * radius * height
}

/// A file that is dropped on the window.
#[derive(Debug)]
pub(crate) struct Dropped(pub(crate) PathBuf);

impl egui::DroppedFile for Dropped {
    fn path(&self) -> &Path {
        &self.0
    }

    fn bytes(&self) -> Result<Vec<u8>, String> {
        std::fs::read(&self.0).map_err(|e| e.to_string())
    }
}

impl Home {
    pub fn mold(&self) -> PathBuf {
        let file = self.path("stepped.stl");
        write_stl(&file, &stepped()).unwrap();
        file
    }
}

impl Desk {
    pub fn mold(&self) -> &MoldDesk {
        &self.app().workspace::<MoldWorkspace>().unwrap().desk
    }

    pub fn take_cutters(&mut self, cutters: &[Cutter]) {
        let mold = self.mold_mut();
        let mut params = mold.params().clone();
        params.library = CutterLibrary { cutter: cutters.to_vec() };
        params.units = Units::Mm;
        mold.edit(params);
        self.settle();
    }

    fn until_found(&mut self) {
        self.until("what is left is found", |d| d.mold().state() == State::Ready);
        self.until("the mold is at rest", |d| !d.mold().work.is_busy());
    }

    /// Drops a file on the window.
    pub fn drop_file(&mut self, path: &Path) {
        self.window.input_mut().dropped_files.push(Arc::new(Dropped(path.to_owned())));
        self.settle();
    }

    pub fn until_loaded(&mut self) {
        self.until("the mold is loaded and looked at", |d| d.mold().work.survey(d.mold().params()).is_some());
    }

    fn volume(&self) -> f64 {
        self.mold().regions().iter().map(|r| r.volume).sum()
    }

    fn visible(&self) -> usize {
        self.mold().is_visible().into_iter().filter(|v| *v).count()
    }
}

/// A window on the mold with one flat cutter of 6 mm, and what it leaves found.
pub fn found(home: &Home) -> Desk {
    let mut desk = home.start(Opening::In("mold", Some(home.mold())));
    desk.take_cutters(&[Cutter::flat(3.0)]);
    desk.until_loaded();
    desk.press("Find rest material");
    desk.until_found();
    desk
}

#[test]
fn what_is_left_is_found_listed_selected_and_cut_into_layers() {
    let home = Home::new();
    let mut desk = found(&home);
    desk.assert_shows("The cutters leave 8 regions");
    let name = desk.window.get(By::new().role(Role::TextInput).label("Cutters 1, Name"));
    assert_eq!(
        name.accesskit_node().placeholder(),
        Some("flat D6"),
        "a cutter without a name is called after its shape"
    );
    let exact = 4.0 * corner(3.0, 5.0) + 4.0 * corner(3.0, 4.0);
    assert!((desk.volume() / exact - 1.0).abs() < 1e-3, "{} {exact}", desk.volume());
    // The blisk was not worked on behind it.
    assert!(desk.blisk().work.part().is_none());

    desk.press_role(Role::Row, "Region 3");
    assert_eq!(desk.mold().selected, Some(2));
    desk.press_role(Role::Button, "Isolate");
    assert_eq!(desk.visible(), 1);
    desk.press_role(Role::Button, "Show all");
    // A click in the view on the middle of another region's box, seen from above.
    desk.key(Key::Num7);
    desk.until("the view has turned", |d| d.app().camera().backward().z > 0.9999);
    let region = &desk.mold().regions()[6];
    let view = desk.window.get(By::new().role(Role::Image).label("3D viewport")).rect();
    let size = [view.width() as u32, view.height() as u32];
    let center = region.bounds.center();
    // What is left fills the outer part of the corner.
    let at = center + (0.2 * region.bounds.size() * center.signum()).with_z(0.0);
    let seen = desk.app().camera().project(at, size).unwrap().pixel;
    let at = view.min + vec2(seen.x as f32, seen.y as f32);
    desk.window.hover_at(at);
    desk.window.drag_at(at);
    desk.window.drop_at(at);
    desk.settle();
    assert_eq!(desk.mold().selected, Some(6));

    // Four corners lie in the lower pocket and four in the upper one.
    desk.mold_mut().least_volume = 0.5 * (corner(3.0, 5.0) + corner(3.0, 4.0));
    desk.settle();
    assert_eq!((desk.visible(), desk.shows("4 of 8")), (4, true));

    desk.key(Key::L);
    let (top, z) = (desk.mold().layer.unwrap(), desk.mold().layer().unwrap().0.z);
    desk.slide("Layer", 0.6, 4);
    let (layer, number) = desk.mold().layer().unwrap();
    assert!(number != top && layer.z != z && (3.0..=12.0).contains(&layer.z), "{number} {}", layer.z);
    desk.assert_shows(&format!("z {:.3} mm", layer.z));
    let not_touched = layer.segment_length;
    assert!((not_touched - 4.0 * 6.0).abs() < 8.0 * 2e-5, "two radii in every corner: {not_touched}");
    assert!(desk.app().scene().section.is_some() && desk.app().scene().lines[1].polylines.len() == 4);

    // The other workspace, and back: everything is as it was.
    desk.press_role(Role::Tab, "Blisk workspace");
    desk.until("the blisk is begun", |d| d.blisk().work.part().is_some());
    assert!(!desk.shows("Regions"));
    desk.press_role(Role::Tab, "Mold workspace");
    assert_eq!((desk.mold().selected, desk.mold().layer), (Some(6), Some(number)));
    assert_eq!(desk.mold().state(), State::Ready);

    // The status bar says what is wrong with a value as long as it is.
    let wrong = |desk: &Desk| desk.app().last_said().is_some_and(|(line, _)| line.text.contains("Corner is 5 mm"));
    desk.enter("Cutters 1, Corner", "5");
    desk.key(Key::F6);
    assert!(wrong(&desk), "{:?}", desk.log());
    desk.enter("Cutters 1, Corner", "1");
    assert!(!wrong(&desk));
}

#[test]
fn a_change_of_a_cutter_is_seen_at_a_glance_and_found_exactly_at_rest() {
    let home = Home::new();
    let mut desk = found(&home);
    desk.mold_mut().follows = false;
    desk.enter("Cutters 1, Diameter", "4");
    assert_eq!(desk.mold().document.params().library.cutter[0].diameter_mm, 4.0);
    desk.until("it is looked at", |d| d.mold().glanced().is_some());
    desk.pictures("mold_glance");
    desk.assert_shows("Out of date (other cutters): The cutters leave 8 regions");
    desk.assert_shows("out of date");
    let glance = desk.mold().glanced().unwrap().preview.clone();
    let exact = 4.0 * (corner(2.0, 5.0) + corner(2.0, 4.0));
    let coarse: f64 = glance.regions.iter().map(|r| r.volume).sum();
    assert!(glance.regions.len() == 8 && (coarse / exact - 1.0).abs() < 0.2, "{coarse} {exact}");
    desk.assert_shows("Preview, cells of");
    // Nothing is found by itself as long as that is not wanted.
    assert_eq!(desk.mold().state(), State::Stale);
    desk.mold_mut().follows = true;
    desk.until_found();
    assert!((desk.volume() / exact - 1.0).abs() < 1e-3 && desk.mold().glanced().is_none());
    assert!(!desk.shows("out of date") && !desk.shows("Out of date (other cutters)"));
}

#[test]
fn what_is_done_to_cutters_is_undone_step_by_step() {
    let home = Home::new();
    let mut desk = home.start(Opening::In("mold", None));
    desk.until_loaded();
    let start = desk.mold().document.params().clone();
    desk.enter("Cutters 2, Diameter", "7");
    let wide = desk.mold().document.params().clone();
    desk.press("Add to Cutters");
    desk.press("Add to Cutters");
    desk.press_role(Role::Button, "-x");
    assert_eq!(desk.mold().document.params().library.cutter.len(), start.library.cutter.len() + 2);
    let end = desk.mold().document.params().clone();
    let labels = ["Opening direction", "Cutters: row added", "Cutters: row added", "Cutters 2, Diameter"];
    for label in labels {
        assert_eq!(desk.mold().document.undo_label(false), Some(label));
        desk.key_with(Modifiers::COMMAND, Key::Z);
        assert!(
            label != "Cutters: row added"
                || desk.mold().document.params().library.cutter.len() > start.library.cutter.len() - 1
        );
    }
    assert!(*desk.mold().document.params() == start && !desk.mold().document.is_unsaved());
    desk.key_with(Modifiers::COMMAND | Modifiers::SHIFT, Key::Z);
    assert_eq!(*desk.mold().document.params(), wide);
    for _ in 1..labels.len() {
        desk.key_with(Modifiers::COMMAND | Modifiers::SHIFT, Key::Z);
    }
    assert_eq!((desk.mold().document.params(), desk.mold().document.undo_label(true)), (&end, None));
    // Nothing of it was done to the blisk.
    assert!(!desk.blisk().document.is_unsaved());
}

/// The demonstration mold is there as soon as the workspace is, is worked on like any other, and makes room for a mold.
#[test]
fn an_empty_workspace_shows_a_demonstration_mold() {
    let home = Home::new();
    let mut desk = home.start(Opening::In("mold", None));
    desk.until_loaded();
    desk.assert_shows("Demonstration mold. Drop your own here");
    assert!(!desk.mold().document.is_unsaved() && desk.mold().params().mesh.is_none());
    let bounds = desk.mold().work.mold().unwrap().shape.bounds();
    assert_eq!(desk.app().scene().objects.len(), 1);
    assert!(bounds.size().distance(DVec3::new(64.0, 46.0, 18.0)) < 1e-4, "{bounds:?}");
    desk.pictures("mold_demonstration");
    // Saved it is the same headless.
    let (file, out) = (home.path("demonstration.sparkpath"), home.path("out"));
    let mut params = desk.mold().params().clone();
    params.library.cutter = vec![Cutter::flat(1.0)];
    desk.mold_mut().edit(params);
    desk.press("Find rest material");
    desk.until_found();
    let regions = desk.mold().regions().len();
    assert!(regions >= 7, "two ribs, a cross, four corners: {regions}");
    desk.key_with(Modifiers::COMMAND, Key::S);
    desk.type_path(&file);
    let mut program = std::process::Command::new(env!("CARGO_BIN_EXE_sparkpath"));
    program.args(["uncut", "--no-pictures", "--out"]).args([&out, &file]);
    assert!(program.env("XDG_CONFIG_HOME", home.path("no-settings")).status().unwrap().success());
    let json: serde_json::Value = serde_json::from_slice(&std::fs::read(out.join("uncut.json")).unwrap()).unwrap();
    assert_eq!(json["uncut"]["regions"].as_array().unwrap().len(), regions);
    let mesh = home.mold();
    desk.drop_file(&mesh);
    desk.until_loaded();
    assert_eq!(desk.mold().params().mesh.as_ref(), Some(&mesh));
    assert!(desk.mold().found().is_none() && !desk.shows("Demonstration mold. Drop"));
}

#[test]
fn a_search_goes_on_while_the_same_mesh_is_read_again() {
    let home = Home::new();
    let mut desk = home.start(Opening::In("mold", Some(home.mold())));
    desk.take_cutters(&[Cutter::flat(3.0)]);
    desk.until_loaded();
    let loads = |desk: &Desk| desk.log().iter().filter(|line| line.starts_with("Mold: ")).count();
    let before = loads(&desk);
    desk.mold_mut().find().unwrap();
    desk.key_with(Modifiers::COMMAND, Key::R);
    desk.until_found();
    assert_eq!(loads(&desk), before + 1, "{:?}", desk.log());
    // Another mesh in the same file is another question.
    let shifted = |p: &DVec3| *p + DVec3::X;
    let mesh = stepped();
    let mesh = Mesh { vertices: mesh.vertices.iter().map(shifted).collect(), ..mesh };
    write_stl(&home.path("stepped.stl"), &mesh).unwrap();
    desk.key_with(Modifiers::COMMAND, Key::R);
    desk.until_loaded();
    assert_ne!(desk.mold().state(), State::Ready);
    assert!(desk.mold().found().is_none(), "what was found in another mesh is not shown on this one");
}

#[test]
fn regions_are_sorted_by_every_column_both_ways() {
    let home = Home::new();
    let mut desk = found(&home);
    let regions: Vec<[f64; 3]> = desk.mold().regions().iter().map(|r| [r.volume, r.plan_area, r.depth]).collect();
    for (head, of) in [("#", None), ("height", Some(2)), ("area mm\u{b2}", Some(1)), ("volume mm\u{b3}", Some(0))] {
        let key = |i: &usize| of.map_or(*i as f64, |column: usize| regions[*i][column]);
        let head = format!("Sort by {head}");
        let rect = desk.window.get(By::new().role(Role::Button).label(&head)).rect();
        assert!((38.0..100.0).contains(&rect.width()), "{head} is hard to hit: {rect:?}");
        let mut orders = Vec::new();
        // Beside its word: all of the head can be pressed.
        let at = rect.left_center() + vec2(8.0, 0.0);
        for _ in 0..2 {
            desk.window.hover_at(at);
            desk.window.drag_at(at);
            desk.window.drop_at(at);
            desk.settle();
            orders.push(desk.mold().listed());
        }
        let falls = |order: &[usize]| order.windows(2).all(|w| key(&w[0]) >= key(&w[1]));
        let rises = |order: &[usize]| order.windows(2).all(|w| key(&w[0]) <= key(&w[1]));
        let both =
            if of.is_none() { [rises(&orders[0]), falls(&orders[1])] } else { [falls(&orders[0]), rises(&orders[1])] };
        assert!(
            both == [true; 2] && orders[0] != orders[1],
            "{head}: {orders:?} {:?} {rect:?} {at:?}",
            desk.mold().sort
        );
    }
}

#[test]
fn other_cutters_are_compared_region_by_region() {
    let home = Home::new();
    let mut desk = found(&home);
    // It reaches the corners of the upper pocket only.
    let short = Cutter { reach_mm: Some(5.0), ..Cutter::flat(0.04) };
    desk.mold_mut().other.cutter = vec![Cutter::flat(3.0), Cutter { holder_diameter_mm: Some(20.0), ..short }];
    desk.press_role(Role::DisclosureTriangle, "Compare cutters");
    desk.press("Compare");
    desk.until("it is compared", |d| d.mold().work.other().is_some() && !d.mold().work.is_busy());
    let comparison = &desk.mold().work.other().unwrap().1;
    let vanish: Vec<bool> = (0..8).map(|i| comparison.vanishes(i)).collect();
    let high: Vec<bool> = desk.mold().regions().iter().map(|r| r.bounds.min.z > 5.0).collect();
    assert_eq!((vanish, comparison.new_regions), (high, 0));
    desk.assert_shows("4 regions vanish");
    desk.mold_mut().only_vanishing = true;
    desk.settle();
    assert_eq!(desk.visible(), 4);
    desk.pictures("mold_compared");
}

#[test]
fn cutters_are_added_saved_and_loaded() {
    let home = Home::new();
    let mut desk = home.start(Opening::In("mold", None));
    // The panel moves under the pointer when the demonstration comes.
    desk.until_loaded();
    let standard = desk.mold().document.params().library.clone();
    desk.press("Add to Cutters");
    desk.press("Cutters 9");
    desk.press("Duplicate");
    desk.enter("Cutters 10, Diameter", "0");
    desk.assert_shows("Cutters 10, Diameter is 0 mm: must be from 0.01 to 500 mm");
    desk.press("Cutters 10");
    desk.press("Remove");
    let nine = desk.mold().document.params().library.clone();
    assert_eq!((nine.cutter.len(), nine.cutter[8].diameter_mm), (9, 2.0));
    desk.press("Save…");
    desk.type_path(&home.path("mine"));
    desk.press("Standard");
    assert_eq!(desk.mold().document.params().library, standard);
    desk.press("Load…");
    desk.type_path(&home.path("mine.toml"));
    assert_eq!(desk.mold().document.params().library, nine);
}

#[test]
fn how_a_mold_looks() {
    let home = Home::new();
    let mut desk = found(&home);
    desk.press_role(Role::Row, "Region 3");
    desk.pictures("mold");
    desk.key(Key::L);
    desk.key(Key::D);
    desk.pictures("mold_layer");
}

/// The opening direction is proposed, chosen along an axis, typed, and taken back; one that hides the cavity is warned of.
#[test]
fn the_opening_direction_is_proposed_and_another_one_is_warned_of() {
    let home = Home::new();
    let file = home.mold();
    write_stl(&file, &stepped().mapped(|p| DVec3::new(p.x, p.z, -p.y))).unwrap();
    let mut desk = home.start(Opening::In("mold", Some(file)));
    desk.until_loaded();
    let opening = |desk: &Desk| desk.mold().params().opening.map(|opening| opening.name()).unwrap_or_default();
    assert!(opening(&desk) == "+y" && !desk.mold().document.is_unsaved(), "{}", opening(&desk));
    desk.assert_shows("Proposed +y: 0.0 mm\u{b2} of faces look away");
    desk.take_cutters(&[Cutter::flat(3.0)]);
    desk.mold_mut().follows = false;
    desk.press_role(Role::Button, "-y");
    desk.until("it is looked at", |d| d.mold().glanced().is_some());
    desk.assert_shows("of the part's inner faces (100 %)");
    desk.pictures("mold_hidden");
    desk.press("As proposed");
    assert_eq!(opening(&desk), "+y");
    desk.press_role(Role::TextInput, "Opening vector");
    desk.window.event(egui::Event::Text("0, 1, 0.5".to_owned()));
    desk.settle();
    desk.key(Key::Enter);
    assert_eq!(opening(&desk), "0,1,0.5");
    for expected in ["+y", "-y", "+y"] {
        desk.key_with(Modifiers::COMMAND, Key::Z);
        assert_eq!(opening(&desk), expected);
    }
}

impl Desk {
    /// Clicks in the view on a place of the part (mm), seen from where it is seen now.
    fn click_on(&mut self, place: DVec3) {
        let view = self.window.get(By::new().role(Role::Image).label("3D viewport")).rect();
        let seen = self.app().camera().project(place, [view.width() as u32, view.height() as u32]).unwrap().pixel;
        let at = view.min + vec2(seen.x as f32, seen.y as f32);
        self.window.hover_at(at);
        self.window.drag_at(at);
        self.window.drop_at(at);
        self.settle();
    }
}

/// Picked at a corner, then in the middle across two pairs of walls, undone, and the results stay.
#[test]
fn the_work_datum_is_picked_on_the_part_and_moves_no_result() {
    let home = Home::new();
    let mut desk = found(&home);
    desk.key(Key::Num7);
    desk.until("the view has turned", |d| d.app().camera().backward().z > 0.9999);
    desk.press_role(Role::DisclosureTriangle, "Work datum");
    desk.press("Corner");
    desk.assert_shows("Work datum: click on a corner of the mold");
    desk.click_on(DVec3::new(13.6, 9.5, 12.0));
    let datum = |desk: &Desk| desk.mold().params().datum.clone();
    let corner = datum(&desk);
    assert_eq!((corner.origin_mm, corner.name.as_str()), (DVec3::new(14.0, 9.0, 12.0), "corner"));
    assert!(desk.mold().pick.is_none() && !desk.shows("click on a corner"));
    // A pair of walls: seen from above they are the steps of the floor, so the lower pocket's own from the front.
    desk.mold_mut().pick_datum(DatumPick::Faces(None));
    let wall = |x: f64| (DVec3::new(x, 1.0, 5.0), DVec3::NEG_X * x.signum());
    let _: Result<(), &str> = desk.mold_mut().take_datum(wall(-8.0).0, wall(-8.0).1);
    assert!(desk.mold_mut().take_datum(DVec3::new(0.0, 5.0, 5.0), DVec3::NEG_Y).is_err(), "not parallel");
    desk.mold_mut().take_datum(wall(8.0).0, wall(8.0).1).unwrap();
    desk.settle();
    assert_eq!(datum(&desk).origin_mm, DVec3::new(0.0, 9.0, 12.0), "across the walls only");
    desk.mold_mut().pick_datum(DatumPick::Hole);
    assert!(desk.mold_mut().take_datum(DVec3::ZERO, DVec3::Z).unwrap_err().contains("no round rim"));
    desk.key(Key::Escape);
    assert!(desk.mold().pick.is_none());
    desk.enter("X axis", "90");
    let axes = desk.app().scene().lines.iter().rev().take(3).map(|l| l.polylines[0].clone()).collect::<Vec<_>>();
    let along: Vec<DVec3> = axes.iter().rev().map(|ends| (ends[1] - ends[0]).normalize()).collect();
    assert!(along[0].distance(DVec3::Y) < 1e-9 && along[2].distance(DVec3::Z) < 1e-9, "{along:?}");
    assert!(desk.mold().state() == State::Ready && desk.mold().glanced().is_none(), "nothing is asked anew");
    desk.pictures("mold_datum");
    for expected in [DVec3::new(0.0, 9.0, 12.0), corner.origin_mm, DVec3::ZERO] {
        desk.key_with(Modifiers::COMMAND, Key::Z);
        assert!(datum(&desk).angle_deg == 0.0 && datum(&desk).origin_mm == expected, "{:?}", datum(&desk));
    }
    // The X axis along an edge of the pocket's mouth, from one of its corners to the other.
    desk.press("X direction");
    desk.assert_shows("Work datum: click on the corner where an edge along X begins");
    let mut take = |place: DVec3| desk.mold_mut().take_datum(place, DVec3::Z);
    take(DVec3::new(14.3, 9.2, 12.0)).unwrap();
    assert!(take(DVec3::new(14.1, 9.1, 7.1)).unwrap_err().contains("over the first one"), "below it");
    take(DVec3::new(14.2, -9.3, 12.0)).unwrap();
    desk.settle();
    assert!(desk.mold().pick.is_none() && !desk.shows("where an edge along X begins"));
    assert_eq!(datum(&desk), Datum { angle_deg: -90.0, ..Datum::default() });
}

/// The view has as much room as both panels together, and all of it where they are folded.
#[test]
fn a_mold_in_a_window_of_1000_by_700() {
    let home = Home::new();
    let mut desk = home.start_in(Opening::In("mold", Some(home.mold())), [1000, 700], 1.0);
    desk.take_cutters(&[Cutter::flat(3.0), Cutter { reach_mm: Some(4.0), ..Cutter::ball(1.5) }]);
    desk.until_loaded();
    desk.key(Key::F6);
    desk.until_found();
    desk.press_role(Role::Row, "Region 1");
    let width = |desk: &Desk| desk.window.get(By::new().role(Role::Image).label("3D viewport")).rect().width();
    desk.key(Key::D);
    desk.key(Key::Num7);
    desk.until("the view has turned", |d| d.app().camera().backward().z > 0.9999);
    desk.picture("mold_1000_dark");
    assert!(width(&desk) > 400.0, "{}", width(&desk));
    desk.press("Show or fold the panel on the left");
    desk.press("Show or fold the panel on the right");
    assert!(width(&desk) > 990.0, "{}", width(&desk));
    desk.press("Show or fold the panel on the right");
    assert!(desk.shows("Regions") && !desk.shows("Tolerance"));
}

/// As little room as there ever is: 640 by 360 points.
#[test]
fn a_mold_in_a_window_of_1280_by_720_at_200_percent() {
    let home = Home::new();
    let mut desk = home.start_in(Opening::In("mold", Some(home.mold())), [1280, 720], 2.0);
    desk.take_cutters(&[Cutter::flat(3.0)]);
    desk.until_loaded();
    desk.key(Key::F6);
    desk.until_found();
    desk.press_role(Role::Row, "Region 1");
    desk.key(Key::L);
    desk.pictures("mold_small");
}

impl Desk {
    pub fn mold_mut(&mut self) -> &mut MoldDesk {
        &mut self.window.state_mut().workspace_mut::<MoldWorkspace>().unwrap().desk
    }
}
