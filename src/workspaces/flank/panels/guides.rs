//! Two guide curves from files: which of them is the lower one, and where its fellow is.

use std::path::{Path, PathBuf};

use files::patience::{Found, look_at};

/// Endings of names by which the lower and the upper guide of one flank are told.
const ENDINGS: [[&str; 2]; 4] = [["lower", "upper"], ["bottom", "top"], ["low", "up"], ["l", "u"]];
/// Name before such an ending.
const BEFORE: [char; 4] = ['_', '-', ' ', '.'];

/// Whether `path` is named as a file of points.
pub fn is_points_file(path: &Path) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case("csv") || e.eq_ignore_ascii_case("txt"))
}

/// Both guides of a flank, one of which is `file`, if the other one lies beside it under its name: `A_lower.csv` and
/// `A_upper.csv`.
pub fn pair(file: &Path) -> Option<[PathBuf; 2]> {
    let other = |from: usize| other(file, from).filter(|path| matches!(look_at(path), Ok(Found::File)));
    if let Some(upper) = other(0) {
        return Some([file.to_owned(), upper]);
    }
    other(1).map(|lower| [lower, file.to_owned()])
}

/// The name of the other guide of `file`, whose own is told by word `from` of a pair.
fn other(file: &Path, from: usize) -> Option<PathBuf> {
    let (stem, ending) = (file.file_stem()?.to_str()?, file.extension()?.to_str()?);
    ENDINGS.iter().find_map(|words| {
        let (own, word) = (words[from], words[1 - from]);
        let at = stem.len().checked_sub(own.len()).filter(|at| stem.is_char_boundary(*at))?;
        let (start, end) = stem.split_at(at);
        let is_told = end.eq_ignore_ascii_case(own) && (start.is_empty() || start.ends_with(BEFORE));
        // As it is written.
        let is_upper = |c: char| c.is_uppercase();
        let word = match (end.chars().all(is_upper), end.starts_with(is_upper)) {
            (true, _) => word.to_uppercase(),
            (false, true) => word[..1].to_uppercase() + &word[1..],
            _ => word.to_owned(),
        };
        is_told.then(|| file.with_file_name(format!("{start}{word}.{ending}")))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fellows_are_told_by_their_names_and_by_being_there() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        for name in
            ["A_lower.csv", "A_upper.csv", "lower.csv", "upper.csv", "B-L.txt", "B-U.txt", "C_lower.csv", "tail.csv"]
        {
            std::fs::write(path(name), "").unwrap();
        }
        for (lower, upper) in [("A_lower.csv", "A_upper.csv"), ("lower.csv", "upper.csv"), ("B-L.txt", "B-U.txt")] {
            let both = Some([path(lower), path(upper)]);
            assert_eq!((pair(&path(lower)), pair(&path(upper))), (both.clone(), both));
        }
        for alone in ["C_lower.csv", "tail.csv", "points.csv", "", "\u{e4}"] {
            assert_eq!(pair(&path(alone)), None, "{alone}");
        }
    }
}
