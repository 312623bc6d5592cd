//! Deviation of measured sections of a blade from the walls that were planned for: the judgement of P1's accuracy.
//!
//! A deviation is the distance of a measured point from the wall along the wall's normal, positive into the channel,
//! where metal is left, and negative where too much is gone. Points beside a wall, such as those beyond its first and last
//! section, are not judged; ahead of a round edge, which faces upstream, they are.

use std::fmt;

use glam::DVec3;
use rayon::prelude::*;
use serde::Serialize;

use super::nurbs_wall::{MeasuredError, NurbsWall};
use super::sections::MeasuredSection;
use task::{Cancel, Cancelled};

/// Greatest deviation with which P1 accepts a blade (mm).
pub const P1_LIMIT_MM: f64 = 0.03;

/// Deviations of the points of one section on one wall.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SideDeviation {
    /// Deviation of each point (mm), in the order of the section; none where a point is not judged.
    #[serde(skip)]
    pub of_points: Vec<Option<f64>>,
    /// Parameters on the wall of each point, in the order of the section; none where a point is not judged.
    #[serde(skip)]
    places: Vec<Option<[f64; 2]>>,
    /// The deviation greatest in size, with its sign (mm); none where no point is judged.
    pub greatest_mm: Option<f64>,
    /// Point of the greatest deviation, in W (mm).
    pub greatest_at: Option<DVec3>,
    /// Mean of the deviations (mm): by how much the section as a whole is off.
    pub mean_mm: f64,
    /// Standard deviation about the mean (mm): noise and form.
    pub spread_mm: f64,
    /// Points that are judged.
    pub judged: usize,
    /// Points that are not, because they lie beyond the wall.
    pub beyond: usize,
}

/// Deviations of one section.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SectionDeviation {
    /// Name of the section.
    pub name: String,
    /// The low and the high wall.
    pub sides: [SideDeviation; 2],
}

/// Deviations of all sections, judged against a limit.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SectionsDeviation {
    /// Greatest deviation allowed, either way (mm).
    pub limit_mm: f64,
    /// The sections from the hub outwards.
    pub sections: Vec<SectionDeviation>,
}

impl SideDeviation {
    /// Distance beside the wall's border up to which a point is still judged (mm): a probe does not stop exactly there.
    const BESIDE: f64 = 0.05;

    /// `sign` is that of the wall's normal into the channel.
    fn new(points: &[DVec3], wall: &NurbsWall, sign: f64, cancel: &Cancel) -> Result<Self, Cancelled> {
        let feet = wall.feet();
        let deviation = |p: &DVec3| {
            cancel.check()?;
            let foot = feet.foot(*p);
            Ok((foot.aside <= Self::BESIDE).then_some((foot.at, sign * foot.height)))
        };
        let found = points.par_iter().map(deviation).collect::<Result<Vec<Option<([f64; 2], f64)>>, Cancelled>>()?;
        let (places, of_points): (Vec<_>, Vec<_>) = found.into_iter().map(Option::unzip).unzip();
        let judged = || of_points.iter().zip(points).filter_map(|(d, p)| Some(((*d)?, *p)));
        let count = judged().count();
        let mean = |of: &dyn Fn(f64) -> f64| judged().map(|(d, _)| of(d)).sum::<f64>() / count.max(1) as f64;
        let mean_mm = mean(&|d| d);
        let spread_mm = mean(&|d| (d - mean_mm).powi(2)).sqrt();
        let greatest = judged().max_by(|a, b| a.0.abs().total_cmp(&b.0.abs()));
        Ok(Self {
            greatest_mm: greatest.map(|g| g.0),
            greatest_at: greatest.map(|g| g.1),
            mean_mm,
            spread_mm,
            judged: count,
            beyond: points.len() - count,
            of_points,
            places,
        })
    }
}

/// Parameter across the sections, and deviation (mm), of a section where it passes `u`, on straight lines between its `points`,
/// which are their parameters and deviations in order along the chord; none where there is none.
fn passing(points: &[([f64; 2], f64)], u: f64) -> Option<[f64; 2]> {
    let after = points.partition_point(|(at, _)| at[0] < u).min(points.len().checked_sub(1)?);
    let (b, a) = (&points[after], &points[after.saturating_sub(1)]);
    let span = b.0[0] - a.0[0];
    let t = if span > 0.0 { ((u - a.0[0]) / span).clamp(0.0, 1.0) } else { 1.0 };
    Some([a.0[1] + t * (b.0[1] - a.0[1]), a.1 + t * (b.1 - a.1)])
}

impl SectionsDeviation {
    /// Deviations of `sections` from the low and the high wall, in the same frame, judged against `limit_mm`.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn new(
        sections: &[MeasuredSection],
        [low, high]: &[NurbsWall; 2],
        limit_mm: f64,
        cancel: &Cancel,
    ) -> Result<Self, Cancelled> {
        let section = |s: &MeasuredSection| {
            let sides =
                [SideDeviation::new(&s.low, low, 1.0, cancel)?, SideDeviation::new(&s.high, high, -1.0, cancel)?];
            Ok(SectionDeviation { name: s.name.clone(), sides })
        };
        Ok(Self { limit_mm, sections: sections.iter().map(section).collect::<Result<_, _>>()? })
    }

    /// Each section but the first and the last judged against walls through the others: a section that is off shows by its
    /// whole error, where walls through all of them would go along with it. Where some are beyond the limit, the one without
    /// which the others agree best is left out of the walls for all others, and so on, so that a good section is not blamed for
    /// its neighbour. What the judgement lacks in accuracy is what a wall changes between the sections beside it.
    ///
    /// # Errors
    /// [`MeasuredError`] if the sections cannot be joined, or when cancelled.
    pub fn of_each(sections: &[MeasuredSection], limit_mm: f64, cancel: &Cancel) -> Result<Self, MeasuredError> {
        /// Most sections that are tried for being the one that is off.
        const TRIED: usize = 8;
        let judged = |left_out: &[usize]| {
            let one = |k: usize| Ok((k, Self::against_others(sections, (k, left_out), limit_mm, cancel)?));
            (1..sections.len().saturating_sub(1)).map(one).collect::<Result<Vec<_>, MeasuredError>>()
        };
        let size = |of: &Option<SectionDeviation>| {
            let sides = of.iter().flat_map(|section| &section.sides);
            sides.filter_map(|side| side.greatest_mm).map(f64::abs).fold(0.0, f64::max)
        };
        let mut left_out = Vec::new();
        let mut found = judged(&left_out)?;
        while 3 * (left_out.len() + 1) < sections.len() {
            let mut off: Vec<(usize, f64)> = found.iter().map(|(k, of)| (*k, size(of))).collect();
            off.retain(|(k, most)| *most > limit_mm && !left_out.contains(k));
            off.sort_by(|a, b| b.1.total_cmp(&a.1));
            let mut best: Option<(f64, usize)> = None;
            for (k, _) in off.iter().take(TRIED) {
                let without = [&left_out[..], &[*k]].concat();
                let rest = judged(&without)?;
                let rest =
                    rest.iter().filter(|(k, _)| !without.contains(k)).map(|(_, of)| size(of)).fold(0.0, f64::max);
                if best.is_none_or(|(least, _)| rest < least) {
                    best = Some((rest, *k));
                }
            }
            let (Some((rest, k)), Some((_, most))) = (best, off.first()) else { break };
            if rest >= *most {
                break;
            }
            left_out.push(k);
            found = judged(&left_out)?;
        }
        Ok(Self { limit_mm, sections: found.into_iter().filter_map(|(_, of)| of).collect() })
    }

    /// Section `k` against walls through those beside it that are not left out; none where these are too few.
    fn against_others(
        sections: &[MeasuredSection],
        (k, left_out): (usize, &[usize]),
        limit_mm: f64,
        cancel: &Cancel,
    ) -> Result<Option<SectionDeviation>, MeasuredError> {
        /// Sections on each side that the walls go through, and least number of all of them.
        const BESIDE: usize = 3;
        const LEAST: usize = 3;
        let is_in = |i: &usize| !left_out.contains(i);
        let mut before: Vec<usize> = (0..k).rev().filter(is_in).take(BESIDE).collect();
        before.reverse();
        let after: Vec<usize> = (k + 1..sections.len()).filter(is_in).take(BESIDE).collect();
        if before.is_empty() || after.is_empty() || before.len() + after.len() < LEAST {
            return Ok(None);
        }
        let others: Vec<MeasuredSection> = before.iter().chain(&after).map(|i| sections[*i].clone()).collect();
        let walls = NurbsWall::of_measured(&others, cancel)?;
        Ok(Self::new(&sections[k..=k], &walls, limit_mm, cancel)?.sections.pop())
    }

    /// Deviation (mm) at every pair of the parameters `u` along the chord and `v` across the sections of wall `wall` (0 low,
    /// 1 high), which these sections were judged against; index `u * v.len() + v`. On straight lines between the measured
    /// points; not a number beyond the first and the last section. Of sections that are among `instead`, the deviations there
    /// are taken.
    pub fn over_wall(&self, instead: &Self, wall: usize, [u, v]: [&[f64]; 2]) -> Vec<f64> {
        /// How far beyond the first and the last section the map goes on: sections are not quite at one parameter.
        const BEYOND: f64 = 1e-3;
        let points = |section: &SectionDeviation| {
            let own = &section.sides[wall];
            let other = instead.sections.iter().find(|other| other.name == section.name);
            let values = other.map_or(&own.of_points, |other| &other.sides[wall].of_points);
            let both = own.places.iter().zip(values).filter_map(|(place, value)| Some(((*place)?, (*value)?)));
            let mut points: Vec<([f64; 2], f64)> = both.collect();
            points.sort_by(|a, b| a.0[0].total_cmp(&b.0[0]));
            points
        };
        let sections: Vec<_> = self.sections.iter().map(points).collect();
        let at_u = |u: &f64| {
            let mut rows: Vec<[f64; 2]> = sections.iter().filter_map(|points| passing(points, *u)).collect();
            rows.sort_by(|a, b| a[0].total_cmp(&b[0]));
            rows
        };
        let between = |rows: &[[f64; 2]], v: f64| {
            let (Some(first), Some(last)) = (rows.first(), rows.last()) else { return f64::NAN };
            if v < first[0] - BEYOND || v > last[0] + BEYOND {
                return f64::NAN;
            }
            let after = rows.partition_point(|row| row[0] < v).min(rows.len() - 1);
            let (a, b) = (rows[after.saturating_sub(1)], rows[after]);
            let t = if b[0] > a[0] { ((v - a[0]) / (b[0] - a[0])).clamp(0.0, 1.0) } else { 1.0 };
            a[1] + t * (b[1] - a[1])
        };
        u.iter().map(at_u).flat_map(|rows| v.iter().map(move |v| between(&rows, *v)).collect::<Vec<_>>()).collect()
    }

    /// The section and the wall (0 low, 1 high) with the deviation greatest in size, and that deviation (mm).
    pub fn greatest(&self) -> Option<(&str, usize, f64)> {
        let sides =
            self.sections.iter().flat_map(|s| (0..2).filter_map(|i| Some((&*s.name, i, s.sides[i].greatest_mm?))));
        sides.max_by(|a, b| a.2.abs().total_cmp(&b.2.abs()))
    }

    /// Whether every wall of every section has points that are judged, and all of these are within the limit.
    pub fn holds(&self) -> bool {
        let within = |side: &SideDeviation| side.greatest_mm.is_some_and(|d| d.abs() <= self.limit_mm);
        !self.sections.is_empty() && self.sections.iter().flat_map(|s| &s.sides).all(within)
    }

    /// The verdict in a sentence.
    pub fn verdict(&self) -> String {
        let limit = self.limit_mm;
        match self.greatest() {
            None => "not judged: no measured point lies on the walls; check the frame of the table".to_owned(),
            Some((name, wall, most)) => {
                let place = format!("{most:+.4} mm on the {} wall of section {name}", ["low", "high"][wall]);
                match (self.holds(), most.abs() > limit) {
                    (true, _) => format!("within {limit} mm: greatest deviation {place}"),
                    (false, true) => format!("not within {limit} mm: greatest deviation {place}"),
                    (false, false) => {
                        format!("not judged as a whole: a section has no point on a wall; greatest {place}")
                    }
                }
            }
        }
    }
}

impl fmt::Display for SectionsDeviation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{:<18}{}", "Measured", self.verdict())?;
        let head = ["greatest", "mean", "spread", "judged", "beyond"].map(|title| format!("{title:>10}")).concat();
        writeln!(f, "{:<18}{:<16}{:<5}{head}   mm", "Deviation", "section", "wall")?;
        for section in &self.sections {
            for (wall, side) in ["low", "high"].iter().zip(&section.sides) {
                let greatest = side.greatest_mm.map_or("-".to_owned(), |d| format!("{d:+.4}"));
                writeln!(
                    f,
                    "{:<18}{:<16}{wall:<5}{greatest:>10}{:>+10.4}{:>10.4}{:>10}{:>10}",
                    "", section.name, side.mean_mm, side.spread_mm, side.judged, side.beyond
                )?;
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;
    use crate::parametric::{ChannelSide, ParametricBlisk};

    const SIDES: [ChannelSide; 2] = [ChannelSide::Low, ChannelSide::High];

    /// Sections at `heights` with `points` on each wall, each point moved along the exact normal into the channel by
    /// `error`, a function of section, wall and point.
    fn sections(heights: &[f64], points: usize, error: impl Fn(usize, usize, usize) -> f64) -> Vec<MeasuredSection> {
        let blisk = ParametricBlisk::default();
        let wall = |k: usize, side: usize| {
            let along = |i: usize| 0.5 - 0.5 * (i as f64 / (points - 1) as f64 * PI).cos();
            let point = |i: usize| {
                let [p, normal] = blisk.wall_at(SIDES[side], along(i), heights[k]);
                p + error(k, side, i) * normal
            };
            (0..points).map(point).collect()
        };
        let section = |k: usize| MeasuredSection {
            name: format!("{k}"),
            low: wall(k, 0),
            high: wall(k, 1),
            ..Default::default()
        };
        (0..heights.len()).map(section).collect()
    }

    fn judged(error: impl Fn(usize, usize, usize) -> f64) -> SectionsDeviation {
        let never = Cancel::default();
        let heights: Vec<f64> = (0..9).map(|k| f64::from(k) / 8.0).collect();
        let walls = NurbsWall::of_measured(&sections(&heights, 121, |_, _, _| 0.0), &never).unwrap();
        // Measured between the sections and the points that the walls were made from.
        let measured = sections(&[0.07, 0.31, 0.55, 0.9], 44, error);
        SectionsDeviation::new(&measured, &walls, P1_LIMIT_MM, &never).unwrap()
    }

    #[test]
    fn a_section_without_error_is_within_and_a_shifted_one_is_off_by_its_shift() {
        for (shift, holds) in [(0.0, true), (0.027, true), (-0.027, true), (0.033, false), (-0.2, false)] {
            let found = judged(|_, _, _| shift);
            assert_eq!(found.holds(), holds, "{shift}: {found}");
            for side in found.sections.iter().flat_map(|s| &s.sides) {
                assert!((side.mean_mm - shift).abs() < 1e-3, "{shift}: {found}");
                assert!((side.greatest_mm.unwrap() - shift).abs() < 2e-3, "{shift}: {found}");
                assert!(side.judged >= 42, "{found}");
            }
        }
    }

    #[test]
    fn one_wall_of_one_section_that_is_off_is_found_and_named() {
        let found = judged(|section, side, _| if (section, side) == (2, 1) { -0.045 } else { 0.004 });
        let (name, wall, most) = found.greatest().unwrap();
        assert_eq!((name, wall, found.holds()), ("2", 1, false));
        assert!((most + 0.045).abs() < 2e-3);
        assert!(found.verdict().contains("high wall of section 2"), "{}", found.verdict());
        let others = found.sections.iter().flat_map(|s| &s.sides).filter(|s| s.greatest_mm.unwrap().abs() < 7e-3);
        assert_eq!(others.count(), 7);
    }

    #[test]
    fn noise_of_known_size_is_spread_and_not_mean() {
        // Even over -a to a: its standard deviation is a / sqrt(3).
        let noise = |a: f64| {
            move |k: usize, side: usize, i: usize| {
                let n = (k * 88 + side * 44 + i) as f64;
                a * (2.0 * (n * 0.618_033_988_749_894_9).fract() - 1.0)
            }
        };
        for (a, holds) in [(0.02, true), (0.06, false)] {
            let found = judged(noise(a));
            assert_eq!(found.holds(), holds, "{found}");
            for side in found.sections.iter().flat_map(|s| &s.sides) {
                assert!(side.mean_mm.abs() < 0.1 * a, "{found}");
                assert!((side.spread_mm / (a / 3f64.sqrt()) - 1.0).abs() < 0.1, "{found}");
                assert!(side.greatest_mm.unwrap().abs() < a + 2e-3, "{found}");
            }
        }
    }

    #[test]
    fn the_map_has_the_error_of_each_section_where_it_lies_and_goes_evenly_from_one_to_the_next() {
        let never = Cancel::default();
        let heights: Vec<f64> = (0..9).map(|k| f64::from(k) / 8.0).collect();
        let walls = NurbsWall::of_measured(&sections(&heights, 121, |_, _, _| 0.0), &never).unwrap();
        let errors = [0.01, -0.03, 0.02];
        let measured = sections(&[0.25, 0.5, 0.75], 44, |k, side, _| if side == 0 { errors[k] } else { 0.0 });
        let found = SectionsDeviation::new(&measured, &walls, P1_LIMIT_MM, &never).unwrap();
        let u = [0.2, 0.5, 0.8];
        let v = [walls[0].v[1], walls[0].v[2], 0.5 * (walls[0].v[2] + walls[0].v[4]), walls[0].v[4], walls[0].v[6]];
        let map = found.over_wall(&found, 0, [&u, &v]);
        for row in map.chunks(v.len()) {
            assert!(row[0].is_nan(), "nothing was measured below the first section");
            for (value, wanted) in row[1..].iter().zip([0.01, -0.01, -0.03, 0.02]) {
                assert!((value - wanted).abs() < 2e-3, "{row:?}");
            }
        }
        assert!(found.over_wall(&found, 1, [&u, &v]).iter().skip(1).filter(|d| d.is_finite()).all(|d| d.abs() < 1e-3));
    }

    #[test]
    fn a_section_that_is_off_shows_against_the_others_by_its_whole_error() {
        let heights: Vec<f64> = (0..9).map(|k| f64::from(k) / 8.0).collect();
        let measured = sections(&heights, 61, |k, side, _| if (k, side) == (4, 1) { -0.045 } else { 0.0 });
        let found = SectionsDeviation::of_each(&measured, P1_LIMIT_MM, &Cancel::default()).unwrap();
        assert_eq!(
            found.sections.iter().map(|s| s.name.as_str()).collect::<Vec<_>>(),
            ["1", "2", "3", "4", "5", "6", "7"]
        );
        let (name, wall, _) = found.greatest().unwrap();
        assert_eq!((name, wall, found.holds()), ("4", 1, false));
        let mean = found.sections[3].sides[1].mean_mm;
        assert!((mean + 0.045).abs() < 4e-3, "{found}");
        // Far from its neighbours, as at these heights, a good section would be blamed for what is off beside it.
        let heights = [0.06, 0.2, 0.32, 0.44, 0.57, 0.7, 0.94];
        for (off, wall) in [(4, 1), (2, 0), (5, 0)] {
            let measured = sections(&heights, 58, |k, side, i| {
                let noise = 0.005 * (2.0 * ((k * 116 + side * 58 + i) as f64 * 0.618_033_988_749_894_9).fract() - 1.0);
                noise + if (k, side) == (off, wall) { -0.045 } else { 0.0 }
            });
            let found = SectionsDeviation::of_each(&measured, P1_LIMIT_MM, &Cancel::default()).unwrap();
            let beyond =
                found.sections.iter().filter(|s| s.sides.iter().any(|d| d.greatest_mm.unwrap().abs() > P1_LIMIT_MM));
            assert_eq!(beyond.map(|s| s.name.clone()).collect::<Vec<_>>(), [off.to_string()], "{found}");
            let side = &found.sections.iter().find(|s| s.name == off.to_string()).unwrap().sides[wall];
            assert!((side.mean_mm + 0.045).abs() < 5e-3, "{found}");
        }
    }

    #[test]
    fn a_section_beyond_the_walls_is_not_judged_and_a_point_ahead_of_the_edge_is() {
        let never = Cancel::default();
        let walls = NurbsWall::of_measured(&sections(&[0.0, 0.5, 1.0], 61, |_, _, _| 0.0), &never).unwrap();
        let mut measured = sections(&[0.5, 1.2], 20, |_, _, _| 0.0);
        let found = SectionsDeviation::new(&measured, &walls, P1_LIMIT_MM, &never).unwrap();
        assert_eq!(found.sections[1].sides[1].judged, 0);
        assert!(!found.holds(), "what is not judged is not good");
        assert!(found.verdict().starts_with("not judged"), "{}", found.verdict());
        // The wall turns round to face upstream at its edge: what stands there is an edge that is too long.
        measured[0].low[0].x -= 0.5;
        let found = SectionsDeviation::new(&measured, &walls, P1_LIMIT_MM, &never).unwrap();
        assert!((found.sections[0].sides[0].greatest_mm.unwrap() - 0.5).abs() < 0.01, "{found}");
        assert!(found.verdict().starts_with("not within"), "{}", found.verdict());
    }
}
