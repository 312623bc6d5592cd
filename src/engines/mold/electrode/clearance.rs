//! Distance of an electrode from the mold, in the burning position and on the way in and out.

use std::f64::consts::PI;

use glam::{DAffine3, DVec2, DVec3};
use rayon::prelude::*;

use super::finding::{CheckKind, Finding};
use super::params::{Orbit, Stage};
use super::setting::ElectrodeError;
use super::setting::GOUGE;
use geometry::exact::{ExactMesh, ExactMeshError};
use geometry::inside::winding_number;
use geometry::mesh::{Mesh, unit_normal};
use geometry::minkowski::{on_grid, with_rectangle};
use geometry::offset::offset;
use task::Cancel;

/// How much nearer an electrode comes between the sampled places of its orbit, at most (mm).
const BULGE: f64 = 2e-4;
/// Least half distance of the sampled places (mm): smaller ones belong to gaps of a few micrometres, which no spark has.
const LEAST_STEP: f64 = 1e-3;

/// A mold that electrodes must keep clear of.
pub struct Obstacle {
    mesh: ExactMesh,
    surface: Mesh,
    cancel: Cancel,
}

impl Obstacle {
    /// A mold.
    ///
    /// # Errors
    /// [`ExactMeshError`].
    pub fn new(mold: &Mesh) -> Result<Self, ExactMeshError> {
        Ok(Self { mesh: ExactMesh::new(mold)?, surface: mold.clone(), cancel: Cancel::default() })
    }

    /// Obstacle whose long computations are stopped by `cancel`.
    pub fn stopped_by(self, cancel: &Cancel) -> Self {
        Self { cancel: cancel.clone(), ..self }
    }

    /// Distance from a point to its surface (mm).
    pub fn distance(&self, p: DVec3) -> f64 {
        self.mesh.nearest(p).signed_distance.abs()
    }

    /// Distance from a point to its surface, negative within (mm), and the unit vector to the point from the nearest of
    /// it.
    pub(super) fn off(&self, p: DVec3) -> (f64, DVec3) {
        let nearest = self.mesh.nearest(p);
        (nearest.signed_distance, (p - nearest.point).normalize_or_zero())
    }

    /// Whether the mold stands between a place beside it and one far away in the direction of a unit vector.
    pub(super) fn is_hidden(&self, p: DVec3, from: DVec3) -> bool {
        /// Further than any mold is large (mm).
        const FAR: f64 = 1e5;
        self.mesh.first_crossing(p, from, FAR).is_some()
    }

    /// Whether the mold hangs over a place beside it seen from afar in the direction of a unit vector, or over one within
    /// a distance of that across the direction (mm).
    pub(super) fn hangs_over(&self, p: DVec3, within: f64, from: DVec3) -> bool {
        /// Directions in which it is looked for.
        const AROUND: usize = 8;
        // From within the mold every way leads through it.
        let is_over = |p: DVec3| self.mesh.nearest(p).signed_distance > 0.0 && self.is_hidden(p, from);
        let (x, y) = from.any_orthonormal_pair();
        let around = |i: usize| {
            let at = DVec2::from_angle(i as f64 * 2.0 * PI / AROUND as f64) * within;
            x * at.x + y * at.y
        };
        is_over(p) || (within > 0.0 && (0..AROUND).map(around).any(|off| is_over(p + off)))
    }

    /// Least distance of the electrode from the mold (mm), in the burning position and on its way straight up by `lift`
    /// (mm).
    ///
    /// The boundary of the volume that a moving body sweeps consists of its first and last position and of the surfaces
    /// swept by its edges; these are compared with the mold exactly. The holder needs no check: base and holder begin
    /// above the highest point of the mold by the extension.
    ///
    /// # Errors
    /// [`ElectrodeError::Exact`], [`ElectrodeError::Cancelled`].
    pub fn clearance(&self, electrode: &Mesh, stage: &Stage, lift: f64) -> Result<Clearance, ElectrodeError> {
        // Without a gap surfaces touch, and touching cannot be told from crossing: the electrode is tried a hair
        // smaller.
        let (hair, smaller);
        let electrode = if stage.gap_mm + stage.stock_mm < 2.0 * GOUGE {
            hair = 2.0 * GOUGE;
            smaller = inset(electrode, hair);
            &smaller
        } else {
            hair = 0.0;
            electrode
        };
        let inside = self.inside(electrode);
        let near = |mesh: &Mesh, shifts: &[DVec3]| -> Result<Near, ElectrodeError> {
            let exact = ExactMesh::new(mesh)?;
            let (distance, shift) = self.least(&exact, shifts)?;
            let distance = distance - hair;
            let is_near = distance < needed(stage) && inside.is_none();
            let place = if is_near { self.contact((mesh, &exact), shift) } else { None };
            Ok(Near { distance, place })
        };
        // What a square orbit sweeps is a solid of its own.
        let square = match stage.orbit {
            Orbit::Square { radius_mm } => with_rectangle(&on_grid(electrode), DVec2::splat(radius_mm)).ok(),
            _ => None,
        };
        let burning = match &square {
            Some(swept) => near(swept, &[DVec3::ZERO])?,
            None => near(electrode, &burning_places(stage))?,
        };
        let way = near(&swept(electrode, lift), &[DVec3::ZERO])?;
        Ok(Clearance { near: [burning, way], inside })
    }

    /// Least distance of a body at these shifts, with the first shift that has it.
    fn least(&self, body: &ExactMesh, shifts: &[DVec3]) -> Result<(f64, DVec3), ElectrodeError> {
        let at = |shift: &DVec3| -> Result<(f64, DVec3), ElectrodeError> {
            self.cancel.check()?;
            Ok((self.mesh.distance_to(body, &DAffine3::from_translation(*shift)), *shift))
        };
        let all = shifts.par_iter().map(at).collect::<Result<Vec<_>, _>>()?;
        // A distance that could not be measured counts as none.
        let nearer = |a: (f64, DVec3), b: (f64, DVec3)| if b.0 < a.0 || b.0.is_nan() { b } else { a };
        Ok(all.into_iter().fold((f64::INFINITY, DVec3::ZERO), nearer))
    }

    /// Whether a body beside the burning tips keeps the gap, in place and on its way.
    ///
    /// # Errors
    /// [`ElectrodeError::Exact`], [`ElectrodeError::Cancelled`].
    pub fn keeps_clear(&self, beside: &Mesh, stage: &Stage, lift: f64) -> Result<bool, ElectrodeError> {
        // Most of what does not is told by a corner.
        if beside.vertices.iter().any(|p| self.off(*p).0 < stage.gap_mm + stage.stock_mm) {
            return Ok(false);
        }
        Ok(self.clearance(beside, stage, lift)?.findings(stage).iter().all(|finding| finding.holds))
    }

    /// A vertex inside the mold.
    fn inside(&self, electrode: &Mesh) -> Option<DVec3> {
        let is_inside = |p: &&DVec3| self.distance(**p) > GOUGE && winding_number(&self.mesh, **p) != 0;
        electrode.vertices.iter().find(is_inside).copied()
    }

    /// Place where a shifted body is nearest to the mold or crosses its surface.
    fn contact(&self, (mesh, exact): (&Mesh, &ExactMesh), shift: DVec3) -> Option<DVec3> {
        /// Further than any body comes near (mm).
        const FAR: f64 = 1e3;
        let nearest = |a: &DVec3, b: &DVec3| self.distance(*a).total_cmp(&self.distance(*b));
        let crossing = || {
            let own = edges(mesh).find_map(|[a, b]| crossed(&self.mesh, a + shift, b + shift));
            let of_mold = || edges(&self.surface).find_map(|[a, b]| crossed(exact, a - shift, b - shift));
            own.or_else(|| of_mold().map(|p| p + shift))
        };
        let vertex = || mesh.vertices.iter().map(|p| *p + shift).min_by(nearest);
        self.mesh.nearest_to(exact, shift, FAR).or_else(crossing).or_else(vertex)
    }
}

/// The edges of a mesh, each from both of its faces.
fn edges(mesh: &Mesh) -> impl Iterator<Item = [DVec3; 2]> + '_ {
    mesh.iter_corners().flat_map(|[a, b, c]| [[a, b], [b, c], [c, a]])
}

/// First crossing of the line between two points with a surface.
fn crossed(surface: &ExactMesh, from: DVec3, to: DVec3) -> Option<DVec3> {
    let along = (to - from).try_normalize()?;
    surface.first_crossing(from, along, from.distance(to)).map(|t| from + along * t)
}

/// Required distance of a body from the mold (mm).
fn needed(stage: &Stage) -> f64 {
    stage.gap_mm + stage.stock_mm - GOUGE
}

/// Distance of a body.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Near {
    /// Least distance (mm).
    distance: f64,
    /// Place of the least distance, if that is too small.
    place: Option<DVec3>,
}

/// Distances of an electrode from the mold.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Clearance {
    /// Distance in the burning position, and on the way in and out.
    near: [Near; 2],
    /// A vertex of the electrode inside the mold.
    inside: Option<DVec3>,
}

impl Clearance {
    /// The worse of two: for each check the lesser distance.
    pub fn worse(self, other: Self) -> Self {
        let nearer = |a: Near, b: Near| if b.distance < a.distance || b.distance.is_nan() { b } else { a };
        let near = [nearer(self.near[0], other.near[0]), nearer(self.near[1], other.near[1])];
        Self { near, inside: self.inside.or(other.inside) }
    }

    /// Checks that the gap of a stage is kept in the burning position, and on the way in and out.
    pub fn findings(&self, stage: &Stage) -> [Finding; 2] {
        let asked = if stage.stock_mm > 0.0 {
            format!("gap {:.4} mm and stock {:.4} mm", stage.gap_mm, stage.stock_mm)
        } else {
            format!("gap {:.4} mm", stage.gap_mm)
        };
        let of = |kind: CheckKind, Near { distance, place }: Near, way: &str| {
            let (holds, found) = (distance >= needed(stage) && self.inside.is_none(), distance.max(0.0));
            let text = if self.inside.is_some() {
                format!("{way} the electrode is inside the mold")
            } else if holds {
                format!("{way} the distance to the mold is {found:.4} mm (required: {asked})")
            } else {
                format!(
                    "{way} the distance to the mold is only {found:.4} mm (required: {asked}); reduce the spark gap \
                     or the depth of the burn"
                )
            };
            let figure = match self.inside {
                Some(_) => ("inside_mm", distance.abs()),
                None => ("missing_mm", needed(stage) - distance),
            };
            Finding::new(kind, holds, text, if holds { None } else { self.inside.or(place) }).with(&[figure])
        };
        let [burning, way] = self.near;
        [of(CheckKind::Gouge, burning, "where it burns"), of(CheckKind::Approach, way, "on approach and retraction")]
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

/// Places of an electrode that burns: the middle of its orbit, and so many along it that the electrode comes nowhere nearer
/// than at one of them by more than [`BULGE`].
fn burning_places(stage: &Stage) -> Vec<DVec3> {
    // Where it comes nearest the way to the mold is across the orbit, so that after a step along it the distance is
    // the hypotenuse of both.
    let gap = stage.gap_mm + stage.stock_mm;
    let step = ((gap + BULGE).powi(2) - gap * gap).sqrt().max(LEAST_STEP);
    let along: Vec<DVec2> = match stage.orbit {
        Orbit::None => Vec::new(),
        Orbit::Circular { radius_mm } => {
            let half = (step / radius_mm.max(step)).min((1.0 - BULGE / radius_mm.max(BULGE)).acos());
            let count = (PI / half).ceil().max(8.0);
            let around = |i: usize| DVec2::from_angle(i as f64 * 2.0 * PI / count);
            (0..count as usize).map(|i| around(i) * radius_mm).collect()
        }
        Orbit::Square { radius_mm: r } => {
            let count = (r / step).ceil().max(1.0) as usize;
            let side = |i: usize| DVec2::new(r, r * (2.0 * i as f64 / count as f64 - 1.0));
            let sides = [DVec2::X, DVec2::Y, DVec2::NEG_X, DVec2::NEG_Y].into_iter();
            sides.flat_map(|way| (0..count).map(move |i| way.rotate(side(i)))).collect()
        }
    };
    std::iter::once(DVec3::ZERO).chain(along.into_iter().map(|p| p.extend(0.0))).collect()
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
