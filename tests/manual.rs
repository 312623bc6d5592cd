//! The manual in `docs/book` and the README say what the program has.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process;

use sparkpath::study::definition::StudyCommand;
use sparkpath::study::evaluate::named_results;
use sparkpath::workspaces::blisk::commands::BliskCommand;
use sparkpath::workspaces::blisk::document::job_file::field_table::FIELDS;
use sparkpath::workspaces::commands::{CommandSet as _, FrameCommand};
use sparkpath::workspaces::flank::commands::FlankCommand;
use sparkpath::workspaces::mold::commands::MoldCommand;

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn read(path: &Path) -> String {
    std::fs::read_to_string(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

fn help(arguments: &[&str]) -> String {
    let output = process::Command::new(env!("CARGO_BIN_EXE_sparkpath")).args(arguments).arg("--help").output().unwrap();
    assert!(output.status.success());
    String::from_utf8(output.stdout).unwrap()
}

/// The first words of the lines below a heading of a help text, up to the next empty line.
fn listed(help: &str, heading: &str) -> Vec<String> {
    let below = help.lines().skip_while(|line| *line != heading).skip(1).take_while(|line| !line.is_empty());
    below.filter_map(|line| line.split_whitespace().next().map(str::to_owned)).collect()
}

/// The long options that a help text describes.
fn options(help: &str) -> BTreeSet<String> {
    let described = help.lines().map(str::trim_start).filter(|line| line.starts_with('-'));
    let words = described.flat_map(|line| line.split([' ', ',']).take(3));
    words.filter(|word| word.starts_with("--")).map(str::to_owned).collect()
}

/// The part of a page below a heading of the second level.
fn section<'a>(page: &'a str, heading: &str) -> &'a str {
    let start = page.find(&format!("\n## {heading}\n")).unwrap_or_else(|| panic!("there is no section {heading}"));
    let below = &page[start + 1..];
    &below[..below[1..].find("\n## ").map_or(below.len(), |end| end + 1)]
}

fn pages() -> Vec<PathBuf> {
    let book = std::fs::read_dir(root().join("docs/book/src")).unwrap().map(|entry| entry.unwrap().path());
    book.filter(|file| file.extension().is_some_and(|e| e == "md")).chain([root().join("README.md")]).collect()
}

/// The targets of the links of a page that are not on the web.
fn links(page: &str) -> Vec<&str> {
    let targets = page.split("](").skip(1).filter_map(|rest| rest.split(')').next());
    targets.filter(|target| !target.starts_with("http")).collect()
}

/// The anchor that a Markdown heading gets.
fn anchor(heading: &str) -> String {
    let letters =
        heading.to_lowercase().chars().filter(|c| c.is_alphanumeric() || "-_ ".contains(*c)).collect::<String>();
    letters.replace(' ', "-")
}

#[test]
fn every_option_of_every_command_is_in_the_manual() {
    let page = read(&root().join("docs/book/src/command-line.md"));
    let commands = listed(&help(&[]), "Commands:");
    assert!(commands.len() > 10, "{commands:?}");
    let everywhere = options(&help(&[]));
    for option in &everywhere {
        assert!(section(&page, "Options of every command").contains(&format!("`{option}")), "{option}");
    }
    for command in commands.iter().filter(|name| *name != "help") {
        // The options of `uncut` hold for `electrodes` too.
        let shared = if command == "electrodes" { section(&page, "uncut") } else { "" };
        let own = section(&page, command);
        for option in options(&help(&[command])).difference(&everywhere) {
            let is_told = [own, shared].iter().any(|text| text.contains(&format!("`{option}")));
            assert!(is_told, "{command} {option}");
        }
    }
}

/// Keys stand in the table of their section, some with others of their kind in one row.
#[test]
fn every_parameter_of_a_project_is_in_the_manual() {
    let page = read(&root().join("docs/book/src/project-file.md"));
    let blisk = section(&page, "Blisk");
    for field in FIELDS.fields() {
        let key = field.key.split('[').next().unwrap();
        let (path, name) = key.rsplit_once('.').unwrap();
        assert!(blisk.contains(&format!("`[{path}]`")) && blisk.contains(&format!("`{name}`")), "{}", field.key);
    }
}

#[test]
fn every_command_of_the_window_is_in_the_manual() {
    let page = read(&root().join("docs/book/src/keys.md"));
    let own = [BliskCommand::all(), MoldCommand::all(), FlankCommand::all()].concat();
    for command in FrameCommand::all().into_iter().chain(own) {
        let name = command.info.name;
        // Views, steps and panels that fold share a line.
        let word = match name {
            _ if name.starts_with("View ") || name.starts_with("Step ") => name.rsplit(' ').next().unwrap(),
            _ if name.contains("fold the panel") => name.rsplit("on the").next().unwrap(),
            _ => name,
        };
        assert!(page.contains(word), "{word}");
    }
}

#[test]
fn every_named_result_of_a_study_is_in_the_manual() {
    let page = read(&root().join("docs/book/src/studies.md"));
    let results = section(&page, "Results");
    for command in [StudyCommand::Plan, StudyCommand::Size, StudyCommand::Uncut, StudyCommand::Electrodes] {
        let row = results.lines().find(|line| line.starts_with(&format!("| `{}` |", command.name()))).unwrap();
        for (name, ..) in named_results(command) {
            assert!(row.contains(&format!("`{name}`")), "{}: {name}", command.name());
        }
    }
}

#[test]
fn every_link_leads_somewhere() {
    for file in pages() {
        let page = read(&file);
        for link in links(&page) {
            let (path, fragment) = link.split_once('#').unwrap_or((link, ""));
            let target = if path.is_empty() { file.clone() } else { file.parent().unwrap().join(path) };
            assert!(target.exists(), "{}: {link}", file.display());
            let is_heading =
                |line: &str| line.starts_with('#') && anchor(line.trim_start_matches('#').trim()) == fragment;
            assert!(fragment.is_empty() || read(&target).lines().any(is_heading), "{}: {link}", file.display());
        }
    }
}

#[test]
fn every_page_is_in_the_summary() {
    let summary = read(&root().join("docs/book/src/SUMMARY.md"));
    let listed: BTreeSet<&str> = links(&summary).into_iter().collect();
    for file in pages().iter().filter(|file| !file.ends_with("README.md")) {
        let name = file.file_name().unwrap().to_str().unwrap();
        assert!(name == "SUMMARY.md" || listed.contains(name), "{name}");
    }
}

#[test]
fn the_readme_stays_short() {
    assert!(read(&root().join("README.md")).lines().count() <= 150);
}
