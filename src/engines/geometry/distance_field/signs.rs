//! Signs that hold where the mesh is folded.
//!
//! The normal at the nearest point tells inside from outside only on a surface that does not cross itself. But
//! where no surface passes there is one sign: leaves that the surface does not cross and that touch each other form
//! *zones*, and each zone gets its sign from one winding number. Leaves that the surface crosses keep the sign of the
//! normals as long as that agrees with the zones they touch; those where it does not, and those where sheets of
//! opposite directions come together, are evaluated by counting crossings within the cell.

use std::collections::HashMap;

use glam::DVec3;
use rayon::prelude::*;

use super::local_triangles::Candidate;
use super::{DistanceField, Handle};
use crate::exact::ExactMesh;
use crate::groups::Groups;
use crate::inside::winding_number;
use task::{Cancel, Cancelled};

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

/// Gives the leaves of `field` their signs. `leaves` and `lists` tell how the surface passes each smooth leaf and
/// each exact cell.
pub(super) fn settle(
    field: &mut DistanceField,
    exact: &ExactMesh,
    mut leaves: Vec<Passage>,
    lists: Vec<Passage>,
    cancel: &Cancel,
) -> Result<(), Cancelled> {
    let smooth = leaves.len();
    leaves.extend(lists);
    let mut survey = Survey { field, exact, smooth, passages: leaves, inside: Vec::new() };
    survey.inside = survey.zones(cancel)?;
    let folded = survey.folded_cells(cancel)?;
    let Survey { passages, inside, .. } = survey;
    field.set_signs(&passages, &inside);
    field.set_folded(exact, &folded, cancel)
}

/// The places of a field before its signs are known. Smooth leaves and exact cells are counted through as nodes.
struct Survey<'a> {
    field: &'a DistanceField,
    exact: &'a ExactMesh,
    /// Number of smooth leaves.
    smooth: usize,
    /// By node.
    passages: Vec<Passage>,
    /// Whether a node is inside; meaningful for clear ones.
    inside: Vec<bool>,
}

impl Survey<'_> {
    fn node(&self, cell: [usize; 3]) -> usize {
        let handle = self.field.handle(cell);
        handle.number() + if handle.kind() == Handle::EXACT { self.smooth } else { 0 }
    }

    fn is_clear(&self, node: usize) -> bool {
        self.passages[node] == Passage::Clear
    }

    /// Whether each clear node is inside.
    fn zones(&self, cancel: &Cancel) -> Result<Vec<bool>, Cancelled> {
        let mut zones = Groups::of(self.passages.len());
        let layers: Vec<_> = (0..self.field.cells[2])
            .into_par_iter()
            .map(|z| cancel.check().map(|()| self.touching_in_layer(z)))
            .collect::<Result<_, _>>()?;
        layers.into_iter().flatten().for_each(|[v, w]| zones.join(v as usize, w as usize));
        let roots: Vec<usize> = (0..self.passages.len()).map(|node| zones.first(node)).collect();
        let places = self.places(|node| self.is_clear(node) && roots[node] == node, cancel)?;
        let wound = |&(node, cell): &(usize, [usize; 3])| {
            cancel.check()?;
            let size = if node < self.smooth { f64::from(1 << self.field.handle(cell).kind()) } else { 1.0 };
            let center = self.field.point_in(cell, DVec3::splat(0.5 * size));
            Ok((node, winding_number(self.exact, center) != 0))
        };
        let of_root: HashMap<usize, bool> = places.par_iter().map(wound).collect::<Result<_, _>>()?;
        Ok(roots.iter().map(|&root| of_root.get(&root).copied().unwrap_or(false)).collect())
    }

    /// Pairs of different clear nodes with cells side by side, the first of them in layer `z`.
    fn touching_in_layer(&self, z: usize) -> Vec<[u32; 2]> {
        let [nx, ny, nz] = self.field.cells;
        let mut pairs = Vec::new();
        for y in 0..ny {
            // Rows run along leaves: most pairs are the one before again.
            let mut last = [[u32::MAX; 2]; 3];
            for x in 0..nx {
                let node = self.node([x, y, z]);
                if !self.is_clear(node) {
                    continue;
                }
                let beside = [(x + 1 < nx, [x + 1, y, z]), (y + 1 < ny, [x, y + 1, z]), (z + 1 < nz, [x, y, z + 1])];
                for (last, (_, cell)) in last.iter_mut().zip(beside).filter(|(_, (exists, _))| *exists) {
                    let other = self.node(cell);
                    let pair = [node as u32, other as u32];
                    if other != node && pair != *last && self.is_clear(other) {
                        *last = pair;
                        pairs.push(pair);
                    }
                }
            }
        }
        pairs
    }

    /// The nodes that `wanted` picks, each with its first cell, in the order of these.
    fn places(
        &self,
        wanted: impl Fn(usize) -> bool + Sync,
        cancel: &Cancel,
    ) -> Result<Vec<(usize, [usize; 3])>, Cancelled> {
        let [nx, ny, nz] = self.field.cells;
        let in_layer = |z: usize| {
            cancel.check()?;
            let mut found = Vec::new();
            for (x, y) in (0..ny).flat_map(|y| (0..nx).map(move |x| (x, y))) {
                let node = self.node([x, y, z]);
                let level = if node < self.smooth { self.field.handle([x, y, z]).kind() } else { 0 };
                let is_first = (x | y | z) & ((1 << level) - 1) == 0;
                if is_first && wanted(node) {
                    found.push((node, [x, y, z]));
                }
            }
            Ok(found)
        };
        let layers: Vec<_> = (0..nz).into_par_iter().map(in_layer).collect::<Result<_, Cancelled>>()?;
        Ok(layers.concat())
    }

    /// The first cell and the size (cells) of every leaf whose normals are unreliable.
    fn folded_cells(&self, cancel: &Cancel) -> Result<Vec<([usize; 3], usize)>, Cancelled> {
        let places = self.places(|node| !self.is_clear(node), cancel)?;
        let folded = |&(node, cell): &(usize, [usize; 3])| {
            let size = if node < self.smooth { 1 << self.field.handle(cell).kind() } else { 1 };
            match self.passages[node] {
                Passage::Clear => None,
                Passage::Folded => Some((cell, size)),
                Passage::Crossed(inside) => (!self.agrees(cell, size, inside)).then_some((cell, size)),
            }
        };
        let parts: Vec<Vec<_>> = places
            .par_chunks(4096)
            .map(|part| cancel.check().map(|()| part.iter().filter_map(folded).collect()))
            .collect::<Result<_, _>>()?;
        Ok(parts.concat())
    }

    /// Whether the signs of a leaf's corners are those of all zones that it touches there; if it touches none,
    /// whether its sign at one place is right.
    fn agrees(&self, cell: [usize; 3], size: usize, inside: u8) -> bool {
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
        let p = self.field.reference_point(cell);
        touches || self.field.value(p).is_some_and(|d| (d < 0.0) == (winding_number(self.exact, p) != 0))
    }

    /// Whether the zone that touches a vertex of the lattice is inside, if there is one.
    fn zone_at(&self, vertex: [usize; 3]) -> Option<bool> {
        (0..8).find_map(|i| {
            let cell = [0, 1, 2].map(|k| vertex[k].wrapping_sub(i >> k & 1));
            if (0..3).any(|k| cell[k] >= self.field.cells[k]) {
                return None;
            }
            let node = self.node(cell);
            self.is_clear(node).then(|| self.inside[node])
        })
    }
}

impl DistanceField {
    /// Writes the signs of clear nodes into the field.
    fn set_signs(&mut self, passages: &[Passage], inside: &[bool]) {
        let smooth = self.leaves.len();
        for (leaf, (passage, &inside)) in self.leaves.iter_mut().zip(passages.iter().zip(inside)) {
            if *passage == Passage::Clear {
                *leaf = leaf.map(|v| if inside { -v.abs() } else { v.abs() });
            }
        }
        self.handles.par_iter_mut().for_each(|handle| {
            let node = smooth + handle.number();
            if handle.kind() == Handle::EXACT && passages[node] == Passage::Clear {
                let kind = if inside[node] { Handle::INSIDE } else { Handle::OUTSIDE };
                *handle = Handle::new(kind, handle.number());
            }
        });
    }

    /// Makes all cells of the `folded` leaves, given by first cell and size, such that count crossings.
    fn set_folded(
        &mut self,
        exact: &ExactMesh,
        folded: &[([usize; 3], usize)],
        cancel: &Cancel,
    ) -> Result<(), Cancelled> {
        let cells_of = |&(first, size): &([usize; 3], usize)| {
            (0..size.pow(3)).map(move |i| [first[0] + i % size, first[1] + i / size % size, first[2] + i / size / size])
        };
        let cells: Vec<[usize; 3]> = folded.iter().flat_map(cells_of).collect();
        let described: Vec<(Vec<Candidate>, i32)> = cells
            .par_iter()
            .map(|&cell| {
                cancel.check()?;
                Ok((self.triangles_near(exact, cell), winding_number(exact, self.reference_point(cell))))
            })
            .collect::<Result<_, Cancelled>>()?;
        for (cell, (list, winding)) in cells.into_iter().zip(described) {
            let i = self.index(cell);
            self.handles[i] = Handle::new(Handle::FOLDED, self.list_ends.len());
            self.windings.insert(self.list_ends.len() as u32, winding);
            self.list.extend(list);
            self.list_ends.push(self.list.len() as u32);
        }
        Ok(())
    }

    /// The triangles that can be nearest to some point of a cell, or cross it, in order of their distance from its
    /// centre.
    fn triangles_near(&self, exact: &ExactMesh, cell: [usize; 3]) -> Vec<Candidate> {
        let center = self.point_in(cell, DVec3::splat(0.5));
        // Twice half the diagonal, and rounding.
        let reach = exact.nearest(center).signed_distance.abs() + 3f64.sqrt() * self.cell + 1e-9;
        let with_distance = |t: u32| (self.triangles.distance(center, t), t);
        let within = self.triangles.numbers(exact.triangles_within(center, reach));
        let mut found: Vec<(f64, u32)> = within.map(with_distance).collect();
        found.retain(|&(d, _)| d <= reach);
        found.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        found.into_iter().map(|(d, t)| Candidate::new(d, t)).collect()
    }

    /// The place in a cell whose winding number is known if the cell is folded: off the middle, so that surfaces that
    /// run through lattice planes miss it.
    pub(super) fn reference_point(&self, cell: [usize; 3]) -> DVec3 {
        self.point_in(cell, DVec3::new(0.437, 0.561, 0.473))
    }

    /// The point `offset` cells from the low corner of a cell.
    fn point_in(&self, cell: [usize; 3], offset: DVec3) -> DVec3 {
        self.bounds.min + (DVec3::from_array(cell.map(|i| i as f64)) + offset) * self.cell
    }
}
