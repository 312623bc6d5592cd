//! Triangles that should not be there: collapsed, doubled, or without height.

use std::cmp::Ordering;

use glam::DVec3;

use super::edges::{EdgeTable, NONE, half_ends};
use geometry::mesh::{Mesh, normal_times_two_areas};
use task::{Cancelled, Task};

/// Removes triangles that have a vertex twice; returns their number.
///
/// Two other edges are one and the same, run through both ways, so the neighbours meet there: no hole opens.
pub(super) fn drop_collapsed(mesh: &mut Mesh) -> usize {
    let before = mesh.triangles.len();
    mesh.triangles.retain(|&[a, b, c]| a != b && b != c && c != a);
    before - mesh.triangles.len()
}

/// Removes triangles that lie on others with the same three vertices; returns their number.
///
/// Usually one of each set stays. Where that would open the surface, as at a fin without thickness or between two
/// bodies that touch, those that face each other are removed together, which leaves its boundary as it is. If neither
/// will do, all stay.
pub(super) fn drop_duplicates(mesh: &mut Mesh, table: &EdgeTable, task: &Task) -> Result<usize, Cancelled> {
    let sets = duplicate_sets(mesh, table);
    if sets.is_empty() {
        return Ok(0);
    }
    let before = table.boundary_size(mesh);
    let extra: usize = sets.iter().map(|set| set.len() - 1).sum();
    for choose in [all_but_first, facing_each_other] as [Choice; 2] {
        let thinned = without(mesh, sets.iter().flat_map(|set| choose(mesh, set)));
        // A sheet that is all double would vanish: that is no fin, and better kept.
        let vanishes = 2 * thinned.triangles.len() < mesh.triangles.len() - extra;
        let table = EdgeTable::of(&thinned, task)?;
        if !vanishes && table.boundary_size(&thinned) <= before {
            let removed = mesh.triangles.len() - thinned.triangles.len();
            *mesh = thinned;
            return Ok(removed);
        }
    }
    Ok(0)
}

/// The triangles to take out of a set that lie on each other.
type Choice = fn(&Mesh, &[u32]) -> Vec<u32>;

fn all_but_first(_: &Mesh, set: &[u32]) -> Vec<u32> {
    set[1..].to_vec()
}

/// Triangles to remove so that as many face one way as the other, and of the rest all but the first.
fn facing_each_other(mesh: &Mesh, set: &[u32]) -> Vec<u32> {
    let (even, odd): (Vec<u32>, Vec<u32>) = set.iter().partition(|&&t| is_even(mesh.triangles[t as usize]));
    match even.len().cmp(&odd.len()) {
        Ordering::Equal => set.to_vec(),
        Ordering::Greater => [&even[1..], &odd].concat(),
        Ordering::Less => [&even, &odd[1..]].concat(),
    }
}

/// Sets of two or more triangles with the same three vertices.
fn duplicate_sets(mesh: &Mesh, table: &EdgeTable) -> Vec<Vec<u32>> {
    let mut sets = Vec::new();
    let mut apexes: Vec<(u32, u32)> = Vec::new();
    for edge in table.edges().filter(|edge| edge.halves().len() > 1) {
        // Each triangle is looked at once: at the edge between its two lowest vertices.
        apexes.clear();
        apexes.extend(edge.halves().filter_map(|half| {
            let apex = mesh.triangles[half as usize / 3][(half as usize + 2) % 3];
            (apex > edge.high).then_some((apex, half / 3))
        }));
        apexes.sort_unstable();
        for set in apexes.chunk_by(|a, b| a.0 == b.0).filter(|set| set.len() > 1) {
            sets.push(set.iter().map(|&(_, triangle)| triangle).collect());
        }
    }
    sets
}

/// Whether the vertices go up when read from the lowest on: two triangles on the same vertices face the same way if
/// this is the same for both.
fn is_even([a, b, c]: [u32; 3]) -> bool {
    (a < b) as u8 + (b < c) as u8 + (c < a) as u8 == 2
}

fn without(mesh: &Mesh, dropped: impl Iterator<Item = u32>) -> Mesh {
    let mut keep = vec![true; mesh.triangles.len()];
    dropped.for_each(|t| keep[t as usize] = false);
    let triangles = mesh.triangles.iter().zip(keep).filter_map(|(&t, keep)| keep.then_some(t)).collect();
    Mesh { vertices: mesh.vertices.clone(), triangles }
}

/// Result of removing the triangles without height.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) struct Slivers {
    /// Number of slivers given a height by exchanging an edge with a neighbour.
    pub exchanged: usize,
    /// Number of slivers that remain.
    pub kept: usize,
}

/// How often edges are exchanged before the rest is left as it is: rows of slivers take one round each.
const ROUNDS: usize = 8;

/// Gives triangles lower than `height` (mm) a height by exchanging their longest edge.
///
/// A triangle of this kind has a corner on its opposite edge. Taking it out would leave a crack that no two edges
/// share; the exchange instead splits its neighbour at that corner and keeps the surface as closed as it was. No point
/// of the surface moves by more than `height`.
pub(super) fn exchange_slivers(mesh: &mut Mesh, height: f64, task: &Task) -> Result<Slivers, Cancelled> {
    let mut result = Slivers::default();
    for _ in 0..ROUNDS {
        let low: Vec<u32> = lower_than(mesh, height);
        result.kept = low.len();
        if low.is_empty() {
            break;
        }
        let table = EdgeTable::of(mesh, task)?;
        let twins = table.twins();
        // Exchanged triangles have new edges that the table does not know: they rest until the next round, and so
        // does everything at their vertices.
        let mut resting = vec![false; mesh.vertices.len()];
        let mut exchanged = 0;
        for t in low {
            exchanged += usize::from(exchange(mesh, &table, &twins, t, &mut resting));
        }
        if exchanged == 0 {
            break;
        }
        result.exchanged += exchanged;
        result.kept = lower_than(mesh, height).len();
    }
    Ok(result)
}

fn lower_than(mesh: &Mesh, height: f64) -> Vec<u32> {
    let low = mesh.iter_corners().enumerate().filter(|(_, corners)| least_height(*corners) < height);
    low.map(|(t, _)| t as u32).collect()
}

/// The least height of a triangle: twice its area over its longest edge.
fn least_height([a, b, c]: [DVec3; 3]) -> f64 {
    let longest = a.distance(b).max(b.distance(c)).max(c.distance(a));
    if longest > 0.0 { normal_times_two_areas([a, b, c]).length() / longest } else { 0.0 }
}

/// Exchanges the longest edge of triangle `t` for the other diagonal of the two triangles at it, if that helps.
fn exchange(mesh: &mut Mesh, table: &EdgeTable, twins: &[u32], t: u32, resting: &mut [bool]) -> bool {
    let length = |half: u32| {
        let (a, b) = half_ends(mesh, half);
        mesh.vertices[a as usize].distance_squared(mesh.vertices[b as usize])
    };
    let longest = (3 * t..3 * t + 3).fold(3 * t, |best, half| if length(half) > length(best) { half } else { best });
    let twin = twins[longest as usize];
    if twin == NONE {
        return false;
    }
    let apex = |half: u32| mesh.triangles[half as usize / 3][(half as usize + 2) % 3];
    let ((p, q), r, s) = (half_ends(mesh, longest), apex(longest), apex(twin));
    let corners = [p, q, r, s];
    if half_ends(mesh, twin) != (q, p) || table.contains(r, s) || corners.iter().any(|&v| resting[v as usize]) {
        return false;
    }
    let height = |triangle: [u32; 3]| least_height(triangle.map(|v| mesh.vertices[v as usize]));
    let (one, other) = ([p, s, r], [s, q, r]);
    if height(one).min(height(other)) <= height([p, q, r]) {
        return false;
    }
    mesh.triangles[t as usize] = one;
    mesh.triangles[twin as usize / 3] = other;
    corners.iter().for_each(|&v| resting[v as usize] = true);
    true
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table(mesh: &Mesh) -> EdgeTable {
        EdgeTable::of(mesh, &Task::default()).unwrap()
    }

    fn deduplicated(mut mesh: Mesh) -> (Mesh, usize) {
        let edges = table(&mesh);
        let removed = drop_duplicates(&mut mesh, &edges, &Task::default()).unwrap();
        (mesh, removed)
    }

    #[test]
    fn a_doubled_triangle_a_doubled_box_and_a_two_sided_box_become_the_box() {
        let solid = Mesh::cuboid(DVec3::ONE);
        let mut one = solid.clone();
        one.triangles.push(one.triangles[4]);
        let mut all = solid.clone();
        all.triangles.extend_from_slice(&solid.triangles);
        let mut two_sided = solid.clone();
        two_sided.triangles.extend(solid.triangles.iter().map(|&[a, b, c]| [c, b, a]));
        for (mesh, extra) in [(one, 1), (all, 12), (two_sided, 12)] {
            assert_eq!(deduplicated(mesh), (solid.clone(), extra));
        }
    }

    #[test]
    fn a_fin_without_thickness_goes_and_a_two_sided_sheet_stays() {
        let solid = Mesh::cuboid(DVec3::ONE);
        let mut finned = solid.clone();
        finned.vertices.push(DVec3::new(0.5, -1.0, -1.0));
        let [a, b, _] = solid.triangles[0];
        finned.triangles.extend([[a, b, 8], [b, a, 8]]);
        let (mesh, removed) = deduplicated(finned);
        assert_eq!((mesh.triangles, removed), (solid.triangles.clone(), 2));

        let sheet = Mesh { triangles: vec![[0, 1, 2], [2, 1, 3], [0, 2, 1], [2, 3, 1]], ..solid };
        assert_eq!(deduplicated(sheet.clone()), (sheet, 0));
    }

    /// A box whose edge between vertices 0 and 1 has extra points on one side only, joined by flat triangles.
    fn box_with_slivers(points: usize) -> Mesh {
        let mut mesh = Mesh::cuboid(DVec3::ONE);
        let half = (0..36).find(|&h| half_ends(&mesh, h) == (0, 1)).unwrap() as usize;
        let apex = mesh.triangles[half / 3][(half + 2) % 3];
        let mut on_edge = vec![0];
        for i in 1..=points {
            on_edge.push(mesh.vertices.len() as u32);
            mesh.vertices.push(DVec3::new(i as f64 / (points + 1) as f64, 0.0, 0.0));
        }
        on_edge.push(1);
        mesh.triangles.remove(half / 3);
        mesh.triangles.extend(on_edge.windows(2).map(|w| [w[0], w[1], apex]));
        // The flat fan between the straight edge and the divided one.
        mesh.triangles.extend(on_edge[1..].windows(2).map(|w| [0, w[1], w[0]]));
        mesh
    }

    #[test]
    fn flat_triangles_are_exchanged_and_the_box_stays_closed() {
        for points in 1..5 {
            let mut mesh = box_with_slivers(points);
            assert!(mesh.is_watertight());
            let slivers = exchange_slivers(&mut mesh, 1e-9, &Task::default()).unwrap();
            assert_eq!(slivers.kept, 0, "{points} points");
            assert!(slivers.exchanged >= points);
            assert!(mesh.is_watertight());
            assert!((mesh.volume() - 1.0).abs() < 1e-12 && (mesh.area() - 6.0).abs() < 1e-12);
            assert!(mesh.iter_corners().all(|c| least_height(c) > 0.1));
        }
    }
}
