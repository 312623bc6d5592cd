//! Triangles of a face.
//!
//! The parameter plane is stretched, each direction by itself, until a step of one in either direction leaves the surface
//! by no more than is allowed. There the boundary and a grid of points make a constrained Delaunay triangulation, to which
//! points are added where its triangles still leave the surface too far.

use std::collections::{HashMap, HashSet, VecDeque};

use geometry::nurbs::NurbsCurve;
use glam::{DVec2, DVec3};
use spade::handles::FixedVertexHandle;
use spade::{ConstrainedDelaunayTriangulation, HasPosition, Point2, Triangulation};

use super::Fineness;
use super::domain::{Corner, Domain, OWN};
use super::surface::{Shape, Surface};
use task::Cancel;

/// Triangles of a face; corners from [`OWN`] on are its own points.
#[derive(Debug, Default)]
pub(super) struct FaceMesh {
    /// Points of the face alone.
    pub own: Vec<DVec3>,
    /// Counter-clockwise around the side to which `du x dv` points.
    pub triangles: Vec<[u32; 3]>,
    /// Whether the triangles leave the surface by no more than is allowed.
    pub is_fine: bool,
    /// Sides of the boundary that are too long for that.
    pub coarse_sides: Vec<[u32; 2]>,
    /// Guides of a ruled surface over the face; see [`geometry::segmentation::KnownFace`].
    pub guides: Vec<[NurbsCurve; 2]>,
}

/// Longest step along a direction, as a multiple of that across: longer triangles are hard to measure.
const LONGEST: f64 = 24.0;
/// How near the boundary, in steps, no point of the grid is put.
const MARGIN: f64 = 0.4;
/// Rounds of refinement.
const ROUNDS: usize = 24;

/// A corner of the triangulation, in stretched parameters.
#[derive(Debug, Clone, Copy)]
struct Place {
    at: Point2<f64>,
    id: u32,
}

impl HasPosition for Place {
    type Scalar = f64;
    fn position(&self) -> Point2<f64> {
        self.at
    }
}

type Delaunay = ConstrainedDelaunayTriangulation<Place>;

/// A stretched direction: steps counted along it.
#[derive(Debug, Clone)]
struct Stretch {
    /// Parameters, rising.
    at: Vec<f64>,
    /// Steps up to each of them.
    steps: Vec<f64>,
}

impl Stretch {
    /// Steps up to the parameter `x`.
    fn to(&self, x: f64) -> f64 {
        interpolate(&self.at, &self.steps, x)
    }

    /// The parameter after `s` steps.
    fn back(&self, s: f64) -> f64 {
        interpolate(&self.steps, &self.at, s)
    }
}

/// Value at `x` of the polyline through (`xs`, `ys`); beyond the ends its first and last pieces continue.
fn interpolate(xs: &[f64], ys: &[f64], x: f64) -> f64 {
    let i = xs.partition_point(|a| *a <= x).clamp(1, xs.len() - 1);
    ys[i - 1] + (x - xs[i - 1]) / (xs[i] - xs[i - 1]) * (ys[i] - ys[i - 1])
}

/// Results of earlier rounds of refinement.
#[derive(Default)]
struct Known {
    /// Points of the surface at its vertices.
    points: Vec<DVec3>,
    /// Sides that leave the surface by no more than is allowed.
    fine_sides: HashSet<[usize; 2]>,
    /// Triangles, by their vertices in rising order, that do so.
    fine_triangles: HashSet<[usize; 3]>,
}

/// What a triangulation is made from.
struct Ground<'a> {
    surface: &'a Surface,
    domain: &'a Domain,
    stretch: [Stretch; 2],
    fine: &'a Fineness,
    cancel: &'a Cancel,
}

/// The triangles of the `domain` of a face, with no more than `most` points within.
///
/// # Errors
/// The reason why there are none: boundaries that cross, at this fineness of their points.
pub(super) fn triangulate(
    surface: &Surface,
    domain: &Domain,
    (most, fine): (usize, &Fineness),
    cancel: &Cancel,
) -> Result<FaceMesh, &'static str> {
    let ground = Ground { surface, domain, stretch: stretches(surface, domain, fine), fine, cancel };
    let mut net = Delaunay::new();
    let walls = ground.boundary(&mut net)?;
    let mut own = domain.own.clone();
    if matches!(surface.shape, Shape::Plane(_)) {
        let triangles = inside(&net, &walls);
        return Ok(FaceMesh { own, triangles: ids(&net, &triangles), is_fine: true, ..FaceMesh::default() });
    }
    let coarse_sides = ground.coarse_sides();
    ground.add_all(&mut net, ground.grid(most)?, &mut own)?;
    // Sides of the boundary are as fine as their edges.
    let mut known = Known { fine_sides: walls.clone(), ..Known::default() };
    for _ in 0..ROUNDS {
        let triangles = inside(&net, &walls);
        let missing = ground.missing(&net, &triangles, &mut known)?;
        if missing.is_empty() || own.len() + missing.len() > most {
            let is_fine = missing.is_empty();
            let guides = surface.guides(domain.range());
            return Ok(FaceMesh { own, triangles: ids(&net, &triangles), is_fine, coarse_sides, guides });
        }
        ground.add_all(&mut net, missing, &mut own)?;
    }
    let triangles = inside(&net, &walls);
    Ok(FaceMesh { own, triangles: ids(&net, &triangles), is_fine: false, coarse_sides, guides: Vec::new() })
}

/// Point numbers of triangles. Those at a pole that have collapsed are left out.
fn ids(net: &Delaunay, triangles: &[[FixedVertexHandle; 3]]) -> Vec<[u32; 3]> {
    let ids = triangles.iter().map(|t| t.map(|v| net.vertex(v).data().id));
    ids.filter(|[a, b, c]| a != b && b != c && c != a).collect()
}

/// Two corners in an order of their own.
fn side(a: FixedVertexHandle, b: FixedVertexHandle) -> [usize; 2] {
    [a.index().min(b.index()), a.index().max(b.index())]
}

/// The triangles within an odd number of walls.
fn inside(net: &Delaunay, walls: &HashSet<[usize; 2]>) -> Vec<[FixedVertexHandle; 3]> {
    let mut is_inside: Vec<Option<bool>> = vec![None; net.num_all_faces()];
    let outer = net.outer_face().fix();
    is_inside[outer.index()] = Some(false);
    let mut queue = VecDeque::new();
    for edge in net.convex_hull() {
        queue.push_back((edge.rev().fix(), false));
        queue.push_back((edge.fix(), false));
    }
    // Each entry is a side and whether the face on its right is inside.
    let mut found = Vec::new();
    while let Some((edge, is_right)) = queue.pop_front() {
        let edge = net.directed_edge(edge);
        let Some(face) = edge.face().as_inner() else { continue };
        if is_inside[face.fix().index()].is_some() {
            continue;
        }
        let within = is_right != walls.contains(&side(edge.from().fix(), edge.to().fix()));
        is_inside[face.fix().index()] = Some(within);
        if within {
            found.push(face.vertices().map(|v| v.fix()));
        }
        queue.extend(face.adjacent_edges().map(|e| (e.rev().fix(), within)));
    }
    found
}

impl Ground<'_> {
    /// Parameters of a place of the triangulation.
    fn uv(&self, at: DVec2) -> DVec2 {
        DVec2::new(self.stretch[0].back(at.x), self.stretch[1].back(at.y))
    }

    /// Looks at the flag every so many items: a few milliseconds of work.
    fn tick(&self, item: usize) -> Result<(), &'static str> {
        if item.is_multiple_of(ITEMS_PER_CHECK) && self.cancel.check().is_err() { Err(CANCELLED) } else { Ok(()) }
    }

    /// Adds points of the face alone.
    fn add_all(&self, net: &mut Delaunay, all: Vec<DVec2>, own: &mut Vec<DVec3>) -> Result<(), &'static str> {
        all.into_iter().enumerate().try_for_each(|(i, at)| {
            self.tick(i)?;
            self.add(net, at, own)
        })
    }

    /// Adds a point of the face alone.
    fn add(&self, net: &mut Delaunay, at: DVec2, own: &mut Vec<DVec3>) -> Result<(), &'static str> {
        let id = OWN + own.len() as u32;
        let count = net.num_vertices();
        net.insert(Place { at: Point2::new(at.x, at.y), id }).map_err(|_| OUT_OF_RANGE)?;
        if net.num_vertices() > count {
            own.push(self.surface.point(self.uv(at)));
        }
        Ok(())
    }

    /// Puts the boundary into the triangulation. Sides that are passed an odd number of times bound the face.
    fn boundary(&self, net: &mut Delaunay) -> Result<HashSet<[usize; 2]>, &'static str> {
        let mut sides: HashMap<[usize; 2], (FixedVertexHandle, FixedVertexHandle, usize)> = HashMap::new();
        let mut order = Vec::new();
        let mut at_place: HashMap<[u64; 2], FixedVertexHandle> = HashMap::new();
        for polygon in &self.domain.polygons {
            let mut corners = Vec::with_capacity(polygon.len());
            for (i, (uv, id)) in polygon.iter().enumerate() {
                self.tick(i)?;
                let at = Point2::new(self.stretch[0].to(uv.x), self.stretch[1].to(uv.y));
                let key = [at.x.to_bits(), at.y.to_bits()];
                let handle = match at_place.get(&key) {
                    Some(handle) => *handle,
                    None => net.insert(Place { at, id: *id }).map_err(|_| OUT_OF_RANGE)?,
                };
                at_place.insert(key, handle);
                corners.push(handle);
            }
            for (i, from) in corners.iter().enumerate() {
                let to = corners[(i + 1) % corners.len()];
                if *from != to {
                    let key = side(*from, to);
                    sides
                        .entry(key)
                        .or_insert_with(|| {
                            order.push(key);
                            (*from, to, 0)
                        })
                        .2 += 1;
                }
            }
        }
        let mut passed: HashMap<[usize; 2], usize> = HashMap::new();
        for (i, (from, to, times)) in order.iter().map(|key| sides[key]).enumerate() {
            self.tick(i)?;
            let edges = net.try_add_constraint(from, to);
            if edges.is_empty() {
                return Err(CROSSES);
            }
            for edge in edges {
                let [a, b] = net.directed_edge(edge).vertices();
                *passed.entry(side(a.fix(), b.fix())).or_insert(0) += times;
            }
        }
        Ok(passed.into_iter().filter(|(_, times)| times % 2 == 1).map(|(side, _)| side).collect())
    }

    /// Points of a grid with steps of one that lie within the face and not beside its boundary.
    fn grid(&self, most: usize) -> Result<Vec<DVec2>, &'static str> {
        let stretched = |c: &Corner| DVec2::new(self.stretch[0].to(c.0.x), self.stretch[1].to(c.0.y));
        let polygons: Vec<Vec<DVec2>> =
            self.domain.polygons.iter().map(|p| p.iter().map(stretched).collect()).collect();
        let all = || polygons.iter().flatten();
        let low = all().fold(DVec2::INFINITY, |a, b| a.min(*b));
        let high = all().fold(DVec2::NEG_INFINITY, |a, b| a.max(*b));
        let size = high - low;
        let is_countable = size.x * size.y <= most as f64;
        if !is_countable {
            return Ok(Vec::new());
        }
        let [columns, rows] = [size.x.ceil().max(1.0), size.y.ceil().max(1.0)];
        let step = size / DVec2::new(columns, rows);
        let mut found = Vec::new();
        for row in 1..rows as usize {
            self.cancel.check().map_err(|_| CANCELLED)?;
            let y = low.y + step.y * row as f64;
            let spans = [y - MARGIN, y, y + MARGIN].map(|y| spans(&polygons, y));
            let is_clear = |x: f64| spans.iter().all(|s| s.iter().any(|[a, b]| x - MARGIN > *a && x + MARGIN < *b));
            // Rows are shifted against each other by half a step, so that on twisted surfaces errors of diagonals cancel.
            let shift = if row % 2 == 0 { 0.0 } else { 0.5 };
            let places = (0..columns as usize).map(|column| low.x + step.x * (column as f64 + shift));
            found.extend(places.filter(|x| is_clear(*x)).map(|x| DVec2::new(x, y)));
        }
        Ok(found)
    }

    /// Distance of the surface at `uv` from a point beside it, along its normal; in any direction where it has none.
    ///
    /// A narrow triangle along a curved edge has a normal of its own that tells nothing.
    fn off(&self, beside: DVec3, uv: DVec2) -> f64 {
        let [p, du, dv] = self.surface.at(uv);
        match du.cross(dv).try_normalize() {
            Some(normal) => (p - beside).dot(normal).abs(),
            None => p.distance(beside),
        }
    }

    /// Whether the surface at `uv` is farther from the place at a share of the chord between two points than is allowed,
    /// along its normal.
    fn leaves(&self, ends: [DVec3; 2], uv: DVec2, share: f64) -> bool {
        self.off(ends[0].lerp(ends[1], share), uv) > self.fine.chord
    }

    /// Sides of the boundary, between which the face leaves its triangles by more than is allowed.
    fn coarse_sides(&self) -> Vec<[u32; 2]> {
        let mut found = Vec::new();
        for polygon in &self.domain.polygons {
            for (i, (from, a)) in polygon.iter().enumerate() {
                let (to, b) = polygon[(i + 1) % polygon.len()];
                let ends = [*from, to].map(|uv| self.surface.point(uv));
                let is_long = ends[0].distance(ends[1]) > 4.0 * self.fine.least_length;
                let is_shared = *a < OWN && b < OWN;
                // The middle alone does not see an edge that bends to and fro.
                let leaves = |share: f64| self.leaves(ends, from.lerp(to, share), share);
                if is_long && is_shared && [0.25, 0.5, 0.75].into_iter().any(leaves) {
                    found.push([*a, b]);
                }
            }
        }
        found
    }

    /// Places where triangles leave the surface by more than is allowed. What was found fine before is not measured again.
    fn missing(
        &self,
        net: &Delaunay,
        triangles: &[[FixedVertexHandle; 3]],
        known: &mut Known,
    ) -> Result<Vec<DVec2>, &'static str> {
        let place = |v: FixedVertexHandle| {
            let p = net.vertex(v).position();
            DVec2::new(p.x, p.y)
        };
        for n in known.points.len()..net.num_vertices() {
            self.tick(n)?;
            known.points.push(self.surface.point(self.uv(place(FixedVertexHandle::from_index(n)))));
        }
        let mut coarse: HashSet<[usize; 2]> = HashSet::new();
        let mut found = Vec::new();
        for (i, t) in triangles.iter().enumerate() {
            self.tick(i)?;
            let mut key = t.map(|v| v.index());
            key.sort_unstable();
            if known.fine_triangles.contains(&key) {
                continue;
            }
            let points = t.map(|v| known.points[v.index()]);
            let mut is_fine = true;
            for (i, j) in [(0, 1), (1, 2), (2, 0)] {
                let key = side(t[i], t[j]);
                // Shorter sides would follow the surface's own faults.
                if known.fine_sides.contains(&key) || points[i].distance(points[j]) <= self.fine.least_length {
                    continue;
                }
                if coarse.contains(&key) {
                    is_fine = false;
                    continue;
                }
                let middle = 0.5 * (place(t[i]) + place(t[j]));
                if self.leaves([points[i], points[j]], self.uv(middle), 0.5) {
                    coarse.insert(key);
                    found.push(middle);
                    is_fine = false;
                } else {
                    known.fine_sides.insert(key);
                }
            }
            if !is_fine {
                continue;
            }
            let middle = (place(t[0]) + place(t[1]) + place(t[2])) / 3.0;
            let is_long = points[0].distance(points[1]).max(points[0].distance(points[2])) > self.fine.least_length;
            let off = self.off((points[0] + points[1] + points[2]) / 3.0, self.uv(middle));
            if is_long && off > self.fine.chord {
                found.push(middle);
            } else {
                known.fine_triangles.insert(key);
            }
        }
        Ok(found)
    }
}

/// Reason why a face has no triangles, which finer points of its edges may help.
pub(super) const CROSSES: &str = "its boundary crosses itself";
/// Reason why a face has no triangles when told to stop.
pub(super) const CANCELLED: &str = "cancelled";
/// How many items are handled between two looks at the flag.
const ITEMS_PER_CHECK: usize = 256;
const OUT_OF_RANGE: &str = "its parameters are out of range";

/// Stretches along the line at height `y` that lie within an odd number of polygons.
fn spans(polygons: &[Vec<DVec2>], y: f64) -> Vec<[f64; 2]> {
    let mut crossings = Vec::new();
    for polygon in polygons {
        for (i, a) in polygon.iter().enumerate() {
            let b = polygon[(i + 1) % polygon.len()];
            if (a.y > y) != (b.y > y) {
                crossings.push(a.x + (y - a.y) / (b.y - a.y) * (b.x - a.x));
            }
        }
    }
    crossings.sort_by(f64::total_cmp);
    crossings.chunks_exact(2).map(|c| [c[0], c[1]]).collect()
}

/// The stretches of both directions over the domain.
fn stretches(surface: &Surface, domain: &Domain, fine: &Fineness) -> [Stretch; 2] {
    let [low, high] = domain.range();
    // No direction is empty.
    let high = high.max(low + 1e-12 * (1.0 + low.abs()));
    if matches!(surface.shape, Shape::Plane(_)) {
        return [0, 1].map(|k| Stretch { at: vec![low[k], high[k]], steps: vec![1.0, 1.0 + high[k] - low[k]] });
    }
    let is_nurbs = matches!(surface.shape, Shape::Nurbs(_));
    let looks = [0, 1].map(|k| {
        let joints = surface.joints(k, [low[k], high[k]]);
        let parts = if !is_nurbs { 4 } else { (LOOKS / joints.len()).clamp(1, 4) };
        let mut looks: Vec<f64> = Vec::new();
        for w in joints.windows(2) {
            looks.extend((0..parts).map(|i| w[0] + (w[1] - w[0]) * (i as f64 + 0.5) / parts as f64));
        }
        looks
    });
    // Allowed steps of the parameters, and lengths of a step of one, at each look: the least across.
    let mut steps = [0, 1].map(|k| vec![f64::INFINITY; looks[k].len()]);
    let mut speeds = [0, 1].map(|k| vec![0.0f64; looks[k].len()]);
    let across = |k: usize| (looks[k].len() / MOST_ACROSS).max(1);
    let thin = [across(0), across(1)];
    for (i, u) in looks[0].iter().enumerate() {
        for (j, v) in looks[1].iter().enumerate() {
            if i % thin[0] != 0 && j % thin[1] != 0 {
                continue;
            }
            let found = allowed(surface, DVec2::new(*u, *v), 1e-3 * (high - low), fine);
            for ((k, n), (step, speed)) in [(0, i), (1, j)].into_iter().zip(found) {
                steps[k][n] = steps[k][n].min(step);
                speeds[k][n] = speeds[k][n].max(speed);
            }
        }
    }
    // Straight lines along a surface need no points: triangles of a wall between equal arcs stand as upright as the wall.
    let is_straight = matches!(surface.shape, Shape::Cylinder { .. } | Shape::Cone { .. });
    let longest = [0, 1].map(|k| {
        if is_straight && k == 1 {
            return f64::INFINITY;
        }
        // Beside a pole nothing moves around it, whatever the step.
        let moves = steps[1 - k].iter().zip(&speeds[1 - k]).filter(|(_, speed)| **speed > 0.0);
        let lengths = moves.map(|(step, speed)| step * speed);
        LONGEST * lengths.fold(f64::INFINITY, f64::min).max(fine.least_length)
    });
    [0, 1].map(|k| {
        let mut at = vec![low[k]];
        at.extend(looks[k].windows(2).map(|w| 0.5 * (w[0] + w[1])));
        at.push(high[k]);
        // Pieces of no width are none.
        let least = 1e-9 * (high[k] - low[k]);
        let mut widths: Vec<usize> = (0..looks[k].len()).filter(|n| at[n + 1] - at[*n] > least).collect();
        if widths.is_empty() {
            widths.push(0);
        }
        // Counted from one on: differences that are nothing but rounding are no places of their own then.
        let mut sum = 1.0;
        let mut counted = vec![sum];
        let mut kept = vec![low[k]];
        for n in widths {
            let speed = speeds[k][n].max(f64::MIN_POSITIVE);
            // No less than a thousandth of the whole direction, so that parameters stay apart.
            let step = steps[k][n].min(longest[k] / speed).clamp(1e-4 * (high[k] - low[k]), high[k] - low[k]);
            let from = kept[kept.len() - 1];
            let to = if at[n + 1] > from { at[n + 1] } else { high[k] };
            sum += (to - from) / step;
            counted.push(sum);
            kept.push(to);
        }
        Stretch { at: kept, steps: counted }
    })
}

/// Looks along a direction, about.
const LOOKS: usize = 48;
/// Looks across a direction at each of these, about.
const MOST_ACROSS: usize = 6;

/// The steps of both parameters at `uv` along which a patch leaves the surface by what is allowed, and the speeds there.
/// `by` are lengths over which the surface is looked at.
fn allowed(surface: &Surface, uv: DVec2, by: DVec2, fine: &Fineness) -> [(f64, f64); 2] {
    let here = surface.at(uv);
    let normal = here[1].cross(here[2]).normalize_or_zero();
    let speeds = [here[1].length(), here[2].length()];
    let ends = [DVec2::new(by.x, 0.0), DVec2::new(0.0, by.y)].map(|d| [surface.at(uv - d), surface.at(uv + d)]);
    let bend = |k: usize| ((ends[k][0][0] + ends[k][1][0] - 2.0 * here[0]).dot(normal) / (by[k] * by[k])).abs();
    let twist = ((ends[1][1][1] - ends[1][0][1]).dot(normal) / (2.0 * by.y)).abs();
    [0, 1].map(|k| {
        let (bend, speed, other) = (bend(k), speeds[k], speeds[1 - k]);
        // A chord over a step h of a curve with acceleration b leaves it by b h^2/8 and turns by b h over the speed. A
        // patch of steps h and k with the twist m leaves its corners by m h k/4; it is made as long as wide.
        let chord = if bend > 0.0 { (8.0 * fine.chord / bend).sqrt() } else { f64::INFINITY };
        let turn = if bend > 0.0 && speed > 0.0 { fine.turn * speed / bend } else { f64::INFINITY };
        let patch = (2.0 * fine.chord * other / (twist * speed)).sqrt();
        let patch = if twist > 0.0 && speed > 0.0 && other > 0.0 { patch } else { f64::INFINITY };
        (chord.min(turn).min(patch), speed)
    })
}
