use std::f64::consts::{FRAC_PI_2, TAU};

use glam::{DMat3, DVec2};

use super::*;

fn segmented(mesh: &Mesh) -> Segmentation {
    let found = Segmentation::of(mesh, &SegmentationSettings::default());
    assert_eq!(found.face_of.len(), mesh.triangles.len());
    let of_faces: usize = found.faces.iter().map(|f| f.triangles.len()).sum();
    assert_eq!(of_faces, mesh.triangles.len(), "every triangle has one face");
    for (i, face) in found.faces.iter().enumerate() {
        assert!(face.triangles.iter().all(|&t| found.face_of[t as usize] == i as u32));
    }
    found
}

/// Rings of points, one above another, joined by quads; the first and last are closed by fans around their middles. A
/// ring is counter-clockwise seen from the end of the list.
fn stacked(rings: &[Vec<DVec3>]) -> Mesh {
    let n = rings[0].len() as u32;
    let mut mesh = Mesh { vertices: rings.concat(), triangles: Vec::new() };
    for k in 0..rings.len() as u32 - 1 {
        for i in 0..n {
            let (a, b) = (k * n + i, k * n + (i + 1) % n);
            mesh.triangles.extend([[a, b, b + n], [a, b + n, a + n]]);
        }
    }
    let last = (rings.len() as u32 - 1) * n;
    for (first, is_top) in [(0, false), (last, true)] {
        let ring = &rings[(first / n) as usize];
        let middle = mesh.vertices.len() as u32;
        mesh.vertices.push(ring.iter().sum::<DVec3>() / f64::from(n));
        for i in 0..n {
            let (a, b) = (first + i, first + (i + 1) % n);
            mesh.triangles.push(if is_top { [a, b, middle] } else { [b, a, middle] });
        }
    }
    mesh
}

fn circle(radius: f64, z: f64, count: u32) -> Vec<DVec3> {
    let at = |i: u32| DVec2::from_angle(TAU * f64::from(i) / f64::from(count)) * radius;
    (0..count).map(|i| at(i).extend(z)).collect()
}

/// A square post of 20 x 20 x `height`, one upright edge rounded by `radius` in `count` facets.
fn rounded_post(radius: f64, count: u32, height: f64) -> Mesh {
    let mut outline = vec![DVec2::ZERO, DVec2::new(20.0, 0.0)];
    let center = DVec2::splat(20.0 - radius);
    outline
        .extend((0..=count).map(|i| center + DVec2::from_angle(FRAC_PI_2 * f64::from(i) / f64::from(count)) * radius));
    outline.push(DVec2::new(0.0, 20.0));
    let ring = |z: f64| outline.iter().map(|p| p.extend(z)).collect();
    stacked(&[ring(0.0), ring(height)])
}

fn frustum() -> Mesh {
    stacked(&[circle(5.0, 0.0, 32), circle(3.0, 4.0, 32)])
}

/// The part of a sphere of radius 10 within 60 degrees of +Z.
fn cap() -> Mesh {
    let ring = |i: u32| {
        let angle = 60f64.to_radians() * (1.0 - f64::from(i) / 10.0);
        circle(10.0 * angle.sin(), 10.0 * angle.cos(), 40)
    };
    let mut mesh = stacked(&(0..10).map(ring).collect::<Vec<_>>());
    let tip = mesh.vertices.len() - 1;
    mesh.vertices[tip] = DVec3::new(0.0, 0.0, 10.0);
    mesh
}

/// A block of 40 x 30 x 20 with a hole of `outline` (convex, counter-clockwise, around the middle) from the top down to
/// `depth`. The top has vertices of its own at the places of the others.
fn pocketed(outline: &[DVec2], depth: f64) -> Mesh {
    let mut mesh = Mesh::cuboid(DVec3::new(40.0, 30.0, 20.0));
    mesh.triangles.retain(|t| t.iter().any(|&v| mesh.vertices[v as usize].z == 0.0));
    let rim = mesh.vertices.len() as u32;
    let corners = [[0.0, 0.0], [40.0, 0.0], [40.0, 30.0], [0.0, 30.0]].map(DVec2::from);
    mesh.vertices.extend(corners.iter().map(|p| p.extend(20.0)));
    let n = outline.len() as u32;
    let (upper, lower) = (rim + 4, rim + 4 + n);
    mesh.vertices.extend(outline.iter().map(|p| p.extend(20.0)));
    mesh.vertices.extend(outline.iter().map(|p| p.extend(20.0 - depth)));
    let nearest = |i: u32| match (outline[i as usize].x > 20.0, outline[i as usize].y > 15.0) {
        (false, false) => rim,
        (true, false) => rim + 1,
        (true, true) => rim + 2,
        (false, true) => rim + 3,
    };
    for (i, j) in (0..n).map(|i| (i, (i + 1) % n)) {
        mesh.triangles.push([upper + i, nearest(i), upper + j]);
        if nearest(i) != nearest(j) {
            mesh.triangles.push([nearest(i), nearest(j), upper + j]);
        }
        mesh.triangles.extend([[upper + i, upper + j, lower + j], [upper + i, lower + j, lower + i]]);
    }
    mesh.triangles.extend((1..n - 1).map(|i| [lower, lower + i, lower + i + 1]));
    mesh
}

fn square_pocket() -> Mesh {
    pocketed(&[[10.0, 10.0], [30.0, 10.0], [30.0, 20.0], [10.0, 20.0]].map(DVec2::from), 8.0)
}

fn round_pocket() -> Mesh {
    let outline: Vec<DVec2> =
        circle(6.0, 0.0, 36).iter().map(|p| DVec2::from_angle(0.05).rotate(p.truncate())).collect();
    pocketed(&outline.iter().map(|p| p + DVec2::new(20.0, 15.0)).collect::<Vec<_>>(), 8.0)
}

/// A rigid motion that leaves no axis where it was.
fn moved(mesh: &Mesh) -> Mesh {
    let turn = DMat3::from_axis_angle(DVec3::new(1.0, 2.0, -0.7).normalize(), 1.1);
    mesh.mapped(|p| turn * p + DVec3::new(31.0, -17.0, 55.0))
}

/// Mesh rounded as in a binary STL.
fn rounded(mesh: &Mesh) -> Mesh {
    mesh.mapped(|p| p.as_vec3().as_dvec3())
}

/// Every triangle cut into four at the middles of its sides.
fn split(mesh: &Mesh) -> Mesh {
    let mut fine = Mesh { vertices: mesh.vertices.clone(), triangles: Vec::new() };
    for &[a, b, c] in &mesh.triangles {
        let first = fine.vertices.len() as u32;
        let middle = |i: u32, j: u32| mesh.vertices[i as usize].midpoint(mesh.vertices[j as usize]);
        fine.vertices.extend([middle(a, b), middle(b, c), middle(c, a)]);
        let [ab, bc, ca] = [first, first + 1, first + 2];
        fine.triangles.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
    }
    fine
}

/// Other numbers for the triangles, and other first corners.
fn reordered(mesh: &Mesh) -> Mesh {
    let n = mesh.triangles.len();
    let step = [7919, 7907].into_iter().find(|step| !n.is_multiple_of(*step)).unwrap();
    let mut triangles: Vec<[u32; 3]> = (0..n).map(|i| mesh.triangles[i * step % n]).collect();
    triangles.iter_mut().enumerate().for_each(|(i, t)| t.rotate_left(i % 3));
    Mesh { vertices: mesh.vertices.clone(), triangles }
}

fn bodies() -> [(&'static str, Mesh); 6] {
    [
        ("box", Mesh::cuboid(DVec3::new(2.0, 3.0, 4.0))),
        ("square pocket", square_pocket()),
        ("round pocket", round_pocket()),
        ("post", rounded_post(3.0, 8, 30.0)),
        ("frustum", frustum()),
        ("cap", cap()),
    ]
}

/// Properties that do not depend on place, order or cuts: form, size and area of each face, kind, angle, form and
/// length of each edge, in thousandths.
fn signature(found: &Segmentation) -> (Vec<[i64; 4]>, Vec<[i64; 4]>) {
    let thousandths = |v: f64| (v * 1e3).round() as i64;
    let mut faces: Vec<_> = found
        .faces
        .iter()
        .map(|f| {
            let (form, size, is_hollow) = match f.kind {
                FaceKind::Plane { .. } => (0, 0.0, false),
                FaceKind::Cylinder { radius, is_hollow, .. } => (1, radius, is_hollow),
                FaceKind::Cone { half_angle, is_hollow, .. } => (2, half_angle, is_hollow),
                // Of triangles alone neither a sphere nor a torus is told.
                FaceKind::Sphere { .. } | FaceKind::Torus { .. } | FaceKind::FreeForm => (3, 0.0, false),
            };
            [form, thousandths(size), i64::from(is_hollow), thousandths(f.area)]
        })
        .collect();
    let mut edges: Vec<_> = found
        .edges
        .iter()
        .map(|e| [e.kind as i64, i64::from(e.is_straight), thousandths(e.length), thousandths(e.angle)])
        .collect();
    faces.sort_unstable();
    edges.sort_unstable();
    (faces, edges)
}

fn count(found: &Segmentation, is_of: impl Fn(&Edge) -> bool) -> usize {
    found.edges.iter().filter(|e| is_of(e)).count()
}

#[test]
fn a_box_has_six_planes_and_twelve_edges() {
    let size = DVec3::new(2.0, 3.0, 4.0);
    let found = segmented(&Mesh::cuboid(size));
    assert_eq!((found.faces.len(), found.edges.len()), (6, 12));
    for face in &found.faces {
        let FaceKind::Plane { normal, offset } = face.kind else { panic!("{face:?}") };
        let outer = normal.max(DVec3::ZERO).dot(size);
        assert!((offset - outer).abs() < 1e-12, "{face:?}");
        let area = size.element_product() / normal.abs().dot(size);
        assert!((face.area - area).abs() < 1e-12 && face.deviation < 1e-12);
    }
    for edge in &found.edges {
        assert_eq!(edge.kind, EdgeKind::Convex);
        assert!((edge.angle - FRAC_PI_2).abs() < 1e-12 && edge.is_straight && edge.vertices.len() == 2, "{edge:?}");
    }
    let total: f64 = found.edges.iter().map(|e| e.length).sum();
    assert!((total - 36.0).abs() < 1e-12, "four times 2 + 3 + 4");
}

#[test]
fn a_pocket_has_concave_edges_at_its_foot() {
    let found = segmented(&square_pocket());
    assert_eq!(found.faces.len(), 11);
    assert!(found.faces.iter().all(|f| matches!(f.kind, FaceKind::Plane { .. })));
    assert_eq!(count(&found, |e| e.kind == EdgeKind::Convex), 16, "12 outside, 4 at the mouth");
    assert_eq!(count(&found, |e| e.kind == EdgeKind::Concave), 8, "4 upright, 4 at the foot");
    assert!(found.edges.iter().all(|e| e.is_straight && (e.angle.abs() - FRAC_PI_2).abs() < 1e-12));
}

#[test]
fn a_rounded_edge_is_a_cylinder_tangent_to_its_neighbours() {
    let found = segmented(&rounded_post(3.0, 8, 30.0));
    assert_eq!(found.faces.len(), 7);
    let rounding = found.faces.iter().position(|f| matches!(f.kind, FaceKind::Cylinder { .. })).unwrap();
    let FaceKind::Cylinder { point, direction, radius, is_hollow } = found.faces[rounding].kind else { panic!() };
    assert!((radius - 3.0).abs() < 1e-6 && !is_hollow && direction.z.abs() > 1.0 - 1e-12);
    assert!(point.truncate().distance(DVec2::splat(17.0)) < 1e-6, "{point}");
    let chord = 2.0 * 3.0 * (FRAC_PI_2 / 16.0).sin();
    assert!((found.faces[rounding].area - 8.0 * chord * 30.0).abs() < 1e-9);
    let smooth: Vec<_> = found.edges.iter().filter(|e| e.kind == EdgeKind::Smooth).collect();
    assert_eq!(smooth.len(), 2);
    assert!(smooth.iter().all(|e| e.is_straight && e.angle.abs() < 1e-6 && (e.length - 30.0).abs() < 1e-12));
    let arcs: Vec<_> = found.edges.iter().filter(|e| !e.is_straight).collect();
    assert_eq!((arcs.len(), found.edges.len()), (2, 15));
    for arc in arcs {
        assert!(arc.faces.contains(&(rounding as u32)) && arc.vertices.len() == 9 && !arc.is_closed());
        assert!((arc.bend - 3.0 * (1.0 - 0.5f64.sqrt())).abs() < 1e-9, "the height of a quarter's arc: {}", arc.bend);
    }
}

#[test]
fn a_blind_hole_is_a_hollow_cylinder_between_closed_edges() {
    let found = segmented(&round_pocket());
    let hole = found.faces.iter().find(|f| matches!(f.kind, FaceKind::Cylinder { .. })).unwrap();
    let FaceKind::Cylinder { radius, is_hollow, .. } = hole.kind else { panic!() };
    assert!((radius - 6.0).abs() < 1e-6 && is_hollow);
    assert_eq!(found.faces.len(), 8);
    let closed: Vec<_> = found.edges.iter().filter(|e| e.is_closed()).map(|e| (e.kind, e.vertices.len())).collect();
    assert_eq!(closed, [(EdgeKind::Convex, 37), (EdgeKind::Concave, 37)]);
    assert_eq!(found.edges.len(), 14);
}

#[test]
fn a_frustum_is_a_cone_between_two_planes() {
    let found = segmented(&frustum());
    assert_eq!((found.faces.len(), found.edges.len()), (3, 2));
    let cone = found.faces.iter().find(|f| matches!(f.kind, FaceKind::Cone { .. })).unwrap();
    let FaceKind::Cone { apex, axis, half_angle, is_hollow } = cone.kind else { panic!() };
    assert!((half_angle - 0.5f64.atan()).abs() < 1e-7, "{half_angle}");
    assert!(apex.distance(DVec3::Z * 10.0) < 1e-5 && axis.z < -1.0 + 1e-12 && !is_hollow);
    // Normals of the cone stand 90 degrees less its half angle from the axis, away from the foot.
    let mut angles: Vec<f64> = found.edges.iter().map(|e| e.angle).collect();
    angles.sort_by(f64::total_cmp);
    let expected = [FRAC_PI_2 - 0.5f64.atan(), FRAC_PI_2 + 0.5f64.atan()];
    assert!(angles.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-6), "{angles:?}");
}

#[test]
fn a_spherical_cap_is_one_free_form() {
    let found = segmented(&cap());
    let free: Vec<_> = found.faces.iter().filter(|f| f.kind == FaceKind::FreeForm).collect();
    assert_eq!((found.faces.len(), free.len(), free[0].triangles.len()), (2, 1, 9 * 80 + 40));
    assert_eq!(found.edges.len(), 1);
    assert!(found.edges[0].is_closed() && found.edges[0].kind == EdgeKind::Convex);
}

#[test]
fn place_order_cuts_and_rounding_change_nothing() {
    for (name, mesh) in bodies() {
        let expected = signature(&segmented(&mesh));
        let others = [
            ("moved", moved(&mesh)),
            ("reordered", reordered(&mesh)),
            ("split", split(&mesh)),
            ("split twice and moved", moved(&split(&split(&mesh)))),
        ];
        for (how, other) in others {
            assert_eq!(signature(&segmented(&other)), expected, "{name} {how}");
        }
        // Rounding may move an area or length by a thousandth.
        for other in [rounded(&moved(&mesh)), rounded(&moved(&split(&reordered(&mesh))))] {
            let found = signature(&segmented(&other));
            let near = |a: &[[i64; 4]], b: &[[i64; 4]]| {
                a.len() == b.len() && a.iter().flatten().zip(b.iter().flatten()).all(|(x, y)| (x - y).abs() <= 1)
            };
            assert!(near(&found.0, &expected.0) && near(&found.1, &expected.1), "{name}: {found:?} not {expected:?}");
        }
    }
}

#[test]
fn slivers_belong_to_the_face_that_they_lie_in() {
    // A vertex so near a side that its triangle's normal is mere rounding.
    let mut mesh = moved(&Mesh::cuboid(DVec3::splat(10.0)));
    let [a, b, c] = mesh.triangles[0];
    let corner = |v: u32| mesh.vertices[v as usize];
    let near = corner(a).lerp(corner(b), 0.4).lerp(corner(c), 1e-8);
    let new = mesh.vertices.len() as u32;
    mesh.vertices.push(near);
    mesh.triangles[0] = [a, b, new];
    mesh.triangles.extend([[b, c, new], [c, a, new]]);
    let found = segmented(&rounded(&mesh));
    assert_eq!((found.faces.len(), found.edges.len()), (6, 12));
}

#[test]
fn an_open_mesh_has_edges_between_faces_only() {
    let mut mesh = Mesh::cuboid(DVec3::ONE);
    mesh.triangles.truncate(10);
    let found = segmented(&mesh);
    assert_eq!((found.faces.len(), found.edges.len()), (5, 8), "a box without a lid");
    let mut half = frustum();
    half.triangles.retain(|t| t.iter().all(|&v| half.vertices[v as usize].y > -1e-9));
    let found = segmented(&half);
    assert_eq!(count(&found, |e| e.kind == EdgeKind::Convex), 2);
    assert!(found.faces.iter().any(|f| matches!(f.kind, FaceKind::Cone { .. })), "{:?}", found.faces);
}

#[test]
fn nonsense_makes_no_panic() {
    assert_eq!(Segmentation::of(&Mesh::default(), &SegmentationSettings::default()), Segmentation::default());
    let vertices = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.5, 0.0, 0.0], [f64::NAN, 0.0, 0.0], [1e300; 3]];
    let vertices: Vec<DVec3> = vertices.map(DVec3::from).to_vec();
    let triangles =
        vec![[0, 1, 2], [0, 1, 3], [0, 0, 1], [2, 2, 2], [0, 1, 4], [9, 1, 2], [0, 5, 1], [1, 0, 2], [0, 1, 2]];
    let found = segmented(&Mesh { vertices, triangles });
    assert!(found.faces.iter().all(|f| f.area >= 0.0));
    let strange = SegmentationSettings {
        plane_tolerance: f64::NAN,
        plane_angle_deg: f64::INFINITY,
        fit_tolerance: -1.0,
        strip_angle_deg: f64::NAN,
        ..SegmentationSettings::default()
    };
    for (_, mesh) in bodies() {
        assert_eq!(Segmentation::of(&mesh, &strange).face_of.len(), mesh.triangles.len());
    }
}
