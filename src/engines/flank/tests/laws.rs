//! Properties that follow from geometry alone.

use glam::{DMat3, DVec2};
use nalgebra::{DMatrix, DVector};

use super::*;
use crate::compensation::Row;
use crate::heights::Heights;
use crate::offset::middle;
use crate::refine::refine;

#[test]
fn three_point_locations_meet_their_tangency_equations() {
    let reference = reference();
    for name in CASES {
        let (surface, cutter, _) = case(&reference, name);
        let (sin, cos) = cutter.half_angle().sin_cos();
        for i in 0..=20 {
            let u0 = -0.06 + 1.1 * f64::from(i) / 20.0;
            let l = three_point(&surface, &cutter, u0, 0.25).unwrap();
            let rim = cutter.radius_mm / cos;
            close(l.q1, surface.point(u0, 0.0) + rim * surface.normal(u0, 0.0), 1e-10);
            close(l.q2, surface.point(l.u1, 1.0) + l.upper_radius * surface.normal(l.u1, 1.0), 1e-10);
            assert!((l.upper_radius - rim - l.q1.distance(l.q2) * sin).abs() < 1e-10, "spheres of one cone");
            assert!((l.tip + l.axis * (cutter.radius_mm * sin / cos) - l.q1).length() < 1e-10);
            let (deviation, height) = middle(&surface, &cutter, &l).unwrap();
            assert!(deviation.abs() < 1e-10, "{deviation:e}");
            let foot = surface.foot(l.tip + height * l.axis, DVec2::new(u0, 0.5)).unwrap();
            assert!((foot.v - 0.5).abs() < 1e-9);
        }
    }
}

#[test]
fn feet_are_perpendicular_on_both_sides_of_the_edges() {
    let (surface, ..) = case(&reference(), "cone_r1_a5_A");
    for i in 0..=12 {
        for j in 0..=8 {
            let (u, v) = (-0.1 + 0.1 * f64::from(i), -0.1 + 0.15 * f64::from(j));
            let place = surface.at(u, v);
            let p = place.point + 1.5 * place.normal;
            let foot = surface.foot(p, DVec2::new(u + 0.03, v - 0.05)).unwrap();
            let off = (p - foot.point).normalize();
            let (along_u, along_v) = (foot.along_u.normalize(), foot.along_v.normalize());
            assert!(off.dot(along_u).abs() < 1e-9 && off.dot(along_v).abs() < 1e-9);
            assert!((foot.u - u).abs() < 1e-9 && (foot.v - v).abs() < 1e-9, "{u} {v}: {foot:?}");
        }
    }
}

#[test]
fn low_ranks_agree_with_the_normal_equations() {
    let reference = reference();
    let (surface, cutter, figures) = case(&reference, "cone_r1_a5_B");
    let (grid, start) = covered_start(&surface, &cutter, &figures, [40, 20]);
    let at = (&start.deviation, &start.feet);
    let system = Compensation::new(&grid, &start.axis, &cutter, at, (Model::Height, &Cancel::default())).unwrap();
    let mut rows = DMatrix::zeros(800, 60);
    for (k, place) in grid.grid_places().iter().enumerate() {
        let row = Row::of(&start.axis, &cutter, place, start.feet.at[k], Model::Height);
        row.entries(10).iter().for_each(|(c, value)| rows[(k, *c)] = *value);
    }
    let right = -DVector::from_column_slice(&start.deviation.values);
    // In the span of the first ranks the system is well conditioned, and the answer must solve the normal equations.
    let eigen = nalgebra::SymmetricEigen::new(rows.transpose() * &rows);
    let mut order: Vec<usize> = (0..60).collect();
    order.sort_by(|a, b| eigen.eigenvalues[*b].total_cmp(&eigen.eigenvalues[*a]));
    for rank in [1, 7, 20] {
        let gap = system.singular_values()[rank - 1] - system.singular_values()[rank];
        assert!(gap > 1e-3, "the first {rank} are apart from the others");
        let span = DMatrix::from_fn(60, rank, |r, c| eigen.eigenvectors[(r, order[c])]);
        let reduced = &rows * &span;
        let solved = (reduced.transpose() * &reduced).cholesky().unwrap().solve(&(reduced.transpose() * &right));
        let off = (&span * solved - system.change(rank)).norm();
        assert!(off < 1e-9, "rank {rank}: {off:e}");
    }
    for (value, place) in system.singular_values().iter().zip(&order).take(20) {
        assert!((value * value / eigen.eigenvalues[*place] - 1.0).abs() < 1e-10);
    }
}

#[test]
fn the_exact_derivative_is_the_limit_of_differences_and_height_matters_for_a_cone() {
    let reference = reference();
    let (surface, cutter, figures) = case(&reference, "cone_r1_a5_B");
    let (grid, start) = covered_start(&surface, &cutter, &figures, [9, 5]);
    let step = DVector::from_fn(60, |i, _| 1e-4 * (((i * 37 + 11) % 19) as f64 - 9.0) / 9.0);
    let after = |sign: f64| {
        let axis = start.axis.moved(&(sign * &step)).unwrap();
        Measured::new(&grid, axis, &cutter, None).unwrap().deviation.values
    };
    let (plus, minus) = (after(1.0), after(-1.0));
    let mut worst = [0.0f64; 3];
    for (k, place) in grid.grid_places().iter().enumerate() {
        for (i, model) in [Model::Moving, Model::Height, Model::Shift].into_iter().enumerate() {
            let row = Row::of(&start.axis, &cutter, place, start.feet.at[k], model);
            let predicted: f64 = row.entries(10).iter().map(|(c, value)| value * step[*c]).sum();
            worst[i] = worst[i].max((0.5 * (plus[k] - minus[k]) - predicted).abs());
        }
    }
    assert!(worst[0] < 1e-9, "{worst:?}");
    assert!(worst[0] * 100.0 < worst[1] && worst[1] < worst[2], "{worst:?}");
}

#[test]
fn the_row_without_the_height_is_that_of_a_cylinder_only() {
    for (name, is_same) in [("cyl_R2_B", true), ("cone_r1_a5_B", false)] {
        let (surface, cutter, _) = case(&reference(), name);
        let [shift, height] = [Model::Shift, Model::Height].map(|row| {
            let params = FlankParams { row, grid: [20, 10], rounds: 0, ..FlankParams::default() };
            planned(&surface, &cutter, &params).unwrap()
        });
        assert!(shift.initial == height.initial, "{name}: the row comes after the first path");
        assert_eq!(shift.ranks == height.ranks && shift.chosen == height.chosen, is_same, "{name}");
    }
}

#[test]
fn splines_sum_to_one_and_reproduce_a_cubic_past_their_ends() {
    use crate::axis_surface::CubicBasis;
    for count in [4, 5, 10, 23] {
        let basis = CubicBasis::new(count);
        for i in -10..=110 {
            let at = basis.at(f64::from(i) / 100.0);
            assert!((at.values.iter().sum::<f64>() - 1.0).abs() < 1e-10, "{count} {i}");
            assert!(!(0..=100).contains(&i) || at.values.iter().all(|b| *b >= -1e-15));
        }
    }
    // Without inner knots the axis surface is a pair of Bezier curves.
    let p: Vec<DVec3> = (0..4).map(|i| DVec3::new(f64::from(i * i), f64::from(3 - i), f64::from(i % 2))).collect();
    let axis = AxisSurface::new(p.clone(), p.iter().map(|q| *q + DVec3::Z).collect(), [0.0, 1.0]).unwrap();
    for t in [-0.2, 0.0, 0.3, 1.0, 1.2] {
        let s = 1.0 - t;
        let bezier = s * s * s * p[0] + 3.0 * s * s * t * p[1] + 3.0 * s * t * t * p[2] + t * t * t * p[3];
        close(axis.at(t).tip, bezier, 1e-12);
        let slope = (axis.at(t + 1e-6).tip - axis.at(t - 1e-6).tip) / 2e-6;
        close(axis.at(t).tip_speed, slope, 1e-7);
    }
}

#[test]
fn a_cylinder_lies_along_a_developable_surface_without_deviation() {
    // A cylinder's own flank: rulings along Z over an arc of radius 30, the cutter outside.
    let arc = |z: f64| {
        let points =
            (0..=40).map(|i| 0.5 + 0.9 * f64::from(i) / 40.0).map(|a| DVec3::new(30.0 * a.cos(), 30.0 * a.sin(), z));
        GuideCurve::Points { points: points.collect(), degree: 5 }
    };
    let surface = RuledSurface::from_guides(&arc(0.0), &arc(12.0), Side::Positive).unwrap();
    assert!(surface.normal(0.5, 0.5).dot(surface.point(0.5, 0.5) * DVec3::new(1.0, 1.0, 0.0)) > 0.0, "outside bulges");
    let cutter = FlankCutter::cylinder(4.0, 20.0);
    let params = FlankParams { grid: [40, 12], ..FlankParams::default() };
    let plan = planned(&surface, &cutter, &params).unwrap();
    assert!(plan.initial.deviation.most_undercut < 1e-4 && plan.initial.deviation.most_overcut > -1e-4);
    for pose in &plan.refined.poses {
        assert!((pose.axis - DVec3::Z).length() < 1e-3, "{pose:?}");
        assert!((pose.tip.truncate().length() - 34.0).abs() < 1e-3, "{pose:?}");
    }
}

#[test]
fn a_turned_and_moved_surface_has_the_turned_and_moved_path() {
    let reference = reference();
    let turn = DMat3::from_euler(glam::EulerRot::XYZ, 0.7, -1.1, 2.3);
    let moved = |p: DVec3| turn * p + DVec3::new(5.0, -40.0, 11.0);
    let guide = |key: &str, f: &dyn Fn(DVec3) -> DVec3| GuideCurve::Bezier {
        points: points(&reference["surfaces"]["A"][key]).into_iter().map(f).collect(),
    };
    let params = FlankParams { grid: [30, 12], rounds: 0, ..FlankParams::default() };
    let cutter = FlankCutter::cone(1.0, 5.0, 30.0);
    let [here, there] = [&|p: DVec3| p, &moved as &dyn Fn(DVec3) -> DVec3].map(|f| {
        let surface = RuledSurface::from_guides(&guide("B1", f), &guide("B2", f), Side::Positive).unwrap();
        planned(&surface, &cutter, &params).unwrap()
    });
    assert!((here.chosen.deviation.sum / there.chosen.deviation.sum - 1.0).abs() < 1e-6);
    for (a, b) in here.chosen.poses.iter().zip(&there.chosen.poses) {
        close(moved(a.tip), b.tip, 1e-5);
        close(turn * a.axis, b.axis, 1e-6);
    }
}

#[test]
fn objectives_do_what_they_say() {
    let reference = reference();
    let (surface, cutter, figures) = case(&reference, "cone_r1_a5_A");
    let (grid, start) = covered_start(&surface, &cutter, &figures, [40, 20]);
    let of = |objective| {
        let task = Task::default();
        let heights = Heights::of(&start, &cutter);
        refine(&grid, &start, (&cutter, &heights), (objective, 80, 0.5), &task).unwrap().deviation
    };
    let (sum, rms) = (of(Objective::Sum), of(Objective::Rms));
    assert!(sum.sum < rms.sum && rms.rms < sum.rms, "{} {} {} {}", sum.sum, rms.sum, rms.rms, sum.rms);
    let clear = of(Objective::Bounded { overcut_mm: Some(0.0), undercut_mm: None });
    assert!(clear.most_overcut > -1e-5, "no overcut: {}", clear.most_overcut);
    let flat = of(Objective::Bounded { overcut_mm: None, undercut_mm: Some(0.02) });
    assert!(flat.most_undercut < 0.02 + 1e-5 && sum.most_undercut > 0.021, "{}", flat.most_undercut);
    assert!(flat.sum < 1.02 * sum.sum, "a bound that costs little");
}

#[test]
fn a_bound_on_overcut_holds_for_the_moving_cutter_too() {
    let objective = Objective::Bounded { overcut_mm: Some(0.0), undercut_mm: None };
    for name in ["cone_r1_a5_A", "cone_r1_a5_B"] {
        let (surface, cutter, figures) = case(&reference(), name);
        let (grid, start) = covered_start(&surface, &cutter, &figures, [40, 20]);
        let heights = Heights::of(&start, &cutter);
        let path = refine(&grid, &start, (&cutter, &heights), (objective, 60, 0.5), &Task::default()).unwrap();
        let moving = envelope::check(&grid, &path.axis, &cutter, (&path.deviation, &path.feet)).deviation;
        let worst = [moving.most_overcut, path.deviation.most_overcut];
        assert!(worst.iter().all(|e| *e > -1e-5), "{name}: {worst:?} {}", path.deviation.sum);
    }
}

#[test]
fn the_same_plan_comes_from_any_number_of_threads() {
    let (surface, cutter, _) = case(&reference(), "cone_r1_a5_B");
    let params = FlankParams { grid: [40, 20], rounds: 20, ..FlankParams::default() };
    let of = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| planned(&surface, &cutter, &params).unwrap())
    };
    let (one, three) = (of(1), of(3));
    assert!(one == three, "bit for bit");
}

#[test]
fn reaching_below_moves_the_bottom_along_the_axis_and_nothing_else() {
    let (surface, whole, _) = case(&reference(), "cone_r1_a5_A");
    let params = FlankParams { grid: [30, 12], rounds: 0, below_mm: 1.5, ..FlankParams::default() };
    let longer = FlankCutter { radius_mm: whole.radius_at(-1.5), length_mm: whole.length_mm + 1.5, ..whole.clone() };
    let below = planned(&surface, &longer, &params).unwrap();
    let flush = planned(&surface, &whole, &FlankParams { below_mm: 0.0, ..params }).unwrap();
    assert!((below.chosen.deviation.sum / flush.chosen.deviation.sum - 1.0).abs() < 1e-6);
    for (a, b) in below.chosen.poses.iter().zip(&flush.chosen.poses) {
        close(a.tip + 1.5 * a.axis, b.tip, 1e-6);
    }
    assert!(below.chosen.coverage.height_range_mm[0] > 1.4);
}

#[test]
fn past_its_ends_a_path_cuts_no_more_than_the_cutter_that_stands_there() {
    for name in ["cone_r1_a5_A", "cyl_R2_B"] {
        let (surface, cutter, _) = case(&reference(), name);
        let params = FlankParams { grid: [41, 7], rounds: 0, is_covering: false, ..FlankParams::default() };
        let path = planned(&surface, &cutter, &params).unwrap().chosen;
        let [first, last] = path.envelope.t_range;
        assert!((first < -1e-3 || last > 1.001) && !path.coverage.is_whole, "{name}: {first} {last}");
        let grid = DesignGrid::new(&surface, params.grid);
        let cutter = cutter.above(params.below_mm).unwrap();
        for (k, place) in grid.places().enumerate() {
            let swept = swept_above(&path.axis, &cutter, (place.point, place.normal), [-2.0, 40.0], 100);
            let moving = path.envelope.deviation.values[k];
            assert!(swept.is_none_or(|swept| (swept - moving).abs() < 1e-5), "{name} {k}: {swept:?} {moving}");
        }
    }
}

#[test]
fn a_path_that_ends_where_the_cutter_stands_but_does_not_graze_yet_covers_not_all() {
    use crate::path::FlankPath;
    let mut beyond = 0;
    for name in ["cone_r1_a5_A", "cone_r1_a5_B", "cyl_R2_B"] {
        let (surface, cutter, _) = case(&reference(), name);
        let params = FlankParams { control_points: 4, grid: [30, 12], rounds: 0, ..FlankParams::default() };
        let whole = planned(&surface, &cutter, &params).unwrap().initial.axis;
        let grid = DesignGrid::new(&surface, params.grid);
        let cutter = cutter.above(params.below_mm).unwrap();
        let [first, last] = Measured::new(&grid, whole.clone(), &cutter, None).unwrap().feet.t_range();
        // The same cubics from the first foot to the last: control points from four places of each.
        let part = |i: usize| whole.at(first + (last - first) * i as f64 / 3.0);
        let cubic = |of: &dyn Fn(usize) -> DVec3| {
            let f: [DVec3; 4] = std::array::from_fn(of);
            let inner = |f: [DVec3; 4]| (-5.0 * f[0] + 18.0 * f[1] - 9.0 * f[2] + 2.0 * f[3]) / 6.0;
            vec![f[0], inner(f), inner([f[3], f[2], f[1], f[0]]), f[3]]
        };
        let range = [first, last].map(|t| whole.u0(t));
        let axis = AxisSurface::new(cubic(&|i| part(i).tip), cubic(&|i| part(i).top), range).unwrap();
        let measured = Measured::new(&grid, axis, &cutter, None).unwrap();
        let [first, last] = measured.feet.t_range();
        assert!(first.abs() < 1e-9 && (last - 1.0).abs() < 1e-9, "feet at both ends: {first} {last}");
        let covers = measured.covers();
        let path = FlankPath::of(&grid, &cutter, measured, (5, 0.0));
        let [first, last] = path.envelope.t_range;
        if first < -1e-6 || last > 1.0 + 1e-6 {
            assert!(!path.coverage.is_whole && !covers, "{name}: {first} {last}");
            beyond += 1;
        }
    }
    assert!(beyond > 0, "where cutter and surface lean, they graze beside the foot");
}
