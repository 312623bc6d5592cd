//! `sparkpath electrodes`: electrodes for what milling cutters leave of a mold.

use std::path::PathBuf;
use std::sync::Arc;

use clap::{Args, ValueEnum};
use glam::DAffine3;

use super::uncut::{AskedMold, MoldArguments};
use super::{Answer, Session, mm};
use crate::workspaces::mold::document::MoldParams;
use crate::workspaces::mold::document::cutter_file::CUTTERS;
use crate::workspaces::mold::document::holder_files::read_holders;
use crate::workspaces::mold::export::{EXPORT, ElectrodeForms, export_electrodes};
use crate::workspaces::mold::job::divisions::{WayResult, compare_divisions};
use crate::workspaces::mold::job::electrodes::electrodes as find_electrodes;
use crate::workspaces::mold::job::uncut::uncut as find_uncut;
use crate::workspaces::mold::report::steps::steps;
use crate::workspaces::mold::report::{ElectrodesPage, ElectrodesReport};
use crate::workspaces::mold::scene::electrodes::electrode_shapes;
use crate::workspaces::mold::scene::pictures::{draw, electrode_pictures};
use burning::figures::NOT_CONSIDERED;
use files::Override;
use files::report::Picture;
use files::{ExportFolder, Published};
use geometry::mesh::Mesh;
use mold::cutter::{Cutter, CutterLibrary};
use mold::electrode::design::{Electrode, ElectrodeSet};
use mold::electrode::finding::CheckKind;
use mold::electrode::params::Shape;
use mold::opening::Opening;
use nc::burn_table::NotBurned;
use nc::electrode_files::{ElectrodeFormat, WrittenElectrodes};
use nc::template::BurnSheet;
use render::mesh::RenderMesh;
use task::{StageClock, Task};

#[derive(Debug, Args)]
pub(super) struct ElectrodesArguments {
    #[command(flatten)]
    mold: MoldArguments,
    /// Spark gap of every stage (mm).
    #[arg(long, value_name = "MM", allow_negative_numbers = true, value_parser = |text: &str| mm(text, [0.0, 5.0]))]
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
    /// Holders (TOML) [default: those of the project; else holders.toml and holders/SUPPLIER.toml in your settings, or
    /// else the built-in ones].
    #[arg(long, value_name = "FILE")]
    holders: Option<PathBuf>,
    /// Exports an electrode although a check fails, as in E03:leftover; with a figure, as in E03:leftover:0.05, only
    /// while none of the check's figures is greater. May be given more than once.
    #[arg(long = "override", value_name = "NAME:CHECK[:FIGURE]", value_parser = electrode_override)]
    overrides: Vec<Override>,
    /// Formats of the electrode files, with commas between.
    #[arg(long, value_name = "FORMATS", value_delimiter = ',', default_value = "stl")]
    formats: Vec<Format>,
    /// A template for the burn sheet (Jinja) [default: the built-in one].
    #[arg(long, value_name = "FILE")]
    template: Option<PathBuf>,
    /// Compares with other ways of dividing regions into heads: not at all, by whole faces, at every inner edge.
    #[arg(long)]
    compare_divisions: bool,
    /// No pictures in the report.
    #[arg(long)]
    no_pictures: bool,
    /// Folder for the electrode files, burn_table.csv, burn_table.json, burn_sheet.txt, report.html and, with a datum
    /// (setup.datum), setup_sheet.txt, made if it is not there.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

/// A format of electrode files.
#[derive(Debug, Clone, Copy, ValueEnum)]
enum Format {
    Stl,
    Obj,
    Glb,
    Step,
}

impl From<Format> for ElectrodeFormat {
    fn from(format: Format) -> Self {
        match format {
            Format::Stl => Self::Stl,
            Format::Obj => Self::Obj,
            Format::Glb => Self::Glb,
            Format::Step => Self::Step,
        }
    }
}

/// Designs the electrodes, checks them, writes what passes. The answer is no where a check fails, overridden or not, or
/// a region has no electrode.
pub(super) fn electrodes(arguments: &ElectrodesArguments, session: &Session) -> anyhow::Result<Answer> {
    // What can be told before the work should not be told after it.
    let sheet = arguments.template.as_deref().map_or_else(|| Ok(BurnSheet::standard()), BurnSheet::read)?;
    let folder = arguments.out.as_deref().map(|out| ExportFolder::open(out, EXPORT)).transpose()?;
    let AskedMold { params: asked, imported, path: mesh } =
        arguments.mold.read(|params| apply(arguments, params), session)?;
    let name = mesh.display().to_string();
    let clock = StageClock::default();
    let task = clock.timed(&session.task);
    let uncut = find_uncut(&imported.mesh, &asked.uncut(), &task).map_err(|e| anyhow::anyhow!("{name}: {e}"))?;
    let set =
        find_electrodes(&imported, &uncut, &asked.electrodes, &task).map_err(|e| anyhow::anyhow!("{name}: {e}"))?;
    let is_made = |o: &&Override| !set.electrodes.iter().any(|e| e.name == o.of);
    if let Some(unknown) = arguments.overrides.iter().find(is_made) {
        let names: Vec<&str> = set.electrodes.iter().map(|e| e.name.as_str()).collect();
        let names = if names.is_empty() { "are none".to_owned() } else { format!("is {}", names.join(", ")) };
        anyhow::bail!("--override {unknown}: there is no electrode {}; there {names}", unknown.of);
    }
    let file_name = mesh.file_name().map_or(name, |n| n.to_string_lossy().into_owned());
    let mut report = ElectrodesReport::of(&set, &file_name, asked.opening(), &asked.datum, uncut.is_certain());
    report.table.notes.extend(imported.report.notes().chain(uncut.doubts()));
    let mut lines = lines(&set, &report, &asked.datum.of_upright(asked.opening()));
    if arguments.compare_divisions {
        let ways =
            compare_divisions(&imported, &uncut, &set, &task).map_err(|e| anyhow::anyhow!("{file_name}: {e}"))?;
        lines.extend(division_lines(&ways));
        report.divisions = Some(ways);
    }
    let mut has_all_files = true;
    if let Some(folder) = folder {
        let drawn =
            if arguments.no_pictures { Ok(Vec::new()) } else { pictures(&imported.mesh, &set, asked.opening(), &task) };
        let pictures = drawn.unwrap_or_else(|error| {
            lines.push(format!("no pictures in the report: {error}"));
            Vec::new()
        });
        session.task.check()?;
        let formats = arguments.formats.iter().copied().map(ElectrodeFormat::from).collect();
        let forms = ElectrodeForms { formats, burn_sheet: sheet, set_up: asked.setup.set_up() };
        let page = ElectrodesPage { times: &steps(&clock.times()), pictures: &pictures };
        let (written, published) = export_electrodes(folder, (&set, &report), &forms, &page, &session.task)?;
        has_all_files = written.no_sheet.is_none() && written.left_out.iter().all(|left| left.format.is_none());
        lines.extend(not_written(&written, &published));
    } else {
        lines.push(
            "nothing was written: give --out DIR for electrode files, burn table, burn sheet and report".to_owned(),
        );
    }
    lines.extend(uncut.doubts().iter().map(|doubt| format!("warning: {doubt}")));
    let is_whole = uncut.is_whole();
    if !is_whole {
        lines.push("beside the electrodes' regions more is left, or not known: see the warnings".to_owned());
    }
    super::terminal::finish();
    say!("{}", if session.json { report.json()? } else { lines.join("\n") });
    Ok(if set.holds() && is_whole && has_all_files { Answer::Yes } else { Answer::No })
}

/// Puts what is given in the place of what `params` have.
fn apply(arguments: &ElectrodesArguments, params: &mut MoldParams) -> anyhow::Result<()> {
    let params = &mut params.electrodes;
    if let Some(file) = &arguments.holders {
        params.holders = read_holders(file)?;
    }
    if let Some(gap) = arguments.gap {
        params.stages.iter_mut().for_each(|stage| stage.gap_mm = gap);
    }
    if arguments.net {
        params.shape = Shape::Net;
    }
    if let Some(file) = &arguments.electrode_library {
        params.cutters = Some(CUTTERS.read(file)?);
    } else if !arguments.electrode_cutters.is_empty() {
        params.cutters = Some(CutterLibrary { cutter: arguments.electrode_cutters.clone() });
    }
    params.overrides.extend(arguments.overrides.iter().cloned());
    Ok(())
}

/// The report's pictures.
fn pictures(mesh: &Mesh, set: &ElectrodeSet, opening: Opening, task: &Task) -> anyhow::Result<Vec<Picture>> {
    let (shapes, mold) = (electrode_shapes(set), Arc::new(RenderMesh::new(mesh)));
    Ok(draw(electrode_pictures(set, &shapes, &mold, opening), task)?)
}

/// What was made and what fails, with places in the axes of the datum, which `axes` lead to from the upright mold.
fn lines(set: &ElectrodeSet, report: &ElectrodesReport, axes: &DAffine3) -> Vec<String> {
    let mut lines = vec![report.sentence.clone()];
    let datum = &report.table.datum;
    if *axes != DAffine3::IDENTITY {
        let [x, y, z] = datum.origin_mm;
        let (name, angle) = (&datum.name, datum.angle_deg);
        lines.push(format!(
            "positions are from the work datum: {name}, at ({x}, {y}, {z}) of the file, turned by {angle} deg"
        ));
    }
    for ((electrode, findings), entry) in set.electrodes.iter().zip(&set.checks).zip(&report.table.electrodes) {
        let burns = electrode.burns.len();
        let parts: usize = electrode.burns.iter().map(|b| b.parts.len()).sum();
        lines.push(format!(
            "{}: {burns} burn{}, {parts} place{}, blank {} mm, {}, {}",
            electrode.name,
            if burns == 1 { "" } else { "s" },
            if parts == 1 { "" } else { "s" },
            entry.blank.text(" x "),
            entry.holder.as_ref().map_or("no holder", |h| &h.name),
            electrode.figures.minutes_text()
        ));
        lines.push(format!("    {}; electrodes needed: {}", electrode.figures.wear_text(), entry.needed));
        lines.extend(entry.family.as_ref().map(|family| {
            let [x, y] = family.offset_mm;
            format!(
                "    same body as {}: its heads are {x}, {y} mm from the middle of the base",
                family.others.join(", ")
            )
        }));
        lines.extend(entry.warnings.iter().map(|text| format!("    {text}")));
        let failed = findings.iter().filter(|f| !f.holds);
        lines.extend(failed.map(|f| {
            let place = f.place.map(|p| axes.transform_point3(p));
            let place = place.map_or_else(String::new, |p| format!(" at ({:.3}, {:.3}, {:.3})", p.x, p.y, p.z));
            format!("    {} fails: {}{place}", f.kind.name(), f.text)
        }));
    }
    for NotBurned { region, why } in &report.table.not_burned {
        let is_burned = |e: &Electrode| e.burns.iter().flat_map(|b| &b.parts).any(|part| part.region + 1 == *region);
        let what = if set.electrodes.iter().any(is_burned) { "" } else { " has no electrode" };
        lines.push(format!("region {region}{what}: {why}"));
    }
    lines.extend(rests_on(report));
    lines.extend(corners(set, axes));
    let idle = set.idle_overrides(&set.params.overrides);
    lines.extend(idle.into_iter().map(|(o, why)| format!("override {o}: {why}")));
    lines
}

/// What minutes and wear rest on and what is missing, each once. Of what is not considered the first few are named.
fn rests_on(report: &ElectrodesReport) -> Vec<String> {
    const NAMED: usize = 3;
    let (mut lines, mut without): (Vec<String>, Vec<String>) = Default::default();
    let add = |to: &mut Vec<String>, line: &str| {
        let line = line.split_whitespace().collect::<Vec<_>>().join(" ");
        if !to.contains(&line) {
            to.push(line);
        }
    };
    for electrode in report.table.electrodes.iter() {
        for line in &electrode.rests_on {
            match line.strip_prefix(NOT_CONSIDERED) {
                Some(items) => items.trim_end_matches('.').split("; ").for_each(|item| add(&mut without, item)),
                None => add(&mut lines, line),
            }
        }
    }
    if !without.is_empty() {
        let more = without.len().saturating_sub(NAMED);
        without.truncate(NAMED);
        let more = if more > 0 { format!("; and {more} more, which the report names") } else { String::new() };
        lines.push(format!("{NOT_CONSIDERED}{}{more}.", without.join("; ")));
    }
    lines
}

/// The ways of dividing as a table.
fn division_lines(ways: &[WayResult]) -> Vec<String> {
    let head = "divided at          regions  edges  remain  heads  electrodes  burns      min  longest mm  not millable  \
                not burned";
    let line = |w: &WayResult| {
        let name = format!("{}{}", w.way.name(), if w.is_own { " (own)" } else { "" });
        if let Some(why) = &w.failure {
            return format!("{name:<18}  {why}");
        }
        format!(
            "{name:<18}  {:>7}  {:>5}  {:>6}  {:>5}  {:>10}  {:>5}  {:>7}  {:>10.2}  {:>12}  {:>10}",
            w.regions,
            w.edges,
            w.edges_left,
            w.heads,
            w.electrodes,
            w.burns,
            w.minutes.map_or_else(|| "?".to_owned(), |minutes| format!("{minutes:.0}")),
            w.largest_mm,
            w.not_millable,
            w.not_burned
        )
    };
    std::iter::once(head.to_owned()).chain(ways.iter().map(line)).collect()
}

/// What sharp corners keep, where that is more than is allowed on faces: it is no failure, and has to be known.
fn corners(set: &ElectrodeSet, axes: &DAffine3) -> Option<String> {
    let tolerance = set.params.tolerance_mm;
    let kept = set.regions.iter().map(|r| &r.left).filter(|left| left.excess <= tolerance);
    let most = kept.max_by(|a, b| a.thickness.total_cmp(&b.thickness)).filter(|left| left.thickness > tolerance)?;
    let p = axes.transform_point3(most.place);
    Some(format!(
        "residual stock in sharp corners is up to {:.4} mm, allowed rest {tolerance} mm, as near ({:.3}, {:.3}, \
         {:.3}); a smaller spark gap leaves less",
        most.thickness, p.x, p.y, p.z
    ))
}

fn not_written(written: &WrittenElectrodes, published: &Published) -> Vec<String> {
    let mut lines = Vec::new();
    for left in &written.left_out {
        let kind = left.format.map_or_else(String::new, |f| format!(" as {}", f.extension().to_uppercase()));
        lines.push(format!("{} was not written{kind}: {}", left.electrode, left.why));
    }
    lines.extend(published.notes());
    lines.extend(written.no_sheet.as_ref().map(|why| format!("burn_sheet.txt was not written: {why}")));
    lines
}

/// The check of an electrode that is let pass.
fn electrode_override(text: &str) -> Result<Override, String> {
    let given: Override = text.parse()?;
    given.validate(&CheckKind::ALL.map(CheckKind::name), true).map_err(|e| e.to_string())?;
    Ok(given)
}
