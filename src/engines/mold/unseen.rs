//! Faces that are not seen from the opening, and the proposal of the opening direction from which fewest are not.
//!
//! A face is not seen if it looks away from the opening, or lies under others. The first is exact; the second is told by
//! a coarse height map at places just before the faces, about as well as grooves are wider than a few hundredths of
//! the part. The part's bottom, on which it stands, is neither, and where solids touch there is no face.

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::contact::{Contacts, place};
use super::height_field::HeightField;
use super::invert::{InvertFaces, looks_away, tilt};
use super::opening::Opening;
use super::section::vertex_error;
use super::warning::MoldWarning;
use geometry::mesh::{Mesh, normal_times_two_areas, unit_normal};
use task::{Cancel, Cancelled};

/// Cells of the height map along the longer side of the part.
const CELLS: f64 = 400.0;
/// How far before a face it is asked what lies above, in cells: more than half a cell's diagonal, so that the face's own
/// cells are never in the way.
const BEFORE: f64 = 0.75;
/// By how many cells what lies over a place is higher, at least: in a groove the ground's cells are higher than it by
/// half a cell times the slope of its walls.
const ABOVE: f64 = 2.0;
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

    /// What is not seen of those faces of a mesh whose opening looks along +Z that count. The contacts are those of the
    /// mesh before its `opening` was turned there.
    fn of(
        upright: &Mesh,
        (contacts, opening): (&Contacts, Opening),
        counts: impl Fn(usize) -> bool + Sync,
        cancel: &Cancel,
    ) -> Result<Self, Cancelled> {
        let error = vertex_error(upright);
        let away_mm2 = away_mm2(upright, DVec3::Z, contacts, &counts);
        let area = |face: usize| 0.5 * normal_times_two_areas(upright.corners(face)).length();
        let size = upright.bounds().size();
        let step = size.x.max(size.y) / CELLS;
        // A part without extent hides nothing.
        let Ok(field) = HeightField::raster(upright, step, cancel) else {
            return cancel.check().map(|()| Self { away_mm2, hidden_mm2: 0.0 });
        };
        let corner = field.center(0) - 0.5 * step;
        let [columns, rows] = field.size();
        let is_above = |at: DVec2, z: f64| {
            let is_beside = at.x < 0.0 || at.y < 0.0 || at.x >= columns as f64 || at.y >= rows as f64;
            !is_beside
                && field.height(at.y as usize * columns + at.x as usize).is_some_and(|height| height > z + ABOVE * step)
        };
        // In a corner the cells on one side only are higher.
        let around = [-1.0, 0.0, 1.0].map(|x| [-1.0, 0.0, 1.0].map(|y| DVec2::new(x, y)));
        let is_under = |p: DVec3| {
            let at = ((p.truncate() - corner) / step).floor();
            is_above(at, p.z) && around.as_flattened().iter().all(|off| is_above(at + off, p.z))
        };
        let hidden = |face: usize| {
            cancel.check()?;
            let corners = upright.corners(face);
            // What looks away is counted there, or is the base.
            if !counts(face) || looks_away(corners, DVec3::Z, error) {
                return Ok(0.0);
            }
            let area = area(face);
            let places = (area / (CELLS_PER_PLACE * step * step)).clamp(1.0, MOST_PLACES).ceil() as usize;
            let normal = unit_normal(corners);
            let is_hidden = |p: DVec3| {
                let is_covered = || contacts.cover(face, opening.in_mesh(p), opening.in_mesh(normal));
                is_under(p + BEFORE * step * normal) && !(contacts.are_near(face) && is_covered())
            };
            let under = (0..places).filter(|i| is_hidden(place(corners, *i, places))).count();
            Ok(area * under as f64 / places as f64)
        };
        // Collected first: the sum is the same however many threads there are.
        let hidden: Vec<f64> = (0..upright.triangles.len()).into_par_iter().map(hidden).collect::<Result<_, _>>()?;
        Ok(Self { away_mm2, hidden_mm2: hidden.iter().sum::<f64>() + 0.0 })
    }

    /// A warning if the opening of `upright`, which looks along +Z, hides a third of the inner faces or more. Inner faces
    /// are all but those on the outside of the part, which has no material before their planes.
    ///
    /// # Errors
    /// If it is cancelled.
    pub fn warning(upright: &Mesh, cancel: &Cancel) -> Result<Option<MoldWarning>, Cancelled> {
        let (is_inner, contacts) = (inner(upright, cancel)?, Contacts::of(upright, cancel)?);
        let faces = (0..upright.triangles.len()).filter(|face| is_inner[*face]);
        let inner_mm2: f64 = faces.map(|face| free_area(upright, face, &contacts)).sum();
        let hidden_mm2 = Self::of(upright, (&contacts, Opening::PlusZ), |face| is_inner[face], cancel)?.area_mm2();
        let is_much = inner_mm2 > 0.0 && hidden_mm2 >= MOST_HIDDEN * inner_mm2;
        Ok(is_much.then_some(MoldWarning::HiddenCavity { hidden_mm2, inner_mm2, is_proposed: false }))
    }
}

/// Area of a face where there is no material before it (mm^2).
fn free_area(mesh: &Mesh, face: usize, contacts: &Contacts) -> f64 {
    0.5 * normal_times_two_areas(mesh.corners(face)).length() * contacts.free_share(face)
}

/// Area of the faces that look away from a direction, of those that count and do not lie on the bottom (mm^2).
fn away_mm2(mesh: &Mesh, direction: DVec3, contacts: &Contacts, counts: impl Fn(usize) -> bool) -> f64 {
    let lowest = mesh.vertices.iter().map(|p| p.dot(direction)).fold(f64::INFINITY, f64::min);
    let low = lowest + OUTER * mesh.bounds().size().length();
    let error = vertex_error(mesh);
    let of = |(face, corners): (usize, [DVec3; 3])| {
        let is_away = looks_away(corners, direction, error);
        let counts = is_away && corners.iter().any(|p| p.dot(direction) > low) && counts(face);
        counts.then(|| free_area(mesh, face, contacts))
    };
    mesh.iter_corners().enumerate().filter_map(of).sum::<f64>() + 0.0
}

/// The undercut faces among the invert faces of `upright`, whose `opening` was turned to look along +Z: where solids
/// touch there is no face, and along a slanted direction the part's outside looks away too, where nothing is to be cut.
///
/// # Errors
/// If it is cancelled.
pub fn undercuts(
    faces: InvertFaces,
    upright: &Mesh,
    opening: Opening,
    cancel: &Cancel,
) -> Result<InvertFaces, Cancelled> {
    if faces.triangles.is_empty() {
        return Ok(faces);
    }
    let contacts = Contacts::of(upright, cancel)?;
    let is_inner = matches!(opening, Opening::Slant(_)).then(|| inner(upright, cancel)).transpose()?;
    let is_undercut = |face: &u32| {
        let is_inner = is_inner.as_ref().is_none_or(|is_inner| is_inner[*face as usize]);
        is_inner && contacts.free_share(*face as usize) > 0.0
    };
    let triangles: Vec<u32> = faces.triangles.into_iter().filter(is_undercut).collect();
    let area = |face: &u32| free_area(upright, *face as usize, &contacts);
    Ok(InvertFaces { area: triangles.iter().map(area).sum::<f64>() + 0.0, triangles })
}

/// The unit normals of the largest faces of a mesh, at most so many, the largest first; opposite ones are one.
fn face_directions(mesh: &Mesh, most: usize, cancel: &Cancel) -> Result<Vec<DVec3>, Cancelled> {
    let sign = |unit: DVec3| {
        let is_first = unit.to_array().into_iter().find(|v| v.abs() > 0.1 * SAME).is_some_and(|v| v > 0.0);
        if is_first { 1.0 } else { -1.0 }
    };
    let key = |face: u32| {
        cancel.check()?;
        let unit = unit_normal(mesh.corners(face as usize));
        Ok(((sign(unit) * unit / SAME).round().to_array().map(|v| v as i16), face))
    };
    let faces = (0..mesh.triangles.len() as u32).into_par_iter().map(key);
    let mut faces: Vec<([i16; 3], u32)> = faces.collect::<Result<_, _>>()?;
    faces.par_sort_unstable();
    let area = |&(_, face): &([i16; 3], u32)| {
        let corners = mesh.corners(face as usize);
        sign(unit_normal(corners)) * normal_times_two_areas(corners)
    };
    let same = faces.chunk_by(|a, b| a.0 == b.0);
    let same = same.map(|of| cancel.check().map(|()| (of[0].0, of.iter().map(area).sum())));
    let mut areas: Vec<([i16; 3], DVec3)> = same.collect::<Result<_, _>>()?;
    areas.par_sort_by(|(k, a), (l, b)| b.length_squared().total_cmp(&a.length_squared()).then(k.cmp(l)));
    let mut found: Vec<DVec3> = Vec::new();
    for direction in areas.iter().filter_map(|(_, area)| area.try_normalize()) {
        // Two steps of the rounding: a face may fall into several of its cells.
        if found.iter().all(|other| other.cross(direction).length() > 2.0 * SAME) {
            found.push(direction);
        }
        if found.len() == most {
            break;
        }
    }
    Ok(found)
}

/// Whether each face of a mesh is none of its outside.
fn inner(mesh: &Mesh, cancel: &Cancel) -> Result<Vec<bool>, Cancelled> {
    /// Largest faces whose normals extreme points are looked for along.
    const MOST: usize = 24;
    let steps = [-1.0, 0.0, 1.0];
    let cube = steps.map(|x| steps.map(|y| steps.map(|z| DVec3::new(x, y, z))));
    let faces = face_directions(mesh, MOST, cancel)?.into_iter().flat_map(|direction| [direction, -direction]);
    let directions: Vec<DVec3> = cube.as_flattened().as_flattened().iter().copied().chain(faces).collect();
    let furthest = |direction: &DVec3| {
        cancel.check()?;
        Ok(mesh.vertices.iter().copied().max_by(|a, b| a.dot(*direction).total_cmp(&b.dot(*direction))))
    };
    let extremes: Vec<Option<DVec3>> = directions.par_iter().map(furthest).collect::<Result<_, _>>()?;
    let (reach, error) = (OUTER * mesh.bounds().size().length(), vertex_error(mesh));
    let is_inner = |face: usize| {
        cancel.check()?;
        let corners = mesh.corners(face);
        let (normal, tilt) = (unit_normal(corners), tilt(corners, error));
        // The plane of a narrow triangle is not known far from it.
        let is_before = |off: DVec3| off.dot(normal) > reach.max(tilt * off.length());
        Ok(extremes.iter().flatten().any(|p| is_before(*p - corners[0])))
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
    /// comes first from which less looks away, then the one that more of the inner faces look towards, as the top of a
    /// groove and not its open ends, then +Z, -Z, +Y, -Y, +X, -X, and then the larger face.
    ///
    /// # Errors
    /// If it is cancelled.
    pub fn of(mesh: &Mesh, cancel: &Cancel) -> Result<Self, Cancelled> {
        use Opening::{MinusX, MinusY, MinusZ, PlusX, PlusY, PlusZ};
        let axes = [PlusZ, MinusZ, PlusY, MinusY, PlusX, MinusX];
        let is_axis = |d: &DVec3| axes.iter().any(|axis| axis.direction().cross(*d).length() <= SAME);
        let faces = face_directions(mesh, FACE_DIRECTIONS + 3, cancel)?.into_iter().filter(|d| !is_axis(d));
        // To decimals that are read and typed.
        let both = faces.take(FACE_DIRECTIONS).map(|d| (d * 1e6).round() / 1e6 + 0.0).flat_map(|d| [d, -d]);
        let directions: Vec<Opening> = axes.into_iter().chain(both.filter_map(Opening::along)).collect();
        let contacts = Contacts::of(mesh, cancel)?;
        let away = |opening: &Opening| {
            cancel.check()?;
            Ok(away_mm2(mesh, opening.direction(), &contacts, |_| true))
        };
        let away: Vec<f64> = directions.par_iter().map(away).collect::<Result<_, _>>()?;
        let mut order: Vec<usize> = (0..directions.len()).collect();
        order.sort_by(|a, b| away[*a].total_cmp(&away[*b]));
        let whole = mesh.area();
        let steps = |area: f64, share: f64| (area / (share * whole)).round() as u64;
        let key = |of: &Unseen| (steps(of.area_mm2(), AS_GOOD[0]), steps(of.away_mm2, AS_GOOD[1]));
        let mut found: Vec<(usize, Unseen)> = Vec::new();
        for i in order {
            // What looks away is not seen: no other can be among the best two.
            if found.get(1).is_some_and(|(_, second)| away[i] > second.area_mm2() + AS_GOOD[0] * whole) {
                break;
            }
            let upright = directions[i].upright_mesh(mesh);
            found.push((i, Unseen::of(&upright, (&contacts, directions[i]), |_| true, cancel)?));
            found.sort_by_key(|(i, of)| (key(of), *i));
        }
        // Inner faces are looked for only where they decide.
        if found.get(1).is_some_and(|(_, second)| key(&found[0].1) == key(second)) {
            let (is_inner, error) = (inner(mesh, cancel)?, vertex_error(mesh));
            let towards = |direction: DVec3| {
                let faces = (0..is_inner.len()).filter(|face| is_inner[*face]);
                let faces = faces.filter(|face| looks_away(mesh.corners(*face), -direction, error));
                faces
                    .map(|face| unit_normal(mesh.corners(face)).dot(direction) * free_area(mesh, face, &contacts))
                    .sum()
            };
            let most = |i: usize| std::cmp::Reverse(steps(towards(directions[i].direction()), AS_GOOD[0]));
            found.sort_by_cached_key(|(i, of)| (key(of), most(*i), *i));
        }
        let [best, next] = [0, 1].map(|k| found.get(k).map_or_else(Default::default, |(i, of)| (directions[*i], *of)));
        Ok(Self { opening: best.0, unseen: best.1, next })
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
    use crate::fixtures::{frame, pocket, rectangle, with};
    use geometry::solid::{difference, hull};

    /// Area that the height map hides although it is seen, in corners (mm^2).
    const NOISE: f64 = 0.5;

    /// A block of 20 x 20 x 10 mm with a pocket of 8 x 6 mm, 4 mm deep, from above.
    fn mold() -> Mesh {
        let hole = rectangle(8.0, 6.0);
        pocket(&rectangle(20.0, 20.0), &hole, &hole, [10.0, 4.0])
    }

    fn proposal_of(mesh: &Mesh) -> OpeningProposal {
        OpeningProposal::of(mesh, &Cancel::default()).unwrap()
    }

    fn undercuts_of(upright: &Mesh, opening: Opening) -> InvertFaces {
        undercuts(InvertFaces::of(upright), upright, opening, &Cancel::default()).unwrap()
    }

    #[test]
    fn what_is_cancelled_proposes_nothing() {
        let cancel = Cancel::default();
        cancel.cancel();
        assert_eq!(OpeningProposal::of(&mold(), &cancel), Err(Cancelled));
        assert_eq!(Unseen::warning(&mold(), &cancel), Err(Cancelled));
        let upright = Opening::MinusZ.upright_mesh(&mold());
        assert_eq!(undercuts(InvertFaces::of(&upright), &upright, Opening::MinusZ, &cancel), Err(Cancelled));
    }

    #[test]
    fn a_pocket_opens_upwards_however_it_lies() {
        for opening in Opening::AXES {
            let lying = mold().mapped(|p| opening.in_mesh(p));
            let proposal = proposal_of(&lying);
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
        let proposal = proposal_of(&lying);
        assert!(proposal.opening.direction().dot(askew.direction()) > 1.0 - 1e-9, "{}", proposal.sentence());
        assert!(proposal.unseen.area_mm2() < NOISE, "{}", proposal.sentence());
    }

    #[test]
    fn of_directions_that_are_as_good_the_first_is_taken() {
        let plain = proposal_of(&Mesh::cuboid(DVec3::new(3.0, 4.0, 5.0)));
        assert_eq!((plain.opening, plain.next.0), (Opening::PlusZ, Opening::MinusZ));
        let through = proposal_of(&frame(&rectangle(20.0, 20.0), &rectangle(6.0, 6.0), 5.0));
        assert_eq!((through.opening, through.next.0), (Opening::PlusZ, Opening::MinusZ));
        assert!(through.unseen.area_mm2() < NOISE);
        // The smallest floor decides: the same hole, all but through.
        let hole = rectangle(0.2, 0.2);
        let blind = pocket(&rectangle(20.0, 20.0), &hole, &hole, [5.0, 4.9]);
        for opening in [Opening::MinusZ, Opening::PlusY] {
            assert_eq!(proposal_of(&blind.mapped(|p| opening.in_mesh(p))).opening, opening);
        }
        assert_eq!(proposal_of(&Mesh::default()).opening, Opening::PlusZ, "nothing opens anywhere");
    }

    /// A groove that is open at both ends is seen from there too, but faces look to its top.
    #[test]
    fn a_groove_opens_where_its_walls_look_to() {
        let at = |x: f64, y: f64, z: f64| DVec3::new(x, y, z);
        let groove = [-31.0, 31.0].map(|x| [at(x, -3.0, 0.01), at(x, 3.0, 0.01), at(x, 0.0, -6.0)]);
        let block = Mesh::cuboid(DVec3::new(60.0, 60.0, 15.0));
        let to_top = block.bounds().center().with_z(block.bounds().max.z);
        let block = block.mapped(|p| p - to_top);
        let mold = difference(&block, &hull(groove.as_flattened())).unwrap();
        let single = |p: DVec3| p.as_vec3().as_dvec3();
        for vector in [DVec3::Z, DVec3::new(0.57, -0.095, 0.82), DVec3::new(-0.3, 0.8, -0.1), DVec3::NEG_Y] {
            let opening = Opening::along(vector).unwrap();
            let proposal = proposal_of(&mold.mapped(|p| single(opening.in_mesh(p))));
            let found = proposal.opening.direction();
            assert!(found.dot(opening.direction()) > 1.0 - 1e-9, "{vector}: {}", proposal.sentence());
        }
    }

    /// In single precision the normals of narrow triangles of the bottom are off, and walls lean.
    #[test]
    fn narrow_triangles_of_a_turned_mold_are_no_undercuts() {
        let block = pocket(&rectangle(60.0, 40.0), &rectangle(8.0, 6.0), &rectangle(8.0, 6.0), [20.0, 4.0]);
        // Points close to the bottom's corners divide its sides and the walls there into narrow triangles.
        let opening = Opening::along(DVec3::new(0.566683, -0.094528, 0.818495)).unwrap();
        let narrow = split_near_corners(&block, 0.02);
        assert!(narrow.is_watertight() && (narrow.volume() - block.volume()).abs() < 1e-6);
        let turned = narrow.mapped(|p| opening.in_mesh(p).as_vec3().as_dvec3());
        let upright = opening.upright_mesh(&turned);
        let found = undercuts_of(&upright, opening);
        assert_eq!(found, InvertFaces::default());
        assert_eq!(proposal_of(&turned).unseen.away_mm2, 0.0);
    }

    /// The mesh with every edge divided at this distance from its first vertex (mm).
    fn split_near_corners(mesh: &Mesh, off: f64) -> Mesh {
        let mut split = Mesh { vertices: mesh.vertices.clone(), triangles: Vec::new() };
        let mut middles = std::collections::HashMap::new();
        for t in &mesh.triangles {
            let mut ring = Vec::new();
            for (a, b) in [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])] {
                let (from, to) = (a.min(b), a.max(b));
                let middle = *middles.entry((from, to)).or_insert_with(|| {
                    let [p, q] = [from, to].map(|v| mesh.vertices[v as usize]);
                    split.vertices.push(p + (q - p).normalize() * off);
                    split.vertices.len() as u32 - 1
                });
                ring.extend([a, middle]);
            }
            let [a, ab, b, bc, c, ca] = ring[..] else { unreachable!() };
            split.triangles.extend([[a, ab, ca], [ab, b, bc], [bc, c, ca], [ab, bc, ca]]);
        }
        split
    }

    #[test]
    fn where_solids_touch_nothing_is_undercut_or_hidden() {
        let base = mold();
        let corner = base.bounds().min.with_z(base.bounds().max.z);
        let rib = Mesh::cuboid(DVec3::new(2.0, 16.0, 6.0));
        let on = |z: f64| {
            let shift = corner + DVec3::new(1.5, 2.0, z) - rib.bounds().min;
            with(&base, &rib.mapped(|p| p + shift))
        };
        let undercut = |mesh: &Mesh| undercuts_of(mesh, Opening::PlusZ).area;
        assert_eq!([undercut(&base), undercut(&on(0.0)), undercut(&on(-1.0))], [0.0; 3]);
        assert!((undercut(&on(1.0)) - 32.0).abs() < 1e-9, "with air below it is undercut");
        let proposal = proposal_of(&on(0.0));
        assert_eq!((proposal.opening, proposal.unseen.away_mm2), (Opening::PlusZ, 0.0), "{}", proposal.sentence());
        assert!(proposal.unseen.hidden_mm2 < NOISE, "{}", proposal.sentence());
    }

    #[test]
    fn what_lies_under_a_lid_is_not_seen() {
        // A pocket whose mouth is narrower than its floor: 4 x 4 mm over 10 x 10 mm, 3 mm deep, walls aslant.
        let under = pocket(&rectangle(20.0, 20.0), &rectangle(4.0, 4.0), &rectangle(10.0, 10.0), [8.0, 3.0]);
        let Unseen { away_mm2, hidden_mm2 } =
            Unseen::of(&under, (&Contacts::default(), Opening::PlusZ), |_| true, &Cancel::default()).unwrap();
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
            undercuts_of(&upright, opening)
        };
        assert_eq!(undercut(DVec3::new(0.5, 0.0, 1.0)), InvertFaces::default());
        // More aslant than one of them.
        let one = undercut(DVec3::new(1.5, 0.0, 1.0));
        assert!((one.area - 0.5 * (12.0 + 8.0) * 2.0 * 2f64.sqrt()).abs() < 1e-9, "{}", one.area);
    }

    #[test]
    fn an_opening_that_hides_a_third_of_the_cavity_is_warned_of() {
        let of = |opening: Opening| Unseen::warning(&opening.upright_mesh(&mold()), &Cancel::default()).unwrap();
        assert_eq!(of(Opening::PlusZ), None);
        for opening in [Opening::MinusZ, Opening::PlusX, Opening::MinusY] {
            let Some(MoldWarning::HiddenCavity { hidden_mm2, inner_mm2, .. }) = of(opening) else {
                panic!("{opening:?}")
            };
            // The floor and four walls; the block's own sides are outer faces.
            assert!((inner_mm2 - (48.0 + 2.0 * 14.0 * 4.0)).abs() < 1e-9, "{inner_mm2}");
            assert!((hidden_mm2 / inner_mm2 - 1.0).abs() < 0.02, "{opening:?}: {hidden_mm2}");
        }
        assert_eq!(
            Unseen::warning(&Mesh::cuboid(DVec3::ONE), &Cancel::default()),
            Ok(None),
            "without a cavity nothing is hidden"
        );
    }
}
