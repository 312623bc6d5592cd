//! The page of a report on a flank: what its template needs beside the report's figures, which is maps and plots.

use serde::Serialize;

use crate::workspaces::flank::comparison::{Quantity, Row, SERIES, points};
use crate::workspaces::flank::report::{AxisEntry, DeviationMaps, FlankReport, PathEntry};
use files::Entry;
use files::report::plot::{Plot, Series};
use files::report::{PageError, Template, number};
use flank::plan::WITHIN_ROUNDING;

/// Ranks whose sum is up to this share of the initial one are shown closely.
const CLOSE: f64 = 1.25;

/// The page of `report` with its `maps`.
pub(super) fn page(report: &FlankReport, maps: &DeviationMaps) -> Result<String, PageError> {
    const TEMPLATE: Template = Template { name: "report.html.jinja", text: include_str!("report.html.jinja") };
    #[derive(Serialize)]
    struct Page<'a> {
        report: &'a FlankReport,
        parameters: &'a [Entry],
        /// The path that is milled.
        milled: Option<&'a PathEntry>,
        /// Stands for the share of an initial sum that is nothing but rounding.
        within_rounding: &'a str,
        maps: &'a DeviationMaps,
        /// Decimals that tell half of the end of the maps' scale, in micrometres, from all of it.
        map_decimals: usize,
        rank_plots: Vec<String>,
        axis_plots: Vec<String>,
        compared_plots: Vec<String>,
    }
    let axes = report.machine.iter().flat_map(|machine| machine.axes.iter().enumerate());
    let page = Page {
        report,
        parameters: &report.parameters.entries,
        milled: report.milled(),
        within_rounding: WITHIN_ROUNDING,
        maps,
        map_decimals: (2.0 - (1e3 * maps.end_mm).max(1e-6).log10().ceil()).clamp(1.0, 6.0) as usize,
        rank_plots: rank_plots(report),
        compared_plots: Quantity::ALL.into_iter().filter_map(|of| compared_plot(of, &report.compared)).collect(),
        axis_plots: axes.map(|(i, axis)| axis_plot(axis, i).svg()).collect(),
    };
    files::report::page(&TEMPLATE, &page)
}

/// The sums over all ranks, and those near the best.
fn rank_plots(report: &FlankReport) -> Vec<String> {
    let ranks = &report.ranks;
    let Some(start) = report.paths.first().map(|p| p.standing.sum_mm) else { return Vec::new() };
    let points: Vec<[f64; 2]> =
        ranks.sums_mm.iter().enumerate().map(|(i, sum)| [(i + 1) as f64, sum.unwrap_or(f64::NAN)]).collect();
    let best = points.iter().find(|p| p[0] == ranks.best as f64).copied();
    let plot = |title: &str, log_y, size, points, mark: Option<([f64; 2], String)>| Plot {
        title: title.to_owned(),
        x_label: "rank k".to_owned(),
        log_y,
        size,
        series: vec![Series { points, class: "c0", dots: false }],
        levels: vec![(start, format!("initial {}", number(start, 3)))],
        marks: mark.into_iter().collect(),
        ..Plot::default()
    };
    let close = points.iter().map(|p| if p[1] <= CLOSE * start { *p } else { [p[0], f64::NAN] }).collect();
    let mark = best.map(|p| (p, format!("k = {}: {}", ranks.best, number(p[1], 3))));
    // The figure of the best stands in the first plot; in the second one it would lie on the axis.
    let circle = best.map(|p| (p, String::new()));
    let all = plot("Sum of deviations, mm, every rank", true, [620.0, 260.0], points, mark);
    [all, plot("Near the best", false, [360.0, 260.0], close, circle)].map(|plot| plot.svg()).to_vec()
}

/// The deviations of plans side by side over a quantity, where they differ in it.
fn compared_plot(of: Quantity, rows: &[Row]) -> Option<String> {
    let series = SERIES.map(|(_, class, figure)| Series { points: points(of, rows, figure), class, dots: false });
    let [[first, _], .., [last, _]] = series[0].points[..] else { return None };
    let title = "Deviation, µm: mean blue, greatest undercut brown, greatest overcut grey".to_owned();
    let x_label = of.label().to_owned();
    (last > first)
        .then(|| Plot { title, x_label, size: [620.0, 260.0], series: series.to_vec(), ..Plot::default() }.svg())
}

fn axis_plot(axis: &AxisEntry, i: usize) -> Plot {
    let AxisEntry { letter, unit, limits: [low, high], values } = axis;
    let limits = format!("limits {} to {}", number(*low, 0), number(*high, 0));
    Plot {
        title: format!("{letter}, {unit} ({limits})"),
        x_label: "s".to_owned(),
        least_range: 1e-3,
        size: [360.0, 190.0],
        series: vec![Series {
            points: values.clone(),
            class: ["c0", "c1", "c2", "c3", "c4", "c5"][i % 6],
            dots: false,
        }],
        ..Plot::default()
    }
}
