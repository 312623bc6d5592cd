//! The comparison as one page without scripts: the runs as a table, then each axis of all runs in one plot.

use std::fmt::Write;

use super::comparison::{Comparison, Run, RunElectrode};
use crate::workspaces::blisk::report::html::{STYLE, file_name};
use crate::workspaces::blisk::report::tables::{number, parameters, row, small, table};
use feed::pose::Axis;
use feed::strategy::Strategy;
use files::svg_plot::{Plot, Series, escape};

/// What is not there.
const NONE: &str = "\u{2013}";

/// The whole page.
pub(super) fn page(comparison: &Comparison) -> String {
    let part = escape(comparison.inputs.first().map_or("", |input| file_name(&input.path)));
    let mut out = format!(
        "<!doctype html><html lang=\"en\"><head><meta charset=\"utf-8\">\
         <meta name=\"viewport\" content=\"width=device-width,initial-scale=1\">\
         <meta name=\"color-scheme\" content=\"light dark\"><title>Comparison of strategies: {part}</title>\
         <style>{STYLE}</style></head><body><main>"
    );
    let certified: Vec<&str> = comparison.runs.iter().filter(|r| r.is_certified()).map(|r| r.strategy.name()).collect();
    let (class, sentence) = match certified.as_slice() {
        [] => ("no", "No strategy has a certified path.".to_owned()),
        names => ("ok", format!("Certified: {}.", names.join(", "))),
    };
    let _ = write!(
        out,
        "<header><h1>Comparison of strategies <span>{part}</span></h1><p class=\"verdict {class}\">{sentence}</p></header>"
    );
    failures(&mut out, &comparison.runs);
    let electrodes = comparison.runs.iter().map(|r| r.electrodes.len()).max().unwrap_or(0);
    (0..electrodes).for_each(|i| electrode(&mut out, comparison, i));
    out.push_str("<section><h2>Parameters of every run</h2>");
    parameters(&mut out, &comparison.parameters);
    let version = escape(comparison.program_version);
    let schema = comparison.schema;
    let _ = writeln!(
        out,
        "</section><footer>Sparkpath {version}, comparison schema {schema}</footer></main></body></html>"
    );
    out
}

/// The strategies that could not be followed.
fn failures(out: &mut String, runs: &[Run]) {
    for run in runs {
        if let Some(why) = &run.failure {
            let name = run.strategy.name();
            let _ = write!(out, "<p class=\"banner no\"><b>{name}</b> cannot be followed here: {}</p>", escape(why));
        }
    }
}

type Found<'a> = (Strategy, &'a RunElectrode);

fn electrode(out: &mut String, comparison: &Comparison, i: usize) {
    let found: Vec<Found> = comparison.runs.iter().filter_map(|r| Some((r.strategy, r.electrodes.get(i)?))).collect();
    let share = found.first().map_or("", |(_, e)| &*e.share);
    let share = if share.is_empty() { String::new() } else { format!(" <span>{}</span>", escape(share)) };
    let _ = write!(out, "<section><h2>Electrode {}{share}</h2>", i + 1);
    if found.windows(2).any(|w| w[0].1.enters_from != w[1].1.enters_from) {
        out.push_str(
            "<p class=\"soft\">Not all enter from the same side, so that these are not all paths of the same electrode: \
             give [electrode] enter to compare on one side.</p>",
        );
    }
    outcomes(out, &found);
    smoothness(out, &found, comparison.step_mm);
    plots(out, &found);
    out.push_str("</section>");
}

fn outcomes(out: &mut String, found: &[Found]) {
    let rows = found.iter().map(|(strategy, e)| {
        let each = e.objective_sums.total / (e.nodes.max(2) - 1) as f64;
        vec![
            swatch(*strategy),
            e.enters_from.to_uppercase().replace('-', "\u{2212}"),
            if e.certified { "certified".to_owned() } else { escape(&e.verdict) },
            e.certified_clearance_mm.map_or(NONE.to_owned(), |c| number(c, 4)),
            e.nodes.to_string(),
            if e.rows > 0 { e.rows.to_string() } else { NONE.to_owned() },
            number(e.search_seconds, 2),
            number(e.certificate_seconds, 2),
            small(e.objective_sums.smoothness),
            small(e.objective_sums.centring),
            small(e.objective_sums.total),
            small(each),
        ]
    });
    let head = [
        "strategy",
        "from",
        "outcome",
        "#certified mm",
        "#nodes",
        "#rows",
        "#search s",
        "#certificate s",
        "#sum Obj1",
        "#sum Obj2",
        "#sum objective",
        "#per step",
    ];
    table(out, "", "Outcomes", &head, rows);
}

/// One row an axis and strategy, so that strategies stand below each other. X moves evenly with the distance withdrawn.
fn smoothness(out: &mut String, found: &[Found], step: f64) {
    let mut rows = Vec::new();
    for axis in &Axis::ALL[1..] {
        for (strategy, e) in found {
            let Some(a) = e.smoothness.iter().find(|a| a.axis == axis.letter()) else { continue };
            rows.push(vec![
                format!("{} <small>{}</small>", a.axis, a.unit),
                swatch(*strategy),
                small(a.total_variation),
                small(a.rms_second_difference),
                small(a.max_second_difference),
                a.sign_changes_first_difference.to_string(),
            ]);
        }
    }
    let caption = format!("Smoothness over equal steps of {} mm", number(step, 2));
    let head = ["axis", "strategy", "#total variation", "#RMS 2nd difference", "#greatest", "#turns back"];
    if rows.is_empty() {
        table(out, "", &caption, &[], [row("No strategy has a path.", "")]);
    } else {
        table(out, "", &caption, &head, rows);
    }
}

/// An overlay of all runs for each axis but X, which is the abscissa itself.
fn plots(out: &mut String, found: &[Found]) {
    out.push_str(
        "<h3>Axes against retract distance <small>dots are search nodes; where there is no path they end at the jam; \
         feed runs from right to left</small></h3><p class=\"legend\">",
    );
    found.iter().for_each(|(strategy, _)| {
        let _ = write!(out, "<span>{}</span>", swatch(*strategy));
    });
    out.push_str("</p>");
    for axis in &Axis::ALL[1..] {
        let courses: Vec<_> = found.iter().filter_map(|(s, e)| Some((*s, e.course(axis.letter())?))).collect();
        if courses.is_empty() {
            continue;
        }
        let series = |(strategy, course): &(Strategy, &super::comparison::AxisCourse)| {
            let class = class(*strategy);
            [(&course.curve, false), (&course.nodes, true)].map(|(p, dots)| Series { points: p.clone(), class, dots })
        };
        let plot = Plot {
            title: format!("{}, {}", axis.letter(), if axis.is_rotary() { "\u{b0}" } else { "mm" }),
            x_label: "s, mm retracted".to_owned(),
            size: [1100.0, 260.0],
            series: courses.iter().flat_map(series).collect(),
            ..Plot::default()
        };
        let _ = write!(out, "<div class=\"plot\">{}</div>", plot.svg());
    }
}

/// The colour of a strategy, the same on every page.
fn class(strategy: Strategy) -> &'static str {
    ["c0", "c1", "c2", "c3", "c4"][strategy as usize]
}

fn swatch(strategy: Strategy) -> String {
    let colour = class(strategy);
    let name = strategy.name().replace('-', "\u{2011}");
    format!("<i class=\"swatch\" style=\"background:var(--{colour})\"></i>{name}")
}
