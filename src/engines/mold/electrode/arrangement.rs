//! Heads as the user arranges them on electrodes.

use std::collections::BTreeSet;

use glam::DVec3;

use super::names::{Burned, part_at};
use super::params::Edit;
use super::part_numbers::{Numbered, Parts};
use super::sharing::Leaf;

/// What the user does with heads, by their places in the list of those of one stage and burn direction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Arranged {
    /// The electrodes of two heads become one.
    Joined([usize; 2]),
    /// The electrode of the first head burns the second place too.
    Copied([usize; 2]),
}

/// The user's arrangement of the heads of one stage and burn direction.
#[derive(Debug, Default)]
pub(super) struct Arrangement {
    /// Heads that have an electrode of their own.
    pub(super) apart: BTreeSet<usize>,
    /// What is done with the others, each with its change's place in the list.
    pub(super) arranged: Vec<(usize, Arranged)>,
    /// Changes that gave heads an electrode of their own, with the region that each is for.
    pub(super) met: Vec<(usize, usize)>,
}

impl Arrangement {
    /// The arrangement that the user's changes ask for; later ones prevail.
    pub(super) fn of(leaves: &[Leaf], edits: &[Edit], (regions, plans, parts): Burned, stage: usize) -> Self {
        let mut found = Self::default();
        if !edits.iter().any(|edit| matches!(edit, Edit::Join { .. } | Edit::TakeApart { .. } | Edit::Copy { .. })) {
            return found;
        }
        let of_stage = |all: &Vec<Numbered>| all.iter().filter(|part| part.stage == stage).cloned().collect();
        let parts: Parts = parts.iter().map(of_stage).collect();
        let head = |place: &DVec3| {
            let part = part_at(*place, (regions, plans, &parts))?;
            leaves.iter().position(|leaf| leaf.id == part)
        };
        for (number, edit) in edits.iter().enumerate() {
            let pair = |[a, b]: &[DVec3; 2]| Some([head(a)?, head(b)?]).filter(|[a, b]| a != b);
            match edit {
                Edit::Join { places } => {
                    let Some(pair) = pair(places) else { continue };
                    found.arranged.push((number, Arranged::Joined(pair)));
                }
                Edit::TakeApart { place } => {
                    let Some(head) = head(place) else { continue };
                    found.arranged.retain(|(_, Arranged::Joined(pair) | Arranged::Copied(pair))| !pair.contains(&head));
                    found.apart.insert(head);
                    found.met.push((number, leaves[head].id.region));
                }
                Edit::Copy { places } => {
                    let Some(pair) = pair(places) else { continue };
                    found.arranged.push((number, Arranged::Copied(pair)));
                }
                _ => {}
            }
        }
        found
    }
}
