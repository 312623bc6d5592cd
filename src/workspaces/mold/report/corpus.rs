//! What cutters leave of many molds, as one table: on a terminal, as CSV, and as a page.

use std::fmt::Write;
use std::path::Path;

use serde::Serialize;

use crate::workspaces::mold::job::uncut::Uncut;
use files::report::{PageError, Template, counted, page, quoted};
use files::{ExportFolder, FileError, Published};
use geometry::mesh::Mesh;

/// Kind of an export of many molds in the manifest of a folder.
pub const CORPUS_EXPORT: &str = "corpus";

/// Figures of a mold.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CorpusFigures {
    /// Number of triangles of the mesh.
    pub triangles: usize,
    /// Number of uncut regions.
    pub regions: usize,
    /// Volume of all regions (mm^3).
    pub volume_mm3: f64,
    /// Area of the faces that look away from the cutters (mm^2).
    pub hidden_area_mm2: f64,
    /// Warnings.
    pub warnings: Vec<String>,
}

impl CorpusFigures {
    /// Figures of what is left of `mesh`.
    pub fn of(mesh: &Mesh, uncut: &Uncut) -> Self {
        let found = uncut.found();
        Self {
            triangles: mesh.triangles.len(),
            regions: found.regions,
            volume_mm3: found.volume_mm3,
            hidden_area_mm2: uncut.undercut().map_or(0.0, |faces| faces.area),
            warnings: uncut.stack.warnings.iter().map(ToString::to_string).collect(),
        }
    }
}

/// A mold of many.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CorpusRow {
    /// Name of its file.
    pub file: String,
    /// Figures of the mold; none where it failed.
    pub figures: Option<CorpusFigures>,
    /// Reason why it failed.
    pub reason: Option<String>,
    /// Time that it took (s).
    pub seconds: f64,
}

impl CorpusRow {
    /// The row of a mold with these figures or this reason for having none.
    pub fn of(file: String, figures: Result<CorpusFigures, String>, seconds: f64) -> Self {
        let (figures, reason) = match figures {
            Ok(figures) => (Some(figures), None),
            Err(reason) => (None, Some(reason)),
        };
        Self { file, figures, reason, seconds }
    }
}

/// What cutters leave of many molds.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Corpus {
    /// Where the molds are.
    pub folder: String,
    /// Number of molds that there are.
    pub molds: usize,
    /// Those that were looked at, in order: fewer than there are if the work was stopped.
    pub rows: Vec<CorpusRow>,
}

impl Corpus {
    /// Number of molds that failed.
    pub fn failed(&self) -> usize {
        self.rows.iter().filter(|row| row.reason.is_some()).count()
    }

    /// Whether all molds ran, and none failed.
    pub fn is_whole(&self) -> bool {
        self.failed() == 0 && self.rows.len() == self.molds
    }

    /// The table in a sentence.
    pub fn sentence(&self) -> String {
        let sum = |of: fn(&CorpusFigures) -> f64| {
            self.rows.iter().filter_map(|row| row.figures.as_ref()).map(of).fold(0.0, |sum, v| sum + v)
        };
        let (regions, volume) = (sum(|f| f.regions as f64) as usize, sum(|f| f.volume_mm3));
        let stopped = match self.molds - self.rows.len().min(self.molds) {
            0 => String::new(),
            rest => format!("; {} not looked at: the work was stopped", counted(rest, "mold")),
        };
        format!(
            "{}, {} failed: {} of {volume:.3} mm3 together, {:.1} s{stopped}.",
            counted(self.rows.len(), "mold"),
            self.failed(),
            counted(regions, "uncut region"),
            self.rows.iter().fold(0.0, |sum, row| sum + row.seconds)
        )
    }

    /// The table in lines for a terminal.
    pub fn text(&self) -> String {
        let wide = self.rows.iter().map(|row| row.file.chars().count()).fold(4, usize::max);
        let mut text = format!(
            "{:<wide$} {:>10} {:>8} {:>12} {:>11} {:>9} {:>8}\n",
            "file", "triangles", "regions", "volume mm3", "hidden mm2", "warnings", "s"
        );
        for row in &self.rows {
            // Writing to a string does not fail.
            let _ = match (&row.figures, &row.reason) {
                (Some(f), _) => writeln!(
                    text,
                    "{:<wide$} {:>10} {:>8} {:>12.4} {:>11.2} {:>9} {:>8.1}",
                    row.file,
                    f.triangles,
                    f.regions,
                    f.volume_mm3,
                    f.hidden_area_mm2,
                    f.warnings.len(),
                    row.seconds
                ),
                (None, reason) => {
                    writeln!(text, "{:<wide$} failed: {}", row.file, reason.as_deref().unwrap_or_default())
                }
            };
        }
        text + &self.sentence() + "\n"
    }

    /// The table as CSV: a row for each mold, warnings with semicolons between.
    pub fn csv(&self) -> String {
        let mut text = "file,triangles,regions,volume_mm3,hidden_area_mm2,warnings,seconds,failed_because\n".to_owned();
        for row in &self.rows {
            let figures = row.figures.as_ref().map_or_else(
                || ",,,,".to_owned(),
                |f| {
                    let warnings = quoted(&f.warnings.join("; "));
                    format!("{},{},{:.6},{:.6},{warnings}", f.triangles, f.regions, f.volume_mm3, f.hidden_area_mm2)
                },
            );
            let reason = quoted(row.reason.as_deref().unwrap_or_default());
            let _ = writeln!(text, "{},{figures},{:.3},{reason}", quoted(&row.file), row.seconds);
        }
        text
    }

    /// The table as one self-contained page.
    ///
    /// # Errors
    /// [`PageError`], which a test of the template keeps from happening.
    pub fn html(&self) -> Result<String, PageError> {
        const TEMPLATE: Template = Template { name: "corpus.html.jinja", text: include_str!("corpus.html.jinja") };
        #[derive(Serialize)]
        struct Page<'a> {
            corpus: &'a Corpus,
            sentence: String,
            is_whole: bool,
            version: &'static str,
        }
        let (sentence, is_whole) = (self.sentence(), self.is_whole());
        page(&TEMPLATE, &Page { corpus: self, sentence, is_whole, version: env!("CARGO_PKG_VERSION") })
    }

    /// Writes `corpus.csv` and `corpus.html` into `folder`, which is made if missing.
    ///
    /// # Errors
    /// [`CorpusExportError`]; then nothing was written.
    pub fn write(&self, folder: &Path) -> Result<Published, CorpusExportError> {
        let (csv, html) = (self.csv(), self.html()?);
        let files: [(&str, &[u8]); 2] = [("corpus.csv", csv.as_bytes()), ("corpus.html", html.as_bytes())];
        Ok(ExportFolder::write_all(folder, CORPUS_EXPORT, &files)?)
    }
}

/// Reason why the table of many molds was not written.
#[derive(Debug, thiserror::Error)]
pub enum CorpusExportError {
    /// The page could not be made.
    #[error(transparent)]
    Page(#[from] PageError),
    /// A file could not be written.
    #[error(transparent)]
    File(#[from] FileError),
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn molds_that_fail_and_those_that_were_not_reached_are_told() {
        let figures = CorpusFigures {
            triangles: 12,
            regions: 4,
            volume_mm3: 2.5,
            hidden_area_mm2: 0.0,
            warnings: vec!["a, b".to_owned(), "c".to_owned()],
        };
        let rows = vec![
            CorpusRow::of("a.stl".to_owned(), Ok(figures), 1.0),
            CorpusRow::of("b,<c>.obj".to_owned(), Err("it is empty".to_owned()), 0.5),
        ];
        let mut corpus = Corpus { folder: "molds".to_owned(), molds: 2, rows };
        assert!(!corpus.is_whole() && corpus.failed() == 1);
        assert_eq!(corpus.sentence(), "2 molds, 1 failed: 4 uncut regions of 2.500 mm3 together, 1.5 s.");
        let csv: Vec<String> = corpus.csv().lines().map(str::to_owned).collect();
        assert_eq!(csv[1], "a.stl,12,4,2.500000,0.000000,\"a, b; c\",1.000,");
        assert_eq!(csv[2], "\"b,<c>.obj\",,,,,,0.500,it is empty");
        let fields = |line: &str| line.matches(',').count();
        assert_eq!(fields(&csv[0]), fields(&csv[2]) - 1, "one comma is in a name");
        assert!(corpus.text().contains("failed: it is empty"));
        let page = corpus.html().unwrap();
        assert!(page.contains("b,&lt;c&gt;.obj") && page.contains("it is empty"), "{page}");
        corpus.rows.truncate(1);
        assert!(!corpus.is_whole() && corpus.sentence().contains("1 mold not looked at"), "{}", corpus.sentence());
    }
}
