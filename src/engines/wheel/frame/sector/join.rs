//! The two ends of a slab between half-planes through the axis, joined so that turned copies of it close.

use std::collections::{BTreeMap, HashMap, HashSet};

use glam::{DMat3, DVec2, DVec3, Vec3Swizzles as _};

use geometry::mesh::Mesh;

/// Most vertices of the outlines of an end: more than any sector has, and few enough to be compared.
const MOST_OUTLINE: usize = 20_000;

/// A closed line of open edges in a half-plane, as the triangles of the lower end have them: that of the upper end is
/// turned round.
struct Outline {
    vertices: Vec<u32>,
    /// Places of the vertices in the half-plane: along the axis and away from it.
    places: Vec<DVec2>,
}

impl Outline {
    /// Place and length of the way (mm) from vertex `from` over `steps` edges, for each vertex on it.
    fn way(&self, from: usize, steps: usize) -> Vec<(usize, DVec2, f64)> {
        let n = self.places.len();
        let (mut way, mut length) = (Vec::with_capacity(steps + 1), 0.0);
        for step in 0..=steps {
            let (i, last) = ((from + step) % n, (from + step + n - 1) % n);
            length += if step > 0 { self.places[i].distance(self.places[last]) } else { 0.0 };
            way.push((i, self.places[i], length));
        }
        way
    }
}

/// Reason why two ends are not joined: how far a place of the one is from the other (mm), and the place.
pub(super) type Mismatch = (f64, DVec2);

/// Joins the outlines of the slab at its two ends: answers for each vertex of the upper end the one of the lower that
/// takes its place, and how far they are moved for that (mm). Vertices that are near each other are one; the others are
/// put into the edges of the other end.
///
/// # Errors
/// [`Mismatch`].
pub(super) fn join(
    slab: &mut Mesh,
    ends: [f64; 2],
    on_cut: f64,
    joint: f64,
) -> Result<(HashMap<u32, u32>, f64), Mismatch> {
    let angle = ends[1] - ends[0];
    let [lower, upper] = [outlines(slab, ends[0], on_cut, false)?, outlines(slab, ends[1], on_cut, true)?];
    let points = |outlines: &[Outline]| -> Vec<(usize, usize, DVec2)> {
        let of = |(k, outline): (usize, &Outline)| -> Vec<(usize, usize, DVec2)> {
            outline.places.iter().enumerate().map(|(i, p)| (k, i, *p)).collect()
        };
        outlines.iter().enumerate().flat_map(of).collect()
    };
    let (of_lower, of_upper) = (points(&lower), points(&upper));
    let nearest = |points: &[(usize, usize, DVec2)], p: DVec2| {
        let off = points.iter().map(|(k, i, q)| (q.distance_squared(p), *k, *i));
        off.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(off, k, i)| (off.sqrt(), k, i))
    };
    let mut partners = HashMap::new();
    let mut put: HashMap<[u32; 2], Vec<(f64, u32)>> = HashMap::new();
    let mut joined = HashSet::new();
    let mut shift: f64 = 0.0;
    if of_lower.len().max(of_upper.len()) > MOST_OUTLINE {
        return Err((f64::INFINITY, of_lower.first().map_or(DVec2::ZERO, |(.., p)| *p)));
    }
    for (k, outline) in lower.iter().enumerate() {
        // Each other's nearest.
        let mutual = |(i, p): (usize, &DVec2)| {
            let (off, other, j) = nearest(&of_upper, *p)?;
            let (_, back, own) = nearest(&of_lower, upper[other].places[j])?;
            (off <= joint && (back, own) == (k, i)).then_some((i, other, j))
        };
        let anchors: Vec<(usize, usize, usize)> = outline.places.iter().enumerate().filter_map(mutual).collect();
        let apart = || {
            let off = outline.places.iter().map(|p| (distance(&upper, *p), *p));
            off.max_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or((f64::INFINITY, DVec2::ZERO))
        };
        let Some(&(first, other, start)) = anchors.first() else { return Err(apart()) };
        let (upper, n) = (&upper[other], upper[other].places.len());
        if !joined.insert(other) {
            return Err(apart());
        }
        let ahead = anchors.iter().filter(|a| a.1 == other).map(|(i, _, j)| (i - first, (j + n - start) % n));
        let mut anchors = rising(&ahead.collect::<Vec<_>>());
        anchors.push((outline.places.len(), n));
        for pair in anchors.windows(2) {
            let ((i, j), (to_i, to_j)) = (pair[0], pair[1]);
            let (v, w) = ((start + j) % n, (first + i) % outline.places.len());
            partners.insert(upper.vertices[v], outline.vertices[w]);
            shift = shift.max(upper.places[v].distance(outline.places[w]));
            let ways = [outline.way(first + i, to_i - i), upper.way(start + j, to_j - j)];
            let [own, theirs] = &ways;
            for (v, p, share, edge) in placed_between(theirs, own) {
                let at = slab.vertices.len() as u32;
                let [from, to] = edge.map(|e| outline.vertices[e]);
                let [a, b] = [from, to].map(|v| slab.vertices[v as usize]);
                let new = a.lerp(b, share.1);
                let off = DVec2::new(new.x, new.yz().length()).distance(p);
                if off > 2.0 * joint {
                    return Err((off, p));
                }
                shift = shift.max(off);
                slab.vertices.push(new);
                put.entry([from, to]).or_default().push((share.0, at));
                partners.insert(upper.vertices[v], at);
            }
            for (v, p, share, edge) in placed_between(own, theirs) {
                let at = slab.vertices.len() as u32;
                // The other way round again.
                let [to, from] = edge.map(|e| upper.vertices[e]);
                let off = upper.places[edge[0]].lerp(upper.places[edge[1]], share.1).distance(p);
                if off > 2.0 * joint {
                    return Err((off, p));
                }
                shift = shift.max(off);
                let own = outline.vertices[v];
                slab.vertices.push(DMat3::from_rotation_x(angle) * slab.vertices[own as usize]);
                put.entry([from, to]).or_default().push((-share.0, at));
                partners.insert(at, own);
            }
        }
    }
    if let Some((k, _)) = upper.iter().enumerate().find(|(k, _)| !joined.contains(k)) {
        let p = upper[k].places[0];
        return Err((distance(&lower, p), p));
    }
    split_edges(slab, put);
    Ok((partners, shift))
}

/// Distance of a place from the nearest outline (mm).
fn distance(outlines: &[Outline], p: DVec2) -> f64 {
    let to_edge = |a: DVec2, b: DVec2| {
        let along = b - a;
        let share = ((p - a).dot(along) / along.length_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
        p.distance(a + share * along)
    };
    let edges =
        outlines.iter().flat_map(|o| (0..o.places.len()).map(|i| (o.places[i], o.places[(i + 1) % o.places.len()])));
    edges.map(|(a, b)| to_edge(a, b)).fold(f64::INFINITY, f64::min)
}

/// The greatest part of `pairs`, which rise in the first number, that rises in the second as well; it holds the first.
fn rising(pairs: &[(usize, usize)]) -> Vec<(usize, usize)> {
    let mut best: Vec<(usize, Option<usize>)> = Vec::new();
    for (i, (_, j)) in pairs.iter().enumerate() {
        let before = (0..i).filter(|k| pairs[*k].1 < *j && best[*k].0 > 0).max_by_key(|k| (best[*k].0, *k));
        // Whatever does not come after the first is nothing.
        best.push(match before {
            None if i > 0 => (0, None),
            before => (before.map_or(0, |k| best[k].0) + 1, before),
        });
    }
    let mut at = (0..best.len()).max_by_key(|i| best[*i].0);
    let mut found = Vec::new();
    while let Some(i) = at {
        found.push(pairs[i]);
        at = best[i].1;
    }
    found.reverse();
    found
}

/// The vertices of a way between its ends, each with its place, the edge of `other` in which as large a share of that way
/// lies behind it, that share, and the share of the edge.
type Between = (usize, DVec2, (f64, f64), [usize; 2]);

fn placed_between(way: &[(usize, DVec2, f64)], other: &[(usize, DVec2, f64)]) -> Vec<Between> {
    let [length, others] = [way, other].map(|way| way.last().map_or(0.0, |end| end.2).max(f64::MIN_POSITIVE));
    let inner = way.iter().skip(1).take(way.len().saturating_sub(2));
    let find = |(v, p, at): &(usize, DVec2, f64)| {
        let share = at / length;
        let edge = other.windows(2).find(|edge| edge[1].2 >= share * others).or(other.windows(2).last())?;
        let [from, to] = [edge[0].2, edge[1].2];
        let within = ((share * others - from) / (to - from).max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
        Some((*v, *p, (share, within), [edge[0].0, edge[1].0]))
    };
    inner.filter_map(find).collect()
}

/// The closed lines of open edges of the slab in the half-plane at `theta` (rad), turned round if `is_upper`; `on_cut`
/// as in [`Sector`].
///
/// # Errors
/// [`Mismatch`], where such edges are no closed lines.
fn outlines(slab: &Mesh, theta: f64, on_cut: f64, is_upper: bool) -> Result<Vec<Outline>, Mismatch> {
    let around = DVec3::new(0.0, -theta.cos(), -theta.sin());
    let lies = |v: u32| around.dot(slab.vertices[v as usize]).abs() <= on_cut;
    let place = |v: u32| {
        let p = slab.vertices[v as usize];
        DVec2::new(p.x, p.yz().length())
    };
    let all = slab.directed_edges();
    let (mut next, mut reached) = (BTreeMap::new(), HashSet::new());
    let sides = slab.triangles.iter().flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)]);
    for (a, b) in sides.filter(|(a, b)| !all.contains_key(&(*b, *a)) && lies(*a) && lies(*b)) {
        let (from, to) = if is_upper { (b, a) } else { (a, b) };
        if next.insert(from, to).is_some() {
            return Err((0.0, place(from)));
        }
        reached.insert(to);
    }
    let mut found = Vec::new();
    // The outline of a sector without a bore begins and ends on the axis, where nothing is left of its edge.
    let begins: Vec<u32> = next.keys().filter(|v| !reached.contains(v)).copied().collect();
    let mut begins = begins.into_iter();
    while let Some(start) = begins.next().or_else(|| next.first_key_value().map(|(v, _)| *v)) {
        let (mut vertices, mut at) = (Vec::new(), start);
        while let Some(to) = next.remove(&at) {
            vertices.push(at);
            at = to;
        }
        if at != start {
            if [start, at].iter().any(|v| place(*v).y > on_cut) {
                return Err((f64::INFINITY, place(at)));
            }
            vertices.push(at);
        }
        let places = vertices.iter().map(|v| place(*v)).collect();
        found.push(Outline { vertices, places });
    }
    Ok(found)
}

/// Puts vertices into open edges, each with its order along its edge.
fn split_edges(slab: &mut Mesh, mut put: HashMap<[u32; 2], Vec<(f64, u32)>>) {
    let mut i = 0;
    // What is added is looked at as well: a triangle may have two such edges.
    while i < slab.triangles.len() {
        let t = slab.triangles[i];
        let side = (0..3).find_map(|k| put.remove(&[t[k], t[(k + 1) % 3]]).map(|points| (k, points)));
        let Some((k, mut points)) = side else {
            i += 1;
            continue;
        };
        points.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let (from, to, apex) = (t[k], t[(k + 1) % 3], t[(k + 2) % 3]);
        let chain: Vec<u32> = std::iter::once(from).chain(points.iter().map(|p| p.1)).chain([to]).collect();
        slab.triangles[i] = [chain[0], chain[1], apex];
        slab.triangles.extend(chain.windows(2).skip(1).map(|w| [w[0], w[1], apex]));
    }
}
