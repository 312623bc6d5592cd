//! `sparkpath flank`: five-axis flank milling of a ruled surface.

use std::time::Instant;

use super::flank_arguments::{Asked, FlankArguments};
use super::{Answer, Session};
use crate::workspaces::flank::comparison::{Variant, best, compare};
use crate::workspaces::flank::document::FlankDocument;
use crate::workspaces::flank::document::cutter_list::CutterList;
use crate::workspaces::flank::export::{ExportChoice, export};
use crate::workspaces::flank::inputs::{input, load_machine, load_surface, load_walls, walls_unit};
use crate::workspaces::flank::report::FlankReport;
use crate::workspaces::flank::report::build::{report, sentence};
use files::paths::user_folder;
use files::{Document, ExportFolder, Params};
use flank::FlankError;
use flank::fit_ruled::{Candidate, CandidateFit};
use nc::flank_job::{FlankJobError, FlankResult, LoadedSurface, flank as plan};

/// Plans the flank, checks the path, writes what may be milled. The answer is no where a check fails, overridden or
/// not.
pub(super) fn flank(arguments: &FlankArguments, session: &Session) -> anyhow::Result<Answer> {
    // What is quick to find wrong comes before what takes long.
    if let Some(folder) = &arguments.out {
        ExportFolder::check(folder)?;
    }
    let Asked { mut document, notes } = arguments.asked(session)?;
    let cutters = arguments.cutters()?;
    let task = &session.task;
    let machine = load_machine(&document, user_folder().as_deref())?;
    let in_unit = walls_unit(&document);
    let walls = document.walls.as_ref().map(|walls| load_walls(walls, in_unit, task)).transpose()?;
    let surface = load_surface(&document.source, task)?;
    if arguments.surface.list {
        surface.doubts.iter().for_each(|doubt| session.note(doubt));
        return list(&surface.value, session);
    }
    let mut input = input(&document, surface, walls, machine);
    input.doubts.extend(notes);
    let start = Instant::now();
    let control_points = input.params.control_points;
    let listed = |list: CutterList| -> Vec<Variant> {
        list.cutter.into_iter().map(|cutter| Variant { cutter, control_points }).collect()
    };
    let mut rows = cutters.map(|list| compare(&input, &listed(list), task)).transpose()?.unwrap_or_default();
    if let Some(best) = best(&rows) {
        document.cutter = rows[best].variant.cutter.clone();
        input.cutter = document.cutter.clone();
    }
    let base = Variant { cutter: input.cutter.clone(), control_points };
    let swept = arguments.sweep().map(|sweep| compare(&input, &sweep.variants(&base), task)).transpose()?;
    rows.extend(swept.unwrap_or_default());
    if let Some(file) = &arguments.save {
        Document::new(document.clone()).export(file)?;
    }
    let result = plan(&input, task).map_err(|e| {
        let remedy = if matches!(e, FlankJobError::Flank(FlankError::SideOpen { .. })) {
            "; give --side positive or --side negative"
        } else {
            ""
        };
        anyhow::anyhow!("{}: {e}{remedy}", document.name())
    })?;
    let seconds = start.elapsed().as_secs_f64();
    session.task.check()?;
    // What is let pass now is not let pass again however bad it gets.
    let remembered = FlankDocument { overrides: result.remembered(&document.overrides), ..document.clone() };
    if let Some(file) = arguments.save.as_ref().filter(|_| remembered != document) {
        Document::new(remembered).export(file)?;
    }
    let mut lines = lines(&result);
    lines.extend(rows.iter().map(|row| format!("with {}", row.sentence())));
    lines.push(format!("planned and checked in {seconds:.2} s"));
    if let Some(folder) = &arguments.out {
        let written =
            export(folder, (&result, &document), &rows, ExportChoice::ALL, task).map_err(anyhow::Error::msg)?;
        lines.push(written.sentence());
    }
    super::terminal::finish();
    let report = FlankReport { compared: rows, ..report(&result, &document) };
    say!("{}", if session.json { report.json()? } else { lines.join("\n") });
    Ok(if result.holds() { Answer::Yes } else { Answer::No })
}

/// The flanks of a mesh.
fn list(surface: &LoadedSurface, session: &Session) -> anyhow::Result<Answer> {
    let LoadedSurface::Face { candidates, .. } = surface else { return Ok(Answer::Yes) };
    super::terminal::finish();
    if session.json {
        let entries: Vec<serde_json::Value> = candidates.iter().enumerate().map(|(i, c)| entry(i + 1, c)).collect();
        say!("{}", serde_json::to_string_pretty(&entries)?);
    } else {
        let lines = candidates.iter().enumerate().map(|(i, c)| {
            let looks = if c.outwards.length() < 0.5 {
                "normals all around".to_owned()
            } else {
                format!("normal ({:.3}, {:.3}, {:.3})", c.outwards.x + 0.0, c.outwards.y + 0.0, c.outwards.z + 0.0)
            };
            format!("{}: {}; {looks}", i + 1, c.summary())
        });
        say!("{}", lines.collect::<Vec<_>>().join("\n"));
    }
    Ok(if candidates.iter().any(Candidate::is_millable) { Answer::Yes } else { Answer::No })
}

fn entry(number: usize, candidate: &Candidate) -> serde_json::Value {
    let fit = match &candidate.fit {
        CandidateFit::Fitted(fit) => Some(fit),
        _ => None,
    };
    serde_json::json!({
        "flank": number,
        "kind": candidate.kind.name(),
        "area_mm2": candidate.area_mm2,
        "height_mm": candidate.height_mm,
        "outwards": candidate.outwards.to_array(),
        "triangles": candidate.triangles.len(),
        "is_ruled": candidate.is_ruled(),
        "covers": fit.is_some_and(|f| f.covers),
        "error": fit.map(|f| f.error),
        "text": candidate.summary(),
    })
}

/// The answer in words.
fn lines(result: &FlankResult) -> Vec<String> {
    let mut lines = vec![sentence(result)];
    for (name, path) in result.plan.paths() {
        let (d, moving) = (&path.deviation, &path.envelope.deviation);
        lines.push(format!(
            "{name}: total absolute deviation {:.3} mm ({}), mean {:.2} um, rms {:.2} um, overcut {:.1} um, \
             undercut {:.1} um; swept envelope: total {:.3} mm, overcut {:.1} um, undercut {:.1} um",
            d.sum,
            result.plan.ratio_words(d.sum),
            1e3 * d.mean,
            1e3 * d.rms,
            1e3 * (-d.most_overcut).max(0.0),
            1e3 * d.most_undercut.max(0.0),
            moving.sum,
            1e3 * (-moving.most_overcut).max(0.0),
            1e3 * moving.most_undercut.max(0.0)
        ));
    }
    let ranks = &result.plan.ranks;
    lines.push(match ranks.best {
        0 => format!("none of {} ranks is better than the initial path", ranks.sums.len()),
        best => format!("rank {best} of {} is the best", ranks.sums.len()),
    });
    for check in &result.checks {
        let state = match (check.holds, check.is_overridden) {
            (true, _) => "holds",
            (false, true) => "fails, overridden",
            (false, false) if check.lapsed.is_some() => "FAILS, its override no longer holds",
            (false, false) => "FAILS",
        };
        let place = check.place.filter(|_| !check.holds);
        let place = place.map_or_else(String::new, |p| format!(" at ({:.3}, {:.3}, {:.3})", p.x, p.y, p.z));
        lines.push(format!("check {}: {state}: {}{place}", check.kind.name(), check.text));
    }
    if let Some(milled) = result.milled() {
        lines.push(format!("{:.1} s of milling, approach and retraction included", 60.0 * milled.minutes));
    }
    lines.extend(result.fit.iter().flat_map(|fit| fit.words.iter().skip(1)).map(|words| format!("fit: {words}")));
    lines.extend(result.all_warnings().into_iter().map(|warning| format!("note: {warning}")));
    lines
}
