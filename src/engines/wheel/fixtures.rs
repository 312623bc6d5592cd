//! Parts for tests, made from formulas: blisks whose walls are known exactly, and parts that are no blisks.

use crate::channel::Channel;
use crate::channel::ChannelWall;
use crate::channel::Throat;
use crate::channel::{Flow, Station};
use crate::parametric::ChannelSide;
use crate::parametric::ParametricBlisk;
use crate::parametric::welder::Welder;
pub use crate::parametric::wheel::flange;
use std::f64::consts::PI;
use std::f64::consts::TAU;

use glam::DVec3;

use geometry::frame::Cylindrical;
use geometry::frame::Frame;
use geometry::mesh::Mesh;

/// A blisk between two cones, its blades of parabolic camber, with its axis along X and the blades from x = 0
/// to x = `chord`. Mesh vertices lie exactly on the formulas of [`Self::wall`].
#[derive(Debug, Clone)]
pub struct TestBlisk {
    /// Number of blades.
    pub blades: usize,
    /// Radius at x = 0 and its slope.
    pub hub: [f64; 2],
    /// Radius at x = 0 and its slope.
    pub shroud: [f64; 2],
    /// Radius of the bore (mm).
    pub bore: f64,
    /// Thickness of the shroud ring.
    pub ring: f64,
    /// Length along the axis (mm).
    pub chord: f64,
    /// How far the rings reach beyond the blades.
    pub beside: f64,
    /// Greatest blade thickness, around the axis at the mean radius.
    pub thickness: f64,
    /// Slope angles of the camber line at its two ends (rad).
    pub beta: [f64; 2],
    /// Turn of the blade per mm of radius (rad/mm).
    pub twist: f64,
    /// Radius of the fillets at hub and shroud; their height is a quarter circle across the blade.
    pub fillet: f64,
    /// Whether a ring closes the channels.
    pub shrouded: bool,
    /// Grid along the chord, along the span, across the channel, and beside the blades.
    pub grid: [usize; 4],
}

impl Default for TestBlisk {
    fn default() -> Self {
        Self {
            blades: 24,
            hub: [50.0, 0.0],
            shroud: [62.0, 0.0],
            bore: 30.0,
            ring: 4.0,
            chord: 14.0,
            beside: 3.0,
            thickness: 2.4,
            beta: [0.6, -0.7],
            twist: 0.004,
            fillet: 0.0,
            shrouded: true,
            grid: [24, 8, 8, 2],
        }
    }
}

impl TestBlisk {
    /// Angle from blade to blade (rad).
    pub fn pitch(&self) -> f64 {
        TAU / self.blades as f64
    }

    /// Radius in the middle of the channel (mm).
    pub fn mean_radius(&self) -> f64 {
        0.5 * (self.hub[0] + self.shroud[0] + (self.hub[1] + self.shroud[1]) * 0.5 * self.chord)
    }

    /// Radius of the hub at `x` (mm).
    pub fn hub_at(&self, x: f64) -> f64 {
        self.hub[0] + self.hub[1] * x
    }

    /// Radius of the shroud at `x` (mm).
    pub fn shroud_at(&self, x: f64) -> f64 {
        self.shroud[0] + self.shroud[1] * x
    }

    /// Theta of the camber surface of blade 0; beside the blades the camber of their edges.
    fn camber(&self, x: f64, r: f64) -> f64 {
        let t = x.clamp(0.0, self.chord);
        let [t0, t1] = self.beta.map(f64::tan);
        (t0 * t + (t1 - t0) * t * t / (2.0 * self.chord)) / self.mean_radius() + self.twist * (r - self.mean_radius())
    }

    /// Half the angle that a blade fills at (x, r), fillets included.
    fn half_blade(&self, x: f64, r: f64) -> f64 {
        let s = (x / self.chord).clamp(0.0, 1.0);
        // Round noses at both ends, greatest in the middle.
        let profile = 0.5 * self.thickness * (4.0 * s * (1.0 - s)).sqrt();
        let height = |h: f64| {
            let k = (1.0 - h / self.fillet.max(1e-300)).clamp(0.0, 1.0);
            self.fillet * (1.0 - (1.0 - k * k).sqrt())
        };
        let root = height(r - self.hub_at(x)) + if self.shrouded { height(self.shroud_at(x) - r) } else { 0.0 };
        (profile + root.min(3.0 * profile)) / self.mean_radius()
    }

    /// Theta of the low and of the high wall of the channel between blade 0 and blade 1.
    pub fn wall(&self, x: f64, r: f64) -> [f64; 2] {
        let (camber, half) = (self.camber(x, r), self.half_blade(x, r));
        [camber + half, camber + self.pitch() - half]
    }

    /// The x of grid station `i`: closer together towards the blades' edges.
    fn station(&self, i: usize) -> f64 {
        let [n, _, _, beside] = self.grid;
        let step = self.beside / beside as f64;
        if i <= beside {
            step * i as f64 - self.beside
        } else if i < beside + n {
            let s = 0.5 * (1.0 - (std::f64::consts::PI * (i - beside) as f64 / n as f64).cos());
            self.chord * s
        } else {
            self.chord + step * (i - beside - n) as f64
        }
    }

    /// The closed mesh.
    pub fn mesh(&self) -> Mesh {
        self.sectors(0..self.blades)
    }

    /// The surface of some of the sectors from blade to blade, open at the ends if they are not all.
    pub fn sectors(&self, sectors: std::ops::Range<usize>) -> Mesh {
        let mut w = Welder::default();
        for k in sectors {
            self.add_sector(&mut w, k as f64 * self.pitch());
        }
        w.mesh
    }

    fn add_sector(&self, w: &mut Welder, turn: f64) {
        let [n, nr, m, beside] = self.grid;
        let last = n + 2 * beside;
        let at = |x: f64, r: f64, theta: f64| Cylindrical { x, r, theta: theta + turn }.point();
        let share = |j: usize, of: usize| j as f64 / of as f64;
        // Across the channel at a station, from the low wall to the high one.
        let across = |i: usize, r: f64, j: usize| {
            let [lo, hi] = self.wall(self.station(i), r);
            lo + (hi - lo) * share(j, m)
        };
        let end = |i: usize, r: f64, r_wall: f64, j: usize| at(self.station(i), r, across(i, r_wall, j));
        let hub = |i: usize| self.hub_at(self.station(i));
        let shroud = |i: usize| self.shroud_at(self.station(i));
        let outer = |i: usize| shroud(i) + self.ring;
        w.patch(last, m, |i, j| end(i, hub(i), hub(i), j));
        w.patch(m, last, |j, i| end(i, self.bore, hub(i), j));
        w.patch(1, m, |i, j| end(0, if i == 0 { self.bore } else { hub(0) }, hub(0), j));
        w.patch(m, 1, |j, i| end(last, if i == 0 { self.bore } else { hub(last) }, hub(last), j));
        if self.shrouded {
            w.patch(m, last, |j, i| end(i, shroud(i), shroud(i), j));
            w.patch(last, m, |i, j| end(i, outer(i), shroud(i), j));
            w.patch(1, m, |i, j| end(0, if i == 0 { shroud(0) } else { outer(0) }, shroud(0), j));
            w.patch(m, 1, |j, i| end(last, if i == 0 { shroud(last) } else { outer(last) }, shroud(last), j));
        }
        // The blade below this channel: its high side bounds this channel, its low side the one before.
        let blade = |i: usize, j: usize, side: f64| {
            let x = self.station(i + beside);
            let r = self.hub_at(x) + (self.shroud_at(x) - self.hub_at(x)) * share(j, nr);
            at(x, r, self.camber(x, r) + side * self.half_blade(x, r))
        };
        w.patch(nr, n, |j, i| blade(i, j, 1.0));
        w.patch(n, nr, |i, j| blade(i, j, -1.0));
        self.add_blade_base(w, turn);
        if !self.shrouded {
            w.patch(n, 1, |i, j| blade(i, nr, if j == 0 { -1.0 } else { 1.0 }));
        }
    }

    /// The bore and outer skin under and over the blade itself, which the channel's patches leave out.
    fn add_blade_base(&self, w: &mut Welder, turn: f64) {
        let [n, _, _, beside] = self.grid;
        let at = |i: usize, r: f64, r_wall: f64, side: usize| {
            let x = self.station(i + beside);
            let theta = self.camber(x, r_wall) + (2.0 * side as f64 - 1.0) * self.half_blade(x, r_wall);
            Cylindrical { x, r, theta: theta + turn }.point()
        };
        let x = |i: usize| self.station(i + beside);
        w.patch(1, n, |j, i| at(i, self.bore, self.hub_at(x(i)), j));
        if self.shrouded {
            w.patch(n, 1, |i, j| at(i, self.shroud_at(x(i)) + self.ring, self.shroud_at(x(i)), j));
        }
    }
}

/// A solid of revolution about X: the polygon of (x, r), counter-clockwise in the plane (x, r), turned in `n` steps.
pub fn turned_part(outline: &[[f64; 2]], n: usize) -> Mesh {
    let mut w = Welder::default();
    let at = |i: usize, j: usize| {
        let [x, r] = outline[i % outline.len()];
        Cylindrical { x, r, theta: TAU * (j % n) as f64 / n as f64 }.point()
    };
    w.patch(n, outline.len(), |j, i| at(i, j));
    w.mesh
}

/// Both meshes as one, as separate shells.
pub fn together(mut a: Mesh, b: &Mesh) -> Mesh {
    let offset = a.vertices.len() as u32;
    a.vertices.extend_from_slice(&b.vertices);
    a.triangles.extend(b.triangles.iter().map(|t| t.map(|v| v + offset)));
    a
}

/// Channel 0 of `blisk` from the generator's own surfaces.
pub fn exact_channel(blisk: &ParametricBlisk) -> Channel {
    let wall = |side| exact_wall(blisk, side);
    let (low, high) = (wall(ChannelSide::Low), wall(ChannelSide::High));
    let ends = [0, low.nu - 1].map(|u| low.cylindrical(u, low.nv / 2).theta + high.cylindrical(u, low.nv / 2).theta);
    let [from, to] = blisk.faces_x();
    let meridian = (0..=40).map(|i| from + (to - from) * f64::from(i) / 40.0).map(|x| {
        let (hub, shroud) = blisk.radii(x);
        Station::across_axis(x, hub, shroud)
    });
    Channel {
        frame: Frame::IDENTITY,
        blades: blisk.blades,
        index: 0,
        shrouded: blisk.shrouded,
        flow: Flow::Axial,
        meridian: meridian.collect(),
        throat: Throat { width_mm: 0.0, on_low_wall: DVec3::ZERO, on_high_wall: DVec3::ZERO },
        turning: 0.5 * (ends[1] - ends[0]),
        faces_x: blisk.faces_x(),
        agreement: Vec::new(),
        kinds: 1,
        whole: None,
        obstacles: None,
        unlike: Vec::new(),
        assumed: Vec::new(),
        low,
        high,
    }
}

fn exact_wall(blisk: &ParametricBlisk, side: ChannelSide) -> ChannelWall {
    let (nu, nv) = (61, 9);
    let mut points = Vec::new();
    let mut normals = Vec::new();
    for u in 0..nu {
        // Close stations at the edges, where the wall turns round.
        let along = 0.5 - 0.5 * (u as f64 / (nu - 1) as f64 * PI).cos();
        for v in 0..nv {
            let [point, normal] = blisk.wall_at(side, along, v as f64 / (nv - 1) as f64);
            points.push(point);
            normals.push(normal);
        }
    }
    ChannelWall { nu, nv, points, normals, side: blisk.blade_side(side) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn test_parts_are_closed_solids_of_the_right_volume() {
        let blisk = TestBlisk { hub: [50.0, 0.1], shroud: [62.0, 0.2], fillet: 0.8, ..Default::default() };
        let open = TestBlisk { shrouded: false, ..blisk.clone() };
        for mesh in [blisk.mesh(), open.mesh(), turned_part(&[[0.0, 5.0], [4.0, 5.0], [4.0, 9.0], [0.0, 9.0]], 64)] {
            assert!(mesh.is_watertight());
            assert!(mesh.volume() > 0.0);
        }
        let flange = flange(20.0, 60.0, 8, 6.0);
        let exact = std::f64::consts::PI * 10.0 * (60.0f64.powi(2) - 20f64.powi(2) - 8.0 * 36.0);
        assert!(flange.is_watertight());
        assert!((flange.volume() / exact - 1.0).abs() < 0.02, "{} {exact}", flange.volume());
    }
}
