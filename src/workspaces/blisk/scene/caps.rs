//! Lids for the holes that are left where a part of a mesh was taken away.

use std::collections::HashMap;

use glam::{DVec2, DVec3};

use geometry::mesh::Mesh;

/// Most points around a hole: the work grows with their square.
const MOST: usize = 4000;

/// Closes the holes of `mesh` by triangles between their points. Those whose outline branches or crosses itself
/// stay open.
pub(super) fn close_holes(mesh: &mut Mesh) {
    for outline in outlines(mesh) {
        if outline.len() <= MOST {
            mesh.triangles.extend(lid(&mesh.vertices, &outline).unwrap_or_default());
        }
    }
}

/// The outlines of all holes, counter-clockwise as a lid lies in them, in rising order of their first vertices.
fn outlines(mesh: &Mesh) -> Vec<Vec<u32>> {
    let edges = mesh.directed_edges();
    let mut rims: Vec<(u32, u32)> = edges.keys().filter(|(a, b)| !edges.contains_key(&(*b, *a))).copied().collect();
    rims.sort_unstable();
    // A lid passes the edges the other way.
    let mut next: HashMap<u32, Option<u32>> = HashMap::with_capacity(rims.len());
    for &(a, b) in &rims {
        next.entry(b).and_modify(|other| *other = None).or_insert(Some(a));
    }
    let mut outlines = Vec::new();
    for &(start, _) in &rims {
        let mut outline = Vec::new();
        let mut at = start;
        // What was passed is taken out, so that every outline is found once.
        while let Some(Some(following)) = next.remove(&at) {
            outline.push(at);
            at = following;
        }
        if at == start && outline.len() > 2 {
            outlines.push(outline);
        }
    }
    outlines
}

/// Triangles that fill an outline, cut off one by one where it has a corner with nothing in it (ear clipping, Meisters
/// 1975), seen along its mean normal; none if that does not work out.
fn lid(vertices: &[DVec3], outline: &[u32]) -> Option<Vec<[u32; 3]>> {
    let points: Vec<DVec3> = outline.iter().map(|&v| vertices[v as usize]).collect();
    let next = |i: usize| points[(i + 1) % points.len()];
    let normal = (0..points.len()).map(|i| (points[i] - points[0]).cross(next(i) - points[0])).sum::<DVec3>();
    let normal = normal.try_normalize()?;
    let (u, v) = normal.any_orthonormal_pair();
    // The pair and the normal make a right-handed frame.
    let flat: Vec<DVec2> = points.iter().map(|p| DVec2::new(u.dot(*p - points[0]), v.dot(*p - points[0]))).collect();
    let mut left: Vec<usize> = (0..outline.len()).collect();
    let corner =
        |left: &[usize], i: usize| [(i + left.len() - 1) % left.len(), i, (i + 1) % left.len()].map(|k| left[k]);
    // How round the triangle at each point is; none where it cannot be cut off.
    let ear = |left: &[usize], i: usize| {
        is_ear(&flat, left, corner(left, i)).then(|| roundness(corner(left, i).map(|k| flat[k])))
    };
    let mut ears: Vec<Option<f64>> = (0..left.len()).map(|i| ear(&left, i)).collect();
    let mut triangles = Vec::with_capacity(outline.len());
    while left.len() > 3 {
        // The roundest first: lids without needles look smooth.
        let found = ears.iter().enumerate().filter_map(|(i, ear)| Some((i, (*ear)?)));
        let (best, _) = found.max_by(|a, b| a.1.total_cmp(&b.1))?;
        triangles.push(corner(&left, best).map(|k| outline[k]));
        left.remove(best);
        ears.remove(best);
        // Nothing changes for any other point.
        for i in [(best + left.len() - 1) % left.len(), best % left.len()] {
            ears[i] = ear(&left, i);
        }
    }
    triangles.push([left[0], left[1], left[2]].map(|k| outline[k]));
    Some(triangles)
}

/// Whether a corner turns left and none of the other points lies in it.
fn is_ear(flat: &[DVec2], left: &[usize], corner: [usize; 3]) -> bool {
    let [a, b, c] = corner.map(|k| flat[k]);
    let side = |p: DVec2, q: DVec2, r: DVec2| (q - p).perp_dot(r - p);
    if side(a, b, c) <= 0.0 {
        return false;
    }
    let within = |p: DVec2| side(a, b, p) >= 0.0 && side(b, c, p) >= 0.0 && side(c, a, p) >= 0.0;
    !left.iter().any(|k| !corner.contains(k) && within(flat[*k]))
}

/// Area over the square of the longest side.
fn roundness([a, b, c]: [DVec2; 3]) -> f64 {
    let longest = a.distance_squared(b).max(b.distance_squared(c)).max(c.distance_squared(a));
    (b - a).perp_dot(c - a) / longest.max(f64::MIN_POSITIVE)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_box_without_a_side_gets_it_back() {
        let whole = Mesh::cuboid(DVec3::new(2.0, 3.0, 4.0));
        let mut open = Mesh { triangles: whole.triangles[2..].to_vec(), ..whole.clone() };
        close_holes(&mut open);
        assert!(open.is_watertight());
        assert!((open.volume() - 24.0).abs() < 1e-12 && (open.area() - 52.0).abs() < 1e-12);
    }

    #[test]
    fn a_crescent_is_filled_and_its_hollow_is_not() {
        // A ring sector of three quarters between radii 1 and 2.
        let arc = |r: f64, i: usize| DVec2::from_angle(1.5 * std::f64::consts::PI * i as f64 / 40.0) * r;
        let flat: Vec<DVec2> = (0..=40).map(|i| arc(2.0, i)).chain((0..=40).rev().map(|i| arc(1.0, i))).collect();
        let vertices: Vec<DVec3> = flat.iter().map(|p| p.extend(1.0)).collect();
        let outline: Vec<u32> = (0..vertices.len() as u32).collect();
        let triangles = lid(&vertices, &outline).unwrap();
        let area = Mesh { vertices, triangles }.area();
        let exact = 0.5 * 40.0 * (1.5 * std::f64::consts::PI / 40.0).sin() * (4.0 - 1.0);
        assert!((area - exact).abs() < 1e-9, "{area} of {exact}");
    }

    #[test]
    fn what_is_closed_stays_as_it_is() {
        let mut whole = Mesh::cuboid(DVec3::ONE);
        close_holes(&mut whole);
        assert_eq!(whole, Mesh::cuboid(DVec3::ONE));
    }
}
