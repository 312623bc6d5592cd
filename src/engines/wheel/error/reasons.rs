//! Reasons of refusals that are told within them.

use super::super::options::{BliskOptions, EndWalls};

/// What is given by hand and fits nothing in the mesh.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Misleading {
    /// Points of hub, shroud or blades.
    Points,
    /// The number of blades.
    Blades,
    /// The axis.
    Axis,
}

impl Misleading {
    /// All of them, what is likeliest to be wrong first.
    pub(crate) const ALL: [Self; 3] = [Self::Points, Self::Blades, Self::Axis];

    /// Takes it out of `options`; false if it is not given there.
    pub(crate) fn take_away(self, options: &mut BliskOptions) -> bool {
        let given = options.clone();
        match self {
            Self::Points => {
                options.hub_points_mm.clear();
                options.shroud_points_mm.clear();
                options.blade_points_mm.clear();
                options.end_walls = EndWalls::Measured;
            }
            Self::Blades => options.blades = BliskOptions::default().blades,
            Self::Axis => options.axis = BliskOptions::default().axis,
        }
        *options != given
    }

    /// The beginning and the end of a sentence about it.
    pub(super) fn words(self) -> [&'static str; 2] {
        match self {
            Self::Points => [
                "the points of blisk.blade_points_mm, blisk.hub_points_mm and blisk.shroud_points_mm do not lie beside the blades of",
                "pick points beside these blades, or take the points away",
            ],
            Self::Blades => ["blisk.blades does not fit", "correct it, or set it to auto"],
            Self::Axis => ["blisk.axis does not fit", "correct it, or set it to auto"],
        }
    }
}

/// Reason why gaps that repeat around an axis are no channels between blades.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum NotChannels {
    /// Walls that differ from gap to gap.
    #[error("many of their walls do not repeat from gap to gap, as where blades are not evenly spaced or not alike")]
    DoNotRepeat,
    /// Channels of which each differs from all others.
    #[error("no two of them are alike")]
    NoneAlike,
    /// Sides of one bulging surface.
    #[error(
        "their two sides do not face each other, as those of a passage do: they are flats or lobes, as of a nut or a cam"
    )]
    Flats,
    /// Holes through a ring or a disc.
    #[error("they are round holes, wide in the middle and closed above and below")]
    RoundHoles,
}
