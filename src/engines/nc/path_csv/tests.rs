use super::*;
use crate::fixtures;
use proptest::prelude::*;

fn text() -> String {
    let path = fixtures::path();
    write_path_csv(&path, fixtures::certificate(&path).row_clearance()).unwrap()
}

#[test]
fn a_written_path_reads_back_bit_for_bit() {
    let (path, back) = (fixtures::path(), read_path_csv(&text()).unwrap());
    assert_eq!(back.digest(), path.digest(), "the digest covers every bit");
    assert_eq!(back, path);
}

#[test]
fn the_file_has_the_agreed_shape() {
    let text = text();
    let lines: Vec<&str> = text.lines().collect();
    assert!(lines[0].starts_with("# {\"format\":\"sparkpath-path-1\",\"frame\":{\"origin\":["));
    let keys = ["origin", "x", "y", "z", "reference_point_mm", "spark_gap_mm", "order", "interpolation"];
    let places: Vec<_> = keys.iter().map(|k| lines[0].find(&format!("\"{k}\":")).unwrap()).collect();
    assert!(places.is_sorted());
    assert_eq!(lines[1], "node,s_mm,x_mm,y_mm,z_mm,a_deg,b_deg,c_deg,clearance_mm");
    assert!(lines[2].starts_with("30,60.00000,-60.00000,3.60000,"));
    assert!(lines[lines.len() - 1].starts_with("0,0.00000,0.00000,0.00000,0.00000,0.000000,0.000000,0.000000,"));
    assert_eq!(lines.len(), 2 + 121);
}

#[test]
fn line_ends_of_another_system_and_a_byte_order_mark_do_no_harm() {
    let foreign = format!("\u{feff}{}\r\n", text().replace('\n', "\r\n"));
    assert_eq!(read_path_csv(&foreign).unwrap(), fixtures::path());
}

#[test]
fn a_path_that_was_not_rounded_is_not_written() {
    let mut path = fixtures::path();
    path.rows[7].pose.c += 1e-12;
    let clearance = vec![0.2; path.rows.len()];
    assert_eq!(write_path_csv(&path, &clearance), Err(PathCsvError::NotQuantised { row: 7 }));
    path.rows[7].pose.c = f64::NAN;
    assert_eq!(write_path_csv(&path, &clearance), Err(PathCsvError::NotQuantised { row: 7 }));
}

/// The file with field `column` of line `line` (both from 0) replaced.
fn with_field(line: usize, column: usize, value: &str) -> String {
    let text = text();
    let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
    let mut fields: Vec<&str> = lines[line].split(',').collect();
    fields[column] = value;
    lines[line] = fields.join(",");
    lines.join("\n")
}

#[test]
fn errors_name_line_and_column() {
    for bad in ["NaN", "inf", "1e999", "", "1,5", "0x10", "1.0mm"] {
        let error = read_path_csv(&with_field(10, 4, bad)).unwrap_err().to_string();
        assert!(error.contains("line 11"), "{bad}: {error}");
    }
    let error = read_path_csv(&with_field(10, 7, "NaN")).unwrap_err().to_string();
    assert!(error.contains("line 11") && error.contains("c_deg") && error.contains("NaN"), "{error}");
    let error = read_path_csv(&with_field(12, 0, "-1")).unwrap_err().to_string();
    assert!(error.contains("line 13") && error.contains("node"), "{error}");
    let error = read_path_csv(&with_field(12, 8, "-0.1")).unwrap_err().to_string();
    assert!(error.contains("clearance_mm"), "{error}");
}

#[test]
fn the_last_row_must_be_the_final_pose() {
    for (i, name) in COLUMNS.into_iter().enumerate().take(8) {
        let error = read_path_csv(&with_field(122, i, "1")).unwrap_err();
        assert!(matches!(error, PathCsvError::NotFinal { line: 123, column, .. } if column == name), "{error}");
    }
    let short = text().lines().take(3).collect::<Vec<_>>().join("\n");
    assert_eq!(read_path_csv(&short), Err(PathCsvError::TooShort { found: 1 }));
}

#[test]
fn headers_that_would_change_the_meaning_are_refused() {
    let header = |from: &str, to: &str| {
        let text = text();
        assert!(text.contains(from), "{from}");
        read_path_csv(&text.replacen(from, to, 1)).unwrap_err()
    };
    assert!(matches!(header("sparkpath-path-1", "sparkpath-path-2"), PathCsvError::Kind { key: "format", .. }));
    assert!(matches!(header("\"feed\"", "\"withdraw\""), PathCsvError::Kind { key: "order", .. }));
    assert!(matches!(header("linear", "spline"), PathCsvError::Kind { key: "interpolation", .. }));
    assert!(matches!(header("\"spark_gap_mm\":0.1", "\"spark_gap_mm\":-0.1"), PathCsvError::HeaderValue { .. }));
    assert!(matches!(header("\"spark_gap_mm\"", "\"unit\":\"inch\",\"spark_gap_mm\""), PathCsvError::Header { .. }));
    assert!(matches!(header("# {", "{"), PathCsvError::Header { .. }));
    assert!(matches!(header("a_deg", "a_rad"), PathCsvError::Columns { .. }));
    assert!(matches!(read_path_csv(""), Err(PathCsvError::Header { .. })));
}

#[test]
fn a_frame_that_scales_or_mirrors_is_refused() {
    let mut path = fixtures::path();
    let clearance = vec![0.2; path.rows.len()];
    path.frame.y = -path.frame.y;
    assert!(matches!(write_path_csv(&path, &clearance), Err(PathCsvError::Frame { .. })), "left-handed");
    path.frame.y *= -1.001;
    assert!(matches!(write_path_csv(&path, &clearance), Err(PathCsvError::Frame { .. })), "scaled");
    path.frame.y = DVec3::NAN;
    assert!(matches!(write_path_csv(&path, &clearance), Err(PathCsvError::Frame { .. })), "not a number");
}

proptest! {
    #[test]
    fn no_text_makes_the_reader_fall_over(text in "(# )?[\\[\\]{}\":,.0-9a-z_ \n-]{0,200}") {
        prop_assert!(read_path_csv(&text).is_err(), "no such text is a path");
    }
}
