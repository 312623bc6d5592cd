//! Faces other than cylinders and cones: planes, and patches of any form.

use super::facets::{Facet, Facets};
use super::topology::NONE;

/// How much larger than all its neighbours a facet in the midst of a curved surface may be.
const SURROUNDED: f64 = 10.0;

/// Limits within which facets are one curved surface.
#[derive(Debug, Clone, Copy)]
pub(super) struct Limits {
    /// Greatest angle between neighbouring facets (rad).
    pub(super) turn: f64,
    /// Greatest distance of the facets from the surface that they stand for (mm).
    pub(super) chord: f64,
}

/// The patch of every facet that belongs to one, [`NONE`] for others; numbered in the order of their first facets.
pub(super) fn patches(facets: &Facets, is_taken: &[bool], limits: Limits) -> Vec<u32> {
    let mut is_curved: Vec<bool> = (0..facets.all.len()).map(|i| is_curved(facets, is_taken, i, limits)).collect();
    let lost: Vec<usize> = (0..facets.all.len())
        .filter(|&i| !is_curved[i] && !is_taken[i] && is_surrounded(facets, &is_curved, i, limits))
        .collect();
    lost.into_iter().for_each(|i| is_curved[i] = true);
    let mut patch = vec![NONE; facets.all.len()];
    let mut count = 0;
    for seed in 0..facets.all.len() {
        if !is_curved[seed] || patch[seed] != NONE {
            continue;
        }
        patch[seed] = count;
        let mut members = vec![seed as u32];
        let mut next = 0;
        while next < members.len() {
            for link in facets.links(members[next]) {
                let to = link.to as usize;
                if is_curved[to] && patch[to] == NONE && link.turn.abs() <= limits.turn {
                    patch[to] = count;
                    members.push(link.to);
                }
            }
            next += 1;
        }
        if members.len() == 1 {
            patch[seed] = NONE;
        } else {
            count += 1;
        }
    }
    patch
}

/// Whether a facet goes on over some side, at a small angle, with one about as wide, so that the two can be chords of
/// one curved surface.
fn is_curved(facets: &Facets, is_taken: &[bool], i: usize, limits: Limits) -> bool {
    let facet = &facets.all[i];
    let sagitta = |facet: &Facet, turn: f64| facet.width * turn.abs() / 8.0;
    !is_taken[i]
        && facets.links(i as u32).iter().any(|link| {
            let other = &facets.all[link.to as usize];
            !is_taken[link.to as usize]
                && link.turn.abs() <= limits.turn
                && sagitta(facet, link.turn) <= limits.chord
                && facet.is_like(other)
        })
}

/// Whether a facet lies in the midst of a curved surface, small enough to be a piece of it.
fn is_surrounded(facets: &Facets, is_curved: &[bool], i: usize, limits: Limits) -> bool {
    let facet = &facets.all[i];
    let links = facets.links(i as u32);
    let largest = links.iter().map(|link| facets.all[link.to as usize].area).fold(0.0, f64::max);
    facet.area <= SURROUNDED * largest
        && links.iter().all(|link| is_curved[link.to as usize] && link.turn.abs() <= limits.turn)
}
