//! Set-up sheet: where the axes of a job lie from what a machine can touch, what a ball on the table must read once the table
//! is tilted, and where the electrodes are measured on their holders.

use std::fmt::Write as _;

use glam::{DMat3, DVec2, DVec3};

use super::job_file::JobFile;
use super::measuring_points::MeasuringPoint;

/// Greatest deviation of the job's axes from right angles and unit length.
const SQUARE: f64 = 1e-6;

/// A thing that a machine touches to find the workpiece.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Datum {
    /// Place of a ball's centre, or of a corner, in the coordinates of the workpiece's file (mm).
    pub place: DVec3,
    /// Radius of a ball (mm); none of a corner.
    pub radius: Option<f64>,
}

/// A table that is tilted to check how it stands.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TableCheck {
    /// Y and Z of the axis of A, which is parallel to X, in the axes of the job (mm).
    pub a_axis: DVec2,
    /// The two angles of A as programs have them (rad): right-handed about X, of the electrode against the workpiece.
    pub angles: [f64; 2],
}

/// Settings of a set-up sheet.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct SetUp {
    /// The datums, in their order.
    pub datums: Vec<Datum>,
    /// Step that set-up values are rounded to (mm); none leaves them as they are.
    pub round: Option<f64>,
    /// The table that is checked with the balls.
    pub check: Option<TableCheck>,
}

/// Reason why there is no set-up sheet.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SetUpError {
    /// No datum is given.
    #[error(
        "there is no datum: give the centre and radius of a ball, or a corner, in the coordinates of the workpiece's file"
    )]
    NoDatum,
    /// A check without a ball.
    #[error("a table is checked with a ball, and no ball is given")]
    NoBall,
    /// A number that is none, or out of its range.
    #[error("{what} is {value}, it must be {range}")]
    Range {
        /// The quantity.
        what: &'static str,
        /// Value of the quantity.
        value: f64,
        /// Allowed values.
        range: &'static str,
    },
    /// Axes that are not perpendicular unit vectors.
    #[error(
        "the X and Z axes of workpiece {workpiece} in the job are no perpendicular unit vectors; export the job again"
    )]
    Axes {
        /// Identifier of the workpiece.
        workpiece: String,
    },
}

/// The set-up sheet of a job.
///
/// # Errors
/// Every [`SetUpError`].
pub fn setup_sheet(job: &JobFile, setup: &SetUp) -> Result<String, SetUpError> {
    check(job, setup)?;
    let workpiece = &job.workpiece;
    let to_job = axes(job)?;
    let mut text = format!("SET-UP SHEET  {}\nAxes: {}. mm and degrees.\n", workpiece.name, workpiece.axes);
    let origin = DVec3::from(workpiece.origin_mm);
    let places: Vec<DVec3> = setup.datums.iter().map(|datum| to_job * (datum.place - origin)).collect();
    for (k, (datum, place)) in setup.datums.iter().zip(&places).enumerate() {
        let radius = datum.radius.map(|radius| format!(", radius {radius:.4}")).unwrap_or_default();
        let kind = if datum.radius.is_some() { "ball" } else { "corner" };
        let _ = writeln!(text, "\n{:<28}{:>12}{:>12}{:>12}", format!("Datum {}: {kind}{radius}", k + 1), "X", "Y", "Z");
        line(&mut text, "in the workpiece's file", datum.place);
        line(&mut text, "in the axes of the job", *place);
        if let Some(radius) = datum.radius {
            line(&mut text, "its top along Z", *place + DVec3::Z * radius);
        }
        line(&mut text, "origin of the job from it", -*place);
        if let Some(step) = setup.round {
            let rounded = (*place / step).round() * step;
            line(&mut text, "the same, rounded", -rounded);
            line(&mut text, "which moves the workpiece", rounded - *place);
        }
    }
    if let Some(table) = setup.check {
        check_of_table(&mut text, setup, &places, table);
    }
    for electrode in &job.electrodes {
        let _ =
            writeln!(text, "\n{}  {}: to measure on its holder, in {}", electrode.id, electrode.name, electrode.axes);
        points(&mut text, &electrode.inspection_points);
    }
    Ok(text)
}

/// Balls of the table at both angles.
fn check_of_table(text: &mut String, setup: &SetUp, places: &[DVec3], table: TableCheck) {
    let DVec2 { x: y, y: z } = table.a_axis;
    let _ = writeln!(
        text,
        "\nCheck of the table, which turns against A of the programs about the line parallel to X through Y {y:.4}, Z {z:.4}"
    );
    if setup.round.is_some() {
        text.push_str("Values that are not rounded:\n");
    }
    for (k, (_, place)) in setup.datums.iter().zip(places).enumerate().filter(|(_, (datum, _))| datum.radius.is_some())
    {
        let turned = table.angles.map(|angle| turned_about_a(*place, table.a_axis, angle));
        for (angle, place) in table.angles.iter().zip(turned) {
            line(text, &format!("ball {} at A {:.4}", k + 1, angle.to_degrees()), place);
        }
        line(text, "the second less the first", turned[1] - turned[0]);
    }
}

/// `place` on the table once A has turned by `angle` (rad) from 0 about the line parallel to X through `axis`. A is the turn of
/// the electrode against the workpiece, so that a table turns the other way.
fn turned_about_a(place: DVec3, axis: DVec2, angle: f64) -> DVec3 {
    let on_axis = DVec3::new(0.0, axis.x, axis.y);
    on_axis + DMat3::from_rotation_x(-angle) * (place - on_axis)
}

fn points(text: &mut String, points: &[MeasuringPoint]) {
    if points.is_empty() {
        text.push_str("  no place where a ball has room\n");
        return;
    }
    let heads = ["X", "Y", "Z"].map(|head| format!("{head:>12}")).concat();
    let _ = writeln!(text, "  {:<26}{heads}{:>10}{:>10}{:>10}{:>13}", "surface", "NX", "NY", "NZ", "ball radius");
    for point in points {
        let place = point.point_mm.map(|v| format!("{:>12.4}", shown(v))).concat();
        let normal = point.normal.map(|v| format!("{:>10.4}", shown(v))).concat();
        let _ = writeln!(text, "  {:<26}{place}{normal}{:>13.2}", point.surface, point.ball_radius_mm);
    }
}

/// A line of a place.
fn line(text: &mut String, what: &str, place: DVec3) {
    let [x, y, z] = place.to_array().map(shown);
    let _ = writeln!(text, "  {what:<26}{x:>12.4}{y:>12.4}{z:>12.4}");
}

/// A number to four decimals, never minus zero.
fn shown(value: f64) -> f64 {
    (value * 1e4).round() / 1e4 + 0.0
}

/// Rotation from the coordinates of the workpiece's file to the axes of the job.
fn axes(job: &JobFile) -> Result<DMat3, SetUpError> {
    let [x, z] = [job.workpiece.x_axis, job.workpiece.z_axis].map(DVec3::from);
    let off = [x.length() - 1.0, z.length() - 1.0, x.dot(z)];
    // Not a number is no axis either.
    if off.iter().all(|off| off.abs() <= SQUARE) {
        Ok(DMat3::from_cols(x, z.cross(x), z).transpose())
    } else {
        Err(SetUpError::Axes { workpiece: job.workpiece.id.clone() })
    }
}

fn check(job: &JobFile, setup: &SetUp) -> Result<(), SetUpError> {
    let within = |what, value: f64, range, is_within: bool| {
        if is_within && value.is_finite() { Ok(()) } else { Err(SetUpError::Range { what, value, range }) }
    };
    if setup.datums.is_empty() {
        return Err(SetUpError::NoDatum);
    }
    let of_place = |what, value: f64| within(what, value, "from -1e6 to 1e6 mm", value.abs() <= 1e6);
    job.workpiece.origin_mm.into_iter().try_for_each(|v| of_place("a coordinate of the origin of the job", v))?;
    for datum in &setup.datums {
        datum.place.to_array().into_iter().try_for_each(|v| of_place("a coordinate of a datum", v))?;
        let radius =
            |r: f64| within("the radius of a ball", r, "greater than 0 and at most 1000 mm", r > 0.0 && r <= 1e3);
        datum.radius.map_or(Ok(()), radius)?;
    }
    let step = |s: f64| within("the step of rounding", s, "from 0.0001 to 10 mm", (1e-4..=10.0).contains(&s));
    setup.round.map_or(Ok(()), step)?;
    let Some(table) = setup.check else { return Ok(()) };
    if setup.datums.iter().all(|datum| datum.radius.is_none()) {
        return Err(SetUpError::NoBall);
    }
    table.a_axis.to_array().into_iter().try_for_each(|v| of_place("a coordinate of the axis of A", v))?;
    let angle = |angle: f64| {
        within("an angle of A (degrees)", angle.to_degrees(), "from -360 to 360", angle.abs() <= std::f64::consts::TAU)
    };
    table.angles.into_iter().try_for_each(angle)?;
    let [first, second] = table.angles.map(f64::to_degrees);
    within(
        "the second angle of A",
        second,
        "another place of the table than the first",
        (second - first) % 360.0 != 0.0,
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::template::Templated as _;

    /// An example whose axes are those of its file turned by 90 degrees about Z, with the origin at (10, 0, 5).
    fn job() -> JobFile {
        let mut job = JobFile::examples().remove(0);
        job.workpiece.origin_mm = [10.0, 0.0, 5.0];
        (job.workpiece.x_axis, job.workpiece.z_axis) = ([0.0, 1.0, 0.0], [0.0, 0.0, 1.0]);
        job
    }

    fn ball(place: [f64; 3]) -> Datum {
        Datum { place: place.into(), radius: Some(4.0) }
    }

    /// Numbers of the line that begins with `what`.
    fn numbers(sheet: &str, what: &str) -> Vec<f64> {
        let line =
            sheet.lines().find_map(|line| line.trim_start().strip_prefix(what)).unwrap_or_else(|| panic!("{what}"));
        line.split_whitespace().map(|word| word.parse().unwrap()).collect()
    }

    #[test]
    fn a_datum_is_told_in_the_axes_of_the_job_and_the_origin_from_it() {
        // Y of the job is -X of the file: 10 - 30 = -20.
        let setup = SetUp { datums: vec![ball([30.0, 7.0, 6.0])], ..SetUp::default() };
        let sheet = setup_sheet(&job(), &setup).unwrap();
        assert_eq!(numbers(&sheet, "in the axes of the job"), [7.0, -20.0, 1.0]);
        assert_eq!(numbers(&sheet, "its top along Z"), [7.0, -20.0, 5.0]);
        assert_eq!(numbers(&sheet, "origin of the job from it"), [-7.0, 20.0, -1.0]);
        assert!(!sheet.contains("rounded") && !sheet.contains("Check of the table"));
    }

    #[test]
    fn what_rounding_moves_is_told() {
        let corner = Datum { place: DVec3::new(10.0124, 3.0, 5.0), radius: None };
        let setup = SetUp { datums: vec![corner], round: Some(0.01), check: None };
        let sheet = setup_sheet(&job(), &setup).unwrap();
        assert_eq!(numbers(&sheet, "the same, rounded"), [-3.0, 0.01, 0.0]);
        assert_eq!(numbers(&sheet, "which moves the workpiece"), [0.0, 0.0024, 0.0]);
        assert!(!sheet.contains("its top along Z"), "a corner has no radius");
    }

    /// About the axis through Y 0, Z -10 a quarter turn of A takes the table with (Y, Z) = (-20, 1) to (11, 10).
    #[test]
    fn a_ball_on_a_tilted_table_is_where_the_turn_takes_it() {
        let check = TableCheck { a_axis: DVec2::new(0.0, -10.0), angles: [0.0, 0.25 * std::f64::consts::TAU] };
        let setup = SetUp { datums: vec![ball([30.0, 7.0, 6.0])], round: None, check: Some(check) };
        let sheet = setup_sheet(&job(), &setup).unwrap();
        assert_eq!(numbers(&sheet, "ball 1 at A 0.0000"), [7.0, -20.0, 1.0]);
        assert_eq!(numbers(&sheet, "ball 1 at A 90.0000"), [7.0, 11.0, 10.0]);
        assert_eq!(numbers(&sheet, "the second less the first"), [0.0, 31.0, 9.0]);
    }

    #[test]
    fn every_point_to_measure_is_listed() {
        let job = job();
        let sheet = setup_sheet(&job, &SetUp { datums: vec![ball([0.0; 3])], ..SetUp::default() }).unwrap();
        let points: usize = job.electrodes.iter().map(|e| e.inspection_points.len()).sum();
        assert!(points > 0);
        let listed =
            |line: &&str| line.split_whitespace().rev().map_while(|word| word.parse::<f64>().ok()).count() == 7;
        assert_eq!(sheet.lines().filter(listed).count(), points);
    }

    #[test]
    fn what_cannot_be_set_up_is_refused() {
        let with = |datum: Datum, round, check| setup_sheet(&job(), &SetUp { datums: vec![datum], round, check });
        assert_eq!(setup_sheet(&job(), &SetUp::default()), Err(SetUpError::NoDatum));
        let check = TableCheck { a_axis: DVec2::ZERO, angles: [0.0, f64::NAN] };
        let corner = Datum { place: DVec3::ZERO, radius: None };
        assert_eq!(with(corner, None, Some(check)), Err(SetUpError::NoBall));
        let is_range = |answer: Result<String, SetUpError>| matches!(answer, Err(SetUpError::Range { .. }));
        assert!(is_range(with(ball([0.0; 3]), None, Some(check))));
        let same = TableCheck { angles: [0.0, std::f64::consts::TAU], ..check };
        assert!(is_range(with(ball([0.0; 3]), None, Some(same))), "a check of one place finds nothing");
        assert!(is_range(with(ball([f64::INFINITY, 0.0, 0.0]), None, None)));
        assert!(is_range(with(Datum { radius: Some(0.0), ..corner }, None, None)));
        assert!(is_range(with(corner, Some(-0.01), None)) && is_range(with(corner, Some(1e-310), None)));
        let mut leaning = job();
        leaning.workpiece.z_axis = [0.0, 0.1, 1.0];
        let setup = SetUp { datums: vec![corner], ..SetUp::default() };
        assert!(matches!(setup_sheet(&leaning, &setup), Err(SetUpError::Axes { .. })));
    }
}
