//! The steps before the plan, each a pure function of what it is given: the part, its channel, its electrodes.

use std::path::Path;
use std::sync::Arc;

use glam::DVec3;

use super::measured::MeasuredWalls;
use super::plan::sides;
use super::planned::inputs_of;
use super::prepared_blisk::electrode_of;
use crate::workspaces::blisk::document::job_file::field_table::FIELDS;
use crate::workspaces::blisk::document::job_file::{BladesFrom, MeasuredBlades, PlanJob};
use crate::workspaces::blisk::report::InputFile;
use crate::workspaces::blisk::scene::residual_stock::MapShape;
use crate::workspaces::blisk::scene::shapes::{ChannelShapes, channel_shapes};
use files::Params as _;
use geometry::exact::ExactMesh;
use geometry::mesh::Mesh;
use import::{CadFaces, ImportOptions, ImportReport, Imported, Reading, Units, import_file};
use render::mesh::RenderMesh;
use task::Task;
use wheel::centreline::{Centreline, CentrelineError};
use wheel::channel::Channel;
use wheel::electrode::{Electrode, ElectrodeError};
use wheel::find_channel::find_or_refuse;
use wheel::parametric::MeshResolution;
use wheel::parametric::wheel::ParametricWheel;
use wheel::sections::{MeasuredSection, read_sections_file};

/// The meshes of a job as loaded.
#[derive(Debug, Clone)]
pub struct Part {
    /// What to call it.
    pub name: String,
    /// The blisk (mm, in the axes of its file).
    pub mesh: Arc<Mesh>,
    /// Solids beside the blisk that are in the way (mm, in its axes); none if there are no such.
    pub obstacles: Option<Arc<Mesh>>,
    /// Shape of the blisk, and of the obstacles beside it, for the screen.
    pub shape: Arc<RenderMesh>,
    /// What the import found; none for the built-in blisk.
    pub report: Option<ImportReport>,
    /// Faces of the CAD program, of a file that has them.
    pub faces: Option<Arc<CadFaces>>,
    /// The user's own electrodes in the blisk's coordinates (mm), if there are any.
    pub own_electrodes: Vec<Arc<Mesh>>,
    /// The measured sections that the blisk was made from, in its coordinates; none where it was not.
    pub sections: Arc<[MeasuredSection]>,
    /// The wheel as it comes, in the blisk's coordinates (mm); none of a full ring, or of one with an allowance.
    pub blank: Option<Arc<Mesh>>,
    /// The files for the report, the blisk's first.
    pub files: Vec<InputFile>,
}

impl Part {
    /// What tells the content of its files from any other.
    pub fn content(&self) -> String {
        self.files.iter().map(|f| f.sha256.as_str()).collect::<Vec<_>>().join("+")
    }

    /// What was read, in a sentence.
    pub fn sentence(&self) -> String {
        format!("{}: {} triangles", self.name, self.mesh.triangles.len())
    }
}

/// The channel of a part, and the part made ready for exact questions.
pub struct FoundChannel {
    /// The channel.
    pub channel: Arc<Channel>,
    /// The blisk in W.
    pub blisk: Arc<Mesh>,
    /// The blisk prepared for exact distances.
    pub exact: Arc<ExactMesh>,
    /// What is shown of it.
    pub shapes: ChannelShapes,
    /// Centreline of the channel, where there is one.
    pub centreline: Option<Arc<Centreline>>,
    /// The measured sections that the part was made from against the walls, and their map for the screen.
    pub measured: Option<(MeasuredWalls, MapShape)>,
}

impl FoundChannel {
    /// What was found, in a sentence.
    pub fn sentence(&self) -> String {
        format!("{} blades, throat {:.2} mm", self.channel.blades, self.channel.throat.width_mm)
    }
}

/// The electrodes of a channel in their final pose, in the order of their parts.
#[derive(Debug, Clone)]
pub struct Electrodes {
    /// The electrodes, in W.
    pub electrodes: Vec<Electrode>,
    /// Shapes of the electrodes for the screen.
    pub shapes: Vec<Arc<RenderMesh>>,
    /// Reason why the side that would have been taken first was not.
    pub notes: Vec<String>,
}

impl Electrodes {
    /// What was made, in a sentence.
    pub fn sentence(&self) -> String {
        let thinnest = self.electrodes.iter().map(|e| e.least_thickness_mm).fold(f64::INFINITY, f64::min);
        let count = self.electrodes.len();
        let plural = if count == 1 { "" } else { "s" };
        format!("{count} electrode{plural}, least thickness {thinnest:.2} mm")
    }
}

/// Loads the blisk and, if the job has any, the user's own electrodes. Reads files.
///
/// # Errors
/// One line naming file, place and remedy.
pub fn load(job: &PlanJob, task: &Task) -> Result<Part, String> {
    let Some(BliskMesh { mesh, obstacles, sections, file, report, faces }) = read_blisk(job, task)? else {
        return Ok(demonstration());
    };
    let mut files = vec![file];
    let mut own_electrodes = Vec::new();
    for path in job.electrode.own_meshes() {
        let own = import(path, &Reading::whole(Units::Mm), task)?;
        files.push(input_file("electrode", path, &own));
        own_electrodes.push(Arc::new(own.mesh));
    }
    let blank = read_blank(job, task)?;
    files.extend(blank.as_ref().map(|(_, file)| file.clone()));
    let mesh = Arc::new(mesh);
    let shape = Arc::new(RenderMesh::beside(&mesh, obstacles.as_ref()));
    task.check().map_err(|e| e.to_string())?;
    let (obstacles, faces) = (obstacles.map(Arc::new), faces.map(Arc::new));
    let blank = blank.map(|(mesh, _)| mesh.into());
    Ok(Part { name: job.part(), mesh, obstacles, shape, report, faces, own_electrodes, sections, blank, files })
}

/// Reads the mesh of the wheel as it comes, and what a report says of it; none of a job that has none.
///
/// # Errors
/// One line naming file, place and remedy.
pub fn read_blank(job: &PlanJob, task: &Task) -> Result<Option<(Mesh, InputFile)>, String> {
    let Some(path) = &job.burning.blank else { return Ok(None) };
    let blank = import(path, &job.blisk.reading.units.into(), task)?;
    if !blank.report.watertight {
        let path = path.display();
        return Err(format!(
            "{path}: the surface of the blank is not closed, so that it has no inside; close it in the program it came from"
        ));
    }
    let file = input_file("blank", path, &blank);
    Ok(Some((blank.mesh, file)))
}

/// The blisk of a job.
pub struct BliskMesh {
    /// The mesh (mm, in the axes of its file).
    pub mesh: Mesh,
    /// Solids beside it that are in the way; none if there are no such.
    pub obstacles: Option<Mesh>,
    /// The measured sections that it was made from, in its coordinates; none where it was not.
    pub sections: Arc<[MeasuredSection]>,
    /// What a report says of it.
    pub file: InputFile,
    /// What the import found; none where the blisk was made from blades.
    pub report: Option<ImportReport>,
    /// Faces of the CAD program, of a file that has them.
    pub faces: Option<CadFaces>,
}

/// Reads the mesh of a job's blisk, or makes it from the blades that the job has instead; none where it has neither.
///
/// # Errors
/// One line naming file, place and remedy.
pub fn read_blisk(job: &PlanJob, task: &Task) -> Result<Option<BliskMesh>, String> {
    let (mesh, sections, path, from) = match (&job.blisk.sections, &job.blisk.mesh) {
        (BladesFrom::None, None) => return Ok(None),
        (BladesFrom::None, Some(path)) => {
            let blisk = import(path, &job.blisk.reading, task)?;
            let file = input_file("blisk", path, &blisk);
            let (sections, report) = (Arc::default(), Some(blisk.report.clone()));
            let Imported { mesh, obstacles, faces, .. } = blisk;
            return Ok(Some(BliskMesh { mesh, obstacles, sections, file, report, faces }));
        }
        (BladesFrom::Measured(MeasuredBlades { file, ring, .. }), _) => {
            let wrong = |problem: &dyn std::fmt::Display| format!("{}: {problem}", file.display());
            let sections = read_sections_file(file).map_err(|e| wrong(&e))?;
            let mesh = ring.mesh(&sections, &task.cancel).map_err(|e| wrong(&e))?;
            (mesh, sections.into(), file.display().to_string(), "through measured sections")
        }
        (BladesFrom::Profile(blisk), _) => {
            let mesh = blisk.mesh(&FINE).map_err(|e| format!("blisk.sections: {e}"))?;
            (mesh, Arc::default(), job.part(), "of its profile")
        }
    };
    let file = InputFile {
        role: "blisk".to_owned(),
        path,
        // The mesh tells one blisk from another as a file would.
        sha256: mesh.digest(),
        triangles: mesh.triangles.len(),
        unit: "mm".to_owned(),
        unit_reason: format!("made by this program {from}"),
        ..Default::default()
    };
    Ok(Some(BliskMesh { mesh, obstacles: None, sections, file, report: None, faces: None }))
}

/// Resolution of blisks that are made of a profile.
const FINE: MeshResolution = MeshResolution { edge: 8, chord: 36, span: 6, pitch: 8, ring: 2 };

fn demonstration() -> Part {
    let mesh = ParametricWheel::demonstration().mesh();
    let file = InputFile {
        role: "blisk".to_owned(),
        path: "built-in demonstration blisk".to_owned(),
        triangles: mesh.triangles.len(),
        unit: "mm".to_owned(),
        unit_reason: "made by this program".to_owned(),
        ..Default::default()
    };
    let name = "Demonstration blisk".to_owned();
    let shape = Arc::new(RenderMesh::new(&mesh));
    Part {
        name,
        mesh: Arc::new(mesh),
        obstacles: None,
        shape,
        report: None,
        faces: None,
        own_electrodes: Vec::new(),
        sections: Arc::default(),
        blank: None,
        files: vec![file],
    }
}

fn import(path: &Path, reading: &Reading, task: &Task) -> Result<Imported, String> {
    let options = ImportOptions { reading: reading.clone(), ..Default::default() };
    import_file(path, &options, task).map_err(|e| e.to_string())
}

/// What a report says of a mesh file.
pub fn input_file(role: &str, path: &Path, imported: &Imported) -> InputFile {
    let report = &imported.report;
    InputFile {
        role: role.to_owned(),
        path: path.display().to_string(),
        sha256: imported.sha256.clone(),
        triangles: report.triangles_read,
        unit: report.unit.name().to_owned(),
        unit_reason: report.unit_reason.clone(),
        repairs: report.warnings.clone(),
        accuracy: report.accuracy(),
    }
}

/// Points of the centreline as it is drawn.
const LINE_POINTS: usize = 200;

/// Finds the channel. Where it is refused, `refused_at` is told the place, in the coordinates of the loaded mesh.
///
/// # Errors
/// One line for the user: what could not be found and how to give it by hand.
pub fn channel(part: &Part, job: &PlanJob, refused_at: &dyn Fn(DVec3), task: &Task) -> Result<FoundChannel, String> {
    if let Some(report) = part.report.as_ref().filter(|r| !r.watertight) {
        return Err(format!(
            "the surface is not closed ({} holes, {} edges of more than two triangles), so it has no inside and \
             nothing can be proven about it; close it in the program it came from",
            report.hole_count, report.non_manifold_edges
        ));
    }
    job.blisk.options.validate()?;
    let mut channel = find_or_refuse(&part.mesh, &job.blisk.options, task).map_err(|refused| {
        refused.at.into_iter().for_each(refused_at);
        FIELDS.labelled(&refused)
    })?;
    channel.obstacles = part.obstacles.clone();
    let blisk = Arc::new(channel.wheel_in_w(&part.mesh));
    let exact = channel.exact(&blisk).map_err(|e| e.to_string())?;
    let mut shapes = channel_shapes(&blisk, &channel, RenderMesh::new);
    let centreline = match Centreline::of_channel(&channel, &task.cancel) {
        Ok(line) => Some(line),
        Err(CentrelineError::Cancelled(cancelled)) => return Err(cancelled.to_string()),
        // Only one of the strategies needs it, and says so.
        Err(_) => None,
    };
    shapes.centreline = centreline.as_ref().map_or(Vec::new(), |line| line.polyline(LINE_POINTS));
    let centreline = centreline.map(Arc::new);
    let limit = job.blisk.sections.limit_mm();
    let measured = MeasuredWalls::of(&part.sections, &channel, limit, &task.cancel).map_err(|e| e.to_string())?;
    let measured = measured.map(|walls| {
        let shape = MapShape::new(&walls.map);
        (walls, shape)
    });
    Ok(FoundChannel { channel: channel.into(), blisk, exact: exact.into(), shapes, centreline, measured })
}

/// Makes the electrodes in the order of their places along the passage, each for the first side on which it can be made
/// of those that a plan tries.
///
/// # Errors
/// One line for the user, of all sides that are tried.
pub fn electrodes(part: &Part, found: &FoundChannel, job: &PlanJob, task: &Task) -> Result<Electrodes, String> {
    job.electrode.validate().map_err(|problem| FIELDS.in_window(&problem))?;
    let inputs = inputs_of(part, job);
    let (mut notes, mut electrodes) = (Vec::new(), Vec::new());
    for number in 0..inputs.electrodes() {
        let mut impossible = Vec::new();
        for side in sides(job, &found.channel, number).map_err(|e| FIELDS.labelled(&e))? {
            match electrode_of(&inputs, &found.channel, &found.exact, (number, side, 0.0), task) {
                Ok(electrode) => {
                    electrodes.push(electrode);
                    break;
                }
                Err(ElectrodeError::Cancelled(cancelled)) => return Err(cancelled.to_string()),
                Err(error) => impossible.push((side, error)),
            }
        }
        if electrodes.len() <= number {
            return Err(ElectrodeError::of_sides(impossible).map_or_else(String::new, |why| FIELDS.labelled(&why)));
        }
        notes.extend(impossible.iter().map(|(_, why)| FIELDS.labelled(why)));
    }
    notes.dedup();
    let shapes = electrodes.iter().map(|e| Arc::new(RenderMesh::new(&e.mesh))).collect();
    Ok(Electrodes { electrodes, shapes, notes })
}
