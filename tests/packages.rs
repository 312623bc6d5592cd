//! Agreement of the lists, texts and files that packages are made of.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

const MIME_TYPE: &str = "application/x-sparkpath";

fn read(file: &str) -> String {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join(file);
    std::fs::read_to_string(&file).unwrap_or_else(|e| panic!("{}: {e}", file.display()))
}

/// The keys of the desktop entry.
fn desktop_entry() -> BTreeMap<String, String> {
    let text = read("assets/desktop/sparkpath.desktop");
    let mut lines = text.lines();
    assert_eq!(lines.next(), Some("[Desktop Entry]"));
    lines.map(|line| line.split_once('=').unwrap()).map(|(key, value)| (key.to_owned(), value.to_owned())).collect()
}

/// Source and destination of each file of both packages, of the second without the first slash.
fn assets() -> [Vec<(String, String)>; 2] {
    let manifest: toml::Table = read("Cargo.toml").parse().unwrap();
    let list = |name: &str| manifest["package"]["metadata"][name]["assets"].as_array().unwrap().clone();
    let word = |value: &toml::Value| value.as_str().unwrap().to_owned();
    let deb = list("deb").iter().map(|file| (word(&file[0]), word(&file[1]))).collect();
    let rpm = list("generate-rpm");
    let below_root = |dest: String| dest.strip_prefix('/').unwrap().to_owned();
    [deb, rpm.iter().map(|file| (word(&file["source"]), below_root(word(&file["dest"])))).collect()]
}

#[test]
fn every_file_of_the_packages_is_there_or_made_by_the_script() {
    let script = read("scripts/package");
    for (source, _) in assets().concat() {
        match source.strip_prefix("target/package/") {
            Some(made) => assert!(script.contains(&format!("$staged/{}", made.trim_end_matches("/*"))), "{source}"),
            None => assert!(Path::new(env!("CARGO_MANIFEST_DIR")).join(&source).is_file(), "{source}"),
        }
    }
}

#[test]
fn the_copyright_of_the_debian_package_has_the_licence_that_the_project_has() {
    let manifest: toml::Table = read("Cargo.toml").parse().unwrap();
    let copyright = read(manifest["package"]["metadata"]["deb"]["license-file"].as_str().unwrap());
    // Without this first line it would be taken for a licence, and get a head that says less.
    assert!(copyright.starts_with("Format: https://www.debian.org/doc/packaging-manuals/copyright-format/1.0/\n"));
    let words = |text: &str| text.split_whitespace().filter(|word| *word != ".").collect::<Vec<_>>().join(" ");
    let licence = read("LICENSE-MIT");
    let (_, text) = licence.split_once("\n\nPermission").unwrap();
    assert!(words(&copyright).contains(&words(text)));
    let holder = licence.lines().find_map(|line| line.strip_prefix("Copyright (c) ")).unwrap();
    assert!(copyright.contains(&format!("Copyright: {holder}")), "{holder}");
}

#[test]
fn both_packages_have_the_same_files() {
    let [deb, rpm] = assets().map(|files| {
        let own = |dest: &str| dest.starts_with("usr/share/doc/") || dest.starts_with("usr/share/licenses/");
        let common = files.into_iter().filter(|(_, dest)| !own(dest));
        common
            .map(|(source, dest)| (source, dest.replace("site-functions", "vendor-completions")))
            .collect::<BTreeSet<_>>()
    });
    assert_eq!(deb, rpm);
    assert!(deb.len() >= 9, "{deb:?}");
}

#[test]
fn the_desktop_entry_opens_the_file_type() {
    let entry = desktop_entry();
    assert_eq!(entry["MimeType"], format!("{MIME_TYPE};"));
    let [deb, _] = assets();
    let installed = |dest: &str| deb.iter().any(|(_, to)| to.starts_with(dest));
    assert_eq!(entry["Exec"], "sparkpath %f");
    assert!(deb.contains(&("target/package/sparkpath".to_owned(), "usr/bin/".to_owned())));
    assert_eq!(entry["Icon"], "sparkpath");
    for folder in ["usr/share/icons/hicolor/scalable/apps/", "usr/share/icons/hicolor/256x256/apps/"] {
        assert!(installed(folder), "{folder}");
    }
    // The window names itself so: a desktop finds icon and name of it in the entry.
    let id = format!(".with_app_id(\"{}\")", entry["StartupWMClass"]);
    assert!(read("src/shell/startup.rs").contains(&id), "{id}");
}

#[test]
fn the_file_type_is_that_of_projects() {
    let text = read("assets/desktop/sparkpath-mime.xml");
    let document = roxmltree::Document::parse(&text).unwrap();
    let types: Vec<_> = document
        .descendants()
        .filter(|node| node.has_tag_name(("http://www.freedesktop.org/standards/shared-mime-info", "mime-type")))
        .collect();
    assert_eq!(types.len(), 1);
    assert_eq!(types[0].attribute("type"), Some(MIME_TYPE));
    let child = |name: &str| types[0].children().find(|node| node.tag_name().name() == name).unwrap();
    assert_eq!(child("glob").attribute("pattern"), Some("*.sparkpath"));
    assert_eq!(child("icon").attribute("name"), Some(desktop_entry()["Icon"].as_str()));
    assert!(Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/demonstration.sparkpath").is_file());
}

/// The icon of the window is what desktops show.
#[test]
fn the_icon_is_square_and_has_its_drawing() {
    let icon = image::open(Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/desktop/sparkpath.png")).unwrap();
    assert_eq!((icon.width(), icon.height()), (256, 256));
    let drawing = read("assets/desktop/sparkpath.svg");
    let document = roxmltree::Document::parse(&drawing).unwrap();
    assert_eq!(document.root_element().attribute("viewBox"), Some("0 0 256 256"));
}
