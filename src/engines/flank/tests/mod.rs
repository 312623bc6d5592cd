//! The figures of an independent computation, and laws that hold whatever the figures.

use glam::DVec3;
use serde_json::Value;

use super::axis_surface::AxisSurface;
use super::compensation::{Compensation, Measured, Model, best_rank};
use super::cutter::FlankCutter;
use super::deviation::{DesignGrid, on_axis_grid};
use super::guide::GuideCurve;
use super::offset::{CutterLocation, Touch, three_point, two_point};
use super::params::{FlankParams, Objective, OffsetMethod, SumOver};
use super::plan::{FlankPlan, plan_flank};
use super::ruled_surface::{RuledSurface, Side};
use super::{FlankError, envelope};
use task::{Cancel, Task};

mod bad_input;
mod check_grid;
mod flat;
mod gouging;
mod heights;
mod laws;
mod own_surface;
mod rings;
mod turning_back;
mod wall_beside;
mod walls;

const CASES: [&str; 4] = ["cone_r1_a5_A", "cone_r1_a5_B", "cyl_R2_A", "cyl_R2_B"];

pub(super) fn reference() -> Value {
    serde_json::from_str(include_str!("../../../../tests/data/flank/reference.json")).unwrap()
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect()
}

fn points(value: &Value) -> Vec<DVec3> {
    value.as_array().unwrap().iter().map(|p| DVec3::from_slice(&numbers(p))).collect()
}

/// Surface, cutter and figures of a case.
pub(super) fn case(reference: &Value, name: &str) -> (RuledSurface, FlankCutter, Value) {
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

/// The path that the reference starts compensation from.
fn covered_start(
    surface: &RuledSurface,
    cutter: &FlankCutter,
    figures: &Value,
    size: [usize; 2],
) -> (DesignGrid, Measured) {
    let covered = &figures["covered"];
    let range = ["u0_lo", "u0_hi"].map(|key| covered[key].as_f64().unwrap());
    let grid = DesignGrid::new(surface, size);
    let axis = AxisSurface::new(points(&covered["D1"]), points(&covered["D2"]), range).unwrap();
    let start = Measured::new(&grid, axis, cutter, None).unwrap();
    (grid, start)
}

/// A case and its path without refinement, for what does not depend on it.
fn quick(name: &str) -> (RuledSurface, FlankPlan) {
    let (surface, cutter, _) = case(&reference(), name);
    let params = FlankParams { grid: [20, 10], rounds: 0, below_mm: 0.0, ..FlankParams::default() };
    let plan = planned(&surface, &cutter, &params).unwrap();
    (surface, plan)
}

fn planned(surface: &RuledSurface, cutter: &FlankCutter, params: &FlankParams) -> Result<FlankPlan, FlankError> {
    plan_flank(surface, cutter, params, &Task::default())
}

#[test]
fn places_and_normals_agree_with_the_reference() {
    let reference = reference();
    for name in CASES {
        let (surface, _, figures) = case(&reference, name);
        let f = &figures["normals"];
        for (i, uv) in f["uv"].as_array().unwrap().iter().map(numbers).enumerate() {
            close(surface.point(uv[0], uv[1]), points(&f["R"])[i], 1e-8);
            close(surface.normal(uv[0], uv[1]), points(&f["n"])[i], 1e-10);
        }
    }
}

#[test]
fn the_axis_surface_and_its_sums_agree_with_the_reference() {
    let reference = reference();
    for name in CASES {
        let (surface, cutter, figures) = case(&reference, name);
        let f = &figures["initial_fit"];
        let locations: Vec<CutterLocation> =
            (0..50).map(|i| three_point(&surface, &cutter, f64::from(i) / 49.0, 0.25).unwrap()).collect();
        for (location, u1) in locations.iter().zip(numbers(&f["u1"])) {
            assert!((location.u1 - u1).abs() < 1e-9);
        }
        let axis = AxisSurface::fit(&locations, 10, false).unwrap();
        for (ours, theirs) in [(axis.lower(), points(&f["D1"])), (axis.upper(), points(&f["D2"]))] {
            ours.iter().zip(theirs).for_each(|(a, b)| close(*a, b, 2e-8));
        }
        for (key, size) in [("50x50", [50, 50]), ("100x50", [100, 50])] {
            let wanted = figures["initial_sums_surf_grid"][key].as_f64().unwrap();
            let sum = DesignGrid::new(&surface, size).deviation(&axis, &cutter, None).unwrap().0.sum;
            assert!((sum / wanted - 1.0).abs() < 1e-6, "{name} {key}: {sum} {wanted}");
            let wanted = figures["initial_sums_axis_grid"][key].as_f64().unwrap();
            let sum = on_axis_grid(&surface, &axis, &cutter, size).unwrap().sum;
            assert!((sum / wanted - 1.0).abs() < 1e-6, "{name} {key}: {sum} {wanted}");
        }
    }
}

#[test]
fn the_deviations_of_the_reference_paths_are_those_of_the_reference() {
    let reference = reference();
    for name in CASES {
        let (surface, cutter, figures) = case(&reference, name);
        let (grid, start) = covered_start(&surface, &cutter, &figures, [100, 50]);
        let covered = &figures["covered"];
        for (key, at) in [("GN_LS", &covered["GN_LS"]), ("L1", &covered["L1"]), ("init", &covered["init"])] {
            let path = match at.get("D1") {
                Some(lower) => {
                    let axis = AxisSurface::new(points(lower), points(&at["D2"]), start.axis.u0_range).unwrap();
                    Measured::new(&grid, axis, &cutter, None).unwrap()
                }
                None => start.clone(),
            };
            let d = &path.deviation;
            let ours = [d.sum, d.mean, d.rms, d.most_overcut, d.most_undercut, d.sum_overcut, d.sum_undercut];
            let keys = ["sum", "mean", "rms", "min_overcut", "max_undercut", "sum_overcut", "sum_undercut"];
            for (ours, which) in ours.into_iter().zip(keys) {
                let wanted = at[which].as_f64().unwrap();
                assert!((ours / wanted - 1.0).abs() < 1e-5, "{name} {key} {which}: {ours} {wanted}");
            }
        }
    }
}

#[test]
fn every_rank_has_the_sum_of_the_reference_and_the_same_one_wins() {
    let reference = reference();
    for name in CASES {
        let (surface, cutter, figures) = case(&reference, name);
        let (grid, start) = covered_start(&surface, &cutter, &figures, [100, 50]);
        let tsvd = &figures["covered"]["tsvd"];
        let (best, ranks) =
            best_rank((&surface, &grid), &start, &cutter, (Model::Height, SumOver::Surface), &Cancel::default())
                .unwrap();
        // Far ranks leave the part altogether; what they come to is noise.
        for (k, wanted) in
            numbers(&tsvd["sum_per_k"]).into_iter().enumerate().filter(|(_, sum)| *sum < 1.1 * start.deviation.sum)
        {
            let sum = ranks.sums[k].unwrap();
            assert!((sum / wanted - 1.0).abs() < 1e-5, "{name} rank {}: {sum} {wanted}", k + 1);
        }
        assert_eq!(ranks.best as u64, tsvd["best_k"].as_u64().unwrap(), "{name}");
        assert!(best.deviation.sum <= tsvd["best"].as_f64().unwrap() * 1.000_001);
        assert!(ranks.singular_values.windows(2).all(|s| s[0] >= s[1]));
    }
}

#[test]
fn the_sum_of_the_paper_chooses_the_rank_that_is_least_in_it() {
    let reference = reference();
    for name in CASES {
        let (surface, cutter, figures) = case(&reference, name);
        let (grid, start) = covered_start(&surface, &cutter, &figures, [40, 20]);
        let of = |sum| best_rank((&surface, &grid), &start, &cutter, (Model::Shift, sum), &Cancel::default()).unwrap();
        let (path, ranks) = of(SumOver::Axis);
        let own = on_axis_grid(&surface, &path.axis, &cutter, grid.size()).unwrap().sum;
        let first = on_axis_grid(&surface, &start.axis, &cutter, grid.size()).unwrap().sum;
        assert!((ranks.sums[ranks.best - 1].unwrap() - own).abs() < 1e-12 && own < first, "{name}: {own} {first}");
        let (other, _) = of(SumOver::Surface);
        let others = on_axis_grid(&surface, &other.axis, &cutter, grid.size()).unwrap().sum;
        assert!(own <= others + 1e-12 && other.deviation.sum <= path.deviation.sum + 1e-12, "{name}: {own} {others}");
    }
}

#[test]
fn plans_for_a_cone_reach_the_ratios_of_the_reference_and_keep_them_while_moving() {
    reaches_and_keeps([("cone_r1_a5_A", [0.5593, 0.538]), ("cone_r1_a5_B", [0.5449, 0.485])]);
}

#[test]
fn plans_for_a_cylinder_reach_the_ratios_of_the_reference_and_keep_them_while_moving() {
    reaches_and_keeps([("cyl_R2_A", [0.4536, 0.429]), ("cyl_R2_B", [0.5579, 0.531])]);
}

fn reaches_and_keeps(cases: [(&str, [f64; 2]); 2]) {
    let reference = reference();
    for (name, [one_pass, refined]) in cases {
        let (surface, cutter, figures) = case(&reference, name);
        let params = FlankParams { below_mm: 0.0, ..FlankParams::default() };
        let plan = planned(&surface, &cutter, &params).unwrap();
        let wanted = figures["covered"]["init"]["sum"].as_f64().unwrap();
        assert!((plan.initial.deviation.sum / wanted - 1.0).abs() < 1e-3, "{name} {}", plan.initial.deviation.sum);
        assert!(plan.ratio(&plan.chosen) < one_pass, "{name}: chosen {}", plan.ratio(&plan.chosen));
        assert!(plan.ratio(&plan.refined) < refined, "{name}: refined {}", plan.ratio(&plan.refined));
        for (which, path) in plan.paths() {
            // Ranks are chosen by where the cutter stands, as in the reference.
            let [first, last] = if which == "chosen" { path.feet.t_range() } else { path.coverage.t_range };
            assert!(first >= 0.0 && last <= 1.0 && (path.coverage.is_whole || which == "chosen"), "{name} {which}");
            assert_eq!(path.deviation.values.len(), 5000);
        }
        let lowest = [&plan.chosen, &plan.refined].map(|path| path.coverage.height_range_mm[0].min(0.0));
        assert!(lowest[1] > lowest[0] - 0.02, "{name}: the cutter did not climb off the surface: {lowest:?}");
        let path = &plan.refined;
        let (still, moving) = (&path.deviation, &path.envelope.deviation);
        assert!((moving.sum / still.sum - 1.0).abs() < 0.02, "{} {}", moving.sum, still.sum);
        assert_eq!(path.envelope.without, 0);
        let grid = DesignGrid::new(&surface, [100, 50]);
        for (k, place) in grid.places().enumerate().step_by(487) {
            let swept = swept_above(&path.axis, &cutter, (place.point, place.normal), [-2.0, 40.0], 100);
            assert!((swept.unwrap() - moving.values[k]).abs() < 1e-5, "{k}: {swept:?} {}", moving.values[k]);
        }
    }
}

#[test]
fn the_envelope_agrees_with_the_reference_and_with_a_brute_force_sweep() {
    let reference = reference();
    for name in CASES {
        let (surface, cutter, figures) = case(&reference, name);
        let (grid, start) = covered_start(&surface, &cutter, &figures, [21, 11]);
        let moving = envelope::check(&grid, &start.axis, &cutter, (&start.deviation, &start.feet));
        assert_eq!(moving.without, 0);
        let wanted = &figures["checks"]["init_brute"];
        let greatest = wanted["max_diff_all"].as_f64().unwrap();
        assert!(
            (moving.greatest_difference / greatest - 1.0).abs() < 0.05,
            "{} {greatest}",
            moving.greatest_difference
        );
        let swept_sum = wanted["sum_swept"].as_f64().unwrap();
        assert!((moving.deviation.sum / swept_sum - 1.0).abs() < 1e-4, "{} {swept_sum}", moving.deviation.sum);
        for (k, place) in grid.places().enumerate().step_by(5) {
            let swept = swept_above(&start.axis, &cutter, (place.point, place.normal), [-2.0, 40.0], 100);
            let envelope = moving.deviation.values[k];
            assert!((swept.unwrap() - envelope).abs() < 1e-8, "{name} {k}: {swept:?} {envelope}");
        }
    }
}

#[test]
fn a_surface_run_the_other_way_is_the_same_surface() {
    let guide = |points: [[f64; 3]; 4]| GuideCurve::Bezier { points: points.map(DVec3::from_array).to_vec() };
    let lower = guide([[0.0, 1.0, 0.0], [10.0, 4.0, 0.0], [22.0, 3.0, 1.0], [30.0, 0.0, 0.0]]);
    let upper = guide([[0.0, 0.0, 10.0], [9.0, 5.0, 10.0], [20.0, 1.0, 11.0], [31.0, 2.0, 12.0]]);
    let surface = RuledSurface::from_guides(&lower, &upper, Side::Positive).unwrap();
    let reversed = surface.reversed();
    assert!(reversed.is_reversed() && reversed.side() == Side::Negative && reversed.reversed() == surface);
    for (u, v) in [(0.0, 0.0), (0.2, 0.7), (0.5, 0.1), (1.0, 1.0)] {
        let (there, back) = (surface.at(u, v), reversed.at(1.0 - u, v));
        assert!(there.point.distance(back.point) < 1e-12 && there.normal.distance(back.normal) < 1e-12);
        assert!(there.along_u.distance(-back.along_u) < 1e-10);
    }
}

/// How far above a point (mm) its normal first enters the cutter's flutes anywhere on the path, by brute force: the
/// part of the cone between two `heights` above the tip (mm), at `samples` places of the path and ever finer around the
/// nearest. None if it never does. Where the normal has left the cutter again below the point, that is the other side
/// of a wall and does not count. For checks: it knows nothing of envelopes.
pub(super) fn swept_above(
    axis: &AxisSurface,
    cutter: &FlankCutter,
    (point, normal): (DVec3, DVec3),
    heights: [f64; 2],
    samples: usize,
) -> Option<f64> {
    const FINER: usize = 6;
    let (mut from, mut to) = (0.0, 1.0);
    let mut best: Option<f64> = None;
    for _ in 0..FINER {
        let spacing = (to - from) / samples.max(2) as f64;
        let entry = |i: usize| {
            let t = from + spacing * i as f64;
            envelope::entry(&axis.at(t), cutter, (point, normal), heights).map(|s| (s, t))
        };
        let (least, t) = (0..=samples.max(2)).filter_map(entry).min_by(|a, b| a.0.total_cmp(&b.0))?;
        best = Some(best.map_or(least, |b| b.min(least)));
        (from, to) = (t - 2.0 * spacing, t + 2.0 * spacing);
        if !axis.is_closed() {
            (from, to) = (from.max(0.0), to.min(1.0));
        }
    }
    best
}
