//! A wheel made from measured sections of its blades, for parts of which there is no mesh: blades skinned over the
//! sections as P1 does it, between two rings.

use files::Invalid;
use glam::{DMat3, DVec2, DVec3};
use serde::{Deserialize, Serialize};

use crate::nurbs_wall::{MeasuredError, NurbsWall};
use crate::parametric::welder::Welder;
use crate::parametric::wheel::{outwards, together, turned};
use crate::sections::MeasuredSection;
use geometry::frame::{Cylindrical, angle_near};
use geometry::mesh::Mesh;
use task::Cancel;

/// What measured sections do not tell of a wheel: blades and rings.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct BladeRing {
    /// Number of blades.
    pub blades: usize,
    /// X of the two faces, that at -X first (mm).
    pub faces_x_mm: [f64; 2],
    /// Radius of the hub at each face (mm).
    pub hub_radius_mm: [f64; 2],
    /// Radius of the shroud at each face (mm).
    pub shroud_radius_mm: [f64; 2],
    /// Radius of the bore (mm).
    pub bore_radius_mm: f64,
    /// Radius of the outside of the shroud's ring (mm).
    pub outer_radius_mm: f64,
}

impl Default for BladeRing {
    fn default() -> Self {
        Self {
            blades: 60,
            faces_x_mm: [-3.0, 23.0],
            hub_radius_mm: [110.0; 2],
            shroud_radius_mm: [125.0; 2],
            bore_radius_mm: 60.0,
            outer_radius_mm: 130.0,
        }
    }
}

/// Reason why there is no wheel.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum BladeRingError {
    /// A value is out of its range, or does not go with another.
    #[error(transparent)]
    Params(#[from] Invalid),
    /// There are no walls through the sections.
    #[error(transparent)]
    Sections(#[from] MeasuredError),
    /// The sections do not reach a ring.
    #[error(
        "the sections end {missing:.2} mm from the {ring} at x = {x:.2} mm, which is more than {most:.2} mm, a fifth of the \
         passage: measure a section nearer to it, or correct its radius"
    )]
    Short {
        /// Name of the ring.
        ring: &'static str,
        /// How far the sections end from it (mm).
        missing: f64,
        /// Place along the axis (mm).
        x: f64,
        /// How far they may end from it (mm).
        most: f64,
    },
    /// The blades reach past a face.
    #[error("the blades reach to x = {x:.2} mm, beyond the faces of the wheel: correct faces_x_mm")]
    BeyondFace {
        /// Place along the axis (mm).
        x: f64,
    },
    /// The blades reach through a ring.
    #[error(
        "the blades reach to r = {:.2} mm at x = {:.2} mm, through the ring: correct bore_radius_mm and outer_radius_mm",
        place.y, place.x
    )]
    BeyondRing {
        /// Place (x, r) (mm).
        place: DVec2,
    },
    /// Blades at the walls' distance have no thickness.
    #[error(
        "with {blades} blades the low wall of a channel is {overlap:.3} mm beyond the high wall of the channel before at \
         x = {:.2}, r = {:.2} mm, so that the blade between them has no thickness there: correct the number of blades, or \
         exchange low and high in the table; where the blade ends, up to {} mm are taken for errors of measurement",
        place.x, place.y, EDGE_ERROR
    )]
    NoThickness {
        /// Number of blades given.
        blades: usize,
        /// Place (x, r) (mm).
        place: DVec2,
        /// How far the sides overlap along the circumference (mm).
        overlap: f64,
    },
}

/// How deep blades reach into the rings (mm).
const INTO: f64 = 0.5;
/// Points of a blade's side along the chord, and rows from hub to shroud.
const GRID: [usize; 2] = [121, 17];
/// Facets of a ring around the axis, at least.
const FACETS: usize = 720;
/// Rounds in which a blade is led on into a ring that widens.
const ROUNDS: usize = 4;
/// Overlap of the sides of a blade at its edges (mm) that is taken for errors of measurement: both sides meet there, and
/// of measured points each has its own error.
const EDGE_ERROR: f64 = 0.1;
/// Share of a side's points at each of its ends that counts as edge.
const EDGE: f64 = 0.2;
/// Least thickness of a blade where its sides overlap (mm): less would make the facets of both sides one.
const LEAST: f64 = 1e-3;
/// Share of the passage's height by which sections may end short of a ring: the blade goes straight on there.
const STRAIGHT_ON: f64 = 0.2;

impl BladeRing {
    /// Whether every value is within its range.
    ///
    /// # Errors
    /// [`Invalid`] with the key.
    pub fn validate(&self) -> Result<(), Invalid> {
        let [front, back] = self.faces_x_mm;
        let least = |of: [f64; 2]| of[0].min(of[1]);
        let most = |of: [f64; 2]| of[0].max(of[1]);
        [
            ("blades", self.blades as f64, [3.0, 1000.0]),
            ("faces_x_mm[0]", front, [-1e4, 1e4]),
            ("faces_x_mm[1]", back, [front + 1.0, 1e4]),
            ("bore_radius_mm", self.bore_radius_mm, [0.5, least(self.hub_radius_mm) - 2.0 * INTO]),
            ("hub_radius_mm", most(self.hub_radius_mm), [1.0, least(self.shroud_radius_mm) - 0.5]),
            ("outer_radius_mm", self.outer_radius_mm, [most(self.shroud_radius_mm) + 2.0 * INTO, 1e4]),
        ]
        .into_iter()
        .try_for_each(|(key, value, range)| Invalid::unless_within(key, value, range, ""))
    }

    /// Radii of hub and shroud at `x` (mm).
    fn radii(&self, x: f64) -> [f64; 2] {
        let [front, back] = self.faces_x_mm;
        let share = ((x - front) / (back - front)).clamp(0.0, 1.0);
        [self.hub_radius_mm, self.shroud_radius_mm].map(|[a, b]| a + share * (b - a))
    }

    /// The wheel about X, in W of the sections: one closed shell for each blade and each ring, which reach into each other.
    ///
    /// # Errors
    /// [`BladeRingError`].
    pub fn mesh(&self, sections: &[MeasuredSection], cancel: &Cancel) -> Result<Mesh, BladeRingError> {
        self.validate()?;
        let walls = NurbsWall::of_measured(sections, cancel)?;
        let pitch = std::f64::consts::TAU / self.blades as f64;
        let back = DMat3::from_rotation_x(-pitch);
        // The upper side of blade 0 is the low wall of channel 0, its lower side the high wall turned back.
        let [mut upper, mut lower] = [self.rows(&walls[0], &|p| p)?, self.rows(&walls[1], &|p| back * p)?];
        for (upper, lower) in upper.iter_mut().zip(&mut lower) {
            for (i, (a, b)) in upper.iter_mut().zip(lower).enumerate() {
                let at = Cylindrical::from_point(*a);
                if !(self.faces_x_mm[0]..=self.faces_x_mm[1]).contains(&at.x) {
                    return Err(BladeRingError::BeyondFace { x: at.x });
                }
                if !(self.bore_radius_mm..=self.outer_radius_mm).contains(&at.r) {
                    return Err(BladeRingError::BeyondRing { place: DVec2::new(at.x, at.r) });
                }
                let share = i as f64 / (GRID[0] - 1) as f64;
                let most = if (EDGE..=1.0 - EDGE).contains(&share) { 0.0 } else { EDGE_ERROR };
                self.part([a, b], most)?;
            }
        }
        let blade = blade(&upper, &lower);
        let turn = |k: usize| DMat3::from_rotation_x(pitch * k as f64);
        let blades = (0..self.blades).map(|k| blade.mapped(|p| turn(k) * p));
        let around = self.blades * FACETS.div_ceil(self.blades);
        let [front_x, back_x] = self.faces_x_mm;
        let ring = |of: [f64; 2], other: f64| {
            let outline = [(front_x, of[0]), (back_x, of[1]), (back_x, other), (front_x, other)].map(DVec2::from);
            turned(&outline, around, around, 1)
        };
        let rings = [ring(self.hub_radius_mm, self.bore_radius_mm), ring(self.shroud_radius_mm, self.outer_radius_mm)];
        Ok(together(rings.into_iter().chain(blades)))
    }

    /// Moves two points that face each other on the upper and on the lower side of a blade apart where the sides overlap by
    /// no more than `most` (mm).
    fn part(&self, [upper, lower]: [&mut DVec3; 2], most: f64) -> Result<(), BladeRingError> {
        /// Overlap that is none (mm): the error of rounding where the sides meet.
        const NOTHING: f64 = 1e-4;
        let [a, b] = [*upper, *lower].map(Cylindrical::from_point);
        let overlap = a.r * (angle_near(b.theta, a.theta) - a.theta);
        if overlap > most.max(NOTHING) {
            return Err(BladeRingError::NoThickness { blades: self.blades, place: DVec2::new(a.x, a.r), overlap });
        }
        if overlap > NOTHING {
            let half = 0.5 * (overlap + LEAST) / a.r;
            *upper = DMat3::from_rotation_x(half) * *upper;
            *lower = DMat3::from_rotation_x(-half) * *lower;
        }
        Ok(())
    }

    /// Rows of a side of a blade from within the hub's ring to within the shroud's, each from edge to edge.
    fn rows(&self, wall: &NurbsWall, place: &dyn Fn(DVec3) -> DVec3) -> Result<Vec<Vec<DVec3>>, BladeRingError> {
        let share = |i: usize, n: usize| i as f64 / (n - 1) as f64;
        // Close together where edges are round.
        let along = |i: usize| 0.5 - 0.5 * (std::f64::consts::PI * share(i, GRID[0])).cos();
        let row = |v: f64| (0..GRID[0]).map(|i| place(wall.surface.point(along(i), v))).collect::<Vec<_>>();
        let mut rows: Vec<Vec<DVec3>> = (0..GRID[1]).map(|j| row(share(j, GRID[1]))).collect();
        let on = |ring: usize, rows: &[Vec<DVec3>]| {
            let (end, before) =
                if ring == 0 { (&rows[0], &rows[1]) } else { (&rows[rows.len() - 1], &rows[rows.len() - 2]) };
            end.iter().zip(before).map(|(p, q)| self.led_on([*q, *p], ring)).collect::<Result<Vec<_>, _>>()
        };
        let [first, last] = [on(0, &rows)?, on(1, &rows)?];
        rows.insert(0, first);
        rows.push(last);
        Ok(rows)
    }

    /// The end of a line through two points, straight on into a ring: 0 the hub's, 1 the shroud's.
    fn led_on(&self, [from, end]: [DVec3; 2], ring: usize) -> Result<DVec3, BladeRingError> {
        let radius = |p: DVec3| p.y.hypot(p.z);
        let radii = self.radii(end.x);
        let out = if ring == 0 { -1.0 } else { 1.0 };
        let missing = out * (radii[ring] - radius(end));
        let most = STRAIGHT_ON * (radii[1] - radii[0]);
        if missing > most {
            let ring = ["hub", "shroud"][ring];
            return Err(BladeRingError::Short { ring, missing, x: end.x, most });
        }
        let rise = out * (radius(end) - radius(from));
        // A line that hardly climbs goes on along the radius.
        let way = if rise > 0.1 * end.distance(from) {
            (end - from) / rise
        } else {
            out * end.with_x(0.0).normalize_or_zero()
        };
        // A ring may be wider where a slanted blade meets it.
        let mut by = missing + INTO;
        for _ in 0..ROUNDS {
            let at = end + way * by.max(0.0);
            by += out * (self.radii(at.x)[ring] - radius(at)) + INTO;
        }
        Ok(end + way * by.max(0.0))
    }
}

/// The closed shell between the two sides of a blade.
fn blade(upper: &[Vec<DVec3>], lower: &[Vec<DVec3>]) -> Mesh {
    let (rows, along) = (upper.len(), upper[0].len());
    let mut welder = Welder::default();
    for (j, i) in (0..rows - 1).flat_map(|j| (0..along - 1).map(move |i| (j, i))) {
        welder.quad([upper[j][i], upper[j][i + 1], upper[j + 1][i + 1], upper[j + 1][i]]);
        welder.quad([lower[j][i], lower[j + 1][i], lower[j + 1][i + 1], lower[j][i + 1]]);
    }
    for j in 0..rows - 1 {
        welder.quad([lower[j][0], upper[j][0], upper[j + 1][0], lower[j + 1][0]]);
        let i = along - 1;
        welder.quad([upper[j][i], lower[j][i], lower[j + 1][i], upper[j + 1][i]]);
    }
    for i in 0..along - 1 {
        welder.quad([lower[0][i], lower[0][i + 1], upper[0][i + 1], upper[0][i]]);
        let j = rows - 1;
        welder.quad([upper[j][i], upper[j][i + 1], lower[j][i + 1], lower[j][i]]);
    }
    outwards(welder.mesh)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::find_channel::find_channel;
    use crate::options::BliskOptions;
    use crate::parametric::{ChannelSide, ParametricBlisk};
    use crate::section_deviation::SectionsDeviation;
    use geometry::nurbs::LineShape;
    use task::Task;

    /// Sections of the exact blades at shares of the height.
    fn sections(blisk: &ParametricBlisk, heights: &[f64]) -> Vec<MeasuredSection> {
        let along = |i: usize| 0.5 - 0.5 * (i as f64 / 120.0 * std::f64::consts::PI).cos();
        let wall = |side, height| (0..=120).map(|i| blisk.wall_at(side, along(i), height)[0]).collect();
        let of = |height: &f64| MeasuredSection {
            name: format!("{height}"),
            low: wall(ChannelSide::Low, *height),
            high: wall(ChannelSide::High, *height),
            ..MeasuredSection::default()
        };
        heights.iter().map(of).collect()
    }

    fn ring(blisk: &ParametricBlisk) -> BladeRing {
        let faces = blisk.faces_x();
        BladeRing {
            blades: blisk.blades,
            faces_x_mm: faces,
            hub_radius_mm: faces.map(|x| blisk.radii(x).0),
            shroud_radius_mm: faces.map(|x| blisk.radii(x).1),
            bore_radius_mm: blisk.bore_radius_mm,
            outer_radius_mm: blisk.outer_radius(),
        }
    }

    const HEIGHTS: [f64; 7] = [0.05, 0.2, 0.35, 0.5, 0.65, 0.8, 0.95];

    #[test]
    fn the_channel_of_a_wheel_from_sections_is_that_of_the_wheel_they_were_taken_from() {
        let blisk = ParametricBlisk { blades: 24, ..ParametricBlisk::turbine() };
        // Turned by half a turn the walls stand where angles jump.
        let turned: Vec<MeasuredSection> = sections(&blisk, &HEIGHTS)
            .into_iter()
            .map(|section| {
                let about = |points: Vec<DVec3>| points.iter().map(|p| DVec3::new(p.x, -p.y, -p.z)).collect();
                MeasuredSection { low: about(section.low), high: about(section.high), ..section }
            })
            .collect();
        assert!(ring(&blisk).mesh(&turned, &Cancel::default()).is_ok());
        let mesh = ring(&blisk).mesh(&sections(&blisk, &HEIGHTS), &Cancel::default()).unwrap();
        assert!(mesh.is_watertight());
        let options = BliskOptions::default();
        let found = find_channel(&mesh, &options, &Task::default()).unwrap();
        assert_eq!((found.blades, found.shrouded), (24, true));
        // Both frames have X along the axis; channel 0 lies on +Z in W.
        for (side, wall) in [(ChannelSide::Low, &found.low), (ChannelSide::High, &found.high)] {
            for p in &wall.points {
                let p = found.frame.to_parent(*p);
                let at = Cylindrical::from_point(p);
                if at.x < blisk.x_le(at.r) + 0.3 || at.x > blisk.x_te(at.r) - 0.3 {
                    continue;
                }
                let pitch = blisk.pitch();
                let off = (at.theta - blisk.wall_theta(side, at.x, at.r)) / pitch;
                let off = (off - off.round()) * pitch * at.r;
                assert!(off.abs() < 0.01, "{side:?} {p}: {off}");
            }
        }
    }

    /// Of few points a parabola through the last three tells little of how a wall ends.
    #[test]
    fn given_end_tangents_bring_the_walls_of_few_points_nearer_to_the_blade() {
        let blisk = ParametricBlisk { blades: 24, ..ParametricBlisk::turbine() };
        let place = |side, share: f64, height| blisk.wall_at(side, share, height)[0];
        // From 0.05 to 0.95 of the chord, off the round edges.
        let share = |i: usize| 0.05 + 0.9 * i as f64 / 5.0;
        let of = |height: &f64, is_given: bool| {
            let points = |side| (0..6).map(|i| place(side, share(i), *height)).collect();
            let tangent = |side, at: f64| place(side, at + 1e-6, *height) - place(side, at - 1e-6, *height);
            let ends = |side| [0, 5].map(|i| is_given.then(|| tangent(side, share(i))));
            let sides = [ChannelSide::Low, ChannelSide::High];
            MeasuredSection {
                name: format!("{height}"),
                low: points(sides[0]),
                high: points(sides[1]),
                shapes: sides.map(|side| LineShape { weights: Vec::new(), ends: ends(side) }),
            }
        };
        let worst = |is_given: bool| {
            let sections: Vec<MeasuredSection> = HEIGHTS.iter().map(|height| of(height, is_given)).collect();
            let walls = NurbsWall::of_measured(&sections, &Cancel::default()).unwrap();
            let sides = [ChannelSide::Low, ChannelSide::High].into_iter().zip(&walls);
            let off = sides.flat_map(|(side, wall)| {
                let blisk = &blisk;
                let v = wall.v[3];
                (0..=50).map(move |i| {
                    let p = Cylindrical::from_point(wall.surface.point(f64::from(i) / 50.0, v));
                    (angle_near(p.theta, 0.0) - blisk.wall_theta(side, p.x, p.r)).abs() * p.r
                })
            });
            off.fold(0.0, f64::max)
        };
        let (found, given) = (worst(false), worst(true));
        assert!(given < 0.5 * found, "{given} mm with, {found} mm without");
    }

    /// A number from -1 to 1, another for each key.
    fn noise(key: usize) -> f64 {
        2.0 * (key as f64 * 0.618_033_988_749_894_9).fract() - 1.0
    }

    /// Sections as a coordinate measuring machine has them: each point off in every direction by up to `most` (mm).
    fn measured(blisk: &ParametricBlisk, heights: &[f64], most: f64) -> Vec<MeasuredSection> {
        let mut sections = sections(blisk, heights);
        for (k, section) in sections.iter_mut().enumerate() {
            for (side, points) in [&mut section.low, &mut section.high].into_iter().enumerate() {
                // A probe does not go in steps of micrometres.
                *points = points.iter().copied().step_by(2).collect();
                for (i, p) in points.iter_mut().enumerate() {
                    let key = 3 * (1000 * (2 * k + side) + i);
                    *p += most * DVec3::new(noise(key), noise(key + 1), noise(key + 2));
                }
            }
        }
        sections
    }

    #[test]
    fn sections_with_the_noise_of_a_measurement_make_the_wheel_and_their_known_error_is_found() {
        let blisk = ParametricBlisk { blades: 24, ..ParametricBlisk::turbine() };
        for most in [0.003, 0.01, 0.02] {
            let mut table = measured(&blisk, &HEIGHTS, most);
            // A section that is too thin at the high wall: its points are moved into the blade.
            let along = |i: usize| 0.5 - 0.5 * (i as f64 / 60.0 * std::f64::consts::PI).cos();
            for (i, p) in table[3].high.iter_mut().enumerate() {
                *p -= 0.08 * blisk.wall_at(ChannelSide::High, along(i), HEIGHTS[3])[1];
            }
            let mesh = ring(&blisk).mesh(&table, &Cancel::default()).unwrap();
            assert!(mesh.is_watertight(), "{most}");
            let channel = find_channel(&mesh, &BliskOptions::default(), &Task::default()).unwrap();
            assert_eq!(channel.blades, 24);
            let walls = NurbsWall::of_channel(&channel).unwrap();
            let in_w = |points: &[DVec3]| points.iter().map(|p| channel.frame.from_parent(*p)).collect();
            let in_w: Vec<MeasuredSection> =
                table.iter().map(|s| MeasuredSection { low: in_w(&s.low), high: in_w(&s.high), ..s.clone() }).collect();
            // The walls that are planned for go through the points, whatever these are.
            let planned = SectionsDeviation::new(&in_w, &walls, 0.03, &Cancel::default()).unwrap();
            assert!(planned.holds(), "{most}: {planned}");
            let others = SectionsDeviation::of_each(&table, 0.03, &Cancel::default()).unwrap();
            let side = &others.sections.iter().find(|s| s.name == table[3].name).unwrap().sides[1];
            assert!((side.mean_mm + 0.08).abs() < 0.006, "{most}: {others}");
            assert!(!others.holds() && others.greatest().unwrap().0 == table[3].name, "{most}: {others}");
        }
    }

    #[test]
    fn the_same_sections_without_an_error_are_within_the_limit() {
        let blisk = ParametricBlisk { blades: 24, ..ParametricBlisk::turbine() };
        for most in [0.0, 0.003] {
            let others =
                SectionsDeviation::of_each(&measured(&blisk, &HEIGHTS, most), 0.03, &Cancel::default()).unwrap();
            assert!(others.holds() && others.sections.len() == HEIGHTS.len() - 2, "{most}: {others}");
        }
    }

    #[test]
    fn what_does_not_go_together_is_said() {
        let blisk = ParametricBlisk { blades: 24, ..ParametricBlisk::turbine() };
        let own = ring(&blisk);
        let said = |ring: BladeRing, heights: &[f64]| {
            ring.mesh(&sections(&blisk, heights), &Cancel::default()).unwrap_err().to_string()
        };
        let short = said(own, &[0.4, 0.6, 0.95]);
        assert!(short.contains("from the hub") && short.contains("measure a section nearer"), "{short}");
        let thick = said(BladeRing { blades: 60, ..own }, &HEIGHTS);
        assert!(thick.contains("no thickness") && thick.contains("number of blades"), "{thick}");
        let faces = said(BladeRing { faces_x_mm: [own.faces_x_mm[0], 5.0], ..own }, &HEIGHTS);
        assert!(faces.contains("beyond the faces"), "{faces}");
        let bore = said(BladeRing { bore_radius_mm: 500.0, ..own }, &HEIGHTS);
        assert!(bore.starts_with("bore_radius_mm"), "{bore}");
    }
}
