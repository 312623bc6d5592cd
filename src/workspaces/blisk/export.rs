//! Writes the results of a plan into a folder.

use std::collections::HashSet;
use std::io::Read as _;
use std::path::{Path, PathBuf};

use crate::workspaces::blisk::document::choice::MeshFrame;
use crate::workspaces::blisk::document::job_file::{ExportSection, PlanJob};
use crate::workspaces::blisk::job::plan::{PlanInputs, PlanJobError, PlanOutcome};
use crate::workspaces::blisk::job::{plan_pictures, simulate};
use crate::workspaces::blisk::report::build;
use crate::workspaces::blisk::report::leftover::map_as_ply;
use crate::workspaces::blisk::report::{FeedLowered, InputFile, Report, ReportError, Written};
use feed::copying::Copying;
use feed::machine_model::MachineModel;
use files::whole_file::{WriteError, write_atomically};
use geometry::mesh::Mesh;
use import::stl_bytes;
use nc::approved::{Approved, NotApproved};
use nc::path_csv::{PathCsvError, write_copying_csv, write_path_csv};
use nc::post::{Post, PostError};
use nc::program::{NcError, NcJob, NcProgram};
use task::{Cancel, Cancelled, Progress};
use wheel::channel::Channel;

/// Why results cannot be written.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs)]
pub enum PlanFilesError {
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    #[error(transparent)]
    Machine(PlanJobError),
    #[error(transparent)]
    Write(#[from] WriteError),
    #[error("{path}: nothing can be written into this folder ({source}); choose another")]
    Folder { path: PathBuf, source: std::io::Error },
    #[error("{file}: cannot be removed or replaced ({source}); the folder now holds only some of the results")]
    Replace { file: PathBuf, source: std::io::Error },
    #[error("two files would be called {name}; nothing was written")]
    TwoOfOneName { name: String },
    #[error("the electrode cannot be written as STL: {0}")]
    Electrode(std::io::Error),
    #[error(transparent)]
    Report(#[from] ReportError),
    #[error(transparent)]
    Csv(#[from] PathCsvError),
    #[error(transparent)]
    Post(#[from] PostError),
    #[error(transparent)]
    Nc(#[from] NcError),
    #[error("the path of electrode {electrode} was certified but cannot be approved: {source}")]
    NotApproved { electrode: usize, source: NotApproved },
}

/// Makes the folder for results and makes sure that files can be written there.
pub fn prepare(folder: &Path) -> Result<(), PlanFilesError> {
    let unusable = |source| PlanFilesError::Folder { path: folder.to_owned(), source };
    if folder.is_dir() {
        return tempfile::tempfile_in(folder).map(drop).map_err(unusable);
    }
    // It is only made when there is something to put there, but what stands in its way shows now.
    let parent = folder.ancestors().find(|a| a.exists()).unwrap_or(Path::new("."));
    tempfile::tempfile_in(if parent.as_os_str().is_empty() { Path::new(".") } else { parent })
        .map(drop)
        .map_err(unusable)
}

/// Reports on a plan, draws its pictures and writes its files into `folder`; see [`write`]. `files` are those that the
/// inputs were read from. Answers the report and the names of the files.
///
/// # Errors
/// [`PlanFilesError`]; if the post cannot be used or nothing can be written there, before anything is drawn.
pub fn export(
    folder: &Path,
    outcome: &PlanOutcome,
    inputs: &PlanInputs,
    files: Vec<InputFile>,
    progress: &Progress,
    cancel: &Cancel,
) -> Result<(Report, Vec<String>), PlanFilesError> {
    let post = Post::named(&inputs.job.export.post)?;
    prepare(folder)?;
    let mut report = build::report(outcome, &inputs.job, files);
    match outcome.stopped() {
        None => plan_pictures::add(&mut report, outcome, inputs, progress, cancel)?,
        // Who stops the work does not wait for pictures.
        Some(_) => report.no_pictures = Some("the work was stopped".to_owned()),
    }
    let written = write(folder, outcome, inputs, &post, &mut report, cancel)?;
    Ok((report, written))
}

/// Makes everything first, writes it under temporary names and renames it at the end, NC programs last, so that an
/// error or an interruption leaves no program beside results that it does not belong to. Files of an earlier
/// plan in the folder are removed. Returns the names of the files and enters them in `report`.
///
/// Only what the job asks for is written; what an earlier plan left behind of the rest is removed all the same. A path
/// that is not verified is written for study as `path_K.unverified.csv`, and never as NC.
pub fn write(
    folder: &Path,
    outcome: &PlanOutcome,
    inputs: &PlanInputs,
    post: &Post,
    report: &mut Report,
    cancel: &Cancel,
) -> Result<Vec<String>, PlanFilesError> {
    cancel.check()?;
    // Frames are exact data of the outcome: the blisk comes out with the very bits that it was verified with.
    let blisk = inputs.blisk.in_frame(&outcome.channel.frame);
    let bodies = bodies_now(outcome, &inputs.job, cancel)?;
    let context = Context { channel: &outcome.channel, blisk: &blisk, job: &inputs.job, post, bodies: bodies.as_ref() };
    let (mut files, mut programs): (Vec<(String, Vec<u8>)>, Vec<_>) = (Vec::new(), Vec::new());
    for i in 0..outcome.electrodes.len() {
        let (own, program) = electrode_files(i + 1, outcome, &context)?;
        report.electrodes[i].feed_lowered = program.as_ref().and_then(NcProgram::slowed).map(FeedLowered::from);
        let program = program.map(|p| (format!("path_{}.{}", i + 1, p.extension()), p.text().as_bytes().to_vec()));
        report.electrodes[i].files = own.iter().chain(&program).map(|(name, _)| name.clone()).collect();
        files.extend(own);
        programs.extend(program);
    }
    if let (Some(leftover), true) = (outcome.leftover(), inputs.job.export.files.leftover) {
        let map = &leftover.map;
        let ply = match inputs.job.export.frame {
            MeshFrame::Mesh => map_as_ply(map, &map.mesh.in_parent_of(&outcome.channel.frame)),
            MeshFrame::W => map_as_ply(map, &map.mesh),
        };
        files.push((LEFTOVER_FILE.to_owned(), ply));
        if let Some(report) = &mut report.leftover {
            report.file = Some(LEFTOVER_FILE.to_owned());
        }
    }
    if inputs.job.export.files.pictures {
        files.extend(report.pictures.iter().map(|p| (p.file.clone(), p.png.clone())));
    }
    files.extend(reports(report, &inputs.job.export, &files, &programs)?);
    files.extend(programs);
    require_distinct(&files)?;
    let unusable = |source| PlanFilesError::Folder { path: folder.to_owned(), source };
    std::fs::create_dir_all(folder).map_err(unusable)?;
    let staging = tempfile::Builder::new().prefix(".sparkpath-").tempdir_in(folder).map_err(unusable)?;
    for (name, bytes) in &files {
        write_atomically(&staging.path().join(name), bytes)?;
    }
    // From here on it is done as a whole: whoever takes an approval back until now finds nothing changed.
    cancel.check()?;
    remove_results(folder, &post.extension)?;
    for (name, _) in &files {
        let file = folder.join(name);
        std::fs::rename(staging.path().join(name), &file).map_err(|source| PlanFilesError::Replace { file, source })?;
    }
    Ok(files.into_iter().map(|(name, _)| name).collect())
}

type NamedFile = (String, Vec<u8>);

/// Makes sure that no file takes another's place, where capitals do not count either.
fn require_distinct(files: &[NamedFile]) -> Result<(), PlanFilesError> {
    let mut seen = HashSet::new();
    match files.iter().find(|(name, _)| !seen.insert(name.to_ascii_lowercase())) {
        Some((name, _)) => Err(PlanFilesError::TwoOfOneName { name: name.clone() }),
        None => Ok(()),
    }
}

/// Enters in `report` what is written, and answers its own files if they are asked for.
fn reports(
    report: &mut Report,
    export: &ExportSection,
    files: &[NamedFile],
    programs: &[NamedFile],
) -> Result<Vec<NamedFile>, PlanFilesError> {
    let own: &[&str] = if export.files.report { &["report.json", "report.html"] } else { &[] };
    let names = |files: &[NamedFile]| files.iter().map(|(name, _)| name.clone()).collect::<Vec<_>>();
    let own: Vec<String> = own.iter().map(|name| (*name).to_owned()).collect();
    report.written = Written {
        electrode_frame: export.frame,
        post: export.post.clone(),
        files: [names(files), own, names(programs)].concat(),
        not_asked_for: export.files.kinds().into_iter().filter(|(_, wanted)| !wanted).map(|(kind, _)| kind).collect(),
    };
    if !export.files.report {
        return Ok(Vec::new());
    }
    let (json, html) = (report.json()?, report.html()?);
    Ok(vec![("report.json".to_owned(), json.into_bytes()), ("report.html".to_owned(), html.into_bytes())])
}

/// The map of the stock that is left.
const LEFTOVER_FILE: &str = "leftover.ply";
/// Its picture.
const LEFTOVER_PICTURE: &str = "view_2_leftover.png";

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

/// See [`Context::bodies`].
fn bodies_now(outcome: &PlanOutcome, job: &PlanJob, cancel: &Cancel) -> Result<Option<MachineModel>, PlanFilesError> {
    let is_simulated = (0..outcome.electrodes.len()).any(|i| outcome.simulation(i).is_some());
    if !is_simulated || !job.export.files.nc || !outcome.may_be_approved() {
        return Ok(None);
    }
    simulate::bodies_of(job, &Progress::silent(), cancel).map(Some).map_err(|error| match error {
        PlanJobError::Cancelled(cancelled) => cancelled.into(),
        other => PlanFilesError::Machine(other),
    })
}

fn electrode_files(
    k: usize,
    whole: &PlanOutcome,
    context: &Context,
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
    let Some(planned) = &outcome.plan.path else { return Ok((files, None)) };
    let holds = planned.certificate.holds();
    if wanted.path {
        let csv = write_path_csv(&planned.path, planned.certificate.row_clearance())?.into_bytes();
        files.push((format!("path_{k}{}.csv", if holds { "" } else { ".unverified" }), csv));
    }
    let copying = whole.copying(k - 1).and_then(Copying::certified).filter(|_| holds);
    if let (Some(copying), true) = (copying, wanted.leftover) {
        let csv = write_copying_csv(&copying.path, copying.certificate.row_clearance())?.into_bytes();
        files.push((format!("copying_{k}.csv"), csv));
    }
    let is_simulated = whole.simulation(k - 1).is_some() || !simulate::is_needed(context.job);
    if !holds || !wanted.nc || !whole.may_be_approved() || !is_simulated {
        return Ok((files, None));
    }
    let not_approved = |source| PlanFilesError::NotApproved { electrode: k, source };
    let mut approved = Approved::new(planned.path.clone(), planned.certificate.clone(), context.blisk, electrode)
        .map_err(not_approved)?;
    if let Some(copying) = copying {
        approved = approved.with_copying(copying).map_err(not_approved)?;
    }
    if let (Some(simulation), Some(of_today)) = (whole.simulation(k - 1), context.bodies) {
        approved = approved.with_simulation(simulation, of_today).map_err(not_approved)?;
    }
    let electrode_file = electrode_in_program(k, &context.job.export);
    let nc_job =
        NcJob { program: &format!("path_{k}"), electrode_file: &electrode_file, machine: &context.job.machine };
    let program = NcProgram::new(&approved, context.post, &context.job.export.nc, &nc_job)?;
    Ok((files, Some(program)))
}

fn electrode_file(k: usize) -> String {
    format!("electrode_{k}.stl")
}

/// What a program says of the file of its electrode.
fn electrode_in_program(k: usize, export: &ExportSection) -> String {
    match (export.files.electrode, export.frame) {
        (false, _) => format!("none was written of electrode {k}"),
        (true, MeshFrame::Mesh) => electrode_file(k),
        (true, MeshFrame::W) => format!("{} in the workpiece frame W", electrode_file(k)),
    }
}

/// Removes what an earlier plan may have written; of a link only the link.
fn remove_results(folder: &Path, extension: &str) -> Result<(), PlanFilesError> {
    let unusable = |source| PlanFilesError::Folder { path: folder.to_owned(), source };
    let listed = listed_files(folder);
    for entry in std::fs::read_dir(folder).map_err(unusable)? {
        let entry = entry.map_err(unusable)?;
        let name = entry.file_name();
        let name = name.to_string_lossy();
        let is_program = || {
            program_extension(&name)
                .is_some_and(|e| e == extension || listed.iter().any(|l| *l == *name) || is_our_program(&entry.path()))
        };
        let is_folder = entry.file_type().map_err(unusable)?.is_dir();
        if !is_folder && (is_result(&name) || is_program()) {
            let replace = |source| PlanFilesError::Replace { file: entry.path(), source };
            std::fs::remove_file(entry.path()).map_err(replace)?;
        }
    }
    Ok(())
}

/// Whether a result of any plan is called `name`, programs of one's own posts apart.
fn is_result(name: &str) -> bool {
    // A verdict on a path of an earlier plan would be taken for one on this plan's.
    ["report.json", "report.html", "verify.json", "verify.html", LEFTOVER_FILE, LEFTOVER_PICTURE].contains(&name)
        || numbered(name, "copying_") == Some(".csv")
        || numbered(name, "view_").is_some_and(|rest| rest == "_whole.png")
        || numbered(name, "electrode_")
            .is_some_and(|rest| [".stl", "_final.png", "_sweep.png", "_closest.png"].contains(&rest))
        || numbered(name, "path_").is_some_and(|rest| [".csv", ".unverified.csv", ".nc"].contains(&rest))
}

/// The extension in `name` if a post of one's own may have called a program so.
fn program_extension(name: &str) -> Option<&str> {
    let extension = numbered(name, "path_")?.strip_prefix('.')?;
    (!extension.is_empty() && extension.chars().all(|c| c.is_ascii_alphanumeric())).then_some(extension)
}

/// The files that the report in `folder` says were written; none if there is no report that can be read.
fn listed_files(folder: &Path) -> Vec<String> {
    let report: serde_json::Value = head(&folder.join("report.json"), 64 << 20)
        .and_then(|text| serde_json::from_slice(&text).ok())
        .unwrap_or_default();
    let files = report["written"]["files"].as_array();
    files.into_iter().flatten().filter_map(|name| name.as_str().map(str::to_owned)).collect()
}

/// Whether the first comment of a program in this file says that we wrote it.
fn is_our_program(path: &Path) -> bool {
    let start = head(path, 64 << 10).unwrap_or_default();
    String::from_utf8_lossy(&start)
        .lines()
        .any(|line| line.contains("Sparkpath ") && line.contains(": feed path path_"))
}

/// The first bytes of a file, at most `most` of them.
fn head(path: &Path, most: u64) -> Option<Vec<u8>> {
    // Pipes and devices may never answer.
    if !std::fs::metadata(path).ok()?.is_file() {
        return None;
    }
    let mut bytes = Vec::new();
    std::fs::File::open(path).ok()?.take(most).read_to_end(&mut bytes).ok()?;
    Some(bytes)
}

/// What follows `prefix` and a number in `name`.
fn numbered<'a>(name: &'a str, prefix: &str) -> Option<&'a str> {
    let rest = name.strip_prefix(prefix)?;
    let end = rest.find(|c: char| !c.is_ascii_digit()).unwrap_or(rest.len());
    (end > 0).then(|| &rest[end..])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_files_of_one_name_are_refused_whatever_their_capitals() {
        let files = |names: [&str; 3]| names.map(|name| (name.to_owned(), Vec::new()));
        assert!(require_distinct(&files(["path_1.csv", "path_2.csv", "path_1.nc"])).is_ok());
        let twice = require_distinct(&files(["path_1.csv", "report.json", "path_1.CSV"]));
        assert!(matches!(twice, Err(PlanFilesError::TwoOfOneName { name }) if name == "path_1.CSV"));
    }

    #[test]
    fn only_results_of_a_plan_are_removed() {
        let folder = tempfile::tempdir().unwrap();
        let names = [
            "electrode_1.stl",
            "path_12.csv",
            "path_1.unverified.csv",
            "path_2.nc",
            "report.json",
            "verify.json",
            "verify.html",
            "view_1_whole.png",
            "electrode_2_final.png",
            "electrode_2_sweep.png",
            "electrode_2_closest.png",
            "leftover.ply",
            "view_2_leftover.png",
            "copying_1.csv",
        ];
        let others = [
            "electrode_x.stl",
            "path_.csv",
            "electrode_1.stl.bak",
            "part.stl",
            "report.txt",
            "path_1.notes.txt",
            "view.png",
            "copying_1.csv.old",
            "electrode_1.png",
        ];
        for name in names.iter().chain(&others) {
            std::fs::write(folder.path().join(name), "x").unwrap();
        }
        remove_results(folder.path(), "nc").unwrap();
        assert!(names.iter().all(|n| !folder.path().join(n).exists()));
        assert!(others.iter().all(|n| folder.path().join(n).exists()));
    }

    #[test]
    fn programs_of_every_earlier_post_are_removed_and_files_of_others_stay() {
        let folder = tempfile::tempdir().unwrap();
        let put = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
        put("report.json", r#"{"written": {"files": ["path_1.ngc", "../path_9.ngc", "part.stl", "notes.txt"]}}"#);
        put("path_1.ngc", "listed in the report");
        put("path_2.H", "%\r\n(Sparkpath 0.1.0: feed path path_2)\r\nG71\r\n");
        let others = ["path_3.ngc", "part.stl", "notes.txt", "path_2.H.bak"];
        others.iter().for_each(|name| put(name, "(Sparkpath is a program)"));
        remove_results(folder.path(), "tap").unwrap();
        let mut left: Vec<_> =
            std::fs::read_dir(folder.path()).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
        left.sort();
        let mut expected = others.to_vec();
        expected.sort_unstable();
        assert_eq!(left, expected);
    }
}
