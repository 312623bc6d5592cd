//! `sparkpath measured`: a finished part that was scanned, fitted to its nominal mesh and judged.

use std::path::PathBuf;
use std::sync::Arc;

use clap::Args;
use serde_json::json;

use super::{Answer, POSITIVE, Session, mm, unit};
use files::ExportFolder;
use geometry::frame::Frame;
use import::{Reading, Units};
use measured::Nominal;
use measured::deviation::{Deviation, DeviationMap, Statistics, Tolerance, deviations};
use measured::fit::{BestFit, FitSettings, Freedom, Freedoms, best_fit};
use measured::points::{PointLimits, read_points};
use measured::table::{deviations_csv, deviations_ply};
use render::colour::Colour;
use render::colour_map::ColourMap;
use wheel::inspect::inspect;
use wheel::options::BliskOptions;

/// Name of the command in manifests.
const MEASURED: &str = "measured";
/// Worst places that are listed.
const WORST: usize = 10;
/// Surface of a part that is no wheel.
const PART: &str = "part";

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
    /// Folder for measured.json, deviations.csv and deviations.ply, made if it is not there.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

/// The free axes that `text` names; none for a scan that is not to be moved.
fn freedoms(text: &str) -> anyhow::Result<Option<Freedoms>> {
    if text.trim().eq_ignore_ascii_case("none") {
        return Ok(None);
    }
    let axis = |part: &str| {
        let letter = part.trim();
        let axis = Freedom::ALL.into_iter().find(|axis| letter.eq_ignore_ascii_case(&axis.letter().to_string()));
        axis.ok_or_else(|| {
            anyhow::anyhow!("--free {letter:?}: give axes of x, y, z, a, b, c with commas between, or none")
        })
    };
    let free = text.split(',').map(axis).collect::<anyhow::Result<Vec<_>>>()?;
    Ok(Some(Freedoms::of(Frame::IDENTITY, &free)?))
}

/// Fits, judges and writes.
pub(super) fn measured(arguments: &MeasuredArguments, session: &Session) -> anyhow::Result<Answer> {
    let tolerance = Tolerance::symmetric(arguments.tolerance)?.for_share(arguments.share)?;
    let freedoms = arguments.free.as_deref().map_or_else(|| Ok(Some(Freedoms::all())), freedoms)?;
    if let Some(folder) = &arguments.out {
        // An older verdict must not outlive a failure of this one.
        ExportFolder::write_all(folder, MEASURED, &[])?;
    }
    let mesh = session.import(&arguments.nominal, &Reading { units: arguments.units, ..Default::default() })?.mesh;
    let scan = read_points(&arguments.scan, &PointLimits::default(), &session.task)?.points;
    let surfaces = surfaces_of(&mesh, session)?;
    let nominal = Nominal::new(Arc::new(mesh), &session.task)?;
    let reach_mm = arguments.reach.unwrap_or(f64::INFINITY);
    let fit = match freedoms {
        Some(freedoms) => {
            let settings = FitSettings { freedoms, reach_mm, ..Default::default() };
            Some(best_fit(&nominal, &scan, &settings, &session.task)?)
        }
        None => None,
    };
    let motion = fit.as_ref().map_or_else(Default::default, |fit| fit.motion);
    let (map, beyond) = deviations(&nominal, &scan, &motion, &session.task)?.within_reach(reach_mm);
    let surface = |deviation: &Deviation| surfaces.get(deviation.triangle as usize).map_or(PART, String::as_str);
    let verdict = map.verdict(&tolerance);
    let by_surface = map.statistics_by(&tolerance, surface);
    let spacing = 0.01 * nominal.mesh().bounds().size().length();
    let worst = map.worst(WORST, spacing, &tolerance, surface);
    super::terminal::finish();
    let answer = json!({
        "within": verdict.is_within,
        "verdict": verdict.to_string(),
        "points": map.list().len(),
        "beyond_reach": beyond,
        "fit": fit.as_ref().map(fit_json),
        "all": statistics_json(&map.statistics(&tolerance)),
        "surfaces": by_surface.iter().map(|(name, of)| (name.to_string(), statistics_json(of))).collect::<serde_json::Map<_, _>>(),
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
        fit.iter().for_each(print_fit);
        say!("{:28} {:>9} {:>9} {:>9} {:>9} {:>9}", "surface", "points", "least mm", "mean", "greatest", "within");
        for (name, of) in &by_surface {
            let share = format!("{:.2} %", 100.0 * of.share_within);
            say!(
                "{name:28} {:>9} {:>9.4} {:>9.4} {:>9.4} {share:>9}",
                of.points,
                of.least_mm,
                of.mean_mm,
                of.greatest_mm
            );
        }
        for worst in &worst {
            let (p, name) = (worst.deviation.point, worst.surface);
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
        let files = [
            ("measured.json", serde_json::to_string_pretty(&answer)?.into_bytes()),
            ("deviations.csv", deviations_csv(&map, surface).into_bytes()),
            ("deviations.ply", coloured(&map, arguments.tolerance)),
        ];
        let files: Vec<(&str, &[u8])> = files.iter().map(|(name, bytes)| (*name, bytes.as_slice())).collect();
        ExportFolder::write_all(folder, MEASURED, &files)?;
        session.note(&format!("measured.json, deviations.csv and deviations.ply are in {}", folder.display()));
    }
    Ok(if verdict.is_within { Answer::Yes } else { Answer::No })
}

/// The name of the surface that each triangle is of, where the part is a wheel; none at all where it is not.
fn surfaces_of(mesh: &geometry::mesh::Mesh, session: &Session) -> anyhow::Result<Vec<String>> {
    let found = inspect(mesh, None, &BliskOptions::default(), &session.task)?;
    let Some(surfaces) = found.surfaces else { return Ok(Vec::new()) };
    let name = |class| surfaces.areas.iter().find(|area| area.class == class).map_or(PART, |area| area.name.as_str());
    Ok(surfaces.classes.iter().map(|class| name(*class).to_owned()).collect())
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

fn print_fit(fit: &BestFit) {
    let values = fit.values.iter().map(|of| {
        let letter = of.freedom.letter();
        match of.freedom.is_rotation() {
            true => format!("{letter} {:+.5}±{:.5} deg", of.value.to_degrees(), of.standard_deviation.to_degrees()),
            false => format!("{letter} {:+.5}±{:.5} mm", of.value, of.standard_deviation),
        }
    });
    let values = values.collect::<Vec<_>>().join(", ");
    let end = if fit.has_converged { "" } else { ", which did not settle" };
    say!("The scan was moved by {values}: rms {:.5} mm after {} iterations{end}.", fit.rms_mm, fit.iterations);
    for undetermined in &fit.undetermined {
        say!("The scan does not determine a {undetermined}: it was left as it is.");
    }
}
