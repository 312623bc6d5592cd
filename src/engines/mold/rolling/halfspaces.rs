//! The point of a polyhedron that is nearest to a given one.

use glam::DVec3;

/// All points `c` with `normal . c >= offset`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HalfSpace {
    /// Unit vector into it.
    pub normal: DVec3,
    /// Distance of its plane from the origin along `normal` (mm).
    pub offset: f64,
}

impl HalfSpace {
    /// How far `p` is inside (mm); negative outside.
    pub fn depth(&self, p: DVec3) -> f64 {
        self.normal.dot(p) - self.offset
    }
}

/// How far outside counts as inside (mm): rounding.
const ROUNDING: f64 = 1e-10;
/// Exchanges of planes after which the search gives up; each takes the point farther away, so that none comes twice.
const MOST_EXCHANGES: usize = 64;

/// The half-spaces whose planes hold the nearest point: a start for the next search among the same ones.
pub type Held = Vec<HalfSpace>;

/// The point of all `spaces` that is nearest to `p`; none if they have no point in common, or hardly one. `held` is
/// what held the nearest point of another `p`, or empty.
///
/// At most three planes hold it. Whenever a further plane is violated, the nearest point of the four is that of one to
/// three of them, the new one among them; this is the scheme of linear programming in few dimensions
/// (M. Sharir, E. Welzl, A combinatorial bound for linear programming and related problems, STACS 1992).
pub fn nearest(spaces: &[HalfSpace], p: DVec3, held: &mut Held) -> Option<DVec3> {
    let mut at = p;
    // What held another point may hold this one too: put in again one by one.
    let others = std::mem::take(held);
    for space in others.iter().filter(|_| others.len() < 4) {
        if space.depth(at) < -ROUNDING {
            held.push(*space);
            (at, *held) = nearest_of_few(held, p)?;
        }
    }
    for _ in 0..MOST_EXCHANGES {
        let worst = spaces.iter().map(|s| (s.depth(at), s)).fold(None, |worst: Option<(f64, &HalfSpace)>, next| {
            if worst.is_none_or(|w| next.0 < w.0) { Some(next) } else { worst }
        });
        let Some((_, worst)) = worst.filter(|w| w.0 < -ROUNDING) else { return Some(at) };
        held.push(*worst);
        (at, *held) = nearest_of_few(held, p)?;
    }
    None
}

/// The nearest point of at most four half-spaces of which the last one is violated without it, and those that hold it.
fn nearest_of_few(spaces: &[HalfSpace], p: DVec3) -> Option<(DVec3, Vec<HalfSpace>)> {
    let (last, others) = spaces.split_last()?;
    let mut best: Option<(f64, DVec3, u32)> = None;
    for subset in 0..1u32 << others.len() {
        if subset.count_ones() > 2 {
            continue;
        }
        let chosen = |i: usize| subset >> i & 1 == 1;
        let mut planes = others.iter().enumerate().filter(|(i, _)| chosen(*i)).map(|(_, s)| s);
        let at = match (planes.next(), planes.next()) {
            (None, _) => Some(on_plane(last, p)),
            (Some(a), None) => on_line(last, a, p),
            (Some(a), Some(b)) => corner(last, a, b),
        };
        let Some(at) = at else { continue };
        // A corner of nearly parallel planes is only as exact as they cross.
        let is_in = spaces.iter().all(|s| s.depth(at) >= -10.0 * ROUNDING);
        let off = at.distance_squared(p);
        if is_in && best.is_none_or(|(least, ..)| off < least) {
            best = Some((off, at, subset));
        }
    }
    let (_, at, subset) = best?;
    let kept = others.iter().enumerate().filter(|(i, _)| subset >> i & 1 == 1).map(|(_, s)| *s);
    Some((at, kept.chain([*last]).collect()))
}

fn on_plane(a: &HalfSpace, p: DVec3) -> DVec3 {
    p - a.normal * a.depth(p)
}

fn on_line(a: &HalfSpace, b: &HalfSpace, p: DVec3) -> Option<DVec3> {
    let cosine = a.normal.dot(b.normal);
    let sine_squared = a.normal.cross(b.normal).length_squared();
    if sine_squared < 1e-18 {
        return None;
    }
    let (da, db) = (a.depth(p), b.depth(p));
    Some(p - a.normal * ((da - cosine * db) / sine_squared) - b.normal * ((db - cosine * da) / sine_squared))
}

fn corner(a: &HalfSpace, b: &HalfSpace, c: &HalfSpace) -> Option<DVec3> {
    let (bc, ca, ab) = (b.normal.cross(c.normal), c.normal.cross(a.normal), a.normal.cross(b.normal));
    let volume = a.normal.dot(bc);
    (volume.abs() > 1e-9).then(|| (bc * a.offset + ca * b.offset + ab * c.offset) / volume)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn unit() -> impl Strategy<Value = DVec3> {
        prop::array::uniform3(-1.0..1.0f64).prop_map(DVec3::from).prop_filter_map("no direction", DVec3::try_normalize)
    }

    proptest! {
        /// The nearest point lies in all half-spaces, and no point of them lies beyond the plane through it, square to
        /// the way there: the way is a sum of normals of planes that hold it.
        #[test]
        fn nothing_nearer_is_in_all_of_them(
            normals in prop::collection::vec((unit(), -1.0..0.9f64), 1..12), p in prop::array::uniform3(-3.0..3.0f64),
            others in prop::collection::vec(prop::array::uniform3(-2.0..2.0f64), 50),
        ) {
            // All hold the origin or nearly: offsets up to 0.9 may leave nothing.
            let spaces: Vec<HalfSpace> = normals.iter().map(|(n, d)| HalfSpace { normal: *n, offset: d * 0.5 }).collect();
            let p = DVec3::from(p);
            let is_in = |q: DVec3, by: f64| spaces.iter().all(|s| s.depth(q) >= by);
            match nearest(&spaces, p, &mut Vec::new()) {
                Some(at) => {
                    prop_assert!(is_in(at, -1e-8));
                    for q in others.iter().map(|q| DVec3::from(*q)).filter(|q| is_in(*q, 0.0)) {
                        prop_assert!((p - at).dot(q - at) <= 1e-6, "{q} is nearer");
                    }
                }
                None => prop_assert!(!is_in(DVec3::ZERO, 1e-6) && others.iter().all(|q| !is_in(DVec3::from(*q), 1e-6))),
            }
        }
    }

    #[test]
    fn in_a_corner_three_planes_hold_it() {
        let spaces = [DVec3::X, DVec3::Y, DVec3::Z].map(|normal| HalfSpace { normal, offset: 1.0 });
        assert_eq!(nearest(&spaces, DVec3::ZERO, &mut Vec::new()), Some(DVec3::ONE));
        assert_eq!(nearest(&spaces, DVec3::new(2.0, 0.0, 5.0), &mut Vec::new()), Some(DVec3::new(2.0, 1.0, 5.0)));
        assert_eq!(nearest(&[], DVec3::X, &mut Vec::new()), Some(DVec3::X));
        let apart = [HalfSpace { normal: DVec3::X, offset: 1.0 }, HalfSpace { normal: -DVec3::X, offset: 1.0 }];
        assert_eq!(nearest(&apart, DVec3::ZERO, &mut Vec::new()), None);
    }
}
