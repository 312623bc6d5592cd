//! Warnings to the user: where the mold is not what the computation presumes.

use files::report::counted;
use geometry::mesh::Mesh;
use serde::{Deserialize, Serialize};

use super::opening::Opening;
use super::unseen::OpeningProposal;
use task::{Cancel, Cancelled};

/// Warning on a mold.
#[derive(Debug, Clone, PartialEq, Serialize, thiserror::Error, Deserialize)]
#[serde(rename_all = "kebab-case", tag = "warning")]
pub enum MoldWarning {
    /// No layer has material.
    #[error("the mold has no material at any height: it has no triangles that enclose a volume")]
    Empty,
    /// The mesh has edges with a face on one side only.
    #[error("the surface is not closed: {edges} edges have no face on one side; repair the mesh")]
    NotClosed {
        /// How many edges.
        edges: usize,
    },
    /// The mesh has gaps: what they open is missing.
    #[error(
        "the surface is open between z = {from:.3} and {to:.3} mm, first at x = {:.3}, y = {:.3}: what \
         is left uncut there is not known; repair the mesh",
        place[0], place[1]
    )]
    Open {
        /// In how many layers.
        layers: usize,
        /// The lowest of them (mm).
        from: f64,
        /// The highest of them (mm).
        to: f64,
        /// Where a piece of an outline ends in the lowest (mm).
        place: [f64; 2],
    },
    /// Outlines enclose something from the wrong side, as where the surface is inside out or crosses itself; that counts as
    /// air.
    #[error(
        "the surface is inside out, or crosses itself, between z = {from:.3} and {to:.3} mm: what lies on its wrong \
         side counts as air there; repair the mesh"
    )]
    InsideOut {
        /// In how many layers.
        layers: usize,
        /// The lowest of them (mm).
        from: f64,
        /// The highest of them (mm).
        to: f64,
    },
    /// The mold has openings through its underside.
    #[error(
        "the mold is open through its underside over {area:.3} mm^2: rest material is looked for there down to the \
         underside, and what is outside the block's outline counts as air"
    )]
    NoFloor {
        /// Area of the openings at the bottom (mm^2).
        area: f64,
    },
    /// The opening direction hides a large part of the cavity.
    #[error(
        "the opening direction hides {hidden_mm2:.1} of {inner_mm2:.1} mm^2 of the part's inner faces ({:.0} %), which \
         look away or lie under others: {}",
        100.0 * hidden_mm2 / inner_mm2,
        if *is_proposed {
            "no other one shows more of the part, so that they need another set-up or a slide"
        } else {
            "choose the proposed one, unless these faces are made otherwise"
        }
    )]
    HiddenCavity {
        /// Area of inner faces that are not seen from there, about (mm^2).
        hidden_mm2: f64,
        /// Area of all inner faces (mm^2).
        inner_mm2: f64,
        /// Whether the direction is the proposed one.
        #[serde(default)]
        is_proposed: bool,
    },
    /// Pieces in single shallow corners, as between the facets of a round.
    #[error(
        "{pieces} pieces lie in single corners up to {depth:.4} mm deep: if these are facets of a round, set the depth \
         tolerance above that"
    )]
    ShallowCorners {
        /// How many pieces of layers.
        pieces: usize,
        /// The deepest (mm).
        depth: f64,
    },
    /// A field of heights that sees too little.
    #[error(
        "the field of heights has a step of {step:.4} mm, more than a tenth of the smallest cutter's radius of \
         {radius} mm: what rounded cutters leave in corners may be missed; leave out the smallest cutters, or cut the \
         mold in parts"
    )]
    CoarseGrid {
        /// Step (mm).
        step: f64,
        /// The smallest radius (mm).
        radius: f64,
    },
    /// Regions that every cutter leaves, too thin for the field of heights.
    #[error(
        "every cutter leaves slivers in {}, up to {thickness:.4} mm thick, as at x = {:.3}, y = {:.3}, z = \
         {:.3}: they are too thin for regions, and no electrode burns them; give a cutter of a smaller radius, or a \
         depth tolerance above that", counted(*regions, "place"), place[0], place[1], place[2]
    )]
    SliversLeft {
        /// Number of slivers.
        regions: usize,
        /// Thickness of the thickest across the surface (mm).
        thickness: f64,
        /// Middle of that one, in the axes of the mesh (mm).
        place: [f64; 3],
    },
    /// Regions that flat cutters leave, of which no grid is fine enough to tell more.
    #[error(
        "{regions} regions that flat cutters leave, up to {thickness:.4} mm thick, are too thin for any \
         height map: whether the rounded cutters take them is not known"
    )]
    ThinRegions {
        /// Number of regions.
        regions: usize,
        /// The thickest (mm).
        thickness: f64,
    },
    /// Volumes of what is left, found in two ways, that differ by much.
    #[error(
        "what the cutters leave is known to be between {:.3} and {:.3} mm^3 only, most uncertain about x = {:.3}, y = \
         {:.3}, z = {:.3}: a place there may be just as wide as a cutter; look whether one enters it, or search again \
         with a finer step",
        volumes_mm3[0], volumes_mm3[1], place[0], place[1], place[2]
    )]
    Uncertain {
        /// Both volumes, the smaller first (mm^3).
        volumes_mm3: [f64; 2],
        /// Middle of the place where they differ most, in the axes of the mesh (mm).
        place: [f64; 3],
    },
    /// A surface in coarser pieces than it should have.
    #[error(
        "the surface of what is left has more pieces than a computer holds with ease: its boundary is drawn as coarse \
         as {fineness:.3} mm, and faces, areas of surfaces and lengths of segments are that rough; volumes and plan \
         areas are as fine as ever"
    )]
    CoarseSurface {
        /// Longest side of its smallest pieces (mm).
        fineness: f64,
    },
    /// Slabs that should have been halved were not.
    #[error("{most} layers are the most that are allowed: between them less is known than was asked for")]
    LayerLimit {
        /// The most layers that are allowed.
        most: usize,
    },
}

impl MoldWarning {
    /// The warning about a mesh that opens in this direction: a hidden cavity tells whether that is the proposed one.
    ///
    /// # Errors
    /// If it is cancelled.
    pub fn of_opening(self, mesh: &Mesh, opening: Opening, cancel: &Cancel) -> Result<Self, Cancelled> {
        Ok(match self {
            Self::HiddenCavity { hidden_mm2, inner_mm2, .. } => {
                let proposed = OpeningProposal::of(mesh, cancel)?.opening.direction();
                let is_proposed = proposed.distance(opening.direction()) < 1e-3;
                Self::HiddenCavity { hidden_mm2, inner_mm2, is_proposed }
            }
            other => other,
        })
    }

    /// Whether the mold's surface is no boundary of a solid, so that what is found there may be wrong.
    pub fn is_of_surface(&self) -> bool {
        matches!(self, Self::Empty | Self::NotClosed { .. } | Self::Open { .. } | Self::InsideOut { .. })
    }
}
