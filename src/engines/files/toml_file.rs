//! TOML files of any kind: bounded in size, parsed, validated, written atomically.

use std::cell::OnceCell;
use std::fs::File;
use std::io::Read;
use std::marker::PhantomData;
use std::ops::Range;
use std::path::{Path, PathBuf};

use serde::Serialize;
use serde::de::DeserializeOwned;
use toml::de::{DeArray, DeTable, DeValue};

use crate::fields::steps;
use crate::{FileError, Invalid, Validate, write_bytes};

/// A kind of TOML file whose content is a `T`.
///
/// ```
/// # use files::{Invalid, TomlFile, Validate};
/// #[derive(serde::Serialize, serde::Deserialize)]
/// #[serde(deny_unknown_fields)]
/// struct Holder { height_mm: f64 }
/// impl Validate for Holder {
///     fn validate(&self) -> Result<(), Invalid> {
///         Invalid::unless_within("height_mm", self.height_mm, [0.1, 1000.0], "mm")
///     }
/// }
/// const HOLDERS: TomlFile<Holder> = TomlFile::new("holder");
/// let error = HOLDERS.parse("height_mm = -2.0", "h.toml".as_ref()).err().unwrap();
/// assert_eq!(error.to_string(), "h.toml: line 1: height_mm is -2: must be from 0.1 to 1000 mm");
/// ```
#[derive(Debug)]
pub struct TomlFile<T> {
    what: &'static str,
    largest: u64,
    of: PhantomData<fn() -> T>,
}

impl<T> TomlFile<T> {
    /// A file of a `what`, of at most 1 MiB.
    pub const fn new(what: &'static str) -> Self {
        Self { what, largest: 1 << 20, of: PhantomData }
    }

    /// Sets the greatest size (bytes).
    #[must_use]
    pub const fn at_most(self, bytes: u64) -> Self {
        Self { largest: bytes, ..self }
    }
}

impl<T: Validate + DeserializeOwned> TomlFile<T> {
    /// The content of `file`.
    ///
    /// # Errors
    /// [`FileError`].
    pub fn read(&self, file: &Path) -> Result<T, FileError> {
        self.parse(&self.read_text(file)?, file)
    }

    /// The text of `file`, which is not looked into.
    ///
    /// # Errors
    /// [`FileError`].
    pub fn read_text(&self, file: &Path) -> Result<String, FileError> {
        read_text(file, self.what, self.largest)
    }

    /// The content of `file`; none if the file does not exist, for optional lists of the user.
    ///
    /// # Errors
    /// [`FileError`] if the file exists but cannot be read.
    pub fn read_if_there(&self, file: &Path) -> Result<Option<T>, FileError> {
        match self.read(file) {
            Err(error) if error.is_not_found() => Ok(None),
            other => other.map(Some),
        }
    }

    /// The content of `text`, which errors call `file`.
    ///
    /// # Errors
    /// [`FileError`].
    pub fn parse(&self, text: &str, file: &Path) -> Result<T, FileError> {
        let content: T = toml::from_str(text).map_err(|error| syntax(file, text, &error))?;
        content.validate().map_err(|problem| FileError::placed(file, text, problem))?;
        Ok(content)
    }

    /// Writes `content` atomically.
    ///
    /// # Errors
    /// [`FileError`], also if the content could not be read again; a former file then stays.
    pub fn write(&self, file: &Path, content: &T) -> Result<(), FileError>
    where
        T: Serialize,
    {
        write_bytes(file, self.text(file, content)?.as_bytes())
    }

    /// The text that [`write`](Self::write) writes to `file`.
    ///
    /// # Errors
    /// [`FileError`] if the content could not be read again.
    pub fn text(&self, file: &Path, content: &T) -> Result<String, FileError>
    where
        T: Serialize,
    {
        content.validate().map_err(|problem| FileError::invalid(file, problem))?;
        let text = toml::to_string_pretty(content).map_err(|e| unwritten(file, one_line(&e.to_string())))?;
        fits(file, &text, self.largest)?;
        Ok(text)
    }
}

fn unwritten(file: &Path, problem: String) -> FileError {
    FileError::NotWritten { file: file.to_owned(), problem }
}

/// Writes `text` unless it is longer than such a file may be.
pub(crate) fn write_text(file: &Path, text: &str, largest: u64) -> Result<(), FileError> {
    fits(file, text, largest)?;
    write_bytes(file, text.as_bytes())
}

fn fits(file: &Path, text: &str, largest: u64) -> Result<(), FileError> {
    let size = text.len() as u64;
    if size > largest {
        return Err(unwritten(file, format!("it would have {size} bytes and at most {largest} are read again")));
    }
    Ok(())
}

/// The text in `file`, a file of a `what` with at most `most` bytes. At most so many bytes are read.
///
/// # Errors
/// [`FileError`] if it cannot be read, is larger, or is no UTF-8.
pub fn read_text(file: &Path, what: &str, most: u64) -> Result<String, FileError> {
    let unreadable = |source| FileError::unreadable(file, source);
    let mut bytes = Vec::new();
    File::open(file).map_err(unreadable)?.take(most + 1).read_to_end(&mut bytes).map_err(unreadable)?;
    if bytes.len() as u64 > most {
        return Err(FileError::TooLarge { file: file.to_owned(), what: what.to_owned(), most });
    }
    String::from_utf8(bytes).map_err(|error| {
        let before = &error.as_bytes()[..error.utf8_error().valid_up_to()];
        FileError::Syntax {
            file: file.to_owned(),
            line: Some(before.iter().filter(|byte| **byte == b'\n').count() + 1),
            key: String::new(),
            problem: "this is no text in UTF-8".to_owned(),
            remedy: "save it as UTF-8, or open another file",
        }
    })
}

/// The parser's error in `text`.
pub(crate) fn syntax(file: &Path, text: &str, error: &toml::de::Error) -> FileError {
    let start = error.span().map(|span| span.start);
    let problem = one_line(error.message());
    let remedy = match problem.contains("unknown field") {
        true => "correct its spelling, or remove it",
        false => "correct it",
    };
    let key = start.and_then(|at| key_at(text, at)).unwrap_or_default();
    FileError::Syntax { file: PathBuf::from(file), line: start.map(|at| line_of(text, at)), key, problem, remedy }
}

impl FileError {
    /// The error of a value in `file`, whose text is `text`, with the line of its key.
    pub fn placed(file: &Path, text: &str, source: Invalid) -> Self {
        let line = place_of(text, &source.key).map(|at| line_of(text, at));
        Self::Invalid { file: file.to_owned(), line, source }
    }
}

pub(crate) fn one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

fn line_of(text: &str, at: usize) -> usize {
    text.bytes().take(at).filter(|byte| *byte == b'\n').count() + 1
}

/// Offset of `key` in `text`.
fn place_of(text: &str, key: &str) -> Option<usize> {
    place_in(DeTable::parse(text).ok()?.get_ref(), key)
}

/// Returns a function that tells whether `text` has a key. The text is parsed once, at the first question.
pub(crate) fn keys_in(text: &str) -> impl Fn(&str) -> bool {
    let root = OnceCell::new();
    move |key| {
        root.get_or_init(|| DeTable::parse(text).ok())
            .as_ref()
            .is_some_and(|root| place_in(root.get_ref(), key).is_some())
    }
}

fn place_in(root: &DeTable, key: &str) -> Option<usize> {
    let mut place = None;
    let (mut table, mut list) = (Some(root), None::<&DeArray>);
    for step in steps(key) {
        let (at, next) = match (table, list) {
            (Some(table), _) => {
                let (name, value) = table.iter().find(|(name, _)| name.get_ref() == step)?;
                (name.span().start, value)
            }
            (None, Some(list)) => {
                let value = list.get(step.parse::<usize>().ok()?)?;
                (value.span().start, value)
            }
            _ => return None,
        };
        place = Some(at);
        (table, list) = (next.get_ref().as_table(), next.get_ref().as_array());
    }
    place
}

/// The key whose name or value is at `offset` of `text`.
fn key_at(text: &str, offset: usize) -> Option<String> {
    let (root, _) = DeTable::parse_recoverable(text);
    let mut best: Option<(usize, String)> = None;
    keys_at(root.get_ref(), offset, "", &mut best);
    best.map(|(_, key)| key)
}

/// Puts the key with the shortest span that holds `offset` into `best`.
fn keys_at(table: &DeTable, offset: usize, prefix: &str, best: &mut Option<(usize, String)>) {
    for (name, value) in table {
        let key = if prefix.is_empty() { name.get_ref().to_string() } else { format!("{prefix}.{}", name.get_ref()) };
        for span in [name.span(), value.span()] {
            offer(best, span, offset, &key);
        }
        match value.get_ref() {
            DeValue::Table(inner) => keys_at(inner, offset, &key, best),
            DeValue::Array(list) => list_keys_at(list, offset, &key, best),
            _ => {}
        }
    }
}

fn list_keys_at(list: &DeArray, offset: usize, prefix: &str, best: &mut Option<(usize, String)>) {
    for (i, value) in list.iter().enumerate() {
        let key = format!("{prefix}[{i}]");
        offer(best, value.span(), offset, &key);
        match value.get_ref() {
            DeValue::Table(inner) => keys_at(inner, offset, &key, best),
            DeValue::Array(inner) => list_keys_at(inner, offset, &key, best),
            _ => {}
        }
    }
}

fn offer(best: &mut Option<(usize, String)>, span: Range<usize>, offset: usize, key: &str) {
    if span.contains(&offset) && best.as_ref().is_none_or(|(length, _)| span.len() <= *length) {
        *best = Some((span.len(), key.to_owned()));
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use serde::Deserialize;

    use super::*;

    #[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
    #[serde(deny_unknown_fields)]
    struct Library {
        #[serde(default)]
        cutter: Vec<Cutter>,
    }

    #[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
    #[serde(deny_unknown_fields)]
    struct Cutter {
        #[serde(default)]
        name: String,
        diameter_mm: f64,
        reach_mm: Option<f64>,
    }

    impl Validate for Library {
        fn validate(&self) -> Result<(), Invalid> {
            if self.cutter.is_empty() {
                return Err(Invalid::of("cutter", "there is none; give at least one as [[cutter]]"));
            }
            for (i, cutter) in self.cutter.iter().enumerate() {
                Invalid::unless_within("diameter_mm", cutter.diameter_mm, [0.01, 500.0], "mm")
                    .map_err(|e| e.within(&format!("cutter[{i}]")))?;
            }
            Ok(())
        }
    }

    const FILE: TomlFile<Library> = TomlFile::new("library of cutters");

    fn error(text: &str) -> FileError {
        FILE.parse(text, Path::new("mine.toml")).unwrap_err()
    }

    #[test]
    fn every_error_names_file_line_key_and_remedy_in_one_line() {
        let good = "[[cutter]]\ndiameter_mm = 3.0\n";
        for (text, line, key, words) in [
            (format!("{good}radius = 1\n"), Some(3), Some("cutter[0].radius"), "unknown field `radius`"),
            (format!("{good}[[cutter]]\ndiameter_mm = -3.0"), Some(4), Some("cutter[1].diameter_mm"), "0.01 to 500 mm"),
            (format!("{good}[[cutter]]\ndiameter_mm = nan"), Some(4), Some("cutter[1].diameter_mm"), "is NaN"),
            (format!("{good}reach_mm = \"far\""), Some(3), Some("cutter[0].reach_mm"), "expected f64"),
            ("[[cutter]\n".to_owned(), Some(1), None, "correct it"),
            (String::new(), None, Some("cutter"), "give at least one as [[cutter]]"),
        ] {
            let error = error(&text);
            assert_eq!((error.line(), error.key()), (line, key), "{text:?}: {error}");
            let said = error.to_string();
            assert!(said.starts_with("mine.toml: ") && said.contains(words) && !said.contains('\n'), "{said}");
        }
    }

    #[test]
    fn what_cannot_be_read_again_is_not_written_and_takes_nothing_away() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("mine.toml");
        let cutter = Cutter { name: "a \"b\"\n".to_owned(), diameter_mm: 1.0 / 3.0, reach_mm: None };
        let library = Library { cutter: vec![cutter.clone()] };
        FILE.write(&file, &library).unwrap();
        assert!(FILE.write(&file, &Library { cutter: Vec::new() }).is_err());
        let size = std::fs::metadata(&file).unwrap().len();
        let small = TomlFile::<Library>::new("library of cutters").at_most(size);
        assert_eq!(small.read(&file).unwrap(), library);
        let longer = Library { cutter: vec![cutter.clone(), cutter] };
        let said = small.write(&file, &longer).unwrap_err().to_string();
        assert!(said.contains("not written") && said.contains(&format!("at most {size}")), "{said}");
        assert_eq!(FILE.read_if_there(&file).unwrap(), Some(library));
        assert_eq!(FILE.read_if_there(&folder.path().join("none.toml")).unwrap(), None);
        assert!(FILE.read(&folder.path().join("none.toml")).unwrap_err().is_not_found());
    }

    #[test]
    fn hostile_files_are_answered_and_no_more_than_allowed_is_read() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("hostile.toml");
        // A sparse file of a tebibyte would exhaust memory if it were read.
        std::fs::File::create(&file).unwrap().set_len(1 << 40).unwrap();
        let said = FILE.read(&file).unwrap_err().to_string();
        assert!(said.contains("no library of cutters has"), "{said}");
        #[cfg(unix)]
        assert!(matches!(FILE.read(Path::new("/dev/zero")), Err(FileError::TooLarge { .. })));
        std::fs::write(&file, b"a = 1\nb = \"\xff\xfe\"\n").unwrap();
        let no_text = FILE.read(&file).unwrap_err();
        assert!(no_text.line() == Some(2) && no_text.to_string().contains("UTF-8"), "{no_text}");
        assert!(matches!(FILE.read(folder.path()), Err(FileError::Unreadable { .. })), "a folder");
        let depth = 200_000;
        for text in [
            format!("cutter = {}{}", "[".repeat(depth), "]".repeat(depth)),
            format!("cutter = {}1{}", "{a=".repeat(depth), "}".repeat(depth)),
            format!("{}=1", vec!["a"; depth].join(".")),
            format!("[{}]\nb=1", vec!["a"; depth].join(".")),
            "cutter = \"".to_owned(),
            "\u{0}\u{feff}= =".to_owned(),
            "cutter = 1e400".to_owned(),
        ] {
            assert!(matches!(error(&text), FileError::Syntax { .. }), "{:.40}", text);
        }
    }

    proptest! {
        #[test]
        fn a_library_is_read_as_it_was_written(
            cutters in prop::collection::vec((any::<String>(), 0.01..500.0_f64, prop::option::of(prop::num::f64::NORMAL)), 1..9)
        ) {
            let cutter = |(name, diameter_mm, reach_mm)| Cutter { name, diameter_mm, reach_mm };
            let library = Library { cutter: cutters.into_iter().map(cutter).collect() };
            let text = toml::to_string_pretty(&library).unwrap();
            prop_assert_eq!(FILE.parse(&text, Path::new("a.toml")).unwrap(), library);
        }

        #[test]
        fn any_text_is_read_or_refused_in_one_line(text in "\\PC{0,60}|[\\[\\]{}=a.\"'\\n1]{0,60}") {
            if let Err(error) = FILE.parse(&text, Path::new("a.toml")) {
                prop_assert!(!error.to_string().contains('\n'));
            }
        }
    }
}
