//! Points as lines of numbers: XYZ and CSV.

use glam::DVec3;
use import::excerpt;

use super::Source;
use crate::MeasuredError;

/// What separates the columns of a line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Separator {
    Semicolon,
    Tab,
    Comma,
    Space,
}

impl Separator {
    fn of(line: &[u8]) -> Self {
        let has = |byte: u8| line.contains(&byte);
        match () {
            () if has(b';') => Self::Semicolon,
            () if has(b'\t') => Self::Tab,
            () if has(b',') => Self::Comma,
            () => Self::Space,
        }
    }

    /// Whether a comma within a column is a decimal mark.
    fn has_decimal_commas(self) -> bool {
        matches!(self, Self::Semicolon | Self::Tab)
    }

    fn columns<'a>(self, line: &'a [u8]) -> Box<dyn Iterator<Item = &'a [u8]> + 'a> {
        let at = |byte: u8| line.split(move |b| *b == byte).map(<[u8]>::trim_ascii);
        match self {
            Self::Semicolon => Box::new(at(b';')),
            Self::Tab => Box::new(at(b'\t')),
            Self::Comma => Box::new(at(b',')),
            Self::Space => Box::new(line.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty())),
        }
    }

    fn number(self, column: &[u8]) -> Option<f64> {
        let text = std::str::from_utf8(unquoted(column)).ok()?;
        if self.has_decimal_commas() && text.contains(',') {
            // A second mark would be one of thousands, and the number not certain.
            let is_certain = text.matches(',').count() == 1 && !text.contains('.');
            return is_certain.then(|| text.replace(',', ".").parse().ok()).flatten();
        }
        text.parse().ok()
    }
}

fn unquoted(column: &[u8]) -> &[u8] {
    column.strip_prefix(b"\"").and_then(|rest| rest.strip_suffix(b"\"")).unwrap_or(column).trim_ascii()
}

/// Whether the beginning of a file looks like text.
pub(super) fn is_like(head: &[u8]) -> bool {
    let is_text = |b: &u8| *b >= b' ' || b.is_ascii_whitespace();
    !head.trim_ascii().is_empty() && head.iter().all(is_text)
}

/// Lines with their numbers, ended by `\n`, `\r\n` or `\r`.
struct Lines<'a> {
    rest: &'a [u8],
    number: usize,
}

impl<'a> Iterator for Lines<'a> {
    type Item = (usize, &'a [u8]);

    fn next(&mut self) -> Option<Self::Item> {
        if self.rest.is_empty() {
            return None;
        }
        let end = self.rest.iter().position(|b| matches!(b, b'\n' | b'\r')).unwrap_or(self.rest.len());
        let (line, after) = self.rest.split_at(end);
        self.rest = after.strip_prefix(b"\r\n").or(after.get(1..)).unwrap_or_default();
        self.number += 1;
        Some((self.number, line))
    }
}

fn is_comment(line: &[u8]) -> bool {
    line.is_empty() || matches!(line, [b'#' | b'%', ..] | [b'/', b'/', ..])
}

const NUMBERS: &str = "a line must have x, y and z as numbers in mm: correct the line or export the scan again";

/// Reads all points.
pub(super) fn read(source: &Source) -> Result<Vec<DVec3>, MeasuredError> {
    let text = source.bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(source.bytes);
    let mut points: Vec<DVec3> = Vec::new();
    let mut columns = None;
    let mut separator = None;
    let lines = Lines { rest: text, number: 0 };
    let mut left = text.len();
    for (number, line) in lines {
        left = left.saturating_sub(line.len() + 1);
        source.tick(number, 1.0 - left as f64 / text.len().max(1) as f64)?;
        // A tab at the beginning separates columns, of which the first is empty.
        let line = line.trim_ascii_end();
        let line = &line[line.iter().take_while(|b| **b == b' ').count()..];
        if is_comment(line) {
            continue;
        }
        if columns.is_none() && points.is_empty() {
            match first_line(source, number, line)? {
                First::Point => {}
                First::Header(named) => {
                    columns = Some(named);
                    continue;
                }
            }
        }
        let separator = *separator.get_or_insert_with(|| Separator::of(line));
        let p = point(line, separator, columns.unwrap_or([0, 1, 2]))
            .map_err(|problem| source.malformed(format!("line {number}"), problem, NUMBERS))?;
        source.check_count(points.len() as u64 + 1)?;
        points.push(source.believed(p, || format!("line {number}"))?);
    }
    Ok(points)
}

/// The point of a line.
fn point(line: &[u8], separator: Separator, columns: [usize; 3]) -> Result<DVec3, String> {
    let mut p = [None; 3];
    let last = columns.iter().copied().max().unwrap_or(0);
    let mut found = 0;
    for (i, column) in separator.columns(line).take(last + 1).enumerate() {
        found = i + 1;
        for (axis, _) in columns.iter().enumerate().filter(|(_, wanted)| **wanted == i) {
            let number = separator.number(column);
            p[axis] = Some(number.ok_or_else(|| format!("column {} is {}, not a number", i + 1, excerpt(column)))?);
        }
    }
    match p {
        [Some(x), Some(y), Some(z)] => Ok(DVec3::new(x, y, z)),
        _ => Err(format!("{found} columns found where {} are needed", last + 1)),
    }
}

/// What the first line is that is no comment.
enum First {
    Point,
    /// A header; the columns of x, y and z.
    Header([usize; 3]),
}

fn first_line(source: &Source, number: usize, line: &[u8]) -> Result<First, MeasuredError> {
    let separator = Separator::of(line);
    let columns: Vec<&[u8]> = separator.columns(line).collect();
    let is_number = |column: &&[u8]| separator.number(column).is_some();
    // A number alone is that of the points, as PTS files begin.
    if let [count] = columns.as_slice()
        && is_number(count)
    {
        return Ok(First::Header([0, 1, 2]));
    }
    if columns.iter().take(3).any(is_number) {
        return Ok(First::Point);
    }
    let refuse = |problem: String, remedy| Err(source.malformed(format!("line {number}"), problem, remedy));
    let named: Vec<(usize, &'static str, String)> = columns
        .iter()
        .enumerate()
        .filter_map(|(i, column)| axis_of(column).map(|(axis, unit)| (i, axis, unit)))
        .collect();
    if let Some((i, _, unit)) = named.iter().find(|(_, _, unit)| FOREIGN_UNITS.contains(&unit.as_str())) {
        let problem = format!("column {} is in {unit}", i + 1);
        return refuse(problem, "the points must be in mm: export the scan again in mm");
    }
    let of = |wanted: &str| named.iter().filter(|(_, axis, _)| *axis == wanted).map(|(i, ..)| *i).collect::<Vec<_>>();
    match (of("x").as_slice(), of("y").as_slice(), of("z").as_slice()) {
        (&[x], &[y], &[z]) => Ok(First::Header([x, y, z])),
        ([], [], []) if columns.len() == 3 => Ok(First::Header([0, 1, 2])),
        _ => refuse(
            "the header does not name one column each x, y and z".to_owned(),
            "name these columns x, y and z, or begin the line with #",
        ),
    }
}

/// Units in which points are not accepted.
const FOREIGN_UNITS: [&str; 7] = ["m", "cm", "um", "\u{b5}m", "in", "inch", "inches"];

/// Axis and unit of a column's name: `x`, `X [mm]`, `x_mm`, `Y(in)`.
fn axis_of(column: &[u8]) -> Option<(&'static str, String)> {
    let name = String::from_utf8_lossy(unquoted(column)).to_lowercase();
    let mut words = name.split(|c: char| !c.is_alphanumeric()).filter(|word| !word.is_empty());
    let first = words.next()?;
    let axis = ["x", "y", "z"].into_iter().find(|axis| *axis == first)?;
    Some((axis, words.next().unwrap_or_default().to_owned()))
}
