//! Following a way while the electrode grows: a way of a smaller electrode is nearly one of a larger.

use rayon::prelude::*;

use super::corridor::{Way, Waypoint};
use super::ground::{Ground, Place};
use crate::pose::Pose;
use task::{Cancel, Cancelled};

impl Ground<'_> {
    /// Times that a motion that is not free is halved.
    const HALVINGS: usize = 3;

    /// The way near `known`, withdrawn distances (mm) and poses of a way of a similar electrode from the final pose on: each
    /// pose moved to where this electrode has most room. None if there is none, or no free motion leads from one to the
    /// next.
    pub(super) fn followed(&self, known: &[(f64, Pose)], cancel: &Cancel) -> Result<Option<Way>, Cancelled> {
        let place = |&(s, pose): &(f64, Pose)| {
            cancel.check()?;
            let place = if s == 0.0 { self.origin() } else { self.roomiest_near(pose, s) };
            Ok(self.is_free(&place).then_some(place))
        };
        let places: Result<Vec<Option<Place>>, Cancelled> = known.par_iter().map(place).collect();
        let Some(places) = places?.into_iter().collect::<Option<Vec<Place>>>() else { return Ok(None) };
        let stretch = |pair: &[Place]| {
            cancel.check()?;
            let d = self.stretch(&pair[0], &pair[1], Self::HALVINGS);
            Ok(d)
        };
        let stretches: Result<Vec<Option<Vec<Place>>>, Cancelled> = places.par_windows(2).map(stretch).collect();
        Ok(stretches?.into_iter().collect::<Option<Vec<_>>>().map(|all| self.way_over(&all.concat())))
    }

    /// Places from the one after `from` to `to` with free motions between them.
    fn stretch(&self, from: &Place, to: &Place, halvings: usize) -> Option<Vec<Place>> {
        if self.joins((from.s, &from.pose), (to.s, &to.pose)) {
            return Some(vec![*to]);
        }
        let halvings = halvings.checked_sub(1)?;
        let middle = self.roomiest_near(from.pose.lerp(&to.pose, 0.5), 0.5 * (from.s + to.s));
        if !self.is_free(&middle) {
            return None;
        }
        Some([self.stretch(from, &middle, halvings)?, self.stretch(&middle, to, halvings)?].concat())
    }

    /// The way from the final pose over `places`.
    fn way_over(&self, places: &[Place]) -> Way {
        let mut way = vec![Waypoint::first(self.room)];
        for place in places {
            let before = way[way.len() - 1];
            way.push(before.then(place, 0, self));
        }
        way
    }
}
