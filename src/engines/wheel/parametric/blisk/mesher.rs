//! The mesh of a parametric blisk, watertight by construction: grids that share their borders.

use std::f64::consts::TAU;

use super::{ChannelSide, MeshResolution, ParametricBlisk};
use geometry::frame::Cylindrical;
use geometry::mesh::Mesh;

/// Builds the mesh of a blisk from closed circles of vertices and grids between them.
pub(super) struct Mesher<'a> {
    blisk: &'a ParametricBlisk,
    resolution: MeshResolution,
    stations: usize,
    mesh: Mesh,
}

/// The vertices of one blade: `upper[k][v]` and `lower[k][v]` share those of the two edges.
struct BladeVertices {
    upper: Vec<Vec<u32>>,
    lower: Vec<Vec<u32>>,
}

impl<'a> Mesher<'a> {
    pub(super) fn new(blisk: &'a ParametricBlisk, resolution: MeshResolution) -> Self {
        Self { blisk, resolution, stations: 2 * resolution.edge + resolution.chord, mesh: Mesh::default() }
    }

    pub(super) fn build(mut self) -> Mesh {
        let blades: Vec<_> = (0..self.blisk.blades).map(|b| self.blade(b)).collect();
        let hub = self.end_wall(&blades, 0);
        self.body(&hub, false);
        if self.blisk.shrouded {
            let shroud = self.end_wall(&blades, self.resolution.span);
            self.body(&shroud, true);
        } else {
            blades.iter().for_each(|blade| self.tip(blade));
        }
        self.mesh
    }

    fn vertex(&mut self, x: f64, r: f64, theta: f64) -> u32 {
        self.mesh.vertices.push(Cylindrical { x, r, theta }.point());
        self.mesh.vertices.len() as u32 - 1
    }

    /// Two triangles, or one where two corners are the same vertex.
    fn quad(&mut self, [a, b, c, d]: [u32; 4]) {
        for t in [[a, b, c], [a, c, d]] {
            if t[0] != t[1] && t[1] != t[2] && t[2] != t[0] {
                self.mesh.triangles.push(t);
            }
        }
    }

    /// Position and radius of station `k` on the surface that is `v` of the way from hub to tip.
    fn place(&self, k: usize, v: f64) -> (f64, f64) {
        let mut x = 0.5 * self.blisk.chord_mm;
        let mut r = self.blisk.hub_radius_mm;
        // The section depends on the radius and the radius, on conical walls, on x: a strong contraction.
        for _ in 0..40 {
            let (hub, tip) = self.blisk.radii(x);
            r = hub + v * (tip - hub);
            x = self.station_x(k, r);
        }
        (x, r)
    }

    /// Position of station `k` in the section at radius `r`: equal angles round the edges, equal steps between.
    fn station_x(&self, k: usize, r: f64) -> f64 {
        let MeshResolution { edge, chord, .. } = self.resolution;
        let scale = self.blisk.scale(r);
        let round =
            |radius: f64, i: usize| scale * radius * (1.0 - (i as f64 / edge as f64 * 120f64.to_radians()).cos());
        let (le, te) = (self.blisk.x_le(r), self.blisk.x_te(r));
        if k <= edge {
            le + round(self.blisk.leading_radius_mm, k)
        } else if k >= edge + chord {
            te - round(self.blisk.trailing_radius_mm, self.stations - k)
        } else {
            let from = le + round(self.blisk.leading_radius_mm, edge);
            let to = te - round(self.blisk.trailing_radius_mm, edge);
            from + (to - from) * (k - edge) as f64 / chord as f64
        }
    }

    fn blade(&mut self, b: usize) -> BladeVertices {
        let (n, span) = (self.stations, self.resolution.span);
        let turn = b as f64 * self.blisk.pitch();
        let mut blade = BladeVertices { upper: vec![Vec::new(); n + 1], lower: vec![Vec::new(); n + 1] };
        for k in 0..=n {
            for v in 0..=span {
                let (x, r) = self.place(k, v as f64 / span as f64);
                let upper = self.blisk.wall_theta(ChannelSide::Low, x, r) + turn;
                let lower = self.blisk.wall_theta(ChannelSide::High, x, r) + turn - self.blisk.pitch();
                let id = self.vertex(x, r, upper);
                blade.upper[k].push(id);
                let is_tip = k == 0 || k == n;
                blade.lower[k].push(if is_tip { id } else { self.vertex(x, r, lower) });
            }
        }
        for k in 0..n {
            for v in 0..span {
                let (u, l) = (&blade.upper, &blade.lower);
                self.quad([u[k][v], u[k + 1][v], u[k + 1][v + 1], u[k][v + 1]]);
                self.quad([l[k][v], l[k][v + 1], l[k + 1][v + 1], l[k + 1][v]]);
            }
        }
        blade
    }

    /// The end wall between the blades at their row `v`; returns its circles at the two edges.
    fn end_wall(&mut self, blades: &[BladeVertices], v: usize) -> [Vec<u32>; 2] {
        let (n, columns, span) = (self.stations, self.resolution.pitch, self.resolution.span);
        let mut circles = [Vec::new(), Vec::new()];
        for (b, blade) in blades.iter().enumerate() {
            let next = &blades[(b + 1) % blades.len()];
            let turn = b as f64 * self.blisk.pitch();
            let mut grid = Vec::with_capacity(n + 1);
            for k in 0..=n {
                let (x, r) = self.place(k, v as f64 / span as f64);
                let low = self.blisk.wall_theta(ChannelSide::Low, x, r) + turn;
                let high = self.blisk.wall_theta(ChannelSide::High, x, r) + turn;
                let mut row = vec![blade.upper[k][v]];
                for j in 1..columns {
                    row.push(self.vertex(x, r, low + (high - low) * j as f64 / columns as f64));
                }
                row.push(next.lower[k][v]);
                grid.push(row);
            }
            for k in 0..n {
                for j in 0..columns {
                    let corners = [grid[k][j], grid[k][j + 1], grid[k + 1][j + 1], grid[k + 1][j]];
                    self.quad(facing(corners, v > 0));
                }
            }
            circles[0].extend(&grid[0][..columns]);
            circles[1].extend(&grid[n][..columns]);
        }
        circles
    }

    /// The closed ring inside the hub circles, or (`outer`) outside the shroud circles.
    fn body(&mut self, edges: &[Vec<u32>; 2], outer: bool) {
        let far = if outer { self.blisk.outer_radius() } else { self.blisk.bore_radius_mm };
        let mut rims = Vec::new();
        for (end, edge) in edges.iter().enumerate() {
            let at_edge = self.mesh.vertices[edge[0] as usize].x;
            let at_face = self.blisk.faces_x()[end];
            let mut last = edge.clone();
            for i in 1..=self.resolution.ring {
                let x = at_edge + (at_face - at_edge) * i as f64 / self.resolution.ring as f64;
                let (hub, tip) = self.blisk.radii(x);
                let next = self.circle(edge, x, if outer { tip } else { hub });
                self.band(&last, &next, 0, (end == 0) != outer);
                last = next;
            }
            let rim = self.circle(edge, at_face, far);
            self.band(&last, &rim, 0, (end == 0) != outer);
            rims.push(rim);
        }
        let shift = self.shift(edges);
        self.band(&rims[1], &rims[0], shift, outer);
    }

    /// New vertices at `x` and `r` with the angles of the circle `like`.
    fn circle(&mut self, like: &[u32], x: f64, r: f64) -> Vec<u32> {
        let thetas: Vec<_> =
            like.iter().map(|&v| Cylindrical::from_point(self.mesh.vertices[v as usize]).theta).collect();
        thetas.into_iter().map(|theta| self.vertex(x, r, theta)).collect()
    }

    /// How many columns further on the circle at the leading edge is nearest to the one at the trailing edge,
    /// so that the rims are joined straight across.
    fn shift(&self, edges: &[Vec<u32>; 2]) -> usize {
        let theta = |v: u32| Cylindrical::from_point(self.mesh.vertices[v as usize]).theta;
        let columns = edges[0].len();
        let behind = (theta(edges[1][0]) - theta(edges[0][0])) / (TAU / columns as f64);
        (behind.round() as i64).rem_euclid(columns as i64) as usize
    }

    /// Joins two circles: normals along theta x (`a` to `b`), or the other way when `flipped`.
    fn band(&mut self, a: &[u32], b: &[u32], shift: usize, flipped: bool) {
        let n = a.len();
        for i in 0..n {
            let j = (i + 1) % n;
            let corners = [a[i], a[j], b[(j + shift) % n], b[(i + shift) % n]];
            self.quad(facing(corners, flipped));
        }
    }

    /// The tip of a blade without shroud.
    fn tip(&mut self, blade: &BladeVertices) {
        let v = self.resolution.span;
        for k in 0..self.stations {
            let (u, l) = (&blade.upper, &blade.lower);
            self.quad([l[k][v], u[k][v], u[k + 1][v], l[k + 1][v]]);
        }
    }
}

/// The corners of a quad in order, or reversed.
fn facing([a, b, c, d]: [u32; 4], flipped: bool) -> [u32; 4] {
    if flipped { [a, d, c, b] } else { [a, b, c, d] }
}
