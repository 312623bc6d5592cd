//! `sparkpath electrodes`: electrodes for what milling cutters leave of a mold.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use clap::{Args, ValueEnum};

use super::uncut::MoldArguments;
use super::{Answer, Session};
use crate::export::burn_table::BurnTable;
use crate::export::burn_template::{BURN_SHEET, render, render_file};
use crate::export::electrode_files::{ElectrodeFormat, WrittenElectrodes, write_electrode_files};
use crate::export::electrode_report::ElectrodesReport;
use crate::export::files::write_atomically;
use crate::geometry::mesh::Mesh;
use crate::jobs::electrodes::electrodes as find_electrodes;
use crate::jobs::uncut::uncut as find_uncut;
use crate::mold::cutter::{Cutter, CutterLibrary};
use crate::mold::electrode::design::ElectrodeSet;
use crate::mold::electrode::params::{ElectrodeParams, Shape};
use crate::mold::opening::Opening;
use crate::project::cutter_file::read_cutters;
use crate::project::electrode_file::{load_electrodes, load_holders, read_electrodes, read_holders};
use crate::render::mesh::RenderMesh;
use crate::render::offscreen::Offscreen;
use crate::views::{PICTURE_SIZE, electrode_pictures, electrode_shapes};

#[derive(Debug, Args)]
pub(super) struct ElectrodesArguments {
    #[command(flatten)]
    mold: MoldArguments,
    /// What is asked of the electrodes (TOML) [default: the built-in one].
    #[arg(long, value_name = "FILE")]
    params: Option<PathBuf>,
    /// Spark gap of every stage (mm).
    #[arg(long, value_name = "MM", allow_negative_numbers = true)]
    gap: Option<f64>,
    /// Files hold the shape of the cavity, without the gap.
    #[arg(long)]
    net: bool,
    /// Cutters that mill the electrodes, with commas between [default: those that mill the mold].
    #[arg(long, value_name = "CUTTERS", value_delimiter = ',', conflicts_with = "electrode_library")]
    electrode_cutters: Vec<Cutter>,
    /// A library of cutters (TOML) that mill the electrodes.
    #[arg(long, value_name = "FILE")]
    electrode_library: Option<PathBuf>,
    /// Holders (TOML) [default: the built-in ones].
    #[arg(long, value_name = "FILE")]
    holders: Option<PathBuf>,
    /// Exports an electrode although a check fails; may be given more than once.
    #[arg(long = "override", value_name = "NAME")]
    overrides: Vec<String>,
    /// Formats of the electrode files, with commas between.
    #[arg(long, value_name = "FORMATS", value_delimiter = ',', default_value = "stl")]
    formats: Vec<Format>,
    /// A template for the burn sheet (Jinja) [default: the built-in one].
    #[arg(long, value_name = "FILE")]
    template: Option<PathBuf>,
    /// No pictures in the report.
    #[arg(long)]
    no_pictures: bool,
    /// Folder for the electrode files, burn_table.csv, burn_table.json, burn_sheet.txt and report.html, made if it is not
    /// there.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

/// A format of electrode files.
#[derive(Debug, Clone, Copy, ValueEnum)]
enum Format {
    Stl,
    Obj,
    Glb,
}

impl From<Format> for ElectrodeFormat {
    fn from(format: Format) -> Self {
        match format {
            Format::Stl => Self::Stl,
            Format::Obj => Self::Obj,
            Format::Glb => Self::Glb,
        }
    }
}

/// Designs the electrodes, checks them, writes what passes. The answer is no where a check fails, overridden or not, or a
/// region has no electrode.
pub(super) fn electrodes(arguments: &ElectrodesArguments, session: &Session) -> anyhow::Result<Answer> {
    let asked = arguments.mold.params()?;
    let params = params(arguments)?;
    params.validate()?;
    let mesh = &arguments.mold.mesh;
    let imported = session.import(mesh, arguments.mold.units)?;
    let name = mesh.display().to_string();
    let uncut = find_uncut(&imported.mesh, &asked, &session.progress, &session.cancel)
        .map_err(|e| anyhow::anyhow!("{name}: {e}"))?;
    let set = find_electrodes(&imported.mesh, &uncut, &params, &session.progress, &session.cancel)
        .map_err(|e| anyhow::anyhow!("{name}: {e}"))?;
    let file_name = mesh.file_name().map_or(name, |n| n.to_string_lossy().into_owned());
    let report = ElectrodesReport::of(&set, &file_name, asked.opening);
    let table = BurnTable::of(&set, &file_name, asked.opening);
    let mut lines = lines(&set, &report);
    if let Some(folder) = &arguments.out {
        let drawn =
            if arguments.no_pictures { Ok(Vec::new()) } else { pictures(&imported.mesh, &set, asked.opening, session) };
        let pictures = drawn.unwrap_or_else(|error| {
            lines.push(format!("no pictures in the report: {error}"));
            Vec::new()
        });
        session.cancel.check()?;
        lines.extend(not_written(&write(folder, arguments, (&set, &report, &table), &pictures)?));
    }
    let is_whole = uncut.is_whole();
    if !is_whole {
        lines.push("what the cutters leave is not known for all of the mold: see `sparkpath uncut`".to_owned());
    }
    super::terminal::finish();
    say!("{}", if session.json { report.json()? } else { lines.join("\n") });
    Ok(if set.holds() && is_whole { Answer::Yes } else { Answer::No })
}

fn params(arguments: &ElectrodesArguments) -> anyhow::Result<ElectrodeParams> {
    let mut params = match &arguments.params {
        Some(file) => read_electrodes(file)?,
        None => load_electrodes(None)?,
    };
    match &arguments.holders {
        Some(file) => params.holders = read_holders(file)?,
        None if arguments.params.is_none() => params.holders = load_holders(None)?,
        None => {}
    }
    if let Some(gap) = arguments.gap {
        params.stages.iter_mut().for_each(|stage| stage.gap_mm = gap);
    }
    if arguments.net {
        params.shape = Shape::Net;
    }
    if let Some(file) = &arguments.electrode_library {
        params.cutters = Some(read_cutters(file)?);
    } else if !arguments.electrode_cutters.is_empty() {
        params.cutters = Some(CutterLibrary { cutter: arguments.electrode_cutters.clone() });
    }
    params.overrides.extend(arguments.overrides.iter().cloned());
    Ok(params)
}

/// The report's pictures.
fn pictures(
    mesh: &Mesh,
    set: &ElectrodeSet,
    opening: Opening,
    session: &Session,
) -> anyhow::Result<Vec<(String, Vec<u8>)>> {
    let mut offscreen = Offscreen::new()?;
    let mut drawn = Vec::new();
    let (shapes, mold) = (electrode_shapes(set), Arc::new(RenderMesh::new(mesh)));
    for picture in electrode_pictures(set, &shapes, &mold, opening) {
        session.progress.report("pictures", 0.0, &picture.caption);
        let png = offscreen.png(&picture.scene, &picture.camera, PICTURE_SIZE, &session.cancel)?;
        drawn.push((picture.caption, png));
    }
    Ok(drawn)
}

fn write(
    folder: &Path,
    arguments: &ElectrodesArguments,
    (set, report, table): (&ElectrodeSet, &ElectrodesReport, &BurnTable),
    pictures: &[(String, Vec<u8>)],
) -> anyhow::Result<WrittenElectrodes> {
    // A template that is wrong should be known before anything is written.
    let sheet = match &arguments.template {
        Some(file) => render_file(table, file)?,
        None => render(table, BURN_SHEET, "the built-in burn sheet")?,
    };
    std::fs::create_dir_all(folder)
        .map_err(|e| anyhow::anyhow!("{}: the folder cannot be made ({e}); give another", folder.display()))?;
    let formats: Vec<ElectrodeFormat> = arguments.formats.iter().copied().map(ElectrodeFormat::from).collect();
    let written = write_electrode_files(folder, set, &formats)?;
    write_atomically(&folder.join("burn_table.csv"), table.csv().as_bytes())?;
    write_atomically(&folder.join("burn_table.json"), table.json()?.as_bytes())?;
    write_atomically(&folder.join("burn_sheet.txt"), sheet.as_bytes())?;
    report.write(folder, pictures)?;
    Ok(written)
}

fn lines(set: &ElectrodeSet, report: &ElectrodesReport) -> Vec<String> {
    let mut lines = vec![report.sentence.clone()];
    for (electrode, findings) in set.electrodes.iter().zip(&set.checks) {
        let burns = electrode.burns.len();
        let parts: usize = electrode.burns.iter().map(|b| b.parts.len()).sum();
        let [x, y, z] = electrode.blank.to_array();
        lines.push(format!(
            "{}: {burns} burn{}, {parts} place{}, blank {x} x {y} x {z} mm, {:.0} min",
            electrode.name,
            if burns == 1 { "" } else { "s" },
            if parts == 1 { "" } else { "s" },
            electrode.minutes
        ));
        let failed = findings.iter().filter(|f| !f.holds);
        lines.extend(failed.map(|f| {
            let place = f.place.map_or_else(String::new, |p| format!(" at ({:.3}, {:.3}, {:.3})", p.x, p.y, p.z));
            format!("    {} fails: {}{place}", f.kind.name(), f.text)
        }));
    }
    for (number, region) in set.regions.iter().enumerate() {
        lines.extend(region.trouble.as_ref().map(|t| format!("region {} has no electrode: {t}", number + 1)));
    }
    let is_known = |name: &&String| set.electrodes.iter().any(|e| e.name == **name);
    let unknown = set.params.overrides.iter().filter(|name| !is_known(name));
    lines.extend(unknown.map(|name| format!("override {name}: there is no electrode of that name")));
    lines
}

fn not_written(written: &WrittenElectrodes) -> Vec<String> {
    let mut lines = Vec::new();
    for left in &written.left_out {
        lines.push(format!("{} was not written: {}", left.electrode, left.why));
        let older = left.older.iter().map(|f| format!("    an older file of it is still there: {}", f.display()));
        lines.extend(older);
    }
    lines
}
