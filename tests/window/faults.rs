//! Faults that happen on a machine: they are said, and nothing is lost.

use std::path::{Path, PathBuf};

use egui::{Key, Modifiers, Role};
use egui_kittest::kittest::{By, NodeT as _, Queryable as _};
use files::{AnyDocument, Document, Recovery};
use sparkpath::shell::run::{Opening, SparkpathApp};
use sparkpath::workspaces::blisk::document::stage::Stage;
use sparkpath::workspaces::mold::document::MoldParams;
use sparkpath::workspaces::preferences::ThemeChoice;

use crate::desk::{Desk, Home};

/// A mold in the project `mine.sparkpath`, open in a window.
fn open(home: &Home) -> (Desk, PathBuf) {
    let file = home.path("mine.sparkpath");
    let mesh = Some(home.mold());
    Document::new(MoldParams { mesh, ..MoldParams::default() }).save_as(&file).unwrap();
    (again(home, &file), file)
}

fn again(home: &Home, file: &Path) -> Desk {
    let mut desk = home.start(Opening::File(file.to_owned()));
    desk.until_loaded();
    desk
}

fn edit(desk: &mut Desk, tolerance_mm: f64) {
    let params = MoldParams { tolerance_mm, ..desk.mold().document.params().clone() };
    desk.mold_mut().edit(params);
    desk.settle();
}

fn saved(file: &Path) -> f64 {
    Document::<MoldParams>::open(file).unwrap().params().tolerance_mm
}

fn control(desk: &mut Desk, key: Key) {
    desk.key_with(Modifiers::COMMAND, key);
}

#[test]
fn two_windows_on_one_project_overwrite_nothing_unasked() {
    const CHANGED: &str = "was changed by another program since it was read";
    let home = Home::new();
    let (mut first, file) = open(&home);
    let mut second = again(&home, &file);
    edit(&mut first, 0.03);
    edit(&mut second, 0.04);
    first.wait(2.0);
    second.wait(2.0);
    control(&mut first, Key::S);
    assert_eq!(saved(&file), 0.03);
    // The other one says so, and saves nothing until it is told what to do.
    control(&mut second, Key::S);
    second.assert_shows(CHANGED);
    assert!(saved(&file) == 0.03 && second.mold().document.is_unsaved());
    second.press("Cancel");
    assert!(!second.shows(CHANGED) && second.mold().document.is_unsaved());
    // A copy of its work lies beside that of the first, which has none any more.
    let copies = || std::fs::read_dir(home.folders().autosave).unwrap().flatten();
    let is_copy = |path: PathBuf| path.extension().is_some_and(|e| e == "sparkpath");
    assert_eq!(copies().filter(|entry| is_copy(entry.path())).count(), 1);
    // Both stay.
    control(&mut second, Key::S);
    second.press("Save under another name…");
    second.type_path(&home.path("other.sparkpath"));
    assert_eq!((saved(&file), saved(&home.path("other.sparkpath"))), (0.03, 0.04));
    assert!(!second.mold().document.is_unsaved());
    // Or the one replaces the other.
    let mut third = again(&home, &file);
    edit(&mut first, 0.05);
    control(&mut first, Key::S);
    edit(&mut third, 0.06);
    control(&mut third, Key::S);
    third.press("Replace it");
    assert!(saved(&file) == 0.06 && !third.mold().document.is_unsaved());
    edit(&mut third, 0.07);
    control(&mut third, Key::S);
    assert!(!third.shows(CHANGED), "it is its own file again");
    // Or is read again, after the question about unsaved work.
    edit(&mut first, 0.08);
    control(&mut first, Key::S);
    first.press("Read it again");
    first.assert_shows("has unsaved changes");
    first.press("Don't save");
    first.until_loaded();
    assert_eq!(first.mold().document.params().tolerance_mm, 0.07);
}

#[test]
fn what_follows_a_save_waits_for_the_answer_about_a_changed_file() {
    let home = Home::new();
    let (mut desk, file) = open(&home);
    edit(&mut desk, 0.03);
    Document::new(MoldParams { tolerance_mm: 0.09, ..desk.mold().document.params().clone() }).save_as(&file).unwrap();
    control(&mut desk, Key::O);
    desk.press("Save");
    desk.assert_shows("The file has changed");
    assert!(!desk.shows("Type or paste the path"));
    desk.press("Replace it");
    assert_eq!(saved(&file), 0.03);
    desk.assert_shows("Type or paste the path");
}

/// Whatever is wrong in it: it is the user's work.
#[test]
fn work_with_a_wrong_number_is_recovered_with_it() {
    let home = Home::new();
    let (mut desk, file) = open(&home);
    edit(&mut desk, -1.0);
    desk.wait(2.0);
    drop(desk);
    assert_eq!(Recovery::find(&home.folders().autosave).len(), 1);
    let mut desk = home.start(Opening::Demonstration);
    desk.press("Recover");
    desk.until("the work is there", |desk| desk.mold().document.params().tolerance_mm == -1.0);
    assert!(desk.mold().document.file() == Some(&*file) && desk.mold().document.problem().is_some());
    edit(&mut desk, 0.03);
    control(&mut desk, Key::S);
    assert_eq!(saved(&file), 0.03);
}

#[test]
fn a_lost_graphics_device_ends_the_program_with_its_work_kept() {
    let home = Home::new();
    let file = home.path("mine.sparkpath");
    Document::new(MoldParams { mesh: Some(home.mold()), ..MoldParams::default() }).save_as(&file).unwrap();
    let (folders, opening) = (home.folders(), Opening::File(file));
    let (tell, told) = std::sync::mpsc::channel();
    let window = egui_kittest::Harness::builder().with_size(egui::vec2(1280.0, 720.0));
    let mut desk = Desk::start(window, move |cc| {
        let device = cc.wgpu_render_state.as_ref().unwrap().device.clone();
        tell.send(device).unwrap();
        SparkpathApp::new(cc, &opening, Some(folders)).unwrap()
    });
    let device = told.recv().unwrap();
    desk.until_loaded();
    let params = MoldParams { tolerance_mm: 0.03, ..desk.mold().document.params().clone() };
    desk.mold_mut().edit(params);
    assert!(desk.app().ending().get().is_none());
    device.destroy();
    let _ = device.poll(wgpu::PollType::Poll);
    desk.window.step();
    let ending = desk.app().ending().get().expect("it ends").clone();
    assert!(ending.contains("device was lost") && ending.contains("offered at the next start"), "{ending}");
    drop(desk);
    let [copy] = &Recovery::find(&home.folders().autosave)[..] else { panic!("one copy") };
    assert_eq!(copy.open::<MoldParams>().unwrap().params().tolerance_mm, 0.03);
}

#[test]
fn a_mesh_that_changes_or_goes_away_meanwhile_is_said() {
    let home = Home::new();
    let (mut desk, _) = open(&home);
    let mesh = home.path("stepped.stl");
    // A look begins every 2 s, and wakes the window when it is done.
    let look = |desk: &mut Desk| {
        desk.wait(2.5);
        desk.await_wake();
        desk.window.step();
    };
    (0..3).for_each(|_| look(&mut desk));
    let mut until_said = |words: &str| {
        while !desk.log().iter().any(|line| line.contains(words)) {
            look(&mut desk);
        }
    };
    std::fs::copy("tests/data/cube.stl", &mesh).unwrap();
    until_said("has changed on the disk");
    std::fs::remove_file(&mesh).unwrap();
    until_said("is no longer there");
}

#[cfg(unix)]
mod drives {
    use sparkpath::workspaces::mold::MoldWorkspace;
    use sparkpath::workspaces::mold::paths::MoldPath;

    use super::*;

    /// A pipe at whose other end nobody is: what reads it waits for ever, as on a drive that does not answer.
    fn silent(home: &Home, name: &str) -> PathBuf {
        let pipe = home.path(name);
        assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
        pipe
    }

    /// So many frames, whatever is waited for.
    fn frames(desk: &mut Desk) {
        desk.window.run_steps(4);
    }

    fn cancel(desk: &mut Desk) {
        desk.window.key_press(Key::Escape);
        frames(desk);
    }

    #[test]
    fn a_project_on_a_drive_that_does_not_answer_can_be_cancelled() {
        let home = Home::new();
        let (mut desk, file) = open(&home);
        let pipe = silent(&home, "far.sparkpath");
        desk.window.state_mut().open(&pipe);
        frames(&mut desk);
        desk.assert_shows("opening far.sparkpath: its drive does not answer yet");
        cancel(&mut desk);
        assert!(!desk.app().is_opening() && !desk.shows("its drive does not answer yet"));
        assert!(desk.log().iter().any(|line| line.contains("was not opened: its drive does not answer")));
        assert_eq!(desk.mold().document.file(), Some(&*file), "what was open stays");
        edit(&mut desk, 0.03);
        control(&mut desk, Key::S);
        assert_eq!(saved(&file), 0.03);
    }

    #[test]
    fn a_mesh_on_a_drive_that_does_not_answer_can_be_cancelled() {
        for (workspace, name) in
            [("mold", "far.stl"), ("flank", "far.stl"), ("blisk", "far.stl"), ("flank", "lower.csv")]
        {
            let home = Home::new();
            let mut desk = home.start(Opening::In(workspace, Some(silent(&home, name))));
            let is_said = |desk: &Desk| desk.shows("does not answer yet");
            desk.window.step();
            while !is_said(&desk) {
                desk.await_wake();
                desk.window.step();
            }
            cancel(&mut desk);
            desk.until("it is given up", |desk| !is_said(desk));
        }
    }

    #[test]
    fn a_library_on_a_drive_that_does_not_answer_is_refused() {
        let home = Home::new();
        let (mut desk, _) = open(&home);
        let pipe = silent(&home, "cutters.toml");
        desk.window.state_mut().act(|_: &mut MoldWorkspace, cx| cx.ask(MoldPath::Cutters, ""));
        desk.settle();
        desk.type_path(&pipe);
        desk.assert_shows("cutters.toml: the drive does not answer");
    }

    #[test]
    fn a_project_saved_to_a_drive_that_does_not_answer_stays_unsaved() {
        let home = Home::new();
        let (mut desk, file) = open(&home);
        edit(&mut desk, 0.03);
        std::fs::remove_file(&file).unwrap();
        silent(&home, "mine.sparkpath");
        desk.window.key_press_modifiers(Modifiers::COMMAND, Key::S);
        frames(&mut desk);
        desk.assert_shows("saving mine.sparkpath: its drive does not answer yet");
        desk.window.key_press_modifiers(Modifiers::COMMAND, Key::S);
        frames(&mut desk);
        assert!(desk.log().iter().any(|line| line.contains("still being saved")));
        cancel(&mut desk);
        assert!(desk.mold().document.is_unsaved() && !desk.app().is_opening());
        desk.key_with(Modifiers::COMMAND | Modifiers::SHIFT, Key::S);
        desk.type_path(&home.path("near.sparkpath"));
        assert_eq!(saved(&home.path("near.sparkpath")), 0.03);
    }

    #[test]
    fn names_from_right_to_left_are_shown_and_those_that_are_no_text_are_refused() {
        use std::os::unix::ffi::OsStringExt as _;
        let home = Home::new();
        let (mut desk, file) = open(&home);
        // The fonts of the window have no such letters; the system draws the title.
        desk.window.ctx.set_missing_glyph_policy(egui::MissingGlyphPolicy::Tofu);
        let name = "\u{5e9}\u{5dc}\u{5d5}\u{5dd}";
        let hebrew = home.path(&format!("{name}.sparkpath"));
        std::fs::copy(&file, &hebrew).unwrap();
        desk.drop_file(&hebrew);
        desk.until_loaded();
        assert!(desk.app().title().contains(name), "{}", desk.app().title());
        assert_eq!(desk.app().context().preferences.recent.iter().next(), Some(&*hebrew));
        let latin = std::ffi::OsString::from_vec(b"schl\xfcssel.sparkpath".to_vec());
        let latin = home.path("").join(latin);
        std::fs::copy(&file, &latin).unwrap();
        desk.drop_file(&latin);
        desk.assert_shows("rename the file");
        desk.press("Close");
        assert_eq!(desk.mold().document.file(), Some(&*hebrew), "what was open stays");
        // What is remembered is still written.
        let read = sparkpath::workspaces::preferences::Preferences::read(&home.folders().config);
        assert_eq!(read.recent.iter().next(), Some(&*hebrew));
    }
}

/// The controls that a window of so many pixels, of which `scale` make a point, cuts off at its sides. Above and below,
/// panels scroll.
fn cut_off(desk: &Desk, pixels: [u16; 2], scale: f32) -> Vec<String> {
    let width = f32::from(pixels[0]) / scale;
    let roles =
        [Role::Button, Role::CheckBox, Role::SpinButton, Role::Slider, Role::ComboBox, Role::TextInput, Role::Tab];
    let all = roles.into_iter().flat_map(|role| desk.window.query_all(By::new().role(role)));
    let seen = all.map(|node| (node.rect(), format!("{:?}", node.accesskit_node().label())));
    let cut = seen.filter(|(rect, _)| rect.left() < -0.5 || rect.right() > width + 0.5);
    cut.map(|(rect, name)| format!("{name} {rect:?}")).collect()
}

/// As little room as 640 by 480 pixels, and a large screen of which each point takes three pixels.
#[test]
fn every_control_is_within_windows_of_640_by_480_and_of_4k_at_300_percent() {
    for (pixels, scale, theme) in [([640, 480], 1.0, ThemeChoice::Dark), ([3840, 2160], 3.0, ThemeChoice::Light)] {
        let home = Home::new();
        let mut desk = home.start_in(Opening::In("mold", Some(home.mold())), pixels, scale);
        desk.window.state_mut().context_mut().preferences.theme = theme;
        desk.until_loaded();
        for workspace in ["Mold", "Flank", "Blisk"] {
            desk.press_role(Role::Tab, &format!("{workspace} workspace"));
            if workspace == "Blisk" {
                desk.until_done(Stage::Electrode);
            }
            let cut = cut_off(&desk, pixels, scale);
            assert!(cut.is_empty(), "{workspace} in {pixels:?}: {cut:#?}");
            if let Some(folder) = std::env::var_os("SPARKPATH_PICTURES") {
                let name = format!("{workspace}_{}.png", pixels[0]);
                desk.window.render().unwrap().save(Path::new(&folder).join(name)).unwrap();
            }
        }
    }
}
