//! The page of a comparison: what its template needs beside the comparison's figures, which is colours and plots.

use serde::Serialize;

use super::{AxisCourse, Comparison, RunElectrode};
use feed::plan_params::Strategy;
use feed::pose::Axis;
use files::Entry;
use files::report::plot::{Plot, Series};
use files::report::{PageError, Template, file_name};

/// The page of `comparison`.
pub(super) fn page(comparison: &Comparison) -> Result<String, PageError> {
    const TEMPLATE: Template = Template { name: "comparison.html.jinja", text: include_str!("comparison.html.jinja") };
    #[derive(Serialize)]
    struct Page<'a> {
        comparison: &'a Comparison,
        parameters: &'a [Entry],
        part: &'a str,
        certified: Vec<Strategy>,
        electrodes: Vec<ElectrodeRuns<'a>>,
    }
    let electrodes = comparison.runs.iter().map(|r| r.electrodes.len()).max().unwrap_or(0);
    let page = Page {
        comparison,
        parameters: &comparison.parameters.entries,
        part: comparison.inputs.first().map_or("", |input| file_name(&input.path)),
        certified: comparison.runs.iter().filter(|r| r.is_certified()).map(|r| r.strategy).collect(),
        electrodes: (0..electrodes).map(|i| ElectrodeRuns::of(comparison, i)).collect(),
    };
    files::report::page(&TEMPLATE, &page)
}

/// What all strategies found for one electrode.
#[derive(Serialize)]
struct ElectrodeRuns<'a> {
    share: &'a str,
    /// Whether not all enter from the same side.
    has_two_sides: bool,
    found: Vec<Found<'a>>,
    /// The letter of each axis but that of withdrawal, which is the abscissa itself, and an overlay of all runs where one
    /// moves it.
    axes: Vec<(char, Option<String>)>,
}

#[derive(Serialize)]
struct Found<'a> {
    strategy: Strategy,
    colour: &'static str,
    electrode: &'a RunElectrode,
}

impl<'a> ElectrodeRuns<'a> {
    fn of(comparison: &'a Comparison, i: usize) -> Self {
        let found = comparison.runs.iter().filter_map(|run| {
            Some(Found { strategy: run.strategy, colour: colour(run.strategy), electrode: run.electrodes.get(i)? })
        });
        let found: Vec<_> = found.collect();
        Self {
            share: found.first().map_or("", |f| &*f.electrode.share),
            has_two_sides: found.windows(2).any(|w| w[0].electrode.enters_from != w[1].electrode.enters_from),
            axes: Axis::ALL
                .into_iter()
                .filter(|axis| found.iter().any(|f| f.electrode.withdrawn != *axis))
                .map(|axis| (axis.letter(), plot(axis, &found)))
                .collect(),
            found,
        }
    }
}

fn plot(axis: Axis, found: &[Found]) -> Option<String> {
    let courses = found.iter().filter_map(|f| Some((f.colour, f.electrode.course(axis.letter())?)));
    let of_run = |(class, course): (&'static str, &AxisCourse)| {
        [(&course.curve, false), (&course.nodes, true)].map(|(p, dots)| Series { points: p.clone(), class, dots })
    };
    let plot = Plot {
        title: format!("{}, {}", axis.letter(), if axis.is_rotary() { "\u{b0}" } else { "mm" }),
        x_label: "s, mm retracted".to_owned(),
        size: [1100.0, 260.0],
        series: courses.flat_map(of_run).collect(),
        ..Plot::default()
    };
    (!plot.series.is_empty()).then(|| plot.svg())
}

/// The colour of a strategy, the same on every page.
fn colour(strategy: Strategy) -> &'static str {
    ["c0", "c1", "c2", "c3", "c4"][strategy as usize]
}
