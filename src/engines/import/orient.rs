//! Turning triangles so that all of them are counter-clockwise seen from outside the material.

use glam::DVec3;

use super::edges::{EdgeTable, NONE, half_ends};
use super::holes::Boundary;
use super::nesting::cavities;
use super::source::tick;
use geometry::mesh::{Bounds, Mesh, normal_times_two_areas};
use task::{Cancelled, Task};

/// Findings about orientation, and the corrections made.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Orientation {
    /// Triangles turned because they disagreed with most of their part.
    pub flipped: usize,
    /// Parts: triangles connected over edges that join exactly two of them.
    pub parts: usize,
    /// Parts turned as a whole.
    pub turned: usize,
    /// Closed parts inside others that bound a cavity.
    pub cavities: usize,
    /// Parts whose outside cannot be told; they stay as they came.
    pub unsure: usize,
    /// Parts that have one side only, like a Moebius band.
    pub one_sided: usize,
    /// Whether there were too many parts to see which lie inside others; they are taken to lie side by side.
    pub nesting_unknown: bool,
}

/// A connected part of the surface; volumes are for the directions that most of its triangles have.
#[derive(Debug, Clone)]
pub(super) struct Part {
    pub(super) bounds: Bounds,
    /// Some point on it.
    pub(super) point: DVec3,
    pub(super) volume: f64,
    area: f64,
    /// Area of the caps that close its holes (mm^2).
    caps: f64,
    pub(super) closed: bool,
    /// Whether edges of three or more triangles leave its boundary in doubt.
    branched: bool,
}

/// How large the missing part of a surface may be, relative to the whole, for inside and outside to be distinguished.
/// A box without one of its twelve triangles misses a twelfth; a lone pocket without a block around it misses more.
const LARGEST_GAP: f64 = 0.1;

/// Turns the triangles of `mesh` outwards; `table` and `boundary` must be of this mesh and remain so as to edges,
/// though not as to directions.
///
/// Within a part all triangles are made to agree. A closed part is then given a positive volume, unless it lies
/// wholly inside the material of others: then it bounds a cavity and its volume is negative. Parts that cross or touch
/// are solids that overlap. An open part is treated as a solid with its holes closed by flat caps, if these are small;
/// otherwise it stays as it came.
pub(super) fn orient(
    mesh: &mut Mesh,
    table: &EdgeTable,
    boundary: &Boundary,
    task: &Task,
) -> Result<Orientation, Cancelled> {
    let patches = Patches::find(mesh, &table.twins(), task)?;
    let mut result = Orientation {
        parts: patches.count,
        one_sided: patches.one_sided.iter().filter(|&&x| x).count(),
        ..Default::default()
    };
    result.flipped = patches.flip.iter().filter(|&&flip| flip).count();
    let parts = measure(mesh, &patches, table, boundary);
    let nesting = cavities(mesh, &patches, &parts, &task.cancel)?;
    result.nesting_unknown = nesting.is_none();
    let is_cavity = nesting.unwrap_or_else(|| vec![false; parts.len()]);
    let mut turn = vec![false; parts.len()];
    for (i, part) in parts.iter().enumerate() {
        let sure = !part.branched && !patches.one_sided[i] && part.caps <= LARGEST_GAP * part.area;
        // A volume beneath rounding says nothing.
        if !sure || part.volume.abs() <= 1e-12 * part.area.powf(1.5) {
            result.unsure += 1;
            continue;
        }
        result.cavities += usize::from(is_cavity[i]);
        turn[i] = (part.volume < 0.0) != is_cavity[i];
    }
    result.turned = turn.iter().filter(|&&t| t).count();
    for (t, triangle) in mesh.triangles.iter_mut().enumerate() {
        if patches.flip[t] != turn[patches.of[t] as usize] {
            triangle.swap(1, 2);
        }
    }
    Ok(result)
}

/// The parts of a mesh, and which triangles disagree with most of their part.
pub(super) struct Patches {
    count: usize,
    /// Part of each triangle.
    of: Vec<u32>,
    /// Whether a triangle disagrees with most of its part.
    pub(super) flip: Vec<bool>,
    /// Whether a part has triangles that cannot be made to agree.
    one_sided: Vec<bool>,
}

impl Patches {
    fn find(mesh: &Mesh, twins: &[u32], task: &Task) -> Result<Self, Cancelled> {
        let count = mesh.triangles.len();
        let mut patches = Self { count: 0, of: vec![NONE; count], flip: vec![false; count], one_sided: Vec::new() };
        let mut members: Vec<u32> = Vec::new();
        let mut done = 0;
        for seed in 0..count as u32 {
            if patches.of[seed as usize] != NONE {
                continue;
            }
            members.clear();
            members.push(seed);
            patches.of[seed as usize] = patches.count as u32;
            let mut one_sided = false;
            let mut next = 0;
            while let Some(&t) = members.get(next) {
                tick(task, "turning triangles", done, count)?;
                (next, done) = (next + 1, done + 1);
                for half in 3 * t..3 * t + 3 {
                    let twin = twins[half as usize];
                    if twin == NONE {
                        continue;
                    }
                    let other = twin as usize / 3;
                    let agrees = half_ends(mesh, half).0 != half_ends(mesh, twin).0;
                    let flip = patches.flip[t as usize] == agrees;
                    if patches.of[other] == NONE {
                        patches.of[other] = patches.count as u32;
                        patches.flip[other] = flip;
                        members.push(other as u32);
                    } else {
                        one_sided |= patches.flip[other] != flip;
                    }
                }
            }
            patches.settle(&members);
            patches.one_sided.push(one_sided);
            patches.count += 1;
        }
        Ok(patches)
    }

    /// Makes the majority of `members` right.
    fn settle(&mut self, members: &[u32]) {
        let flips = members.iter().filter(|&&t| self.flip[t as usize]).count();
        if 2 * flips > members.len() {
            members.iter().for_each(|&t| self.flip[t as usize] = !self.flip[t as usize]);
        }
    }

    /// The triangles of each part, and where each part's begin.
    pub(super) fn members(&self) -> (Vec<u32>, Vec<usize>) {
        let mut start = vec![0; self.count + 1];
        self.of.iter().for_each(|&part| start[part as usize + 1] += 1);
        (1..start.len()).for_each(|i| start[i] += start[i - 1]);
        let mut next = start.clone();
        let mut triangles = vec![0; self.of.len()];
        for (t, &part) in self.of.iter().enumerate() {
            triangles[next[part as usize]] = t as u32;
            next[part as usize] += 1;
        }
        (triangles, start)
    }
}

fn measure(mesh: &Mesh, patches: &Patches, table: &EdgeTable, boundary: &Boundary) -> Vec<Part> {
    let empty = Part {
        bounds: Bounds::EMPTY,
        point: DVec3::ZERO,
        volume: 0.0,
        area: 0.0,
        caps: 0.0,
        closed: true,
        branched: false,
    };
    let mut parts = vec![empty; patches.count];
    // Six times the volume under a triangle, seen from a point of its part.
    let under = |[a, b, c]: [DVec3; 3], from: DVec3| (a - from).dot((b - from).cross(c - from));
    let sign = |t: usize| if patches.flip[t] { -1.0 } else { 1.0 };
    for (t, corners) in mesh.iter_corners().enumerate() {
        let part = &mut parts[patches.of[t] as usize];
        if part.area == 0.0 {
            part.point = corners[0];
        }
        let bounds = Bounds::of(corners);
        part.bounds = Bounds { min: part.bounds.min.min(bounds.min), max: part.bounds.max.max(bounds.max) };
        part.area += normal_times_two_areas(corners).length() / 2.0;
        part.volume += sign(t) * under(corners, part.point) / 6.0;
    }
    for (&half, &hole) in boundary.halves.iter().zip(&boundary.hole_of) {
        let t = half as usize / 3;
        let part = &mut parts[patches.of[t] as usize];
        let (a, b) = half_ends(mesh, half);
        let cap = [b, a].map(|v| mesh.vertices[v as usize]);
        let cap = [cap[0], cap[1], boundary.holes[hole as usize].center_mm];
        part.closed = false;
        part.caps += normal_times_two_areas(cap).length() / 2.0;
        part.volume += sign(t) * under(cap, part.point) / 6.0;
    }
    for edge in table.edges().filter(|edge| edge.halves().len() > 2) {
        let mut balance: Vec<(u32, i32)> = edge
            .halves()
            .map(|half| {
                let t = half as usize / 3;
                let forward = (half_ends(mesh, half).0 == edge.low) != patches.flip[t];
                (patches.of[t], if forward { 1 } else { -1 })
            })
            .collect();
        balance.sort_unstable();
        for one in balance.chunk_by(|a, b| a.0 == b.0) {
            if one.iter().map(|&(_, sign)| sign).sum::<i32>() != 0 {
                let part = &mut parts[one[0].0 as usize];
                (part.closed, part.branched) = (false, true);
            }
        }
    }
    parts
}

#[cfg(test)]
mod tests {
    use super::super::holes::trace;
    use super::*;

    fn oriented(mesh: &Mesh) -> (Mesh, Orientation) {
        let mut mesh = mesh.clone();
        let task = Task::default();
        let table = EdgeTable::of(&mesh, &task).unwrap();
        let boundary = trace(&mesh, &table);
        let orientation = orient(&mut mesh, &table, &boundary, &task).unwrap();
        (mesh, orientation)
    }

    fn append(mesh: &mut Mesh, other: &Mesh) {
        let base = mesh.vertices.len() as u32;
        mesh.vertices.extend_from_slice(&other.vertices);
        mesh.triangles.extend(other.triangles.iter().map(|t| t.map(|v| v + base)));
    }

    fn inside_out(mut mesh: Mesh) -> Mesh {
        mesh.triangles.iter_mut().for_each(|t| t.swap(1, 2));
        mesh
    }

    #[test]
    fn any_choice_of_turned_triangles_of_a_box_is_undone() {
        let solid = Mesh::cuboid(DVec3::new(1.0, 2.0, 3.0)).mapped(|p| p + 1e3);
        for choice in 0..1_u32 << 12 {
            let mut mesh = solid.clone();
            let turned = (0..12).filter(|&t| choice >> t & 1 == 1);
            turned.for_each(|t| mesh.triangles[t].swap(1, 2));
            let (mesh, result) = oriented(&mesh);
            assert!(mesh.is_watertight() && (mesh.volume() - 6.0).abs() < 1e-6);
            let count = choice.count_ones() as usize;
            assert_eq!(result.flipped, count.min(12 - count));
            if count != 6 {
                assert_eq!(result.turned, usize::from(count > 6));
            }
        }
    }

    #[test]
    fn shells_inside_shells_alternate() {
        let cube = |half: f64| Mesh::cuboid(DVec3::splat(2.0 * half)).mapped(|p| p - half);
        let mut mesh = inside_out(cube(1.0));
        append(&mut mesh, &cube(2.0));
        append(&mut mesh, &inside_out(cube(3.0)));
        append(&mut mesh, &cube(1.0).mapped(|p| p + 10.0));
        let (mesh, result) = oriented(&mesh);
        assert_eq!((result.parts, result.cavities, result.turned), (4, 1, 3));
        assert!((mesh.volume() - (216.0 - 64.0 + 8.0 + 8.0)).abs() < 1e-9);
    }

    /// A block of 10 mm with its cavities and ribs, each given by its corners, in either direction of the file.
    fn block_with(inner: &[(DVec3, DVec3, bool)]) -> Mesh {
        let mut mesh = Mesh::cuboid(DVec3::splat(10.0));
        for &(from, to, is_cavity) in inner {
            let shell = Mesh::cuboid(to - from).mapped(|p| p + from);
            append(&mut mesh, &if is_cavity { inside_out(shell) } else { shell });
        }
        mesh
    }

    #[test]
    fn a_shell_that_touches_the_one_around_it_is_a_solid() {
        let at = DVec3::new;
        for (from, cavities) in [(at(0.0, 1.0, 1.0), 0), (at(1e-3, 1.0, 1.0), 1)] {
            let (mesh, result) = oriented(&block_with(&[(from, from + at(1.0, 2.0, 3.0), cavities == 0)]));
            assert_eq!((result.turned, result.cavities), (1, cavities));
            let volume = if cavities == 0 { 1006.0 } else { 994.0 };
            assert!((mesh.volume() - volume).abs() < 1e-9);
        }
    }

    /// A bar across the hole of a block, with one end in the material: its box and its first corner lie in the block's.
    #[test]
    fn a_shell_that_crosses_the_one_around_it_is_a_solid() {
        let mut mesh = block_with(&[]);
        let notch = Mesh::cuboid(DVec3::new(6.0, 6.0, 12.0)).mapped(|p| p + DVec3::new(2.0, 2.0, -1.0));
        mesh = geometry::solid::difference(&mesh, &notch).unwrap();
        let bar = Mesh::cuboid(DVec3::new(2.0, 1.0, 8.0)).mapped(|p| p + DVec3::new(1.0, 4.0, 1.0));
        append(&mut mesh, &bar);
        for (given, turned) in [(mesh.clone(), 0), (inside_out(mesh), 2)] {
            let (mesh, result) = oriented(&given);
            assert_eq!((result.parts, result.turned, result.cavities), (2, turned, 0));
            assert!((mesh.volume() - (1000.0 - 360.0 + 16.0)).abs() < 1e-6);
        }
    }

    #[test]
    fn a_cavity_stays_one_where_ribs_cross_it_and_where_solids_around_it_overlap() {
        let at = DVec3::new;
        let cavity = (at(2.0, 2.0, 2.0), at(8.0, 8.0, 8.0), true);
        let ribbed = block_with(&[cavity, (at(1.0, 4.0, 4.0), at(9.0, 5.0, 5.0), false)]);
        for (given, turned) in [(ribbed.clone(), 0), (inside_out(ribbed), 3)] {
            let (mesh, result) = oriented(&given);
            assert_eq!((result.turned, result.cavities), (turned, 1));
            assert!((mesh.volume() - (1000.0 - 216.0 + 8.0)).abs() < 1e-9);
        }
        let overlapping = block_with(&[(at(-1.0, -1.0, 1.0), at(11.0, 11.0, 9.0), false), cavity]);
        let (mesh, result) = oriented(&overlapping);
        assert_eq!((result.turned, result.cavities), (0, 1));
        assert!((mesh.volume() - (1000.0 + 1152.0 - 216.0)).abs() < 1e-9);
    }

    #[test]
    fn a_box_with_a_small_hole_has_an_outside_and_a_sheet_has_none() {
        let mut mesh = inside_out(Mesh::cuboid(DVec3::ONE));
        mesh.triangles.pop();
        let (open, result) = oriented(&mesh);
        assert_eq!((result.turned, result.unsure), (1, 0));
        let missing = inside_out(mesh.clone()).triangles;
        assert_eq!(open.triangles, missing);

        mesh.triangles.truncate(4);
        let (sheet, result) = oriented(&mesh);
        assert_eq!((result.turned, result.unsure), (0, result.parts));
        assert_eq!(sheet.triangles.len(), 4);
    }

    #[test]
    fn a_moebius_band_has_one_side() {
        let ring = |i: u32| [2 * (i % 5), 2 * (i % 5) + 1];
        let mut mesh = Mesh::default();
        for i in 0..5 {
            let (turn, half) = (i as f64 / 5.0 * std::f64::consts::TAU, i as f64 / 5.0 * std::f64::consts::PI);
            let out = DVec3::new(turn.cos(), turn.sin(), 0.0);
            let across = (out * half.cos() + DVec3::Z * half.sin()) * 0.3;
            mesh.vertices.extend([out - across, out + across]);
            let ([a, b], [mut c, mut d]) = (ring(i), ring(i + 1));
            if i == 4 {
                (c, d) = (d, c);
            }
            mesh.triangles.extend([[a, b, c], [c, b, d]]);
        }
        let (_, result) = oriented(&mesh);
        assert_eq!((result.one_sided, result.unsure, result.turned), (1, 1, 0));
    }
}
