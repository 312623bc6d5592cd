//! Clearances of walls that the flutes run along or across, where figures by hand are at hand.

use super::*;
use crate::gouge::{GougeCheck, TOLERANCE, check};
use crate::walls::{OwnTriangles, Walls};
use geometry::mesh::Mesh;

/// Faces as fans of their corners.
fn mesh(faces: &[Vec<DVec3>]) -> Mesh {
    let mut mesh = Mesh::default();
    for face in faces {
        let first = mesh.vertices.len() as u32;
        mesh.vertices.extend(face);
        mesh.triangles.extend((1..face.len() as u32 - 1).map(|i| [first, first + i, first + i + 1]));
    }
    mesh
}

/// The six faces of a box.
fn block(low: [f64; 3], high: [f64; 3]) -> Vec<Vec<DVec3>> {
    let ends = [DVec3::from(low), DVec3::from(high)];
    let face = |across: usize, at: usize| {
        let [along, up] = [(across + 1) % 3, (across + 2) % 3];
        let corner = |i: usize, j: usize| {
            let mut p = ends[at];
            (p[along], p[up]) = (ends[i][along], ends[j][up]);
            p
        };
        vec![corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)]
    };
    (0..3).flat_map(|across| [face(across, 0), face(across, 1)]).collect()
}

fn line(a: [f64; 3], b: [f64; 3]) -> GuideCurve {
    GuideCurve::Bezier { points: vec![a.into(), b.into()] }
}

fn checked(mesh: &Mesh, surface: &RuledSurface, cutter: &FlankCutter) -> GougeCheck {
    let params = FlankParams { grid: [20, 10], rounds: 0, below_mm: 0.0, ..FlankParams::default() };
    let path = planned(surface, cutter, &params).unwrap().initial;
    let walls = Walls::new(mesh, OwnTriangles::Near(0.01), (surface, &path), 0.01, &Cancel::default()).unwrap();
    check(&path, cutter, &walls, &Task::default()).unwrap()
}

#[test]
fn a_half_round_in_a_block_is_milled_without_a_gouge() {
    // As a tessellated part has it: the half-round is chords, its caps are large triangles that meet at its rim.
    const CHORDS: u32 = 128;
    let rim = |z: f64| {
        (0..=CHORDS).map(move |i| {
            let (y, x) = (std::f64::consts::PI * f64::from(i) / f64::from(CHORDS)).sin_cos();
            DVec3::new(3.0 * x, 3.0 * y, z)
        })
    };
    let rims = [rim(0.0).collect::<Vec<_>>(), rim(10.0).collect()];
    let mut faces: Vec<Vec<DVec3>> =
        (0..CHORDS as usize).map(|i| vec![rims[0][i], rims[0][i + 1], rims[1][i + 1], rims[1][i]]).collect();
    for (z, rim) in [(0.0, &rims[0]), (10.0, &rims[1])] {
        let outer = DVec3::new(10.0, 20.0, z);
        faces.push(std::iter::once(outer).chain(rim[..=64].iter().copied().rev()).collect());
        faces.push([DVec3::new(-10.0, 20.0, z)].into_iter().chain(rim[64..].iter().copied()).collect());
    }
    for x in [-1.0, 1.0] {
        faces.push([(3.0, 0.0), (10.0, 0.0), (10.0, 10.0), (3.0, 10.0)].map(|(a, z)| DVec3::new(x * a, 0.0, z)).into());
    }
    let guide = |z: f64| GuideCurve::Points { points: rim(z).collect(), degree: 3 };
    let surface = RuledSurface::from_guides(&guide(0.0), &guide(10.0), Side::Positive).unwrap();
    let middle = surface.normal(0.5, 0.5);
    let side = if middle.y < 0.0 { Side::Positive } else { Side::Negative };
    let surface = RuledSurface::from_guides(&guide(0.0), &guide(10.0), side).unwrap();
    let found = checked(&mesh(&faces), &surface, &FlankCutter::cone(1.5, 0.0, 12.0)).cutter.unwrap();
    assert!(found.distance_mm.abs() < 2.0 * TOLERANCE, "{found:?}");
}

#[test]
fn a_lip_over_a_wall_is_cut_as_deep_as_it_stands_out() {
    let surface = RuledSurface::from_guides(
        &line([-10.0, -6.0, 0.0], [10.0, -6.0, 0.0]),
        &line([-10.0, -6.0, 12.0], [10.0, -6.0, 12.0]),
        Side::Positive,
    )
    .unwrap();
    assert!(surface.normal(0.5, 0.5).y < 0.0);
    let part = |out: f64| {
        let mut faces = block([-10.0, -6.0, 0.0], [10.0, 6.0, 12.0]);
        faces.extend(block([-10.0, -6.0 - out, 12.0], [10.0, 8.0, 14.0]));
        mesh(&faces)
    };
    for out in [0.3, 1.5] {
        let found = checked(&part(out), &surface, &FlankCutter::cone(2.0, 0.0, 20.0)).cutter.unwrap();
        let wanted = -out;
        assert!(found.distance_mm > wanted - TOLERANCE && found.distance_mm < 0.94 * wanted, "{found:?}");
    }
}

#[test]
fn a_wall_along_the_flutes_is_as_far_as_it_is() {
    let surface = RuledSurface::from_guides(
        &line([0.0, 0.0, 0.0], [0.0, 20.0, 0.0]),
        &line([0.0, 0.0, 10.0], [0.0, 20.0, 10.0]),
        Side::Positive,
    )
    .unwrap();
    assert!(surface.normal(0.5, 0.5).x > 0.0);
    // A cutter of 2 mm in a slot of 5 mm: 1 mm is left, all along the path and the flutes.
    let opposite = mesh(&block([5.0, -100.0, -100.0], [105.0, 120.0, 100.0]));
    let found = checked(&opposite, &surface, &FlankCutter::cone(2.0, 0.0, 12.0)).cutter.unwrap();
    assert!((found.distance_mm - 1.0).abs() < 0.05, "{found:?}");
    let narrow = mesh(&block([3.9995, -100.0, -100.0], [105.0, 120.0, 100.0]));
    let found = checked(&narrow, &surface, &FlankCutter::cone(2.0, 0.0, 12.0)).cutter.unwrap();
    assert!((found.distance_mm + 0.0005).abs() < TOLERANCE, "{found:?}");
}
