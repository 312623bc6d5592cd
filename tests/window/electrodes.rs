//! Electrodes in the workspace of molds: from a mesh to burns that are looked at, changed and exported.

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Arc;

use egui::{Key, Modifiers, Role};
use egui_kittest::kittest::{By, Queryable as _};
use files::{AnyDocument, Document};
use geometry::solid::{difference, prism};
use glam::{DVec2, DVec3};
use import::write_stl;
use mold::cutter::{Cutter, CutterLibrary};
use mold::electrode::design::{Burn, ElectrodeSet};
use mold::electrode::params::{Edit, Holder, Method};
use mold::opening::Opening::MinusX;
use nc::template::BurnSheet;
use sparkpath::shell::run::Opening;
use sparkpath::workspaces::commands::{CommandSet as _, Commanded as _};
use sparkpath::workspaces::flank::document::{FlankDocument, FlankSource};
use sparkpath::workspaces::mold::commands::MoldCommand;
use sparkpath::workspaces::mold::scene::electrodes::BurnOf;
use sparkpath::workspaces::setup::DatumRow;
use task::State;

use crate::desk::{Desk, Home};
use crate::regions::{bent_slot, with_electrodes};

/// A window on the stepped mold with electrodes, for which nothing but Design was pressed.
fn designed(home: &Home, pixels: [u16; 2]) -> Desk {
    let mut desk = home.start_in(Opening::In("mold", Some(home.mold())), pixels, 1.0);
    desk.take_cutters(&[Cutter::flat(3.0)]);
    let mut params = desk.mold().document.params().clone();
    params.electrodes.cutters = Some(CutterLibrary { cutter: vec![Cutter::flat(1.0)] });
    desk.mold_mut().edit(params);
    desk.until_loaded();
    desk.press("Create electrodes");
    until_designed(&mut desk);
    desk
}

pub(crate) fn until_designed(desk: &mut Desk) {
    desk.until("electrodes are made", |d| d.mold().design_state() == State::Ready && !d.mold().work.is_busy());
}

fn bodies(desk: &Desk) -> usize {
    desk.app().scene().objects.iter().filter(|o| o.id.0 >= 1 << 24).count()
}

#[test]
fn electrodes_are_designed_looked_at_changed_and_exported() {
    let home = Home::new();
    let mut desk = designed(&home, [1280, 720]);
    assert_eq!(desk.mold().state(), State::Ready, "what is left was found first");
    let made = desk.mold().electrodes.designed().unwrap().clone();
    let burns: usize = made.set.electrodes.iter().map(|e| e.burns.len()).sum();
    assert!(burns > 0 && bodies(&desk) == burns, "{burns} {}", bodies(&desk));
    let first = made.set.electrodes[0].name.clone();
    desk.press_role(Role::Row, &format!("Electrode {first}"));
    assert_eq!(desk.mold().electrodes.selected, Some(BurnOf { electrode: 0, burn: 0 }));
    desk.press_role(Role::Row, &format!("Electrode {first}"));
    assert_eq!(desk.mold().electrodes.selected, Some(BurnOf { electrode: 0, burn: 0 }), "a second click keeps it");
    desk.pictures("electrodes");

    // Lifted out they are higher and further apart.
    let high = |desk: &Desk| desk.app().scene().bounds().max.z;
    let before = high(&desk);
    desk.slide("Retracted", 0.9, 3);
    assert!(high(&desk) > before + 5.0);
    desk.pictures("electrodes_apart");
    desk.mold_mut().electrodes.exploded = 0.0;

    // A cut through the burn goes straight down through its lowest face, and only that burn is left.
    desk.key(Key::X);
    desk.settle();
    let section = desk.app().scene().section.unwrap();
    assert!(section.normal.z.abs() < 1e-12 && bodies(&desk) == 1);
    desk.assert_shows("gap 0.05 mm");
    desk.pictures("electrode_cut");
    desk.key(Key::X);
    assert!(desk.app().scene().section.is_none());

    // Down, burn, up: two thirds of the way it stands where it has burned.
    desk.press("To the start");
    let lift = desk.mold().electrodes.moment().unwrap().1;
    assert!(lift >= made.set.params.lift_mm, "{lift}");
    for _ in 0..8 {
        desk.press("Step forward");
    }
    assert!(desk.mold().electrodes.moment().unwrap().1.abs() < 1e-9);
    desk.press("Play");
    let at = desk.mold().electrodes.time;
    desk.until("it goes on", |d| d.mold().electrodes.time > at);
    desk.press("Burn position");

    // A template of one's own.
    let mine = home.path("mine.jinja");
    std::fs::write(&mine, "{% for e in electrodes %}BURN {{ e.name }}\n{% endfor %}").unwrap();
    desk.mold_mut().electrodes.sheet = BurnSheet::read(&mine).unwrap();

    // What the machine touches changes no electrode.
    let mut params = desk.mold().document.params().clone();
    params.setup.datum = vec![DatumRow { x_mm: 1.0, y_mm: 2.0, z_mm: 3.0, radius_mm: None }];
    desk.mold_mut().edit(params);
    assert_eq!(desk.mold().design_state(), State::Ready);

    let folder = home.path("out");
    desk.key_with(Modifiers::COMMAND, Key::E);
    desk.type_path(&folder);
    desk.until("it is exported", |d| !d.mold().work.is_busy());
    let passes: Vec<&str> =
        (0..made.set.electrodes.len()).filter(|e| !made.set.fails(*e)).map(|e| &*made.set.electrodes[e].name).collect();
    for name in &passes {
        assert!(folder.join(format!("{name}.stl")).exists() || crate::desk::holds(&folder, ".stl"), "{name}");
    }
    for file in ["burn_table.csv", "burn_table.json", "burn_sheet.txt", "setup_sheet.txt", "report.html"] {
        assert!(folder.join(file).exists(), "{file}; {:?}", desk.log());
    }

    let sheet = std::fs::read_to_string(folder.join("burn_sheet.txt")).unwrap();
    let names: Vec<&str> = sheet.lines().filter_map(|line| line.strip_prefix("BURN ")).collect();
    assert_eq!(names, made.set.electrodes.iter().map(|e| &*e.name).collect::<Vec<_>>(), "{sheet}");

    // A change of what is asked makes them stale; undo makes them those of the present parameters again.
    desk.mold_mut().follows = false;
    let mut params = desk.mold().document.params().clone();
    params.electrodes.stages[0].gap_mm = 0.1;
    desk.mold_mut().edit(params);
    desk.settle();
    assert_eq!((desk.mold().design_state(), desk.mold().state()), (State::Stale, State::Ready));
    desk.assert_shows("Out of date");
    desk.key_with(Modifiers::COMMAND, Key::Z);
    assert_eq!(desk.mold().design_state(), State::Ready);
    // What is exported although a check fails changes no electrode.
    let mut params = desk.mold().document.params().clone();
    params.electrodes.overrides.push(format!("{first}:gouge").parse().unwrap());
    desk.mold_mut().edit(params);
    assert_eq!(desk.mold().design_state(), State::Ready);
}

#[test]
fn a_region_is_made_in_another_way_and_a_part_is_split_by_two_clicks() {
    let home = Home::new();
    let mut desk = designed(&home, [1000, 700]);
    desk.mold_mut().electrodes.select(BurnOf { electrode: 0, burn: 0 });
    desk.settle();
    desk.picture("electrodes_1000_dark");
    // The last figure of the strip is all on the view.
    let view = desk.window.get(By::new().role(Role::Image).label("3D viewport")).rect();
    let figure = desk.window.get(By::new().label("0.00 mm")).rect();
    assert!(view.contains_rect(figure), "{figure:?} {view:?}");
    let made = desk.mold().electrodes.designed().unwrap().clone();
    let region = made.set.electrodes[0].burns[0].parts[0].region;
    let place = made.places[region].unwrap();
    let other = if made.set.regions[region].method == Method::Cutting { Method::Extruding } else { Method::Cutting };
    let mut params = desk.mold().document.params().clone();
    params.electrodes.edits.push(Edit::Make { place, method: other });
    desk.mold_mut().edit(params);
    assert_eq!(desk.mold().document.undo_label(false), Some("Method of a region"));
    desk.press("Create electrodes");
    until_designed(&mut desk);
    let now = desk.mold().electrodes.designed().unwrap().clone();
    assert_eq!(now.set.regions[region].method, other);

    desk.mold_mut().electrodes.split = Some(None);
    desk.key(Key::Num7);
    desk.until("the view has turned", |d| d.app().camera().backward().z > 0.9999);
    let ends = [DVec3::new(-3.0, 0.0, 3.0), DVec3::new(3.0, 1.0, 3.0)];
    ends.into_iter().for_each(|end| click_at(&mut desk, end));
    let Some(Edit::Split { line }) = desk.mold().document.params().electrodes.edits.last() else {
        panic!("no line was drawn")
    };
    for (found, end) in line.iter().zip(ends) {
        assert!(found.truncate().distance(end.truncate()) < 0.1, "{found} {end}");
    }
    assert_eq!(desk.mold().document.undo_label(false), Some("Split part"));
}

#[test]
fn a_change_that_meets_nothing_is_said_and_a_line_is_given_up_with_escape() {
    let home = Home::new();
    let mut desk = designed(&home, [1280, 720]);
    desk.mold_mut().electrodes.begin_split(0);
    desk.settle();
    desk.assert_shows("Split region 1: click on the mold where the line begins");
    // Electrodes that are made again in the meantime do not end it.
    let before = desk.mold().electrodes.designed().unwrap().clone();
    desk.mold_mut().design().unwrap();
    until_designed(&mut desk);
    assert!(!Arc::ptr_eq(&before, desk.mold().electrodes.designed().unwrap()));
    assert_eq!((desk.mold().electrodes.split, desk.mold().electrodes.split_region), (Some(None), Some(0)));
    desk.key(Key::Escape);
    let burns = &desk.mold().electrodes;
    assert_eq!((burns.split, burns.split_region), (None, None));
    let mut params = desk.mold().document.params().clone();
    let far = [DVec3::new(900.0, 0.0, 0.0), DVec3::new(900.0, 1.0, 0.0)];
    params.electrodes.edits.push(Edit::Split { line: far });
    desk.mold_mut().edit(params);
    desk.press("Create electrodes");
    until_designed(&mut desk);
    assert_eq!(desk.mold().electrodes.designed().unwrap().set.unmet_edits(), [0]);
    // Which, where, and what to do.
    desk.assert_shows("Change 1 has no effect: split from 900.00, 0.00 to 900.00, 1.00");
    desk.assert_shows("draw a line across the part");
}

#[test]
fn the_flanks_of_a_designed_electrode_are_milled_without_a_file() {
    let home = Home::new();
    let mut desk = designed(&home, [1280, 720]);
    let made = desk.mold().electrodes.designed().unwrap().clone();
    let first = &made.set.electrodes[0];
    let mill = |desk: &Desk| desk.mold().is_enabled(MoldCommand::MillFlanks.command());
    assert!(!mill(&desk), "none is selected");
    desk.press_role(Role::Row, &format!("Electrode {}", first.name));
    desk.press("Mill its flanks");
    assert_eq!(desk.app().shown(), "flank");
    let flank = |desk: &Desk| desk.flank().document.params().clone();
    let volume = desk.until_faces();
    assert!((volume / first.mesh.volume() - 1.0).abs() < 1e-9, "{volume}");
    let FlankSource::Mesh(source) = flank(&desk).source else { panic!("no face of a part") };
    assert_eq!((source.part(), source.fit.up), (format!("{} of stepped", first.name), DVec3::NEG_Z));
    // It is clamped as it burns no more: tips to the spindle.
    assert_eq!(flank(&desk).milling.workpiece.unwrap().z_axis, DVec3::NEG_Z);
    assert!(!desk.flank().document.is_unsaved());

    // The mesh goes along with the flank's file.
    desk.enter("Radius", "0.75");
    let file = home.path("tips.sparkpath");
    desk.key_with(Modifiers::COMMAND, Key::S);
    desk.type_path(&file);
    let before = flank(&desk);
    assert_eq!(Document::<FlankDocument>::open(&file).unwrap().params().clone(), before);

    // What is unsaved is not thrown away for another electrode.
    desk.enter("Radius", "0.5");
    desk.press_role(Role::Tab, "Mold workspace");
    desk.press("Mill its flanks");
    desk.assert_shows("Unsaved work");
    desk.press("Don't save");
    assert_eq!((flank(&desk).source, desk.flank().document.file().map(Path::to_owned)), (before.source, None));
}

impl Desk {
    /// Types `text` in the place of what the field called `name` holds, and leaves it.
    pub fn type_in(&mut self, name: &str, text: &str) {
        self.press_role(Role::TextInput, name);
        self.key_with(Modifiers::COMMAND, Key::A);
        self.window.event(egui::Event::Text(text.to_owned()));
        self.settle();
        self.key(Key::Enter);
    }
}

#[test]
fn datums_of_the_set_up_sheet_are_rows_of_the_form() {
    let home = Home::new();
    let mut desk = home.start(Opening::In("mold", None));
    desk.until_loaded();
    desk.press_role(Role::DisclosureTriangle, "Electrodes");
    desk.press_role(Role::DisclosureTriangle, "Set-up sheet");
    desk.press("Add to Datums");
    desk.enter("Datums 1, X", "12.5");
    let row = DatumRow { x_mm: 12.5, y_mm: 0.0, z_mm: 0.0, radius_mm: Some(10.0) };
    assert_eq!(desk.mold().document.params().setup.datum, [row]);
    assert_eq!(desk.mold().document.undo_label(false), Some("Datums 1, X"));
}

#[test]
fn every_parameter_of_electrodes_has_a_field() {
    let home = Home::new();
    let mut desk = home.start(Opening::In("mold", None));
    desk.until_loaded();
    desk.press_role(Role::DisclosureTriangle, "Electrodes");
    let before = desk.mold().document.params().electrodes.clone();
    for (name, text, step) in [
        ("Stages 1, Stock", "0.1", "Stages 1, Stock"),
        ("Stages 1, Pieces", "3", "Stages 1, Pieces"),
        ("Overlap", "0.4", "Overlap"),
        ("Least size", "0.5", "Least size"),
        ("Allowed rest", "0.03", "Allowed rest"),
        ("Orientation chamfer", "0.75", "Orientation chamfer"),
    ] {
        desk.enter(name, text);
        assert_eq!(desk.mold().document.undo_label(false), Some(step), "{name}");
    }
    desk.press_role(Role::CheckBox, "Retract limit: none");
    desk.enter("Retract limit", "60");
    assert_eq!(desk.mold().document.params().electrodes.lift_limit_mm, Some(60.0));
    desk.press_role(Role::DisclosureTriangle, "Blanks");
    desk.type_in("Sides", "20 8; 12,5; x");
    desk.assert_shows("Sides is 20 8; 12,5; x: numbers with commas between");
    assert_eq!(desk.mold().document.params().electrodes.blanks, before.blanks, "what is no list changes nothing");
    desk.type_in("Sides", "20; 8; 12,5");
    desk.type_in("Diameters", "16, 10");
    desk.enter("Increment", "2");
    desk.press_role(Role::DisclosureTriangle, "Burning times");
    desk.enter("Set-up", "20");
    desk.enter("Change", "7");
    desk.press_role(Role::DisclosureTriangle, "Cutters for electrodes");
    desk.press_role(Role::CheckBox, "same as the mold");
    desk.enter("Electrode cutters 1, Diameter", "0.8");
    let asked = desk.mold().document.params().electrodes.clone();
    let (stage, library) = (&asked.stages[0], &desk.mold().document.params().library);
    assert_eq!((stage.stock_mm, stage.quantity), (0.1, 3));
    assert_eq!(
        (asked.overlap_mm, asked.least_size_mm, asked.tolerance_mm, asked.datum_corner_mm),
        (0.4, 0.5, 0.03, 0.75)
    );
    assert_eq!((&*asked.blanks.sides_mm, &*asked.blanks.diameters_mm), (&[8.0, 12.5, 20.0][..], &[10.0, 16.0][..]));
    let overhead = asked.technology.overhead;
    assert_eq!((asked.blanks.increment_mm, overhead.setup_min, overhead.change_min), (2.0, 20.0, 7.0));
    let own = asked.cutters.as_ref().unwrap();
    assert!(own.cutter[0].diameter_mm == 0.8 && own.cutter[1..] == library.cutter[1..]);
    desk.picture("electrode_form_dark");
    // Of all this nothing is left where every step is taken back.
    for _ in 0..16 {
        desk.key_with(Modifiers::COMMAND, Key::Z);
    }
    assert_eq!((&desk.mold().document.params().electrodes, desk.mold().document.undo_label(false)), (&before, None));
}

#[test]
fn a_change_of_stages_makes_electrodes_of_all_of_them_again() {
    let home = Home::new();
    let mut desk = designed(&home, [1280, 720]);
    let first = desk.mold().electrodes.designed().unwrap().clone();
    desk.press_role(Role::DisclosureTriangle, "Electrodes");
    desk.press("Add to Stages");
    assert!(!desk.mold().is_designed());
    desk.assert_shows("out of date");
    desk.until("they are made again", |d| d.mold().is_designed() && !d.mold().work.is_busy());
    let made = desk.mold().electrodes.designed().unwrap().clone();
    let of = |stage: usize| made.set.electrodes.iter().filter(|e| e.stage == stage).count();
    assert!(of(0) > 0 && of(1) == first.set.electrodes.len(), "{} {}", of(0), of(1));
    desk.enter("Stages 1, Spark gap", "0.4");
    desk.assert_shows("out of date");
    // Who looks at regions goes on doing so.
    desk.press_role(Role::Tab, "List of Regions");
    desk.until("they are made again", |d| d.mold().is_designed() && !d.mold().work.is_busy());
    assert_eq!(desk.mold().electrodes.designed().unwrap().set.params.stages[0].gap_mm, 0.4);
    assert!(desk.mold().electrodes.seen().is_none() && !desk.shows("out of date"));
    // A step back shows what was made before, and makes nothing again.
    desk.key_with(Modifiers::COMMAND, Key::Z);
    assert!(desk.mold().is_designed() && !desk.mold().work.is_busy());
    assert!(Arc::ptr_eq(desk.mold().electrodes.designed().unwrap(), &made));
    // What the user stops does not begin again.
    desk.enter("Stages 1, Spark gap", "0.5");
    desk.until("it begins", |d| d.mold().design_state() == State::Running);
    desk.key(Key::Escape);
    desk.until("it has ended", |d| !d.mold().work.is_busy());
    assert_eq!(desk.mold().design_state(), State::Cancelled);
}

#[test]
fn the_place_where_most_is_left_is_flown_to_and_marked() {
    let home = Home::new();
    let mut desk = designed(&home, [1280, 720]);
    let made = desk.mold().electrodes.designed().unwrap().clone();
    let (electrode, burn, region) = most_left(&made.set);
    desk.press_role(Role::Row, &format!("Electrode {}", made.set.electrodes[electrode].name));
    desk.press(&format!("Show the thickest residual stock of region {}", region + 1));
    let left = made.set.regions[region].left;
    let burns = &desk.mold().electrodes;
    assert_eq!((burns.selected, burns.is_alone), (Some(BurnOf { electrode, burn }), true));
    assert_eq!(burns.place.as_ref().map(|place| place.at), Some(left.place));
    // Less than four decimals show is nothing.
    let most = if left.excess >= 5e-5 { left.excess } else { left.thickness };
    desk.assert_shows(&format!("region {}: residual stock {most:.4} mm", region + 1));
    let marker = desk.app().scene().markers[0].at;
    assert_eq!(marker, made.opening.in_mesh(left.place));
    desk.settle();
    let view = desk.window.get(By::new().role(Role::Image).label("3D viewport")).rect();
    let seen = desk.app().camera().project(marker, [view.width() as u32, view.height() as u32]).unwrap().pixel;
    let off = egui::vec2(seen.x as f32, seen.y as f32) - 0.5 * view.size();
    assert!(off.length() < 3.0, "it is in the middle of the view: {off:?}");
    desk.pictures("electrode_left");
    // Another electrode is another matter.
    desk.mold_mut().electrodes.deselect();
    desk.settle();
    assert!(!desk.shows(&format!("region {}: ", region + 1)) && desk.app().scene().markers.is_empty());
}

/// The region of which most is left, with an electrode and its burn for it.
fn most_left(set: &ElectrodeSet) -> (usize, usize, usize) {
    let thickness = |r: usize| set.regions[r].left.thickness;
    let region = (0..set.regions.len()).max_by(|a, b| thickness(*a).total_cmp(&thickness(*b))).unwrap();
    let is_for = |burn: &Burn| burn.parts.iter().any(|part| part.region == region);
    let mut all = set.electrodes.iter().enumerate();
    all.find_map(|(e, electrode)| Some((e, electrode.burns.iter().position(is_for)?, region))).unwrap()
}

/// Names and contents of the files of an export, without pages, whose pictures and times differ, and the manifest.
fn exported(folder: &Path) -> Vec<(OsString, Vec<u8>)> {
    let mut files: Vec<_> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.retain(|file| file.extension().is_some_and(|e| e != "html") && !file.ends_with(files::MANIFEST));
    files.sort();
    let content = |file: &PathBuf| (file.file_name().unwrap().to_owned(), std::fs::read(file).unwrap());
    files.iter().map(content).collect()
}

/// Opening, cutters, holders, material, names, divisions and burn directions by hand, overrides: a saved project has them
/// all, and the command line makes the same files of it to the last bit.
#[test]
fn a_saved_project_with_every_edit_is_answered_headless_as_in_the_window() {
    let home = Home::new();
    let [mesh, project, shown, headless] =
        ["bent.stl", "bent.sparkpath", "shown", "headless"].map(|name| home.path(name));
    // A second region beside the bent one: a groove that is open on one side.
    let groove = [[6.0, 1.0], [11.0, 1.0], [11.0, 2.5], [6.0, 2.5]].map(DVec2::from);
    let mold = difference(&bent_slot(), &prism(&[&groove], 7.0, 11.0).unwrap()).unwrap();
    write_stl(&mesh, &mold.mapped(|p| MinusX.in_mesh(p))).unwrap();
    let mut desk = home.start_in(Opening::In("mold", Some(mesh)), [1280, 720], 1.0);
    desk.take_cutters(&[Cutter::flat(2.0)]);
    let mut params = desk.mold().document.params().clone();
    params.opening = Some(MinusX);
    params.electrodes.cutters = Some(CutterLibrary { cutter: vec![Cutter::flat(0.5)] });
    params.electrodes.stages[0].gap_mm = 0.06;
    params.electrodes.material = "graphite".to_owned();
    params.electrodes.holders = vec![Holder { name: "mine".to_owned(), size_mm: [60.0, 60.0], height_mm: 25.0 }];
    desk.mold_mut().edit(params);
    desk.until_loaded();
    desk.press("Create electrodes");
    until_designed(&mut desk);
    let made = desk.mold().electrodes.designed().unwrap().clone();
    let leaves: Vec<usize> = (0..made.set.regions.len()).map(|r| made.leaves(r).len()).collect();
    let bent =
        leaves.iter().position(|count| *count == 2).unwrap_or_else(|| panic!("{leaves:?} {:?}", made.set.regions));
    let [Some(a), Some(b)] = made.leaves(bent)[..] else { panic!("{:?}", made.leaves(bent)) };
    let direction = DVec3::new(-0.1, 0.0, -1.0);
    let mut params = desk.mold().document.params().clone();
    params.electrodes.edits = vec![
        Edit::Merge { places: [a, b] },
        Edit::Split { line: [DVec3::new(2.0, -7.5, 10.0), DVec3::new(2.0, -1.5, 10.0)] },
        Edit::Make { place: made.places[bent].unwrap(), method: Method::Extruding },
        Edit::Burn { place: made.places[1 - bent].unwrap(), direction },
    ];
    params.electrodes.overrides.push("E01:machinable".parse().unwrap());
    desk.mold_mut().edit(params);
    desk.until("they are made again", |d| d.mold().is_designed() && !d.mold().work.is_busy());
    let made = desk.mold().electrodes.designed().unwrap().clone();
    assert!(made.set.unmet_edits().is_empty(), "{:?}", made.report.sentence);
    assert!(made.set.regions[1 - bent].direction.distance(direction.normalize()) < 1e-12);
    desk.key_with(Modifiers::COMMAND, Key::S);
    desk.type_path(&project);
    desk.key_with(Modifiers::COMMAND, Key::E);
    desk.type_path(&shown);
    desk.until("they are exported", |d| !d.mold().work.is_busy());
    desk.press("Export rest\u{2026}");
    desk.type_path(&shown);
    desk.until("the rest is exported", |d| !d.mold().work.is_busy());
    for command in ["electrodes", "uncut"] {
        let mut program = Command::new(env!("CARGO_BIN_EXE_sparkpath"));
        program.args([command, "--no-pictures", "--out"]).args([&headless, &project]);
        let said = program.env("XDG_CONFIG_HOME", home.path("no-settings")).output().unwrap();
        assert!(matches!(said.status.code(), Some(0 | 3)), "{}", String::from_utf8_lossy(&said.stderr));
    }
    let [shown, headless] = [shown, headless].map(|folder| exported(&folder));
    let names = |files: &[(OsString, Vec<u8>)]| files.iter().map(|(name, _)| name.clone()).collect::<Vec<_>>();
    assert_eq!(names(&shown), names(&headless));
    for known in ["burn_table.csv", "electrodes.json", "uncut.json", "uncut_segments.csv"] {
        assert!(names(&shown).iter().any(|name| *name == known), "{known}");
    }
    for ((name, shown), (_, headless)) in shown.iter().zip(&headless) {
        let lines = [shown, headless].map(|bytes| String::from_utf8_lossy(bytes).into_owned());
        let differing = lines[0].lines().zip(lines[1].lines()).find(|(a, b)| a != b);
        assert!(shown == headless, "{name:?} differs: {differing:?}");
    }
}

#[test]
fn ways_of_dividing_are_compared_with_the_electrodes_that_are_shown() {
    let home = Home::new();
    let mut desk = with_electrodes(&home, [1280, 900]);
    for shut in ["Mold", "Cutters", "Uncut"] {
        desk.press_role(Role::DisclosureTriangle, shut);
    }
    desk.press_role(Role::DisclosureTriangle, "Electrodes");
    desk.press("Compare ways of dividing");
    desk.until("they are compared", |d| !d.mold().work.is_busy());
    let ways = desk.mold().work.divisions(desk.mold().params()).unwrap().clone();
    let made = desk.mold().electrodes.designed().unwrap();
    assert_eq!(ways.iter().map(|way| way.heads).collect::<Vec<_>>()[..1], [1]);
    assert!(
        ways[3].is_own && ways[3].burns == 2 && ways[3].minutes == made.set.minutes().map(|all| all.mean),
        "{ways:?}"
    );
    assert!(ways[0].not_millable == 1 && ways[3].not_millable == 0, "{ways:?}");
    desk.assert_shows("whole faces");
    desk.picture("mold_divisions_dark");
}

/// A click in the view on a place of the mold.
pub(crate) fn click_at(desk: &mut Desk, place: DVec3) {
    let view = desk.window.get(By::new().role(Role::Image).label("3D viewport")).rect();
    let size = [view.width() as u32, view.height() as u32];
    let seen = desk.app().camera().project(place, size).unwrap().pixel;
    let at = view.min + egui::vec2(seen.x as f32, seen.y as f32);
    desk.window.hover_at(at);
    desk.window.drag_at(at);
    desk.window.drop_at(at);
    desk.settle();
}

#[test]
fn what_was_computed_is_shown_at_once_when_its_project_is_opened_and_proven_before_an_export() {
    let home = Home::new();
    let (file, before, after) = (home.path("kept.sparkpath"), home.path("before"), home.path("after"));
    let export = |desk: &mut Desk, folder: &Path| {
        desk.key_with(Modifiers::COMMAND, Key::E);
        desk.type_path(folder);
        desk.until("it is exported", |d| !d.mold().work.is_busy());
        exported(folder)
    };
    let mut desk = designed(&home, [1280, 720]);
    let made = desk.mold().electrodes.designed().unwrap().clone();
    assert!(made.is_proven);
    let files = export(&mut desk, &before);
    desk.key_with(Modifiers::COMMAND, Key::S);
    desk.type_path(&file);
    assert!(!desk.mold().document.is_unsaved());
    drop(desk);

    // Nothing but the project is opened.
    let mut desk = home.start(Opening::File(file.clone()));
    until_designed(&mut desk);
    assert_eq!((desk.mold().state(), desk.mold().design_state()), (State::Ready, State::Ready));
    let kept = desk.mold().electrodes.designed().unwrap().clone();
    assert!(!kept.is_proven && !desk.mold().document.is_unsaved());
    let shapes =
        |set: &ElectrodeSet| set.electrodes.iter().map(|e| (e.name.clone(), e.mesh.clone())).collect::<Vec<_>>();
    assert_eq!(shapes(&kept.set), shapes(&made.set));
    assert!(bodies(&desk) > 0 && !desk.mold().regions().is_empty());
    assert_eq!(export(&mut desk, &after), files, "what is exported is computed anew, and is the same to the last bit");
    let is_proven =
        |desk: &Desk| desk.mold().electrodes.designed().unwrap().is_proven && desk.mold().found().unwrap().is_proven;
    assert!(is_proven(&desk), "what was proven is not computed once more");

    // Of other parameters nothing was kept.
    let mut params = desk.mold().document.params().clone();
    params.tolerance_mm = 0.03;
    Document::new(params).export(&file).unwrap();
    drop(desk);
    let mut desk = home.start(Opening::File(file.clone()));
    desk.until_loaded();
    desk.settle();
    assert_eq!(desk.mold().state(), State::Missing);

    // What is kept and was damaged since is not taken.
    for entry in std::fs::read_dir(home.folders().results).unwrap() {
        std::fs::write(entry.unwrap().path(), "damaged").unwrap();
    }
    desk.press("Find rest material");
    desk.until("it is found", |d| d.mold().state() == State::Ready && !d.mold().work.is_busy());
    assert!(desk.mold().found().unwrap().is_proven);
}
