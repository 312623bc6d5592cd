use glam::{DQuat, DVec3};
use proptest::prelude::*;

use super::*;
use geometry::nurbs::KnotVector;
use task::{Cancel, Progress, Task};

/// Points and normals over the unit square.
type Form = dyn Fn(f64, f64) -> DVec3;

/// A solid whose first triangles, as many as answered, tessellate `form` by a grid; the rest closes it, `thick` behind.
fn solid(form: &Form, [nu, nv]: [usize; 2], thick: f64) -> (Mesh, Vec<u32>) {
    let at = |i: usize, n: usize| i as f64 / n as f64;
    let normal = |u: f64, v: f64| {
        let h = 1e-6;
        let (du, dv) = (form(u + h, v) - form(u - h, v), form(u, v + h) - form(u, v - h));
        du.cross(dv).normalize()
    };
    let places: Vec<[f64; 2]> = (0..=nu).flat_map(|i| (0..=nv).map(move |j| [at(i, nu), at(j, nv)])).collect();
    let mut vertices: Vec<DVec3> = places.iter().map(|p| form(p[0], p[1])).collect();
    vertices.extend(places.iter().map(|p| form(p[0], p[1]) - normal(p[0], p[1]) * thick));
    let far = places.len() as u32;
    let number = |i: usize, j: usize| (i * (nv + 1) + j) as u32;
    let mut triangles = Vec::new();
    for i in 0..nu {
        for j in 0..nv {
            let [a, b, c, d] = [number(i, j), number(i + 1, j), number(i + 1, j + 1), number(i, j + 1)];
            triangles.extend(if (i + j) % 2 == 0 { [[a, b, c], [a, c, d]] } else { [[a, b, d], [b, c, d]] });
        }
    }
    let front = triangles.len();
    triangles.extend((0..front).map(|t| triangles[t]).map(|[a, b, c]| [a + far, c + far, b + far]).collect::<Vec<_>>());
    let mut wall = |a: u32, b: u32| triangles.extend([[b, a, a + far], [b, a + far, b + far]]);
    (0..nu).for_each(|i| wall(number(i, 0), number(i + 1, 0)));
    (0..nu).for_each(|i| wall(number(i + 1, nv), number(i, nv)));
    (0..nv).for_each(|j| wall(number(0, j + 1), number(0, j)));
    (0..nv).for_each(|j| wall(number(nu, j), number(nu, j + 1)));
    (Mesh { vertices, triangles }, (0..front as u32).collect())
}

fn bezier(points: [[f64; 3]; 4], u: f64) -> DVec3 {
    let w = 1.0 - u;
    let shares = [w * w * w, 3.0 * w * w * u, 3.0 * w * u * u, u * u * u];
    points.iter().zip(shares).map(|(p, s)| DVec3::from_array(*p) * s).sum()
}

const UPPER: [[f64; 3]; 4] = [[73.445, 13.857, 0.0], [81.443, 4.621, 0.0], [92.634, 2.779, 0.0], [105.48, -9.257, 0.0]];
const LOWER_A: [[f64; 3]; 4] = [[70.0, 2.0, -10.0], [81.545, 6.0, -10.0], [92.157, 0.0, -10.0], [109.3, 4.0, -10.0]];
const LOWER_B: [[f64; 3]; 4] = [[79.125, 2.0, -10.0], [84.898, 6.0, -10.0], [90.204, 0.0, -10.0], [98.775, 4.0, -10.0]];

/// Ruled surfaces with their names.
fn ruled_forms() -> Vec<(&'static str, Box<Form>)> {
    let between =
        |a: fn(f64) -> DVec3, b: fn(f64) -> DVec3| -> Box<Form> { Box::new(move |u, v| a(u) * (1.0 - v) + b(u) * v) };
    let arc = |r: f64, z: f64, t: f64| DVec3::new(r * t.cos(), r * t.sin(), z);
    vec![
        ("paper's A", between(|u| bezier(LOWER_A, u), |u| bezier(UPPER, u))),
        ("paper's B", between(|u| bezier(LOWER_B, u), |u| bezier(UPPER, u))),
        (
            "twisted quadrangle",
            between(|u| DVec3::new(30.0 * u, 0.0, 0.0), |u| DVec3::new(2.0 + 26.0 * u, 4.0 * u - 1.0, 10.0 + u)),
        ),
        ("cylinder", Box::new(move |u, v| arc(8.0, 12.0 * v, 2.2 * u))),
        ("cone", Box::new(move |u, v| arc(9.0 - 4.0 * v, 10.0 * v, 1.9 * u))),
        ("helicoid", Box::new(move |u, v| arc(4.0 + 9.0 * v, 20.0 * u, 1.2 * u))),
        (
            "guides run through unevenly",
            between(
                |u| DVec3::new(40.0 * u, 6.0 * (2.0 * u).sin(), 0.0),
                |u| DVec3::new(40.0 * (0.55 * u + 0.45 * u * u), 5.0 * (2.4 * u).cos(), 12.0),
            ),
        ),
    ]
}

fn fitted(form: &Form, tolerance_mm: f64) -> RuledFit {
    let (mesh, front) = solid(form, [48, 5], 3.0);
    fit_ruled(&mesh, &front, &RuledFitParams { tolerance_mm, ..RuledFitParams::default() }, &Cancel::default()).unwrap()
}

/// The paper's surfaces by their own guides: nothing is fitted, so that corners are off by rounding only.
#[test]
fn guides_of_a_cad_face_are_taken_as_they_are() {
    let of = |points: [[f64; 3]; 4]| {
        let points = points.map(DVec3::from_array);
        NurbsCurve::new(KnotVector::new(3, [[2.0; 4], [5.0; 4]].concat()).unwrap(), &points, &[1.0; 4]).unwrap()
    };
    for lower in [LOWER_A, LOWER_B] {
        let form = move |u: f64, v: f64| bezier(lower, u) * (1.0 - v) + bezier(UPPER, u) * v;
        let (mesh, front) = solid(&form, [48, 5], 3.0);
        let given = [of(lower), of(UPPER)];
        let turned = [given[1].reversed(), given[0].reversed()];
        for guides in [given.clone(), turned] {
            let params = RuledFitParams { tolerance_mm: 1e-3, ..RuledFitParams::default() };
            let fit = known_ruled(&mesh, &front, &[guides], &params, &Cancel::default()).unwrap().unwrap();
            assert!(fit.is_known && fit.is_ruled && fit.covers && fit.error_corners.greatest_mm < 1e-9, "{fit:?}");
            assert!(fit.border_mm < 1e-9 && fit.lower.knots().count() == 4, "{fit:?}");
            // The lower guide is the lower edge, and the tool stands outside.
            let [low, along, _] = fit.lower.at(0.3);
            assert!((low.z + 10.0).abs() < 1e-9);
            let outwards = along.cross(fit.upper.point(0.3) - low);
            let out = solid_normal(&form, 0.3);
            assert!(outwards.dot(out) > 0.0);
        }
    }
    // Guides of some other surface are not believed.
    let form = |u: f64, v: f64| bezier(LOWER_A, u) * (1.0 - v) + bezier(UPPER, u) * v;
    let (mesh, front) = solid(&form, [48, 5], 3.0);
    let other = known_ruled(&mesh, &front, &[[of(LOWER_B), of(UPPER)]], &RuledFitParams::default(), &Cancel::default())
        .unwrap();
    assert!(other.is_none());
}

/// The normal of a form at (u, 0), to the side to which `solid` has none of its metal.
fn solid_normal(form: &Form, u: f64) -> DVec3 {
    let h = 1e-6;
    (form(u + h, 0.0) - form(u - h, 0.0)).cross(form(u, h) - form(u, 0.0))
}

/// The greatest distance of places of `form` from the fit, and of both its guides from the edges of `form`, which may
/// be the other way round.
fn off_form(form: &Form, fit: &RuledFit) -> [f64; 2] {
    let edge = |v: f64| -> Vec<DVec3> { (0..=200).map(|i| form(i as f64 / 200.0, v)).collect() };
    let edges = [edge(0.0), edge(1.0)];
    let off = |guide: &NurbsCurve, edge: &[DVec3]| edge.iter().map(|p| guide.nearest(*p).distance).fold(0.0, f64::max);
    let straight = off(&fit.lower, &edges[0]).max(off(&fit.upper, &edges[1]));
    let crossed = off(&fit.lower, &edges[1]).max(off(&fit.upper, &edges[0]));
    let mut most = 0.0f64;
    for i in 0..=23 {
        for j in 0..=3 {
            let p = form(i as f64 / 23.0, j as f64 / 3.0);
            // The tangent plane at the nearest of dense rulings, as good as the surface itself at a hundredth of a mm.
            let at = |k: usize| {
                let u = k as f64 / 4000.0;
                let ([a, da, _], [b, db, _]) = (fit.lower.at(u), fit.upper.at(u));
                let v = ((p - a).dot(b - a) / (b - a).length_squared()).clamp(0.0, 1.0);
                let normal = (da * (1.0 - v) + db * v).cross(b - a).normalize();
                (a + (b - a) * v, normal)
            };
            let near = |k: &usize| at(*k).0.distance(p);
            let coarse = (0..=40).map(|k| 100 * k).min_by(|a, b| near(a).total_cmp(&near(b))).unwrap();
            let around = coarse.saturating_sub(100)..=(coarse + 100).min(4000);
            let (foot, normal) = at(around.min_by(|a, b| near(a).total_cmp(&near(b))).unwrap());
            most = most.max((p - foot).dot(normal).abs());
        }
    }
    [most, straight.min(crossed)]
}

#[test]
fn known_ruled_surfaces_are_found_with_their_borders() {
    for (name, form) in ruled_forms() {
        let fit = fitted(&*form, 2e-3);
        let [surface, border] = off_form(&*form, &fit);
        assert!(fit.is_ruled && fit.words[0].starts_with("ruled within"), "{name}: {:?}", fit.words);
        assert!(fit.error_corners.greatest_mm < 5e-4 && fit.border_mm < 5e-4, "{name}: {fit:?}");
        assert!(surface < 1e-3 && border < 1e-3, "{name}: {surface} {border}");
        // Triangles leave the surface by what their own turning says, and by no more.
        let beyond = fit.error.greatest_mm / fit.chord_mm;
        assert!((0.5..1.2).contains(&beyond), "{name}: {beyond} of {}", fit.chord_mm);
        assert!(fit.error_back.greatest_mm < 1.2 * fit.chord_mm && fit.overhang_mm < 1e-3, "{name}: {fit:?}");
    }
}

/// The normal of a fit in its middle.
fn middle_normal(fit: &RuledFit) -> DVec3 {
    let along = fit.lower.at(0.5)[1] + fit.upper.at(0.5)[1];
    along.cross(fit.upper.point(0.5) - fit.lower.point(0.5)).normalize()
}

#[test]
fn the_tool_stands_outside_and_the_lower_guide_below() {
    for (name, form) in ruled_forms() {
        let (mesh, front) = solid(&*form, [30, 3], 3.0);
        let outside = patch::mean_normal(&mesh, &front);
        let fit = fit_ruled(&mesh, &front, &RuledFitParams::default(), &Cancel::default()).unwrap();
        assert!(middle_normal(&fit).dot(outside) > 0.5, "{name}");
        let height = |g: &NurbsCurve| (0..=20).map(|i| g.point(i as f64 / 20.0).z).sum::<f64>() / 21.0;
        assert!(height(&fit.lower) <= height(&fit.upper) + 0.05, "{name}");
        // The way back over the same face: from inside of the wall the tool stands on the other side.
        let back: Vec<u32> = front.iter().map(|t| t + front.len() as u32).collect();
        let behind =
            fit_ruled(&mesh, &back, &RuledFitParams { tolerance_mm: 0.5, ..Default::default() }, &Cancel::default())
                .unwrap();
        assert!(middle_normal(&behind).dot(outside) < -0.5, "{name}");
    }
}

/// A sphere's zone about the equator: rulings are chords of its meridians, whose sagitta s is R (1 - cos(a)). No line
/// is nearer to an arc than s/2 at its worst place, and the chord is s away.
#[test]
fn a_sphere_is_not_ruled_by_its_sagitta() {
    for (radius, half) in [(30.0, 0.15f64), (12.0, 0.3)] {
        let zone = move |u: f64, v: f64| {
            let (turn, height) = (1.6 * u, half * (2.0 * v - 1.0));
            DVec3::new(height.cos() * turn.cos(), height.cos() * turn.sin(), height.sin()) * radius
        };
        let fit = fitted(&zone, 0.01);
        let sagitta = radius * (1.0 - half.cos());
        let share = fit.error_corners.greatest_mm / sagitta;
        assert!(!fit.is_ruled && (0.48..1.0).contains(&share), "{share}: {:?}", fit.words);
        assert!(fit.words[0].starts_with("not ruled within 0.0100 mm"), "{:?}", fit.words);
        assert!((fit.worst.length() - radius).abs() <= fit.chord_mm + 1e-9, "{:?}", fit.worst);
        // With a tolerance of the sagitta it is one.
        assert!(fitted(&zone, sagitta).is_ruled);
    }
}

#[test]
fn a_cylinder_and_a_cone_all_around_have_closed_guides() {
    for (low, high, sides) in [(6.0, 6.0, 4), (8.0, 5.0, 5)] {
        let n = 90;
        let ring = |r: f64, z: f64| {
            (0..n)
                .map(move |i| std::f64::consts::TAU * i as f64 / n as f64)
                .map(move |t| DVec3::new(r * t.cos(), r * t.sin(), z))
        };
        let levels: Vec<DVec3> = (0..=sides)
            .flat_map(|k| {
                let share = k as f64 / sides as f64;
                ring(low + (high - low) * share, 10.0 * share)
            })
            .collect();
        let mut triangles = Vec::new();
        for k in 0..sides as u32 {
            for i in 0..n as u32 {
                let [a, b] = [k * n as u32 + i, k * n as u32 + (i + 1) % n as u32];
                triangles.extend([[a, b, b + n as u32], [a, b + n as u32, a + n as u32]]);
            }
        }
        let mesh = Mesh { vertices: levels, triangles };
        let all: Vec<u32> = (0..mesh.triangles.len() as u32).collect();
        let fit = fit_ruled(&mesh, &all, &RuledFitParams::default(), &Cancel::default()).unwrap();
        assert!(fit.is_ruled && fit.is_closed && fit.covers, "{:?}", fit.words);
        assert!(fit.words.iter().any(|w| w.contains("all around")), "{:?}", fit.words);
        // Place, slope and bend go on across the seam, and both guides are circles everywhere.
        for (guide, radius) in [(&fit.lower, low), (&fit.upper, high)] {
            let ([p, d, s], [q, e, t]) = (guide.at(0.0), guide.at(1.0));
            assert!(p.distance(q) < 1e-9 && d.distance(e) < 1e-8 * d.length() && s.distance(t) < 1e-6 * s.length());
            let off = |i: i32| (guide.point(f64::from(i) / 200.0).truncate().length() - radius).abs();
            let most = (0..=200).map(off).fold(0.0, f64::max);
            assert!(most < 0.005, "{most}");
            assert!((guide.length(0.0, 1.0) / (std::f64::consts::TAU * radius) - 1.0).abs() < 1e-3);
        }
        for u in [0.1, 0.4, 0.8] {
            let (a, b) = (fit.lower.point(u), fit.upper.point(u));
            // A ruling stands on a meridian.
            assert!(a.truncate().normalize().distance(b.truncate().normalize()) < 0.02, "{a} {b}");
        }
    }
}

#[test]
fn an_oblique_end_a_hole_and_turned_triangles_are_said() {
    let form = |u: f64, v: f64| {
        let t = 1.8 * u + 0.25 * v * (1.0 - u);
        DVec3::new(8.0 * t.cos(), 8.0 * t.sin(), 10.0 * v)
    };
    let (mesh, front) = solid(&form, [60, 10], 2.0);
    let fit =
        fit_ruled(&mesh, &front, &RuledFitParams { tolerance_mm: 2e-3, ..Default::default() }, &Cancel::default())
            .unwrap();
    assert!(fit.is_ruled, "{:?}", fit.words);
    // A hole of two by two cells in the middle.
    let is_in = |t: u32| (600..640).contains(&t) && (8..12).contains(&(t % 20));
    let holed: Vec<u32> = front.iter().copied().filter(|t| !is_in(*t)).collect();
    let fit =
        fit_ruled(&mesh, &holed, &RuledFitParams { tolerance_mm: 2e-3, ..Default::default() }, &Cancel::default())
            .unwrap();
    assert!(fit.is_ruled && fit.words.iter().any(|w| w.contains("hole")), "{:?}", fit.words);
    let mut turned = mesh.clone();
    (0..front.len()).step_by(7).for_each(|t| turned.triangles[t].swap(0, 1));
    let fit =
        fit_ruled(&turned, &front, &RuledFitParams { tolerance_mm: 2e-3, ..Default::default() }, &Cancel::default())
            .unwrap();
    let said = format!("{} triangle(s) faced the other way", front.len().div_ceil(7));
    assert!(fit.is_ruled && fit.words.iter().any(|w| w.starts_with(&said)), "{:?}", fit.words);
}

#[test]
fn a_face_that_the_surface_does_not_cover_is_said() {
    let params = RuledFitParams { tolerance_mm: 2e-3, ..Default::default() };
    let fit_of = |mesh: &Mesh, face: &[u32]| fit_ruled(mesh, face, &params, &Cancel::default()).unwrap();
    let says = |fit: &RuledFit, word: &str| fit.words.iter().any(|w| w.contains(word));
    // The end of a wall of 15 mm by 10 mm reaches 8 mm further in an arc.
    let arched = |u: f64, v: f64| {
        let t = u * (15.0 + 8.0 * (1.0 - (2.0 * v - 1.0).powi(2))) / 60.0;
        DVec3::new(60.0 * t.cos(), 60.0 * t.sin(), 10.0 * v)
    };
    let (mesh, front) = solid(&arched, [30, 16], 2.0);
    let fit = fit_of(&mesh, &front);
    assert!(!fit.covers && fit.uncovered_mm > 0.05, "{:?}", fit.words);
    let at = fit.uncovered_at;
    assert!(says(&fit, "NOT COVERED") && (at.truncate().length() - 60.0).abs() < 0.05, "{at}");
    // A slot cuts 4 mm of a wall of 16 mm off; an island in a hole lies on the surface.
    let wall = |u: f64, v: f64| DVec3::new(10.0 * (1.6 * u).cos(), 10.0 * (1.6 * u).sin(), 8.0 * v);
    let (mesh, front) = solid(&wall, [40, 8], 2.0);
    let [slot, ring]: [fn(u32, u32) -> bool; 2] = [
        |i, _| i == 29,
        |i, j| (16..24).contains(&i) && (1..7).contains(&j) && !((18..22).contains(&i) && (3..5).contains(&j)),
    ];
    let without = |is_in: fn(u32, u32) -> bool| {
        front.iter().copied().filter(|t| !is_in(t / 16, t % 16 / 2)).collect::<Vec<u32>>()
    };
    assert!(fit_of(&mesh, &front).covers);
    let fit = fit_of(&mesh, &without(slot));
    let lost = 11.0 / 40.0 * 16.0;
    assert!(fit.is_ruled && !fit.covers && (0.7 * lost..1.1 * lost).contains(&fit.lost_mm), "{} {lost}", fit.lost_mm);
    assert!(says(&fit, "NOT COVERED"), "{:?}", fit.words);
    let fit = fit_of(&mesh, &without(ring));
    assert!(fit.is_ruled && fit.covers && says(&fit, "in pieces"), "{:?}", fit.words);
}

#[test]
fn triangles_that_say_too_little_are_not_allowed_for() {
    // Six chords of an eighth of their turn's square times the radius.
    let wall = |u: f64, v: f64| DVec3::new(8.0 * (2.2 * u).cos(), 8.0 * (2.2 * u).sin(), 8.0 * v);
    let (mesh, front) = solid(&wall, [6, 3], 2.0);
    let fit_of = |tolerance_mm: f64| {
        let params = RuledFitParams { tolerance_mm, ..Default::default() };
        fit_ruled(&mesh, &front, &params, &Cancel::default()).unwrap()
    };
    let chord = 8.0 * (2.2f64 / 6.0).powi(2) / 8.0;
    let fit = fit_of(0.04 * chord);
    assert!(!fit.covers && !fit.is_ruled && (fit.chord_mm / chord - 1.0).abs() < 0.1, "{:?}", fit.words);
    assert!(fit.words.iter().any(|w| w.contains("too coarse")), "{:?}", fit.words);
    assert!(fit_of(0.06 * chord).covers);
}

#[test]
fn what_is_no_strip_is_refused_in_words() {
    let cube = Mesh::cuboid(DVec3::new(2.0, 3.0, 4.0));
    let params = RuledFitParams::default();
    let refused = |triangles: &[u32], mesh: &Mesh| fit_ruled(mesh, triangles, &params, &Cancel::default()).unwrap_err();
    assert_eq!(refused(&[], &cube), RuledFitError::NoArea);
    assert_eq!(refused(&[3, 99], &cube), RuledFitError::NoTriangle(99));
    assert_eq!(refused(&(0..12).collect::<Vec<u32>>(), &cube), RuledFitError::Closed);
    assert_eq!(refused(&[0], &cube), RuledFitError::NoSides);
    let mut broken = cube.clone();
    broken.vertices[cube.triangles[5][1] as usize].x = f64::NAN;
    assert_eq!(refused(&[5], &broken), RuledFitError::NoPoint(5));
    broken = cube.clone();
    broken.triangles[4][0] = 77;
    assert_eq!(refused(&[4], &broken), RuledFitError::NoPoint(4));
    broken = cube.clone();
    broken.triangles.push([cube.triangles[0][0], cube.triangles[0][2], 7]);
    assert!(matches!(refused(&(0..13).collect::<Vec<u32>>(), &broken), RuledFitError::Branching(_)));
    for (params, key) in [
        (RuledFitParams { tolerance_mm: 0.0, ..params }, "tolerance_mm"),
        (RuledFitParams { tolerance_mm: f64::NAN, ..params }, "tolerance_mm"),
        (RuledFitParams { most_control_points: 3, ..params }, "most_control_points"),
        (RuledFitParams { up: DVec3::ZERO, ..params }, "up"),
        (RuledFitParams { base: Some(PartBase::at_end(DVec3::ZERO)), ..params }, "base.towards"),
        (
            RuledFitParams { base: Some(PartBase { from_mm: Some(f64::NAN), towards: DVec3::X }), ..params },
            "base.from_mm",
        ),
    ] {
        let error = fit_ruled(&cube, &[0, 1], &params, &Cancel::default()).unwrap_err();
        assert!(error.to_string().contains(key), "{error}");
        assert_eq!(flank_candidates(&cube, &params, &Task::default()), Err(error));
    }
}

#[test]
fn any_number_of_threads_answers_the_same_and_a_stop_is_heeded() {
    let (mesh, front) = solid(&*ruled_forms().remove(1).1, [60, 8], 3.0);
    let params = RuledFitParams { tolerance_mm: 2e-3, ..RuledFitParams::default() };
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| fit_ruled(&mesh, &front, &params, &Cancel::default()).unwrap())
    };
    assert_eq!(on(1), on(3));
    let cancel = Cancel::default();
    cancel.cancel();
    assert_eq!(fit_ruled(&mesh, &front, &params, &cancel), Err(RuledFitError::Cancelled));
    assert_eq!(flank_candidates(&mesh, &params, &Task::silent(&cancel)), Err(RuledFitError::Cancelled));
}

#[test]
fn a_plane_is_ruled_upright() {
    let mesh = Mesh::cuboid(DVec3::new(20.0, 30.0, 14.0));
    let found = flank_candidates(&mesh, &RuledFitParams::default(), &Task::default()).unwrap();
    assert_eq!(found.len(), 6);
    // What lies comes last, whatever its size.
    let rank = |c: &Candidate| (c.outwards.z.abs() > 0.5, -c.area_mm2);
    assert!(found.windows(2).all(|w| rank(&w[0]) <= rank(&w[1])));
    for candidate in &found {
        let CandidateFit::Fitted(fit) = &candidate.fit else { panic!("{}", candidate.summary()) };
        assert!(candidate.is_ruled() && candidate.kind == CandidateKind::Plane && fit.error.greatest_mm < 1e-9);
        assert!(middle_normal(fit).distance(candidate.outwards) < 1e-9, "{}", candidate.summary());
        let ruling = fit.upper.point(0.3) - fit.lower.point(0.3);
        let lies = candidate.outwards.z.abs() > 0.5;
        assert!(lies || (ruling.x.abs() + ruling.y.abs() < 1e-6 && (ruling.z - 14.0).abs() < 1e-6), "{ruling}");
    }
}

/// A prism over a square with rounded corners, its bottom at zero.
fn rounded_block(half: f64, radius: f64, height: f64, parts: usize) -> Mesh {
    let mut outline = Vec::new();
    for corner in 0..4 {
        let quarter = std::f64::consts::FRAC_PI_2;
        let middle = DVec3::new(half - radius, half - radius, 0.0);
        let turned = DQuat::from_rotation_z(quarter * corner as f64);
        for i in 0..=parts {
            let t = quarter * i as f64 / parts as f64;
            outline.push(turned * (middle + DVec3::new(radius * t.cos(), radius * t.sin(), 0.0)));
        }
    }
    let n = outline.len() as u32;
    let mut vertices = outline.clone();
    vertices.extend(outline.iter().map(|p| *p + DVec3::Z * height));
    vertices.extend([DVec3::ZERO, DVec3::Z * height]);
    let mut triangles = Vec::new();
    for (i, j) in (0..n).map(|i| (i, (i + 1) % n)) {
        triangles.extend([[i, j, j + n], [i, j + n, i + n], [2 * n, j, i], [2 * n + 1, i + n, j + n]]);
    }
    Mesh { vertices, triangles }
}

#[test]
fn candidates_are_walls_roundings_and_the_wall_all_around() {
    let (half, radius, height) = (12.0, 4.0, 15.0);
    let mesh = rounded_block(half, radius, height, 24);
    let told = std::sync::Arc::new(std::sync::Mutex::new(Vec::new()));
    let teller = told.clone();
    let progress =
        Progress::new(move |update| teller.lock().unwrap().push((update.fraction, update.message.to_owned())));
    let task = Task { progress, cancel: Cancel::default() };
    let found = flank_candidates(&mesh, &RuledFitParams::default(), &task).unwrap();
    let mut told = told.lock().unwrap().clone();
    told.sort_by(|a, b| a.0.total_cmp(&b.0));
    let tried = found.iter().filter(|c| c.fit != CandidateFit::NotTried).count();
    assert_eq!((told.len(), told.last()), (tried + 1, Some(&(1.0, format!("{tried} of {tried}")))));
    let of = |kind: CandidateKind| found.iter().filter(|c| c.kind == kind).collect::<Vec<_>>();
    assert_eq!([CandidateKind::Plane, CandidateKind::Cylinder, CandidateKind::Joined].map(|k| of(k).len()), [6, 4, 1]);
    let side = 2.0 * (half - radius);
    for plane in of(CandidateKind::Plane).iter().filter(|c| c.outwards.z.abs() < 0.1) {
        assert!((plane.area_mm2 - side * height).abs() < 1e-6 && (plane.height_mm - height).abs() < 1e-9);
    }
    for cylinder in of(CandidateKind::Cylinder) {
        let CandidateFit::Fitted(fit) = &cylinder.fit else { panic!("{}", cylinder.summary()) };
        // The chord of a part of the arc: R (1 - cos(angle / 2)).
        let chord = radius * (1.0 - (std::f64::consts::FRAC_PI_4 / 24.0).cos());
        assert!(fit.is_ruled && (0.8..1.3).contains(&(fit.chord_mm / chord)), "{} {chord}", fit.chord_mm);
        let arc = radius * std::f64::consts::FRAC_PI_2;
        assert!((fit.lower.length(0.0, 1.0) / arc - 1.0).abs() < 1e-3);
    }
    let [wall] = of(CandidateKind::Joined)[..] else { panic!() };
    let CandidateFit::Fitted(fit) = &wall.fit else { panic!("{}", wall.summary()) };
    assert!(wall.faces.len() == 8 && fit.is_closed && wall.outwards == DVec3::ZERO, "{}", wall.summary());
    assert!(wall.is_ruled(), "{:?}", fit.words);
    // Its seam is at an end of a plane, not within a rounding.
    let seam = fit.lower.point(0.0).abs();
    assert!((seam.x.max(seam.y) - half).abs() < 0.02 && (seam.x.min(seam.y) - (half - radius)).abs() < 0.02, "{seam}");
}

/// A flat has no chord error, however long: what turns at its seams is the rounding beside it.
#[test]
fn the_chord_error_of_a_wall_is_that_of_its_roundings() {
    for (parts, flats) in [(24, 1), (24, 5), (6, 1), (4, 1)] {
        let (half, radius, height) = (12.0, 4.0, 15.0);
        let block = rounded_block(half, radius, height, parts);
        let n = 4 * (parts + 1);
        // The wall, its flats cut into as many pieces.
        let mut wall = Mesh { vertices: block.vertices.clone(), triangles: Vec::new() };
        for (i, j) in (0..n).map(|i| (i, (i + 1) % n)) {
            let pieces = if (i + 1) % (parts + 1) == 0 { flats } else { 1 };
            let ends = [i, j, j + n, i + n].map(|k| block.vertices[k]);
            for piece in 0..pieces {
                let [from, to] = [piece, piece + 1].map(|k| k as f64 / pieces as f64);
                let [a, b, c, d] = [(0, 1, from), (0, 1, to), (3, 2, to), (3, 2, from)].map(|(p, q, share)| {
                    // The very ends, so that they meet those of the next.
                    wall.vertices.push(if share == 1.0 { ends[q] } else { ends[p].lerp(ends[q], share) });
                    wall.vertices.len() as u32 - 1
                });
                wall.triangles.extend([[a, b, c], [a, c, d]]);
            }
        }
        let all: Vec<u32> = (0..wall.triangles.len() as u32).collect();
        let chord = radius * (1.0 - (std::f64::consts::FRAC_PI_4 / parts as f64).cos());
        let found = patch::Patch::of(&wall, &all).unwrap().chord;
        assert!((0.9..1.2).contains(&(found / chord)), "{parts}, {flats}: {found} {chord}");
    }
}

/// Small roundings of a large wall need knots where they are: as many even ones would be half a millimetre apart.
#[test]
fn a_wall_with_small_roundings_is_ruled_with_few_control_points() {
    let mesh = rounded_block(20.0, 3.0, 15.0, 24);
    let n = 4 * 25;
    let around: Vec<u32> = (0..4 * n).filter(|t| t % 4 < 2).collect();
    let fit = fit_ruled(&mesh, &around, &RuledFitParams::default(), &Cancel::default()).unwrap();
    assert!(fit.is_ruled && fit.is_closed && fit.covers, "{:?}", fit.words);
    assert!(fit.error_corners.greatest_mm < 0.01, "{:?}", fit.error_corners);
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 4, ..ProptestConfig::default() })]

    /// Turning, moving and growing a part turns, moves and grows the answer; noise of the corners comes back as error.
    #[test]
    fn the_fit_goes_with_the_part(
        turn in prop::array::uniform3(-3.0..3.0f64),
        shift in prop::array::uniform3(-200.0..200.0f64),
        scale in 0.3..5.0f64,
        which in 0usize..7,
        noise in 0.0..2e-3f64,
    ) {
        let forms = ruled_forms();
        let (name, form) = &forms[which];
        let rotation = DQuat::from_scaled_axis(DVec3::from_array(turn));
        let (mesh, front) = solid(&**form, [40, 6], 2.0);
        let moved = mesh.mapped(|p| {
            // Noise that depends on the place alone, so that points at one place stay together.
            let wave = |k: f64| noise * (1e4 * p.dot(DVec3::new(0.3, 0.5, 0.7)) * k).sin();
            rotation * (p + DVec3::new(wave(12.9), wave(78.2), wave(37.7))) * scale + DVec3::from_array(shift)
        });
        let params = RuledFitParams { tolerance_mm: 4e-3 * scale, up: rotation * DVec3::Z, ..Default::default() };
        let fit = fit_ruled(&moved, &front, &params, &Cancel::default()).unwrap();
        prop_assert!(fit.is_ruled, "{name}: {:?}", fit.words);
        prop_assert!(fit.error_corners.greatest_mm <= scale * (1e-3 + 2.0 * noise), "{name}: {:?}", fit.error_corners);
        let outside = patch::mean_normal(&moved, &front);
        prop_assert!(middle_normal(&fit).dot(outside) > 0.5);
    }

    /// Whatever the triangles, there is an answer with numbers or a refusal in words.
    #[test]
    fn nothing_upsets_it(
        points in prop::collection::vec(prop::array::uniform3(0i32..4), 3..20),
        picks in prop::collection::vec(prop::array::uniform3(0u32..20), 1..40),
        size in prop::sample::select(vec![1e-9, 1.0, 1e9]),
    ) {
        let vertices = points.iter().map(|p| DVec3::from_array(p.map(f64::from)) * size).collect::<Vec<_>>();
        let count = vertices.len() as u32;
        let triangles: Vec<[u32; 3]> = picks.iter().map(|t| t.map(|v| v % count)).collect();
        let mesh = Mesh { vertices, triangles };
        let all: Vec<u32> = (0..mesh.triangles.len() as u32).collect();
        if let Ok(fit) = fit_ruled(&mesh, &all, &RuledFitParams::default(), &Cancel::default()) {
            let figures = [fit.error.greatest_mm, fit.chord_mm, fit.border_mm, fit.overhang_mm, fit.uncovered_mm];
            prop_assert!(figures.iter().all(|f| f.is_finite()) && !fit.words.is_empty(), "{fit:?}");
        }
        let candidates = flank_candidates(&mesh, &RuledFitParams::default(), &Task::default()).unwrap();
        prop_assert!(candidates.iter().all(|c| c.area_mm2.is_finite() && !c.summary().is_empty()));
    }
}
