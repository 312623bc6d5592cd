//! Small molds for tests.

pub use crate::random_mold::{polygon, rectangle, with};

use glam::{DVec2, DVec3};

use geometry::mesh::Mesh;
use geometry::weld::Weld;

/// A block of `[height, depth]` with a pocket: all outlines have as many corners, in the same directions.
pub fn pocket(block: &[DVec2], mouth: &[DVec2], floor: &[DVec2], [height, depth]: [f64; 2]) -> Mesh {
    dish(block, &[(mouth.to_vec(), height), (floor.to_vec(), height - depth)], height - depth)
}

/// A block with a hollow through outlines at heights, from its mouth down to a floor that closes the last of them at a
/// height.
pub fn dish(block: &[DVec2], levels: &[(Vec<DVec2>, f64)], floor: f64) -> Mesh {
    let at = |outline: &[DVec2], z: f64| outline.iter().map(|p| p.extend(z)).collect::<Vec<_>>();
    let mut rings = vec![at(block, 0.0), at(block, levels[0].1)];
    rings.extend(levels.iter().map(|(outline, z)| at(outline, *z)));
    let mut soup = strips(&rings);
    let last = &rings[rings.len() - 1];
    let n = last.len();
    let tip = DVec3::new(0.0, 0.0, floor);
    let is_point = last.iter().all(|p| p.distance(last[0]) == 0.0);
    if last[0].z == floor && !is_point {
        soup.extend((1..n - 1).map(|i| [last[0], last[i], last[i + 1]]));
    } else {
        soup.extend((0..n).map(|i| [last[i], last[(i + 1) % n], tip]));
    }
    soup.extend((1..n - 1).map(|i| [rings[0][0], rings[0][i + 1], rings[0][i]]));
    welded(&soup)
}

/// A block with a hole through it.
pub fn frame(block: &[DVec2], hole: &[DVec2], height: f64) -> Mesh {
    let at = |outline: &[DVec2], z: f64| outline.iter().map(|p| p.extend(z)).collect::<Vec<_>>();
    welded(&strips(&[at(block, 0.0), at(block, height), at(hole, height), at(hole, 0.0), at(block, 0.0)]))
}

/// Strips of triangles from each ring to the next.
fn strips(rings: &[Vec<DVec3>]) -> Vec<[DVec3; 3]> {
    let strip = |pair: &[Vec<DVec3>]| {
        let [low, high] = [pair[0].clone(), pair[1].clone()];
        let n = low.len();
        (0..n)
            .flat_map(move |i| {
                let j = (i + 1) % n;
                [[low[i], low[j], high[j]], [low[i], high[j], high[i]]]
            })
            .collect::<Vec<_>>()
    };
    rings.windows(2).flat_map(strip).collect()
}

fn welded(soup: &[[DVec3; 3]]) -> Mesh {
    let mut weld = Weld::default();
    let triangles = soup.iter().map(|corners| corners.map(|p| weld.add(p)));
    let triangles = triangles.filter(|[a, b, c]| a != b && b != c && c != a).collect();
    Mesh { vertices: weld.into_points(), triangles }
}
