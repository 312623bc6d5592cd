use super::fixtures;
use super::*;

#[test]
fn the_json_has_the_agreed_keys() {
    let json: serde_json::Value = serde_json::from_str(&fixtures::report().json().unwrap()).unwrap();
    for key in
        ["schema", "program_version", "verdict", "inputs", "blisk", "parameters", "symbols", "electrodes", "times"]
    {
        assert!(json.get(key).is_some(), "{key}");
    }
    assert_eq!(json["inputs"][0]["sha256"].as_str().unwrap().len(), 64);
    let one = &json["electrodes"][0];
    assert_eq!(one["extractable"], true);
    assert_eq!(one["verified"], true);
    assert_eq!(one["required_clearance_mm"], 0.1);
    let certificate = fixtures::certificate(&fixtures::path());
    assert_eq!(one["certified_clearance_mm"], certificate.certified());
    assert_eq!(one["least_clearance_mm"], certificate.least().distance);
    assert!((certificate.least().distance - 0.1032).abs() < 1e-4, "{:?}", certificate.least());
    assert_eq!(one["least_clearance_at"]["surface"], "pressure wall");
    assert_eq!(one["nodes"][1]["x_mm"], -2.0, "poses of nodes stand beside s_mm");
    assert_eq!(one["smoothness"][0]["axis"], "X");
    assert!(one["volume_mm3"].is_f64() && one["least_thickness_mm"].is_f64() && one.get("motion").is_none());
    for what in ["path", "blisk", "electrode"] {
        assert_eq!(one["sha256"][what].as_str().map(str::len), Some(64), "{what}");
    }
    let two = &json["electrodes"][1];
    assert_eq!((&two["extractable"], &two["failure"]["node"]), (&false.into(), &14.into()));
    assert!(two["certified_clearance_mm"].is_null());
}

#[test]
fn equal_reports_give_equal_bytes() {
    let report = fixtures::report();
    assert_eq!(report.json().unwrap(), fixtures::report().json().unwrap());
    assert_eq!(report.html().unwrap(), fixtures::report().html().unwrap());
}

#[test]
fn the_page_needs_nothing_from_outside_and_closes_what_it_opens() {
    let html = fixtures::report().html().unwrap();
    assert!(!html.contains("<script") && !html.contains("http"));
    for tag in ["section", "table", "tr", "td", "svg", "div", "dl", "p", "h2", "text", "main"] {
        let opened = html.matches(&format!("<{tag}>")).count() + html.matches(&format!("<{tag} ")).count();
        assert_eq!(opened, html.matches(&format!("</{tag}>")).count(), "{tag}");
    }
    assert!(html.contains("Verified.") && html.contains("No path.") && html.contains("prefers-color-scheme:dark"));
    assert!(!html.contains("NaN") && !html.contains("inf,"));
}

#[test]
fn whatever_comes_from_input_is_escaped() {
    let evil = "\"><script>alert(1)</script>".to_owned();
    let mut report = fixtures::report();
    report.verdict.sentence = evil.clone();
    report.inputs[0] = InputFile {
        role: evil.clone(),
        path: evil.clone(),
        sha256: evil.clone(),
        unit: evil.clone(),
        unit_reason: evil.clone(),
        repairs: vec![evil.clone()],
        accuracy: Some(evil.clone()),
        ..InputFile::default()
    };
    report.blisk.assumed = vec![evil.clone()];
    let entry = &mut report.parameters.entries[0];
    (entry.label, entry.value) = (evil.clone(), evil.clone());
    report.symbols[0] = Symbol { symbol: evil.clone(), meaning: evil.clone(), value: evil.clone(), unit: evil.clone() };
    report.times[0].stage = evil.clone();
    report.program_version = evil.clone();
    report.no_pictures = Some(evil.clone());
    report.pictures = vec![Picture {
        file: evil.clone(),
        title: evil.clone(),
        caption: evil.clone(),
        legend: vec![(evil.clone(), evil.clone())],
        png: vec![1, 2, 3],
    }];
    let electrode = &mut report.electrodes[0];
    electrode.enters_from = evil.clone();
    electrode.files = vec![evil.clone()];
    electrode.least_clearance_at.as_mut().unwrap().surface = evil.clone();
    electrode.failure =
        Some(Failure { node: 1, s_mm: 1.0, wall: Some(evil.clone()), place: Some([0.0; 3]), sentence: evil.clone() });
    let html = report.html().unwrap();
    assert!(!html.to_lowercase().contains("<script"));
    assert_eq!(html.matches("alert(1)").count(), html.matches("script&gt;alert(1)&lt;/").count());
}

#[test]
fn an_unverified_path_is_never_called_verified() {
    let mut report = fixtures::report();
    report.electrodes.truncate(1);
    report.electrodes[0].verified = false;
    let html = report.html().unwrap();
    assert!(html.contains("Not verified.") && html.contains("must not be used") && !html.contains("<b>Verified."));
    report.electrodes[0].verified = true;
    report.electrodes[0].certified_clearance_mm = None;
    assert!(!report.html().unwrap().contains("<b>Verified."), "a verdict needs its figure");
}

#[test]
fn an_empty_report_is_still_a_page() {
    let mut report = fixtures::report();
    report.electrodes = vec![ElectrodeReport { motion: Some(Motion::default()), ..ElectrodeReport::default() }];
    (report.inputs, report.symbols, report.times) = (vec![], vec![], vec![]);
    report.parameters = Default::default();
    assert!(report.html().unwrap().contains("No path."));
}

#[test]
fn only_axes_that_move_have_figures_of_smoothness() {
    let still = AxisSmoothness::of(&[0.5; 4]);
    let moving = AxisSmoothness::of(&[0.0, 1.0, 3.0, 2.0]);
    let figures = Smoothness::of(&[still, moving, still, still, still, moving]);
    assert_eq!(figures.iter().map(|f| (f.axis, f.unit)).collect::<Vec<_>>(), [('Y', "mm"), ('C', "deg")]);
    assert_eq!((figures[0].total_variation, figures[0].sign_changes_first_difference), (4.0, 1));
}
