//! The two walls of a channel as grids of points that lie exactly on the mesh, between the blades' edges.

use std::f64::consts::PI;

use glam::DVec3;
use rayon::prelude::*;

use super::super::channel::{BladeSide, ChannelWall, MeridianSample, radii_at};
use super::super::error::BliskError;
use super::super::frame::slices::{Crossing, Gap};
use super::meridian::{Place, Tracer};
use geometry::frame::Cylindrical;

/// The first and last row of points stay away from hub and shroud by this share of the height, so that the
/// facets of the end walls do not cut their circles.
pub(super) const INSET: f64 = 0.005;

/// A curve along the channel at a constant share of the height, between the blades' edges.
pub(super) struct Row {
    /// Share of the height, 0 at the hub and 1 at the shroud.
    share: f64,
    /// The last place before the edges on the -X side.
    pub front: Place,
    /// The last place before the edges on the +X side.
    pub back: Place,
    /// A place between them.
    inside: Place,
}

/// Finds rows and walls of a channel with known end walls.
pub(super) struct WallFinder<'a> {
    pub tracer: &'a Tracer<'a>,
    pub meridian: &'a [MeridianSample],
    /// A place between the blades.
    pub start: Place,
}

impl WallFinder<'_> {
    fn radius(&self, x: f64, share: f64) -> f64 {
        let (hub, shroud) = radii_at(self.meridian, x);
        hub + share * (shroud - hub)
    }

    /// The row at `share` of the height.
    pub fn row(&self, share: f64) -> Result<Row, BliskError> {
        let inside = self.climb(share)?;
        Ok(Row { share, front: self.edge(&inside, share, -1.0)?, back: self.edge(&inside, share, 1.0)?, inside })
    }

    /// The place at the start's x and `share` of the height, reached along the radius from the start.
    fn climb(&self, share: f64) -> Result<Place, BliskError> {
        const STEPS: usize = 12;
        let Place { x, r: r0, mut gap } = self.start;
        let r1 = self.radius(x, share);
        for i in 1..=STEPS {
            let r = r0 + (r1 - r0) * i as f64 / STEPS as f64;
            gap = self.tracer.bladed_gap(x, r, &gap).ok_or(BliskError::LostWall { x, r })?;
        }
        Ok(Place { x, r: r1, gap })
    }

    /// The last place towards -X or +X that blades bound on both sides.
    fn edge(&self, from: &Place, share: f64, toward: f64) -> Result<Place, BliskError> {
        let step = self.tracer.slices.mesh().bounds().size().x / 256.0;
        let place_at = |x: f64, near: &Gap| {
            let r = self.radius(x, share);
            self.tracer.bladed_gap(x, r, near).map(|gap| Place { x, r, gap })
        };
        let mut good = *from;
        let mut bad = loop {
            self.tracer.cancel.check()?;
            match place_at(good.x + toward * step, &good.gap) {
                Some(place) => good = place,
                None => break good.x + toward * step,
            }
        };
        while (bad - good.x).abs() > 1e-9 * step {
            let x = 0.5 * (good.x + bad);
            match place_at(x, &good.gap) {
                Some(place) => good = place,
                None => bad = x,
            }
        }
        Ok(good)
    }

    /// The place of a row at `x`, between its edges.
    pub fn place(&self, row: &Row, x: f64) -> Result<Place, BliskError> {
        self.follow(row.share, row.inside.x, x, &row.inside.gap)
    }

    /// The gaps of a row at `n` places from edge to edge, closer together towards both.
    fn gaps(&self, row: &Row, n: usize) -> Result<Vec<Place>, BliskError> {
        let (x0, x1) = (row.front.x, row.back.x);
        let x_of = |u: usize| x0 + (x1 - x0) * 0.5 * (1.0 - (PI * u as f64 / (n - 1) as f64).cos());
        let inner: Vec<f64> = (1..n - 1).map(x_of).collect();
        let middle = inner.partition_point(|&x| x < row.inside.x);
        let follow = |xs: &mut dyn Iterator<Item = f64>| {
            let mut gap = row.inside.gap;
            let mut last = row.inside.x;
            xs.map(|x| {
                self.tracer.cancel.check()?;
                let place = self.follow(row.share, last, x, &gap)?;
                (gap, last) = (place.gap, x);
                Ok(place)
            })
            .collect::<Result<Vec<_>, BliskError>>()
        };
        let mut places = vec![row.back];
        places.splice(0..0, follow(&mut inner[middle..].iter().copied())?);
        let mut front = follow(&mut inner[..middle].iter().rev().copied())?;
        front.push(row.front);
        front.reverse();
        front.extend(places);
        Ok(front)
    }

    /// The place at `to` on a row, followed from the gap at `from` in steps no longer than the part allows.
    fn follow(&self, share: f64, from: f64, to: f64, near: &Gap) -> Result<Place, BliskError> {
        let longest = self.tracer.slices.mesh().bounds().size().x / 256.0;
        let steps = ((to - from).abs() / longest).ceil().max(1.0) as usize;
        let mut place = Place { x: from, r: 0.0, gap: *near };
        for i in 1..=steps {
            let x = from + (to - from) * i as f64 / steps as f64;
            let r = self.radius(x, share);
            let gap = self.tracer.bladed_gap(x, r, &place.gap).ok_or(BliskError::LostWall { x, r })?;
            place = Place { x, r, gap };
        }
        Ok(place)
    }

    /// Both walls, low and high, with `nu` by `nv` points. Their sides are not set yet.
    pub fn walls(&self, nu: usize, nv: usize) -> Result<[ChannelWall; 2], BliskError> {
        let rows: Vec<Vec<Place>> = (0..nv)
            .into_par_iter()
            .map(|v| {
                let share = INSET + (1.0 - 2.0 * INSET) * v as f64 / (nv - 1) as f64;
                self.gaps(&self.row(share)?, nu)
            })
            .collect::<Result<_, BliskError>>()?;
        Ok([|g: &Gap| g.low, |g: &Gap| g.high].map(|end| {
            let order = || (0..nu).flat_map(|u| rows.iter().map(move |row| &row[u]));
            ChannelWall {
                nu,
                nv,
                points: order().map(|p| point(p, end(&p.gap))).collect(),
                normals: order().map(|p| self.normal(end(&p.gap))).collect(),
                side: BladeSide::Flat,
            }
        }))
    }

    /// The mesh's normal where a circle meets it. A triangle without area is met only along its neighbours'
    /// edges; there the direction around the axis stands in.
    fn normal(&self, crossing: Crossing) -> DVec3 {
        let around = DVec3::new(0.0, -crossing.theta.cos(), -crossing.theta.sin());
        let into_gap = if crossing.enters { -around } else { around };
        self.tracer.slices.normal(crossing.triangle).try_normalize().unwrap_or(into_gap)
    }
}

fn point(place: &Place, crossing: Crossing) -> DVec3 {
    Cylindrical { x: place.x, r: place.r, theta: crossing.theta }.point()
}
