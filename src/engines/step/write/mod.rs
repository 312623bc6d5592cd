//! Writer of STEP AP242: the boundary of a solid with exact and fitted faces from a closed mesh.
//!
//! The mesh is the certified shape. Its faces are found again: planes, cylinders and cones as such, everything else as
//! bicubic B-splines fitted within a stated tolerance. Edges are lines, circles or cubic B-splines that lie on both
//! faces. What the file's faces differ from the mesh by is measured both ways, as is the volume; the report says both.
//!
//! Where the faces are known as patches of the mesh, as those of an electrode made from rings are, nothing has to be found:
//! each patch is one face, and the solid stays inside of the mesh.
//!
//! How: [`geometry::segmentation`] tells faces. Edges are fitted once, along the sides of triangles between two faces. A
//! free form is a disc with four sides: its surface is a tensor product whose outer control points are those of its edges,
//! so that it meets its neighbours exactly. Free forms that are no discs, or that one surface does not fit, are cut by
//! planes; small pieces that nothing fits, and facets too coarse for a smooth surface, become plane faces.
//!
//! Guaranteed: every edge is used exactly twice, in opposite senses; the file was read again, its solids are closed, and
//! volume and distances are those of the report; the same input gives the same bytes. Not guaranteed: that the deviation is
//! within the tolerance where the mesh itself is coarser, as on a cylinder of few facets: it passes through the vertices,
//! and the report tells by how much it leaves the facets between them.

mod band;
mod brep;
mod check;
mod corners;
mod curve;
mod divide;
mod file;
mod map;
mod net;
mod patches;
mod piece;
mod quad;
mod regions;
mod skin;
mod spline;
mod surface;
#[cfg(test)]
mod tests;

use geometry::groups::Groups;
use geometry::mesh::Mesh;
use geometry::patch::Patch;
use glam::DVec3;
use step_io::AuthorError;
use task::{Cancelled, Task};

use self::brep::{Brep, FaceSurface};
use self::check::{Limits, Measures};
use self::skin::Skin;
use self::surface::Surface;

/// Purpose of faces: their name in the file, and their colour.
#[derive(Debug, Clone, PartialEq)]
pub struct Role {
    /// Name of the faces.
    pub name: String,
    /// Red, green and blue, 0 to 1; none leaves the faces without a colour.
    pub colour: Option<[f64; 3]>,
}

/// Value of a property.
#[derive(Debug, Clone, PartialEq)]
pub enum PropertyValue {
    /// Words.
    Text(String),
    /// A length (mm).
    Length(f64),
    /// An angle (rad).
    Angle(f64),
    /// A number of things.
    Count(u32),
}

/// A property of the part, such as its material, spark gap or burn position.
#[derive(Debug, Clone, PartialEq)]
pub struct Property {
    /// Name.
    pub name: String,
    /// Value.
    pub value: PropertyValue,
}

/// A face that is known.
#[derive(Debug, Clone, Copy)]
pub struct StepPatch<'a> {
    /// Vertices of the part's mesh.
    pub grid: &'a Patch,
    /// Number of its purpose in the roles of the part.
    pub role: u16,
}

/// A part to be written.
#[derive(Debug, Clone, Copy)]
pub struct StepPart<'a> {
    /// Name of the product and of its solid.
    pub name: &'a str,
    /// Surface (mm): closed, triangles counter-clockwise seen from outside.
    pub mesh: &'a Mesh,
    /// Purposes that faces can have; may be empty.
    pub roles: &'a [Role],
    /// The role of each triangle, by its place in `roles`; empty for none. Faces are divided where it changes.
    pub role_of: &'a [u16],
    /// The faces, if they are known: every triangle is in one, and neighbours share whole sides. Empty where the faces have
    /// to be found.
    pub patches: &'a [StepPatch<'a>],
    /// Properties in the order in which they are written.
    pub properties: &'a [Property],
}

/// Settings of the writer.
#[derive(Debug, Clone, PartialEq)]
pub struct StepSettings {
    /// Distance between mesh and free forms that is aimed at (mm). A file whose faces were found is refused where it is off
    /// by more than twice this, one whose faces were known where it is 0.15 mm inside of the mesh.
    pub tolerance: f64,
    /// How far faces that are known may reach beyond the mesh (mm).
    pub to_spare: f64,
    /// Time stamp of the header (ISO 8601); the file's bytes depend on nothing else that changes.
    pub time_stamp: String,
    /// Name of the program in the header.
    pub originating_system: String,
}

impl Default for StepSettings {
    fn default() -> Self {
        Self {
            tolerance: 0.005,
            to_spare: 0.003,
            time_stamp: "2000-01-01T00:00:00Z".to_owned(),
            originating_system: "Sparkpath".to_owned(),
        }
    }
}

/// Counts of a written file, and its distances from the mesh.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct StepReport {
    /// Solids: one for every part of the mesh that hangs together.
    pub solids: usize,
    /// Plane faces.
    pub planes: usize,
    /// Cylindrical faces.
    pub cylinders: usize,
    /// Conical faces.
    pub cones: usize,
    /// B-spline faces.
    pub free_forms: usize,
    /// Edges.
    pub edges: usize,
    /// Greatest distance from a vertex or triangle centre of the mesh to the file's faces (mm).
    pub mesh_to_file_mm: f64,
    /// Greatest distance of the file's faces and edges outside of the mesh (mm).
    pub outside_mm: f64,
    /// Greatest distance of the file's faces and edges inside of the mesh (mm).
    pub inside_mm: f64,
    /// How far the triangles of the file that were compared may leave its faces (mm): the other distances are known to
    /// this.
    pub unsure_mm: f64,
    /// Greatest distance of an edge's curve from the planes, cylinders and cones beside it (mm).
    pub edge_gap_mm: f64,
    /// Volume of the file's solids (mm^3).
    pub volume_mm3: f64,
    /// Volume of the mesh (mm^3).
    pub mesh_volume_mm3: f64,
}

impl StepReport {
    /// Number of faces.
    pub fn faces(&self) -> usize {
        self.planes + self.cylinders + self.cones + self.free_forms
    }

    /// The greatest distance between mesh and file, both ways (mm).
    pub fn deviation_mm(&self) -> f64 {
        self.mesh_to_file_mm.max(self.outside_mm).max(self.inside_mm)
    }
}

/// A STEP file with its report.
#[derive(Debug, Clone, PartialEq)]
pub struct StepFile {
    /// Text of the file.
    pub bytes: Vec<u8>,
    /// Counts and distances.
    pub report: StepReport,
}

/// Reason why no STEP file is written.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum StepWriteError {
    /// A tolerance that is no length.
    #[error("the tolerance of a STEP file must be greater than 0 mm, it is {0}; take a tenth of the spark gap")]
    Tolerance(f64),
    /// Faces that cannot be drawn in far enough.
    #[error("its faces may reach {distance:.4} mm beyond the mesh that was checked at ({:.2}, {:.2}, {:.2}) mm, and {to_spare:.4} mm are to spare; a usual cause is triangles that are twisted beside a fillet; leave more clearance, or take the mesh", at.x, at.y, at.z)]
    Beyond {
        /// Place (mm).
        at: DVec3,
        /// How far they may reach (mm).
        distance: f64,
        /// Room beyond the mesh (mm).
        to_spare: f64,
    },
    /// Less to spare beyond the mesh than can be measured.
    #[error(
        "{to_spare:.4} mm are to spare beyond the mesh that was checked, and less than {least} mm is not measured; leave more clearance, or take the mesh"
    )]
    ToSpare {
        /// Room beyond the mesh (mm).
        to_spare: f64,
        /// The least that is measured (mm).
        least: f64,
    },
    /// No triangles, or coordinates that are no numbers.
    #[error("the mesh has no triangles, or coordinates that are no numbers, so that it cannot become a STEP solid")]
    Unusable,
    /// A mesh too large for its numbers.
    #[error("the mesh has too many triangles for a STEP file; make it coarser")]
    TooLarge,
    /// A side that has not exactly one triangle on both sides.
    #[error("the mesh is not closed, or touches itself along an edge, at ({:.3}, {:.3}, {:.3}) mm; repair it before it is written as STEP", at.x, at.y, at.z)]
    NotClosed {
        /// Middle of the side (mm).
        at: DVec3,
    },
    /// A part of the mesh that is inside out.
    #[error("the mesh has a cavity or is inside out at ({:.3}, {:.3}, {:.3}) mm; a STEP electrode is one solid without cavities", at.x, at.y, at.z)]
    Cavity {
        /// A vertex of it (mm).
        at: DVec3,
    },
    /// A free form that cannot be fitted.
    #[error("the surface at ({:.3}, {:.3}, {:.3}) mm cannot be fitted within {tolerance} mm: it is off by {distance:.4} mm; allow a greater tolerance or make the mesh finer there", at.x, at.y, at.z)]
    Fit {
        /// The place farthest off (mm).
        at: DVec3,
        /// Distance there (mm).
        distance: f64,
        /// The tolerance (mm).
        tolerance: f64,
    },
    /// Known faces that do not fit together.
    #[error("the faces that are given do not fit together at ({:.3}, {:.3}, {:.3}) mm: neighbours have to share whole sides, and every triangle has to be in one of them", at.x, at.y, at.z)]
    Patches {
        /// A place on a side that has no neighbour (mm).
        at: DVec3,
    },
    /// A free form that cannot be divided into faces.
    #[error("the surface at ({:.3}, {:.3}, {:.3}) mm cannot be divided into faces; make the mesh finer there, or repair it", at.x, at.y, at.z)]
    Divide {
        /// A place on it (mm).
        at: DVec3,
    },
    /// The file that was written does not read as what was meant.
    #[error(
        "the STEP file was discarded, as it does not read as a sound solid: {problem}; allow a greater tolerance or make the mesh finer there"
    )]
    Reread {
        /// The reason.
        problem: String,
        /// The place, where it is known (mm).
        at: Option<DVec3>,
    },
    /// The file leaves the mesh by too much.
    #[error("the STEP file was discarded, as it is {distance:.4} mm off the mesh at ({:.3}, {:.3}, {:.3}) mm, more than the {most:.4} mm allowed; allow a greater tolerance or make the mesh finer there", at.x, at.y, at.z)]
    Deviation {
        /// The place farthest off (mm).
        at: DVec3,
        /// Distance there (mm).
        distance: f64,
        /// The most that is allowed (mm).
        most: f64,
    },
    /// The file has another volume than the mesh.
    #[error(
        "the STEP file was discarded, as its volume is {file:.4} mm^3, that of the mesh {mesh:.4} mm^3; make the mesh finer on its curved faces"
    )]
    Volume {
        /// Volume of the file's solids (mm^3).
        file: f64,
        /// Volume of the mesh (mm^3).
        mesh: f64,
    },
    /// The file could not be composed.
    #[error("the STEP file cannot be composed: {0}")]
    File(String),
    /// Cancelled.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

impl StepWriteError {
    /// The place of what was found wrong with a file (mm).
    fn place(&self) -> Option<DVec3> {
        match self {
            Self::Reread { at, .. } => *at,
            Self::Deviation { at, .. } => Some(*at),
            _ => None,
        }
    }
}

impl From<AuthorError> for StepWriteError {
    fn from(error: AuthorError) -> Self {
        Self::File(error.to_string())
    }
}

/// Times that a region is divided because the file as it was read again is not good enough there.
const REPAIRS: usize = 6;

/// Share of the tolerance that the triangles of the file that is read may leave its faces by: of one whose faces are
/// found, and of one whose faces are known and have to stay inside of the mesh.
const CHORD: f64 = 0.2;
const FINE_CHORD: f64 = 0.1;
/// Tolerances by which a file whose faces are found may leave the mesh at any place.
const MOST_DEVIATION: f64 = 2.0;
/// Distance by which a file whose faces are known may lie inside of the mesh (mm), as it does where that is twisted between
/// its vertices: it burns that much less there, and its report says so.
const MOST_INSIDE: f64 = 0.15;
/// Share of what there is to spare beyond the mesh that the triangles by which such a file is measured may leave its faces
/// by, and the least distance that they are given (mm).
const CHORD_TO_SPARE: f64 = 0.5;
const LEAST_CHORD: f64 = 1e-4;
/// Times that known faces are drawn in where they reach beyond the mesh.
const DRAWN_IN: u32 = 12;
/// Tolerances within which known faces are fitted, one after the other until a file is good: closer fits have more knots,
/// and may wave between them.
const FITS: [f64; 2] = [1.0, 4.0];

/// Writes a part as STEP AP242.
///
/// # Errors
/// Every [`StepWriteError`].
pub fn write_step(part: &StepPart, settings: &StepSettings, task: &Task) -> Result<StepFile, StepWriteError> {
    let tolerance = settings.tolerance;
    if !(tolerance.is_finite() && tolerance > 0.0) {
        return Err(StepWriteError::Tolerance(tolerance));
    }
    let mut skin = Skin::of(part.mesh)?;
    if !part.patches.is_empty() {
        return of_patches(part, settings, task);
    }
    let mut regions = regions::regions(&mut skin, part.mesh, part.role_of, tolerance)?;
    task.check()?;
    let limits = Limits { chord: CHORD * tolerance, deviation: MOST_DEVIATION * tolerance };
    let mut repairs = 0;
    let (brep, solids, bytes, measures) = loop {
        let brep = brep::brep(&mut skin, &mut regions, tolerance, task)?;
        let shells = shells(&brep);
        without_cavities(&skin, &shells)?;
        let bytes = file::file(part, settings, &brep, &shells)?;
        let error = match check::check(&bytes, part.mesh, shells.len(), limits, task) {
            Ok(measures) => break (brep, shells.len(), bytes, measures),
            Err(error) => error,
        };
        repairs += 1;
        let is_mended = match error.place().filter(|_| repairs <= REPAIRS) {
            Some(at) => divide::mend(&mut skin, &mut regions, at, tolerance)?,
            None => false,
        };
        if !is_mended {
            return Err(error);
        }
    };
    Ok(StepFile { bytes, report: report(&brep, part, solids, &measures) })
}

/// Writes a part whose faces are known, which stay inside of the mesh.
fn of_patches(part: &StepPart, settings: &StepSettings, task: &Task) -> Result<StepFile, StepWriteError> {
    let sheet = patches::Sheet::of(part)?;
    let mut refusal = None;
    for fit in FITS {
        match drawn_in(part, settings, (sheet.clone(), fit * settings.tolerance), task) {
            Err(StepWriteError::Cancelled(cancelled)) => return Err(cancelled.into()),
            // The closest fit tells the reason best.
            Err(error) => refusal = refusal.or(Some(error)),
            Ok(file) => return Ok(file),
        }
    }
    Err(refusal.unwrap_or(StepWriteError::Unusable))
}

/// Writes a part with the faces of a sheet, fitted within `fit` (mm), drawn in until they reach beyond the mesh by no more
/// than there is to spare.
fn drawn_in(
    part: &StepPart,
    settings: &StepSettings,
    (mut sheet, fit): (patches::Sheet, f64),
    task: &Task,
) -> Result<StepFile, StepWriteError> {
    let chord = (FINE_CHORD * settings.tolerance).min(CHORD_TO_SPARE * settings.to_spare).max(LEAST_CHORD);
    let limits = Limits { chord, deviation: MOST_INSIDE };
    let mut least: Option<(f64, DVec3)> = None;
    for round in 0..=DRAWN_IN {
        task.report("faces", f64::from(round) / f64::from(DRAWN_IN), "");
        let brep = sheet.brep(fit, task)?;
        let shells = shells(&brep);
        let bytes = file::file(part, settings, &brep, &shells)?;
        let measures = match check::check(&bytes, part.mesh, shells.len(), limits, task) {
            Ok(measures) => measures,
            // Drawn in farther than the file bears: what was missing before that says why.
            Err(error) if least.is_none() || matches!(error, StepWriteError::Cancelled(_)) => return Err(error),
            Err(_) => break,
        };
        let outside = measures.file_to_mesh[0];
        if outside + measures.unsure <= settings.to_spare {
            return Ok(StepFile { bytes, report: report(&brep, part, shells.len(), &measures) });
        }
        if measures.unsure > settings.to_spare {
            return Err(StepWriteError::ToSpare { to_spare: settings.to_spare, least: LEAST_CHORD });
        }
        if least.is_none_or(|(before, _)| outside < before) {
            let farthest = measures.beyond.iter().max_by(|a, b| a.0.total_cmp(&b.0));
            least = Some((outside, farthest.map_or(measures.at, |(_, p)| *p)));
        }
        if !sheet.draw_in(&measures.beyond, task)? {
            break;
        }
    }
    let (distance, at) = least.ok_or(StepWriteError::Unusable)?;
    Err(StepWriteError::Beyond { at, distance: distance + chord, to_spare: settings.to_spare })
}

fn report(brep: &Brep, part: &StepPart, solids: usize, measures: &Measures) -> StepReport {
    let mut report = count(brep);
    report.solids = solids;
    report.mesh_to_file_mm = measures.mesh_to_file;
    [report.outside_mm, report.inside_mm] = measures.file_to_mesh;
    report.unsure_mm = measures.unsure;
    report.volume_mm3 = measures.volume;
    report.mesh_volume_mm3 = part.mesh.volume();
    report
}

fn count(brep: &Brep) -> StepReport {
    let mut report = StepReport { edges: brep.edges.len(), edge_gap_mm: brep.edge_gap, ..Default::default() };
    for face in &brep.faces {
        *match &face.surface {
            FaceSurface::Exact(Surface::Plane(_)) => &mut report.planes,
            FaceSurface::Exact(Surface::Cylinder { .. }) => &mut report.cylinders,
            FaceSurface::Exact(Surface::Cone { .. }) => &mut report.cones,
            FaceSurface::Free(_) => &mut report.free_forms,
        } += 1;
    }
    report
}

/// The faces of every solid: those that hang together across edges.
fn shells(brep: &Brep) -> Vec<Vec<usize>> {
    let mut faces_of = vec![Vec::new(); brep.edges.len()];
    for (f, face) in brep.faces.iter().enumerate() {
        face.loops.iter().flatten().for_each(|&(edge, _)| faces_of[edge].push(f));
    }
    let mut groups = Groups::of(brep.faces.len());
    for faces in faces_of {
        faces.windows(2).for_each(|pair| groups.join(pair[0], pair[1]));
    }
    let (shell_of, count) = groups.numbers();
    let mut shells = vec![Vec::new(); count];
    shell_of.into_iter().enumerate().for_each(|(face, shell)| shells[shell as usize].push(face));
    shells
}

/// Denies shells of regions that enclose less than nothing.
fn without_cavities(skin: &Skin, shells: &[Vec<usize>]) -> Result<(), StepWriteError> {
    let mut shell_of = vec![0; shells.iter().map(Vec::len).sum()];
    for (shell, faces) in shells.iter().enumerate() {
        faces.iter().for_each(|&face| shell_of[face] = shell);
    }
    let mut volumes = vec![(0.0, DVec3::ZERO); shells.len()];
    for (i, &region) in (0u32..).zip(&skin.region) {
        let [a, b, c] = skin.corners(i);
        let shell = &mut volumes[shell_of[region as usize]];
        *shell = (shell.0 + a.dot(b.cross(c)), a);
    }
    match volumes.iter().find(|v| v.0 <= 0.0) {
        Some(&(_, at)) => Err(StepWriteError::Cavity { at }),
        None => Ok(()),
    }
}
