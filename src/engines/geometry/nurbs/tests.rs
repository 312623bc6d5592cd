use glam::DVec3;
use proptest::prelude::*;

use super::*;

fn points(flat: &[f64]) -> Vec<DVec3> {
    flat.chunks_exact(3).map(|c| DVec3::new(c[0], c[1], c[2])).collect()
}

/// A curve that turns and climbs, for points to lie on.
fn spiral(t: f64) -> DVec3 {
    DVec3::new(20.0 * t, 6.0 * (2.0 * t).sin(), 100.0 + 3.0 * t * t)
}

#[test]
fn a_rational_quadratic_is_a_circle_to_rounding() {
    // Nine control points on a square, weights 1 and the cosine of half a right angle.
    let corners = [(1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1), (1, 0)];
    let radius = 7.5;
    let control: Vec<DVec3> = corners.map(|(x, y)| radius * DVec3::new(f64::from(x), f64::from(y), 0.0)).to_vec();
    let weights: Vec<f64> = (0..9).map(|i| if i % 2 == 0 { 1.0 } else { 0.5f64.sqrt() }).collect();
    let knots = [0.0, 0.0, 0.0, 0.25, 0.25, 0.5, 0.5, 0.75, 0.75, 1.0, 1.0, 1.0].to_vec();
    let circle = NurbsCurve::new(KnotVector::new(2, knots).unwrap(), &control, &weights).unwrap();
    for i in 0..=400 {
        let [point, slope, bend] = circle.at(f64::from(i) / 400.0);
        assert!((point.length() - radius).abs() < 1e-12, "{}", point.length());
        assert!(point.dot(slope).abs() < 1e-9, "the tangent is square to the radius");
        // The curvature of a circle, from both derivatives.
        let curvature = slope.cross(bend).length() / slope.length().powi(3);
        assert!((curvature - 1.0 / radius).abs() < 1e-9, "{curvature}");
    }
    assert!((circle.length(0.0, 1.0) - std::f64::consts::TAU * radius).abs() < 1e-6);
    let away = DVec3::new(3.0, -4.0, 2.0);
    let near = circle.nearest(away);
    assert!((near.point - DVec3::new(0.6, -0.8, 0.0) * radius).length() < 1e-9, "{near:?}");
}

#[test]
fn a_stretch_of_a_curve_is_the_curve_there() {
    let points: Vec<DVec3> = (0..12).map(|i| spiral(f64::from(i) / 11.0)).collect();
    let weights: Vec<f64> = (0..12).map(|i| 1.0 + 0.5 * f64::from(i % 3)).collect();
    let inner = vec![0.1, 0.2, 0.4, 0.4, 0.5, 0.7, 0.7, 0.7];
    let curve = NurbsCurve::new(KnotVector::clamped(3, 0.0, inner, 1.0).unwrap(), &points, &weights).unwrap();
    for [from, to] in [[0.0, 1.0], [0.05, 0.95], [0.4, 0.7], [0.41, 0.43], [0.2, 1.0]] {
        let stretch = curve.between(from, to).unwrap();
        assert_eq!(stretch.domain(), [from, to]);
        for i in 0..=50 {
            let u = from + (to - from) * f64::from(i) / 50.0;
            assert!(stretch.point(u).distance(curve.point(u)) < 1e-12, "at {u} of {from} to {to}");
        }
    }
    assert!(curve.between(0.5, 0.5).is_err());
}

#[test]
fn without_inner_knots_it_is_a_bezier_curve() {
    let control = points(&[0.0, 0.0, 1.0, 2.0, 5.0, -1.0, 4.0, -3.0, 0.5, 7.0, 1.0, 2.0, 8.0, 8.0, 0.0]);
    let weights = [1.0, 0.7, 2.0, 1.3, 0.9];
    let knots = KnotVector::new(4, [[0.0; 5], [1.0; 5]].concat()).unwrap();
    let curve = NurbsCurve::new(knots, &control, &weights).unwrap();
    for i in 0..=50 {
        let t = f64::from(i) / 50.0;
        let bernstein = |k: i32| [1.0, 4.0, 6.0, 4.0, 1.0][k as usize] * t.powi(k) * (1.0 - t).powi(4 - k);
        let share: Vec<f64> = (0..5).map(|k| bernstein(k) * weights[k as usize]).collect();
        let sum: f64 = share.iter().sum();
        let expected: DVec3 = control.iter().zip(&share).map(|(p, s)| *p * (s / sum)).sum();
        assert!((curve.point(t) - expected).length() < 1e-12);
    }
}

#[test]
fn derivatives_are_the_limits_of_differences() {
    let line: Vec<DVec3> = (0..12).map(|i| spiral(0.1 * f64::from(i * i) / 12.0)).collect();
    for degree in 2..=5 {
        let curve = NurbsCurve::through(&line, degree).unwrap();
        for u in [0.05, 0.37, 0.5, 0.81] {
            let h = 1e-5;
            let [before, here, after] = [u - h, u, u + h].map(|u| curve.at(u));
            let [slope, bend] = [(after[0] - before[0]) / (2.0 * h), (after[1] - before[1]) / (2.0 * h)];
            assert!((slope - here[1]).length() < 1e-5 * (1.0 + here[1].length()), "degree {degree}");
            assert!((bend - here[2]).length() < 1e-4 * (1.0 + here[2].length()), "degree {degree}");
        }
    }
}

#[test]
fn a_cubic_through_points_keeps_its_end_tangents_and_bends_continuously() {
    let line: Vec<DVec3> = [0.0, 0.1, 0.25, 0.6, 0.7, 1.1, 1.2, 1.5].map(spiral).to_vec();
    let ends = [DVec3::new(30.0, 1.0, -2.0), DVec3::new(12.0, -20.0, 5.0)];
    let curve = NurbsCurve::cubic(&line, Some(ends)).unwrap();
    for (p, u) in line.iter().zip(chord_parameters(&line).unwrap()) {
        assert!((curve.point(u) - *p).length() < 1e-11);
    }
    assert!((curve.at(0.0)[1] - ends[0]).length() < 1e-10 && (curve.at(1.0)[1] - ends[1]).length() < 1e-10);
    let joints = curve.knots().joints();
    assert_eq!(joints.len(), 8, "as many pieces as point spacings");
    for &u in &joints[1..joints.len() - 1] {
        let [left, right] = [u - 1e-9, u + 1e-9].map(|u| curve.at(u));
        let scale = 1.0 + right[2].length();
        assert!((left[1] - right[1]).length() < 1e-5 * scale && (left[2] - right[2]).length() < 1e-5 * scale);
    }
}

/// A quarter of a circle is the quotient of two polynomials: (1 - t^2, 2 t) / (1 + t^2).
#[test]
fn with_the_weights_of_a_circle_its_points_give_the_circle() {
    let t = [0.0, 0.2, 0.45, 0.7, 1.0];
    let points = t.map(|t: f64| DVec3::new((1.0 - t * t) / (1.0 + t * t), 2.0 * t / (1.0 + t * t), 0.0));
    let shape = LineShape { weights: t.map(|t| 1.0 + t * t).to_vec(), ends: [None; 2] };
    let circle = NurbsCurve::rational_at(&t, &points, &shape).unwrap();
    let off = |curve: &NurbsCurve| {
        (0..=100).map(|i| (curve.point(f64::from(i) / 100.0).length() - 1.0).abs()).fold(0.0, f64::max)
    };
    assert!(off(&circle) < 1e-12);
    let equal = NurbsCurve::rational_at(&t, &points, &LineShape::default()).unwrap();
    assert!(off(&equal) > 1e-4);
    // Weights of one are none.
    let ones = LineShape { weights: vec![1.0; 5], ends: [None; 2] };
    let ones = NurbsCurve::rational_at(&t, &points, &ones).unwrap();
    assert!((0..=50).all(|i| ones.point(f64::from(i) / 50.0).distance(equal.point(f64::from(i) / 50.0)) < 1e-14));
    for weights in [vec![1.0; 4], vec![1.0, 1.0, 1e6, 1.0, 1.0]] {
        assert!(NurbsCurve::rational(&points, &LineShape { weights, ends: [None; 2] }).is_err());
    }
}

#[test]
fn sections_are_skinned_with_their_weights_and_end_directions() {
    let section = |z: f64| (0..7).map(|i| spiral(0.2 * f64::from(i)) + DVec3::Z * z).collect::<Vec<_>>();
    let sections = [0.0, 4.0, 9.0, 15.0].map(section).to_vec();
    let way = DVec3::new(0.3, 1.0, 0.1);
    let shape = |k: usize| LineShape {
        weights: (0..7).map(|i| 1.0 + 0.1 * ((i + k) % 3) as f64).collect(),
        ends: [Some(way), (k > 1).then_some(-way)],
    };
    let shapes: Vec<LineShape> = (0..4).map(shape).collect();
    let (surface, [u, v]) = NurbsSurface::skinned_as(&sections, &shapes).unwrap();
    let (plain, _) = NurbsSurface::skinned(&sections).unwrap();
    for (section, v) in sections.iter().zip(&v) {
        for (p, u) in section.iter().zip(&u) {
            assert!((surface.point(*u, *v) - *p).length() < 1e-10);
        }
        let [_, along, _] = surface.at(0.0, *v);
        assert!(along.angle_between(way) < 1e-6);
        assert!(plain.at(0.0, *v)[1].angle_between(way) > 0.01);
        assert!(surface.point(0.5 * (u[2] + u[3]), *v).distance(plain.point(0.5 * (u[2] + u[3]), *v)) > 1e-6);
    }
    assert!(surface.at(1.0, v[3])[1].angle_between(-way) < 1e-6 && surface.at(1.0, v[0])[1].angle_between(-way) > 0.01);
}

#[test]
fn a_cubic_polynomial_is_reproduced() {
    let cubic = |t: f64| DVec3::new(1.0 + t * t * t, 2.0 * t - 3.0 * t * t, 4.0 - t + 0.5 * t * t * t);
    let slope = |t: f64| DVec3::new(3.0 * t * t, 2.0 - 6.0 * t, -1.0 + 1.5 * t * t);
    let t = [0.0, 0.15, 0.2, 0.55, 0.7, 1.0];
    let with_ends = NurbsCurve::through_at(&t, &t.map(cubic), 3, Some([slope(0.0), slope(1.0)])).unwrap();
    let without = NurbsCurve::through_at(&t, &t.map(cubic), 3, None).unwrap();
    // Parabolas at the ends reproduce a parabola.
    let two =
        NurbsCurve::through_at(&[0.0, 1.0], &[cubic(0.0), cubic(1.0)], 3, Some([slope(0.0), slope(1.0)])).unwrap();
    for i in 0..=60 {
        let u = f64::from(i) / 60.0;
        for curve in [&with_ends, &without, &two] {
            assert!((curve.point(u) - cubic(u)).length() < 1e-12);
            assert!((curve.at(u)[1] - slope(u)).length() < 1e-10);
        }
    }
}

#[test]
fn a_function_reproduces_polynomials_of_its_degree_and_bounds_its_bend() {
    let quartic = |t: f64| 1.0 - t + 0.5 * t.powi(3) - 0.1 * t.powi(4);
    let t = [0.0, 0.5, 1.0, 1.25, 2.0, 2.5, 4.0];
    let exact = BSpline::through(&t, &t.map(quartic), 4).unwrap();
    for i in 0..=80 {
        let x = 0.05 * f64::from(i);
        let [value, slope, bend] = exact.at(x);
        assert!((value - quartic(x)).abs() < 1e-11);
        assert!((slope - (-1.0 + 1.5 * x * x - 0.4 * x.powi(3))).abs() < 1e-10);
        assert!((bend - (3.0 * x - 1.2 * x * x)).abs() < 1e-9);
    }
    for (x, y) in [(vec![0.0, 2.0], vec![1.0, 5.0]), (vec![0.0, 1.0, 3.0], vec![0.0, 1.0, 9.0])] {
        let few = BSpline::through(&x, &y, 3).unwrap();
        let expected = if x.len() == 2 { 4.0 } else { 2.25 };
        assert!((few.at(1.5)[0] - expected).abs() < 1e-12, "a line, a parabola");
    }
}

#[test]
fn a_flat_grid_gives_a_flat_surface_with_straight_parameters() {
    let at = |x: f64, y: f64| DVec3::new(x, y, 2.0 + 0.5 * x - 0.25 * y);
    let (xs, ys) = ([0.0, 1.0, 1.5, 4.0, 6.0], [0.0, 2.0, 3.0, 3.5]);
    let sections: Vec<Vec<DVec3>> = ys.iter().map(|y| xs.iter().map(|x| at(*x, *y)).collect()).collect();
    let (surface, [u, v]) = NurbsSurface::skinned(&sections).unwrap();
    assert!(xs.iter().zip(&u).all(|(x, u)| (x / 6.0 - u).abs() < 1e-14));
    assert!(ys.iter().zip(&v).all(|(y, v)| (y / 3.5 - v).abs() < 1e-14));
    for i in 0..=20 {
        let (u, v) = (f64::from(i) / 20.0, f64::from(20 - i) / 20.0);
        assert!((surface.point(u, v) - at(6.0 * u, 3.5 * v)).length() < 1e-12);
        let normal = DVec3::new(-0.5, 0.25, 1.0).normalize();
        assert!((surface.normal(u, v) - normal).length() < 1e-12);
    }
}

#[test]
fn a_skinned_surface_meets_its_points_and_nears_a_cylinder() {
    let radius = 40.0;
    let at = |angle: f64, z: f64| DVec3::new(radius * angle.cos(), radius * angle.sin(), z);
    let error = |n: u32| {
        let turn = |i: u32| 1.2 * f64::from(i) / f64::from(n - 1);
        let sections: Vec<Vec<DVec3>> = (0..5u32)
            .map(|j| (0..n).map(|i| at(turn(i) + 0.05 * f64::from(j), 3.0 * f64::from(j))).collect())
            .collect();
        let (surface, [u, v]) = NurbsSurface::skinned(&sections).unwrap();
        for (section, v) in sections.iter().zip(&v) {
            let off = section.iter().zip(&u).map(|(p, u)| (surface.point(*u, *v) - *p).length());
            assert!(FitError::of(off).greatest_mm < 1e-10);
        }
        FitError::of((0..=1000).map(|i| {
            let p = surface.point(f64::from(i % 101) / 100.0, f64::from(i) / 1000.0);
            p.truncate().length() - radius
        }))
    };
    let (coarse, fine) = (error(9), error(17));
    assert!(fine.greatest_mm < 1e-3 && fine.rms_mm < fine.greatest_mm && fine.points == 1001, "{fine:?}");
    // Half the spacing: an eighth of the error at least, since the end tangents are good to second order.
    assert!(fine.greatest_mm < coarse.greatest_mm / 7.0, "{coarse:?} {fine:?}");
}

#[test]
fn curves_on_a_surface_are_the_surface_there() {
    let sections: Vec<Vec<DVec3>> = (0..4)
        .map(|k| (0..9).map(|i| spiral(f64::from(i) / 8.0) + f64::from(k * k) * DVec3::new(0.1, 1.0, 3.0)).collect())
        .collect();
    let (surface, _) = NurbsSurface::skinned(&sections).unwrap();
    for i in 0..=20 {
        let (along, across) = (f64::from(i) / 20.0, 0.37);
        let place = |k: usize, x: f64| surface.domain()[k][0] * (1.0 - x) + surface.domain()[k][1] * x;
        let (u, v) = (place(0, along), place(1, across));
        assert!(surface.curve(0, v).point(u).distance(surface.point(u, v)) < 1e-12);
        let (u, v) = (place(0, across), place(1, along));
        assert!(surface.curve(1, u).point(v).distance(surface.point(u, v)) < 1e-12);
    }
}

#[test]
fn bad_input_is_refused_with_its_place() {
    let p = [DVec3::ZERO, DVec3::X, DVec3::X, DVec3::Y];
    assert_eq!(NurbsCurve::through(&p, 3), Err(NurbsError::Coincident(2)));
    assert_eq!(NurbsCurve::through(&p[..1], 3), Err(NurbsError::Counts));
    assert_eq!(NurbsCurve::through(&p[..2], MAX_DEGREE + 1), Err(NurbsError::Degree(MAX_DEGREE + 1)));
    assert_eq!(BSpline::through(&[0.0, 1.0, 1.0], &[0.0; 3], 3), Err(NurbsError::Coincident(2)));
    assert_eq!(BSpline::through(&[0.0, f64::NAN], &[0.0; 2], 3), Err(NurbsError::Coincident(1)));
    assert_eq!(KnotVector::new(1, vec![0.0, 0.0, 0.5, 0.4, 1.0, 1.0]), Err(NurbsError::Knots(3)));
    assert_eq!(KnotVector::new(2, vec![0.0, 0.0, 0.0, 0.5, 0.5, 0.5, 1.0, 1.0, 1.0]), Err(NurbsError::Knots(5)));
    assert_eq!(KnotVector::new(1, vec![0.0, 0.1, 0.5, 1.0]), Err(NurbsError::Knots(0)), "not clamped");
    let line = || KnotVector::new(1, vec![0.0, 0.0, 1.0, 1.0]).unwrap();
    assert_eq!(NurbsCurve::new(line(), &p[..2], &[1.0, 0.0]), Err(NurbsError::Value(1)));
    assert_eq!(NurbsCurve::new(line(), &[DVec3::NAN, DVec3::X], &[1.0; 2]), Err(NurbsError::Value(0)));
    assert_eq!(NurbsSurface::skinned(&[p[..2].to_vec()]), Err(NurbsError::Counts));
}

#[test]
fn a_foot_between_the_places_looked_at_is_found() {
    // A curve that swings so far that a nearer foot hides between its first looks.
    let flat = [[0.0, 0.0, 4.1, 5.6, 2.6, -4.4, -3.5, -5.7, -8.5], [5.4, 7.3, 9.3, 6.5, -3.4, -3.8, 7.0, -2.1, 2.4]];
    let curve = NurbsCurve::through(&points(&flat.concat()), 3).unwrap();
    for i in 0..200 {
        let p = DVec3::new(f64::from(i % 20) - 10.0, f64::from(i / 20 * 2) - 10.0, f64::from(i % 7) - 3.0);
        let best = (0..=20_000).map(|k| curve.point(f64::from(k) / 20_000.0).distance(p)).fold(f64::INFINITY, f64::min);
        let near = curve.nearest(p);
        assert!(
            near.distance <= best + NurbsCurve::NEAR * curve.extent(),
            "{} instead of {best} from {p}",
            near.distance
        );
    }
}

proptest! {
    #[test]
    fn an_interpolation_meets_its_points(
        steps in prop::collection::vec(0.1..3.0f64, 3..30),
        values in prop::collection::vec(-5.0..5.0f64, 30),
        degree in 3usize..=5,
    ) {
        let t: Vec<f64> = steps.iter().scan(0.0, |s, h| { *s += h; Some(*s) }).collect();
        let f = BSpline::through(&t, &values[..t.len()], degree).unwrap();
        for (i, &x) in t.iter().enumerate() {
            let scale = 1.0 + (0..=50).map(|k| f.at(t[0] + (t[t.len() - 1] - t[0]) * f64::from(k) / 50.0)[0].abs()).fold(0.0, f64::max);
            prop_assert!((f.at(x)[0] - values[i]).abs() < 1e-9 * scale);
        }
        for i in 0..t.len() - 1 {
            let bound = f.greatest_second(i);
            for k in 0..=10 {
                let x = t[i] + (t[i + 1] - t[i]) * f64::from(k) / 10.0;
                prop_assert!(f.at(x)[2].abs() <= bound * (1.0 + 1e-9) + 1e-9, "{} > {bound}", f.at(x)[2].abs());
            }
        }
    }

    #[test]
    fn the_nearest_point_is_nearer_than_any_other(
        flat in prop::collection::vec(-10.0..10.0f64, 18),
        p in prop::array::uniform3(-12.0..12.0f64),
    ) {
        let curve = NurbsCurve::through(&points(&flat), 3).unwrap();
        let p = DVec3::from_array(p);
        let near = curve.nearest(p);
        prop_assert!((curve.point(near.u) - near.point).length() < 1e-12);
        let best = (0..=4000).map(|i| curve.point(f64::from(i) / 4000.0).distance(p)).fold(f64::INFINITY, f64::min);
        let bound = best + NurbsCurve::NEAR * curve.extent();
        prop_assert!(near.distance <= bound, "{} instead of {best}", near.distance);
        let [point, slope, _] = curve.at(near.u);
        let inside = near.u > 1e-12 && near.u < 1.0 - 1e-12;
        prop_assert!(!inside || (point - p).dot(slope).abs() < 1e-6 * (1.0 + slope.length()), "a perpendicular");
    }
}
