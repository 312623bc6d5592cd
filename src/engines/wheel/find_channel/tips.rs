//! The tips of the blades of a channel: whether they are its outer bound, and whether they reach its shroud.

use glam::DVec2;

use super::super::channel::{Station, Surface, along_at, station_at};
use super::super::error::BliskError;
use super::super::frame::slices::Gap;
use super::agreement::{Measured, SPARSE, START};
use geometry::frame::angle_near;
use std::f64::consts::TAU;

/// A shroud is thicker than this share of the height.
const FILM: f64 = 1e-3;
/// Metal within this share of the height beyond the tips covers the passage.
const NEAR_TIPS: f64 = 0.2;
/// Share of the height beyond the tips at which blades have ended.
const BEYOND: f64 = 0.06;
/// Share of the passage's width within which a wall beyond the tips goes on from that below them.
const SAME_WALL: f64 = 0.25;
/// Share of the height from the shroud up to which a tip ends before it.
const MOST_GAP: f64 = 0.08;
/// Distance up to which places are one (mm).
const SAME_PLACE: f64 = 1e-6;

impl Measured<'_> {
    /// Share of the rays outwards, past the tips of a channel that lies `turn` further about the axis (rad), that meet
    /// metal within its height; 0 where there is a shroud, which is measured.
    pub(super) fn covered(&self, turn: f64) -> f64 {
        if self.meridian.shrouded {
            return 0.0;
        }
        self.metal_beyond_tips(turn, 1.0).len() as f64 / SPARSE.stations as f64
    }

    /// Refuses tips over which metal stands along part of the passage.
    ///
    /// # Errors
    /// [`BliskError::PartShroud`].
    pub fn check_tips(&self) -> Result<(), BliskError> {
        if self.tracer.is_drawn(Surface::Shroud) || self.tracer.options.shroud_radius_mm.given().is_some() {
            return Ok(());
        }
        match self.metal_beyond_tips(0.0, NEAR_TIPS)[..] {
            [] | [_] => {}
            ref met => {
                let DVec2 { x, y: r } = met[met.len() / 2];
                let share = met.len() as f64 / SPARSE.stations as f64;
                return Err(BliskError::PartShroud { share, x, r, joined: false });
            }
        }
        let higher = self.higher_blades();
        match higher.get(higher.len() / 2) {
            Some(&DVec2 { x, y: r }) if 2 * higher.len() > SPARSE.stations => Err(BliskError::HigherBlade { x, r }),
            _ => Ok(()),
        }
    }

    /// Where a wall of the channel goes on beyond the tips that bound it, at stations along the blades.
    fn higher_blades(&self) -> Vec<DVec2> {
        let goes_on = |u: usize| {
            let (station, [low, high]) = self.at_tips(u);
            let at = station.place(1.0 + BEYOND);
            let mut gaps = self.tracer.slices.gaps(at.x, at.y).into_iter();
            let gap = gaps.find(|gap| gap.holds(0.5 * (low + high)))?;
            let is_near = |a: f64, b: f64| (angle_near(a, b) - b).abs() < SAME_WALL * (high - low);
            (is_near(gap.low.theta, low) || is_near(gap.high.theta, high)).then_some(at)
        };
        self.columns().filter_map(goes_on).collect()
    }

    /// The greatest distance by which the blade on the high side ends before the shroud, along most of its length (mm);
    /// none where it is one with the shroud.
    pub fn tip_gap(&self) -> Option<f64> {
        if !self.meridian.shrouded {
            return None;
        }
        let slices = self.tracer.slices;
        let gap_at = |u: usize| {
            let (station, [low, high]) = self.at_tips(u);
            let [from, toward] = self.tracer.start_of(&station, 1.0 - START, Surface::Shroud);
            let gaps = slices.gaps(from.x, from.y);
            let gap = gaps.iter().find(|gap| gap.holds(0.5 * (low + high)))?;
            let thickness = |next: &Gap| (next.low.theta - gap.high.theta).rem_euclid(TAU);
            let thickness = gaps.iter().map(thickness).min_by(f64::total_cmp)?;
            let theta = gap.high.theta + 0.5 * thickness;
            let height = station.height();
            let (tip, facet) = slices.first_in_half_plane(theta, from, toward, (START + MOST_GAP) * height)?;
            // A ray may leave a thin blade that leans by its side.
            if tip < (START - MOST_GAP) * height || self.tracer.is_of_blade(facet, theta) {
                return None;
            }
            // Past the tip itself, which rounding may meet again.
            let past = from + (tip + SAME_PLACE) * toward;
            let (wide, _) = slices.first_in_half_plane(theta, past, toward, MOST_GAP * height)?;
            let between = past + 0.5 * wide * toward;
            (!slices.is_solid(between.x, between.y, theta)).then_some(wide)
        };
        // Beside its edges a tip may be rounded off.
        let gaps: Vec<f64> = self.columns().skip(1).take(SPARSE.stations - 2).filter_map(gap_at).collect();
        (2 * gaps.len() > SPARSE.stations).then(|| gaps.into_iter().fold(0.0, f64::max))
    }

    /// Columns of the walls' grids, evenly between the edges.
    fn columns(&self) -> impl Iterator<Item = usize> {
        let nu = self.walls[0].nu;
        (1..=SPARSE.stations).map(move |i| i * (nu - 1) / (SPARSE.stations + 1))
    }

    /// The station of a column at the tips, and the angles of the low and the high wall there (rad).
    fn at_tips(&self, u: usize) -> (Station, [f64; 2]) {
        let (tip, stations) = (self.walls[0].nv - 1, &self.meridian.stations);
        let ends = self.walls.map(|wall| wall.cylindrical(u, tip));
        let station = station_at(stations, along_at(stations, DVec2::new(ends[0].x, ends[0].r), 1.0));
        (station, [ends[0].theta, angle_near(ends[1].theta, ends[0].theta)])
    }

    /// Where rays outwards, past the tips of a channel that lies `turn` further about the axis (rad), meet metal within
    /// a share `reach` of its height, at stations along the blades.
    fn metal_beyond_tips(&self, turn: f64, reach: f64) -> Vec<DVec2> {
        let meets = |u: usize| {
            let (station, [low, high]) = self.at_tips(u);
            let theta = 0.5 * (low + high) + turn;
            let [from, toward] = self.tracer.start_of(&station, 1.0 - START, Surface::Shroud);
            let met = self.tracer.met(theta, from, toward, (START + reach) * station.height());
            // A blade that leans is no shroud.
            let (distance, _) = met.filter(|(_, facet)| !self.tracer.is_of_blade(*facet, theta))?;
            // A film without thickness is no shroud.
            let beyond = from + (distance + FILM * station.height()) * toward;
            self.tracer.slices.is_solid(beyond.x, beyond.y, theta).then(|| from + distance * toward)
        };
        self.columns().filter_map(meets).collect()
    }
}
