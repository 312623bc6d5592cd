//! Exact intersections of circles about the axis, and of rays along the radius, with a mesh.
//!
//! Both live in a plane x = const, in which the mesh is a set of segments with the solid on their left (seen
//! from +X). Which side of a circle or ray a segment's end lies on is decided once per mesh edge, so that a
//! closed mesh is always entered as often as it is left, whatever the rounding.

use std::f64::consts::TAU;
use std::sync::OnceLock;

use glam::{DVec2, DVec3, Vec3Swizzles as _};

use super::search_grid::SearchGrid;
use geometry::frame::{Cylindrical, wrap_angle};
use geometry::mesh::{Bounds, Mesh, unit_normal};

/// Cells along the axis and along the radius of the grid that [`Slices::cell_middle`] counts in, and at most of
/// the search grid.
pub(crate) const CELLS: [usize; 2] = [64, 192];

/// Solids and gaps narrower than this (rad) are rounding.
const SLIVER: f64 = 1e-10;

/// A mesh in W, sorted for circles about X and for radial rays.
pub(crate) struct Slices {
    mesh: Mesh,
    bounds: Bounds,
    grid: SearchGrid,
    /// Whether the mesh is closed, found when it is first asked for.
    is_closed: OnceLock<bool>,
}

/// Intersection of a circle about the axis with the mesh.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Crossing {
    /// Angle about the axis (rad).
    pub theta: f64,
    /// Whether the solid lies on the side of greater theta.
    pub enters: bool,
    /// The triangle that is met.
    pub triangle: u32,
}

/// An arc of a circle that lies outside the solid, between two crossings.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Gap {
    /// End of the solid of smaller theta.
    pub low: Crossing,
    /// Start of the solid of greater theta; its theta is greater than that of `low`.
    pub high: Crossing,
}

impl Gap {
    /// Angle between the two ends (rad).
    pub fn width(&self) -> f64 {
        self.high.theta - self.low.theta
    }

    /// Angle of the middle (rad).
    pub fn middle(&self) -> f64 {
        0.5 * (self.low.theta + self.high.theta)
    }

    /// Whether the gap holds the half plane at `theta` (rad), in whichever turn.
    pub fn holds(&self, theta: f64) -> bool {
        (theta - self.low.theta).rem_euclid(TAU) < self.width()
    }

    /// Gap counted `turns` whole turns further.
    fn turned(mut self, turns: f64) -> Self {
        self.low.theta += turns * TAU;
        self.high.theta += turns * TAU;
        self
    }

    /// How much of this gap's angle lies within `other`, negative when they are apart (rad).
    fn overlap(&self, other: &Gap) -> f64 {
        self.high.theta.min(other.high.theta) - self.low.theta.max(other.low.theta)
    }
}

/// Intersection of a ray along the radius with the mesh.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct RadialCrossing {
    /// Distance from the axis (mm).
    pub r: f64,
    /// Whether the solid lies on the side of greater radius.
    pub enters: bool,
    /// The triangle that is met.
    pub triangle: u32,
}

impl Slices {
    /// Sorts `mesh`, which is given in W and has at least one triangle.
    pub fn new(mesh: Mesh) -> Self {
        let bounds = mesh.bounds();
        let grid = SearchGrid::new(&mesh, bounds, CELLS);
        Self { mesh, bounds, grid, is_closed: OnceLock::new() }
    }

    /// The mesh in W.
    pub fn mesh(&self) -> &Mesh {
        &self.mesh
    }

    /// Box around the mesh.
    pub fn bounds(&self) -> Bounds {
        self.bounds
    }

    /// Middle (x, r) of a cell of the grid of [`CELLS`].
    pub fn cell_middle(&self, ix: usize, ir: usize) -> DVec2 {
        self.grid.origin + self.cell_size() * (DVec2::new(ix as f64, ir as f64) + 0.5)
    }

    /// The cell of the grid of [`CELLS`] that holds the circle through `p`.
    pub fn cell_at(&self, p: DVec3) -> Option<[usize; 2]> {
        let at = (DVec2::new(p.x, p.yz().length()) - self.grid.origin) / self.cell_size();
        let [x, r] = [at.x.floor(), at.y.floor()];
        let inside = (0.0..CELLS[0] as f64).contains(&x) && (0.0..CELLS[1] as f64).contains(&r);
        inside.then_some([x as usize, r as usize])
    }

    /// Size of a cell of the grid of [`CELLS`] along x and r (mm).
    pub fn cell_size(&self) -> DVec2 {
        self.grid.size / DVec2::new(CELLS[0] as f64, CELLS[1] as f64)
    }

    /// Unit outward normal of a triangle.
    pub fn normal(&self, triangle: u32) -> DVec3 {
        unit_normal(self.mesh.corners(triangle as usize))
    }

    /// Every crossing of the circle of radius `r` about the axis at `x`, in order of theta in (-pi, pi].
    pub fn circle(&self, x: f64, r: f64) -> Vec<Crossing> {
        let mut crossings = Vec::new();
        for &triangle in self.grid.about(x, r) {
            let Some([p, q]) = self.segment(triangle, x) else { continue };
            let mut push = |t: f64, enters| {
                let at = p.lerp(q, t);
                crossings.push(Crossing { theta: at.y.atan2(at.x), enters, triangle });
            };
            let (p_in, q_in) = (p.length_squared() < r * r, q.length_squared() < r * r);
            let Some((first, last)) = chord(p, q, r, p_in != q_in) else { continue };
            // The solid is on the segment's left: running outwards across the circle it lies ahead in theta.
            match (p_in, q_in) {
                (true, false) => push(last.clamp(0.0, 1.0), true),
                (false, true) => push(first.clamp(0.0, 1.0), false),
                (false, false) if first > 0.0 && last < 1.0 => {
                    push(first, false);
                    push(last, true);
                }
                _ => {}
            }
        }
        crossings.sort_by(|a, b| a.theta.total_cmp(&b.theta).then(a.triangle.cmp(&b.triangle)));
        crossings
    }

    /// The arcs of a circle that lie outside the solid, in order of their lower ends; none when it meets nothing.
    ///
    /// Where triangles are missing the mesh does not tell how deep in the solid a circle is. There an arc begins where the
    /// solid is left and ends where it is entered next, so that only those beside the hole are lost.
    pub fn gaps(&self, x: f64, r: f64) -> Vec<Gap> {
        let crossings = self.circle(x, r);
        let n = crossings.len();
        if n == 0 {
            return Vec::new();
        }
        let next = |i: usize| (crossings[(i + 1) % n], if i + 1 == n { TAU } else { 0.0 });
        let width = |i: usize| next(i).0.theta + next(i).1 - crossings[i].theta;
        let step = |crossing: &Crossing| if crossing.enters { 1 } else { -1 };
        let is_balanced = crossings.iter().map(step).sum::<i32>() == 0;
        let mut outside = Vec::new();
        if is_balanced {
            // Shells may overlap (blades pushed into a hub): count how deep the circle is, starting in the widest arc.
            let widest = (0..n).max_by(|&a, &b| width(a).total_cmp(&width(b))).unwrap_or(0);
            let mut depth = self.depth(x, r, crossings[widest].theta + 0.5 * width(widest));
            for i in (0..n).map(|k| (widest + k) % n) {
                depth += if i == widest { 0 } else { step(&crossings[i]) };
                if depth <= 0 {
                    outside.push(i);
                }
            }
        }
        let tells_nothing = outside.is_empty() || outside.len() == n;
        if !is_balanced || (tells_nothing && !self.is_closed()) {
            outside = (0..n).filter(|&i| !crossings[i].enters && next(i).0.enters).collect();
        }
        let gap = |i: usize| {
            let (high, turn) = next(i);
            Gap { low: crossings[i], high: Crossing { theta: high.theta + turn, ..high } }
        };
        let mut gaps: Vec<Gap> = outside.into_iter().filter(|i| width(*i) > SLIVER).map(gap).collect();
        gaps.sort_by(|a, b| a.low.theta.total_cmp(&b.low.theta));
        gaps
    }

    fn is_closed(&self) -> bool {
        *self.is_closed.get_or_init(|| self.mesh.is_watertight())
    }

    /// The gap of the circle at (`x`, `r`) that shares most with `near`, counted by the turn that `near` is in.
    pub fn gap_near(&self, x: f64, r: f64, near: &Gap) -> Option<Gap> {
        let best = self.gaps(x, r).into_iter().map(|gap| {
            let turns = ((near.middle() - gap.middle()) / TAU).round();
            gap.turned(turns)
        });
        let best = best.max_by(|a, b| a.overlap(near).total_cmp(&b.overlap(near)))?;
        (best.overlap(near) > 0.0).then_some(best)
    }

    /// Every crossing of the ray from the axis at `x` towards `theta`, in order of radius.
    pub fn ray(&self, x: f64, theta: f64) -> Vec<RadialCrossing> {
        let along = DVec2::from_angle(theta);
        let mut crossings = Vec::new();
        for &triangle in self.grid.towards(self.grid.column(x), theta) {
            let Some([p, q]) = self.segment(triangle, x) else { continue };
            let (side_p, side_q) = (along.perp_dot(p), along.perp_dot(q));
            if (side_p >= 0.0) == (side_q >= 0.0) {
                continue;
            }
            let r = along.dot(p.lerp(q, side_p / (side_p - side_q)));
            if r > 0.0 {
                // Running towards greater theta, a segment has the solid on its inner side.
                crossings.push(RadialCrossing { r, enters: side_p >= 0.0, triangle });
            }
        }
        crossings.sort_by(|a, b| a.r.total_cmp(&b.r));
        crossings
    }

    /// The first triangle that the ray from `from` (x, r) along `direction` (x, r; a unit vector) meets within `reach`
    /// (mm, also infinite) in the half plane at `theta`, from either side: the distance (mm) and the triangle.
    pub fn first_in_half_plane(&self, theta: f64, from: DVec2, direction: DVec2, reach: f64) -> Option<(f64, u32)> {
        let along = DVec2::from_angle(theta);
        // Along the radius an infinite reach leaves x where it is.
        let far = if direction.x == 0.0 { from.x } else { from.x + reach * direction.x };
        let column = |x: f64| self.grid.column(x);
        let (first, last) = (column(from.x), column(far));
        let nearer = |a: &(f64, u32), b: &(f64, u32)| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1));
        let met_in = |ix: usize| {
            let triangles = self.grid.towards(ix, theta).iter();
            let met = triangles.filter_map(|&triangle| {
                let [p, q] = self.half_plane_segment(triangle, along)?;
                let (p, q) = (p - from, q - from);
                let (side_p, side_q) = (direction.perp_dot(p), direction.perp_dot(q));
                if (side_p >= 0.0) == (side_q >= 0.0) {
                    return None;
                }
                let distance = direction.dot(p.lerp(q, side_p / (side_p - side_q)));
                // Beyond the axis the same line is in the half plane on its other side.
                let is_here = from.y + distance * direction.y >= 0.0;
                (distance > 0.0 && distance <= reach && is_here).then_some((distance, triangle))
            });
            met.min_by(nearer)
        };
        // Column by column: what is met in one that was passed is nearer than anything in those to come.
        let mut nearest: Option<(f64, u32)> = None;
        for step in 0..=first.abs_diff(last) {
            let ix = if first <= last { first + step } else { first - step };
            let met = met_in(ix).into_iter().chain(nearest);
            nearest = met.min_by(nearer);
            if nearest.is_some_and(|(distance, _)| column(from.x + distance * direction.x).abs_diff(first) <= step) {
                break;
            }
        }
        nearest
    }

    /// The segment (x, r) in which the half plane through the axis along `along` (z, -y) meets a triangle.
    fn half_plane_segment(&self, triangle: u32, along: DVec2) -> Option<[DVec2; 2]> {
        let ids = self.mesh.triangles[triangle as usize];
        let corners = ids.map(|v| self.mesh.vertices[v as usize]);
        let sides = corners.map(|p| along.perp_dot(DVec2::new(p.z, -p.y)));
        let crossed = match sides.map(|side| side >= 0.0) {
            [a, b, c] if a == b && b == c => return None,
            [a, b, c] if a == b && b != c => [(1, 2), (2, 0)],
            [a, b, c] if b == c && a != b => [(0, 1), (2, 0)],
            _ => [(0, 1), (1, 2)],
        };
        // An edge is met at the same place, to the last bit, in both triangles that share it.
        let segment = crossed.map(|(i, k)| {
            let (i, k) = if ids[i] < ids[k] { (i, k) } else { (k, i) };
            let at = corners[i].lerp(corners[k], sides[i] / (sides[i] - sides[k]));
            DVec2::new(at.x, along.dot(DVec2::new(at.z, -at.y)))
        });
        // On the other side of the axis the same plane goes on.
        segment.iter().any(|p| p.y > 0.0).then_some(segment)
    }

    /// How far a facet that is met at radius `r` dips below the circle through its corners (mm).
    pub fn sag(&self, triangle: u32, r: f64) -> f64 {
        let theta = self.mesh.corners(triangle as usize).map(|p| Cylindrical::from_point(p).theta);
        let turn =
            theta.iter().map(|t| wrap_angle(t - theta[0])).fold([0.0, 0.0], |[l, m]: [f64; 2], t| [l.min(t), m.max(t)]);
        r * (1.0 - (0.5 * (turn[1] - turn[0])).cos())
    }

    /// The share of [`Self::sag`] that lies across a triangle: none where it faces along the axis (mm).
    pub fn radial_sag(&self, triangle: u32, r: f64) -> f64 {
        let normal = self.normal(triangle);
        self.sag(triangle, r) * normal.y.hypot(normal.z).min(1.0)
    }

    /// Components (x, r) of the unit normal of a triangle in the half plane at `theta`.
    pub fn meridional_normal(&self, triangle: u32, theta: f64) -> DVec2 {
        let normal = self.normal(triangle);
        let (s, c) = theta.sin_cos();
        DVec2::new(normal.x, c * normal.z - s * normal.y)
    }

    /// Distances from the axis of the corners that the section at `x` has within `half` of the angle `theta`.
    pub fn corner_radii(&self, x: f64, theta: f64, half: f64) -> Vec<f64> {
        let along = DVec2::from_angle(theta);
        let triangles = self.grid.within(self.grid.column(x), [theta - half, theta + half]);
        let corners = triangles.filter_map(|&t| self.segment(t, x)).flatten();
        corners.filter(|c| along.angle_to(*c).abs() <= half).map(DVec2::length).collect()
    }

    /// Whether the point lies in the solid.
    pub fn is_solid(&self, x: f64, r: f64, theta: f64) -> bool {
        self.depth(x, r, theta) > 0
    }

    /// How many shells the point lies in.
    fn depth(&self, x: f64, r: f64, theta: f64) -> i32 {
        self.ray(x, theta).iter().filter(|c| c.r > r).map(|c| if c.enters { -1 } else { 1 }).sum()
    }

    /// The segment in which the plane at `x` meets a triangle, as points (z, -y), whose polar angle is theta;
    /// seen from +X the solid is on its left.
    fn segment(&self, triangle: u32, x: f64) -> Option<[DVec2; 2]> {
        let ids = self.mesh.triangles[triangle as usize];
        let above = ids.map(|v| self.mesh.vertices[v as usize].x >= x);
        let lone = match above {
            [a, b, c] if a == b && b == c => return None,
            [a, b, c] if b == c && a != b => 0,
            [a, b, c] if a == c && a != b => 1,
            _ => 2,
        };
        let [a, b, c] = [ids[lone], ids[(lone + 1) % 3], ids[(lone + 2) % 3]];
        let (p, q) = (self.edge_point(a, b, x), self.edge_point(a, c, x));
        Some(if above[lone] { [p, q] } else { [q, p] })
    }

    /// Where an edge meets the plane at `x`: the same to the last bit for both triangles that share it.
    fn edge_point(&self, a: u32, b: u32, x: f64) -> DVec2 {
        let (p, q) = (self.mesh.vertices[a.min(b) as usize], self.mesh.vertices[a.max(b) as usize]);
        let at = p.lerp(q, (x - p.x) / (q.x - p.x));
        DVec2::new(at.z, -at.y)
    }
}

/// Components of a direction along x, along the radius and about the axis at `theta`.
pub(crate) fn cylindrical_components(d: DVec3, theta: f64) -> DVec3 {
    let (s, c) = theta.sin_cos();
    DVec3::new(d.x, -s * d.y + c * d.z, -c * d.y - s * d.z)
}

/// Parameters at which the line from `p` to `q` enters and leaves the circle of radius `r` about the origin;
/// always there when it is known to `cross` the circle between `p` and `q`.
fn chord(p: DVec2, q: DVec2, r: f64, cross: bool) -> Option<(f64, f64)> {
    let d = q - p;
    let (a, b, c) = (d.length_squared(), p.dot(d), p.length_squared() - r * r);
    let discriminant = b * b - a * c;
    if discriminant < 0.0 && !cross {
        return None;
    }
    let s = b + discriminant.max(0.0).sqrt().copysign(b);
    if a == 0.0 || s == 0.0 {
        return cross.then_some((0.5, 0.5));
    }
    let (t, u) = (-s / a, -c / s);
    Some((t.min(u), t.max(u)))
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    #[test]
    fn rays_in_half_planes_meet_a_square_bar() {
        let bar = Slices::new(Mesh::cuboid(DVec3::new(4.0, 2.0, 2.0)).mapped(|p| p - DVec3::new(0.0, 1.0, 1.0)));
        let outwards = |theta: f64, direction: DVec2, reach| {
            bar.first_in_half_plane(theta, DVec2::new(1.0, 0.5), direction, reach).map(|(distance, _)| distance)
        };
        for theta in [0.3, 0.5 * PI + 0.3, PI + 0.3, -0.3] {
            let expected = 1.0 / 0.3f64.cos() - 0.5;
            let found = outwards(theta, DVec2::Y, f64::INFINITY).unwrap();
            assert!((found - expected).abs() < 1e-12, "{theta}: {found}");
            // Towards the axis there is nothing on this side of it.
            assert_eq!(outwards(theta, DVec2::NEG_Y, f64::INFINITY), None);
            // Slanted to the end face at x = 4.
            let slanted = outwards(theta, DVec2::new(0.98, 0.02).normalize(), f64::INFINITY).unwrap();
            assert!((slanted - 3.0 * 0.98f64.hypot(0.02) / 0.98).abs() < 1e-12, "{slanted}");
            assert_eq!(outwards(theta, DVec2::Y, 0.4), None);
        }
    }

    #[test]
    fn a_circle_leaves_a_square_bar_where_trigonometry_says() {
        let bar = Slices::new(Mesh::cuboid(DVec3::new(4.0, 2.0, 2.0)).mapped(|p| p - DVec3::new(0.0, 1.0, 1.0)));
        let gaps = bar.gaps(1.0, 1.25);
        assert_eq!(gaps.len(), 4, "{gaps:?}");
        let half = (1.0f64 / 1.25).acos();
        for (gap, middle) in gaps.iter().zip([-0.5 * PI, 0.0, 0.5 * PI, PI]) {
            assert!((gap.middle() - middle).abs() < 1e-12 && (gap.width() - 2.0 * half).abs() < 1e-12, "{gap:?}");
        }
        assert!(bar.gaps(1.0, 0.9).is_empty() && bar.gaps(1.0, 1.5).is_empty() && bar.gaps(5.0, 1.25).is_empty());
        let [corner] = bar.ray(1.0, 0.25 * PI)[..] else { panic!("the ray leaves the bar once") };
        assert!((corner.r - 2f64.sqrt()).abs() < 1e-12 && !corner.enters);
    }

    #[test]
    fn overlapping_shells_count_as_one_solid() {
        let mut mesh = Mesh::cuboid(DVec3::new(4.0, 2.0, 2.0)).mapped(|p| p - DVec3::new(0.0, 1.0, 1.0));
        // A fin that starts inside the bar and sticks out along +Z.
        let fin = Mesh::cuboid(DVec3::new(4.0, 0.2, 3.0)).mapped(|p| p - DVec3::new(0.0, 0.1, 0.0));
        let offset = mesh.vertices.len() as u32;
        mesh.vertices.extend(fin.vertices);
        mesh.triangles.extend(fin.triangles.iter().map(|t| t.map(|v| v + offset)));
        let slices = Slices::new(mesh);
        assert!(slices.gaps(2.0, 0.5).is_empty(), "inside the bar the fin's sides bound no gap");
        let gaps = slices.gaps(2.0, 2.0);
        assert_eq!(gaps.len(), 1);
        assert!((gaps[0].width() - (TAU - 2.0 * (0.1f64 / 2.0).asin())).abs() < 1e-12);
    }

    /// Four posts, one of which has lost half of a side: circles through the hole lose the gap beside it, no other.
    #[test]
    fn missing_triangles_take_only_the_gap_beside_them() {
        let mut whole = Mesh::default();
        for k in 0..4 {
            let turn = glam::DMat3::from_rotation_x(k as f64 * 0.5 * PI);
            let post = Mesh::cuboid(DVec3::new(4.0, 2.0, 2.0)).mapped(|p| turn * (p + DVec3::new(0.0, -1.0, 4.0)));
            let offset = whole.vertices.len() as u32;
            whole.vertices.extend(post.vertices);
            whole.triangles.extend(post.triangles.iter().map(|t| t.map(|v| v + offset)));
        }
        let mut open = whole.clone();
        let side = whole.iter_corners().position(|t| t.iter().all(|p| p.y == -1.0 && p.z > 3.0)).unwrap();
        open.triangles.remove(side);
        let [whole, open] = [whole, open].map(Slices::new);
        let mut lost = 0;
        for x in [1.0, 3.0] {
            for r in [4.5, 5.0, 5.5] {
                let (all, found) = (whole.gaps(x, r), open.gaps(x, r));
                assert_eq!(all.len(), 4);
                lost += all.len() - found.len();
                assert!(
                    found.len() >= 3
                        && found.iter().all(|gap| {
                            all.iter().any(|other| {
                                (gap.middle() - other.middle()).abs() + (gap.width() - other.width()).abs() < 1e-12
                            })
                        }),
                    "{found:?}"
                );
            }
        }
        assert!((1..6).contains(&lost), "some circles meet the hole: {lost}");
    }

    #[test]
    fn a_coarser_search_grid_finds_the_same() {
        // A fan of many triangles that each reach all over the part makes the search grid coarser.
        let fan = |n: usize| {
            let mut mesh = Mesh::cuboid(DVec3::new(4.0, 2.0, 2.0)).mapped(|p| p - DVec3::new(0.0, 1.0, 1.0));
            let first = mesh.vertices.len() as u32;
            mesh.vertices.extend([DVec3::new(0.0, 0.0, 3.0), DVec3::new(4.0, 0.0, 3.0), DVec3::new(2.0, 0.0, -3.0)]);
            (0..n).for_each(|_| mesh.triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 1]]));
            Slices::new(mesh)
        };
        let (fine, coarse) = (fan(1), fan(2500));
        assert!(coarse.grid.counts[0] < fine.grid.counts[0]);
        let gaps = |slices: &Slices| slices.gaps(1.0, 1.25).iter().map(Gap::width).collect::<Vec<_>>();
        assert_eq!(gaps(&fine).len(), 5, "four beside the bar, one of them parted by the fan");
        assert_eq!(gaps(&fine), gaps(&coarse));
        assert_eq!(fine.cell_middle(3, 5), coarse.cell_middle(3, 5));
    }

    proptest::proptest! {
        #[test]
        fn a_closed_mesh_is_left_as_often_as_it_is_entered(
            x in 0.0..3.0f64, r in 0.0..3.0f64, turn in -3.0..3.0f64, shift in -1.0..1.0f64,
        ) {
            let turn = glam::DQuat::from_euler(glam::EulerRot::XYZ, turn, 2.0 * turn, -turn);
            let slices = Slices::new(Mesh::cuboid(DVec3::new(2.0, 3.0, 1.0)).mapped(|p| turn * p + shift));
            let crossings = slices.circle(x, r);
            let entered = crossings.iter().filter(|c| c.enters).count();
            proptest::prop_assert_eq!(2 * entered, crossings.len());
            let ray = slices.ray(x, turn.x);
            let outside = slices.ray(x, turn.x).iter().map(|c| if c.enters { 1 } else { -1 }).sum::<i32>();
            proptest::prop_assert!(outside == 0 || outside == -1, "{:?}", ray);
        }
    }
}
