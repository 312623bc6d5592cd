//! Heads as the user arranges them on electrodes.

use std::collections::BTreeSet;

use glam::DVec3;

use super::names::{Burned, part_at};
use super::params::Edit;
use super::sharing::Leaf;

/// The user's arrangement of the heads of one stage and burn direction, by their places in the list.
#[derive(Debug, Default)]
pub(super) struct Arrangement {
    /// Heads that stand on one base.
    pub(super) joined: Vec<Vec<usize>>,
    /// Heads that have an electrode of their own.
    pub(super) apart: BTreeSet<usize>,
    /// Pairs of which the electrode with the first burns the second too, each with its change's place in the list.
    pub(super) copies: Vec<(usize, [usize; 2])>,
    /// Changes of joined heads and of those apart, with a region that each is for.
    pub(super) met: Vec<(usize, usize)>,
}

impl Arrangement {
    /// The arrangement that the user's changes ask for.
    pub(super) fn of(leaves: &[Leaf], edits: &[Edit], burned: Burned) -> Self {
        let head = |place: &DVec3| {
            let part = part_at(*place, burned)?;
            leaves.iter().position(|leaf| leaf.id == part)
        };
        let mut found = Self::default();
        for (number, edit) in edits.iter().enumerate() {
            match edit {
                Edit::Join { places: [a, b] } => {
                    let (Some(a), Some(b)) = (head(a), head(b)) else { continue };
                    if a != b {
                        found.join(a, b);
                        found.met.push((number, leaves[a].id.region));
                    }
                }
                Edit::TakeApart { place } => {
                    let Some(head) = head(place) else { continue };
                    found.apart.insert(head);
                    found.met.push((number, leaves[head].id.region));
                }
                Edit::Copy { places: [a, b] } => {
                    if let (Some(a), Some(b)) = (head(a), head(b)) {
                        found.copies.push((number, [a, b]));
                    }
                }
                _ => {}
            }
        }
        found
    }

    fn join(&mut self, a: usize, b: usize) {
        let mut all = vec![a, b];
        self.joined.retain(|set| {
            let is_joined = set.contains(&a) || set.contains(&b);
            if is_joined {
                all.extend(set);
            }
            !is_joined
        });
        all.sort_unstable();
        all.dedup();
        self.joined.push(all);
    }

    /// The electrodes that it begins with, each given by its heads.
    pub(super) fn bases(&self) -> Vec<Vec<usize>> {
        let joined = self.joined.iter();
        let is_single = |head: &&usize| !self.joined.iter().any(|set| set.contains(head));
        let first = self.copies.iter().map(|(_, [a, _])| a);
        let single: BTreeSet<usize> = self.apart.iter().chain(first).filter(is_single).copied().collect();
        joined.cloned().chain(single.into_iter().map(|head| vec![head])).collect()
    }
}
