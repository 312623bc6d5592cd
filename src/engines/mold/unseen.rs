//! Faces that are not seen from the opening, and the proposal of the opening direction from which fewest are not.
//!
//! A face is not seen if it looks away from the opening, or lies under others. The first is exact; the second is told by
//! a coarse height map at places just before the faces, about as well as grooves are wider than a few hundredths of
//! the part. The part's bottom, on which it stands, is neither.

use glam::DVec3;
use rayon::prelude::*;

use super::height_field::HeightField;
use super::invert::{DOWNWARDS, InvertFaces};
use super::opening::Opening;
use super::warning::MoldWarning;
use geometry::mesh::{Mesh, normal_times_two_areas, unit_normal};
use task::Cancel;

/// Cells of the height map along the longer side of the part.
const CELLS: f64 = 400.0;
/// How far before a face it is asked what lies above, in cells: more than half a cell's diagonal, so that the face's own
/// cells are never in the way.
const BEFORE: f64 = 0.75;
/// Cells that a place of a face stands for, and most places of a triangle.
const CELLS_PER_PLACE: f64 = 16.0;
const MOST_PLACES: f64 = 1024.0;
/// Directions of large faces that are tried beside the axes, each with its opposite.
const FACE_DIRECTIONS: usize = 6;
/// Normals up to this angle from each other are of one direction (rad).
const SAME: f64 = 2e-3;
/// How far a point may lie off a plane of the part's outside to be on it, in parts of the part's diagonal: directions are
/// proposed to a millionth, and files in single precision are as exact.
const OUTER: f64 = 1e-5;
/// Shares of the part's area up to which two directions leave as much unseen, which the height map does not tell better,
/// and up to which as much looks away.
const AS_GOOD: [f64; 2] = [5e-4, 1e-6];
/// Share of the inner faces that an opening direction may hide without a warning.
const MOST_HIDDEN: f64 = 1.0 / 3.0;

/// Areas of a part's faces that are not seen from its opening.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Unseen {
    /// Area that looks away, but for the bottom (mm^2).
    pub away_mm2: f64,
    /// Area that lies under other faces, about (mm^2).
    pub hidden_mm2: f64,
}

impl Unseen {
    /// The area of both (mm^2).
    pub fn area_mm2(&self) -> f64 {
        self.away_mm2 + self.hidden_mm2
    }

    /// What is not seen of those faces of a mesh whose opening looks along +Z that count.
    fn of(upright: &Mesh, counts: impl Fn(usize) -> bool + Sync) -> Self {
        let is_base_or_away = |corners: [DVec3; 3]| unit_normal(corners).z < DOWNWARDS;
        let away_mm2 = away_mm2(upright, DVec3::Z, &counts);
        let area = |face: usize| 0.5 * normal_times_two_areas(upright.corners(face)).length();
        let size = upright.bounds().size();
        let step = size.x.max(size.y) / CELLS;
        // A part without extent hides nothing.
        let Ok(field) = HeightField::raster(upright, step, &Cancel::default()) else {
            return Self { away_mm2, hidden_mm2: 0.0 };
        };
        let corner = field.center(0) - 0.5 * step;
        let [columns, rows] = field.size();
        let is_under = |p: DVec3| {
            let at = ((p.truncate() - corner) / step).floor();
            let is_beside = at.x < 0.0 || at.y < 0.0 || at.x >= columns as f64 || at.y >= rows as f64;
            !is_beside && field.height(at.y as usize * columns + at.x as usize).is_some_and(|height| height > p.z)
        };
        let hidden = |face: usize| {
            let corners = upright.corners(face);
            if !counts(face) || is_base_or_away(corners) {
                return 0.0;
            }
            let area = area(face);
            let places = (area / (CELLS_PER_PLACE * step * step)).clamp(1.0, MOST_PLACES).ceil() as usize;
            let before = BEFORE * step * unit_normal(corners);
            let under = (0..places).filter(|i| is_under(place(corners, *i, places) + before)).count();
            area * under as f64 / places as f64
        };
        // Collected first: the sum is the same however many threads there are.
        let hidden: Vec<f64> = (0..upright.triangles.len()).into_par_iter().map(hidden).collect();
        Self { away_mm2, hidden_mm2: hidden.iter().sum::<f64>() + 0.0 }
    }

    /// A warning if the opening of `upright`, which looks along +Z, hides a third of the inner faces or more. Inner faces
    /// are all but those on the outside of the part, which has no material before their planes.
    pub fn warning(upright: &Mesh) -> Option<MoldWarning> {
        let is_inner = inner(upright);
        let faces = upright.iter_corners().zip(&is_inner).filter(|(_, is_inner)| **is_inner);
        let inner_mm2: f64 = faces.map(|(corners, _)| 0.5 * normal_times_two_areas(corners).length()).sum();
        let hidden_mm2 = Self::of(upright, |face| is_inner[face]).area_mm2();
        let is_much = inner_mm2 > 0.0 && hidden_mm2 >= MOST_HIDDEN * inner_mm2;
        is_much.then_some(MoldWarning::HiddenCavity { hidden_mm2, inner_mm2 })
    }
}

/// Area of the faces that look away from a direction, of those that count and do not lie on the bottom (mm^2).
fn away_mm2(mesh: &Mesh, direction: DVec3, counts: impl Fn(usize) -> bool) -> f64 {
    let lowest = mesh.vertices.iter().map(|p| p.dot(direction)).fold(f64::INFINITY, f64::min);
    let low = lowest + OUTER * mesh.bounds().size().length();
    let of = |(face, corners): (usize, [DVec3; 3])| {
        let scaled = normal_times_two_areas(corners);
        let up = scaled.dot(direction);
        let is_away = up < 0.0 && up * up > DOWNWARDS * DOWNWARDS * scaled.length_squared();
        let counts = is_away && corners.iter().any(|p| p.dot(direction) > low) && counts(face);
        counts.then(|| 0.5 * scaled.length())
    };
    mesh.iter_corners().enumerate().filter_map(of).sum::<f64>() + 0.0
}

/// The undercut faces among the invert faces of `upright`, whose `opening` was turned to look along +Z: along a slanted
/// direction the part's outside looks away too, where nothing is to be cut.
pub fn undercuts(faces: InvertFaces, upright: &Mesh, opening: Opening) -> InvertFaces {
    if !matches!(opening, Opening::Slant(_)) {
        return faces;
    }
    let is_inner = inner(upright);
    let triangles: Vec<u32> = faces.triangles.into_iter().filter(|face| is_inner[*face as usize]).collect();
    let area = |face: &u32| 0.5 * normal_times_two_areas(upright.corners(*face as usize)).length();
    InvertFaces { area: triangles.iter().map(area).sum::<f64>() + 0.0, triangles }
}

/// Place number `i` of so many in a triangle, evenly spread: by the fractions of multiples of two irrational numbers
/// (Roberts 2018); one alone is the middle.
fn place([a, b, c]: [DVec3; 3], i: usize, count: usize) -> DVec3 {
    if count == 1 {
        return (a + b + c) / 3.0;
    }
    let [u, v] = [0.754_877_666_246_692_8, 0.569_840_290_998_053_3].map(|step| (0.5 + step * i as f64).fract());
    let [u, v] = if u + v > 1.0 { [1.0 - u, 1.0 - v] } else { [u, v] };
    a + u * (b - a) + v * (c - a)
}

/// The unit normals of the largest faces of a mesh, at most so many, the largest first; opposite ones are one.
fn face_directions(mesh: &Mesh, most: usize) -> Vec<DVec3> {
    let of = |face: usize| {
        let (scaled, unit) = (normal_times_two_areas(mesh.corners(face)), unit_normal(mesh.corners(face)));
        let is_first = unit.to_array().into_iter().find(|v| v.abs() > 0.1 * SAME).is_some_and(|v| v > 0.0);
        let sign = if is_first { 1.0 } else { -1.0 };
        ((sign * unit / SAME).round().to_array().map(|v| v as i32), face, sign * scaled)
    };
    let mut faces: Vec<([i32; 3], usize, DVec3)> = (0..mesh.triangles.len()).into_par_iter().map(of).collect();
    faces.par_sort_unstable_by_key(|(key, face, _)| (*key, *face));
    let same = faces.chunk_by(|a, b| a.0 == b.0);
    let mut areas: Vec<([i32; 3], DVec3)> = same.map(|of| (of[0].0, of.iter().map(|(.., area)| *area).sum())).collect();
    areas.sort_by(|(k, a), (l, b)| b.length_squared().total_cmp(&a.length_squared()).then(k.cmp(l)));
    let mut found: Vec<DVec3> = Vec::new();
    for direction in areas.iter().filter_map(|(_, area)| area.try_normalize()) {
        // Two steps of the rounding: a face may fall into several of its cells.
        if found.len() < most && found.iter().all(|other| other.cross(direction).length() > 2.0 * SAME) {
            found.push(direction);
        }
    }
    found
}

/// Whether each face of a mesh is none of its outside.
fn inner(mesh: &Mesh) -> Vec<bool> {
    /// Largest faces whose normals extreme points are looked for along.
    const MOST: usize = 24;
    let steps = [-1.0, 0.0, 1.0];
    let cube = steps.map(|x| steps.map(|y| steps.map(|z| DVec3::new(x, y, z))));
    let faces = face_directions(mesh, MOST).into_iter().flat_map(|direction| [direction, -direction]);
    let directions: Vec<DVec3> = cube.as_flattened().as_flattened().iter().copied().chain(faces).collect();
    let furthest = |direction: &DVec3| {
        mesh.vertices.iter().copied().max_by(|a, b| a.dot(*direction).total_cmp(&b.dot(*direction)))
    };
    let extremes: Vec<DVec3> = directions.par_iter().filter_map(furthest).collect();
    let reach = OUTER * mesh.bounds().size().length();
    let is_inner = |face: usize| {
        let corners = mesh.corners(face);
        let normal = unit_normal(corners);
        extremes.iter().any(|p| (*p - corners[0]).dot(normal) > reach)
    };
    (0..mesh.triangles.len()).into_par_iter().map(is_inner).collect()
}

/// The opening direction from which most of a part is seen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OpeningProposal {
    /// The direction.
    pub opening: Opening,
    /// What is not seen from there.
    pub unseen: Unseen,
    /// The next best direction, and what is not seen from there.
    pub next: (Opening, Unseen),
}

impl OpeningProposal {
    /// The proposal for a part, in its own axes: of the six axes and the directions of its largest faces and their
    /// opposites the one from which the least area is not seen. Of directions that are as good as each other the one
    /// comes first from which less looks away, then +Z, -Z, +Y, -Y, +X, -X, and then the larger face.
    pub fn of(mesh: &Mesh) -> Self {
        use Opening::{MinusX, MinusY, MinusZ, PlusX, PlusY, PlusZ};
        let axes = [PlusZ, MinusZ, PlusY, MinusY, PlusX, MinusX];
        let is_axis = |d: &DVec3| axes.iter().any(|axis| axis.direction().cross(*d).length() <= SAME);
        let faces = face_directions(mesh, FACE_DIRECTIONS + 3).into_iter().filter(|d| !is_axis(d));
        // To decimals that are read and typed.
        let both = faces.take(FACE_DIRECTIONS).map(|d| (d * 1e6).round() / 1e6 + 0.0).flat_map(|d| [d, -d]);
        let directions: Vec<Opening> = axes.into_iter().chain(both.filter_map(Opening::along)).collect();
        let away = |opening: &Opening| away_mm2(mesh, opening.direction(), |_| true);
        let away: Vec<f64> = directions.par_iter().map(away).collect();
        let mut order: Vec<usize> = (0..directions.len()).collect();
        order.sort_by(|a, b| away[*a].total_cmp(&away[*b]));
        let whole = mesh.area();
        let steps = |area: f64, share: f64| (area / (share * whole)).round() as u64;
        let mut found: Vec<(usize, Unseen)> = Vec::new();
        for i in order {
            // What looks away is not seen: no other can be among the best two.
            if found.get(1).is_some_and(|(_, second)| away[i] > second.area_mm2() + AS_GOOD[0] * whole) {
                break;
            }
            found.push((i, Unseen::of(&directions[i].upright_mesh(mesh), |_| true)));
            found.sort_by_key(|(i, of)| (steps(of.area_mm2(), AS_GOOD[0]), steps(of.away_mm2, AS_GOOD[1]), *i));
        }
        let [best, next] = [0, 1].map(|k| found.get(k).map_or_else(Default::default, |(i, of)| (directions[*i], *of)));
        Self { opening: best.0, unseen: best.1, next }
    }

    /// The direction and why it is proposed.
    pub fn sentence(&self) -> String {
        let figures = |Unseen { away_mm2, hidden_mm2 }: Unseen| (away_mm2, hidden_mm2);
        let ((away, hidden), (of_next, under_next)) = (figures(self.unseen), figures(self.next.1));
        format!(
            "{}: {away:.1} mm2 of faces look away and about {hidden:.0} mm2 lie under others; next best {}: \
             {of_next:.1} and {under_next:.0} mm2",
            self.opening.name(),
            self.next.0.name()
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixtures::{frame, pocket, rectangle};

    /// Area that the height map hides although it is seen, in corners (mm^2).
    const NOISE: f64 = 0.5;

    /// A block of 20 x 20 x 10 mm with a pocket of 8 x 6 mm, 4 mm deep, from above.
    fn mold() -> Mesh {
        let hole = rectangle(8.0, 6.0);
        pocket(&rectangle(20.0, 20.0), &hole, &hole, [10.0, 4.0])
    }

    #[test]
    fn a_pocket_opens_upwards_however_it_lies() {
        for opening in Opening::AXES {
            let lying = mold().mapped(|p| opening.in_mesh(p));
            let proposal = OpeningProposal::of(&lying);
            let Unseen { away_mm2, hidden_mm2 } = proposal.unseen;
            assert_eq!((proposal.opening, away_mm2), (opening, 0.0), "{}", proposal.sentence());
            assert!(hidden_mm2 < NOISE, "{hidden_mm2}");
            // From any other side nothing of it is seen: neither its floor nor its walls.
            let unseen = proposal.next.1.area_mm2();
            assert!((unseen - (48.0 + 2.0 * 14.0 * 4.0)).abs() < 3.0, "{unseen}");
            let sentence = format!("{}: 0.0 mm2 of faces look away and about 0 mm2 lie under", opening.name());
            assert!(proposal.sentence().starts_with(&sentence), "{}", proposal.sentence());
        }
    }

    #[test]
    fn a_mold_that_lies_askew_opens_along_its_own_faces() {
        let askew = Opening::along(DVec3::new(0.3, -0.2, 0.8)).unwrap();
        let lying = mold().mapped(|p| askew.in_mesh(p));
        let proposal = OpeningProposal::of(&lying);
        assert!(proposal.opening.direction().dot(askew.direction()) > 1.0 - 1e-9, "{}", proposal.sentence());
        assert!(proposal.unseen.area_mm2() < NOISE, "{}", proposal.sentence());
    }

    #[test]
    fn of_directions_that_are_as_good_the_first_is_taken() {
        let plain = OpeningProposal::of(&Mesh::cuboid(DVec3::new(3.0, 4.0, 5.0)));
        assert_eq!((plain.opening, plain.next.0), (Opening::PlusZ, Opening::MinusZ));
        let through = OpeningProposal::of(&frame(&rectangle(20.0, 20.0), &rectangle(6.0, 6.0), 5.0));
        assert_eq!((through.opening, through.next.0), (Opening::PlusZ, Opening::MinusZ));
        assert!(through.unseen.area_mm2() < NOISE);
        // The smallest floor decides: the same hole, all but through.
        let hole = rectangle(0.2, 0.2);
        let blind = pocket(&rectangle(20.0, 20.0), &hole, &hole, [5.0, 4.9]);
        for opening in [Opening::MinusZ, Opening::PlusY] {
            assert_eq!(OpeningProposal::of(&blind.mapped(|p| opening.in_mesh(p))).opening, opening);
        }
        assert_eq!(OpeningProposal::of(&Mesh::default()).opening, Opening::PlusZ, "nothing opens anywhere");
    }

    #[test]
    fn what_lies_under_a_lid_is_not_seen() {
        // A pocket whose mouth is narrower than its floor: 4 x 4 mm over 10 x 10 mm, 3 mm deep, walls aslant.
        let under = pocket(&rectangle(20.0, 20.0), &rectangle(4.0, 4.0), &rectangle(10.0, 10.0), [8.0, 3.0]);
        let Unseen { away_mm2, hidden_mm2 } = Unseen::of(&under, |_| true);
        // Four trapezia look down; of the floor what is under them cannot be seen.
        let wall = 0.5 * (4.0 + 10.0) * 3.0 * 2f64.sqrt();
        assert!((away_mm2 - 4.0 * wall).abs() < 1e-9, "{away_mm2}");
        assert!((hidden_mm2 - (100.0 - 16.0)).abs() < 5.0, "{hidden_mm2}");
    }

    #[test]
    fn the_outside_is_no_undercut_of_a_slanted_direction() {
        // Less aslant than the walls: 45 degrees over a depth of 2 mm.
        let wide = pocket(&rectangle(20.0, 20.0), &rectangle(12.0, 12.0), &rectangle(8.0, 8.0), [10.0, 2.0]);
        let undercut = |vector: DVec3| {
            let opening = Opening::along(vector).unwrap();
            let upright = opening.upright_mesh(&wide);
            undercuts(InvertFaces::of(&upright), &upright, opening)
        };
        assert_eq!(undercut(DVec3::new(0.5, 0.0, 1.0)), InvertFaces::default());
        // More aslant than one of them.
        let one = undercut(DVec3::new(1.5, 0.0, 1.0));
        assert!((one.area - 0.5 * (12.0 + 8.0) * 2.0 * 2f64.sqrt()).abs() < 1e-9, "{}", one.area);
    }

    #[test]
    fn an_opening_that_hides_a_third_of_the_cavity_is_warned_of() {
        let of = |opening: Opening| Unseen::warning(&opening.upright_mesh(&mold()));
        assert_eq!(of(Opening::PlusZ), None);
        for opening in [Opening::MinusZ, Opening::PlusX, Opening::MinusY] {
            let Some(MoldWarning::HiddenCavity { hidden_mm2, inner_mm2 }) = of(opening) else { panic!("{opening:?}") };
            // The floor and four walls; the block's own sides are outer faces.
            assert!((inner_mm2 - (48.0 + 2.0 * 14.0 * 4.0)).abs() < 1e-9, "{inner_mm2}");
            assert!((hidden_mm2 / inner_mm2 - 1.0).abs() < 0.02, "{opening:?}: {hidden_mm2}");
        }
        assert_eq!(Unseen::warning(&Mesh::cuboid(DVec3::ONE)), None, "without a cavity nothing is hidden");
    }
}
