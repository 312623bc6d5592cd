//! A table in every channel at once: instead of turning it to each and testing there, copies of it stand about one
//! channel as it stands about each.

use glam::{DMat3, DVec3};

use super::tour::Visit;
use crate::verify::pair::Solid;
use geometry::mesh::{Bounds, Mesh};
use geometry::triangle_distance::triangle_distance;
use task::{Cancel, Cancelled};

/// The most triangles that all copies of a body may have.
const MOST_TRIANGLES: usize = 2_000_000;
/// Greatest distance by which rounding takes a point off its triangle (mm).
const ROUNDING: f64 = 1e-6;

/// Copies of a body, each turned so that a channel's turn is undone.
pub(super) struct Copies<'a> {
    pub solid: Solid,
    body: &'a Mesh,
    visits: &'a [Visit],
}

impl<'a> Copies<'a> {
    /// The copies of `body`, in W, for `visits`; none for a single one, and where they would be too large.
    pub fn new(body: &'a Mesh, visits: &'a [Visit], cancel: &Cancel) -> Result<Option<Self>, Cancelled> {
        if visits.len() < 2 || body.triangles.len() * visits.len() > MOST_TRIANGLES {
            return Ok(None);
        }
        let mut all = Mesh::default();
        for visit in visits {
            cancel.check()?;
            let (turn, start) = (DMat3::from_rotation_x(-visit.turn), all.vertices.len() as u32);
            all.vertices.extend(body.vertices.iter().map(|&p| turn * p));
            all.triangles.extend(body.triangles.iter().map(|t| t.map(|v| v + start)));
        }
        Ok(Some(Self { solid: Solid::new(&all, DVec3::ZERO, cancel)?, body, visits }))
    }

    /// The visit whose copy the point `p` of the copies is on, and where it is on the body itself.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn visit_at(&self, p: DVec3, cancel: &Cancel) -> Result<Option<(Visit, DVec3)>, Cancelled> {
        for visit in self.visits {
            cancel.check()?;
            let on_body = DMat3::from_rotation_x(visit.turn) * p;
            if self.is_on_body(on_body) {
                return Ok(Some((*visit, on_body)));
            }
        }
        Ok(None)
    }

    fn is_on_body(&self, p: DVec3) -> bool {
        let here = Bounds { min: p, max: p };
        let near = |corners: &[DVec3; 3]| Bounds::of(*corners).grown(ROUNDING).intersects(&here);
        self.body.iter_corners().filter(near).any(|t| triangle_distance(&[p; 3], &t).distance <= ROUNDING)
    }
}
