//! The ruled surface between two guide curves, R(u, v) = (1 - v) B1(u) + v B2(u), P4 (1).

use glam::{DMat2, DVec2, DVec3};
use serde::{Deserialize, Serialize};

use super::FlankError;
use super::guide::{self, GuideCurve};
use geometry::nurbs::NurbsCurve;

/// Side of a surface that the cutter stands on.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Side {
    /// The side that R_u x R_v points to (+1).
    Positive,
    /// The side opposite to R_u x R_v (-1).
    Negative,
    /// Outside of the solid, for a face of a mesh. Two guides alone do not say where the part is: they need one of the
    /// others.
    #[default]
    Automatic,
}

/// A ruled surface with a side for the cutter; u and v run from 0 to 1 and may go on past the ends. A closed one, whose
/// guides end as they start, begins again there.
#[derive(Debug, Clone, PartialEq)]
pub struct RuledSurface {
    lower: NurbsCurve,
    upper: NurbsCurve,
    /// +1 or -1.
    sign: f64,
    /// Whether u runs against the guides as they were given.
    is_reversed: bool,
    /// Whether u wraps around.
    is_closed: bool,
}

/// A place of a surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfacePlace {
    /// Along the guides.
    pub u: f64,
    /// Along the ruling, 0 on the lower guide and 1 on the upper.
    pub v: f64,
    /// Position (mm).
    pub point: DVec3,
    /// Derivative by u.
    pub along_u: DVec3,
    /// Derivative by v: the ruling.
    pub along_v: DVec3,
    /// Unit normal, towards the cutter.
    pub normal: DVec3,
}

impl RuledSurface {
    /// Places along the guides at which a new surface is looked at.
    const LOOKS: usize = 128;
    /// Most places of [`Self::places_along`].
    pub const MOST_ALONG: usize = 4000;
    /// Share of the surface's size below which guides meet.
    const MEETING: f64 = 1e-5;
    /// Share of the surface's size within which a guide ends where it starts, and share of its derivative by which this
    /// may differ there.
    const CLOSED: [f64; 2] = [1e-6, 0.01];

    /// The surface between two guides that run the same way.
    ///
    /// # Errors
    /// [`FlankError`] if the guides meet, if the surface folds over or turns too far along a ruling, or if the side is
    /// left open.
    pub fn new(lower: NurbsCurve, upper: NurbsCurve, side: Side) -> Result<Self, FlankError> {
        let mut surface = Self {
            lower: unit(lower, "lower")?,
            upper: unit(upper, "upper")?,
            sign: 1.0,
            is_reversed: false,
            is_closed: false,
        };
        surface.is_closed = surface.ends_as_it_starts();
        surface.check_apart()?;
        surface.check_folds()?;
        surface.sign = match side {
            Side::Positive => 1.0,
            Side::Negative => -1.0,
            Side::Automatic => {
                let SurfacePlace { point, normal, .. } = surface.at(0.5, 0.5);
                return Err(FlankError::SideOpen { point, normal });
            }
        };
        Ok(surface)
    }

    /// The surface between guides as they are given. Of two rows with as many points each, every ruling through a point
    /// of one goes through its fellow in the other.
    ///
    /// # Errors
    /// [`FlankError::Guide`] that says which guide is wrong, and as [`Self::new`].
    pub fn from_guides(lower: &GuideCurve, upper: &GuideCurve, side: Side) -> Result<Self, FlankError> {
        let [lower, upper] = guide::pair(lower, upper)?;
        Self::new(lower, upper, side)
    }

    /// Surface with the same side and u reversed.
    pub fn reversed(&self) -> Self {
        let (lower, upper) = (self.lower.reversed(), self.upper.reversed());
        Self { lower, upper, sign: -self.sign, is_reversed: !self.is_reversed, is_closed: self.is_closed }
    }

    /// Whether u runs against the guides as they were given.
    pub fn is_reversed(&self) -> bool {
        self.is_reversed
    }

    /// The lower guide, at v = 0.
    pub fn lower(&self) -> &NurbsCurve {
        &self.lower
    }

    /// The upper guide, at v = 1.
    pub fn upper(&self) -> &NurbsCurve {
        &self.upper
    }

    /// Whether both guides end where they start and go on from there without a corner: u is then any number, and the
    /// place at u + 1 is that at u.
    pub fn is_closed(&self) -> bool {
        self.is_closed
    }

    fn ends_as_it_starts(&self) -> bool {
        let [apart, turn] = Self::CLOSED;
        let near = apart * self.extent();
        [&self.lower, &self.upper].iter().all(|guide| {
            let ([p, d, _], [q, e, _]) = (guide.at(0.0), guide.at(1.0));
            p.distance(q) <= near && d.distance(e) <= turn * d.length()
        })
    }

    /// Both guides with their derivatives.
    fn guides(&self, u: f64) -> [[DVec3; 3]; 2] {
        let u = if self.is_closed { u - u.floor() } else { u };
        [self.lower.at(u), self.upper.at(u)]
    }

    /// The side that the cutter stands on; never [`Side::Automatic`].
    pub fn side(&self) -> Side {
        if self.sign > 0.0 { Side::Positive } else { Side::Negative }
    }

    /// The point at (`u`, `v`).
    pub fn point(&self, u: f64, v: f64) -> DVec3 {
        let [lower, upper] = self.guides(u);
        lower[0].lerp(upper[0], v)
    }

    /// Unit normal towards the cutter; zero where the surface has none.
    pub fn normal(&self, u: f64, v: f64) -> DVec3 {
        self.at(u, v).normal
    }

    /// All of a place.
    pub fn at(&self, u: f64, v: f64) -> SurfacePlace {
        let [[b1, d1, _], [b2, d2, _]] = self.guides(u);
        let (along_u, along_v) = (d1.lerp(d2, v), b2 - b1);
        let normal = self.sign * along_u.cross(along_v).normalize_or_zero();
        SurfacePlace { u, v, point: b1.lerp(b2, v), along_u, along_v, normal }
    }

    /// Diagonal of the guides' boxes (mm), a measure of its size.
    pub fn extent(&self) -> f64 {
        self.lower.extent().max(self.upper.extent()).max(self.lower.point(0.0).distance(self.upper.point(0.0)))
    }

    /// Places along u at which nothing of the surface is passed over: `even` of them from 0 to 1, and where a piece
    /// between two knots of a guide holds fewer than two of these, two more at its quarters. No more than
    /// [`Self::MOST_ALONG`] or `even`, whichever is more: of guides with more pieces some go without.
    pub fn places_along(&self, even: usize) -> Vec<f64> {
        /// Pieces shorter than this are joints that differ by rounding.
        const SHORTEST: f64 = 1e-6;
        let last = even.max(2) - 1;
        let even: Vec<f64> = (0..=last).map(|i| i as f64 / last as f64).collect();
        let mut joints = [self.lower.knots().joints(), self.upper.knots().joints()].concat();
        joints.sort_by(f64::total_cmp);
        let mut more = Vec::new();
        for [from, to] in joints.windows(2).map(|w| [w[0], w[1]]) {
            let within = even.partition_point(|u| *u < to) - even.partition_point(|u| *u < from);
            if within < 2 && to - from > SHORTEST {
                more.extend([0.25, 0.75].map(|share| from + share * (to - from)));
            }
        }
        // Left out evenly, so that pieces without a place lie among such with one.
        let room = Self::MOST_ALONG.saturating_sub(even.len());
        let kept = more.len().min(room);
        let more: Vec<f64> = (0..kept).map(|i| more[i * more.len() / kept]).collect();
        let mut all = [even, more].concat();
        all.sort_by(f64::total_cmp);
        all.dedup();
        all
    }

    /// The radius (mm) of the hollow at a place across the ruling, seen from the cutter; infinite where it bulges.
    pub fn hollow_radius(&self, u: f64, v: f64) -> f64 {
        let bend = self.bend_across(u, v);
        if bend > 0.0 { 1.0 / bend } else { f64::INFINITY }
    }

    /// Curvature (1/mm) across the ruling, positive where it is hollow for the cutter. A ruling does not bend, so this
    /// is twice the mean curvature.
    fn bend_across(&self, u: f64, v: f64) -> f64 {
        let [[b1, d1, s1], [b2, d2, s2]] = self.guides(u);
        let (ru, rv, ruu, ruv) = (d1.lerp(d2, v), b2 - b1, s1.lerp(s2, v), d2 - d1);
        let normal = self.sign * ru.cross(rv).normalize_or_zero();
        let (e, f, g) = (ru.length_squared(), ru.dot(rv), rv.length_squared());
        let (l, m) = (ruu.dot(normal), ruv.dot(normal));
        (g * l - 2.0 * f * m) / (e * g - f * f)
    }

    /// The foot of the perpendicular from `p` onto the surface gone on past its edges, near `start`; none if Newton's
    /// method does not come to rest.
    pub fn foot(&self, p: DVec3, start: DVec2) -> Option<SurfacePlace> {
        const ROUNDS: usize = 40;
        let [mut u, mut v] = start.to_array();
        for _ in 0..ROUNDS {
            let [[b1, d1, s1], [b2, d2, s2]] = self.guides(u);
            let (ru, rv, ruu, ruv) = (d1.lerp(d2, v), b2 - b1, s1.lerp(s2, v), d2 - d1);
            let off = b1.lerp(b2, v) - p;
            let slope = DVec2::new(off.dot(ru), off.dot(rv));
            let (e, f, g) = (ru.length_squared(), ru.dot(rv), rv.length_squared());
            let newton = DMat2::from_cols_array(&[e + off.dot(ruu), f + off.dot(ruv), f + off.dot(ruv), g]);
            // Away from the foot Newton's method may climb; without the bends it never does.
            let safe = DMat2::from_cols_array(&[e, f, f, g]);
            let is_rising = newton.determinant() > 0.1 * safe.determinant() && newton.x_axis.x > 0.0;
            let step = if is_rising { newton } else { safe }.inverse() * slope;
            let step = step * (0.25 / step.abs().max_element()).min(1.0);
            (u, v) = (u - step.x, v - step.y);
            if !u.is_finite() || !v.is_finite() || u.abs() > 4.0 || v.abs() > 4.0 {
                return None;
            }
            if step.abs().max_element() < 1e-14 {
                break;
            }
        }
        let place = self.at(u, v);
        let off = p - place.point;
        let near = 1e-9 * self.extent().max(off.length());
        let slant = off.dot(place.along_u) / place.along_u.length();
        let is_foot = slant.abs() < near && (off.dot(place.along_v) / place.along_v.length()).abs() < near;
        is_foot.then_some(place)
    }

    /// The place nearest to `p` with u and v from 0 to 1, from a look all over.
    pub fn nearest(&self, p: DVec3) -> SurfacePlace {
        let looks = (0..=32).flat_map(|i| (0..=4).map(move |j| DVec2::new(f64::from(i) / 32.0, f64::from(j) / 4.0)));
        let by_distance = |q: &DVec2| self.point(q.x, q.y).distance_squared(p);
        let start = looks.min_by(|a, b| by_distance(a).total_cmp(&by_distance(b))).unwrap_or_default();
        let within = |q: DVec2| {
            let q = if self.is_closed { DVec2::new(q.x - q.x.floor(), q.y) } else { q };
            q.clamp(DVec2::ZERO, DVec2::ONE)
        };
        let foot = self.foot(p, start).map_or(start, |f| within(DVec2::new(f.u, f.v)));
        // Past an edge the nearest place is that of the edge's own curve.
        let edges = [0.0, 1.0].map(|v| {
            let curve = if v < 0.5 { &self.lower } else { &self.upper };
            DVec2::new(curve.nearest_between(p, foot.x, [0.0, 1.0]).u.clamp(0.0, 1.0), v)
        });
        let ends = [0.0, 1.0].map(|u| {
            let (from, along) = (self.point(u, 0.0), self.point(u, 1.0) - self.point(u, 0.0));
            within(DVec2::new(u, (p - from).dot(along) / along.length_squared()))
        });
        let all = [start, foot, edges[0], edges[1], ends[0], ends[1]];
        let best = all.into_iter().min_by(|a, b| by_distance(a).total_cmp(&by_distance(b))).unwrap_or(start);
        self.at(best.x, best.y)
    }

    fn check_apart(&self) -> Result<(), FlankError> {
        const ROUNDS: usize = 40;
        let off = |u: f64| self.upper.nearest(self.lower.point(u)).distance;
        let look = |i: usize| i as f64 / Self::LOOKS as f64;
        let looks: Vec<f64> = (0..=Self::LOOKS).map(|i| off(look(i))).collect();
        let nearest = (0..=Self::LOOKS).min_by(|i, j| looks[*i].total_cmp(&looks[*j])).unwrap_or(0);
        // Between two looks the curves may come nearer than at either: the stretch around is divided in three.
        let (mut from, mut to) = (look(nearest.saturating_sub(1)), look((nearest + 1).min(Self::LOOKS)));
        for _ in 0..ROUNDS {
            let [a, b] = [from + (to - from) / 3.0, to - (to - from) / 3.0];
            (from, to) = if off(a) < off(b) { (from, b) } else { (a, to) };
        }
        let ends = [from, look(nearest), to];
        let lower_u = ends.into_iter().min_by(|a, b| off(*a).total_cmp(&off(*b))).unwrap_or(from);
        let near = self.upper.nearest(self.lower.point(lower_u));
        if near.distance > Self::MEETING * self.extent() {
            return Ok(());
        }
        Err(FlankError::GuidesMeet { distance_mm: near.distance, lower_u, upper_u: near.u })
    }

    fn check_folds(&self) -> Result<(), FlankError> {
        const ACROSS: usize = 16;
        let mut before: Vec<DVec3> = Vec::new();
        for i in 0..=Self::LOOKS {
            let u = i as f64 / Self::LOOKS as f64;
            let row: Vec<DVec3> = (0..=ACROSS).map(|j| self.normal(u, j as f64 / ACROSS as f64)).collect();
            let turns = |j: usize| before.get(j).is_some_and(|n| n.dot(row[j]) <= 0.0) || row[j] == DVec3::ZERO;
            let turns_along = |j: usize| j > 0 && row[j - 1].dot(row[j]) <= 0.0;
            if let Some(j) = (0..=ACROSS).find(|j| turns(*j) || turns_along(*j)) {
                return Err(FlankError::Folds { u, v: j as f64 / ACROSS as f64 });
            }
            let turn = row[0].angle_between(row[ACROSS]);
            if turn >= std::f64::consts::FRAC_PI_2 {
                return Err(FlankError::Twisted { u, turn_deg: turn.to_degrees() });
            }
            before = row;
        }
        Ok(())
    }
}

/// The curve if it runs from 0 to 1, as every guide does here.
fn unit(curve: NurbsCurve, which: &'static str) -> Result<NurbsCurve, FlankError> {
    let wrong = geometry::nurbs::NurbsError::Knots(0);
    if curve.domain() == [0.0, 1.0] { Ok(curve) } else { Err(FlankError::Guide { which, reason: wrong }) }
}
