use super::*;

fn square(side: f64) -> Vec<DVec2> {
    [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)].map(|(x, y)| DVec2::new(x, y) * side).to_vec()
}

fn block(at: DVec3, size: DVec3) -> Mesh {
    prism(&[&square(1.0)], 0.0, 1.0).unwrap().mapped(|p| at + p * size)
}

/// The edges of a box, each split close to one of its ends: in single precision both are one point.
#[test]
fn slivers_become_points_and_the_surface_stays_closed() {
    let whole = Mesh::cuboid(DVec3::new(3.0, 4.0, 5.0)).mapped(|p| p + DVec3::splat(40.0));
    let mut split = whole.clone();
    for (a, b) in [(0u32, 1u32), (0, 2), (5, 7), (6, 7)] {
        let middle = split.vertices.len() as u32;
        let [from, to] = [a, b].map(|v| split.vertices[v as usize]);
        split.vertices.push(from.lerp(to, 1e-7));
        let is_at = |t: &[u32; 3]| t.contains(&a) && t.contains(&b);
        let at: Vec<usize> = (0..split.triangles.len()).filter(|i| is_at(&split.triangles[*i])).collect();
        assert_eq!(at.len(), 2, "{a} {b} is an edge");
        for i in at {
            let triangle = split.triangles[i];
            split.triangles[i] = triangle.map(|v| if v == a { middle } else { v });
            split.triangles.push(triangle.map(|v| if v == b { middle } else { v }));
        }
    }
    assert!(split.is_watertight() && split.triangles.len() == 20);
    let found = without_slivers(split);
    assert!(found.is_watertight() && found.vertices.len() == 8 && found.triangles.len() == 12);
    assert!((found.volume() - whole.volume()).abs() < 1e-4);
    assert_eq!(without_slivers(whole.clone()), whole.compacted());
}

#[test]
fn a_prism_with_a_hole_has_the_volume_of_a_prism_with_a_hole() {
    let hole: Vec<DVec2> = square(2.0).iter().rev().map(|p| *p + DVec2::ONE).collect();
    let mesh = prism(&[&square(4.0), &hole], -1.0, 2.0).unwrap();
    assert!(mesh.is_watertight());
    assert!((mesh.volume() - 3.0 * 12.0).abs() < 1e-12, "{}", mesh.volume());
    assert_eq!(prism(&[&square(4.0)[..2]], 0.0, 1.0), Err(SolidError::Outline));
    let line = [DVec2::ZERO, DVec2::X, DVec2::X * 2.0];
    assert_eq!(prism(&[&line], 0.0, 1.0), Err(SolidError::Outline));
}

/// A frame with an arm in line with a side of its hole, in all directions.
#[test]
fn rings_whose_corners_lie_in_line_are_filled() {
    let outer = [(0.0, 1.1), (0.0, 0.0), (16.1, 0.0), (16.1, 11.1), (5.0, 11.1), (5.0, 1.1)];
    let hole = [(6.1, 1.1), (6.1, 10.0), (15.0, 10.0), (15.0, 1.1)];
    let area = 16.1 * 11.1 - 5.0 * 10.0 - 8.9 * 8.9;
    for quarters in 0..4 {
        for mirrored in [false, true] {
            let turn = DVec2::from_angle(f64::from(quarters) * std::f64::consts::FRAC_PI_2);
            let ring = |points: &[(f64, f64)]| {
                let mut ring: Vec<DVec2> =
                    points.iter().map(|(x, y)| turn.rotate(DVec2::new(if mirrored { -x } else { *x }, *y))).collect();
                if mirrored {
                    ring.reverse();
                }
                ring
            };
            let mesh = prism(&[&ring(&outer), &ring(&hole)], 0.0, 2.0).unwrap();
            assert!(mesh.is_watertight() && (mesh.volume() - 2.0 * area).abs() < 1e-9, "{quarters} {mirrored}");
        }
    }
    assert_eq!(prism(&[&ring_that_crosses()], 0.0, 1.0), Err(SolidError::Outline));
}

fn ring_that_crosses() -> Vec<DVec2> {
    [(0.0, 0.0), (4.0, 4.0), (4.0, 0.0), (0.0, 3.0)].map(DVec2::from).to_vec()
}

#[test]
fn blocks_add_up_also_where_faces_lie_in_one_another() {
    let (a, volume) = (block(DVec3::ZERO, DVec3::ONE), |m: &Mesh| m.volume());
    for (at, common) in
        [(DVec3::splat(0.5), 0.125), (DVec3::new(0.5, 0.0, 0.0), 0.5), (DVec3::new(0.25, 0.5, 0.0), 0.375)]
    {
        let b = block(at, DVec3::ONE);
        let (less, both, all) = (difference(&a, &b).unwrap(), intersection(&a, &b).unwrap(), union(&a, &b).unwrap());
        for (found, expected) in [(less, 1.0 - common), (both, common), (all, 2.0 - common)] {
            assert!(found.is_watertight() && (volume(&found) - expected).abs() < 1e-12, "{at}: {}", volume(&found));
        }
    }
}

#[test]
fn a_triangle_without_area_is_taken_in_by_its_neighbour_and_the_surface_stays_closed() {
    // A block with a corner in the middle of a side that only one of the two faces there knows, and a triangle
    // between.
    let mut mesh = block(DVec3::ZERO, DVec3::splat(2.0));
    let [a, b, c] = mesh.triangles[0];
    let middle = mesh.vertices.len() as u32;
    mesh.vertices.push(mesh.vertices[a as usize].midpoint(mesh.vertices[b as usize]));
    mesh.triangles[0] = [a, middle, c];
    mesh.triangles.extend([[middle, b, c], [a, b, middle]]);
    assert!(mesh.is_watertight());
    let triangles = without_collinear(&mesh.vertices, mesh.triangles.clone());
    assert_eq!(triangles.len(), mesh.triangles.len());
    let area = |t: &[u32; 3]| normal_times_two_areas(t.map(|v| mesh.vertices[v as usize])).length();
    assert!(triangles.iter().all(|t| area(t) > 0.5));
    let solid = wound(&mesh).unwrap();
    assert!(solid.is_watertight() && (solid.volume() - 8.0).abs() < 1e-12, "{}", solid.volume());
}

#[test]
fn nothing_is_left_of_a_block_within_another_and_open_surfaces_are_refused() {
    let (inner, outer) = (block(DVec3::ONE, DVec3::ONE), block(DVec3::ZERO, DVec3::splat(3.0)));
    assert!(difference(&inner, &outer).unwrap().triangles.is_empty());
    assert!(intersection(&inner, &block(DVec3::splat(9.0), DVec3::ONE)).unwrap().triangles.is_empty());
    let mut open = outer.clone();
    open.triangles.pop();
    assert!(matches!(difference(&inner, &open), Err(SolidError::NotClosed(_) | SolidError::Failed(_))));
    assert!(difference(&Mesh::default(), &outer).unwrap().triangles.is_empty());
    assert_eq!(union(&Mesh::default(), &outer).unwrap(), outer);
}
