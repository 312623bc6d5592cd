//! The feed path as a CSV file, format `sparkpath-path-1`.
//!
//! The first line is `# ` and one line of JSON: the workpiece frame W in the coordinates of the loaded mesh (mm),
//! the electrode reference point O in W (mm) and the spark gap (mm). Then a header row, and one row per pose in
//! feed order: lengths in mm, angles in degrees, last row all zeros. Motion between rows is linear in every axis.

use glam::{DMat3, DVec3};
use serde::{Deserialize, Serialize};

use feed::path::{FeedPath, PathRow};
use feed::pose::Pose;
use feed::quantise::{DEG_DECIMALS, MM_DECIMALS, deg_text, first_unquantised_row, floor_mm_text, mm_text};
use geometry::frame::Frame;

/// The format's name, the first key of the header.
pub const FORMAT: &str = "sparkpath-path-1";
/// Format of the file of a copying motion.
pub const COPYING_FORMAT: &str = "sparkpath-copying-1";
/// The columns in order.
pub const COLUMNS: [&str; 9] = ["node", "s_mm", "x_mm", "y_mm", "z_mm", "a_deg", "b_deg", "c_deg", "clearance_mm"];
/// How far the frame's axes may be from orthonormal.
const FRAME_TOLERANCE: f64 = 1e-6;

/// Error of a path file, or of a path that was to become one. Lines count from 1.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum PathCsvError {
    /// The first line is no header.
    #[error("line 1: a path file starts with `# ` and one line of JSON with \"format\":\"{FORMAT}\"; {problem}")]
    Header {
        /// Problem found.
        problem: String,
    },
    /// The header names another kind of file.
    #[error("line 1: {key} is {found}, but must be {expected}; this program reads no other kind of path")]
    Kind {
        /// Key.
        key: &'static str,
        /// Value found.
        found: String,
        /// Expected form.
        expected: &'static str,
    },
    /// The frame of the header is no rotation.
    #[error(
        "line 1: frame is not a rotation: {problem}; x, y and z must be unit vectors, right-handed, at right angles"
    )]
    Frame {
        /// Problem found.
        problem: String,
    },
    /// A value of the header is out of range.
    #[error("line 1: {key} is {value}; {remedy}")]
    HeaderValue {
        /// Key.
        key: &'static str,
        /// Value found.
        value: String,
        /// Range or remedy.
        remedy: &'static str,
    },
    /// The second line does not name the columns.
    #[error("line 2: the columns must be {}, found {found:?}", COLUMNS.join(","))]
    Columns {
        /// Line found.
        found: String,
    },
    /// A row has another number of values.
    #[error("line {line}: {found} values where {} are needed", COLUMNS.len())]
    FieldCount {
        /// Line of the file, from 1.
        line: usize,
        /// Number of values found.
        found: usize,
    },
    /// A value of a row cannot be read.
    #[error("line {line}, column {column}: {text:?} is not {expected}")]
    Value {
        /// Line of the file, from 1.
        line: usize,
        /// Column.
        column: &'static str,
        /// Text found.
        text: String,
        /// Expected form.
        expected: &'static str,
    },
    /// The path has fewer than two rows.
    #[error("the path has {found} rows; at least 2 are needed: one outside and the final pose")]
    TooShort {
        /// Number of rows.
        found: usize,
    },
    /// The last row is not the final pose.
    #[error("line {line}, column {column}: the last row is the final pose and must be 0, found {value}")]
    NotFinal {
        /// Line of the file, from 1.
        line: usize,
        /// Column.
        column: &'static str,
        /// Value found.
        value: f64,
    },
    /// Rows do not run from outside to the final pose.
    #[error(
        "line {line}: rows run from outside to the final pose: s_mm must fall and node must not rise; sort the rows"
    )]
    OutOfOrder {
        /// Line of the file, from 1.
        line: usize,
    },
    /// A row is not rounded to the decimals of the file.
    #[error("row {row} is not rounded to the decimals of the file; round the path before it is verified")]
    NotQuantised {
        /// Row, from 0.
        row: usize,
    },
    /// The number of clearances is not that of the rows.
    #[error("{found} clearances for {rows} rows; verify this path again")]
    Clearances {
        /// Number of clearances.
        found: usize,
        /// Number of rows.
        rows: usize,
    },
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Header {
    format: String,
    frame: Frame,
    reference_point_mm: DVec3,
    spark_gap_mm: f64,
    order: String,
    interpolation: String,
}

/// The text of the file for `path`; `row_clearance` (mm) is the certificate's clearance at every row and is
/// rounded down.
///
/// # Errors
/// [`PathCsvError::NotQuantised`] when a row would not be read back bit for bit, and the reader's own errors for a
/// path that it would refuse.
pub fn write_path_csv(path: &FeedPath, row_clearance: &[f64]) -> Result<String, PathCsvError> {
    let header = header_of(path);
    let text = text_of(&header, path, row_clearance)?;
    check_header(&header)?;
    check_rows(&path.rows)?;
    Ok(text)
}

/// The text of the file for the copying motion `path`, from the final pose back to it: the same header but for the
/// format's name [`COPYING_FORMAT`] and the order, and the same columns; every row has node and `s_mm` 0.
///
/// # Errors
/// [`PathCsvError`] when a row would not be read back bit for bit, or there is not a clearance for every row.
pub fn write_copying_csv(path: &FeedPath, row_clearance: &[f64]) -> Result<String, PathCsvError> {
    let header = Header { format: COPYING_FORMAT.to_owned(), order: "copying".to_owned(), ..header_of(path) };
    text_of(&header, path, row_clearance)
}

fn header_of(path: &FeedPath) -> Header {
    Header {
        format: FORMAT.to_owned(),
        frame: path.frame,
        reference_point_mm: path.reference_point,
        spark_gap_mm: path.spark_gap,
        order: "feed".to_owned(),
        interpolation: "linear".to_owned(),
    }
}

fn text_of(header: &Header, path: &FeedPath, row_clearance: &[f64]) -> Result<String, PathCsvError> {
    if let Some(row) = first_unquantised_row(path) {
        return Err(PathCsvError::NotQuantised { row });
    }
    if row_clearance.len() != path.rows.len() {
        return Err(PathCsvError::Clearances { found: row_clearance.len(), rows: path.rows.len() });
    }
    let json = serde_json::to_string(header).map_err(|e| PathCsvError::Header { problem: e.to_string() })?;
    let mut text = format!("# {json}\n{}\n", COLUMNS.join(","));
    for (row, &clearance) in path.rows.iter().zip(row_clearance) {
        text.push_str(&row_text(row, clearance));
        text.push('\n');
    }
    Ok(text)
}

fn row_text(row: &PathRow, clearance: f64) -> String {
    let (p, mm, deg) = (&row.pose, |v| mm_text(v, MM_DECIMALS), |v| deg_text(v, DEG_DECIMALS));
    let fields = [mm(row.s), mm(p.x), mm(p.y), mm(p.z), deg(p.a), deg(p.b), deg(p.c), floor_mm_text(clearance)];
    format!("{},{}", row.node, fields.join(","))
}

/// Reads a path file, refusing whatever is not exactly the format. The clearance column is checked and dropped:
/// clearances are for a verifier to find, not to believe.
///
/// # Errors
/// [`PathCsvError`] naming line and column.
pub fn read_path_csv(text: &str) -> Result<FeedPath, PathCsvError> {
    let mut lines = text.strip_prefix('\u{feff}').unwrap_or(text).trim_end().lines();
    let header = read_header(lines.next().unwrap_or_default())?;
    let columns = lines.next().unwrap_or_default();
    if !columns.split(',').map(str::trim).eq(COLUMNS) {
        return Err(PathCsvError::Columns { found: columns.chars().take(200).collect() });
    }
    let rows = lines.enumerate().map(|(i, line)| read_row(i + 3, line)).collect::<Result<Vec<_>, _>>()?;
    check_rows(&rows)?;
    Ok(FeedPath {
        frame: header.frame,
        reference_point: header.reference_point_mm,
        spark_gap: header.spark_gap_mm,
        rows,
    })
}

fn read_header(line: &str) -> Result<Header, PathCsvError> {
    let problem = |problem: String| PathCsvError::Header { problem };
    let json = line.strip_prefix('#').ok_or_else(|| problem("there is no `#`".to_owned()))?.trim();
    let value: serde_json::Value = serde_json::from_str(json).map_err(|e| problem(e.to_string()))?;
    // Asked first, so that a file of another version is told so and not that some key is missing.
    if let Some(format) = value.get("format").and_then(|f| f.as_str()).filter(|&f| f != FORMAT) {
        return Err(PathCsvError::Kind { key: "format", found: format.to_owned(), expected: FORMAT });
    }
    let header = Header::deserialize(value).map_err(|e| problem(e.to_string()))?;
    check_header(&header)?;
    Ok(header)
}

fn check_header(header: &Header) -> Result<(), PathCsvError> {
    let kinds = [("order", &header.order, "feed"), ("interpolation", &header.interpolation, "linear")];
    if let Some((key, found, expected)) = kinds.into_iter().find(|(_, found, expected)| found != expected) {
        return Err(PathCsvError::Kind { key, found: found.clone(), expected });
    }
    let Frame { origin, x, y, z } = header.frame;
    let m = DMat3::from_cols(x, y, z);
    let errors = (m.transpose() * m - DMat3::IDENTITY).to_cols_array();
    if !errors.iter().all(|e| e.abs() <= FRAME_TOLERANCE) {
        return Err(PathCsvError::Frame { problem: format!("its axes are {x}, {y}, {z}") });
    }
    if m.determinant() < 0.0 {
        return Err(PathCsvError::Frame { problem: "it is left-handed".to_owned() });
    }
    let bad = |key, value: String, remedy| Err(PathCsvError::HeaderValue { key, value, remedy });
    if !origin.is_finite() {
        return bad("frame.origin", origin.to_string(), "give three finite numbers in mm");
    }
    if !header.reference_point_mm.is_finite() {
        return bad("reference_point_mm", header.reference_point_mm.to_string(), "give three finite numbers in mm");
    }
    if !(header.spark_gap_mm.is_finite() && header.spark_gap_mm >= 0.0) {
        return bad("spark_gap_mm", header.spark_gap_mm.to_string(), "give the spark gap in mm, 0 or more");
    }
    Ok(())
}

fn read_row(line: usize, text: &str) -> Result<PathRow, PathCsvError> {
    let fields: Vec<&str> = text.split(',').map(str::trim).collect();
    if fields.len() != COLUMNS.len() {
        return Err(PathCsvError::FieldCount { line, found: fields.len() });
    }
    let wrong = |i: usize, expected| PathCsvError::Value {
        line,
        column: COLUMNS[i],
        text: fields[i].chars().take(40).collect(),
        expected,
    };
    let number = |i: usize| match fields[i].parse::<f64>() {
        Ok(v) if v.is_finite() => Ok(v + 0.0),
        _ => Err(wrong(i, "a finite number")),
    };
    let node = fields[0].parse().map_err(|_| wrong(0, "a whole number, 0 or more"))?;
    let (s, x, y, z) = (number(1)?, number(2)?, number(3)?, number(4)?);
    let (a, b, c) = (number(5)?.to_radians(), number(6)?.to_radians(), number(7)?.to_radians());
    if number(8)? < 0.0 {
        return Err(wrong(8, "a distance, 0 or more"));
    }
    Ok(PathRow { node, s, pose: Pose { x, y, z, a, b, c } })
}

fn check_rows(rows: &[PathRow]) -> Result<(), PathCsvError> {
    let [_, .., last] = rows else { return Err(PathCsvError::TooShort { found: rows.len() }) };
    let values = [&[last.node as f64, last.s], &last.pose.to_array()[..]].concat();
    match values.iter().zip(COLUMNS).find(|(v, _)| **v != 0.0) {
        Some((&value, column)) => Err(PathCsvError::NotFinal { line: rows.len() + 2, column, value }),
        None => check_order(rows),
    }
}

fn check_order(rows: &[PathRow]) -> Result<(), PathCsvError> {
    let wrong = (1..rows.len()).find(|&i| rows[i].s >= rows[i - 1].s || rows[i].node > rows[i - 1].node);
    // Rows begin on line 3.
    wrong.map_or(Ok(()), |i| Err(PathCsvError::OutOfOrder { line: i + 3 }))
}

#[cfg(test)]
mod tests;
