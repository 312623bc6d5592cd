//! Solids of known volume, written by an independent writer.

use std::f64::consts::{PI, TAU};

use glam::{DVec2, DVec3};
use step_io::build::{CurveInput, FaceBoundInput, Frame, LengthUnit, SurfaceInput, UnitsInput};
use step_io::model::{AdvancedFaceId, EdgeCurveId};
use step_io::{Orientation, StepBuilder};
use task::Task;

use super::surface::{Shape, Surface};
use super::{Options, StepFile, read};
use Orientation::{Forward, Reversed};

const CHORD: f64 = 0.01;

fn frame(origin: DVec3, axis: DVec3) -> Frame {
    Frame { origin: origin.into(), axis: axis.into(), ref_dir: axis.any_orthonormal_vector().into() }
}

/// A circle about Z at height `z`, from its point towards the reference direction.
fn circle(b: &mut StepBuilder, radius: f64, z: f64) -> EdgeCurveId {
    let frame = frame(DVec3::Z * z, DVec3::Z);
    let start = DVec3::from(frame.origin) + DVec3::from(frame.ref_dir) * radius;
    let vertex = b.vertex(start.into()).unwrap();
    b.edge(vertex, vertex, CurveInput::Circle(frame, radius)).unwrap()
}

fn cap(b: &mut StepBuilder, edge: EdgeCurveId, z: f64, side: Orientation) -> AdvancedFaceId {
    let bound = FaceBoundInput::outer(vec![(edge, side)]);
    b.face(SurfaceInput::Plane(frame(DVec3::Z * z, DVec3::Z)), side, vec![bound]).unwrap()
}

fn written(build: impl FnOnce(&mut StepBuilder) -> Vec<AdvancedFaceId>) -> Vec<u8> {
    let mut b = StepBuilder::new();
    let part = b.part("part");
    let faces = build(&mut b);
    b.solid(part, "body", faces).unwrap();
    bytes(b)
}

fn bytes(b: StepBuilder) -> Vec<u8> {
    let mut bytes = Vec::new();
    step_io::write(&b.finish(), &mut bytes).unwrap();
    bytes
}

fn read_all(bytes: &[u8]) -> StepFile {
    read(bytes, &Options { chord: CHORD, ..Options::default() }, &Task::default()).unwrap()
}

/// Reads the one solid of a file, which must close, and whose volume must be `volume` but for what chords cut off its
/// `area`.
fn closes(bytes: &[u8], volume: f64, area: f64) -> super::Solid {
    let mut file = read_all(bytes);
    let solid = file.solids.remove(0);
    assert!(file.solids.is_empty() && solid.is_closed() && solid.faults.is_empty(), "{:?}", solid.faults);
    let off = solid.mesh.volume() - volume;
    assert!(off.abs() <= CHORD * area, "{} for {volume}", solid.mesh.volume());
    solid
}

fn cuboid(b: &mut StepBuilder, size: DVec3) -> Vec<AdvancedFaceId> {
    let corner = |i: usize| size * DVec3::new((i & 1) as f64, (i >> 1 & 1) as f64, (i >> 2 & 1) as f64);
    let vertices: Vec<_> = (0..8).map(|i| b.vertex(corner(i).into()).unwrap()).collect();
    let mut edges = std::collections::HashMap::new();
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let mut faces = Vec::new();
    for quad in quads {
        let mut bound = Vec::new();
        for k in 0..4 {
            let (from, to) = (quad[k], quad[(k + 1) % 4]);
            let key = (from.min(to), from.max(to));
            let edge = *edges
                .entry(key)
                .or_insert_with(|| b.edge(vertices[key.0], vertices[key.1], CurveInput::Line).unwrap());
            bound.push((edge, if from < to { Forward } else { Reversed }));
        }
        let normal = (corner(quad[1]) - corner(quad[0])).cross(corner(quad[2]) - corner(quad[1])).normalize();
        let plane = SurfaceInput::Plane(frame(corner(quad[0]), normal));
        faces.push(b.face(plane, Forward, vec![FaceBoundInput::outer(bound)]).unwrap());
    }
    faces
}

#[test]
fn a_box_has_twelve_triangles_and_its_volume() {
    let solid = closes(&written(|b| cuboid(b, DVec3::new(10.0, 20.0, 30.0))), 6000.0, 1e-6);
    assert_eq!((solid.faces.len(), solid.mesh.triangles.len()), (6, 12));
    assert_eq!(solid.name, "part: body");
}

/// A cylinder of radius 5 from z = 0 to 10, whose wall has `with_seam` the seam that some writers need.
fn cylinder(b: &mut StepBuilder, with_seam: bool) -> Vec<AdvancedFaceId> {
    let (low, high) = (frame(DVec3::ZERO, DVec3::Z), frame(DVec3::Z * 10.0, DVec3::Z));
    let start = |f: &Frame| DVec3::from(f.origin) + 5.0 * DVec3::from(f.ref_dir);
    let ends = [b.vertex(start(&low).into()).unwrap(), b.vertex(start(&high).into()).unwrap()];
    let bottom = b.edge(ends[0], ends[0], CurveInput::Circle(low, 5.0)).unwrap();
    let top = b.edge(ends[1], ends[1], CurveInput::Circle(high, 5.0)).unwrap();
    let bounds = if with_seam {
        let seam = b.edge(ends[0], ends[1], CurveInput::Line).unwrap();
        vec![FaceBoundInput::outer(vec![(bottom, Forward), (seam, Forward), (top, Reversed), (seam, Reversed)])]
    } else {
        vec![FaceBoundInput::outer(vec![(bottom, Forward)]), FaceBoundInput::inner(vec![(top, Reversed)])]
    };
    let wall = b.face(SurfaceInput::Cylinder(low, 5.0), Forward, bounds).unwrap();
    vec![wall, cap(b, bottom, 0.0, Reversed), cap(b, top, 10.0, Forward)]
}

#[test]
fn a_cylinder_closes_with_and_without_a_seam() {
    for with_seam in [false, true] {
        let solid = closes(&written(|b| cylinder(b, with_seam)), 250.0 * PI, 100.0 * PI);
        for p in &solid.mesh.vertices {
            assert!((p.truncate().length() - 5.0).abs() < 1e-9);
        }
        // Triangles of the wall stand upright, as it does.
        for (corners, _) in solid.mesh.iter_corners().zip(&solid.face_of).filter(|(_, face)| **face == 0) {
            let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize();
            assert!(normal.z.abs() < 1e-9);
        }
        // Chords that leave a circle of radius r by c are at most 2 sqrt(2 r c) long.
        let sides = solid.mesh.triangles.len() as f64 / 4.0;
        assert!(TAU * 5.0 / sides <= 2.0 * (10.0 * CHORD).sqrt() && sides < 64.0, "{sides}");
    }
}

#[test]
fn a_cone_and_a_half_sphere_close_at_their_poles() {
    // r = 4 at z = 0, tip at z = 8.
    let cone = written(|b| {
        let edge = circle(b, 4.0, 0.0);
        let at = frame(DVec3::ZERO, -DVec3::Z);
        let wall = SurfaceInput::Cone(at, 4.0, (0.5f64).atan());
        vec![
            b.face(wall, Forward, vec![FaceBoundInput::outer(vec![(edge, Forward)])]).unwrap(),
            cap(b, edge, 0.0, Reversed),
        ]
    });
    closes(&cone, PI * 16.0 * 8.0 / 3.0, PI * 4.0 * 80f64.sqrt());
    let dome = written(|b| {
        let edge = circle(b, 6.0, 0.0);
        let ball = SurfaceInput::Sphere(frame(DVec3::ZERO, DVec3::X), 6.0);
        vec![
            b.face(ball, Forward, vec![FaceBoundInput::outer(vec![(edge, Forward)])]).unwrap(),
            cap(b, edge, 0.0, Reversed),
        ]
    });
    closes(&dome, 2.0 * PI * 216.0 / 3.0, TAU * 36.0);
}

#[test]
fn a_ring_of_two_halves_of_a_torus_closes() {
    // The circles at the inside and outside of a torus of radii 10 and 3, between them its upper and lower halves.
    let ring = written(|b| {
        let [inner, outer] = [7.0, 13.0].map(|r| circle(b, r, 0.0));
        let torus = || SurfaceInput::Torus(frame(DVec3::ZERO, DVec3::Z), 10.0, 3.0);
        let half = |o: Orientation, i: Orientation| {
            vec![FaceBoundInput::outer(vec![(outer, o)]), FaceBoundInput::inner(vec![(inner, i)])]
        };
        vec![
            b.face(torus(), Forward, half(Forward, Reversed)).unwrap(),
            b.face(torus(), Forward, half(Reversed, Forward)).unwrap(),
        ]
    });
    closes(&ring, TAU * 10.0 * PI * 9.0, TAU * 10.0 * TAU * 3.0);
}

#[test]
fn placed_copies_and_other_units_come_out_in_millimetres() {
    let mut b = StepBuilder::new_with(&UnitsInput { length: LengthUnit::Metre, uncertainty: 1e-9 }).unwrap();
    let (whole, part) = (b.part("whole"), b.part("part"));
    let faces = cuboid(&mut b, DVec3::new(0.01, 0.02, 0.03));
    b.solid(part, "part", faces).unwrap();
    b.place(whole, part, Frame { origin: [0.1, 0.0, 0.0], axis: [0.0, 0.0, 1.0], ref_dir: [0.0, 1.0, 0.0] }).unwrap();
    b.place(whole, part, Frame { origin: [0.0; 3], axis: [0.0, 0.0, 1.0], ref_dir: [1.0, 0.0, 0.0] }).unwrap();
    let file = read_all(&bytes(b));
    assert_eq!(file.solids.iter().map(|s| s.name.as_str()).collect::<Vec<_>>(), ["part", "part (2)"]);
    assert!(file.solids.iter().all(|s| s.is_closed() && (s.mesh.volume() - 6000.0).abs() < 1e-6));
    // X of the part lies along Y.
    let bounds = file.solids[0].mesh.bounds();
    assert!((bounds.min - DVec3::new(80.0, 0.0, 0.0)).length() < 1e-9);
    assert!((bounds.max - DVec3::new(100.0, 10.0, 30.0)).length() < 1e-9);
}

#[test]
fn a_face_that_is_missing_leaves_the_solid_open_and_the_rest_as_it_is() {
    let open = written(|b| cuboid(b, DVec3::splat(10.0)).split_off(1));
    let file = read_all(&open);
    assert!(!file.solids[0].is_closed() && file.solids[0].mesh.triangles.len() == 10);
}

/// Guides are those of the box of parameters that the face covers.
#[test]
fn a_ruled_face_has_its_guides() {
    use geometry::nurbs::{KnotVector, NurbsSurface};
    let bezier =
        |degree: usize| KnotVector::new(degree, [vec![0.0; degree + 1], vec![1.0; degree + 1]].concat()).unwrap();
    let rows = [[0.0, 0.0, 0.0], [1.0, 3.0, 0.0], [2.0, 3.0, 0.0], [4.0, 0.0, 0.0]].map(DVec3::from_array);
    let points: Vec<DVec3> = rows.iter().flat_map(|p| [*p, *p * DVec3::new(1.0, -1.0, 1.0) + DVec3::Z * 5.0]).collect();
    let twisted = NurbsSurface::new(bezier(3), bezier(1), &points, &[1.0; 8]).unwrap();
    let shape = Surface {
        shape: Shape::Nurbs(twisted.clone().into()),
        period: [None; 2],
        poles: [None; 2],
        is_flipped: false,
        offset: 0.0,
    };
    let [low, high] = [DVec2::new(0.25, 0.1), DVec2::new(0.75, 0.6)];
    let guides = shape.guides([low, high]);
    assert_eq!(guides.len(), 1);
    for i in 0..=8 {
        let u = 0.25 + f64::from(i) / 16.0;
        for (guide, v) in guides[0].iter().zip([0.1, 0.6]) {
            assert!(guide.point(u).distance(twisted.point(u, v)) < 1e-12);
        }
    }
    assert!(shape.guides([low, DVec2::new(1.2, 0.6)]).is_empty(), "beyond the surface there are no guides");
}

/// Basis function number `i` by its definition.
fn basis(knots: &[f64], i: usize, degree: usize, u: f64) -> f64 {
    if degree == 0 {
        return f64::from(knots[i] <= u && u < knots[i + 1]);
    }
    let share = |over: f64, width: f64| if width > 0.0 { over / width } else { 0.0 };
    share(u - knots[i], knots[i + degree] - knots[i]) * basis(knots, i, degree - 1, u)
        + share(knots[i + degree + 1] - u, knots[i + degree + 1] - knots[i + 1]) * basis(knots, i + 1, degree - 1, u)
}

#[test]
fn knots_whose_ends_are_not_repeated_give_the_same_curve_and_surface() {
    let knots_u = vec![0.0, 1.0, 2.0, 3.5, 4.0, 4.0, 5.0, 6.5, 7.0, 8.0];
    let knots_v = vec![0.0, 1.0, 1.0, 2.0, 3.0, 4.5, 5.0];
    let control = |i: usize, j: usize| [i as f64, (i * i % 5) as f64 + 0.3 * j as f64, (j * j) as f64 - 0.1 * i as f64];
    let weight = |i: usize, j: usize| 1.0 + 0.2 * ((i + 2 * j) % 3) as f64;
    let [rows, columns] = [6, 4];
    let net = step_io::scene::NurbsSurface {
        degree_u: 3,
        degree_v: 2,
        control_points: (0..rows).map(|i| (0..columns).map(|j| control(i, j)).collect()).collect(),
        weights: (0..rows).map(|i| (0..columns).map(|j| weight(i, j)).collect()).collect(),
        knots_u: knots_u.clone(),
        knots_v: knots_v.clone(),
    };
    let curve = super::edges::curve(&step_io::scene::NurbsCurve {
        degree: 3,
        control_points: (0..rows).map(|i| control(i, 1)).collect(),
        weights: (0..rows).map(|i| weight(i, 1)).collect(),
        knots: knots_u.clone(),
    })
    .unwrap();
    let surface = Surface::nurbs(&net, 1e-6).unwrap();
    assert_eq!(curve.domain(), [3.5, 5.0]);
    for u in [3.5, 3.7, 4.0, 4.6, 4.999] {
        let at = |v: Option<f64>| {
            let mut sum = glam::DVec4::ZERO;
            for (i, j) in (0..rows).flat_map(|i| (0..columns).map(move |j| (i, j))) {
                let across = v.map_or(f64::from(j == 1), |v| basis(&knots_v, j, 2, v));
                let share = basis(&knots_u, i, 3, u) * across * weight(i, j);
                sum += (DVec3::from(control(i, j)) * share).extend(share);
            }
            sum.truncate() / sum.w
        };
        assert!(curve.point(u).distance(at(None)) < 1e-12, "{u}");
        for v in [1.0, 1.5, 2.0, 2.9] {
            assert!(surface.point(DVec2::new(u, v)).distance(at(Some(v))) < 1e-12, "{u} {v}");
        }
    }
}

/// A quarter of a cylinder of radius 5 about Z, 4 high, its normal outwards, as a NURBS surface.
fn quarter() -> step_io::scene::NurbsSurface {
    let arc = [[5.0, 0.0], [5.0, 5.0], [0.0, 5.0]];
    step_io::scene::NurbsSurface {
        degree_u: 2,
        degree_v: 1,
        control_points: arc.map(|[x, y]| [0.0, 4.0].map(|z| [x, y, z]).to_vec()).to_vec(),
        weights: [1.0, 0.5f64.sqrt(), 1.0].map(|w| vec![w; 2]).to_vec(),
        knots_u: vec![0.0, 0.0, 0.0, 1.0, 1.0, 1.0],
        knots_v: vec![0.0, 0.0, 1.0, 1.0],
    }
}

#[test]
fn a_surface_beside_another_lies_at_its_distance() {
    let surface = Surface::nurbs(&quarter(), 1e-6).unwrap().offset_by(1.5);
    for uv in [DVec2::new(0.1, 0.2), DVec2::new(0.5, 0.5), DVec2::new(0.93, 0.8)] {
        let [p, du, dv] = surface.at(uv);
        assert!((p.truncate().length() - 6.5).abs() < 1e-12 && (p.z - 4.0 * uv.y).abs() < 1e-12);
        for (k, slope) in [(DVec2::X, du), (DVec2::Y, dv)] {
            let by = 1e-5;
            let difference = (surface.point(uv + k * by) - surface.point(uv - k * by)) / (2.0 * by);
            assert!(difference.distance(slope) < 1e-7, "{uv}");
        }
        assert!(surface.locate_anywhere(p).distance(uv) < 1e-9);
    }
    assert!(surface.guides([DVec2::ZERO, DVec2::ONE]).is_empty());
}

/// The lid of a box on a surface 2 mm above a free one.
#[test]
fn a_face_on_an_offset_surface_closes() {
    let text = String::from_utf8(written(|b| cuboid(b, DVec3::new(10.0, 20.0, 30.0)))).unwrap();
    let planes: Vec<&str> = text.lines().filter(|line| line.contains("PLANE(") && line.contains('=')).collect();
    let number = planes[1].split('=').next().unwrap();
    let points = [(-1.0, -1.0), (-1.0, 21.0), (11.0, -1.0), (11.0, 21.0)];
    let points =
        points.iter().zip(90002..).map(|((x, y), n)| format!("#{n}=CARTESIAN_POINT('',({x:?},{y:?},28.0));\n"));
    let offset = format!(
        "{number}=OFFSET_SURFACE('',#90001,2.0,.F.);\n#90001=B_SPLINE_SURFACE_WITH_KNOTS('',1,1,((#90002,#90003),\
         (#90004,#90005)),.UNSPECIFIED.,.F.,.F.,.F.,(2,2),(2,2),(0.0,1.0),(0.0,1.0),.UNSPECIFIED.);\n{}",
        points.collect::<String>()
    );
    let solid = closes(text.replace(planes[1], &offset).as_bytes(), 6000.0, 1e-6);
    assert!(solid.mesh.bounds().max.distance(DVec3::new(10.0, 20.0, 30.0)) < 1e-9);
}

#[test]
fn a_face_is_given_up_when_told_to_stop() {
    let mut surface = Surface::nurbs(&quarter(), 1e-6).unwrap();
    let fine = super::Fineness { chord: 1e-3, turn: 0.1, least_length: 2e-3, joined: 1e-5 };
    let around = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)].map(|(u, v)| surface.point(DVec2::new(u, v)));
    let loops = [around.into_iter().zip(0..).collect::<Vec<_>>()];
    let cancel = task::Cancel::default();
    let domain = super::domain::domain(&mut surface, &loops, &fine, &cancel).unwrap();
    let made = |cancel: &task::Cancel| super::triangulate::triangulate(&surface, &domain, (1000, &fine), cancel);
    assert!(made(&cancel).is_ok_and(|mesh| mesh.triangles.len() > 2));
    cancel.cancel();
    assert_eq!(made(&cancel).err(), Some("cancelled"));
    assert_eq!(super::domain::domain(&mut surface.clone(), &loops, &fine, &cancel).err(), Some("cancelled"));
}

/// Both would take all of the stack.
#[test]
fn a_text_without_an_end_is_refused_and_long_comments_are_passed() {
    let sound = String::from_utf8(written(|b| cuboid(b, DVec3::splat(10.0)))).unwrap();
    let after = |what: &str| sound.replacen("DATA;", &format!("DATA;\n{what}"), 1);
    let texts = "#90001=CARTESIAN_POINT('',(0.0,0.0,0.0));\n".repeat(100_000);
    let error = read(after(&format!("'{texts}")).as_bytes(), &Options::default(), &Task::default()).unwrap_err();
    assert!(error.to_string().contains("does not end"), "{error}");
    closes(after(&format!("/*{}*/", "*".repeat(200_000))).as_bytes(), 1000.0, 1e-6);
}

/// Further away than numbers are exact curves would be halved for ever.
#[test]
fn a_point_at_the_end_of_the_world_is_answered_at_once() {
    let bytes = written(|b| cuboid(b, DVec3::new(64.0, 80.0, 100.5)));
    let text = String::from_utf8(bytes).unwrap();
    let points: Vec<usize> = text.match_indices("CARTESIAN_POINT('',(").map(|(at, _)| at).collect();
    assert!(points.len() > 8, "{text}");
    for far in ["1.1E308", "1.E30", "1.E13", "1.E9"] {
        for &at in &points {
            let end = at + text[at..].find("))").unwrap();
            let last = at + text[at..end].rfind(',').unwrap() + 1;
            let far = format!("{}{far}{}", &text[..last], &text[end..]);
            let _ = read(far.as_bytes(), &Options::default(), &Task::default());
        }
    }
}

/// Number of spoilt files that are tried: 400, or as many as the environment's `STEP_MUTATIONS` says.
fn mutations() -> usize {
    std::env::var("STEP_MUTATIONS").ok().and_then(|count| count.parse().ok()).unwrap_or(400)
}

#[test]
fn whatever_the_bytes_there_is_an_answer() {
    let sound = written(|b| cylinder(b, true));
    let mut state = 1u64;
    let mut random = |below: usize| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as usize % below
    };
    for _ in 0..mutations() {
        let mut bytes = sound.clone();
        for _ in 0..=random(4) {
            if bytes.is_empty() {
                break;
            }
            let at = random(bytes.len());
            match random(3) {
                0 => bytes[at] = b"0123456789.-#(),;'$*E"[random(21)],
                1 => drop(bytes.drain(at..(at + random(30)).min(bytes.len()))),
                _ => bytes.truncate(at.max(1)),
            }
        }
        let options = Options { max_triangles: 100_000, ..Options::default() };
        if let Ok(file) = read(&bytes, &options, &Task::default()) {
            assert!(file.solids.iter().all(|s| s.mesh.vertices.iter().all(|p| p.is_finite())));
        }
    }
}
