//! Errors for input that makes no path, or none as asked.

use super::*;
use geometry::nurbs::NurbsError;

fn line(a: [f64; 3], b: [f64; 3]) -> GuideCurve {
    GuideCurve::Bezier { points: vec![a.into(), b.into()] }
}

fn spanned(lower: &GuideCurve, upper: &GuideCurve) -> Result<RuledSurface, FlankError> {
    RuledSurface::from_guides(lower, upper, Side::Positive)
}

#[test]
fn guides_that_cross_touch_or_run_apart_are_told_so() {
    let lower = line([0.0, 0.0, 0.0], [10.0, 0.0, 0.0]);
    let crossing = spanned(&lower, &line([0.0, -3.0, 0.0], [10.0, 4.0, 0.0])).unwrap_err();
    assert!(matches!(crossing, FlankError::GuidesMeet { .. }), "{crossing}");
    let touching = spanned(&lower, &line([0.0, 0.0, 5.0], [10.0, 0.0, 0.0])).unwrap_err();
    assert!(matches!(touching, FlankError::GuidesMeet { .. }), "{touching}");
    let backwards = spanned(&lower, &line([10.0, 0.0, 5.0], [0.0, 0.0, 5.0])).unwrap_err();
    assert!(matches!(backwards, FlankError::Folds { .. }), "{backwards}");
    assert!(backwards.to_string().contains("reverse one of the guide"));
    let twisted = spanned(&lower, &line([5.5, -5.0, 5.0], [4.5, 5.0, 5.0])).unwrap_err();
    assert!(matches!(twisted, FlankError::Twisted { .. }), "{twisted}");
    assert!(spanned(&lower, &line([0.0, 1.0, 5.0], [10.0, -1.0, 5.0])).is_ok());
}

#[test]
fn the_side_of_two_guides_is_asked_for_and_each_is_named_by_where_it_is() {
    // Along X below and along X above: X x Z is -Y.
    let (lower, upper) = (line([0.0, 0.0, 0.0], [10.0, 0.0, 0.0]), line([0.0, 0.0, 5.0], [10.0, 0.0, 5.0]));
    let open = RuledSurface::from_guides(&lower, &upper, Side::Automatic).unwrap_err();
    let FlankError::SideOpen { point, normal } = &open else { panic!("{open}") };
    close(*point, DVec3::new(5.0, 0.0, 2.5), 1e-12);
    close(*normal, DVec3::NEG_Y, 1e-12);
    let words = open.to_string();
    assert!(words.contains("positive side is towards") && words.contains("-1.00"), "{words}");
    let positive = spanned(&lower, &upper).unwrap();
    assert_eq!(positive.normal(0.5, 0.5), DVec3::NEG_Y, "what is named is what is taken");
}

#[test]
fn a_point_of_no_number_and_too_few_points_are_refused() {
    let good = line([0.0, 0.0, 5.0], [10.0, 0.0, 5.0]);
    let wrong = GuideCurve::Points { points: vec![DVec3::ZERO, DVec3::NAN, DVec3::X], degree: 3 };
    assert_eq!(
        spanned(&wrong, &good),
        Err(FlankError::Points { which: "lower", problem: "point 2 has a coordinate that is no number".to_owned() })
    );
    let none = GuideCurve::Bezier { points: Vec::new() };
    assert_eq!(spanned(&good, &none), Err(FlankError::Guide { which: "upper", reason: NurbsError::Counts }));
}

#[test]
fn points_are_read_from_text_with_the_line_of_what_is_wrong() {
    let read = GuideCurve::from_csv("x; y; z\n# a line\n0; 0; 0\n\n1.5, 2e1 -3\n2\t0\t1\n").unwrap();
    let wanted = [DVec3::ZERO, DVec3::new(1.5, 20.0, -3.0), DVec3::new(2.0, 0.0, 1.0)];
    assert_eq!(read, GuideCurve::Points { points: wanted.to_vec(), degree: 3 });
    let curve = read.curve().unwrap();
    wanted.iter().for_each(|p| assert!(curve.nearest(*p).distance < 1e-9));
    for text in ["0,0,0\n1,2\n", "0,0,0\nnan,1,2", "0,0,0\n1,2,3,4"] {
        let error = GuideCurve::from_csv(text).unwrap_err();
        assert!(matches!(error, FlankError::Unreadable { line: 2, .. }), "{error}");
    }
}

#[test]
fn a_row_of_very_many_points_is_refused_in_words() {
    let text = |n: usize| (0..n).map(|i| format!("{i},0,0\n")).collect::<String>();
    assert!(GuideCurve::from_csv(&text(20_000)).is_ok());
    let error = GuideCurve::from_csv(&text(20_001)).unwrap_err();
    assert_eq!(error, FlankError::TooManyPoints { most: 20_000 });
    let long = GuideCurve::Points { points: vec![DVec3::ZERO; 20_001], degree: 3 };
    assert_eq!(spanned(&line([0.0; 3], [1.0; 3]), &long), Err(error));
}

#[test]
fn rows_with_as_many_points_have_rulings_from_point_to_point() {
    use crate::guide::pairing_warning;
    // Spaced evenly below and more and more widely above: shares of length are not the same.
    let row = |z: f64, x: &dyn Fn(f64) -> f64, n: u32| GuideCurve::Points {
        points: (0..n).map(f64::from).map(|i| DVec3::new(x(i), 0.1 * i * i, z)).collect(),
        degree: 3,
    };
    let (lower, upper) = (row(0.0, &|i| 4.0 * i, 9), row(10.0, &|i| 2.0 * i + 0.25 * i * i, 9));
    let surface = spanned(&lower, &upper).unwrap();
    let (GuideCurve::Points { points: low, .. }, GuideCurve::Points { points: high, .. }) = (&lower, &upper) else {
        panic!()
    };
    for (p, q) in low.iter().zip(high) {
        let [u, w] = [surface.lower().nearest(*p), surface.upper().nearest(*q)];
        assert!(u.distance < 1e-9 && w.distance < 1e-9 && (u.u - w.u).abs() < 1e-7, "{} {}", u.u, w.u);
        assert!(surface.point(u.u, 0.5).distance(0.5 * (*p + *q)) < 1e-6, "the middle of the ruling given");
    }
    assert_eq!(pairing_warning(&lower, &upper), None);
    let words = pairing_warning(&lower, &row(10.0, &|i| 4.0 * i, 8)).unwrap();
    assert!(words.contains("9 points") && words.contains("one 8"), "{words}");
}

#[test]
fn a_b_spline_guide_runs_from_zero_to_one_whatever_its_knots() {
    let points: Vec<DVec3> = (0..5).map(|i| DVec3::new(f64::from(i), f64::from(i * i), 0.0)).collect();
    let of = |knots: [f64; 9]| GuideCurve::BSpline {
        degree: 3,
        knots: knots.to_vec(),
        points: points.clone(),
        weights: vec![],
    };
    let plain = of([0.0, 0.0, 0.0, 0.0, 0.5, 1.0, 1.0, 1.0, 1.0]).curve().unwrap();
    let stretched = of([2.0, 2.0, 2.0, 2.0, 5.0, 8.0, 8.0, 8.0, 8.0]).curve().unwrap();
    for u in [0.0, 0.2, 0.5, 0.9, 1.0] {
        close(plain.point(u), stretched.point(u), 1e-12);
    }
}

#[test]
fn a_cutter_too_short_or_too_thick_is_planned_with_and_told_so() {
    let reference = reference();
    let params = FlankParams { grid: [20, 10], rounds: 0, ..FlankParams::default() };
    let (surface, ..) = case(&reference, "cyl_R2_A");
    let short = FlankCutter::cylinder(2.0, 8.0);
    assert!(matches!(short.fits(&surface, 0.0), Err(FlankError::CutterTooShort { .. })));
    let plan = planned(&surface, &short, &params).unwrap();
    assert!(plan.warnings.iter().any(|w| w.text.contains("as if its flutes were long enough")), "{:?}", plan.warnings);
    // A hollow of radius 6, seen from inside.
    let arc = |z: f64| {
        let points = (0..=20).map(|i| 0.1 * f64::from(i)).map(|a| DVec3::new(6.0 * a.cos(), 6.0 * a.sin(), z));
        GuideCurve::Points { points: points.collect(), degree: 3 }
    };
    let hollow = RuledSurface::from_guides(&arc(0.0), &arc(8.0), Side::Negative).unwrap();
    assert!((hollow.hollow_radius(0.5, 0.5) - 6.0).abs() < 1e-2 && hollow.normal(0.5, 0.5).dot(DVec3::X) < 0.0);
    assert!(FlankCutter::cylinder(5.5, 20.0).fits(&hollow, 0.0).is_ok());
    let thick = FlankCutter::cylinder(7.0, 20.0).fits(&hollow, 0.0);
    assert!(matches!(thick, Err(FlankError::CutterTooThick { .. })), "{thick:?}");
    // What touches is the part of a cone that is left above its reach below the surface.
    let cone = FlankCutter::cone(1.0, 20.0, 30.0);
    assert!(cone.fits(&hollow, 0.0).is_ok(), "1 mm at the bottom, 3.9 mm at the top");
    let raised = cone.fits(&hollow, 10.0);
    let Err(FlankError::CutterTooThick { radius_mm, v, .. }) = raised else { panic!("{raised:?}") };
    let wanted = cone.radius_at(10.0 + v * 8.0 * cone.half_angle().cos()) / cone.half_angle().cos();
    assert!((radius_mm - wanted).abs() < 1e-6 && radius_mm > 6.0, "{radius_mm} {wanted}");
    let reaching = FlankCutter::cylinder(2.0, 12.0);
    assert!(reaching.fits(&hollow, 3.9).is_ok());
    let Err(FlankError::CutterTooShort { needed_mm, .. }) = reaching.fits(&hollow, 4.5) else { panic!() };
    assert!((needed_mm - 12.5).abs() < 1e-6, "8 mm of surface and 4.5 mm below it: {needed_mm}");
}

#[test]
fn without_a_change_of_sign_the_nearest_location_is_taken_and_said() {
    let (surface, ..) = case(&reference(), "cyl_R2_A");
    // A slide too small to reach the third contact.
    let cutter = FlankCutter::cylinder(2.0, 40.0);
    let l = three_point(&surface, &cutter, 0.0, 0.001).unwrap();
    assert_eq!(l.touch, Touch::NearestToThree);
    let ends = [-0.001, 0.001].map(|d| two_point(&surface, &cutter, 0.0, d).unwrap().middle_mm.unwrap().abs());
    assert!((l.middle_mm.unwrap().abs() - ends[0].min(ends[1])).abs() < 1e-12);
    let params =
        FlankParams { slide_u: 0.001, is_covering: false, grid: [20, 10], rounds: 0, ..FlankParams::default() };
    let plan = planned(&surface, &cutter, &params).unwrap();
    assert!(plan.warnings.iter().any(|w| w.text.contains("cannot touch the surface midway")), "{:?}", plan.warnings);
    assert!(plan.warnings.iter().any(|w| w.text.contains("does not cover")), "{:?}", plan.warnings);
}

#[test]
fn a_jump_through_zero_is_no_touch() {
    use crate::offset::slide_to_touch;
    let (surface, cutter, _) = case(&reference(), "cyl_R2_A");
    let any = two_point(&surface, &cutter, 0.5, 0.5).unwrap();
    // From -0.4 to 0.6 at 0.53 without being 0, and 0 at 0.36 on the other side.
    let jumping = |u1: f64| Some((u1, if u1 > 0.53 { 0.6 } else { 2.5 * (0.36 - u1) }, any));
    let found = slide_to_touch(&jumping, 0.5, 0.25, 1e-7).unwrap();
    assert!((found.0 - 0.36).abs() < 1e-7 && found.1.abs() < 1e-7, "{} {}", found.0, found.1);
    let only = |u1: f64| Some((u1, if u1 > 0.53 { 0.6 } else { -0.4 - (0.53 - u1) }, any));
    let found = slide_to_touch(&only, 0.5, 0.25, 1e-7).unwrap();
    assert!((found.1 + 0.4).abs() < 1e-3, "the least there is, not a touch: {}", found.1);
}

#[test]
fn parameters_out_of_range_are_named() {
    let (surface, cutter, _) = case(&reference(), "cyl_R2_A");
    let name = |params: &FlankParams| match planned(&surface, &cutter, params) {
        Err(FlankError::Parameter { name, .. }) => name,
        other => panic!("{:?}", other.map(|plan| plan.warnings)),
    };
    let usual = FlankParams::default;
    assert_eq!(name(&FlankParams { control_points: 3, ..usual() }), "control_points");
    assert_eq!(name(&FlankParams { locations: 9, ..usual() }), "locations");
    assert_eq!(name(&FlankParams { grid: [1, 50], ..usual() }), "grid");
    assert_eq!(name(&FlankParams { slide_u: f64::NAN, ..usual() }), "slide_u");
    assert_eq!(name(&FlankParams { below_mm: 90.0, ..usual() }), "below_mm");
    let bad = FlankCutter { taper_deg: 50.0, ..cutter.clone() };
    assert!(planned(&surface, &bad, &usual()).unwrap_err().to_string().contains("taper_deg"));
    let cancel = Cancel::default();
    cancel.cancel();
    let stopped = plan_flank(&surface, &cutter, &usual(), &Task::silent(&cancel));
    assert!(matches!(stopped, Err(FlankError::Cancelled(_))));
    let two = FlankParams { offset: OffsetMethod::TwoPoint, grid: [20, 10], rounds: 0, ..usual() };
    assert!(planned(&surface, &cutter, &two).unwrap().locations.iter().all(|l| l.touch == Touch::TwoPoints));
}

#[test]
fn what_is_said_of_one_path_is_said_to_the_readers_of_that_path_alone() {
    let (surface, cutter, _) = case(&reference(), "cone_r1_a5_A");
    let objective = Objective::Bounded { overcut_mm: Some(0.0), undercut_mm: Some(0.0) };
    let params = FlankParams { grid: [30, 12], rounds: 2, objective, ..FlankParams::default() };
    let plan = planned(&surface, &cutter, &params).unwrap();
    let says = |path: &str| plan.warnings_of(path).any(|w| w.contains("the bounds asked for are not kept"));
    assert_eq!(["initial", "chosen", "refined"].map(says), [false, false, true], "{:?}", plan.warnings);
}
