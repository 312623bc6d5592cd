use super::*;

/// A sphere of radius `r` about `center` as a net of `n` by `2 n` quads, poles as fans.
pub(crate) fn sphere(r: f64, n: usize, center: DVec3) -> Mesh {
    let mut vertices = vec![center + DVec3::Z * r, center - DVec3::Z * r];
    let around = 2 * n;
    for i in 1..n {
        let polar = std::f64::consts::PI * i as f64 / n as f64;
        for j in 0..around {
            let azimuth = std::f64::consts::TAU * j as f64 / around as f64;
            let across = DVec3::new(azimuth.cos(), azimuth.sin(), 0.0) * polar.sin();
            vertices.push(center + (across + DVec3::Z * polar.cos()) * r);
        }
    }
    let at = |i: usize, j: usize| match i {
        0 => 0,
        i if i == n => 1,
        i => (2 + (i - 1) * around + j % around) as u32,
    };
    let quads = (0..n).flat_map(|i| (0..around).map(move |j| (i, j)));
    let triangles = quads
        .flat_map(|(i, j)| [[at(i, j), at(i + 1, j), at(i + 1, j + 1)], [at(i, j), at(i + 1, j + 1), at(i, j + 1)]])
        .filter(|[a, b, c]| a != b && b != c && c != a)
        .collect();
    Mesh { vertices, triangles }
}

fn normal_of(vertex: &Vertex) -> DVec3 {
    DVec3::from_array([0, 1, 2].map(|i| f64::from(vertex.normal[i]))) / f64::from(i16::MAX)
}

#[test]
fn a_box_has_three_normals_at_each_corner_and_twelve_edges() {
    let mesh = RenderMesh::new(&Mesh::cuboid(DVec3::new(1.0, 2.0, 3.0)));
    let full = mesh.full();
    assert_eq!((full.vertices.len(), full.indices.len(), full.edges.len()), (24, 36, 12));
    assert!(mesh.is_closed());
    for (t, corners) in full.indices.chunks(3).zip(mesh.source().iter_corners()) {
        for (&index, corner) in t.iter().zip(corners) {
            let vertex = &full.vertices[index as usize];
            assert!((normal_of(vertex) - unit_normal(corners)).length() < 1e-4);
            let position = DVec3::from_array(vertex.position.map(f64::from)) + mesh.origin();
            assert!((position - corner).length() < 1e-6);
            assert_eq!(mesh.source().vertices[full.sources[index as usize] as usize], corner);
        }
    }
}

#[test]
fn a_sphere_is_smooth_and_its_normals_are_radial() {
    let center = DVec3::new(1e6, -2e6, 3e6);
    let mesh = RenderMesh::new(&sphere(5.0, 40, center));
    assert!(mesh.is_closed() && mesh.full().edges.is_empty());
    assert_eq!(mesh.full().vertices.len(), mesh.source().vertices.len());
    for vertex in &mesh.full().vertices {
        let radial = DVec3::from_array(vertex.position.map(f64::from));
        // Far from the origin the positions are still those of a sphere to a few f32 units.
        assert!((radial.length() - 5.0).abs() < 1e-6, "{}", radial.length());
        assert!(normal_of(vertex).dot(radial / 5.0) > 0.999);
    }
}

#[test]
fn an_open_box_shows_its_rim_and_is_not_closed() {
    let mut mesh = Mesh::cuboid(DVec3::ONE);
    // Two coplanar triangles: taking one away leaves a rim of three sides, two of which were creases.
    mesh.triangles.pop();
    let open = RenderMesh::new(&mesh);
    assert!(!open.is_closed());
    assert_eq!(open.full().edges.len(), 13);
}

#[test]
fn a_vertex_with_very_many_faces_is_shaded_like_any_other() {
    let n = 3000;
    let rim = (0..n).map(|i| DVec3::from_array([f64::cos(i as f64 * 0.002), f64::sin(i as f64 * 0.002), 0.0]));
    let vertices = std::iter::once(DVec3::ZERO).chain(rim).collect();
    let mesh = RenderMesh::new(&Mesh { vertices, triangles: (1..n as u32 - 1).map(|i| [0, i, i + 1]).collect() });
    assert!(mesh.full().vertices.iter().all(|v| (normal_of(v) - DVec3::Z).length() < 1e-4));
    assert_eq!(mesh.full().vertices.len(), n);
}

#[test]
fn unusable_triangles_are_left_out_and_the_others_keep_their_place() {
    let mut mesh = Mesh::cuboid(DVec3::ONE);
    let bounds = mesh.bounds();
    mesh.vertices.push(DVec3::new(f64::NAN, 0.0, 0.0));
    mesh.vertices.push(DVec3::splat(1e9));
    mesh.triangles.insert(0, [0, 1, 8]);
    mesh.triangles.insert(0, [0, 1, 77]);
    let prepared = RenderMesh::new(&mesh);
    assert_eq!(prepared.bounds(), bounds);
    assert!(prepared.full().vertices.iter().all(|v| v.position.iter().all(|c| c.is_finite())));
    assert_eq!(prepared.source().triangles[2..], mesh.triangles[2..]);
    for empty in [Mesh::default(), Mesh { vertices: vec![DVec3::NAN], triangles: vec![[0, 0, 0]] }] {
        assert!(RenderMesh::new(&empty).is_empty() && RenderMesh::new(&empty).full().indices.is_empty());
    }
}

#[test]
fn the_lighter_level_is_light_and_stays_on_the_surface() {
    let (r, center) = (30.0, DVec3::new(4.0, 5.0, 6.0));
    let mesh = RenderMesh::new(&sphere(r, 250, center));
    let (full, lighter) = (mesh.full(), mesh.lighter());
    assert!(full.indices.len() > 3 * 240_000);
    assert!((10_000..60_000).contains(&(lighter.indices.len() / 3)), "{}", lighter.indices.len() / 3);
    let cell = simplify::cell_size(mesh.source(), LARGE_TARGET);
    for t in lighter.indices.chunks(3) {
        let corners = t.iter().map(|&i| DVec3::from_array(lighter.vertices[i as usize].position.map(f64::from)));
        let corners: Vec<DVec3> = corners.collect();
        // Corners lie on the sphere; the middle sags below it by at most what a side of two cells does.
        let middle = corners.iter().sum::<DVec3>() / 3.0;
        let sag = r - (r * r - 3.0 * 4.0 * cell * cell / 3.0).sqrt();
        assert!(corners.iter().all(|c| (c.length() - r).abs() < 1e-4));
        assert!(middle.length() <= r + 1e-6 && middle.length() > r - sag - 0.01, "{}", middle.length());
    }
    for (vertex, &source) in lighter.vertices.iter().zip(&lighter.sources) {
        let original = mesh.source().vertices[source as usize] - mesh.origin();
        assert!((original - DVec3::from_array(vertex.position.map(f64::from))).length() < 1e-4);
    }
    let small = RenderMesh::new(&Mesh::cuboid(DVec3::ONE));
    assert!(std::ptr::eq(small.lighter(), small.full()));
}

#[test]
fn a_smaller_mesh_has_a_lighter_level_unless_its_surface_would_be_lost() {
    let ball = RenderMesh::new(&sphere(5.0, 14, DVec3::ZERO));
    assert!(!ball.is_large());
    assert!((30..ball.triangle_count() / 4).contains(&(ball.lighter().indices.len() / 3)));
    // An open patch of few triangles keeps most of itself.
    let grid = |k: u32| DVec3::new(f64::from(k / 5), f64::from(k % 5), 0.0);
    let quads = (0..4).flat_map(|i| (0..4).map(move |j| [0, 5, 6, 1].map(|v| 5 * i + j + v)));
    let patch = RenderMesh::new(&Mesh {
        vertices: (0..25).map(grid).collect(),
        triangles: quads.flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]).collect(),
    });
    assert!((2..=16).contains(&(patch.lighter().indices.len() / 3)));
    let corner = |i: &u32| DVec3::from_array(patch.lighter().vertices[*i as usize].position.map(f64::from));
    let area = |t: &[u32]| (corner(&t[1]) - corner(&t[0])).cross(corner(&t[2]) - corner(&t[0])).length() / 2.0;
    assert!(patch.lighter().indices.chunks(3).map(area).sum::<f64>() >= 0.6 * 16.0);
    // A strip a hundred times as long as it is wide: its two sides would fall into one.
    let strip = Mesh {
        vertices: (0..402).map(|i| DVec3::new(f64::from(i / 2), f64::from(i % 2) * 2.0, 0.0)).collect(),
        triangles: (0..400).map(|i| if i % 2 == 0 { [i, i + 2, i + 1] } else { [i, i + 1, i + 2] }).collect(),
    };
    let strip = RenderMesh::new(&strip);
    assert!(std::ptr::eq(strip.lighter(), strip.full()));
}

#[test]
fn preparing_twice_gives_the_same_and_other_names() {
    let source = sphere(3.0, 40, DVec3::ONE);
    let (a, b) = (RenderMesh::new(&source), RenderMesh::new(&source));
    assert_ne!(a.id(), b.id());
    assert_eq!(a.full().vertices, b.full().vertices);
    assert_eq!(a.full().indices, b.full().indices);
}
