//! `sparkpath measured`: a finished part that was scanned, fitted to its nominal mesh and judged.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use clap::Args;
use serde_json::json;

use super::{Answer, POSITIVE, Session, mm, unit};
use crate::workspaces::blisk::document::scan::{ALL_FREE, freedoms};
use crate::workspaces::blisk::job::plan_pictures::drawn;
use crate::workspaces::blisk::job::scan::{Judgement, ScannedPart, Surfaces};
use crate::workspaces::blisk::report::measured::{ScanPage, page};
use crate::workspaces::blisk::scene::scan::scan_picture;
use files::ExportFolder;
use files::report::Picture;
use geometry::mesh::Mesh;
use import::{Reading, Units};
use measured::deviation::{DeviationMap, Statistics, Tolerance};
use measured::fit::BestFit;
use measured::points::{PointLimits, read_points};
use measured::table::{deviations_csv, deviations_ply};
use render::colour::Colour;
use render::colour_map::ColourMap;
use render::offscreen::RenderError;
use wheel::error::BliskError;
use wheel::find_channel::find_channel;
use wheel::options::BliskOptions;

/// Name of the command in manifests.
const MEASURED: &str = "measured";

#[derive(Debug, Args)]
pub(super) struct MeasuredArguments {
    /// The finished part as it is to be: STL, OBJ, glTF, GLB or STEP.
    nominal: PathBuf,
    /// Points of the scan (mm): STL, OBJ, PLY, XYZ or CSV, roughly aligned.
    scan: PathBuf,
    /// Greatest deviation, either way (mm).
    #[arg(long, value_name = "MM", default_value = "0.03", value_parser = |text: &str| mm(text, POSITIVE))]
    tolerance: f64,
    /// Share of the points that must lie within it, from 0 to 1.
    #[arg(long, value_name = "SHARE", default_value_t = 1.0)]
    share: f64,
    /// Axes that the fit may move the scan along and about, of x, y, z, a, b and c, such as x,y,z,c for what a machine can
    /// correct; none for a scan that lies as it is to be [default: all].
    #[arg(long, value_name = "AXES")]
    free: Option<String>,
    /// Distance from the nominal surface beyond which points do not count (mm): what the scanner saw of a fixture.
    #[arg(long, value_name = "MM", value_parser = |text: &str| mm(text, POSITIVE))]
    reach: Option<f64>,
    /// Unit of the nominal mesh: auto, mm, cm, m, inch.
    #[arg(long, value_name = "UNIT", default_value = "auto", value_parser = unit)]
    units: Units,
    /// No picture on the page.
    #[arg(long)]
    no_pictures: bool,
    /// Folder for measured.json, measured.html, deviations.csv and deviations.ply, made if it is not there.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

/// Fits, judges and writes.
pub(super) fn measured(arguments: &MeasuredArguments, session: &Session) -> anyhow::Result<Answer> {
    let tolerance = Tolerance::symmetric(arguments.tolerance)?.for_share(arguments.share)?;
    let free = arguments.free.as_deref().unwrap_or(ALL_FREE);
    let freedoms = freedoms(free).map_err(|problem| anyhow::anyhow!("--free {problem}"))?;
    if let Some(folder) = &arguments.out {
        // An older verdict must not outlive a failure of this one.
        ExportFolder::write_all(folder, MEASURED, &[])?;
    }
    let mesh = session.import(&arguments.nominal, &Reading { units: arguments.units, ..Default::default() })?.mesh;
    let scan = read_points(&arguments.scan, &PointLimits::default(), &session.task)?.points;
    let mesh = Arc::new(mesh);
    let surfaces = surfaces_of(&mesh, session)?;
    let reach_mm = arguments.reach.unwrap_or(f64::INFINITY);
    let judgement = Judgement { tolerance, freedoms, reach_mm };
    let found = ScannedPart::of(mesh.clone(), &surfaces, &scan, &judgement, &session.task)?;
    let ScannedPart { fit, map, beyond_reach, verdict, all, by_surface, by_channel, worst, .. } = &found;
    super::terminal::finish();
    let answer = json!({
        "within": verdict.is_within,
        "verdict": verdict.to_string(),
        "points": map.list().len(),
        "beyond_reach": beyond_reach,
        "unit_doubt": found.unit_doubt,
        "fit": fit.as_ref().map(fit_json),
        "all": statistics_json(all),
        "surfaces": by_surface.iter().map(|(name, of)| (name.clone(), statistics_json(of))).collect::<serde_json::Map<_, _>>(),
        "channels": by_channel.iter().map(|(number, of)| (number.to_string(), statistics_json(of))).collect::<serde_json::Map<_, _>>(),
        "worst": worst.iter().map(|worst| json!({
            "surface": worst.surface,
            "deviation_mm": worst.deviation.distance,
            "at_mm": worst.deviation.point.to_array(),
        })).collect::<Vec<_>>(),
    });
    if session.json {
        say!("{}", serde_json::to_string_pretty(&answer)?);
    } else {
        say!("The part is {verdict}.");
        found.fit_sentences().iter().for_each(|sentence| say!("{sentence}"));
        let heads = |first| {
            say!("{first:28} {:>9} {:>9} {:>9} {:>9} {:>9}", "points", "least mm", "mean", "greatest", "within")
        };
        heads("surface");
        by_surface.iter().for_each(|(name, of)| print_row(name, of));
        if !by_channel.is_empty() {
            heads("channel");
            by_channel.iter().for_each(|(number, of)| print_row(&number.to_string(), of));
        }
        for worst in worst {
            let (p, name) = (worst.deviation.point, &worst.surface);
            say!(
                "worst      {:+.4} mm on the {name} at ({:.3}, {:.3}, {:.3}) mm",
                worst.deviation.distance,
                p.x,
                p.y,
                p.z
            );
        }
    }
    if let Some(folder) = &arguments.out {
        let pictures = if arguments.no_pictures { Vec::new() } else { pictures(&found, &mesh, session)? };
        let (nominal, scan) = (file_name(&arguments.nominal), file_name(&arguments.scan));
        let html = page(&found, &ScanPage { nominal: &nominal, scan: &scan, pictures: &pictures })?;
        let files = [
            ("measured.json", serde_json::to_string_pretty(&answer)?.into_bytes()),
            ("measured.html", html.into_bytes()),
            ("deviations.csv", deviations_csv(map, |of| surfaces.name(of.triangle)).into_bytes()),
            ("deviations.ply", coloured(map, arguments.tolerance)),
        ];
        let files: Vec<(&str, &[u8])> = files.iter().map(|(name, bytes)| (*name, bytes.as_slice())).collect();
        ExportFolder::write_all(folder, MEASURED, &files)?;
        let written = "measured.json, measured.html, deviations.csv and deviations.ply are in";
        session.note(&format!("{written} {}", folder.display()));
    }
    Ok(if verdict.is_within { Answer::Yes } else { Answer::No })
}

/// The picture of the page; none, with the reason told, where nothing can be drawn.
fn pictures(found: &ScannedPart, mesh: &Mesh, session: &Session) -> anyhow::Result<Vec<Picture>> {
    match drawn(scan_picture(found, mesh), &session.task) {
        Ok(picture) => Ok(vec![picture]),
        Err(RenderError::Cancelled(cancelled)) => Err(cancelled.into()),
        Err(error) => {
            session.note(&format!("no picture on the page: {error}"));
            Ok(Vec::new())
        }
    }
}

/// Name of a file without its folder.
fn file_name(path: &Path) -> String {
    path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned())
}

fn print_row(name: &str, of: &Statistics) {
    let share = format!("{:.2} %", 100.0 * of.share_within);
    let Statistics { points, least_mm, mean_mm, greatest_mm, .. } = of;
    say!("{name:28} {points:>9} {least_mm:>9.4} {mean_mm:>9.4} {greatest_mm:>9.4} {share:>9}");
}

/// The surfaces of a wheel; none of a part that is no wheel.
fn surfaces_of(mesh: &Mesh, session: &Session) -> anyhow::Result<Surfaces> {
    match find_channel(mesh, &BliskOptions::default(), &session.task) {
        Ok(channel) => Ok(Surfaces::of_wheel(mesh, &channel, &[], &session.task)?),
        Err(BliskError::Cancelled(cancelled)) => Err(cancelled.into()),
        Err(why) => {
            session.note(&format!("the part is one surface, as no channel of a wheel is found: {why}"));
            Ok(Surfaces::default())
        }
    }
}

/// The deviations as coloured points: lightest at none, the ends of the colours at twice the tolerance.
fn coloured(map: &DeviationMap, tolerance: f64) -> Vec<u8> {
    deviations_ply(map, |deviation| {
        let Colour { r, g, b } = ColourMap::Diverging.at(0.5 + 0.25 * deviation / tolerance);
        [r, g, b]
    })
}

fn statistics_json(of: &Statistics) -> serde_json::Value {
    json!({
        "points": of.points,
        "least_mm": of.least_mm,
        "mean_mm": of.mean_mm,
        "greatest_mm": of.greatest_mm,
        "rms_mm": of.rms_mm,
        "share_within": of.share_within,
    })
}

fn fit_json(fit: &BestFit) -> serde_json::Value {
    let value = |value: f64, is_rotation: bool| if is_rotation { value.to_degrees() } else { value };
    json!({
        "axes": fit.values.iter().map(|of| json!({
            "axis": of.freedom.letter().to_string(),
            "unit": if of.freedom.is_rotation() { "deg" } else { "mm" },
            "value": value(of.value, of.freedom.is_rotation()),
            "standard_deviation": value(of.standard_deviation, of.freedom.is_rotation()),
        })).collect::<Vec<_>>(),
        "undetermined": fit.undetermined.iter().map(ToString::to_string).collect::<Vec<_>>(),
        "rms_mm": fit.rms_mm,
        "scale_mm": fit.scale_mm,
        "iterations": fit.iterations,
        "has_converged": fit.has_converged,
        "beyond_reach": fit.beyond_reach,
    })
}
