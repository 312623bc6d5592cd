use glam::{DQuat, DVec3};
use proptest::prelude::*;

use super::*;

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
const LOWER_B: [[f64; 3]; 4] =
    [[79.125, 2.0, -10.0], [84.898, 6.0, -10.0], [90.204, 0.0, -10.0], [98.775, 4.0, -10.0]];

/// Ruled surfaces with their names.
fn ruled_forms() -> Vec<(&'static str, Box<Form>)> {
    let between = |a: fn(f64) -> DVec3, b: fn(f64) -> DVec3| -> Box<Form> {
        Box::new(move |u, v| a(u) * (1.0 - v) + b(u) * v)
    };
    let arc = |r: f64, z: f64, t: f64| DVec3::new(r * t.cos(), r * t.sin(), z);
    vec![
        ("paper's A", between(|u| bezier(LOWER_A, u), |u| bezier(UPPER, u))),
        ("paper's B", between(|u| bezier(LOWER_B, u), |u| bezier(UPPER, u))),
        (
            "twisted quadrangle",
            between(
                |u| DVec3::new(30.0 * u, 0.0, 0.0),
                |u| DVec3::new(2.0 + 26.0 * u, 4.0 * u - 1.0, 10.0 + u),
            ),
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

#[test]
fn known_ruled_surfaces_are_found_with_their_borders() {
    for (name, form) in ruled_forms() {
        let (mesh, front) = solid(&*form, [60, 8], 3.0);
        let params = RuledFitParams { tolerance_mm: 2e-3, ..RuledFitParams::default() };
        let fit = fit_ruled(&mesh, &front, &params).unwrap();
        eprintln!("{name}: {:?} n {}\n   chord {} border {} over {} back {:?} corner {:?}", fit.words, fit.lower.knots().count(), fit.chord_mm, fit.border_mm, fit.overhang_mm, fit.error_back, fit.error_corners);
    }
}
