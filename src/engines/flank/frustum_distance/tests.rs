//! Distances against golden sections nested in each other, dense sampling and figures by hand, and how many cuts they
//! take.

use proptest::prelude::*;

use super::*;
use geometry::triangle_distance::triangle_distance;

/// The least distance over a triangle, where, and at how many places it was asked for.
fn counted(corners: [DVec3; 3], frustum: &Frustum, pose: &FlankPose, most: f64) -> (Option<(f64, DVec3)>, usize) {
    let mut count = 0;
    let found = least_over(corners, most, |p| {
        count += 1;
        frustum.distance(pose, p)
    });
    (found, count)
}

/// The least value of a convex function from 0 to 1, by golden section.
fn golden(f: impl Fn(f64) -> f64) -> f64 {
    let share = 0.5 * (5.0f64.sqrt() - 1.0);
    let (mut low, mut high) = (0.0, 1.0);
    let [mut s, mut t] = [1.0 - share, share];
    let [mut at_s, mut at_t] = [f(s), f(t)];
    let mut least = f(0.0).min(f(1.0)).min(at_s).min(at_t);
    for _ in 0..50 {
        if at_s < at_t {
            (high, t, at_t) = (t, s, at_s);
            s = high - share * (high - low);
            at_s = f(s);
        } else {
            (low, s, at_s) = (s, t, at_t);
            t = low + share * (high - low);
            at_t = f(t);
        }
        least = least.min(at_s).min(at_t);
    }
    least
}

/// Distance of a triangle, by golden sections nested in each other.
fn by_golden_sections([a, b, c]: [DVec3; 3], frustum: &Frustum, pose: &FlankPose) -> f64 {
    golden(|s| golden(|t| frustum.distance(pose, a.lerp(b.lerp(c, t), s)).0))
}

fn vector(size: f64) -> impl Strategy<Value = DVec3> {
    [-size..size, -size..size, -size..size].prop_map(DVec3::from_array)
}

/// A cone or cylinder of any taper, tip and axis.
fn tool() -> impl Strategy<Value = (Frustum, FlankPose)> {
    let radius = || prop_oneof![Just(2.0), 0.0..6.0];
    let axis = vector(1.0).prop_filter("a direction", |v| v.length() > 0.1).prop_map(DVec3::normalize);
    (-2.0..2.0, 0.5..30.0, [radius(), radius()], vector(5.0), axis).prop_map(|(low, length, radii, tip, axis)| {
        (Frustum { heights: [low, low + length], radii }, FlankPose { t: 0.0, tip, axis })
    })
}

/// Triangles of every size, slivers and points among them.
fn triangle() -> impl Strategy<Value = [DVec3; 3]> {
    let size = prop_oneof![Just(0.0), Just(1e-7), Just(1e-3), 0.01..30.0, Just(400.0)];
    (vector(12.0), [vector(1.0), vector(1.0)], [size.clone(), size])
        .prop_map(|(a, [b, c], [of_b, of_c])| [a, a + of_b * b, a + of_b * b + of_c * c])
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn the_distance_to_a_triangle_is_that_of_nested_golden_sections((frustum, pose) in tool(), corners in triangle()) {
        let (found, count) = counted(corners, &frustum, &pose, f64::INFINITY);
        let (distance, place) = found.unwrap();
        let wanted = by_golden_sections(corners, &frustum, &pose);
        prop_assert!((distance - wanted).abs() < EXACT + 1e-6, "{distance} {wanted}");
        prop_assert!(count <= 80, "{count} places were looked at");
        prop_assert!((frustum.distance(&pose, place).0 - distance).abs() < 1e-12, "the place named is where it is");
        let off = triangle_distance(&corners, &[place; 3]).distance;
        prop_assert!(off < 1e-6, "{off} mm off the triangle");
    }

    #[test]
    fn nothing_of_a_triangle_is_nearer_by_dense_sampling((frustum, pose) in tool(), corners in triangle()) {
        const N: u32 = 60;
        let [a, b, c] = corners;
        let (distance, _) = nearest_on(corners, &frustum, &pose, f64::INFINITY).unwrap();
        let share = |k: u32| f64::from(k) / f64::from(N);
        let shares = (0..=N).flat_map(|i| (0..=N - i).map(move |j| (share(i), share(j))));
        let at = |(s, t): (f64, f64)| frustum.distance(&pose, a + s * (b - a) + t * (c - a)).0;
        let sampled = shares.map(at).fold(f64::INFINITY, f64::min);
        prop_assert!(distance < sampled + EXACT, "{distance} {sampled}");
        // A place is at most this far from a sample, and the distance changes by no more than the way.
        let step = (a.distance(b) + a.distance(c)) * share(1);
        prop_assert!(distance > sampled - step - 1e-9, "{distance} {sampled} {step}");
    }

    #[test]
    fn what_is_not_nearer_than_asked_is_not_answered((frustum, pose) in tool(), corners in triangle(), less in 0.0..5.0) {
        let (distance, _) = nearest_on(corners, &frustum, &pose, f64::INFINITY).unwrap();
        prop_assert_eq!(nearest_on(corners, &frustum, &pose, distance - less - EXACT), None);
        let found = nearest_on(corners, &frustum, &pose, distance + less + 2.0 * EXACT).map(|f| f.0);
        prop_assert!(found.is_some_and(|f| (f - distance).abs() < 2.0 * EXACT), "{found:?} {distance}");
    }
}

const UPRIGHT: FlankPose = FlankPose { t: 0.0, tip: DVec3::ZERO, axis: DVec3::Z };

/// A rod of 2 mm, 10 mm long.
const ROD: Frustum = Frustum { heights: [0.0, 10.0], radii: [2.0, 2.0] };

#[test]
fn large_faces_and_slivers_along_the_flutes_take_few_cuts() {
    let p = |x, y, z| DVec3::new(x, y, z);
    // All are parallel to the axis, so that a line of them is nearest.
    let cases = [
        ("a face of 400 mm, touched", [p(2.0, -200.0, -200.0), p(2.0, 200.0, -200.0), p(2.0, 0.0, 200.0)], 0.0),
        (
            "the same, 0.0005 mm deep",
            [p(1.9995, -200.0, -200.0), p(1.9995, 200.0, -200.0), p(1.9995, 0.0, 200.0)],
            -5e-4,
        ),
        ("a strip as of a fillet", [p(2.1, 0.15, 0.0), p(2.1, -0.15, 0.0), p(2.1, 0.15, 10.0)], 0.1),
        ("a sliver", [p(1.0, 1e-7, -50.0), p(1.0, -1e-7, -50.0), p(1.0, 0.0, 60.0)], -1.0),
        ("an edge", [p(1.5, 0.0, -5.0), p(1.5, 0.0, 15.0), p(1.5, 0.0, 1.0)], -0.5),
        ("a point", [p(0.0, 0.0, 11.0); 3], 1.0),
        ("the bottom's plane", [p(-300.0, -300.0, 0.0), p(300.0, -300.0, 0.0), p(0.0, 300.0, 0.0)], 0.0),
        ("a plane across", [p(-300.0, -300.0, 5.0), p(300.0, -300.0, 5.0), p(0.0, 300.0, 5.0)], -2.0),
        ("a corner within", [p(1.5, 0.0, 5.0), p(11.5, 6.0, 5.0), p(11.5, -6.0, 5.0)], -0.5),
    ];
    for (name, corners, wanted) in cases {
        let (found, count) = counted(corners, &ROD, &UPRIGHT, 50.0);
        let distance = found.unwrap().0;
        assert!((distance - wanted).abs() < EXACT + 1e-12, "{name}: {distance} {wanted}");
        assert!(count <= 60, "{name}: {count} places were looked at");
    }
}

#[test]
fn a_triangle_that_is_too_far_costs_one_look() {
    let far = [DVec3::new(30.0, -5.0, 0.0), DVec3::new(30.0, 5.0, 0.0), DVec3::new(30.0, 0.0, 9.0)];
    assert_eq!(counted(far, &ROD, &UPRIGHT, 20.0), (None, 1));
}

#[test]
fn what_is_not_finite_ends_without_an_answer() {
    let broken = [DVec3::NAN, DVec3::ZERO, DVec3::X];
    assert_eq!(nearest_on(broken, &ROD, &UPRIGHT, 50.0), None);
}
