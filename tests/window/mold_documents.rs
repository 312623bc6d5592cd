//! Documents of molds: opened, dropped, saved, and decisions that hold for one mold alone.

use std::path::Path;
use std::sync::Arc;

use egui::{Key, Modifiers, Role};
use files::Override;
use files::{AnyDocument, Document};
use geometry::mesh::Mesh;
use glam::DVec3;
use import::write_stl;
use mold::cutter::Cutter;
use mold::electrode::params::Edit;
use mold::opening::Opening::{MinusX, PlusZ};
use sparkpath::shell::run::Opening;
use sparkpath::workspaces::flank::FlankWorkspace;
use sparkpath::workspaces::mold::document::MoldParams;

use crate::desk::{Desk, Home};
use crate::mold::{Dropped, stepped};

#[test]
fn a_mold_is_saved_and_dropped_on_either_workspace() {
    let home = Home::new();
    let mut desk = home.start(Opening::In("mold", Some(home.mold())));
    desk.take_cutters(&[Cutter::flat(1.5)]);
    desk.until_idle();
    let saved = desk.mold().document.params().clone();
    desk.key_with(Modifiers::COMMAND, Key::S);
    desk.type_path(&home.path("mine"));
    desk.take_cutters(&[Cutter::ball(1.5)]);
    assert!(desk.mold().document.name() == "mine" && desk.mold().document.is_unsaved());
    desk.assert_shows("mine \u{2022}");
    assert_eq!(desk.app().title(), "mine* - Sparkpath");
    desk.press_role(Role::Tab, "Blisk workspace");
    let app = desk.window.state_mut();
    app.open(&home.path("mine.sparkpath"));
    // Opened behind the window: the mold of before is ready until then.
    let is_opened = |d: &Desk| d.app().shown() == "mold" && *d.mold().document.params() == saved;
    desk.until("the project is opened", is_opened);
    desk.until_loaded();
    assert!(is_opened(&desk) && desk.mold().document.name() == "mine" && !desk.mold().document.is_unsaved());
    assert!(!desk.mold().document.is_unsaved());
    // While molds are shown a mesh is one, whatever blisk there is.
    let other = home.path("other.stl");
    write_stl(&other, &stepped()).unwrap();
    desk.window.input_mut().dropped_files.push(Arc::new(Dropped(other.clone())));
    desk.settle();
    assert_eq!(desk.mold().document.params().mesh.as_deref(), Some(&*other));
    assert!(desk.blisk().document.params().blisk.mesh.is_none());
}

#[test]
fn changes_of_a_mold_are_not_lost_without_a_word() {
    const UNSAVED: &str = "has unsaved changes";
    let home = Home::new();
    let [mold, other, file] = [home.mold(), home.path("other.stl"), home.path("mine.sparkpath")];
    write_stl(&other, &stepped()).unwrap();
    let mut desk = home.start(Opening::In("mold", None));
    // Cutters that are chosen first stay when the mold comes, and are unsaved all along.
    desk.take_cutters(&[Cutter::flat(1.5)]);
    let drop_on = |desk: &mut Desk, path: &Path| {
        desk.window.input_mut().dropped_files.push(Arc::new(Dropped(path.to_owned())));
        desk.settle();
    };
    drop_on(&mut desk, &mold);
    assert!(!desk.shows(UNSAVED) && desk.mold().document.is_unsaved());
    assert_eq!(desk.mold().document.params().library.cutter, [Cutter::flat(1.5)]);
    drop_on(&mut desk, &other);
    desk.assert_shows("Mold: stepped has unsaved changes");
    desk.press("Cancel");
    assert_eq!(desk.mold().document.params().mesh.as_ref(), Some(&mold));
    // The end of the program is asked about too; saved work goes on to it.
    desk.key_with(Modifiers::COMMAND, Key::Q);
    desk.assert_shows(UNSAVED);
    desk.press("Cancel");
    drop_on(&mut desk, &other);
    desk.press("Save");
    desk.type_path(&file);
    assert!(file.exists() && !desk.shows(UNSAVED));
    assert_eq!(desk.mold().document.params().mesh.as_ref(), Some(&other));
    desk.take_cutters(&[Cutter::flat(2.5)]);
    drop_on(&mut desk, &file);
    desk.press("Don't save");
    assert_eq!(
        (desk.mold().document.params().mesh.as_ref(), desk.mold().document.name().as_str()),
        (Some(&mold), "mine")
    );
    drop_on(&mut desk, &other);
    assert!(!desk.shows(UNSAVED) && desk.mold().document.params().mesh.as_ref() == Some(&other), "nothing was changed");
}

/// Unsaved work is asked about before a path is, in every workspace, and once.
#[test]
fn what_is_unsaved_is_asked_about_before_the_path() {
    const UNSAVED: &str = "has unsaved changes";
    let home = Home::new();
    let other = home.path("other.stl");
    write_stl(&other, &moved()).unwrap();
    let mut desk = home.start(Opening::In("mold", Some(home.mold())));
    desk.until_loaded();
    desk.take_cutters(&[Cutter::flat(1.5)]);
    desk.key_with(Modifiers::COMMAND, Key::O);
    assert!(desk.shows(UNSAVED) && !desk.shows("Type or paste the path"));
    desk.press("Don't save");
    assert!(!desk.shows(UNSAVED));
    desk.type_path(&other);
    assert!(!desk.shows(UNSAVED) && desk.mold().document.params().mesh.as_ref() == Some(&other));
    desk.press_role(Role::Tab, "Flank workspace");
    let flank = &mut desk.window.state_mut().workspace_mut::<FlankWorkspace>().unwrap().desk;
    let mut params = flank.params().clone();
    params.cutter.radius_mm += 1.0;
    flank.edit(params);
    desk.settle();
    desk.key_with(Modifiers::COMMAND, Key::O);
    assert!(desk.shows(UNSAVED) && !desk.shows("Type or paste the path"));
    desk.press("Cancel");
    assert!(!desk.shows(UNSAVED) && !desk.shows("Type or paste the path"));
}

/// The stepped mold a millimetre aside: another part, with parts of regions of the same names.
fn moved() -> Mesh {
    let mesh = stepped();
    Mesh { vertices: mesh.vertices.iter().map(|p| *p + DVec3::X).collect(), ..mesh }
}

/// `params` with everything that is decided for one part only.
fn decided(params: &MoldParams) -> MoldParams {
    let mut decided = params.clone();
    decided.opening = Some(MinusX);
    decided.electrodes.edits.push(Edit::Split { line: [DVec3::X, DVec3::Y] });
    let parts = vec!["R1.1".to_owned()];
    let of = "E01".to_owned();
    decided.electrodes.overrides.push(Override { of, parts, ..Override::whatever("approach") });
    decided
}

/// Electrodes and parts of regions have the same names on every mold: what was decided on one holds for no other.
#[test]
fn what_is_decided_for_one_mold_holds_for_no_other() {
    let home = Home::new();
    let other = home.path("other.stl");
    write_stl(&other, &moved()).unwrap();
    let mut desk = home.start(Opening::In("mold", Some(home.mold())));
    desk.take_cutters(&[Cutter::flat(3.0)]);
    desk.until_loaded();
    let standard = desk.mold().document.params().electrodes.clone();
    let mut params = decided(desk.mold().document.params());
    (params.tolerance_mm, params.electrodes.lift_mm) = (0.05, 2.0);
    desk.mold_mut().edit(params);
    (desk.mold_mut().electrodes.exploded, desk.mold_mut().least_volume) = (0.5, 100.0);
    let before = desk.app().camera().backward();
    desk.key(Key::Num7);
    desk.until("the view has turned", |d| d.app().camera().backward().z > 0.9999);

    desk.drop_file(&other);
    desk.press("Don't save");
    desk.until_loaded();
    let now = desk.mold();
    assert_eq!(now.params().mesh.as_ref(), Some(&other));
    assert_eq!((&now.params().electrodes, now.params().opening), (&standard, Some(PlusZ)), "the one that is proposed");
    assert_eq!(now.params().tolerance_mm, MoldParams::default().tolerance_mm);
    assert_eq!(now.params().library.cutter, [Cutter::flat(3.0)], "a shop has its cutters for every mold");
    assert_eq!((now.electrodes.exploded, now.least_volume), (0.0, 0.0));
    assert!(desk.app().camera().backward().distance(before) < 1e-9, "{}", desk.app().camera().backward());
    let file = home.path("other.sparkpath");
    desk.key_with(Modifiers::COMMAND, Key::S);
    desk.type_path(&file);
    let saved = Document::<MoldParams>::open(&file).unwrap().params().clone();
    assert!(saved.electrodes.edits.is_empty() && saved.electrodes.overrides.is_empty());
}

/// A file that has another content is another part, whatever it is called.
#[test]
fn decisions_do_not_pass_to_another_mesh_in_the_same_file() {
    let home = Home::new();
    let (mesh, file) = (home.mold(), home.path("mine.sparkpath"));
    let mut desk = home.start(Opening::In("mold", Some(mesh.clone())));
    desk.until_loaded();
    let params = decided(desk.mold().document.params());
    desk.mold_mut().edit(params.clone());
    desk.key_with(Modifiers::COMMAND, Key::S);
    desk.type_path(&file);
    // Read again from the same file, and opened again: they hold.
    desk.key_with(Modifiers::COMMAND, Key::R);
    desk.until_loaded();
    assert_eq!(*desk.mold().document.params(), params);
    let mut desk = home.start(Opening::In("mold", Some(file.clone())));
    desk.until_loaded();
    assert!(*desk.mold().document.params() == params && !desk.mold().document.is_unsaved());

    write_stl(&mesh, &moved()).unwrap();
    desk.key_with(Modifiers::COMMAND, Key::R);
    desk.until_loaded();
    let is_clean = |desk: &Desk| {
        let MoldParams { opening, electrodes, .. } = desk.mold().document.params();
        *opening == Some(PlusZ) && electrodes.edits.is_empty() && electrodes.overrides.is_empty()
    };
    assert!(is_clean(&desk) && desk.mold().document.is_unsaved());
    assert!(desk.log().iter().any(|line| line.contains("1 override") && line.contains("dropped")), "{:?}", desk.log());
    // Nor by way of the file, nor by undo.
    let mut desk = home.start(Opening::In("mold", Some(file)));
    desk.settle();
    desk.press("Use as it is now");
    desk.until_loaded();
    desk.settle();
    assert!(is_clean(&desk));
    let tolerant = MoldParams { tolerance_mm: 0.05, ..desk.mold().document.params().clone() };
    desk.mold_mut().edit(tolerant);
    for _ in 0..3 {
        desk.key_with(Modifiers::COMMAND, Key::Z);
        assert!(is_clean(&desk));
    }
}
