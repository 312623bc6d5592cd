//! Pictures from the command line: of meshes, of projects, and of plans in their reports.

use std::path::Path;

#[cfg(target_os = "linux")]
use super::blind;
use super::{COMES_OUT, CUBE, job, path, sparkpath, text};

/// The pixels of a PNG file, which must have more than one colour.
fn picture(png: &[u8]) -> image::RgbImage {
    let image = image::load_from_memory_with_format(png, image::ImageFormat::Png).unwrap().into_rgb8();
    let first = *image.get_pixel(0, 0);
    assert!(image.pixels().any(|p| *p != first), "nothing is drawn");
    image
}

/// Colours of a picture that are clearly more red than blue: copper, not steel nor the background.
fn copper(image: &image::RgbImage) -> usize {
    image.pixels().filter(|p| i32::from(p[0]) > i32::from(p[2]) + 40).count()
}

#[test]
fn meshes_are_drawn_in_the_size_asked_for_and_each_in_its_own_colour() {
    let folder = tempfile::tempdir().unwrap();
    let png = folder.path().join("a.png");
    let (blisk, electrode) = (path("part.stl"), path("out/electrode_1.stl"));
    let draw = |meshes: &[&str], rest: &[&str]| {
        let output = sparkpath(&[&["render", "--units", "mm", "--png", png.to_str().unwrap()], meshes, rest].concat());
        assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
        picture(&std::fs::read(&png).unwrap())
    };
    let alone = draw(&[&blisk], &["--size", "320x200"]);
    assert_eq!(alone.dimensions(), (320, 200));
    let both = draw(&[&blisk, &electrode], &["--size", "320x200", "--view", "Left"]);
    let other = draw(&[&blisk], &["--size", "320x200", "--view", "left"]);
    assert!(copper(&both) > copper(&other) + 50, "the second mesh has another colour");
    let again = draw(&[&blisk, &electrode], &["--size", "320x200", "--view", "left"]);
    assert!(both == again, "the same picture again");
    let dark = draw(&[&blisk], &["--size", "320x200", "--theme", "dark"]);
    let brightness = |image: &image::RgbImage| image.get_pixel(0, 0).0.iter().map(|c| u32::from(*c)).sum::<u32>();
    assert!(brightness(&dark) < 300 && brightness(&alone) > 600);
}

#[test]
fn a_project_is_drawn_in_its_final_pose_and_at_a_node() {
    let folder = tempfile::tempdir().unwrap();
    let project = job(folder.path(), COMES_OUT);
    let png = folder.path().join("a.png");
    let drawn = |rest: &[&str]| {
        let files = ["render", &project, "--png", png.to_str().unwrap(), "--size", "400x260"];
        let output = sparkpath(&[&files, rest].concat());
        assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
        picture(&std::fs::read(&png).unwrap())
    };
    let into_channel = drawn(&["--view", "channel"]);
    assert!(copper(&into_channel) > 500);
    let withdrawn = drawn(&["--node", "5"]);
    let changed = withdrawn.pixels().zip(into_channel.pixels()).filter(|(a, b)| a[0].abs_diff(b[0]) > 20).count();
    assert!(changed > 500, "withdrawn the electrode stands elsewhere: {changed} pixels");
    let room = drawn(&["--node", "5", "--swept", "--electrode", "1"]);
    let coloured = room.pixels().zip(withdrawn.pixels()).filter(|(a, b)| a[0].abs_diff(b[0]) > 8).count();
    assert!(coloured > 300, "the swept volume is shown: {coloured} pixels");
}

#[test]
fn an_electrode_or_a_node_that_there_is_not_is_not_drawn() {
    let folder = tempfile::tempdir().unwrap();
    let project = job(folder.path(), COMES_OUT);
    let png = folder.path().join("a.png");
    let draw = |rest: &[&str]| sparkpath(&[&["render", &project, "--png", png.to_str().unwrap()], rest].concat());
    let second = draw(&["--electrode", "2"]);
    assert_eq!(second.status.code(), Some(2));
    assert!(text(&second.stderr).contains("1 electrode, counted from 1"), "{}", text(&second.stderr));
    let beyond = draw(&["--node", "100000"]);
    assert_eq!(beyond.status.code(), Some(2));
    assert!(text(&beyond.stderr).contains("nodes 0 to"), "{}", text(&beyond.stderr));
    assert!(!png.exists());
}

#[test]
fn what_cannot_be_drawn_is_one_line_with_code_2() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str, content: &str| {
        let file = folder.path().join(name);
        std::fs::write(&file, content).unwrap();
        file.to_str().unwrap().to_owned()
    };
    let (cube, project) = (at("cube.stl", CUBE), at("a.sparkpath", "{}"));
    let png = folder.path().join("a.png").to_str().unwrap().to_owned();
    let nowhere = folder.path().join("absent/a.png").to_str().unwrap().to_owned();
    let render = |arguments: &[&str]| sparkpath(&[&["render"], arguments].concat());
    for (output, named) in [
        (
            render(&[&cube, "--png", &png, "--view", "sideways"]),
            "front, back, left, right, top, bottom, isometric, channel",
        ),
        (render(&[&cube, "--png", &png, "--view", "channel"]), ".sparkpath"),
        (render(&[&cube, "--png", &png, "--size", "0x5"]), "1400x900"),
        (render(&[&cube, "--png", &png, "--size", "8192x8192"]), "million"),
        (render(&[&cube, "--png", &png, "--theme", "pink"]), "dark or light"),
        (render(&[&cube, "--png", &png, "--node", "3"]), ".sparkpath"),
        (render(&[&cube, "--png", &png, "--swept"]), ".sparkpath"),
        (render(&[&cube, "--png", &png, "--electrode", "2"]), ".sparkpath"),
        (render(&[&cube, "--png", &png, "--electrode", "0"]), "1.."),
        (render(&[&cube, "--png", &nowhere]), "absent"),
        (render(&[&cube, "--png", "picture.jpg"]), ".png"),
        (render(&[&cube, "--png", folder.path().to_str().unwrap()]), "folder"),
        (render(&[&cube, &project, "--png", &png]), "alone"),
        (render(&[&project, "--png", &png]), "a.sparkpath: line 1: "),
        (render(&[&cube, "--png", &png, "--set", "electrode.parts=2"]), ".sparkpath"),
        (render(&["absent.stl", "--png", &png]), "absent.stl"),
        (render(&["--png", &png]), "PROJECT|MESH"),
        (render(&[&cube]), "--png"),
    ] {
        let message = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{message}");
        let errors: Vec<&str> = message.lines().filter(|l| !l.ends_with(" ...")).collect();
        assert_eq!(errors.len(), 1, "{message}");
        assert!(errors[0].contains(named) && errors[0].starts_with("error: "), "{message}");
    }
    assert!(!Path::new(&png).exists());
}

/// The bytes that RFC 4648 base 64 stands for.
fn decoded(base64: &str) -> Vec<u8> {
    let digit = |c: u8| match c {
        b'A'..=b'Z' => c - b'A',
        b'a'..=b'z' => c - b'a' + 26,
        b'0'..=b'9' => c - b'0' + 52,
        b'+' => 62,
        b'/' => 63,
        other => panic!("{other} is no digit"),
    };
    let digits: Vec<u8> = base64.trim_end_matches('=').bytes().map(digit).collect();
    let group = |four: &[u8]| {
        let bits = (0..4).fold(0u32, |bits, i| bits << 6 | u32::from(four.get(i).copied().unwrap_or(0)));
        bits.to_be_bytes()[1..four.len()].to_vec()
    };
    digits.chunks(4).flat_map(group).collect()
}

#[test]
fn the_report_shows_the_very_pictures_that_lie_beside_it() {
    let html = std::fs::read_to_string(path("out/report.html")).unwrap();
    let sources = html.split("<img ").skip(1);
    let shown: Vec<Vec<u8>> = sources
        .map(|tag| decoded(tag.split_once("src=\"data:image/png;base64,").unwrap().1.split_once('"').unwrap().0))
        .collect();
    let names = ["view_1_whole", "view_2_leftover", "electrode_1_final", "electrode_1_sweep", "electrode_1_closest"];
    let files = names.map(|name| std::fs::read(path(&format!("out/{name}.png"))).unwrap());
    assert!(shown == files, "{} pictures are shown", shown.len());
    for (png, name) in files.iter().zip(names).filter(|(_, name)| *name != "view_2_leftover") {
        assert!(copper(&picture(png)) > 500, "the electrode is seen in {name}");
    }
    assert_eq!(html.matches("<figcaption>").count(), 5);
}

#[cfg(target_os = "linux")]
pub fn without_a_graphics_driver_a_plan_is_written_all_the_same(out: &Path) {
    let html = std::fs::read_to_string(out.join("report.html")).unwrap();
    assert!(html.contains("no pictures") && html.contains("driver") && !html.contains("<img"));
    assert!(out.join("path_1.nc").is_file() && !out.join("view_1_whole.png").exists());
    let output = blind(&["render", &path("part.stl"), "--png", "a.png"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(text(&output.stderr).contains("mesa-vulkan-drivers"), "{}", text(&output.stderr));
}

#[test]
fn projects_of_molds_and_flanks_are_drawn() {
    let folder = tempfile::tempdir().unwrap();
    let mesh = folder.path().join("mold.stl");
    import::write_stl(&mesh, &super::uncut::pocket()).unwrap();
    let mold = "kind = \"mold\"\nmesh = \"mold.stl\"\nunits = \"mm\"\n[[library.cutter]]\ndiameter_mm = 2.0\n";
    let flank = "kind = \"flank\"\n[plan]\ngrid = [30, 12]\nrounds = 1\n";
    for (name, text) in [("mold.sparkpath", mold), ("flank.sparkpath", flank), ("other.sparkpath", "kind = \"lathe\"")]
    {
        std::fs::write(folder.path().join(name), text).unwrap();
    }
    let run = |name: &str, more: &[&str]| {
        let [project, png] = [folder.path().join(name), folder.path().join("a.png")];
        let _ = std::fs::remove_file(&png);
        let paths = [project.to_str().unwrap(), "--png", png.to_str().unwrap(), "--size", "400x300"];
        let output = sparkpath(&[&["render"], &paths[..], more].concat());
        (output.status.code(), text(&output.stderr), std::fs::read(&png).ok())
    };
    let mut pictures = Vec::new();
    for (name, more) in [
        ("mold.sparkpath", &[][..]),
        ("mold.sparkpath", &["--electrode", "1"]),
        ("flank.sparkpath", &["--theme", "dark"]),
    ] {
        let (code, said, png) = run(name, more);
        assert_eq!(code, Some(0), "{name} {more:?}: {said}");
        let drawn = picture(&png.unwrap());
        let corner = *drawn.get_pixel(0, 0);
        assert!(drawn.pixels().filter(|p| **p != corner).count() > 5_000, "{name} {more:?}: nothing is drawn");
        pictures.push(drawn);
    }
    assert!(pictures[0] != pictures[1]);
    for (name, more, words) in [
        ("mold.sparkpath", &["--node", "3"][..], "--node: only the project of a blisk has nodes"),
        ("mold.sparkpath", &["--electrode", "7"], "there are pictures of electrodes 1 to 1"),
        ("flank.sparkpath", &["--electrode", "1"], "the project of a flank has none"),
        ("flank.sparkpath", &["--view", "channel"], "only the project of a blisk has channels"),
    ] {
        let (code, said, png) = run(name, more);
        assert!(code == Some(2) && said.contains(words) && png.is_none(), "{name} {more:?}: {said}");
    }
    assert_eq!(run("other.sparkpath", &[]).0, Some(2));
}
