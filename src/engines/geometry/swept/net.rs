//! Connections of the cells that the surface passes.
//!
//! Edge `4 a + i + 2 j` of a cell runs along axis `a`, on its far side along the next axis if `i` is 1 and along the
//! one after that if `j` is 1.

use glam::DVec3;
use rayon::prelude::*;

use super::lattice::{BLOCK, Blocks, Lattice};

/// Corners and edges around each face of a cell.
const FACES: [([usize; 4], [usize; 4]); 6] = faces();

/// Vertices and quadrangles of a surface, before the vertices have their places.
pub(super) struct Net {
    /// Start of each vertex.
    pub starts: Vec<Start>,
    /// Number of vertices of each mixed block, in their order.
    pub counts: Vec<usize>,
    /// Vertices of the quadrangles, counter-clockwise seen from outside.
    pub quads: Vec<[u32; 4]>,
}

/// Start of a vertex.
#[derive(Clone, Copy)]
pub(super) struct Start {
    /// The middle of the edges that its sheet crosses, in its cell.
    pub middle: DVec3,
    /// The middle of their ends outside.
    pub outside: DVec3,
}

/// A cell that the surface passes.
struct Cell {
    /// The number of its first point.
    index: usize,
    /// Sheet that crosses each edge, or `NONE`.
    sheets: [u8; 12],
    /// Number of its first vertex, within its block.
    first: usize,
}

const NONE: u8 = u8::MAX;

impl Net {
    pub(super) fn new(lattice: &Lattice, blocks: &Blocks) -> Self {
        let parts: Vec<(Vec<Cell>, Vec<Start>)> =
            blocks.mixed.par_iter().map(|(number, _)| cells_of(*number, lattice, blocks)).collect();
        let mut net = Self { starts: Vec::new(), counts: Vec::new(), quads: Vec::new() };
        let mut cells = Vec::new();
        for (mut own, starts) in parts {
            own.iter_mut().for_each(|cell| cell.first += net.starts.len());
            cells.extend(own);
            net.counts.push(starts.len());
            net.starts.extend(starts);
        }
        let mut at_point = vec![u32::MAX; lattice.point_count()];
        for (i, cell) in cells.iter().enumerate() {
            at_point[cell.index] = i as u32;
        }
        let strides = [0, 1, 2].map(|axis| lattice.stride(axis));
        for cell in &cells {
            for axis in (0..3).filter(|axis| cell.sheets[4 * axis] != NONE) {
                let vertex = |i: usize, j: usize| {
                    let other = cell.index - i * strides[(axis + 1) % 3] - j * strides[(axis + 2) % 3];
                    // The rim of the lattice is outside: an edge that is crossed has four cells around it.
                    let other = &cells[at_point[other] as usize];
                    (other.first + usize::from(other.sheets[4 * axis + i + 2 * j])) as u32
                };
                let mut quad = [vertex(0, 0), vertex(1, 0), vertex(1, 1), vertex(0, 1)];
                if !blocks.is_inside(cell.index) {
                    quad.reverse();
                }
                net.quads.push(quad);
            }
        }
        net
    }
}

/// The cells of a block that the surface passes, and where their vertices begin.
fn cells_of(block: usize, lattice: &Lattice, blocks: &Blocks) -> (Vec<Cell>, Vec<Start>) {
    let (mut cells, mut starts) = (Vec::new(), Vec::new());
    let strides = [0, 1, 2].map(|axis| lattice.stride(axis));
    let offsets: [usize; 8] = std::array::from_fn(|c| (0..3).map(|k| (c >> k & 1) * strides[k]).sum());
    for i in 0..BLOCK.pow(3) {
        let point = lattice.point_of(block, i);
        if !lattice.has_cell(point) {
            continue;
        }
        let index = lattice.index(point);
        let inside: [bool; 8] = std::array::from_fn(|c| blocks.is_inside(index + offsets[c]));
        if inside == [inside[0]; 8] {
            continue;
        }
        let (sheets, count) = sheets(&inside);
        let first = starts.len();
        for sheet in 0..count {
            let crossed: Vec<[usize; 2]> = (0..12).filter(|&e| sheets[e] == sheet).map(ends_of_edge).collect();
            let mean = |of: &dyn Fn(&[usize; 2]) -> DVec3| {
                lattice.place(point) + crossed.iter().map(of).sum::<DVec3>() / crossed.len() as f64 * lattice.cell
            };
            starts.push(Start {
                middle: mean(&|[a, b]| 0.5 * (corner(*a) + corner(*b))),
                outside: mean(&|[a, b]| corner(if inside[*a] { *b } else { *a })),
            });
        }
        cells.push(Cell { index, sheets, first });
    }
    (cells, starts)
}

/// Numbers the sheets in which the surface passes a cell with these corners inside: for each edge the one that crosses
/// it, and how many there are.
fn sheets(inside: &[bool; 8]) -> ([u8; 12], u8) {
    let mut root: [usize; 12] = std::array::from_fn(|e| e);
    let find = |root: &[usize; 12], mut e: usize| {
        while root[e] != e {
            e = root[e];
        }
        e
    };
    let mut join = |a: usize, b: usize| {
        let (a, b) = (find(&root, a), find(&root, b));
        root[a.max(b)] = a.min(b);
    };
    for (corners, edges) in &FACES {
        let crossed = |i: usize| inside[corners[i]] != inside[corners[(i + 1) % 4]];
        let ones: Vec<usize> = (0..4).filter(|&i| crossed(i)).collect();
        match ones[..] {
            [a, b] => join(edges[a], edges[b]),
            // Both ways are possible: the corners that are inside are kept apart, seen from either side of the face.
            [_, _, _, _] => {
                (0..4).filter(|&i| inside[corners[i]]).for_each(|i| join(edges[i], edges[(i + 3) % 4]));
            }
            _ => {}
        }
    }
    let mut sheets = [NONE; 12];
    let mut count = 0;
    for e in 0..12 {
        let [a, b] = ends_of_edge(e);
        if inside[a] == inside[b] {
            continue;
        }
        let r = find(&root, e);
        if r == e {
            sheets[e] = count;
            count += 1;
        } else {
            // A root is the least of its set: it has its number already.
            sheets[e] = sheets[r];
        }
    }
    (sheets, count)
}

/// The corners at both ends of an edge; corner `c` is on the far side along axis `k` if bit `k` of `c` is set.
const fn ends_of_edge(e: usize) -> [usize; 2] {
    let (axis, i, j) = (e / 4, e % 2, e % 4 / 2);
    let near = (i << ((axis + 1) % 3)) | (j << ((axis + 2) % 3));
    [near, near + (1 << axis)]
}

/// A corner, in cells from the first.
fn corner(c: usize) -> DVec3 {
    DVec3::new((c & 1) as f64, (c >> 1 & 1) as f64, (c >> 2 & 1) as f64)
}

/// For every face its corners around it, and its edges: edge `i` between corners `i` and `i + 1`.
const fn faces() -> [([usize; 4], [usize; 4]); 6] {
    let mut faces = [([0; 4], [0; 4]); 6];
    let mut f = 0;
    while f < 6 {
        let (axis, side) = (f % 3, f / 3);
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        let base = side << axis;
        let (along_u, along_v) = (1 << u, 1 << v);
        let corners = [base, base + along_u, base + along_u + along_v, base + along_v];
        let mut edges = [0; 4];
        let mut i = 0;
        while i < 4 {
            edges[i] = edge_between(corners[i], corners[(i + 1) % 4]);
            i += 1;
        }
        faces[f] = (corners, edges);
        f += 1;
    }
    faces
}

const fn edge_between(a: usize, b: usize) -> usize {
    let mut e = 0;
    loop {
        let [p, q] = ends_of_edge(e);
        if (p == a && q == b) || (p == b && q == a) || e == 11 {
            return e;
        }
        e += 1;
    }
}
