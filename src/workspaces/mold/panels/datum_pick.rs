//! The work datum as it is picked on the part.

use glam::DVec3;

use super::desk::MoldDesk;
use crate::workspaces::mold::document::MoldParams;
use mold::datum::rim_at;

/// How the origin or the X axis of the work datum is picked on the part.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum DatumPick {
    /// At a corner.
    Corner,
    /// In the middle between two parallel faces: a place of the first (mm) with its normal, once it is picked.
    Faces(Option<(DVec3, DVec3)>),
    /// At the centre of a hole.
    Hole,
    /// The X axis, from one corner to another: the first (mm), once it is picked.
    XAxis(Option<DVec3>),
}

impl DatumPick {
    /// What is to be clicked on.
    pub fn instruction(self) -> &'static str {
        match self {
            Self::Corner => "click on a corner of the mold",
            Self::Faces(None) => "click on the first of two parallel faces",
            Self::Faces(Some(_)) => "click on the other face",
            Self::Hole => "click on a hole, near its rim",
            Self::XAxis(None) => "click on the corner where an edge along X begins",
            Self::XAxis(Some(_)) => "click on the corner where it ends, towards +X",
        }
    }
}

impl MoldDesk {
    /// Begins to pick the origin or the X axis of the work datum on the part, or gives it up.
    pub fn pick_datum(&mut self, pick: DatumPick) {
        self.pick = (self.pick != Some(pick)).then_some(pick);
        // Electrodes would be in the way.
        self.electrodes.is_shown = false;
        self.electrodes.give_up_split();
    }

    /// Takes a place on the part (mm, in the axes of the mesh) with the normal there for what is being picked of the work
    /// datum.
    ///
    /// # Errors
    /// One line if it is not found there; it goes on being picked.
    pub fn take_datum(&mut self, place: DVec3, normal: DVec3) -> Result<(), &'static str> {
        let (Some(pick), Some(mold)) = (self.pick, self.work.mold()) else { return Ok(()) };
        let datum = &self.params().datum;
        let corner = || {
            let off = |p: &&DVec3| p.distance_squared(place);
            let nearest = mold.mesh.vertices.iter().min_by(|a, b| off(a).total_cmp(&off(b)));
            nearest.copied().ok_or("the mold has no corner")
        };
        let found = match pick {
            DatumPick::Corner => corner().map(|corner| datum.at(corner, "corner")),
            DatumPick::Faces(None) => {
                self.pick = Some(DatumPick::Faces(Some((place, normal))));
                return Ok(());
            }
            DatumPick::Faces(Some(first)) => {
                datum.between([first, (place, normal)]).ok_or("the two faces are not parallel: click on another one")
            }
            DatumPick::Hole => rim_at(self.work.survey(self.params()).map_or(&[], |found| &found.rims), place)
                .map(|rim| datum.at(rim.centre, &format!("hole dia {:.3}", 2.0 * rim.radius)))
                .ok_or("no round rim is near: click nearer to the rim of a hole"),
            DatumPick::XAxis(None) => {
                self.pick = Some(DatumPick::XAxis(Some(corner()?)));
                return Ok(());
            }
            DatumPick::XAxis(Some(first)) => datum
                .with_x_along(self.params().opening(), [first, corner()?])
                .ok_or("the corner lies over the first one: click on another one"),
        };
        let params = MoldParams { datum: found?, ..self.params().clone() };
        self.pick = None;
        self.edit(params);
        Ok(())
    }
}
