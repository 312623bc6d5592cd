//! The results of the papers that this program builds on, beside its own: every numbered table and figure on parts that
//! the program makes itself.
//!
//! The papers' parts are not public. Each result says on which part ours is, which dimensions it shares with the paper's,
//! and why the two may differ.

mod centreline_p1;
mod electrodes_p3;
mod feed_path_p0;
mod flank_p4;
mod page;
mod words;

use std::path::Path;
use std::time::Instant;

use serde::Serialize;

use files::report::{PageError, Picture};
use files::{ExportFolder, FileError};
use task::{Cancelled, Task};

/// Version of the keys of `reproduction.json`.
pub const SCHEMA: u32 = 1;

/// A paper.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
pub enum Paper {
    /// Huang and Liu: feed paths for shrouded blisks by a genetic algorithm.
    P0,
    /// Feed paths along the centreline of a channel.
    P1,
    /// Li, Zhou, Liu and Ma: uncut detection and electrode design.
    P3,
    /// Five-axis flank milling by deviation compensation.
    P4,
}

impl Paper {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::P0, Self::P1, Self::P3, Self::P4];

    /// Short name, as the manual uses it.
    pub fn name(self) -> &'static str {
        match self {
            Self::P0 => "P0",
            Self::P1 => "P1",
            Self::P3 => "P3",
            Self::P4 => "P4",
        }
    }

    /// Subject.
    pub fn title(self) -> &'static str {
        match self {
            Self::P0 => "Optimum electrode path for shrouded blisks: genetic search for the feed nodes",
            Self::P1 => "Electrode feed path along the centreline of a blisk channel",
            Self::P3 => "Uncut detection and automatic design of EDM electrodes",
            Self::P4 => "Flank milling: three-point offset and deviation compensation",
        }
    }

    /// Words of its results and what they mean, for readers who do not know this program.
    fn words(self) -> &'static [(&'static str, &'static str)] {
        match self {
            Self::P0 => words::OF_BLISKS,
            Self::P1 => words::OF_CENTRELINES,
            Self::P3 => words::OF_MOLDS,
            Self::P4 => words::OF_FLANKS,
        }
    }

    fn results(self, task: &Task) -> Result<Vec<Outcome>, ReproduceError> {
        match self {
            Self::P0 => feed_path_p0::results(task),
            Self::P1 => centreline_p1::results(task),
            Self::P3 => electrodes_p3::results(task),
            Self::P4 => flank_p4::results(task),
        }
    }
}

/// Our result beside the paper's.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// The same within what the parts differ by.
    Same,
    /// Ours is better.
    Better,
    /// The paper's is better.
    Worse,
    /// No comparison is possible.
    #[default]
    NotComparable,
}

impl Verdict {
    /// In words.
    pub fn words(self) -> &'static str {
        match self {
            Self::Same => "same",
            Self::Better => "better",
            Self::Worse => "worse",
            Self::NotComparable => "cannot be compared",
        }
    }
}

/// A table of figures; columns whose title begins with `#` hold numbers.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Table {
    /// Caption.
    pub caption: String,
    /// Titles of the columns.
    pub head: Vec<String>,
    /// Cells, row by row.
    pub rows: Vec<Vec<String>>,
}

impl Table {
    /// A table of these columns.
    fn new(caption: &str, head: &[&str], rows: Vec<Vec<String>>) -> Self {
        Self { caption: caption.to_owned(), head: head.iter().map(|title| (*title).to_owned()).collect(), rows }
    }
}

/// A numbered table or figure of a paper, with ours.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Outcome {
    /// Number in the paper, as in `Figure 5` or `Table 1`.
    pub name: String,
    /// Subject.
    pub title: String,
    /// Part that ours is of, with the dimensions that it shares with the paper's.
    pub part: String,
    /// Our result beside the paper's.
    pub verdict: Verdict,
    /// Reason for the verdict: why they differ, or why they cannot be compared.
    pub why: String,
    /// How to get the same by hand: command, and place in the window.
    pub by_hand: String,
    /// Figures, the paper's beside ours.
    pub tables: Vec<Table>,
    /// Plots as SVG.
    pub plots: Vec<String>,
    /// Pictures.
    pub pictures: Vec<Picture>,
    /// Other files, such as an animation: name and bytes.
    #[serde(skip)]
    pub files: Vec<(String, Vec<u8>)>,
}

/// A paper's results.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Reproduced {
    /// The paper.
    pub paper: Paper,
    /// Tables and figures, in order.
    pub outcomes: Vec<Outcome>,
    /// Duration of the computation (s).
    pub seconds: f64,
}

/// Reason why there is no reproduction.
#[derive(Debug, thiserror::Error)]
pub enum ReproduceError {
    /// A result cannot be computed: name of the result, and the problem in words.
    #[error("{name} of {}: {problem}", paper.name())]
    Result {
        /// The paper.
        paper: Paper,
        /// The table or figure.
        name: &'static str,
        /// The problem, in words.
        problem: String,
    },
    /// A page cannot be made.
    #[error(transparent)]
    Page(#[from] PageError),
    /// The results cannot be written.
    #[error(transparent)]
    Write(#[from] FileError),
    /// Cancelled.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

/// The results of `papers`, computed anew.
///
/// # Errors
/// [`ReproduceError`].
pub fn reproduce(papers: &[Paper], task: &Task) -> Result<Vec<Reproduced>, ReproduceError> {
    let one = |paper: &Paper| {
        task.check()?;
        task.report(paper.name(), 0.0, "");
        let start = Instant::now();
        let outcomes = paper.results(task)?;
        Ok(Reproduced { paper: *paper, outcomes, seconds: start.elapsed().as_secs_f64() })
    };
    papers.iter().map(one).collect()
}

/// Name of the page.
pub const PAGE_FILE: &str = "reproduction.html";

/// Writes `reproduction.html`, `reproduction.json` and the files of the results into `folder`. Returns their names.
///
/// # Errors
/// [`ReproduceError::Page`], [`ReproduceError::Write`].
pub fn write(folder: &Path, results: &[Reproduced]) -> Result<Vec<String>, ReproduceError> {
    let mut files = vec![
        (PAGE_FILE.to_owned(), page::html(results)?.into_bytes()),
        ("reproduction.json".to_owned(), page::json(results).into_bytes()),
    ];
    files.extend(results.iter().flat_map(|of| &of.outcomes).flat_map(|outcome| outcome.files.iter().cloned()));
    let written: Vec<(&str, &[u8])> = files.iter().map(|(name, bytes)| (&name[..], &bytes[..])).collect();
    ExportFolder::write_all(folder, "reproduce", &written)?;
    Ok(files.into_iter().map(|(name, _)| name).collect())
}
