//! Signs that hold where the mesh is folded.
//!
//! The normal at the nearest point tells inside from outside only on a surface that does not cross itself. But
//! where no surface passes there is one sign: leaves of a block that the surface does not cross and that touch each other
//! form *zones*, and each zone gets its sign from one winding number. Leaves that the surface crosses keep the sign of the
//! normals as long as that agrees with the zones they touch; those where it does not, and those where sheets of
//! opposite directions come together, are evaluated by counting crossings within the cell.

use glam::DVec3;

use super::local_triangles::Candidate;
use super::{Block, DistanceField, Handle, Place};
use crate::groups::Groups;
use crate::inside::winding_number;

/// Course of the surface through a leaf.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Passage {
    /// Not at all: one sign holds all over it, which is not known yet.
    Clear,
    /// Through it or close by. Bit `i` tells that the normals put corner `i` inside.
    Crossed(u8),
    /// The surface is folded, so that its normals are not reliable.
    Folded,
}

/// Gives the leaves of a `block` of `field` their signs. `leaves` and `lists` tell how the surface passes each smooth leaf
/// and each exact cell.
pub(super) fn settle(field: &DistanceField, block: &mut Block, leaves: &[Passage], lists: &[Passage]) {
    let smooth = leaves.len();
    let passages = [leaves, lists].concat();
    let mut survey = Survey { field, block, smooth, passages, inside: Vec::new() };
    survey.inside = survey.zones();
    let folded = survey.folded_cells();
    let Survey { passages, inside, .. } = survey;
    block.set_signs(&passages, &inside);
    block.set_folded(field, &folded);
}

/// The places of a block before its signs are known. Smooth leaves and exact cells are counted through as nodes.
struct Survey<'a> {
    field: &'a DistanceField,
    block: &'a Block,
    /// Number of smooth leaves.
    smooth: usize,
    /// By node.
    passages: Vec<Passage>,
    /// Whether a node is inside; meaningful for clear ones.
    inside: Vec<bool>,
}

impl Survey<'_> {
    fn node(&self, cell: [usize; 3]) -> usize {
        let handle = self.block.handles[Block::index(cell)];
        handle.number() + if handle.kind() == Handle::EXACT { self.smooth } else { 0 }
    }

    fn is_clear(&self, node: usize) -> bool {
        self.passages[node] == Passage::Clear
    }

    /// Cells that the leaf or exact cell at `cell` spans along each side.
    fn size(&self, cell: [usize; 3]) -> usize {
        let handle = self.block.handles[Block::index(cell)];
        if handle.is_exact() { 1 } else { 1 << handle.kind() }
    }

    /// Whether each clear node is inside.
    fn zones(&self) -> Vec<bool> {
        let mut zones = Groups::of(self.passages.len());
        for cell in cells_of([0; 3], Block::SIDE) {
            let node = self.node(cell);
            for k in (0..3).filter(|&k| self.is_clear(node) && cell[k] + 1 < Block::SIDE) {
                let mut beside = cell;
                beside[k] += 1;
                let other = self.node(beside);
                if other != node && self.is_clear(other) {
                    zones.join(node, other);
                }
            }
        }
        let mut inside = vec![false; self.passages.len()];
        for (node, cell) in self.places() {
            inside[node] = self.is_clear(node)
                && match zones.first(node) {
                    first if first == node => self.is_wound(cell, DVec3::splat(0.5 * self.size(cell) as f64)),
                    // Places come in the order of their numbers.
                    first => inside[first],
                };
        }
        inside
    }

    /// Whether the surface winds around the point `offset` cells from the low corner of a cell of the block.
    fn is_wound(&self, cell: [usize; 3], offset: DVec3) -> bool {
        winding_number(&self.field.exact, self.field.point_in(self.block.in_field(cell), offset)) != 0
    }

    /// The nodes, each with its first cell: smooth leaves and exact cells in the order of their numbers.
    fn places(&self) -> Vec<(usize, [usize; 3])> {
        let is_first = |cell: &[usize; 3]| cell.iter().all(|i| i % self.size(*cell) == 0);
        let mut places: Vec<_> =
            cells_of([0; 3], Block::SIDE).filter(is_first).map(|cell| (self.node(cell), cell)).collect();
        places.sort_unstable();
        places
    }

    /// The cells of every leaf whose normals are unreliable.
    fn folded_cells(&self) -> Vec<[usize; 3]> {
        let is_folded = |&(node, cell): &(usize, [usize; 3])| match self.passages[node] {
            Passage::Clear => false,
            Passage::Folded => true,
            Passage::Crossed(inside) => !self.agrees(cell, inside),
        };
        let folded = self.places().into_iter().filter(is_folded);
        folded.flat_map(|(_, cell)| cells_of(cell, self.size(cell))).collect()
    }

    /// Whether the signs of a leaf's corners are those of all zones that it touches there; if it touches none,
    /// whether its sign at one place is right.
    fn agrees(&self, cell: [usize; 3], inside: u8) -> bool {
        let size = self.size(cell);
        let mut touches = false;
        for corner in 0..8 {
            let vertex = [0, 1, 2].map(|k| cell[k] + (corner >> k & 1) * size);
            if let Some(zone) = self.zone_at(vertex) {
                touches = true;
                if zone != (inside >> corner & 1 == 1) {
                    return false;
                }
            }
        }
        if touches {
            return true;
        }
        let in_field = self.block.in_field(cell);
        let p = self.field.reference_point(in_field);
        let by_normals = self.block.place(self.field, in_field).value(p);
        (by_normals < 0.0) == (winding_number(&self.field.exact, p) != 0)
    }

    /// Whether the zone that touches a vertex of the block's lattice is inside, if there is one.
    fn zone_at(&self, vertex: [usize; 3]) -> Option<bool> {
        (0..8).find_map(|i| {
            let cell = [0, 1, 2].map(|k| vertex[k].wrapping_sub(i >> k & 1));
            if cell.iter().any(|&i| i >= Block::SIDE) {
                return None;
            }
            let node = self.node(cell);
            self.is_clear(node).then(|| self.inside[node])
        })
    }
}

/// The cells of a cube of `size` cells along each side, x fastest.
fn cells_of(first: [usize; 3], size: usize) -> impl Iterator<Item = [usize; 3]> {
    (0..size.pow(3)).map(move |i| [first[0] + i % size, first[1] + i / size % size, first[2] + i / size / size])
}

impl Block {
    /// The cell `cell` of `field`, one of the block's.
    fn place<'a>(&'a self, field: &'a DistanceField, cell: [usize; 3]) -> Place<'a> {
        Place { field, block: self, handle: self.handles[Self::index(cell)], cell }
    }

    /// Writes the signs of clear nodes into the block.
    fn set_signs(&mut self, passages: &[Passage], inside: &[bool]) {
        let smooth = self.leaves.len();
        for (leaf, (passage, &inside)) in self.leaves.iter_mut().zip(passages.iter().zip(inside)) {
            if *passage == Passage::Clear {
                *leaf = leaf.map(|v| if inside { -v.abs() } else { v.abs() });
            }
        }
        for handle in self.handles.iter_mut().filter(|handle| handle.kind() == Handle::EXACT) {
            let node = smooth + handle.number();
            if passages[node] == Passage::Clear {
                let kind = if inside[node] { Handle::INSIDE } else { Handle::OUTSIDE };
                *handle = Handle::new(kind, handle.number());
            }
        }
    }

    /// Makes the `folded` cells such that count crossings.
    fn set_folded(&mut self, field: &DistanceField, folded: &[[usize; 3]]) {
        for &cell in folded {
            let in_field = self.in_field(cell);
            self.handles[Self::index(cell)] = Handle::new(Handle::FOLDED, self.list_ends.len());
            self.windings.push(winding_number(&field.exact, field.reference_point(in_field)));
            self.list.extend(field.triangles_near(in_field));
            self.list_ends.push(self.list.len() as u32);
        }
    }

    /// Finds the distance at the centre of every exact cell.
    pub(super) fn measure_centres(&mut self, field: &DistanceField) {
        let mut centres = vec![f32::NEG_INFINITY; self.list_ends.len()];
        for cell in cells_of(self.first, Self::SIDE) {
            let place = self.place(field, cell);
            if place.handle.is_exact() {
                centres[place.handle.number()] = place.value(place.center()) as f32;
            }
        }
        self.centres = centres;
    }
}

impl DistanceField {
    /// The triangles that can be nearest to some point of a cell, or cross it, in order of their distance from its
    /// centre.
    fn triangles_near(&self, cell: [usize; 3]) -> Vec<Candidate> {
        let center = self.point_in(cell, DVec3::splat(0.5));
        // Twice half the diagonal, and rounding.
        let reach = self.exact.nearest(center).signed_distance.abs() + 3f64.sqrt() * self.cell + 1e-9;
        let with_distance = |t: u32| (self.triangles.distance(center, t), t);
        let within = self.triangles.numbers(self.exact.triangles_within(center, reach));
        let mut found: Vec<(f64, u32)> = within.map(with_distance).collect();
        found.retain(|&(d, _)| d <= reach);
        found.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        found.into_iter().map(|(d, t)| Candidate::new(d, t)).collect()
    }
}
