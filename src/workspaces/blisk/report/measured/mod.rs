//! The page of a scanned part: verdict, fit, deviations by surface and by channel as in P1's figure 10b, and the worst places.

use std::collections::BTreeMap;

use serde::Serialize;

use crate::workspaces::blisk::job::scan::ScannedPart;
use files::report::plot::{Plot, Series};
use files::report::{PageError, Picture, Template, number};
use measured::deviation::Statistics;

/// Bins of the histogram from the least to the greatest deviation that is allowed.
const BINS: i64 = 20;
/// Bins on either side of these at most.
const BEYOND: i64 = 30;
/// Size of the plots (CSS pixels).
const PLOT: [f64; 2] = [1100.0, 260.0];

/// Files and pictures of a page.
#[derive(Debug, Clone, Copy)]
pub struct ScanPage<'a> {
    /// Name of the file of the nominal part.
    pub nominal: &'a str,
    /// Name of the file of the scan.
    pub scan: &'a str,
    /// Pictures of the deviations.
    pub pictures: &'a [Picture],
}

/// Deviations of one surface or channel as a row of a table.
#[derive(Serialize)]
struct Row {
    name: String,
    points: usize,
    least_mm: f64,
    mean_mm: f64,
    greatest_mm: f64,
    rms_mm: f64,
    within_percent: f64,
}

impl Row {
    fn of(name: impl ToString, of: &Statistics) -> Self {
        Self {
            name: name.to_string(),
            points: of.points,
            least_mm: of.least_mm,
            mean_mm: of.mean_mm,
            greatest_mm: of.greatest_mm,
            rms_mm: of.rms_mm,
            within_percent: 100.0 * of.share_within,
        }
    }
}

#[derive(Serialize)]
struct WorstRow<'a> {
    deviation_mm: f64,
    surface: &'a str,
    at_mm: [f64; 3],
}

/// The page of a scanned `part`.
///
/// # Errors
/// [`PageError`].
pub fn page(part: &ScannedPart, of: &ScanPage) -> Result<String, PageError> {
    const TEMPLATE: Template = Template { name: "measured.html.jinja", text: include_str!("measured.html.jinja") };
    #[derive(Serialize)]
    struct Page<'a> {
        program_version: &'static str,
        nominal: &'a str,
        scan: &'a str,
        is_within: bool,
        verdict: String,
        tolerance_mm: [f64; 2],
        least_percent: f64,
        fit: Vec<String>,
        all: Row,
        surfaces: Vec<Row>,
        channels: Vec<Row>,
        worst: Vec<WorstRow<'a>>,
        by_channel: Option<String>,
        histogram: String,
        is_cut_off: bool,
        pictures: &'a [Picture],
    }
    let tolerance = &part.verdict.tolerance;
    let histogram = Histogram::of(part.map.list().iter().map(|of| of.distance), tolerance.range_mm());
    let worst = part.worst.iter().map(|worst| WorstRow {
        deviation_mm: worst.deviation.distance,
        surface: &worst.surface,
        at_mm: worst.deviation.point.to_array(),
    });
    let page = Page {
        program_version: env!("CARGO_PKG_VERSION"),
        nominal: of.nominal,
        scan: of.scan,
        is_within: part.verdict.is_within,
        verdict: format!("The part is {}.", part.verdict),
        tolerance_mm: tolerance.range_mm(),
        least_percent: 100.0 * tolerance.least_share(),
        fit: part.fit_sentences(),
        all: Row::of("all", &part.all),
        surfaces: part.by_surface.iter().map(|(name, of)| Row::of(name, of)).collect(),
        channels: part.by_channel.iter().map(|(number, of)| Row::of(number, of)).collect(),
        worst: worst.collect(),
        by_channel: (!part.by_channel.is_empty()).then(|| by_channel(&part.by_channel, tolerance.range_mm())),
        histogram: histogram.plot(tolerance.range_mm()).svg(),
        is_cut_off: histogram.is_cut_off,
        pictures: of.pictures,
    };
    files::report::page(&TEMPLATE, &page)
}

/// Least, mean and greatest deviation over the number of the channel.
fn by_channel(channels: &BTreeMap<usize, Statistics>, [below, above]: [f64; 2]) -> String {
    let curve = |class: &'static str, value: fn(&Statistics) -> f64| {
        let points: Vec<[f64; 2]> = channels.iter().map(|(number, of)| [*number as f64, value(of)]).collect();
        [false, true].map(|dots| Series { points: points.clone(), class, dots })
    };
    let plot = Plot {
        title: "Deviation of each channel, mm".to_owned(),
        x_label: "channel".to_owned(),
        size: PLOT,
        series: [curve("c2", |of| of.least_mm), curve("c0", |of| of.mean_mm), curve("c1", |of| of.greatest_mm)]
            .concat(),
        levels: [below, above].map(|limit| (limit, format!("tolerance {}", number(limit, 4)))).into(),
        ..Plot::default()
    };
    plot.svg()
}

/// How many of the points deviate by how much.
#[derive(Debug, Clone, PartialEq)]
struct Histogram {
    /// Outline of the bins: deviation (mm), and share of the points (%).
    outline: Vec<[f64; 2]>,
    /// Whether the outermost bins count what lies farther out as well.
    is_cut_off: bool,
}

impl Histogram {
    /// The histogram of `deviations` (mm), whose bins divide the tolerance from `below` to `above` (mm) evenly.
    fn of(deviations: impl Iterator<Item = f64>, [below, above]: [f64; 2]) -> Self {
        let width = (above - below) / BINS as f64;
        let (mut counts, mut all, mut is_cut_off) = (BTreeMap::<i64, usize>::new(), 0, false);
        for deviation in deviations {
            let bin = ((deviation - below) / width).floor() as i64;
            // The limit itself is within the tolerance.
            let bin = if deviation == above { BINS - 1 } else { bin };
            let shown = bin.clamp(-BEYOND, BINS + BEYOND - 1);
            is_cut_off |= shown != bin;
            *counts.entry(shown).or_default() += 1;
            all += 1;
        }
        let Some((first, last)) = counts.keys().next().copied().zip(counts.keys().next_back().copied()) else {
            return Self { outline: Vec::new(), is_cut_off };
        };
        let edge = |bin: i64| below + bin as f64 * width;
        let share = |bin: i64| 100.0 * counts.get(&bin).copied().unwrap_or(0) as f64 / all as f64;
        let tops = (first..=last).flat_map(|bin| [[edge(bin), share(bin)], [edge(bin + 1), share(bin)]]);
        let outline = std::iter::once([edge(first), 0.0]).chain(tops).chain([[edge(last + 1), 0.0]]).collect();
        Self { outline, is_cut_off }
    }

    fn plot(&self, tolerance: [f64; 2]) -> Plot {
        let most = self.outline.iter().fold(0.0, |most: f64, [_, share]| most.max(*share));
        let limit = |at: f64| Series { points: vec![[at, 0.0], [at, most]], class: "lim", dots: false };
        let outline = Series { points: self.outline.clone(), class: "c0", dots: false };
        Plot {
            title: "Share of the points, %".to_owned(),
            x_label: "deviation, mm".to_owned(),
            size: PLOT,
            series: tolerance.map(limit).into_iter().chain([outline]).collect(),
            ..Plot::default()
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::workspaces::blisk::job::scan::{Judgement, Surfaces};
    use geometry::mesh::Mesh;
    use glam::DVec3;
    use measured::deviation::Tolerance;
    use task::Task;

    #[test]
    fn bins_divide_the_tolerance_and_the_outermost_take_what_lies_farther_out() {
        let found = Histogram::of([0.01, 0.05, 0.31, 0.99].into_iter(), [-1.0, 1.0]);
        let share = |of: &Histogram, at: f64| {
            let bin = of.outline.windows(2).find(|w| w[0][0] <= at && at < w[1][0]);
            bin.map(|w| w[0][1])
        };
        assert_eq!(
            [0.02, 0.12, 0.35, 0.95].map(|at| share(&found, at)),
            [Some(50.0), Some(0.0), Some(25.0), Some(25.0)]
        );
        assert!(!found.is_cut_off && share(&found, 1.05).is_none() && share(&found, -0.05).is_none());
        // The limit belongs to the tolerance; beyond four times of it nothing more is told apart.
        let found = Histogram::of([1.0, 100.0, -100.0, 0.5].into_iter(), [-1.0, 1.0]);
        assert_eq!(
            [0.95, 1.05, 3.95, -3.95].map(|at| share(&found, at)),
            [Some(25.0), Some(0.0), Some(25.0), Some(25.0)]
        );
        assert!(found.is_cut_off);
        assert!(Histogram::of(std::iter::empty(), [-1.0, 1.0]).outline.is_empty());
    }

    #[test]
    fn a_page_has_the_verdict_every_table_and_the_plots() {
        let mesh = Arc::new(Mesh::cuboid(DVec3::new(40.0, 30.0, 20.0)));
        let scan: Vec<DVec3> = [0.0, 0.01, 0.05]
            .iter()
            .enumerate()
            .map(|(i, d)| DVec3::new(10.0 + 5.0 * i as f64, 15.0, 20.0 + d))
            .collect();
        let judgement =
            Judgement { tolerance: Tolerance::symmetric(0.03).unwrap(), freedoms: None, reach_mm: f64::INFINITY };
        let mut part = ScannedPart::of(mesh, &Surfaces::default(), &scan, &judgement, &Task::default()).unwrap();
        let files = ScanPage { nominal: "<box>.stl", scan: "scan.csv", pictures: &[] };
        let of_box = page(&part, &files).unwrap();
        assert!(
            of_box.contains("outside of the tolerance of") && of_box.contains("The scan was not moved."),
            "{of_box}"
        );
        assert!(of_box.contains("&lt;box&gt;.stl") && of_box.contains("scan.csv"));
        assert!(of_box.contains("<td class=\"num\">0.0500</td>\n<td>part</td>"), "worst place: {of_box}");
        assert_eq!(of_box.matches("<svg").count(), 1, "a part that is no wheel has no channels");
        assert!(!of_box.contains("Deviation of each channel"));
        part.by_channel = (0..3).map(|number| (number, part.all)).collect();
        (part.beyond_reach, part.reach_mm) = (7, 0.5);
        let of_wheel = page(&part, &files).unwrap();
        assert_eq!(of_wheel.matches("<svg").count(), 2);
        for text in [
            "Deviation of each channel, mm",
            "tolerance 0.0300",
            "tolerance \u{2212}0.0300",
            "7 of ",
            "farther than 0.5 mm",
        ] {
            assert!(of_wheel.contains(text), "{text}: {of_wheel}");
        }
    }
}
