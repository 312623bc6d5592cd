//! Posts: NC dialects as data. A post is a TOML file that describes how a control wants its words written.
//!
//! Built-in posts are compiled in from `assets/posts`; a file of the same name in a user folder takes their place.

use std::path::Path;

use serde::{Deserialize, Serialize};

use feed::pose::Axis;
use feed::quantise::{DEG_DECIMALS, MM_DECIMALS};
use files::{FileError, Invalid, TomlFile, Validate};

/// The posts that come with the program: name and text.
pub const BUILT_IN: &[(&str, &str)] = &[
    ("iso", include_str!("../../../assets/posts/iso.toml")),
    ("beckhoff-edm", include_str!("../../../assets/posts/beckhoff-edm.toml")),
];

/// Extensions of other files that the program reads or writes. A program must not have one of them, to be neither
/// confused with such a file nor written over it.
const OTHER_RESULTS: [&str; 10] = ["csv", "stl", "obj", "png", "json", "html", "toml", "cl", "old", "sparkpath"];

/// Reason why a post cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum PostError {
    /// No post has this name.
    #[error("there is no post {name:?}; built in are {}, and one of your own is given by the path of its .toml file",
            known.join(", "))]
    Unknown {
        /// Name asked for.
        name: String,
        /// Names of the built-in posts.
        known: Vec<&'static str>,
    },
    /// The file of a post cannot be read, is not valid TOML, or holds a value out of range.
    #[error(transparent)]
    File(#[from] FileError),
}

/// Files of posts.
const POST: TomlFile<Post> = TomlFile::new("post");

/// Meaning of the number in the F word.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum FeedMode {
    /// mm per minute, degrees per minute in blocks where only rotary axes move (usually G94).
    PerMinute,
    /// The inverse of the minutes that the block takes (usually G93).
    InverseTime,
    /// The seconds that the block takes.
    Seconds,
}

/// The F word.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FeedWords {
    /// Meaning of F.
    pub mode: FeedMode,
    /// The word that switches this mode on, e.g. `G94`.
    pub word: String,
    /// The word for feed per minute, used to approach the first position: the start of that motion is unknown, so its
    /// time cannot be given.
    pub approach_word: String,
    /// Decimals of the F word.
    pub decimals: usize,
}

/// Marks of a comment.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CommentStyle {
    /// Start of a comment.
    pub open: String,
    /// End of a comment; empty when the end of the line ends it.
    pub close: String,
}

/// Decimals of coordinates.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Decimals {
    /// Decimals of lengths (mm).
    pub mm: usize,
    /// Decimals of angles (degrees).
    pub deg: usize,
}

/// Numbering of blocks: `N10`, `N20`, ...
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BlockNumbers {
    /// Number of the first block.
    pub first: u32,
    /// Step from one block to the next.
    pub step: u32,
    /// Greatest number; counting then starts again at `first`.
    pub last: u32,
}

/// An axis word.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AxisWord {
    /// The axis of the pose.
    pub axis: Axis,
    /// Address on the control, e.g. `X`.
    pub word: String,
    /// Whether the machine counts this axis in the opposite sense.
    #[serde(default)]
    pub reversed: bool,
}

/// Words of a control that follows the tool's tip. The number of the length offset follows as `H1`.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TipWords {
    /// The word after which X Y Z are the tip and the rotary axes are given, e.g. `G43.4`; none if the control has
    /// none.
    #[serde(default)]
    pub angles: Option<String>,
    /// The word after which X Y Z are the tip and I J K the tool's direction, e.g. `G43.5`; none if it has none.
    #[serde(default)]
    pub vector: Option<String>,
    /// The word that ends the mode, e.g. `G49`.
    pub off: String,
}

/// Description of the programs of a control.
///
/// Lines of `program_start`, `safe_start`, `burn`, `safe_end`, `program_end` and `dwell` may hold the
/// placeholders `{program}` (name of the program) and `{seconds}` (dwell).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Post {
    /// Purpose of the post, in a few words.
    pub title: String,
    /// File name extension without the dot.
    pub extension: String,
    /// Longest line that the control accepts, without the line end (characters).
    pub max_line_length: usize,
    /// Whether lines end with CR LF instead of LF.
    pub crlf: bool,
    /// First lines, written as they are.
    pub program_start: Vec<String>,
    /// The block that selects mm and absolute positions.
    pub modes: String,
    /// The block that makes the control pass exactly through every programmed point, without rounding corners.
    pub exact_path: String,
    /// Blocks before the first motion, with the electrode clear of the blisk.
    pub safe_start: Vec<String>,
    /// Blocks in the final pose, for the burn.
    pub burn: Vec<String>,
    /// Blocks before the feed that set the generator's jumps, with `{jump_mm}` for the greatest length back along the path that
    /// the certificate covers (mm); none if the control has none.
    #[serde(default)]
    pub jump: Vec<String>,
    /// The dwell block, written after `burn` when a dwell is asked for.
    pub dwell: String,
    /// Blocks after the retraction.
    pub safe_end: Vec<String>,
    /// Last lines, written as they are.
    pub program_end: Vec<String>,
    /// The word of linear motion, e.g. `G01`.
    pub linear: String,
    /// The F word.
    pub feed: FeedWords,
    /// Marks of comments.
    pub comment: CommentStyle,
    /// Decimals of coordinates.
    pub decimals: Decimals,
    /// Numbering of blocks; none if blocks have no numbers.
    #[serde(default)]
    pub block_numbers: Option<BlockNumbers>,
    /// Words for following the tool's tip; none if the control cannot do that.
    #[serde(default)]
    pub tip_control: Option<TipWords>,
    /// Axis words in the order of writing.
    pub axes: Vec<AxisWord>,
}

impl Post {
    /// The built-in post of this name, or the post in this file if the name ends in `.toml`.
    ///
    /// # Errors
    /// [`PostError`] if there is no such post, or its file is wrong.
    pub fn named(name: &str) -> Result<Self, PostError> {
        if !name.ends_with(".toml") {
            return Self::load(name, None);
        }
        Ok(POST.read(Path::new(name))?)
    }

    /// The post called `name`: `NAME.toml` in `user_folder` if it is there, else the built-in one.
    ///
    /// # Errors
    /// [`PostError`] when there is no such post or its file is not one.
    pub fn load(name: &str, user_folder: Option<&Path>) -> Result<Self, PostError> {
        // A name is a file name here, never a way out of the folder.
        let plain = !name.is_empty() && name.chars().all(|c| c.is_ascii_alphanumeric() || "-_".contains(c));
        let unknown =
            || PostError::Unknown { name: name.to_owned(), known: BUILT_IN.iter().map(|(n, _)| *n).collect() };
        if !plain {
            return Err(unknown());
        }
        let own = user_folder.map(|folder| POST.read_if_there(&folder.join(format!("{name}.toml")))).transpose()?;
        if let Some(post) = own.flatten() {
            return Ok(post);
        }
        let (_, text) = BUILT_IN.iter().find(|(n, _)| *n == name).ok_or_else(unknown)?;
        Self::from_toml(text, name)
    }

    /// Reads a post. `origin` (file or name) is named in errors.
    ///
    /// # Errors
    /// [`PostError`] naming the key.
    pub fn from_toml(text: &str, origin: &str) -> Result<Self, PostError> {
        Ok(POST.parse(text, Path::new(origin))?)
    }
}

impl Validate for Post {
    fn validate(&self) -> Result<(), Invalid> {
        let bad = |key: &str, value: String, remedy: &str| Err(Invalid::new(key, value, remedy));
        for (key, found, least) in
            [("decimals.mm", self.decimals.mm, MM_DECIMALS), ("decimals.deg", self.decimals.deg, DEG_DECIMALS)]
        {
            if found < least {
                let remedy = format!("at least {least} are needed, or the program would leave the verified path");
                return bad(key, found.to_string(), &remedy);
            }
            if found > 12 {
                return bad(key, found.to_string(), "at most 12 make sense");
            }
        }
        if self.feed.decimals > 12 {
            return bad("feed.decimals", self.feed.decimals.to_string(), "at most 12 make sense");
        }
        if !(40..=4096).contains(&self.max_line_length) {
            return bad("max_line_length", self.max_line_length.to_string(), "give 40 to 4096 characters");
        }
        if self.comment.open.is_empty() {
            return bad("comment.open", "empty".to_owned(), "say what starts a comment");
        }
        if self.block_numbers.is_some_and(|n| n.step == 0 || n.last < n.first) {
            return bad("block_numbers", "not rising".to_owned(), "give a step of 1 or more and last >= first");
        }
        if self.extension.is_empty() || !self.extension.chars().all(|c| c.is_ascii_alphanumeric()) {
            return bad("extension", format!("{:?}", self.extension), "give letters and digits only");
        }
        if OTHER_RESULTS.iter().any(|taken| self.extension.eq_ignore_ascii_case(taken)) {
            let remedy = "it is the extension of another file of ours; give the one that the control expects";
            return bad("extension", format!("{:?}", self.extension), remedy);
        }
        self.validate_axes()?;
        self.validate_lines()
    }
}

impl Post {
    fn validate_axes(&self) -> Result<(), Invalid> {
        for (i, a) in self.axes.iter().enumerate() {
            let bad = |value: &str, remedy| Err(Invalid::new(format!("axes[{i}].word"), format!("{value:?}"), remedy));
            if !a.word.chars().next().is_some_and(|c| c.is_ascii_uppercase()) || a.word.len() > 4 || !a.word.is_ascii()
            {
                return bad(&a.word, "an axis word is a capital letter, at most 4 characters long");
            }
            if self.axes[..i].iter().any(|b| b.axis == a.axis || b.word == a.word) {
                return bad(&a.word, "name each axis and each word once");
            }
        }
        Ok(())
    }

    fn validate_lines(&self) -> Result<(), Invalid> {
        let bad = |key: &str, value: &str, remedy| Err(Invalid::new(key, format!("{value:?}"), remedy));
        let blocks = [
            ("program_start", &self.program_start),
            ("safe_start", &self.safe_start),
            ("burn", &self.burn),
            ("safe_end", &self.safe_end),
            ("program_end", &self.program_end),
        ];
        let single = [
            ("modes", &self.modes),
            ("exact_path", &self.exact_path),
            ("dwell", &self.dwell),
            ("linear", &self.linear),
            ("feed.word", &self.feed.word),
            ("feed.approach_word", &self.feed.approach_word),
            ("comment.open", &self.comment.open),
            ("comment.close", &self.comment.close),
        ];
        let tip = self.tip_control.iter().flat_map(|t| {
            let words = [("angles", t.angles.as_ref()), ("vector", t.vector.as_ref()), ("off", Some(&t.off))];
            words.into_iter().filter_map(|(key, word)| Some((format!("tip_control.{key}"), word?)))
        });
        if let Some((key, empty)) = tip.clone().find(|(_, word)| word.trim().is_empty()) {
            return bad(&key, empty, "give the control's word, or leave the key out");
        }
        let lines = blocks
            .into_iter()
            .flat_map(|(key, lines)| lines.iter().enumerate().map(move |(i, line)| (format!("{key}[{i}]"), line)));
        let single = single.into_iter().map(|(key, line)| (key.to_owned(), line));
        let jumps = self.jump.iter().enumerate().map(|(i, line)| (format!("jump[{i}]"), line));
        for (key, line) in lines.chain(single).chain(tip).chain(jumps) {
            if !line.chars().all(|c| c == ' ' || c.is_ascii_graphic()) {
                return bad(&key, line, "use printable ASCII only");
            }
            let rest = line.replace("{program}", "").replace("{seconds}", "");
            let is_jump = key.starts_with("jump[");
            let rest = if is_jump { rest.replace("{jump_mm}", "") } else { rest };
            if rest.contains(['{', '}']) {
                return bad(&key, line, "the placeholders are {program} and {seconds}, and in jump {jump_mm}");
            }
        }
        for (key, line) in [("modes", &self.modes), ("exact_path", &self.exact_path), ("linear", &self.linear)] {
            if line.trim().is_empty() {
                return bad(key, line, "the program is not safe without it");
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn iso_with(from: &str, to: &str) -> Result<Post, PostError> {
        let text = BUILT_IN[0].1;
        assert!(text.contains(from), "{from}");
        Post::from_toml(&text.replacen(from, to, 1), "changed")
    }

    #[test]
    fn every_built_in_post_is_valid_and_reads_back_from_its_own_text() {
        for (name, _) in BUILT_IN {
            let post = Post::load(name, None).unwrap();
            let again = Post::from_toml(&toml::to_string(&post).unwrap(), name).unwrap();
            assert_eq!(post, again);
            assert_eq!(post.axes.len(), 6, "every axis of the pose has a word");
        }
    }

    #[test]
    fn a_post_coarser_than_the_path_is_refused() {
        for (from, to) in [("mm = 5", "mm = 4"), ("deg = 6", "deg = 3")] {
            let error = iso_with(from, to).unwrap_err().to_string();
            assert!(error.contains("decimals.") && error.contains("verified path"), "{error}");
        }
        assert!(iso_with("mm = 5", "mm = 7").is_ok());
    }

    #[test]
    fn a_post_that_is_not_safe_is_refused() {
        assert!(iso_with("exact_path = \"G61\"", "exact_path = \"\"").is_err());
        assert!(iso_with("word = \"Y\"", "word = \"X\"").is_err());
        assert!(iso_with("program_start", "programme_start").is_err());
        assert!(iso_with("{seconds}", "{minutes}").is_err());
        let tip = |words: &str| iso_with("[comment]", &format!("[tip_control]\n{words}\n[comment]"));
        assert!(tip("angles = \"G43.4\"\noff = \"G49\"").is_ok());
        for wrong in ["angles = \"\"\noff = \"G49\"", "angles = \"G43.4\"", "off = \"G49 \u{e4}\""] {
            assert!(tip(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn a_program_may_not_be_called_like_another_result() {
        for taken in ["csv", "CSV", "Stl", "png", "json", "html", "toml", "sparkpath"] {
            let error = iso_with("extension = \"nc\"", &format!("extension = \"{taken}\"")).unwrap_err().to_string();
            assert!(error.contains("extension") && error.contains(taken), "{error}");
        }
        assert!(iso_with("extension = \"nc\"", "extension = \"tap\"").is_ok());
    }

    #[test]
    fn a_user_folder_takes_precedence_and_names_stay_inside_it() {
        let folder = tempfile::tempdir().unwrap();
        let own = BUILT_IN[0].1.replace("mm = 5", "mm = 6");
        std::fs::write(folder.path().join("iso.toml"), own).unwrap();
        assert_eq!(Post::load("iso", Some(folder.path())).unwrap().decimals.mm, 6);
        assert_eq!(Post::load("beckhoff-edm", Some(folder.path())).unwrap().feed.mode, FeedMode::Seconds);
        for name in ["../iso", "", "no-such", "iso.toml"] {
            assert!(matches!(Post::load(name, Some(folder.path())), Err(PostError::Unknown { .. })), "{name}");
        }
    }
}
