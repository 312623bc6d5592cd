//! Checks that nothing may skip: whether an electrode is closed, enters nothing on its way, leaves nothing, and can be
//! milled.

use std::f64::consts::PI;

use glam::{DAffine3, DMat3, DVec2, DVec3};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::burning::Burning;
use super::params::{Orbit, Stage};
use crate::geometry::exact::{ExactMesh, ExactMeshError};
use crate::geometry::inside::winding_number;
use crate::geometry::mesh::{Mesh, unit_normal};
use crate::geometry::offset::offset;
use crate::geometry::solid;
use crate::mold::cutter::CutterLibrary;
use crate::mold::height_field::{self, HeightField, HeightFieldError};
use crate::mold::invert::InvertFaces;
use crate::progress::{Cancel, Cancelled};

/// By how much an electrode may come closer than the gap (mm): rounding of files, not of sparks.
pub const GOUGE: f64 = 5e-4;
/// Vertices within this are one in a file of single precision (mm).
const WELD: f64 = 1e-6;
/// How far an orbit may bulge beyond the places of it that are tried (mm).
const BULGE: f64 = 2e-4;
/// Cells of the smallest radius on the grid on which it is tried whether an electrode can be milled.
const MILLING_CELLS: f64 = 20.0;
/// Area of faces that look away from the cutters up to which it is rounding (mm^2).
const LEAST_INVERT: f64 = 1e-2;
/// How near to the burn surface a march along a normal ends (mm).
const ARRIVED: f64 = 1e-6;
/// Share of a distance by which a point above a face is nearer to another one if it is in a corner.
const CORNER: f64 = 1e-3;
/// A step of such a march, at least (mm).
const LEAST_STEP: f64 = 1e-4;
/// Steps of such a march, at most.
const STEPS: usize = 200;

/// What a check is about.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum CheckKind {
    /// The surface is closed.
    Watertight,
    /// Where it burns it keeps the gap.
    Gouge,
    /// On its way in and out it keeps the gap.
    Approach,
    /// What it was made for is burned.
    Leftover,
    /// It can be milled.
    Machinable,
}

impl CheckKind {
    /// All of them, in the order in which they are made.
    pub const ALL: [Self; 5] = [Self::Watertight, Self::Gouge, Self::Approach, Self::Leftover, Self::Machinable];

    /// How it is called.
    pub fn name(self) -> &'static str {
        match self {
            Self::Watertight => "watertight",
            Self::Gouge => "gouge",
            Self::Approach => "approach",
            Self::Leftover => "leftover",
            Self::Machinable => "machinable",
        }
    }
}

/// What a check found.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Finding {
    /// What it is about.
    pub kind: CheckKind,
    /// Whether it holds.
    pub holds: bool,
    /// What was found, in words with its figures.
    pub text: String,
    /// Where, in the upright mold (mm).
    pub place: Option<DVec3>,
}

impl Finding {
    fn new(kind: CheckKind, holds: bool, text: String, place: Option<DVec3>) -> Self {
        Self { kind, holds, text, place }
    }

    /// One that does not hold.
    pub(super) fn failed(kind: CheckKind, text: String) -> Self {
        Self::new(kind, false, text, None)
    }
}

/// Whether a surface is closed.
pub fn watertight(mesh: &Mesh) -> Finding {
    let volume = mesh.volume();
    let is_closed = mesh.is_watertight() && solid::is_closed(mesh, WELD);
    let holds = is_closed && volume > 0.0;
    let text = if holds {
        format!("closed; {volume:.2} mm^3")
    } else if is_closed {
        format!("its faces look inwards ({volume:.2} mm^3): turn them round")
    } else {
        "its surface has open edges or touches itself: no other check means anything".into()
    };
    Finding::new(CheckKind::Watertight, holds, text, None)
}

/// A mold that electrodes must keep clear of.
pub struct Obstacle {
    mesh: ExactMesh,
    surface: Mesh,
}

impl Obstacle {
    /// A mold.
    ///
    /// # Errors
    /// [`ExactMeshError`].
    pub fn new(mold: &Mesh) -> Result<Self, ExactMeshError> {
        Ok(Self { mesh: ExactMesh::new(mold)?, surface: mold.clone() })
    }

    /// The same mold, turned.
    ///
    /// # Errors
    /// [`ExactMeshError`].
    pub fn turned(&self, by: &DMat3) -> Result<Self, ExactMeshError> {
        Self::new(&self.surface.mapped(|p| *by * p))
    }

    /// Distance from a point to its surface (mm).
    pub fn distance(&self, p: DVec3) -> f64 {
        self.mesh.nearest(p).signed_distance.abs()
    }

    /// Distance from a point to its surface, negative within (mm).
    fn height_above(&self, p: DVec3) -> f64 {
        self.mesh.nearest(p).signed_distance
    }

    /// How near the electrode, which stands where it burns, comes to the mold there and on its way straight up by `lift` (mm).
    ///
    /// While a body moves, the boundary of what it sweeps is made of its first and last place and of what its edges
    /// sweep: these are held against the mold exactly.
    /// The holder needs none: the base, and all that is above it, begins higher than any point of the mold by the extension.
    ///
    /// # Errors
    /// [`ExactMeshError`].
    pub fn clearance(&self, electrode: &Mesh, stage: &Stage, lift: f64) -> Result<Clearance, ExactMeshError> {
        // Without a gap surfaces touch, and touching cannot be told from crossing: the electrode is tried a hair smaller.
        let (hair, smaller);
        let electrode = if stage.gap_mm + stage.stock_mm < 2.0 * GOUGE {
            hair = 2.0 * GOUGE;
            smaller = inset(electrode, hair);
            &smaller
        } else {
            hair = 0.0;
            electrode
        };
        let least = |mesh: &Mesh, shift: DVec3| -> Result<f64, ExactMeshError> {
            Ok(self.mesh.distance_to(&ExactMesh::new(mesh)?, &DAffine3::from_translation(shift)) - hair)
        };
        let mut burning = least(electrode, DVec3::ZERO)?;
        for shift in orbit_places(stage.orbit) {
            burning = burning.min(least(electrode, shift)?);
        }
        let way = least(&swept(electrode, lift), DVec3::ZERO)?;
        Ok(Clearance {
            distances: [burning, way],
            inside: self.inside(electrode),
            nearest: self.nearest_place(electrode),
        })
    }

    /// Whether a body that stands beside the tips that burn keeps the gap there and on its way.
    ///
    /// # Errors
    /// [`ExactMeshError`].
    pub fn keeps_clear(&self, beside: &Mesh, stage: &Stage, lift: f64) -> Result<bool, ExactMeshError> {
        // Most of what does not is told by a corner.
        if beside.vertices.iter().any(|p| self.height_above(*p) < stage.gap_mm + stage.stock_mm) {
            return Ok(false);
        }
        Ok(self.clearance(beside, stage, lift)?.findings(stage).iter().all(|finding| finding.holds))
    }

    /// A vertex that stands inside the mold.
    fn inside(&self, electrode: &Mesh) -> Option<DVec3> {
        let is_inside = |p: &&DVec3| self.distance(**p) > GOUGE && winding_number(&self.mesh, **p) != 0;
        electrode.vertices.iter().find(is_inside).copied()
    }

    /// The vertex that comes nearest.
    fn nearest_place(&self, electrode: &Mesh) -> Option<DVec3> {
        let nearest = |a: &&DVec3, b: &&DVec3| self.distance(**a).total_cmp(&self.distance(**b));
        electrode.vertices.iter().min_by(nearest).copied()
    }
}

/// How near an electrode comes to the mold.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Clearance {
    /// Least distance where it burns, and on its way in and out (mm).
    distances: [f64; 2],
    /// A vertex of it that stands inside the mold.
    inside: Option<DVec3>,
    /// The vertex that comes nearest.
    nearest: Option<DVec3>,
}

impl Clearance {
    /// The worse of two: what stands inside the mold is worse than what comes near it.
    pub fn worse(self, other: Self) -> Self {
        let badness = |c: &Self| (c.inside.is_some(), -c.distances[0].min(c.distances[1]));
        if badness(&other) > badness(&self) { other } else { self }
    }

    /// Whether the gap of a stage is kept where it burns, and on the way in and out.
    pub fn findings(&self, stage: &Stage) -> [Finding; 2] {
        let (needed, gap) = (stage.gap_mm + stage.stock_mm - GOUGE, stage.gap_mm);
        let of = |kind: CheckKind, found: f64, way: &str| {
            let holds = found >= needed && self.inside.is_none();
            let text = if self.inside.is_some() {
                format!("{way} it stands inside the mold")
            } else if holds {
                format!("{way} it keeps {:.4} mm from the mold (gap {gap:.4} mm)", found.max(0.0))
            } else {
                format!(
                    "{way} it comes to {:.4} mm of the mold, the gap is {gap:.4} mm: too deep a burn",
                    found.max(0.0)
                )
            };
            let place = if holds { None } else { self.inside.or(self.nearest) };
            Finding::new(kind, holds, text, place)
        };
        let [burning, way] = self.distances;
        [of(CheckKind::Gouge, burning, "where it burns"), of(CheckKind::Approach, way, "on its way in and out")]
    }
}

/// A closed surface moved inwards by `by` (mm); as it is where that cannot be.
fn inset(mesh: &Mesh, by: f64) -> Mesh {
    let turned = |mesh: &Mesh| Mesh {
        vertices: mesh.vertices.clone(),
        triangles: mesh.triangles.iter().map(|[a, b, c]| [*a, *c, *b]).collect(),
    };
    offset(&turned(mesh), |_| by).map_or_else(|_| mesh.clone(), |moved| turned(&moved))
}

/// Places of an orbit, so many that it bulges less beyond them than [`BULGE`].
fn orbit_places(orbit: Orbit) -> Vec<DVec3> {
    match orbit {
        Orbit::None => Vec::new(),
        Orbit::Circular { radius_mm } => {
            let half_step = (1.0 - BULGE / radius_mm.max(BULGE)).acos();
            let count = (PI / half_step).ceil().max(8.0);
            let around = |i: usize| DVec2::from_angle(i as f64 * 2.0 * PI / count);
            (0..count as usize).map(|i| (around(i) * radius_mm).extend(0.0)).collect()
        }
        Orbit::Square { radius_mm: r } => {
            [(r, r), (r, -r), (-r, r), (-r, -r)].into_iter().map(|(x, y)| DVec3::new(x, y, 0.0)).collect()
        }
    }
}

/// The surfaces that bound what a mesh sweeps on its way straight up.
fn swept(mesh: &Mesh, lift: f64) -> Mesh {
    let count = mesh.vertices.len() as u32;
    let mut soup = mesh.clone();
    soup.vertices.extend(mesh.vertices.iter().map(|p| *p + DVec3::Z * lift));
    soup.triangles.extend(mesh.triangles.iter().map(|t| t.map(|i| i + count)));
    let mut faces = std::collections::BTreeMap::new();
    for (i, &[a, b, c]) in mesh.triangles.iter().enumerate() {
        let up = unit_normal(mesh.corners(i)).z;
        for (from, to) in [(a, b), (b, c), (c, a)] {
            faces.entry((from.min(to), from.max(to))).or_insert_with(Vec::new).push(up);
        }
    }
    for ((a, b), ups) in faces {
        // Between two faces that both look up or both down nothing of the boundary is swept.
        let both = |is: fn(&f64) -> bool| ups.len() == 2 && ups.iter().all(is);
        let is_upright = mesh.vertices[a as usize].truncate() == mesh.vertices[b as usize].truncate();
        if !is_upright && !both(|up| *up > 1e-9) && !both(|up| *up < -1e-9) {
            soup.triangles.extend([[a, b, b + count], [a, b + count, a + count]]);
        }
    }
    soup
}

/// Whether cutters mill an electrode, turned over so that its tips look up, leaving nothing above `tolerance` (mm). Only
/// what stands on something of its own is left: tips need the base that they stand on.
///
/// # Errors
/// [`HeightFieldError`].
pub fn machinable(
    electrode: &Mesh,
    cutters: &CutterLibrary,
    tolerance: f64,
    cancel: &Cancel,
) -> Result<Finding, HeightFieldError> {
    let over = electrode.mapped(|p| DVec3::new(p.x, -p.y, -p.z));
    let radius = cutters.needed().iter().map(|c| c.radius()).fold(f64::INFINITY, f64::min);
    let field = HeightField::raster(&over, (radius / MILLING_CELLS).min(1.25 * tolerance.max(0.02)), cancel)?;
    let closing = height_field::closing(&field, cutters, cancel)?;
    let left = height_field::regions(&field, &closing, tolerance, cancel)?;
    let invert = InvertFaces::of(&over).area;
    let back = |p: DVec3| DVec3::new(p.x, -p.y, -p.z);
    Ok(match left.first() {
        Some(worst) => {
            let text = format!(
                "the cutters leave {} places on it, {:.3} mm^3 in all, up to {:.3} mm thick: divide it there, or add a smaller cutter",
                left.len(),
                left.iter().map(|r| r.volume).sum::<f64>(),
                left.iter().map(|r| r.normal_depth).fold(0.0, f64::max)
            );
            Finding::new(CheckKind::Machinable, false, text, Some(back(worst.bounds.center())))
        }
        None if invert > LEAST_INVERT => {
            let text = format!("{invert:.3} mm^2 of it look away from the cutters");
            Finding::new(CheckKind::Machinable, false, text, None)
        }
        None => Finding::new(CheckKind::Machinable, true, "the cutters leave nothing of it".into(), None),
    })
}

/// A part of a mold's surface that cutters leave, as leftovers are looked for on it.
#[derive(Debug, Clone, Copy)]
pub struct Sample {
    /// Its middle (mm).
    pub point: DVec3,
    /// Its unit normal.
    pub normal: DVec3,
    /// Its area (mm^2).
    pub area: f64,
    /// How thick at most the cutters leave it (mm).
    pub thickest: f64,
}

/// What burns leave of a region.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct LeftOfRegion {
    /// Greatest distance from the mold's surface (mm).
    pub thickness: f64,
    /// The same without what the gap's radius keeps in corners (mm).
    pub excess: f64,
    /// Where that is greatest; where there is none, where the thickness is.
    pub place: DVec3,
    /// Volume (mm^3).
    pub volume: f64,
}

impl LeftOfRegion {
    /// What is left of both: what is thickest, the place of the greater excess, the volumes together.
    pub(super) fn and(self, other: Self) -> Self {
        let (volume, thickness) = (self.volume + other.volume, self.thickness.max(other.thickness));
        // Where no excess is, the place is that of the greatest thickness.
        let is_worse = (other.excess, other.thickness) > (self.excess, self.thickness);
        Self { volume, thickness, ..if is_worse { other } else { self } }
    }
}

/// Where cutters leave something, known to `within` (mm).
pub struct Milled<'a> {
    /// Whether they leave it at a point, or within that distance of it.
    pub leaves: &'a (dyn Fn(DVec3) -> bool + Sync),
    /// How far off the answer may be (mm).
    pub within: f64,
}

/// What `burns` leave on samples of a region's surface, of what the cutters left.
///
/// # Errors
/// [`Cancelled`].
pub fn left_by(
    burns: &[&Burning],
    samples: &[Sample],
    (mold, milled): (&Obstacle, &Milled),
    cancel: &Cancel,
) -> Result<LeftOfRegion, Cancelled> {
    let of = |sample: &Sample| -> Result<LeftOfRegion, Cancelled> {
        cancel.check()?;
        Ok(left_at(burns, sample, mold, milled))
    };
    let all = samples.par_iter().map(of).collect::<Result<Vec<_>, _>>()?;
    Ok(all.into_iter().fold(LeftOfRegion::default(), LeftOfRegion::and))
}

fn left_at(burns: &[&Burning], sample: &Sample, mold: &Obstacle, milled: &Milled) -> LeftOfRegion {
    let at = |t: f64| sample.point + sample.normal * t;
    let beyond = |t: f64| burns.iter().map(|burn| burn.beyond(at(t))).fold(f64::INFINITY, f64::min);
    // Along an edge a normal runs beside another face: what is left there is as thick as it is far from any face.
    let (mut along, mut thickness) = (0.0, 0.0f64);
    for _ in 0..STEPS {
        let step = beyond(along);
        if step <= ARRIVED || along >= sample.thickest {
            break;
        }
        // Where it is not known to a cell whether the cutters leave it, small steps.
        let on = f64::min(along + step.clamp(LEAST_STEP, milled.within.max(LEAST_STEP)), sample.thickest);
        let off = mold.height_above(at(on));
        if off <= 0.0 {
            break;
        }
        if !(milled.leaves)(at(on)) {
            let back = 1.5 * milled.within;
            (along, thickness) = (f64::max(along - back, 0.0), f64::max(thickness - back, 0.0));
            break;
        }
        along = on;
        thickness = thickness.max(along.min(off));
    }
    // What lies nearer to another face is counted there.
    let own = if along > ARRIVED { along.min(mold.distance(at(along))) } else { 0.0 };
    // A corner is where another face lies within the reach of the spark.
    let is_in_corner = |reach: f64| mold.distance(at(reach)) < reach * (1.0 - CORNER);
    let kept = burns.iter().map(|burn| burn.reach()).fold(0.0, f64::max);
    let excess = if thickness > 0.0 && is_in_corner(kept) {
        (thickness - (3f64.sqrt() - 1.0) * kept).max(0.0)
    } else {
        thickness
    };
    LeftOfRegion { thickness, excess, place: sample.point, volume: own * sample.area }
}

/// What is said of a square orbit where something is left.
const SQUARE: &str =
    "; a square orbit reaches only into corners of walls along X and Y: a circular one, or none, leaves less";

/// The finding for the worst of the regions that an electrode is for: what is left on faces, and in corners beyond the
/// (sqrt 3 - 1) of the spark's radius that they keep, is held against the tolerance.
pub fn leftover(left: &LeftOfRegion, tolerance: f64, stage: &Stage) -> Finding {
    let holds = left.excess <= tolerance;
    let text = if holds {
        format!(
            "at most {:.4} mm are left, in corners that the spark rounds; {:.4} mm^3 in all",
            left.thickness, left.volume
        )
    } else {
        format!(
            "{:.4} mm are left beyond what corners keep, {tolerance:.4} mm are allowed; {:.4} mm^3 in all{}",
            left.excess,
            left.volume,
            if matches!(stage.orbit, Orbit::Square { .. }) { SQUARE } else { "" }
        )
    };
    Finding::new(CheckKind::Leftover, holds, text, (!holds).then_some(left.place))
}
