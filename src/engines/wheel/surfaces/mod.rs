//! The surfaces of a wheel told apart: hub, shroud, sides of blades, tips, edges and fillets, for every triangle of its
//! mesh.
//!
//! A triangle is placed in the meridional plane against hub and shroud of a channel. Beside one of them it belongs to
//! it if it faces as it does. In a fillet of radius R, rolled along hub and blade, a place whose normal makes the angle
//! a with the hub's normal lies R (1 - cos a) above the hub; on the blade beyond it lies higher. The sides of blades and
//! their edges are told by the normals of the channel's walls.

mod band;
mod fillet;
mod group;
#[cfg(test)]
mod tests;

use glam::{DVec2, DVec3};
use rayon::prelude::*;
use serde::Serialize;

use self::band::{Band, Blades, Foot};
use self::group::{Group, OfGroup};
use super::cad_faces::classes_by_faces;
use super::channel::{BladeSide, Channel};
use super::frame::slices::{Slices, cylindrical_components};
use geometry::frame::{Cylindrical, wrap_angle};
use geometry::mesh::{Mesh, normal_times_two_areas};
use task::{Cancelled, Task};

/// Kind of surface of a wheel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum SurfaceClass {
    /// The inner end wall, as far along the flow path as hub and shroud or tips of the channel were found: of a wheel
    /// whose passage is not axial, with splitters and without shroud, a height beyond the edges of the channel's own blades.
    Hub,
    /// The outer end wall.
    Shroud,
    /// Sides of the main blades that are low walls of passages: they face greater theta.
    MainLow,
    /// Sides of the main blades that are high walls of passages.
    MainHigh,
    /// Sides of splitters that are low walls of passages.
    SplitterLow,
    /// Sides of splitters that are high walls of passages.
    SplitterHigh,
    /// Tips of blades without a shroud.
    Tip,
    /// Leading and trailing edges of blades.
    Edge,
    /// Fillets between blades and hub.
    HubFillet,
    /// Fillets between blades and shroud.
    ShroudFillet,
    /// Anything else: rims, faces, seals, bores, flanges.
    Elsewhere,
}

impl SurfaceClass {
    /// Every class, in the order of tables and legends.
    pub const ALL: [Self; 11] = [
        Self::Hub,
        Self::Shroud,
        Self::MainLow,
        Self::MainHigh,
        Self::SplitterLow,
        Self::SplitterHigh,
        Self::Tip,
        Self::Edge,
        Self::HubFillet,
        Self::ShroudFillet,
        Self::Elsewhere,
    ];
}

/// The class of every triangle of a mesh.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SurfaceClasses {
    /// One for each triangle of the loaded mesh, in its order.
    #[serde(skip)]
    pub classes: Vec<SurfaceClass>,
    /// Figures of the classes, in the order of [`SurfaceClass::ALL`]; those without triangles are left out.
    pub areas: Vec<ClassArea>,
    /// Radius of the fillets between blades and hub (mm); none where there are no fillets or their radii differ.
    pub hub_fillet_mm: Option<f64>,
    /// Radius of the fillets between blades and shroud (mm), as at the hub.
    pub shroud_fillet_mm: Option<f64>,
}

/// Figures of a class.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ClassArea {
    /// The class.
    pub class: SurfaceClass,
    /// Name for a reader, e.g. `"main blades, suction sides"`.
    pub name: String,
    /// Number of triangles.
    pub triangles: usize,
    /// Area (mm²).
    pub area_mm2: f64,
}

/// The name of `class` for a reader, e.g. `"main blades, suction sides"`.
pub fn class_name(class: SurfaceClass, channel: &Channel) -> String {
    let side = |side: BladeSide, otherwise: &str| match side {
        BladeSide::Suction => "suction sides".to_owned(),
        BladeSide::Pressure => "pressure sides".to_owned(),
        BladeSide::Flat => format!("sides towards {otherwise} theta"),
    };
    let [low, high] = [side(channel.low.side, "greater"), side(channel.high.side, "smaller")];
    let main = if channel.kinds > 1 { "main blades" } else { "blades" };
    match class {
        SurfaceClass::Hub => "hub".to_owned(),
        SurfaceClass::Shroud => "shroud".to_owned(),
        SurfaceClass::MainLow => format!("{main}, {low}"),
        SurfaceClass::MainHigh => format!("{main}, {high}"),
        SurfaceClass::SplitterLow => format!("splitters, {low}"),
        SurfaceClass::SplitterHigh => format!("splitters, {high}"),
        SurfaceClass::Tip => "blade tips".to_owned(),
        SurfaceClass::Edge => "blade edges".to_owned(),
        SurfaceClass::HubFillet => "fillets at the hub".to_owned(),
        SurfaceClass::ShroudFillet => "fillets at the shroud".to_owned(),
        SurfaceClass::Elsewhere => "elsewhere".to_owned(),
    }
}

/// Triangles that a figure is measured on, at most.
const SAMPLES: usize = 200_000;
/// Triangles between two looks at whether the work is cancelled.
const CHUNK: usize = 4096;
/// Facets of hub and shroud lie no further off them than this (mm), beside their chords.
const ON_WALL: f64 = 0.02;
/// And face them within this angle (cosine).
const FACES_WALL: f64 = 0.9;
/// Blade surfaces that face along the camber line within 45 degrees are edges (cosine).
const EDGE: f64 = 0.7;
/// Blades stand out of the ends of hub and shroud or tips by at most this share of the height, above this share of it.
const STAND_OUT: f64 = 0.3;
const ABOVE_HUB: f64 = 0.03;
/// What stands out further above the hub than this share of the height, and faces outwards, is a tip.
const AT_TIPS: f64 = 0.9;

/// Tells the surfaces of the loaded `mesh` apart, in which `channel` was found. `face_of` has the number of the CAD face of
/// each triangle, and is empty where the file has no faces: a face is of one class where nearly all of it is.
///
/// # Errors
/// Only when cancelled.
pub fn classify(mesh: &Mesh, channel: &Channel, face_of: &[u32], task: &Task) -> Result<SurfaceClasses, Cancelled> {
    task.report("surfaces", 0.0, "");
    let turned = if mesh.volume() < 0.0 { -1.0 } else { 1.0 };
    let vertices: Vec<DVec3> = mesh.vertices.par_iter().map(|p| channel.frame.from_parent(*p)).collect();
    let facet = |i: usize| Facet::new(mesh.triangles[i].map(|v| vertices[v as usize]), turned);
    let every = |step: usize| -> Vec<usize> { (0..mesh.triangles.len()).step_by(step).collect() };
    let teller = Band::new(channel).and_then(|band| {
        let blades = Blades::new(channel, &band)?;
        Some(Teller { channel, band, blades, group: None, fillets: [None; 2] })
    });
    let mut found =
        SurfaceClasses { classes: Vec::new(), areas: Vec::new(), hub_fillet_mm: None, shroud_fillet_mm: None };
    let Some(mut teller) = teller else {
        found.classes = vec![SurfaceClass::Elsewhere; mesh.triangles.len()];
        found.areas.push(ClassArea::new(SurfaceClass::Elsewhere, channel, (mesh.triangles.len(), mesh.area())));
        return Ok(found);
    };
    let step = (mesh.triangles.len() / SAMPLES) | 1;
    let samples: Vec<Facet> = every(step).into_par_iter().map(facet).collect();
    task.cancel.check()?;
    if channel.kinds > 1 {
        let wheel = channel.wheel_in_w(mesh);
        let wheel = if wheel.volume() < 0.0 { wheel.turned_over() } else { wheel };
        teller.group = Group::new(&Slices::new(wheel), channel, &task.cancel)?;
    }
    teller.fillets = teller.fillet_radii(&samples);
    task.report("surfaces", 0.3, "");
    let chunks: Vec<usize> = every(CHUNK);
    let told: Vec<Vec<(SurfaceClass, f64)>> = chunks
        .into_par_iter()
        .map(|first| {
            task.cancel.check()?;
            let ids = first..(first + CHUNK).min(mesh.triangles.len());
            Ok(ids.map(facet).map(|facet| (teller.class(&facet), facet.area)).collect())
        })
        .collect::<Result<_, Cancelled>>()?;
    let (mut classes, of_triangles): (Vec<_>, Vec<_>) = told.into_iter().flatten().unzip();
    classes_by_faces(&mut classes, &of_triangles, face_of);
    let mut areas = [(0, 0.0); SurfaceClass::ALL.len()];
    for (class, area) in classes.iter().zip(of_triangles) {
        let sum = &mut areas[*class as usize];
        *sum = (sum.0 + 1, sum.1 + area);
    }
    found.classes = classes;
    let there = SurfaceClass::ALL.into_iter().zip(areas).filter(|(_, (triangles, _))| *triangles > 0);
    found.areas = there.map(|(class, sum)| ClassArea::new(class, channel, sum)).collect();
    [found.hub_fillet_mm, found.shroud_fillet_mm] = teller.fillets;
    task.report("surfaces", 1.0, "");
    Ok(found)
}

impl ClassArea {
    fn new(class: SurfaceClass, channel: &Channel, (triangles, area_mm2): (usize, f64)) -> Self {
        Self { class, name: class_name(class, channel), triangles, area_mm2 }
    }
}

/// A triangle of the wheel's surface in W.
struct Facet {
    /// Middle.
    at: Cylindrical,
    /// Places (x, r) of its corners.
    corners: [DVec2; 3],
    /// Unit outward normal: along x, along r and about the axis.
    normal: DVec3,
    /// Area (mm²).
    area: f64,
    /// Its height above its longest side (mm).
    width: f64,
    /// Greatest difference of its corners' angles about the axis (rad).
    turn: f64,
}

impl Facet {
    fn new(corners: [DVec3; 3], turned: f64) -> Self {
        let at = Cylindrical::from_point(corners.iter().sum::<DVec3>() / 3.0);
        let normal = turned * normal_times_two_areas(corners);
        let sides = [0, 1, 2].map(|i| corners[i].distance(corners[(i + 1) % 3]));
        let width = normal.length() / sides.into_iter().fold(f64::MIN_POSITIVE, f64::max);
        let corners = corners.map(Cylindrical::from_point);
        let turns = corners.map(|c| wrap_angle(c.theta - at.theta));
        let [least, most] = turns.iter().fold([0.0_f64, 0.0_f64], |[l, m], t| [l.min(*t), m.max(*t)]);
        Self {
            at,
            corners: corners.map(|c| DVec2::new(c.x, c.r)),
            normal: cylindrical_components(normal.normalize_or_zero(), at.theta),
            area: 0.5 * normal.length(),
            width,
            turn: most - least,
        }
    }

    /// Component of the normal along a direction in the meridional plane.
    fn facing(&self, way: DVec2) -> f64 {
        self.normal.x * way.x + self.normal.y * way.y
    }
}

/// Tells the class of a facet.
struct Teller<'a> {
    channel: &'a Channel,
    band: Band,
    blades: Blades,
    /// Of a wheel with splitters.
    group: Option<Group>,
    /// Radii of the fillets at hub and shroud (mm).
    fillets: [Option<f64>; 2],
}

/// Where a facet lies against one of the end walls.
struct Beside {
    /// Least and greatest distance of its corners from the wall (mm).
    off: [f64; 2],
    /// Cosine of the angle between its normal and the wall's.
    facing: f64,
    /// How far its middle may lie off the wall because of chords (mm).
    chord: f64,
    /// Height of the facet above its longest side (mm).
    width: f64,
}

impl Teller<'_> {
    fn beside(&self, facet: &Facet, foot: &Foot, wall: usize) -> Option<Beside> {
        let feet = facet.corners.map(|corner| self.band.foot(corner).map(|foot| foot.off[wall]));
        let [a, b, c] = [feet[0]?, feet[1]?, feet[2]?];
        let off = [a.min(b).min(c), a.max(b).max(c)];
        let chord = foot.sag[wall] + facet.at.r * (1.0 - (0.5 * facet.turn).cos());
        Some(Beside { off, facing: facet.facing(foot.normals[wall]), chord, width: facet.width })
    }

    /// The radii of the fillets at hub and shroud, where there are any (mm).
    fn fillet_radii(&self, samples: &[Facet]) -> [Option<f64>; 2] {
        [0, 1].map(|wall| {
            if wall == 1 && !self.channel.shrouded {
                return None;
            }
            let estimate = |facet: &Facet| {
                let foot = self.foot(facet)?;
                let beside = self.beside(facet, &foot, wall)?;
                let radius = fillet::estimate(beside.off, beside.facing, foot.height)?;
                Some(fillet::Estimate { radius, area: facet.area, facing: beside.facing })
            };
            let estimates: Vec<_> = samples.par_iter().filter_map(estimate).collect();
            fillet::radius(&estimates, self.channel.middle().height())
        })
    }

    /// The place of a facet against hub and shroud; none outside the flow path, of which it may stand out by `share` of
    /// the height at either end.
    fn foot_within(&self, facet: &Facet, share: f64) -> Option<Foot> {
        let foot = self.band.foot(DVec2::new(facet.at.x, facet.at.r))?;
        let [first, last] = self.band.ends();
        let slack = ON_WALL.max(1e-3 * foot.height);
        let beyond = slack + share * foot.height;
        let is_within = foot.along > first - beyond && foot.along < last + beyond;
        (is_within && foot.off.iter().all(|off| *off > -slack - 0.02 * foot.height)).then_some(foot)
    }

    fn foot(&self, facet: &Facet) -> Option<Foot> {
        self.foot_within(facet, 0.0)
    }

    /// The place of a facet of hub or shroud of which no more than a part stands out of the flow path: it belongs to them as
    /// a whole, as the faces that they end in do not.
    fn foot_of_any_corner(&self, facet: &Facet) -> Option<Foot> {
        let [first, last] = self.band.ends();
        let is_within = |corner: &DVec2| {
            let inside = 1e-6 * (last - first);
            self.band.foot(*corner).is_some_and(|foot| (first + inside..last - inside).contains(&foot.along))
        };
        let foot = facet.corners.iter().any(is_within).then(|| self.foot_within(facet, f64::INFINITY)).flatten()?;
        let faces_wall = foot.normals.iter().any(|normal| facet.facing(*normal) > FACES_WALL);
        faces_wall.then_some(foot)
    }

    /// The place of a facet of a blade that stands out of the flow path at one of its ends.
    fn foot_of_standing_out(&self, facet: &Facet) -> Option<Foot> {
        let foot = self.foot_within(facet, STAND_OUT)?;
        let is_blade = foot.share > ABOVE_HUB && facet.facing(foot.normals[0]).abs() < EDGE;
        (is_blade || self.is_outer_tip(facet, &foot)).then_some(foot)
    }

    /// Whether a facet that stands out of the flow path is of a tip.
    fn is_outer_tip(&self, facet: &Facet, foot: &Foot) -> bool {
        !self.channel.shrouded && foot.share > AT_TIPS && facet.facing(-foot.normals[1]) > EDGE
    }

    fn class(&self, facet: &Facet) -> SurfaceClass {
        let is_within = self.foot(facet);
        let Some(foot) =
            is_within.or_else(|| self.foot_of_any_corner(facet)).or_else(|| self.foot_of_standing_out(facet))
        else {
            return SurfaceClass::Elsewhere;
        };
        if self.channel.whole.is_some() && facet.turn < 1e-6 {
            // The planes that a sector is cut by.
            return SurfaceClass::Elsewhere;
        }
        let walls = if self.channel.shrouded { 2 } else { 1 };
        let classes =
            [[SurfaceClass::Hub, SurfaceClass::HubFillet], [SurfaceClass::Shroud, SurfaceClass::ShroudFillet]];
        for (wall, [on_wall, in_fillet]) in classes.into_iter().enumerate().take(walls) {
            let Some(beside) = self.beside(facet, &foot, wall) else { return SurfaceClass::Elsewhere };
            let radius = self.fillets[wall];
            if fillet::is_wall(&beside, radius) {
                return on_wall;
            }
            if radius.is_some_and(|radius| fillet::holds(&beside, radius)) {
                return in_fillet;
            }
            if beside.off[1] <= 0.0 {
                return SurfaceClass::Elsewhere;
            }
        }
        let is_tip = facet.facing(-foot.normals[1]) > FACES_WALL && foot.off[1] < ON_WALL.max(0.01 * foot.height);
        if walls == 1 && (is_tip || (is_within.is_none() && self.is_outer_tip(facet, &foot))) {
            return SurfaceClass::Tip;
        }
        let blade =
            self.group.as_ref().and_then(|group| group.blade(DVec2::new(facet.at.x, facet.at.r), facet.at.theta));
        let OfGroup { is_main, camber } =
            blade.unwrap_or_else(|| OfGroup { is_main: true, camber: self.blades.camber(foot.along, foot.share) });
        let up = (foot.normals[0] - foot.normals[1]).extend(0.0).normalize_or(DVec3::Y);
        if facet.normal.dot(camber.cross(up).normalize_or_zero()).abs() > EDGE {
            return SurfaceClass::Edge;
        }
        match (is_main, facet.normal.dot(camber) > 0.0) {
            (true, true) => SurfaceClass::MainLow,
            (true, false) => SurfaceClass::MainHigh,
            (false, true) => SurfaceClass::SplitterLow,
            (false, false) => SurfaceClass::SplitterHigh,
        }
    }
}
