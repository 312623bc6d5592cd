//! Measured sections of a channel's two walls, read from a table.
//!
//! A CSV file with a heading line that names the columns, in any order:
//!
//! | column | meaning |
//! | --- | --- |
//! | `section` | any name; all points with the same name make a section |
//! | `side` | `low` or `high`: the wall on the side of smaller or of greater theta |
//! | `x` | mm along the blisk axis |
//! | `y`, `z` | mm, in the workpiece frame W |
//! | `r`, `theta_deg` | instead of `y` and `z`: mm from the axis, degrees about it from +Z |
//! | `weight` | may be left out: weight of the point in the rational curve through its side, greater than 0 |
//! | `tx`, `ty`, `tz` | may be left out: direction of the curve in W at the first and at the last point of a side, in the order of the points; empty at the others |
//!
//! The points of a side stand in order from edge to edge, in either direction. Empty lines and lines that begin with
//! `#` are passed over.

use std::io::Read;
use std::path::Path;

use glam::DVec3;

use geometry::frame::Cylindrical;
use geometry::nurbs::LineShape;

/// One measured section.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct MeasuredSection {
    /// Name of the section in the file.
    pub name: String,
    /// Points of the low wall in W from the -X edge to the +X edge (mm).
    pub low: Vec<DVec3>,
    /// Points of the high wall.
    pub high: Vec<DVec3>,
    /// Weights and end tangents of the low and the high wall.
    pub shapes: [LineShape; 2],
}

/// Reason why a table of sections cannot be used.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SectionsError {
    /// The table is larger than any measurement.
    #[error("the table is too large: more than {0}")]
    TooLarge(String),
    /// The file cannot be read.
    #[error("cannot be read ({0}); check the path")]
    Unreadable(String),
    /// There is no heading.
    #[error("the table is empty; it needs a heading line such as section,side,x,y,z")]
    Empty,
    /// A heading names a column that is not known.
    #[error("line {line}: unknown column {name:?}; known are section, side, x, y, z, r, theta_deg, weight, tx, ty, tz")]
    UnknownColumn {
        /// Counted from 1.
        line: usize,
        /// Name as written.
        name: String,
    },
    /// A column is missing or there twice.
    #[error("line {line}: the heading must name {wanted} once")]
    Columns {
        /// Counted from 1.
        line: usize,
        /// The column.
        wanted: &'static str,
    },
    /// A row with another number of cells than the heading.
    #[error("line {line}: {found} cells, the heading has {wanted}")]
    Cells {
        /// Counted from 1.
        line: usize,
        /// Cells found.
        found: usize,
        /// Cells of the heading.
        wanted: usize,
    },
    /// A cell that is not what its column holds.
    #[error("line {line}: {column} is {text:?}; expected {expected}")]
    Cell {
        /// Counted from 1.
        line: usize,
        /// The column.
        column: &'static str,
        /// Text as written, shortened.
        text: String,
        /// Expected content.
        expected: &'static str,
    },
    /// A section without enough points on one side.
    #[error("section {name:?} has {found} points on its {side} side; it needs at least 4")]
    TooFew {
        /// The section.
        name: String,
        /// The side.
        side: &'static str,
        /// Points found.
        found: usize,
    },
    /// Two neighbouring points at the same place.
    #[error("line {line}: the point coincides with the one before it on its side")]
    Repeated {
        /// Counted from 1.
        line: usize,
    },
    /// A tangent between the ends.
    #[error(
        "line {line}: the point before it on its side has a tangent; only the first and the last of a side may have one"
    )]
    InnerTangent {
        /// Counted from 1.
        line: usize,
    },
    /// A single section has no height.
    #[error("the table has {0} sections; a wall needs at least 2")]
    TooFewSections(usize),
}

/// Most bytes of a table.
const MOST_BYTES: usize = 64 << 20;
/// Most points of a table.
const MOST_POINTS: usize = 500_000;
/// Most sections.
const MOST_SECTIONS: usize = 1000;
/// Least points of a side.
const LEAST_POINTS: usize = 4;
/// Greatest coordinate (mm).
const FURTHEST: f64 = 1e5;

/// The sections in the file at `path`; see [`read_sections`].
///
/// # Errors
/// [`SectionsError`], also if the file cannot be read or is no text.
pub fn read_sections_file(path: &Path) -> Result<Vec<MeasuredSection>, SectionsError> {
    let unreadable = |e: std::io::Error| SectionsError::Unreadable(e.to_string());
    let file = std::fs::File::open(path).map_err(unreadable)?;
    let mut text = String::new();
    // One byte more than is allowed tells that it is too large, whatever the file system says of its size.
    file.take(MOST_BYTES as u64 + 1).read_to_string(&mut text).map_err(unreadable)?;
    read_sections(&text)
}

/// The sections in the table `text`, from the hub outwards.
///
/// # Errors
/// [`SectionsError`], with the line where there is one.
pub fn read_sections(text: &str) -> Result<Vec<MeasuredSection>, SectionsError> {
    if text.len() > MOST_BYTES {
        return Err(SectionsError::TooLarge(format!("{} MiB", MOST_BYTES >> 20)));
    }
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let mut lines = text.lines().enumerate().map(|(i, line)| (i + 1, line.trim()));
    let mut filled = lines.by_ref().filter(|(_, line)| !line.is_empty() && !line.starts_with('#'));
    let (line, heading) = filled.next().ok_or(SectionsError::Empty)?;
    let columns = Columns::named(line, heading)?;
    let mut sections: Vec<MeasuredSection> = Vec::new();
    for (count, (line, row)) in filled.enumerate() {
        if count == MOST_POINTS {
            return Err(SectionsError::TooLarge(format!("{MOST_POINTS} points")));
        }
        columns.add(line, row, &mut sections)?;
    }
    finished(sections)
}

/// The sections in order, each with enough points that run along +X.
fn finished(mut sections: Vec<MeasuredSection>) -> Result<Vec<MeasuredSection>, SectionsError> {
    if sections.len() < 2 {
        return Err(SectionsError::TooFewSections(sections.len()));
    }
    for MeasuredSection { name, low, high, shapes } in &mut sections {
        for ((side, points), shape) in [("low", low), ("high", high)].into_iter().zip(shapes) {
            if points.len() < LEAST_POINTS {
                return Err(SectionsError::TooFew { name: name.clone(), side, found: points.len() });
            }
            if points[points.len() - 1].x < points[0].x {
                points.reverse();
                shape.weights.reverse();
                shape.ends = [shape.ends[1], shape.ends[0]].map(|end| end.map(|direction| -direction));
            }
        }
    }
    let radius = |s: &MeasuredSection| {
        let points = s.low.iter().chain(&s.high);
        points.map(|p| p.y.hypot(p.z)).sum::<f64>() / (s.low.len() + s.high.len()) as f64
    };
    sections.sort_by(|a, b| radius(a).total_cmp(&radius(b)));
    Ok(sections)
}

/// Where the columns are.
struct Columns {
    count: usize,
    section: usize,
    side: usize,
    x: usize,
    across: Across,
    weight: Option<usize>,
    tangent: Option<[usize; 3]>,
}

enum Across {
    Cartesian { y: usize, z: usize },
    Polar { r: usize, theta: usize },
}

impl Columns {
    fn named(line: usize, heading: &str) -> Result<Self, SectionsError> {
        const SHAPE: [&str; 4] = ["weight", "tx", "ty", "tz"];
        const NAMES: [&str; 7] = ["section", "side", "x", "y", "z", "r", "theta_deg"];
        let names: Vec<String> = heading.split(',').map(|n| n.trim().to_ascii_lowercase()).collect();
        if let Some(name) = names.iter().find(|n| !NAMES.iter().chain(&SHAPE).any(|known| known == n)) {
            return Err(SectionsError::UnknownColumn { line, name: shortened(name) });
        }
        let at = |wanted: &'static str| {
            let mut places = (0..names.len()).filter(|i| names[*i] == wanted);
            match (places.next(), places.next()) {
                (Some(place), None) => Ok(place),
                _ => Err(SectionsError::Columns { line, wanted }),
            }
        };
        let polar = names.iter().any(|n| n == "r" || n == "theta_deg");
        let across = if polar {
            Across::Polar { r: at("r")?, theta: at("theta_deg")? }
        } else {
            Across::Cartesian { y: at("y")?, z: at("z")? }
        };
        // With both kinds of coordinates it would not be known which to believe.
        let has = |name: &&str| names.iter().any(|n| n == name);
        if names.iter().filter(|n| NAMES.contains(&n.as_str())).count() > 5 {
            return Err(SectionsError::Columns { line, wanted: "either y and z or r and theta_deg" });
        }
        let weight = if has(&"weight") { Some(at("weight")?) } else { None };
        let has_tangent = SHAPE[1..].iter().any(has);
        let tangent = if has_tangent { Some([at("tx")?, at("ty")?, at("tz")?]) } else { None };
        let [section, side, x] = [at("section")?, at("side")?, at("x")?];
        Ok(Self { count: names.len(), section, side, x, across, weight, tangent })
    }

    /// Adds the point in `row` to its section.
    fn add(&self, line: usize, row: &str, sections: &mut Vec<MeasuredSection>) -> Result<(), SectionsError> {
        let cells: Vec<&str> = row.split(',').map(str::trim).take(self.count + 1).collect();
        if cells.len() != self.count {
            return Err(SectionsError::Cells { line, found: row.split(',').count(), wanted: self.count });
        }
        let number = |column: &'static str, at: usize| {
            let value = cells[at].parse::<f64>().ok().filter(|v| v.abs() <= FURTHEST);
            let expected = "a number of at most 100000 in size";
            value.ok_or_else(|| SectionsError::Cell { line, column, text: shortened(cells[at]), expected })
        };
        let x = number("x", self.x)?;
        let point = match self.across {
            Across::Cartesian { y, z } => DVec3::new(x, number("y", y)?, number("z", z)?),
            Across::Polar { r: at, theta } => {
                let r = number("r", at)?;
                if r <= 0.0 {
                    let (text, expected) = (shortened(cells[at]), "a radius greater than 0");
                    return Err(SectionsError::Cell { line, column: "r", text, expected });
                }
                Cylindrical { x, r, theta: number("theta_deg", theta)?.to_radians() }.point()
            }
        };
        let wrong = |column, at: usize, expected| {
            Err(SectionsError::Cell { line, column, text: shortened(cells[at]), expected })
        };
        let weight = match self.weight.map(|at| Ok((at, number("weight", at)?))).transpose()? {
            Some((at, weight)) if weight <= 0.0 => return wrong("weight", at, "a weight greater than 0"),
            found => found.map(|(_, weight)| weight),
        };
        let tangent = match self.tangent.filter(|at| at.iter().any(|at| !cells[*at].is_empty())) {
            Some([x, y, z]) => Some((x, DVec3::new(number("tx", x)?, number("ty", y)?, number("tz", z)?))),
            None => None,
        };
        let section = section_named(cells[self.section], sections)?;
        let (points, shape) = match cells[self.side].to_ascii_lowercase().as_str() {
            "low" => (&mut section.low, &mut section.shapes[0]),
            "high" => (&mut section.high, &mut section.shapes[1]),
            _ => {
                let text = shortened(cells[self.side]);
                return Err(SectionsError::Cell { line, column: "side", text, expected: "low or high" });
            }
        };
        if points.last() == Some(&point) {
            return Err(SectionsError::Repeated { line });
        }
        if shape.ends[1].is_some() {
            return Err(SectionsError::InnerTangent { line });
        }
        if let Some((at, direction)) = tangent {
            if direction.length() < 1e-9 {
                return wrong("tx", at, "a direction that is not zero");
            }
            shape.ends[usize::from(!points.is_empty())] = Some(direction);
        }
        shape.weights.extend(weight);
        points.push(point);
        Ok(())
    }
}

/// The section called `name`, which is added if it is new.
fn section_named<'a>(
    name: &str,
    sections: &'a mut Vec<MeasuredSection>,
) -> Result<&'a mut MeasuredSection, SectionsError> {
    // Rows of a section mostly follow each other.
    let known = sections.iter().rposition(|s| s.name == name);
    let at = known.unwrap_or(sections.len());
    if known.is_none() {
        if sections.len() == MOST_SECTIONS {
            return Err(SectionsError::TooLarge(format!("{MOST_SECTIONS} sections")));
        }
        sections.push(MeasuredSection { name: name.to_owned(), ..MeasuredSection::default() });
    }
    Ok(&mut sections[at])
}

fn shortened(text: &str) -> String {
    text.chars().take(40).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rows(section: &str, r: f64, reversed: bool) -> String {
        let mut rows = String::new();
        for side in ["low", "high"] {
            let theta = if side == "low" { -2.0 } else { 2.0 };
            for i in 0..5 {
                let i = if reversed { 4 - i } else { i };
                rows += &format!("{section},{side},{},{r},{theta}\n", f64::from(i) * 2.0);
            }
        }
        rows
    }

    #[test]
    fn sections_are_ordered_outwards_and_run_along_x() {
        let text = format!(
            "# probe 3\n section , side,x,r,theta_deg\n{}\n{}",
            rows("outer", 120.0, true),
            rows("1", 100.0, false)
        );
        let sections = read_sections(&text).unwrap();
        assert_eq!(sections.iter().map(|s| s.name.as_str()).collect::<Vec<_>>(), ["1", "outer"]);
        for (section, r) in sections.iter().zip([100.0, 120.0]) {
            for (points, theta) in [(&section.low, -2f64), (&section.high, 2.0)] {
                assert_eq!(points.len(), 5);
                for (i, p) in points.iter().enumerate() {
                    let [sin, cos] = [theta.to_radians().sin(), theta.to_radians().cos()];
                    assert!((*p - DVec3::new(2.0 * i as f64, -r * sin, r * cos)).length() < 1e-9);
                }
            }
        }
        let cartesian = "side,z,y,x,section\nlow,100,3,0,a\nlow,100,3,1,a\nlow,100,3,2,a\nlow,100,3,3,a\n";
        let both = format!(
            "{cartesian}{}",
            cartesian.lines().skip(1).map(|l| l.replace("low", "HIGH") + "\n").collect::<String>()
        );
        assert_eq!(read_sections(&both), Err(SectionsError::TooFewSections(1)));
    }

    #[test]
    fn weights_and_end_tangents_belong_to_their_side_and_turn_with_it() {
        let side = |side: &str, reversed: bool| -> String {
            let row = |i: usize| {
                let x = if reversed { 6 - 2 * i } else { 2 * i };
                let tangent = [",1,0.5,0", ",,,", ",,,", ",2,0,0"][i];
                format!("a,{side},{x},1,100,{}{tangent}\n", i + 1)
            };
            (0..4).map(row).collect()
        };
        let head = "section,side,x,y,z,weight,tx,ty,tz\n";
        let text = format!("{head}{}{}", side("low", false), side("high", true));
        let two =
            format!("{text}{}", text.lines().skip(1).map(|l| l.replacen("a,", "b,", 1) + "\n").collect::<String>());
        let [low, high] = &read_sections(&two).unwrap()[0].shapes;
        assert_eq!(low.weights, [1.0, 2.0, 3.0, 4.0]);
        assert_eq!(low.ends, [Some(DVec3::new(1.0, 0.5, 0.0)), Some(DVec3::new(2.0, 0.0, 0.0))]);
        assert_eq!(high.weights, [4.0, 3.0, 2.0, 1.0]);
        assert_eq!(high.ends, [Some(DVec3::new(-2.0, 0.0, 0.0)), Some(DVec3::new(-1.0, -0.5, 0.0))]);
    }

    #[test]
    fn mistakes_are_named_with_their_line() {
        let head = "section,side,x,y,z\n";
        let cases = [
            (String::new(), "heading"),
            ("section,side,x,y\n".into(), "line 1: the heading must name z once"),
            ("section,side,x,x,y,z\n".into(), "either y and z or r and theta_deg"),
            ("section,side,x,y,z,w\n".into(), "line 1: unknown column \"w\""),
            (format!("{head}a,low,1,2\n"), "line 2: 4 cells, the heading has 5"),
            (format!("{head}a,low,1,2,3,4,5\n"), "line 2: 7 cells"),
            (format!("{head}\na,low,1,2,zwei\n"), "line 3: z is \"zwei\""),
            (format!("{head}a,low,1,2,NaN\n"), "line 2: z is \"NaN\""),
            (format!("{head}a,low,1,2,1e300\n"), "line 2: z is"),
            (format!("{head}a,left,1,2,3\n"), "line 2: side is \"left\""),
            ("section,side,x,y,z,tx,ty\n".into(), "line 1: the heading must name tz once"),
            ("section,side,x,y,z,weight\na,low,1,2,3,0\n".into(), "line 2: weight is \"0\""),
            ("section,side,x,y,z,tx,ty,tz\na,low,1,2,3,0,0,0\n".into(), "a direction that is not zero"),
            ("section,side,x,y,z,tx,ty,tz\na,low,1,2,3,1,,\n".into(), "line 2: ty is \"\""),
            (
                "section,side,x,y,z,tx,ty,tz\na,low,1,2,3,,,\na,low,2,2,3,1,0,0\na,low,3,2,3,,,\n".into(),
                "line 4: the point before it",
            ),
            (format!("{head}a,low,1,2,3\na,low,1,2,3\n"), "line 3: the point coincides"),
            (format!("{head}a,low,1,2,3\nb,low,1,2,3\n"), "section \"a\" has 1 points on its low side"),
        ];
        for (text, named) in cases {
            let message = read_sections(&text).unwrap_err().to_string();
            assert!(message.contains(named), "{text:?}: {message}");
        }
        let many: String = (0..=MOST_SECTIONS).map(|i| format!("{i},low,1,2,3\n")).collect();
        assert!(matches!(read_sections(&format!("{head}{many}")), Err(SectionsError::TooLarge(_))));
    }
}
