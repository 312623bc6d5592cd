//! The centreline as P1 constructs it (figure 6, conditions 1 to 3): circles C_i inscribed in the blades on both sides of the
//! channel, each touching the one before, the lines L_i between the centres of equal circles, and their middles M_i.

use std::f64::consts::TAU;

use glam::{DMat3, DVec3};

use super::{Centreline, CentrelineError, Order, Section};
use crate::channel::{Channel, ChannelWall, Flow};
use crate::inscribed::CurvePair;
use crate::nurbs_wall::NurbsWall;
use task::Cancel;

/// Radius of the least circle as a share of the greatest of its section.
const LEAST: f64 = 0.01;

/// Equal circles in the two blades beside a channel, in W.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BladeCircle {
    /// Radius of both circles (mm).
    pub radius: f64,
    /// Centres of the circle in the blade at the low wall and of that in the blade at the high wall (mm): the ends of L_i.
    pub centers: [DVec3; 2],
}

impl BladeCircle {
    /// The middle of L_i (mm).
    pub fn middle(&self) -> DVec3 {
        0.5 * (self.centers[0] + self.centers[1])
    }
}

/// The circles of each section from the hub outwards, in order along the channel. All blades are alike, so that the circles
/// of one are those of the next, turned by a pitch; sections in which none fits are empty.
///
/// # Errors
/// [`CentrelineError`] if the walls cannot be joined, or when cancelled.
pub fn blade_circles(channel: &Channel, cancel: &Cancel) -> Result<Vec<Vec<BladeCircle>>, CentrelineError> {
    let to_next = DMat3::from_rotation_x(TAU / channel.blades as f64);
    let back = to_next.transpose();
    // The blade at the low wall is between the high wall of the channel before and that low wall.
    let before = ChannelWall {
        points: channel.high.points.iter().map(|p| back * *p).collect(),
        normals: channel.high.normals.iter().map(|n| back * *n).collect(),
        ..channel.high.clone()
    };
    let [under, over] = [NurbsWall::of_grid(&before)?, NurbsWall::of_grid(&channel.low)?];
    let order = if channel.flow == Flow::Axial { Order::X } else { Order::Along(channel) };
    let mut sections = Vec::new();
    for k in 0..Centreline::SECTIONS {
        cancel.check()?;
        let section = Section::new(&under, &over, (k as f64 + 0.5) / Centreline::SECTIONS as f64, order)?;
        let curves = [section.curve(0)?, section.curve(1)?];
        let chain = CurvePair::new(curves[0].clone(), curves[1].clone()).chain();
        // Where both sides meet at the tip of an edge a point passes for a circle.
        let most = chain.iter().map(|circle| circle.radius).fold(0.0, f64::max);
        let chain = chain.iter().filter(|circle| circle.radius > LEAST * most);
        let joined = |circle| {
            let found = section.in_space(circle, &curves);
            BladeCircle { radius: circle.radius, centers: [found.center, to_next * found.center] }
        };
        sections.push(chain.map(joined).collect());
    }
    Ok(sections)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixtures::exact_channel;
    use crate::parametric::ParametricBlisk;
    use geometry::frame::Cylindrical;
    use glam::DVec2;

    #[test]
    fn circles_of_the_blades_touch_both_sides_and_each_other_and_lines_join_equal_ones() {
        let blisk = ParametricBlisk::default();
        let channel = exact_channel(&blisk);
        let sections = blade_circles(&channel, &Cancel::default()).unwrap();
        assert_eq!(sections.len(), Centreline::SECTIONS);
        for circles in &sections {
            assert!(circles.len() > 5, "{}", circles.len());
            // Where the exact section at the mean radius of the centres puts a centre, both sides are a radius away.
            for circle in circles {
                let at = Cylindrical::from_point(circle.centers[0]);
                let profile = blisk.profile(at.r);
                let mean = 0.5 * (blisk.hub_radius_mm + blisk.shroud_radius_mm);
                let lean = blisk.lean_deg.to_radians().tan() * (at.r - mean);
                let center = DVec2::new(at.x - blisk.x_le(at.r), at.r * (at.theta + 0.5 * blisk.pitch()) - lean);
                let off = |y: &dyn Fn(f64) -> f64| {
                    let x = |i: u32| blisk.chord_mm * f64::from(i) / 4000.0;
                    let all = (0..=4000).map(|i| center.distance(DVec2::new(x(i), y(x(i)))));
                    all.fold(f64::INFINITY, f64::min) - circle.radius
                };
                let [upper, lower] = [off(&|x| profile.upper_y(x)), off(&|x| profile.lower_y(x))];
                assert!(upper.abs() < 0.03 && lower.abs() < 0.03, "{circle:?}: {upper} {lower}");
            }
            for pair in circles.windows(2) {
                let apart = pair[0].centers[0].distance(pair[1].centers[0]) - pair[0].radius - pair[1].radius;
                assert!(apart.abs() < 0.02, "{apart}");
            }
        }
        // L_i is a chord of a pitch; its middle is on the half angle.
        for circle in sections.iter().flatten() {
            let [a, b] = circle.centers.map(Cylindrical::from_point);
            assert!((b.theta - a.theta - blisk.pitch()).abs() < 1e-12 && a.x == b.x);
            let middle = Cylindrical::from_point(circle.middle());
            assert!((middle.theta - 0.5 * (a.theta + b.theta)).abs() < 1e-12);
            assert!((middle.r - a.r * (0.5 * blisk.pitch()).cos()).abs() < 1e-9);
        }
    }
}
