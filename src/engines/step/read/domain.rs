//! The part of a surface's parameter plane that a face covers, as closed polygons.
//!
//! Edges that a face uses in both directions are seams of the file's writer and are left out. What remains are closed
//! loops. In a closed direction of the surface they are laid out without jumps; a loop that runs once around the surface
//! is joined to the one across, or to the pole, along a seam of our own whose points are the same on both sides.

use glam::{DVec2, DVec3};

use super::Fineness;
use super::surface::{Axes, Shape, Surface};
use super::triangulate::CANCELLED;
use task::Cancel;

/// Numbers from here on are points of the face alone, in the order in which they were made.
pub(super) const OWN: u32 = 1 << 31;

/// A point of a loop: its place in space and its number in the mesh of the solid.
pub(super) type Node = (DVec3, u32);

/// A corner of a polygon: parameters and number of its point.
pub(super) type Corner = (DVec2, u32);

/// What a face covers in its parameter plane: whatever lies within an odd number of the polygons.
#[derive(Debug, Default)]
pub(super) struct Domain {
    /// Closed polygons.
    pub polygons: Vec<Vec<Corner>>,
    /// Points of seams and poles, numbered from [`OWN`] on.
    pub own: Vec<DVec3>,
}

impl Domain {
    /// Least and greatest parameters.
    pub fn range(&self) -> [DVec2; 2] {
        let corners = || self.polygons.iter().flatten().map(|c| c.0);
        [corners().fold(DVec2::INFINITY, DVec2::min), corners().fold(DVec2::NEG_INFINITY, DVec2::max)]
    }
}

/// A loop laid out in the parameter plane.
#[derive(Debug, Clone)]
struct Run {
    corners: Vec<Corner>,
    /// How often it runs around the closed directions, counted in the sense of rising parameters.
    turns: [i32; 2],
}

/// How often a seam is halved at most.
const SEAM_HALVINGS: u32 = 10;

/// Points of seams and poles, which belong to the face alone.
struct Own<'a> {
    points: Vec<DVec3>,
    fine: &'a Fineness,
}

impl Own<'_> {
    /// Adds a point; its number.
    fn add(&mut self, p: DVec3) -> u32 {
        self.points.push(p);
        OWN + self.points.len() as u32 - 1
    }
}

/// The domain of a face with these `loops`, counter-clockwise around the face as seen from the side to which
/// `du x dv` points. A sphere is turned so that a pole lies within the face.
///
/// # Errors
/// The reason why the loops bound no part of the surface.
pub(super) fn domain(
    surface: &mut Surface,
    loops: &[Vec<Node>],
    fine: &Fineness,
    cancel: &Cancel,
) -> Result<Domain, &'static str> {
    let tolerance = fine.joined;
    turn_sphere(surface, loops);
    let mut runs = Vec::new();
    for nodes in loops.iter().filter(|nodes| nodes.len() > 1) {
        runs.push(lay_out(surface, nodes, tolerance, cancel)?);
    }
    let mut own = Own { points: Vec::new(), fine };
    let mut polygons = Vec::new();
    let around = runs.iter().flat_map(|r| [0, 1].into_iter().filter(|k| r.turns[*k] != 0)).next();
    if runs.iter().any(|r| r.turns[0] != 0 && r.turns[1] != 0) {
        return Err("a boundary winds around the surface both ways");
    }
    let (rings, rest): (Vec<Run>, Vec<Run>) = runs.into_iter().partition(|r| r.turns != [0, 0]);
    let is_whole =
        surface.period[0].is_some() && (surface.period[1].is_some() || surface.poles.iter().all(Option::is_some));
    if let Some(k) = around {
        bands(surface, rings, k, &mut own, &mut polygons)?;
    } else if is_whole && rest.iter().all(|r| area(&r.corners) < 0.0) {
        polygons.extend(whole(surface, &mut own));
    }
    add_rest(surface, rest, &mut polygons);
    if polygons.is_empty() {
        return Err("it has no boundary");
    }
    Ok(Domain { polygons, own: own.points })
}

/// Turns the axis of a sphere towards the middle of the loops: there a pole does no harm, as no edge meets it.
fn turn_sphere(surface: &mut Surface, loops: &[Vec<Node>]) {
    let Shape::Sphere { axes, .. } = &mut surface.shape else { return };
    let Some(nodes) = loops.first() else { return };
    let middle = nodes.iter().map(|n| n.0).sum::<DVec3>() / nodes.len().max(1) as f64;
    let towards = middle - axes.origin;
    let normal: DVec3 =
        (0..nodes.len()).map(|i| (nodes[i].0 - middle).cross(nodes[(i + 1) % nodes.len()].0 - middle)).sum();
    // A great circle has its middle at the centre, so that its plane decides.
    let z = if towards.length() > 1e-3 * normal.length().sqrt() { towards } else { normal };
    if let Some(turned) = Axes::new(axes.origin, z, z.any_orthogonal_vector()) {
        *axes = turned;
    }
}

/// Lays out a loop without jumps.
fn lay_out(surface: &Surface, nodes: &[Node], tolerance: f64, cancel: &Cancel) -> Result<Run, &'static str> {
    let is_pole: Vec<bool> = nodes
        .iter()
        .map(|n| surface.poles.iter().flatten().any(|v| surface.point(DVec2::new(0.0, *v)).distance(n.0) <= tolerance))
        .collect();
    let Some(start) = is_pole.iter().position(|p| !p) else { return Err("its boundary is a single point") };
    let mut corners: Vec<Corner> = Vec::with_capacity(nodes.len() + 2);
    // Numbers of the corners that leave a pole.
    let mut leaving = Vec::new();
    let mut in_vain = 0;
    let mut here = surface.locate_anywhere(nodes[start].0);
    let first = here;
    for k in 0..nodes.len() {
        // A point that is looked for everywhere takes a millisecond or two.
        if k % 16 == 0 && cancel.check().is_err() {
            return Err(CANCELLED);
        }
        let (p, id) = nodes[(start + k) % nodes.len()];
        if is_pole[(start + k) % nodes.len()] {
            let near = |v: &&f64| surface.point(DVec2::new(0.0, **v)).distance_squared(p);
            let pole = surface.poles.iter().flatten().min_by(|a, b| near(a).total_cmp(&near(b)));
            let v = pole.copied().unwrap_or(here.y);
            corners.push((DVec2::new(here.x, v), id));
            // At the pole itself no direction leads to the next point.
            let next = around(surface, surface.locate_anywhere(nodes[(start + k + 1) % nodes.len()].0), here);
            leaving.push(corners.len());
            here = DVec2::new(next.x, v);
            corners.push((here, id));
        } else {
            here = if k == 0 { first } else { follow(surface, p, here, tolerance, &mut in_vain) };
            corners.push((here, id));
        }
    }
    let end = follow(surface, nodes[start].0, here, tolerance, &mut in_vain);
    let mut turns = [0, 1].map(|k| surface.period[k].map_or(0, |t| ((end - first)[k] / t).round() as i32));
    let Some(period) = surface.period[0] else { return Ok(Run { corners, turns }) };
    // Around a pole the way is not known: the loop closes, and encloses what is on its left.
    if let Some(&from) = leaving.first() {
        if turns[0] != 0 {
            let by = DVec2::new(-f64::from(turns[0]) * period, 0.0);
            corners[from..].iter_mut().for_each(|c| c.0 += by);
            turns[0] = 0;
        } else if area(&corners) < 0.0 {
            let to = leaving.get(1).copied().unwrap_or(corners.len());
            let by = DVec2::new(period, 0.0);
            let shifted = |sign: f64| {
                let mut shifted = corners.clone();
                shifted[from..to].iter_mut().for_each(|c| c.0 += by * sign);
                shifted
            };
            if leaving.len() > 1 {
                corners = [shifted(1.0), shifted(-1.0)].into_iter().find(|c| area(c) > 0.0).unwrap_or(corners);
            }
        }
    }
    // Corners of triangles along the pole.
    for from in leaving.into_iter().rev() {
        let ((before, id), (after, _)) = (corners[from - 1], corners[from]);
        let between: Vec<f64> = at_pole(before.x, after.x, period).collect();
        let inner = between.get(1..between.len() - 1).unwrap_or(&[]);
        let added = inner.iter().map(|u| (DVec2::new(*u, before.y), id)).collect::<Vec<_>>();
        corners.splice(from..from, added);
    }
    Ok(Run { corners, turns })
}

/// Searches in vain after which a boundary is known to lie beside its surface: further ones would take long and find
/// nothing.
const MOST_IN_VAIN: usize = 32;

/// Parameters of `p` near those of its neighbour; looked for everywhere where the surface is not met so. Counts the
/// searches that were `in_vain`.
fn follow(surface: &Surface, p: DVec3, near: DVec2, tolerance: f64, in_vain: &mut usize) -> DVec2 {
    let found = surface.locate(p, near);
    let off = surface.point(found).distance(p);
    if off <= tolerance || *in_vain >= MOST_IN_VAIN {
        return found;
    }
    let other = around(surface, surface.locate_anywhere(p), near);
    if surface.point(other).distance(p) < 0.5 * off {
        return other;
    }
    *in_vain += 1;
    found
}

/// Parameters of the same point, of all equal ones the nearest to `near`.
fn around(surface: &Surface, uv: DVec2, near: DVec2) -> DVec2 {
    let turned = |k: usize| surface.period[k].map_or(0.0, |t| ((near[k] - uv[k]) / t).round() * t);
    uv + DVec2::new(turned(0), turned(1))
}

/// Twice the signed area of a polygon.
fn area(corners: &[Corner]) -> f64 {
    let next = |i: usize| corners[(i + 1) % corners.len()].0;
    corners.iter().enumerate().map(|(i, c)| c.0.perp_dot(next(i))).sum()
}

/// Whether `p` lies within a polygon.
fn is_within(corners: &[Corner], p: DVec2) -> bool {
    let mut within = false;
    for (i, (a, _)) in corners.iter().enumerate() {
        let b = corners[(i + 1) % corners.len()].0;
        if (a.y > p.y) != (b.y > p.y) && p.x < a.x + (p.y - a.y) / (b.y - a.y) * (b.x - a.x) {
            within = !within;
        }
    }
    within
}

/// Polygons between loops that run around the surface in direction `k`: each two that face each other, or one and the
/// pole that it faces.
fn bands(
    surface: &Surface,
    rings: Vec<Run>,
    k: usize,
    own: &mut Own,
    polygons: &mut Vec<Vec<Corner>>,
) -> Result<(), &'static str> {
    let Some(period) = surface.period[k] else { return Err("a boundary does not close") };
    // With u to the right the material is above a loop that runs right. With v around, u rises downwards.
    let sense = if k == 0 { 1 } else { -1 };
    let across = 1 - k;
    let mut lower: Vec<Run> = Vec::new();
    let mut upper: Vec<Run> = Vec::new();
    for ring in rings {
        match ring.turns[k] * sense {
            1 => lower.push(ring),
            -1 => upper.push(ring),
            _ => return Err("a boundary winds around the surface more than once"),
        }
    }
    let level = |r: &Run| r.corners.iter().map(|c| c.0[across]).sum::<f64>() / r.corners.len() as f64;
    let by_level = |a: &Run, b: &Run| level(a).total_cmp(&level(b));
    lower.sort_by(by_level);
    upper.sort_by(by_level);
    if lower.len() + upper.len() == 1 {
        let (ring, end) = match lower.pop() {
            Some(ring) => (ring, 1),
            None => (upper.remove(0), 0),
        };
        let pole = if k == 0 { surface.poles[end] } else { None };
        let Some(pole) = pole else { return Err("a boundary runs around the surface and nothing bounds it across") };
        polygons.push(to_pole(surface, &ring, period, pole, own));
        return Ok(());
    }
    if lower.len() != upper.len() {
        return Err("its boundaries around the surface do not pair");
    }
    // On a surface closed across as well, the first upper loop may belong below the first lower one.
    if let (Some(round), Some(low), Some(high)) = (surface.period[across], lower.first(), upper.first())
        && level(high) < level(low)
    {
        let mut first = upper.remove(0);
        first.corners.iter_mut().for_each(|c| c.0[across] += round);
        upper.push(first);
    }
    for (low, high) in lower.iter().zip(&upper) {
        polygons.push(between(surface, [low, high], k, period, own));
    }
    Ok(())
}

/// The corners of a loop from number `from` on, once around and back to the same point, carried by its turn.
fn once_around(ring: &Run, from: usize, k: usize, period: f64) -> Vec<Corner> {
    let n = ring.corners.len();
    let turn = f64::from(ring.turns[k]) * period;
    (0..=n)
        .map(|i| {
            let (mut uv, id) = ring.corners[(from + i) % n];
            if from + i >= n {
                uv[k] += turn;
            }
            (uv, id)
        })
        .collect()
}

/// The polygon between two loops around the surface.
fn between(surface: &Surface, [low, high]: [&Run; 2], k: usize, period: f64, own: &mut Own) -> Vec<Corner> {
    // The seam leads between the two corners that lie most nearly across from each other.
    let across = |a: DVec2, b: DVec2| {
        let off = (a[k] - b[k]).rem_euclid(period);
        off.min(period - off)
    };
    let from = 0;
    let start = low.corners[from].0;
    let order = |i: &usize, j: &usize| across(start, high.corners[*i].0).total_cmp(&across(start, high.corners[*j].0));
    let to = (0..high.corners.len()).min_by(order).unwrap_or(0);
    let mut polygon = once_around(low, from, k, period);
    let mut back = once_around(high, to, k, period);
    let end = polygon[polygon.len() - 1].0;
    let by = ((end[k] - back[0].0[k]) / period).round() * period;
    back.iter_mut().for_each(|c| c.0[k] += by);
    let seam = seam(surface, end, back[0].0, own);
    let turn = polygon[0].0 - end;
    polygon.extend(&seam);
    polygon.extend(back);
    polygon.extend(seam.iter().rev().map(|(uv, id)| (*uv + turn, *id)));
    polygon
}

/// The polygon between a loop around the surface and a pole.
fn to_pole(surface: &Surface, ring: &Run, period: f64, pole: f64, own: &mut Own) -> Vec<Corner> {
    let mut polygon = once_around(ring, 0, 0, period);
    let (start, end) = (polygon[0].0, polygon[polygon.len() - 1].0);
    let seam = seam(surface, end, DVec2::new(end.x, pole), own);
    let tip = own.add(surface.point(DVec2::new(end.x, pole)));
    polygon.extend(&seam);
    polygon.extend(at_pole(end.x, start.x, period).map(|u| (DVec2::new(u, pole), tip)));
    polygon.extend(seam.iter().rev().map(|(uv, id)| (*uv + start - end, *id)));
    polygon
}

/// Parameters at which the single point of a pole is taken for corners of triangles, from one to another.
fn at_pole(from: f64, to: f64, period: f64) -> impl Iterator<Item = f64> {
    let parts = (16.0 * (to - from).abs() / period).ceil().clamp(1.0, 32.0);
    (0..=parts as u32).map(move |i| from + (to - from) * f64::from(i) / parts)
}

/// Points of a seam between two places, the ends not among them.
fn seam(surface: &Surface, from: DVec2, to: DVec2, own: &mut Own) -> Vec<Corner> {
    let place = |i: u32, n: u32| from.lerp(to, f64::from(i) / f64::from(n));
    let is_fine = |n: &u32| {
        let at = |i: u32| surface.point(place(i, 2 * n));
        (0..*n).all(|i| own.fine.allows(at(2 * i), at(2 * i + 2), at(2 * i + 1)))
    };
    // One more halving than asked for makes the triangles beside the seam as fine as the others.
    let n =
        (0..SEAM_HALVINGS).map(|k| 1 << k).find(is_fine).map_or(1 << SEAM_HALVINGS, |n| if n == 1 { 1 } else { 2 * n });
    (1..n).map(|i| (place(i, n), own.add(surface.point(place(i, n))))).collect()
}

/// The polygon of a surface without boundary.
fn whole(surface: &Surface, own: &mut Own) -> Option<Vec<Corner>> {
    let period = surface.period[0]?;
    let start = |k: usize| if let Shape::Nurbs(s) = &surface.shape { s.domain()[k][0] } else { 0.0 };
    let [low, high] = match (surface.poles, surface.period[1]) {
        ([Some(low), Some(high)], _) => [low, high],
        (_, round) => [start(1), start(1) + round?],
    };
    let at = |u: f64, v: f64| DVec2::new(start(0) + u * period, v);
    let tip = own.add(surface.point(at(0.0, low)));
    let up = seam(surface, at(1.0, low), at(1.0, high), own);
    let (top, right) = match surface.period[1] {
        Some(_) => (tip, seam(surface, at(0.0, low), at(1.0, low), own)),
        None => (own.add(surface.point(at(0.0, high))), Vec::new()),
    };
    let lift = DVec2::new(0.0, high - low);
    let mut polygon = Vec::new();
    if surface.period[1].is_some() {
        polygon.push((at(0.0, low), tip));
        polygon.extend(&right);
        polygon.push((at(1.0, low), tip));
        polygon.extend(&up);
        polygon.push((at(1.0, high), top));
        polygon.extend(right.iter().rev().map(|(uv, id)| (*uv + lift, *id)));
        polygon.push((at(0.0, high), top));
    } else {
        polygon.extend(at_pole(0.0, 1.0, 1.0).map(|u| (at(u, low), tip)));
        polygon.extend(&up);
        polygon.extend(at_pole(1.0, 0.0, 1.0).map(|u| (at(u, high), top)));
    }
    polygon.extend(up.iter().rev().map(|(uv, id)| (*uv - DVec2::new(period, 0.0), *id)));
    Some(polygon)
}

/// Adds the loops that run around nothing: the outer boundary of the face, and its holes, each carried by whole turns to
/// where it lies within the rest.
fn add_rest(surface: &Surface, mut rest: Vec<Run>, polygons: &mut Vec<Vec<Corner>>) {
    rest.sort_by(|a, b| area(&b.corners).abs().total_cmp(&area(&a.corners).abs()));
    for mut run in rest {
        if let Some(outer) = polygons.first() {
            let turns = |k: usize| match surface.period[k] {
                Some(period) => [0.0, -1.0, 1.0, -2.0, 2.0].map(|i| i * period).to_vec(),
                None => vec![0.0],
            };
            let p = run.corners[0].0;
            let places = turns(0).into_iter().flat_map(|u| turns(1).into_iter().map(move |v| DVec2::new(u, v)));
            if let Some(by) = places.into_iter().find(|by| is_within(outer, p + *by)) {
                run.corners.iter_mut().for_each(|c| c.0 += by);
            }
        }
        polygons.push(run.corners);
    }
}
