//! Figures of P3 on a whole mold: its case study is not public, ours is the demonstration mold.

use std::sync::Arc;

use super::parts::{WAY_HEAD, minutes, way_row};
use super::{Outcome, Table, Verdict, blank, part_file, same_if, wrong};
use crate::reproduce::ReproduceError;
use crate::workspaces::mold::document::demonstration::demonstration;
use crate::workspaces::mold::document::standard::standard_mold;
use crate::workspaces::mold::job::divisions::{Way, WayResult, compare_divisions};
use crate::workspaces::mold::job::electrodes::electrodes;
use crate::workspaces::mold::job::uncut::{Uncut, uncut};
use crate::workspaces::mold::report::segments::ClassTotal;
use crate::workspaces::mold::report::steps::{StepTime, steps};
use crate::workspaces::mold::scene::electrodes::electrode_shapes;
use crate::workspaces::mold::scene::pictures::{draw, electrode_pictures, pictures_of};
use files::report::{Picture, number};
use geometry::mesh::Mesh;
use mold::electrode::design::{ElectrodeSet, RegionPlan};
use mold::electrode::params::Method;
use mold::opening::Opening;
use render::mesh::RenderMesh;
use task::{StageClock, Task};

/// Part of all these results.
const PART: &str = "demonstration mold: 64 x 46 x 18 mm with ribs, a cross of ribs, a pocket and a boss";
const NAME: &str = "Table 1";
const BY_HAND: &str = "sparkpath electrodes p3_demonstration.stl --units mm --opening +z --out DIR --compare-divisions; \
                       window: demonstration mold";

/// Table 1 of the paper: minutes of each step by an engineer with NX 10, and with the paper's system. The refinement is
/// by hand in both.
const PAPER: [(&str, f64, f64); 4] = [
    ("Uncut detection", 5.0, 5.0),
    ("Electrode design", 35.0, 4.0),
    ("Checks, residual stock included", 3.0, 0.0),
    ("Refinement: reuse and shared bases", 6.0, 4.0),
];

/// The mold with all that is found of it.
struct Shown {
    mesh: Mesh,
    found: Uncut,
    set: ElectrodeSet,
    times: Vec<StepTime>,
    ways: Vec<WayResult>,
    classes: Vec<ClassTotal>,
    /// Regions, uncut segments, electrodes; none where nothing can be drawn.
    pictures: Vec<Picture>,
}

impl Shown {
    fn new(task: &Task) -> Result<Self, ReproduceError> {
        let mesh = demonstration(task).map_err(wrong(NAME, task))?.mesh;
        let mut params = standard_mold(None).map_err(wrong(NAME, task))?;
        params.opening = Some(Opening::PlusZ);
        let clock = StageClock::default();
        let timed = clock.timed(task);
        let found = uncut(&mesh, &params.uncut(), &timed).map_err(wrong(NAME, task))?;
        let set = electrodes(&mesh, &found, &params.electrodes, &timed).map_err(wrong(NAME, task))?;
        let times = steps(&clock.times());
        let ways = compare_divisions(&mesh, &found, &set, task).map_err(wrong(NAME, task))?;
        let classes = ClassTotal::of(&found.classed_runs(&mesh, &task.cancel)?);
        let pictures = pictures(&mesh, &found, &set, task)?;
        Ok(Self { mesh, found, set, times, ways, classes, pictures })
    }

    /// The pictures with these titles.
    fn pictures(&self, titles: &[&str]) -> Vec<Picture> {
        self.pictures.iter().filter(|picture| titles.contains(&&*picture.title)).cloned().collect()
    }
}

/// Pictures of all regions, segments and electrodes.
fn pictures(mesh: &Mesh, found: &Uncut, set: &ElectrodeSet, task: &Task) -> Result<Vec<Picture>, ReproduceError> {
    let mut scenes = pictures_of(mesh, found, &task.cancel)?;
    scenes.retain(|picture| ["Uncut regions", "Uncut segments"].contains(&&*picture.title));
    let (shapes, mold) = (electrode_shapes(set), Arc::new(RenderMesh::new(mesh)));
    scenes.extend(electrode_pictures(set, &shapes, &mold, Opening::PlusZ).into_iter().take(1));
    let drawn = draw(scenes, task);
    task.check()?;
    // A computer without graphics has the figures all the same.
    Ok(drawn.unwrap_or_default())
}

pub(super) fn outcomes(task: &Task) -> Result<Vec<Outcome>, ReproduceError> {
    let shown = Shown::new(task)?;
    Ok(vec![segments(&shown), divided(&shown), combined(&shown), shared(&shown), case_study(&shown), times(&shown)])
}

fn of(name: &str, title: &str) -> Outcome {
    Outcome { by_hand: BY_HAND.to_owned(), ..blank(name, title, PART) }
}

fn segments(shown: &Shown) -> Outcome {
    let mut rows: Vec<Vec<String>> = Vec::new();
    for class in &shown.classes {
        rows.push(vec![class.name.to_owned(), class.runs.to_string(), number(class.length_mm, 2)]);
    }
    Outcome {
        why: "The paper's mold and its layers are not public. Ours are layers just above every horizontal face and as many \
              between as the residue asks for; the paper's are evenly spaced, nearer than the cutter's radius."
            .to_owned(),
        by_hand: "sparkpath uncut p3_demonstration.stl --units mm --opening +z --out DIR; window: slider of layers".to_owned(),
        tables: vec![Table::new(
            &format!("Uncut segments of {} layers by class of interference", shown.found.layers.len()),
            &["interference", "#segments", "#length mm"],
            rows,
        )],
        pictures: shown.pictures(&["Uncut segments"]),
        files: part_file("demonstration", &shown.mesh),
        ..of("Figure 7", "A mold and its section curves")
    }
}

/// The paper's other words on figures 19 to 21 are about special parts; these ways are of a whole mold.
fn divided(shown: &Shown) -> Outcome {
    let own = &shown.ways[Way::HEdges as usize];
    let undivided = &shown.ways[Way::Undivided as usize];
    Outcome {
        verdict: same_if(own.edges_left == 0 && own.not_millable <= undivided.not_millable),
        why: format!(
            "The paper shows one region without figures, split along its H-edges until every part can be milled. Here {} \
             H-edges are found, {} remain after the division, and {} electrodes cannot be milled, against {} undivided. \
             Parts that burn nothing which the others do not burn are left out, so that there may be no more heads.{}",
            own.edges,
            own.edges_left,
            own.not_millable,
            undivided.not_millable,
            minutes(&shown.ways)
        ),
        tables: vec![Table::new("Ways of dividing", &WAY_HEAD, shown.ways.iter().map(way_row).collect())],
        ..of("Figure 18", "H-edges, and a region split along them")
    }
}

fn combined(shown: &Shown) -> Outcome {
    let electrodes = &shown.set.electrodes;
    let many = electrodes.iter().filter(|e| e.burns.len() > 1).count();
    let burns: usize = electrodes.iter().map(|e| e.burns.len()).sum();
    Outcome {
        why: "The paper joins tips of the same shape and size on one electrode, of which it shows one example, and burns them \
              at once. On the demonstration mold one electrode is made for places that are the same but for a turn about the \
              burn direction, and burns them one after another; electrodes.repeat = heads puts such tips on one base. Which \
              of the two is better is not in the paper."
            .to_owned(),
        tables: vec![Table::new(
            "Electrodes",
            &["#electrodes", "#of them for several places", "#burns"],
            vec![vec![electrodes.len().to_string(), many.to_string(), burns.to_string()]],
        )],
        ..of("Figure 26", "Tips of the same shape on one electrode")
    }
}

fn shared(shown: &Shown) -> Outcome {
    let tips = |e: &mold::electrode::design::Electrode| e.burns.first().map_or(0, |burn| burn.parts.len());
    let most = shown.set.electrodes.iter().map(tips).fold(0, usize::max);
    let several = shown.set.electrodes.iter().filter(|e| tips(e) > 1).count();
    Outcome {
        why: "The paper shows five tips on one holder; its distances and its mold are not given, so that the numbers say \
              nothing about which is better. The rule is the same: tips within a distance that is set share a base."
            .to_owned(),
        tables: vec![Table::new(
            "Tips on one base",
            &["", "#most tips on a base", "#bases with several tips"],
            vec![
                vec!["paper".to_owned(), "5".to_owned(), "1".to_owned()],
                vec!["ours".to_owned(), most.to_string(), several.to_string()],
            ],
        )],
        ..of("Figure 27", "Tips that share a holder")
    }
}

fn case_study(shown: &Shown) -> Outcome {
    let (set, found) = (&shown.set, shown.found.found());
    let made =
        |method: Method| set.regions.iter().filter(|r: &&RegionPlan| r.tree.is_some() && r.method == method).count();
    let passing = (0..set.electrodes.len()).filter(|e| !set.fails(*e)).count();
    let rows = [
        ("uncut regions", found.regions),
        ("regions of whole faces: extruding method", made(Method::Extruding)),
        ("regions with parts of faces: cutting method", made(Method::Cutting)),
        ("electrodes", set.electrodes.len()),
        ("electrodes that pass every check", passing),
        ("regions without an electrode", set.without_electrode().len()),
    ];
    Outcome {
        why: "The paper's mold is not public, and it gives no figures for it. It looks for uncut areas that were forgotten; here \
              each electrode is checked, and what a check finds is told."
            .to_owned(),
        tables: vec![Table::new(
            "The demonstration mold",
            &["", "#"],
            rows.iter().map(|(what, count)| vec![(*what).to_owned(), count.to_string()]).collect(),
        )],
        pictures: shown.pictures(&["Uncut regions", "The electrodes, retracted"]),
        ..of("Figure 29", "Case study: mold, section curves, electrodes, holders")
    }
}

fn times(shown: &Shown) -> Outcome {
    let seconds = |step: &str| shown.times.iter().filter(|s| s.step == step).fold(0.0, |sum, s| sum + s.seconds);
    let row = |step: &str, by_hand: f64, theirs: f64, seconds: f64| {
        let saved = 100.0 * (1.0 - theirs / by_hand);
        let figures = [(by_hand, 0), (theirs, 0), (saved, 1), (seconds / 60.0, 3), (seconds, 2)];
        std::iter::once(step.to_owned()).chain(figures.map(|(figure, places)| number(figure, places))).collect()
    };
    let mut rows: Vec<_> = PAPER.iter().map(|(step, a, b)| row(step, *a, *b, seconds(step))).collect();
    let sum = PAPER.iter().fold([0.0; 3], |[a, b, c], (step, x, y)| [a + x, b + y, c + seconds(step)]);
    rows.push(row("Total", sum[0], sum[1], sum[2]));
    Outcome {
        verdict: Verdict::NotComparable,
        why: "The paper's mold and computer are not public, and the number of its electrodes is not given. Its times are of \
              two engineers at work, 4 of the 13 minutes with the system by hand; ours are of the computation alone, \
              without reading the results. The step that its system leaves to the engineer, the refinement, is computed \
              here."
            .to_owned(),
        tables: vec![Table::new(
            &format!("Time of each step; ours with {} electrodes", shown.set.electrodes.len()),
            &["step", "#engineer with NX 10, min", "#paper's system, min", "#saved by it, %", "#ours, min", "#ours, s"],
            rows,
        )],
        ..of(NAME, "Time of each step")
    }
}
