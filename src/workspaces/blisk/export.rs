//! Writes the results of a plan into a folder.

use std::path::Path;

use crate::workspaces::blisk::document::choice::MeshFrame;
use crate::workspaces::blisk::document::job_file::{ExportSection, PlanJob};
use crate::workspaces::blisk::job::burning::schedule_csv;
use crate::workspaces::blisk::job::job_of_plan::{face_name, job_of_plan};
use crate::workspaces::blisk::job::outcome::{PlanInputs, PlanJobError, PlanOutcome};
use crate::workspaces::blisk::job::{figures, plan_pictures, simulate};
use crate::workspaces::blisk::report::build;
use crate::workspaces::blisk::report::residual_stock::map_as_ply;
use crate::workspaces::blisk::report::{FeedLowered, InputFile, Report, ReportError, Written};
use crate::workspaces::setup::SETUP_SHEET_FILE;
use feed::certificate::Certificate;
use feed::copying::Copying;
use feed::machine_model::MachineModel;
use files::{ExportFolder, FileError};
use geometry::mesh::Mesh;
use import::stl_bytes;
use nc::approved::{Approved, NotApproved};
use nc::lines::NcError;
use nc::measuring_points::measuring_csv;
use nc::path_csv::{PathCsvError, write_copying_csv, write_path_csv};
use nc::post::{Post, PostError};
use nc::program::{NcJob, NcProgram, is_program_for};
use nc::setup_sheet::{SetUpError, setup_sheet};
use nc::step_files::{WrittenStep, length, step_words, text, written_step};
use nc::template::{JobSheet, TemplateError};
use step::write::{Role, StepPart, StepPatch};
use task::{Cancel, Cancelled, Task};
use wheel::channel::Channel;
use wheel::electrode::ElectrodeFace;

/// What the manifest of a folder calls an export of a plan.
const EXPORT: &str = "plan";
/// Names of verdicts on a plan in the manifest: a verdict on an earlier plan would be taken for one on this plan.
const VERDICTS: [&str; 2] = [VERIFY, SIMULATE];
/// What the manifest of a folder calls an export of `sparkpath verify`.
pub const VERIFY: &str = "verify";
/// What the manifest of a folder calls an export of `sparkpath simulate`.
pub const SIMULATE: &str = "simulate";

/// Reason why results cannot be written.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs)]
pub enum PlanFilesError {
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    #[error(transparent)]
    Machine(PlanJobError),
    #[error(transparent)]
    Write(#[from] FileError),
    #[error("the electrode cannot be written as STL: {0}")]
    Electrode(std::io::Error),
    #[error(transparent)]
    Report(#[from] ReportError),
    #[error("job file: {0}")]
    Job(#[from] serde_json::Error),
    #[error(transparent)]
    Csv(#[from] PathCsvError),
    #[error(transparent)]
    Post(#[from] PostError),
    #[error(transparent)]
    JobSheet(#[from] TemplateError),
    #[error(transparent)]
    Nc(#[from] NcError),
    #[error("set-up sheet: {0}")]
    SetUp(#[from] SetUpError),
    #[error("the path of electrode {electrode} was certified but cannot be approved: {source}")]
    NotApproved { electrode: usize, source: NotApproved },
}

/// Reports on a plan, draws its pictures and writes its files into `folder`; see [`write()`]. `files` are those that
/// the inputs were read from. Returns the report and the names of the files.
///
/// # Errors
/// [`PlanFilesError`]; if the post cannot be used or nothing can be written there, before anything is drawn.
pub fn export(
    folder: &Path,
    outcome: &PlanOutcome,
    inputs: &PlanInputs,
    files: Vec<InputFile>,
    task: &Task,
) -> Result<(Report, Vec<String>), PlanFilesError> {
    let forms = ExportForms::of(&inputs.job.export)?;
    ExportFolder::check(folder)?;
    let mut report = build::report(outcome, &inputs.job, files);
    match outcome.stopped() {
        None => plan_pictures::add(&mut report, outcome, inputs, task)?,
        // Who stops the work does not wait for pictures.
        Some(_) => report.no_pictures = Some("the work was stopped".to_owned()),
    }
    let written = write(folder, outcome, inputs, &forms, &mut report, &task.cancel)?;
    Ok((report, written))
}

/// Makes everything first and publishes it at the end, NC programs last, so that an error or an interruption leaves no
/// program beside results that it does not belong to. Files of an earlier plan in the folder do not keep their names,
/// nor verdicts on it. Returns the names of the files and enters them in `report`.
///
/// Only what the job asks for is written; what an earlier plan left behind of the rest goes all the same. A path
/// that is not verified is written for study as `path_K.unverified.csv`, and never as NC.
pub fn write(
    folder: &Path,
    outcome: &PlanOutcome,
    inputs: &PlanInputs,
    forms: &ExportForms,
    report: &mut Report,
    cancel: &Cancel,
) -> Result<Vec<String>, PlanFilesError> {
    cancel.check()?;
    // Frames are exact data of the outcome: the blisk comes out with the very bits that it was verified with.
    let blisk = outcome.channel.wheel_in_w(&inputs.blisk);
    let bodies = bodies_now(outcome, &inputs.job, cancel)?;
    let context = Context {
        channel: &outcome.channel,
        blisk: &blisk,
        job: &inputs.job,
        post: &forms.post,
        bodies: bodies.as_ref(),
    };
    let (mut files, mut programs): (Vec<(String, Vec<u8>)>, Vec<_>) = (Vec::new(), Vec::new());
    for i in 0..outcome.electrodes.len() {
        let step = inputs.job.export.files.step.then(|| step_file(i + 1, outcome, &context, cancel));
        let step = step.transpose()?;
        report.electrodes[i].step = step.as_ref().map(step_words);
        let (own, program) = electrode_files(i + 1, outcome, &context, step.as_ref())?;
        report.electrodes[i].feed_lowered = program.as_ref().and_then(NcProgram::slowed).map(FeedLowered::from);
        let program = program.map(|p| (format!("path_{}.{}", i + 1, p.extension()), p.text().as_bytes().to_vec()));
        report.electrodes[i].files = own.iter().chain(&program).map(|(name, _)| name.clone()).collect();
        files.extend(own);
        programs.extend(program);
    }
    if let (Some(residual_stock), true) = (outcome.residual_stock(), inputs.job.export.files.residual_stock) {
        let map = &residual_stock.map;
        let ply = match inputs.job.export.frame {
            MeshFrame::Mesh => map_as_ply(map, &map.mesh.in_parent_of(&outcome.channel.frame)),
            MeshFrame::W => map_as_ply(map, &map.mesh),
        };
        files.push((RESIDUAL_STOCK_FILE.to_owned(), ply));
        if let Some(report) = &mut report.residual_stock {
            report.file = Some(RESIDUAL_STOCK_FILE.to_owned());
        }
    }
    if inputs.job.export.files.report {
        files.extend(as_bytes(figures::tables(outcome, cancel)?));
    }
    let schedule =
        report.burning.as_ref().and_then(|burning| Some((burning.schedule.as_ref()?, &burning.electrodes[..])));
    if let Some((schedule, electrodes)) = schedule.filter(|_| inputs.job.export.files.report) {
        files.push((SCHEDULE_FILE.to_owned(), schedule_csv(schedule, electrodes).into_bytes()));
    }
    let mut no_job_sheet = None;
    if inputs.job.export.files.report {
        let job = job_of_plan(outcome, &inputs.job, report.burning.as_ref(), &files);
        let points = job.electrodes.iter().map(|electrode| (electrode.id.as_str(), &electrode.inspection_points[..]));
        let mut texts = vec![("measuring_points.csv", measuring_csv(points))];
        texts.extend([("job.json", job.json()?), ("job.xml", job.xml()?), ("job.csv", job.csv())]);
        match forms.job_sheet.of(&job) {
            Ok(sheet) => texts.push((JOB_SHEET_FILE, sheet)),
            Err(error) => no_job_sheet = Some(error.to_string()),
        }
        if let Some(set_up) = inputs.job.setup.sheet.set_up() {
            texts.push((SETUP_SHEET_FILE, setup_sheet(&job, &set_up)?));
        }
        files.extend(texts.into_iter().map(|(name, text)| (name.to_owned(), text.into_bytes())));
    }
    if let (Some(walls), true) = (&outcome.measured, inputs.job.export.files.report) {
        files.push((SECTIONS_FILE.to_owned(), walls.csv().into_bytes()));
        if let Some(measured) = &mut report.measured {
            measured.file = Some(SECTIONS_FILE.to_owned());
        }
    }
    if inputs.job.export.files.pictures {
        files.extend(report.pictures.iter().map(|p| (p.file.clone(), p.png.clone())));
    }
    files.extend(reports(report, &inputs.job.export, &files, &programs, no_job_sheet)?);
    files.extend(programs);
    let mut out = ExportFolder::open(folder, EXPORT)?.replacing(&VERDICTS).setting_aside(is_program);
    for (name, bytes) in &files {
        out.write(name, bytes)?;
    }
    // From here on it is done as a whole: whoever takes an approval back until now finds nothing changed.
    cancel.check()?;
    out.publish()?;
    Ok(files.into_iter().map(|(name, _)| name).collect())
}

type NamedFile = (String, Vec<u8>);

fn as_bytes(texts: Vec<(String, String)>) -> impl Iterator<Item = NamedFile> {
    texts.into_iter().map(|(name, text)| (name, text.into_bytes()))
}

/// Whether a file is the program of a feed path: whatever post it was made with, or whatever is in it where its name is
/// that of one.
fn is_program(file: &Path) -> bool {
    let rest = file.file_name().and_then(|name| name.to_str()).and_then(|name| name.strip_prefix("path_"));
    rest.is_some_and(|rest| {
        let is_named = rest.strip_suffix(".nc").is_some_and(|number| number.parse::<usize>().is_ok());
        is_named || is_program_for(file, "feed path path_")
    })
}

/// Enters in `report` what is written, and answers its own files if they are asked for.
fn reports(
    report: &mut Report,
    export: &ExportSection,
    files: &[NamedFile],
    programs: &[NamedFile],
    no_job_sheet: Option<String>,
) -> Result<Vec<NamedFile>, PlanFilesError> {
    let own: &[&str] = if export.files.report { &["report.json", "report.html"] } else { &[] };
    let names = |files: &[NamedFile]| files.iter().map(|(name, _)| name.clone()).collect::<Vec<_>>();
    let own: Vec<String> = own.iter().map(|name| (*name).to_owned()).collect();
    report.written = Written {
        electrode_frame: export.frame,
        post: export.post.clone(),
        files: [names(files), own, names(programs)].concat(),
        no_job_sheet,
        not_asked_for: export.files.kinds().into_iter().filter(|(_, wanted)| !wanted).map(|(kind, _)| kind).collect(),
    };
    if !export.files.report {
        return Ok(Vec::new());
    }
    let (json, html) = (report.json()?, report.html()?);
    Ok(vec![("report.json".to_owned(), json.into_bytes()), ("report.html".to_owned(), html.into_bytes())])
}

/// The map of the stock that is left.
const RESIDUAL_STOCK_FILE: &str = "leftover.ply";

/// The schedule of the wheel.
const SCHEDULE_FILE: &str = "schedule.csv";

/// The measured points with their deviations.
const SECTIONS_FILE: &str = "section_deviations.csv";

/// The job sheet.
const JOB_SHEET_FILE: &str = "job_sheet.txt";

/// The forms of what is written: the post of the programs and the template of the job sheet.
#[derive(Debug)]
pub struct ExportForms {
    /// Post of the NC programs.
    pub post: Post,
    /// Template of the job sheet.
    pub job_sheet: JobSheet,
}

impl ExportForms {
    /// The forms that `export` names; the template of a job sheet only where a report is asked for, which it comes with.
    ///
    /// # Errors
    /// The first that cannot be used.
    pub fn of(export: &ExportSection) -> Result<Self, PlanFilesError> {
        let named = export.files.report.then(|| JobSheet::named(&export.job_sheet));
        Ok(Self { post: Post::named(&export.post)?, job_sheet: named.unwrap_or_else(|| Ok(JobSheet::standard()))? })
    }
}

/// What the files of all electrodes share.
struct Context<'a> {
    channel: &'a Channel,
    /// The blisk in W.
    blisk: &'a Mesh,
    job: &'a PlanJob,
    post: &'a Post,
    /// The bodies of the machine as its file has them now, if a program may be made of a simulated motion.
    bodies: Option<&'a MachineModel>,
}

/// Machine with bodies that the NC programs are proven against, [`Context::bodies`].
fn bodies_now(outcome: &PlanOutcome, job: &PlanJob, cancel: &Cancel) -> Result<Option<MachineModel>, PlanFilesError> {
    let is_simulated = (0..outcome.electrodes.len()).any(|i| outcome.simulation(i).is_some());
    if !is_simulated || !job.export.files.nc || !outcome.may_be_approved() {
        return Ok(None);
    }
    simulate::bodies_of(job, &Task::silent(cancel)).map(Some).map_err(|error| match error {
        PlanJobError::Cancelled(cancelled) => cancelled.into(),
        other => PlanFilesError::Machine(other),
    })
}

/// Name and colour of a face: what burns is coppery, the rest grey.
fn role(face: ElectrodeFace, channel: &Channel) -> Role {
    let colour = match face {
        ElectrodeFace::LowWall => [0.80, 0.45, 0.25],
        ElectrodeFace::HighWall => [0.72, 0.38, 0.20],
        ElectrodeFace::HubSide => [0.88, 0.60, 0.38],
        ElectrodeFace::ShroudSide => [0.88, 0.66, 0.48],
        ElectrodeFace::Division => [0.85, 0.72, 0.55],
        ElectrodeFace::FarEnd => [0.75, 0.55, 0.40],
        ElectrodeFace::EntryEnd => [0.62, 0.62, 0.62],
        ElectrodeFace::Shank => [0.70, 0.70, 0.70],
        ElectrodeFace::Holder => [0.55, 0.57, 0.60],
    };
    Role { name: face_name(face, channel).to_owned(), colour: Some(colour) }
}

/// Electrode number `k` as STEP, or the reason why there is none. Its faces keep the clearance that is required, on the feed
/// and on the copying motion.
fn step_file(k: usize, whole: &PlanOutcome, context: &Context, cancel: &Cancel) -> Result<WrittenStep, Cancelled> {
    let outcome = &whole.electrodes[k - 1];
    let (job, electrode) = (context.job, &outcome.electrode.mesh);
    let mesh = match job.export.frame {
        MeshFrame::Mesh => &electrode.in_parent_of(&context.channel.frame),
        MeshFrame::W => electrode,
    };
    let to_spare = |c: &Certificate| c.certified() - (c.required() - c.tolerance());
    let feed = outcome.plan.path.as_ref().map(|planned| &planned.certificate).filter(|c| c.holds());
    let Some(feed) = feed else { return Ok(Err("the path of the electrode is not certified".to_owned())) };
    let copying = whole.copying(k - 1).and_then(Copying::certified).map(|motion| to_spare(&motion.certificate));
    let to_spare = copying.map_or(to_spare(feed), |copying| copying.min(to_spare(feed)));
    let mut properties = vec![
        text("role", "electrode"),
        length("spark gap", job.electrode.burned_gap_mm(k - 1)),
        text("enters from", outcome.electrode.enters_from.name()),
    ];
    if let Some(stage) = job.electrode.stage_of(k - 1) {
        properties.extend([text("stage", &stage.name), length("stock left", stage.stock_mm)]);
    }
    let name = format!("electrode {k}");
    let of_electrode = &outcome.electrode.patches;
    let roles: Vec<Role> = of_electrode.iter().map(|patch| role(patch.face, context.channel)).collect();
    // Patches of one name have one role, so that flat ones can be one face.
    let number = |k: usize| roles.iter().position(|r| r.name == roles[k].name).unwrap_or(k) as u16;
    let patches: Vec<StepPatch> =
        of_electrode.iter().enumerate().map(|(k, patch)| StepPatch { grid: &patch.grid, role: number(k) }).collect();
    let part = StepPart { name: &name, mesh, roles: &roles, role_of: &[], patches: &patches, properties: &properties };
    written_step(&part, to_spare, &Task::silent(cancel))
}

fn electrode_files(
    k: usize,
    whole: &PlanOutcome,
    context: &Context,
    step: Option<&WrittenStep>,
) -> Result<(Vec<NamedFile>, Option<NcProgram>), PlanFilesError> {
    let (wanted, mut files) = (&context.job.export.files, Vec::new());
    let outcome = &whole.electrodes[k - 1];
    let electrode = &outcome.electrode.mesh;
    if wanted.electrode {
        let mesh = match context.job.export.frame {
            MeshFrame::Mesh => &electrode.in_parent_of(&context.channel.frame),
            MeshFrame::W => electrode,
        };
        files.push((electrode_file(k), stl_bytes(mesh).map_err(PlanFilesError::Electrode)?));
    }
    if let Some(worn) = &outcome.worn {
        let mesh = match context.job.export.frame {
            MeshFrame::Mesh => &worn.mesh.in_parent_of(&context.channel.frame),
            MeshFrame::W => &worn.mesh,
        };
        files.push((worn_file(k), stl_bytes(mesh).map_err(PlanFilesError::Electrode)?));
    }
    if let Some(Ok(step)) = step {
        files.push((format!("electrode_{k}.step"), step.bytes.clone()));
    }
    if wanted.report {
        files.extend(as_bytes(figures::electrode_tables(k, outcome)));
    }
    let Some(planned) = &outcome.plan.path else { return Ok((files, None)) };
    let holds = planned.certificate.holds();
    if wanted.path {
        let csv = write_path_csv(&planned.path, planned.certificate.row_clearance())?.into_bytes();
        files.push((format!("path_{k}{}.csv", if holds { "" } else { ".unverified" }), csv));
    }
    let copying = whole.copying(k - 1).and_then(Copying::certified).filter(|_| holds);
    if let (Some(copying), true) = (copying, wanted.residual_stock) {
        let csv = write_copying_csv(&copying.path, copying.certificate.row_clearance())?.into_bytes();
        files.push((format!("copying_{k}.csv"), csv));
    }
    let is_simulated = whole.simulation(k - 1).is_some() || !simulate::is_needed(context.job);
    if !holds || !wanted.nc || !whole.may_be_approved() || !is_simulated {
        return Ok((files, None));
    }
    let not_approved = |source| PlanFilesError::NotApproved { electrode: k, source };
    let mut approved =
        Approved::new(planned.path.clone(), planned.certificate.clone(), context.blisk, &outcome.burning().mesh)
            .map_err(not_approved)?
            .with_preset(outcome.preset.as_ref());
    if let Some(copying) = copying {
        approved = approved.with_copying(copying).map_err(not_approved)?;
    }
    if let (Some(simulation), Some(of_today)) = (whole.simulation(k - 1), context.bodies) {
        approved = approved.with_simulation(simulation, of_today).map_err(not_approved)?;
    }
    let electrode_file = electrode_in_program(k, outcome.worn.is_some(), &context.job.export);
    let setting = whole.setting(k - 1).map(|room| format!("Setting up: {}", room.sentence()));
    let stage = context.job.electrode.stage_of(k - 1).map(|stage| {
        let (name, gap, stock) = (&stage.name, stage.spark_gap_mm, stage.stock_mm);
        format!("Stage {name}: spark gap {gap} mm, {stock} mm of stock are left; the required clearance is both")
    });
    let notes: Vec<String> = stage.into_iter().chain(outcome.preset_sentence()).chain(setting).collect();
    let nc_job = NcJob {
        program: &format!("path_{k}"),
        electrode_file: &electrode_file,
        machine: &context.job.machine,
        notes: &notes,
    };
    let program = NcProgram::new(&approved, context.post, &context.job.export.nc, &nc_job)?;
    Ok((files, Some(program)))
}

fn electrode_file(k: usize) -> String {
    format!("electrode_{k}.stl")
}

/// File of the electrode as it is worn, moved on.
fn worn_file(k: usize) -> String {
    format!("electrode_{k}.worn.stl")
}

/// What a program says of the file of its electrode.
fn electrode_in_program(k: usize, is_worn: bool, export: &ExportSection) -> String {
    let file = if is_worn { worn_file(k) } else { electrode_file(k) };
    match (export.files.electrode || is_worn, export.frame) {
        (false, _) => format!("none was written of electrode {k}"),
        (true, MeshFrame::Mesh) => file,
        (true, MeshFrame::W) => format!("{file} in the workpiece frame W"),
    }
}
