//! Congruent tips: which one fits another's place, turned about the burn direction and moved.

use glam::{DMat3, DVec2, DVec3};

use geometry::mesh::{Mesh, normal_times_two_areas};

/// Faces whose normals differ by less are parallel.
const PARALLEL: f64 = 1e-5;
/// How far two faces of one plane lie apart at most (mm).
const SAME_PLANE: f64 = 1e-4;
/// Horizontal part of a normal from which on a face tells how a tip is turned.
const TURNING: f64 = 0.2;
/// Share of the burning area below which a face is not looked at.
const SMALL: f64 = 2e-3;
/// How far faces may be off after one tip is moved onto another (mm).
const OFF: f64 = 2e-3;
/// By how much areas of faces may differ that are laid onto each other: their open sides are cut off roughly.
const AREAS: f64 = 0.3;
/// Turns that are tried.
const TURNS: usize = 24;

/// A flat face of a tip that burns.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BurningFace {
    normal: DVec3,
    offset: f64,
    area: f64,
}

/// A tip, as others are compared with it.
#[derive(Debug, Clone)]
pub struct Form {
    /// Burning faces, the largest first.
    pub faces: Vec<BurningFace>,
    /// Area of all of them (mm^2).
    pub area: f64,
    middle: DVec3,
}

impl Form {
    /// The form of a tip; `burns` tells whether a point of its surface is on a burning face.
    pub fn of(tip: &Mesh, burns: impl Fn(DVec3) -> bool) -> Self {
        let mut faces: Vec<BurningFace> = Vec::new();
        let mut middle = (DVec3::ZERO, 0.0);
        for corners in tip.iter_corners() {
            let [a, b, c] = corners;
            let twice = normal_times_two_areas(corners);
            let (normal, area) = (twice.normalize_or_zero(), 0.5 * twice.length());
            let center = (a + b + c) / 3.0;
            if normal == DVec3::ZERO || !burns(center) {
                continue;
            }
            middle = (middle.0 + center * area, middle.1 + area);
            let offset = normal.dot(center);
            let same = |f: &&mut BurningFace| {
                f.normal.dot(normal) > 1.0 - PARALLEL * PARALLEL.sqrt() && (f.offset - offset).abs() < SAME_PLANE
            };
            match faces.iter_mut().find(same) {
                Some(face) => face.area += area,
                None => faces.push(BurningFace { normal, offset, area }),
            }
        }
        let area = middle.1;
        faces.retain(|f| f.area > SMALL * area);
        faces.sort_by(|a, b| b.area.total_cmp(&a.area));
        Self { faces, area, middle: middle.0 / area.max(f64::MIN_POSITIVE) }
    }

    /// Turns about Z and shifts that may lay this form onto `other`: their burning faces then lie in each other.
    pub fn onto(&self, other: &Form) -> Vec<(f64, DVec3)> {
        if (self.area - other.area).abs() > AREAS * other.area {
            return Vec::new();
        }
        let shift = |turn: f64| self.shift_onto(other, turn).map(|shift| (turn, shift));
        self.turns_onto(other).into_iter().filter_map(shift).collect()
    }

    fn turns_onto(&self, other: &Form) -> Vec<f64> {
        let leads = |f: &&BurningFace| f.normal.truncate().length() > TURNING;
        let quarter = std::f64::consts::FRAC_PI_2;
        let Some(first) = self.faces.iter().find(leads) else {
            return (0..4).map(|k| f64::from(k) * quarter).collect();
        };
        let fits = |f: &&BurningFace| {
            leads(f) && (f.area - first.area).abs() <= AREAS * first.area && (f.normal.z - first.normal.z).abs() < 1e-3
        };
        let turn = |f: &BurningFace| first.normal.truncate().angle_to(f.normal.truncate());
        other.faces.iter().filter(fits).map(turn).take(TURNS).collect()
    }

    /// The shift that lays the faces, turned, into those of `other`, if one does.
    fn shift_onto(&self, other: &Form, turn: f64) -> Option<DVec3> {
        let about = DVec2::from_angle(turn);
        let turned = |v: DVec3| about.rotate(v.truncate()).extend(v.z);
        let mut shift = other.middle - turned(self.middle);
        for _ in 0..3 {
            let (mut matrix, mut right) =
                (DMat3::from_diagonal(DVec3::splat(1e-7 * self.area)), shift * 1e-7 * self.area);
            let mut found = 0.0;
            for face in &self.faces {
                let normal = turned(face.normal);
                // Turning leaves the distance from the origin as it is.
                let miss = |f: &BurningFace| f.offset - face.offset - normal.dot(shift);
                let parallel = other.faces.iter().filter(|f| f.normal.distance_squared(normal) < PARALLEL);
                let Some(to) = parallel.min_by(|a, b| miss(a).abs().total_cmp(&miss(b).abs())) else { continue };
                let weight = face.area.min(to.area);
                found += weight;
                matrix += outer(normal) * weight;
                right += normal * (weight * (to.offset - face.offset));
            }
            if found < (1.0 - AREAS) * self.area {
                return None;
            }
            shift = matrix.inverse() * right;
        }
        let is_met = |face: &BurningFace| {
            let normal = turned(face.normal);
            other.faces.iter().any(|f| {
                f.normal.distance_squared(normal) < PARALLEL && (f.offset - face.offset - normal.dot(shift)).abs() < OFF
            })
        };
        let met: f64 = self.faces.iter().filter(|f| is_met(f)).map(|f| f.area).sum();
        (shift.is_finite() && met > (1.0 - AREAS) * self.area).then_some(shift)
    }
}

fn outer(n: DVec3) -> DMat3 {
    DMat3::from_cols(n * n.x, n * n.y, n * n.z)
}

/// Groups of boxes, each at most `most` wide along X and Y and with at least `apart` between its boxes in plan (mm).
pub fn near(boxes: &[[DVec2; 2]], most: f64, apart: f64) -> Vec<Vec<usize>> {
    let mut order: Vec<usize> = (0..boxes.len()).collect();
    order.sort_by(|&a, &b| boxes[a][0].x.total_cmp(&boxes[b][0].x).then(boxes[a][0].y.total_cmp(&boxes[b][0].y)));
    let mut groups: Vec<(Vec<usize>, [DVec2; 2])> = Vec::new();
    for i in order {
        let [low, high] = boxes[i];
        let fits = |(members, [l, h]): &(Vec<usize>, [DVec2; 2])| {
            let size = high.max(*h) - low.min(*l);
            let is_apart = |m: &usize| {
                let [ml, mh] = boxes[*m];
                (low - mh).max(ml - high).max_element() >= apart
            };
            size.max_element() <= most && members.iter().all(is_apart)
        };
        match groups.iter_mut().find(|group| fits(group)) {
            Some((members, [l, h])) => {
                members.push(i);
                (*l, *h) = (low.min(*l), high.max(*h));
            }
            None => groups.push((vec![i], [low, high])),
        }
    }
    let mut groups: Vec<Vec<usize>> = groups.into_iter().map(|(members, _)| members).collect();
    groups.iter_mut().for_each(|members| members.sort_unstable());
    groups.sort();
    groups
}
