//! Bases: what tips stand on and a holder takes.

use glam::{DVec2, DVec3};

use super::params::{Blanks, ElectrodeParams};
use crate::geometry::mesh::{Bounds, Mesh};
use crate::geometry::solid::{self, SolidError};

/// How far tips are led into the base (mm), so that the two solids overlap.
pub(super) const INTO_BASE: f64 = 0.25;

/// A base: a block whose underside is at height 0, its middle at the origin.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Base {
    /// Its sides (mm).
    pub sides: DVec2,
    /// Its height (mm).
    pub height: f64,
    /// The corner that is cut off, at +X +Y (mm along each side).
    pub corner: f64,
}

impl Base {
    /// The base under tips with this box, centred on them, and the length of the blank that both are made from (mm).
    pub fn under(tips: &Bounds, params: &ElectrodeParams) -> (Self, f64) {
        let size = tips.size();
        let side = |length: f64| params.blanks.side(length + 2.0 * params.base_margin_mm);
        let (sides, least) = (DVec2::new(side(size.x), side(size.y)), params.base_height_mm);
        let length = params.blanks.rounded_up(size.z + least);
        (Self { sides, height: length - size.z, corner: params.datum_corner_mm }, length)
    }

    /// Its outline.
    pub fn outline(&self) -> Vec<DVec2> {
        let DVec2 { x, y } = self.sides / 2.0;
        let corners = [(-x, -y), (x, -y), (x, y - self.corner), (x - self.corner, y), (-x, y)];
        let mut outline: Vec<DVec2> = corners.into_iter().map(DVec2::from).collect();
        outline.dedup();
        outline
    }

    /// The base with tips that reach from below into it.
    ///
    /// # Errors
    /// [`SolidError`].
    pub fn with_tips(&self, tips: &[Mesh]) -> Result<Mesh, SolidError> {
        let mut body = solid::prism(&[&self.outline()], 0.0, self.height)?;
        for tip in tips {
            body = solid::union(&body, tip)?;
        }
        Ok(body)
    }
}

/// Tips on a plate a little larger than they are: what cutters make of it is what they make of the electrode.
///
/// # Errors
/// [`SolidError`].
pub fn on_plate(tips: &Mesh) -> Result<Mesh, SolidError> {
    /// How far the plate reaches beyond the tips, and its thickness (mm).
    const PLATE: f64 = 1.0;
    let bounds = tips.bounds().grown(PLATE);
    let (low, high) = (bounds.min.truncate(), bounds.max.truncate());
    let outline = [low, DVec2::new(high.x, low.y), high, DVec2::new(low.x, high.y)];
    solid::union(&solid::prism(&[&outline], 0.0, PLATE)?, tips)
}

/// The diameter of the least round blank around sides (mm), if there is one.
pub fn round_blank(sides: DVec2, blanks: &Blanks) -> Option<f64> {
    blanks.diameters_mm.iter().copied().find(|d| *d >= sides.length())
}

/// A mesh turned about Z and moved.
pub fn placed(mesh: &Mesh, turn: f64, shift: DVec3) -> Mesh {
    let turned = DVec2::from_angle(turn);
    mesh.mapped(|p| turned.rotate(p.truncate()).extend(p.z) + shift)
}
