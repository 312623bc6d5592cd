//! The figures of an independent computation, and laws that hold whatever the figures.

use glam::{DVec2, DVec3};
use serde_json::Value;

use super::axis_surface::AxisSurface;
use super::cutter::FlankCutter;
use super::deviation::{DesignGrid, on_axis_grid};
use super::guide::GuideCurve;
use super::offset::{CutterLocation, Touch, three_point, two_point};
use super::ruled_surface::{RuledSurface, Side};

const CASES: [&str; 4] = ["cone_r1_a5_A", "cone_r1_a5_B", "cyl_R2_A", "cyl_R2_B"];

fn reference() -> Value {
    serde_json::from_str(include_str!("../../tests/data/flank/reference.json")).unwrap()
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect()
}

fn points(value: &Value) -> Vec<DVec3> {
    value.as_array().unwrap().iter().map(|p| DVec3::from_slice(&numbers(p))).collect()
}

/// Surface, cutter and figures of a case.
fn case(reference: &Value, name: &str) -> (RuledSurface, FlankCutter, Value) {
    let which = &name[name.len() - 1..];
    let guide = |key: &str| GuideCurve::Bezier { points: points(&reference["surfaces"][which][key]) };
    let surface = RuledSurface::from_guides(&guide("B1"), &guide("B2"), Side::Positive).unwrap();
    let figures = reference["cases"][name].clone();
    let of = |key: &str| figures["tool"][key].as_f64().unwrap();
    (surface, FlankCutter::cone(of("r0"), of("alpha_deg"), 40.0), figures)
}

fn close(a: DVec3, b: DVec3, tolerance: f64) {
    assert!(a.distance(b) < tolerance, "{a} and {b} are {:e} apart", a.distance(b));
}

#[test]
fn offsets_and_axes_agree_with_the_reference() {
    let reference = reference();
    for name in CASES {
        let (surface, cutter, figures) = case(&reference, name);
        for kind in ["two_point_u1_eq_u0", "three_point"] {
            let f = &figures[kind];
            let u1 = f.get("u1").map(numbers);
            for (i, u0) in numbers(&f["u0"]).into_iter().enumerate() {
                let l = if let Some(u1) = &u1 {
                    let l = three_point(&surface, &cutter, u0, 0.25).unwrap();
                    assert!((l.u1 - u1[i]).abs() < 1e-9 && l.touch == Touch::ThreePoints, "{l:?} {}", u1[i]);
                    l
                } else {
                    two_point(&surface, &cutter, u0, u0).unwrap()
                };
                close(l.q1, points(&f["Q1"])[i], 1e-9 * 100.0);
                close(l.q2, points(&f["Q2"])[i], 1e-9 * 100.0);
                close(l.tip, points(&f["O"])[i], 1e-9 * 100.0);
                close(l.axis, points(&f["I"])[i], 1e-9);
                if u1.is_none() {
                    let wanted = numbers(&f["eps_mid"])[i];
                    assert!((l.middle_mm.unwrap() - wanted).abs() < 1e-9, "{:?} {wanted}", l.middle_mm);
                }
            }
        }
    }
}

#[test]
fn scratch() {
    let reference = reference();
    for name in CASES {
        let (surface, cutter, figures) = case(&reference, name);
        let grid = DesignGrid::new(&surface, [100, 50]);
        let cov = &figures["covered"];
        let range = [cov["u0_lo"].as_f64().unwrap(), cov["u0_hi"].as_f64().unwrap()];
        for (what, f) in [("cov", cov), ("ls", &cov["GN_LS"]), ("l1", &cov["L1"])] {
            let axis = AxisSurface::new(points(&f["D1"]), points(&f["D2"]), range).unwrap();
            let (d, feet) = grid.deviation(&axis, &cutter, None).unwrap();
            println!("{name} {what} {} {} {} {:?}", d.sum, d.rms, d.most_overcut, feet.t_range());
        }
        let f = &figures["initial_fit"];
        let l: Vec<CutterLocation> =
            (0..50).map(|i| three_point(&surface, &cutter, i as f64 / 49.0, 0.25).unwrap()).collect();
        let axis = AxisSurface::fit(&l, 10).unwrap();
        let off = axis.lower().iter().zip(points(&f["D1"])).map(|(a, b)| a.distance(b)).fold(0.0, f64::max);
        let offu = axis.upper().iter().zip(points(&f["D2"])).map(|(a, b)| a.distance(b)).fold(0.0, f64::max);
        println!("{off:e} {offu:e}");
        for (key, size) in [("50x50", [50, 50]), ("100x50", [100, 50]), ("101x51", [101, 51]), ("50x100", [50, 100])] {
            let (d, feet) = DesignGrid::new(&surface, size).deviation(&axis, &cutter, None).unwrap();
            println!("surf {} {} {:?}", d.sum, figures["initial_sums_surf_grid"][key], feet.t_range());
            let (d, _) = on_axis_grid(&surface, &axis, &cutter, size).unwrap();
            println!("axis {} {}", d.sum, figures["initial_sums_axis_grid"][key]);
        }
        let _ = DVec2::ZERO;
    }
}

#[test]
fn scratch2() {
    use super::compensation::*;
    use super::params::Objective;
    use super::refine::refine;
    use crate::progress::*;
    let reference = reference();
    for name in CASES {
        let (surface, cutter, figures) = case(&reference, name);
        let grid = DesignGrid::new(&surface, [100, 50]);
        let cov = &figures["covered"];
        let range = [cov["u0_lo"].as_f64().unwrap(), cov["u0_hi"].as_f64().unwrap()];
        let axis = AxisSurface::new(points(&cov["D1"]), points(&cov["D2"]), range).unwrap();
        let start = Measured::new(&grid, axis, &cutter, None).unwrap();
        let wanted = numbers(&cov["tsvd"]["sum_per_k"]);
        for model in [Model::Shift, Model::Height, Model::Moving] {
            let now = std::time::Instant::now();
            let (best, curve) = best_rank(&grid, &start, &cutter, model, &Cancel::default()).unwrap();
            let el = now.elapsed();
            let off: Vec<String> = curve
                .sums
                .iter()
                .zip(&wanted)
                .step_by(6)
                .map(|(a, b)| format!("{:.5}", a.unwrap_or(f64::NAN) - b))
                .collect();
            println!(
                "{name} {model:?} k {} {} ratio {} {off:?} {el:?}",
                curve.best,
                best.deviation.sum,
                best.deviation.sum / start.deviation.sum
            );
            if model == Model::Height {
                for o in [
                    Objective::Sum,
                    Objective::Rms,
                    Objective::Bounded { overcut_mm: Some(0.0), undercut_mm: None },
                    Objective::Bounded { overcut_mm: None, undercut_mm: Some(0.02) },
                    Objective::Bounded { overcut_mm: Some(0.02), undercut_mm: Some(0.02) },
                ] {
                    let now = std::time::Instant::now();
                    let r = refine(&grid, &best, &cutter, (o, 100), (&Progress::silent(), &Cancel::default())).unwrap();
                    println!(
                        "  {o:?} {} ratio {} rms {} over {} under {} {:?} t {:?}",
                        r.deviation.sum,
                        r.deviation.sum / start.deviation.sum,
                        r.deviation.rms,
                        r.deviation.most_overcut,
                        r.deviation.most_undercut,
                        now.elapsed(),
                        r.feet.t_range()
                    );
                }
            }
        }
    }
}

#[test]
fn scratch3() {
    use super::envelope::*;
    use super::params::*;
    use super::plan::plan_flank;
    use crate::progress::*;
    let reference = reference();
    for name in CASES {
        let (surface, cutter, figures) = case(&reference, name);
        let now = std::time::Instant::now();
        let plan =
            plan_flank(&surface, &cutter, &FlankParams::default(), &Progress::silent(), &Cancel::default()).unwrap();
        println!(
            "{name} {:?} range {:?} {} {}",
            now.elapsed(),
            plan.initial.axis.u0_range,
            figures["covered"]["u0_lo"],
            figures["covered"]["u0_hi"]
        );
        for (what, path) in plan.paths() {
            println!(
                " {what} {} ratio {} env {} diff {} without {} cov {:?}",
                path.deviation.sum,
                plan.ratio(path),
                path.envelope.deviation.sum,
                path.envelope.greatest_difference,
                path.envelope.without,
                path.coverage
            );
            let coarse = DesignGrid::new(&surface, [21, 11]);
            let (d, feet) = coarse.deviation(&path.axis, &cutter, None).unwrap();
            let env = check(&coarse, &path.axis, &cutter, (&d, &feet));
            let swept: Vec<f64> = coarse
                .places()
                .map(|p| swept_above(&path.axis, &cutter, (p.point, p.normal), [-2.0, 40.0], 200).unwrap())
                .collect();
            let off = swept.iter().zip(&env.deviation.values).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            let sum: f64 = swept.iter().map(|x| x.abs()).sum();
            println!(
                "    coarse static {} env {} swept {} env-swept {off:e} static-env {}",
                d.sum, env.deviation.sum, sum, env.greatest_difference
            );
        }
        println!("{:?}", plan.warnings);
        println!("{}", figures["checks"]["init_brute"]);
        println!("{}", figures["checks"]["LS_brute"]);
    }
}
