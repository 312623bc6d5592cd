//! The figures of a channel's centreline, for `inspect` and reports.

use serde::Serialize;

use super::{Centreline, CentrelineError};
use crate::channel::{BladeSide, Channel};
use crate::nurbs_wall::NurbsWall;
use geometry::exact::ExactMesh;
use geometry::nurbs::FitError;
use task::Cancel;

/// The figures of a wall.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct WallFit {
    /// Face of the blade that the wall is.
    pub side: BladeSide,
    /// The surface against the points that it was made from.
    pub points: FitError,
    /// The surface against the mesh.
    pub mesh: FitError,
}

/// The figures of a channel's centreline and of its walls as NURBS.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct CentrelineSummary {
    /// Length of the centreline between the blades (mm).
    pub length_mm: f64,
    /// Sections in which circles were inscribed; 0 where the line is half way between the walls.
    pub sections: usize,
    /// Diameter of the least and of the greatest circle (mm).
    pub diameters_mm: Option<[f64; 2]>,
    /// The curve against the middles of the sections.
    pub fit: FitError,
    /// The low and the high wall.
    pub walls: [WallFit; 2],
}

impl CentrelineSummary {
    /// The figures of `channel`, whose blisk `mesh` is in W.
    ///
    /// # Errors
    /// [`CentrelineError`].
    pub fn new(channel: &Channel, mesh: &ExactMesh, cancel: &Cancel) -> Result<Self, CentrelineError> {
        let line = Centreline::of_channel(channel, cancel)?;
        Self::of_line(line, &NurbsWall::of_channel(channel)?, [channel.low.side, channel.high.side], mesh, cancel)
    }

    /// The figures of a low and a high wall along X, which are these sides of their blades; the blisk `mesh` is in the
    /// same frame.
    ///
    /// # Errors
    /// [`CentrelineError`].
    pub fn of_walls(
        walls: &[NurbsWall; 2],
        sides: [BladeSide; 2],
        mesh: &ExactMesh,
        cancel: &Cancel,
    ) -> Result<Self, CentrelineError> {
        let line = Centreline::between(&walls[0], &walls[1], cancel)?;
        Self::of_line(line, walls, sides, mesh, cancel)
    }

    fn of_line(
        line: Centreline,
        [low, high]: &[NurbsWall; 2],
        sides: [BladeSide; 2],
        mesh: &ExactMesh,
        cancel: &Cancel,
    ) -> Result<Self, CentrelineError> {
        let fit = |wall: &NurbsWall, side| {
            cancel.check()?;
            Ok::<_, CentrelineError>(WallFit { side, points: wall.off_points, mesh: wall.off_mesh(mesh) })
        };
        Ok(Self {
            length_mm: line.length(),
            sections: line.sections.len(),
            diameters_mm: line.diameters(),
            fit: line.fit,
            walls: [fit(low, sides[0])?, fit(high, sides[1])?],
        })
    }
}
