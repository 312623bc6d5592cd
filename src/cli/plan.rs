//! `sparkpath plan` and `sparkpath demo`.

use std::path::Path;

use super::project::{ProjectArguments, Settings};
use super::{Answer, Session};
use crate::workspaces::blisk::document::job_file::PlanJob;
use crate::workspaces::blisk::document::job_file::field_table::FIELDS;
use crate::workspaces::blisk::export::{self, PlanFilesError};
use crate::workspaces::blisk::job::burning::check_ends;
use crate::workspaces::blisk::job::burning::{BurningElectrode, WheelBurning};
use crate::workspaces::blisk::job::finish::finish_as_far_as_possible;
use crate::workspaces::blisk::job::outcome::{PlanInputs, PlanOutcome};
use crate::workspaces::blisk::job::plan::{prepare, run_prepared};
use crate::workspaces::blisk::job::prepared_blisk::PreparedBlisk;
use crate::workspaces::blisk::job::preset::{Presets, check_presets, read_presets, with_presets};
use crate::workspaces::blisk::job::sizing::auto_sized;
use crate::workspaces::blisk::job::stages::{BliskMesh, input_file, read_blank, read_blisk};
use crate::workspaces::blisk::report::{InputFile, Report};
use files::{ExportFolder, Validate as _};
use import::Units;
use task::{Cancel, Task};
use wheel::electrode::Sizing;
use wheel::parametric::wheel::ParametricWheel;

/// Plans `project` and writes the results into `out`.
pub(super) fn plan(
    project: &ProjectArguments,
    presets: Option<&Path>,
    out: &Path,
    session: &Session,
) -> anyhow::Result<Answer> {
    let (mut inputs, files) = load(project, session)?;
    if let Some(presets) = presets {
        inputs.job.setup.presets = Some(presets.display().to_string());
    }
    let presets = presets.or(inputs.job.setup.presets.as_deref().map(Path::new)).map(read_presets).transpose()?;
    finish(inputs, files, presets.as_ref(), out, session)
}

/// The parameters of a blisk's plan, with the seed of the command line if that gives one.
pub(super) fn read(project: &ProjectArguments, session: &Session) -> anyhow::Result<PlanJob> {
    let mut job = project.read(&FIELDS, PlanJob::for_mesh)?;
    job.genetic.seed = session.seed.unwrap_or(job.genetic.seed);
    Ok(job)
}

/// Reads a project and its meshes, and what a report says of these.
pub(super) fn load(project: &ProjectArguments, session: &Session) -> anyhow::Result<(PlanInputs, Vec<InputFile>)> {
    let job = read(project, session)?;
    let read = read_blisk(&job, &session.task).map_err(anyhow::Error::msg)?;
    let Some(BliskMesh { mesh: blisk, obstacles, sections, file, report, .. }) = read else {
        anyhow::bail!(
            "{}: blisk.mesh is missing; give the mesh file there or with --set blisk.mesh=FILE, or blades in blisk.sections. \
             The built-in blisk is planned by sparkpath demo",
            project.file.display()
        )
    };
    if let (Some(report), Some(mesh)) = (&report, &job.blisk.mesh) {
        session.note_unit(mesh, report);
        super::require_closed(mesh, report)?;
    }
    let mut files = vec![file];
    let mut own_electrodes = Vec::new();
    for path in job.electrode.own_meshes() {
        // The user's electrodes stand in the blisk's coordinates after conversion, as our own files do.
        let own = session.import(path, &Units::Mm.into())?;
        files.push(input_file("electrode", path, &own));
        own_electrodes.push(own.mesh.into());
    }
    let blank = read_blank(&job, &session.task).map_err(anyhow::Error::msg)?;
    files.extend(blank.as_ref().map(|(_, file)| file.clone()));
    let blank = blank.map(|(mesh, _)| mesh.into());
    let (blisk, obstacles) = (blisk.into(), obstacles.map(Into::into));
    Ok((PlanInputs { blisk, obstacles, own_electrodes, sections, blank, job }, files))
}

/// The whole journey on the built-in blisk.
pub(super) fn demo(settings: &Settings, out: &Path, session: &Session) -> anyhow::Result<Answer> {
    let mut job = PlanJob::demonstration();
    settings.apply(&FIELDS, &mut job)?;
    job.validate()?;
    job.genetic.seed = session.seed.unwrap_or(job.genetic.seed);
    let blisk = ParametricWheel::demonstration().mesh();
    let file = InputFile {
        role: "blisk".to_owned(),
        path: "built-in demonstration blisk".to_owned(),
        triangles: blisk.triangles.len(),
        unit: "mm".to_owned(),
        unit_reason: "made by this program".to_owned(),
        ..Default::default()
    };
    let inputs = PlanInputs::of(blisk, job);
    finish(inputs, vec![file], None, out, session)
}

fn finish(
    inputs: PlanInputs,
    files: Vec<InputFile>,
    presets: Option<&Presets>,
    out: &Path,
    session: &Session,
) -> anyhow::Result<Answer> {
    // What would stop the results should be found out before the work.
    export::ExportForms::of(&inputs.job.export)?;
    check_ends(&inputs.job).map_err(anyhow::Error::msg)?;
    ExportFolder::check(out)?;
    if let Some(presets) = presets {
        check_presets(presets, inputs.electrodes()).map_err(|why| anyhow::anyhow!("presets: {why}"))?;
    }
    let task = &session.task;
    let (prepared, inputs) = ready(inputs, session)?;
    let mut outcome = run_prepared(&prepared, &inputs, &|_, _, _| (), task)?;
    if let Some(presets) = presets {
        outcome = with_presets(outcome, &inputs, prepared.blisk(), presets, task)?;
    }
    finish_as_far_as_possible(&outcome, &inputs, prepared.blisk(), task)?;
    // Its fields make room for the pictures.
    drop(prepared);
    // What is known when the work is stopped is written all the same.
    let exported = |outcome: &PlanOutcome| {
        let cancel = if outcome.stopped().is_some() { Cancel::default() } else { task.cancel.clone() };
        export::export(out, outcome, &inputs, files.clone(), &Task { cancel, ..task.clone() })
    };
    let (outcome, (report, written)) = match exported(&outcome) {
        Err(PlanFilesError::Cancelled(_)) => {
            let outcome = outcome.undrawn();
            let files = exported(&outcome)?;
            (outcome, files)
        }
        files => (outcome, files?),
    };
    let stopped = outcome.stopped();
    super::terminal::finish();
    if session.json {
        say!("{}", report.json()?);
    } else {
        print_summary(&report, &outcome, &written, out);
    }
    Ok(match stopped {
        Some(stage) if outcome.is_verified() => {
            Answer::Stopped { stage, written: "the certified plan was written, without an NC program" }
        }
        Some(stage) => Answer::Stopped { stage, written: "what is known of the plan was written" },
        None if outcome.may_be_approved() && outcome.bears_setting() => Answer::Yes,
        None => Answer::No,
    })
}

/// The blisk of `inputs` made ready for planning, and `inputs` with the sizes that are found where the job leaves them
/// open.
pub(super) fn ready(inputs: PlanInputs, session: &Session) -> anyhow::Result<(PreparedBlisk, PlanInputs)> {
    let prepared = prepare(&inputs, &session.task)?;
    let inputs = match inputs.job.electrode.size {
        Sizing::Given => inputs,
        Sizing::Auto => auto(&prepared, &inputs, session)?,
    };
    Ok((prepared, inputs))
}

/// The job with the size that is found for it, which is said.
fn auto(prepared: &PreparedBlisk, inputs: &PlanInputs, session: &Session) -> anyhow::Result<PlanInputs> {
    let (sized, rows) = auto_sized(prepared, inputs, &session.task)?;
    super::terminal::finish();
    if !session.json {
        for (stage, row) in rows.iter().enumerate() {
            let name =
                sized.job.electrode.stage.get(stage).map(|stage| format!("{}: ", stage.name)).unwrap_or_default();
            match row {
                Some(row) => {
                    let ([low, high], enter) = (row.reduction_cells(), row.enter.name());
                    say!("size       {name}reductions {low} and {high} deg, entered from {enter}, strategy global");
                }
                None => {
                    let [low, high] = sized.job.electrode.of_stage(stage).circumferential_reduction_deg;
                    say!(
                        "size       {name}not feasible: no reduction gives an extraction path; planned with {low:.3} and \
                         {high:.3} deg"
                    );
                }
            }
        }
    }
    Ok(sized)
}

fn print_summary(report: &Report, outcome: &PlanOutcome, written: &[String], out: &Path) {
    let blisk = &report.blisk;
    say!(
        "blisk      {} blades, channel {}, throat {:.3} mm, turning {:.1} deg",
        blisk.blades,
        blisk.channel,
        blisk.throat_mm,
        blisk.turning_deg
    );
    for assumed in &blisk.assumed {
        say!("           assumed: {assumed}");
    }
    for (e, o) in report.electrodes.iter().zip(&outcome.electrodes) {
        say!(
            "electrode {} enters from {}: volume {:.1} mm3, least thickness {:.3} mm, burn area {:.1} mm2",
            o.electrode.label(e.index - 1),
            e.enters_from,
            e.volume_mm3,
            o.electrode.least_thickness_mm,
            o.electrode.burn_area_mm2
        );
        let [nodes, searches, mends, points] = [e.nodes.len(), o.plan.rounds, o.plan.repairs, o.plan.probes];
        say!("           {nodes} nodes, {searches} searches, {mends} path repairs, {points} points tested");
    }
    report.burning.iter().for_each(print_burning);
    for symbol in &report.symbols {
        say!("           {:10} {:>22} {:4} {}", symbol.symbol, symbol.value, symbol.unit, symbol.meaning);
    }
    for time in &report.times {
        say!("time       {:16} {:8.3} s", time.stage, time.seconds);
    }
    if let Some(why) = &report.no_pictures {
        say!("pictures   none: {why}");
    }
    for (i, electrode) in report.electrodes.iter().enumerate() {
        if let Some(preset) = &electrode.preset {
            say!("preset     electrode {}: {preset}.", outcome.electrodes[i].electrode.label(i));
        }
    }
    if let Some(why) = &report.written.no_job_sheet {
        say!("           no job sheet: {why}");
    }
    say!("files      {} in {}", written.join(", "), out.display());
    say!("{}", report.verdict.sentence);
}

/// Minutes and wear of each electrode, what they rest on and what is missing, and the hours of the wheel.
fn print_burning(burning: &WheelBurning) {
    let mut told = Vec::new();
    for electrode in &burning.electrodes {
        let BurningElectrode { label, figures, .. } = electrode;
        let of_burn = figures.volume_mm3.zip(figures.frontal_area_mm2).map_or_else(
            || "volume and frontal area not known".to_owned(),
            |(volume, [least, greatest])| {
                format!("{volume:.1} mm3 on a frontal area of {least:.1} to {greatest:.1} mm2")
            },
        );
        say!("burning    electrode {label}: {of_burn}: {}, {}", figures.minutes_text(), figures.wear_text());
        for step in figures.steps.iter().filter(|step| step.volume_mm3 != Some(0.0)) {
            let or_none = |value: Option<f64>, unit: &str| {
                value.map_or_else(|| format!("? {unit}"), |value| format!("{value:.2} {unit}"))
            };
            say!(
                "           step {}: {} at {} is {}",
                step.step,
                or_none(step.volume_mm3, "mm3"),
                or_none(step.rate_mm3_min, "mm3/min"),
                or_none(step.minutes, "min")
            );
        }
        say!("           electrodes for {} channels: {}", burning.channels, electrode.needed_text());
        for line in figures.explanation() {
            // Electrodes of one plan rest on the same.
            if !told.contains(&line) {
                say!("           {}", line.split_whitespace().collect::<Vec<_>>().join(" "));
                told.push(line);
            }
        }
    }
    say!("           {}", burning.sentence());
}
