//! Who may write what a machine runs: every function that hands out NC or CL text takes what was approved.
//!
//! The source is read as text, wherever in it the folder `nc` is. What counts: in that folder every public function that
//! returns text, and anywhere every function of whatever visibility but private that returns a structure of that folder
//! with text in it. Text that is no program is listed with the reason.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// Structures with text that is no program, and what it is.
const NO_PROGRAMS: [(&str, &str); 3] =
    [("BlockFeed", "one F word"), ("Template", "a template"), ("FlankCheck", "what a check found")];
/// Public functions that return text that is no program, and what it is.
const NO_PROGRAM_TEXT: [(&str, &str); 19] = [
    ("Pace::approach", "one F word"),
    ("write_path_csv", "a table of a path, whose file says so if it is not verified"),
    ("write_copying_csv", "a table of a path"),
    ("BlankEntry::text", "a word of a burn sheet"),
    ("Template::name", "a name"),
    ("Template::of", "a burn sheet or a job sheet"),
    ("measuring_csv", "a table of points"),
    ("setup_sheet", "places of datums"),
    ("BurnTable::csv", "a burn sheet"),
    ("BurnTable::json", "a burn sheet"),
    ("JobFile::json", "a table of a job, which names files of certified paths"),
    ("JobFile::xml", "a table of a job"),
    ("JobFile::csv", "a table of a job"),
    ("why_blocked", "why an electrode has no files"),
    ("file_stems", "names of files"),
    ("step_words", "what a STEP file of an electrode holds"),
    ("FlankResult::why_blocked", "checks that fail"),
    ("FlankResult::all_warnings", "warnings"),
    ("MillingSettings::take_machine", "the name of a machine"),
];
/// Functions that every walk has to meet, or else it looks in the wrong place.
const DOORS: [&str; 3] = ["NcProgram::new", "FlankNc::new", "cl_text"];

/// A file of the source without its comments and tests.
struct Source {
    name: String,
    is_of_programs: bool,
    code: String,
}

impl Source {
    fn new(name: &str, is_of_programs: bool, text: &str) -> Self {
        let code = text.lines().map(|line| line.split("//").next().unwrap_or_default());
        let code = code.collect::<Vec<_>>().join("\n");
        let code = code.split("#[cfg(test)]\nmod ").next().unwrap_or_default().to_owned();
        Self { name: name.to_owned(), is_of_programs, code }
    }

    /// Names of the structures with a field of text.
    fn texts(&self) -> BTreeSet<String> {
        let mut found = BTreeSet::new();
        for (at, _) in self.code.match_indices("struct ") {
            let rest = &self.code[at + "struct ".len()..];
            let name: String = rest.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
            let body = rest.find('{').zip(rest.find('}')).filter(|(open, close)| open < close);
            if body.is_some_and(|(open, close)| rest[open..close].contains("text: String")) {
                found.insert(name);
            }
        }
        found
    }

    /// The functions: whether it is public, in which `impl`, name, parameters and what it returns.
    fn functions(&self) -> Vec<Function> {
        let mut found = Vec::new();
        let mut of = String::new();
        let mut is_trait = false;
        let mut at = 0;
        let code = &self.code;
        while at < code.len() {
            let end = code[at..].find('\n').map_or(code.len(), |n| at + n);
            let line = &code[at..end];
            let next = end + 1;
            if ["impl", "trait ", "pub trait ", "pub(crate) trait "].iter().any(|start| line.starts_with(start)) {
                is_trait = line.contains("trait ") || line.contains(" for ");
                let subject = line.split(" for ").last().unwrap_or_default();
                let subject = subject.rsplit("impl ").next().unwrap_or_default().trim_start_matches("pub ");
                let subject = subject
                    .split_once("> ")
                    .map_or(subject, |(before, after)| if before.starts_with("impl<") { after } else { subject });
                of = subject.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
            } else if line == "}" {
                (of, is_trait) = (String::new(), false);
            }
            let words: Vec<&str> = line.split_whitespace().collect();
            if let Some(k) = words.iter().position(|w| *w == "fn") {
                let is_modifier = |w: &&str| w.starts_with("pub") || ["const", "async", "unsafe", "in"].contains(w);
                if words[..k].iter().all(is_modifier) {
                    let visibility = words.first().filter(|w| w.starts_with("pub")).copied().unwrap_or_default();
                    let is_public = is_trait || visibility == "pub" || visibility.starts_with("pub(crate");
                    found.extend(Function::parse(&code[at..], is_public, visibility, &of));
                }
            }
            at = next;
        }
        found
    }
}

#[derive(Debug, Clone, PartialEq)]
struct Function {
    is_public: bool,
    /// Whether it can be called from beyond its module.
    is_seen: bool,
    of: String,
    name: String,
    parameters: String,
    returns: String,
}

impl Function {
    fn parse(text: &str, is_public: bool, visibility: &str, of: &str) -> Option<Self> {
        let rest = &text[text.find("fn ")? + 3..];
        let name: String = rest.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
        let open = rest.find('(')?;
        let mut depth = 0;
        let close = rest[open..].char_indices().find_map(|(i, c)| {
            depth += i32::from(c == '(') - i32::from(c == ')');
            (depth == 0).then_some(open + i)
        })?;
        let until = rest[close..].find(['{', ';']).map_or(rest.len(), |n| close + n);
        let returns = rest[close + 1..until].trim().trim_start_matches("->").trim();
        let returns = returns.split("where").next().unwrap_or_default().replace("Self", of);
        let (of, parameters) = (of.to_owned(), rest[open + 1..close].to_owned());
        Some(Self { is_public, is_seen: is_public || !visibility.is_empty(), of, name, parameters, returns })
    }

    fn full_name(&self) -> String {
        if self.of.is_empty() { self.name.clone() } else { format!("{}::{}", self.of, self.name) }
    }

    /// The words of what it returns, errors that are mere text left out.
    fn words(&self) -> BTreeSet<&str> {
        let returned = self.returns.strip_suffix(", String>").unwrap_or(&self.returns);
        returned.split(|c: char| !(c.is_alphanumeric() || c == '_')).filter(|w| !w.is_empty()).collect()
    }

    fn takes_what_was_approved(&self) -> bool {
        let mut words = self.parameters.split(|c: char| !(c.is_alphanumeric() || c == '_'));
        let is_approved = |word: &str| ["Approved", "ApprovedFlank"].contains(&word);
        let is_method = self.parameters.trim_start().starts_with("&self");
        words.any(is_approved) || (is_method && is_approved(&self.of))
    }
}

/// Functions that hand out programs, and those among them that take nothing that was approved.
fn doors(sources: &[Source]) -> (Vec<String>, Vec<String>) {
    let programs: BTreeSet<String> = sources.iter().filter(|s| s.is_of_programs).flat_map(Source::texts).collect();
    let programs: BTreeSet<&str> =
        programs.iter().map(String::as_str).filter(|t| NO_PROGRAMS.iter().all(|(name, _)| name != t)).collect();
    let (mut all, mut open) = (Vec::new(), Vec::new());
    for source in sources {
        for function in source.functions() {
            let words = function.words();
            let is_text = words.contains("String") || (words.contains("str") && !function.returns.contains("'static"));
            let is_listed = NO_PROGRAM_TEXT.iter().any(|(name, _)| *name == function.full_name());
            let hands_out_text = source.is_of_programs && function.is_public && is_text && !is_listed;
            // Of a program that is there already others may be told.
            let is_of_program =
                function.parameters.trim_start().starts_with("&self") && programs.contains(function.of.as_str());
            let hands_out_program = function.is_seen && words.iter().any(|word| programs.contains(word));
            if (hands_out_text || hands_out_program) && !is_of_program {
                all.push(function.full_name());
                if !function.takes_what_was_approved() {
                    open.push(format!("{} in {}", function.full_name(), source.name));
                }
            }
        }
    }
    (all, open)
}

fn rust_files(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        if path.is_dir() && name != "tests" {
            rust_files(&path, found);
        } else if name.ends_with(".rs") && !name.ends_with("tests.rs") && name != "fixtures.rs" {
            found.push(path);
        }
    }
}

fn product() -> Vec<Source> {
    let mut files = Vec::new();
    rust_files(&Path::new(env!("CARGO_MANIFEST_DIR")).join("src"), &mut files);
    let source = |path: &PathBuf| {
        let name = path.strip_prefix(env!("CARGO_MANIFEST_DIR")).unwrap();
        let is_of_programs = name.components().any(|part| part.as_os_str() == "nc");
        Source::new(&name.display().to_string(), is_of_programs, &std::fs::read_to_string(path).unwrap())
    };
    files.iter().map(source).collect()
}

#[test]
fn every_public_function_that_returns_nc_or_cl_text_takes_what_was_approved() {
    let sources = product();
    let (all, open) = doors(&sources);
    for door in DOORS {
        assert!(all.iter().any(|name| name == door), "{door} was not met: {all:?}");
    }
    assert!(open.is_empty(), "these hand out a program of what nobody approved: {open:?}");
    // An exception for what is no longer there would excuse what comes next by its name.
    let of_programs: Vec<Function> = sources.iter().filter(|s| s.is_of_programs).flat_map(Source::functions).collect();
    for (name, why) in NO_PROGRAM_TEXT {
        assert!(of_programs.iter().any(|f| f.full_name() == name), "{name} ({why}) is gone: take it off the list");
    }
}

#[test]
fn a_new_function_without_an_approval_is_found() {
    let door = "pub struct NcProgram {\n    text: String,\n}\n";
    let found = |is_of_programs: bool, code: &str| {
        let sources = [Source::new("door.rs", true, door), Source::new("new.rs", is_of_programs, code)];
        doors(&sources).1.len()
    };
    for code in [
        "pub fn quick(path: &FeedPath) -> String {\n}\n",
        "pub fn quick(\n    path: &FeedPath,\n    post: &Post,\n) -> Result<String, NcError> {\n}\n",
        "impl NcProgram {\n    pub fn bare(path: &FeedPath) -> Result<Self, NcError> {\n    }\n}\n",
        "impl From<FeedPath> for NcProgram {\n    fn from(path: FeedPath) -> Self {\n    }\n}\n",
        "impl<'a> Text for Job<'a> {\n    fn text_of(&self) -> String {\n    }\n}\n",
        "pub(crate) fn quick(path: &FeedPath) -> Option<NcProgram> {\n}\n",
    ] {
        assert_eq!(found(true, code), 1, "{code}");
    }
    let elsewhere = "pub(super) fn quick(path: &FeedPath) -> (Vec<u8>, Option<NcProgram>) {\n}\n";
    assert_eq!((found(false, elsewhere), found(true, elsewhere)), (1, 1));
    for code in [
        "pub fn good(approved: &Approved, post: &Post) -> Result<NcProgram, NcError> {\n}\n",
        "pub fn good(approved: &ApprovedFlank<'_>) -> String {\n}\n",
        "fn private(path: &FeedPath) -> String {\n}\n",
        "impl NcProgram {\n    pub fn name(&self) -> &str {\n    }\n}\n",
        "#[cfg(test)]\nmod tests {\n    pub fn quick() -> String {\n    }\n}\n",
        "// pub fn quick() -> String {\n",
        "pub fn kind(self) -> &'static str {\n}\n",
    ] {
        assert_eq!(found(true, code), 0, "{code}");
    }
    let named = "pub fn unapproved(not: &NotApproved) -> NcProgram {\n}\n";
    assert_eq!(found(true, named), 1, "only the approval itself counts");
}
