//! Molds whose residue by a ball is known in closed form.

use std::f64::consts::PI;

use glam::{DVec2, DVec3};

use super::ball::BallReach;
use crate::fixtures::{self, rectangle};
use geometry::mesh::Mesh;
use task::{Cancel, Cancelled};

fn over(mesh: &Mesh, radius: f64) -> BallReach {
    BallReach::new(mesh, radius, &Cancel::default()).unwrap()
}

/// A block of 20 x 20 x 10 mm with its top at 0 and a pocket of 8 x 6 x 4 mm.
fn pocket() -> Mesh {
    let hole = rectangle(8.0, 6.0);
    fixtures::pocket(&rectangle(20.0, 20.0), &hole, &hole, [10.0, 4.0]).mapped(|p| p - 10.0 * DVec3::Z)
}

#[test]
fn over_a_floor_the_ball_leaves_a_fillet_along_the_wall() {
    let ball = over(&pocket(), 1.0);
    for k in 0..=40 {
        let off_wall = 0.05 * f64::from(k);
        let left = ball.lowest(DVec2::new(4.0 - off_wall, 0.3)).height;
        let u = (1.0 - off_wall).max(0.0);
        let exact = -4.0 + 1.0 - (1.0 - u * u).sqrt();
        assert!((left - exact).abs() < 1e-5, "{off_wall}: {left} {exact}");
    }
    // On the land around the pocket nothing is left, and in a corner that the ball does not see all up to where it
    // rests.
    assert!(ball.lowest(DVec2::new(6.0, 5.0)).height.abs() < 1e-9);
    assert!(ball.lowest(DVec2::new(3.95, 2.95)).height > -0.1);
}

#[test]
fn a_pocket_keeps_fillets_and_corners() {
    let ball = over(&pocket(), 1.0);
    // A quarter of the pocket by the midpoint rule.
    let step = 0.1;
    let places = (0..30).flat_map(|y| (0..40).map(move |x| DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5) * step));
    let volume: f64 = places.map(|p| 4.0 * (ball.lowest(p).height + 4.0) * step * step).sum();
    let fillet = 1.0 - PI / 4.0;
    let exact = fillet * (2.0 * (6.0 + 4.0) + 4.0 * 3.0) + 4.0 * (1.0 - PI / 6.0);
    assert!((volume / exact - 1.0).abs() < 0.03, "{volume} {exact}");
}

/// A groove of half angle `angle`: what a ball leaves in it is R^2 (cot a - (pi/2 - a)) for each mm.
#[test]
fn a_ball_in_a_groove_leaves_what_lies_below_it() {
    for angle_deg in [30.0, 45.0, 60.0] {
        let angle = f64::to_radians(angle_deg);
        let (depth, radius) = (4.0, 1.0);
        let half = depth * angle.tan();
        let profile = [[-9.0, -6.0], [9.0, -6.0], [9.0, 0.0], [half, 0.0], [0.0, -depth], [-half, 0.0], [-9.0, 0.0]];
        let n = profile.len() as u32;
        let ends = [0.0, 10.0].map(|y| profile.map(|[x, z]| DVec3::new(x, y, z)));
        let mut triangles = Vec::new();
        for i in 0..n {
            let j = (i + 1) % n;
            triangles.extend([[i, j + n, j], [i, i + n, j + n]]);
        }
        let mesh = Mesh { vertices: ends.concat(), triangles };
        let ball = over(&mesh, radius);
        // Across the middle of the groove, where its ends are far.
        let (steps, width) = (600, radius * angle.cos());
        let step = 2.0 * width / f64::from(steps);
        let area: f64 = (0..steps)
            .map(|k| {
                let x = -width + (f64::from(k) + 0.5) * step;
                let floor = -depth + x.abs() / angle.tan();
                (ball.lowest(DVec2::new(x, 5.0)).height - floor).max(0.0) * step
            })
            .sum();
        let exact = radius * radius * (1.0 / angle.tan() - (PI / 2.0 - angle));
        assert!((area / exact - 1.0).abs() < 1e-3, "{angle_deg}: {area} {exact}");
    }
}

#[test]
fn the_mold_is_not_sorted_any_more_once_nobody_waits() {
    let cancel = Cancel::default();
    cancel.cancel();
    assert!(matches!(BallReach::new(&pocket(), 1.0, &cancel), Err(Cancelled)));
}
