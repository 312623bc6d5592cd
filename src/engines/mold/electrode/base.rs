//! Bases: what tips stand on and a holder takes.

use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

use glam::{DVec2, DVec3};

use super::check::{WELD, in_file};
use super::params::{Blanks, ElectrodeParams, Holder};
use geometry::groups::Groups;
use geometry::mesh::{Bounds, Mesh};
use geometry::solid;
use geometry::solid::{SolidError, Trimmer};
use task::Cancel;

/// How far tips are led into the base (mm), so that the two solids overlap.
pub(super) const INTO_BASE: f64 = 0.25;

/// How far the sides of a round base's outline lie within its circle at most (mm).
const SAGITTA: f64 = 0.005;

/// A base: a block or a cylinder whose underside is at height 0, its middle at the origin.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Base {
    /// Sides (mm); the diameter twice if it is round.
    pub sides: DVec2,
    /// Whether it is round.
    pub is_round: bool,
    /// Height (mm).
    pub height: f64,
    /// Orientation chamfer: of a block the corner at +X +Y is cut off (mm along each side), a round base has a flat as
    /// deep at +X.
    pub corner: f64,
}

impl Base {
    /// The base under tips with this box, centred on them, and the length of the blank that both are made from (mm). It
    /// is round where there is a round blank of less volume than the rectangular one.
    pub fn under(tips: &Bounds, params: &ElectrodeParams) -> (Self, f64) {
        let size = tips.size();
        let side = |length: f64| params.blanks.side(length + 2.0 * params.base_margin_mm);
        let sides = DVec2::new(side(size.x), side(size.y));
        let length = params.blanks.rounded_up(size.z + params.base_height_mm);
        let round = params.blanks.diameter(size.truncate().length() + 2.0 * params.base_margin_mm);
        let round = round.filter(|d| PI / 4.0 * d * d < sides.x * sides.y);
        let base = Self {
            sides: round.map_or(sides, DVec2::splat),
            is_round: round.is_some(),
            height: length - size.z,
            corner: params.datum_corner_mm,
        };
        (base, length)
    }

    /// The first of the holders that takes it: its place in the list.
    pub fn holder(&self, params: &ElectrodeParams) -> Option<usize> {
        params.holders.iter().position(|holder| self.fits(holder))
    }

    /// Whether a holder takes it.
    pub fn fits(&self, holder: &Holder) -> bool {
        let [x, y] = holder.size_mm;
        self.sides.min_element() <= x.min(y) && self.sides.max_element() <= x.max(y)
    }

    /// Outline.
    pub fn outline(&self) -> Vec<DVec2> {
        if self.is_round {
            return self.circle();
        }
        let DVec2 { x, y } = self.sides / 2.0;
        let corners = [(-x, -y), (x, -y), (x, y - self.corner), (x - self.corner, y), (-x, y)];
        let mut outline: Vec<DVec2> = corners.into_iter().map(DVec2::from).collect();
        outline.dedup();
        outline
    }

    /// The outline of a round one, from the flat's end all around to its beginning.
    fn circle(&self) -> Vec<DVec2> {
        let radius = 0.5 * self.sides.x;
        let flat = (1.0 - self.corner / radius).clamp(0.0, 1.0).acos();
        let step = 2.0 * (1.0 - SAGITTA / radius.max(2.0 * SAGITTA)).acos();
        let count = ((2.0 * PI - 2.0 * flat) / step).ceil().max(8.0);
        // Without a flat the last point would be the first one again.
        let points = if flat > 0.0 { count as usize + 1 } else { count as usize };
        let at = |i: usize| DVec2::from_angle(flat + (2.0 * PI - 2.0 * flat) * i as f64 / count) * radius;
        (0..points).map(at).collect()
    }

    /// The base with tips that reach from below into it. What tips touch themselves or each other along is taken away, a
    /// little around it: a file holds no such edges.
    ///
    /// # Errors
    /// [`SolidError`].
    pub fn with_tips(&self, tips: &[Mesh]) -> Result<Mesh, SolidError> {
        /// How far around an edge metal is taken away (mm).
        const AROUND: f64 = 2e-3;
        let mut body = solid::prism(&[&self.outline()], 0.0, self.height)?;
        for tip in tips {
            body = solid::union(&body, tip)?;
        }
        let body = without_specks(solid::without_slivers(body));
        let touching = solid::touching_edges(&in_file(&body), WELD);
        if touching.is_empty() {
            return Ok(body);
        }
        let around = |p: DVec3| DVec3::AXES.into_iter().flat_map(move |axis| [p - AROUND * axis, p + AROUND * axis]);
        let rods: Vec<Vec<DVec3>> =
            touching.into_iter().map(|ends| ends.into_iter().flat_map(around).collect()).collect();
        Trimmer::new(&solid::union_of_hulls(&rods, &Cancel::default())?)?.trim(&body)
    }
}

/// A closed surface without those of its bodies that are no larger than what a file tells apart: between faces that lie in
/// one another but for rounding, trimming leaves such.
fn without_specks(mut mesh: Mesh) -> Mesh {
    /// Size of a body that is none (mm).
    const SPECK: f64 = 5e-4;
    let (body_of, count) = Groups::of_vertices(&mesh).numbers();
    let mut bodies = vec![Vec::new(); count];
    mesh.vertices.iter().zip(&body_of).for_each(|(p, body)| bodies[*body as usize].push(*p));
    let is_speck: Vec<bool> = bodies.into_iter().map(|all| Bounds::of(all).size().max_element() < SPECK).collect();
    mesh.triangles.retain(|[a, ..]| !is_speck[body_of[*a as usize] as usize]);
    mesh.compacted()
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

/// The diameter of the least round blank that an electrode can be made from (mm), if there is one.
pub fn round_blank(base: &Base, blanks: &Blanks) -> Option<f64> {
    if base.is_round { Some(base.sides.x) } else { blanks.diameter(base.sides.length()) }
}

/// A mesh turned about Z and moved.
pub fn placed(mesh: &Mesh, turn: f64, shift: DVec3) -> Mesh {
    let turned = DVec2::from_angle(turn);
    mesh.mapped(|p| turned.rotate(p.truncate()).extend(p.z) + shift)
}

#[cfg(test)]
mod tests {
    use super::super::check::watertight;
    use super::super::tip::joined;
    use super::*;

    fn under(size: DVec3, diameters_mm: &[f64]) -> (Base, f64) {
        let blanks = Blanks { diameters_mm: diameters_mm.to_vec(), ..Blanks::default() };
        let params = ElectrodeParams { blanks, ..ElectrodeParams::default() };
        Base::under(&Bounds { min: -size / 2.0, max: size / 2.0 }, &params)
    }

    #[test]
    fn a_round_blank_is_taken_where_it_is_the_smaller_one_and_holds_tips_and_margin() {
        // 8 by 6 and 2 on each side: 12 by 10 as a block, 14 across as a cylinder, pi / 4 * 14^2 = 153.9 of 120.
        let tips = DVec3::new(8.0, 6.0, 10.0);
        assert!(!under(tips, &[]).0.is_round && !under(tips, &[14.0]).0.is_round);
        // A long tip needs little more than its length, but as little width.
        let tips = DVec3::new(8.1, 1.0, 10.0);
        let (base, length) = under(tips, &[8.0, 12.0, 12.3]);
        assert!(!base.is_round && base.sides == DVec2::new(15.0, 5.0), "a block of 75 is smaller: {base:?}");
        let tips = DVec3::new(6.1, 6.1, 10.0);
        let (base, round_length) = under(tips, &[8.0, 12.0, 12.7, 20.0]);
        // 10.1 needs sides of 12, 144 in all; across 6.1 * sqrt 2 + 4 = 12.63, 126.7.
        assert!(base.is_round && base.sides == DVec2::splat(12.7) && round_length == length, "{base:?}");
        let reach = tips.truncate() / 2.0;
        assert!(reach.length() + ElectrodeParams::default().base_margin_mm <= 0.5 * base.sides.x);
    }

    /// A tetrahedron of some 20 nanometres beside a tip, whose corners fall together in a file.
    #[test]
    fn bodies_that_no_file_tells_apart_are_left_out() {
        let speck = solid::hull(&[DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z]);
        let speck = speck.mapped(|p| DVec3::new(0.354, 0.107, -4.0) + p * DVec3::new(2e-5, 3e-5, 1e-8));
        let pin = Mesh::cuboid(DVec3::new(2.0, 2.0, 5.0)).mapped(|p| p + DVec3::Z * (INTO_BASE - 5.0));
        let both = joined(pin.clone(), speck);
        assert!(!watertight(&both).holds);
        assert_eq!(without_specks(both), pin.compacted());
    }

    /// Two square pins that stand corner to corner: no file tells whether they are one body.
    #[test]
    fn tips_that_touch_along_an_edge_make_a_closed_electrode() {
        let base = Base { sides: DVec2::splat(16.0), is_round: false, height: 12.0, corner: 1.0 };
        let pin = |at: DVec2| Mesh::cuboid(DVec3::new(2.0, 2.0, 5.0)).mapped(|p| p + at.extend(INTO_BASE - 5.0));
        let mesh = base.with_tips(&[pin(DVec2::ZERO), pin(DVec2::splat(-2.0))]).unwrap();
        let finding = watertight(&mesh);
        assert!(finding.holds, "{}", finding.text);
        let whole = 12.0 * (16.0 * 16.0 - 0.5) + 2.0 * 4.0 * (5.0 - INTO_BASE);
        assert!((-1e-3..0.0).contains(&(mesh.volume() - whole)), "{} of {whole}", mesh.volume());
    }

    #[test]
    fn a_round_base_is_closed_and_has_the_volume_of_a_cylinder_with_a_flat() {
        for corner in [0.0, 1.0] {
            let base = Base { sides: DVec2::splat(16.0), is_round: true, height: 12.0, corner };
            let tip = Mesh::cuboid(DVec3::new(2.0, 3.0, 5.0)).mapped(|p| p - DVec3::new(1.0, 1.5, 5.0 - INTO_BASE));
            let mesh = base.with_tips(std::slice::from_ref(&tip)).unwrap();
            assert!(mesh.is_watertight());
            let flat = 8.0 - corner;
            let segment = 64.0 * (flat / 8.0).acos() - flat * (64.0 - flat * flat).sqrt();
            let expected = 12.0 * (64.0 * PI - segment) + 6.0 * (5.0 - INTO_BASE);
            assert!((mesh.volume() / expected - 1.0).abs() < 1e-3, "{corner}: {} {expected}", mesh.volume());
            let bounds = mesh.bounds();
            assert!((bounds.max.x - flat).abs() < 0.01 && (bounds.min.x + 8.0).abs() < 0.01, "{bounds:?}");
        }
    }
}
