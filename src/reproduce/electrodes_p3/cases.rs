//! The cases of section 6: the paper ran its system on 200 real molds and gives no figures on them. Ours are molds at
//! random.

use std::time::Instant;

use super::{Outcome, Table, blank, part_file, wrong};
use crate::reproduce::{ReproduceError, Verdict};
use crate::workspaces::mold::job::electrodes::electrodes;
use crate::workspaces::mold::job::uncut::{UncutParams, uncut};
use crate::workspaces::mold::report::corpus::{Corpus, CorpusFigures, CorpusRow};
use files::report::number;
use mold::cutter::{Cutter, CutterLibrary};
use mold::electrode::params::{ElectrodeParams, Stage};
use mold::random_mold::random_mold;
use rayon::prelude::*;
use task::Task;

const NAME: &str = "Section 6";
/// Cases of the paper, and molds that are run here.
const MOLDS: usize = 200;
/// One mold in so many also gets electrodes, which takes much longer.
const ELECTRODES_OF_EVERY: usize = 50;

/// Electrodes of a mold: number, those that pass every check, regions without any.
type Made = [usize; 3];
/// A mold of the table, its electrodes if any were made, and its file.
type Case = (CorpusRow, Option<Made>, Vec<(String, Vec<u8>)>);

pub(super) fn outcome(task: &Task) -> Result<Outcome, ReproduceError> {
    let stage = task.as_stage("random molds");
    let library = CutterLibrary {
        cutter: vec![Cutter::flat(1.0), Cutter::flat(2.0), Cutter::flat(5.0), Cutter::ball(1.0), Cutter::ball(3.0)],
    };
    let params = ElectrodeParams { stages: vec![Stage::finish(0.05)], ..ElectrodeParams::default() };
    let run = |index: usize| -> Result<Case, ReproduceError> {
        task.check()?;
        let start = Instant::now();
        let (mesh, opening) = random_mold(index as u64, &task.cancel).map_err(wrong(NAME, task))?;
        let asked = UncutParams { opening, ..UncutParams::of(library.clone()) };
        let run = || -> Result<(CorpusFigures, Option<Made>), String> {
            let found = uncut(&mesh, &asked, &stage).map_err(|error| error.to_string())?;
            let figures = CorpusFigures::of(&mesh, &found);
            if !index.is_multiple_of(ELECTRODES_OF_EVERY) {
                return Ok((figures, None));
            }
            let set = electrodes(&mesh, &found, &params, &stage).map_err(|error| error.to_string())?;
            let passing = (0..set.electrodes.len()).filter(|e| !set.fails(*e)).count();
            let made = [set.electrodes.len(), passing, set.without_electrode().len()];
            Ok((figures, Some(made)))
        };
        let result = run();
        task.check()?;
        let made = result.as_ref().ok().and_then(|(_, made)| *made);
        let figures = result.map(|(figures, _)| figures);
        let row = CorpusRow::of(format!("mold {index}"), figures, start.elapsed().as_secs_f64());
        Ok((row, made, part_file(&format!("mold_{index:03}"), &mesh)))
    };
    let runs = (0..MOLDS).into_par_iter().map(run).collect::<Result<Vec<_>, _>>()?;
    let mut corpus = Corpus { folder: "random molds".to_owned(), molds: MOLDS, rows: Vec::new() };
    let (mut made, mut files) = (Vec::new(), Vec::new());
    for (row, of, file) in runs {
        corpus.rows.push(row);
        made.push(of);
        files.extend(file);
    }
    let row = |(row, made): (&CorpusRow, &Option<Made>)| match &row.figures {
        Some(f) => {
            let mut cells = vec![row.file.clone(), f.triangles.to_string(), f.regions.to_string()];
            cells.extend([number(f.volume_mm3, 3), number(f.hidden_area_mm2, 1)]);
            let cell = |k: usize| made.map_or_else(|| "–".to_owned(), |made| made[k].to_string());
            cells.extend([0, 1, 2].map(cell));
            cells.extend([f.warnings.len().to_string(), number(row.seconds, 1)]);
            cells
        }
        None => vec![row.file.clone(), format!("failed: {}", row.reason.as_deref().unwrap_or_default())],
    };
    let with: Vec<Made> = made.iter().copied().flatten().collect();
    let sum: Made = with.iter().fold([0; 3], |sum, of| std::array::from_fn(|k| sum[k] + of[k]));
    let whole = with.iter().filter(|[all, passing, without]| *all > 0 && all == passing && *without == 0).count();
    let rate = |count: usize, of: usize| format!("{count} of {of}");
    let summary = vec![
        vec![
            "molds of which the uncut regions were found".to_owned(),
            rate(corpus.rows.len() - corpus.failed(), corpus.rows.len()),
        ],
        vec![
            "molds with regions of which all are burned by electrodes that pass every check".to_owned(),
            rate(whole, with.iter().filter(|[all, _, without]| all + without > 0).count()),
        ],
        vec!["electrodes that pass every check".to_owned(), rate(sum[1], sum[0])],
        vec!["regions that are not burned, or not wholly".to_owned(), sum[2].to_string()],
    ];
    Ok(Outcome {
        verdict: Verdict::NotComparable,
        why: format!(
            "The paper says that it was tested on {MOLDS} real cases, and not with what result. Ours are as many molds at \
             random, of which every {ELECTRODES_OF_EVERY}th gets electrodes as well: pockets on a draft, grooves with \
             sharp grounds, free-form floors, undercuts, leaning slots, openings through the block, turned in all \
             directions. Many cannot be burned whole from one side."
        ),
        by_hand:
            "sparkpath uncut DIR --units mm --cutters flat:1,flat:2,flat:5,ball:1,ball:3, where DIR is a folder with \
                  nothing but the molds p3_mold_000.stl and on of this page; for the electrodes of one: sparkpath electrodes with the same options"
                .to_owned(),
        tables: vec![
            Table::new("Success", &["", "#"], summary),
            Table::new(
                "Molds",
                &[
                    "mold",
                    "#triangles",
                    "#uncut regions",
                    "#volume mm³",
                    "#undercut mm²",
                    "#electrodes",
                    "#passing every check",
                    "#regions not wholly burned",
                    "#warnings",
                    "#s",
                ],
                corpus.rows.iter().zip(&made).map(row).collect(),
            ),
        ],
        files,
        ..blank(NAME, "Molds that the method was tested on", "molds at random, each from its number")
    })
}
