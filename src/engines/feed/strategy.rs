//! The ways to search a feed path.

use serde::{Deserialize, Serialize};

/// How a path is searched for.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Strategy {
    /// The adaptive genetic algorithm of P0.
    Genetic,
    /// The widest way over many poses for each node, then polished as a whole.
    #[default]
    Global,
    /// Straight on along the main direction as far as it goes (Kang et al. 2018); to compare with.
    FreeTravel,
    /// The greatest least distance at every node (Ayesta et al. 2016); to compare with.
    MaxMinDistance,
    /// Along the centreline of the channel, P1.
    Centreline,
}

impl Strategy {
    /// Every strategy in the order of declaration.
    pub const ALL: [Self; 5] = [Self::Genetic, Self::Global, Self::FreeTravel, Self::MaxMinDistance, Self::Centreline];

    /// Its name, as job files have it.
    pub fn name(self) -> &'static str {
        ["genetic", "global", "free-travel", "max-min-distance", "centreline"][self as usize]
    }

    /// The strategy called `name`.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|strategy| strategy.name() == name)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_those_of_job_files() {
        for strategy in Strategy::ALL {
            assert_eq!(serde_json::to_value(strategy).unwrap(), strategy.name());
            assert_eq!(Strategy::named(strategy.name()), Some(strategy));
        }
        assert_eq!(Strategy::named("Genetic"), None);
    }
}
